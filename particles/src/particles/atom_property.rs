//! The columns of atoms in molecular formats, and the names in those that are text.

use super::frame::Particles;
use super::names::Names;
use halfline_ground::error::Result;

/// Columns of an atom that colours and selections can read; names are numbered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AtomProperty {
    /// B factor, Å².
    Bfactor,
    Occupancy,
    /// The number of the residue in its chain.
    Residue,
    /// The chain, numbered from 0 in the order of first occurrence; asym and entity likewise.
    Chain,
    Model,
    Serial,
    Asym,
    Entity,
    /// In an assembly, the number of the operator from 0.
    Copy,
    /// Partial charge, elementary charges.
    Charge,
    /// The name of the atom.
    Name,
    /// The name of the residue.
    Resname,
    Segid,
    /// The identifier of the alternate location.
    Altloc,
    /// The residue's insertion code.
    Icode,
    /// `ATOM` or `HETATM`.
    Record,
    Vx,
    Vy,
    Vz,
}

impl AtomProperty {
    /// All of them, by their names in `--color-by` and selections.
    pub(crate) const ALL: [(&'static str, Self); 19] = [
        ("name", Self::Name),
        ("resname", Self::Resname),
        ("residue", Self::Residue),
        ("chain", Self::Chain),
        ("segid", Self::Segid),
        ("serial", Self::Serial),
        ("bfactor", Self::Bfactor),
        ("occupancy", Self::Occupancy),
        ("charge", Self::Charge),
        ("altloc", Self::Altloc),
        ("icode", Self::Icode),
        ("record", Self::Record),
        ("model", Self::Model),
        ("asym", Self::Asym),
        ("entity", Self::Entity),
        ("copy", Self::Copy),
        ("vx", Self::Vx),
        ("vy", Self::Vy),
        ("vz", Self::Vz),
    ];

    /// Whether its values are names.
    pub(crate) fn is_text(self) -> bool {
        use AtomProperty::{Altloc, Asym, Chain, Entity, Icode, Name, Record, Resname, Segid};
        matches!(self, Chain | Asym | Entity | Name | Resname | Segid | Altloc | Icode | Record)
    }

    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, kind)| *kind == self).map_or("", |(name, _)| name)
    }
}

/// The names in the text columns of a file.
#[derive(Debug, Default)]
pub(crate) struct NameTable([Names; AtomProperty::ALL.len()]);

impl NameTable {
    /// The number of a name in a column.
    ///
    /// # Errors
    /// [`Error::Limits`] where memory is short.
    pub(crate) fn number(&mut self, kind: AtomProperty, name: &[u8]) -> Result<f64> {
        self.0[kind as usize].number(name).map(f64::from)
    }

    /// The names of a column.
    pub(crate) fn list(&self, kind: AtomProperty) -> &[Vec<u8>] {
        &self.0[kind as usize].list
    }

    /// Adds the names of the stored columns to the particles.
    pub(crate) fn label(&self, particles: &mut Particles) {
        for (name, kind) in AtomProperty::ALL {
            let names = &self.0[kind as usize];
            if kind.is_text() && particles.columns.iter().any(|column| column.name == name) {
                particles.labels.insert(name.into(), names.labels());
            }
        }
    }
}
