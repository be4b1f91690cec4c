//! The lens: `--lens` with its numbers, and its size, `--aperture` and `--focus-distance`.

use super::values::{length, list, numbers};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use halfline::camera::{Aperture, Intrinsics, Lens, Look};
use halfline::error::{Error, Result};
use halfline::quote::setting::{INTRINSICS, LENS, LENS_COEFFICIENTS, VFOV};
use halfline_files::read::SceneFrame;
use halfline_files::read::cameras::{LensName, NamedLens};

/// The options for the lens.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(super) struct LensArgs {
    /// Lens of a picture that is not one of a plane: fisheye (image heights grow with the angle; --vfov is the angle of
    /// the full height, up to 360 degrees), equirectangular (the whole sphere, from the middle of the spheres unless
    /// --eye is given), opencv (--intrinsics, and distortion by --lens-coefficients) [default: the scene file's, else a
    /// perspective one].
    #[arg(long, value_name = "L", value_parser = names(), hide_possible_values = true,
        conflicts_with_all = ["ortho", "aperture", "focus_distance"])]
    lens: Option<LensName>,
    /// Focal lengths and principal point, in pixels of the picture, of --lens opencv or fisheye, or for cameras of --cameras without a lens of
    /// their own; the centre of the top left pixel is 0.5,0.5. The principal point may lie anywhere, also outside of the image.
    #[arg(long, value_name = "FX,FY,CX,CY", value_parser = intrinsics, conflicts_with = "vfov", allow_hyphen_values = true)]
    pub(super) intrinsics: Option<Intrinsics>,
    /// Distortion by the model of OpenCV, K1,K2,P1,P2 or with K3 or K3,K4,K5,K6 behind them; of a fisheye K1,K2,K3,K4.
    #[arg(long, value_name = "K1,K2,P1,P2[,K3[,K4,K5,K6]]", value_parser = coefficients, requires = "lens", allow_hyphen_values = true)]
    lens_coefficients: Option<Coefficients>,
    /// Diameter of the lens in scene units: what is nearer or farther than the distance in focus is blurred. Each sample leaves
    /// from another point of the lens [default: the scene file's, else a pinhole; with 64 samples unless --samples is given].
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true, conflicts_with = "ortho")]
    aperture: Option<f64>,
    /// Distance along the view of the plane in focus, in scene units [default: the scene file's, else the distance of
    /// the point looked at, else of the middle of the spheres].
    #[arg(long, value_name = "F", value_parser = length, allow_negative_numbers = true)]
    focus_distance: Option<f64>,
}

/// The coefficients of a lens.
#[derive(Debug, Clone)]
struct Coefficients(Vec<f64>);

/// The lens of one picture.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PictureLens {
    pub(super) aperture: Option<Aperture>,
    /// The samples where no one asks for any.
    pub(super) samples: Option<u32>,
}

impl LensArgs {
    /// Whether an option of a lens with a size is given.
    pub(super) fn has_size(&self) -> bool {
        self.aperture.is_some() || self.focus_distance.is_some()
    }

    /// Whether the angle is of a lens with `--lens`, not of a perspective lens.
    pub(super) fn is_named(&self) -> bool {
        self.lens.is_some()
    }

    /// The lens of `--lens` in an image of `width` x `height` pixels, with this `--vfov`; `None` without it.
    ///
    /// # Errors
    /// [`Error::Settings`] for numbers that the lens does not have, or lacks.
    pub(super) fn named(&self, vfov: Option<f64>, (width, height): (u32, u32)) -> Result<Option<Lens>> {
        let Some(name) = self.lens else { return Ok(None) };
        let coefficients = self.lens_coefficients.as_ref().map_or(&[][..], |list| &list.0);
        let words = [VFOV, INTRINSICS, LENS_COEFFICIENTS];
        let lens = NamedLens { name, vfov, intrinsics: self.intrinsics, coefficients, words }.lens(width, height);
        lens.map(Some).map_err(|(_, problem, mend)| Error::settings(format!("{LENS} {}: {problem}", name.name()), mend))
    }

    /// The lens for a frame whose camera is final but for turns, with the lens of a picture whose camera was taken;
    /// `has_samples` says whether options or the file ask for samples.
    ///
    /// # Errors
    /// [`Error::Settings`] for a focus without an aperture and an aperture of a curved lens, and errors of [`Aperture::distance`].
    pub(super) fn lens(&self, frame: &SceneFrame, taken: Option<Aperture>, has_samples: bool) -> Result<PictureLens> {
        let given = taken.or(frame.aperture);
        let Some(diameter) = self.aperture.or(given.map(|lens| lens.diameter)) else {
            return match self.focus_distance {
                Some(_) => Err(Error::settings(
                    "all is in focus without an aperture",
                    "add --aperture D, or remove --focus-distance",
                )),
                None => Ok(PictureLens::default()),
            };
        };
        let camera = &frame.scene.camera;
        if self.aperture.is_some() && camera.lens.is_curved() {
            let problem = "--aperture: a lens with a size is one of a plane, and the lens of the camera is curved";
            return Err(Error::settings(problem, "remove --aperture, or use another camera"));
        }
        let middle = || match camera.look {
            Look::View(view) if !frame.has_camera => {
                Some((frame.scene.spheres.middle() - camera.eye).dot(view.normalize())).filter(|depth| *depth > 0.0)
            }
            _ => None,
        };
        let focus = self.focus_distance.or(given.and_then(|lens| lens.focus)).or_else(middle);
        let focus = Some(Aperture { diameter, focus }.distance(camera)?);
        let samples = (!has_samples).then_some(Aperture::SAMPLES);
        Ok(PictureLens { aperture: Some(Aperture { diameter, focus }), samples })
    }
}

impl PictureLens {
    /// A sentence with the diameter of the lens, the distance in focus and the samples that it sets; `None` for a
    /// pinhole.
    pub(super) fn words(&self) -> Option<String> {
        let Aperture { diameter, focus: Some(focus) } = self.aperture? else { return None };
        let samples = self.samples.map(|samples| format!(", --samples {samples}")).unwrap_or_default();
        Some(format!("lens of diameter {diameter}: what is {focus} away is in focus{samples}"))
    }
}

fn names() -> impl TypedValueParser<Value = LensName> {
    let value = |lens: &LensName| {
        let help = match lens {
            LensName::Fisheye => "Image heights that grow with the angle",
            LensName::Equirectangular => "The whole sphere: longitudes across, latitudes down",
            LensName::Opencv => "Focal lengths, principal point and distortion in pixels, as of OpenCV",
        };
        PossibleValue::new(lens.name()).help(help)
    };
    PossibleValuesParser::new(LensName::ALL.iter().map(value)).try_map(|name| name.parse())
}

fn intrinsics(text: &str) -> Result<Intrinsics, String> {
    let [fx, fy, cx, cy] = numbers(text).ok_or("expected four finite numbers FX,FY,CX,CY, such as 525,525,320,240")?;
    Ok(Intrinsics { fx, fy, cx, cy })
}

fn coefficients(text: &str) -> Result<Coefficients, String> {
    let expected = "expected finite numbers with commas between them, such as -0.28,0.07,0,0";
    list(text).map(Coefficients).ok_or_else(|| expected.into())
}
