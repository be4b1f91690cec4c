//! A row of `_atom_site`: the meaning of its columns, and the values of an atom.

use super::symmetry::Symmetry;
use super::tokens::{Token, Tokens, number};
use crate::read::lines::Spot;
use crate::read::particles::atom_property::{AtomProperty, NameTable};
use crate::read::particles::infer::AtomNames;
use crate::read::particles::layout::is_wanted;
use crate::read::particles::molecule::Model;
use crate::read::particles::request::{Altloc, Request};
use halfline::error::{Error, Place, Result};
use halfline::quote::quote;

/// The meaning of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    Symbol,
    /// The atom's name.
    Name,
    /// The residue's name.
    Residue,
    /// Part of what distinguishes residues.
    ResidueNumber,
    Location,
    Model,
    Position(usize),
    /// A number that colours and selections use.
    Number(AtomProperty),
    /// A name that they use.
    Text(AtomProperty),
    /// The file's own chain, which assemblies refer to.
    Asym,
    /// Part of what distinguishes sites.
    Site,
    /// How the position was determined; `dum` marks a dummy atom.
    Origin,
}

/// The columns of the atoms.
#[derive(Debug, Clone, Default)]
pub(super) struct AtomColumns {
    uses: Vec<Vec<Use>>,
    has: Vec<AtomProperty>,
    fractional: bool,
    one: bool,
}

impl AtomColumns {
    /// Whether a tag in lower case belongs to atoms; small-molecule files write `_atom_site_label`.
    pub(super) fn is_atom(tag: &str) -> bool {
        item(tag).is_some()
    }

    /// The layout of these tags, in lower case.
    pub(super) fn of(tags: &[String], request: &Request) -> Self {
        let items: Vec<&str> = tags.iter().map(|tag| item(tag).unwrap_or_default()).collect();
        // The first of these names that occurs.
        let column = |names: &[&str]| names.iter().find_map(|name| items.iter().position(|item| item == name));
        let mut layout = Self { uses: vec![Vec::new(); items.len()], ..Self::default() };
        let highest = request.altloc == Altloc::Highest;
        let columns: [(AtomProperty, &[&str]); 14] = [
            (AtomProperty::Bfactor, &["b_iso_or_equiv"]),
            (AtomProperty::Occupancy, &["occupancy"]),
            (AtomProperty::Residue, &["auth_seq_id", "label_seq_id"]),
            (AtomProperty::Serial, &["id"]),
            (AtomProperty::Chain, &["auth_asym_id", "label_asym_id"]),
            (AtomProperty::Asym, &["label_asym_id", "auth_asym_id"]),
            (AtomProperty::Entity, &["label_entity_id"]),
            (AtomProperty::Model, &["pdbx_pdb_model_num"]),
            (AtomProperty::Name, &["auth_atom_id", "label_atom_id", "label"]),
            (AtomProperty::Resname, &["auth_comp_id", "label_comp_id"]),
            (AtomProperty::Segid, &["auth_asym_id", "label_asym_id"]),
            (AtomProperty::Altloc, &["label_alt_id"]),
            (AtomProperty::Icode, &["pdbx_pdb_ins_code"]),
            (AtomProperty::Record, &["group_pdb"]),
        ];
        for (kind, names) in columns {
            let Some(at) = column(names) else { continue };
            layout.has.push(kind);
            let (wanted, sites) =
                (is_wanted(&request.columns, kind.name()), highest && kind == AtomProperty::Occupancy);
            match kind {
                AtomProperty::Model => layout.uses[at].push(Use::Model),
                AtomProperty::Asym if wanted || request.assembly.is_some() => layout.uses[at].push(Use::Asym),
                AtomProperty::Asym => {}
                kind if wanted && kind.is_text() => layout.uses[at].push(Use::Text(kind)),
                kind if !kind.is_text() && (wanted || sites) => layout.uses[at].push(Use::Number(kind)),
                _ => {}
            }
        }
        let cartesian = ["cartn_x", "cartn_y", "cartn_z"];
        layout.fractional = !cartesian.iter().all(|name| items.contains(name));
        let places = if layout.fractional { ["fract_x", "fract_y", "fract_z"] } else { cartesian };
        for (k, name) in places.iter().enumerate() {
            if let Some(at) = column(&[name]) {
                layout.uses[at].push(Use::Position(k));
            }
        }
        let symbol = column(&["type_symbol"]);
        let texts = [
            (symbol, Use::Symbol),
            (column(&["label_atom_id", "auth_atom_id", "label"]), Use::Name),
            (column(&["label_comp_id", "auth_comp_id"]), Use::Residue),
            // Residues matter only where elements are inferred.
            (column(&["label_asym_id", "auth_asym_id"]).filter(|_| symbol.is_none()), Use::ResidueNumber),
            (column(&["label_seq_id"]).filter(|_| symbol.is_none()), Use::ResidueNumber),
            (column(&["auth_seq_id"]).filter(|_| symbol.is_none()), Use::ResidueNumber),
            (column(&["pdbx_pdb_ins_code"]).filter(|_| symbol.is_none()), Use::ResidueNumber),
            (column(&["label_alt_id"]), Use::Location),
            (column(&["calc_flag"]), Use::Origin),
        ];
        let sites =
            ["label_asym_id", "auth_asym_id", "label_seq_id", "auth_seq_id", "pdbx_pdb_ins_code", "label_atom_id"];
        let sites = sites.iter().filter(|_| highest).map(|name| (column(&[name]), Use::Site));
        for (at, what) in texts.into_iter().chain(sites) {
            if let Some(at) = at {
                layout.uses[at].push(what);
            }
        }
        layout
    }

    /// Whether all three coordinates are present.
    pub(super) fn is_placed(&self) -> bool {
        (0..3).all(|k| self.uses.iter().flatten().any(|kind| *kind == Use::Position(k)))
    }

    pub(super) fn is_fractional(&self) -> bool {
        self.fractional
    }

    /// The same for a single atom without a row.
    pub(super) fn of_one(self) -> Self {
        Self { one: true, ..self }
    }

    pub(super) fn is_of_one(&self) -> bool {
        self.one
    }

    /// The numeric columns of the file; symmetry copies of a small molecule are numbered.
    pub(super) fn has(&self) -> Vec<AtomProperty> {
        self.has.iter().copied().chain(self.fractional.then_some(AtomProperty::Copy)).collect()
    }
}

fn item(tag: &str) -> Option<&str> {
    tag.strip_prefix("_atom_site").and_then(|rest| rest.strip_prefix(['.', '_']))
}

/// The values of an atom, with text in reused buffers.
#[derive(Debug, Clone, Default)]
pub(super) struct AtomRow {
    /// The model's number.
    pub(super) model: i64,
    symbol: Vec<u8>,
    name: Vec<u8>,
    residue: Vec<u8>,
    /// What distinguishes the residue.
    number: Vec<u8>,
    location: Vec<u8>,
    site: Vec<u8>,
    position: [f64; 3],
    /// By [`AtomProperty`].
    numbers: [f64; AtomProperty::ALL.len()],
    asym: u32,
    /// Whether this is a dummy atom.
    dummy: bool,
    /// Whether it belongs to a small molecule.
    small: bool,
}

impl AtomRow {
    /// Reads the next row; false at the end of the loop.
    pub(super) fn read(&mut self, tokens: &mut Tokens, layout: &AtomColumns, names: &mut NameTable) -> Result<bool> {
        self.clear();
        self.small = layout.fractional;
        for (k, uses) in layout.uses.iter().enumerate() {
            match tokens.next()? {
                Token::Value => {}
                token if k == 0 => {
                    tokens.give_back(token);
                    return Ok(false);
                }
                _ => {
                    let problem = format!("the row of this atom ends after {k} of {} values", layout.uses.len());
                    return Err(Error::scene(tokens.place().named("_atom_site"), problem, "use one value per column"));
                }
            }
            for kind in uses {
                self.take(*kind, tokens.value(), names, || tokens.place())?;
            }
        }
        Ok(true)
    }

    /// Reads an atom whose values are not in a loop.
    pub(super) fn single(
        &mut self,
        layout: &AtomColumns,
        values: &[(Vec<u8>, Spot)],
        names: &mut NameTable,
        file: &Place,
    ) -> Result<()> {
        self.clear();
        self.small = layout.fractional;
        for (uses, (value, spot)) in layout.uses.iter().zip(values) {
            for kind in uses {
                self.take(*kind, value, names, || spot.of(file.clone()))?;
            }
        }
        Ok(())
    }

    fn clear(&mut self) {
        let names = [&mut self.symbol, &mut self.name, &mut self.residue, &mut self.number];
        names.into_iter().chain([&mut self.location, &mut self.site]).for_each(Vec::clear);
        (self.model, self.asym, self.dummy) = (1, 0, false);
        self.numbers = [f64::NAN; AtomProperty::ALL.len()];
    }

    fn take(&mut self, kind: Use, value: &[u8], names: &mut NameTable, place: impl Fn() -> Place) -> Result<()> {
        match kind {
            Use::Symbol => self.symbol.extend(value),
            Use::Name => self.name.extend(value),
            Use::Residue => self.residue.extend(value),
            Use::ResidueNumber => {
                self.number.extend(value);
                self.number.push(0);
            }
            Use::Location => self.location.extend(value),
            Use::Site => {
                self.site.extend(value);
                self.site.push(0);
            }
            Use::Origin => self.dummy = value.eq_ignore_ascii_case(b"dum"),
            Use::Model => {
                let number = std::str::from_utf8(value).ok().and_then(|text| text.parse().ok());
                self.model = match number {
                    Some(number) => number,
                    None if value.is_empty() => 1,
                    None => return Err(bad_model(value, place())),
                };
            }
            Use::Position(k) => {
                self.position[k] = match number(value) {
                    Some(x) => x,
                    None => return Err(bad_place(k, value, place())),
                };
            }
            Use::Number(kind) => self.numbers[kind as usize] = number(value).unwrap_or(f64::NAN),
            Use::Text(kind) => self.numbers[kind as usize] = names.number(kind, value)?,
            Use::Asym => {
                let number = names.number(AtomProperty::Asym, value)?;
                self.numbers[AtomProperty::Asym as usize] = number;
                self.asym = number as u32;
            }
        }
        Ok(())
    }

    /// Adds the atom to a model, with fractional positions as they are. Without a symbol, the element is inferred from
    /// the label of a small molecule's atom.
    pub(super) fn give(&self, model: &mut Model, symmetry: &Symmetry) -> Result<()> {
        let occupancy = self.numbers[AtomProperty::Occupancy as usize];
        // Without an occupancy, an atom is present.
        let occupancy = if occupancy.is_nan() { 1.0 } else { occupancy };
        if !model.admits(&self.location, occupancy, |key| key.extend(&self.site))? {
            return Ok(());
        }
        let mut atom = AtomNames { symbol: &self.symbol, name: &self.name, residue: &self.residue, site: &self.number };
        if self.dummy {
            atom = AtomNames { symbol: b"", name: b"DUM", ..atom };
        } else if self.symbol.is_empty() && self.small {
            atom.symbol = symmetry.symbol(&self.name);
        }
        model.push(&atom, self.position, self.asym, |kind| {
            Ok(match kind {
                AtomProperty::Occupancy => occupancy,
                AtomProperty::Model => self.model as f64,
                AtomProperty::Copy => 0.0,
                kind => self.numbers[kind as usize],
            })
        })
    }
}

fn bad_place(axis: usize, value: &[u8], place: Place) -> Error {
    let problem = match value {
        [] => "the atom has no position".to_owned(),
        word => format!("expected a finite number, found {}", quote(word)),
    };
    Error::scene(place.named(["x", "y", "z"][axis]), problem, "use a finite number such as -12.345")
}

fn bad_model(value: &[u8], place: Place) -> Error {
    let problem = format!("{} is not a model number", quote(value));
    Error::scene(place.named("pdbx_PDB_model_num"), problem, "use a whole number")
}
