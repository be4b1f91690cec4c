//! The lists of general spheres leave out none that matters: every answer has the bits of a search among all of them, the
//! sphere that a ray truly hits first is listed, and the bounds of a cell hold for each of its rays.

use super::wild::{Mode, Value, Wild, under};
use crate::certify::binned::{BinnedScene, Binning};
use crate::certify::general::{General, general_low};
use crate::certify::general_lists::{GeneralLists, GeneralTree};
use crate::certify::projection::{ProjectionBounds, host_cull_margin};
use crate::certify::{Certify, TERMS};
use crate::double_double as dd;
use crate::kernel::Kernel;
use crate::scene::camera::Look;
use crate::testing::Rng;
use crate::tile::{TILE, WHOLE};
use crate::view::View;
use crate::view::raster::Raster;
use crate::view::ray::NONE;
use crate::window::Window;
use crate::{Camera, ImagePlane, Lens, Scene, Spheres};
use glam::DVec3;
use halfline_ground::memory::Pool;

const SIZE: [u32; 2] = [93, 61];

/// Tolerances from the least to the greatest that `--tolerance` takes.
const TOLERANCES: [f64; 4] = [1e-5, 1e-15, 1e-2, 1.0];

const fn degrees(degrees: f64) -> Lens {
    Lens::Vfov { degrees, distance: 1.0 }
}

/// The kinds of worlds and their lenses.
const WORLDS: [(&str, Lens); 8] = [
    ("crowd", degrees(40.0)),
    ("inside all", degrees(60.0)),
    ("beside", degrees(50.0)),
    ("ground", degrees(90.0)),
    ("surface", degrees(40.0)),
    ("crowd", degrees(0.01)),
    ("inside all", degrees(170.0)),
    ("beside", degrees(170.0)),
];

/// A world of this kind around the eye.
fn world(kind: &str, lens: Lens, rng: &mut Rng) -> Scene {
    let eye = DVec3::new(rng.between(-9.0, 9.0), 3.0, 1.0);
    let camera = Camera { eye, look: Look::View(DVec3::new(0.3, -0.2, -1.0)), lens, ..Camera::CANONICAL };
    let basis = camera.basis().expect("a basis");
    let mut spheres = Spheres::default();
    let mut push = |[right, up, ahead]: [f64; 3], radius: f64| {
        let center = eye + basis.u * right + basis.v * up - basis.w * ahead;
        spheres.push(center.to_array(), radius, None);
    };
    for n in 0..240 {
        let mut cube = |side: f64| [0; 3].map(|_| rng.between(-side, side));
        match kind {
            "crowd" => push(cube(2.0), 0.7),
            "inside all" => push(cube(1.0), 2.0),
            "beside" => {
                // The surface touches the plane of the eye, or nearly.
                let [right, up, _] = cube(4.0);
                let radius = 0.2 + 0.01 * f64::from(n % 60);
                push([right, up, radius * rng.sign() * (1.0 + rng.sign() * rng.decade(-17.0, -1.0))], radius);
            }
            "ground" => {
                let at = cube(1.5);
                match n {
                    0 => push([0.0, -1e6, 0.0], 1e6 - 0.5),
                    _ => push(at, 0.3 + 0.2 * at[0].abs()),
                }
            }
            // The surface passes through the eye, but for its rounding or a little more.
            _ => {
                let at = DVec3::from_array(cube(1.0));
                push(at.to_array(), at.length() * (1.0 + rng.sign() * rng.decade(-18.0, -1.0)));
            }
        }
    }
    let image = ImagePlane { width: SIZE[0], height: SIZE[1], background: [0.0; 3] };
    Scene { camera, image, spheres, lighting: Default::default() }
}

fn binned(scene: &Scene, view: &View, tolerance: f64) -> BinnedScene {
    BinnedScene::new(&Binning::of(scene, view, tolerance, &Pool::default())).expect("a stage").expect("a lens")
}

fn view(scene: &Scene, raster: Raster) -> View {
    let kernel = Kernel::certified();
    View::for_rays(scene, raster, kernel.records()).expect("a view")
}

/// Compares every ray's answer with the answer of a search among all general spheres; returns the entries of the lists, and
/// the number of rays that are certain.
fn same_as_all(name: &str, scene: &Scene, view: &View, tolerance: f64) -> [usize; 2] {
    let listed = binned(scene, view, tolerance);
    let mut whole = listed.clone();
    whole.general_lists = GeneralLists::all(whole.generals.len(), view.record.tiles());
    let [listed, whole] = [&listed, &whole].map(|binned| Certify::<f32>::new(&view.record, binned));
    let (mut entries, mut certain) = (0, 0);
    for (i, j) in (0..SIZE[1]).flat_map(|i| (0..SIZE[0]).map(move |j| (i, j))) {
        let [row, column] = view.record.sample_position(i, j);
        let s = whole.slopes(row, column);
        let answered = [&listed, &whole].map(|twin| {
            let k = twin.nearest_two(&s);
            let answer = (k.slot != NONE).then(|| twin.certify_winner(&s, &k));
            let proved = answer.is_none_or(|answer| twin.certain(&answer, [k.low, k.second]));
            (k.low.to_bits(), k.slot, format!("{answer:?}"), proved)
        });
        assert!(answered[0] == answered[1], "{name}, tolerance {tolerance}, row {i}, column {j}: {answered:?}");
        certain += usize::from(answered[0].3);
        entries += listed.general_lists.of(i, j).len();
    }
    [entries, certain]
}

#[test]
fn answers_have_the_bits_of_a_search_among_all_general_spheres() {
    let mut rng = Rng(5);
    for (name, lens) in WORLDS {
        for tolerance in TOLERANCES {
            let scene = world(name, lens, &mut rng);
            let view = view(&scene, Raster::centres(Window::full(SIZE[0], SIZE[1])));
            let [entries, certain] = same_as_all(name, &scene, &view, tolerance);
            let all = binned(&scene, &view, tolerance).generals.len() * (SIZE[0] * SIZE[1]) as usize;
            println!(
                "{name} {lens:?} {tolerance}: {:.3} of all entries, {certain} certain",
                entries as f64 / all as f64
            );
            // Of a tolerance of 1 little is behind what covers a tile.
            assert!(tolerance > 0.1 || entries < all / 3, "{name}: {entries} entries of {all}");
        }
    }
}

#[test]
fn answers_of_samples_have_the_bits_of_a_search_among_all_general_spheres() {
    let mut rng = Rng(6);
    for (name, lens) in [WORLDS[0], WORLDS[3], WORLDS[6]] {
        let scene = world(name, lens, &mut rng);
        let samples = Raster::samples(Window::full(SIZE[0], SIZE[1]), 9, 3, &scene.image).expect("room");
        let mut view = view(&scene, samples.expect("samples"));
        for sample in [0, 5, 8] {
            view.record.sample = sample;
            same_as_all(name, &scene, &view, 1e-5);
        }
    }
}

/// Exact arithmetic names the sphere that a ray hits first among all; if it is a general one, its tile lists it.
#[test]
fn the_sphere_that_is_hit_first_is_listed() {
    let mut rng = Rng(7);
    let mut found = 0;
    for (name, lens) in WORLDS {
        let scene = world(name, lens, &mut rng);
        let view = view(&scene, Raster::centres(Window::full(SIZE[0], SIZE[1])));
        let binned = binned(&scene, &view, 1e-5);
        let judge = view.judge(&scene).expect("a judge");
        for _ in 0..300 {
            let [i, j] = [rng.below(SIZE[1]), rng.below(SIZE[0])];
            let Some(truth) = judge.pixel(i, j) else { continue };
            let Ok(slot) = binned.generals.binary_search_by_key(&truth.id, |general| general.id) else { continue };
            assert!(binned.general_lists.of(i, j).contains(&(slot as u32)), "{name}, row {i}, column {j}: {truth:?}");
            found += 1;
        }
    }
    assert!(found > 1500, "{found} general spheres were hit");
}

/// The bounds of a cell, at every level: no lower bound that the kernel may compute is below, no true hit above.
#[test]
fn the_bounds_of_a_cell_hold_for_its_rays_however_the_device_rounds() {
    let mut rng = Rng(8);
    let (mut misses, mut hits) = (0, 0);
    for (name, lens) in WORLDS {
        let scene = world(name, lens, &mut rng);
        let view = view(&scene, Raster::centres(Window::full(SIZE[0], SIZE[1])));
        let binned = binned(&scene, &view, 1e-5);
        let projection = ProjectionBounds::new(&scene.camera, &view, SIZE, &TERMS).expect("a lens");
        let near = GeneralTree::new(&projection, &binned.generals, SIZE, host_cull_margin(1e-5));
        let judge = view.judge(&scene).expect("a judge");
        let twin = Certify::<f32>::new(&view.record, &binned);
        for _ in 0..40 {
            let pixel = [rng.below(SIZE[1]), rng.below(SIZE[0])];
            let s = Certify::<Wild> {
                view: twin.view,
                projection: twin.projection,
                lists: twin.lists,
                generals: Vec::new(),
                general_lists: twin.general_lists,
                terms: twin.terms,
                planes: None,
            }
            .slopes(pixel[0], pixel[1]);
            for level in 0..5 {
                let at = [pixel[1], pixel[0]].map(|n| (n / TILE) >> level);
                for (record, [low, high]) in binned.generals.iter().zip(near.depths(level, at)) {
                    for mode in Mode::BLIND {
                        let seed = rng.bits();
                        let own = under(mode, seed, || general_low(&s, &General::new(record), &TERMS)).value();
                        let own = if own < f32::MAX.into() { own } else { f64::INFINITY };
                        assert!(low <= own, "{name} {mode:?}: {low} is above {own}, pixel {pixel:?}, {record:?}");
                    }
                    misses += usize::from(low == f64::INFINITY);
                    if high < f64::INFINITY {
                        let truth =
                            judge.among(pixel[0], pixel[1], &[record.id]).expect("a sphere that covers the cell");
                        let depth = dd::ldexp(truth.depth, -view.unit);
                        assert!(depth <= high, "{name}: {depth} is above {high}, pixel {pixel:?}, {record:?}");
                        hits += 1;
                    }
                }
            }
        }
    }
    println!("{misses} missed, {hits} covered");
    assert!(misses > 10_000 && hits > 10_000, "{misses} missed, {hits} covered");
}

/// A tile has one list in every window.
#[test]
fn the_lists_of_a_window_are_those_of_the_full_frame() {
    let mut rng = Rng(9);
    let window = Window { x0: 13, y0: 27, x1: 52, y1: 60 };
    for (name, lens) in [WORLDS[0], WORLDS[3]] {
        let scene = world(name, lens, &mut rng);
        let [full, part] = [Window::full(SIZE[0], SIZE[1]), window]
            .map(|window| binned(&scene, &view(&scene, Raster::centres(window)), 1e-5).general_lists);
        let mut entries = 0;
        for (i, j) in (window.y0..window.y1).flat_map(|i| (window.x0..window.x1).map(move |j| (i, j))) {
            assert!(full.of(i, j) == part.of(i, j), "{name}, row {i}, column {j}");
            entries += part.of(i, j).len();
        }
        assert!(entries > 0 && part.slots.len() < full.slots.len(), "{name}: {entries} entries");
    }
}

/// One list for the whole image holds every sphere that some ray may hit first.
#[test]
fn one_list_serves_the_whole_image() {
    let scene = world("crowd", degrees(40.0), &mut Rng(10));
    let view = view(&scene, Raster::centres(Window::full(SIZE[0], SIZE[1])));
    let of = |level| {
        BinnedScene::new(&Binning { level, ..Binning::of(&scene, &view, 1e-5, &Pool::default()) }).expect("a stage")
    };
    let [single, whole] = [0, WHOLE].map(|level| of(level).expect("a lens").general_lists);
    let all = whole.of(0, 0).to_vec();
    assert!((0..SIZE[1]).all(|i| single.of(i, 0).iter().all(|slot| all.contains(slot))));
    assert!(!all.is_empty() && whole.of(SIZE[1] - 1, SIZE[0] - 1) == all);
}
