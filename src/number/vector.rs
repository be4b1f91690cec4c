//! Eight numbers at once. Every operation is written out for each lane, without branches, which the compiler turns into vector
//! instructions where it is compiled for them (`pulp::Arch::dispatch`). Vector and scalar operations round alike.
//!
//! No loops: a function of double-doubles would have thousands of them, whose rotation and unrolling took two thirds of the time
//! to compile this crate. Masks of bits instead of truth values: of `bool` the compiler makes scalar code.

use super::{Arithmetic, Fused, Mask, Number, TruthValue, ldexp};
use bytemuck::Pod;
use pulp::cast;
use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// Numbers in a vector.
pub const LANES: usize = 8;

/// Numbers in a vector of f32 where the processor has vectors of 512 bits.
pub const WIDE: usize = 2 * LANES;

/// Evaluates an expression with the processor's widest vectors. Functions that it calls must be inlined into it.
macro_rules! vectorized {
    ($work:expr) => {
        crate::number::vector::dispatch(
            #[inline(always)]
            move || $work,
        )
    };
}
pub(crate) use vectorized;

/// Calls `work` with these vectors. `FnOnce` in the bound makes the closure one that is called once; else it would be called by
/// a function between, compiled without them.
#[inline(always)]
pub(crate) fn dispatch<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// Eight numbers, or their bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vector<T>(pub [T; LANES]);

/// The bits of a number, as wide as the number.
pub trait Bits:
    Pod
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Not<Output = Self>
    + PartialEq
    + Debug
    + Send
    + Sync
{
    /// All of them where `yes`, else none.
    fn all_if(yes: bool) -> Self;
    /// All bits or no bits, in 32.
    fn narrow(self) -> u32;
}

/// A number that fits into a lane.
pub trait Lane: Number + Debug + Pod {
    /// Its bits.
    type Bits: Bits;
}

macro_rules! lane {
    ($number:ty, $bits:ty) => {
        impl Lane for $number {
            type Bits = $bits;
        }

        impl Bits for $bits {
            #[inline(always)]
            fn all_if(yes: bool) -> Self {
                Self::from(yes).wrapping_neg()
            }
            #[inline(always)]
            fn narrow(self) -> u32 {
                self as u32
            }
        }
    };
}
lane!(f32, u32);
lane!(f64, u64);

/// An array of the values of an expression for each lane.
macro_rules! each {
    ($lane:ident => $value:expr) => {
        each!($lane => $value; 0 1 2 3 4 5 6 7)
    };
    ($lane:ident => $value:expr; $($number:literal)*) => {
        [$({
            const $lane: usize = $number;
            $value
        }),*]
    };
}

macro_rules! by_lanes {
    ($($operator:ident $method:ident $sign:tt)*) => {$(
        impl<T: $operator<Output = T> + Copy> $operator for Vector<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                Self(each!(L => self.0[L] $sign b.0[L]))
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

macro_rules! each_lane {
    ($($operator:ident $method:ident $sign:tt)*) => {$(
        impl<T: $operator<Output = T> + Copy> $operator for Vector<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self) -> Self {
                Self(each!(L => $sign self.0[L]))
            }
        }
    )*};
}
each_lane! {
    Neg neg -
    Not not !
}

impl<B: Bits> TruthValue for Vector<B> {
    #[inline(always)]
    fn any(self) -> bool {
        let mut any = 0;
        for l in 0..LANES {
            any |= self.0[l].narrow();
        }
        any != 0
    }
}

/// `yes` where the bits are set, else `no`.
#[inline(always)]
pub fn pick<T: Lane>(bits: T::Bits, yes: T, no: T) -> T {
    let (yes, other): (T::Bits, T::Bits) = (cast(yes), cast(no));
    cast(other ^ ((other ^ yes) & bits))
}

impl<T: Lane> Mask<Vector<T>> for Vector<T::Bits> {
    #[inline(always)]
    fn pick(self, yes: Vector<T>, no: Vector<T>) -> Vector<T> {
        Vector(each!(L => pick(self.0[L], yes.0[L], no.0[L])))
    }
}

impl<T: Lane> Vector<T> {
    #[inline(always)]
    fn compare(self, b: Self, holds: impl Fn(&T, &T) -> bool) -> Vector<T::Bits> {
        Vector(each!(L => T::Bits::all_if(holds(&self.0[L], &b.0[L]))))
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
    fn sqrt(self) -> Self {
        Self(each!(L => self.0[L].sqrt()))
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

impl Fused for Vector<f64> {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([x; LANES])
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(each!(L => self.0[L].mul_add(a.0[L], b.0[L])))
    }
    #[inline(always)]
    fn ldexp(self, k: i32) -> Self {
        Self(each!(L => ldexp(self.0[L], k)))
    }
}

/// A number that a method computes eight at a time.
pub trait Laned: Number {
    /// Eight of these numbers.
    type Vector: Arithmetic;
    /// This number in every lane.
    fn splat(self) -> Self::Vector;
    /// These numbers.
    fn gather(numbers: [Self; LANES]) -> Self::Vector;
    /// The number in a lane.
    fn lane(numbers: &Self::Vector, lane: usize) -> Self;
    /// Truth values in 32 bits.
    fn narrow(mask: <Self::Vector as Arithmetic>::Mask) -> Vector<u32>;
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
    fn narrow(mask: Vector<T::Bits>) -> Vector<u32> {
        Vector(each!(L => mask.0[L].narrow()))
    }
}
