//! The identity of particles. Programs such as LAMMPS write the particles of each frame in another order, with numbers that
//! stay; by these the particles of all frames have the order of the first.

use super::frame::{ParticleFrames, Particles};
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::check;
use halfline_ground::quote::count;
use halfline_ground::quote::setting::IDENTITY;
use std::collections::HashMap;
use std::fmt;

/// The column that identifies the particles of a film.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Identity {
    /// The column `id` of LAMMPS dumps and extended XYZ, where a file has it.
    #[default]
    Id,
    /// The column of this name, which each frame has.
    Column(String),
    /// None: particles keep the order of their rows.
    Row,
}

impl Identity {
    /// The column; `None` for rows.
    pub(crate) fn column(&self) -> Option<&str> {
        match self {
            Self::Id => Some("id"),
            Self::Column(name) => Some(name),
            Self::Row => None,
        }
    }
}

impl From<&str> for Identity {
    /// The column of this name, or rows for `row`.
    fn from(text: &str) -> Self {
        match text {
            "row" => Self::Row,
            name => Self::Column(name.to_lowercase()),
        }
    }
}

impl fmt::Display for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.column().unwrap_or("row"))
    }
}

/// The numbers of a column that has no texts.
pub(crate) fn numbers<'a>(particles: &'a Particles, name: &str) -> Option<&'a [f64]> {
    let column = particles.columns.iter().find(|column| column.name.eq_ignore_ascii_case(name))?;
    (!particles.labels.contains_key(&column.name)).then_some(&column.values[..])
}

/// A key of a map for a number: zero has one sign.
pub(super) fn key(number: f64) -> u64 {
    (number + 0.0).to_bits()
}

/// Frames in the order of the first.
pub(crate) struct Ordered {
    frames: Box<dyn ParticleFrames>,
    file: Place,
    identity: Identity,
    /// The numbers of the first frame with particles, in its order; `None` before it.
    first: Option<Vec<f64>>,
    /// The places of these numbers, once another frame has another order.
    places: Option<HashMap<u64, u32>>,
    /// Whether a message about frames that have other particles was reported.
    has_reported: bool,
}

impl Ordered {
    /// The frames of a file; `first` has the numbers of the first one, if it was read before.
    pub(crate) fn new(
        frames: Box<dyn ParticleFrames>,
        file: Place,
        identity: Identity,
        first: Option<Vec<f64>>,
    ) -> Self {
        Self { frames, file, identity, first, places: None, has_reported: false }
    }

    /// The numbers that identify the particles of a frame. `None` where they are not asked for and cannot be used.
    fn ids(&self, frame: &Particles) -> Result<Option<Vec<f64>>> {
        let name = self.identity.column().unwrap_or_default();
        let fault = |problem: String| {
            let mend = format!("use a column of numbers with {IDENTITY}, or {IDENTITY} row");
            Error::scene(self.file.clone().named(name), problem, mend)
        };
        match (numbers(frame, name), &self.identity) {
            (Some(ids), _) => Ok(Some(ids.to_vec())),
            (None, Identity::Column(_)) => {
                let has = match frame.has.join(", ") {
                    names if names.is_empty() => String::new(),
                    names => format!("; the file has {names}"),
                };
                Err(fault(format!("there is no column {name} of numbers{has}")))
            }
            (None, _) => Ok(None),
        }
    }

    /// The rows of a frame in the order of the first, and those that the first does not have behind them; how many of the first
    /// are missing, if others move up for them. `None` where two particles have one number.
    fn rows(&mut self, ids: &[f64]) -> Option<(Vec<u32>, Option<usize>)> {
        let first = self.first.as_deref().unwrap_or_default();
        let places = self
            .places
            .get_or_insert_with(|| first.iter().enumerate().map(|(place, id)| (key(*id), place as u32)).collect());
        if places.len() < first.len() {
            return None;
        }
        let mut rows = vec![u32::MAX; first.len()];
        let mut others = Vec::new();
        for (row, id) in ids.iter().enumerate() {
            match places.get(&key(*id)) {
                Some(place) if rows[*place as usize] == u32::MAX => rows[*place as usize] = row as u32,
                Some(_) => return None,
                None => others.push(row as u32),
            }
        }
        others.sort_by(|a, b| ids[*a as usize].total_cmp(&ids[*b as usize]));
        let last = rows.iter().rposition(|row| *row != u32::MAX).map_or(0, |last| last + 1);
        let is_moved = rows[..last].contains(&u32::MAX) || last < rows.len() && !others.is_empty();
        rows.extend(others);
        let all = rows.len();
        rows.retain(|row| *row != u32::MAX);
        Some((rows, is_moved.then(|| all - ids.len())))
    }

    /// Gives a frame the order of the first.
    fn order(&mut self, frame: &mut Particles) -> Result<()> {
        let Some(ids) = self.ids(frame)? else { return Ok(()) };
        let Some(first) = &self.first else {
            self.first = Some(ids);
            return Ok(());
        };
        if *first == ids {
            return Ok(());
        }
        check(32 * (ids.len() + first.len()) as u64, || {
            format!("the order of {}", count(ids.len() as u64, "particle"))
        })?;
        let before = first.len() as u64;
        let message = match self.rows(&ids) {
            Some((rows, missing)) => {
                frame.arrange(&rows);
                missing.map(|missing| {
                    let are = if missing == 1 { "is" } else { "are" };
                    format!(
                        "{missing} of {} of the first frame {are} missing: \
                         the ids of later particles hold in this frame alone",
                        count(before, "particle"),
                    )
                })
            }
            None => Some(format!("two particles have the same {}: they keep the order of the file", self.identity)),
        };
        if let Some(message) = message.filter(|_| !self.has_reported) {
            self.has_reported = true;
            frame.skipped.assumed.push(message);
        }
        Ok(())
    }
}

impl ParticleFrames for Ordered {
    fn next(&mut self) -> Result<Option<Particles>> {
        let Some(mut frame) = self.frames.next()? else { return Ok(None) };
        if !frame.positions.is_empty() {
            self.order(&mut frame)?;
        }
        Ok(Some(frame))
    }

    fn skip(&mut self) -> Result<bool> {
        self.frames.skip()
    }
}
