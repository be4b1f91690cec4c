//! Names of columns with units of length.

/// Units of length that may follow a name: `x_km`, `x (km)`.
const UNITS: [&str; 22] = [
    "m", "km", "cm", "mm", "um", "µm", "nm", "pm", "a", "å", "ang", "angstrom", "au", "pc", "kpc", "mpc", "gpc", "ly",
    "px", "mpc/h", "kpc/h", "bohr",
];

/// A name and the unit of length after it, both in lower case.
pub(super) fn split(name: &str) -> (String, String) {
    let name = name.trim().to_lowercase();
    if let Some((base, unit)) = name.split_once(['_', '(', '[', ' ']) {
        let unit = unit.trim_matches(|c: char| "_()[] ".contains(c));
        if UNITS.contains(&unit) {
            return (base.trim().to_owned(), unit.to_owned());
        }
    }
    (name, String::new())
}

/// The unit of x, y and z, where there are such columns; empty for none.
pub(crate) fn axes(names: &[String]) -> Option<String> {
    let names: Vec<_> = names.iter().map(|name| split(name)).collect();
    // Names without a unit first.
    let mut units: Vec<&String> = names.iter().filter(|(base, _)| base == "x").map(|(_, unit)| unit).collect();
    units.sort();
    let named = |axis: &str, unit: &String| names.iter().any(|(base, of)| base == axis && of == unit);
    units.into_iter().find(|unit| named("y", unit) && named("z", unit)).cloned()
}
