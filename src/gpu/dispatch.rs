//! One frame on the device: upload, dispatch band by band, read back.

use crate::certify::stage::Stage;
use crate::certify::tiles::TILE;
use crate::error::{Error, Result};
use crate::frame::raw::Raw;
use crate::gpu::clock::Clock;
use crate::gpu::compose::{compose, constants};
use crate::gpu::device::{self, AdapterSummary};
use crate::gpu::layout::{Binding, bindings, validate};
use crate::gpu::selftest::Verdict;
use crate::gpu::traffic::{Band, Reach, bands, lists, outputs, uploads};
use crate::plan::{Kernel, Rays};
use crate::report::Stages;
use crate::settle::Unsure;
use crate::tree::Tree;
use crate::view::{SphereRecord, View, ViewRecord};
use std::collections::HashMap;
use std::num::NonZeroU64;

/// Invocations in a workgroup, rays in a group; the same test.
pub(crate) const GROUP: u32 = 64;

/// An opened device, its pipelines and its buffers, kept from frame to frame.
pub(crate) struct Gpu {
    pub(crate) summary: AdapterSummary,
    pub(super) open: device::Open,
    limits: wgpu::Limits,
    pipelines: HashMap<Kernel, Pipeline>,
    buffers: HashMap<&'static str, wgpu::Buffer>,
    clock: Option<Clock>,
    pub(super) verdict: Option<Verdict>,
}

struct Pipeline {
    compute: wgpu::ComputePipeline,
    bindings: Vec<Binding>,
}

/// What the kernels read besides the view, by the name of the binding.
pub(crate) struct Input<'a> {
    pub(crate) view: &'a View,
    /// Linear RGB per sphere.
    pub(crate) colors: Option<&'a [[f32; 3]]>,
    /// Records of given rays; empty for viewing rays.
    pub(crate) rays: &'a [crate::trace::RayRecord],
    /// What the certified kernels read instead of the view's spheres.
    pub(crate) stage: Option<&'a Stage>,
    /// What given rays walk.
    pub(crate) tree: Option<&'a Tree>,
}

/// What a run leaves behind.
pub(crate) struct Output<'a> {
    pub(crate) raw: &'a mut Raw,
    /// What a certified kernel could not prove.
    pub(crate) unsure: Vec<Unsure>,
    pub(crate) stages: &'a mut Stages,
}

impl Gpu {
    pub(crate) fn new(open: device::Open, summary: AdapterSummary) -> Self {
        let limits = open.device.limits();
        let clock = Clock::new(&open);
        Self { clock, summary, open, limits, pipelines: HashMap::new(), buffers: HashMap::new(), verdict: None }
    }

    /// Fills `output` by `kernel`. `go_on` is asked between bands.
    pub(crate) fn run(
        &mut self,
        kernel: &Kernel,
        input: &Input<'_>,
        output: &mut Output<'_>,
        go_on: &dyn Fn() -> bool,
    ) -> Result<()> {
        self.guarded(|gpu| gpu.run_unguarded(kernel, input, output, go_on))
    }

    /// Whether kernels are timed.
    pub(crate) fn has_clock(&self) -> bool {
        self.clock.is_some()
    }

    /// How long kernels ran since this was last asked, milliseconds by the device's clock, if it has one.
    pub(crate) fn kernel_ms(&mut self) -> Option<f64> {
        self.clock.as_mut().map(Clock::take)
    }

    /// Does `work` and turns what the device complains of meanwhile into errors of ours.
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
                mend: "render fewer spheres or a smaller --size".into(),
            }),
            Some(error) => Err(Error::Adapter {
                problem: format!("{} refused the work: {error}", self.summary.name),
                mend: "choose another --adapter or --backend cpu, and report it".into(),
            }),
        }
    }

    fn run_unguarded(
        &mut self,
        kernel: &Kernel,
        input: &Input<'_>,
        output: &mut Output<'_>,
        go_on: &dyn Fn() -> bool,
    ) -> Result<()> {
        let Output { raw, unsure, stages } = output;
        let record = input.view.record;
        self.check_limits(kernel, &record)?;
        stages.time("pipeline", || self.pipeline(kernel))?;
        stages.time("upload", || self.upload(kernel, input))?;
        for band in bands(kernel, input, &Reach::from(&self.limits)) {
            if !go_on() {
                return Err(Error::Interrupted);
            }
            if let Some(stage) = input.stage {
                stages.time("upload", || {
                    lists(stage, &band).uploads().iter().try_for_each(|(name, parts)| self.fill_parts(name, parts))
                })?;
            }
            stages.time("trace", || self.dispatch(kernel, &record, &band))?;
            stages.time("readback", || self.read_back(kernel, &record, &band, raw, unsure))?;
        }
        Ok(())
    }

    /// Refuses, before any work, what the adapter cannot hold.
    fn check_limits(&self, kernel: &Kernel, record: &ViewRecord) -> Result<()> {
        let largest = self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size);
        let fit = largest / size_of::<SphereRecord>() as u64;
        // A certified frame holds the lists of one band at a time.
        if !kernel.certify && u64::from(record.spheres) > fit {
            return Err(Error::Limits {
                problem: format!(
                    "{} spheres need {} bytes in one buffer and {} binds {largest}",
                    record.spheres,
                    u64::from(record.spheres) * size_of::<SphereRecord>() as u64,
                    self.summary.name
                ),
                mend: format!("render at most {fit} spheres, or use --backend cpu"),
            });
        }
        let widest = (self.limits.max_compute_workgroups_per_dimension * TILE)
            .min((largest / (3 * 4 * u64::from(TILE))).min(u64::from(u32::MAX)) as u32);
        if kernel.rays == Rays::Camera && record.width > widest {
            return Err(Error::Limits {
                problem: format!(
                    "{} columns are more than {} can write in one dispatch",
                    record.width, self.summary.name
                ),
                mend: format!("render at most {widest} columns, or use --backend cpu"),
            });
        }
        Ok(())
    }

    pub(super) fn pipeline(&mut self, kernel: &Kernel) -> Result<()> {
        if self.pipelines.contains_key(kernel) {
            return Ok(());
        }
        let source = compose(kernel);
        let (module, info) = validate(&source, crate::gpu::layout::capabilities(kernel))?;
        let shader = self.open.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(kernel.method.name()),
            source: wgpu::ShaderSource::Wgsl(source.text.as_str().into()),
        });
        let compute = self.open.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(kernel.method.name()),
            layout: None,
            module: &shader,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants(kernel),
                zero_initialize_workgroup_memory: false,
            },
            cache: None,
        });
        self.pipelines.insert(*kernel, Pipeline { compute, bindings: bindings(&module, &info) });
        Ok(())
    }

    fn upload(&mut self, kernel: &Kernel, input: &Input<'_>) -> Result<()> {
        uploads(kernel, input).into_iter().try_for_each(|(name, bytes)| self.fill(name, bytes))
    }

    fn dispatch(&mut self, kernel: &Kernel, record: &ViewRecord, band: &Band) -> Result<()> {
        let (record, pixels, groups) = match kernel.rays {
            Rays::Camera => {
                let record = ViewRecord { first_row: band.first, rows: band.count, ..*record };
                let groups = (record.width.div_ceil(TILE), band.count.div_ceil(TILE));
                (record, u64::from(record.width) * u64::from(band.count), groups)
            }
            _ => {
                let record = ViewRecord { first_row: band.first, rows: 1, width: band.count, ..*record };
                (record, u64::from(band.count), (band.count.div_ceil(GROUP), 1))
            }
        };
        self.fill("view", bytemuck::bytes_of(&record))?;
        for output in outputs(kernel) {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
            let bytes = pixels * output.bytes;
            self.reserve(output.name, bytes, usage);
            self.reserve(output.staging, bytes, READING);
        }
        if kernel.certify {
            self.reserve_unsure(pixels);
        }
        self.submit(kernel, pixels, groups)
    }

    /// One dispatch, and copies of what it wrote to where they can be read.
    pub(super) fn submit(&mut self, kernel: &Kernel, pixels: u64, groups: (u32, u32)) -> Result<()> {
        let pipeline = &self.pipelines[kernel];
        let entries: Vec<_> = pipeline
            .bindings
            .iter()
            .map(|b| wgpu::BindGroupEntry { binding: b.binding, resource: self.bound(b.name, kernel, pixels) })
            .collect();
        let group = self.open.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.compute.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = self.open.device.create_command_encoder(&Default::default());
        if kernel.certify {
            encoder.clear_buffer(&self.buffers["unsure"], 0, Some(8));
        }
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: None,
                timestamp_writes: self.clock.as_ref().map(Clock::writes),
            });
            pass.set_pipeline(&pipeline.compute);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(groups.0, groups.1, 1);
        }
        for output in outputs(kernel) {
            let (from, to) = (&self.buffers[output.name], &self.buffers[output.staging]);
            encoder.copy_buffer_to_buffer(from, 0, to, 0, pixels * output.bytes);
        }
        if kernel.certify {
            let (from, to) = (&self.buffers["unsure"], &self.buffers["read unsure"]);
            encoder.copy_buffer_to_buffer(from, 0, to, 0, Self::unsure_bytes(pixels));
        }
        if let Some(clock) = &self.clock {
            clock.resolve(&mut encoder);
        }
        self.open.queue.submit([encoder.finish()]);
        if let Some(clock) = &self.clock {
            clock.ask();
        }
        self.wait()?;
        if let Some(clock) = &mut self.clock {
            clock.add();
        }
        Ok(())
    }

    fn read_back(
        &mut self,
        kernel: &Kernel,
        record: &ViewRecord,
        band: &Band,
        raw: &mut Raw,
        unsure: &mut Vec<Unsure>,
    ) -> Result<()> {
        let row = if kernel.rays == Rays::Camera { record.width as usize } else { 1 };
        let (first, pixels) = (band.first as usize * row, band.count as usize * row);
        let read: Vec<_> = outputs(kernel).collect();
        for output in &read {
            self.buffers[output.staging].map_async(wgpu::MapMode::Read, 0..pixels as u64 * output.bytes, |_| {});
        }
        let listed = Self::unsure_bytes(pixels as u64);
        if kernel.certify {
            self.buffers["read unsure"].map_async(wgpu::MapMode::Read, 0..listed, |_| {});
        }
        self.wait()?;
        if kernel.certify {
            let list = mapped(&self.buffers["read unsure"], listed)?.to_vec();
            self.buffers["read unsure"].unmap();
            unsure.extend(self.unsure(&list)?);
        }
        for output in &read {
            let staging = &self.buffers[output.staging];
            {
                let mapped = mapped(staging, pixels as u64 * output.bytes)?;
                raw.store(output.name, first, pixels, &mapped);
            }
            staging.unmap();
        }
        Ok(())
    }

    /// The first bytes of a buffer.
    pub(super) fn read(&mut self, name: &'static str, size: u64) -> Result<Vec<u8>> {
        self.reserve("read list", size, READING);
        let staging = &self.buffers["read list"];
        let mut encoder = self.open.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&self.buffers[name], 0, staging, 0, size);
        self.open.queue.submit([encoder.finish()]);
        staging.map_async(wgpu::MapMode::Read, 0..size, |_| {});
        self.wait()?;
        let bytes = mapped(staging, size)?.to_vec();
        staging.unmap();
        Ok(bytes)
    }

    pub(super) fn wait(&self) -> Result<()> {
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: None };
        self.open.device.poll(wait).map(drop).map_err(|e| Error::DeviceLost(e.to_string()))
    }

    /// The part of a buffer that belongs to this dispatch: buffers are kept, so they may be larger.
    fn bound(&self, name: &'static str, kernel: &Kernel, pixels: u64) -> wgpu::BindingResource<'_> {
        let buffer = &self.buffers[name];
        let size = outputs(kernel).find(|o| o.name == name).and_then(|o| NonZeroU64::new(pixels * o.bytes));
        wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })
    }

    /// Refuses a buffer that the adapter cannot bind.
    pub(super) fn check_size(&self, name: &str, bytes: u64) -> Result<()> {
        let largest = self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size);
        if bytes <= largest {
            return Ok(());
        }
        Err(Error::Limits {
            problem: format!("{bytes} bytes of {name} are more than {} binds ({largest})", self.summary.name),
            mend: "render fewer at a time, or use --backend cpu".into(),
        })
    }

    pub(super) fn fill(&mut self, name: &'static str, bytes: &[u8]) -> Result<()> {
        self.fill_parts(name, &[bytes])
    }

    /// Parts one after the other; each a multiple of four bytes.
    pub(super) fn fill_parts(&mut self, name: &'static str, parts: &[&[u8]]) -> Result<()> {
        let uniform = ["view", "lens"].contains(&name);
        let usage = if uniform { wgpu::BufferUsages::UNIFORM } else { wgpu::BufferUsages::STORAGE };
        // A binding may not be empty; the kernels count, so what is not written is never looked at.
        let size = parts.iter().map(|part| part.len() as u64).sum::<u64>().max(SMALLEST);
        self.check_size(name, size)?;
        self.reserve(name, size, usage | wgpu::BufferUsages::COPY_DST);
        let mut offset = 0;
        for part in parts {
            self.open.queue.write_buffer(&self.buffers[name], offset, part);
            offset += part.len() as u64;
        }
        Ok(())
    }

    pub(super) fn reserve(&mut self, name: &'static str, size: u64, usage: wgpu::BufferUsages) {
        if self.buffers.get(name).is_none_or(|buffer| buffer.size() < size) {
            let descriptor = wgpu::BufferDescriptor { label: Some(name), size, usage, mapped_at_creation: false };
            self.buffers.insert(name, self.open.device.create_buffer(&descriptor));
        }
    }
}

/// Bytes of the smallest buffer: room for one record of any kind.
const SMALLEST: u64 = 64;

/// The first bytes of a buffer that was mapped for reading.
fn mapped(buffer: &wgpu::Buffer, size: u64) -> Result<wgpu::BufferView> {
    buffer.get_mapped_range(0..size).map_err(|e| Error::DeviceLost(format!("a buffer cannot be read back: {e}")))
}

/// What a buffer is for that the host reads.
pub(super) const READING: wgpu::BufferUsages = wgpu::BufferUsages::MAP_READ.union(wgpu::BufferUsages::COPY_DST);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::device;
    use crate::intersect::Method;
    use crate::memory::Pool;
    use crate::plan::Sharing;
    use crate::scene::{ReadOptions, Scene};
    use crate::shade::Shade;
    use std::path::Path;

    /// Whichever way invocations share the spheres they load, the answers are the same bits.
    #[test]
    fn every_way_of_sharing_gives_the_same_frame() {
        if std::env::var_os("HALFLINE_NO_GPU").is_some() {
            println!("SKIPPED: HALFLINE_NO_GPU is set");
            return;
        }
        let found = device::choose(device::find().expect("adapters"), None).expect("a choice");
        let found = found.expect("an adapter; tests/run installs and pins one");
        println!("adapter: {} ({})", found.summary.name, found.summary.driver);
        let lanes = found.summary.subgroup.map_or(0, |[least, _]| least);
        let mut gpu = Gpu::new(device::open(&found).expect("a device"), found.summary);
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/weekend.toml");
        let mut scene = Scene::read(&path, &ReadOptions::default()).expect("weekend");
        (scene.image.width, scene.image.height) = (131, 74);
        // The low parts are there for those that read them.
        let mut view = View::new(&scene).expect("a view");
        view.keep_lows(&scene.spheres.centers, &scene.spheres.radii);
        let stage = Stage::new(&scene, &view, 1e-6, &crate::certify::TERMS, 0, &Pool::default())
            .expect("a stage")
            .expect("a lens");
        let mut answers = Vec::new();
        for (sharing, least) in Sharing::ALL.into_iter().zip([0, 4, 8, 1]) {
            if lanes < least {
                println!("SKIPPED: {sharing:?} needs subgroups of {least}, this adapter has {lanes}");
                continue;
            }
            let kernel = Kernel {
                method: Method::Stable,
                rays: Rays::Camera,
                sharing,
                shade: Some(Shade::Headlight),
                colors: true,
                t: true,
                normal: true,
                certify: false,
                width: false,
                tree: false,
            };
            let certified = Kernel { certify: true, width: true, ..kernel };
            let mut raws = Vec::new();
            // A second normal in better arithmetic takes SwiftShader ten seconds to compile.
            let wide = |method| Kernel { method, shade: Some(Shade::Flat), ..kernel };
            let f64 = gpu.summary.f64.then(|| wide(Method::Native64));
            for kernel in [kernel, certified, wide(Method::DoubleFloat)].into_iter().chain(f64) {
                let mut raw = Raw::new(&kernel, 131 * 74, &Pool::default()).expect("room");
                let stage = Some(&stage);
                let input =
                    Input { view: &view, colors: scene.spheres.colors.as_deref(), rays: &[], stage, tree: None };
                let mut output = Output { raw: &mut raw, unsure: Vec::new(), stages: &mut Stages::default() };
                gpu.run(&kernel, &input, &mut output, &|| true).expect("a frame");
                let mut unsure = output.unsure;
                unsure.sort_unstable_by_key(|u| u.pixel);
                raws.push((raw, unsure));
            }
            answers.push((sharing, raws));
        }
        assert!(
            answers[0].1.iter().all(|(raw, _)| raw.id.iter().filter(|id| **id != crate::ray::NONE).count() > 1000),
            "the scene shows something"
        );
        assert!(!answers[0].1[1].1.is_empty(), "something is left to settle");
        for (sharing, raws) in &answers[1..] {
            assert!(raws == &answers[0].1, "{sharing:?} differs");
        }
    }
}
