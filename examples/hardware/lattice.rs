//! Equal spheres on a lattice, whose rectangles end within thousandths of a pixel of where the device takes another kernel for a
//! sphere. Kernels that disagree there would lose it.

use super::Result;
use super::cloud::Random;
use super::scenes::certified;
use halfline::{Aov, Backend, Camera, ImagePlane, Lens, Renderer, Scene, Spheres};
use serde_json::{Value, json};

/// Frames of device and CPU path, and what differs.
struct Tally {
    device: Renderer,
    host: Renderer,
    frames: u64,
    pixels: u64,
    wrong: u64,
    settled: u64,
    cases: Vec<Value>,
}

impl Tally {
    fn new() -> Result<Self> {
        let [device, host] = [Backend::Gpu, Backend::Cpu].map(|backend| Renderer::new(&certified(backend, &[Aov::Id])));
        let (device, host) = (device?, host?);
        Ok(Self { device, host, frames: 0, pixels: 0, wrong: 0, settled: 0, cases: Vec::new() })
    }

    /// Renders spheres of a size in pixels, given the positions of their centres in the image.
    fn add(&mut self, side: u32, lens: Lens, half: f64, centers: impl Iterator<Item = [f64; 2]>) -> Result<()> {
        let mut spheres = Spheres::default();
        for [x, y] in centers {
            let middle = f64::from(side) / 2.0;
            spheres.push([x + 0.5 - middle, y - middle, -DISTANCE], half - 0.001, None);
        }
        let camera = Camera { lens, ..Camera::CANONICAL };
        let image = ImagePlane { width: side, height: side, background: [0.0; 3] };
        let scene = Scene { camera, image, spheres, lighting: Default::default() };
        let on = self.device.render(&scene, &certified(Backend::Gpu, &[Aov::Id]))?;
        let off = self.host.render(&scene, &certified(Backend::Cpu, &[Aov::Id]))?;
        let wrong = on.ids().iter().zip(off.ids()).filter(|(a, b)| a != b).count() as u64;
        if wrong > 0 && self.cases.len() < 10 {
            let search = on.report.search;
            self.cases.push(json!({ "frame": self.frames, "half": half, "wrong": wrong, "search": search }));
        }
        self.frames += 1;
        self.pixels += u64::from(side * side);
        self.wrong += wrong;
        self.settled += on.report.settled;
        Ok(())
    }
}

/// Of the spheres from the eye, in pixels.
const DISTANCE: f64 = 1000.0;

/// The part of a pixel by which the device widens a rectangle, and its share of the rectangle's half side
/// (shaders/place/rectangle.wgsl), as they add up at the edges of the larger spheres.
const WIDER: [f64; 2] = [3.7e-4, 1e-5];

/// Small spheres in 160 frames and large ones in 60.
pub(crate) fn lattice() -> Result {
    let mut tally = Tally::new()?;
    let mut random = Random(77);
    // With 16 rows a rectangle has 16 or 17 columns, and 17 are too many for one invocation.
    for case in 0..160 {
        let (side, apart) = (512, 20.0);
        let across = (f64::from(side) / apart) as i32;
        let lens = match case % 4 {
            3 => Lens::Viewport { vw: f64::from(side), vh: f64::from(side), distance: DISTANCE },
            _ => Lens::Orthographic { height: f64::from(side) },
        };
        let half = 8.05 + 0.35 * random.unit();
        let center = |n: i32| {
            let [i, j] = [n / across, n % across].map(f64::from);
            // Edges lie at centres of pixels but for another part of a pixel each: in fine steps about what rectangles are widened
            // by, and in wide ones.
            let part = f64::from(n) / f64::from(across * across) - 0.5;
            let offset = if case % 4 < 2 { 1.9e-4 + 3e-4 * part } else { 6e-3 * (part + 0.2) };
            [i * apart + 12.0 + half + offset, j * apart + 12.5]
        };
        tally.add(side, lens, half, (0..across * across).map(center))?;
    }
    // 128 or 129 columns are 4 or 5 pieces.
    for _ in 0..60 {
        let side = 1024;
        let half = 64.05 + 0.35 * random.unit();
        let center = |n: i32| {
            let offset = WIDER[1] * half + WIDER[0] + 2e-6 * (f64::from(n) - 17.5);
            [f64::from(n % 6) * 150.0 + 70.0 + half + offset, f64::from(n / 6) * 150.0 + 70.5 + half.floor()]
        };
        tally.add(side, Lens::Orthographic { height: f64::from(side) }, half, (0..36).map(center))?;
    }
    let Tally { frames, pixels, wrong, settled, cases, .. } = tally;
    Ok(json!({
        "frames": frames, "pixels": pixels, "wrong": wrong, "settled": settled, "cases": cases, "good": wrong == 0,
    }))
}
