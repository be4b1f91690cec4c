//! The promise: no dependency declares a newer Rust version than Cargo.toml, and no document or workflow names another. For
//! crates that declare none, a CI job builds with that version. No dependency of the Python package has other features than in the
//! tests.

#[path = "common/home.rs"]
mod home;

use home::home;
use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;

fn version(text: &str) -> Vec<u64> {
    text.split('.').map(|part| part.parse().expect("a number")).collect()
}

#[test]
fn no_dependency_needs_a_newer_rust() {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["metadata", "--locked", "--format-version", "1"]).current_dir(home());
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

/// The words after `before` in a text, up to the end of their line or a comma.
fn after<'a>(text: &'a str, before: &str) -> Vec<&'a str> {
    text.split(before).skip(1).map(|rest| rest.split(['\n', ',', ' ']).next().unwrap_or_default()).collect()
}

#[test]
fn documents_and_workflows_name_the_rust_of_the_manifest() {
    let text = |file: &str| {
        let path = home().join(file);
        std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{file}: {e}"))
    };
    let ours = env!("CARGO_PKG_RUST_VERSION").trim_end_matches(".0");
    for (file, before) in
        [("README.md", "[Rust](https://rustup.rs), "), ("docs/python.md", "[Rust](https://rustup.rs) ")]
    {
        assert_eq!(after(&text(file), before), [ours], "{file} names another Rust than Cargo.toml");
    }
    // A job that installs a fixed version falls behind Cargo.toml: the one of the oldest Rust reads it from there.
    let mut oldest = 0;
    for file in [".github/workflows/ci.yml", ".github/workflows/weekly.yml"] {
        let text = text(file);
        let (actions, toolchains) = (after(&text, "dtolnay/rust-toolchain@"), after(&text, "toolchain: "));
        assert_eq!(actions.len(), toolchains.len(), "{file}: an installation of Rust does not say which");
        for (action, toolchain) in actions.into_iter().zip(toolchains) {
            assert!(action.len() == 40, "{file}: rust-toolchain@{action} is not a commit");
            oldest += usize::from(toolchain == "${{");
            assert!(["stable", "${{"].contains(&toolchain), "{file}: installs Rust {toolchain}");
        }
        let version = text.contains("rust-version = ") && text.contains("steps.oldest.outputs.version");
        assert_eq!(version, file.ends_with("ci.yml"), "{file}: where the oldest Rust is read");
    }
    assert_eq!(oldest, 1, "jobs with the oldest Rust");
}

/// The packages of a build with their features.
fn features(of: &str) -> BTreeSet<String> {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["tree", "--locked", "--offline", "--prefix", "none", "--format", "{p} [{f}]"]).args(of.split(' '));
    let output = cargo.current_dir(home()).output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    text.lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
}

/// One dependency with other features is compiled twice, and so is all that depends on it.
#[test]
fn the_wheel_has_the_build_of_the_tests() {
    let tests = features("--workspace --exclude halfline-page --exclude halfline-page-bind --edges normal,build,dev");
    let wheel = features("--package halfline-python --features like-tests --edges normal,build");
    let other: Vec<_> = wheel.difference(&tests).filter(|line| !line.starts_with("halfline-python ")).collect();
    assert!(
        wheel.len() > 100 && other.is_empty(),
        "add to `like-tests` of python/Cargo.toml what these lack: {other:?}"
    );
}
