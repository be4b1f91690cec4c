//! Parts of scenes: what a frame needs of some of its spheres.

use crate::arrays::{list, owned, shown};
use crate::camera::Camera;
use crate::errors::OrRaise;
use crate::scene::Scene;
use crate::work::Job;
use halfline::error::{Error, Result};
use halfline::render::stream::{Part as CorePart, Stream};
use halfline::scene::{ImagePlane, Lighting};
use halfline::settings::{Outline, Settings, Tolerance};
use halfline::window::Window;
use halfline::{Scene as CoreScene, Spheres};
use halfline_files::parts;
use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
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
    #[expect(clippy::too_many_arguments, reason = "those of the class in Python")]
    fn new(
        camera: &Camera,
        size: (u32, u32),
        samples: u32,
        seed: u32,
        crop: Option<[u32; 4]>,
        tolerance: Option<f64>,
        outline_width: Option<f64>,
        first_id: u64,
    ) -> PyResult<Self> {
        let stream = || {
            if camera.aperture.is_some() {
                let problem = "a lens with a size sees spheres that a part has forgotten";
                return Err(Error::settings(problem, "give a camera without aperture"));
            }
            camera.check_size(size)?;
            let (width, height) = size;
            let image = ImagePlane { width, height, ..ImagePlane::default() };
            let (spheres, lighting) = (Spheres::default(), Lighting::default());
            let scene = CoreScene { camera: camera.camera, image, spheres, lighting };
            scene.check()?;
            let settings = Settings {
                samples,
                seed,
                window: crop.map(|[x0, y0, x1, y1]| Window { x0, y0, x1, y1 }),
                tolerance: tolerance.map(Tolerance::new).transpose()?,
                outline: Outline::of(outline_width, None),
                ..Settings::default()
            };
            Stream::of_part(&scene, &settings, first_id)
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

    /// The settings of a frame of the part; those that are given must be its own.
    pub(crate) fn settings(
        &self,
        size: Option<(u32, u32)>,
        outline_width: Option<f64>,
        settings: Settings,
    ) -> Result<Settings> {
        let view = self.0.view();
        let own = (view.size[0], view.size[1]);
        if let Some(size) = size.filter(|size| *size != own) {
            let problem = format!("size is {size:?}, and the part is of a frame of {own:?}");
            return Err(Error::settings(problem, "remove size, or sift again"));
        }
        // 0 is the default of the keyword.
        let seed = if settings.seed == 0 { view.seed } else { settings.seed };
        let tolerance = settings.tolerance.or(parts::tolerance(view)?);
        let outline = Outline { width: outline_width.unwrap_or(view.outline), ..settings.outline };
        Ok(Settings { seed, tolerance, outline, window: settings.window.or(Some(view.window)), ..settings })
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
