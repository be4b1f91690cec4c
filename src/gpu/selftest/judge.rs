//! Evaluates the answers of the self-test on the host without rounding errors: sums and products of f32 in
//! double-double, integers in i128. A wrong answer is counted and never causes a panic.

use super::cases::{COUNT, ROUNDING, SPECIAL, SUBNORMAL, ahead, power, quadratic};
use super::verdict::{Check, DIV_ULP, SQRT_ULP};
use crate::double_double::Dd;
use crate::intersect::double_float::Pair;
use crate::number::Arithmetic;

/// The checks that double-float requires.
pub(super) const DOUBLE_FLOAT: [&str; 10] = [
    "TwoSum, barrier",
    "FastTwoSum, barrier",
    "TwoDiff, barrier",
    "TwoProd by Dekker's split, barrier",
    "double-float add",
    "double-float mul and add",
    "double-float div",
    "double-float sqrt",
    "double-float solve",
    "f32 load, store, bitcast",
];

/// The checks that f64 requires.
pub(super) const F64: [&str; 5] = ["f64 sum", "f64 difference", "f64 product", "f64 division", "f64 sqrt"];

fn check<const N: usize>(name: &str, passed: bool, detail: [(&str, f64); N]) -> Check {
    // JSON has no infinities and no NaN.
    let finite = |x: f64| if x.is_finite() { x } else { f64::MAX };
    let detail = detail.into_iter().map(|(name, x)| (name.to_owned(), finite(x))).collect();
    Check { name: name.to_owned(), passed, detail }
}

/// The largest value of one figure over all checks.
pub(super) fn worst(checks: &[Check], number: &str) -> f64 {
    checks.iter().filter_map(|c| c.detail.get(number)).copied().fold(0.0, f64::max)
}

/// The words of each case as numbers, with the words of its answer.
fn rows<'a>(
    cases: &'a [u32],
    answers: &'a [u32],
    [words_in, words_out]: [usize; 2],
) -> impl Iterator<Item = (&'a [f32], &'a [f32])> + Clone {
    cases
        .chunks_exact(words_in)
        .map(bytemuck::cast_slice)
        .zip(answers.chunks_exact(words_out).map(bytemuck::cast_slice))
}

/// a - b, exact if a double-double can represent it.
fn difference(a: Dd, b: f32) -> f64 {
    (a - Dd::from(f64::from(b))).value()
}

/// Whether `x` is `exact` or one of its two neighbours, which WGSL calls correctly rounded.
fn faithful(x: f32, exact: Dd) -> bool {
    let off = difference(exact, x);
    x.is_finite()
        && match off.total_cmp(&0.0) {
            _ if off == 0.0 => true,
            std::cmp::Ordering::Greater => difference(exact, x.next_up()) < 0.0,
            _ => difference(exact, x.next_down()) > 0.0,
        }
}

/// Error of `x` in ulps of the f32 nearest to `exact`.
fn ulps(x: f32, exact: f64) -> f64 {
    let near = exact.abs() as f32;
    let ulp = f64::from(near.next_up()) - f64::from(near);
    let off = (f64::from(x) - exact).abs() / ulp;
    if off.is_nan() { f64::INFINITY } else { off }
}

pub(super) fn transforms(cases: &[u32], answers: &[u32]) -> Vec<Check> {
    // hi rounded to nearest, and the required hi + lo.
    type Exact = fn(&[f32]) -> (f32, Dd);
    let rows = rows(cases, answers, [6, 27]);
    let sum: Exact = |c| (c[0] + c[1], Dd::sum(c[0].into(), c[1].into()));
    let difference: Exact = |c| (c[0] - c[1], Dd::diff(c[0].into(), c[1].into()));
    let product: Exact = |c| (c[0] * c[1], Dd::from(f64::from(c[0]) * f64::from(c[1])));
    let exact: [(&str, Exact); 12] = [
        ("TwoSum, plain", sum),
        ("TwoSum, barrier", sum),
        ("FastTwoSum, plain", sum),
        ("FastTwoSum, barrier", sum),
        ("TwoDiff, plain", difference),
        ("TwoDiff, barrier", difference),
        ("TwoProd by fma, plain", product),
        ("TwoProd by fma, barrier", product),
        ("TwoProd by Dekker's split, plain", product),
        ("TwoProd by Dekker's split, barrier", product),
        ("TwoProd by mask, plain", product),
        ("TwoProd by mask, barrier", product),
    ];
    let mut checks = Vec::new();
    for (k, (name, exact)) in exact.into_iter().enumerate() {
        let (mut cases, mut wrong, mut lost) = (0.0, 0.0, 0.0);
        for (case, answer) in rows.clone() {
            let (hi, lo) = (answer[2 * k], answer[2 * k + 1]);
            let (nearest, sum) = exact(case);
            let good = hi == nearest && Dd::sum(hi.into(), lo.into()) == sum;
            cases += 1.0;
            wrong += f64::from(!good);
            lost += f64::from(!good && lo == 0.0);
        }
        let detail = [("cases", cases), ("wrong", wrong), ("error lost", lost)];
        checks.push(check(name, wrong == 0.0 && cases > 0.0, detail));
    }
    let counted = |name: &str, bad: &dyn Fn(&[f32], &[f32]) -> bool| {
        let count = rows.clone().filter(|(case, answer)| bad(case, answer)).count();
        check(name, count == 0, [("cases", rows.clone().count() as f64), ("wrong", count as f64)])
    };
    checks.push(counted("no contraction", &|_, answer| answer[24] != 0.0));
    checks.push(counted("no reassociation", &|case, answer| {
        let (large, small) = if case[0].abs() < case[1].abs() { (case[1], case[0]) } else { (case[0], case[1]) };
        answer[25] != (large + small) - large
    }));
    checks.push(counted("no distribution", &|case, answer| {
        let exact = f64::from(case[3] - case[4]) * f64::from(case[5]);
        !faithful(answer[26], Dd::from(exact))
    }));
    checks
}

pub(super) fn operations(cases: &[u32], answers: &[u32]) -> Vec<Check> {
    let all: Vec<_> = rows(cases, answers, [2, 11]).collect();
    let random = &all[..COUNT.min(all.len())];
    let rounds = |name: &str, word: usize, exact: fn(f64, f64) -> Dd| {
        let wrong = random.iter().filter(|(c, x)| !faithful(x[word], exact(c[0].into(), c[1].into()))).count();
        let ulp = random.iter().map(|(c, x)| ulps(x[word], exact(c[0].into(), c[1].into()).value()));
        check(name, wrong == 0, [("wrong", wrong as f64), ("ulp", ulp.fold(0.0, f64::max))])
    };
    let errs = |name: &str, word: usize, limit: f64, exact: fn(f64, f64) -> f64| {
        let ulp = random.iter().map(|(c, x)| ulps(x[word], exact(c[0].into(), c[1].into()))).fold(0.0, f64::max);
        check(name, ulp <= limit, [("ulp", ulp), ("allowed", limit)])
    };
    let mut checks = vec![
        rounds("f32 sum", 0, Dd::sum),
        rounds("f32 difference", 1, Dd::diff),
        rounds("f32 product", 2, |a, b| Dd::from(a * b)),
        errs("f32 division", 3, DIV_ULP, |a, b| a / b),
        errs("f32 sqrt", 4, SQRT_ULP, |a, _| a.abs().sqrt()),
        // The bound that WGSL states.
        errs("f32 inverseSqrt", 5, 2.0, |a, _| 1.0 / a.abs().sqrt()),
    ];
    let moved = random.iter().filter(|(c, x)| x[6] != c[0] || x[7] != c[0]).count();
    checks.push(check("f32 load, store, bitcast", moved == 0, [("wrong", moved as f64)]));
    let directed = &all[COUNT.min(all.len())..];
    checks.push(rounding(directed));
    let subnormal = directed.get(2 * ROUNDING.len()..).unwrap_or(&[]);
    let flushed = SUBNORMAL.map(|(name, _, word, expected)| {
        let place = SUBNORMAL.iter().position(|(other, ..)| *other == name).and_then(|k| subnormal.get(k));
        (name, f64::from(place.is_none_or(|(_, x)| x[word] != expected)))
    });
    checks.push(check("subnormals", flushed.iter().all(|(_, flushed)| *flushed == 0.0), flushed));
    let special = subnormal.get(SUBNORMAL.len()..).unwrap_or(&[]);
    let missed = SPECIAL.len() - SPECIAL.iter().zip(special).filter(|((_, word), (_, x))| x[*word] == 1.0).count();
    let cried = random.iter().filter(|(_, x)| x[8..11] != [0.0; 3]).count();
    let detail = [("missed", missed as f64), ("finite taken for special", cried as f64)];
    checks.push(check("f32 special numbers", missed + cried == 0, detail));
    checks
}

/// The rounding direction of sums: 0 to nearest even, 1 toward zero, 2 neither.
fn rounding(directed: &[(&[f32], &[f32])]) -> Check {
    let n = ROUNDING.len();
    let all_are = |k: usize| {
        directed.len() >= 2 * n
            && ROUNDING.iter().zip(&directed[..n]).all(|(r, (_, x))| x[0] == r[k])
            && ROUNDING.iter().zip(&directed[n..]).all(|(r, (_, x))| x[0] == -r[k])
    };
    let mode = [2, 3].into_iter().position(all_are).map_or(2.0, |k| k as f64);
    check("f32 rounding", mode == 0.0, [("mode", mode)])
}

/// u^2 of two f32 that round to nearest, u = 2^-24.
const U2: f64 = 1.0 / (1u64 << 48) as f64;

/// WGSL lets every operation round in either direction, which doubles u.
const FAITHFUL: f64 = 4.0;

/// Error bounds of the composed operations in u^2 (intersect/double_float.rs), rounded up for the terms in u^3.
const ADD: f64 = 3.01 * FAITHFUL;
const MUL: f64 = 5.01 * FAITHFUL;
const DIV: f64 = 15.01 * FAITHFUL;
const ROOT: f64 = 3.2 * FAITHFUL;

pub(super) fn pairs(cases: &[u32], answers: &[u32]) -> Vec<Check> {
    type Twin = fn(Pair<f32>, Pair<f32>, Pair<f32>) -> Pair<f32>;
    // The exact result, and the bound of the error in u^2.
    type Exact = fn(Dd, Dd, Dd) -> (Dd, f64);
    let operations: [(&str, Twin, Exact); 4] = [
        ("double-float add", |a, b, _| a + b, |a, b, _| (a + b, ADD * (a + b).value().abs())),
        (
            "double-float mul and add",
            |a, b, c| a * b + c,
            |a, b, c| {
                let (ab, sum) = (a * b, a * b + c);
                (sum, MUL * ab.value().abs() + ADD * (sum.value().abs() + MUL * U2 * ab.value().abs()))
            },
        ),
        ("double-float div", |a, b, _| a / b, |a, b, _| (a / b, DIV * (a / b).value().abs())),
        ("double-float sqrt", |a, _, _| Arithmetic::sqrt(a), |a, _, _| (a.sqrt(), ROOT * a.sqrt().value().abs())),
    ];
    let mut checks = Vec::new();
    for (k, (name, twin, exact)) in operations.into_iter().enumerate() {
        let (mut wrong, mut bits, mut most) = (0.0, 0.0, 0.0f64);
        for (case, answer) in rows(cases, answers, [6, 8]) {
            let given = |at: usize| Pair { hi: case[at], lo: case[at + 1] };
            let twin = twin(given(0), given(2), given(4));
            let (hi, lo) = (answer[2 * k], answer[2 * k + 1]);
            let double = |p: Pair<f32>| Dd::sum(p.hi.into(), p.lo.into());
            let (exact, bound) = exact(double(given(0)), double(given(2)), double(given(4)));
            let off = (double(Pair { hi, lo }) - exact).value().abs() / U2;
            wrong += f64::from(off.is_nan() || off > bound);
            bits += f64::from(twin.hi.to_bits() != hi.to_bits() || twin.lo.to_bits() != lo.to_bits());
            // A product followed by a sum may cancel, so errors are relative to their bound, not to the result.
            most = most.max(off / bound.max(f64::MIN_POSITIVE));
        }
        let detail =
            [("wrong", wrong), ("bits that differ from the twin", bits), ("u2", most * [ADD, MUL, DIV, ROOT][k])];
        checks.push(check(name, wrong == 0.0, detail));
    }
    checks
}

/// The error of a double-float discriminant relative to its two terms: about 30 roundings of u^2, with u doubled.
const TRUSTED: f64 = 32.0 * FAITHFUL * U2;

/// The intersection: hit or miss by the exact sign of the discriminant; t within the error that TRUSTED allows.
pub(super) fn solve(cases: &[u32], answers: &[u32]) -> Vec<Check> {
    let (mut decided, mut wrong, mut single, mut worst) = (0.0, 0.0, 0.0, 0.0f64);
    for (case, answer) in rows(cases, answers, [9, 2]) {
        let three = |k: usize| [case[k] as i64, case[k + 1] as i64, case[k + 2] as i64];
        let (p, d, r) = (three(0), three(3), case[6] as i64);
        let (aa, gg) = quadratic(p, d);
        let first = aa * i128::from(r).pow(2);
        let exact = first - gg;
        if exact.unsigned_abs() as f64 <= TRUSTED * (first + gg) as f64 || ahead(p, d) == 0 {
            continue;
        }
        let hit = answer[0] < f32::MAX;
        decided += 1.0;
        wrong += f64::from(hit != (exact >= 0));
        single += f64::from((exact.unsigned_abs() as f64) < f64::from(f32::EPSILON) * first as f64);
        if exact >= 0 {
            let q = ahead(p, d) as f64 + (exact as f64).sqrt();
            let t = power(p, r) as f64 / q;
            let off = (f64::from(answer[0]) + f64::from(answer[1]) - t).abs() / t.abs();
            // The effect on the root of an error TRUSTED in the discriminant's terms, and the remaining roundings.
            let allowed = TRUSTED * (first + gg) as f64 / ((exact as f64).sqrt() * q) + TRUSTED;
            wrong += f64::from(off.is_nan() || off > allowed);
            worst = worst.max(off);
        }
    }
    // Most cases must be beyond the precision of f32; otherwise the check shows nothing.
    let passed = wrong == 0.0 && decided >= 900.0 && single >= 500.0;
    let detail = [("decided", decided), ("wrong", wrong), ("within one ulp of f32", single), ("error of t", worst)];
    vec![check("double-float solve", passed, detail)]
}

/// Bounds for f64 like those for f32: sums and products rounded in either direction, which is one ulp from nearest, and
/// the same allowance for division and square root.
const WIDE: [f64; 5] = [1.0, 1.0, 1.0, DIV_ULP + 0.5, SQRT_ULP + 0.5];

pub(super) fn wide(cases: &[u32], answers: &[u32]) -> Vec<Check> {
    // Reads pairs of words by value, since their address may not be aligned for f64.
    let number = |w: &[u32]| f64::from_bits(u64::from(w[0]) | u64::from(w[1]) << 32);
    let ieee: [fn(f64, f64) -> f64; 5] =
        [|a, b| a + b, |a, b| a - b, |a, b| a * b, |a, b| a / b, |a, _| a.abs().sqrt()];
    let mut checks = Vec::new();
    for (k, name) in F64.into_iter().enumerate() {
        let (mut bits, mut most) = (0.0, 0.0f64);
        for (case, answer) in cases.chunks_exact(4).zip(answers.chunks_exact(10)) {
            let expected = ieee[k](number(case), number(&case[2..]));
            let got = number(&answer[2 * k..]);
            // Ordered as the numbers are, so that neighbours differ by one.
            let order = |x: f64| (x.to_bits() as i64) ^ ((((x.to_bits() as i64) >> 63) as u64) >> 1) as i64;
            let off = if got.is_finite() { order(got).abs_diff(order(expected)) as f64 } else { f64::INFINITY };
            bits += f64::from(off != 0.0);
            most = most.max(off);
        }
        checks.push(check(name, most <= WIDE[k], [("other bits than IEEE 754", bits), ("f64 ulp", most)]));
    }
    checks
}
