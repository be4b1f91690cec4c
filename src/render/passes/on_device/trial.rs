//! The trial of a device that draws pictures: a small one, before the first picture of a renderer, beside the host's.

use crate::frame::report::milliseconds;
use crate::frame::{Aov, Data, Frame};
use crate::render::renderer::Renderer;
use crate::scene::camera::{Camera, Lens, Look};
use crate::scene::{ImagePlane, Light, LightSource, Lighting, Scene, Sky, SkyColors, Spheres};
use crate::settings::{Accuracy, Settings};
use glam::DVec3;
use halfline_ground::error::Result;
use web_time::Instant;

/// The most that a colour differs: normals of hits are within 1e-3 of the true ones on either side, the light of a surface changes
/// with the normal by at most as much as colour times 1 for the sun and 1 for the sky, and sums over rays are rounded to 2^-16.
pub(super) const MOST: f32 = 2e-3;
/// The share of values that may differ by more: where a comparison decides, of depths for a line or of a neighbour's rays.
pub(super) const DECIDED: f64 = 1e-4;

/// A few spheres of several sizes and colours on a ground, with a sun and a sky.
pub(super) fn scene() -> Scene {
    let mut spheres = Spheres::default();
    spheres.push([0.0, -101.0, 0.0], 100.0, Some([0.4, 0.5, 0.3]));
    for n in 0..24u32 {
        let [x, y, z] = [n % 6, n * 5 % 7, n / 6].map(f64::from);
        let color = [0.3 + 0.1 * x as f32, 0.9 - 0.1 * y as f32, 0.5];
        spheres.push([0.6 * x - 1.5, 0.3 * y - 0.8, 0.7 * z - 1.0], 0.12 + 0.05 * y, Some(color));
    }
    let camera = Camera {
        eye: DVec3::new(0.4, 0.7, 5.0),
        look: Look::At(DVec3::ZERO),
        lens: Lens::Vfov { degrees: 40.0, distance: 1.0 },
        ..Camera::CANONICAL
    };
    let sun = LightSource::Direction(DVec3::new(-0.4, 0.8, 0.5).normalize());
    let light = Light { source: sun, color: [0.9; 3], intensity: 0.6 };
    let colors = SkyColors { zenith: [0.3, 0.5, 1.0], horizon: [1.0, 0.9, 0.8], is_shown: true };
    let sky = Sky { share: 0.5, colors: Some(colors), ..Sky::AT_CENTERS };
    Scene {
        camera,
        image: ImagePlane { width: 96, height: 72, background: [0.9, 0.95, 1.0] },
        spheres,
        lighting: Lighting { lights: vec![light], sky: Some(sky), ..Lighting::default() },
    }
}

/// The linear RGB of a picture; empty without.
pub(super) fn colors(frame: &Frame) -> &[f32] {
    match frame.get(Aov::Color).map(|buffer| &buffer.data) {
        Some(Data::F32(values)) => values,
        _ => &[],
    }
}

/// Whether two pictures differ by no more than roundings, and are pictures.
pub(super) fn is_alike(a: &[f32], b: &[f32]) -> bool {
    let near = a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() <= MOST).count();
    a.len() == b.len() && !a.is_empty() && (a.len() - near) as f64 <= DECIDED * a.len() as f64
}

impl Renderer {
    /// Has the device draw a small picture, unless it did before or leaves pictures to the host, and compares it with the host's, as a
    /// part of the setup. An error of the device becomes an error of the frame that follows.
    pub(in crate::render) fn try_drawing(&mut self) {
        let Some(gpu) = self.device.gpu.as_mut().filter(|gpu| gpu.draws.is_none()) else { return };
        gpu.draws = Some(true);
        let start = Instant::now();
        let watch = std::mem::take(&mut self.watch);
        let is_alike = self.draws_alike();
        self.watch = watch;
        self.setup_ms += milliseconds(start);
        if let Some(gpu) = &mut self.device.gpu {
            gpu.draws = Some(is_alike.unwrap_or(false));
        }
    }

    fn draws_alike(&mut self) -> Result<bool> {
        let settings = Settings {
            aovs: vec![Aov::Color],
            accuracy: Accuracy::Certified,
            samples: 4,
            silhouette: true,
            depth_cue: true,
            ..Settings::default()
        };
        let scene = scene();
        let drawn = self.render(&scene, &settings)?;
        let expected = self.on_host(|this| this.render(&scene, &settings))?;
        Ok(is_alike(colors(&drawn), colors(&expected)))
    }
}
