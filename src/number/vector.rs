//! Eight numbers at once. Every operation is a loop without branches, which the compiler turns into vector instructions
//! where it is compiled for them (`pulp::Arch::dispatch`). Vector and scalar operations round alike.
//!
//! Loops over indices, and masks of bits instead of truth values: of iterators and of `bool` the compiler makes scalar
//! code.

use super::{Arithmetic, Mask, Number, Truth};
use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// Numbers in a vector.
pub const LANES: usize = 8;

/// Eight numbers, or their bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vector<T>(pub [T; LANES]);

/// The bits of a number, as wide as the number.
pub trait Bits:
    Copy
    + Default
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Not<Output = Self>
    + PartialEq
    + Debug
    + Send
    + Sync
    + 'static
{
    /// All of them where `yes`, else none.
    fn all_if(yes: bool) -> Self;
    /// All bits or no bits, in 32.
    fn narrow(self) -> u32;
    /// All bits or no bits, from 32.
    fn widen(bits: u32) -> Self;
}

impl Bits for u32 {
    #[inline(always)]
    fn all_if(yes: bool) -> Self {
        u32::from(yes).wrapping_neg()
    }
    #[inline(always)]
    fn narrow(self) -> u32 {
        self
    }
    #[inline(always)]
    fn widen(bits: u32) -> Self {
        bits
    }
}

impl Bits for u64 {
    #[inline(always)]
    fn all_if(yes: bool) -> Self {
        u64::from(yes).wrapping_neg()
    }
    #[inline(always)]
    fn narrow(self) -> u32 {
        self as u32
    }
    #[inline(always)]
    fn widen(bits: u32) -> Self {
        i64::from(bits as i32) as u64
    }
}

/// A number that fits into a lane.
pub trait Lane: Number + Debug {
    /// Its bits.
    type Bits: Bits;
    /// Its bits.
    fn bits(self) -> Self::Bits;
    /// The number with these bits.
    fn of_bits(bits: Self::Bits) -> Self;
    /// The nearest f32.
    fn nearest_f32(self) -> f32;
}

impl Lane for f32 {
    type Bits = u32;
    #[inline(always)]
    fn bits(self) -> u32 {
        self.to_bits()
    }
    #[inline(always)]
    fn of_bits(bits: u32) -> Self {
        f32::from_bits(bits)
    }
    #[inline(always)]
    fn nearest_f32(self) -> f32 {
        self
    }
}

impl Lane for f64 {
    type Bits = u64;
    #[inline(always)]
    fn bits(self) -> u64 {
        self.to_bits()
    }
    #[inline(always)]
    fn of_bits(bits: u64) -> Self {
        f64::from_bits(bits)
    }
    #[inline(always)]
    fn nearest_f32(self) -> f32 {
        self as f32
    }
}

macro_rules! by_lanes {
    ($($operator:ident $method:ident $sign:tt)*) => {$(
        impl<T: $operator<Output = T> + Copy> $operator for Vector<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, b: Self) -> Self {
                for l in 0..LANES {
                    self.0[l] = self.0[l] $sign b.0[l];
                }
                self
            }
        }
    )*};
}
by_lanes! {
    Add add +
    Sub sub -
    Mul mul *
    Div div /
    BitAnd bitand &
    BitOr bitor |
}

impl<T: Neg<Output = T> + Copy> Neg for Vector<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for l in 0..LANES {
            self.0[l] = -self.0[l];
        }
        self
    }
}

impl<T: Not<Output = T> + Copy> Not for Vector<T> {
    type Output = Self;
    #[inline(always)]
    fn not(mut self) -> Self {
        for l in 0..LANES {
            self.0[l] = !self.0[l];
        }
        self
    }
}

impl Vector<u32> {
    /// Where they are above `number`.
    #[inline(always)]
    pub fn above(self, number: u32) -> Self {
        let mut mask = Self([0; LANES]);
        for l in 0..LANES {
            mask.0[l] = u32::all_if(self.0[l] > number);
        }
        mask
    }
}

impl<B: Bits> Truth for Vector<B> {
    #[inline(always)]
    fn any(self) -> bool {
        let mut any = 0;
        for l in 0..LANES {
            any |= self.0[l].narrow();
        }
        any != 0
    }
}

impl<T: Lane> Mask<Vector<T>> for Vector<T::Bits> {
    #[inline(always)]
    fn pick(self, yes: Vector<T>, mut no: Vector<T>) -> Vector<T> {
        for l in 0..LANES {
            let bits = no.0[l].bits();
            no.0[l] = T::of_bits(bits ^ ((bits ^ yes.0[l].bits()) & self.0[l]));
        }
        no
    }
}

impl<T: Lane> Vector<T> {
    #[inline(always)]
    fn compare(self, b: Self, holds: impl Fn(&T, &T) -> bool) -> Vector<T::Bits> {
        let mut mask = Vector([T::Bits::default(); LANES]);
        for l in 0..LANES {
            mask.0[l] = T::Bits::all_if(holds(&self.0[l], &b.0[l]));
        }
        mask
    }
}

impl<T: Lane> Arithmetic for Vector<T> {
    type Mask = Vector<T::Bits>;
    const MISS: Self = Self([T::MISS; LANES]);
    const ZERO: Self = Self([T::ZERO; LANES]);
    #[inline(always)]
    fn from_f32(x: f32) -> Self {
        Self([T::from_f32(x); LANES])
    }
    #[inline(always)]
    fn sqrt(mut self) -> Self {
        for l in 0..LANES {
            self.0[l] = self.0[l].sqrt();
        }
        self
    }
    #[inline(always)]
    fn less(self, b: Self) -> Self::Mask {
        self.compare(b, T::lt)
    }
    #[inline(always)]
    fn equal(self, b: Self) -> Self::Mask {
        self.compare(b, T::eq)
    }
}

/// A number of which a method computes eight at once.
pub trait Laned: Number {
    /// Eight of these numbers.
    type Vector: Arithmetic;
    /// This number in every lane.
    fn splat(self) -> Self::Vector;
    /// These numbers.
    fn gather(numbers: [Self; LANES]) -> Self::Vector;
    /// The number in a lane.
    fn lane(numbers: &Self::Vector, lane: usize) -> Self;
    /// The nearest f32 of each.
    fn nearest_f32(numbers: &Self::Vector) -> Vector<f32>;
    /// Truth values in 32 bits.
    fn narrow(mask: <Self::Vector as Arithmetic>::Mask) -> Vector<u32>;
    /// Truth values from 32 bits.
    fn widen(narrow: Vector<u32>) -> <Self::Vector as Arithmetic>::Mask;
}

impl<T: Lane> Laned for T {
    type Vector = Vector<T>;
    #[inline(always)]
    fn splat(self) -> Vector<T> {
        Vector([self; LANES])
    }
    #[inline(always)]
    fn gather(numbers: [Self; LANES]) -> Vector<T> {
        Vector(numbers)
    }
    #[inline(always)]
    fn lane(numbers: &Vector<T>, lane: usize) -> Self {
        numbers.0[lane]
    }
    #[inline(always)]
    fn nearest_f32(numbers: &Vector<T>) -> Vector<f32> {
        let mut nearest = Vector([0.0; LANES]);
        for l in 0..LANES {
            nearest.0[l] = numbers.0[l].nearest_f32();
        }
        nearest
    }
    #[inline(always)]
    fn narrow(mask: Vector<T::Bits>) -> Vector<u32> {
        let mut narrow = Vector([0; LANES]);
        for l in 0..LANES {
            narrow.0[l] = mask.0[l].narrow();
        }
        narrow
    }
    #[inline(always)]
    fn widen(narrow: Vector<u32>) -> Vector<T::Bits> {
        let mut wide = Vector([T::Bits::default(); LANES]);
        for l in 0..LANES {
            wide.0[l] = T::Bits::widen(narrow.0[l]);
        }
        wide
    }
}
