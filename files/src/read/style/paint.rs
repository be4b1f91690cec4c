//! Colours of selected particles, and their rows in a legend.

use super::categories;
use halfline::error::{Error, Result};
use halfline::frame::legend::Category;
use halfline::frame::srgb;
use halfline::quote::setting::COLOR;
use halfline_particles::Selection;
use halfline_particles::color::of_hex;
use halfline_particles::elements::element;

/// The colour of selected particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Paint {
    /// One linear RGB.
    One([f32; 3]),
    /// Each has the colour of its element.
    Element,
}

/// The rows of [`Paint::Element`]: atomic numbers; 0 is an unknown element.
const ELEMENTS: usize = 119;

impl Paint {
    /// Linear RGB of a particle of this element.
    pub(in crate::read) fn color(self, element: u8) -> [f32; 3] {
        match self {
            Self::One(color) => color,
            Self::Element => of_hex(categories::of_element(element)),
        }
    }

    /// The number of its rows in a legend.
    fn rows(self) -> usize {
        if self == Self::Element { ELEMENTS } else { 1 }
    }
}

/// Returns an error for the colours of elements where there are none.
///
/// # Errors
/// [`Error::Settings`].
pub(in crate::read) fn check(paints: &[(Selection, Paint)], elements: &[u8]) -> Result<()> {
    match paints.iter().find(|(_, paint)| *paint == Paint::Element && elements.is_empty()) {
        None => Ok(()),
        Some((selection, _)) => {
            let problem =
                format!("{COLOR}: `{}` has the colours of elements, and the file has none", selection.brief());
            Err(Error::settings(problem, "give a colour, or use a file with elements"))
        }
    }
}

/// The labels and colours of the rows of rules in a legend: one of each colour, and the rows of all elements.
pub(in crate::read) fn rows(paints: &[(Selection, Paint)]) -> impl Iterator<Item = (String, [f32; 3])> {
    paints.iter().flat_map(|(selection, paint)| {
        (0..paint.rows()).map(|row| {
            let number = row as u8;
            let label = match paint {
                Paint::One(_) => selection.label().to_owned(),
                // A chain may be called N.
                Paint::Element => format!("element {}", element(number).map_or("unknown", |element| element.symbol)),
            };
            (label, paint.color(number))
        })
    })
}

/// The number of particles in each of these rows. The particles are those that a rule applies to, each as the rule and an atomic number.
pub(in crate::read) fn counts(paints: &[(Selection, Paint)], particles: impl Iterator<Item = (usize, u8)>) -> Vec<u64> {
    let mut first = Vec::with_capacity(paints.len());
    let mut rows = 0;
    for (_, paint) in paints {
        first.push(rows);
        rows += paint.rows();
    }
    let mut counts = vec![0; rows];
    for (rule, element) in particles {
        let row = usize::from(element).min(paints[rule].1.rows() - 1);
        counts[first[rule] + row] += 1;
    }
    counts
}

/// The rows that some particle has.
pub(in crate::read) fn categories(rows: impl Iterator<Item = (String, [f32; 3])>, counts: &[u64]) -> Vec<Category> {
    let used = rows.zip(counts).filter(|(_, count)| **count > 0);
    used.map(|((label, color), count)| Category { label, color: color.map(srgb::level), count: *count }).collect()
}
