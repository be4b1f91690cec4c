//! Signals: the first request to end lets the work end tidily, the second ends the process at once.

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::{register, register_conditional_shutdown};
use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Requests to end.
#[cfg(unix)]
const ENDS: [i32; 3] = [SIGINT, SIGTERM, signal_hook::consts::SIGHUP];
#[cfg(not(unix))]
const ENDS: [i32; 2] = [SIGINT, SIGTERM];

/// Takes the signals over. Where the system refuses, its default ends the process, which is right too. Other signals
/// keep their default, which a user may want (a core file by ctrl-\, say).
pub(super) fn listen() {
    for signal in ENDS {
        // In this order: the shutdown looks at the flag before the first signal sets it.
        let _ = register_conditional_shutdown(signal, 130, &INTERRUPTED);
        let _ = register(signal, &INTERRUPTED);
    }
    // Its default ends the process in the middle of a write beyond `ulimit -f`. With any handler the write fails, and
    // the failure is told like that of a full disk.
    #[cfg(unix)]
    {
        static BEYOND_FILE_SIZE: AtomicBool = AtomicBool::new(false);
        let _ = register(signal_hook::consts::SIGXFSZ, &BEYOND_FILE_SIZE);
    }
}

/// Whether no signal asked the process to end.
pub(super) fn go_on() -> bool {
    !INTERRUPTED.load(Ordering::SeqCst)
}
