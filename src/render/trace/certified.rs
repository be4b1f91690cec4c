//! Certified and exact answers of given rays, in blocks of rays that one thread orders, answers and writes; idle threads help.

use super::{Hits, Occlusion, Rays, Tracer};
use crate::answers::assemble::{STEPS, settled_bound};
use crate::answers::settle::Settled;
use crate::certify::given::AnyHit;
use crate::cpu::given_certified::{Given, NearestHit, Query};
use crate::cpu::given_cuts::GivenCuts;
use crate::exact::Truth;
use crate::scene::Spheres;
use crate::settings::{Accuracy, Search};
use halfline_ground::error::Result;
use halfline_ground::parallel::{self, CHEAP, Target};
use halfline_ground::progress::Watch;

/// Spheres for each ray of a block: with fewer rays among more spheres, neighbours in the order of a block have fewer boxes in common.
const SPHERES_PER_RAY: usize = 4;

/// Least rays of a block: their answers, 2 MB, are written while they are in a cache.
pub(super) const LEAST: usize = 1 << 15;

impl Tracer<'_> {
    /// The nearest hits, and the truths of the rays that the judge settled, in the order of the rays.
    pub(super) fn certified_hits(&mut self, rays: &Rays) -> Result<(Hits, Vec<Settled>)> {
        let mut hits = self.misses(rays.len());
        let Hits { id, t, distance, certainty, normal, bound, .. } = &mut hits;
        let numbers = ((&mut t[..], &mut distance[..]), (normal.as_deref_mut(), bound.as_deref_mut()));
        let places = ((&mut id[..], &mut certainty[..]), numbers);
        let settled = self.each_answer(rays, places, &|places, n, answer, truth| {
            let ((id, certainty), ((t, distance), (normals, bounds))) = places;
            certainty[n] = u8::from(answer == NearestHit::Unsure);
            let (sphere, at, length, normal, bound) = match (answer, truth) {
                (NearestHit::Hit { id, numbers: h }, _) => {
                    (id, h.t, h.distance, h.normal, h.error * h.distance + STEPS)
                }
                (_, Some(truth)) => (truth.id, truth.t, truth.distance, truth.normal, settled_bound(truth.distance)),
                (_, None) => return,
            };
            (id[n], t[n], distance[n]) = (sphere as i32, at, length);
            normals.iter_mut().for_each(|normals| normals[n] = normal.map(|x| x as f32));
            bounds.iter_mut().for_each(|bounds| bounds[n] = bound);
        })?;
        Ok((hits, settled))
    }

    pub(super) fn certified_occlusion(&mut self, rays: &Rays) -> Result<Occlusion> {
        let mut occlusion = Occlusion { hit: vec![0; rays.len()], certainty: vec![0; rays.len()] };
        let places = (&mut occlusion.hit[..], &mut occlusion.certainty[..]);
        self.each_answer(rays, places, &|(hit, certainty), n, answer: AnyHit, truth| {
            certainty[n] = u8::from(answer == AnyHit::Unsure);
            hit[n] = u8::from(answer == AnyHit::Blocked || truth.is_some());
        })?;
        Ok(occlusion)
    }

    /// Has `write` put the certified answer of each ray into its place of `places`; where that is unsure, and for exact answers,
    /// with the truth beside it. The truths are returned, in the order of the rays.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    fn each_answer<Q: Query, T: Target>(
        &mut self,
        rays: &Rays,
        places: T,
        write: &Write<'_, Q, T>,
    ) -> Result<Vec<Settled>> {
        let Self { renderer, spheres, plan, tree, tolerance, .. } = self;
        let Some(tree) = tree else {
            return Ok(Vec::new());
        };
        let cuts = spheres.cuts.as_ref().map(GivenCuts::new);
        let (all, tolerance) = (plan.search == Search::All, *tolerance);
        let given = Given { tree, rays, all, tolerance, cuts: cuts.as_ref() };
        let answering = Answering { given, spheres, watch: &renderer.watch, write };
        let is_exact = plan.accuracy == Accuracy::Exact;
        let block = (spheres.len() / SPHERES_PER_RAY).max(LEAST);
        let blocks = parallel::blocks(places, block, &|range, places| {
            answering.watch.check()?;
            let numbers = given.order(range.clone());
            let answers = if is_exact { vec![Q::UNSURE; numbers.len()] } else { given.each(&numbers) };
            answering.finish(range.start, places, &numbers, &answers)
        });
        let settled = blocks.into_iter().collect::<Result<Vec<_>>>()?;
        Ok(settled.into_iter().flatten().collect())
    }
}

/// Puts an answer, with the truth of an unsure one, into the places of a block, by its number there.
type Write<'a, Q, T> = dyn Fn(&mut T, usize, Q, Option<&Truth>) + Sync + 'a;

/// The work that remains with the answers of a block.
struct Answering<'a, Q, T> {
    given: Given<'a>,
    spheres: &'a Spheres,
    watch: &'a Watch,
    write: &'a Write<'a, Q, T>,
}

/// Rays that one job decides in exact arithmetic.
const RAYS_PER_JOB: usize = 16;

impl<Q: Query, T: Target> Answering<'_, Q, T> {
    /// Settles and writes the answers to the rays with these numbers, the rays of a block from `first` on. Returns the truths in the
    /// order of the rays.
    fn finish(&self, first: usize, places: T, numbers: &[u32], answers: &[Q]) -> Result<Vec<Settled>> {
        let unsure: Vec<u32> = parallel::collect(numbers.len(), CHEAP, &|range, unsure| {
            unsure.extend(range.filter(|k| answers[*k] == Q::UNSURE).map(|k| numbers[k]));
        });
        let mut settled: Vec<Settled> = parallel::collect(unsure.len(), RAYS_PER_JOB, &|range, settled| {
            settled.extend(unsure[range].iter().map(|&n| Settled { pixel: n, truth: self.decide(n) }));
        });
        // Rays that were left out have no truth.
        self.watch.check()?;
        settled.sort_unstable_by_key(|settled| settled.pixel);
        let truth = |n: usize| {
            let found = settled.binary_search_by_key(&((first + n) as u32), |settled| settled.pixel);
            found.ok().and_then(|at| settled[at].truth.as_ref())
        };
        let mut order = vec![0; numbers.len()];
        (0..).zip(numbers).for_each(|(k, &n)| order[n as usize - first] = k);
        parallel::fill(places, CHEAP, &|range, mut places| {
            for (place, n) in range.enumerate() {
                let answer = answers[order[n] as usize];
                let truth = if answer == Q::UNSURE { truth(n) } else { None };
                (self.write)(&mut places, place, answer, truth);
            }
        });
        Ok(settled)
    }

    /// Decides a ray in exact arithmetic, among the spheres that may be hit first, unless the work is cancelled.
    fn decide(&self, n: u32) -> Option<Truth> {
        if !self.watch.goes_on() {
            return None;
        }
        self.given.judged(&self.given.rays.ray(n as usize), self.spheres, &|_| true)
    }
}
