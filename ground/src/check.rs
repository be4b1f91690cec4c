//! Checks of the numbers of spheres, for every reader and for scenes in memory; lists reduced to some of their values.

use crate::error::{Error, Place, Result};

/// Whether a sphere may have this centre; the rule of [`check_sphere`], without a branch.
#[inline]
pub fn is_center(center: &[f64; 3]) -> bool {
    center[0].is_finite() & center[1].is_finite() & center[2].is_finite()
}

/// Whether a sphere may have this radius; the rule of [`check_sphere`], without a branch.
#[inline]
pub fn is_radius(radius: &f64) -> bool {
    (*radius > 0.0) & radius.is_finite()
}

/// Checks a sphere, for every reader: finite centre, positive finite radius.
///
/// # Errors
/// [`Error::Scene`] at `place`, with the name of the field appended.
pub fn check_sphere(center: [f64; 3], radius: f64, place: impl Fn() -> Place) -> Result<()> {
    let inside = |field: &str| {
        let place = place();
        let name = place.field.as_ref().map_or_else(|| field.to_owned(), |outer| format!("{outer} {field}"));
        place.named(name)
    };
    if let Some(bad) = center.iter().find(|x| !x.is_finite()) {
        return Err(Error::scene(
            inside("center"),
            format!("expected a finite number, found {bad}"),
            "give three finite numbers",
        ));
    }
    if !is_radius(&radius) {
        let problem = format!("the radius is {radius}");
        return Err(Error::scene(inside("radius"), problem, "give a positive finite number"));
    }
    Ok(())
}

/// Whether a number is a component of a colour in linear RGB: finite, 0 or more.
#[must_use]
pub fn is_component(component: f32) -> bool {
    component.is_finite() && component >= 0.0
}

/// Checks a colour, for every reader: three finite numbers, none negative.
///
/// # Errors
/// [`Error::Scene`] at `place`.
pub fn check_color(color: [f32; 3], place: impl FnOnce() -> Place) -> Result<()> {
    match color.iter().find(|c| !is_component(**c)) {
        None => Ok(()),
        Some(bad) => Err(Error::scene(place(), format!("the colour component is {bad}"), "give linear RGB, 0 or more")),
    }
}

/// Keeps the values whose flag is set; an empty list stays empty.
pub fn keep<T>(values: &mut Vec<T>, flags: &[bool]) {
    let mut flags = flags.iter();
    values.retain(|_| flags.next().copied().unwrap_or(true));
}
