//! The perpendicular form in unevaluated sums of two f32, about 48 bits: a number type, which is the twin of number/double_float.wgsl, operation for operation. Every f32 operation in Rust rounds
//! once, so the shader's barrier is not needed here.
//!
//! Sources: Knuth (TwoSum), Dekker 1971 (FastTwoSum, split and product); Joldes, Muller, Popescu, *Tight and rigorous
//! error bounds for basic building blocks of double-word arithmetic*, ACM TOMS 44 (2017), algorithms 6 (add, relative
//! error 3 u^2 + 13 u^3), 10 (mul, 5 u^2 after Muller and Rideau 2022) and 17 (div, 15 u^2 + 56 u^3); Lefevre, Louvet,
//! Muller, Picot, Rideau, *Accurate calculation of Euclidean norms using double-word arithmetic*, ACM TOMS 49 (2023)
//! (square root, 25/8 u^2); u = 2^-24.

use crate::number::vector::{LANES, Laned, Vector};
use crate::number::{Arithmetic, Mask, Number};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `hi + lo` with |lo| <= ulp(hi)/2, in f32 or in vectors of it.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(crate) struct Pair<F> {
    /// The nearest f32.
    pub(crate) hi: F,
    /// The rounding error of `hi`.
    pub(crate) lo: F,
}

/// 2^12 + 1: Dekker's constant for 24 bits.
const SPLIT: f32 = 4097.0;

/// a + b exactly.
#[inline(always)]
fn two_sum<F: Arithmetic>(a: F, b: F) -> Pair<F> {
    let hi = a + b;
    let bb = hi - a;
    Pair { hi, lo: (a - (hi - bb)) + (b - bb) }
}

/// a + b exactly, where |a| >= |b|.
#[inline(always)]
fn fast_two_sum<F: Arithmetic>(a: F, b: F) -> Pair<F> {
    let hi = a + b;
    Pair { hi, lo: b - (hi - a) }
}

/// a as the sum of two numbers of 12 bits.
#[inline(always)]
fn split<F: Arithmetic>(a: F) -> Pair<F> {
    let c = F::from_f32(SPLIT) * a;
    let hi = c - (c - a);
    Pair { hi, lo: a - hi }
}

/// a b exactly.
#[inline(always)]
fn two_product<F: Arithmetic>(a: F, b: F) -> Pair<F> {
    let hi = a * b;
    let (x, y) = (split(a), split(b));
    Pair { hi, lo: (x.hi * y.hi - hi + x.hi * y.lo + x.lo * y.hi) + x.lo * y.lo }
}

impl<F: Arithmetic> Add for Pair<F> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        let s = two_sum(self.hi, b.hi);
        let t = two_sum(self.lo, b.lo);
        let v = fast_two_sum(s.hi, s.lo + t.hi);
        fast_two_sum(v.hi, v.lo + t.lo)
    }
}

impl<F: Arithmetic> Neg for Pair<F> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl<F: Arithmetic> Sub for Pair<F> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl<F: Arithmetic> Mul for Pair<F> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        let p = two_product(self.hi, b.hi);
        let cross = self.hi * b.lo + self.lo * b.hi;
        fast_two_sum(p.hi, p.lo + cross)
    }
}

impl<F: Arithmetic> Div for Pair<F> {
    type Output = Self;
    #[inline(always)]
    fn div(self, b: Self) -> Self {
        let first = self.hi / b.hi;
        let p = two_product(b.hi, first);
        let v = fast_two_sum(p.hi, b.lo * first);
        let back = fast_two_sum(v.hi, v.lo + p.lo);
        let rest = (self.hi - back.hi) + (self.lo - back.lo);
        fast_two_sum(first, rest / b.hi)
    }
}

impl<F: Arithmetic> Arithmetic for Pair<F>
where
    F::Mask: Mask<Self>,
{
    type Mask = F::Mask;
    const MISS: Self = Self { hi: F::MISS, lo: F::ZERO };
    const ZERO: Self = Self { hi: F::ZERO, lo: F::ZERO };

    #[inline(always)]
    fn from_f32(x: f32) -> Self {
        Self { hi: F::from_f32(x), lo: F::ZERO }
    }

    /// Scales each part, because splitting the power could overflow.
    #[inline(always)]
    fn scaled(self, power: Self) -> Self {
        Self { hi: self.hi * power.hi, lo: self.lo * power.hi }
    }

    /// Square root; 0 for arguments that are not positive.
    #[inline(always)]
    fn sqrt(self) -> Self {
        let first = self.hi.sqrt();
        let p = two_product(first, first);
        let rest = self.lo + ((self.hi - p.hi) - p.lo);
        let root = fast_two_sum(first, rest / (F::from_f32(2.0) * first));
        let none = self.hi.less(F::ZERO) | self.hi.equal(F::ZERO);
        none.pick(Self::ZERO, root)
    }

    #[inline(always)]
    fn less(self, b: Self) -> Self::Mask {
        self.hi.less(b.hi) | (self.hi.equal(b.hi) & self.lo.less(b.lo))
    }

    #[inline(always)]
    fn equal(self, b: Self) -> Self::Mask {
        self.hi.equal(b.hi) & self.lo.equal(b.lo)
    }
}

impl Number for Pair<f32> {
    const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    fn from_hi_lo(hi: f32, lo: f32) -> Self {
        Self { hi, lo }
    }

    fn to_hi_lo(self) -> (f32, f32) {
        (self.hi, self.lo)
    }
}

impl Mask<Pair<Vector<f32>>> for Vector<u32> {
    #[inline(always)]
    fn pick(self, yes: Pair<Vector<f32>>, no: Pair<Vector<f32>>) -> Pair<Vector<f32>> {
        Pair { hi: self.pick(yes.hi, no.hi), lo: self.pick(yes.lo, no.lo) }
    }
}

impl Laned for Pair<f32> {
    type Vector = Pair<Vector<f32>>;
    #[inline(always)]
    fn splat(self) -> Self::Vector {
        Pair { hi: self.hi.splat(), lo: self.lo.splat() }
    }
    #[inline(always)]
    fn gather(pairs: [Self; LANES]) -> Self::Vector {
        Pair { hi: Vector(pairs.map(|pair| pair.hi)), lo: Vector(pairs.map(|pair| pair.lo)) }
    }
    #[inline(always)]
    fn lane(pairs: &Self::Vector, lane: usize) -> Self {
        Self { hi: pairs.hi.0[lane], lo: pairs.lo.0[lane] }
    }
    #[inline(always)]
    fn narrow(mask: Vector<u32>) -> Vector<u32> {
        mask
    }
}
