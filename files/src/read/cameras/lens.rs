//! The lens of a camera of a list.

use halfline::error::{Error, Result};
use halfline::scene::camera::{Camera, Curve, Intrinsics, Lens};

/// The lens of a camera of a list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ListedLens {
    /// A lens for an image of any size.
    Known(Lens),
    /// A lens for an image of so many columns and rows.
    OfImage(Lens, [u32; 2]),
    /// A lens whose lengths are in pixels of the image.
    InPixels(PixelLens),
}

/// Focal lengths or angles of view, and a principal point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelLens {
    /// Across and down, in pixels; one stands for both.
    pub(super) focal: [Option<f64>; 2],
    /// Fields of view across and down, radians, for focal lengths that are not given.
    pub(super) angles: [Option<f64>; 2],
    /// The middle of the image, where it is not given.
    pub(super) center: Option<[f64; 2]>,
    /// Columns and rows of the image that the pixels belong to; of the picture where they are not given.
    pub(super) image: Option<[u32; 2]>,
    /// The model of a lens with distortion, a fisheye or a panorama, which needs no focal lengths.
    pub(super) curve: Option<Curve>,
}

impl PixelLens {
    /// These intrinsics, of a picture of any size.
    #[must_use]
    pub fn of(intrinsics: Intrinsics) -> Self {
        let Intrinsics { fx, fy, cx, cy } = intrinsics;
        Self { focal: [Some(fx), Some(fy)], center: Some([cx, cy]), ..Self::default() }
    }

    /// Whether the principal point is the middle of an image of this size.
    pub(super) fn is_centred(&self, size: [u32; 2]) -> bool {
        self.center.is_none_or(|center| center == size.map(|side| f64::from(side) / 2.0))
    }

    /// The axis along which the focal length and the angle of an image with these sides contradict each other. The angle of a fisheye has
    /// no formula that programs agree on.
    pub(super) fn contradiction(&self, sides: [f64; 2]) -> Option<usize> {
        let is_apart = |axis: &usize| match (self.focal[*axis], self.by_angle(*axis, sides)) {
            (Some(focal), Some(by_angle)) => !is_near(focal, by_angle),
            _ => false,
        };
        [0, 1].into_iter().find(is_apart).filter(|_| !matches!(self.curve, Some(Curve::Fisheye { .. })))
    }

    /// Whether a viewport or an angle shows what the focal lengths do in an image with these sides.
    pub(super) fn is_view_of(&self, lens: Lens, sides: [f64; 2]) -> bool {
        let focal = self.focal_lengths(sides);
        match lens {
            Lens::Viewport { vw, vh, distance } => {
                [vw, vh].iter().enumerate().all(|(k, side)| is_near(sides[k] * distance / side, focal[k]))
            }
            Lens::Vfov { degrees, .. } => is_near(0.5 * sides[1] / (0.5 * degrees.to_radians()).tan(), focal[1]),
            _ => false,
        }
    }

    fn by_angle(&self, axis: usize, sides: [f64; 2]) -> Option<f64> {
        self.angles[axis].map(|angle| 0.5 * sides[axis] / (0.5 * angle).tan())
    }

    /// The focal lengths in an image with these sides.
    fn focal_lengths(&self, sides: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|k| self.focal[k].or_else(|| self.by_angle(k, sides)));
        [x.or(y), y.or(x)].map(|focal| focal.unwrap_or(f64::NAN))
    }

    /// The intrinsics for a picture of `width` x `height` pixels, by [`Intrinsics::resized`].
    fn intrinsics(&self, width: u32, height: u32) -> Intrinsics {
        let sides = self.image.unwrap_or([width, height]).map(f64::from);
        let [fx, fy] = self.focal_lengths(sides);
        let [cx, cy] = self.center.unwrap_or(sides.map(|side| side / 2.0));
        Intrinsics { fx, fy, cx, cy }.resized(self.image.unwrap_or([width, height]), [width, height])
    }

    /// Returns an error for numbers that contradict each other in a picture of `width` x `height` pixels.
    fn check(&self, index: usize, width: u32, height: u32) -> Result<()> {
        let image = self.image.unwrap_or([width, height]);
        if let Some(axis) = self.contradiction(image.map(f64::from)) {
            let side = ["width", "height"][axis];
            let problem = format!(
                "camera {index}: the focal length and the angle of its {side} differ for {width} x {height} pixels"
            );
            return Err(Error::settings(problem, "remove the wrong one of the two from the list, or add w and h"));
        }
        if self.curve == Some(Curve::Panorama) && !self.is_centred(image) {
            let problem = format!("camera {index}: cx and cy of a panorama are not the middle of its image");
            return Err(Error::settings(problem, "remove them from the list"));
        }
        Ok(())
    }
}

impl ListedLens {
    /// The lens for an image of `width` x `height` pixels. Errors refer to the camera by its `index` in the list, from 0.
    ///
    /// # Errors
    /// As [`lens_of`]; [`Error::Settings`] for numbers that contradict each other.
    pub fn for_image(&self, index: usize, width: u32, height: u32) -> Result<Lens> {
        if let Self::InPixels(lens) = self {
            lens.check(index, width, height)?;
        }
        match self {
            // The picture has the height of the view, and square pixels where the image has square ones.
            Self::OfImage(Lens::Viewport { vw, vh, distance }, image) if *image != [width, height] => {
                let [w, h] = image.map(f64::from);
                let vw = vw * (h / w) * (f64::from(width) / f64::from(height));
                Ok(Lens::Viewport { vw, vh: *vh, distance: *distance })
            }
            Self::Known(lens) | Self::OfImage(lens, _) => Ok(*lens),
            Self::InPixels(PixelLens { curve: Some(Curve::Panorama), .. }) => Ok(Lens::panorama(width, height)),
            Self::InPixels(lens @ PixelLens { curve: Some(curve), .. }) => {
                let Intrinsics { fx, fy, cx, cy } = lens.intrinsics(width, height);
                Ok(Lens::Curved { curve: *curve, fx, fy, cx, cy })
            }
            Self::InPixels(lens) => {
                lens_of(&lens.intrinsics(width, height), width, height).map_err(|error| match error {
                    Error::Settings { problem, mend } => Error::settings(format!("camera {index}: {problem}"), mend),
                    other => other,
                })
            }
        }
    }
}

/// Whether two numbers are one, within a hundredth.
pub(super) fn is_near(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() <= 0.01
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
