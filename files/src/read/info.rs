//! The content of a file, examined without keeping its particles: format, frames, columns with their ranges, elements,
//! chains, cell and extent, and the assumptions of a rendering without options.

use super::native::rows_of;
use super::options::ReadOptions;
use super::sequence::{SceneFrame, Sequence};
use super::style::{Radii, Style, spacing_of};
use halfline::error::{Error, Place, Result};
use halfline::scene::{Cell, check_sphere};
use halfline_particles::FrameRange;
use halfline_particles::elements::element;
use halfline_particles::input::Input;
use halfline_particles::open::open;
use halfline_particles::opened::SceneSource;
use halfline_particles::particles::colors::ColorScale;
use halfline_particles::particles::frame::Particles;
use halfline_particles::particles::survey::{ColumnCounts, Counts, Survey};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

/// The content of a scene or particle file. Numbers describe the first frame, in the file's unit (GROMACS: converted
/// to ångström).
#[derive(Debug, Clone, Serialize)]
pub struct FileInfo {
    /// `halfline-info`.
    pub schema: &'static str,
    /// Version of this object's shape.
    pub version: u32,
    /// The format's name, as in `--format`.
    pub format: &'static str,
    /// The number of frames or models.
    pub frames: u64,
    /// Spheres of the first frame.
    pub spheres: u64,
    /// The columns besides the coordinates, by the name in the file.
    pub columns: BTreeMap<String, ColumnInfo>,
    /// Atoms by the symbol of their element; `X` for unknown ones. Empty where the format has no elements.
    pub elements: BTreeMap<String, u64>,
    /// The names of the chains in the file's order.
    pub chains: Vec<String>,
    /// The periodic cell, if the file has one.
    pub cell: Option<CellInfo>,
    /// The box around the centres; `None` without spheres.
    pub extent: Option<Extent>,
    /// The radii of a rendering without options.
    pub radii: RadiiInfo,
    /// Whether the file has colours.
    pub colored: bool,
    /// Whether the file has a camera.
    pub camera: bool,
    /// Warnings: skipped items, assumptions, and remarks about the file.
    pub warnings: Vec<String>,
}

/// A column of a file.
#[derive(Debug, Clone, Serialize)]
pub struct ColumnInfo {
    /// `number` or `text`. A column of numbers and texts is text.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// The least finite number; `None` for text.
    pub min: Option<f64>,
    /// The largest finite number; `None` for text.
    pub max: Option<f64>,
    /// The different names, the most frequent first; of numbers the whole ones in ascending order, if all are whole and
    /// there are few. At most 64.
    pub values: Vec<String>,
    /// The number of different names or whole numbers; `None` where they are not counted.
    pub distinct: Option<u64>,
    /// Particles without a number or a name.
    pub missing: u64,
    /// Particles with an infinite number.
    pub infinite: u64,
}

/// A periodic cell.
#[derive(Debug, Clone, Serialize)]
pub struct CellInfo {
    /// The corner of the cell.
    pub origin: [f64; 3],
    /// The three edges.
    pub edges: [[f64; 3]; 3],
    /// Their lengths.
    pub lengths: [f64; 3],
    /// The angles between them, degrees: b and c, a and c, a and b.
    pub angles: [f64; 3],
}

/// A box around centres.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Extent {
    /// The least coordinates.
    pub min: [f64; 3],
    /// The largest coordinates.
    pub max: [f64; 3],
}

/// Radii, and where they come from.
#[derive(Debug, Clone, Serialize)]
pub struct RadiiInfo {
    /// `file`, `element` (van der Waals, ångström), `spacing` (half the mean spacing) or `none` (no spheres).
    pub source: &'static str,
    /// The least radius.
    pub min: f64,
    /// The largest radius.
    pub max: f64,
}

/// The warning about a frame or a scene without spheres.
const NOTHING: &str = "there is no sphere to render";

/// The most values that are listed.
const LISTED: usize = 64;

/// Examines a file. Its particles are counted and dropped block by block, so that the memory does not grow with the
/// file; archives (.npz), LAMMPS data files and small-molecule CIF are read whole.
///
/// # Errors
/// As [`scene`](super::scene).
pub fn info(path: &Path, options: &ReadOptions) -> Result<FileInfo> {
    of_source(
        SceneSource::open(path, options.particles.known_format(), &options.particles.watch)?,
        path,
        options,
        Survey::default(),
    )
}

/// Examines bytes from any reader; messages and the detection of the format treat them as the file `path`.
///
/// # Errors
/// As [`info`].
pub fn info_from_reader(reader: impl Read + Send + 'static, path: &Path, options: &ReadOptions) -> Result<FileInfo> {
    let input = Input::of(Box::new(reader), &options.particles.watch).map_err(|error| Error::read(path, error))?;
    of_source(SceneSource::of(input, path, options.particles.known_format())?, path, options, Survey::default())
}

/// The content of an opened source, counted by `survey`.
fn of_source(source: SceneSource, path: &Path, options: &ReadOptions, survey: Survey) -> Result<FileInfo> {
    let particles = halfline_particles::ParticleOptions {
        survey: Some(survey.clone()),
        frames: FrameRange::first(),
        ..options.particles.clone()
    };
    let options = ReadOptions { particles, style: Style::default(), ..options.clone() };
    let format = source.format.name();
    let mut frames = match open(source, &options.reading())? {
        Ok(frames) => frames,
        Err(source) => {
            return Sequence::of_source(source, path, &options)?.next_scene()?.map_or_else(
                || {
                    Err(Error::scene(
                        Place::file(path.display().to_string()),
                        "the file has no scene",
                        "use another file",
                    ))
                },
                |frame| Ok(FileInfo::of_scene(frame, format)),
            );
        }
    };
    let Some(first) = frames.next()? else {
        let place = Place::file(path.display().to_string());
        return Err(Error::scene(place, "the file has no atoms or particles", "use a file with coordinates"));
    };
    let mut counts = first.counted(&survey);
    if let Some((n, center, radius)) = counts.invalid {
        let place = || Place::file(path.display().to_string()).named(format!("particle {n}"));
        check_sphere(center, radius, place)?;
    }
    let mut count = 1;
    loop {
        options.particles.watch.check()?;
        match frames.skip() {
            Ok(true) => count += 1,
            Ok(false) => break,
            // The frames before it can be rendered.
            Err(error) if is_of_content(&error) => {
                counts.warnings.push(format!("frame {} cannot be read, nor can what follows it: {error}", count + 1));
                break;
            }
            Err(error) => return Err(error),
        }
    }
    Ok(FileInfo { format, frames: count, ..FileInfo::of(counts) })
}

/// Whether an error is of the file's content: also of a count that is too large.
fn is_of_content(error: &Error) -> bool {
    matches!(error, Error::Scene { .. } | Error::Limits { .. })
}

impl FileInfo {
    fn of(counts: Counts) -> Self {
        let named = |number: usize| element(number as u8).map_or("X", |element| element.symbol).to_owned();
        let known: u64 = counts.elements[1..].iter().sum();
        let mut elements = BTreeMap::new();
        if known > 0 {
            for (number, count) in counts.elements.iter().enumerate().filter(|(_, count)| **count > 0) {
                *elements.entry(named(number)).or_default() += count;
            }
        }
        let chains = counts.columns.get("chain").map(|column| column.labels.clone()).unwrap_or_default();
        let mut warnings = counts.warnings.clone();
        if !counts.unknown.is_empty() && known > 0 {
            let names: Vec<String> = counts.unknown.iter().map(|(name, n)| format!("{n} {name}")).collect();
            warnings.push(format!("names without an element: {}", names.join(", ")));
        }
        if counts.particles == 0 {
            warnings.push(NOTHING.into());
        }
        let [low, high] = counts.extent;
        let shown = |name: String| counts.shown.get(&name).cloned().unwrap_or(name);
        Self {
            schema: "halfline-info",
            version: 1,
            format: "",
            frames: 1,
            spheres: counts.particles,
            elements,
            chains: chains.iter().map(|name| name.trim().to_owned()).collect(),
            cell: counts.cell.as_ref().map(CellInfo::of),
            extent: (counts.particles > 0).then_some(Extent { min: low, max: high }),
            radii: RadiiInfo::of(&counts),
            colored: counts.colored > 0 && counts.colors.scale() != ColorScale::Empty,
            camera: false,
            warnings,
            columns: counts.columns.into_iter().map(|(name, column)| (shown(name), ColumnInfo::of(column))).collect(),
        }
    }

    fn of_scene(SceneFrame { scene, skipped, .. }: SceneFrame, format: &'static str) -> Self {
        let spheres = scene.spheres;
        let (is_empty, colored) = (spheres.is_empty(), spheres.colors.is_some());
        let survey = Survey::default();
        survey.count_spheres(&mut rows_of(spheres), true);
        let counts = Particles::default().counted(&survey);
        let info = Self::of(counts);
        let nothing = is_empty.then(|| NOTHING.to_owned());
        let warnings = skipped.warnings().into_iter().chain(nothing).collect();
        Self { format, camera: true, colored, warnings, ..info }
    }
}

impl ColumnInfo {
    fn of(column: ColumnCounts) -> Self {
        let is_text = column.is_text();
        let ColumnCounts { ends: [low, high], missing, infinite, values, labels, texts, .. } = column;
        let texts = if is_text { texts } else { BTreeMap::new() };
        let missing = missing.saturating_sub(texts.values().sum());
        let distinct = values.as_ref().map(|values| (values.len() + texts.len()) as u64);
        let name = |number: i64| match usize::try_from(number).ok().and_then(|n| labels.get(n)) {
            Some(label) => label.trim().to_owned(),
            None => number.to_string(),
        };
        let numbered = values.unwrap_or_default().into_iter().map(|(number, count)| (name(number), count));
        let mut counted: Vec<(String, u64)> = numbered.chain(texts).collect();
        if is_text {
            counted.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        }
        let there = low <= high && !is_text;
        Self {
            kind: if is_text { "text" } else { "number" },
            min: there.then_some(low),
            max: there.then_some(high),
            values: counted.into_iter().take(LISTED).map(|(name, _)| name).collect(),
            distinct,
            missing,
            infinite,
        }
    }
}

impl CellInfo {
    fn of(cell: &Cell) -> Self {
        let [a, b, c] = cell.edges.map(glam::DVec3::from_array);
        let angle = |u: glam::DVec3, v: glam::DVec3| u.angle_between(v).to_degrees();
        Self {
            origin: cell.origin,
            edges: cell.edges,
            lengths: [a, b, c].map(glam::DVec3::length),
            angles: [angle(b, c), angle(a, c), angle(a, b)],
        }
    }
}

impl RadiiInfo {
    /// The radii that [`Style::default`] gives.
    fn of(counts: &Counts) -> Self {
        let known: u64 = counts.elements[1..].iter().sum();
        let (source, [min, max]) = if counts.particles == 0 {
            ("none", [f64::NAN; 2])
        } else if counts.sized > 0 {
            ("file", counts.radii)
        } else if known > 0 {
            let radius = |number: usize| Radii::Vdw.radius(number as u8);
            let there = (0..counts.elements.len()).filter(|number| counts.elements[*number] > 0).map(radius);
            ("element", there.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], r| [a.min(r), b.max(r)]))
        } else {
            ("spacing", [spacing_of(counts.extent, counts.particles) / 2.0; 2])
        };
        Self { source, min, max }
    }
}

#[cfg(test)]
mod tests;
