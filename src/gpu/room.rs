//! The memory of a device. wgpu has no portable question for what is free, and its thresholds for budgets lose the device where a
//! staging buffer exceeds one of them, although it would fit elsewhere. So work is tried, and what failed is not tried again.

/// The memory that work needs, in bytes by an estimate that serves to compare, and that there was not.
pub(crate) struct Room {
    /// Of the current work.
    load: u64,
    /// Of the least work for which there was no memory.
    pub(super) least: u64,
    /// The same for trees of rays from hits, in spheres.
    pub(super) tree: usize,
}

/// A failure of a device in tests.
#[cfg(test)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    Lost,
    OutOfMemory,
    /// Work that the device refuses.
    Invalid,
}

impl Default for Room {
    fn default() -> Self {
        Self { load: 0, least: u64::MAX, tree: usize::MAX }
    }
}

impl Room {
    /// Begins work of so many bytes.
    pub(crate) fn begin(&mut self, load: u64) {
        self.load = load;
    }

    /// Notes that there is no memory for the current work.
    pub(super) fn exhaust(&mut self) {
        self.least = self.least.min(self.load);
    }

    /// Whether there was no memory for the current work, or for less.
    pub(crate) fn is_exhausted(&self) -> bool {
        self.load >= self.least
    }
}
