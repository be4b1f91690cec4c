//! Extremes over all spheres of copies, by branch and bound.

use super::{Group, Instances, NumberedSpheres};
use crate::scene::Spheres;
use crate::scene::instances::enclosure::Enclosure;
use crate::scene::source::SphereSource;
use glam::DVec3;
use halfline_ground::error::Result;
use halfline_ground::progress::Watch;

/// Copies whose passes can be cancelled.
pub struct CopiedSpheres<'a> {
    /// The copies.
    pub instances: &'a Instances,
    /// The end of a pass that is cancelled.
    pub watch: &'a Watch,
}

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
    fn least_along(&self, watch: &Watch, normal: DVec3, from: DVec3) -> Result<f64> {
        let mut least = f64::INFINITY;
        let bound = |around: &Enclosure| -(around.along(normal, from)[0] - around.radii[1]);
        self.search(watch, bound, |found| {
            let each = found.spheres.centers.iter().zip(&found.spheres.radii);
            least = each.map(|(c, r)| normal.dot(DVec3::from_array(*c) - from) - r).fold(least, f64::min);
            -least
        })?;
        Ok(least)
    }
}

impl SphereSource for CopiedSpheres<'_> {
    fn each(&self, visit: &mut dyn FnMut(&Spheres) -> Result<()>) -> Result<()> {
        self.instances.blocks().try_for_each(|block| {
            self.watch.check()?;
            visit(&block)
        })
    }

    fn ends(&self) -> Result<[DVec3; 2]> {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
        let [a, b, c, d, e, f] = self.sides(axes, DVec3::ZERO)?;
        // Not a negation, which has -0 where a sphere ends at 0.
        Ok([DVec3::new(a, b, c), DVec3::ZERO - DVec3::new(d, e, f)])
    }

    fn sides(&self, normals: [DVec3; 6], from: DVec3) -> Result<[f64; 6]> {
        let mut sides = [f64::INFINITY; 6];
        for (side, normal) in sides.iter_mut().zip(normals).filter(|(_, normal)| *normal != DVec3::ZERO) {
            *side = self.instances.least_along(self.watch, normal, from)?;
        }
        Ok(sides)
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
