//! Colours that need no rays, for eight pixels at once: the same bits as one by one.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays")]

use super::lighting::LightingContext;
use super::run::{Run, lane};
use crate::answers::open_sky::SkySums;
use crate::number::larger;
use crate::number::vector::LANES;
use crate::scene::Material;
use crate::view::RayKind;
use crate::view::picture_rays::PictureHits;
use crate::view::ray::NONE;
use bytemuck::Zeroable;
use glam::{DVec3, Vec3};
use pulp::NullaryFnOnce;

/// The colours of pixels of a frame without shadows, mirrors and highlights, whose open sky is known.
pub(super) struct Colors<'a, 'b, 'c>(pub(super) Run<'a, 'b, 'c>);

/// Numbers of some pixels before their colours, one array per component. Lanes that show no sphere are not read.
#[derive(Zeroable)]
struct Lanes {
    own: [[f64; LANES]; 3],
    /// The vectors of the rays toward the sky.
    sky: [[[f64; LANES]; 3]; 4],
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
        let Run { lighting, ids, .. } = self.0;
        let (mut lanes, places) = (Lanes::zeroed(), lighting.view.record.places(self.0.pixel(first)));
        for ((l, &id), [row, column]) in ids[first..].iter().take(LANES).enumerate().zip(places) {
            if id == NONE {
                continue;
            }
            let sky = lighting.open.map(|open| open.around(row, column, id)).unwrap_or_default();
            for (lanes, sum) in lanes.sky.iter_mut().zip([sky.all, sky.open, sky.zenith[0], sky.zenith[1]]) {
                (lanes[0][l], lanes[1][l], lanes[2][l]) = (sum.x, sum.y, sum.z);
            }
            let own = lighting.own_color(id);
            (lanes.own[0][l], lanes.own[1][l], lanes.own[2][l]) = (own.x, own.y, own.z);
        }
        lanes
    }
}

impl NullaryFnOnce for Colors<'_, '_, '_> {
    /// The pixels that are left: f64 alone does not know their normals, or they show ink.
    type Output = Vec<usize>;

    #[inline(always)]
    fn call(self) -> Vec<usize> {
        let Run { lighting, rays, ids, .. } = self.0;
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
            let PictureHits { normal, facing, near, .. } = rays.hits(&self.0.shown(first));
            let mut white = [[0.0; LANES]; 3];
            for l in 0..LANES {
                let light = match share {
                    Some(share) => {
                        let [all, open, zenith, open_zenith] = [0, 1, 2, 3].map(|k| lane(&lanes.sky[k], l));
                        let sums = SkySums { all, open, zenith: [zenith, open_zenith], rays: 1 };
                        sums.light(lane(&normal, l), lighting.colors.as_ref()) * share
                    }
                    None if lights.is_empty() => DVec3::splat(larger(facing[l], 0.0)),
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
                    let background = lighting.backdrop.at(self.0.pixel(n));
                    self.0.chunk.color[3 * n..3 * n + 3].copy_from_slice(&background);
                } else if near[l] != 0 && materials.is_none_or(|materials| !materials.is_ink(id)) {
                    self.0.chunk.color[3 * n..3 * n + 3].copy_from_slice(&[rgb[0][l], rgb[1][l], rgb[2][l]]);
                } else {
                    left.push(n);
                }
            }
        }
        left
    }
}
