//! The promise of the readers about files that people have: what other programs write and read is read, the same way by all that
//! read it, and what is not read is named with a way to it.

use crate::rng::Rng;
use crate::scenes::{CAMERA, folder, read_frame, read_spheres};
use halfline::error::Error;
use halfline_files::read::{self, Format, Keep, ParticleOptions, ReadOptions, SceneFrame};
use std::fmt::Write as _;

/// The frame of a file that `info`, a reading of all columns and a plain one read alike.
fn read_alike(name: &str, content: &[u8], options: &ReadOptions) -> Result<SceneFrame, Error> {
    let folder = folder(&[(name, content)]);
    let path = folder.path().join(name);
    let frame = read::scene(&path, options)?;
    let keeping =
        ReadOptions { particles: ParticleOptions { keep: Keep::All, ..options.particles.clone() }, ..options.clone() };
    let kept = read::scene(&path, &keeping).unwrap_or_else(|error| panic!("all columns: {error}"));
    let info = read::info(&path, options).unwrap_or_else(|error| panic!("info: {error}"));
    assert_eq!(kept.scene.spheres.centers, frame.scene.spheres.centers, "{name}");
    assert_eq!(info.spheres as usize, frame.scene.spheres.len(), "{name}");
    Ok(frame)
}

fn alike(name: &str, content: &[u8]) -> SceneFrame {
    read_alike(name, content, &ReadOptions::default())
        .unwrap_or_else(|error| panic!("{error}\n{}", String::from_utf8_lossy(content)))
}

fn selecting(text: &str) -> ReadOptions {
    ReadOptions {
        particles: ParticleOptions { select: vec![text.parse().expect("a selection")], ..Default::default() },
        ..ReadOptions::default()
    }
}

/// The problem and the mend of a file that is refused.
fn refusal(name: &str, content: &[u8], options: &ReadOptions) -> String {
    read_frame(name, content, options).map(drop).expect_err(name).to_string()
}

/// Bytes of other encodings than UTF-8.
fn bytes(rng: &mut Rng) -> Vec<u8> {
    let mut bytes: Vec<u8> = (0..rng.within(1, 12)).map(|_| rng.within(0x80, 0x100) as u8).collect();
    bytes.extend([0xe9, b' ', b'a', 0xff]);
    bytes
}

/// Text of every format with a place for bytes that nobody uses, `@`.
const COMMENTED: [(&str, &str); 24] = [
    ("a.xyz", "1\n@\nO 1 2 3\n"),
    ("a.xyz", "1\nProperties=species:S:1:pos:R:3:note:S:1 comment=\"@\"\nO 1 2 3 @\n"),
    (
        "a.pdb",
        "TITLE     @\nREMARK @\nATOM      1  O   HOH A   1       1.000   2.000   3.000  1.00  0.00           O\n",
    ),
    ("a.pdb", "ATOM      1  O   HOH A   1       1.000   2.000   3.000  1.00  0.00           O\nREMARK @\n"),
    ("a.pqr", "REMARK @\nATOM      1  O   HOH A   1       1.000   2.000   3.000 -0.5000 1.5000\n"),
    (
        "a.cif",
        "data_a\n# @\n_audit.author '@'\n_note\n;\n@\n;\nloop_\n_atom_site.id\n_atom_site.type_symbol\n\
        _atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n1 O 1 2 3 # @\n",
    ),
    ("a.gro", "@\n 1\n    1SOL     OW    1   0.100   0.200   0.300\n 0 0 0\n"),
    ("a.dump", "ITEM: UNITS\n@\nITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS id x y z name\n1 1 2 3 @\n"),
    ("a.data", "@\n\n1 atoms\n1 atom types\n\nAtoms # atomic\n\n1 1 1 2 3 # @\n"),
    ("a.data", "title\n# @\n1 atoms\n1 atom types\n\nAtoms # @\n\n1 1 1 2 3\n"),
    (
        "a.ply",
        "ply\nformat ascii 1.0\ncomment @\nobj_info @\nelement vertex 1\nproperty float x\nproperty float y\n\
        property float z\nend_header\n1 2 3\n",
    ),
    (
        "a.pcd",
        "# @\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n",
    ),
    ("a.csv", "# @\nx,y,z\n# @\n1,2,3\n"),
    ("a.csv", "// @\nx,y,z,name\n1,2,3,@\n"),
    ("a.csv", "x;y;z;@\n1;2;3;4\n"),
    ("a.tsv", "x\ty\tz\tname\n1\t2\t3\t\"@\"\n"),
    ("a.nff", "# @\nv\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 20\nresolution 8 8\ns 1 2 3 1 # @\n"),
    (
        "a.toml",
        "# @\n[camera]\neye = [0, 0, 9] # @\nat = [0, 0, 0]\nup = [0, 1, 0]\nvfov = 20\n[[sphere]]\n\
        center = [1, 2, 3]\nradius = 1\n",
    ),
    ("POSCAR", "@\n1.0\n4 0 0\n0 4 0\n0 0 4\nO\n1\nCartesian @\n1 2 3 @\n"),
    ("a.pdbqt", "REMARK @\nROOT\nATOM      1  O   HOH A   1       1.000   2.000   3.000  0.00  0.00    +0.007 OA\n"),
    // Without a name that says it.
    (
        "a",
        "# @\n[camera]\neye = [0, 0, 9]\nat = [0, 0, 0]\nup = [0, 1, 0]\nvfov = 20\n[[sphere]]\ncenter = [1, 2, 3]\nradius = 1\n",
    ),
    ("a", "1\n@\nO 1 2 3\n"),
    ("a", "# @\nx y z\n1 2 3\n"),
    (
        "a",
        "ply\ncomment @\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
        end_header\n1 2 3\n",
    ),
];

#[test]
fn text_that_nobody_uses_may_hold_any_bytes() {
    let mut rng = Rng::new(47);
    for (name, template) in COMMENTED {
        for _ in 0..4 {
            let mut content = Vec::new();
            for (n, part) in template.split('@').enumerate() {
                if n > 0 {
                    content.extend(bytes(&mut rng));
                }
                content.extend(part.as_bytes());
            }
            let frame = alike(name, &content);
            assert_eq!(frame.scene.spheres.centers, [[1.0, 2.0, 3.0]], "{name}: {content:?}");
        }
    }
    // Behind a header of text, binary points are as they are.
    let points: Vec<u8> = [1.0f32, 2.0, 3.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    for _ in 0..8 {
        let note = bytes(&mut rng);
        let ply = [
            b"ply\nformat binary_little_endian 1.0\ncomment ",
            &note[..],
            b"\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
            &points,
        ];
        let pcd = [
            b"# ",
            &note[..],
            b"\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA binary\n",
            &points,
        ];
        for (name, content) in [("a.ply", ply.concat()), ("a.pcd", pcd.concat())] {
            assert_eq!(alike(name, &content).scene.spheres.centers, [[1.0, 2.0, 3.0]], "{name}");
        }
    }
    let table = b"# d\xe9but\nx,y,z,radius\n1,2,3,1\n";
    assert_eq!(read_spheres("a.csv", table).expect("spheres").spheres.centers, [[1.0, 2.0, 3.0]]);
    // In a scene a text that is used is none.
    let scene = [CAMERA.as_bytes(), b"# d\xe9but\n[[spheres]]\nfile = 'a.csv'\nselect = \"name ", b"\xe9\"\n"].concat();
    let folder = folder(&[("a.csv", b"x,y,z,name\n1,2,3,b\n"), ("scene.toml", &scene)]);
    let error = read::scene(&folder.path().join("scene.toml"), &ReadOptions::default()).map(drop).expect_err("a text");
    assert!(error.to_string().contains("is not UTF-8 text"), "{error}");
    // NumPy writes headers in ISO 8859-1 before version 3.0.
    let header = b"{'descr': [('x', '<f4'), ('y', '<f4'), ('z', '<f4'), ('d\xe9', '<f4')], 'fortran_order': False, 'shape': (1,), }\n";
    let npy = [b"\x93NUMPY\x01\0", &(header.len() as u16).to_le_bytes()[..], header, &points, &points[..4]].concat();
    assert_eq!(alike("a.npy", &npy).scene.spheres.centers, [[1.0, 2.0, 3.0]]);
    // Behind a byte order mark too.
    for (name, content) in [("a.nff", &b"\xef\xbb\xbf\xbf"[..]), ("a.nff", b"\xef\xbb\xbfs \xe9\n")] {
        assert!(refusal(name, content, &ReadOptions::default()).contains("is not UTF-8 text"), "{content:?}");
    }
    let marked = b"\xef\xbb\xbf# d\xe9but\nx,y,z,radius\n1,2,3,1\n";
    assert_eq!(read_spheres("a.csv", marked).expect("spheres").spheres.len(), 1);
    // Words that differ stay different, and a number is none.
    let names = b"x,y,z,name\n1,2,3,\xe9\n4,5,6,\xe8\n";
    let of = |text: &str| read_frame("a.csv", names, &selecting(text)).expect("rows").scene.spheres.centers.to_vec();
    assert_eq!((of("name '\u{e9}'"), of("name '\u{e8}'")), (vec![[1.0, 2.0, 3.0]], vec![[4.0, 5.0, 6.0]]));
    assert!(refusal("a.csv", b"x,y,z\n1,\xe9,3\n", &ReadOptions::default()).contains("a.csv:2:3: y"));
}

#[test]
fn extended_xyz_has_atomic_numbers_and_coordinates() {
    let mut rng = Rng::new(48);
    let parts = [
        ("species:S:1", ["O", "H"]),
        ("pos:R:3", ["1 2 3", "4 5 -6"]),
        ("Z:I:1", ["8", "1"]),
        ("force:R:3", ["0 0 1", "0 1 0"]),
        ("tag:I:1", ["3", "4"]),
        ("numbers:I:1", ["8", "1"]),
    ];
    for _ in 0..24 {
        let mut order: Vec<usize> = vec![1, 2];
        order.extend((0..parts.len()).filter(|k| ![1, 2].contains(k) && rng.below(2) == 0));
        for k in (1..order.len()).rev() {
            order.swap(k, rng.below(k + 1));
        }
        let properties: Vec<&str> = order.iter().map(|k| parts[*k].0).collect();
        let row = |n: usize| order.iter().map(|k| parts[*k].1[n]).collect::<Vec<_>>().join(" ");
        let text = format!("2\nProperties={}\n{}\n{}\n", properties.join(":"), row(0), row(1));
        let frame = alike("a.xyz", text.as_bytes());
        assert_eq!(frame.scene.spheres.centers, [[1.0, 2.0, 3.0], [4.0, 5.0, -6.0]], "{text}");
        assert_eq!(frame.scene.spheres.radii, [1.52, 1.2], "{text}");
        for selection in ["z < 0", "element H", "atomic_number == 1"] {
            let found = read_frame("a.xyz", text.as_bytes(), &selecting(selection)).expect("an atom").scene;
            assert_eq!(found.spheres.centers, [[4.0, 5.0, -6.0]], "{selection}: {text}");
        }
    }
}

#[test]
fn records_of_pdb_may_follow_a_bare_title() {
    let atom = "ATOM      1  O   HOH A   1       1.000   2.000   3.000  1.00  0.00           O\n";
    for head in
        ["TITLE\n", "TITLE \n\n", "TITLE\nTITLE    2 WATER\n", "TITLE\nREMARK   1\n", "\nTITLE\nMODEL        1\n"]
    {
        for name in ["a.pdb", "a", "a.ent"] {
            let text = format!("{head}{atom}END\n");
            assert_eq!(alike(name, text.as_bytes()).scene.spheres.centers, [[1.0, 2.0, 3.0]], "{text}");
        }
    }
    let gromos = "TITLE\n  atoms of a run\nEND\nPOSITION\n    1 HOH   OW         1    0.1    0.2    0.3\nEND\n";
    assert!(refusal("a.pdb", gromos.as_bytes(), &ReadOptions::default()).contains("GROMOS"));
}

const CELL: &str = "_cell_length_a 4\n_cell_length_b 4\n_cell_length_c 4\n";
const ATOMS: &str =
    "loop_\n_atom_site_label\n_atom_site_fract_x\n_atom_site_fract_y\n_atom_site_fract_z\nO1 0.25 0.5 0.75\n";

#[test]
fn sites_without_coordinates_are_left_out_and_counted() {
    for missing in ["H1 ? ? ?\n", "H1 . . .\n", "H1 ? ? ?\nH2 . ? .\n"] {
        let count = missing.lines().count();
        for text in [
            format!("data_a\n{CELL}{ATOMS}{missing}"),
            format!("data_a\n{CELL}{}{missing}O1 0.25 0.5 0.75\n", ATOMS.replace("O1 0.25 0.5 0.75\n", "")),
            format!(
                "data_a\nloop_\n_atom_site.id\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n{missing}O1 1 2 3\n"
            ),
        ] {
            let frame = alike("a.cif", text.as_bytes());
            assert_eq!(frame.scene.spheres.centers, [[1.0, 2.0, 3.0]], "{text}");
            assert_eq!(frame.skipped.kinds, [("site without coordinates", count as u64)], "{text}");
            let strict = ReadOptions {
                particles: ParticleOptions { strict: true, ..Default::default() },
                ..ReadOptions::default()
            };
            assert!(refusal("a.cif", text.as_bytes(), &strict).contains("site without coordinates"));
        }
        let none = format!("data_a\n{CELL}{}{missing}", ATOMS.replace("O1 0.25 0.5 0.75\n", ""));
        assert!(refusal("a.cif", none.as_bytes(), &ReadOptions::default()).contains("without coordinates"));
    }
    let half = format!("data_a\n{CELL}{ATOMS}H1 0.5 ? 0.5\n");
    assert!(refusal("a.cif", half.as_bytes(), &ReadOptions::default()).contains("y: the atom has no position"));
}

#[test]
fn angles_of_a_cell_are_right_ones_where_none_are_given() {
    for (given, message) in [
        ("", "alpha, beta, gamma"),
        ("_cell_angle_beta 90\n", "alpha, gamma"),
        ("_cell_angle_alpha .\n_cell_angle_beta ?\n", "alpha, beta, gamma"),
        ("_cell_angle_alpha 90\n_cell_angle_beta 90\n_cell_angle_gamma 90\n", ""),
    ] {
        let frame = alike("a.cif", format!("data_a\n{CELL}{given}{ATOMS}").as_bytes());
        assert_eq!(frame.scene.spheres.centers, [[1.0, 2.0, 3.0]]);
        let note = frame.skipped.assumed.iter().find(|note| note.contains("90 degrees"));
        assert_eq!(note.is_some(), !message.is_empty(), "{:?}", frame.skipped);
        assert!(note.is_none_or(|note| note.contains(message)), "{note:?}");
    }
    let sheared = alike("a.cif", format!("data_a\n{CELL}_cell_angle_gamma 60\n{ATOMS}").as_bytes());
    assert!((sheared.scene.spheres.centers[0][0] - 2.0).abs() < 1e-12, "{:?}", sheared.scene.spheres.centers);
    assert!(
        refusal("a.cif", format!("data_a\n{ATOMS}").as_bytes(), &ReadOptions::default()).contains("_cell_length_a")
    );
}

#[test]
fn a_chemical_component_is_read() {
    let tags =
        |names: &[&str]| names.iter().fold("loop_\n".to_owned(), |text, name| text + "_chem_comp_atom." + name + "\n");
    let ccd = ["comp_id", "atom_id", "type_symbol", "charge", "model_Cartn_x", "model_Cartn_y", "model_Cartn_z"];
    let ideal = ["pdbx_model_Cartn_x_ideal", "pdbx_model_Cartn_y_ideal", "pdbx_model_Cartn_z_ideal"];
    let both = tags(&[&ccd[..], &ideal].concat());
    let ccp4 = tags(&["comp_id", "atom_id", "type_symbol", "type_energy", "charge", "x", "y", "z"]);
    let atom_site = "loop_\n_atom_site.id\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n1 7 8 9\n";
    let single = "_chem_comp_atom.comp_id ZN\n_chem_comp_atom.atom_id ZN\n_chem_comp_atom.type_symbol ZN\n\
        _chem_comp_atom.model_Cartn_x 1\n_chem_comp_atom.model_Cartn_y 2\n_chem_comp_atom.model_Cartn_z 3\n";
    for (text, centers, radius) in [
        (
            format!("data_HOH\n{both}HOH O O 0 1 2 3 9 9 9\nHOH H1 H 0 4 5 6 9 9 9\n"),
            vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]],
            1.52,
        ),
        (
            format!("data_HOH\n{both}HOH O O 0 ? ? ? 1 2 3\nHOH H1 H 0 ? ? ? 4 5 6\n"),
            vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]],
            1.52,
        ),
        (format!("data_HOH\n{both}HOH O O 0 1 2 3 9 9 9\nHOH H1 H 0 ? ? ? 9 9 9\n"), vec![[1.0, 2.0, 3.0]], 1.52),
        (
            format!(
                "global_\n_lib_name x\ndata_comp_list\nloop_\n_chem_comp.id\nHOH\ndata_comp_HOH\n{ccp4}HOH O O O 0 1 2 3\n"
            ),
            vec![[1.0, 2.0, 3.0]],
            1.52,
        ),
        (format!("data_A\n{ccp4}A O O O 0 1 2 3\ndata_B\n{ccp4}B N N N 0 4 5 6\n"), vec![[1.0, 2.0, 3.0]], 1.52),
        (format!("data_ZN\n{single}"), vec![[1.0, 2.0, 3.0]], 1.39),
        // Atoms of a structure come first, wherever they are.
        (format!("data_A\n{ccp4}A O O O 0 1 2 3\n{atom_site}"), vec![[7.0, 8.0, 9.0]], 0.5),
        (format!("data_A\n{atom_site}data_B\n{ccp4}A O O O 0 1 2 3\n"), vec![[7.0, 8.0, 9.0]], 0.5),
    ] {
        let frame = alike("a.cif", text.as_bytes());
        assert_eq!(frame.scene.spheres.centers[..], centers[..], "{text}");
        assert_eq!(frame.scene.spheres.radii[0], radius, "{text}");
        let is_reported = frame.skipped.assumed.iter().any(|warning| warning.contains("several data blocks"));
        assert_eq!(is_reported, text.contains("data_B"), "{text}");
    }
    let text = format!("data_HOH\n{both}HOH O O 0 1 2 3 9 9 9\nHOH H1 H 0 4 5 6 9 9 9\n");
    let hydrogen = read_frame("a.cif", text.as_bytes(), &selecting("name H1 and resname HOH")).expect("an atom");
    assert_eq!(hydrogen.scene.spheres.centers, [[4.0, 5.0, 6.0]]);
    let bare = tags(&["comp_id", "atom_id", "type_symbol"]);
    assert!(
        refusal("a.cif", format!("data_A\n{bare}A O O\n").as_bytes(), &ReadOptions::default()).contains("no atoms")
    );
}

#[test]
fn an_open_quote_of_cif_ends_with_its_line() {
    let angles = "_cell_angle_alpha 90\n_cell_angle_beta 90\n_cell_angle_gamma 90\n";
    for open in [
        "_audit_author_name 'David Dubbeldam\n",
        "_note \"a\n",
        "loop_\n_author\n'A B\n'C D'\n",
        "_symmetry_space_group_name_H-M 'P 1\n",
    ] {
        let frame = alike("a.cif", format!("data_a\n{open}{CELL}{angles}{ATOMS}").as_bytes());
        assert_eq!(frame.scene.spheres.centers, [[1.0, 2.0, 3.0]], "{open}");
        assert!(frame.skipped.assumed.iter().any(|note| note.contains("a quote is not closed")), "{:?}", frame.skipped);
    }
    // There it would take the coordinates.
    let atom = format!("data_a\n{CELL}{angles}{}", ATOMS.replace("O1 ", "'O1 "));
    assert!(refusal("a.cif", atom.as_bytes(), &ReadOptions::default()).contains("a quote is not closed in its line"));
}

#[test]
fn coordinates_of_clouds_may_be_in_capitals() {
    for names in ["X Y Z", "x Y z", "X Y Z Radius", "X Y Z x y z"] {
        let fields: Vec<&str> = names.split(' ').collect();
        let row = if fields.len() == 6 { "7 8 9 1 2 3" } else { "1 2 3 0.5" };
        let row: Vec<&str> = row.split(' ').take(fields.len()).collect();
        let mut ply = "ply\nformat ascii 1.0\nelement vertex 1\n".to_owned();
        fields.iter().for_each(|name| ply += &format!("property float {name}\n"));
        let ply = format!("{ply}end_header\n{}\n", row.join(" "));
        let list = |word: &str| vec![word; fields.len()].join(" ");
        let pcd = format!(
            "VERSION 0.7\nFIELDS {names}\nSIZE {}\nTYPE {}\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n{}\n",
            list("4"),
            list("F"),
            row.join(" ")
        );
        for (name, text) in [("a.ply", ply), ("a.pcd", pcd)] {
            let spheres = alike(name, text.as_bytes()).scene.spheres;
            assert_eq!(spheres.centers, [[1.0, 2.0, 3.0]], "{text}");
            assert!(!names.contains("Radius") || spheres.radii == [0.5], "{text}");
        }
    }
}

#[test]
fn points_that_compression_does_not_shorten_are_stored_as_they_are() {
    let mut rng = Rng::new(49);
    for count in [1, 7, 100] {
        let numbers: Vec<f32> = (0..3 * count).map(|_| (rng.unit() * 1e3) as f32).collect();
        let data: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let head = format!(
            "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH {count}\nHEIGHT 1\nPOINTS {count}\nDATA binary_compressed\n"
        );
        let size = (data.len() as u32).to_le_bytes();
        let frame = alike("a.pcd", &[head.as_bytes(), &size, &size, &data].concat());
        let expected = |n: usize| [0, 1, 2].map(|axis| f64::from(numbers[axis * count + n]));
        assert_eq!(frame.scene.spheres.centers[..], (0..count).map(expected).collect::<Vec<_>>()[..]);
        let cut = [head.as_bytes(), &(data.len() as u32 - 1).to_le_bytes(), &size, &data[1..]].concat();
        assert!(refusal("a.pcd", &cut, &ReadOptions::default()).contains("do not decompress"));
    }
}

#[test]
fn tables_that_look_like_a_crystal_are_tables() {
    let rows = "1 2 3\n4 5 6\n7 8 9\n1 1 2\n2 2 3\n3 3 4\n4 4 5\n";
    for head in ["x y z\n", "\"x\" \"y\" \"z\"\n", "# x y z\n", "//X Y Z\n"] {
        let frame = alike("a.txt", format!("{head}{rows}").as_bytes());
        assert_eq!(frame.scene.spheres.centers[..2], [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{head}");
    }
    // As R writes tables, with the names of rows.
    let r = "\"x\" \"y\" \"z\" \"kind\"\n\"1\" 1 2 3 \"a b\"\n\"2\" 4 5 6 \"c\"\n";
    assert_eq!(alike("a.txt", r.as_bytes()).scene.spheres.centers, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    let selected = read_frame("a.txt", r.as_bytes(), &selecting("kind 'a b'")).expect("a row").scene;
    assert_eq!(selected.spheres.centers, [[1.0, 2.0, 3.0]]);
    for named in ["\"x\",\"y\",\"z\"\n\"a\",1,2,3\n", "x y z\na 1 2 3\n", "\"id\" \"x\" \"y\" \"z\"\n\"1\" 7 1 2 3\n"] {
        assert_eq!(alike("a.csv", named.as_bytes()).scene.spheres.centers, [[1.0, 2.0, 3.0]], "{named}");
    }
    // A number too many is not the name of a row.
    for wrong in ["name,x,y,z\na,1,2,3,4\n", "\"name\",\"x\",\"y\",\"z\"\n\"a\",1,2,3,4\n", "x,y,z\n1,2,3,4\n"] {
        assert!(refusal("a.csv", wrong.as_bytes(), &ReadOptions::default()).contains("more than"), "{wrong}");
    }
    let ptx = "1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n0 0 0 0.5\n";
    for name in ["a.ptx", "a", "a.txt", "a.xyz"] {
        assert_eq!(alike(name, ptx.as_bytes()).scene.spheres.centers, [[1.0, 2.0, 3.0]], "{name}");
    }
}

/// A quoted field may have line breaks, whatever is before it and wherever the file is divided.
#[test]
fn quoted_fields_may_have_line_breaks() {
    let mut rng = Rng::new(50);
    for delimiter in [",", ";", "\t"] {
        for end in ["\n", "\r\n"] {
            let mut text = ["x", "y", "z", "\"a\n name\"", "last"].join(delimiter) + end;
            let mut centers = Vec::new();
            for n in 0..3000 {
                let name = match rng.below(6) {
                    0 => "\"one\ntwo\"",
                    1 => "\"with \"\"quotes\"\" and\n\n# a line\n1,2,3\"",
                    2 => "\"\n\"",
                    3 => "plain",
                    // A quote that nothing closes is a letter.
                    4 => "5\" wide",
                    _ => "\"plain\"",
                };
                let n = f64::from(n);
                let _ = write!(
                    text,
                    "{}{end}",
                    [n.to_string(), "2".into(), "3".into(), name.into(), "9".into()].join(delimiter)
                );
                centers.push([n, 2.0, 3.0]);
            }
            let frame = alike("a.csv", text.as_bytes());
            assert_eq!(frame.scene.spheres.centers[..], centers[..], "{delimiter:?} {end:?}");
        }
    }
    let selected = read_frame("a.csv", b"x,y,z,name\n1,2,3,\"a\nb\"\n4,5,6,\"a b\"\n", &selecting("name 'a b'"));
    assert_eq!(selected.expect("a row").scene.spheres.centers, [[4.0, 5.0, 6.0]]);
    // Places count lines of the file.
    let error = refusal("a.csv", b"x,y,z,name\n1,2,3,\"a\nb\"\n4,b,6,c\n", &ReadOptions::default());
    assert!(error.contains("a.csv:4:3: y"), "{error}");
    let error = refusal("a.csv", b"name,x,y,z\n\"a\nb\",4,b,6\n", &ReadOptions::default());
    assert!(error.contains("a.csv:3:6: y"), "{error}");
    // A field that only begins with a quote ends with its line.
    for open in ["\"5 inch", "\"a\"b"] {
        let text = format!("name,x,y,z\n{open},1,2,3\nb,4,5,6\n{open},7,8,9\n");
        let centers = alike("a.csv", text.as_bytes()).scene.spheres.centers;
        assert_eq!(centers, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]], "{open}");
    }
    assert_eq!(read_spheres("a.csv", b"x,y,z,\"radius\"\n1,2,3,1\n").expect("spheres").spheres.len(), 1);
}

#[test]
fn tables_of_scanners_are_read() {
    let named = |columns: &str| ReadOptions {
        particles: ParticleOptions {
            columns_named: columns.parse().expect("columns"),
            format: Some(Format::CSV),
            ..Default::default()
        },
        ..ReadOptions::default()
    };
    for text in
        ["//X;Y;Z;Intensity\n1;2;3;9\n4;5;6;8\n", "//X Y Z\n2\n1 2 3\n4 5 6\n", "// by hand\n//X,Y,Z\n1,2,3\n4,5,6\n"]
    {
        for name in ["a.txt", "a.csv", "a.asc"] {
            assert_eq!(
                alike(name, text.as_bytes()).scene.spheres.centers,
                [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]],
                "{text}"
            );
        }
    }
    for text in
        ["1 2 3\n4 5 6\n", "2\n1 2 3\n4 5 6\n", "1.5 2 3 9 9\n4 5 6 9 9\n", "2\n1 2 3 9 9 9 9\n4.0 5 6 9 9 9 9\n"]
    {
        let cut = text.replacen("2\n", "3\n", 1);
        let is_points = !text.contains("9 9") || text.contains("9 9 9 9");
        for name in ["a.pts", "a.xyz", "a.asc"] {
            let is_named = match name {
                "a.pts" => is_points,
                "a.xyz" => text.starts_with("1 2 3"),
                // A count before points with colours.
                _ => text.contains("9 9 9 9"),
            };
            let options = if is_named { ReadOptions::default() } else { named("x=1,y=2,z=3") };
            // With a count it may be XYZ whose comment has numbers.
            let is_xyz = name == "a.xyz" && text.starts_with("2\n");
            if !(is_named || is_xyz) {
                let error = refusal(name, text.as_bytes(), &ReadOptions::default());
                assert!(error.contains("`\u{2060}columns` x=1,y=2,z=3"), "{name}: {error}");
            }
            // What the mend says works.
            let frame = read_alike(name, text.as_bytes(), &options).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(frame.scene.spheres.centers[1], [4.0, 5.0, 6.0], "{text}");
            assert_eq!(frame.scene.spheres.len(), 2, "{text}");
            assert!(!frame.skipped.assumed.iter().any(|warning| warning.contains("alone")), "{:?}", frame.skipped);
            let frame = read_alike(name, cut.as_bytes(), &options).unwrap_or_else(|error| panic!("{error}"));
            let is_reported = frame
                .skipped
                .assumed
                .iter()
                .any(|warning| warning.contains("a") && warning.contains(":1:1: 3 stands alone"));
            assert_eq!(is_reported, text.starts_with("2\n"), "{:?}", frame.skipped);
        }
    }
}

/// The name, the type, the bytes, and the scale and the offset of an extra field.
type ExtraField<'a> = (&'a str, u8, &'a [u8], Option<[f64; 2]>);

/// A LAS file of version 1.4 and format 6 with extra bytes: types, numbers, scales and offsets as written by hand from the
/// specification.
fn las(fields: &[ExtraField<'_>]) -> Vec<u8> {
    let extra: usize = fields.iter().map(|(_, _, bytes, _)| bytes.len()).sum();
    let (head, size) = (375 + 54 + 192 * fields.len(), 30 + extra);
    let mut bytes = vec![0; head + size];
    let mut put = |at: usize, new: &[u8]| bytes[at..at + new.len()].copy_from_slice(new);
    put(0, b"LASF");
    put(24, &[1, 4]);
    put(94, &375u16.to_le_bytes());
    put(96, &(head as u32).to_le_bytes());
    put(100, &1u32.to_le_bytes());
    put(104, &[6]);
    put(105, &(size as u16).to_le_bytes());
    (0..3).for_each(|axis| put(131 + 8 * axis, &1f64.to_le_bytes()));
    put(247, &1u64.to_le_bytes());
    put(377, b"LASF_Spec");
    put(393, &4u16.to_le_bytes());
    put(395, &(192 * fields.len() as u16).to_le_bytes());
    let mut at = head + 30;
    [1i32, 2, 3].iter().enumerate().for_each(|(axis, x)| put(head + 4 * axis, &x.to_le_bytes()));
    for (n, (name, kind, value, scale)) in fields.iter().enumerate() {
        let about = 429 + 192 * n;
        // Of bytes without a meaning the options are their number.
        put(about + 2, &[*kind, if *kind == 0 { value.len() as u8 } else { scale.map_or(0, |_| 24) }]);
        put(about + 4, name.as_bytes());
        if let Some([scale, offset]) = scale {
            put(about + 112, &scale.to_le_bytes());
            put(about + 136, &offset.to_le_bytes());
        }
        put(at, value);
        at += value.len();
    }
    bytes
}

#[test]
fn extra_bytes_of_las_are_columns() {
    let content = las(&[
        ("Amplitude", 3, &1234u16.to_le_bytes(), None),
        ("unknown", 0, &[7; 3], None),
        ("Deviation", 4, &(-300i16).to_le_bytes(), Some([0.5, 10.0])),
        ("id", 6, &(-1i32).to_le_bytes(), None),
        ("distance", 10, &0.1f64.to_le_bytes(), None),
        ("Pulse width", 9, &0.5f32.to_le_bytes(), None),
        ("intensity", 1, &[200], None),
        ("pair", 13, &[1, 0, 2, 0], None),
        // Names of the fields of other formats.
        ("Red", 3, &700u16.to_le_bytes(), None),
        ("nir", 1, &[77], None),
    ]);
    assert_eq!(alike("a.las", &content).scene.spheres.centers, [[1.0, 2.0, 3.0]]);
    for selection in [
        "amplitude == 1234",
        "deviation == -140",
        "id == -1",
        "distance == 0.1",
        "pair_0 == 1 and pair_1 == 2",
        "intensity == 0",
        "red == 700 and nir == 77",
    ] {
        assert_eq!(read_frame("a.las", &content, &selecting(selection)).expect(selection).scene.spheres.len(), 1);
    }
    let folder = folder(&[("a.las", &content)]);
    let info = read::info(&folder.path().join("a.las"), &ReadOptions::default()).expect("columns");
    for (name, value) in [("Pulse width", 0.5), ("intensity", 0.0), ("intensity.1", 200.0)] {
        assert_eq!(info.columns.get(name).and_then(|column| column.max), Some(value), "{name}");
    }
    assert!(!info.columns.contains_key("unknown"));
}

/// A file whose end is cut, or is no frame, is read up to there with a warning.
#[test]
fn info_counts_the_frames_that_can_be_read() {
    let xyz = "1\n\nO 1 2 3\n";
    let gro = "t= 1\n 1\n    1SOL     OW    1   0.100   0.200   0.300\n 0 0 0\n";
    let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS id x y z\n1 1 2 3\n";
    let mut xtc = vec![];
    for n in 0..2u32 {
        let words = [&[1995, 1, n, 0][..], &[0; 9], &[1], &[0.1f32, 0.2, 0.3].map(f32::to_bits)].concat();
        xtc.extend(words.iter().flat_map(|word| word.to_be_bytes()));
    }
    let cases: [(&str, Vec<u8>, &[usize]); 4] = [
        ("a.xyz", xyz.repeat(2).into(), &[2, 3, 5, 7, 9]),
        ("a.gro", gro.repeat(2).into(), &[10, 30, 52, 56]),
        ("a.dump", dump.repeat(2).into(), &[5, 20, 40, 65, dump.len() - 4]),
        ("a.xtc", xtc, &[1, 4, 30, 67]),
    ];
    for (name, whole, cuts) in cases {
        let half = whole.len() / 2;
        let mut cases = vec![(whole.clone(), 2, false)];
        cases.extend(cuts.iter().map(|cut| (whole[..half + cut].to_vec(), 1, true)));
        if name != "a.xtc" {
            cases.push(([&whole[..], b"made by hand\n\nin a day\n"].concat(), 2, true));
        }
        for (content, frames, is_reported) in cases {
            let folder = folder(&[(name, &content)]);
            let path = folder.path().join(name);
            let info = read::info(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!((info.frames, info.spheres), (frames, 1), "{name}: {:?}", info.warnings);
            let is_found = info.warnings.iter().any(|warning| warning.contains("cannot be read"));
            assert_eq!(is_found, is_reported, "{name}: {:?}", info.warnings);
            assert_eq!(read::scene(&path, &ReadOptions::default()).expect(name).scene.spheres.len(), 1);
        }
    }
}

/// All columns are read where a picture needs none of them.
#[test]
fn columns_that_nobody_asks_for_refuse_nothing() {
    for (name, text) in [
        ("a.csv", "x,y,z,t,t,T\n1,2,3,4,5,6\n"),
        ("a.csv", "x,y,z,t\n1,2,3,n/a\n"),
        ("a.xyz", "1\nProperties=species:S:1:pos:R:3:q:R:1:Q:R:1\nO 1 2 3 4 5\n"),
        ("a.dump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS id id x y z\n1 1 1 2 3\n"),
        ("a.pcd", "FIELDS x y z i I\nSIZE 4 4 4 4 4\nTYPE F F F F F\nWIDTH 1\nPOINTS 1\nDATA ascii\n1 2 3 4 5\n"),
        ("a.data", "t\n\n1 atoms\n1 atom types\n\nAtoms # atomic\n\n1 C 1 2 3\n"),
    ] {
        assert_eq!(alike(name, text.as_bytes()).scene.spheres.centers, [[1.0, 2.0, 3.0]], "{text}");
    }
    let twice = "x,y,z,t,t\n1,2,3,4,5\n";
    assert!(refusal("a.csv", twice.as_bytes(), &selecting("t > 1")).contains("`t` occurs twice"));
}

#[test]
fn what_is_not_read_is_named_with_a_way_to_it() {
    let zip = |name: &str| {
        let mut bytes = b"PK\x03\x04\x14\0\0\0\0\0".to_vec();
        bytes.resize(26, 0);
        bytes.extend([name.len() as u8, 0, 0, 0]);
        bytes.extend(name.as_bytes());
        bytes
    };
    let tar = [&[b'a'; 257][..], b"ustar\0"].concat();
    let utf16: Vec<u8> = "\u{feff}x,y,z\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    for (content, what, mend) in [
        (b"\xfd7zXZ\0\0".to_vec(), "xz", "xz -t"),
        (b"\x28\xb5\x2f\xfd\x04".to_vec(), "Zstandard", "zstd -t"),
        (b"\x27\xb5\x2f\xfd\x04".to_vec(), "Zstandard before", "zstd -d"),
        (b"\x04\x22\x4d\x18\x04".to_vec(), "LZ4", "lz4 -d"),
        (b"7z\xbc\xaf\x27\x1c\0\x04".to_vec(), "7z", "7z x"),
        (zip("1abc.pdb"), "ZIP", "unzip"),
        (zip("[Content_Types].xml"), "ZIP", "CSV"),
        (zip("folder/"), "ZIP", "unzip"),
        (tar, "tar", "tar -xf"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n".to_vec(), "Git LFS", "git lfs pull"),
        (b"/annex/objects/SHA256E-s1--0.xyz\n".to_vec(), "git-annex", "git annex get"),
        (b"\n<!DOCTYPE HTML>\n<html>404</html>\n".to_vec(), "HTML", "download"),
        (utf16, "UTF-16", "UTF-8"),
    ] {
        for name in ["a.xyz", "a.pdb", "a.csv", "a.npz", "a.toml", "a"] {
            let error = refusal(name, &content, &ReadOptions::default());
            assert!(error.contains(what) && error.contains(mend) && error.contains(name), "{name}: {error}");
            let columns_named = "x=1,y=2,z=3".parse().expect("columns");
            let error = refusal(
                name,
                &content,
                &ReadOptions {
                    particles: ParticleOptions { columns_named, ..Default::default() },
                    ..ReadOptions::default()
                },
            );
            assert!(error.contains(what), "{name}: {error}");
        }
    }
    for name in ["a.xyz", "a.toml", "a", "a.nff", "a.csv"] {
        assert!(refusal(name, b"", &ReadOptions::default()).contains("the file is empty"), "{name}");
    }
    for content in ["\n", " \n\t\n"] {
        assert!(refusal("a", content.as_bytes(), &ReadOptions::default()).contains("the file is empty"), "{content:?}");
    }
}

#[test]
fn errors_of_numbers_that_are_none_say_how_to_write_them() {
    let skip = "skip_invalid";
    for (name, text, place, mend) in [
        ("a.csv", "x,y,z\n1,1.5D+03,3\n", ":2:3: y: `1.5D+03` is not a number", "with E, as in 1.5E+03"),
        ("a.xyz", "1\n\nO 1 2 -3d-1\n", ":3:7: z", "with E, as in -3E-1"),
        ("a.nff", "s 1.0D0 2 3 1\n", ":1:3: sphere 0: `1.0D0`", "with E, as in 1.0E0"),
        ("a.csv", "x;y;z\n1,5;2;3\n", ":2:1: x", "with a point, as in 1.5"),
        ("a.csv", "x,y,z,radius\n1,2,3,0\n", ":2:7: radius: `0` is not positive", skip),
        ("a.csv", "x,y,z,radius\n1,2,3,\n", ":2:7: radius: the field is blank", skip),
        ("a.csv", "x,y,z\n1,,3\n", ":2:3: y: the field is blank", skip),
        ("a.xyz", "1\nProperties=pos:R:3:radius:R:1\n1 2 3 0\n", ":3:7: radius: `0` is not positive", skip),
        (
            "a.dump",
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS id x y z radius\n1 1 nan 3 1\n",
            "y: `nan`",
            skip,
        ),
        (
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
            property float radius\nend_header\n1 2 3 0\n",
            ":9:7: radius",
            skip,
        ),
        (
            "a.cif",
            "data_a\nloop_\n_atom_site.id\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n1 1.0D0 2 3\n",
            ":7:3: x",
            "with E, as in 1.0E0",
        ),
    ] {
        let error = refusal(name, text.as_bytes(), &ReadOptions::default());
        assert!(error.contains(place) && error.contains(mend), "{error}");
        // Where it is said, it works.
        if mend == skip {
            let options = ReadOptions {
                particles: ParticleOptions { skip_invalid: true, ..Default::default() },
                ..ReadOptions::default()
            };
            assert_eq!(read_frame(name, text.as_bytes(), &options).expect("no row").scene.spheres.len(), 0);
        }
    }
    // There a row cannot be left out.
    let spheres = read_spheres("a.csv", b"x,y,z,radius\n1,2,3,0\n").map(drop).expect_err("a radius").to_string();
    assert!(!spheres.contains(skip), "{spheres}");
    for (name, text) in [
        ("a.csv", "x,y,z,r\n1,2,3,4\n"),
        ("a.csv", "x,y,z,Rad\n1,2,3,4\n"),
        ("a.pcd", "FIELDS x y z r\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 1\nPOINTS 1\nDATA ascii\n1 2 3 4\n"),
    ] {
        let frame = alike(name, text.as_bytes());
        assert!(frame.skipped.assumed.iter().any(|warning| warning.contains("radius=r")), "{:?}", frame.skipped);
    }
    let frame = alike("a.csv", b"x,y,z,Radii,r\n1,2,3,4,5\n");
    assert_eq!((frame.scene.spheres.radii[0], &frame.skipped.assumed[..]), (4.0, &[][..]));
    let frame = alike("a.csv", b"x,y,z,r,g,b\n1,2,3,1,0,0\n");
    assert!(!frame.skipped.assumed.iter().any(|warning| warning.contains("radius=r")), "{:?}", frame.skipped);
}
