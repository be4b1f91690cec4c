//! Certified frames whose spheres the device holds: it places them (shaders/place), they leave minima in the pixels
//! (shaders/splat), and each pixel's winner is certified (shaders/main/certified.wgsl). The host sends a camera. It decides
//! what the device leaves to it: spheres around the eye, and pixels that are not proved.

pub(crate) mod held;
pub(crate) mod sky;
pub(crate) mod steps;
#[cfg(test)]
mod tests;

use super::Gpu;
use super::compose::Step;
use super::input::{Input, KernelRays, Output};
use super::sizes::{HOST_SPHERES, PAIRS, PIECES};
use super::transfers::{Band, Entries};
use crate::certify::binned::BinnedScene;
use crate::certify::placing::{ByHost, Placer};
use crate::certify::tiles::Placed;
use crate::error::{Error, Result};
use crate::kernel::{Generals, Kernel, KernelOutput, Sharing};
use crate::memory::Pool;
use crate::scene::{Scene, Spheres};
use crate::search::tile_candidates::CandidateList;
use crate::tile::TILE;
use crate::view::{View, ViewRecord};
use held::{Held, PlacedFor, Reach, Starts};

/// The scene and the view of a frame.
#[derive(Clone, Copy)]
pub(crate) struct ResidentFrame<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) view: &'a View,
    pub(crate) placer: &'a Placer,
    pub(crate) pool: &'a Pool,
}

/// A frame on the device, or why the device leaves it to the host.
pub(crate) enum Rendered {
    Frame(Box<BinnedScene>),
    Left(String),
}

/// Whether a device numbers so many spheres.
fn can_hold(spheres: &Spheres) -> bool {
    !spheres.is_empty() && spheres.len() <= (u32::MAX >> 2) as usize
}

impl Gpu {
    /// Holds the spheres of a scene from now on; what it holds already is not sent again. `frame` is a number for which
    /// spheres that others may change stay the same. `None` where the device cannot hold them.
    ///
    /// # Errors
    /// Those of the device.
    pub(crate) fn hold(&mut self, scene: &Scene, frame: u64) -> Result<Option<Reach>> {
        let spheres = &scene.spheres;
        if !can_hold(spheres) {
            return Ok(None);
        }
        if self.resident.held.as_ref().is_none_or(|held| !held.is_of(spheres, frame)) {
            self.resident.held = None;
            self.guarded(|gpu| {
                gpu.check_size("spheres", Held::largest(spheres.len().min(gpu.resident.block)))?;
                let (held, bytes) = Held::new(&gpu.open, spheres, frame, gpu.resident.block);
                gpu.resident.held = Some(held);
                gpu.traffic.up += bytes;
                Ok(())
            })?;
        }
        Ok(self.resident.held.as_ref().map(|held| held.reach))
    }

    /// What [`Gpu::hold`] returns, without sending a sphere.
    ///
    /// # Errors
    /// Those of [`Gpu::hold`] that are known before.
    pub(crate) fn reach(&self, spheres: &Spheres) -> Result<Option<Reach>> {
        if !can_hold(spheres) {
            return Ok(None);
        }
        self.check_size("spheres", Held::largest(spheres.len().min(self.resident.block)))?;
        Ok(Some(Reach::of(spheres)))
    }

    /// Fills `output` by `kernel` for the spheres that it holds. `go_on` is called before every band with the number of
    /// completed pixels.
    ///
    /// # Errors
    /// Those of [`Gpu::run`].
    pub(crate) fn render_resident(
        &mut self,
        kernel: &Kernel,
        frame: ResidentFrame<'_>,
        output: &mut Output<'_>,
        go_on: &dyn Fn(u64) -> bool,
    ) -> Result<Rendered> {
        self.guarded(|gpu| gpu.render_resident_unguarded(kernel, frame, output, go_on))
    }

    fn render_resident_unguarded(
        &mut self,
        kernel: &Kernel,
        frame: ResidentFrame<'_>,
        output: &mut Output<'_>,
        go_on: &dyn Fn(u64) -> bool,
    ) -> Result<Rendered> {
        let ResidentFrame { scene, view, placer, .. } = frame;
        self.forget_hits();
        let mut binned = match output.timings.time("place", || self.place(frame))? {
            Ok(binned) => binned,
            Err(reason) => return Ok(Rendered::Left(reason)),
        };
        let generals = Generals::of(binned.generals.len());
        let lists = if generals == Generals::Lists { 2 } else { 0 };
        // Besides the outputs: records, minima, general spheres with their lists, colours.
        let bound = KernelOutput::of(kernel).count() + 2 + lists + usize::from(kernel.colors);
        let most = self.limits.max_storage_buffers_per_shader_stage;
        // The starts of rays from the hits, where there is room for one more.
        let asked_for_starts = kernel.starts;
        let starts = asked_for_starts && bound < most as usize;
        let kernel = Kernel { sharing: Sharing::None, generals, starts, ..*kernel };
        if bound > most as usize {
            return Ok(Rendered::Left(format!("the kernel binds {bound} buffers, and the adapter at most {most}")));
        }
        let samples = kernel.samples;
        let large = self.resident.held.as_ref().is_some_and(|held| held.pieces > 0);
        output.timings.time("pipeline", || {
            self.step(Step::Small { samples })?;
            if large {
                self.step(Step::Large { samples })?;
            }
            self.pipeline(&kernel)
        })?;
        let candidates = Some(CandidateList::Certified(&binned));
        let input = Input { view, colors: scene.spheres.colors.as_deref(), rays: KernelRays::Viewing, candidates };
        output.timings.time("upload", || self.upload_resident(&kernel, &input))?;
        let record = view.record;
        let mut pairs = Vec::new();
        let rows = self.rows_of_band(&kernel, &record);
        let mut first = record.first_row;
        let end = record.first_row + record.rows;
        while first < end {
            let band = Band { first, count: (end - first).min(rows - first % TILE) };
            if !go_on(band.before(&kernel, &record)) {
                return Err(Error::Interrupted);
            }
            if generals == Generals::Lists && !(band.count == record.rows && self.has_lists()) {
                let entries = Entries::of(&CandidateList::Certified(&binned), &band);
                entries.upload(&CandidateList::Certified(&binned), |name, parts| match name {
                    "projected" => Ok(()),
                    _ => self.fill_parts(name, parts),
                })?;
            }
            self.know_lists(generals == Generals::Lists && band.count == record.rows);
            output.timings.time("trace", || self.trace_band(&kernel, &record, &band))?;
            output.timings.time("readback", || self.read_back(&kernel, &record, &band, 0, output.raw))?;
            let Some(found) = self.take_pairs()? else {
                return Ok(Rendered::Left(format!("more than {PAIRS} spheres lie at pixels that are not proved")));
            };
            let before = band.before(&kernel, &record) as u32;
            pairs.extend(found.into_iter().map(|[pixel, slot]| [pixel + before, slot]));
            first += band.count;
        }
        if asked_for_starts {
            self.resident.starts = Some(match rows >= record.rows + record.first_row % TILE {
                _ if !starts => Err("the adapter binds too few buffers to keep the hits"),
                true => Ok(Starts { record, unit: view.unit }),
                false => Err("the adapter holds the hits of a part of the image only"),
            });
        }
        if !pairs.is_empty() {
            let held = self.resident.held.as_ref();
            pairs.iter_mut().for_each(|[_, slot]| *slot = held.map_or(*slot, |held| held.id(*slot)));
            output.timings.time("settle", || placer.list(scene, view, &mut binned, pairs));
        }
        Ok(Rendered::Frame(Box::new(binned)))
    }

    /// Whether the lists of general spheres of the whole frame were sent after the spheres were placed.
    fn has_lists(&self) -> bool {
        self.resident.held.as_ref().is_some_and(|held| held.has_lists)
    }

    fn know_lists(&mut self, known: bool) {
        if let Some(held) = &mut self.resident.held {
            held.has_lists = known;
        }
    }

    /// Places the spheres; what was placed for the same view is kept. The inner error is why the host has to do it.
    fn place(&mut self, frame: ResidentFrame<'_>) -> Result<std::result::Result<BinnedScene, String>> {
        let Some(mut held) = self.resident.held.take() else { return Ok(Err("the device holds no spheres".into())) };
        let placed = self.place_held(&mut held, frame);
        self.resident.held = Some(held);
        placed
    }

    fn place_held(
        &mut self,
        held: &mut Held,
        frame: ResidentFrame<'_>,
    ) -> Result<std::result::Result<BinnedScene, String>> {
        let ResidentFrame { scene, view, placer, pool } = frame;
        let record = placer.record(0.0);
        let key = PlacedFor { camera: scene.camera, placing: record, lens: placer.lens(), tiles: view.record.tiles() };
        if let Some((_, binned)) = held.placed.as_ref().filter(|(known, _)| *known == key) {
            return Ok(Ok(binned.clone()));
        }
        (held.placed, held.has_lists) = (None, false);
        self.refill("placing", bytemuck::bytes_of(&record))?;
        self.refill("view", bytemuck::bytes_of(&view.record))?;
        let mut counts = self.place_blocks(held)?;
        if counts.host > HOST_SPHERES {
            return Ok(Err(format!(
                "{} spheres lie around the eye or too near, more than {HOST_SPHERES}",
                counts.host
            )));
        }
        let ByHost { binned, guests, reference } = placer.by_host(scene, view, &counts.summary, pool);
        if reference > 0.0 {
            self.refill("placing", bytemuck::bytes_of(&placer.record(reference)))?;
            counts = self.place_blocks(held)?;
        }
        self.check_size("spheres", Held::largest(guests.len()))?;
        self.traffic.up += held.set_guests(&self.open, &guests);
        if let Some(block) = held.guests() {
            counts.pieces = self.cut_guests(block)?;
        }
        if counts.pieces > u64::from(PIECES) {
            return Ok(Err(format!("more than {PIECES} pieces of large spheres")));
        }
        held.pieces = counts.pieces as u32;
        held.placed = Some((key, binned.clone()));
        Ok(Ok(binned))
    }

    /// The records of all spheres as placed last; `None` for those that have none.
    ///
    /// # Errors
    /// Those of the device.
    pub(crate) fn records(&mut self) -> Result<Vec<Option<Placed>>> {
        let Some(held) = self.resident.held.take() else { return Ok(Vec::new()) };
        let mut all = Vec::new();
        for block in held.blocks.iter().filter(|block| block.spheres.is_some()) {
            all.extend(self.records_of(block)?);
        }
        self.resident.held = Some(held);
        Ok(all)
    }

    /// The inputs of the kernel besides what each band has.
    fn upload_resident(&mut self, kernel: &Kernel, input: &Input<'_>) -> Result<()> {
        let known = self.resident.held.as_ref().is_some_and(|held| held.has_colors);
        for (name, bytes) in super::transfers::uploads(kernel, input) {
            match name {
                // Colours are sent once, with the spheres.
                "colors" if known => {}
                "colors" => self.fill(name, bytes)?,
                _ => self.refill(name, bytes)?,
            }
        }
        if let Some(held) = self.resident.held.as_mut().filter(|_| kernel.colors) {
            held.has_colors = true;
        }
        Ok(())
    }

    /// Rows of pixels whose minima and outputs fit a binding, a multiple of a tile's.
    fn rows_of_band(&self, kernel: &Kernel, record: &ViewRecord) -> u32 {
        let largest = self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size);
        let rows = largest / (if kernel.starts { 32 } else { 12 } * u64::from(record.columns));
        ((rows.min(u64::from(u32::MAX / 2)) as u32) / TILE * TILE).max(TILE)
    }

    /// Minima and the certificate of a band.
    fn trace_band(&mut self, kernel: &Kernel, record: &ViewRecord, band: &Band) -> Result<()> {
        let record = ViewRecord { first_row: band.first, rows: band.count, ..*record };
        let pixels = record.pixels() as u64;
        self.refill("view", bytemuck::bytes_of(&record))?;
        self.reserve("minima", 12 * pixels, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST);
        self.reserve_outputs(kernel, pixels);
        if kernel.starts {
            self.reserve("starts", 32 * pixels, wgpu::BufferUsages::STORAGE);
        }
        let Some(held) = self.resident.held.take() else { return Ok(()) };
        let done = self.submit_steps(kernel, &held, pixels, record.tiles());
        self.resident.held = Some(held);
        done
    }
}
