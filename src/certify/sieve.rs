//! Sifts blocks of spheres: what no ray of a frame can hit first is left out.

use super::TERMS;
use super::projection::ProjectionBounds;
use super::projection::project::{Eight, LANES};
use super::projection::pyramid::DepthPyramid;
use super::projection::stage::Staged;
use crate::error::Result;
use crate::scene::Scene;
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
    /// The least and the largest depth of the centres of all spheres that the frame would project, with their indices.
    pub(crate) depths: Option<[(f64, u32); 2]>,
}

impl Sifted {
    /// The same with `first` added to the indices.
    pub(crate) fn moved(mut self, first: u32) -> Self {
        self.kept.iter_mut().for_each(|n| *n += first);
        self.depths = self.depths.map(|ends| ends.map(|(depth, n)| (depth, n + first)));
        self
    }

    /// This part and the one after it.
    pub(crate) fn with(mut self, mut next: Self) -> Self {
        self.kept.append(&mut next.kept);
        next.depths.into_iter().flatten().for_each(|(depth, n)| self.see(depth, n));
        self
    }

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
    /// Those of the camera, and of numbers beyond the range of one frame.
    pub(crate) fn new(scene: &Scene, raster: Raster, tolerance: f64) -> Result<Option<Self>> {
        let view = View::for_rays(scene, raster, Records::None)?;
        let size = [scene.image.width, scene.image.height];
        let projection = ProjectionBounds::new(&scene.camera, &view, size, &TERMS)?;
        let pyramid = || DepthPyramid::new(&projection, (size, raster.window), 0.0, tolerance);
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

    /// The exponent of the unit of [`Sifted::depths`].
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
        let mut sifted = Sifted::default();
        for first in (0..radii.len()).step_by(LANES) {
            let there = LANES.min(radii.len() - first);
            // The last sphere is repeated to fill the vector; the copies are discarded.
            let at = |l: usize| first + l.min(there - 1);
            let (eight_centers, eight_radii) =
                (std::array::from_fn(|l| centers[at(l)]), std::array::from_fn(|l| radii[at(l)]));
            let eight: Eight = projection.eight(&eight_centers, &eight_radii, 0.0);
            for l in 0..there {
                let index = (first + l) as u32;
                let (bin, placed) = if eight.projected[l] != 0 {
                    sifted.see(eight.depth[l], index);
                    (eight.bin(l), eight.placed(l, index))
                } else if eight.other[l] != 0 {
                    match projection.stage(index, eight_centers[l], eight_radii[l], 0.0) {
                        Staged::Unseen => continue,
                        Staged::General(_) => {
                            sifted.kept.push(index);
                            continue;
                        }
                        Staged::Projected(landed) => {
                            sifted.see(landed.depth, index);
                            (landed.bin, landed.placed)
                        }
                    }
                } else {
                    continue;
                };
                if !pyramid.hides(&bin) && !pyramid.hides_in_pixels(projection, &bin, &placed) {
                    sifted.kept.push(index);
                    if covers {
                        pyramid.cover(&placed);
                    }
                }
            }
        }
        sifted
    }
}
