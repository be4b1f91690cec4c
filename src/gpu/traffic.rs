//! Traffic of the device: its working time, and the bytes sent to it and read back.

use std::time::Duration;

/// Sums since they were last taken.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Traffic {
    /// The time in which the device had work of this renderer or of others on it.
    pub(crate) busy: Duration,
    /// Milliseconds of kernels by the device's clock, if it has one.
    pub(crate) kernel_ms: Option<f64>,
    /// Bytes that were written to buffers and textures.
    pub(crate) up: u64,
    /// Bytes that were read back.
    pub(crate) down: u64,
}
