// A stand-in for a notebook: a model of anywidget whose comm is the mock's HTTP, and the joined modules of the page.
import widget from "./joined.js";

const token = location.hash.slice(1), traits = { camera: null, picked: null, selection: null }, hearers = [];
const model = {
  sent: [], saves: 0, traits,
  get: (name) => traits[name],
  set: (name, value) => { traits[name] = value; },
  save_changes: () => { model.saves += 1; },
  on: (name, f) => hearers.push([name, f]),
  off: (name, f) => hearers.splice(hearers.findIndex(([n, g]) => n === name && g === f), 1),
  emit: (name, ...values) => hearers.filter(([n]) => n === name).forEach(([, f]) => f(...values)),
  async send(message) {
    model.sent.push(message);
    if (message.route === "/keep") return;
    const answer = await fetch(message.route, {
      method: "POST", headers: { Authorization: `Bearer ${token}` }, body: JSON.stringify(message.body),
    });
    const content = { id: message.id, status: answer.status }, buffers = [];
    if (answer.headers.get("X-Halfline")) {
      content.info = JSON.parse(answer.headers.get("X-Halfline"));
      buffers.push(new DataView(await answer.arrayBuffer()));
    } else if (answer.status !== 204) content.json = await answer.json();
    model.emit("msg:custom", content, buffers);
  },
};
const cell = document.getElementById("cell");
cell.style.width = "600px";
const close = widget.render({ model, el: cell });
const root = cell.querySelector(".halfline-view");
root.style.height = "400px";
window.notebook = { model, root, close };
