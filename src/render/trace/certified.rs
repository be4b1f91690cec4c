//! Certified and exact answers of given rays.

use super::{Hits, Occlusion, Rays, Tracer};
use crate::answers::settle::Settled;
use crate::certify::given::AnyHit;
use crate::cpu::given_certified::{Given, NearestHit, Query};
use crate::error::{Error, Result};
use crate::exact::{Truth, judge_ray_among};
use crate::parallel::{self, CHEAP};
use crate::progress::Watch;
use crate::scene::Spheres;
use crate::settings::{Accuracy, Search};

/// Rays between two looks at whether to go on.
const RAYS_PER_CHECK: usize = 1 << 18;

impl Tracer<'_> {
    pub(super) fn certified_hits(&mut self, rays: &Rays) -> Result<(Hits, Vec<Settled>)> {
        let mut hits = Hits::none(rays.len(), &self.plan);
        let mut settled = Vec::new();
        self.each_answer(rays, |n, answer, truth| match (answer, truth) {
            (NearestHit::Miss, _) => {}
            (NearestHit::Hit { id, numbers: h }, _) => hits.set(n, id, h.t, h.distance, h.normal),
            (NearestHit::Unsure, truth) => {
                hits.certainty[n as usize] = 1;
                settled.push(Settled { pixel: n, truth });
                if let Some(truth) = truth {
                    hits.set(n, truth.id, truth.t, truth.distance, truth.normal);
                }
            }
        })?;
        settled.sort_unstable_by_key(|one| one.pixel);
        Ok((hits, settled))
    }

    pub(super) fn certified_occlusion(&mut self, rays: &Rays) -> Result<Occlusion> {
        let mut occlusion = Occlusion { hit: vec![0; rays.len()], certainty: vec![0; rays.len()] };
        self.each_answer(rays, |n, answer: AnyHit, truth| {
            let n = n as usize;
            occlusion.certainty[n] = u8::from(answer == AnyHit::Unsure);
            occlusion.hit[n] = u8::from(answer == AnyHit::Blocked || truth.is_some());
        })?;
        Ok(occlusion)
    }

    /// Calls `write` with the number of each ray and its certified answer; where that is unsure, and for exact answers, with
    /// the truth beside it. Rays are answered in an order in which neighbours visit the same boxes.
    fn each_answer<Q: Query>(&mut self, rays: &Rays, mut write: impl FnMut(u32, Q, Option<Truth>)) -> Result<()> {
        let Self { renderer, spheres, plan, tree, device, tolerance, .. } = self;
        let Some(tree) = tree else {
            return Ok(());
        };
        let given = Given { tree, rays, all: plan.search == Search::All, tolerance: *tolerance };
        for numbers in given.order().chunks(RAYS_PER_CHECK) {
            if !renderer.watch.goes_on() {
                return Err(Error::Interrupted);
            }
            let answers: Vec<Q> = match (&mut renderer.device.gpu, &mut *device) {
                _ if plan.accuracy == Accuracy::Exact => vec![Q::UNSURE; numbers.len()],
                (Some(gpu), Some(device)) => device.answers(gpu, &given, numbers, &renderer.watch)?,
                _ => given.each(numbers),
            };
            let unsure = parallel::collect(numbers.len(), CHEAP, &|range, unsure| {
                unsure.extend(range.filter(|k| answers[*k] == Q::UNSURE).map(|k| numbers[k]));
            });
            let mut settled = settle(spheres, &given, &unsure, &renderer.watch).into_iter();
            // Rays that were left out have no truth.
            renderer.watch.check()?;
            for (answer, &n) in answers.into_iter().zip(numbers) {
                let truth = if answer == Q::UNSURE { settled.next().flatten() } else { None };
                write(n, answer, truth);
            }
        }
        Ok(())
    }
}

/// Rays that one job decides in exact arithmetic.
const RAYS_PER_JOB: usize = 16;

/// Decides rays in exact arithmetic, among the spheres that may be hit first, until the work is cancelled.
fn settle(spheres: &Spheres, given: &Given<'_>, numbers: &[u32], watch: &Watch) -> Vec<Option<Truth>> {
    let decide = |&n: &u32| {
        if !watch.goes_on() {
            return None;
        }
        let ray = given.rays.ray(n as usize);
        let judge =
            |ids: &mut dyn Iterator<Item = u32>| judge_ray_among(ray.origin, ray.direction, ray.limit, spheres, ids);
        if given.all {
            judge(&mut (0..spheres.len() as u32))
        } else {
            judge(&mut given.candidates(&ray, &|_| true).into_iter())
        }
    };
    parallel::collect(numbers.len(), RAYS_PER_JOB, &|range, truths| truths.extend(numbers[range].iter().map(decide)))
}

impl Hits {
    fn set(&mut self, n: u32, id: u32, t: f64, distance: f64, normal: [f64; 3]) {
        let n = n as usize;
        (self.id[n], self.t[n], self.distance[n]) = (id as i32, t, distance);
        if let Some(normals) = &mut self.normal {
            normals[n] = normal.map(|x| x as f32);
        }
    }
}
