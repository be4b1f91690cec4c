import { mount } from "./view.js";

// The page in a notebook: requests are messages {id, route, body} of the comm, answers {id, status, json or info} with the
// picture as the first buffer.
function commTransport(model) {
  const waiting = new Map();
  let last = 0;
  const receive = (content, buffers) => {
    const resolve = waiting.get(content?.id);
    if (!resolve) return;
    waiting.delete(content.id);
    const { status, json = null, info = {} } = content, bytes = buffers?.[0];
    if (!bytes) return resolve({ status, json });
    const first = bytes.buffer ? bytes.getUint8?.(0) ?? bytes[0] : new Uint8Array(bytes)[0];
    resolve({ status, info, blob: new Blob([bytes], { type: first === 0x89 ? "image/png" : "image/jpeg" }) });
  };
  model.on("msg:custom", receive);
  return {
    request: (route, body) => new Promise((resolve) => {
      waiting.set(++last, resolve);
      model.send({ id: last, route, body });
    }),
    close: () => model.off("msg:custom", receive),
  };
}

export default {
  render({ model, el }) {
    const root = document.createElement("div");
    root.className = "halfline-view";
    el.append(root);
    const transport = commTransport(model);
    const trait = (name) => model.get(name) || undefined;
    const view = mount(root, transport, {
      camera: trait("camera"),
      selection: trait("selection"),
      onChange(state) {
        for (const [name, value] of Object.entries(state)) model.set(name, value);
        model.save_changes();
      },
      onStill: () => model.send({ route: "/keep" }),
    });
    const follow = () => view.setCamera(trait("camera"));
    const choose = () => view.select(trait("selection") ?? "");
    model.on("change:camera", follow);
    model.on("change:selection", choose);
    return () => {
      model.off("change:camera", follow);
      model.off("change:selection", choose);
      transport.close();
      view.destroy();
    };
  },
};
