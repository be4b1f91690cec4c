//! Colours that need no rays, for eight pixels at once: the same bits as one by one.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays")]

use super::lighting::LightingContext;
use super::run::{Run, lane};
use crate::answers::open_sky::{SkyLanes, light_of_lanes};
use crate::cpu::certified::triples::{Portable, Triples};
use crate::number::larger;
use crate::number::vector::LANES;
use crate::scene::Material;
use crate::view::RayKind;
use crate::view::picture_rays::PictureHits;
use crate::view::ray::NONE;
use bytemuck::Zeroable;
use glam::Vec3;
use pulp::NullaryFnOnce;

/// The colours of pixels of a frame without shadows, mirrors and highlights, whose open sky is known.
pub(super) struct Colors<'a, 'b, 'c>(pub(super) Run<'a, 'b, 'c>);

/// Numbers of some pixels before their colours, one array per component. Lanes that show no sphere are not read.
#[derive(Zeroable)]
struct Lanes {
    own: [[f32; LANES]; 3],
    /// The rays toward the sky.
    sky: SkyLanes,
}

impl Colors<'_, '_, '_> {
    /// Whether all spheres of a scene reflect only diffusely or are of ink, and the rays come from a perspective camera.
    pub(super) fn fit(lighting: &LightingContext<'_>) -> bool {
        let is_plain = |kind: &Material| *kind == Material::default() || *kind == Material::Ink;
        let materials = lighting.scene.spheres.materials.as_ref();
        let is_perspective = lighting.view.kind() == RayKind::Perspective;
        materials.is_none_or(|materials| materials.kinds.iter().all(is_plain)) && is_perspective
    }

    #[inline(always)]
    fn gathered(&self, first: usize, ids: &[u32]) -> Lanes {
        let (mut lanes, lighting) = (Lanes::zeroed(), self.0.lighting);
        if let Some(open) = lighting.open {
            lanes.sky = open.of_run(&lighting.view.record, self.0.pixel(first), ids);
        }
        for (l, &id) in ids.iter().enumerate().filter(|(_, id)| **id != NONE) {
            [lanes.own[0][l], lanes.own[1][l], lanes.own[2][l]] = lighting.own_color(id, false).to_array();
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
        for (n, ids) in ids.chunks(LANES).enumerate() {
            let first = n * LANES;
            let mut lanes = self.gathered(first, ids);
            let hits = rays.hits(&self.0.shown(first));
            if let Some(depths) = self.0.chunk.depth.get_mut(first..) {
                rays.write_depths(&hits, ids, depths);
            }
            let PictureHits { normal, facing, near, face, .. } = hits;
            for (l, id) in ids.iter().enumerate().filter(|(l, _)| face[*l]) {
                [lanes.own[0][l], lanes.own[1][l], lanes.own[2][l]] = lighting.own_color(*id, true).to_array();
            }
            let mut white = [[0.0; LANES]; 3];
            match share {
                Some(share) => {
                    let sky = light_of_lanes(&lanes.sky, &normal, lighting.colors.as_ref());
                    for k in 0..3 {
                        for l in 0..LANES {
                            white[k][l] = f64::from(sky[k][l]) * share;
                        }
                    }
                }
                None if lights.is_empty() => {
                    for l in 0..LANES {
                        white[0][l] = larger(facing[l], 0.0);
                    }
                    white = [white[0]; 3];
                }
                None => {}
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
                    rgb[k][l] = (f64::from(lanes.own[k][l]) * white[k][l] * f64::from(diffuse)) as f32;
                }
            }
            let plain = (0..ids.len()).fold(materials.is_none(), |all, l| all & (ids[l] != NONE) & (near[l] != 0));
            if let (true, Some(colors)) = (plain, self.0.chunk.color[3 * first..].first_chunk_mut()) {
                *colors = bytemuck::cast::<_, [f32; 3 * LANES]>(Portable.of(&rgb));
                continue;
            }
            for (l, &id) in ids.iter().enumerate() {
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
