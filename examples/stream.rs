//! Reads a file of spheres block by block, then reads it again and sifts the blocks for a picture, and prints the rates of
//! both and the peak of memory.
//!
//! ```sh
//! cargo run --release --example stream -- huge.npy
//! ```

use halfline::camera::{Camera, Lens, Look};
use halfline::error::{Error, Result};
use halfline::read::{ReadOptions, SphereBlocks};
use halfline::render::stream::Stream;
use halfline::{Aov, ImagePlane, Renderer, Scene, Settings, Spheres};
use std::path::{Path, PathBuf};
use std::time::Instant;

fn main() -> Result<()> {
    let files: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    if files.is_empty() {
        return Err(Error::settings("no file is given", "use cargo run --release --example stream -- FILE.npy ..."));
    }
    println!("| file | spheres | read, s | read and sifted, s | ratio of the rates | kept | frame, s | peak, MB |");
    println!("|---|---|---|---|---|---|---|---|");
    files.iter().try_for_each(|file| row(file))
}

/// One line of the table.
fn row(file: &Path) -> Result<()> {
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
        skipped: Default::default(),
        lighting: Default::default(),
    };
    let settings = Settings {
        backend: halfline::Backend::Cpu,
        aovs: vec![Aov::Color, Aov::Id, Aov::Distance, Aov::Normal],
        ..Settings::default()
    };
    let start = Instant::now();
    let mut stream = Stream::new(&scene, &settings)?;
    each(file, |block| stream.add(&block))?;
    let visible = stream.finish()?;
    let sifted = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut frame = Renderer::new(&settings)?.render(&visible.scene, &settings)?;
    visible.ids.restore(&mut frame);
    println!(
        "| {} | {} | {read:.2} | {sifted:.2} | {:.2} | {} | {:.2} | {} |",
        file.file_name().unwrap_or_default().to_string_lossy(),
        visible.ids.count,
        read / sifted,
        visible.ids.ids.len(),
        start.elapsed().as_secs_f64(),
        peak().map_or("unknown".into(), |kilobytes| (kilobytes / 1024).to_string())
    );
    Ok(())
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
