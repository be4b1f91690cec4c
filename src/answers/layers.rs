//! Layers of translucent spheres: of each viewing ray the hits after the first, in their exact order, and their colours.

use crate::certify::Certify;
use crate::certify::binned::BinnedScene;
use crate::certify::constants::VANISH;
use crate::error::Result;
use crate::exact::Judge;
use crate::parallel;
use crate::progress::{Step, Watch};
use crate::scene::{Scene, Spheres};
use crate::view::View;
use crate::view::ray::NONE;
use std::cell::OnceCell;
use std::ops::Range;

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

/// Writes the layers of a range of pixels.
pub(crate) type Peel<'a> = &'a (dyn Fn(Range<usize>, &mut [Vec<u32>]) + Sync);

impl Layers<'_> {
    /// Whether a pixel may show this sphere behind the first, or as its opaque one.
    pub(crate) fn counts(&self, spheres: &Spheres, pixel: usize, id: u32) -> bool {
        id != self.first[pixel] && (id == self.opaque[pixel] || spheres.opacity(id) < 1.0)
    }

    /// The layers: `job` writes those of a range of pixels, each of which is [`NONE`] before.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`].
    pub(crate) fn peel(&self, watch: &Watch, job: Peel<'_>) -> Result<Vec<Vec<u32>>> {
        let doing = watch.begin(Step::Settle, self.first.len() as u64);
        let part = |range: Range<usize>| {
            let mut layers = vec![vec![NONE; range.len()]; self.more as usize];
            if doing.next(range.len() as u64) {
                job(range, &mut layers);
            }
            layers
        };
        let parts = parallel::blocks(0..self.first.len(), PIXELS_PER_JOB, &|range, _| part(range));
        doing.end()?;
        let layer = |k: usize| parts.iter().flat_map(|part| part[k].iter().copied()).collect();
        Ok((0..self.more as usize).map(layer).collect())
    }
}

/// The search for the hits behind the first among spheres in lists.
pub(crate) struct Peeling<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) view: &'a View,
    /// The spheres in lists from which none that a ray may show is left out; `None` where every pixel is decided exactly.
    pub(crate) lists: Option<&'a BinnedScene>,
    pub(crate) layers: Layers<'a>,
}

/// A sphere that a ray may hit.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// A lower bound of the hit's depth.
    low: f32,
    slot: u32,
    id: u32,
}

impl Peeling<'_> {
    /// The ids of the next layers: of each pixel the translucent hits behind the first, in order up to the opaque one; [`NONE`] where
    /// there is none.
    ///
    /// # Errors
    /// Errors of [`View::judge`], and [`crate::Error::Interrupted`].
    pub(crate) fn behind(&self, watch: &Watch) -> Result<Vec<Vec<u32>>> {
        let twin = self.lists.map(|lists| Certify::<f32>::new(&self.view.record, lists));
        // Without lists one judge knows all spheres.
        let all = if twin.is_none() { Some(self.view.judge(self.scene)?) } else { None };
        self.layers.peel(watch, &|range, layers| {
            let first = self.layers.first;
            let pixels = range.enumerate().filter(|(_, pixel)| first[*pixel] != NONE);
            match (&twin, &all) {
                (Some(twin), _) => {
                    let (mut all, mut lists) = (Vec::new(), Vec::new());
                    for (at, pixel) in pixels {
                        let first = all.len();
                        self.add_candidates(twin, pixel, &mut all);
                        lists.push(Listed { at, pixel, list: first..all.len() });
                    }
                    let nearest = Nearest { peeling: self, twin, few: OnceCell::new(), all: &all };
                    let mut open = Vec::new();
                    for Listed { at, pixel, list } in lists {
                        open.clear();
                        open.extend_from_slice(&all[list]);
                        nearest.peel(at, pixel, &mut open, layers);
                    }
                }
                (None, Some(judge)) => pixels.for_each(|(at, pixel)| self.peel_all(judge, pixel, at, layers)),
                (None, None) => {}
            }
        })
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

    /// Peels one pixel in exact arithmetic only.
    fn peel_all(&self, judge: &Judge, pixel: usize, at: usize, layers: &mut [Vec<u32>]) {
        let (opaque, [row, column]) = (self.layers.opaque[pixel], self.view.record.position(pixel as u32));
        let count = self.scene.spheres.len() as u32;
        let mut open: Vec<u32> = (0..count).filter(|id| self.counts(pixel, *id)).collect();
        for layer in layers {
            let Some(next) = judge.among(row, column, &open).map(|truth| truth.id).filter(|id| *id != opaque) else {
                return;
            };
            layer[at] = next;
            open.retain(|id| *id != next);
        }
    }
}

/// The candidates of a pixel, the pixel `at` of its job.
struct Listed {
    at: usize,
    pixel: usize,
    list: Range<usize>,
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
    /// Writes the layers of one pixel, the pixel `at` of its job: of its candidates each time the nearest.
    fn peel(&self, at: usize, pixel: usize, open: &mut Vec<Candidate>, layers: &mut [Vec<u32>]) {
        for layer in layers {
            let next = self.of(pixel, open).filter(|id| *id != self.peeling.layers.opaque[pixel]);
            let Some(next) = next else { return };
            layer[at] = next;
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
            if self.twin.certain(&answer, [foremost.low, second]) {
                return Some(foremost.id);
            }
            let limit = if answer.hits { answer.high + VANISH } else { second };
            let count = open.iter().take_while(|one| one.low <= limit).count().max(1);
            match self.judged([row, column], &open[..count]) {
                // A hit behind other lower bounds is not known to be the nearest.
                Some(_) if !answer.hits && count < open.len() => return self.judged([row, column], open),
                Some(id) => return Some(id),
                None => drop(open.drain(..count)),
            }
        }
        None
    }

    /// The nearest hit of a ray among some spheres, in exact arithmetic.
    fn judged(&self, [row, column]: [u32; 2], some: &[Candidate]) -> Option<u32> {
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
        // The view has this camera, and the scene these spheres, so that both are valid.
        let judge = view.judge(&Scene { spheres, ..scene.bare() }).ok()?;
        Some(Few { judge, ids })
    }
}
