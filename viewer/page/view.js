import { basis, before, fit, look, minus, norm, orbit, otherLens, pan, pivot, plus, project, roundLength, sameCamera, tidy, unitPerPixel, zoom } from "./camera.js";

const REST_MS = 150;        // still for so long: the still picture is asked for
const TARGET_MS = 80;       // what a moving frame may take
const SMALLEST = 3;         // a moving frame has at least 1/2^3 of the width
const IN_FLIGHT = 2;
const MOST_PIXELS = 4096;   // of a side
const PLAY_MS = 40;
const CLICK_PX = 3, TAP_PX = 8, DOUBLE_MS = 400;

const make = (tag, props = {}, ...children) => {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(props)) {
    if (key.includes("-") || key === "role") element.setAttribute(key, value);
    else element[key] = value;
  }
  element.append(...children);
  return element;
};
const count = (n) => n.toLocaleString("en-US");
const plural = (n, word) => `${count(n)} ${word}${n === 1 ? "" : "s"}`;
const shown = (value) => Array.isArray(value) ? value.map(shown).join(", ") : String(value ?? "");

// How much smaller than the canvas moving frames are: halves and doubles from the times of the frames.
function pace() {
  let level = 0, delay = Infinity, recent = [];
  return {
    get level() { return level; },
    // `time` from request to picture with `flying` requests under way, `ms` of it in the server.
    add(at, time, flying, ms) {
      delay = Math.max(0, Math.min(delay * 1.02 + 0.1, time - flying * ms));
      if (at !== level) return;
      recent = [...recent.slice(-1), time / flying];
      if (recent.length < 2) return;
      // A long way to the server is no reason for a small picture: only what exceeds it counts.
      const way = delay / flying, budget = Math.max(TARGET_MS, way + 30), slow = Math.min(...recent), quick = Math.max(...recent);
      let next = level;
      if (slow > 1.3 * budget) next = Math.min(SMALLEST, level + (slow > 5 * budget ? 2 : 1));
      else if (way + 4.4 * Math.max(0, quick - way) < budget) next = Math.max(0, level - 1);
      if (next !== level) [level, recent] = [next, []];
    },
  };
}

// Builds the view in `root`. `transport` has request(route, body) -> Promise of {status, json, blob, info}; `options` has page
// (the keys of the whole document are the view's), camera, selection, onChange and onStill.
export function mount(root, transport, options = {}) {
  const ended = new AbortController();
  const listen = (target, names, f, more = {}) => {
    for (const name of names.split(" ")) target.addEventListener(name, f, { signal: ended.signal, ...more });
  };

  // The state.
  let scene = null, camera = null, home = null, axis = null, vfov = 40;
  let selection = options.selection || "", frame = null, last = null, picked = [], styleName = null;
  let version = 0, failed = -1, rest = true, restTimer = 0, wasLost = false, playing = 0;
  let seq = Date.now();      // increases over reloads of the page too
  let flying = [], drawn = { seq: 0, version: -1 }, still = null, waiters = [], warnings = [];
  const speed = pace(), stats = { frames: 0, sizes: [], flying: 0 };

  // The document.
  const button = (text, title, run, name = "") => make("button", { type: "button", textContent: text, title, className: name, "aria-label": title, onclick: run });
  const canvas = make("canvas", { tabIndex: 0, role: "img", "aria-label": "The rendered scene. Press ? for the keys." });
  const title = make("span", { className: "hl-title" });
  const input = make("input", { type: "text", placeholder: "Select  ( / )", spellcheck: false, autocomplete: "off", autocapitalize: "off", "aria-label": "Selection" });
  const chosen = make("output", { className: "hl-count" });
  const refused = make("div", { className: "hl-refused", role: "alert", hidden: true });
  const choose = make("form", { className: "hl-select", hidden: true, onsubmit: (e) => { e.preventDefault(); select(input.value); } }, input, chosen, refused);
  const looks = make("select", { title: "Look of the still picture", "aria-label": "Look of the still picture", hidden: true, onchange: () => { styleName = looks.value; changed(); } });
  const bar = make("div", { className: "hl-bar" }, title, choose, make("span", { className: "hl-buttons" }, looks,
    button("Fit", "Fit the scene (f)", () => actions.f[1]()),
    button("Command", "Copy the command of this picture (c)", () => copy("shell")),
    button("Python", "Copy the Python of this picture (p)", () => copy("python")),
    button("Save", "Save this picture as PNG (s)", save),
    button("?", "Hands and keys (?)", toggleHelp)));
  const message = make("button", { type: "button", className: "hl-message", hidden: true });
  const note = make("div", { className: "hl-note", role: "status", hidden: true });
  const rule = make("div", { className: "hl-rule" }), ruleText = make("span");
  const scale = make("div", { className: "hl-scale hl-plate", hidden: true, title: "Scene units at the distance of the pivot" }, ruleText, rule);
  const legend = make("img", { className: "hl-legend hl-plate", alt: "Legend", hidden: true, draggable: false });
  const rings = [0, 1].map(() => make("div", { className: "hl-ring", hidden: true }));
  const table = make("div", { className: "hl-table hl-panel", role: "region", "aria-label": "Picked spheres", hidden: true });
  const help = make("div", { className: "hl-help hl-panel", role: "dialog", "aria-label": "Hands and keys", hidden: true });
  const text = make("div", { className: "hl-text hl-panel", role: "dialog", hidden: true });
  const stage = make("div", { className: "hl-stage" }, canvas, ...rings, legend, scale, table, note, message, help, text);
  const status = make("span", { className: "hl-status" });
  const warned = make("details", { className: "hl-warnings", hidden: true });
  const number = make("output"), slider = make("input", { type: "range", "aria-label": "Frame", step: 1, oninput: () => setFrame(+slider.value) });
  const play = button("Play", "Play the frames (space)", togglePlay);
  const film = make("span", { className: "hl-film", hidden: true },
    button("‹", "The frame before (left arrow)", () => step(-1)), play, button("›", "The next frame (right arrow)", () => step(1)), slider, number);
  root.replaceChildren(bar, stage, make("div", { className: "hl-foot" }, status, warned, film));
  // A notebook keeps its own keys and menus to itself here.
  root.toggleAttribute("data-lm-suppress-shortcuts", true);
  root.toggleAttribute("data-jp-suppress-context-menu", true);

  function say(what, isError = false) {
    note.textContent = what;
    note.hidden = !what;
    note.classList.toggle("hl-error", isError);
    clearTimeout(say.timer);
    if (what && !isError) say.timer = setTimeout(() => say(""), 4000);
  }
  function tell(what, retry) {
    message.textContent = what;
    message.hidden = !what;
    message.disabled = !retry;
    message.onclick = retry ?? null;
  }

  // Requests.
  async function ask(route, body) {
    let answer;
    try {
      answer = await transport.request(route, body);
    } catch (error) {
      if (!ended.signal.aborted && !wasLost) {
        wasLost = true;
        stop();
        tell("The server has ended", start);
      }
      throw error;
    }
    if (answer.status < 400) return answer;
    throw Object.assign(new Error(answer.json?.error?.message ?? `The server answered ${answer.status}`), { status: answer.status });
  }
  const complain = (error) => { if (!wasLost) say(error.message, true); };

  async function start() {
    wasLost = false;
    tell("Waiting for the server");
    try {
      for (;;) {
        const { state, text: what } = (await ask("/progress", {})).json;
        if (ended.signal.aborted) return;
        if (state === "ready") break;
        tell(what || "Reading the file");
        await new Promise((resolve) => setTimeout(resolve, 100));
      }
      const answer = (await ask("/scene", {})).json;
      if (!scene) begin(answer);
    } catch (error) {
      if (!wasLost) tell(error.message, start);
      return;
    }
    tell("");
    rest = true;
    version += 1;
    pump();
    if (selection && !chosen.value) select(selection);
  }

  function begin(answer) {
    scene = answer;
    frame = scene.frame ?? 1;
    last = scene.frames == null ? null : firstFrame() + scene.frames - 1;
    home = scene.camera.up;
    title.replaceChildren(scene.file ?? "", make("small", { textContent: plural(scene.count, "sphere") }));
    title.title = [scene.file, scene.format, scene.version && `halfline ${scene.version}`].filter(Boolean).join(", ");
    if (options.page) document.title = `${scene.file ?? "scene"} - halfline view`;
    if (/^#[0-9a-f]{6}$/i.test(scene.background)) stage.style.background = scene.background;
    choose.hidden = scene.selects === false;
    input.title = `Columns: ${Object.keys(scene.columns ?? {}).join(", ")}`;
    looks.append(...(scene.looks ?? []).map((name) => make("option", { value: name, textContent: name, selected: name === scene.look })));
    looks.hidden = looks.length < 2;
    film.hidden = scene.frames === 1;
    slider.min = firstFrame();
    showFrame();
    showLegend(scene.legend);
    warn(scene.warnings);
    setCamera(options.camera?.eye ? options.camera : scene.camera);
  }

  // The camera. One that is given is used as it is; one that was moved gets short numbers.
  function setCamera(next) {
    if (!next?.eye || (camera && sameCamera(camera, next))) return;
    vfov = next.vfov ?? vfov;
    if (axis || !camera) axis = next.up;
    camera = next;
    changed();
  }
  function move(next) {
    const { center, radius } = scene;
    const far = norm(minus(next.at, next.eye)), size = next.height ?? far, r = radius || 1;
    if (!(size > Math.max(1e-9 * r, 1e-12 * norm(next.at)) && size < 1e5 * r + 10 * norm(minus(center, next.at)))) return;
    camera = tidy(before(next, center, r));
    changed();
  }
  const box = () => [stage.clientWidth || 1, stage.clientHeight || 1];
  function fullSize() {
    const [w, h] = box().map((x) => x * devicePixelRatio), k = Math.min(1, MOST_PIXELS / w, MOST_PIXELS / h);
    return [w, h].map((x) => Math.max(1, Math.round(x * k)));
  }
  const notify = (state) => options.onChange?.(state);

  // Frames: while something changes, small and quick ones; at rest a whole one and then the still.
  function changed() {
    version += 1;
    rest = false;
    clearTimeout(restTimer);
    restTimer = setTimeout(() => {
      if (playing) return;
      rest = true;
      notify({ camera });
      pump();
    }, REST_MS);
    pump();
  }
  const body = (mode, size) => ({
    seq, camera, size, ...(scene.frames === 1 ? {} : { frame }), select: selection || null, look: styleName,
    samples: mode === "move" ? 1 : null, mode,
  });

  function pump() {
    if (!scene || wasLost || failed === version || !stage.clientWidth || !stage.clientHeight) return;
    if (flying.length >= IN_FLIGHT) return;
    const of = flying.filter((f) => f.version === version);
    if (!rest) {
      if (!of.length && drawn.version !== version) send("move", speed.level);
    } else if (!of.some((f) => f.level === 0) && !isStill()) {
      send(drawn.version === version && drawn.level === 0 ? "still" : "move", 0);
    }
  }
  const isStill = () => drawn.version === version && drawn.mode === "still";

  async function send(mode, level) {
    const full = fullSize(), size = full.map((x) => Math.max(1, Math.round(x / 2 ** level)));
    seq += 1;
    const sent = { seq, version, mode, level, camera, frame, size };
    const from = performance.now(), request = body(mode, size);
    flying.push(sent);
    stats.flying = Math.max(stats.flying, flying.length);
    const together = flying.length;
    let pause = 0;
    try {
      const { status: code, blob, info } = await ask("/frame", request);
      if (code !== 204) {
        const bitmap = await createImageBitmap(blob);
        draw(sent, bitmap, info ?? {}, blob);
        if (mode === "move") speed.add(level, performance.now() - from, together, info?.ms ?? 0);
      } else if (sent.version === version) pause = 250;   // another window has the server
    } catch (error) {
      if (error.status === 503) pause = 500;
      else if (sent.version === version || error.status !== 400) frameFailed(sent, error);
    }
    flying = flying.filter((f) => f !== sent);
    if (ended.signal.aborted) return;
    if (pause) setTimeout(pump, pause);
    else pump();
  }
  function frameFailed(sent, error) {
    failed = sent.version;
    stop();
    complain(error);
    // The end of a film whose length is not known.
    if (scene.frames == null && drawn.frame != null && sent.frame > drawn.frame) {
      last = frame = drawn.frame;
      showFrame();
      changed();
    }
  }

  function draw(sent, bitmap, info, blob) {
    if (sent.seq < drawn.seq || ended.signal.aborted) return bitmap.close();
    [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
    canvas.getContext("2d").drawImage(bitmap, 0, 0);
    drawn = { ...sent, info, pixels: [bitmap.width, bitmap.height] };
    bitmap.close();
    stats.frames += 1;
    stats.sizes = [...stats.sizes.slice(-999), drawn.pixels];
    if (sent.mode === "still") still = blob;
    if (note.classList.contains("hl-error")) say("");
    showStatus();
    showScale();
    showRings();
    warn(info.warnings);
    if (!isStill()) return;
    for (const resolve of waiters.splice(0)) resolve(still);
    options.onStill?.();
  }

  // What is on the screen beside the picture.
  function showStatus() {
    const { certified, settled, ms, adapter } = drawn.info, parts = [];
    if (certified != null) parts.push(certified >= 1 ? "certified" : `${(Math.floor(certified * 1e4) / 100).toFixed(2)} % certified`);
    if (settled != null) parts.push(`${count(settled)} settled`);
    if (ms != null) parts.push(`${Math.round(ms)} ms`);
    parts.push(drawn.pixels.join(" x "));
    if (adapter) parts.push(adapter);
    status.textContent = parts.join(", ");
    status.title = status.textContent;
  }
  function showScale() {
    const pixel = (drawn.info.unit * drawn.pixels[0]) / box()[0];
    scale.hidden = !(pixel > 0 && Number.isFinite(pixel));
    if (scale.hidden) return;
    const length = roundLength(140 * pixel);
    rule.style.width = `${length / pixel}px`;
    ruleText.textContent = length >= 1e6 || length < 1e-4 ? length.toExponential() : count2(length);
  }
  const count2 = (x) => x >= 1 ? count(x) : String(x);
  function showRings() {
    rings.forEach((ring, i) => {
      const at = picked[i] && drawn.camera && project(drawn.camera, box(), picked[i].position);
      ring.hidden = !at;
      if (at) ring.style.transform = `translate(${at[0]}px, ${at[1]}px)`;
    });
  }
  function showLegend(svg) {
    URL.revokeObjectURL(legend.src);
    legend.hidden = !svg;
    if (svg) legend.src = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  }
  function warn(list) {
    const fresh = (list ?? []).filter((w) => !warnings.includes(w));
    if (!fresh.length) return;
    warnings.push(...fresh);
    warned.hidden = false;
    warned.replaceChildren(make("summary", { textContent: plural(warnings.length, "warning") }),
      make("ul", { className: "hl-panel" }, ...warnings.map((w) => make("li", { textContent: w }))));
  }
  function showPicked() {
    table.hidden = !picked.length;
    if (!picked.length) return table.replaceChildren();
    const rows = [["id", "id"], ["row", "row"], ["center", "centre"], ["radius", "radius"], ["position", "position"], ["distance", "distance"], ["certainty", "certainty"]]
      .map(([key, name]) => [name, picked.map((p) => p[key])]);
    const names = [...new Set(picked.flatMap((p) => Object.keys(p.columns ?? {})))];
    rows.push(...names.map((name) => [name, picked.map((p) => p.columns?.[name])]));
    const line = ([name, values]) => make("tr", {}, make("th", { scope: "row", textContent: name }), ...values.map((v) => make("td", { textContent: shown(v) })));
    const pair = picked[1]?.from, head = [make("strong", { textContent: pair ? `Distance ${pair.distance}` : `Sphere ${picked[0].id}` })];
    if (pair?.minimum_image != null) head.push(make("span", { textContent: `minimum image ${pair.minimum_image}` }));
    else if (picked.length < 2) head.push(make("small", { textContent: "Shift-click a second one for the distance" }));
    table.replaceChildren(make("header", {}, make("div", {}, ...head), button("×", "Close (Esc)", () => setPicked([]), "hl-close")),
      make("table", {}, make("tbody", {}, ...rows.map(line))));
  }
  function setPicked(next) {
    picked = next;
    showPicked();
    showRings();
    notify({ picked });
  }

  // Picking and selecting.
  let pickNumber = 0;
  async function pick([x, y], second) {
    const size = fullSize(), here = box(), mine = ++pickNumber;
    const pixel = [x, y].map((v, i) => Math.max(0, Math.min(size[i] - 1, Math.floor((v / here[i]) * size[i]))));
    const { camera: c, frame: f, select: s } = body("still", size);
    try {
      const { json } = await ask("/pick", { camera: c, size, frame: f, select: s, x: pixel[0], y: pixel[1], from: second ? picked[0]?.id ?? null : null });
      if (mine === pickNumber) setPicked(second && picked.length ? (json ? [picked[0], json] : picked) : json ? [json] : []);
      return json;
    } catch (error) {
      complain(error);
    }
  }
  async function select(expr) {
    expr = expr.trim();
    if (!scene) return void (selection = expr);
    refused.hidden = true;
    if (expr === selection && (!expr || chosen.value)) return;
    input.value = expr;
    try {
      const json = expr ? (await ask("/select", { expr, ...(scene.frames === 1 ? {} : { frame }) })).json : null;
      chosen.value = json ? `${count(json.count)} of ${count(json.of)}` : "";
      showLegend(json?.legend ?? scene.legend);
      const isNew = expr !== selection;
      selection = expr;
      if (isNew) notify({ selection });
      changed();
    } catch (error) {
      if (wasLost) return;
      refused.textContent = error.message;
      refused.hidden = false;
    }
  }

  // Frames of a file.
  const firstFrame = () => scene.frame === 0 ? 0 : 1;
  function showFrame() {
    number.value = last == null ? `frame ${frame}` : `${frame} / ${last}`;
    slider.hidden = last == null;
    if (last != null) [slider.max, slider.value] = [last, frame];
  }
  function setFrame(n) {
    if (scene.frames === 1 || n === frame || n < firstFrame() || (last != null && n > last)) return;
    frame = n;
    showFrame();
    if (picked.length) setPicked([]);
    changed();
  }
  function step(by) {
    stop();
    setFrame(frame + by);
  }
  function togglePlay() {
    if (playing) return stop();
    if (scene.frames === 1) return;
    playing = setInterval(() => {
      if (flying.length >= IN_FLIGHT || flying.some((f) => f.mode === "still")) return;
      setFrame(frame === last ? firstFrame() : frame + 1);
    }, PLAY_MS);
    play.textContent = "Pause";
  }
  function stop() {
    if (!playing) return;
    clearInterval(playing);
    playing = 0;
    play.textContent = "Play";
    changed();
  }

  // Copying and saving.
  async function copy(kind) {
    try {
      const what = (await ask("/command", body("still", fullSize()))).json[kind];
      try {
        await navigator.clipboard.writeText(what);
        say(kind === "shell" ? "The command is copied" : "The Python is copied");
      } catch {
        showText(what);
      }
    } catch (error) {
      complain(error);
    }
  }
  function showText(what) {
    const area = make("textarea", { value: what, readOnly: true, rows: Math.min(12, what.split("\n").length + 3), "aria-label": "Text to copy" });
    text.replaceChildren(make("header", {}, make("span", { textContent: "The clipboard refused the text: copy it from here" }), button("×", "Close (Esc)", closeAll, "hl-close")), area);
    text.hidden = false;
    area.focus();
    area.select();
  }
  const whenStill = () => isStill() ? Promise.resolve(still) : new Promise((resolve) => waiters.push(resolve));
  async function save() {
    const href = URL.createObjectURL(await whenStill());
    const stem = (scene.file ?? "view").replace(/(.)\.[^.]*$/, "$1");
    make("a", { href, download: `${stem}${scene.frames === 1 ? "" : `-${frame}`}.png` }).click();
    setTimeout(() => URL.revokeObjectURL(href), 60000);
  }

  // Keys. The help lists them; its rows are buttons, for hands without keys.
  const along = (i) => (reverse) => {
    axis &&= home;
    move(look(camera, [0, 1, 2].map((k) => k === i ? (reverse ? -1 : 1) : 0), home));
  };
  const actions = {
    f: ["Fit the scene", () => move(fit(camera, scene.center, scene.radius, box()))],
    x: ["Look along x (Shift: against it)", along(0)],
    y: ["Look along y (Shift: against it)", along(1)],
    z: ["Look along z (Shift: against it)", along(2)],
    o: ["Orthographic or perspective", () => {
      move(otherLens(camera, vfov));
      say(camera.height ? "Orthographic" : "Perspective");
    }],
    t: ["Turn freely, or about the up direction", () => {
      axis = axis ? null : camera.up;
      say(axis ? "A drag turns about the up direction" : "A drag turns freely");
    }],
    c: ["Copy the command", () => copy("shell")],
    p: ["Copy the Python", () => copy("python")],
    s: ["Save the picture as PNG", save],
    ArrowLeft: ["The frame before", () => step(-1)],
    ArrowRight: ["The next frame", () => step(1)],
    " ": ["Play the frames, or pause", togglePlay],
    "/": ["Select by an expression", () => { if (!choose.hidden) { input.focus(); input.select(); } }],
    Escape: ["Clear selection and picks", escape],
    "?": ["Show this help", toggleHelp],
  };
  const KEY_NAMES = { ArrowLeft: "←", ArrowRight: "→", " ": "Space", Escape: "Esc" };
  const HANDS = [
    ["Drag, one finger", "Turn about the pivot"], ["Right, middle or Shift drag, two fingers", "Shift the picture"],
    ["Wheel, pinch", "Zoom toward the pointer"], ["Click, tap", "Pick a sphere"],
    ["Shift click", "Distance to a second sphere"], ["Double click", "Make the sphere the pivot"],
  ];
  function toggleHelp() {
    if (!help.hidden) return closeAll();
    closeAll();
    const row = ([key, [what, run]]) => make("button", { type: "button", onclick: () => { closeAll(); run(false); } }, make("kbd", { textContent: KEY_NAMES[key] ?? key }), what);
    const close = button("×", "Close (Esc)", closeAll, "hl-close");
    help.replaceChildren(make("header", {}, make("strong", { textContent: "Hands and keys" }), close),
      make("dl", {}, ...HANDS.flatMap(([how, what]) => [make("dt", { textContent: how }), make("dd", { textContent: what })])),
      make("div", { className: "hl-keys" }, ...Object.entries(actions).map(row)));
    help.hidden = false;
    close.focus();
  }
  function closeAll() {
    help.hidden = text.hidden = true;
    canvas.focus({ preventScroll: true });
  }
  function escape() {
    if (!help.hidden || !text.hidden) return closeAll();
    canvas.focus({ preventScroll: true });
    if (picked.length) setPicked([]);
    say("");
    select("");
    input.value = "";
  }
  listen(options.page ? document : root, "keydown", (e) => {
    if (!options.page) e.stopPropagation();
    if (!scene || e.defaultPrevented || e.ctrlKey || e.metaKey || e.altKey) return;
    const on = e.target, pressed = e.key === " " || e.key === "Enter";
    if (e.key !== "Escape") {
      if (on.matches?.("textarea, select, input:not([type=range])")) return;
      if (on.matches?.("[type=range]") && e.key.startsWith("Arrow")) return;
      if (on.matches?.("button, summary") && pressed) return;
    }
    const action = Object.hasOwn(actions, e.key) ? actions[e.key] : Object.hasOwn(actions, e.key.toLowerCase()) ? actions[e.key.toLowerCase()] : null;
    if (!action) return;
    e.preventDefault();
    action[1](e.shiftKey);
  });

  // Hands.
  const fingers = new Map();
  let gesture = null, lastClick = null;
  const place = (e) => {
    const r = stage.getBoundingClientRect(), b = box();
    return [((e.clientX - r.left) / r.width) * b[0], ((e.clientY - r.top) / r.height) * b[1]];
  };
  const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
  listen(canvas, "mousedown", (e) => e.preventDefault());   // else the middle button scrolls
  listen(canvas, "contextmenu", (e) => e.preventDefault());
  listen(canvas, "pointerdown", (e) => {
    if (!scene || wasLost) return;
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(e.pointerId);
    const at = place(e), touch = e.pointerType === "touch";
    fingers.set(e.pointerId, at);
    if (fingers.size > 1) gesture.moved = true;
    else gesture = { start: at, moved: false, left: e.button === 0, shift: e.shiftKey, reach: touch ? TAP_PX : CLICK_PX };
  });
  listen(canvas, "pointermove", (e) => {
    const was = fingers.get(e.pointerId), at = place(e);
    if (!was || (!gesture.moved && apart(at, gesture.start) <= gesture.reach)) return;
    gesture.moved = true;
    if (fingers.size > 2) return;
    const [dx, dy] = [at[0] - was[0], at[1] - was[1]], size = box();
    const other = [...fingers].find(([id]) => id !== e.pointerId)?.[1];
    fingers.set(e.pointerId, at);
    if (other) {
      const middle = [(at[0] + other[0]) / 2, (at[1] + other[1]) / 2];
      move(zoom(pan(camera, size, dx / 2, dy / 2), size, ...middle, apart(was, other) / Math.max(1, apart(at, other))));
    } else if (gesture.left && !gesture.shift) {
      const angle = Math.PI / Math.min(...size);
      move(orbit(camera, axis, dx * angle, dy * angle));
    } else move(pan(camera, size, dx, dy));
  });
  listen(canvas, "pointerup pointercancel lostpointercapture", (e) => {
    if (!fingers.delete(e.pointerId) || e.type !== "pointerup" || gesture.moved || !gesture.left) return;
    const at = gesture.start, isDouble = lastClick && !gesture.shift && performance.now() - lastClick.when < DOUBLE_MS && apart(at, lastClick.at) < 3 * gesture.reach;
    lastClick = isDouble ? null : { at, when: performance.now() };
    const found = pick(at, gesture.shift);
    if (isDouble) found.then((p) => p && move(pivot(camera, p.center)));
  });
  listen(stage, "wheel", (e) => {
    if (e.target.closest(".hl-panel")) return;
    e.preventDefault();
    if (!scene || wasLost) return;
    const turned = (e.deltaY || e.deltaX) * [1, 16, 400][e.deltaMode];
    move(zoom(camera, box(), ...place(e), Math.exp(Math.max(-300, Math.min(300, turned)) * (e.ctrlKey ? 0.01 : 0.0015))));
  }, { passive: false });

  const sized = new ResizeObserver(() => {
    if (!scene || (drawn.level === 0 && String(drawn.pixels) === String(fullSize()))) return;
    showRings();
    changed();
  });
  sized.observe(stage);
  start();

  root.halfline = {
    stats, setCamera, select,
    camera: () => camera,
    still: whenStill,
    lastStill: () => still,
    picked: () => picked,
    selection: () => selection,
    destroy() {
      ended.abort();
      sized.disconnect();
      clearTimeout(restTimer);
      clearInterval(playing);
      clearTimeout(say.timer);
      URL.revokeObjectURL(legend.src);
      root.replaceChildren();
    },
  };
  return root.halfline;
}
