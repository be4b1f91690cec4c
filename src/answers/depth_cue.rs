//! Depth cue: the colour of a hit fades toward the background with its depth.

use crate::scene::Scene;
use crate::scene::camera::Basis;
use crate::view::ray::NONE;
use glam::DVec3;
use halfline_ground::parallel::{self, CHEAP};
use std::ops::Range;

/// The least and the largest depth of a sphere along the view axis; +inf and -inf for one that is behind the eye, or beyond f64.
#[inline(always)]
pub(crate) fn reach(basis: &Basis, center: [f64; 3], radius: f64) -> [f64; 2] {
    let depth = (basis.e - DVec3::from_array(center)).dot(basis.w);
    let [near, far] = [depth - radius, depth + radius];
    let counts = near.is_finite() & far.is_finite() & (far > 0.0);
    if counts { [near, far] } else { [f64::INFINITY, f64::NEG_INFINITY] }
}

/// The least and the largest distance of a sphere from the eye; the least is not below 0.
fn away(basis: &Basis, center: [f64; 3], radius: f64) -> [f64; 2] {
    let distance = (DVec3::from_array(center) - basis.e).length();
    [(distance - radius).max(0.0), distance + radius]
}

/// Depths along the view axis between which the background's share grows, in the scene's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DepthCue {
    /// The share is 0 up to here.
    pub(crate) near: f64,
    /// It is greatest from here on.
    pub(crate) far: f64,
    /// The greatest share.
    pub(crate) most: f64,
}

impl DepthCue {
    /// From the nearest to the farthest depth of the scene's spheres, as far as they lie in front of the eye, whether or
    /// not they are in the picture: so parts of a frame agree. `None` if there are none. Depths of a curved lens, which may see behind the
    /// eye, are distances from it.
    pub(crate) fn of(scene: &Scene, basis: &Basis, most: f64) -> Option<Self> {
        let (spheres, is_curved) = (&scene.spheres, scene.camera.lens.is_curved());
        let joined = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        let depths = |ids: Range<usize>| {
            let all = spheres.centers[ids.clone()].iter().zip(&spheres.radii[ids]);
            all.map(
                |(center, radius)| {
                    if is_curved { away(basis, *center, *radius) } else { reach(basis, *center, *radius) }
                },
            )
            .filter(|[near, _]| near.is_finite())
            .reduce(joined)
        };
        let both = parallel::blocks(0..spheres.len(), CHEAP, &|ids, _| depths(ids));
        both.into_iter().flatten().reduce(joined).map(|[near, far]| Self { near: near.max(0.0), far, most })
    }

    /// The background's share at this depth; 0 for NaN.
    pub(crate) fn share(&self, depth: f64) -> f32 {
        // Halves, so that the difference cannot overflow.
        let part = (0.5 * depth - 0.5 * self.near) / (0.5 * self.far - 0.5 * self.near);
        if part > 0.0 { (self.most * part.min(1.0)) as f32 } else { 0.0 }
    }

    /// Mixes the background of each pixel into the linear RGB of all hits.
    pub(crate) fn apply(
        &self,
        ids: &[u32],
        depths: &[f64],
        background: &(dyn Fn(u32) -> [f32; 3] + Sync),
        color: &mut [f32],
    ) {
        parallel::each(color.as_chunks_mut::<3>().0, |pixel, rgb| {
            let share = if ids[pixel] == NONE { 0.0 } else { self.share(depths[pixel]) };
            if share > 0.0 {
                for (value, behind) in rgb.iter_mut().zip(background(pixel as u32)) {
                    *value += share * (behind - *value);
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, ImagePlane, Look, Spheres};

    fn scene(spheres: &[([f64; 3], f64)]) -> Scene {
        let mut scene = Scene {
            camera: Camera::CANONICAL,
            image: ImagePlane::default(),
            spheres: Spheres::default(),
            lighting: Default::default(),
        };
        spheres.iter().for_each(|(center, radius)| scene.spheres.push(*center, *radius, None));
        scene
    }

    fn cue(spheres: &[([f64; 3], f64)]) -> Option<DepthCue> {
        let scene = scene(spheres);
        DepthCue::of(&scene, &scene.camera.basis().expect("a basis"), 0.6)
    }

    #[test]
    fn the_depths_are_those_of_the_spheres_in_front_of_the_eye() {
        let two = [([5.0, 0.0, -10.0], 1.0), ([0.0, 7.0, -4.0], 2.0)];
        assert_eq!(cue(&two), Some(DepthCue { near: 2.0, far: 11.0, most: 0.6 }));
        // One behind the eye does not count, one around it counts from the eye.
        let behind = ([0.0, 0.0, 50.0], 1.0);
        assert_eq!(cue(&[two[0], two[1], behind]), cue(&two));
        assert_eq!(cue(&[two[0], ([0.0; 3], 3.0)]), Some(DepthCue { near: 0.0, far: 11.0, most: 0.6 }));
        assert_eq!([cue(&[]), cue(&[behind])], [None; 2]);
        // Along the view axis, not the distance.
        let mut turned = scene(&[([10.0, 30.0, 0.0], 1.0)]);
        turned.camera.look = Look::View(DVec3::X);
        let basis = turned.camera.basis().expect("a basis");
        assert_eq!(DepthCue::of(&turned, &basis, 0.6), Some(DepthCue { near: 9.0, far: 11.0, most: 0.6 }));
    }

    #[test]
    fn the_share_grows_from_near_to_far() {
        let cue = DepthCue { near: 2.0, far: 11.0, most: 0.6 };
        let shares: Vec<f32> = (0..=200).map(|k| cue.share(f64::from(k) * 0.1)).collect();
        assert!(shares.windows(2).all(|pair| pair[0] <= pair[1]) && shares[21] > 0.0, "{shares:?}");
        let exact = [cue.share(-1.0), cue.share(2.0), cue.share(6.5), cue.share(11.0), cue.share(f64::INFINITY)];
        assert_eq!(exact, [0.0, 0.0, 0.3, 0.6, 0.6]);
        assert_eq!([cue.share(f64::NAN), cue.share(f64::NEG_INFINITY)], [0.0; 2]);
        assert_eq!(DepthCue { most: 1.0, ..cue }.share(11.0), 1.0);
        // Depths without extent, and of the largest numbers.
        let flat = DepthCue { near: 3.0, far: 3.0, most: 0.6 };
        assert_eq!([flat.share(3.0), flat.share(2.0), flat.share(4.0)], [0.0, 0.0, 0.6]);
        assert_eq!(DepthCue { near: 0.0, far: f64::MAX, most: 0.6 }.share(f64::MAX), 0.6);
    }

    #[test]
    fn hits_are_mixed_with_the_background_and_misses_keep_their_color() {
        let cue = DepthCue { near: 2.0, far: 11.0, most: 0.6 };
        let (ids, inf) = ([4, 4, 4, NONE, 4, NONE, 4], f64::INFINITY);
        let depths = [2.0, 11.0, 6.5, inf, f64::NAN, 5.0, inf];
        let own = [0.75, 0.5, 0.25];
        let mut color: Vec<f32> = ids.iter().flat_map(|_| own).collect();
        cue.apply(&ids, &depths, &|_| [0.0, 0.5, 1.0], &mut color);
        let mixed = |share: f32| [0.75 + share * (0.0 - 0.75), 0.5, 0.25 + share * (1.0 - 0.25)];
        let expected = [own, mixed(0.6), mixed(0.3), own, own, own, mixed(0.6)];
        assert_eq!(color, expected.concat());
        // Monotone to the last bit, in every channel.
        let depths: Vec<f64> = (0..1000).map(|k| 1.9 + 0.01 * f64::from(k)).collect();
        let mut color: Vec<f32> = depths.iter().flat_map(|_| [0.9, 0.1, 0.3]).collect();
        cue.apply(&vec![0; 1000], &depths, &|_| [0.2, 0.7, 0.3], &mut color);
        let steps = || color.chunks_exact(3).zip(color[3..].chunks_exact(3));
        assert!(steps().all(|(a, b)| a[0] >= b[0] && a[1] <= b[1] && a[2] == b[2]));
    }
}
