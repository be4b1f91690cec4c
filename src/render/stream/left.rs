//! The spheres of a stream as planes leave them: a block, and copies in groups, most of them wholly on one side.

use crate::scene::instances::enclosure::Enclosure;
use crate::scene::instances::{Group, Instances, NumberedSpheres};
use crate::scene::{CUT, CutPlane, REMOVED, Spheres};
use glam::DVec3;
use halfline_ground::error::Result;
use halfline_ground::progress::Watch;
use std::borrow::Cow;

/// The spheres that planes leave of a block.
pub(super) struct Left {
    pub(super) spheres: Spheres,
    /// The places of these in the block.
    pub(super) places: Vec<usize>,
    /// The spheres that planes cut, and those that they remove.
    pub(super) changed: [u64; 2],
}

/// The spheres that planes leave of a block; `None` for all of it, whole.
///
/// # Errors
/// As [`Spheres::cut`].
pub(super) fn left(block: &Spheres, planes: &[CutPlane]) -> Result<Option<Left>> {
    if planes.is_empty() {
        return Ok(None);
    }
    let mut spheres = block.clone();
    spheres.cut(planes, None)?;
    let Some(cuts) = &spheres.cuts else { return Ok(None) };
    let changed = [CUT, REMOVED].map(|flag| cuts.count(flag));
    let stays: Vec<bool> = cuts.of.iter().map(|flag| *flag != REMOVED).collect();
    let places = (0..block.len()).filter(|n| stays[*n]).collect();
    spheres.keep(&stays);
    Ok(Some(Left { spheres, places, changed }))
}

/// Bound of the rounding of N.c and of r |N| in f64, relative to the sum of the sizes of their terms.
/// Section 9a of docs/certificate.md.
const ROUNDED: f64 = 16.0 * f64::EPSILON;

/// Whether planes certainly leave all spheres of a box whole (`Some(true)`), or none of them.
fn keep(planes: &[CutPlane], around: &Enclosure) -> Option<bool> {
    let mut all = true;
    for CutPlane { normal, distance } in planes.iter().map(CutPlane::in_range) {
        let normal = DVec3::from_array(normal);
        let [least, most] = around.along(normal, DVec3::ZERO);
        let reach = around.radii[1] * normal.length();
        let sizes = normal.abs().dot(around.low.abs().max(around.high.abs())) + distance.abs() + reach;
        let doubt = ROUNDED * sizes + f64::MIN_POSITIVE;
        // A sum beyond f64 decides nothing.
        if least - reach - distance > doubt {
            return Some(false);
        }
        all &= most + reach - distance < -doubt;
    }
    all.then_some(true)
}

/// Copies as planes leave them.
pub(super) struct LeftCopies<'a> {
    pub(super) instances: &'a Instances,
    pub(super) planes: Vec<CutPlane>,
}

impl LeftCopies<'_> {
    /// Whether planes remove all spheres of a box.
    pub(super) fn removes(&self, around: &Enclosure) -> bool {
        keep(&self.planes, around) == Some(false)
    }

    /// The part of some spheres that planes leave.
    ///
    /// # Errors
    /// As [`Spheres::cut`].
    pub(super) fn of<'b>(&self, some: &'b NumberedSpheres) -> Result<Cow<'b, NumberedSpheres>> {
        Ok(match left(&some.spheres, &self.planes)? {
            None => Cow::Borrowed(some),
            Some(Left { spheres, places, .. }) => {
                Cow::Owned(NumberedSpheres { numbers: places.iter().map(|n| some.numbers[*n]).collect(), spheres })
            }
        })
    }

    /// As [`Instances::search`] among what planes leave.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted), and as [`Spheres::cut`].
    pub(super) fn search(
        &self,
        watch: &Watch,
        bound: impl Fn(&Enclosure) -> f64,
        mut score: impl FnMut(&NumberedSpheres) -> f64,
    ) -> Result<()> {
        let mut failed = Ok(());
        let bound = |around: &Enclosure| if self.removes(around) { f64::NEG_INFINITY } else { bound(around) };
        self.instances.search(watch, bound, |some| match self.of(some) {
            Ok(some) => score(&some),
            Err(error) => {
                failed = Err(error);
                f64::INFINITY
            }
        })?;
        failed
    }

    /// Visits the groups that are not divided, but those that `skips` names.
    fn each(
        &self,
        watch: &Watch,
        mut skips: impl FnMut(&Group, &Enclosure) -> bool,
        mut visit: impl FnMut(&NumberedSpheres) -> Result<bool>,
    ) -> Result<()> {
        let (mut open, mut parts, mut found) = (self.instances.whole(), Vec::new(), NumberedSpheres::default());
        open.reverse();
        while let Some(group) = open.pop() {
            let around = self.instances.enclosure(&group);
            if self.instances.clips(&around) == Some(false) || skips(&group, &around) {
                continue;
            }
            parts.clear();
            if self.instances.divide(&group, &mut parts) {
                open.extend(parts.iter().rev());
                continue;
            }
            watch.check()?;
            found.clear();
            self.instances.spheres_of(&group, &mut found);
            if !visit(&found)? {
                break;
            }
        }
        Ok(())
    }

    /// Some spheres that planes leave: this many, if there are.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted), and as [`Spheres::cut`].
    pub(super) fn first(&self, count: usize, watch: &Watch) -> Result<NumberedSpheres> {
        if self.planes.is_empty() {
            return Ok(self.instances.first(count));
        }
        let mut all = NumberedSpheres::default();
        let skips = |_: &Group, around: &Enclosure| self.removes(around);
        self.each(watch, skips, |some| {
            let some = self.of(some)?;
            let indices: Vec<u32> = (0..some.numbers.len().min(count) as u32).collect();
            all.add(&some.spheres, &|n| some.numbers[n], &indices)?;
            Ok(all.numbers.len() < count)
        })?;
        Ok(all)
    }

    /// The number of spheres that planes cut, and that they remove.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted), and as [`Spheres::cut`].
    pub(super) fn changed(&self, watch: &Watch) -> Result<[u64; 2]> {
        let (mut changed, mut removed) = ([0; 2], 0);
        if self.planes.is_empty() {
            return Ok(changed);
        }
        let skips = |group: &Group, around: &Enclosure| match keep(&self.planes, around) {
            Some(false) if self.instances.clips(around) == Some(true) => {
                removed += self.instances.count(group);
                true
            }
            Some(true) => true,
            _ => false,
        };
        self.each(watch, skips, |some| {
            let own = left(&some.spheres, &self.planes)?.map_or([0; 2], |left| left.changed);
            changed = [changed[0] + own[0], changed[1] + own[1]];
            Ok(true)
        })?;
        Ok([changed[0], changed[1] + removed])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_of_every_length_leave_the_same() {
        for k in [-1020, -560, -1, 0, 500, 1000] {
            let scale = 2f64.powi(k / 2) * 2f64.powi(k - k / 2);
            let planes = [CutPlane { normal: [0.6 * scale, 0.0, 0.8 * scale], distance: 0.5 * scale }];
            let box_at = |along: f64| {
                let center = DVec3::new(0.6, 0.0, 0.8) * along;
                Enclosure { low: center - 0.1, high: center + 0.1, radii: [0.5, 1.0] }
            };
            let kept = [-4.0, 1.4, 5.0].map(|along| keep(&planes, &box_at(along)));
            assert_eq!(kept, [Some(true), None, Some(false)], "2^{k}");
        }
    }
}
