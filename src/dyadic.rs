//! Exact binary numbers m 2^e with a big integer m. Every f64 is one; sums and products are exact.
//!
//! No common denominator is needed: a product adds exponents, a sum shifts the operand with the larger one. Quotients
//! and roots are truncated to a stated number of bits.

use crate::double_double::{self as dd, Dd};
use dashu_int::ops::{BitTest, SquareRoot};
use dashu_int::{IBig, Sign, UBig};
use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

/// `m 2^e`.
#[derive(Debug, Clone)]
pub(crate) struct Dyadic {
    m: IBig,
    e: i64,
}

impl Dyadic {
    /// 0.
    pub(crate) const ZERO: Self = Self { m: IBig::ZERO, e: 0 };
    pub(crate) const ONE: Self = Self { m: IBig::ONE, e: 0 };

    /// The finite f64 `x`, exactly.
    pub(crate) fn of(x: f64) -> Self {
        debug_assert!(x.is_finite(), "{x}");
        let bits = x.to_bits();
        let (field, fraction) = ((bits >> 52 & 0x7ff) as i64, bits & ((1 << 52) - 1));
        // Subnormals have the exponent of the smallest normals and no implicit leading one.
        let (m, e) = if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
        if m == 0 {
            return Self::ZERO;
        }
        // Short integers make short products, and the numbers of scenes are often round.
        let zeros = m.trailing_zeros();
        let sign = if x < 0.0 { Sign::Negative } else { Sign::Positive };
        Self { m: IBig::from_parts(sign, UBig::from(m >> zeros)), e: e + i64::from(zeros) }
    }

    /// The sign, as the comparison with 0.
    pub(crate) fn sign(&self) -> Ordering {
        match self.m.sign() {
            Sign::Negative => Ordering::Less,
            Sign::Positive if self.m.is_zero() => Ordering::Equal,
            Sign::Positive => Ordering::Greater,
        }
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.m.is_zero()
    }

    /// |self|
    pub(crate) fn abs(self) -> Self {
        if self.sign() == Ordering::Less { -self } else { self }
    }

    /// self 2^k
    pub(crate) fn ldexp(mut self, k: i64) -> Self {
        self.e += k;
        self
    }

    pub(crate) fn square(&self) -> Self {
        Self { m: self.m.sqr().into(), e: 2 * self.e }
    }

    /// The n with 2^(n-1) <= |self| < 2^n; 0 for 0.
    pub(crate) fn magnitude(&self) -> i64 {
        if self.is_zero() { 0 } else { self.e + self.m.bit_len() as i64 }
    }

    /// The leading `bits` bits: a relative error below 2^-(bits-1).
    pub(crate) fn truncate(self, bits: usize) -> Self {
        let length = self.m.bit_len();
        if length <= bits {
            return self;
        }
        // A right shift of a negative number rounds down: the error is one unit of the last kept bit either way.
        let cut = length - bits;
        Self { m: self.m >> cut, e: self.e + cut as i64 }
    }

    /// self / by with a relative error below 2^-(bits-1); `by` is not 0.
    pub(crate) fn over(&self, by: &Self, bits: usize) -> Self {
        // The quotient of integers has at least len(self) + shift - len(by) bits; the last is truncated.
        let shift = (bits + 1 + by.m.bit_len()).saturating_sub(self.m.bit_len());
        Self { m: (&self.m << shift) / &by.m, e: self.e - by.e - shift as i64 }.truncate(bits + 1)
    }

    /// The root of a number that is not negative, with a relative error below 2^-(bits-1).
    pub(crate) fn sqrt(&self, bits: usize) -> Self {
        // The root of 2 bits + 2 bits has bits + 1 of them; the exponent must be even to be halved.
        let shift = (2 * bits + 2).saturating_sub(self.m.bit_len()) as i64;
        let shift = shift + (self.e - shift).rem_euclid(2);
        let (_, magnitude) = (&self.m << shift as usize).into_parts();
        Self { m: magnitude.sqrt().into(), e: (self.e - shift) / 2 }.truncate(bits + 1)
    }

    /// The nearest f64, ties to even; infinite beyond the range, and rounded twice where the result is subnormal.
    pub(crate) fn to_f64(&self) -> f64 {
        let cut = self.m.bit_len().saturating_sub(64);
        let (sign, magnitude) = self.m.clone().into_parts();
        let lost = magnitude.trailing_zeros().is_some_and(|zeros| zeros < cut);
        let top = u64::try_from(magnitude >> cut).expect("64 bits are left");
        // The last of the 64 bits is a sticky bit for all that were cut, so the conversion to 53 bits rounds correctly.
        let x = (top | u64::from(lost)) as f64;
        // 5000 is beyond any shift that matters: x is an integer below 2^65, and f64 ranges from 2^-1074 to 2^1024.
        let x = dd::ldexp(x, (self.e + cut as i64).clamp(-5000, 5000) as i32);
        if sign == Sign::Negative { -x } else { x }
    }

    /// The nearest double-double: a relative error of at most 2^-106 away from the ends of the range.
    pub(crate) fn to_dd(&self) -> Dd {
        let hi = self.to_f64();
        if !hi.is_finite() {
            return Dd::from(hi);
        }
        Dd { hi, lo: (self - &Self::of(hi)).to_f64() }
    }
}

impl From<i64> for Dyadic {
    fn from(m: i64) -> Self {
        Self { m: IBig::from(m), e: 0 }
    }
}

impl Neg for Dyadic {
    type Output = Self;
    fn neg(self) -> Self {
        Self { m: -self.m, e: self.e }
    }
}

impl Add for &Dyadic {
    type Output = Dyadic;
    fn add(self, b: Self) -> Dyadic {
        if self.is_zero() || b.is_zero() {
            return if self.is_zero() { b.clone() } else { self.clone() };
        }
        let (low, high) = if self.e <= b.e { (self, b) } else { (b, self) };
        Dyadic { m: &low.m + (&high.m << (high.e - low.e) as usize), e: low.e }
    }
}

impl Sub for &Dyadic {
    type Output = Dyadic;
    fn sub(self, b: Self) -> Dyadic {
        self + &-b.clone()
    }
}

impl Mul for &Dyadic {
    type Output = Dyadic;
    fn mul(self, b: Self) -> Dyadic {
        if self.is_zero() || b.is_zero() {
            return Dyadic::ZERO;
        }
        Dyadic { m: &self.m * &b.m, e: self.e + b.e }
    }
}

/// A vector of three exact numbers.
pub(crate) type Dyadic3 = [Dyadic; 3];

/// The f64 vector, exactly.
pub(crate) fn vector(a: [f64; 3]) -> Dyadic3 {
    a.map(Dyadic::of)
}

/// a - b
pub(crate) fn minus(a: &Dyadic3, b: &Dyadic3) -> Dyadic3 {
    std::array::from_fn(|k| &a[k] - &b[k])
}

/// a . b
pub(crate) fn dot(a: &Dyadic3, b: &Dyadic3) -> Dyadic {
    &(&(&a[0] * &b[0]) + &(&a[1] * &b[1])) + &(&a[2] * &b[2])
}

/// a x b
pub(crate) fn cross(a: &Dyadic3, b: &Dyadic3) -> Dyadic3 {
    let minor = |i: usize, j: usize| &(&a[i] * &b[j]) - &(&a[j] * &b[i]);
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENDS: [f64; 9] = [0.0, 1.0, -3.5, 0.1, 5e-324, -2.2e-308, f64::MAX, f64::MIN_POSITIVE, -1e-20];

    #[test]
    fn every_f64_goes_in_and_comes_back() {
        for x in ENDS {
            assert_eq!(Dyadic::of(x).to_f64(), x, "{x:e}");
            assert_eq!(Dyadic::of(x).sign(), x.partial_cmp(&0.0).expect("finite"), "{x:e}");
        }
    }

    #[test]
    fn sums_and_products_are_exact_over_the_whole_range() {
        for x in ENDS.map(Dyadic::of) {
            for y in ENDS.map(Dyadic::of) {
                let (sum, difference) = (&x + &y, &x - &y);
                let product = &(&x * &y).ldexp(2);
                let squares = &sum.square() - &difference.square();
                assert!((&squares - product).is_zero(), "(x+y)^2 - (x-y)^2 = 4 x y for {x:?} {y:?}");
            }
        }
    }

    #[test]
    fn rounding_to_f64_is_to_nearest_even() {
        let one = Dyadic::of(1.0);
        let step = |k: i64| &one + &Dyadic::of(1.0).ldexp(-k);
        assert_eq!(step(53).to_f64(), 1.0, "the tie goes to even");
        assert_eq!((&step(53) + &Dyadic::of(1.0).ldexp(-900)).to_f64(), 1.0 + f64::EPSILON, "just above the tie");
        assert_eq!((-(&step(53) + &Dyadic::of(1.0).ldexp(-900))).to_f64(), -1.0 - f64::EPSILON);
        let third = Dyadic::from(1).over(&Dyadic::from(3), 200).to_dd();
        assert!(((third * Dd::from(3.0)) - Dd::from(1.0)).value().abs() < 2f64.powi(-104), "{third:?}");
    }

    #[test]
    fn roots_and_quotients_keep_their_bits() {
        // The difference is at most 2^k of x.
        let near = |a: &Dyadic, x: &Dyadic, k: i64| {
            let off = (a - x).abs();
            off.is_zero() || off.magnitude() - x.magnitude() <= k
        };
        for x in [2.0, 3e-200, 1e300, 0.1, 5e-324].map(Dyadic::of) {
            for bits in [60, 61, 300] {
                let root = x.sqrt(bits);
                // (1 + e)^2 = 1 + 2 e + e^2 with |e| < 2^-(bits-1).
                assert!(near(&root.square(), &x, 3 - bits as i64), "{x:?}");
                assert!(near(&(&x.over(&root, bits) * &root), &x, 2 - bits as i64), "{x:?}");
            }
        }
        assert!(Dyadic::of(4.0).sqrt(60).to_f64() == 2.0 && Dyadic::ZERO.sqrt(60).is_zero());
    }
}
