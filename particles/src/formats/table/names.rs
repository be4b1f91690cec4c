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

/// Names that ParaView gives to the coordinates of points in CSV files, in lower case; the second are from its
/// spreadsheet (docs.paraview.org/en/latest/UsersGuide/savingResults.html).
const POINTS: [[&str; 3]; 2] = [["points:0", "points:1", "points:2"], ["points_0", "points_1", "points_2"]];

/// The names of the columns x, y and z of a table.
pub(crate) struct Axes {
    /// The unit of length after the names; empty for none.
    pub(super) unit: String,
    /// Names other than x, y and z, from ParaView.
    points: Option<[&'static str; 3]>,
}

impl Axes {
    /// The columns named x, y and z with this unit; some of them may be missing.
    pub(super) fn of_unit(unit: String) -> Self {
        Self { unit, points: None }
    }

    /// The axis of a column: 0, 1 or 2; `None` for other columns.
    pub(super) fn of(&self, name: &str) -> Option<usize> {
        if let Some(points) = self.points {
            let name = name.trim().to_lowercase();
            return points.iter().position(|point| *point == name);
        }
        let (base, unit) = split(name);
        ["x", "y", "z"].iter().position(|axis| *axis == base).filter(|_| unit == self.unit)
    }
}

/// The columns x, y and z, where there are such columns; else the columns of ParaView.
pub(crate) fn axes(names: &[String]) -> Option<Axes> {
    let parts: Vec<_> = names.iter().map(|name| split(name)).collect();
    // Names without a unit first.
    let mut units: Vec<&String> = parts.iter().filter(|(base, _)| base == "x").map(|(_, unit)| unit).collect();
    units.sort();
    let named = |axis: &str, unit: &String| parts.iter().any(|(base, of)| base == axis && of == unit);
    if let Some(unit) = units.into_iter().find(|unit| named("y", unit) && named("z", unit)) {
        return Some(Axes { unit: unit.clone(), points: None });
    }
    let has = |point: &str| names.iter().any(|name| name.trim().eq_ignore_ascii_case(point));
    let points = POINTS.into_iter().find(|points| points.iter().all(|point| has(point)))?;
    Some(Axes { unit: String::new(), points: Some(points) })
}
