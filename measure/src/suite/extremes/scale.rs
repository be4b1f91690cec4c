//! Very small, very large, very wide and very narrow scenes.

use super::parts::{aslant, cloud, decades, filled_by, one, picture, tangent};
use crate::suite::Random;
use glam::DVec3;
use halfline::error::Result;
use halfline::scene::camera::{Lens, Look};
use halfline::scene::{Scene, Spheres};

/// A cluster about the origin, scaled; seen from outside and from within.
pub(super) fn sizes(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for scale in decades(-30, 30, 10).chain([1e-250, 1e-140, 1e140, 1e250]) {
        for away in [9.0, 0.5] {
            let spheres = cloud(&mut random, 60, DVec3::ZERO, 3.0 * scale, [0.3 * scale, scale]);
            let lens = Lens::Vfov { degrees: 45.0, distance: 1.0 };
            scenes.push(picture(aslant() * away * scale, Look::View(-aslant()), lens, [32, 24], spheres));
        }
    }
    Ok(scenes)
}

/// Spheres of all sizes, each with a radius of a tenth to a third of its distance.
pub(super) fn mixed(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scene = |eye: DVec3| {
        let mut spheres = Spheres::default();
        for _ in 0..300 {
            let far = 10f64.powf(9.0 * (2.0 * random.unit() - 1.0));
            let center = eye + far * DVec3::from_array(random.cube());
            spheres.push(center.to_array(), far * (0.02 + 0.1 * random.unit()), None);
        }
        picture(eye, Look::View(aslant()), Lens::Vfov { degrees: 80.0, distance: 1.0 }, [64, 48], spheres)
    };
    Ok(vec![scene(DVec3::ZERO), scene(DVec3::new(-3e-9, 1e-9, 2e-9))])
}

/// |d| from 1e-20 to 1e20: the viewport and its distance together.
pub(super) fn viewports(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scene = |unit: f64| {
        let spheres = cloud(&mut random, 60, DVec3::ZERO, 3.0, [0.1, 1.0]);
        let lens = Lens::Viewport { vw: 1.2 * unit, vh: 0.7 * unit, distance: 1.1 * unit };
        picture(aslant() * 7.0, Look::At(DVec3::ZERO), lens, [32, 24], spheres)
    };
    Ok(decades(-20, 20, 5).map(&mut scene).collect())
}

/// Nearly up to a half space, from among the spheres and from the front of a large one.
pub(super) fn wide(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for degrees in [120.0, 160.0, 175.0, 178.0, 179.9, 179.999_999, 179.999_999_999] {
        let lens = Lens::Vfov { degrees, distance: 1.0 };
        let among = cloud(&mut random, 120, DVec3::ZERO, 3.0, [0.1, 0.6]);
        scenes.push(picture(DVec3::new(0.1, 0.2, 0.3), Look::View(aslant()), lens, [48, 36], among));
        // Completely in front of the eye, so that only a wide lens sees them far off the axis.
        let mut spheres = cloud(&mut random, 40, aslant() * 6.0, 4.0, [0.1, 0.8]);
        spheres.push((aslant() * 1e3).to_array(), 990.0, None);
        scenes.push(picture(DVec3::ZERO, Look::View(aslant()), lens, [48, 36], spheres));
    }
    Ok(scenes)
}

/// Down to 1e-28 degrees, at the silhouette of a unit sphere, of two that overlap, and within a picture's disc.
pub(super) fn long(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for degrees in decades(-28, 0, 2) {
        let eye = DVec3::new(5.0, -3.0, 4.0);
        let center = DVec3::from_array(random.cube());
        let (p, lens) = (center - eye, Lens::Vfov { degrees, distance: 1.0 });
        let across = p.cross(aslant()).normalize();
        let (sine, far) = (1.0 / p.length(), p.length());
        let edge = p / far * (1.0 - sine * sine).sqrt() + across * sine;
        let mut spheres = one(center, 1.0);
        scenes.push(picture(eye, Look::View(edge), lens, [32, 24], spheres.clone()));
        // A second one intersects it, so their seam runs through the picture.
        spheres.push((center + 0.5 * across).to_array(), 1.0, None);
        // A circle of radius sqrt(1 - 1/16) about the middle between them, turned to the eye.
        let out = 0.6 * across.cross(p / far) - 0.8 * p / far;
        let seam = p + 0.25 * across + (15.0f64 / 16.0).sqrt() * out;
        scenes.push(picture(eye, Look::View(seam), lens, [32, 24], spheres));
    }
    Ok(scenes)
}

/// The smallest and the thinnest pictures.
pub(super) fn slivers(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for size in [[1, 1], [1, 2], [2, 1], [1, 97], [3001, 1], [3, 3]] {
        for degrees in [20.0, 100.0] {
            let spheres = cloud(&mut random, 50, DVec3::ZERO, 2.0, [0.2, 0.7]);
            let (vh, vw) = (2.0 * f64::to_radians(degrees / 2.0).tan(), f64::to_radians(degrees / 2.0).tan());
            let lens = Lens::Viewport { vw, vh, distance: 1.0 };
            scenes.push(picture(aslant() * 6.0, Look::At(DVec3::splat(0.1)), lens, size, spheres));
        }
    }
    Ok(scenes)
}

/// Thousands of spheres with a diameter of a thousandth of a pixel, every other one at a pixel's ray.
pub(super) fn dust(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for distance in [10.0, 1e5] {
        let eye = aslant() * distance;
        let lens = filled_by(tangent(distance));
        let mut scene = picture(eye, Look::View(-aslant()), lens, [64, 48], Spheres::default());
        let basis = scene.camera.basis()?;
        let lens = scene.camera.viewport(64, 48)?;
        let pitch = lens.vw / 64.0 * distance;
        for n in 0..3000 {
            let anywhere = [64.0 * random.unit(), 48.0 * random.unit()];
            // A pixel's centre within a radius each way: some are hit, some are not.
            let at = if n % 2 == 0 { anywhere.map(|x| x.floor() + 0.5) } else { anywhere };
            let shift = DVec3::from_array(random.cube()) * 1e-3 * pitch;
            let [u, v] = [(at[0] / 64.0 - 0.5) * lens.vw, (0.5 - at[1] / 48.0) * lens.vh];
            let depth = distance * (1.0 + 0.1 * random.unit());
            let center = eye + depth * (basis.u * u + basis.v * v - basis.w) + shift;
            scene.spheres.push(center.to_array(), 1e-3 * pitch, None);
        }
        scenes.push(scene);
    }
    Ok(scenes)
}

/// Pixels up to 1e12 times as wide as high, or as high as wide.
pub(super) fn stretched(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for stretch in [1e-12, 1e-6, 1e-2, 1e3, 1e7] {
        for [vw, vh] in [[1.0, stretch], [stretch, 1.0]] {
            let spheres = cloud(&mut random, 60, DVec3::ZERO, 2.0, [0.2, 0.7]);
            let lens = Lens::Viewport { vw, vh, distance: 1.0 };
            scenes.push(picture(aslant() * 5.0, Look::At(DVec3::splat(0.1)), lens, [32, 24], spheres));
        }
    }
    Ok(scenes)
}

/// An up vector almost parallel to the view, so that the roll depends on the last bits; near and far from the origin.
pub(super) fn rolled(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for sine in [1e-14, 1e-11, 1e-7] {
        for (offset, lens) in [(0.0, 0.4), (1e6, 0.4), (0.3, 1e-4), (1e6, 1e-8), (3.0, 4.0)] {
            let at = offset * DVec3::new(1.0, -2.0, 3.0) + DVec3::from_array(random.cube());
            let eye = at + 5.0 * aslant();
            let spheres = cloud(&mut random, 60, at, 2.0, [0.2, 0.7]);
            let mut scene = picture(eye, Look::At(at), filled_by(lens), [32, 24], spheres);
            scene.camera.up = (eye - at).normalize() + sine * DVec3::from_array(random.cube());
            scenes.push(scene);
        }
    }
    Ok(scenes)
}

/// Depths from 1e-45 to 1e40 in one frame: the eye is so close to small spheres that f32 has no normal numbers for them
/// beside the large ones.
pub(super) fn span(seed: u64) -> Result<Vec<Scene>> {
    let mut random = Random(seed);
    let mut scenes = Vec::new();
    for (tiny, huge) in [(1e-20, 1e30), (1e-25, 1e35), (1e-30, 1e30), (1e-30, 1e40)] {
        for close in [1e-15, 1e-13, 1e-9, 0.3] {
            let mut spheres = cloud(&mut random, 20, DVec3::ZERO, 3.0 * huge, [0.1 * huge, huge]);
            for _ in 0..6 {
                // At a distance slightly more than its radius: its surface is `close` radii away.
                let away = tiny * (1.0 + random.unit()) * (aslant() + 0.5 * DVec3::from_array(random.cube()));
                spheres.push(away.to_array(), away.length() * (1.0 - close * (1.0 + random.unit())), None);
            }
            let lens = Lens::Vfov { degrees: 120.0, distance: 1.0 };
            scenes.push(picture(DVec3::ZERO, Look::View(aslant()), lens, [32, 24], spheres));
        }
    }
    Ok(scenes)
}
