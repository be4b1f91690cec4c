//! Settling: pixels that f32 could not prove are decided again, in double-double with proven bounds and, where that is
//! not enough, exactly.

use crate::certify::Certify;
use crate::certify::binned::BinnedScene;
use crate::certify::constants::VANISH;
use crate::certify::cut::{CutHit, CutRay, SHARP};
use crate::double_double as dd;
use crate::exact::{Judge, Root, Truth};
use crate::number::vector::{LANES, vectorized};
use crate::scene::{Cuts, NumberedBall, Scene, Spheres};
use crate::shade::Shade;
use crate::view::picture_rays::PictureRays;
use crate::view::placement::Placement;
use crate::view::planes::EyePlanes;
use crate::view::ray::{NONE, UNSURE};
use crate::view::{View, ViewRecord};
use glam::DVec3;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::parallel::{self, CHEAP, Rows};

/// A pixel, or a given ray, that was settled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settled {
    /// Its index in the buffers: row times columns plus column, in the window; of a given ray its number.
    pub(crate) pixel: u32,
    /// The exact hit of its ray; `None` on a miss.
    pub(crate) truth: Option<Truth>,
}

/// Pixels that are compared together; most are sure.
const COMPARED: usize = 64;

/// The pixels that a certified kernel marked unsure.
pub(crate) fn unsure(ids: &[u32]) -> Vec<u32> {
    parallel::collect(ids.len(), CHEAP, &|range, out| {
        for (first, ids) in range.clone().step_by(COMPARED).zip(ids[range].chunks(COMPARED)) {
            // All ids are compared, without a branch, so that compilers make vectors of them.
            if ids.iter().fold(false, |has, id| has | (*id == UNSURE)) {
                out.extend((first as u32..).zip(ids).filter(|(_, id)| **id == UNSURE).map(|(pixel, _)| pixel));
            }
        }
    })
}

/// The most candidates reserved at once: 64 MiB, and as much again for each pixel's own lists.
const AT_ONCE: usize = 1 << 24;

/// Decides every unsure pixel among the spheres that may be its nearest hit, by their lower bounds of depth. The CPU
/// twin computes these bounds anew; they hold as the kernel's do, whichever way either rounds. Where planes cut spheres, f64 decides and
/// answers pixels whose t it knows to `sharp` of itself, which is infinite where ids alone count. `go_on` is called before
/// every pixel; if it returns false, the result is incomplete and must be discarded.
pub(crate) fn settle(
    scene: &Scene,
    view: &View,
    binned: &BinnedScene,
    (unsure, sharp): (&[u32], f64),
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Settled>> {
    let cuts = scene.spheres.cuts.as_ref();
    let cuts = cuts.map(|cuts| CutSettler::new(scene, view, binned, cuts, sharp)).transpose()?;
    let settler = Settler { scene, view, twin: Certify::new(&view.record, binned), cuts, go_on };
    let mut settled = Vec::with_capacity(unsure.len());
    let most: Vec<usize> = parallel::map(unsure, |pixel| settler.most(*pixel));
    let mut left = unsure;
    while !left.is_empty() {
        let mut reserved = 0;
        let fits = |most: &&usize| {
            reserved += **most;
            reserved <= AT_ONCE
        };
        let count = most[settled.len()..].iter().take_while(fits).count().max(1);
        let (now, later) = left.split_at(count);
        settled.extend(settler.decide(now)?);
        left = later;
    }
    Ok(settled)
}

/// Decides unsure pixels.
struct Settler<'a> {
    scene: &'a Scene,
    view: &'a View,
    twin: Certify<'a, f32>,
    /// The decisions in f64, in a scene whose spheres planes cut.
    cuts: Option<CutSettler<'a>>,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

impl Settler<'_> {
    /// The most candidates that a pixel may have.
    fn most(&self, pixel: u32) -> usize {
        let [row, column] = self.twin.view.place(pixel);
        let [first, end] = self.twin.lists.range(row, column);
        (end - first) as usize + self.twin.general_lists.of(row, column).len()
    }

    /// The spheres that may be the nearest hit of each pixel, in the scene's order.
    fn candidates(&self, pixels: &[u32]) -> Lists {
        let (mut lists, mut all) = (Lists::default(), Vec::new());
        let twin = &self.twin;
        for pixel in pixels {
            if !(self.go_on)() {
                lists.add(std::iter::empty());
                continue;
            }
            let [row, column] = twin.view.position(*pixel);
            let slopes = twin.slopes(row, column);
            all.clear();
            all.extend(twin.candidates(&slopes));
            // An upper bound of the depth of the nearest hit. A cut sphere bounds nothing.
            let whole = all.iter().filter(|(_, slot)| !self.scene.spheres.is_cut(twin.id(*slot)));
            let foremost = whole.min_by(|a, b| a.0.total_cmp(&b.0));
            let answer = foremost.map(|(_, slot)| twin.answer(&slopes, *slot)).filter(|answer| answer.hits);
            let limit = answer.map_or(f32::MAX, |answer| answer.high + VANISH);
            lists.add(all.iter().filter(|(low, _)| *low <= limit).map(|(_, slot)| twin.id(*slot)));
        }
        lists
    }

    /// Decides pixels: where planes cut spheres by f64 with bounds, and by the judge those that it leaves.
    fn decide(&self, pixels: &[u32]) -> Result<Vec<Settled>> {
        let Some(cuts) = &self.cuts else { return self.judged(pixels) };
        let place = |pixel: u32| self.twin.view.position(pixel);
        let twin = &self.twin;
        let found: Vec<Option<Settled>> = parallel::collect(pixels.len(), PIXELS_PER_JOB, &|range, out| {
            let mut some = Vec::new();
            out.extend(pixels[range].iter().map(|&pixel| {
                let at = place(pixel);
                some.clear();
                if (self.go_on)() {
                    some.extend(twin.candidates(&twin.slopes(at[0], at[1])).map(|(low, slot)| (low, twin.id(slot))));
                }
                some.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
                cuts.first(at, &some).map(|truth| Settled { pixel, truth })
            }));
        });
        let left: Vec<u32> = pixels.iter().zip(&found).filter(|(_, found)| found.is_none()).map(|(n, _)| *n).collect();
        let mut judged = self.judged(&left)?.into_iter().map(|settled| Settled {
            truth: settled.truth.map(|truth| cuts.sharpened(place(settled.pixel), truth)),
            ..settled
        });
        Ok(found.into_iter().filter_map(|found| found.or_else(|| judged.next())).collect())
    }

    fn judged(&self, pixels: &[u32]) -> Result<Vec<Settled>> {
        let scene = self.scene;
        let mut lists: Vec<Lists> =
            parallel::blocks(0..pixels.len(), PIXELS_PER_JOB, &|range, _| self.candidates(&pixels[range]));
        // Only the candidates are set up, in their order, so that the lower id stays the lower.
        let mut ids: Vec<u32> = parallel::collect(lists.len(), 1, &|range, out| {
            lists[range].iter().for_each(|list| out.extend(list.different()))
        });
        parallel::sort(&mut ids, u32::cmp);
        ids.dedup();
        let mut spheres = Spheres::default();
        for &id in &ids {
            spheres.push(scene.spheres.centers[id as usize], scene.spheres.radii[id as usize], None);
        }
        spheres.cuts = scene.spheres.cuts.as_ref().map(|cuts| cuts.chosen(&ids));
        let few = Scene { spheres, ..scene.bare() };
        let (judge, view) = (&self.view.judge(&few)?, self.twin.view);
        let is_long =
            lists.iter().any(|lists| (0..lists.ends.len()).any(|n| lists.of(n).len() > EQUAL_SEARCH_MIN_CANDIDATES));
        // Equal spheres may be cut and whole.
        let firsts = if is_long && few.spheres.cuts.is_none() { firsts(&few.spheres) } else { None };
        let local = |id: &u32| ids.binary_search(id).map_or(u32::MAX, |k| k as u32);
        let mut settled: Vec<Settled> = pixels.iter().map(|&pixel| Settled { pixel, truth: None }).collect();
        let decide = |settled: &mut [Settled], lists: &mut Lists| {
            lists.ids.iter_mut().for_each(|id| *id = local(id));
            firsts.iter().for_each(|firsts| lists.keep(firsts));
            let (lists, some) = (&*lists, &mut *settled);
            vectorized!(decide_lists(judge, view, lists, some));
            for truth in settled.iter_mut().filter_map(|settled| settled.truth.as_mut()) {
                truth.id = ids[truth.id as usize];
            }
        };
        let jobs = (Rows { values: &mut settled, each: PIXELS_PER_JOB }, &mut lists[..]);
        parallel::fill(jobs, 1, &|_, (settled, lists)| decide(settled.values, &mut lists[0]));
        Ok(settled)
    }
}

/// Decides pixels in f64 where planes cut spheres.
pub(super) struct CutSettler<'a> {
    scene: &'a Scene,
    view: &'a View,
    cuts: &'a Cuts,
    planes: EyePlanes,
    placement: Placement,
    /// The judge of the planes alone.
    judge: Judge,
    /// The largest relative error of a t that f64 answers with; infinite where ids alone count.
    sharp: f64,
    /// The depth from which lower bounds of depths count, in the frame's unit.
    reference: f64,
}

impl<'a> CutSettler<'a> {
    /// # Errors
    /// Errors of the judge.
    pub(super) fn new(
        scene: &'a Scene,
        view: &'a View,
        binned: &BinnedScene,
        cuts: &'a Cuts,
        sharp: f64,
    ) -> Result<Self> {
        let Spheres { centers, radii, .. } = &scene.spheres;
        let (planes, placement) = (EyePlanes::new(cuts, view.basis.e), Placement::new(centers, radii));
        let (judge, reference) = (view.judge(&scene.bare())?, binned.projection.depth.into());
        Ok(Self { scene, view, cuts, planes, placement, judge, sharp, reference })
    }

    fn ray(&self, at: [u32; 2]) -> Option<CutRay> {
        let is_along = |plane| self.judge.is_along(at, plane);
        CutRay::of_pixel(&self.planes, self.view, &self.placement, (at, &is_along))
    }

    fn ball(&self, id: u32) -> NumberedBall {
        NumberedBall { id, ball: self.scene.spheres.ball(id) }
    }

    /// The first hit among some spheres; `None` where f64 does not decide it, or not sharply enough.
    fn first(&self, at: [u32; 2], some: &[(f32, u32)]) -> Option<Option<Truth>> {
        let ray = self.ray(at)?;
        match self.first_of(&ray, at, some.iter().copied())? {
            None => Some(None),
            Some(hit) => ray.truth((&self.planes, self.sharp), self.view, at, hit).map(Some),
        }
    }

    /// The sphere that is hit first among some; `None` where f64 does not decide it.
    pub(super) fn first_id(&self, at: [u32; 2], some: impl Iterator<Item = (f32, u32)>) -> Option<Option<u32>> {
        let ray = self.ray(at)?;
        self.first_of(&ray, at, some).map(|hit| hit.map(|(ball, _)| ball.id))
    }

    /// The first hit among some spheres, by lower bounds of their depths in f32.
    fn first_of(
        &self,
        ray: &CutRay,
        at: [u32; 2],
        some: impl Iterator<Item = (f32, u32)>,
    ) -> Option<Option<(NumberedBall, CutHit)>> {
        // The few roundings of a product are far below the last factor.
        let factor = dd::ldexp(ray.of_depth(self.view, at), self.view.unit) * (1.0 - SHARP);
        let least_t = |low: f32| ((self.reference + f64::from(low)) * factor).max(0.0);
        ray.first(some.map(|(low, id)| (least_t(low), self.ball(id), self.cuts.is_cut(id))))
    }

    /// The numbers of f64 in place of the judge's numbers, where they are sharp enough: so they do not depend on the spheres that a pixel
    /// was decided among.
    fn sharpened(&self, at: [u32; 2], truth: Truth) -> Truth {
        let own = || {
            let (ray, ball) = (self.ray(at)?, self.ball(truth.id));
            let hit = ray.hit(ball, self.cuts.is_cut(truth.id)).filter(|hit| hit.root == truth.root)?;
            ray.truth((&self.planes, self.sharp), self.view, at, (ball, hit))
        };
        own().unwrap_or(truth)
    }
}

/// The candidates of some pixels, one list after the other.
#[derive(Debug, Default)]
struct Lists {
    ids: Vec<u32>,
    ends: Vec<usize>,
}

impl Lists {
    /// Adds the candidates of the next pixel.
    fn add(&mut self, candidates: impl Iterator<Item = u32>) {
        let first = self.ids.len();
        self.ids.extend(candidates);
        self.ids[first..].sort_unstable();
        self.ends.push(self.ids.len());
    }

    /// The candidates of a pixel.
    fn of(&self, n: usize) -> &[u32] {
        &self.ids[n.checked_sub(1).map_or(0, |n| self.ends[n])..self.ends[n]]
    }

    /// Replaces every candidate by the first sphere that is equal to it, and removes duplicates.
    fn keep(&mut self, firsts: &[u32]) {
        let (mut kept, mut own) = (Self::default(), Vec::new());
        for n in 0..self.ends.len() {
            own.clear();
            own.extend(self.of(n).iter().map(|id| firsts[*id as usize]));
            own.sort_unstable();
            own.dedup();
            kept.ids.extend(&own);
            kept.ends.push(kept.ids.len());
        }
        *self = kept;
    }

    /// All candidates, each once.
    fn different(&self) -> Vec<u32> {
        let mut ids = self.ids.clone();
        ids.sort_unstable();
        ids.dedup();
        ids
    }
}

/// Candidates of a pixel from which on it is worth while to look for equal spheres.
const EQUAL_SEARCH_MIN_CANDIDATES: usize = 64;

/// For each sphere, the index of the first sphere with the same centre and radius: of equal spheres the first is hit.
/// `None` where all differ.
fn firsts(spheres: &Spheres) -> Option<Vec<u32>> {
    // -0.0 + 0.0 is 0.0.
    let key = |n: &u32| {
        let ([x, y, z], r) = (spheres.centers[*n as usize], spheres.radii[*n as usize]);
        [x, y, z, r].map(|x| (x + 0.0).to_bits())
    };
    let mut order: Vec<u32> = (0..spheres.len() as u32).collect();
    parallel::sort(&mut order, |a, b| (key(a), a).cmp(&(key(b), b)));
    let mut firsts: Vec<u32> = (0..spheres.len() as u32).collect();
    let mut has_equal = false;
    for equal in order.chunk_by(|a, b| key(a) == key(b)) {
        has_equal |= equal.len() > 1;
        equal.iter().for_each(|n| firsts[*n as usize] = equal[0]);
    }
    has_equal.then_some(firsts)
}

/// Pixels that one job decides.
const PIXELS_PER_JOB: usize = 256;

/// Rays of one sphere that are decided together; fewer take less time one by one.
const BATCH_MIN_RAYS: usize = 3;

/// Decides some pixels among the candidates of each, compiled for processors with vectors and a fused multiply-add, which would be
/// a function call elsewhere.
#[inline(always)]
fn decide_lists(judge: &Judge, view: &ViewRecord, lists: &Lists, settled: &mut [Settled]) {
    let count = |n: &usize| lists.of(*n).len();
    let mut alone: Vec<usize> = (0..settled.len()).filter(|n| count(n) == 1).collect();
    alone.sort_by_key(|n| lists.of(*n)[0]);
    let mut left: Vec<usize> = (0..settled.len()).filter(|n| count(n) > 1).collect();
    for same in alone.chunk_by(|a, b| lists.of(*a) == lists.of(*b)) {
        for some in same.chunks(LANES) {
            if some.len() < BATCH_MIN_RAYS {
                left.extend(some);
                continue;
            }
            let mut places = [[0; 2]; LANES];
            for (l, place) in places.iter_mut().enumerate() {
                *place = view.position(settled[some[l.min(some.len() - 1)]].pixel);
            }
            for (n, truth) in some.iter().zip(judge.surely_hit(&places, lists.of(some[0])[0])) {
                settled[*n].truth = truth;
                if truth.is_none() {
                    left.push(*n);
                }
            }
        }
    }
    for n in left {
        let [row, column] = view.position(settled[n].pixel);
        settled[n].truth = judge.among(row, column, lists.of(n));
    }
}

/// Decides every pixel of the window among all spheres, in exact arithmetic only. `go_on` is called before every row.
pub(crate) fn exact(scene: &Scene, view: &View, go_on: &(dyn Fn() -> bool + Sync)) -> Result<Vec<Settled>> {
    let record = &view.record;
    let judge = view.judge(scene)?;
    let row = |i: usize| {
        let first = i as u32 * record.columns;
        let pixels = if go_on() { first..first + record.columns } else { 0..0 };
        let decide = |pixel: u32| {
            let [row, column] = record.position(pixel);
            Settled { pixel, truth: judge.pixel(row, column) }
        };
        pixels.map(decide)
    };
    Ok(parallel::collect(record.rows as usize, 1, &|rows, out| out.extend(rows.flat_map(row))))
}

/// Colours the settled pixels from their exact normals.
pub(crate) fn shade(shade: Shade, scene: &Scene, view: &View, settled: &[Settled], color: &mut [f32]) {
    for s in settled {
        let rgb = match &s.truth {
            None => scene.image.background,
            Some(truth) => {
                let [row, column] = view.record.position(s.pixel);
                let along = view.to_world(view.direction(row, column));
                let own = scene.spheres.color(truth.id, truth.root == Root::Face);
                let normal = DVec3::from_array(truth.normal);
                shade.in_world(normal, -normal.dot(along) / along.length(), own)
            }
        };
        color[3 * s.pixel as usize..][..3].copy_from_slice(&rgb);
    }
}

/// Colours of the hits of a view, without lights: linear RGB. A pixel without a hit is black.
///
/// # Errors
/// Errors of [`View::judge`], and [`crate::Error::Limits`] where memory is short.
pub(crate) fn shade_all(shade: Shade, scene: &Scene, view: &View, ids: &[u32], pool: &Pool) -> Result<Vec<f32>> {
    let (rays, spheres, judge) =
        (PictureRays::new(view, scene.spheres.cuts.as_ref()), &scene.spheres, view.judge(&scene.bare())?);
    let mut color = pool.values(3 * ids.len())?;
    parallel::each(color.as_chunks_mut().0, |pixel, rgb: &mut [f32; 3]| {
        let id = ids[pixel];
        if id == NONE {
            *rgb = [0.0; 3];
            return;
        }
        let ball = spheres.ball(id);
        let hit = rays.hit(pixel as u32, ball, spheres.is_cut(id));
        let own = spheres.color(id, hit.face);
        let exact = || {
            let [row, column] = view.record.position(pixel as u32);
            judge.hit_of(row, column, spheres.solid(id)).map(|truth| DVec3::from_array(truth.normal))
        };
        // A flat colour needs no normal.
        let is_known = hit.near || shade == Shade::Flat;
        let normal = if is_known { hit.normal } else { exact().unwrap_or(-hit.along) };
        *rgb = shade.in_world(normal, -normal.dot(hit.along), own);
    });
    Ok(color)
}
