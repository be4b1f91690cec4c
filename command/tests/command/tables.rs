//! The promise of tables: columns are found by the names that other programs give them, or by those that `--columns`
//! gives, and a table without names is read only with a warning.

use crate::test_dir::{SPHERE, TestDir};
use serde_json::json;

/// Three points with radii; the coordinates are exact in f32.
const PLAIN: &str = "radius,x,y,z\n0.5,1,2,3\n0.25,-1,2.5,3\n1,1,4,-3\n";

/// The same from ParaView's writer of CSV, and from its spreadsheet.
const PARAVIEW: &str = "\"radius\",\"Points:0\",\"Points:1\",\"Points:2\"\n0.5,1,2,3\n0.25,-1,2.5,3\n1,1,4,-3\n";
const SPREADSHEET: &str = "Point ID,radius,Points_0,Points_1,Points_2,Points_Magnitude\n\
    0,0.5,1,2,3,3.74166\n1,0.25,-1,2.5,3,4.03113\n2,1,1,4,-3,5.09902\n";

fn dir() -> TestDir {
    TestDir::new(&[("plain.csv", PLAIN), ("paraview.csv", PARAVIEW), ("spreadsheet.dat", SPREADSHEET)])
}

/// The ids and the distances of a small picture of a file.
fn picture(dir: &TestDir, file: &str, options: &[&str]) -> [Vec<f64>; 2] {
    let buffers = ["--size", "24x24", "--aov", "id=id.npy", "--aov", "distance=d.npy"];
    dir.render(&[&[file], options, &buffers[..]].concat());
    ["id.npy", "d.npy"].map(|name| dir.array(name).0)
}

#[test]
fn points_of_paraview_are_coordinates() {
    let dir = dir();
    for file in ["paraview.csv", "spreadsheet.dat"] {
        let info = dir.good(&["info", file, "--json"]).json();
        assert_eq!((&info["format"], &info["spheres"]), (&json!("csv"), &json!(3)), "{file}");
        assert_eq!(info["extent"], json!({"min": [-1.0, 2.0, -3.0], "max": [1.0, 4.0, 3.0]}), "{file}");
        let plain = picture(&dir, "plain.csv", &[]);
        assert!(plain[0].contains(&0.0) && plain[0].contains(&-1.0));
        assert_eq!(picture(&dir, file, &[]), plain, "{file}");
    }
}

#[test]
fn columns_are_named_by_an_option() {
    let dir = dir();
    let rows = "0.5,1,2,3\n0.25,-1,2.5,3\n1,1,4,-3\n";
    dir.put("named.dat", format!("size,pos_x,pos_y,pos_z\n{rows}"));
    dir.put("bare.dat", rows);
    dir.put("bare.csv", "1 2 3 0.5\n-1 2.5 3 0.25\n1 4 -3 1\n");
    let plain = picture(&dir, "plain.csv", &[]);
    for (file, columns) in [
        ("named.dat", "x=pos_x,y=pos_y,z=pos_z,radius=size"),
        ("named.dat", "x=2,y=3,z=4,radius=1"),
        ("bare.dat", "x=2,y=3,z=4,radius=1"),
        ("bare.csv", "x=1,y=2,z=3,radius=4"),
    ] {
        assert_eq!(picture(&dir, file, &["--columns", columns]), plain, "{file} {columns}");
        let info = dir.good(&["info", file, "--columns", columns, "--json"]).json();
        assert_eq!((&info["spheres"], &info["warnings"]), (&json!(3), &json!([])), "{file} {columns}");
    }
    // A .csv file without names has assumed ones, and so has one of a stated format.
    let stderr = dir.render("bare.csv -o a.png").err;
    assert!(
        stderr.contains("bare.csv:1:1: the table has no header, so its columns are read as x, y, z and radius"),
        "{stderr}"
    );
    assert_eq!(picture(&dir, "bare.csv", &[]), plain);
    dir.put("bare.txt", dir.get("bare.csv"));
    assert_eq!(picture(&dir, "bare.txt", &["--format", "csv"]), plain);
    for (arguments, code, words) in [
        ("bare.txt -o b.png", 3, &["cannot be detected", "name the columns of a table with --columns x=1,y=2,z=3"][..]),
        (
            "named.dat --columns x=a,y=b,z=c -o b.png",
            3,
            &["named.dat:1:1: header", "no column `a`", "size, pos_x, pos_y, pos_z"],
        ),
        ("plain.csv --columns x=9 -o b.png", 3, &["column 9 is named, but the table has 4"]),
        ("plain.csv --columns w=1 -o b.png", 2, &["`w` is not a meaning of a column"]),
        ("a.xyz --columns x=1,y=2,z=3 -o b.png", 2, &["--columns names the columns of tables, but the file is xyz"]),
        ("s.toml --columns x=1,y=2,z=3 -o b.png", 2, &["but the file is toml"]),
    ] {
        dir.put("a.xyz", "1\n\nO 1 2 3\n");
        dir.put("s.toml", SPHERE);
        dir.refused_render(code, arguments, words);
    }
}

#[test]
fn invalid_rows_are_left_out_on_request() {
    let dir = dir();
    let atoms = "O 1 2 3 0.5\nO -1 2.5 3 0.25\nO 1 4 -3 1\n";
    let broken = "O 1 2 3 0.5\nO nan 0 0 1\nO -1 2.5 3 0.25\nO 0 0 0 -1\nO 1 4 -3 1\n";
    let xyz = |n: usize, atoms: &str| format!("{n}\nProperties=species:S:1:pos:R:3:radius:R:1\n{atoms}");
    let box_of = "ITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS element x y z radius\n";
    let dump = |n: usize, atoms: &str| format!("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{n}\n{box_of}{atoms}");
    let properties: String = ["x", "y", "z", "radius"].map(|name| format!("property double {name}\n")).concat();
    let ply = |n: usize, atoms: &str| {
        format!("ply\nformat ascii 1.0\nelement vertex {n}\n{properties}end_header\n{}", atoms.replace("O ", ""))
    };
    for (file, line) in [("a.xyz", 4), ("a.dump", 11), ("a.ply", 10), ("a.csv", 3)] {
        let text = |n: usize, atoms: &str| match file {
            "a.xyz" => xyz(n, atoms),
            "a.dump" => dump(n, atoms),
            "a.ply" => ply(n, atoms),
            _ => format!("element x y z radius\n{atoms}"),
        };
        dir.put(file, text(3, atoms));
        let whole = picture(&dir, file, &[]);
        dir.put(file, text(5, broken));
        let found = picture(&dir, file, &["--skip-invalid"]);
        assert!(found == whole && whole[0].contains(&0.0), "{file}");
        let warning = format!("2 rows left out, the first in line {line}: x: `nan` is not finite");
        let output = dir.render(&format!("{file} --skip-invalid -o a.png"));
        assert!(output.err.contains(&warning), "{file}: {}", output.err);
        let info = dir.good(&["info", file, "--skip-invalid", "--json"]).json();
        assert_eq!((&info["spheres"], &info["warnings"][0]), (&json!(3), &json!(warning)), "{file}");
        let place = format!("{file}:{line}:");
        dir.refused_render(3, &format!("{file} -o b.png"), &[&place, "x: `nan` is not finite"]);
    }
}

/// Atoms of two molecules in a cell of 8 by 8 by 8 from the origin, cut by its faces.
const CUT: &str = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n4\nITEM: BOX BOUNDS pp pp pp\n0 8\n0 8\n0 8\n";

#[test]
fn particles_are_moved_by_edges_of_the_cell() {
    let dir = dir();
    let dump = |columns: &str, atoms: &str| format!("{CUT}ITEM: ATOMS {columns} radius x y z\n{atoms}");
    let whole = dump("mol", "1 1 7 4 4\n1 1 9 4 4\n2 1 4 -1 4\n2 1 4 1 4\n");
    let wrapped = dump("mol", "1 1 7 4 4\n1 1 1 4 4\n2 1 4 7 4\n2 1 4 1 4\n");
    // The first atom of the second molecule is at 7, so the whole molecule is there.
    let above = dump("mol", "1 1 7 4 4\n1 1 9 4 4\n2 1 4 7 4\n2 1 4 9 4\n");
    let flagged = dump("ix iy iz", "0 0 0 1 7 4 4\n1 0 0 1 1 4 4\n0 -1 0 1 4 7 4\n0 0 0 1 4 1 4\n");
    for (file, text) in [("whole", &whole), ("wrapped", &wrapped), ("above", &above), ("flagged", &flagged)] {
        dir.put(file, text);
    }
    let camera = ["--ortho", "14", "--eye", "4,4,40", "--view", "0,0,-1"];
    let view = |file: &str, options: &[&str]| picture(&dir, file, &[&camera, options].concat());
    let [as_whole, as_wrapped, as_above] = ["whole", "wrapped", "above"].map(|file| view(file, &[]));
    assert!(as_whole != as_wrapped && as_whole != as_above && as_above != as_wrapped);
    for (file, options, expected) in [
        ("whole", &["--wrap"][..], &as_wrapped),
        ("wrapped", &["--wrap"], &as_wrapped),
        ("wrapped", &["--unwrap"], &as_above),
        ("flagged", &["--unwrap"], &as_whole),
        ("flagged", &["--wrap"], &as_wrapped),
    ] {
        assert_eq!(&view(file, options), expected, "{file} {options:?}");
    }
    // Selections see the moved particles.
    let near = ["--select", "within 2 of (x > 6)"];
    assert_eq!(view("wrapped", &near)[0].iter().copied().fold(-1.0, f64::max), 0.0);
    assert_eq!(view("wrapped", &[&["--unwrap"], &near[..]].concat())[0].iter().copied().fold(-1.0, f64::max), 1.0);
    dir.put("s.toml", SPHERE);
    for (arguments, words) in [
        ("plain.csv --wrap -o b.png", "--wrap needs a periodic cell, but the file has none; use a file with a cell"),
        ("plain.csv --unwrap -o b.png", "--unwrap needs a periodic cell"),
        ("s.toml --wrap -o b.png", "--wrap needs a periodic cell"),
        ("whole --wrap --unwrap -o b.png", "cannot be used with"),
    ] {
        dir.refused_render(2, arguments, &[words]);
    }
    dir.put("alone", dump("id", "1 1 7 4 4\n2 1 1 4 4\n3 1 4 7 4\n4 1 4 1 4\n"));
    dir.refused_render(
        2,
        "alone --unwrap -o b.png",
        &["--unwrap needs image flags (ix, iy, iz, or an image of extended XYZ), molecules (mol), residues or elements"],
    );
}
