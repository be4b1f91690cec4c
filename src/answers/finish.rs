//! What is drawn over the colours of a frame or of a sample of it: silhouettes and depth cue.

use super::depth_cue::DepthCue;
use super::silhouette::{MARGIN, PixelSize, Shown};
use crate::double_double as dd;
use crate::scene::Scene;
use crate::view::View;
use crate::view::ray::NONE;
use crate::window::Window;
use glam::DVec3;
use rayon::prelude::*;

/// What is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Finish {
    pub(crate) silhouette: bool,
    /// Silhouettes also where spheres touch.
    pub(crate) between: bool,
    pub(crate) depth_cue: bool,
}

impl Finish {
    /// How many pixels around a window its lines depend on.
    pub(crate) fn margin(self) -> u32 {
        if self.silhouette { MARGIN } else { 0 }
    }

    /// The depth cue of the frame; `None` where none is requested or no sphere is in front of the eye.
    pub(crate) fn cue(self, scene: &Scene, view: &View) -> Option<DepthCue> {
        if self.depth_cue { DepthCue::of(scene, &view.basis) } else { None }
    }

    /// Draws the lines of `part` over its colours, from what the pixels' centres of the whole view show.
    pub(crate) fn draw(self, scene: &Scene, view: &View, ids: &[u32], part: Window, color: &mut [f32]) {
        if self.silhouette {
            let (depths, width) = (depths(scene, view, ids), view.record.columns as usize);
            let (pixel, radii) = (PixelSize::of(view), &scene.spheres.radii);
            Shown { width, ids, depths: &depths, radii, pixel }.draw(part, self.between, color);
        }
    }
}

/// Fades the colours of a view's rays.
pub(crate) fn fade(cue: DepthCue, scene: &Scene, view: &View, ids: &[u32], color: &mut [f32]) {
    cue.apply(ids, &depths(scene, view, ids), scene.image.background, color);
}

/// The planar depth of each pixel's hit in the scene's unit, +inf on a miss. f64 without a bound is good for pictures.
fn depths(scene: &Scene, view: &View, ids: &[u32]) -> Vec<f64> {
    let spheres = &scene.spheres;
    // In the frame's unit squares neither overflow nor vanish.
    let scaled = |x: DVec3| x.to_array().map(|x| dd::ldexp(x, -view.unit));
    let depth = |(pixel, id): (usize, &u32)| {
        if *id == NONE {
            return f64::INFINITY;
        }
        let [row, column] = view.record.place(pixel as u32);
        let [i, j] = view.record.sample_position(row, column);
        let direction = view.direction(i, j);
        let d = view.to_world(direction);
        let from = view.basis.e + view.to_world(view.origin(i, j));
        let p = DVec3::from_array(scaled(DVec3::from_array(spheres.centers[*id as usize]) - from));
        let r = dd::ldexp(spheres.radii[*id as usize], -view.unit);
        let (a, b) = (d.length_squared(), p.dot(d));
        let root = (a * r * r - p.cross(d).length_squared()).max(0.0).sqrt();
        let t = if p.length_squared() > r * r { b - root } else { b + root } / a;
        dd::ldexp(-direction[2] * t, view.unit)
    };
    ids.par_iter().enumerate().map(depth).collect()
}
