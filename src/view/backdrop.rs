//! The background: the colours of rays that hit nothing.

use super::View;
use crate::scene::{Gradient, Scene};
use glam::{DVec3, Vec3};

/// The background of a view: one colour, or the colours of the sky.
pub(crate) struct Backdrop<'a> {
    view: &'a View,
    flat: DVec3,
    sky: Option<Gradient>,
}

impl<'a> Backdrop<'a> {
    /// The background of a scene; `uses_lights` says whether its sky lights the picture, which shows the sky's colours then.
    pub(crate) fn new(scene: &Scene, view: &'a View, uses_lights: bool) -> Self {
        let flat = Vec3::from_array(scene.image.background).as_dvec3();
        Self { view, flat, sky: Gradient::of(scene).filter(|sky| uses_lights && sky.is_shown) }
    }

    /// Linear RGB in a direction of length 1.
    pub(crate) fn toward(&self, direction: DVec3) -> DVec3 {
        self.sky.map_or(self.flat, |sky| sky.toward(direction))
    }

    /// Linear RGB of a pixel of the view.
    pub(crate) fn at(&self, pixel: u32) -> [f32; 3] {
        let Some(sky) = self.sky else { return self.flat.as_vec3().to_array() };
        let [i, j] = self.view.record.position(pixel);
        let direction = self.view.to_world(self.view.direction(i, j)).try_normalize();
        direction.map_or(self.flat, |direction| sky.toward(direction)).as_vec3().to_array()
    }
}
