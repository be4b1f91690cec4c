//! Silhouettes and depth cue: drawn over the colours of a frame or of a sample of it.

use super::depth_cue::DepthCue;
use super::silhouette::{Line, PixelSize, Shown};
use crate::scene::Scene;
use crate::scene::camera::Basis;
use crate::view::View;
use crate::view::backdrop::Backdrop;
use crate::view::picture_rays::PictureRays;
use crate::view::ray::NONE;
use rayon::prelude::*;

/// The effects that are drawn over the colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Finish {
    /// The lines of silhouettes; `None` without.
    pub(crate) line: Option<Line>,
    /// Silhouettes also where spheres touch.
    pub(crate) between: bool,
    pub(crate) depth_cue: bool,
}

impl Finish {
    /// The width, in pixels, of the border around a window on which the window's lines depend; 0 without silhouettes.
    pub(crate) fn margin(self) -> u32 {
        self.line.map_or(0, |line| line.margin())
    }

    /// The depth cue of the frame; `None` where none is requested or no sphere is in front of the eye.
    pub(crate) fn cue(self, scene: &Scene, basis: &Basis) -> Option<DepthCue> {
        if self.depth_cue { DepthCue::of(scene, basis) } else { None }
    }

    /// Draws silhouettes over the colours of a view, from the spheres `ids` that its rays hit.
    pub(crate) fn draw(self, scene: &Scene, view: &View, ids: &[u32], color: &mut [f32]) {
        if let Some(line) = self.line {
            let (depths, width) = (depths(scene, view, ids), view.record.columns as usize);
            let window = view.record.window();
            let (pixel, radii) = (PixelSize::of(view), &scene.spheres.radii);
            Shown { width, ids, depths: &depths, radii, pixel, line }.draw(window.inside(window), self.between, color);
        }
    }
}

/// Fades the colours of a view's rays to the background; `uses_lights` as for [`Backdrop::new`].
pub(crate) fn fade(cue: DepthCue, scene: &Scene, (view, uses_lights): (&View, bool), ids: &[u32], color: &mut [f32]) {
    let backdrop = Backdrop::new(scene, view, uses_lights);
    cue.apply(ids, &depths(scene, view, ids), &|pixel| backdrop.at(pixel), color);
}

/// The planar depth of each pixel's hit in the scene's unit, +inf on a miss.
fn depths(scene: &Scene, view: &View, ids: &[u32]) -> Vec<f64> {
    let (spheres, rays) = (&scene.spheres, PictureRays::new(view));
    let depth = |(pixel, id): (usize, &u32)| match *id {
        NONE => f64::INFINITY,
        id => rays.depth(pixel as u32, spheres.centers[id as usize], spheres.radii[id as usize]),
    };
    ids.par_iter().enumerate().map(depth).collect()
}
