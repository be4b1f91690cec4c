//! Streams of copies that are operators over one set of spheres. Groups of copies that no ray can hit first pass without
//! their spheres, front to back, and the extremes of all spheres are found by branch and bound.

use super::witness::{SCORES, witness};
use super::{FIRST, Stream, StreamIds, Visible, visible};
use crate::error::Result;
use crate::memory::{check_wide_ids, ids_fit};
use crate::progress::Watch;
use crate::scene::instances::enclosure::Enclosure;
use crate::scene::instances::{Group, Instances, NumberedSpheres};
use crate::scene::{Scene, Spheres};
use crate::settings::Settings;

/// Spheres that are sifted together.
const BATCH: usize = 1 << 17;

impl Stream {
    /// The spheres that a frame of `scene` with these spheres needs. The fingerprint is that of all of them as far as 32-bit ids
    /// can number them, and else one of the spheres and the operators that they are copies by.
    ///
    /// # Errors
    /// Those of [`Stream::new`] and [`Stream::add`]; [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn of_instances(scene: &Scene, settings: &Settings, instances: &Instances, watch: &Watch) -> Result<Visible> {
        let mut stream = Self::new(scene, settings)?;
        check_wide_ids(instances.total())?;
        let count = instances.ids(&[], watch)?.1;
        if count > 0 {
            stream.see_extremes(instances, watch)?;
            stream.see_depths(instances, watch)?;
            stream.pass(instances, watch)?;
            stream.see_generals(instances, watch)?;
            stream.hash(instances, ids_fit(count), watch)?;
        }
        let mut kept = stream.rest()?;
        if instances.is_colored() {
            // Also where every sphere is clipped.
            kept.spheres.colors.get_or_insert_default();
        }
        let (ids, count) = instances.ids(&kept.numbers, watch)?;
        Ok(visible(stream.scene, kept.spheres, StreamIds { ids, count }, &stream.digests))
    }

    /// Finds the first spheres and those with the extremes of size and place, and opens the sieves in their unit.
    fn see_extremes(&mut self, instances: &Instances, watch: &Watch) -> Result<()> {
        let first = instances.first(FIRST);
        let numbers = first.numbers.iter().take(FIRST).enumerate();
        self.witnesses.first.extend(numbers.map(|(n, number)| witness(&first.spheres, *number, n)));
        for kind in 0..SCORES {
            let found = std::cell::RefCell::new(&mut self.witnesses);
            let bound = |around: &Enclosure| found.borrow().bound(kind, around);
            instances.search(watch, bound, |some| {
                let mut witnesses = found.borrow_mut();
                witnesses.see(&some.spheres, &|n| some.numbers[n]);
                witnesses.score(kind)
            })?;
        }
        let mut ends = Spheres::default();
        self.witnesses.all().for_each(|end| ends.push(end.center, end.radius, end.color));
        self.open(&ends)
    }

    /// Finds the spheres with the extremes of depth for every sieve.
    fn see_depths(&mut self, instances: &Instances, watch: &Watch) -> Result<()> {
        let (sieves, witnesses) = (&self.sieves, &mut self.witnesses);
        let Some(unit) = sieves.first().map(|sieve| sieve.unit()) else { return Ok(()) };
        for (n, sieve) in sieves.iter().enumerate() {
            for end in 0..2 {
                let scaled = |depth: f64| crate::double_double::ldexp(depth, unit);
                let bound = |around: &Enclosure| match sieve.depths(around) {
                    Some([least, most]) => scaled(if end == 0 { -least } else { most }),
                    None => f64::NEG_INFINITY,
                };
                instances.search(watch, bound, |some| {
                    let sifted = super::sift(sieves, &some.spheres, false);
                    witnesses.mark(&some.spheres, &|n| some.numbers[n], &sifted.marks, unit);
                    witnesses.end(n, end)
                })?;
            }
        }
        Ok(())
    }

    /// A frame without general spheres may have a reference depth, so one of them is kept if there are any.
    fn see_generals(&mut self, instances: &Instances, watch: &Watch) -> Result<()> {
        let (sieves, witnesses) = (&self.sieves, &mut self.witnesses);
        let Some(unit) = sieves.first().map(|sieve| sieve.unit()) else { return Ok(()) };
        for (n, sieve) in sieves.iter().enumerate() {
            let [least, most] = [-witnesses.end(n, 0), witnesses.end(n, 1)];
            if witnesses.has_general(n) || least <= 4.0 * (most - least) {
                continue;
            }
            let bound = |around: &Enclosure| if sieve.may_be_general(around) { 0.0 } else { f64::NEG_INFINITY };
            instances.search(watch, bound, |some| {
                let sifted = super::sift(sieves, &some.spheres, false);
                witnesses.mark(&some.spheres, &|n| some.numbers[n], &sifted.marks, unit);
                if witnesses.has_general(n) { 0.0 } else { f64::NEG_INFINITY }
            })?;
        }
        Ok(())
    }

    /// Passes all groups, the nearest first, and keeps what some ray may hit first.
    fn pass(&mut self, instances: &Instances, watch: &Watch) -> Result<()> {
        let basis = self.scene.camera.basis()?;
        let near = |group: &Group| instances.enclosure(group).along(-basis.w, basis.e)[0];
        let (mut batch, mut parts) = (NumberedSpheres::default(), Vec::new());
        // The next one is last.
        let nearest_last = |groups: &mut [Group]| groups.sort_by(|a, b| near(b).total_cmp(&near(a)));
        let mut open = instances.whole();
        nearest_last(&mut open);
        while let Some(group) = open.pop() {
            let around = instances.enclosure(&group);
            let hidden = !self.sieves.is_empty() && self.sieves.iter().all(|sieve| sieve.hides(&around));
            if hidden || instances.clips(&around) == Some(false) {
                continue;
            }
            parts.clear();
            if instances.divide(&group, &mut parts) {
                nearest_last(&mut parts);
                open.extend(&parts);
                continue;
            }
            instances.spheres_of(&group, &mut batch);
            if batch.numbers.len() >= BATCH {
                watch.check()?;
                self.take(&batch)?;
                batch.clear();
            }
        }
        if batch.numbers.is_empty() { Ok(()) } else { self.take(&batch) }
    }

    /// Keeps what some ray may hit first of a batch.
    fn take(&mut self, batch: &NumberedSpheres) -> Result<()> {
        let sifted = super::sift(&self.sieves, &batch.spheres, true);
        let number = |n: usize| batch.numbers[n];
        self.keep(&batch.spheres, &number, &sifted)?;
        self.refresh();
        Ok(())
    }

    /// The fingerprint of all spheres, or of the operators.
    fn hash(&mut self, instances: &Instances, all: bool, watch: &Watch) -> Result<()> {
        if !all {
            let mut at = 0;
            instances.describe(&mut |bytes| {
                self.digests.describe(at, bytes);
                at += bytes.len() as u64;
            });
            return Ok(());
        }
        let mut blocks = instances.blocks();
        let (mut first, mut block) = (0, blocks.next());
        while let Some(this) = block {
            watch.check()?;
            // Places are new, so bytes cannot differ.
            (block, _) = rayon::join(|| blocks.next(), || self.digests.add(first, &this));
            first += this.len() as u64;
        }
        Ok(())
    }
}
