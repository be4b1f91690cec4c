//! What the unit tests of several rooms share.

use crate::gpu::device;

#[path = "../tests/common/skip.rs"]
mod skip;

pub(crate) use skip::skip;

/// The adapter that the tests are pinned to. `None`, and the test is skipped, where HALFLINE_NO_GPU is set.
pub(crate) fn adapter_or_skip() -> Option<device::FoundAdapter> {
    if std::env::var_os("HALFLINE_NO_GPU").is_some() {
        skip("HALFLINE_NO_GPU is set");
        return None;
    }
    let found = device::choose(device::find().expect("adapters"), None).expect("a choice");
    let found = found.expect("an adapter; tests/run installs and pins one");
    println!("adapter: {} ({})", found.summary.name, found.summary.driver);
    Some(found)
}

/// SplitMix64: Steele, Lea, Flood, *Fast splittable pseudorandom number generators*, OOPSLA 2014.
#[derive(Debug, Clone)]
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// In [low, high).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// 10^x for x in [low, high).
    pub(crate) fn decade(&mut self, low: f64, high: f64) -> f64 {
        10f64.powf(self.between(low, high))
    }

    /// A whole number below `n`.
    pub(crate) fn below(&mut self, n: u32) -> u32 {
        (self.bits() % u64::from(n)) as u32
    }

    /// 1 or -1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.bits() & 1 == 0 { 1.0 } else { -1.0 }
    }
}
