//! Families of a perspective camera.

use super::super::claims::Exact;
use super::{FAMILIES, Site, World, aimed, scaled, shaped, size};
use crate::scene::camera::{Camera, Lens, Look};
use crate::testing::Rng;
use glam::DVec3;

/// One sphere from 1.01 to 1e8 radii away, the lens narrowed to it.
pub(super) fn generic(rng: &mut Rng) -> World {
    let size = size(rng);
    let depth = rng.decade(0.005, 8.0);
    let half = (rng.between(0.3, 3.0) / depth).min(2.0);
    let mut site = Site::random(rng, shaped(half, size).map(|h| h.min(20.0)), size, depth);
    let by = rng.between(0.0, half * depth);
    let pixel = site.pixel(rng);
    let at = site.near_ray(rng, pixel, depth, by);
    site.push(at, 1.0);
    site.done(rng, vec![pixel])
}

/// The same by one to four spheres, grazed.
pub(super) fn grazed(rng: &mut Rng) -> World {
    let size = size(rng);
    let site = Site::random(rng, shaped(rng.clone().decade(-3.0, 0.5), size).map(|h| h.min(20.0)), size, 1.0);
    aimed(rng, site, [0.3, 6.0], &[])
}

/// 100 to 176 degrees.
pub(super) fn wide(rng: &mut Rng) -> World {
    let size = size(rng);
    let half = rng.between(100f64, 176.0).to_radians() / 2.0;
    let site = Site::random(rng, [half.tan(), half.tan()].map(|h| h * 0.78), size, 1.0);
    aimed(rng, site, [0.1, 4.0], &[])
}

/// Angles down to a microradian, distances up to a billion units.
pub(super) fn long(rng: &mut Rng) -> World {
    let size = size(rng);
    let half = rng.decade(-10.0, -3.0);
    let site = Site::random(rng, shaped(half, size), size, 1.0);
    aimed(rng, site, [2.0, 9.0], &[])
}

/// A planet seen from 1.7 m to 100 km, its horizon, and pebbles below the eye.
pub(super) fn planet(rng: &mut Rng) -> World {
    let r = 6.4e6;
    let h = rng.decade(0.2, 5.0);
    let lens = Lens::Vfov { degrees: rng.between(5.0, 100.0), distance: 1.0 };
    let tilt = rng.between(0.0, 2.5) * (2.0 * h / r).sqrt();
    let look = Look::View(DVec3::new(rng.between(-1.0, 1.0), -tilt, rng.between(-1.0, 1.0)));
    let size = size(rng);
    let mut site = Site::new(Camera { eye: DVec3::new(0.0, h, 0.0), look, up: DVec3::Y, lens }, size);
    let center = [0.0, -r, 0.0];
    let pixel = site.pixel(rng);
    let passes = Exact::of(&site.scene, pixel, center, 1.0).passes();
    // The horizon goes through a pixel if that leaves the eye outside.
    let aimed = passes * (1.0 + rng.sign() * 2f64.powf(rng.between(-40.0, -18.0)));
    site.scene.spheres.push(center, if aimed < r + 0.99 * h { aimed } else { r }, None);
    for _ in 0..rng.below(4) {
        let depth = h * rng.decade(-0.5, 1.5);
        let pixel = site.pixel(rng);
        let at = site.near_ray(rng, pixel, depth, 0.03 * depth);
        site.aim(rng, pixel, at);
    }
    site.done(rng, vec![pixel])
}

/// The eye inside spheres, deep and close to the surface; shells; a sphere between eye and surface.
pub(super) fn inside(rng: &mut Rng) -> World {
    let size = size(rng);
    let mut site = Site::random(rng, shaped(rng.clone().decade(-4.0, 0.7), size).map(|h| h.min(25.0)), size, 1.0);
    for _ in 0..1 + rng.below(3) {
        let r = rng.decade(-2.0, 4.0);
        let deep = 1.0 - rng.decade(-9.0, 0.0);
        let way = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0));
        site.push((way.normalize() * r * deep).to_array(), r);
        if rng.below(2) == 0 {
            let last = site.scene.spheres.centers.len() - 1;
            let center = site.scene.spheres.centers[last];
            site.scene.spheres.push(center, r * (1.0 + rng.decade(-9.0, -2.0)), None);
        }
    }
    let pixel = site.pixel(rng);
    site.done(rng, vec![pixel])
}

/// Across the eye plane, or large and close.
pub(super) fn straddling(rng: &mut Rng) -> World {
    let size = size(rng);
    let mut site = Site::random(rng, shaped(rng.clone().decade(-2.0, 0.9), size).map(|h| h.min(30.0)), size, 1.0);
    let mut pixels = Vec::new();
    for _ in 0..1 + rng.below(3) {
        let pixel = site.pixel(rng);
        let depth = rng.between(-0.5, 1.2);
        let by = rng.decade(-1.0, 1.5);
        let at = site.near_ray(rng, pixel, depth, by);
        site.aim(rng, pixel, at);
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// Far away and at nearly equal depths, where the order is hard to decide.
pub(super) fn cluster(rng: &mut Rng) -> World {
    let size = size(rng);
    let depth = rng.decade(0.7, 8.0);
    let mut site = Site::random(rng, shaped(0.7 / depth, size), size, depth);
    let pixel = site.pixel(rng);
    let apart = rng.decade(-8.0, 0.0);
    for _ in 0..2 + rng.below(5) {
        let by = rng.between(0.0, 0.4);
        let back = rng.between(0.0, apart);
        let mut at = site.near_ray(rng, pixel, depth, by);
        // The hits are at nearly the same depth along the ray.
        let r = rng.between(0.5, 1.5);
        at[2] += (r * r - by * by).sqrt() + back;
        site.push(at, r);
    }
    site.done(rng, vec![pixel; 2])
}

/// A pixel is larger than the sphere.
pub(super) fn sub_pixel(rng: &mut Rng) -> World {
    let size = size(rng);
    let half = rng.decade(-5.0, 0.3);
    let mut site = Site::random(rng, [half, half], size, 1.0);
    let mut pixels = Vec::new();
    for _ in 0..2 {
        let pixel = site.pixel(rng);
        let depth = rng.decade(0.3, 5.0);
        let radius = depth * half / f64::from(size[1]) * rng.decade(-6.5, 0.0);
        let at = site.near_ray(rng, pixel, depth, radius);
        // The ray grazes within the rounding of the projected centre.
        let delta = if rng.below(2) == 0 { rng.sign() * rng.decade(-8.0, -1.0) } else { rng.decade(-2.0, 0.3) };
        site.aim_by(delta, pixel, at);
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// A scene of any family, 1e-30 to 1e30 times as large.
pub(super) fn scales(rng: &mut Rng) -> World {
    let World { mut scene, pixels } = FAMILIES[rng.below(9) as usize].1(rng);
    // A power of two, so that rays still graze.
    let scale = 2f64.powi(rng.below(200) as i32 - 100);
    scaled(&mut scene, scale);
    World { scene, pixels }
}

/// At the corners of a wide image, where |d|^2 is largest.
pub(super) fn corner(rng: &mut Rng) -> World {
    let size = size(rng);
    let half = rng.decade(-0.3, 1.3);
    let mut site = Site::random(rng, [half, half], size, 1.0);
    let mut pixels = Vec::new();
    for _ in 0..2 {
        let pixel = [rng.below(2) * (size[1] - 1), rng.below(2) * (size[0] - 1)];
        let depth = rng.decade(0.3, 5.0);
        let radius = depth * rng.decade(-4.0, 0.0);
        let at = site.near_ray(rng, pixel, depth, radius);
        site.aim(rng, pixel, at);
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// Viewports a hundred times as wide as tall, or the reverse, on square images.
pub(super) fn anisotropic(rng: &mut Rng) -> World {
    let size = size(rng);
    let half = rng.decade(-3.0, 1.0);
    let half = if rng.below(2) == 0 { [half, half / 100.0] } else { [half / 100.0, half] };
    let site = Site::random(rng, half, size, 1.0);
    aimed(rng, site, [0.3, 5.0], &[])
}

/// The eye just outside, just inside, or on a surface.
pub(super) fn surface(rng: &mut Rng) -> World {
    let size = size(rng);
    let mut site = Site::random(rng, shaped(rng.clone().decade(-2.0, 0.5), size).map(|h| h.min(25.0)), size, 0.0);
    for _ in 0..1 + rng.below(2) {
        let r = rng.decade(-2.0, 6.0);
        let gap = 1.0 + rng.sign() * rng.decade(-16.0, -2.0);
        let way = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0));
        site.push((way.normalize() * r * gap).to_array(), r);
    }
    let pixel = site.pixel(rng);
    site.done(rng, vec![pixel])
}

/// Up to 2^20 pixels wide.
pub(super) fn big_image(rng: &mut Rng) -> World {
    let size = [1 << (10 + rng.below(11)), 1 + rng.below(3000)];
    let half = rng.decade(-4.0, 0.7);
    let site = Site::random(rng, shaped(half.min(20.0 / f64::from(size[0])), size), size, 1.0);
    aimed(rng, site, [0.3, 6.0], &[])
}

/// Slightly ahead and far aside: in front of the eye plane, but not a projected sphere.
pub(super) fn off_axis_near(rng: &mut Rng) -> World {
    let size = size(rng);
    let half = rng.decade(0.0, 2.5);
    let mut site = Site::random(rng, [half, half], size, 1.0);
    // Small: p x d cancels, which affects the normal first.
    let pixel = site.pixel(rng);
    let radius = rng.decade(-5.5, -3.0);
    let at = site.near_ray(rng, pixel, 1.0, radius);
    site.aim_by(rng.decade(-2.0, 0.3), pixel, at);
    aimed(rng, site, [-1.0, 1.0], &[pixel])
}
