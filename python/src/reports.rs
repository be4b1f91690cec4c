//! Reports as JSON: adapters and files.

use crate::errors::{OrRaise, exception};
use crate::work::Job;
use halfline_command::choices::in_keywords;
use halfline_files::read::{ParticleOptions, ReadOptions};
use pyo3::prelude::*;
use serde::Serialize;
use std::path::PathBuf;

/// A report as JSON.
pub(crate) fn json(report: &impl Serialize) -> PyResult<String> {
    let text = serde_json::to_string(report).map_err(|error| exception(halfline::Error::write("-", error.into())))?;
    Ok(in_keywords(&text))
}

/// Every adapter with the measured properties of its arithmetic.
#[pyfunction]
pub(crate) fn adapters(py: Python<'_>) -> PyResult<String> {
    let (found, measured) = Job::default().run(py, None, || Ok((halfline::adapters()?, halfline::verdicts(false)?)))?;
    let both = found.iter().zip(&measured).map(|(adapter, verdict)| {
        let mut object = serde_json::json!(adapter);
        object["verdict"] = serde_json::json!(verdict.as_ref().ok());
        object["verdict_error"] = serde_json::json!(verdict.as_ref().err().map(ToString::to_string));
        object
    });
    json(&both.collect::<Vec<_>>())
}

/// The contents of a file, as JSON: format, frames, spheres, columns.
#[pyfunction]
pub(crate) fn info(
    py: Python<'_>,
    path: PathBuf,
    format: Option<String>,
    columns: Option<String>,
    atom_style: Option<String>,
    skip_invalid: bool,
    model: Option<i64>,
) -> PyResult<String> {
    let format = format.map(|text| text.parse()).transpose().or_raise()?;
    let columns_named = columns.map(|text| text.parse()).transpose().or_raise()?.unwrap_or_default();
    let atom_style = atom_style.map(|text| text.parse()).transpose().or_raise()?;
    let job = Job::default();
    let watch = job.watch();
    let options = ReadOptions {
        particles: ParticleOptions {
            format,
            columns_named,
            atom_style,
            skip_invalid,
            model,
            watch,
            ..Default::default()
        },
        ..ReadOptions::default()
    };
    json(&job.run(py, None, || halfline_files::read::info(&path, &options))?)
}
