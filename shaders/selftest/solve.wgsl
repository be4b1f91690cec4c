// The double-float intersection as production composes it. A case is p, d, r of integers, so that the discriminant's
// sign is known, and the power in high and low parts.
const WORDS_IN: u32 = 9u;
const WORDS_OUT: u32 = 2u;

fn answer(n: u32) {
    let at = WORDS_IN * n;
    let p = Number3(number(cases[at]), number(cases[at + 1u]), number(cases[at + 2u]));
    let d = Number3(number(cases[at + 3u]), number(cases[at + 4u]), number(cases[at + 5u]));
    let s = WideSphere(p, number(cases[at + 6u]), pair(cases[at + 7u], cases[at + 8u]));
    let t = intersect(ray_of(d), s);
    answers[WORDS_OUT * n] = high(t);
    answers[WORDS_OUT * n + 1u] = low(t);
}
