//! The frame's buffers, assembled from the kernel's output and the settled pixels.

use super::light::{LightBuffers, NOT_CERTIFIED, SETTLED};
use super::raw::Raw;
use super::samples::Means;
use super::settle::Settled;
use crate::double_double as dd;
use crate::exact::Truth;
use crate::frame::{Aov, Buffer, Data};
use crate::number::vector::vectorized;
use crate::view::View;
use crate::view::ray::NONE;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::parallel;

/// The answers of a finished frame: the kernel's, and the settled pixels over them.
pub(crate) struct Answers<'a> {
    pub(crate) pool: &'a Pool,
    pub(crate) view: &'a View,
    pub(crate) raw: Raw,
    /// Whether answers are proved or settled; otherwise none is.
    pub(crate) promised: bool,
    /// In pixel order.
    pub(crate) settled: &'a [Settled],
    /// Colour and coverage, with several samples per pixel.
    pub(crate) sampled: Option<Means>,
    /// The buffers of lights and sky.
    pub(crate) light: LightBuffers,
}

/// Relative rounding error of a distance computed from a depth in f64, and of a settled one: 2^-50, several roundings.
const ROUNDED: f64 = 1.0 / (1u64 << 50) as f64;
/// Absolute error of a few roundings below the normal numbers: four steps of the smallest subnormal.
pub(crate) const STEPS: f64 = f64::from_bits(4);

/// The bound of the error of a settled distance.
pub(crate) fn settled_bound(distance: f64) -> f64 {
    ROUNDED * distance + STEPS
}

impl Answers<'_> {
    /// The requested buffers, in f64 where the frame promises f64.
    pub(crate) fn assemble(mut self, aovs: &[Aov]) -> Result<Vec<Buffer>> {
        let (w, h) = (self.view.record.columns as usize, self.view.record.rows as usize);
        let mut requested: Vec<Aov> = aovs.iter().copied().chain([Aov::Id]).collect();
        requested.sort_unstable();
        requested.dedup();
        let inf = f64::INFINITY;
        let mut buffers = Vec::with_capacity(requested.len());
        for aov in requested {
            let data = match aov {
                Aov::Color => Data::F32(match &mut self.sampled {
                    Some(sampled) => std::mem::take(&mut sampled.color),
                    None if self.raw.color.is_empty() => std::mem::take(&mut self.light.color),
                    None => std::mem::take(&mut self.raw.color),
                }),
                Aov::Normal => Data::F32(std::mem::take(&mut self.raw.normal)),
                // Ids come last because the other buffers read them. NONE and -1 are the same bits.
                Aov::Id => continue,
                Aov::Distance => Data::F64(self.fill(inf, |_, d, depth| [depth * length(d)], |t| [t.distance])?),
                Aov::Depth => Data::F64(self.fill(inf, |_, d, depth| [-d[2] * depth], |t| [t.depth])?),
                Aov::Position => {
                    let point = |pixel: usize, d, depth| {
                        let [row, column] = self.view.record.position(pixel as u32);
                        self.view.point(self.view.origin(row, column), d, depth)
                    };
                    Data::F64(self.fill(f64::NAN, point, |t| t.position)?)
                }
                Aov::Bound => {
                    let unit = dd::ldexp(1.0, self.view.unit);
                    let bound = |pixel: usize, d: [f64; 3], depth: f64| match self.raw.depth_interval.get(pixel) {
                        Some(width) => [(f64::from(*width) * unit + ROUNDED * depth + STEPS) * length(d)],
                        None => [inf],
                    };
                    Data::F64(self.fill(0.0, bound, |t| [settled_bound(t.distance)])?)
                }
                Aov::Alpha => Data::F32(match &mut self.sampled {
                    Some(sampled) => std::mem::take(&mut sampled.alpha),
                    None => parallel::map(&self.raw.id, |id| f32::from(*id != NONE)),
                }),
                Aov::Shadow => Data::F32(std::mem::take(&mut self.light.shadow)),
                Aov::Occlusion => Data::F32(std::mem::take(&mut self.light.occlusion)),
                Aov::Mask => Data::U8(parallel::map(&self.raw.id, |id| u8::from(*id != NONE))),
                Aov::Certainty => {
                    let mut certainty = vec![if self.promised { 0 } else { NOT_CERTIFIED }; w * h];
                    if self.promised {
                        self.settled.iter().for_each(|s| certainty[s.pixel as usize] = SETTLED);
                        self.light.unsure.iter().for_each(|(pixel, known)| certainty[*pixel as usize] = *known);
                    }
                    Data::U8(certainty)
                }
            };
            buffers.push(Buffer::new(aov, w, h, data)?);
        }
        let ids = bytemuck::allocation::cast_vec(std::mem::take(&mut self.raw.id));
        self.raw.put_back(self.pool);
        buffers.push(Buffer::new(Aov::Id, w, h, Data::I32(ids))?);
        buffers.sort_by_key(|b| b.aov);
        Ok(buffers)
    }

    /// One buffer of `N` numbers per pixel: `missed` on a miss, `hit` of pixel, direction (x, y, -1) and depth, for a curved lens its
    /// direction and t, and `truth` where the pixel was settled.
    fn fill<const N: usize>(
        &self,
        missed: f64,
        hit: impl Fn(usize, [f64; 3], f64) -> [f64; N] + Sync,
        truth: impl Fn(&Truth) -> [f64; N],
    ) -> Result<Vec<f64>> {
        let width = self.view.record.columns as usize;
        let unit = dd::ldexp(1.0, self.view.unit);
        let mut out: Vec<f64> = self.pool.values(N * self.raw.id.len())?;
        // Rays of pixels' centres: of a column all have the same x, of a row the same y.
        let direction = |row: usize, column: usize| {
            let [row, column] = self.view.record.position((row * width + column) as u32);
            let [u, v, w] = self.view.direction(row, column);
            ([u / -w, v / -w], w)
        };
        let xs: Vec<f64> = (0..width).map(|j| direction(0, j).0[0]).collect();
        // What was not requested is 0.
        let (none, nowhere) = (vec![0.0; width], vec![0.0; width]);
        // The depths of a certified kernel are relative to the depths of the spheres' centres.
        let (raw, xs, hit, certify) = (&self.raw, &xs[..], &hit, !self.raw.depth.is_empty());
        let curved = self.view.curved.as_ref().map(|curved| curved.directions());
        parallel::chunks(&mut out, N * width, &|i, out| {
            let ([_, y], w) = direction(i, 0);
            let first = i * width;
            let ids = &raw.id[first..first + width];
            if let Some(directions) = curved {
                for (j, out) in out.as_chunks_mut::<N>().0.iter_mut().enumerate() {
                    let t = raw.depth.get(first + j).map_or(0.0, |t| t * unit);
                    *out = if ids[j] == NONE { [missed; N] } else { hit(first + j, directions[first + j], t) };
                }
                return;
            }
            // In the frame's unit: t in two parts, and the depths of centres.
            let [high, low] = [&raw.t, &raw.t_low].map(|t| t.get(first..first + width).unwrap_or(&none));
            let centers = raw.depth.get(first..first + width).unwrap_or(&nowhere);
            vectorized!({
                let (high, low, centers) = (&high[..width], &low[..width], &centers[..width]);
                let (ids, xs, out) = (&ids[..width], &xs[..width], &mut out.as_chunks_mut::<N>().0[..width]);
                for j in 0..width {
                    let t = (f64::from(high[j]) + f64::from(low[j])) * unit;
                    // A certified depth is relative to its centre's depth; the other methods give t along (u, v, -d).
                    let depth = if certify { centers[j] * unit + t } else { -w * t };
                    let values = hit(first + j, [xs[j], y, -1.0], depth);
                    for k in 0..N {
                        out[j][k] = if ids[j] == NONE { missed } else { values[k] };
                    }
                }
            });
        });
        for s in self.settled {
            let values = s.truth.as_ref().map_or([missed; N], &truth);
            out[N * s.pixel as usize..][..N].copy_from_slice(&values);
        }
        Ok(out)
    }
}

#[inline(always)]
fn length(d: [f64; 3]) -> f64 {
    d.iter().map(|x| x * x).sum::<f64>().sqrt()
}
