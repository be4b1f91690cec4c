//! The formats of scene files, and their names.

use halfline_ground::error::named;
use std::path::Path;

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
    /// Macromolecular CIF, in text or binary.
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
    /// Points in lines of numbers, as laser scanners export them.
    Pts,
    /// Scans of Leica Cyclone.
    Ptx,
    /// Frames of HOOMD-blue.
    Gsd,
}

named! {
    Format, "format",
    Native "toml" Nff "nff" Xyz "xyz" Pdb "pdb" Pqr "pqr" Pdbqt "pdbqt" Mmcif "cif" Gro "gro" Dump "dump" Data "data" Ply "ply"
    Csv "csv" Npy "npy" Npz "npz" Xtc "xtc" Trr "trr" Dcd "dcd" Poscar "poscar" Pcd "pcd" Las "las" Pts "pts" Ptx "ptx" Gsd "gsd"
}

impl Format {
    /// Whether its files are of atoms of molecules; those of trajectories are, with the elements of a topology.
    #[must_use]
    pub fn is_of_molecules(self) -> bool {
        let text = matches!(self, Self::Pdb | Self::Pqr | Self::Pdbqt | Self::Mmcif | Self::Gro | Self::Xyz);
        text || matches!(self, Self::Xtc | Self::Trr | Self::Dcd)
    }

    /// The file name extensions besides the format's name.
    fn other_endings(self) -> &'static [&'static str] {
        match self {
            Self::Xyz => &["extxyz"],
            Self::Pdb => &["ent"],
            Self::Mmcif => &["mmcif", "bcif"],
            Self::Dump => &["lammpstrj"],
            Self::Data => &["lammps"],
            Self::Csv => &["tsv"],
            Self::Poscar => &["contcar", "vasp"],
            Self::Las => &["laz"],
            _ => &[],
        }
    }

    /// Detects the format by a file name without the extension of its compression.
    pub fn of_name(path: &Path) -> Option<Self> {
        let ending = ending(path);
        let has = |format: &Self| format.name() == ending || format.other_endings().contains(&ending.as_str());
        let known = Self::ALL.into_iter().find(has);
        // VASP gives its files these names, without an extension.
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_uppercase();
        known.or_else(|| ["POSCAR", "CONTCAR"].iter().any(|vasp| name.starts_with(vasp)).then_some(Self::Poscar))
    }
}

/// The file name extension in lower case; empty if there is none.
pub fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}
