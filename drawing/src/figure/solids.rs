//! Balls that planes cut: what the ray of a place hits first.

use super::circle::{Ball, Plane, Projection};
use glam::{DVec2, DVec3};

/// A part of what is seen: of the sphere of a ball, or of the face in which a plane cuts it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Surface {
    /// The id of the sphere.
    pub sphere: u32,
    /// The number of the plane; `None` for the sphere itself.
    pub face: Option<u32>,
}

impl Surface {
    pub(super) fn of(sphere: u32) -> Self {
        Self { sphere, face: None }
    }
}

/// A plane that cuts balls, with a normal of length 1 toward what it removes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cut {
    pub(super) plane: Plane,
    /// Whether rays lie in it.
    pub(super) is_edge_on: bool,
}

/// Balls in front of a camera, the planes, and which balls they cut and which stand whole among them.
pub(super) struct Solids {
    pub(super) balls: Vec<Ball>,
    pub(super) is_cut: Vec<bool>,
    pub(super) is_spared: Vec<bool>,
    pub(super) cuts: Vec<Cut>,
    pub(super) projection: Projection,
}

/// A question about the ray of a place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Question {
    /// Balls that are left out.
    pub(super) but: [u32; 2],
    /// Balls that the ray only touches count if they are nearer than this.
    pub(super) near: f64,
    /// Planes whose faces are left out.
    pub(super) without: [u32; 2],
    /// A plane in which the ray lies, and whether it is on the kept side.
    pub(super) on_edge: Option<(u32, bool)>,
}

impl Default for Question {
    fn default() -> Self {
        Self { but: [u32::MAX; 2], near: f64::NEG_INFINITY, without: [u32::MAX; 2], on_edge: None }
    }
}

/// The part of a ray that planes keep, and the plane at which it begins.
struct Interval {
    from: f64,
    face: Option<u32>,
    to: f64,
}

impl Solids {
    /// Whether the planes keep a point, without some of them.
    pub(super) fn keep(&self, x: DVec3, but: [u32; 2]) -> bool {
        (0..).zip(&self.cuts).all(|(n, cut)| but.contains(&n) || cut.plane.height(x) < 0.0)
    }

    fn interval(&self, place: DVec2, on_edge: Option<(u32, bool)>) -> Interval {
        let (start, along) = self.projection.ray(place);
        let mut interval = Interval { from: 0.0, face: None, to: f64::INFINITY };
        for (n, Cut { plane, is_edge_on }) in (0..).zip(&self.cuts) {
            let slope = plane.normal.dot(along);
            if *is_edge_on || slope == 0.0 {
                let known = on_edge.filter(|(plane, _)| *plane == n).map(|(_, is_kept)| is_kept);
                if !known.unwrap_or_else(|| plane.height(start + along) < 0.0) {
                    interval.to = f64::NEG_INFINITY;
                }
                continue;
            }
            let depth = -plane.height(start) / slope;
            if slope > 0.0 {
                interval.to = interval.to.min(depth);
            } else if depth > interval.from {
                (interval.from, interval.face) = (depth, Some(n));
            }
        }
        interval
    }

    /// The depth at which the ray of a place first hits a ball, and the plane of a face.
    fn hit(&self, n: u32, place: DVec2, near: f64, interval: &Interval) -> Option<(f64, Option<u32>)> {
        let [first, second] = self.balls[n as usize].depths(&self.projection, place, near)?;
        if !self.is_cut[n as usize] {
            return Some((first, None));
        }
        let Interval { from, face, to } = *interval;
        match first {
            _ if from >= to || first >= to || second <= from => None,
            _ if first > from => Some((first, None)),
            _ => face.map(|plane| (from, Some(plane))),
        }
    }

    /// The depth of a ball at a place.
    pub(super) fn depth(&self, n: u32, place: DVec2) -> Option<f64> {
        let interval = self.interval(place, None);
        self.hit(n, place, f64::NEG_INFINITY, &interval).map(|(depth, _)| depth)
    }

    /// The nearest surface of some balls at a place, with its depth. Of faces in one plane it is the face of the smallest ball, then of the first.
    pub(super) fn nearest(&self, balls: &[u32], place: DVec2, question: Question) -> Option<(f64, Surface)> {
        let Question { but, near, without, on_edge } = question;
        let interval = self.interval(place, on_edge);
        let others = balls.iter().copied().filter(|n| !but.contains(n));
        let hit = |sphere: u32| {
            let (depth, face) = self.hit(sphere, place, near, &interval)?;
            let rank = face.map_or(0.0, |_| self.balls[sphere as usize].radius);
            let is_left_out = face.is_some_and(|plane| without.contains(&plane));
            (!is_left_out).then_some((depth, rank, Surface { sphere, face }))
        };
        let nearest = others
            .filter_map(hit)
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.sphere.cmp(&b.2.sphere)));
        nearest.map(|(depth, _, surface)| (depth, surface))
    }

    /// Whether the face of one ball lies over the face of another in one plane.
    pub(super) fn is_before(&self, a: u32, b: u32) -> bool {
        let [one, other] = [a, b].map(|n| self.balls[n as usize].radius);
        one < other || one == other && a < b
    }

    /// The ball of some, but for one, that shows its face at a point of a plane.
    pub(super) fn owner(&self, balls: &[u32], x: DVec3, but: u32) -> Option<u32> {
        let holds = |n: &u32| {
            let Ball { center, radius } = self.balls[*n as usize];
            self.is_cut[*n as usize] && *n != but && x.distance_squared(center) < radius * radius
        };
        let candidates = balls.iter().copied().filter(holds);
        candidates.reduce(|a, b| if self.is_before(b, a) { b } else { a })
    }
}
