//! GSD files of HOOMD-blue: frames of positions, types, diameters, shapes, velocities, masses, charges, bodies, images and the box
//! (gsd.readthedocs.io/en/stable/schema-hoomd.html). What a frame lacks comes from the first frame, where both have the
//! same number of particles, or is the default of the schema. There is no crate for the format.

mod file;
mod shape;

use crate::format::{FormatRow, Open, Sign};
use crate::particles::bytes::BinaryFile;
use crate::particles::frame::{Column, ParticleFrames, Particles};
use crate::particles::frame_time::FrameTime;
use crate::particles::layout::is_requested;
use crate::particles::request::Request;
use crate::source::Source;
use file::{Chunk, GsdFile, until_zero};
use halfline_ground::Cell;
use halfline_ground::error::Result;
use halfline_ground::memory::{check, check_ids};
use halfline_ground::quote::setting::RADIUS;
use halfline_ground::quote::{list, unquoted};
use shape::Shape;
use std::collections::BTreeMap;

pub(crate) const GSD: FormatRow = FormatRow {
    name: "gsd",
    about: "frames of HOOMD-blue",
    signs: &[Sign::Bytes(|bytes| bytes.starts_with(&0x65df_65df_65df_65df_u64.to_le_bytes()))],
    open: Open::Frames(|source, request, _| Ok(Box::new(Gsd::new(source, request)))).optional(),
    ..FormatRow::PLAIN
};

/// The reader.
pub(crate) struct Gsd {
    source: Option<BinaryFile>,
    file: Option<GsdFile>,
    /// The requested columns, as indices of [`COLUMNS`].
    requested: Vec<usize>,
    /// The next frame, from 0.
    frame: u64,
    /// The shapes of the types, of the chunk that they were read from, which many frames share.
    shapes: (Option<Chunk>, Vec<Shape>),
    /// Whether the shapes were reported, which are the shapes of all frames.
    has_reported: bool,
}

/// A column (`typeid` has numbers, `type` the names that they stand for): its name, the chunk, the component, and the default of the schema.
const COLUMNS: [(&str, &str, u32, f64); 11] = [
    ("typeid", TYPE, 0, 0.0),
    ("type", TYPE, 0, 0.0),
    ("mass", "particles/mass", 0, 1.0),
    ("charge", "particles/charge", 0, 0.0),
    ("body", "particles/body", 0, -1.0),
    ("vx", VELOCITY, 0, 0.0),
    ("vy", VELOCITY, 1, 0.0),
    ("vz", VELOCITY, 2, 0.0),
    ("ix", IMAGE, 0, 0.0),
    ("iy", IMAGE, 1, 0.0),
    ("iz", IMAGE, 2, 0.0),
];

const TYPE: &str = "particles/typeid";
const VELOCITY: &str = "particles/velocity";
/// The images that particles are in, under the names that LAMMPS gives them.
const IMAGE: &str = "particles/image";
const NAMES: &str = "particles/types";
const SHAPES: &str = "particles/type_shapes";
const COUNT: &str = "particles/N";
const POSITION: &str = "particles/position";
const DIAMETER: &str = "particles/diameter";

/// The default diameter of the schema.
const DIAMETER_DEFAULT: f64 = 1.0;

/// The most types.
const MOST_TYPES: u64 = 4096;

impl Gsd {
    pub(crate) fn new(source: Source, request: Request) -> Self {
        let selects = |name: &str| is_requested(&request.columns, name);
        let requested = (0..COLUMNS.len()).filter(|k| selects(COLUMNS[*k].0)).collect();
        Self {
            source: Some(BinaryFile::new(source)),
            file: None,
            requested,
            frame: 0,
            shapes: (None, Vec::new()),
            has_reported: false,
        }
    }

    /// Reads the file, if it was not read yet, and returns the next frame that it has.
    fn advance(&mut self) -> Result<Option<(&GsdFile, u64)>> {
        if let Some(source) = self.source.take() {
            self.file = Some(GsdFile::read(source)?);
        }
        let Some(file) = &self.file else { return Ok(None) };
        if self.frame >= file.frames()? {
            return Ok(None);
        }
        self.frame += 1;
        Ok(Some((file, self.frame - 1)))
    }
}

/// The particles of a frame.
struct Reading<'a> {
    file: &'a GsdFile,
    frame: u64,
    count: u64,
    /// Whether the first frame has as many particles.
    like_first: bool,
}

impl<'a> Reading<'a> {
    fn new(file: &'a GsdFile, frame: u64) -> Result<Self> {
        let of = |frame: u64| -> Result<Option<u64>> {
            let Some(chunk) = file.chunk(frame, COUNT) else { return Ok(None) };
            let number = file.numbers(chunk).next().filter(|n| *n >= 0.0 && n.fract() == 0.0);
            let count = number.ok_or_else(|| file.wrong(frame, COUNT, "it is no whole number"))? as u64;
            check_ids(count).map(|()| Some(count))
        };
        let first = of(0)?.unwrap_or(0);
        let count = of(frame)?.unwrap_or(first);
        Ok(Self { file, frame, count, like_first: count == first })
    }

    /// An array with a row for each particle, of this frame or of the first.
    fn array(&self, name: &str, columns: u32) -> Result<Option<Chunk>> {
        let first = || self.file.chunk(0, name).filter(|_| self.like_first);
        let Some(chunk) = self.file.chunk(self.frame, name).or_else(first) else { return Ok(None) };
        if (chunk.rows, chunk.columns) != (self.count, columns) {
            let problem = format!("{} x {} numbers for {} particles", chunk.rows, chunk.columns, self.count);
            return Err(self.file.wrong(self.frame, name, problem));
        }
        Ok(Some(chunk))
    }

    fn positions(&self) -> Result<Vec<[f64; 3]>> {
        let Some(chunk) = self.array(POSITION, 3)? else {
            let problem = format!("{} particles have no positions", self.count);
            return if self.count == 0 { Ok(Vec::new()) } else { Err(self.file.wrong(self.frame, POSITION, problem)) };
        };
        check(32 * self.count, || format!("{} particles", self.count))?;
        let mut numbers = self.file.numbers(chunk);
        let mut three = || Some([numbers.next()?, numbers.next()?, numbers.next()?]);
        Ok(std::iter::from_fn(&mut three).collect())
    }

    /// Reads the shapes of the types, if they are of another chunk than those that were read.
    fn shapes(&self, known: &mut (Option<Chunk>, Vec<Shape>)) -> Result<()> {
        let chunk = self.file.chunk(self.frame, SHAPES).or_else(|| self.file.chunk(0, SHAPES));
        if known.0 != chunk {
            let of = |(n, text): (usize, &String)| {
                let wrong = |problem| self.file.wrong(self.frame, SHAPES, format!("type {n}: {problem}"));
                Shape::of(text).map_err(wrong)
            };
            *known = (chunk, self.texts(SHAPES).unwrap_or_default().iter().enumerate().map(of).collect::<Result<_>>()?);
        }
        Ok(())
    }

    /// The radii, and the message about shapes that are no spheres. Diameters of particles come before diameters of their types.
    fn radii(&self, shapes: &[Shape]) -> Result<(Vec<f64>, Option<String>)> {
        if let Some(chunk) = self.array(DIAMETER, 1)? {
            return Ok((self.file.numbers(chunk).map(|diameter| diameter / 2.0).collect(), None));
        }
        let plain = DIAMETER_DEFAULT / 2.0;
        if shapes.is_empty() {
            return Ok((vec![plain; self.count as usize], None));
        }
        let mut of_types = vec![0_u64; shapes.len()];
        let mut radius = |of: f64| {
            let kind = of as usize;
            of_types.get_mut(kind).into_iter().for_each(|count| *count += 1);
            if let Some(Shape::Sphere(radius)) = shapes.get(kind) { *radius } else { plain }
        };
        let radii = self.column(0)?.values.into_iter().map(&mut radius).collect();
        let mut others: BTreeMap<&str, u64> = BTreeMap::new();
        for (shape, count) in shapes.iter().zip(of_types).filter(|(_, count)| *count > 0) {
            if let Shape::Other(name) = shape {
                *others.entry(name).or_default() += count;
            }
        }
        let named = others.iter().map(|(name, count)| format!("{count} {}", unquoted(name)));
        let all: u64 = others.values().sum();
        let warning = format!(
            "{} of a shape that is no sphere ({}), and {} drawn as a sphere of the diameter {DIAMETER_DEFAULT}; use {RADIUS} to set another",
            if all == 1 { "1 particle is".into() } else { format!("{all} particles are") },
            list(named),
            if all == 1 { "it is" } else { "each is" },
        );
        Ok((radii, (all > 0).then_some(warning)))
    }

    fn column(&self, kind: usize) -> Result<Column> {
        let (name, chunk, component, default) = COLUMNS[kind];
        let width = if [VELOCITY, IMAGE].contains(&chunk) { 3 } else { 1 };
        check(8 * self.count, || format!("the column {name}"))?;
        let values = match self.array(chunk, width)? {
            Some(chunk) => self.file.numbers(chunk).skip(component as usize).step_by(width as usize).collect(),
            None => vec![default; self.count as usize],
        };
        Ok(Column { name: name.to_owned(), values })
    }

    /// The rows of a chunk as texts, of this frame or of the first; `None` where there are none, or too many.
    fn texts(&self, name: &str) -> Option<Vec<String>> {
        let chunk = self.file.chunk(self.frame, name).or_else(|| self.file.chunk(0, name));
        let chunk = chunk.filter(|chunk| chunk.columns > 0 && chunk.rows <= MOST_TYPES)?;
        let text = |row: &[u8]| String::from_utf8_lossy(&until_zero(row)).into_owned();
        Some(self.file.bytes(chunk).chunks(chunk.columns as usize).map(text).collect())
    }

    /// The names of the types; numbers of types beyond them are names of their own.
    fn types(&self, values: &[f64]) -> Vec<String> {
        let mut types = self.texts(NAMES).unwrap_or_else(|| vec!["A".into()]);
        let most = values.iter().fold(0.0f64, |most, x| most.max(*x)) as u64;
        types.extend((types.len() as u64..=most.min(MOST_TYPES)).map(|number| number.to_string()));
        types
    }

    /// The step, which is 0 by the schema where the file has none.
    fn step(&self) -> i64 {
        let name = "configuration/step";
        let chunk = self.file.chunk(self.frame, name).or_else(|| self.file.chunk(0, name));
        chunk.and_then(|chunk| self.file.numbers(chunk).next()).map_or(0, |step| step as i64)
    }

    /// The box: lengths, then the tilts xy, xz and yz; its centre is the origin.
    fn cell(&self) -> Result<Option<Cell>> {
        let name = "configuration/box";
        let Some(chunk) = self.file.chunk(self.frame, name).or_else(|| self.file.chunk(0, name)) else {
            return Ok(None);
        };
        let numbers: Vec<f64> = self.file.numbers(chunk).take(7).collect();
        let [x, y, z, xy, xz, yz] = numbers[..] else {
            return Err(self.file.wrong(self.frame, name, "a box has six numbers"));
        };
        let edges = [[x, 0.0, 0.0], [xy * y, y, 0.0], [xz * z, yz * z, z]];
        if !edges.iter().flatten().all(|x| x.is_finite()) {
            return Err(self.file.wrong(self.frame, name, "a number is not finite"));
        }
        let origin = [0, 1, 2].map(|k| -(edges[0][k] + edges[1][k] + edges[2][k]) / 2.0);
        Ok(edges.iter().flatten().any(|x| *x != 0.0).then_some(Cell { origin, edges }))
    }
}

impl ParticleFrames for Gsd {
    fn next(&mut self) -> Result<Option<Particles>> {
        let (requested, has_reported) = (self.requested.clone(), self.has_reported);
        let mut shapes = std::mem::take(&mut self.shapes);
        let Some((file, frame)) = self.advance()? else { return Ok(None) };
        let reading = Reading::new(file, frame)?;
        // The positions prove the count.
        let positions = reading.positions()?;
        reading.shapes(&mut shapes)?;
        let (radii, warning) = reading.radii(&shapes.1)?;
        // The schema's images are all 0, so a file without any does not say which they are.
        let is_there = |kind: &usize| COLUMNS[*kind].1 != IMAGE || file.has(IMAGE);
        let has = (0..COLUMNS.len()).filter(is_there).map(|kind| COLUMNS[kind].0.to_owned()).collect();
        let mut particles = Particles {
            positions,
            radii,
            cell: reading.cell()?,
            when: FrameTime::of(None, Some(reading.step())),
            has,
            ..Particles::default()
        };
        particles.skipped.assumed.extend(warning.filter(|_| !has_reported));
        for kind in requested.into_iter().filter(is_there) {
            let column = reading.column(kind)?;
            if column.name == "type" {
                particles.labels.insert(column.name.clone(), reading.types(&column.values));
            }
            particles.columns.push(column);
        }
        (self.has_reported, self.shapes) = (true, shapes);
        Ok(Some(particles))
    }

    fn skip(&mut self) -> Result<bool> {
        Ok(self.advance()?.is_some())
    }
}

#[cfg(test)]
mod tests;
