//! Random spheres.

use crate::rng::Rng;
use halfline::scene::Spheres;

/// `count` coloured spheres of radius `r` to 3 r in a cube of half side `side` about `at`.
pub(crate) fn cloud(seed: u64, count: usize, at: [f64; 3], side: f64, r: f64) -> Spheres {
    let mut rng = Rng::new(seed);
    let mut spheres = Spheres::default();
    for _ in 0..count {
        let [x, y, z] = rng.cube();
        let center = [at[0] + side * x, at[1] + side * y, at[2] + side * z];
        let color = rng.cube().map(|c| 0.5 + 0.5 * c as f32);
        spheres.push(center, r * (1.0 + 2.0 * rng.unit()), Some(color));
    }
    spheres
}
