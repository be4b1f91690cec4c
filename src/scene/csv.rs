//! Spheres from comma-separated values: a header that names the columns `x,y,z,radius[,r,g,b]` in any order, then one
//! sphere per line. Blank lines and lines that begin with `#` say nothing; fields may be quoted and padded.
//!
//! Read by lines rather than by the csv crate, whose record positions count the comments and blank lines before a
//! record to it: a number that spans lines is wrong anyway, and an error here names the very character.

use super::lines::Lines;
use super::{Spheres, check_color, check_sphere, relocate};
use crate::error::{Error, Place, Result};
use std::io::BufRead;
use std::path::Path;

/// The columns, in the order of a sphere's numbers.
pub(super) const COLUMNS: [&str; 7] = ["x", "y", "z", "radius", "r", "g", "b"];

/// Appends the spheres of the file. Errors name line, column in characters, and field.
pub(super) fn read(path: &Path, spheres: &mut Spheres) -> Result<()> {
    let mut lines = Lines::new(super::open(path)?, path);
    if !next(&mut lines)? {
        let mend = "begin with the line x,y,z,radius or x,y,z,radius,r,g,b";
        return Err(Error::scene(lines.file(), "the file is empty", mend));
    }
    let slots = header(&lines)?;
    let colored = slots.len() == COLUMNS.len();
    while next(&mut lines)? {
        let row = Row::parse(&lines, &slots)?;
        let [x, y, z, radius, r, g, b] = row.values;
        let locate = |error| relocate(error, |field| row.place(&lines, field));
        check_sphere([x, y, z], radius, Place::default).map_err(locate)?;
        let color = colored.then_some([r as f32, g as f32, b as f32]);
        if let Some(color) = color {
            check_color(color, Place::default).map_err(locate)?;
        }
        spheres.push([x, y, z], radius, color);
    }
    Ok(())
}

/// Goes to the next line that says something.
fn next<R: BufRead>(lines: &mut Lines<R>) -> Result<bool> {
    while lines.advance()? {
        let text = lines.text().trim_start();
        if !text.is_empty() && !text.starts_with('#') {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Which of [`COLUMNS`] each column of the file is.
fn header<R: BufRead>(lines: &Lines<R>) -> Result<Vec<usize>> {
    let mut slots = Vec::new();
    for (start, name) in fields(lines.text()) {
        let fail = |problem: String| Err(Error::scene(lines.place(start).named("header"), problem, ALLOWED));
        match COLUMNS.iter().position(|column| *column == name) {
            None => return fail(format!("unknown column `{name}`")),
            Some(slot) if slots.contains(&slot) => return fail(format!("column `{name}` appears twice")),
            Some(slot) => slots.push(slot),
        }
    }
    let has = |slot: &usize| slots.contains(slot);
    let wanted = if (4..7).any(|slot| has(&slot)) { 7 } else { 4 };
    match (0..wanted).find(|slot| !has(slot)) {
        None => Ok(slots),
        Some(slot) => {
            let problem = format!("column `{}` is missing", COLUMNS[slot]);
            Err(Error::scene(lines.place(0).named("header"), problem, ALLOWED))
        }
    }
}

const ALLOWED: &str = "the columns are x, y, z, radius and, all or none, r, g, b";

/// One sphere's numbers and where each begins in its line.
struct Row {
    values: [f64; 7],
    starts: [usize; 7],
}

impl Row {
    fn parse<R: BufRead>(lines: &Lines<R>, slots: &[usize]) -> Result<Self> {
        let mut row = Self { values: [0.0; 7], starts: [0; 7] };
        let mut count = 0;
        for (start, field) in fields(lines.text()) {
            let Some(&slot) = slots.get(count) else {
                let problem = format!("more than the {} fields that the header names", slots.len());
                return Err(Error::scene(lines.place(start).named("row"), problem, "give one field per column"));
            };
            let wrong = |problem: String| {
                Error::scene(lines.place(start).named(COLUMNS[slot]), problem, "give a finite number such as 0.5")
            };
            let value: f64 = match field {
                "" => return Err(wrong("the field is empty".into())),
                _ => field.parse().map_err(|_| wrong(format!("`{field}` is no number")))?,
            };
            if !value.is_finite() {
                return Err(wrong(format!("`{field}` is not finite")));
            }
            (row.values[slot], row.starts[slot]) = (value, start);
            count += 1;
        }
        if let Some(&slot) = slots.get(count) {
            let problem = format!("{count} fields where the header names {}", slots.len());
            let place = lines.place(lines.text().len()).named(COLUMNS[slot]);
            return Err(Error::scene(place, problem, "give one field per column"));
        }
        Ok(row)
    }

    /// The place of what a check found; a centre or a colour begins at its first number.
    fn place<R: BufRead>(&self, lines: &Lines<R>, field: &str) -> Place {
        let (slot, name) = match field {
            "radius" => (3, field),
            "center" => (0, field),
            _ => (4, "color"),
        };
        lines.place(self.starts[slot]).named(name)
    }
}

/// The fields without padding and quotes, each with the byte it begins at.
fn fields(line: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut start = 0;
    line.split(',').map(move |raw| {
        let at = start + raw.len() - raw.trim_start().len();
        start += raw.len() + 1;
        let field = raw.trim();
        let bare = field.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
        (at, bare.map_or(field, str::trim))
    })
}
