//! The keys of lenses in lists of cameras, by the names of NeRF, OpenCV, COLMAP, nerfstudio, instant-ngp, ROS and Kalibr.
//!
//! Sources: docs.nerf.studio/quickstart/data_conventions.html; instant-ngp, json_binding.h and nerf_loader.cu; colmap.github.io/cameras.html;
//! docs.opencv.org, calib3d, fisheye and omnidir; docs.ros.org, sensor_msgs/CameraInfo and camera_calibration_parsers;
//! github.com/ethz-asl/kalibr/wiki/yaml-formats.

use halfline::error::{Error, Place, Result};
use serde_json::{Map, Value};

/// The remedy of cameras that lack something.
pub(super) const MEND: &str = "give each camera eye, view or at, and up; or transform_matrix (NeRF); or pose, a 4 x 4 matrix from camera to world";

/// The meaning of a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Meaning {
    /// A focal length in pixels, across, down or both.
    Focal(&'static [usize]),
    /// A field of view across or down, radians.
    Radians(usize),
    /// A field of view across or down, degrees.
    Degrees(usize),
    /// A coordinate of the principal point.
    Center(usize),
    /// Columns or rows.
    Side(usize),
    /// Columns and rows.
    Size,
    /// Focal lengths and principal point as a matrix of 3 rows, whose fourth column, if any, is 0, or as fx, fy, cx, cy.
    Matrix,
    /// k1 to k6.
    Radial(usize),
    /// p1 and p2.
    Tangential(usize),
    /// Coefficients in the order of OpenCV: k1, k2, p1, p2, k3, k4, k5, k6.
    OpenCv,
    /// Coefficients in the order of nerfstudio: k1, k2, k3, k4, p1, p2.
    Nerfstudio,
    /// All numbers of a lens in the order of its model in COLMAP.
    Params,
    /// The name of a model.
    Model,
    /// The name of a model, or of a body.
    ModelOrBody,
    /// The name of a model of distortion, of a lens whose own model is a pinhole's.
    Distortion,
    /// Whether the lens is a fisheye, or a panorama.
    Is(&'static str),
    /// The curve as halfline writes it.
    Curve,
    /// Width and height of the viewport.
    Viewport,
    /// The distance of the viewport; null for parallel rays.
    Distance,
    /// Full height as an angle, degrees.
    Vfov,
    /// Diameter of a lens with a size, and the distance in focus, as halfline writes them.
    Aperture,
    Focus,
    /// A rotation of the image; only none is known.
    Rotation,
    /// A part of a model that is not known, which 0, false and nothing leave out.
    Unknown,
    /// A focal length or an angle in a unit or a direction that the key does not say.
    Unclear,
}

use Meaning::*;

/// All keys.
pub(super) const KEYS: &[(&str, Meaning)] = &[
    ("fl_x", Focal(&[0])),
    ("fl_y", Focal(&[1])),
    ("fx", Focal(&[0])),
    ("fy", Focal(&[1])),
    ("f", Focal(&[0, 1])),
    ("camera_angle_x", Radians(0)),
    ("camera_angle_y", Radians(1)),
    ("x_fov", Degrees(0)),
    ("y_fov", Degrees(1)),
    ("cx", Center(0)),
    ("cy", Center(1)),
    ("ppx", Center(0)),
    ("ppy", Center(1)),
    ("w", Side(0)),
    ("h", Side(1)),
    ("width", Side(0)),
    ("height", Side(1)),
    ("image_width", Side(0)),
    ("image_height", Side(1)),
    ("size", Size),
    ("resolution", Size),
    ("K", Matrix),
    ("camera_matrix", Matrix),
    ("intrinsics", Matrix),
    ("P", Matrix),
    ("p", Matrix),
    ("projection_matrix", Matrix),
    ("k1", Radial(0)),
    ("k2", Radial(1)),
    ("k3", Radial(2)),
    ("k4", Radial(3)),
    ("k5", Radial(4)),
    ("k6", Radial(5)),
    ("p1", Tangential(0)),
    ("p2", Tangential(1)),
    ("distortion", OpenCv),
    ("distortion_coefficients", OpenCv),
    ("distortion_coeffs", OpenCv),
    ("dist_coeffs", OpenCv),
    ("dist", OpenCv),
    ("D", OpenCv),
    ("d", OpenCv),
    ("distortion_params", Nerfstudio),
    ("params", Params),
    ("camera_model", Model),
    ("projection", Model),
    ("projection_type", Model),
    ("lens_model", Model),
    ("lens_type", Model),
    ("model", ModelOrBody),
    ("camera_type", ModelOrBody),
    ("lens", ModelOrBody),
    ("camera", ModelOrBody),
    ("distortion_model", Distortion),
    ("is_fisheye", Is("OPENCV_FISHEYE")),
    ("fisheye", Is("OPENCV_FISHEYE")),
    ("equirectangular", Is("EQUIRECTANGULAR")),
    ("panorama", Is("EQUIRECTANGULAR")),
    ("curve", Curve),
    ("viewport", Viewport),
    ("distance", Distance),
    ("vfov", Vfov),
    ("aperture", Aperture),
    ("focus", Focus),
    ("R", Rotation),
    ("r", Rotation),
    ("rectification_matrix", Rotation),
    // Skewed pixels, thin prisms, tilted sensors, and further terms.
    ("skew", Unknown),
    ("b1", Unknown),
    ("b2", Unknown),
    ("s0", Unknown),
    ("s1", Unknown),
    ("s2", Unknown),
    ("s3", Unknown),
    ("s4", Unknown),
    ("sx1", Unknown),
    ("sy1", Unknown),
    ("tauX", Unknown),
    ("tauY", Unknown),
    ("taux", Unknown),
    ("tauy", Unknown),
    ("tau_x", Unknown),
    ("tau_y", Unknown),
    ("k0", Unknown),
    ("k7", Unknown),
    ("k8", Unknown),
    ("k9", Unknown),
    ("k10", Unknown),
    ("k11", Unknown),
    ("k12", Unknown),
    ("p0", Unknown),
    ("p3", Unknown),
    ("p4", Unknown),
    ("p5", Unknown),
    ("p6", Unknown),
    ("p7", Unknown),
    ("p8", Unknown),
    // Coefficients and principal points of other definitions.
    ("coeffs", Unknown),
    ("radial_distortion", Unknown),
    ("tangential_distortion", Unknown),
    ("disto_k1", Unknown),
    ("disto_k3", Unknown),
    ("disto_t2", Unknown),
    ("c_x", Unknown),
    ("c_y", Unknown),
    ("principal_point", Unknown),
    // Spheres and cones in place of a plane.
    ("xi", Unknown),
    ("alpha", Unknown),
    ("beta", Unknown),
    ("omega", Unknown),
    ("ftheta_p0", Unknown),
    ("ftheta_p1", Unknown),
    ("ftheta_p2", Unknown),
    ("ftheta_p3", Unknown),
    ("ftheta_p4", Unknown),
    ("ftheta_p5", Unknown),
    ("latlong", Unknown),
    ("orthographic", Unknown),
    // Parts of an image, and a moving one.
    ("fisheye_crop_radius", Unknown),
    ("binning_x", Unknown),
    ("binning_y", Unknown),
    ("roi", Unknown),
    ("rolling_shutter", Unknown),
    ("focal", Unclear),
    ("focal_x", Unclear),
    ("focal_y", Unclear),
    ("focal_length", Unclear),
    ("fov", Unclear),
    ("fov_x", Unclear),
    ("fov_y", Unclear),
    ("hfov", Unclear),
];

/// A key of a lens, its value, and where it stands.
#[derive(Debug, Clone, Copy)]
pub(super) struct Given<'a> {
    pub(super) key: &'a str,
    pub(super) meaning: Meaning,
    pub(super) value: &'a Value,
    /// Whether it is of the list, not of the camera.
    is_shared: bool,
}

/// The keys of the lens of a camera: each of the camera itself, else of its list.
pub(super) struct Keys<'a> {
    given: Vec<Given<'a>>,
    file: &'a Place,
    camera: &'a Place,
}

impl<'a> Keys<'a> {
    /// The keys of a camera at `camera`, which is in a list at `file` with keys for all of its cameras.
    pub(super) fn new(
        own: &'a Map<String, Value>,
        camera: &'a Place,
        shared: &'a Map<String, Value>,
        file: &'a Place,
    ) -> Self {
        let (mut given, mut of_list) = (Vec::new(), Vec::new());
        add(own, false, true, &mut given);
        // An object of the camera completes the object of the list; any other value replaces it.
        let is_replaced = |key: &str, value: &Value| {
            own.get(key).is_some_and(|own| !(own.is_null() || own.is_object() && value.is_object()))
        };
        shared.iter().filter(|(key, value)| !is_replaced(key, value)).for_each(|(key, value)| {
            add_key(key, value, true, true, &mut of_list);
        });
        of_list.retain(|one: &Given<'_>| given.iter().all(|own| own.key != one.key));
        given.append(&mut of_list);
        Self { given, file, camera }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Given<'a>> {
        self.given.iter().copied()
    }

    /// A key with this meaning.
    pub(super) fn find(&self, is: impl Fn(Meaning) -> bool) -> Option<Given<'a>> {
        self.iter().find(|given| is(given.meaning))
    }

    /// Words for a key: its name, and the camera or the list that has it.
    pub(super) fn name(&self, given: Given<'_>) -> String {
        let whose = if given.is_shared { "the list" } else { "the camera" };
        format!("`{}` of {whose}", given.key)
    }

    /// The error of a key.
    pub(super) fn wrong(&self, given: Given<'_>, problem: impl Into<String>, mend: impl Into<String>) -> Error {
        let place = if given.is_shared { self.file } else { self.camera };
        Error::scene(field(place, given.key), problem, mend)
    }

    /// The error of a key that the camera lacks.
    pub(super) fn missing(&self, key: &str, problem: impl Into<String>) -> Error {
        Error::scene(field(self.camera, key), problem, MEND)
    }

    /// The error of a key that says otherwise than another one.
    pub(super) fn apart(&self, given: Given<'_>, other: Given<'_>) -> Error {
        let shown = |given: Given<'_>| format!("{} is {}", self.name(given), short(given.value));
        self.wrong(given, format!("{}, but {}", shown(given), shown(other)), "remove the wrong one of the two")
    }

    /// The finite number of a key.
    pub(super) fn number(&self, given: Given<'_>) -> Result<f64> {
        let number = given.value.as_f64().filter(|x| x.is_finite());
        number.ok_or_else(|| self.wrong(given, "expected a finite number", "give it as a number"))
    }

    /// The finite numbers of a key.
    pub(super) fn array<const N: usize>(&self, given: Given<'_>) -> Result<[f64; N]> {
        numbers(given.value).ok_or_else(|| {
            self.wrong(given, format!("expected {N} finite numbers"), format!("give a list of {N} numbers"))
        })
    }

    /// All finite numbers of a key, in an array or in the rows of one; null counts as 0.
    pub(super) fn list(&self, given: Given<'a>) -> Result<Vec<f64>> {
        let row = |value: &'a Value| value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
        let rows = given.value.as_array().into_iter().flatten().flat_map(row);
        let all: Option<Vec<f64>> = rows.map(|x| if x.is_null() { Some(0.0) } else { x.as_f64() }).collect();
        let all = all.filter(|all| given.value.is_array() && all.iter().all(|x| x.is_finite()));
        all.ok_or_else(|| self.wrong(given, "expected finite numbers in a list", "give it as a list of numbers"))
    }
}

/// The place of a field.
pub(super) fn field(place: &Place, key: &str) -> Place {
    let name = place.field.as_ref().map_or_else(|| key.to_owned(), |camera| format!("{camera} {key}"));
    place.clone().named(name)
}

/// Adds the keys of lenses in an object.
fn add<'a>(map: &'a Map<String, Value>, is_shared: bool, is_outer: bool, given: &mut Vec<Given<'a>>) {
    map.iter().for_each(|(key, value)| add_key(key, value, is_shared, is_outer, given));
}

/// Adds a key if it is one of a lens, and the keys of an outer object that describes a lens.
fn add_key<'a>(key: &'a str, value: &'a Value, is_shared: bool, is_outer: bool, given: &mut Vec<Given<'a>>) {
    let known = KEYS.iter().find(|(name, _)| *name == key).map(|(_, meaning)| *meaning);
    let meaning = match (key, known) {
        // The matrices of ROS 2 have names of one small letter, and COLMAP has a single coefficient.
        ("k", _) if !value.is_array() => Radial(0),
        ("k", _) => Matrix,
        ("p" | "r" | "d", _) if !value.is_array() => return,
        (_, Some(meaning)) => meaning,
        (_, None) => return,
    };
    // As ROS and OpenCV write matrices.
    let value = value.get("data").filter(|data| data.is_array()).unwrap_or(value);
    match value {
        Value::Null if meaning != Distance => {}
        Value::Object(inner) if is_outer && matches!(meaning, Matrix | OpenCv | Nerfstudio | ModelOrBody) => {
            add(inner, is_shared, false, given);
        }
        _ => given.push(Given { key, meaning, value, is_shared }),
    }
}

/// Finite numbers in an array of exactly N.
pub(super) fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let items = value.as_array().filter(|items| items.len() == N)?;
    let all: Option<Vec<f64>> = items.iter().map(|item| item.as_f64().filter(|x| x.is_finite())).collect();
    <[f64; N]>::try_from(all?).ok()
}

/// A value in few characters.
fn short(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// docs/film.md names each key once, in the row of what becomes of it.
    #[test]
    fn the_documentation_has_every_key_of_a_lens() {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
        let page = fs::read_to_string(format!("{root}/docs/film.md")).expect("docs/film.md");
        let table = page.split("| keys of a lens |").nth(1).expect("the table of keys");
        let rows: Vec<&str> = table.lines().skip(1).take_while(|line| line.starts_with('|')).collect();
        let named = |row: &str| -> Vec<String> {
            let cell = row.split('|').nth(1).unwrap_or_default();
            cell.split('`').skip(1).step_by(2).map(str::to_owned).collect()
        };
        let all: Vec<String> = rows.iter().flat_map(|row| named(row)).collect();
        for (key, meaning) in KEYS {
            let row = rows.iter().find(|row| named(row).iter().any(|name| name == key)).copied();
            let row = row.unwrap_or_else(|| panic!("docs/film.md has no row for `{key}`"));
            assert_eq!(row.contains("refused if"), matches!(meaning, Unknown | Unclear | Rotation), "{row}");
        }
        let known = |name: &String| name == "k" || KEYS.iter().any(|(key, _)| key == name);
        assert_eq!(all.iter().find(|name| !known(name)), None, "docs/film.md names a key that is none");
    }
}
