//! Families of parallel rays.

use super::{FAMILIES, Site, World, scaled, size};
use crate::scene::camera::{Camera, Lens};
use crate::testing::Rng;

/// Parallel rays of a view of about that height, from a point within `unit`.
fn parallel_site(rng: &mut Rng, size: [u32; 2], height: f64, unit: f64) -> Site {
    let site = Site::random(rng, [1.0; 2], size, unit);
    let lens = Lens::Orthographic { height };
    Site::new(Camera { lens, ..site.scene.camera }, size)
}

/// One to four spheres at any depth, larger or smaller than the view, grazed.
pub(super) fn parallel(rng: &mut Rng) -> World {
    let size = size(rng);
    let height = rng.decade(-3.0, 3.0);
    let mut site = parallel_site(rng, size, height, 1.0);
    let mut pixels = Vec::new();
    for _ in 0..1 + rng.below(4) {
        let pixel = site.pixel(rng);
        let radius = height * rng.decade(-4.0, 0.5);
        let depth = radius * rng.decade(0.0, 4.0);
        let at = site.near_ray(rng, pixel, depth, radius);
        site.aim(rng, pixel, at);
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// Across the plane of the eye, just in front of it and just behind it; around the eye; and farther behind.
pub(super) fn parallel_crossing(rng: &mut Rng) -> World {
    let size = size(rng);
    let mut site = parallel_site(rng, size, 2.0, 1.0);
    let mut pixels = Vec::new();
    for _ in 0..1 + rng.below(4) {
        let pixel = site.pixel(rng);
        let radius = rng.decade(-2.0, 0.5);
        let depth = match rng.below(3) {
            0 => rng.between(-1.0, 1.0),
            1 => rng.sign() * (1.0 + rng.sign() * rng.decade(-16.0, -1.0)),
            _ => rng.between(1.0, 3.0),
        };
        let by = radius * rng.between(0.0, 1.0);
        let at = site.near_ray(rng, pixel, depth * radius, by);
        if rng.below(2) == 0 {
            site.aim(rng, pixel, at);
        } else {
            site.push(at, radius);
        }
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// Far from the plane or from the origin, where the order is hard to decide.
pub(super) fn parallel_distant(rng: &mut Rng) -> World {
    let size = size(rng);
    let (depth, unit) = match rng.below(2) {
        0 => (rng.decade(0.7, 12.0), 1.0),
        _ => (rng.decade(0.7, 2.0), rng.decade(2.0, 9.0)),
    };
    let mut site = parallel_site(rng, size, 3.0, unit);
    let pixel = site.pixel(rng);
    let apart = rng.decade(-8.0, 0.0);
    for _ in 0..2 + rng.below(5) {
        let by = rng.between(0.0, 0.4);
        let back = rng.between(0.0, apart);
        let mut at = site.near_ray(rng, pixel, depth, by);
        let r = rng.between(0.5, 1.5);
        at[2] += (r * r - by * by).sqrt() + back;
        site.push(at, r);
    }
    site.done(rng, vec![pixel; 2])
}

/// A pixel is larger than the sphere, and the ray grazes it within the host's rounding of its position.
pub(super) fn parallel_sub_pixel(rng: &mut Rng) -> World {
    let size = size(rng);
    let height = rng.decade(-5.0, 5.0);
    let mut site = parallel_site(rng, size, height, 1.0);
    let mut pixels = Vec::new();
    for _ in 0..2 {
        let pixel = site.pixel(rng);
        let depth = height * rng.decade(-1.0, 9.0);
        let radius = height / f64::from(size[1]) * rng.decade(-6.5, 0.0);
        let at = site.near_ray(rng, pixel, depth, radius);
        let delta = if rng.below(2) == 0 { rng.sign() * rng.decade(-8.0, -1.0) } else { rng.decade(-2.0, 0.3) };
        site.aim_by(delta, pixel, at);
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// A scene of any of these families, 1e-30 to 1e30 times as large.
pub(super) fn parallel_scales(rng: &mut Rng) -> World {
    let World { mut scene, pixels } = FAMILIES[15 + rng.below(4) as usize].1(rng);
    let scale = 2f64.powi(rng.below(200) as i32 - 100);
    if let Lens::Orthographic { height } = &mut scene.camera.lens {
        *height *= scale;
    }
    scaled(&mut scene, scale);
    World { scene, pixels }
}
