use super::*;
use halfline_ground::quote::setting::ASSEMBLY;

fn options(columns: &[&str]) -> Request {
    Request::of(columns)
}

fn read(text: &str, options: &Request) -> Result<Vec<Particles>> {
    let mut pdb = Pdb::new(Source::of_text(text), options.clone(), Dialect::Pdb);
    std::iter::from_fn(|| pdb.next().transpose()).collect()
}

fn refused(text: &str, options: &Request) -> String {
    read(text, options).map(drop).expect_err(text).to_string()
}

/// An atom's record, with the text between name and residue number and the position (x, 0, 0).
fn atom(name: &str, location: &str, chain: &str, x: f64, occupancy: f64, symbol: &str) -> String {
    format!(
        "ATOM      1 {name:4}{location:1}ALA {chain:1}   7    {x:8.3}{:8.3}{:8.3}{occupancy:6.2}{:6.2}{:10}{symbol:>2}\n",
        0.0, 0.0, 20.5, ""
    )
}

fn xs(particles: &Particles) -> Vec<f64> {
    particles.positions.iter().map(|p| p[0]).collect()
}

#[test]
fn columns_hold_what_the_format_says() {
    let text = "CRYST1   40.000   50.000   60.000  90.00  90.00  90.00 P 1           1\r\n\
        ATOM  A0000  CA AGLY B  -3A   -100.123-200.456-300.789  0.50-10.00           C1-\r\n\
        ANISOU    2  CA AGLY B  -3A      500    500    500\r\n\
        HETATM    2 FE   HEM C   9       1.5     2.      3\r\n\
        TER\r\nEND\r\n";
    let names = ["serial", "Residue", "chain", "occupancy", "bfactor", "model", "copy"];
    let frame = read(text, &options(&names)).expect("a file").remove(0);
    assert_eq!(frame.positions, [[-100.123, -200.456, -300.789], [1.5, 2.0, 3.0]]);
    assert_eq!(frame.elements, [6, 26]);
    let column = |name: &str| &frame.columns.iter().find(|column| column.name == name).expect(name).values[..];
    assert_eq!((column("serial"), column("residue")), (&[100_000.0, 2.0][..], &[-3.0, 9.0][..]));
    assert_eq!((column("chain"), column("occupancy")), (&[0.0, 1.0][..], &[0.5, 1.0][..]));
    assert!(column("bfactor")[0] == -10.0 && column("bfactor")[1].is_nan());
    assert_eq!((column("model"), frame.columns.len()), (&[1.0, 1.0][..], 6));
    assert_eq!(frame.cell.expect("a cell").edges[2], [0.0, 0.0, 60.0]);
    assert_eq!(
        frame.skipped.assumed,
        [
            "the file gives no element for 1 of 2 atoms; inferred: 1 as single ions",
            "1 of 2 atoms are alternate locations and all are shown; use `\u{2060}altloc` highest or A to show one",
        ]
    );
    assert!(!frame.has.contains(&"copy".to_owned()) && frame.has.contains(&"bfactor".to_owned()));
}

#[test]
fn hybrid_36_continues_where_digits_end() {
    for (text, number) in [
        ("99999", 99_999.0),
        ("A0000", 100_000.0),
        ("A0001", 100_001.0),
        ("ZZZZZ", 43_770_015.0),
        ("a0000", 43_770_016.0),
        ("zzzzz", 87_440_031.0),
        ("A000", 10_000.0),
        ("  -12", -12.0),
    ] {
        assert_eq!(hybrid36(text.as_bytes()), number, "{text}");
    }
    for bad in ["*****", "", "Aa000", "1a000", "A 000", " A000", "\u{fc}"] {
        assert!(hybrid36(bad.as_bytes()).is_nan(), "{bad}");
    }
}

#[test]
fn elements_follow_from_names_without_an_element_column() {
    let text = [" CA  ALA", "CA    CA", " QX  XXX"]
        .map(|name| format!("HETATM    1 {name} A   1       0.000   0.000   0.000\n"));
    let frame = read(&text.concat(), &options(&[])).expect("atoms").remove(0);
    assert_eq!((&frame.elements[..], frame.unknown.get("QX")), (&[6, 20, 0][..], Some(&1)));
    assert!(frame.skipped.assumed[0].starts_with("the file gives no element for 3 of 3 atoms"));
    // Old entries have their code and the line number there.
    let old = atom(" CA", "", "A", 0.0, 1.0, "").replace("          ", "      1TII 206");
    assert_eq!(read(&old, &options(&[])).expect("an atom")[0].elements, [6]);
}

#[test]
fn alternate_locations_are_chosen() {
    let text = [
        atom(" N", "", "A", 1.0, 1.0, "N"),
        atom(" CA", "A", "A", 2.0, 0.4, "C"),
        atom(" CB", "A", "A", 3.0, 0.5, "C"),
        atom(" CA", "B", "A", 4.0, 0.6, "C"),
        atom(" CB", "B", "A", 5.0, 0.5, "C"),
        atom(" CB", "A", "B", 6.0, 0.1, "C"),
    ]
    .concat();
    let with = |altloc: &str| {
        let options = Request { altloc: altloc.parse().expect("a choice"), ..options(&["occupancy"]) };
        read(&text, &options).expect("atoms").remove(0)
    };
    assert_eq!(xs(&with("all")), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert!(with("all").skipped.assumed[0].starts_with("5 of 6 atoms"));
    let highest = with("highest");
    assert_eq!((xs(&highest), &highest.skipped.assumed[..]), (vec![1.0, 3.0, 4.0, 6.0], &[][..]));
    assert_eq!(highest.columns[0].values, [1.0, 0.5, 0.6, 0.1]);
    assert_eq!(xs(&with("B")), [1.0, 4.0, 5.0]);
    let none = with("Z");
    assert_eq!(xs(&none), [1.0]);
    assert!(none.skipped.assumed[0].contains("none of them has the identifier `Z`"), "{:?}", none.skipped);
}

#[test]
fn models_are_frames() {
    let model = |header: &str, x: f64| format!("{header}\n{}ENDMDL\n", atom(" C", "", "A", x, 1.0, "C"));
    let text =
        ["NUMMDL    3\n", &model("MODEL        4", 1.0), &model("MODEL", 2.0), &model("MODEL        9", 3.0), "END\n"]
            .concat();
    let all = options(&["model"]);
    let frames = read(&text, &all).expect("three");
    let models: Vec<f64> = frames.iter().map(|frame| frame.columns[0].values[0]).collect();
    assert_eq!((models, xs(&frames[2])), (vec![4.0, 5.0, 9.0], vec![3.0]));
    assert!(frames[0].skipped.assumed[0].contains("the file has 3 models"), "{:?}", frames[0].skipped);
    let one = read(&text, &Request { model: Some(5), ..all.clone() }).expect("the second");
    assert_eq!((one.len(), xs(&one[0]), one[0].skipped.assumed.len()), (1, vec![2.0], 0));
    let error = refused(&text, &Request { model: Some(3), ..all.clone() });
    assert!(error.contains("no model 3") && error.contains("4, 5, 9"), "{error}");
    let mut pdb = Pdb::new(Source::of_text(&text), all.clone(), Dialect::Pdb);
    assert!(pdb.skip().expect("skipped") && pdb.skip().expect("skipped"));
    assert_eq!(xs(&pdb.next().expect("read").expect("the third")), [3.0]);
    assert!(!pdb.skip().expect("the end"));
    // Models without announced numbers, divided only by END, the last one by the end of the file.
    let bare = [1.0, 2.0].map(|x| atom(" C", "", "A", x, 1.0, "C"));
    let frames = read(&bare.join("END\n"), &options(&[])).expect("two");
    assert_eq!((frames.len(), xs(&frames[1])), (2, vec![2.0]));
    assert!(frames[0].skipped.assumed[0].contains("more than one model"), "{:?}", frames[0].skipped);
    assert!(read("REMARK nothing\n", &options(&[])).expect("nothing").is_empty());
}

const REMARK: &str = "\
REMARK 350 BIOMOLECULE: 1
REMARK 350 AUTHOR DETERMINED BIOLOGICAL UNIT: DIMERIC
REMARK 350 APPLY THE FOLLOWING TO CHAINS: A,
REMARK 350                    AND CHAINS: B
REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000
REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000
REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000
REMARK 350   BIOMT1   2 -1.000000  0.000000  0.000000      100.00000
REMARK 350   BIOMT2   2  0.000000  1.000000  0.000000        0.00000
REMARK 350   BIOMT3   2  0.000000  0.000000 -1.000000        0.00000
REMARK 350 APPLY THE FOLLOWING TO CHAINS: NULL
REMARK 350   BIOMT1   2 -1.000000  0.000000  0.000000      100.00000
REMARK 350   BIOMT2   2  0.000000  1.000000  0.000000        0.00000
REMARK 350   BIOMT3   2  0.000000  0.000000 -1.000000        0.00000
REMARK 350
REMARK 350 BIOMOLECULE: 2
REMARK 350 APPLY THE FOLLOWING TO CHAINS: C
REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000
REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000
REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000
";

#[test]
fn assemblies_are_built() {
    let atoms = [("B", 1.0), ("", 2.0), ("A", 3.0), ("C", 4.0)].map(|(chain, x)| atom(" C", "", chain, x, 1.0, "C"));
    let text = format!("{REMARK}{}", atoms.concat());
    let with = |id: &str| Request { assembly: Some(id.into()), ..options(&["copy", "chain"]) };
    let whole = read(&text, &with("1")).expect("an assembly").remove(0);
    assert_eq!(xs(&whole), [1.0, 3.0, 99.0, 97.0, 98.0]);
    assert_eq!(whole.columns[0].values, [0.0, 0.0, 1.0, 1.0, 1.0]);
    assert_eq!(whole.columns[1].values, [0.0, 2.0, 0.0, 2.0, 1.0]);
    assert_eq!(xs(&read(&text, &with("2")).expect("an assembly")[0]), [4.0]);
    let error = refused(&text, &with("3"));
    assert!(error.contains("no assembly `3`") && error.contains("the file has 1, 2"), "{error}");
    let unit = read(&text, &options(&[])).expect("as they stand").remove(0);
    assert_eq!(unit.positions.len(), 4);
    assert!(unit.skipped.assumed[0].contains(&format!("2 copies; use {ASSEMBLY} 1")), "{:?}", unit.skipped);
    for (old, new, problem) in [
        ("BIOMT2   2", "BIOMT3   2", "text:9:14: REMARK 350: found BIOMT3 of operator `2`, expected BIOMT2"),
        ("-1.000000  0.000000  0.000000      100.00000", "-1.0 0 0", "expected four numbers"),
        ("100.00000", "inf", "text:8:"),
        ("APPLY THE FOLLOWING TO CHAINS: A,", "", "text:7:14"),
        ("REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000\nATOM", "ATOM", "2 of three rows"),
    ] {
        let bad = text.replacen(old, new, 1).replace("REMARK 350                    AND CHAINS: B\n", "REMARK 350\n");
        let error = refused(&bad, &with("1"));
        assert!(error.contains(problem), "{error}");
        read(&bad, &options(&[])).expect("no assembly is requested");
    }
}

#[test]
fn errors_are_reported_with_line_and_column() {
    let good = atom(" C", "", "A", 1.0, 1.0, "C");
    for (line, place) in [
        (good.replacen("   1.000", "   one  ", 1), ":2:34: x: expected a finite number, found `one`"),
        (good.replacen("   0.000", "     NaN", 1), ":2:44: y: expected a finite number, found `NaN`"),
        (good[..40].to_owned(), ":2:39: y"),
        (good[..46].to_owned(), ":2:47: z: columns 47 to 54 are empty"),
        ("ATOM\n".to_owned(), ":2:5: x"),
        (good.replacen("   1.000", "\u{fc}\u{20ac}1.000", 1), ":2:31: x"),
        (good.replacen("1.000", "1e999", 1), ":2:34: x"),
    ] {
        let error = refused(&format!("REMARK\n{line}"), &options(&[]));
        assert!(error.contains(place), "{line}: {error}");
    }
}

#[test]
fn bytes_that_are_not_utf_8_are_accepted() {
    let good = atom(" C", "", "A", 1.0, 1.0, "C");
    let mut bytes = format!("{REMARK}{good}{good}END\n").into_bytes();
    let first = b"AUTHOR    J.M\xfcLLER\n".to_vec();
    let with = |bytes: Vec<u8>, options: &Request| {
        let mut pdb = Pdb::new(Source::of_bytes(&bytes), options.clone(), Dialect::Pdb);
        pdb.next()
    };
    let plain = with([first, bytes.clone()].concat(), &options(&[])).expect("read").expect("a model");
    assert_eq!(plain.positions.len(), 2);
    let all = Request { assembly: Some("1".into()), altloc: Altloc::Highest, ..options(&["serial", "residue"]) };
    for at in 0..bytes.len() {
        for part in [&bytes[..at], &bytes[at..]] {
            let _read = (with(part.to_vec(), &all), with(part.to_vec(), &options(&[])));
        }
    }
    let mut seed = 1_u64;
    for _ in 0..3000 {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let at = (seed >> 33) as usize % bytes.len();
        let old = bytes[at];
        bytes[at] = (seed >> 20) as u8;
        // It is read or refused, without a panic.
        let _read = (with(bytes.clone(), &all), with(bytes.clone(), &options(&[])));
        bytes[at] = if seed & 7 == 0 { bytes[at] } else { old };
    }
}

fn read_as(dialect: Dialect, text: &str, options: &Request) -> Result<Vec<Particles>> {
    let mut pdb = Pdb::new(Source::of_text(text), options.clone(), dialect);
    std::iter::from_fn(|| pdb.next().transpose()).collect()
}

#[test]
fn autodock_types_give_elements() {
    let row = |name: &str, charge: &str, kind: &str| {
        format!("ATOM      1 {name:<4} UNL A   1      31.770  31.020  29.720  0.00  0.00    {charge}{kind}\n")
    };
    let text = [
        row(" C1", "+0.007", " A "),
        row(" H9", " 0.292", " HD"),
        row(" O1", "-0.507", " OA"),
        row(" N1", "-0.507", " NA"),
        row("NA", " 1.000", " Na"),
        row("CL1", "-0.507", " Cl"),
        row("ZN", " 2.000", " Zn"),
        row(" S", "-0.100", " SA"),
        row(" C2", "-0.100", " C"),
    ];
    let frame = read_as(Dialect::Pdbqt, &text.concat(), &options(&["charge", "serial"])).expect("atoms").remove(0);
    assert_eq!(frame.elements, [6, 1, 8, 7, 11, 17, 30, 16, 6]);
    assert_eq!(frame.columns[0].values[..3], [0.007, 0.292, -0.507]);
    // The charge is in the columns of the segment.
    let segid = read_as(Dialect::Pdbqt, &text.concat(), &options(&["segid"])).expect("atoms").remove(0);
    assert!(segid.columns.is_empty() && !segid.has.contains(&"segid".to_owned()), "{:?}", segid.has);
    assert!(frame.skipped.assumed.is_empty(), "{:?}", frame.skipped);
}

#[test]
fn radii_and_charges_of_pqr_are_read_with_and_without_columns() {
    let text = "REMARK   1 PQR\n\
        ATOM      1  N    MET     1     -11.921   26.307   10.410 -0.3000 1.8500\n\
        ATOM   2  CA  MET A   1     -11.5   26.0   10.0  0.2  2.0\n\
        HETATM99999  H1  WAT B  -7A   -100.123-200.456-300.789  0.4170 0.0000\n\
        HETATM100000 CL   CL     9       1.0 2.0 3.0 -1.0 1.9 CL\nTER\nEND\n";
    let frame = read_as(Dialect::Pqr, text, &options(&["charge", "serial", "residue", "chain", "icode"]))
        .expect("atoms")
        .remove(0);
    assert_eq!(frame.elements, [7, 6, 1, 17]);
    assert_eq!(frame.positions[0], [-11.921, 26.307, 10.41]);
    assert_eq!(frame.positions[2], [-100.123, -200.456, -300.789]);
    assert!(frame.radii[2].is_nan());
    assert_eq!([frame.radii[0], frame.radii[1], frame.radii[3]], [1.85, 2.0, 1.9]);
    let column = |name: &str| &frame.columns.iter().find(|column| column.name == name).expect(name).values[..];
    assert_eq!(column("charge"), [-0.3, 0.2, 0.417, -1.0]);
    assert_eq!(column("serial"), [1.0, 2.0, 99999.0, 100000.0]);
    assert_eq!((column("residue"), column("chain")), (&[1.0, 1.0, -7.0, 9.0][..], &[0.0, 1.0, 2.0, 0.0][..]));
    let icodes = |frame: &Particles| -> Vec<String> {
        let column = frame.columns.iter().find(|column| column.name == "icode").expect("icode");
        column.values.iter().map(|number| frame.labels["icode"][*number as usize].clone()).collect()
    };
    assert_eq!(icodes(&frame), ["", "", "A", ""]);
    let spaced = "ATOM 1 N MET A 52A 1.0 2.0 3.0 0.5 1.5\nATOM 2 N MET A 52 B 1.0 2.0 3.0 0.5 1.5\n";
    let frame = read_as(Dialect::Pqr, spaced, &options(&["icode"])).expect("atoms").remove(0);
    assert_eq!(icodes(&frame), ["A", "B"]);
    for (line, message) in [
        (
            "ATOM      1  N    MET     1     -11.921   26.307   10.410\n",
            "text:1:58: radius: expected charge and radius",
        ),
        (
            "ATOM      1  N    MET     1     -11.921   26.307   10.410 1.0 -2.0\n",
            "text:1:63: radius: `-2.0` is negative",
        ),
        ("ATOM      1  N    MET     1     -11.921   26.307   nan    1.0 2.0\n", "x: `-11.921` overruns its columns"),
        ("ATOM\n", "x: columns 31 to 38 are empty"),
    ] {
        let error = read_as(Dialect::Pqr, line, &options(&[])).map(drop).expect_err(line).to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn coordinates_that_overrun_their_columns_are_refused() {
    let at = |from: usize, numbers: &str| format!("{:30}{}{numbers}", "ATOM      1  CA  ALA A   1", " ".repeat(from));
    for (numbers, axis) in [
        ("31256.96532685.06460403.930", "x"),
        ("31256.965  32.064  60.930  1.00", "x"),
        ("  12.34532685.06460403.930", "y"),
        ("  12.345  32.06412345.678  1.00", "z"),
        ("-1256.965  32.064  60.930  1.00", "x"),
        ("123456.782345.678 345.678", "x"),
    ] {
        let error = read(&at(0, numbers), &Request::default()).map(drop).expect_err(numbers).to_string();
        assert!(error.contains("text:1:") && error.contains(&format!(": {axis}: ")), "{numbers}: {error}");
    }
    for (numbers, position) in [
        ("1234.5671234.5671234.567100.00", [1234.567; 3]),
        ("-123.456-123.456-123.456 -1.00", [-123.456; 3]),
        ("   1.5     2.25    3.0", [1.5, 2.25, 3.0]),
    ] {
        let found = read(&at(0, numbers), &Request::default()).expect(numbers).remove(0);
        assert_eq!(found.positions, [position], "{numbers}");
    }
}
