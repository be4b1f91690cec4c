//! The host's part where a device places the spheres (shaders/place): the uniform, and the spheres that the device
//! leaves to the host.

pub(crate) use super::placing_record::PlacingRecord;

use super::binned::BinnedScene;
use super::general_lists::GeneralTree;
use super::planes::{PlaneRecords, Ranks};
use super::projection::stage::Staged;
use super::projection::{ProjectionBounds, WIDEST, host_cull_margin};
use super::reference::{joined, reference};
use super::tiles::{Lists, Placed};
use super::{TERMS, answer::ProjectionRecord};
use crate::scene::Scene;
#[cfg(test)]
use crate::scene::instances::enclosure::Enclosure;
use crate::tile::TILE;
use crate::view::View;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::parallel::{self, CHEAP};

/// Above the factor by which a device's f32 may understate the depth of a sphere that it places: 2^-20 of |c|_1 + r, which is below 112
/// times the depth. Section 9a of docs/certificate.md.
const DEPTHS_ROUNDED: f64 = 1.0 + 1.0 / 4096.0;

/// The result of placing all spheres on a device.
#[derive(Debug, Default)]
pub(crate) struct PlacedSummary {
    /// Least and largest depth of the spheres whose rectangle certainly contains a pixel of the image.
    pub(crate) depths: Option<[f64; 2]>,
    /// The same of the spheres for which f32 cannot tell that.
    pub(crate) perhaps: Option<[f64; 2]>,
    /// The ids of the spheres that the host has to place, in order.
    pub(crate) for_host: Vec<u32>,
    /// The first of the spheres aside, which every ray misses by far and which may be general.
    pub(crate) missed: Option<u32>,
}

/// The spheres that a device left to the host.
pub(crate) struct ByHost {
    /// The scene without lists, with its general spheres.
    pub(crate) binned: BinnedScene,
    /// The records of the projected ones, with the depths of their centres.
    pub(crate) guests: Vec<Placed>,
    pub(crate) reference: f32,
}

/// The host's part in placing the spheres of a frame.
pub(crate) struct Placer {
    projection: ProjectionBounds,
    image: [u32; 2],
    tolerance: f64,
}

impl Placer {
    /// The host's part for the rays of a view. `None` where the field of view is too wide or too narrow for the bounds
    /// of projected spheres.
    ///
    /// # Errors
    /// Errors of the camera.
    pub(crate) fn new(scene: &Scene, view: &View, tolerance: f64) -> Result<Option<Self>> {
        let image = [scene.image.width, scene.image.height];
        let projection = ProjectionBounds::new(&scene.camera, view, image, &TERMS)?;
        let fits = projection.is_bounded() && projection.widest <= WIDEST;
        Ok(fits.then_some(Self { projection, image, tolerance }))
    }

    /// As [`ProjectionBounds::is_same_in_units`].
    pub(crate) fn is_same_in_units(&self, span: i32) -> bool {
        self.projection.is_same_in_units(span)
    }

    /// The kernel's projection uniform of a frame without spheres: the reference depth is 0, and there are no general
    /// spheres.
    pub(crate) fn lens(&self) -> ProjectionRecord {
        self.projection.record(0.0, self.tolerance, 0)
    }

    /// The uniform, with depths relative to `reference`.
    pub(crate) fn record(&self, reference: f32) -> PlacingRecord {
        self.projection.placing_record(reference, self.image)
    }

    /// Places the spheres that a device left, and decides the reference depth, which is the same as in
    /// [`BinnedScene::new`].
    pub(crate) fn by_host(
        &self,
        (scene, ranks): (&Scene, Option<&Ranks>),
        view: &View,
        summary: &PlacedSummary,
        pool: &Pool,
    ) -> ByHost {
        let stage = |reference: f64| -> Vec<Staged> {
            parallel::values(summary.for_host.len(), CHEAP, |n| self.stage(scene, summary.for_host[n], reference))
        };
        let mut staged = stage(0.0);
        let general = |staged: &Staged| matches!(staged, Staged::General(_));
        let depths = staged.iter().filter_map(|staged| match staged {
            Staged::Projected(landed) => Some([landed.placed.depth; 2]),
            _ => None,
        });
        let range = depths.chain(summary.depths).reduce(joined);
        let is_general = |id: u32| general(&self.stage(scene, id, 0.0));
        let has_generals = staged.iter().any(general) || summary.missed.is_some_and(is_general);
        let mut reference = reference(range, has_generals);
        // Further spheres only widen the range, and a range that is too wide stays so. If the first sphere aside is not general,
        // another one may be.
        let within = |[a, b]: [f64; 2]| range.is_some_and(|[least, most]| least <= a && b <= most);
        let is_wider = summary.perhaps.is_some_and(|few| !within(few));
        let is_open = match reference > 0.0 {
            true => is_wider || summary.missed.is_some(),
            false => is_wider && range.is_none() && !has_generals,
        };
        if is_open {
            reference = self.projection.reference_of(&scene.spheres, pool);
        }
        if reference > 0.0 && !staged.is_empty() {
            staged = stage(reference.into());
        }
        let (mut generals, mut guests) = (Vec::new(), Vec::new());
        for staged in staged {
            match staged {
                Staged::General(record) => generals.push(record),
                Staged::Projected(landed) => guests.push(landed.placed),
                Staged::Unseen => {}
            }
        }
        let tiles = view.record.tiles();
        let margin = host_cull_margin(self.tolerance);
        let cuts = scene.spheres.cuts.as_ref().zip(ranks);
        cuts.iter().for_each(|(_, ranks)| ranks.mark(&mut generals));
        // As of spheres that the host bins.
        let margin = if cuts.is_none() { margin } else { f64::INFINITY };
        let general_lists = GeneralTree::new(&self.projection, &generals, self.image, margin).lists(tiles, 0);
        let projection = self.projection.record(reference, self.tolerance, generals.len());
        let lists = Lists::of_tiles(tiles, &[]);
        let placed = guests.iter().map(|guest| guest.depth);
        let deepest = [summary.depths, summary.perhaps].into_iter().flatten().map(|[_, most]| most).chain(placed);
        let deepest = deepest.fold(0.0, f64::max) * DEPTHS_ROUNDED;
        let planes =
            cuts.map(|cuts| PlaneRecords::new(cuts, view, &self.projection, (&lists, &generals), (reference, deepest)));
        ByHost {
            binned: BinnedScene { projection, lists, generals, general_lists, projected_count: 0, planes },
            guests,
            reference,
        }
    }

    fn stage(&self, scene: &Scene, id: u32, reference: f64) -> Staged {
        let (center, radius) = (scene.spheres.centers[id as usize], scene.spheres.radii[id as usize]);
        self.projection.stage(id, center, radius, reference)
    }

    /// A sphere as the host places it; `None` where it has no projected record.
    pub(crate) fn placed(&self, scene: &Scene, id: u32, reference: f32) -> Option<Placed> {
        match self.stage(scene, id, reference.into()) {
            Staged::Projected(landed) => Some(landed.placed),
            _ => None,
        }
    }

    /// Whether a sphere is general, and whether no ray hits it: it is behind or outside of the image, or general and missed by far.
    #[cfg(test)]
    pub(crate) fn is_general_and_missed(&self, scene: &Scene, id: u32) -> [bool; 2] {
        let (center, radius) = (scene.spheres.centers[id as usize], scene.spheres.radii[id as usize]);
        match self.stage(scene, id, 0.0) {
            Staged::Unseen => [false, true],
            Staged::Projected(_) => [false, false],
            Staged::General(_) => [true, self.projection.misses(&Enclosure::of(center, radius))],
        }
    }

    /// Makes the lists of tiles from pairs of a pixel of the window and a sphere that its ray may hit first.
    pub(crate) fn list(&self, scene: &Scene, view: &View, binned: &mut BinnedScene, mut pairs: Vec<[u32; 2]>) {
        // Tiles are numbered in the window, which has fewer than pixels; an image may have more than a u32 counts.
        let tiles = view.record.tiles();
        let [[left, right], [top, _]] = tiles;
        let columns = right - left + 1;
        for [tile, _] in &mut pairs {
            let [row, column] = view.record.place(*tile);
            *tile = (row / TILE - top) * columns + (column / TILE - left);
        }
        parallel::sort(&mut pairs, <[u32; 2]>::cmp);
        pairs.dedup();
        let listed: Vec<_> = pairs.chunk_by(|a, b| a[0] == b[0]).collect();
        let reference = binned.projection.depth;
        let list = |pairs: &&[[u32; 2]]| {
            let placed = pairs.iter().filter_map(|[_, id]| self.placed(scene, *id, reference));
            ([left + pairs[0][0] % columns, top + pairs[0][0] / columns], placed.collect())
        };
        let lists = parallel::collect(listed.len(), 1, &|range, lists| lists.extend(listed[range].iter().map(list)));
        binned.lists = Lists::of_tiles(tiles, &lists);
    }
}
