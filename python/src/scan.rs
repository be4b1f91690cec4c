//! The beams of a scanner, and what it measures of their echoes.

use crate::arrays::{list, owned};
use crate::camera::Camera;
use crate::errors::OrRaise;
use crate::scene::Scene;
use crate::work::Job;
use halfline::error::Error;
use halfline::render::trace::echoes::Echoes;
use halfline::scene::lidar::Lidar;
use halfline::settings::Search;
use halfline::{Hits, Rays};
use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// The beams of a pattern, in the words of `halfline trace --pattern`.
#[pyclass(frozen)]
pub(crate) struct Pattern(Lidar);

#[pymethods]
impl Pattern {
    #[new]
    fn new(pattern: &str) -> PyResult<Self> {
        pattern.parse().map(Self).or_raise()
    }

    /// Rings, azimuths and the rays of a beam.
    #[getter]
    fn shape(&self) -> (u32, u32, u32) {
        (self.0.rings(), self.0.azimuths(), self.0.rays_per_beam())
    }

    /// The longest distance that is measured; infinite for none.
    #[getter]
    fn range(&self) -> f64 {
        self.0.range()
    }

    /// Whether echoes are measured in place of exact hits.
    #[getter]
    fn has_echoes(&self) -> bool {
        self.0.echoes().is_some()
    }

    /// The directions of all rays, beam by beam, for a scanner with the pose of this camera; its eye is where they begin.
    fn directions<'py>(&self, py: Python<'py>, camera: &Camera) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let basis = camera.camera.basis().or_raise()?;
        let rays = Job::default().run(py, None, || Ok(self.0.directions(0..self.0.beams(), &basis)))?;
        let count = rays.len();
        owned(py, rays.into_flattened(), &[count, 3])
    }

    /// The echoes of the hits of all rays: ring and column, numbers of returns, id, distance, position, intensity, certainty.
    #[expect(clippy::too_many_arguments, reason = "the arrays of hits")]
    fn echoes<'py>(
        &self,
        py: Python<'py>,
        scene: &Scene,
        eye: [f64; 3],
        directions: PyReadonlyArrayDyn<'py, f64>,
        id: PyReadonlyArrayDyn<'py, i32>,
        distance: PyReadonlyArrayDyn<'py, f64>,
        normal: PyReadonlyArrayDyn<'py, f32>,
        certainty: PyReadonlyArrayDyn<'py, u8>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let directions = list::<f64, [f64; 3], 3>(&directions)?;
        let hits = Hits {
            id: list::<i32, i32, 1>(&id)?.to_vec(),
            t: Vec::new(),
            distance: list::<f64, f64, 1>(&distance)?.to_vec(),
            certainty: list::<u8, u8, 1>(&certainty)?.to_vec(),
            normal: Some(list::<f32, [f32; 3], 3>(&normal)?.to_vec()),
            bound: None,
            search: Search::Auto,
        };
        let found = Job::default().run(py, None, || {
            let rays = Rays { origins: &[eye], directions: &directions, limits: &[] };
            Echoes::new(&self.0, 0, &rays, &hits, scene.spheres())
                .ok_or_else(|| Error::settings("the pattern measures no echoes", "add divergence or noise to it"))
        })?;
        let all = &found.all;
        let count = [all.len()];
        (
            owned(py, all.iter().flat_map(|echo| [echo.ring, echo.column]).collect(), &[all.len(), 2])?,
            owned(
                py,
                all.iter().flat_map(|echo| [echo.return_number, echo.number_of_returns]).collect(),
                &[all.len(), 2],
            )?,
            owned(py, all.iter().map(|echo| echo.id).collect(), &count)?,
            owned(py, all.iter().map(|echo| echo.distance).collect(), &count)?,
            owned(py, all.iter().flat_map(|echo| echo.position).collect(), &[all.len(), 3])?,
            owned(py, all.iter().map(|echo| echo.intensity).collect(), &count)?,
            owned(py, all.iter().map(|echo| echo.certainty).collect(), &count)?,
        )
            .into_pyobject(py)
    }
}
