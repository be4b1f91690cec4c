//! Streams of copies that are operators over one set of spheres. Groups of copies that no ray can hit first pass without
//! their spheres, front to back, and the extremes of all spheres are found by branch and bound.

use super::left::LeftCopies;
use super::witness::{FIRST, SCORES, Witnesses};
use super::{Stream, StreamIds, Visible, visible};
use crate::certify::sieve::{Sieve, sift};
use crate::double_double::ldexp;
use crate::scene::Scene;
use crate::scene::instances::enclosure::Enclosure;
use crate::scene::instances::{Group, Instances, NumberedSpheres};
use crate::settings::Settings;
use crate::view::unit;
use halfline_ground::error::Result;
use halfline_ground::memory::{check_wide_ids, ids_fit};
use halfline_ground::parallel;
use halfline_ground::progress::Watch;

/// Spheres that are sifted together.
const SPHERES_PER_BATCH: usize = 1 << 17;

impl Stream {
    /// The spheres that a frame of `scene` with these spheres needs. The fingerprint covers all of them as far as 32-bit ids
    /// can number them, and else the spheres and the operators that they are copies by.
    ///
    /// # Errors
    /// Errors of [`Stream::new`] and [`Stream::add`]; [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn of_instances(scene: &Scene, settings: &Settings, instances: &Instances, watch: &Watch) -> Result<Visible> {
        let mut stream = Self::new(scene, settings)?;
        check_wide_ids(instances.total())?;
        let count = instances.ids(&[], watch)?.1;
        let left = LeftCopies { instances, planes: stream.planes().to_vec() };
        let changed = left.changed(watch)?;
        if changed[1] < count {
            stream.see_extremes(&left, watch)?;
            stream.see_depths(&left, watch)?;
            stream.pass(&left, watch)?;
            stream.see_generals(&left, watch)?;
        }
        if count > 0 {
            stream.hash(instances, ids_fit(count), watch)?;
        }
        let mut kept = stream.rest()?;
        if instances.is_colored() {
            // Also where every sphere is clipped.
            kept.spheres.colors.get_or_insert_default();
        }
        let (ids, count) = instances.ids(&kept.numbers, watch)?;
        visible(stream.scene, kept.spheres, StreamIds { ids, count, changed: Some(changed) }, &stream.digests)
    }

    /// Finds the first spheres and those with the extremes of size and place, and opens the sieves in their unit.
    fn see_extremes(&mut self, left: &LeftCopies<'_>, watch: &Watch) -> Result<()> {
        let first = left.first(FIRST, watch)?;
        self.witnesses.add_first(&first.spheres, &|n| first.numbers[n]);
        for kind in 0..SCORES {
            let found = std::cell::RefCell::new(&mut self.witnesses);
            let bound = |around: &Enclosure| found.borrow().bound(kind, around);
            left.search(watch, bound, |some| {
                let mut witnesses = found.borrow_mut();
                witnesses.see(&some.spheres, &|n| some.numbers[n]);
                witnesses.score(kind)
            })?;
        }
        let (centers, radii): (Vec<_>, Vec<_>) = self.witnesses.all().map(|end| (end.center, end.radius)).unzip();
        self.make_sieves(unit(self.scene.camera.basis()?.e, &centers, &radii)?)
    }

    /// Finds the spheres with the extremes of depth for every sieve.
    fn see_depths(&mut self, left: &LeftCopies<'_>, watch: &Watch) -> Result<()> {
        let unit = self.unit();
        for n in 0..self.sieves.len() {
            for end in 0..2 {
                let scaled = |depth: f64| ldexp(depth, unit);
                let bound = |sieve: &Sieve, bounds: &Enclosure| match sieve.depths(bounds) {
                    Some([least, most]) => scaled(if end == 0 { -least } else { most }),
                    None => f64::NEG_INFINITY,
                };
                self.search_marks(left, watch, n, bound, |witnesses| witnesses.end(n, end))?;
            }
        }
        Ok(())
    }

    /// A frame without general spheres may have a reference depth, so one of them is kept if there are any.
    fn see_generals(&mut self, left: &LeftCopies<'_>, watch: &Watch) -> Result<()> {
        for n in 0..self.sieves.len() {
            let [least, most] = [-self.witnesses.end(n, 0), self.witnesses.end(n, 1)];
            if self.witnesses.has_general(n) || least <= 4.0 * (most - least) {
                continue;
            }
            let score = |is_found: bool| if is_found { 0.0 } else { f64::NEG_INFINITY };
            let bound = |sieve: &Sieve, bounds: &Enclosure| score(sieve.may_be_general(bounds));
            self.search_marks(left, watch, n, bound, |witnesses| score(witnesses.has_general(n)))?;
        }
        Ok(())
    }

    /// Finds the spheres with the greatest score by what sieves mark; `bound` is one of a box in sieve `n`.
    fn search_marks(
        &mut self,
        left: &LeftCopies<'_>,
        watch: &Watch,
        n: usize,
        bound: impl Fn(&Sieve, &Enclosure) -> f64,
        score: impl Fn(&Witnesses) -> f64,
    ) -> Result<()> {
        let (sieves, unit, witnesses) = (&self.sieves, self.unit(), &mut self.witnesses);
        let bound = |bounds: &Enclosure| bound(&sieves[n], bounds);
        left.search(watch, bound, |some| {
            let marks = sift(sieves, &some.spheres, false).marks;
            witnesses.mark(&some.spheres, &|n| some.numbers[n], &marks, unit);
            score(witnesses)
        })
    }

    /// Passes all groups, the nearest first, and keeps what some ray may hit first.
    fn pass(&mut self, left: &LeftCopies<'_>, watch: &Watch) -> Result<()> {
        let instances = left.instances;
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
            if hidden || instances.clips(&around) == Some(false) || left.removes(&around) {
                continue;
            }
            parts.clear();
            if instances.divide(&group, &mut parts) {
                nearest_last(&mut parts);
                open.extend(&parts);
                continue;
            }
            instances.spheres_of(&group, &mut batch);
            if batch.numbers.len() >= SPHERES_PER_BATCH {
                watch.check()?;
                self.take(left.of(&batch)?.as_ref())?;
                batch.clear();
            }
        }
        if batch.numbers.is_empty() { Ok(()) } else { self.take(left.of(&batch)?.as_ref()) }
    }

    /// Keeps what some ray may hit first of a batch.
    fn take(&mut self, batch: &NumberedSpheres) -> Result<()> {
        self.keep_open(&batch.spheres, &|n| batch.numbers[n])?;
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
            (block, _) = parallel::join(|| blocks.next(), || self.digests.add(first, &this));
            first += this.len() as u64;
        }
        Ok(())
    }
}
