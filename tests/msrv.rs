//! The promise: no dependency declares a newer Rust version than Cargo.toml. For crates that declare none, a CI job
//! builds with that version.

use serde_json::Value;
use std::process::Command;

fn version(text: &str) -> Vec<u64> {
    text.split('.').map(|part| part.parse().expect("a number")).collect()
}

#[test]
fn no_dependency_needs_a_newer_rust() {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["metadata", "--locked", "--format-version", "1"]).current_dir(env!("CARGO_MANIFEST_DIR"));
    let output = cargo.output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let declared: Vec<_> = packages.iter().filter_map(|p| Some((p, p["rust_version"].as_str()?))).collect();
    assert!(declared.len() > 100, "only {} of {} packages declare a Rust", declared.len(), packages.len());
    let ours = env!("CARGO_PKG_RUST_VERSION");
    let newer: Vec<_> = declared
        .iter()
        .filter(|(_, theirs)| version(theirs) > version(&format!("{ours}.0")))
        .map(|(package, theirs)| format!("{} {} needs {theirs}", package["name"], package["version"]))
        .collect();
    assert!(newer.is_empty(), "rust-version is {ours}, but {}", newer.join(", "));
}
