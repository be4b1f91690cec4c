//! `--aperture` and `--focus-distance`: a lens with a size.

use super::values::length;
use clap::Args;
use halfline::camera::{Aperture, Look};
use halfline::error::{Error, Result};
use halfline_files::read::SceneFrame;

/// The options for the lens.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(super) struct LensArgs {
    /// Diameter of the lens in scene units: what is nearer or farther than the distance in focus is blurred. Each sample leaves
    /// from another point of the lens [default: the scene file's, else a pinhole; with 64 samples unless --samples is given].
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true, conflicts_with = "ortho")]
    aperture: Option<f64>,
    /// Distance along the view of the plane in focus, in scene units [default: the scene file's, else that of the point looked
    /// at, else that of the middle of the spheres].
    #[arg(long, value_name = "F", value_parser = length, allow_negative_numbers = true)]
    focus_distance: Option<f64>,
}

/// The lens of one picture.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PictureLens {
    pub(super) aperture: Option<Aperture>,
    /// The samples where no one asks for any.
    pub(super) samples: Option<u32>,
}

impl LensArgs {
    /// Whether an option is given.
    pub(super) fn is_given(&self) -> bool {
        self.aperture.is_some() || self.focus_distance.is_some()
    }

    /// The lens for a frame whose camera is final but for turns, with that of a picture whose camera was taken;
    /// `has_samples` says whether options or the file ask for samples.
    ///
    /// # Errors
    /// [`Error::Settings`] for a focus without an aperture, and those of [`Aperture::distance`].
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
