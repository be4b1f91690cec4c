//! The promise that nothing is overwritten that is read, and that no two outputs are one file: exit code 2, before any work.

#[path = "common/desk.rs"]
mod desk;

use desk::Desk;
use std::collections::BTreeMap;

const SCENE: &str = "[camera]\neye = [0.0, 0.0, 0.0]\nview = [0.0, 0.0, -1.0]\nup = [0.0, 1.0, 0.0]\nvfov = 60.0\n
[image]\nsize = [8, 6]\n\n[[spheres]]\nfile = \"folder/spheres.npy\"\n";

/// One sphere as halfline's own .npy of a position and a radius.
fn spheres() -> Vec<u8> {
    let mut header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 4), }".to_owned();
    header += &format!("{}\n", " ".repeat(117 - header.len()));
    let numbers = [0.0f64, 0.0, -3.0, 1.0].into_iter().flat_map(f64::to_le_bytes);
    [b"\x93NUMPY\x01\x00\x76\x00", header.as_bytes()].concat().into_iter().chain(numbers).collect()
}

fn desk() -> Desk {
    let desk = Desk::new(&[
        ("s.toml", SCENE),
        ("q.csv", "x,y,z,radius,q\n0,0,-5,1,1\n1,0,-5,1,2\n"),
        ("7.xyz", &"1\nH\nH 0 0 0\n".repeat(12)),
    ]);
    std::fs::create_dir(desk.path("folder")).expect("a folder");
    desk.put("folder/spheres.npy", spheres());
    desk.put("n.npy", spheres());
    desk
}

/// All that is there, one folder deep.
fn everything(desk: &Desk) -> (BTreeMap<String, Vec<u8>>, Vec<Vec<u8>>) {
    let entries = std::fs::read_dir(desk.path("folder")).expect("a folder").map(|entry| entry.expect("an entry"));
    (desk.files(), entries.map(|entry| std::fs::read(entry.path()).expect("a file")).collect())
}

fn refused(desk: &Desk, words: &str, told: &[&str]) {
    let before = everything(desk);
    let said = desk.run(words);
    assert_eq!(said.code, 2, "{words}: {}", said.err);
    assert!(said.out.is_empty() && !said.err.contains("rendering on"), "{words}: before any work: {}", said.err);
    told.iter().for_each(|told| assert!(said.err.contains(told), "{words}: no {told:?} in {}", said.err));
    assert!(everything(desk) == before, "{words}: files have changed");
}

#[test]
fn what_is_read_is_not_overwritten() {
    let desk = desk();
    let read = "is read and would be overwritten";
    refused(&desk, "render n.npy --backend cpu -o n.npy", &["n.npy", read]);
    refused(&desk, "render n.npy --backend cpu -o ./folder/../n.npy", &["which is read"]);
    refused(&desk, "render n.npy --backend cpu -o a.png --aov depth=n.npy", &["n.npy", read]);
    refused(
        &desk,
        "render s.toml --backend cpu -o a.png --aov depth=folder/spheres.npy",
        &["folder/spheres.npy", read],
    );
    desk.put("q.svg", desk.get("q.csv"));
    refused(&desk, "render q.svg --format csv --color-by q --legend q.svg --backend cpu -o a.png", &["q.svg", read]);
    // By its number, which comes later.
    desk.put("frame7.npy", desk.get("7.xyz"));
    refused(&desk, "render frame7.npy --format xyz --frames 1-9 --backend cpu -o frame%d.npy", &["frame7.npy", read]);
    refused(&desk, "render frame7.npy --format xyz --frames 1- --backend cpu -o frame%d.npy", &["frame7.npy", read]);
    desk.render("frame7.npy --format xyz --frames 1-6 --size 4x4 -o frame%d.npy");

    for (tile, name) in [("1/2", "1.png"), ("2/2", "2.png")] {
        desk.render(&format!("s.toml --tile {tile} -o {name}"));
    }
    refused(&desk, "merge 1.png 2.png -o 2.png", &["2.png", read]);
    refused(&desk, "compare 1.png 2.png -o 1.png", &["1.png", read]);
    std::fs::copy(desk.path("s.toml"), desk.path("folder/report.html")).expect("copied");
    refused(&desk, "measure folder/report.html --backend cpu --out folder", &["report.html", read]);
    desk.put("folder/records.json", "{}");
    refused(&desk, "measure --from folder/records.json --out folder", &["records.json", read]);
}

#[cfg(unix)]
#[test]
fn nor_through_links() {
    let desk = desk();
    std::os::unix::fs::symlink("n.npy", desk.path("soft.npy")).expect("linked");
    std::os::unix::fs::symlink("soft.npy", desk.path("softer.npy")).expect("linked");
    std::fs::hard_link(desk.path("n.npy"), desk.path("hard.npy")).expect("linked");
    for name in ["soft.npy", "softer.npy", "hard.npy"] {
        refused(&desk, &format!("render n.npy --backend cpu -o {name}"), &[name, "n.npy, which is read"]);
        refused(&desk, &format!("render {name} --backend cpu -o n.npy"), &["which is read"]);
    }
    // What the shell appends to is not what is read either.
    let append = format!("{} render n.npy --backend cpu -o - >> n.npy", env!("CARGO_BIN_EXE_halfline"));
    let before = desk.get("n.npy");
    let status = std::process::Command::new("sh").args(["-c", &append]).current_dir(desk.path("")).status();
    assert_eq!(status.expect("sh runs").code(), Some(2));
    assert!(desk.get("n.npy") == before);
}

#[test]
fn no_two_outputs_are_one_file() {
    let desk = desk();
    let twice = "would be written twice";
    desk.refused(2, "s.toml --aov depth=d.npy --aov id=./d.npy", &[twice]);
    refused(&desk, "render 7.xyz --frames 7 --backend cpu --aov depth=d7.npy --aov id=d%d.npy", &["d7.npy"]);
    refused(&desk, "render q.csv --color-by q --legend a.png -o ./a.png --backend cpu", &[twice]);
    let meet = "would both write";
    refused(
        &desk,
        "render 7.xyz --frames 1-12 --backend cpu --aov depth=z%d.npy --aov id=z1%d.npy",
        &[meet, "z11.npy"],
    );
    refused(
        &desk,
        "render 7.xyz --spin 1000 --backend cpu --aov depth=z%d.npy --aov id=z%04d.npy",
        &[meet, "z1000.npy"],
    );
    refused(&desk, "render q.csv --color-by q --range 0,1 --spin 8 --legend l8.png -o l%d.png --backend cpu", &[meet]);
    let before = desk.files().len();
    desk.render("7.xyz --frames 1-10 --size 4x4 --aov depth=z%d.npy --aov id=z1%d.npy");
    assert_eq!(desk.files().len(), before + 20, "to ten there is no clash");
    assert_eq!(desk.array("z110.npy").1, [4, 4]);
    desk.render("7.xyz --size 4x4 --aov depth=e.exr --aov id=./e.exr");
}
