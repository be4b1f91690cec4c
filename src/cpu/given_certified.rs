//! Certified answers of given rays on the CPU path: boxes and spheres of the tree in f32 vectors, then bounds in f64 for
//! the few spheres that are left.

use super::foremost::Foremost;
use super::given_cuts::GivenCuts;
use crate::certify::given::{AnyHit, Bounds, CertifiedRay, HitNumbers};
use crate::exact::{Truth, judge_ray_among};
use crate::scene::Spheres;
use crate::search::tree::lanes::{Lanes, Portable, RAYS_PER_TASK, Work, dispatch};
use crate::search::tree::walk::{Test, may_intersect, may_pass, pass_all, walk};
use crate::search::tree::{BoxRay, Tree, order};
use crate::view::given::{GivenRay, Rays};
use halfline_ground::parallel;
use std::ops::Range;

/// The answer to the nearest hit of one ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum NearestHit {
    Miss,
    Hit { id: u32, numbers: HitNumbers },
    Unsure,
}

/// Rays and the spheres that they may hit.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a> {
    pub(crate) tree: &'a Tree,
    pub(crate) rays: &'a Rays<'a>,
    /// Whether every ray tests all spheres, without the boxes.
    pub(crate) all: bool,
    /// The promised relative error of t.
    pub(crate) tolerance: f64,
    /// The planes that cut spheres.
    pub(crate) cuts: Option<&'a GivenCuts<'a>>,
}

/// Largest error of a certified normal, in radians: the promised 1e-3, less the rounding to f32.
/// Section 9 of docs/certificate.md.
const TILT: f64 = 0.97e-3;

impl Given<'_> {
    /// The answers to the rays with these numbers.
    pub(crate) fn each<Q: Query>(&self, numbers: &[u32]) -> Vec<Q> {
        let mut answers = vec![Q::UNSURE; numbers.len()];
        parallel::fill(&mut answers[..], RAYS_PER_TASK, &|range, answers| {
            dispatch(Task { given: self, numbers: &numbers[range], answers });
        });
        answers
    }

    /// The ray in f64 and as the boxes see it; `None` if it certainly hits nothing.
    #[inline(always)]
    pub(crate) fn ray(&self, ray: &GivenRay) -> Option<(CertifiedRay, BoxRay)> {
        let ray = CertifiedRay::new(&self.tree.placement, ray.origin, ray.direction, ray.limit);
        if ray.limit[1] <= 0.0 {
            return None;
        }
        let boxes = BoxRay::new(ray.placed(), ray.direction, 0.0)?;
        Some((ray, boxes))
    }

    /// The nearest hit of a ray among the spheres whose ids count.
    pub(crate) fn nearest_among(&self, ray: &GivenRay, counts: &dyn Fn(u32) -> bool) -> NearestHit {
        dispatch(NearestAmong { given: self, ray, counts })
    }

    #[inline(always)]
    fn nearest_of<L: Lanes>(&self, lanes: L, ray: &GivenRay, counts: impl Fn(usize) -> bool) -> NearestHit {
        let Some((ray, boxes)) = self.ray(ray) else {
            return NearestHit::Miss;
        };
        if let Some(cuts) = self.cuts {
            return match cuts.nearest((self.tree, self.all), lanes, (&ray, &boxes), counts) {
                Some(None) => NearestHit::Miss,
                Some(Some((id, numbers))) if self.is_good(&numbers) => NearestHit::Hit { id, numbers },
                _ => NearestHit::Unsure,
            };
        }
        let limit = boxes.limit(ray.limit[1]);
        let (tree, foremost) = (self.tree, Foremost::of(None));
        let mut search = NearestSearch { lanes, tree, ray: &ray, boxes: &boxes, counts, limit, foremost };
        if self.all {
            pass_all(self.tree, &mut search);
        } else {
            walk::<false, _>(lanes, self.tree, &boxes, limit, &mut search);
        }
        match (search.foremost.best, search.foremost.rival) {
            (None, f64::INFINITY) => NearestHit::Miss,
            (Some((place, bounds)), rival) if rival > bounds.high => self.hit(&ray, place, &bounds),
            _ => NearestHit::Unsure,
        }
    }

    /// The answer where the nearest hit is on the sphere at `place`.
    #[inline(always)]
    fn hit(&self, ray: &CertifiedRay, place: usize, bounds: &Bounds) -> NearestHit {
        let numbers = ray.numbers(self.tree.ball(place), bounds);
        if bounds.sure && self.is_good(&numbers) {
            NearestHit::Hit { id: self.tree.ids[place], numbers }
        } else {
            NearestHit::Unsure
        }
    }

    /// Whether the numbers of a hit are within the promised errors.
    #[inline(always)]
    fn is_good(&self, numbers: &HitNumbers) -> bool {
        numbers.error <= self.tolerance && numbers.tilt <= TILT
    }

    #[inline(always)]
    fn any_of<L: Lanes>(&self, lanes: L, ray: &GivenRay) -> AnyHit {
        let Some((ray, boxes)) = self.ray(ray) else {
            return AnyHit::Free;
        };
        if let Some(cuts) = self.cuts {
            return cuts.any((self.tree, self.all), lanes, (&ray, &boxes));
        }
        let limit = boxes.limit(ray.limit[1]);
        let limits = [boxes.limit_below(ray.limit[0]), limit];
        let (tree, counts, found) = (self.tree, |_| true, AnyHit::Free);
        let mut search = AnySearch { lanes, tree, ray: &ray, boxes: &boxes, counts, limits, found };
        if self.all {
            pass_all(self.tree, &mut search);
        } else {
            walk::<true, _>(lanes, self.tree, &boxes, limit, &mut search);
        }
        search.found
    }

    /// The spheres that may be the nearest hit of a ray among those whose ids count, in the scene's order.
    fn candidates(&self, ray: &GivenRay, counts: &dyn Fn(u32) -> bool) -> Vec<u32> {
        let Some((ray, boxes)) = self.ray(ray) else {
            return Vec::new();
        };
        let nearest = ray.limit[1];
        let mut search = NearestCandidates { given: self, ray: &ray, boxes: &boxes, counts, nearest, all: Vec::new() };
        walk::<false, _>(Portable, self.tree, &boxes, boxes.limit(nearest), &mut search);
        let near = search.all.into_iter().filter(|(low, _)| *low <= search.nearest);
        let mut ids: Vec<u32> = near.map(|(_, id)| id).collect();
        ids.sort_unstable();
        ids
    }

    /// The nearest hit of a ray in exact arithmetic, among the spheres of the tree whose ids count.
    pub(crate) fn judged(&self, ray: &GivenRay, spheres: &Spheres, counts: &dyn Fn(u32) -> bool) -> Option<Truth> {
        let GivenRay { origin, direction, limit } = *ray;
        let among = |ids: &mut dyn Iterator<Item = u32>| judge_ray_among(origin, direction, limit, spheres, ids);
        match self.all {
            true => among(&mut (0..spheres.len() as u32).filter(|id| counts(*id))),
            false => among(&mut self.candidates(ray, counts).into_iter()),
        }
    }

    /// The numbers of some rays in an order in which neighbours visit the same boxes.
    pub(crate) fn order(&self, numbers: Range<usize>) -> Vec<u32> {
        if self.all {
            return numbers.map(|n| n as u32).collect();
        }
        order(numbers, |n| self.ray(&self.rays.ray(n)).map(|(_, boxes)| boxes))
    }
}

/// The search for the nearest hit of a ray, among the spheres whose places count.
pub(super) struct NearestSearch<'a, L, F> {
    pub(super) lanes: L,
    pub(super) tree: &'a Tree,
    pub(super) ray: &'a CertifiedRay,
    pub(super) boxes: &'a BoxRay,
    pub(super) counts: F,
    pub(super) limit: f32,
    pub(super) foremost: Foremost,
}

impl<L: Lanes, F: Fn(usize) -> bool> Test for NearestSearch<'_, L, F> {
    #[inline(always)]
    fn test(&mut self, block: u32) -> f32 {
        for place in may_intersect(self.lanes, self.tree, block, self.boxes, self.limit) {
            if (self.counts)(place)
                && let Some(bounds) = self.ray.intersect(self.tree.ball(place))
                && self.foremost.keep(self.tree, self.ray, place, bounds)
            {
                self.limit = self.boxes.limit(bounds.high);
            }
        }
        self.limit
    }
}

/// The search for any hit of a ray, among the spheres whose places count.
pub(super) struct AnySearch<'a, L, F> {
    pub(super) lanes: L,
    pub(super) tree: &'a Tree,
    pub(super) ray: &'a CertifiedRay,
    pub(super) boxes: &'a BoxRay,
    pub(super) counts: F,
    /// Lower and upper bound of the ray's limit, in the boxes' t: a certain hit before the first blocks the ray, a hit
    /// from the second on does not count.
    pub(super) limits: [f32; 2],
    pub(super) found: AnyHit,
}

impl<L: Lanes, F: Fn(usize) -> bool> Test for AnySearch<'_, L, F> {
    #[inline(always)]
    fn test(&mut self, block: u32) -> f32 {
        let Some(places) = may_pass(self.lanes, self.tree, block, self.boxes, self.limits) else {
            self.found = AnyHit::Blocked;
            return -1.0;
        };
        for place in places {
            if !(self.counts)(place) {
                continue;
            }
            match AnyHit::of(self.ray, self.tree.ball(place)) {
                AnyHit::Free => {}
                AnyHit::Unsure => self.found = AnyHit::Unsure,
                AnyHit::Blocked => {
                    self.found = AnyHit::Blocked;
                    return -1.0;
                }
            }
        }
        self.limits[1]
    }
}

/// The search for all spheres that may be hit first.
struct NearestCandidates<'a, 'b> {
    given: &'a Given<'b>,
    ray: &'a CertifiedRay,
    boxes: &'a BoxRay,
    counts: &'a dyn Fn(u32) -> bool,
    /// Upper bound of t of the nearest hit: from the nearest sure hit so far, or from the ray's limit.
    nearest: f64,
    all: Vec<(f64, u32)>,
}

impl Test for NearestCandidates<'_, '_> {
    fn test(&mut self, block: u32) -> f32 {
        for place in self.given.tree.places(block) {
            let id = self.given.tree.ids[place];
            if let Some(bounds) = self.ray.intersect(self.given.tree.ball(place)).filter(|_| (self.counts)(id)) {
                let changes = self.given.cuts.is_some_and(|cuts| cuts.changes(id));
                // From inside, a face comes before the root.
                let low = if changes && !bounds.outside { 0.0 } else { bounds.low };
                self.all.push((low, id));
                if bounds.sure && !changes {
                    self.nearest = self.nearest.min(bounds.high);
                }
            }
        }
        self.boxes.limit(self.nearest)
    }
}

/// The answer to a ray; its type tells the question: the nearest hit, or any hit.
pub(crate) trait Query: Copy + PartialEq + Send + Sync {
    /// The answer of a ray that is not decided.
    const UNSURE: Self;
    fn of<L: Lanes>(given: &Given<'_>, lanes: L, ray: &GivenRay) -> Self;
}

impl Query for NearestHit {
    const UNSURE: Self = Self::Unsure;
    #[inline(always)]
    fn of<L: Lanes>(given: &Given<'_>, lanes: L, ray: &GivenRay) -> Self {
        given.nearest_of(lanes, ray, |_| true)
    }
}

impl Query for AnyHit {
    const UNSURE: Self = Self::Unsure;
    #[inline(always)]
    fn of<L: Lanes>(given: &Given<'_>, lanes: L, ray: &GivenRay) -> Self {
        given.any_of(lanes, ray)
    }
}

/// One ray and the spheres that count.
struct NearestAmong<'a, 'b> {
    given: &'a Given<'b>,
    ray: &'a GivenRay,
    counts: &'a dyn Fn(u32) -> bool,
}

impl Work for NearestAmong<'_, '_> {
    type Output = NearestHit;

    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) -> NearestHit {
        let Self { given, ray, counts } = self;
        given.nearest_of(lanes, ray, |place| counts(given.tree.ids[place]))
    }
}

/// Some rays and the places of their answers.
struct Task<'a, 'b, Q> {
    given: &'a Given<'b>,
    numbers: &'a [u32],
    answers: &'a mut [Q],
}

impl<Q: Query> Work for Task<'_, '_, Q> {
    type Output = ();

    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        // All at once, since in another order every ray is a wait for memory, and the processor can have many.
        let mut rays = [GivenRay::default(); RAYS_PER_TASK];
        for (ray, &n) in rays.iter_mut().zip(self.numbers) {
            *ray = self.given.rays.ray(n as usize);
        }
        for (answer, ray) in self.answers.iter_mut().zip(&rays) {
            *answer = Q::of(self.given, lanes, ray);
        }
    }
}
