//! Random scenes: every number is drawn over its whole range, to find combinations that no other case covers.

use super::parts::picture;
use crate::suite::Random;
use glam::DVec3;
use halfline::error::Result;
use halfline::scene::camera::{Lens, Look};
use halfline::scene::{Scene, Spheres};

/// 10^x with x uniform between `from` and `to`.
fn log(random: &mut Random, from: f64, to: f64) -> f64 {
    10f64.powf(from + (to - from) * random.unit())
}

/// A lens of up to 179.99 degrees, or down to 1e-9, with pixels of any shape.
fn lens(random: &mut Random) -> Lens {
    let tall = match random.unit() {
        x if x < 0.6 => log(random, -1.0, 0.5),
        x if x < 0.8 => log(random, -9.0, 0.0),
        _ => log(random, 0.0, 4.0),
    };
    let shape = if random.unit() < 0.7 { 4.0 / 3.0 } else { log(random, -3.0, 3.0) };
    let distance = log(random, -20.0, 20.0);
    Lens::Viewport { vw: tall * shape * distance, vh: tall * distance, distance }
}

/// Adds a sphere that is probably visible, at `depth`: small or large relative to a pixel, or almost touching the eye.
fn add(random: &mut Random, scene: &mut Scene, depth: f64) -> Result<()> {
    let [x, y, _] = random.cube();
    let basis = scene.camera.basis()?;
    let viewport = scene.camera.viewport(scene.image.width, scene.image.height)?;
    let slope = [0.55 * x * viewport.vw / viewport.d, 0.55 * y * viewport.vh / viewport.d];
    let away = depth * (basis.u * slope[0] + basis.v * slope[1] - basis.w);
    let pixel = depth * viewport.vh / viewport.d / f64::from(scene.image.height);
    let radius = match random.unit() {
        x if x < 0.6 => pixel * log(random, -1.0, 1.0),
        x if x < 0.75 => pixel * log(random, -3.0, 3.0),
        x if x < 0.85 => away.length() * log(random, -2.0, 0.0),
        // The eye is just outside or inside.
        _ => away.length() * (1.0 + log(random, -16.0, 0.0) * if random.unit() < 0.7 { -1.0 } else { 1.0 }),
    };
    let mut center = scene.camera.eye + away;
    let spheres = &mut scene.spheres;
    let n = spheres.len();
    if n > 0 && random.unit() < 0.15 {
        // A copy of another sphere, moved or grown by a few of its last bits, or unchanged.
        let k = (random.unit() * n as f64) as usize;
        center = DVec3::from_array(spheres.centers[k]);
        let ulps = (random.unit() * 4.0).floor() - 1.0;
        let grown = spheres.radii[k] * (1.0 + ulps * f64::EPSILON);
        if random.unit() < 0.5 {
            center *= 1.0 + f64::EPSILON;
        }
        spheres.push(center.to_array(), grown, None);
    } else if radius > 0.0 {
        spheres.push(center.to_array(), radius, None);
    }
    Ok(())
}

/// Scenes of 1 to 40 spheres.
pub(super) fn anything(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scene = || -> Result<Scene> {
        let scale = if random.unit() < 0.7 { 1.0 } else { log(&mut random, -30.0, 30.0) };
        let far = if random.unit() < 0.5 { 0.0 } else { log(&mut random, -2.0, 9.0) };
        let eye = scale * far * DVec3::from_array(random.cube());
        let view = match random.unit() {
            x if x < 0.1 => DVec3::NEG_Z,
            _ => DVec3::from_array(random.cube()) * log(&mut random, -3.0, 3.0),
        };
        let lens = lens(&mut random);
        let size = [1 + (24.0 * random.unit()) as u32, 1 + (24.0 * random.unit()) as u32];
        let mut scene = picture(eye, Look::View(view), lens, size, Spheres::default());
        // All at nearly the same depth, or at different depths.
        let spread = if random.unit() < 0.5 { 0.02 } else { 6.0 * random.unit() };
        for _ in 0..1 + (40.0 * random.unit()) as usize {
            let depth = scale * log(&mut random, -spread, spread);
            add(&mut random, &mut scene, depth)?;
        }
        Ok(scene)
    };
    (0..60).map(|_| scene()).collect()
}
