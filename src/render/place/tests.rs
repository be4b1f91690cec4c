//! An adapter that is lost or out of memory at any moment: the CPU path takes over, or it is an error.

use crate::Method;
use crate::frame::{Aov, Frame};
use crate::gpu::room::Fault;
use crate::render::Renderer;
use crate::render::trace::{Rays, Tracer};
use crate::scene::{ImagePlane, Light, LightSource, Lighting, Scene, Sky, Spheres};
use crate::settings::{Accuracy, Backend, Settings};
use crate::testing::{Rng, adapter_or_skip, calls_apart, keeps_bits, near_and_far};
use crate::window::Window;
use halfline_ground::error::Error;

/// The failures, with a word of their warnings.
const FAULTS: [(Fault, &str); 2] = [(Fault::Lost, " was lost"), (Fault::OutOfMemory, " is out of memory")];

/// Settings under which a device that fails is left.
fn auto(settings: &Settings) -> Settings {
    Settings { backend: Backend::Auto, ..settings.clone() }
}

/// A renderer on the pinned adapter, whose nth call of the device fails.
fn failing(n: u32, fault: Fault) -> Renderer {
    let settings = Settings { backend: Backend::Gpu, ..Settings::default() };
    let mut renderer = Renderer::new(&settings).expect("an adapter; tests/run installs and pins one");
    renderer.verdict().expect("a self-test");
    set(&mut renderer, n, fault);
    renderer
}

fn set(renderer: &mut Renderer, n: u32, fault: Fault) {
    renderer.device.gpu.as_mut().expect("a device").fault = Some((n, fault));
}

/// Spheres with a sky and a light, or without.
fn scene(has_light: bool) -> Scene {
    // Smaller, because it is rendered some hundred times.
    let scene = near_and_far(3);
    let image = ImagePlane { width: 67, height: 38, ..scene.image };
    let sky = Sky { rays: 4, ..Sky::default() };
    let light = Light::white(LightSource::Direction([1.0, 2.0, 3.0].into()));
    let lighting = Lighting { lights: vec![light], sky: Some(sky), shadows: true, ..Lighting::default() };
    Scene { image, lighting: if has_light { lighting } else { Lighting::default() }, ..scene }
}

/// A plain frame with buffers, a picture of several samples in soft light, and a picture by a method.
fn kinds() -> [(Scene, Settings); 3] {
    let plain = Settings { accuracy: Accuracy::Certified, ..Settings::default() };
    let picture = Settings { aovs: vec![Aov::Color, Aov::Id], ..plain.clone() };
    let method = Settings { method: Some(Method::Stable), accuracy: Accuracy::Auto, ..picture.clone() };
    let buffers = vec![Aov::Color, Aov::Id, Aov::Distance, Aov::Normal];
    [
        (scene(false), Settings { aovs: buffers, ..plain }),
        (scene(true), Settings { samples: 4, ..picture }),
        (scene(false), method),
    ]
}

fn count(frame: &Frame, word: &str) -> usize {
    frame.report.warnings.iter().filter(|warning| warning.contains(word)).count()
}

/// Whatever call fails, the frame has the bits of the CPU path and says once what happened. After a loss the CPU path renders all
/// frames; where memory was short, those that are as large.
#[test]
fn the_cpu_path_takes_over_from_an_adapter_that_fails() {
    let Some(found) = adapter_or_skip() else { return };
    let strict = keeps_bits(&found.summary.name);
    let apart = calls_apart(&found.summary.name) as usize;
    for (scene, settings) in kinds() {
        let host = Settings { backend: Backend::Cpu, ..settings.clone() };
        let known = Renderer::new(&host).expect("the CPU path").render(&scene, &host).expect("a frame");
        for (fault, word) in FAULTS {
            let mut calls = 0;
            // Until a frame ends before the call that would fail.
            for n in (1..).step_by(apart) {
                let mut renderer = failing(n, fault);
                let what = format!("{settings:?}, {fault:?} at call {n}");
                let first = renderer.render(&scene, &auto(&settings)).expect(&what);
                if renderer.device.gpu.as_ref().is_some_and(|gpu| gpu.fault.is_some()) {
                    break;
                }
                calls = n;
                assert_eq!(count(&first, word), 1, "{what}: {:?}", first.report.warnings);
                // Rays from hits have a warning of their own, and the device goes on without them.
                if strict || first.report.backend == "cpu" {
                    assert!(first.buffers == known.buffers, "{what}");
                }
                let again = renderer.render(&scene, &auto(&settings)).expect(&what);
                assert_eq!(count(&again, word), 1, "{what}: {:?}", again.report.warnings);
                assert_eq!(again.report.backend, first.report.backend, "{what}");
                if strict || again.report.backend == "cpu" {
                    assert!(again.buffers == known.buffers, "{what}");
                }
                assert_eq!(renderer.is_gpu(), fault == Fault::OutOfMemory, "{what}");
                let corner = Some(Window { x0: 20, y0: 10, x1: 46, y1: 26 });
                let small = renderer.render(&scene, &Settings { window: corner, ..auto(&settings) }).expect(&what);
                assert_eq!(small.report.backend == "gpu", fault == Fault::OutOfMemory, "{what}: a smaller frame");
                if first.report.backend == "cpu" {
                    assert_eq!(first.report.adapter, "cpu", "{what}");
                    assert_eq!(count(&small, word), usize::from(fault == Fault::Lost), "{what}");
                }
            }
            assert!(calls > 0, "{settings:?}: {fault:?}");
        }
    }
}

/// Two renderers of a device in two threads: where it is lost, both go on with the CPU path; where it is out of memory for one, the
/// other goes on.
#[test]
fn renderers_of_one_device_leave_it_each_for_itself() {
    let Some(found) = adapter_or_skip() else { return };
    let strict = keeps_bits(&found.summary.name);
    for (mut scene, settings) in kinds() {
        scene.spheres.share();
        let host = Settings { backend: Backend::Cpu, ..settings.clone() };
        let known = Renderer::new(&host).expect("the CPU path").render(&scene, &host).expect("a frame");
        for (fault, word) in FAULTS {
            let renderer = failing(2, fault);
            let mut pair = [renderer.another(), renderer];
            let film =
                |renderer: &mut Renderer| [0; 4].map(|_| renderer.render(&scene, &auto(&settings)).expect("a frame"));
            let films = std::thread::scope(|scope| {
                let threads = pair.each_mut().map(|renderer| scope.spawn(|| film(renderer)));
                threads.map(|thread| thread.join().expect("a thread"))
            });
            for frame in films.iter().flatten() {
                assert!(!strict && frame.report.backend == "gpu" || frame.buffers == known.buffers, "{fault:?}");
            }
            let [other, failed] =
                films.each_ref().map(|film| film.iter().filter(|frame| count(frame, word) > 0).count());
            assert!(failed > 0, "{fault:?}: the one that failed says so");
            assert!(fault == Fault::Lost || other == 0, "{fault:?}: the other has memory");
            let is_left = fault == Fault::Lost;
            let again = pair.each_mut().map(|renderer| {
                let frame = renderer.render(&scene, &auto(&settings)).expect("a frame");
                assert!(!strict || frame.buffers == known.buffers, "{fault:?}");
                renderer.is_gpu()
            });
            assert_eq!(again, [!is_left; 2], "{fault:?}");
        }
    }
}

/// Work that an adapter refuses, such as a shader that its compiler does not take, is done on the CPU path, and so is all later work.
#[test]
fn the_cpu_path_takes_over_from_an_adapter_that_refuses() {
    if adapter_or_skip().is_none() {
        return;
    }
    for (scene, settings) in kinds() {
        let host = Settings { backend: Backend::Cpu, ..settings.clone() };
        let known = Renderer::new(&host).expect("the CPU path").render(&scene, &host).expect("a frame");
        let mut renderer = failing(1, Fault::Invalid);
        for _ in 0..2 {
            let frame = renderer.render(&scene, &auto(&settings)).expect("a frame");
            assert_eq!((frame.report.backend, count(&frame, " failed: ")), ("cpu", 1), "{settings:?}");
            assert!(frame.buffers == known.buffers && !renderer.is_gpu(), "{settings:?}");
        }
        let gpu = Settings { backend: Backend::Gpu, ..settings };
        let error = failing(1, Fault::Invalid).render(&scene, &gpu).expect_err("refused");
        assert!(matches!(error, Error::Adapter { .. }), "{error}");
    }
}

/// The failure of an adapter that was requested is an error. After one of memory the next frame is tried with new buffers; after a loss
/// there is no other.
#[test]
fn a_failure_of_a_requested_adapter_is_an_error() {
    if adapter_or_skip().is_none() {
        return;
    }
    for (scene, settings) in kinds() {
        let gpu = Settings { backend: Backend::Gpu, ..settings };
        let mut renderer = failing(1, Fault::OutOfMemory);
        for n in 1..3 {
            set(&mut renderer, 1, Fault::OutOfMemory);
            match renderer.render(&scene, &gpu) {
                Err(Error::Limits { problem, .. }) => assert!(problem.ends_with("is out of memory"), "{problem}"),
                other => panic!("{n}: {:?}", other.map(|frame| frame.report)),
            }
            let frame = renderer.render(&scene, &gpu).expect("a frame");
            assert_eq!((frame.report.backend, count(&frame, "memory")), ("gpu", 0), "{n}");
        }
        set(&mut renderer, 1, Fault::Lost);
        for _ in 0..2 {
            let error = renderer.render(&scene, &gpu).expect_err("a lost device");
            assert!(matches!(error, Error::DeviceLost(_)), "{error}");
        }
    }
}

/// Answers to given rays, the nearest hits and whether anything is hit.
fn answers(tracer: &mut Tracer<'_>, rays: &Rays) -> (Vec<i32>, Vec<f64>, Vec<u8>) {
    let hits = tracer.hits(rays).expect("hits");
    (hits.id, hits.t, tracer.occluded(rays).expect("answers").hit)
}

/// Given rays: the call that fails and all later ones are answered on the CPU path. The spheres are more than one submission writes.
#[test]
fn the_cpu_path_traces_rays_of_an_adapter_that_fails() {
    if adapter_or_skip().is_none() {
        return;
    }
    let mut rng = Rng(0x7ace);
    let mut spheres = Spheres::default();
    (0..9000).for_each(|_| spheres.push([0; 3].map(|_| rng.between(-9.0, 9.0)), rng.between(0.01, 0.3), None));
    let directions: Vec<[f64; 3]> = (0..500).map(|_| [0; 3].map(|_| rng.between(-1.0, 1.0))).collect();
    let rays = Rays { origins: &[[0.1, 0.2, 0.3]], directions: &directions, limits: &[] };
    // Certified rays are traced on the CPU path anyway.
    let settings = Settings { method: Some(Method::Stable), ..Settings::default() };
    let host = Settings { backend: Backend::Cpu, ..settings.clone() };
    let mut renderer = Renderer::new(&host).expect("the CPU path");
    let known = answers(&mut renderer.tracer(&spheres, &host).expect("spheres"), &rays);
    assert!(known.0.iter().filter(|id| **id >= 0).count() > 100);
    for (fault, word) in FAULTS {
        for n in 1..4 {
            let mut renderer = failing(n, fault);
            renderer.device.gpu.as_mut().expect("a device").open.part = 1 << 16;
            let auto = auto(&settings);
            let mut tracer = renderer.tracer(&spheres, &auto).expect("spheres");
            let what = format!("{settings:?}, {fault:?} at call {n}");
            assert!(tracer.is_gpu() && tracer.warning().is_none(), "{what}");
            let first = answers(&mut tracer, &rays);
            assert_eq!(tracer.is_gpu(), n == 3, "{what}");
            assert!(first == known && answers(&mut tracer, &rays) == known, "{what}");
            assert!(tracer.warning().is_some_and(|warning| warning.contains(word)), "{what}");
            assert_eq!((tracer.is_gpu(), tracer.adapter()), (false, "cpu"), "{what}");
            // Another tracer answers on the CPU path too: many spheres are not tried again.
            let mut next = renderer.tracer(&spheres, &auto).expect("spheres");
            assert!(!next.is_gpu() && answers(&mut next, &rays) == known, "{what}");
            let few = spheres.part(&(0..9000).map(|n| n < 10).collect::<Vec<_>>());
            let next = renderer.tracer(&few, &auto).expect("spheres");
            assert_eq!(next.is_gpu(), fault == Fault::OutOfMemory, "{what}");
        }
    }
    let gpu = Settings { backend: Backend::Gpu, ..settings };
    let mut renderer = failing(1, Fault::Lost);
    let error = renderer.tracer(&spheres, &gpu).expect("spheres").hits(&rays).expect_err("a lost device");
    assert!(matches!(error, Error::DeviceLost(_)), "{error}");
}
