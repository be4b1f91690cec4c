// Starts the program that precedes this script, and asks it. Frames are made one after the other; other questions do not wait for them.
const unpacked = async (text) => {
  if (typeof text !== "string") return text;
  const bytes = Uint8Array.fromBase64?.(text) ?? Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
};

// Without promise integration the program cannot wait for a device, and uses none.
const suspends = "Suspending" in WebAssembly;
const channel = new MessageChannel();
channel.port1.onmessage = () => channel.resume();
globalThis.pause = () => suspends ? new Promise((resolve) => { channel.resume = resolve; channel.port2.postMessage(0); }) : undefined;
if (!suspends) {
  WebAssembly.Suspending = function (f) { return f; };
  WebAssembly.promising = (f) => (...given) => f(...given);
}

const damaged = (what) => { throw new Error(`the page is damaged: its ${what} cannot be read`); };

const begun = {};
async function start({ program, content, backend }) {
  const [code, scene] = await Promise.all([unpacked(program).catch(() => damaged("program")), unpacked(content).catch(() => damaged("content"))]);
  const compiled = code instanceof WebAssembly.Module ? code : await WebAssembly.compile(code);
  await wasm_bindgen({ module_or_path: compiled });
  await wasm_bindgen.start(scene, suspends ? backend : "cpu");
  begun.content = scene;
  return { code: compiled, content: scene, gpu: wasm_bindgen.is_gpu() };
}

// The adapter, as far as the browser names it.
async function adapter() {
  const found = suspends && await navigator.gpu?.requestAdapter();
  if (!found) return { none: suspends ? "the browser has no adapter for WebGPU" : "the browser lacks JavaScript promise integration" };
  const { vendor, architecture, device, description } = found.info;
  return { vendor, architecture, device, description };
}

let frames = Promise.resolve();
async function answer(answered) {
  const { status, content_type: type, info, body: bytes } = await answered;
  return { status, type, info, bytes };
}

onmessage = async ({ data: { id, route, body, ...first } }) => {
  try {
    if (first.program) return postMessage({ id, ...await start(first) });
    if (first.supersede) return wasm_bindgen.supersede(first.supersede);
    if (first.selftest) {
      return postMessage({ id, report: { browser: navigator.userAgent, ...await adapter(), ...JSON.parse(await wasm_bindgen.selftest(suspends ? first.selftest : "cpu")) } });
    }
    // For scripts: the ids, depths and certainty of a view.
    if (first.buffers) return postMessage({ id, ...await answer(wasm_bindgen.buffers(begun.content, body, first.buffers)) });
    const ticket = wasm_bindgen.take(route, body);
    const work = route === "frame" ? frames = frames.then(() => answer(wasm_bindgen.answer(ticket))) : answer(wasm_bindgen.answer(ticket));
    const reply = await work;
    postMessage({ id, ...reply }, [reply.bytes.buffer]);
  } catch (error) {
    postMessage({ id, error: error?.message ?? String(error) });
  }
};
