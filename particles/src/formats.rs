//! Readers, one file for each format.

pub(crate) mod data;
pub(crate) mod dump;
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
pub mod table;
pub(crate) mod trajectory;
pub(crate) mod xyz;
