//! Sums over rays toward the sky whose answers are known, for eight pixels at once: the same bits as one by one.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays")]

use super::lighting::LightingContext;
use super::run::Run;
use crate::answers::light::Traced;
use crate::answers::open_sky::SkyCounts;
use crate::number::vector::LANES;
use crate::view::directions::PixelSample;
use crate::view::picture_rays::PictureHits;
use crate::view::ray::NONE;
use bytemuck::Zeroable;
use pulp::NullaryFnOnce;

/// The rays toward the sky of pixels for which only these are requested.
pub(super) struct KnownSky<'a, 'b, 'c> {
    pub(super) run: Run<'a, 'b, 'c>,
    pub(super) traced: Traced<'a>,
}

/// The directions from some pixels, and their answers: one if nothing hides the sky there, else 0.
#[derive(Clone, Copy, Zeroable)]
struct Directions {
    toward: [[f64; LANES]; 3],
    open: [f64; LANES],
}

impl KnownSky<'_, '_, '_> {
    /// Writes the directions from some pixels, and the answers. Returns the pixels that are left.
    #[inline(always)]
    fn gather(&self, first: usize, directions: &mut [Directions]) -> [bool; LANES] {
        let Run { lighting, ids, .. } = self.run;
        let (mut is_left, start, record) = ([false; LANES], self.run.pixel(first), &lighting.view.record);
        for ((l, &id), [row, column]) in ids[first..].iter().take(LANES).enumerate().zip(record.places(start)) {
            let Some(own) = self.traced.of(start + l as u32).filter(|_| id != NONE) else {
                is_left[l] = id != NONE;
                continue;
            };
            let at = PixelSample { row, column, sample: record.sample, seed: lighting.seed };
            for (ray, (direction, out)) in lighting.directions.of(at, 0).iter().zip(&mut *directions).enumerate() {
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
        let Run { lighting, rays, ids, .. } = self.run;
        let (mut directions, mut left) = (vec![Directions::zeroed(); self.traced.rays], Vec::new());
        for first in (0..ids.len()).step_by(LANES) {
            let is_left = self.gather(first, &mut directions);
            let PictureHits { normal, near, sharp, .. } = rays.hits(&self.run.shown(first));
            let sums = sums(lighting, &normal, &directions);
            let counted = SkyCounts::of(&normal, &sums, directions.len() as u32);
            for (l, id) in ids[first..].iter().take(LANES).enumerate() {
                if is_left[l] || *id != NONE && near[l] & sharp[l] == 0 {
                    left.push(first + l);
                } else {
                    self.run.chunk.write_counts(first + l, &counted, (*id != NONE).then_some(l));
                }
            }
        }
        left
    }
}

/// The vectors of [`SkySums`] for some pixels.
#[inline(always)]
fn sums(
    lighting: &LightingContext<'_>,
    normal: &[[f64; LANES]; 3],
    directions: &[Directions],
) -> [[[f64; LANES]; 3]; 4] {
    let mut sums = [[[0.0; LANES]; 3]; 4];
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
