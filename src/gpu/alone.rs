//! The lock of a process around what its threads do to a driver one after the other.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Waits until no other thread makes or drops instances, adapters, devices or pipelines. Drivers crash and hang where threads do so side by
/// side (gfx-rs/wgpu#10234, NVIDIA/open-gpu-kernel-modules#929); eight renderers of one process hung an H200.
pub(crate) fn alone() -> MutexGuard<'static, ()> {
    static DRIVER: Mutex<()> = Mutex::new(());
    // A thread that panicked left the driver as it was.
    DRIVER.lock().unwrap_or_else(PoisonError::into_inner)
}
