import { before, dot, look, minus, norm, orbit, otherLens, pan, pivot, project, roundLength, sameCamera, tidy, unit, zoom } from "./camera.js";

const REST_MS = 150;        // still for so long: the still picture is asked for
const TARGET_MS = 80;       // what a moving frame may take
const SMALLEST = 3;         // a moving frame has 1/2^3 of the width or more
const IN_FLIGHT = 2;
const MOST_PIXELS = 4096;   // of a side
const MOST_SAVED = 64e6;    // pixels of a saved picture
const LAST = Number.MAX_SAFE_INTEGER; // the number of a request that none supersedes
const PLAY_MS = 40;
const INK = "<style>svg{shape-rendering:crispEdges}text{fill:#1b1f24}polyline{stroke:#808080}@media(prefers-color-scheme:dark){text{fill:#e6e8eb}}</style>";
const TURN = Math.PI / 12;  // of an arrow key
const CLICK_PX = 3, TAP_PX = 8, DOUBLE_MS = 400;

const make = (tag, props, ...children) => {
  const element = Object.assign(document.createElement(tag), props);
  element.append(...children);
  return element;
};
const div = (name, props, ...children) => make("div", { className: `hl-${name}`, ...props }, ...children);
const count = (n) => n.toLocaleString("en-US");
const plural = (n, word) => `${count(n)} ${word}${n === 1 ? "" : "s"}`;
// Positions on a surface and distances are within 1e-5.
const short = (value) => typeof value === "number" ? +value.toPrecision(7) : Array.isArray(value) ? value.map(short) : value;
const words = (value) => Array.isArray(value) ? value.map(words).join("\n") : String(value ?? "");

// The reduction of moving frames, from their times.
function pace() {
  let level = 0, delay = Infinity, recent = [];
  return {
    get level() { return level; },
    // `time` from request to picture with `flying` under way, `ms` in the server.
    add(at, time, flying, ms) {
      delay = Math.max(0, Math.min(delay * 1.02 + 0.1, time - flying * ms));
      if (at !== level) return;
      recent = [...recent.slice(-1), time / flying];
      if (recent.length < 2) return;
      // Only what exceeds the way to the server counts.
      const way = delay / flying, budget = Math.max(TARGET_MS, way + 30), slow = Math.min(...recent), quick = Math.max(...recent);
      let next = level;
      if (slow > 1.3 * budget) next = Math.min(SMALLEST, level + (slow > 5 * budget ? 2 : 1));
      else if (way + 4.4 * Math.max(0, quick - way) < budget) next = Math.max(0, level - 1);
      if (next !== level) [level, recent] = [next, []];
    },
  };
}

// Builds the view in `root`. transport.request(route, body, worker) -> Promise of {status, json, blob or pixels, info}. One that can
// compose(request, ask, isNow, show) renders the parts of a still at the same time, and supersede(seq) gives up those before; it saves
// by the worker `saver()`. `options`: page, camera, selection, onChange, onStill, words waiting and ended.
export function mount(root, transport, options = {}) {
  const ended = new AbortController();
  const listen = (target, names, f, more = {}) => {
    for (const name of names.split(" ")) target.addEventListener(name, f, { signal: ended.signal, ...more });
  };

  const notify = options.onChange ?? (() => {});

  let scene = null, camera = null, home = null, axis = null, vfov = 40;
  let selection = options.selection || "", frame = null, last = Infinity, picked = [];
  let version = 0, failed = -1, rest = true, restTimer = 0, wasLost = false, playing = 0;
  let seq = Date.now();      // increases over reloads of the page too
  let flying = [], drawn = { seq: 0, version: -1 }, still = null, waiters = [], lastSize = "";
  const speed = pace(), stats = { frames: 0 };

  // The document.
  const button = (text, title, onclick) => make("button", { textContent: text, title, ariaLabel: title, onclick });
  const canvas = make("canvas", { tabIndex: 0, role: "img", ariaLabel: "The picture; ? shows the keys" });
  const title = div("title");
  const input = make("input", { placeholder: "Select  ( / )", spellcheck: false, autocomplete: "off", autocapitalize: "off", ariaLabel: "Selection" });
  const chosen = make("output");
  const choose = make("form", { className: "hl-select", onsubmit: (e) => { e.preventDefault(); select(input.value); } }, input, chosen);
  const message = make("button", { className: "hl-message" });
  const note = div("note", { role: "status" });
  const rule = div("rule"), ruleText = make("span");
  const scale = div("scale", {}, ruleText, rule);
  const legendImage = make("img", { alt: "Legend" });
  const legend = make("details", { className: "hl-legend hl-panel", open: true }, make("summary", {}, "Legend"), legendImage);
  const rings = [0, 1].map(() => div("ring", {})), span = div("span", {});
  const table = div("table hl-panel", { role: "region", ariaLabel: "Picked spheres" });
  const controls = div("controls hl-panel");
  const dialog = div("dialog hl-panel", { role: "dialog" });
  const picture = div("picture", {}, canvas, span, ...rings);
  const stage = div("stage", {}, picture, scale, div("sides", {}, controls, table), note, message, dialog);
  const proof = make("summary"), facts = make("table");
  const status = make("details", { className: "hl-status" }, proof, div("panel", {}, facts));
  const caption = div("caption");
  const warned = make("details", { className: "hl-warnings" });
  const number = make("output"), slider = make("input", { type: "range", ariaLabel: "Frame", oninput: () => setFrame(+slider.value) });
  const film = div("film");
  const buttons = div("buttons");
  root.replaceChildren(div("bar", {}, title, choose, buttons), div("middle", {}, legend, stage), film, caption, div("foot", {}, status, warned));
  for (const e of [choose, buttons, message, note, scale, legend, caption, status, span, ...rings, table, controls, dialog, warned, film]) e.hidden = true;

  function say(what, isError = false, stays = isError) {
    note.textContent = what;
    note.hidden = !what;
    note.classList.toggle("hl-error", isError);
    clearTimeout(say.timer);
    if (what && !stays) say.timer = setTimeout(() => say(""), 4000);
  }
  function tell(what, retry) {
    message.textContent = what;
    message.hidden = !what;
    message.disabled = !retry;
    message.onclick = retry ?? null;
  }

  // Requests.
  async function ask(route, body, worker = 0) {
    let answer;
    try {
      answer = await transport.request(route, body, worker);
    } catch (error) {
      if (!ended.signal.aborted && !wasLost) {
        wasLost = true;
        stop();
        tell(options.ended ?? "The server has ended", !options.ended && start);
      }
      throw error;
    }
    if (answer.status < 400) return answer;
    throw Object.assign(new Error(answer.json?.error?.message ?? `status ${answer.status}`), answer);
  }
  const complain = (error) => { if (!wasLost) say(error.message, true); };

  async function start() {
    wasLost = false;
    tell(options.waiting ?? "Waiting for the server");
    try {
      for (;;) {
        const { state, text: what } = (await ask("/progress", {})).json;
        if (ended.signal.aborted) return;
        if (state === "ready") break;
        tell(what);
        await new Promise((resolve) => setTimeout(resolve, 100));
      }
      const framed = () => ask("/scene", { size: fullSize() });
      let { json } = await framed();
      showLegend(json.legend, json.draws);
      if (!legend.hidden) ({ json } = await framed());
      if (!scene) begin(json);
    } catch (error) {
      if (!wasLost) tell(error.message, start);
      return;
    }
    tell("");
    rest = true;
    version += 1;
    pump();
    notify({ camera });
    if (selection && !chosen.value) select(selection);
  }

  function begin(json) {
    scene = json;
    frame = scene.frame;
    // An axis, or y.
    home = unit(scene.camera.up).some((x) => Math.abs(x) > 1 - 1e-6) ? scene.camera.up : [0, 1, 0];
    layout();
    const name = scene.title ?? scene.file;
    title.replaceChildren(name, make("small", {}, scene.title ? "" : plural(scene.count, "sphere")));
    title.title = `${scene.file}, ${plural(scene.count, "sphere")}`;
    if (options.page) document.title = scene.title ?? `${scene.file} - halfline view`;
    caption.textContent = scene.caption ?? "";
    caption.hidden = !scene.caption;
    stage.style.backgroundColor = scene.background;
    choose.hidden = scene.selects === false;
    input.title = `Columns: ${Object.keys(scene.columns).join(", ")}`;
    buttons.hidden = false;
    showControls();
    film.hidden = scene.frames === 1;
    slider.min = scene.first;
    showFrame(scene.frames);
    layout();
    warn(scene.warnings);
    adopt(options.camera?.eye ? options.camera : scene.camera);
  }

  // One that was moved gets short numbers.
  function adopt(next) {
    vfov = next.vfov ?? vfov;
    if (axis || !camera) axis = next.up;
    camera = next;
  }
  function setCamera(next) {
    if (!scene) options.camera = next;
    else if (next?.eye && !sameCamera(camera, next)) {
      adopt(next);
      changed();
    }
  }
  function move(next) {
    const { center, radius } = scene;
    const r = radius || 1, size = next.height ?? norm(minus(next.at, next.eye));
    if (!(size > 1e-9 * r + 1e-12 * norm(next.at) && size < 1e5 * r + 10 * norm(minus(center, next.at)))) return;
    camera = tidy(before(next, center, r));
    changed();
  }
  function layout() {
    if (!scene?.sized) return;
    const [w, h] = scene.size, k = Math.min(stage.clientWidth / w, stage.clientHeight / h);
    picture.style.width = `${w * k}px`;
    picture.style.height = `${h * k}px`;
  }
  const box = () => [picture.clientWidth || 1, picture.clientHeight || 1];
  function fullSize() {
    if (scene?.sized) return scene.size;
    const [w, h] = box().map((x) => x * devicePixelRatio), k = Math.min(1, MOST_PIXELS / w, MOST_PIXELS / h);
    return [w, h].map((x) => Math.max(1, Math.round(x * k)));
  }

  // Frames: small ones in motion, at rest a whole one and the still.
  function changed() {
    if (note.classList.contains("hl-error")) say("");
    version += 1;
    transport.supersede?.(seq += 1);
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
    seq: seq += 1, camera, size, ...ofFrame(), select: selection || null, options: choices(), mode,
  });

  const isNow = (f) => f.version === version, isStill = () => isNow(drawn) && drawn.mode === "still";
  function pump() {
    if (!scene || wasLost || failed === version || flying.length >= IN_FLIGHT || !stage.clientWidth || !stage.clientHeight) return;
    const asked = flying.filter(isNow);
    if (!rest) {
      if (!asked.length && !isNow(drawn)) send("move", speed.level);
    } else if (!asked.some((f) => f.level === 0) && !isStill()) send(isNow(drawn) && drawn.level === 0 ? "still" : "move", 0);
  }

  async function send(mode, level) {
    const from = performance.now();
    const full = fullSize(), request = body(mode, full.map((x) => Math.max(1, Math.round(x / 2 ** level))));
    lastSize = String(full);
    const sent = { seq, version, mode, level, camera, frame }, together = flying.push(sent);
    let pause = 0;
    try {
      const composes = mode === "still" && scene.parts && transport.compose, isWanted = () => isNow(sent);
      const { blob, pixels, info } = await (composes ? transport.compose(request, ask, isWanted, refine) : ask("/frame", request));
      if (blob || pixels) {
        draw(sent, await createImageBitmap(blob ?? pixels), info ?? {}, blob);
        if (mode === "move") speed.add(level, performance.now() - from, together, info?.ms ?? 0);
      } else if (isNow(sent)) pause = 250;   // another window has the server
    } catch (error) {
      if (error.status === 503) pause = 500;
      else if (isNow(sent)) {
        failed = version;
        stop();
        complain(error);
      }
    }
    flying = flying.filter((f) => f !== sent);
    if (ended.signal.aborted) return;
    if (pause) setTimeout(pump, pause);
    else pump();
  }
  function refine(image, share) {
    [canvas.width, canvas.height] = [image.width, image.height];
    canvas.getContext("2d").drawImage(image, 0, 0);
    proof.textContent = `… refining, ${Math.round(100 * share)} %`;
  }
  function draw(sent, bitmap, info, blob) {
    if (sent.seq < drawn.seq || ended.signal.aborted) return bitmap.close();
    const pixels = [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
    canvas.getContext("2d").drawImage(bitmap, 0, 0);
    drawn = { ...sent, info, pixels };
    bitmap.close();
    stats.frames += 1;
    if (sent.mode === "still") still = blob ?? null;
    showFrame(info.frames);
    showStatus(sent.mode === "still", info, pixels);
    showScale();
    showRings();
    if (sent.mode === "still") warn(info.warnings);
    if (!isStill()) return;
    for (const resolve of waiters.splice(0)) resolve();
    options.onStill?.();
  }
  // Rounded down: a share of 100 % is one that is certified.
  function showStatus(isWhole, { certified, accuracy, settled, ms, adapter, look, samples }, [width, height]) {
    const [icon, what] = certified >= 1 ? ["✓", "certified"] : accuracy === "fast" ? ["≈", "fast"] : ["◔", `${Math.floor(certified * 1e4) / 100} % certified`];
    status.hidden = false;
    proof.textContent = `${icon} ${what}${isWhole ? "" : ", preview"}`;
    const rows = { "pixels": what, "settled exactly": count(settled ?? 0), "time": `${Math.round(ms)} ms`, "size": `${width} x ${height}`,
      "look": look && `${look}, ${plural(samples, "sample")}`, "rendered on": adapter };
    facts.replaceChildren(...Object.entries(rows).filter(([, value]) => value).map(([name, value]) =>
      make("tr", {}, make("th", { scope: "row" }, name), make("td", {}, value))));
  }

  function showScale() {
    const pixel = (drawn.info.unit * drawn.pixels[0]) / box()[0];
    if (!(pixel > 0) || scene.draws?.scale_bar) return;
    scale.hidden = false;
    const length = roundLength(140 * pixel);
    rule.style.width = `${length / pixel}px`;
    ruleText.textContent = length >= 1e6 ? length.toExponential() : length >= 1 ? count(length) : length;
  }
  function showRings() {
    const [a, b] = rings.map((ring, i) => {
      const at = picked[i] && drawn.camera && project(drawn.camera, box(), picked[i].position);
      ring.hidden = !at;
      if (at) ring.style.transform = `translate(${at[0]}px, ${at[1]}px)`;
      return at;
    });
    span.hidden = !(a && b);
    if (span.hidden) return;
    span.style.width = `${Math.hypot(b[0] - a[0], b[1] - a[1])}px`;
    span.style.transform = `translate(${a[0]}px, ${a[1]}px) rotate(${Math.atan2(b[1] - a[1], b[0] - a[0])}rad)`;
  }
  function showLegend(svg, draws = scene?.draws) {
    legend.hidden = !svg || draws?.legend;
    if (svg) legendImage.src = `data:image/svg+xml,${encodeURIComponent(svg.replace(/<rect.*?>/, INK))}`;
  }
  function warn(list) {
    const all = [...new Set([...(scene.warnings ?? []), ...(list ?? [])])];
    warned.hidden = !all.length;
    warned.replaceChildren(make("summary", {}, plural(all.length, "warning")),
      make("ul", { className: "hl-panel" }, ...all.map((w) => make("li", {}, w))));
  }
  function showPicked() {
    table.hidden = !picked.length;
    if (!picked.length) return table.replaceChildren();
    const line = (name, value) => make("tr", {}, make("th", { scope: "row" }, name), ...picked.map((p) => make("td", {}, words(value(p)))));
    const names = { center: "centre", radius: "radius", position: "position", distance: "from the eye", id: "id in the picture", row: "row, from 0", certainty: "certainty" };
    const rows = Object.entries(names).map(([key, name]) => line(name, (p) => short(p[key])));
    const columns = new Set(picked.flatMap((p) => Object.keys(p.columns))), unit = scene.unit ? ` ${scene.unit}` : "";
    const pair = picked[1]?.from, head = [make("strong", {}, pair ? `Distance ${short(pair.distance)}${unit}` : `Sphere ${picked[0].id}`)];
    if (pair?.minimum_image != null) head.push(make("span", {}, `minimum image ${short(pair.minimum_image)}${unit}`));
    else if (!pair) head.push(button("Distance", "Measure to the next sphere that is picked (Shift)", () => { measuring = true; say("Pick the second sphere"); }));
    table.replaceChildren(make("header", {}, make("div", {}, ...head), button("×", "Close (Esc)", () => setPicked([]))),
      make("table", {}, ...[...columns].map((name) => line(name, (p) => p.columns[name])), ...rows));
  }
  function setPicked(next) {
    picked = next;
    showPicked();
    showRings();
    notify({ picked });
  }

  let pickNumber = 0, measuring = false;
  async function pick([x, y], second) {
    const size = fullSize(), here = box(), mine = ++pickNumber;
    const pixel = [x, y].map((v, i) => Math.max(0, Math.min(size[i] - 1, Math.floor((v / here[i]) * size[i]))));
    const of = second || measuring ? picked.slice(0, 1) : [];
    measuring = false;
    const answer = await ask("/pick", { ...body("still", size), x: pixel[0], y: pixel[1], from: of[0]?.id ?? null }).catch(complain);
    if (answer && mine === pickNumber) setPicked(answer.json ? [...of, answer.json] : of);
    return answer?.json;
  }
  // What is selected, and its legend.
  let described = 0;
  async function describe(expr) {
    const mine = ++described, { json } = await ask("/select", { expr: expr || null, options: choices(expr), ...ofFrame() });
    if (mine === described) showLegend(json.legend);
    return json;
  }
  async function select(expr) {
    expr = expr.trim();
    if (!scene) return void (selection = expr);
    input.value = expr;
    if (expr === selection && (!expr || chosen.value)) return;
    const json = await describe(expr).catch((error) => error), isWrong = json instanceof Error;
    if (wasLost) return;
    selection = isWrong ? "" : expr;
    chosen.value = selection && `${count(json.count)} of ${count(json.of)}`;
    if (selection) canvas.focus({ preventScroll: true });
    notify({ selection });
    changed();
    if (!isWrong) return;
    complain(json);
    describe("").catch(complain);
  }

  // Controls: rows of the server, and the values that were changed.
  const settings = new Map();
  function choices(expr = selection) {
    const all = {}, names = Object.fromEntries([...settings].map(([{ renames }, value]) => [renames, value]));
    for (const [{ id, plane, others, renames }, value] of settings) {
      const text = plane ? String([...plane, dot(plane, [value, value, value])]) : others && expr ? `not (${expr})=${value}` : value;
      const name = names[id] ?? id;
      if (!renames) all[name] = [...all[name] ?? [], ...text ? [text] : []];
    }
    return all;
  }
  function restyle() {
    changed();
    describe(selection).catch(complain);
  }
  function showControls() {
    const row = (one) => {
      const { label, help, values, value, type, min, max, step } = one, output = make("output");
      const field = values ? make("select", {}, ...values.map((name) => make("option", { value: name }, name || "default")))
        : make("input", { type, min, max, step });
      field.value = value;
      const first = field.value, show = () => { output.value = type === "range" ? field.value : ""; };
      field.oninput = () => {
        settings.delete(one);
        if (field.value !== first) settings.set(one, field.value);
        show();
        restyle();
      };
      show();
      return make("label", { title: help }, label, field, output);
    };
    const reset = button("Reset", "The values of the beginning", () => { settings.clear(); showControls(); restyle(); });
    controls.replaceChildren(make("header", {}, make("strong", {}, "Controls"), reset, keyed("v", "×")),
      ...scene.controls.map(row));
  }

  const ofFrame = () => scene.frames === 1 ? {} : { frame };
  // The number of frames may come later.
  function showFrame(frames) {
    if (frames) last = scene.first + frames - 1;
    number.value = last < Infinity ? `${frame} / ${last}` : `frame ${frame}`;
    slider.hidden = !(last < Infinity);
    [slider.max, slider.value] = [last, frame];
  }
  function setFrame(n) {
    if (scene.frames === 1 || n < scene.first || n > last) return;
    frame = n;
    showFrame();
    if (picked.length) setPicked([]);
    changed();
  }
  const step = (by) => { stop(); setFrame(frame + by); };
  function togglePlay() {
    if (playing) return stop();
    if (scene.frames === 1) return;
    playing = setInterval(() => {
      if (flying.length < IN_FLIGHT) setFrame(frame >= last ? scene.first : frame + 1);
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

  async function copy(kind) {
    const all = (await ask("/command", body("still", fullSize())).catch(complain))?.json, what = all?.[kind];
    if (!what) return all && say("The scene has no command; p copies Python");
    try {
      await navigator.clipboard.writeText(what);
      say("The text is copied");
    } catch {
      const area = make("textarea", { value: what, readOnly: true, rows: 5, ariaLabel: "Text" });
      open("The clipboard is closed: copy from here", area);
      area.select();
    }
  }
  const whenRest = () => isStill() ? Promise.resolve() : new Promise((resolve) => waiters.push(resolve));
  // The file of the still; a composed one is rendered as a whole.
  async function whenStill() {
    await whenRest();
    const at = version, blob = still ?? (await ask("/frame", body("still", fullSize()))).blob;
    if (at !== version) return whenStill();
    return still = blob;
  }
  // A picture of `k` times the pixels of a side, or a figure, by a worker that renders nothing else meanwhile.
  async function enlarged(k, legend, kind) {
    const size = fullSize().map((x) => k * x), all = legend ? { ...choices(), legend_in: ["right"] } : choices();
    const request = { ...body(kind === "png" ? "still" : kind, size), seq: LAST, options: all };
    say(`Rendering ${size[0]} x ${size[1]}`, false, true);
    const { blob } = await ask("/frame", request, transport.saver?.(true)).finally(() => transport.saver?.(false));
    say("");
    return blob;
  }
  // A still `k` times as wide and high, or a figure without pixels, as a file of this kind.
  async function save(k = 1, legend = false, kind = "png") {
    const isStill = kind === "png" && k === 1 && !legend;
    const blob = await (isStill ? whenStill() : enlarged(k, legend, kind)).catch(complain);
    if (!blob) return;
    const href = URL.createObjectURL(blob), stem = scene.file.replace(/(.)\.[^.]*$/, "$1");
    make("a", { href, download: `${stem}${scene.frames === 1 ? "" : `-${frame}`}${k === 1 ? "" : `-${k}x`}.${kind}` }).click();
    setTimeout(() => URL.revokeObjectURL(href), 60000);
  }
  function chooseSize() {
    const [width, height] = fullSize(), hasLegend = !legend.hidden && !scene.draws?.legend;
    const box = make("input", { type: "checkbox", checked: hasLegend });
    const size = (k) => button(`${k * width} x ${k * height}`, `Save ${k} times the width and height as PNG`, () => { closeDialog(); save(k, box.checked); });
    const sizes = [1, 2, 4].filter((k) => k === 1 || k * k * width * height <= MOST_SAVED).map(size);
    const figure = (kind) => button(kind.toUpperCase(), `Save as ${kind.toUpperCase()}: a figure without pixels, with a light at the eye`,
      () => { closeDialog(); save(1, box.checked, kind); });
    open("Save as PNG, or without pixels", div("choices", {}, ...sizes, ...["svg", "pdf"].map(figure)), ...hasLegend ? [make("label", {}, box, " with the legend")] : []);
  }

  // Keys.
  const along = (name, i) => [name, [`Look along ${name} (Shift: against it)`, (back) => {
    axis &&= home;
    move(look(camera, [0, 1, 2].map((k) => k === i ? (back ? -1 : 1) : 0), home));
  }]];
  const turn = (x, y) => move(orbit(camera, axis, x * TURN, y * TURN));
  const side = (by, turns) => turns || scene.frames === 1 ? turn(by, 0) : step(by);
  const actions = {
    v: ["Show the controls, or hide them", () => { controls.hidden = !controls.hidden; }],
    f: ["Fit the scene, or the selection", async () => {
      const seen = version, fitted = await ask("/fit", body("still", fullSize())).catch(complain);
      if (fitted && seen === version) setCamera(fitted.json.camera);
    }],
    ...Object.fromEntries(["x", "y", "z"].map(along)),
    o: ["Orthographic or perspective", () => {
      move(otherLens(camera, vfov));
      say(camera.height ? "Orthographic" : "Perspective");
    }],
    t: ["Turn freely, or about the up direction", () => {
      axis = axis ? null : camera.up;
      say(axis ? "A drag turns about the up direction" : "A drag turns freely");
    }],
    0: ["The first view", () => setCamera(scene.camera)],
    c: ["Copy the command of the picture", () => copy("shell")],
    p: ["Copy the Python of the picture", () => copy("python")],
    s: ["Save the picture as PNG", () => save()],
    ArrowUp: ["Turn upwards", () => turn(0, -1)],
    ArrowDown: ["Turn downwards", () => turn(0, 1)],
    ArrowLeft: ["The frame before (Shift: turn)", (turns) => side(-1, turns)],
    ArrowRight: ["The next frame (Shift: turn)", (turns) => side(1, turns)],
    " ": ["Play the frames, or pause", togglePlay],
    "/": ["Select by an expression", () => { if (!choose.hidden) { input.focus(); input.select(); } }],
    Escape: ["Clear selection and picks", escape],
    "?": ["Show this help", toggleHelp],
  };
  const KEY_NAMES = { ArrowUp: "↑", ArrowDown: "↓", ArrowLeft: "←", ArrowRight: "→", " ": "Space", Escape: "Esc" };
  const keyed = (key, name) => button(name, `${actions[key][0]} (${KEY_NAMES[key] ?? key})`, () => actions[key][1]());
  const play = keyed(" ", "Play");
  film.append(keyed("ArrowLeft", "‹"), play, keyed("ArrowRight", "›"), slider, number);
  buttons.append(keyed("v", "Controls"), keyed("f", "Fit"), button("Copy", "Copy the command or the Python of the picture", chooseText),
    button("Save", "Save the picture as PNG, SVG or PDF (s: this one as PNG)", chooseSize), keyed("?", "?"));
  const HANDS = [
    "Drag, one finger: turn about the pivot", "Right, middle or Shift drag, two fingers: shift the picture",
    "Wheel, pinch: zoom toward the pointer", "Click, tap: pick a sphere",
    "Shift click: distance to a second sphere", "Double click: make the sphere the pivot",
  ];
  function toggleHelp() {
    if (!dialog.hidden) return closeDialog();
    const row = ([key, [what, run]]) => make("button", { onclick: () => { closeDialog(); run(false); } },
      make("kbd", {}, KEY_NAMES[key] ?? key), what);
    open("Hands and keys", div("keys", {}, ...Object.entries(actions).map(row)), div("keys", {}, ...HANDS.map((what) => make("span", {}, what))));
  }
  function chooseText() {
    const row = (key, name) => button(name, `${actions[key][0]} (${key})`, () => { closeDialog(); actions[key][1](); });
    open("Copy what makes this picture", div("choices", {}, row("c", "Command"), row("p", "Python")));
  }
  function open(name, ...content) {
    const close = button("×", "Close (Esc)", closeDialog);
    dialog.replaceChildren(make("header", {}, make("strong", {}, name), close), ...content);
    dialog.hidden = false;
    close.focus();
  }
  function closeDialog() {
    dialog.hidden = true;
    canvas.focus({ preventScroll: true });
  }
  function escape() {
    if (!dialog.hidden) return closeDialog();
    canvas.focus({ preventScroll: true });
    if (picked.length) setPicked([]);
    say("");
    select("");
  }
  listen(options.page ? document : root, "keydown", (e) => {
    if (!options.page) e.stopPropagation();
    if (!scene || !e.key || e.defaultPrevented || e.ctrlKey || e.metaKey || e.altKey) return;
    // Keys of the focused control.
    const own = e.key.startsWith("Arrow") ? "[type=range]" : e.key === " " || e.key === "Enter" ? "button, summary" : "textarea";
    if (e.key !== "Escape" && e.target.matches?.(`${own}, textarea, select, input:not([type=range])`)) return;
    const action = actions[e.key.length === 1 ? e.key.toLowerCase() : e.key];
    if (!action) return;
    e.preventDefault();
    action[1](e.shiftKey);
  });

  // Hands.
  const fingers = new Map();
  let gesture = null, lastClick = { when: -1e9 };
  const place = (e) => {
    const { left, top } = picture.getBoundingClientRect();
    return [e.clientX - left, e.clientY - top];
  };
  const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
  listen(canvas, "mousedown contextmenu", (e) => e.preventDefault());
  listen(canvas, "pointerdown", (e) => {
    if (!scene || wasLost) return;
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(e.pointerId);
    const at = place(e);
    fingers.set(e.pointerId, at);
    if (fingers.size > 1) gesture.moved = true;
    else gesture = { start: at, moved: false, left: e.button === 0, shift: e.shiftKey, reach: e.pointerType === "touch" ? TAP_PX : CLICK_PX };
  });
  listen(canvas, "pointermove", (e) => {
    const was = fingers.get(e.pointerId), at = place(e);
    if (!was || (!gesture.moved && apart(at, gesture.start) <= gesture.reach)) return;
    gesture.moved = true;
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
    const { start: at, shift, reach } = gesture, isDouble = !shift && e.timeStamp - lastClick.when < DOUBLE_MS && apart(at, lastClick.at) < 3 * reach;
    lastClick = { at, when: isDouble ? -1e9 : e.timeStamp };
    const found = pick(at, shift);
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
    layout();
    if (!scene) return;
    showRings();
    if (String(fullSize()) !== lastSize) changed();
  });
  sized.observe(stage);
  start();

  root.halfline = {
    stats, setCamera, select,
    camera: () => camera,
    rest: whenRest,
    still: whenStill,
    lastStill: () => still,
    picked: () => picked,
    selection: () => selection,
    destroy() {
      ended.abort();
      sized.disconnect();
      clearTimeout(restTimer);
      clearInterval(playing);
      root.replaceChildren();
    },
  };
  return root.halfline;
}
