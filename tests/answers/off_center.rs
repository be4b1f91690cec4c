//! The promise of lenses whose principal point is not the middle of the image: every ray leaves through the pixel's centre of
//! the pinhole camera, ((j + 1/2 - cx)/fx, (cy - i - 1/2)/fy, -1), on every adapter, certified as with every lens.
//!
//! Gold standard: that formula and the quadratic in f64, written here; and crops of images whose middle is the principal
//! point.

use crate::adapter::{cpu, gpu_or_skip};
use crate::rng::Rng;
use glam::DVec3;
use halfline::camera::{Camera, CameraRecord, Lens, Look};
use halfline::exact::Judge;
use halfline::frame::{Aov, Frame};
use halfline::intersect::Method;
use halfline::progress::Watch;
use halfline::render::Renderer;
use halfline::scene::{ImagePlane, Scene, Spheres};
use halfline::settings::{Accuracy, Backend, Settings};
use halfline::window::Window;
use halfline_measure::run::{Options, Subject, measure};

pub(crate) const SIZE: [u32; 2] = [88, 61];

pub(crate) fn scene(lens: Lens, [width, height]: [u32; 2]) -> Scene {
    let mut random = Rng::new(9);
    let mut spheres = Spheres::default();
    for n in 0..700 {
        let center = [0, 1, 2].map(|_| 12.0 * random.unit() - 6.0);
        spheres.push(center, 0.1 + 0.6 * random.unit().powi(3), Some([(n % 7) as f32 / 7.0, 0.5, 0.9]));
    }
    Scene {
        camera: Camera {
            eye: DVec3::new(3.0, 4.0, 15.0),
            look: Look::View(DVec3::new(-0.2, -0.3, -1.0)),
            up: DVec3::new(0.1, 1.0, 0.2),
            lens,
        },
        image: ImagePlane { width, height, background: [0.1, 0.2, 0.3] },
        spheres,
        lighting: Default::default(),
    }
}

pub(crate) fn intrinsics([cx, cy]: [f64; 2]) -> Lens {
    Lens::Intrinsics { fx: 90.0, fy: 84.5, cx, cy }
}

/// Principal points: whole and half pixels, shares of 1/512 that the rays can have, beside the image, and the middle.
pub(crate) const POINTS: [[f64; 2]; 6] = [
    [30.0, 20.5],
    [44.0, 30.5],
    [18.373046875, 41.8046875],
    [87.998046875, 0.001953125],
    [-40.5, 75.0],
    [121.251953125, -30.37109375],
];

/// A focal length is rounded nowhere: with fx = 1, fy = 10, cx = 4.5 and cy = 8 the ray of row 0, column 4 has the slope 7.5/10 and
/// touches the sphere of radius 3 around (0, 0, -5), whose tangents have the sine 3/5. A step less, and it passes; in f64 17 (1/10)/17
/// is not 1/10.
#[test]
fn a_quotient_of_focal_lengths_is_not_rounded() {
    let lens = Lens::Intrinsics { fx: 1.0, fy: 10.0, cx: 4.5, cy: 8.0 };
    for (radius, expected) in [(3.0, 0), (3f64.next_down(), -1)] {
        // In the middle column fx does not matter.
        for (fx, fy) in [(1.0, 10.0), (0.7, 10.0), (3e5, 10.0), (2f64.powi(-40), 10.0), (10.0, 10.0)] {
            let mut spheres = Spheres::default();
            spheres.push([0.0, 0.0, -5.0], radius, None);
            let Lens::Intrinsics { cx, cy, .. } = lens else { panic!("no intrinsics") };
            let camera = Camera { lens: Lens::Intrinsics { fx, fy, cx, cy }, ..Camera::CANONICAL };
            let scene = Scene { camera, spheres, ..scene(lens, [9, 17]) };
            let scene = Scene { image: ImagePlane { width: 9, height: 17, ..scene.image }, ..scene };
            let hit = Judge::new(&scene).expect("a scene").pixel(0, 4);
            assert_eq!(hit.map_or(-1, |hit| i64::from(hit.id)), expected, "{fx} {fy} {radius}");
            assert_eq!(hit.is_some_and(|hit| hit.tangent), expected == 0, "{fx} {fy} {radius}");
            for accuracy in [Accuracy::Certified, Accuracy::Exact] {
                let frame = cpu().render(&scene, &Settings { accuracy, ..Settings::default() }).expect("a frame");
                assert_eq!(i64::from(frame.ids()[4]), expected, "{fx} {fy} {radius} {accuracy:?}");
            }
        }
    }
}

/// The direction of the ray of a pixel, by the pinhole camera.
fn pinhole(camera: &Camera, [i, j]: [f64; 2]) -> DVec3 {
    let Lens::Intrinsics { fx, fy, cx, cy } = camera.lens else { panic!("no intrinsics") };
    let Look::View(view) = camera.look else { panic!("no view") };
    let back = -view.normalize();
    let right = camera.up.cross(back).normalize();
    right * ((j - cx) / fx) + back.cross(right) * ((cy - i) / fy) - back
}

/// The nearest sphere of a ray and its distance, and the least share of a radius by which it passes a silhouette.
fn nearest(scene: &Scene, direction: DVec3) -> (Option<(u32, f64)>, f64) {
    let d = direction.normalize();
    let (mut found, mut margin): (Option<(u32, f64)>, f64) = (None, f64::INFINITY);
    for (n, (center, radius)) in scene.spheres.centers.iter().zip(&scene.spheres.radii).enumerate() {
        let p = DVec3::from_array(*center) - scene.camera.eye;
        let relative_distance = p.cross(d).length() / radius;
        margin = margin.min((relative_distance - 1.0).abs());
        if relative_distance < 1.0 {
            let t = p.dot(d) - radius * (1.0 - relative_distance * relative_distance).sqrt();
            if t > 0.0 && found.is_none_or(|(_, least)| t < least) {
                found = Some((n as u32, t));
            }
        }
    }
    (found, margin)
}

fn frame(renderer: &mut Renderer, scene: &Scene, settings: Settings) -> Frame {
    let aovs = vec![Aov::Distance, Aov::Normal, Aov::Position, Aov::Depth, Aov::Certainty, Aov::Id];
    renderer.render(scene, &Settings { aovs, ..settings }).expect("a frame")
}

#[test]
fn rays_are_those_of_the_pinhole_camera() {
    let mut renderers = vec![("CPU path", cpu())];
    renderers.extend(gpu_or_skip().map(|gpu| ("GPU", gpu)));
    let (mut pixels, mut skipped) = (0, 0);
    for (name, renderer) in &mut renderers {
        for point in POINTS {
            let scene = scene(intrinsics(point), SIZE);
            let judge = Judge::new(&scene).expect("a judge");
            let certified = frame(renderer, &scene, Settings { accuracy: Accuracy::Certified, ..Settings::default() });
            let fast = [None, Some(Method::Stable)].map(|method| {
                frame(renderer, &scene, Settings { accuracy: Accuracy::Fast, method, ..Settings::default() })
            });
            let distance = certified.f64(Aov::Distance).expect("distances");
            let position = certified.f64(Aov::Position).expect("positions");
            for (i, j) in (0..SIZE[1]).flat_map(|i| (0..SIZE[0]).map(move |j| (i, j))) {
                let at = (i * SIZE[0] + j) as usize;
                let ray = pinhole(&scene.camera, [f64::from(i) + 0.5, f64::from(j) + 0.5]);
                let (found, margin) = nearest(&scene, ray);
                pixels += 1;
                // f64 has 1e-16 of 20 units; silhouettes nearer than this are left to the judge.
                if margin < 1e-10 {
                    skipped += 1;
                    continue;
                }
                let place = format!("{name}, principal point {point:?}, row {i}, column {j}");
                assert_eq!(certified.ids()[at], found.map_or(-1, |(id, _)| id as i32), "{place}");
                assert_eq!(judge.pixel(i, j).map(|truth| truth.id), found.map(|(id, _)| id), "{place}: the judge");
                if let Some((_, t)) = found {
                    // The tolerance of certified depths.
                    assert!((distance[at] - t).abs() <= 1e-5 * t, "{place}: {} of {t}", distance[at]);
                    let world = scene.camera.eye + ray.normalize() * t;
                    let off = DVec3::new(position[3 * at], position[3 * at + 1], position[3 * at + 2]) - world;
                    assert!(off.length() <= 1e-5 * t, "{place}: position");
                }
                // A method in f32 errs at silhouettes only: its own error is below 1e-3 of a radius here.
                for other in fast.iter().filter(|_| margin > 1e-3) {
                    assert_eq!(other.ids()[at], certified.ids()[at], "{place}: method stable");
                }
            }
        }
    }
    println!("{pixels} pixels, {skipped} skipped near a silhouette");
    assert!(skipped * 1000 < pixels);
}

#[test]
fn an_image_is_a_part_of_the_one_around_its_principal_point() {
    for samples in [1, 16] {
        let settings =
            || Settings { accuracy: Accuracy::Certified, aovs: vec![Aov::Color], samples, ..Settings::default() };
        // Half pixels: of 2 * 60 columns the first 88, of 2 * 40.5 rows the last 61.
        let part = scene(Lens::Intrinsics { fx: 90.0, fy: 80.0, cx: 60.0, cy: 20.5 }, SIZE);
        // The quotient 81 90/80 is a number of f64, as a viewport's height must be.
        let lens = Lens::Viewport { vw: 120.0, vh: 91.125, distance: 90.0 };
        let whole = scene(lens, [120, 81]);
        let mut renderer = cpu();
        let window = Window { x0: 0, y0: 20, x1: 88, y1: 81 };
        let ours = frame(&mut renderer, &part, settings());
        let theirs = frame(&mut renderer, &whole, Settings { window: Some(window), ..settings() });
        for aov in [Aov::Distance, Aov::Depth, Aov::Position] {
            let bits =
                |frame: &Frame| -> Vec<u64> { frame.f64(aov).expect("a buffer").iter().map(|x| x.to_bits()).collect() };
            assert!(bits(&ours) == bits(&theirs), "{} with {samples} samples", aov.name());
        }
        assert_eq!(ours.ids(), theirs.ids());
        // A part of the image is the same part of the frame.
        let window = Window { x0: 13, y0: 7, x1: 60, y1: 50 };
        let cut = frame(&mut renderer, &part, Settings { window: Some(window), ..settings() });
        let expected: Vec<i32> =
            (7..50).flat_map(|i| (13..60).map(move |j| (i, j))).map(|(i, j)| ours.ids()[i * 88 + j]).collect();
        assert_eq!(cut.ids(), &expected[..]);
    }
}

/// Coverage of 64 samples beside the coverage of a fine grid of rays by the pinhole camera.
#[test]
fn samples_cover_the_pixels_of_the_pinhole_camera() {
    let mut renderers = vec![("CPU path", cpu())];
    renderers.extend(gpu_or_skip().map(|gpu| ("GPU", gpu)));
    for point in [[18.37109375, 41.8046875], [-8.25, 41.5], [30.25, 20.75]] {
        // A smaller image in a shorter lens, since each pixel has 256 rays.
        let [width, height] = [40, 31];
        let lens = Lens::Intrinsics { fx: 45.0, fy: 42.0, cx: point[0] / 2.0, cy: point[1] / 2.0 };
        let mut scene = scene(lens, [width, height]);
        let keep = 40;
        scene.spheres.centers.to_mut().truncate(keep);
        scene.spheres.radii.to_mut().truncate(keep);
        scene.spheres.colors = None;
        scene.spheres.radii.to_mut().iter_mut().for_each(|radius| *radius += 0.5);
        for (name, renderer) in &mut renderers {
            let settings = Settings { samples: 64, aovs: vec![Aov::Alpha], ..Settings::default() };
            let frame = renderer.render(&scene, &settings).expect("a frame");
            let alpha = frame.f32(Aov::Alpha).expect("coverage");
            let (mut worst, mut edges): (f64, u32) = (0.0, 0);
            for (i, j) in (0..height).flat_map(|i| (0..width).map(move |j| (i, j))) {
                let part = |n: u32, k: u32| f64::from(n) + (f64::from(k) + 0.5) / 16.0;
                let rays = (0..16).flat_map(|a| (0..16).map(move |b| (a, b)));
                let hits = rays
                    .filter(|(a, b)| nearest(&scene, pinhole(&scene.camera, [part(i, *a), part(j, *b)])).0.is_some());
                let share = hits.count() as f64 / 256.0;
                edges += u32::from(share > 0.0 && share < 1.0);
                worst = worst.max((share - f64::from(alpha[(i * width + j) as usize])).abs());
            }
            // An edge crosses at most 16 of the 8 x 8 strata, each off by less than a half with random sign: 0.12 is three
            // standard deviations. A quarter of a pixel would be seen as 0.25.
            assert!(worst < 0.15 && edges > 100, "{name}, {point:?}: {worst} at {edges} edges");
        }
    }
}

#[test]
fn the_record_of_a_camera_tells_its_principal_point() {
    for point in [[18.3, 41.7], [1000.123, -2000.4], [30.0, 20.5], [3e4 + 0.3, 0.2]] {
        let scene = scene(intrinsics(point), SIZE);
        let record = CameraRecord::new(&scene.camera, SIZE, None).expect("a record");
        let found = record.intrinsics.expect("intrinsics");
        // A part is 1/256 of a pixel while 8 * 256 * (2 * distance + 2) <= 2^20, and half of it is the rounding.
        let side = 2.0 * point[0].abs().max(point[1].abs()).max(100.0) + 2.0;
        let part = if point[0].fract() == 0.0 { 0.0 } else { 1.0_f64.min(2f64.powi(-8).max(side * 2f64.powi(-16))) };
        assert!((found.cx - point[0]).abs() <= part / 2.0 && (found.cy - point[1]).abs() <= part / 2.0, "{found:?}");
        let again = CameraRecord::new(&record.camera(), SIZE, None).expect("a record");
        assert_eq!(again, record, "its rays are the same again");
    }
    let options = Options { backend: Backend::Cpu, ..Options::default() };
    let subject = Subject::scene("off-centre", scene(intrinsics([30.0, 20.5]), SIZE), Vec::new());
    let error = measure(&subject, &options, &Watch::default(), &mut |_| {});
    assert!(error.map(drop).expect_err("its clearance is another").to_string().contains("principal point"));
    for bad in [[f64::NAN, 1.0], [1.0, f64::INFINITY], [1e9, 0.0]] {
        cpu().render(&scene(intrinsics(bad), SIZE), &Settings::default()).expect_err("no frame of that size");
    }
}
