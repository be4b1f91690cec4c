//! The hits of cut spheres in f64, with bounds: for most pixels they decide what the judge would, at a hundredth of its time.
//! docs/certificate.md, section 9a, derives the bounds.

use super::given::{AnyHit, Bounds, CertifiedRay, EPS, HitNumbers};
use super::surface::SurfacePoint;
use crate::double_double as dd;
use crate::exact::{Root, Truth};
use crate::scene::{Ball, NumberedBall};
use crate::view::View;
use crate::view::placement::Placement;
use crate::view::planes::{EyePlane, EyePlanes};
use crate::view::ray::dot3;
use glam::DVec3;
use std::borrow::Borrow;
use std::cmp::Ordering;

/// The largest relative error of a t of an answer that is given in f64. Section 9a.
pub(crate) const SHARP: f64 = 1.0 / (1u64 << 40) as f64;
/// The largest error of a normal, as an angle, of an answer that is given in f64. Section 9a.
const TURNED: f64 = 1.0 / (1u64 << 30) as f64;

/// A distance from a plane, in the tree's unit, below which it may have lost bits. Section 9a.
const TINY: f64 = 1e-290;

/// Bound of the roundings of a quotient of bounds: theirs, its own and its product with this. Section 9a.
const QUOTIENT: f64 = 8.0 * EPS;

/// Room for the few roundings of the bounds themselves, and for products of two errors. Section 9a.
const ROUNDED: f64 = 1.0 + 1.0 / (1u64 << 20) as f64;

/// The least and the largest t that a number may have.
#[derive(Debug, Clone, Copy)]
struct Between([f64; 2]);

impl Between {
    /// Whether it is certainly below another.
    fn is_below(self, other: Self) -> bool {
        self.0[1] < other.0[0]
    }

    fn middle(self) -> f64 {
        0.5 * (self.0[0] + self.0[1])
    }

    /// Of both by `choose`, the lower and the upper bounds apart.
    fn by(self, other: Self, choose: fn(f64, f64) -> f64) -> Self {
        Self([0, 1].map(|k| choose(self.0[k], other.0[k])))
    }
}

/// A ray, and the part of it that the planes keep.
pub(crate) struct CutRay {
    ray: CertifiedRay,
    /// The place of the plane through which it enters, and its index if that is known; `None` where it begins in the kept part.
    entry: Option<(Between, Option<usize>)>,
    /// The same of the plane through which it leaves.
    exit: Option<(Between, Option<usize>)>,
    /// Whether the planes keep nothing of it.
    is_empty: bool,
}

/// A hit of a sphere, if f64 is certain of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CutHit {
    t: Between,
    pub(crate) root: Root,
}

/// The answer for one sphere.
enum Answer {
    Miss,
    Hit(CutHit),
    /// Not below this t.
    Unsure(f64),
}

/// The point at which a ray through a sphere leaves it.
#[derive(Debug)]
pub(crate) struct Leaving {
    /// The bounds of its t.
    pub(crate) t: [f64; 2],
    pub(crate) point: SurfacePoint,
    pub(crate) sure: bool,
}

/// The first of the hits of a ray, as far as they are known.
#[derive(Debug)]
pub(crate) struct FirstHit {
    best: Option<(NumberedBall, CutHit)>,
    /// The lower bound of its t.
    least: f64,
    /// The next t, of a hit other than the best, or its lower bound.
    second: f64,
}

impl Default for FirstHit {
    fn default() -> Self {
        Self { best: None, least: f64::INFINITY, second: f64::INFINITY }
    }
}

impl FirstHit {
    /// An upper bound of the first certain hit's t.
    pub(crate) fn high(&self) -> f64 {
        self.best.map_or(f64::INFINITY, |(_, hit)| hit.t.0[1])
    }

    /// The first certain hit, whether or not another may come before it, and the bounds of its t.
    pub(crate) fn best(&self) -> Option<(NumberedBall, CutHit, [f64; 2])> {
        self.best.map(|(ball, hit)| (ball, hit, hit.t.0))
    }

    /// A lower bound of t of all hits.
    pub(crate) fn low(&self) -> f64 {
        self.least.min(self.second)
    }

    /// Adds a sphere, which planes may cut.
    pub(crate) fn keep(&mut self, ray: &CutRay, ball: NumberedBall, is_cut: bool) {
        let [least_limit, limit] = ray.ray.limit;
        let hit = match ray.hit_of(ball.ball, is_cut) {
            Answer::Miss => return,
            Answer::Hit(hit) if hit.t.0[0] >= limit => return,
            Answer::Hit(hit) if hit.t.0[1] < least_limit => hit,
            Answer::Unsure(low) if low >= limit => return,
            Answer::Hit(CutHit { t: Between([low, _]), .. }) | Answer::Unsure(low) => {
                self.second = self.second.min(low);
                return;
            }
        };
        let low = hit.t.0[0];
        match self.best {
            // Faces are all at one place, where the smaller sphere shows it, then the lower index.
            Some((other, old)) if hit.root == Root::Face && old.root == Root::Face => {
                let key = |ball: NumberedBall| (ball.ball.radius, ball.id);
                if key(ball) < key(other) {
                    self.best = Some((ball, hit));
                }
            }
            Some(_) if low >= self.least => self.second = self.second.min(low),
            _ => {
                self.second = self.second.min(self.least);
                (self.best, self.least) = (Some((ball, hit)), low);
            }
        }
    }

    /// The first hit: `None` where it is not decided, `Some(None)` for a certain miss.
    pub(crate) fn found(&self) -> Option<Option<(NumberedBall, CutHit)>> {
        match self.best {
            None => (self.second == f64::INFINITY).then_some(None),
            Some((_, hit)) => (hit.t.0[1] < self.second).then_some(self.best),
        }
    }
}

impl CutRay {
    /// The viewing ray of row `i` and column `j`; `None` where f64 does not tell which part of it is kept. `is_along` says of a plane, in
    /// exact numbers, whether the ray lies along it.
    pub(crate) fn of_pixel(
        planes: &EyePlanes,
        view: &View,
        placement: &Placement,
        (at, is_along): ([u32; 2], &dyn Fn(usize) -> bool),
    ) -> Option<Self> {
        let ray = CertifiedRay::of_pixel(view, placement, at);
        let mut found = Self { ray, entry: None, exit: None, is_empty: false };
        let (offset, d) = (found.ray.offset(), found.ray.direction);
        let away = dot3(offset, offset).sqrt();
        // All spheres are within [-1, 1] in each coordinate, and a direction is at least 1 long.
        let start = found.ray.placed();
        let reach = (dot3(start, start).sqrt() + 4.0) * ROUNDED;
        for (index, EyePlane { normal, length, gap, side, .. }) in planes.iter().enumerate() {
            let gap = placement.radius(*gap);
            let (num, den) = (gap - dot3(*normal, offset), dot3(*normal, d));
            // One rounding of the gap and two of its place, four of the product and the difference; a direction is at most 4 long.
            let num_error = (3.0 * EPS * gap.abs() + length * (6.0 * EPS * away + found.ray.blur)) * ROUNDED;
            let den_error = 4.0 * length * (4.0 * EPS + found.ray.tilt) * ROUNDED;
            // A plane that no part of the ray within reach of the spheres passes, such as one along parallel rays.
            if (den.abs() + den_error) * reach < num.abs() - num_error {
                found.is_empty |= num < 0.0;
                continue;
            }
            let from_eye = offset == [0.0; 3];
            if !(num.is_finite() && den.abs() > 2.0 * den_error) {
                // Such a plane keeps all of the ray or nothing, as of its origin.
                let is_beyond = match side {
                    _ if !is_along(index) => return None,
                    side if from_eye => *side == Ordering::Less,
                    _ if num.abs() > num_error => num < 0.0,
                    _ => return None,
                };
                found.is_empty |= is_beyond;
                continue;
            }
            match (side, from_eye) {
                // The eye is exactly on the plane.
                (Ordering::Equal, true) => {
                    found.is_empty |= den > 0.0;
                    continue;
                }
                (Ordering::Equal, false) => {}
                // Numbers next to underflow have fewer bits.
                _ if gap.abs() < TINY => return None,
                _ => {}
            }
            let ends = [num - num_error, num + num_error].map(|num| num / den);
            let wider = |x: f64| x.abs() * (2.0 * den_error / den.abs() + 4.0 * EPS) * ROUNDED;
            let [low, high] = if den > 0.0 { ends } else { [ends[1], ends[0]] };
            let place = Between([low - wider(low), high + wider(high)]);
            let zero = Between([0.0; 2]);
            if den > 0.0 {
                // A plane that the ray leaves through behind its origin.
                found.is_empty |= place.is_below(zero);
                found.exit = match found.exit {
                    Some((exit, plane)) if exit.is_below(place) => Some((exit, plane)),
                    Some((exit, _)) if !place.is_below(exit) => return None,
                    _ => Some((place, Some(index))),
                };
            } else if !place.is_below(zero) {
                if !zero.is_below(place) {
                    return None;
                }
                found.entry = match found.entry {
                    Some((entry, plane)) if place.is_below(entry) => Some((entry, plane)),
                    // The first of equal planes.
                    Some((entry, _)) if !entry.is_below(place) => return None,
                    _ => Some((place, Some(index))),
                };
            }
        }
        let start = found.entry.map_or(Between([0.0; 2]), |(entry, _)| entry);
        match found.exit {
            _ if found.is_empty => {}
            Some((exit, _)) if exit.is_below(start) => found.is_empty = true,
            Some((exit, _)) if !start.is_below(exit) => return None,
            _ => {}
        }
        Some(found)
    }

    /// The hit of a sphere, which planes may cut.
    fn hit_of(&self, ball: Ball, is_cut: bool) -> Answer {
        let Some(bounds) = self.ray.intersect(ball) else { return Answer::Miss };
        let root = Between([bounds.low, bounds.high]);
        let kind = if bounds.outside { Root::Near } else { Root::Far };
        if !is_cut {
            return if bounds.sure { Answer::Hit(CutHit { t: root, root: kind }) } else { Answer::Unsure(bounds.low) };
        }
        if self.is_empty {
            return Answer::Miss;
        }
        let before_exit = || match self.exit {
            Some((exit, _)) if exit.is_below(root) => Answer::Miss,
            Some((exit, _)) if !root.is_below(exit) => Answer::Unsure(bounds.low),
            _ => Answer::Hit(CutHit { t: root, root: kind }),
        };
        let Some((entry, _)) = self.entry else {
            return if bounds.sure { before_exit() } else { Answer::Unsure(bounds.low) };
        };
        if bounds.sure && bounds.outside && entry.is_below(root) {
            return before_exit();
        }
        match self.side(entry, ball) {
            Some(true) => Answer::Hit(CutHit { t: entry, root: Root::Face }),
            // The plane is beyond the sphere where it is not before it.
            Some(false) if bounds.sure && (!bounds.outside || root.is_below(entry)) => Answer::Miss,
            // From inside the ray may meet the plane before the far root, which these bounds are of.
            _ if bounds.outside => Answer::Unsure(entry.0[0].max(bounds.low)),
            _ => Answer::Unsure(entry.0[0]),
        }
    }

    /// Whether the place on the plane is inside of a ball; `None` where f64 does not tell.
    fn side(&self, entry: Between, ball: Ball) -> Option<bool> {
        let CertifiedRay { direction, tilt, blur, .. } = self.ray;
        let (p, r, t) = (self.ray.to(ball.center), self.ray.radius(ball.radius), entry.middle());
        let away: [f64; 3] = std::array::from_fn(|n| t * direction[n] - p[n]);
        let (distance, size) = (dot3(away, away).sqrt(), dot3(p, p).sqrt());
        // The place on the ray, its direction, the start, and a few roundings of t d, p and their difference.
        let error =
            (4.0 * (entry.0[1] - entry.0[0] + t * (tilt + 8.0 * EPS)) + blur + 8.0 * EPS * (size + distance)) * ROUNDED;
        (distance.is_finite() && (distance - r).abs() > error).then_some(distance < r)
    }

    /// The first hit among some spheres, each with a lower bound of its t: `None` where f64 does not decide it, `Some(None)` for a certain miss.
    /// The sooner the nearest comes, the fewer are tested.
    pub(crate) fn first(
        &self,
        balls: impl Iterator<Item = (f64, NumberedBall, bool)>,
    ) -> Option<Option<(NumberedBall, CutHit)>> {
        let mut first = FirstHit::default();
        for (least_t, ball, is_cut) in balls {
            if least_t <= first.high() {
                first.keep(self, ball, is_cut);
            }
        }
        first.found()
    }

    /// The factor from depths along the view axis to t of this ray, for a view of a plane.
    pub(crate) fn of_depth(&self, view: &View, at: [u32; 2]) -> f64 {
        let [_, _, z] = view.direction(at[0], at[1]);
        dd::ldexp(-1.0 / z, -self.ray.shift)
    }

    /// The normal at a hit, and its error as an angle; `None` where the plane of a face is not known.
    fn normal(&self, planes: &EyePlanes, (ball, hit): (Ball, CutHit)) -> Option<([f64; 3], f64)> {
        if let (Root::Face, Some((_, plane))) = (hit.root, self.entry) {
            return Some((planes.normal(plane?), 0.0));
        }
        let ([low, high], t, length) = (hit.t.0, hit.t.middle(), self.ray.a.sqrt());
        let p = self.ray.to(ball.center);
        let outward: [f64; 3] = std::array::from_fn(|n| t * self.ray.direction[n] - p[n]);
        let size = dot3(outward, outward).sqrt();
        let sign = if hit.root == Root::Near { 1.0 / size } else { -1.0 / size };
        let error = (high - low) * length
            + 8.0 * EPS * (t * length + dot3(p, p).sqrt())
            + self.ray.blur
            + self.ray.tilt * t * length;
        Some((outward.map(|x| x * sign), 2.0 * error / self.ray.radius(ball.radius)))
    }

    /// The answer for a hit whose t is known to `sharp` of itself, and, where that is finite, its normal; else `None`.
    pub(crate) fn truth(
        &self,
        (planes, sharp): (&EyePlanes, f64),
        view: &View,
        at: [u32; 2],
        (ball, hit): (NumberedBall, CutHit),
    ) -> Option<Truth> {
        let [low, high] = hit.t.0;
        if !(low > 0.0 && high - low < sharp * low) {
            return None;
        }
        let (normal, turn) = self.normal(planes, (ball.ball, hit))?;
        if turn.is_nan() || sharp < f64::INFINITY && turn >= TURNED {
            return None;
        }
        let t = dd::ldexp(hit.t.middle(), self.ray.shift);
        let direction = view.direction(at[0], at[1]);
        let position = view.point(view.origin(at[0], at[1]), direction, t);
        let depth = -direction[2] * t;
        let distance = t * DVec3::from_array(direction).length();
        let is_finite = position.iter().chain([&t, &depth, &distance]).all(|x| x.is_finite());
        is_finite.then_some(Truth { id: ball.id, root: hit.root, t, distance, depth, normal, position, tangent: false })
    }

    /// The numbers of a hit of a given ray; `None` where the plane of a face is not known.
    pub(crate) fn numbers(&self, planes: &EyePlanes, (ball, hit): (NumberedBall, CutHit)) -> Option<HitNumbers> {
        let [low, high] = hit.t.0;
        self.normal(planes, (ball.ball, hit)).map(|normal| self.ray.numbers_at([low, hit.t.middle(), high], normal))
    }

    /// The hit of one sphere, if f64 is certain of it.
    pub(crate) fn hit(&self, ball: NumberedBall, is_cut: bool) -> Option<CutHit> {
        match self.hit_of(ball.ball, is_cut) {
            Answer::Hit(hit) => Some(hit),
            Answer::Miss | Answer::Unsure(_) => None,
        }
    }
}

/// Planes seen from a hit.
#[derive(Debug, Default)]
pub(crate) struct PointPlanes {
    planes: Vec<PointPlane>,
    /// Whether all planes keep the hit.
    pub(crate) is_kept: bool,
}

/// A plane seen from a hit.
#[derive(Debug)]
struct PointPlane {
    normal: [f64; 3],
    length: f64,
    /// Bounds of D - N.p in the tree's unit.
    gap: [f64; 2],
}

impl PointPlanes {
    /// Measures the planes from a hit, which is known to be kept or not.
    pub(crate) fn begin(&mut self, planes: &EyePlanes, placement: &Placement, point: &SurfacePoint, is_kept: bool) {
        self.planes.clear();
        for plane in planes.iter() {
            let [gap, error] = plane.gap_at(point.ball.center).map(|x| placement.radius(x));
            let num = gap - dot3(plane.normal, point.offset);
            // Two roundings of the gap in the tree's unit, four of the product and the difference.
            let error =
                (error + 4.0 * EPS * gap.abs() + plane.length * (6.0 * EPS * point.size + point.blur)) * ROUNDED + TINY;
            let [low, high] = [num - error, num + error];
            let gap = match (num.is_finite() && error.is_finite(), is_kept) {
                (true, true) => [low.max(0.0), high.max(0.0)],
                (true, false) => [low, high],
                (false, true) => [0.0, f64::INFINITY],
                (false, false) => [f64::NEG_INFINITY, f64::INFINITY],
            };
            self.planes.push(PointPlane { normal: plane.normal, length: plane.length, gap });
        }
        self.is_kept = is_kept || self.planes.iter().all(|plane| plane.gap[0] > 0.0);
    }

    /// The ray from the hit, which planes keep, up to where it leaves what they keep.
    pub(crate) fn clipped(&self, ray: &CertifiedRay) -> CertifiedRay {
        let mut limit = ray.limit;
        for PointPlane { normal, length, gap: [low, high] } in &self.planes {
            let [den, error] = across(normal, *length, ray);
            if den + error <= 0.0 {
                continue;
            }
            limit[0] = limit[0].min(low / (den + error) / ROUNDED);
            if den > error {
                limit[1] = limit[1].min(high / (den - error) * ROUNDED);
            }
        }
        ray.ending_at(limit)
    }
}

/// N.d, and a bound of its error.
fn across(normal: &[f64; 3], length: f64, ray: &CertifiedRay) -> [f64; 2] {
    [dot3(*normal, ray.direction), 4.0 * length * (4.0 * EPS + ray.tilt) * ROUNDED]
}

impl CutRay {
    /// A ray from a hit that planes do not keep; `None` where f64 does not tell which part of it is kept.
    pub(crate) fn of_hit(planes: &PointPlanes, ray: CertifiedRay) -> Option<Self> {
        Self::among(planes.planes.iter(), ray)
    }

    /// A given ray; `None` where f64 does not tell which part of it is kept.
    pub(crate) fn of_given(planes: &EyePlanes, placement: &Placement, ray: CertifiedRay) -> Option<Self> {
        let planes = planes.iter().map(|plane| {
            let [gap, error] = plane.gap_at(ray.origin).map(|x| placement.radius(x));
            let error = error * ROUNDED + TINY;
            PointPlane { normal: plane.normal, length: plane.length, gap: [gap - error, gap + error] }
        });
        Self::among(planes, ray)
    }

    /// The part of a ray that planes keep, seen from its start.
    fn among(planes: impl Iterator<Item: Borrow<PointPlane>>, ray: CertifiedRay) -> Option<Self> {
        let mut found = Self { ray, entry: None, exit: None, is_empty: false };
        let start = ray.placed();
        let reach = (dot3(start, start).sqrt() + 4.0) * ROUNDED;
        for (index, plane) in planes.enumerate() {
            let PointPlane { normal, length, gap: [low, high] } = plane.borrow();
            let [den, error] = across(normal, *length, &ray);
            // What is left of a plane that no part of the ray within reach of the spheres passes.
            let passed = (den.abs() + error) * reach;
            if passed < *low {
                continue;
            }
            if passed < -high || den > error && *high <= 0.0 {
                found.is_empty = true;
            } else if den > -error && *low > 0.0 {
                let last = if den > error { high / (den - error) * (1.0 + QUOTIENT) } else { f64::INFINITY };
                let place = Between([low / (den + error) * (1.0 - QUOTIENT), last]);
                found.exit = match found.exit {
                    Some((exit, plane)) if exit.is_below(place) => Some((exit, plane)),
                    Some((exit, _)) if !place.is_below(exit) => Some((place.by(exit, f64::min), None)),
                    _ => Some((place, Some(index))),
                };
            } else if den < -error && *high < 0.0 {
                let [first, last] = [high / (den - error), low / (den + error)];
                let place = Between([first * (1.0 - QUOTIENT), last * (1.0 + QUOTIENT)]);
                found.entry = match found.entry {
                    Some((entry, plane)) if place.is_below(entry) => Some((entry, plane)),
                    Some((entry, _)) if !entry.is_below(place) => Some((place.by(entry, f64::max), None)),
                    _ => Some((place, Some(index))),
                };
            } else if !(den < -error && *low >= 0.0) {
                return None;
            }
        }
        if let (Some((entry, _)), Some((exit, _))) = (found.entry, found.exit) {
            found.is_empty |= exit.is_below(entry);
            if !found.is_empty && !entry.is_below(exit) {
                return None;
            }
        }
        Some(found)
    }

    /// A ray without a part that planes keep: it meets only spheres that they spare.
    pub(crate) fn beyond(ray: CertifiedRay) -> Self {
        Self { ray, entry: None, exit: None, is_empty: true }
    }

    /// A ray that planes keep as a whole.
    pub(crate) fn whole(ray: CertifiedRay) -> Self {
        Self { ray, entry: None, exit: None, is_empty: false }
    }

    /// The place where a ray through the sphere of a point leaves it: by its surface, or, of a sphere that planes cut, by the plane where
    /// what they keep ends.
    pub(crate) fn leaving(&self, planes: &EyePlanes, from: &SurfacePoint, is_cut: bool) -> Leaving {
        // A face lies inside of its sphere.
        let inside = || self.ray.intersect(from.ball).unwrap_or(Bounds::UNKNOWN);
        let bounds = if from.is_face { inside() } else { from.chord(&self.ray) };
        let sphere = NumberedBall { id: from.id, ball: from.ball };
        let root = Between([bounds.low, bounds.high]);
        let by_surface = |sure| Leaving { t: root.0, point: SurfacePoint::met(&self.ray, &bounds, sphere), sure };
        let Some((exit, plane)) = self.exit.filter(|_| is_cut) else { return by_surface(bounds.sure) };
        match plane.filter(|_| exit.middle() < bounds.t) {
            None => by_surface(bounds.sure && root.is_below(exit)),
            Some(plane) => {
                let [low, high] = exit.0;
                let bounds = Bounds { low, high, t: exit.middle(), sure: true, outside: false };
                let point = SurfacePoint::met(&self.ray, &bounds, sphere);
                let inward = planes.normal(plane).map(|x| -x);
                let point = SurfacePoint { outside: false, ..point.on_face(inward) };
                Leaving { t: exit.0, point, sure: exit.is_below(root) }
            }
        }
    }

    /// Whether a sphere, which planes may cut, blocks the ray before its limit.
    pub(crate) fn blocked_by(&self, ball: Ball, is_cut: bool) -> AnyHit {
        let [least, most] = self.ray.limit;
        if !is_cut {
            return AnyHit::of(&self.ray, ball);
        }
        match self.hit_of(ball, true) {
            Answer::Miss => AnyHit::Free,
            Answer::Hit(hit) if hit.t.0[0] >= most => AnyHit::Free,
            Answer::Hit(hit) if hit.t.0[1] < least => AnyHit::Blocked,
            Answer::Unsure(low) if low >= most => AnyHit::Free,
            Answer::Hit(_) | Answer::Unsure(_) => AnyHit::Unsure,
        }
    }

    /// The point of a hit, from which rays leave.
    pub(crate) fn point(&self, planes: &EyePlanes, ball: NumberedBall, hit: CutHit) -> SurfacePoint {
        let [low, high] = hit.t.0;
        let bounds = Bounds { low, high, t: hit.t.middle(), sure: true, outside: hit.root != Root::Far };
        let point = SurfacePoint::met(&self.ray, &bounds, ball);
        match (hit.root, self.entry) {
            (Root::Face, Some((_, Some(plane)))) => point.on_face(planes.normal(plane)),
            _ => point,
        }
    }
}
