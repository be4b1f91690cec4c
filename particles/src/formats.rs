//! The formats: a file for each reader, and one list.

pub(crate) mod data;
pub(crate) mod dump;
pub(crate) mod e57;
pub(crate) mod gro;
pub(crate) mod gsd;
pub(crate) mod las;
pub(crate) mod mmcif;
pub(crate) mod npz;
pub(crate) mod pcd;
pub(crate) mod pdb;
pub(crate) mod ply;
pub(crate) mod poscar;
pub(crate) mod ptx;
pub mod scenes;
pub mod table;
pub(crate) mod trajectory;
pub(crate) mod vtk;
pub(crate) mod xyz;

use crate::format::Format;
use crate::npy::records as npy;
use halfline_ground::error::{Error, Result, by_name};
use std::str::FromStr;

/// Lists the formats. Those with signs of the same kind are tried in this order.
macro_rules! formats {
    ($($name:ident $($room:ident)::+,)*) => {
        impl Format {
            /// All of them.
            pub const ALL: [Self; [$(stringify!($name)),*].len()] = [$(Self::$name),*];

            $(
                #[doc = concat!("The format `", stringify!($name), "`; see [`Format::about`].")]
                pub const $name: Self = Self(&$($room)::+::$name);
            )*
        }
    };
}

formats! {
    NATIVE scenes,
    NFF scenes,
    XYZ xyz,
    PDB pdb,
    PQR pdb,
    PDBQT pdb,
    GRO gro,
    PTX ptx,
    POSCAR poscar,
    CIF mmcif,
    DATA data,
    DUMP dump,
    PLY ply,
    CSV table,
    NPY npy,
    NPZ npz,
    XTC trajectory,
    TRR trajectory,
    DCD trajectory,
    NC trajectory,
    PCD pcd,
    LAS las,
    PTS table,
    GSD gsd,
    VTK vtk,
    E57 e57,
}

impl Format {
    /// Whether a frame is of atoms without a box around them: of a format of molecules, with an element; of XYZ only without a cell.
    #[must_use]
    pub fn is_molecule(self, has_elements: bool, has_cell: bool) -> bool {
        self.is_of_molecules() && has_elements && !(self == Self::XYZ && has_cell)
    }
}

impl FromStr for Format {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self> {
        by_name("format", name, &Self::ALL, Self::name)
    }
}
