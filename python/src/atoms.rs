//! The library's tables of the elements.

use crate::read::color;
use halfline::read::style::elements::{atomic_number, element};
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
