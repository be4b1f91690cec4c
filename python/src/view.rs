//! Functions for the widget of a notebook: its page, and answers to it in JSON.

use crate::arrays::list;
use crate::errors::OrRaise;
use crate::options::Picture;
use crate::scene::Scene;
use crate::work::{Job, begin};
use halfline_command::shown;
use halfline_files::read::Selection;
use halfline_viewer::FrameRequest;
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::{Value, json};
use std::ffi::OsString;

/// The module of the widget.
#[pyfunction]
pub(crate) fn widget_module() -> String {
    halfline_viewer::widget_module()
}

/// The style of the widget.
#[pyfunction]
pub(crate) fn widget_style() -> &'static str {
    halfline_viewer::widget_style()
}

/// The JPEG of a picture in 8-bit sRGB, a contiguous array of shape (H, W, 3).
#[pyfunction]
pub(crate) fn jpeg<'py>(py: Python<'py>, pixels: PyReadonlyArrayDyn<'py, u8>) -> PyResult<Bound<'py, PyBytes>> {
    let &[height, width, 3] = pixels.shape() else {
        return Err(PyValueError::new_err(format!("the picture has the shape {:?}", pixels.shape())));
    };
    let levels = pixels.as_slice()?;
    let encoded = py.detach(|| halfline_viewer::jpeg::encode([width as u32, height as u32], levels));
    encoded.map(|bytes| PyBytes::new(py, &bytes)).map_err(|refusal| PyValueError::new_err(refusal.message))
}

/// The scene for the page, as JSON: what does not depend on a camera. `picture` are the options of its pictures.
#[pyfunction]
pub(crate) fn summary(py: Python<'_>, scene: &Scene, picture: Picture) -> PyResult<String> {
    begin()?;
    let summary = py.detach(|| {
        let exact = scene.sized(None, None, picture.background())?;
        let (look, samples) = picture.look_and_samples(scene)?;
        let edges = scene.cell.map(|(_, edges)| edges);
        let mut summary = shown::scene(
            (&exact.spheres, scene.beads),
            &scene.columns,
            edges,
            exact.image.background,
            (Some(look), samples),
        );
        (summary["file"], summary["frame"]) = (json!(scene.file), json!(scene.number));
        Ok(summary)
    });
    summary.or_raise().map(|summary| summary.to_string())
}

/// The legend of the colours as SVG, if they have one.
#[pyfunction]
pub(crate) fn legend(scene: &Scene) -> PyResult<Option<String>> {
    shown::legend(scene.legend.as_deref()).or_raise()
}

/// A sphere for the page, as JSON: its centre and radius, its row in the file, and its columns.
#[pyfunction]
pub(crate) fn describe(scene: &Scene, id: usize) -> PyResult<String> {
    let spheres = scene.spheres();
    let (Some(center), Some(radius)) = (spheres.centers.get(id), spheres.radii.get(id)) else {
        return Err(PyIndexError::new_err(format!("there is no sphere {id}")));
    };
    let Value::Object(mut found) = json!({ "id": id, "center": center, "radius": radius }) else { unreachable!() };
    shown::describe(&mut found, &scene.columns, id);
    Ok(Value::Object(found).to_string())
}

/// The distance of the centres of two spheres: as they lie, and in a periodic cell that of their nearest images.
#[pyfunction]
pub(crate) fn apart(scene: &Scene, from: usize, to: usize) -> Option<(f64, Option<f64>)> {
    shown::apart(scene.spheres(), scene.periodic().as_ref(), [from, to])
}

/// The command and the lines of Python that render the picture of a request of the page, both as JSON. The scene was read from
/// `file` by some of the options, which are identifiers of the command's options with their values.
#[pyfunction]
#[pyo3(signature = (file, options, request))]
pub(crate) fn commands(
    file: Option<OsString>,
    options: Vec<(String, Option<OsString>)>,
    request: &str,
) -> PyResult<String> {
    let wrong = |error: serde_json::Error| PyValueError::new_err(format!("the request is not valid: {error}"));
    let request: FrameRequest = serde_json::from_str(request).map_err(wrong)?;
    let found = shown::commands(file.as_deref(), &options, &request).or_raise()?;
    Ok(json!(found).to_string())
}

/// The same spheres in the colours of these rows.
#[pyfunction]
pub(crate) fn with_colors(scene: &Scene, colors: PyReadonlyArrayDyn<'_, f32>) -> PyResult<Scene> {
    scene.with_colors(list::<f32, [f32; 3], 3>(&colors)?).or_raise()
}

/// The same spheres, with a colour for those that each expression selects, the last one wins; and what is to be said about it.
#[pyfunction]
pub(crate) fn painted(py: Python<'_>, scene: &Scene, rules: Vec<(String, [f32; 3])>) -> PyResult<(Scene, Vec<String>)> {
    let rules = rules.iter().map(|(text, color)| Ok((text.parse::<Selection>()?, *color)));
    let rules = rules.collect::<halfline::Result<Vec<_>>>().or_raise()?;
    Job::default().run(py, None, || scene.painted(&rules))
}

/// The same spheres, lit from the eye alone: for pictures while the camera moves.
#[pyfunction]
pub(crate) fn with_light_at_the_eye(scene: &Scene) -> Scene {
    scene.with_light_at_the_eye()
}
