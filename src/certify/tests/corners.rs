//! Critical steps of the derivation, each with a scene that would refute it.

use super::claims::{Case, Checks};
use super::sound::hold;
use super::worlds::Site;
use crate::certify::TERMS;
use crate::scene::camera::{Camera, Lens, Look};
use crate::testing::Rng;
use glam::DVec3;

fn lens(half: f64) -> Lens {
    Lens::Viewport { vw: 2.0 * half, vh: 2.0 * half, distance: 1.0 }
}

fn canonical(half: f64, size: [u32; 2]) -> Site {
    Site::new(Camera { lens: lens(half), ..Camera::CANONICAL }, size)
}

fn checked(site: Site, tolerance: f64, pixels: &[[u32; 2]]) -> [u64; 2] {
    let case = Case::new(site.scene, tolerance, pixels, &TERMS).expect("a lens for f32");
    hold(&case, &case.binned, &TERMS, Checks::ALL, 1)
        .unwrap_or_else(|e| panic!("{e}\n{:?}\n{:?}", case.scene, case.binned))
}

/// The power of an eye 2^-k from a surface: its double-double value must be exact to far less than an ulp of f32.
#[test]
fn the_power_of_an_eye_near_a_surface_is_accurate() {
    let mut rng = Rng(3);
    for k in (30..140).chain((140..900).step_by(9)) {
        for _ in 0..4 {
            // (2, 3, 6) m is 7 m from the origin, exactly.
            let m = ((rng.bits() >> 14) | 1) as f64 * 2f64.powi(-53);
            let gap = rng.sign() * 2f64.powi(-k);
            let camera = Camera {
                eye: DVec3::new(0.0, 0.0, gap),
                look: Look::View(DVec3::new(2.0, 3.0, -6.0)),
                lens: lens(0.9),
                ..Camera::CANONICAL
            };
            let mut site = Site::new(camera, [3, 3]);
            site.scene.spheres.push([2.0 * m, 3.0 * m, -6.0 * m], 7.0 * m, None);
            checked(site, 1e-4, &[[1, 1], [0, 0], [2, 1]]);
        }
    }
}

/// An image of one pixel has the finest fixed point: the host's error must fit beside its rounding.
#[test]
fn an_image_of_one_pixel_has_room_for_the_error_of_the_host() {
    let mut rng = Rng(5);
    for _ in 0..3000 {
        let half = rng.decade(-6.5, -3.0);
        let camera = Camera {
            eye: DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0)),
            look: Look::View(DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), 1.0)),
            up: DVec3::Y,
            lens: lens(half),
        };
        let n = 1 + rng.below(2);
        let mut site = Site::new(camera, [n, n]);
        let [x, y] = site.slopes([0, 0]);
        let r = half * rng.decade(-7.0, -1.0);
        site.aim(&mut rng, [0, 0], [x + r, y - 0.7 * r, 1.0]);
        checked(site, 1e-5, &[[0, 0]]);
    }
}

/// Fixed point ends four images away: spheres farther out are either certainly invisible or handled by the general case.
#[test]
fn spheres_far_outside_the_image_are_not_lost() {
    let mut rng = Rng(11);
    for n in 0..600 {
        let size = [[1, 1], [5, 3], [1 << 20, 2], [3, 1 << 20]][n % 4];
        let mut site = canonical(rng.decade(-4.0, 0.5), size);
        let pixel = [rng.below(size[1]), rng.below(size[0])];
        let [x, y] = site.slopes(pixel);
        let away = rng.decade(-2.0, 2.0);
        let turn = rng.between(0.0, std::f64::consts::TAU);
        let z = rng.decade(0.0, 4.0);
        site.aim(&mut rng, pixel, [(x + away * turn.cos()) * z, (y + away * turn.sin()) * z, z]);
        checked(site, 0.9, &[pixel, [0, 0], [size[1] - 1, size[0] - 1]]);
    }
}

/// Depths relative to a reference: spheres whose spread of size or depth is just below or above its limit.
#[test]
fn a_reference_depth_keeps_lows_below() {
    let mut rng = Rng(13);
    for n in 0..600 {
        let z = rng.decade(1.0, 7.0);
        let mut site = canonical(2.0 / z, [9, 9]);
        let pixels = [[rng.below(9), rng.below(9)], [4, 4]];
        for k in 0..3 {
            let pixel = pixels[k % 2];
            let [x, y] = site.slopes(pixel);
            // The reference is used where 4 times the spread is below the least depth.
            let back = z * (1.0 + rng.between(0.0, if n % 2 == 0 { 0.26 } else { 1e-6 }));
            let r = rng.decade(-3.0, 0.0);
            site.aim(&mut rng, pixel, [x * back + r, y * back, back]);
        }
        checked(site, [1e-5, 0.9, 2f64.powi(-50)][n % 3], &pixels);
    }
}

/// Sizes at both ends of the range of a frame: flushed and overflowing products.
#[test]
fn the_ends_of_the_range_stay_sound() {
    let mut rng = Rng(17);
    for _ in 0..600 {
        let mut site = canonical(rng.decade(-5.0, 0.5), [4, 4]);
        let pixel = [rng.below(4), rng.below(4)];
        let [x, y] = site.slopes(pixel);
        for z in [rng.decade(-35.0, -34.0), rng.decade(34.0, 35.0)] {
            let r = z * rng.decade(-9.0, -1.0);
            site.aim(&mut rng, pixel, [x * z + r, y * z, z]);
        }
        checked(site, 1e-3, &[pixel, [0, 3]]);
    }
}
