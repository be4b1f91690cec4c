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

pub use aperture::Aperture;
pub(crate) use centred::{CentredFrame, ExactViewport};
pub use curved::Curve;
pub(crate) use curved::CurvedRays;
pub(crate) use curved_frame::CurvedFrame;
pub use project::{Projected, Projector};
pub use record::{CameraRecord, Intrinsics};

use crate::double_double::{Dd, Dd3};
use crate::dyadic::{self, Dyadic3};
use crate::error::{Error, Place, Result};
use crate::quote::number;
use crate::quote::setting::ZOOM;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// The words for curved lenses in messages, behind "this lens has".
pub(crate) const CURVED: &str = "distortion or is a fisheye or a panorama";

/// Pose and lens. Every number is taken as exact.
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
    /// A lens with distortion, a fisheye or a panorama; its rays are those of [`Curve`], and it has no viewport. Its viewing rays are found
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

    /// The viewport of the rays about the axis: that of the focal lengths where the lens is curved, else [`Camera::viewport`].
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

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(eye: [f64; 3], look: Look, up: [f64; 3]) -> Camera {
        Camera { eye: eye.into(), look, up: up.into(), lens: Camera::CANONICAL.lens }
    }

    #[test]
    fn the_canonical_basis_is_the_axes() {
        let b = Camera::CANONICAL.basis().expect("canonical");
        assert_eq!((b.e, b.u, b.v, b.w), (DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z));
    }

    #[test]
    fn any_basis_is_orthonormal_right_handed_and_looks_along_the_view() {
        for scale in [1e-300, 1e-20, 1.0, 1e20, 1e300] {
            for view in [[1.0, 2.0, 3.0], [-1.0, 0.0, 1e-9], [0.0, 1.0, 1e-12], [3.0, -4.0, 5e5]] {
                let view = DVec3::from_array(view) * scale;
                let b = camera([1.0, -2.0, 3.0], Look::View(view), [0.0, 1.0, 0.0]).basis().expect("a basis");
                // 2^-50: three products of components that are each within 2^-52.
                let tiny = 2f64.powi(-50);
                for (a, c) in [(b.u, b.v), (b.v, b.w), (b.w, b.u)] {
                    assert!(a.dot(c).abs() <= tiny, "{b:?}");
                    assert!((a.length() - 1.0).abs() <= tiny, "{b:?}");
                }
                assert!((b.u.cross(b.v) - b.w).length() <= tiny, "right-handed {b:?}");
                assert!((b.w + view / scale / (view / scale).length()).length() <= tiny, "against the view {b:?}");
                assert!(b.v.y > 0.0, "up points up {b:?}");
            }
        }
    }

    #[test]
    fn at_and_view_agree_also_far_away_and_at_the_ends_of_the_range() {
        let eye = DVec3::new(1e9, -2e9, 3e9);
        let look = DVec3::new(3.0, -5.0, 7.0);
        let at = camera(eye.into(), Look::At(eye + look), [0.0, 0.0, 1.0]).basis().expect("at");
        let view = camera(eye.into(), Look::View(look), [0.0, 0.0, 1.0]).basis().expect("view");
        assert_eq!(at, view);
        let far = camera([-1.7e308, 0.0, 0.0], Look::At(DVec3::new(1.7e308, 0.0, 0.0)), [0.0, 1.0, 0.0]);
        assert_eq!(far.basis().expect("no overflow").w, DVec3::NEG_X);
    }

    /// A camera of tests/truth/axes.py.
    #[derive(serde::Deserialize)]
    struct Known {
        eye: [String; 3],
        at: Option<[String; 3]>,
        view: Option<[String; 3]>,
        up: [String; 3],
        axes: Vec<(String, String)>,
    }

    #[test]
    fn axes_are_those_of_two_thousand_digits() {
        let known: Vec<Known> = serde_json::from_str(include_str!("../../tests/truth/axes.json")).expect("the fixture");
        assert!(known.len() > 150, "{} cameras", known.len());
        let number = |bits: &String| f64::from_bits(u64::from_str_radix(bits, 16).expect("hexadecimal digits"));
        let vector = |bits: &[String; 3]| DVec3::from_array(bits.each_ref().map(number));
        let mut worst = 0.0f64;
        for case in &known {
            let look = match (&case.at, &case.view) {
                (Some(at), _) => Look::At(vector(at)),
                (_, view) => Look::View(vector(view.as_ref().expect("a view"))),
            };
            let camera = camera(vector(&case.eye).into(), look, vector(&case.up).into());
            let axes = camera.axes().expect("axes");
            for (axis, (near, tail)) in axes.iter().flatten().zip(&case.axes) {
                let (near, tail) = (number(near), tail.parse::<f64>().expect("digits"));
                // Both low words are below an ulp of the high one, so their difference is exact enough.
                let off = ((axis.hi - near) + (axis.lo - tail)).abs();
                // The tail has 20 digits, and the smallest f64 is 2^-1074.
                assert!(off <= near.abs() * 2f64.powi(-104) + 2f64.powi(-1073), "{off:e} of {near:e}: {camera:?}");
                worst = worst.max(off / near.abs().max(f64::MIN_POSITIVE));
            }
        }
        println!("axes are off by 2^{:.1} at most", worst.log2());
    }

    #[test]
    fn a_step_of_the_subnormal_numbers_is_a_direction() {
        let step = f64::from_bits(1);
        let at = |at: [f64; 3]| camera([0.0; 3], Look::At(at.into()), [0.0, 1.0, 0.0]).basis().expect("a direction");
        assert_eq!(at([0.0, 0.0, -step]).w, DVec3::Z);
        // 3 steps right and 1 ahead.
        let w = DVec3::new(-3.0, 0.0, 1.0) / 10f64.sqrt();
        assert!((at([3.0 * step, 0.0, -step]).w - w).length() < 1e-15);
    }

    #[test]
    fn degenerate_cameras_are_refused_with_the_field() {
        let y = [0.0, 1.0, 0.0];
        for (camera, field) in [
            (camera([1.0; 3], Look::At(DVec3::ONE), y), "camera.at"),
            (camera([1.0; 3], Look::View(DVec3::ZERO), y), "camera.view"),
            (camera([1.0; 3], Look::View(DVec3::X), [0.0; 3]), "camera.up"),
            (camera([1.0; 3], Look::View(DVec3::NEG_Y * 1e-20), y), "camera.up"),
            (camera([f64::NAN, 0.0, 0.0], Look::View(DVec3::X), y), "camera.eye"),
            (camera([0.0; 3], Look::View(DVec3::new(f64::INFINITY, 0.0, 0.0)), y), "camera.view"),
        ] {
            let error = camera.basis().expect_err(field).to_string();
            assert!(error.contains(field), "{error}");
        }
    }

    #[test]
    fn nearly_parallel_is_judged_relative_to_the_lengths() {
        let up = |x: f64| camera([0.0; 3], Look::View(DVec3::Y * 1e-20), [x * 1e20, 1e20, 0.0]).basis();
        assert!(up(0.9 * PARALLEL).is_err());
        assert!(up(1.1 * PARALLEL).is_ok());
    }

    #[test]
    fn lenses_give_the_viewport() {
        let lens = |lens| Camera { lens, ..Camera::CANONICAL }.viewport(200, 100);
        let square = lens(Lens::Vfov { degrees: 90.0, distance: 3.0 }).expect("vfov");
        // tan(45 degrees) rounds to within an ulp of 1.
        assert!((square.vh - 6.0).abs() < 1e-14 && (square.vw - 12.0).abs() < 1e-14, "{square:?}");
        let rows = lens(Lens::RowCentres { degrees: 90.0 }).expect("rows");
        assert!((rows.vh * 99.0 / 100.0 - 2.0).abs() < 1e-14, "{rows:?}");
        let parallel = lens(Lens::Orthographic { height: 12.0 }).expect("orthographic");
        assert_eq!(parallel, Viewport { vw: 24.0, vh: 12.0, d: f64::INFINITY });
        for bad in [
            Lens::Vfov { degrees: 180.0, distance: 1.0 },
            Lens::Vfov { degrees: 0.0, distance: 1.0 },
            Lens::Vfov { degrees: 40.0, distance: -1.0 },
            Lens::Viewport { vw: 0.0, vh: 1.0, distance: 1.0 },
            Lens::Viewport { vw: 1.0, vh: f64::INFINITY, distance: 1.0 },
            Lens::RowCentres { degrees: f64::NAN },
            Lens::Orthographic { height: 0.0 },
            Lens::Orthographic { height: f64::NAN },
            Lens::Orthographic { height: 1.7e308 },
        ] {
            lens(bad).expect_err("a lens that opens no viewport");
        }
    }
}
