//! Parts of scenes: what a frame needs of some of its spheres.

use crate::arrays::{list, owned, shown};
use crate::camera::Camera;
use crate::errors::OrRaise;
use crate::scene::Scene;
use crate::words::written;
use crate::work::Job;
use halfline::error::Error;
use halfline::render::stream::{Part as CorePart, Stream};
use halfline::scene::{ImagePlane, Lighting};
use halfline::{Scene as CoreScene, Spheres};
use halfline_command::choices::Choices;
use halfline_command::shown::Call;
use halfline_files::parts;
use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Takes spheres block by block.
#[pyclass(frozen)]
pub(crate) struct Sieve(Mutex<Option<Stream>>);

impl Sieve {
    fn stream(&self) -> MutexGuard<'_, Option<Stream>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn ended() -> Error {
    Error::settings("this sieve has given its part", "make another Sieve for other spheres")
}

#[pymethods]
impl Sieve {
    #[new]
    fn new(camera: &Camera, options: &Bound<'_, PyDict>, first_id: u64) -> PyResult<Self> {
        let choices = Choices::of(&written(options, Call::Sieve)?).or_raise()?;
        let stream = || {
            if camera.aperture.is_some() {
                let problem = "a lens with a size sees spheres that a part has forgotten";
                return Err(Error::settings(problem, "give a camera without aperture"));
            }
            let (width, height) = choices.size().unwrap_or_default();
            camera.check_size((width, height))?;
            let image = ImagePlane { width, height, ..ImagePlane::default() };
            let (spheres, lighting) =
                (Spheres { cuts: choices.planes_of_part()?, ..Spheres::default() }, Lighting::default());
            let scene = CoreScene { camera: camera.for_image((width, height)), image, spheres, lighting };
            scene.check()?;
            Stream::of_part(&scene, &choices.settings_of_part(&scene)?, first_id)
        };
        Ok(Self(Mutex::new(Some(stream().or_raise()?))))
    }

    /// Takes a block of spheres; the package passes contiguous arrays of shape (n, 3), (n,), (n, 3) and (n,).
    fn add(
        &self,
        py: Python<'_>,
        centers: PyReadonlyArrayDyn<'_, f64>,
        radii: PyReadonlyArrayDyn<'_, f64>,
        colors: Option<PyReadonlyArrayDyn<'_, f32>>,
        opacities: Option<PyReadonlyArrayDyn<'_, f32>>,
    ) -> PyResult<()> {
        let block = Spheres {
            centers: list::<f64, [f64; 3], 3>(&centers)?,
            radii: list::<f64, f64, 1>(&radii)?,
            colors: colors.map(|colors| list::<f32, [f32; 3], 3>(&colors)).transpose()?,
            materials: None,
            opacities: opacities.map(|opacities| list::<f32, f32, 1>(&opacities)).transpose()?,
            cuts: None,
        };
        Job::default().run(py, None, || self.stream().as_mut().ok_or_else(ended)?.add(&block))
    }

    /// The spheres that a frame needs of those added so far; no more can be added afterwards.
    fn part(&self, py: Python<'_>) -> PyResult<Part> {
        Job::default().run(py, None, || self.stream().take().ok_or_else(ended)?.part()).map(Part)
    }
}

/// A part; it does not change.
#[pyclass(frozen)]
pub(crate) struct Part(pub(crate) CorePart);

impl Part {
    /// A scene with the camera and the image of the part, without spheres.
    pub(crate) fn scene(&self) -> Scene {
        Scene::of_part(self.0.view().scene(), self.0.view().samples)
    }
}

#[pymethods]
impl Part {
    /// The part in the bytes of a file.
    #[staticmethod]
    fn of_bytes(py: Python<'_>, bytes: &[u8], name: &str) -> PyResult<Self> {
        Job::default().run(py, None, || parts::of_bytes(bytes, name)).map(Self)
    }

    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Job::default().run(py, None, || parts::read(&path)).map(Self)
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        Job::default().run(py, None, || parts::write(&self.0, &path))
    }

    fn bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &Job::default().run(py, None, || parts::bytes(&self.0))?))
    }

    fn combine(&self, py: Python<'_>, others: Vec<Py<Self>>) -> PyResult<Self> {
        let all = || self.0.clone().combine_all(others.iter().map(|part| Ok(part.get().0.clone())));
        Job::default().run(py, None, all).map(Self)
    }

    fn __len__(&self) -> usize {
        self.0.ids().len()
    }

    #[getter]
    fn words(&self) -> String {
        self.0.to_string()
    }

    #[getter]
    fn count(&self) -> u64 {
        self.0.count()
    }

    #[getter]
    fn all_ids(&self) -> Vec<(u64, u64)> {
        self.0.all_ids().into_iter().map(|[first, end]| (first, end)).collect()
    }

    #[getter]
    fn size(&self) -> (u32, u32) {
        self.0.view().size.into()
    }

    #[getter]
    fn samples(&self) -> u32 {
        self.0.view().samples
    }

    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        let ids: Vec<i64> = self.0.ids().iter().map(|id| *id as i64).collect();
        let count = ids.len();
        owned(py, ids, &[count])
    }

    #[getter]
    fn centers<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let values = &this.get().0.spheres().centers;
        #[expect(unsafe_code, reason = "an array of the memory of this part")]
        // SAFETY: a part is frozen, and the array keeps it alive.
        unsafe {
            shown(values.as_flattened(), &[values.len(), 3], this.clone().into_any())
        }
    }

    #[getter]
    fn radii<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let values = &this.get().0.spheres().radii;
        #[expect(unsafe_code, reason = "an array of the memory of this part")]
        // SAFETY: as for the centres.
        unsafe {
            shown(values, &[values.len()], this.clone().into_any())
        }
    }

    #[getter]
    fn colors<'py>(this: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyArrayDyn<f32>>>> {
        let Some(values) = &this.get().0.spheres().colors else { return Ok(None) };
        #[expect(unsafe_code, reason = "an array of the memory of this part")]
        // SAFETY: as for the centres.
        unsafe {
            shown(values.as_flattened(), &[values.len(), 3], this.clone().into_any()).map(Some)
        }
    }
}
