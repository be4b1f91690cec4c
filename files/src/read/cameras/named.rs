//! A curved lens by its name and its numbers, as options of the command, Python and `[camera]` of a scene file give it.

use super::curve::curve_of;
use super::lens::lens_of;
use halfline::error::{Error, Result, named};
use halfline::scene::camera::{Camera, Curve, Intrinsics, Lens};

/// The name of a lens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LensName {
    /// Image heights that grow with the angle, by OpenCV's model.
    Fisheye,
    /// The whole sphere: longitudes across, latitudes down.
    Equirectangular,
    /// A perspective lens with OpenCV's model of distortion.
    Opencv,
}

named! { LensName, "lens", Fisheye "fisheye" Equirectangular "equirectangular" Opencv "opencv" }

/// A lens by its name.
#[derive(Debug, Clone, Copy)]
pub struct NamedLens<'a> {
    /// Its name.
    pub name: LensName,
    /// The angle of the full height of a fisheye, degrees; 180 where neither it nor intrinsics are given.
    pub vfov: Option<f64>,
    /// Focal lengths and principal point in pixels.
    pub intrinsics: Option<Intrinsics>,
    /// k1, k2, p1, p2, k3, k4, k5, k6, where the last 3 or 4 may be left out; of a fisheye k1 to k4; empty for none.
    pub coefficients: &'a [f64],
    /// The names of `vfov`, `intrinsics` and `coefficients` in messages.
    pub words: [&'static str; 3],
}

/// A wrong number of a named lens: the place of its name in `words`, the problem and the mend.
pub type LensProblem = (usize, String, String);

const VFOV: usize = 0;
const INTRINSICS: usize = 1;
const COEFFICIENTS: usize = 2;

impl NamedLens<'_> {
    /// The angle of a fisheye without any.
    const DEGREES: f64 = 180.0;

    /// The lens in an image of `width` x `height` pixels, to which its intrinsics belong.
    ///
    /// # Errors
    /// The number that the lens does not have, lacks, or that is out of its range.
    pub fn lens(&self, width: u32, height: u32) -> Result<Lens, LensProblem> {
        self.check()?;
        let problem = |key: usize| {
            move |error: Error| match error {
                Error::Settings { problem, mend } | Error::Scene { problem, mend, .. } => (key, problem, mend),
                other => (key, other.to_string(), "use another lens".to_owned()),
            }
        };
        let curve = curve_of(self.coefficients, self.name == LensName::Fisheye).map_err(problem(COEFFICIENTS))?;
        let lens = match (self.name, curve, self.intrinsics) {
            (LensName::Equirectangular, ..) => Lens::panorama(width, height),
            (_, None, Some(intrinsics)) => {
                lens_of(&intrinsics, width, height).map_err(problem(INTRINSICS))?;
                let Intrinsics { fx, fy, cx, cy } = intrinsics;
                // In pixels also where the principal point is the middle.
                Lens::Intrinsics { fx, fy, cx, cy }
            }
            (_, Some(curve), Some(Intrinsics { fx, fy, cx, cy })) => Lens::Curved { curve, fx, fy, cx, cy },
            (_, Some(Curve::Fisheye { k }), None) => {
                Lens::fisheye(self.vfov.unwrap_or(Self::DEGREES), k, width, height)
            }
            (_, _, None) => {
                let problem = "an opencv lens has focal lengths and a principal point".to_owned();
                return Err((INTRINSICS, problem, format!("add {}", self.words[INTRINSICS])));
            }
        };
        let key = if self.intrinsics.is_some() { INTRINSICS } else { COEFFICIENTS };
        Camera { lens, ..Camera::CANONICAL }.check(width, height).map_err(problem(key))?;
        Ok(lens)
    }

    /// Checks that the lens has the numbers that are given.
    fn check(&self) -> Result<(), LensProblem> {
        let Self { name, vfov, intrinsics, coefficients, words } = self;
        let given = [vfov.is_some(), intrinsics.is_some(), !coefficients.is_empty()];
        let (lacks, why): (&[usize], _) = match name {
            LensName::Equirectangular => (&[VFOV, INTRINSICS, COEFFICIENTS], "shows the whole sphere"),
            LensName::Opencv => (&[VFOV], "has focal lengths in place of an angle"),
            LensName::Fisheye => (&[], ""),
        };
        if let Some(key) = lacks.iter().find(|key| given[**key]) {
            let problem = format!("{} is not one of the lens {}, which {why}", words[*key], name.name());
            return Err((*key, problem, format!("remove {}", words[*key])));
        }
        if given[VFOV] && given[INTRINSICS] {
            let problem = format!("{} and {} exclude each other", words[INTRINSICS], words[VFOV]);
            return Err((INTRINSICS, problem, "remove one of them".to_owned()));
        }
        if let Some(degrees) = vfov.filter(|degrees| !(*degrees > 0.0 && *degrees <= 360.0)) {
            let problem = format!("the angle of a fisheye is {degrees} degrees");
            return Err((VFOV, problem, "use an angle above 0 and at most 360".to_owned()));
        }
        let (counts, order): (&[usize], _) = match name {
            LensName::Fisheye => (&[0, 4], "k1,k2,k3,k4"),
            _ => (&[0, 4, 5, 8], "k1,k2,p1,p2, or k3 behind them, or k3,k4,k5,k6"),
        };
        if !counts.contains(&coefficients.len()) {
            let (of, count) = (words[COEFFICIENTS], coefficients.len());
            return Err((
                COEFFICIENTS,
                format!("{of} of the lens {} has {count} numbers", name.name()),
                format!("give {order}"),
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORDS: [&str; 3] = ["vfov", "intrinsics", "coefficients"];

    fn named(name: LensName, vfov: Option<f64>, intrinsics: Option<[f64; 4]>, coefficients: &[f64]) -> NamedLens<'_> {
        let intrinsics = intrinsics.map(|[fx, fy, cx, cy]| Intrinsics { fx, fy, cx, cy });
        NamedLens { name, vfov, intrinsics, coefficients, words: WORDS }
    }

    #[test]
    fn names_and_numbers_give_the_lenses_of_their_models() {
        use LensName::{Equirectangular, Fisheye, Opencv};
        let pixels = [50.0, 51.0, 20.5, 16.0];
        let [fx, fy, cx, cy] = pixels;
        let curved = |curve| Lens::Curved { curve, fx, fy, cx, cy };
        // 30 rows are 90 degrees.
        let focal = 30.0 / std::f64::consts::FRAC_PI_2;
        let even = Curve::Fisheye { k: [0.0; 4] };
        for (lens, expected) in [
            (
                named(Fisheye, Some(90.0), None, &[]),
                Lens::Curved { curve: even, fx: focal, fy: focal, cx: 20.0, cy: 15.0 },
            ),
            (
                named(Fisheye, None, None, &[]),
                Lens::Curved { curve: even, fx: focal / 2.0, fy: focal / 2.0, cx: 20.0, cy: 15.0 },
            ),
            (named(Fisheye, None, Some(pixels), &[]), curved(even)),
            (
                named(Fisheye, None, Some(pixels), &[0.1, 0.2, 0.3, 0.4]),
                curved(Curve::Fisheye { k: [0.1, 0.2, 0.3, 0.4] }),
            ),
            (named(Equirectangular, None, None, &[]), Lens::panorama(40, 30)),
            (named(Opencv, None, Some(pixels), &[]), Lens::Intrinsics { fx, fy, cx, cy }),
            (
                named(Opencv, None, Some(pixels), &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]),
                curved(Curve::Distorted { k: [1.0, 2.0, 5.0, 6.0, 7.0, 8.0], p: [3.0, 4.0] }),
            ),
        ] {
            assert_eq!(lens.lens(40, 30), Ok(expected), "{lens:?}");
        }
        // The image height of OpenCV's fisheye at the half angle is half of the image.
        let bent = named(Fisheye, Some(120.0), None, &[0.1, -0.02, 0.0, 0.0]).lens(40, 30).expect("a lens");
        let Lens::Curved { fy, .. } = bent else { panic!("{bent:?}") };
        let theta = 60f64.to_radians();
        assert!((fy * (theta + 0.1 * theta.powi(3) - 0.02 * theta.powi(5)) - 15.0).abs() < 1e-12, "{bent:?}");
    }

    #[test]
    fn wrong_numbers_are_named() {
        use LensName::{Equirectangular, Fisheye, Opencv};
        let pixels = Some([50.0, 50.0, 20.0, 15.0]);
        for (lens, key, words) in [
            (named(Fisheye, Some(0.0), None, &[]), VFOV, "at most 360"),
            (named(Fisheye, Some(360.5), None, &[]), VFOV, "at most 360"),
            (named(Fisheye, Some(90.0), pixels, &[]), INTRINSICS, "intrinsics and vfov exclude each other"),
            (named(Fisheye, None, None, &[0.1]), COEFFICIENTS, "has 1 numbers"),
            (named(Fisheye, None, None, &[-9.0, 0.0, 0.0, 0.0]), COEFFICIENTS, "not positive"),
            (named(Equirectangular, Some(90.0), None, &[]), VFOV, "the whole sphere"),
            (named(Equirectangular, None, pixels, &[]), INTRINSICS, "the whole sphere"),
            (named(Equirectangular, None, None, &[0.0; 4]), COEFFICIENTS, "the whole sphere"),
            (named(Opencv, Some(90.0), pixels, &[]), VFOV, "remove vfov"),
            (named(Opencv, None, None, &[0.0; 4]), INTRINSICS, "add intrinsics"),
            (named(Opencv, None, pixels, &[0.1, 0.2]), COEFFICIENTS, "k1,k2,p1,p2"),
            (named(Opencv, None, Some([0.0, 50.0, 20.0, 15.0]), &[]), INTRINSICS, "not positive"),
            (named(Opencv, None, Some([0.0, 50.0, 20.0, 15.0]), &[0.1; 4]), INTRINSICS, "not positive"),
        ] {
            let (found, problem, mend) = lens.lens(40, 30).expect_err("a wrong number");
            let text = format!("{problem}; {mend}");
            assert!(found == key && text.contains(words), "{lens:?}: {found} {text}");
        }
    }
}
