use super::*;
use crate::particles::molecule::cell;
use std::collections::BTreeMap;

fn cell_of(numbers: [f64; 6]) -> Cell {
    let [a, b, c, angles @ ..] = numbers;
    cell([a, b, c], angles).expect("a cell")
}

const CUBE: [f64; 6] = [5.0, 5.0, 5.0, 90.0, 90.0, 90.0];
const HEXAGONAL: [f64; 6] = [5.0, 5.0, 13.0, 90.0, 90.0, 120.0];

/// Numbers of operators from International Tables A, the number of points of the general position.
#[test]
fn every_setting_is_a_group_of_its_order() {
    let mut orders: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for setting in settings() {
        let operators = hall::operators(setting.hall).unwrap_or_else(|| panic!("{setting:?}"));
        // Translations of the lattice differ between settings, rotations do not.
        let centred = operators
            .iter()
            .filter(|operator| {
                operator.0.map(|row| [row[0], row[1], row[2]]) == operators[0].0.map(|row| [row[0], row[1], row[2]])
            })
            .count();
        orders.entry(setting.number as u32).or_default().push(operators.len() / centred);
        for operator in &operators {
            assert!(operators.contains(&wrapped(operator.after(operator))), "{setting:?}");
        }
    }
    assert_eq!(orders.len(), 230);
    for (number, found) in &orders {
        assert!(found.iter().all(|order| *order == found[0]), "{number}: {found:?}");
        // The order of the point group follows from the number.
        let order = match number {
            1 => 1,
            2..=9 => 2,
            10..=46 | 75..=82 => 4,
            47..=74 | 83..=122 => 8,
            123..=142 => 16,
            143..=146 => 3,
            147..=161 | 168..=174 => 6,
            162..=167 | 175..=190 => 12,
            191..=194 => 24,
            195..=199 => 12,
            200..=220 => 24,
            _ => 48,
        };
        assert_eq!(found[0], order, "{number}");
    }
}

fn wrapped(Operator(rows): Operator) -> Operator {
    Operator(rows.map(|[a, b, c, shift]| [a, b, c, (24.0 * (shift - shift.floor())).round() % 24.0 / 24.0]))
}

/// The general positions of International Tables A.
#[test]
fn operators_are_those_of_the_tables() {
    let group = |name: &str, numbers| find("", name, None, &cell_of(numbers)).expect(name).operators;
    let monoclinic = [5.0, 6.0, 7.0, 90.0, 100.0, 90.0];
    let expected = [
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.5], [0.0, 0.0, -1.0, 0.5]],
        [[-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0]],
        [[1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.5], [0.0, 0.0, 1.0, 0.5]],
    ];
    for name in ["P 1 21/c 1", "P 21/c", "P2(1)/c", "P_21/c", "p 21/c"] {
        let found = group(name, monoclinic);
        assert!(found.len() == 4 && expected.iter().all(|rows| found.contains(&Operator(*rows))), "{name}: {found:?}");
    }
    // The origin of P 31 1 2 is on an axis of order 2, at a third of c from the origin of its Hall symbol.
    let moved = [[0.0, -1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 2.0 / 3.0]];
    assert!(group("P 31 1 2", HEXAGONAL).contains(&Operator(moved)));
    // P 21/n is another cell of the same group: its glide is along a and c.
    assert!(group("P 21/n", monoclinic).contains(&Operator([
        [1.0, 0.0, 0.0, 0.5],
        [0.0, -1.0, 0.0, 0.5],
        [0.0, 0.0, 1.0, 0.5]
    ])));
    for (name, numbers, count) in [
        ("F m -3 m", CUBE, 192),
        ("F m 3 m", CUBE, 192),
        ("Fd-3m:2", CUBE, 192),
        ("F d -3 m Z", CUBE, 192),
        ("P 63/m m c", HEXAGONAL, 24),
        ("R -3 c", HEXAGONAL, 36),
        ("R -3 c H", HEXAGONAL, 36),
        ("R-3c:H", HEXAGONAL, 36),
        ("H -3 c", HEXAGONAL, 36),
        ("R -3 c", [6.0, 6.0, 6.0, 55.0, 55.0, 55.0], 12),
        ("C m c e", [5.0, 6.0, 7.0, 90.0, 90.0, 90.0], 16),
        ("P 1", [5.0, 6.0, 7.0, 80.0, 85.0, 95.0], 1),
    ] {
        assert_eq!(group(name, numbers).len(), count, "{name}");
    }
}

#[test]
fn names_mean_one_group() {
    // Symbols without their blanks do not stand for two groups.
    for setting in settings() {
        for symbol in [setting.symbol, plain(setting.symbol), &setting.symbol.replace(' ', "")] {
            let found = named(symbol);
            assert!(found.contains(&setting), "{symbol}: {found:?}");
            assert!(found.iter().all(|other| other.number == setting.number), "{symbol}: {found:?}");
            assert!(found.iter().all(|other| plain(other.symbol) == plain(setting.symbol)), "{symbol}: {found:?}");
        }
    }
}

/// Full symbols of International Tables A, and how people write them.
#[test]
fn full_symbols_are_those_of_the_short_ones() {
    let orthorhombic = [5.0, 6.0, 7.0, 90.0, 90.0, 90.0];
    let tetragonal = [5.0, 5.0, 7.0, 90.0, 90.0, 90.0];
    let monoclinic = [5.0, 6.0, 7.0, 90.0, 100.0, 90.0];
    for (full, short, numbers) in [
        ("P 1 21/c 1", "P 21/c", monoclinic),
        ("C 1 2/c 1", "C 2/c", monoclinic),
        ("P 2/m 2/m 2/m", "P m m m", orthorhombic),
        ("P 21/n 21/m 21/a", "P n m a", orthorhombic),
        ("P 21/b 21/c 21/a", "P b c a", orthorhombic),
        ("C 2/m 2/c 21/m", "C m c m", orthorhombic),
        ("C 2/m 2/c 21/e", "C m c e", orthorhombic),
        ("C 2/m 2/c 21/a", "C m c a", orthorhombic),
        ("A e m 2", "A b m 2", orthorhombic),
        ("F 2/d 2/d 2/d :2", "F d d d:2", orthorhombic),
        ("I 2/m 2/m 2/m", "I m m m", orthorhombic),
        ("P 4/m 2/m 2/m", "P 4/m m m", tetragonal),
        ("P 42/m 21/n 2/m", "P 42/m n m", tetragonal),
        ("I 41/a 2/m 2/d :1", "I 41/a m d:1", tetragonal),
        ("P 4/n 21/m 2/m :2", "P 4/n m m:2", tetragonal),
        ("P -3 1 2/m", "P -3 1 m", HEXAGONAL),
        ("P -3 2/m 1", "P -3 m 1", HEXAGONAL),
        ("R -3 2/m", "R -3 m", HEXAGONAL),
        ("R -3 2/c :H", "R -3 c:H", HEXAGONAL),
        ("P 6/m 2/m 2/m", "P 6/m m m", HEXAGONAL),
        ("P 63/m 2/m 2/c", "P 63/m m c", HEXAGONAL),
        ("P 2/m -3", "P m -3", CUBE),
        ("P 21/a -3", "P a -3", CUBE),
        ("F 2/d -3 :1", "F d -3:1", CUBE),
        ("I 21/a -3", "I a -3", CUBE),
        ("P 4/m -3 2/m", "P m -3 m", CUBE),
        ("P 42/m -3 2/n", "P m -3 n", CUBE),
        ("P 42/n -3 2/m :2", "P n -3 m:2", CUBE),
        ("F 4/m -3 2/m", "F m -3 m", CUBE),
        ("F 4/m 3 2/m", "F m -3 m", CUBE),
        ("F 4/m -3 2/c", "F m -3 c", CUBE),
        ("F 41/d -3 2/m :1", "F d -3 m:1", CUBE),
        ("F 41/d -3 2/m S", "F d -3 m:1", CUBE),
        ("F 41/d -3 2/m Z", "F d -3 m:2", CUBE),
        ("F 41/d -3 2/m origin 2", "F d -3 m:2", CUBE),
        ("I 4/m -3 2/m", "I m -3 m", CUBE),
        ("I 41/a -3 2/d", "I a -3 d", CUBE),
    ] {
        let group = |name: &str| find("", name, None, &cell_of(numbers)).unwrap_or_else(|why| panic!("{name}: {why}"));
        let expected = group(short);
        for name in [
            full.to_owned(),
            full.replace(' ', ""),
            full.replace(' ', "_"),
            full.to_lowercase(),
            full.replace("21/", "2_1/").replace("41/", "4_1/").replace("42/", "4_2/").replace("63/", "6_3/"),
            full.replace("21/", "2(1)/").replace("41/", "4(1)/").replace("63/", "6(3)/"),
            full.replace("-3", "3\u{305}"),
            full.replace('-', "\u{2212}"),
            format!("'{full}'"),
        ] {
            // A letter behind the symbol is a word of its own.
            if name.ends_with(['S', 'Z', 's', 'z']) && !name.contains(' ')
                || name.contains("origin") && !name.contains(' ')
            {
                continue;
            }
            let found = group(&name);
            assert!(found.operators.len() == expected.operators.len(), "{name}: {} of {short}", found.symbol);
            assert!(found.operators.iter().all(|operator| expected.operators.contains(operator)), "{name}");
        }
    }
}

#[test]
fn what_is_ambiguous_or_does_not_fit_is_not_assumed() {
    for (hall, name, number, numbers, reason) in [
        ("", "F d -3 m", None, CUBE, "two origins"),
        ("", "", Some(227.0), CUBE, "two origins"),
        ("", "P q", None, CUBE, "not in International Tables"),
        ("", "P q", Some(231.0), CUBE, "not in International Tables"),
        ("", "F 4/m 3 2/n", None, CUBE, "not in International Tables"),
        ("", "P 2/m -3 2/m :7", None, CUBE, "not in International Tables"),
        ("", "", Some(231.0), CUBE, "not in International Tables"),
        ("", "", Some(14.5), CUBE, "not in International Tables"),
        ("", "F m -3 m", None, [5.0, 5.0, 5.2, 90.0, 90.0, 90.0], "the cell does not have the symmetry"),
        ("", "P 63/m m c", None, CUBE, "the cell does not have the symmetry"),
        ("", "P 1 1 21/b", None, [5.0, 6.0, 7.0, 90.0, 100.0, 90.0], "the cell does not have the symmetry"),
        ("-P 4 2 3 (x+1/4,y,z)", "", None, CUBE, "Hall symbol"),
        ("P 7", "", None, CUBE, "Hall symbol"),
        ("Q 2", "", None, CUBE, "Hall symbol"),
        ("Q 2", "by hand", None, CUBE, "Hall symbol"),
        ("P 2 2 2 2", "", None, CUBE, "Hall symbol"),
        ("P 2 3", "", None, CUBE, "Hall symbol"),
        ("P 2xy", "", None, CUBE, "Hall symbol"),
        ("P 2 (1 2)", "", None, CUBE, "Hall symbol"),
        ("P 2 (1 2 99999999999)", "", None, CUBE, "Hall symbol"),
    ] {
        let found = find(hall, name, number, &cell_of(numbers)).expect_err(reason);
        assert!(found.contains(reason), "{hall}{name}: {found}");
    }
    // A name that is not known leaves the number, in its standard setting, and a note of it.
    for (hall, name, words) in
        [("", "by hand", "the name by hand is not known"), ("Q 2", "", "the name Q 2 is not known")]
    {
        let found = find(hall, name, Some(225.0), &cell_of(CUBE)).expect("a group");
        assert!(found.by_number && found.symbol == "F m -3 m" && found.operators.len() == 192, "{found:?}");
        assert!(
            found.note().is_some_and(|note| note.contains(words) && note.contains("standard setting")),
            "{:?}",
            found.note()
        );
    }
    let named = find("Q 2", "F m -3 m", Some(14.0), &cell_of(CUBE)).expect("a group");
    assert!(!named.by_number && named.note().is_some_and(|note| note.ends_with("follow from its name")));
    let standard = find("", "", Some(14.0), &cell_of([5.0, 6.0, 7.0, 90.0, 100.0, 90.0])).expect("a group");
    assert!(standard.by_number && standard.symbol == "P 1 21/c 1");
    // The Hall symbol comes before the other names.
    assert_eq!(find("P 2", "P 1", Some(225.0), &cell_of(CUBE)).expect("a group").operators.len(), 2);
}
