//! The promises of samples: colour and alpha are the means of n x n samples of each pixel, the same on GPU and CPU, in every
//! crop and for a seed; all else stays the answer of the pixel's centre.
//!
//! Gold standards: the outline of a sphere straight ahead, which is a circle; the CPU path, bit for bit on adapters that round
//! as IEEE 754 does; the frame without samples; the full frame.

#[path = "common/bits.rs"]
mod bits;
mod common;
#[path = "common/cut.rs"]
mod cut;

use bits::Bits;
use common::{cpu, gpu};
use cut::cut;
use halfline::error::Error;
use halfline::frame::{Aov, Frame};
use halfline::intersect::Method;
use halfline::render::Renderer;
use halfline::scene::{ImagePlane, ReadOptions, Scene, Skipped, Spheres};
use halfline::settings::{Accuracy, Search, Settings};
use halfline::shade::Shade;
use halfline::window::Window;
use halfline::{Camera, Lens};
use std::path::Path;

/// Adapters whose every f32 operation was seen to round as IEEE 754 does.
const STRICT: [&str; 2] = ["llvmpipe", "SwiftShader"];

fn weekend() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/weekend.toml");
    let mut scene = Scene::read(&path, &ReadOptions::default()).expect("weekend");
    (scene.image.width, scene.image.height) = (61, 43);
    scene
}

/// The eye in a sphere that stands open to others: near spheres and front ones.
fn inside() -> Scene {
    let mut scene = weekend();
    scene.camera.lens = Lens::Vfov { degrees: 90.0, distance: 1.0 };
    scene.spheres.push((scene.camera.eye * 1.01).to_array(), 3.0, Some([0.9, 0.1, 0.1]));
    scene
}

fn asked(samples: u32, seed: u32) -> Settings {
    Settings { samples, seed, aovs: Aov::ALL.to_vec(), ..Settings::default() }
}

/// Every kind of answer, with 4 samples a pixel.
fn kinds(renderer: &mut Renderer) -> Vec<(String, Settings)> {
    let accuracy = |accuracy: Accuracy| (accuracy.name().to_owned(), Settings { accuracy, ..asked(4, 7) });
    let mut kinds = vec![accuracy(Accuracy::Certified), accuracy(Accuracy::Exact)];
    kinds.push(("certified, flat".into(), Settings { shade: Shade::Flat, ..kinds[0].1.clone() }));
    for method in common::admitted(renderer) {
        // SwiftShader takes long to compile normals in better arithmetic.
        let wide = [Method::Native64, Method::DoubleFloat].contains(&method);
        let shade = if wide { Shade::Flat } else { Shade::Headlight };
        for search in [Search::All, Search::Tiles] {
            let name = format!("{}, {}", method.name(), search.name());
            kinds.push((name, Settings { method: Some(method), search, shade, ..asked(4, 7) }));
        }
    }
    kinds
}

fn render(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Frame {
    renderer.render(scene, settings).expect("a frame")
}

#[test]
fn gpu_and_cpu_agree_on_samples() {
    let Some(mut gpu) = gpu() else { return };
    let strict = STRICT.iter().any(|name| gpu.adapter().contains(name));
    for (name, scene) in [("weekend", weekend()), ("inside", inside())] {
        for (kind, settings) in kinds(&mut gpu) {
            let (a, b) = (render(&mut gpu, &scene, &settings), render(&mut cpu(), &scene, &settings));
            assert_eq!((a.report.backend, b.report.backend), ("gpu", "cpu"));
            let same = |aov: Aov| a.bits(aov) == b.bits(aov);
            // Hits and misses of certified frames are the truth on any adapter.
            assert!(same(Aov::Alpha) || !strict && a.report.accuracy == "fast", "{name}, {kind}");
            // A certified cosine is of (x, y, -1), whose squares lavapipe's compiler adds in another order: some ten
            // roundings of 2^-23.
            let shaded = kind == "certified" && settings.shade == Shade::Headlight;
            let colors = [&a, &b].map(|frame| frame.f32(Aov::Color).expect("asked for"));
            let close = colors[0].iter().zip(colors[1]).all(|(a, b)| (a - b).abs() < 2e-6);
            assert!(same(Aov::Color) || shaded && close || !strict, "{name}, {kind}");
            let alpha = a.f32(Aov::Alpha).expect("asked for");
            assert!(name == "inside" || alpha.iter().any(|x| *x > 0.0 && *x < 1.0), "some pixels are covered in part");
        }
    }
}

/// What no sample touches has the bits of a frame without them; where nothing changes within a pixel, neither do colours.
#[test]
fn everything_else_is_the_pixels_centre() {
    for mut renderer in [Some(cpu()), gpu()].into_iter().flatten() {
        for method in [None, Some(Method::Stable)] {
            let settings = |samples| Settings { method, shade: Shade::Flat, ..asked(samples, 0) };
            let (plain, nine) =
                (render(&mut renderer, &weekend(), &settings(1)), render(&mut renderer, &weekend(), &settings(7)));
            assert_eq!((plain.report.samples, nine.report.samples), (1, 9), "the next square");
            for aov in Aov::ALL.into_iter().filter(|aov| ![Aov::Color, Aov::Alpha].contains(aov)) {
                assert!(plain.bits(aov) == nine.bits(aov), "{aov}");
            }
            assert_eq!((plain.report.hits, plain.report.rays), (nine.report.hits, nine.report.rays));
            let (alpha, [a, b]) = (nine.f32(Aov::Alpha).expect("asked"), [&plain, &nine].map(|f| f.f32(Aov::Color)));
            let (a, b) = (a.expect("asked"), b.expect("asked"));
            let sky: Vec<_> = (0..alpha.len()).filter(|k| alpha[*k] == 0.0).collect();
            assert!(sky.len() > 100 && sky.iter().all(|k| b[3 * k..3 * k + 3] == weekend().image.background));
            let kept = (0..alpha.len()).filter(|k| a[3 * k..3 * k + 3] == b[3 * k..3 * k + 3]).count();
            assert!(kept > alpha.len() / 4 && kept < alpha.len() - 100, "{kept} colours are what they were");
        }
    }
}

/// How much of the pixel [x, x + 1] x [y, y + 1] lies in the disc of this radius about the origin: midpoints of 1000 rows,
/// within 1e-4.
fn covered(x: f64, y: f64, radius: f64) -> f64 {
    let row = |n: u32| {
        let v = y + (f64::from(n) + 0.5) / 1000.0;
        let half = (radius * radius - v * v).max(0.0).sqrt();
        (half.min(x + 1.0) - (-half).max(x)).max(0.0)
    };
    (0..1000).map(row).sum::<f64>() / 1000.0
}

/// A sphere straight ahead is a circle. A square of the n x n of a pixel that the outline does not cut is counted right; of
/// those that it cuts, at most 3 n in a pixel (an arc that turns once crosses so many) and 8 r n in all (a circle of r
/// pixels), each is a coin whose deviation is 1/2 at most. Tolerance: five deviations for the sum, six for the worst of
/// some thousand pixels.
#[test]
fn alpha_converges_to_what_is_covered() {
    let mut spheres = Spheres::default();
    spheres.push([0.0, 0.0, -3.0], 1.0, None);
    let image = ImagePlane { width: 64, height: 64, background: [0.0; 3] };
    let scene = Scene { camera: Camera::CANONICAL, image, spheres, skipped: Skipped::default() };
    let radius = 64.0 / f64::sqrt(8.0);
    let place = |n: usize| n as f64 - 32.0;
    let exact: Vec<f64> = (0..4096).map(|k| covered(place(k % 64), place(k / 64), radius)).collect();
    let area: f64 = exact.iter().sum();
    assert!((area - std::f64::consts::PI * radius * radius).abs() < 1e-2, "{area}");
    for mut renderer in [Some(cpu()), gpu()].into_iter().flatten() {
        for n in [1u32, 2, 4, 8, 16] {
            let settings = Settings { aovs: vec![Aov::Alpha], ..asked(n * n, 5) };
            let frame = render(&mut renderer, &scene, &settings);
            let alpha = frame.f32(Aov::Alpha).expect("asked for");
            let off = alpha.iter().zip(&exact).map(|(a, b)| (f64::from(*a) - b).abs());
            let (worst, sum) = (off.fold(0.0, f64::max), alpha.iter().map(|a| f64::from(*a)).sum::<f64>());
            let n = f64::from(n);
            let (of_sum, of_one) = ((2.0 * radius * n).sqrt() / (n * n), (0.75 * n).sqrt() / (n * n));
            println!("{n} x {n}: {sum} of {area}, worst pixel {worst}");
            assert!((sum - area).abs() < 5.0 * of_sum, "{n} x {n}: {sum} of {area}");
            assert!(worst < 6.0 * of_one, "{n} x {n}: {worst}");
        }
    }
}

#[test]
fn the_seed_chooses_the_samples_and_nothing_else() {
    for mut renderer in [Some(cpu()), gpu()].into_iter().flatten() {
        let [a, b, again] = [1, 2, 1].map(|seed| render(&mut renderer, &weekend(), &asked(4, seed)));
        assert!(Aov::ALL.into_iter().all(|aov| a.bits(aov) == again.bits(aov)), "one seed, one picture");
        assert!(a.bits(Aov::Color) != b.bits(Aov::Color) && a.bits(Aov::Alpha) != b.bits(Aov::Alpha));
        assert!(a.ids() == b.ids());
    }
}

#[test]
fn a_crop_has_the_samples_of_the_full_frame() {
    let windows = [[0, 0, 1, 1], [60, 42, 61, 43], [5, 9, 30, 31], [17, 0, 18, 43]];
    for mut renderer in [Some(cpu()), gpu()].into_iter().flatten() {
        for (name, scene) in [("weekend", weekend()), ("inside", inside())] {
            for (kind, settings) in kinds(&mut renderer) {
                let full = render(&mut renderer, &scene, &settings);
                for window in windows.map(|[x0, y0, x1, y1]| Window { x0, y0, x1, y1 }) {
                    let settings = Settings { window: Some(window), ..settings.clone() };
                    let crop = render(&mut renderer, &scene, &settings);
                    for aov in Aov::ALL {
                        assert!(crop.bits(aov) == cut(&full, aov, window), "{name}, {kind}, crop {window}: {aov}");
                    }
                }
            }
        }
    }
}

#[test]
fn more_samples_than_a_frame_can_be_cut_into_are_refused() {
    let mut scene = weekend();
    (scene.image.width, scene.image.height) = (1 << 18, 1);
    let error = cpu().render(&scene, &asked(17, 0)).map(drop).expect_err("5 x 2^18 columns");
    assert!(matches!(error, Error::Limits { .. }) && error.to_string().contains("at most 16"), "{error}");
    let ids = Settings { aovs: vec![Aov::Id], ..asked(16, 0) };
    assert_eq!(render(&mut cpu(), &weekend(), &ids).report.samples, 1, "nobody asked what samples are for");
}
