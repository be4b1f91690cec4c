//! Certified frames whose spheres the device holds: it places them (shaders/place), they leave minima in the pixels
//! (shaders/splat), and each pixel's winner is certified (shaders/main/certified.wgsl). The host sends a camera, the spheres
//! around the eye, which it projects or lists, and decides the pixels that are not proved.

pub(crate) mod picture;
pub(crate) mod scene;
pub(crate) mod sky;
pub(crate) mod steps;
#[cfg(test)]
mod tests;

use super::Gpu;
use super::compose::Step;
use super::dispatch::Program;
use super::input::{Input, KernelRays, Output};
use super::sizes::{HOST_SPHERES, PAIRS, PIECES};
use super::transfers::{Band, few_generals, general_lists, largest_binding, uploads};
use crate::certify::binned::BinnedScene;
use crate::certify::placing::{ByHost, Placer};
use crate::certify::planes::PlaneRecords;
use crate::certify::tiles::Placed;
use crate::frame::report::Timings;
use crate::kernel::{Certificate, Generals, Kernel, KernelOutput};
use crate::scene::{Scene, Spheres};
use crate::tile::TILE;
use crate::view::{View, ViewRecord};
use halfline_ground::error::{Error, Result};
use halfline_ground::memory::Pool;
use scene::{PlacedFor, Reach, ResidentScene, SpheresOnDevice, Starts};

/// The scene and the view of a frame.
#[derive(Clone, Copy)]
pub(crate) struct ResidentFrame<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) view: &'a View,
    pub(crate) placer: &'a Placer,
    pub(crate) pool: &'a Pool,
}

/// A frame on the device, or the reason why the device leaves it to the host.
pub(crate) enum Rendered {
    Frame(Box<BinnedScene>),
    Left(String),
}

/// A frame on the device before its rays.
struct Begun {
    /// The kernel for its general spheres.
    kernel: Kernel,
    /// Rows of a band.
    rows: u32,
    /// The spheres that the host placed or listed.
    binned: Box<BinnedScene>,
    /// The starts of rays that its hits will be, where the kernel was to leave them, or the reason why they will not.
    starts: Option<std::result::Result<Starts, &'static str>>,
}

/// The reason why a frame with too many pairs is left to the host.
fn too_many_pairs() -> String {
    format!("more than {PAIRS} spheres lie at pixels that are not proved")
}

/// Bytes of the two vectors of a ray's start.
const START: u64 = 32;

/// Bytes of the minima of a pixel: two depths and a slot, and where planes cut spheres the rank of a face.
fn minima(kernel: &Kernel) -> u64 {
    if kernel.has_planes() { 16 } else { 12 }
}

/// Whether a device numbers so many spheres.
fn can_hold(spheres: &Spheres) -> bool {
    !spheres.is_empty() && spheres.len() <= (u32::MAX >> 2) as usize
}

impl Gpu {
    /// Holds the spheres of a scene from now on; spheres that it holds already are not sent again. Lists that others
    /// may change count as unchanged only within one number `frame`. `None` where the device cannot hold the spheres.
    ///
    /// # Errors
    /// [`Error::Limits`] where a block exceeds a binding or the device is out of memory, [`Error::DeviceLost`],
    /// [`Error::Adapter`].
    pub(crate) fn hold(&mut self, scene: &Scene, frame: u64) -> Result<Option<Reach>> {
        let spheres = &scene.spheres;
        if !can_hold(spheres) {
            return Ok(None);
        }
        let is_resident = |one: &ResidentScene| one.is_of(spheres, frame);
        if !self.resident.as_ref().is_some_and(is_resident) {
            self.forget_tree();
            // A picture that shows something through translucent spheres has two scenes, which take turns within a frame.
            let last = self.resident.take().filter(|last| last.used == frame);
            self.resident = std::mem::replace(&mut self.other, last).filter(is_resident);
            if let Some(resident) = &mut self.resident {
                // Buffers that both share hold what belongs to the last one.
                (resident.placed, resident.has_colors, resident.has_lists) = (None, false, false);
            }
        }
        if self.resident.is_none() {
            // All buffers come first: where there is no memory for one of them, nothing is written.
            let mut resident = self.guarded(|gpu| {
                gpu.check_size("spheres", ResidentScene::largest(spheres.len().min(gpu.block)))?;
                Ok(ResidentScene::new(&gpu.open, spheres, frame, gpu.block))
            })?;
            let (shared, size) = (self.shared.clone(), self.block);
            let shared = shared.or_make(|shared| shared.serves(spheres, size), || self.send(spheres, frame))?;
            self.traffic.up += self.guarded(|gpu| resident.take(shared, &mut gpu.open))?;
            self.resident = Some(resident);
        }
        Ok(self.resident.as_mut().map(|resident| {
            resident.used = frame;
            resident.reach
        }))
    }

    /// Sends spheres to buffers of their own.
    fn send(&mut self, spheres: &Spheres, frame: u64) -> Result<SpheresOnDevice> {
        let shared = self.guarded(|gpu| Ok(SpheresOnDevice::new(&gpu.open, spheres, frame, gpu.block)))?;
        self.traffic.up += self.guarded(|gpu| shared.send(&mut gpu.open, spheres))?;
        Ok(shared)
    }

    /// The reach that [`Gpu::hold`] would return, without sending a sphere.
    ///
    /// # Errors
    /// [`Error::Limits`] where a block exceeds a binding.
    pub(crate) fn reach(&self, spheres: &Spheres) -> Result<Option<Reach>> {
        if !can_hold(spheres) {
            return Ok(None);
        }
        self.check_size("spheres", ResidentScene::largest(spheres.len().min(self.block)))?;
        Ok(Some(Reach::of(spheres)))
    }

    /// Fills `output` by `kernel` for the spheres that the device holds. `go_on` is called before every band with the
    /// number of completed pixels.
    ///
    /// # Errors
    /// As [`Gpu::run`]: errors of the device, and [`Error::Interrupted`] where `go_on` returns false.
    pub(crate) fn render_resident(
        &mut self,
        kernel: &Kernel,
        frame: ResidentFrame<'_>,
        output: &mut Output<'_>,
        go_on: &dyn Fn(u64) -> bool,
    ) -> Result<Rendered> {
        let record = frame.view.record;
        self.forget_hits();
        self.guarded(|gpu| {
            let Begun { kernel, rows, mut binned, starts } = match gpu.begin_frame(kernel, frame, output.timings)? {
                Ok(begun) => begun,
                Err(reason) => return Ok(Rendered::Left(reason)),
            };
            let Some(pairs) = gpu.trace_bands(&kernel, &record, rows, &binned, output, go_on)? else {
                return Ok(Rendered::Left(too_many_pairs()));
            };
            gpu.starts = starts;
            output.timings.time("settle", || gpu.list_pairs(frame, &mut binned, pairs));
            Ok(Rendered::Frame(binned))
        })
    }

    /// Places the spheres, and compiles and sends the rest of what a frame needs. The error is the reason why the device leaves the frame to
    /// the host.
    fn begin_frame(
        &mut self,
        kernel: &Kernel,
        frame: ResidentFrame<'_>,
        timings: &mut Timings,
    ) -> Result<std::result::Result<Begun, String>> {
        let ResidentFrame { scene, view, .. } = frame;
        let record = view.record;
        let binned = match timings.time("place", || self.place(frame))? {
            Rendered::Frame(binned) => binned,
            Rendered::Left(reason) => return Ok(Err(reason)),
        };
        let leaves_starts = kernel.leaves_starts();
        let kernel = match self.kernel_of_frame(kernel, &binned) {
            Ok(kernel) => kernel,
            Err(reason) => return Ok(Err(reason)),
        };
        timings.time("pipeline", || self.compile_for_frame(&kernel))?;
        timings.time("upload", || self.upload_resident(&kernel, scene, view, &binned))?;
        let Some(rows) = self.rows_of_band(&kernel, &record) else {
            return Ok(Err("a row of tiles exceeds the adapter's largest binding".into()));
        };
        let starts = leaves_starts.then(|| {
            if !kernel.leaves_starts() {
                Err("the adapter binds too few buffers to keep the hits")
            } else if rows < record.rows + record.first_row % TILE {
                Err("the adapter holds the hits of a part of the image only")
            } else {
                Ok(Starts { record, unit: view.unit })
            }
        });
        Ok(Ok(Begun { kernel, rows, binned, starts }))
    }

    /// Adds the spheres among which the host decides unproved pixels, from pairs of a pixel and a slot, to what it placed.
    fn list_pairs(&self, frame: ResidentFrame<'_>, binned: &mut BinnedScene, mut pairs: Vec<[u32; 2]>) {
        let ResidentFrame { scene, view, placer, .. } = frame;
        if let (false, Some(resident)) = (pairs.is_empty(), &self.resident) {
            pairs.iter_mut().for_each(|[_, slot]| *slot = resident.id(*slot));
            placer.list(scene, view, binned, pairs);
        }
    }

    /// The kernel for a frame with these general spheres. It writes starts of rays from the hits only where the adapter
    /// binds one buffer more. The error is the reason why the adapter cannot bind the kernel.
    fn kernel_of_frame(&self, kernel: &Kernel, binned: &BinnedScene) -> std::result::Result<Kernel, String> {
        let generals = Generals::of(binned.generals.len());
        let lists = usize::from(generals == Generals::Lists);
        // Besides the outputs: records, minima, general spheres with their lists, colours, planes.
        let bound = KernelOutput::buffers(kernel).count() + 2 + lists;
        let bound = bound + usize::from(kernel.colors) + usize::from(kernel.has_planes());
        let most = self.limits.max_storage_buffers_per_shader_stage as usize;
        if bound > most {
            return Err(format!("the kernel binds {bound} buffers, and the adapter at most {most}"));
        }
        Ok(kernel.certified_by(|of| Certificate { generals, starts: of.starts && bound < most, ..of }))
    }

    fn compile_for_frame(&mut self, kernel: &Kernel) -> Result<()> {
        let (samples, planes) = (kernel.samples, kernel.has_planes());
        self.compile(Program::Step(Step::Small { samples, planes }))?;
        if self.resident.as_ref().is_some_and(|resident| resident.pieces > 0) {
            self.compile(Program::Step(Step::Large { samples, planes }))?;
        }
        self.compile(Program::Kernel(*kernel))
    }

    /// Traces the frame in bands of `rows` rows. Returns the pairs of an unproved pixel and a sphere's slot; `None`
    /// where there are too many.
    fn trace_bands(
        &mut self,
        kernel: &Kernel,
        record: &ViewRecord,
        rows: u32,
        binned: &BinnedScene,
        output: &mut Output<'_>,
        go_on: &dyn Fn(u64) -> bool,
    ) -> Result<Option<Vec<[u32; 2]>>> {
        let mut pairs = Vec::new();
        let mut first = record.first_row;
        let end = record.first_row + record.rows;
        while first < end {
            let band = Band { first, count: (end - first).min(rows - first % TILE) };
            let before = band.before(kernel, record);
            if !go_on(before) {
                return Err(Error::Interrupted);
            }
            self.upload_general_lists(record, &band, binned)?;
            output.timings.time("trace", || self.trace_band(kernel, record, &band, true))?;
            output.timings.time("readback", || self.read_back(kernel, record, &band, output.raw))?;
            let Some(found) = self.take_pairs()? else { return Ok(None) };
            pairs.extend(found.into_iter().map(|[pixel, slot]| [pixel + before as u32, slot]));
            first += band.count;
        }
        Ok(Some(pairs))
    }

    /// Sends the lists of general spheres of a band, unless the device holds the lists of the whole frame since the
    /// spheres were placed.
    fn upload_general_lists(&mut self, record: &ViewRecord, band: &Band, binned: &BinnedScene) -> Result<()> {
        let has_lists = Generals::of(binned.generals.len()) == Generals::Lists;
        let is_whole = has_lists && band.count == record.rows;
        let known = self.resident.as_ref().is_some_and(|resident| resident.has_lists);
        if has_lists && !(is_whole && known) {
            let (tiles, slots) = general_lists(binned, band);
            let generals = bytemuck::cast_slice(&binned.generals);
            let parts = [generals, bytemuck::cast_slice(&tiles), bytemuck::cast_slice(slots)];
            self.fill_parts("generals_storage", &parts)?;
        }
        if let Some(resident) = &mut self.resident {
            resident.has_lists = is_whole;
        }
        Ok(())
    }

    /// Runs `work` with the spheres that the device holds; `None` where it holds none.
    fn with_resident<T>(&mut self, work: impl FnOnce(&mut Self, &mut ResidentScene) -> Result<T>) -> Result<Option<T>> {
        let Some(mut resident) = self.resident.take() else { return Ok(None) };
        let done = work(self, &mut resident);
        self.resident = Some(resident);
        done.map(Some)
    }

    /// Places the spheres, unless the device holds their records for the same view.
    fn place(&mut self, frame: ResidentFrame<'_>) -> Result<Rendered> {
        let placed = self.with_resident(|gpu, resident| gpu.place_resident(resident, frame))?;
        Ok(placed.unwrap_or_else(|| Rendered::Left("the device holds no spheres".into())))
    }

    fn place_resident(&mut self, resident: &mut ResidentScene, frame: ResidentFrame<'_>) -> Result<Rendered> {
        let ResidentFrame { scene, view, placer, pool } = frame;
        let record = placer.record(0.0);
        let key = PlacedFor { camera: scene.camera, placing: record, lens: placer.lens(), tiles: view.record.tiles() };
        if let Some((_, binned)) = resident.placed.as_ref().filter(|(known, _)| *known == key) {
            return Ok(Rendered::Frame(Box::new(binned.clone())));
        }
        (resident.placed, resident.has_lists) = (None, false);
        self.refill("placing", bytemuck::bytes_of(&record))?;
        self.refill("view", bytemuck::bytes_of(&view.record))?;
        let mut counts = self.place_blocks(resident)?;
        if counts.host > HOST_SPHERES {
            let reason = format!("{} spheres lie around the eye or too near, more than {HOST_SPHERES}", counts.host);
            return Ok(Rendered::Left(reason));
        }
        let ranks = resident.ranks.as_ref();
        let ByHost { binned, guests, reference } = placer.by_host((scene, ranks), view, &counts.summary, pool);
        if reference > 0.0 {
            self.refill("placing", bytemuck::bytes_of(&placer.record(reference)))?;
            counts = self.place_blocks(resident)?;
        }
        self.check_size("spheres", ResidentScene::largest(guests.len()))?;
        self.traffic.up += resident.set_guests(&mut self.open, &guests)?;
        if let Some(block) = resident.guests() {
            counts.pieces = self.cut_guests(block)?;
        }
        if counts.pieces > u64::from(PIECES) {
            return Ok(Rendered::Left(format!("more than {PIECES} pieces of large spheres")));
        }
        if let (Some(PlaneRecords { head, planes, .. }), Some(ranks)) = (&binned.planes, &resident.ranks) {
            let parts = [bytemuck::bytes_of(head), bytemuck::cast_slice(planes), bytemuck::cast_slice(&ranks.ids)];
            self.fill_parts("planes", &parts)?;
        }
        resident.pieces = counts.pieces as u32;
        resident.placed = Some((key, binned.clone()));
        Ok(Rendered::Frame(Box::new(binned)))
    }

    /// The records of all spheres from the last placing; `None` for spheres without a record.
    ///
    /// # Errors
    /// Errors of the device.
    pub(crate) fn records(&mut self) -> Result<Vec<Option<Placed>>> {
        let all = self.with_resident(|gpu, resident| {
            let blocks = resident.blocks.iter().filter(|block| block.spheres.is_some());
            blocks.map(|block| gpu.records_of(block)).collect::<Result<Vec<_>>>()
        })?;
        Ok(all.into_iter().flatten().flatten().collect())
    }

    /// Uploads the kernel's inputs, except those that each band has.
    fn upload_resident(&mut self, kernel: &Kernel, scene: &Scene, view: &View, binned: &BinnedScene) -> Result<()> {
        self.refill("projection", bytemuck::bytes_of(&binned.projection))?;
        if Generals::of(binned.generals.len()) == Generals::Few {
            self.refill("generals_uniform", bytemuck::cast_slice(&few_generals(binned)))?;
        }
        // Colours are sent once, with the spheres.
        let known = self.resident.as_ref().is_some_and(|resident| resident.has_colors);
        let both = (!known && kernel.face_colors).then(|| scene.spheres.colors_and_faces());
        let colors = both.as_deref().or(scene.spheres.colors.as_deref());
        let input = Input { view, colors, rays: KernelRays::Viewing };
        if !known {
            uploads(kernel, &input).into_iter().try_for_each(|(name, bytes)| self.fill(name, bytes))?;
        }
        if let Some(resident) = self.resident.as_mut().filter(|_| kernel.colors) {
            resident.has_colors = true;
        }
        Ok(())
    }

    /// Rows of a band whose minima and outputs fit a binding: a multiple of a tile's rows. `None` where not one tile's do.
    fn rows_of_band(&self, kernel: &Kernel, record: &ViewRecord) -> Option<u32> {
        let bytes = if kernel.leaves_starts() { START } else { minima(kernel) }.max(KernelOutput::largest(kernel));
        let rows = largest_binding(&self.limits) / (bytes * u64::from(record.columns));
        let rows = (rows.min(u64::from(u32::MAX / 2)) as u32) / TILE * TILE;
        (rows > 0).then_some(rows)
    }

    /// Runs the passes of minima, the certifying kernel and the pass of pairs for a band. Unless the host `reads` the outputs, they stay
    /// on the device, and the pairs also list the pixels that are not proved.
    fn trace_band(&mut self, kernel: &Kernel, record: &ViewRecord, band: &Band, reads: bool) -> Result<()> {
        let record = ViewRecord { first_row: band.first, rows: band.count, ..*record };
        let pixels = record.pixels() as u64;
        self.refill("view", bytemuck::bytes_of(&record))?;
        self.reserve("minima", minima(kernel) * pixels, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST);
        self.reserve_outputs(kernel, pixels);
        if kernel.leaves_starts() {
            self.reserve("starts", START * pixels, wgpu::BufferUsages::STORAGE);
        }
        self.with_resident(|gpu, resident| gpu.submit_steps(kernel, resident, &record, reads)).map(drop)
    }
}
