//! The residues of a frame: consecutive particles with the same number, insertion code, name, chain and segment.

use super::frame::{Column, Particles};

/// The column of names that says which of several files a particle is from.
pub(crate) const FILE: &str = "file";

/// The columns that distinguish residues, as far as a file has them.
pub(crate) const COLUMNS: [&str; 8] = [FILE, "residue", "resid", "resnum", "icode", "resname", "chain", "segid"];

/// The number of each particle's residue in the file's order, from 0; `None` where the file has none of [`COLUMNS`].
pub(crate) fn numbers(particles: &Particles) -> Option<Vec<u32>> {
    let columns: Vec<&Column> = COLUMNS.into_iter().filter_map(|name| particles.column(name)).collect();
    let differ = |n: usize| columns.iter().any(|column| column.values[n].to_bits() != column.values[n - 1].to_bits());
    let mut number = 0;
    let of = |n: usize| {
        number += u32::from(n > 0 && differ(n));
        number
    };
    (!columns.is_empty()).then(|| (0..particles.positions.len()).map(of).collect())
}
