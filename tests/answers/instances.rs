//! The promise of copies that are operators over one set of spheres: the frame has the bits of the frame of all copies in
//! memory, ids included.

use crate::adapter::{cpu, renderers};
use crate::bits::differing;
use crate::cloud::cloud;
use crate::oblique::{self, vfov};
use crate::rng::Rng;
use glam::DVec3;
use halfline::camera::Lens;
use halfline::frame::{Aov, Data, Frame};
use halfline::progress::Watch;
use halfline::render::Renderer;
use halfline::render::stream::{Stream, Visible};
use halfline::scene::arrange::Arrangement;
use halfline::scene::instances::{CopiedSpheres, Instances, Operator};
use halfline::scene::{CUT, Cell, CutPlane, Cuts, Framing, REMOVED, Scene, SphereSource, Spheres};
use halfline::settings::{Accuracy, Settings, Tolerance};
use halfline::window::Window;

/// Buffers in which a sphere too few or too many would show.
const AOVS: [Aov; 7] = [Aov::Color, Aov::Alpha, Aov::Id, Aov::Distance, Aov::Normal, Aov::Certainty, Aov::Bound];

/// A tilted cell.
const CELL: Cell = Cell { origin: [0.0; 3], edges: [[1.0, 0.1, 0.0], [-0.2, 0.9, 0.1], [0.1, 0.0, 1.1]] };

fn scene(eye: [f64; 3], at: [f64; 3], lens: Lens) -> Scene {
    oblique::scene([77, 53], eye, at, lens, Spheres::default())
}

fn settings() -> Settings {
    Settings { accuracy: Accuracy::Certified, aovs: AOVS.to_vec(), ..Settings::default() }
}

/// Cameras around and inside of copies that fill the box from 0 to 6 or so.
fn cameras() -> Vec<(&'static str, Scene)> {
    let middle = [2.5, 2.0, 3.0];
    vec![
        ("from outside", scene([14.0, 9.0, 17.0], middle, vfov(35.0))),
        ("against the order of the copies", scene([-6.0, -4.0, -9.0], middle, vfov(40.0))),
        ("from inside", scene([2.4, 2.1, 2.9], [4.0, 3.5, 6.0], vfov(70.0))),
        ("from far away", scene([4e3, 2e3, -6e3], middle, vfov(0.05))),
        ("beyond the edges of the image", scene([14.0, 9.0, 17.0], middle, vfov(3.0))),
        ("past a corner", scene([8.0, 6.0, 9.0], [20.0, 2.0, 3.0], vfov(100.0))),
        ("parallel rays", scene([14.0, 9.0, 17.0], middle, Lens::Orthographic { height: 5.0 })),
        (
            "parallel rays from inside, along an edge",
            scene([2.4, 2.1, 2.9], [3.4, 2.2, 2.9], Lens::Orthographic { height: 3.0 }),
        ),
        (
            "a lens too wide for bounds",
            scene([9.0, 9.0, 9.0], middle, Lens::Viewport { vw: 1e7, vh: 1e7, distance: 1.0 }),
        ),
    ]
}

/// The spheres of a frame by operators, and all of them in memory.
fn visible(scene: &Scene, settings: &Settings, instances: &Instances) -> Visible {
    Stream::of_instances(scene, settings, instances, &Watch::default()).expect("what is visible")
}

/// Renders both ways and compares; returns the number of spheres that were kept.
fn check(what: &str, renderer: &mut Renderer, whole: &Scene, settings: &Settings, instances: &Instances) -> usize {
    let frame = renderer.render(whole, settings).expect("a frame");
    let visible = visible(whole, settings, instances);
    let mut other = renderer.render(&visible.scene, settings).expect("a frame");
    visible.ids.restore(&mut other);
    let differing = differing(&frame, &other);
    assert!(differing.is_empty(), "{what}, {}: {differing:?} differ", renderer.adapter());
    let counts = |frame: &Frame| (frame.report.spheres, frame.report.hits, frame.report.settled);
    assert_eq!(counts(&frame), counts(&other), "{what}");
    assert_eq!(visible.scene.fingerprint(), whole.fingerprint(), "{what}");
    assert_eq!(visible.scene.spheres.bounds(), whole.spheres.bounds(), "{what}");
    visible.ids.ids.len()
}

/// A cell of some hundred spheres, twins among them, whose hits are ties.
fn atoms(seed: u64, count: usize, radius: f64) -> Spheres {
    let mut spheres = cloud(seed, count, [0.5; 3], 0.5, radius);
    for twin in 0..9 {
        spheres.push(spheres.centers[twin], spheres.radii[twin], Some([1.0; 3]));
    }
    spheres
}

/// Copies along the edges of the cell, and all of them in memory.
fn copies(atoms: &Spheres, copies: [u32; 3], clip: &[[f64; 4]]) -> (Instances, Spheres) {
    let arrangement = Arrangement { copies, clip: clip.to_vec(), ..Arrangement::default() };
    let instances = arrangement.copies(atoms, Some(&CELL)).expect("copies");
    let mut all = atoms.clone();
    arrangement.apply(&mut all, Some(&CELL), &Watch::default()).expect("memory");
    (instances, all)
}

/// Sets of spheres with operators, and all of them in memory.
fn assembly(seed: u64, tinted: bool) -> (Instances, Spheres) {
    let mut rng = Rng::new(seed);
    let (mut sets, mut all) = (Vec::new(), Spheres::default());
    for (n, count) in [400, 150].into_iter().enumerate() {
        let set = atoms(seed + n as u64, count, 0.06);
        let operators: Vec<Operator> = (0..60)
            .map(|k| {
                // Turned, mirrored and stretched.
                let mut row = |shift: f64| {
                    let [a, b, c] = rng.cube();
                    [a, b, c, shift]
                };
                let place = [k % 4, k / 4 % 4, k / 16].map(f64::from);
                Operator([row(1.4 * place[0]), row(1.3 * place[1]), row(1.5 * place[2])])
            })
            .collect();
        let tints = tinted.then(|| (0..60).map(|k| [k as f32 / 60.0, 0.5, n as f32]).collect::<Vec<_>>());
        for (k, operator) in operators.iter().enumerate() {
            for (index, center) in set.centers.iter().enumerate() {
                let own = set.colors.as_ref().map(|colors| colors[index]);
                let color = tints.as_ref().map(|tints| tints[k]).or(own);
                all.push(operator.apply(*center), set.radii[index], color);
            }
        }
        sets.push((set, operators, tints));
    }
    (Instances::by_operators(sets).expect("operators"), all)
}

#[test]
fn copies_have_the_bits_of_copies_in_memory() {
    let (instances, all) = copies(&atoms(1, 300, 0.05), [6, 5, 7], &[]);
    for (_, mut renderer) in renderers() {
        for (what, camera) in cameras() {
            let whole = Scene { spheres: all.clone(), ..camera };
            let kept = check(what, &mut renderer, &whole, &settings(), &instances);
            println!("{what}: {} spheres, {kept} kept", all.len());
        }
    }
}

/// Small cells, whose copies are grouped; large ones, which are divided; and spheres larger than the cell.
#[test]
fn cells_of_any_size_have_the_bits_of_copies_in_memory() {
    for (count, number, radius) in [(9, [7, 12, 9], 0.1), (3000, [2, 1, 1], 0.02), (20, [5, 4, 4], 0.7)] {
        let (instances, all) = copies(&atoms(count as u64, count, radius), number, &[]);
        for (what, camera) in cameras().into_iter().take(5) {
            let whole = Scene { spheres: all.clone(), ..camera };
            check(&format!("{count} spheres, {what}"), &mut cpu(), &whole, &settings(), &instances);
        }
    }
}

#[test]
fn operators_have_the_bits_of_their_images_in_memory() {
    for tinted in [false, true] {
        let (instances, all) = assembly(3, tinted);
        for (what, camera) in cameras().into_iter().take(7) {
            let whole = Scene { spheres: all.clone(), ..camera };
            check(what, &mut cpu(), &whole, &settings(), &instances);
        }
    }
}

#[test]
fn clipped_copies_samples_and_windows_have_the_same_bits() {
    let clips: [&[[f64; 4]]; 3] =
        [&[[0.0, 0.0, 1.0, 4.2]], &[[-1.0, 0.3, 0.0, -2.0], [0.2, 1.0, 0.1, 3.0]], &[[1.0, 0.0, 0.0, -5.0]]];
    let window = Some(Window { x0: 13, y0: 21, x1: 66, y1: 44 });
    let tolerance = Some(Tolerance::new(1e-3).expect("a tolerance"));
    for clip in clips {
        let (instances, all) = copies(&atoms(4, 300, 0.06), [6, 5, 7], clip);
        for (what, camera) in cameras().into_iter().skip(1).take(2) {
            let whole = Scene { spheres: all.clone(), ..camera };
            for settings in [
                settings(),
                Settings { samples: 4, seed: 5, tolerance, depth_cue: true, ..settings() },
                Settings { silhouette: true, window, ..settings() },
            ] {
                check(what, &mut cpu(), &whole, &settings, &instances);
            }
        }
    }
}

/// Planes through groups of copies, most of them on one side; one that removes all but a few, one that removes all, one that cuts none.
#[test]
fn cut_copies_have_the_bits_of_cut_spheres_in_memory() {
    let plane = |normal: [f64; 3], distance| CutPlane { normal, distance };
    let clip: &[[f64; 4]] = &[[0.2, 1.0, 0.1, 3.0]];
    let (mut faces, mut removed) = (0, 0);
    for (planes, clip) in [
        (vec![plane([0.0, 0.0, 1.0], 4.2)], clip),
        (vec![plane([14.0, 9.0, 17.0], 90.0), plane([-1.0, 0.3, 0.0], -2.0)], &[]),
        (vec![plane([0.0, 0.0, 2.0], 0.02)], &[]),
        (vec![plane([0.0, 0.0, 1.0], -5.0)], &[]),
        (vec![plane([0.0, 0.0, 1.0], 50.0)], clip),
    ] {
        let (instances, mut all) = copies(&atoms(4, 300, 0.06), [6, 5, 7], clip);
        all.cut(&planes, None).expect("planes");
        let flag = |flag| all.cuts.as_ref().map_or(0, |cuts| cuts.count(flag));
        (faces, removed) = (faces + flag(CUT), removed + flag(REMOVED));
        for (what, camera) in cameras().into_iter().take(3) {
            let mut whole = Scene { spheres: all.clone(), ..camera };
            let settings = Settings { samples: 4, silhouette: true, ..settings() };
            let frame = cpu().render(&whole, &settings).expect("a frame");
            whole.spheres.cuts = Cuts::later(planes.clone()).expect("planes");
            let visible = visible(&whole, &settings, &instances);
            let mut other = cpu().render(&visible.scene, &settings).expect("a frame");
            visible.ids.restore(&mut other);
            let differing = differing(&frame, &other);
            assert!(differing.is_empty(), "{what}, {planes:?}: {differing:?} differ");
            let counts = |Frame { report, .. }: &Frame| (report.spheres, report.spheres_cut, report.spheres_removed);
            assert_eq!(counts(&frame), counts(&other), "{what} {planes:?}");
        }
    }
    assert!(faces > 1000 && removed > 60_000, "{faces} cut, {removed} removed");
}

/// A camera that shows all copies has the bits of the one for copies in memory.
#[test]
fn framing_finds_the_extremes_of_all_copies() {
    let (instances, all) = copies(&atoms(5, 200, 0.05), [6, 5, 7], &[[0.0, 0.0, 1.0, 4.2]]);
    for lens in [vfov(30.0), Lens::Orthographic { height: 1.0 }] {
        let mut whole = Scene { spheres: all.clone(), ..scene([0.0, 0.0, 5.0], [1.0, 2.0, 0.5], lens) };
        let mut bare = scene([0.0, 0.0, 5.0], [1.0, 2.0, 0.5], lens);
        let framing = Framing::default();
        let copied = CopiedSpheres { instances: &instances, watch: &Watch::default() };
        let bounds = copied.ends().expect("not cancelled");
        bare.camera.fit(bare.image, &copied, &framing).expect("framed");
        whole.camera.fit(whole.image, &whole.spheres, &framing).expect("framed");
        assert_eq!((bounds, bare.camera), (all.bounds(), whole.camera));
    }
}

/// 1e13 copies: nothing but what is seen is made, and ids are 64-bit.
#[test]
fn ids_beyond_32_bits_count_as_if_multiplied_out() {
    let one = cloud(6, 10, [0.5; 3], 0.5, 0.3);
    let number = [10_000; 3];
    let arrangement = Arrangement { copies: number, ..Arrangement::default() };
    let instances = arrangement.copies(&one, Some(&CELL)).expect("copies");
    let far = DVec3::from_array(CELL.edges[0]) * 1e4
        + DVec3::from_array(CELL.edges[1]) * 1e4
        + DVec3::from_array(CELL.edges[2]) * 1e4;
    let camera = scene((far * 1.0005).into(), [0.0; 3], vfov(30.0));
    let visible = visible(&camera, &settings(), &instances);
    assert!(visible.ids.are_wide() && visible.ids.count == 10_000_000_000_000);
    assert!(visible.ids.ids.len() < 100_000, "{} kept", visible.ids.ids.len());
    let mut frame = cpu().render(&visible.scene, &settings()).expect("a frame");
    visible.ids.restore(&mut frame);
    let Some(Data::I64(ids)) = frame.get(Aov::Id).map(|buffer| &buffer.data) else { panic!("64-bit ids") };
    let position = |id: u64| {
        let (copy, atom) = (id / 10, (id % 10) as usize);
        let [i, j, k] = [copy % 10_000, copy / 10_000 % 10_000, copy / 100_000_000].map(|n| n as f64);
        let [a, b, c] = CELL.edges.map(DVec3::from_array);
        DVec3::from_array(one.centers[atom]) + (i * a + j * b + k * c)
    };
    let hits: Vec<u64> = ids.iter().filter_map(|id| u64::try_from(*id).ok()).collect();
    assert!(hits.len() > 1000 && hits.iter().all(|id| position(*id).distance(far) < 100.0), "{} hits", hits.len());
    assert!(hits.iter().any(|id| *id > 9_000_000_000_000));
}

/// Negative control: a copy elsewhere gives another frame.
#[test]
fn a_moved_copy_is_found() {
    let (mut instances, all) = copies(&atoms(1, 300, 0.05), [6, 5, 7], &[]);
    let whole = Scene { spheres: all, ..cameras().swap_remove(0).1 };
    let other = Cell { edges: [CELL.edges[0], CELL.edges[1], [0.1, 1e-3, 1.1]], ..CELL };
    let arrangement = Arrangement { copies: [6, 5, 7], ..Arrangement::default() };
    instances = arrangement.copies(&atoms(1, 300, 0.05), Some(&other)).inspect(|_| drop(instances)).expect("copies");
    let visible = visible(&whole, &settings(), &instances);
    let mut moved = cpu().render(&visible.scene, &settings()).expect("a frame");
    visible.ids.restore(&mut moved);
    assert!(!differing(&cpu().render(&whole, &settings()).expect("a frame"), &moved).is_empty());
}
