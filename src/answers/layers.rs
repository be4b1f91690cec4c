//! Layers of translucent spheres: of each viewing ray the hits after the first, in their exact order, and their colours.

use crate::certify::Certify;
use crate::certify::binned::BinnedScene;
use crate::certify::constants::VANISH;
use crate::error::Result;
use crate::exact::Judge;
use crate::parallel;
use crate::progress::{Step, Watch};
use crate::scene::{DEFAULT_COLOR, Scene, Spheres};
use crate::shade::Shade;
use crate::view::View;
use crate::view::picture_rays::PictureRays;
use crate::view::ray::NONE;
use glam::DVec3;
use std::cell::OnceCell;
use std::ops::Range;

/// Pixels that one job peels.
const PIXELS_PER_JOB: usize = 256;

/// The search for the hits behind the first.
pub(crate) struct Peeling<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) view: &'a View,
    /// The spheres in lists from which none is left out; `None` where every pixel is decided exactly.
    pub(crate) lists: Option<&'a BinnedScene>,
    /// The opaque sphere that each pixel shows; [`NONE`] where there is none.
    pub(crate) opaque: &'a [u32],
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
    /// The ids of the next `more` layers: of each pixel, whose nearest translucent hit is `first`, the translucent hits in order up to
    /// the opaque one; [`NONE`] where there is none.
    ///
    /// # Errors
    /// Errors of [`View::judge`], and [`crate::Error::Interrupted`].
    pub(crate) fn behind(&self, first: &[u32], more: u32, watch: &Watch) -> Result<Vec<Vec<u32>>> {
        let twin = self.lists.map(|lists| Certify::<f32>::new(&self.view.record, lists));
        // Without lists one judge knows all spheres.
        let all = if twin.is_none() { Some(self.view.judge(self.scene)?) } else { None };
        let doing = watch.begin(Step::Settle, first.len() as u64);
        let job = |range: Range<usize>| -> Vec<Vec<u32>> {
            let mut layers = vec![vec![NONE; range.len()]; more as usize];
            if !doing.next(range.len() as u64) {
                return layers;
            }
            let pixels = range.clone().zip(&first[range]).enumerate().filter(|(_, (_, id))| **id != NONE);
            match (&twin, &all) {
                (Some(twin), _) => {
                    let candidates = |pixel, id| self.candidates(twin, pixel, id);
                    let lists: Vec<_> =
                        pixels.map(|(at, (pixel, id))| Listed { at, pixel, list: candidates(pixel, *id) }).collect();
                    let nearest = Nearest { peeling: self, twin, few: OnceCell::new(), lists: &lists };
                    lists.iter().for_each(|listed| nearest.peel(listed, &mut layers));
                }
                (None, Some(judge)) => {
                    pixels.for_each(|(at, (pixel, id))| self.peel_all(judge, pixel, *id, at, &mut layers))
                }
                (None, None) => {}
            }
            layers
        };
        let parts = parallel::blocks(0..first.len(), PIXELS_PER_JOB, &|range, _| job(range));
        doing.end()?;
        let layer = |k: usize| parts.iter().flat_map(|part| part[k].iter().copied()).collect();
        Ok((0..more as usize).map(layer).collect())
    }

    /// Whether a ray that shows this opaque sphere may show another before it.
    fn counts(&self, id: u32, first: u32, opaque: u32) -> bool {
        id != first && (id == opaque || self.scene.spheres.opacity(id) < 1.0)
    }

    /// The spheres beside `first` that may be in the layers of a pixel, and its opaque one, by their lower bounds.
    fn candidates(&self, twin: &Certify<'_, f32>, pixel: usize, first: u32) -> Vec<Candidate> {
        let [row, column] = twin.view.position(pixel as u32);
        let slopes = twin.slopes(row, column);
        let all = twin.candidates(&slopes).map(|(low, slot)| Candidate { low, slot, id: twin.id(slot) });
        let mut list: Vec<_> = all.filter(|one| self.counts(one.id, first, self.opaque[pixel])).collect();
        list.sort_unstable_by(|a, b| a.low.total_cmp(&b.low).then(a.id.cmp(&b.id)));
        list
    }

    /// Peels one pixel in exact arithmetic only.
    fn peel_all(&self, judge: &Judge, pixel: usize, first: u32, at: usize, layers: &mut [Vec<u32>]) {
        let (opaque, [row, column]) = (self.opaque[pixel], self.view.record.position(pixel as u32));
        let count = self.scene.spheres.len() as u32;
        let mut open: Vec<u32> = (0..count).filter(|id| self.counts(*id, first, opaque)).collect();
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
    list: Vec<Candidate>,
}

/// The search for the nearest hits among the candidates of some pixels.
struct Nearest<'a> {
    peeling: &'a Peeling<'a>,
    twin: &'a Certify<'a, f32>,
    lists: &'a [Listed],
    /// The judge of all these candidates, made for the first pixel that needs exact arithmetic.
    few: OnceCell<Option<Few>>,
}

/// A judge of few spheres, with their ids in increasing order, so that the lower id stays the lower.
struct Few {
    judge: Judge,
    ids: Vec<u32>,
}

impl Nearest<'_> {
    /// Writes the layers of one pixel: of its candidates each time the nearest.
    fn peel(&self, listed: &Listed, layers: &mut [Vec<u32>]) {
        let mut open = listed.list.clone();
        for layer in layers {
            let next = self.of(listed.pixel, &mut open).filter(|id| *id != self.peeling.opaque[listed.pixel]);
            let Some(next) = next else { return };
            layer[listed.at] = next;
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
        let mut ids: Vec<u32> = self.lists.iter().flat_map(|listed| &listed.list).map(|one| one.id).collect();
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

/// Colours of the hits of a view, without lights: linear RGB. A pixel without a hit is black.
///
/// # Errors
/// Errors of [`View::judge`].
pub(crate) fn shade(shade: Shade, scene: &Scene, view: &View, ids: &[u32]) -> Result<Vec<f32>> {
    let (rays, spheres, judge) = (PictureRays::new(view), &scene.spheres, view.judge(&scene.bare())?);
    let mut color = vec![0.0; 3 * ids.len()];
    parallel::each(color.as_chunks_mut().0, |pixel, rgb: &mut [f32; 3]| {
        let id = ids[pixel];
        if id == NONE {
            return;
        }
        let own = || spheres.colors.as_ref().map_or(DEFAULT_COLOR, |colors| colors[id as usize]);
        let ball = spheres.ball(id);
        let hit = rays.hit(pixel as u32, ball.center, ball.radius);
        let normal = || {
            let [row, column] = view.record.position(pixel as u32);
            let exact = || judge.hit_of(row, column, ball).map(|truth| DVec3::from_array(truth.normal));
            if hit.near { hit.normal } else { exact().unwrap_or(-hit.along) }
        };
        *rgb = match shade {
            Shade::Flat => own(),
            Shade::Normal => normal().to_array().map(|x| (0.5 * x + 0.5) as f32),
            Shade::Headlight => own().map(|x| (-normal().dot(hit.along)).max(0.0) as f32 * x),
        };
    });
    Ok(color)
}
