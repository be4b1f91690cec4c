//! Lenses whose pictures are not projections onto a plane: with distortion, fisheyes and panoramas. Each point of the image has a viewing ray
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

use glam::{DMat2, DVec2, DVec3};
use halfline_ground::error::{Error, Result};
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
    pub(super) size: DVec2,
    /// The farthest point of the image from the axis, in focal lengths.
    reach: f64,
    /// The largest radius on the plane, or the largest angle, up to which heights grow; beyond it the model folds.
    fold: f64,
}

/// Newton steps, and halves of a step: convergence is quadratic, and far from the solution steps are too long.
const STEPS: usize = 64;

/// The distance from the place in the image, relative to its height, at which the search ends: eight roundings of f64.
const ROUNDED: f64 = 1.0 / (1u64 << 49) as f64;

/// The largest distance from the place in the image, in focal lengths, relative to its height, or to the reach of the image where that is
/// larger and below 1: thousands of roundings of f64.
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
        let corners = [DVec2::ZERO, size, DVec2::new(size.x, 0.0), DVec2::new(0.0, size.y)];
        let reach = corners.map(|corner| ((corner - center) / focal).length()).into_iter().fold(0.0, f64::max);
        Ok(Self { curve, focal, center, size, reach, fold: first_fold(curve, reach) })
    }

    /// The point of the image, in pixels from its upper left corner, whose viewing ray has this direction: right, down and ahead; also beyond
    /// the edges of the image. `None` where no ray of the lens has it.
    pub(crate) fn point(&self, direction: DVec3) -> Option<[f64; 2]> {
        let (flat, along) = (direction.truncate(), direction.z);
        let place = match self.curve {
            Curve::Distorted { k, p } => {
                let place = Some(flat / along).filter(|place| along > 0.0 && place.length() <= self.fold)?;
                distorted(k, p, place).0
            }
            Curve::Fisheye { k } => {
                let out = flat.length();
                let angle = Some(out.atan2(along)).filter(|angle| *angle <= self.fold)?;
                if out > 0.0 { flat * (image_height(k, angle) / out) } else { DVec2::ZERO }
            }
            Curve::Panorama => {
                let longitude = direction.x.atan2(along) / (2.0 * PI) + 0.5;
                let latitude = 0.5 + direction.y.atan2(direction.x.hypot(along)) / PI;
                return Some([longitude * self.size.x, latitude * self.size.y]);
            }
        };
        let point = (place * self.focal + self.center).to_array();
        // Of the directions that a folded model projects there the ray has one.
        let ray = self.direction(point)?.normalize();
        Some(point).filter(|_| ray.distance(direction.normalize()) <= SAME_RAY)
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

    /// Pixels in a radian at a direction of length 1, the mean of all directions across it; of a panorama at its equator. 0 at the edge of what
    /// the lens sees.
    pub(crate) fn scale(&self, toward: DVec3) -> f64 {
        if self.curve == Curve::Panorama {
            return (self.size.x / (2.0 * PI) * self.size.y / PI).sqrt();
        }
        let across = toward.any_orthonormal_vector();
        let slope = |axis: DVec3| {
            let [a, b] = [STEP, -STEP].map(|step| self.point(toward + step * axis).map(DVec2::from));
            Some((a? - b?) / (2.0 * STEP))
        };
        let area = slope(across).zip(slope(toward.cross(across))).map(|(a, b)| a.perp_dot(b).abs());
        area.unwrap_or(0.0).sqrt()
    }

    /// The place on the plane at distance 1 whose distorted place this is, by Newton's method.
    fn undistorted(&self, k: [f64; 6], p: [f64; 2], place: DVec2) -> Option<DVec2> {
        let mut found = place * (self.fold / place.length()).min(1.0);
        let (mut reached, mut slopes) = distorted(k, p, found);
        for _ in 0..STEPS {
            let error = reached - place;
            // At the rounding of f64 no step comes nearer, and all halves would be tried.
            if error.length() <= ROUNDED * place.length() {
                break;
            }
            let step = slopes.inverse() * error;
            // The longest of the step and its halves that comes nearer; none at the rounding of f64.
            let tried = (0..STEPS).map(|n| found - step * 0.5_f64.powi(n as i32));
            let nearer = |next: &DVec2| (distorted(k, p, *next).0 - place).length() < error.length();
            let Some(next) = tried.into_iter().find(nearer) else { break };
            found = next;
            (reached, slopes) = distorted(k, p, found);
        }
        let is_precise = (reached - place).length() <= PRECISE * place.length().max(self.reach.min(1.0));
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
}

/// The largest distance of the unit directions of one ray: roundings, which grow without end toward a fold.
const SAME_RAY: f64 = 1e-6;

/// The step of the differences that give a scale, radians: small against curves, and large against roundings.
const STEP: f64 = 1e-6;

/// A distorted lens may see this many times farther from its axis than the corner of its image is.
const FARTHEST: f64 = 1024.0;

/// Radii at which a fold is looked for, to the reach of the image.
const FOLD_STEPS: f64 = 2048.0;

/// The radius or angle at which the heights of an image stop growing, without the tangential part; +inf where they grow as far as an image of
/// this reach can see. It is looked for in steps of the reach, and beyond that in steps that grow with the radius.
fn first_fold(curve: Curve, reach: f64) -> f64 {
    // The height, and its derivative.
    let height = |x: f64| match curve {
        Curve::Distorted { k, .. } => {
            let (s, slope) = radial(k, x * x);
            (x * s, s + 2.0 * x * x * slope)
        }
        Curve::Fisheye { k: [k1, k2, k3, k4] } => {
            let square = x * x;
            let slope = 1.0 + square * (3.0 * k1 + square * (5.0 * k2 + square * (7.0 * k3 + square * 9.0 * k4)));
            (image_height([k1, k2, k3, k4], x), slope)
        }
        Curve::Panorama => (x, 1.0),
    };
    let (most, unfolded) = match curve {
        Curve::Fisheye { .. } => (PI, PI),
        _ => (FARTHEST * reach, f64::INFINITY),
    };
    let (mut low, mut below) = (0.0, 0.0);
    while low < most {
        let mut high = (low + low.max(reach) / FOLD_STEPS).min(most);
        let grows = |x: f64| {
            let (height, slope) = height(x);
            slope > 0.0 && height > below
        };
        if high <= low || grows(high) {
            (low, below) = (if high > low { high } else { most }, height(high).0);
            continue;
        }
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                return low;
            }
            if grows(middle) { low = middle } else { high = middle }
        }
    }
    unfolded
}

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
pub(super) fn image_height([k1, k2, k3, k4]: [f64; 4], angle: f64) -> f64 {
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
    fn points_are_where_the_models_project_directions() {
        let size = [640.0, 480.0];
        for (curve, focal) in LENSES {
            let rays = CurvedRays::new(curve, focal, [640, 480]).expect("a lens");
            let mut count = 0;
            for (i, j) in (0..60).flat_map(|i| (0..60).map(move |j| (i, j))) {
                let [a, b] = [i, j].map(|n| f64::from(n) / 30.0 - 0.983);
                for direction in [DVec3::new(a, b, 0.9), DVec3::new(a, b, -0.4), DVec3::new(0.5, a, b)] {
                    let Some(point) = rays.point(direction) else { continue };
                    let expected = place(curve, focal, size, direction);
                    assert!((0..2).all(|k| (point[k] - expected[k]).abs() < 1e-9), "{curve:?} {direction}: {point:?}");
                    let ray = rays.direction(point).expect("a ray").normalize();
                    assert!(ray.distance(direction.normalize()) < 1e-6, "{curve:?} {direction}: {ray}");
                    count += 1;
                }
            }
            assert!(count > 2000, "{curve:?}: {count}");
            // Behind the plane, and at the axis.
            let is_all = matches!(curve, Curve::Panorama | Curve::Fisheye { .. });
            assert_eq!(rays.point(DVec3::new(0.3, 0.1, -1.0)).is_some(), is_all, "{curve:?}");
            assert_eq!(rays.point(DVec3::Z).map(|at| at.map(f64::round)), Some([focal[2], focal[3]].map(f64::round)));
        }
    }

    /// A lens of another focal length whose coefficients are scaled alike has the rays of the first, scaled: the same pixels have none.
    #[test]
    fn lenses_are_alike_over_decades_of_focal_lengths() {
        let shapes = [
            Curve::Distorted { k: [-0.28, 0.09, -0.012, 0.0, 0.0, 0.0], p: [1e-3, -7e-4] },
            Curve::Distorted { k: [-0.9, 0.0, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] },
            Curve::Distorted { k: [0.3, -0.5, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] },
            Curve::Distorted { k: [0.0, 0.0, 0.0, -0.9, 0.1, 0.0], p: [0.0; 2] },
        ];
        let image = [32, 24];
        let pixels: Vec<[f64; 2]> =
            (0..24).flat_map(|i| (0..32).map(move |j| [f64::from(j) + 0.5, f64::from(i) + 0.5])).collect();
        for shape in shapes {
            let lens = |by: f64| {
                let Curve::Distorted { k, p } = shape else { panic!("distorted") };
                let [k1, k2, k3, k4, k5, k6] = k;
                let (two, four, six) = (by.powi(2), by.powi(4), by.powi(6));
                let k = [k1 * two, k2 * four, k3 * six, k4 * two, k5 * four, k6 * six];
                CurvedRays::new(Curve::Distorted { k, p: p.map(|p| p * by) }, [20.0 * by, 20.0 * by, 16.0, 12.0], image)
                    .expect("a lens")
            };
            let directions =
                |rays: CurvedRays| pixels.iter().map(|at| rays.direction(*at)).collect::<Vec<Option<DVec3>>>();
            let near = directions(lens(1.0));
            let rays = near.iter().flatten().count();
            assert!((100..=768).contains(&rays), "{shape:?}: {rays}");
            for decade in [-2, -1, 1, 2, 3, 4, 6, 9, 12] {
                let by = 10f64.powi(decade);
                for ((a, b), at) in near.iter().zip(directions(lens(by))).zip(&pixels) {
                    match (a, b) {
                        (Some(a), Some(b)) => {
                            let apart = (a.truncate() - by * b.truncate()).length();
                            // Far from folds; at them a rounding moves the ray by its root.
                            assert!(apart < 1e-5 * a.truncate().length().max(0.1), "{shape:?} {by} {at:?}: {a} {b}");
                        }
                        (None, None) => {}
                        _ => panic!("{shape:?} times {by} at {at:?}: {a:?} {b:?}"),
                    }
                }
            }
        }
        // The lens of a telescope: 32 of its pixels are 3.2e-5 of a focal length, and its rays grow up to 3.65e-5.
        let k = [-2.5e8, 0.0, 0.0, 0.0, 0.0, 0.0];
        let rays = CurvedRays::new(Curve::Distorted { k, p: [0.0; 2] }, [1e6, 1e6, 16.0, 12.0], image).expect("a lens");
        assert!(pixels.iter().all(|at| rays.direction(*at).is_some()));
        // A fisheye as long.
        let rays = CurvedRays::new(Curve::Fisheye { k: [-2.5e8, 0.0, 0.0, 0.0] }, [1e6, 1e6, 16.0, 12.0], image);
        let rays = rays.expect("a lens");
        assert!(pixels.iter().all(|at| rays.direction(*at).is_some()));
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
