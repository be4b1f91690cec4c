//! Cameras in JSON: a list, or an object with `frames` (NeRF), `cameras` or `poses`.

use super::curve::curve;
use super::lens::PixelLens;
use super::listed::ListedCamera;
use halfline::error::{Error, Place, Result};
use halfline::scene::camera::{Curve, Intrinsics, Lens, Look};
use serde_json::{Map, Value};

/// The keys of lists, in order of preference.
const LISTS: [&str; 3] = ["frames", "cameras", "poses"];

/// The keys of matrices from camera to world, and whether their axes are OpenCV's.
const MATRICES: [(&str, bool); 4] =
    [("transform_matrix", false), ("pose", true), ("world_from_camera", true), ("camera_to_world", true)];

const MEND: &str = "give each camera eye, view or at, and up; or transform_matrix (NeRF); or pose, a 4 x 4 matrix from camera to world";

/// An object of the file, for errors.
struct Object<'a> {
    map: &'a Map<String, Value>,
    place: Place,
}

pub(super) fn read(bytes: &[u8], file: &Place) -> Result<Vec<ListedCamera>> {
    let value: Value = serde_json::from_slice(bytes).map_err(|e| {
        Error::scene(file.clone().at(e.line() as u64, e.column() as u64), e.to_string(), "correct the JSON there")
    })?;
    let empty = Map::new();
    let (list, shared) = match &value {
        Value::Array(list) => (list, &empty),
        Value::Object(map) => {
            let list = LISTS.iter().find_map(|key| map.get(*key)?.as_array());
            (
                list.ok_or_else(|| Error::scene(file.clone(), "no list of cameras (frames, cameras or poses)", MEND))?,
                map,
            )
        }
        _ => return Err(Error::scene(file.clone(), "no list of cameras", MEND)),
    };
    let shared = Object { map: shared, place: file.clone() };
    let (intrinsics, size, shared_curve) = (shared.intrinsics()?, shared.size()?, shared.curve()?);
    let one = |(n, value): (usize, &Value)| {
        let place = file.clone().named(format!("camera {n}"));
        let Value::Object(map) = value else { return Err(Error::scene(place, "expected an object", MEND)) };
        let object = Object { map, place };
        let mut camera = object.camera()?;
        camera.size = object.size()?.or(size);
        let (own, curve) = (object.intrinsics()?, object.curve()?.or(shared_curve));
        let panorama = (curve == Some(Curve::Panorama)).then(PixelLens::default);
        let lens = panorama.or(own).or(intrinsics.filter(|_| !camera.has_lens));
        camera.intrinsics = lens.map(|lens| PixelLens { image: camera.size, curve, ..lens });
        if curve.is_some() {
            // A viewport is that of a pinhole.
            camera.has_lens = false;
            if lens.is_none() {
                return Err(object.fail("fl_x", "a lens with distortion has no focal lengths"));
            }
        }
        // A viewport has the principal point in its middle.
        if own.is_some_and(|own| camera.size.is_some_and(|size| !own.is_centred(size))) {
            camera.has_lens = false;
        }
        Ok(camera)
    };
    list.iter().enumerate().map(one).collect()
}

impl Object<'_> {
    fn fail(&self, key: &str, problem: &str) -> Error {
        Error::scene(self.field(key), problem, MEND)
    }

    /// The place of a field.
    fn field(&self, key: &str) -> Place {
        let field = match &self.place.field {
            Some(camera) => format!("{camera} {key}"),
            None => key.to_owned(),
        };
        self.place.clone().named(field)
    }

    fn number(&self, key: &str) -> Result<Option<f64>> {
        let Some(value) = self.map.get(key) else { return Ok(None) };
        let number = value.as_f64().filter(|x| x.is_finite());
        number.map(Some).ok_or_else(|| self.fail(key, "expected a finite number"))
    }

    fn numbers<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>> {
        self.map
            .get(key)
            .map(|value| numbers(value).ok_or_else(|| self.fail(key, "expected finite numbers")))
            .transpose()
    }

    /// Two numbers, each under one of two names; one of them alone is an error.
    fn both(&self, first: [&str; 2], second: [&str; 2]) -> Result<Option<[f64; 2]>> {
        let of = |names: [&str; 2]| Ok::<_, Error>(self.number(names[0])?.or(self.number(names[1])?));
        match (of(first)?, of(second)?) {
            (Some(a), Some(b)) => Ok(Some([a, b])),
            (None, None) => Ok(None),
            (Some(_), None) => Err(self.fail(second[0], &format!("missing beside {}", first[0]))),
            (None, Some(_)) => Err(self.fail(first[0], &format!("missing beside {}", second[0]))),
        }
    }

    fn size(&self) -> Result<Option<[u32; 2]>> {
        let sides = match self.numbers::<2>("size")? {
            Some(sides) => Some(sides),
            None => self.both(["w", "width"], ["h", "height"])?,
        };
        let side = |x: f64| Some(x as u32).filter(|side| *side > 0 && f64::from(*side) == x);
        let whole = |[w, h]: [f64; 2]| side(w).zip(side(h)).map(|(w, h)| [w, h]);
        sides.map(|sides| whole(sides).ok_or_else(|| self.fail("size", "expected whole positive numbers"))).transpose()
    }

    /// The curve of the lens, also of one that `intrinsics` describes; `None` for a pinhole.
    fn curve(&self) -> Result<Option<Curve>> {
        let inner = self.map.get("intrinsics").and_then(Value::as_object);
        let of = |map| curve(map).map_err(|wrong| Error::scene(self.field(&wrong.key), wrong.problem, wrong.mend));
        Ok(of(self.map)?.or(inner.map_or(Ok(None), of)?))
    }

    /// Focal lengths under the names of NeRF, of OpenCV (`K`) and of halfline (`intrinsics`).
    fn intrinsics(&self) -> Result<Option<PixelLens>> {
        if let Some(value) = self.map.get("K") {
            let rows: Option<Vec<[f64; 3]>> = value.as_array().and_then(|rows| rows.iter().map(numbers).collect());
            let Some([[fx, skew, cx], [low, fy, cy], [0.0, 0.0, 1.0]]) = rows.as_deref() else {
                return Err(self.fail("K", "expected a 3 x 3 matrix whose last row is 0, 0, 1"));
            };
            if [*skew, *low] != [0.0; 2] {
                return Err(self.fail("K", "a skewed image cannot be rendered"));
            }
            return Ok(Some(PixelLens::of(Intrinsics { fx: *fx, fy: *fy, cx: *cx, cy: *cy })));
        }
        if let Some(Value::Object(map)) = self.map.get("intrinsics") {
            let inner = Object { map, place: self.place.clone().named("intrinsics") };
            return inner.intrinsics();
        }
        let either = |a: &str, b: &str| Ok::<_, Error>(self.number(a)?.or(self.number(b)?));
        let focal = [either("fl_x", "fx")?, either("fl_y", "fy")?];
        let angles = [self.number("camera_angle_x")?, self.number("camera_angle_y")?];
        let center = self.both(["cx"; 2], ["cy"; 2])?;
        let is_given = focal.iter().chain(&angles).any(Option::is_some);
        Ok(is_given.then_some(PixelLens { focal, angles, center, ..PixelLens::default() }))
    }

    fn camera(&self) -> Result<ListedCamera> {
        for (key, opencv) in MATRICES {
            let Some(value) = self.map.get(key) else { continue };
            let rows: Option<Vec<[f64; 4]>> = value.as_array().and_then(|rows| rows.iter().map(numbers).collect());
            return match rows.as_deref() {
                Some([a, b, c] | [a, b, c, [0.0, 0.0, 0.0, 1.0]]) => ListedCamera::of_matrix([*a, *b, *c], opencv)
                    .map_err(|(problem, mend)| Error::scene(self.field(key), problem, mend)),
                _ => Err(self.fail(key, "expected a 4 x 4 matrix whose last row is 0, 0, 0, 1")),
            };
        }
        let need = |key: &str| self.numbers::<3>(key)?.ok_or_else(|| self.fail(key, "missing"));
        let eye = need("eye")?;
        let look = match self.numbers::<3>("at")? {
            Some(at) => Look::At(at.into()),
            None => Look::View(need("view")?.into()),
        };
        let camera = ListedCamera::new(eye, look, need("up")?);
        if let Some([vw, vh]) = self.numbers::<2>("viewport")? {
            return Ok(camera.with_lens(match self.map.get("distance") {
                Some(Value::Null) => Lens::Orthographic { height: vh },
                _ => Lens::Viewport { vw, vh, distance: self.number("distance")?.unwrap_or(1.0) },
            }));
        }
        let vfov = self.number("vfov")?.map(|degrees| Lens::Vfov { degrees, distance: 1.0 });
        Ok(vfov.map_or(camera, |lens| camera.with_lens(lens)))
    }
}

/// Finite numbers in an array of exactly N.
fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let items = value.as_array().filter(|items| items.len() == N)?;
    let all: Option<Vec<f64>> = items.iter().map(|item| item.as_f64().filter(|x| x.is_finite())).collect();
    <[f64; N]>::try_from(all?).ok()
}
