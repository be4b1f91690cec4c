//! The pyramid of directions that a curved lens shows within a rectangle of its image, by which scenes are framed.
//!
//! The directions of the rectangle's edges, or of the last rays on the way to them, enclose the directions of its inside. A pyramid about the axis
//! that has none of them inside is shown within the rectangle as a whole.

use super::CurvedRays;
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_PI_3;

/// The widest angle between the axis and a side of the pyramid: what a fisheye shows beyond is seen from too near to tell its shape.
const WIDEST: f64 = FRAC_PI_3;

/// Points along an edge, an even number: they include the middle and the ends, where edges come nearest to the axis.
const POINTS: u32 = 128;

/// Halves of the way to a point without a ray: all bits of f64.
const HALVES: u32 = 53;

impl CurvedRays {
    /// The angles between the axis and the sides of the pyramid: left, right, bottom, top. `insets` are the shares of the image's size that are
    /// not used at these sides. `None` where the middle of the rectangle has no ray.
    pub(crate) fn pyramid(&self, [left, right, bottom, top]: [f64; 4]) -> Option<[f64; 4]> {
        let low = DVec2::new(left, top) * self.size;
        let high = DVec2::new(1.0 - right, 1.0 - bottom) * self.size;
        let middle = 0.5 * (low + high);
        let ahead = self.direction(middle.to_array())?;
        let (other, another) = (DVec2::new(low.x, high.y), DVec2::new(high.x, low.y));
        let angle = |from: DVec2, to: DVec2, outward: DVec3| {
            let of = |n: u32| {
                let point = from.lerp(to, f64::from(n) / f64::from(POINTS));
                let ray = self.last_ray(middle, ahead, point);
                // Directions behind the plane of the eye are in no pyramid.
                if ray.z > 0.0 { outward.dot(ray).atan2(ray.z) } else { WIDEST }
            };
            (0..=POINTS).map(of).fold(WIDEST, f64::min)
        };
        Some([
            angle(low, other, DVec3::NEG_X),
            angle(another, high, DVec3::X),
            angle(other, high, DVec3::Y),
            angle(low, another, DVec3::NEG_Y),
        ])
    }

    /// The direction of the last point with a ray on the way from `from`, which has the ray `ahead`, to `to`.
    fn last_ray(&self, from: DVec2, ahead: DVec3, to: DVec2) -> DVec3 {
        if let Some(ray) = self.direction(to.to_array()) {
            return ray;
        }
        let (mut low, mut high, mut last) = (0.0, 1.0, ahead);
        for _ in 0..HALVES {
            let share = 0.5 * (low + high);
            match self.direction(from.lerp(to, share).to_array()) {
                Some(ray) => (low, last) = (share, ray),
                None => high = share,
            }
        }
        last
    }
}
