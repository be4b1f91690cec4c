//! The promise of a crop: in every buffer, the pixels of a window are the full frame's, bit for bit on one adapter.
//!
//! Gold standard: the full frame, cut here. Tolerance: none on any adapter, because a pixel's operations do not depend on
//! the other pixels that are rendered.

use crate::adapter::{admitted, cpu, gpu_or_skip, is_strict, renderers};
use crate::amount::amount;
use crate::bits::Bits;
use crate::cloud::cloud;
use crate::oblique::{self, vfov};
use crate::rng::Rng;
use crate::twins::VISIBLE;
use crate::weekend::weekend;
use glam::DVec3;
use halfline::error::Error;
use halfline::frame::{Aov, Frame};
use halfline::intersect::Method;
use halfline::render::Renderer;
use halfline::scene::{Light, LightSource, Lighting, Scene, Sky, Spheres};
use halfline::settings::{Accuracy, Settings};
use halfline::window::Window;

const SIZE: [u32; 2] = [97, 61];

fn scene(eye: [f64; 3], degrees: f64, spheres: Spheres) -> Scene {
    Scene { lighting: lighting(), ..oblique::scene(SIZE, eye, [0.0; 3], vfov(degrees), spheres) }
}

/// A light from the side, so that there are shadows.
fn lighting() -> Lighting {
    let lights = vec![Light::white(LightSource::Direction(DVec3::new(1.0, 2.0, 0.5)))];
    Lighting { lights, shadows: true, ..Lighting::default() }
}

pub(crate) fn scenes() -> Vec<(&'static str, Scene)> {
    let mut weekend = weekend();
    [weekend.image.width, weekend.image.height] = SIZE;
    weekend.lighting = lighting();
    let mut inside = cloud(2, 300, [0.0; 3], 1.0, 0.05);
    inside.push([0.5, 0.5, 1.5], 0.8, Some([0.9, 0.1, 0.1]));
    let mut far = scene([2e3, -1e3, 3e3], 0.03, cloud(3, 400, [0.0; 3], 1.0, 0.05));
    far.spheres.push(far.spheres.centers[7], far.spheres.radii[7], Some([1.0; 3]));
    vec![
        ("a ground that is near, and tangent spheres", weekend),
        ("the eye in a sphere, spheres behind", scene([0.6, 0.6, 1.6], 70.0, inside)),
        ("from far away, relative to a reference depth", far),
    ]
}

/// One pixel, a row, the last column, odd offsets, whole tiles, the whole frame, and random windows.
pub(crate) fn windows() -> Vec<Window> {
    let [w, h] = SIZE;
    let fixed = [
        [0, 0, 1, 1],
        [w - 1, 0, w, h],
        [w - 1, h - 1, w, h],
        [0, 17, w, 18],
        [3, 5, 22, 40],
        [7, 7, 9, 9],
        [8, 16, 24, 32],
        [31, 0, 32, h],
        [0, 0, w, h],
    ];
    let mut random = Rng::new(11);
    let mut range = |n: u32| {
        let [a, b] = [0, 1].map(|_| (random.unit() * f64::from(n)) as u32);
        [a.min(b), a.max(b) + 1]
    };
    let random = (0..amount("random windows", [1, 1, 6]))
        .map(|_| (range(w), range(h)))
        .map(|([x0, x1], [y0, y1])| [x0, y0, x1, y1])
        .collect::<Vec<_>>();
    fixed.into_iter().chain(random).map(|[x0, y0, x1, y1]| Window { x0, y0, x1, y1 }).collect()
}

/// Settings for every accuracy and method of `renderer`, with all buffers.
fn kinds(renderer: &mut Renderer) -> Vec<(String, Settings)> {
    let sky = |rays: u32| Sky { rays, ..Sky::default() };
    let all = || Settings { aovs: Aov::ALL.to_vec(), sky: sky(4), ..Settings::default() };
    // The judge takes a millisecond for each ray to the sky.
    let rays = |accuracy: Accuracy| if accuracy == Accuracy::Exact { 1 } else { 4 };
    let accuracy =
        |accuracy: Accuracy| (accuracy.name().to_owned(), Settings { accuracy, sky: sky(rays(accuracy)), ..all() });
    let mut kinds = vec![accuracy(Accuracy::Certified), accuracy(Accuracy::Exact)];
    kinds.push(accuracy(Accuracy::Fast));
    let by = |method: Method| (method.name().to_owned(), Settings { method: Some(method), ..all() });
    kinds.extend(admitted(renderer).into_iter().map(by));
    kinds
}

fn render(renderer: &mut Renderer, scene: &Scene, settings: &Settings, window: Window) -> Frame {
    let settings = Settings { window: Some(window), ..settings.clone() };
    renderer.render(scene, &settings).expect("a frame")
}

/// The first buffer in which a crop differs from the pixels of the full frame.
fn differing(crop: &Frame, full: &Frame, window: Window) -> Option<Aov> {
    assert_eq!((crop.width, crop.height), (window.width(), window.height()));
    assert_eq!((crop.window, crop.full), (window, [full.width, full.height]));
    assert_eq!(crop.report.rays, u64::from(window.width()) * u64::from(window.height()));
    assert_eq!(crop.report.hits, crop.ids().iter().filter(|id| **id >= 0).count() as u64);
    let same = |aov: &Aov| crop.bits(*aov) == full.bits_in(window, *aov);
    Aov::ALL.into_iter().find(|aov| !same(aov))
}

fn check(mut renderer: Renderer, strict: bool) {
    let mut settled = 0;
    for (name, scene) in scenes() {
        for (kind, settings) in kinds(&mut renderer) {
            let full = renderer.render(&scene, &settings).expect("a frame");
            if !strict && full.report.predicted.is_some_and(|predicted| predicted.outline > VISIBLE) {
                println!("{name}, {kind}: the method loses its digits");
                continue;
            }
            assert!(full.report.hits > 500, "{name}, {kind} has hits: {}", full.report.hits);
            for window in windows() {
                let crop = render(&mut renderer, &scene, &settings, window);
                assert_eq!(differing(&crop, &full, window), None, "{name}, {kind}, crop {window}");
                settled += crop.report.settled * u64::from(crop.report.accuracy == "certified");
            }
        }
    }
    assert!(settled > 10, "some certified pixels were settled: {settled}");
}

#[test]
fn a_crop_has_the_bits_of_the_full_frame_on_the_cpu() {
    check(cpu(), true);
}

#[test]
fn a_crop_has_the_bits_of_the_full_frame_on_the_gpu() {
    let Some(gpu) = gpu_or_skip() else { return };
    let strict = is_strict(&gpu);
    check(gpu, strict);
}

/// Spheres that cover the whole image are in the lists of all tiles. There are so many of them that tiles share their lists,
/// which is decided for the whole frame: src/certify/tests/window.rs checks that they do.
#[test]
fn a_crop_with_shared_lists_has_the_bits_of_the_full_frame() {
    let mut random = Rng::new(5);
    let mut spheres = Spheres::default();
    for _ in 0..2600 {
        let [x, y, z] = random.cube();
        spheres.push([0.3 * x, 0.3 * y, 6.0 * z], 1.0 + 0.2 * random.unit(), None);
    }
    let mut scene = scene([0.0, 0.0, 16.0], 3.0, spheres);
    [scene.image.width, scene.image.height] = [256, 256];
    let window = Window { x0: 101, y0: 27, x1: 152, y1: 90 };
    for (_, mut renderer) in renderers() {
        for method in [None, Some(Method::Stable)] {
            let settings = Settings { method, aovs: Aov::ALL.to_vec(), ..Settings::default() };
            let full = renderer.render(&scene, &settings).expect("a frame");
            let crop = render(&mut renderer, &scene, &settings, window);
            assert_eq!(differing(&crop, &full, window), None, "{method:?}");
        }
    }
}

#[test]
fn the_tiles_of_a_frame_hold_all_its_pixels() {
    let (_, scene) = scenes().swap_remove(0);
    let settings = Settings { aovs: vec![Aov::Id, Aov::Distance], ..Settings::default() };
    for (_, mut renderer) in renderers() {
        let full = renderer.render(&scene, &settings).expect("a frame");
        let mut ids = vec![i32::MIN; full.ids().len()];
        let mut hits = 0;
        for number in 1..=6 {
            let window = Window::tile(number, 6, SIZE[0], SIZE[1]).expect("a tile");
            let tile = render(&mut renderer, &scene, &settings, window);
            hits += tile.report.hits;
            for (row, y) in tile.ids().chunks_exact(window.width() as usize).zip(window.y0..) {
                let start = (y * SIZE[0] + window.x0) as usize;
                ids[start..start + row.len()].copy_from_slice(row);
            }
        }
        assert_eq!((ids, hits), (full.ids().to_vec(), full.report.hits));
    }
}

#[test]
fn a_crop_outside_the_frame_is_refused() {
    let (_, scene) = scenes().swap_remove(0);
    for [x0, y0, x1, y1] in [[0, 0, SIZE[0] + 1, 1], [5, 5, 5, 6], [9, 0, 3, 1]] {
        let settings = Settings { window: Some(Window { x0, y0, x1, y1 }), ..Settings::default() };
        let error = cpu().render(&scene, &settings).map(drop).expect_err("no part of the frame");
        assert!(matches!(error, Error::Settings { .. }), "{error}");
    }
}
