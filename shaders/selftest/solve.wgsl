// The double-float intersection as the kernels compose it. A case is p, d, r as integers, so that the sign of the
// discriminant is known, and the power in high and low parts.
alias Word = f32;
const WORDS_IN: u32 = 9u;
const WORDS_OUT: u32 = 2u;

fn answer(n: u32) {
    let at = WORDS_IN * n;
    let p = Number3(from_f32(cases[at]), from_f32(cases[at + 1u]), from_f32(cases[at + 2u]));
    let d = Number3(from_f32(cases[at + 3u]), from_f32(cases[at + 4u]), from_f32(cases[at + 5u]));
    let s = Sphere(p, from_f32(cases[at + 6u]), from_hi_lo(cases[at + 7u], cases[at + 8u]), 1.0);
    let t = intersect(Ray(d), s);
    answers[WORDS_OUT * n] = to_hi(t);
    answers[WORDS_OUT * n + 1u] = to_lo(t);
}
