//! A camera as numbers in reports, pictures and lists of cameras.

use super::{Aperture, Camera, Curve, Lens, Look};
use glam::DVec3;
use halfline_ground::error::Result;
use serde::{Deserialize, Serialize};

/// A camera for an image of a certain size, in the lecture's numbers and as intrinsics. Its numbers give the same rays
/// again, bit for bit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CameraRecord {
    /// The eye.
    pub eye: [f64; 3],
    /// The point looked at, where the camera is given so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 3]>,
    /// The direction of the view, of any length.
    pub view: [f64; 3],
    /// The scene's up direction.
    pub up: [f64; 3],
    /// Width and height of the viewport; of an orthographic camera in the scene's unit.
    pub viewport: [f64; 2],
    /// Distance of the viewport; `None` for an orthographic camera.
    pub distance: Option<f64>,
    /// Columns and rows of the image.
    pub size: [u32; 2],
    /// Focal lengths and principal point in pixels, where the centre of the top left pixel is (0.5, 0.5); `None` for an
    /// orthographic camera.
    pub intrinsics: Option<Intrinsics>,
    /// The model of a lens with distortion, a fisheye or a panorama; the intrinsics then give the viewport.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<Curve>,
    /// Diameter of the lens, where it has a size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub aperture: Option<f64>,
    /// Distance of the plane in focus.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub focus: Option<f64>,
}

/// Focal lengths and principal point, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Intrinsics {
    /// Focal length across.
    pub fx: f64,
    /// Focal length down.
    pub fy: f64,
    /// Column of the principal point.
    pub cx: f64,
    /// Row of the principal point.
    pub cy: f64,
}

impl Intrinsics {
    /// The intrinsics for an image of `to` columns and rows in place of `from`: the height of the view stays, pixels keep their shape, and the
    /// principal point its distance from the middle in heights of the view.
    #[must_use]
    pub fn resized(self, from: [u32; 2], to: [u32; 2]) -> Self {
        if from == to {
            return self;
        }
        let Self { fx, fy, cx, cy } = self;
        let scale = f64::from(to[1]) / f64::from(from[1]);
        let moved = |center: f64, k: usize| (center - f64::from(from[k]) / 2.0) * scale + f64::from(to[k]) / 2.0;
        Self { fx: fx * scale, fy: fy * scale, cx: moved(cx, 0), cy: moved(cy, 1) }
    }
}

impl Lens {
    /// The lens for an image of `to` columns and rows in place of `from`. A panorama becomes the other image's; what is given in pixels is
    /// scaled as by [`Intrinsics::resized`].
    #[must_use]
    pub fn resized(self, from: [u32; 2], to: [u32; 2]) -> Self {
        let scaled = |[fx, fy, cx, cy]: [f64; 4]| Intrinsics { fx, fy, cx, cy }.resized(from, to);
        match self {
            Self::Curved { curve: Curve::Panorama, .. } => Self::panorama(to[0], to[1]),
            Self::Curved { curve, fx, fy, cx, cy } => {
                let Intrinsics { fx, fy, cx, cy } = scaled([fx, fy, cx, cy]);
                Self::Curved { curve, fx, fy, cx, cy }
            }
            Self::Intrinsics { fx, fy, cx, cy } => {
                let Intrinsics { fx, fy, cx, cy } = scaled([fx, fy, cx, cy]);
                Self::Intrinsics { fx, fy, cx, cy }
            }
            other => other,
        }
    }
}

impl CameraRecord {
    /// The record of a camera, and of its lens if it has a size, for an image of `width` x `height` pixels. A principal
    /// point beside the middle is recorded as the rays have it, rounded: to half a pixel where it is given so, else to
    /// 1/512 of a pixel, or less finely for images of more than 255 pixels: to 2^-20 of eight times the side of the
    /// smallest image around it that contains this one.
    ///
    /// # Errors
    /// Errors of [`Camera::viewport`] and of [`Aperture::distance`].
    pub fn new(camera: &Camera, [width, height]: [u32; 2], aperture: Option<Aperture>) -> Result<Self> {
        let [w, h] = [width, height].map(f64::from);
        let viewport = camera.central_viewport(width, height)?;
        let (at, view) = match camera.look {
            Look::At(at) => (Some(at.to_array()), at - camera.eye),
            Look::View(view) => (None, view),
        };
        let distance = (!viewport.is_parallel()).then_some(viewport.d);
        let [cx, cy] = camera.principal_point([width, height]);
        Ok(Self {
            eye: camera.eye.to_array(),
            at,
            view: view.to_array(),
            up: camera.up.to_array(),
            viewport: [viewport.vw, viewport.vh],
            distance,
            size: [width, height],
            intrinsics: distance.map(|d| match camera.lens {
                Lens::Intrinsics { fx, fy, .. } | Lens::Curved { fx, fy, .. } => Intrinsics { fx, fy, cx, cy },
                _ => Intrinsics { fx: d * w / viewport.vw, fy: d * h / viewport.vh, cx, cy },
            }),
            curve: match camera.lens {
                Lens::Curved { curve, .. } => Some(curve),
                _ => None,
            },
            aperture: aperture.map(|aperture| aperture.diameter),
            focus: aperture.map(|aperture| aperture.distance(camera)).transpose()?,
        })
    }

    /// The lens, if it has a size.
    #[must_use]
    pub fn lens_size(&self) -> Option<Aperture> {
        self.aperture.map(|diameter| Aperture { diameter, focus: self.focus })
    }

    /// The intrinsics, if the principal point is not the middle of the image.
    fn off_center(&self) -> Option<Intrinsics> {
        let middle = self.size.map(|side| f64::from(side) / 2.0);
        self.intrinsics.filter(|intrinsics| [intrinsics.cx, intrinsics.cy] != middle)
    }

    /// Whether the principal point is not the middle of the image.
    #[must_use]
    pub fn is_off_center(&self) -> bool {
        self.off_center().is_some()
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> Camera {
        let [vw, vh] = self.viewport;
        Camera {
            eye: DVec3::from_array(self.eye),
            look: self.at.map_or(Look::View(DVec3::from_array(self.view)), |at| Look::At(DVec3::from_array(at))),
            up: DVec3::from_array(self.up),
            lens: match (self.curve.zip(self.intrinsics), self.off_center(), self.distance) {
                (Some((curve, Intrinsics { fx, fy, cx, cy })), ..) => Lens::Curved { curve, fx, fy, cx, cy },
                (_, Some(Intrinsics { fx, fy, cx, cy }), _) => Lens::Intrinsics { fx, fy, cx, cy },
                (_, None, Some(distance)) => Lens::Viewport { vw, vh, distance },
                (_, None, None) => Lens::Orthographic { height: vh },
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_gives_the_same_rays_after_json() {
        let lenses = [
            Lens::Vfov { degrees: 33.3, distance: 0.7 },
            Lens::Viewport { vw: 0.1, vh: 0.3, distance: 1e-7 },
            Lens::RowCentres { degrees: 20.0 },
            Lens::Orthographic { height: 12.3 },
        ];
        for (lens, look) in lenses.into_iter().flat_map(|lens| {
            [Look::At(DVec3::new(0.1, 0.2, 0.3)), Look::View(DVec3::new(-1e9, 0.1, 1e-9))].map(|look| (lens, look))
        }) {
            let camera = Camera { eye: DVec3::new(1e9 / 3.0, 0.1, -7.0), look, up: DVec3::new(0.0, 1.0, 0.1), lens };
            let record = CameraRecord::new(&camera, [640, 360], None).expect("a camera");
            let text = serde_json::to_string(&record).expect("JSON");
            let again: CameraRecord = serde_json::from_str(&text).expect(&text);
            assert_eq!(again, record);
            let back = again.camera();
            assert_eq!(back.basis().expect("a basis"), camera.basis().expect("a basis"), "{text}");
            assert_eq!(back.viewport(640, 360).expect("one"), camera.viewport(640, 360).expect("one"), "{text}");
        }
    }

    #[test]
    fn intrinsics_are_focal_lengths_in_pixels() {
        let lens = Lens::Viewport { vw: 4.0, vh: 3.0, distance: 2.0 };
        let camera = Camera { lens, ..Camera::CANONICAL };
        let found =
            CameraRecord::new(&camera, [640, 480], None).expect("a camera").intrinsics.expect("a perspective camera");
        assert_eq!(found, Intrinsics { fx: 320.0, fy: 320.0, cx: 320.0, cy: 240.0 });
    }
}
