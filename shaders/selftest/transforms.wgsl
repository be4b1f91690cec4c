// Error-free transforms without the barrier (plain) and with it; and sums and products that a compiler may reassociate
// or fuse. A case is a, b, c = RN(a b), and x, y, z for (x - y) z.
alias Word = f32;
const WORDS_IN: u32 = 6u;
const WORDS_OUT: u32 = 27u;

fn put(at: u32, x: Number) {
    answers[at] = x.hi;
    answers[at + 1u] = x.lo;
}

fn plain_two_sum(a: f32, b: f32) -> Number {
    let hi = a + b;
    let bb = hi - a;
    return Number(hi, (a - (hi - bb)) + (b - bb));
}

fn plain_fast_two_sum(a: f32, b: f32) -> Number {
    let hi = a + b;
    return Number(hi, b - (hi - a));
}

fn plain_two_diff(a: f32, b: f32) -> Number {
    let hi = a - b;
    let bb = hi - a;
    return Number(hi, (a - (hi - bb)) - (b + bb));
}

fn two_diff(a: f32, b: f32) -> Number {
    let hi = minus(a, b);
    let bb = minus(hi, a);
    return Number(hi, minus(minus(a, minus(hi, bb)), plus(b, bb)));
}

fn plain_fma_product(a: f32, b: f32) -> Number {
    let hi = a * b;
    return Number(hi, fma(a, b, -hi));
}

fn fma_product(a: f32, b: f32) -> Number {
    let hi = product(a, b);
    return Number(hi, fp_barrier(fma(a, b, fp_barrier(-hi))));
}

fn plain_split(a: f32) -> Number {
    let c = SPLIT * a;
    let hi = c - (c - a);
    return Number(hi, a - hi);
}

fn masked(a: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(a) & 0xfffff000u);
}

fn plain_product_of(a: f32, b: f32, x: Number, y: Number) -> Number {
    let p = a * b;
    return Number(p, (x.hi * y.hi - p + x.hi * y.lo + x.lo * y.hi) + x.lo * y.lo);
}

fn product_of(a: f32, b: f32, x: Number, y: Number) -> Number {
    let p = product(a, b);
    let more = plus(plus(minus(product(x.hi, y.hi), p), product(x.hi, y.lo)), product(x.lo, y.hi));
    return Number(p, plus(more, product(x.lo, y.lo)));
}

fn answer(n: u32) {
    let a = cases[WORDS_IN * n];
    let b = cases[WORDS_IN * n + 1u];
    let c = cases[WORDS_IN * n + 2u];
    let x = cases[WORDS_IN * n + 3u];
    let y = cases[WORDS_IN * n + 4u];
    let z = cases[WORDS_IN * n + 5u];
    let swap = abs(a) < abs(b);
    let large = select(a, b, swap);
    let small = select(b, a, swap);
    let at = WORDS_OUT * n;
    put(at, plain_two_sum(a, b));
    put(at + 2u, two_sum(a, b));
    put(at + 4u, plain_fast_two_sum(large, small));
    put(at + 6u, fast_two_sum(large, small));
    put(at + 8u, plain_two_diff(a, b));
    put(at + 10u, two_diff(a, b));
    put(at + 12u, plain_fma_product(a, b));
    put(at + 14u, fma_product(a, b));
    put(at + 16u, plain_product_of(a, b, plain_split(a), plain_split(b)));
    put(at + 18u, two_product(a, b));
    put(at + 20u, plain_product_of(a, b, Number(masked(a), a - masked(a)), Number(masked(b), b - masked(b))));
    put(at + 22u, product_of(a, b, Number(masked(a), minus(a, masked(a))), Number(masked(b), minus(b, masked(b)))));
    answers[at + 24u] = a * b - c;
    answers[at + 25u] = (large + small) - large;
    answers[at + 26u] = (x - y) * z;
}
