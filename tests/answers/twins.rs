//! The promise: a kernel and its CPU twin give the same answer, bit for bit where the adapter rounds as IEEE 754 does.
//!
//! Gold standard: the twin, in Rust's f32. Tolerance on adapters that are known to do so: none. On any other every operation may
//! round either way, and division be off by 2.5 ulp. The predicted errors (docs/accuracy.md) hold for either twin, so these differ
//! by at most twice as much: ids at the pixels between two outlines, distances where ids agree. Where outlines are predicted to
//! be visibly off ([`VISIBLE`]) the form has lost its digits in this scene, as the lecture's forms do far from a sphere
//! (docs/accuracy.md): either answer is as wrong as the other, and nothing is promised.

use crate::adapter::{self, admitted, cpu, gpu_or_skip, is_strict};
use crate::amount::{amount, everything};
use crate::bits::Bits;
use crate::cloud;
use crate::home::home;
use crate::oblique::{self, vfov};
use crate::rng::Rng;
use glam::DVec3;
use halfline::frame::{Aov, Data, Frame};
use halfline::intersect::Method;
use halfline::render::Renderer;
use halfline::scene::{Scene, Spheres};
use halfline::settings::Settings;
use halfline::shade::Shade;
use halfline_files::read::ReadOptions;

/// The buffers that a kernel writes, and those that are derived from them.
const AOVS: [Aov; 7] = [Aov::Color, Aov::Distance, Aov::Depth, Aov::Normal, Aov::Position, Aov::Id, Aov::Mask];

/// The predicted error of outlines, in radii, and of distances up to which twins are compared on adapters that do not keep bits: that
/// from which frames have a warning.
pub(crate) const VISIBLE: f64 = 0.02;

/// The least tolerance of outlines, in radii, and of distances, relative: a pixel or two of these small images, in
/// which outlines pass centres of pixels.
const MIN_TOLERANCE: f64 = 5e-5;

fn settings(method: Method, shade: Shade) -> Settings {
    Settings { method: Some(method), shade, aovs: AOVS.to_vec(), ..Settings::default() }
}

fn scene(eye: [f64; 3], at: [f64; 3], degrees: f64, spheres: Spheres) -> Scene {
    oblique::scene([97, 61], eye, at, vfov(degrees), spheres)
}

/// Spheres with or without colours.
fn cloud(seed: u64, count: usize, at: [f64; 3], side: f64, r: f64, colored: bool) -> Spheres {
    let spheres = cloud::cloud(seed, count, at, side, r);
    let colors = spheres.colors.clone().filter(|_| colored);
    Spheres { colors, ..spheres }
}

/// The project's own scenes, small, and random ones at many scales, with and without colours; sphere counts that are
/// not multiples of any subgroup size.
fn scenes() -> Vec<(String, Scene)> {
    let folder = home().join("scenes");
    let mut scenes = Vec::new();
    for entry in folder.read_dir().expect("scenes/") {
        let path = entry.expect("an entry").path();
        let mut scene = halfline_files::read::scene(&path, &ReadOptions::default()).expect("a good scene").scene;
        (scene.image.width, scene.image.height) = if everything() { (131, 74) } else { (67, 37) };
        scenes.push((path.display().to_string(), scene));
    }
    assert!(scenes.len() >= 4, "{} scenes", scenes.len());
    let mut add = |name: &str, scene| scenes.push((name.to_owned(), scene));
    add("nothing", scene([0.0; 3], [0.0, 0.0, -1.0], 50.0, Spheres::default()));
    add("a cloud", scene([3.0, 2.0, 4.0], [0.0; 3], 40.0, cloud(1, 61, [0.0; 3], 1.0, 0.05, true)));
    add("the eye in a cloud", scene([0.1, 0.2, 0.3], [1.0, 0.0, 0.0], 120.0, cloud(2, 83, [0.0; 3], 1.0, 0.1, false)));
    add("far and small", scene([1e6, -2e6, 3e6], [0.0; 3], 4e-5, cloud(3, 40, [0.0; 3], 1.0, 0.1, true)));
    let small = cloud(4, 17, [1e-20, 0.0, -3e-20], 1e-20, 1e-21, false);
    add("r = 1e-21", scene([4e-20, 3e-20, 2e-20], [1e-20, 0.0, -3e-20], 40.0, small));
    let large = cloud(5, 17, [1e20, 0.0, -3e20], 1e20, 1e19, true);
    add("r = 1e19", scene([4e20, 3e20, 2e20], [1e20, 0.0, -3e20], 40.0, large));
    scenes
}

fn frame(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Frame {
    renderer.render(scene, settings).expect("a frame")
}

/// The number of values with different bits in all buffers, and the position of the first.
fn differing(a: &Frame, b: &Frame) -> (usize, String) {
    let mut count = 0;
    let mut first = String::new();
    for aov in AOVS {
        let (a, b) = (a.bits(aov), b.bits(aov));
        assert_eq!(a.len(), b.len(), "{aov}");
        let wrong: Vec<_> = (0..a.len()).filter(|&k| a[k] != b[k]).collect();
        if let (Some(&k), true) = (wrong.first(), first.is_empty()) {
            first = format!("{aov}[{k}]: {:x} and {:x}", a[k], b[k]);
        }
        count += wrong.len();
    }
    (count, first)
}

/// The tolerance for adapters that are not known to round as IEEE 754 does: two outlines that are off by `outline` radii to
/// either side enclose 4 `outline` of a disc, and two distances differ by twice `distance`.
fn near(a: &Frame, b: &Frame, [outline, distance]: [f64; 2]) -> bool {
    let (ids, others) = (a.ids(), b.ids());
    let same: Vec<_> = (0..ids.len()).filter(|&k| ids[k] == others[k]).collect();
    let (t, u) = (a.f64(Aov::Depth).expect("a requested buffer"), b.f64(Aov::Depth).expect("a requested buffer"));
    let close = |&k: &usize| t[k] == u[k] || (t[k] - u[k]).abs() <= 2.0 * distance * u[k].abs();
    (ids.len() - same.len()) as f64 <= 4.0 * outline * ids.len() as f64 && same.iter().all(close)
}

#[test]
fn gpu_and_cpu_agree_for_every_scene_method_and_shading() {
    let Some(mut gpu) = gpu_or_skip() else { return };
    let mut cpu = cpu();
    let strict = is_strict(&gpu);
    println!("comparing bit for bit: {strict}");
    let (mut hits, mut compared, mut lost) = (0, 0, 0);
    let methods = admitted(&mut gpu);
    // Every pair of a method and a shading, and every pair of a scene and a method.
    let count = amount("shadings of a scene by a method", [1, 1, Shade::ALL.len()]);
    for (n, (name, scene)) in scenes().into_iter().enumerate() {
        for (m, &method) in methods.iter().enumerate() {
            for shade in (0..count).map(|k| Shade::ALL[(n + m + k) % Shade::ALL.len()]) {
                let settings = settings(method, shade);
                let (a, b) = (frame(&mut gpu, &scene, &settings), frame(&mut cpu, &scene, &settings));
                assert_eq!((a.report.backend, b.report.backend), ("gpu", "cpu"), "no frame is compared with itself");
                let (count, first) = differing(&a, &b);
                hits += a.report.hits;
                let predicted =
                    a.report.predicted.map_or([0.0; 2], |predicted| [predicted.outline, predicted.distance]);
                let is_lost = predicted.iter().any(|error| *error > VISIBLE);
                if !strict && is_lost {
                    lost += 1;
                    continue;
                }
                compared += 1;
                let same =
                    if strict { count == 0 } else { near(&a, &b, predicted.map(|error| error.max(MIN_TOLERANCE))) };
                let what = format!("{name}, {}, {}", method.name(), shade.name());
                assert!(same, "{what}: {count} values differ, first {first}, predicted {predicted:?}");
            }
        }
    }
    let enough = if everything() { 100_000 } else { 10_000 };
    assert!(hits > enough, "the scenes have hits: {hits}");
    println!("{compared} frames compared, {lost} whose method loses its digits");
    assert!(compared > lost, "{compared} frames compared, {lost} not");
}

/// Negative control: one changed bit.
#[test]
fn a_planted_difference_is_found() {
    let (_, scene) = scenes().swap_remove(0);
    let a = frame(&mut cpu(), &scene, &settings(Method::Stable, Shade::Flat));
    for aov in AOVS {
        let mut b = a.clone();
        let buffer = b.buffers.iter_mut().find(|buffer| buffer.aov == aov).expect("a requested buffer");
        match &mut buffer.data {
            Data::F32(v) => v[33] = f32::from_bits(v[33].to_bits() ^ 1),
            Data::F64(v) => v[33] = f64::from_bits(v[33].to_bits() ^ 1),
            Data::I32(v) => v[33] ^= 1,
            Data::U8(v) => v[33] ^= 1,
            _ => panic!("a new type of data"),
        }
        assert_eq!(differing(&a, &b).0, 1, "{aov}");
    }
}

/// A frame of several dispatches has the pixels of one.
#[test]
fn a_frame_beyond_one_binding_agrees_with_the_cpu() {
    let Some(mut gpu) = gpu_or_skip() else { return };
    // 13 million pixels of three floats are more than one 128 MiB binding.
    let mut scene = scene([3.0, 2.0, 4.0], [0.0; 3], 40.0, cloud(6, 3, [0.0; 3], 1.0, 0.2, true));
    (scene.image.width, scene.image.height) = (4800, 2700);
    let settings = Settings { aovs: vec![Aov::Normal, Aov::Depth], ..Settings::default() };
    let (a, b) = (frame(&mut gpu, &scene, &settings), frame(&mut cpu(), &scene, &settings));
    // Certified: distances within 1e-5 each.
    assert!(near(&a, &b, [0.0, 1e-5]));
    assert!(a.ids().contains(&2) && a.report.hits > 100_000);
}

/// Rays from one point, from a few and from many, against the twin and against the known distance.
#[test]
fn given_rays_hit_their_targets() {
    let Some(mut gpu) = gpu_or_skip() else { return };
    let methods = admitted(&mut gpu);
    let strict = is_strict(&gpu);
    let mut random = Rng::new(7);
    let spheres = cloud(8, 50, [2e5, -1e5, 4e5], 5e5, 1e3, false);
    let targets: Vec<usize> = (0..3000).map(|_| (random.unit() * 50.0) as usize).collect();
    let spread: Vec<[f64; 3]> = targets.iter().map(|_| random.cube().map(|x| 1e6 * x)).collect();
    let few: Vec<_> = (0..targets.len()).map(|n| spread[n % 5]).collect();
    for (name, origins) in [("one", vec![[1.0, 2.0, 3.0]]), ("few", few), ("many", spread)] {
        let from = |n: usize| DVec3::from_array(if origins.len() == 1 { origins[0] } else { origins[n] });
        let aimed = |(n, &k): (usize, &usize)| ((DVec3::from_array(spheres.centers[k]) - from(n)) * 3e-7).to_array();
        let directions: Vec<_> = targets.iter().enumerate().map(aimed).collect();
        for &method in &methods {
            let settings = Settings { method: Some(method), aovs: vec![Aov::Normal], ..Settings::default() };
            let mut answers = Vec::new();
            for mut renderer in [adapter::gpu().expect("an adapter"), cpu()] {
                let hits = renderer.trace(&spheres, &origins, &directions, &settings).expect("hits");
                for (n, &k) in targets.iter().enumerate() {
                    // The hit is at most as far as the target, and its surface faces the ray; where it is the target,
                    // the hit lies one radius before its centre.
                    let d = DVec3::from_array(directions[n]);
                    let length = (DVec3::from_array(spheres.centers[k]) - from(n)).length();
                    let reach = hits.t[n] * d.length();
                    let what = format!("{name}, {}, ray {n}: {reach} of {length}", method.name());
                    // The squares of 1e6 that the lecture's forms subtract are off by up to 8 roundings of 2^-23, more than 1e3 squared.
                    let forms = [Method::Textbook, Method::Unit, Method::Geometric];
                    // Then a sphere is lost, or its surface is where its centre is.
                    let loses = !strict && forms.contains(&method);
                    if loses && hits.id[n] < 0 {
                        continue;
                    }
                    let most = if loses { length * (1.0 + 2e-3) } else { length };
                    assert!(hits.id[n] >= 0 && reach <= most, "{what}");
                    let normal = hits.normal.as_ref().expect("a requested buffer")[n];
                    let normal = DVec3::from_array(normal.map(f64::from));
                    assert!(loses || normal.dot(d) < 0.0, "{what}: normal {normal}");
                    if hits.id[n] == k as i32 && length > spheres.radii[k] {
                        // 2e-3: the lecture's methods lose half of f32's digits at 1e3 radii.
                        let bound = match method {
                            Method::Stable => 1e-6,
                            // The directions are f64, and the rays miss the centres by their rounding.
                            Method::Native64 | Method::DoubleFloat => 1e-12,
                            _ => 2e-3,
                        };
                        let off = (reach - (length - spheres.radii[k])).abs() / length;
                        assert!(off <= bound, "{what}: off by {off}");
                    }
                }
                answers.push(hits);
            }
            assert!(!strict || answers[0] == answers[1], "{name}, {}: twins differ", method.name());
        }
    }
}

#[test]
fn invalid_rays_are_refused() {
    let spheres = cloud(9, 3, [0.0; 3], 1.0, 0.1, false);
    let trace = |o: &[[f64; 3]], d: &[[f64; 3]]| cpu().trace(&spheres, o, d, &Settings::default());
    assert!(trace(&[[0.0; 3]], &[]).expect("no rays, no hits").id.is_empty());
    trace(&[[0.0; 3]; 2], &[[1.0; 3]; 3]).expect_err("2 origins, 3 directions");
    trace(&[[0.0; 3]], &[[0.0; 3]]).expect_err("a zero direction");
    trace(&[[f64::NAN; 3]], &[[1.0; 3]]).expect_err("an origin of NaN");
    trace(&[[0.0; 3]], &[[f64::INFINITY, 0.0, 0.0]]).expect_err("an infinite direction");
}
