//! What is drawn over the colours of a frame or of a sample of it: silhouettes and depth cue.

use super::depth_cue::DepthCue;
use super::silhouette::{PixelSize, Shown, with_margin};
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
    /// The window to render, which is wider than `window` where lines depend on neighbours, and the place of `window` in
    /// it.
    pub(crate) fn windows(self, window: Window, width: u32, height: u32) -> [Window; 2] {
        if self.silhouette {
            return with_margin(window, width, height);
        }
        [window, Window { x0: 0, y0: 0, x1: window.width(), y1: window.height() }]
    }

    /// Draws over the colours of `part`, from what the whole view shows.
    pub(crate) fn draw(self, scene: &Scene, view: &View, ids: &[u32], part: Window, color: &mut [f32]) {
        let depths = depths(scene, view, ids);
        let width = view.record.columns as usize;
        if self.silhouette {
            let (pixel, radii) = (PixelSize::of(view), &scene.spheres.radii);
            Shown { width, ids, depths: &depths, radii, pixel }.draw(part, self.between, color);
        }
        if let Some(cue) = DepthCue::of(scene, &view.basis).filter(|_| self.depth_cue) {
            let (ids, depths) = (cut(ids, width, part, 1), cut(&depths, width, part, 1));
            cue.apply(&ids, &depths, scene.image.background, color);
        }
    }
}

/// The numbers of a part of a rectangle, `each` per pixel.
pub(crate) fn cut<T: Copy + Send + Sync>(all: &[T], width: usize, part: Window, each: usize) -> Vec<T> {
    let row = |y: u32| {
        let first = (y as usize * width + part.x0 as usize) * each;
        all[first..first + part.width() as usize * each].iter().copied()
    };
    (part.y0..part.y1).flat_map(row).collect()
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
