//! The operators of a space group by its Hall symbol (Hall, Acta Cryst. A37, 517 (1981); International Tables B, A1.4.2.3): a lattice,
//! and rotations with their axes and translations, which generate the group.

use halfline_ground::Operator;

/// The parts of an edge that translations are counted in; 1/8 and 1/12 are whole numbers of them.
const PARTS: i32 = 24;

/// The most operators of a space group in its conventional cell (International Tables A, F m -3 m).
const MOST: usize = 192;

/// A symmetry operator: x becomes `turn` x + `shift`, which is in parts of the edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Symop {
    turn: [[i32; 3]; 3],
    shift: [i32; 3],
}

const ONE: [[i32; 3]; 3] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
const INVERSION: [[i32; 3]; 3] = [[-1, 0, 0], [0, -1, 0], [0, 0, -1]];

/// Rotations about z by their order, and rotations of order 2 about a - b and a + b (table A1.4.2.4 and A1.4.2.5).
const ABOUT_Z: [(char, [[i32; 3]; 3]); 6] = [
    ('2', [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]),
    ('3', [[0, -1, 0], [1, -1, 0], [0, 0, 1]]),
    ('4', [[0, -1, 0], [1, 0, 0], [0, 0, 1]]),
    ('6', [[1, -1, 0], [1, 0, 0], [0, 0, 1]]),
    ('\'', [[0, -1, 0], [-1, 0, 0], [0, 0, -1]]),
    ('"', [[0, 1, 0], [1, 0, 0], [0, 0, -1]]),
];

/// The rotation of order 3 about a + b + c (table A1.4.2.6).
const DIAGONAL: [[i32; 3]; 3] = [[0, 0, 1], [1, 0, 0], [0, 1, 0]];

/// The translations of a lattice in parts of 24, besides the whole edges.
const LATTICES: [(char, &[[i32; 3]]); 10] = [
    ('P', &[]),
    ('A', &[[0, 12, 12]]),
    ('B', &[[12, 0, 12]]),
    ('C', &[[12, 12, 0]]),
    ('I', &[[12, 12, 12]]),
    ('F', &[[0, 12, 12], [12, 0, 12]]),
    ('R', &[[16, 8, 8]]),
    ('S', &[[8, 8, 16]]),
    ('T', &[[8, 16, 8]]),
    ('H', &[[16, 8, 0]]),
];

/// The translations of symbols in parts of 24.
const TRANSLATIONS: [(char, [i32; 3]); 8] = [
    ('a', [12, 0, 0]),
    ('b', [0, 12, 0]),
    ('c', [0, 0, 12]),
    ('n', [12, 12, 12]),
    ('u', [6, 0, 0]),
    ('v', [0, 6, 0]),
    ('w', [0, 0, 6]),
    ('d', [6, 6, 6]),
];

/// The operators of a group, the identity first; `None` for a text that is no Hall symbol, and for one with a change of axes.
pub(super) fn operators(symbol: &str) -> Option<Vec<Operator>> {
    let (symbol, origin) = match symbol.split_once('(') {
        Some((symbol, origin)) => (symbol, shift_of(origin.strip_suffix(')')?)?),
        None => (symbol, [0; 3]),
    };
    let mut words = symbol.split_whitespace();
    let lattice = words.next()?;
    let mut generators = Vec::new();
    if lattice.starts_with('-') {
        generators.push(Symop { turn: INVERSION, shift: [0; 3] });
    }
    let mut letters = lattice.trim_start_matches('-').chars();
    let letter = letters.next()?.to_ascii_uppercase();
    let (_, centred) = LATTICES.iter().find(|(known, _)| *known == letter && letters.as_str().is_empty())?;
    generators.extend(centred.iter().map(|shift| Symop { turn: ONE, shift: *shift }));
    let mut before = Before::default();
    for word in words {
        generators.push(rotation(word, &mut before)?);
    }
    let moved = generators.into_iter().map(|generator| generator.about(origin)).collect::<Vec<_>>();
    Some(group(&moved)?.iter().map(Symop::operator).collect())
}

/// The origin in twelfths, as parts.
fn shift_of(text: &str) -> Option<[i32; 3]> {
    let numbers: Vec<i32> = text.split_whitespace().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let [x, y, z] = numbers[..] else { return None };
    [x, y, z].iter().all(|x| x.abs() <= 12).then_some([x, y, z].map(|x| x * PARTS / 12))
}

/// The rotations before one.
#[derive(Default)]
struct Before {
    count: usize,
    /// The order of the last, and its axis: 0, 1, 2 for x, y, z.
    order: u32,
    axis: usize,
}

/// The operator of a symbol such as `2`, `-4`, `31`, `2yb`, `2"`, `3*`, `-1n`.
fn rotation(word: &str, before: &mut Before) -> Option<Symop> {
    let is_improper = word.starts_with('-');
    let mut letters = word.trim_start_matches('-').chars();
    let digit = letters.next()?;
    let order = digit.to_digit(10).filter(|order| [1, 2, 3, 4, 6].contains(order))?;
    let (mut kind, mut screw, mut shift) = (None, 0, [0; 3]);
    for letter in letters {
        match letter {
            'x' | 'y' | 'z' | '\'' | '"' | '*' if kind.is_none() => kind = Some(letter),
            '1'..='5' => screw = letter.to_digit(10)?,
            _ => {
                let (_, more) = TRANSLATIONS.iter().find(|(known, _)| *known == letter)?;
                shift = [0, 1, 2].map(|k| shift[k] + more[k]);
            }
        }
    }
    // Axes that are not written.
    let kind = kind.unwrap_or(match (before.count, order, before.order) {
        (_, 1, _) | (0, ..) => 'z',
        (1, 2, 2 | 4) => 'x',
        (1, 2, 3 | 6) => '\'',
        (2, 3, _) => '*',
        _ => return None,
    });
    let axis = ['x', 'y', 'z'].iter().position(|axis| *axis == kind);
    let turn = match (order, kind) {
        (1, _) => ONE,
        (3, '*') => DIAGONAL,
        (2, '\'' | '"') => about(kind, before.axis)?,
        _ => about(digit, axis?)?,
    };
    if screw > 0 {
        shift[axis?] += screw as i32 * PARTS / order as i32;
    }
    *before = Before { count: before.count + 1, order, axis: axis.unwrap_or(before.axis) };
    let turn = if is_improper { turn.map(|row| row.map(|x| -x)) } else { turn };
    Some(Symop { turn, shift }.reduced())
}

/// The rotation that is this one about z, about another axis: the axes in their cyclic order.
fn about(kind: char, axis: usize) -> Option<[[i32; 3]; 3]> {
    let (_, turn) = ABOUT_Z.iter().find(|(known, _)| *known == kind)?;
    let place = |k: usize| (k + 2 - axis) % 3;
    Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| turn[place(i)][place(j)])))
}

impl Symop {
    /// The shift within the cell.
    fn reduced(self) -> Self {
        Self { shift: self.shift.map(|x| x.rem_euclid(PARTS)), ..self }
    }

    /// This operator after another.
    fn after(&self, other: &Self) -> Self {
        let dot = |i: usize, of: [i32; 3]| (0..3).map(|k| self.turn[i][k] * of[k]).sum::<i32>();
        let column = |j: usize| [0, 1, 2].map(|k| other.turn[k][j]);
        let turn = [0, 1, 2].map(|i| [0, 1, 2].map(|j| dot(i, column(j))));
        Self { turn, shift: [0, 1, 2].map(|i| dot(i, other.shift) + self.shift[i]) }.reduced()
    }

    /// The operator with the origin moved: V S V^-1, where V adds `origin`.
    fn about(self, origin: [i32; 3]) -> Self {
        let turned = |i: usize| (0..3).map(|k| self.turn[i][k] * origin[k]).sum::<i32>();
        Self { shift: [0, 1, 2].map(|i| self.shift[i] + origin[i] - turned(i)), ..self }.reduced()
    }

    fn operator(&self) -> Operator {
        Operator([0, 1, 2].map(|i| {
            let [a, b, c] = self.turn[i].map(f64::from);
            [a, b, c, f64::from(self.shift[i]) / f64::from(PARTS)]
        }))
    }
}

/// All products of these operators, the identity first; `None` where they are more than a space group has.
fn group(generators: &[Symop]) -> Option<Vec<Symop>> {
    let mut found = vec![Symop { turn: ONE, shift: [0; 3] }];
    let mut at = 0;
    while at < found.len() {
        for generator in generators {
            let next = generator.after(&found[at]);
            if !found.contains(&next) {
                found.push(next);
            }
        }
        if found.len() > MOST {
            return None;
        }
        at += 1;
    }
    Some(found)
}
