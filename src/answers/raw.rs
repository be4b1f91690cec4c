//! The buffers that a kernel writes.

use super::settle::Settled;
use crate::kernel::Kernel;
use crate::view::ray::NONE;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::parallel;

/// The output buffers of a kernel in row order; buffers that were not requested are empty.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Raw {
    /// Index of the sphere; [`NONE`] for a miss.
    pub(crate) id: Vec<u32>,
    /// t in the frame's unit. For a certified kernel: the depth relative to the depth of the sphere's centre.
    pub(crate) t: Vec<f32>,
    /// The low part of t if the kernel computes in more than f32; empty otherwise.
    pub(crate) t_low: Vec<f32>,
    /// World normals, three values each.
    pub(crate) normal: Vec<f32>,
    /// Linear RGB.
    pub(crate) color: Vec<f32>,
    /// Bound of the depth's error, in the frame's unit.
    pub(crate) depth_interval: Vec<f32>,
    /// The depth of the sphere's centre in the frame's unit, to which a certified kernel's t is relative; 0 for a general
    /// sphere; of given rays t.
    pub(crate) depth: Vec<f64>,
}

/// Bytes that one job copies.
const BYTES_PER_JOB: usize = 1 << 20;

impl Raw {
    /// Allocates the buffers for `pixels` answers of `kernel`.
    ///
    /// # Errors
    /// [`Error::Limits`] if the allocation fails.
    pub(crate) fn new(kernel: &Kernel, pixels: usize, pool: &Pool) -> Result<Self> {
        Ok(Self {
            id: pool.values(pixels)?,
            t: pool.values(if kernel.t && !kernel.is_given() { pixels } else { 0 })?,
            t_low: pool.values(if kernel.t && kernel.is_wide() { pixels } else { 0 })?,
            normal: pool.values(if kernel.normal { 3 * pixels } else { 0 })?,
            color: pool.values(if kernel.shade.is_some() { 3 * pixels } else { 0 })?,
            depth_interval: pool.values(if kernel.has_depth_interval() { pixels } else { 0 })?,
            depth: pool.values(if kernel.has_depths() { pixels } else { 0 })?,
        })
    }

    /// Copies the bytes read from the device into the buffer of the binding `name`.
    pub(crate) fn store(&mut self, name: &str, first: usize, pixels: usize, bytes: &[u8]) {
        let (buffer, channels): (&mut [u8], usize) = match name {
            "frame_t" => (bytemuck::cast_slice_mut(&mut self.t), 1),
            "frame_depth_interval" => (bytemuck::cast_slice_mut(&mut self.depth_interval), 1),
            "frame_depth" => (bytemuck::cast_slice_mut(&mut self.depth), 2),
            "frame_t_low" => (bytemuck::cast_slice_mut(&mut self.t_low), 1),
            "frame_normal" => (bytemuck::cast_slice_mut(&mut self.normal), 3),
            "frame_color" => (bytemuck::cast_slice_mut(&mut self.color), 3),
            _ => (bytemuck::cast_slice_mut(&mut self.id), 1),
        };
        let size = 4 * channels;
        let to = &mut buffer[size * first..size * (first + pixels)];
        parallel::fill(to, BYTES_PER_JOB, &|range, to| to.copy_from_slice(&bytes[range]));
    }

    /// Splits the buffers after the first `first` pixels, and then every `pixels`. Buffers that were not requested stay
    /// empty.
    pub(crate) fn cut(&mut self, first: usize, pixels: usize) -> impl Iterator<Item = Piece<'_>> {
        let mut ts = pieces(&mut self.t, first, pixels);
        let mut normals = pieces(&mut self.normal, 3 * first, 3 * pixels);
        let mut colors = pieces(&mut self.color, 3 * first, 3 * pixels);
        let mut widths = pieces(&mut self.depth_interval, first, pixels);
        let mut depths = pieces(&mut self.depth, first, pixels);
        pieces(&mut self.id, first, pixels).map(move |id| Piece {
            id,
            t: ts.next().unwrap_or_default(),
            normal: normals.next().unwrap_or_default(),
            color: colors.next().unwrap_or_default(),
            depth_interval: widths.next().unwrap_or_default(),
            depth: depths.next().unwrap_or_default(),
        })
    }

    /// Stores the ids and normals of settled pixels.
    pub(crate) fn settle(&mut self, settled: &[Settled]) {
        for s in settled {
            let pixel = s.pixel as usize;
            self.id[pixel] = s.truth.map_or(NONE, |truth| truth.id);
            if let Some(normal) = self.normal.get_mut(3 * pixel..3 * pixel + 3) {
                normal.copy_from_slice(&s.truth.map_or([0.0; 3], |truth| truth.normal.map(|x| x as f32)));
            }
        }
    }

    /// Returns its memory to the pool for the next frame.
    pub(crate) fn put_back(self, pool: &Pool) {
        pool.put_back(self.id);
        pool.put_back(self.depth);
        [self.t, self.t_low, self.normal, self.color, self.depth_interval]
            .into_iter()
            .for_each(|unused| pool.put_back(unused));
    }

    /// t of a hit as the sum of its two parts; 0 if not requested.
    #[inline(always)]
    pub(crate) fn t(&self, pixel: usize) -> f64 {
        let part = |buffer: &[f32]| buffer.get(pixel).map_or(0.0, |x| f64::from(*x));
        part(&self.t) + part(&self.t_low)
    }
}

/// The first `first` values, then chunks of `count`. An empty buffer gives one empty piece.
fn pieces<T>(buffer: &mut [T], first: usize, count: usize) -> impl Iterator<Item = &mut [T]> {
    let (head, rest) = buffer.split_at_mut(first.min(buffer.len()));
    std::iter::once(head).chain(rest.chunks_mut(count))
}

/// A run of consecutive pixels of a [`Raw`].
pub(crate) struct Piece<'a> {
    pub(crate) id: &'a mut [u32],
    pub(crate) t: &'a mut [f32],
    pub(crate) normal: &'a mut [f32],
    pub(crate) color: &'a mut [f32],
    pub(crate) depth_interval: &'a mut [f32],
    pub(crate) depth: &'a mut [f64],
}
