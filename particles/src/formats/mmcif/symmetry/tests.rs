use super::*;
use crate::particles::molecule::cell;

#[test]
fn operators_are_read_as_people_write_them() {
    for (text, rows) in [
        ("x,y,z", IDENTITY.0),
        (" 'X , Y,Z' ".trim().trim_matches('\''), IDENTITY.0),
        ("-x, y+1/2, -z+1/2", [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.5], [0.0, 0.0, -1.0, 0.5]]),
        ("1/2-y,.25+x-y,z-3/4", [[0.0, -1.0, 0.0, 0.5], [1.0, -1.0, 0.0, 0.25], [0.0, 0.0, 1.0, -0.75]]),
        ("x-y,x,1*z,+1", [[1.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]),
        ("1/2x+1/2y,y,2z", [[0.5, 0.5, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]]),
    ] {
        assert_eq!(parse(text), Some(Operator(rows)), "{text}");
    }
    for bad in [
        "",
        "x,y",
        "x,y,z,2",
        "x,y,z,1,1",
        "x,,z",
        "x,y,w",
        "x,y,1/0",
        "x,y,z1",
        "x,y,--z",
        "x,y,inf",
        "x,y,1e3",
        "x;y;z",
    ] {
        assert_eq!(parse(bad), None, "{bad}");
    }
    assert!(is_isometry(&parse("-y,x-y,-z").expect("an operator")) && !is_isometry(&parse("x,x,z").expect("a sum")));
    assert!(!is_isometry(&parse("2x,y,z").expect("a sum")));
}

fn symmetry(operators: &[&str], name: &str) -> Symmetry {
    let operators = operators.iter().map(|text| ((*text).to_owned(), Spot::default())).collect();
    Symmetry { operators, name: name.into(), ..Symmetry::default() }
}

fn filled(symmetry: &Symmetry, cell: &Cell, positions: &[[f64; 3]]) -> Result<Particles> {
    let listed = Particles {
        positions: positions.to_vec(),
        elements: (1..=positions.len() as u8).collect(),
        columns: vec![
            Column { name: "copy".into(), values: vec![0.0; positions.len()] },
            Column { name: "serial".into(), values: (1..=positions.len()).map(|n| n as f64).collect() },
        ],
        ..Particles::default()
    };
    symmetry.fill(listed, cell, true, &Place::file("text"), &Watch::default())
}

/// P 63/m m c, number 194, from International Tables A: six-fold axis, mirrors, inversion; generated from three of
/// them, so that the test does not repeat a list of the program.
fn hexagonal() -> Vec<String> {
    let generators = ["x-y,x,z+1/2", "-y,-x,z", "-x,-y,-z"].map(|text| parse(text).expect("a generator"));
    let mut group = vec![IDENTITY];
    let mut at = 0;
    while at < group.len() {
        for generator in &generators {
            let mut product = generator.after(&group[at]);
            product.0.iter_mut().for_each(|row| row[3] = wrap(row[3]));
            if !group.contains(&product) {
                group.push(product);
            }
        }
        at += 1;
    }
    let sum = |row: &[f64; 4]| {
        let axis = |k: usize| match row[k] {
            1.0 => ["+x", "+y", "+z"][k],
            -1.0 => ["-x", "-y", "-z"][k],
            _ => "",
        };
        format!("{}{}{}+{}", axis(0), axis(1), axis(2), row[3])
    };
    group.iter().map(|Operator(rows)| rows.iter().map(sum).collect::<Vec<_>>().join(",")).collect()
}

#[test]
fn a_close_packed_cell_has_its_two_atoms_however_thirds_are_rounded() {
    let operators = hexagonal();
    let words: Vec<&str> = operators.iter().map(String::as_str).collect();
    assert_eq!(words.len(), 24, "the order of the point group");
    let magnesium = cell([3.2094, 3.2094, 5.2108], [90.0, 90.0, 120.0]).expect("a cell");
    for third in [1.0 / 3.0, 0.333, 0.33333, 0.3] {
        let found = filled(&symmetry(&words, "P 63/m m c"), &magnesium, &[[third, 2.0 * third, 0.25]]).expect("filled");
        // 0.3 is 0.2 ångström beside the special position, closer than any two atoms.
        assert_eq!(found.positions.len(), 2, "{third}");
        let between = [0, 1, 2].map(|k| found.positions[0][k] - found.positions[1][k]);
        assert!((between[2].abs() - 5.2108 / 2.0).abs() < 1e-12, "{between:?}");
    }
    // An atom on a general position has one image per operator, with its columns.
    let found = filled(&symmetry(&words, ""), &magnesium, &[[0.1, 0.35, 0.12], [0.0; 3]]).expect("filled");
    assert_eq!(found.positions.len(), 24 + 2);
    assert_eq!((&found.elements[..3], found.columns[1].values[1]), (&[1, 2, 1][..], 2.0), "operator by operator");
    assert_eq!((found.columns[0].values[0], found.columns[0].values[2]), (0.0, 1.0));
    let inside = |p: &[f64; 3]| (-1e-12..5.2108).contains(&p[2]);
    assert!(found.positions.iter().all(inside), "{:?}", found.positions);
}

#[test]
fn a_face_centred_cube_has_four_atoms_and_an_octant_eight() {
    let operators = ["x,y,z", "x,y+1/2,z+1/2", "x+1/2,y,z+1/2", "x+1/2,y+1/2,z", "-x,-y,-z", "1/2-x,1/2-y,-z"];
    let cube = Cell { origin: [0.0; 3], edges: [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]] };
    let found = filled(&symmetry(&operators, "F"), &cube, &[[0.0; 3]]).expect("filled");
    assert_eq!(found.positions, [[0.0; 3], [0.0, 2.0, 2.0], [2.0, 0.0, 2.0], [2.0, 2.0, 0.0]]);
    assert!(
        found.skipped.assumed[0].starts_with("6 operators of F make 4 atoms in the cell from the 1 "),
        "{:?}",
        found.skipped
    );
    // Just below zero is zero, not one.
    let found = filled(&symmetry(&operators, "F"), &cube, &[[-1e-17, 1.0, 2.0 - 1e-16]]).expect("filled");
    assert_eq!(found.positions.len(), 4);
    assert!(found.positions.iter().flatten().all(|x| (0.0..4.0).contains(x)), "{:?}", found.positions);
    // Two positions 0.4 apart are two atoms, also across a face of the cell.
    let near =
        |x: f64| filled(&symmetry(&["x,y,z", "-x,y,z"], "P"), &cube, &[[x, 0.0, 0.0]]).expect("filled").positions.len();
    assert_eq!([near(0.05), near(0.045), near(-0.045), near(0.5 + 0.045), near(0.455)], [2, 1, 1, 1, 1]);
}

#[test]
fn sites_of_several_elements_are_counted() {
    let cube = Cell { origin: [0.0; 3], edges: [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]] };
    let sites = [[0.5; 3], [0.25; 3], [0.5; 3], [1.5, -0.5, 0.5]];
    let found = filled(&symmetry(&["x,y,z", "-x,-y,-z"], "P -1"), &cube, &sites).expect("filled");
    assert_eq!((found.positions.len(), &found.elements[..]), (5, &[1, 2, 3, 4, 2][..]));
    assert!(found.skipped.assumed[0].starts_with("2 atoms have the position of another"), "{:?}", found.skipped);
}

#[test]
fn without_operators_atoms_are_as_listed() {
    let cube = Cell { origin: [0.0; 3], edges: [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]] };
    let place = [[-0.25, 1.5, 0.5]];
    for (operators, name, message) in [
        (&["x,y,z"][..], "P 1", None),
        (&[], "P 1", None),
        (&["x,y,z"], "F m -3 m", None),
        (&[], "", Some("the file has no symmetry")),
        (
            &[],
            "F d -3 m",
            Some("the file has space group F d -3 m but lists no operators, and the group has two origins"),
        ),
        (&[], "by hand", Some("the file has space group by hand but lists no operators, and the group is not in")),
    ] {
        let found = filled(&symmetry(operators, name), &cube, &place).expect("as listed");
        assert_eq!(found.positions, [[-1.0, 6.0, 2.0]], "{name}");
        let assumed = found.skipped.assumed;
        assert_eq!(assumed.len(), usize::from(message.is_some()), "{name}: {assumed:?}");
        assert!(message.is_none_or(|message| assumed[0].starts_with(message)), "{assumed:?}");
    }
    let listed = Particles { positions: place.to_vec(), elements: vec![6], ..Particles::default() };
    let found = symmetry(&["x,y,z", "-x,-y,-z"], "P -1")
        .fill(listed, &cube, false, &Place::default(), &Watch::default())
        .expect("as listed");
    assert_eq!((found.positions.len(), found.skipped.assumed.len()), (1, 0));
}

/// The operators of P 21/n from its own, and from its names.
#[test]
fn a_group_without_operators_is_filled_by_its_name() {
    let edges = [[5.0, 0.0, 0.0], [0.0, 6.0, 0.0], [-1.0, 0.0, 7.0]];
    let cell = Cell { origin: [0.0; 3], edges };
    let place = [[0.1, 0.2, 0.3], [0.5, 0.0, 0.5]];
    let own = ["x,y,z", "1/2-x,1/2+y,1/2-z", "-x,-y,-z", "1/2+x,1/2-y,1/2+z"];
    let listed = filled(&symmetry(&own, "P 21/n"), &cell, &place).expect("filled");
    let places = |found: &Particles| {
        let mut places = found.positions.iter().map(|place| place.map(|x| (1e9 * x).round())).collect::<Vec<_>>();
        places.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
        places
    };
    assert_eq!(listed.positions.len(), 6);
    for named in [
        symmetry(&[], "P 21/n"),
        symmetry(&[], "P 1 21/n 1"),
        Symmetry { hall: "-P 2yn".into(), name: "unknown".into(), ..Symmetry::default() },
    ] {
        let found = filled(&named, &cell, &place).expect("filled");
        assert_eq!(places(&found), places(&listed));
        let [note, count] = &found.skipped.assumed[..] else { panic!("{:?}", found.skipped) };
        assert!(note.starts_with("the file lists no operators; the operators of") && count.contains("make 6 atoms"));
        let copies = &found.columns[0].values;
        assert_eq!((copies[0], copies.iter().fold(0.0, |a: f64, b| a.max(*b))), (0.0, 3.0));
    }
    let number = Symmetry { number: Some(14.0), ..Symmetry::default() };
    let note = filled(&number, &cell, &place).expect("filled").skipped.assumed.remove(0);
    assert!(note.contains("P 1 21/c 1 follow from its number alone, in the standard setting"), "{note}");
}

#[test]
fn an_invalid_symmetry_operation_is_refused() {
    let cube = Cell { origin: [0.0; 3], edges: [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]] };
    for (operators, message) in [
        (vec!["x,y,z", "x,y"], "`x,y` is not a symmetry operator"),
        (vec!["2x,y,z"], "`2x,y,z` is not a symmetry operator"),
        (vec!["x,y,z"; MOST + 1], "more than 192 symmetry operators"),
    ] {
        let error = filled(&symmetry(&operators, ""), &cube, &[[0.0; 3]]).map(drop).expect_err(message).to_string();
        assert!(error.contains(message), "{error}");
    }
    // Duplicate operators have no effect.
    assert_eq!(filled(&symmetry(&["-x,-y,-z"; 3], ""), &cube, &[[0.1; 3]]).expect("filled").positions.len(), 2);
}

/// Operators of a magnetic group act on atoms without their time, with all translations of the lattice (magCIF dictionary,
/// `_space_group_symop_magn_operation.xyz`).
#[test]
fn magnetic_operators_fill_the_cell() {
    let cube = Cell { origin: [0.0; 3], edges: [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]] };
    let list = |texts: &[&str]| texts.iter().map(|text| ((*text).to_owned(), Spot::default())).collect::<Vec<_>>();
    let of = |operators: &[&str], centering: &[&str]| Symmetry {
        magnetic: [list(operators), list(centering)],
        ..Symmetry::default()
    };
    for (operators, centering, count) in [
        (&["x,y,z,+1", "-x,-y,-z,-1"][..], &[][..], 2),
        (&["x,y,z,+1", "-x,-y,-z,+1"], &["x,y,z,+1", "x+1/2,y+1/2,z+1/2,-1"], 4),
        // A grey group has each operator twice.
        (&["x,y,z,+1", "x,y,z,-1", "-x,y,-z,+1", "-x,y,-z,-1"], &["x,y,z,+1"], 2),
        (&["x,y,z,+1"], &["x,y,z,+1", "x,y+1/2,z+1/2,+1", "x+1/2,y,z+1/2,-1", "x+1/2,y+1/2,z,-1"], 4),
        (&["x,y,z"], &[], 1),
    ] {
        let found = filled(&of(operators, centering), &cube, &[[0.1, 0.2, 0.3]]).expect("filled");
        assert_eq!(found.positions.len(), count, "{operators:?} {centering:?}");
        assert!(!found.skipped.assumed.iter().any(|message| message.contains("no symmetry")), "{:?}", found.skipped);
    }
    // Plain operators come first, and each list has its limit.
    let both = Symmetry { operators: list(&["x,y,z"]), ..of(&["x,y,z,1", "-x,-y,-z,1"], &[]) };
    assert_eq!(filled(&both, &cube, &[[0.1; 3]]).expect("filled").positions.len(), 1);
    let many: Vec<String> = (0..190).map(|n| format!("x+{n}/191,y,z")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    let error =
        filled(&of(&many, &["x,y,z", "x,y+1/2,z", "x,y+1/3,z"]), &cube, &[[0.1; 3]]).map(drop).expect_err("many");
    assert!(error.to_string().contains("more than 384 operators and translations"), "{error}");
    for (symmetry, words) in [
        (
            Symmetry { magnetic_name: "P 1.1' [P 1]".into(), ..Symmetry::default() },
            "the magnetic group P 1.1' [P 1] but lists no",
        ),
        (
            Symmetry { superspace: true, ..Symmetry::default() },
            "the file lists operators of superspace, which are not applied",
        ),
    ] {
        let found = filled(&symmetry, &cube, &[[0.1; 3]]).expect("as listed");
        assert!(found.skipped.assumed.iter().any(|message| message.contains(words)), "{:?}", found.skipped);
    }
}

#[test]
fn labels_begin_with_a_symbol() {
    let of = |there: &[&str], label: &str| {
        let elements = there.iter().map(|symbol| atomic_number(symbol)).collect();
        let symmetry = Symmetry { elements, ..Symmetry::default() };
        String::from_utf8(symmetry.symbol(label.as_bytes()).to_vec()).expect("ASCII")
    };
    for (there, label, symbol) in [
        (&[][..], "Fe1", "Fe"),
        (&[], "C12A", "C"),
        (&[], "Na", "Na"),
        (&[], "CA1", "C"),
        (&["C", "H"], "CA1", "C"),
        (&["Ca", "O"], "CA1", "CA"),
        (&["Ca", "C", "O"], "CA", "CA"),
        (&["C", "H", "O"], "Co1", "C"),
        (&["Co", "C", "H"], "Co1", "Co"),
        (&["Si", "O"], "SIT1", "SI"),
        (&[], "O2W", "O"),
        (&[], "Ow", "O"),
        (&[], "Wat", "O"),
        (&[], "Zn(1)", "Zn"),
        (&[], "ZN1", "ZN"),
        (&[], "HO", "H"),
        (&[], "D1", "D"),
        (&[], "Q1", ""),
        (&[], "1", ""),
        (&[], "", ""),
    ] {
        assert_eq!(of(there, label), symbol, "{label} among {there:?}");
    }
}
