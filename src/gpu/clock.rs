//! Timestamp queries: the time kernels take on the device, without upload, readback and waiting.

use super::device::Open;
use std::cell::Cell;

/// The most passes between two waits; the time of any beyond is not counted.
const PASSES: u32 = 32;

/// Two timestamps of 64 bits for each pass.
const BYTES: u64 = 16;

/// Two timestamps around each pass, and the buffers that transfer them to the host.
pub(super) struct Clock {
    queries: wgpu::QuerySet,
    /// Passes since the last wait.
    passes: Cell<u32>,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
    /// Nanoseconds per tick.
    period: f64,
    /// Milliseconds of all passes since the last call of `take`.
    total: f64,
    /// Milliseconds of the last pass, if its timestamps could be read.
    last: Option<f64>,
}

impl Clock {
    /// `None` if the device has no timestamp queries.
    pub(super) fn new(open: &Open) -> Option<Self> {
        let Open { device, queue, .. } = open;
        let buffer = |usage| {
            let size = BYTES * u64::from(PASSES);
            device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
        };
        device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: 2 * PASSES,
            }),
            passes: Cell::new(0),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            staging: buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
            period: f64::from(queue.get_timestamp_period()),
            total: 0.0,
            last: None,
        })
    }

    /// The timestamps that the next pass writes: at its beginning and at its end.
    pub(super) fn writes(&self) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let pass = self.passes.get();
        self.passes.set((pass + 1).min(PASSES));
        (pass < PASSES).then(|| wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * pass),
            end_of_pass_write_index: Some(2 * pass + 1),
        })
    }

    /// Copies the timestamps of the passes since the last wait to a buffer that the host can map.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        let passes = self.passes.get();
        if passes > 0 {
            encoder.resolve_query_set(&self.queries, 0..2 * passes, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, BYTES * u64::from(passes));
        }
    }

    /// Requests the mapping, which completes with the next wait.
    pub(super) fn ask(&self, open: &Open) {
        self.staging.map_async(wgpu::MapMode::Read, .., open.pending.mapping());
    }

    /// Adds the times of the passes; call it after that wait. An unreadable timestamp does not fail the frame.
    pub(super) fn add(&mut self) {
        self.last = None;
        let passes = self.passes.replace(0) as usize;
        if let Ok(mapped) = self.staging.get_mapped_range(..) {
            let stamps = bytemuck::pod_collect_to_vec::<u8, u64>(&mapped);
            for stamps in stamps.chunks_exact(2).take(passes) {
                let passed = stamps[1].saturating_sub(stamps[0]) as f64 * self.period * 1e-6;
                self.total += passed;
                // Equal timestamps carry no information.
                self.last = (passed > 0.0).then_some(passed);
            }
        }
        self.staging.unmap();
    }

    /// Milliseconds of the last pass, if known.
    pub(super) fn last(&self) -> Option<f64> {
        self.last
    }

    /// Milliseconds since the last call. Passes of a frame that an error ended are forgotten.
    pub(super) fn take(&mut self) -> f64 {
        self.passes.set(0);
        std::mem::take(&mut self.total)
    }
}
