//! Submissions: commands, the mapping of what the host reads, the wait for both, and the time of it.

use super::Gpu;
use crate::answers::raw::Raw;
use crate::error::{Error, Result};
use crate::gpu::clock::Clock;
use crate::gpu::transfers::Band;
use crate::kernel::{Kernel, KernelOutput};
use crate::view::ViewRecord;
use std::time::Instant;

impl Gpu {
    /// The buffers of the kernel's outputs.
    pub(super) fn reserve_outputs(&mut self, kernel: &Kernel, pixels: u64) {
        for output in KernelOutput::of(kernel) {
            let bytes = pixels * output.bytes();
            let reading = if self.direct { wgpu::BufferUsages::MAP_READ } else { wgpu::BufferUsages::COPY_SRC };
            self.reserve(output.name, bytes, wgpu::BufferUsages::STORAGE | reading);
            if !self.direct {
                self.reserve(output.staging, bytes, READING);
            }
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
        let start = Instant::now();
        self.open.queue.submit([commands]);
        if let Some(clock) = clock {
            clock.ask();
        }
        ask(self);
        self.wait()?;
        self.traffic.busy += start.elapsed();
        if let Some(clock) = self.clock.as_mut().filter(|_| timed) {
            clock.add();
        }
        Ok(())
    }

    /// Submits commands that leave `size` bytes in a buffer for reading; its numbers.
    pub(super) fn fetch(
        &mut self,
        encoder: wgpu::CommandEncoder,
        timed: bool,
        name: &'static str,
        size: u64,
    ) -> Result<Vec<u32>> {
        self.finish(encoder, timed, |gpu| gpu.buffers[name].map_async(wgpu::MapMode::Read, 0..size, |_| {}))?;
        self.take(name, size)
    }

    /// The first numbers of a buffer whose mapping was asked for before the last wait.
    pub(super) fn take(&mut self, name: &'static str, size: u64) -> Result<Vec<u32>> {
        let buffer = &self.buffers[name];
        let numbers = bytemuck::pod_collect_to_vec(&mapped(buffer, size)?);
        buffer.unmap();
        self.traffic.down += size;
        Ok(numbers)
    }

    /// Where a pass writes its timestamps, if the device has a clock.
    pub(super) fn times(&self) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        self.clock.as_ref().map(Clock::writes)
    }

    /// Seconds of the last timed pass, by the device's clock if it has one, else since `start`.
    pub(super) fn seconds(&self, start: Instant) -> f64 {
        let clocked = self.clock.as_ref().and_then(Clock::last).map(|ms| ms * 1e-3);
        clocked.unwrap_or_else(|| start.elapsed().as_secs_f64())
    }

    /// The buffer in which the host reads an output.
    fn read_from(&self, output: &KernelOutput) -> &wgpu::Buffer {
        &self.buffers[if self.direct { output.name } else { output.staging }]
    }

    /// Requests the mapping of the outputs, which completes with the next wait.
    pub(super) fn ask(&self, kernel: &Kernel, pixels: u64) {
        for output in KernelOutput::of(kernel) {
            self.read_from(output).map_async(wgpu::MapMode::Read, 0..pixels * output.bytes(), |_| {});
        }
    }

    /// Takes the outputs that [`Gpu::ask`] mapped.
    pub(super) fn read_back(&mut self, kernel: &Kernel, record: &ViewRecord, band: &Band, raw: &mut Raw) -> Result<()> {
        let row = if kernel.has_pixels() { record.columns as usize } else { 1 };
        let (first, pixels) = (band.before(kernel, record) as usize, band.count as usize * row);
        for output in KernelOutput::of(kernel) {
            let bytes = pixels as u64 * output.bytes();
            let buffer = self.read_from(output);
            raw.store(output.name, first, pixels, &mapped(buffer, bytes)?);
            buffer.unmap();
            self.traffic.down += bytes;
        }
        Ok(())
    }

    pub(super) fn wait(&self) -> Result<()> {
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: None };
        self.open.device.poll(wait).map(drop).map_err(|e| Error::DeviceLost(e.to_string()))
    }
}

/// The first `size` bytes of a buffer that was mapped for reading.
pub(super) fn mapped(buffer: &wgpu::Buffer, size: u64) -> Result<wgpu::BufferView> {
    buffer.get_mapped_range(0..size).map_err(|e| Error::DeviceLost(format!("a buffer cannot be read back: {e}")))
}

/// The usage of buffers that the host reads.
pub(super) const READING: wgpu::BufferUsages = wgpu::BufferUsages::MAP_READ.union(wgpu::BufferUsages::COPY_DST);
