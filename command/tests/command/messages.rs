//! The promise of messages: `--quiet` leaves out notes and keeps warnings, errors and results; with `--json` a failure
//! prints one object.

use crate::test_dir::{NO_ADAPTER, Output, SPHERE, TestDir, failure};

fn dir() -> TestDir {
    // Without radii a table has a default one, with a warning.
    let dir = TestDir::new(&[("s.toml", SPHERE), ("bare.csv", "x,y,z\n0,0,0\n4,0,0\n"), ("bad.toml", "[camera]\n")]);
    for (tile, name) in [("1/2", "1.png"), ("2/2", "2.png")] {
        dir.render(&format!("s.toml --tile {tile} -o {name}"));
    }
    dir
}

#[test]
fn quiet_leaves_out_notes_and_keeps_warnings_and_results() {
    let dir = dir();
    for words in [
        "render s.toml --backend cpu -o a.png",
        "render s.toml --backend cpu -o a.png --resume",
        "render bare.csv --backend cpu --radius 1 -o a.png",
        "render s.toml --backend cpu -o a.png --look figure --accuracy auto --tolerance 1e-3",
        "render s.toml --backend cpu --aov id=id.npy --preview",
        "trace s.toml --backend cpu --pattern lidar:rings=2,vfov=-9..9,step=90 -o hits.npz",
        "plan s.toml --backend cpu -o a.png --look soft",
        "measure s.toml --backend cpu --size 4x4 --repeat 1 --methods stable",
        "merge 1.png 2.png -o a.png",
        "compare 1.png 1.png -o -",
    ] {
        let (loud, quiet) = (dir.good(words), dir.good(&format!("{words} --quiet")));
        assert!(loud.err.contains("halfline: ") || words.contains("compare"), "{words}: {}", loud.err);
        assert_eq!(quiet.err, "", "{words}");
        // Times differ from run to run, and so does the free memory.
        let same = |output: &Output| {
            let text = String::from_utf8_lossy(&output.out).into_owned();
            text.lines()
                .filter(|line| !line.contains("memory") && !line.contains("free"))
                .collect::<Vec<_>>()
                .join("\n")
        };
        assert!(words.starts_with("measure") || same(&quiet) == same(&loud), "{words}: results stay");
    }
    let warned = dir.render("bare.csv --size 20x20 -o a.png --quiet").err;
    let warnings = warned.lines().filter(|line| line.starts_with("halfline: warning: ")).count();
    assert!(warnings > 0 && warnings == warned.lines().count(), "{warned}");
    dir.refused_render(3, "bad.toml -o b.png --quiet", &["bad.toml:1:1: camera.at: missing"]);
    let environment = [("HALFLINE_QUIET", "1")];
    assert_eq!(dir.run_with("render s.toml --backend cpu -o a.png", &environment).err, "");
    // Progress for programs was asked for.
    let lines = dir.render("s.toml -o a.png --quiet --progress json").err;
    assert!(lines.lines().count() > 0 && lines.lines().all(|line| line.starts_with('{')), "{lines}");
}

#[test]
fn quiet_changes_nothing_of_the_json() {
    let dir = dir();
    let report = |options: &str| {
        let mut report = dir.render(&format!("bare.csv --size 20x20 --json{options}")).json();
        let times = report.as_object_mut().expect("an object");
        times.retain(|key, _| !key.ends_with("_ms"));
        report
    };
    assert_eq!(report(" --quiet"), report(""));
}

#[test]
fn a_failure_with_json_is_an_object() {
    let dir = dir();
    let refused = |code: i32, words: &str, expected: &[&str]| dir.refused(code, words, expected);
    refused(2, "render s.toml --json --bogus", &["--bogus"]);
    refused(2, "render --json", &["<SCENE>"]);
    refused(2, "merge 1.png 2.png --json", &["--json"]);
    refused(2, "compare - - --json", &["only one of the frames"]);
    refused(2, "trace s.toml --json", &["--rays"]);
    refused(2, "measure --json", &["SCENE"]);
    refused(2, "adapters --json extra", &["extra"]);
    refused(2, "render s.toml --json -o -", &["standard output"]);
    refused(3, "render bad.toml --backend cpu --json -o b.png", &["camera.at", "missing"]);
    refused(3, "plan bad.toml --json -o b.png", &["camera.at", "missing"]);
    refused(3, "measure bad.toml --json", &["camera.at", "missing"]);
    refused(8, "compare 1.png none.png --json", &["none.png"]);
    refused(8, "trace none.toml --pattern lidar:rings=2,vfov=-9..9,step=90 --json", &["none.toml"]);
    refused(8, "render s.toml --backend cpu --json -o none/a.png", &["none"]);
    dir.refused_with(4, "render s.toml --json --backend gpu", &NO_ADAPTER, &["adapter"]);
    dir.refused_with(8, "render s.toml --json", &[("HALFLINE_CONFIG", "none.toml")], &["none.toml"]);
    dir.put("cell.xyz", "1\nLattice=\"4 0 0 0 4 0 0 0 4\"\nC 0 0 0\n");
    refused(5, "render cell.xyz --backend cpu --copies 99999,99999,99 --json", &["spheres"]);
    // A word behind `--` is a file name, and help is no failure.
    dir.refused(8, "render -o a.png -- --jason", &["--jason"]);
    let after = dir.run(&["render", "-o", "b.png", "--", "--json"]);
    assert_eq!((after.code, after.text().as_str()), (8, ""), "{}", after.err);
    assert!(!dir.good("render --help --json").text().contains("{\"error\""));
    // The message of the argument parser on one line, without the usage.
    let usage = failure(&dir.run("render s.toml --json --bogus").text(), 2);
    assert!(usage.starts_with("unexpected argument '--bogus' found") && !usage.contains("Usage"), "{usage}");
    let value = failure(&dir.run("render s.toml --json --samples 0").text(), 2);
    assert!(value.contains("--samples") && !value.contains("For more"), "{value}");
    // A difference is a result.
    assert_eq!(dir.run("compare 1.png 2.png --json").json()["equal"], false);
}

#[test]
fn frames_before_a_failure_keep_their_objects() {
    let dir = dir();
    dir.put("f.xyz", "1\none\nC 0 0 0\n1\ntwo\nC 0 0 zero\n");
    let output = dir.run("render f.xyz --backend cpu --frames 1-2 --size 9x9 --json");
    let lines: Vec<_> = output.text().lines().map(|line| format!("{line}\n")).collect();
    assert_eq!((output.code, lines.len()), (3, 2), "{}", output.err);
    assert_eq!(output.json_lines()[0]["spheres"], 1);
    assert!(failure(&lines[1], 3).contains("f.xyz:6"), "{}", lines[1]);
}
