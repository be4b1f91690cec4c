//! SphereRows from comma-separated values: a header that names the columns `x,y,z,radius[,r,g,b]` in any order, then one
//! sphere per line. Blank lines and lines that begin with `#` are ignored; fields may be quoted and padded.

use super::input::Input;
use super::lines::Lines;
use super::particles::frame::Particles;
use super::particles::role::Role;
use super::particles::survey::Survey;
use crate::formats::table::Table;
use crate::spheres::SphereRows;
use halfline_ground::error::{Error, Result};
use halfline_ground::progress::Watch;
use std::path::Path;

/// The columns, in the order of a sphere's numbers.
pub(super) const COLUMNS: [&str; 7] = ["x", "y", "z", "radius", "r", "g", "b"];

const ROLES: [Role; 7] = [
    Role::Position(0),
    Role::Position(1),
    Role::Position(2),
    Role::Radius,
    Role::Color(0),
    Role::Color(1),
    Role::Color(2),
];

const ALLOWED: &str = "the columns are x, y, z, radius and optionally r, g, b";

/// Appends the spheres of the file. Errors name line, column in characters, and field.
pub fn read(path: &Path, spheres: &mut SphereRows, watch: &Watch) -> Result<()> {
    each(path, watch, |center, radius, color| spheres.add(center, radius, color))
}

/// Gives the spheres of the file to `survey`, block by block.
pub fn pass(path: &Path, survey: &Survey, watch: &Watch) -> Result<()> {
    let mut block = SphereRows::default();
    each(path, watch, |center, radius, color| {
        block.add(center, radius, color)?;
        if survey.is_full(block.len()) { survey.take_spheres(&mut block, true) } else { Ok(()) }
    })?;
    survey.take_spheres(&mut block, true)
}

/// Whether the spheres of the file have colours.
pub fn is_colored(path: &Path, watch: &Watch) -> Result<bool> {
    table(path, watch).map(|table| has_colors(&table))
}

fn has_colors(table: &Table<Input>) -> bool {
    ROLES[4..].iter().any(|role| table.layout().contains(*role))
}

fn table(path: &Path, watch: &Watch) -> Result<Table<Input>> {
    let role = |name: &str| COLUMNS.iter().position(|column| *column == name).map(|column| ROLES[column]);
    let table = Table::strict(Lines::new(Input::open(path, watch)?, path), ALLOWED, role)?;
    let required = if has_colors(&table) { &ROLES[..] } else { &ROLES[..4] };
    if let Some(missing) = required.iter().position(|role| !table.layout().contains(*role)) {
        let problem = format!("column `{}` is missing", COLUMNS[missing]);
        return Err(Error::scene(table.lines().place(0).named("header"), problem, ALLOWED));
    }
    Ok(table)
}

/// Every sphere of the file.
fn each(path: &Path, watch: &Watch, mut take: impl FnMut([f64; 3], f64, Option<[f32; 3]>) -> Result<()>) -> Result<()> {
    let mut table = table(path, watch)?;
    let mut row = Particles::default();
    while table.row(&mut row)? {
        if let (Some(center), Some(radius)) = (row.positions.pop(), row.radii.pop()) {
            take(center, radius, row.colors.pop())?;
            table.lines().found();
        }
    }
    Ok(())
}
