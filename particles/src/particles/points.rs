//! The columns of points of laser scanners, which their number says: PTS, PTX, and lines of numbers that are called XYZ.

use super::column_names::ColumnNames;
use super::role::Role;

const NAMES: [(&str, Role); 7] = [
    ("x", Role::Position(0)),
    ("y", Role::Position(1)),
    ("z", Role::Position(2)),
    ("intensity", Role::Other),
    ("red", Role::Color(0)),
    ("green", Role::Color(1)),
    ("blue", Role::Color(2)),
];

/// The columns of points.
pub(crate) struct PointColumns {
    /// Names and meanings.
    pub(crate) names: Vec<(String, Role)>,
    /// The warning about numbers that are no colours.
    pub(crate) warning: Option<String>,
}

/// The names and the meanings of the columns of points whose first has these words: coordinates, perhaps an intensity, and perhaps a
/// colour. `None` for another number of words, and where one is no number. Three further numbers that are no levels of a colour,
/// such as normals, have no name, which a warning says.
pub(crate) fn columns<'a>(words: impl Iterator<Item = &'a str>) -> Option<PointColumns> {
    let numbers: Vec<f64> = words.take(NAMES.len() + 1).map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let known = match numbers.len() {
        3 | 4 | 7 => NAMES[..numbers.len()].to_vec(),
        6 => [&NAMES[..3], &NAMES[4..]].concat(),
        _ => return None,
    };
    let is_level = |x: &f64| x.fract() == 0.0 && (0.0..=65535.0).contains(x);
    let are_levels = numbers[numbers.len() - 3..].iter().all(is_level);
    let of = |(n, (name, role)): (usize, &(&str, Role))| match role {
        Role::Color(_) if !are_levels => (ColumnNames::name_of(None, n), Role::Other),
        role => ((*name).to_owned(), *role),
    };
    let names: Vec<(String, Role)> = known.iter().enumerate().map(of).collect();
    let has_others = !are_levels && numbers.len() >= 6;
    let warning = has_others.then(|| {
        let others: Vec<&str> = names[numbers.len() - 3..].iter().map(|(name, _)| name.as_str()).collect();
        let [a, b, c] = [3, 2, 1].map(|k| numbers[numbers.len() - k]);
        format!(
            "the last numbers of the first point ({a} {b} {c}) are no levels of a colour, so the points have no colours, and these \
             are the columns {}",
            others.join(", ")
        )
    });
    Some(PointColumns { names, warning })
}
