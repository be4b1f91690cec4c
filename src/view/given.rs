//! Rays given by the caller instead of viewing rays.

use halfline_ground::error::{Error, Result};
use halfline_ground::parallel;

/// Rays given by the caller: origin + t direction, 0 < t < limit. All numbers are taken as exact.
#[derive(Debug, Clone, Copy, Default)]
pub struct Rays<'a> {
    /// One point per direction, or a single one for all.
    pub origins: &'a [[f64; 3]],
    /// One direction per ray, of any length but zero.
    pub directions: &'a [[f64; 3]],
    /// One limit per direction, in units of the direction, or none at all. A hit at t counts only if t < limit; +inf
    /// is no limit, and with a limit of 0 or less nothing is hit.
    pub limits: &'a [f64],
}

/// One ray of [`Rays`].
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GivenRay {
    pub(crate) origin: [f64; 3],
    pub(crate) direction: [f64; 3],
    pub(crate) limit: f64,
}

impl Rays<'_> {
    /// The number of rays.
    #[must_use]
    pub fn len(&self) -> usize {
        self.directions.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.directions.is_empty()
    }

    /// The point of ray `n` at parameter `t`: origin + t direction.
    #[must_use]
    #[inline]
    pub fn at(&self, n: usize, t: f64) -> [f64; 3] {
        let ray = self.ray(n);
        [0, 1, 2].map(|axis| ray.origin[axis] + t * ray.direction[axis])
    }

    #[inline(always)]
    pub(crate) fn ray(&self, n: usize) -> GivenRay {
        GivenRay {
            origin: if self.origins.len() == 1 { self.origins[0] } else { self.origins[n] },
            direction: self.directions[n],
            limit: if self.limits.is_empty() { f64::INFINITY } else { self.limits[n] },
        }
    }

    /// # Errors
    /// [`Error::Settings`] for numbers that are not finite, directions that are zero, and lists of different lengths;
    /// [`Error::Limits`] for more rays than 32-bit indices can number.
    pub(crate) fn check(&self) -> Result<()> {
        let count = self.len();
        if self.origins.len() != 1 && self.origins.len() != count {
            let problem = format!("found {} origins for {count} directions", self.origins.len());
            return Err(Error::settings(problem, "use one origin, or one for each direction"));
        }
        if !self.limits.is_empty() && self.limits.len() != count {
            let problem = format!("found {} limits for {count} directions", self.limits.len());
            return Err(Error::settings(problem, "use one limit for each direction, or none"));
        }
        if u32::try_from(count).is_err() {
            let problem = format!("{count} rays are more than 32-bit indices can number");
            return Err(Error::Limits { problem, mend: format!("trace at most {} rays per call", u32::MAX) });
        }
        if let Some(n) = parallel::position(self.origins, |o| o.iter().any(|x| !x.is_finite())) {
            return Err(Error::settings(format!("origin {n} is not finite"), "use three finite numbers"));
        }
        let no_direction = |d: &[f64; 3]| d.iter().any(|x| !x.is_finite()) || d.iter().all(|x| *x == 0.0);
        if let Some(n) = parallel::position(self.directions, no_direction) {
            let problem = format!("direction {n} is zero or not finite");
            return Err(Error::settings(problem, "use a finite direction that is not zero"));
        }
        if let Some(n) = parallel::position(self.limits, |limit| limit.is_nan()) {
            return Err(Error::settings(format!("limit {n} is not a number"), "use a number, or inf for no limit"));
        }
        Ok(())
    }
}
