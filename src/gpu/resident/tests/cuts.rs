//! Frames of spheres that planes cut have the bits of the CPU path, in every order and division of the work.

use super::*;
use crate::scene::{CutPlane, REMOVED};
use crate::view::ray::dot3;
use glam::DVec3;

/// A scene as planes leave it, without the spheres that they remove; `None` where they cut none.
fn left_by(scene: &Scene, planes: &[CutPlane], colors_faces: bool) -> Option<Scene> {
    let mut all = scene.spheres.clone();
    all.cut(planes, None).expect("planes");
    let cuts = all.cuts.take()?;
    let ids: Vec<u32> = (0..all.len() as u32).filter(|id| cuts.of[*id as usize] != REMOVED).collect();
    let mut spheres = Spheres::default();
    for &id in &ids {
        let color = all.colors.as_ref().map(|colors| colors[id as usize]);
        spheres.push(all.centers[id as usize], all.radii[id as usize], color);
    }
    let mut cuts = cuts.chosen(&ids);
    let face = |n: usize| [n as f32 / ids.len() as f32, 1.0, 0.25];
    cuts.colors = colors_faces.then(|| (0..ids.len()).map(face).collect::<Vec<_>>().into());
    spheres.cuts = Some(cuts);
    Some(Scene { spheres, ..scene.bare() })
}

/// A plane through a place near a sphere or through the eye, toward or along the view, or in any direction.
fn plane(scene: &Scene, rng: &mut Rng) -> CutPlane {
    let mut any = || DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0));
    let (mut normal, other) = (any(), any().normalize());
    let ball = scene.spheres.ball(rng.below(scene.spheres.len() as u32));
    let mut through = DVec3::from_array(ball.center) + rng.unit() * ball.radius * other;
    let basis = scene.camera.basis().expect("a basis");
    match rng.below(8) {
        0 => through = scene.camera.eye,
        1 => normal = basis.w,
        2 => normal = basis.u + 1e-9 * basis.w,
        3 => normal = -basis.w,
        _ => {}
    }
    normal *= rng.decade(-3.0, 3.0);
    CutPlane { normal: normal.to_array(), distance: dot3(normal.to_array(), through.to_array()) }
}

/// The proved pixels of faces: their normals are the normals of planes.
fn faces(planes: &[CutPlane], device: &Raw) -> usize {
    let normals: Vec<DVec3> = planes.iter().map(|plane| DVec3::from_array(plane.normal).normalize()).collect();
    let is_face = |normal: &[f32]| {
        let own = DVec3::new(normal[0].into(), normal[1].into(), normal[2].into());
        normals.iter().any(|normal| (*normal - own).length() < 1e-6)
    };
    let sure = device.id.iter().zip(device.normal.chunks_exact(3)).filter(|(id, _)| **id < UNSURE);
    sure.filter(|(_, normal)| is_face(normal)).count()
}

#[test]
fn frames_of_cut_spheres_have_the_bits_of_the_cpu_path() {
    let Some(mut gpu) = open() else { return };
    let strict = keeps_bits(&gpu.summary.name);
    let (mut rng, mut number, mut proved, mut cut, mut on_faces, mut near_by) = (Rng(0xc07), 8000, 0, 0, 0, 0);
    for case in 0..amount("frames of cut spheres", [3, 6, 60]) {
        for lens in lenses_within(&mut rng) {
            let mut scene = match case % 3 {
                0 => within_cloud(&mut rng, 1000, lens),
                n => {
                    let scene = near_and_far(3 * (n - 1) as usize);
                    Scene { camera: Camera { lens, ..scene.camera }, ..scene }
                }
            };
            scene.spheres.radii.to_mut().iter_mut().for_each(|radius| *radius *= 10f64.powf(rng.between(-1.0, 0.7)));
            let planes: Vec<CutPlane> = (0..1 + rng.below(3)).map(|_| plane(&scene, &mut rng)).collect();
            let Some(scene) = left_by(&scene, &planes, case % 2 == 0) else { continue };
            if scene.spheres.is_empty() {
                continue;
            }
            let part = Window { x0: 11, y0: 5, x1: 50, y1: 41 };
            let full = Window::full(scene.image.width, scene.image.height);
            let raster = match rng.below(3) {
                0 => Raster::centres(full),
                1 => Raster::centres(part),
                _ => Raster::samples(part, 9, 3, &scene.image).expect("room").expect("several samples"),
            };
            // Several blocks, submissions of one or of a part, rows and bands, in either order.
            (gpu.block, gpu.reversed) = [(BLOCK, false), (64, true)][rng.below(2) as usize];
            gpu.limits.max_storage_buffer_binding_size = [128 << 20, 64 << 10][rng.below(2) as usize];
            number += 1;
            let (mut device, mut host, left) = both(&mut gpu, &scene, raster, number);
            assert_eq!(left, None, "case {case}, {lens:?}");
            on_faces += faces(&planes, &device);
            assert_agree(strict, &mut device, &mut host, &format!("case {case}, {lens:?}"));
            let is_sure = |id: &&u32| **id != UNSURE;
            proved += host.id.iter().filter(is_sure).count();
            cut += host.id.iter().filter(is_sure).filter(|id| **id < UNSURE && scene.spheres.is_cut(**id)).count();
            near_by += generals(&gpu);
        }
    }
    println!("{proved} pixels are proved, {cut} of cut spheres, {on_faces} on faces, beside {near_by} general spheres");
    assert!(
        proved > 25_000 && cut > 5_000 && on_faces > 2_000 && near_by > 50,
        "{proved}, {cut}, {on_faces}, {near_by}"
    );
}
