//! The promise: errors that fuzzing found stay repaired. Every input of the corpus, the shortest for each path through the
//! readers, runs through the harness of the fuzzer again: see fuzz/README.md.

#![expect(unsafe_code, reason = "a global allocator needs it")]

#[path = "../fuzz/src/counting.rs"]
mod counting;
#[path = "../fuzz/src/harness.rs"]
mod harness;

use harness::Target;
use std::fs;
use std::panic::{self, AssertUnwindSafe};
use std::path::PathBuf;

#[global_allocator]
static ALLOCATOR: counting::Counting = counting::Counting;

/// The inputs of a target, in the order of their names.
fn inputs(target: &str) -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target);
    let entries = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut inputs: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
    inputs.sort();
    inputs
}

#[test]
fn every_input_of_the_corpus_is_read_or_refused() {
    let mut faults = Vec::new();
    for name in Target::names() {
        let (target, inputs) = (Target::named(name).expect("a target"), inputs(name));
        assert!(inputs.len() > 1, "{name} has no corpus");
        for path in &inputs {
            let data = fs::read(path).expect("a file");
            let held = counting::begin();
            match panic::catch_unwind(AssertUnwindSafe(|| target.run(&data))) {
                Ok(allowed) if counting::most_since(held) <= allowed.bytes => {}
                Ok(allowed) => {
                    faults.push(format!("{}: more than {} bytes were allocated", path.display(), allowed.bytes))
                }
                Err(_) => faults.push(format!("{}: it panics, as printed above", path.display())),
            }
        }
        println!("{name}: {} inputs", inputs.len());
    }
    // Only some targets create the folder.
    let _ = fs::remove_dir_all(harness::desk());
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
