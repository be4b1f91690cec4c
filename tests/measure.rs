//! The promise of `halfline measure`: every method in every place against exact arithmetic, in one record, in files that
//! are whole or not there.

#[expect(dead_code, reason = "the helpers of tests that walk the methods")]
mod common;

use halfline::Method;
use halfline::measure::contender::Contender;
use halfline::measure::record::{Record, Run};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A unit sphere 1e5 radii away, askew: the lecture's form sees noise there.
const FAR: &str = "[camera]
eye = [1e5, 2e5, -1.5e5]
at = [0.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
viewport = [1.6e-5, 1.2e-5]

[image]
size = [40, 30]

[[sphere]]
center = [0.1, 0.2, 0.3]
radius = 1.0
";

/// A folder with `far.toml` in it.
fn desk() -> tempfile::TempDir {
    let desk = tempfile::tempdir().expect("a temporary folder");
    fs::write(desk.path().join("far.toml"), FAR).expect("a scene");
    desk
}

fn command(desk: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_halfline"));
    command.arg("measure").args(arguments).current_dir(desk).stdin(Stdio::null());
    command.env("NODEVICE_SELECT", "1").env_remove("RUST_LOG");
    command
}

fn run(desk: &Path, arguments: &[&str]) -> Output {
    command(desk, arguments).output().expect("halfline runs")
}

fn good(desk: &Path, arguments: &[&str]) -> String {
    let said = run(desk, arguments);
    assert!(said.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&said.stderr));
    String::from_utf8(said.stdout).expect("text")
}

/// Refused with this code and these words, and nothing new is there.
fn refused(desk: &Path, code: i32, arguments: &[&str], words: &[&str]) {
    let before = names(desk);
    let said = run(desk, arguments);
    let err = String::from_utf8_lossy(&said.stderr);
    assert_eq!(said.status.code(), Some(code), "{arguments:?}: {err}");
    for word in words {
        assert!(err.contains(word), "{arguments:?}: {err} does not say {word}");
    }
    assert!(said.stdout.is_empty(), "{arguments:?}: {}", String::from_utf8_lossy(&said.stdout));
    assert_eq!(names(desk), before, "{arguments:?} left something behind");
}

fn names(folder: &Path) -> BTreeSet<PathBuf> {
    fs::read_dir(folder).expect("the folder").map(|entry| entry.expect("an entry").path()).collect()
}

fn record(text: &str) -> Record {
    Record::from_json(text, "-").expect("a record")
}

/// The runs of a method that was not refused.
fn runs<'a>(record: &'a Record, method: &'a str) -> impl Iterator<Item = &'a Run> {
    record.runs.iter().filter(move |run| run.method == method && run.refused.is_none())
}

#[test]
fn every_method_is_measured_in_every_place() {
    let desk = desk();
    let gpu = common::gpu().is_some();
    let record = record(&good(desk.path(), &["far.toml", "--json", "--repeat", "3"]));
    let places: Vec<_> = record.places.iter().map(|place| place.backend.as_str()).collect();
    assert_eq!(places, if gpu { vec!["gpu", "cpu"] } else { vec!["cpu"] });
    let scene = &record.scenes[0];
    assert_eq!((scene.name.as_str(), scene.size, scene.pictures, scene.spheres), ("far.toml", [40, 30], 1, 1));
    assert!(scene.hits > 100 && scene.hits < 1100, "{} hits: an outline is in the picture", scene.hits);
    assert!(scene.farthest.is_some_and(|k| (2.6e5..2.8e5).contains(&k)), "{:?}", scene.farthest);
    for (k, place) in record.places.iter().enumerate() {
        assert_eq!(place.self_test.is_empty(), place.backend == "cpu");
        let here: Vec<_> = record.runs.iter().filter(|run| run.place == k).collect();
        for method in Method::ALL.iter().map(|m| m.name()).chain(["certified"]) {
            let run = here.iter().find(|run| run.method == method).unwrap_or_else(|| panic!("{method} is missing"));
            if let Some(reason) = &run.refused {
                assert!(place.backend == "gpu" && reason.contains(method), "{method}: {reason}");
                assert_eq!((run.first_ms, run.errors.pixels, run.errors.relative.max), (None, 0, None));
                continue;
            }
            // The reference path renders fewer.
            let rounds = if place.backend == "gpu" { 3 } else { 2 };
            assert_eq!((run.errors.pixels, run.steady_ms.len()), (1200, rounds), "{method}");
            assert!(run.first_ms.is_some_and(|ms| ms > 0.0) && run.steady_ms.iter().all(|ms| *ms > 0.0), "{method}");
            assert_eq!(run.kernel_ms.len(), if place.timestamps { rounds } else { 0 }, "{method}");
            let map = run.map.as_ref().expect("a map");
            assert_eq!(u64::from(map.wrong.iter().sum::<u32>()), run.errors.wrong(), "{method}");
        }
    }
    let exact: Vec<_> = runs(&record, "exact").collect();
    assert_eq!(exact.len(), 1, "the exact way is the same everywhere");
    assert_eq!((exact[0].errors.wrong(), exact[0].errors.relative.max), (0, Some(0.0)));
    assert_eq!(runs(&record, "certified").count(), record.places.len());
    for certified in runs(&record, "certified") {
        assert_eq!(certified.errors.wrong(), 0);
        assert!(certified.errors.relative.max <= Some(record.tolerance), "{:?}", certified.errors);
        assert!(certified.of_bound.is_some_and(|share| share > 0.0 && share <= 1.0), "{:?}", certified.of_bound);
        assert!(certified.certified.is_some_and(|share| share > 0.5), "{:?}", certified.certified);
    }
    assert_eq!(runs(&record, "textbook").count(), record.places.len());
    for textbook in runs(&record, "textbook") {
        assert!(textbook.errors.wrong() > 100 && textbook.errors.outline > Some(0.01), "{:?}", textbook.errors);
        assert!(textbook.certified.is_none() && textbook.of_bound.is_none());
    }
}

#[test]
fn files_are_flat_agree_and_come_back() {
    let desk = desk();
    let table =
        good(desk.path(), &["far.toml", "--methods", "exact,stable,stable", "--backend", "cpu", "--out", "out"]);
    assert!(table.contains("stable") && table.contains("ns/ray") && !table.contains("textbook"), "{table}");
    let out = desk.path().join("out");
    assert!(names(&out).iter().all(|path| path.is_file()), "flat: {:?}", names(&out));
    let text = fs::read_to_string(out.join("records.json")).expect("records.json");
    let record = record(&text);
    let methods: Vec<_> = record.runs.iter().map(|run| run.method.as_str()).collect();
    assert_eq!(methods, ["stable", "exact"], "in the list's order, each once");
    assert_eq!(record.command, "halfline measure far.toml --methods exact,stable,stable --backend cpu --out out");

    let csv = fs::read_to_string(out.join("records.csv")).expect("records.csv");
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().expect("a head");
    let column = |row: &[&str], name: &str| {
        row[head.iter().position(|head| *head == name).unwrap_or_else(|| panic!("no {name} in {head:?}"))].to_owned()
    };
    let rows: Vec<_> = lines.filter(|row| row.len() > 1).collect();
    assert_eq!(rows.len(), record.runs.len());
    // The driver of the CPU path has a comma in its name, so everything before the quotes is read plainly.
    for (row, run) in rows.iter().zip(&record.runs) {
        assert_eq!(column(row, "scene"), "far.toml");
        assert_eq!(column(row, "hits_pixels"), record.scenes[0].hits.to_string());
        assert!(row.contains(&run.method.as_str()), "{row:?}");
        assert!(row.contains(&run.first_ms.expect("a time").to_string().as_str()), "{row:?}");
        let samples = run.steady_ms.iter().map(f64::to_string).collect::<Vec<_>>().join(";");
        assert!(row.contains(&samples.as_str()), "{row:?}");
    }

    // Exported again from what was exported, by file and by pipe.
    let again = good(desk.path(), &["--from", "out/records.json", "--json", "--out", "again"]);
    assert!(again == text, "every digit comes back");
    for name in ["records.json", "records.csv"] {
        let [a, b] = ["out", "again"].map(|folder| fs::read(desk.path().join(folder).join(name)).expect(name));
        assert!(a == b, "{name}");
    }
    assert_eq!(good(desk.path(), &["--from", "out/records.json"]), table);
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let desk = desk();
    let desk = desk.path();
    fs::write(desk.join("other.json"), "{\"schema\": \"halfline-render\"}").expect("a file");
    fs::write(desk.join("bad.toml"), FAR.replace("radius = 1.0", "radius = -1.0")).expect("a file");
    fs::write(desk.join("file"), "").expect("a file");
    refused(desk, 2, &[], &["required", "--suite"]);
    refused(desk, 2, &["far.toml", "--suite", "ladder"], &["cannot be used"]);
    refused(desk, 2, &["--from", "other.json", "--size", "4x4"], &["cannot be used"]);
    refused(desk, 2, &["--suite", "extremes", "--size", "4x4"], &["leave out --size"]);
    let names: Vec<_> = Contender::all().into_iter().map(Contender::name).collect();
    refused(desk, 2, &["far.toml", "--methods", "stable,cubic"], &[["cubic"].as_slice(), &names].concat());
    refused(desk, 3, &["--from", "other.json"], &["other.json", "records.json"]);
    refused(desk, 3, &["bad.toml"], &["radius"]);
    refused(desk, 4, &["far.toml", "--adapter", "no such adapter"], &["no such adapter", "halfline adapters"]);
    refused(desk, 8, &["none.toml"], &["none.toml"]);
    refused(desk, 8, &["--from", "none.json"], &["none.json"]);
    refused(desk, 8, &["far.toml", "--out", "no/such/folder"], &["no/such"]);
    refused(desk, 8, &["far.toml", "--out", "file"], &["file", "folder"]);
}

/// A frame that the CPU path would work on for longer than one waits.
#[test]
fn the_cpu_path_is_not_waited_for_without_end() {
    let desk = desk();
    let spheres = "[[sphere]]\ncenter = [0.1, 0.2, 0.3]\nradius = 1.0\n".repeat(2000);
    fs::write(desk.path().join("many.toml"), FAR.to_owned() + &spheres).expect("a scene");
    let arguments = ["many.toml", "--backend", "cpu", "--size", "320x240", "--patience", "1e-3"];
    refused(
        desk.path(),
        7,
        &[&arguments[..], &["--methods", "double-float"]].concat(),
        &["--patience", "double-float"],
    );
}

#[test]
#[cfg(unix)]
fn an_interrupt_leaves_nothing_behind() {
    let desk = desk();
    let arguments = ["--suite", "ladder", "--backend", "cpu", "--out", "out"];
    let mut child =
        command(desk.path(), &arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("halfline runs");
    std::thread::sleep(Duration::from_millis(500));
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill").success());
    let begun = Instant::now();
    assert_eq!(child.wait().expect("an end").code(), Some(130));
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
    assert!(!desk.path().join("out").exists());
}
