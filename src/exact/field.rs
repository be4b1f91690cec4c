//! The numbers x + y alpha + z beta + w alpha beta with exact binary alpha^2 and beta^2: the discriminants of rays of
//! an oblique camera. Their signs are decided by squaring and not by refining an interval, so that exact tangency and
//! exact ties terminate.

use crate::dyadic::Dyadic;
use std::cmp::Ordering;

/// Adjoins alpha and beta, two positive square roots, which may be rational or multiples of each other.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    pub(crate) alpha2: Dyadic,
    pub(crate) beta2: Dyadic,
}

/// An index into [`FieldElement`]; the fourth is not needed for any axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FieldBasis {
    One = 0,
    Alpha = 1,
    Beta = 2,
    AlphaBeta = 3,
}

/// The coefficients of 1, alpha, beta and alpha beta.
#[derive(Debug, Clone)]
pub(crate) struct FieldElement(pub(crate) [Dyadic; 4]);

impl FieldElement {
    pub(crate) const ZERO: Self = Self([const { Dyadic::ZERO }; 4]);

    pub(crate) fn plus(&self, b: &Self) -> Self {
        Self(std::array::from_fn(|k| &self.0[k] + &b.0[k]))
    }

    pub(crate) fn minus(&self, b: &Self) -> Self {
        Self(std::array::from_fn(|k| &self.0[k] - &b.0[k]))
    }

    /// The number as a binary number, if it is one.
    pub(crate) fn plain(&self) -> Option<&Dyadic> {
        self.0[1..].iter().all(Dyadic::is_zero).then_some(&self.0[0])
    }

    /// self x
    pub(super) fn scaled(&self, x: &Dyadic) -> Self {
        Self(self.0.each_ref().map(|part| part * x))
    }

    /// self 2^k
    pub(crate) fn ldexp(self, k: i64) -> Self {
        Self(self.0.map(|x| x.ldexp(k)))
    }

    /// Adds `x` times `unit`.
    pub(crate) fn add(&mut self, unit: FieldBasis, x: &Dyadic) {
        let slot = &mut self.0[unit as usize];
        *slot = &*slot + x;
    }
}

impl Field {
    /// The field of binary numbers: alpha = beta = 1.
    pub(crate) fn rational() -> Self {
        Self { alpha2: Dyadic::from(1), beta2: Dyadic::from(1) }
    }

    /// a b, by (a0 + a1 beta)(b0 + b1 beta) over the pairs x + y alpha.
    pub(crate) fn times(&self, a: &FieldElement, b: &FieldElement) -> FieldElement {
        let [a0, a1, a2, a3] = &a.0;
        let [b0, b1, b2, b3] = &b.0;
        let pair = |x0: &Dyadic, x1: &Dyadic, y0: &Dyadic, y1: &Dyadic| {
            [&(x0 * y0) + &(&self.alpha2 * &(x1 * y1)), &(x0 * y1) + &(x1 * y0)]
        };
        let (low, high) = (pair(a0, a1, b0, b1), pair(a2, a3, b2, b3));
        let (left, right) = (pair(a0, a1, b2, b3), pair(a2, a3, b0, b1));
        let [h0, h1] = high.map(|x| &self.beta2 * &x);
        FieldElement([&low[0] + &h0, &low[1] + &h1, &left[0] + &right[0], &left[1] + &right[1]])
    }

    /// The exact sign.
    pub(crate) fn sign(&self, a: &FieldElement) -> Ordering {
        let [x, y, z, w] = &a.0;
        let outer = self.sign_of_pair(x, y);
        let inner = self.sign_of_pair(z, w);
        resolve(outer, inner, || {
            // (x + y alpha)^2 - beta^2 (z + w alpha)^2, once more of the form X + Y alpha.
            let norm = |p: &Dyadic, q: &Dyadic| &p.square() + &(&self.alpha2 * &q.square());
            let big = &norm(x, y) - &(&self.beta2 * &norm(z, w));
            let mixed = &(x * y) - &(&self.beta2 * &(z * w));
            self.sign_of_pair(&big, &mixed.ldexp(1))
        })
    }

    /// The exact sign of x + y alpha.
    fn sign_of_pair(&self, x: &Dyadic, y: &Dyadic) -> Ordering {
        resolve(x.sign(), y.sign(), || (&x.square() - &(&self.alpha2 * &y.square())).sign())
    }

    /// The value with a relative error below 2^-bits; exactly 0 for 0.
    ///
    /// The four terms are summed with roots of n bits. Each root and each product of roots has an error of at most
    /// 2^-(n-3) of its term, so the sum has 2^-(n-3) of the sum of magnitudes; after cancellation n is increased. This
    /// terminates because [`Self::sign`] detects a sum that is exactly 0.
    pub(crate) fn value(&self, a: &FieldElement, bits: usize) -> Dyadic {
        let [x, y, z, w] = &a.0;
        let mut n = bits + 64;
        loop {
            let (alpha, beta) = (self.alpha2.sqrt(n), self.beta2.sqrt(n));
            let terms = [x.clone(), y * &alpha, z * &beta, &(w * &alpha) * &beta];
            let sum = terms.iter().fold(Dyadic::ZERO, |sum, term| &sum + term);
            let largest = terms.iter().filter(|x| !x.is_zero()).map(Dyadic::magnitude).max();
            let Some(largest) = largest else {
                return Dyadic::ZERO;
            };
            // Four terms below 2^largest: the error is below 2^(largest + 2 - (n - 3)), the sum at least
            // 2^(magnitude - 1); one more bit for the truncation.
            if !sum.is_zero() && largest + 5 - n as i64 <= sum.magnitude() - 1 - (bits as i64 + 1) {
                return sum.truncate(bits + 3);
            }
            if self.sign(a) == Ordering::Equal {
                return Dyadic::ZERO;
            }
            n *= 2;
        }
    }
}

/// The sign of A + B sqrt(C), C > 0, from the signs of A and B and, where they oppose, of A^2 - B^2 C.
pub(super) fn resolve(a: Ordering, b: Ordering, squares: impl FnOnce() -> Ordering) -> Ordering {
    match (a, b) {
        (_, Ordering::Equal) => a,
        (Ordering::Equal, _) => b,
        _ if a == b => a,
        (Ordering::Greater, _) => squares(),
        (Ordering::Less, _) => squares().reverse(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(x: [i64; 4]) -> FieldElement {
        FieldElement(x.map(Dyadic::from))
    }

    fn field(alpha2: i64, beta2: i64) -> Field {
        Field { alpha2: Dyadic::from(alpha2), beta2: Dyadic::from(beta2) }
    }

    #[test]
    fn signs_agree_with_f64_wherever_f64_can_tell() {
        for (p, q) in [(2, 3), (4, 5), (2, 8), (9, 16), (7, 7)] {
            let field = field(p, q);
            let (alpha, beta) = ((p as f64).sqrt(), (q as f64).sqrt());
            for n in 0..7i64.pow(4) {
                let x: [i64; 4] = std::array::from_fn(|k| n / 7i64.pow(k as u32) % 7 - 3);
                let approximate = x[0] as f64 + x[1] as f64 * alpha + x[2] as f64 * beta + x[3] as f64 * alpha * beta;
                let sign = field.sign(&element(x));
                // Coefficients up to 3: conjugates multiply to a non-zero integer, so no value lies in (0, 1e-9).
                if approximate.abs() > 1e-9 {
                    assert_eq!(sign, approximate.total_cmp(&0.0), "{x:?} {p} {q}");
                } else {
                    assert_eq!(sign, Ordering::Equal, "{x:?} {p} {q}");
                }
            }
        }
    }

    #[test]
    fn a_vanishing_sum_has_sign_and_value_zero() {
        // sqrt(8) = 2 sqrt(2), and sqrt(2) sqrt(8) = 4.
        let field = field(2, 8);
        for zero in [[0, 2, -1, 0], [4, 0, 0, -1], [12, -6, 3, -3]] {
            assert_eq!(field.sign(&element(zero)), Ordering::Equal, "{zero:?}");
            assert!(field.value(&element(zero), 100).is_zero(), "{zero:?}");
        }
    }

    #[test]
    fn products_and_values_survive_cancellation() {
        // (sqrt(2) - 1)^64 = x - y sqrt(2) with x and y near 10^24: their difference is about 10^-25.
        let field = field(2, 3);
        let mut power = element([-1, 1, 0, 0]);
        for _ in 0..6 {
            power = field.times(&power, &power);
        }
        let expected = (std::f64::consts::SQRT_2 - 1.0).powi(64);
        // powi of a rounded base: 64 ulps and a few.
        assert!((field.value(&power, 80).to_f64() / expected - 1.0).abs() < 1e-13);
        assert_eq!(field.sign(&power), Ordering::Greater);
        // (1 + a)(1 + b)(1 - a)(1 - b) = (1 - 2)(1 - 3)
        let plus = field.times(&element([1, 1, 0, 0]), &element([1, 0, 1, 0]));
        let both = field.times(&plus, &field.times(&element([1, -1, 0, 0]), &element([1, 0, -1, 0])));
        assert_eq!(both.0.each_ref().map(Dyadic::to_f64), [2.0, 0.0, 0.0, 0.0]);
    }
}
