//! Particles and the periodic cell: wrapping them into it, and making whole what it cuts. A move is a whole number of
//! edges, so particles that stay keep every bit of their coordinates.

use super::{Column, Particles};
use crate::error::{Error, Result};
use crate::memory::check;
use crate::scene::Cell;
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// What is done about the particles of a periodic cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Periodic {
    /// They stay where the file has them.
    #[default]
    AsListed,
    /// Each particle is moved into the cell: its fractions of the three edges are in [0, 1).
    Wrap,
    /// Molecules that the cell cuts are made whole: by image flags, or by moving the particles of each molecule or residue
    /// to the image that is nearest to the first.
    Unwrap,
}

/// Image flags of LAMMPS (docs.lammps.org/dump.html): the number of edges that a particle has crossed.
const FLAGS: [&str; 3] = ["ix", "iy", "iz"];

/// Columns with the number of a molecule; 0 is none.
const MOLECULES: [&str; 2] = ["mol", "molecule"];

/// Columns that distinguish residues, which are consecutive in a file.
const RESIDUES: [&str; 7] = ["residue", "resid", "resnum", "icode", "resname", "chain", "segid"];

/// The columns that [`Periodic::Unwrap`] reads, as far as the file has them.
pub(in crate::read) fn columns() -> impl Iterator<Item = &'static str> {
    FLAGS.into_iter().chain(MOLECULES).chain(RESIDUES)
}

/// Moves particles by edges of their cell.
///
/// # Errors
/// [`Error::Settings`] for a file without a cell, and where nothing says what belongs together; [`Error::Limits`].
pub(in crate::read) fn apply(periodic: Periodic, particles: &mut Particles) -> Result<()> {
    let (option, what) = match periodic {
        Periodic::AsListed => return Ok(()),
        Periodic::Wrap => ("--wrap", "wrapping"),
        Periodic::Unwrap => ("--unwrap", "unwrapping"),
    };
    let Some(cell) = &particles.cell else {
        return Err(no_cell(option));
    };
    let Some(frame) = Edges::of(cell) else {
        let problem = format!("{what} needs a cell with a volume, but the edges of the cell are {:?}", cell.edges);
        return Err(Error::settings(problem, format!("remove {option}, or use a file with three independent edges")));
    };
    let count = particles.positions.len();
    check(48 * count as u64, || format!("{what} {count} particles"))?;
    let moved: Vec<[f64; 3]> = match periodic {
        Periodic::Unwrap => unwrapped(&frame, particles)?,
        _ => particles.positions.par_iter().map(|position| frame.wrapped(*position)).collect(),
    };
    // Columns of coordinates, such as for --color-by z, follow the particles.
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        for column in particles.columns.iter_mut().filter(|column| column.name == name) {
            let places = particles.positions.iter().zip(&moved);
            for (value, (_, new)) in
                column.values.iter_mut().zip(places).filter(|(value, (old, _))| **value == old[axis])
            {
                *value = new[axis];
            }
        }
    }
    particles.positions = moved;
    Ok(())
}

/// The error for an option that needs a cell.
pub(in crate::read) fn no_cell(option: &str) -> Error {
    let problem = format!("{option} needs a periodic cell, but the file has none");
    Error::settings(problem, "use a file with a cell: Lattice, CRYST1, BOX BOUNDS, a box line")
}

/// The edges of a cell and their inverse.
struct Edges {
    origin: DVec3,
    edges: DMat3,
    inverse: DMat3,
}

impl Edges {
    /// `None` where the edges span no volume.
    fn of(cell: &Cell) -> Option<Self> {
        let edges = DMat3::from_cols_array_2d(&cell.edges);
        let inverse = edges.inverse();
        let volume = edges.determinant();
        let usable = volume != 0.0 && volume.is_finite() && inverse.is_finite();
        usable.then(|| Self { origin: DVec3::from_array(cell.origin), edges, inverse })
    }

    /// A vector as fractions of the edges. Where the first edge is along x and the second in the xy plane, as programs
    /// write cells, one division gives each, so that a whole edge is exactly 1.
    fn fractions(&self, vector: DVec3) -> DVec3 {
        let [a, b, c] = [self.edges.x_axis, self.edges.y_axis, self.edges.z_axis];
        if [a.y, a.z, b.z] != [0.0; 3] {
            return self.inverse * vector;
        }
        let z = vector.z / c.z;
        let y = (vector.y - z * c.y) / b.y;
        DVec3::new((vector.x - z * c.x - y * b.x) / a.x, y, z)
    }

    /// The position in the cell: its fractions of the edges are in [0, 1), as far as f64 can tell.
    fn wrapped(&self, position: [f64; 3]) -> [f64; 3] {
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

    /// The image of a position that is nearest to another one: its fractions differ by at most a half. It is the nearest
    /// one wherever the distance is below half of the least height of the cell.
    fn beside(&self, position: [f64; 3], first: [f64; 3]) -> [f64; 3] {
        let point = DVec3::from_array(position);
        let apart = self.fractions(point - DVec3::from_array(first));
        (point - self.edges * (apart + 0.5).floor()).to_array()
    }
}

/// The positions of molecules that the cell does not cut.
fn unwrapped(frame: &Edges, particles: &Particles) -> Result<Vec<[f64; 3]>> {
    let positions = &particles.positions;
    let column = |name: &str| particles.columns.iter().find(|column| column.name == name);
    let has = |name: &str| particles.has.iter().any(|known| known == name);
    // A LAMMPS dump may have coordinates that are not wrapped, which the reader takes where there are no others.
    let [plain, unwrapped, scaled] = ["x", "xu", "xs"].map(has);
    if !plain && (unwrapped || !scaled && has("xsu")) {
        return Ok(positions.clone());
    }
    if let [Some(x), Some(y), Some(z)] = FLAGS.map(column) {
        let image = |n: usize| DVec3::new(x.values[n], y.values[n], z.values[n]);
        let moved =
            |(n, position): (usize, &[f64; 3])| (DVec3::from_array(*position) + frame.edges * image(n)).to_array();
        return Ok(positions.par_iter().enumerate().map(moved).collect());
    }
    if let Some(molecules) = MOLECULES.into_iter().find_map(column) {
        // Molecules are numbered, and their atoms may be anywhere in the file.
        let mut first: HashMap<u64, usize> = HashMap::new();
        let moved = positions.iter().enumerate().map(|(n, position)| match molecules.values[n] {
            0.0 => *position,
            number => frame.beside(*position, positions[*first.entry(number.to_bits()).or_insert(n)]),
        });
        return Ok(moved.collect());
    }
    let residues: Vec<&Column> = RESIDUES.into_iter().filter_map(column).collect();
    if residues.is_empty() {
        let problem =
            "--unwrap needs image flags (ix, iy, iz), molecules (mol) or residues, but the file has none of them";
        return Err(Error::settings(problem, "use a file with one of them, or remove --unwrap"));
    }
    let same =
        |a: usize, b: usize| residues.iter().all(|column| column.values[a].to_bits() == column.values[b].to_bits());
    let mut first = 0;
    let moved = positions.iter().enumerate().map(|(n, position)| {
        if !same(first, n) {
            first = n;
        }
        frame.beside(*position, positions[first])
    });
    Ok(moved.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tilted cell whose numbers and inverse are dyadic, so that all results are exact.
    const CELL: Cell = Cell { origin: [-1.0, 0.0, 0.5], edges: [[4.0, 0.0, 0.0], [2.0, 8.0, 0.0], [0.0, 4.0, 2.0]] };

    fn particles(positions: &[[f64; 3]], columns: &[(&str, &[f64])]) -> Particles {
        let columns: Vec<Column> =
            columns.iter().map(|(name, values)| Column { name: (*name).into(), values: values.to_vec() }).collect();
        let has = columns.iter().map(|column| column.name.clone()).collect();
        Particles { positions: positions.to_vec(), columns, has, cell: Some(CELL), ..Particles::default() }
    }

    #[test]
    fn wrapping_moves_by_whole_edges_into_the_cell() {
        // Fractions, their whole parts, and the fractions that are left; 1 is the lower face.
        let cases = [
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
            ([0.25, 0.5, 0.75], [0.25, 0.5, 0.75]),
            ([1.0, 1.0, 1.0], [0.0, 0.0, 0.0]),
            ([-0.25, 2.5, 0.5], [0.75, 0.5, 0.5]),
            ([-3.0, 0.125, -0.5], [0.0, 0.125, 0.5]),
        ];
        let mut p =
            particles(&cases.map(|(parts, _)| CELL.place(parts)), &[("z", &cases.map(|(f, _)| CELL.place(f)[2]))]);
        apply(Periodic::Wrap, &mut p).expect("a cell");
        assert_eq!(p.positions, cases.map(|(_, parts)| CELL.place(parts)));
        assert_eq!(p.columns[0].values, cases.map(|(_, parts)| CELL.place(parts)[2]));
    }

    #[test]
    fn a_coordinate_below_the_cell_by_less_than_a_rounding_goes_to_its_lower_face() {
        // 49 times the rounded 1/49 is less than 1.
        let cell = Cell { origin: [0.0; 3], edges: [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 49.0]] };
        let mut p = Particles { positions: vec![[-1e-300, 3.0, 49.0]], cell: Some(cell), ..Particles::default() };
        apply(Periodic::Wrap, &mut p).expect("a cell");
        assert_eq!(p.positions, [[0.0, 3.0, 0.0]]);
    }

    #[test]
    fn unwrapping_takes_flags_then_molecules_then_residues() {
        let at = |parts: [f64; 3]| CELL.place(parts);
        let cut = [[0.875, 0.5, 0.5], [0.125, 0.5, 0.5], [0.5, 0.0625, 0.5], [0.5, 0.9375, 0.5]].map(at);
        let unwrap = |columns: &[(&str, &[f64])]| {
            let mut p = particles(&cut, columns);
            apply(Periodic::Unwrap, &mut p).map(|()| p.positions)
        };
        let two = [at([0.875, 0.5, 0.5]), at([1.125, 0.5, 0.5]), at([0.5, 0.0625, 0.5]), at([0.5, -0.0625, 0.5])];
        let (residues, molecules) = ([7.0, 7.0, 7.0, 7.0], [1.0, 1.0, 2.0, 2.0]);
        assert_eq!(unwrap(&[("residue", &residues), ("mol", &molecules)]).expect("molecules"), two);
        assert_eq!(unwrap(&[("residue", &molecules)]).expect("residues"), two);
        // A residue's number that comes again is another residue.
        assert_eq!(unwrap(&[("resid", &[1.0, 1.0, 1.0, 1.0]), ("resname", &molecules)]).expect("residues"), two);
        assert_eq!(unwrap(&[("mol", &[1.0, 0.0, 2.0, 0.0])]).expect("no molecule"), cut);
        let flags: [&[f64]; 3] = [&[0.0, 1.0, 0.0, -2.0], &[0.0, 0.0, 0.0, 1.0], &[0.0, 0.0, 3.0, 0.0]];
        let [ix, iy, iz] = flags;
        let all = [at([0.875, 0.5, 0.5]), at([1.125, 0.5, 0.5]), at([0.5, 0.0625, 3.5]), at([-1.5, 1.9375, 0.5])];
        assert_eq!(unwrap(&[("ix", ix), ("iy", iy), ("iz", iz), ("mol", &molecules)]).expect("flags"), all);
        // Coordinates of a dump that are not wrapped have no use for flags.
        assert_eq!(unwrap(&[("xu", ix), ("ix", ix), ("iy", iy), ("iz", iz)]).expect("unwrapped"), cut);
        assert!(matches!(unwrap(&[("charge", ix)]), Err(Error::Settings { .. })));
    }

    #[test]
    fn a_cell_is_needed() {
        for cell in [None, Some(Cell { edges: [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 1.0]], ..CELL })] {
            for periodic in [Periodic::Wrap, Periodic::Unwrap] {
                let mut p = Particles { cell, ..particles(&[[1.0; 3]], &[("mol", &[1.0])]) };
                assert!(matches!(apply(periodic, &mut p), Err(Error::Settings { .. })), "{cell:?}");
            }
            apply(Periodic::AsListed, &mut Particles { cell, ..particles(&[[1.0; 3]], &[]) }).expect("nothing to do");
        }
    }
}
