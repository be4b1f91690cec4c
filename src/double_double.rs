//! Double-double arithmetic of the host: an unevaluated sum of two f64, about 106 bits.
//!
//! Error-free transforms after Knuth (TwoSum) and Dekker 1971 (FastTwoSum); products by the fused multiply-add, which
//! Rust promises to round once. Relative error of `+ - * /` and `sqrt` is at most 2^-100 for operands whose
//! intermediate products neither overflow nor fall under 2^-900: callers scale by powers of two first.
//! Source of the error bounds: Joldes, Muller, Popescu, *Tight and rigorous error bounds for basic building blocks of
//! double-word arithmetic*, ACM TOMS 44 (2017), algorithms 6, 12 and 17.

use crate::number::{Fused, Mask};
pub(crate) use crate::number::{exponent, ldexp};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `hi + lo` with |lo| <= ulp(hi)/2, of one number or of a vector.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Dd<T = f64> {
    pub(crate) hi: T,
    pub(crate) lo: T,
}

impl<T: Fused> Dd<T> {
    /// a + b exactly.
    #[inline(always)]
    pub(crate) fn sum(a: T, b: T) -> Self {
        let hi = a + b;
        let bb = hi - a;
        Self { hi, lo: (a - (hi - bb)) + (b - bb) }
    }

    /// a - b exactly.
    #[inline(always)]
    pub(crate) fn diff(a: T, b: T) -> Self {
        Self::sum(a, -b)
    }

    /// a b exactly, away from underflow.
    #[inline(always)]
    pub(crate) fn product(a: T, b: T) -> Self {
        let hi = a * b;
        Self { hi, lo: a.mul_add(b, -hi) }
    }

    /// a + b where |a| >= |b|.
    #[inline(always)]
    fn fast(a: T, b: T) -> Self {
        let hi = a + b;
        Self { hi, lo: b - (hi - a) }
    }

    /// The nearest f64.
    #[inline(always)]
    pub(crate) fn value(self) -> T {
        self.hi + self.lo
    }

    /// 0 of a number that is not positive.
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        let root = self.hi.sqrt();
        let rest = (self - Self::product(root, root)).value();
        let (zero, root) = (T::ZERO.into(), Self::fast(root, rest / (root + root)));
        Self::pick(self.hi.at_most(T::ZERO), zero, root)
    }

    /// Times 2^k, exactly unless it leaves the range.
    #[inline(always)]
    pub(crate) fn ldexp(self, k: i32) -> Self {
        Self { hi: self.hi.ldexp(k), lo: self.lo.ldexp(k) }
    }

    /// This number in every lane.
    #[inline(always)]
    pub(crate) fn splat(x: Dd) -> Self {
        Self { hi: T::splat(x.hi), lo: T::splat(x.lo) }
    }

    /// `yes` where the mask is set, else `no`.
    #[inline(always)]
    pub(crate) fn pick(mask: T::Mask, yes: Self, no: Self) -> Self {
        Self { hi: mask.pick(yes.hi, no.hi), lo: mask.pick(yes.lo, no.lo) }
    }
}

impl<T: Fused> From<T> for Dd<T> {
    #[inline(always)]
    fn from(hi: T) -> Self {
        Self { hi, lo: T::ZERO }
    }
}

impl<T: Fused> Add for Dd<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        let s = Self::sum(self.hi, b.hi);
        let t = Self::sum(self.lo, b.lo);
        let v = Self::fast(s.hi, s.lo + t.hi);
        Self::fast(v.hi, v.lo + t.lo)
    }
}

impl<T: Fused> Neg for Dd<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl<T: Fused> Sub for Dd<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl<T: Fused> Mul for Dd<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        let p = Self::product(self.hi, b.hi);
        let cross = self.lo.mul_add(b.hi, self.hi * b.lo);
        Self::fast(p.hi, p.lo + cross)
    }
}

impl<T: Fused> Div for Dd<T> {
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
pub(crate) type Dd3<T = f64> = [Dd<T>; 3];

/// a . b
#[inline(always)]
pub(crate) fn dot<T: Fused>(a: Dd3<T>, b: Dd3<T>) -> Dd<T> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a x b
#[inline(always)]
pub(crate) fn cross<T: Fused>(a: Dd3<T>, b: Dd3<T>) -> Dd3<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
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
}
