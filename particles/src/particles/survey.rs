//! A file read part by part, so that the memory does not grow with it: the particles of a part are counted and dropped,
//! or passed on.

use super::colors::{ColorSurvey, ColorType};
use super::infer::{Inference, code_of_unknown};
use super::mixed::is_missing;
use crate::spheres::SphereRows;
use halfline_ground::Cell;
use halfline_ground::check::{is_center, is_radius};
use halfline_ground::error::{Error, Result};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The most particles in a part, unless another number is given.
const PART: usize = 1 << 19;

/// The most different numbers of a column that are counted.
const VALUES: usize = 64;

/// The most bytes of the texts among the numbers of a column, and the bytes of one besides its letters.
const MOST_TEXTS: usize = 1 << 28;
const TEXT: usize = 64;

/// A reading in parts: the particles of each part are counted and dropped, or passed on. Clones share the counts and
/// the receiver.
#[derive(Debug, Clone)]
pub struct Survey {
    counts: Arc<Mutex<Counts>>,
    /// The channel that parts are sent to; without it the particles are counted and dropped.
    parts: Option<SyncSender<Part>>,
    /// The selection of spheres before they are passed on; `None` passes all.
    pick: Option<Arc<Mutex<dyn Pick>>>,
    /// The number of particles that fills a part.
    part: usize,
    /// The columns that are known to have texts, in lower case.
    texts: Vec<String>,
}

/// Selects spheres that arrive block by block.
pub trait Pick: fmt::Debug + Send {
    /// The selected spheres of the next block.
    ///
    /// # Errors
    /// Errors of the selection.
    fn pick(&mut self, block: SphereRows) -> Result<SphereRows>;
}

/// Particles that are passed on, with what a style needs of them; see `Particles` for the lists.
#[derive(Debug, Default)]
pub struct Part {
    pub(crate) positions: Vec<[f64; 3]>,
    pub(crate) radii: Vec<f64>,
    pub(crate) elements: Vec<u8>,
    pub colors: Vec<[f32; 3]>,
    pub color_type: ColorType,
    /// Names and values.
    pub(crate) columns: Vec<(String, Vec<f64>)>,
    /// The names of columns of names, numbered for this part.
    pub labels: BTreeMap<String, Vec<String>>,
    /// The names of all columns of the file.
    pub has: Vec<String>,
    pub(crate) checked: bool,
}

/// The counts of a frame.
#[derive(Debug, Clone)]
pub struct Counts {
    pub particles: u64,
    /// The least and the largest coordinates of the centres.
    pub extent: [[f64; 3]; 2],
    /// The least and the largest radius of the file, and the number of particles that have one.
    pub radii: [f64; 2],
    pub sized: u64,
    pub colored: u64,
    /// The survey of the colours, from which their scale follows.
    pub colors: ColorSurvey,
    /// Particles by atomic number, 0 for an unknown element; all 0 where the format has no elements.
    pub elements: [u64; 256],
    pub columns: BTreeMap<String, ColumnCounts>,
    /// The columns whose names have capitals in the file, by the names in lower case.
    pub shown: BTreeMap<String, String>,
    /// Names that are not elements, with the number of their particles.
    pub unknown: BTreeMap<String, u64>,
    pub cell: Option<Cell>,
    pub warnings: Vec<String>,
    /// The first particle that is no sphere, with its centre and its radius.
    pub invalid: Option<(u64, [f64; 3], f64)>,
}

/// The values of a column.
#[derive(Debug, Clone)]
pub struct ColumnCounts {
    /// The least and the largest finite number.
    pub ends: [f64; 2],
    /// Particles without a number.
    pub missing: u64,
    /// Particles with an infinity.
    pub infinite: u64,
    /// The number of particles by value: by the number of a name, or by whole number; `None` for other numbers and too
    /// many of them.
    pub values: Option<BTreeMap<i64, u64>>,
    /// Whether the column has names instead of numbers.
    pub(crate) text: bool,
    /// The names; empty for numbers.
    pub labels: Vec<String>,
    /// Texts among the numbers, and words for missing numbers, with the number of their particles.
    pub texts: BTreeMap<String, u64>,
    /// The bytes of these texts.
    text_bytes: usize,
}

impl Default for Counts {
    fn default() -> Self {
        Self {
            particles: 0,
            extent: [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]],
            radii: [f64::INFINITY, f64::NEG_INFINITY],
            sized: 0,
            colored: 0,
            colors: ColorSurvey::default(),
            elements: [0; 256],
            columns: BTreeMap::new(),
            shown: BTreeMap::new(),
            unknown: BTreeMap::new(),
            cell: None,
            warnings: Vec::new(),
            invalid: None,
        }
    }
}

/// Particles that are counted.
pub(super) struct Counted<'a> {
    pub(super) positions: &'a [[f64; 3]],
    pub(super) radii: &'a [f64],
    pub(super) colors: (ColorType, &'a [[f32; 3]]),
    pub(super) elements: &'a [u8],
    /// Name and values of every column, and whether it has names.
    pub(super) columns: Vec<(&'a str, &'a [f64], bool)>,
}

impl Default for Survey {
    fn default() -> Self {
        Self { counts: Arc::default(), parts: None, pick: None, part: PART, texts: Vec::new() }
    }
}

impl Survey {
    /// A survey that drops the particles after each part of so many; the counts do not depend on it.
    #[must_use]
    pub fn with_part(part: usize) -> Self {
        Self { part, ..Self::default() }
    }

    /// Passes the particles on instead of counting them, in parts of at least `part`.
    pub fn passing(parts: SyncSender<Part>, part: usize) -> Self {
        Self { parts: Some(parts), part, ..Self::default() }
    }

    /// The same, where only the spheres that `pick` selects are passed on.
    pub fn picking(&self, pick: Arc<Mutex<dyn Pick>>) -> Self {
        Self { pick: Some(pick), ..self.clone() }
    }

    /// The same, where these columns are known to have texts.
    pub fn with_texts(self, texts: Vec<String>) -> Self {
        Self { texts, ..self }
    }

    /// Whether a column is known to have texts.
    pub(super) fn has_texts(&self, column: &str) -> bool {
        self.texts.iter().any(|name| name == column)
    }

    /// Whether the particles are counted.
    pub(crate) fn is_counting(&self) -> bool {
        self.parts.is_none()
    }

    /// Passes a part on; does nothing where particles are counted.
    ///
    /// # Errors
    /// [`Error::Interrupted`] if nothing receives it.
    pub(super) fn pass(&self, part: Part) -> Result<()> {
        self.parts.as_ref().map_or(Ok(()), |parts| parts.send(part).map_err(|_| Error::Interrupted))
    }

    /// Counts spheres whose numbers were checked, or passes them on; without radii in the file their radii do not count.
    ///
    /// # Errors
    /// [`Error::Interrupted`] if nothing receives them, and errors of the selection.
    pub fn take_spheres(&self, spheres: &mut SphereRows, sized: bool) -> Result<()> {
        if self.is_counting() {
            self.count_spheres(spheres, sized);
            return Ok(());
        }
        let mut block = std::mem::take(spheres);
        if let Some(pick) = &self.pick {
            block = pick.lock().unwrap_or_else(PoisonError::into_inner).pick(block)?;
        }
        let SphereRows { centers, radii, colors } = block;
        let radii = if sized { radii } else { Vec::new() };
        self.pass(Part { positions: centers, radii, colors, checked: true, ..Part::default() })
    }

    /// Whether so many particles fill a part.
    pub(crate) fn is_full(&self, particles: usize) -> bool {
        particles >= self.part
    }

    /// Counts spheres and drops them; without radii in the file their radii are not counted.
    pub fn count_spheres(&self, spheres: &mut SphereRows, sized: bool) {
        self.counts().add(&Counted {
            positions: &spheres.centers,
            radii: if sized { &spheres.radii } else { &[] },
            colors: (ColorType::Real, &spheres.colors),
            elements: &[],
            columns: Vec::new(),
        });
        spheres.clear();
    }

    /// The counts so far.
    pub(super) fn counts(&self) -> MutexGuard<'_, Counts> {
        self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Counts {
    pub(super) fn add(&mut self, part: &Counted<'_>) {
        // A particle without a radius has a default.
        let radius = |n: usize| part.radii.get(n).copied().filter(|radius| !radius.is_nan()).unwrap_or(1.0);
        let is_invalid = |n: &usize| !(is_center(&part.positions[*n]) & is_radius(&radius(*n)));
        if self.invalid.is_none()
            && let Some(n) = (0..part.positions.len()).find(is_invalid)
        {
            self.invalid = Some((self.particles + n as u64, part.positions[n], radius(n)));
        }
        self.particles += part.positions.len() as u64;
        for position in part.positions {
            for (axis, x) in position.iter().enumerate() {
                self.extent[0][axis] = self.extent[0][axis].min(*x);
                self.extent[1][axis] = self.extent[1][axis].max(*x);
            }
        }
        for radius in part.radii.iter().filter(|radius| !radius.is_nan()) {
            self.radii = [self.radii[0].min(*radius), self.radii[1].max(*radius)];
            self.sized += 1;
        }
        let (kind, colors) = part.colors;
        self.colored += colors.len() as u64;
        if !colors.is_empty() {
            self.colors.see(kind, colors);
        }
        part.elements.iter().for_each(|number| self.elements[usize::from(*number)] += 1);
        for (name, values, text) in &part.columns {
            if !self.columns.contains_key(*name) {
                self.columns.insert((*name).to_owned(), ColumnCounts::new());
            }
            if let Some(counts) = self.columns.get_mut(*name) {
                counts.text |= text;
                values.iter().for_each(|value| counts.add(*value, *text));
            }
        }
    }

    /// Finishes an inference whose atoms were all counted; returns what to report.
    pub(super) fn infer(&mut self, inference: Inference) -> Vec<String> {
        let inferred = inference.finish_counts(&mut self.elements);
        for (slot, name) in inferred.names.iter().enumerate() {
            let count = std::mem::take(&mut self.elements[code_of_unknown(slot)]);
            self.elements[0] += count;
            if count > 0 {
                *self.unknown.entry(name.clone()).or_default() += count;
            }
        }
        inferred.sentences(self.particles + inferred.sites())
    }

    /// Counts texts among the numbers of a column, which are counted as missing numbers too.
    pub(super) fn mix(&mut self, column: &str, texts: BTreeMap<String, u64>) {
        if texts.is_empty() {
            return;
        }
        let counts = self.columns.entry(column.to_owned()).or_insert_with(ColumnCounts::new);
        for (text, count) in texts {
            if let Some(known) = counts.texts.get_mut(&text) {
                *known += count;
            } else if counts.text_bytes < MOST_TEXTS {
                counts.text_bytes += text.len() + TEXT;
                counts.texts.insert(text, count);
            } else {
                counts.values = None;
            }
        }
    }

    pub(super) fn add_unknown(&mut self, unknown: BTreeMap<String, u64>) {
        unknown.into_iter().for_each(|(name, count)| *self.unknown.entry(name).or_default() += count);
    }
}

impl ColumnCounts {
    fn new() -> Self {
        Self {
            ends: [f64::INFINITY, f64::NEG_INFINITY],
            missing: 0,
            infinite: 0,
            values: Some(BTreeMap::new()),
            text: false,
            labels: Vec::new(),
            texts: BTreeMap::new(),
            text_bytes: 0,
        }
    }

    /// Whether the column has texts: where they are words for missing numbers alone, it has no numbers.
    pub fn is_text(&self) -> bool {
        let has_numbers = self.ends[0] <= self.ends[1] || self.infinite > 0;
        self.text || self.texts.keys().any(|text| !(has_numbers && is_missing(text)))
    }

    fn add(&mut self, value: f64, text: bool) {
        if !value.is_finite() {
            self.missing += u64::from(value.is_nan());
            self.infinite += u64::from(value.is_infinite());
            return;
        }
        self.ends = [self.ends[0].min(value), self.ends[1].max(value)];
        let Some(values) = &mut self.values else { return };
        let whole = value.fract() == 0.0 && value.abs() < 1e15;
        let known = values.contains_key(&(value as i64));
        if whole && (text || known || values.len() < VALUES) {
            *values.entry(value as i64).or_default() += 1;
        } else {
            self.values = None;
        }
    }
}
