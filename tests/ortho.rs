//! The promise of the orthographic camera: certified frames are the exact answer of parallel rays, on the GPU and on the
//! CPU path alike, bit for bit where the adapter rounds as IEEE does.
//!
//! Gold standard: the judge, which tests/truth.rs holds against a thousand digits of another program; here it is held
//! once more against a closed form, and against a perspective camera so far away that its rays are as good as parallel.

#[path = "common/bits.rs"]
mod bits;
#[expect(dead_code, reason = "no method but the certified one has parallel rays")]
mod common;

use bits::Bits;
use common::{cpu, gpu};
use glam::DVec3;
use halfline::camera::{Camera, Lens, Look};
use halfline::error::Error;
use halfline::exact::{Judge, Root};
use halfline::explain::explain;
use halfline::frame::{Aov, Frame};
use halfline::intersect::Method;
use halfline::measure::run::{Options, Subject, measure};
use halfline::measure::suite::Random;
use halfline::predict::Prediction;
use halfline::progress::Watch;
use halfline::render::Renderer;
use halfline::scene::{ImagePlane, Scene, Skipped, Spheres};
use halfline::settings::{Accuracy, Search, Settings, Tolerance};

/// Adapters whose every f32 operation was seen to round as IEEE 754 does: tests/twins.rs.
const STRICT: [&str; 2] = ["llvmpipe", "SwiftShader"];

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
        skipped: Skipped::default(),
    }
}

/// `count` spheres of radius `r` to 3 r in a cube of half side `side` about `at`.
fn cloud(seed: u64, count: usize, at: DVec3, side: f64, r: f64) -> Spheres {
    let mut random = Random(seed);
    let mut spheres = Spheres::default();
    for _ in 0..count {
        let center = at + DVec3::from_array(random.cube()) * side;
        let color = random.cube().map(|c| 0.5 + 0.5 * c as f32);
        spheres.push(center.to_array(), r * (1.0 + 2.0 * random.unit()), Some(color));
    }
    spheres
}

/// Back along the view from `at` by so much.
fn behind(at: DVec3, by: f64) -> DVec3 {
    at - DVec3::new(-0.5, -0.4, -0.8).normalize() * by
}

/// Spheres whose silhouettes pass within 2^-k of their radius by the ray of a pixel, for k up to 52.
fn touching() -> Scene {
    let mut scene = scene(DVec3::new(1.0, 2.0, 3.0), 8.0, Spheres::default());
    let basis = scene.camera.basis().expect("a basis");
    let mut random = Random(21);
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

fn scenes() -> Vec<(&'static str, Scene)> {
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
            (0..300)
                .for_each(|n| long.centers[n] = behind(long.centers[n].into(), -(10f64.powi(n as i32 % 9))).to_array());
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

/// Every promise of a certified frame against the exact one; the first that is broken.
fn broken(frame: &Frame, exact: &Frame) -> Option<String> {
    let f64s = |frame: &Frame, aov| frame.f64(aov).expect("asked for").to_vec();
    let (bound, distance, truth) = (f64s(frame, Aov::Bound), f64s(frame, Aov::Distance), f64s(exact, Aov::Distance));
    let (depth, position, place) = (f64s(frame, Aov::Depth), f64s(frame, Aov::Position), f64s(exact, Aov::Position));
    let normal = frame.f32(Aov::Normal).expect("asked for");
    let true_normal = exact.f32(Aov::Normal).expect("asked for");
    for k in 0..truth.len() {
        let fault = |what: &str| Some(format!("pixel {k}: {what}: {} of {}", distance[k], truth[k]));
        if frame.ids()[k] != exact.ids()[k] {
            return fault("another sphere");
        }
        if frame.ids()[k] < 0 {
            continue;
        }
        let off = (distance[k] - truth[k]).abs();
        // The truth itself is rounded.
        let spare = f64::EPSILON * truth[k];
        let most = bound[k].min(1e-5 * truth[k]) + spare;
        if off.is_nan() || off > most || depth[k] != distance[k] {
            return fault("beyond its bound");
        }
        let apart = |a: &[f64], b: &[f64]| DVec3::from_slice(a).distance(DVec3::from_slice(b));
        let at = 3 * k..3 * k + 3;
        // Three roundings of the largest number on the way beside the error of the distance.
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
        assert!(report.hits > 500 || scene.spheres.is_empty(), "{name} shows something");
        proved += report.certified;
        hits += report.hits;
    }
    // Three of the scenes are cut by the plane of the eye, or reach too far out of the view: their pixels are settled.
    assert!(proved > 0.7 * scenes.len() as f64, "{proved} of {}", scenes.len());
    assert!(hits > 20_000, "{hits}");
}

#[test]
fn certified_frames_are_exact_on_the_cpu() {
    check(&mut cpu());
}

#[test]
fn certified_frames_are_exact_on_the_gpu() {
    let Some(mut gpu) = gpu() else { return };
    check(&mut gpu);
}

#[test]
fn kernel_and_twin_agree_bit_for_bit_and_lists_change_nothing() {
    let Some(mut gpu) = gpu() else { return };
    let strict = STRICT.iter().any(|name| gpu.adapter().contains(name));
    for (name, scene) in scenes() {
        for search in [Search::Tiles, Search::All] {
            let settings = Settings { search, ..settings(Accuracy::Certified) };
            let a = gpu.render(&scene, &settings).expect("a frame");
            let b = cpu().render(&scene, &settings).expect("a frame");
            assert_eq!(a.report.backend, "gpu");
            assert_eq!(a.ids(), b.ids(), "{name}");
            for aov in AOVS.into_iter().filter(|_| strict) {
                let [a, b] = [&a, &b].map(|frame| frame.bits(aov));
                let first = a.iter().zip(&b).position(|(a, b)| a != b);
                assert_eq!(first, None, "{name}, {aov}");
            }
        }
    }
}

/// One ball straight ahead: t = z - sqrt(r^2 - u^2 - v^2), in numbers that f64 holds.
#[test]
fn a_ball_ahead_has_a_closed_form() {
    let mut spheres = Spheres::default();
    spheres.push([0.0, 0.0, -7.0], 5.0, None);
    let camera = Camera { lens: Lens::Orthographic { height: 12.0 }, ..Camera::CANONICAL };
    let image = ImagePlane { width: 12, height: 12, background: [0.0; 3] };
    let scene = Scene { camera, image, spheres, skipped: Skipped::default() };
    let judge = Judge::new(&scene).expect("a scene");
    let certified = frame(&mut cpu(), &scene, Accuracy::Certified);
    let (distance, position) =
        (certified.f64(Aov::Distance).expect("asked for"), certified.f64(Aov::Position).expect("asked for"));
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

/// A perspective camera 2^40 behind the plane, its viewport in it: rays 97 / 2^40 from parallel, off by as much at the far
/// end of the scene.
#[test]
fn the_limit_of_perspective_is_the_same_picture() {
    let far = 2f64.powi(40);
    for (name, scene) in scenes() {
        let (camera, image) = (scene.camera, scene.image);
        let lens = camera.viewport(image.width, image.height).expect("a viewport");
        if scene.spheres.is_empty() || !(1e-3..=100.0).contains(&lens.vh) || camera.eye.length() > 100.0 {
            continue;
        }
        // Spheres that the plane cuts would be met before it.
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
                // The eye itself is rounded to 2^-13, along the view and across it.
                assert!((a.t - (b.depth - far)).abs() < 0.05, "{name}: {} and {}", a.t, b.depth - far);
            }
        }
        // Silhouettes within 2^-12 of a pixel's ray may fall to either side.
        assert!(same as f64 >= 0.985 * f64::from(all), "{name}: {same} of {all}");
    }
}

#[test]
fn what_lies_behind_the_plane_of_the_eye_costs_nothing() {
    let (_, scene) = scenes().swap_remove(0);
    let mut more = scene.clone();
    let behind = cloud(31, 300, behind(scene.camera.eye, 2.0), 1.0, 0.05);
    more.spheres.centers.extend(behind.centers);
    more.spheres.radii.extend(behind.radii);
    more.spheres.colors.as_mut().expect("colours").extend(behind.colors.expect("colours"));
    let [a, b] = [&scene, &more].map(|scene| frame(&mut cpu(), scene, Accuracy::Certified));
    assert_eq!((a.ids(), a.report.settled), (b.ids(), b.report.settled));
}

#[test]
fn a_broken_answer_is_found() {
    let (_, scene) = scenes().swap_remove(0);
    let exact = frame(&mut cpu(), &scene, Accuracy::Exact);
    let mut moved = scene.clone();
    moved.camera.eye += moved.camera.basis().expect("a basis").w * 1e-3;
    assert!(broken(&frame(&mut cpu(), &moved, Accuracy::Certified), &exact).expect("1e-3 farther").contains("bound"));
    let mut aside = scene.clone();
    aside.camera.eye += aside.camera.basis().expect("a basis").u * 1e-3;
    assert!(broken(&frame(&mut cpu(), &aside, Accuracy::Certified), &exact).is_some());
}

#[test]
fn what_is_not_certified_is_refused_and_fast_says_what_it_takes() {
    let (_, scene) = scenes().swap_remove(0);
    let plain = Settings { aovs: vec![Aov::Color], ..Settings::default() };
    for method in Method::ALL {
        let settings = Settings { method: Some(*method), ..plain.clone() };
        let error = cpu().render(&scene, &settings).expect_err("no form has parallel rays");
        assert!(matches!(&error, Error::Settings { .. }) && error.to_string().contains("certified"), "{error}");
    }
    for (settings, word) in [
        (plain.clone(), "parallel rays"),
        (Settings { accuracy: Accuracy::Fast, ..plain.clone() }, "fast was asked for"),
        (Settings { tolerance: Some(Tolerance::new(1e-3).expect("a tolerance")), ..plain.clone() }, "1.0e-3"),
    ] {
        let frame = cpu().render(&scene, &settings).expect("a frame");
        assert_eq!((frame.report.accuracy, frame.report.method), ("certified", "certified"));
        assert!(frame.report.reason.contains(word), "{}", frame.report.reason);
        let plan =
            explain(&scene, &Settings { backend: halfline::settings::Backend::Cpu, ..settings }).expect("a plan");
        assert_eq!((plan.accuracy, plan.reason), ("certified", frame.report.reason.clone()));
    }
    let refused = |result: Result<(), Error>| match result {
        Err(Error::Settings { problem, .. }) => {
            assert!(problem.contains("parallel") || problem.contains("orthographic"))
        }
        other => panic!("{other:?}"),
    };
    refused(Prediction::of(&scene, Method::Stable).map(drop));
    let options = Options { backend: halfline::settings::Backend::Cpu, ..Options::default() };
    refused(measure(&Subject::scene("a cloud", scene), &options, &Watch::default(), &mut |_| {}).map(drop));
}
