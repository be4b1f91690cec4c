//! The place of rendering: an adapter or the CPU path, and the reason.

#[cfg(test)]
mod tests;

use crate::gpu::Gpu;
use crate::gpu::alone::alone;
use crate::gpu::device::{self, FoundAdapter};
use crate::settings::{Backend, Settings};
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::{ADAPTER, BACKEND};

/// The end of a warning that an adapter is not used although the settings allow it.
pub(super) const INSTEAD: &str = "the CPU path is used instead";

/// The device of a renderer, and the reason for it.
pub(super) struct ChosenDevice {
    /// `None` for the CPU path.
    pub(super) gpu: Option<Box<Gpu>>,
    /// The reason for this device, in words.
    pub(super) reason: String,
    /// The reasons why adapters that were found are not used although the settings allow them.
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
        let _alone = alone();
        let named = settings.adapter.clone().or_else(|| std::env::var("WGPU_ADAPTER_NAME").ok());
        if let (None, Backend::Auto) = (&named, settings.backend) {
            return Ok(Self::first(device::find()?));
        }
        match device::choose(device::find()?, named.as_deref())? {
            Some(found) => Self::open(&found, "an adapter was requested"),
            None if settings.backend == Backend::Auto => Ok(Self::none()),
            None => Err(device::none_found()),
        }
    }

    fn cpu(reason: &str) -> Self {
        Self { gpu: None, reason: reason.into(), passed_over: Vec::new(), has_no_adapter: false }
    }

    fn none() -> Self {
        let mut place = Self::cpu("no Vulkan, Metal or DX12 adapter was found");
        place.has_no_adapter = true;
        place
    }

    /// An adapter that is open.
    pub(super) fn adapter(gpu: Gpu, reason: &str) -> Self {
        let mut place = Self::cpu(reason);
        place.gpu = Some(Box::new(gpu));
        place
    }

    /// The same device for another renderer.
    pub(super) fn another(&self) -> Self {
        let mut place = Self::cpu(&self.reason);
        place.gpu = self.gpu.as_ref().map(|gpu| Box::new(gpu.another()));
        place.passed_over.clone_from(&self.passed_over);
        place.has_no_adapter = self.has_no_adapter;
        place
    }

    fn open(found: &FoundAdapter, reason: &str) -> Result<Self> {
        Ok(Self::adapter(Gpu::new(device::open(found)?, found.summary.clone()), reason))
    }

    /// Leaves the adapter that failed: for good where it was lost or refused the work; where it was out of memory, for frames that are as
    /// large. Returns the warning that the CPU path takes over.
    ///
    /// # Errors
    /// The same error where a device was requested, and any error that is not the device's.
    pub(super) fn leave(&mut self, error: Error, backend: Backend) -> Result<String> {
        let Some(gpu) = self.gpu.as_ref().filter(|_| backend != Backend::Gpu) else { return Err(error) };
        let warning = match error {
            Error::DeviceLost(why) => format!("{} was lost ({why}): {INSTEAD}", gpu.summary.name),
            Error::Adapter { problem, .. } => format!("{problem}: {INSTEAD}"),
            Error::Limits { .. } if gpu.room.is_exhausted() => return Ok(format!("{}: {INSTEAD}", gpu.exhausted())),
            error => return Err(error),
        };
        self.close();
        self.reason.clone_from(&warning);
        self.passed_over.push(warning.clone());
        Ok(warning)
    }

    /// The warning that the CPU path takes over, where the adapter was out of memory for no more than this work. A device that was requested
    /// is tried again.
    pub(super) fn memory_blocker(&mut self, load: u64, backend: Backend) -> Option<String> {
        let gpu = self.gpu.as_mut()?;
        gpu.room.begin(load);
        (gpu.room.is_exhausted() && backend != Backend::Gpu).then(|| format!("{}: {INSTEAD}", gpu.exhausted()))
    }

    /// The first adapter that opens, hardware before software. The CPU path instead of a software adapter, and where none opens.
    fn first(found: Vec<FoundAdapter>) -> Self {
        if found.is_empty() {
            return Self::none();
        }
        let mut passed_over = Vec::new();
        let open = |found: &FoundAdapter| {
            let name = &found.summary.name;
            match found.summary.is_software() {
                true => Ok(Self::cpu(&format!("{name} is software, and the CPU path is faster than any"))),
                false => Self::open(found, &format!("{name} is the first adapter that can be used")),
            }
        };
        if let Some(mut place) = device::open_first(&found, open, &mut passed_over) {
            place.passed_over = passed_over;
            return place;
        }
        if let Some(last) = passed_over.last_mut() {
            last.push_str(": falling back to the CPU path");
        }
        let mut place = Self::cpu("no adapter that was found can be used");
        place.passed_over = passed_over;
        place
    }

    /// Drops the device, while no other thread uses its driver.
    fn close(&mut self) {
        if let Some(gpu) = self.gpu.take() {
            let _alone = alone();
            drop(gpu);
        }
    }
}

impl Drop for ChosenDevice {
    fn drop(&mut self) {
        self.close();
    }
}
