//! Rays toward the sky from the hits of a view, all of one direction at once.

use super::lighting::LightingContext;
use crate::answers::light::Traced;
use crate::certify::given::EPS;
use crate::number::vector::LANES;
use crate::scene::{Light, LightSource};
use crate::search::tree::Tree;
use crate::search::tree::bounding::SIXTEEN;
use crate::search::tree::sixteen::{Sixteen, Work16, dispatch};
use crate::search::tree::streams::{Blockers, Chosen, ERROR, Ends, Hidden, MOST_RAYS, NO_END, Starts, Stream};
use crate::view::RayKind;
use crate::view::directions::PixelSample;
use crate::view::picture_rays::{PictureHits, ShownBalls};
use crate::view::placement::Placement;
use crate::view::planes::EyePlane;
use crate::view::ray::NONE;
use glam::DVec3;
use halfline_ground::parallel;
use std::iter::repeat_with;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Pixels whose directions are looked up by one job.
const PIXELS_PER_JOB: usize = 1 << 16;

/// Pixels with the same directions from which on their rays go down together: fewer take longer than one by one.
const LEAST_PIXELS: usize = 1 << 9;

/// The cosine below which the side of a ray is not known: normals are off by 2^-29, and their product with a direction is rounded.
/// Section 10a of docs/certificate.md.
const GRAZING: f32 = 1.0 / (1u32 << 20) as f32;

/// The length of a margin around spheres in which a point may be inside of them, in the tree's unit.
/// Section 10a of docs/certificate.md.
const NEAR: f64 = 1.0 / (1u64 << 18) as f64;

impl LightingContext<'_> {
    /// The numbers of rays toward the sky and toward lights from the hits of all pixels, which show these spheres, and their words as
    /// [`Traced`] has them; `None` where rays have no common directions, or their starts may lie inside of spheres. A pixel has its last bit
    /// set where a ray is undecided: [`ERROR`] leaves it to f64.
    pub(crate) fn stream(&self, ids: &[u32], go_on: &(dyn Fn() -> bool + Sync)) -> Option<(Traced<'static>, Vec<u32>)> {
        let reaches_all = self.sky.is_some_and(|sky| sky.reach == f64::INFINITY);
        let rays = if reaches_all && self.open.is_none() { self.directions.len() } else { 0 };
        let turns = if rays > 0 { self.directions.turns() } else { 1 };
        let suns = self.suns();
        let count = Traced { words: &[], rays, lights: suns.len() };
        let is_worth = rays + suns.len() > 0 && ids.len() >= LEAST_PIXELS * turns;
        // Of a method it is not proved that hits are the first ones.
        let is_certified = self.judge.is_some() && !self.exact;
        if !is_worth || !is_certified || !self.from_first || !self.is_outside() {
            return None;
        }
        let words: Vec<AtomicU32> = repeat_with(AtomicU32::default).take(count.words_of_pixel() * ids.len()).collect();
        let by_turn = self.by_turn(ids, turns);
        let trace = |turn: usize, pixels: &[u32]| {
            if go_on() {
                let sky = if rays > 0 { self.directions.of_turn(turn) } else { &[] };
                let toward = sky.iter().map(|direction| direction.map(f64::from)).chain(suns.iter().copied()).collect();
                dispatch(Batch { lighting: self, ids, count, toward, pixels, words: &words });
            }
        };
        let batches: Vec<(usize, Vec<u32>)> = parallel::collect(turns, 1, &|turns, batches| {
            for turn in turns {
                let pixels: Vec<u32> = by_turn.iter().flat_map(|block| block[turn].iter().copied()).collect();
                batches.extend(pixels.chunks(MOST_RAYS).map(|pixels| (turn, pixels.to_vec())));
            }
        });
        parallel::fill(0..batches.len(), 1, &|range, _| {
            batches[range].iter().for_each(|(turn, pixels)| trace(*turn, pixels));
        });
        Some((count, words.into_iter().map(AtomicU32::into_inner).collect()))
    }

    /// The directions to the lights if their shadows are requested and every light is infinitely far; otherwise empty.
    fn suns(&self) -> Vec<[f64; 3]> {
        let lighting = &self.scene.lighting;
        let direction = |light: &Light| match light.source {
            LightSource::Direction(direction) => Some(direction.to_array()),
            _ => None,
        };
        let all = self
            .outputs
            .casts_shadows(lighting)
            .then(|| lighting.lights.iter().map(direction).collect::<Option<Vec<_>>>());
        all.flatten().unwrap_or_default()
    }

    /// The pixels that show a sphere, by the turn of their directions, of some jobs.
    fn by_turn(&self, ids: &[u32], turns: usize) -> Vec<Vec<Vec<u32>>> {
        let record = &self.view.record;
        parallel::blocks(0..ids.len(), PIXELS_PER_JOB, &|pixels, _: Range<usize>| {
            let mut by_turn = vec![Vec::new(); turns];
            let places = record.places(pixels.start as u32);
            for (pixel, [row, column]) in pixels.zip(places).filter(|(pixel, _)| ids[*pixel] != NONE) {
                let at = PixelSample { row, column, sample: record.sample, seed: self.seed };
                let turn = if turns > 1 { self.directions.turn(at, 0) } else { 0 };
                by_turn[turn].push(pixel as u32);
            }
            by_turn
        })
    }

    /// Whether all viewing rays start outside of the spheres that block rays. What they hit first from there is outside too.
    fn is_outside(&self) -> bool {
        let spared = self.cuts.as_ref().and_then(|cuts| cuts.spared);
        [Some(self.blockers), spared].into_iter().flatten().all(|tree| self.is_outside_of(tree))
    }

    fn is_outside_of(&self, tree: &Tree) -> bool {
        let basis = &self.view.basis;
        let eye = tree.placement.point(basis.e.to_array());
        let far = eye.iter().fold(1.0, |far: f64, x| far.max(x.abs()));
        // Beyond the scene nothing is inside; nearer, f64 knows the place to far less than the margin.
        let is_beyond = far > 4.0;
        let away = |center: [f32; 3]| DVec3::from_array(std::array::from_fn(|k| f64::from(center[k]) - eye[k]));
        let (parallel, axis, margin) = (self.view.kind() == RayKind::Parallel, basis.w, NEAR * far);
        let may_contain = |center: [f32; 3], radius: f32| {
            let away = away(center);
            let distance = if parallel { away.dot(axis).abs() } else { away.length() };
            distance.is_nan() || distance <= f64::from(radius) + margin
        };
        (is_beyond && !parallel) || !tree.bounding().any(&tree.blocks, &may_contain)
    }
}

/// Pixels whose rays have the same directions.
struct Batch<'a> {
    lighting: &'a LightingContext<'a>,
    ids: &'a [u32],
    count: Traced<'static>,
    /// The directions toward the sky, then to the lights.
    toward: Vec<[f64; 3]>,
    pixels: &'a [u32],
    words: &'a [AtomicU32],
}

/// The hits of some pixels.
#[derive(Default)]
struct Hits {
    pixels: Vec<u32>,
    starts: Starts,
    normals: [Vec<f32>; 3],
    /// A bit for each that is on a plane which cuts its sphere, sixteen to a word; empty in a scene without cuts.
    faces: Vec<u32>,
    planes: Vec<PlaneGaps>,
}

/// A plane that cuts spheres, with its distance from each start in the tree's unit and in lengths of its normal.
struct PlaneGaps {
    normal: DVec3,
    gaps: Vec<f64>,
    /// Bound of the error of the distances.
    error: f64,
}

impl Work16 for Batch<'_> {
    type Output = ();

    #[inline(always)]
    fn work<S: Sixteen>(self, s: S) {
        let Self { lighting, ref toward, count, words, .. } = self;
        let tree: &Tree = lighting.blockers;
        let blockers = |tree| Blockers { tree, error: ERROR };
        let spared = lighting.cuts.as_ref().and_then(|cuts| cuts.spared);
        let (undecided, each) = (count.rays + count.lights, count.words_of_pixel());
        let of_left = |pixel: u32| words[pixel as usize * each + undecided / 32].store(1 << (undecided % 32), Relaxed);
        let hits = self.hits(&of_left);
        let mut own = vec![0u32; each * hits.pixels.len()];
        let mut set = |n: usize, ray: usize| own[n * each + ray / 32] |= 1 << (ray % 32);
        let mut stream = Stream::default();
        let (mut sides, mut ends) = ([Vec::new(), Vec::new()], Ends::default());
        let ids = &hits.starts.ids[..];
        for (ray, direction) in toward.iter().enumerate() {
            hits.sides(s, *direction, &mut sides, |n| set(n, undecided));
            stream.begin(*direction, &hits.starts);
            // A direction toward the sky is meant up to its sign; the sphere of a point hides a light behind it.
            for (backward, chosen) in
                [false, true].into_iter().zip(&mut sides).take(if ray < count.rays { 2 } else { 1 })
            {
                // A face looks into what its plane removes.
                hits.faces(chosen, |n| set(n, ray));
                let sign = if backward { -1.0 } else { 1.0 };
                let ends = hits.ends(direction.map(|x| sign * x), &mut ends);
                stream.trace(s, blockers(tree), backward, Chosen { chosen, ids, ends });
                let Some(spared) = spared else {
                    for (n, answer) in stream.answers() {
                        match answer {
                            Hidden::No => set(n, ray),
                            Hidden::Unsure => set(n, undecided),
                            Hidden::Yes => {}
                        }
                    }
                    continue;
                };
                let rest: Vec<(usize, Hidden)> = stream.answers().collect();
                stream.trace(s, blockers(spared), backward, Chosen { chosen, ids, ends: None });
                for ((n, of_rest), (_, of_spared)) in rest.into_iter().zip(stream.answers()) {
                    match (of_rest, of_spared) {
                        (Hidden::No, Hidden::No) => set(n, ray),
                        (Hidden::Yes, _) | (_, Hidden::Yes) => {}
                        _ => set(n, undecided),
                    }
                }
            }
        }
        for (pixel, own) in hits.pixels.iter().zip(own.chunks(each)) {
            let words = &words[*pixel as usize * each..][..each];
            words.iter().zip(own).for_each(|(word, own)| word.store(*own, Relaxed));
        }
    }
}

/// Bound of the error of a start, as a length in the tree's unit: a normal off by 2^-29 and a radius of at most 1.
/// Section 9a of docs/certificate.md.
const START: f64 = 1.0 / (1u64 << 28) as f64;

/// Bound of the error of the product of a plane's normal and a direction of length 1 in f64, over the length of the normal.
/// Section 9a of docs/certificate.md.
const ACROSS: f64 = 1.0 / (1u64 << 48) as f64;

impl Hits {
    /// Takes the faces out of some hits, whose rays leave on the side of the normal, and calls `each` for them.
    fn faces(&self, chosen: &mut [u32], mut each: impl FnMut(usize)) {
        for (n, (chosen, faces)) in chosen.iter_mut().zip(&self.faces).enumerate() {
            let mut found = *chosen & faces;
            *chosen &= !faces;
            while found != 0 {
                each(n * SIXTEEN + found.trailing_zeros() as usize);
                found &= found - 1;
            }
        }
    }

    /// The lengths at which rays in a direction leave what planes keep; `None` in a scene without cuts.
    fn ends<'e>(&self, direction: [f64; 3], ends: &'e mut Ends) -> Option<&'e Ends> {
        if self.planes.is_empty() {
            return None;
        }
        let along = DVec3::from_array(direction).normalize();
        for ends in [&mut ends.low, &mut ends.high] {
            ends.clear();
            ends.resize(self.starts.ids.len(), NO_END);
        }
        for PlaneGaps { normal, gaps, error } in &self.planes {
            let (den, doubt) = (normal.dot(along), ACROSS * normal.length());
            if den <= -doubt {
                continue;
            }
            for ((low, high), gap) in ends.low.iter_mut().zip(&mut ends.high).zip(gaps) {
                // One step of f32 on either side for the roundings.
                *low = low.min((((gap - error) / (den + doubt)) as f32).next_down().max(0.0));
                let last = if den > doubt { (((gap + error) / (den - doubt)) as f32).next_up() } else { NO_END };
                *high = high.min(last.max(0.0));
            }
        }
        Some(ends)
    }

    /// Writes the hits whose normals are on the side of a direction, and those on the other, a bit each, sixteen to a word. Those for which
    /// that is not known are `undecided` besides.
    #[inline(always)]
    fn sides<S: Sixteen>(
        &self,
        s: S,
        direction: [f64; 3],
        sides: &mut [Vec<u32>; 2],
        mut undecided: impl FnMut(usize),
    ) {
        let unit = DVec3::from_array(direction).normalize().as_vec3();
        let (x, y, z) = (s.splat(unit.x), s.splat(unit.y), s.splat(unit.z));
        sides.iter_mut().for_each(Vec::clear);
        let normals = self.normals.each_ref().map(|x| x.as_chunks::<SIXTEEN>().0);
        for (n, ((a, b), c)) in normals[0].iter().zip(normals[1]).zip(normals[2]).enumerate() {
            let cosine = s.add(s.add(s.mul(s.load(a), x), s.mul(s.load(b), y)), s.mul(s.load(c), z));
            let there = (1u32 << (self.pixels.len() - n * SIXTEEN).min(SIXTEEN)) - 1;
            let front = s.at_most(s.splat(0.0), cosine);
            let mut grazing = there & s.at_most(cosine, s.splat(GRAZING)) & s.at_most(s.splat(-GRAZING), cosine);
            while grazing != 0 {
                undecided(n * SIXTEEN + grazing.trailing_zeros() as usize);
                grazing &= grazing - 1;
            }
            sides[0].push(there & front);
            sides[1].push(there & !front);
        }
    }
}

impl Batch<'_> {
    /// The hits of the pixels whose normals f64 knows to 2^-29, from outside. The others are undecided.
    #[inline(always)]
    fn hits(&self, undecided: &dyn Fn(u32)) -> Hits {
        let Self { lighting, ids, pixels, .. } = *self;
        let (record, spheres, placement) = (&lighting.view.record, &lighting.scene.spheres, &lighting.tree.placement);
        let rays = lighting.picture_rays();
        let mut hits = Hits::default();
        let cuts = lighting.cuts.as_ref();
        let planes = cuts.iter().flat_map(|cuts| cuts.planes.iter());
        let planes: Vec<PlaneFromMiddle> = planes.map(|plane| PlaneFromMiddle::of(plane, placement)).collect();
        for some in pixels.chunks(LANES) {
            let shown = ShownBalls::of_some(record, some, ids, spheres);
            let PictureHits { normal, outside, near, sharp, face, .. } = rays.hits(&shown);
            let mut at = [[0.0; LANES]; 3];
            for l in 0..LANES {
                let (place, radius) = (placement.point(shown.center(l)), placement.radius(shown.radius(l)));
                for k in 0..3 {
                    at[k][l] = place[k] + radius * normal[k][l];
                }
            }
            for (l, pixel) in some.iter().enumerate() {
                let id = ids[*pixel as usize];
                let start = [at[0][l], at[1][l], at[2][l]];
                let is_left = cuts.is_some_and(|cuts| match cuts.spared {
                    // The start of a face is not known here.
                    Some(_) if face[l] => true,
                    Some(_) => cuts.cuts.is_spared(id) && !planes.iter().all(|plane| plane.keeps(start)),
                    None => false,
                });
                if outside[l] & near[l] & sharp[l] == 0 || is_left {
                    undecided(*pixel);
                    continue;
                }
                if cuts.is_some() {
                    let n = hits.pixels.len();
                    hits.faces.resize(n / SIXTEEN + 1, 0);
                    hits.faces[n / SIXTEEN] |= u32::from(face[l]) << (n % SIXTEEN);
                }
                hits.pixels.push(*pixel);
                hits.starts.ids.push(id);
                for k in 0..3 {
                    hits.starts.at[k].push(at[k][l]);
                    hits.normals[k].push(normal[k][l] as f32);
                }
            }
        }
        let whole = hits.pixels.len().next_multiple_of(SIXTEEN);
        hits.normals.iter_mut().for_each(|normals| normals.resize(whole, 0.0));
        let [x, y, z] = &hits.starts.at;
        hits.planes.extend(planes.into_iter().map(|plane| {
            let gaps = (0..x.len()).map(|n| plane.gap_at([x[n], y[n], z[n]])).collect();
            PlaneGaps { normal: plane.normal, gaps, error: plane.error }
        }));
        hits
    }
}

/// A plane in the tree's coordinates.
struct PlaneFromMiddle {
    normal: DVec3,
    gap: f64,
    /// Bound of the error of its distance from a start.
    error: f64,
}

impl PlaneFromMiddle {
    fn of(plane: &EyePlane, placement: &Placement) -> Self {
        let [gap, error] = plane.gap_at(placement.middle()).map(|x| placement.radius(x));
        Self {
            normal: DVec3::from_array(plane.normal),
            gap,
            error: error + 8.0 * EPS * gap.abs() + START * plane.length,
        }
    }

    /// Its distance from a start.
    fn gap_at(&self, start: [f64; 3]) -> f64 {
        self.gap - self.normal.dot(DVec3::from_array(start))
    }

    /// Whether it certainly keeps a start.
    fn keeps(&self, start: [f64; 3]) -> bool {
        self.gap_at(start) > self.error
    }
}
