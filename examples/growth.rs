//! The growth of the time of a certified frame with spheres, with pixels and with overlap, on the adapter and on the
//! CPU path, as a table and one plot.
//!
//! ```sh
//! cargo run --release --example growth -- target/growth          # minutes; 8192 x 8192 takes some 5 GB
//! cargo run --release --example growth -- target/growth 1e5 cpu  # at most 1e5 spheres, one backend
//! ```
//! Writes growth.csv, growth.svg and growth.png into the folder.

mod cloud;

use cloud::cloud;
use halfline::{Accuracy, Aov, Backend, Renderer, Scene, Settings};
use halfline_measure::plot::growth::{Curve, Growth, Panel};
use halfline_measure::record::PlaceRecord;
use std::collections::BTreeMap;
use std::fmt::Write;

type Result<T = ()> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The image's side when the number of spheres grows.
const SIDE: u32 = 1024;

/// Steady frames whose median is reported; fewer if they take long.
const FRAMES: usize = 5;

/// Milliseconds of steady frames after which no more are rendered.
const PATIENCE: f64 = 6000.0;

/// Spheres about one centre, all larger than the image and farther than two radii (nearer ones would be tested by every
/// ray): every tile lists all of them.
fn shells(count: usize) -> Scene {
    let mut scene = cloud(0);
    (0..count).for_each(|i| scene.spheres.push([0.5; 3], 1.25 + 0.1 * i as f64 / count as f64, None));
    scene
}

/// A scene with `pixels` pixels per radius at the middle of the cloud.
fn overlap(pixels: f64) -> Scene {
    let away = (1.7f64.powi(2) + 1.1f64.powi(2) + 2.4f64.powi(2)).sqrt();
    let pixel = 2.0 * away * 16f64.to_radians().tan() / f64::from(SIDE);
    let mut scene = cloud(1000);
    scene.spheres.radii.to_mut().fill(pixels * pixel);
    scene
}

/// One kind of scene at several sizes.
struct Series {
    panel: usize,
    name: &'static str,
    /// The sizes, and the scene at each.
    steps: Vec<f64>,
    scene: fn(f64) -> Scene,
    /// The image's side.
    side: fn(f64) -> u32,
}

fn series(most: f64) -> [Series; 4] {
    let decades = |first: i32, last: f64| (first..=last.log10().round() as i32).map(|e| 10f64.powi(e)).collect();
    [
        Series { panel: 0, name: "cloud", steps: decades(2, most), scene: |n| cloud(n as usize), side: |_| SIDE },
        Series {
            panel: 0,
            name: "shells over all tiles",
            steps: decades(1, 1e3),
            scene: |n| shells(n as usize),
            side: |_| SIDE,
        },
        Series {
            panel: 1,
            name: "cloud of 1e5",
            steps: (6..=13).map(|e| 4f64.powi(e)).collect(),
            scene: |_| cloud(100_000),
            side: |n| n.sqrt() as u32,
        },
        Series {
            panel: 2,
            name: "1e3 spheres in a cube",
            steps: (-2..=6).map(|half| 10f64.powf(f64::from(half) / 2.0)).collect(),
            scene: overlap,
            side: |_| SIDE,
        },
    ]
}

const MEASURED: &str = "whole steady frame (ms, median)";
const OVER: [&str; 3] = ["spheres (1024 x 1024)", "pixels", "radius in pixels (1024 x 1024)"];

/// A first frame and some steady ones.
struct Timed {
    first: f64,
    steady: Vec<f64>,
    stages: BTreeMap<&'static str, f64>,
    certified: f64,
}

fn time(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Result<Timed> {
    let mut times = Vec::new();
    loop {
        let frame = renderer.render(scene, settings)?;
        times.extend(&frame.report.frame_ms);
        let (stages, certified) = (frame.report.stages_ms.clone(), frame.report.certified);
        renderer.recycle(frame);
        let spent: f64 = times[1..].iter().sum();
        if times.len() > FRAMES || (times.len() > 1 && spent > PATIENCE) {
            let mut steady = times.split_off(1);
            steady.sort_by(f64::total_cmp);
            return Ok(Timed { first: times[0], steady, stages, certified });
        }
    }
}

fn main() -> Result {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let dir = std::path::Path::new(arguments.first().ok_or("give a folder")?);
    let most: f64 = arguments.get(1).map_or(Ok(1e7), |most| most.parse())?;
    let backends =
        arguments.get(2).map_or(Ok(vec![Backend::Gpu, Backend::Cpu]), |name| name.parse().map(|b| vec![b]))?;
    std::fs::create_dir_all(dir)?;
    let settings = backends.into_iter().map(|backend| Settings {
        accuracy: Accuracy::Certified,
        backend,
        aovs: vec![Aov::Color, Aov::Id, Aov::Distance, Aov::Normal],
        ..Settings::default()
    });
    let settings: Vec<Settings> = settings.collect();
    let mut renderers = settings.iter().map(Renderer::new).collect::<halfline::Result<Vec<_>>>()?;
    let places = renderers.iter().zip(&settings).map(|(renderer, settings)| PlaceRecord {
        backend: settings.backend.name().into(),
        adapter: renderer.adapter().into(),
        driver: renderer.driver(),
        ..PlaceRecord::default()
    });
    let mut growth = Growth {
        title: "How a frame's time grows".into(),
        subject: "certified, with colour, id, distance and normal".into(),
        places: places.collect(),
        panels: OVER.map(|over| Panel { over: over.into(), measured: MEASURED.into(), curves: Vec::new() }).into(),
    };
    let mut table = String::from("over,scene,backend,n,first_ms,median_ms,least_ms,frames,certified,stages_ms\n");
    for series in series(most) {
        let mut curves: Vec<Curve> =
            (0..settings.len()).map(|place| Curve { name: series.name.into(), place, points: Vec::new() }).collect();
        for n in series.steps {
            let mut scene = (series.scene)(n);
            (scene.image.width, scene.image.height) = ((series.side)(n), (series.side)(n));
            for (place, settings) in settings.iter().enumerate() {
                let Timed { first, steady, stages, certified } = time(&mut renderers[place], &scene, settings)?;
                let median = steady[steady.len() / 2];
                let stages: Vec<String> = stages.iter().map(|(name, ms)| format!("{name} {ms:.1}")).collect();
                let line = format!(
                    "{},{},{},{n:.4},{first:.2},{median:.2},{:.2},{},{certified:.5},{}",
                    OVER[series.panel],
                    series.name,
                    settings.backend.name(),
                    steady[0],
                    steady.len(),
                    stages.join(" ")
                );
                println!("{line}");
                writeln!(table, "{line}")?;
                curves[place].points.push([n, median]);
            }
        }
        growth.panels[series.panel].curves.extend(curves);
    }
    for (panel, curve) in growth.panels.iter().flat_map(|panel| panel.curves.iter().map(move |curve| (panel, curve))) {
        if let Some([exponent, _]) = curve.fit() {
            println!(
                "{} of {}, {}: exponent {exponent:.2}",
                panel.over, curve.name, growth.places[curve.place].backend
            );
        }
    }
    std::fs::write(dir.join("growth.csv"), table)?;
    growth.plot()?.write(dir)?;
    Ok(())
}
