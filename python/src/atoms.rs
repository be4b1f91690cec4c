//! The library's tables of the elements, and what it infers from names.

use crate::errors::OrRaise;
use crate::read::color;
use halfline::read::style::elements::{atomic_number, element};
use halfline::read::{NamedAtoms, elements_of_names};
use pyo3::prelude::*;

/// Radii and linear RGB, where there are any.
type Tables = (Vec<Option<f64>>, Vec<Option<[f32; 3]>>);

/// The radii and colours of the elements with these symbols.
#[pyfunction]
pub(crate) fn elements(symbols: Vec<String>, radii: &str) -> PyResult<Tables> {
    let is_covalent = radii == "covalent";
    let of = |symbol: &String| {
        let found = element(atomic_number(symbol));
        let radius = found.and_then(|element| if is_covalent { element.covalent } else { element.vdw });
        let color = found.map(|element| color(&format!("#{:06x}", element.color))).transpose()?;
        Ok((radius, color))
    };
    symbols.iter().map(of).collect::<PyResult<Vec<_>>>().map(|found| found.into_iter().unzip())
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
