//! The random generator of all tests: the generator of the library's suites, extended by random integers.

use halfline_measure::suite::Random;

/// A seeded generator: the same numbers on every machine.
pub(crate) struct Rng(Random);

impl Rng {
    /// Any seed but 0.
    pub(crate) fn new(seed: u64) -> Self {
        Self(Random(seed))
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        self.0.unit()
    }

    /// Uniform in [-1, 1)^3.
    pub(crate) fn cube(&mut self) -> [f64; 3] {
        self.0.cube()
    }

    /// A whole number from 0 to `n` - 1; 0 where `n` is 0.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// A whole number from `from` to `to` - 1.
    pub(crate) fn within(&mut self, from: u32, to: u32) -> u32 {
        from + self.below((to - from) as usize) as u32
    }

    /// One of `items`.
    pub(crate) fn pick<'a, T: ?Sized>(&mut self, items: &[&'a T]) -> &'a T {
        items[self.below(items.len())]
    }
}
