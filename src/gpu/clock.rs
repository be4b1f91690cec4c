//! Timestamp queries: the time kernels take on the device, without upload, readback and waiting.

use super::device::Open;

/// Two timestamps of 64 bits.
const BYTES: u64 = 16;

/// Two timestamps around a pass, and the buffers that transfer them to the host.
pub(super) struct Clock {
    queries: wgpu::QuerySet,
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

    /// The timestamps that a pass writes: query 0 at its beginning, query 1 at its end.
    pub(super) fn writes(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// Copies both timestamps to a buffer that the host can map.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, BYTES);
    }

    /// Requests the mapping, which completes with the next wait.
    pub(super) fn ask(&self) {
        self.staging.map_async(wgpu::MapMode::Read, .., |_| {});
    }

    /// Adds the time of the pass; call it after that wait. An unreadable timestamp does not fail the frame.
    pub(super) fn add(&mut self) {
        self.last = None;
        if let Ok(mapped) = self.staging.get_mapped_range(..)
            && let [begin, end] = bytemuck::pod_collect_to_vec::<u8, u64>(&mapped)[..]
        {
            let passed = end.saturating_sub(begin) as f64 * self.period * 1e-6;
            self.total += passed;
            // Equal timestamps carry no information.
            self.last = (passed > 0.0).then_some(passed);
        }
        self.staging.unmap();
    }

    /// Milliseconds of the last pass, if known.
    pub(super) fn last(&self) -> Option<f64> {
        self.last
    }

    /// Milliseconds since the last call.
    pub(super) fn take(&mut self) -> f64 {
        std::mem::take(&mut self.total)
    }
}
