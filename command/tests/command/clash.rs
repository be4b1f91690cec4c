//! The promise that no input is overwritten and that no two outputs are one file: exit code 2, before any work.

use crate::numpy::{little, npy_of};
use crate::test_dir::{Output, TestDir};
use std::collections::BTreeMap;

const SCENE: &str = "[camera]\neye = [0.0, 0.0, 0.0]\nview = [0.0, 0.0, -1.0]\nup = [0.0, 1.0, 0.0]\nvfov = 60.0\n
[image]\nsize = [8, 6]\n\n[[spheres]]\nfile = \"folder/spheres.npy\"\n";

/// One sphere as halfline's own .npy of a position and a radius.
fn spheres() -> Vec<u8> {
    npy_of("<f8", "False", "(1, 4)", &little(&[0.0, 0.0, -3.0, 1.0]))
}

fn dir() -> TestDir {
    let dir = TestDir::new(&[
        ("s.toml", SCENE),
        ("q.csv", "x,y,z,radius,q\n0,0,-5,1,1\n1,0,-5,1,2\n"),
        ("7.xyz", &"1\nH\nH 0 0 0\n".repeat(12)),
    ]);
    std::fs::create_dir(dir.path("folder")).expect("a folder");
    dir.put("folder/spheres.npy", spheres());
    dir.put("n.npy", spheres());
    dir
}

/// All files, one folder deep.
fn everything(dir: &TestDir) -> (BTreeMap<String, Vec<u8>>, Vec<Vec<u8>>) {
    let entries = std::fs::read_dir(dir.path("folder")).expect("a folder").map(|entry| entry.expect("an entry"));
    (dir.files(), entries.map(|entry| std::fs::read(entry.path()).expect("a file")).collect())
}

fn refused(dir: &TestDir, words: &str, expected: &[&str]) {
    let before = everything(dir);
    let Output { code, out, err } = dir.run(words);
    assert_eq!(code, 2, "{words}: {err}");
    assert!(out.is_empty() && !err.contains("rendering on"), "{words}: before any work: {err}");
    expected.iter().for_each(|expected| assert!(err.contains(expected), "{words}: no {expected:?} in {err}"));
    assert!(everything(dir) == before, "{words}: files have changed");
}

#[test]
fn an_input_is_not_overwritten() {
    let dir = dir();
    let read = "is an input and would be overwritten";
    refused(&dir, "render n.npy --backend cpu -o n.npy", &["n.npy", read]);
    refused(&dir, "render n.npy --backend cpu -o ./folder/../n.npy", &["is the input"]);
    refused(&dir, "render n.npy --backend cpu -o a.png --aov depth=n.npy", &["n.npy", read]);
    refused(&dir, "render s.toml --backend cpu -o a.png --aov depth=folder/spheres.npy", &["folder/spheres.npy", read]);
    dir.put("q.svg", dir.get("q.csv"));
    refused(&dir, "render q.svg --format csv --color-by q --legend q.svg --backend cpu -o a.png", &["q.svg", read]);
    dir.put("map.npy", "0,0,0\n1,1,1\n");
    refused(&dir, "render q.csv --color-by q --map map.npy --backend cpu -o map.npy", &["map.npy", read]);
    // By a later frame of a numbered pattern.
    dir.put("frame7.npy", dir.get("7.xyz"));
    refused(&dir, "render frame7.npy --format xyz --frames 1-9 --backend cpu -o frame%d.npy", &["frame7.npy", read]);
    refused(&dir, "render frame7.npy --format xyz --frames 1- --backend cpu -o frame%d.npy", &["frame7.npy", read]);
    dir.render("frame7.npy --format xyz --frames 1-6 --size 4x4 -o frame%d.npy");
    // The topology of a trajectory: a frame of one atom, which is not compressed.
    let head = [1995i32, 1, 0, 0].into_iter().flat_map(i32::to_be_bytes).chain([0; 36]);
    dir.put("move.xtc", head.chain(1i32.to_be_bytes()).chain([0; 12]).collect::<Vec<u8>>());
    dir.put("atom7.npy", "1\nH\nH 0 0 0\n");
    std::fs::copy(dir.path("atom7.npy"), dir.path("atom.xyz")).expect("copied");
    dir.put("atom.npy", dir.get("atom.xyz"));
    refused(&dir, "render move.xtc --topology atom.npy --backend cpu -o atom.npy", &["atom.npy", read]);
    refused(&dir, "render move.xtc --topology atom7.npy --frames 1- --backend cpu -o atom%d.npy", &["atom7.npy", read]);
    dir.render("move.xtc --topology atom.xyz --size 4x4 -o atom.png");

    for (tile, name) in [("1/2", "1.png"), ("2/2", "2.png")] {
        dir.render(&format!("s.toml --tile {tile} -o {name}"));
    }
    refused(&dir, "merge 1.png 2.png -o 2.png", &["2.png", read]);
    refused(&dir, "compare 1.png 2.png -o 1.png", &["1.png", read]);
    std::fs::copy(dir.path("s.toml"), dir.path("folder/report.html")).expect("copied");
    refused(&dir, "measure folder/report.html --backend cpu --out folder", &["report.html", read]);
    dir.put("folder/records.json", "{}");
    refused(&dir, "measure --from folder/records.json --out folder", &["records.json", read]);
}

#[cfg(unix)]
#[test]
fn an_input_is_not_overwritten_through_a_link() {
    let dir = dir();
    std::os::unix::fs::symlink("n.npy", dir.path("soft.npy")).expect("linked");
    std::os::unix::fs::symlink("soft.npy", dir.path("softer.npy")).expect("linked");
    std::fs::hard_link(dir.path("n.npy"), dir.path("hard.npy")).expect("linked");
    for name in ["soft.npy", "softer.npy", "hard.npy"] {
        refused(&dir, &format!("render n.npy --backend cpu -o {name}"), &[name, "is the input n.npy"]);
        refused(&dir, &format!("render {name} --backend cpu -o n.npy"), &["is the input"]);
    }
    // Standard output that the shell appends to the input.
    let append = format!("{} render n.npy --backend cpu -o - >> n.npy", env!("CARGO_BIN_EXE_halfline"));
    let before = dir.get("n.npy");
    let status = std::process::Command::new("sh").args(["-c", &append]).current_dir(dir.path("")).status();
    assert_eq!(status.expect("sh runs").code(), Some(2));
    assert!(dir.get("n.npy") == before);
}

#[test]
fn no_two_outputs_are_one_file() {
    let dir = dir();
    let twice = "would be written twice";
    dir.refused_render(2, "s.toml --aov depth=d.npy --aov id=./d.npy", &[twice]);
    refused(&dir, "render 7.xyz --frames 7 --backend cpu --aov depth=d7.npy --aov id=d%d.npy", &["d7.npy"]);
    refused(&dir, "render q.csv --color-by q --legend a.png -o ./a.png --backend cpu", &[twice]);
    let both = "would both write";
    refused(&dir, "render 7.xyz --frames 1-12 --backend cpu --aov depth=z%d.npy --aov id=z1%d.npy", &[both, "z11.npy"]);
    refused(
        &dir,
        "render 7.xyz --spin 1000 --backend cpu --aov depth=z%d.npy --aov id=z%04d.npy",
        &[both, "z1000.npy"],
    );
    refused(&dir, "render q.csv --color-by q --range 0,1 --spin 8 --legend l8.png -o l%d.png --backend cpu", &[both]);
    let before = dir.files().len();
    dir.render("7.xyz --frames 1-10 --size 4x4 --aov depth=z%d.npy --aov id=z1%d.npy");
    assert_eq!(dir.files().len(), before + 20, "up to ten the names differ");
    assert_eq!(dir.array("z110.npy").1, [4, 4]);
    dir.render("7.xyz --size 4x4 --aov depth=e.exr --aov id=./e.exr");
}
