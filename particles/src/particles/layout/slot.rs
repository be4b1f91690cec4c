//! A column of a layout: where the words and the numbers of its rows go.

use crate::elements::element;
use crate::lines::Word;
use crate::particles::frame::Particles;
use crate::particles::mixed::is_missing;
use crate::particles::role::Role;
use halfline_ground::check::is_component;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::STREAM;
use std::io::BufRead;

/// A column.
#[derive(Debug)]
pub(super) struct Slot {
    pub(super) name: String,
    pub(super) role: Role,
    /// Its index among the requested columns.
    pub(super) requested: Option<usize>,
    /// For requested text: its index among the columns of text.
    pub(super) text: Option<usize>,
    /// For a component of a vector whose length is requested: the index among the requested columns, and whether it is
    /// the first component.
    pub(super) part: Option<(usize, bool)>,
    /// For a requested column whose rows decide what it is: its index among these.
    pub(super) mixed: Option<usize>,
}

/// A particle that is being read.
#[derive(Default)]
pub(super) struct ParticleBuilder {
    pub(super) position: [f64; 3],
    pub(super) color: Option<[f32; 3]>,
    /// The byte at which its colour begins.
    pub(super) color_at: usize,
}

impl Slot {
    /// Adds the word of a row.
    pub(super) fn word<R: BufRead>(
        &self,
        word: &Word<'_, R>,
        builder: &mut ParticleBuilder,
        particles: &mut Particles,
    ) -> Result<()> {
        let unread = self.requested.is_none() && self.part.is_none();
        if let (Some(column), Some(text)) = (self.requested, self.text) {
            let number = particles.reading.texts[text].1.number(word.content().as_bytes())?;
            particles.columns[column].values.push(f64::from(number));
        }
        if let (Some(column), Some(mixed)) = (self.requested, self.mixed) {
            let text = word.content();
            particles.reading.mixed[mixed].add(&text, &mut particles.columns[column].values)?;
            self.put_part(text.parse().unwrap_or(f64::NAN), particles);
            return Ok(());
        }
        let number = match self.role {
            Role::Text => return Ok(()),
            Role::Other if unread => return Ok(()),
            Role::Symbol => {
                let symbol = word.content();
                let number = particles.reading.species.code(&symbol);
                if number == 0 {
                    particles.count_unknown(&symbol, 1);
                }
                particles.elements.push(number);
                return Ok(());
            }
            Role::Radius | Role::Diameter => word.positive(&self.name)?,
            Role::Position(_) => word.finite(&self.name)?,
            Role::Color(k) => {
                if k == 0 {
                    builder.color_at = word.at;
                }
                word.finite(&self.name)?
            }
            // A missing number in a table is NaN.
            Role::Other | Role::Number if word.text.is_empty() || is_missing(word.text) => f64::NAN,
            Role::Other => word.number(&self.name).map_err(|error| match error {
                Error::Scene { place, problem, source, .. } => {
                    let mend = format!("use a number in every row, or remove {STREAM} for a column of texts");
                    Error::Scene { place, problem, mend, source }
                }
                other => other,
            })?,
            Role::Number => word.number(&self.name)?,
        };
        self.put(number, builder, particles);
        Ok(())
    }

    /// Whether a number of the column is one that no particle has.
    pub(super) fn is_invalid(&self, x: f64) -> bool {
        match self.role {
            Role::Position(_) => !x.is_finite(),
            // NaN is no radius.
            Role::Radius | Role::Diameter => x <= 0.0 || x == f64::INFINITY,
            Role::Color(_) => !is_component(x as f32),
            _ => false,
        }
    }

    /// Adds the numbers of the column to a part of so many particles.
    pub(super) fn put_all(&self, column: &[f64], particles: &mut Particles) {
        match self.role {
            Role::Position(axis) => particles.positions.iter_mut().zip(column).for_each(|(to, x)| to[axis] = *x),
            Role::Radius => particles.radii.extend(column),
            Role::Diameter => particles.radii.extend(column.iter().map(|x| x / 2.0)),
            Role::Color(k) => {
                particles.colors.resize(column.len(), [0.0; 3]);
                particles.colors.iter_mut().zip(column).for_each(|(to, x)| to[k] = *x as f32);
            }
            Role::Number => particles.elements.extend(column.iter().map(|x| number_of_element(*x))),
            Role::Symbol | Role::Text | Role::Other => {}
        }
        if let Some(requested) = self.requested {
            particles.columns[requested].values.extend(column);
        }
        match self.part {
            Some((length, true)) => particles.columns[length].values.extend(column.iter().map(|x| x.abs())),
            Some((length, false)) => {
                let lengths = particles.columns[length].values.iter_mut();
                lengths.zip(column).for_each(|(length, x)| *length = length.hypot(*x));
            }
            None => {}
        }
    }

    /// Adds the number of a row.
    pub(super) fn put(&self, number: f64, builder: &mut ParticleBuilder, particles: &mut Particles) {
        match self.role {
            Role::Position(axis) => builder.position[axis] = number,
            Role::Radius => particles.radii.push(number),
            Role::Diameter => particles.radii.push(number / 2.0),
            Role::Color(k) => builder.color.get_or_insert_default()[k] = number as f32,
            Role::Number => particles.elements.push(number_of_element(number)),
            Role::Symbol | Role::Text | Role::Other => {}
        }
        if let Some(column) = self.requested {
            particles.columns[column].values.push(number);
        }
        self.put_part(number, particles);
    }

    /// Adds a component to the length of the vector that it is a part of.
    fn put_part(&self, number: f64, particles: &mut Particles) {
        match self.part {
            Some((column, true)) => particles.columns[column].values.push(number.abs()),
            Some((column, false)) => {
                if let Some(length) = particles.columns[column].values.last_mut() {
                    *length = length.hypot(number);
                }
            }
            None => {}
        }
    }
}

/// The atomic number of an element; 0 for a number that is none.
fn number_of_element(number: f64) -> u8 {
    let whole = number as u8;
    if f64::from(whole) == number && element(whole).is_some() { whole } else { 0 }
}
