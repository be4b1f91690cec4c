//! The scenes of the kit, their settings, and what is reported of a frame.

use super::Result;
use super::cloud::cloud;
use halfline::frame::Frame;
use halfline::settings::{AddedLight, Look};
use halfline::{Accuracy, Aov, Backend, Scene, Settings, Sky};
use serde_json::{Value, json};

/// Certified frames.
pub(crate) fn certified(backend: Backend, aovs: &[Aov]) -> Settings {
    Settings { backend, accuracy: Accuracy::Certified, aovs: aovs.to_vec(), ..Settings::default() }
}

/// A cloud that no one changes, in one of the looks of the kit, and the settings of its frames: `plain` has colours of a headlight,
/// `answers` buffers of them too, `soft` a sky, a sun, outlines and four samples, `occlusion16` the open share of the sky by 16
/// rays a pixel.
pub(crate) fn looked(count: usize, look: &str, side: u32, backend: Backend) -> Result<(Scene, Settings)> {
    let mut scene = cloud(count);
    (scene.image.width, scene.image.height) = (side, side);
    scene.image.background = [0.1, 0.1, 0.12];
    let mut settings = certified(backend, &[Aov::Color, Aov::Id]);
    match look {
        "plain" => {}
        "answers" => settings.aovs.extend([Aov::Distance, Aov::Normal, Aov::Mask]),
        "soft" => {
            AddedLight { look: Look::Soft, ..AddedLight::default() }.apply(&mut scene, &settings.aovs)?;
            (settings.samples, settings.silhouette) = (4, true);
        }
        _ => {
            let rays = look.strip_prefix("occlusion").ok_or("an unknown look")?.parse()?;
            settings.aovs = vec![Aov::Id, Aov::Occlusion];
            scene.lighting.sky = Some(Sky { rays, ..Sky::default() });
        }
    }
    scene.spheres.share();
    Ok((scene, settings))
}

/// The main values of a frame's report, as JSON.
pub(crate) fn report_json(frame: &Frame) -> Value {
    let report = &frame.report;
    json!({
        "search": report.search, "backend": report.backend, "adapter": report.adapter, "hits": report.hits,
        "settled": report.settled, "light_on_device": report.light_on_device, "bytes_up": report.bytes_up,
        "bytes_down": report.bytes_down, "stages_ms": report.stages_ms, "warnings": report.warnings,
    })
}

/// The middle one of some times.
pub(crate) fn median(times: &[f64]) -> f64 {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The times of some frames.
#[derive(Default)]
pub(crate) struct Times([Vec<f64>; 3]);

impl Times {
    /// Adds a frame.
    pub(crate) fn add(&mut self, frame: &Frame) {
        let report = &frame.report;
        for (times, new) in self.0.iter_mut().zip([&report.frame_ms, &report.host_ms, &report.kernel_ms]) {
            times.extend(new);
        }
    }

    /// Adds the times of another renderer.
    pub(crate) fn join(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(times, more)| times.extend(more));
    }

    /// The share of the time in which the device had work.
    pub(crate) fn busy(&self) -> f64 {
        let [frame, host, _] = self.0.each_ref().map(|times| times.iter().sum::<f64>());
        1.0 - host / frame
    }

    /// Their medians.
    pub(crate) fn medians(&self) -> Value {
        let [frame, host, kernel] = &self.0;
        let [frame_ms, host_ms, kernel_ms] = [frame, host, kernel].map(|times| median(times));
        json!({ "frame_ms": frame_ms, "host_ms": host_ms, "kernel_ms": kernel_ms, "frames": frame.len() })
    }
}
