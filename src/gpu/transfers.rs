//! Uploads, readbacks and the division into bands: `halfline plan` prints them, dispatch.rs performs them.

use super::input::{GROUP, Input, KernelRays};
use super::submission_budget::{PIXEL, SubmissionBudget};
use crate::certify::binned::BinnedScene;
use crate::certify::general::GeneralRecord;
use crate::kernel::{Generals, Kernel, KernelOutput};
use crate::tile::TILE;
use crate::view::{SphereRecord, ViewRecord};

/// The largest binding of an adapter in bytes.
pub(crate) fn largest_binding(limits: &wgpu::Limits) -> u64 {
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
}

/// The largest number of spheres for this kernel: the records of a form, and the colours, must fit one binding. Spheres of
/// certified given rays are a texture.
pub(crate) fn most_spheres(limits: &wgpu::Limits, kernel: &Kernel) -> u64 {
    let fit = |bytes: usize| largest_binding(limits) / bytes as u64;
    let color = size_of::<[f32; 3]>() << u32::from(kernel.face_colors);
    let colors = if kernel.colors { fit(color) } else { u64::MAX };
    let records = if kernel.method().is_some() { fit(size_of::<SphereRecord>()) } else { u64::MAX };
    // Frames store ids as i32.
    colors.min(records).min(i32::MAX as u64)
}

/// A band of the window: rows of pixels, counted in the full frame, or a run of given rays in one row.
pub(crate) struct Band {
    pub(crate) first: u32,
    pub(crate) count: u32,
}

impl Band {
    /// Pixels of the window, or rays, before this band.
    pub(crate) fn before(&self, kernel: &Kernel, record: &ViewRecord) -> u64 {
        match kernel.has_pixels() {
            true => u64::from(record.columns) * u64::from(self.first - record.first_row),
            false => u64::from(self.first),
        }
    }
}

/// The division of the rays into bands that fit the adapter's bindings and the submission budget. The smallest band is
/// a row of tiles or a group of given rays; it is submitted even if it exceeds the budget.
pub(crate) struct Bands<'a> {
    kernel: &'a Kernel,
    record: ViewRecord,
    limits: wgpu::Limits,
    /// The first row or ray of all. Bands begin at multiples of the smallest band, so the first one may be shorter.
    start: u32,
    /// The first row or ray that is in no band yet, and the one past the last.
    first: u32,
    end: u32,
}

impl<'a> Bands<'a> {
    pub(crate) fn new(kernel: &'a Kernel, input: &Input<'_>, limits: wgpu::Limits) -> Self {
        let record = input.view.record;
        let (start, end) = match kernel.has_pixels() {
            true => (record.first_row, record.first_row + record.rows),
            false => (0, input.rays.given() as u32),
        };
        let mut bands = Self { kernel, record, limits, start, first: start, end };
        bands.first -= start % bands.unit().0;
        bands
    }

    /// The next band, as large as `budget` allows.
    pub(crate) fn next(&mut self, budget: &SubmissionBudget) -> Option<Band> {
        let (first, left) = (self.first, self.end - self.first);
        if left == 0 {
            return None;
        }
        let (unit, pixels) = self.unit();
        let fit = (largest_binding(&self.limits) / (KernelOutput::largest(self.kernel) * pixels))
            .clamp(1, self.limits.max_compute_workgroups_per_dimension.into());
        let each = self.tests(&Band { first, count: unit });
        let paid = (budget.next(self.tests(&Band { first, count: left })) / each).max(1.0) as u64;
        let count = (fit.min(paid) * u64::from(unit)).min(u64::from(left)) as u32;
        self.first += count;
        let cut = self.start.saturating_sub(first);
        Some(Band { first: first + cut, count: count - cut })
    }

    /// Rows or rays in the smallest band, and their pixels.
    fn unit(&self) -> (u32, u64) {
        match self.kernel.has_pixels() {
            true => (TILE, u64::from(self.record.columns) * u64::from(TILE)),
            false => (GROUP, u64::from(GROUP)),
        }
    }

    /// Upper bound of a band's cost, in ray-sphere tests of `stable`.
    pub(crate) fn tests(&self, band: &Band) -> f64 {
        let width = if self.kernel.has_pixels() { self.record.columns } else { 1 };
        let pixels = f64::from(width) * f64::from(band.count);
        let cost = self.kernel.method().map_or(1.0, |method| method.cost());
        let each = f64::from(self.record.spheres);
        pixels * (each * cost + PIXEL)
    }
}

/// The lists of general spheres of a band's tiles, as general_lists.wgsl reads them: for each tile the first index and
/// the end of its list, counted from the beginning of the ranges; then the slots of the lists.
pub(crate) fn general_lists<'a>(binned: &'a BinnedScene, band: &Band) -> (Vec<[u32; 2]>, &'a [u32]) {
    let lists = &binned.general_lists;
    let mut tiles: Vec<[u32; 2]> = lists.rows(band.first, band.count).collect();
    let some = tiles.iter().filter(|[first, end]| first < end);
    let [first, end] = some.fold([u32::MAX, 0], |[a, b], [first, end]| [a.min(*first), b.max(*end)]);
    let (first, before) = (first.min(end), 2 * tiles.len() as u32);
    for tile in &mut tiles {
        *tile = if tile[0] < tile[1] { tile.map(|n| n - first + before) } else { [0; 2] };
    }
    (tiles, &lists.slots[first as usize..end as usize])
}

/// General spheres as a uniform buffer of constant size holds them.
pub(crate) fn few_generals(binned: &BinnedScene) -> [GeneralRecord; Generals::MAX_WITHOUT_LISTS] {
    std::array::from_fn(|n| binned.generals.get(n).copied().unwrap_or(bytemuck::Zeroable::zeroed()))
}

/// The inputs of a kernel by binding name, without the view and the inputs of a resident frame.
pub(crate) fn uploads<'a>(kernel: &Kernel, input: &Input<'a>) -> Vec<(&'static str, &'a [u8])> {
    let mut all: Vec<(&'static str, &'a [u8])> = Vec::new();
    if kernel.method().is_some() {
        all.push(("spheres", bytemuck::cast_slice(&input.view.spheres)));
    }
    if let (true, Some(colors)) = (kernel.colors, input.colors) {
        all.push(("colors", bytemuck::cast_slice(colors)));
    }
    match input.rays {
        KernelRays::Viewing => {}
        KernelRays::Given(rays) => all.push(("rays", bytemuck::cast_slice(rays))),
    }
    if kernel.reads_residuals() {
        all.push(("residuals", bytemuck::cast_slice(&input.view.residuals)));
    }
    all
}
