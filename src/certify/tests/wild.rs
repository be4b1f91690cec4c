//! f32 with the worst rounding that WGSL allows: an adversary chooses every rounding.

use crate::double_double::{self as dd, Dd};
use crate::number::{Arithmetic, Number};
use crate::testing::Rng;
use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The adversary's rule for rounding inexact results.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Mode {
    /// Up, always.
    Up,
    /// Down, always.
    Down,
    /// Towards zero.
    Inward,
    /// Away from it.
    Outward,
    /// Either way at random; quotients and roots by any amount within their bound.
    Random,
    /// As chosen for each operation by [`climb`].
    Chosen,
}

impl Mode {
    pub(super) const BLIND: [Self; 5] = [Self::Up, Self::Down, Self::Inward, Self::Outward, Self::Random];
}

struct Adversary {
    mode: Mode,
    rng: Rng,
    chosen: Vec<bool>,
    count: usize,
}

thread_local! {
    static ADVERSARY: RefCell<Adversary> =
        const { RefCell::new(Adversary { mode: Mode::Random, rng: Rng(0), chosen: Vec::new(), count: 0 }) };
}

/// Runs `f` in a mode.
pub(super) fn under<T>(mode: Mode, seed: u64, f: impl FnOnce() -> T) -> T {
    ADVERSARY.with_borrow_mut(|a| (a.mode, a.rng, a.count) = (mode, Rng(seed), 0));
    f()
}

/// Coordinate ascent over all roundings: flips each choice in place if that increases `probe`. Returns the largest
/// value.
pub(super) fn climb(chosen: &mut Vec<bool>, sweeps: usize, probe: impl Fn() -> f64) -> f64 {
    let take = |chosen: &mut Vec<bool>| ADVERSARY.with_borrow_mut(|a| std::mem::swap(&mut a.chosen, chosen));
    take(chosen);
    let look = || under(Mode::Chosen, 0, &probe);
    let mut best = look();
    let count = ADVERSARY.with_borrow_mut(|a| {
        a.chosen.resize(a.count, false);
        a.count
    });
    for _ in 0..sweeps {
        let before = best;
        for k in 0..count {
            let flip = || ADVERSARY.with_borrow_mut(|a| a.chosen[k] ^= true);
            flip();
            let there = look();
            if there > best {
                best = there;
            } else {
                flip();
            }
        }
        if best == before {
            break;
        }
    }
    take(chosen);
    best
}

/// The adversary's choice for the next result, from -1 (as far down as allowed) to 1.
fn push(value: f64) -> f64 {
    ADVERSARY.with_borrow_mut(|a| {
        a.count += 1;
        match a.mode {
            Mode::Up => 1.0,
            Mode::Down => -1.0,
            Mode::Inward => -value.signum(),
            Mode::Outward => value.signum(),
            Mode::Random => 2.0 * a.rng.unit() - 1.0,
            Mode::Chosen if a.chosen.get(a.count - 1).copied().unwrap_or_default() => 1.0,
            Mode::Chosen => -1.0,
        }
    })
}

/// Subnormals may be flushed to zero.
fn flushed(x: f32) -> f32 {
    if !x.is_subnormal() {
        return x;
    }
    let flush = ADVERSARY.with_borrow_mut(|a| a.rng.bits() & 1 == 0);
    if flush { 0.0 } else { x }
}

/// The neighbour of the exact hi + lo that the adversary chooses.
fn rounded(exact: Dd) -> Wild {
    let wish = push(exact.hi);
    let near = exact.hi as f32;
    let rest = (exact.hi - f64::from(near)) + exact.lo;
    let there = match (rest > 0.0, wish > 0.0) {
        _ if rest == 0.0 => near,
        (true, true) => near.next_up(),
        (false, false) => near.next_down(),
        _ => near,
    };
    Wild(flushed(there))
}

/// A number within `ulps` of x, with the error that the adversary chooses.
fn off(x: f64, ulps: f64) -> Wild {
    let wish = push(x);
    let near = x as f32;
    if x == 0.0 || !near.is_finite() {
        return Wild(near);
    }
    let target = x + wish * ulps * dd::ldexp(1.0, dd::exponent(x) - 23);
    let there = target as f32;
    let there = match wish > 0.0 {
        true if f64::from(there) > target => there.next_down(),
        false if f64::from(there) < target => there.next_up(),
        _ => there,
    };
    Wild(flushed(there))
}

/// f32 with the adversary's roundings.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(super) struct Wild(pub(super) f32);

impl Add for Wild {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        rounded(Dd::sum(self.0.into(), b.0.into()))
    }
}

impl Sub for Wild {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        rounded(Dd::diff(self.0.into(), b.0.into()))
    }
}

impl Mul for Wild {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        // 48 bits: exact.
        rounded((f64::from(self.0) * f64::from(b.0)).into())
    }
}

impl Div for Wild {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        off(f64::from(self.0) / f64::from(b.0), 2.5)
    }
}

impl Neg for Wild {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Arithmetic for Wild {
    type Mask = bool;
    const MISS: Self = Self(f32::MAX);
    const ZERO: Self = Self(0.0);
    fn from_f32(x: f32) -> Self {
        Self(x)
    }
    fn sqrt(self) -> Self {
        // Inherited from 1/inverseSqrt: 2 ulp and 2.5 ulp.
        off(f64::from(self.0).sqrt(), 4.5)
    }
    fn less(self, b: Self) -> bool {
        self < b
    }
    fn equal(self, b: Self) -> bool {
        self == b
    }
}

impl Number for Wild {
    const ONE: Self = Self(1.0);
    fn from_hi_lo(hi: f32, _: f32) -> Self {
        Self(hi)
    }
    fn to_hi_lo(self) -> (f32, f32) {
        (self.0, 0.0)
    }
    fn from_i32(x: i32) -> Self {
        rounded(f64::from(x).into())
    }
}

/// The numbers that tests read from a twin.
pub(super) trait Value: Number {
    fn value(self) -> f64;
}

impl Value for f32 {
    fn value(self) -> f64 {
        self.into()
    }
}

impl Value for Wild {
    fn value(self) -> f64 {
        self.0.into()
    }
}

#[test]
fn the_adversary_stays_within_the_specification() {
    let mut rng = Rng(7);
    for n in 0..20_000 {
        let mut number = || Wild((rng.decade(-8.0, 8.0) * rng.sign()) as f32);
        let (a, b) = (number(), number());
        let (x, y) = (a.value(), b.value());
        for mode in Mode::BLIND {
            let [sum, product, quotient, root] = under(mode, n, || [a + b, a * b, a / b, (a * a).sqrt()]);
            // A neighbour: less than one ulp off.
            let ulp = |x: f64| dd::ldexp(1.0, dd::exponent(x) - 23);
            assert!((sum.value() - (x + y)).abs() < ulp(x + y) * 1.000_001, "{x:e} + {y:e}");
            assert!((product.value() - x * y).abs() < ulp(x * y) * 1.000_001, "{x:e} * {y:e}");
            assert!((quotient.value() - x / y).abs() <= 2.500_001 * ulp(x / y), "{x:e} / {y:e}");
            assert!((root.value() / x.abs() - 1.0).abs() <= 5.6 / f64::from(1 << 23), "sqrt({x:e}^2)");
        }
    }
    assert_eq!(under(Mode::Up, 0, || Wild(3.0) * Wild(0.25) + Wild(1.0)), Wild(1.75), "exact results stay");
    assert_eq!(under(Mode::Up, 0, || Wild::from_i32((1 << 24) + 1)), Wild(16_777_218.0));
}
