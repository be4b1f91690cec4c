//! Many spheres: overlapping, coincident, around the eye; and scenes from third parties.

use super::parts::{aslant, cloud, filled_by, one, picture};
use crate::suite::Random;
use glam::DVec3;
use halfline::error::{Error, Place, Result};
use halfline::scene::camera::{Lens, Look};
use halfline::scene::{Scene, Spheres};
use halfline_files::read::ReadOptions;
use std::path::Path;

const LENS: Lens = Lens::Vfov { degrees: 40.0, distance: 1.0 };

/// Concentric spheres 1e-9 r apart, in either order, from outside and inside; and pairs shifted by the same distance.
pub(super) fn shells(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for gap in [1e-9, -1e-9, 1e-15] {
        for away in [3.0, 100.0, 0.3] {
            let mut spheres = Spheres::default();
            for _ in 0..12 {
                let center = DVec3::from_array(random.cube()) * 0.8;
                let radius = 0.2 + 0.3 * random.unit();
                spheres.push(center.to_array(), radius, None);
                // The same centre, or one shifted by the difference of the radii.
                let shift = if random.unit() < 0.5 { DVec3::ZERO } else { gap * DVec3::from_array(random.cube()) };
                let thick = if shift == DVec3::ZERO { radius * (1.0 + gap) } else { radius };
                spheres.push((center + shift).to_array(), thick, None);
            }
            let lens = if away < 1.0 { LENS } else { filled_by(1.0 / away) };
            scenes.push(picture(away * aslant(), Look::At(DVec3::ZERO), lens, [32, 24], spheres));
        }
    }
    Ok(scenes)
}

/// Every sphere three times, among others: the lowest index is visible.
pub(super) fn coincident(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for away in [4.0, 1e4, 0.1] {
        let once = cloud(&mut random, 20, DVec3::ZERO, 1.0, [0.2, 0.5]);
        let mut spheres = Spheres::default();
        for n in 0..60 {
            // 7 is coprime to 20, so each sphere comes three times.
            let k = (7 * n + n / 20) % 20;
            spheres.push(once.centers[k], once.radii[k], None);
        }
        let lens = if away < 1.0 { LENS } else { filled_by(1.0 / away) };
        scenes.push(picture(away * aslant(), Look::At(DVec3::ZERO), lens, [32, 24], spheres));
    }
    Ok(scenes)
}

/// Pairs mirrored in the plane of the middle column, where both are at exactly the same distance.
pub(super) fn ties(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for distance in [4.0, 1e6] {
        let mut spheres = Spheres::default();
        for n in 0..12 {
            let [_, y, z] = random.cube();
            let x = 0.1 + 0.1 * random.unit();
            let x = if n % 2 == 0 { x } else { -x };
            for side in [1.0, -1.0] {
                spheres.push([side * x, 1.5 * y, z - distance], 0.3, None);
            }
        }
        let mut scene = picture(DVec3::ZERO, Look::View(DVec3::NEG_Z), filled_by(1.5 / distance), [33, 24], spheres);
        scene.camera.up = DVec3::Y;
        scenes.push(scene);
    }
    // The same in the plane of a view (1, 2, 2) and an up (2, -2, 1), to which (2, 1, -2) is perpendicular; no square
    // root is irrational here. Coordinates are integers, so the mirror image is exact.
    for distance in [100.0, 1e9] {
        let (view, up, side) = (DVec3::new(1.0, 2.0, 2.0), DVec3::new(2.0, -2.0, 1.0), DVec3::new(2.0, 1.0, -2.0));
        let eye = DVec3::new(3.0, -5.0, 7.0);
        let mut spheres = Spheres::default();
        for _ in 0..12 {
            let [y, z, _] = random.cube().map(|x| (8.0 * x).round());
            let middle = eye + (distance + z) * view + y * up;
            for x in [1.0, -1.0] {
                spheres.push((middle + x * side).to_array(), 5.0, None);
            }
        }
        let mut scene = picture(eye, Look::View(view), filled_by(9.0 / distance), [33, 24], spheres);
        scene.camera.up = up + view;
        scenes.push(scene);
    }
    Ok(scenes)
}

/// Across the eye plane, behind it, around the eye, in front: each has its own form of the discriminant.
pub(super) fn around(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for degrees in [30.0, 90.0, 140.0, 170.0] {
        for (count, size) in [(30, 1.0), (150, 0.3)] {
            let eye = DVec3::new(0.3, -0.2, 0.1);
            let mut spheres = cloud(&mut random, count, eye, 2.0, [0.05 * size, 0.8 * size]);
            // Two that contain the eye, one of them barely; they hide the others.
            if count == 30 {
                spheres.push([50.0, 20.0, -10.0], 56.0, None);
                spheres.push((eye + DVec3::new(0.0, 1.0, 0.0)).to_array(), 1.0 + 1e-7, None);
            }
            let lens = Lens::Vfov { degrees, distance: 1.0 };
            scenes.push(picture(eye, Look::View(DVec3::from_array(random.cube())), lens, [48, 36], spheres));
        }
    }
    Ok(scenes)
}

/// A ground that fills the lower half of the picture, with crumbs on it.
pub(super) fn ground(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for radius in [1e3, 1e6, 1e9] {
        let mut spheres = one(DVec3::new(0.0, -radius, 0.0), radius);
        for _ in 0..150 {
            let [x, y, z] = random.cube();
            let r = 0.02 + 0.2 * y * y;
            spheres.push([8.0 * x, r, 8.0 * z], r, None);
        }
        let eye = DVec3::new(13.0, 2.0, 3.0);
        scenes.push(picture(
            eye,
            Look::At(DVec3::ZERO),
            Lens::Vfov { degrees: 25.0, distance: 1.0 },
            [64, 48],
            spheres,
        ));
    }
    Ok(scenes)
}

/// A spiral of 5,761 heavily overlapping spheres: the whole and a corner.
#[cfg_attr(target_arch = "wasm32", expect(dead_code, reason = "a browser has no files"))]
pub(super) fn spiral(path: &Path) -> Result<Vec<Scene>> {
    let mut scene = halfline_files::read::scene(path, &ReadOptions::default())?.scene;
    (scene.image.width, scene.image.height) = (48, 48);
    let mut close = scene.clone();
    (close.camera.look, close.camera.lens) = (Look::At(DVec3::new(0.0, 2.0, -12.0)), filled_by(0.06));
    Ok(vec![scene, close])
}

/// Jupiter and all other bodies from the Earth's surface: from the day side and the night side, wide and through a long
/// lens.
#[cfg_attr(target_arch = "wasm32", expect(dead_code, reason = "a browser has no files"))]
pub(super) fn solar(path: &Path) -> Result<Vec<Scene>> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::read(path, e))?;
    let mut bodies = Spheres::default();
    for (number, line) in (1..).zip(text.lines()).skip(1) {
        let numbers: Option<Vec<f64>> = line.split(',').skip(1).map(|x| x.parse().ok()).collect();
        let Some([x, y, z, r]) = numbers.as_deref() else {
            let place = Place::file(path.display().to_string()).at(number, 1);
            return Err(Error::scene(
                place,
                "expected name,x,y,z,radius",
                "use a file with the columns name,x,y,z,radius",
            ));
        };
        bodies.push([*x, *y, *z], *r, None);
    }
    if bodies.len() < 8 {
        let place = Place::file(path.display().to_string());
        return Err(Error::scene(
            place,
            "bodies are missing",
            "the file needs sun, mercury, venus, earth, moon, mars, jupiter, saturn",
        ));
    }
    // In the file's order: sun, mercury, venus, earth, moon, mars, jupiter, ...
    let place = |k: usize| DVec3::from_array(bodies.centers[k]);
    let mut scenes = Vec::new();
    for target in [6, 0, 4, 7] {
        let p = place(target) - place(3);
        // 1.5 m above the ground, with the target 25 degrees above the horizon.
        let up = (p.normalize() + 2.0 * p.cross(DVec3::Z).normalize()).normalize();
        let eye = place(3) + up * (bodies.radii[3] + 1.5e-3);
        let view = place(target) - eye;
        let angle = bodies.radii[target] / view.length();
        for lens in [filled_by(angle), filled_by(40.0 * angle), Lens::Vfov { degrees: 90.0, distance: 1.0 }] {
            scenes.push(picture(eye, Look::At(place(target)), lens, [48, 36], bodies.clone()));
        }
    }
    Ok(scenes)
}
