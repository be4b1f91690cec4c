//! Lights and sky at the pixels of a frame: which of them the hit points see, and the colours that follow.

#[cfg(test)]
mod tests;

mod bounce;
mod point;

use crate::answers::lit::{Chunk, Lit, NOT_CERTIFIED, OpenSky, SETTLED};
use crate::certify::surface::SurfacePoint;
use crate::exact::Judge;
use crate::scene::{DEFAULT_COLOR, Material, Scene, Sky};
use crate::search::tree::Tree;
use crate::search::tree::lanes::{Lanes, TASK, Work, dispatch};
use crate::view::View;
use crate::view::directions::{DiscPoints, PixelSample, SkyDirections};
use crate::view::ray::NONE;
use bounce::Bounces;
use glam::{DVec3, Vec3};
use point::PointLight;
use rayon::prelude::*;

/// What is computed of lights and sky.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Wanted {
    /// The colour of the picture.
    pub(crate) color: bool,
    /// The share of each light that is hidden.
    pub(crate) shadow: bool,
    /// The share of the sky that is open.
    pub(crate) occlusion: bool,
}

/// A scene set up for its lights.
pub(crate) struct Lighting<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) view: &'a View,
    pub(crate) tree: &'a Tree,
    pub(crate) wanted: Wanted,
    /// Decides what f64 leaves unsure; `None` for answers that are not certified.
    pub(crate) judge: Option<&'a Judge>,
    /// The judge decides every ray.
    pub(crate) exact: bool,
    pub(crate) sky: Option<Sky>,
    pub(crate) directions: &'a SkyDirections,
    pub(crate) disc: &'a DiscPoints,
    pub(crate) seed: u32,
    /// The open share of the sky at the hits of viewing rays, if it is known.
    pub(crate) open: Option<OpenSky<'a>>,
    /// How often a ray goes on; 0 where no material asks for it.
    pub(crate) bounces: u32,
}

impl Wanted {
    /// Whether there is anything to compute.
    pub(crate) fn is_any(self) -> bool {
        self.color || self.shadow || self.occlusion
    }
}

impl Lighting<'_> {
    /// Fills `lit` for the pixels that show these spheres. `go_on` is called before every part of a row with its number
    /// of pixels; after `false` the rest is left unchanged.
    pub(crate) fn fill(&self, ids: &[u32], lit: &mut Lit, go_on: &(dyn Fn(u64) -> bool + Sync)) {
        let lights = self.scene.lighting.lights.len();
        let chunks: Vec<Chunk<'_>> = lit.chunks(ids.len(), TASK, lights).collect();
        let work = |mut chunk: Chunk<'_>| {
            let ids = &ids[chunk.first..chunk.first + chunk.count];
            let mut unsure = Vec::new();
            if go_on(ids.len() as u64) {
                dispatch(Task { lighting: self, ids, chunk: &mut chunk, unsure: &mut unsure });
            }
            unsure
        };
        lit.unsure = chunks.into_par_iter().flat_map_iter(work).collect();
    }

    /// The hit point of a pixel.
    fn point(&self, pixel: u32, id: u32) -> SurfacePoint {
        let sphere = (id, self.scene.spheres.centers[id as usize], self.scene.spheres.radii[id as usize]);
        let placement = &self.tree.placement;
        let [i, j] = self.position(pixel);
        let point = SurfacePoint::seen(self.view, placement, [i, j], sphere);
        match self.judge {
            None => point.trusted(placement),
            Some(_) if point.is_sharp(placement) => point,
            Some(judge) => match judge.hit_of(i, j, (sphere.1, sphere.2)) {
                Some(truth) => SurfacePoint::judged(placement, &truth, sphere),
                None => point,
            },
        }
    }

    fn material(&self, id: u32) -> Material {
        self.scene.spheres.materials.as_ref().map_or(Material::default(), |materials| materials.of(id))
    }

    fn own_color(&self, id: u32) -> DVec3 {
        let color = self.scene.spheres.colors.as_ref().map_or(DEFAULT_COLOR, |colors| colors[id as usize]);
        Vec3::from_array(color).as_dvec3()
    }

    /// The unit direction of a pixel's viewing ray.
    fn direction(&self, pixel: u32) -> DVec3 {
        let [i, j] = self.position(pixel);
        self.view.to_world(self.view.direction(i, j)).normalize()
    }

    /// Row and column of a pixel's ray, in the finer frame of its samples.
    fn position(&self, pixel: u32) -> [u32; 2] {
        let [row, column] = self.view.record.place(pixel);
        self.view.record.sample_position(row, column)
    }
}

/// Some pixels of one row or more.
struct Task<'a, 'b, 'c> {
    lighting: &'a Lighting<'a>,
    ids: &'a [u32],
    chunk: &'b mut Chunk<'c>,
    unsure: &'b mut Vec<(u32, u8)>,
}

impl Work for Task<'_, '_, '_> {
    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        let Task { lighting, ids, chunk, unsure } = self;
        let Wanted { color, shadow, occlusion } = lighting.wanted;
        let lights = lighting.scene.lighting.lights.len();
        let mut at_point = PointLight::new(lighting);
        let mut bounces = Bounces::default();
        for (n, &id) in ids.iter().enumerate() {
            let pixel = (chunk.first + n) as u32;
            if id == NONE {
                chunk.miss(n, lights, lighting.scene.image.background);
                continue;
            }
            let record = &lighting.view.record;
            let [row, column] = record.place(pixel);
            let at = PixelSample { row, column, sample: record.sample, seed: lighting.seed };
            let point = lighting.point(pixel, id);
            let along = lighting.direction(pixel);
            match lighting.open {
                None => at_point.see(lanes, &point, along, at),
                Some(open) => at_point.see_lights(lanes, &point, along, at, open.around(row, column, id)),
            }
            let settled = at_point.settle(&point, lighting.position(pixel));
            if shadow {
                let shares = chunk.shadow[n * lights..(n + 1) * lights].iter_mut();
                shares.zip(at_point.hidden()).for_each(|(out, x)| *out = x);
            }
            if occlusion {
                chunk.occlusion[n] = at_point.open() as f32;
            }
            let mut proved = true;
            if color {
                let mut rgb = at_point.color(&point, along);
                if lighting.bounces > 0 {
                    let (more, sure) = bounces.follow(lanes, &mut at_point, (point, along), at);
                    (rgb, proved) = (rgb + more, sure);
                }
                chunk.color[3 * n..3 * n + 3].copy_from_slice(&rgb.as_vec3().to_array());
            }
            if !proved {
                unsure.push((pixel, NOT_CERTIFIED));
            } else if settled {
                unsure.push((pixel, SETTLED));
            }
        }
    }
}
