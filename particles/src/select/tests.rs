use super::evaluate::Evaluator;
use super::selection::Selection;
use crate::particles::frame::{Column, Particles};
use halfline_ground::error::Result;

/// Ten atoms on the x axis: two residues of a protein, a ligand without a number for one charge, and two waters.
fn atoms() -> Particles {
    let names = ["N", "CA", "C", "N", "CA", "O1", "FE", "OW", "HW1", "OW"];
    let residues = ["ALA", "ALA", "ALA", "GLY", "GLY", "HEM", "HEM", "HOH", "HOH", "HOH"];
    let mut atoms = Particles {
        positions: (0..10).map(|n| [f64::from(n), 0.0, 0.0]).collect(),
        elements: vec![7, 6, 6, 7, 6, 8, 26, 8, 1, 8],
        ..Particles::default()
    };
    for (name, values) in [("name", names), ("resname", residues)] {
        let mut labels: Vec<String> = Vec::new();
        let mut number = |value: &str| match labels.iter().position(|label| label == value) {
            Some(at) => at as f64,
            None => {
                labels.push(value.to_owned());
                (labels.len() - 1) as f64
            }
        };
        let values = values.map(&mut number).to_vec();
        atoms.columns.push(Column { name: name.into(), values });
        atoms.labels.insert(name.into(), labels);
    }
    let numbers = [1.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 5.0];
    let charges = [0.5, -0.5, 0.0, 0.5, 0.25, f64::NAN, 2.0, -1.0, 0.5, -1.0];
    atoms.columns.push(Column { name: "residue".into(), values: numbers.to_vec() });
    atoms.columns.push(Column { name: "charge".into(), values: charges.to_vec() });
    atoms.has = atoms.columns.iter().map(|column| column.name.clone()).collect();
    atoms
}

/// The indices that an expression selects, and its notes.
fn select(text: &str) -> Result<(Vec<usize>, Vec<String>)> {
    let (atoms, selection) = (atoms(), text.parse::<Selection>()?);
    let mut evaluator = Evaluator::new(&atoms, &selection);
    let mask = evaluator.mask()?;
    let notes = selection.remarks().into_iter().chain(evaluator.notes).map(|note| note.to_string()).collect();
    Ok(((0..10).filter(|n| mask[*n]).collect(), notes))
}

#[test]
fn expressions_select_the_atoms_that_they_name() {
    for (text, expected) in [
        ("all", &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9][..]),
        ("none", &[]),
        ("protein", &[0, 1, 2, 3, 4]),
        ("backbone and not name N", &[1, 2, 4]),
        ("water or name FE", &[6, 7, 8, 9]),
        ("hydrogen", &[8]),
        ("name C* O?", &[1, 2, 4, 5, 7, 9]),
        ("name \"C*\"", &[1, 2, 4]),
        ("name [!CHNO]*", &[6]),
        ("charge!=0.5", &[1, 2, 4, 6, 7, 9]),
        ("resid 2:4", &[3, 4, 5, 6, 7, 8]),
        ("resid 1 4 to 5", &[0, 1, 2, 7, 8, 9]),
        ("element fe N", &[0, 3, 6]),
        ("charge < 0", &[1, 7, 9]),
        ("charge<=0.25 and x>=2", &[2, 4, 7, 9]),
        ("0 > charge", &[1, 7, 9]),
        ("prop abs charge == 0.5", &[0, 1, 3, 8]),
        ("charge != 0.5", &[1, 2, 4, 6, 7, 9]),
        ("index 0 9", &[0, 9]),
        ("bynum 1:2", &[0, 1]),
        ("within 1 of (resname HEM)", &[4, 5, 6, 7]),
        ("around 1 resname HEM", &[4, 7]),
        ("exwithin 1 of name FE", &[5, 7]),
        ("byres name O1", &[5, 6]),
        ("same residue as (name CA and x < 2)", &[0, 1, 2]),
        ("same resname as index 9", &[7, 8, 9]),
        ("not (protein or water)", &[5, 6]),
        ("not not name FE", &[6]),
        ("name FE && resname HEM || name N", &[0, 3, 6]),
        // From left to right.
        ("name N or name CA and resname GLY", &[3, 4]),
    ] {
        let (found, _) = select(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(found, expected, "{text}");
    }
}

/// Their length is limited, not their number; a parenthesis between quotes is a letter.
#[test]
fn long_lists_are_read() {
    let groups = vec!["(name FE)"; 1000].join(" or ");
    let quoted = format!("name FE {}", "'(' ".repeat(1000));
    for text in [groups, quoted] {
        assert_eq!(select(&text).expect("a long list").0, [6]);
    }
    let (_, notes) = select(&format!("resid {}", "77 ".repeat(20_000))).expect("numbers");
    assert_eq!(notes.len(), 1);
    assert!(notes[0].contains("nor 19999 other values; the file has 1 to 5") && notes[0].len() < 400, "{notes:?}");
}

#[test]
fn words_that_select_nothing_are_reported_with_what_the_file_has() {
    for (text, message) in [
        (
            "resname HEC or protein",
            "`resname HEC` in the selection `resname HEC or protein`: no particle has it; the file has ALA, GLY, HEM, HOH",
        ),
        ("resid 7:9", "no particle has it; the file has 1 to 5"),
        ("element Zn", "the file has H, C, N, O, Fe"),
        ("nucleic", "no particle is selected by it; the residues of the file are ALA"),
        ("name N or name CA and resname GLY", "VMD combines `and` first"),
        ("within 3 of name N and protein", "`within` applies to the next word only"),
        ("not (not nucleic)", "no particle is selected by it"),
        ("not protein or nucleic", "no particle is selected by it"),
    ] {
        let (_, notes) = select(text).expect(text);
        assert!(notes.iter().any(|note| note.contains(message)), "{text}: {notes:?}");
    }
    for quiet in ["within 3 of (name N) and protein", "name N and name CA or resname GLY", "not resname HEM"]
        .into_iter()
        .chain(["not nucleic", "protein and not (resname HEC or element Zn)", "not resid 7:9"])
    {
        assert_eq!(select(quiet).expect(quiet).1, Vec::<String>::new(), "{quiet}");
    }
}

#[test]
fn invalid_expressions_are_refused_at_their_place() {
    let deep = format!("{}name N{}", "(".repeat(200), ")".repeat(200));
    for (text, message) in [
        ("", "a column or a word such as `protein` at column 1"),
        ("protin", "at column 1"),
        ("name", "at column 1"),
        ("(protein", "expected `)`, `and` or `or` at column 9"),
        ("protein and", "at column 12"),
        ("protein water", "`and`, `or` or the end at column 9"),
        ("protein)", "at column 8"),
        ("within x of name N", "a distance of 0 or more at column 7"),
        ("within -1 of name N", "a distance of 0 or more"),
        ("within 5 name N", "`of`"),
        ("same residue name N", "`as`"),
        ("charge <", "a number or a name"),
        ("prop charge 5", "a comparison"),
        ("chain A", "the file has no chain"),
        ("bfactor < 3", "the file has no bfactor"),
        ("charge C*", "charge is a number in this file"),
        ("charge < high", "charge is a number in this file"),
        ("name < N", "which are not compared"),
        ("name 5 to x and", "at column"),
        (&deep, "128 parts within each other at column"),
        (&"byres ".repeat(9000), "128 parts within each other"),
        (&"same resname as ".repeat(3000), "128 parts within each other"),
        (&"around 1 ".repeat(5000), "128 parts within each other"),
        (&"within 1 of ".repeat(5000), "128 parts within each other"),
        (&format!("name {}", "*a".repeat(30_000)), "more than 1024 asterisks"),
    ] {
        let error = select(text).map(drop).expect_err(text).to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
    let error = select("bfactor < 3").map(drop).expect_err("no such column").to_string();
    assert!(error.contains("the file has index, x, y, z, element, name, resname, residue, charge"), "{error}");
}
