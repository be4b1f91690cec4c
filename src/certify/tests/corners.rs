//! Single suspicions about a step of the derivation, each a scene that would show it to be false.

use super::claims::{Case, Checks};
use super::sound::hold;
use super::wild::Dice;
use super::worlds::Site;
use crate::camera::{Camera, Lens, Look};
use crate::certify::TERMS;
use glam::DVec3;

fn lens(half: f64) -> Lens {
    Lens::Viewport { vw: 2.0 * half, vh: 2.0 * half, distance: 1.0 }
}

fn canonical(half: f64, size: [u32; 2]) -> Site {
    Site::new(Camera { lens: lens(half), ..Camera::CANONICAL }, size)
}

fn held(site: Site, tolerance: f64, pixels: &[[u32; 2]]) -> [u64; 2] {
    let case = Case::new(site.scene, tolerance, pixels, &TERMS).expect("a lens for f32");
    hold(&case, &case.binned, &TERMS, Checks::ALL, 1)
        .unwrap_or_else(|e| panic!("{e}\n{:?}\n{:?}", case.scene, case.binned))
}

/// The power of an eye 2^-k from a surface: what double-double leaves of it must be exact to far less than f32's ulp.
#[test]
fn an_eye_at_a_surface_knows_its_power() {
    let mut dice = Dice(3);
    for k in (30..140).chain((140..900).step_by(9)) {
        for _ in 0..4 {
            // (2, 3, 6) m is 7 m from the origin, exactly.
            let m = ((dice.bits() >> 14) | 1) as f64 * 2f64.powi(-53);
            let gap = dice.sign() * 2f64.powi(-k);
            let camera = Camera {
                eye: DVec3::new(0.0, 0.0, gap),
                look: Look::View(DVec3::new(2.0, 3.0, -6.0)),
                lens: lens(0.9),
                ..Camera::CANONICAL
            };
            let mut site = Site::new(camera, [3, 3]);
            site.scene.spheres.push([2.0 * m, 3.0 * m, -6.0 * m], 7.0 * m, None);
            held(site, 1e-4, &[[1, 1], [0, 0], [2, 1]]);
        }
    }
}

/// One pixel has the finest fixed point of all: the host's error must fit beside its rounding.
#[test]
fn an_image_of_one_pixel_leaves_room_for_the_hosts_error() {
    let mut dice = Dice(5);
    for _ in 0..3000 {
        let half = dice.decade(-6.5, -3.0);
        let camera = Camera {
            eye: DVec3::new(dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), dice.between(-1.0, 1.0)),
            look: Look::View(DVec3::new(dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), 1.0)),
            up: DVec3::Y,
            lens: lens(half),
        };
        let n = 1 + dice.below(2);
        let mut site = Site::new(camera, [n, n]);
        let [x, y] = site.slopes([0, 0]);
        let r = half * dice.decade(-7.0, -1.0);
        site.aim(&mut dice, [0, 0], [x + r, y - 0.7 * r, 1.0]);
        held(site, 1e-5, &[[0, 0]]);
    }
}

/// Fixed point ends four images away: what is farther is either surely unseen or counts as near.
#[test]
fn spheres_far_outside_the_image_are_not_lost() {
    let mut dice = Dice(11);
    for n in 0..600 {
        let size = [[1, 1], [5, 3], [1 << 20, 2], [3, 1 << 20]][n % 4];
        let mut site = canonical(dice.decade(-4.0, 0.5), size);
        let pixel = [dice.below(size[1]), dice.below(size[0])];
        let [x, y] = site.slopes(pixel);
        let away = dice.decade(-2.0, 2.0);
        let turn = dice.between(0.0, std::f64::consts::TAU);
        let z = dice.decade(0.0, 4.0);
        site.aim(&mut dice, pixel, [(x + away * turn.cos()) * z, (y + away * turn.sin()) * z, z]);
        held(site, 0.9, &[pixel, [0, 0], [size[1] - 1, size[0] - 1]]);
    }
}

/// Depths relative to a reference: spheres so far apart in size or depth that it is just used, or just not.
#[test]
fn a_reference_depth_keeps_lows_below() {
    let mut dice = Dice(13);
    for n in 0..600 {
        let z = dice.decade(1.0, 7.0);
        let mut site = canonical(2.0 / z, [9, 9]);
        let pixels = [[dice.below(9), dice.below(9)], [4, 4]];
        for k in 0..3 {
            let pixel = pixels[k % 2];
            let [x, y] = site.slopes(pixel);
            // The reference is used where 4 times the spread is below the least depth.
            let back = z * (1.0 + dice.between(0.0, if n % 2 == 0 { 0.26 } else { 1e-6 }));
            let r = dice.decade(-3.0, 0.0);
            site.aim(&mut dice, pixel, [x * back + r, y * back, back]);
        }
        held(site, [1e-5, 0.9, 2f64.powi(-50)][n % 3], &pixels);
    }
}

/// Sizes at both ends of what a frame holds: flushed and overflowing products.
#[test]
fn the_ends_of_the_range_stay_sound() {
    let mut dice = Dice(17);
    for _ in 0..600 {
        let mut site = canonical(dice.decade(-5.0, 0.5), [4, 4]);
        let pixel = [dice.below(4), dice.below(4)];
        let [x, y] = site.slopes(pixel);
        for z in [dice.decade(-35.0, -34.0), dice.decade(34.0, 35.0)] {
            let r = z * dice.decade(-9.0, -1.0);
            site.aim(&mut dice, pixel, [x * z + r, y * z, z]);
        }
        held(site, 1e-3, &[pixel, [0, 3]]);
    }
}
