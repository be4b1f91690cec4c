//! The numbers of the CPU twins: one body of code, several arithmetics.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number type for the twins of the kernels. f32 mirrors the device bit for bit where the device rounds as IEEE does.
pub trait Real:
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
    /// t of a ray that hits nothing: the largest finite f32, as in ray.wgsl.
    const MISS: Self;
    /// 0.
    const ZERO: Self;
    /// 1/2.
    const HALF: Self;
    /// 1.
    const ONE: Self;
    /// Exactly this number.
    fn exact(x: f32) -> Self;
    /// hi and what rounding took from it, as far as this arithmetic can hold it.
    fn pair(hi: f32, lo: f32) -> Self;
    /// The nearest f32, and the f32 nearest to what it lacks.
    fn parts(self) -> (f32, f32);
    /// Times a power of two.
    fn scaled(self, power: Self) -> Self {
        self * power
    }
    /// This integer, rounded once.
    fn whole(x: i32) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;

    /// |x|
    fn abs(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }
}

impl Real for f32 {
    const MISS: Self = f32::MAX;
    const ZERO: Self = 0.0;
    const HALF: Self = 0.5;
    const ONE: Self = 1.0;
    fn exact(x: f32) -> Self {
        x
    }
    fn whole(x: i32) -> Self {
        x as f32
    }
    fn pair(hi: f32, _: f32) -> Self {
        hi
    }
    fn parts(self) -> (f32, f32) {
        (self, 0.0)
    }
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

impl Real for f64 {
    const MISS: Self = f32::MAX as f64;
    const ZERO: Self = 0.0;
    const HALF: Self = 0.5;
    const ONE: Self = 1.0;
    fn exact(x: f32) -> Self {
        x.into()
    }
    fn whole(x: i32) -> Self {
        x.into()
    }
    fn pair(hi: f32, lo: f32) -> Self {
        f64::from(hi) + f64::from(lo)
    }
    fn parts(self) -> (f32, f32) {
        let hi = self as f32;
        (hi, (self - f64::from(hi)) as f32)
    }
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}
