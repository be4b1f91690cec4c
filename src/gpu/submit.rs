//! Submissions: commands, the mapping of what the host reads, the wait for both, and the time of it.

use super::Gpu;
use crate::answers::raw::Raw;
use crate::gpu::clock::Clock;
use crate::gpu::dispatch::reserve;
use crate::gpu::transfers::Band;
use crate::kernel::{Kernel, KernelOutput};
use crate::view::ViewRecord;
use halfline_ground::error::{Error, Result};
use web_time::Instant;

impl Gpu {
    /// The buffers of the kernel's outputs.
    pub(super) fn reserve_outputs(&mut self, kernel: &Kernel, pixels: u64) {
        for (buffer, bytes) in KernelOutput::buffers(kernel) {
            let reading = if self.direct { wgpu::BufferUsages::MAP_READ } else { wgpu::BufferUsages::COPY_SRC };
            self.reserve(buffer, pixels * bytes, wgpu::BufferUsages::STORAGE | reading);
        }
    }

    /// Copies the first bytes of a buffer to where the host can read them.
    pub(super) fn copy(&mut self, encoder: &mut wgpu::CommandEncoder, name: &'static str, size: u64) {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        reserve(&self.open, &mut self.staging, name, size, usage);
        encoder.copy_buffer_to_buffer(&self.buffers[name], 0, &self.staging[name], 0, size);
    }

    /// The same for all outputs, unless the host reads them in place.
    pub(super) fn copy_outputs(&mut self, encoder: &mut wgpu::CommandEncoder, kernel: &Kernel, pixels: u64) {
        if !self.direct {
            KernelOutput::buffers(kernel).for_each(|(buffer, bytes)| self.copy(encoder, buffer, pixels * bytes));
        }
    }

    /// Submits commands, asks for the mapping of buffers, and waits for all of it. `timed` if a pass of the commands writes the
    /// clock's timestamps.
    pub(super) fn finish(
        &mut self,
        mut encoder: wgpu::CommandEncoder,
        timed: bool,
        ask: impl FnOnce(&Self),
    ) -> Result<()> {
        let clock = self.clock.as_ref().filter(|_| timed);
        if let Some(clock) = clock {
            clock.resolve(&mut encoder);
        }
        let commands = encoder.finish();
        self.open.busy.during(|| {
            let submitted = self.open.queue.submit([commands]);
            if let Some(clock) = clock {
                clock.ask(&self.open);
            }
            ask(self);
            // Other renderers of the device have submissions of their own.
            self.open.wait(Some(submitted))
        })?;
        if let Some(clock) = self.clock.as_mut().filter(|_| timed) {
            clock.add();
        }
        Ok(())
    }

    /// Submits commands without a wait: what reads their results waits for both. Drivers of software run them before they return.
    pub(super) fn enqueue(&mut self, encoder: wgpu::CommandEncoder) {
        let commands = encoder.finish();
        self.open.busy.during(|| self.open.queue.submit([commands]));
    }

    /// Submits commands and reads the first `size` bytes of a buffer after them, as numbers.
    pub(super) fn fetch(
        &mut self,
        mut encoder: wgpu::CommandEncoder,
        timed: bool,
        name: &'static str,
        size: u64,
    ) -> Result<Vec<u32>> {
        self.copy(&mut encoder, name, size);
        self.finish(encoder, timed, |gpu| gpu.ask(name, size))?;
        self.take(name, size)
    }

    /// Requests the mapping of a copy, which completes with the next wait.
    pub(super) fn ask(&self, name: &'static str, size: u64) {
        self.staging[name].map_async(wgpu::MapMode::Read, 0..size, self.open.pending.mapping());
    }

    /// The first numbers of a copy whose mapping was asked for before the last wait.
    pub(super) fn take(&mut self, name: &'static str, size: u64) -> Result<Vec<u32>> {
        self.with_taken(name, size, bytemuck::pod_collect_to_vec)
    }

    /// The result of `read` with the first bytes of such a copy.
    pub(super) fn with_taken<T>(&mut self, name: &'static str, size: u64, read: impl FnOnce(&[u8]) -> T) -> Result<T> {
        let buffer = &self.staging[name];
        let done = read(&mapped(buffer, size)?);
        buffer.unmap();
        self.traffic.down += size;
        Ok(done)
    }

    /// Seconds of the last timed pass, by the device's clock if it has one, else since `start`.
    pub(super) fn seconds(&self, start: Instant) -> f64 {
        let clocked = self.clock.as_ref().and_then(Clock::last).map(|ms| ms * 1e-3);
        clocked.unwrap_or_else(|| start.elapsed().as_secs_f64())
    }

    /// The buffer in which the host reads outputs.
    fn read_from(&self, buffer: &str) -> &wgpu::Buffer {
        &(if self.direct { &self.buffers } else { &self.staging })[buffer]
    }

    /// Requests the mapping of the outputs, which completes with the next wait.
    pub(super) fn ask_outputs(&self, kernel: &Kernel, pixels: u64) {
        for (buffer, bytes) in KernelOutput::buffers(kernel) {
            self.read_from(buffer).map_async(wgpu::MapMode::Read, 0..pixels * bytes, self.open.pending.mapping());
        }
    }

    /// Takes the outputs that [`Gpu::ask_outputs`] mapped.
    pub(super) fn read_back(&mut self, kernel: &Kernel, record: &ViewRecord, band: &Band, raw: &mut Raw) -> Result<()> {
        let row = if kernel.has_pixels() { record.columns as usize } else { 1 };
        let (first, pixels) = (band.before(kernel, record) as usize, band.count as usize * row);
        for (name, bytes) in KernelOutput::buffers(kernel) {
            let bytes = pixels as u64 * bytes;
            let buffer = self.read_from(name);
            let all = mapped(buffer, bytes)?;
            for (output, before) in KernelOutput::in_buffer(kernel, name) {
                let [begin, size] = [before, output.channels].map(|values| 4 * values * pixels);
                raw.store(output.name, first, pixels, &all[begin..begin + size]);
            }
            drop(all);
            buffer.unmap();
            self.traffic.down += bytes;
        }
        Ok(())
    }
}

/// The first `size` bytes of a buffer that was mapped for reading.
fn mapped(buffer: &wgpu::Buffer, size: u64) -> Result<wgpu::BufferView> {
    buffer.get_mapped_range(0..size).map_err(|e| Error::DeviceLost(format!("a buffer cannot be read back: {e}")))
}
