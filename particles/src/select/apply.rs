//! Applies the selections of the options to a frame.

use super::evaluate::{Evaluator, Mask};
use super::note::{Note, Notes};
use super::selection::Selection;
use crate::particles::frame::{Particles, RuleTarget};
use crate::spheres::SphereRows;
use halfline_ground::check::keep;
use halfline_ground::error::Result;
use halfline_ground::memory::check;
use halfline_ground::parallel;

/// The selections that apply to the particles of a frame, by their use.
pub struct Selections<'a> {
    /// The particles to take: those that one of these selects; all where the list is empty.
    pub select: &'a [Selection],
    /// The particles to leave out: those that one of these selects.
    pub hide: &'a [Selection],
    /// The particles that are reported to the caller.
    pub marks: &'a [Selection],
    /// By [`RuleTarget`] the selections of the style's rules, one for each rule.
    pub rules: [Vec<&'a Selection>; RuleTarget::COUNT],
}

/// Marks the particles that a style's rules give a property, then removes those that are not selected. Returns the
/// messages about the selections.
///
/// # Errors
/// As `Evaluator::mask`, and [`Error::Limits`](halfline_ground::error::Error::Limits) where memory is short.
pub fn apply(selections: &Selections<'_>, particles: &mut Particles) -> Result<Vec<Note>> {
    let Selections { select, hide, marks, rules } = selections;
    let has_rules = !marks.is_empty() || rules.iter().any(|rules| !rules.is_empty());
    let count = particles.positions.len();
    // A frame without particles may have no columns either.
    if count == 0 || select.is_empty() && hide.is_empty() && !has_rules {
        return Ok(Vec::new());
    }
    check(8 * count as u64, || format!("the selections of {count} particles"))?;
    let mut notes = Vec::new();
    let marks = marks.iter().map(|selection| noted(selection, particles)).collect::<Result<Vec<_>>>()?;
    let mut of = |selection: &Selection| -> Result<Mask> {
        let (mask, messages) = noted(selection, particles)?;
        notes.extend(messages);
        Ok(mask)
    };
    // All rules see the whole frame, also what is hidden.
    let mut last = |selections: &[&Selection]| -> Result<Vec<u16>> {
        let mut rule = Vec::new();
        for (k, selection) in selections.iter().enumerate() {
            rule.resize(count, 0);
            let number = u16::try_from(k + 1).unwrap_or(u16::MAX);
            let mask = of(selection)?;
            parallel::zip(&mut rule, &mask, |rule, flag| *rule = if *flag { number } else { *rule });
        }
        Ok(rule)
    };
    let mut numbers: [Vec<u16>; RuleTarget::COUNT] = Default::default();
    for (numbers, rules) in numbers.iter_mut().zip(rules) {
        *numbers = last(rules)?;
    }
    let mut stays = vec![select.is_empty(); count];
    for selection in *select {
        let mask = of(selection)?;
        parallel::zip(&mut stays, &mask, |stays, flag| *stays |= flag);
    }
    for selection in *hide {
        let mask = of(selection)?;
        parallel::zip(&mut stays, &mask, |stays, flag| *stays &= !flag);
    }
    (particles.rules, particles.marks) = (numbers, marks);
    if !(select.is_empty() && hide.is_empty()) {
        particles.keep(&stays);
        if particles.positions.is_empty() {
            notes.push(Note::NoneLeft(count as u64));
        }
    }
    Ok(notes)
}

/// The spheres that each selection selects, as flags, and the messages about it; empty without spheres. Spheres have an
/// index, which is `before` for the first, coordinates and a radius.
///
/// # Errors
/// As `Evaluator::mask`.
pub fn marks_of(
    selections: &[Selection],
    before: u64,
    centers: &[[f64; 3]],
    radii: &[f64],
) -> Result<Vec<(Mask, Vec<Note>)>> {
    // Without spheres there are no columns either.
    if selections.is_empty() || centers.is_empty() {
        return Ok(Vec::new());
    }
    let (positions, radii) = (centers.to_vec(), radii.to_vec());
    let particles = Particles { positions, radii, before, ..Particles::default() };
    selections.iter().map(|selection| noted(selection, &particles)).collect()
}

/// The particles that a selection selects, as flags, and the messages about it.
///
/// # Errors
/// As `Evaluator::mask`.
pub fn mask(selection: &Selection, particles: &Particles) -> Result<(Mask, Vec<String>)> {
    noted(selection, particles).map(|(mask, notes)| (mask, notes.iter().map(Note::to_string).collect()))
}

fn noted(selection: &Selection, particles: &Particles) -> Result<(Mask, Vec<Note>)> {
    let mut evaluator = Evaluator::new(particles, selection);
    let mask = evaluator.mask()?;
    let mut notes = selection.remarks();
    notes.extend(evaluator.notes);
    Ok((mask, notes))
}

/// Selects spheres that arrive block by block. Spheres have an index, coordinates and a radius.
#[derive(Debug)]
pub struct SelectedSpheres {
    selection: Selection,
    /// The number of spheres so far, and of the selected ones.
    before: u64,
    left: u64,
    notes: Notes,
}

impl SelectedSpheres {
    pub fn new(selection: &Selection) -> Self {
        Self { selection: selection.clone(), before: 0, left: 0, notes: Notes::default() }
    }

    /// The selected spheres of the next block, without materials.
    ///
    /// # Errors
    /// As [`Evaluator::mask`].
    pub fn of(&mut self, block: SphereRows) -> Result<SphereRows> {
        let SphereRows { centers, radii, mut colors } = block;
        let mut particles = Particles { positions: centers, radii, before: self.before, ..Particles::default() };
        let (mask, notes) = noted(&self.selection, &particles)?;
        if !mask.is_empty() {
            self.notes.join(notes);
        }
        self.before += mask.len() as u64;
        particles.keep(&mask);
        self.left += particles.positions.len() as u64;
        keep(&mut colors, &mask);
        Ok(SphereRows { centers: particles.positions, radii: particles.radii, colors })
    }

    /// The messages about the selection, for use after the last block.
    pub fn messages(&self) -> Vec<String> {
        let none = self.before > 0 && self.left == 0;
        let none =
            none.then(|| format!("the selection `{}` leaves none of {} spheres", self.selection.brief(), self.before));
        self.notes.messages().chain(none).collect()
    }
}
