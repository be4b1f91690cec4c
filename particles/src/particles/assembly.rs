//! Biological assemblies: copies of a file's chains, transformed by its operators.

use super::frame::{Column, Particles};
use super::grouped::Grouped;
use super::placed::PlacedPart;
use halfline_ground::Operator;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::{check, check_spheres, extend_to};
use halfline_ground::progress::Watch;
use halfline_ground::quote::setting::ASSEMBLY;
use halfline_ground::quote::{list, quote};
use std::collections::HashMap;

/// The most operators in an assembly; without a limit, a short expression could demand more than memory holds.
pub(crate) const MOST_OPERATORS: usize = 1 << 16;

/// Chains that the same operators apply to.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct AssemblyPart {
    /// The chains, by the names that the operators refer to.
    pub(crate) chains: Vec<Vec<u8>>,
    /// The operators in the file's order, each with its name.
    pub(crate) operators: Vec<(String, Operator)>,
}

/// One assembly of a file.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Assembly {
    /// Its identifier in the file: `1`, `PAU`.
    pub(crate) id: String,
    /// Its parts in the file's order.
    pub(crate) parts: Vec<AssemblyPart>,
}

/// The selected assembly.
///
/// # Errors
/// [`Error::Settings`] with the identifiers of the file.
pub(crate) fn find<'a>(assemblies: &'a [Assembly], id: &str, file: &Place) -> Result<&'a Assembly> {
    assemblies
        .iter()
        .find(|assembly| assembly.id == id)
        .ok_or_else(|| unknown(id, assemblies.iter().map(|a| &a.id), file))
}

/// The error for an assembly that is not in the file.
pub(crate) fn unknown<'a>(id: &str, ids: impl Iterator<Item = &'a String>, file: &Place) -> Error {
    let ids = list(ids);
    let mend = match &ids[..] {
        "" => format!("the file has none; remove {ASSEMBLY}"),
        ids => format!("the file has {ids}"),
    };
    Error::settings(format!("{file}: there is no assembly {}", quote(id)), mend)
}

/// The assembly of these atoms: part by part, all atoms of the first operator, then of the second, each in the file's
/// order. `chains` holds every atom's chain, an index of `names`. The cell is dropped, since an assembly is not
/// periodic. A column `copy`, if there is one, is filled with the operator's number from 0.
///
/// # Errors
/// [`Error::Limits`] for more atoms than memory holds, [`Error::Scene`] for an assembly without atoms.
pub(super) fn build(
    assembly: &Assembly,
    mut unit: Particles,
    chains: &[u32],
    names: &[Vec<u8>],
    file: &Place,
    watch: &Watch,
) -> Result<Particles> {
    let atoms = Members::of(chains, names)?;
    let total = total(assembly, &atoms, file)?;
    check_spheres(total, true)?;
    let each = size_of::<[f64; 3]>() + size_of::<u8>() + unit.columns.len() * size_of::<f64>();
    check(total.saturating_mul(each as u64), || format!("the {total} atoms of the assembly"))?;
    let mut whole = with_room(&mut unit, total)?;
    let mut numbers = CopyNumbers::default();
    for part in &assembly.parts {
        let atoms = atoms.of_part(part)?;
        for (name, operator) in &part.operators {
            watch.check()?;
            add(&mut whole, &unit, &atoms, |position| operator.apply(position));
            let copy = numbers.of(name);
            if let Some(Column { values, .. }) = whole.columns.iter_mut().find(|column| column.name == "copy") {
                let before = values.len() - atoms.len();
                values[before..].fill(copy);
            }
        }
    }
    Ok(whole)
}

/// The same assembly as operators over its atoms: the particles are the atoms of the first part, then of the second, each once,
/// and [`Particles::placed`] has the copies of each part.
///
/// # Errors
/// As [`build`].
pub(super) fn keep_operators(
    assembly: &Assembly,
    mut unit: Particles,
    chains: &[u32],
    names: &[Vec<u8>],
    file: &Place,
) -> Result<Particles> {
    let atoms = Members::of(chains, names)?;
    total(assembly, &atoms, file)?;
    let count = assembly.parts.iter().map(|part| atoms.count(part)).sum();
    check_spheres(count, true)?;
    let mut all = with_room(&mut unit, count)?;
    let mut numbers = CopyNumbers::default();
    for part in &assembly.parts {
        let atoms = atoms.of_part(part)?;
        add(&mut all, &unit, &atoms, |position| position);
        let operators = part.operators.iter().map(|(_, operator)| *operator).collect();
        let copies = part.operators.iter().map(|(name, _)| numbers.of(name)).collect();
        all.placed.push(PlacedPart { count: atoms.len(), operators, copies });
    }
    Ok(all)
}

/// Lists for the copies of these atoms, with room for so many.
fn with_room(unit: &mut Particles, count: u64) -> Result<Particles> {
    let (has, skipped) = (std::mem::take(&mut unit.has), std::mem::take(&mut unit.skipped));
    let column = |column: &Column| Ok(Column { name: column.name.clone(), values: room(count)? });
    let columns = unit.columns.iter().map(column).collect::<Result<_>>()?;
    Ok(Particles { positions: room(count)?, elements: room(count)?, columns, has, skipped, ..Particles::default() })
}

/// Adds some of the atoms, at other places.
fn add(copies: &mut Particles, unit: &Particles, atoms: &[usize], place: impl Fn([f64; 3]) -> [f64; 3]) {
    copies.positions.extend(atoms.iter().map(|n| place(unit.positions[*n])));
    copies.elements.extend(atoms.iter().map(|n| unit.elements[*n]));
    for (column, from) in copies.columns.iter_mut().zip(&unit.columns) {
        column.values.extend(atoms.iter().map(|n| from.values[*n]));
    }
}

/// The numbers of operators by their names, from 0 in the order of first occurrence.
#[derive(Default)]
struct CopyNumbers<'a>(HashMap<&'a str, usize>);

impl<'a> CopyNumbers<'a> {
    fn of(&mut self, name: &'a str) -> f64 {
        let next = self.0.len();
        *self.0.entry(name).or_insert(next) as f64
    }
}

/// The number of atoms of an assembly.
///
/// # Errors
/// [`Error::Scene`] for none.
fn total(assembly: &Assembly, atoms: &Members<'_>, file: &Place) -> Result<u64> {
    let copies = |part: &AssemblyPart| (part.operators.len() as u64).saturating_mul(atoms.count(part));
    let total = assembly.parts.iter().map(copies).fold(0, u64::saturating_add);
    if total == 0 {
        let problem = format!("assembly {} has no atoms, because the file has none of its chains", quote(&assembly.id));
        return Err(Error::scene(file.clone(), problem, format!("remove {ASSEMBLY}, or use another")));
    }
    Ok(total)
}

/// The atoms grouped by chain, so that the cost of parts with many operators and of files with many chains stays
/// proportional to their size.
struct Members<'a> {
    /// The index of a chain by its name.
    chains: HashMap<&'a [u8], usize>,
    /// The atoms of each chain, in the file's order.
    atoms: Grouped,
}

impl<'a> Members<'a> {
    /// Groups atoms whose chains are indices of `names`.
    fn of(chains: &[u32], names: &'a [Vec<u8>]) -> Result<Self> {
        let need = 8 * chains.len() + 64 * names.len();
        check(need as u64, || format!("the {} chains of the file", names.len()))?;
        let of_chains = chains.iter().map(|chain| *chain as usize).zip(0..);
        let atoms = Grouped::new(names.len(), of_chains.filter(|(chain, _)| *chain < names.len()));
        let chains = names.iter().enumerate().map(|(chain, name)| (&name[..], chain)).collect();
        Ok(Self { chains, atoms })
    }

    /// The chains of a part, without duplicates.
    fn chains_of(&self, part: &AssemblyPart) -> Vec<usize> {
        let mut chains: Vec<usize> =
            part.chains.iter().filter_map(|name| self.chains.get(&name[..]).copied()).collect();
        chains.sort_unstable();
        chains.dedup();
        chains
    }

    /// The number of atoms of a part.
    fn count(&self, part: &AssemblyPart) -> u64 {
        self.chains_of(part).into_iter().map(|chain| self.atoms.of(chain).len() as u64).sum()
    }

    /// The atoms of a part, in the file's order.
    fn of_part(&self, part: &AssemblyPart) -> Result<Vec<usize>> {
        let mut atoms = room(self.count(part))?;
        let of_chain = |chain: usize| self.atoms.of(chain).iter().map(|n| *n as usize);
        self.chains_of(part).into_iter().for_each(|chain| atoms.extend(of_chain(chain)));
        atoms.sort_unstable();
        Ok(atoms)
    }
}

fn room<T>(n: u64) -> Result<Vec<T>> {
    let mut list = Vec::new();
    extend_to(&mut list, n as usize)?;
    Ok(list)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURN: Operator = Operator([[0.0, -1.0, 0.0, 10.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
    const STEP: Operator = Operator([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 5.0]]);

    #[test]
    fn products_are_applied_from_the_right() {
        let both = STEP.after(&TURN);
        assert_eq!(both.apply([1.0, 2.0, 3.0]), STEP.apply(TURN.apply([1.0, 2.0, 3.0])));
        assert_eq!(both.apply([1.0, 2.0, 3.0]), [8.0, 1.0, 8.0]);
        let other = Operator([[2.0, 0.0, 1.0, 1.0], [0.0, 3.0, 0.0, -1.0], [1.0, 0.0, 0.0, 2.0]]);
        assert_ne!(other.after(&TURN), TURN.after(&other));
        assert_eq!(TURN.after(&other).apply([1.0, 2.0, 3.0]), TURN.apply(other.apply([1.0, 2.0, 3.0])));
    }

    #[test]
    fn copies_are_ordered_by_operator_and_part() {
        let unit = Particles {
            positions: vec![[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]],
            elements: vec![6, 7, 8],
            columns: ["serial", "copy"].map(|name| Column { name: name.into(), values: vec![1.0, 2.0, 3.0] }).to_vec(),
            ..Particles::default()
        };
        let names = [b"A".to_vec(), b"B".to_vec()];
        let part = |chains: &[&[u8]], operators: &[(&str, Operator)]| AssemblyPart {
            chains: chains.iter().map(|name| name.to_vec()).collect(),
            operators: operators.iter().map(|(name, operator)| ((*name).to_owned(), *operator)).collect(),
        };
        let parts = vec![part(&[b"B", b"A"], &[("1", TURN), ("2", STEP)]), part(&[b"B"], &[("2", STEP)])];
        let assembly = Assembly { id: "1".into(), parts };
        let file = Place::file("text");
        let whole = build(&assembly, unit.clone(), &[0, 1, 0], &names, &file, &Watch::default()).expect("an assembly");
        assert_eq!(whole.elements, [6, 7, 8, 6, 7, 8, 7]);
        assert_eq!(whole.columns[0].values, [1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 2.0]);
        assert_eq!(whole.columns[1].values, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!((whole.positions[1], whole.positions[6]), ([10.0, 2.0, 0.0], [2.0, 0.0, 5.0]));
        let empty = Assembly { id: "2".into(), parts: vec![part(&[b"C"], &[("1", STEP)])] };
        let error = build(&empty, unit, &[0, 1, 0], &names, &file, &Watch::default())
            .map(drop)
            .expect_err("nothing")
            .to_string();
        assert!(error.contains("no atoms"), "{error}");
        let error = find(&[assembly, empty], "3", &file).expect_err("no third").to_string();
        assert!(error.contains("`3`") && error.contains("1, 2"), "{error}");
    }

    #[test]
    fn a_frame_beyond_memory_is_refused_before_it_is_built() {
        let atoms = 1_000_000;
        let unit = Particles { positions: vec![[0.0; 3]; atoms], elements: vec![6; atoms], ..Particles::default() };
        let part = AssemblyPart { chains: vec![b"A".to_vec()], operators: vec![("1".into(), STEP); MOST_OPERATORS] };
        let assembly = Assembly { id: "1".into(), parts: vec![part] };
        let file = Place::file("text");
        let built = build(&assembly, unit, &vec![0; atoms], &[b"A".to_vec()], &file, &Watch::default()).map(drop);
        // 6.6e10 atoms are terabytes.
        let error = built.expect_err("no memory is so large");
        assert!(matches!(error, Error::Limits { .. }) && error.to_string().contains("65536000000 spheres"), "{error}");
    }
}
