//! What the device did for a frame: how long it worked, and what went to it and came back.

use std::time::{Duration, Instant};

/// Sums since they were taken last.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Traffic {
    /// The time in which the device had work and the host waited for it.
    pub(crate) busy: Duration,
    /// Bytes that were written to buffers and textures.
    pub(crate) up: u64,
    /// Bytes that were read back.
    pub(crate) down: u64,
}

impl Traffic {
    /// The sums, which begin again.
    pub(crate) fn take(&mut self) -> Self {
        std::mem::take(self)
    }

    /// Adds the time since the device got its work.
    pub(super) fn worked(&mut self, since: Instant) {
        self.busy += since.elapsed();
    }
}
