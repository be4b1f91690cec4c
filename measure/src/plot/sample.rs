//! SYNTHETIC records for tests, with the structure of real ones but without measurements.

use crate::record::{Crop, Errors, Map, PlaceRecord, Predicted, Record, Run, SceneRecord, Spread};

/// Name, decade of radii at which it fails, relative error at 1 radius, growth per decade, ns per ray on the GPU and
/// the CPU.
type Method = (&'static str, f64, f64, f64, f64, f64);

const METHODS: [Method; 8] = [
    ("textbook", 3.1, 3e-7, 0.8, 0.21, 38.0),
    ("unit", 3.0, 4e-7, 0.8, 0.24, 41.0),
    ("geometric", 3.0, 4e-7, 0.8, 0.25, 43.0),
    ("stable", 99.0, 2e-7, 0.0, 0.23, 40.0),
    ("f64", 99.0, 3e-15, 0.02, 3.1, 47.0),
    ("double-float", 99.0, 2e-14, 0.03, 1.4, 120.0),
    ("certified", 99.0, 1.1e-7, 0.0, 0.31, 66.0),
    ("exact", 99.0, 0.0, 0.0, 9.5, 2400.0),
];

fn noise(seed: u64) -> f64 {
    let mut x = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678;
    x ^= x >> 29;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 32;
    (x % 10_000) as f64 / 10_000.0
}

fn places() -> Vec<PlaceRecord> {
    vec![
        PlaceRecord {
            backend: "gpu".into(),
            adapter: "SYNTHETIC H200 <not measured>".into(),
            driver: "NVIDIA 580.65.06".into(),
            self_test: vec!["f32 rounds to nearest even: yes".into(), "fma is fused: yes".into()],
            timestamps: true,
        },
        PlaceRecord {
            backend: "cpu".into(),
            adapter: "cpu".into(),
            driver: "16 threads".into(),
            ..PlaceRecord::default()
        },
    ]
}

/// A ladder of spheres 10 to 1e9 radii away.
pub(crate) fn ladder() -> Record {
    let scenes = (1..=9)
        .map(|decade| SceneRecord {
            name: format!("1e{decade} radii"),
            fingerprint: format!("{:064x}", decade * 977),
            pictures: 1,
            spheres: 1,
            size: [512, 512],
            farthest: Some(10f64.powi(decade)),
            hits: 205_000,
        })
        .collect();
    let mut runs = Vec::new();
    for scene in 0..9 {
        for place in 0..2 {
            for (index, method) in METHODS.iter().enumerate() {
                runs.push(run(scene, place, index, method));
            }
        }
    }
    Record {
        schema: Record::SCHEMA.into(),
        version: Record::VERSION,
        halfline: "0.1.0".into(),
        subject: "suite ladder (SYNTHETIC)".into(),
        command: "halfline measure --suite ladder --out <dir>".into(),
        places: places(),
        scenes,
        runs,
        tolerance: 1e-6,
        warnings: vec!["These numbers are SYNTHETIC & mean nothing.".into()],
        ..Record::default()
    }
}

fn run(scene: usize, place: usize, index: usize, &(name, fails, error, growth, gpu, cpu): &Method) -> Run {
    let decade = scene as f64 + 1.0;
    let seed = (scene * 100 + index) as u64;
    let pixels = 512 * 512;
    let beyond = (decade - fails).max(-9.0);
    let share = if beyond > -0.5 { (0.004 * 10f64.powf(beyond)).min(0.45) } else { 0.0 };
    let wrong = (share * f64::from(pixels)) as u64;
    let most = error * 10f64.powf(growth * decade) * (1.0 + 0.4 * noise(seed));
    let ms = if place == 0 { gpu } else { cpu } * f64::from(pixels) * 1e-6 * (1.0 + 0.1 * noise(seed + 7));
    let spread = |most: f64| Spread { median: Some(most / 9.0), p99: Some(most / 2.0), max: Some(most) };
    let proved = matches!(name, "certified" | "exact");
    Run {
        scene,
        place,
        method: name.into(),
        refused: None,
        first_ms: Some(ms * 30.0 + 20.0),
        steady_ms: (0..9).map(|i| ms * (0.93 + 0.3 * noise(seed + i * 31))).collect(),
        kernel_ms: if place == 0 { vec![ms * 0.6; 9] } else { Vec::new() },
        errors: Errors {
            pixels: pixels as u64,
            false_hit: wrong / 2,
            false_miss: wrong - wrong / 2,
            outline: Some(share * 2.0),
            relative: spread(most),
            ulp: spread(most * 1.6e7),
            radii: spread(most * 10f64.powf(decade)),
            normal: spread(most * 57.0),
            ..Errors::default()
        },
        certified: (name == "certified").then_some(0.994),
        settled: (name == "certified").then_some(1573),
        of_bound: proved.then_some(0.07),
        predicted: Predicted {
            outline: (name == "textbook").then(|| 10f64.powf(2.0 * decade - 6.5)),
            distance: (most > 0.0).then_some(most * 12.0).filter(|_| decade < 7.0 || fails > 9.0),
        },
        map: None,
        crop: Some(crop(beyond, seed)),
    }
}

/// A disc that dissolves beyond a distance.
fn crop(beyond: f64, seed: u64) -> Crop {
    let (mut shade, mut verdict) = (String::new(), String::new());
    for pixel in 0..48 * 48u64 {
        let (x, y) = ((pixel % 48) as f64 / 23.5 - 1.0, (pixel / 48) as f64 / 23.5 - 1.0);
        let radius = x.hypot(y) / 0.8;
        let width = 0.02 * 10f64.powf(beyond);
        let band = (x * 40.0 + (y * 9.0).sin()).sin() > 0.3 && width > 0.3;
        let is_hit = (radius + width.min(0.6) * (2.0 * noise(seed * 9000 + pixel) - 1.0) < 1.0) != band;
        let letter = char::from_digit(((1.0 - radius * radius).max(0.0).sqrt() * 15.0) as u32, 16);
        shade.push(if is_hit { letter.unwrap_or('0') } else { '.' });
        verdict.push(match (is_hit, radius < 1.0) {
            (true, false) => 'h',
            (false, true) => 'm',
            (true, true) if width > 0.3 && noise(pixel) > 0.9 => {
                if x > 0.0 {
                    's'
                } else {
                    'r'
                }
            }
            _ => '-',
        });
    }
    Crop { size: [48, 48], shade, verdict }
}

/// One scene with maps of its errors; double-float was refused.
pub(crate) fn scene() -> Record {
    let mut record = ladder();
    record.subject = "weekend.toml (SYNTHETIC)".into();
    record.scenes.truncate(1);
    record.scenes[0] = SceneRecord {
        name: "weekend.toml".into(),
        spheres: 487,
        size: [1200, 675],
        farthest: Some(1013.2),
        ..record.scenes[0].clone()
    };
    record.runs.retain(|run| run.scene == 0);
    for (index, run) in record.runs.iter_mut().enumerate() {
        run.crop = None;
        run.map = Some(map(index % 8));
        run.errors.wrong_sphere = run.map.iter().flat_map(|map| &map.wrong).map(|n| u64::from(*n)).sum();
        if run.method == "double-float" && run.place == 0 {
            *run = Run {
                method: run.method.clone(),
                refused: Some("its arithmetic contracts a*b+c".into()),
                ..Run::default()
            };
        }
    }
    record
}

fn map(index: usize) -> Map {
    let (_, fails, error, ..) = METHODS[index];
    let [columns, rows] = [150u32, 85];
    let (mut errors, mut wrong) = (Vec::new(), Vec::new());
    for cell in 0..columns * rows {
        let (x, y) = (f64::from(cell % columns) / 75.0 - 1.0, f64::from(cell / columns) / 75.0 - 0.56);
        let discs = [(-0.55, 0.0, 0.3), (0.0, 0.0, 0.36), (0.6, 0.05, 0.3)];
        let depth = discs.iter().map(|(u, v, r)| 1.0 - ((x - u).hypot(y - v) / r)).fold(-1.0, f64::max);
        let ground = y > 0.12;
        let hit = depth > 0.0 || ground;
        let grazing = if depth > 0.0 { 1.0 / depth.max(0.002) } else { 30.0 };
        errors.push(if hit { (error * grazing * (0.2 + noise(u64::from(cell)))) as f32 } else { 0.0 });
        wrong.push(u32::from(fails < 9.0 && depth.abs() < 0.012 && noise(u64::from(cell) + 5) > 0.4));
    }
    Map { cell: 8, size: [columns, rows], error: errors, wrong }
}

/// Unordered families, such as the extremes; stable is refused in one.
pub(crate) fn families() -> Record {
    let mut record = ladder();
    record.subject = "suite extremes (SYNTHETIC)".into();
    for (index, scene) in record.scenes.iter_mut().enumerate() {
        scene.name = format!("family {index}");
        scene.farthest = Some(10f64.powf((index * 7 % 9) as f64 * 1.7 - 2.0) * (1.0 + noise(index as u64)));
    }
    for run in &mut record.runs {
        run.crop = None;
        if run.method == "stable" && run.scene == 4 {
            run.refused = Some("no <reason>".into());
        }
        if run.method == "unit" && run.scene == 3 {
            run.errors.relative.max = None;
        }
    }
    record
}
