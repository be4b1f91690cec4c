// The composed operations of double_float.wgsl as intersect inlines them. A case is a, b, c in high and low parts.
alias Word = f32;
const WORDS_IN: u32 = 6u;
const WORDS_OUT: u32 = 8u;

fn put(at: u32, x: Number) {
    answers[at] = x.hi;
    answers[at + 1u] = x.lo;
}

fn answer(n: u32) {
    let at = WORDS_IN * n;
    let a = from_hi_lo(cases[at], cases[at + 1u]);
    let b = from_hi_lo(cases[at + 2u], cases[at + 3u]);
    let c = from_hi_lo(cases[at + 4u], cases[at + 5u]);
    let to = WORDS_OUT * n;
    put(to, add(a, b));
    put(to + 2u, add(mul(a, b), c));
    put(to + 4u, div(a, b));
    put(to + 6u, root(a));
}
