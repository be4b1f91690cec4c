//! Silhouettes and depth cue: drawn over the colours of a frame or of a sample of it.

use super::depth_cue::DepthCue;
use super::silhouette::{FACE, Line, PixelSize, Shown};
use crate::scene::Scene;
use crate::scene::camera::Basis;
use crate::view::View;
use crate::view::backdrop::Backdrop;
use crate::view::picture_rays::PictureRays;
use halfline_ground::parallel;
use std::borrow::Cow;

/// The effects that are drawn over the colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Finish {
    /// The lines of silhouettes; `None` without.
    pub(crate) line: Option<Line>,
    /// Silhouettes also where spheres touch.
    pub(crate) between: bool,
    /// The strength of the depth cue; `None` without.
    pub(crate) depth_cue: Option<f64>,
}

impl Finish {
    /// The width, in pixels, of the border around a window on which the window's lines depend; 0 without silhouettes.
    pub(crate) fn margin(self) -> u32 {
        self.line.map_or(0, |line| line.margin())
    }

    /// The depth cue of the frame; `None` where none is requested or no sphere is in front of the eye.
    pub(crate) fn cue(self, scene: &Scene, basis: &Basis) -> Option<DepthCue> {
        DepthCue::of(scene, basis, self.depth_cue?)
    }

    /// Fades the colours of a view to the background by `cue`, if there is one, and draws silhouettes over them, from the
    /// spheres `ids` that its rays hit, and their depths where these are known; `uses_lights` as for [`Backdrop::new`].
    pub(crate) fn draw(
        self,
        cue: Option<DepthCue>,
        scene: &Scene,
        (view, uses_lights): (&View, bool),
        (ids, depths): (&[u32], Option<&[f64]>),
        color: &mut [f32],
    ) {
        if cue.is_none() && self.line.is_none() {
            return;
        }
        let depths = &depths.map_or_else(|| self::depths(scene, view, ids).into(), Cow::Borrowed)[..];
        if let Some(cue) = cue {
            let backdrop = Backdrop::new(scene, view, uses_lights);
            cue.apply(ids, depths, &|pixel| backdrop.at(pixel), color);
        }
        if let Some(line) = self.line {
            let faces = scene.spheres.cuts.as_ref().map(|_| on_faces(scene, view, ids));
            let ids = faces.as_deref().unwrap_or(ids);
            let (width, pixel, radii) = (view.record.columns as usize, PixelSize::of(view), &scene.spheres.radii);
            let materials = scene.spheres.materials.as_ref();
            Shown { width, ids, depths, radii, materials, pixel, line }.draw(self.between, color);
        }
    }
}

/// The spheres of pixels, marked by [`FACE`] where the hit is on a plane that cuts the sphere.
fn on_faces(scene: &Scene, view: &View, ids: &[u32]) -> Vec<u32> {
    let (spheres, rays) = (&scene.spheres, PictureRays::new(view, scene.spheres.cuts.as_ref()));
    let is_face = |n: usize, id: u32| spheres.is_cut(id) && rays.hit(n as u32, spheres.ball(id), true).face;
    let mut marked = vec![0; ids.len()];
    parallel::each(&mut marked, |n, to| *to = if is_face(n, ids[n]) { ids[n] | FACE } else { ids[n] });
    marked
}

/// The planar depth of each pixel's hit in the scene's unit, +inf on a miss.
fn depths(scene: &Scene, view: &View, ids: &[u32]) -> Vec<f64> {
    const BLOCK: usize = 1 << 10;
    let (rays, mut depths) = (PictureRays::new(view, scene.spheres.cuts.as_ref()), vec![0.0; ids.len()]);
    parallel::fill(&mut depths[..], BLOCK, &|pixels, depths| {
        rays.depths(pixels.start as u32, &ids[pixels], &scene.spheres, depths);
    });
    depths
}
