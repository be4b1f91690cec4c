//! Reads files of spheres block by block, then reads them again and sifts the blocks for a picture; prints the rates of both
//! and the peak of memory, and plots them. The smallest file comes first, since the peak covers the whole process.
//!
//! ```sh
//! cargo run --release --example stream -- target/streams small.npy huge.npy
//! ```

use halfline::camera::{Camera, Lens, Look};
use halfline::error::{Error, Result};
use halfline::render::stream::Stream;
use halfline::{Aov, ImagePlane, Renderer, Scene, Settings, Spheres};
use halfline_files::read::{ReadOptions, SphereBlocks};
use halfline_measure::plot::growth::{Curve, Growth, Panel};
use halfline_measure::record::PlaceRecord;
use std::path::{Path, PathBuf};
use std::time::Instant;

fn main() -> Result<()> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let Some((folder, files)) = arguments.split_first().filter(|(_, files)| !files.is_empty()) else {
        let mend = "use cargo run --release --example stream -- FOLDER FILE.npy ...";
        return Err(Error::settings("no folder for the plot and no file is given", mend));
    };
    std::fs::create_dir_all(folder).map_err(|error| Error::write(folder, error))?;
    println!("| file | spheres | read, s | read and sifted, s | ratio of the rates | kept | frame, s | peak, MB |");
    println!("|---|---|---|---|---|---|---|---|");
    let rows = files.iter().map(|file| row(file)).collect::<Result<Vec<Row>>>()?;
    let curve = |name: &str, of: fn(&Row) -> Option<f64>| Curve {
        name: name.into(),
        place: 0,
        points: rows.iter().filter_map(|row| Some([row.spheres, of(row)?])).collect(),
    };
    let panel = |measured: &str, curves| Panel { over: "spheres".into(), measured: measured.into(), curves };
    let growth = Growth {
        title: "Streams".into(),
        subject: "1024 x 1024, certified, with colour, id, distance and normal".into(),
        places: vec![PlaceRecord {
            backend: "cpu".into(),
            adapter: "cpu".into(),
            driver: Renderer::new(&settings())?.driver(),
            ..PlaceRecord::default()
        }],
        panels: vec![
            panel(
                "s",
                vec![
                    curve("reading alone", |row| Some(row.read)),
                    curve("reading and sifting", |row| Some(row.sifted)),
                    curve("the frame of what is kept", |row| Some(row.frame)),
                ],
            ),
            panel(
                "MB",
                vec![curve("peak of resident memory", |row| row.peak), curve("the file", |row| Some(row.file))],
            ),
        ],
    };
    let mut plot = growth.plot()?;
    plot.name = "streams";
    plot.write(folder).map(drop)
}

/// The measurements of a file: times in seconds, memory and size in megabytes.
struct Row {
    spheres: f64,
    read: f64,
    sifted: f64,
    frame: f64,
    file: f64,
    peak: Option<f64>,
}

fn settings() -> Settings {
    Settings {
        backend: halfline::Backend::Cpu,
        aovs: vec![Aov::Color, Aov::Id, Aov::Distance, Aov::Normal],
        ..Settings::default()
    }
}

/// One line of the table.
fn row(file: &Path) -> Result<Row> {
    let start = Instant::now();
    each(file, |_| Ok(()))?;
    let read = start.elapsed().as_secs_f64();
    // Clouds in the cube of half side 1, as of benches/peers.
    let scene = Scene {
        camera: Camera {
            eye: [3.0, 2.0, 4.0].into(),
            look: Look::At([0.0; 3].into()),
            up: [0.0, 1.0, 0.0].into(),
            lens: Lens::Vfov { degrees: 40.0, distance: 1.0 },
        },
        image: ImagePlane { width: 1024, height: 1024, background: [0.0; 3] },
        spheres: Spheres::default(),
        lighting: Default::default(),
    };
    let settings = settings();
    let start = Instant::now();
    let mut stream = Stream::new(&scene, &settings)?;
    each(file, |block| stream.add(&block))?;
    let visible = stream.finish()?;
    let sifted = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut frame = Renderer::new(&settings)?.render(&visible.scene, &settings)?;
    visible.ids.restore(&mut frame);
    let frame = start.elapsed().as_secs_f64();
    let spheres = visible.ids.count;
    let peak = peak().map(|kibibytes| kibibytes as f64 * 1024e-6);
    println!(
        "| {} | {spheres} | {read:.2} | {sifted:.2} | {:.2} | {} | {frame:.2} | {} |",
        file.file_name().unwrap_or_default().to_string_lossy(),
        read / sifted,
        visible.ids.ids.len(),
        peak.map_or("unknown".into(), |megabytes| format!("{megabytes:.0}"))
    );
    let size = std::fs::metadata(file).map_or(0.0, |about| about.len() as f64 * 1e-6);
    Ok(Row { spheres: spheres as f64, read, sifted, frame, file: size, peak })
}

fn each(file: &Path, mut each: impl FnMut(Spheres) -> Result<()>) -> Result<()> {
    let mut blocks = SphereBlocks::open(file, &ReadOptions::default())?;
    while let Some(block) = blocks.next_block()? {
        each(block)?;
    }
    Ok(())
}

/// The peak of resident memory so far, KiB; on Linux only.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.split_whitespace().next()?.parse().ok()
}
