use super::*;

#[test]
fn formats_are_recognised_by_content() {
    let gro = "a title\n 2\n    1SOL     OW    1   0.126   1.624   1.679\n";
    let qt = "ATOM      1  C   UNL A   1      31.770  31.020  29.720  0.00  0.00    +0.007 A \n";
    let pqr = "REMARK   1 PQR\nATOM      1  N    MET     1     -11.921   26.307   10.410 -0.3000 1.8500\n";
    let cases: [(&str, Option<Format>); 33] = [
        ("ply\nformat ascii 1.0\n", Some(Format::Ply)),
        ("ITEM: TIMESTEP\n0\n", Some(Format::Dump)),
        ("# a comment\ndata_1ABC\n#\nloop_\n", Some(Format::Mmcif)),
        ("HEADER    VIRUS\n", Some(Format::Pdb)),
        ("ATOM      1  N   MET A   1      27.340  24.430   2.614\n", Some(Format::Pdb)),
        ("ATOM      1  CA AGLY B  -3A   -100.123-200.456-300.789  0.50-10.00           C1-\n", Some(Format::Pdb)),
        (qt, Some(Format::Pdbqt)),
        ("REMARK  Name = x\nROOT\nATOM      1  C   UNL A   1      31.770  31.020  29.720\n", Some(Format::Pdbqt)),
        (pqr, Some(Format::Pqr)),
        ("ATOM      1  O1G gtp     1      -5.019  -2.528  14.700 -0.9526  1.5000       O\n", Some(Format::Pqr)),
        (gro, Some(Format::Gro)),
        ("2\n\nO 0 0 0\nH 1 0 0\n", Some(Format::Xyz)),
        ("0\nempty\n", Some(Format::Xyz)),
        ("1\nProperties=pos:R:3\n1 2 3\n", Some(Format::Xyz)),
        ("# by hand\nv\nfrom 0 0 1\n", Some(Format::Nff)),
        ("s 0 0 0 1\n", Some(Format::Nff)),
        ("1 2 3\n4 5 6\n4 0 0\n0 4 0\n0 0 4\n4 4 4\n1 2 3\n", None),
        ("1 2 3\n1 1 1\n4 0 0\n0 4 0\n0 0 4\n1 1 1\nDirect\n", Some(Format::Poscar)),
        ("salt\n1.0\n4 0 0\n0 4 0\n0 0 4\nNa Cl\n1 1\nDirect\n", Some(Format::Poscar)),
        ("Cu\n-32.5\n4 0 0\n0 4 0\n0 0 4\n4\nDirect\n", Some(Format::Poscar)),
        ("c 1\n1 1 2\n4 0 0\n0 4 0\n0 0 4\n4\nDirect\n", Some(Format::Poscar)),
        ("# .PCD v.7\nVERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n", Some(Format::Pcd)),
        ("LAMMPS data file\n\n 12 atoms\n", Some(Format::Data)),
        ("x,y,z,radius\n", Some(Format::Csv)),
        ("# id X Y Z vx\n", Some(Format::Csv)),
        ("# by hand\n\nradius,z,y,x\n", Some(Format::Csv)),
        ("name,x_km,y_km,z_km\n", Some(Format::Csv)),
        ("\"t\",\"Points:0\",\"Points:1\",\"Points:2\"\n", Some(Format::Csv)),
        ("Points_0,Points_1,Points_2,Points_Magnitude\n", Some(Format::Csv)),
        ("Points_0,Points_1,Points_Magnitude\n", None),
        ("[camera]\neye = [0, 0, 1]\n", None),
        ("hello\n", None),
        ("", None),
    ];
    for (text, format) in cases {
        assert_eq!(of_content(text.as_bytes(), None), format, "{text:?}");
    }
    assert_eq!(of_content(b"\x93NUMPY\x01\x00", None), Some(Format::Npy));
    assert_eq!(of_content(b"PK\x03\x04", None), Some(Format::Npz));
    assert_eq!(of_content(b"LASF\0\0", None), Some(Format::Las));
    assert_eq!(of_content(b"\x83\xa7version\xa50.3.0", None), Some(Format::Mmcif));
    assert_eq!(of_content(b"\xde\0\x03\xaadataBlocks\x91", None), Some(Format::Mmcif));
    assert_eq!(of_content(b"\x83\xabmmtfVersion", None), None);
    assert_eq!(of_content(&[0xdf, 0x65].repeat(4), None), Some(Format::Gsd));
    assert_eq!(of_content(&[0, 0, 7, 0xcb, 0, 0], None), Some(Format::Xtc));
    assert_eq!(of_content(&[0, 0, 7, 0xe7, 0, 0], None), Some(Format::Xtc));
    assert_eq!(of_content(&[0, 0, 7, 0xc9, 0, 0], None), Some(Format::Trr));
    assert_eq!(of_content(b"T\0\0\0CORD", None), Some(Format::Dcd));
    assert_eq!(of_content(b"\0\0\0\0\0\0\0TCORD", None), Some(Format::Dcd));
}

#[test]
fn names_decide_where_content_does_not_and_unsupported_formats_are_named() {
    let header = "REMARK   1\n".repeat(80);
    let of = |text: &str, name: &str| {
        recognise(text.as_bytes(), Path::new(name)).map(|(format, _)| format).map_err(|(problem, _)| problem)
    };
    assert_eq!(of(&header, "a.pqr"), Ok(Format::Pqr));
    assert_eq!(of(&header, "a.pdbqt"), Ok(Format::Pdbqt));
    assert_eq!(of(&header, "a.gro"), Ok(Format::Pdb));
    assert_eq!(of("# nothing\n", "a.xyz"), Ok(Format::Xyz));
    assert_eq!(of("[camera]\n", "a"), Ok(Format::Native));
    assert_eq!(of("no scale\n", "run/CONTCAR.relaxed"), Ok(Format::Poscar));
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
                assert_eq!(of(text, name), (Format::Pdb, false), "{name}: {text}");
            }
            // Five numbers with blanks between them can be those of PQR.
            let is_either = run(atom) == 5;
            assert_eq!(of(text, "a.pqr"), (Format::Pqr, is_either), "{text}");
        }
    }
    for atom in PQR {
        let long = format!("{}{atom}\n", "REMARK\n".repeat(99));
        for text in [&format!("{atom}\n"), &long] {
            assert_eq!(of(text, "a.pqr"), (Format::Pqr, false), "{text}");
            assert_eq!(of(text, "a.pdb"), (Format::Pqr, true), "{text}");
            assert_eq!(of(text, "a"), (Format::Pqr, false), "{text}");
        }
    }
    let qt = "ATOM      1  O   UNL A   1      31.770  31.020  29.720  0.00  0.00    -0.350 OA\n";
    assert_eq!(of(qt, "a.pdb"), (Format::Pdbqt, true));
    assert_eq!(of(&qt.replace("OA", "O "), "a.pdb"), (Format::Pdb, false));
    assert_eq!(of("2\n\nO 0 0 0\nH 1 0 0\n", "a.pdb"), (Format::Xyz, true));
    assert_eq!(of("x y z\n1 2 3\n", "a.xyz"), (Format::Csv, true));
    assert_eq!(of("ply\n", "a.csv"), (Format::Ply, true));
}

#[test]
fn titles_and_comments_look_like_other_formats() {
    let cell = "1.0\n4 0 0\n0 4 0\n0 0 4\nNa Cl\n1 1\nDirect\n";
    let atoms = " 2\n    1SOL     OW    1   0.126   1.624   1.679\n";
    let data = "\n 12 atoms\n";
    for title in ["data_salt", "loop_", "HEADER of it", "MODEL 1", "ATOM file", "TITLE x", "REMARK", "USER", "# x y z"]
    {
        for (rest, name, format) in [
            (cell, "POSCAR", Format::Poscar),
            (cell, "a.vasp", Format::Poscar),
            (atoms, "a.gro", Format::Gro),
            (data, "a.data", Format::Data),
        ] {
            let text = format!("{title}\n{rest}");
            assert_eq!(recognise(text.as_bytes(), Path::new(name)), Ok((format, None)), "{text}");
        }
    }
    let scan = "1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
    assert_eq!(recognise(scan.as_bytes(), Path::new("a")), Ok((Format::Ptx, None)));
    for (text, name, format) in [
        ("{ salt\n1.0\n4 0 0\n0 4 0\n0 0 4\nNa Cl\n1 1\nDirect\n", "POSCAR", Format::Poscar),
        ("# the units of x y z are metres\n[camera]\neye = [0, 0, 1]\n", "s.toml", Format::Native),
        ("# x y z\nv\nfrom 0 0 1\n", "s.nff", Format::Nff),
        ("data_id,x,y,z\n1,0,0,0\n", "a.csv", Format::Csv),
    ] {
        assert_eq!(recognise(text.as_bytes(), Path::new(name)), Ok((format, None)), "{text}");
    }
}

#[test]
fn a_scene_is_recognised_wherever_its_beginning_is_cut() {
    let text = "# \u{e9}\n[camera]\n";
    assert_eq!(native(text.as_bytes()), Some(Format::Native));
    let within = format!("{text}# \u{e9}");
    assert_eq!(native(&within.as_bytes()[..within.len() - 1]), Some(Format::Native));
    assert_eq!(native(b"# \xe9\n[camera]\n"), Some(Format::Native));
    assert_eq!(native(b"\xff\xd8 = \n"), None);
}

#[test]
fn points_that_are_called_xyz_are_not_atoms() {
    let pts = Ok((Format::Pts, None));
    let xyz = Ok((Format::Xyz, None));
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
        assert!(recognise(b"1 2 3\n4 5 6\n", Path::new(name)).is_ok_and(|(format, _)| format != Format::Pts), "{name}");
    }
}
