//! Lenses with distortion, fisheyes and panoramas in lists of cameras: by the coefficients of OpenCV and the names of models.

use super::keys::{Given, Keys, Meaning};
use halfline::error::{Error, Result};
use halfline::scene::camera::Curve;

/// The kind of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Perspective,
    Fisheye,
    Panorama,
}

use Kind::{Fisheye, Panorama, Perspective};

/// The models that are known, in capitals, and their numbers in the order of COLMAP: coefficients that a model does not name it does not have.
/// Without numbers it may have all of its kind.
const MODELS: [(&str, Kind, &[&str]); 24] = [
    ("PINHOLE", Perspective, &["fx", "fy", "cx", "cy"]),
    ("SIMPLE_PINHOLE", Perspective, &["f", "cx", "cy"]),
    ("SIMPLE_RADIAL", Perspective, &["f", "cx", "cy", "k1"]),
    ("RADIAL", Perspective, &["f", "cx", "cy", "k1", "k2"]),
    ("FULL_OPENCV", Perspective, &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]),
    ("OPENCV_FISHEYE", Fisheye, &["fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"]),
    ("RADIAL_FISHEYE", Fisheye, &["f", "cx", "cy", "k1", "k2"]),
    ("SIMPLE_RADIAL_FISHEYE", Fisheye, &["f", "cx", "cy", "k1"]),
    ("SIMPLE_FISHEYE", Fisheye, &["f", "cx", "cy"]),
    // nerfstudio's, which also has k3.
    ("OPENCV", Perspective, &[]),
    ("PERSPECTIVE", Perspective, &[]),
    ("FISHEYE", Fisheye, &[]),
    // Models of ROS and of Kalibr.
    ("NONE", Perspective, &["fx", "fy", "cx", "cy"]),
    ("PLUMB_BOB", Perspective, &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"]),
    ("RADTAN", Perspective, &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"]),
    ("RATIONAL_POLYNOMIAL", Perspective, &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]),
    ("EQUIDISTANT", Fisheye, &[]),
    ("EQUI", Fisheye, &[]),
    ("KANNALA_BRANDT", Fisheye, &[]),
    ("KANNALA_BRANDT4", Fisheye, &[]),
    ("FISHEYE_OPENCV", Fisheye, &[]),
    ("EQUIRECTANGULAR", Panorama, &[]),
    ("PANORAMA", Panorama, &[]),
    ("SPHERICAL", Panorama, &[]),
];

/// Other models, which are refused also where the name may belong to a body.
const OTHERS: [&str; 22] = [
    "FOV",
    "THIN_PRISM",
    "THIN_PRISM_FISHEYE",
    "RAD_TAN_THIN_PRISM_FISHEYE",
    "DIVISION",
    "SIMPLE_DIVISION",
    "UCM",
    "EUCM",
    "MEI",
    "DS",
    "DOUBLE_SPHERE",
    "OMNI",
    "OMNIDIRECTIONAL",
    "ORTHOGRAPHIC",
    "ORTHOPHOTO",
    "CYLINDRICAL",
    "FTHETA",
    "DUAL",
    "BROWN",
    "VR180",
    "VR180_L",
    "VR180_R",
];

const MODEL: &str = "use PINHOLE, OPENCV, FULL_OPENCV, OPENCV_FISHEYE or EQUIRECTANGULAR, or undistort the images";

const FEWER: &str = "refit the lens with fewer coefficients";

/// The names of coefficients: k1 to k6, p1 and p2.
const COEFFICIENTS: [&str; 8] = ["k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"];

/// The places of coefficients in the order of OpenCV and of nerfstudio.
const OPENCV: [usize; 8] = [0, 1, 6, 7, 2, 3, 4, 5];
const NERFSTUDIO: [usize; 6] = [0, 1, 2, 3, 6, 7];

/// A model that a key names, or a flag that is set or not.
struct Named<'a> {
    given: Given<'a>,
    kind: Kind,
    numbers: &'static [&'static str],
    /// The flag says that the lens is none of this kind.
    is_denied: bool,
}

/// The model of a lens by all of its keys.
pub(super) struct Model<'a> {
    named: Vec<Named<'a>>,
}

impl<'a> Model<'a> {
    /// # Errors
    /// The key of a model that is not known, and of one that contradicts another.
    pub(super) fn of(keys: &Keys<'a>) -> Result<Self> {
        let mut named: Vec<Named<'a>> = Vec::new();
        for given in keys.iter() {
            let found = match given.meaning {
                Meaning::Model | Meaning::ModelOrBody | Meaning::Distortion => known(keys, given)?,
                Meaning::Is(model) => Some((flag(keys, given)?, model)).map(|(is_set, model)| {
                    let kind = if model == "OPENCV_FISHEYE" { Fisheye } else { Panorama };
                    Named { given, kind, numbers: &[], is_denied: !is_set }
                }),
                _ => None,
            };
            named.extend(found);
        }
        // A lens of Kalibr and of ROS is a pinhole with a model of distortion.
        if named.iter().any(|one| one.given.meaning == Meaning::Distortion) {
            named.retain(|one| one.given.value.as_str().is_none_or(|name| !name.eq_ignore_ascii_case("pinhole")));
        }
        for one in &named {
            let apart = |other: &&Named<'_>| match (one.is_denied, other.is_denied) {
                (false, false) => one.kind != other.kind,
                (true, false) => one.kind == other.kind,
                _ => false,
            };
            if let Some(other) = named.iter().find(apart) {
                return Err(keys.apart(one.given, other.given));
            }
        }
        named.retain(|one| !one.is_denied);
        Ok(Self { named })
    }

    fn kind(&self) -> Kind {
        self.named.first().map_or(Perspective, |one| one.kind)
    }

    /// Whether the lens is a panorama.
    pub(super) fn is_panorama(&self) -> bool {
        self.kind() == Panorama
    }

    /// The names of the numbers of a lens in the order of its model in COLMAP.
    pub(super) fn params(&self) -> Option<&'static [&'static str]> {
        let of = |one: &Named<'_>| match one.given.value.as_str() {
            Some(name) if name.eq_ignore_ascii_case("opencv") => {
                Some(&["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"][..])
            }
            _ => Some(one.numbers).filter(|numbers| !numbers.is_empty()),
        };
        self.named.iter().find_map(of)
    }

    /// The curve of the lens; `None` for a pinhole. `params` are the numbers of a list in the order of the model.
    ///
    /// # Errors
    /// The key and the problem of coefficients that are no numbers, that the model does not have, that contradict each other, or that
    /// mean different things in different programs.
    pub(super) fn curve(&self, keys: &Keys<'a>, params: &[(&'static str, f64, Given<'a>)]) -> Result<Option<Curve>> {
        let mut found: [Option<(f64, Given<'a>)>; 8] = [None; 8];
        let mut put = |place: usize, x: f64, given: Given<'a>| match found[place] {
            Some((known, other)) if known != x => Err(keys.apart(given, other)),
            _ => {
                found[place] = Some((x, given));
                Ok(())
            }
        };
        for given in keys.iter() {
            match given.meaning {
                Meaning::Radial(n) => put(n, keys.number(given)?, given)?,
                Meaning::Tangential(n) => put(6 + n, keys.number(given)?, given)?,
                Meaning::OpenCv | Meaning::Nerfstudio => {
                    let list = keys.list(given)?;
                    let order = match given.meaning {
                        _ if self.kind() == Fisheye => &[0, 1, 2, 3][..],
                        Meaning::OpenCv => &OPENCV,
                        _ => &NERFSTUDIO,
                    };
                    check_length(&list, order, given.meaning)
                        .map_err(|(problem, mend)| keys.wrong(given, problem, mend))?;
                    order.iter().zip(&list).try_for_each(|(place, x)| put(*place, *x, given))?;
                }
                _ => {}
            }
        }
        for (name, x, given) in params {
            if let Some(place) = COEFFICIENTS.iter().position(|known| known == name) {
                put(place, *x, *given)?;
            }
        }
        self.made(keys, found)
    }

    /// The curve of coefficients.
    fn made(&self, keys: &Keys<'a>, found: [Option<(f64, Given<'a>)>; 8]) -> Result<Option<Curve>> {
        let own = keys.find(|meaning| meaning == Meaning::Curve);
        for (place, name) in COEFFICIENTS.iter().enumerate() {
            let Some((x, given)) = found[place].filter(|(x, _)| *x != 0.0) else { continue };
            if let Some(curve) = own {
                return Err(keys.apart(given, curve));
            }
            let lacks = |one: &&Named<'_>| match one.kind {
                Panorama => true,
                Fisheye if place > 3 => true,
                _ => !one.numbers.is_empty() && !one.numbers.contains(name),
            };
            if let Some(one) = self.named.iter().find(lacks) {
                let problem = format!("{name} is {x}, which the model {} does not have", one.given.value);
                return Err(keys.wrong(given, problem, format!("remove it, or correct {}", keys.name(one.given))));
            }
        }
        if let Some(curve) = own {
            if let Some(one) = self.named.first() {
                return Err(keys.apart(one.given, curve));
            }
            let read = serde_json::from_value(curve.value.clone());
            return read.map(Some).map_err(|error| {
                keys.wrong(curve, error.to_string(), "give it as halfline writes it in cameras.json")
            });
        }
        let [k1, k2, k3, k4, k5, k6, p1, p2] = found.map(|one| one.map_or(0.0, |(x, _)| x));
        if let (Perspective, Some((_, given)), [0.0, 0.0]) =
            (self.kind(), found[3].filter(|(x, _)| *x != 0.0), [k5, k6])
        {
            let is_opencv =
                given.meaning == Meaning::OpenCv || self.named.iter().any(|one| one.numbers.contains(&"k4"));
            if !is_opencv {
                let problem = "k4 is a divisor in OpenCV and a factor of r^8 in nerfstudio";
                let mend = "add \"camera_model\": \"FULL_OPENCV\" for OpenCV's, or refit the lens without k4";
                return Err(keys.wrong(given, problem, mend));
            }
        }
        Ok(match self.kind() {
            Panorama => Some(Curve::Panorama),
            Fisheye => Some(Curve::Fisheye { k: [k1, k2, k3, k4] }),
            Perspective => distorted([k1, k2, k3, k4, k5, k6], [p1, p2]),
        })
    }
}

/// The model that a key names; `None` for the name of a body.
fn known<'a>(keys: &Keys<'a>, given: Given<'a>) -> Result<Option<Named<'a>>> {
    let is_body = given.meaning == Meaning::ModelOrBody;
    let Some(name) = given.value.as_str() else {
        return match is_body {
            true => Ok(None),
            false => Err(keys.wrong(given, "expected the name of a model", MODEL)),
        };
    };
    let model = name.trim().to_ascii_uppercase();
    match MODELS.iter().find(|(known, ..)| *known == model) {
        Some((_, kind, numbers)) => Ok(Some(Named { given, kind: *kind, numbers, is_denied: false })),
        None if is_body && !OTHERS.contains(&&model[..]) && !model.contains("FISHEYE") => Ok(None),
        None => Err(keys.wrong(given, format!("the lens has the model {name:?}"), MODEL)),
    }
}

/// A truth, also in words.
fn flag(keys: &Keys<'_>, given: Given<'_>) -> Result<bool> {
    let words = given.value.as_str().map_or_else(|| given.value.to_string(), str::to_ascii_lowercase);
    match words.trim() {
        "true" | "1" | "yes" => Ok(true),
        "false" | "0" | "no" | "" => Ok(false),
        _ => Err(keys.wrong(given, "expected true or false", "give it without quotes")),
    }
}

/// Checks that what a list has beyond its order is 0.
fn check_length(list: &[f64], order: &[usize], of: Meaning) -> std::result::Result<(), (String, &'static str)> {
    if list.iter().skip(order.len()).any(|x| *x != 0.0) {
        return Err((format!("more than {} coefficients are not modelled", order.len()), FEWER));
    }
    if of == Meaning::Nerfstudio && order.len() > 4 && list.get(3).is_some_and(|k4| *k4 != 0.0) {
        return Err(("k4, a factor of r^8, is not modelled".to_owned(), "refit the lens without k4"));
    }
    let is_odd = of == Meaning::OpenCv && order.len() > 4 && matches!(list.len(), 6 | 7);
    if is_odd && list.iter().any(|x| *x != 0.0) {
        let problem = format!("{} coefficients are no list of OpenCV, which has 4, 5, 8, 12 or 14", list.len());
        return Err((problem, "use distortion_params for nerfstudio's k1, k2, k3, k4, p1, p2"));
    }
    Ok(())
}

/// The curve of coefficients of a perspective lens; `None` for a pinhole.
fn distorted(k: [f64; 6], p: [f64; 2]) -> Option<Curve> {
    (k != [0.0; 6] || p != [0.0; 2]).then_some(Curve::Distorted { k, p })
}

/// The curve of coefficients in the order of OpenCV, whose end may be left out; `None` for a pinhole.
///
/// # Errors
/// [`Error::Settings`] for more coefficients than a model has.
pub fn curve_of(coefficients: &[f64], is_fisheye: bool) -> Result<Option<Curve>> {
    let order = if is_fisheye { &[0, 1, 2, 3][..] } else { &OPENCV };
    check_length(coefficients, order, Meaning::OpenCv).map_err(|(problem, mend)| Error::settings(problem, mend))?;
    let mut all = [0.0; 8];
    order.iter().zip(coefficients).for_each(|(place, x)| all[*place] = *x);
    let [k1, k2, k3, k4, k5, k6, p1, p2] = all;
    Ok(match is_fisheye {
        true => Some(Curve::Fisheye { k: [k1, k2, k3, k4] }),
        false => distorted([k1, k2, k3, k4, k5, k6], [p1, p2]),
    })
}
