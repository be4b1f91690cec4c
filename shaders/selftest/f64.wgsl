// The operations of f64 one by one, on adapters that support it. A case is a, b.
alias Word = f64;
const WORDS_IN: u32 = 2u;
const WORDS_OUT: u32 = 5u;

fn answer(n: u32) {
    let a = cases[WORDS_IN * n];
    let b = cases[WORDS_IN * n + 1u];
    let at = WORDS_OUT * n;
    answers[at] = a + b;
    answers[at + 1u] = a - b;
    answers[at + 2u] = a * b;
    answers[at + 3u] = a / b;
    answers[at + 4u] = sqrt(abs(a));
}
