//! The promise: whatever halfline reads, it reads or refuses with an error: it does not panic, and its memory is bounded by
//! the size of the file. Every input of the fuzzer's corpus, the shortest for each path through the readers, runs through the
//! harness of the fuzzer again, and so do damaged ones: see fuzz/README.md. Seeds are fixed. `HALFLINE_FUZZ_RUNS=100000` runs
//! more damaged inputs of each target, `HALFLINE_FUZZ_TARGET=ply` only one target.

#![expect(unsafe_code, reason = "a global allocator needs it")]

#[path = "common/amount.rs"]
#[expect(dead_code, reason = "there is no end of damaged inputs")]
mod amount;
#[path = "../fuzz/src/corpus.rs"]
mod corpus;
#[path = "../fuzz/src/counting.rs"]
mod counting;
#[path = "common/damage.rs"]
mod damage;
#[path = "../fuzz/src/harness.rs"]
mod harness;
#[path = "common/home.rs"]
mod home;
#[path = "common/rng.rs"]
#[expect(dead_code, reason = "files need no real numbers")]
mod rng;

use amount::amount;
use damage::damage;
use harness::Target;
use home::home;
use rng::Rng;
use std::panic::{self, AssertUnwindSafe};
use std::time::{Duration, Instant};

#[global_allocator]
static ALLOCATOR: counting::Counting = counting::Counting;

/// More time than any input takes.
const SLOWEST: Duration = Duration::from_secs(10);

/// Runs an input; returns what was wrong.
fn fault(target: &Target, content: &[u8]) -> Option<String> {
    let (start, begun) = (counting::begin(), Instant::now());
    match panic::catch_unwind(AssertUnwindSafe(|| target.run(content))) {
        Ok(allowed) if counting::most_since(start) > allowed.bytes => {
            Some(format!("{} bytes were allocated, not {}", counting::most_since(start), allowed.bytes))
        }
        Ok(_) => Some(begun.elapsed()).filter(|time| *time > SLOWEST).map(|time| format!("it took {time:?}")),
        Err(_) => Some("it panics, as printed above".into()),
    }
}

// One test, because memory is counted for the whole process.
#[test]
fn every_input_of_the_corpus_is_read_or_refused_and_so_are_damaged_ones() {
    let given = std::env::var("HALFLINE_FUZZ_RUNS").map(|runs| runs.parse().expect("a number of runs"));
    let runs: usize = given.unwrap_or_else(|_| amount("damaged inputs of a target", [200, 1000, 1000]));
    let only = std::env::var("HALFLINE_FUZZ_TARGET").ok();
    let mut faults = Vec::new();
    for target in Target::all().iter().filter(|target| only.as_deref().is_none_or(|only| only == target.name)) {
        let pack = home().join("fuzz/corpus").join(target.name).with_extension("zip");
        let inputs = corpus::read(&pack);
        assert!(inputs.len() > 1, "{} has no corpus", target.name);
        for (name, content) in &inputs {
            faults.extend(fault(target, content).map(|fault| format!("{} {name}: {fault}", target.name)));
        }
        let mut rng = Rng::new(0x9e37_79b9_7f4a_7c15 ^ target.name.len() as u64);
        let begun = Instant::now();
        for run in 0..runs {
            let [(name, content), (_, other)] = [(); 2].map(|()| &inputs[rng.below(inputs.len())]);
            let mut damaged = content.clone();
            (0..=rng.below(4)).for_each(|_| damage(&mut damaged, other, &mut rng));
            faults.extend(fault(target, &damaged).map(|fault| {
                let hex: String = damaged.iter().take(8192).map(|byte| format!("{byte:02x}")).collect();
                format!("{} {name}, damaged in run {run}: {fault}; {} bytes {hex}", target.name, damaged.len())
            }));
        }
        println!("{}: {} inputs, {runs} damaged ones in {:.1?}", target.name, inputs.len(), begun.elapsed());
    }
    // Only some targets create the folder.
    let _ = std::fs::remove_dir_all(harness::check::desk());
    assert!(faults.is_empty(), "{} faults, the first:\n{}", faults.len(), faults[..faults.len().min(3)].join("\n"));
}
