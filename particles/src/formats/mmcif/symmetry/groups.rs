//! Space groups by their names: the settings of International Tables, each with a Hall symbol.

use super::hall;
use halfline_ground::Cell;
use halfline_ground::Operator;
use halfline_ground::quote::unquoted;

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
    /// Whether its number says it, where the file has no name that is known.
    pub(super) by_number: bool,
    /// A name of the file that is not known.
    pub(super) unknown: Option<String>,
}

impl Group {
    /// The message about operators that the file does not list; `None` for a group that has the identity alone.
    pub(super) fn note(&self) -> Option<String> {
        let symbol = &self.symbol;
        let by = match (self.by_number, &self.unknown) {
            (false, _) => "its name".to_owned(),
            (true, None) => "its number alone, in the standard setting".to_owned(),
            (true, Some(name)) => {
                format!("its number, in the standard setting, since the name {name} is not known")
            }
        };
        (self.operators.len() > 1)
            .then(|| format!("the file lists no operators; the operators of {symbol} follow from {by}"))
    }
}

/// The group by its Hall symbol, else by its Hermann-Mauguin symbol, else by its number; or why it has no operators.
pub(super) fn find(hall: &str, name: &str, number: Option<f64>, cell: &Cell) -> Result<Group, &'static str> {
    let unknown = [name, hall].into_iter().find(|name| !name.is_empty()).map(|name| unquoted(name).to_string());
    let (settings, by_number) = match named(name) {
        _ if !hall.is_empty()
            && let Some(operators) = hall::operators(&hall.replace('_', " ")) =>
        {
            let group = Group { symbol: unquoted(hall).to_string(), operators, by_number: false, unknown: None };
            return if fits(&group.operators, cell) { Ok(group) } else { Err(UNFIT) };
        }
        found if name.is_empty() || found.is_empty() => (numbered(number), true),
        found => (found, false),
    };
    if settings.is_empty() {
        return Err(match hall {
            "" => "the group is not in International Tables under this name",
            _ => "the Hall symbol is not understood",
        });
    }
    let groups = settings.iter().filter_map(|setting| {
        let operators = hall::operators(setting.hall)?;
        let symbol = setting.symbol.to_owned();
        fits(&operators, cell).then(|| Group { symbol, operators, by_number, unknown: unknown.clone() })
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
    first(|setting| setting.is_called(&name))
}

/// The standard setting of a number.
fn numbered(number: Option<f64>) -> Vec<Setting> {
    first(|setting| Some(setting.number) == number)
}

/// Of such settings those with the symbol of the first, which is the standard one: others have other axes or another cell, or a glide e by
/// its other name, which has another origin.
fn first(is_match: impl Fn(&Setting) -> bool) -> Vec<Setting> {
    let mut found = settings().filter(is_match).peekable();
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
    // A bar above the digit before it, and signs that look like a minus.
    let mut text = String::new();
    for letter in name.chars() {
        match letter {
            '\u{304}' | '\u{305}' => text.insert(text.char_indices().next_back().map_or(0, |(at, _)| at), '-'),
            '\u{2010}'..='\u{2015}' | '\u{2212}' => text.push('-'),
            '(' | ')' | '\'' | '"' => {}
            letter => text.push(letter.to_ascii_lowercase()),
        }
    }
    let words: Vec<&str> =
        text.split(|c: char| c.is_whitespace() || c == '_').filter(|word| !word.is_empty()).collect();
    let (words, origin) = match words[..] {
        [ref rest @ .., "s"] if rest.len() > 1 => (rest, ":1"),
        [ref rest @ .., "z"] if rest.len() > 1 => (rest, ":2"),
        [ref rest @ .., ":" | "origin", "1"] if rest.len() > 1 => (rest, ":1"),
        [ref rest @ .., ":" | "origin", "2"] if rest.len() > 1 => (rest, ":2"),
        _ => (&words[..], ""),
    };
    let bare = words.concat();
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
    /// Whether it has this symbol, short or full, with or without the 1 of the axes of a monoclinic group, and perhaps without the origin.
    fn is_called(&self, name: &str) -> bool {
        let own = plain(self.symbol);
        if !name.get(..1).is_some_and(|lattice| own[..1].eq_ignore_ascii_case(lattice)) {
            return false;
        }
        let (name, origin) = name.split_at(name.find(':').unwrap_or(name.len()));
        if !origin.is_empty() && origin != self.symbol[own.len()..].to_ascii_lowercase() {
            return false;
        }
        let parts: Vec<&str> = own.split(' ').collect();
        let is_spelled = |parts: &[&str]| {
            let mut rests = vec![name];
            for (k, part) in parts.iter().enumerate() {
                let spellings = self.spellings(k, &part.to_ascii_lowercase());
                rests = rests
                    .iter()
                    .flat_map(|rest| spellings.iter().filter_map(|own| rest.strip_prefix(&own[..])))
                    .collect();
            }
            rests.contains(&"")
        };
        let is_short = matches!(parts[..], [_, "1", _, "1"]) && is_spelled(&[parts[0], parts[2]]);
        is_short || is_spelled(&parts)
    }

    /// The spellings of a part of the symbol. The full symbol has the axis before a plane across it, where the short one has the plane
    /// alone: `F 4/m -3 2/m`. Until 1983 cubic groups had 3 for -3, and until 1992 a glide e along two edges had the name of one
    /// (International Tables A, 1.4 and 2.1.3.4).
    fn spellings(&self, k: usize, part: &str) -> Vec<String> {
        let is_cubic = self.number >= 195.0;
        let axes: &[&str] = match (k, part) {
            (0, _) => &[],
            (2, "-3") if is_cubic => return vec!["-3".into(), "3".into()],
            (1, "a" | "b" | "c" | "d" | "m" | "n") if is_cubic => &["2/", "21/", "4/", "41/", "42/"],
            (_, "a" | "b" | "c" | "d" | "e" | "m" | "n") if self.number >= 16.0 => &["2/", "21/"],
            _ => &[],
        };
        let is_double =
            [39.0, 41.0, 64.0, 67.0, 68.0].contains(&self.number) && ["a", "b", "c"].contains(&part) && k > 0;
        let planes = [part, "e"].into_iter().take(1 + usize::from(is_double));
        planes.flat_map(|plane| [""].iter().chain(axes).map(move |axis| format!("{axis}{plane}"))).collect()
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
