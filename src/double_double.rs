//! Double-double arithmetic of the host: an unevaluated sum of two f64, about 106 bits.
//!
//! Error-free transforms after Knuth (TwoSum) and Dekker 1971 (FastTwoSum); products by the fused multiply-add, which
//! Rust promises to round once. Relative error of `+ - * /` and `sqrt` is at most 2^-100 for operands whose
//! intermediate products neither overflow nor fall under 2^-900: callers scale by powers of two first.
//! Source of the error bounds: Joldes, Muller, Popescu, *Tight and rigorous error bounds for basic building blocks of
//! double-word arithmetic*, ACM TOMS 44 (2017), algorithms 6, 12 and 17.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `hi + lo` with |lo| <= ulp(hi)/2.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Dd {
    pub(crate) hi: f64,
    pub(crate) lo: f64,
}

impl Dd {
    /// a + b exactly.
    #[inline(always)]
    pub(crate) fn sum(a: f64, b: f64) -> Self {
        let hi = a + b;
        let bb = hi - a;
        Self { hi, lo: (a - (hi - bb)) + (b - bb) }
    }

    /// a - b exactly.
    #[inline(always)]
    pub(crate) fn diff(a: f64, b: f64) -> Self {
        Self::sum(a, -b)
    }

    /// a b exactly, away from underflow.
    #[inline(always)]
    pub(crate) fn product(a: f64, b: f64) -> Self {
        let hi = a * b;
        Self { hi, lo: a.mul_add(b, -hi) }
    }

    /// a + b where |a| >= |b|.
    #[inline(always)]
    fn fast(a: f64, b: f64) -> Self {
        let hi = a + b;
        Self { hi, lo: b - (hi - a) }
    }

    /// The nearest f64.
    #[inline(always)]
    pub(crate) fn value(self) -> f64 {
        self.hi + self.lo
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        if self.hi <= 0.0 {
            return Self::default();
        }
        let root = self.hi.sqrt();
        let rest = (self - Self::product(root, root)).value();
        Self::fast(root, rest / (2.0 * root))
    }

    /// Times 2^k, exactly unless it leaves the range.
    #[inline(always)]
    pub(crate) fn ldexp(self, k: i32) -> Self {
        Self { hi: ldexp(self.hi, k), lo: ldexp(self.lo, k) }
    }
}

impl From<f64> for Dd {
    #[inline(always)]
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

impl Add for Dd {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        let s = Self::sum(self.hi, b.hi);
        let t = Self::sum(self.lo, b.lo);
        let v = Self::fast(s.hi, s.lo + t.hi);
        Self::fast(v.hi, v.lo + t.lo)
    }
}

impl Neg for Dd {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Sub for Dd {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Mul for Dd {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        let p = Self::product(self.hi, b.hi);
        let cross = self.lo.mul_add(b.hi, self.hi * b.lo);
        Self::fast(p.hi, p.lo + cross)
    }
}

impl Div for Dd {
    type Output = Self;
    #[inline(always)]
    fn div(self, b: Self) -> Self {
        let first = self.hi / b.hi;
        let rest = self - b * first.into();
        let second = rest.hi / b.hi;
        let rest = rest - b * second.into();
        Self::fast(first, second) + (rest.hi / b.hi).into()
    }
}

/// A vector of three double-doubles.
pub(crate) type Dd3 = [Dd; 3];

/// a . b
#[inline(always)]
pub(crate) fn dot(a: Dd3, b: Dd3) -> Dd {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a x b
#[inline(always)]
pub(crate) fn cross(a: Dd3, b: Dd3) -> Dd3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The e with 2^e <= |x| < 2^(e+1) for a normal or subnormal x; 0 for zero.
#[must_use]
pub fn exponent(x: f64) -> i32 {
    if x == 0.0 {
        return 0;
    }
    let field = ((x.to_bits() >> 52) & 0x7ff) as i32;
    if field != 0 { field - 1023 } else { exponent(x * f64::from_bits((1023 + 64) << 52)) - 64 }
}

/// x 2^k. Exact unless the result is subnormal or overflows; then rounded once.
#[inline(always)]
pub(crate) fn ldexp(x: f64, k: i32) -> f64 {
    let power = |k: i32| f64::from_bits(((k + 1023) as u64) << 52);
    match k {
        -1022..=1023 => x * power(k),
        1024.. => ldexp(x * power(1023), k - 1023),
        // The first factor keeps x normal, so only the last product rounds.
        _ => ldexp(x * power(-969), k + 969),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_products_lose_nothing() {
        let (a, b) = (1.0 + f64::EPSILON, 2f64.powi(-60) + 2f64.powi(-100));
        assert_eq!(Dd::sum(a, b).hi, a, "the sum rounds to a");
        assert_eq!(Dd::sum(a, b).lo, b, "and keeps b");
        let p = Dd::product(a, a);
        assert_eq!((p.hi, p.lo), (1.0 + 2.0 * f64::EPSILON, f64::EPSILON * f64::EPSILON), "(1+e)^2");
    }

    #[test]
    fn division_and_root_invert_multiplication() {
        let x = Dd::sum(1.0 / 3.0, 1e-20);
        let y = Dd::sum(std::f64::consts::PI, -3e-18);
        // 2^-100: the bound stated at the head of the module.
        let near = |a: Dd, b: Dd| ((a - b).value() / b.hi).abs() <= 2f64.powi(-100);
        assert!(near((x * y) / y, x), "{:?}", (x * y) / y);
        assert!(near((y * y).sqrt(), y), "{:?}", (y * y).sqrt());
    }

    #[test]
    fn exponents_and_scaling_reach_the_ends() {
        for (x, e) in [(1.0, 0), (1.9, 0), (0.5, -1), (f64::MAX, 1023), (f64::MIN_POSITIVE, -1022), (5e-324, -1074)] {
            assert_eq!(exponent(x), e, "{x}");
            assert_eq!(exponent(-x), e, "-{x}");
        }
        assert_eq!(ldexp(1.5, 1000), 1.5 * 2f64.powi(1000));
        assert_eq!(ldexp(ldexp(1.5, -1060), 1060), 1.5, "subnormal and back");
        assert_eq!(ldexp(5e-324, 2000), 2f64.powi(2000 - 1074));
        assert_eq!(ldexp(1.0, -3000), 0.0);
    }
}
