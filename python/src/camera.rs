//! Cameras.

use crate::errors::OrRaise;
use halfline::camera::{Aperture, CameraRecord, Intrinsics, Lens, Look};
use halfline::{Camera as CoreCamera, Error};
use halfline_files::read::cameras::{self, ListedCamera, ListedLens, NamedLens};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A camera, and the size of its image where it has one of its own.
#[pyclass(frozen, from_py_object)]
#[derive(Clone, Copy)]
pub(crate) struct Camera {
    pub(crate) camera: CoreCamera,
    /// The size of its lens; `None` for a pinhole.
    pub(crate) aperture: Option<Aperture>,
    #[pyo3(get)]
    pub(crate) size: Option<(u32, u32)>,
    /// Whether its lens is given in pixels of an image of this size, or without a size in pixels of any picture.
    pub(crate) in_pixels: bool,
}

impl Camera {
    /// The camera that `scene` has for an image of this size.
    pub(crate) fn of(camera: CoreCamera, aperture: Option<Aperture>, size: (u32, u32)) -> Self {
        Self { camera, aperture, size: camera.lens.is_curved().then_some(size), in_pixels: false }
    }

    /// The camera for an image of this size.
    pub(crate) fn for_image(&self, size: (u32, u32)) -> CoreCamera {
        let own = if self.in_pixels { size } else { self.size.unwrap_or(UNIT) };
        CoreCamera { lens: self.camera.lens.resized(own.into(), size.into()), ..self.camera }
    }

    /// Checks a size, where the lens is given in pixels of an image of another one.
    ///
    /// # Errors
    /// [`Error::Settings`] with both sizes.
    pub(crate) fn check_size(&self, size: (u32, u32)) -> halfline::Result<()> {
        let Some(own) = self.size.filter(|own| self.in_pixels && *own != size) else { return Ok(()) };
        let problem = format!("size is {size:?}, and the camera's intrinsics belong to {own:?}");
        Err(Error::settings(problem, "remove size, or give the intrinsics of the other size"))
    }
}

/// The size of the image for which a lens without one is made.
const UNIT: (u32, u32) = (1, 1);

/// The kind of a lens that options name, before its name.
const NAMED: &str = "lens ";

/// The lens of a camera: its kind and its numbers.
pub(crate) type LensArgument = (String, Vec<f64>);

/// `vfov`: degrees and the distance of the viewport; `viewport`: width, height, distance; `height` of a view with parallel
/// rays; `intrinsics`: fx, fy, cx, cy; `lens NAME`: vfov, fx, fy, cx, cy (NaN stands for none), and coefficients.
pub(crate) fn lens_of((kind, numbers): &LensArgument, size: Option<(u32, u32)>) -> halfline::Result<Lens> {
    if let (Some(name), [vfov, fx, fy, cx, cy, coefficients @ ..]) = (kind.strip_prefix(NAMED), &numbers[..]) {
        let [vfov, fx, fy, cx, cy] = [*vfov, *fx, *fy, *cx, *cy];
        let intrinsics = Some(Intrinsics { fx, fy, cx, cy }).filter(|_| !fx.is_nan());
        let words = ["vfov", "intrinsics", "lens_coefficients"];
        let vfov = Some(vfov).filter(|degrees| !degrees.is_nan());
        let (width, height) = size.unwrap_or(UNIT);
        let lens = NamedLens { name: name.parse()?, vfov, intrinsics, coefficients, words }.lens(width, height);
        return lens.map_err(|(_, problem, mend)| Error::settings(format!("lens {name}: {problem}"), mend));
    }
    match (kind.as_str(), &numbers[..]) {
        ("vfov", &[degrees, distance]) => Ok(Lens::Vfov { degrees, distance }),
        ("viewport", &[vw, vh, distance]) => Ok(Lens::Viewport { vw, vh, distance }),
        ("height", &[height]) => Ok(Lens::Orthographic { height }),
        ("intrinsics", &[fx, fy, cx, cy]) => {
            let (width, height) = size.unwrap_or(UNIT);
            cameras::lens_of(&Intrinsics { fx, fy, cx, cy }, width, height)
        }
        (curved @ ("distorted" | "fisheye"), &[fx, fy, cx, cy, ref coefficients @ ..]) => {
            let curve = cameras::curve_of(coefficients, curved == "fisheye")?;
            match curve {
                Some(curve) => Ok(Lens::Curved { curve, fx, fy, cx, cy }),
                None => lens_of(&("intrinsics".to_owned(), vec![fx, fy, cx, cy]), size),
            }
        }
        _ => Err(Error::settings(format!("{kind} with {} numbers is no lens", numbers.len()), "use Camera")),
    }
}

#[pymethods]
impl Camera {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "the arguments of the class in Python")]
    pub(crate) fn new(
        eye: [f64; 3],
        at: Option<[f64; 3]>,
        view: Option<[f64; 3]>,
        up: [f64; 3],
        lens: LensArgument,
        size: Option<(u32, u32)>,
        aperture: Option<f64>,
        focus: Option<f64>,
    ) -> PyResult<Self> {
        let look = match (at, view) {
            (Some(at), _) => Look::At(at.into()),
            (None, view) => Look::View(view.unwrap_or([0.0, 0.0, -1.0]).into()),
        };
        let camera = CoreCamera { eye: eye.into(), look, up: up.into(), lens: lens_of(&lens, size).or_raise()? };
        let (width, height) = size.unwrap_or(UNIT);
        camera.basis().and_then(|_| camera.check(width, height)).or_raise()?;
        let aperture = aperture.map(|diameter| Aperture { diameter, focus });
        aperture.map(|aperture| aperture.distance(&camera)).transpose().or_raise()?;
        let in_pixels = match lens.0.strip_prefix(NAMED) {
            Some(_) => lens.1.get(1).is_some_and(|fx| !fx.is_nan()),
            None => !["vfov", "viewport", "height"].contains(&&lens.0[..]),
        };
        Ok(Self { camera, aperture, size, in_pixels })
    }

    /// All that it is, as JSON, for pickling.
    fn state(&self) -> String {
        let aperture = self.aperture.map(|aperture| (aperture.diameter, aperture.focus));
        // Numbers and names are always JSON.
        serde_json::to_string(&(self.camera, aperture, self.size, self.in_pixels)).unwrap_or_default()
    }

    /// The camera of a state.
    #[staticmethod]
    fn of_state(state: &str) -> PyResult<Self> {
        type State = (CoreCamera, Option<(f64, Option<f64>)>, Option<(u32, u32)>, bool);
        let read = serde_json::from_str::<State>(state);
        let (camera, aperture, size, in_pixels) = read
            .map_err(|error| Error::settings(format!("the pickled camera is damaged: {error}"), "make it again"))
            .or_raise()?;
        camera.basis().or_raise()?;
        let aperture = aperture.map(|(diameter, focus)| Aperture { diameter, focus });
        Ok(Self { camera, aperture, size, in_pixels })
    }

    /// The camera in numbers for an image of this size, as JSON.
    fn record(&self, size: (u32, u32)) -> PyResult<String> {
        let record = CameraRecord::new(&self.for_image(size), size.into(), self.aperture).or_raise()?;
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
    let vfov = vfov.map(|degrees| Lens::Vfov { degrees, distance: 1.0 });
    let camera = |(index, found): (usize, &ListedCamera)| {
        let size = size.or(found.size.map(Into::into));
        let lens = found
            .lens(given, vfov)
            .ok_or_else(|| Error::settings(format!("camera {index} has no lens"), "give vfov= or intrinsics="))?;
        let in_pixels = matches!(lens, ListedLens::InPixels(_));
        let image = size.or((!in_pixels).then_some((1, 1)));
        let (width, height) = image.ok_or_else(|| {
            let problem = format!("camera {index} has intrinsics and no size");
            Error::settings(problem, "give size=(width, height)")
        })?;
        let lens = lens.for_image(index, width, height)?;
        Ok(Camera { camera: CoreCamera { lens, ..found.camera }, aperture: found.aperture, size, in_pixels })
    };
    cameras::read(&path).and_then(|found| found.iter().enumerate().map(camera).collect()).or_raise()
}
