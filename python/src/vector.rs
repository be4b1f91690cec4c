//! Figures without pixels.

use crate::camera::Camera;
use crate::errors::OrRaise;
use crate::scene::Scene;
use crate::words::written;
use crate::work::Job;
use halfline::error::Error;
use halfline_command::choices::{Choices, ChosenFigure, in_keywords};
use halfline_command::shown::Call;
use halfline_files::write::file::{check_writable, write_atomically};
use halfline_files::write::vector::VectorFormat;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;

/// A figure; it does not change.
#[pyclass(frozen)]
pub(crate) struct Figure(ChosenFigure);

#[pymethods]
impl Figure {
    #[new]
    fn new(py: Python<'_>, scene: &Scene, camera: Option<&Camera>, options: &Bound<'_, PyDict>) -> PyResult<Self> {
        let mut written = written(options, Call::Vector)?;
        written.push(("output".into(), Some("figure.svg".into())));
        let choices = Choices::of(&written).or_raise()?;
        let figure = || choices.figure(scene.chosen(camera, choices.size(), scene.frame.number)?);
        Job::default().run(py, None, figure).map(Self)
    }

    /// The counts of paths, of small parts that are left out, and of lines that are closed by a straight one.
    #[getter]
    fn counts(&self) -> (u64, u64, u64) {
        let counts = self.0.figure.counts();
        (counts.paths, counts.small, counts.joined)
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings.iter().map(|warning| in_keywords(warning)).collect()
    }

    fn svg(&self, py: Python<'_>) -> String {
        py.detach(|| self.0.figure.svg(self.0.panels.as_ref()))
    }

    fn pdf<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &py.detach(|| self.0.bytes(VectorFormat::Pdf)))
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        Job::default().run(py, None, || {
            let format = VectorFormat::of(&path).ok_or_else(|| {
                let problem = format!("{} cannot hold a figure without pixels", path.display());
                Error::settings(problem, "use the file name extension .svg or .pdf")
            })?;
            let bytes = self.0.bytes(format);
            check_writable(&path)?;
            write_atomically(&path, |out| out.write_all(&bytes))
        })
    }
}
