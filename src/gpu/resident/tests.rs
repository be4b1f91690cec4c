//! Resident frames have the same bits whatever the order and the division of their work, and what a device places has the bits of
//! the host. On adapters that keep bits (tests/common/strict.rs) frames have the bits of the CPU path; on others what both
//! prove agrees.

mod cuts;

use super::scene::{BLOCK, Counts};
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
use crate::testing::{Rng, adapter_or_skip, amount, keeps_bits, near_and_far};
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

/// All outputs for a scene.
fn kernel(scene: &Scene, samples: bool) -> Kernel {
    let cuts = scene.spheres.cuts.as_ref();
    let planes = cuts.is_some();
    let certified = Kernel::certified().certified_by(|of| Certificate { depth_interval: true, planes, ..of });
    let face_colors = cuts.is_some_and(|cuts| cuts.colors.is_some());
    Kernel { shade: Some(Shade::Headlight), colors: true, face_colors, t: true, normal: true, samples, ..certified }
}

/// The tolerance of the frames' distances.
const TOLERANCE: f64 = 1e-5;

/// The device's buffers for a scene, the reason where it leaves the frame to the host, and the view.
fn on_device(gpu: &mut Gpu, scene: &Scene, raster: Raster, number: u64) -> (Raw, Option<String>, View) {
    let pool = Pool::default();
    let reach = gpu.hold(scene, number).expect("a device").expect("spheres");
    let mut view =
        View::in_unit(scene, raster, Some(middle(reach.sizes(scene.camera.eye).expect("sizes")))).expect("a view");
    view.record.sample = raster.count() / 2;
    let kernel = kernel(scene, !view.record.is_plain());
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
    let (pool, kernel) = (Pool::default(), kernel(scene, !view.record.is_plain()));
    let binned = BinnedScene::new(&Binning::of(scene, &view, TOLERANCE, &pool)).expect("a stage").expect("a lens");
    let mut host = Raw::new(&kernel, view.record.pixels(), &pool).expect("room");
    let faces = scene.spheres.cuts.as_ref().and_then(|cuts| cuts.colors.as_deref());
    cpu::certified(&kernel, &view, &binned, [scene.spheres.colors.as_deref(), faces], &[], &mut host, &|| true);
    // The depths of misses are of no sphere.
    for raw in [&mut device, &mut host] {
        let Raw { id, depth, .. } = raw;
        depth.iter_mut().zip(id).filter(|(_, id)| **id >= UNSURE).for_each(|(depth, _)| *depth = 0.0);
    }
    (device, host, left)
}

/// The general spheres of the last frame.
fn generals(gpu: &Gpu) -> usize {
    let placed = gpu.resident.as_ref().and_then(|resident| resident.placed.as_ref());
    placed.map_or(0, |(_, binned)| binned.generals.len())
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
                (64, 100, true, 3, 44 << 10),
            ] {
                let gpu = if reversed { &mut far } else { &mut near_by };
                (gpu.block, gpu.open.part, gpu.reversed) = (block, part, reversed);
                gpu.limits.max_compute_workgroups_per_dimension = groups;
                gpu.limits.max_storage_buffer_binding_size = binding;
                number += 1;
                let (device, host, left) = both(gpu, &scene, raster, number);
                assert_eq!(left, None);
                let partial = gpu.buffers.get("generals_storage").map_or(0, |buffer| buffer.size() % 16);
                assert_eq!(partial, 0, "an array of vectors would lose the numbers after its last whole one");
                assert_eq!(generals(gpu), near, "as many as choose between no list, a uniform and lists");
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
        let SkyTraced::Traced(words) = gpu.trace_sky(&rays, &count).expect("a device") else { panic!("no rays") };
        assert!(submissions.get() > 1, "several submissions");
        let open: u32 = words.iter().map(|word| word.count_ones()).sum();
        println!("blocks of {block}: {open} rays of {} pixels are open", raw.id.len());
        // The rays of another window are not the rays of this frame.
        let mut other = View::in_unit(&scene, raster, Some(view.unit)).expect("a view");
        other.record.rows = 1;
        assert!(gpu.trace_sky(&SkyRays { view: &other, ..rays }, &count).expect("a device") == SkyTraced::NoHits);
        // Another view of the same pixels in another unit changes nothing.
        let other = View::in_unit(&scene, raster, Some(view.unit + 3)).expect("a view");
        let again = gpu.trace_sky(&SkyRays { view: &other, ..rays }, &count).expect("a device");
        assert!(again == SkyTraced::Traced(words.clone()));
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

/// The largest difference between the `low` of a device and the `low` of the host: a part of the error that is subtracted
/// from the depth of the centre, and a part of the difference. On adapters that do not keep bits, + - * round either
/// way, a root is within 4.6 ulp and a quotient within 2.5. The error of shaders/place/low.wgsl is then within 48
/// roundings of 2^-23 of its terms, as is the host's, and each difference within one. As 1 - T unit is at least 1/4, the
/// quotient has four times the roundings of T. `INFLATE` of certify/projection.rs leaves 2^-9 of the error for these
/// roundings, so the device's `low` is a lower bound as well.
const LOW: [f64; 2] = [1.0 / 65_536.0, 1.0 / 4_194_304.0];

/// The largest loss of `low` where subnormal numbers are flushed: FLUSHED, 2^-124, twice.
const LOW_FLUSHED: f64 = 1e-37;

/// The eye in a cloud of equal spheres that fill 3 % of a unit cube, as in examples/cloud.
fn within_cloud(rng: &mut Rng, count: usize, lens: Lens) -> Scene {
    let radius = (0.03 / count as f64 * 3.0 / (4.0 * std::f64::consts::PI)).cbrt();
    let mut spheres = Spheres::default();
    (0..count).for_each(|_| spheres.push([0; 3].map(|_| rng.unit()), radius, Some([0.5; 3])));
    let look = Look::At([0; 3].map(|_| rng.unit()).into());
    let eye = [0; 3].map(|_| rng.between(0.2, 0.8)).into();
    let camera = Camera { eye, look, lens, ..Camera::CANONICAL };
    let image = ImagePlane { width: 64, height: 48, background: [0.0; 3] };
    Scene { camera, image, spheres, lighting: Default::default() }
}

/// Lenses of every kind: long and wide ones, one as wide as spheres are left out for, and wider ones; off-centre ones; parallel rays.
fn lenses_within(rng: &mut Rng) -> Vec<Lens> {
    let vfov = |degrees| Lens::Vfov { degrees, distance: 1.0 };
    let off = |share: f64| Lens::Intrinsics { fx: 60.0, fy: 50.0, cx: share * 64.0, cy: 20.25 };
    let mut all = [0.01, 5.0, 32.0, 90.0, 132.0, 140.0, 165.0].map(vfov).to_vec();
    all.extend([off(0.3), off(-0.8)]);
    all.extend([0.01, 0.2, 3.0].map(|height| Lens::Orthographic { height: height * rng.between(0.5, 1.0) }));
    all
}

/// The counts of a placing on the device with the host's part for it.
fn placed_counts(gpu: &mut Gpu, scene: &Scene, raster: Raster, number: u64) -> (Counts, Placer) {
    let reach = gpu.hold(scene, number).expect("a device").expect("spheres");
    let unit = middle(reach.sizes(scene.camera.eye).expect("sizes"));
    let view = View::in_unit(scene, raster, Some(unit)).expect("a view");
    let placer = Placer::new(scene, &view, TOLERANCE).expect("a lens").expect("a projection");
    gpu.refill("placing", bytemuck::bytes_of(&placer.record(0.0))).expect("room");
    gpu.refill("view", bytemuck::bytes_of(&view.record)).expect("room");
    let counts = gpu.with_resident(|gpu, resident| gpu.place_blocks(resident)).expect("a device").expect("spheres");
    (counts, placer)
}

/// A device neither places a sphere nor leaves it to the host only if no ray can hit it, and names a general one among those.
#[test]
fn spheres_that_a_device_leaves_out_are_missed() {
    let Some(mut gpu) = open() else { return };
    let (mut rng, mut number, mut out, mut generals) = (Rng(0xa51de), 4000, 0, 0);
    for case in 0..amount("clouds around the eye", [6, 6, 60]) {
        for lens in lenses_within(&mut rng) {
            let mut scene = within_cloud(&mut rng, 3000, lens);
            // Of many sizes, up to the distance of the eye: most are general, and planes of the image pass between them.
            for radius in scene.spheres.radii.to_mut() {
                *radius *= 10f64.powf(rng.between(-2.0, 0.7));
            }
            number += 1;
            let window = Window::full(64, 48);
            let samples = Raster::samples(window, 4, 7, &scene.image).expect("room").filter(|_| case % 2 == 1);
            let (counts, placer) = placed_counts(&mut gpu, &scene, samples.unwrap_or(Raster::centres(window)), number);
            let has_record = gpu.records().expect("records");
            for id in 0..scene.spheres.len() as u32 {
                if has_record[id as usize].is_some() || counts.summary.for_host.binary_search(&id).is_ok() {
                    continue;
                }
                let [is_general, is_missed] = placer.is_general_and_missed(&scene, id);
                assert!(is_missed, "case {case}, {lens:?}: sphere {id} is left out");
                assert!(!is_general || counts.summary.missed.is_some_and(|first| first <= id), "{lens:?}: sphere {id}");
                out += 1;
                generals += u32::from(is_general);
            }
        }
    }
    println!("{out} spheres are left out, {generals} of them general");
    assert!(generals > 5000, "{generals} of {out}");
}

/// In a cloud around the eye the host looks at the spheres near the eye alone, in place of all near its plane: 2,471 with this
/// lens, 2,069 with parallel rays.
#[test]
fn of_a_cloud_around_the_eye_few_spheres_are_left_to_the_host() {
    let Some(mut gpu) = open() else { return };
    let lenses = [Lens::Vfov { degrees: 32.0, distance: 1.0 }, Lens::Orthographic { height: 0.1 }];
    for (number, (lens, most)) in (4900..).zip(lenses.into_iter().zip([40, 200])) {
        let scene = within_cloud(&mut Rng(0xc10d), 200_000, lens);
        let (counts, _) = placed_counts(&mut gpu, &scene, Raster::centres(Window::full(64, 48)), number);
        println!("{lens:?}: {} of {} spheres are left to the host", counts.host, scene.spheres.len());
        assert!(counts.host < most, "{lens:?}: {}", counts.host);
    }
}

/// Sets the numbers of pixels that are not proved to 0.
fn blank_unproved(raw: &mut Raw) {
    for n in (0..raw.id.len()).filter(|&n| raw.id[n] == UNSURE) {
        raw.t[n] = 0.0;
        raw.normal[3 * n..3 * n + 3].fill(0.0);
        raw.color[3 * n..3 * n + 3].fill(0.0);
    }
}

/// Asserts that both have the same bits, but for what is not proved, which is left to the host and may be NaN; where an adapter does not
/// keep bits, as [`assert_proved_alike`].
fn assert_agree(strict: bool, device: &mut Raw, host: &mut Raw, what: &str) {
    if !strict {
        return assert_proved_alike(device, host, what);
    }
    let differ = device.id.iter().zip(&host.id).filter(|(a, b)| a != b).count();
    blank_unproved(device);
    blank_unproved(host);
    assert!(device == host, "{what}: {differ} ids differ");
}

/// Frames from places in clouds have the bits of the CPU path.
#[test]
fn frames_within_clouds_have_the_bits_of_the_cpu_path() {
    let Some(mut gpu) = open() else { return };
    let strict = keeps_bits(&gpu.summary.name);
    let (mut rng, mut number, mut proved, mut general_spheres) = (Rng(0x1d5), 6000, 0, 0);
    for case in 0..amount("frames within clouds", [2, 4, 40]) {
        for lens in lenses_within(&mut rng) {
            let mut scene = within_cloud(&mut rng, 1000, lens);
            scene.spheres.radii.to_mut().iter_mut().for_each(|radius| *radius *= 10f64.powf(rng.between(-1.0, 0.7)));
            let part = Window { x0: 11, y0: 5, x1: 50, y1: 41 };
            let raster = match case % 3 {
                0 => Raster::centres(Window::full(64, 48)),
                1 => Raster::centres(part),
                _ => Raster::samples(part, 9, 3, &scene.image).expect("room").expect("several samples"),
            };
            number += 1;
            let (mut device, mut host, left) = both(&mut gpu, &scene, raster, number);
            assert_eq!(left, None, "case {case}, {lens:?}");
            assert_agree(strict, &mut device, &mut host, &format!("case {case}, {lens:?}"));
            proved += host.id.iter().filter(|id| **id != UNSURE).count();
            general_spheres += generals(&gpu);
        }
    }
    println!("{proved} pixels are proved, beside {general_spheres} general spheres");
    assert!(proved > 25_000 && general_spheres > 50, "{proved}, {general_spheres}");
}

/// A general sphere aside makes the reference depth 0, as on the CPU path, also where another sphere aside comes before it that is
/// not general; without one, depths are relative to the far cluster.
#[test]
fn a_general_sphere_that_is_missed_decides_the_reference_depth() {
    let Some(mut gpu) = open() else { return };
    // As far from the axis as the host still projects, and farther than f32 is sure of.
    let nearly = ([-63.97, 0.0, -1.0], 0.01);
    let (lateral, ahead) = (([60.0, 3.0, 0.2], 1.0), ([0.0, 0.0, -1000.0], 10.0));
    for (number, (some, is_relative)) in
        (7000..).zip([(vec![], true), (vec![nearly], true), (vec![lateral], false), (vec![nearly, lateral], false)])
    {
        let mut spheres = Spheres::default();
        some.into_iter().chain([ahead]).for_each(|(center, radius)| spheres.push(center, radius, Some([0.5; 3])));
        let lens = Lens::Vfov { degrees: 10.0, distance: 1.0 };
        let image = ImagePlane { width: 64, height: 48, background: [0.0; 3] };
        let camera = Camera { lens, ..Camera::CANONICAL };
        let scene = Scene { camera, image, spheres, lighting: Default::default() };
        let (_, left, view) = on_device(&mut gpu, &scene, Raster::centres(Window::full(64, 48)), number);
        assert_eq!(left, None);
        let pool = Pool::default();
        let host = BinnedScene::new(&Binning::of(&scene, &view, TOLERANCE, &pool))
            .expect("a stage")
            .expect("a lens")
            .projection
            .depth;
        let placed = gpu.resident.as_ref().and_then(|resident| resident.placed.as_ref());
        let device = placed.map(|(_, binned)| binned.projection.depth);
        assert_eq!((device, host > 0.0), (Some(host), is_relative), "{} spheres", scene.spheres.len());
    }
}

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
        .for_each(|n| crowd.push([1e-3 * f64::from(n % 256), 1e-3 * f64::from(n / 256), 0.0], 0.4, Some([1.0; 3])));
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
    let scene = near_and_far(6);
    let full = Window::full(scene.image.width, scene.image.height);
    let limits = gpu.limits.clone();
    gpu.limits.max_storage_buffers_per_shader_stage = 5;
    let (_, left, _) = on_device(&mut gpu, &scene, Raster::centres(full), 3);
    assert!(left.as_ref().is_some_and(|reason| reason.contains("at most 5")), "{left:?}");
    gpu.limits = wgpu::Limits { max_storage_buffer_binding_size: 1 << 15, ..limits };
    let (_, left, _) = on_device(&mut gpu, &scene, Raster::centres(full), 4);
    assert!(left.as_ref().is_some_and(|reason| reason.contains("row of tiles")), "{left:?}");
}
