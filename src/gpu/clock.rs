//! The device's own clock: how long kernels ran, without upload, readback and waiting.

use super::device::Open;

/// Two timestamps of 64 bits.
const BYTES: u64 = 16;

/// Two timestamps around a pass and the way they take to the host.
pub(super) struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
    /// Nanoseconds in a tick.
    period: f64,
    /// Of the passes since it was last asked, milliseconds.
    total: f64,
    /// Of the last one, if it could be read.
    last: Option<f64>,
}

impl Clock {
    /// `None` where the device offers none.
    pub(super) fn new(open: &Open) -> Option<Self> {
        let Open { device, queue, .. } = open;
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: None, size: BYTES, usage, mapped_at_creation: false })
        };
        device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            staging: buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
            period: f64::from(queue.get_timestamp_period()),
            total: 0.0,
            last: None,
        })
    }

    /// Where a pass notes when it begins and ends.
    pub(super) fn writes(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// Brings both to where the host can read them.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, BYTES);
    }

    /// Asks for them, to be there after the next wait.
    pub(super) fn ask(&self) {
        self.staging.map_async(wgpu::MapMode::Read, .., |_| {});
    }

    /// Adds the pass, after that wait. A clock that cannot be read is no reason to fail a frame.
    pub(super) fn add(&mut self) {
        self.last = None;
        if let Ok(mapped) = self.staging.get_mapped_range(..)
            && let [begin, end] = bytemuck::pod_collect_to_vec::<u8, u64>(&mapped)[..]
        {
            let passed = end.saturating_sub(begin) as f64 * self.period * 1e-6;
            self.total += passed;
            // A clock that stands still tells nothing.
            self.last = (passed > 0.0).then_some(passed);
        }
        self.staging.unmap();
    }

    /// Milliseconds of the last pass, if they are known.
    pub(super) fn last(&self) -> Option<f64> {
        self.last
    }

    /// Milliseconds since it was last asked.
    pub(super) fn take(&mut self) -> f64 {
        std::mem::take(&mut self.total)
    }
}
