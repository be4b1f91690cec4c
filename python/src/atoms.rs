//! The library's tables of the elements, and what it infers from names.

use crate::errors::OrRaise;
use halfline_files::read::style::elements::{atomic_number, element};
use halfline_files::read::style::{Radii, color_of_element};
use halfline_files::read::{NamedAtoms, elements_of_names};
use pyo3::prelude::*;

/// Radii and linear RGB.
type Tables = (Vec<f64>, Vec<[f32; 3]>);

/// The radii and colours of the elements with these symbols; for unknown ones those that the readers take.
#[pyfunction]
pub(crate) fn elements(symbols: Vec<String>, radii: &str) -> PyResult<Tables> {
    let radii = radii.parse::<Radii>().or_raise()?;
    let of = |number| (radii.radius(number), color_of_element(number));
    Ok(symbols.iter().map(|symbol| of(atomic_number(symbol))).unzip())
}

/// The elements of atoms by their symbols, names, residues, residue numbers and masses: the symbols, empty where unknown;
/// whether each is a virtual site; what was inferred.
#[pyfunction]
pub(crate) fn infer(
    py: Python<'_>,
    names: Vec<String>,
    symbols: Vec<String>,
    residues: Vec<String>,
    residue_numbers: Vec<u64>,
    masses: Vec<f64>,
) -> PyResult<(Vec<&'static str>, Vec<bool>, Vec<String>)> {
    let atoms = NamedAtoms {
        names: &names,
        symbols: &symbols,
        residues: &residues,
        residue_numbers: &residue_numbers,
        masses: &masses,
    };
    let found = py.detach(|| elements_of_names(&atoms)).or_raise()?;
    let symbols = found.elements.iter().map(|number| element(*number).map_or("", |element| element.symbol));
    Ok((symbols.collect(), found.is_site, found.warnings))
}
