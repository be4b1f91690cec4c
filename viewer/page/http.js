import { mount } from "./view.js";

// The token is in the fragment, which no request carries.
const token = location.hash.slice(1);
addEventListener("hashchange", () => location.reload());

const transport = {
  async request(route, body) {
    const answer = await fetch(route, {
      method: "POST",
      headers: { "Content-Type": "application/json", Authorization: `Bearer ${token}` },
      body: JSON.stringify(body),
    });
    const { status, headers } = answer, picture = headers.get("Content-Type")?.startsWith("image/");
    if (picture) return { status, blob: await answer.blob(), info: JSON.parse(headers.get("X-Halfline")) };
    const text = await answer.text();
    return { status, json: text ? JSON.parse(text) : null };
  },
};

mount(document.getElementById("view"), transport, { page: true });
