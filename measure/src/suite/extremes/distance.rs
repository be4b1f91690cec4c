//! Far from the scene, or far from the origin.

use super::parts::{aslant, cloud, decades, filled_by, one, picture, tangent};
use crate::suite::Random;
use glam::DVec3;
use halfline::error::Result;
use halfline::scene::Scene;
use halfline::scene::camera::{Lens, Look};

/// Distances in radii, from almost touching.
fn distances() -> impl Iterator<Item = f64> {
    [1.01, 2.0].into_iter().chain(decades(1, 12, 1))
}

/// A unit sphere straight ahead along the world's axes.
pub(super) fn on_axis(_: u64) -> Result<Vec<Scene>> {
    let scene = |distance: f64| {
        let mut scene = picture(
            DVec3::Z * distance,
            Look::View(DVec3::NEG_Z),
            filled_by(tangent(distance)),
            [32, 24],
            one(DVec3::ZERO, 1.0),
        );
        scene.camera.up = DVec3::Y;
        scene
    };
    Ok(distances().map(scene).collect())
}

/// The same along (1, 2, 3).
pub(super) fn oblique(_: u64) -> Result<Vec<Scene>> {
    let scene = |distance: f64| {
        picture(
            aslant() * distance,
            Look::At(DVec3::ZERO),
            filled_by(tangent(distance)),
            [48, 36],
            one(DVec3::ZERO, 1.0),
        )
    };
    Ok(distances().map(scene).collect())
}

/// The same, off the middle of the picture and, in wide lenses, far off it; the coordinates of the centres are not
/// round.
pub(super) fn off_axis(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for distance in distances() {
        let center = DVec3::from_array(random.cube());
        let eye = center + aslant() * distance;
        let across = eye.cross(DVec3::from_array(random.cube())).normalize();
        scenes.push(picture(
            eye,
            Look::At(center + 0.7 * across),
            filled_by(tangent(distance)),
            [32, 24],
            one(center, 1.0),
        ));
        // 60 degrees off the axis, in a picture with as many columns as the distance has radii.
        if (10.0..1e3).contains(&distance) {
            let view = (center - eye).normalize() + 1.7 * across;
            let lens = Lens::Viewport { vw: 8.0, vh: 6.0, distance: 1.0 };
            scenes.push(picture(eye, Look::View(view), lens, [96, 64], one(center, 0.2 * distance)));
        }
    }
    Ok(scenes)
}

/// 40 spheres of radius 0.5 to 1.5; the lens narrows with the distance.
pub(super) fn clusters(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scene = |distance: f64| {
        let spheres = cloud(&mut random, 40, DVec3::ZERO, 4.0, [0.5, 1.5]);
        let eye = distance * DVec3::new(1.0, -2.0, 3.0) / 14f64.sqrt();
        picture(eye, Look::At(DVec3::ZERO), filled_by(4.0 / distance), [64, 48], spheres)
    };
    Ok(decades(3, 9, 1).map(&mut scene).collect())
}

/// Scene and eye both far from the origin, where coordinates are coarse.
pub(super) fn offsets(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scene = |offset: f64| {
        let at = offset * DVec3::new(1.0, -2.0, 3.0);
        let eye = at + DVec3::new(9.0, 5.0, 12.0);
        let spheres = cloud(&mut random, 40, at, 3.0, [0.5, 1.5]);
        picture(eye, Look::At(at), filled_by(0.3), [48, 36], spheres)
    };
    Ok(decades(3, 12, 1).map(&mut scene).collect())
}

/// Observed failures of other renderers.
pub(super) fn peers(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    // A unit sphere filling half the picture, view along (1, 2, 3): wrong at 1e4, missing at 1e8.
    let small = |distance: f64| {
        picture(
            -aslant() * distance,
            Look::At(DVec3::ZERO),
            filled_by(tangent(distance)),
            [96, 64],
            one(DVec3::ZERO, 1.0),
        )
    };
    let mut scenes: Vec<_> = decades(4, 8, 1).map(small).collect();
    // The horizon of a sphere of radius 1e6 from 1 above it, 1,414 away.
    let level = DVec3::new(1.0, 0.1, 0.3);
    let wide = Lens::Vfov { degrees: 50.0, distance: 1.0 };
    scenes.push(picture(DVec3::new(0.0, 1e6 + 1.0, 0.0), Look::View(level), wide, [96, 64], one(DVec3::ZERO, 1e6)));
    // The eye exactly on the surface: |(2, 3, 6)| = 7.
    for view in [DVec3::new(-2.0, -3.0, -5.0), DVec3::new(3.0, -6.0, 2.5)] {
        scenes.push(picture(DVec3::new(2.0, 3.0, 6.0), Look::View(view), wide, [96, 64], one(DVec3::ZERO, 7.0)));
    }
    // 300 spheres shifted by 1e7.
    let at = DVec3::splat(1e7);
    let spheres = cloud(&mut random, 300, at, 1.0, [0.05, 0.1]);
    scenes.push(picture(at + DVec3::new(2.5, 2.0, 3.0), Look::At(at), filled_by(0.25), [96, 64], spheres));
    // And from 800 scene radii through a narrow lens.
    let spheres = cloud(&mut random, 300, DVec3::ZERO, 1.0, [0.05, 0.1]);
    scenes.push(picture(aslant() * 800.0, Look::At(DVec3::ZERO), filled_by(1.0 / 800.0), [96, 64], spheres));
    Ok(scenes)
}
