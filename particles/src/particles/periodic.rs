//! Particles and the periodic cell: wrapping them into it, and making whole what it cuts. A move is a whole number of
//! edges, so particles that stay keep every bit of their coordinates.

mod atoms;
mod edges;
pub(crate) mod images;
mod join;
mod pairs;

use super::frame::Particles;
use super::residues;
use atoms::Atoms;
use edges::Edges;
use glam::DVec3;
use halfline_ground::error::{Error, Result};
use halfline_ground::memory::check;
use halfline_ground::parallel;
use halfline_ground::quote::count;
use halfline_ground::quote::setting::{UNWRAP, WRAP};
use join::{Endless, Joined};
use pairs::pairs;

/// The treatment of the particles of a periodic cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Periodic {
    /// Particles stay where the file has them.
    #[default]
    AsListed,
    /// Each particle is moved into the cell: its fractions of the three edges are in [0, 1).
    Wrap,
    /// Molecules that the cell cuts are made whole: by image flags; else along bonds, which are found by distance where elements
    /// are known, then by moving the parts of each molecule or residue to the image that is nearest to its first particle, then
    /// what touches a protein or nucleic acid to it.
    Unwrap,
}

/// Image flags, the number of edges that a particle has crossed: of LAMMPS (docs.lammps.org/dump.html) and of GSD, of OVITO's property
/// Periodic Image, and `travel` of QUIP, which `map_into_cell` of its module Atoms counts (github.com/libAtoms/QUIP).
const FLAGS: [[&str; 3]; 4] = [
    ["ix", "iy", "iz"],
    ["image_x", "image_y", "image_z"],
    ["PeriodicImage_x", "PeriodicImage_y", "PeriodicImage_z"],
    ["travel_x", "travel_y", "travel_z"],
];

/// The edges by which QUIP would move a particle into its cell, where fractions are from -1/2 to 1/2: the positions are not wrapped. Where
/// they are, others have written images under this name.
const SHIFTS: [&str; 3] = ["map_shift_x", "map_shift_y", "map_shift_z"];

/// Columns with the number of a molecule; 0 is none.
const MOLECULES: [&str; 2] = ["mol", "molecule"];

/// Bytes per particle while they are moved: positions, edges, cells and bonds.
const WORK: u64 = 160;

/// The columns that [`Periodic::Unwrap`] reads, as far as the file has them.
pub(crate) fn columns() -> impl Iterator<Item = &'static str> {
    FLAGS.into_iter().flatten().chain(SHIFTS).chain(MOLECULES).chain(residues::COLUMNS)
}

/// Whether a column has image flags.
pub(crate) fn is_image(name: &str) -> bool {
    FLAGS.into_iter().flatten().chain(SHIFTS).any(|known| known.eq_ignore_ascii_case(name))
}

/// Moves particles by edges of their cell.
///
/// # Errors
/// [`Error::Settings`] for a file without a cell, and where nothing says what belongs together; [`Error::Limits`].
pub fn apply(periodic: Periodic, particles: &mut Particles) -> Result<()> {
    let (option, what) = match periodic {
        Periodic::AsListed => return Ok(()),
        Periodic::Wrap => (WRAP, "wrapping"),
        Periodic::Unwrap => (UNWRAP, "unwrapping"),
    };
    let Some(cell) = &particles.cell else {
        return Err(no_cell(option));
    };
    let Some(frame) = Edges::of(cell) else {
        let problem = format!("{what} needs a cell with a volume, but the edges of the cell are {:?}", cell.edges);
        return Err(Error::settings(problem, format!("remove {option}, or use a file with three independent edges")));
    };
    let number = particles.positions.len();
    check(WORK * number as u64, || format!("{what} {number} particles"))?;
    let moved: Vec<[f64; 3]> = match periodic {
        Periodic::Unwrap => unwrapped(&frame, particles)?,
        _ => parallel::map(&particles.positions, |position| frame.wrapped(*position)),
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
pub fn no_cell(option: &str) -> Error {
    let problem = format!("{option} needs a periodic cell, but the file has none");
    Error::settings(problem, "use a file with a cell: Lattice, CRYST1, BOX BOUNDS, a box line")
}

/// The positions of molecules that the cell does not cut.
fn unwrapped(frame: &Edges, particles: &mut Particles) -> Result<Vec<[f64; 3]>> {
    let positions = &particles.positions;
    let column = |name: &str| particles.columns.iter().find(|column| column.name.eq_ignore_ascii_case(name));
    let has = |name: &str| particles.has.iter().any(|known| known == name);
    // A LAMMPS dump may have coordinates that are not wrapped, which the reader takes where there are no others.
    let [plain, unwrapped, scaled] = ["x", "xu", "xs"].map(has);
    if !plain && (unwrapped || !scaled && has("xsu")) {
        return Ok(positions.clone());
    }
    let flags =
        |names: [&str; 3]| if let [Some(x), Some(y), Some(z)] = names.map(column) { Some([x, y, z]) } else { None };
    let shifts = flags(SHIFTS);
    if let Some(images) = FLAGS.into_iter().find_map(flags).or(shifts) {
        let moved = |n: usize| {
            let [x, y, z] = images.map(|column| column.values[n]);
            frame.back(positions[n], -DVec3::new(x, y, z))
        };
        let moved = parallel::from_fn(positions.len(), moved);
        let is_centred =
            |position: &[f64; 3]| frame.fractions(DVec3::from_array(*position)).abs().max_element() < 0.5 + 1e-9;
        let are_shifts = shifts == Some(images) && parallel::all(&moved, is_centred);
        return Ok(if are_shifts { positions.clone() } else { moved });
    }
    let (groups, are_residues): (Vec<Option<u64>>, bool) = match MOLECULES.into_iter().find_map(column) {
        // Molecules are numbered, and their atoms may be anywhere in the file; 0 is none.
        Some(molecules) => (molecules.values.iter().map(|n| (*n != 0.0).then(|| n.to_bits())).collect(), false),
        None => {
            let numbers = residues::numbers(particles).unwrap_or_default();
            (numbers.into_iter().map(|number| Some(u64::from(number))).collect(), true)
        }
    };
    let atoms = Atoms::of(particles);
    if groups.is_empty() && !atoms.has_elements {
        let problem = format!(
            "{UNWRAP} needs image flags (ix, iy, iz, or an image of extended XYZ), molecules (mol), residues or elements, but the file has none of them"
        );
        return Err(Error::settings(problem, format!("use a file with one of them, or remove {UNWRAP}")));
    }
    let (mut bonds, reaches) = at_one_place(positions, &atoms.bonds);
    bonds.extend(pairs(frame, positions, &reaches, |_, _| true)?);
    let mut joined = Joined::along(frame, positions, &bonds);
    joined.link(frame, positions, &joined.links(&groups));
    let touch = |a, b| atoms.may_touch(a, b) && joined.are_apart(a, b);
    joined.link(frame, positions, &pairs(frame, positions, &atoms.contacts, touch)?);
    let Joined { images, endless, .. } = joined;
    let moved = parallel::from_fn(positions.len(), |n| frame.back(positions[n], images[n]));
    let mut warnings = Vec::new();
    if let Some(Endless { first, size }) = endless.first() {
        let whole = if endless.len() == 1 { "it" } else { "them" };
        warnings.push(format!(
            "{UNWRAP}: {} bonded to an own image across the cell, so nothing makes {whole} whole; the first has {}, from particle \
             {first} on",
            are(endless.len() as u64, "molecule"),
            count(*size, "particle")
        ));
    }
    if are_residues && !atoms.has_elements && !positions.is_empty() {
        warnings
            .push(format!("{UNWRAP}: no element is known, so each residue is whole, but chains of them may stay cut"));
    }
    particles.skipped.assumed.extend(warnings);
    Ok(moved)
}

/// Pairs that join atoms at one place to the one of them with the longest reach, and the reaches, 0 for the others. What is
/// near one of them is near that one, so all pairs would join no more.
fn at_one_place(positions: &[[f64; 3]], reaches: &[f32]) -> (Vec<[u32; 2]>, Vec<f32>) {
    let place = |n: u32| positions[n as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..reaches.len() as u32).filter(|n| reaches[*n as usize] > 0.0).collect();
    let key = |n: &u32| (place(*n), std::cmp::Reverse(reaches[*n as usize].to_bits()), *n);
    parallel::sort(&mut order, |a, b| key(a).cmp(&key(b)));
    let (mut joined, mut left) = (Vec::new(), reaches.to_vec());
    for same in order.chunk_by(|a, b| place(*a) == place(*b)) {
        for n in &same[1..] {
            joined.push([same[0].min(*n), same[0].max(*n)]);
            left[*n as usize] = 0.0;
        }
    }
    (joined, left)
}

/// `1 molecule is`, `2 molecules are`.
fn are(n: u64, noun: &str) -> String {
    format!("{} {}", count(n, noun), if n == 1 { "is" } else { "are" })
}

#[cfg(test)]
mod tests {
    use super::super::frame::Column;
    use super::*;
    use halfline_ground::Cell;

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
        for names in FLAGS.into_iter().chain([SHIFTS]) {
            let [x, y, z] = names;
            assert_eq!(unwrap(&[(x, ix), (y, iy), (z, iz), ("mol", &molecules)]).expect("flags"), all, "{names:?}");
        }
        // The shifts of QUIP move each into the cell around the origin, from where it is without them.
        let frame = Edges::of(&CELL).expect("a volume");
        let shift = |k: usize| cut.map(|place| -(frame.fractions(DVec3::from_array(place)) + 0.5).floor()[k]);
        let [x, y, z] = [0, 1, 2].map(shift);
        let quip = unwrap(&[("map_shift_x", &x), ("map_shift_y", &y), ("map_shift_z", &z)]).expect("shifts");
        assert!(quip == cut && [x, y, z].concat().iter().any(|shift| *shift != 0.0), "not wrapped");
        // Coordinates of a dump that are not wrapped have no use for flags.
        assert_eq!(unwrap(&[("xu", ix), ("ix", ix), ("iy", iy), ("iz", iz)]).expect("unwrapped"), cut);
        assert!(matches!(unwrap(&[("charge", ix)]), Err(Error::Settings { .. })));
    }

    /// A chain of carbon atoms at distances of 1.5 from a start, each step in one of the directions in turn.
    fn chain(start: [f64; 3], steps: &[[f64; 3]], count: usize) -> Vec<[f64; 3]> {
        let mut at = DVec3::from_array(start);
        let step = |n: usize| {
            let here = at;
            at += DVec3::from_array(steps[n % steps.len()]) * 1.5;
            here.to_array()
        };
        (0..count).map(step).collect()
    }

    /// The chains in a tilted cell, wrapped into it.
    fn cut(chains: &[Vec<[f64; 3]>], columns: &[(&str, &[f64])]) -> Particles {
        let cell = Cell { origin: [-1.0, 2.0, 0.5], edges: [[20.0, 0.0, 0.0], [6.0, 24.0, 0.0], [-3.0, 5.0, 18.0]] };
        let mut p = Particles { cell: Some(cell), ..particles(&chains.concat(), columns) };
        p.elements = vec![6; p.positions.len()];
        apply(Periodic::Wrap, &mut p).expect("a cell");
        p
    }

    /// All pairs of atoms at one place would be some 10^9.
    #[test]
    fn many_atoms_at_one_place_are_one() {
        let count = 60_000;
        let place = |n: usize| [[0.3, 19.6][n % 2], 1.0, 1.0];
        let mut p = particles(&(0..count).map(place).collect::<Vec<_>>(), &[]);
        p.cell = Some(Cell { origin: [0.0; 3], edges: [[20.0, 0.0, 0.0], [0.0, 20.0, 0.0], [0.0, 0.0, 20.0]] });
        // Hydrogen at the second place reaches carbon at the first, and is bonded by it alone.
        p.elements = (0..count).map(|n| [6, 1][n % 2]).collect();
        apply(Periodic::Unwrap, &mut p).expect("bonds");
        for (n, found) in p.positions.iter().enumerate() {
            let expected = place(n)[0] - [0.0, 20.0][n % 2];
            assert!((found[0] - expected).abs() < 1e-12, "{n}: {found:?}");
        }
    }

    /// Chains longer than the cell, nowhere near each other or their own images, which residues alone would leave in pieces.
    #[test]
    fn chains_are_joined_along_their_bonds() {
        let long = chain([3.0, 4.0, 5.0], &[[0.8, 0.6, 0.0], [0.0, 0.6, 0.8]], 60);
        let far = chain([1.0, 20.0, 9.0], &[[0.6, 0.0, -0.8]], 30);
        let whole = [long.clone(), far.clone()];
        let residue: Vec<f64> = (0..90).map(|n| f64::from(n / 6)).collect();
        for columns in [&[][..], &[("residue", &residue[..])]] {
            let mut p = cut(&whole, columns);
            let listed = p.positions.clone();
            apply(Periodic::Unwrap, &mut p).expect("bonds");
            assert!(p.skipped.assumed.is_empty(), "{:?}", p.skipped.assumed);
            let mut first = 0;
            for chain in &whole {
                // The first atom stays, and the others are where they are from it. Each move is rounded once, 2^-50 of 100.
                let moved = DVec3::from_array(listed[first]) - DVec3::from_array(chain[0]);
                for (n, place) in chain.iter().enumerate() {
                    let error =
                        (DVec3::from_array(p.positions[first + n]) - DVec3::from_array(*place) - moved).length();
                    assert!(error < 1e-12, "atom {n} is off by {error}");
                }
                first += chain.len();
            }
        }
        // Without elements, each residue is whole by itself, which is said.
        let mut p = cut(&whole, &[("residue", &residue)]);
        p.elements.clear();
        apply(Periodic::Unwrap, &mut p).expect("residues");
        assert!(p.skipped.assumed[0].contains("chains of them may stay cut"), "{:?}", p.skipped.assumed);
        let steps = p.positions.windows(2).map(|two| (DVec3::from(two[1]) - DVec3::from(two[0])).length());
        assert!(steps.filter(|length| *length > 1.6).count() > 3, "cut between residues");
    }

    /// Parts of a residue without a bond between them stay together, with all that is bonded to them.
    #[test]
    fn what_has_no_bond_follows_its_residue() {
        let chain = chain([3.0, 4.0, 5.0], &[[0.8, 0.6, 0.0], [0.0, 0.6, 0.8]], 40);
        // Beyond every bond of the last atom of the chain.
        let ligand = chain[39].map(|x| x + 2.0);
        let mut whole = chain.clone();
        whole.push(ligand);
        let residue: Vec<f64> = (0..41).map(|n| f64::from(n / 8)).collect();
        let last: Vec<f64> = residue.iter().enumerate().map(|(n, r)| if n >= 39 { 9.0 } else { *r }).collect();
        let mut p = cut(&[whole.clone()], &[("residue", &last)]);
        apply(Periodic::Unwrap, &mut p).expect("bonds");
        let step = DVec3::from_array(p.positions[40]) - DVec3::from_array(p.positions[39]);
        assert!((step - DVec3::splat(2.0)).length() < 1e-12, "{step}");
        // Ions and waters are bonded to nothing, however near.
        let mut p = cut(&[whole], &[("residue", &residue)]);
        p.elements = vec![11; 41];
        let listed = p.positions.clone();
        apply(Periodic::Unwrap, &mut p).expect("residues");
        assert_eq!(p.positions[8], listed[8], "the first of a residue stays");
    }

    /// Two chains of a protein that touch across a face are one picture; what is no protein stays.
    #[test]
    fn chains_of_a_protein_that_touch_come_together() {
        let first = chain([17.0, 5.0, 5.0], &[[0.0, 1.0, 0.0]], 6);
        // 3.5 beside it, across the face at the end of the first edge.
        let second = chain([20.5, 5.0, 5.0], &[[0.0, 1.0, 0.0]], 6);
        for (name, are_together) in [("ALA", true), ("POPC", false)] {
            let mut p = cut(&[first.clone(), second.clone()], &[("resname", &[0.0; 12])]);
            p.labels.insert("resname".into(), vec![name.into()]);
            // One group would join them too.
            p.columns.push(Column { name: "resid".into(), values: (0..12).map(f64::from).collect() });
            apply(Periodic::Unwrap, &mut p).expect("bonds");
            let apart = (DVec3::from_array(p.positions[6]) - DVec3::from_array(p.positions[0])).length();
            assert_eq!((apart - 3.5).abs() < 1e-12, are_together, "{name}: {apart}");
        }
    }

    /// A chain from one face to the opposite one has no end, and stays as it is; another one is made whole beside it.
    #[test]
    fn a_molecule_that_is_bonded_to_its_own_image_is_reported() {
        let endless: Vec<[f64; 3]> = (0..14).map(|n| [f64::from(n) * 20.0 / 14.0, 3.0, 2.0]).collect();
        let other = chain([18.0, 15.0, 9.0], &[[1.0, 0.0, 0.0]], 8);
        let mut p = cut(&[endless, other], &[]);
        let listed = p.positions.clone();
        apply(Periodic::Unwrap, &mut p).expect("bonds");
        assert_eq!(p.positions[..14], listed[..14]);
        assert_ne!(p.positions[14..], listed[14..]);
        let warnings = &p.skipped.assumed;
        assert!(warnings.len() == 1 && warnings[0].contains("1 molecule is bonded to an own image"), "{warnings:?}");
        assert!(warnings[0].contains("14 particles, from particle 0 on"), "{warnings:?}");
    }

    /// Atoms without room are refused before all their pairs are listed, and atoms of a small part of a large cell are joined as fast as
    /// others. All pairs of both would be some 10^8.
    #[test]
    fn the_time_of_bonds_is_that_of_atoms() {
        let cube = |edge: f64| Cell { origin: [0.0; 3], edges: [[edge, 0.0, 0.0], [0.0, edge, 0.0], [0.0, 0.0, edge]] };
        let of = |places: Vec<[f64; 3]>, edge: f64| {
            let mut p = Particles { positions: places, cell: Some(cube(edge)), ..Particles::default() };
            p.elements = vec![6; p.positions.len()];
            apply(Periodic::Unwrap, &mut p).map(|()| p.positions)
        };
        let crowd = (0..10_000).map(|n| [f64::from(n % 100) / 100.0, f64::from(n / 100) / 100.0, 0.5]).collect();
        let error = of(crowd, 100.0).expect_err("a crowd").to_string();
        assert!(error.contains("up to 10000 atoms lie within 1.8 of each other, too many"), "{error}");
        // Rods of 8 atoms 1.5 apart, across a face of a cell of 10^7.
        let rods = |n: u32| [f64::from(n % 8) * 1.5 - 4.0, f64::from(n / 8 % 70) * 5.0, f64::from(n / 560) * 5.0];
        let whole: Vec<[f64; 3]> = (0..9_800).map(rods).collect();
        let cell = cube(1e7);
        let frame = Edges::of(&cell).expect("a volume");
        let found = of(whole.iter().map(|place| frame.wrapped(*place)).collect(), 1e7).expect("bonds");
        for (n, (place, found)) in whole.iter().zip(&found).enumerate() {
            // The first atom of each stays on its side.
            assert!((place[0] + 1e7 - found[0]).abs() < 1e-8 && place[1..] == found[1..], "{n}: {place:?} {found:?}");
        }
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
