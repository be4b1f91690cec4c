//! Lights and sky at the pixels of a frame: which of them the hit points see, and the colours that follow.

#[cfg(test)]
pub(crate) mod tests;

mod bounce;
mod colors;
mod lighting;
mod point;
mod surface;

use crate::answers::lit::{Chunk, Lit, NOT_CERTIFIED, SETTLED};
use crate::search::tree::lanes::TASK;
use crate::view::directions::PixelSample;
use crate::view::picture_rays::PictureRays;
use crate::view::ray::NONE;
use bounce::Bounces;
use colors::Colors;
use glam::DVec3;
pub(crate) use lighting::{LitScene, Wanted};
use point::PointLight;
use rayon::prelude::*;
use std::cell::OnceCell;
use surface::Surface;

impl LitScene<'_> {
    /// Fills `lit` for the pixels that show these spheres. `go_on` is called before every part of a row with its number
    /// of pixels; after `false` the rest is left unchanged.
    pub(crate) fn fill(&self, ids: &[u32], lit: &mut Lit, go_on: &(dyn Fn(u64) -> bool + Sync)) {
        let lights = self.scene.lighting.lights.len();
        let chunks: Vec<Chunk<'_>> = lit.chunks(ids.len(), TASK, lights).collect();
        let work = |mut chunk: Chunk<'_>| {
            let ids = &ids[chunk.first..chunk.first + chunk.count];
            let mut unsure = Vec::new();
            if go_on(ids.len() as u64) {
                Task { lighting: self, ids, chunk: &mut chunk, unsure: &mut unsure }.work();
            }
            unsure
        };
        lit.unsure = chunks.into_par_iter().flat_map_iter(work).collect();
    }
}

/// Some pixels of one row or more.
struct Task<'a, 'b, 'c> {
    lighting: &'a LitScene<'a>,
    ids: &'a [u32],
    chunk: &'b mut Chunk<'c>,
    unsure: &'b mut Vec<(u32, u8)>,
}

impl Task<'_, '_, '_> {
    fn work(self) {
        let Task { lighting, ids, chunk, unsure } = self;
        let Wanted { color, shadow, occlusion, sky } = lighting.wanted;
        let lights = lighting.scene.lighting.lights.len();
        let mut at_point = PointLight::new(lighting);
        let mut bounces = Bounces::default();
        let rayless = color && lighting.is_rayless();
        let rays = PictureRays::new(lighting.view);
        let left: Vec<usize> = match rayless && !shadow && !occlusion && !sky && Colors::fit(lighting) {
            true => pulp::Arch::new().dispatch(Colors { lighting, rays: &rays, ids, chunk: &mut *chunk }),
            false => (0..ids.len()).collect(),
        };
        for n in left {
            let id = ids[n];
            let pixel = (chunk.first + n) as u32;
            if id == NONE {
                chunk.miss(n, lights, || lighting.backdrop.at(pixel));
                continue;
            }
            let write = |rgb: DVec3, out: &mut [f32]| out[3 * n..3 * n + 3].copy_from_slice(&rgb.as_vec3().to_array());
            let record = &lighting.view.record;
            let [row, column] = record.place(pixel);
            let position = record.sample_position(row, column);
            let point = OnceCell::new();
            let at_hit = || point.get_or_init(|| lighting.point(position, id));
            let (surface, along, sharp) = match color && lighting.bounces > 0 {
                // Rays that go on need the point anyway.
                true => (Surface::from(at_hit()), lighting.direction(position), true),
                false => lighting.surface(&rays, (pixel, id), at_hit),
            };
            let open = lighting.open.map(|open| open.around(row, column, id));
            at_point.see(&surface, along, open.unwrap_or(DVec3::ONE));
            if rayless {
                write(at_point.color(&surface, along), chunk.color);
                if !shadow && !occlusion && !sky {
                    continue;
                }
            }
            let at = PixelSample { row, column, sample: record.sample, seed: lighting.seed };
            let traced = lighting.traced.and_then(|traced| traced.of(pixel));
            match traced.filter(|traced| traced.lights > 0) {
                Some(traced) => at_point.tell_lights(at_hit, |n| traced.is_open(traced.rays + n)),
                None if lighting.asks_lights() => at_point.ask_lights(at_hit(), at),
                None => {}
            }
            match traced.filter(|traced| traced.rays > 0) {
                _ if open.is_some() => {}
                None if lighting.sky.is_none() => {}
                traced => {
                    // The weights of the rays are known as well as their normal.
                    let surface = if sharp { surface } else { at_hit().into() };
                    match traced {
                        Some(traced) => at_point.open_sky(&surface, at, |k| traced.is_open(k)),
                        None => at_point.ask_sky(at_hit(), &surface, at),
                    }
                }
            }
            let settled = point.get().is_some_and(|point| at_point.settle(point, position));
            if shadow {
                let shares = chunk.shadow[n * lights..(n + 1) * lights].iter_mut();
                shares.zip(at_point.hidden()).for_each(|(out, x)| *out = x);
            }
            if occlusion {
                chunk.occlusion[n] = at_point.open() as f32;
            }
            if sky {
                write(at_point.sky_light(), chunk.sky);
            }
            let mut proved = true;
            if color && !rayless {
                let mut rgb = at_point.color(&surface, along);
                if let Some(point) = point.get().filter(|_| lighting.bounces > 0) {
                    let (more, sure) = bounces.follow(&mut at_point, (*point, along), at);
                    (rgb, proved) = (rgb + more, sure);
                }
                write(rgb, chunk.color);
            }
            if !proved {
                unsure.push((pixel, NOT_CERTIFIED));
            } else if settled {
                unsure.push((pixel, SETTLED));
            }
        }
    }
}
