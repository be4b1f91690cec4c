//! The promise of certified answers where renderers fail: mask and id are exact at every pixel, and the distance is within
//! the tolerance and within its stated bound, on an adapter and on the CPU.
//!
//! Gold standard: `--accuracy exact`, which tests/answers/truth.rs compares with a program that shares no code with it.
//! Tolerances:
//!
//! | buffer | tolerance | why |
//! |---|---|---|
//! | id, mask | none | the promise |
//! | distance, depth | `tolerance` x itself, and the bound | the promise; 2^-50 where settled |
//! | normal | 1e-3 rad | the promise; the length is 1 within 2^-20, a handful of roundings in f32 |
//! | position | bound + 2^-48 (|e| + distance) | the basis is good to 2^-52, three products and sums |
//! | GPU against CPU | none on adapters known to be strict | the twin rounds in the same way |
//!
//! A case that fails is printed with the bits of its scene, so that it can be rebuilt anywhere.

use super::score::{Score, settled};
use crate::adapter::{cpu, is_strict, renderers};
use crate::amount::{amount, everything};
use crate::bits::Bits;
use crate::data::real_or_skip;
use crate::rng::Rng;
use crate::{nff, planets};
use glam::DVec3;
use halfline::camera::Look;
use halfline::frame::{Aov, Data, Frame};
use halfline::render::Renderer;
use halfline::scene::{ImagePlane, Scene};
use halfline::settings::{Accuracy, Backend, Settings, Tolerance};
use halfline_measure::suite::extremes::{FAMILIES, Family};

/// The same cases in every run; the first of them where not everything is tested.
const SEEDS: [u64; 3] = [0x5eed_0003, 0x5eed_0005, 0x5eed_0007];

/// The buffers that are compared.
const AOVS: [Aov; 7] = [Aov::Distance, Aov::Depth, Aov::Normal, Aov::Position, Aov::Mask, Aov::Certainty, Aov::Bound];

/// The largest error of a normal, in radians.
const NORMAL: f64 = 1e-3;

/// Relative rounding of a unit vector's length in f32: some ten roundings of 2^-24.
const UNIT_LENGTH: f64 = 1.0 / (1u64 << 20) as f64;

/// The relative error of a world point: the basis within 2^-52 a component, times sqrt(3), three products and three sums.
const POINT: f64 = 1.0 / (1u64 << 48) as f64;

/// The relative error of a settled number, and the rounding of every f64 answer.
const SETTLED: f64 = 1.0 / (1u64 << 50) as f64;

fn settings(accuracy: Accuracy, tolerance: f64) -> Settings {
    let tolerance = Some(Tolerance::new(tolerance).expect("a tolerance that can be promised"));
    Settings { accuracy, tolerance, aovs: AOVS.to_vec(), ..Settings::default() }
}

/// The seeds of a test that would take these: the first alone where not everything is tested.
pub(crate) fn seeds(all: &[u64]) -> &[u64] {
    &all[..amount("seeds of families", [1, 1, all.len()])]
}

/// The scenes of a family, in frames of half their size where not everything is tested. Families that read files get generated
/// files of the same kind.
pub(crate) fn scenes(family: &Family, seed: u64) -> Vec<Scene> {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, content) in [("shells.nff", nff::shells()), ("solar_system.csv", planets::csv())] {
        std::fs::write(folder.path().join(name), content).expect("written");
    }
    let mut scenes = family.scenes(seed, Some(folder.path())).expect("valid scenes");
    assert!(!scenes.is_empty(), "{} has scenes", family.name);
    if !everything() {
        scenes.iter_mut().for_each(halve);
    }
    scenes
}

/// Halves the sides of a frame.
pub(crate) fn halve(scene: &mut Scene) {
    let ImagePlane { width, height, .. } = &mut scene.image;
    (*width, *height) = (width.div_ceil(2), height.div_ceil(2));
}

/// The exact frame.
fn exact(scene: &Scene) -> Frame {
    cpu().render(scene, &settings(Accuracy::Exact, 1e-5)).expect("an exact frame")
}

fn f64s(frame: &Frame, aov: Aov) -> &[f64] {
    frame.f64(aov).expect("a requested buffer")
}

/// A vector of a buffer with three numbers a pixel.
fn vector(values: &[f64], pixel: usize) -> DVec3 {
    DVec3::from_slice(&values[3 * pixel..])
}

fn normal(frame: &Frame, pixel: usize) -> DVec3 {
    let n = &frame.f32(Aov::Normal).expect("a requested buffer")[3 * pixel..];
    DVec3::new(f64::from(n[0]), f64::from(n[1]), f64::from(n[2]))
}

/// Whether `x` is at most `most`; false for NaN.
fn within(x: f64, most: f64) -> bool {
    x <= most
}

/// The first error in one pixel of a certified frame.
fn fault(scene: &Scene, frame: &Frame, exact: &Frame, tolerance: f64, k: usize) -> Option<String> {
    let (id, truth) = (frame.ids()[k], exact.ids()[k]);
    if id != truth {
        return Some(format!("shows {id}, exact is {truth}"));
    }
    let mask = match &frame.get(Aov::Mask)?.data {
        Data::U8(mask) => mask[k],
        _ => 2,
    };
    if mask != u8::from(truth >= 0) {
        return Some(format!("mask {mask}, exact id {truth}"));
    }
    let again = settled(frame).map_or(255, |settled| settled[k]);
    if again > 1 {
        return Some(format!("certainty {again}"));
    }
    let at = |frame: &Frame, aov| f64s(frame, aov)[k];
    let [distance, depth, bound] = [Aov::Distance, Aov::Depth, Aov::Bound].map(|aov| at(frame, aov));
    let [real, deep] = [Aov::Distance, Aov::Depth].map(|aov| at(exact, aov));
    let (point, place) = (vector(f64s(frame, Aov::Position), k), vector(f64s(exact, Aov::Position), k));
    if truth < 0 {
        let nothing =
            distance == f64::INFINITY && depth == f64::INFINITY && bound == 0.0 && normal(frame, k) == DVec3::ZERO;
        return (!nothing || !point.is_nan()).then(|| "a miss with finite values".to_owned());
    }
    let most = (tolerance * real).min(bound);
    if !(bound > 0.0 && bound <= tolerance * real * (1.0 + SETTLED)) {
        return Some(format!("bound {bound:e} of distance {real:e}"));
    }
    if !within((distance - real).abs(), most) {
        return Some(format!("distance {distance:e} is off by {:e}, bound {bound:e}", (distance - real).abs()));
    }
    // The bound of the distance, along the axis.
    if !within((depth - deep).abs(), most * (deep / real) * (1.0 + SETTLED) + SETTLED * deep) {
        return Some(format!("depth {depth:e} is off by {:e}, distance bound {bound:e}", (depth - deep).abs()));
    }
    let (n, m) = (normal(frame, k), normal(exact, k));
    if !((n.length() - 1.0).abs() <= UNIT_LENGTH && n.cross(m).length().atan2(n.dot(m)) <= NORMAL) {
        return Some(format!("normal {n}, exact {m}"));
    }
    if !within((point - place).length(), bound + POINT * (scene.camera.eye.length() + real)) {
        return Some(format!("position {point}, exact {place}, bound {bound:e}"));
    }
    // A settled pixel has the exact values.
    let same = distance == real && depth == deep && point == place && n == m;
    (again == 1 && !same).then(|| "settled, but not exact".to_owned())
}

/// The bits of all inputs of the pixel: of the spheres, the one shown and the exact one.
fn bits(scene: &Scene, frame: &Frame, exact: &Frame, k: usize) -> String {
    let hex = |v: &[f64]| v.iter().map(|x| format!("{:016x}", x.to_bits())).collect::<Vec<_>>().join(" ");
    let Scene { camera, image, spheres, .. } = scene;
    let (Look::At(look) | Look::View(look)) = camera.look;
    let lens = camera.viewport(image.width, image.height).expect("a good lens");
    let mut text = format!(
        "pixel {} {} of {} x {}; eye {}; {} {}; up {}; vw vh d {}",
        k / image.width as usize,
        k % image.width as usize,
        image.width,
        image.height,
        hex(&camera.eye.to_array()),
        if matches!(camera.look, Look::At(_)) { "at" } else { "view" },
        hex(&look.to_array()),
        hex(&camera.up.to_array()),
        hex(&[lens.vw, lens.vh, lens.d]),
    );
    for id in [frame.ids()[k], exact.ids()[k]] {
        if let Some(id) = usize::try_from(id).ok().filter(|id| *id < spheres.len()) {
            text += &format!(
                "; sphere {id} of {}: {} {}",
                spheres.len(),
                hex(&spheres.centers[id]),
                hex(&[spheres.radii[id]])
            );
        }
    }
    text
}

/// Errors of a whole frame, at most four.
fn faults(what: &str, scene: &Scene, frame: &Frame, exact: &Frame, tolerance: f64) -> Vec<String> {
    let pixels = exact.ids().len();
    assert_eq!(frame.ids().len(), pixels, "{what}");
    let mut found: Vec<String> = (0..pixels)
        .filter_map(|k| Some((k, fault(scene, frame, exact, tolerance, k)?)))
        .map(|(k, fault)| format!("{what}: {fault}; {}", bits(scene, frame, exact, k)))
        .collect();
    let count = settled(frame).map_or(0, |settled| settled.iter().filter(|x| **x == 1).count() as u64);
    let proved = (frame.report.certified * pixels as f64).round() as u64;
    if count != frame.report.settled || proved != pixels as u64 - count {
        found.push(format!(
            "{what}: {count} pixels settled, reported {} and {}",
            frame.report.settled, frame.report.certified
        ));
    }
    if frame.report.bound.is_none_or(|bound| bound > tolerance * (1.0 + SETTLED)) {
        found.push(format!("{what}: reports the bound {:?}", frame.report.bound));
    }
    let all = found.len();
    found.truncate(3);
    if all > 3 {
        found.push(format!("{what}: and {} more", all - 3));
    }
    found
}

/// The first difference in bits.
fn differs(a: &Frame, b: &Frame) -> Option<String> {
    AOVS.iter().chain([&Aov::Id]).find_map(|&aov| {
        let (a, b) = (a.bits(aov), b.bits(aov));
        let k = (0..a.len().max(b.len())).find(|&k| a.get(k) != b.get(k))?;
        Some(format!("{aov}[{k}] differs in bits: {:x?} and {:x?}", a.get(k), b.get(k)))
    })
}

/// Compares one scene on every backend at one tolerance with the exact frame.
fn judge(
    what: &str,
    scene: &Scene,
    exact: &Frame,
    tolerance: f64,
    renderers: &mut [(Backend, Renderer)],
) -> (Score, Vec<String>) {
    let mut faulty = Vec::new();
    let mut frames: Vec<Frame> = Vec::new();
    let mut score = Score::default();
    for (backend, renderer) in renderers {
        let backend = backend.name();
        let strict = is_strict(renderer);
        let frame = renderer.render(scene, &settings(Accuracy::Certified, tolerance));
        let frame = frame.unwrap_or_else(|e| panic!("{what}, {backend}: {e}"));
        let what = format!("{what}, {backend}");
        if frame.report.backend != backend {
            // No frame is compared with itself.
            let warnings = &frame.report.warnings;
            let refused = warnings.iter().find(|warning| warning.contains("the CPU path rendered this frame"));
            println!("{what}: {}", refused.unwrap_or_else(|| panic!("{what}: {warnings:?}")));
            continue;
        }
        faulty.extend(faults(&what, scene, &frame, exact, tolerance));
        if let (true, Some(first)) = (strict, frames.first()) {
            faulty.extend(differs(first, &frame).map(|d| format!("{what}, {d}")));
        }
        score = score.and(Score::of(&frame, exact));
        frames.push(frame);
    }
    (score, faulty)
}

/// Every family with this seed on every backend: the score, the number of hits, the errors.
fn walk(seed: u64) -> (Score, u64, Vec<String>) {
    let mut renderers = renderers();
    let (mut faulty, mut total, mut hits) = (Vec::new(), Score::default(), 0);
    for family in FAMILIES {
        let begun = std::time::Instant::now();
        let mut sum = Score::default();
        for (n, scene) in scenes(family, seed).iter().enumerate() {
            let exact = exact(scene);
            hits += exact.report.hits;
            let (score, faults) = judge(&format!("{} [{n}]", family.name), scene, &exact, 1e-5, &mut renderers);
            sum = sum.and(score);
            faulty.extend(faults);
        }
        println!(
            "{:30} {:7} pixels compared, {} wrong, error {:.1e}, {:.4} in f32, error / bound {:.2}, {:.1} s",
            family.name,
            sum.pixels,
            sum.wrong,
            sum.error,
            sum.certified as f64 / sum.pixels as f64,
            sum.ratio,
            begun.elapsed().as_secs_f64(),
        );
        total = total.and(sum);
    }
    println!("seed {seed:x}: {total:?}, {hits} hits");
    (total, hits, faulty)
}

#[test]
fn certified_is_exact_in_every_family() {
    // HALFLINE_SEEDS=1000 adds as many seeds.
    let more = std::env::var("HALFLINE_SEEDS").map_or(0, |n| n.parse().expect("a number of seeds"));
    for seed in seeds(&SEEDS).iter().copied().chain((1..=more).map(|n: u64| n.wrapping_mul(0x9e37_79b9_7f4a_7c15))) {
        let (total, hits, faulty) = walk(seed);
        assert!(faulty.is_empty(), "{} faults of seed {seed:x}:\n{}", faulty.len(), faulty.join("\n"));
        // With only the CPU path there are half as many pixels.
        let (enough, many) = if everything() { (80_000, 300_000) } else { (20_000, 75_000) };
        assert!(hits > enough && total.pixels > many, "the families have hits: {hits}");
    }
}

/// The family that is read from JPL's ephemeris, on its real file.
#[test]
fn certified_is_exact_among_the_planets_of_the_ephemeris() {
    let found = real_or_skip(&["solar_system.csv"]);
    let Some((name, path)) = found.first() else { return };
    let family = FAMILIES.iter().find(|family| family.file() == Some(name)).expect("a family of that file");
    let (mut renderers, mut hits) = (renderers(), 0);
    for (n, scene) in family.scenes(SEEDS[0], path.parent()).expect("valid scenes").iter().enumerate() {
        let exact = exact(scene);
        let (_, faulty) = judge(&format!("{} [{n}]", family.name), scene, &exact, 1e-5, &mut renderers);
        assert!(faulty.is_empty(), "{}", faulty.join("\n"));
        hits += exact.report.hits;
    }
    assert!(hits > 1000, "{hits} hits");
}

#[test]
fn every_tolerance_is_kept() {
    let mut renderers = renderers();
    let mut shares = Vec::new();
    for tolerance in [1.0, 1e-3, 1e-7, 1e-12, 2f64.powi(-50)] {
        let mut sum = Score::default();
        for name in
            ["far, off the axis", "clusters 1e3 to 1e9 away", "around the eye", "planet with pebbles", "wide lenses"]
        {
            let family = FAMILIES.iter().find(|family| family.name == name).expect("a family of that name");
            for (n, scene) in scenes(family, SEEDS[0]).iter().enumerate() {
                let what = format!("{name} [{n}] at {tolerance:e}");
                let (score, faulty) = judge(&what, scene, &exact(scene), tolerance, &mut renderers);
                assert!(faulty.is_empty(), "{}", faulty.join("\n"));
                sum = sum.and(score);
            }
        }
        println!("tolerance {tolerance:.1e}: {sum:?}");
        shares.push(sum.certified);
    }
    assert!(shares.is_sorted_by(|loose, tight| loose >= tight), "a smaller tolerance certifies less: {shares:?}");
}

/// The lists of pixels and of pairs are complete if every pixel is unsure, and grow far beyond their first capacity.
///
/// f32 cannot reach a tolerance of 2^-50, so every hit is unsure. Spheres that coincide within 1e-9 are all candidates:
/// 100 pairs a hit, while a GPU's first list holds 2^14 pairs and the first read 2^12 pixels.
#[test]
fn a_frame_of_unsure_pixels_is_settled_completely() {
    let mut random = Rng::new(SEEDS[0]);
    let mut spheres = halfline::scene::Spheres::default();
    for _ in 0..100 {
        let center = DVec3::new(0.0, 0.5, -4.0) + 1e-9 * DVec3::from_array(random.cube());
        spheres.push(center.to_array(), 2.0 + 1e-9 * random.unit(), None);
    }
    let scene = Scene {
        camera: halfline::camera::Camera { up: DVec3::new(0.1, 1.0, 0.2), ..halfline::camera::Camera::CANONICAL },
        image: halfline::scene::ImagePlane { width: 128, height: 96, background: [0.0; 3] },
        spheres,
        lighting: Default::default(),
    };
    let exact = exact(&scene);
    let shown: std::collections::BTreeSet<_> = exact.ids().iter().collect();
    assert!(exact.report.hits > 6000 && shown.len() > 5, "{} hits of {} spheres", exact.report.hits, shown.len());
    for (backend, mut renderer) in renderers() {
        let backend = backend.name();
        // The second time the lists are large enough.
        for _ in 0..2 {
            let tolerance = 2f64.powi(-50);
            let frame = renderer.render(&scene, &settings(Accuracy::Certified, tolerance)).expect("a frame");
            let faulty = faults(backend, &scene, &frame, &exact, tolerance);
            assert!(faulty.is_empty(), "{}", faulty.join("\n"));
            assert!(frame.report.settled >= frame.report.hits, "{backend}: {} settled", frame.report.settled);
        }
    }
}

/// Long columns, and the longest rows that 65,535 workgroups of 8 write in one dispatch: there fixed-point centres have
/// the fewest bits per pixel.
#[test]
fn the_longest_frames_are_exact() {
    let mut renderers = renderers();
    let mut random = Rng::new(SEEDS[0]);
    for [width, height] in [[8 * 65535, 1], [1, 1 << 18]] {
        let mut spheres = halfline::scene::Spheres::default();
        for n in 0..40 {
            let [x, y, z] = random.cube();
            // On the line in view, most of them a few pixels wide.
            let (along, across) = (12.0 * x, 1e-6 * y);
            let place = if width > 1 { [along, across] } else { [across, along] };
            let radius = if n % 8 == 0 { 0.5 } else { 1e-5 * (1.1 + random.unit()) };
            spheres.push([place[0], place[1], -4.0 + z], radius, None);
        }
        let pitch = 4.0 / f64::from(width.max(height));
        let lens = halfline::camera::Lens::Viewport {
            vw: pitch * f64::from(width),
            vh: pitch * f64::from(height),
            distance: 1.0,
        };
        let scene = Scene {
            camera: halfline::camera::Camera { lens, ..halfline::camera::Camera::CANONICAL },
            image: halfline::scene::ImagePlane { width, height, background: [0.0; 3] },
            spheres,
            lighting: Default::default(),
        };
        let exact = exact(&scene);
        let (score, faulty) = judge(&format!("{width} x {height}"), &scene, &exact, 1e-5, &mut renderers);
        println!("{width} x {height}: {score:?}, {} hits", exact.report.hits);
        assert!(faulty.is_empty(), "{}", faulty.join("\n"));
        let shown: std::collections::BTreeSet<_> = exact.ids().iter().collect();
        assert!(shown.len() > 10, "{} spheres are visible", shown.len());
    }
}
