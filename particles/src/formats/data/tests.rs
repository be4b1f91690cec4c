use super::*;
use halfline_ground::Cell;

fn read(text: &str, columns: &[&str]) -> Result<Particles> {
    super::read(Source::of_text(text), &Request::of(columns))
}

const HEAD: &str = "by hand\n\n2 atoms # so many\n2 atom types\n0 2 xlo xhi\n-1 3 ylo yhi\n0 5 zlo zhi\n";

#[test]
fn sections_are_read_and_passed_over() {
    let text = format!(
        "{HEAD}0.5 0 -1 xy xz yz\n\nPair Coeffs # lj\n\n1 1 1\n2 1 1\n\nMasses\n\n2 15.9994 # O\n1 1.008\n\n\
         Atoms # full\n\n7 1 2 -0.8 1 2 3 0 0 1\n\n3 1 1 0.4 4 5 6 0 0 0\n\nVelocities\n\n3 0 0 9\n7 0 0 8\n\n\
         Bonds\n\n1 1 7 3\n"
    );
    let found = read(&text, &["q", "vz"]).expect("a file");
    assert_eq!((&found.positions[..], &found.elements[..]), (&[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]][..], &[8, 1][..]));
    let cell = Cell { origin: [0.0, -1.0, 0.0], edges: [[2.0, 0.0, 0.0], [0.5, 4.0, 0.0], [0.0, -1.0, 5.0]] };
    assert_eq!(found.cell, Some(cell));
    let column = |name: &str| &found.columns.iter().find(|c| c.name == name).expect(name).values[..];
    assert_eq!((column("q"), column("vz")), (&[-0.8, 0.4][..], &[8.0, 9.0][..]), "velocities by the atoms' numbers");
    // All columns, as a list of them takes.
    let all = read(&text, &["*"]).expect("a file");
    let names: Vec<&str> = all.columns.iter().map(|column| &column.name[..]).collect();
    assert!(["q", "ix", "vx", "vy", "vz"].iter().all(|name| names.contains(name)), "{names:?}");
    assert_eq!(found.skipped.assumed.len(), 1, "{:?}", found.skipped);
    assert!(found.skipped.assumed[0].contains("2 O, 1 H"), "{:?}", found.skipped);
}

#[test]
fn image_flags_behind_the_columns_are_columns_if_they_are_requested() {
    let file = |heading: &str, rows: &str| format!("{HEAD}\nAtoms{heading}\n\n{rows}\n");
    let rows = "7 1 1 2 3 0 -1 2 # a\n3 2 4 5 6 1 0 0";
    for heading in ["", " # atomic"] {
        let found = read(&file(heading, rows), &["ix", "iy", "iz"]).expect("flags");
        let columns = |n: usize| found.columns.iter().map(|column| column.values[n]).collect::<Vec<_>>();
        assert_eq!((columns(0), columns(1)), (vec![0.0, -1.0, 2.0], vec![1.0, 0.0, 0.0]));
    }
    assert!(read(&file(" # atomic", rows), &["id"]).expect("no flags").has.iter().all(|name| name != "ix"));
    // What a hybrid has are no flags, and two numbers more are of another style.
    assert!(read(&file(" # hybrid", rows), &["ix"]).expect("no flags").columns.is_empty());
    let error = read(&file(" # atomic", "7 1 1 2 3 0 -1\n3 2 4 5 6 1 0"), &["ix"]).map(drop).expect_err("7 columns");
    assert!(error.to_string().contains("the style atomic has 5 columns, or 8 with image flags, not 7"), "{error}");
    let error = read(&file(" # atomic", "7 1 1 2 3 0 -1 2\n3 2 4 5 6"), &["ix"]).map(drop).expect_err("no flags");
    assert!(error.to_string().contains(":12:10: ix: expected 8 fields, found 5"), "{error}");
}

#[test]
fn styles_are_named_or_follow_from_the_columns() {
    let file = |heading: &str, row: &str| format!("{HEAD}\n{heading}\n\n{row}\n{row}\n");
    for (heading, row, assumed) in [
        ("Atoms # sphere", "1 1 3 0.1 1 2 3", 0),
        ("Atoms # dipole", "1 1 0.5 1 2 3 9 9 9", 0),
        ("Atoms # hybrid sphere", "1 1 1 2 3 3 1", 0),
        ("Atoms # hybrid/kk charge sphere/kk by hand", "1 1 1 2 3 -0.5 3 1 0 0 0", 0),
        ("Atoms # hybrid", "1 1 1 2 3 3 1 9 9", 0),
        ("Atoms", "1 1 1 2 3", 1),
        ("Atoms", "1 1 1 2 3 0 -1 0", 1),
        ("Atoms", "1 1 1 1.0 2 3", 1),
        ("Atoms", "1 1 0.5 1 2 3 0 0 0", 1),
        ("Atoms", "1 1 1 0.5 1 2 3", 1),
    ] {
        let found = read(&file(heading, row), &[]).unwrap_or_else(|e| panic!("{heading} {row}: {e}"));
        assert_eq!((found.positions[1], found.skipped.assumed.len()), ([1.0, 2.0, 3.0], assumed), "{heading} {row}");
        assert_eq!(found.radii, if heading.contains("sphere") { vec![1.5; 2] } else { vec![] }, "{heading}");
    }
    let general = file("Atoms # atomic", "1 1 1 2 3").replace("0 2 xlo xhi", "1 2 3 avec\n4 5 6 bvec\n7 8 9 cvec");
    let cell = read(&general, &[]).expect("a file").cell.expect("a cell");
    assert_eq!((cell.edges[1], cell.origin), ([4.0, 5.0, 6.0], [0.0; 3]));
}

#[test]
fn labels_and_reduced_masses() {
    let labelled = format!("{HEAD}\nMasses\n\nFe 55.845\nC 12.011\n\nAtoms # atomic\n\n1 C 1 2 3\n2 Fe 1 2 3\n");
    assert_eq!(read(&labelled, &[]).expect("a file").elements, [6, 26]);
    let found = read(&labelled, &["type"]).expect("a column");
    assert_eq!(
        (&found.columns[0].values[..], &found.labels["type"][..]),
        (&[0.0, 1.0][..], &["C".into(), "Fe".into()][..])
    );
    let reduced = format!("{HEAD}\nMasses\n\n1 1\n2 2\n\nAtoms # atomic\n\n1 1 1 2 3\n2 2 1 2 3\n");
    assert!(read(&reduced, &[]).expect("a file").elements.is_empty());
    let lj = reduced.replace("2 2\n\nAtoms", "2 12.011\n\nAtoms").replace("by hand", "LAMMPS, units = lj");
    assert!(read(&lj, &[]).expect("a file").elements.is_empty());
}

/// The columns of each style of the manual, named behind `Atoms` and by the option: the coordinates are the last or, in some, before others.
#[test]
fn every_style_of_the_manual_is_read() {
    for (style, before, after, columns) in [
        ("amoeba", "7 1 0.5", "", &["mol", "q"][..]),
        ("angle", "7 1", "", &["mol"]),
        ("apip", "1", "", &[]),
        ("atomic", "1", "", &[]),
        ("body", "1 0 4.5", "", &["bodyflag", "mass"]),
        ("bond", "7 1", "", &["mol"]),
        ("bpm/sphere", "7 1 3 0.1", "", &["mol", "density"]),
        ("charge", "1 -1", "", &["q"]),
        ("dielectric", "1 -1", " 0 0 1 2 3 4 5 6", &["q", "curvature"]),
        ("dipole", "1 -1", " 1 2 3", &["q", "muz"]),
        ("dpd", "1 300", "", &["theta"]),
        ("edpd", "1 300 2", "", &["edpd_temp", "edpd_cv"]),
        ("electron", "1 -1 1 0.5", "", &["q", "espin", "eradius"]),
        ("ellipsoid", "1 0 2.5", "", &["ellipsoidflag", "density"]),
        ("full", "7 1 0.5", "", &["mol", "q"]),
        ("line", "7 1 0 2.5", "", &["mol", "lineflag"]),
        ("mdpd", "1 2.5", "", &["rho"]),
        ("mesont", "7 1 2 3 4 5 6", "", &["mol", "buckling"]),
        ("molecular", "7 1", "", &["mol"]),
        ("oxdna", "1", "", &[]),
        ("peri", "1 2.5 3.5", "", &["volume", "density"]),
        ("rheo", "1 0 2.5", "", &["status", "rho"]),
        ("rheo/thermal", "1 0 2.5 9", "", &["status", "rho", "energy"]),
        ("smd", "1 7 2 3 4 5 1.5 2.5 3.5", "", &["mol", "volume", "mass", "kradius", "cradius", "z0"]),
        ("sph", "1 2.5 3 4", "", &["rho", "esph", "cv"]),
        ("sphere", "1 3 0.1", "", &["density"]),
        ("spin", "1", " 1 0 0 2", &["spx", "sp"]),
        ("tdpd", "1", " 1 2 3", &[]),
        ("template", "1 7 0 0", "", &["mol", "template"]),
        ("tri", "7 1 0 2.5", "", &["mol", "triangleflag"]),
        ("wavepacket", "1 -1 1 0.5 3 0.25 0.75", "", &["q", "eradius", "etag", "cs_im"]),
        ("hybrid sphere wavepacket", "1", " 3 0.1 -1 1 0.5 3 0.25 0.75", &["density", "cs_im"]),
    ] {
        let rows = format!("1 {before} 4 5 6{after}\n2 {before} 7 8 9{after}\n");
        let given = Request { atom_style: Some(style.parse().expect(style)), ..Request::of(columns) };
        for (heading, request) in [(format!("Atoms # {style}"), &Request::of(columns)), ("Atoms".into(), &given)] {
            let text = format!("{HEAD}\n{heading}\n\n{rows}");
            let found = super::read(Source::of_text(&text), request).unwrap_or_else(|error| panic!("{style}: {error}"));
            assert_eq!(found.positions, [[4.0, 5.0, 6.0], [7.0, 8.0, 9.0]], "{style}");
            let names: Vec<&str> = found.columns.iter().map(|column| &column.name[..]).collect();
            assert!(columns.iter().all(|column| names.contains(column)), "{style}: {names:?}");
        }
    }
}

/// LAMMPS takes the style from its input, so that people write what they like there.
#[test]
fn a_comment_that_is_no_style_is_a_comment() {
    for comment in ["so many", "made by a script", "by moltemplate full", "id type x y z", "atomic/kk", "1"] {
        let text = format!("{HEAD}\nAtoms # {comment}\n\n1 1 1 2 3\n2 1 4 5 6\n");
        let found = read(&text, &[]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(found.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{comment}");
        let is_reported =
            found.skipped.assumed.iter().any(|warning| warning.contains(&format!("`{comment}` is no atom style")));
        assert_eq!(is_reported, comment != "atomic/kk", "{:?}", found.skipped);
    }
}

#[test]
fn errors_are_reported_with_line_and_column() {
    let file = |sections: &str| format!("{HEAD}\n{sections}");
    for (text, message) in [
        (file("Atoms # atomic\n\n1 1 1 2 3\n"), "the file ends after 1 of 2 lines of Atoms"),
        (file("Atoms # atomic\n\n1 1 1 2 3\n\nVelocities\n"), ":13:11: Atoms: the section ends after 1 of 2 lines"),
        (file("Atoms # atomic\n\n1 1 1 2 3\n2 1 1 2 3\n3 1 1 2 3\n"), ":13:1: count: expected 2 atoms, found 3"),
        (file("Masses\n\n1 1\n2 2\nFe 3\n\nAtoms\n"), ":13:1: count: expected 2 atom types, found 3"),
        (
            file("Atoms # atomic\n\n1.7 1 1 2 3\n2 1 1 2 3\n\nVelocities\n\n1 1 1 1\n2 1 1 1\n"),
            ":11:1: id: `1.7` is not a whole number; use a whole number such as 7",
        ),
        (
            file("Atoms # atomic\n\n1 1 1 2 3\n2 1 1 2 3\n\nVelocities\n\n2 1 1 1\n1 1 1 1\n3 1 1 1\n\nBonds\n"),
            ":18:1: count: expected 2 atoms, found 3",
        ),
        ("t\n\n0 atoms\n\nAtoms\n\n1 1 1 2 3\n".into(), ":7:1: count: expected 0 atoms, found 1"),
        ("t\n\n9999999999 atoms\n\nAtoms\n\n1 1 1 2 3\n".into(), "more than 32-bit ids"),
        (file("Atoms # atomic\n\n1 1 1 2 3\n2 1 1 b 3\n"), ":12:7: y: `b`"),
        (file("Atoms # molecular\n\n1 1 1 0.5 1 2 3\n"), ":11:1: Atoms: the style molecular has 6 columns, or 9"),
        (
            file("Atoms # by hand\n\n1 1 0.5 2.5 1 2 3\n"),
            ":11:1: Atoms: the style of atoms with 7 columns is not known, and `by hand`",
        ),
        (file("Atoms # fancy\n\n1 1 1 2 3\n"), ":9:1: Atoms: `fancy` is no known atom style"),
        (file("Atoms # Full\n\n1 1 1 0.5 1 2 3\n"), ":9:1: Atoms: `Full` is no known atom style"),
        (
            file("Atoms # sphere/gpu\n\n1 1 1 2 3\n"),
            "set the style with `\u{2060}atom_style`, which takes the columns too",
        ),
        (
            file("Atoms\n\n1 1 0.5 2.5 1 2 3\n"),
            "is not known; set it with `\u{2060}atom_style`, or write one of these behind",
        ),
        (file("Atoms # sphere\n\n1 1 0 0.1 1 2 3\n"), ":11:5: diameter: `0` is not positive"),
        (file("Velocities\n\n"), "comes before Atoms"),
        (file("Masses\n\n1\n"), ":11:1: Masses"),
        (file("Masses\n\n1 -1\n"), ":11:3: mass"),
        (file("Bonds\n\n1 1 1 1\n"), "the section Atoms is missing"),
        ("title\n\nx atoms\n".into(), ":3:1: header"),
        ("title\n".into(), "the number of atoms is not known"),
    ] {
        let error = read(&text, &["vx"]).map(drop).expect_err(&text).to_string();
        assert!(error.contains(message), "{error}");
    }
}

/// The columns of hybrids by the example of LAMMPS's description of read_data.
#[test]
fn a_style_that_is_given_comes_before_that_of_the_file() {
    let file = |heading: &str, row: &str| format!("{HEAD}\nAtoms{heading}\n\n{row}\n{row}\n");
    let read = |text: &str, style: &str, columns: &[&str]| {
        let request = Request { atom_style: Some(style.parse().expect(style)), ..Request::of(columns) };
        super::read(Source::of_text(text), &request)
    };
    for (heading, style, row, columns, values) in [
        (" # atomic", "charge", "1 1 -0.5 1 2 3", &["q"][..], &[-0.5][..]),
        (" # by hand", "full", "1 7 1 -0.5 1 2 3 0 0 0", &["mol", "q"], &[7.0, -0.5]),
        ("", "dpd/kk", "1 1 0.25 1 2 3", &["theta"], &[0.25]),
        ("", "hybrid charge sphere", "1 1 1 2 3 -0.5 4 9", &["q", "density"], &[-0.5, 9.0]),
        ("", "hybrid,dipole,full", "1 1 1 2 3 -0.5 6 7 8 4", &["q", "muz", "mol"], &[-0.5, 8.0, 4.0]),
        (" # hybrid", "id type q x y z heat", "1 1 -0.5 1 2 3 300", &["q", "heat"], &[-0.5, 300.0]),
    ] {
        let found = read(&file(heading, row), style, columns).unwrap_or_else(|error| panic!("{style}: {error}"));
        assert_eq!(found.positions, [[1.0, 2.0, 3.0]; 2], "{style}");
        assert!(found.columns.iter().map(|column| column.values[1]).eq(values.iter().copied()), "{style}");
        assert!(found.skipped.assumed.is_empty(), "{:?}", found.skipped);
    }
    let error = read(&file("", "1 1 1 2 3"), "full", &[]).map(drop).expect_err("5 columns").to_string();
    assert!(error.contains("the style full has 7 columns, or 10 with image flags, not 5"), "{error}");
    for wrong in ["", "fancy", "Full", "hybrid fancy", "full charge", "id type x y", "type id x y z", "id type x y z x"]
    {
        let error = wrong.parse::<AtomStyle>().expect_err(wrong).to_string();
        assert!(error.contains("is no atom style of LAMMPS; use one of amoeba, angle, apip, atomic"), "{error}");
    }
}
