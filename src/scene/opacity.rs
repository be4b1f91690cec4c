//! Opacities of spheres: the share of what lies behind that a sphere hides in a picture.

use super::Spheres;
use halfline_ground::error::{Error, Place, Result};

/// Whether a number is an opacity: above 0, at most 1. A sphere of opacity 0 would be no sphere.
#[must_use]
pub fn is_opacity(opacity: f32) -> bool {
    opacity > 0.0 && opacity <= 1.0
}

/// Checks an opacity.
///
/// # Errors
/// [`Error::Scene`] at `place`.
pub fn check_opacity(opacity: f32, place: impl FnOnce() -> Place) -> Result<()> {
    if is_opacity(opacity) {
        return Ok(());
    }
    Err(Error::scene(place(), format!("found {opacity}"), "give a number above 0 and at most 1; 1 is opaque"))
}

impl Spheres {
    /// The opacity of a sphere; 1 for one that the scene does not have.
    #[must_use]
    pub fn opacity(&self, id: u32) -> f32 {
        self.opacities.as_ref().and_then(|all| all.get(id as usize)).copied().unwrap_or(1.0)
    }

    /// Whether a picture shows something through a sphere.
    #[must_use]
    pub fn is_translucent(&self) -> bool {
        self.opacities.as_ref().is_some_and(|all| all.iter().any(|opacity| *opacity < 1.0))
    }

    /// Changes the opacity of the spheres from this index on.
    pub fn set_opacity_from(&mut self, first: usize, opacity: f32) {
        let count = self.len();
        if first >= count || self.opacities.is_none() && opacity == 1.0 {
            return;
        }
        let all = self.opacities.get_or_insert_with(|| vec![1.0; count].into()).to_mut();
        all.truncate(first);
        all.resize(count, opacity);
    }

    /// Checks that every sphere has an opacity, if any has.
    ///
    /// # Errors
    /// [`Error::Scene`] for the first number that is none.
    pub(super) fn check_opacities(&self) -> Result<()> {
        let Some(all) = &self.opacities else { return Ok(()) };
        if all.len() != self.len() {
            let problem = format!("found {} opacities of {} spheres", all.len(), self.len());
            return Err(Error::scene("spheres", problem, "give every sphere an opacity"));
        }
        if all.is_sound(|opacity| is_opacity(*opacity)) {
            return Ok(());
        }
        let mut each = all.iter().enumerate();
        each.try_for_each(|(n, opacity)| check_opacity(*opacity, || Place::field(format!("sphere {n} opacity"))))
    }
}
