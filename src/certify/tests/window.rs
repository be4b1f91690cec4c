//! A window's lists equal the lists of the full frame, also if tiles share them.

use crate::certify::binned::{BinnedScene, Binning};
use crate::certify::placing::Placer;
use crate::kernel::Kernel;
use crate::tile::TILE;
use crate::view::View;
use crate::view::raster::Raster;
use crate::view::ray::NONE;
use crate::window::Window;
use crate::{Camera, ImagePlane, Lens, Scene, Spheres};
use halfline_ground::memory::Pool;

/// Spheres of this radius, one behind the other, in front of an image of 256 x 256 pixels.
fn scene(count: usize, radius: f64) -> Scene {
    let mut spheres = Spheres::default();
    for n in 0..count {
        let [x, y] = [7, 11].map(|k| ((n * k) % 101) as f64 / 101.0 - 0.5);
        spheres.push([x, y, -10.0 - n as f64 * 1e-3], radius, None);
    }
    let lens = Lens::Vfov { degrees: 3.0, distance: 1.0 };
    let image = ImagePlane { width: 256, height: 256, background: [0.0; 3] };
    Scene { camera: Camera { lens, ..Camera::CANONICAL }, image, spheres, lighting: Default::default() }
}

#[test]
fn the_lists_of_a_window_are_those_of_the_full_frame() {
    let kernel = Kernel::certified();
    let window = Window { x0: 101, y0: 27, x1: 152, y1: 90 };
    // Single tiles that are covered, and cells of several tiles.
    for (count, radius, shared) in [(900, 0.2, false), (2600, 1.4, true)] {
        let scene = scene(count, radius);
        let binned = |window: Window| {
            let view = View::for_rays(&scene, Raster::centres(window), kernel.records()).expect("a view");
            BinnedScene::new(&Binning::of(&scene, &view, 1e-5, &Pool::default())).expect("a stage").expect("a lens")
        };
        let (full, part) = (binned(Window::full(256, 256)), binned(window));
        assert_eq!((full.projection, &full.generals), (part.projection, &part.generals));
        assert_eq!((full.lists.level() > 0, part.lists.level()), (shared, full.lists.level()));
        let mut entries = 0;
        for (row, column) in (window.y0..window.y1).flat_map(|i| (window.x0..window.x1).map(move |j| (i, j))) {
            let of = |binned: &BinnedScene| {
                let [first, end] = binned.lists.range(row, column).map(|n| n as usize);
                let chunk_min_depths = &binned.lists.chunk_min_depths[first / TILE as usize..end / TILE as usize];
                (
                    binned.lists.projected[first..end].to_vec(),
                    binned.lists.details[first..end].to_vec(),
                    chunk_min_depths.to_vec(),
                )
            };
            let (full, part) = (of(&full), of(&part));
            entries += part.0.len();
            assert!(full == part, "row {row}, column {column}");
        }
        assert!(entries > 0, "the window shows something");
        assert!(part.lists.projected.len() < full.lists.projected.len() / 4, "only the window's lists are built");
    }
}

/// Spheres in several lists are projected once for all of them, others for each list: every entry has the bits of its sphere
/// projected alone.
#[test]
fn every_entry_has_the_bits_of_its_sphere_alone() {
    let kernel = Kernel::certified();
    // More and fewer entries than projecting once is worth.
    for (radius, often) in [(0.02, true), (0.001, false)] {
        let scene = scene(900, radius);
        let view = View::for_rays(&scene, Raster::centres(Window::full(256, 256)), kernel.records()).expect("a view");
        let binned =
            BinnedScene::new(&Binning::of(&scene, &view, 1e-5, &Pool::default())).expect("a stage").expect("a lens");
        let placer = Placer::new(&scene, &view, 1e-5).expect("a lens").expect("a projection");
        let lists = &binned.lists;
        let entries = lists.details.iter().filter(|detail| detail.id != NONE).count();
        assert_eq!(entries >= 3 * scene.spheres.len(), often, "{entries} entries");
        for (n, detail) in lists.details.iter().enumerate().filter(|(_, detail)| detail.id != NONE) {
            let placed = placer.placed(&scene, detail.id, binned.projection.depth).expect("a record");
            let bits = (lists.projected[n], *detail, lists.depths[n].to_bits());
            assert_eq!(bits, (placed.record, placed.detail, placed.depth.to_bits()), "entry {n}");
        }
    }
}
