//! The promise of messages: `--quiet` leaves out notes and keeps warnings, errors and results.

use crate::test_dir::{SPHERE, TestDir};

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
        assert!(words.starts_with("measure") || quiet.out == loud.out, "{words}: results stay");
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
