//! Number types of the CPU twins: one body of code, several arithmetics, of one number or of a vector.

pub mod vector;

pub use crate::double_double::exponent;

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Truth values: one for each number that was compared.
pub trait Truth: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Whether any of them is true.
    fn any(self) -> bool;
}

/// Truth values that choose numbers.
pub trait Mask<R>: Truth {
    /// `yes` where it is true, else `no`.
    fn pick(self, yes: R, no: R) -> R;
}

impl Truth for bool {
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

/// What the forms compute with: a [`Number`], or a vector of them, each rounded as if alone.
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

/// A number type for the CPU twins of the kernels. f32 equals the device bit for bit where the device rounds as IEEE 754
/// does.
pub trait Number: Arithmetic<Mask = bool> + PartialOrd {
    /// 1/2.
    const HALF: Self;
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
    fn from_i32(x: i32) -> Self;

    /// |x|
    fn abs(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }
}

impl Arithmetic for f32 {
    type Mask = bool;
    const MISS: Self = f32::MAX;
    const ZERO: Self = 0.0;
    #[inline(always)]
    fn from_f32(x: f32) -> Self {
        x
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

impl Number for f32 {
    const HALF: Self = 0.5;
    const ONE: Self = 1.0;
    fn from_i32(x: i32) -> Self {
        x as f32
    }
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

impl Arithmetic for f64 {
    type Mask = bool;
    const MISS: Self = f32::MAX as f64;
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

impl Number for f64 {
    const HALF: Self = 0.5;
    const ONE: Self = 1.0;
    fn from_i32(x: i32) -> Self {
        x.into()
    }
    fn from_hi_lo(hi: f32, lo: f32) -> Self {
        f64::from(hi) + f64::from(lo)
    }
    fn to_hi_lo(self) -> (f32, f32) {
        let hi = self as f32;
        (hi, (self - f64::from(hi)) as f32)
    }
}
