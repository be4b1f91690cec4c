use super::*;

#[test]
fn formats_are_recognised_by_content() {
    let gro = "a title\n 2\n    1SOL     OW    1   0.126   1.624   1.679\n";
    let qt = "ATOM      1  C   UNL A   1      31.770  31.020  29.720  0.00  0.00    +0.007 A \n";
    let pqr = "REMARK   1 PQR\nATOM      1  N    MET     1     -11.921   26.307   10.410 -0.3000 1.8500\n";
    let cases: [(&str, Option<Format>); 33] = [
        ("ply\nformat ascii 1.0\n", Some(Format::PLY)),
        ("ITEM: TIMESTEP\n0\n", Some(Format::DUMP)),
        ("# a comment\ndata_1ABC\n#\nloop_\n", Some(Format::CIF)),
        ("HEADER    VIRUS\n", Some(Format::PDB)),
        ("ATOM      1  N   MET A   1      27.340  24.430   2.614\n", Some(Format::PDB)),
        ("ATOM      1  CA AGLY B  -3A   -100.123-200.456-300.789  0.50-10.00           C1-\n", Some(Format::PDB)),
        (qt, Some(Format::PDBQT)),
        ("REMARK  Name = x\nROOT\nATOM      1  C   UNL A   1      31.770  31.020  29.720\n", Some(Format::PDBQT)),
        (pqr, Some(Format::PQR)),
        ("ATOM      1  O1G gtp     1      -5.019  -2.528  14.700 -0.9526  1.5000       O\n", Some(Format::PQR)),
        (gro, Some(Format::GRO)),
        ("2\n\nO 0 0 0\nH 1 0 0\n", Some(Format::XYZ)),
        ("0\nempty\n", Some(Format::XYZ)),
        ("1\nProperties=pos:R:3\n1 2 3\n", Some(Format::XYZ)),
        ("# by hand\nv\nfrom 0 0 1\n", Some(Format::NFF)),
        ("s 0 0 0 1\n", Some(Format::NFF)),
        ("1 2 3\n4 5 6\n4 0 0\n0 4 0\n0 0 4\n4 4 4\n1 2 3\n", None),
        ("1 2 3\n1 1 1\n4 0 0\n0 4 0\n0 0 4\n1 1 1\nDirect\n", Some(Format::POSCAR)),
        ("salt\n1.0\n4 0 0\n0 4 0\n0 0 4\nNa Cl\n1 1\nDirect\n", Some(Format::POSCAR)),
        ("Cu\n-32.5\n4 0 0\n0 4 0\n0 0 4\n4\nDirect\n", Some(Format::POSCAR)),
        ("c 1\n1 1 2\n4 0 0\n0 4 0\n0 0 4\n4\nDirect\n", Some(Format::POSCAR)),
        ("# .PCD v.7\nVERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n", Some(Format::PCD)),
        ("LAMMPS data file\n\n 12 atoms\n", Some(Format::DATA)),
        ("x,y,z,radius\n", Some(Format::CSV)),
        ("# id X Y Z vx\n", Some(Format::CSV)),
        ("# by hand\n\nradius,z,y,x\n", Some(Format::CSV)),
        ("name,x_km,y_km,z_km\n", Some(Format::CSV)),
        ("\"t\",\"Points:0\",\"Points:1\",\"Points:2\"\n", Some(Format::CSV)),
        ("Points_0,Points_1,Points_2,Points_Magnitude\n", Some(Format::CSV)),
        ("Points_0,Points_1,Points_Magnitude\n", None),
        ("[camera]\neye = [0, 0, 1]\n", None),
        ("hello\n", None),
        ("", None),
    ];
    for (text, format) in cases {
        assert_eq!(of_content(text.as_bytes(), None), format, "{text:?}");
    }
    assert_eq!(of_content(b"\x93NUMPY\x01\x00", None), Some(Format::NPY));
    assert_eq!(of_content(b"PK\x03\x04", None), Some(Format::NPZ));
    assert_eq!(of_content(b"LASF\0\0", None), Some(Format::LAS));
    assert_eq!(of_content(b"\x83\xa7version\xa50.3.0", None), Some(Format::CIF));
    assert_eq!(of_content(b"\xde\0\x03\xaadataBlocks\x91", None), Some(Format::CIF));
    assert_eq!(of_content(b"\x83\xabmmtfVersion", None), None);
    assert_eq!(of_content(&[0xdf, 0x65].repeat(4), None), Some(Format::GSD));
    assert_eq!(of_content(&[0, 0, 7, 0xcb, 0, 0], None), Some(Format::XTC));
    assert_eq!(of_content(&[0, 0, 7, 0xe7, 0, 0], None), Some(Format::XTC));
    assert_eq!(of_content(&[0, 0, 7, 0xc9, 0, 0], None), Some(Format::TRR));
    for length in [&b"T\0\0\0"[..], b"\0\0\0T", b"T\0\0\0\0\0\0\0", b"\0\0\0\0\0\0\0T"] {
        for kind in [b"CORD", b"VELD"] {
            assert_eq!(of_content(&[length, kind].concat(), None), Some(Format::DCD));
        }
    }
}

#[test]
fn names_decide_where_content_does_not_and_unsupported_formats_are_named() {
    let header = "REMARK   1\n".repeat(80);
    let of = |text: &str, name: &str| {
        recognise(text.as_bytes(), Path::new(name)).map(|(format, _)| format).map_err(|(problem, _)| problem)
    };
    assert_eq!(of(&header, "a.pqr"), Ok(Format::PQR));
    assert_eq!(of(&header, "a.pdbqt"), Ok(Format::PDBQT));
    assert_eq!(of(&header, "a.gro"), Ok(Format::PDB));
    assert_eq!(of("# nothing\n", "a.xyz"), Ok(Format::XYZ));
    assert_eq!(of("[camera]\n", "a"), Ok(Format::NATIVE));
    assert_eq!(of("no scale\n", "run/CONTCAR.relaxed"), Ok(Format::POSCAR));
    for (text, name, what) in [
        ("TITLE\n  a run\nEND\n", "a.pdb", "GROMOS"),
        ("2 water\n 1 O 0.0 0.0 0.0 1 2\n 2 H 1.0 0.0 0.0 2 1\n", "a.xyz", "Tinker"),
        ("\u{1}", "a.tng", "TNG"),
        ("[ moleculetype ]\n", "a.itp", "topology"),
        ("<?xml version=\"1.0\"?>\n", "a", "XML"),
        ("not x = 1 and more\n", "a", "cannot be detected"),
    ] {
        let problem = of(text, name).expect_err(name);
        assert!(problem.contains(what), "{problem}");
    }
}

/// Atoms in the columns of PDB, and such as PDB2PQR and AMBER write, which are not.
const PDB: [&str; 4] = [
    "ATOM    194  O   LYS A  20      34.379  53.562  37.179  1.00  53.1           O",
    "ATOM    194  O   LYS A  20      34.379  53.562  37.179   1.0  53.10          O",
    "ATOM    194  O   LYS A  20      34.379  53.562  37.179  0.50 3.1             O",
    "HETATM  194  O   HOH A  20      34.379  53.562  37.179 1.000100.5            O",
];
const PQR: [&str; 3] = [
    "ATOM      1  N   MET     1     -11.921   26.307   10.410 -0.3000 1.8500",
    "ATOM      1  N   MET A   1      27.340  24.430   2.614  0.1414 1.8240",
    "ATOM 1 N MET A 1 27.340 24.430 2.614 -0.4157 1.8240",
];

#[test]
fn a_name_that_a_beginning_can_have_is_right_and_another_is_reported() {
    let of = |text: &str, name: &str| {
        let (format, warning) = recognise(text.as_bytes(), Path::new(name)).expect(text);
        (format, warning.is_some())
    };
    for atom in PDB {
        let long = format!("{}{atom}\n", "REMARK\n".repeat(99));
        for text in [&format!("{atom}\n"), &format!("TITLE\n{atom}\n"), &long] {
            for name in ["a.pdb", "a.ent", "a", "a.txt"] {
                assert_eq!(of(text, name), (Format::PDB, false), "{name}: {text}");
            }
            // Five numbers with blanks between them can be an atom of PQR.
            let is_either = atom.split_whitespace().filter(|word| word.contains('.')).count() == 5;
            assert_eq!(of(text, "a.pqr"), (Format::PQR, is_either), "{text}");
        }
    }
    for atom in PQR {
        let long = format!("{}{atom}\n", "REMARK\n".repeat(99));
        for text in [&format!("{atom}\n"), &long] {
            assert_eq!(of(text, "a.pqr"), (Format::PQR, false), "{text}");
            assert_eq!(of(text, "a.pdb"), (Format::PQR, true), "{text}");
            assert_eq!(of(text, "a"), (Format::PQR, false), "{text}");
        }
    }
    let qt = "ATOM      1  O   UNL A   1      31.770  31.020  29.720  0.00  0.00    -0.350 OA\n";
    assert_eq!(of(qt, "a.pdb"), (Format::PDBQT, true));
    assert_eq!(of(&qt.replace("OA", "O "), "a.pdb"), (Format::PDB, false));
    assert_eq!(of("2\n\nO 0 0 0\nH 1 0 0\n", "a.pdb"), (Format::XYZ, true));
    assert_eq!(of("x y z\n1 2 3\n", "a.xyz"), (Format::CSV, true));
    assert_eq!(of("ply\n", "a.csv"), (Format::PLY, true));
}

#[test]
fn titles_and_comments_look_like_other_formats() {
    let cell = "1.0\n4 0 0\n0 4 0\n0 0 4\nNa Cl\n1 1\nDirect\n";
    let atoms = " 2\n    1SOL     OW    1   0.126   1.624   1.679\n";
    let data = "\n 12 atoms\n";
    for title in ["data_salt", "loop_", "HEADER of it", "MODEL 1", "ATOM file", "TITLE x", "REMARK", "USER", "# x y z"]
    {
        for (rest, name, format) in [
            (cell, "POSCAR", Format::POSCAR),
            (cell, "a.vasp", Format::POSCAR),
            (atoms, "a.gro", Format::GRO),
            (data, "a.data", Format::DATA),
        ] {
            let text = format!("{title}\n{rest}");
            assert_eq!(recognise(text.as_bytes(), Path::new(name)), Ok((format, None)), "{text}");
        }
    }
    let scan = "1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
    assert_eq!(recognise(scan.as_bytes(), Path::new("a")), Ok((Format::PTX, None)));
    for (text, name, format) in [
        ("{ salt\n1.0\n4 0 0\n0 4 0\n0 0 4\nNa Cl\n1 1\nDirect\n", "POSCAR", Format::POSCAR),
        ("# the units of x y z are metres\n[camera]\neye = [0, 0, 1]\n", "s.toml", Format::NATIVE),
        ("# x y z\nv\nfrom 0 0 1\n", "s.nff", Format::NFF),
        ("data_id,x,y,z\n1,0,0,0\n", "a.csv", Format::CSV),
    ] {
        assert_eq!(recognise(text.as_bytes(), Path::new(name)), Ok((format, None)), "{text}");
    }
}

/// Beginnings of other formats, as a line of a title or a comment.
const BEGINNINGS: [&str; 66] = [
    "ply",
    "ITEM: TIMESTEP",
    "VERSION .7",
    "FIELDS x y z",
    "data_1ABC",
    "loop_",
    "global_",
    "_atom_site.id",
    "HEADER    VIRUS",
    "TITLE",
    "TITLE     A STRUCTURE",
    "COMPND",
    "MODEL        1",
    "CRYST1",
    "ATOM",
    "REMARK",
    "USER",
    "ROOT",
    "v",
    "s 0 0 0 1",
    "12 atoms",
    "LAMMPS data file",
    "Atoms # full",
    "2 atom types",
    "0 1 xlo xhi",
    "x,y,z,radius",
    "x y z",
    "# x y z",
    "[camera]",
    "eye = [1, 2, 3]",
    "3",
    "1 2 3",
    "1 2 3 4",
    "1.0",
    "Direct",
    "Properties=species:S:1:pos:R:3",
    "Lattice=\"1 0 0 0 1 0 0 0 1\"",
    "# .PCD v.7 - Point Cloud Data file format",
    "* a title of CHARMM",
    "PSF CMAP",
    "%VERSION  VERSION_STAMP = V0001.000",
    "@<TRIPOS>MOLECULE",
    "  9  8  0  0  0  0  0  0  0  0999 V2000",
    "1 O 0.0 0.0 0.0 1 2",
    "{\"a\": 1}",
    "<?xml version=\"1.0\"?>",
    "<!DOCTYPE html>",
    "<VTKFile>",
    "# vtk DataFile Version 3.0",
    "solid cube",
    "facet normal",
    "version https://git-lfs.github.com/spec/v1",
    "../.git/annex/objects/x",
    "SIMPLE  =",
    "glTF",
    "PAR1",
    "ARROW1",
    "ASTM-E57",
    "MATLAB 5.0 MAT-file",
    "- of Ulm",
    "a   CORD",
    "    CORD",
    "a       VELD",
    "a VERSION",
    "12   VERSION 2",
    "LASF",
];

/// A small file of each format of text, with a line that its grammar leaves to the writer.
fn written(format: Format, line: &str) -> Option<String> {
    let word = line.split_whitespace().next().unwrap_or("a");
    Some(match format.name() {
        "gro" => format!(
            "{line}\n 2\n    1SOL     OW    1   0.126   1.624   1.679\n    1SOL    HW1    2   0.1   1.6   1.7\n 1 1 1\n"
        ),
        "poscar" => format!("{line}\n1.0\n4 0 0\n0 4 0\n0 0 4\nNa Cl\n1 1\nDirect\n0 0 0\n.5 .5 .5\n"),
        "data" => {
            format!("{line}\n\n2 atoms\n1 atom types\n0 1 xlo xhi\n\nAtoms # atomic\n\n1 1 0 0 0\n2 1 1 0 0\n")
        }
        "xyz" => format!("2\n{line}\nO 0 0 0.5\nH 1 0 0\n"),
        "cif" => format!("# {line}\ndata_x\n_a\n;\n{line}\n;\nloop_\n_atom_site.id\n1\n"),
        "pdb" => format!(
            "REMARK    {line}\nTITLE     {line}\nATOM      1  N   MET A   1      27.340  24.430   2.614  1.00 53.10           N\n"
        ),
        "pqr" => {
            format!("REMARK   1 {line}\nATOM      1  N   MET     1     -11.921   26.307   10.410 -0.3000 1.8500\n")
        }
        "pdbqt" => format!(
            "REMARK  {line}\nROOT\nATOM      1  C   UNL A   1      31.770  31.020  29.720  0.00  0.00    +0.007 A \n"
        ),
        "csv" => format!("# {line}\n\"{word}\",x,y,z\n{word},1,2,3\n"),
        "ply" => format!("ply\nformat ascii 1.0\ncomment {line}\nelement vertex 0\nend_header\n"),
        "pcd" => format!("# {line}\nVERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n"),
        "nff" => format!("# {line}\nv\nfrom 0 0 1\n"),
        "toml" => format!("# {line}\n[camera]\neye = [0, 0, 1]\n"),
        "dump" => format!("ITEM: UNITS\n{line}\nITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n0\n"),
        _ => return None,
    })
}

/// Text that one format leaves to its writer is no sign of another, whatever it says and whatever the file is called.
#[test]
fn signatures_of_other_formats_never_beat_the_words_of_a_format() {
    let mut wrong = Vec::new();
    let mut count = 0;
    for format in Format::ALL {
        for line in BEGINNINGS {
            let Some(text) = written(format, line) else { continue };
            let own = if format == Format::NATIVE { "toml" } else { format.name() };
            for name in ["a", "a.txt", &format!("a.{own}")] {
                count += 1;
                // A header that is a comment is the header of a table without another one.
                let is_header = format == Format::NFF && line.contains("x y z") && name != "a.nff";
                let found = recognise(text.as_bytes(), Path::new(name));
                if found != Ok((format, None)) && !is_header {
                    wrong.push(format!("{name}: {found:?} of {text:?}"));
                }
            }
        }
    }
    assert!(count > 2000 && wrong.is_empty(), "{} of {count}:\n{}", wrong.len(), wrong.join("\n"));
}

/// The words of extended XYZ are words of no other format, whatever its columns are; the rows of Tinker's file distinguish it.
#[test]
fn extended_xyz_is_not_tinker() {
    for comment in ["Properties=id:I:1:species:S:1:pos:R:3:type:I:1", "properties=id:I:1:species:S:1:pos:R:3:a:I:1 x=1"]
    {
        for name in ["a.xyz", "a.extxyz", "a"] {
            for line in ["", "@<TRIPOS>", "VERSION"] {
                let text = format!("1\n{comment} {line}\n1 C 1 2 3 1\n");
                assert_eq!(recognise(text.as_bytes(), Path::new(name)), Ok((Format::XYZ, None)), "{text}");
            }
        }
    }
    let rows = "2\n30 30 30 90 90 90\n1 O 0 0 0 1 2\n2 H 1 0 0 2 1\n";
    assert!(recognise(rows.as_bytes(), Path::new("a.xyz")).expect_err("Tinker").0.contains("Tinker"));
}

#[test]
fn a_scene_is_recognised_wherever_its_beginning_is_cut() {
    let text = "# \u{e9}\n[camera]\n";
    assert!(native(text.as_bytes()));
    let within = format!("{text}# \u{e9}");
    assert!(native(&within.as_bytes()[..within.len() - 1]));
    assert!(native(b"# \xe9\n[camera]\n"));
    assert!(!native(b"\xff\xd8 = \n"));
}

#[test]
fn points_that_are_called_xyz_are_not_atoms() {
    let pts = Ok((Format::PTS, None));
    let xyz = Ok((Format::XYZ, None));
    let numbered = "8 0 0 0.5\n1 1 0 0\n";
    for (text, name, format) in [
        ("0.5 1 2\n1 2 3\n", "a.xyz", &pts),
        ("1 2 3\n", "a.xyz", &pts),
        ("1,2,3,4\n5,6,7,8\n", "a.xyz", &pts),
        ("2\n0.5 1 2 10 255 0 0\n1.5 2 3 11 0 255 0\n", "a.xyz", &pts),
        ("// X Y Z\n1 2 3\n4 5 6\n", "a.xyz", &pts),
        ("2\n0 1 2 10\n1 2 3 11\n", "a.pts", &pts),
        ("0 1 2\n1 2 3\n", "a.pts", &pts),
        ("2\n0.5 1 2 255 0 0\n1.5 2 3 0 255 0\n", "a", &pts),
        ("2\n0.5 1 2 -9 255 0 0\n1.5 2 3 -8 0 255 0\n", "a.txt", &pts),
        ("2\n\n8 0 0 0.5\n1 1 0 0\n", "a.xyz", &xyz),
        ("2\n1 2 3 4\n8 0 0 0.5\n1 1 0 0\n", "a.xyz", &xyz),
        ("2\n\nO 0 0 0.5\nH 1 0 0\n", "a.xyz", &xyz),
        // Atomic numbers without a count, and rows of other lengths: the reader of XYZ says what is missing.
        (numbered, "a.xyz", &xyz),
        ("1 2 3\n1 2 3 4\n0 0 0\n", "a.xyz", &xyz),
        ("O 0 0 0.5\n", "a.xyz", &xyz),
    ] {
        assert_eq!(&recognise(text.as_bytes(), Path::new(name)), format, "{name}: {text}");
    }
    for text in ["1 2 3\n4 5 6\n", "2\n1 2 3\n4 5 6\n", numbered] {
        let problem = recognise(text.as_bytes(), Path::new("-")).expect_err(text);
        assert!(problem.1.contains(", pts"), "{problem:?}");
    }
    for name in ["a.csv", "a.gro", "POSCAR"] {
        assert!(recognise(b"1 2 3\n4 5 6\n", Path::new(name)).is_ok_and(|(format, _)| format != Format::PTS), "{name}");
    }
}
