//! The promise of columns and of encodings: a file has the same content whatever way it is read, as its field's programs read it.

use crate::numpy::npy_of;
use crate::rng::Rng;
use crate::test_dir::TestDir;
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

const CAMERA: [&str; 12] =
    ["--eye", "0,0,90", "--at", "0,0,0", "--vfov", "60", "--size", "16x16", "--look", "plain", "--samples", "1"];

/// The ids of the spheres of a picture.
fn ids(dir: &TestDir, file: &str, options: &[&str], input: Option<&[u8]>) -> Vec<f64> {
    let arguments = [&["render", file, "--backend", "cpu", "--aov", "id=id.npy"][..], &CAMERA, options].concat();
    let output = match input {
        Some(input) => dir.run_fed(&arguments[..], input),
        None => dir.run(&arguments[..]),
    };
    assert_eq!(output.code, 0, "{file} {options:?}: {}", output.err);
    dir.array("id.npy").0
}

/// A table and a dump of points on a grid, whose column `nm` has the texts; the first rows have none.
fn files(texts: &[String]) -> [(&'static str, String); 3] {
    let place = |n: usize| (n % 30) as f64 * 2.0 - 29.0;
    let mut table = "x,y,z,radius,nm\n".to_owned();
    let mut dump = format!(
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS\n-99 99\n-99 99\n-99 99\nITEM: ATOMS x y z radius nm\n",
        texts.len()
    );
    let mut xyz = format!("{}\nProperties=pos:R:3:radius:R:1:nm:R:1\n", texts.len());
    for (n, text) in texts.iter().enumerate() {
        let [x, y] = [place(n), place(n / 30)];
        writeln!(table, "{x},{y},0,1,{text}").expect("text");
        let text = if text.is_empty() { "nan" } else { text };
        writeln!(dump, "{x} {y} 0 1 {text}").expect("text");
        writeln!(xyz, "{x} {y} 0 1 {text}").expect("text");
    }
    [("a.csv", table), ("a.dump", dump), ("a.xyz", xyz)]
}

/// In memory, as a stream, from standard input, in large and in small blocks, and by what `info` says.
#[test]
fn a_text_in_any_row_makes_a_column_of_texts_in_every_way_of_reading() {
    let mut rng = Rng::new(5);
    for parts in [1, 4096] {
        for rows in [2, 800] {
            let dir = TestDir::new(&[]).in_parts(parts);
            let mut texts: Vec<String> = (0..rows).map(|n| ["", "1", "007", "1.50"][n % 4].to_owned()).collect();
            texts[0] = ["", "1", "NA"][rng.below(3)].to_owned();
            let late = rows - 1 - rng.below(rows / 2);
            texts[late] = "zz".to_owned();
            for (file, content) in files(&texts) {
                dir.put(file, &content);
                let info = dir.good(&["info", file, "--json"]).json();
                assert_eq!(info["columns"]["nm"]["type"], "text", "{file} {parts} {rows}");
                for (select, is) in [("nm zz", "zz"), ("nm 007 zz", "007"), ("nm zz 1.50", "1.50")] {
                    let options = ["--select", select];
                    let memory = ids(&dir, file, &options, None);
                    // Every selected sphere is highest, and no other.
                    let count = texts.iter().filter(|text| *text == is || *text == "zz").count();
                    let highest = memory.iter().copied().fold(-1.0, f64::max) as usize + 1;
                    assert!(highest <= count && highest > 0, "{file} {select}: {highest} of {count}");
                    assert_eq!(ids(&dir, "-", &options, Some(content.as_bytes())), memory, "{file} {select}");
                    let stream = [&options[..], &["--stream"]].concat();
                    assert_eq!(ids(&dir, file, &stream, None), memory, "{file} {select} {parts}");
                }
                // What can be read once is refused, with the way.
                let once = [&["render", "-", "-o", "b.png", "--stream", "--select", "nm zz"][..], &CAMERA].concat();
                let output = dir.run_fed(&once[..], content.as_bytes());
                let of_row = output.err.contains("remove --stream for a column of texts");
                assert!(of_row || output.err.contains("nm is a number in this file"), "{file}: {}", output.err);
                assert!([2, 3].contains(&output.code), "{file}: {}", output.err);
            }
        }
    }
}

/// The buffers of two files are equal.
fn same(dir: &TestDir, file: &str, other: &str, options: &[&str]) {
    assert_eq!(ids(dir, file, options, None), ids(dir, other, options, None), "{file} {other}");
}

#[test]
fn words_for_missing_numbers_are_none_as_an_empty_field() {
    let dir = TestDir::new(&[("a.csv", "x,y,z,radius,t\n0,0,0,1,\n3,0,0,1,2\n-3,0,0,1,5\n")]);
    let picture = |file: &str| {
        dir.render(&[&[file, "--color-by", "t", "-o", "a.png"], &CAMERA[..]].concat()[..]);
        dir.get("a.png")
    };
    let empty = picture("a.csv");
    for word in ["NA", "N/A", "nan", "NaN", "null", "NULL", "None", "-", "--", "#N/A", "<NA>", "?", "\\N"] {
        dir.put("b.csv", format!("x,y,z,radius,t\n0,0,0,1,{word}\n3,0,0,1,2\n-3,0,0,1,5\n"));
        assert!(picture("b.csv") == empty, "{word}");
        let column = &dir.good("info b.csv --json").json()["columns"]["t"];
        assert_eq!(
            (&column["type"], &column["missing"], &column["min"]),
            (&"number".into(), &1.into(), &2.0.into()),
            "{word}"
        );
    }
}

#[test]
fn delimiters_and_quotes_are_those_of_other_programs() {
    let rows = [("0,0,0", "5\" pipe"), ("4,0,0", "a, b; c|d"), ("-4,0,0", "two\nlines"), ("0,4,0", "\"")];
    let dir = TestDir::new(&[]);
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    for (delimiter, first) in
        [(",", ""), (";", ""), ("\t", ""), ("|", ""), (";", "sep=;\n"), ("^", "\"sep=^\"\r\n"), (",", "SEP=,\n")]
    {
        let mut table = format!("{first}{}\n", ["x", "y", "z", "\"The \"\"name\"\"\""].join(delimiter));
        for (place, name) in rows {
            writeln!(table, "{}{delimiter}{}", place.replace(',', delimiter), quoted(name)).expect("text");
        }
        for mark in ["", "\u{feff}"] {
            dir.put("a.csv", format!("{mark}{table}"));
            let info = dir.good("info a.csv --json").json();
            let column = &info["columns"]["The \"name\""];
            let mut values: Vec<&str> =
                column["values"].as_array().expect("values").iter().filter_map(|v| v.as_str()).collect();
            values.sort_unstable();
            let mut names = rows.map(|(_, name)| name);
            names.sort_unstable();
            assert_eq!(values, names, "{table}");
        }
    }
    // Rays and spheres of a scene have the same fields.
    let ray = "0,0,9,0,0,-1";
    dir.put(
        "s.toml",
        "[camera]\neye = [0, 0, 9]\nat = [0, 0, 0]\nup = [0, 1, 0]\nvfov = 40\n[[spheres]]\nfile = \"s.csv\"\n",
    );
    dir.put("s.csv", "\"x\",\"y\",\"z\",\"radius\"\n\"0\",\"0\",\"0\",\"1\"\n");
    for (delimiter, first) in [(",", ""), ("|", ""), (";", "sep=;\n"), ("^", "sep=^\n")] {
        let header = "\"ox\",oy,\"oz\",dx,dy,dz".replace(',', delimiter);
        dir.put("r.csv", format!("\u{feff}{first}{header}\n{}\n", ray.replace(',', delimiter)));
        dir.good("trace s.toml --rays r.csv -o hits.csv");
        assert!(String::from_utf8_lossy(&dir.get("hits.csv")).lines().nth(1).is_some_and(|hit| hit.starts_with('0')));
        let header = "eye_x,eye_y,eye_z,\"view_x\",view_y,view_z,up_x,up_y,up_z,vfov".replace(',', delimiter);
        dir.put("c.csv", format!("\u{feff}{first}{header}\n{}\n", "0,0,9,0,0,-1,0,1,0,40".replace(',', delimiter)));
        dir.render(&["s.toml", "--cameras", "c.csv", "-o", "c.png", "--size", "8x8"][..]);
    }
    // A line break within the quotes of a number is refused at its field.
    dir.put("s.csv", "x,y,z,radius\n0,0,\"0\n1\",1\n");
    dir.refused_render(3, "s.toml -o d.png", &["s.csv:2:5: z", "is not a number"]);
    dir.put("r.csv", "ox,oy,oz,dx,dy,dz\n0,0,\"0\n1\",0,0,-1\n");
    dir.refused(3, "trace a.csv --rays r.csv -o hits.csv", &["r.csv:2:5"]);
}

#[test]
fn marks_line_ends_and_encodings_of_texts() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
               property float radius\nelement face 1\nproperty list uchar int i\nend_header\n0 0 0 1\n4 0 0 1\n3 0 1 1\n";
    let dir = TestDir::new(&[("plain.ply", ply)]);
    let bytes: Vec<u8> = [0f32, 0.0, 0.0, 1.0, 4.0, 0.0, 0.0, 1.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let binary = |end: &str| {
        let header = ply.split_inclusive("end_header\n").next().unwrap_or_default();
        let header =
            header.replace("element face 1\nproperty list uchar int i\n", "").replace("ascii", "binary_little_endian");
        [header.replace('\n', end).as_bytes(), &bytes].concat()
    };
    for (name, content) in [
        ("crlf.ply", ply.replace('\n', "\r\n").into_bytes()),
        ("cr.ply", ply.replace('\n', "\r").into_bytes()),
        ("marked.ply", format!("\u{feff}{ply}").into_bytes()),
        (
            "blank.ply",
            ply.replace("end_header\n", "\nend_header\n\n").replace("0 0 0 1\n", "0 0 0 1\n \n\n").into_bytes(),
        ),
        ("lf-binary.ply", binary("\n")),
        ("crlf-binary.ply", binary("\r\n")),
        ("cr-binary.ply", binary("\r")),
    ] {
        dir.put(name, &content);
        // The content decides without the name, too.
        dir.put("unnamed", &content);
        same(&dir, name, "plain.ply", &[]);
        same(&dir, "unnamed", "plain.ply", &[]);
    }
    // A mark of byte order before each format of text, and UTF-16.
    let texts = [
        ("a.xyz", "1\n\nO 1 2 3\n"),
        ("a.csv", "x,y,z\n1,2,3\n"),
        ("a.pts", "1\n1 2 3 4 5 6 7\n"),
        ("a.pdb", "ATOM      1  CA  ALA A   1      11.104   6.134  -6.504  1.00  0.00           C\n"),
        (
            "a.toml",
            "[camera]\neye = [0, 0, 9]\nat = [0, 0, 0]\nup = [0, 1, 0]\nvfov = 40\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\n",
        ),
        ("a.nff", "v\nfrom 0 0 9\nat 0 0 0\nup 0 1 0\nangle 40\nhither 1\nresolution 8 8\ns 0 0 0 1\n"),
        (
            "a.pcd",
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n",
        ),
        ("a.gro", "t\n1\n    1SOL     OW    1   0.126   1.624   1.679\n   1.8   1.8   1.8\n"),
        (
            "a.cif",
            "data_a\nloop_\n_atom_site.id\n_atom_site.type_symbol\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n1 C 1 2 3\n",
        ),
        (
            "a.dump",
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS\n0 9\n0 9\n0 9\nITEM: ATOMS x y z\n1 2 3\n",
        ),
        ("a.poscar", "t\n1\n9 0 0\n0 9 0\n0 0 9\nC\n1\ndirect\n0 0 0\n"),
        ("a.data", "t\n\n1 atoms\n1 atom types\n\nAtoms # atomic\n\n1 1 1 2 3\n"),
        ("a.ptx", "1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n"),
    ];
    for (name, text) in texts {
        dir.put(name, text);
        let plain = dir.good(&["info", name, "--json"]).json();
        dir.put(name, format!("\u{feff}{text}"));
        assert_eq!(dir.good(&["info", name, "--json"]).json(), plain, "{name}");
        for (big, mark) in [(false, true), (true, true), (false, false), (true, false)] {
            let units = mark.then_some(0xfeff).into_iter().chain(text.encode_utf16());
            let bytes: Vec<u8> =
                units.flat_map(|unit| if big { unit.to_be_bytes() } else { unit.to_le_bytes() }).collect();
            dir.put(name, bytes);
            dir.refused(3, &["info", name], &["a text in UTF-16", "iconv -f UTF-16"]);
            // The command of the message makes a text that is read.
            let message = dir.run(&["info", name]).err;
            let command = message.split('`').nth(1).expect("a command");
            let made = dir.program("sh").args(["-c", &format!("{command} {name} > made")]).status().expect("sh runs");
            assert!(made.success(), "{message}");
            assert_eq!(String::from_utf8_lossy(&dir.get("made")).trim_start_matches('\u{feff}'), text, "{message}");
        }
    }
    let list = r#"[{"eye":[0,0,9],"view":[0,0,-1],"up":[0,1,0],"vfov":40}]"#;
    let map = "[[0,0,0],[1,1,1]]";
    dir.put("c.json", format!("\u{feff}{list}"));
    dir.put("m.json", format!("\u{feff}{map}"));
    dir.put("a.csv", "x,y,z,t\n0,0,0,1\n3,0,0,2\n");
    dir.render("a.csv --cameras c.json --color-by t --map m.json --size 8x8 -o m.png");
    let utf16 = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>();
    dir.put("c.json", utf16(list));
    dir.refused_render(3, "a.csv --cameras c.json --size 8x8 -o m%d.png", &["c.json", "UTF-16"]);
    dir.put("m.json", utf16(map));
    dir.refused_render(3, "a.csv --color-by t --map m.json --size 8x8 -o m.png", &["m.json", "UTF-16"]);
    // A mesh is no NFF.
    dir.put("mesh.obj", "# Blender\nmtllib a.mtl\no Cube\nv 1 2 3\nv 2 3 4\nv 3 4 5\nf 1 2 3\n");
    dir.refused(3, "info mesh.obj", &["an OBJ mesh", "save its vertices as PLY"]);
    dir.put("mesh.obj", "v 1 2 3\nv 2 3 4\nv 3 4 5\nf 1 2 3\n");
    dir.refused(3, "info mesh.obj", &["an OBJ mesh"]);
    dir.put("mesh", dir.get("mesh.obj"));
    dir.refused(3, "info mesh", &["an OBJ mesh"]);
}

/// The bytes of numbers of each type of NumPy; they are from 0 to 100 and whole.
fn bytes(kind: &str, numbers: &[f64]) -> Vec<u8> {
    let big = kind.starts_with('>');
    let of = |x: f64| -> Vec<u8> {
        let mut bytes = match &kind[1..] {
            "f8" => x.to_le_bytes().to_vec(),
            "f4" => (x as f32).to_le_bytes().to_vec(),
            // Whole numbers up to 2048 are exact.
            "f2" if x == 0.0 => vec![0; 2],
            "f2" => {
                let exponent = x.log2().floor();
                let fraction = ((x / exponent.exp2() - 1.0) * 1024.0) as u16;
                (((exponent as i32 + 15) as u16) << 10 | fraction).to_le_bytes().to_vec()
            }
            whole => (x as u64).to_le_bytes()[..whole[1..].parse().expect("a size")].to_vec(),
        };
        if big {
            bytes.reverse();
        }
        bytes
    };
    numbers.iter().flat_map(|x| of(*x)).collect()
}

/// An uncompressed archive of NumPy.
fn archive(members: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let stored = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, content) in members {
        zip.start_file(*name, stored).expect("in memory");
        zip.write_all(content).expect("in memory");
    }
    zip.finish().expect("in memory").into_inner()
}

#[test]
fn arrays_of_every_type_and_order_and_films_of_frames_are_read() {
    let dir = TestDir::new(&[]);
    // Two frames of three spheres.
    let frames: [[[f64; 3]; 3]; 2] =
        [[[1.0, 2.0, 3.0], [9.0, 0.0, 1.0], [0.0, 9.0, 2.0]], [[2.0, 2.0, 3.0], [8.0, 0.0, 1.0], [0.0, 7.0, 2.0]]];
    let row_major = frames.concat().concat();
    let column_major: Vec<f64> =
        (0..3).flat_map(|axis| (0..3).flat_map(move |n| (0..2).map(move |frame| frames[frame][n][axis]))).collect();
    for kind in ["<f8", ">f8", "<f4", ">f4", "<f2", ">f2", "|i1", "|u1", "<i2", ">u2", "<i4", ">i4", "<u8", ">i8"] {
        for (fortran, numbers) in [("False", &row_major), ("True", &column_major)] {
            dir.put("a.npy", npy_of(kind, fortran, "(2, 3, 3)", &bytes(kind, numbers)));
            dir.put("a.npz", archive(&[("positions.npy", dir.get("a.npy"))]));
            for file in ["a.npy", "a.npz"] {
                let info = dir.good(&["info", file, "--json"]).json();
                assert_eq!((&info["frames"], &info["spheres"]), (&2.into(), &3.into()), "{file} {kind} {fortran}");
                for (number, frame) in frames.iter().enumerate() {
                    let rows: Vec<String> = frame.iter().map(|p| format!("{},{},{}", p[0], p[1], p[2])).collect();
                    dir.put("f.csv", format!("x,y,z\n{}\n", rows.join("\n")));
                    let options = ["--frames", if number == 0 { "1" } else { "2" }, "--radius", "2"];
                    assert_eq!(
                        ids(&dir, file, &options, None),
                        ids(&dir, "f.csv", &["--radius", "2"], None),
                        "{file} {kind} {fortran} {number}"
                    );
                }
            }
        }
        // One frame.
        dir.put("b.npy", npy_of(kind, "False", "(3, 3)", &bytes(kind, &frames[0].concat())));
        let info = dir.good("info b.npy --json").json();
        assert_eq!(info["extent"]["max"], serde_json::json!([9.0, 9.0, 3.0]), "{kind}");
    }
    // One radius for all, and messages with what was found.
    dir.put(
        "r.npz",
        archive(&[
            ("positions.npy", npy_of("<f8", "False", "(1, 3)", &bytes("<f8", &[1.0, 2.0, 3.0]))),
            ("radii.npy", npy_of("<f4", "False", "()", &bytes("<f4", &[2.0]))),
            ("Speed.npy", npy_of("<f4", "False", "(1,)", &bytes("<f4", &[7.0]))),
        ]),
    );
    let info = dir.good("info r.npz --json").json();
    assert_eq!((&info["radii"]["source"], &info["radii"]["max"]), (&"file".into(), &2.0.into()));
    assert!(info["columns"]["Speed"]["max"] == 7.0 && info["warnings"] == serde_json::json!([]), "{info}");
    let complex = npy_of("<c16", "False", "(1, 3)", &[0; 48]);
    let other = npy_of("<f4", "False", "(2, 2)", &[0; 16]);
    dir.put("c.npz", archive(&[("positions.npy", complex.clone()), ("other.npy", other)]));
    dir.refused(3, "info c.npz", &["`<c16` of shape (1, 3)", "other (`<f4` of shape (2, 2))"]);
    dir.put("c.npy", complex);
    dir.refused(3, "info c.npy", &["found `<c16`"]);
    dir.put("d.npy", npy_of("<f8", "False", "(2, 2)", &[0; 32]));
    dir.refused(3, "info d.npy", &["found (2, 2), expected (n, 3)"]);
}
