import { mount } from "./view.js";

// The files of the modes; while a camera moves they are JPEG.
const TYPES = { still: "image/png", svg: "image/svg+xml", pdf: "application/pdf" };

// The page in a notebook: requests are messages {id, route, body} of the comm, answers {id, status, json or info} with the
// picture as the first buffer.
function commTransport(model) {
  const waiting = new Map();
  let last = Math.floor(Math.random() * 2 ** 48);   // other views hear the answers
  const receive = (content, buffers) => {
    const { id, status, json = null, info = {} } = content, [resolve, type] = waiting.get(id) ?? [];
    waiting.delete(id);
    resolve?.(buffers?.length ? { status, info, blob: new Blob([buffers[0]], { type }) } : { status, json });
  };
  model.on("msg:custom", receive);
  return {
    request: (route, body) => new Promise((resolve) => {
      waiting.set(++last, [resolve, TYPES[body.mode] ?? "image/jpeg"]);
      model.send({ id: last, route, body });
    }),
    close: () => model.off("msg:custom", receive),
  };
}

export default {
  render({ model, el }) {
    const root = document.createElement("div");
    root.className = "halfline-view";
    // The notebook's keys and menus stay outside.
    for (const name of ["data-lm-suppress-shortcuts", "data-jp-suppress-context-menu"]) root.toggleAttribute(name, true);
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
