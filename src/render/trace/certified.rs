//! Certified and exact answers of given rays.

use super::{Hits, Occlusion, Rays, Tracer};
use crate::cpu::given_certified::{AnyHit, Given, NearestHit, Query};
use crate::error::{Error, Result};
use crate::exact::{Truth, judge_ray_among};
use crate::settings::{Accuracy, Search};
use rayon::prelude::*;

/// Rays between two looks at whether to go on.
const PART: usize = 1 << 18;

impl Tracer<'_> {
    pub(super) fn certified_hits(&mut self, rays: &Rays) -> Result<Hits> {
        let mut hits = Hits { search: self.plan.search, ..Hits::none(rays.len(), self.plan.normal) };
        self.each_part(rays, |this, given, numbers| {
            let answers: Vec<NearestHit> = this.answers(given, numbers);
            let unsure = |(answer, n): (&NearestHit, &u32)| matches!(answer, NearestHit::Unsure).then_some(*n);
            let unsure: Vec<u32> = answers.iter().zip(numbers).filter_map(unsure).collect();
            for (answer, &n) in answers.iter().zip(numbers) {
                if let NearestHit::Hit { id, numbers } = answer {
                    hits.set(n, *id, numbers.t, numbers.distance, numbers.normal);
                }
            }
            for (&n, truth) in unsure.iter().zip(this.settle(given, &unsure)) {
                hits.certainty[n as usize] = 1;
                if let Some(truth) = truth {
                    hits.set(n, truth.id, truth.t, truth.distance, truth.normal);
                }
            }
        })?;
        Ok(hits)
    }

    pub(super) fn certified_occlusion(&mut self, rays: &Rays) -> Result<Occlusion> {
        let mut occlusion = Occlusion { hit: vec![0; rays.len()], certainty: vec![0; rays.len()] };
        self.each_part(rays, |this, given, numbers| {
            let answers: Vec<AnyHit> = this.answers(given, numbers);
            let mut unsure = Vec::new();
            for (answer, &n) in answers.iter().zip(numbers) {
                match answer {
                    AnyHit::Free => {}
                    AnyHit::Blocked => occlusion.hit[n as usize] = 1,
                    AnyHit::Unsure => unsure.push(n),
                }
            }
            for (&n, truth) in unsure.iter().zip(this.settle(given, &unsure)) {
                occlusion.certainty[n as usize] = 1;
                occlusion.hit[n as usize] = u8::from(truth.is_some());
            }
        })?;
        Ok(occlusion)
    }

    /// Calls `part` with the numbers of some rays at a time, in an order in which neighbours visit the same boxes.
    fn each_part(&mut self, rays: &Rays, mut part: impl FnMut(&Self, &Given<'_>, &[u32])) -> Result<()> {
        let Some(tree) = &self.tree else {
            return Ok(());
        };
        let given = Given { tree, rays, all: self.plan.search == Search::All, tolerance: self.tolerance };
        for numbers in given.order().chunks(PART) {
            if !self.renderer.watch.goes_on() {
                return Err(Error::Interrupted);
            }
            part(self, &given, numbers);
        }
        Ok(())
    }

    /// The certified answers; where exact ones are requested, every ray is left to the judge.
    fn answers<Q: Query>(&self, given: &Given<'_>, numbers: &[u32]) -> Vec<Q> {
        if self.plan.accuracy == Accuracy::Exact { vec![Q::UNSURE; numbers.len()] } else { given.each(numbers) }
    }

    /// Decides rays in exact arithmetic, among the spheres that may be hit first.
    fn settle(&self, given: &Given<'_>, numbers: &[u32]) -> Vec<Option<Truth>> {
        let decide = |&n: &u32| {
            let ray = given.rays.ray(n as usize);
            let judge = |ids: &mut dyn Iterator<Item = u32>| {
                judge_ray_among(ray.origin, ray.direction, ray.limit, self.spheres, ids)
            };
            if given.all {
                judge(&mut (0..self.spheres.len() as u32))
            } else {
                judge(&mut given.candidates(&ray).into_iter())
            }
        };
        numbers.par_iter().map(decide).collect()
    }
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
