//! The memory that a frame needs, compared with the memory that is free, and the number of spheres that would fit.

use super::plan::Plan;
use crate::answers::light::Traced;
use crate::answers::open_sky::SkySums;
use crate::answers::settle::Settled;
use crate::certify::binned::BinnedScene;
use crate::certify::general::{General, GeneralRecord};
use crate::exact;
use crate::frame::Aov;
use crate::frame::coverage::Coverage;
use crate::gpu::device::AdapterSummary;
use crate::kernel::Kernel;
use crate::scene::Scene;
use crate::search::tree::Tree;
use crate::settings::{Accuracy, Settings};
use crate::view::raster::strata_of;
use crate::view::{SphereRecord, SphereResiduals, View};
use crate::window::Window;
use halfline_ground::error::{Error, Result};
use halfline_ground::memory::SPHERE;
use halfline_ground::quote::setting::{CROP, SIZE, TILE};

/// Peak bytes on the host per sphere that a ray may hit, for a certified frame: its bin (20), its key (12), and its list
/// entry (40 and its share of a chunk's depth), once in the list of its row and once in the frame's. Spheres smaller
/// than a tile have about 1.1 entries. Spheres that no ray hits have none, but that is not known at this point.
const STAGED: u64 = 126;

/// Bytes per entry of these lists beyond 1.1 for each sphere: its key, and twice the entry.
const ENTRY: u64 = 12 + 2 * 42;

/// Bytes per general sphere while its lists are made: its record in the list of a job and in the list of all, and its numbers
/// in f64. Also its place among all (4), and its place and lower bound in the list of the whole image (12).
const GENERAL: u64 = (2 * size_of::<GeneralRecord>() + size_of::<General<f64>>() + 4 + 12) as u64;

/// Bytes per tile of the lists of general spheres: the tile's list while they are laid out (4), and its range (8).
const NEAR_TILE: u64 = 12;

/// Bytes per entry of these lists: in the list of its cell and in the list of all, each with capacity for twice as many at most.
const NEAR_ENTRY: u64 = 2 * 2 * size_of::<u32>() as u64;

/// Frames keep ids as i32.
const MAX_SPHERES: u64 = i32::MAX as u64;

/// The host memory of a frame besides its scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Need {
    /// Bytes for its pixels.
    pub(crate) pixels: u64,
    /// Bytes for each sphere.
    pub(crate) sphere: u64,
    /// The number of spheres.
    pub(crate) spheres: u64,
    /// The number of pixels.
    pub(crate) count: u64,
    /// Bytes that the caller needs for what it does with the frame.
    pub(crate) reserve: u64,
    /// Bytes for lists of spheres beyond `sphere`, once they are known.
    pub(crate) lists: u64,
}

impl Need {
    /// The need of a window of a planned frame, on an adapter or on the CPU path.
    pub(crate) fn of(
        plan: &Plan,
        settings: &Settings,
        scene: &Scene,
        window: Window,
        adapter: Option<&AdapterSummary>,
    ) -> Self {
        let (gpu, shares) = (adapter.is_some(), adapter.is_some_and(AdapterSummary::shares_memory));
        let (record, wide) = (size_of::<SphereRecord>() as u64, plan.kernel.is_wide());
        let records = record + if wide { size_of::<SphereResiduals>() as u64 } else { 0 };
        let sphere = match plan.accuracy {
            Accuracy::Exact if plan.given.is_none() => exact::BYTES_PER_SPHERE,
            _ if plan.kernel.is_certified() => STAGED,
            _ if plan.given.is_some() => Tree::bytes(1),
            // Two copies while it is uploaded, and what the device holds.
            _ if shares => 3 * records,
            _ if gpu => 2 * records,
            // The twin has copies in its own number type.
            _ => records + if wide { 48 } else { 24 },
        };
        let has_tree = plan.light_outputs.is_any() && plan.given.is_none();
        let sphere = sphere + if has_tree { Tree::bytes(1) } else { 0 };
        // The opaque spheres, with their ids and their tree, and the second frame while it is made.
        let through = SPHERE + 4 + STAGED + if plan.light_outputs.is_any() { Tree::bytes(1) } else { 0 };
        let sphere = sphere + if plan.see_through { through } else { 0 };
        // The scene of the eyes on a lens.
        let sphere = sphere + if settings.aperture.is_some() { SPHERE } else { 0 };
        // The buffers of the samples, their sums, and the means.
        let sampled = plan.sampled.map_or(0, |kernel| {
            let colors = u64::from(kernel.shade.is_some() || plan.light_outputs.color);
            // The spheres and the normals of the pixels, and the rays toward the sky, twice while they are put together.
            let sky = scene.lighting.sky.filter(|_| plan.light_outputs.color);
            let rays = sky.map_or(0, |sky| 4 + 6 + 2 * 2 * SkySums::count(sky.colors.is_some()) as u64);
            // Of layers: the ids and colours of one, its shares and what passes, the ids of all, and the rays of each.
            let layers = u64::from(settings.layers.max(1));
            let through = if plan.see_through { 4 + 12 + 4 + 4 + layers * (4 + rays) } else { 0 };
            bytes_per_pixel(&kernel, &[], 0, gpu) + (24 + 12) * colors + 4 + 4 + rays + through
        });
        // Of rays from hits that go down together: the words of their answers, twice while they are collected, and the lists of pixels.
        let streamed = plan.light_outputs.is_any().then(|| {
            let sky = if plan.light_outputs.occlusion { Some(settings.buffer_sky(scene)) } else { scene.lighting.sky };
            let rays = sky.map_or(0, |sky| sky.rays as usize) + scene.lighting.lights.len();
            2 * 4 * Traced::words_of(rays) as u64 + 2 * 4
        });
        let kernel = bytes_per_pixel(&plan.kernel, &[], 0, gpu);
        // The exact answer of every pixel, twice while the threads' lists are joined.
        let exact = if plan.accuracy == Accuracy::Exact { 2 * size_of::<Settled>() as u64 } else { 0 };
        let covers =
            u64::from(settings.coverage) * Coverage::pixel_bytes(u64::from(strata_of(settings.samples)).pow(2));
        // The kernel's buffers also exist on the device.
        let device = if shares { kernel } else { 0 };
        let each = bytes_per_pixel(&plan.kernel, &settings.aovs, scene.lighting.lights.len() as u64, gpu)
            + sampled
            + streamed.unwrap_or(0)
            + covers
            + exact
            + device
            // The directions of a curved lens, in its camera and in the world.
            + if plan.given.is_some() { 2 * size_of::<[f64; 3]>() as u64 } else { 0 };
        let count = u64::from(window.width()) * u64::from(window.height());
        let (pixels, spheres) = (count.saturating_mul(each), scene.spheres.len() as u64);
        Self { pixels, sphere, spheres, count, reserve: settings.reserve, lists: 0 }
    }

    /// The same with the lists that the host makes of the binned scene, whose lengths are not known before: spheres wider than a tile
    /// are in several, in more where pixels have so many `samples`.
    pub(crate) fn with_lists(self, binned: Option<&BinnedScene>, samples: u32) -> Self {
        let Some(binned) = binned else { return self };
        let entries = binned.lists.entries(self.spheres, samples.into());
        let lists = ENTRY * entries.saturating_sub(self.spheres + self.spheres / 10);
        Self { lists: self.lists + lists, ..self }
    }

    /// The same with the general spheres of the binned scene, whose number is not known before: where the eye is in a crowd they
    /// need more than [`Need::of`] counts for a sphere.
    pub(crate) fn with_generals(self, binned: Option<&BinnedScene>, view: &View) -> Self {
        let Some(binned) = binned.filter(|binned| !binned.generals.is_empty()) else { return self };
        let [[left, right], [top, bottom]] = view.record.tiles();
        let tiles = u64::from(right - left + 1) * u64::from(bottom - top + 1);
        let lists = NEAR_TILE * tiles + NEAR_ENTRY * binned.general_lists.slots.len() as u64;
        Self { lists: self.lists + GENERAL * binned.generals.len() as u64 + lists, ..self }
    }

    /// Bytes for pixels, lists and the caller.
    fn bytes_without_spheres(&self) -> u64 {
        self.pixels.saturating_add(self.reserve).saturating_add(self.lists)
    }

    /// Bytes in all.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes_without_spheres().saturating_add(self.spheres.saturating_mul(self.sphere))
    }

    /// The number of spheres that fit in `free` bytes; those beyond the scene's own also need room for their numbers.
    pub(crate) fn fitting(&self, free: u64) -> u64 {
        let left = free.saturating_sub(self.bytes_without_spheres());
        let had = self.spheres.min(left / self.sphere.max(1));
        had + (left - had * self.sphere) / (self.sphere + SPHERE)
    }

    /// Refuses a frame that does not fit in `free` bytes, if that number is known.
    ///
    /// # Errors
    /// [`Error::Limits`] with the numbers and the size that fits.
    pub(crate) fn check(&self, free: Option<u64>) -> Result<()> {
        if self.spheres > MAX_SPHERES {
            let problem = format!("{} spheres are more than 32-bit ids can number", self.spheres);
            return Err(Error::Limits { problem, mend: format!("render at most {MAX_SPHERES} spheres") });
        }
        let (need, Some(free)) = (self.bytes(), free.filter(|free| self.bytes() > *free)) else {
            return self.check_count();
        };
        let problem = format!(
            "the frame needs about {need} bytes of memory ({} for its pixels and {} for each sphere), but only {free} are free",
            self.bytes_without_spheres(),
            self.sphere
        );
        let mend = match self.fitting(free) {
            _ if self.bytes_without_spheres() > free => format!("render a smaller {SIZE} or fewer buffers"),
            fit => format!("render at most {fit} spheres, or a smaller {SIZE}"),
        };
        Err(Error::Limits { problem, mend })
    }

    /// Refuses more pixels than 32-bit indices can number, even where memory allows them.
    fn check_count(&self) -> Result<()> {
        if self.count <= u64::from(u32::MAX) {
            return Ok(());
        }
        let problem = format!("{} pixels are more than 32-bit indices can number", self.count);
        Err(Error::Limits { problem, mend: format!("render tiles with {TILE} or {CROP}, and merge them") })
    }
}

/// Bytes on a device for each sphere: itself, its records, its colour; and besides a kernel's outputs for each pixel: minima and a ray's start.
const SPHERE_ON_DEVICE: u64 = 32 + 48 + 12;
const PIXEL_ON_DEVICE: u64 = 12 + 32;

/// Bytes of so many spheres on a device, and of the pixels of a kernel: an estimate, by which frames are compared.
pub(crate) fn on_device(spheres: usize, kernel: &Kernel, pixels: u64) -> u64 {
    let each = bytes_per_pixel(kernel, &[], 0, true) + PIXEL_ON_DEVICE;
    (spheres as u64).saturating_mul(SPHERE_ON_DEVICE).saturating_add(pixels.saturating_mul(each))
}

/// Bytes per pixel held at once: the kernel's buffers and those made from them.
fn bytes_per_pixel(kernel: &Kernel, aovs: &[Aov], lights: u64, gpu: bool) -> u64 {
    let made = aovs.iter().map(|aov| match aov {
        // The kernel's buffers become the frame's.
        Aov::Color | Aov::Normal | Aov::Id => 0,
        Aov::Position => 24,
        Aov::Distance | Aov::Depth | Aov::Bound => 8,
        Aov::Alpha | Aov::Occlusion => 4,
        Aov::Shadow => 4 * lights,
        Aov::Mask | Aov::Certainty => 1,
    });
    let vectors = u64::from(kernel.normal) + u64::from(kernel.shade.is_some());
    // A method on the CPU path stores both parts of t, requested or not.
    let t = match gpu || kernel.is_certified() {
        true => u64::from(kernel.t) * if kernel.is_wide() { 2 } else { 1 },
        false => 2,
    };
    let depth = 8 * u64::from(kernel.has_depths());
    4 + 4 * (t + u64::from(kernel.has_depth_interval())) + depth + 12 * vectors + made.sum::<u64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intersect::Method;
    use crate::render::Renderer;
    use crate::render::rendering::{FrameRays, Rendering};
    use crate::render::setup::FrameSetup;
    use crate::scene::camera::{Camera, Lens};
    use crate::scene::{ImagePlane, Spheres};
    use crate::settings::Backend;
    use crate::testing::Rng;
    use crate::view::raster::Raster;

    const GIB: u64 = 1 << 30;

    /// Calls `check` with the need of a certified frame on the CPU path, without its lists, and its setup.
    fn with_setup(camera: Camera, side: u32, spheres: Spheres, check: impl FnOnce(Need, &FrameSetup, &BinnedScene)) {
        let image = ImagePlane { width: side, height: side, background: [0.0; 3] };
        let scene = Scene { camera, image, spheres, lighting: Default::default() };
        let settings = Settings { accuracy: Accuracy::Certified, backend: Backend::Cpu, ..Settings::default() };
        let plan = Plan::new(&scene, &settings, &mut |_| true).expect("a plan");
        let window = settings.window_of(&scene).expect("a window");
        let bare = Need::of(&plan, &settings, &scene, window, None);
        let mut renderer = Renderer::new(&settings).expect("the CPU path");
        let mut at = Rendering::new(&mut renderer, &scene, &settings, FrameRays { window, samples: None });
        let setup = FrameSetup::new(&mut at, plan, (&scene, None), Raster::centres(window)).expect("a setup");
        check(bare, &setup, setup.engine.binned().expect("bins"));
    }

    /// Inside a crowd the plan counts what the frame really allocates for general spheres, and not much more.
    #[test]
    fn general_spheres_and_their_lists_are_counted() {
        for (count, radius, degrees) in
            [(1000, 0.7, 40.0), (100_000, 0.7, 40.0), (1000, 0.066, 120.0), (10, 0.7, 120.0)]
        {
            let mut rng = Rng(3);
            let mut spheres = Spheres::default();
            (0..count).for_each(|_| spheres.push([0; 3].map(|_| rng.between(-1.0, 1.0)), radius, None));
            let lens = Lens::Vfov { degrees, distance: 1.0 };
            let camera = Camera { eye: [0.01, 0.02, 0.03].into(), lens, ..Camera::CANONICAL };
            with_setup(camera, 512, spheres, |bare, setup, binned| {
                assert!(!binned.generals.is_empty(), "{count} of radius {radius}");
                let need = bare.with_generals(Some(binned), &setup.view);
                // What is still allocated once the lists are made.
                let ranges = 64 * 64 * size_of::<[u32; 2]>();
                let allocated = size_of::<GeneralRecord>() * binned.generals.capacity()
                    + 4 * binned.general_lists.slots.capacity()
                    + ranges;
                let counted = need.bytes() - bare.bytes();
                println!(
                    "{count} of radius {radius}: {} general, {counted} bytes counted, {allocated} held",
                    binned.generals.len()
                );
                // The numbers in f64 and the cells' lists are gone: at most GENERAL of 64 bytes, and 16 of 4.
                assert!(
                    allocated as u64 <= counted && counted <= 5 * allocated as u64,
                    "{count}: {counted} bytes counted, {allocated} held"
                );
            });
        }
    }

    /// Spheres wider than a tile are in several lists, which the plan counts as long as they are.
    #[test]
    fn lists_of_spheres_wider_than_a_tile_are_counted() {
        for (radius, least) in [(0.001, 0.9), (0.02, 2.0)] {
            let mut rng = Rng(5);
            let mut spheres = Spheres::default();
            let center = |rng: &mut Rng| [rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-4.0, -3.0)];
            (0..10_000).for_each(|_| spheres.push(center(&mut rng), radius, None));
            with_setup(Camera::CANONICAL, 1024, spheres, |bare, _, binned| {
                let entries = binned.lists.projected.len() as f64 / 10_000.0;
                assert!(entries > least, "{entries} entries for a sphere of radius {radius}");
                let counted = |samples| bare.with_lists(Some(binned), samples).lists as f64 / 10_000.0;
                // 96 bytes for each entry beyond 1.1 for each sphere; up to eight entries for each sphere, and 2^21.
                assert!((counted(1) - 96.0 * (entries - 1.1).max(0.0)).abs() < 1.0, "{} bytes", counted(1));
                assert!(counted(4) > 96.0 * (3.9 * entries - 1.1), "{} bytes of samples", counted(4));
                assert!(counted(1 << 20) <= 96.0 * (8.0 + 210.0), "{} bytes at most", counted(1 << 20));
            });
        }
    }

    /// The buffers of a device are memory of the host where both share it.
    #[test]
    fn buffers_of_a_device_with_memory_of_its_own_are_not_counted() {
        let mut spheres = Spheres::default();
        (0..9).for_each(|n| spheres.push([f64::from(n), 0.0, -9.0], 0.4, None));
        let image = ImagePlane { width: 64, height: 64, background: [0.0; 3] };
        let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
        let certified = Settings { accuracy: Accuracy::Certified, ..Settings::default() };
        let method = Settings { method: Some(Method::Stable), ..Settings::default() };
        for (settings, copies) in [(certified, 0), (method, size_of::<SphereRecord>() as u64)] {
            let plan = Plan::new(&scene, &settings, &mut |_| true).expect("a plan").on_device();
            let window = settings.window_of(&scene).expect("a window");
            let need = |kind| {
                let [name, backend, driver] = [(); 3].map(|()| String::new());
                let (index, subgroup, max_binding, max_buffer) = (0, None, GIB, GIB);
                let of = AdapterSummary {
                    index,
                    name,
                    kind,
                    backend,
                    driver,
                    subgroup,
                    f64: false,
                    max_binding,
                    max_buffer,
                };
                Need::of(&plan, &settings, &scene, window, Some(&of))
            };
            let [shared, own] = ["integrated", "discrete"].map(need);
            let outputs = 64 * 64 * bytes_per_pixel(&plan.kernel, &[], 0, true);
            assert_eq!((shared.pixels - own.pixels, shared.sphere - own.sphere), (outputs, copies), "{settings:?}");
        }
    }

    #[test]
    fn the_number_that_fits_fits_and_one_more_does_not() {
        let need = Need { pixels: GIB - 5, sphere: 100, spheres: 10_000_000, count: 1 << 20, reserve: 5, lists: 0 };
        assert!(need.check(Some(need.bytes())).is_ok() && need.check(None).is_ok());
        let error = need.check(Some(need.bytes() - 1)).expect_err("a byte too few").to_string();
        assert!(error.contains("at most 9999999 spheres"), "{error}");
        let free = 3 * GIB;
        let (fit, total) = (need.fitting(free), need.spheres);
        assert!(fit > total);
        let with = |spheres: u64| GIB + spheres * 100 + (spheres - total) * SPHERE;
        assert!(with(fit) <= free && with(fit + 1) > free);
        let error = need.check(Some(GIB - 1)).expect_err("too many pixels").to_string();
        assert!(error.contains(SIZE) && !error.contains("at most"), "{error}");
        let error = Need { pixels: u64::MAX / 2, ..need }.check(Some(GIB)).expect_err("absurd").to_string();
        assert!(error.contains("bytes"), "{error}");
        let error = Need { count: 1 << 32, ..need }.check(None).expect_err("no numbers").to_string();
        assert!(error.contains("4294967296 pixels") && error.contains(TILE), "{error}");
        let error = Need { spheres: MAX_SPHERES + 1, ..need }.check(None).expect_err("no ids").to_string();
        assert!(error.contains(&MAX_SPHERES.to_string()), "{error}");
    }
}
