//! Results on standard output, and whether the process began with one. The standard library opens /dev/null in place of one
//! that is closed, so that what is written there would be lost without an error.

use super::messages::flags;
use halfline::error::{Error, Result};
use serde::Serialize;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether there is none.
static CLOSED: AtomicBool = AtomicBool::new(false);

/// Whether the process began without a standard output; known on Linux, where /proc shows it.
pub(super) fn output_is_closed() -> bool {
    CLOSED.load(Ordering::Relaxed)
}

/// An error for a standard output that is closed.
pub(super) fn check_output() -> io::Result<()> {
    match output_is_closed() {
        true => Err(io::Error::other("standard output is closed")),
        false => Ok(()),
    }
}

/// Prints a result on standard output; failing to do so is an error.
pub(super) fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    check_output()
        .and_then(|()| out.write_all(flags(text).as_bytes()))
        .and_then(|()| out.flush())
        .map_err(|error| Error::write("-", error))
}

/// Prints a report as JSON on a line.
pub(super) fn print_json(report: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string(report).map_err(|e| Error::write("-", e.into()))?;
    print(&format!("{text}\n"))
}

#[cfg(target_os = "linux")]
#[used]
#[expect(unsafe_code, reason = "nothing else runs before the standard library replaces closed streams")]
// SAFETY: the section holds pointers to functions of this type, which the loader calls once, on the only thread.
#[unsafe(link_section = ".init_array")]
static LOOK: extern "C" fn() = look;

/// Runs before the standard library opens anything.
#[cfg(target_os = "linux")]
extern "C" fn look() {
    let is_there = |path: &str| std::fs::symlink_metadata(path).is_ok();
    CLOSED.store(is_there("/proc/self/fd") && !is_there("/proc/self/fd/1"), Ordering::Relaxed);
}
