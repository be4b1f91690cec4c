//! Predicts the worst-case rounding error of a method before anything is rendered: a bound from the spheres' extents
//! alone, for every ray of every picture from this eye. docs/accuracy.md derives it line by line.
//!
//! Two numbers. Each bounds a quantity that a score of `halfline-measure` observes:
//!
//! - *outline*: a ray whose distance l from a sphere's centre differs from its radius r by more than outline * r has
//!   the right answer: no false hit, no false miss;
//! - *distance*: |t - t*| / t* of a correct hit, and of a sphere shown in place of another that is equally near.
//!
//! With k = |p|/r, p from the eye to the centre, the perpendicular form has an outline error of order k u and the
//! lecture's forms of order k^2 u, because they subtract squares of the distance. Near the outline D is small and t has
//! the square root of its error, so distances are worst there.

use super::{Form, Method};
use crate::scene::{Scene, Spheres};
use crate::view::{SphereRecord, View};
use halfline_ground::error::{Error, Result};
use halfline_ground::parallel::{self, CHEAP};
use halfline_ground::quote::number;
use halfline_ground::quote::setting::ACCURACY;
use serde::Serialize;

/// The unit roundoff of WGSL's f32, which may round either way.
const U: f64 = 1.0 / (1u64 << 23) as f64;
/// The host's rounding error of f32, to nearest.
const HOST: f64 = 1.0 / (1u64 << 24) as f64;
/// Relative error of an f64 stored as two f32: the low part holds 24 bits of the remainder, half an ulp at most.
const PAIR: f64 = HOST * HOST;
/// The unit roundoff of f64 on a device, rounding either way.
const U64: f64 = 1.0 / (1u64 << 52) as f64;
/// c - e rotated by the host in f64, as a vector: 5 * 2^-53 |c - e|_1 a component (certify/projection.rs), twice sqrt(3).
const ROTATED: f64 = 15.0 / (1u64 << 53) as f64;
/// The power of the eye from double-double, in a unit in which max(|p|, r) is at least 1 and the terms below 16.
const POWER: f64 = HOST * HOST * HOST / (1u64 << 20) as f64;
/// t times a length, in f64 on the host: about ten roundings.
const ASSEMBLED: f64 = 1.0 / (1u64 << 49) as f64;
/// The largest norm of (a_y b_z + a_z b_y, ...) for unit vectors, sqrt(4/3) at a = b = (1, 1, 1)/sqrt(3): the sum of
/// the rounding errors of a cross product.
const CROSS: f64 = 1.1548;
/// Numbers below 2^-126 may be flushed; |d| < 4 and a few factors of 2 lie between t and the flushed numbers.
const VANISH: f64 = HOST * HOST * HOST * HOST * HOST / 4.0;
/// Products of two errors, and the rounding of the extents to f32: about ten times 2^-23 of the bound itself, 2^-10
/// where an error is so large that its square matters.
const INFLATE: f64 = 1.0 + 1.0 / 1024.0;

/// Outline errors above this give a warning: a fiftieth of a radius is visible.
const VISIBLE: f64 = 0.02;

/// A-priori bounds of one method on one scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Prediction {
    /// Bound of the error of an outline, in radii of its sphere.
    pub outline: f64,
    /// Bound of the relative error of a distance; infinite where there is no bound.
    pub distance: f64,
    /// The sphere with the worst of both, by its index in the scene's order.
    pub sphere: u32,
    /// The distance of that sphere's centre from the eye, in its radii.
    pub radii: f64,
}

impl Prediction {
    /// The prediction for `method` on `scene`; `None` without spheres.
    ///
    /// # Errors
    /// Errors of [`View::new`]; [`Error::Settings`] for an orthographic camera, which uncertified methods do not
    /// support.
    pub fn of(scene: &Scene, method: Method) -> Result<Option<Self>> {
        if scene.camera.lens.is_orthographic() {
            let problem =
                "uncertified methods do not support orthographic cameras, and certified answers need no prediction";
            return Err(Error::settings(problem, "render without a prediction, or give the camera a vfov"));
        }
        Ok(Self::of_view(&View::without_spheres(scene)?, scene, method))
    }

    /// The prediction for the spheres of `scene`, seen from its view.
    pub(crate) fn of_view(view: &View, scene: &Scene, method: Method) -> Option<Self> {
        let Spheres { centers, radii, .. } = &scene.spheres;
        let spheres = view.moved(centers, radii);
        let one = |id: usize| Self::of_sphere(&Extent::of(&spheres[id]), id as u32, method);
        let all = parallel::blocks(0..spheres.len(), CHEAP, &|ids, _| ids.map(one).reduce(Self::and));
        all.into_iter().flatten().reduce(Self::and)
    }

    fn of_sphere(extent: &Extent, sphere: u32, method: Method) -> Self {
        let [outline, distance] = match method.form() {
            Form::Perpendicular => perpendicular(&Roundings::of(method), extent),
            Form::General => lecture(&general(extent), extent),
            Form::Normalised => lecture(&normalised(extent), extent),
        };
        // NaN means that there is no bound.
        let sure = |x: f64| if x.is_nan() { f64::INFINITY } else { INFLATE * x };
        Self { outline: sure(outline), distance: sure(distance), sphere, radii: extent.k }
    }

    /// The worse of both; for equally bad spheres the first.
    fn and(self, other: Self) -> Self {
        let worse = other.worst() > self.worst() || other.worst() == self.worst() && other.sphere < self.sphere;
        let named = if worse { other } else { self };
        Self { outline: self.outline.max(other.outline), distance: self.distance.max(other.distance), ..named }
    }

    /// The larger of both numbers, which is compared with a tolerance.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.outline.max(self.distance)
    }

    /// Whether outlines or distances may be off by so much that a picture shows it.
    pub(crate) fn is_visible(&self) -> bool {
        self.worst() > VISIBLE
    }

    /// A warning with the numbers and a remedy, where the error is visible.
    #[must_use]
    pub fn warning(&self, method: Method) -> Option<String> {
        (self.outline > VISIBLE).then(|| {
            let [outline, distance, radii] = [self.outline, self.distance, self.radii].map(|x| number(x, 2));
            let sphere = self.sphere;
            format!(
                "method {} places outlines only within {outline} radii and distances within {distance}, worst at \
                 sphere {sphere}, {radii} radii away; use {ACCURACY} certified",
                method.name()
            )
        })
    }
}

/// The properties of a sphere that the bounds depend on.
struct Extent {
    /// Distance of its centre in radii.
    k: f64,
    /// Power of the eye in squares of its radius, |k^2 - 1|, exact where k^2 - 1 would cancel.
    power: f64,
    outside: bool,
    /// The error of t due to flushing, relative to the distance of the surface.
    flushed: f64,
}

impl Extent {
    fn of(s: &SphereRecord) -> Self {
        let [x, y, z, r] = s.center_radius.map(f64::from);
        let (far, power) = ((x * x + y * y + z * z).sqrt(), f64::from(s.power));
        // |p| - r = c / (|p| + r).
        let gap = power.abs() / (far + r);
        let flushed = VANISH / (gap * f64::from(s.scale).min(1.0));
        Self { k: far / r, power: power.abs() / (r * r), outside: power > 0.0, flushed }
    }

    /// |k - 1|: the distance of the surface in radii.
    fn gap(&self) -> f64 {
        self.power / (self.k + 1.0)
    }
}

/// Relative errors of an arithmetic: of its inputs and of its operations.
struct Roundings {
    /// Error of p, as a vector.
    center: f64,
    radius: f64,
    /// Error of d, as a vector: viewport and distance rounded, times an exact odd integer.
    direction: f64,
    power: f64,
    add: f64,
    mul: f64,
    div: f64,
    /// WGSL: 2.5 ulp, and sqrt is 1/inverseSqrt of 2 ulp: 4.5 ulp, 4.6 with the second order.
    root: f64,
}

const F32: Roundings = Roundings {
    center: HOST + ROTATED,
    radius: HOST,
    direction: HOST + U,
    power: HOST,
    add: U,
    mul: U,
    div: 2.5 * U,
    root: 4.6 * U,
};

const F64: Roundings = Roundings {
    center: PAIR + ROTATED,
    radius: PAIR,
    direction: PAIR + 2.0 * U64,
    power: PAIR,
    add: U64,
    mul: U64,
    div: 2.5 * U64,
    root: 4.6 * U64,
};

/// Its operations as published (intersect/double_float.rs cites the sources), with v^3 terms in the last digit.
const DOUBLE_FLOAT: Roundings = Roundings {
    center: PAIR + ROTATED,
    radius: PAIR,
    // Rounded, and a product with one f32: 1 for the one cross term, 2 for its sum.
    direction: 4.01 * PAIR,
    power: PAIR,
    add: 3.01 * PAIR,
    mul: 5.01 * PAIR,
    div: 15.01 * PAIR,
    root: 3.13 * PAIR,
};

impl Roundings {
    fn of(method: Method) -> Self {
        match method {
            Method::Native64 => F64,
            Method::DoubleFloat => DOUBLE_FLOAT,
            _ => F32,
        }
    }

    /// A sum of three products, relative to the sum of their absolute values.
    fn dot(&self) -> f64 {
        self.mul + 2.0 * self.add
    }
}

/// D = a r^2 - g.g with g = p x d, t = c/q or q/a: intersect/stable.rs in any arithmetic.
fn perpendicular(a: &Roundings, s: &Extent) -> [f64; 2] {
    // Of g, in r |d|: its products and both its inputs, |p||d| as large. Its differences have an error relative to g
    // itself.
    let tilt = (CROSS * a.mul + a.center + a.direction) * s.k;
    // |g| = r |d| at the outline; of squares, a r^2 and g.g, half.
    let outline = tilt + a.add + 0.5 * (2.0 * a.dot() + 2.0 * a.mul) + a.radius;
    // Of D, in a r^2, for a ray that hits: |g| <= r |d|.
    let e = tilt * (2.0 + tilt) + 2.0 * (a.direction + a.radius + a.dot() + a.mul + a.add);
    // Error of D over the smallest b^2 or D for q, c: sqrt(D) and sqrt(D + e) differ by less than sqrt(e).
    let x2 = e / s.power;
    // b, q, and all errors that are relative to t; b >= sqrt(a c) or q >= sqrt(a |c|).
    let b = (a.dot() + a.center + a.direction) * s.k / s.power.sqrt();
    let host = a.power + POWER * (s.k * s.k).max(1.0) / s.power + ASSEMBLED;
    let y = b + host + a.div + 2.0 * a.add + a.root + a.dot() + 2.0 * a.direction + s.flushed;
    let lost = match s.outside {
        // q = b + sqrt(D) with b^2 = D + a c: the worst case loses a D as large as its error.
        true => (x2 / (1.0 + x2)).sqrt() + 1.0,
        // |b| + sqrt(D) where b may be 0 and D is at least a |c|.
        false if x2 < 1.0 => 1.0 / (1.0 - x2).sqrt(),
        false => f64::INFINITY,
    };
    [outline, if y < 1.0 { lost / (1.0 - y) - 1.0 } else { f64::INFINITY }]
}

/// The errors in which the lecture's forms differ.
struct Quadratic {
    /// Error of D over a r^2, by its arithmetic alone.
    squares: f64,
    /// Error of b over |p||d|, with the error of its inputs.
    b: f64,
    /// Relative error of the divisor of t.
    scale: f64,
}

/// b^2 - a c: 2|b| 3u |b|, its product u; a 3u, c 3u |p|^2 + u r^2 + u |c|, the product u.
fn general(s: &Extent) -> Quadratic {
    let k2 = s.k * s.k;
    let squares = F32.dot() * (2.0 * k2 + k2 + s.power) + U * (k2 + 1.0 + 2.0 * s.power);
    Quadratic { squares, b: F32.dot() + F32.center + F32.direction, scale: F32.dot() + 2.0 * F32.direction }
}

/// b^2 - |p|^2 + r^2 for d divided by its length. The length has an error of half of d.d and of sqrt, each quotient one
/// of its division, and b^2 twice that, because nothing cancels it in |p|^2.
fn normalised(s: &Extent) -> Quadratic {
    let k2 = s.k * s.k;
    let length = 0.5 * F32.dot() + F32.root;
    let b = length + F32.div + F32.dot();
    let squares = (2.0 * b + F32.mul + F32.dot() + U) * k2 + 2.0 * U;
    Quadratic { squares, b: b + F32.center + F32.direction, scale: length + F32.direction }
}

/// t = (b -+ sqrt(D))/a, the near root if it is positive.
fn lecture(form: &Quadratic, s: &Extent) -> [f64; 2] {
    let tilt = (F32.center + F32.direction) * s.k;
    // l^2 and r^2 are compared, so their error is the error of a square: |l/r - 1| where |l^2/r^2 - 1| = squares.
    let of_square = |e: f64| {
        let grow = e / ((1.0 + e).sqrt() + 1.0);
        if e < 1.0 { e / ((1.0 - e).sqrt() + 1.0) } else { grow.max(1.0) }
    };
    let mut outline = tilt + F32.radius + of_square(form.squares);
    // With the errors of the inputs, for a ray that hits.
    let e = form.squares + tilt * (2.0 + tilt) + 2.0 * (F32.direction + F32.radius);
    // The sign of a root is the sign of c: the wrong sign shows a sphere that lies behind, or hides one from inside.
    let sign = e + 2.0 * F32.root * s.k * s.k + U * (s.k * s.k + 1.0);
    if s.power <= sign {
        outline = outline.max(s.gap());
    }
    let x2 = e / s.power;
    // The error of sqrt(D) is min(sqrt(e), e/sqrt(D)): for the near root worst where D = e, for the far root from
    // inside where D is largest.
    let rooted = if s.outside { x2 + (x2 * (1.0 + x2)).sqrt() } else { x2 * (1.0 + s.k) };
    let host = ASSEMBLED + s.flushed;
    let y = (form.b * s.k + F32.root) / s.gap() + form.scale + F32.div + F32.add + host;
    // With an error of the whole distance, the other root may be taken.
    let distance = rooted + y;
    [outline, if distance < 1.0 { distance } else { f64::INFINITY }]
}
