//! Occlusion culling: pixels that count as covered are hit, no deeper than their limit.

use crate::certify::TERMS;
use crate::certify::binned::{BinnedScene, Binning};
use crate::certify::projection::cover::{Cover, Coverage};
use crate::certify::projection::stage::Staged;
use crate::certify::projection::{ProjectionBounds, host_cull_margin};
use crate::exact::Judge;
use crate::scene::Scene;
use crate::scene::camera::Lens::{Orthographic, Viewport};
use crate::testing::Rng;
use crate::tile::TILE;
use crate::view::View;
use crate::view::ray::NONE;
use crate::{Camera, ImagePlane, Spheres};
use glam::DVec3;
use halfline_ground::memory::Pool;

/// Eight times the least tolerance, 2^-21.
const MARGIN: f64 = 1.0 / (1 << 18) as f64;

/// Small and large spheres at all distances in front of an oblique camera.
fn scene(rng: &mut Rng) -> Scene {
    let mut spheres = Spheres::default();
    let camera = Camera { eye: DVec3::new(1e3, -20.0, 7.0), ..Camera::CANONICAL };
    for _ in 0..400 {
        let depth = rng.decade(0.0, 6.0);
        let [x, y] = [0, 1].map(|_| rng.between(-1.1, 1.1) * depth);
        spheres.push((camera.eye + DVec3::new(x, y, -depth)).to_array(), depth * rng.decade(-3.5, -0.2), None);
    }
    let image = ImagePlane { width: 93, height: 61, background: [0.0; 3] };
    Scene { camera, image, spheres, lighting: Default::default() }
}

/// The same for parallel rays, some spheres across the plane of the eye.
fn parallel_scene(rng: &mut Rng) -> Scene {
    let mut scene = scene(rng);
    scene.camera.lens = Orthographic { height: 100.0 };
    for (center, radius) in scene.spheres.centers.to_mut().iter_mut().zip(scene.spheres.radii.to_mut()) {
        let [x, y] = [0, 1].map(|_| rng.between(-80.0, 80.0));
        *center = (scene.camera.eye + DVec3::new(x, y, -rng.decade(-1.0, 4.0))).to_array();
        *radius = rng.decade(-1.0, 1.5);
    }
    scene
}

/// Every covered pixel is hit in exact arithmetic, no deeper than its limit.
#[test]
fn covered_pixels_are_hit() {
    let mut rng = Rng(5);
    let (mut closed, mut deep) = (0, 0.0f64);
    for make in [scene, parallel_scene].repeat(8) {
        let scene = make(&mut rng);
        let view = View::new(&scene).expect("a view");
        let (width, height) = (scene.image.width, scene.image.height);
        let lens = ProjectionBounds::new(&scene.camera, &view, [width, height], &TERMS).expect("a lens");
        let coverage = Coverage::new(&lens, [width, height], 0.0, host_cull_margin(0.0), 1.0);
        let judge = Judge::new(&scene).expect("a judge");
        let unit = crate::double_double::ldexp(1.0, view.unit);
        for id in 0..scene.spheres.len() {
            let staged = lens.stage(id as u32, scene.spheres.centers[id], scene.spheres.radii[id], 0.0);
            let Staged::Projected(landed) = staged else { continue };
            for (row, column) in (0..height.div_ceil(TILE)).flat_map(|i| (0..width.div_ceil(TILE)).map(move |j| (i, j)))
            {
                let mut cover = Cover::new(coverage, [column, row]);
                let all = cover.open;
                cover.add(&landed.placed);
                for bit in (0..64).filter(|bit| (all & !cover.open) >> bit & 1 == 1) {
                    let (i, j) = (row * TILE + bit / TILE, column * TILE + bit % TILE);
                    let truth = judge.among(i, j, &[id as u32]).expect("a covered pixel is hit");
                    let depth = truth.depth / unit;
                    // What may be left out lies farther behind by the least cull margin.
                    assert!(depth + depth.abs() * MARGIN <= cover.deepest, "sphere {id}, row {i}, column {j}");
                    closed += 1;
                    deep = deep.max((cover.deepest - depth) / cover.deepest);
                }
            }
        }
    }
    assert!(closed > 10_000, "{closed} pixels were covered");
    assert!(deep < 1.0, "the bound is not trivial");
}

/// A disc of 5.1 pixels about the corner of four tiles: in each it closes the pixels inside it, and none outside the image.
#[test]
fn a_disc_closes_its_pixels_and_no_others() {
    let mut spheres = Spheres::default();
    // 16 columns for a slope of 0.005: the radius is 5.1 columns, and so small that its outline is a disc.
    spheres.push([0.0, 0.0, -100.0], 0.159, None);
    let image = ImagePlane { width: 16, height: 13, background: [0.0; 3] };
    let camera = Camera { lens: Viewport { vw: 0.005, vh: 0.005, distance: 1.0 }, ..Camera::CANONICAL };
    let scene = Scene { camera, image, spheres, lighting: Default::default() };
    let view = View::new(&scene).expect("a view");
    let lens = ProjectionBounds::new(&scene.camera, &view, [16, 13], &TERMS).expect("a lens");
    let Staged::Projected(landed) = lens.stage(0, [0.0, 0.0, -100.0], 0.159, 0.0) else { panic!("a projected sphere") };
    let judge = Judge::new(&scene).expect("a judge");
    for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let mut cover = Cover::new(Coverage::new(&lens, [16, 13], 0.0, host_cull_margin(0.0), 1.0), [column, row]);
        assert_eq!(cover.open.count_ones(), TILE * if row == 0 { 8 } else { 5 }, "only what lies in the image");
        assert_eq!(cover.limit(), None);
        cover.add(&landed.placed);
        for (i, j) in
            (row * TILE..(row * TILE + TILE).min(13)).flat_map(|i| (0..TILE).map(move |j| (i, column * TILE + j)))
        {
            let hit = judge.pixel(i, j).is_some();
            let open = cover.open >> (TILE * (i % TILE) + j % TILE) & 1 == 1;
            // No pixel lies within a hundredth of this outline.
            assert_eq!(hit, !open, "row {i}, column {j}");
        }
    }
}

/// Clouds that cover tiles: the sphere that a pixel's ray hits is in its list, although most of the cloud is not.
#[test]
fn no_visible_sphere_is_culled() {
    let mut rng = Rng(77);
    let (mut listed, mut projected_spheres, mut hits) = (0, 0, 0);
    for round in 0..16 {
        let mut spheres = Spheres::default();
        // Far and compact in every other round, so that depths are stored relative to a reference.
        let eye = DVec3::new(rng.between(-9.0, 9.0), 3.0, 1.0) * if round % 2 == 0 { 1.0 } else { 1e6 };
        let (far, spread) = if round % 2 == 0 { (1.5, 8.0) } else { (1e6, 2e5) };
        // Parallel rays in the last rounds.
        let parallel = round >= 12;
        let lens = if parallel { Orthographic { height: far + spread } } else { Camera::CANONICAL.lens };
        let camera = Camera { eye, lens, ..Camera::CANONICAL };
        for _ in 0..6000 {
            let depth = far + spread * rng.unit();
            let wide = if parallel { far + spread } else { depth };
            let [x, y] = [0, 1].map(|_| rng.between(-0.6, 0.6) * wide);
            spheres.push((eye + DVec3::new(x, y, -depth)).to_array(), depth * rng.decade(-2.0, -1.2), None);
        }
        let image = ImagePlane { width: 61, height: 45, background: [0.0; 3] };
        let scene = Scene { camera, image, spheres, lighting: Default::default() };
        let view = View::new(&scene).expect("a view");
        let binned =
            BinnedScene::new(&Binning::of(&scene, &view, 1e-5, &Pool::default())).expect("a stage").expect("a lens");
        assert_eq!(binned.projection.depth > 0.0, round % 2 == 1, "the reference");
        let judge = Judge::new(&scene).expect("a judge");
        let entries = |[first, end]: [u32; 2]| &binned.lists.details[first as usize..end as usize];
        for (i, j) in (0..image.height).flat_map(|i| (0..image.width).map(move |j| (i, j))) {
            let Some(truth) = judge.pixel(i, j) else { continue };
            let there = entries(binned.lists.range(i, j)).iter().any(|more| more.id == truth.id);
            assert!(
                there || binned.generals.iter().any(|general| general.id == truth.id),
                "row {i}, column {j}: {truth:?}"
            );
            hits += 1;
        }
        listed += binned.lists.details.iter().filter(|more| more.id != NONE).count();
        projected_spheres += binned.projected_count;
    }
    println!("{hits} hits, {listed} entries for {projected_spheres} spheres");
    assert!(
        hits > 30_000 && listed < projected_spheres as usize,
        "{listed} entries, {projected_spheres} spheres, {hits} hits"
    );
}
