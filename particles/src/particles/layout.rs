//! Columns by name: positions, radii, colours, elements, and requested columns. All formats with named columns share
//! it.

mod slot;

use super::colors::ColorType;
use super::frame::{Column, Particles, Reading};
use super::meaning::Meanings;
use super::mixed::Mixed;
use super::names::Names;
use super::request::Request;
use super::role::Role;
use super::survey::Survey;
use crate::lines::{Lines, Word};
use crate::skipped::Skipped;
use halfline_ground::check::check_color;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::quote;
use halfline_ground::quote::setting::{COLUMNS, SKIP_INVALID};
use slot::{ParticleBuilder, Slot};
use std::collections::BTreeMap;
use std::io::BufRead;

/// The columns of a row in the order of the file.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    slots: Vec<Slot>,
    /// The names of columns to keep.
    to_keep: Vec<String>,
    /// The survey that counts the particles or passes them on in parts; `None` keeps them.
    survey: Option<Survey>,
    /// The requested columns that the file has.
    requested: Vec<String>,
    /// The indices of the requested columns that are text, and of those whose rows decide what they are.
    texts: Vec<usize>,
    mixed: Vec<usize>,
    /// The names of all columns.
    has: Vec<String>,
    /// The requested columns whose names have capitals in the file, by the names in lower case.
    shown: BTreeMap<String, String>,
    /// Bytes of all names.
    named: usize,
    /// Whether rows with invalid coordinates or radii are left out instead of being errors; `None` where they cannot be.
    skip_invalid: Option<bool>,
    /// The type of the colours' numbers, which decides how they become linear RGB.
    color_type: ColorType,
    /// Warnings about columns that are not taken.
    warnings: Vec<String>,
}

/// The most columns.
const MOST: usize = 4096;

/// The most bytes of their names; every component of a vector has its own name.
const MOST_NAMED: usize = 1 << 20;

impl Layout {
    /// No columns yet, for this request.
    pub(crate) fn new(request: &Request) -> Self {
        let (to_keep, survey) = (request.columns.clone(), request.survey.clone());
        Self { to_keep, survey, skip_invalid: Some(request.skip_invalid), ..Self::default() }
    }

    /// No columns yet, for a reader that keeps every row until the end of the file.
    pub(crate) fn whole(request: &Request) -> Self {
        Self { to_keep: request.columns.clone(), ..Self::default() }
    }

    /// Adds the columns of fields.
    pub(crate) fn add_fields(&mut self, meanings: Meanings) -> Result<(), String> {
        for columns in meanings.fields {
            for (name, role) in &columns {
                self.add(name, *role)?;
            }
            if let [(first, Role::Other), ..] = &columns[..] {
                self.vector(first.trim_end_matches("_x"), columns.len());
            }
        }
        self.color_type = meanings.color_type;
        self.warnings.extend(meanings.warnings);
        Ok(())
    }

    /// Sets the type of the colours' numbers, and adds warnings about columns that are not taken.
    pub(crate) fn note(&mut self, color_type: ColorType, warnings: Vec<String>) {
        self.color_type = color_type;
        self.warnings.extend(warnings);
    }

    /// Adds a warning.
    pub(crate) fn warn(&mut self, warning: String) {
        self.warnings.push(warning);
    }

    /// Adds a column. A column that occurs twice is an error, because it is ambiguous.
    pub(crate) fn add(&mut self, name: &str, role: Role) -> Result<(), String> {
        if self.slots.len() == MOST {
            return Err(format!("more than {MOST} columns"));
        }
        self.named += name.len();
        if self.named > MOST_NAMED {
            return Err(format!("the names of the columns have more than {MOST_NAMED} bytes"));
        }
        let (shown, name) = (name, name.to_lowercase());
        let twice = |name: &str| Err(format!("{} occurs twice", quote(name)));
        // Two columns with the same meaning: the first is used, if they have other names.
        let known = self.slots.iter().find(|slot| slot.role == role && !matches!(role, Role::Other | Role::Text));
        let role = match role {
            Role::Number if known.is_some_and(|slot| slot.name != name) => Role::Other,
            Role::Symbol if known.is_some_and(|slot| slot.name != name) => Role::Text,
            _ if known.is_some() => return twice(&name),
            Role::Number if self.contains(Role::Symbol) => Role::Other,
            Role::Symbol if self.contains(Role::Number) => Role::Text,
            Role::Diameter if self.contains(Role::Radius) => Role::Other,
            Role::Radius if self.contains(Role::Diameter) => Role::Other,
            Role::Other if self.survey.as_ref().is_some_and(|survey| survey.has_texts(&name)) => Role::Text,
            role => role,
        };
        let mut slot = Slot { name, role, requested: None, text: None, part: None, mixed: None };
        self.has.push(slot.name.clone());
        if is_requested(&self.to_keep, &slot.name) {
            // A column whose name another has cannot be asked for; among all of them it is numbered, as by pandas.
            let is_every = self.to_keep.iter().any(|name| name == EVERY);
            let mut number = 0;
            let first = slot.name.clone();
            while self.requested.contains(&slot.name) {
                if !is_every {
                    return twice(&first);
                }
                number += 1;
                slot.name = format!("{first}.{number}");
            }
            if shown != slot.name && !self.requested.contains(&slot.name) {
                self.shown.insert(slot.name.clone(), slot.name.replacen(&first, shown, 1));
            }
            slot.requested = Some(self.requested.len());
            if matches!(role, Role::Symbol | Role::Text) {
                slot.text = Some(self.texts.len());
                self.texts.push(self.requested.len());
            }
            let is_whole = self.survey.as_ref().is_none_or(Survey::is_counting);
            if role == Role::Other && is_whole {
                slot.mixed = Some(self.mixed.len());
                self.mixed.push(self.requested.len());
            }
            self.requested.push(slot.name.clone());
        }
        self.slots.push(slot);
        Ok(())
    }

    /// Whether rows with invalid coordinates or radii are left out.
    pub(crate) fn skips_invalid(&self) -> bool {
        self.skip_invalid == Some(true)
    }

    /// Adds the option that leaves such rows out to the remedy of an error, where the option applies.
    pub(crate) fn offer_to_skip(&self, column: usize, error: Error) -> Error {
        let applies = self.skip_invalid == Some(false) && self.slots[column].role.is_checked();
        if applies { offer_to_skip(error) } else { error }
    }

    /// Declares the last `count` columns as a vector of this name, whose length can be requested.
    pub(crate) fn vector(&mut self, name: &str, count: usize) {
        if count < 2
            || self.requested.iter().any(|requested| requested.eq_ignore_ascii_case(name))
            || !self.to_keep.iter().any(|w| w.eq_ignore_ascii_case(name))
        {
            return;
        }
        let from = self.slots.len() - count;
        for (k, slot) in self.slots[from..].iter_mut().enumerate() {
            slot.part = Some((self.requested.len(), k == 0));
        }
        self.requested.push(name.to_lowercase());
    }

    /// The number of columns.
    pub(crate) fn len(&self) -> usize {
        self.slots.len()
    }

    /// Whether a column has this role.
    pub(crate) fn contains(&self, role: Role) -> bool {
        self.slots.iter().any(|slot| slot.role == role)
    }

    /// The meaning of a column.
    pub(crate) fn role(&self, column: usize) -> Role {
        self.slots[column].role
    }

    /// An empty list of particles with a list for every requested column; for a survey they are counted and dropped.
    pub(crate) fn begin(&self) -> Particles {
        let mut skipped = Skipped { assumed: self.warnings.clone(), ..Skipped::default() };
        let is_sized = self.slots.iter().any(|slot| matches!(slot.role, Role::Radius | Role::Diameter));
        let is_radius = |slot: &&Slot| slot.role == Role::Other && ["r", "rad"].contains(&slot.name.as_str());
        if let Some(slot) = self.slots.iter().find(is_radius).filter(|_| !is_sized) {
            let name = &slot.name;
            skipped.assumed.push(format!(
                "the column {name} is not read as a radius; call it radius, or in a table use {COLUMNS} radius={name}"
            ));
        }
        let part = self.begin_part();
        let reading = Reading { survey: self.survey.clone(), ..part.reading };
        Particles { has: self.has.clone(), shown: self.shown.clone(), skipped, reading, ..part }
    }

    /// The same for a part of the file, without the names of the other columns.
    pub(crate) fn begin_part(&self) -> Particles {
        let columns = self.requested.iter().map(|name| Column { name: name.clone(), values: Vec::new() }).collect();
        let texts = self.texts.iter().map(|column| (*column, Names::default())).collect();
        let mixed = self.mixed.iter().map(|column| Mixed::of(*column)).collect();
        let reading = Reading { texts, mixed, ..Reading::default() };
        Particles { columns, reading, color_type: self.color_type, ..Particles::default() }
    }

    /// Adds a particle from the words of a line, or counts the line as left out; words after the last column are ignored.
    pub(crate) fn row<'a, R: BufRead + 'a>(
        &self,
        words: &mut (impl Iterator<Item = Word<'a, R>> + Clone),
        lines: &Lines<R>,
        particles: &mut Particles,
    ) -> Result<()> {
        if self.skips_invalid()
            && let Some(error) = self.invalid(words.clone())
        {
            particles.reading.left_out.add(error);
            words.take(self.slots.len()).for_each(drop);
            return Ok(());
        }
        self.valid_row(words, lines, particles)
    }

    /// Whether a line is a valid row.
    pub(crate) fn fits<'a, R: BufRead + 'a>(
        &self,
        mut words: impl Iterator<Item = Word<'a, R>>,
        lines: &Lines<R>,
    ) -> bool {
        self.valid_row(&mut words, lines, &mut self.begin_part()).is_ok()
    }

    /// The error of the first invalid coordinate or radius of a row; `None` for a valid row or one that lacks columns.
    fn invalid<'a, R: BufRead + 'a>(&self, mut words: impl Iterator<Item = Word<'a, R>>) -> Option<Error> {
        let mut first = None;
        for slot in &self.slots {
            let word = words.next()?;
            let checked = match slot.role {
                Role::Position(_) => word.finite(&slot.name),
                Role::Radius | Role::Diameter => word.positive(&slot.name),
                _ => continue,
            };
            first = first.or(checked.err());
        }
        first
    }

    fn valid_row<'a, R: BufRead + 'a>(
        &self,
        words: &mut impl Iterator<Item = Word<'a, R>>,
        lines: &Lines<R>,
        particles: &mut Particles,
    ) -> Result<()> {
        particles.grow(1, 0)?;
        let mut builder = ParticleBuilder::default();
        for (count, slot) in self.slots.iter().enumerate() {
            let Some(word) = words.next() else {
                let problem = format!("expected {} fields, found {count}", self.slots.len());
                return Err(lines.ends(&slot.name, problem, "use one field per column"));
            };
            slot.word(&word, &mut builder, particles).map_err(|error| self.offer_to_skip(count, error))?;
        }
        if let Some(color) = builder.color {
            check_color(color, || lines.place(builder.color_at).named("color"))?;
            particles.colors.push(color);
        }
        particles.positions.push(builder.position);
        Ok(())
    }

    /// Adds `count` particles to a part without any, from the numbers of each column, one column after the other; returns false, and
    /// adds none, where a coordinate, a radius or a colour is invalid.
    pub(crate) fn valid_columns(&self, count: usize, numbers: &[f64], particles: &mut Particles) -> bool {
        let columns = || self.slots.iter().zip(numbers.chunks_exact(count.max(1)));
        // Without branches within a column, so that compilers vectorize it.
        let are_valid =
            |(slot, column): (&Slot, &[f64])| !column.iter().fold(false, |any, x| any | slot.is_invalid(*x));
        if !columns().all(are_valid) {
            return false;
        }
        particles.positions.resize(count, [0.0; 3]);
        for (slot, column) in columns() {
            slot.put_all(column, particles);
        }
        true
    }

    /// Adds a particle from a number for every column, or counts it as left out; `placed` gives an error its place in the file.
    ///
    /// # Errors
    /// [`Error::Scene`] for an invalid coordinate, radius or colour.
    pub(crate) fn checked_numbers(
        &self,
        numbers: &[f64],
        particles: &mut Particles,
        placed: impl Fn(Error) -> Error,
    ) -> Result<()> {
        let is_invalid = |(slot, x): &(&Slot, &f64)| !matches!(slot.role, Role::Color(_)) && slot.is_invalid(**x);
        let Some((slot, x)) = self.slots.iter().zip(numbers).find(is_invalid) else {
            return self.numbers(numbers, particles).map_err(placed);
        };
        let what = if x.is_finite() { "positive" } else { "finite" };
        let problem = format!("{x} is not {what}");
        self.refuse(
            placed(Error::scene(Place::field(&slot.name), problem, "use a finite number such as 0.5")),
            particles,
        )
    }

    /// Counts a row that has this error as left out, or returns it.
    ///
    /// # Errors
    /// This error.
    pub(crate) fn refuse(&self, error: Error, particles: &mut Particles) -> Result<()> {
        match (self.skip_invalid, error) {
            (Some(true), error) => {
                particles.reading.left_out.add(error);
                Ok(())
            }
            (Some(false), error) => Err(offer_to_skip(error)),
            (None, error) => Err(error),
        }
    }

    /// Adds a particle from a number for every column.
    ///
    /// # Errors
    /// [`Error::Scene`] for an invalid colour, without its place.
    pub(crate) fn numbers(&self, numbers: &[f64], particles: &mut Particles) -> Result<()> {
        particles.grow(1, 0)?;
        let mut builder = ParticleBuilder::default();
        for (slot, number) in self.slots.iter().zip(numbers) {
            slot.put(*number, &mut builder, particles);
        }
        if let Some(color) = builder.color {
            check_color(color, || Place::field("color"))?;
            particles.colors.push(color);
        }
        particles.positions.push(builder.position);
        Ok(())
    }
}

fn offer_to_skip(error: Error) -> Error {
    match error {
        Error::Scene { place, problem, mend, source } => {
            let mend = format!("{mend}, or add {SKIP_INVALID} to leave such rows out");
            Error::Scene { place, problem, mend, source }
        }
        error => error,
    }
}

/// Whether a column is requested; `*` requests all.
pub(crate) fn is_requested(requested: &[String], name: &str) -> bool {
    requested.iter().any(|requested| requested == EVERY || requested.eq_ignore_ascii_case(name))
}

/// The requested ones of a format's columns, in the order of the request.
pub(crate) fn named<T: Copy>(requested: &[String], columns: &[(&str, T)]) -> Vec<T> {
    if requested.iter().any(|requested| requested == EVERY) {
        return columns.iter().map(|(_, column)| *column).collect();
    }
    let find = |name: &String| columns.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
    requested.iter().filter_map(find).map(|(_, column)| *column).collect()
}

/// The name that requests every column.
pub(crate) const EVERY: &str = "*";
