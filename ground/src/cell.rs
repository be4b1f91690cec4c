//! The periodic cell of a simulation or a crystal.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// The most shifts along an edge that are tried; only cells with an angle of few degrees would need more.
const MAX_SHIFTS: f64 = 32.0;

/// A periodic cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// A corner.
    pub origin: [f64; 3],
    /// The three edges from that corner.
    pub edges: [[f64; 3]; 3],
}

impl Cell {
    /// The point at these fractions of the edges.
    pub fn place(&self, parts: [f64; 3]) -> [f64; 3] {
        let along = |k: usize| (0..3).map(|edge| parts[edge] * self.edges[edge][k]).sum::<f64>();
        [0, 1, 2].map(|k| self.origin[k] + along(k))
    }

    /// The shortest of all vectors that differ from this one by whole edges: between two particles that toward the nearest
    /// image. A cell without a volume has no images.
    #[must_use]
    pub fn nearest_image(&self, apart: DVec3) -> DVec3 {
        let edges = DMat3::from_cols_array_2d(&self.edges);
        let inverse = edges.inverse();
        if !inverse.is_finite() {
            return apart;
        }
        let near = apart - edges * (inverse * apart).round();
        // A vector of at most this length has parts of at most length / height along an edge, and the parts of `near` are at
        // most a half.
        let most = |k: usize| (near.length() * inverse.row(k).length() + 0.5).floor().min(MAX_SHIFTS) as i32;
        let [a, b, c] = [0, 1, 2].map(|k| -most(k)..=most(k));
        let shifts =
            a.flat_map(|i| b.clone().map(move |j| (i, j))).flat_map(|(i, j)| c.clone().map(move |k| [i, j, k]));
        let images = shifts.map(|shift| near + edges * DVec3::from_array(shift.map(f64::from)));
        images.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The truth tries all shifts of a wide range.
    #[test]
    fn no_image_is_nearer_than_the_nearest() {
        let skewed = [[4.0, 0.0, 0.0], [3.9, 1.0, 0.0], [-2.5, 0.7, 2.0]];
        for edges in [[[4.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 6.0]], skewed] {
            let cell = Cell { origin: [0.0; 3], edges };
            for n in 0..200_i32 {
                let part = |k: i32| f64::from((n * k) % 101) * 0.37 - 15.0;
                let apart = DVec3::new(part(7), part(13), part(29));
                let range = || -30_i32..=30;
                let all = range().flat_map(|i| range().flat_map(move |j| range().map(move |k| [i, j, k])));
                let [a, b, c] = edges.map(DVec3::from_array);
                let least =
                    all.map(|[i, j, k]| (apart + f64::from(i) * a + f64::from(j) * b + f64::from(k) * c).length());
                let (least, found) = (least.fold(f64::INFINITY, f64::min), cell.nearest_image(apart).length());
                assert!((found - least).abs() <= 1e-12 * (1.0 + least), "{apart}: {found}, not {least}");
            }
        }
        let flat = Cell { origin: [0.0; 3], edges: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]] };
        assert_eq!(flat.nearest_image(DVec3::splat(3.0)), DVec3::splat(3.0));
    }
}
