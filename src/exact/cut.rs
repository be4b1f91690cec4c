//! Exact decisions about planes that cut spheres: where a ray enters and leaves what the planes keep, and the hit of a cut ball there.
//!
//! With the numbers of [`super::decide`], a ray of the frame passes a plane N.p = D at num/den, in the unit in which it meets a
//! sphere at (b' -+ sqrt(D'))/a':
//!
//! ```text
//! den = N.dir'      num = D - N.e      of a parallel ray, which starts at o = L origin / a':
//! den = a' N.dir'   num = a' (D - N.e) - L N.origin
//! ```
//!
//! both elements of the frame's field, so that num/den - root has the sign of den times the sign of
//! a' num - den b' +- den sqrt(D'), and two planes compare by products.

use super::decide::{ExactFrame, ExactRay, Meeting, Root};
use super::field::{Field, FieldBasis, FieldElement, resolve};
use crate::dyadic::{self, Dyadic, Dyadic3};
use crate::scene::{CutPlane, Cuts};
use std::cmp::Ordering;

/// A plane in exact numbers.
#[derive(Debug, Clone)]
pub(super) struct ExactPlane {
    pub(super) normal: Dyadic3,
    pub(super) distance: Dyadic,
}

/// The place where a ray passes a plane: num/den.
#[derive(Debug, Clone)]
pub(super) struct Crossing {
    /// The index of the plane.
    pub(super) plane: usize,
    pub(super) num: FieldElement,
    pub(super) den: FieldElement,
}

/// The part of a ray that planes keep: behind `entry`, or the origin, and before `exit`.
#[derive(Debug, Clone)]
pub(super) struct Interval {
    /// The last plane that the ray enters through, ahead of its origin; of several at the same place the first.
    pub(super) entry: Option<Crossing>,
    exit: Option<Crossing>,
}

fn product(a: Ordering, b: Ordering) -> Ordering {
    match a {
        Ordering::Less => b.reverse(),
        Ordering::Equal => Ordering::Equal,
        Ordering::Greater => b,
    }
}

/// The planes of some spheres, and which of these they cut.
#[derive(Debug)]
pub(super) struct ExactCuts {
    pub(super) planes: Vec<ExactPlane>,
    of: Vec<bool>,
}

impl ExactCuts {
    pub(super) fn of(cuts: &Cuts) -> Self {
        Self {
            planes: cuts.planes.iter().map(ExactPlane::of).collect(),
            of: (0..cuts.of.len() as u32).map(|id| cuts.is_cut(id)).collect(),
        }
    }

    pub(super) fn is_cut(&self, id: u32) -> bool {
        self.of.get(id as usize).is_some_and(|flag| *flag)
    }

    /// The normal of a plane, of length 1.
    pub(super) fn normal(&self, plane: usize) -> [f64; 3] {
        let normal = &self.planes[plane].normal;
        let length = dyadic::dot(normal, normal).sqrt(128);
        normal.each_ref().map(|x| x.over(&length, 128).to_f64())
    }
}

impl ExactPlane {
    pub(super) fn of(plane: &CutPlane) -> Self {
        Self { normal: dyadic::vector(plane.normal), distance: Dyadic::of(plane.distance) }
    }
}

impl ExactFrame {
    /// N.dir'
    fn across(&self, ray: &ExactRay, ExactPlane { normal, .. }: &ExactPlane) -> FieldElement {
        let mut across = FieldElement::ZERO;
        for (axis, along) in self.axes.iter().zip(&ray.dir) {
            across.add(axis.unit, &(along * &dyadic::dot(normal, &axis.vector)));
        }
        across
    }

    /// Whether a ray lies along a plane, in it or beside it.
    pub(super) fn is_along(&self, ray: &ExactRay, plane: &ExactPlane) -> bool {
        self.field.sign(&self.across(ray, plane)) == Ordering::Equal
    }

    fn crossing(&self, ray: &ExactRay, index: usize, plane: &ExactPlane) -> Crossing {
        let ExactPlane { normal, distance } = plane;
        let (mut den, mut num) = (self.across(ray, plane), FieldElement::ZERO);
        num.add(FieldBasis::One, &(distance - &dyadic::dot(normal, &self.eye)));
        if ray.is_parallel() {
            let mut origin = FieldElement::ZERO;
            for (n, along) in normal.iter().enumerate() {
                origin = origin.plus(&self.origin_offset(ray, n).scaled(along));
            }
            num = num.scaled(&ray.a).minus(&origin.scaled(&ray.dir[2]));
            den = den.scaled(&ray.a);
        }
        Crossing { plane: index, num, den }
    }

    /// The part of a ray that all planes keep; `None` where that is nothing.
    pub(super) fn interval(&self, ray: &ExactRay, planes: &[ExactPlane]) -> Option<Interval> {
        let field = &self.field;
        let mut kept = Interval { entry: None, exit: None };
        for (index, plane) in planes.iter().enumerate() {
            let crossing = self.crossing(ray, index, plane);
            let is_ahead = || crossing.sign(field) == Ordering::Greater;
            match field.sign(&crossing.den) {
                Ordering::Equal if field.sign(&crossing.num) == Ordering::Less => return None,
                Ordering::Equal => {}
                Ordering::Less => {
                    let is_last = |entry: &Crossing| crossing.order(field, entry) == Ordering::Greater;
                    if is_ahead() && kept.entry.as_ref().is_none_or(is_last) {
                        kept.entry = Some(crossing);
                    }
                }
                Ordering::Greater if !is_ahead() => return None,
                Ordering::Greater => {
                    let is_first = |exit: &Crossing| crossing.order(field, exit) == Ordering::Less;
                    if kept.exit.as_ref().is_none_or(is_first) {
                        kept.exit = Some(crossing);
                    }
                }
            }
        }
        let is_empty = match (&kept.entry, &kept.exit) {
            (Some(entry), Some(exit)) => entry.order(field, exit) != Ordering::Less,
            _ => false,
        };
        (!is_empty).then_some(kept)
    }
}

impl Crossing {
    /// The sign of its place.
    fn sign(&self, field: &Field) -> Ordering {
        product(field.sign(&self.num), field.sign(&self.den))
    }

    /// The order of two planes along the ray.
    fn order(&self, field: &Field, other: &Self) -> Ordering {
        let gap = field.times(&self.num, &other.den).minus(&field.times(&other.num, &self.den));
        product(field.sign(&gap), product(field.sign(&self.den), field.sign(&other.den)))
    }

    /// The order of the plane and a root of a sphere, which is real.
    pub(super) fn order_root(&self, field: &Field, ray: &ExactRay, meeting: &Meeting, root: Root) -> Ordering {
        let Self { num, den, .. } = self;
        let gap = num.scaled(&ray.a).minus(&field.times(den, &meeting.b));
        let sign = field.sign(den);
        let of_root = match field.sign(&meeting.disc) {
            Ordering::Greater if root == Root::Near => sign,
            Ordering::Greater => sign.reverse(),
            _ => Ordering::Equal,
        };
        let squares = || {
            let own = field.times(&field.times(den, den), &meeting.disc);
            field.sign(&field.times(&gap, &gap).minus(&own))
        };
        product(sign, resolve(field.sign(&gap), of_root, squares))
    }

    /// Whether the place is below `limit`, for a ray with its own direction.
    pub(super) fn is_before(&self, field: &Field, limit: &Dyadic) -> bool {
        let gap = self.num.minus(&self.den.scaled(limit));
        product(field.sign(&gap), field.sign(&self.den)) == Ordering::Less
    }

    /// a' num/den with a relative error below 2^-bits.
    pub(super) fn scaled(&self, field: &Field, ray: &ExactRay, bits: usize) -> Dyadic {
        let bits = bits + 4;
        let num = &field.value(&self.num, bits) * &ray.a;
        num.over(&field.value(&self.den, bits), bits)
    }
}

impl Interval {
    /// The hit of a cut ball: at its near root within the interval, else on the plane through which the ray enters the ball, else from
    /// inside at its far root, where no plane comes before that. `None` where the ray hits nothing of it.
    pub(super) fn hit(&self, field: &Field, ray: &ExactRay, meeting: &Meeting) -> Option<(Root, bool)> {
        let disc = field.sign(&meeting.disc);
        if disc == Ordering::Less {
            return None;
        }
        let is_before_exit = |root: Root| {
            self.exit.as_ref().is_none_or(|exit| exit.order_root(field, ray, meeting, root) == Ordering::Greater)
        };
        let near = || is_before_exit(Root::Near).then_some((Root::Near, disc == Ordering::Equal));
        if let Some(entry) = &self.entry {
            let is_behind = |root: Root| entry.order_root(field, ray, meeting, root) == Ordering::Less;
            return match (is_behind(Root::Near), is_behind(Root::Far)) {
                (true, _) => near(),
                (false, true) => Some((Root::Face, false)),
                (false, false) => None,
            };
        }
        let ahead = field.sign(&meeting.b) == Ordering::Greater;
        match meeting.side(field) {
            Ordering::Greater => {
                if ahead {
                    near()
                } else {
                    None
                }
            }
            side => {
                let is_hit = (side == Ordering::Less || ahead) && is_before_exit(Root::Far);
                is_hit.then_some((Root::Far, false))
            }
        }
    }
}
