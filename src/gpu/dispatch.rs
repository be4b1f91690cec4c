//! Rendering one frame on the device: upload, dispatch by bands, readback.

use crate::error::{Error, Result};
use crate::gpu::clock::Clock;
use crate::gpu::compose::{Source, compose};
use crate::gpu::device::{self, AdapterSummary};
use crate::gpu::input::{GROUP, Input, Output};
use crate::gpu::layout::{Binding, bindings, is_texture};
use crate::gpu::resident::held::Resident;
use crate::gpu::selftest::verdict::Verdict;
use crate::gpu::submission_budget::SubmissionBudget;
use crate::gpu::traffic::Traffic;
use crate::gpu::transfers::{Band, Bands, BindingLimits, Entries, uploads};
use crate::gpu::validate::{compile, validate};
use crate::kernel::{Kernel, KernelOutput, RaySource};
use crate::quote::setting::{ADAPTER, BACKEND, SIZE};
use crate::tile::TILE;
use crate::view::ViewRecord;
use naga::valid::Capabilities;
use std::collections::HashMap;
use std::num::NonZeroU64;
use std::time::Instant;

/// An open device with its pipelines and buffers, kept between frames.
pub(crate) struct Gpu {
    pub(crate) summary: AdapterSummary,
    pub(super) open: device::Open,
    pub(crate) limits: wgpu::Limits,
    pub(super) pipelines: HashMap<Kernel, Pipeline>,
    pub(super) buffers: HashMap<&'static str, wgpu::Buffer>,
    /// What lies in small buffers that were refilled.
    filled: HashMap<&'static str, Vec<u8>>,
    pub(super) textures: HashMap<&'static str, (wgpu::Texture, wgpu::TextureView)>,
    pub(super) clock: Option<Clock>,
    pub(super) traffic: Traffic,
    /// Output buffers are read in place.
    pub(super) direct: bool,
    /// The budget for kernels that have not run yet.
    pub(super) budget: SubmissionBudget,
    pub(super) verdict: Option<Verdict>,
    pub(super) resident: Resident,
}

pub(super) struct Pipeline {
    pub(super) compute: wgpu::ComputePipeline,
    pub(super) bindings: Vec<Binding>,
    budget: SubmissionBudget,
}

impl Gpu {
    pub(crate) fn new(open: device::Open, summary: AdapterSummary) -> Self {
        let limits = open.device.limits();
        let clock = Clock::new(&open);
        let (pipelines, buffers, textures) = (HashMap::new(), HashMap::new(), HashMap::new());
        let direct = open.is_direct(&summary);
        Self {
            clock,
            traffic: Traffic::default(),
            summary,
            open,
            limits,
            pipelines,
            buffers,
            filled: HashMap::new(),
            textures,
            direct,
            budget: SubmissionBudget::default(),
            verdict: None,
            resident: Resident::default(),
        }
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
        self.guarded(|gpu| gpu.run_unguarded(kernel, input, output, go_on))
    }

    /// Whether kernel times are measured.
    pub(crate) fn has_clock(&self) -> bool {
        self.clock.is_some()
    }

    /// Kernel time since the last call, in milliseconds by the device's clock, if it has one.
    pub(crate) fn kernel_ms(&mut self) -> Option<f64> {
        self.clock.as_mut().map(Clock::take)
    }

    /// What the device did since the last call.
    pub(crate) fn traffic(&mut self) -> Traffic {
        std::mem::take(&mut self.traffic)
    }

    /// Runs `work` and converts errors that the device reports meanwhile.
    pub(super) fn guarded<T>(&mut self, work: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        let device = self.open.device.clone();
        let scopes = [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::Validation]
            .map(|filter| device.push_error_scope(filter));
        let outcome = work(self);
        let mut failure = None;
        for scope in scopes.into_iter().rev() {
            failure = pollster::block_on(scope.pop()).or(failure);
        }
        if let Some(message) = self.open.lost.lock().ok().and_then(|lost| lost.clone()) {
            return Err(Error::DeviceLost(message));
        }
        match failure {
            None => outcome,
            Some(wgpu::Error::OutOfMemory { .. }) => Err(Error::Limits {
                problem: format!("{} is out of memory", self.summary.name),
                mend: format!("render fewer spheres, or use a smaller {SIZE}"),
            }),
            Some(error) => Err(Error::Adapter {
                problem: format!("{} failed: {error}", self.summary.name),
                mend: format!("use another {ADAPTER} or {BACKEND} cpu, and report this as a bug"),
            }),
        }
    }

    fn run_unguarded(
        &mut self,
        kernel: &Kernel,
        input: &Input<'_>,
        output: &mut Output<'_>,
        go_on: &dyn Fn(u64) -> bool,
    ) -> Result<()> {
        let Output { raw, timings } = output;
        self.resident.share_buffers();
        let record = input.record();
        self.check_limits(kernel, input)?;
        timings.time("pipeline", || self.pipeline(kernel))?;
        timings.time("upload", || self.upload(kernel, input))?;
        let mut bands = Bands::new(kernel, input, BindingLimits::from(&self.limits));
        while let Some(band) = bands.next(&self.pipelines[kernel].budget) {
            if !go_on(band.before(kernel, &record)) {
                return Err(Error::Interrupted);
            }
            let mut first_entry = 0;
            if let Some(candidates) = &input.candidates {
                let entries = Entries::of(candidates, &band);
                first_entry = entries.first();
                timings.time("upload", || entries.upload(candidates, |name, parts| self.fill_parts(name, parts)))?;
            }
            let (tests, start) = (bands.tests(&band), Instant::now());
            timings.time("trace", || self.dispatch(kernel, &record, &band))?;
            // Wall time includes the uploads before the submission, and for the first band the driver's compile time.
            let seconds = self.seconds(start);
            tracing::debug!(band.first, band.count, tests, seconds, "submitted");
            if let Some(pipeline) = self.pipelines.get_mut(kernel) {
                pipeline.budget.took(tests, seconds);
            }
            timings.time("readback", || self.read_back(kernel, &record, &band, first_entry, raw))?;
        }
        Ok(())
    }

    /// Checks the adapter's limits before any work.
    fn check_limits(&self, kernel: &Kernel, input: &Input<'_>) -> Result<()> {
        let (record, reach) = (&input.view.record, BindingLimits::from(&self.limits));
        let (largest, fit) = (reach.binding, reach.spheres(kernel, input));
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
            .min((largest / (3 * 4 * u64::from(TILE))).min(u64::from(u32::MAX)) as u32);
        if kernel.rays == RaySource::Camera && record.columns > widest {
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

    pub(super) fn pipeline(&mut self, kernel: &Kernel) -> Result<()> {
        if self.pipelines.contains_key(kernel) {
            return Ok(());
        }
        let capabilities = crate::gpu::layout::capabilities(kernel);
        let (compute, bindings) = self.built(&compose(kernel), capabilities, kernel.method.name())?;
        self.pipelines.insert(*kernel, Pipeline { compute, bindings, budget: self.budget });
        Ok(())
    }

    /// A pipeline and what it binds. They are compiled one after the other: side by side, eight renderers of a process hung on
    /// NVIDIA's driver.
    pub(super) fn built(
        &self,
        source: &Source,
        capabilities: Capabilities,
        label: &str,
    ) -> Result<(wgpu::ComputePipeline, Vec<Binding>)> {
        let (module, info) = validate(source, capabilities)?;
        let bindings = bindings(&module, &info);
        Ok((compile(&self.open.device, label, module), bindings))
    }

    fn upload(&mut self, kernel: &Kernel, input: &Input<'_>) -> Result<()> {
        uploads(kernel, input).into_iter().try_for_each(|(name, bytes)| match is_texture(name) {
            true => self.fill_texture(name, bytes),
            false => self.fill(name, bytes),
        })
    }

    fn dispatch(&mut self, kernel: &Kernel, record: &ViewRecord, band: &Band) -> Result<()> {
        let (record, pixels, groups) = match kernel.rays {
            RaySource::Camera => {
                let record = ViewRecord { first_row: band.first, rows: band.count, ..*record };
                let [columns, rows] = record.tiles().map(|[first, last]| last - first + 1);
                (record, record.pixels() as u64, (columns, rows))
            }
            _ => {
                let record = ViewRecord { first_row: band.first, rows: 1, width: band.count, ..*record };
                (record, u64::from(band.count), (band.count.div_ceil(GROUP), 1))
            }
        };
        self.fill("view", bytemuck::bytes_of(&record))?;
        self.reserve_outputs(kernel, pixels);
        self.submit(kernel, pixels, groups)
    }

    /// One dispatch, with copies of the outputs to buffers that can be mapped.
    pub(super) fn submit(&mut self, kernel: &Kernel, pixels: u64, groups: (u32, u32)) -> Result<()> {
        let pipeline = &self.pipelines[kernel];
        let entries: Vec<_> = pipeline
            .bindings
            .iter()
            .map(|b| wgpu::BindGroupEntry { binding: b.binding, resource: self.bound(b.name, kernel, pixels) })
            .collect();
        let mut encoder = self.record(&pipeline.compute, &entries, groups, self.times());
        for output in KernelOutput::of(kernel).filter(|_| !self.direct) {
            let (from, to) = (&self.buffers[output.name], &self.buffers[output.staging]);
            encoder.copy_buffer_to_buffer(from, 0, to, 0, pixels * output.bytes());
        }
        self.finish(encoder, true, |gpu| gpu.ask(kernel, pixels))
    }

    /// A dispatch that is recorded and not yet submitted.
    pub(super) fn record(
        &self,
        pipeline: &wgpu::ComputePipeline,
        entries: &[wgpu::BindGroupEntry<'_>],
        groups: (u32, u32),
        times: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) -> wgpu::CommandEncoder {
        let layout = &pipeline.get_bind_group_layout(0);
        let bound = wgpu::BindGroupDescriptor { label: None, layout, entries };
        let group = self.open.device.create_bind_group(&bound);
        let mut encoder = self.open.device.create_command_encoder(&Default::default());
        let described = wgpu::ComputePassDescriptor { label: None, timestamp_writes: times };
        let mut pass = encoder.begin_compute_pass(&described);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(groups.0, groups.1, 1);
        drop(pass);
        encoder
    }

    /// A texture, or the part of a buffer that this dispatch uses. Buffers are kept between frames, so they may be larger.
    pub(super) fn bound(&self, name: &'static str, kernel: &Kernel, pixels: u64) -> wgpu::BindingResource<'_> {
        if let Some((_, view)) = self.textures.get(name) {
            return wgpu::BindingResource::TextureView(view);
        }
        let buffer = &self.buffers[name];
        let size = KernelOutput::of(kernel).find(|o| o.name == name).and_then(|o| NonZeroU64::new(pixels * o.bytes()));
        wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })
    }

    /// Checks that the adapter can bind a buffer of this size.
    pub(super) fn check_size(&self, name: &str, bytes: u64) -> Result<()> {
        let largest = self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size);
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

    /// The same, unless the buffer was filled with these bytes last; for small ones.
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
        let uniform = ["view", "projection", "near", "placing", "part", "sky"].contains(&name);
        let usage = if uniform { wgpu::BufferUsages::UNIFORM } else { wgpu::BufferUsages::STORAGE };
        // A binding cannot be empty. Kernels read as many entries as the view record counts, so the padding is never
        // read.
        let size = parts.iter().map(|part| part.len() as u64).sum::<u64>().max(SMALLEST);
        self.check_size(name, size)?;
        self.reserve(name, size, usage | wgpu::BufferUsages::COPY_DST);
        let mut offset = 0;
        for part in parts {
            self.open.queue.write_buffer(&self.buffers[name], offset, part);
            offset += part.len() as u64;
        }
        self.traffic.up += offset;
        Ok(())
    }

    pub(super) fn reserve(&mut self, name: &'static str, size: u64, usage: wgpu::BufferUsages) {
        if self.buffers.get(name).is_none_or(|buffer| buffer.size() < size) {
            let descriptor = wgpu::BufferDescriptor { label: Some(name), size, usage, mapped_at_creation: false };
            self.buffers.insert(name, self.open.device.create_buffer(&descriptor));
        }
    }
}

/// Size of the smallest buffer in bytes: enough for one record of any kind.
const SMALLEST: u64 = 64;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answers::raw::Raw;
    use crate::certify::binned::{BinnedScene, Binning};
    use crate::frame::report::Timings;
    use crate::gpu::device;
    use crate::gpu::input::KernelRays;
    use crate::intersect::Method;
    use crate::kernel::{Generals, Sharing};
    use crate::memory::Pool;
    use crate::search::tile_candidates::{CandidateList, TileCandidates};
    use crate::shade::Shade;
    use crate::view::View;

    /// All ways of sharing loaded spheres give the same bits.
    #[test]
    fn every_way_of_sharing_gives_the_same_frame() {
        let Some(found) = crate::testing::adapter_or_skip() else { return };
        let lanes = found.summary.subgroup.map_or(0, |[least, _]| least);
        let mut gpu = Gpu::new(device::open(&found).expect("a device"), found.summary);
        let scene = crate::testing::weekend([131, 74]);
        // Includes the low parts for the kernels that read them.
        let mut view = View::new(&scene).expect("a view");
        view.keep_residuals(&scene.spheres.centers, &scene.spheres.radii);
        let binned =
            BinnedScene::new(&Binning::of(&scene, &view, 1e-6, &Pool::default())).expect("a stage").expect("a lens");
        let pool = Pool::default();
        let mut answers = Vec::new();
        for (sharing, least) in Sharing::ALL.into_iter().zip([0, 4, 8, 1]) {
            if lanes < least {
                println!("not tested: {sharing:?} needs subgroups of {least}, this adapter has {lanes}");
                continue;
            }
            let kernel = Kernel {
                sharing,
                shade: Some(Shade::Headlight),
                colors: true,
                t: true,
                normal: true,
                ..Kernel::bare(Method::Stable)
            };
            let certified = Kernel { certify: true, generals: Generals::Lists, ..kernel }.winners();
            let tiles = |kernel| Kernel { tiles: true, ..kernel };
            let mut raws = Vec::new();
            // SwiftShader takes ten seconds to compile a second normal in wider arithmetic.
            let wide = |method| Kernel { method, shade: Some(Shade::Flat), ..kernel };
            let f64 = gpu.summary.f64.then(|| wide(Method::Native64));
            let all = [kernel, certified, wide(Method::DoubleFloat)].into_iter().chain(f64);
            for kernel in all.chain([tiles(kernel), tiles(wide(Method::DoubleFloat))]) {
                let mut raw = Raw::new(&kernel, 131 * 74, &Pool::default()).expect("room");
                let tile_candidates = || {
                    CandidateList::Uncertified(TileCandidates::new(
                        &view,
                        &scene.spheres,
                        &binned,
                        kernel.is_wide(),
                        &pool,
                    ))
                };
                let candidates = match kernel.certify {
                    true => Some(CandidateList::Certified(&binned)),
                    false => kernel.tiles.then(tile_candidates),
                };
                let input = Input {
                    view: &view,
                    colors: scene.spheres.colors.as_deref(),
                    rays: KernelRays::Viewing,
                    candidates,
                };
                let mut output = Output { raw: &mut raw, timings: &mut Timings::default() };
                gpu.run(&kernel, &input, &mut output, &|_| true).expect("a frame");
                raws.push(raw);
            }
            answers.push((sharing, raws));
        }
        assert!(
            answers[0].1.iter().all(|raw| raw.id.iter().filter(|id| **id != crate::view::ray::NONE).count() > 1000),
            "the scene shows something"
        );
        for (sharing, raws) in &answers[1..] {
            assert!(raws == &answers[0].1, "{sharing:?} differs");
        }
    }
}
