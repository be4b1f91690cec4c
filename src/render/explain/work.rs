//! The work of a device, over all passes of a frame.

use super::explanation::{DeviceBuffer, ShaderFile};
use crate::gpu::compose::Source;
use crate::gpu::work::Work;

/// The work of all passes.
#[derive(Default)]
pub(super) struct WorkOfPasses {
    pub(super) kernel: Vec<ShaderFile>,
    pub(super) uploaded: Vec<DeviceBuffer>,
    pub(super) written: Vec<DeviceBuffer>,
    pub(super) dispatches: u64,
    pub(super) spheres: Option<u64>,
}

impl WorkOfPasses {
    /// Adds `passes` passes of given rays in so many dispatches each, whose buffers hold some rays at a time.
    pub(super) fn add_given(&mut self, shaders: &[(&'static str, Source)], dispatches: u64, passes: u32) {
        let files = shaders.iter().flat_map(|(_, source)| source.files());
        self.kernel = files.map(|(file, lines)| ShaderFile { file, lines }).collect();
        self.dispatches = dispatches * u64::from(passes);
    }

    /// Adds `passes` passes of a kernel.
    pub(super) fn add(&mut self, pass: Work, passes: u32) {
        let passes = u64::from(passes);
        for (file, lines) in pass.shaders.iter().flat_map(|source| source.files()) {
            let part = ShaderFile { file, lines };
            if !self.kernel.contains(&part) {
                self.kernel.push(part);
            }
        }
        for (all, more) in [(&mut self.uploaded, pass.uploaded), (&mut self.written, pass.written)] {
            for (name, bytes) in more {
                match all.iter_mut().find(|b| b.name == name) {
                    Some(b) => b.bytes += passes * bytes,
                    None => all.push(DeviceBuffer { name, bytes: passes * bytes }),
                }
            }
        }
        self.dispatches += passes * pass.dispatches;
        self.spheres = Some(self.spheres.map_or(pass.spheres, |fit| fit.min(pass.spheres)));
    }
}
