// The mathematics of the camera, without state. A camera is {eye, at, up, vfov} with degrees of the full height,
// {eye, at, up, height} in scene units (orthographic), or with a lens. `at` is the pivot; pixels are from the top left.

export const plus = (a, b, k = 1) => a.map((x, i) => x + k * b[i]);
export const minus = (a, b) => plus(a, b, -1);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const norm = (a) => Math.hypot(...a);
export const unit = (a) => a.map((x) => x / norm(a));
const turn = (v, axis, angle) => {
  const c = Math.cos(angle), s = Math.sin(angle), k = dot(axis, v) * (1 - c), w = cross(axis, v);
  return v.map((x, i) => x * c + w[i] * s + axis[i] * k);
};
const halfTan = (c) => c.lens?.half ?? Math.tan((c.vfov * Math.PI) / 360);

// An up direction that is square to `forward`: x, else y, is on the right.
function otherUp(forward) {
  const side = Math.abs(forward[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
  return unit(cross(side, forward));
}

export function basis(c) {
  const view = minus(c.at, c.eye), distance = norm(view), forward = unit(view);
  let right = cross(forward, unit(c.up));
  if (!(norm(right) > 1e-9)) right = cross(forward, otherUp(forward));
  right = unit(right);
  return { forward, right, up: cross(right, forward), distance };
}

// The height of what is seen at the distance of the pivot, and a pixel's share of it.
export const seen = (c) => c.height ?? 2 * norm(minus(c.at, c.eye)) * halfTan(c);
export const unitPerPixel = (c, size) => seen(c) / size[1];

// Turns the eye about the pivot by the angles of a drag to the right and downwards. With an axis the horizon stays level and
// the eye stops short of the poles (it may stay at one); without one the camera turns freely.
const POLE = Math.PI / 360;
export function orbit(c, axis, dx, dy) {
  const { forward, right, up, distance } = basis(c);
  const angle = Math.hypot(dx, dy);
  if (!angle) return c;
  let move, level = false;
  if (axis) {
    const pole = unit(axis), polar = Math.acos(Math.max(-1, Math.min(1, dot(forward, pole))));
    const next = Math.max(Math.min(POLE, polar), Math.min(Math.max(Math.PI - POLE, polar), polar + dy));
    move = (v) => turn(turn(v, right, polar - next), pole, -dx);
    level = Math.sin(next) > 0.99 * Math.sin(POLE);
  } else {
    const about = unit(plus(right.map((x) => x * dy), up, dx));
    move = (v) => turn(v, about, -angle);
  }
  return { ...c, eye: plus(c.at, unit(move(forward)), -distance), up: level ? axis : move(up) };
}

const shift = (c, by) => ({ ...c, eye: plus(c.eye, by), at: plus(c.at, by) });

// The vector in the plane of the pivot that is `dx` pixels to the right and `dy` downwards.
function inPlane(c, size, dx, dy) {
  const { right, up } = basis(c), u = unitPerPixel(c, size);
  return plus(right.map((x) => x * dx * u), up, -dy * u);
}

export const pan = (c, size, dx, dy) => shift(c, inPlane(c, size, -dx, -dy));

// Scales what is seen by `factor`; the point of the pivot's plane at pixel (x, y) stays there.
export function zoom(c, size, x, y, factor) {
  const moved = shift(c, inPlane(c, size, (x - size[0] / 2) * (1 - factor), (y - size[1] / 2) * (1 - factor)));
  if (c.height) return { ...moved, height: c.height * factor };
  return { ...moved, eye: plus(moved.at, minus(c.eye, c.at), factor) };
}

// Moves the pivot to a point and keeps direction and distance.
export const pivot = (c, point) => shift(c, minus(point, c.at));

// Looks along a direction with the given up direction, or with another where they are parallel.
export function look(c, direction, up) {
  const forward = unit(direction), level = norm(cross(forward, unit(up))) > 1e-6;
  return { ...c, eye: plus(c.at, forward, -norm(minus(c.at, c.eye))), up: level ? up : otherUp(forward) };
}

// Changes between perspective with `vfov` and orthographic; the size at the pivot stays.
export function otherLens(c, vfov) {
  const { eye, at, up } = c;
  if (!c.height) return { eye, at, up, height: seen(c) };
  return { eye: plus(at, basis(c).forward, -c.height / 2 / halfTan({ vfov })), at, up, vfov };
}

// Parallel rays start at the plane of the eye: moves an orthographic eye back until a ball is before it.
export function before(c, center, radius) {
  if (!c.height) return c;
  const { forward, distance } = basis(c), needed = dot(minus(c.at, center), forward) + 1.05 * radius;
  return distance >= needed ? c : { ...c, eye: plus(c.at, forward, -needed) };
}

// The pixel of a point; null behind the eye and for a lens.
export function project(c, size, point) {
  const { forward, right, up } = basis(c), v = minus(point, c.eye), depth = dot(v, forward);
  if (!(depth > 0) || c.lens) return null;
  const k = size[1] / (c.height ?? 2 * depth * halfTan(c));
  return [size[0] / 2 + dot(v, right) * k, size[1] / 2 - dot(v, up) * k];
}

// Numbers to a millionth of what is seen. What is sent is what is copied.
function trim(x, scale) {
  const digits = 6 - Math.floor(Math.log10(scale));
  if (!(digits <= 100)) return x;
  const step = 10 ** -digits;
  return (digits < 0 ? Math.round(x / step) * step : Number(x.toFixed(digits))) + 0;
}
export function tidy(c) {
  const scale = seen(c), h = c.height, all = (v, s) => v.map((x) => trim(x, s));
  return { ...c, eye: all(c.eye, scale), at: all(c.at, scale), up: all(c.up, 1.5 * norm(c.up)), ...(h && { height: trim(h, scale) }) };
}

// The greatest of 1, 2, 5 x 10^k that is not above `most`.
export function roundLength(most) {
  const k = Math.floor(Math.log10(most) + 1e-9);
  return Number(`${[5, 2, 1].find((m) => m <= (most / 10 ** k) * (1 + 1e-9)) ?? 1}e${k}`);
}

const numbers = (c) => JSON.stringify([c.eye, c.at, c.up, c.vfov, c.height, c.lens]);
export const sameCamera = (a, b) => numbers(a) === numbers(b);
