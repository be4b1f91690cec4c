//! Failed memory allocations end the process with the exit code for limits instead of a crash.
//!
//! Large requests are checked beforehand and refused with numbers. Small requests and requests of dependencies remain: for
//! them the standard library prints the number of bytes and aborts. A limit of the process (`ulimit -v`) or of the
//! system is not a fault of the program, so this abort becomes exit code 5; any other abort stays one.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether any allocation failed.
static EXHAUSTED: AtomicBool = AtomicBool::new(false);

/// Makes an abort end the process with exit code 5 after an allocation has failed.
pub(super) fn listen() {
    #[cfg(unix)]
    let _ = signal_hook::flag::register_conditional_shutdown(signal_hook::consts::SIGABRT, 5, &EXHAUSTED);
}

/// The system's allocator, with a flag for failures.
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
    reason = "there is no safe way to detect failed requests; every call is passed to the system unchanged"
)]
// SAFETY: each method has the requirements of the same method of `System`, which receives the same arguments.
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
