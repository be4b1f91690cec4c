//! The command `halfline` of the wheel.

use crate::work::begin;
use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs the command with these arguments; the exit code. It handles signals itself and may end the process.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<u8> {
    begin()?;
    Ok(py.detach(|| halfline_command::command(std::iter::once("halfline".into()).chain(arguments))))
}
