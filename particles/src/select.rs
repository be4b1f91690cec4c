//! Selections of particles by expressions in the words of MDAnalysis and VMD: `protein and not name H*`, `chain A B`,
//! `resid 10:20`, `bfactor < 30`, `within 5 of (resname HEM)`. The grammar and the meaning are as in
//! docs.mdanalysis.org/stable/documentation_pages/selections.html, with VMD's `within`, `exwithin` and `hydrogen`
//! (www.ks.uiuc.edu/Research/vmd/current/ug/node89.html).

pub mod apply;
mod columns;
mod evaluate;
mod expression;
mod grammar;
mod ligand;
mod note;
pub mod selection;
mod values;

pub use apply::{SelectedSpheres, Selections, apply, marks_of, mask};
pub(super) use columns::candidates;
pub use note::{Note, Notes};

#[cfg(test)]
mod tests;
