//! The promise of `halfline info`: it shows what a file has, as text and as one JSON object. Truth is what the files here
//! contain.

use crate::test_dir::{SPHERE, TestDir};
use serde_json::json;

/// A chain of two residues, an ion and a water; the second chain begins at the ion.
const PDB: &str = "\
CRYST1   20.000   30.000   40.000  90.00  90.00 120.00
ATOM      1  N   ALA A   1       0.000   0.000   0.000  1.00 10.00           N
ATOM      2  CA  ALA A   1       1.500   0.000  -2.000  0.50 20.00           C
ATOM      3  C   GLY A   2       3.000   4.000   0.000  1.00 30.00           C
HETATM    4 ZN    ZN B   3      12.000   0.000   5.000  1.00 40.50          ZN
HETATM    5  O   HOH B   4      16.000   0.000   0.000  1.00                 O
";

/// Two waters of three sites and one virtual site each, in nanometres, with velocities.
const GRO: &str = "\
two waters, t= 2.5 step= 5
8
    1SOL     OW    1   0.000   0.100   0.200  0.1000  0.0000 -0.5000
    1SOL    HW1    2   0.100   0.100   0.200  0.2000  0.0000 -0.5000
    1SOL    HW2    3   0.000   0.200   0.200  0.3000  0.0000 -0.5000
    1SOL     MW    4   9.000   9.000   9.000  9.0000  9.0000  9.0000
    2SOL     OW    5   1.000   0.100   0.200  0.4000  0.0000 -0.5000
    2SOL    HW1    6   1.100   0.100   0.200  0.5000  0.0000 -0.5000
    2SOL    HW2    7   1.000   0.200   0.200  0.6000  0.0000  0.2500
    2SOL     MW    8   9.000   9.000   9.000  9.0000  9.0000  9.0000
   2.00000   3.00000   4.00000
";

const TABLE: &str = "x,y,z,radius,kind,t\n0,0,0,0.5,rock,1\n1,2,3,1.5,ice,inf\n2,0,0,0.5,rock,\n4,0,0,0.5,rock,2.5\n";

/// A frame of a dump, in fractions of a cell of 2 x 4 x 8.
fn frame(step: u32, atoms: &str) -> String {
    let count = atoms.lines().count();
    format!(
        "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS pp pp pp\n-1 1\n0 4\n0 8\n\
         ITEM: ATOMS id type xs ys zs\n{atoms}"
    )
}

fn dir() -> TestDir {
    let dump = frame(0, "1 1 0.5 0.5 0.5\n2 3 0 0.25 1\n") + &frame(10, "1 1 0 0 0\n") + &frame(20, "1 1 0 0 0\n");
    TestDir::new(&[
        ("a.pdb", PDB),
        ("a.gro", GRO),
        ("a.csv", TABLE),
        ("a.dump", &dump),
        ("a.toml", SPHERE),
        ("b.xyz", "0\nnothing\n"),
        ("empty.pdb", ""),
        ("letter.txt", "Dear reader,\nthis is no scene.\n"),
    ])
}

/// The lines of the text, as words with one blank between them.
fn lines(dir: &TestDir, file: &str) -> Vec<String> {
    let text = dir.good(&["info", file]).text();
    text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect()
}

#[test]
fn a_protein_has_its_cell_elements_chains_and_columns() {
    let dir = dir();
    let info = dir.good("info a.pdb --json").json();
    assert_eq!(
        (&info["schema"], &info["version"], &info["format"]),
        (&json!("halfline-info"), &json!(1), &json!("pdb"))
    );
    assert_eq!((&info["frames"], &info["spheres"], &info["camera"]), (&json!(1), &json!(5), &json!(false)));
    assert_eq!(info["elements"], json!({"C": 2, "N": 1, "O": 1, "Zn": 1}));
    assert_eq!(info["chains"], json!(["A", "B"]));
    assert_eq!(info["extent"], json!({"min": [0.0, 0.0, -2.0], "max": [16.0, 4.0, 5.0]}));
    assert_eq!((&info["cell"]["lengths"][0], &info["cell"]["lengths"][2]), (&json!(20.0), &json!(40.0)));
    // An angle from the cosine of 120 degrees, in f64.
    let gamma = info["cell"]["angles"][2].as_f64().expect("an angle");
    assert!((gamma - 120.0).abs() < 1e-12, "{gamma}");
    let bfactor = json!({"type": "number", "min": 10.0, "max": 40.5, "values": [], "distinct": null, "missing": 1, "infinite": 0});
    assert_eq!(info["columns"]["bfactor"], bfactor);
    let resname = &info["columns"]["resname"];
    assert_eq!(
        (&resname["type"], &resname["values"], &resname["min"]),
        (&json!("text"), &json!(["ALA", "GLY", "ZN", "HOH"]), &json!(null))
    );
    assert_eq!(
        (&info["radii"]["source"], &info["colored"], &info["warnings"]),
        (&json!("element"), &json!(false), &json!([]))
    );
    let lines = lines(&dir, "a.pdb");
    for expected in [
        "format pdb, 1 frame",
        "spheres 5",
        "extent x 0 to 16.0000, y 0 to 4.00000, z -2.00000 to 5.00000",
        "cell edges 20.0000, 30.0000, 40.0000, angles 90.0000, 90.0000, 120.000",
        "colours of the elements",
        "elements C 2, N 1, O 1, Zn 1",
        "chains 2: A, B",
        "bfactor 10 to 40.5000; 1 without a value",
        "resname ALA, GLY, ZN, HOH",
    ] {
        assert!(lines.iter().any(|line| line == expected), "{expected}: {lines:#?}");
    }
}

#[test]
fn gromacs_is_in_angstrom_and_without_virtual_sites() {
    let dir = dir();
    let info = dir.good("info a.gro --json").json();
    assert_eq!((&info["spheres"], &info["elements"]), (&json!(6), &json!({"H": 4, "O": 2})));
    assert_eq!(info["extent"], json!({"min": [0.0, 1.0, 2.0], "max": [11.0, 2.0, 2.0]}));
    assert_eq!(info["cell"]["lengths"], json!([20.0, 30.0, 40.0]));
    let ends = |column: &str| (info["columns"][column]["min"].clone(), info["columns"][column]["max"].clone());
    assert_eq!((ends("vx"), ends("vz")), ((json!(0.1), json!(0.6)), (json!(-0.5), json!(0.25))));
    assert_eq!(info["columns"]["name"]["values"], json!(["OW", "HW1", "HW2"]));
    let warnings = info["warnings"].to_string();
    assert!(warnings.contains("2 virtual sites left out (2 `MW`)"), "{warnings}");
    assert!(warnings.contains("no element for 6 of 8 atoms"), "{warnings}");
}

#[test]
fn a_table_has_texts_infinities_and_radii() {
    let dir = dir();
    let info = dir.good("info a.csv --json").json();
    assert_eq!(
        (&info["radii"]["source"], &info["radii"]["min"], &info["radii"]["max"]),
        (&json!("file"), &json!(0.5), &json!(1.5))
    );
    let kind = json!({"type": "text", "min": null, "max": null, "values": ["rock", "ice"], "distinct": 2, "missing": 0, "infinite": 0});
    assert_eq!(info["columns"]["kind"], kind);
    let t =
        json!({"type": "number", "min": 1.0, "max": 2.5, "values": [], "distinct": null, "missing": 1, "infinite": 1});
    assert_eq!(info["columns"]["t"], t);
    let lines = lines(&dir, "a.csv");
    for expected in
        ["radii of the file, 0.5000 to 1.500", "colours grey", "t 1 to 2.50000; 1 infinite; 1 without a value"]
    {
        assert!(lines.iter().any(|line| line == expected), "{expected}: {lines:#?}");
    }
    assert!(lines.iter().any(|line| line.ends_with("kind rock, ice")), "{lines:#?}");
}

#[test]
fn frames_are_counted_and_the_numbers_are_those_of_the_first() {
    let dir = dir();
    let info = dir.good("info a.dump --json").json();
    assert_eq!((&info["frames"], &info["spheres"]), (&json!(3), &json!(2)));
    assert_eq!(info["extent"], json!({"min": [-1.0, 1.0, 4.0], "max": [0.0, 2.0, 8.0]}), "placed in the cell");
    assert_eq!(
        (&info["cell"]["origin"], &info["cell"]["lengths"]),
        (&json!([-1.0, 0.0, 0.0]), &json!([2.0, 4.0, 8.0]))
    );
    assert_eq!(info["columns"]["type"]["values"], json!(["1", "3"]));
    let lines = lines(&dir, "a.dump");
    assert_eq!(lines[..2], ["format dump, 3 frames", "spheres 2 in the first frame"]);
    let fed = dir.run_fed("info - --json", &dir.get("a.dump"));
    assert_eq!((fed.code, fed.json()), (0, info));
}

#[test]
fn a_scene_has_its_camera_and_no_spheres_are_reported() {
    let dir = dir();
    let info = dir.good("info a.toml --json").json();
    assert_eq!((&info["format"], &info["camera"], &info["spheres"]), (&json!("toml"), &json!(true), &json!(1)));
    assert_eq!(info["extent"], json!({"min": [0.0, 0.0, -3.0], "max": [0.0, 0.0, -3.0]}));
    assert_eq!(lines(&dir, "a.toml")[0], "format toml, 1 frame, with a camera");
    let nothing = lines(&dir, "b.xyz");
    assert_eq!(
        (&nothing[1][..], &nothing[nothing.len() - 1][..]),
        ("spheres 0", "warning there is no sphere to render")
    );
}

#[test]
fn files_that_cannot_be_read_are_refused() {
    let dir = dir();
    dir.refused(3, "info letter.txt", &["letter.txt", "the format cannot be detected", "--format"]);
    dir.refused(3, "info empty.pdb", &["empty.pdb", "the file is empty"]);
    dir.refused(8, "info missing.pdb", &["missing.pdb"]);
    dir.refused(2, "info a.pdb --columns x=1", &["--columns", "the file is pdb"]);
}

#[test]
fn a_chain_without_a_name_is_called_blank() {
    let dir = TestDir::new(&[("a.pdb", &PDB.replace(" A   ", "     "))]);
    let text = dir.good("info a.pdb").text();
    assert!(text.lines().any(|line| line.split_whitespace().eq("chains 2: (blank), B".split_whitespace())), "{text}");
    assert_eq!(dir.good("info a.pdb --json").json()["chains"], json!(["", "B"]));
}

#[test]
fn a_file_without_atoms_is_reported() {
    let dir = TestDir::new(&[("a.pdb", "HEADER    VIRUS\nTITLE     WITHOUT ATOMS\n"), ("b.pqr", "REMARK\nEND\n")]);
    for name in ["a.pdb", "b.pqr"] {
        for options in ["", "--frames 2"] {
            dir.refused_render(
                3,
                &format!("{name} {options} -o a%d.png"),
                &[name, "no atoms or particles", "coordinates"],
            );
        }
    }
}
