//! Adapters: listing, selecting and opening them.

use super::alone::alone;
use super::busy::Busy;
use super::wait::{Pending, block_on};
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::{ADAPTER, BACKEND};
use serde::Serialize;
use std::sync::{Arc, Mutex};

/// The description of an adapter. `--adapter` takes its index.
#[derive(Debug, Clone, Serialize)]
pub struct AdapterSummary {
    /// Index in the list, from 0.
    pub index: usize,
    /// The driver's name for the device.
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub kind: &'static str,
    /// `vulkan`, `metal` or `dx12`.
    pub backend: String,
    /// The driver and its version.
    pub driver: String,
    /// Smallest and largest number of lanes of a subgroup; `None` without subgroups.
    pub subgroup: Option<[u32; 2]>,
    /// Whether shaders can use f64.
    pub f64: bool,
    /// The largest storage buffer a shader can bind, in bytes.
    pub max_binding: u64,
    /// The largest buffer, in bytes.
    pub max_buffer: u64,
}

impl AdapterSummary {
    /// Whether the host's processor computes the shaders.
    pub(crate) fn is_software(&self) -> bool {
        self.kind == "software"
    }

    /// Whether device and host share memory. If not, kernels would write slowly to memory that the host can map.
    pub(crate) fn shares_memory(&self) -> bool {
        ["software", "integrated"].contains(&self.kind)
    }

    /// The description of a device that the caller opened.
    pub(crate) fn of_device(device: &wgpu::Device) -> Self {
        summary(0, device.adapter_info(), device.features(), &device.limits())
    }
}

/// An adapter and its description.
pub(crate) struct FoundAdapter {
    pub(crate) adapter: wgpu::Adapter,
    pub(crate) summary: AdapterSummary,
}

/// Every adapter of the backends that WGPU_BACKEND selects, hardware before software.
pub(crate) fn find() -> Result<Vec<FoundAdapter>> {
    let requested = wgpu::Backends::from_env();
    if requested.is_some_and(|b| b.is_empty()) {
        let variable = std::env::var("WGPU_BACKEND").unwrap_or_default();
        let problem = format!("WGPU_BACKEND={variable} is not a backend");
        return Err(Error::Adapter { problem, mend: "name vulkan, metal or dx12, or leave it unset".into() });
    }
    let backends = requested.unwrap_or(wgpu::Backends::PRIMARY);
    let descriptor = wgpu::InstanceDescriptor {
        backends,
        // The flags of a debug build would search for validation layers on the user's machine.
        flags: wgpu::InstanceFlags::empty().with_env(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    };
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = block_on(instance.enumerate_adapters(backends));
    adapters.sort_by_key(|adapter| rank(adapter.get_info().device_type));
    let found = |(index, adapter): (usize, wgpu::Adapter)| FoundAdapter {
        summary: summary(index, adapter.get_info(), adapter.features(), &adapter.limits()),
        adapter,
    };
    Ok(adapters.into_iter().enumerate().map(found).collect())
}

/// Every adapter, in the order of their indices.
///
/// # Errors
/// [`Error::Adapter`] if WGPU_BACKEND names an unknown backend.
pub fn adapters() -> Result<Vec<AdapterSummary>> {
    let _alone = alone();
    Ok(find()?.into_iter().map(|found| found.summary).collect())
}

fn rank(kind: wgpu::DeviceType) -> u8 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

fn summary(index: usize, info: wgpu::AdapterInfo, features: wgpu::Features, limits: &wgpu::Limits) -> AdapterSummary {
    let kind = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => "discrete",
        wgpu::DeviceType::IntegratedGpu => "integrated",
        wgpu::DeviceType::VirtualGpu => "virtual",
        wgpu::DeviceType::Cpu => "software",
        wgpu::DeviceType::Other => "other",
    };
    AdapterSummary {
        index,
        kind,
        backend: info.backend.to_string(),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        subgroup: features
            .contains(wgpu::Features::SUBGROUP)
            .then_some([info.subgroup_min_size, info.subgroup_max_size]),
        f64: features.contains(wgpu::Features::SHADER_F64),
        max_binding: limits.max_storage_buffer_binding_size,
        max_buffer: limits.max_buffer_size,
        // A browser may not say it.
        name: if info.name.is_empty() { format!("{} adapter", info.backend) } else { info.name },
    }
}

/// Selects an adapter by index, by part of its name (ignoring case), or the first. `None` if no adapter was requested
/// and none exists.
pub(crate) fn choose(mut found: Vec<FoundAdapter>, requested: Option<&str>) -> Result<Option<FoundAdapter>> {
    let Some(requested) = requested else {
        return Ok(if found.is_empty() { None } else { Some(found.swap_remove(0)) });
    };
    let by_name = |f: &FoundAdapter| f.summary.name.to_lowercase().contains(&requested.to_lowercase());
    let place = match requested.parse::<usize>() {
        Ok(index) => (index < found.len()).then_some(index),
        Err(_) => found.iter().position(by_name),
    };
    if let Some(place) = place {
        return Ok(Some(found.swap_remove(place)));
    }
    let list: Vec<_> = found.iter().map(|f| format!("{}: {}", f.summary.index, f.summary.name)).collect();
    let problem = match list.as_slice() {
        [] => format!("no adapter matches '{requested}': none was found"),
        list => format!("no adapter matches '{requested}'; found {}", list.join(", ")),
    };
    Err(Error::Adapter {
        problem,
        mend: "give the index or part of the name of a listed adapter (see: halfline adapters)".into(),
    })
}

/// The result of `open` for the first adapter that opens; `None` where none does. The errors of adapters that do not
/// open are added to `passed_over`.
pub(crate) fn open_first<T>(
    found: &[FoundAdapter],
    open: impl Fn(&FoundAdapter) -> Result<T>,
    passed_over: &mut Vec<String>,
) -> Option<T> {
    found.iter().find_map(|found| match open(found) {
        Ok(opened) => Some(opened),
        Err(error) => {
            passed_over.push(if let Error::Adapter { problem, .. } = error { problem } else { error.to_string() });
            None
        }
    })
}

/// The error when a GPU is required and there is none.
pub(crate) fn none_found() -> Error {
    Error::Adapter {
        problem: "no Vulkan, Metal or DX12 adapter was found".into(),
        mend: format!(
            "install a driver (software Vulkan on Debian or Ubuntu: apt-get install mesa-vulkan-drivers libvulkan1), \
             or use {BACKEND} cpu"
        ),
    }
}

/// An open device, and the record of its loss.
pub(crate) struct Open {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) lost: Arc<Mutex<Option<String>>>,
    /// Bytes that are written in one submission. Until it is done, wgpu keeps a copy of them on the host.
    pub(crate) part: usize,
    /// Bytes that were written since the last submission of such, and this submission.
    unsent: usize,
    sent: Option<wgpu::SubmissionIndex>,
    pub(super) pending: Pending,
    pub(super) busy: Busy,
}

/// The usual [`Open::part`].
const PART: usize = 64 << 20;

impl Open {
    pub(crate) fn new(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let (lost, busy) = (Arc::default(), Busy::default());
        Self { device, queue, lost, part: PART, unsent: 0, sent: None, pending: Pending::new(), busy }
    }

    /// The same device for another renderer.
    pub(super) fn another(&self) -> Self {
        let (lost, busy) = (Arc::clone(&self.lost), self.busy.clone());
        Self { lost, part: self.part, busy, ..Self::new(self.device.clone(), self.queue.clone()) }
    }

    /// Whether the output buffers can be read in place without a copy, and doing so is faster.
    pub(crate) fn is_direct(&self, summary: &AdapterSummary) -> bool {
        summary.shares_memory() && self.device.features().contains(DIRECT)
    }

    /// Writes bytes into a buffer.
    ///
    /// # Errors
    /// As [`Open::wrote`].
    pub(super) fn write(&mut self, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) -> Result<()> {
        let size = self.part;
        bytes.chunks(size).enumerate().try_for_each(|(n, part)| {
            self.queue.write_buffer(buffer, offset + (n * size) as u64, part);
            self.wrote(part.len())
        })
    }

    /// Counts bytes that were written. After [`Open::part`] of them they are submitted, and the submission before them is waited for, so that
    /// wgpu has copies of two at most.
    ///
    /// # Errors
    /// [`Error::DeviceLost`].
    pub(super) fn wrote(&mut self, bytes: usize) -> Result<()> {
        self.unsent += bytes;
        if self.unsent < self.part {
            return Ok(());
        }
        self.unsent = 0;
        let last = self.sent.replace(self.queue.submit([]));
        last.map_or(Ok(()), |last| self.wait(Some(last)))
    }

    /// Waits for a submission, or for all.
    ///
    /// # Errors
    /// [`Error::DeviceLost`].
    pub(super) fn wait(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<()> {
        self.pending.wait(&self.device, &self.queue, submission_index)
    }
}

/// Lets the host map the output buffers of a kernel.
const DIRECT: wgpu::Features = wgpu::Features::MAPPABLE_PRIMARY_BUFFERS;

/// Opens a device with all limits of the adapter and the features that kernels can use, and creates a clock if there is
/// one.
pub(crate) fn open(found: &FoundAdapter) -> Result<Open> {
    let features = wgpu::Features::SHADER_F64 | wgpu::Features::TIMESTAMP_QUERY;
    let features = features | if found.summary.shares_memory() { DIRECT } else { wgpu::Features::empty() };
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("halfline"),
        required_features: found.adapter.features() & features,
        required_limits: found.adapter.limits(),
        ..Default::default()
    };
    let (device, queue) = block_on(found.adapter.request_device(&descriptor)).map_err(|e| Error::Adapter {
        problem: format!("{} cannot be opened: {e}", found.summary.name),
        mend: format!("choose another {ADAPTER}, or {BACKEND} cpu"),
    })?;
    let open = Open::new(device, queue);
    let note = |lost: &Mutex<Option<String>>, message| {
        if let Ok(mut lost) = lost.lock() {
            lost.get_or_insert(message);
        }
    };
    let lost = Arc::clone(&open.lost);
    open.device.set_device_lost_callback(move |reason, message| {
        note(&lost, if message.is_empty() { format!("{reason:?}") } else { message });
    });
    // Outside of `Gpu::guarded` only small buffers are made: a device that has no memory even for these is as good as lost.
    let lost = Arc::clone(&open.lost);
    open.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| note(&lost, error.to_string())));
    Ok(open)
}
