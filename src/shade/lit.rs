//! What a surface reflects of lights and the sky, in linear RGB.

use crate::scene::Sky;
use glam::DVec3;

/// The light that a surface gets from the sky, of which this is open, or which is absent.
pub(crate) fn of_sky(open: Option<DVec3>, lights: bool) -> DVec3 {
    open.map_or(DVec3::ZERO, |open| if lights { open * f64::from(Sky::BESIDE_LIGHTS) } else { open })
}

/// The cap of a sphere that shines.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cap {
    from: DVec3,
    /// Toward the centre, and across.
    axes: [DVec3; 3],
    distance: f64,
    radius: f64,
    /// One minus the cosine of the angle at which it is seen.
    versine: f64,
}

impl Cap {
    /// As seen from a point; `None` from inside the sphere.
    pub(crate) fn new(from: DVec3, center: DVec3, radius: f64) -> Option<Self> {
        let away = center - from;
        let distance = away.length();
        if distance.is_nan() || distance <= radius {
            return None;
        }
        let axis = away / distance;
        let (across, up) = axis.any_orthonormal_pair();
        let sine = radius / distance;
        // 1 - cos = sin^2 / (1 + cos), which keeps small angles.
        let versine = sine * sine / (1.0 + (1.0 - sine * sine).sqrt());
        Some(Self { from, axes: [axis, across, up], distance, radius, versine })
    }

    /// The point of the surface at a point of the unit disc: equal areas of the disc have equal solid angles.
    pub(crate) fn point(&self, [x, y]: [f64; 2]) -> DVec3 {
        let area = x * x + y * y;
        let lowered = self.versine * area;
        let sine2 = lowered * (2.0 - lowered);
        // The direction's part across is its sine along (x, y).
        let scale = if area > 0.0 { (sine2 / area).sqrt() } else { 0.0 };
        let cosine = 1.0 - lowered;
        let direction = self.axes[0] * cosine + (self.axes[1] * x + self.axes[2] * y) * scale;
        // Where it enters the sphere.
        let half = (self.radius * self.radius - self.distance * self.distance * sine2).max(0.0).sqrt();
        self.from + direction * (self.distance * cosine - half)
    }
}
