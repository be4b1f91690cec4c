//! Boxes around groups of spheres. Bounds over a box are computed by the operations that compute the number of one sphere,
//! at the corner that each operand's sign selects. Rounding is monotonic, so they bound the rounded numbers of all spheres
//! without a margin.

use glam::DVec3;

/// A box that contains the centres of spheres, and the least and the largest of their radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Enclosure {
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
    pub(crate) radii: [f64; 2],
}

impl Enclosure {
    /// The enclosure of no spheres.
    pub(crate) const NOTHING: Self =
        Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY, radii: [f64::INFINITY, f64::NEG_INFINITY] };

    /// The enclosure of one sphere.
    pub(crate) fn of(center: [f64; 3], radius: f64) -> Self {
        let center = DVec3::from_array(center);
        Self { low: center, high: center, radii: [radius; 2] }
    }

    /// The enclosure of both.
    pub(crate) fn with(self, other: &Self) -> Self {
        let ([a, b], [c, d]) = (self.radii, other.radii);
        Self { low: self.low.min(other.low), high: self.high.max(other.high), radii: [a.min(c), b.max(d)] }
    }

    /// Bounds of n.(c - p) as f64 computes it, over all centres c.
    #[inline]
    pub(crate) fn along(&self, normal: DVec3, from: DVec3) -> [f64; 2] {
        let (low, high) = (self.low - from, self.high - from);
        let up = normal.cmpge(DVec3::ZERO);
        [normal.dot(DVec3::select(up, low, high)), normal.dot(DVec3::select(up, high, low))]
    }

    /// The largest |c - p|, axis by axis, and the least.
    pub(crate) fn away(&self, from: DVec3) -> [DVec3; 2] {
        let (low, high) = (self.low - from, self.high - from);
        [high.max(-low), low.max(-high).max(DVec3::ZERO)]
    }

    /// Whether all numbers are finite.
    pub(crate) fn is_finite(&self) -> bool {
        let reach = self.low.is_finite() && self.high.is_finite();
        reach && (self.low - self.radii[1]).is_finite() && (self.high + self.radii[1]).is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_along_a_normal_are_those_of_the_corners() {
        let enclosure = Enclosure::of([1.0, -2.0, 0.5], 0.1).with(&Enclosure::of([-0.3, 4.0, 0.7], 0.2));
        let (normal, from) = (DVec3::new(-0.3, 0.7, 1e-3), DVec3::new(0.1, 0.2, 0.3));
        let corners = (0..8)
            .map(|n| DVec3::select(glam::BVec3::new(n & 1 > 0, n & 2 > 0, n & 4 > 0), enclosure.low, enclosure.high));
        let numbers: Vec<f64> = corners.map(|corner| normal.dot(corner - from)).collect();
        let [least, most] = enclosure.along(normal, from);
        assert_eq!(least, numbers.iter().copied().fold(f64::INFINITY, f64::min));
        assert_eq!(most, numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        assert_eq!(enclosure.radii, [0.1, 0.2]);
        assert!(enclosure.is_finite() && !Enclosure::NOTHING.is_finite());
    }
}
