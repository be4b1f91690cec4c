//! A row of `_atom_site`: the meaning of its columns, and the values of an atom.

use super::symmetry::Symmetry;
use super::token::{Token, Want, number};
use super::tokens::Tokens;
use crate::lines::{Spot, mend_number};
use crate::particles::atom_property::{AtomProperty, NameTable};
use crate::particles::infer::AtomNames;
use crate::particles::layout::is_requested;
use crate::particles::molecule::Model;
use crate::particles::request::{Altloc, Request};
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::quote;

/// The meaning of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    Symbol,
    /// The atom's name.
    Name,
    /// The residue's name.
    Residue,
    /// A part of the key that distinguishes residues.
    ResidueNumber,
    Location,
    Model,
    Position(usize),
    /// A coordinate of a component's idealised geometry.
    Ideal(usize),
    /// A number that colours and selections use.
    Number(AtomProperty),
    /// A name that they use.
    Text(AtomProperty),
    /// The file's own chain, which assemblies refer to.
    Asym,
    /// A part of the key that alternate locations of an atom share.
    Site,
    /// The flag of the position's origin, calculated or measured; `dum` marks a dummy atom.
    Origin,
}

impl Use {
    /// Whether a number is all that is needed.
    fn is_number(self) -> bool {
        matches!(self, Self::Position(_) | Self::Ideal(_) | Self::Number(_))
    }
}

/// The columns of the atoms.
#[derive(Debug, Clone, Default)]
pub(super) struct AtomColumns {
    uses: Vec<Vec<Use>>,
    has: Vec<AtomProperty>,
    fractional: bool,
    one: bool,
    /// Whether they are of the atoms of a chemical component, and whether its idealised positions are taken.
    component: bool,
    ideal: bool,
}

impl AtomColumns {
    /// Whether a tag in lower case belongs to atoms; small-molecule files write `_atom_site_label`.
    pub(super) fn is_atom(tag: &str) -> bool {
        tag.strip_prefix("_atom_site").is_some_and(|rest| rest.starts_with(['.', '_']))
    }

    /// Whether a tag in lower case belongs to the atoms of a chemical component.
    pub(super) fn is_component(tag: &str) -> bool {
        tag.starts_with(COMPONENT)
    }

    /// The layout of these tags, in lower case.
    pub(super) fn of(tags: &[String], request: &Request) -> Self {
        let items: Vec<&str> = tags.iter().map(|tag| item(tag).unwrap_or_default()).collect();
        // The first of these names that occurs.
        let column = |names: &[&str]| names.iter().find_map(|name| items.iter().position(|item| item == name));
        let component = tags.first().is_some_and(|tag| Self::is_component(tag));
        let mut layout = Self { uses: vec![Vec::new(); items.len()], component, ..Self::default() };
        layout.take_properties(&column, request);
        let cartesian = ["cartn_x", "cartn_y", "cartn_z"];
        layout.fractional = !component && !cartesian.iter().all(|name| items.contains(name));
        let places = if layout.fractional { ["fract_x", "fract_y", "fract_z"] } else { cartesian };
        for (k, (name, ideal)) in places.into_iter().zip(["ideal_x", "ideal_y", "ideal_z"]).enumerate() {
            layout.take(column(&[name]), Use::Position(k));
            layout.take(column(&[ideal]), Use::Ideal(k));
        }
        layout.ideal = !layout.has_all(Use::Position) && layout.has_all(Use::Ideal);
        layout.take_names(&column, request);
        layout
    }

    /// Gives a column a meaning, if the file has it.
    fn take(&mut self, column: Option<usize>, what: Use) {
        if let Some(column) = column {
            self.uses[column].push(what);
        }
    }

    /// The properties of atoms that colours, selections and assemblies need; `column` finds the first of some names.
    fn take_properties(&mut self, column: &impl Fn(&[&str]) -> Option<usize>, request: &Request) {
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
            let found = column(names);
            self.has.extend(found.map(|_| kind));
            let requested = is_requested(&request.columns, kind.name());
            let of_sites = kind == AtomProperty::Occupancy && request.altloc == Altloc::Highest;
            match kind {
                AtomProperty::Model => self.take(found, Use::Model),
                AtomProperty::Asym if requested || request.assembly.is_some() => self.take(found, Use::Asym),
                AtomProperty::Asym => {}
                kind if requested && kind.is_text() => self.take(found, Use::Text(kind)),
                kind if !kind.is_text() && (requested || of_sites) => self.take(found, Use::Number(kind)),
                _ => {}
            }
        }
    }

    /// The names from which elements and radii follow, and those that tell alternate locations apart.
    fn take_names(&mut self, column: &impl Fn(&[&str]) -> Option<usize>, request: &Request) {
        let symbol = column(&["type_symbol"]);
        self.take(symbol, Use::Symbol);
        self.take(column(&["label_atom_id", "auth_atom_id", "label"]), Use::Name);
        self.take(column(&["label_comp_id", "auth_comp_id"]), Use::Residue);
        // Residues matter only where elements are inferred.
        if symbol.is_none() {
            self.take(column(&["label_asym_id", "auth_asym_id"]), Use::ResidueNumber);
            for name in ["label_seq_id", "auth_seq_id", "pdbx_pdb_ins_code"] {
                self.take(column(&[name]), Use::ResidueNumber);
            }
        }
        self.take(column(&["label_alt_id"]), Use::Location);
        self.take(column(&["calc_flag"]), Use::Origin);
        if request.altloc == Altloc::Highest {
            let parts =
                ["label_asym_id", "auth_asym_id", "label_seq_id", "auth_seq_id", "pdbx_pdb_ins_code", "label_atom_id"];
            parts.into_iter().for_each(|name| self.take(column(&[name]), Use::Site));
        }
    }

    /// Whether all three coordinates are present.
    pub(super) fn is_placed(&self) -> bool {
        self.ideal || self.has_all(Use::Position)
    }

    /// Whether all three of these coordinates are present.
    fn has_all(&self, of: fn(usize) -> Use) -> bool {
        (0..3).all(|k| self.uses.iter().flatten().any(|kind| *kind == of(k)))
    }

    /// Takes the idealised positions, if there are any.
    pub(super) fn idealise(&mut self) {
        self.ideal = self.has_all(Use::Ideal);
    }

    /// Whether the idealised positions of a component are taken.
    pub(super) fn is_ideal(&self) -> bool {
        self.ideal
    }

    pub(super) fn is_of_component(&self) -> bool {
        self.component
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

/// The category of the atoms of a chemical component.
const COMPONENT: &str = "_chem_comp_atom.";

/// Its items, in the dictionaries of the PDB and of monomers of CCP4, that have another name than in `_atom_site`.
const COMPONENT_ITEMS: [(&str, &str); 11] = [
    ("atom_id", "label_atom_id"),
    ("comp_id", "label_comp_id"),
    ("model_cartn_x", "cartn_x"),
    ("model_cartn_y", "cartn_y"),
    ("model_cartn_z", "cartn_z"),
    ("x", "cartn_x"),
    ("y", "cartn_y"),
    ("z", "cartn_z"),
    ("pdbx_model_cartn_x_ideal", "ideal_x"),
    ("pdbx_model_cartn_y_ideal", "ideal_y"),
    ("pdbx_model_cartn_z_ideal", "ideal_z"),
];

/// The name of an item of atoms, without its category.
fn item(tag: &str) -> Option<&str> {
    if let Some(name) = tag.strip_prefix(COMPONENT) {
        return COMPONENT_ITEMS.iter().find(|(own, _)| *own == name).map_or(Some(name), |(_, name)| Some(name));
    }
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
    /// The key of the residue: chain, numbers and insertion code, a zero byte after each. Empty where the file gives
    /// elements.
    number: Vec<u8>,
    location: Vec<u8>,
    site: Vec<u8>,
    /// NaN for a coordinate that is missing.
    position: [f64; 3],
    ideal: [f64; 3],
    /// The first coordinate that is missing, and where it is.
    missing: Option<(usize, Spot)>,
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
            // The first value tells whether there is a row.
            let want = match &uses[..] {
                [] if k > 0 => Want::Nothing,
                uses if uses.iter().all(|kind| kind.is_number()) && k > 0 => Want::Number,
                _ => Want::Word,
            };
            match tokens.next_as(want)? {
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
            if k + 1 < layout.uses.len() {
                tokens.check_quote()?;
            }
            for kind in uses {
                match tokens.number() {
                    Some(number) => self.take_number(*kind, number),
                    None => self.take(*kind, tokens.value(), names, || tokens.spot(), &|| tokens.file())?,
                }
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
                self.take(*kind, value, names, || *spot, &|| file.clone())?;
            }
        }
        Ok(())
    }

    fn clear(&mut self) {
        let names = [&mut self.symbol, &mut self.name, &mut self.residue, &mut self.number];
        names.into_iter().chain([&mut self.location, &mut self.site]).for_each(Vec::clear);
        (self.model, self.asym, self.dummy) = (1, 0, false);
        self.numbers = [f64::NAN; AtomProperty::ALL.len()];
        (self.position, self.ideal, self.missing) = ([f64::NAN; 3], [f64::NAN; 3], None);
    }

    /// Takes a finite number.
    fn take_number(&mut self, kind: Use, number: f64) {
        match kind {
            Use::Position(k) => self.position[k] = number,
            Use::Ideal(k) => self.ideal[k] = number,
            Use::Number(kind) => self.numbers[kind as usize] = number,
            _ => {}
        }
    }

    fn take(
        &mut self,
        kind: Use,
        value: &[u8],
        names: &mut NameTable,
        spot: impl Fn() -> Spot,
        file: &dyn Fn() -> Place,
    ) -> Result<()> {
        let place = || spot().of(file());
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
            Use::Position(k) | Use::Ideal(k) => {
                let of = if kind == Use::Position(k) { &mut self.position } else { &mut self.ideal };
                match number(value) {
                    Some(x) => of[k] = x,
                    None if value.is_empty() => {}
                    None => return Err(bad_place(k, value, place())),
                }
                if of[k].is_nan() {
                    self.missing.get_or_insert_with(|| (k, spot()));
                }
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

    /// Whether the atom has a position.
    ///
    /// # Errors
    /// [`Error::Scene`] for an atom that lacks some coordinates.
    pub(super) fn is_placed(&self, layout: &AtomColumns, file: impl FnOnce() -> Place) -> Result<bool> {
        let position = if layout.ideal { self.ideal } else { self.position };
        match position.map(f64::is_nan) {
            [false, false, false] => Ok(true),
            [true, true, true] => Ok(false),
            _ => {
                let (axis, at) = self.missing.unwrap_or_default();
                Err(bad_place(axis, b"", at.of(file())))
            }
        }
    }

    /// Adds the atom to a model, with fractional positions as they are. Without a symbol, the element is inferred from
    /// the label of a small molecule's atom.
    pub(super) fn give(&self, model: &mut Model, layout: &AtomColumns, symmetry: &Symmetry) -> Result<()> {
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
        let position = if layout.ideal { self.ideal } else { self.position };
        model.push(&atom, position, self.asym, |kind| {
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
    Error::scene(
        place.named(["x", "y", "z"][axis]),
        problem,
        mend_number(&String::from_utf8_lossy(value), "use a finite number such as -12.345"),
    )
}

fn bad_model(value: &[u8], place: Place) -> Error {
    let problem = format!("{} is not a model number", quote(value));
    Error::scene(place.named("pdbx_PDB_model_num"), problem, "use a whole number")
}
