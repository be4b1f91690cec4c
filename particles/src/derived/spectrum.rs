//! The place of residues in their chains, by which PyMOL's and ChimeraX's rainbows are coloured.

use crate::particles::frame::{Column, Particles};
use crate::particles::infer::residues::class;
use crate::particles::residues;
use halfline_ground::error::{Error, Result};

/// The columns that tell chains apart.
const CHAINS: [&str; 3] = ["chain", "segid", "copy"];

/// The columns that it reads besides the columns of residues.
pub(super) const COLUMNS: [&str; 4] = ["copy", "name", "species", "atom_name"];

/// The place of each particle's residue in its chain: 0 at the first, 1 at the last, 0 in a chain of one. NaN for
/// what is no residue of a protein or of a nucleic acid. A chain is a run of such residues with the same chain, segment and copy.
///
/// # Errors
/// [`Error::Settings`] for a file without residues.
pub(super) fn places(particles: &Particles) -> Result<Vec<f64>> {
    let (Some(numbers), Some(polymers)) = (residues::numbers(particles), polymers(particles)) else {
        let problem = "a spectrum is the place of residues in their chains, and the file has no residues";
        return Err(Error::settings(problem, "use a file with residues, such as PDB, mmCIF or GRO"));
    };
    let chains: Vec<&Column> = CHAINS.into_iter().filter_map(|name| particles.column(name)).collect();
    let is_same =
        |a: usize, b: usize| chains.iter().all(|chain| chain.values[a].to_bits() == chain.values[b].to_bits());
    let members: Vec<usize> = (0..numbers.len()).filter(|n| polymers[*n]).collect();
    let mut places = vec![f64::NAN; numbers.len()];
    for chain in members.chunk_by(|a, b| is_same(*a, *b)) {
        let mut count = 0;
        let ranks: Vec<u32> = (0..chain.len())
            .map(|k| {
                count += u32::from(k > 0 && numbers[chain[k]] != numbers[chain[k - 1]]);
                count
            })
            .collect();
        for (n, rank) in chain.iter().zip(ranks) {
            places[*n] = f64::from(rank) / f64::from(count.max(1));
        }
    }
    Ok(places)
}

/// Whether each particle is of a protein or a nucleic acid, by the name of its residue; `None` without such names.
fn polymers(particles: &Particles) -> Option<Vec<bool>> {
    let column = particles.column("resname")?;
    let names = particles.labels.get(&column.name)?;
    let is = |name: &String| {
        use crate::particles::infer::residues::ResidueClass::{Nucleic, Protein};
        matches!(class(name.trim().to_ascii_uppercase().as_bytes()), Some(Protein | Nucleic))
    };
    let are: Vec<bool> = names.iter().map(is).collect();
    Some(column.values.iter().map(|value| are.get(*value as usize).copied().unwrap_or(false)).collect())
}
