//! Lights and sky at the pixels of a frame: the shares of them that the hit points see, and the colours that follow.

#[cfg(test)]
pub(crate) mod tests;

mod bounce;
mod colors;
mod lighting;
mod point;
mod run;
mod sky_sums;
mod streams;
mod surface;

use crate::answers::light::{Chunk, LightBuffers, NOT_CERTIFIED, PixelLight, SETTLED};
use crate::answers::open_sky::SkyAtHit;
use crate::search::tree::lanes::RAYS_PER_TASK;
use crate::view::directions::PixelSample;
use crate::view::picture_rays::PictureRays;
use crate::view::ray::NONE;
use bounce::{Onward, follow};
use colors::Colors;
use glam::{DVec3, Vec3};
use halfline_ground::parallel;
pub(crate) use lighting::{LightOutputs, LightingContext};
use point::PointLight;
use run::Run;
use sky_sums::KnownSky;
use std::cell::OnceCell;
use surface::Surface;

/// Hits whose rays one task traces.
const HITS_PER_TASK: usize = 16;

impl LightingContext<'_> {
    /// Fills `buffers` for the pixels that show these spheres. `go_on` is called before every part of a row with its number
    /// of pixels; after `false` the rest is left unchanged.
    pub(crate) fn fill(&self, ids: &[u32], buffers: &mut LightBuffers, go_on: &(dyn Fn(u64) -> bool + Sync)) {
        let lights = self.scene.lighting.lights.len();
        let mut chunks: Vec<Chunk<'_>> = buffers.chunks(ids.len(), RAYS_PER_TASK, lights).collect();
        let work = |chunk: &mut Chunk<'_>| {
            let ids = &ids[chunk.first..chunk.first + chunk.count];
            if go_on(ids.len() as u64) { self.fill_chunk(ids, chunk) } else { Vec::new() }
        };
        let unsure = parallel::blocks(&mut chunks[..], 1, &|_, chunk| work(&mut chunk[0]));
        drop(chunks);
        buffers.unsure = unsure.concat();
    }

    /// The rays toward the sky from the hits of some pixels, each on a sphere.
    pub(crate) fn sky_at(&self, hits: &[(u32, u32)]) -> Vec<SkyAtHit> {
        parallel::collect(hits.len(), HITS_PER_TASK, &|range, out| {
            let mut shader = PixelShader::new(self);
            out.extend(hits[range].iter().map(|(pixel, id)| shader.shade_pixel(*pixel, *id).sky));
        })
    }

    /// Fills some pixels of one row or more. Returns the pixels that are not certain, each with its certainty.
    fn fill_chunk(&self, ids: &[u32], chunk: &mut Chunk<'_>) -> Vec<(u32, u8)> {
        let mut unsure = Vec::new();
        let mut shader = PixelShader::new(self);
        let rays = &shader.rays;
        let left: Vec<usize> = if shader.rayless && shader.color_alone && Colors::fit(self) {
            pulp::Arch::new().dispatch(Colors(Run { lighting: self, rays, ids, chunk: &mut *chunk }))
        } else if let Some(traced) = self.traced.filter(|traced| self.outputs.is_sky_alone() && traced.rays > 0) {
            let run = Run { lighting: self, rays, ids, chunk: &mut *chunk };
            pulp::Arch::new().dispatch(KnownSky { run, traced })
        } else {
            rays.depths(chunk.first as u32, &ids[..chunk.depth.len()], &self.scene.spheres, chunk.depth);
            (0..ids.len()).collect()
        };
        for n in left {
            let pixel = (chunk.first + n) as u32;
            let light = if ids[n] == NONE { shader.background(pixel) } else { shader.shade_pixel(pixel, ids[n]) };
            chunk.write(n, &light);
            unsure.extend(light.certainty.map(|certainty| (pixel, certainty)));
        }
        unsure
    }
}

/// Light at the pixels of one frame, one after the other.
struct PixelShader<'a> {
    lighting: &'a LightingContext<'a>,
    rays: PictureRays<'a>,
    at_point: PointLight<'a>,
    /// Buffer of [`follow`], empty between pixels.
    onward: Vec<Onward>,
    /// The colour is requested, and needs no rays.
    rayless: bool,
    /// Nothing but the colour is requested.
    color_alone: bool,
    shadow: Vec<f32>,
}

impl<'a> PixelShader<'a> {
    fn new(lighting: &'a LightingContext<'a>) -> Self {
        let LightOutputs { color, shadow, occlusion, sky, .. } = lighting.outputs;
        Self {
            lighting,
            rays: lighting.picture_rays(),
            at_point: PointLight::new(lighting),
            onward: Vec::new(),
            rayless: color && lighting.is_rayless(),
            color_alone: color && !shadow && !occlusion && !sky,
            shadow: Vec::new(),
        }
    }

    /// The light of a pixel that shows no sphere.
    fn background(&mut self, pixel: u32) -> PixelLight<'_> {
        let LightingContext { scene, backdrop, outputs, .. } = self.lighting;
        let lights = if outputs.shadow { scene.lighting.lights.len() } else { 0 };
        self.shadow.clear();
        self.shadow.resize(lights, 0.0);
        let color = if outputs.color { Vec3::from_array(backdrop.at(pixel)).as_dvec3() } else { DVec3::ZERO };
        PixelLight { color, shadow: &self.shadow, occlusion: 1.0, ..PixelLight::default() }
    }

    /// The light of a pixel that shows this sphere.
    fn shade_pixel(&mut self, pixel: u32, id: u32) -> PixelLight<'_> {
        let Self { lighting, rays, at_point, onward, rayless, color_alone, shadow } = self;
        let LightOutputs { color, .. } = lighting.outputs;
        let record = &lighting.view.record;
        let [row, column] = record.place(pixel);
        let position = record.sample_position(row, column);
        let point = OnceCell::new();
        let at_hit = || point.get_or_init(|| lighting.point(position, id));
        // Rays that go on need the point anyway.
        let (surface, along, sharp) = if color && lighting.bounces > 0 {
            (Surface::from(at_hit()), lighting.direction(position), true)
        } else {
            lighting.surface(rays, pixel, id, at_hit)
        };
        let open = lighting.open.map(|open| open.around(row, column, id));
        at_point.begin(&surface, along, open.unwrap_or_default());
        let mut light = PixelLight::default();
        if *rayless {
            light.color = at_point.color(&surface, along);
            if *color_alone {
                return light;
            }
        }
        let at = PixelSample { row, column, sample: record.sample, seed: lighting.seed };
        let traced = lighting.traced.and_then(|traced| traced.of(pixel));
        if let Some(traced) = traced.filter(|traced| traced.lights > 0) {
            at_point.apply_traced_lights(at_hit, |n| traced.is_open(traced.rays + n));
        } else if lighting.asks_lights() {
            at_point.trace_lights(at_hit(), at);
        }
        let traced = traced.filter(|traced| traced.rays > 0);
        if open.is_none() && (traced.is_some() || lighting.sky.is_some()) {
            // The weights of the rays are known as well as their normal.
            let surface = if sharp { surface } else { at_hit().into() };
            match traced {
                Some(traced) => at_point.open_sky(&surface, at, |k| traced.is_open(k)),
                None => at_point.trace_sky(at_hit(), &surface, at),
            }
        }
        let settled = point.get().is_some_and(|point| at_point.settle(point, position));
        light.certainty = settled.then_some(SETTLED);
        shadow.clear();
        if lighting.outputs.shadow {
            shadow.extend(at_point.hidden());
        }
        light.shadow = shadow;
        light.occlusion = at_point.open() as f32;
        if lighting.outputs.sky {
            light.sky = at_point.sky_at(&surface);
        }
        if color && !*rayless {
            light.color = at_point.color(&surface, along);
            if let Some(point) = point.get().filter(|_| lighting.bounces > 0) {
                let (more, proved) = follow(onward, at_point, *point, along, at);
                light.color += more;
                if !proved {
                    light.certainty = Some(NOT_CERTIFIED);
                }
            }
        }
        light
    }
}
