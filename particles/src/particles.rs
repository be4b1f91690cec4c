//! Particles from files of simulations, molecules and scans. A reader returns them frame by frame; the style turns them
//! into spheres.

pub(super) mod added;
pub(super) mod assembly;
pub(super) mod atom_property;
pub(super) mod bytes;
pub mod colors;
pub mod column_names;
pub mod frame;
pub mod frame_time;
pub(super) mod grouped;
pub mod identity;
pub mod infer;
pub(super) mod joined;
pub(super) mod layout;
pub(super) mod left_out;
pub(super) mod masses;
pub(super) mod meaning;
pub(super) mod mixed;
pub(super) mod molecule;
pub(super) mod names;
pub mod periodic;
pub(super) mod placed;
pub(super) mod points;
pub(super) mod records;
pub mod request;
pub(super) mod residues;
pub(super) mod role;
pub(super) mod rows;

pub mod survey;
pub mod vectors;
