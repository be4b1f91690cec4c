//! The symmetry of small-molecule CIF: the images of the listed atoms under the operators, in one unit cell (IUCr core
//! dictionary, `_space_group_symop_operation_xyz`; Hahn, International Tables for Crystallography A).

mod groups;
mod hall;

use super::token::number;
use super::tokens::Tokens;
use crate::elements::atomic_number;
use crate::lines::Spot;
use crate::particles::frame::{Column, Particles};
use halfline_ground::Cell;
use halfline_ground::Operator;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::{check, check_spheres};
use halfline_ground::parallel;
use halfline_ground::progress::Watch;
use halfline_ground::quote::setting::AS_LISTED;
use halfline_ground::quote::{quote, unquoted};
use std::collections::HashSet;
use std::ops::Range;

/// Two images of one atom closer than this, ångström, are one atom on a special position whose coordinates are rounded
/// (0.333 for 1/3) or refined slightly beside it. It is half the shortest distance between nuclei, the bond of H2,
/// 0.74, so two atoms are never that close.
const SAME: f64 = 0.37;

/// The most operators of a space group in its conventional cell (International Tables A, F m -3 m).
const MOST: usize = 192;

/// The remedy for a space group without operators.
const MEND: &str = "add _space_group_symop_operation_xyz, or fill the cell with `ase convert in.cif out.extxyz`";

/// The message where a block has neither operators nor a group.
const NO_SYMMETRY: &str = "the file has no symmetry, so the atoms are shown as listed; name its space group (_space_group_name_H-M_alt), or \
    add _space_group_symop_operation_xyz";

/// Atoms between two checks for cancellation.
const PART: usize = 1 << 10;

/// A value that is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SymmetryItem {
    /// An operator as `x,1/2-y,z`, and of a magnetic group, whose translations are listed apart.
    Operator,
    Magnetic,
    Centering,
    /// The symbol of a magnetic group, or an operator of superspace, which are not applied.
    MagneticName,
    Superspace,
    /// The space group's symbols by Hall, and by Hermann and Mauguin, and its number in International Tables A.
    Hall,
    Name,
    Number,
    /// The elements of the block, as a formula or one by one.
    Elements,
}

impl SymmetryItem {
    /// The item of a tag in lower case.
    pub(super) fn of(tag: &str) -> Option<Self> {
        match tag {
            "_symmetry_equiv_pos_as_xyz"
            | "_space_group_symop_operation_xyz"
            | "_space_group_symop.operation_xyz"
            | "_symmetry_equiv.pos_as_xyz" => Some(Self::Operator),
            "_space_group_symop_magn_operation.xyz"
            | "_space_group_symop_magn_operation_xyz"
            | "_space_group_symop.magn_operation_xyz"
            | "_space_group_symop_magn.operation_xyz" => Some(Self::Magnetic),
            "_space_group_symop_magn_centering.xyz"
            | "_space_group_symop_magn_centering_xyz"
            | "_space_group_symop.magn_centering_xyz"
            | "_space_group_symop_magn.centering_xyz" => Some(Self::Centering),
            "_space_group_magn.name_bns"
            | "_space_group_magn_name_bns"
            | "_space_group.magn_name_bns"
            | "_space_group_magn.number_bns"
            | "_space_group_magn_number_bns"
            | "_space_group.magn_number_bns"
            | "_space_group_magn.name_og"
            | "_space_group_magn.number_og" => Some(Self::MagneticName),
            "_space_group_symop_ssg_operation_algebraic"
            | "_space_group_symop_ssg.operation_algebraic"
            | "_space_group_symop_magn_ssg_operation.algebraic"
            | "_space_group_symop.ssg_operation_algebraic" => Some(Self::Superspace),
            "_symmetry_space_group_name_h-m"
            | "_space_group_name_h-m_alt"
            | "_space_group_name_h-m_ref"
            | "_space_group_name_h-m"
            | "_space_group.name_h-m_alt"
            | "_symmetry.space_group_name_h-m" => Some(Self::Name),
            "_symmetry_space_group_name_hall"
            | "_space_group_name_hall"
            | "_space_group.name_hall"
            | "_symmetry.space_group_name_hall" => Some(Self::Hall),
            "_symmetry_int_tables_number"
            | "_space_group_it_number"
            | "_space_group.it_number"
            | "_symmetry.int_tables_number" => Some(Self::Number),
            "_chemical_formula_sum" | "_chemical_formula.sum" | "_atom_type_symbol" | "_atom_type.symbol" => {
                Some(Self::Elements)
            }
            _ => None,
        }
    }
}

/// The symmetry data of a block.
#[derive(Debug, Clone, Default)]
pub(super) struct Symmetry {
    operators: Vec<(String, Spot)>,
    /// Of a magnetic group: the operators, and the translations of its lattice.
    magnetic: [Vec<(String, Spot)>; 2],
    magnetic_name: String,
    /// Whether operators of superspace are listed.
    superspace: bool,
    hall: String,
    name: String,
    number: Option<f64>,
    /// By atomic number, the elements that the block lists.
    elements: Vec<u8>,
}

impl Symmetry {
    /// Stores the current value.
    ///
    /// # Errors
    /// As [`Tokens::string`].
    pub(super) fn take(&mut self, item: SymmetryItem, tokens: &Tokens) -> Result<()> {
        match item {
            SymmetryItem::Operator | SymmetryItem::Magnetic | SymmetryItem::Centering => {
                let list = match item {
                    SymmetryItem::Operator => &mut self.operators,
                    item => &mut self.magnetic[usize::from(item == SymmetryItem::Centering)],
                };
                // One more than allowed, so that the excess is an error when they are used.
                if list.len() <= MOST && !tokens.value().is_empty() {
                    list.push((tokens.string()?, tokens.spot()));
                }
            }
            SymmetryItem::MagneticName => self.magnetic_name = tokens.string()?,
            SymmetryItem::Superspace => self.superspace = true,
            SymmetryItem::Hall => self.hall = tokens.string()?,
            SymmetryItem::Name => self.name = tokens.string()?,
            SymmetryItem::Number => self.number = number(tokens.value()),
            SymmetryItem::Elements => {
                let text = tokens.string()?;
                let symbols = text.split(|c: char| !c.is_ascii_alphabetic()).map(atomic_number);
                let new: Vec<u8> = symbols.filter(|number| *number > 0 && !self.elements.contains(number)).collect();
                self.elements.extend(new);
            }
        }
        Ok(())
    }

    /// The symbol at the beginning of an atom's label (`Fe1`, `O2W`). Where both one and two letters are symbols, two
    /// are taken if the block lists that element or if they are written as in the periodic table.
    pub(super) fn symbol<'a>(&self, label: &'a [u8]) -> &'a [u8] {
        let letters = label.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let number = |length: usize| std::str::from_utf8(&label[..length]).map_or(0, atomic_number);
        let (one, two) = (if letters > 0 { number(1) } else { 0 }, if letters > 1 { number(2) } else { 0 });
        let there = |number: u8| number > 0 && self.elements.contains(&number);
        let written = letters > 1 && label[1].is_ascii_lowercase();
        // Water whose hydrogens are not listed.
        if label.get(..3).is_some_and(|start| start.eq_ignore_ascii_case(b"wat")) {
            return b"O";
        }
        let length = match (there(one), there(two)) {
            (true, true) => 1 + usize::from(written || label.len() == 2),
            (true, false) => 1,
            (false, true) => 2,
            (false, false) if two > 0 && (written || one == 0) => 2,
            (false, false) => usize::from(one > 0),
        };
        &label[..length]
    }

    /// The operators of the block, the identity first. Of a magnetic group each operator moves an atom as without its moment, and each
    /// translation of the lattice, also one that turns moments, makes another of each.
    ///
    /// # Errors
    /// [`Error::Scene`] for invalid operators, and for more than a space group can have.
    fn operators(&self, file: &Place) -> Result<Vec<Operator>> {
        let [magnetic, centering] = &self.magnetic;
        let listed = if self.operators.is_empty() { magnetic } else { &self.operators };
        let mut found = Self::parsed(listed, file)?;
        if self.operators.is_empty() {
            for translation in Self::parsed(centering, file)? {
                for operator in found.clone() {
                    let mut moved = translation.after(&operator);
                    moved.0.iter_mut().for_each(|row| row[3] = wrap(row[3]));
                    if !found.contains(&moved) {
                        found.push(moved);
                    }
                }
                if found.len() > 2 * MOST {
                    let problem =
                        format!("more than {} operators and translations, which no magnetic group has", 2 * MOST);
                    let mend = format!("list each once, or use {AS_LISTED} to show the atoms as listed");
                    return Err(Error::scene(file.clone().named("symmetry"), problem, mend));
                }
            }
        }
        if let Some(at) = found.iter().position(|operator| *operator == IDENTITY) {
            found[..=at].rotate_right(1);
        } else if !found.is_empty() {
            found.insert(0, IDENTITY);
        }
        Ok(found)
    }

    /// Different operators of a list.
    fn parsed(list: &[(String, Spot)], file: &Place) -> Result<Vec<Operator>> {
        if let Some((_, spot)) = list.get(MOST) {
            let place = spot.of(file.clone()).named("symmetry");
            let problem = format!("more than {MOST} symmetry operators, which no space group has");
            return Err(Error::scene(
                place,
                problem,
                format!("list each operator once, or use {AS_LISTED} to show the atoms as listed"),
            ));
        }
        let mut found = Vec::new();
        for (text, spot) in list {
            let operator = parse(text).filter(is_isometry).ok_or_else(|| {
                let problem = format!("{} is not a symmetry operator", quote(text));
                Error::scene(spot.of(file.clone()).named("symmetry"), problem, "use an operator such as x,1/2-y,z+1/2")
            })?;
            if !found.contains(&operator) {
                found.push(operator);
            }
        }
        Ok(found)
    }

    /// Turns fractional coordinates into positions, and makes the images of each atom under the operators, wrapped into
    /// the cell and without duplicates: operator by operator, and for each the atoms in the file's order. A column
    /// `copy` gives the operator, from 0. Where the block has only the identity, or symmetry is not wanted, atoms stay
    /// at the listed positions. Messages are added to the assumptions.
    ///
    /// # Errors
    /// As [`Symmetry::operators`]; [`Error::Limits`] for more atoms than memory holds, [`Error::Interrupted`].
    pub(super) fn fill(
        &self,
        mut listed: Particles,
        cell: &Cell,
        is_requested: bool,
        file: &Place,
        watch: &Watch,
    ) -> Result<Particles> {
        let atoms = listed.positions.len();
        // A hash table of them has twice as many slots as entries.
        check(2 * (size_of::<[u64; 3]>() as u64 + 1) * atoms as u64, || format!("the places of {atoms} atoms"))?;
        let mut operators = if is_requested { self.operators(file)? } else { Vec::new() };
        if is_requested && operators.is_empty() && self.is_named() {
            match groups::find(&self.hall, &self.name, self.number, cell) {
                Ok(group) => {
                    listed.skipped.assumed.extend(group.note());
                    operators = group.operators;
                }
                Err(reason) => listed.skipped.assumed.push(self.unknown(reason)),
            }
        }
        let mut taken = HashSet::new();
        let first = |place: &&[f64; 3]| taken.insert(place.map(|x| wrap(x).to_bits()));
        let shared = atoms - listed.positions.iter().filter(first).count();
        if shared > 0 {
            let warning = format!(
                "{shared} atoms have the position of another (mixed occupancy), so only the larger sphere is visible"
            );
            listed.skipped.assumed.push(warning);
        }
        if operators.len() < 2 {
            parallel::each(&mut listed.positions, |_, position| *position = cell.place(*position));
            if is_requested && operators.is_empty() && !self.is_named() {
                listed.skipped.assumed.push(self.without());
            }
            return Ok(listed);
        }
        let total = (operators.len() as u64).saturating_mul(atoms as u64);
        check_spheres(total, true)?;
        let each =
            2 * size_of::<Image>() + size_of::<[f64; 3]>() + size_of::<u8>() + listed.columns.len() * size_of::<f64>();
        check(total.saturating_mul(each as u64), || format!("the {total} atoms that symmetry may make"))?;
        let part = |atoms: Range<usize>| {
            watch.check()?;
            Ok(atoms.flat_map(|n| images(&operators, listed.positions[n], cell, n)).collect())
        };
        let mut places: Vec<Image> = parallel::try_collect(atoms, PART, &part)?;
        parallel::sort(&mut places, |a, b| (a.operator, a.atom).cmp(&(b.operator, b.atom)));
        let mut whole = Particles { has: listed.has, labels: listed.labels, ..Particles::default() };
        whole.positions = places.iter().map(|image| cell.place(image.position)).collect();
        whole.elements = places.iter().map(|image| listed.elements[image.atom]).collect();
        for column in &listed.columns {
            let values = match &column.name[..] {
                "copy" => places.iter().map(|image| image.operator as f64).collect(),
                _ => places.iter().map(|image| column.values[image.atom]).collect(),
            };
            whole.columns.push(Column { name: column.name.clone(), values });
        }
        whole.skipped = listed.skipped;
        let count = operators.len();
        let name = if self.name.is_empty() { String::new() } else { format!(" of {}", unquoted(&self.name)) };
        whole.skipped.assumed.push(format!(
            "{count} operators{name} make {} atoms in the cell from the {atoms} in the file; use {AS_LISTED} to show only those",
            places.len()
        ));
        Ok(whole)
    }

    /// The message where a block has no operators and no group that could give them.
    fn without(&self) -> String {
        let what = match (self.superspace, &self.magnetic_name[..]) {
            (true, _) => "the file lists operators of superspace".to_owned(),
            (false, "") => return NO_SYMMETRY.to_owned(),
            (false, name) => format!("the file has the magnetic group {} but lists no operators", unquoted(name)),
        };
        format!("{what}, which are not applied, so the atoms are shown as listed; {MEND}")
    }

    /// Whether the block names its space group.
    fn is_named(&self) -> bool {
        !self.hall.is_empty() || !self.name.is_empty() || self.number.is_some()
    }

    /// The message where a block lists no operators, and its group does not give them.
    fn unknown(&self, reason: &str) -> String {
        let group = match [&self.hall, &self.name].into_iter().find(|name| !name.is_empty()) {
            Some(name) => unquoted(name).to_string(),
            None => self.number.unwrap_or_default().to_string(),
        };
        format!(
            "the file has space group {group} but lists no operators, and {reason}, so the atoms are shown as listed; {MEND}"
        )
    }
}

/// One of an atom's images, in fractional coordinates.
struct Image {
    operator: usize,
    atom: usize,
    position: [f64; 3],
}

const IDENTITY: Operator = Operator([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

/// The images of an atom, without duplicates.
fn images(operators: &[Operator], position: [f64; 3], cell: &Cell, atom: usize) -> Vec<Image> {
    let mut found: Vec<Image> = Vec::new();
    for (operator, moved) in operators.iter().enumerate() {
        let position = moved.apply(position).map(wrap);
        if !found.iter().any(|image| apart(image.position, position, cell) < SAME) {
            found.push(Image { operator, atom, position });
        }
    }
    found
}

/// The fractional part of a number, in [0, 1).
fn wrap(x: f64) -> f64 {
    let part = x - x.floor();
    // Just below a whole number, the difference rounds to 1.
    if part < 1.0 { part } else { 0.0 }
}

/// The distance of two positions, ångström, to the nearest periodic image.
fn apart(a: [f64; 3], b: [f64; 3], cell: &Cell) -> f64 {
    let between = [0, 1, 2].map(|k| {
        let x = a[k] - b[k];
        x - x.round()
    });
    let along = |k: usize| (0..3).map(|edge| between[edge] * cell.edges[edge][k]).sum::<f64>();
    [0, 1, 2].map(along).iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Whether the operator preserves volume: a rotation, optionally with an inversion, in fractional coordinates.
fn is_isometry(Operator([a, b, c]): &Operator) -> bool {
    let determinant =
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    determinant.abs() == 1.0
}

/// Parses an operator such as `-x+y, 1/2-z, .25+x`: for each coordinate a sum of x, y, z and fractions, in any order.
fn parse(text: &str) -> Option<Operator> {
    let mut rows = [[0.0; 4]; 3];
    let bare: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let mut sums = bare.split(',');
    for row in &mut rows {
        let mut rest = sums.next()?;
        if rest.is_empty() {
            return None;
        }
        while !rest.is_empty() {
            let sign = if rest.starts_with('-') { -1.0 } else { 1.0 };
            rest = rest.strip_prefix(['+', '-']).unwrap_or(rest);
            let end = rest.find(['+', '-']).unwrap_or(rest.len());
            let (column, value) = term(&rest[..end])?;
            row[column] += sign * value;
            rest = &rest[end..];
        }
    }
    // A fourth coordinate is the time reversal of magnetic groups.
    let time = sums.next().is_none_or(|time| ["+1", "1", "-1"].contains(&time));
    (time && sums.next().is_none()).then_some(Operator(rows))
}

/// A summand: its column, where the fourth is the translation, and its factor.
fn term(text: &str) -> Option<(usize, f64)> {
    let axis = |c: char| ['x', 'y', 'z'].iter().position(|axis| c.eq_ignore_ascii_case(axis));
    let value = |text: &str| {
        let (above, below) = text.split_once('/').unwrap_or((text, "1"));
        let plain = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
        let value = above.parse::<f64>().ok()? / below.parse::<f64>().ok()?;
        (plain(above) && plain(below) && value.is_finite()).then_some(value)
    };
    let last = text.chars().next_back()?;
    match axis(last) {
        Some(column) => {
            let factor = text[..text.len() - 1].trim_end_matches('*');
            Some((column, if factor.is_empty() { 1.0 } else { value(factor)? }))
        }
        None => Some((3, value(text)?)),
    }
}

#[cfg(test)]
mod tests;
