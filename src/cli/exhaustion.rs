//! Memory that cannot be had, whoever asks for it, ends the process with the exit code of limits and not as a crash.
//!
//! What is known beforehand is refused beforehand, with numbers. What is left are small requests and those of dependencies:
//! there the standard library prints how many bytes failed and aborts. A limit of the process (`ulimit -v`) or of the system
//! is no fault of the program, so that abort becomes exit code 5; any other abort stays one.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether any request failed.
static EXHAUSTED: AtomicBool = AtomicBool::new(false);

/// Lets an abort end the process with exit code 5 once a request has failed.
pub(super) fn listen() {
    #[cfg(unix)]
    let _ = signal_hook::flag::register_conditional_shutdown(signal_hook::consts::SIGABRT, 5, &EXHAUSTED);
}

/// The system's allocator, and a note of its failures.
struct Noting;

#[global_allocator]
static ALLOCATOR: Noting = Noting;

fn noted(memory: *mut u8) -> *mut u8 {
    if memory.is_null() {
        EXHAUSTED.store(true, Ordering::SeqCst);
    }
    memory
}

#[expect(
    unsafe_code,
    reason = "there is no safe way to hear of failed requests: every call goes to the system as it came"
)]
// SAFETY: the requirements of each method are those of the same method of `System`, which gets the same arguments.
unsafe impl GlobalAlloc for Noting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        noted(unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        noted(unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        noted(unsafe { System.realloc(memory, layout, size) })
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) }
    }
}
