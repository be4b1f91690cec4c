//! Extremes over all spheres of copies, by branch and bound.

use super::{Group, Instances, NumberedSpheres};
use crate::error::Result;
use crate::progress::Watch;
use crate::scene::instances::enclosure::Enclosure;
use glam::DVec3;

impl Instances {
    /// Finds the spheres with the greatest score. `bound` is no less than the score of any sphere in a box, and
    /// -infinity where it does not matter; `score` sees spheres and returns the greatest score so far. Groups whose bound
    /// is not above that are passed.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub(crate) fn search(
        &self,
        watch: &Watch,
        bound: impl Fn(&Enclosure) -> f64,
        mut score: impl FnMut(&NumberedSpheres) -> f64,
    ) -> Result<()> {
        let of = |group: Group| {
            let around = self.enclosure(&group);
            let bound = if self.clips(&around) == Some(false) { f64::NEG_INFINITY } else { bound(&around) };
            (bound, group)
        };
        let mut open: Vec<(f64, Group)> = self.whole().into_iter().map(of).collect();
        open.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut best, mut parts, mut found) = (f64::NEG_INFINITY, Vec::new(), NumberedSpheres::default());
        while let Some((bound, group)) = open.pop() {
            if bound <= best {
                continue;
            }
            parts.clear();
            if self.divide(&group, &mut parts) {
                let first = open.len();
                open.extend(parts.iter().map(|group| of(*group)));
                open[first..].sort_by(|a, b| a.0.total_cmp(&b.0));
                continue;
            }
            watch.check()?;
            found.clear();
            self.spheres_of(&group, &mut found);
            best = best.max(score(&found));
        }
        Ok(())
    }

    /// The least n.(c - p) - r of all spheres; infinite without any.
    ///
    /// # Errors
    /// As [`Instances::search`].
    pub(crate) fn least_along(&self, watch: &Watch, normal: DVec3, from: DVec3) -> Result<f64> {
        let mut least = f64::INFINITY;
        let bound = |around: &Enclosure| -(around.along(normal, from)[0] - around.radii[1]);
        self.search(watch, bound, |found| {
            let each = found.spheres.centers.iter().zip(&found.spheres.radii);
            least = each.map(|(c, r)| normal.dot(DVec3::from_array(*c) - from) - r).fold(least, f64::min);
            -least
        })?;
        Ok(least)
    }

    /// The corners of the box around all spheres; not finite for none. The same numbers as
    /// [`Spheres::bounds`](crate::Spheres::bounds) of all of them.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn bounds(&self, watch: &Watch) -> Result<[DVec3; 2]> {
        let least = |normal: DVec3| self.least_along(watch, normal, DVec3::ZERO);
        let low = DVec3::new(least(DVec3::X)?, least(DVec3::Y)?, least(DVec3::Z)?);
        // Not a negation, which has -0 where a sphere ends at 0.
        let high = DVec3::ZERO - DVec3::new(least(DVec3::NEG_X)?, least(DVec3::NEG_Y)?, least(DVec3::NEG_Z)?);
        Ok([low, high])
    }
}

impl NumberedSpheres {
    /// Removes all spheres, and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.numbers.clear();
        self.spheres.centers.to_mut().clear();
        self.spheres.radii.to_mut().clear();
        if let Some(colors) = &mut self.spheres.colors {
            colors.to_mut().clear();
        }
    }
}
