//! Layers of translucent spheres: of each viewing ray the hits after the first, in their exact order, and their colours.

use super::settle::CutSettler;
use crate::certify::Certify;
use crate::certify::binned::BinnedScene;
use crate::certify::constants::VANISH;
use crate::exact::Judge;
use crate::scene::{Scene, Spheres};
use crate::view::View;
use crate::view::ray::{NONE, UNSURE};
use halfline_ground::error::Result;
use halfline_ground::parallel::{self, CHEAP, Rows};
use halfline_ground::progress::{Step, Watch};
use std::cell::OnceCell;

/// Pixels that one job peels.
const PIXELS_PER_JOB: usize = 256;

/// The layers that are looked for behind the first.
#[derive(Clone, Copy)]
pub(crate) struct Layers<'a> {
    /// The opaque sphere that each pixel shows; [`NONE`] where there is none.
    pub(crate) opaque: &'a [u32],
    /// The nearest translucent sphere before it; [`NONE`] where there is none.
    pub(crate) first: &'a [u32],
    /// The number of layers behind.
    pub(crate) more: u32,
}

/// The nearest sphere that counts of a pixel, behind some that are found.
pub(crate) type Next<'a> = &'a (dyn Fn(usize, &[u32]) -> Option<u32> + Sync);

impl Layers<'_> {
    /// Whether a pixel may show this sphere behind the first, or as its opaque one.
    pub(crate) fn counts(&self, spheres: &Spheres, pixel: usize, id: u32) -> bool {
        id != self.first[pixel] && (id == self.opaque[pixel] || spheres.opacity(id) < 1.0)
    }

    /// Ends the rays of the next layer that is found where the one before has none, and at the opaque spheres. The pixels that are undecided
    /// end too, and are returned.
    pub(crate) fn end(&self, before: &[u32], next: &mut [u32]) -> Vec<u32> {
        let undecided = parallel::collect(next.len(), CHEAP, &|pixels, out| {
            out.extend(
                pixels.filter(|pixel| next[*pixel] == UNSURE && before[*pixel] != NONE).map(|pixel| pixel as u32),
            );
        });
        parallel::each(next, |pixel, id| {
            if *id == UNSURE || before[pixel] == NONE || *id == self.opaque[pixel] {
                *id = NONE;
            }
        });
        undecided
    }

    /// The layers, pixel by pixel: `next` returns the nearest hit that counts of a pixel, behind those that are found.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`].
    pub(crate) fn peel(&self, watch: &Watch, next: Next<'_>) -> Result<Vec<Vec<u32>>> {
        let each = self.more as usize;
        let mut all = vec![NONE; each * self.first.len()];
        let doing = watch.begin(Step::Settle, self.first.len() as u64);
        parallel::fill(Rows { values: &mut all, each }, PIXELS_PER_JOB, &|pixels, all| {
            if !doing.next(pixels.len() as u64) {
                return;
            }
            let mut found = Vec::with_capacity(each + 1);
            for (pixel, layers) in
                pixels.zip(all.values.chunks_mut(each)).filter(|(pixel, _)| self.first[*pixel] != NONE)
            {
                found.clear();
                found.push(self.first[pixel]);
                for layer in layers {
                    let Some(id) = next(pixel, &found).filter(|id| *id != self.opaque[pixel]) else { break };
                    *layer = id;
                    found.push(id);
                }
            }
        });
        doing.end()?;
        Ok((0..each).map(|k| all.iter().skip(k).step_by(each).copied().collect()).collect())
    }

    /// The layers in exact arithmetic alone, among all spheres.
    ///
    /// # Errors
    /// Errors of [`View::judge`], and [`crate::Error::Interrupted`].
    pub(crate) fn judged(&self, scene: &Scene, view: &View, watch: &Watch) -> Result<Vec<Vec<u32>>> {
        let judge = view.judge(scene)?;
        self.peel(watch, &|pixel, found| {
            let [row, column] = view.record.position(pixel as u32);
            let counts = |id: &u32| !found.contains(id) && self.counts(&scene.spheres, pixel, *id);
            let open: Vec<u32> = (0..scene.spheres.len() as u32).filter(counts).collect();
            judge.among(row, column, &open).map(|truth| truth.id)
        })
    }
}

/// The search for the hits behind the first of pixels that strips leave undecided.
pub(crate) struct Peeling<'a> {
    scene: &'a Scene,
    view: &'a View,
    /// The spheres in lists from which none that a ray may show is left out.
    lists: &'a BinnedScene,
    layers: Layers<'a>,
    /// The decisions in f64, in a scene whose spheres planes cut.
    cuts: Option<CutSettler<'a>>,
}

/// A sphere that a ray may hit.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// A lower bound of the hit's depth.
    low: f32,
    slot: u32,
    id: u32,
}

impl<'a> Peeling<'a> {
    /// # Errors
    /// Errors of the judge.
    pub(crate) fn new(scene: &'a Scene, view: &'a View, lists: &'a BinnedScene, layers: Layers<'a>) -> Result<Self> {
        let cuts = scene.spheres.cuts.as_ref();
        let cuts = cuts.map(|cuts| CutSettler::new(scene, view, lists, cuts, f64::INFINITY)).transpose()?;
        Ok(Self { scene, view, lists, layers, cuts })
    }

    /// The ids of the next layers of some pixels, pixel after pixel: the translucent hits behind the first, in order up to the opaque one;
    /// [`NONE`] where there is none.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`].
    pub(crate) fn behind(&self, pixels: &[u32], watch: &Watch) -> Result<Vec<u32>> {
        let twin = Certify::<f32>::new(&self.view.record, self.lists);
        let each = self.layers.more as usize;
        let mut next = vec![NONE; each * pixels.len()];
        let doing = watch.begin(Step::Settle, pixels.len() as u64);
        parallel::fill(Rows { values: &mut next, each: each * PIXELS_PER_JOB }, 1, &|jobs, next| {
            let first = jobs.start * PIXELS_PER_JOB;
            let pixels = &pixels[first..pixels.len().min(first + PIXELS_PER_JOB * jobs.len())];
            if doing.next(pixels.len() as u64) {
                self.peel(&twin, pixels, next.values);
            }
        });
        doing.end()?;
        Ok(next)
    }

    /// Writes the next layers of some pixels.
    fn peel(&self, twin: &Certify<'_, f32>, pixels: &[u32], next: &mut [u32]) {
        let (mut all, mut ends) = (Vec::new(), vec![0]);
        for pixel in pixels {
            self.add_candidates(twin, *pixel as usize, &mut all);
            ends.push(all.len());
        }
        let nearest = Nearest { peeling: self, twin, few: OnceCell::new(), all: &all };
        let mut open = Vec::new();
        for ((pixel, next), ends) in pixels.iter().zip(next.chunks_mut(self.layers.more as usize)).zip(ends.windows(2))
        {
            open.clear();
            open.extend_from_slice(&all[ends[0]..ends[1]]);
            nearest.peel(*pixel as usize, &mut open, next);
        }
    }

    /// Whether the pixel may show this sphere behind its first.
    fn counts(&self, pixel: usize, id: u32) -> bool {
        self.layers.counts(&self.scene.spheres, pixel, id)
    }

    /// Adds the spheres that may be in the layers of a pixel behind the first, and its opaque one, by their lower bounds.
    fn add_candidates(&self, twin: &Certify<'_, f32>, pixel: usize, all: &mut Vec<Candidate>) {
        let [row, column] = twin.view.position(pixel as u32);
        let (slopes, first) = (twin.slopes(row, column), all.len());
        let found = twin.candidates(&slopes).map(|(low, slot)| Candidate { low, slot, id: twin.id(slot) });
        all.extend(found.filter(|one| self.counts(pixel, one.id)));
        all[first..].sort_unstable_by(|a, b| a.low.total_cmp(&b.low).then(a.id.cmp(&b.id)));
    }
}

/// The search for the nearest hits among the candidates of some pixels.
struct Nearest<'a> {
    peeling: &'a Peeling<'a>,
    twin: &'a Certify<'a, f32>,
    all: &'a [Candidate],
    /// The judge of all these candidates, made for the first pixel that needs exact arithmetic.
    few: OnceCell<Option<Few>>,
}

/// A judge of few spheres, with their ids in increasing order, so that the lower id stays the lower.
struct Few {
    judge: Judge,
    ids: Vec<u32>,
}

impl Nearest<'_> {
    /// Writes the next layers of one pixel: of its candidates each time the nearest.
    fn peel(&self, pixel: usize, open: &mut Vec<Candidate>, layers: &mut [u32]) {
        for layer in layers {
            let next = self.of(pixel, open).filter(|id| *id != self.peeling.layers.opaque[pixel]);
            let Some(next) = next else { return };
            *layer = next;
            open.retain(|one| one.id != next);
        }
    }

    /// The nearest hit among the candidates of a pixel; those that are found to be missed are removed.
    fn of(&self, pixel: usize, open: &mut Vec<Candidate>) -> Option<u32> {
        let [row, column] = self.twin.view.position(pixel as u32);
        let slopes = self.twin.slopes(row, column);
        while let Some(foremost) = open.first() {
            let answer = self.twin.answer(&slopes, foremost.slot);
            let second = open.get(1).map_or(f32::MAX, |one| one.low);
            // The answer is for a whole sphere.
            let is_cut = self.peeling.scene.spheres.is_cut(foremost.id);
            if !is_cut && self.twin.certain(&answer, [foremost.low, second]) {
                return Some(foremost.id);
            }
            let hits = answer.hits && !is_cut;
            let limit = if hits { answer.high + VANISH } else { second };
            let count = open.iter().take_while(|one| one.low <= limit).count().max(1);
            match self.judged([row, column], &open[..count]) {
                // A hit behind other lower bounds is not known to be the nearest.
                Some(_) if !hits && count < open.len() => return self.judged([row, column], open),
                Some(id) => return Some(id),
                None => drop(open.drain(..count)),
            }
        }
        None
    }

    /// The nearest hit of a ray among some spheres, in exact arithmetic; where planes cut spheres, by f64 where that decides it.
    fn judged(&self, [row, column]: [u32; 2], some: &[Candidate]) -> Option<u32> {
        let of_cuts = |cuts: &CutSettler<'_>| cuts.first_id([row, column], some.iter().map(|one| (one.low, one.id)));
        if let Some(known) = self.peeling.cuts.as_ref().and_then(of_cuts) {
            return known;
        }
        let Few { judge, ids } = self.few.get_or_init(|| self.few()).as_ref()?;
        let local = |one: &Candidate| ids.binary_search(&one.id).map_or(u32::MAX, |n| n as u32);
        let mut some: Vec<u32> = some.iter().map(local).collect();
        some.sort_unstable();
        some.dedup();
        judge.among(row, column, &some).map(|truth| ids[truth.id as usize])
    }

    fn few(&self) -> Option<Few> {
        let Peeling { scene, view, .. } = self.peeling;
        let mut ids: Vec<u32> = self.all.iter().map(|one| one.id).collect();
        ids.sort_unstable();
        ids.dedup();
        let mut spheres = Spheres::default();
        for id in &ids {
            spheres.push(scene.spheres.centers[*id as usize], scene.spheres.radii[*id as usize], None);
        }
        spheres.cuts = scene.spheres.cuts.as_ref().map(|cuts| cuts.chosen(&ids));
        // The view has this camera, and the scene these spheres, so that both are valid.
        let judge = view.judge(&Scene { spheres, ..scene.bare() }).ok()?;
        Some(Few { judge, ids })
    }
}
