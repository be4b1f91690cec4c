// Checks of camera.js, evaluated by drive.py in the page: gives [[name, ok, detail]].
(async () => {
  const m = await import("/camera.js"), results = [];
  const near = (a, b, e = 1e-9) => [a].flat().every((x, i) => Math.abs(x - [b].flat()[i]) <= e * Math.max(1, Math.abs(x)));
  const check = (name, ok, detail = "") => results.push([name, Boolean(ok), detail]);
  let state = 1;
  const random = () => (state = (state * 16807) % 2147483647) / 2147483647 * 2 - 1;
  const point = (k = 10) => [random() * k, random() * k, random() * k];
  const size = [800, 600], length = (c) => m.norm(m.minus(c.at, c.eye));
  const cameras = [...Array(50)].map((_, i) => ({
    eye: point(), at: point(), up: i % 2 ? [0, 0, 1] : point(), ...(i % 3 ? { vfov: 10 + 50 * Math.abs(random()) } : { height: 1 + Math.abs(random()) * 9 }),
  }));
  // The point of the pivot's plane at a pixel, written apart from the module.
  const under = (c, x, y) => {
    const w = m.unit(m.minus(c.at, c.eye)), u = m.unit(m.cross(w, c.up)), v = m.cross(u, w);
    const k = (c.height ?? 2 * length(c) * Math.tan(c.vfov * Math.PI / 360)) / size[1];
    return c.at.map((a, i) => a + u[i] * (x - 400) * k + v[i] * (300 - y) * k);
  };
  const all = (name, f) => {
    const bad = cameras.find((c) => !f(c));
    check(name, !bad, bad && JSON.stringify(bad));
  };
  all("orbit keeps the distance, the pivot and up", (c) => {
    const d = m.orbit(c, c.up, random(), random());
    return near(length(d), length(c)) && near(d.at, c.at) && near(d.up, c.up);
  });
  all("a small orbit moves the point before the pivot with the pointer", (c) => {
    const front = m.plus(c.at, m.unit(m.minus(c.eye, c.at)), 0.1 * length(c)), d = m.orbit(c, null, 0.01, 0.02);
    const [x, y] = m.project(d, size, front);
    return x > 400 && y > 300;
  });
  all("an orbit about up keeps the height of the eye when it goes sideways", (c) => {
    const up = m.unit(c.up), d = m.orbit(c, c.up, random() * 6, 0);
    return near(m.dot(d.eye, up), m.dot(c.eye, up), 1e-8);
  });
  all("a free orbit has no poles", (c) => {
    let d = c;
    for (let i = 0; i < 60; i++) d = m.orbit(d, null, 0, Math.PI / 30);
    return near(d.eye, c.eye, 1e-6) && near(length(d), length(c));
  });
  all("an orbit stops before the poles", (c) => {
    const d = m.orbit(m.orbit(c, c.up, 0, 9), c.up, 0.3, 9);
    const { forward } = m.basis(d), sine = m.norm(m.cross(forward, m.unit(c.up)));
    return sine > 0.008 && sine < 0.0095;
  });
  all("pan moves the plane of the pivot with the pointer", (c) => {
    const d = m.pan(c, size, 37, -21), p = under(c, 300, 200);
    return near(m.project(d, size, p), [337, 179], 1e-6) && near(length(d), length(c));
  });
  all("zoom keeps the point under the pointer", (c) => {
    const d = m.zoom(c, size, 610, 130, 0.7), p = under(c, 610, 130);
    return near(m.project(d, size, p), [610, 130], 1e-6) && near(m.unitPerPixel(d, size), 0.7 * m.unitPerPixel(c, size));
  });
  all("pivot keeps direction and distance", (c) => {
    const p = point(), d = m.pivot(c, p);
    return near(d.at, p) && near(m.minus(d.at, d.eye), m.minus(c.at, c.eye)) && near(m.project(d, size, p), [400, 300], 1e-6);
  });
  for (const i of [0, 1, 2]) for (const sign of [1, -1]) all(`look along ${sign}${"xyz"[i]}`, (c) => {
    const direction = [0, 0, 0].map((_, k) => k === i ? sign : 0);
    return [[0, 0, 1], [0, 1, 0], [1, 0, 0], c.up].every((up) => {
      const d = m.look(c, direction, up), b = m.basis(d);
      return near(b.forward, direction, 1e-6) && near(length(d), length(c)) && m.norm(m.cross(b.forward, m.unit(d.up))) > 1e-6;
    });
  });
  const top = m.look(cameras[1], [0, 0, -1], [0, 0, 1]);
  check("the view from above has x on the right and y upwards", near(m.basis(top).right, [1, 0, 0]) && near(m.basis(top).up, [0, 1, 0]));
  check("a drag leaves the view from above without a jump", m.norm(m.minus(m.orbit(top, [0, 0, 1], 0, -0.001).eye, top.eye)) < 0.0011 * length(top));
  all("the other lens keeps the size at the pivot, and comes back", (c) => {
    const d = m.otherLens(c, c.vfov ?? 40), e = m.otherLens(d, c.vfov ?? 40);
    return near(m.seen(c), m.seen(d)) && near(m.seen(e), m.seen(c)) && (c.height || near(e.eye, c.eye, 1e-9)) && !(d.vfov && d.height);
  });
  all("an orthographic eye is before the ball", (c) => {
    const center = point(), d = m.before(c, center, 5);
    return c.vfov ? d === c : m.dot(m.minus(center, d.eye), m.basis(c).forward) >= 5 && near(m.project(d, size, c.at), [400, 300], 1e-6);
  });
  all("tidy moves the picture by less than a hundredth of a pixel and is idempotent", (c) => {
    const d = m.tidy(c), p = under(c, 500, 100), q = m.project(d, size, p);
    return near(q, [500, 100], 2e-5) && m.sameCamera(m.tidy(d), d) && JSON.stringify(d).length < 140;
  });
  const far = { eye: [6378137.123456789, 1e9, -3], at: [6378137.123456789, 1e9 + 1, -3], up: [0, 0, 1], vfov: 30 };
  check("tidy far from the origin", near(m.project(m.tidy(far), size, far.at), [400, 300], 1e-3), JSON.stringify(m.tidy(far)));
  check("tidy of great and of tiny scenes", [1e12, 1e-12, 1e300, 1e-200].every((k) => {
    const c = { eye: [0, -3.123456789 * k, 0], at: [0, 0, 0], up: [0, 0, 1], vfov: 30 }, d = m.tidy(c);
    return near(m.seen(d) / m.seen(c), 1, 1e-5);
  }));
  check("round lengths", [[1, 1], [1.9, 1], [2, 2], [4.99, 2], [7, 5], [0.03, 0.02], [1234, 1000], [0.1, 0.1], [1e-9, 1e-9], [6e20, 5e20]].every(([x, y]) => m.roundLength(x) === y));
  check("a point behind the eye is nowhere", m.project({ eye: [0, 0, 0], at: [0, 1, 0], up: [0, 0, 1], vfov: 30 }, size, [0, -1, 0]) === null);
  return results;
})()
