//! Resident frames have the same bits whatever the order and the division of their work, and what a device places has the bits of
//! the host. On adapters that keep bits (tests/common/strict.rs) frames have those of the CPU path; on others what both prove
//! agrees.

use super::scene::BLOCK;
use super::sky::{SkyRays, SkyRecord, SkyTraced};
use super::*;
use crate::answers::raw::Raw;
use crate::certify::binned::Binning;
use crate::cpu;
use crate::frame::report::Timings;
use crate::gpu::device;
use crate::gpu::submission_budget::SubmissionBudget;
use crate::scene::camera::{Camera, Lens, Look};
use crate::scene::{ImagePlane, Spheres};
use crate::search::tree::Tree;
use crate::search::tree::device_rays::DirectionRecord;
use crate::shade::Shade;
use crate::testing::{Rng, adapter_or_skip, keeps_bits, near_and_far};
use crate::view::directions::SkyDirections;
use crate::view::middle;
use crate::view::raster::Raster;
use crate::view::ray::UNSURE;
use crate::window::Window;
use bytemuck::Zeroable;

/// A device of the pinned adapter.
fn open() -> Option<Gpu> {
    let found = adapter_or_skip()?;
    Some(Gpu::new(device::open(&found).expect("a device"), found.summary))
}

/// All outputs but one: with lists of general spheres that is as many buffers as SwiftShader binds.
fn kernel(samples: bool) -> Kernel {
    Kernel { shade: Some(Shade::Headlight), colors: true, t: true, normal: true, samples, ..Kernel::certified() }
}

/// The tolerance of the frames' distances.
const TOLERANCE: f64 = 1e-5;

/// The device's buffers for a scene, the reason where it leaves the frame to the host, and the view.
fn on_device(gpu: &mut Gpu, scene: &Scene, raster: Raster, number: u64) -> (Raw, Option<String>, View) {
    let (pool, kernel) = (Pool::default(), kernel(raster.count() > 1));
    let reach = gpu.hold(scene, number).expect("a device").expect("spheres");
    let mut view =
        View::in_unit(scene, raster, Some(middle(reach.sizes(scene.camera.eye).expect("sizes")))).expect("a view");
    view.record.sample = raster.count() / 2;
    let placer = Placer::new(scene, &view, TOLERANCE).expect("a lens").expect("a projection");
    let mut device = Raw::new(&kernel, view.record.pixels(), &pool).expect("room");
    let frame = ResidentFrame { scene, view: &view, placer: &placer, pool: &pool };
    let mut output = Output { raw: &mut device, timings: &mut Timings::default() };
    let left = match gpu.render_resident(&kernel, frame, &mut output, &|_| true).expect("a frame") {
        Rendered::Frame(_) => None,
        Rendered::Left(reason) => Some(reason),
    };
    (device, left, view)
}

/// The buffers of a device and of the CPU path for a scene, and the reason where the device leaves the frame to the
/// host.
fn both(gpu: &mut Gpu, scene: &Scene, raster: Raster, number: u64) -> (Raw, Raw, Option<String>) {
    let (mut device, left, view) = on_device(gpu, scene, raster, number);
    let (pool, kernel) = (Pool::default(), kernel(raster.count() > 1));
    let binned = BinnedScene::new(&Binning::of(scene, &view, TOLERANCE, &pool)).expect("a stage").expect("a lens");
    let mut host = Raw::new(&kernel, view.record.pixels(), &pool).expect("room");
    cpu::certified(&kernel, &view, &binned, scene.spheres.colors.as_deref(), &mut host, &|| true);
    // The depths of misses are of no sphere.
    for raw in [&mut device, &mut host] {
        let Raw { id, depth, .. } = raw;
        depth.iter_mut().zip(id).filter(|(_, id)| **id >= UNSURE).for_each(|(depth, _)| *depth = 0.0);
    }
    (device, host, left)
}

/// Asserts that device and host agree where both prove: ids; depths within twice the tolerance, normals within twice
/// 1e-3 (certify::NORMAL), and so the headlight's colours, since both are within the promise. At least nine of ten
/// pixels are proved by both: their share with spheres around the eye.
fn assert_proved_alike(device: &Raw, host: &Raw, what: &str) {
    let proved: Vec<_> = (0..host.id.len()).filter(|&n| device.id[n] != UNSURE && host.id[n] != UNSURE).collect();
    assert!(10 * proved.len() >= 9 * host.id.len(), "{what}: {} of {} pixels", proved.len(), host.id.len());
    for n in proved {
        assert_eq!(device.id[n], host.id[n], "{what}: pixel {n}");
        if host.id[n] >= UNSURE {
            continue;
        }
        let [a, b] = [device, host].map(|raw| raw.depth[n] + f64::from(raw.t[n]));
        assert!((a - b).abs() <= 2.0 * TOLERANCE * b, "{what}: pixel {n}: depths {a} and {b}");
        for (name, a, b) in [("normals", &device.normal, &host.normal), ("colours", &device.color, &host.color)] {
            let [a, b] = [a, b].map(|values| &values[3 * n..3 * n + 3]);
            let off = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(off <= 2e-3, "{what}: pixel {n}: {name} {a:?} and {b:?}");
        }
    }
}

#[test]
fn a_frame_has_the_same_bits_in_every_order_and_division() {
    let (Some(mut near_by), Some(mut far)) = (open(), open()) else { return };
    // The host reads results from copies, as on devices with memory of their own.
    far.direct = false;
    let strict = keeps_bits(&far.summary.name);
    let mut number = 0;
    for near in [0, 3, 6] {
        let scene = near_and_far(near);
        let full = Window::full(scene.image.width, scene.image.height);
        let part = Window { x0: 37, y0: 11, x1: 102, y1: 59 };
        let samples = Raster::samples(part, 4, 7, &scene.image).expect("room").expect("several samples");
        for raster in [Raster::centres(full), Raster::centres(part), samples] {
            let mut first: Option<Raw> = None;
            // Blocks, bytes of a submission, their order, workgroups in a row, and bytes of a binding: several blocks, submissions
            // of one or of a part, rows and bands.
            for (block, part, reversed, groups, binding) in [
                (BLOCK, 1 << 26, false, 65_535, 128 << 20),
                (7, 1 << 26, false, 65_535, 128 << 20),
                (7, 7 * 32, true, 2, 128 << 20),
                (64, 100, true, 3, 26 << 10),
            ] {
                let gpu = if reversed { &mut far } else { &mut near_by };
                (gpu.block, gpu.open.part, gpu.reversed) = (block, part, reversed);
                gpu.limits.max_compute_workgroups_per_dimension = groups;
                gpu.limits.max_storage_buffer_binding_size = binding;
                number += 1;
                let (device, host, left) = both(gpu, &scene, raster, number);
                assert_eq!(left, None);
                let what = format!(
                    "{near} near, {raster:?}, blocks of {block}, {part} bytes, {groups} groups, {binding} bytes"
                );
                let hits = host.id.iter().filter(|id| **id < UNSURE).count();
                assert!(hits > 1000, "{hits} hits: {what}");
                let same = |a: &Raw, b: &Raw, what: &str| {
                    let differ = a.id.iter().zip(&b.id).filter(|(a, b)| a != b).count();
                    assert!(a == b, "{what}: {differ} ids differ");
                };
                if strict {
                    same(&device, &host, &what);
                } else {
                    assert_proved_alike(&device, &host, &what);
                }
                match &first {
                    None => first = Some(device),
                    Some(first) => same(&device, first, &format!("{what}, and the first division")),
                }
            }
        }
    }
}

/// The rays of a pixel in several submissions, of hits on spheres in several blocks.
#[test]
fn rays_from_hits_have_the_same_bits_in_every_division() {
    let Some(mut gpu) = open() else { return };
    let (scene, pool) = (near_and_far(3), Pool::default());
    let tree = Tree::new(&scene.spheres.centers, &scene.spheres.radii).expect("spheres");
    let raster = Raster::centres(Window::full(scene.image.width, scene.image.height));
    let (mut found, rays) = (Vec::new(), 70);
    for (number, (block, groups)) in [(BLOCK, 65_535), (7, 65_535), (7, 2)].into_iter().enumerate() {
        (gpu.block, gpu.budget) = (block, SubmissionBudget::starting(1e6));
        gpu.programs.remove(&Program::Step(Step::Sky));
        gpu.limits.max_compute_workgroups_per_dimension = groups;
        let reach = gpu.hold(&scene, number as u64).expect("a device").expect("spheres");
        let view =
            View::in_unit(&scene, raster, Some(middle(reach.sizes(scene.camera.eye).expect("sizes")))).expect("a view");
        let placer = Placer::new(&scene, &view, 1e-5).expect("a lens").expect("a projection");
        let kernel = Kernel::certified().certified_by(|of| Certificate { starts: true, ..of });
        let mut raw = Raw::new(&kernel, view.record.pixels(), &pool).expect("room");
        let frame = ResidentFrame { scene: &scene, view: &view, placer: &placer, pool: &pool };
        let mut output = Output { raw: &mut raw, timings: &mut Timings::default() };
        gpu.render_resident(&kernel, frame, &mut output, &|_| true).expect("a frame");
        let sky = SkyDirections::new(rays, 1, 0);
        let directions: Vec<_> = sky.turned().iter().map(DirectionRecord::of_unit).collect();
        let rays = SkyRays {
            tree: &tree,
            view: &view,
            directions: &directions,
            record: SkyRecord { rays, seed: 1, sure_limit: f32::MAX, limit: f32::MAX, ..Zeroable::zeroed() },
        };
        let submissions = std::cell::Cell::new(0);
        let count = |_: u64| {
            submissions.set(submissions.get() + 1);
            true
        };
        let SkyTraced::Words(words) = gpu.trace_sky(&rays, &count).expect("a device") else { panic!("no rays") };
        assert!(submissions.get() > 1, "several submissions");
        let open: u32 = words.iter().map(|word| word.count_ones()).sum();
        println!("blocks of {block}: {open} rays of {} pixels are open", raw.id.len());
        // The rays of another window are not those of this frame.
        let mut other = View::in_unit(&scene, raster, Some(view.unit)).expect("a view");
        other.record.rows = 1;
        assert!(gpu.trace_sky(&SkyRays { view: &other, ..rays }, &count).expect("a device") == SkyTraced::NoHits);
        // Another view of the same pixels in another unit changes nothing.
        let other = View::in_unit(&scene, raster, Some(view.unit + 3)).expect("a view");
        let again = gpu.trace_sky(&SkyRays { view: &other, ..rays }, &count).expect("a device");
        assert!(again == SkyTraced::Words(words.clone()));
        let most = gpu
            .trace_sky(&SkyRays { record: SkyRecord { rays: 5000, ..rays.record }, ..rays }, &count)
            .expect("a device");
        assert!(matches!(most, SkyTraced::Refused(reason) if reason.contains("5000 rays")));
        gpu.forget_hits();
        assert!(gpu.trace_sky(&rays, &count).expect("a device") == SkyTraced::NoHits);
        found.push(words);
    }
    assert!(found[0].iter().any(|word| *word != 0) && found[1..].iter().all(|words| *words == found[0]));
}

/// The largest difference between the `low` of a device and that of the host: a part of the error that is subtracted
/// from the depth of the centre, and a part of the difference. On adapters that do not keep bits, + - * round either
/// way, a root is within 4.6 ulp and a quotient within 2.5. The error of shaders/place/low.wgsl is then within 48
/// roundings of 2^-23 of its terms (1 - T unit is at least 1/4, so the quotient has four times those of T), as is the
/// host's, and each difference within one. `INFLATE` of certify/projection.rs leaves 2^-9 of the error for these
/// roundings, so the device's `low` is a lower bound as well.
const LOW: [f64; 2] = [1.0 / 65_536.0, 1.0 / 4_194_304.0];

/// The largest loss of `low` where subnormal numbers are flushed: FLUSHED, 2^-124, twice.
const LOW_FLUSHED: f64 = 1e-37;

/// Cameras from near to far, through long and wide lenses, for parallel rays too.
#[test]
fn places_have_the_bits_of_the_host() {
    let Some(mut gpu) = open() else { return };
    let strict = keeps_bits(&gpu.summary.name);
    let mut rng = Rng(0x91ace);
    let (mut placed, mut number) = (0, 1000);
    for case in 0..120 {
        let scale = 2f64.powf(rng.between(-60.0, 60.0));
        let at = [0; 3].map(|_| scale * rng.between(-10.0, 10.0) * 10f64.powf(rng.between(0.0, 6.0)));
        let mut spheres = Spheres::default();
        for _ in 0..400 {
            let center = at.map(|x| x + scale * rng.between(-1.0, 1.0));
            spheres.push(center, scale * 10f64.powf(rng.between(-5.0, -0.5)), Some([0.5; 3]));
        }
        let far = scale * 10f64.powf(rng.between(0.3, 6.0));
        let direction = [0; 3].map(|_| rng.between(-1.0, 1.0));
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        let eye = [0, 1, 2].map(|k| at[k] + far * direction[k] / length);
        let lens = match case % 3 {
            0 => Lens::Vfov { degrees: (3.0 * scale / far).atan().to_degrees(), distance: 1.0 },
            1 => Lens::Vfov { degrees: rng.between(20.0, 150.0), distance: 1.0 },
            _ => Lens::Orthographic { height: 3.0 * scale },
        };
        let camera = Camera { eye: eye.into(), look: Look::At(at.into()), lens, ..Camera::CANONICAL };
        let image = ImagePlane { width: 61, height: 40, background: [0.0; 3] };
        let scene = Scene { camera, image, spheres, lighting: Default::default() };
        number += 1;
        let raster = Raster::centres(Window::full(61, 40));
        let Some(sizes) = gpu.hold(&scene, number).expect("a device").and_then(|reach| reach.sizes(camera.eye)) else {
            continue;
        };
        let view = View::in_unit(&scene, raster, Some(middle(sizes))).expect("a view");
        let Some(placer) = Placer::new(&scene, &view, 1e-5).expect("a lens") else { continue };
        let binned =
            BinnedScene::new(&Binning::of(&scene, &view, 1e-5, &Pool::default())).expect("a stage").expect("a lens");
        let (_, left, _) = on_device(&mut gpu, &scene, raster, number);
        assert_eq!(left, None);
        for (id, device) in gpu.records().expect("records").into_iter().enumerate() {
            let Some(mut device) = device else { continue };
            // The device also keeps spheres that lie just outside the image, or between pixels.
            let Some(host) = placer.placed(&scene, id as u32, binned.projection.depth) else { continue };
            if !strict {
                let [a, b] = [&device, &host].map(|placed| f64::from(placed.record.low));
                let error = f64::from(host.detail.center) - b;
                let allowed = LOW[0] * error + LOW[1] * b.abs() + LOW_FLUSHED;
                assert!((a - b).abs() <= allowed, "case {case}, sphere {id}: low {a:e} and {b:e}, error {error:e}");
                device.record.low = host.record.low;
            }
            let bits = |placed: &Placed| (placed.record, placed.detail, placed.depth.to_bits());
            assert_eq!(bits(&device), bits(&host), "case {case}, sphere {id}");
            placed += 1;
        }
    }
    println!("{placed} records compared");
    assert!(placed > 5000, "{placed}");
}

/// More spheres around the eye than the host looks at, and larger ones than their pieces are counted: a reason, no frame.
#[test]
fn what_a_device_cannot_hold_is_left_to_the_host() {
    let Some(mut gpu) = open() else { return };
    let image = ImagePlane { width: 64, height: 64, background: [0.0; 3] };
    let mut crowd = Spheres::default();
    (0..=HOST_SPHERES)
        .for_each(|n| crowd.push([f64::from(n % 256) - 128.0, f64::from(n / 256) - 128.0, 0.0], 0.4, Some([1.0; 3])));
    let scene = Scene { camera: Camera::CANONICAL, image, spheres: crowd, lighting: Default::default() };
    let raster = Raster::centres(Window::full(64, 64));
    let (_, left, _) = on_device(&mut gpu, &scene, raster, 1);
    assert!(left.as_ref().is_some_and(|reason| reason.contains("around the eye")), "{left:?}");
    let image = ImagePlane { width: 2048, height: 2048, background: [0.0; 3] };
    let mut walls = Spheres::default();
    (0..9000).for_each(|n| walls.push([0.0, 0.0, -10.0 - f64::from(n)], 2.0 + 0.2 * f64::from(n), Some([1.0; 3])));
    let scene = Scene { image, spheres: walls, ..scene };
    let (_, left, _) = on_device(&mut gpu, &scene, Raster::centres(Window::full(2048, 2048)), 2);
    assert!(left.as_ref().is_some_and(|reason| reason.contains("large")), "{left:?}");
    gpu.limits.max_storage_buffers_per_shader_stage = 8;
    let scene = near_and_far(6);
    let full = Window::full(scene.image.width, scene.image.height);
    let (_, left, _) = on_device(&mut gpu, &scene, Raster::centres(full), 3);
    assert!(left.as_ref().is_some_and(|reason| reason.contains("at most 8")), "{left:?}");
}
