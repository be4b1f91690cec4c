import { mount } from "./view.js";

// A page without a server: the program answers in a worker. Requests are messages {id, route, body}, answers {id, status, type, info, bytes}.
const holds = (name) => document.getElementById(name).textContent;
const why = document.getElementById("why");

function program() {
  const worker = new Worker(URL.createObjectURL(new Blob([holds("worker")], { type: "text/javascript" })));
  const waiting = new Map();
  let last = 0, fault = null;
  const end = (error) => {
    fault ??= error;
    for (const { reject } of waiting.values()) reject(fault);
    waiting.clear();
  };
  worker.onmessage = ({ data: { id, error, ...answer } }) => {
    if (error) return end(new Error(error));
    waiting.get(id)?.resolve(answer);
    waiting.delete(id);
  };
  worker.onerror = (event) => end(new Error(event.message || "the worker cannot be started"));
  const send = (message) => new Promise((resolve, reject) => {
    if (fault) return reject(fault);
    waiting.set(++last, { resolve, reject });
    worker.postMessage({ id: last, ...message });
  });
  return {
    send,
    async request(route, body) {
      const { status, type, info, bytes } = await send({ route: route.slice(1), body: JSON.stringify(body) });
      if (type === "image/png") return { status, blob: new Blob([bytes], { type }), info: JSON.parse(info) };
      if (type === "image/x-rgba") return { status, pixels: new ImageData(new Uint8ClampedArray(bytes.buffer), ...body.size), info: JSON.parse(info) };
      const json = bytes.length ? JSON.parse(new TextDecoder().decode(bytes)) : null;
      if (route === "/scene") widen(json, body.size);
      return { status, json };
    },
  };
}

// In a window that is narrower than the picture with which the page begins, the whole width of that picture is seen.
function widen({ camera, size, sized }, window) {
  const k = (size[0] / size[1]) / (window[0] / window[1]), half = Math.PI / 360;
  if (sized || !(k > 1)) return;
  if (camera.height) camera.height *= k;
  else if (camera.vfov) camera.vfov = Math.atan(Math.tan(camera.vfov * half) * k) / half;
}

// The picture that the page has anyway stays until the program shows one, and says why where it does not.
async function show() {
  const asked = new URLSearchParams(location.search), backend = asked.get("backend") ?? "auto";
  try {
    if (typeof WebAssembly !== "object") throw new Error("this browser has no WebAssembly");
    const transport = program();
    globalThis.halflineProgram = transport;
    await transport.send({ program: holds("program"), content: holds("content"), backend });
    if (asked.has("selftest")) return await selftest(transport, backend);
    const view = document.getElementById("view");
    view.hidden = false;
    const words = { page: true, waiting: "Starting", ended: "The program has ended: reload the page" };
    mount(view, transport, { ...words, onStill: () => document.getElementById("still")?.remove() });
  } catch (error) {
    why.textContent = `A picture only: ${error.message}`;
  }
}

// The report of the self-test, to be copied.
async function selftest(transport, backend) {
  why.textContent = "The self-test runs: half a minute";
  const { report } = await transport.send({ selftest: backend });
  why.textContent = `Self-test: ${report.wrong} of ${report.pixels} pixels are wrong on ${report.adapter}`;
  const text = document.createElement("textarea");
  Object.assign(text, { id: "report", readOnly: true, rows: 24, cols: 100, value: JSON.stringify(report, null, 1) });
  document.getElementById("still").append(text);
}

why.textContent = "Starting…";
show();
