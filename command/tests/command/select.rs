//! The promise of selections: they take, leave out, colour and resize the particles that they name, and a selection of
//! nothing is never silent. `tests/independent/selections.py` compares the selected atoms with MDAnalysis.

use crate::test_dir::{Output, TestDir};
use halfline::frame::color_map::ColorMap;

/// A protein of two residues, a ligand and a water.
const PDB: &str = "\
ATOM      1  N   ALA A   1       0.000   0.000   0.000  1.00 10.00           N
ATOM      2  CA  ALA A   1       4.000   0.000   0.000  1.00 20.00           C
ATOM      3  CA  GLY B   2       8.000   0.000   0.000  1.00 30.00           C
HETATM    4 FE   HEM B   3      12.000   0.000   0.000  1.00 40.00          FE
HETATM    5  O   HOH B   4      16.000   0.000   0.000  1.00 50.00           O
";

/// Two types and a column of names.
const TABLE: &str = "x,y,z,type,mass,kind\n0,0,0,1,0.5,rock\n4,0,0,2,1.5,ice\n8,0,0,2,nan,iron rich\n";

const SCENE: &str =
    "[camera]\neye = [8, 0, 60]\nview = [0, 0, -1]\nup = [0, 1, 0]\nheight = 8\n[image]\nsize = [60, 24]\n";

fn dir() -> TestDir {
    TestDir::new(&[("a.pdb", PDB), ("t.csv", TABLE), ("s.csv", "x,y,z,radius\n0,0,0,1\n4,0,0,1\n8,0,0,2\n")])
}

/// The x coordinates of the spheres in view, by id, and the result of the command.
fn shown(dir: &TestDir, file: &str, options: &[&str]) -> (Vec<f64>, Output) {
    let buffers =
        ["--size", "120x24", "--aov", "id=id.npy", "--aov", "position=p.npy", "-o", "c.npy", "--shade", "flat"];
    let output = dir.render(&[&[file], options, &buffers[..]].concat());
    let ((ids, _), (positions, _)) = (dir.array("id.npy"), dir.array("p.npy"));
    let mut centers = Vec::new();
    for id in 0.. {
        let visible: Vec<f64> = ids
            .iter()
            .zip(positions.chunks(3))
            .filter(|(found, _)| **found == f64::from(id))
            .map(|(_, p)| p[0])
            .collect();
        if visible.is_empty() {
            break;
        }
        // The middle of what is seen of a sphere is within a quarter of the distance to the next one.
        let ends = visible.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(*x), b.max(*x)]);
        centers.push((((ends[0] + ends[1]) / 2.0) / 4.0).round() * 4.0);
    }
    (centers, output)
}

#[test]
fn select_takes_and_hide_leaves_out() {
    let dir = dir();
    for (options, expected) in [
        (&["--select", "protein"][..], &[0.0, 4.0, 8.0][..]),
        (&["--hide", "water"], &[0.0, 4.0, 8.0, 12.0]),
        (&["--select", "chain B", "--hide", "water"], &[8.0, 12.0]),
        (&["--hide", "water", "--select", "chain B"], &[8.0, 12.0]),
        (&["--select", "name N", "--select", "element Fe"], &[0.0, 12.0]),
        (&["--select", "bfactor >= 30 and not water"], &[8.0, 12.0]),
        (&["--select", "within 4 of (resname HEM)"], &[8.0, 12.0, 16.0]),
        (&["--select", "resid 2:3 and not chain A"], &[8.0, 12.0]),
        (&["--select", "index 1 3", "--color-by", "resname"], &[4.0, 12.0]),
    ] {
        assert_eq!(shown(&dir, "a.pdb", options).0, expected, "{options:?}");
    }
    for (options, expected) in [
        (&["--select", "type 2"][..], &[4.0, 8.0][..]),
        (&["--hide", "mass < 1"], &[4.0, 8.0]),
        (&["--select", "kind \"iron rich\" rock"], &[0.0, 8.0]),
        (&["--select", "x > 2 and x < 6"], &[4.0]),
    ] {
        assert_eq!(shown(&dir, "t.csv", &[options, &["--radius", "1"]].concat()).0, expected, "{options:?}");
    }
}

#[test]
fn colours_and_radii_of_selected_particles_win_in_their_order() {
    let dir = dir();
    let color = |file: &str, options: &[&str]| -> Vec<[f64; 3]> {
        shown(&dir, file, options);
        let ((ids, _), (pixels, _)) = (dir.array("id.npy"), dir.array("c.npy"));
        let of = |id: f64| {
            ids.iter().zip(pixels.chunks(3)).find(|(found, _)| **found == id).map(|(_, c)| [c[0], c[1], c[2]])
        };
        (0..5).map_while(|id| of(f64::from(id))).collect()
    };
    let plain = color("t.csv", &["--radius", "1"]);
    let painted = color("t.csv", &["--radius", "1", "--color", "type 2=1,0,0", "--color", "mass >= 1=0,0,1"]);
    assert_eq!(painted, [plain[0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
    let all = color("t.csv", &["--radius", "1", "--color", "0,1,0", "--color", "type 1=1,0,0"]);
    assert_eq!(all, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let by = color("t.csv", &["--radius", "1", "--color-by", "type", "--color", "x < 1=1,0,0"]);
    let second = ColorMap::Category.color(2.0).map(f64::from);
    assert_eq!(by, [[1.0, 0.0, 0.0], second, second]);
    // Carbon by chain, all else by element.
    let carbons = color("a.pdb", &["--color-by", "chain", "--color", "not element C=element"]);
    let elements = color("a.pdb", &[]);
    let chain = |n: f64| ColorMap::Category.color(n).map(f64::from);
    assert_eq!(carbons, [elements[0], chain(0.0), chain(1.0), elements[3], elements[4]]);
    assert_eq!(color("a.pdb", &["--color", "element"]), elements);
    // What is hidden is still a neighbour.
    let near = color("a.pdb", &["--color", "within 4.5 of (water)=1,0,0", "--hide", "water"]);
    assert_eq!((near.len(), near[3]), (4, [1.0, 0.0, 0.0]));
    let pixels = |options: &[&str]| {
        shown(&dir, "t.csv", &[options, &["--eye", "4,0,60", "--ortho=12"]].concat());
        let (ids, _) = dir.array("id.npy");
        [0.0, 1.0, 2.0].map(|id| ids.iter().filter(|found| **found == id).count())
    };
    let same = pixels(&["--radius", "1"]);
    let grown = pixels(&["--radius", "1", "--radius", "type 2=2", "--radius", "kind \"iron*\"=0.5"]);
    assert!(grown[0] == same[0] && grown[1] > 3 * same[1] && grown[2] < same[2], "{same:?} {grown:?}");
    assert_eq!(pixels(&["--radius", "0.5", "--radius", "x > 2=0.5", "--radius-scale", "2"]), same);
}

/// Jmol's colours (jmol.sourceforge.net/jscolors), by which the elements are known.
#[test]
fn colours_of_elements_have_their_rows_in_the_legend() {
    let dir = dir();
    let legend = |options: &[&str]| {
        dir.render(&[&["a.pdb", "-o", "a.png", "--legend", "l.svg", "--size", "60x24"], options].concat());
        String::from_utf8(dir.get("l.svg")).expect("a legend")
    };
    let svg = legend(&["--color-by", "chain", "--color", "not element C=element"]);
    for (label, color) in [(">element N<", "#3050f8"), (">element Fe<", "#e06633"), (">element O<", "#ff0d0d")] {
        assert!(svg.contains(label) && svg.contains(color), "{label} {color}: {svg}");
    }
    assert!(!svg.contains("element C"), "carbon has the colours of the chains: {svg}");
    let classes = legend(&["--color-by", "bfactor", "--map", "plddt", "--range", "0,40"]);
    for label in ["pLDDT", "very high: above 36", ">high: 28 to 36", "very low: 20 or less"] {
        assert!(classes.contains(label), "{label}: {classes}");
    }
    assert!(!classes.contains(">low"), "no value is between 20 and 28: {classes}");
    let of_table = ["t.csv", "--radius", "1", "--color", "type 2=element", "-o", "t.png"];
    dir.refused_render(2, &of_table, &["type 2", "the file has none"]);
}

#[test]
fn a_scene_file_selects_spheres_of_its_files() {
    let dir = dir();
    let scene = |name: &str, tables: &str| dir.put(name, format!("{SCENE}{tables}"));
    scene("csv.toml", "[[spheres]]\nfile = \"s.csv\"\nselect = \"radius < 1.5 and x > 1\"\n");
    assert_eq!(shown(&dir, "csv.toml", &["--fit"]).0, [4.0]);
    scene(
        "pdb.toml",
        "[[spheres]]\nfile = \"a.pdb\"\nselect = \"protein\"\n[[spheres]]\nfile = \"s.csv\"\nselect = \"index 1\"\n",
    );
    assert_eq!(shown(&dir, "pdb.toml", &["--fit"]).0[..3], [0.0, 4.0, 8.0]);
    scene("none.toml", "[[spheres]]\nfile = \"s.csv\"\nselect = \"x > 100\"\n");
    let err = dir.render("none.toml --json").err;
    assert!(err.contains("the selection `x > 100` leaves none of 3 spheres"), "{err}");
    for (tables, place) in [
        (
            "[[spheres]]\nfile = \"s.csv\"\nselect = \"x >\"\n",
            "bad.toml:10:10: spheres 0 select: `x >` is not a selection",
        ),
        ("[[spheres]]\nfile = \"s.csv\"\nselect = \"chain A\"\n", "bad.toml:10:10: spheres 0 select"),
        ("[[spheres]]\nfile = \"s.csv\"\nselect = 5\n", "bad.toml:10:10: spheres 0 select: expected a string"),
        ("[[spheres]]\nfile = \"s.txt\"\n", "`s.txt` is not a supported file of spheres"),
    ] {
        scene("bad.toml", tables);
        dir.refused_render(3, "bad.toml -o a.png", &[place]);
    }
}

#[test]
fn a_selection_of_nothing_is_reported_and_an_invalid_one_refused() {
    let dir = dir();
    let err = |options: &[&str]| dir.render(&[&["a.pdb", "--json"], options].concat()[..]).err;
    let nothing = err(&["--select", "resname LIG"]);
    assert!(
        nothing.contains("the file has ALA, GLY, HEM, HOH") && nothing.contains("leave none of the 5"),
        "{nothing}"
    );
    let mixed = err(&["--select", "name N or name CA and chain A"]);
    assert!(mixed.contains("VMD combines `and` first"), "{mixed}");
    assert!(!err(&["--select", "chain A"]).contains("selection"), "no remarks");
    for (options, words) in [
        (&["--select", "chain"][..], &["`chain` is not a selection", "at column 1"][..]),
        (
            &["--select", "type 2"],
            &["the file has no type", "the file has index, x, y, z, element, name, resname, residue, chain"],
        ),
        (&["--color", "chain A=redd"], &["redd"]),
        (&["--color", "chain (=1,0,0"], &["`chain (` is not a selection"]),
        (&["--radius", "chain A=-1"], &["expected a positive number"]),
        (&["--color", "1,0,0", "--color-by", "chain"], &["--color", "--color-by"]),
    ] {
        dir.refused_render(2, &[&["a.pdb", "-o", "a.png"], options].concat()[..], words);
    }
    dir.put("plain.toml", format!("{SCENE}[[sphere]]\ncenter = [8, 0, 0]\nradius = 1\n"));
    dir.refused_render(
        2,
        &["plain.toml", "-o", "a.png", "--select", "x > 1"][..],
        &["no columns to select by", "[[spheres]]"],
    );
}

/// A line of a PDB file.
fn atom(record: &str, serial: usize, name: &str, residue: &str, number: u32, x: f64, symbol: &str) -> String {
    format!(
        "{record:6}{serial:5}  {name:<3} {residue:>3} A{number:4}    {x:8.3}   0.000   0.000  1.00  0.00          {symbol:>2}\n"
    )
}

/// Residues on a line: two amino acids around a modified one, that is linked to both by bonds of 1.3; benzene, glycerol, zinc,
/// acetate, a haem with its iron, a sugar and water, 9 apart.
#[test]
fn ligands_and_metals_have_their_rule() {
    let chain = [("ALA", "ATOM"), ("CRX", "HETATM"), ("GLY", "ATOM")];
    let six = ["C1", "C2", "C3", "C4", "C5", "C6"];
    let others: [(&str, &[&str], &str); 7] = [
        ("BNZ", &six, "C"),
        ("GOL", &six, "C"),
        ("ZN", &["ZN"], "ZN"),
        ("ACT", &["C1", "C2", "O1", "O2"], "C"),
        ("HEM", &["FE", "C1", "C2", "C3", "C4", "C5", "C6", "C7"], "C"),
        ("NAG", &six, "C"),
        ("HOH", &["O"], "O"),
    ];
    let (mut text, mut x, mut serial, mut number) = (String::new(), 0.0, 0, 0);
    for (residue, record) in chain {
        number += 1;
        for name in ["N", "CA", "CB", "CG", "CD", "CE", "C"] {
            serial += 1;
            text += &atom(record, serial, name, residue, number, x, &name[..1]);
            x += 1.3;
        }
    }
    for (residue, names, symbol) in others {
        (number, x) = (number + 1, x + 9.0);
        for name in names {
            serial += 1;
            let symbol = if name.len() == 2 && name.chars().all(char::is_alphabetic) { name } else { symbol };
            text += &atom("HETATM", serial, name, residue, number, x, symbol);
            x += 1.3;
        }
    }
    let dir = TestDir::new(&[("a.pdb", &text)]);
    let count = |expression: &str| {
        let report = dir.render(&["a.pdb", "--select", expression, "--json", "--size", "9x9"]).json();
        report["spheres"].as_u64().expect("a count")
    };
    assert_eq!((count("ligand"), count("ligand and resname BNZ HEM")), (14, 14));
    assert_eq!((count("metal"), count("metals and resname ZN HEM"), count("metal and ligand")), (2, 2, 1));
    // Away from the others, the modified residue is a ligand.
    dir.put(
        "b.pdb",
        text.lines().filter(|line| !line.starts_with("ATOM")).map(|line| format!("{line}\n")).collect::<String>(),
    );
    let report = dir.render(&["b.pdb", "--select", "ligands", "--json", "--size", "9x9"]).json();
    assert_eq!(report["spheres"].as_u64(), Some(21));
}
