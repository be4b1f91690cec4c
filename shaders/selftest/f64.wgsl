// The operations of f64, where shaders have it, one by one. A case is a, b.
const WORDS_IN: u32 = 2u;
const WORDS_OUT: u32 = 5u;

@group(0) @binding(20) var<storage, read> wide_cases: array<f64>;
@group(0) @binding(21) var<storage, read_write> wide_answers: array<f64>;

fn answer(n: u32) {
    let a = wide_cases[WORDS_IN * n];
    let b = wide_cases[WORDS_IN * n + 1u];
    let at = WORDS_OUT * n;
    wide_answers[at] = a + b;
    wide_answers[at + 1u] = a - b;
    wide_answers[at + 2u] = a * b;
    wide_answers[at + 3u] = a / b;
    wide_answers[at + 4u] = sqrt(abs(a));
}
