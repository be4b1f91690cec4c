//! Number types of the CPU twins: one body of code, several arithmetics.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number type for the CPU twins of the kernels. f32 equals the device bit for bit where the device rounds as IEEE 754
/// does.
pub trait Number:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// t of a ray that hits nothing: the largest finite f32, as in math.wgsl.
    const MISS: Self;
    /// 0.
    const ZERO: Self;
    /// 1/2.
    const HALF: Self;
    /// 1.
    const ONE: Self;
    /// This f32, exactly.
    fn from_f32(x: f32) -> Self;
    /// hi plus its rounding error lo, as far as this arithmetic holds them.
    fn from_hi_lo(hi: f32, lo: f32) -> Self;
    /// The nearest f32, and the f32 nearest to the remainder.
    fn to_hi_lo(self) -> (f32, f32);
    /// Times a power of two.
    fn scaled(self, power: Self) -> Self {
        self * power
    }
    /// a minus b times a power of two, each in two parts.
    fn difference(a: [f32; 2], b: [f32; 2], power: f32) -> Self {
        Self::from_hi_lo(a[0], a[1]) - Self::from_hi_lo(b[0], b[1]).scaled(Self::from_f32(power))
    }
    /// This integer, rounded once.
    fn from_i32(x: i32) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;

    /// |x|
    fn abs(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }
}

impl Number for f32 {
    const MISS: Self = f32::MAX;
    const ZERO: Self = 0.0;
    const HALF: Self = 0.5;
    const ONE: Self = 1.0;
    fn from_f32(x: f32) -> Self {
        x
    }
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
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

impl Number for f64 {
    const MISS: Self = f32::MAX as f64;
    const ZERO: Self = 0.0;
    const HALF: Self = 0.5;
    const ONE: Self = 1.0;
    fn from_f32(x: f32) -> Self {
        x.into()
    }
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
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}
