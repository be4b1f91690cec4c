//! `halfline info FILE`.

use super::process::ExitCode;
use super::signals::watch;
use super::standard::{print, print_json};
use halfline::error::Result;
use halfline::quote::{count, list, number, printable};
use halfline_files::read::info::{ColumnInfo, FileInfo, info};
use halfline_files::read::{AtomStyle, ColumnNames, Format, ParticleOptions, ReadOptions};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Describes a file: format, frames, columns with their ranges, elements, chains, cell and extent, and what a plain
/// rendering would assume. The memory does not grow with the file.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Info {
    /// The scene or particle file; - for standard input.
    file: PathBuf,
    /// File format, if neither content nor name show it.
    #[arg(long, value_name = "F")]
    format: Option<Format>,
    /// Columns of a table by meaning, as for halfline render.
    #[arg(long, value_name = "M=C,...")]
    columns: Option<ColumnNames>,
    /// Atom style of a LAMMPS data file, as for halfline render.
    #[arg(long, value_name = "STYLE")]
    atom_style: Option<AtomStyle>,
    /// Leaves out invalid rows, as for halfline render.
    #[arg(long)]
    skip_invalid: bool,
    /// Model number in a PDB or mmCIF file.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    model: Option<i64>,
    /// Prints one JSON object.
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  halfline info molecule.pdb
  halfline info trajectory.dump.gz --json";

/// The most values of a column that the text lists.
const LISTED: usize = 8;

impl Info {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        let Self { format, skip_invalid, model, .. } = *self;
        let columns_named = self.columns.clone().unwrap_or_default();
        let atom_style = self.atom_style.clone();
        let watch = watch();
        let options = ReadOptions {
            particles: ParticleOptions {
                format,
                columns_named,
                atom_style,
                skip_invalid,
                model,
                watch,
                ..Default::default()
            },
            ..ReadOptions::default()
        };
        let found = info(&self.file, &options)?;
        match self.json {
            true => print_json(&found)?,
            false => print(&format!("{}\n", text(&found).trim_end()))?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// The content of the file in lines.
fn text(info: &FileInfo) -> String {
    let mut text = String::new();
    let mut line = |name: &str, what: String| {
        // Writing to a String does not fail.
        let _ = writeln!(text, "{name:10} {}", printable(&what));
    };
    let camera = if info.camera { ", with a camera" } else { "" };
    line("format", format!("{}, {}{camera}", info.format, count(info.frames, "frame")));
    let first = if info.frames > 1 { " in the first frame" } else { "" };
    line("spheres", format!("{}{first}", info.spheres));
    if let Some(extent) = &info.extent {
        let ends = |k: usize| format!("{} to {}", number(extent.min[k], 6), number(extent.max[k], 6));
        line("extent", format!("x {}, y {}, z {}", ends(0), ends(1), ends(2)));
    }
    if let Some(cell) = &info.cell {
        let three = |numbers: [f64; 3]| numbers.map(|x| number(x, 6)).join(", ");
        line("cell", format!("edges {}, angles {}", three(cell.lengths), three(cell.angles)));
    }
    let radii = &info.radii;
    match radii.source {
        "file" => line("radii", format!("of the file, {} to {}", number(radii.min, 4), number(radii.max, 4))),
        "element" => line("radii", format!("van der Waals, {} to {}", number(radii.min, 4), number(radii.max, 4))),
        "spacing" => line("radii", format!("half the mean spacing, {}; --radius sets another", number(radii.min, 4))),
        _ => {}
    }
    line(
        "colours",
        if info.colored {
            "of the file"
        } else if info.elements.is_empty() {
            "grey"
        } else {
            "of the elements"
        }
        .into(),
    );
    if !info.elements.is_empty() {
        let mut counts: Vec<_> = info.elements.iter().collect();
        counts.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        let names: Vec<&str> =
            info.columns.iter().filter(|column| is_elements(info, column)).map(|c| &c.0[..]).collect();
        let column = if names.is_empty() { String::new() } else { format!(" (column {})", list(names)) };
        line("elements", list(counts.iter().map(|(symbol, count)| format!("{symbol} {count}"))) + &column);
    }
    if !info.chains.is_empty() {
        let names = info.chains.iter().map(|name| if name.is_empty() { "(blank)" } else { name });
        line("chains", format!("{}: {}", info.chains.len(), list(names)));
    }
    for (n, (name, column)) in info.columns.iter().filter(|column| !is_elements(info, column)).enumerate() {
        line(if n == 0 { "columns" } else { "" }, format!("{name:12} {}", values(column)));
    }
    for warning in &info.warnings {
        line("warning", warning.clone());
    }
    text
}

/// Whether a column names the elements, which are listed with their counts.
fn is_elements(info: &FileInfo, (_, column): &(&String, &ColumnInfo)) -> bool {
    let is_symbol = |name: &String| info.elements.contains_key(name);
    !info.elements.is_empty()
        && column.distinct == Some(info.elements.len() as u64)
        && column.values.iter().all(is_symbol)
}

/// The values of a column in words.
fn values(column: &ColumnInfo) -> String {
    let mut parts = Vec::new();
    let is_one = column.distinct == Some(1);
    if let (Some(low), Some(high), false) = (column.min, column.max, is_one) {
        parts.push(format!("{} to {}", brief(low), brief(high)));
    }
    let few = column.kind == "text" || column.values.len() <= LISTED;
    if few && !column.values.is_empty() {
        let shown: Vec<&str> =
            column.values.iter().take(LISTED).map(|name| if name.is_empty() { "(blank)" } else { name }).collect();
        let more = column.distinct.unwrap_or(0).saturating_sub(shown.len() as u64);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        parts.push(format!("{}{more}", list(shown)));
    }
    if column.infinite > 0 {
        parts.push(format!("{} infinite", column.infinite));
    }
    if column.missing > 0 {
        parts.push(format!("{} without a value", column.missing));
    }
    parts.join("; ")
}

/// A number: whole where it is, else with six digits.
fn brief(x: f64) -> String {
    if x.fract() == 0.0 && x.abs() < 1e15 { x.to_string() } else { number(x, 6) }
}
