//! Vectors whose components are columns: the one name of the velocity in all formats, columns of lengths, and the common
//! name of components.

use halfline_ground::parallel;

/// The name of the velocity, and the other words for its length.
pub(crate) const VELOCITY: &str = "velocity";
const WORDS: [&str; 4] = [VELOCITY, "velo", "vel", "velocities"];

/// Its components in most formats.
const COMPONENTS: [&str; 3] = ["vx", "vy", "vz"];

/// Another word for its length, which is no name of a vector.
const SPEED: &str = "speed";

/// Whether a word means the length of the velocity.
fn is_velocity(name: &str) -> bool {
    WORDS.iter().chain([&SPEED]).any(|word| word.eq_ignore_ascii_case(name))
}

/// Adds the columns whose length each of the requested ones may be.
pub(crate) fn request(requested: &mut Vec<String>) {
    let is_fast = requested.iter().any(|name| is_velocity(name));
    let words = WORDS.iter().map(|word| (*word).to_owned());
    let of_velocity = words.chain(sets().into_iter().flatten()).filter(|_| is_fast);
    let parts: Vec<String> = requested.iter().flat_map(|name| [0, 1, 2].map(|k| component(name, k))).collect();
    for name in of_velocity.chain(parts) {
        if !requested.iter().any(|known| known.eq_ignore_ascii_case(&name)) {
            requested.push(name);
        }
    }
}

/// The names that components of the velocity have.
fn sets() -> [[String; 3]; 5] {
    let of = |word: &str| [0, 1, 2].map(|k| component(word, k));
    [COMPONENTS.map(str::to_owned), of(WORDS[0]), of(WORDS[1]), of(WORDS[2]), of(WORDS[3])]
}

/// A column by its name.
pub(super) type Named<'a> = (&'a str, &'a [f64]);

/// The columns whose length a word that is no column means: the components of the vector of this name. For the velocity,
/// the components of any of its names, or its length by another name.
pub(crate) fn parts<'a>(word: &str, columns: &[Named<'a>]) -> Option<Vec<&'a [f64]>> {
    let find = |word: &str| columns.iter().find(|(name, _)| name.eq_ignore_ascii_case(word)).map(|(_, values)| *values);
    if !is_velocity(word) {
        let parts: Vec<&[f64]> = (0..).map_while(|k| find(&component(word, k))).collect();
        return Some(parts).filter(|parts| parts.len() > 1);
    }
    if let Some(values) = WORDS.iter().find_map(|word| find(word)) {
        return Some(vec![values]);
    }
    let parts = |set: &[String; 3]| set.iter().filter_map(|name| find(name)).collect::<Vec<&[f64]>>();
    sets().iter().map(parts).find(|parts| parts.len() > 1)
}

/// The lengths of the vectors with these components; of one column its values.
pub fn length(parts: &[&[f64]]) -> Vec<f64> {
    if let [one] = parts {
        return one.to_vec();
    }
    let count = parts.first().map_or(0, |part| part.len());
    parallel::from_fn(count, |n| parts.iter().map(|part| part[n].powi(2)).sum::<f64>().sqrt())
}

/// The name of a quantity for a legend: `|velocity|` for the length of a vector whose columns have a common name, else
/// `|a, b|`; the column's name for a number. `columns` are the names of all columns of the file.
pub fn title(names: &[String], columns: &[String]) -> String {
    let has = |name: &str| columns.iter().any(|known| known.eq_ignore_ascii_case(name));
    match names {
        [one] if has(one) || !(is_velocity(one) || has(&component(one, 0))) => one.clone(),
        [one] if is_velocity(one) => format!("|{VELOCITY}|"),
        [one] => format!("|{one}|"),
        several => format!("|{}|", common(several).unwrap_or_else(|| several.join(", "))),
    }
}

/// The name of a vector's component: `forces_x`, and by its number beyond the third.
pub(crate) fn component(name: &str, k: usize) -> String {
    match ["x", "y", "z"].get(k) {
        Some(axis) => format!("{name}_{axis}"),
        None => format!("{name}_{k}"),
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

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn the_velocity_has_one_name_whatever_its_components_are_called() {
        for parts in [["vx", "vy", "vz"], ["velo_x", "velo_y", "velo_z"], ["velocity_x", "velocity_y", "velocity_z"]] {
            let columns = [(parts[0], &[2.0][..]), (parts[1], &[-3.0]), (parts[2], &[6.0])];
            let mut requested = names(&["Velocity"]);
            request(&mut requested);
            assert!(parts.iter().all(|name| requested.iter().any(|known| known == name)), "{requested:?}");
            let speed = |columns: &[Named<'_>]| super::parts("Velocity", columns).map(|parts| length(&parts));
            assert_eq!(speed(&columns), Some(vec![7.0]), "{parts:?}");
            assert_eq!(speed(&columns[..2]), Some(vec![13.0_f64.sqrt()]), "in a plane");
            for requested in [&names(&["Velocity"]), &names(&parts)] {
                assert_eq!(title(requested, &names(&parts)), "|velocity|");
            }
        }
        // A column of that name is what it says.
        let own = [("velocity", &[-1.0][..]), ("vx", &[2.0]), ("vy", &[2.0])];
        assert_eq!(title(&names(&["velocity"]), &names(&["velocity", "vx", "vy"])), "velocity");
        assert_eq!(parts("vel", &own), Some(vec![&[-1.0][..]]));
        assert_eq!(parts("velocity", &[("mass", &[1.0])]), None);
        let mut requested = names(&["mass"]);
        request(&mut requested);
        assert_eq!(requested, ["mass", "mass_x", "mass_y", "mass_z"]);
    }

    #[test]
    fn a_vector_has_a_length_by_its_name() {
        let columns = [("f_x", &[3.0][..]), ("F_y", &[4.0]), ("f_z", &[12.0]), ("g_x", &[1.0])];
        assert_eq!(parts("f", &columns).map(|parts| length(&parts)), Some(vec![13.0]));
        assert_eq!(parts("f", &columns[..2]).map(|parts| length(&parts)), Some(vec![5.0]));
        assert_eq!((parts("g", &columns), parts("h", &columns)), (None, None));
    }

    #[test]
    fn vectors_have_the_common_name_of_their_columns() {
        for (columns, expected) in [
            (&["fx", "fy", "fz"][..], "|force|"),
            (&["MU_z", "mu_x", "mu_y"], "|mu|"),
            (&["vx", "vy"], "|vx, vy|"),
            (&["x", "y", "z"], "|x, y, z|"),
            (&["a", "b", "c"], "|a, b, c|"),
            (&["mass"], "mass"),
        ] {
            assert_eq!(title(&names(columns), &[]), expected);
        }
        assert_eq!(title(&names(&["forces"]), &names(&["forces_x", "forces_y"])), "|forces|");
    }
}
