//! Applies the selections of the options to a frame.

use super::evaluate::{Evaluator, Mask};
use super::selection::Selection;
use crate::read::particles::frame::Particles;
use halfline::error::Result;
use halfline::memory::check;
use halfline::scene::Spheres;
use rayon::prelude::*;

/// What is selected of the particles of a frame.
pub(in crate::read) struct Selections<'a> {
    /// The particles to take: those that one of these selects; all where the list is empty.
    pub(in crate::read) select: &'a [Selection],
    /// The particles to leave out: those that one of these selects.
    pub(in crate::read) hide: &'a [Selection],
    /// Particles that the caller wants to know.
    pub(in crate::read) marks: &'a [Selection],
    /// Those that the rules of a style colour and resize, a selection for each rule.
    pub(in crate::read) paints: Vec<&'a Selection>,
    pub(in crate::read) sizes: Vec<&'a Selection>,
}

/// Marks the particles that a style's rules colour or resize, then removes those that are not selected.
///
/// # Errors
/// Those of the selections.
pub(in crate::read) fn apply(selections: &Selections<'_>, particles: &mut Particles) -> Result<()> {
    let Selections { select, hide, marks, paints, sizes } = selections;
    let rules = paints.len() + sizes.len() + marks.len();
    let count = particles.positions.len();
    // A frame without particles may have no columns either.
    if count == 0 || select.is_empty() && hide.is_empty() && rules == 0 {
        return Ok(());
    }
    check(8 * count as u64, || format!("the selections of {count} particles"))?;
    let (mut notes, mut all) = (Vec::new(), Vec::new());
    let marks = marks.iter().map(|selection| mask(selection, particles)).collect::<Result<Vec<_>>>()?;
    let mut of = |selection: &Selection| -> Result<Mask> {
        let (mask, said) = mask(selection, particles)?;
        notes.extend(said);
        Ok(mask)
    };
    // All rules see the whole frame, also what is hidden.
    let mut last = |selections: &[&Selection]| -> Result<Vec<u16>> {
        let mut rule = Vec::new();
        for (k, selection) in selections.iter().enumerate() {
            rule.resize(count, 0);
            let number = u16::try_from(k + 1).unwrap_or(u16::MAX);
            let mask = of(selection)?;
            rule.par_iter_mut().zip(&mask).filter(|(_, flag)| **flag).for_each(|(rule, _)| *rule = number);
            all.push(mask.par_iter().any(|flag| *flag));
        }
        Ok(rule)
    };
    let paint = last(paints)?;
    let size = last(sizes)?;
    let mut stays = vec![select.is_empty(); count];
    for selection in *select {
        let mask = of(selection)?;
        stays.par_iter_mut().zip(mask).for_each(|(stays, flag)| *stays |= flag);
    }
    for selection in *hide {
        let mask = of(selection)?;
        stays.par_iter_mut().zip(mask).for_each(|(stays, flag)| *stays &= !flag);
    }
    (particles.paint, particles.size, particles.marks) = (paint, size, marks);
    if !(select.is_empty() && hide.is_empty()) {
        particles.keep(&stays);
        if particles.positions.is_empty() && count > 0 {
            notes.push(format!("the selections leave none of the {count} particles"));
        }
    }
    particles.skipped.assumed.extend(notes);
    Ok(())
}

/// The spheres that selections select, and what their evaluation said. Spheres have an index, coordinates and a radius.
///
/// # Errors
/// Those of the selections.
pub(in crate::read) fn marks_of(selections: &[Selection], spheres: &Spheres) -> Result<Vec<(Mask, Vec<String>)>> {
    if selections.is_empty() {
        return Ok(Vec::new());
    }
    let (positions, radii) = (spheres.centers.to_vec(), spheres.radii.to_vec());
    let particles = Particles { positions, radii, ..Particles::default() };
    selections.iter().map(|selection| mask(selection, &particles)).collect()
}

/// The particles that a selection selects, and messages about it.
///
/// # Errors
/// Those of the selection.
pub(in crate::read) fn mask(selection: &Selection, particles: &Particles) -> Result<(Vec<bool>, Vec<String>)> {
    let mut evaluator = Evaluator::new(particles, selection);
    let mask = evaluator.mask()?;
    let mut notes = selection.remarks();
    notes.extend(evaluator.notes);
    Ok((mask, notes))
}

/// Appends the selected ones of `part` to `spheres`; returns messages about the selection. Spheres have an index,
/// coordinates and a radius.
///
/// # Errors
/// Those of the selection, [`Error::Limits`](halfline::error::Error::Limits).
pub(in crate::read) fn add_selected(
    selection: &Selection,
    part: Spheres,
    spheres: &mut Spheres,
) -> Result<Vec<String>> {
    let Spheres { centers, radii, colors, .. } = part;
    let particles = Particles { positions: centers.into_vec(), radii: radii.into_vec(), ..Particles::default() };
    let (mask, mut notes) = mask(selection, &particles)?;
    for (n, _) in mask.iter().enumerate().filter(|(_, flag)| **flag) {
        spheres.add(particles.positions[n], particles.radii[n], colors.as_ref().map(|colors| colors[n]))?;
    }
    if !mask.is_empty() && !mask.contains(&true) {
        notes.push(format!("the selection `{}` leaves none of {} spheres", selection.brief(), mask.len()));
    }
    Ok(notes)
}
