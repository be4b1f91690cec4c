//! Lenses whose pictures are not those of a plane: with distortion, fisheyes and panoramas. Each point of the image has a viewing ray
//! in f64, which is exact from there on.
//!
//! With X to the right, Y down and Z ahead, a direction has the place x = X/Z, y = Y/Z on the plane at distance 1, and the angle theta
//! from the axis. Models, by docs.opencv.org (calib3d, fisheye):
//!
//! ```text
//! distorted   s = (1 + k1 r^2 + k2 r^4 + k3 r^6)/(1 + k4 r^2 + k5 r^4 + k6 r^6),  r^2 = x^2 + y^2
//!             x' = x s + 2 p1 x y + p2 (r^2 + 2 x^2)      y' = y s + p1 (r^2 + 2 y^2) + 2 p2 x y
//! fisheye     t = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
//!             x' = t X/sqrt(X^2 + Y^2)                    y' = t Y/sqrt(X^2 + Y^2)
//! pixel       fx x' + cx, fy y' + cy
//! ```
//!
//! A *panorama* (equirectangular) has the longitude 2 pi (px/W - 1/2) and the latitude pi (1/2 - py/H).

use crate::error::{Error, Result};
use glam::{DMat2, DVec2, DVec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A lens with distortion, a fisheye or a panorama.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Curve {
    /// A perspective lens with distortion.
    Distorted {
        /// k1 to k6.
        k: [f64; 6],
        /// p1 and p2.
        p: [f64; 2],
    },
    /// A lens whose image heights grow with the angle.
    Fisheye {
        /// k1 to k4.
        k: [f64; 4],
    },
    /// All directions: longitudes across and latitudes down. It has no focal lengths.
    Panorama,
}

/// The rays of a curve for an image.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CurvedRays {
    curve: Curve,
    focal: DVec2,
    center: DVec2,
    size: DVec2,
    /// The largest image height, of the radius on the plane or of the angle, up to which heights grow; beyond it the model folds.
    fold: f64,
}

/// Newton steps, and halves of a step: convergence is quadratic, and far from the solution steps are too long.
const STEPS: usize = 64;

/// The largest distance from the place in the image, in focal lengths, relative to its height where that is above 1: thousands of roundings
/// of f64, and a millionth of a pixel of the longest lens.
const PRECISE: f64 = 1e-12;

impl CurvedRays {
    /// # Errors
    /// [`Error::Settings`] for numbers that are not finite and focal lengths that are not positive.
    pub(crate) fn new(curve: Curve, [fx, fy, cx, cy]: [f64; 4], [width, height]: [u32; 2]) -> Result<Self> {
        let given: &[f64] = match &curve {
            Curve::Distorted { k, p } => &[&k[..], &p[..]].concat(),
            Curve::Fisheye { k } => k,
            Curve::Panorama => &[],
        };
        if let Some(x) = given.iter().chain(&[cx, cy]).find(|x| !x.is_finite()) {
            return Err(Error::settings(format!("a coefficient of the lens is {x}"), "use finite numbers"));
        }
        if ![fx, fy].iter().all(|focal| *focal > 0.0 && focal.is_finite()) {
            let problem = format!("the focal lengths {fx:?}, {fy:?} are not positive finite numbers");
            return Err(Error::settings(problem, "give them in pixels, such as 525"));
        }
        let (focal, center) = (DVec2::new(fx, fy), DVec2::new(cx, cy));
        let size = DVec2::new(f64::from(width), f64::from(height));
        let mut rays = Self { curve, focal, center, size, fold: f64::INFINITY };
        rays.fold = rays.first_fold();
        Ok(rays)
    }

    /// The direction of the viewing ray of a point of the image, in pixels from its upper left corner: right, down and ahead. `None` where
    /// the model gives the point none: beyond its fold, or behind a fisheye's full circle.
    pub(crate) fn direction(&self, point: [f64; 2]) -> Option<DVec3> {
        let place = (DVec2::from_array(point) - self.center) / self.focal;
        match self.curve {
            Curve::Distorted { k, p } => self.undistorted(k, p, place).map(|place| place.extend(1.0)),
            Curve::Fisheye { k } => {
                let height = place.length();
                let angle = self.angle(k, height)?;
                let (sine, cosine) = angle.sin_cos();
                let across = if height > 0.0 { place * (sine / height) } else { DVec2::ZERO };
                Some(across.extend(cosine))
            }
            Curve::Panorama => {
                let share = DVec2::from_array(point) / self.size;
                let (sine, cosine) = (2.0 * PI * (share.x - 0.5)).sin_cos();
                let (up, out) = (PI * (0.5 - share.y)).sin_cos();
                Some(DVec3::new(out * sine, -up, out * cosine))
            }
        }
    }

    /// The place on the plane at distance 1 whose distorted place this is, by Newton's method.
    fn undistorted(&self, k: [f64; 6], p: [f64; 2], place: DVec2) -> Option<DVec2> {
        let mut found = place * (self.fold / place.length()).min(1.0);
        let (mut reached, mut slopes) = distorted(k, p, found);
        for _ in 0..STEPS {
            let error = reached - place;
            let step = slopes.inverse() * error;
            // The longest of the step and its halves that comes nearer; none at the rounding of f64.
            let tried = (0..STEPS).map(|n| found - step * 0.5_f64.powi(n as i32));
            let nearer = |next: &DVec2| (distorted(k, p, *next).0 - place).length() < error.length();
            let Some(next) = tried.into_iter().find(nearer) else { break };
            found = next;
            (reached, slopes) = distorted(k, p, found);
        }
        let is_precise = (reached - place).length() <= PRECISE * place.length().max(1.0);
        Some(found).filter(|found| is_precise && found.length() <= self.fold && slopes.determinant() > 0.0)
    }

    /// The angle from the axis with this image height, by bisection within the growing part.
    fn angle(&self, k: [f64; 4], height: f64) -> Option<f64> {
        let most = self.fold.min(PI);
        if height > image_height(k, most) {
            return None;
        }
        let (mut low, mut high) = (0.0, most);
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                return Some(if height - image_height(k, low) < image_height(k, high) - height { low } else { high });
            }
            if image_height(k, middle) < height { low = middle } else { high = middle }
        }
    }

    /// The radius or angle at which image heights stop growing, without the tangential part; +inf where they grow as far as an image can
    /// reach.
    fn first_fold(&self) -> f64 {
        let corners = [DVec2::ZERO, self.size, DVec2::new(self.size.x, 0.0), DVec2::new(0.0, self.size.y)];
        let reach =
            corners.map(|corner| ((corner - self.center) / self.focal).length()).into_iter().fold(0.0, f64::max);
        let height = |x: f64| match self.curve {
            Curve::Distorted { k, .. } => x * radial(k, x * x).0,
            Curve::Fisheye { k } => image_height(k, x),
            Curve::Panorama => x,
        };
        let is_fisheye = matches!(self.curve, Curve::Fisheye { .. });
        // Steps so small that a fold is a fold of the image, not of rounding.
        let most = if is_fisheye { PI } else { FARTHEST * reach.max(1.0) };
        let step = |n: u32| most * f64::from(n) / f64::from(FOLD_STEPS);
        let grows = |n: &u32| height(step(*n)) > height(step(n - 1));
        match (1..=FOLD_STEPS).find(|n| !grows(n)) {
            Some(n) => step(n - 1),
            None if is_fisheye => PI,
            None => f64::INFINITY,
        }
    }
}

/// A distorted lens may see this many times farther from its axis than the corner of its image is.
const FARTHEST: f64 = 8.0;

/// Radii at which a fold is looked for.
const FOLD_STEPS: u32 = 1 << 14;

/// The radial factor s and its derivative by r^2.
fn radial([k1, k2, k3, k4, k5, k6]: [f64; 6], square: f64) -> (f64, f64) {
    let above = 1.0 + square * (k1 + square * (k2 + square * k3));
    let below = 1.0 + square * (k4 + square * (k5 + square * k6));
    let above_slope = k1 + square * (2.0 * k2 + square * 3.0 * k3);
    let below_slope = k4 + square * (2.0 * k5 + square * 3.0 * k6);
    (above / below, (above_slope * below - above * below_slope) / (below * below))
}

/// The distorted place of a place on the plane at distance 1, and its derivatives by x and by y.
fn distorted(k: [f64; 6], [p1, p2]: [f64; 2], place: DVec2) -> (DVec2, DMat2) {
    let DVec2 { x, y } = place;
    let square = x * x + y * y;
    let (s, slope) = radial(k, square);
    let at = DVec2::new(
        x * s + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
        y * s + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
    );
    let mixed = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
    let by_x = DVec2::new(s + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x, mixed);
    let by_y = DVec2::new(mixed, s + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x);
    (at, DMat2::from_cols(by_x, by_y))
}

/// The image height t of a fisheye at an angle.
fn image_height([k1, k2, k3, k4]: [f64; 4], angle: f64) -> f64 {
    let square = angle * angle;
    angle * (1.0 + square * (k1 + square * (k2 + square * (k3 + square * k4))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The place of a direction in the image by the model's formulas as OpenCV's documentation writes them.
    fn place(curve: Curve, [fx, fy, cx, cy]: [f64; 4], size: [f64; 2], d: DVec3) -> [f64; 2] {
        let (x, y) = match curve {
            Curve::Distorted { k: [k1, k2, k3, k4, k5, k6], p: [p1, p2] } => {
                let (x, y) = (d.x / d.z, d.y / d.z);
                let r = x.hypot(y);
                let s = (1.0 + k1 * r.powi(2) + k2 * r.powi(4) + k3 * r.powi(6))
                    / (1.0 + k4 * r.powi(2) + k5 * r.powi(4) + k6 * r.powi(6));
                let across = x * s + 2.0 * p1 * x * y + p2 * (r.powi(2) + 2.0 * x.powi(2));
                (across, y * s + p1 * (r.powi(2) + 2.0 * y.powi(2)) + 2.0 * p2 * x * y)
            }
            Curve::Fisheye { k: [k1, k2, k3, k4] } => {
                let out = d.x.hypot(d.y);
                let theta = out.atan2(d.z);
                let t = theta + k1 * theta.powi(3) + k2 * theta.powi(5) + k3 * theta.powi(7) + k4 * theta.powi(9);
                if out == 0.0 { (0.0, 0.0) } else { (t * d.x / out, t * d.y / out) }
            }
            Curve::Panorama => {
                let longitude = d.x.atan2(d.z) / (2.0 * PI) + 0.5;
                let latitude = 0.5 - (-d.y / d.length()).asin() / PI;
                return [longitude * size[0], latitude * size[1]];
            }
        };
        [fx * x + cx, fy * y + cy]
    }

    const LENSES: [(Curve, [f64; 4]); 5] = [
        // A wide lens of an action camera, and the rational model of a depth camera.
        (Curve::Distorted { k: [-0.28, 0.09, -0.012, 0.0, 0.0, 0.0], p: [1e-3, -7e-4] }, [520.0, 523.0, 322.5, 238.0]),
        (Curve::Distorted { k: [0.65, -2.7, 1.6, 0.53, -2.5, 1.5], p: [5e-4, -1e-4] }, [604.0, 604.0, 319.0, 241.5]),
        (Curve::Fisheye { k: [0.0; 4] }, [210.0, 210.0, 320.0, 240.0]),
        (Curve::Fisheye { k: [-0.013, 0.02, -0.01, 0.001] }, [190.0, 195.0, 310.0, 244.0]),
        (Curve::Panorama, [640.0 / (2.0 * PI), 480.0 / PI, 320.0, 240.0]),
    ];

    #[test]
    fn rays_leave_through_the_places_that_the_models_give_them() {
        let size = [640.0, 480.0];
        for (curve, focal) in LENSES {
            let rays = CurvedRays::new(curve, focal, [640, 480]).expect("a lens");
            let mut count = 0;
            for (i, j) in (0..480).step_by(7).flat_map(|i| (0..640).step_by(7).map(move |j| (i, j))) {
                let point = [f64::from(j) + 0.5, f64::from(i) + 0.5];
                let Some(direction) = rays.direction(point) else { continue };
                let found = place(curve, focal, size, direction);
                count += 1;
                for axis in 0..2 {
                    // A millionth of a pixel: PRECISE times the focal length, and roundings of the place.
                    assert!((found[axis] - point[axis]).abs() < 1e-6, "{curve:?} {point:?}: {found:?}");
                }
            }
            assert!(count > 69 * 92 * 9 / 10, "{curve:?}: {count} rays");
        }
    }

    #[test]
    fn a_fold_has_no_rays_beyond_it() {
        // r (1 - r^2/3) grows up to r = 1, where it is 2/3.
        let k = [-1.0 / 3.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let rays = CurvedRays::new(Curve::Distorted { k, p: [0.0; 2] }, [300.0, 300.0, 320.0, 240.0], [640, 480]);
        let rays = rays.expect("a lens");
        let at = |height: f64| rays.direction([320.0 + 300.0 * height, 240.0]);
        assert!(at(0.66).is_some_and(|d| d.x < 1.0) && at(0.67).is_none() && at(0.9).is_none());
        // A fisheye sees no farther than straight back.
        let full =
            CurvedRays::new(Curve::Fisheye { k: [0.0; 4] }, [50.0, 50.0, 320.0, 240.0], [640, 480]).expect("a lens");
        assert!(full.direction([320.0 + 50.0 * (PI - 1e-3), 240.0]).is_some_and(|d| d.z < -0.99));
        assert!(full.direction([320.0 + 50.0 * (PI + 1e-3), 240.0]).is_none());
        assert_eq!(full.direction([320.0, 240.0]), Some(DVec3::Z));
    }

    #[test]
    fn wrong_numbers_are_refused() {
        let of = |curve, focal| CurvedRays::new(curve, focal, [64, 48]).map(drop);
        let nan = Curve::Fisheye { k: [0.0, f64::NAN, 0.0, 0.0] };
        of(nan, [1.0, 1.0, 0.0, 0.0]).expect_err("not a number");
        for focal in
            [[0.0, 1.0, 0.0, 0.0], [1.0, -1.0, 0.0, 0.0], [1.0, f64::INFINITY, 0.0, 0.0], [1.0, 1.0, f64::NAN, 0.0]]
        {
            of(Curve::Fisheye { k: [0.0; 4] }, focal).expect_err("no focal lengths");
        }
    }
}
