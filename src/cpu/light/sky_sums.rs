//! Sums over rays toward the sky whose answers are known, for eight pixels at once: the same bits as one by one.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays")]

use super::lighting::LightingContext;
use crate::answers::light::{Chunk, Traced};
use crate::answers::open_sky::SkyCounts;
use crate::number::vector::LANES;
use crate::view::RayKind;
use crate::view::directions::PixelSample;
use crate::view::picture_rays::PictureRays;
use crate::view::ray::NONE;
use bytemuck::Zeroable;
use pulp::NullaryFnOnce;

/// Some pixels of a frame that asks for rays toward the sky alone.
pub(super) struct KnownSky<'a, 'b, 'c> {
    pub(super) lighting: &'a LightingContext<'a>,
    pub(super) traced: Traced<'a>,
    pub(super) rays: &'a PictureRays<'a>,
    pub(super) ids: &'a [u32],
    pub(super) chunk: &'b mut Chunk<'c>,
}

/// Numbers of some pixels, one array per component. Lanes that show no sphere are not read.
#[derive(Zeroable)]
struct Lanes {
    position: [[u32; LANES]; 2],
    center: [[f64; LANES]; 3],
    radius: [f64; LANES],
    normal: [[f64; LANES]; 3],
    is_known: [u64; LANES],
}

/// The directions from some pixels, and their answers: one if nothing hides the sky there, else 0.
#[derive(Clone, Copy, Zeroable)]
struct Directions {
    toward: [[f64; LANES]; 3],
    open: [f64; LANES],
}

impl KnownSky<'_, '_, '_> {
    /// Writes where some pixels are and what they show. Returns the pixels that are left.
    #[inline(always)]
    fn gather(&self, first: usize, lanes: &mut Lanes, directions: &mut [Directions]) -> [bool; LANES] {
        let (record, spheres) = (&self.lighting.view.record, &self.lighting.scene.spheres);
        let (mut is_left, start) = ([false; LANES], (self.chunk.first + first) as u32);
        lanes.position = record.positions(start);
        for ((l, &id), [row, column]) in self.ids[first..].iter().take(LANES).enumerate().zip(record.places(start)) {
            let pixel = start + l as u32;
            let Some(own) = self.traced.of(pixel).filter(|_| id != NONE) else {
                is_left[l] = id != NONE;
                continue;
            };
            let center = spheres.centers[id as usize];
            lanes.radius[l] = spheres.radii[id as usize];
            for k in 0..3 {
                lanes.center[k][l] = center[k];
            }
            let at = PixelSample { row, column, sample: record.sample, seed: self.lighting.seed };
            for (ray, (direction, out)) in self.lighting.directions.of(at, 0).iter().zip(&mut *directions).enumerate() {
                for k in 0..3 {
                    out.toward[k][l] = direction[k].into();
                }
                out.open[l] = if own.is_open(ray) { 1.0 } else { 0.0 };
            }
        }
        is_left
    }
}

impl NullaryFnOnce for KnownSky<'_, '_, '_> {
    /// The pixels that are left: the device or the streams did not decide their rays, or f64 alone does not know their normals.
    type Output = Vec<usize>;

    #[inline(always)]
    fn call(self) -> Vec<usize> {
        let (kind, mut left) = (self.lighting.view.kind(), Vec::new());
        let mut directions = vec![Directions::zeroed(); self.traced.rays];
        for first in (0..self.ids.len()).step_by(LANES) {
            let mut lanes = Lanes::zeroed();
            let is_left = self.gather(first, &mut lanes, &mut directions);
            match kind {
                RayKind::Perspective => hits(self.rays, RayKind::Perspective, &mut lanes),
                kind => hits(self.rays, kind, &mut lanes),
            }
            let sums = sums(self.lighting, &lanes, &directions);
            let counted = SkyCounts::of(&lanes.normal, &sums, directions.len() as u32);
            for (l, id) in self.ids[first..].iter().take(LANES).enumerate() {
                if is_left[l] || *id != NONE && lanes.is_known[l] == 0 {
                    left.push(first + l);
                } else {
                    self.chunk.write_counts(first + l, &counted, (*id != NONE).then_some(l));
                }
            }
        }
        left
    }
}

/// Writes the normals of some pixels.
#[inline(always)]
fn hits(rays: &PictureRays<'_>, kind: RayKind, lanes: &mut Lanes) {
    for l in 0..LANES {
        let center = [lanes.center[0][l], lanes.center[1][l], lanes.center[2][l]];
        let hit = rays.hit_at(kind, [lanes.position[0][l], lanes.position[1][l]], center, lanes.radius[l]);
        lanes.is_known[l] = u64::from(hit.near & hit.sharp);
        (lanes.normal[0][l], lanes.normal[1][l], lanes.normal[2][l]) = (hit.normal.x, hit.normal.y, hit.normal.z);
    }
}

/// The vectors of [`SkySums`] for some pixels.
#[inline(always)]
fn sums(lighting: &LightingContext<'_>, lanes: &Lanes, directions: &[Directions]) -> [[[f64; LANES]; 3]; 4] {
    let (mut sums, normal) = ([[[0.0; LANES]; 3]; 4], lanes.normal);
    for Directions { toward, open } in directions {
        for l in 0..LANES {
            let cosine = normal[0][l] * toward[0][l] + normal[1][l] * toward[1][l] + normal[2][l] * toward[2][l];
            let side = if cosine < 0.0 { -1.0 } else { 1.0 };
            let outward = [side * toward[0][l], side * toward[1][l], side * toward[2][l]];
            for k in 0..3 {
                sums[0][k][l] += outward[k];
                sums[1][k][l] += open[l] * outward[k];
            }
            if let Some(colors) = &lighting.colors {
                let zenith = colors.gradient.zenith(outward.into());
                for k in 0..3 {
                    sums[2][k][l] += outward[k] * zenith;
                    sums[3][k][l] += open[l] * (outward[k] * zenith);
                }
            }
        }
    }
    sums
}
