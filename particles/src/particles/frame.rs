//! The particles of a frame, as a file lists them, and the trait of their readers.

use super::colors::{ColorSurvey, ColorType};
use super::frame_time::FrameTime;
use super::infer;
use super::infer::species::Species;
use super::infer::{Inference, Inferred};
use super::left_out::LeftOut;
use super::mixed::{Mixed, SPELLED};
use super::names::Names;
use super::placed::PlacedPart;
use super::survey::{Counted, Counts, Part, Survey};
use super::vectors;
use crate::select::Note;
use crate::skipped::Skipped;
use halfline_ground::Cell;
use halfline_ground::check::keep;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::{check, entries, extend_to};
use halfline_ground::quote::setting::STREAM;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A property of spheres that the style's rules give to selected particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RuleTarget {
    Color,
    Radius,
    Opacity,
    Material,
    Place,
}

impl RuleTarget {
    /// The number of properties.
    pub const COUNT: usize = 5;
}

/// One frame of particles, as the file has them.
#[derive(Debug, Clone, Default)]
pub struct Particles {
    /// Positions in the file's unit; nanometres of GROMACS are converted to ångström.
    pub positions: Vec<[f64; 3]>,
    /// Radii in the same unit; empty if the file has none, NaN for a particle without one.
    pub radii: Vec<f64>,
    /// Atomic numbers, 0 for an unknown element; empty where the format has no elements.
    pub elements: Vec<u8>,
    /// Colours, as the numbers of the file until they are made linear RGB; empty if the file has none.
    pub colors: Vec<[f32; 3]>,
    /// The type of these numbers, which decides how they become linear RGB.
    #[doc(hidden)]
    pub color_type: ColorType,
    /// The columns of [`ParticleOptions::columns`](crate::ParticleOptions::columns) that the file has, with a number for
    /// every particle. Names of columns in files are converted to lower case.
    pub columns: Vec<Column>,
    /// Whether the reader has checked the positions and the radii by [`check_sphere`](halfline_ground::check::check_sphere), and named the
    /// row of the first that is not valid.
    #[doc(hidden)]
    pub checked: bool,
    /// The number of particles before them, in the parts of the file that were passed on.
    #[doc(hidden)]
    pub before: u64,
    /// The files that the particles are of, each with the index of its first particle; empty for one file.
    #[doc(hidden)]
    pub files: Vec<(PathBuf, u64)>,
    /// The names of all columns of the file, for messages.
    pub has: Vec<String>,
    /// The columns whose names have capitals in the file, by the names in lower case.
    pub shown: BTreeMap<String, String>,
    /// For columns of names: the column's name, and the names that its whole numbers, from 0, refer to.
    pub labels: BTreeMap<String, Vec<String>>,
    /// The indices in the file, where some particles were removed; empty where none was.
    pub places: Vec<u32>,
    /// The number of particles in the file, where some were removed.
    #[doc(hidden)]
    pub listed: usize,
    /// By [`RuleTarget`] the numbers from 1 of the style's rules for each particle, 0 for none; empty without rules.
    #[doc(hidden)]
    pub rules: [Vec<u16>; RuleTarget::COUNT],
    /// The particles of each of `ParticleOptions::marks`, and what its evaluation said.
    #[doc(hidden)]
    pub marks: Vec<(Vec<bool>, Vec<Note>)>,
    /// The periodic cell, if the file has one.
    pub cell: Option<Cell>,
    /// The edges of the cell along which it does not repeat, as far as the file says so.
    pub open_edges: [bool; 3],
    /// The copies of the particles, where an assembly is kept as operators: parts that together are all particles.
    pub placed: Vec<PlacedPart>,
    /// Its time and step.
    pub when: FrameTime,
    /// Names that are not elements, with the number of their particles.
    pub unknown: BTreeMap<String, u64>,
    /// Skipped records and assumptions.
    pub skipped: Skipped,
    /// The state of the reading; empty in a frame that was read.
    #[doc(hidden)]
    pub reading: Reading,
}

/// The state of a frame while it is read.
#[derive(Debug, Clone, Default)]
pub struct Reading {
    /// The index and the names of each column of text, while it is read.
    pub(crate) texts: Vec<(usize, Names)>,
    /// Atom names and virtual sites in a column of symbols, while it is read.
    pub(crate) species: Species,
    /// The columns whose rows decide whether they are of numbers or of texts, while they are read.
    pub(crate) mixed: Vec<Mixed>,
    /// Invalid rows that are left out, while they are read.
    pub(crate) left_out: LeftOut,
    /// The survey that counts the particles or passes them on in parts; `None` keeps them.
    pub(crate) survey: Option<Survey>,
    /// The number of particles for which all lists have capacity.
    pub(crate) room: usize,
}

impl Column {
    fn named(&self) -> (&str, &[f64]) {
        (&self.name, &self.values)
    }
}

/// A column of numbers, one per particle.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Column {
    pub name: String,
    pub values: Vec<f64>,
}

impl Particles {
    /// The column of this name, in any case.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name.eq_ignore_ascii_case(name))
    }

    /// Adds the length of the vector that each of these names means, unless a column has the name.
    ///
    /// # Errors
    /// [`Error::Limits`] where memory is short.
    #[doc(hidden)]
    pub fn add_lengths(&mut self, requested: &[String]) -> Result<()> {
        for name in requested {
            let numbers = self.columns.iter().filter(|column| !self.labels.contains_key(&column.name));
            let named: Vec<(&str, &[f64])> = numbers.map(Column::named).collect();
            if self.column(name).is_some() {
                continue;
            }
            if let Some(parts) = vectors::parts(name, &named) {
                check(8 * self.positions.len() as u64, || format!("the column {name}"))?;
                let values = vectors::length(&parts);
                self.columns.push(Column { name: name.clone(), values });
            }
        }
        Ok(())
    }

    /// Counts particles with a name that is not an element. The number of different names is limited.
    pub(crate) fn add_unknown(&mut self, name: &str, count: u64) {
        let keep = self.unknown.len() < 16 || self.unknown.contains_key(name);
        self.count_unknown(if keep { name } else { "others" }, count);
    }

    /// The same for a part of a file, which is small enough to keep all names.
    pub(super) fn count_unknown(&mut self, name: &str, count: u64) {
        match self.unknown.get_mut(name) {
            Some(known) => *known += count,
            None => drop(self.unknown.insert(name.to_owned(), count)),
        }
    }

    /// Appends the particles of a part with the same columns.
    ///
    /// # Errors
    /// As [`Particles::grow`].
    pub(super) fn append(&mut self, mut more: Self) -> Result<()> {
        self.grow(more.positions.len(), 0)?;
        self.positions.append(&mut more.positions);
        self.radii.append(&mut more.radii);
        self.elements.append(&mut more.elements);
        self.colors.append(&mut more.colors);
        // A part numbers its names by itself.
        for ((column, known), (_, names)) in self.reading.texts.iter_mut().zip(&more.reading.texts) {
            known.renumber(names, &mut more.columns[*column].values)?;
        }
        for (known, mixed) in self.reading.mixed.iter_mut().zip(more.reading.mixed) {
            let column = known.column;
            known.append(&mut self.columns[column].values, mixed, &mut more.columns[column].values)?;
        }
        for (column, more) in self.columns.iter_mut().zip(&mut more.columns) {
            column.values.append(&mut more.values);
        }
        more.unknown.iter().for_each(|(name, count)| self.add_unknown(name, *count));
        self.reading.species.add(more.reading.species);
        self.skipped.append(more.skipped);
        self.reading.left_out.append(more.reading.left_out);
        Ok(())
    }

    /// Reports the rows that were left out.
    pub(crate) fn tell_left_out(&mut self) {
        self.skipped.assumed.extend(std::mem::take(&mut self.reading.left_out).sentence());
    }

    /// Finishes columns of text and of symbols: finds the elements of names, and removes virtual sites.
    ///
    /// # Errors
    /// [`Error::Limits`] where memory is short.
    pub(crate) fn settle_texts(&mut self) -> Result<()> {
        self.tell_left_out();
        if let Some(survey) = self.reading.survey.clone().filter(Survey::is_counting) {
            let mut counts = survey.counts();
            self.count(&mut counts);
            let messages = std::mem::take(&mut self.reading.species).settle_counts(&mut counts.elements);
            counts.warnings.extend(messages);
        }
        for (column, names) in std::mem::take(&mut self.reading.texts) {
            self.labels.insert(self.columns[column].name.clone(), names.labels());
        }
        if self.reading.survey.is_none() {
            for mixed in std::mem::take(&mut self.reading.mixed) {
                let Column { name, values } = &mut self.columns[mixed.column];
                if let Some(labels) = mixed.settle(values)? {
                    self.labels.insert(name.clone(), labels);
                }
            }
        }
        let (messages, sites) = std::mem::take(&mut self.reading.species).settle(&mut self.elements);
        self.skipped.assumed.extend(messages);
        self.leave_sites_out(sites);
        Ok(())
    }

    pub(super) fn leave_sites_out(&mut self, there: bool) {
        if there {
            let stays: Vec<bool> = self.elements.iter().map(|code| !infer::is_site(*code)).collect();
            self.keep(&stays);
        }
    }

    /// Finishes an inference: removes virtual sites and returns what to report. For a survey the particles are counted
    /// and dropped.
    pub(super) fn infer(&mut self, mut inference: Inference, survey: Option<&Survey>) -> Vec<String> {
        if let Some(survey) = survey {
            self.count_part(&mut inference, survey);
            return survey.counts().infer(inference);
        }
        let read = self.elements.len() as u64;
        let inferred = inference.finish(&mut self.elements);
        self.leave_sites_out(inferred.sites() > 0);
        let sentences = inferred.sentences(read);
        self.count_unknown_atoms(&inferred);
        sentences
    }

    /// Counts unknown atoms by the names that an inference numbered, and sets their atomic number to 0.
    pub(super) fn count_unknown_atoms(&mut self, inferred: &Inferred) {
        let mut counts = vec![0; inferred.names.len()];
        for element in &mut self.elements {
            if let Some(slot) = infer::unknown(*element) {
                counts[slot] += 1;
                *element = 0;
            }
        }
        self.unknown = inferred.names.iter().cloned().zip(counts).filter(|(_, count)| *count > 0).collect();
    }

    /// The counts of a frame that was read for this survey.
    #[doc(hidden)]
    pub fn counted(mut self, survey: &Survey) -> Counts {
        let mut shared = survey.counts();
        self.count(&mut shared);
        let mut counts = std::mem::take(&mut *shared);
        for (name, labels) in self.labels {
            if let Some(column) = counts.columns.get_mut(&name) {
                column.labels = labels;
            }
        }
        counts.shown = self.shown;
        counts.add_unknown(self.unknown);
        counts.cell = self.cell;
        counts.warnings.extend(self.skipped.warnings());
        let warning = counts.colors.warning();
        counts.warnings.extend(warning);
        counts
    }

    /// Counts a part whose elements are still being inferred, and drops it.
    pub(super) fn count_part(&mut self, inference: &mut Inference, survey: &Survey) {
        inference.end_part(&mut self.elements);
        self.count(&mut survey.counts());
    }

    /// Counts the particles without virtual sites and drops them; what describes the frame as a whole is kept.
    pub(super) fn count(&mut self, counts: &mut Counts) {
        for mixed in &mut self.reading.mixed {
            let Column { name, values } = &mut self.columns[mixed.column];
            counts.mix(name, mixed.take_texts(values));
        }
        self.leave_sites_out(self.elements.iter().any(|code| infer::is_site(*code)));
        let columns = self.columns.iter().filter(|column| !["x", "y", "z"].contains(&column.name.as_str()));
        let named: Vec<(&str, &[f64])> = self.columns.iter().map(Column::named).collect();
        let has_speed = named.iter().any(|(name, _)| name.eq_ignore_ascii_case(vectors::VELOCITY));
        let speed = vectors::parts(vectors::VELOCITY, &named).filter(|_| !has_speed);
        let speed = speed.map(|parts| vectors::length(&parts));
        let speed = speed.iter().map(|speed| (vectors::VELOCITY, &speed[..], false));
        counts.add(&Counted {
            positions: &self.positions,
            radii: &self.radii,
            colors: (self.color_type, &self.colors),
            elements: &self.elements,
            columns: columns
                .map(|column| (&column.name[..], &column.values[..], self.is_text(&column.name)))
                .chain(speed)
                .collect(),
        });
        self.positions.clear();
        self.radii.clear();
        self.elements.clear();
        self.colors.clear();
        self.columns.iter_mut().for_each(|column| column.values.clear());
        self.places.clear();
    }

    /// Takes the particles so far away, as a part of the frame.
    ///
    /// # Errors
    /// [`Error::Settings`] for a column of elements that is understood only from the whole file.
    pub(super) fn split_off(&mut self) -> Result<Part> {
        if self.reading.species != Species::default() {
            let problem = "the column of elements has atom names, which are understood only from the whole file";
            return Err(Error::settings(problem, format!("remove {STREAM}")));
        }
        self.reading.room = 0;
        // The next part numbers its names anew, so that the names of a file need no memory.
        let texts = self
            .reading
            .texts
            .iter_mut()
            .map(|(n, names)| (self.columns[*n].name.clone(), std::mem::take(names).labels()));
        let labels = texts.collect();
        let columns = self.columns.iter_mut();
        Ok(Part {
            positions: std::mem::take(&mut self.positions),
            radii: std::mem::take(&mut self.radii),
            elements: std::mem::take(&mut self.elements),
            colors: std::mem::take(&mut self.colors),
            color_type: self.color_type,
            columns: columns.map(|column| (column.name.clone(), std::mem::take(&mut column.values))).collect(),
            labels,
            has: self.has.clone(),
            checked: self.checked,
        })
    }

    /// The particles of a part.
    #[doc(hidden)]
    pub fn of_part(part: Part) -> Self {
        let Part { positions, radii, elements, colors, color_type, columns, labels, has, checked } = part;
        let columns = columns.into_iter().map(|(name, values)| Column { name, values }).collect();
        Self { positions, radii, elements, colors, color_type, columns, labels, has, checked, ..Self::default() }
    }

    /// Whether a column has names.
    pub(super) fn is_text(&self, name: &str) -> bool {
        let reading = self.reading.texts.iter().any(|(column, _)| self.columns[*column].name == name);
        reading || self.labels.contains_key(name)
    }

    /// The numbers from 1 of the rules that give the particles this property, 0 for none; empty without rules.
    #[doc(hidden)]
    pub fn rule_numbers(&self, target: RuleTarget) -> &[u16] {
        &self.rules[target as usize]
    }

    /// The index of the rule that gives particle `n` this property; `None` where none does.
    #[doc(hidden)]
    pub fn rule(&self, target: RuleTarget, n: usize) -> Option<usize> {
        self.rule_numbers(target).get(n).and_then(|number| usize::from(*number).checked_sub(1))
    }

    /// Whether rules give some particles this property.
    #[doc(hidden)]
    pub fn has_rules(&self, target: RuleTarget) -> bool {
        !self.rule_numbers(target).is_empty()
    }

    /// Makes the colours of a whole file linear light, and adds what is assumed of them. Particles that are selected do not tell
    /// what the numbers of the file are, so this comes before any selection.
    #[doc(hidden)]
    pub fn lighten(&mut self) {
        let mut file = ColorSurvey::default();
        file.see(self.color_type, &self.colors);
        self.lighten_part(&file);
        self.skipped.assumed.extend(file.warning());
    }

    /// The same for a part of a file, whose colours have this in common.
    #[doc(hidden)]
    pub fn lighten_part(&mut self, file: &ColorSurvey) {
        file.lighten(&mut self.colors);
    }

    /// The index of particle `n` in the file.
    #[doc(hidden)]
    pub fn index(&self, n: usize) -> u64 {
        self.before + self.places.get(n).map_or(n as u64, |place| u64::from(*place))
    }

    /// The place of particle `n` for errors; `file` is the place of the only file.
    #[doc(hidden)]
    pub fn place(&self, n: usize, file: &Place) -> Place {
        let index = self.index(n);
        let (file, first) = match self.files.iter().rev().find(|(_, first)| *first <= index) {
            Some((path, first)) => (Place::file(path.display().to_string()), *first),
            None => (file.clone(), 0),
        };
        file.named(format!("particle {}", index - first))
    }

    /// Keeps the particles whose flag is set.
    pub(crate) fn keep(&mut self, stays: &[bool]) {
        if self.places.is_empty() {
            self.places = (0..self.positions.len() as u32).collect();
            self.listed = self.positions.len();
        }
        keep(&mut self.places, stays);
        self.rules.iter_mut().for_each(|rules| keep(rules, stays));
        self.marks.iter_mut().for_each(|(mask, _)| keep(mask, stays));
        keep(&mut self.positions, stays);
        keep(&mut self.radii, stays);
        keep(&mut self.elements, stays);
        keep(&mut self.colors, stays);
        self.columns.iter_mut().for_each(|column| keep(&mut column.values, stays));
    }

    /// Keeps the particles of these rows, in their order.
    pub(super) fn arrange(&mut self, rows: &[u32]) {
        if self.places.is_empty() {
            self.places = (0..self.positions.len() as u32).collect();
            self.listed = self.positions.len();
        }
        self.places = of_rows(&self.places, rows);
        self.positions = of_rows(&self.positions, rows);
        self.radii = of_rows(&self.radii, rows);
        self.elements = of_rows(&self.elements, rows);
        self.colors = of_rows(&self.colors, rows);
        self.columns.iter_mut().for_each(|column| column.values = of_rows(&column.values, rows));
    }

    /// Reserves capacity for `more` particles in every list, counting `extra` bytes per particle that the reader
    /// keeps: an endless file must not fill the memory.
    ///
    /// # Errors
    /// [`Error::Limits`].
    pub(crate) fn grow(&mut self, more: usize, extra: usize) -> Result<()> {
        let n = self.positions.len();
        if let Some(survey) = self.reading.survey.clone()
            && survey.is_full(n)
        {
            match survey.is_counting() {
                true => self.count(&mut survey.counts()),
                false => survey.pass(self.split_off()?)?,
            }
            return Ok(());
        }
        if n + more <= self.reading.room {
            return Ok(());
        }
        let columns = self.columns.len() * size_of::<f64>() + self.reading.mixed.len() * SPELLED;
        // A list that is empty after the first particle stays empty.
        let of = |is_empty: bool, bytes: usize| if is_empty { 0 } else { bytes };
        let [radius, element, color] =
            [of(self.radii.is_empty(), 8), of(self.elements.is_empty(), 1), of(self.colors.is_empty(), 12)];
        let room = entries(n, more, size_of::<[f64; 3]>() + radius + element + color + columns + extra, "spheres")?;
        extend_to(&mut self.positions, room)?;
        if radius > 0 {
            extend_to(&mut self.radii, room)?;
        }
        if element > 0 {
            extend_to(&mut self.elements, room)?;
        }
        if color > 0 {
            extend_to(&mut self.colors, room)?;
        }
        for column in &mut self.columns {
            extend_to(&mut column.values, room)?;
        }
        self.reading.room = room;
        Ok(())
    }
}

/// The values of these rows; none of a list that is empty.
pub(super) fn of_rows<T: Copy>(values: &[T], rows: &[u32]) -> Vec<T> {
    let rows = if values.is_empty() { &[] } else { rows };
    rows.iter().map(|row| values[*row as usize]).collect()
}

/// A file of particles, frame by frame.
pub trait ParticleFrames: Send {
    /// The next frame; `None` after the last.
    ///
    /// # Errors
    /// [`Error::Scene`] with line and column, [`Error::Io`].
    fn next(&mut self) -> Result<Option<Particles>>;

    /// Skips the next frame; returns `false` after the last.
    ///
    /// # Errors
    /// As [`ParticleFrames::next`].
    fn skip(&mut self) -> Result<bool> {
        Ok(self.next()?.is_some())
    }
}

/// A file with one frame, by what reads it.
pub(crate) struct OneFrame<F>(Option<F>);

impl<F: FnOnce() -> Result<Particles> + Send> OneFrame<F> {
    pub(crate) fn new(read: F) -> Self {
        Self(Some(read))
    }
}

impl<F: FnOnce() -> Result<Particles> + Send> ParticleFrames for OneFrame<F> {
    fn next(&mut self) -> Result<Option<Particles>> {
        self.0.take().map(|read| read()).transpose()
    }
}

#[cfg(test)]
impl Particles {
    /// The particles with colours in linear light, for the readers' tests.
    pub(crate) fn linearized(mut self) -> Self {
        self.lighten();
        self
    }
}

/// All frames, for the readers' tests.
#[cfg(test)]
pub(crate) fn all(mut frames: impl ParticleFrames) -> Result<Vec<Particles>> {
    std::iter::from_fn(|| frames.next().transpose()).collect()
}
