// The operations one by one, and the treatment of numbers at the ends of the range. A case is a, b.
alias Word = f32;
const WORDS_IN: u32 = 2u;
const WORDS_OUT: u32 = 11u;

const EXPONENT: u32 = 0x7f800000u; // all ones: infinity or NaN

fn is_special(x: f32) -> f32 {
    return select(0.0, 1.0, (bitcast<u32>(x) & EXPONENT) == EXPONENT);
}

fn answer(n: u32) {
    let a = cases[WORDS_IN * n];
    let b = cases[WORDS_IN * n + 1u];
    let at = WORDS_OUT * n;
    answers[at] = a + b;
    answers[at + 1u] = a - b;
    answers[at + 2u] = a * b;
    answers[at + 3u] = a / b;
    answers[at + 4u] = sqrt(abs(a));
    answers[at + 5u] = inverseSqrt(abs(a));
    answers[at + 6u] = a;
    answers[at + 7u] = bitcast<f32>(bitcast<u32>(a) ^ view.zero);
    answers[at + 8u] = is_special(a);
    answers[at + 9u] = is_special(a / b);
    answers[at + 10u] = is_special(a * b);
}
