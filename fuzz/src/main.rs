//! Runs the fuzz target of `harness` named in `HALFLINE_FUZZ`, which `run` sets; `list` prints the names.

#![no_main]

mod config;
mod counting;
mod harness;

use counting::Counting;
use harness::Target;
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

static TARGET: LazyLock<Target> = LazyLock::new(|| {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().expect("the first pool");
    let name = std::env::var("HALFLINE_FUZZ").unwrap_or_default();
    Target::named(&name).unwrap_or_else(|| {
        println!("{}", Target::names().join("\n"));
        std::process::exit(i32::from(name != "list"));
    })
});

/// The processor time of this thread in seconds, which other load does not affect.
fn processor_time() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the pointer is valid for the call.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

fuzz_target!(|data: &[u8]| {
    let target = &*TARGET;
    let (held, began) = (counting::begin(), processor_time());
    let allowed = target.run(data);
    let (held, seconds) = (counting::most_since(held), processor_time() - began);
    assert!(held <= allowed.bytes, "{held} bytes were held where {} are allowed", allowed.bytes);
    assert!(seconds <= allowed.seconds, "{seconds} s were worked where {} are allowed", allowed.seconds);
});
