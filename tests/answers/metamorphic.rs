//! Properties of the geometry: scaled, moved, mirrored, turned and reordered scenes have the same certified answers, on
//! every backend.
//!
//! Scaling by powers of two is exact, so bits are compared. Elsewhere each of two distances is within its own bound of the
//! same real number, so they differ by at most the sum of both bounds.

use crate::adapter::renderers;
use crate::rng::Rng;
use glam::DVec3;
use halfline::camera::{Camera, Lens, Look};
use halfline::frame::{Aov, Frame};
use halfline::render::Renderer;
use halfline::scene::{ImagePlane, Scene, Spheres};
use halfline::settings::{Accuracy, Settings};

/// Coordinates are whole multiples of this, so that sums with offsets up to 2^32 are exact.
const GRAIN: f64 = 1.0 / (1u64 << 20) as f64;

fn grain(x: DVec3) -> DVec3 {
    (x / GRAIN).round() * GRAIN
}

/// Spheres in front of the eye, across its plane, around it and far away, all in view of a wide lens.
fn base() -> Scene {
    let mut random = Rng::new(0x5eed_0004);
    let mut spheres = Spheres::default();
    let mut add =
        |center: DVec3, radius: f64| spheres.push(grain(center).to_array(), grain(DVec3::splat(radius)).x, None);
    for _ in 0..60 {
        add(4.0 * DVec3::from_array(random.cube()), 0.05 + 0.5 * random.unit());
    }
    for _ in 0..20 {
        add(DVec3::new(-300.0, -200.0, -250.0) + 50.0 * DVec3::from_array(random.cube()), 30.0 * random.unit() + 1.0);
    }
    add(DVec3::new(1.0, -100.0, 2.0), 98.0);
    let camera = Camera {
        eye: grain(DVec3::new(2.5, 1.5, 2.0)),
        look: Look::View(DVec3::new(-1.0, -0.75, -0.875)),
        up: DVec3::new(0.125, 1.0, 0.25),
        lens: Lens::Viewport { vw: 2.5, vh: 1.75, distance: 1.0 },
    };
    let image = ImagePlane { width: 64, height: 48, background: [0.0; 3] };
    Scene { camera, image, spheres, lighting: Default::default() }
}

/// The scene with `map` applied to every point and every length times `scale`.
fn mapped(scene: &Scene, scale: f64, map: impl Fn(DVec3) -> DVec3) -> Scene {
    let mut scene = scene.clone();
    scene.camera.eye = map(scene.camera.eye);
    for center in scene.spheres.centers.to_mut() {
        *center = map(DVec3::from_array(*center)).to_array();
    }
    scene.spheres.radii.to_mut().iter_mut().for_each(|r| *r *= scale);
    scene
}

/// The same with `map` applied to directions too.
fn turned(scene: &Scene, map: impl Fn(DVec3) -> DVec3) -> Scene {
    let mut scene = mapped(scene, 1.0, &map);
    scene.camera.up = map(scene.camera.up);
    if let Look::View(view) = scene.camera.look {
        scene.camera.look = Look::View(map(view));
    }
    scene
}

fn certified(renderer: &mut Renderer, scene: &Scene) -> Frame {
    let aovs = vec![Aov::Distance, Aov::Bound, Aov::Normal];
    let settings = Settings { accuracy: Accuracy::Certified, aovs, ..Settings::default() };
    renderer.render(scene, &settings).expect("a frame")
}

/// Runs `test` on every backend with the frame of [`base`].
fn on_every_backend(test: impl Fn(&mut Renderer, &Scene, &Frame)) {
    for (_, mut renderer) in renderers() {
        let scene = base();
        let frame = certified(&mut renderer, &scene);
        let shown = frame.report.hits;
        assert!((1500..3072).contains(&shown) && frame.report.certified > 0.9, "{shown} of 3072 hit");
        test(&mut renderer, &scene, &frame);
    }
}

/// Distances and bounds.
fn numbers(frame: &Frame) -> [&[f64]; 2] {
    [Aov::Distance, Aov::Bound].map(|aov| frame.f64(aov).expect("a requested buffer"))
}

/// Checks that the ids (by `rename`) at the pixels that `place` returns are equal, and distances are within both
/// bounds.
fn assert_same(what: &str, a: &Frame, b: &Frame, place: impl Fn(usize) -> usize, rename: impl Fn(i32) -> i32) {
    let ([near, bound], [other, beyond]) = (numbers(a), numbers(b));
    for k in 0..a.ids().len() {
        let m = place(k);
        assert_eq!(rename(a.ids()[k]), b.ids()[m], "{what}: pixel {k}");
        let close = near[k] == other[m] || (near[k] - other[m]).abs() <= bound[k] + beyond[m];
        assert!(close, "{what}: pixel {k}: {} and {}, bounds {:e} {:e}", near[k], other[m], bound[k], beyond[m]);
    }
}

#[test]
fn a_scaled_scene_has_the_same_bits() {
    on_every_backend(|renderer, scene, frame| {
        for k in -40..=40 {
            let scale = 2f64.powi(k);
            let scaled = certified(renderer, &mapped(scene, scale, |p| p * scale));
            assert_eq!(scaled.ids(), frame.ids(), "2^{k}");
            assert_eq!(scaled.f32(Aov::Normal), frame.f32(Aov::Normal), "2^{k}");
            for (a, b) in numbers(frame).into_iter().zip(numbers(&scaled)) {
                assert!(a.iter().zip(b).all(|(a, b)| a * scale == *b), "2^{k}");
            }
        }
    });
}

#[test]
fn a_scaled_viewport_has_the_same_bits() {
    on_every_backend(|renderer, scene, frame| {
        for k in (-60..=60).step_by(12) {
            let mut scaled = scene.clone();
            let unit = 2f64.powi(k);
            scaled.camera.lens = Lens::Viewport { vw: 2.5 * unit, vh: 1.75 * unit, distance: unit };
            let scaled = certified(renderer, &scaled);
            assert_eq!(scaled.ids(), frame.ids(), "2^{k}");
            assert_eq!(numbers(&scaled), numbers(frame), "2^{k}");
        }
    });
}

/// The answer depends only on c - e, and these sums are exact.
#[test]
fn a_scene_moved_with_its_eye_has_the_same_bits() {
    on_every_backend(|renderer, scene, frame| {
        for k in [0, 7, 15, 24, 31] {
            let offset = DVec3::new(1.0, -1.5, 0.75) * 2f64.powi(k);
            let moved = certified(renderer, &mapped(scene, 1.0, |p| p + offset));
            assert_eq!(moved.ids(), frame.ids(), "{offset}");
            assert_eq!(numbers(&moved), numbers(frame), "{offset}");
            assert_eq!(moved.f32(Aov::Normal), frame.f32(Aov::Normal), "{offset}");
        }
    });
}

#[test]
fn a_mirrored_scene_gives_the_mirrored_frame() {
    on_every_backend(|renderer, scene, frame| {
        for mirror in [DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, 1.0), DVec3::NEG_ONE] {
            // The basis is right-handed on either side of a mirror, so the order of columns is reversed.
            let mirrored = certified(renderer, &turned(scene, |p| p * mirror));
            assert_same("mirrored", frame, &mirrored, |k| k / 64 * 64 + 63 - k % 64, |id| id);
        }
    });
}

#[test]
fn a_turned_scene_gives_the_same_frame() {
    on_every_backend(|renderer, scene, frame| {
        for turn in [|p: DVec3| DVec3::new(p.y, p.z, p.x), |p: DVec3| DVec3::new(-p.y, p.x, p.z)] {
            let again = certified(renderer, &turned(scene, turn));
            assert_same("turned", frame, &again, |k| k, |id| id);
        }
    });
}

#[test]
fn reordered_spheres_have_reordered_ids() {
    on_every_backend(|renderer, scene, frame| {
        let count = scene.spheres.len();
        for step in [1, 8, 40] {
            // 81 = 3^4, prime to each step: k goes to step k + 5 modulo 81.
            let to = |k: usize| (step * k + 5) % count;
            let mut reordered = scene.clone();
            for k in 0..count {
                reordered.spheres.centers.to_mut()[to(k)] = scene.spheres.centers[k];
                reordered.spheres.radii.to_mut()[to(k)] = scene.spheres.radii[k];
            }
            let reordered = certified(renderer, &reordered);
            let rename = |id: i32| usize::try_from(id).map_or(-1, |id| to(id) as i32);
            assert_same("reordered", frame, &reordered, |k| k, rename);
        }
    });
}

/// Each sphere 200 times. The first of equal spheres is the one that is hit, and pixels are settled among long lists.
#[test]
fn copies_of_spheres_at_their_places_change_no_answer() {
    on_every_backend(|renderer, scene, frame| {
        let mut copies = scene.clone();
        for _ in 1..200 {
            for (center, radius) in scene.spheres.centers.iter().zip(scene.spheres.radii.iter()) {
                copies.spheres.push(*center, *radius, None);
            }
        }
        let again = certified(renderer, &copies);
        assert!(again.report.settled > 500, "{}", again.report.settled);
        assert_same("copies", frame, &again, |pixel| pixel, |id| id);
    });
}
