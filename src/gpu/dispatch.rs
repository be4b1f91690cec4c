//! Rendering one frame on the device: upload, dispatch by bands, readback.

use crate::gpu::clock::Clock;
use crate::gpu::compose::{Source, Step, compose, compose_step};
use crate::gpu::device::{self, AdapterSummary};
use crate::gpu::input::{GROUP, Input, Output};
use crate::gpu::layout::{Binding, bindings, capabilities};
use crate::gpu::resident::scene::{BLOCK, ResidentScene, SpheresOnDevice, Starts};
#[cfg(test)]
use crate::gpu::room::Fault;
use crate::gpu::room::Room;
use crate::gpu::selftest::verdict::Verdict;
use crate::gpu::submission_budget::SubmissionBudget;
use crate::gpu::traffic::Traffic;
use crate::gpu::transfers::{Band, Bands, largest_binding, most_spheres, uploads};
use crate::gpu::validate::{compile, validate};
use crate::gpu::wait::block_on;
use crate::intersect::Method;
use crate::kernel::{Kernel, KernelOutput};
use crate::tile::TILE;
use crate::view::ViewRecord;
use halfline_ground::Shared;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::{ADAPTER, BACKEND, SIZE};
use naga::valid::Capabilities;
use std::collections::HashMap;
use std::num::NonZeroU64;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use web_time::Instant;

/// An open device with its pipelines and buffers, kept between frames.
pub(crate) struct Gpu {
    pub(crate) summary: AdapterSummary,
    pub(crate) open: device::Open,
    pub(crate) limits: wgpu::Limits,
    pub(super) programs: HashMap<Program, Pipeline>,
    /// The programs of all renderers of the device.
    compiled: Arc<Mutex<HashMap<Program, Pipeline>>>,
    pub(super) buffers: HashMap<&'static str, wgpu::Buffer>,
    /// Copies of buffers for the host to read, by the same names.
    pub(super) staging: HashMap<&'static str, wgpu::Buffer>,
    /// The last contents of small buffers, to skip equal uploads.
    filled: HashMap<&'static str, Vec<u8>>,
    pub(super) textures: HashMap<&'static str, (wgpu::Texture, wgpu::TextureView)>,
    pub(super) clock: Option<Clock>,
    pub(super) traffic: Traffic,
    /// The time in which the device had work until the times were last taken.
    busy_before: Duration,
    /// Output buffers are read in place.
    pub(super) direct: bool,
    /// The budget for kernels that have not run yet.
    pub(super) budget: SubmissionBudget,
    pub(super) verdict: Option<Verdict>,
    pub(super) resident: Option<ResidentScene>,
    /// The spheres that any renderer of the device sent.
    pub(super) shared: Shared<SpheresOnDevice>,
    /// The scene with which the resident one takes turns.
    pub(super) other: Option<ResidentScene>,
    /// The frame whose hits the device keeps, as starts of rays, or the reason why it keeps none; `None` where the last
    /// hits are invalid.
    pub(super) starts: Option<Result<Starts, &'static str>>,
    /// The number of spheres in a block.
    pub(super) block: usize,
    pub(crate) room: Room,
    /// The number of the guarded call that fails, from 1 for the next.
    #[cfg(test)]
    pub(crate) fault: Option<(u32, Fault)>,
    /// Blocks leave their minima in the reverse order.
    #[cfg(test)]
    pub(super) reversed: bool,
    /// Whether the device draws pictures as the host does; `None` before the trial. Software leaves them to the host, with its bits.
    pub(crate) draws: Option<bool>,
}

/// A shader of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Program {
    Kernel(Kernel),
    Step(Step),
}

/// A compiled shader, its bindings and its budget.
#[derive(Clone)]
pub(super) struct Pipeline {
    compute: wgpu::ComputePipeline,
    bindings: Vec<Binding>,
    pub(super) budget: SubmissionBudget,
}

impl Gpu {
    pub(crate) fn new(open: device::Open, summary: AdapterSummary) -> Self {
        let limits = open.device.limits();
        let clock = Clock::new(&open);
        let direct = open.is_direct(&summary);
        let draws = summary.is_software().then_some(false);
        Self {
            clock,
            traffic: Traffic::default(),
            busy_before: Duration::ZERO,
            summary,
            open,
            limits,
            programs: HashMap::new(),
            compiled: Arc::default(),
            buffers: HashMap::new(),
            staging: HashMap::new(),
            filled: HashMap::new(),
            textures: HashMap::new(),
            direct,
            budget: SubmissionBudget::default(),
            verdict: None,
            resident: None,
            shared: Shared::default(),
            other: None,
            starts: None,
            block: BLOCK,
            room: Room::default(),
            #[cfg(test)]
            fault: None,
            #[cfg(test)]
            reversed: false,
            draws,
        }
    }

    /// The same device for another renderer, with the programs and the spheres that it holds.
    pub(crate) fn another(&self) -> Self {
        let mut own = Self::new(self.open.another(), self.summary.clone());
        (own.compiled, own.shared) = (Arc::clone(&self.compiled), self.shared.clone());
        (own.verdict, own.draws, own.block) = (self.verdict.clone(), self.draws, self.block);
        own
    }

    /// Fills `output` by `kernel`. `go_on` is called before every band with the number of completed pixels; `false`
    /// stops.
    pub(crate) fn run(
        &mut self,
        kernel: &Kernel,
        input: &Input<'_>,
        output: &mut Output<'_>,
        go_on: &dyn Fn(u64) -> bool,
    ) -> Result<()> {
        let record = input.view.record;
        self.guarded(|gpu| {
            let Output { raw, timings } = output;
            gpu.share_buffers();
            gpu.check_limits(kernel, input)?;
            let program = Program::Kernel(*kernel);
            timings.time("pipeline", || gpu.compile(program))?;
            timings.time("upload", || gpu.upload(kernel, input))?;
            let mut bands = Bands::new(kernel, input, gpu.limits.clone());
            while let Some(band) = bands.next(&gpu.programs[&program].budget) {
                if !go_on(band.before(kernel, &record)) {
                    return Err(Error::Interrupted);
                }
                let (tests, start) = (bands.tests(&band), Instant::now());
                timings.time("trace", || gpu.dispatch_band(kernel, &record, &band))?;
                // Wall time includes the uploads before the submission, and for the first band the driver's compile time.
                let seconds = gpu.seconds(start);
                tracing::debug!(band.first, band.count, tests, seconds, "submitted");
                if let Some(pipeline) = gpu.programs.get_mut(&program) {
                    pipeline.budget.took(tests, seconds);
                }
                timings.time("readback", || gpu.read_back(kernel, &record, &band, raw))?;
            }
            Ok(())
        })
    }

    /// Invalidates what lies in the buffers of colours, lists and ids, which all kernels share.
    fn share_buffers(&mut self) {
        if let Some(resident) = &mut self.resident {
            (resident.has_colors, resident.has_lists) = (false, false);
        }
        self.starts = None;
    }

    /// Whether kernel times are measured.
    pub(crate) fn has_clock(&self) -> bool {
        self.clock.is_some()
    }

    /// Takes the device's times and bytes since the last call.
    pub(crate) fn traffic(&mut self) -> Traffic {
        let total = self.open.busy.total();
        let busy = total - std::mem::replace(&mut self.busy_before, total);
        Traffic { kernel_ms: self.clock.as_mut().map(Clock::take), busy, ..std::mem::take(&mut self.traffic) }
    }

    /// Runs `work` and converts errors that the device reports meanwhile. Where it is out of memory, it keeps nothing.
    pub(super) fn guarded<T>(&mut self, work: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        let device = self.open.device.clone();
        let scopes = [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::Validation]
            .map(|filter| device.push_error_scope(filter));
        let outcome = work(self);
        let mut failure = None;
        for scope in scopes.into_iter().rev() {
            failure = block_on(scope.pop()).or(failure);
        }
        #[cfg(test)]
        let failure = self.next_fault().or(failure);
        if let Some(message) = self.open.lost.lock().ok().and_then(|lost| lost.clone()) {
            return Err(Error::DeviceLost(message));
        }
        match failure {
            None => outcome,
            Some(wgpu::Error::OutOfMemory { .. }) => {
                self.room.exhaust();
                self.forget();
                Err(Error::Limits {
                    problem: self.exhausted(),
                    mend: format!("render fewer spheres, or use a smaller {SIZE}"),
                })
            }
            Some(error) => Err(Error::Adapter {
                problem: format!("{} failed: {error}", self.summary.name),
                mend: format!("use another {ADAPTER} or {BACKEND} cpu, and report this as a bug"),
            }),
        }
    }

    /// Forgets every buffer, texture and sphere: those for which there was no memory are invalid.
    fn forget(&mut self) {
        (self.resident, self.other, self.starts) = (None, None, None);
        (self.buffers, self.staging) = Default::default();
        (self.filled, self.textures) = Default::default();
    }

    /// The message for a device without memory for its work.
    pub(crate) fn exhausted(&self) -> String {
        format!("{} is out of memory", self.summary.name)
    }

    /// The failure of this guarded call of a test. What is on the device becomes useless, as buffers are for which there was no memory.
    #[cfg(test)]
    fn next_fault(&mut self) -> Option<wgpu::Error> {
        let (count, fault) = self.fault.as_mut()?;
        *count -= 1;
        let fault = (*count == 0).then_some(*fault)?;
        self.fault = None;
        match fault {
            Fault::Lost => {
                self.open.device.destroy();
                // The loss is reported by a poll.
                let _ = self.open.wait(None);
                return None;
            }
            Fault::Invalid => {
                return Some(wgpu::Error::Validation { source: "a test".into(), description: "a test".into() });
            }
            Fault::OutOfMemory => {}
        }
        self.buffers.values().chain(self.staging.values()).for_each(wgpu::Buffer::destroy);
        self.textures.values().for_each(|(texture, _)| texture.destroy());
        self.resident.iter().chain(&self.other).for_each(ResidentScene::destroy);
        Some(wgpu::Error::OutOfMemory { source: "a test".into() })
    }

    /// Checks the adapter's limits before any work.
    fn check_limits(&self, kernel: &Kernel, input: &Input<'_>) -> Result<()> {
        let record = &input.view.record;
        let (largest, fit) = (largest_binding(&self.limits), most_spheres(&self.limits, kernel));
        if u64::from(record.spheres) > fit {
            return Err(Error::Limits {
                problem: format!(
                    "{} spheres exceed what {} can bind for this image ({largest} bytes per binding)",
                    record.spheres, self.summary.name
                ),
                mend: format!("render at most {fit} spheres, or use {BACKEND} cpu"),
            });
        }
        let widest = (self.limits.max_compute_workgroups_per_dimension * TILE)
            .min((largest / (KernelOutput::largest(kernel) * u64::from(TILE))).min(u64::from(u32::MAX)) as u32);
        if kernel.has_pixels() && record.columns > widest {
            return Err(Error::Limits {
                problem: format!(
                    "{} columns exceed what {} can write in one dispatch",
                    record.columns, self.summary.name
                ),
                mend: format!("render at most {widest} columns, or use {BACKEND} cpu"),
            });
        }
        Ok(())
    }

    /// Makes the pipeline of a program, unless it is known.
    pub(super) fn compile(&mut self, program: Program) -> Result<()> {
        if self.programs.contains_key(&program) {
            return Ok(());
        }
        let compiled = Arc::clone(&self.compiled);
        // Another renderer waits for a program that this one makes. A thread that panicked left whole ones.
        let mut compiled = compiled.lock().unwrap_or_else(PoisonError::into_inner);
        let pipeline = match compiled.get(&program) {
            Some(known) => known.clone(),
            None => {
                let made = match &program {
                    Program::Kernel(kernel) => {
                        let label = kernel.method().map_or("certified", Method::name);
                        self.built(&compose(kernel), capabilities(kernel), label)
                    }
                    Program::Step(step) => self.built(&compose_step(*step), Capabilities::empty(), "resident"),
                }?;
                compiled.entry(program).or_insert(made).clone()
            }
        };
        self.programs.insert(program, pipeline);
        Ok(())
    }

    /// The pipeline of a shader that has not run yet.
    pub(super) fn built(&self, source: &Source, capabilities: Capabilities, label: &str) -> Result<Pipeline> {
        let (module, info) = validate(source, capabilities)?;
        let bindings = bindings(&module, &info);
        Ok(Pipeline { compute: compile(&self.open.device, label, source, module), bindings, budget: self.budget })
    }

    fn upload(&mut self, kernel: &Kernel, input: &Input<'_>) -> Result<()> {
        uploads(kernel, input).into_iter().try_for_each(|(name, bytes)| self.fill(name, bytes))
    }

    fn dispatch_band(&mut self, kernel: &Kernel, record: &ViewRecord, band: &Band) -> Result<()> {
        let (record, pixels, groups) = match kernel.has_pixels() {
            true => {
                let record = ViewRecord { first_row: band.first, rows: band.count, ..*record };
                let [columns, rows] = record.tiles().map(|[first, last]| last - first + 1);
                (record, record.pixels() as u64, (columns, rows))
            }
            false => {
                let record = ViewRecord { first_row: band.first, rows: 1, width: band.count, ..*record };
                (record, u64::from(band.count), (band.count.div_ceil(GROUP), 1))
            }
        };
        self.fill("view", bytemuck::bytes_of(&record))?;
        self.reserve_outputs(kernel, pixels);
        let mut encoder = self.encoder();
        let program = &self.programs[&Program::Kernel(*kernel)];
        let bound = |name| self.bound(name, Some((kernel, pixels)));
        self.dispatch(&mut self.pass(&mut encoder), program, bound, groups);
        self.copy_outputs(&mut encoder, kernel, pixels);
        self.finish(encoder, true, |gpu| gpu.ask_outputs(kernel, pixels))
    }

    pub(super) fn encoder(&self) -> wgpu::CommandEncoder {
        self.open.device.create_command_encoder(&Default::default())
    }

    /// A pass that the clock times, if the device has one.
    pub(super) fn pass<'a>(&self, encoder: &'a mut wgpu::CommandEncoder) -> wgpu::ComputePass<'a> {
        let timestamp_writes = self.clock.as_ref().and_then(Clock::writes);
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes })
    }

    /// Adds a dispatch to a pass. `bound` gives the resource of each binding by its name.
    pub(super) fn dispatch<'a>(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        program: &Pipeline,
        bound: impl Fn(&'static str) -> wgpu::BindingResource<'a>,
        (columns, rows): (u32, u32),
    ) {
        let entry = |b: &Binding| wgpu::BindGroupEntry { binding: b.binding, resource: bound(b.name) };
        let entries: Vec<_> = program.bindings.iter().map(entry).collect();
        let layout = &program.compute.get_bind_group_layout(0);
        let group = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
        pass.set_pipeline(&program.compute);
        pass.set_bind_group(0, &self.open.device.create_bind_group(&group), &[]);
        pass.dispatch_workgroups(columns, rows, 1);
    }

    /// The binding of a texture or a buffer. Of outputs it is the part that the kernel uses for its number of pixels,
    /// since a buffer that is kept between frames may be larger.
    pub(super) fn bound(&self, name: &'static str, outputs: Option<(&Kernel, u64)>) -> wgpu::BindingResource<'_> {
        if let Some((_, view)) = self.textures.get(name) {
            return wgpu::BindingResource::TextureView(view);
        }
        let buffer = &self.buffers[name];
        let size = outputs.and_then(|(kernel, pixels)| {
            let written = KernelOutput::buffers(kernel).find(|(buffer, _)| *buffer == name);
            written.and_then(|(_, bytes)| NonZeroU64::new(pixels * bytes))
        });
        wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })
    }

    /// Checks that the adapter can bind a buffer of this size.
    pub(super) fn check_size(&self, name: &str, bytes: u64) -> Result<()> {
        let largest = largest_binding(&self.limits);
        if bytes <= largest {
            return Ok(());
        }
        Err(Error::Limits {
            problem: format!(
                "{bytes} bytes of {name} exceed the largest binding of {} ({largest} bytes)",
                self.summary.name
            ),
            mend: format!("render fewer spheres or rays at a time, or use {BACKEND} cpu"),
        })
    }

    pub(super) fn fill(&mut self, name: &'static str, bytes: &[u8]) -> Result<()> {
        self.fill_parts(name, &[bytes])
    }

    /// Fills a small buffer like [`Gpu::fill`], unless these bytes filled it last.
    pub(super) fn refill(&mut self, name: &'static str, bytes: &[u8]) -> Result<()> {
        if self.filled.get(name).is_some_and(|known| known == bytes) {
            return Ok(());
        }
        self.fill(name, bytes)?;
        self.filled.insert(name, bytes.to_vec());
        Ok(())
    }

    /// Writes the parts one after the other; each is a multiple of four bytes.
    pub(super) fn fill_parts(&mut self, name: &'static str, parts: &[&[u8]]) -> Result<()> {
        self.filled.remove(name);
        // A binding cannot be empty. Kernels read as many entries as the view record counts, so the padding is never
        // read.
        // Arrays of vectors end with a whole one.
        let size = parts.iter().map(|part| part.len() as u64).sum::<u64>().max(MIN_BUFFER_BYTES).next_multiple_of(16);
        self.check_size(name, size)?;
        self.reserve(name, size, FILLED);
        let mut offset = 0;
        for part in parts {
            self.open.write(&self.buffers[name], offset, part)?;
            offset += part.len() as u64;
        }
        self.traffic.up += offset;
        Ok(())
    }

    pub(super) fn reserve(&mut self, name: &'static str, size: u64, usage: wgpu::BufferUsages) {
        reserve(&self.open, &mut self.buffers, name, size, usage);
    }
}

/// Keeps a buffer that is large enough, or makes one.
pub(super) fn reserve(
    open: &device::Open,
    buffers: &mut HashMap<&'static str, wgpu::Buffer>,
    name: &'static str,
    size: u64,
    usage: wgpu::BufferUsages,
) {
    if buffers.get(name).is_none_or(|buffer| buffer.size() < size) {
        let descriptor = wgpu::BufferDescriptor { label: Some(name), size, usage, mapped_at_creation: false };
        buffers.insert(name, open.device.create_buffer(&descriptor));
    }
}

/// Size of the smallest buffer in bytes: enough for one record of any kind.
const MIN_BUFFER_BYTES: u64 = 64;

/// The usage of buffers that the host fills: shaders bind them as either.
const FILLED: wgpu::BufferUsages =
    wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::UNIFORM).union(wgpu::BufferUsages::COPY_DST);
