//! Silhouettes and depth cue: drawn over the colours of a frame or of a sample of it.

use super::depth_cue::DepthCue;
use super::silhouette::{Line, PixelSize, Shown};
use crate::scene::Scene;
use crate::scene::camera::Basis;
use crate::view::View;
use crate::view::backdrop::Backdrop;
use crate::view::picture_rays::PictureRays;
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
    const CHUNK: usize = 1 << 10;
    let (rays, mut depths) = (PictureRays::new(view), vec![0.0; ids.len()]);
    let chunks = ids.par_chunks(CHUNK).zip(depths.par_chunks_mut(CHUNK)).enumerate();
    chunks.for_each(|(n, (ids, depths))| rays.depths((n * CHUNK) as u32, ids, &scene.spheres, depths));
    depths
}
