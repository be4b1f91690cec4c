//! What a kernel leaves behind, and the frame made of it.

use crate::error::{Error, Result};
use crate::frame::{Aov, Buffer, Data};
use crate::plan::Kernel;
use crate::ray::NONE;
use crate::view::View;
use rayon::prelude::*;

/// The kernel's own buffers, row by row; those nobody asked for are empty.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Raw {
    /// Index of the sphere, [`NONE`] on a miss.
    pub(crate) id: Vec<u32>,
    /// t in the frame's unit.
    pub(crate) t: Vec<f32>,
    /// What t lacks, where the kernel computes in more than f32; else empty.
    pub(crate) t_low: Vec<f32>,
    /// World normals, three numbers each.
    pub(crate) normal: Vec<f32>,
    /// Linear RGB.
    pub(crate) color: Vec<f32>,
}

impl Raw {
    /// Room for `pixels` answers of `kernel`.
    ///
    /// # Errors
    /// [`Error::Limits`] when the memory cannot be had.
    pub(crate) fn new(kernel: &Kernel, pixels: usize) -> Result<Self> {
        Ok(Self {
            id: room(pixels)?,
            t: room(if kernel.t { pixels } else { 0 })?,
            t_low: room(if kernel.t && kernel.method.is_wide() { pixels } else { 0 })?,
            normal: room(if kernel.normal { 3 * pixels } else { 0 })?,
            color: room(if kernel.shade.is_some() { 3 * pixels } else { 0 })?,
        })
    }

    /// Copies what the device wrote into the buffer of that binding.
    pub(crate) fn store(&mut self, name: &str, first: usize, pixels: usize, bytes: &[u8]) {
        let (buffer, channels): (&mut [u8], usize) = match name {
            "frame_t" => (bytemuck::cast_slice_mut(&mut self.t), 1),
            "frame_t_low" => (bytemuck::cast_slice_mut(&mut self.t_low), 1),
            "frame_normal" => (bytemuck::cast_slice_mut(&mut self.normal), 3),
            "frame_color" => (bytemuck::cast_slice_mut(&mut self.color), 3),
            _ => (bytemuck::cast_slice_mut(&mut self.id), 1),
        };
        let size = 4 * channels;
        buffer[size * first..size * (first + pixels)].copy_from_slice(bytes);
    }

    /// t of a hit in all its parts.
    pub(crate) fn t(&self, pixel: usize) -> f64 {
        f64::from(self.t[pixel]) + self.t_low.get(pixel).map_or(0.0, |low| f64::from(*low))
    }

    /// How many rays hit something.
    pub(crate) fn hits(&self) -> u64 {
        self.id.par_iter().filter(|id| **id != NONE).count() as u64
    }

    /// The buffers asked for, in f64 where the frame promises f64: t is all that f32 was needed for.
    pub(crate) fn assemble(self, view: &View, aovs: &[Aov]) -> Result<Vec<Buffer>> {
        let (w, h) = (view.record.width as usize, view.record.height as usize);
        let mut wanted: Vec<Aov> = aovs.iter().copied().chain([Aov::Id]).collect();
        wanted.sort_unstable();
        wanted.dedup();
        let mut buffers = Vec::with_capacity(wanted.len());
        for aov in wanted {
            let data = match aov {
                Aov::Color | Aov::Normal | Aov::Id => continue,
                Aov::Distance => Data::F64(self.lengths(view, |d| d.iter().map(|x| x * x).sum::<f64>().sqrt())?),
                Aov::Depth => Data::F64(self.lengths(view, |d| -d[2])?),
                Aov::Position => Data::F64(self.positions(view)?),
                Aov::Mask => Data::U8(self.id.par_iter().map(|id| u8::from(*id != NONE)).collect()),
                Aov::Certainty => Data::U8(vec![255; w * h]),
                Aov::Bound => {
                    let bound = |id: &u32| if *id == NONE { 0.0 } else { f64::INFINITY };
                    Data::F64(self.id.par_iter().map(bound).collect())
                }
            };
            buffers.push(buffer(aov, w, h, data));
        }
        if aovs.contains(&Aov::Color) {
            buffers.push(buffer(Aov::Color, w, h, Data::F32(self.color)));
        }
        if aovs.contains(&Aov::Normal) {
            buffers.push(buffer(Aov::Normal, w, h, Data::F32(self.normal)));
        }
        // NONE and -1 are the same bits.
        buffers.push(buffer(Aov::Id, w, h, Data::I32(bytemuck::allocation::cast_vec(self.id))));
        buffers.sort_by_key(|b| b.aov);
        Ok(buffers)
    }

    /// t times `along` of the viewing direction, in the scene's unit; +inf on a miss.
    fn lengths(&self, view: &View, along: impl Fn([f64; 3]) -> f64 + Sync) -> Result<Vec<f64>> {
        let width = view.record.width as usize;
        let unit = crate::dd::ldexp(1.0, view.unit);
        let mut out: Vec<f64> = room(self.id.len())?;
        out.par_chunks_mut(width).enumerate().for_each(|(i, row)| {
            for (j, x) in row.iter_mut().enumerate() {
                let pixel = i * width + j;
                *x = match self.id[pixel] {
                    NONE => f64::INFINITY,
                    _ => self.t(pixel) * along(view.direction(i, j)) * unit,
                };
            }
        });
        Ok(out)
    }

    /// Hit points in world space; NaN on a miss.
    fn positions(&self, view: &View) -> Result<Vec<f64>> {
        let width = view.record.width as usize;
        let unit = crate::dd::ldexp(1.0, view.unit);
        let mut out: Vec<f64> = room(3 * self.id.len())?;
        out.par_chunks_mut(3 * width).enumerate().for_each(|(i, row)| {
            for (j, point) in row.chunks_exact_mut(3).enumerate() {
                let pixel = i * width + j;
                let at = match self.id[pixel] {
                    NONE => [f64::NAN; 3],
                    _ => view.point(view.direction(i, j), self.t(pixel) * unit),
                };
                point.copy_from_slice(&at);
            }
        });
        Ok(out)
    }
}

fn buffer(aov: Aov, w: usize, h: usize, data: Data) -> Buffer {
    let shape = if aov.channels() == 1 { vec![h, w] } else { vec![h, w, aov.channels()] };
    Buffer { aov, shape, data }
}

/// A zeroed vector, or an error instead of an abort when the memory cannot be had.
fn room<T: Clone + Default>(n: usize) -> Result<Vec<T>> {
    let mut v = Vec::new();
    v.try_reserve_exact(n).map_err(|_| Error::Limits {
        problem: format!("{} bytes for one buffer of the frame cannot be had", n.saturating_mul(size_of::<T>())),
        mend: "render a smaller --size or fewer buffers".into(),
    })?;
    v.resize(n, T::default());
    Ok(v)
}
