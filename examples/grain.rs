//! The grain of pictures: how far colours are from those with 65,536 rays to the sky for each pixel, at the same samples.
//!
//! ```sh
//! cargo run --release --example grain -- FOLDER [BINARY]
//! ```
//! FOLDER holds 1IHM.pdb and 1tii.pdb of the wwPDB; the third picture is scenes/cover.toml. With the command of another
//! version as BINARY, its pictures are measured as well. docs/light.md has the table.

use halfline::read::ReadOptions;
use halfline::scene::{Light, Scene, Sky};
use halfline::settings::{Backend, Settings};
use halfline::window::Window;
use halfline::{Aov, Renderer};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Rays to the sky for each pixel that stand for all of it.
const TRUTH: u32 = 65_536;

struct Picture {
    name: &'static str,
    scene: Scene,
    /// Whether its look is soft: rays leave from the centres of pixels.
    soft: bool,
    /// The scene and its camera for the command.
    options: Vec<String>,
    windows: [Window; 2],
}

fn square(x0: u32, y0: u32) -> Window {
    Window { x0, y0, x1: x0 + 12, y1: y0 + 12 }
}

fn pictures(folder: &Path) -> Result<Vec<Picture>, Box<dyn Error>> {
    let soft = |file: &str, assembly: Option<&str>, zoom: f64| -> Result<Picture, Box<dyn Error>> {
        let path = folder.join(file);
        let options = ReadOptions { assembly: assembly.map(Into::into), ..ReadOptions::default() };
        let mut scene = Scene::read(&path, &options)?;
        scene.camera.zoom(zoom, scene.image.width, scene.image.height)?;
        scene.lighting.lights.push(Light::above_left(&scene.camera)?);
        let mut options = vec![path.display().to_string(), "--look".into(), "soft".into(), format!("--zoom={zoom}")];
        options.extend(assembly.map(|assembly| format!("--assembly={assembly}")));
        let name = if assembly.is_some() { "capsid" } else { "close-up" };
        Ok(Picture { name, scene, soft: true, options, windows: [square(248, 248), square(170, 200)] })
    };
    let cover = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cover.toml"));
    Ok(vec![
        soft("1IHM.pdb", Some("1"), 1.0)?,
        soft("1tii.pdb", None, 4.0)?,
        Picture {
            name: "cover",
            scene: Scene::read(&cover, &ReadOptions::default())?,
            soft: false,
            options: vec![cover.display().to_string()],
            windows: [square(500, 420), square(300, 380)],
        },
    ])
}

/// The colours of a window, with `rays` to the sky for each pixel, or as the picture has them.
fn color(
    renderer: &mut Renderer,
    picture: &Picture,
    samples: u32,
    rays: Option<u32>,
    window: Window,
) -> Result<Vec<f32>, Box<dyn Error>> {
    let mut scene = picture.scene.clone();
    let own = match picture.soft {
        // One sample has as many rays as usual.
        true if samples == 1 => Sky::default(),
        true => Sky { rays: 4, at_centers: true, ..Sky::default() },
        false => scene.lighting.sky.unwrap_or_default(),
    };
    let each = if own.at_centers { 1 } else { samples };
    scene.lighting.sky = Some(Sky { rays: rays.map_or(own.rays, |rays| rays / each), ..own });
    let settings = Settings {
        backend: Backend::Cpu,
        aovs: vec![Aov::Color],
        samples,
        silhouette: picture.soft,
        window: Some(window),
        ..Settings::default()
    };
    Ok(renderer.render(&scene, &settings)?.f32(Aov::Color).ok_or("no colours")?.to_vec())
}

/// The same of another version's command.
fn of_command(binary: &str, picture: &Picture, samples: u32, window: Window) -> Result<Vec<f32>, Box<dyn Error>> {
    let file = std::env::temp_dir().join(format!("halfline-grain-{}.pfm", std::process::id()));
    let Window { x0, y0, x1, y1 } = window;
    let mut command = Command::new(binary);
    command.arg("render").args(&picture.options).args(["--backend", "cpu", "--samples", &samples.to_string()]);
    command.arg("--crop").arg(format!("{x0},{y0},{x1},{y1}")).arg("-o").arg(&file);
    let done = command.output()?;
    if !done.status.success() {
        return Err(String::from_utf8_lossy(&done.stderr).into_owned().into());
    }
    let bytes = std::fs::read(&file)?;
    std::fs::remove_file(&file)?;
    // Three lines of text, then rows of f32 from the bottom.
    let lines: Vec<usize> = (0..bytes.len()).filter(|n| bytes[*n] == b'\n').take(3).collect();
    let [_, _, end] = lines[..] else { return Err("no PFM".into()) };
    let row = 3 * 4 * (x1 - x0) as usize;
    let rows = bytes[end + 1..].chunks_exact(row).take((y1 - y0) as usize).collect::<Vec<_>>();
    let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    Ok(rows.into_iter().rev().flat_map(|row| row.chunks_exact(4).map(number)).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(folder) = arguments.first() else { return Err("give the folder of 1IHM.pdb and 1tii.pdb".into()) };
    let mut renderer = Renderer::new(&Settings { backend: Backend::Cpu, ..Settings::default() })?;
    println!("| picture | samples | rms | of BINARY |\n|---|---|---|---|");
    for picture in pictures(Path::new(folder))? {
        for samples in [1, 4, 16, 64] {
            let mut sums = [0.0f64; 2];
            for window in picture.windows {
                let truth = color(&mut renderer, &picture, samples, Some(TRUTH), window)?;
                let mut found = vec![color(&mut renderer, &picture, samples, None, window)?];
                if let Some(binary) = arguments.get(1) {
                    found.push(of_command(binary, &picture, samples, window)?);
                }
                for (sum, found) in sums.iter_mut().zip(found) {
                    let square = |(a, b): (&f32, &f32)| (f64::from(*a) - f64::from(*b)).powi(2);
                    *sum += found.iter().zip(&truth).map(square).sum::<f64>() / truth.len() as f64;
                }
            }
            let [now, other] = sums.map(|sum| (sum / picture.windows.len() as f64).sqrt());
            println!("| {} | {samples} | {now:.5} | {other:.5} |", picture.name);
        }
    }
    Ok(())
}
