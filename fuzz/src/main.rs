//! Runs the fuzz target of `harness` named in `HALFLINE_FUZZ` under libFuzzer. `list`, `unpack TARGET FOLDER` and `pack TARGET
//! FOLDER` instead of libFuzzer's options print the targets, unpack the corpus of one and pack it; the script `run` uses them.

#![no_main]

mod corpus;
mod counting;
mod harness;
mod pack;

use counting::Counting;
use harness::Target;
use libfuzzer_sys::fuzz_target;
use std::path::Path;
use std::sync::LazyLock;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

static TARGET: LazyLock<Target> = LazyLock::new(|| {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().expect("the first pool");
    let name = std::env::var("HALFLINE_FUZZ").expect("HALFLINE_FUZZ names a target");
    Target::all().into_iter().find(|target| target.name == name).unwrap_or_else(|| panic!("no target {name}"))
});

/// Runs a command that is not libFuzzer's, and exits.
fn command() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let file = |target: &str| Path::new("corpus").join(target).with_extension("zip");
    let names: Vec<_> = Target::all().iter().map(|target| target.name).collect();
    match &arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["list"] => println!("{}", names.join("\n")),
        ["unpack", target, _] if !names.contains(target) => {
            println!("there is no target {target}; the targets are {}", names.join(" "));
            std::process::exit(1);
        }
        ["unpack", target, folder] => pack::unpack(&file(target), Path::new(folder)),
        ["pack", target, folder] => pack::pack(Path::new(folder), &file(target)),
        _ => return,
    }
    std::process::exit(0);
}

/// The processor time of this thread in seconds, which other load does not affect.
fn processor_time() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the pointer is valid for the call.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

fuzz_target!(init: command(), |data: &[u8]| {
    let target = &*TARGET;
    let (memory, began) = (counting::begin(), processor_time());
    let allowed = target.run(data);
    let (memory, seconds) = (counting::most_since(memory), processor_time() - began);
    assert!(memory <= allowed.bytes, "{memory} bytes were held where {} are allowed", allowed.bytes);
    assert!(seconds <= allowed.seconds, "{seconds} s were worked where {} are allowed", allowed.seconds);
});
