//! Vectors whose components are columns: the one name of the velocity in all formats, columns of lengths, and the common
//! name of components.

use super::{Column, Particles, component};
use crate::error::Result;
use crate::memory::check;
use rayon::prelude::*;

/// The name of the velocity, and the other words for its length.
pub(in crate::read) const VELOCITY: &str = "velocity";
const WORDS: [&str; 4] = [VELOCITY, "velo", "vel", "velocities"];

/// Its components in most formats.
const COMPONENTS: [&str; 3] = ["vx", "vy", "vz"];

/// Whether a word means the length of the velocity.
fn is_velocity(name: &str) -> bool {
    WORDS.iter().any(|word| word.eq_ignore_ascii_case(name))
}

/// Adds the columns that the velocity is made of to the requested ones, where its length is requested.
pub(in crate::read) fn request(wanted: &mut Vec<String>) {
    if !wanted.iter().any(|name| is_velocity(name)) {
        return;
    }
    let words = WORDS.iter().map(|word| (*word).to_owned());
    for name in words.chain(sets().into_iter().flatten()) {
        if !wanted.iter().any(|known| known.eq_ignore_ascii_case(&name)) {
            wanted.push(name);
        }
    }
}

/// The names that components of the velocity have.
fn sets() -> [[String; 3]; 5] {
    let of = |word: &str| [0, 1, 2].map(|k| component(word, k));
    [COMPONENTS.map(str::to_owned), of(WORDS[0]), of(WORDS[1]), of(WORDS[2]), of(WORDS[3])]
}

/// Adds the length of the velocity under each requested name that the file has no column of.
///
/// # Errors
/// [`Error::Limits`](crate::error::Error::Limits) where memory is short.
pub(in crate::read) fn add_lengths(particles: &mut Particles, wanted: &[String]) -> Result<()> {
    let is_there = |particles: &Particles, name: &str| {
        particles.columns.iter().any(|column| column.name.eq_ignore_ascii_case(name))
    };
    for name in wanted.iter().filter(|name| is_velocity(name)) {
        if is_there(particles, name) {
            continue;
        }
        check(8 * particles.positions.len() as u64, || format!("the column {name}"))?;
        if let Some(values) = speed(&particles.columns) {
            particles.columns.push(Column { name: name.clone(), values });
        }
    }
    Ok(())
}

/// The length of the velocity: a column of it, or of two or three components; `None` without.
pub(in crate::read) fn speed(columns: &[Column]) -> Option<Vec<f64>> {
    let find = |name: &str| columns.iter().find(|column| column.name.eq_ignore_ascii_case(name));
    if let Some(column) = WORDS.iter().find_map(|word| find(word)) {
        return Some(column.values.clone());
    }
    let parts: Vec<&Column> = sets()
        .iter()
        .map(|set| set.iter().filter_map(|name| find(name)).collect())
        .find(|parts: &Vec<&Column>| parts.len() > 1)?;
    Some(length(&parts))
}

/// The lengths of the vectors with these components.
pub(in crate::read) fn length(parts: &[&Column]) -> Vec<f64> {
    let count = parts.first().map_or(0, |part| part.values.len());
    (0..count).into_par_iter().map(|n| parts.iter().map(|part| part.values[n].powi(2)).sum::<f64>().sqrt()).collect()
}

/// The name of a quantity for a legend: `|velocity|` for the length of a vector whose columns have a common name, else
/// `|a, b|`; that of the column for a number.
pub(in crate::read) fn title(names: &[String], particles: &Particles) -> String {
    let has = |name: &str| particles.has.iter().any(|known| known.eq_ignore_ascii_case(name));
    match names {
        [one] if has(one) || !(is_velocity(one) || has(&component(one, 0))) => one.clone(),
        [one] if is_velocity(one) => format!("|{VELOCITY}|"),
        [one] => format!("|{one}|"),
        several => format!("|{}|", common(several).unwrap_or_else(|| several.join(", "))),
    }
}

/// The common name of three components that end with x, y and z in any order: `vx`, `vy`, `vz` or `velo_x`, ... are the
/// velocity, `fx`, ... the force, `mu_x`, ... `mu`.
fn common(names: &[String]) -> Option<String> {
    let mut names: Vec<String> = names.iter().map(|name| name.to_lowercase()).collect();
    names.sort_unstable();
    let stem = names[0].strip_suffix('x')?;
    let is_vector = names.len() == 3 && names[1] == format!("{stem}y") && names[2] == format!("{stem}z");
    match stem.trim_end_matches('_') {
        _ if !is_vector => None,
        "" => None,
        "v" => Some(VELOCITY.to_owned()),
        "f" => Some("force".to_owned()),
        stem if is_velocity(stem) => Some(VELOCITY.to_owned()),
        stem => Some(stem.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn particles(columns: &[(&str, f64)]) -> Particles {
        let column = |(name, value): &(&str, f64)| Column { name: (*name).to_owned(), values: vec![*value] };
        Particles {
            positions: vec![[0.0; 3]],
            has: columns.iter().map(|(name, _)| (*name).to_owned()).collect(),
            columns: columns.iter().map(column).collect(),
            ..Particles::default()
        }
    }

    #[test]
    fn the_velocity_has_one_name_whatever_its_components_are_called() {
        for names in [["vx", "vy", "vz"], ["velo_x", "velo_y", "velo_z"], ["velocity_x", "velocity_y", "velocity_z"]] {
            let mut found = particles(&[(names[0], 2.0), (names[1], -3.0), (names[2], 6.0)]);
            let mut wanted = vec!["Velocity".to_owned()];
            request(&mut wanted);
            assert!(names.iter().all(|name| wanted.iter().any(|wanted| wanted == name)), "{wanted:?}");
            add_lengths(&mut found, &["Velocity".to_owned()]).expect("memory");
            assert_eq!(found.columns[3], Column { name: "Velocity".into(), values: vec![7.0] });
            assert_eq!(title(&["Velocity".to_owned()], &found), "|velocity|");
            assert_eq!(title(&names.map(str::to_owned), &found), "|velocity|");
        }
        // A column of that name is what it says.
        let mut own = particles(&[("velocity", -1.0), ("vx", 2.0), ("vy", 2.0)]);
        add_lengths(&mut own, &["velocity".to_owned()]).expect("memory");
        assert_eq!((own.columns.len(), title(&["velocity".to_owned()], &own)), (3, "velocity".to_owned()));
        let mut none = particles(&[("mass", 1.0)]);
        add_lengths(&mut none, &["velocity".to_owned()]).expect("memory");
        assert_eq!(none.columns.len(), 1, "no velocity");
        let mut wanted = vec!["mass".to_owned()];
        request(&mut wanted);
        assert_eq!(wanted, ["mass"]);
    }

    #[test]
    fn vectors_have_the_common_name_of_their_columns() {
        let none = Particles::default();
        for (names, title_of) in [
            (&["fx", "fy", "fz"][..], "|force|"),
            (&["MU_z", "mu_x", "mu_y"], "|mu|"),
            (&["vx", "vy"], "|vx, vy|"),
            (&["x", "y", "z"], "|x, y, z|"),
            (&["a", "b", "c"], "|a, b, c|"),
            (&["mass"], "mass"),
        ] {
            let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
            assert_eq!(title(&names, &none), title_of);
        }
        assert_eq!(title(&["forces".to_owned()], &particles(&[("forces_x", 0.0), ("forces_y", 0.0)])), "|forces|");
    }
}
