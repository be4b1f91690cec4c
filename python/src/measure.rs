//! Measurements of speed against error.

use crate::camera::Camera;
use crate::errors::OrRaise;
use crate::scene::Scene;
use crate::work::Job;
use halfline::settings::Tolerance;
use halfline_measure::run::{Options, Subject, measure as run};
use halfline_measure::variant::Variant;
use pyo3::prelude::*;

/// Measures methods in a scene; the record as JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the package names them")]
pub(crate) fn measure(
    py: Python<'_>,
    scene: &Scene,
    camera: Option<&Camera>,
    size: Option<(u32, u32)>,
    methods: Option<Vec<String>>,
    backend: &str,
    adapter: Option<String>,
    repeat: Option<u32>,
    tolerance: Option<f64>,
    patience: f64,
) -> PyResult<String> {
    let options = Options {
        backend: backend.parse().or_raise()?,
        adapter,
        variants: match methods {
            Some(names) => names.iter().map(|name| name.parse()).collect::<halfline::Result<_>>().or_raise()?,
            None => Variant::all(),
        },
        rounds: repeat,
        tolerance: tolerance.map(Tolerance::new).transpose().or_raise()?.unwrap_or_default(),
        patience,
        command: "halfline.measure".into(),
    };
    let job = Job::default();
    let record = job.run(py, None, || {
        let subject = Subject::scene("scene", scene.exact(camera, size)?, scene.frame.skipped.warnings());
        run(&subject, &options, &job.watch(), &mut |_| {})
    })?;
    crate::reports::json(&record)
}
