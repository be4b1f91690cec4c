//! Placement of the copies of a set of spheres: by whole edges of a cell, or by rotations and translations.

use super::enclosure::Enclosure;
use glam::DVec3;
use halfline_ground::Operator;

/// Copies along the edges of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lattice {
    /// Copies along each edge, the original included.
    pub(crate) copies: [u32; 3],
    pub(crate) edges: [DVec3; 3],
}

impl Lattice {
    /// The number of copies.
    pub(crate) fn count(&self) -> u64 {
        self.copies.iter().fold(1, |n: u64, k| n.saturating_mul(u64::from(*k)))
    }

    /// The place of copy number `copy` along the edges; that along the first edge grows fastest.
    pub(crate) fn place(&self, copy: u64) -> [u32; 3] {
        let [na, nb, _] = self.copies.map(u64::from);
        [copy % na, copy / na % nb, copy / na / nb].map(|n| n as u32)
    }

    /// The translation of the copy at this place.
    pub(crate) fn shift(&self, place: [u32; 3]) -> DVec3 {
        let ([i, j, k], [a, b, c]) = (place.map(f64::from), self.edges);
        i * a + j * b + k * c
    }

    /// The enclosure of the copies of everything in `enclosure` at these places; the ends of ranges are excluded.
    fn image(&self, places: &[[u32; 2]; 3], enclosure: &Enclosure) -> Enclosure {
        // Each coordinate of a shift is monotonic in each of the three numbers.
        let ends = [false, true].map(|most| {
            let axis = |axis: usize| {
                let at = |edge: usize| {
                    let [first, end] = places[edge];
                    let forward = self.edges[edge][axis] >= 0.0;
                    if forward == most { end - 1 } else { first }
                };
                self.shift([at(0), at(1), at(2)])[axis]
            };
            DVec3::new(axis(0), axis(1), axis(2))
        });
        Enclosure { low: enclosure.low + ends[0], high: enclosure.high + ends[1], radii: enclosure.radii }
    }
}

/// The rule by which copies of a set of spheres are placed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum CopyRule {
    Lattice(Lattice),
    Operators(Vec<Operator>),
}

/// Some of the copies of a placement: ranges along each edge, the ends excluded. Operators count along the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Copies(pub(crate) [[u32; 2]; 3]);

impl Copies {
    /// The number of these copies along an edge.
    pub(crate) fn side(&self, edge: usize) -> u32 {
        self.0[edge][1] - self.0[edge][0]
    }

    /// The number of these copies.
    pub(crate) fn count(&self) -> u64 {
        (0..3).map(|edge| u64::from(self.side(edge))).product()
    }

    /// The two halves along an edge.
    pub(crate) fn halved(&self, edge: usize) -> [Self; 2] {
        let [first, end] = self.0[edge];
        let middle = first.midpoint(end);
        [[first, middle], [middle, end]].map(|range| {
            let mut places = self.0;
            places[edge] = range;
            Self(places)
        })
    }
}

impl CopyRule {
    /// The number of copies.
    pub(crate) fn count(&self) -> u64 {
        match self {
            Self::Lattice(lattice) => lattice.count(),
            Self::Operators(operators) => operators.len() as u64,
        }
    }

    /// The number of copies along each edge.
    fn sides(&self) -> [u32; 3] {
        match self {
            Self::Lattice(lattice) => lattice.copies,
            Self::Operators(operators) => [operators.len() as u32, 1, 1],
        }
    }

    /// All copies.
    pub(crate) fn all(&self) -> Copies {
        Copies(self.sides().map(|n| [0, n]))
    }

    /// The number of the copy at this place.
    pub(crate) fn number(&self, place: [u32; 3]) -> u64 {
        let ([na, nb, _], [i, j, k]) = (self.sides().map(u64::from), place.map(u64::from));
        (k * nb + j) * na + i
    }

    /// The copy with this number.
    pub(crate) fn one(&self, copy: u64) -> Copies {
        let place = match self {
            Self::Lattice(lattice) => lattice.place(copy),
            Self::Operators(_) => [copy as u32, 0, 0],
        };
        Copies(place.map(|n| [n, n + 1]))
    }

    /// A box around these copies of everything in `enclosure`.
    pub(crate) fn image(&self, copies: &Copies, enclosure: &Enclosure) -> Enclosure {
        match self {
            Self::Lattice(lattice) => lattice.image(&copies.0, enclosure),
            Self::Operators(operators) => {
                let [first, end] = copies.0[0];
                let images = operators[first as usize..end as usize].iter().map(|operator| image(operator, enclosure));
                images.fold(Enclosure::NOTHING, |all, image| all.with(&image))
            }
        }
    }

    /// Calls `each` with the number of every one of these copies, in order, and the function that places its centres.
    pub(crate) fn each(&self, copies: &Copies, mut each: impl FnMut(u64, &dyn Fn([f64; 3]) -> [f64; 3])) {
        let [columns, rows, layers] = copies.0.map(|[first, end]| first..end);
        for (k, j) in layers.flat_map(|k| rows.clone().map(move |j| (k, j))) {
            for i in columns.clone() {
                let number = self.number([i, j, k]);
                match self {
                    Self::Lattice(lattice) => {
                        let shift = lattice.shift([i, j, k]);
                        each(number, &|center| (DVec3::from_array(center) + shift).to_array());
                    }
                    Self::Operators(operators) => each(number, &|center| operators[i as usize].apply(center)),
                }
            }
        }
    }
}

/// The enclosure of the images of everything in `enclosure`, as [`Operator::apply`] rounds them.
fn image(operator: &Operator, enclosure: &Enclosure) -> Enclosure {
    let (low, high) = (enclosure.low.to_array(), enclosure.high.to_array());
    let corner = |row: [f64; 4], ends: [[f64; 3]; 2]| {
        let at = |k: usize| row[k] * ends[usize::from(row[k] < 0.0)][k];
        at(0) + at(1) + at(2) + row[3]
    };
    let [low, high] = [[low, high], [high, low]].map(|ends| operator.0.map(|row| corner(row, ends)));
    Enclosure { low: DVec3::from_array(low), high: DVec3::from_array(high), radii: enclosure.radii }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every rounded image lies in the rounded box. The image of some corner lies on each of its sides: nothing could be narrower.
    #[test]
    fn boxes_of_copies_contain_every_copy_without_a_margin() {
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        for case in 0..200 {
            let scale = 10f64.powi(case % 9 - 4);
            let mut vector = || [random() * scale, random() * scale, random() * scale];
            let points: Vec<[f64; 3]> = (0..40).map(|_| vector()).collect();
            let around = points.iter().fold(Enclosure::NOTHING, |all, p| all.with(&Enclosure::of(*p, 1.0)));
            let lattice = Lattice { copies: [5, 4, 3], edges: [vector(), vector(), vector()].map(DVec3::from_array) };
            let rows = [vector(), vector(), vector()].map(|[a, b, c]| [a, b, c, a + b]);
            let placements = [
                (CopyRule::Lattice(lattice), Copies([[1, 5], [0, 3], [1, 3]])),
                (CopyRule::Operators(vec![Operator(rows); 3]), Copies([[1, 3], [0, 1], [0, 1]])),
            ];
            for (placement, copies) in placements {
                let image = placement.image(&copies, &around);
                let (mut found, mut count) = (Enclosure::NOTHING, 0);
                placement.each(&copies, |_, place| {
                    count += 1;
                    for corner in (0..8).map(|n| {
                        let (low, high) = (around.low, around.high);
                        let side = |k: usize| if n >> k & 1 == 0 { low[k] } else { high[k] };
                        [side(0), side(1), side(2)]
                    }) {
                        found = found.with(&Enclosure::of(place(corner), 1.0));
                    }
                    for p in &points {
                        let at = DVec3::from_array(place(*p));
                        assert!(image.low.cmple(at).all() && at.cmple(image.high).all(), "case {case}: {at}");
                    }
                });
                assert_eq!(count, copies.count());
                assert_eq!((found.low, found.high), (image.low, image.high), "case {case}");
            }
        }
    }
}
