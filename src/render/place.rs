//! Where frames are rendered: on an adapter or on the CPU path, and why there.

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::gpu::device::{self, FoundAdapter};
use crate::gpu::selftest::Pace;
use crate::quote::number;
use crate::quote::setting::{ADAPTER, BACKEND};
use crate::settings::{Backend, Settings};

/// The device of a renderer.
pub(super) enum Executor {
    Gpu(Box<Gpu>),
    Cpu,
}

/// A device, and why it was chosen.
pub(super) struct ChosenDevice {
    pub(super) executor: Executor,
    /// Why this one, in words.
    pub(super) reason: String,
    /// Why adapters that were found are not used although the settings allow them.
    pub(super) passed_over: Vec<String>,
    /// Whether the settings left the choice and there was no adapter.
    pub(super) has_no_adapter: bool,
}

impl ChosenDevice {
    /// The place that `settings` select. `WGPU_ADAPTER_NAME` and `WGPU_BACKEND` apply where they leave a choice.
    ///
    /// # Errors
    /// [`Error::Adapter`] when no adapter fits, [`Error::Settings`] for an adapter with the CPU path.
    pub(super) fn of(settings: &Settings) -> Result<Self> {
        if settings.backend == Backend::Cpu && settings.adapter.is_some() {
            return Err(Error::settings(
                format!("{BACKEND} cpu does not use an adapter"),
                format!("remove {ADAPTER} or use {BACKEND} gpu"),
            ));
        }
        if settings.backend == Backend::Cpu {
            return Ok(Self::cpu("the CPU path was requested"));
        }
        let named = settings.adapter.clone().or_else(|| std::env::var("WGPU_ADAPTER_NAME").ok());
        if let (None, Backend::Auto) = (&named, settings.backend) {
            let software = if settings.part { Software::Avoided } else { Software::Measured };
            return Ok(Self::first(device::find()?, software));
        }
        match device::choose(device::find()?, named.as_deref())? {
            Some(found) => Self::open(&found, "an adapter was requested".into()),
            None if settings.backend == Backend::Auto => Ok(Self::none()),
            None => Err(device::none_found()),
        }
    }

    fn cpu(reason: &str) -> Self {
        Self { executor: Executor::Cpu, reason: reason.into(), passed_over: Vec::new(), has_no_adapter: false }
    }

    fn none() -> Self {
        Self { has_no_adapter: true, ..Self::cpu("no Vulkan, Metal or DX12 adapter was found") }
    }

    fn open(found: &FoundAdapter, reason: String) -> Result<Self> {
        let gpu = Gpu::new(device::open(found)?, found.summary.clone());
        Ok(Self { executor: Executor::Gpu(Box::new(gpu)), ..Self::cpu(&reason) })
    }

    /// The first adapter that opens, hardware before software. The CPU path instead of a software adapter that is not
    /// clearly faster, and where none opens.
    fn first(found: Vec<FoundAdapter>, software: Software) -> Self {
        if found.is_empty() {
            return Self::none();
        }
        let mut passed_over = Vec::new();
        let open = |found: &FoundAdapter| match software.reason(found)? {
            (true, reason) => Self::open(found, reason),
            (false, reason) => Ok(Self::cpu(&reason)),
        };
        if let Some(place) = device::open_first(&found, open, &mut passed_over) {
            return Self { passed_over, ..place };
        }
        if let Some(last) = passed_over.last_mut() {
            last.push_str(": falling back to the CPU path");
        }
        Self { passed_over, ..Self::cpu("no adapter that was found can be used") }
    }
}

/// How the choice between a software adapter and the CPU path is made.
#[derive(Clone, Copy)]
enum Software {
    /// By the time that both take for a small frame.
    Measured,
    /// Always the CPU path, so that no measurement can send the parts of a frame to different places.
    Avoided,
}

impl Software {
    /// Whether the adapter is preferred to the CPU path, and why.
    ///
    /// # Errors
    /// Those of the measurement.
    fn reason(self, found: &FoundAdapter) -> Result<(bool, String)> {
        let name = &found.summary.name;
        if !found.summary.is_software() {
            return Ok((true, format!("{name} is the first adapter that can be used")));
        }
        if matches!(self, Self::Avoided) {
            return Ok((false, format!("parts of a frame are rendered on the CPU path where {name} is software")));
        }
        let pace = Pace::of(found)?;
        let [of_adapter, of_cpu] = [pace.adapter_ms, pace.cpu_ms].map(|ms| number(ms, 3));
        let words = match pace.prefers_adapter() {
            true => format!("{name} is faster than the CPU path: a small frame takes {of_adapter} ms, not {of_cpu}"),
            false => format!(
                "the CPU path is as fast as {name} or faster: a small frame takes {of_cpu} ms, not {of_adapter}"
            ),
        };
        Ok((pace.prefers_adapter(), words))
    }
}
