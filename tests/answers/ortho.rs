//! The promise of the orthographic camera: certified frames are the exact answer of parallel rays, on the GPU and on the
//! CPU path, bit for bit where the adapter rounds as IEEE 754 does.
//!
//! Gold standard: the exact arithmetic, which truth.rs compares with a thousand digits of another program. Here it is
//! compared with a closed form, and with a perspective camera so far away that its rays are almost parallel.

use crate::adapter::{cpu, gpu_or_skip, is_strict};
use crate::bits::Bits;
use crate::cloud;
use crate::rng::Rng;
use glam::DVec3;
use halfline::camera::{Camera, Lens, Look};
use halfline::error::Error;
use halfline::exact::{Judge, Root};
use halfline::explain::explain;
use halfline::frame::{Aov, Frame};
use halfline::intersect::Method;
use halfline::predict::Prediction;
use halfline::progress::Watch;
use halfline::render::Renderer;
use halfline::scene::{ImagePlane, Scene, Spheres};
use halfline::settings::{Accuracy, Settings, Tolerance};
use halfline_measure::run::{Options, Subject, measure};

const AOVS: [Aov; 9] =
    [Aov::Color, Aov::Distance, Aov::Depth, Aov::Normal, Aov::Position, Aov::Id, Aov::Mask, Aov::Certainty, Aov::Bound];

fn scene(eye: DVec3, height: f64, spheres: Spheres) -> Scene {
    Scene {
        camera: Camera {
            eye,
            look: Look::View(DVec3::new(-0.5, -0.4, -0.8)),
            up: DVec3::new(0.1, 1.0, 0.2),
            lens: Lens::Orthographic { height },
        },
        image: ImagePlane { width: 97, height: 61, background: [0.1, 0.2, 0.3] },
        spheres,
        lighting: Default::default(),
    }
}

/// Coloured spheres about a point.
fn cloud(seed: u64, count: usize, at: DVec3, side: f64, r: f64) -> Spheres {
    cloud::cloud(seed, count, at.to_array(), side, r)
}

/// The point at distance `by` from `at`, against the view direction.
fn behind(at: DVec3, by: f64) -> DVec3 {
    at - DVec3::new(-0.5, -0.4, -0.8).normalize() * by
}

/// Spheres whose silhouettes pass a pixel's ray within 2^-k of their radius, for k up to 52.
fn touching() -> Scene {
    let mut scene = scene(DVec3::new(1.0, 2.0, 3.0), 8.0, Spheres::default());
    let basis = scene.camera.basis().expect("a basis");
    let mut random = Rng::new(21);
    for n in 0..400 {
        let [i, j] = [61.0, 97.0].map(|side| (random.unit() * side).floor());
        let [u, v] = [(j + 0.5 - 48.5) * 8.0 / 61.0, (30.5 - i - 0.5) * 8.0 / 61.0];
        let r = 10f64.powf(random.unit() * 3.0 - 2.5);
        let turn = random.unit() * std::f64::consts::TAU;
        let off = 2f64.powi(-(n % 50) - 3) * if n % 2 == 0 { 1.0 } else { -1.0 };
        let center =
            basis.e + basis.u * (u + r * (1.0 + off) * turn.cos()) + basis.v * (v + r * (1.0 + off) * turn.sin())
                - basis.w * (r + 10.0 * random.unit());
        scene.spheres.push(center.to_array(), r, None);
    }
    scene
}

pub(crate) fn scenes() -> Vec<(&'static str, Scene)> {
    let zero = DVec3::ZERO;
    let mut scenes = vec![
        ("a cloud", scene(behind(zero, 5.0), 3.0, cloud(1, 60, zero, 1.0, 0.05))),
        ("thousands of spheres", scene(behind(zero, 9.0), 2.5, cloud(2, 6000, zero, 1.0, 0.012))),
        ("the plane of the eye cuts a cloud", scene(zero, 3.0, cloud(3, 400, zero, 1.0, 0.06))),
        ("far from the origin", {
            let at = DVec3::new(1e7, -2e7, 3e7);
            scene(behind(at, 4.0), 3.0, cloud(4, 300, at, 1.0, 0.05))
        }),
        ("the eye far behind", scene(behind(zero, 1e9), 3.0, cloud(5, 300, zero, 1.0, 0.05))),
        ("tiny", scene(behind(zero, 4e-20), 3e-20, cloud(6, 300, zero, 1e-20, 5e-22))),
        ("huge", scene(behind(zero, 4e20), 3e20, cloud(7, 300, zero, 1e20, 5e18))),
        ("1e12 away and a thousandth high", {
            let at = DVec3::new(1e12, 2e12, -1e12);
            scene(behind(at, 1.0), 1e-3, cloud(8, 100, at, 1e-3, 1e-3))
        }),
        ("a long way through", {
            let mut long = cloud(9, 300, zero, 1.0, 0.05);
            (0..300).for_each(|n| {
                long.centers.to_mut()[n] = behind(long.centers[n].into(), -(10f64.powi(n as i32 % 9))).to_array()
            });
            scene(behind(zero, 3.0), 3.0, long)
        }),
        ("silhouettes through pixels", touching()),
        ("a ball as large as the view", scene(behind(zero, 4.0), 1.0, cloud(10, 3, zero, 0.3, 0.6))),
        ("a ground far outside the view", {
            let mut spheres = cloud(11, 60, zero, 1.0, 0.05);
            spheres.push([0.0, -1001.0, 0.0], 1000.0, None);
            scene(behind(zero, 5.0), 3.0, spheres)
        }),
        ("nothing", scene(zero, 3.0, Spheres::default())),
    ];
    let mut inside = cloud(12, 200, zero, 1.0, 0.04);
    inside.push([0.1, 0.0, 0.0], 2.5, None);
    scenes.push(("the eye in a sphere", scene(zero, 3.0, inside)));
    scenes
}

fn settings(accuracy: Accuracy) -> Settings {
    Settings { accuracy, aovs: AOVS.to_vec(), ..Settings::default() }
}

fn frame(renderer: &mut Renderer, scene: &Scene, accuracy: Accuracy) -> Frame {
    renderer.render(scene, &settings(accuracy)).expect("a frame")
}

/// The first error of a certified frame.
fn broken(frame: &Frame, exact: &Frame) -> Option<String> {
    let f64s = |frame: &Frame, aov| frame.f64(aov).expect("a requested buffer").to_vec();
    let (bound, distance, truth) = (f64s(frame, Aov::Bound), f64s(frame, Aov::Distance), f64s(exact, Aov::Distance));
    let (depth, position, place) = (f64s(frame, Aov::Depth), f64s(frame, Aov::Position), f64s(exact, Aov::Position));
    let normal = frame.f32(Aov::Normal).expect("a requested buffer");
    let true_normal = exact.f32(Aov::Normal).expect("a requested buffer");
    for k in 0..truth.len() {
        let fault = |what: &str| Some(format!("pixel {k}: {what}: {} of {}", distance[k], truth[k]));
        if frame.ids()[k] != exact.ids()[k] {
            return fault("another sphere");
        }
        if frame.ids()[k] < 0 {
            continue;
        }
        let off = (distance[k] - truth[k]).abs();
        // The exact value is rounded too.
        let spare = f64::EPSILON * truth[k];
        let most = bound[k].min(1e-5 * truth[k]) + spare;
        if off.is_nan() || off > most || depth[k] != distance[k] {
            return fault("beyond its bound");
        }
        let apart = |a: &[f64], b: &[f64]| DVec3::from_slice(a).distance(DVec3::from_slice(b));
        let at = 3 * k..3 * k + 3;
        // The error of the distance, and three roundings of the largest intermediate number.
        let size = place[at.clone()].iter().fold(truth[k], |most, x| most.max(x.abs()));
        if apart(&position[at.clone()], &place[at.clone()]) > off + 16.0 * f64::EPSILON * size {
            return fault("elsewhere");
        }
        let [a, b] = [normal, true_normal].map(|n| n[at.clone()].iter().map(|x| f64::from(*x)).collect::<Vec<_>>());
        // |n - n*| is 2 sin(angle / 2), and both are rounded to f32.
        if apart(&a, &b) > 1e-3 + 1e-6 {
            return fault("another normal");
        }
    }
    None
}

fn check(renderer: &mut Renderer) {
    let (mut proved, mut hits) = (0.0, 0);
    let scenes = scenes();
    for (name, scene) in &scenes {
        let exact = frame(&mut cpu(), scene, Accuracy::Exact);
        let certified = frame(renderer, scene, Accuracy::Certified);
        assert_eq!(broken(&certified, &exact), None, "{name}");
        let report = &certified.report;
        println!("{name:34} {:5} hits, proved {:.4}", report.hits, report.certified);
        assert!(report.hits > 500 || scene.spheres.is_empty(), "{name} has hits");
        proved += report.certified;
        hits += report.hits;
    }
    // Three of the scenes cross the plane of the eye, or reach far out of the view: their pixels are settled.
    assert!(proved > 0.7 * scenes.len() as f64, "{proved} of {}", scenes.len());
    assert!(hits > 20_000, "{hits}");
}

#[test]
fn certified_frames_are_exact_on_the_cpu() {
    check(&mut cpu());
}

#[test]
fn certified_frames_are_exact_on_the_gpu() {
    let Some(mut gpu) = gpu_or_skip() else { return };
    check(&mut gpu);
}

#[test]
fn kernel_and_twin_agree_bit_for_bit() {
    let Some(mut gpu) = gpu_or_skip() else { return };
    let strict = is_strict(&gpu);
    for (name, scene) in scenes() {
        for accuracy in [Accuracy::Certified, Accuracy::Fast] {
            let settings = settings(accuracy);
            let a = gpu.render(&scene, &settings).expect("a frame");
            let b = cpu().render(&scene, &settings).expect("a frame");
            let backend = if scene.spheres.is_empty() { "cpu" } else { "gpu" };
            assert_eq!(a.report.backend, backend, "{name}: {:?}", a.report.warnings);
            assert_eq!(a.ids(), b.ids(), "{name}");
            for aov in AOVS.into_iter().filter(|_| strict) {
                let [a, b] = [&a, &b].map(|frame| frame.bits(aov));
                let first = a.iter().zip(&b).position(|(a, b)| a != b);
                assert_eq!(first, None, "{name}, {aov}");
            }
        }
    }
}

/// One sphere straight ahead: t = z - sqrt(r^2 - u^2 - v^2), in numbers that are exact in f64.
#[test]
fn a_sphere_ahead_has_its_closed_form() {
    let mut spheres = Spheres::default();
    spheres.push([0.0, 0.0, -7.0], 5.0, None);
    let camera = Camera { lens: Lens::Orthographic { height: 12.0 }, ..Camera::CANONICAL };
    let image = ImagePlane { width: 12, height: 12, background: [0.0; 3] };
    let scene = Scene { camera, image, spheres, lighting: Default::default() };
    let judge = Judge::new(&scene).expect("a scene");
    let certified = frame(&mut cpu(), &scene, Accuracy::Certified);
    let (distance, position) = (
        certified.f64(Aov::Distance).expect("a requested buffer"),
        certified.f64(Aov::Position).expect("a requested buffer"),
    );
    for (i, j) in (0..12).flat_map(|i| (0..12).map(move |j| (i, j))) {
        let [u, v] = [f64::from(j) - 5.5, 5.5 - f64::from(i)];
        let left = 25.0 - u * u - v * v;
        let truth = judge.pixel(i, j);
        assert_eq!(truth.is_some(), left >= 0.0, "row {i}, column {j}");
        let pixel = (12 * i + j) as usize;
        assert_eq!(certified.ids()[pixel], if left >= 0.0 { 0 } else { -1 });
        let Some(truth) = truth else { continue };
        // The root and the difference are rounded.
        let t = 7.0 - left.sqrt();
        assert!((truth.t - t).abs() <= 4.0 * f64::EPSILON * 7.0, "row {i}, column {j}: {} of {t}", truth.t);
        assert_eq!((truth.root, truth.distance, truth.depth), (Root::Near, truth.t, truth.t));
        assert!((distance[pixel] - t).abs() <= 1e-5 * t);
        let [x, y, z] = [0, 1, 2].map(|n| position[3 * pixel + n]);
        assert!((x, y) == (u, v) && (z + t).abs() <= 1e-5 * t, "row {i}, column {j}: {x} {y} {z}");
    }
}

/// A perspective camera 2^40 behind the plane, with its viewport in the plane: rays within 97 / 2^40 of parallel.
#[test]
fn a_distant_perspective_camera_gives_the_same_frame() {
    let far = 2f64.powi(40);
    for (name, scene) in scenes() {
        let (camera, image) = (scene.camera, scene.image);
        let lens = camera.viewport(image.width, image.height).expect("a viewport");
        if scene.spheres.is_empty() || !(1e-3..=100.0).contains(&lens.vh) || camera.eye.length() > 100.0 {
            continue;
        }
        // Perspective rays hit spheres that cross the plane in front of it.
        let ahead = |k: &usize| {
            let away = DVec3::from_array(scene.spheres.centers[*k]) - camera.eye;
            let depth = -away.dot(camera.basis().expect("a basis").w);
            depth > 1.01 * scene.spheres.radii[*k] && depth < 1e3
        };
        let some: Vec<_> = (0..scene.spheres.len()).filter(ahead).collect();
        let mut spheres = Spheres::default();
        some.iter().for_each(|k| spheres.push(scene.spheres.centers[*k], scene.spheres.radii[*k], None));
        let parallel = Scene { spheres, ..scene };
        let eye = camera.eye + camera.basis().expect("a basis").w * far;
        let lens = Lens::Viewport { vw: lens.vw, vh: lens.vh, distance: far };
        let perspective = Scene { camera: Camera { eye, lens, ..camera }, ..parallel.clone() };
        let [ours, theirs] = [&parallel, &perspective].map(|scene| Judge::new(scene).expect("a scene"));
        let (mut same, mut all) = (0, 0);
        for (i, j) in (0..image.height).flat_map(|i| (0..image.width).map(move |j| (i, j))) {
            let (a, b) = (ours.pixel(i, j), theirs.pixel(i, j));
            all += 1;
            same += u32::from(a.map(|a| a.id) == b.map(|b| b.id));
            if let (Some(a), Some(b)) = (a, b)
                && a.id == b.id
            {
                // The eye is rounded to 2^-13.
                assert!((a.t - (b.depth - far)).abs() < 0.05, "{name}: {} and {}", a.t, b.depth - far);
            }
        }
        // Silhouettes within 2^-12 of a pixel's ray may fall to either side.
        assert!(same as f64 >= 0.985 * f64::from(all), "{name}: {same} of {all}");
    }
}

#[test]
fn spheres_behind_the_plane_of_the_eye_settle_no_pixel() {
    let (_, scene) = scenes().swap_remove(0);
    let mut more = scene.clone();
    let behind = cloud(31, 300, behind(scene.camera.eye, 2.0), 1.0, 0.05);
    more.spheres.centers.to_mut().extend(behind.centers);
    more.spheres.radii.to_mut().extend(behind.radii);
    more.spheres.colors.as_mut().expect("colours").to_mut().extend(behind.colors.expect("colours"));
    let [a, b] = [&scene, &more].map(|scene| frame(&mut cpu(), scene, Accuracy::Certified));
    assert_eq!((a.ids(), a.report.settled), (b.ids(), b.report.settled));
}

#[test]
fn a_planted_error_is_found() {
    let (_, scene) = scenes().swap_remove(0);
    let exact = frame(&mut cpu(), &scene, Accuracy::Exact);
    let mut moved = scene.clone();
    moved.camera.eye += moved.camera.basis().expect("a basis").w * 1e-3;
    assert!(broken(&frame(&mut cpu(), &moved, Accuracy::Certified), &exact).expect("1e-3 farther").contains("bound"));
    let mut shifted = scene.clone();
    shifted.camera.eye += shifted.camera.basis().expect("a basis").u * 1e-3;
    assert!(broken(&frame(&mut cpu(), &shifted, Accuracy::Certified), &exact).is_some());
}

#[test]
fn uncertified_methods_are_refused_and_fast_needs_none() {
    let (_, scene) = scenes().swap_remove(0);
    let plain = Settings { aovs: vec![Aov::Color], ..Settings::default() };
    for method in Method::ALL {
        let settings = Settings { method: Some(*method), ..plain.clone() };
        let error = cpu().render(&scene, &settings).expect_err("no form has parallel rays");
        assert!(matches!(&error, Error::Settings { .. }) && error.to_string().contains("orthographic"), "{error}");
    }
    for (accuracy, settings, word) in [
        ("certified", plain.clone(), "parallel rays"),
        ("fast", Settings { accuracy: Accuracy::Fast, ..plain.clone() }, "fast is requested"),
        (
            "certified",
            Settings { tolerance: Some(Tolerance::new(1e-3).expect("a tolerance")), ..plain.clone() },
            "within 0.0010",
        ),
    ] {
        let frame = cpu().render(&scene, &settings).expect("a frame");
        assert_eq!((frame.report.accuracy, frame.report.method), (accuracy, accuracy));
        assert!(frame.report.reason.contains(word), "{}", frame.report.reason);
        let plan =
            explain(&scene, &Settings { backend: halfline::settings::Backend::Cpu, ..settings }).expect("a plan");
        assert_eq!((plan.accuracy, plan.reason), (accuracy, frame.report.reason.clone()));
    }
    let refused = |result: Result<(), Error>| match result {
        Err(Error::Settings { problem, .. }) => {
            assert!(problem.contains("parallel") || problem.contains("orthographic"))
        }
        other => panic!("{other:?}"),
    };
    refused(Prediction::of(&scene, Method::Stable).map(drop));
    let options = Options { backend: halfline::settings::Backend::Cpu, ..Options::default() };
    refused(measure(&Subject::scene("a cloud", scene, Vec::new()), &options, &Watch::default(), &mut |_| {}).map(drop));
}
