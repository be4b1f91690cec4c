//! Pictures of several samples whose colours a device computes: shaders/picture. The host decides the pixels and the rays that f32
//! does not prove, and sends them back as patches.

use super::sky::{SPHERES, SkyRays, SkyTraced};
use super::{Begun, Rendered, ResidentFrame, too_many_pairs};
use crate::frame::report::Timings;
use crate::gpu::Gpu;
use crate::gpu::compose::Step;
use crate::gpu::dispatch::Program;
use crate::gpu::input::GROUP;
use crate::gpu::sizes::{PAIRS, SUMMARY_PAIRS};
use crate::gpu::transfers::Band;
use crate::kernel::Kernel;
use crate::scene::Scene;
use crate::view::ViewRecord;
use crate::view::ray::NONE;
use bytemuck::{Pod, Zeroable};
use halfline_ground::error::Result;
#[cfg(test)]
use {crate::gpu::compose::compose_step, naga::valid::Capabilities};

/// The most lights of a picture whose colours a device computes.
pub(crate) const MAX_SOURCES: usize = 8;

/// Declared in shaders/picture/record.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct PictureRecord {
    pub(crate) sky_corner: [u32; 2],
    pub(crate) sky_size: [u32; 2],
    pub(crate) up: [f32; 3],
    pub(crate) share: f32,
    pub(crate) horizon: [f32; 3],
    pub(crate) gradient: u32,
    pub(crate) change: [f32; 3],
    pub(crate) lights: u32,
    pub(crate) ink: [f32; 3],
    pub(crate) strength: f32,
    pub(crate) pixel_slope: f32,
    pub(crate) pixel_size: f32,
    pub(crate) stretch: f32,
    pub(crate) between: u32,
    pub(crate) neighbours: [i32; 2],
    pub(crate) cue_near: f32,
    pub(crate) cue_slope: f32,
    pub(crate) cue_share: f32,
    pub(crate) radius: f32,
    pub(crate) step: u32,
    pub(crate) planes: u32,
    pub(crate) parallel: u32,
    pub(crate) unused: [u32; 3],
    pub(crate) shares: [[f32; 4]; 9],
    pub(crate) sources: [[f32; 4]; 2 * MAX_SOURCES],
}

/// Words that the host decided: the place of each in a buffer, and the word.
#[derive(Debug, Default)]
pub(crate) struct Patches(Vec<[u32; 2]>);

impl Patches {
    pub(crate) fn set(&mut self, place: usize, word: u32) {
        self.0.push([place as u32, word]);
    }
}

/// Words of a pixel of the hits of the sky: the sphere, and the normal.
const HIT_WORDS: u64 = 3;

/// Bytes of a pixel's sums of colour and coverage.
const SUMS: u64 = 16;

impl Gpu {
    /// Replaces the kernels that colour samples by one that does not.
    #[cfg(test)]
    pub(crate) fn spoil_pictures(&mut self) {
        for colors in [false, true] {
            let wrong = self.built(&compose_step(Step::Unsure), Capabilities::empty(), "wrong").expect("a pipeline");
            self.programs.insert(Program::Step(Step::Picture { colors }), wrong);
        }
    }

    /// Traces rays toward the sky from the hits of the last frame and adds them up at each hit. Returns the pixels of the hits
    /// whose rays the host has to trace; [`SkyTraced::Refused`] also where these are too many.
    ///
    /// # Errors
    /// Errors of the device, and [`crate::Error::Interrupted`].
    pub(crate) fn sum_sky(
        &mut self,
        rays: &SkyRays<'_>,
        picture: &PictureRecord,
        go_on: &dyn Fn(u64) -> bool,
    ) -> Result<SkyTraced<Vec<u32>>> {
        let traced = self.trace_hits(rays, go_on, |gpu, _| {
            let record = rays.view.record;
            let pixels = record.pixels() as u64;
            let storage = wgpu::BufferUsages::STORAGE;
            gpu.reserve("sky_hits", 4 * HIT_WORDS * pixels, storage);
            for name in ["sky_sums", "sky_means"] {
                gpu.reserve(name, 4 * u64::from(picture.planes) * pixels, storage);
            }
            gpu.refill("picture", bytemuck::bytes_of(picture))?;
            let mut encoder = gpu.encoder();
            encoder.clear_buffer(&gpu.buffers["summary"], 4 * u64::from(SUMMARY_PAIRS), Some(4));
            gpu.step_of_picture(&mut encoder, Step::SkySums, &record)?;
            gpu.swap_sums();
            gpu.finish_pairs(encoder, |_| {})?;
            gpu.take_pairs()
        })?;
        Ok(match traced {
            SkyTraced::Traced(Some(pairs)) => SkyTraced::Traced(pairs.into_iter().map(|[pixel, _]| pixel).collect()),
            SkyTraced::Traced(None) => SkyTraced::Refused(format!("f32 does not prove the rays of {PAIRS} pixels")),
            SkyTraced::NoHits => SkyTraced::NoHits,
            SkyTraced::Refused(reason) => SkyTraced::Refused(reason),
        })
    }

    /// Writes the host's hits and sums, and puts the rays of neighbours together in passes of these steps.
    ///
    /// # Errors
    /// Errors of the device.
    pub(crate) fn smooth_sky(
        &mut self,
        record: &ViewRecord,
        picture: &PictureRecord,
        [hits, sums]: [&Patches; 2],
        steps: &[u32],
    ) -> Result<()> {
        self.guarded(|gpu| {
            gpu.refill("view", bytemuck::bytes_of(record))?;
            gpu.patch("sky_hits", hits)?;
            gpu.patch("sky_sums", sums)?;
            for &step in steps {
                gpu.refill("picture", bytemuck::bytes_of(&PictureRecord { step, ..*picture }))?;
                let mut encoder = gpu.encoder();
                gpu.step_of_picture(&mut encoder, Step::Smooth, record)?;
                gpu.enqueue(encoder);
                gpu.swap_sums();
            }
            gpu.refill("picture", bytemuck::bytes_of(picture))
        })
    }

    /// The hits of a sample, which stay on the device. `unsure` gets the pixels that the host has to decide, among the spheres of the
    /// result.
    ///
    /// # Errors
    /// Errors of the device.
    pub(crate) fn hit_sample(
        &mut self,
        kernel: &Kernel,
        frame: ResidentFrame<'_>,
        unsure: &mut Vec<u32>,
        timings: &mut Timings,
    ) -> Result<Rendered> {
        let record = frame.view.record;
        self.forget_hits();
        self.guarded(|gpu| {
            let Begun { kernel, mut binned, starts, .. } = match gpu.begin_frame(kernel, frame, timings)? {
                Ok(begun) => begun,
                Err(reason) => return Ok(Rendered::Left(reason)),
            };
            if let Some(Err(reason)) = starts {
                return Ok(Rendered::Left(reason.into()));
            }
            gpu.compile(Program::Step(Step::Unsure))?;
            let band = Band { first: record.first_row, count: record.rows };
            gpu.upload_general_lists(&record, &band, &binned)?;
            timings.time("trace", || gpu.trace_band(&kernel, &record, &band, false))?;
            let Some(mut pairs) = gpu.take_pairs()? else { return Ok(Rendered::Left(too_many_pairs())) };
            unsure.extend(pairs.iter().map(|[pixel, _]| *pixel));
            unsure.sort_unstable();
            unsure.dedup();
            pairs.retain(|[_, slot]| *slot != NONE);
            timings.time("settle", || gpu.list_pairs(frame, &mut binned, pairs));
            Ok(Rendered::Frame(binned))
        })
    }

    /// Writes the host's hits of a sample, and adds its colours to the picture.
    ///
    /// # Errors
    /// Errors of the device.
    pub(crate) fn add_sample(
        &mut self,
        scene: &Scene,
        record: &ViewRecord,
        [ids, starts]: [&Patches; 2],
    ) -> Result<()> {
        self.guarded(|gpu| {
            gpu.patch("frame_id", ids)?;
            gpu.patch("starts", starts)?;
            let colors = scene.spheres.colors.as_deref();
            if let Some(colors) = colors.filter(|_| !gpu.resident.as_ref().is_some_and(|one| one.has_colors)) {
                gpu.fill("colors", bytemuck::cast_slice(colors))?;
                gpu.resident.iter_mut().for_each(|resident| resident.has_colors = true);
            }
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
            gpu.reserve("picture_sums", SUMS * record.pixels() as u64, usage);
            let mut encoder = gpu.encoder();
            gpu.step_of_picture(&mut encoder, Step::Picture { colors: colors.is_some() }, record)?;
            gpu.enqueue(encoder);
            Ok(())
        })
    }

    /// Sums of linear RGB and coverage over all samples, four numbers a pixel, which `read` gets.
    ///
    /// # Errors
    /// Errors of the device.
    pub(crate) fn read_picture<T>(&mut self, pixels: usize, read: impl FnOnce(&[f32]) -> T) -> Result<T> {
        self.guarded(|gpu| {
            let bytes = SUMS * pixels as u64;
            let mut encoder = gpu.encoder();
            gpu.copy(&mut encoder, "picture_sums", bytes);
            gpu.finish(encoder, true, |gpu| gpu.ask("picture_sums", bytes))?;
            gpu.with_taken("picture_sums", bytes, |bytes| read(bytemuck::cast_slice(bytes)))
        })
    }

    /// Adds a step over the pixels of a window.
    fn step_of_picture(&mut self, encoder: &mut wgpu::CommandEncoder, step: Step, record: &ViewRecord) -> Result<()> {
        self.compile(Program::Step(step))?;
        let [columns, rows] = record.tiles().map(|[first, last]| last - first + 1);
        let bound = |name| match name {
            "placed" => self.bound(SPHERES, None),
            _ => self.bound(name, None),
        };
        self.dispatch(&mut self.pass(encoder), &self.programs[&Program::Step(step)], bound, (columns, rows));
        Ok(())
    }

    /// Writes words into a buffer, without a wait.
    fn patch(&mut self, name: &'static str, patches: &Patches) -> Result<()> {
        let Some(last) = patches.0.last() else { return Ok(()) };
        let program = Program::Step(Step::Scatter);
        self.compile(program)?;
        let groups = patches.0.len().div_ceil(GROUP as usize);
        // Whole workgroups.
        let rest = vec![*last; groups * GROUP as usize - patches.0.len()];
        self.fill_parts("patches", &[bytemuck::cast_slice(&patches.0), bytemuck::cast_slice(&rest)])?;
        let bound = |binding| self.bound(if binding == "patched" { name } else { binding }, None);
        let mut encoder = self.encoder();
        self.dispatch(&mut self.pass(&mut encoder), &self.programs[&program], bound, (groups as u32, 1));
        self.enqueue(encoder);
        Ok(())
    }

    /// The sums that a pass left are those that the next one reads.
    fn swap_sums(&mut self) {
        if let (Some(sums), Some(means)) = (self.buffers.remove("sky_sums"), self.buffers.remove("sky_means")) {
            self.buffers.insert("sky_sums", means);
            self.buffers.insert("sky_means", sums);
        }
    }
}
