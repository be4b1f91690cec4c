//! The content of files that are written here.

use super::*;
use halfline_particles::ParticleOptions;
use halfline_particles::input::Input;

/// The content of a text, counted in parts of `part` particles.
fn counted(name: &str, text: &str, part: usize) -> Result<FileInfo> {
    let (path, options) = (Path::new(name), ReadOptions::default());
    let source = SceneSource::of(Input::of_bytes(text.as_bytes()), path, options.particles.known_format())?;
    of_source(source, path, &options, Survey::with_part(part))
}

#[test]
fn the_extent_of_scaled_coordinates_is_that_of_the_placed_particles() {
    let head = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp pp pp\n-1 3\n0 8\n10 26\n";
    for columns in ["xs ys zs", "xsu ysu zsu"] {
        let text = format!("{head}ITEM: ATOMS {columns}\n0.25 0.5 1\n0.5 0.125 0\n1 0 0.25\n");
        for part in [1, 2, usize::MAX] {
            let extent = counted("a.dump", &text, part).expect("a dump").extent.expect("particles");
            assert_eq!((extent.min, extent.max), ([0.0, 0.0, 10.0], [3.0, 4.0, 26.0]), "{columns} {part}");
        }
    }
}

/// A file of some thousand particles, `atom` by `atom`, between a head and a tail.
fn many(head: &str, atom: impl Fn(usize) -> String, tail: &str) -> String {
    let atoms: String = (0..COUNT).map(|n| atom(n) + "\n").collect();
    format!("{head}{atoms}{tail}")
}

/// More than the most atoms of a residue, and several parts of a block of lines.
const COUNT: usize = 6000;

#[test]
fn the_counts_do_not_depend_on_the_size_of_the_parts() {
    // Numbers of all signs that are written in eight columns.
    let x = |n: usize, k: usize| ((n * (7 + k)) % 997) as f64 / 8.0 - 60.0;
    let three = |n: usize| format!("{:8.3}{:8.3}{:8.3}", x(n, 0), x(n, 1), x(n, 2));
    let words = |n: usize| format!("{} {} {}", x(n, 0), x(n, 1), x(n, 2));
    // Names of columns, then more names, which begin in the first one: `CD1 ` is carbon in the end.
    let aligned = |n: usize| match n {
        0..1000 => [" C1 ", "CD1 ", " N1 ", " Q7 "][n % 4],
        _ => ["N1  ", "O1  ", "MW  ", "XX  "][n % 4],
    };
    let pdb = |n: usize| {
        let (location, icode) = (["A", " "][n % 2], [" ", "B"][n / 2000 % 2]);
        let residue = n / 8 % 10_000;
        format!(
            "ATOM  {:5} {}{location}LIG {}{residue:4}{icode}   {}{:6.2}{:6.2}",
            n % 100_000,
            aligned(n),
            ["A", "B"][n / 3000],
            three(n),
            1.0,
            (n % 90) as f64
        )
    };
    let gro = |residue: &'static dyn Fn(usize) -> usize, moving: bool| {
        move |n: usize| {
            let speed = if moving { format!("{:8.4}{:8.4}{:8.4}", x(n, 3), x(n, 4), x(n, 5)) } else { String::new() };
            let name = ["C1", "MW", "HB1", "Q7", &format!("Z{}", n % 40)][n % 5].to_owned();
            format!("{:5}LIG  {name:>5}{:5}{}{speed}", residue(n) % 100_000, n % 100_000, three(n))
        }
    };
    let count = COUNT;
    let box_of = "ITEM: BOX BOUNDS pp pp pp\n-1 3\n0 8\n10 26\n";
    let dump =
        format!("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{count}\n{box_of}ITEM: ATOMS id xs ys zs element mol\n");
    let species = |n: usize| ["C", "CA", "HB1", "MW", "O"][n % 5].to_owned();
    let cif = "data_x\nloop_\n_atom_site.id\n_atom_site.type_symbol\n_atom_site.label_atom_id\n_atom_site.label_comp_id\n\
               _atom_site.label_asym_id\n_atom_site.label_seq_id\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n";
    let crystal = "data_x\n_cell_length_a 10\n_cell_length_b 10\n_cell_length_c 10\n_cell_angle_alpha 90\n_cell_angle_beta 90\n\
                   _cell_angle_gamma 90\nloop_\n_symmetry_equiv_pos_as_xyz\nx,y,z\n-x,-y,-z\n\
                   loop_\n_atom_site_label\n_atom_site_fract_x\n_atom_site_fract_y\n_atom_site_fract_z\n";
    let xyz = "\nLattice=\"9 0 0 0 9 0 0 0 9\" Properties=species:S:1:pos:R:3:kind:S:1:v:R:2\n";
    for (name, text) in [
        ("a.pdb", many("CRYST1   20.000   20.000   20.000  90.00  90.00  90.00\n", pdb, "END\n")),
        ("a.gro", many(&format!("still\n{count}\n"), gro(&|n| n / 3, false), "9 9 9\n")),
        ("b.gro", many(&format!("moving\n{count}\n"), gro(&|_| 1, true), "9 9 9\n")),
        (
            "a.xyz",
            many(&format!("{count}{xyz}"), |n| format!("{} {} k{} {} -{n}", species(n), words(n), n % 7, x(n, 3)), ""),
        ),
        ("a.dump", many(&dump, |n| format!("{n} {} {} {}", words(n), species(n), n % 11), "")),
        (
            "a.csv",
            many(
                "x,y,z,radius,t,kind,mixed\n",
                |n| {
                    format!("{},{},k{},{}", words(n).replace(' ', ","), 1 + n % 3, n % 70, n % 9)
                        .replace(",k", &format!(",{n},k"))
                },
                "",
            ),
        ),
        (
            "a.cif",
            many(
                cif,
                |n| {
                    format!(
                        "{n} {} {} LIG {} {} {}",
                        ["C", "?"][n % 2],
                        ["C1", "CD1", "MW", "Q7"][n % 4],
                        ["A", "B"][n / 3000],
                        n / 8,
                        words(n)
                    )
                },
                "",
            ),
        ),
        (
            "b.cif",
            many(
                crystal,
                |n| {
                    format!(
                        "C{n} {} {} {}",
                        (n % 18) as f64 / 20.0,
                        (n / 18 % 18) as f64 / 20.0,
                        (n / 324) as f64 / 40.0
                    )
                },
                "",
            ),
        ),
    ] {
        let info = |part: usize| format!("{:#?}", counted(name, &text, part).unwrap_or_else(|e| panic!("{e}")));
        let whole = info(usize::MAX);
        for part in [1, 100, 1777] {
            assert_eq!(info(part), whole, "{name}, parts of {part}");
        }
        if name == "a.pdb" {
            // 1250 of the 6000 are virtual sites.
            let elements = [("C", 500), ("N", 1500), ("O", 1250), ("X", 1500)];
            let found = counted(name, &text, 100).expect("a PDB file").elements;
            assert_eq!(found, elements.map(|(name, n)| (name.to_owned(), n)).into());
        }
    }
}

#[test]
fn a_column_of_numbers_and_texts_is_text() {
    let table = "x,y,z,a,b,c\n0,0,0,1,0.5,2\n1,0,0,2,A,2\n2,0,0,A,B,2\n3,0,0,A,,x y\n";
    let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n3\nITEM: ATOMS x y z type\n0 0 0 1\n0 0 1 2\n0 0 2 A\n";
    for part in [1, usize::MAX] {
        let info = counted("a.csv", table, part).expect("a table");
        let column = |name: &str| {
            let ColumnInfo { kind, min, values, distinct, missing, .. } = &info.columns[name];
            (*kind, *min, values.join(" "), *distinct, *missing)
        };
        assert_eq!(column("a"), ("text", None, "A 1 2".into(), Some(3), 0));
        // Numbers that are not whole are not counted.
        assert_eq!(column("b"), ("text", None, "A B".into(), None, 1));
        assert_eq!(column("c"), ("text", None, "2 x y".into(), Some(2), 0));
        let info = counted("a.dump", dump, part).expect("a dump");
        assert_eq!((info.columns["type"].kind, &info.columns["type"].values.join(" ")[..]), ("text", "1 2 A"));
    }
    // A coordinate is an error still.
    let error = counted("a.csv", "x,y,z\n0,0,0\n0,A,0\n", 1).map(drop).expect_err("a text").to_string();
    assert!(error.contains("a.csv:3:3: y: `A` is not a number"), "{error}");
}

#[test]
fn infinities_are_counted_and_not_in_the_range() {
    let info = counted("a.csv", "x,y,z,t\n0,0,0,inf\n1,0,0,-inf\n2,0,0,3\n3,0,0,nan\n4,0,0,\n", 1).expect("a table");
    let t = &info.columns["t"];
    assert_eq!(
        (t.min, t.max, t.infinite, t.missing, &t.values[..]),
        (Some(3.0), Some(3.0), 2, 2, &["3".to_owned()][..])
    );
}

#[test]
fn files_without_particles_have_a_warning_and_their_columns() {
    for (name, text, column) in [
        ("a.xyz", "0\nProperties=species:S:1:pos:R:3:kind:S:1:v:R:1\n", "kind"),
        ("a.gro", "nothing\n0\n1 1 1\n", "resname"),
        ("a.csv", "x,y,z,element\n", "element"),
    ] {
        let info = counted(name, text, usize::MAX).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((info.spheres, info.extent.is_none(), info.columns[column].kind), (0, true, "text"), "{name}");
        assert_eq!(info.warnings, ["there is no sphere to render"], "{name}");
    }
    let info = counted("a.toml", "[camera]\neye = [0.0, 0.0, 5.0]\nat = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nvfov = 60.0\n[image]\nsize = [4, 4]\n", usize::MAX).expect("a scene");
    assert_eq!((info.spheres, &info.warnings[..]), (0, &["there is no sphere to render".to_owned()][..]));
}

/// A file whose last frame is cut, as of a simulation that runs, has the frames before it, which the error names.
#[test]
fn the_error_of_a_frame_names_the_whole_ones_before_it() {
    let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: ATOMS x y z\n0 0 0\n1 1 1\n";
    let gro =
        "t\n 2\n    1SOL     OW    1   0.126   1.624   1.679\n    1SOL    HW1    2   0.1     1.6     1.7  \n 1 1 1\n";
    let trr = |x: f32| -> Vec<u8> {
        let words = [1993, 13, 12].map(i32::to_be_bytes).concat();
        let sizes = [0, 0, 0, 0, 0, 0, 0, 24, 0, 0, 2, 0, 0].map(i32::to_be_bytes).concat();
        let rest: Vec<u8> = [0.0, 0.0, x, 0.0, 0.0, 1.0, 1.0, 1.0].into_iter().flat_map(f32::to_be_bytes).collect();
        [words, b"GMX_trn_file".to_vec(), sizes, rest].concat()
    };
    for (name, frame) in [
        ("a.xyz", b"2\n\nO 0 0 0\nH 1 0 0\n".to_vec()),
        ("a.dump", dump.as_bytes().to_vec()),
        ("a.gro", gro.as_bytes().to_vec()),
        ("a.trr", trr(0.5)),
    ] {
        let film = frame.repeat(4);
        let cut = &film[..film.len() - frame.len() / 4];
        for (frames, way) in [
            ("1-", Some("or use `\u{2060}frames` 1-3, since the frames before frame 4 are whole")),
            ("3-9", Some("or use `\u{2060}frames` 3, since the frames before")),
            ("4", Some("or use `\u{2060}frames` 1-3, since the frames before")),
            ("1-3", None),
        ] {
            let options = ReadOptions {
                particles: ParticleOptions { frames: frames.parse().expect("frames"), ..Default::default() },
                ..ReadOptions::default()
            };
            let source = SceneSource::of(Input::of_bytes(cut), Path::new(name), options.particles.known_format())
                .expect("a format");
            let mut film = Sequence::of_source(source, Path::new(name), &options).expect("a film");
            let error = loop {
                match film.next_scene() {
                    Ok(Some(_)) => {}
                    Ok(None) => break None,
                    Err(error) => break Some(error.to_string()),
                }
            };
            assert_eq!(error.is_some(), way.is_some(), "{name} {frames}: {error:?}");
            assert!(way.is_none_or(|way| error.as_ref().is_some_and(|error| error.contains(way))), "{name}: {error:?}");
        }
        // The first frame alone has none before it.
        let source = SceneSource::of(
            Input::of_bytes(&frame[..frame.len() * 3 / 4]),
            Path::new(name),
            ReadOptions::default().particles.known_format(),
        );
        let mut film =
            Sequence::of_source(source.expect("a format"), Path::new(name), &ReadOptions::default()).expect("a film");
        let error = film.next_scene().map(drop).expect_err("one frame").to_string();
        assert!(!error.contains("whole"), "{name}: {error}");
    }
}
