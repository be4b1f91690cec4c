//! The formats of scene files, and their names.

use halfline::error::{Error, Result};
use std::path::Path;
use std::str::FromStr;

/// The supported formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// The native scene file, TOML.
    Native,
    /// Haines' Neutral File Format.
    Nff,
    /// XYZ and extended XYZ.
    Xyz,
    /// Protein Data Bank.
    Pdb,
    /// PDB with charges and radii, as written by PDB2PQR.
    Pqr,
    /// PDB with charges and AutoDock's atom types.
    Pdbqt,
    /// Macromolecular CIF.
    Mmcif,
    /// GROMACS coordinates.
    Gro,
    /// LAMMPS dump.
    Dump,
    /// LAMMPS data.
    Data,
    /// Points of a Stanford polygon file.
    Ply,
    /// Comma- or space-separated values with named columns.
    Csv,
    /// A NumPy array.
    Npy,
    /// Named NumPy arrays.
    Npz,
    /// GROMACS trajectory, compressed.
    Xtc,
    /// GROMACS trajectory in full precision.
    Trr,
    /// Trajectory of CHARMM, NAMD, X-PLOR and LAMMPS.
    Dcd,
    /// POSCAR and CONTCAR of VASP.
    Poscar,
    /// Point clouds of the Point Cloud Library.
    Pcd,
    /// Points of laser scans.
    Las,
    /// Frames of HOOMD-blue.
    Gsd,
}

impl Format {
    /// All of them.
    pub const ALL: &'static [Self] = &[
        Self::Native,
        Self::Nff,
        Self::Xyz,
        Self::Pdb,
        Self::Pqr,
        Self::Pdbqt,
        Self::Mmcif,
        Self::Gro,
        Self::Dump,
        Self::Data,
        Self::Ply,
        Self::Csv,
        Self::Npy,
        Self::Npz,
        Self::Xtc,
        Self::Trr,
        Self::Dcd,
        Self::Poscar,
        Self::Pcd,
        Self::Las,
        Self::Gsd,
    ];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.endings()[0]
    }

    /// Whether its files are of atoms of molecules; those of trajectories are, with the elements of a topology.
    #[must_use]
    pub fn is_of_molecules(self) -> bool {
        let text = matches!(self, Self::Pdb | Self::Pqr | Self::Pdbqt | Self::Mmcif | Self::Gro | Self::Xyz);
        text || matches!(self, Self::Xtc | Self::Trr | Self::Dcd)
    }

    /// The file name extensions; the first is the format's name.
    fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Native => &["toml"],
            Self::Nff => &["nff"],
            Self::Xyz => &["xyz", "extxyz"],
            Self::Pdb => &["pdb", "ent"],
            Self::Pqr => &["pqr"],
            Self::Pdbqt => &["pdbqt"],
            Self::Mmcif => &["cif", "mmcif"],
            Self::Gro => &["gro"],
            Self::Dump => &["dump", "lammpstrj"],
            Self::Data => &["data", "lammps"],
            Self::Ply => &["ply"],
            Self::Csv => &["csv", "tsv"],
            Self::Npy => &["npy"],
            Self::Npz => &["npz"],
            Self::Xtc => &["xtc"],
            Self::Trr => &["trr"],
            Self::Dcd => &["dcd"],
            Self::Poscar => &["poscar", "contcar", "vasp"],
            Self::Pcd => &["pcd"],
            Self::Las => &["las", "laz"],
            Self::Gsd => &["gsd"],
        }
    }

    /// Detects the format by a file name without the extension of its compression.
    pub(super) fn of_name(path: &Path) -> Option<Self> {
        let ending = ending(path);
        let known = Self::ALL.iter().copied().find(|format| format.endings().contains(&ending.as_str()));
        // VASP gives its files these names, without an extension.
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_uppercase();
        known.or_else(|| ["POSCAR", "CONTCAR"].iter().any(|vasp| name.starts_with(vasp)).then_some(Self::Poscar))
    }
}

impl FromStr for Format {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self> {
        halfline::error::by_name("format", name, Self::ALL, Self::name)
    }
}

/// The file name extension in lower case; empty if there is none.
pub(super) fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}
