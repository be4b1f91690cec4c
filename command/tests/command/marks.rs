//! The promise of `--mark`: a text at what is seen of a selection, in pictures alone.

use crate::test_dir::TestDir;
use serde_json::json;

/// Two residues, the second behind a large atom of the first, and a table of named rows.
fn dir() -> TestDir {
    let atom = |n: u32, name: &str, residue: &str, id: u32, [x, y, z]: [f64; 3]| {
        format!("HETATM{n:5} {name:<4} {residue} A{id:4}    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00           {name:>2}\n")
    };
    let pdb = [
        atom(1, "C", "LIG", 7, [0.0, 0.0, 0.0]),
        atom(2, "O", "LIG", 7, [1.4, 0.0, 0.0]),
        atom(3, "N", "HID", 8, [0.0, 0.0, -4.0]),
        atom(4, "S", "FAR", 9, [-9.0, 3.0, 0.0]),
    ];
    let table = "name,x,y,z,radius,mass\nIo,0,0,0,1,0.0149\nEuropa,5,2,0,1,0.008\nRest,-4,-3,0,1,2\n";
    TestDir::new(&[("m.pdb", &pdb.concat()), ("moons.csv", table)])
}

const CAMERA: &str = "--eye 0,0,30 --at 0,0,0 --ortho 24 --size 160x120 --backend cpu --background white";

/// The pixels of a picture by a command whose words have ~ in place of spaces, and what was said.
fn picture(dir: &TestDir, options: &str) -> (Vec<f64>, String) {
    let words = format!("render {options} {CAMERA} -o a.png");
    let ran = dir.run(&words.split_whitespace().map(|word| word.replace('~', " ")).collect::<Vec<_>>());
    assert_eq!(ran.code, 0, "{}", ran.err);
    (dir.array("a.png").0, ran.err)
}

/// The columns and rows around the pixels that differ; `None` where none does.
fn changed(a: &[f64], b: &[f64]) -> Option<[usize; 4]> {
    let differ = (0..160 * 120).filter(|pixel| a[3 * pixel..][..3] != b[3 * pixel..][..3]);
    let places: Vec<[usize; 2]> = differ.map(|pixel| [pixel % 160, pixel / 160]).collect();
    let ends = |k: usize| Some([places.iter().map(|at| at[k]).min()?, places.iter().map(|at| at[k]).max()?]);
    Some([ends(0)?[0], ends(1)?[0], ends(0)?[1], ends(1)?[1]])
}

#[test]
fn texts_stand_at_visible_things() {
    let dir = dir();
    let (plain, _) = picture(&dir, "m.pdb");
    let marked = |options: &str| changed(&plain, &picture(&dir, &format!("m.pdb {options}")).0);
    // The sulfur is 9 units left and 3 up of the middle, 5 pixels a unit.
    let [x0, y0, x1, y1] = marked("--mark resname~FAR={resname}~{resid}").expect("a mark");
    assert!((35..=52).contains(&x0) && x1 < 100 && y0 >= 37 && y1 <= 53, "{x0} {y0} {x1} {y1}");
    assert!((42..=48).contains(&(y0.midpoint(y1))), "{y0} {y1}: the row of its middle");
    assert_eq!(marked("--mark resname~HID=x"), None, "hidden");
    assert!(marked("--mark resname~HID=x --mark-all").is_some());
    // What is hidden is said where it is not the most.
    let warned = |options: &str| picture(&dir, &format!("m.pdb {options}")).1;
    let words = warned("--mark all={resname}");
    assert!(words.contains("1 of 3 marks name what no pixel shows (HID)") && words.contains("--mark-all"), "{words}");
    assert!(!warned("--mark all={resname} --mark-all").contains("no pixel shows"));
    assert_eq!(marked("--mark resname~ALA=x"), None, "nothing is selected");
    let (ghost, _) = picture(&dir, "m.pdb --opacity resname~LIG=0.5");
    let through = picture(&dir, "m.pdb --opacity resname~LIG=0.5 --mark resname~HID=x").0;
    assert!(changed(&ghost, &through).is_some(), "seen through a translucent residue");
    // One text for a residue, and one for each particle of a table.
    let (one, two) = (marked("--mark resname~LIG=w").expect("a mark"), marked("--mark name~C=w").expect("a mark"));
    assert!(one[2] - one[0] <= 12 && two[2] - two[0] <= 12, "{one:?} {two:?}");
    let (moons, _) = picture(&dir, "moons.csv");
    let names = changed(&moons, &picture(&dir, "moons.csv --mark all={name}").0).expect("marks");
    assert!(names[2] - names[0] > 50, "{names:?}: from the leftmost moon to the rightmost");
    let once = changed(&moons, &picture(&dir, "moons.csv --mark-one all=moons").0).expect("one mark");
    assert!(once[2] - once[0] < 40 && once[3] - once[1] < 20, "{once:?}: one text for all");
    let mass = changed(&moons, &picture(&dir, "moons.csv --mark name~Io={name}~of~{mass}").0).expect("a mark");
    assert!(mass[2] - mass[0] > 60, "{mass:?}: Io of 0.0149");
}

#[test]
fn marks_that_find_no_place_are_counted_and_never_cover_another() {
    let dir = dir();
    let crowd: String =
        (0..90).map(|n| format!("{},{},0,0.2\n", f64::from(n % 10) * 0.2, f64::from(n / 10) * 0.2)).collect();
    dir.put("crowd.csv", format!("x,y,z,radius\n{crowd}"));
    let (_, err) = picture(&dir, "crowd.csv --mark all=moon");
    assert!(err.contains("of 90 marks have no place in the picture beside the others (moon, moon"), "{err}");
    dir.put("many.csv", format!("x,y,z,radius\n{}", "0,0,0,1\n".repeat(501)));
    dir.refused_render(
        2,
        &format!("many.csv {CAMERA} --mark all=x -o b.png").replace("--backend cpu", ""),
        &["--mark", "501", "500"],
    );
}

/// A picture with other marks is not kept.
#[test]
fn marks_are_in_the_provenance() {
    let dir = dir();
    let resumed = |mark: &str| {
        let words = format!("render moons.csv {CAMERA} -o r.png --resume --json --mark {mark}");
        let words: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
        dir.run(&words).json()["resumed"].clone()
    };
    let kept = |mark: &str| resumed(mark) == json!(true);
    assert!(!kept("all={name}") && kept("all={name}"), "the same marks");
    assert!(!kept("all={mass}") && !kept("index<2={mass}") && kept("index<2={mass}"), "others");
}

#[test]
fn invalid_marks_are_refused() {
    let dir = dir();
    for (options, words) in [
        ("moons.csv --mark name -o b.png", &["--mark <EXPR=TEXT>", "a mark has no text"][..]),
        ("moons.csv --mark all= -o b.png", &["--mark", "empty"]),
        ("moons.csv --mark all={name -o b.png", &["--mark", "brace"]),
        ("moons.csv --mark all={colour} -o b.png", &["--mark", "`colour`", "mass"]),
        ("moons.csv --mark colour<1=x -o b.png", &["colour"]),
        ("moons.csv --mark-all -o b.png", &["--mark"]),
        ("moons.csv --mark all=x -o b.npy", &["--mark", ".png"]),
        ("moons.csv --mark all=x -o b.png --crop 0,0,9,9", &["--mark", "--crop"]),
        ("moons.csv --mark all=x -o b.png --stream", &["--mark", "--stream"]),
    ] {
        dir.refused_render(2, options, words);
    }
}
