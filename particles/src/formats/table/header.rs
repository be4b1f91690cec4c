//! The header of a table: the names of its columns and their meaning, from the file or from the caller.

use super::fields::{declared_delimiter, delimiter, delimiters, fields, next};
use super::names::{Axes, axes, split};
use crate::lines::{Lines, comment};
use crate::particles::column_names::ColumnNames;
use crate::particles::meaning::{FieldKind, Meanings, NamedField, meanings};
use crate::particles::points;
use crate::particles::role::Role;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::setting::COLUMNS;
use halfline_ground::quote::{list, quote};
use std::io::BufRead;

/// The columns of a table.
pub(super) struct TableHeader {
    pub(super) names: Vec<(String, Role)>,
    pub(super) delimiter: u8,
    /// Whether a line above says the delimiter.
    pub(super) is_declared: bool,
    /// Whether it is a comment.
    pub(super) comment: bool,
    pub(super) place: Place,
    /// Warnings: the meaning assumed for columns without a header, and columns that are not taken.
    pub(super) assumed: Vec<String>,
    /// A number alone in its line above, and where it is: the number of rows, as scanners write it.
    pub(super) counted: Option<(Place, u64)>,
}

/// The columns of a table without a header and without given meanings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Bare {
    /// x, y, z and perhaps a radius.
    Spheres,
    /// x, y, z, perhaps an intensity, and perhaps red, green and blue.
    Points,
}

/// The remedy for a table whose coordinates are not named.
fn name_them() -> String {
    format!("add a header that names x, y and z, such as x,y,z,radius, or name the columns with {COLUMNS} x=1,y=2,z=3")
}

impl TableHeader {
    /// Finds the header, which may be a comment or missing, and whether the current line is a row. `given` has the meaning
    /// of columns whose names do not say it, and `kind` the columns of a table without a header.
    ///
    /// # Errors
    /// [`Error::Scene`] for a table without named coordinates, and without a column that is given.
    pub(super) fn find<R: BufRead>(lines: &mut Lines<R>, given: &ColumnNames, kind: Bare) -> Result<(Self, bool)> {
        let (mut above, mut counted, mut declared) = (None, None, None);
        while lines.advance()? {
            let text = lines.text().trim_start();
            if text.is_empty() {
                continue;
            }
            if let (None, Ok(rows)) = (&counted, text.trim_end().parse()) {
                counted = Some((lines.place(0), rows));
                continue;
            }
            if let (None, None, Some(delimiter)) = (&above, declared, declared_delimiter(text)) {
                declared = Some(delimiter);
                lines.set_records(delimiter);
                continue;
            }
            let comment = comment(text);
            let start = lines.text().len() - text.len() + comment;
            let found = Self::of(lines, start, given, declared);
            if comment > 0 {
                above = found?.ok().or(above);
                continue;
            }
            // A table by numbers has a header only if its first line has no numbers there.
            let bare = if given.are_numbers() { Self::bare(lines, given, kind, declared) } else { None };
            let (header, ahead) = match (found?, bare, above) {
                (_, Some(bare), Some(above)) if above.names.len() == bare.names.len() => (above, true),
                (Ok(header), None, _) => {
                    lines.set_records(header.delimiter);
                    (header, next(lines)?)
                }
                (_, None, Some(above)) => (above, true),
                (_, Some(bare), None) => (bare, true),
                (_, Some(bare), Some(above)) => (if given.is_empty() { above } else { bare }, true),
                (Err(error), None, None) => return Err(error),
            };
            return Ok((Self { counted, ..header }, ahead));
        }
        let problem = "the columns x, y and z are missing";
        above
            .map(|header| (Self { counted, ..header }, false))
            .ok_or_else(|| Error::scene(lines.file().named("header"), problem, name_them()))
    }

    /// The columns of a table whose first row is the current line; `None` for a line that is no row.
    fn bare<R: BufRead>(lines: &Lines<R>, given: &ColumnNames, kind: Bare, declared: Option<u8>) -> Option<Self> {
        let delimiter = declared.unwrap_or_else(|| delimiter(lines.text()));
        let numbers: Vec<bool> = fields(lines, 0, delimiter).map(|word| word.text.parse::<f64>().is_ok()).collect();
        let place = lines.place(0);
        let header = |roles: Vec<Option<Role>>, assumed| {
            let name =
                |(n, role): (usize, &Option<Role>)| (ColumnNames::name_of(*role, n), role.unwrap_or(Role::Other));
            let names = roles.iter().enumerate().map(name).collect();
            let is_declared = declared.is_some();
            Self { names, delimiter, is_declared, comment: false, place: place.clone(), assumed, counted: None }
        };
        if given.is_empty() && kind == Bare::Points {
            let words = fields(lines, 0, delimiter).map(|word| word.text);
            return points::columns(words)
                .map(|found| Self { names: found.names, ..header(Vec::new(), found.warning.into_iter().collect()) });
        }
        if given.is_empty() {
            let roles = [Role::Position(0), Role::Position(1), Role::Position(2), Role::Radius].map(Some);
            let (3 | 4, false) = (numbers.len(), numbers.contains(&false)) else { return None };
            let what = if numbers.len() == 3 { "x, y and z" } else { "x, y, z and radius" };
            let warning = format!(
                "{place}: the table has no header, so its columns are read as {what}; name them with {COLUMNS}"
            );
            return Some(header(roles[..numbers.len()].to_vec(), vec![warning]));
        }
        let names: Vec<String> = (0..numbers.len()).map(|n| ColumnNames::name_of(None, n)).collect();
        let roles = given.roles(&names).ok()?;
        // One number makes it a row, so that an invalid first row is not taken for a header.
        let is_number =
            |(role, number): (&Option<Role>, &bool)| *number && role.is_some_and(|role| role != Role::Symbol);
        roles.iter().zip(&numbers).any(is_number).then(|| header(roles, Vec::new())).filter(Self::is_placed)
    }

    /// Whether x, y and z are among the columns.
    fn is_placed(&self) -> bool {
        (0..3).all(|axis| self.names.iter().any(|(_, role)| *role == Role::Position(axis)))
    }

    /// The header that begins at this byte of the current line, or why it is none.
    ///
    /// # Errors
    /// [`Error::Scene`] for lengths in different units.
    fn of<R: BufRead>(
        lines: &Lines<R>,
        start: usize,
        given: &ColumnNames,
        declared: Option<u8>,
    ) -> Result<Result<Self>> {
        let place = lines.place(start);
        let mut problem = None;
        let likely = delimiters(&lines.text()[start..]).filter(|_| declared.is_none());
        for delimiter in declared.into_iter().chain(likely) {
            let names: Vec<String> = fields(lines, start, delimiter).map(|word| word.content().into_owned()).collect();
            let fixed = match given.roles(&names) {
                Ok(fixed) => fixed,
                Err(lack) => {
                    let mend = format!("correct {COLUMNS}; the columns are {}", list(&names));
                    problem.get_or_insert((lack, mend));
                    continue;
                }
            };
            let placed = fixed.iter().position(|role| matches!(role, Some(Role::Position(_))));
            let axes = match placed {
                Some(column) => Some(Axes::of_unit(split(&names[column]).1)),
                None => axes(&names),
            };
            let missing = || ("the columns x, y and z are missing".to_owned(), name_them());
            let Some(axes) = axes else {
                problem.get_or_insert_with(missing);
                continue;
            };
            let (roles, assumed) = roles(&names, &fixed, &axes);
            let lengths = |role| !matches!(role, Role::Radius | Role::Diameter);
            let odd = names.iter().find(|name| ["radius", "diameter"].contains(&split(name).0.as_str()));
            if let Some(odd) = odd.filter(|_| roles.iter().copied().all(lengths)) {
                let problem = format!("{} has another unit than the positions", quote(odd));
                let mend = "use the same unit for radii and positions, and the same name for it";
                return Err(Error::scene(place.named("header"), problem, mend));
            }
            let comment = start > 0 && lines.text()[..start].ends_with(['#', '/']);
            let names = names.into_iter().zip(roles).collect();
            let is_declared = declared.is_some();
            let header = Self { names, delimiter, is_declared, comment, place: place.clone(), assumed, counted: None };
            if header.is_placed() {
                return Ok(Ok(header));
            }
            problem.get_or_insert_with(missing);
        }
        let (problem, mend) = problem.unwrap_or_default();
        Ok(Err(Error::scene(place.named("header"), problem, mend)))
    }
}

/// The meaning of each column: the given one, else by its name; and what to say of columns that are not taken.
fn roles(names: &[String], fixed: &[Option<Role>], axes: &Axes) -> (Vec<Role>, Vec<String>) {
    let fields: Vec<NamedField<'_>> =
        names.iter().map(|name| NamedField { name, count: 1, kind: FieldKind::Text }).collect();
    let Meanings { fields, warnings, .. } = meanings(&fields);
    let found = fields.concat().into_iter().map(|(_, role)| role);
    let is_given = |role: Role| fixed.contains(&Some(role));
    let length = is_given(Role::Radius) || is_given(Role::Diameter);
    let own = |name: &str, found: Role| match role(name, found, axes) {
        Role::Radius | Role::Diameter if length => Role::Other,
        role if is_given(role) => Role::Other,
        role => role,
    };
    let roles =
        names.iter().zip(found).zip(fixed).map(|((name, found), fixed)| fixed.unwrap_or_else(|| own(name, found)));
    (roles.collect(), if fixed.iter().flatten().count() == 0 { warnings } else { Vec::new() })
}

/// The meaning of a column, where lengths have the unit of these axes; without units it is `found`.
fn role(name: &str, found: Role, axes: &Axes) -> Role {
    if let Some(axis) = axes.of(name) {
        return Role::Position(axis);
    }
    let (base, unit) = split(name);
    match (base.as_str(), found) {
        ("radius", _) if unit == axes.unit => Role::Radius,
        ("diameter", _) if unit == axes.unit => Role::Diameter,
        (_, Role::Radius | Role::Diameter) if !axes.unit.is_empty() => Role::Other,
        (_, Role::Position(_)) => Role::Other,
        ("element" | "symbol", _) => Role::Symbol,
        (_, found) => found,
    }
}
