//! Given rays: the rays of a curved lens, which a tree certifies or a method tests.

use super::{Engine, Found, ViewRays};
use crate::answers::layers::Layers;
use crate::answers::raw::Raw;
use crate::answers::settle::Settled;
use crate::cpu::given_certified::{Given, NearestHit};
use crate::cpu::given_cuts::GivenCuts;
use crate::double_double as dd;
use crate::exact::Truth;
use crate::frame::Aov;
use crate::render::plan::GivenPlan;
use crate::render::rendering::Rendering;
use crate::render::trace::{Hits, Rays, Tracer};
use crate::scene::Scene;
use crate::search::tree::Tree;
use crate::settings::{Search, Settings};
use crate::view::View;
use crate::view::picture_rays::PictureRays;
use crate::view::ray::NONE;
use glam::{DVec3, Vec3};
use halfline_ground::error::{Error, Result};
use halfline_ground::parallel::{self, CHEAP};
use halfline_ground::progress::Step;
use std::ops::Range;
use std::sync::Arc;

/// Rays that are traced at once.
pub(in crate::render) const BLOCK: usize = 1 << 18;

/// The plan of the rays, and what is kept between samples.
pub(in crate::render) struct GivenRays {
    plan: GivenPlan,
    tolerance: f64,
    /// Whether the errors of distances are bounded.
    bounds: bool,
    /// The tree over the spheres, once it is needed; `None` without spheres.
    tree: Option<Arc<Tree>>,
}

impl GivenRays {
    pub(in crate::render) fn new(plan: GivenPlan, settings: &Settings) -> Self {
        let (tolerance, bounds) = (settings.promise().relative(), settings.asks(&[Aov::Bound]));
        Self { plan, tolerance, bounds, tree: None }
    }

    /// Builds the tree, unless it is known.
    fn build_tree(&mut self, Rendering { renderer, log, .. }: &mut Rendering<'_>, scene: &Scene) {
        if self.tree.is_none() {
            let frame = renderer.frames;
            self.tree = log.time("tree", || renderer.order_of(&scene.spheres).tree(&scene.spheres, frame));
        }
    }
}

/// The viewing rays of a view in the world, of all its pixels.
struct PixelRays {
    origin: [[f64; 3]; 1],
    directions: Vec<[f64; 3]>,
    /// 0 for a pixel without a ray, which so misses; empty where all have one.
    limits: Vec<f64>,
}

impl PixelRays {
    fn of(view: &View) -> Self {
        let own = view.curved.as_ref().map_or(&[][..], |curved| curved.directions());
        let in_world = |direction: &[f64; 3]| match direction {
            [0.0, 0.0, 0.0] => [0.0, 0.0, 1.0],
            direction => view.to_world(*direction).to_array(),
        };
        let limit = |direction: &[f64; 3]| if *direction == [0.0; 3] { 0.0 } else { f64::INFINITY };
        let lacks = parallel::any(own.len(), CHEAP, &|range| own[range].contains(&[0.0; 3]));
        Self {
            origin: [view.basis.e.to_array()],
            directions: parallel::map(own, in_world),
            limits: if lacks { parallel::map(own, limit) } else { Vec::new() },
        }
    }

    /// The rays of some pixels.
    fn part(&self, pixels: Range<usize>) -> Rays<'_> {
        let limits = self.limits.get(pixels.clone()).unwrap_or_default();
        Rays { origins: &self.origin, directions: &self.directions[pixels], limits }
    }
}

impl Engine for GivenRays {
    fn first_hits(&mut self, at: &mut Rendering<'_>, rays: ViewRays<'_>, raw: &mut Raw) -> Result<Found> {
        let ViewRays { scene, view, kernel } = rays;
        if self.plan.certifies() {
            self.build_tree(at, scene);
        }
        let Rendering { renderer, log, .. } = at;
        let all = PixelRays::of(view);
        let (count, watch) = (all.directions.len(), renderer.watch.clone());
        let mut plan = self.plan.clone();
        plan.kernel.normal = kernel.has_normals();
        let promise = (self.tolerance, self.bounds && kernel.t);
        let mut tracer = Tracer::of_frame(renderer, &scene.spheres, plan, self.tree.clone(), promise);
        let mut settled = Vec::new();
        let doing = watch.begin(Step::Trace, count as u64);
        for first in (0..count).step_by(BLOCK) {
            let block = first..count.min(first + BLOCK);
            let part = all.part(block.clone());
            let (hits, decided) = log.time("trace", || tracer.answers(&part))?;
            write(rays, (block.start, &part), &hits, raw);
            settled.extend(decided.into_iter().filter(|one| part.ray(one.pixel as usize).limit > 0.0).map(|one| {
                let pixel = block.start as u32 + one.pixel;
                let [row, column] = view.record.position(pixel);
                // A given ray has no view axis.
                let along = -view.direction(row, column)[2];
                Settled { pixel, truth: one.truth.map(|truth| Truth { depth: along * truth.t, ..truth }) }
            }));
            if !doing.next(block.len() as u64) {
                return Err(Error::Interrupted);
            }
        }
        doing.end()?;
        Ok(Found::Hits(settled))
    }

    fn behind(
        &mut self,
        at: &mut Rendering<'_>,
        ViewRays { scene, view, .. }: ViewRays<'_>,
        layers: Layers<'_>,
    ) -> Result<Vec<Vec<u32>>> {
        let count = layers.first.len();
        // A method finds the first hits alone.
        self.build_tree(at, scene);
        let Some(tree) = &self.tree else { return Ok(vec![vec![NONE; count]; layers.more as usize]) };
        let all = PixelRays::of(view);
        let rays = &all.part(0..count);
        let cuts = scene.spheres.cuts.as_ref().map(GivenCuts::new);
        let (all, tolerance) = (self.plan.search == Search::All, self.tolerance);
        let given = Given { tree, rays, all, tolerance, cuts: cuts.as_ref() };
        let next = |pixel: usize, found: &[u32]| -> Option<u32> {
            let ray = rays.ray(pixel);
            let counts = |id: u32| !found.contains(&id) && layers.counts(&scene.spheres, pixel, id);
            match given.nearest_among(&ray, &counts) {
                NearestHit::Miss => None,
                NearestHit::Hit { id, .. } => Some(id),
                NearestHit::Unsure => given.judged(&ray, &scene.spheres, &counts).map(|truth| truth.id),
            }
        };
        layers.peel(&at.renderer.watch, &next)
    }
}

/// Writes the hits of the rays of the pixels from `first` on.
fn write(of: ViewRays<'_>, (first, rays): (usize, &Rays<'_>), hits: &Hits, raw: &mut Raw) {
    let ViewRays { scene, view, kernel } = of;
    let pixels = first..first + hits.id.len();
    raw.id[pixels.clone()].copy_from_slice(bytemuck::cast_slice(&hits.id));
    if let Some(depths) = raw.depth.get_mut(pixels.clone()) {
        parallel::zip(depths, &hits.t, |depth, t| *depth = dd::ldexp(*t, -view.unit));
    }
    if let Some(bounds) = &hits.bound {
        raw.depth_interval.resize(raw.id.len(), 0.0);
        // Of t, as the other engines bound their depths.
        parallel::each(&mut raw.depth_interval[pixels.clone()], |n, width| {
            let error = bounds[n] * (hits.t[n] / hits.distance[n]);
            *width = (dd::ldexp(error, -view.unit) as f32).next_up();
        });
    }
    let triples = 3 * pixels.start..3 * pixels.end;
    if let (Some(normals), Some(own)) = (raw.normal.get_mut(triples.clone()), &hits.normal) {
        normals.copy_from_slice(own.as_flattened());
    }
    if let (Some(shade), Some(colors)) = (kernel.shade, raw.color.get_mut(triples)) {
        let shown = PictureRays::new(view, scene.spheres.cuts.as_ref());
        let own = |n: usize, id: u32| {
            let is_face = || shown.hit((first + n) as u32, scene.spheres.ball(id), true).face;
            scene.spheres.color(id, scene.spheres.is_cut(id) && is_face())
        };
        let normal = |n: usize| hits.normal.as_ref().map_or(DVec3::ZERO, |normals| Vec3::from(normals[n]).as_dvec3());
        parallel::each(colors.as_chunks_mut::<3>().0, |n, color| {
            *color = match hits.id[n] {
                ..0 => scene.image.background,
                id => {
                    let (along, normal) = (DVec3::from_array(rays.directions[n]), normal(n));
                    shade.in_world(normal, -normal.dot(along) / along.length(), own(n, id as u32))
                }
            };
        });
    }
}
