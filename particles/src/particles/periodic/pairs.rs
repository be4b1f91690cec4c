//! Pairs of atoms that are near each other, across the faces of the cell too.

use super::super::grouped::Grouped;
use super::edges::Edges;
use glam::DVec3;
use halfline_ground::error::{Error, Result};
use halfline_ground::parallel::{self, CHEAP};
use halfline_ground::quote::setting::UNWRAP;

/// The pairs of atoms whose nearest images are at most the sum of their reaches apart, as far as they are wanted: each once,
/// the lower index first, in ascending order. An atom with the reach 0 is in none. The time grows with the atoms and their
/// neighbours: cells as wide as the longest reach hold few of them.
///
/// # Errors
/// [`Error::Limits`] for atoms that lie so close that they have no number of neighbours to speak of.
pub(super) fn pairs(
    frame: &Edges,
    positions: &[[f64; 3]],
    reaches: &[f32],
    is_pair: impl Fn(usize, usize) -> bool + Sync,
) -> Result<Vec<[u32; 2]>> {
    let largest = parallel::reduce(reaches, 0.0, f32::max);
    if largest <= 0.0 {
        return Ok(Vec::new());
    }
    let width = 2.0 * f64::from(largest);
    let grid = Grid::new(frame, positions, reaches, width);
    if let Some(most) = grid.crowd() {
        let problem = format!(
            "{UNWRAP}: up to {most} atoms lie within {width:.1} of each other, too many to look for bonds among all"
        );
        return Err(Error::Limits {
            problem,
            mend: format!("use a file with image flags (ix, iy, iz), or remove {UNWRAP}"),
        });
    }
    let of = |a: usize| {
        let is_near = |b: &u32| {
            let b = *b as usize;
            let apart = grid.fractions[b] - grid.fractions[a];
            let apart = frame.edges * (apart - apart.round());
            let most = f64::from(reaches[a] + reaches[b]);
            b > a && apart.length_squared() <= most * most && is_pair(a, b)
        };
        let mut found: Vec<u32> = grid.around(a).filter(is_near).collect();
        found.sort_unstable();
        found.into_iter().map(move |b| [a as u32, b])
    };
    Ok(parallel::collect(positions.len(), ATOMS_PER_JOB, &|atoms, out| {
        out.extend(atoms.filter(|a| reaches[*a] > 0.0).flat_map(of));
    }))
}

/// Atoms whose pairs one job finds.
const ATOMS_PER_JOB: usize = 1 << 8;

/// The most pairs within cells for each atom, and in all: bonds give some 15, and a thousand atoms at one place a thousand.
const MOST_PAIRS: u64 = 1 << 10;
const FEW_PAIRS: u64 = 1 << 24;

/// The most cells along an edge.
const FINEST: f64 = 1e12;

/// Atoms by their cell of a grid in the periodic cell. A large and sparse one repeats, so that cells far from each other are one.
struct Grid {
    /// Cells along each edge before they repeat, and in all, a multiple of them.
    sides: [usize; 3],
    steps: [f64; 3],
    /// The positions as fractions of the edges, in [0, 1].
    fractions: Vec<DVec3>,
    /// The atoms with a reach in each cell.
    atoms: Grouped,
}

impl Grid {
    /// With cells that are at least `width` across.
    fn new(frame: &Edges, positions: &[[f64; 3]], reaches: &[f32], width: f64) -> Self {
        let fraction = |position: [f64; 3]| {
            let fractions = frame.fractions(DVec3::from_array(position) - frame.origin);
            fractions - fractions.floor()
        };
        let fractions = parallel::values(positions.len(), CHEAP, |n| fraction(positions[n]));
        // A sparse cell needs no more cells than it has atoms.
        let most = (2.0 * (positions.len() as f64).cbrt()).ceil().max(3.0);
        let all = (frame.heights() / width).to_array().map(|side| side.floor().clamp(1.0, FINEST));
        let sides = all.map(|side| side.min(most));
        let steps = [0, 1, 2].map(|k| all[k] - all[k] % sides[k]);
        let mut grid = Self { sides: sides.map(|side| side as usize), steps, fractions, atoms: Grouped::default() };
        let all = (0..positions.len()).filter(|n| reaches[*n] > 0.0);
        let placed = all.map(|n| (grid.index(grid.cell(n)), n as u32));
        grid.atoms = Grouped::new(grid.sides.iter().product(), placed);
        grid
    }

    fn cell(&self, n: usize) -> [usize; 3] {
        let fractions = self.fractions[n].to_array();
        let step = |axis: usize| (fractions[axis] * self.steps[axis]).floor().min(self.steps[axis] - 1.0);
        // The cast saturates.
        [0, 1, 2].map(|axis| step(axis) as usize % self.sides[axis])
    }

    /// The most atoms of a cell, where the pairs within cells are too many.
    fn crowd(&self) -> Option<u64> {
        let of = |cell: usize| self.atoms.of(cell).len() as u64;
        let cells = 0..self.sides.iter().product();
        let atoms: u64 = cells.clone().map(of).sum();
        let pairs = cells.clone().map(|cell| of(cell).saturating_pow(2)).fold(0, u64::saturating_add);
        (pairs > MOST_PAIRS * atoms + FEW_PAIRS).then(|| cells.map(of).max()).flatten()
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.sides[1] + y) * self.sides[0] + x
    }

    /// The atoms in the cell of an atom and in those beside it, each once.
    fn around(&self, n: usize) -> impl Iterator<Item = u32> {
        let cell = self.cell(n);
        // Two cells are on both sides of each other.
        let adjacent = |axis: usize| {
            let (side, at) = (self.sides[axis], cell[axis]);
            (0..side.min(3)).map(move |step| (at + side - 1 + step.min(side - 1)) % side)
        };
        let (xs, ys, zs) = (adjacent(0), adjacent(1), adjacent(2));
        zs.flat_map(move |z| {
            let xs = xs.clone();
            ys.clone().flat_map(move |y| xs.clone().map(move |x| [x, y, z]))
        })
        .flat_map(move |place| self.atoms.of(self.index(place)).iter().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline_ground::Cell;

    /// All pairs, all images.
    fn by_all_pairs(cell: &Cell, positions: &[[f64; 3]], reaches: &[f32]) -> Vec<[u32; 2]> {
        let steps = || (-2..=2).map(f64::from);
        let mut found = Vec::new();
        for a in 0..positions.len() {
            for b in a + 1..positions.len() {
                let near = |shift: [f64; 3]| {
                    let square: f64 = (0..3)
                        .map(|k| {
                            let moved = (0..3).map(|edge| shift[edge] * cell.edges[edge][k]).sum::<f64>();
                            (positions[b][k] + moved - positions[a][k]).powi(2)
                        })
                        .sum();
                    reaches[a] > 0.0 && reaches[b] > 0.0 && square.sqrt() <= f64::from(reaches[a] + reaches[b])
                };
                if steps().any(|x| steps().any(|y| steps().any(|z| near([x, y, z])))) {
                    found.push([a as u32, b as u32]);
                }
            }
        }
        found
    }

    /// Cells from one to many grid cells across; the longest reach is below half of the least height.
    #[test]
    fn the_grid_finds_what_all_pairs_give() {
        let mut state = 11_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for (edges, count) in [
            ([[4.0, 0.0, 0.0], [1.0, 4.5, 0.0], [0.5, -1.0, 4.2]], 12),
            ([[8.0, 0.0, 0.0], [-2.0, 5.0, 0.0], [1.0, 1.0, 14.0]], 60),
            ([[15.0, 1.0, 2.0], [3.0, 16.0, -4.0], [0.0, 2.0, 12.0]], 300),
        ] {
            let cell = Cell { origin: [3.0, -2.0, 1.0], edges };
            let frame = Edges::of(&cell).expect("a volume");
            // Over the faces too.
            let positions: Vec<_> =
                (0..count).map(|_| cell.place([next(), next(), next()].map(|x| 3.0 * x - 1.0))).collect();
            let reaches: Vec<f32> = (0..count).map(|n| [0.91, 0.37, 0.79, 0.0][n % 4]).collect();
            let wrapped: Vec<_> = positions.iter().map(|position| frame.wrapped(*position)).collect();
            let expected = by_all_pairs(&cell, &wrapped, &reaches);
            assert!(expected.len() > 3, "{} pairs", expected.len());
            assert_eq!(pairs(&frame, &positions, &reaches, |_, _| true).expect("few"), expected);
            let even: Vec<_> = expected.into_iter().filter(|[a, b]| (a + b) % 2 == 0).collect();
            assert_eq!(pairs(&frame, &positions, &reaches, |a, b| (a + b) % 2 == 0).expect("few"), even);
        }
    }
}
