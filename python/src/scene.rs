//! Scenes.

use crate::arrays::{list, shown};
use crate::camera::Camera;
use crate::errors::OrRaise;
use crate::work::begin;
use halfline::scene::{ImagePlane, check_color};
use halfline::{Camera as Exact, Error, Scene as ExactScene, Spheres};
use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use std::sync::Arc;

/// A scene; it does not change, so that any number of threads may render it.
#[pyclass(frozen)]
pub(crate) struct Scene {
    scene: Arc<ExactScene>,
    /// Whether the camera stays, whatever the size of the image; otherwise it shows all spheres.
    held: bool,
    /// The number in its file, the time and the step.
    /// Whether its default camera is that of a molecule.
    is_molecule: bool,
    #[pyo3(get)]
    pub(crate) number: u64,
    #[pyo3(get)]
    time: Option<f64>,
    #[pyo3(get)]
    step: Option<i64>,
    /// The periodic cell: a corner and three edges.
    #[pyo3(get)]
    cell: Option<([f64; 3], [[f64; 3]; 3])>,
}

impl Scene {
    /// The scene of a file.
    pub(crate) fn of_file(frame: halfline::read::SceneFrame, held: bool) -> Self {
        let mut scene = frame.scene;
        scene.spheres.share();
        Self {
            scene: Arc::new(scene),
            held,
            is_molecule: frame.is_molecule,
            number: frame.number,
            time: frame.when.time,
            step: frame.when.step,
            cell: frame.cell.map(|cell| (cell.origin, cell.edges)),
        }
    }

    /// The spheres.
    pub(crate) fn spheres(&self) -> &Spheres {
        &self.scene.spheres
    }

    /// The scene with another camera, size or background. The spheres are shared.
    pub(crate) fn exact(
        &self,
        camera: Option<&Camera>,
        size: Option<(u32, u32)>,
        background: Option<[f32; 3]>,
    ) -> halfline::Result<ExactScene> {
        let mut scene = (*self.scene).clone();
        let own = camera.filter(|camera| camera.in_pixels).and_then(|camera| camera.size);
        if let (Some(size), Some(own)) = (size, own)
            && size != own
        {
            let problem = format!("size is {size:?}, and the camera's intrinsics belong to {own:?}");
            return Err(Error::settings(problem, "remove size, or give the intrinsics of the other size"));
        }
        if let Some(size) = size.or(camera.and_then(|camera| camera.size)) {
            (scene.image.width, scene.image.height) = size;
        }
        scene.image.background = background.unwrap_or(scene.image.background);
        match camera {
            Some(camera) => scene.camera = camera.camera,
            None if self.held => {}
            None => {
                // A size without pixels has no shape; it is refused before the camera is.
                halfline::scene::check_size([scene.image.width.into(), scene.image.height.into()], || "size".into())?;
                scene.frame_by_default(self.is_molecule, &Default::default())?;
            }
        }
        Ok(scene)
    }
}

#[pymethods]
impl Scene {
    /// The package passes contiguous arrays of shape (n, 3), (n,) and (n, 3).
    #[new]
    fn new(
        py: Python<'_>,
        centers: PyReadonlyArrayDyn<'_, f64>,
        radii: PyReadonlyArrayDyn<'_, f64>,
        colors: Option<PyReadonlyArrayDyn<'_, f32>>,
        background: [f32; 3],
    ) -> PyResult<Self> {
        let colors = colors.map(|colors| list::<f32, [f32; 3], 3>(&colors)).transpose()?;
        let spheres = Spheres {
            centers: list::<f64, [f64; 3], 3>(&centers)?,
            radii: list::<f64, f64, 1>(&radii)?,
            colors,
            materials: None,
        };
        py.detach(|| check(&spheres)).or_raise()?;
        check_color(background, || "background".into()).or_raise()?;
        let scene = ExactScene {
            camera: Exact::CANONICAL,
            image: ImagePlane { background, ..ImagePlane::default() },
            spheres,
            skipped: Default::default(),
            lighting: Default::default(),
        };
        let (held, is_molecule) = (false, false);
        Ok(Self { scene: Arc::new(scene), held, is_molecule, number: 1, time: None, step: None, cell: None })
    }

    /// The same spheres with what another program says of them.
    fn told(
        &self,
        warnings: Vec<String>,
        number: u64,
        time: Option<f64>,
        step: Option<i64>,
        cell: Option<([f64; 3], [[f64; 3]; 3])>,
    ) -> Self {
        let mut scene = (*self.scene).clone();
        scene.skipped.assumed.extend(warnings);
        Self { scene: Arc::new(scene), held: self.held, is_molecule: self.is_molecule, number, time, step, cell }
    }

    fn __len__(&self) -> usize {
        self.scene.spheres.len()
    }

    #[getter]
    fn centers<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let values = &this.get().scene.spheres.centers;
        #[expect(unsafe_code, reason = "an array of the memory of this scene")]
        // SAFETY: a scene is frozen, and the array keeps it alive.
        unsafe {
            shown(values.as_flattened(), &[values.len(), 3], this.clone().into_any())
        }
    }

    #[getter]
    fn radii<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let values = &this.get().scene.spheres.radii;
        #[expect(unsafe_code, reason = "an array of the memory of this scene")]
        // SAFETY: as for the centres.
        unsafe {
            shown(values, &[values.len()], this.clone().into_any())
        }
    }

    #[getter]
    fn colors<'py>(this: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyArrayDyn<f32>>>> {
        let Some(values) = &this.get().scene.spheres.colors else { return Ok(None) };
        #[expect(unsafe_code, reason = "an array of the memory of this scene")]
        // SAFETY: as for the centres.
        unsafe {
            shown(values.as_flattened(), &[values.len(), 3], this.clone().into_any()).map(Some)
        }
    }

    /// Columns and rows of the image.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.scene.image.width, self.scene.image.height)
    }

    /// Linear RGB of a ray that hits nothing.
    #[getter]
    fn background(&self) -> [f32; 3] {
        self.scene.image.background
    }

    /// What the reader left out or assumed.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.scene.skipped.warnings()
    }

    /// The camera for an image of this size.
    fn camera(&self, size: Option<(u32, u32)>) -> PyResult<Camera> {
        begin()?;
        let scene = self.exact(None, size, None).or_raise()?;
        Ok(Camera { camera: scene.camera, size: None, in_pixels: false })
    }

    /// Equal for equal numbers.
    fn fingerprint(&self, py: Python<'_>) -> PyResult<String> {
        begin()?;
        Ok(py.detach(|| self.scene.fingerprint()))
    }
}

/// Checks the spheres; an error names the argument and the row.
fn check(spheres: &Spheres) -> halfline::Result<()> {
    let wrong = |name: &str, row: usize, found: String, mend: &str| {
        Err(Error::settings(format!("{name}[{row}] is {found}: {}", rule(name)), mend))
    };
    let three = |[x, y, z]: [f64; 3]| format!("[{x}, {y}, {z}]");
    if let Some(row) = spheres.centers.iter().position(|center| center.iter().any(|x| !x.is_finite())) {
        return wrong("centers", row, three(spheres.centers[row]), "remove the sphere or give it three finite numbers");
    }
    if let Some(row) = spheres.radii.iter().position(|radius| !(*radius > 0.0 && radius.is_finite())) {
        return wrong("radii", row, spheres.radii[row].to_string(), "remove the sphere or give it a radius");
    }
    let Some(colors) = &spheres.colors else { return Ok(()) };
    match colors.iter().position(|color| color.iter().any(|c| !(c.is_finite() && *c >= 0.0))) {
        Some(row) => wrong("colors", row, three(colors[row].map(f64::from)), "give linear RGB, 0 or more"),
        None => Ok(()),
    }
}

fn rule(name: &str) -> &'static str {
    match name {
        "centers" => "coordinates are finite",
        "radii" => "radii are positive and finite",
        _ => "components are finite and not negative",
    }
}
