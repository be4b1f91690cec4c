//! Spheres that a frame depends on though no ray may hit them: those whose numbers are the extremes of all.

use crate::answers::depth_cue::reach;
use crate::certify::sieve::Marks;
use crate::double_double::ldexp;
use crate::render::plan::choose::MAX_FOR_METHOD;
use crate::scene::Spheres;
use crate::scene::camera::Basis;
use crate::scene::instances::enclosure::Enclosure;
use crate::view::size_from;
use halfline_ground::parallel;
use std::ops::Range;

/// A sphere with its number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Witness {
    pub(super) number: u64,
    pub(super) center: [f64; 3],
    pub(super) radius: f64,
    pub(super) color: Option<[f32; 3]>,
    pub(super) opacity: f32,
}

/// The spheres with the least and the largest sizes, depths and coordinates so far.
#[derive(Debug)]
pub(super) struct Witnesses {
    basis: Basis,
    /// The greatest score of each kind, with its sphere.
    best: [Best; SCORES],
    /// For every sieve the greatest of minus the depths and of the depths, and a general sphere.
    ends: Vec<[Best; 2]>,
    generals: Vec<Option<Witness>>,
    /// The first spheres, up to [`FIRST`].
    first: Vec<Witness>,
}

/// Scores of a sphere: the size that the frame's unit depends on, the box around all, and the depths of a depth cue, each as a
/// maximum.
pub(super) const SCORES: usize = 10;

/// Spheres that one job scores.
const SPHERES_PER_JOB: usize = 1 << 12;

/// The first spheres are kept in any case: plans depend on whether there are more than so many.
pub(super) const FIRST: usize = MAX_FOR_METHOD + 1;

/// The sphere with the greatest score so far.
type Best = Option<(f64, Witness)>;

/// Takes a sphere whose score is greater.
fn improve(best: &mut Best, score: f64, sphere: impl FnOnce() -> Option<Witness>) {
    if best.is_none_or(|(known, _)| score > known) {
        *best = sphere().map(|sphere| (score, sphere));
    }
}

impl Witnesses {
    /// No spheres yet, seen by a camera with this basis.
    pub(super) fn new(basis: Basis) -> Self {
        Self { basis, best: [None; SCORES], ends: Vec::new(), generals: Vec::new(), first: Vec::new() }
    }

    /// Takes the first spheres of a block, whose numbers `number` gives, while there are too few.
    pub(super) fn add_first(&mut self, block: &Spheres, number: &impl Fn(usize) -> u64) {
        let more = 0..block.len().min(FIRST.saturating_sub(self.first.len()));
        self.first.extend(more.map(|n| witness(block, number(n), n)));
    }

    /// Takes the spheres of a block.
    pub(super) fn see(&mut self, block: &Spheres, number: &impl Fn(usize) -> u64) {
        let basis = self.basis;
        let job = |ids: Range<usize>| {
            ids.fold([f64::NEG_INFINITY; SCORES], |best, id| {
                let score = scores(&basis, block.centers[id], block.radii[id]);
                std::array::from_fn(|k| if score[k] > best[k] { score[k] } else { best[k] })
            })
        };
        let all = parallel::blocks(0..block.len(), SPHERES_PER_JOB, &|ids, _| job(ids));
        for (n, best) in all.into_iter().enumerate() {
            for (k, score) in best.into_iter().enumerate() {
                improve(&mut self.best[k], score, || {
                    let mut range = n * SPHERES_PER_JOB..block.len();
                    let place = range.find(|n| scores(&basis, block.centers[*n], block.radii[*n])[k] == score);
                    place.map(|place| witness(block, number(place), place))
                });
            }
        }
    }

    /// Takes the marks of every sieve in a block. Depths are in the unit 2^`unit`.
    pub(super) fn mark(&mut self, block: &Spheres, number: &impl Fn(usize) -> u64, marks: &[Marks], unit: i32) {
        let of = |place: u32| witness(block, number(place as usize), place as usize);
        if self.ends.len() < marks.len() {
            self.ends.resize(marks.len(), [None; 2]);
            self.generals.resize(marks.len(), None);
        }
        for ((ends, general), marks) in self.ends.iter_mut().zip(&mut self.generals).zip(marks) {
            let scaled = |depth: f64| ldexp(depth, unit);
            let found = marks.depths.map(|[least, most]| [(-scaled(least.0), least.1), (scaled(most.0), most.1)]);
            for (known, (score, place)) in ends.iter_mut().zip(found.into_iter().flatten()) {
                improve(known, score, || Some(of(place)));
            }
            *general = general.or(marks.general.map(of));
        }
    }

    /// The greatest score of a kind so far.
    pub(super) fn score(&self, kind: usize) -> f64 {
        self.best[kind].map_or(f64::NEG_INFINITY, |(score, _)| score)
    }

    /// An upper bound of it for the spheres in a box.
    pub(super) fn bound(&self, kind: usize, around: &Enclosure) -> f64 {
        let Basis { e, w, .. } = self.basis;
        let ([most, least], [least_r, most_r]) = (around.away(e), around.radii);
        // The products and sums of `reach`, with both signs turned.
        let [near, far] = around.along(-w, e);
        match kind {
            0 => most.max_element().max(most_r),
            1 => -least.max_element().max(least_r),
            2..5 => around.high[kind - 2] + most_r,
            5..8 => most_r - around.low[kind - 5],
            8 => -(near - most_r),
            _ => far + most_r,
        }
    }

    /// Minus the least depth so far of a sieve, and the largest.
    pub(super) fn end(&self, sieve: usize, end: usize) -> f64 {
        let known = self.ends.get(sieve).and_then(|ends| ends[end]);
        known.map_or(f64::NEG_INFINITY, |(score, _)| score)
    }

    /// Whether a sphere was found that is general in this sieve.
    pub(super) fn has_general(&self, sieve: usize) -> bool {
        self.generals.get(sieve).is_some_and(Option::is_some)
    }

    /// All of them; one sphere may occur several times.
    pub(super) fn all(&self) -> impl Iterator<Item = Witness> + '_ {
        let ends = self.ends.iter().flatten();
        let generals = self.generals.iter().flatten().copied();
        self.best
            .iter()
            .chain(ends)
            .flatten()
            .map(|(_, witness)| *witness)
            .chain(generals)
            .chain(self.first.iter().copied())
    }
}

/// The sphere of a block at an index.
fn witness(block: &Spheres, number: u64, place: usize) -> Witness {
    Witness {
        number,
        center: block.centers[place],
        radius: block.radii[place],
        color: block.colors.as_ref().map(|colors| colors[place]),
        opacity: block.opacity(place as u32),
    }
}

#[inline(always)]
fn scores(basis: &Basis, [x, y, z]: [f64; 3], r: f64) -> [f64; SCORES] {
    let size = size_from(basis.e, [x, y, z], r);
    let [near, far] = reach(basis, [x, y, z], r);
    [size, -size, x + r, y + r, z + r, r - x, r - y, r - z, -near, far]
}
