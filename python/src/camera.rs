//! Cameras.

use crate::errors::OrRaise;
use crate::work::begin;
use halfline::camera::{CameraRecord, Intrinsics, Lens, Look};
use halfline::read::cameras;
use halfline::scene::Framing;
use halfline::{Camera as Exact, Error};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A camera, and the size of its image where it has one of its own.
#[pyclass(frozen, from_py_object)]
#[derive(Clone, Copy)]
pub(crate) struct Camera {
    pub(crate) camera: Exact,
    #[pyo3(get)]
    pub(crate) size: Option<(u32, u32)>,
    /// Whether its lens is given in pixels of an image of this size.
    pub(crate) in_pixels: bool,
}

/// The lens of a camera: its kind and its numbers.
type LensArgument = (String, Vec<f64>);

/// `vfov`: degrees and the distance of the viewport; `viewport`: width, height, distance; `height` of a view with parallel
/// rays; `intrinsics`: fx, fy, cx, cy.
fn lens_of((kind, numbers): &LensArgument, size: Option<(u32, u32)>) -> halfline::Result<Lens> {
    match (kind.as_str(), &numbers[..]) {
        ("vfov", &[degrees, distance]) => Ok(Lens::Vfov { degrees, distance }),
        ("viewport", &[vw, vh, distance]) => Ok(Lens::Viewport { vw, vh, distance }),
        ("height", &[height]) => Ok(Lens::Orthographic { height }),
        ("intrinsics", &[fx, fy, cx, cy]) => {
            let (width, height) = size.unwrap_or((1, 1));
            cameras::lens_of(&Intrinsics { fx, fy, cx, cy }, width, height)
        }
        _ => Err(Error::settings(format!("{kind} with {} numbers is no lens", numbers.len()), "use Camera")),
    }
}

#[pymethods]
impl Camera {
    #[new]
    fn new(
        eye: [f64; 3],
        at: Option<[f64; 3]>,
        view: Option<[f64; 3]>,
        up: [f64; 3],
        lens: LensArgument,
        size: Option<(u32, u32)>,
    ) -> PyResult<Self> {
        let look = match (at, view) {
            (Some(at), _) => Look::At(at.into()),
            (None, view) => Look::View(view.unwrap_or([0.0, 0.0, -1.0]).into()),
        };
        let camera = Exact { eye: eye.into(), look, up: up.into(), lens: lens_of(&lens, size).or_raise()? };
        let (width, height) = size.unwrap_or((1, 1));
        camera.basis().and_then(|_| camera.viewport(width, height)).or_raise()?;
        Ok(Self { camera, size, in_pixels: lens.0 == "intrinsics" })
    }

    /// A camera that shows all spheres of a scene.
    #[staticmethod]
    fn fit(
        scene: &crate::scene::Scene,
        view: [f64; 3],
        up: [f64; 3],
        lens: LensArgument,
        size: (u32, u32),
        margin: f64,
    ) -> PyResult<Self> {
        begin()?;
        if !(0.0..1.0).contains(&margin) {
            let problem = format!("margin is {margin}");
            return Err(Error::settings(problem, "give a share of the image from 0 to less than 1")).or_raise();
        }
        let mut framed = scene.exact(None, Some(size), None).or_raise()?;
        framed.camera = Exact {
            look: Look::View(view.into()),
            up: up.into(),
            lens: lens_of(&lens, None).or_raise()?,
            ..framed.camera
        };
        framed.fit(&Framing { margin, ..Framing::default() }).or_raise()?;
        Ok(Self { camera: framed.camera, size: None, in_pixels: false })
    }

    /// The camera in numbers for an image of this size, as JSON.
    fn record(&self, size: (u32, u32)) -> PyResult<String> {
        let record = CameraRecord::new(&self.camera, size.0, size.1).or_raise()?;
        Ok(serde_json::to_string(&record).unwrap_or_default())
    }
}

/// Checks that the columns of `pose` are axes of length 1.
#[pyfunction]
pub(crate) fn check_pose(columns: [[f64; 3]; 3]) -> PyResult<()> {
    let wrong = |(problem, mend)| Error::settings(format!("pose: {problem}"), mend);
    cameras::check_axes(columns, true).map_err(wrong).or_raise()
}

/// The cameras of a list.
#[pyfunction]
pub(crate) fn read_cameras(
    path: PathBuf,
    intrinsics: Option<(f64, f64, f64, f64)>,
    vfov: Option<f64>,
    size: Option<(u32, u32)>,
) -> PyResult<Vec<Camera>> {
    let given = intrinsics.map(|(fx, fy, cx, cy)| Intrinsics { fx, fy, cx, cy });
    let camera = |(number, found): (usize, &cameras::ListedCamera)| {
        let size = size.or(found.size.map(Into::into));
        let lens = match (found.intrinsics.or(given), vfov) {
            _ if found.has_lens => found.camera.lens,
            (Some(intrinsics), _) => {
                let (width, height) = size.ok_or_else(|| {
                    let problem = format!("camera {} has intrinsics and no size", number + 1);
                    Error::settings(problem, "give size=(width, height)")
                })?;
                cameras::lens_of(&intrinsics, width, height)?
            }
            (None, Some(degrees)) => Lens::Vfov { degrees, distance: 1.0 },
            (None, None) => {
                let problem = format!("camera {} has no lens", number + 1);
                return Err(Error::settings(problem, "give vfov= or intrinsics="));
            }
        };
        let in_pixels = !found.has_lens && found.intrinsics.or(given).is_some();
        Ok(Camera { camera: Exact { lens, ..found.camera }, size, in_pixels })
    };
    cameras::read(&path).and_then(|found| found.iter().enumerate().map(camera).collect()).or_raise()
}
