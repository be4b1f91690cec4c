//! The promise of streams: the frame of what a stream keeps has the same bits as the frame of all spheres in memory.

use crate::adapter::{cpu, renderers};
use crate::bits::differing;
use crate::cloud::cloud;
use crate::oblique::{self, vfov};
use crate::rng::Rng;
use glam::DVec3;
use halfline::camera::Lens;
use halfline::error::Error;
use halfline::frame::{Aov, Frame};
use halfline::intersect::Method;
use halfline::render::Renderer;
use halfline::render::stream::{Stream, Visible};
use halfline::scene::{Light, LightSource, Scene, Spheres};
use halfline::settings::{Accuracy, Settings, Tolerance};
use halfline::window::Window;

/// Every buffer of camera rays.
const AOVS: [Aov; 10] = [
    Aov::Color,
    Aov::Alpha,
    Aov::Id,
    Aov::Mask,
    Aov::Distance,
    Aov::Depth,
    Aov::Normal,
    Aov::Position,
    Aov::Certainty,
    Aov::Bound,
];

pub(crate) fn scene(eye: [f64; 3], lens: Lens, spheres: Spheres) -> Scene {
    oblique::scene([77, 53], eye, [0.0; 3], lens, spheres)
}

pub(crate) fn settings() -> Settings {
    Settings { accuracy: Accuracy::Certified, aovs: AOVS.to_vec(), ..Settings::default() }
}

/// The spheres in blocks of `size`.
pub(crate) fn blocks(spheres: &Spheres, size: usize) -> impl Iterator<Item = Spheres> + '_ {
    (0..spheres.len()).step_by(size).map(move |first| {
        let mut block = Spheres::default();
        for n in first..(first + size).min(spheres.len()) {
            block.push(spheres.centers[n], spheres.radii[n], spheres.colors.as_ref().map(|colors| colors[n]));
        }
        block.opacities = spheres.opacities.as_ref().map(|all| (first..first + block.len()).map(|n| all[n]).collect());
        block
    })
}

fn stream(scene: &Scene, settings: &Settings, size: usize) -> Visible {
    let mut stream = Stream::new(scene, settings).expect("a stream");
    blocks(&scene.spheres, size).for_each(|block| stream.add(&block).expect("a block"));
    stream.finish().expect("what is visible")
}

/// Renders both ways and compares; returns the number of spheres that were kept.
fn check(what: &str, renderer: &mut Renderer, scene: &Scene, settings: &Settings, size: usize) -> usize {
    let whole = renderer.render(scene, settings).expect("a frame");
    let visible = stream(scene, settings, size);
    let mut streamed = renderer.render(&visible.scene, settings).expect("a frame");
    visible.ids.restore(&mut streamed);
    let differing = differing(&whole, &streamed);
    assert!(differing.is_empty(), "{what}, blocks of {size}, {}: {differing:?} differ", renderer.adapter());
    let counts = |frame: &Frame| (frame.report.spheres, frame.report.hits, frame.report.settled);
    assert_eq!(counts(&whole), counts(&streamed), "{what}");
    assert_eq!(visible.scene.fingerprint(), scene.fingerprint(), "{what}");
    visible.ids.ids.len()
}

/// Back to front, so that every block covers the ones before it.
fn reversed(mut spheres: Spheres, eye: [f64; 3]) -> Spheres {
    let mut order: Vec<usize> = (0..spheres.len()).collect();
    let away = |n: &usize| -DVec3::from_array(spheres.centers[*n]).distance(eye.into());
    order.sort_by(|a, b| away(a).total_cmp(&away(b)));
    let all = spheres.clone();
    spheres = Spheres::default();
    for n in order {
        spheres.push(all.centers[n], all.radii[n], all.colors.as_ref().map(|colors| colors[n]));
    }
    spheres
}

/// Dense clouds, in which most spheres are hidden; each has twins, whose hits are ties.
pub(crate) fn scenes() -> Vec<(&'static str, Scene)> {
    let dense = |seed, count, r| {
        let mut spheres = cloud(seed, count, [0.0; 3], 1.0, r);
        for twin in (0..20).rev() {
            spheres.push(spheres.centers[twin], spheres.radii[twin], Some([1.0; 3]));
        }
        spheres
    };
    let mut scenes = vec![
        ("a cloud from outside", scene([3.0, 2.0, 4.0], vfov(40.0), dense(1, 4000, 0.05))),
        ("the same back to front", scene([3.0, 2.0, 4.0], vfov(40.0), reversed(dense(1, 4000, 0.05), [3.0, 2.0, 4.0]))),
        ("a cloud from inside, spheres behind", scene([0.1, 0.2, 0.3], vfov(100.0), dense(2, 2000, 0.04))),
        ("a cloud beyond the image's edges", scene([0.0, 0.3, 2.0], vfov(9.0), dense(3, 3000, 0.03))),
        ("a cloud from far away", scene([2e3, -1e3, 3e3], vfov(0.03), dense(4, 3000, 0.05))),
        ("a cloud of dots", scene([3.0, 2.0, 4.0], vfov(40.0), dense(5, 12_000, 0.004))),
        ("parallel rays", scene([3.0, 2.0, 4.0], Lens::Orthographic { height: 2.0 }, dense(6, 3000, 0.05))),
        (
            "a lens too wide for bounds",
            scene([3.0, 2.0, 4.0], Lens::Viewport { vw: 1e7, vh: 1e7, distance: 1.0 }, dense(7, 60, 0.1)),
        ),
        ("few spheres", scene([3.0, 2.0, 4.0], vfov(40.0), cloud(8, 9, [0.0; 3], 1.0, 0.05))),
    ];
    let mut inside = dense(9, 2000, 0.05);
    inside.push([0.5, 0.5, 1.5], 0.8, Some([0.9, 0.1, 0.1]));
    scenes.push(("the eye in a sphere", scene([0.6, 0.6, 1.6], vfov(60.0), inside)));
    let mut ground = dense(10, 2000, 0.05);
    ground.push([0.0, -1000.9, 0.0], 1000.0, Some([0.2, 0.8, 0.2]));
    ground.push([0.0, 0.0, 4000.0], 3000.0, Some([0.2, 0.2, 0.8]));
    scenes.push(("a large ground, and a planet behind", scene([3.0, 0.5, 2.0], vfov(50.0), ground)));
    // Sizes that set the frame's unit, and are not seen.
    let mut uneven = dense(11, 2000, 0.05);
    uneven.push([3.0, 2.0, 4.0 + 1e-3], 1e-4, Some([1.0; 3]));
    uneven.push([-1e9, 3e9, 1e9], 2.0, Some([1.0; 3]));
    scenes.push(("a speck behind the eye, and a far star", scene([3.0, 2.0, 4.0], vfov(40.0), uneven)));
    scenes
}

#[test]
fn a_streamed_frame_has_the_bits_of_the_frame_in_memory() {
    for (_, mut renderer) in renderers() {
        for (what, scene) in scenes() {
            let kept = [500, 1 << 20].map(|size| check(what, &mut renderer, &scene, &settings(), size));
            println!("{what}: {} spheres, {kept:?} kept", scene.spheres.len());
        }
    }
}

/// Which pixels are certified depends on the tolerance, and on every bound of every sphere near the first hit.
#[test]
fn certificates_do_not_depend_on_what_is_forgotten() {
    for (what, scene) in scenes() {
        for tolerance in [0.3, 1e-3, 3e-5, 1e-7] {
            let tolerance = Tolerance::new(tolerance).expect("a tolerance");
            check(what, &mut cpu(), &scene, &Settings { tolerance: Some(tolerance), ..settings() }, 700);
        }
    }
}

#[test]
fn windows_samples_lines_and_exact_answers_have_the_same_bits() {
    for (what, scene) in scenes() {
        let window = Some(Window { x0: 13, y0: 21, x1: 66, y1: 44 });
        for settings in [
            Settings { window, ..settings() },
            Settings { samples: 4, seed: 5, depth_cue: true, ..settings() },
            Settings { depth_cue: true, ..settings() },
            Settings { samples: 9, silhouette: true, window, ..settings() },
            Settings { accuracy: Accuracy::Auto, aovs: vec![Aov::Color], ..settings() },
        ] {
            check(what, &mut cpu(), &scene, &settings, 700);
        }
        if scene.spheres.len() < 100 {
            check(what, &mut cpu(), &scene, &Settings { accuracy: Accuracy::Exact, window, ..settings() }, 700);
        }
    }
}

/// In memory, too, lists end behind what is covered. Exact frames have no lists.
#[test]
fn spheres_that_are_not_in_lists_change_no_bit() {
    let mut scenes = scenes();
    for (what, scene) in &mut scenes[..5] {
        let (mut rng, r) = (Rng::new(77), scene.spheres.radii[0]);
        while scene.spheres.len() < 6000 {
            scene.spheres.push(rng.cube(), r * (0.3 + rng.unit()), Some([0.5; 3]));
        }
        for (backend, mut renderer) in renderers() {
            let window = Some(Window { x0: 10, y0: 17, x1: 61, y1: 42 });
            let mut ids = |accuracy| {
                let settings = Settings { window, accuracy, aovs: vec![Aov::Id], ..settings() };
                renderer.render(scene, &settings).expect("a frame").ids().to_vec()
            };
            assert!(ids(Accuracy::Certified) == ids(Accuracy::Exact), "{what}, {backend:?}");
        }
    }
}

/// Most of a dense cloud is forgotten, in whatever order it comes, and nothing that is seen.
#[test]
fn hidden_spheres_are_forgotten() {
    for (what, scene) in scenes().into_iter().take(2) {
        let kept = stream(&scene, &settings(), 500).ids.ids;
        let frame = cpu().render(&scene, &settings()).expect("a frame");
        let mut visible: Vec<u64> = frame.ids().iter().filter_map(|id| u64::try_from(*id).ok()).collect();
        visible.sort_unstable();
        visible.dedup();
        assert!(visible.iter().all(|id| kept.binary_search(id).is_ok()), "{what}");
        assert!(kept.len() < 3 * visible.len() && kept.len() < scene.spheres.len() / 2, "{what}: {} kept", kept.len());
        // Rays through samples are compared one by one, so that spheres smaller than a pixel hide others.
        let mut small = scene;
        small.spheres = cloud(12, 60_000, [0.0; 3], 1.0, 0.006);
        let [one, sixteen] =
            [1, 16].map(|samples| stream(&small, &Settings { samples, ..settings() }, 5000).ids.ids.len());
        println!("{what}: {one} of 60000 kept, {sixteen} with 16 samples");
        assert!(4 * one < 60_000 && 2 * sixteen < 60_000, "{what}: {one} kept, {sixteen} with 16 samples");
    }
}

/// Negative control: a stream that loses a sphere gives another frame.
#[test]
fn a_lost_sphere_is_found() {
    let (_, scene) = scenes().swap_remove(0);
    let whole = cpu().render(&scene, &settings()).expect("a frame");
    let hit = *whole.ids().iter().find(|id| **id >= 100).expect("a hit") as usize;
    let mut without = scene;
    without.spheres.centers.to_mut()[hit] = [0.0, 0.0, 1e3];
    let visible = stream(&without, &settings(), 500);
    let mut streamed = cpu().render(&visible.scene, &settings()).expect("a frame");
    visible.ids.restore(&mut streamed);
    assert!(!differing(&whole, &streamed).is_empty());
}

#[test]
fn what_needs_all_spheres_is_refused() {
    let (_, plain) = scenes().swap_remove(0);
    let mut with_light = plain.clone();
    with_light.lighting.lights.push(Light::white(LightSource::Direction(DVec3::Z)));
    for (scene, settings) in [
        (&plain, Settings { accuracy: Accuracy::Fast, ..settings() }),
        (&plain, Settings { accuracy: Accuracy::Auto, method: Some(Method::Stable), ..settings() }),
        (&plain, Settings { aovs: vec![Aov::Occlusion], ..settings() }),
        (&with_light, settings()),
    ] {
        assert!(matches!(Stream::new(scene, &settings), Err(Error::Settings { .. })));
    }
    let mut stream = Stream::new(&plain, &settings()).expect("a stream");
    let mut bare = cloud(1, 5, [0.0; 3], 1.0, 0.1);
    stream.add(&bare).expect("coloured spheres");
    bare.colors = None;
    assert!(matches!(stream.add(&bare), Err(Error::Scene { .. })));
    bare.radii.to_mut()[3] = -1.0;
    assert!(matches!(stream.add(&bare), Err(Error::Scene { .. })));
}
