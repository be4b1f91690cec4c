//! Spheres that are lights, where spheres are arranged.

use glam::DVec3;
use halfline::scene::{Light, LightSource, Scene, Spheres};

/// The spheres that are lights. Clip planes may remove them and change the ids of those that stay.
pub(super) struct SphereLights(Vec<SphereLight>);

struct SphereLight {
    /// The index of the light.
    light: usize,
    center: [f64; 3],
    radius: f64,
    /// The number of equal spheres before it: a plane removes all of them or none.
    before: usize,
}

impl SphereLights {
    /// The lights of a scene that are spheres.
    pub(super) fn of(scene: &Scene) -> Self {
        let Spheres { centers, radii, .. } = &scene.spheres;
        let sphere = |(light, found): (usize, &Light)| {
            let LightSource::Sphere(id) = found.source else { return None };
            let (center, radius) = (*centers.get(id as usize)?, *radii.get(id as usize)?);
            let before = equal(&scene.spheres, center, radius).take_while(|other| *other < id as usize).count();
            Some(SphereLight { light, center, radius, before })
        };
        Self(scene.lighting.lights.iter().enumerate().filter_map(sphere).collect())
    }

    /// Gives the lights their new ids. A light whose sphere was removed shines from the same place.
    pub(super) fn follow(&self, scene: &mut Scene) {
        for SphereLight { light, center, radius, before } in &self.0 {
            let id = equal(&scene.spheres, *center, *radius).nth(*before).and_then(|id| u32::try_from(id).ok());
            let gone = LightSource::Ball { center: DVec3::from_array(*center), radius: *radius };
            scene.lighting.lights[*light].source = id.map_or(gone, LightSource::Sphere);
        }
    }
}

/// The spheres with this centre and radius.
fn equal(spheres: &Spheres, center: [f64; 3], radius: f64) -> impl Iterator<Item = usize> {
    let all = spheres.centers.iter().zip(&spheres.radii).enumerate();
    all.filter(move |(_, (c, r))| **c == center && **r == radius).map(|(id, _)| id)
}
