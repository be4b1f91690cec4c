//! Sifts blocks of spheres: what no ray of a frame can hit first is left out.

use super::TERMS;
use super::projection::ProjectionBounds;
use super::projection::enclose::Enclosed;
use super::projection::project::Landed;
use super::projection::pyramid::{DepthPyramid, Rectangles};
use super::projection::stage::Staged;
use crate::error::Result;
use crate::memory::check;
use crate::number::vector::LANES;
use crate::scene::Scene;
use crate::scene::instances::enclosure::Enclosure;
use crate::view::raster::Raster;
use crate::view::{Records, View};
use pulp::NullaryFnOnce;

/// The rays of a frame, and what the spheres so far cover.
pub(crate) struct Sieve {
    projection: ProjectionBounds,
    pyramid: DepthPyramid,
}

/// What remains of a block.
#[derive(Debug, Default)]
pub(crate) struct Sifted {
    /// The indices, in order, of the spheres that some ray may hit first.
    pub(crate) kept: Vec<u32>,
    /// What else a frame of each sieve takes from the block.
    pub(crate) marks: Vec<Marks>,
}

/// What a frame takes from all spheres of a block, whether they are kept or not.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Marks {
    /// The least and the largest depth of the centres of all spheres that the frame would project, with their indices.
    pub(crate) depths: Option<[(f64, u32); 2]>,
    /// One that would be general.
    pub(crate) general: Option<u32>,
}

impl Sifted {
    /// The same with `first` added to the indices.
    pub(crate) fn moved(mut self, first: u32) -> Self {
        self.kept.iter_mut().for_each(|n| *n += first);
        for marks in &mut self.marks {
            marks.depths = marks.depths.map(|ends| ends.map(|(depth, n)| (depth, n + first)));
            marks.general = marks.general.map(|n| n + first);
        }
        self
    }

    /// This part and the one after it.
    pub(crate) fn with(mut self, mut next: Self) -> Self {
        self.kept.append(&mut next.kept);
        if self.marks.is_empty() {
            self.marks = next.marks;
            return self;
        }
        for (marks, next) in self.marks.iter_mut().zip(next.marks) {
            next.depths.into_iter().flatten().for_each(|(depth, n)| marks.see(depth, n));
            marks.general = marks.general.or(next.general);
        }
        self
    }

    /// The same block in another sieve: what either keeps.
    pub(crate) fn beside(mut self, mut other: Self) -> Self {
        self.kept.append(&mut other.kept);
        self.kept.sort_unstable();
        self.kept.dedup();
        self.marks.append(&mut other.marks);
        self
    }
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
}

impl Sieve {
    /// For the rays of `raster`, without a sphere; the unit of the view is that of the spheres of `scene`. `None` where
    /// the field of view is too wide or too narrow for the bounds.
    ///
    /// # Errors
    /// Those of the camera, and of numbers beyond the range of one frame; [`Error::Limits`](crate::Error::Limits) where memory is
    /// short.
    pub(crate) fn new(scene: &Scene, raster: Raster, tolerance: f64) -> Result<Option<Self>> {
        let view = View::for_rays(scene, raster, Records::None)?;
        let size = [scene.image.width, scene.image.height];
        let projection = ProjectionBounds::new(&scene.camera, &view, size, &TERMS)?;
        let pixels = u64::from(raster.window.width()) * u64::from(raster.window.height());
        check(DepthPyramid::bytes(pixels, &view.record), || format!("the depths that {pixels} pixels show"))?;
        let pyramid = || {
            let pyramid = DepthPyramid::new(&projection, (size, raster.window), 0.0, tolerance);
            pyramid.of_samples(&projection, &view.record)
        };
        Ok(projection.is_bounded().then(pyramid).map(|pyramid| Self { projection, pyramid }))
    }

    /// Takes over what the spheres since the last refresh cover.
    pub(crate) fn refresh(&mut self) {
        self.pyramid.refresh();
    }

    /// The spheres of a block that some ray may hit first. What they cover hides later ones, if `covers`.
    pub(crate) fn sift(&self, centers: &[[f64; 3]], radii: &[f64], covers: bool) -> Sifted {
        pulp::Arch::new().dispatch(Block { sieve: self, centers, radii, covers })
    }

    /// Whether no sphere in a box changes the frame, but by the numbers that it takes from all: each is certainly missed by every
    /// ray, or hidden by what was covered at the last refresh.
    pub(crate) fn hides(&self, around: &Enclosure) -> bool {
        match self.projection.enclose(around) {
            Enclosed::Unseen => true,
            Enclosed::Projected { least, pixels } => self.pyramid.hides(&pixels, least),
            Enclosed::Unknown => self.projection.misses(around),
        }
    }

    /// Bounds of the depths of those spheres in a box that the frame would project; `None` if it projects none.
    pub(crate) fn depths(&self, around: &Enclosure) -> Option<[f64; 2]> {
        let unseen = match self.projection.enclose(around) {
            Enclosed::Unseen => true,
            Enclosed::Projected { .. } => false,
            Enclosed::Unknown => self.projection.misses(around),
        };
        (!unseen).then(|| self.projection.depths(around))
    }

    /// Whether some sphere in a box may be general.
    pub(crate) fn may_be_general(&self, around: &Enclosure) -> bool {
        matches!(self.projection.enclose(around), Enclosed::Unknown)
    }

    /// Whether a sphere that is projected at this depth of the world has a form that f32 holds in the unit 2^`unit` too.
    pub(crate) fn holds(&self, depth: f64, unit: i32) -> bool {
        self.projection.is_in_range_of(depth, unit)
    }

    /// The exponent of the unit of depths.
    pub(crate) fn unit(&self) -> i32 {
        self.projection.unit_exponent()
    }
}

/// A block while it is sifted.
struct Block<'a> {
    sieve: &'a Sieve,
    centers: &'a [[f64; 3]],
    radii: &'a [f64],
    covers: bool,
}

impl NullaryFnOnce for Block<'_> {
    type Output = Sifted;

    #[inline(always)]
    fn call(self) -> Sifted {
        let Self { sieve: Sieve { projection, pyramid }, centers, radii, covers } = self;
        let (mut kept, mut marks) = (Vec::new(), Marks::default());
        for first in (0..radii.len()).step_by(LANES) {
            let there = LANES.min(radii.len() - first);
            // The last sphere is repeated to fill the vector; the copies are discarded.
            let (mut eight_centers, mut eight_radii) = ([[0.0; 3]; LANES], [0.0; LANES]);
            for l in 0..LANES {
                let at = first + l.min(there - 1);
                (eight_centers[l], eight_radii[l]) = (centers[at], radii[at]);
            }
            let mut rectangles = Rectangles::NONE;
            let see = |l: usize, landed: &Landed| rectangles.set(l, landed, pyramid);
            let eight = projection.eight_and(&eight_centers, &eight_radii, 0.0, see);
            for l in 0..there {
                let index = (first + l) as u32;
                let placed = if eight.projected[l] != 0 {
                    marks.see(eight.depth[l], index);
                    if pyramid.hides_one(&rectangles, l, eight.bin(l).chunk_min_depth) {
                        continue;
                    }
                    eight.placed(l, index)
                } else if eight.other[l] != 0 {
                    match projection.stage(index, eight_centers[l], eight_radii[l], 0.0) {
                        Staged::Unseen => continue,
                        Staged::General(_) => {
                            // Where only this unit keeps it from being projected, the frame's unit decides.
                            if let Ok(depth) = projection.depth_in_any_unit(eight_centers[l], eight_radii[l]) {
                                depth.into_iter().for_each(|depth| marks.see(depth, index));
                                kept.push(index);
                                continue;
                            }
                            marks.general = marks.general.or(Some(index));
                            if !projection.misses(&Enclosure::of(eight_centers[l], eight_radii[l])) {
                                kept.push(index);
                            }
                            continue;
                        }
                        Staged::Projected(landed) => {
                            marks.see(landed.placed.depth, index);
                            if pyramid.hides(&landed.pixels, landed.bin.chunk_min_depth) {
                                continue;
                            }
                            landed.placed
                        }
                    }
                } else {
                    continue;
                };
                kept.push(index);
                if covers {
                    pyramid.cover(&placed);
                }
            }
        }
        Sifted { kept, marks: vec![marks] }
    }
}
