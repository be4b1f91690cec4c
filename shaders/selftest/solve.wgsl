// The sign of the discriminant a r^2 - |p x d|^2 in double-float: a case is p, d, r of integers, so that it is known.
const WORDS_IN: u32 = 7u;
const WORDS_OUT: u32 = 2u;

fn minor(a: f32, b: f32, c: f32, d: f32) -> Number {
    let g = sub(mul(number(a), number(b)), mul(number(c), number(d)));
    return mul(g, g);
}

fn answer(n: u32) {
    let at = WORDS_IN * n;
    let p = vec3<f32>(cases[at], cases[at + 1u], cases[at + 2u]);
    let d = vec3<f32>(cases[at + 3u], cases[at + 4u], cases[at + 5u]);
    let r = number(cases[at + 6u]);
    let gg = add(add(minor(p.y, d.z, p.z, d.y), minor(p.z, d.x, p.x, d.z)), minor(p.x, d.y, p.y, d.x));
    let x = mul(number(d.x), number(d.x));
    let y = mul(number(d.y), number(d.y));
    let z = mul(number(d.z), number(d.z));
    let disc = sub(mul(add(add(x, y), z), mul(r, r)), gg);
    answers[WORDS_OUT * n] = disc.hi;
    answers[WORDS_OUT * n + 1u] = disc.lo;
}
