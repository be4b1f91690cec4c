//! Space groups by their names: the settings of International Tables, of which each has a Hall symbol.

use super::hall;
use halfline::quote::unquoted;
use halfline::scene::Cell;
use halfline::scene::instances::Operator;

/// Number, Hermann-Mauguin symbol and Hall symbol of each setting.
const TABLE: &str = include_str!("groups.txt");

/// The most that an operator of the group may change a product of two edges, as a part of it. Cells are rounded and measured without
/// constraints; another unique axis, or rhombohedral axes, change it by more unless the cell is nearly of a higher symmetry.
const STRAIN: f64 = 0.01;

/// A setting of a space group.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Setting {
    number: f64,
    symbol: &'static str,
    hall: &'static str,
}

/// The operators of a group, and what says which it is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Group {
    pub(super) symbol: String,
    pub(super) operators: Vec<Operator>,
    /// Whether the number alone says it.
    pub(super) by_number: bool,
}

impl Group {
    /// The message about operators that the file does not list; `None` for a group that has the identity alone.
    pub(super) fn note(&self) -> Option<String> {
        let by = if self.by_number { "its number alone, of which this is the standard setting" } else { "its name" };
        let symbol = &self.symbol;
        (self.operators.len() > 1).then(|| format!("the file lists no operators; those of {symbol} follow from {by}"))
    }
}

/// The group by its Hall symbol, else by its Hermann-Mauguin symbol, else by its number; or why it has no operators.
pub(super) fn find(hall: &str, name: &str, number: Option<f64>, cell: &Cell) -> Result<Group, &'static str> {
    let by_number = hall.is_empty() && name.is_empty();
    let settings = match () {
        () if !hall.is_empty() => {
            let operators = hall::operators(&hall.replace('_', " ")).ok_or("the Hall symbol is not understood")?;
            let group = Group { symbol: unquoted(hall).to_string(), operators, by_number };
            return if fits(&group.operators, cell) { Ok(group) } else { Err(UNFIT) };
        }
        () if !name.is_empty() => named(name),
        () => numbered(number),
    };
    if settings.is_empty() {
        return Err("the group is not in International Tables under this name");
    }
    let groups = settings.iter().filter_map(|setting| {
        let operators = hall::operators(setting.hall)?;
        fits(&operators, cell).then(|| Group { symbol: setting.symbol.to_owned(), operators, by_number })
    });
    let mut groups: Vec<Group> = groups.collect();
    match groups.len() {
        0 => Err(UNFIT),
        1 => Ok(groups.remove(0)),
        _ => Err("the group has two origins; add :1 or :2 to its name"),
    }
}

const UNFIT: &str = "the cell does not have the symmetry of the group";

fn settings() -> impl Iterator<Item = Setting> {
    TABLE.lines().filter_map(|line| {
        let mut fields = line.split('\t');
        let number = fields.next()?.parse().ok()?;
        Some(Setting { number, symbol: fields.next()?, hall: fields.next()? })
    })
}

/// The settings of a Hermann-Mauguin symbol: several where it does not say the origin, or the axes.
fn named(name: &str) -> Vec<Setting> {
    let name = key(name);
    let of = |name: &str| settings().filter(|setting| setting.is_called(name)).collect::<Vec<_>>();
    let found = of(&name);
    // Symbols of cubic groups before 1983: F m 3 m.
    let bytes = name.as_bytes();
    if found.is_empty() && bytes.len() > 2 && bytes[1].is_ascii_alphabetic() && bytes[2] == b'3' {
        return of(&format!("{}-{}", &name[..2], &name[2..]));
    }
    found
}

/// The standard setting of a number: of those with other axes or another cell the first.
fn numbered(number: Option<f64>) -> Vec<Setting> {
    let mut found = settings().filter(|setting| Some(setting.number) == number).peekable();
    let first = found.peek().map(|setting| plain(setting.symbol));
    found.filter(|setting| Some(plain(setting.symbol)) == first).collect()
}

/// A symbol without its origin and axes.
fn plain(symbol: &str) -> &str {
    symbol.split_once(':').map_or(symbol, |(plain, _)| plain)
}

/// A symbol as it is compared: in lower case without blanks, brackets and underscores, with `:` before what says the origin or the axes,
/// which others write as a word (H, R, S, Z), or as the lattice H.
fn key(name: &str) -> String {
    let text = name.to_ascii_lowercase();
    let words: Vec<&str> =
        text.split(|c: char| c.is_whitespace() || c == '_').filter(|word| !word.is_empty()).collect();
    let (words, origin) = match words[..] {
        [ref rest @ .., "s"] if rest.len() > 1 => (rest, ":1"),
        [ref rest @ .., "z"] if rest.len() > 1 => (rest, ":2"),
        _ => (&words[..], ""),
    };
    let bare: String = words.concat().chars().filter(|c| !"()'\"".contains(*c)).collect();
    let bare = match bare.strip_prefix('h') {
        Some(rest) => format!("r{rest}h"),
        None => bare,
    };
    let axes =
        bare.strip_prefix('r').and_then(|rest| rest.strip_suffix(['h', 'r'])).map(|rest| rest.trim_end_matches(':'));
    match axes {
        Some(rest) => format!("r{rest}:{}", &bare[bare.len() - 1..]),
        None => bare + origin,
    }
}

impl Setting {
    /// Whether it has this symbol, in full or without the 1 of the axes of a monoclinic group, and perhaps without the origin.
    fn is_called(&self, name: &str) -> bool {
        let own = plain(self.symbol);
        let short = match own.split(' ').collect::<Vec<_>>()[..] {
            [lattice, "1", middle, "1"] => format!("{lattice}{middle}"),
            _ => own.replace(' ', ""),
        };
        let suffix = self.symbol[own.len()..].to_ascii_lowercase();
        [short, own.replace(' ', "")].iter().any(|symbol| {
            let symbol = symbol.to_ascii_lowercase();
            name == symbol || name == symbol + &suffix
        })
    }
}

/// Whether the operators keep the lengths and angles of a cell.
fn fits(operators: &[Operator], cell: &Cell) -> bool {
    let product = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
    let [a, b, c] = cell.edges;
    let metric = [a, b, c].map(|edge| [a, b, c].map(|other| product(edge, other)));
    operators.iter().all(|Operator(rows)| {
        let turned = |i: usize, j: usize| -> f64 {
            (0..3).flat_map(|k| (0..3).map(move |l| (k, l))).map(|(k, l)| rows[k][i] * metric[k][l] * rows[l][j]).sum()
        };
        (0..3).all(|i| {
            (0..3).all(|j| (turned(i, j) - metric[i][j]).abs() <= STRAIN * (metric[i][i] * metric[j][j]).sqrt())
        })
    })
}

#[cfg(test)]
mod tests;
