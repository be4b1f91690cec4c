//! What goes to the device, what it writes, and in how many pieces: told by `halfline plan`, done by dispatch.rs.

use super::certified::{ENTRY, LIST_HEAD};
use super::dispatch::{GROUP, Input, TILE};
use crate::plan::{Kernel, Pass, Rays};
use crate::view::{SphereLow, SphereRecord, ViewRecord};

/// Ray-sphere tests in one dispatch: a second or so on software, far below any watchdog on hardware.
const TESTS_PER_DISPATCH: u64 = 1 << 32;

/// What an adapter can take at once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    /// Bytes in one binding.
    pub(crate) binding: u64,
    /// Workgroups along one dimension of a dispatch.
    pub(crate) groups: u32,
}

impl From<&wgpu::Limits> for Reach {
    fn from(limits: &wgpu::Limits) -> Self {
        Self {
            binding: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            groups: limits.max_compute_workgroups_per_dimension,
        }
    }
}

/// A band of the frame: rows of pixels, or a run of given rays in one row.
pub(crate) struct Band {
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// The rays in pieces that fit the adapter's bindings and its patience.
pub(crate) fn bands(kernel: &Kernel, record: &ViewRecord, rays: u32, reach: &Reach) -> Vec<Band> {
    let pixels = (reach.binding / 12).min(TESTS_PER_DISPATCH / u64::from(record.spheres.max(1)));
    let most = u64::from(reach.groups);
    let (total, step) = match kernel.rays {
        Rays::Camera => {
            let tiles = (pixels / u64::from(record.width * TILE)).max(1);
            (record.height, tiles.min(most) as u32 * TILE)
        }
        _ => (rays, (pixels / u64::from(GROUP)).max(1).min(most) as u32 * GROUP),
    };
    (0..total).step_by(step as usize).map(|first| Band { first, count: step.min(total - first) }).collect()
}

/// What a kernel reads besides the view of a band, by the name of its binding.
pub(crate) fn uploads<'a>(kernel: &Kernel, input: &Input<'a>) -> Vec<(&'static str, &'a [u8])> {
    // A binding may not be empty; the kernels count, so one record of nothing is never looked at.
    static NOTHING: [u8; 64] = [0; 64];
    let or_nothing = |bytes: &'a [u8], record: usize| if bytes.is_empty() { &NOTHING[..record] } else { bytes };
    let mut all: Vec<(&'static str, &'a [u8])> = Vec::new();
    match (kernel.certify, input.stage) {
        (Some(_), Some(stage)) => all.extend([
            ("lens", bytemuck::bytes_of(&stage.lens)),
            ("fronts", or_nothing(bytemuck::cast_slice(&stage.fronts), 64)),
            ("front_mores", or_nothing(bytemuck::cast_slice(&stage.mores), 64)),
            ("nears", or_nothing(bytemuck::cast_slice(&stage.nears), 64)),
        ]),
        (Some(_), None) => {}
        (None, _) => {
            let spheres = bytemuck::cast_slice(&input.view.spheres);
            all.push(("spheres", or_nothing(spheres, size_of::<SphereRecord>())));
        }
    }
    if let (true, Some(colors)) = (kernel.colors, input.colors) {
        all.push(("colors", bytemuck::cast_slice(colors)));
    }
    if kernel.rays != Rays::Camera {
        all.push(("rays", bytemuck::cast_slice(input.rays)));
    }
    if kernel.rays == Rays::Spread || kernel.is_wide() {
        let lows = bytemuck::cast_slice(&input.view.lows);
        all.push(("lows", or_nothing(lows, size_of::<SphereLow>())));
    }
    all
}

/// A buffer that a kernel writes and the host reads: its binding, where it is read from, bytes per pixel.
pub(crate) struct Written {
    pub(crate) name: &'static str,
    pub(crate) staging: &'static str,
    pub(crate) bytes: u64,
}

/// The buffers that a kernel writes for every pixel.
pub(crate) fn outputs(kernel: &Kernel) -> impl Iterator<Item = Written> {
    [
        (kernel.certify != Some(Pass::Emit), "frame_id", "read frame_id", 4),
        (kernel.width, "frame_width", "read frame_width", 4),
        (kernel.t, "frame_t", "read frame_t", 4),
        (kernel.t && kernel.is_wide(), "frame_t_low", "read frame_t_low", 4),
        (kernel.normal, "frame_normal", "read frame_normal", 12),
        (kernel.shade.is_some(), "frame_color", "read frame_color", 12),
    ]
    .into_iter()
    .filter(|(written, ..)| *written)
    .map(|(_, name, staging, bytes)| Written { name, staging, bytes })
}

/// Bytes of a list with room for so many entries of two u32.
pub(crate) fn list_size(entries: u64) -> u64 {
    LIST_HEAD + ENTRY * entries
}
