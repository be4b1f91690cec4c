//! Spheres block by block: those in memory are one block, copies and files are many.

use super::Spheres;
use glam::DVec3;
use halfline_ground::error::Result;

/// Spheres that are passed over as often as needed, each time in the same order.
pub trait SphereSource {
    /// Visits all of them.
    ///
    /// # Errors
    /// Errors of the visit, and of reading the spheres.
    fn each(&self, visit: &mut dyn FnMut(&Spheres) -> Result<()>) -> Result<()>;

    /// The corners of the box around all of them; not finite for none.
    ///
    /// # Errors
    /// As [`SphereSource::each`].
    fn ends(&self) -> Result<[DVec3; 2]> {
        ends_and_count(|visit| self.each(visit)).map(|(ends, _)| ends)
    }

    /// The least n.(c - p) - r of all of them along each of these normals; infinite along zero, and without spheres.
    ///
    /// # Errors
    /// As [`SphereSource::each`].
    fn sides(&self, normals: [DVec3; 6], from: DVec3) -> Result<[f64; 6]> {
        let mut sides = [f64::INFINITY; 6];
        self.each(&mut |block| {
            for (side, normal) in sides.iter_mut().zip(normals).filter(|(_, normal)| *normal != DVec3::ZERO) {
                *side = side.min(block.least_along(normal, from));
            }
            Ok(())
        })?;
        Ok(sides)
    }

    /// The mean of their centres; `None` without any.
    ///
    /// # Errors
    /// As [`SphereSource::each`].
    fn mean(&self) -> Result<Option<DVec3>> {
        let (ends, count) = ends_and_count(|visit| self.each(visit))?;
        if count == 0 {
            return Ok(None);
        }
        let (middle, mut sum) = (middle(ends), DVec3::ZERO);
        self.each(&mut |block| {
            block.centers.iter().for_each(|center| sum += (DVec3::from_array(*center) - middle) / count as f64);
            Ok(())
        })?;
        Ok(Some(middle + sum))
    }
}

impl SphereSource for Spheres {
    fn each(&self, visit: &mut dyn FnMut(&Spheres) -> Result<()>) -> Result<()> {
        visit(self)
    }
}

/// The corners of the box around all spheres of a pass, and their number.
fn ends_and_count(
    pass: impl FnOnce(&mut dyn FnMut(&Spheres) -> Result<()>) -> Result<()>,
) -> Result<([DVec3; 2], u64)> {
    let (mut ends, mut count) = ([DVec3::INFINITY, DVec3::NEG_INFINITY], 0);
    pass(&mut |block| {
        let [low, high] = block.bounds();
        (ends, count) = ([ends[0].min(low), ends[1].max(high)], count + block.len() as u64);
        Ok(())
    })?;
    Ok((ends, count))
}

/// The middle of a box with these corners; the origin if they are not finite, as those around no spheres.
#[must_use]
pub fn middle([low, high]: [DVec3; 2]) -> DVec3 {
    let middle = low + (high - low) / 2.0;
    if middle.is_finite() { middle } else { DVec3::ZERO }
}
