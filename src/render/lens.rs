//! A lens with a size: each pass over the samples leaves from one of its points, as from an eye of its own.

use crate::frame::Aov;
use crate::scene::Scene;
use crate::scene::camera::{Aperture, Camera, CentredFrame};
use crate::settings::Settings;
use crate::view::directions::lens_point;
use crate::view::raster::Raster;
use crate::window::Window;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::SAMPLES;

/// A scene and its rays as seen from the points of a lens, one point for each sample.
pub(super) struct LensPasses {
    aperture: Aperture,
    /// The camera whose eye is the middle of the lens, and its frame.
    camera: Camera,
    frame: CentredFrame,
    raster: Raster,
    scene: Scene,
}

impl LensPasses {
    /// The passes of a frame over the points of the lens; `None` for a pinhole.
    ///
    /// # Errors
    /// Errors of [`Camera::viewport`].
    pub(super) fn new(scene: &Scene, settings: &Settings, raster: Raster) -> Result<Option<Self>> {
        let Some(aperture) = settings.aperture else { return Ok(None) };
        let frame = scene.camera.centred([scene.image.width, scene.image.height], raster.strata, raster.jitter)?;
        let (camera, mut scene) = (scene.camera, scene.clone());
        scene.spheres.share();
        Ok(Some(Self { aperture, camera, frame, raster, scene }))
    }

    /// The scene whose eye is the point of the lens that this sample leaves from, and its rays of a window.
    ///
    /// # Errors
    /// Errors of [`Aperture::distance`].
    pub(super) fn pass(&mut self, sample: u32, window: Window) -> Result<(&Scene, Raster)> {
        let point = lens_point(self.raster.strata, sample, self.raster.seed);
        let (camera, lens_offset) = self.aperture.at(point, &self.camera, &self.frame)?;
        self.scene.camera = camera;
        Ok((&self.scene, Raster { window, lens_offset, ..self.raster }))
    }
}

/// The samples, with room in their frame for the offsets of a lens's points.
///
/// # Errors
/// [`Error::Settings`] for a lens with a size and one sample per pixel; errors of [`Aperture::distance`] and of
/// [`Raster::with_margin`].
pub(super) fn raster(samples: Option<Raster>, scene: &Scene, settings: &Settings) -> Result<Option<Raster>> {
    let Some(aperture) = settings.aperture else { return Ok(samples) };
    let reach = aperture.reach(&scene.camera, [scene.image.width, scene.image.height])?;
    match samples {
        Some(samples) => samples.with_margin(reach, &scene.image).map(Some),
        None if settings.asks(&[Aov::Color, Aov::Alpha]) => {
            let problem = "a lens with a size needs several samples per pixel, which leave from its points";
            Err(Error::settings(problem, format!("use more samples, such as {SAMPLES} 64, or remove the aperture")))
        }
        None => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::Judge;
    use crate::render::Renderer;
    use crate::scene::camera::{Lens, Look};
    use crate::scene::{ImagePlane, Spheres};
    use crate::settings::{Accuracy, Backend};
    use crate::shade::Shade;
    use crate::testing::Rng;
    use crate::view::{Records, View};
    use crate::window::Window;
    use glam::DVec3;

    /// Samples of a pixel, and digits of a channel that count them: 5 x 4 bits are exact in f32.
    const SAMPLES: u32 = 9;
    const DIGITS: usize = 5;

    /// 15 spheres near and far, whose colours are digits: the mean colour of a pixel says how many of its samples show each.
    fn scene(lens: Lens) -> Scene {
        let mut rng = Rng(5);
        let mut spheres = Spheres::default();
        for n in 0..3 * DIGITS {
            let center = [rng.between(-4.0, 4.0), rng.between(-3.0, 3.0), rng.between(-14.0, -3.0)];
            let mut color = [0.0; 3];
            color[n / DIGITS] = 16f32.powi(-1 - (n % DIGITS) as i32);
            spheres.push(center, rng.between(0.4, 1.4), Some(color));
        }
        Scene {
            camera: Camera {
                eye: DVec3::new(0.3, 0.2, 1.0),
                look: Look::At(DVec3::new(0.0, 0.0, -7.0)),
                up: DVec3::Y,
                lens,
            },
            image: ImagePlane { width: 41, height: 27, background: [0.0; 3] },
            spheres,
            lighting: Default::default(),
        }
    }

    /// The judge, who knows nothing of lenses, has for each point of the lens the camera of a larger image.
    #[test]
    fn every_sample_is_the_exact_ray_of_its_point_of_the_lens() {
        let lenses =
            [Lens::Vfov { degrees: 50.0, distance: 1.5 }, Lens::Intrinsics { fx: 40.0, fy: 40.0, cx: 17.25, cy: 16.0 }];
        for (lens, focus) in lenses.into_iter().flat_map(|lens| [(lens, None), (lens, Some(4.0))]) {
            let scene = scene(lens);
            let aperture = Some(Aperture { diameter: 0.8, focus });
            let settings = Settings {
                backend: Backend::Cpu,
                accuracy: Accuracy::Certified,
                shade: Shade::Flat,
                aovs: vec![Aov::Color, Aov::Alpha],
                samples: SAMPLES,
                seed: 3,
                aperture,
                ..Settings::default()
            };
            let frame = Renderer::new(&settings).expect("the CPU path").render(&scene, &settings).expect("a frame");
            let color = frame.f32(Aov::Color).expect("colours");
            let ImagePlane { width, height, .. } = scene.image;
            let window = Window::full(width, height);
            let samples = Raster::samples(window, SAMPLES, settings.seed, &scene.image).expect("room");
            let raster = raster(samples, &scene, &settings).expect("room").expect("samples");
            let mut passes = LensPasses::new(&scene, &settings, raster).expect("a camera").expect("a lens");
            let mut counts = vec![[0u32; 3 * DIGITS]; (width * height) as usize];
            let mut eyes = Vec::new();
            for sample in 0..SAMPLES {
                let (pass_scene, raster) = passes.pass(sample, window).expect("a point");
                let mut view = View::for_rays(pass_scene, raster, Records::None).expect("a view");
                view.record.sample = sample;
                let viewport = view.viewport.expect("a viewport");
                let ([vw, vh], distance) = (viewport.rounded(), viewport.d);
                let lens = Lens::Viewport { vw, vh, distance };
                let image = ImagePlane { width: view.record.width, height: view.record.height, ..pass_scene.image };
                let alone = Scene { camera: Camera { lens, ..pass_scene.camera }, image, ..pass_scene.clone() };
                let judge = Judge::new(&alone).expect("a judge");
                eyes.push(pass_scene.camera.eye);
                for (row, column) in (0..height).flat_map(|i| (0..width).map(move |j| (i, j))) {
                    let [i, j] = view.record.sample_position(row, column);
                    if let Some(truth) = judge.pixel(i, j) {
                        counts[(row * width + column) as usize][truth.id as usize] += 1;
                    }
                }
            }
            let far = eyes.iter().map(|eye| (*eye - scene.camera.eye).length()).fold(0.0, f64::max);
            assert!(far > 0.3 && far < 0.4, "eyes all over the lens: {far}");
            let mut mixed = 0;
            for (pixel, counts) in counts.iter().enumerate() {
                let digits: Vec<u32> = (0..3 * DIGITS)
                    .map(|n| {
                        let sum =
                            (f64::from(color[3 * pixel + n / DIGITS]) * f64::from(SAMPLES) * 16f64.powi(5)).round();
                        (sum as u32) >> (4 * (DIGITS - 1 - n % DIGITS)) & 15
                    })
                    .collect();
                assert_eq!(digits, counts, "{lens:?} {focus:?} pixel {pixel}");
                mixed += u32::from(counts.iter().filter(|n| **n > 0).count() > 1);
            }
            assert!(mixed > 10, "{mixed} pixels show several spheres");
        }
    }
}
