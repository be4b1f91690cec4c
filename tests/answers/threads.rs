//! The promise of a process with many renderers: threads that make, use and drop one each, side by side, all have the answers of one.

use crate::adapter::{gpu_or_skip, renderers};
use crate::amount::amount;
use crate::rng::Rng;
use crate::weekend::weekend;
use glam::DVec3;
use halfline::camera::{Camera, Lens, Look};
use halfline::frame::{Aov, Frame};
use halfline::render::Renderer;
use halfline::scene::{CutPlane, ImagePlane, Lighting, Scene, Sky, Spheres};
use halfline::settings::{Accuracy, Backend, Settings};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// The renderers of a round.
const RENDERERS: usize = 16;

#[test]
fn sixteen_renderers_begin_and_end_in_sixteen_threads() {
    let Some(mut first) = gpu_or_skip() else { return };
    let mut scene = weekend();
    (scene.image.width, scene.image.height) = (32, 20);
    let aovs = vec![Aov::Distance];
    let settings = Settings { backend: Backend::Gpu, accuracy: Accuracy::Certified, aovs, ..Settings::default() };
    let answers = |frame: &Frame| {
        let distances = frame.f64(Aov::Distance).expect("distances").iter().map(|x| x.to_bits());
        (frame.ids().to_vec(), distances.collect::<Vec<_>>())
    };
    let expected = answers(&first.render(&scene, &settings).expect("a frame"));
    // As many as a machine with a card was asked to try.
    for round in 0..amount("rounds of sixteen renderers", [1, 1, 100]) {
        let one = || {
            let mut renderer = Renderer::new(&settings).expect("an adapter");
            answers(&renderer.render(&scene, &settings).expect("a frame"))
        };
        let all = thread::scope(|scope| {
            let threads: Vec<_> = (0..RENDERERS).map(|_| scope.spawn(one)).collect();
            threads.into_iter().map(|thread| thread.join().expect("a thread")).collect::<Vec<_>>()
        });
        assert!(all.iter().all(|answers| *answers == expected), "round {round}");
    }
}

/// The views of a film around a cloud.
const VIEWS: usize = 10;

/// Spheres of a cloud, some translucent, some cut, and how they are lit.
fn films() -> Vec<(&'static str, Scene, Settings)> {
    let mut rng = Rng::new(77);
    let mut spheres = Spheres::default();
    for n in 0..20_000 {
        let place = rng.cube();
        spheres.push(place, 0.01 + 0.02 * rng.unit(), (n % 3 == 0).then_some([0.2, 0.5, 0.9]));
    }
    let image = ImagePlane { width: 96, height: 64, background: [0.1; 3] };
    let lens = Lens::Vfov { degrees: 40.0, distance: 1.0 };
    let camera = Camera { eye: DVec3::new(0.0, 0.0, 4.0), look: Look::At(DVec3::ZERO), up: DVec3::Y, lens };
    let plain = Scene { camera, image, spheres, lighting: Lighting::default() };
    let mut soft = plain.clone();
    soft.lighting = Lighting { sky: Some(Sky { rays: 4, ..Sky::default() }), shadows: true, ..Lighting::default() };
    let mut ghosts = plain.clone();
    ghosts.spheres.opacities = Some((0..20_000).map(|n| if n % 2 == 0 { 1.0 } else { 0.4 }).collect::<Vec<_>>().into());
    let mut cut = plain.clone();
    let plane = CutPlane { normal: [1.0, 0.2, 0.0], distance: 0.1 };
    cut.spheres.cut(&[plane], None).expect("cut spheres");
    let certified = Settings { accuracy: Accuracy::Certified, ..Settings::default() };
    let picture = Settings { aovs: vec![Aov::Color, Aov::Id, Aov::Normal], ..certified.clone() };
    let buffers = Settings { aovs: vec![Aov::Color, Aov::Id, Aov::Distance, Aov::Bound], ..certified };
    let mut all = vec![
        ("plain", plain, buffers.clone()),
        ("soft", soft, picture.clone()),
        ("samples", ghosts, Settings { samples: 4, ..picture.clone() }),
        ("cut", cut, buffers),
    ];
    all.iter_mut().for_each(|(_, scene, _)| scene.spheres.share());
    all
}

/// View `n` of a film.
fn view(scene: &Scene, n: usize) -> Scene {
    let angle = n as f64 / VIEWS as f64 * std::f64::consts::TAU;
    let eye = 4.0 * DVec3::new(angle.sin(), 0.2, angle.cos());
    Scene { camera: Camera { eye, ..scene.camera }, ..scene.clone() }
}

/// Two renderers on a device, in two threads, have the frames of one, and the device holds equal spheres once.
#[test]
fn frames_in_flight_have_the_bits_of_frames_in_turn() {
    for (what, scene, settings) in films() {
        for (backend, mut renderer) in renderers() {
            let settings = Settings { backend, ..settings.clone() };
            let in_turn: Vec<Frame> =
                (0..VIEWS).map(|n| renderer.render(&view(&scene, n), &settings).expect("a frame")).collect();
            let mut pair = [renderer.another(), renderer.another()];
            drop(renderer);
            let views = AtomicUsize::new(0);
            let film = |renderer: &mut Renderer| {
                let mut frames = Vec::new();
                loop {
                    let n = views.fetch_add(1, Ordering::Relaxed);
                    if n >= VIEWS {
                        return frames;
                    }
                    frames.push((n, renderer.render(&view(&scene, n), &settings).expect("a frame")));
                }
            };
            let made = thread::scope(|scope| {
                let threads = pair.each_mut().map(|renderer| scope.spawn(|| film(renderer)));
                threads.map(|thread| thread.join().expect("a thread"))
            });
            for (n, frame) in made.iter().flatten() {
                assert!(frame.buffers == in_turn[*n].buffers, "{what}, {backend:?}: view {n}");
            }
            if backend == Backend::Gpu && what == "plain" {
                let sent = |frame: &Frame| frame.report.bytes_up;
                let once = 32 * scene.spheres.len() as u64;
                let all: u64 = made.iter().flatten().map(|(_, frame)| sent(frame)).sum();
                assert!(sent(&in_turn[0]) > once && (once..2 * once).contains(&all), "{all} bytes sent");
            }
        }
    }
}
