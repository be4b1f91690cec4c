//! Leaves out spheres that no ray of a frame can hit first: of the blocks of a stream, of copies, and of the groups of
//! a scene. docs/certificate.md, section 11.

use super::entry::Bin;
use super::general::GeneralRecord;
use super::projection::ProjectionBounds;
use super::projection::enclose::Enclosed;
use super::projection::project::{Eight, Landed, LaneBatch};
use super::projection::pyramid::{DepthPyramid, Rectangles};
use super::projection::stage::Staged;
use super::terms::TERMS;
use crate::number::ldexp;
use crate::number::vector::LANES;
use crate::scene::instances::enclosure::Enclosure;
use crate::scene::{NumberedBall, Scene, Spheres};
use crate::view::View;
use crate::view::raster::Raster;
use halfline_ground::error::Result;
use halfline_ground::memory::check;
use halfline_ground::parallel;
use pulp::NullaryFnOnce;
use std::ops::Range;

/// Spheres that one job sifts.
const SPHERES_PER_JOB: usize = 1 << 13;

/// The rays of a frame, and the depths behind which the spheres so far hide others.
pub(crate) struct Sieve {
    pub(super) projection: ProjectionBounds,
    pub(super) pyramid: DepthPyramid,
}

/// The verdict on a sphere that some ray may meet.
pub(super) enum Fate {
    /// It is projected, with its centre at this depth, and others hide it.
    Hidden { depth: f64 },
    /// It is projected, and some ray may hit it first.
    Open { depth: f64, bin: Bin },
    /// It is general: the pyramid has no bounds for it.
    General(GeneralRecord),
}

/// Takes the fates of spheres. No closure: compilers would call it, once for each sphere.
pub(super) trait Fates {
    /// Takes the fate of the sphere with this number.
    fn add(&mut self, n: usize, fate: Fate);
}

/// The verdict on all spheres of a group, by the box around them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GroupFate {
    /// Each is behind the eye plane, or projected outside of the image.
    Unseen,
    /// Every ray misses each of them by far; some may be general.
    Missed,
    /// None is general, and others hide all that are projected.
    Hidden,
    /// Some ray may hit one of them first.
    Open,
}

/// The remains of a block.
#[derive(Debug)]
pub(crate) struct Sifted {
    /// Whether some ray may hit a sphere first, by its index.
    pub(crate) kept: Vec<bool>,
    /// The marks of every sieve, in their order.
    pub(crate) marks: Vec<Marks>,
}

/// Facts of a block that a frame needs of all spheres, whether they are kept or not.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Marks {
    /// The least and the largest depth of the centres of all spheres that the frame would project, with their indices.
    pub(crate) depths: Option<[(f64, u32); 2]>,
    /// The index of a sphere that the frame would treat as general; `None` without one.
    pub(crate) general: Option<u32>,
}

impl Marks {
    fn see(&mut self, depth: f64, index: u32) {
        let [least, most] = self.depths.get_or_insert([(depth, index); 2]);
        if depth < least.0 {
            *least = (depth, index);
        }
        if depth > most.0 {
            *most = (depth, index);
        }
    }

    /// Adds the marks of later spheres.
    fn join(&mut self, next: &Self) {
        next.depths.into_iter().flatten().for_each(|(depth, n)| self.see(depth, n));
        self.general = self.general.or(next.general);
    }
}

impl Sieve {
    /// The sieve for the rays of `raster` in the unit 2^`unit`, before any sphere. `None` where the field of view is
    /// too wide or too narrow for the bounds.
    ///
    /// # Errors
    /// Errors of the camera; [`Error::Limits`](crate::Error::Limits) where memory is short.
    pub(crate) fn new(scene: &Scene, raster: Raster, unit: i32, tolerance: f64) -> Result<Option<Self>> {
        let view = View::in_unit(scene, raster, Some(unit))?;
        let size = [scene.image.width, scene.image.height];
        let projection = ProjectionBounds::new(&scene.camera, &view, size, &TERMS)?;
        if !projection.is_bounded() {
            return Ok(None);
        }
        let pixels = u64::from(raster.window.width()) * u64::from(raster.window.height());
        check(DepthPyramid::bytes(pixels, &view.record), || format!("the depths that {pixels} pixels show"))?;
        let pyramid = DepthPyramid::new(&projection, size, raster.window, tolerance);
        Ok(Some(Self { pyramid: pyramid.of_samples(&projection, &view.record, tolerance), projection }))
    }

    /// Brings the levels of the depth pyramid up to date with the spheres since the last refresh.
    pub(crate) fn refresh(&mut self) {
        self.pyramid.refresh();
    }

    /// Decides the fates of the spheres of a range, which `sphere` gives. Spheres behind the eye plane or outside of
    /// the image have none. If `covers`, open spheres hide later ones.
    #[inline(always)]
    pub(super) fn settle(
        &self,
        range: Range<usize>,
        sphere: impl Fn(usize) -> NumberedBall,
        covers: bool,
        fates: &mut impl Fates,
    ) {
        let mut batch = LaneBatch::NONE;
        for first in range.clone().step_by(LANES) {
            batch.fill(first..range.end, &sphere);
            let mut rectangles = Rectangles::NONE;
            let place = |l: usize, landed: &Landed| rectangles.set(l, landed, &self.pyramid);
            let eight = self.projection.eight_and(&batch, 0.0, place);
            for l in 0..batch.count {
                if let Some(fate) = self.settle_lane(&batch, &eight, &rectangles, l, covers) {
                    fates.add(first + l, fate);
                }
            }
        }
    }

    /// The fate of one of eight spheres.
    #[inline(always)]
    fn settle_lane(
        &self,
        batch: &LaneBatch,
        eight: &Eight,
        rectangles: &Rectangles,
        l: usize,
        covers: bool,
    ) -> Option<Fate> {
        let (placed, bin) = if eight.projected[l] != 0 {
            let bin = eight.bin(l);
            if self.pyramid.hides_lane(rectangles, l, bin.chunk_min_depth) {
                return Some(Fate::Hidden { depth: eight.depth[l] });
            }
            (eight.placed(l, batch.ids[l]), bin)
        } else if eight.other[l] != 0 {
            match self.projection.stage(batch.ids[l], batch.centers[l], batch.radii[l], 0.0) {
                Staged::Unseen => return None,
                Staged::General(record) => return Some(Fate::General(record)),
                Staged::Projected(Landed { placed, bin, pixels, .. }) => {
                    if self.pyramid.hides(&pixels, bin.chunk_min_depth) {
                        return Some(Fate::Hidden { depth: placed.depth });
                    }
                    (placed, bin)
                }
            }
        } else {
            return None;
        };
        if covers {
            self.pyramid.cover(&placed);
        }
        Some(Fate::Open { depth: placed.depth, bin })
    }

    /// The fate of the spheres in a box, by what was covered at the last refresh.
    #[inline(always)]
    pub(super) fn settle_group(&self, bounds: &Enclosure) -> GroupFate {
        match self.projection.enclose(bounds) {
            Enclosed::Unseen => GroupFate::Unseen,
            Enclosed::Missed => GroupFate::Missed,
            Enclosed::Projected { least, pixels } if self.pyramid.hides(&pixels, least) => GroupFate::Hidden,
            Enclosed::Projected { .. } | Enclosed::Unknown => GroupFate::Open,
        }
    }

    /// Whether no sphere in a box changes the frame, apart from the facts in [`Marks`].
    pub(crate) fn hides(&self, bounds: &Enclosure) -> bool {
        self.settle_group(bounds) != GroupFate::Open
    }

    /// Bounds of the depths of those spheres in a box that the frame would project; `None` if it projects none.
    pub(crate) fn depths(&self, bounds: &Enclosure) -> Option<[f64; 2]> {
        let is_projected = !matches!(self.projection.enclose(bounds), Enclosed::Unseen | Enclosed::Missed);
        is_projected.then(|| self.projection.depths(bounds))
    }

    /// Whether some sphere in a box may be general.
    pub(crate) fn may_be_general(&self, bounds: &Enclosure) -> bool {
        matches!(self.projection.enclose(bounds), Enclosed::Missed | Enclosed::Unknown)
    }

    /// Whether a sphere that is projected at this depth of the world has a form that f32 holds in the unit 2^`unit` too. True for
    /// parallel rays: a frame of them that is not bounded is exact.
    pub(crate) fn holds(&self, depth: f64, unit: i32) -> bool {
        self.projection.parallel || self.projection.is_in_range(ldexp(depth, -unit))
    }

    /// The exponent of the unit of depths.
    pub(crate) fn unit(&self) -> i32 {
        self.projection.frame
    }
}

/// The spheres of a block that some ray of a sieve may hit first; all of them without sieves. If `covers`, they hide
/// later ones.
pub(crate) fn sift(sieves: &[Sieve], block: &Spheres, covers: bool) -> Sifted {
    let (centers, radii) = (&block.centers[..], &block.radii[..]);
    let mut kept = vec![sieves.is_empty(); radii.len()];
    let arch = pulp::Arch::new();
    let found = parallel::blocks(&mut kept[..], SPHERES_PER_JOB, &|places, kept| -> Vec<Marks> {
        let first = places.start;
        let one = |sieve| {
            let marks = Marks::default();
            arch.dispatch(Job { sieve, first, centers, radii, covers, kept: &mut *kept, marks })
        };
        sieves.iter().map(one).collect()
    });
    let mut marks = vec![Marks::default(); sieves.len()];
    found.iter().for_each(|found| marks.iter_mut().zip(found).for_each(|(all, next)| all.join(next)));
    Sifted { kept, marks }
}

/// Some spheres of a block in one sieve, from index `first` on, with their flags.
struct Job<'a> {
    sieve: &'a Sieve,
    first: usize,
    centers: &'a [[f64; 3]],
    radii: &'a [f64],
    covers: bool,
    kept: &'a mut [bool],
    marks: Marks,
}

impl NullaryFnOnce for Job<'_> {
    type Output = Marks;

    #[inline(always)]
    fn call(mut self) -> Marks {
        let Self { sieve, first, centers, radii, covers, .. } = self;
        let range = first..first + self.kept.len();
        sieve.settle(range, |n| NumberedBall::of(centers, radii, n), covers, &mut self);
        self.marks
    }
}

impl Fates for Job<'_> {
    #[inline(always)]
    fn add(&mut self, n: usize, fate: Fate) {
        match fate {
            Fate::Hidden { depth } => self.marks.see(depth, n as u32),
            Fate::Open { depth, .. } => {
                self.marks.see(depth, n as u32);
                self.kept[n - self.first] = true;
            }
            Fate::General(_) => self.add_general(n),
        }
    }
}

impl Job<'_> {
    /// Adds a sphere that is general in the sieve's unit.
    fn add_general(&mut self, n: usize) {
        let (projection, center, radius) = (&self.sieve.projection, self.centers[n], self.radii[n]);
        let is_kept = if let Ok(depth) = projection.depth_in_any_unit(center, radius) {
            // Where only this unit keeps it from being projected, the frame's unit decides.
            depth.into_iter().for_each(|depth| self.marks.see(depth, n as u32));
            true
        } else {
            self.marks.general = self.marks.general.or(Some(n as u32));
            !projection.misses(&Enclosure::of(center, radius))
        };
        self.kept[n - self.first] |= is_kept;
    }
}
