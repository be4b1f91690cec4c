//! Columns by name: which of them are places, radii, colours and elements, and which are asked for. The formats whose
//! columns have names share it.

use super::{Column, Particles};
use crate::error::{Error, Place, Result};
use crate::quote::quote;
use crate::scene::check_color;
use crate::scene::lines::{Lines, Word};
use crate::scene::style::elements::element;
use std::io::BufRead;

/// What a column is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// A coordinate, of axis 0, 1 or 2.
    Position(usize),
    Radius,
    Diameter,
    /// A component of linear RGB.
    Color(usize),
    /// The symbol of an element.
    Symbol,
    /// An atomic number.
    Number,
    /// No number; passed over.
    Text,
    /// A number that is read where it is asked for.
    Other,
}

/// The columns of a row in the order of the file.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    slots: Vec<Slot>,
    /// The columns that are asked for and here.
    asked: Vec<String>,
    /// The names of all columns of numbers.
    has: Vec<String>,
    /// Bytes of all names.
    named: usize,
}

#[derive(Debug)]
struct Slot {
    name: String,
    role: Role,
    /// Which of the columns asked for it is.
    asked: Option<usize>,
    /// Of which of the columns asked for, a vector's length, it is a component; and whether the first.
    part: Option<(usize, bool)>,
}

/// A particle in the making.
#[derive(Default)]
struct Making {
    position: [f64; 3],
    color: Option<[f32; 3]>,
    /// The byte its colour begins at.
    color_at: usize,
}

/// More columns than any file has.
const MOST: usize = 4096;

/// Bytes of their names: a vector's components each bear its name.
const MOST_NAMED: usize = 1 << 20;

impl Layout {
    /// One more column. What stands twice, and which of the two is meant cannot be told, is a problem.
    pub(crate) fn add(&mut self, name: &str, role: Role, wanted: &[String]) -> Result<(), String> {
        if self.slots.len() == MOST {
            return Err(format!("more than {MOST} columns"));
        }
        self.named += name.len();
        if self.named > MOST_NAMED {
            return Err(format!("the names of the columns have more than {MOST_NAMED} bytes"));
        }
        if !matches!(role, Role::Other | Role::Text) && self.slots.iter().any(|slot| slot.role == role) {
            return Err(format!("{} is given twice", quote(name)));
        }
        // Two ways of saying the same: the first is taken.
        let role = match role {
            Role::Number if self.contains(Role::Symbol) => Role::Other,
            Role::Symbol if self.contains(Role::Number) => Role::Text,
            Role::Diameter if self.contains(Role::Radius) => Role::Other,
            Role::Radius if self.contains(Role::Diameter) => Role::Other,
            role => role,
        };
        let name = name.to_lowercase();
        let mut slot = Slot { name, role, asked: None, part: None };
        if !matches!(role, Role::Symbol | Role::Text) {
            self.has.push(slot.name.clone());
            if wanted.iter().any(|wanted| wanted.eq_ignore_ascii_case(&slot.name)) {
                if self.asked.contains(&slot.name) {
                    return Err(format!("{} is given twice", quote(&slot.name)));
                }
                slot.asked = Some(self.asked.len());
                self.asked.push(slot.name.clone());
            }
        }
        self.slots.push(slot);
        Ok(())
    }

    /// The last `count` columns are a vector of this name, whose length can be asked for.
    pub(crate) fn vector(&mut self, name: &str, count: usize, wanted: &[String]) {
        if count < 2
            || self.asked.iter().any(|asked| asked == name)
            || !wanted.iter().any(|w| w.eq_ignore_ascii_case(name))
        {
            return;
        }
        let from = self.slots.len() - count;
        for (k, slot) in self.slots[from..].iter_mut().enumerate() {
            slot.part = Some((self.asked.len(), k == 0));
        }
        self.asked.push(name.to_owned());
    }

    /// Columns of a row.
    pub(crate) fn len(&self) -> usize {
        self.slots.len()
    }

    /// Whether a column has this role.
    pub(crate) fn contains(&self, role: Role) -> bool {
        self.slots.iter().any(|slot| slot.role == role)
    }

    /// What a column is.
    pub(crate) fn role(&self, column: usize) -> Role {
        self.slots[column].role
    }

    /// Particles without any yet, with a place for every column that is asked for.
    pub(crate) fn begin(&self) -> Particles {
        Particles { has: self.has.clone(), ..self.begin_part() }
    }

    /// The same for a part of them, which need not know what else the file has.
    pub(crate) fn begin_part(&self) -> Particles {
        let columns = self.asked.iter().map(|name| Column { name: name.clone(), values: Vec::new() }).collect();
        Particles { columns, ..Particles::default() }
    }

    /// Takes a particle from the words of a line; what follows the last column is left.
    pub(crate) fn row<'a, R: BufRead + 'a>(
        &self,
        words: &mut impl Iterator<Item = Word<'a, R>>,
        lines: &Lines<R>,
        particles: &mut Particles,
    ) -> Result<()> {
        particles.grow(1, 0)?;
        let mut making = Making::default();
        for (count, slot) in self.slots.iter().enumerate() {
            let Some(word) = words.next() else {
                let problem = format!("{count} fields where {} are announced", self.slots.len());
                let place = lines.place(lines.text().len()).named(&slot.name);
                return Err(Error::scene(place, problem, "give one field per column"));
            };
            slot.word(&word, &mut making, particles)?;
        }
        if let Some(color) = making.color {
            check_color(color, || lines.place(making.color_at).named("color"))?;
            particles.colors.push(color);
        }
        particles.positions.push(making.position);
        Ok(())
    }

    /// Takes a particle from a number for every column.
    ///
    /// # Errors
    /// [`Error::Scene`] for a colour that is none, without its place.
    pub(crate) fn numbers(&self, numbers: &[f64], particles: &mut Particles) -> Result<()> {
        particles.grow(1, 0)?;
        let mut making = Making::default();
        for (slot, number) in self.slots.iter().zip(numbers) {
            slot.put(*number, &mut making, particles);
        }
        if let Some(color) = making.color {
            check_color(color, || Place::field("color"))?;
            particles.colors.push(color);
        }
        particles.positions.push(making.position);
        Ok(())
    }
}

impl Slot {
    fn word<R: BufRead>(&self, word: &Word<'_, R>, making: &mut Making, particles: &mut Particles) -> Result<()> {
        let unread = self.asked.is_none() && self.part.is_none();
        let number = match self.role {
            Role::Text => return Ok(()),
            Role::Other if unread => return Ok(()),
            Role::Symbol => {
                let number = particles.species.code(word.text);
                if number == 0 {
                    particles.count_unknown(word.text, 1);
                }
                particles.elements.push(number);
                return Ok(());
            }
            Role::Radius | Role::Diameter => word.positive(&self.name)?,
            Role::Position(_) => word.finite(&self.name)?,
            Role::Color(k) => {
                if k == 0 {
                    making.color_at = word.at;
                }
                word.finite(&self.name)?
            }
            // What is missing in a table has no number.
            Role::Other | Role::Number if word.text.is_empty() => f64::NAN,
            Role::Other | Role::Number => word.number(&self.name)?,
        };
        self.put(number, making, particles);
        Ok(())
    }

    fn put(&self, number: f64, making: &mut Making, particles: &mut Particles) {
        match self.role {
            Role::Position(axis) => making.position[axis] = number,
            Role::Radius => particles.radii.push(number),
            Role::Diameter => particles.radii.push(number / 2.0),
            Role::Color(k) => making.color.get_or_insert_default()[k] = number as f32,
            Role::Number => {
                let whole = number as u8;
                particles.elements.push(if f64::from(whole) == number && element(whole).is_some() { whole } else { 0 });
            }
            Role::Symbol | Role::Text | Role::Other => {}
        }
        if let Some(column) = self.asked {
            particles.columns[column].values.push(number);
        }
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

/// How a column of a vector is called: `forces_x`, and by its number beyond the third.
pub(crate) fn component(name: &str, k: usize) -> String {
    match ["x", "y", "z"].get(k) {
        Some(axis) => format!("{name}_{axis}"),
        None => format!("{name}_{k}"),
    }
}

/// The columns of a style, no more of them than are ever of use.
///
/// # Errors
/// [`Error::Settings`] for more.
pub(crate) fn wanted(columns: &[String]) -> Result<Vec<String>> {
    const ASKED: usize = 64;
    if columns.len() > ASKED {
        let problem = format!("{} columns to colour by are more than {ASKED}", columns.len());
        return Err(Error::settings(problem, "name fewer"));
    }
    Ok(columns.to_vec())
}
