//! The work of a device: what is compiled, uploaded, written and dispatched.

use super::explanation::{DeviceBuffer, ShaderFile};
use crate::certify::ProjectionRecord;
use crate::certify::placing::PlacingRecord;
use crate::gpu::Gpu;
use crate::gpu::compose::{Step, compose, compose_step};
use crate::gpu::input::{Input, KernelRays};
use crate::gpu::submission_budget::SubmissionBudget;
use crate::gpu::transfers::{Bands, BindingLimits, Entries, uploads};
use crate::kernel::{Kernel, KernelOutput};
use crate::memory::Pool;
use crate::render::setup::FrameSetup;
use crate::scene::Scene;
use crate::view::ViewRecord;

/// The work of a device.
#[derive(Default)]
pub(super) struct Work {
    pub(super) kernel: Vec<ShaderFile>,
    pub(super) uploaded: Vec<DeviceBuffer>,
    pub(super) written: Vec<DeviceBuffer>,
    pub(super) dispatches: u64,
    pub(super) spheres: Option<u64>,
}

impl Work {
    pub(super) fn of(kernel: &Kernel, setup: &FrameSetup, scene: &Scene, gpu: &Gpu) -> Self {
        if kernel.is_resident() {
            return Self::of_resident(kernel, setup, scene, gpu);
        }
        let pool = Pool::default();
        let (view, candidates) = (&setup.view, setup.candidates(scene, &pool));
        let parts = compose(kernel).files().into_iter().map(|(file, lines)| ShaderFile { file, lines }).collect();
        let pixels = view.record.pixels() as u64;
        let input = Input { view, colors: scene.spheres.colors.as_deref(), rays: KernelRays::Viewing, candidates };
        let mut uploaded = vec![DeviceBuffer { name: "view", bytes: size_of::<ViewRecord>() as u64 }];
        let bytes = |(name, bytes): (&'static str, &[u8])| DeviceBuffer { name, bytes: bytes.len() as u64 };
        uploaded.extend(uploads(kernel, &input).into_iter().map(bytes));
        let written =
            KernelOutput::of(kernel).map(|out| DeviceBuffer { name: out.name, bytes: pixels * out.bytes() }).collect();
        let limits = BindingLimits::from(&gpu.limits);
        let mut cut = Bands::new(kernel, &input, limits);
        let bands: Vec<_> = std::iter::from_fn(|| cut.next(&SubmissionBudget::default())).collect();
        if let Some(candidates) = candidates {
            // The bands pass through the same buffers one after another.
            let mut of_lists: Vec<DeviceBuffer> = Vec::new();
            for (name, more) in bands.iter().flat_map(|band| Entries::of(&candidates, band).sizes(&candidates)) {
                match of_lists.iter_mut().find(|b| b.name == name) {
                    Some(b) => b.bytes += more,
                    None => of_lists.push(DeviceBuffer { name, bytes: more }),
                }
            }
            uploaded.extend(of_lists);
        }
        let spheres = Some(limits.spheres(kernel, &input));
        Self { kernel: parts, uploaded, written, dispatches: bands.len() as u64, spheres }
    }

    /// Where the device holds the spheres: what its first frame uploads.
    fn of_resident(kernel: &Kernel, setup: &FrameSetup, scene: &Scene, gpu: &Gpu) -> Self {
        let samples = kernel.samples;
        let steps = [Step::Place, Step::Small { samples }, Step::Large { samples }].map(compose_step);
        let mut parts: Vec<ShaderFile> = Vec::new();
        for source in steps.into_iter().chain([compose(kernel)]) {
            for (file, lines) in source.files() {
                let part = ShaderFile { file, lines };
                if !parts.contains(&part) {
                    parts.push(part);
                }
            }
        }
        let (pixels, spheres) = (setup.view.record.pixels() as u64, scene.spheres.len() as u64);
        let colors = if kernel.colors { 12 * spheres } else { 0 };
        let uploaded = [
            ("view", size_of::<ViewRecord>() as u64),
            ("projection", size_of::<ProjectionRecord>() as u64),
            ("placing", size_of::<PlacingRecord>() as u64),
            ("resident", 32 * spheres),
            ("colors", colors),
        ];
        let uploaded = uploaded.into_iter().filter(|(_, bytes)| *bytes > 0);
        let uploaded = uploaded.map(|(name, bytes)| DeviceBuffer { name, bytes }).collect();
        let written =
            KernelOutput::of(kernel).map(|out| DeviceBuffer { name: out.name, bytes: pixels * out.bytes() }).collect();
        let binding = BindingLimits::from(&gpu.limits).binding;
        let fit = if kernel.colors { binding / 12 } else { u64::from(u32::MAX >> 2) };
        // The spheres are placed, go over the pixels twice in one submission, and are certified.
        Self { kernel: parts, uploaded, written, dispatches: 2, spheres: Some(fit) }
    }
}

impl Work {
    /// Adds `passes` passes of another kernel.
    pub(super) fn add(&mut self, pass: Self, passes: u32) {
        let passes = u64::from(passes);
        let new = pass.kernel.into_iter().filter(|part| !self.kernel.contains(part)).collect::<Vec<_>>();
        self.kernel.extend(new);
        for (all, more) in [(&mut self.uploaded, pass.uploaded), (&mut self.written, pass.written)] {
            for DeviceBuffer { name, bytes } in more {
                match all.iter_mut().find(|b| b.name == name) {
                    Some(b) => b.bytes += passes * bytes,
                    None => all.push(DeviceBuffer { name, bytes: passes * bytes }),
                }
            }
        }
        self.dispatches += passes * pass.dispatches;
        self.spheres = self.spheres.min(pass.spheres);
    }
}
