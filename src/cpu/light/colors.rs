//! Colours that need no rays, for eight pixels at once: the same bits as one by one.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays")]

use super::lighting::LightingContext;
use crate::answers::light::Chunk;
use crate::answers::open_sky::SkySums;
use crate::number::larger;
use crate::number::vector::LANES;
use crate::scene::Material;
use crate::view::RayKind;
use crate::view::picture_rays::PictureRays;
use crate::view::ray::NONE;
use bytemuck::Zeroable;
use glam::{DVec3, Vec3};
use pulp::NullaryFnOnce;

/// Some pixels of a frame without shadows, mirrors and highlights, whose open sky is known.
pub(super) struct Colors<'a, 'b, 'c> {
    pub(super) lighting: &'a LightingContext<'a>,
    pub(super) rays: &'a PictureRays<'a>,
    pub(super) ids: &'a [u32],
    pub(super) chunk: &'b mut Chunk<'c>,
}

/// Numbers of some pixels before their colours, one array per component. Lanes that show no sphere are not read.
#[derive(Zeroable)]
struct Lanes {
    position: [[u32; LANES]; 2],
    center: [[f64; LANES]; 3],
    radius: [f64; LANES],
    own: [[f64; LANES]; 3],
    /// The vectors of the rays toward the sky.
    sky: [[[f64; LANES]; 3]; 4],
}

/// The components of a vector in one lane.
#[inline(always)]
fn lane(components: &[[f64; LANES]; 3], l: usize) -> DVec3 {
    DVec3::new(components[0][l], components[1][l], components[2][l])
}

impl Colors<'_, '_, '_> {
    /// Whether all spheres of a scene reflect only diffusely or are of ink, and the rays are those of a perspective camera.
    pub(super) fn fit(lighting: &LightingContext<'_>) -> bool {
        let is_plain = |kind: &Material| *kind == Material::default() || *kind == Material::Ink;
        let materials = lighting.scene.spheres.materials.as_ref();
        let is_perspective = lighting.view.kind() == RayKind::Perspective;
        materials.is_none_or(|materials| materials.kinds.iter().all(is_plain)) && is_perspective
    }

    #[inline(always)]
    fn gathered(&self, first: usize) -> Lanes {
        let (lighting, record) = (self.lighting, &self.lighting.view.record);
        let spheres = &lighting.scene.spheres;
        let (mut lanes, pixel) = (Lanes::zeroed(), (self.chunk.first + first) as u32);
        lanes.position = record.positions(pixel);
        for ((l, &id), [row, column]) in self.ids[first..].iter().take(LANES).enumerate().zip(record.places(pixel)) {
            if id == NONE {
                continue;
            }
            let sky = lighting.open.map(|open| open.around(row, column, id)).unwrap_or_default();
            for (lanes, sum) in lanes.sky.iter_mut().zip([sky.all, sky.open, sky.zenith[0], sky.zenith[1]]) {
                (lanes[0][l], lanes[1][l], lanes[2][l]) = (sum.x, sum.y, sum.z);
            }
            let (center, own) = (spheres.centers[id as usize], lighting.own_color(id).to_array());
            lanes.radius[l] = spheres.radii[id as usize];
            for k in 0..3 {
                (lanes.center[k][l], lanes.own[k][l]) = (center[k], own[k]);
            }
        }
        lanes
    }
}

impl NullaryFnOnce for Colors<'_, '_, '_> {
    /// The pixels that are left: f64 alone does not know their normals, or they show ink.
    type Output = Vec<usize>;

    #[inline(always)]
    fn call(self) -> Vec<usize> {
        let Self { lighting, rays, ids, .. } = self;
        let lighted = &lighting.scene.lighting;
        let lights: Vec<_> = lighted
            .lights
            .iter()
            .filter_map(|light| {
                let color = Vec3::from_array(light.color).as_dvec3() * f64::from(light.intensity);
                light.source.far().map(|direction| (direction, color))
            })
            .collect();
        let share = lighted.sky.map(|sky| f64::from(sky.share));
        let Material::Phong { diffuse, .. } = Material::default() else { return (0..ids.len()).collect() };
        let materials = lighting.scene.spheres.materials.as_ref();
        let mut left = Vec::new();
        for first in (0..ids.len()).step_by(LANES) {
            let lanes = self.gathered(first);
            let (mut near, mut facing) = ([0u64; LANES], [0.0; LANES]);
            let mut normal = [[0.0; LANES]; 3];
            for l in 0..LANES {
                let position = [lanes.position[0][l], lanes.position[1][l]];
                let hit =
                    rays.hit_at(RayKind::Perspective, position, lane(&lanes.center, l).to_array(), lanes.radius[l]);
                near[l] = u64::from(hit.near);
                facing[l] = larger(-hit.along.dot(hit.normal), 0.0);
                (normal[0][l], normal[1][l], normal[2][l]) = (hit.normal.x, hit.normal.y, hit.normal.z);
            }
            let mut white = [[0.0; LANES]; 3];
            for l in 0..LANES {
                let light = match share {
                    Some(share) => {
                        let [all, open, zenith, open_zenith] = [0, 1, 2, 3].map(|k| lane(&lanes.sky[k], l));
                        let sums = SkySums { all, open, zenith: [zenith, open_zenith], rays: 1 };
                        sums.light(lane(&normal, l), lighting.colors.as_ref()) * share
                    }
                    None if lights.is_empty() => DVec3::splat(facing[l]),
                    None => DVec3::ZERO,
                };
                (white[0][l], white[1][l], white[2][l]) = (light.x, light.y, light.z);
            }
            for (direction, color) in &lights {
                for l in 0..LANES {
                    let light = color * larger(lane(&normal, l).dot(*direction), 0.0);
                    white[0][l] += light.x;
                    white[1][l] += light.y;
                    white[2][l] += light.z;
                }
            }
            let mut rgb = [[0.0f32; LANES]; 3];
            for k in 0..3 {
                for l in 0..LANES {
                    rgb[k][l] = (lanes.own[k][l] * white[k][l] * f64::from(diffuse)) as f32;
                }
            }
            for (l, &id) in ids[first..].iter().take(LANES).enumerate() {
                let n = first + l;
                if id == NONE {
                    let pixel = (self.chunk.first + n) as u32;
                    self.chunk.color[3 * n..3 * n + 3].copy_from_slice(&lighting.backdrop.at(pixel));
                } else if near[l] != 0 && materials.is_none_or(|materials| !materials.is_ink(id)) {
                    self.chunk.color[3 * n..3 * n + 3].copy_from_slice(&[rgb[0][l], rgb[1][l], rgb[2][l]]);
                } else {
                    left.push(n);
                }
            }
        }
        left
    }
}
