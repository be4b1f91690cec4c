//! Cameras in JSON: a list, or an object with `frames` (NeRF), `cameras` or `poses`.

use super::keyed::{self, KeyedLens};
use super::keys::{Keys, MEND, field, numbers};
use super::listed::ListedCamera;
use halfline::error::{Error, Place, Result};
use halfline::scene::camera::Look;
use serde_json::{Map, Value};

/// The keys of lists, in order of preference.
const LISTS: [&str; 3] = ["frames", "cameras", "poses"];

/// The keys of matrices from camera to world, and whether their axes are OpenCV's.
const MATRICES: [(&str, bool); 4] =
    [("transform_matrix", false), ("pose", true), ("world_from_camera", true), ("camera_to_world", true)];

/// An object of the file, for errors.
struct Object<'a> {
    map: &'a Map<String, Value>,
    place: &'a Place,
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
    let one = |(n, value): (usize, &Value)| {
        let place = file.clone().named(format!("camera {n}"));
        let Value::Object(map) = value else { return Err(Error::scene(place, "expected an object", MEND)) };
        let KeyedLens { size, plain, pixels, aperture } = keyed::lens(&Keys::new(map, &place, shared, file))?;
        let pose = Object { map, place: &place }.pose()?;
        let camera = plain.map_or(pose, |lens| pose.with_lens(lens));
        Ok(ListedCamera { size, intrinsics: pixels, aperture, ..camera })
    };
    list.iter().enumerate().map(one).collect()
}

impl Object<'_> {
    fn fail(&self, key: &str, problem: &str) -> Error {
        Error::scene(field(self.place, key), problem, MEND)
    }

    fn numbers(&self, key: &str) -> Result<Option<[f64; 3]>> {
        self.map
            .get(key)
            .map(|value| numbers(value).ok_or_else(|| self.fail(key, "expected finite numbers")))
            .transpose()
    }

    /// The camera without a lens.
    fn pose(&self) -> Result<ListedCamera> {
        for (key, opencv) in MATRICES {
            let Some(value) = self.map.get(key) else { continue };
            let rows: Option<Vec<[f64; 4]>> = value.as_array().and_then(|rows| rows.iter().map(numbers).collect());
            return match rows.as_deref() {
                Some([a, b, c] | [a, b, c, [0.0, 0.0, 0.0, 1.0]]) => ListedCamera::of_matrix([*a, *b, *c], opencv)
                    .map_err(|(problem, mend)| Error::scene(field(self.place, key), problem, mend)),
                _ => Err(self.fail(key, "expected a 4 x 4 matrix whose last row is 0, 0, 0, 1")),
            };
        }
        let need = |key: &str| self.numbers(key)?.ok_or_else(|| self.fail(key, "missing"));
        let eye = need("eye")?;
        let look = match self.numbers("at")? {
            Some(at) => Look::At(at.into()),
            None => Look::View(need("view")?.into()),
        };
        Ok(ListedCamera::new(eye, look, need("up")?))
    }
}
