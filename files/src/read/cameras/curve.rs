//! Lenses with distortion, fisheyes and panoramas in lists of cameras: by the coefficients of OpenCV and the names of models of COLMAP and
//! nerfstudio.

use halfline::error::Error;
use halfline::scene::camera::Curve;
use serde_json::{Map, Value};

/// The keys of coefficients.
const RADIAL: [&str; 6] = ["k1", "k2", "k3", "k4", "k5", "k6"];
const TANGENTIAL: [&str; 2] = ["p1", "p2"];

/// The keys of lists of coefficients in the order of OpenCV: k1, k2, p1, p2, k3, k4, k5, k6.
const LISTS: [&str; 5] = ["distortion", "distortion_coefficients", "dist_coeffs", "dist", "D"];

/// The key of nerfstudio's list: k1, k2, k3, k4, p1, p2.
const NERFSTUDIO: &str = "distortion_params";

/// The models of perspective lenses, of fisheyes and of panoramas, in capitals.
const PERSPECTIVE: [&str; 7] =
    ["PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV", "FULL_OPENCV", "PERSPECTIVE"];
const FISHEYES: [&str; 4] = ["OPENCV_FISHEYE", "RADIAL_FISHEYE", "SIMPLE_RADIAL_FISHEYE", "FISHEYE"];
const PANORAMAS: [&str; 2] = ["EQUIRECTANGULAR", "PANORAMA"];

/// A key of a camera whose value is wrong, the problem and the mend.
pub(super) struct CurveProblem {
    pub(super) key: String,
    pub(super) problem: String,
    pub(super) mend: &'static str,
}

fn wrong<T>(key: &str, problem: impl Into<String>, mend: &'static str) -> Result<T, CurveProblem> {
    Err(CurveProblem { key: key.to_owned(), problem: problem.into(), mend })
}

/// The curve of a camera of a list; `None` for a pinhole.
///
/// # Errors
/// The key and the problem of an unknown model, and of coefficients that are no numbers or mean different things in different programs.
pub(super) fn curve(camera: &Map<String, Value>) -> Result<Option<Curve>, CurveProblem> {
    if let Some(value) = camera.get("curve") {
        return match serde_json::from_value(value.clone()) {
            Ok(curve) => Ok(Some(curve)),
            Err(error) => wrong("curve", error.to_string(), "give it as halfline writes it in cameras.json"),
        };
    }
    let model = model(camera)?;
    if PANORAMAS.contains(&&model[..]) {
        return Ok(Some(Curve::Panorama));
    }
    let is_fisheye = FISHEYES.contains(&&model[..]) || camera.get("is_fisheye") == Some(&Value::Bool(true));
    let (k, p) = coefficients(camera, is_fisheye)?;
    if is_fisheye {
        let [k1, k2, k3, k4, rest @ ..] = k;
        return match rest.iter().chain(&p).all(|x| *x == 0.0) {
            true => Ok(Some(Curve::Fisheye { k: [k1, k2, k3, k4] })),
            false => wrong("p1", "a fisheye has the coefficients k1 to k4 alone", "remove k5, k6, p1 and p2"),
        };
    }
    if k[3] != 0.0 && k[4..] == [0.0; 2] && model != "FULL_OPENCV" && !LISTS.iter().any(|key| camera.contains_key(*key))
    {
        let problem = "k4 is a divisor in OpenCV and a factor of r^8 in nerfstudio";
        return wrong(
            "k4",
            problem,
            "add \"camera_model\": \"FULL_OPENCV\" for OpenCV's, or refit the lens without k4",
        );
    }
    Ok((k != [0.0; 6] || p != [0.0; 2]).then_some(Curve::Distorted { k, p }))
}

/// The name of the model in capitals; empty where the camera has none.
fn model(camera: &Map<String, Value>) -> Result<String, CurveProblem> {
    let named = ["camera_model", "model"].into_iter().find_map(|key| Some((key, camera.get(key)?.as_str()?)));
    let Some((key, name)) = named else { return Ok(String::new()) };
    let model = name.to_ascii_uppercase();
    // `model` may be that of a camera body.
    let is_lens = key == "camera_model" || model.contains("FISHEYE");
    let known = PERSPECTIVE.iter().chain(&FISHEYES).chain(&PANORAMAS);
    if is_lens && !known.clone().any(|known| *known == model) {
        let problem = format!("the lens has the model {name:?}");
        return wrong(
            key,
            problem,
            "use PINHOLE, OPENCV, FULL_OPENCV, OPENCV_FISHEYE or EQUIRECTANGULAR, or undistort the images",
        );
    }
    Ok(model)
}

/// k1 to k6, and p1 and p2; 0 where they are not given.
fn coefficients(camera: &Map<String, Value>, is_fisheye: bool) -> Result<([f64; 6], [f64; 2]), CurveProblem> {
    let number = |key: &str, value: &Value| match value.as_f64().or(value.is_null().then_some(0.0)) {
        Some(x) if x.is_finite() => Ok(x),
        _ => wrong(key, "expected a finite number", "give the coefficient as a number"),
    };
    let (mut k, mut p) = ([0.0; 6], [0.0; 2]);
    for (keys, values) in [(&RADIAL[..], &mut k[..]), (&TANGENTIAL, &mut p)] {
        for (key, x) in keys.iter().zip(values) {
            *x = camera.get(*key).map_or(Ok(0.0), |value| number(key, value))?;
        }
    }
    let Some((key, Value::Array(list))) = LISTS.iter().chain([&NERFSTUDIO]).find_map(|key| camera.get_key_value(*key))
    else {
        return Ok((k, p));
    };
    let list: Vec<f64> = list.iter().map(|value| number(key, value)).collect::<Result<_, _>>()?;
    if is_fisheye || key != NERFSTUDIO {
        return in_opencv_order(&list, is_fisheye).or_else(|problem| wrong(key, problem, FEWER));
    }
    let at = |n: usize| list.get(n).copied().unwrap_or(0.0);
    match at(3) {
        0.0 => Ok(([at(0), at(1), at(2), 0.0, 0.0, 0.0], [at(4), at(5)])),
        _ => wrong(key, "k4, a factor of r^8, is not modelled", "refit the lens without k4"),
    }
}

const FEWER: &str = "refit the lens with fewer coefficients";

/// k1 to k6, and p1 and p2, of a list in the order of OpenCV, whose end may be left out: k1, k2, p1, p2, k3, k4, k5, k6; of a fisheye k1
/// to k4.
fn in_opencv_order(list: &[f64], is_fisheye: bool) -> Result<([f64; 6], [f64; 2]), String> {
    let at = |n: usize| list.get(n).copied().unwrap_or(0.0);
    let used = if is_fisheye { 4 } else { 8 };
    if list.iter().skip(used).any(|x| *x != 0.0) {
        return Err(format!("more than {used} coefficients are not modelled"));
    }
    Ok(match is_fisheye {
        true => ([at(0), at(1), at(2), at(3), 0.0, 0.0], [0.0; 2]),
        false => ([at(0), at(1), at(4), at(5), at(6), at(7)], [at(2), at(3)]),
    })
}

/// The curve of coefficients in the order of OpenCV; `None` for a pinhole.
///
/// # Errors
/// [`Error::Settings`] for more coefficients than a model has.
pub fn curve_of(coefficients: &[f64], is_fisheye: bool) -> halfline::Result<Option<Curve>> {
    let (k, p) = in_opencv_order(coefficients, is_fisheye).map_err(|problem| Error::settings(problem, FEWER))?;
    let [k1, k2, k3, k4, ..] = k;
    Ok(match is_fisheye {
        true => Some(Curve::Fisheye { k: [k1, k2, k3, k4] }),
        false => (k != [0.0; 6] || p != [0.0; 2]).then_some(Curve::Distorted { k, p }),
    })
}
