//! Nearly or exactly touching: grazing rays, eyes on surfaces, observers on planets.

use super::parts::{aslant, cloud, decades, filled_by, one, picture, tangent};
use crate::suite::Random;
use glam::DVec3;
use halfline::error::Result;
use halfline::exact::Judge;
use halfline::scene::camera::{Lens, Look};
use halfline::scene::{Scene, Spheres};

const CANONICAL: Lens = Lens::Viewport { vw: 2.0, vh: 1.5, distance: 1.0 };

/// The direction through the centre of row i, column j, of an image whose lens has d = 1, within rounding.
fn direction(scene: &Scene, i: u32, j: u32) -> Result<DVec3> {
    let (camera, image) = (&scene.camera, &scene.image);
    let basis = camera.basis()?;
    let lens = camera.viewport(image.width, image.height)?;
    let odd = |k: u32, n: u32| (2.0 * f64::from(k) + 1.0 - f64::from(n)) / (2.0 * f64::from(n));
    Ok(basis.u * (odd(j, image.width) * lens.vw) - basis.v * (odd(i, image.height) * lens.vh) - basis.w * lens.d)
}

/// The smallest f64 radius at which the ray of that pixel hits a sphere about `center`: its exact impact parameter,
/// rounded up. `guess` is within 2^-20 of it.
fn impact(scene: &Scene, [i, j]: [u32; 2], center: DVec3, guess: f64) -> Result<f64> {
    let hit = |radius: f64| -> Result<bool> {
        let alone = Scene { spheres: one(center, radius), ..scene.clone() };
        Ok(Judge::new(&alone)?.pixel(i, j).is_some())
    };
    // Positive f64 have the order of their bits.
    let [mut missed, mut touched] = [-1.0, 1.0].map(|side| (guess * (1.0 + side * 2f64.powi(-20))).to_bits());
    debug_assert!(!hit(f64::from_bits(missed))? && hit(f64::from_bits(touched))?, "the guess {guess:e} is off");
    while touched - missed > 1 {
        let middle = missed + (touched - missed) / 2;
        *if hit(f64::from_bits(middle))? { &mut touched } else { &mut missed } = middle;
    }
    Ok(f64::from_bits(touched))
}

/// Distance of `center` from the line through the eye, within rounding.
fn distance(scene: &Scene, d: DVec3, center: DVec3) -> f64 {
    (center - scene.camera.eye).cross(d).length() / d.length()
}

/// b(1 +- 2^-k) for the n-th case: k counts to 45, the sign alternates, and every 46th case is b itself.
fn nearly(b: f64, n: i32) -> f64 {
    let k = 1 + n / 2 % 46;
    let side = if n % 2 == 0 { 1.0 } else { -1.0 };
    if k == 46 { b } else { b * (1.0 + side * 2f64.powi(-k)) }
}

/// Beside each of 192 rays a small sphere that the ray touches or just misses.
pub(super) fn grazing(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for depths in [[2.0, 20.0], [1e3, 1e5]] {
        let mut scene =
            picture(DVec3::new(3.0, -2.0, 5.0), Look::View(-aslant()), CANONICAL, [32, 24], Spheres::default());
        let mut n = 0;
        for i in (0..24).step_by(2) {
            for j in (0..32).step_by(2) {
                let d = direction(&scene, i, j)?;
                let z = depths[0] + (depths[1] - depths[0]) * random.unit();
                let across = d.cross(DVec3::from_array(random.cube())).normalize();
                // 0.3 of a pixel's pitch at that depth, so that no other ray comes near.
                let center = scene.camera.eye + z * (d + across * (0.3 * 2.0 / 32.0));
                let guess = distance(&scene, d, center);
                let b = impact(&scene, [i, j], center, guess)?;
                scene.spheres.push(center.to_array(), nearly(b, n), None);
                n += 1;
            }
        }
        scenes.push(scene);
    }
    Ok(scenes)
}

/// A sphere that fills half the picture and is touched by one of its rays, near and far, oblique and on the axis.
pub(super) fn grazing_large(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for (distances, axis) in [(5.0, false), (1e3, false), (1e6, false), (1e6, true)] {
        // k = 5, 15, 25, 35, 40, 45, and b itself, with alternating signs.
        for n in [8, 28, 49, 68, 79, 88, 89, 90] {
            let away = if axis { DVec3::Z } else { aslant() };
            let eye = away * distances;
            let mut scene =
                picture(eye, Look::View(-away), filled_by(tangent(distances)), [24, 18], Spheres::default());
            let center = DVec3::from_array(random.cube()) * 0.1;
            let pixel = [9 + (4.0 * random.unit()) as u32, 15 + (4.0 * random.unit()) as u32];
            let guess = distance(&scene, direction(&scene, pixel[0], pixel[1])?, center);
            let b = impact(&scene, pixel, center, guess)?;
            scene.spheres = one(center, nearly(b, n));
            scenes.push(scene);
        }
    }
    Ok(scenes)
}

/// Rays whose discriminant is exactly 0.
fn tangent_rays(eye: DVec3, unit: f64) -> Scene {
    // The rays of the pixels are (a, b, -6) with a in -16 ..= 16 and b in -12 ..= 12: all integers.
    let lens = Lens::Viewport { vw: 33.0 * unit, vh: 25.0 * unit, distance: 6.0 * unit };
    let mut spheres = Spheres::default();
    // Right of the rays with a = 0: the centre's perpendicular is along x, of length r.
    for b in -12i32..=12 {
        let t = f64::from(3 + b.rem_euclid(5));
        spheres.push((eye + DVec3::new(0.25, t * f64::from(b), -6.0 * t)).to_array(), 0.25, None);
    }
    // (2, 3, -6) is perpendicular to (6, 2, 3) and (3, -6, -2), all of length 7.
    for (n, across) in [[6.0, 2.0, 3.0], [3.0, -6.0, -2.0], [-6.0, -2.0, -3.0]].into_iter().enumerate() {
        let s = 0.125 / 2f64.powi(n as i32);
        let center = eye + (10.0 + 3.0 * n as f64) * DVec3::new(2.0, 3.0, -6.0) + s * DVec3::from_array(across);
        spheres.push(center.to_array(), 7.0 * s, None);
    }
    // The four signs of (a, b) = (8, 0) and (0, 8), |(8, 0, 6)| = 10; the perpendicular in the plane of the axis.
    for (a, b) in [(8.0, 0.0), (-8.0, 0.0), (0.0, 8.0), (0.0, -8.0)] {
        let (d, across) = (DVec3::new(a, b, -6.0), DVec3::new(a * 6.0, b * 6.0, 64.0) / 8.0);
        spheres.push((eye + 20.0 * d + 0.5 * across).to_array(), 0.5 * 10.0, None);
    }
    let mut scene = picture(eye, Look::View(DVec3::NEG_Z), lens, [33, 25], spheres);
    scene.camera.up = DVec3::Y;
    scene
}

/// Exact tangency along the axes, and in oblique views through the middle pixel.
pub(super) fn touched(_: u64) -> Result<Vec<Scene>> {
    let mut scenes = vec![
        tangent_rays(DVec3::ZERO, 1.0),
        tangent_rays(DVec3::new(1e6, -3e6, 1e9), 2f64.powi(-60)),
        tangent_rays(DVec3::new(0.5, 0.25, 8.0), 2f64.powi(40)),
    ];
    // The middle ray is the view (1, 2, 2) itself, even if the basis is irrational; (2, 1, -2) is perpendicular and of
    // the same length. One sphere behind another, each tangent on one side or the other.
    for (t, s, side) in [(5.0, 1.0, 1.0), (7.0, 0.5, -1.0), (1e6, 2.0, 1.0), (1e9, 3.0, -1.0)] {
        let (view, across) = (DVec3::new(1.0, 2.0, 2.0), DVec3::new(2.0, 1.0, -2.0));
        let eye = DVec3::new(-3.0, 4.0, 0.5);
        let mut spheres = one(eye + t * view + side * s * across, 3.0 * s);
        // As far behind it as it is large: the middle ray enters this sphere deeply.
        spheres.push((eye + (t + 2.0 * s) * view).to_array(), 0.5 * s, None);
        scenes.push(picture(eye, Look::View(view), filled_by(s / t), [33, 25], spheres));
    }
    Ok(scenes)
}

/// Points of a sphere of radius 7 about the origin, and views inward, outward and along the surface.
fn poses() -> Vec<[DVec3; 2]> {
    let v = DVec3::new;
    vec![
        [v(2.0, 3.0, 6.0), v(-2.0, -3.0, -5.0)],
        [v(2.0, 3.0, 6.0), v(3.0, -6.0, 2.0)],
        [v(-6.0, 2.0, -3.0), v(-6.0, 2.5, -3.0)],
        [v(-6.0, 2.0, -3.0), v(1.0, 3.0, 0.1)],
        [v(0.0, -7.0, 0.0), v(1.0, 0.05, 0.2)],
    ]
}

/// The sphere of radius 7, crumbs about it, and a lens of `degrees`.
fn shore(random: &mut Random, eye: DVec3, view: DVec3, degrees: f64) -> Scene {
    let mut spheres = cloud(random, 8, eye + 4.0 * view.normalize(), 3.0, [0.1, 0.4]);
    spheres.push([0.0; 3], 7.0, None);
    picture(eye, Look::View(view), Lens::Vfov { degrees, distance: 1.0 }, [32, 24], spheres)
}

/// Exactly on the surface, at scale 1 and at other scales.
pub(super) fn on_surface(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for [eye, view] in poses() {
        scenes.push(shore(&mut random, eye, view, 60.0));
        scenes.push(shore(&mut random, eye, view, 150.0));
    }
    // Touching spheres behind and beside the eye, alone: nothing hides the empty side.
    for scale in [1.0, 1e-20, 2f64.powi(60)] {
        let [eye, view] = [DVec3::new(2.0, 3.0, 6.0), DVec3::new(3.0, -6.0, 2.0)];
        let lens = Lens::Vfov { degrees: 100.0, distance: 1.0 };
        let mut spheres = Spheres::default();
        // Multiples of powers of two times integers: exact at 1 and 2^60, rounded at 1e-20.
        for m in [1.0, 2.0, 0.5, -1.0] {
            let center = eye * (1.0 - m) * scale;
            spheres.push(center.to_array(), 7.0 * f64::abs(m) * scale, None);
        }
        scenes.push(picture(eye * scale, Look::View(view), lens, [32, 24], spheres));
    }
    Ok(scenes)
}

/// Outside and inside by an ulp, 2^-40, 1e-9 and 1e-4 of the radius.
pub(super) fn off_surface(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for ([eye, view], off) in poses().into_iter().zip([2f64.powi(-52), 2f64.powi(-50), 2f64.powi(-40), 1e-9, 1e-4]) {
        for side in [-1.0, 1.0] {
            scenes.push(shore(&mut random, eye * (1.0 + side * off), view, 70.0));
            scenes.push(shore(&mut random, eye * (1.0 + side * off), eye.cross(view) + 0.1 * view, 110.0));
        }
    }
    // The nearest f64 to an irrational point of the unit sphere.
    scenes.push(picture(aslant(), Look::View(DVec3::X), CANONICAL, [32, 24], one(DVec3::ZERO, 1.0)));
    Ok(scenes)
}

/// The Earth from heights of 1.7 m to 100 km, and 40 stones whose size is proportional to the height.
pub(super) fn planet(seed: u64) -> Result<Vec<Scene>> {
    const R: f64 = 6.4e6;
    let mut random = Random(seed);
    let up = aslant();
    let ahead = up.cross(DVec3::new(1.0, 0.2, 0.0)).normalize();
    let mut scene = |height: f64| {
        let eye = (R + height) * up;
        let mut spheres = one(DVec3::ZERO, R);
        for _ in 0..40 {
            let [x, _, z] = random.cube();
            let ground = R * up + height * ((4.0 + 3.0 * x) * ahead + 3.0 * z * ahead.cross(up));
            let stone = height * (0.02 + 0.1 * random.unit());
            // Half sunk or lying on the surface.
            spheres.push((ground.normalize() * (R + stone * random.unit())).to_array(), stone, None);
        }
        let lens = Lens::Vfov { degrees: 50.0, distance: 1.0 };
        let mut scene = picture(eye, Look::View(ahead - 0.2 * up), lens, [48, 36], spheres);
        scene.camera.up = up;
        scene
    };
    Ok([1.7, 10.0, 100.0, 1e3, 1e4, 1e5].into_iter().map(&mut scene).collect())
}

/// The horizon, magnified: the silhouette of a sphere that fills half the view.
pub(super) fn horizon(_: u64) -> Result<Vec<Scene>> {
    let mut scenes = Vec::new();
    for (radius, height) in [(6.4e6, 1.7), (6.4e6, 1e5), (1e6, 1.0), (6.957e8, 1e-3)] {
        let eye = (radius + height) * aslant();
        let out = aslant().cross(DVec3::X).normalize();
        // From the eye to the horizon: sqrt(h(2 r + h)) along, and down to the point of tangency.
        let along = f64::sqrt(height * (2.0 * radius + height));
        let dip = along / radius;
        let view = out - dip * aslant();
        for degrees in decades(-6, 0, 2) {
            let lens = Lens::Vfov { degrees, distance: 1.0 };
            let mut scene = picture(eye, Look::View(view), lens, [32, 24], one(DVec3::ZERO, radius));
            scene.camera.up = aslant();
            scenes.push(scene);
        }
    }
    Ok(scenes)
}
