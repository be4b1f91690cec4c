//! Pictures while the camera moves: soon, by one ray for each pixel, lit from the eye.
//!
//! Two ways make them: a frame of the renderer, which stages all spheres for each camera, and a tree of the spheres, whose cost
//! grows with the pixels. Both are timed, and the faster one is taken.

use super::rays::ViewingRays;
use super::tree::Tree;
use glam::{DVec3, Vec3};
use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::frame::report::Report;
use halfline::frame::srgb;
use halfline::render::Renderer;
use halfline::scene::{DEFAULT_COLOR, Lighting, Scene};
use halfline::settings::{Accuracy, Look, Settings};
use halfline::shade::Shade;
use halfline::trace::Hits;
use halfline_viewer::Pixels;
use rayon::prelude::*;
use std::time::Instant;

/// A frame that takes longer than this is worth a tree, milliseconds: with fewer than ten pictures a second hands are lost.
const SLOW: f64 = 40.0;

/// Frames of the same spheres before a tree is built: a film shows each once.
const STANDING: u32 = 2;

/// What is known about the spheres that move.
#[derive(Default)]
pub(super) struct Moving {
    /// The number of the frame of the file.
    frame: u64,
    /// How many pictures of it were made.
    count: u32,
    tree: Option<Tree>,
    /// The time of the last frame of the renderer, and that of the tree for each pixel, milliseconds.
    staged: f64,
    traced: Option<f64>,
}

impl Moving {
    /// The picture of a scene, which is that of frame `number` of the file.
    ///
    /// # Errors
    /// Those of a frame.
    pub(super) fn render(
        &mut self,
        renderer: &mut Renderer,
        (number, scene): (u64, &Scene),
        settings: &Settings,
    ) -> Result<(Pixels, Report)> {
        if self.frame != number {
            *self = Self { frame: number, ..Self::default() };
        }
        self.count += 1;
        let start = Instant::now();
        let milliseconds = || start.elapsed().as_secs_f64() * 1e3;
        let pixels = f64::from(scene.image.width) * f64::from(scene.image.height);
        let is_faster = self.traced.is_none_or(|each| each * pixels < self.staged);
        let is_built = self.tree.as_mut().is_some_and(Tree::is_built);
        if let Some(tree) = self.tree.as_ref().filter(|_| is_faster && is_built) {
            let moved = by_tree(tree, scene, settings)?;
            self.traced = Some(milliseconds() / pixels);
            return Ok(moved);
        }
        let moved = by_frame(renderer, scene, settings)?;
        self.staged = milliseconds();
        if self.staged > SLOW && self.count > STANDING && self.tree.is_none() && scene.spheres.materials.is_none() {
            self.tree = Tree::of(scene.spheres.clone());
        }
        Ok(moved)
    }
}

fn by_frame(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Result<(Pixels, Report)> {
    let scene = Scene { lighting: Lighting::from_the_eye(), spheres: scene.spheres.clone(), ..*scene };
    let aovs = vec![Aov::Color];
    let settings = Settings { aovs, samples: 1, aperture: None, silhouette: false, ..settings.clone() };
    let frame = renderer.render(&scene, &settings)?;
    let levels = frame.levels().ok_or_else(|| Error::settings("no picture is requested", "remove --aov"))?;
    let pixels = Pixels::Rgb { size: [frame.width, frame.height], levels };
    let report = Report { look: Some(Look::Plain.name()), warnings: Vec::new(), ..frame.report.clone() };
    renderer.recycle(frame);
    Ok((pixels, report))
}

fn by_tree(tree: &Tree, scene: &Scene, settings: &Settings) -> Result<(Pixels, Report)> {
    let size = [scene.image.width, scene.image.height];
    let rays = ViewingRays::new(&scene.camera, size)?;
    let hits = tree.hits(&rays)?;
    let background = scene.image.background.map(srgb::level);
    let levels = (0..rays.len()).into_par_iter().flat_map_iter(|n| match usize::try_from(hits.id[n]) {
        Ok(id) => shaded(scene, settings.shade, rays.nth(n)[1], normal(&hits, n), id).map(srgb::level),
        Err(_) => background,
    });
    let (rays, settled) =
        (rays.len() as u64, hits.certainty.par_iter().filter(|certainty| **certainty == 1).count() as u64);
    let report = Report {
        accuracy: Accuracy::Certified.name(),
        rays,
        certified: (rays - settled) as f64 / rays as f64,
        settled,
        adapter: "cpu".into(),
        look: Some(Look::Plain.name()),
        samples: 1,
        ..Report::default()
    };
    Ok((Pixels::Rgb { size, levels: levels.collect() }, report))
}

/// The linear colour of a hit, as the kernels shade without lights.
fn shaded(scene: &Scene, shade: Shade, direction: DVec3, normal: Vec3, id: usize) -> [f32; 3] {
    let own = scene.spheres.colors.as_ref().map_or(DEFAULT_COLOR, |colors| colors[id]);
    match shade {
        Shade::Flat => own,
        Shade::Normal => normal.to_array().map(|x| 0.5 * x + 0.5),
        Shade::Headlight => own.map(|channel| channel * normal.dot(-direction.normalize().as_vec3()).max(0.0)),
    }
}

fn normal(hits: &Hits, n: usize) -> Vec3 {
    hits.normal.as_ref().map_or(Vec3::Z, |normals| Vec3::from_array(normals[n]))
}
