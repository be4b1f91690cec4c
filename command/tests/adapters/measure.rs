//! The promise of `halfline measure`: every method on every backend compared with exact arithmetic, in one record; files are
//! written completely or not at all.

use crate::adapter::gpu;
use crate::test_dir::TestDir;
use halfline::Method;
use halfline_measure::record::{Record, Run};
use halfline_measure::variant::Variant;
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A unit sphere 1e5 radii away in an oblique view, where the lecture's method shows noise.
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

fn dir() -> TestDir {
    TestDir::new(&[("far.toml", FAR)])
}

/// Runs `halfline measure`, which must succeed.
fn measured(dir: &TestDir, arguments: &str) -> String {
    dir.good(&format!("measure {arguments}")).text()
}

fn record(text: &str) -> Record {
    Record::from_json(text, "-").expect("a record")
}

/// The runs of a method that was not refused.
fn runs<'a>(record: &'a Record, method: &'a str) -> impl Iterator<Item = &'a Run> {
    record.runs.iter().filter(move |run| run.method == method && run.refused.is_none())
}

#[test]
fn every_method_is_measured_on_every_backend() {
    let dir = dir();
    let gpu = gpu().is_some();
    let record = record(&measured(&dir, "far.toml --json --repeat 3"));
    let places: Vec<_> = record.places.iter().map(|place| place.backend.as_str()).collect();
    assert_eq!(places, if gpu { vec!["gpu", "cpu"] } else { vec!["cpu"] });
    let scene = &record.scenes[0];
    assert_eq!((scene.name.as_str(), scene.size, scene.pictures, scene.spheres), ("far.toml", [40, 30], 1, 1));
    assert!(scene.hits > 100 && scene.hits < 1100, "{} hits: an outline is in view", scene.hits);
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
            // The CPU path renders fewer frames.
            let rounds = if place.backend == "gpu" { 3 } else { 2 };
            assert_eq!((run.errors.pixels, run.steady_ms.len()), (1200, rounds), "{method}");
            assert!(run.first_ms.is_some_and(|ms| ms > 0.0) && run.steady_ms.iter().all(|ms| *ms > 0.0), "{method}");
            assert_eq!(run.kernel_ms.len(), if place.timestamps { rounds } else { 0 }, "{method}");
            let map = run.map.as_ref().expect("a map");
            assert_eq!(u64::from(map.wrong.iter().sum::<u32>()), run.errors.wrong(), "{method}");
        }
    }
    let exact: Vec<_> = runs(&record, "exact").collect();
    assert_eq!(exact.len(), 1, "exact arithmetic is the same on every backend");
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
fn the_files_of_a_measurement_agree_and_are_read_back() {
    let dir = dir();
    let table = measured(&dir, "far.toml --methods exact,stable,stable --backend cpu --out out");
    assert!(table.contains("stable") && table.contains("ns/ray") && !table.contains("textbook"), "{table}");
    let entries = fs::read_dir(dir.path("out")).expect("the folder").map(|entry| entry.expect("an entry").path());
    assert!({ entries }.all(|path| path.is_file()), "no folders");
    let text = String::from_utf8(dir.get("out/records.json")).expect("UTF-8");
    let record = record(&text);
    let methods: Vec<_> = record.runs.iter().map(|run| run.method.as_str()).collect();
    assert_eq!(methods, ["stable", "exact"], "in the list's order, each once");
    assert_eq!(record.command, "halfline measure far.toml --methods exact,stable,stable --backend cpu --out out");

    let csv = String::from_utf8(dir.get("out/records.csv")).expect("UTF-8");
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().expect("a head");
    let column = |row: &[&str], name: &str| {
        row[head.iter().position(|head| *head == name).unwrap_or_else(|| panic!("no {name} in {head:?}"))].to_owned()
    };
    let rows: Vec<_> = lines.filter(|row| row.len() > 1).collect();
    assert_eq!(rows.len(), record.runs.len());
    // The driver of the CPU path has a comma in its name: columns before it are found by their number.
    for (row, run) in rows.iter().zip(&record.runs) {
        assert_eq!(column(row, "scene"), "far.toml");
        assert_eq!(column(row, "hits_pixels"), record.scenes[0].hits.to_string());
        assert!(row.contains(&run.method.as_str()), "{row:?}");
        assert!(row.contains(&run.first_ms.expect("a time").to_string().as_str()), "{row:?}");
        let samples = run.steady_ms.iter().map(f64::to_string).collect::<Vec<_>>().join(";");
        assert!(row.contains(&samples.as_str()), "{row:?}");
    }

    // Exported again from the files.
    assert!(measured(&dir, "--from out/records.json --json --out again") == text, "every digit is kept");
    for name in ["records.json", "records.csv"] {
        assert!(dir.get(&format!("out/{name}")) == dir.get(&format!("again/{name}")), "{name}");
    }
    assert_eq!(measured(&dir, "--from out/records.json"), table);
}

#[test]
fn invalid_measurements_are_refused() {
    let dir = dir();
    dir.put("other.json", "{\"schema\": \"halfline-render\"}");
    dir.put("bad.toml", FAR.replace("radius = 1.0", "radius = -1.0"));
    dir.put("file", "");
    let refused = |code: i32, arguments: &str, words: &[&str]| {
        let before = dir.files();
        let output = dir.run(&format!("measure {arguments}"));
        assert_eq!(output.code, code, "{arguments}: {}", output.err);
        assert!(
            output.out.is_empty() && words.iter().all(|word| output.err.contains(word)),
            "{arguments}: {}",
            output.err
        );
        assert!(dir.files() == before, "{arguments} left something behind");
    };
    refused(2, "", &["required", "--suite"]);
    refused(2, "far.toml --suite ladder", &["cannot be used"]);
    refused(2, "--from other.json --size 4x4", &["cannot be used"]);
    refused(2, "--suite extremes --size 4x4", &["remove --size"]);
    let names: Vec<_> = Variant::all().into_iter().map(Variant::name).collect();
    refused(2, "far.toml --methods stable,cubic", &[["cubic"].as_slice(), &names].concat());
    refused(3, "--from other.json", &["other.json", "records.json"]);
    refused(3, "bad.toml", &["radius"]);
    refused(4, "far.toml --adapter no-such-adapter", &["no-such-adapter", "halfline adapters"]);
    refused(8, "none.toml", &["none.toml"]);
    refused(8, "--from none.json", &["none.json"]);
    refused(8, "far.toml --out no/such/folder", &["no/such"]);
    refused(8, "far.toml --out file", &["file", "folder"]);
    // A frame that takes the CPU path longer than --patience allows.
    let spheres = "[[sphere]]\ncenter = [0.1, 0.2, 0.3]\nradius = 1.0\n".repeat(2000);
    dir.put("many.toml", FAR.to_owned() + &spheres);
    let slow = "many.toml --backend cpu --size 320x240 --patience 1e-3 --methods double-float";
    refused(7, slow, &["--patience", "double-float"]);
}

#[test]
#[cfg(unix)]
fn an_interrupted_measurement_leaves_nothing_behind() {
    let dir = dir();
    let mut command = dir.command("measure --suite ladder --backend cpu --out out");
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("halfline runs");
    std::thread::sleep(Duration::from_millis(500));
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill").success());
    let begun = Instant::now();
    assert_eq!(child.wait().expect("an end").code(), Some(130));
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
    assert!(!dir.path("out").exists());
}
