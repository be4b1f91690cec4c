//! The perpendicular form in unevaluated sums of two f32, about 48 bits: the code of [`Stable`] with another number
//! type, which is the twin of number/double_float.wgsl, operation for operation. Every f32 operation in Rust rounds
//! once, so the shader's barrier is not needed here.
//!
//! Sources: Knuth (TwoSum), Dekker 1971 (FastTwoSum, split and product); Joldes, Muller, Popescu, *Tight and rigorous
//! error bounds for basic building blocks of double-word arithmetic*, ACM TOMS 44 (2017), algorithms 6 (add, relative
//! error 3 u^2 + 13 u^3), 10 (mul, 5 u^2 after Muller and Rideau 2022) and 17 (div, 15 u^2 + 56 u^3); Lefevre, Louvet,
//! Muller, Picot, Rideau, *Accurate calculation of Euclidean norms using double-word arithmetic*, ACM TOMS 49 (2023)
//! (square root, 25/8 u^2); u = 2^-24.

use super::Intersect;
use super::stable::Stable;
use crate::number::Number;
use crate::view::Sphere;
use crate::view::ray::Ray;
use std::ops::{Add, Div, Mul, Neg, Sub};

pub(crate) struct DoubleFloat;

impl Intersect for DoubleFloat {
    type Number = Pair;

    fn intersect<R: Number>(ray: &Ray<R>, s: &Sphere<R>) -> R {
        Stable::intersect(ray, s)
    }

    fn normal_at<R: Number>(ray: &Ray<R>, s: &Sphere<R>, t: R) -> [R; 3] {
        Stable::normal_at(ray, s, t)
    }
}

/// `hi + lo` with |lo| <= ulp(hi)/2.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(crate) struct Pair {
    /// The nearest f32.
    pub(crate) hi: f32,
    /// The rounding error of `hi`.
    pub(crate) lo: f32,
}

/// 2^12 + 1: Dekker's constant for 24 bits.
const SPLIT: f32 = 4097.0;

/// a + b exactly.
fn two_sum(a: f32, b: f32) -> Pair {
    let hi = a + b;
    let bb = hi - a;
    Pair { hi, lo: (a - (hi - bb)) + (b - bb) }
}

/// a + b exactly, where |a| >= |b|.
fn fast_two_sum(a: f32, b: f32) -> Pair {
    let hi = a + b;
    Pair { hi, lo: b - (hi - a) }
}

/// a as the sum of two numbers of 12 bits.
fn split(a: f32) -> Pair {
    let c = SPLIT * a;
    let hi = c - (c - a);
    Pair { hi, lo: a - hi }
}

/// a b exactly.
fn two_product(a: f32, b: f32) -> Pair {
    let hi = a * b;
    let (x, y) = (split(a), split(b));
    Pair { hi, lo: (x.hi * y.hi - hi + x.hi * y.lo + x.lo * y.hi) + x.lo * y.lo }
}

impl Add for Pair {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let s = two_sum(self.hi, b.hi);
        let t = two_sum(self.lo, b.lo);
        let v = fast_two_sum(s.hi, s.lo + t.hi);
        fast_two_sum(v.hi, v.lo + t.lo)
    }
}

impl Neg for Pair {
    type Output = Self;
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Sub for Pair {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Mul for Pair {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let p = two_product(self.hi, b.hi);
        let cross = self.hi * b.lo + self.lo * b.hi;
        fast_two_sum(p.hi, p.lo + cross)
    }
}

impl Div for Pair {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let first = self.hi / b.hi;
        let p = two_product(b.hi, first);
        let v = fast_two_sum(p.hi, b.lo * first);
        let back = fast_two_sum(v.hi, v.lo + p.lo);
        let rest = (self.hi - back.hi) + (self.lo - back.lo);
        fast_two_sum(first, rest / b.hi)
    }
}

impl Number for Pair {
    const MISS: Self = Self { hi: f32::MAX, lo: 0.0 };
    const ZERO: Self = Self { hi: 0.0, lo: 0.0 };
    const HALF: Self = Self { hi: 0.5, lo: 0.0 };
    const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    fn from_f32(x: f32) -> Self {
        Self { hi: x, lo: 0.0 }
    }

    fn from_i32(x: i32) -> Self {
        let hi = x as f32;
        Self { hi, lo: (f64::from(x) - f64::from(hi)) as f32 }
    }

    fn from_hi_lo(hi: f32, lo: f32) -> Self {
        Self { hi, lo }
    }

    fn to_hi_lo(self) -> (f32, f32) {
        (self.hi, self.lo)
    }

    /// Scales each part, because splitting the power could overflow.
    fn scaled(self, power: Self) -> Self {
        Self { hi: self.hi * power.hi, lo: self.lo * power.hi }
    }

    /// Square root; 0 for arguments that are not positive.
    fn sqrt(self) -> Self {
        if self.hi <= 0.0 {
            return Self::ZERO;
        }
        let first = self.hi.sqrt();
        let p = two_product(first, first);
        let rest = self.lo + ((self.hi - p.hi) - p.lo);
        fast_two_sum(first, rest / (2.0 * first))
    }
}
