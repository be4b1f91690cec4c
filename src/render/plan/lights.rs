//! Requirements of the lights and materials of a scene.

use crate::cpu::light::LightOutputs;
use crate::frame::Aov;
use crate::scene::{BOUNCES, Materials, Scene};
use crate::settings::Settings;
use crate::shade::Shade;
use crate::view::directions::RIM;

/// The outputs of lights and sky that the settings request.
pub(super) fn outputs(scene: &Scene, settings: &Settings) -> LightOutputs {
    let lighting = &scene.lighting;
    let uses_lights = lighting.has_light() || bounces(scene) > 0;
    LightOutputs {
        depth: false,
        color: uses_lights && settings.shade == Shade::Headlight && settings.asks(&[Aov::Color]),
        shadow: settings.asks(&[Aov::Shadow]),
        occlusion: settings.asks(&[Aov::Occlusion]),
        sky: false,
    }
}

/// Whether rays leave from the hits of viewing rays, toward the sky or for shadows.
pub(super) fn leave_hits(outputs: LightOutputs, scene: &Scene) -> bool {
    let lighting = &scene.lighting;
    let of_picture = lighting.sky.is_some() || lighting.shadows && !lighting.lights.is_empty();
    // The host traces the rays from hits of cut spheres, which begin and end at planes.
    scene.spheres.cuts.is_none() && (outputs.shadow || outputs.occlusion || outputs.color && of_picture)
}

/// The most bounces of a ray of the picture; 0 where no material asks for any.
pub(crate) fn bounces(scene: &Scene) -> u32 {
    let can_bounce = scene.spheres.materials.as_ref().is_some_and(Materials::bounce);
    if can_bounce { scene.lighting.bounces.unwrap_or(BOUNCES) } else { 0 }
}

/// Points of a light with a size for each pixel, over all its samples.
const LIGHT_POINTS: u32 = 64;

/// The rays of a pixel to one light with a size, over all its samples; one sample has more rays, to the rim.
pub(crate) fn light_rays(samples: u32) -> u32 {
    light_points(samples) * samples + if samples == 1 { RIM } else { 0 }
}

/// The points of a light with a size for each of so many samples of a pixel.
pub(crate) fn light_points(samples: u32) -> u32 {
    LIGHT_POINTS.div_ceil(samples.max(1))
}
