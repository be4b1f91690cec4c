//! Exact decisions: whether a ray hits a sphere, and which of two hits is nearer.
//!
//! With A3 = up x (-view), alpha = |A3|, beta = |view| and B3 = (-view) x A3, the basis of the lecture is
//! u = A3/alpha, v = B3/(alpha beta), -w = view/beta. The ray's direction times alpha beta is therefore
//! u beta A3 + v B3 + d alpha view, and with p = c - e, c0 = p.p - r^2
//!
//! ```text
//! a' = alpha^2 beta^2 (u^2 + v^2 + d^2)     b' = u (p.A3) beta + v (p.B3) + d (p.view) alpha     D' = b'^2 - a' c0
//! t  = alpha beta (b' -+ sqrt(D')) / a'
//! ```
//!
//! where every number but alpha, beta and the last root is a binary number: D' is an [`FieldElement`] of their [`Field`].
//! u, v and d are multiplied by 2 W H so that the pixel's fractions vanish too; t is then so much smaller.
//! A ray with its own direction has alpha = beta = 1 and the axes of the world.
//!
//! A parallel ray leaves from e + u A3/alpha + v B3/(alpha beta) along view/beta: u and v move the origin, the direction's
//! are 0 and d is 1. With p as before, a' = alpha^2 beta^2, b' = (p.view) alpha, and
//!
//! ```text
//! a' c0 = alpha^2 beta^2 (p.p - r^2 + u^2 + v^2) - 2 u beta^2 (p.A3) alpha - 2 v (p.B3) alpha beta
//! ```
//!
//! is not a binary number any more, but still an element of the field.

use super::field::{Field, FieldBasis, FieldElement, resolve};
use crate::dyadic::{self, Dyadic, Dyadic3};
use crate::scene::Ball;
use crate::scene::camera::{Camera, ExactViewport, Look};
use std::cmp::Ordering;

/// One of the two intersections of a line with a sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Root {
    /// The smaller t: the ray enters.
    Near,
    /// The larger t: the ray leaves.
    Far,
    /// No root: a plane cuts the sphere, and the ray enters it through the plane.
    Face,
}

/// The eye and three orthogonal axes; a direction's component along one is counted in units of its length.
#[derive(Debug, Clone)]
pub(crate) struct ExactFrame {
    pub(crate) eye: Dyadic3,
    pub(crate) axes: [ExactAxis; 3],
    pub(crate) field: Field,
}

/// An axis that is not normalised: alpha beta over its length is `unit`.
#[derive(Debug, Clone)]
pub(crate) struct ExactAxis {
    pub(crate) vector: Dyadic3,
    pub(crate) unit: FieldBasis,
}

impl ExactFrame {
    /// The basis of a valid camera: right, up and forward.
    pub(crate) fn of(camera: &Camera) -> Self {
        let eye = dyadic::vector(camera.eye.to_array());
        let view = match camera.look {
            Look::At(at) => dyadic::minus(&dyadic::vector(at.to_array()), &eye),
            Look::View(view) => dyadic::vector(view.to_array()),
        };
        let back = view.clone().map(|x| -x);
        let right = dyadic::cross(&dyadic::vector(camera.up.to_array()), &back);
        let up = dyadic::cross(&back, &right);
        let field = Field { alpha2: dyadic::dot(&right, &right), beta2: dyadic::dot(&view, &view) };
        let axis = |vector, unit| ExactAxis { vector, unit };
        Self {
            eye,
            axes: [axis(right, FieldBasis::Beta), axis(up, FieldBasis::One), axis(view, FieldBasis::Alpha)],
            field,
        }
    }

    /// The axes of the world at `origin`.
    pub(crate) fn world(origin: [f64; 3]) -> Self {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let axes = axes.map(|x| ExactAxis { vector: dyadic::vector(x), unit: FieldBasis::One });
        Self { eye: dyadic::vector(origin), axes, field: Field::rational() }
    }

    /// The ray with these components along the axes.
    pub(crate) fn ray(&self, line: Line) -> ExactRay {
        let Line { dir, from } = line;
        let a = &(&self.field.alpha2 * &self.field.beta2) * &dyadic::dot(&dir, &dir);
        ExactRay { dir, from, a }
    }

    /// The quantities of a ray's line and a sphere.
    pub(crate) fn intersect(&self, ray: &ExactRay, ball: Ball) -> Meeting {
        let p = dyadic::minus(&dyadic::vector(ball.center), &self.eye);
        let mut b = FieldElement::ZERO;
        for (axis, along) in self.axes.iter().zip(&ray.dir) {
            b.add(axis.unit, &(along * &dyadic::dot(&p, &axis.vector)));
        }
        let ac = self.powers(ray, &p, ball.radius);
        let disc = self.field.times(&b, &b).minus(&ac);
        Meeting { p, b, ac, disc }
    }

    /// a' c0
    fn powers(&self, ray: &ExactRay, p: &Dyadic3, radius: f64) -> FieldElement {
        let mut ac = FieldElement::ZERO;
        ac.add(FieldBasis::One, &(&ray.a * &power(p, radius)));
        if let Some([u, v]) = &ray.from {
            // u and v are times the direction's length, and a' has its square.
            let Field { alpha2, beta2 } = &self.field;
            let depth = &ray.dir[2];
            let cross_term = |axis: &ExactAxis, by: &Dyadic| -(&(by * depth) * &dyadic::dot(p, &axis.vector)).ldexp(1);
            ac.add(FieldBasis::One, &(&(alpha2 * beta2) * &(&u.square() + &v.square())));
            ac.add(FieldBasis::Alpha, &(beta2 * &cross_term(&self.axes[0], u)));
            ac.add(FieldBasis::AlphaBeta, &cross_term(&self.axes[1], v));
        }
        ac
    }

    /// Component n of a parallel ray's origin minus the eye, times a' over the direction's length; 0 for other rays.
    pub(crate) fn origin_offset(&self, ray: &ExactRay, n: usize) -> FieldElement {
        let mut sum = FieldElement::ZERO;
        if let Some([u, v]) = &ray.from {
            sum.add(FieldBasis::Alpha, &(&(&self.field.beta2 * u) * &self.axes[0].vector[n]));
            sum.add(FieldBasis::AlphaBeta, &(v * &self.axes[1].vector[n]));
        }
        sum
    }
}

/// The power of the eye with respect to the sphere: |p|^2 - r^2.
pub(crate) fn power(p: &Dyadic3, radius: f64) -> Dyadic {
    &dyadic::dot(p, p) - &Dyadic::of(radius).square()
}

/// The lens in exact numbers: (2 j + 1 - W) vw H, (H - 1 - 2 i) vh W and 2 W H d are 2 W H times u, v and d. All are times
/// fy too, where vh is `tall` fx / fy.
#[derive(Debug, Clone)]
pub(crate) struct ExactLens {
    wide: Dyadic,
    tall: Dyadic,
    /// `None` for parallel rays.
    deep: Option<Dyadic>,
    /// The factor from u, v and d: 2 W H, or 2 W H fy.
    pub(super) stretch: Dyadic,
    size: [i64; 2],
}

impl ExactLens {
    pub(crate) fn of(viewport: ExactViewport, size: [u32; 2]) -> Self {
        let size = size.map(i64::from);
        let [w, h] = size.map(Dyadic::from);
        let [fx, fy] = viewport.pitch.map(Dyadic::of);
        let stretch = (&(&w * &h) * &fy).ldexp(1);
        let wide = &(&Dyadic::of(viewport.vw) * &h) * &fy;
        let tall = &(&Dyadic::of(viewport.tall) * &w) * &fx;
        let deep = (!viewport.is_parallel()).then(|| &Dyadic::of(viewport.d) * &stretch);
        Self { wide, tall, deep, stretch, size }
    }

    /// The ray through the centre of row i, column j, times [`Self::stretch`].
    pub(crate) fn line(&self, i: u32, j: u32) -> Line {
        let [columns, rows] = odds(self.size, i, j).map(Dyadic::from);
        let [u, v] = [&columns * &self.wide, &rows * &self.tall];
        match &self.deep {
            Some(deep) => Line { dir: [u, v, deep.clone()], from: None },
            None => Line { dir: [Dyadic::ZERO, Dyadic::ZERO, self.stretch.clone()], from: Some([u, v]) },
        }
    }
}

/// 2 j + 1 - W and H - 1 - 2 i: the pixel's centre in half pixels from the image's.
pub(crate) fn odds([width, height]: [i64; 2], i: u32, j: u32) -> [i64; 2] {
    [2 * i64::from(j) + 1 - width, height - 1 - 2 * i64::from(i)]
}

/// A ray by its components along the axes of a frame: its direction, and for a parallel ray its start in the plane of
/// the eye, right and up, times the length of the direction.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    pub(crate) dir: Dyadic3,
    pub(crate) from: Option<[Dyadic; 2]>,
}

/// A line in a frame.
#[derive(Debug, Clone)]
pub(crate) struct ExactRay {
    pub(crate) dir: Dyadic3,
    from: Option<[Dyadic; 2]>,
    /// a'
    pub(crate) a: Dyadic,
}

impl ExactRay {
    pub(super) fn is_parallel(&self) -> bool {
        self.from.is_some()
    }
}

/// p, b', a' c0 and D' of one ray and one sphere.
#[derive(Debug, Clone)]
pub(crate) struct Meeting {
    pub(crate) p: Dyadic3,
    pub(super) b: FieldElement,
    ac: FieldElement,
    pub(super) disc: FieldElement,
}

impl Meeting {
    /// `None` where the ray hits nothing at t > 0, else whether it is tangent at its first hit, which [`root`] names.
    ///
    /// From outside both roots have the sign of b'. On the surface they are 0 and 2 b'/a'. From inside they differ in
    /// sign and D' > 0.
    pub(crate) fn hit(&self, field: &Field) -> Option<bool> {
        let side = self.side(field);
        if side == Ordering::Less {
            return Some(false);
        }
        if field.sign(&self.b) != Ordering::Greater {
            return None;
        }
        if side == Ordering::Equal {
            return Some(false);
        }
        match field.sign(&self.disc) {
            Ordering::Less => None,
            tangent => Some(tangent == Ordering::Equal),
        }
    }

    /// The exact sign of the power of the ray's origin.
    pub(crate) fn side(&self, field: &Field) -> Ordering {
        field.sign(&self.ac)
    }

    /// (b' -+ sqrt(D')) with a relative error below 2^-bits; `None` when the line misses the sphere.
    ///
    /// The root of larger magnitude is a sum of equal signs, the other is a' c0 over it: nothing cancels. Errors of b'
    /// and of the root of D' (half the error of D' and one truncation) are below 2^-(bits+5), the quotient adds as much.
    pub(crate) fn scaled_root(&self, field: &Field, root: Root, bits: usize) -> Option<Dyadic> {
        let n = bits + 8;
        let s = match field.sign(&self.disc) {
            Ordering::Less => return None,
            Ordering::Equal => Dyadic::ZERO,
            Ordering::Greater => field.value(&self.disc, n).sqrt(n),
        };
        let b = field.value(&self.b, n);
        let backwards = b.sign() == Ordering::Less;
        let sum = &b.abs() + &s;
        let large = if backwards { -sum } else { sum };
        if (root == Root::Far) != backwards || large.is_zero() {
            return Some(large);
        }
        let ac = self.ac.plain().cloned().unwrap_or_else(|| field.value(&self.ac, n));
        Some(ac.over(&large, n))
    }
}

/// Which root is the first t > 0 of a sphere that is hit: the far one on the surface and inside, where the near one is not
/// ahead.
pub(crate) fn root(power: Ordering) -> Root {
    if power == Ordering::Greater { Root::Near } else { Root::Far }
}

/// Whether t of that root, which is real, is below `limit`, for a ray with its own direction.
///
/// t = (b' -+ sqrt(D')) / a', so the sign of B -+ sqrt(D') with B = b' - a' limit decides.
pub(crate) fn before(field: &Field, ray: &ExactRay, meeting: &Meeting, root: Root, limit: &Dyadic) -> bool {
    let mut at_limit = FieldElement::ZERO;
    at_limit.add(FieldBasis::One, &(&ray.a * limit));
    let gap = meeting.b.minus(&at_limit);
    // 0 only where D' is.
    let s = field.sign(&meeting.disc);
    let s = if root == Root::Far { s } else { s.reverse() };
    let squares = || field.sign(&field.times(&gap, &gap).minus(&meeting.disc));
    resolve(field.sign(&gap), s, squares) == Ordering::Less
}

/// The exact order of t between two hits of one ray, each by the root that counts.
///
/// The sign of B + X with B = b1 - b2 and X = s1 sqrt(D1) - s2 sqrt(D2). Where they oppose, B^2 - X^2 =
/// G + 2 s1 s2 sqrt(D1 D2) with G = B^2 - D1 - D2 decides, and where those two oppose, G^2 - 4 D1 D2.
pub(crate) fn order(field: &Field, (first, root1): (&Meeting, Root), (second, root2): (&Meeting, Root)) -> Ordering {
    let gap = first.b.minus(&second.b);
    let (far1, far2) = (root1 == Root::Far, root2 == Root::Far);
    let (d1, d2) = (&first.disc, &second.disc);
    let roots = match (far1, far2) {
        (true, true) => field.sign(&d1.minus(d2)),
        (false, false) => field.sign(&d2.minus(d1)),
        // A sum of two roots, both not negative: 0 only if both are.
        (true, false) => field.sign(d1).max(field.sign(d2)),
        (false, true) => field.sign(d1).max(field.sign(d2)).reverse(),
    };
    resolve(field.sign(&gap), roots, || compare_squares(field, &gap, d1, d2, far1 == far2))
}

/// The sign of B^2 - (sqrt(D1) -+ sqrt(D2))^2, minus where the roots are `alike`.
fn compare_squares(field: &Field, gap: &FieldElement, d1: &FieldElement, d2: &FieldElement, alike: bool) -> Ordering {
    let g = field.times(gap, gap).minus(&d1.plus(d2));
    let product = field.times(d1, d2);
    let mixed = field.sign(&product);
    let mixed = if alike { mixed } else { mixed.reverse() };
    resolve(field.sign(&g), mixed, || field.sign(&field.times(&g, &g).minus(&product.ldexp(2))))
}
