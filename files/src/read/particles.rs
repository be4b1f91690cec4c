//! Particles from files of simulations, molecules and scans. A reader returns them frame by frame; the style turns them
//! into spheres.

pub(super) mod assembly;
pub(super) mod atom_property;
pub(super) mod bytes;
pub(super) mod column_names;
pub(super) mod data;
pub(super) mod dump;
pub(super) mod frame;
pub(super) mod frame_time;
pub(super) mod gro;
pub(super) mod gsd;
pub(super) mod infer;
pub(super) mod las;
pub(super) mod layout;
pub(super) mod left_out;
pub(super) mod masses;
pub(super) mod mixed;
pub(super) mod mmcif;
pub(super) mod molecule;
pub(super) mod names;
pub(super) mod npz;
pub(super) mod pcd;
pub(super) mod pdb;
pub(super) mod periodic;
pub(super) mod placed;
pub(super) mod ply;
pub(super) mod poscar;
pub(super) mod request;
pub(super) mod role;
pub(super) mod rows;

pub(super) mod survey;
pub(super) mod table;
pub(super) mod trajectory;
pub(super) mod vectors;
pub(super) mod xyz;
