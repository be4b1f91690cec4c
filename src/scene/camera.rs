//! The general perspective camera of the lecture, and the orthographic one, in f64 on the host.
//!
//! Step by step: the *canonical camera* has its eye at the origin and looks down -z through a viewport of 1 x 1 at
//! distance 1. A *distance* d and a *viewport* of vw x vh generalise the lens; the *eye* e and the *basis* u, v, w
//! (right, up, back) generalise the pose. For row i and column j, counted from 0, of an image of W x H pixels
//!
//! ```text
//! u = ((j + 1/2)/W - 1/2) vw        v = -((i + 1/2)/H - 1/2) vh
//! origin = e                        direction = u u + v v - d w
//! ```
//!
//! An *orthographic* camera is the limit of an eye infinitely far behind the viewport: all rays are parallel, and vw
//! and vh are lengths in the scene. Rays start on the plane through e perpendicular to w:
//!
//! ```text
//! origin = e + u u + v v            direction = -w
//! ```

mod aperture;
mod centred;
mod curved;
mod curved_frame;
mod project;
mod pyramid;
mod record;
#[cfg(test)]
mod tests;

pub use aperture::Aperture;
pub(crate) use centred::{CentredFrame, ExactViewport};
pub use curved::Curve;
pub(crate) use curved::CurvedRays;
pub(crate) use curved_frame::CurvedFrame;
pub use project::{Projected, Projector};
pub use record::{CameraRecord, Intrinsics};

use crate::double_double::{Dd, Dd3};
use crate::dyadic::{self, Dyadic3};
use glam::DVec3;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::number;
use halfline_ground::quote::setting::ZOOM;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// The words for curved lenses in messages, behind "this lens has".
pub(crate) const CURVED: &str = "distortion or is a fisheye or a panorama";

/// Pose and lens. Every number is taken as exact.
///
/// ```
/// use halfline::{Camera, Lens, Look};
///
/// let lens = Lens::Orthographic { height: 10.0 };
/// let camera = Camera { eye: [0.0, 0.0, 9.0].into(), look: Look::View([0.0, 0.0, -1.0].into()), up: [0.0, 1.0, 0.0].into(), lens };
/// let basis = camera.basis()?;
/// assert_eq!(basis.w.to_array(), [0.0, 0.0, 1.0], "w points against the view");
/// # Ok::<(), halfline::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// The origin of all viewing rays; orthographic rays start on the plane through it perpendicular to the view.
    pub eye: DVec3,
    /// The direction of the view.
    pub look: Look,
    /// The scene's up direction, not necessarily the image's; any length.
    pub up: DVec3,
    /// The viewport.
    pub lens: Lens,
}

/// The direction of the view.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Look {
    /// Towards this point.
    At(DVec3),
    /// In this direction, of any length but zero.
    View(DVec3),
}

/// The viewport as specified. It lies at `distance` in front of the eye, in any unit: only ratios matter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Lens {
    /// The lecture's numbers: vw x vh at distance d.
    Viewport {
        /// Width, vw.
        vw: f64,
        /// Height, vh.
        vh: f64,
        /// d.
        distance: f64,
    },
    /// Full height as an angle; the width follows from the aspect ratio of the image.
    Vfov {
        /// Degrees between 0 and 180.
        degrees: f64,
        /// d.
        distance: f64,
    },
    /// NFF's angle: from the centre of the top row of pixels to the centre of the bottom row, at distance 1.
    RowCentres {
        /// Degrees between 0 and 180.
        degrees: f64,
    },
    /// Focal lengths and principal point in pixels, from the top left corner of the image: the centre of its first pixel is
    /// (0.5, 0.5). The principal point may lie anywhere; it is rounded to a half or to a small share of a pixel, see
    /// [`CameraRecord::new`].
    Intrinsics {
        /// Focal length across.
        fx: f64,
        /// Focal length down.
        fy: f64,
        /// Column of the principal point.
        cx: f64,
        /// Row of the principal point.
        cy: f64,
    },
    /// A lens with distortion, a fisheye or a panorama; its rays come from [`Curve`], and it has no viewport. Its viewing rays are found
    /// as given rays are ([`trace`](mod@crate::trace)).
    Curved {
        /// The model.
        curve: Curve,
        /// Focal length across, pixels; of a panorama pixels per radian.
        fx: f64,
        /// Focal length down.
        fy: f64,
        /// Column of the principal point.
        cx: f64,
        /// Row of the principal point.
        cy: f64,
    },
    /// Parallel rays: a view of this height, whose width follows from the aspect ratio of the image. A hit's t,
    /// distance and depth are equal: its distance from the plane of the eye.
    Orthographic {
        /// Full height, in the scene's unit.
        height: f64,
    },
}

impl Lens {
    /// A panorama in an image of `width` x `height` pixels, with the view in its middle.
    #[must_use]
    pub fn panorama(width: u32, height: u32) -> Self {
        let [w, h] = [width, height].map(f64::from);
        Self::Curved { curve: Curve::Panorama, fx: w / TAU, fy: h / PI, cx: w / 2.0, cy: h / 2.0 }
    }

    /// A fisheye in an image of `width` x `height` pixels with the view in its middle, by the angle of its full height in degrees and OpenCV's
    /// k1 to k4; without coefficients image heights are proportional to the angle (equidistant).
    #[must_use]
    pub fn fisheye(degrees: f64, k: [f64; 4], width: u32, height: u32) -> Self {
        let [w, h] = [width, height].map(f64::from);
        let focal = h / 2.0 / curved::image_height(k, degrees.to_radians() / 2.0);
        Self::Curved { curve: Curve::Fisheye { k }, fx: focal, fy: focal, cx: w / 2.0, cy: h / 2.0 }
    }

    /// Whether its rays are not those through a plane.
    #[must_use]
    pub fn is_curved(&self) -> bool {
        matches!(self, Self::Curved { .. })
    }

    /// Checks that it has a viewport, which `what` needs.
    ///
    /// # Errors
    /// [`Error::Scene`] for a curved lens, with the mend.
    pub fn check_flat(&self, what: &str, mend: &str) -> Result<()> {
        let problem =
            format!("{what} needs the viewport of a perspective or orthographic camera, and this lens has {CURVED}");
        if self.is_curved() { Err(wrong("lens", problem, mend)) } else { Ok(()) }
    }

    /// Whether it sees all around.
    #[must_use]
    pub fn is_panorama(&self) -> bool {
        matches!(self, Self::Curved { curve: Curve::Panorama, .. })
    }

    /// Whether all viewing rays are parallel.
    #[must_use]
    pub fn is_orthographic(&self) -> bool {
        matches!(self, Self::Orthographic { .. })
    }
}

/// The basis of the lecture: e and the orthonormal u (right), v (up), w (back), each component within 2^-52 of the
/// exact one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Basis {
    /// The eye.
    pub e: DVec3,
    /// Right.
    pub u: DVec3,
    /// Up in the image.
    pub v: DVec3,
    /// Back, against the view.
    pub w: DVec3,
}

impl Basis {
    /// A vector by its components to the right, up and back, in the world. Given rays of a curved lens are exact by these operations.
    #[inline(always)]
    pub(crate) fn to_world(self, [right, up, back]: [f64; 3]) -> DVec3 {
        self.u * right + self.v * up + self.w * back
    }
}

/// `up` and `view` count as parallel when |up x view| <= PARALLEL |up||view|.
///
/// Half an ulp in every component of both vectors moves up x view by at most 2 sqrt(3) 2^-53 |up||view|. Below about
/// twice that (8 2^-53, about 9e-16 rad) the last digits of the input would determine the roll of the camera.
pub const PARALLEL: f64 = 8.0 / (1u64 << 53) as f64;

/// The farthest principal point, in pixels: frames have at most 2^20 columns.
const FARTHEST_CENTER: f64 = (1 << 18) as f64;

impl Camera {
    /// The canonical camera of the lecture: eye at the origin, looking down -z, viewport 1 x 1 at distance 1.
    pub const CANONICAL: Self = Self {
        eye: DVec3::ZERO,
        look: Look::View(DVec3::NEG_Z),
        up: DVec3::Y,
        lens: Lens::Viewport { vw: 1.0, vh: 1.0, distance: 1.0 },
    };

    /// The basis from eye + view + up, or from eye + at + up with view = at - eye: w against the view, u = up x w and v
    /// = w x u, normalised. Computed with exact numbers, so a scene may be as small as 1e-320 and `up` almost parallel
    /// to the view.
    ///
    /// # Errors
    /// [`Error::Scene`] for numbers that are not finite, eye = at, a zero view, a zero up, and up parallel to the view
    /// within [`PARALLEL`].
    pub fn basis(&self) -> Result<Basis> {
        let [u, v, w] = self.axes()?.map(|axis| DVec3::from_array(axis.map(Dd::value)));
        Ok(Basis { e: self.eye, u, v, w })
    }

    /// u, v and w in double-double, each component within 2^-104 of itself (away from the subnormal numbers).
    ///
    /// Sums and products are exact; the only errors are one square root and one quotient of 128 bits and the rounding
    /// to 106. Double-double arithmetic would lose 2^-105 / sin(up, view) of u, which is visible with a field of view
    /// of 1e-17 rad where `up` is almost parallel to the view.
    pub(crate) fn axes(&self) -> Result<[Dd3; 3]> {
        let (look, target) = match self.look {
            Look::At(p) => ("at", p),
            Look::View(p) => ("view", p),
        };
        for (field, vector) in [("eye", self.eye), (look, target), ("up", self.up)] {
            if !vector.is_finite() {
                let problem = format!("({}, {}, {}) is not finite", vector.x, vector.y, vector.z);
                return Err(wrong(field, problem, "give three finite numbers"));
            }
        }
        let view = match self.look {
            Look::At(at) => dyadic::minus(&dyadic::vector(at.to_array()), &dyadic::vector(self.eye.to_array())),
            Look::View(view) => dyadic::vector(view.to_array()),
        };
        let up = dyadic::vector(self.up.to_array());
        let square = |a: &Dyadic3| dyadic::dot(a, a);
        let (view2, up2) = (square(&view), square(&up));
        if view2.is_zero() {
            return Err(match self.look {
                Look::At(_) => wrong("at", "eye and at are the same point", "move at or eye, or use view"),
                Look::View(_) => wrong("view", "the view has length zero", "use a vector with a direction"),
            });
        }
        if up2.is_zero() {
            return Err(wrong("up", "the up vector has length zero", "use a vector with a direction"));
        }
        let back = view.map(|x| -x);
        let right = dyadic::cross(&up, &back);
        let sine = square(&right).over(&(&up2 * &view2), 64).to_f64().sqrt();
        if sine <= PARALLEL {
            let problem = format!(
                "up is parallel to the view (the sine of their angle is {}, the minimum {})",
                number(sine, 2),
                number(PARALLEL, 2)
            );
            return Err(wrong("up", problem, "use an up vector in another direction"));
        }
        let unit = |a: Dyadic3| -> Dd3 {
            let length = square(&a).sqrt(128);
            a.map(|x| x.over(&length, 128).to_dd())
        };
        let above = dyadic::cross(&back, &right);
        Ok([unit(right), unit(above), unit(back)])
    }

    /// Magnifies the image of `width` x `height` pixels by `factor` about its principal point, the middle for most
    /// lenses: its viewport is narrower by that factor, and the eye stays, so that the perspective does too. The
    /// viewport's numbers are rounded here, once, and are exact from here on. The width of an orthographic view still
    /// follows from its height. A curved lens keeps its coefficients.
    ///
    /// # Errors
    /// Errors of [`Camera::viewport`] and [`Camera::check`], for the lens before and after; [`Error::Scene`] for a panorama.
    pub fn zoom(&mut self, factor: f64, width: u32, height: u32) -> Result<()> {
        if let Lens::Curved { curve, fx, fy, cx, cy } = self.lens {
            if curve == Curve::Panorama {
                let problem = format!("{ZOOM} needs a lens with a focal length, and this one shows the whole sphere");
                return Err(wrong("lens", problem, &format!("remove {ZOOM}, or use a fisheye")));
            }
            self.lens = Lens::Curved { curve, fx: fx * factor, fy: fy * factor, cx, cy };
            return self.check(width, height);
        }
        let Viewport { vw, vh, d } = self.viewport(width, height)?;
        self.lens = match self.lens {
            Lens::Orthographic { height } => Lens::Orthographic { height: height / factor },
            // The same principal point.
            Lens::Intrinsics { fx, fy, cx, cy } => Lens::Intrinsics { fx: fx * factor, fy: fy * factor, cx, cy },
            _ => Lens::Viewport { vw: vw / factor, vh: vh / factor, distance: d },
        };
        self.viewport(width, height).map(drop)
    }

    /// Checks the lens for an image of `width` x `height` pixels.
    ///
    /// # Errors
    /// Errors of [`Camera::viewport`]; [`Error::Settings`] for coefficients of a curved lens that are not finite, and for focal lengths that
    /// are not positive.
    pub fn check(&self, width: u32, height: u32) -> Result<()> {
        match self.lens {
            Lens::Curved { curve, fx, fy, cx, cy } => {
                CurvedRays::new(curve, [fx, fy, cx, cy], [width, height]).map(drop)
            }
            _ => self.viewport(width, height).map(drop),
        }
    }

    /// The viewport of the rays about the axis: by the focal lengths where the lens is curved, else [`Camera::viewport`].
    ///
    /// # Errors
    /// Errors of [`Camera::viewport`].
    pub fn central_viewport(&self, width: u32, height: u32) -> Result<Viewport> {
        match self.lens {
            Lens::Curved { fx, fy, .. } => {
                Ok(Viewport { vw: f64::from(width) / fx, vh: f64::from(height) / fy, d: 1.0 })
            }
            _ => self.viewport(width, height),
        }
    }

    /// The viewport (vw, vh, d) for an image of `width` x `height` pixels. Its three numbers are exact from here on,
    /// however they were given: with an angle, vh = 2 d tan(angle/2) and vw = vh W/H are rounded here, once. Where fx and fy
    /// differ, vh = H fx/fy is rounded for the caller alone; rays have the quotient itself.
    ///
    /// # Errors
    /// [`Error::Scene`] for a viewport, distance or angle that is not positive and finite, or an angle of 180 degrees
    /// or more.
    pub fn viewport(&self, width: u32, height: u32) -> Result<Viewport> {
        let positive = |field: &str, x: f64| {
            if x > 0.0 && x.is_finite() {
                return Ok(x);
            }
            Err(wrong(field, format!("expected a positive finite number, found {x}"), "use a positive number"))
        };
        let tall = |field: &str, degrees: f64, distance: f64| {
            if !(degrees > 0.0 && degrees < 180.0) {
                let problem = format!("the angle is {degrees} degrees");
                return Err(wrong(field, problem, "use an angle between 0 and 180, ends excluded"));
            }
            Ok(2.0 * distance * (degrees.to_radians() / 2.0).tan())
        };
        let shaped = |vh: f64| vh * f64::from(width) / f64::from(height);
        let (vw, vh, d) = match self.lens {
            Lens::Orthographic { height } => {
                let vh = positive("height", height)?;
                return Ok(Viewport { vw: positive("height", shaped(vh))?, vh, d: f64::INFINITY });
            }
            Lens::Viewport { vw, vh, distance } => (vw, vh, distance),
            Lens::Curved { .. } => {
                let problem = "a lens with distortion, a fisheye or a panorama has no viewport";
                return Err(wrong("lens", problem, "use a perspective or orthographic camera for this"));
            }
            Lens::Intrinsics { fx, fy, cx, cy } => {
                let (fx, fy) = (positive("fx", fx)?, positive("fy", fy)?);
                for (field, x) in [("cx", cx), ("cy", cy)] {
                    if x.is_nan() || x.abs() > FARTHEST_CENTER {
                        let problem = format!("the principal point is {x}");
                        return Err(wrong(field, problem, "give it in pixels, at most 2^18 from the image's corner"));
                    }
                }
                let vh = f64::from(height) * (fx / fy);
                if !(vh > 0.0 && vh.is_finite()) {
                    return Err(too_unlike(fx, fy));
                }
                (f64::from(width), vh, fx)
            }
            Lens::Vfov { degrees, distance } => {
                let vh = tall("vfov", degrees, positive("distance", distance)?)?;
                (shaped(vh), vh, distance)
            }
            Lens::RowCentres { degrees } => {
                let rows = f64::from(height);
                let centres = tall("angle", degrees, 1.0)?;
                let vh = if height == 1 { centres } else { centres * rows / (rows - 1.0) };
                (shaped(vh), vh, 1.0)
            }
        };
        Ok(Viewport { vw: positive("viewport", vw)?, vh: positive("viewport", vh)?, d: positive("distance", d)? })
    }
}

/// The error of a camera whose field of this name is wrong.
fn wrong(field: &str, problem: impl Into<String>, mend: &str) -> Error {
    Error::scene(Place::field(format!("camera.{field}")), problem, mend)
}

/// The error of focal lengths whose quotient is no f64.
fn too_unlike(fx: f64, fy: f64) -> Error {
    let problem = format!("fx is {fx:?} and fy is {fy:?}, whose quotient is beyond f64");
    wrong("fx", problem, "give both focal lengths in pixels, such as 525")
}

/// The viewport of the lecture: vw x vh at distance d.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewport {
    /// Width; for an orthographic camera in the scene's unit.
    pub vw: f64,
    /// Height; for an orthographic camera in the scene's unit.
    pub vh: f64,
    /// Distance from the eye; infinite for an orthographic camera, whose rays are parallel.
    pub d: f64,
}

impl Viewport {
    /// Whether the rays through it are parallel.
    pub(crate) fn is_parallel(&self) -> bool {
        self.d.is_infinite()
    }
}
