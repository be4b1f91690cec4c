//! The promises of samples: colour and alpha are the means of n x n samples of each pixel, the same on GPU and CPU, in every
//! crop and for a seed; all other buffers have the values at the pixel's centre.
//!
//! Gold standards: the outline of a sphere straight ahead, which is a circle; the CPU path, bit for bit on adapters that round
//! as IEEE 754 does; the frame with one sample; the full frame.

use crate::adapter::{admitted, cpu, gpu_or_skip, is_strict, renderers};
use crate::bits::Bits;
use crate::weekend;
use glam::DVec3;
use halfline::error::Error;
use halfline::frame::{Aov, Frame};
use halfline::intersect::Method;
use halfline::render::Renderer;
use halfline::scene::{ImagePlane, Light, LightSource, Scene, Sky, Spheres};
use halfline::settings::{Accuracy, Backend, Settings};
use halfline::shade::Shade;
use halfline::window::Window;
use halfline::{Camera, Lens};

/// A small image of the scene, with a light: shadows need one, and with the file's light every sample would have a ray to it.
fn weekend() -> Scene {
    let mut scene = weekend::weekend();
    (scene.image.width, scene.image.height) = (61, 43);
    scene.lighting.lights = vec![Light::white(LightSource::Direction(DVec3::new(1.0, 2.0, 0.5)))];
    scene
}

/// The eye inside a sphere that others overlap.
fn inside() -> Scene {
    let mut scene = weekend();
    scene.camera.lens = Lens::Vfov { degrees: 90.0, distance: 1.0 };
    scene.spheres.push((scene.camera.eye * 1.01).to_array(), 3.0, Some([0.9, 0.1, 0.1]));
    scene
}

fn sampled(samples: u32, seed: u32) -> Settings {
    // Few rays to the sky: the judge takes a millisecond for each.
    let sky = Sky { rays: 2, ..Sky::default() };
    Settings { samples, seed, sky, aovs: Aov::ALL.to_vec(), ..Settings::default() }
}

/// Settings for every accuracy and method, with 4 samples a pixel.
fn kinds(renderer: &mut Renderer) -> Vec<(String, Settings)> {
    let accuracy = |accuracy: Accuracy| (accuracy.name().to_owned(), Settings { accuracy, ..sampled(4, 7) });
    let mut kinds = vec![accuracy(Accuracy::Certified), accuracy(Accuracy::Exact), accuracy(Accuracy::Fast)];
    kinds.push(("certified, flat".into(), Settings { shade: Shade::Flat, ..kinds[0].1.clone() }));
    for method in admitted(renderer) {
        // SwiftShader takes long to compile normals in wider arithmetic.
        let wide = [Method::Native64, Method::DoubleFloat].contains(&method);
        let shade = if wide { Shade::Flat } else { Shade::Headlight };
        kinds.push((method.name().to_owned(), Settings { method: Some(method), shade, ..sampled(4, 7) }));
    }
    kinds
}

fn render(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Frame {
    renderer.render(scene, settings).expect("a frame")
}

#[test]
fn gpu_and_cpu_agree_on_samples() {
    let Some(mut gpu) = gpu_or_skip() else { return };
    let strict = is_strict(&gpu);
    for (name, scene) in [("weekend", weekend()), ("inside", inside())] {
        for (kind, settings) in kinds(&mut gpu) {
            let (a, b) = (render(&mut gpu, &scene, &settings), render(&mut cpu(), &scene, &settings));
            assert_eq!((a.report.backend, b.report.backend), ("gpu", "cpu"));
            let same = |aov: Aov| a.bits(aov) == b.bits(aov);
            // Certified frames have exact hits and misses on any adapter.
            assert!(same(Aov::Alpha) || !strict && a.report.accuracy == "fast", "{name}, {kind}");
            // A certified cosine uses (x, y, -1), whose squares lavapipe's compiler adds in another order: some ten
            // roundings of 2^-23.
            let shaded = kind == "certified" && settings.shade == Shade::Headlight;
            let colors = [&a, &b].map(|frame| frame.f32(Aov::Color).expect("a requested buffer"));
            let close = colors[0].iter().zip(colors[1]).all(|(a, b)| (a - b).abs() < 2e-6);
            assert!(same(Aov::Color) || shaded && close || !strict, "{name}, {kind}");
            let alpha = a.f32(Aov::Alpha).expect("a requested buffer");
            assert!(name == "inside" || alpha.iter().any(|x| *x > 0.0 && *x < 1.0), "some pixels are partly covered");
        }
    }
}

/// Buffers that are not averaged have the bits of a frame with one sample, and so have colours that are constant in a pixel.
#[test]
fn other_buffers_have_the_values_at_the_pixels_centre() {
    for (backend, mut renderer) in renderers() {
        // The kernel of samples is another one, which other adapters may round in another way: certified ids are the same in any kernel.
        let strict = backend == Backend::Cpu || is_strict(&renderer);
        for method in [None, Some(Method::Stable)].into_iter().take(if strict { 2 } else { 1 }) {
            let settings = |samples| Settings { method, shade: Shade::Flat, ..sampled(samples, 0) };
            let (plain, nine) =
                (render(&mut renderer, &weekend(), &settings(1)), render(&mut renderer, &weekend(), &settings(7)));
            assert_eq!((plain.report.samples, nine.report.samples), (1, 9), "the next square");
            let others = Aov::ALL.into_iter().filter(|aov| ![Aov::Color, Aov::Alpha].contains(aov));
            for aov in others.filter(|aov| strict || [Aov::Id, Aov::Mask].contains(aov)) {
                assert!(plain.bits(aov) == nine.bits(aov), "{aov}");
            }
            assert_eq!((plain.report.hits, plain.report.rays), (nine.report.hits, nine.report.rays));
            let (alpha, [a, b]) =
                (nine.f32(Aov::Alpha).expect("a requested buffer"), [&plain, &nine].map(|f| f.f32(Aov::Color)));
            let (a, b) = (a.expect("a requested buffer"), b.expect("a requested buffer"));
            let sky: Vec<_> = (0..alpha.len()).filter(|k| alpha[*k] == 0.0).collect();
            assert!(sky.len() > 100 && sky.iter().all(|k| b[3 * k..3 * k + 3] == weekend().image.background));
            let kept = (0..alpha.len()).filter(|k| a[3 * k..3 * k + 3] == b[3 * k..3 * k + 3]).count();
            assert!(kept > alpha.len() / 4 && kept < alpha.len() - 100, "{kept} colours are unchanged");
        }
    }
}

/// Spheres in pure red, green and blue with flat shading: the mean of a channel is the share of the samples that show one of them.
/// Sixteen samples have exact shares.
#[test]
fn coverage_has_the_samples_that_show_each_sphere() {
    let (camera, mut spheres) = (Camera::CANONICAL, Spheres::default());
    for (n, color) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().cycle().take(60).enumerate() {
        let at = |k: usize| ((n * k) % 61) as f64 / 61.0 - 0.5;
        spheres.push([4.0 * at(7), 3.0 * at(11), -3.0 + at(23)], 0.2 + 0.1 * at(3), Some(color));
    }
    let image = ImagePlane { width: 48, height: 36, background: [0.0; 3] };
    let scene = Scene { camera, image, spheres, lighting: Default::default() };
    for (backend, mut renderer) in renderers() {
        for (samples, window) in [(16, None), (1, None), (16, Some(Window { x0: 5, y0: 9, x1: 40, y1: 30 }))] {
            let aovs = vec![Aov::Color, Aov::Alpha];
            let settings =
                Settings { samples, window, aovs, coverage: true, shade: Shade::Flat, ..Settings::default() };
            let frame = render(&mut renderer, &scene, &settings);
            let coverage = frame.coverage.as_ref().expect("it was requested");
            assert_eq!((coverage.samples, coverage.rows.len()), (samples, frame.height as usize), "{backend:?}");
            let mut means = vec![0.0; 3 * (frame.width * frame.height) as usize];
            for (y, row) in coverage.rows.iter().enumerate() {
                for cover in row {
                    let pixel = y * frame.width as usize + cover.column as usize;
                    means[3 * pixel + cover.id as usize % 3] += cover.samples as f32 / samples as f32;
                }
            }
            assert!(frame.f32(Aov::Color) == Some(&means), "{backend:?}, {samples} samples of {window:?}");
            let partly = means.iter().filter(|share| **share > 0.0 && **share < 1.0).count();
            assert!((partly > 100) == (samples > 1), "{partly} edges");
        }
        let mut clear = scene.clone();
        clear.spheres.opacities = Some(vec![0.5; 60].into());
        let settings = Settings { coverage: true, aovs: vec![Aov::Color], ..Settings::default() };
        let error = renderer.render(&clear, &settings).expect_err("no first hit alone").to_string();
        assert!(error.contains("cryptomatte") && error.contains("opacity"), "{error}");
    }
}

/// The part of the pixel [x, x + 1] x [y, y + 1] inside the disc of this radius about the origin, by the midpoints of 1000
/// rows: within 1e-4.
fn covered(x: f64, y: f64, radius: f64) -> f64 {
    let row = |n: u32| {
        let v = y + (f64::from(n) + 0.5) / 1000.0;
        let half = (radius * radius - v * v).max(0.0).sqrt();
        (half.min(x + 1.0) - (-half).max(x)).max(0.0)
    };
    (0..1000).map(row).sum::<f64>() / 1000.0
}

/// A sphere straight ahead is a circle. Of the n x n squares of a pixel, those that the outline does not cross are counted
/// exactly. It crosses at most 3 n in a pixel and 8 r n in all (a circle of r pixels); each of them is a random variable with
/// a standard deviation of at most 1/2. Tolerance: five deviations for the sum, six for the worst of some thousand pixels.
#[test]
fn alpha_converges_to_the_covered_area() {
    let mut spheres = Spheres::default();
    spheres.push([0.0, 0.0, -3.0], 1.0, None);
    let image = ImagePlane { width: 64, height: 64, background: [0.0; 3] };
    let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
    let radius = 64.0 / f64::sqrt(8.0);
    let place = |n: usize| n as f64 - 32.0;
    let exact: Vec<f64> = (0..4096).map(|k| covered(place(k % 64), place(k / 64), radius)).collect();
    let area: f64 = exact.iter().sum();
    assert!((area - std::f64::consts::PI * radius * radius).abs() < 1e-2, "{area}");
    for (_, mut renderer) in renderers() {
        for n in [1u32, 2, 4, 8, 16] {
            let settings = Settings { aovs: vec![Aov::Alpha], ..sampled(n * n, 5) };
            let frame = render(&mut renderer, &scene, &settings);
            let alpha = frame.f32(Aov::Alpha).expect("a requested buffer");
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
    for (_, mut renderer) in renderers() {
        let [a, b, again] = [1, 2, 1].map(|seed| render(&mut renderer, &weekend(), &sampled(4, seed)));
        assert!(Aov::ALL.into_iter().all(|aov| a.bits(aov) == again.bits(aov)), "the same seed gives the same frame");
        assert!(a.bits(Aov::Color) != b.bits(Aov::Color) && a.bits(Aov::Alpha) != b.bits(Aov::Alpha));
        assert!(a.ids() == b.ids());
    }
}

#[test]
fn a_crop_has_the_samples_of_the_full_frame() {
    let windows = [[0, 0, 1, 1], [60, 42, 61, 43], [5, 9, 30, 31], [17, 0, 18, 43]];
    for (_, mut renderer) in renderers() {
        for (name, scene) in [("weekend", weekend()), ("inside", inside())] {
            for (kind, settings) in kinds(&mut renderer) {
                let full = render(&mut renderer, &scene, &settings);
                for window in windows.map(|[x0, y0, x1, y1]| Window { x0, y0, x1, y1 }) {
                    let settings = Settings { window: Some(window), ..settings.clone() };
                    let crop = render(&mut renderer, &scene, &settings);
                    for aov in Aov::ALL {
                        assert!(crop.bits(aov) == full.bits_in(window, aov), "{name}, {kind}, crop {window}: {aov}");
                    }
                }
            }
        }
    }
}

#[test]
fn more_samples_than_a_row_can_have_are_refused() {
    let mut scene = weekend();
    (scene.image.width, scene.image.height) = (1 << 18, 1);
    let error = cpu().render(&scene, &sampled(17, 0)).map(drop).expect_err("5 x 2^18 columns");
    assert!(matches!(error, Error::Limits { .. }) && error.to_string().contains("at most 16"), "{error}");
    let ids = Settings { aovs: vec![Aov::Id], ..sampled(16, 0) };
    assert_eq!(render(&mut cpu(), &weekend(), &ids).report.samples, 1, "ids need one sample");
}
