import { mount } from "./view.js";

// A page without a server: the program answers in a worker. Requests are messages {id, route, body}, answers {id, status, type, info, bytes}.
const holds = (name) => document.getElementById(name).textContent;
const why = document.getElementById("why");
let begun = null, spheres = 1;   // what further workers begin with

function worker() {
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
  return { send, post: (message) => worker.postMessage(message) };
}

// The program in a worker, and, where no graphics card renders, in one for each further processor: they render parts of stills.
const MOST_WORKERS = 8, MOST_SPHERES = 4e6;
const PARTS = 3;    // of a still for each worker
const COARSE = 4;   // the first still is this much smaller
function program() {
  const all = [worker()];
  let saver = 0;   // the worker that renders a picture to be saved
  return {
    send: all[0].send,
    get workers() { return all.length; },
    help({ code, content, gpu }, spheres) {
      const most = Math.min(MOST_WORKERS, navigator.hardwareConcurrency || 1, MOST_SPHERES / spheres);
      if (gpu) return;
      while (all.length < most) {
        const helper = worker();
        all.push(helper);
        helper.ready = helper.send({ program: code, content, backend: "cpu" });
        helper.ready.catch(() => {});
      }
    },
    compose(request, ask, isNow, show) {
      if (all.length === 1) return ask("/frame", request);
      return composed(request, ask, isNow, show, all.length, (worker) => worker > 0 && worker === saver);
    },
    saver: (begins) => saver = begins ? all.length - 1 : 0,
    supersede(seq) {
      for (const { post } of all.slice(1)) post({ supersede: seq });
    },
    async request(route, body, number = 0) {
      await all[number].ready;
      const { status, type, info, bytes } = await all[number].send({ route: route.slice(1), body: JSON.stringify(body) });
      const [x0, y0, x1, y1] = body.window ?? [0, 0, ...body.size ?? [0, 0]];
      // Further workers do not delay the first picture.
      if (route === "/frame" && begun) begun = this.help(begun, spheres);
      if (["image/png", "image/svg+xml", "application/pdf"].includes(type)) return { status, blob: new Blob([bytes], { type }), info: JSON.parse(info) };
      if (type === "image/x-rgba") return { status, pixels: new ImageData(new Uint8ClampedArray(bytes.buffer), x1 - x0, y1 - y0), info: JSON.parse(info) };
      const json = bytes.length ? JSON.parse(new TextDecoder().decode(bytes)) : null;
      if (route === "/scene") {
        if (json.framed && !json.sized) json.camera = (await this.request("/fit", { ...json, size: body.size, frame: null })).json.camera;
        else widen(json, body.size);
        spheres = json.count * (json.frames ?? 1);
      }
      return { status, json };
    },
  };
}

// The windows of a picture that is cut into about `count` parts, those in the middle first.
function windows([width, height], count) {
  const columns = Math.max(1, Math.round(Math.sqrt((count * width) / height))), rows = Math.max(1, Math.round(count / columns));
  const cut = (side, n) => Array.from({ length: n }, (_, k) => [Math.round((k * side) / n), Math.round(((k + 1) * side) / n)]);
  const all = cut(height, rows).flatMap(([y0, y1]) => cut(width, columns).map(([x0, x1]) => [x0, y0, x1, y1]));
  const away = ([x0, y0, x1, y1]) => Math.hypot(x0 + x1 - width, y0 + y1 - height);
  return all.filter(([x0, y0, x1, y1]) => x0 < x1 && y0 < y1).sort((a, b) => away(a) - away(b));
}

// A still from coarse to fine: a small one, and then its parts, each by the next of so many workers that is free; `isOther` says which
// one does other work. `show` gets what there is so far.
async function composed(request, ask, isNow, show, workers, isOther) {
  const from = performance.now(), [width, height] = request.size, part = { ...request, mode: "part" };
  const whole = new OffscreenCanvas(width, height), ground = whole.getContext("2d");
  const all = windows(request.size, PARTS * workers), rest = [...all], infos = [];
  let warnings = [];
  const paint = (image, [x0, y0, x1, y1], mode) => {
    ground.globalCompositeOperation = mode;
    ground.drawImage(image, x0, y0, x1 - x0, y1 - y0);
    if (isNow()) show(whole, infos.length / all.length);
  };
  const get = async (body, worker) => {
    const { pixels, info } = isNow() ? await ask("/frame", body, worker) : {};
    return pixels && { image: await createImageBitmap(pixels), info };
  };
  const work = async (worker) => {
    while (rest.length && isNow() && !isOther(worker)) {
      const window = rest.shift(), found = await get({ ...part, window }, worker).catch((error) => {
        if (!worker || !isNow()) throw error;
        rest.push(window);   // the worker could not be started
      });
      if (!found) return;
      infos.push(found.info);
      paint(found.image, window, "source-over");
    }
  };
  const first = async () => {
    const small = await get({ ...part, size: request.size.map((x) => Math.ceil(x / COARSE)) }, 0);
    warnings = small?.info.warnings ?? [];
    if (small) paint(small.image, [0, 0, width, height], "destination-over");
    await work(0);
  };
  await Promise.all([first(), ...Array.from({ length: workers - 1 }, (_, k) => work(k + 1))]);
  await work(0);
  if (infos.length < all.length) return {};
  const settled = infos.reduce((sum, info) => sum + info.settled, 0), certified = Math.min(1, ...infos.map((info) => info.certified));
  return { pixels: whole, info: { ...infos[0], ms: performance.now() - from, settled, certified, warnings } };
}

// In a window that is narrower than the picture with which the page begins, the whole width of that picture is seen by a camera that is given.
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
    begun = await transport.send({ program: holds("program"), content: holds("content"), backend });
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
