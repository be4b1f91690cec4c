//! Helpers that the unit tests of several rooms share: the adapter, random numbers, scenes.

use crate::camera::{Camera, Lens, Look};
use crate::gpu::device;
use crate::scene::{ImagePlane, Lighting, Scene, Spheres};
use glam::DVec3;

#[path = "../tests/common/amount.rs"]
mod amount;
#[path = "../tests/common/home.rs"]
mod home;
#[path = "../tests/common/skip.rs"]
mod skip;
#[path = "../tests/common/strict.rs"]
mod strict;

pub(crate) use amount::{amount, everything};
pub(crate) use home::home;
pub(crate) use skip::skip;
pub(crate) use strict::keeps_bits;

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

/// scenes/weekend.toml without its lights, in an image of this size. The readers of files are in another crate, so the
/// spheres are taken line by line.
pub(crate) fn weekend([width, height]: [u32; 2]) -> Scene {
    let text = include_str!("../scenes/weekend.toml");
    let numbers = |line: &str| -> Vec<f64> {
        line.trim_matches(['[', ']']).split(", ").map(|number| number.parse().expect("a number")).collect()
    };
    let of = |sphere: &str, field: &str| {
        let line = sphere.lines().find_map(|line| line.strip_prefix(field)?.strip_prefix(" = "));
        numbers(line.expect("the field"))
    };
    let mut spheres = Spheres::default();
    for sphere in text.split("[[sphere]]").skip(1) {
        let [center, color] = ["center", "color"].map(|field| <[f64; 3]>::try_from(of(sphere, field)).expect("three"));
        spheres.push(center, of(sphere, "radius")[0], Some(color.map(|part| part as f32)));
    }
    let camera = Camera {
        eye: DVec3::new(13.0, 2.0, 3.0),
        look: Look::At(DVec3::ZERO),
        up: DVec3::Y,
        lens: Lens::Vfov { degrees: 20.0, distance: 1.0 },
    };
    let image = ImagePlane { width, height, background: [0.0; 3] };
    Scene { camera, image, spheres, lighting: Lighting::default() }
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

/// Spheres that are not entirely in front of the eye plane, or too near it, and not aside.
const NEAR: [([f64; 3], f64); 6] = [
    ([0.0, -101.0, 0.0], 100.0),
    ([3.0, 0.0, -0.5], 2.0),
    ([-3.0, 0.2, -0.4], 2.0),
    ([0.0, 2.2, 0.2], 1.6),
    ([2.0, -2.0, 0.3], 1.4),
    ([-2.0, -2.0, 0.1], 1.3),
];

/// The first so many of six spheres around the eye, between spheres in front.
pub(crate) fn near_and_far(near: usize) -> Scene {
    let mut rng = Rng(0x5eed);
    let mut spheres = Spheres::default();
    for n in 0..400 {
        let center = [rng.between(-4.0, 4.0), rng.between(-1.0, 4.0), rng.between(-9.0, -5.0)];
        let color = [rng.unit() as f32, 0.5, rng.unit() as f32];
        spheres.push(center, rng.between(0.05, 0.3), Some(color));
        if let Some((center, radius)) = NEAR[..near].get(n / 50).filter(|_| n % 50 == 0) {
            spheres.push(*center, *radius, Some([0.2; 3]));
        }
    }
    let image = ImagePlane { width: 131, height: 74, background: [0.1, 0.2, 0.3] };
    Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() }
}

/// The number of calls of a device from one that fails in a test to the next: on llvmpipe, the adapter of most tests, more of them fail.
pub(crate) fn calls_apart(adapter: &str) -> u32 {
    let shares = if adapter.contains("llvmpipe") { [1, 4, 4] } else { [1, 1, 4] };
    4 / amount("calls of a device that fail, in quarters", shares)
}
