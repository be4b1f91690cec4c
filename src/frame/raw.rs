//! What a kernel leaves behind, and the frame made of it.

use crate::certify::stage::Depths;
use crate::error::Result;
use crate::exact::Truth;
use crate::frame::{Aov, Buffer, Data};
use crate::kernel::Kernel;
use crate::memory::Pool;
use crate::ray::{NONE, Ray};
use crate::real::Real;
use crate::sample::Sampled;
use crate::settle::Settled;
use crate::shade::{Shade, Surface};
use crate::view::View;
use rayon::prelude::*;

/// The kernel's own buffers, row by row; those nobody asked for are empty.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Raw {
    /// Index of the sphere, [`NONE`] on a miss.
    pub(crate) id: Vec<u32>,
    /// t in the frame's unit; of a certified kernel, the depth relative to the centre's.
    pub(crate) t: Vec<f32>,
    /// What t lacks, where the kernel computes in more than f32; else empty.
    pub(crate) t_low: Vec<f32>,
    /// World normals, three numbers each.
    pub(crate) normal: Vec<f32>,
    /// Linear RGB.
    pub(crate) color: Vec<f32>,
    /// How far the depth may be from the true one, in the frame's unit.
    pub(crate) width: Vec<f32>,
}

impl Raw {
    /// Room for `pixels` answers of `kernel`.
    ///
    /// # Errors
    /// [`Error::Limits`] when the memory cannot be had.
    pub(crate) fn new(kernel: &Kernel, pixels: usize, pool: &Pool) -> Result<Self> {
        Ok(Self {
            id: pool.values(pixels)?,
            t: pool.values(if kernel.t { pixels } else { 0 })?,
            t_low: pool.values(if kernel.t && kernel.is_wide() { pixels } else { 0 })?,
            normal: pool.values(if kernel.normal { 3 * pixels } else { 0 })?,
            color: pool.values(if kernel.shade.is_some() { 3 * pixels } else { 0 })?,
            width: pool.values(if kernel.width { pixels } else { 0 })?,
        })
    }

    /// Copies what the device wrote into the buffer of that binding.
    pub(crate) fn store(&mut self, name: &str, first: usize, pixels: usize, bytes: &[u8]) {
        let (buffer, channels): (&mut [u8], usize) = match name {
            "frame_t" => (bytemuck::cast_slice_mut(&mut self.t), 1),
            "frame_width" => (bytemuck::cast_slice_mut(&mut self.width), 1),
            "frame_t_low" => (bytemuck::cast_slice_mut(&mut self.t_low), 1),
            "frame_normal" => (bytemuck::cast_slice_mut(&mut self.normal), 3),
            "frame_color" => (bytemuck::cast_slice_mut(&mut self.color), 3),
            _ => (bytemuck::cast_slice_mut(&mut self.id), 1),
        };
        let size = 4 * channels;
        buffer[size * first..size * (first + pixels)].copy_from_slice(bytes);
    }

    /// The buffers cut after `first` pixels and then after every `pixels`; those nobody asked for stay empty.
    pub(crate) fn cut(&mut self, first: usize, pixels: usize) -> impl Iterator<Item = Piece<'_>> {
        let mut ts = pieces(&mut self.t, first, pixels);
        let mut lows = pieces(&mut self.t_low, first, pixels);
        let mut normals = pieces(&mut self.normal, 3 * first, 3 * pixels);
        let mut colors = pieces(&mut self.color, 3 * first, 3 * pixels);
        let mut widths = pieces(&mut self.width, first, pixels);
        pieces(&mut self.id, first, pixels).map(move |id| Piece {
            id,
            t: ts.next().unwrap_or_default(),
            t_low: lows.next().unwrap_or_default(),
            normal: normals.next().unwrap_or_default(),
            color: colors.next().unwrap_or_default(),
            width: widths.next().unwrap_or_default(),
        })
    }

    /// Ids and normals of what was settled.
    pub(crate) fn settle(&mut self, settled: &[Settled]) {
        for s in settled {
            let pixel = s.pixel as usize;
            self.id[pixel] = s.truth.map_or(NONE, |truth| truth.id);
            if let Some(normal) = self.normal.get_mut(3 * pixel..3 * pixel + 3) {
                normal.copy_from_slice(&s.truth.map_or([0.0; 3], |truth| truth.normal.map(|x| x as f32)));
            }
        }
    }

    /// Leaves its memory to the next frame.
    pub(crate) fn give_to(self, pool: &Pool) {
        pool.give(self.id);
        [self.t, self.t_low, self.normal, self.color, self.width].into_iter().for_each(|unused| pool.give(unused));
    }

    /// t of a hit in all its parts; 0 where nobody asked for it.
    pub(crate) fn t(&self, pixel: usize) -> f64 {
        let part = |buffer: &[f32]| buffer.get(pixel).map_or(0.0, |x| f64::from(*x));
        part(&self.t) + part(&self.t_low)
    }
}

/// The first `first` values, and then `count` at a time. An empty buffer has one piece, and that is empty.
fn pieces<T>(buffer: &mut [T], first: usize, count: usize) -> impl Iterator<Item = &mut [T]> {
    let (head, rest) = buffer.split_at_mut(first.min(buffer.len()));
    std::iter::once(head).chain(rest.chunks_mut(count))
}

/// Some consecutive pixels of a [`Raw`].
pub(crate) struct Piece<'a> {
    pub(crate) id: &'a mut [u32],
    pub(crate) t: &'a mut [f32],
    pub(crate) t_low: &'a mut [f32],
    pub(crate) normal: &'a mut [f32],
    pub(crate) color: &'a mut [f32],
    pub(crate) width: &'a mut [f32],
}

impl Piece<'_> {
    /// Normal and colour of a pixel by its number here, where they are asked for: frame/normal.wgsl and frame/color.wgsl.
    /// `normal` is that of the canonical camera at a hit.
    pub(crate) fn shade<R: Real>(
        &mut self,
        pixel: usize,
        shade: Option<Shade>,
        surface: &Surface<'_, R>,
        ray: impl FnOnce() -> Ray<R>,
        hit: Option<([f32; 3], u32)>,
    ) {
        if let Some(out) = self.normal.get_mut(3 * pixel..3 * pixel + 3) {
            out.copy_from_slice(&hit.map_or([0.0; 3], |(normal, _)| surface.to_world(normal)));
        }
        if let (Some(shade), Some(out)) = (shade, self.color.get_mut(3 * pixel..3 * pixel + 3)) {
            let [red, green, blue, _] = surface.view.background;
            let rgb = hit.map(|(normal, id)| surface.shade_normal(shade, &ray(), normal, id));
            out.copy_from_slice(&rgb.unwrap_or([red, green, blue]));
        }
    }
}

/// A finished frame's answers: the kernel's, and over them what was settled.
pub(crate) struct Answers<'a> {
    pub(crate) pool: &'a Pool,
    pub(crate) view: &'a View,
    pub(crate) raw: Raw,
    /// Depth of each sphere's centre, to which a certified kernel's t is relative; `None` for the others.
    pub(crate) depths: Option<Depths<'a>>,
    /// In the order of pixels.
    pub(crate) settled: &'a [Settled],
    /// Colour and coverage, where pixels were sampled.
    pub(crate) sampled: Option<Sampled>,
}

/// Relative rounding of a distance made of a depth in f64, and of a settled one: 2^-50, several roundings.
const ROUNDED: f64 = 1.0 / (1u64 << 50) as f64;
/// What a few roundings take below the normal numbers: four of the last steps of f64.
const STEPS: f64 = f64::from_bits(4);

impl Answers<'_> {
    /// The buffers asked for, in f64 where the frame promises f64.
    pub(crate) fn assemble(mut self, aovs: &[Aov]) -> Result<Vec<Buffer>> {
        let (w, h) = (self.view.record.columns as usize, self.view.record.rows as usize);
        self.raw.settle(self.settled);
        let mut wanted: Vec<Aov> = aovs.iter().copied().chain([Aov::Id]).collect();
        wanted.sort_unstable();
        wanted.dedup();
        let inf = f64::INFINITY;
        let mut buffers = Vec::with_capacity(wanted.len());
        for aov in wanted {
            let data = match aov {
                Aov::Color => Data::F32(match &mut self.sampled {
                    Some(sampled) => std::mem::take(&mut sampled.color),
                    None => std::mem::take(&mut self.raw.color),
                }),
                Aov::Normal => Data::F32(std::mem::take(&mut self.raw.normal)),
                // Last of all: the others look at the ids. NONE and -1 are the same bits.
                Aov::Id => continue,
                Aov::Distance => Data::F64(self.fill(inf, |_, d, depth| [depth * length(d)], |t| [t.distance])?),
                Aov::Depth => Data::F64(self.fill(inf, |_, _, depth| [depth], |t| [t.depth])?),
                Aov::Position => {
                    let point = |pixel: usize, d, depth| {
                        let [row, column] = self.row_and_column(pixel);
                        self.view.point(self.view.origin(row, column), d, depth)
                    };
                    Data::F64(self.fill(f64::NAN, point, |t| t.position)?)
                }
                Aov::Bound => {
                    let unit = crate::dd::ldexp(1.0, self.view.unit);
                    let bound = |pixel: usize, d: [f64; 3], depth: f64| match self.raw.width.get(pixel) {
                        Some(width) => [(f64::from(*width) * unit + ROUNDED * depth + STEPS) * length(d)],
                        None => [inf],
                    };
                    Data::F64(self.fill(0.0, bound, |t| [ROUNDED * t.distance + STEPS])?)
                }
                Aov::Alpha => Data::F32(match &mut self.sampled {
                    Some(sampled) => std::mem::take(&mut sampled.alpha),
                    None => self.raw.id.par_iter().map(|id| f32::from(*id != NONE)).collect(),
                }),
                Aov::Mask => Data::U8(self.raw.id.par_iter().map(|id| u8::from(*id != NONE)).collect()),
                Aov::Certainty => {
                    let mut certainty = vec![if self.depths.is_some() { 0 } else { 255 }; w * h];
                    self.settled.iter().for_each(|s| certainty[s.pixel as usize] = 1);
                    Data::U8(certainty)
                }
            };
            buffers.push(Buffer::new(aov, w, h, data)?);
        }
        for unused in [self.raw.t, self.raw.t_low, self.raw.width] {
            self.pool.give(unused);
        }
        let ids = bytemuck::allocation::cast_vec(self.raw.id);
        buffers.push(Buffer::new(Aov::Id, w, h, Data::I32(ids))?);
        buffers.sort_by_key(|b| b.aov);
        Ok(buffers)
    }

    /// Row and column in the full frame of a pixel of the window.
    fn row_and_column(&self, pixel: usize) -> [u32; 2] {
        let record = &self.view.record;
        let width = record.columns as usize;
        [record.first_row + (pixel / width) as u32, record.first_column + (pixel % width) as u32]
    }

    /// One buffer of `N` numbers a pixel: `missed` on a miss, `hit` of pixel, direction (x, y, -1) and depth, and
    /// `truth` where it was settled.
    fn fill<const N: usize>(
        &self,
        missed: f64,
        hit: impl Fn(usize, [f64; 3], f64) -> [f64; N] + Sync,
        truth: impl Fn(&Truth) -> [f64; N],
    ) -> Result<Vec<f64>> {
        let width = self.view.record.columns as usize;
        let unit = crate::dd::ldexp(1.0, self.view.unit);
        let mut out: Vec<f64> = self.pool.values(N * self.raw.id.len())?;
        out.par_chunks_mut(N * width).enumerate().for_each(|(i, row)| {
            for (j, values) in row.chunks_exact_mut(N).enumerate() {
                let pixel = i * width + j;
                let id = self.raw.id[pixel];
                let values = values.first_chunk_mut::<N>();
                if let Some(values) = values {
                    *values = if id == NONE {
                        [missed; N]
                    } else {
                        let [row, column] = self.row_and_column(pixel);
                        let [u, v, w] = self.view.direction(row, column);
                        let t = self.raw.t(pixel) * unit;
                        // A certified depth is relative to its centre's; t of the other forms is along (u, v, -d).
                        let depth = self.depths.as_ref().map_or(-w * t, |depths| depths.of(id) + t);
                        hit(pixel, [u / -w, v / -w, -1.0], depth)
                    };
                }
            }
        });
        for s in self.settled {
            let values = s.truth.as_ref().map_or([missed; N], &truth);
            out[N * s.pixel as usize..][..N].copy_from_slice(&values);
        }
        Ok(out)
    }
}

fn length(d: [f64; 3]) -> f64 {
    d.iter().map(|x| x * x).sum::<f64>().sqrt()
}
