//! The edges of a periodic cell: positions as fractions of them, and moves by whole edges.

use glam::{DMat3, DVec3};
use halfline_ground::Cell;

/// The edges of a cell and their inverse.
pub(super) struct Edges {
    pub(super) origin: DVec3,
    pub(super) edges: DMat3,
    inverse: DMat3,
}

impl Edges {
    /// `None` where the edges span no volume.
    pub(super) fn of(cell: &Cell) -> Option<Self> {
        let edges = DMat3::from_cols_array_2d(&cell.edges);
        let inverse = edges.inverse();
        let volume = edges.determinant();
        let usable = volume != 0.0 && volume.is_finite() && inverse.is_finite();
        usable.then(|| Self { origin: DVec3::from_array(cell.origin), edges, inverse })
    }

    /// A vector as fractions of the edges. Where the first edge is along x and the second in the xy plane, as programs
    /// write cells, one division gives each, so that a whole edge is exactly 1.
    pub(super) fn fractions(&self, vector: DVec3) -> DVec3 {
        let [a, b, c] = [self.edges.x_axis, self.edges.y_axis, self.edges.z_axis];
        if [a.y, a.z, b.z] != [0.0; 3] {
            return self.inverse * vector;
        }
        let z = vector.z / c.z;
        let y = (vector.y - z * c.y) / b.y;
        DVec3::new((vector.x - z * c.x - y * b.x) / a.x, y, z)
    }

    /// The position in the cell: its fractions of the edges are in [0, 1), as far as f64 can tell.
    pub(super) fn wrapped(&self, position: [f64; 3]) -> [f64; 3] {
        let mut point = DVec3::from_array(position);
        // A fraction that is negative by less than a rounding becomes 1, which a second move makes 0.
        for _ in 0..3 {
            let images = self.fractions(point - self.origin).floor();
            if images == DVec3::ZERO {
                break;
            }
            point -= self.edges * images;
        }
        point.to_array()
    }

    /// The edges, each a whole number of times, by which `to` is moved back to be beside `from`: its fractions then differ by at
    /// most a half. That image is the nearest one wherever its distance is below half of the least height of the cell.
    pub(super) fn images(&self, from: [f64; 3], to: [f64; 3]) -> DVec3 {
        (self.fractions(DVec3::from_array(to) - DVec3::from_array(from)) + 0.5).floor()
    }

    /// A position that is moved back by edges.
    pub(super) fn back(&self, position: [f64; 3], images: DVec3) -> [f64; 3] {
        if images == DVec3::ZERO { position } else { (DVec3::from_array(position) - self.edges * images).to_array() }
    }

    /// The distances between opposite faces.
    pub(super) fn heights(&self) -> DVec3 {
        let [a, b, c] = [0, 1, 2].map(|axis| self.inverse.row(axis).length().recip());
        DVec3::new(a, b, c)
    }
}
