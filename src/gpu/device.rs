//! Adapters: listing, selecting and opening them.

use crate::error::{Error, Result};
use crate::quote::setting::{ADAPTER, BACKEND};
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
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
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
        name: info.name,
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

impl Open {
    /// Whether the output buffers can be read in place without a copy, and doing so is faster.
    pub(crate) fn is_direct(&self, summary: &AdapterSummary) -> bool {
        shares_memory(summary) && self.device.features().contains(DIRECT)
    }
}

/// An open device, and the record of its loss.
pub(crate) struct Open {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) lost: Arc<Mutex<Option<String>>>,
}

/// Lets the host map the output buffers of a kernel.
const DIRECT: wgpu::Features = wgpu::Features::MAPPABLE_PRIMARY_BUFFERS;

/// Whether device and host share memory. If not, kernels would write slowly to memory that the host can map.
fn shares_memory(summary: &AdapterSummary) -> bool {
    ["software", "integrated"].contains(&summary.kind)
}

/// Opens a device with all limits of the adapter and the features that kernels can use, and creates a clock if there is
/// one.
pub(crate) fn open(found: &FoundAdapter) -> Result<Open> {
    let features = wgpu::Features::SHADER_F64 | wgpu::Features::TIMESTAMP_QUERY;
    let features = features | if shares_memory(&found.summary) { DIRECT } else { wgpu::Features::empty() };
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("halfline"),
        required_features: found.adapter.features() & features,
        required_limits: found.adapter.limits(),
        ..Default::default()
    };
    let (device, queue) =
        pollster::block_on(found.adapter.request_device(&descriptor)).map_err(|e| Error::Adapter {
            problem: format!("{} cannot be opened: {e}", found.summary.name),
            mend: format!("choose another {ADAPTER}, or {BACKEND} cpu"),
        })?;
    let lost = Arc::new(Mutex::new(None));
    let note = Arc::clone(&lost);
    device.set_device_lost_callback(move |reason, message| {
        if let Ok(mut note) = note.lock() {
            *note = Some(if message.is_empty() { format!("{reason:?}") } else { message });
        }
    });
    Ok(Open { device, queue, lost })
}
