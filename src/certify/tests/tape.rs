//! Numbers that record their computation, and the largest error that all roundings together can cause.
//!
//! The twins run on [`Traced`] numbers and record a graph of operations. In a second evaluation each operation has an
//! independent rounding: out(e_1, e_2, ...) with |e_i| at most a number of units. To first order their largest effect
//! is the sum of |d out / d e_i| times those units, which one backward pass computes exactly. An adversary that samples
//! roundings comes near it only by chance.
//!
//! WGSL may evaluate a sum in any order and fuse products into it. Therefore nested sums are split into their terms and
//! added along a random tree; each product in a sum may lose its rounding.

use crate::number::{Arithmetic, Number};
use crate::testing::Rng;
use std::cell::RefCell;
use std::cmp::Ordering;
use std::collections::HashMap;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The operation that computed a number, with the indices of its operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Op {
    /// The bits of a given f32: a constant, or a number of a record.
    Known(u32),
    /// A number with its own error.
    Input(u32),
    Whole(i32),
    Add(u32, u32),
    Sub(u32, u32),
    Mul(u32, u32),
    Div(u32, u32),
    Neg(u32),
    Sqrt(u32),
}

#[derive(Default)]
struct Tape {
    ops: Vec<(Op, f64)>,
    /// Equal operations on equal numbers share an entry.
    known: HashMap<Op, u32>,
}

thread_local! {
    static TAPE: RefCell<Tape> = RefCell::default();
}

/// A number on the tape of this thread: its index, or one of the constants, which are not on a tape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Traced(u32);

/// The indices of the constants of [`Number`].
const CONSTANTS: [(u32, f32); 3] = [(u32::MAX, f32::MAX), (u32::MAX - 1, 0.0), (u32::MAX - 2, 1.0)];

/// Clears the tape.
pub(super) fn rewind() {
    TAPE.take();
}

/// The operation of the number at an index, and its value without rounding.
fn made(place: u32) -> (Op, f64) {
    let constant = CONSTANTS.into_iter().find(|constant| constant.0 == place);
    match constant {
        Some((_, x)) => (Op::Known(x.to_bits()), x.into()),
        None => TAPE.with_borrow(|tape| tape.ops[place as usize]),
    }
}

impl Traced {
    fn push(op: Op, value: f64) -> Self {
        TAPE.with_borrow_mut(|tape| {
            if let Some(place) = tape.known.get(&op) {
                return Self(*place);
            }
            let place = tape.ops.len() as u32;
            tape.ops.push((op, value));
            tape.known.insert(op, place);
            Self(place)
        })
    }

    /// A number with an independent error.
    pub(super) fn input(value: f32) -> Self {
        let count = TAPE.with_borrow(|tape| tape.ops.len() as u32);
        Self::push(Op::Input(count), value.into())
    }

    /// The value without rounding.
    pub(super) fn real(self) -> f64 {
        made(self.0).1
    }
}

impl PartialEq for Traced {
    fn eq(&self, other: &Self) -> bool {
        self.real() == other.real()
    }
}

impl PartialOrd for Traced {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.real().partial_cmp(&other.real())
    }
}

impl Add for Traced {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self::push(Op::Add(self.0, b.0), self.real() + b.real())
    }
}

impl Sub for Traced {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self::push(Op::Sub(self.0, b.0), self.real() - b.real())
    }
}

impl Mul for Traced {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Self::push(Op::Mul(self.0, b.0), self.real() * b.real())
    }
}

impl Div for Traced {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        Self::push(Op::Div(self.0, b.0), self.real() / b.real())
    }
}

impl Neg for Traced {
    type Output = Self;
    fn neg(self) -> Self {
        Self::push(Op::Neg(self.0), -self.real())
    }
}

impl Arithmetic for Traced {
    type Mask = bool;
    const MISS: Self = Self(CONSTANTS[0].0);
    const ZERO: Self = Self(CONSTANTS[1].0);
    fn from_f32(x: f32) -> Self {
        Self::push(Op::Known(x.to_bits()), x.into())
    }
    fn sqrt(self) -> Self {
        Self::push(Op::Sqrt(self.0), self.real().sqrt())
    }
    fn less(self, b: Self) -> bool {
        self < b
    }
    fn equal(self, b: Self) -> bool {
        self == b
    }
}

impl Number for Traced {
    const ONE: Self = Self(CONSTANTS[2].0);
    fn from_hi_lo(hi: f32, _: f32) -> Self {
        Self::from_f32(hi)
    }
    fn to_hi_lo(self) -> (f32, f32) {
        (self.real() as f32, 0.0)
    }
    fn from_i32(x: i32) -> Self {
        Self::push(Op::Whole(x), x.into())
    }
}

/// The errors of the given numbers, in units.
#[derive(Default, Clone)]
pub(super) struct Given {
    inputs: HashMap<u32, f64>,
    known: HashMap<u32, f64>,
}

impl Given {
    /// From here on the error of this number is so many units, whatever it was computed from.
    pub(super) fn set(&mut self, number: Traced, units: f64) {
        self.inputs.insert(number.0, units);
    }

    /// From here on the numbers `exact` have no error, and the numbers `off` an error of one unit, whatever they were
    /// computed from.
    pub(super) fn fix(&mut self, exact: &[Traced], off: &[Traced]) {
        exact.iter().for_each(|number| self.set(*number, 0.0));
        off.iter().for_each(|number| self.set(*number, 1.0));
    }

    /// Sets the error of every use of this number of a record.
    pub(super) fn set_known(&mut self, number: f32, units: f64) {
        // A power of two was not rounded, and may be equal to a constant of the kernel.
        if number.to_bits() << 9 != 0 {
            self.known.insert(number.to_bits(), units);
        }
    }
}

/// An operation, or a given number.
struct Step {
    value: f64,
    /// The steps of its operands, and its derivatives by them.
    of: [(usize, f64); 2],
    /// Its relative error, in units.
    units: f64,
}

/// One way to compute some numbers: an order for every sum.
pub(super) struct Program<'a> {
    given: &'a Given,
    /// `None`: the order of the source.
    rng: Option<Rng>,
    steps: Vec<Step>,
    done: HashMap<u32, usize>,
}

const NOTHING: (usize, f64) = (0, 0.0);

impl<'a> Program<'a> {
    pub(super) fn new(given: &'a Given, rng: Option<Rng>) -> Self {
        Self { given, rng, steps: Vec::new(), done: HashMap::new() }
    }

    fn step(&mut self, value: f64, of: [(usize, f64); 2], units: f64) -> usize {
        self.steps.push(Step { value, of, units });
        self.steps.len() - 1
    }

    fn value(&self, step: usize) -> f64 {
        self.steps[step].value
    }

    /// Computes the number.
    pub(super) fn compute(&mut self, number: Traced) -> usize {
        if let Some(step) = self.done.get(&number.0) {
            return *step;
        }
        let step = self.made(number.0, 1.0);
        self.done.insert(number.0, step);
        step
    }

    /// Computes the number at an index; `rounded` is the error of a product, 0 if it is fused.
    fn made(&mut self, place: u32, rounded: f64) -> usize {
        let (op, value) = made(place);
        if let Some(units) = self.given.inputs.get(&place) {
            return self.step(value, [NOTHING; 2], *units);
        }
        let mut of = |place: u32| self.compute(Traced(place));
        match op {
            Op::Known(bits) => {
                let units = self.given.known.get(&bits).copied().unwrap_or_default();
                self.step(value, [NOTHING; 2], units)
            }
            Op::Input(_) => self.step(value, [NOTHING; 2], 0.0),
            // Beyond 2^24 an integer is rounded.
            Op::Whole(n) => self.step(value, [NOTHING; 2], f64::from(n.unsigned_abs() > 1 << 24)),
            Op::Mul(a, b) => {
                let power = |place: u32| matches!(made(place).0, Op::Known(bits) if bits << 9 == 0);
                let units = if power(a) || power(b) { 0.0 } else { rounded };
                let (x, y) = (of(a), of(b));
                let of = [(x, self.value(y)), (y, self.value(x))];
                self.step(self.value(x) * self.value(y), of, units)
            }
            Op::Div(a, b) => {
                let (x, y) = (of(a), of(b));
                let (over, value) = (1.0 / self.value(y), self.value(x) / self.value(y));
                self.step(value, [(x, over), (y, -value * over)], 2.5)
            }
            Op::Sqrt(a) => {
                let x = of(a);
                let root = self.value(x).sqrt();
                // The root of zero has no derivative; another bound covers an error under it.
                let slope = if root > 0.0 { 0.5 / root } else { 0.0 };
                self.step(root, [(x, slope), NOTHING], 4.6)
            }
            Op::Neg(_) | Op::Add(..) | Op::Sub(..) => self.sum(place),
        }
    }

    /// A sum along a random tree of all its terms, or in the order of the source.
    fn sum(&mut self, place: u32) -> usize {
        let mut terms = Vec::new();
        let whole = self.rng.is_some();
        self.terms(place, 1.0, whole, &mut terms);
        let mut parts: Vec<(usize, f64)> = terms
            .into_iter()
            .map(|(term, sign)| {
                let product = matches!(made(term).0, Op::Mul(..)) && !self.given.inputs.contains_key(&term);
                let fused = product && self.rng.as_mut().is_some_and(|rng| rng.below(8) == 0);
                (if fused { self.made(term, 0.0) } else { self.compute(Traced(term)) }, sign)
            })
            .collect();
        while parts.len() > 1 {
            let mut any = |n: usize| self.rng.as_mut().map_or(n - 1, |rng| rng.below(n as u32) as usize);
            let (x, p) = {
                let n = any(parts.len());
                parts.swap_remove(n)
            };
            let (y, q) = {
                let n = any(parts.len());
                parts.swap_remove(n)
            };
            // A sum with zero is not rounded.
            let units = f64::from(self.value(x) != 0.0 && self.value(y) != 0.0);
            let step = self.step(p * self.value(x) + q * self.value(y), [(x, p), (y, q)], units);
            parts.push((step, 1.0));
        }
        match parts[..] {
            [(x, sign)] if sign < 0.0 => self.step(-self.value(x), [(x, -1.0), NOTHING], 0.0),
            [(x, _)] => x,
            _ => unreachable!("a sum has terms"),
        }
    }

    /// The terms of a sum with their signs; if `whole`, nested sums are split too.
    fn terms(&self, place: u32, sign: f64, whole: bool, to: &mut Vec<(u32, f64)>) {
        let mut next = |program: &Self, part: u32, sign: f64| match made(part).0 {
            Op::Neg(_) | Op::Add(..) | Op::Sub(..) if whole && !program.given.inputs.contains_key(&part) => {
                program.terms(part, sign, whole, to);
            }
            _ => to.push((part, sign)),
        };
        match made(place).0 {
            Op::Neg(a) => next(self, a, -sign),
            Op::Add(a, b) => [a, b].into_iter().for_each(|part| next(self, part, sign)),
            Op::Sub(a, b) => {
                next(self, a, sign);
                next(self, b, -sign);
            }
            _ => to.push((place, sign)),
        }
    }

    /// d(the sum of these numbers times their factors) / d(each step).
    fn slopes(&self, of: &[(usize, f64)]) -> Vec<f64> {
        let mut slopes = vec![0.0; self.steps.len()];
        of.iter().for_each(|(step, factor)| slopes[*step] += factor);
        for n in (0..self.steps.len()).rev() {
            for (part, slope) in self.steps[n].of {
                slopes[part] += slope * slopes[n];
            }
        }
        slopes
    }

    /// The largest error of the vector of these combinations of numbers: the sum over all roundings of the length of
    /// the error vector that each of them causes, in units.
    pub(super) fn worst<const N: usize>(&self, of: [&[(usize, f64)]; N]) -> f64 {
        let slopes = of.map(|of| self.slopes(of));
        let each = self.steps.iter().enumerate().filter(|(_, step)| step.units > 0.0);
        let length = |n: usize| slopes.iter().map(|slopes| slopes[n] * slopes[n]).sum::<f64>().sqrt();
        each.map(|(n, step)| length(n) * step.value.abs() * step.units).sum()
    }
}

#[test]
fn all_roundings_of_a_sum_of_products_are_counted() {
    rewind();
    let [a, b, c] = [3.0, -5.0, 7.0].map(Traced::input);
    let sum = a * b + c;
    let given = Given::default();
    let mut program = Program::new(&given, None);
    let out = program.compute(sum);
    // The product, 15, and the sum, 8.
    assert_eq!(program.worst([&[(out, 1.0)]]), 23.0);
    let mut given = Given::default();
    given.set(b, 0.5);
    let mut program = Program::new(&given, None);
    let out = program.compute(sum);
    assert_eq!(program.worst([&[(out, 1.0)]]), 23.0 + 7.5, "half a unit of b is half a unit of the product");
}

#[test]
fn some_order_of_a_sum_rounds_the_large_terms_first() {
    rewind();
    let [a, b, c] = [100.0, 1.0, -100.0].map(Traced::input);
    let sum = a + b + c;
    let given = Given::default();
    let mut found = Vec::new();
    for n in 0..40 {
        let mut program = Program::new(&given, Some(Rng(n)));
        let out = program.compute(sum);
        found.push(program.worst([&[(out, 1.0)]]));
    }
    // (100 - 100) + 1, where nothing is rounded, and the two other trees.
    assert!([0.0, 102.0, 100.0].iter().all(|worst| found.contains(worst)), "{found:?}");
}
