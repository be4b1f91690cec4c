//! The lens of a camera of a list.

use halfline::error::{Error, Result};
use halfline::scene::camera::{Camera, Intrinsics, Lens};

/// The lens of a camera of a list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ListedLens {
    /// It does not depend on the size of the image.
    Known(Lens),
    /// Its lengths are in pixels of the image.
    InPixels(Intrinsics),
}

impl ListedLens {
    /// The lens for an image of `width` x `height` pixels. Errors refer to the camera by its `index` in the list, from 0.
    ///
    /// # Errors
    /// Those of [`lens_of`].
    pub fn for_image(&self, index: usize, width: u32, height: u32) -> Result<Lens> {
        match self {
            Self::Known(lens) => Ok(*lens),
            Self::InPixels(intrinsics) => lens_of(intrinsics, width, height).map_err(|error| match error {
                Error::Settings { problem, mend } => Error::settings(format!("camera {index}: {problem}"), mend),
                other => other,
            }),
        }
    }
}

/// The lens of intrinsics for an image of `width` x `height` pixels: a viewport of W/fx x H/fy at distance 1 where the
/// principal point is the centre of the image.
///
/// # Errors
/// [`Error::Settings`] for focal lengths that are not positive, and for a principal point farther than 2^18 pixels.
pub fn lens_of(intrinsics: &Intrinsics, width: u32, height: u32) -> Result<Lens> {
    let Intrinsics { fx, fy, cx, cy } = *intrinsics;
    let [w, h] = [width, height].map(f64::from);
    if !(fx > 0.0 && fy > 0.0 && fx.is_finite() && fy.is_finite()) {
        let problem = format!("the focal lengths {fx:?}, {fy:?} are not positive finite numbers");
        return Err(Error::settings(problem, "give them in pixels, such as 525,525,320,240"));
    }
    if [cx, cy] == [w / 2.0, h / 2.0] {
        let [vw, vh] = [w / fx, h / fy];
        if !(vw > 0.0 && vh > 0.0 && vw.is_finite() && vh.is_finite()) {
            let problem = format!("the focal lengths {fx:?}, {fy:?} give a viewport beyond f64");
            return Err(Error::settings(problem, "give them in pixels, such as 525,525,320,240"));
        }
        return Ok(Lens::Viewport { vw, vh, distance: 1.0 });
    }
    let lens = Lens::Intrinsics { fx, fy, cx, cy };
    let camera = Camera { lens, ..Camera::CANONICAL };
    camera.viewport(width, height).map(|_| lens).map_err(|error| match error {
        Error::Scene { problem, mend, .. } => Error::settings(problem, mend),
        other => other,
    })
}
