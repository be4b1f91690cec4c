//! Whether the process began with a standard output. The standard library opens /dev/null in place of one that is closed, so
//! that what is written there would be lost without an error.

use std::sync::atomic::{AtomicBool, Ordering};

/// Whether there is none.
static CLOSED: AtomicBool = AtomicBool::new(false);

/// Whether the process began without a standard output; known on Linux, where /proc shows it.
pub(super) fn output_is_closed() -> bool {
    CLOSED.load(Ordering::Relaxed)
}

/// Runs before the standard library opens anything.
#[cfg(target_os = "linux")]
mod before_main {
    use super::CLOSED;
    use std::fs::symlink_metadata;
    use std::sync::atomic::Ordering;

    #[used]
    #[expect(unsafe_code, reason = "nothing else runs before the standard library replaces closed streams")]
    // SAFETY: the section holds pointers to functions of this type, which the loader calls once, on the only thread.
    #[unsafe(link_section = ".init_array")]
    static LOOK: extern "C" fn() = look;

    extern "C" fn look() {
        let is_there = |path: &str| symlink_metadata(path).is_ok();
        CLOSED.store(is_there("/proc/self/fd") && !is_there("/proc/self/fd/1"), Ordering::Relaxed);
    }
}
