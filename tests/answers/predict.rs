//! The promise of a prediction: no error of any method is larger than predicted, and on ordinary scenes the prediction is at
//! most 100 times the largest error.
//!
//! Gold standard: exact arithmetic, through `measure::score`. Both predicted numbers are bounds for all rays, so the errors
//! of one frame depend on how closely its rays graze. The second test therefore takes ordinary scenes and changes each
//! radius by less than a third, so that a pixel's ray grazes the sphere within the predicted outline. A narrow field of view
//! straight ahead stays far below a bound for all views: through 25 degrees (jacks.nff) the small components of p and d
//! have small errors, and f64 shows less than a hundredth.

use super::extremes;
use crate::adapter::{admitted, cpu, gpu};
use crate::amount::amount;
use crate::home::home;
use crate::nff;
use crate::rng::Rng;
use glam::DVec3;
use halfline::camera::{Camera, Lens, Look};
use halfline::exact::Judge;
use halfline::frame::Aov;
use halfline::intersect::Method;
use halfline::predict::Prediction;
use halfline::render::Renderer;
use halfline::scene::{ImagePlane, Scene, Spheres};
use halfline::settings::Settings;
use halfline_files::read::ReadOptions;
use halfline_measure::score::Truths;
use halfline_measure::suite::extremes::FAMILIES;

const SEED: u64 = 0x5eed_0003;

/// The largest ratio of a prediction to the error of an ordinary scene.
const SLACK: f64 = 100.0;

fn settings(method: Method) -> Settings {
    Settings { method: Some(method), aovs: vec![Aov::Distance, Aov::Normal], ..Settings::default() }
}

/// Every backend that is present, and the methods that run there.
fn places() -> Vec<(&'static str, Vec<Method>, Renderer)> {
    let mut places = vec![("cpu", Method::ALL.to_vec(), cpu())];
    if let Some(mut gpu) = gpu() {
        places.push(("gpu", admitted(&mut gpu), gpu));
    }
    places
}

/// An error as a share of its prediction; 0 where the prediction is infinite.
fn share([error, predicted]: [f64; 2]) -> f64 {
    if predicted.is_infinite() { 0.0 } else { error / predicted }
}

/// The largest errors of outline and distance of `method` on `scene` in all `places`, as shares of their predictions; and a
/// message for each above 1.
fn shares(
    what: &str,
    (scene, truths): (&Scene, &Truths),
    method: Method,
    places: &mut [(&str, Vec<Method>, Renderer)],
) -> ([f64; 2], Vec<String>) {
    let predicted = Prediction::of(scene, method).expect("a good scene").expect("spheres");
    let (mut worst, mut faulty) = ([0.0f64; 2], Vec::new());
    for (place, methods, renderer) in places {
        if !methods.contains(&method) {
            continue;
        }
        let frame = renderer.render(scene, &settings(method)).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_eq!(frame.report.backend, *place);
        assert_eq!(frame.report.predicted, Some(predicted), "the report has the same prediction");
        let errors = truths.score(&frame).expect("a frame of this scene").given(&predicted).errors();
        let [outline, distance] = [errors.outline, errors.relative.max].map(|x| x.unwrap_or(f64::INFINITY));
        if !(outline <= predicted.outline && distance <= predicted.distance) {
            let name = method.name();
            faulty.push(format!("{what}, {name}, {place}: saw {outline:e} and {distance:e} of {predicted:?}"));
        }
        worst[0] = worst[0].max(share([outline, predicted.outline]));
        worst[1] = worst[1].max(share([distance, predicted.distance]));
    }
    (worst, faulty)
}

fn words(worst: &[[f64; 2]]) -> String {
    let each = Method::ALL
        .iter()
        .zip(worst)
        .map(|(m, [outline, distance])| format!("{} {outline:.4} {distance:.4}", m.name()));
    each.collect::<Vec<_>>().join("; ")
}

#[test]
fn no_error_is_larger_than_predicted() {
    let mut places = places();
    let (mut faulty, mut compared) = (Vec::new(), 0);
    // Each scene with some of the methods, and each method with some scenes of each family.
    let thirds = amount("methods of a scene, in thirds", [1, 2, 3]);
    println!("largest outline and distance as shares of their prediction");
    for family in FAMILIES {
        let mut worst = vec![[0.0f64; 2]; Method::ALL.len()];
        for (n, scene) in extremes::scenes(family, SEED).iter().enumerate() {
            compared += 1;
            let truths = Truths::of(scene).expect("a good scene");
            let methods = Method::ALL.iter().enumerate().filter(|(m, _)| (n + m) % 3 < thirds);
            for (m, &method) in methods {
                let worst = &mut worst[m];
                let (shares, faults) = shares(&format!("{} [{n}]", family.name), (scene, &truths), method, &mut places);
                *worst = [worst[0].max(shares[0]), worst[1].max(shares[1])];
                faulty.extend(faults);
            }
        }
        println!("{:30} {}", family.name, words(&worst));
    }
    assert!(compared > 200, "{compared} scenes");
    assert!(faulty.is_empty(), "{} faults:\n{}", faulty.len(), faulty.join("\n"));
}

/// Atoms from 10 to 1000 radii away, most of them far, each tangent to a pixel's ray.
fn atoms() -> Scene {
    let camera = Camera {
        eye: DVec3::new(3.0, -4.0, 5.0),
        look: Look::View(DVec3::new(-1.0, 2.0, -3.0)),
        up: DVec3::Y,
        lens: Lens::Vfov { degrees: 40.0, distance: 1.0 },
    };
    let image = ImagePlane { width: 96, height: 72, background: [0.0; 3] };
    let mut scene = Scene { camera, image, spheres: Spheres::default(), lighting: Default::default() };
    let mut random = Rng::new(SEED);
    for _ in 0..600 {
        let pixel = [(72.0 * random.unit()) as u32, (96.0 * random.unit()) as u32];
        let d = direction(&scene, pixel).normalize();
        let (radius, k) = (1.0 + random.unit(), 10f64.powf(1.0 + 2.0 * random.unit().sqrt()));
        let perpendicular = d.cross(DVec3::from_array(random.cube())).normalize();
        scene.spheres.push((scene.camera.eye + radius * (k * d + perpendicular)).to_array(), radius, None);
    }
    scene
}

/// The direction through the centre of row i, column j, within rounding.
fn direction(scene: &Scene, [i, j]: [u32; 2]) -> DVec3 {
    let (camera, image) = (&scene.camera, &scene.image);
    let basis = camera.basis().expect("a good camera");
    let lens = camera.viewport(image.width, image.height).expect("a good lens");
    let odd = |k: u32, n: u32| (2.0 * f64::from(k) + 1.0 - f64::from(n)) / (2.0 * f64::from(n));
    basis.u * (odd(j, image.width) * lens.vw) - basis.v * (odd(i, image.height) * lens.vh) - basis.w * lens.d
}

/// The least radius for which the ray of that pixel hits a sphere about `center`; `guess` is within 2^-20 of it.
fn impact(scene: &Scene, [i, j]: [u32; 2], center: DVec3, guess: f64) -> f64 {
    let hit = |radius: f64| {
        let mut alone = Scene { spheres: Spheres::default(), ..scene.clone() };
        alone.spheres.push(center.to_array(), radius, None);
        Judge::new(&alone).expect("a good scene").pixel(i, j).is_some()
    };
    // Positive f64 are ordered as their bits.
    let [mut missed, mut touched] = [-1.0, 1.0].map(|side| (guess * (1.0 + side * 2f64.powi(-20))).to_bits());
    assert!(!hit(f64::from_bits(missed)) && hit(f64::from_bits(touched)), "the guess {guess:e} is too far off");
    while touched - missed > 1 {
        let middle = missed + (touched - missed) / 2;
        *if hit(f64::from_bits(middle)) { &mut touched } else { &mut missed } = middle;
    }
    f64::from_bits(touched)
}

/// For up to 200 spheres, farthest and nearest in turn: the radii that are tangent to the rays that pass closest to the
/// limb and hit nothing nearer, at most one for each of [`PARTS`].
fn limbs(scene: &Scene) -> Vec<(usize, Vec<f64>)> {
    let judge = Judge::new(scene).expect("a good scene");
    let (w, h) = (scene.image.width, scene.image.height);
    let pixels: Vec<_> = (0..h).flat_map(|i| (0..w).map(move |j| [i, j])).collect();
    let rays: Vec<_> = pixels.iter().map(|at| direction(scene, *at).normalize()).collect();
    let hits: Vec<_> =
        pixels.iter().map(|[i, j]| judge.pixel(*i, *j).map(|truth| (truth.id as usize, truth.distance))).collect();
    let bare = Scene { spheres: Spheres::default(), ..scene.clone() };
    let ball = |id: usize| (DVec3::from_array(scene.spheres.centers[id]), scene.spheres.radii[id]);
    let farness = |id: &usize| (ball(*id).0 - scene.camera.eye).length() / ball(*id).1;
    let mut order: Vec<usize> = (0..scene.spheres.len()).collect();
    order.sort_by(|a, b| farness(a).total_cmp(&farness(b)));
    let mut limbs = Vec::new();
    let turn = |n: usize| if n.is_multiple_of(2) { order[n / 2] } else { order[order.len() - 1 - n / 2] };
    for id in (0..order.len()).map(turn) {
        let (center, radius) = ball(id);
        let p = center - scene.camera.eye;
        let mut near: Vec<_> = (0..pixels.len())
            .filter(|&k| p.dot(rays[k]) > 0.0)
            .map(|k| (p.cross(rays[k]).length(), k))
            .filter(|(l, k)| {
                let open = hits[*k].is_none_or(|(at, distance)| at == id || distance > p.length());
                (l / radius - 1.0).abs() < 0.3 && open
            })
            .collect();
        near.sort_by(|a, b| (a.0 / radius - 1.0).abs().total_cmp(&(b.0 / radius - 1.0).abs()));
        let touched = near.iter().take(PARTS.len()).map(|(guess, k)| impact(&bare, pixels[*k], center, *guess));
        if !near.is_empty() {
            limbs.push((id, touched.collect()));
        }
        if limbs.len() == 200 {
            break;
        }
    }
    limbs
}

/// The scene with each radius changed so that ray `turn` passes the limb within `part` of the predicted outline.
fn grazed(scene: &Scene, limbs: &[(usize, Vec<f64>)], method: Method, turn: usize, part: f64) -> Scene {
    let mut scene = scene.clone();
    for (n, (id, touched)) in limbs.iter().enumerate() {
        let touched = touched[turn % touched.len()];
        let mut alone = Scene { spheres: Spheres::default(), ..scene.clone() };
        alone.spheres.push(scene.spheres.centers[*id], touched, None);
        let own = Prediction::of(&alone, method).expect("a good scene").expect("a sphere").outline;
        let side = if n % 2 == 0 { 1.0 } else { -1.0 };
        scene.spheres.radii.to_mut()[*id] = touched * (1.0 + side * part * own.min(0.5));
    }
    scene
}

/// Shares of the predicted outline; the smallest is just above 1 / [`SLACK`].
const PARTS: [f64; 12] = [0.25, 0.1, 0.05, 0.03, 0.02, 0.02, 0.02, 0.015, 0.015, 0.015, 0.012, 0.012];

#[test]
fn errors_of_ordinary_scenes_come_within_a_hundredth_of_the_prediction() {
    let mut scenes = vec![("atoms".to_owned(), atoms())];
    let folder = tempfile::tempdir().expect("a folder");
    let weekend = home().join("scenes/weekend.toml");
    let balls = [("balls_s2.nff", 2), ("balls_s4.nff", 4)].map(|(name, depth)| {
        let path = folder.path().join(name);
        std::fs::write(&path, nff::balls(depth)).expect("written");
        path
    });
    for path in [weekend].into_iter().chain(balls).take(amount("scenes of files", [0, 1, 3])) {
        let mut scene = halfline_files::read::scene(&path, &ReadOptions::default()).expect("a scene").scene;
        // Fewer rays where there are many spheres.
        (scene.image.width, scene.image.height) = match scene.spheres.len() {
            0..1000 => (96, 72),
            _ => (48, 36),
        };
        scenes.push((path.file_name().expect("a file").to_string_lossy().into_owned(), scene));
    }
    let mut places = places();
    let mut faulty = Vec::new();
    println!("largest outline and distance as shares of their prediction");
    for (name, scene) in &scenes {
        let limbs = limbs(scene);
        assert!(limbs.len() > 50, "{name}: {} limbs", limbs.len());
        let mut worst = Vec::new();
        for &method in Method::ALL {
            let mut largest = [0.0f64; 2];
            for (turn, part) in PARTS.into_iter().enumerate() {
                let scene = grazed(scene, &limbs, method, turn, part);
                let truths = Truths::of(&scene).expect("a good scene");
                let (shares, faults) = shares(name, (&scene, &truths), method, &mut places);
                largest = [largest[0].max(shares[0]), largest[1].max(shares[1])];
                faulty.extend(faults);
            }
            if largest.iter().any(|share| share * SLACK < 1.0) {
                faulty.push(format!("{name}, {}: only {largest:?} of the prediction was reached", method.name()));
            }
            worst.push(largest);
        }
        println!("{name:15} {:4} limbs  {}", limbs.len(), words(&worst));
    }
    assert!(faulty.is_empty(), "{} faults:\n{}", faulty.len(), faulty.join("\n"));
}
