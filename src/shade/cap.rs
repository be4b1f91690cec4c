//! The visible cap of a sphere: points of a light with a size, toward which rays are traced.

use crate::double_double as dd;
use glam::DVec3;

/// The cap of a sphere that a point outside of it sees, in the sphere's radius. docs/certificate.md, section 10.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cap {
    /// Unit vectors: from the point toward the centre, and two across.
    axes: [DVec3; 3],
    /// Sine and cosine of the angle at which the rim is seen from the axis.
    sine: f64,
    cosine: f64,
}

impl Cap {
    /// The cap as seen from a point from which the centre lies at `away`, in the unit of `radius`. The point must be
    /// outside of the sphere; for a point inside, the cap shrinks to the nearest point of the sphere.
    pub(crate) fn new(away: DVec3, radius: f64) -> Self {
        // A power of two brings the larger of both into [1, 2), so that their squares are within f64.
        let e = -dd::exponent(away.abs().max_element().max(radius));
        let (away, radius) = (DVec3::from_array(away.to_array().map(|x| dd::ldexp(x, e))), dd::ldexp(radius, e));
        let distance = away.length().max(radius);
        let axis = away.try_normalize().unwrap_or(DVec3::Z);
        let (across, up) = axis.any_orthonormal_pair();
        // (1 - r/d) (1 + r/d) keeps what is left of the cosine close to the sphere.
        let cosine = ((distance - radius) * (distance + radius)).sqrt() / distance;
        Self { axes: [axis, across, up], sine: radius / distance, cosine }
    }

    /// The direction from the centre to the point of the cap for a point of the unit disc: equal areas of the disc have equal
    /// solid angles as the point sees them. Its length is 1, within five roundings: the root of a sum of three squares, its
    /// reciprocal, and the product.
    pub(crate) fn outward(&self, [x, y]: [f64; 2]) -> DVec3 {
        let Self { axes: [axis, across, up], sine, cosine } = *self;
        let area = (x * x + y * y).min(1.0);
        // The angle theta from the axis has 1 - cos theta = (1 - cosine) area; 1 - cosine = sine^2 / (1 + cosine).
        let spread = 1.0 / (1.0 + cosine);
        let lowered = sine * sine * spread * area;
        // The ray meets the sphere at the angle alpha to its normal, and sin alpha = sin theta / sine.
        let sine_per_radius = ((2.0 - lowered) * spread).sqrt();
        let upright = (1.0 - sine_per_radius * sine_per_radius * area).max(0.0).sqrt();
        // Seen from the centre the point is alpha - theta from the axis.
        let across = (across * x + up * y) * (sine_per_radius * (1.0 - lowered - upright * sine));
        let along = upright * (1.0 - lowered) + sine_per_radius * sine_per_radius * area * sine;
        (across - axis * along).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dyadic::{self, Dyadic};
    use crate::testing::Rng;
    use std::cmp::Ordering;

    /// Points of the disc, from its middle to its rim.
    fn places() -> Vec<[f64; 2]> {
        let ring = |n: u32| {
            let (area, angle) = (f64::from(n) / 64.0, f64::from(n) * 2.4);
            [area.sqrt() * angle.cos(), area.sqrt() * angle.sin()]
        };
        (0..=64).map(ring).collect()
    }

    /// Whether two lengths whose exact squares are given differ by at most a share of one of them.
    fn close(square: &Dyadic, radius: f64, share: f64) -> bool {
        let r2 = Dyadic::of(radius).square();
        let (low, high) = (Dyadic::of(1.0 - 2.0 * share), Dyadic::of(1.0 + 2.0 * share));
        (square - &(&r2 * &low)).sign() != Ordering::Less && (&(&r2 * &high) - square).sign() != Ordering::Less
    }

    /// Six roundings of 2^-53, at every scale: the five of `outward` and the product with the radius.
    #[test]
    fn points_of_a_light_lie_on_it() {
        let mut random = Rng(77);
        let mut worst = 0.0f64;
        for k in [-1000, -541, -300, 0, 200, 511, 513, 1000] {
            for (distance, radius) in
                [(1.0, 0.5), (1.0, 1.0 - 1e-12), (1.0, 1e-300), (1.0, 1.0), (0.5, 1.0), (3.0, 1e-9)]
            {
                let toward = loop {
                    let v = DVec3::from_array(std::array::from_fn(|_| random.between(-1.0, 1.0)));
                    if v.length() > 0.1 {
                        break v.normalize();
                    }
                };
                let scale = |x: f64| dd::ldexp(x, k);
                let (away, r) = (toward * distance, scale(radius));
                if r == 0.0 {
                    continue;
                }
                let cap = Cap::new(DVec3::from_array(away.to_array().map(scale)), r);
                // A product that underflows is off by half a step of the subnormal numbers.
                for place in places() {
                    let offset = (cap.outward(place) * r).to_array();
                    let square = dyadic::dot(&dyadic::vector(offset), &dyadic::vector(offset));
                    let share = 6.0 * 2f64.powi(-53) + 2f64.powi(-1073) / r;
                    assert!(close(&square, r, share), "2^{k} {distance} {radius} {place:?}");
                    let length = (square.over(&Dyadic::of(r).square(), 128).to_dd() - 1.0.into()).value().abs();
                    worst = worst.max(if r > 1e-290 { length / 2.0 } else { 0.0 });
                }
            }
        }
        println!("points are off by {:.2} roundings of the radius at most", worst * 2f64.powi(53));
    }

    /// Directions toward the points of equal areas of the disc lie in equal steps of the cosine, on the near side.
    #[test]
    fn equal_areas_are_equal_solid_angles() {
        for radius in [1e-6, 0.3, 0.9, 0.999_999] {
            let away = DVec3::new(0.0, 0.6, -0.8);
            let cap = Cap::new(away, radius);
            let versine = 1.0 - (1.0 - radius * radius).sqrt();
            for [x, y] in places() {
                let outward = cap.outward([x, y]);
                let ray = away + outward * radius;
                // The cosine to the axis, from the sine where that is small.
                let sine = ray.normalize().cross(away).length();
                let lowered = sine * sine / (1.0 + (1.0 - sine * sine).sqrt());
                // Rounding of the sum, of the ray's length, against the sine.
                let error = 1e-15 / (1.0 - radius) + 1e-9 * versine;
                assert!((lowered - versine * (x * x + y * y)).abs() <= error, "{radius} {x} {y}: {lowered}");
                assert!(outward.dot(ray) <= 1e-7, "{radius} {x} {y}: on the far side");
            }
        }
    }
}
