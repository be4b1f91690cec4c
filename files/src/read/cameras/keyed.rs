//! The lens of a camera of a list by its keys. Keys that say one thing agree; else the camera is refused.

use super::curve::Model;
use super::keys::{Given, Keys, MEND, Meaning};
use super::lens::{PixelLens, is_near};
use halfline::error::Result;
use halfline::scene::camera::{Aperture, Curve, Lens};
use serde_json::Value;

/// A number and the key that gives it.
type Slot<'a> = Option<(f64, Given<'a>)>;

/// The largest relative difference of numbers that are one, written with few digits.
const SAME: f64 = 1e-4;

/// The lens that keys describe.
#[derive(Debug, Default)]
pub(super) struct KeyedLens {
    /// Columns and rows of the image.
    pub(super) size: Option<[u32; 2]>,
    /// A lens by a viewport or an angle alone.
    pub(super) plain: Option<Lens>,
    /// A lens in pixels.
    pub(super) pixels: Option<PixelLens>,
    /// The lens's own size, where it has one.
    pub(super) aperture: Option<Aperture>,
}

/// The numbers of a lens across and down.
struct Numbers<'a, 'k> {
    keys: &'k Keys<'a>,
    focal: [Slot<'a>; 2],
    angles: [Slot<'a>; 2],
    center: [Slot<'a>; 2],
    sides: [Slot<'a>; 2],
    /// Coefficients among the numbers of a model.
    params: Vec<(&'static str, f64, Given<'a>)>,
}

/// The lens of a camera.
///
/// # Errors
/// The key that is wrong, that is not known, or that contradicts another one.
pub(super) fn lens(keys: &Keys<'_>) -> Result<KeyedLens> {
    let model = Model::of(keys)?;
    let mut numbers =
        Numbers { keys, focal: [None; 2], angles: [None; 2], center: [None; 2], sides: [None; 2], params: Vec::new() };
    for given in keys.iter() {
        numbers.take(given, &model)?;
    }
    let curve = model.curve(keys, &numbers.params)?;
    numbers.lens(curve, model.is_panorama())
}

impl<'a> Numbers<'a, '_> {
    /// Takes the numbers of a key.
    fn take(&mut self, given: Given<'a>, model: &Model<'a>) -> Result<()> {
        let keys = self.keys;
        match given.meaning {
            Meaning::Focal(axes) => {
                let x = keys.number(given)?;
                axes.iter().try_for_each(|axis| put(keys, &mut self.focal[*axis], x, given))
            }
            Meaning::Radians(axis) => put(keys, &mut self.angles[axis], keys.number(given)?, given),
            Meaning::Degrees(axis) => put(keys, &mut self.angles[axis], keys.number(given)?.to_radians(), given),
            Meaning::Center(axis) => put(keys, &mut self.center[axis], keys.number(given)?, given),
            Meaning::Side(axis) => put(keys, &mut self.sides[axis], whole(keys, given, keys.number(given)?)?, given),
            Meaning::Size => {
                let sides = keys.array::<2>(given)?;
                [0, 1]
                    .into_iter()
                    .try_for_each(|axis| put(keys, &mut self.sides[axis], whole(keys, given, sides[axis])?, given))
            }
            Meaning::Matrix => self.matrix(given),
            Meaning::Params => self.params(given, model),
            Meaning::Rotation => {
                let list = keys.list(given)?;
                let is_one = |n: usize, x: f64| (x - f64::from(u8::from(n.is_multiple_of(4)))).abs() < SAME;
                if list.iter().all(|x| *x == 0.0)
                    || list.len() == 9 && list.iter().enumerate().all(|(n, x)| is_one(n, *x))
                {
                    return Ok(());
                }
                let problem = "a rotation of the image, as of ROS's rectified ones, is not modelled";
                Err(keys.wrong(given, problem, "remove it: the pose of a camera gives its rotation"))
            }
            Meaning::Unknown if !is_nothing(given) => {
                let problem = format!("{} is {}, and lenses have no such part here", keys.name(given), given.value);
                Err(keys.wrong(given, problem, "refit the lens without it, or undistort the images and remove it"))
            }
            _ => Ok(()),
        }
    }

    /// Takes a matrix of intrinsics, or fx, fy, cx, cy.
    fn matrix(&mut self, given: Given<'a>) -> Result<()> {
        let keys = self.keys;
        let list = keys.list(given)?;
        let (rows, columns) = match list.len() {
            9 => (3, 3),
            12 => (3, 4),
            16 => (4, 4),
            _ => (0, 0),
        };
        let at = |row: usize, column: usize| list[row * columns + column];
        let (skew, [fx, fy, cx, cy]) = match (&list[..], rows) {
            (&[fx, fy, cx, cy], _) => (0.0, [fx, fy, cx, cy]),
            (_, 3 | 4) if is_square(rows, columns, &at) => (at(0, 1), [at(0, 0), at(1, 1), at(0, 2), at(1, 2)]),
            _ => {
                let problem = "expected a 3 x 3 matrix whose last row is 0, 0, 1";
                return Err(keys.wrong(given, problem, "give fx, 0, cx; 0, fy, cy; 0, 0, 1"));
            }
        };
        if skew != 0.0 || rows > 0 && at(1, 0) != 0.0 {
            return Err(keys.wrong(given, "a skewed image cannot be rendered", "refit the camera without a skew"));
        }
        for (axis, [focal, center]) in [[fx, cx], [fy, cy]].into_iter().enumerate() {
            put(keys, &mut self.focal[axis], focal, given)?;
            put(keys, &mut self.center[axis], center, given)?;
        }
        Ok(())
    }

    /// Takes the numbers of a model in its order.
    fn params(&mut self, given: Given<'a>, model: &Model<'a>) -> Result<()> {
        let keys = self.keys;
        let list = keys.list(given)?;
        let Some(names) = model.params().filter(|names| names.len() == list.len()) else {
            let problem = format!("{} numbers, and the model of the lens has another count", list.len());
            let mend = "name COLMAP's model in camera_model, or give fl_x, fl_y, cx, cy, k1, .. by themselves";
            return Err(keys.wrong(given, problem, mend));
        };
        for (name, x) in names.iter().copied().zip(list) {
            match name {
                "f" => self.focal.iter_mut().try_for_each(|slot| put(keys, slot, x, given))?,
                "fx" => put(keys, &mut self.focal[0], x, given)?,
                "fy" => put(keys, &mut self.focal[1], x, given)?,
                "cx" => put(keys, &mut self.center[0], x, given)?,
                "cy" => put(keys, &mut self.center[1], x, given)?,
                _ => self.params.push((name, x, given)),
            }
        }
        Ok(())
    }

    /// The lens of these numbers.
    fn lens(&self, curve: Option<Curve>, is_panorama: bool) -> Result<KeyedLens> {
        let keys = self.keys;
        let center = self.both(&self.center, ["cx", "cy"])?;
        let size = self.both(&self.sides, ["w", "h"])?.map(|sides| sides.map(|x| x as u32));
        let (plain, aperture) = self.plain()?;
        let [focal, angles] = [&self.focal, &self.angles].map(|of| of.map(|slot| slot.map(|(x, _)| x)));
        let mut pixels = PixelLens { focal, angles, center, image: size, curve };
        let has_pixels = focal.iter().chain(&angles).any(Option::is_some);
        let first = |slots: &[Slot<'a>]| slots.iter().flatten().map(|(_, given)| *given).next();
        let first_center = first(&self.center);
        let all = |plain| Ok(KeyedLens { size, plain, pixels: Some(pixels), aperture });
        if is_panorama || curve == Some(Curve::Panorama) {
            if let Some(vfov) = keys.find(|meaning| meaning == Meaning::Vfov) {
                return Err(keys.wrong(vfov, "a panorama has all angles", "remove it"));
            }
            (pixels.focal, pixels.angles) = ([None; 2], [None; 2]);
            return Ok(KeyedLens { size, plain: None, pixels: Some(pixels), aperture });
        }
        let unclear = keys.find(|meaning| meaning == Meaning::Unclear);
        if let Some(unclear) = unclear.filter(|_| plain.is_none() && !has_pixels) {
            let problem = "it says no unit and no axis that all programs agree on";
            let mend = "give fl_x and fl_y in pixels, camera_angle_x in radians, or vfov in degrees";
            return Err(keys.wrong(unclear, problem, mend));
        }
        if !has_pixels && (curve.is_some() || first_center.is_some()) {
            let is_middle = size.is_some_and(|size| pixels.is_centred(size));
            match plain {
                Some((Lens::Vfov { degrees, .. }, _)) if curve.is_none() && !is_middle => {
                    pixels.angles[1] = Some(degrees.to_radians());
                    return Ok(KeyedLens { size, plain: None, pixels: Some(pixels), aperture });
                }
                Some((lens, _)) if curve.is_none() && is_middle => {
                    return Ok(KeyedLens { size, plain: Some(lens), pixels: None, aperture });
                }
                _ => {}
            }
            let problem = match (curve, first_center) {
                (None, Some(given)) => format!("missing beside {}", keys.name(given)),
                _ => "a lens with distortion has no focal lengths".to_owned(),
            };
            return Err(keys.missing("fl_x", problem));
        }
        if let (Some(size), true) = (size, has_pixels) {
            let apart = pixels.contradiction(size.map(f64::from));
            if let Some((focal, angle)) = apart.and_then(|axis| self.focal[axis].zip(self.angles[axis])) {
                return Err(keys.apart(focal.1, angle.1));
            }
        }
        let Some((lens, given)) = plain else {
            return if has_pixels { all(None) } else { Ok(KeyedLens { size, aperture, ..KeyedLens::default() }) };
        };
        if !has_pixels {
            return Ok(KeyedLens { size, plain: Some(lens), pixels: None, aperture });
        }
        // A viewport or an angle beside lengths in pixels is theirs.
        let other = first(&self.focal).or_else(|| first(&self.angles)).unwrap_or(given);
        let Some(sides) = size.map(|size| size.map(f64::from)) else {
            let problem =
                format!("{} and {} are one only for an image of a known size", keys.name(given), keys.name(other));
            return Err(keys.wrong(given, problem, "remove one of the two, or add w and h"));
        };
        if !pixels.is_view_of(lens, sides) {
            return Err(keys.apart(given, other));
        }
        // A viewport has the principal point in its middle, and straight rays.
        let is_plain = curve.is_none() && size.is_some_and(|size| pixels.is_centred(size));
        all(Some(lens).filter(|_| is_plain))
    }

    /// The lens by a viewport or by an angle, with its key, and the size of the lens.
    #[expect(clippy::type_complexity, reason = "a pair for one caller")]
    fn plain(&self) -> Result<(Option<(Lens, Given<'a>)>, Option<Aperture>)> {
        let keys = self.keys;
        let of = |asked: Meaning| keys.find(|meaning| meaning == asked);
        let vfov = of(Meaning::Vfov).map(|given| Ok::<_, halfline::Error>((keys.number(given)?, given))).transpose()?;
        let by_angle = vfov.map(|(degrees, given)| (Lens::Vfov { degrees, distance: 1.0 }, given));
        let Some(viewport) = of(Meaning::Viewport) else { return Ok((by_angle, None)) };
        let [vw, vh] = keys.array::<2>(viewport)?;
        let distance = of(Meaning::Distance);
        let lens = match distance {
            Some(given) if *given.value == Value::Null => Lens::Orthographic { height: vh },
            Some(given) => Lens::Viewport { vw, vh, distance: keys.number(given)? },
            None => Lens::Viewport { vw, vh, distance: 1.0 },
        };
        if let Some((degrees, given)) = vfov {
            let agrees = matches!(lens, Lens::Viewport { vh, distance, .. }
                if is_near(0.5 * vh / distance, (0.5 * degrees.to_radians()).tan()));
            if !agrees {
                return Err(keys.apart(given, viewport));
            }
        }
        let optional = |asked| of(asked).map(|given| keys.number(given)).transpose();
        let (diameter, focus) = (optional(Meaning::Aperture)?, optional(Meaning::Focus)?);
        Ok((Some((lens, viewport)), diameter.map(|diameter| Aperture { diameter, focus })))
    }

    /// Two numbers; one alone is an error.
    fn both(&self, slots: &[Slot<'a>; 2], names: [&str; 2]) -> Result<Option<[f64; 2]>> {
        match *slots {
            [Some((a, _)), Some((b, _))] => Ok(Some([a, b])),
            [None, None] => Ok(None),
            [Some((_, given)), None] => Err(self.keys.missing(names[1], format!("missing beside {}", given.key))),
            [None, Some((_, given))] => Err(self.keys.missing(names[0], format!("missing beside {}", given.key))),
        }
    }
}

/// Puts a number into a slot that is empty or has the same.
fn put<'a>(keys: &Keys<'a>, slot: &mut Slot<'a>, x: f64, given: Given<'a>) -> Result<()> {
    match *slot {
        Some((known, other)) if (known - x).abs() > SAME * known.abs() => Err(keys.apart(given, other)),
        Some(_) => Ok(()),
        None => {
            *slot = Some((x, given));
            Ok(())
        }
    }
}

/// The number of columns or rows.
fn whole(keys: &Keys<'_>, given: Given<'_>, x: f64) -> Result<f64> {
    let is_whole = x >= 1.0 && f64::from(x as u32) == x;
    if is_whole { Ok(x) } else { Err(keys.wrong(given, "expected whole positive numbers", MEND)) }
}

/// Whether a matrix of 3 or 4 rows is one of intrinsics: beyond the upper rows it equals the identity.
fn is_square(rows: usize, columns: usize, at: &dyn Fn(usize, usize) -> f64) -> bool {
    let is_one = |row: usize, column: usize| at(row, column) == f64::from(u8::from(row == column));
    (0..rows).all(|row| (0..columns).all(|column| row < 2 && column < 3 || is_one(row, column)))
}

/// Whether a part of a lens is left out: 0, false, nothing, or those alone; a divisor of 1.
fn is_nothing(given: Given<'_>) -> bool {
    fn empty(value: &Value) -> bool {
        match value {
            Value::Null => true,
            Value::Bool(is_set) => !is_set,
            Value::Number(number) => number.as_f64() == Some(0.0),
            Value::String(text) => text.is_empty() || text.eq_ignore_ascii_case("false"),
            Value::Array(items) => items.iter().all(empty),
            Value::Object(map) => map.values().all(empty),
        }
    }
    let is_one = matches!(given.key, "binning_x" | "binning_y" | "beta") && given.value.as_f64() == Some(1.0);
    is_one || empty(given.value)
}
