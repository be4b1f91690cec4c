//! Number types of the CPU twins: one body of code, several arithmetics, of one number or of a vector.

pub mod vector;

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Truth values: one for each number that was compared.
pub trait TruthValue: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Whether any of them is true.
    fn any(self) -> bool;
}

/// Truth values that choose numbers.
pub trait Mask<R>: TruthValue {
    /// `yes` where it is true, else `no`.
    fn pick(self, yes: R, no: R) -> R;
}

impl TruthValue for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}

impl<R> Mask<R> for bool {
    #[inline(always)]
    fn pick(self, yes: R, no: R) -> R {
        if self { yes } else { no }
    }
}

/// The numbers that the forms compute with: a [`Number`], or a vector of them, each rounded as if alone.
pub trait Arithmetic:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// The result of a comparison.
    type Mask: Mask<Self>;
    /// t of a ray that hits nothing: the largest finite f32, as in math.wgsl.
    const MISS: Self;
    /// 0.
    const ZERO: Self;
    /// This f32, exactly.
    fn from_f32(x: f32) -> Self;
    /// Times a power of two.
    #[inline(always)]
    fn scaled(self, power: Self) -> Self {
        self * power
    }
    /// Square root.
    fn sqrt(self) -> Self;
    /// self < b
    fn less(self, b: Self) -> Self::Mask;
    /// self = b
    fn equal(self, b: Self) -> Self::Mask;
}

/// Numbers of f64 for error-free transforms.
pub(crate) trait Fused: Arithmetic {
    /// This number in every lane.
    fn splat(x: f64) -> Self;
    /// self a + b, rounded once.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// Times 2^k; see [`ldexp`].
    fn ldexp(self, k: i32) -> Self;
    /// self <= b
    #[inline(always)]
    fn at_most(self, b: Self) -> Self::Mask {
        self.less(b) | self.equal(b)
    }
    /// |self|
    #[inline(always)]
    fn abs(self) -> Self {
        self.less(Self::ZERO).pick(-self, self)
    }
}

impl Fused for f64 {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self.mul_add(a, b)
    }
    #[inline(always)]
    fn ldexp(self, k: i32) -> Self {
        ldexp(self, k)
    }
}

/// A number type for the CPU twins of the kernels. f32 equals the device bit for bit where the device rounds as IEEE 754
/// does.
pub trait Number: Arithmetic<Mask = bool> + PartialOrd {
    /// 1.
    const ONE: Self;
    /// hi plus its rounding error lo, as far as this arithmetic holds them.
    fn from_hi_lo(hi: f32, lo: f32) -> Self;
    /// The nearest f32, and the f32 nearest to the remainder.
    fn to_hi_lo(self) -> (f32, f32);
    /// a minus b times a power of two, each in two parts.
    fn difference(a: [f32; 2], b: [f32; 2], power: f32) -> Self {
        Self::from_hi_lo(a[0], a[1]) - Self::from_hi_lo(b[0], b[1]).scaled(Self::from_f32(power))
    }
    /// This integer, rounded once.
    #[inline(always)]
    fn from_i32(x: i32) -> Self {
        let hi = x as f32;
        Self::from_hi_lo(hi, (f64::from(x) - f64::from(hi)) as f32)
    }

    /// |x|
    fn abs(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }
}

macro_rules! arithmetic {
    ($($number:ty)*) => {$(
        impl Arithmetic for $number {
            type Mask = bool;
            const MISS: Self = f32::MAX as Self;
            const ZERO: Self = 0.0;
            #[inline(always)]
            fn from_f32(x: f32) -> Self {
                x.into()
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn less(self, b: Self) -> bool {
                self < b
            }
            #[inline(always)]
            fn equal(self, b: Self) -> bool {
                self == b
            }
        }
    )*};
}
arithmetic! { f32 f64 }

impl Number for f32 {
    const ONE: Self = 1.0;
    fn from_hi_lo(hi: f32, _: f32) -> Self {
        hi
    }
    fn to_hi_lo(self) -> (f32, f32) {
        (self, 0.0)
    }
    /// The large parts are subtracted first and the small ones added to the difference, so that two far things near each other
    /// keep their distance.
    fn difference(a: [f32; 2], b: [f32; 2], power: f32) -> Self {
        (a[0] - power * b[0]) + (a[1] - power * b[1])
    }
}

impl Number for f64 {
    const ONE: Self = 1.0;
    fn from_hi_lo(hi: f32, lo: f32) -> Self {
        f64::from(hi) + f64::from(lo)
    }
    fn to_hi_lo(self) -> (f32, f32) {
        let hi = self as f32;
        (hi, (self - f64::from(hi)) as f32)
    }
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

/// 2^k for normal results.
pub(crate) const fn power_of_two(k: i64) -> f64 {
    f64::from_bits(((k + 1023) as u64) << 52)
}

/// The larger; of NaN the second. Without the treatment of NaN of `max`, which compilers make no vectors of.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller; of NaN the second.
#[inline(always)]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

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
