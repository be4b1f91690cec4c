//! Pictures that a device draws, beside the pictures of the host.

use super::trial::{DECIDED, MOST, colors, is_alike};
use super::*;
use crate::frame::Data;
use crate::frame::outline::Outline;
use crate::gpu::room::Fault;
use crate::render::Renderer;
use crate::scene::camera::Camera;
use crate::scene::{ImagePlane, Lighting, Sky, SkyColors, Spheres};
use crate::settings::{Backend, Settings};
use crate::testing::{Rng, adapter_or_skip, calls_apart};
use crate::{Aov, Frame};

/// A cloud of spheres of many sizes before the eye, with a large one as ground.
fn cloud(count: usize, colors: bool, seed: u64) -> Scene {
    let mut rng = Rng(seed);
    let mut spheres = Spheres::default();
    for _ in 0..count {
        let center = [0; 3].map(|_| rng.between(-1.0, 1.0));
        let color = colors.then(|| [0; 3].map(|_| rng.between(0.1, 1.0) as f32));
        spheres.push(center, 0.3 * rng.between(0.1, 1.0) * (count as f64).powf(-1.0 / 3.0) * 3.0, color);
    }
    spheres.push([0.0, -101.3, 0.0], 100.0, colors.then_some([0.5, 0.6, 0.7]));
    let base = trial::scene();
    let camera = Camera { eye: DVec3::new(0.4, 0.7, 4.0), ..base.camera };
    let image = ImagePlane { width: 161, height: 118, ..base.image };
    let lighting = Lighting { sky: Some(Sky { share: 0.5, ..Sky::AT_CENTERS }), ..base.lighting };
    Scene { camera, image, spheres, lighting }
}

fn settings(backend: Backend) -> Settings {
    let aovs = vec![Aov::Color, Aov::Alpha, Aov::Id];
    Settings { backend, aovs, samples: 4, silhouette: true, ..Settings::default() }
}

fn alpha(frame: &Frame) -> &Data {
    &frame.get(Aov::Alpha).expect("coverage").data
}

#[test]
fn a_picture_of_a_device_is_that_of_the_host_within_roundings() {
    let Some(_) = adapter_or_skip() else { return };
    let mut renderer = Renderer::new(&settings(Backend::Gpu)).expect("an adapter; tests/run installs and pins one");
    let mut host = Renderer::new(&settings(Backend::Cpu)).expect("the CPU path");
    renderer.device.gpu.as_mut().expect("a device").draws = None;
    let gradient = SkyColors { zenith: [0.3, 0.5, 1.0], horizon: [1.0, 0.9, 0.8], is_shown: true };
    let soft = settings(Backend::Gpu);
    let wide = Settings { outline: Outline { width: 3.0, ..Outline::default() }, depth_cue: true, ..soft.clone() };
    let crop = Settings { window: Some(Window { x0: 37, y0: 20, x1: 120, y1: 90 }), ..soft.clone() };
    let bare = Settings { silhouette: false, samples: 1, ..soft.clone() };
    let many = Settings { samples: 16, ..soft.clone() };
    for (n, settings) in [soft, wide, crop, bare, many].iter().enumerate() {
        for (count, seed) in [(12, 1), (3000, 2)] {
            let mut scene = cloud(count, n % 2 == 0, seed);
            if n % 3 == 1 {
                scene.lighting.sky = Some(Sky { colors: Some(gradient), ..Sky::AT_CENTERS });
            }
            let drawn = renderer.render(&scene, settings).expect("a frame");
            let expected =
                host.render(&scene, &Settings { backend: Backend::Cpu, ..settings.clone() }).expect("a frame");
            assert_eq!(drawn.report.warnings, expected.report.warnings, "{n}, {count}");
            assert_eq!(alpha(&drawn), alpha(&expected), "{n}, {count}");
            let differences = colors(&drawn).iter().zip(colors(&expected)).map(|(a, b)| (a - b).abs());
            let differences: Vec<f32> = differences.collect();
            let most = differences.iter().copied().fold(0.0, f32::max);
            let beyond = differences.iter().filter(|x| **x > MOST).count();
            let differ = differences.iter().filter(|x| **x > 0.0).count();
            let share = drawn.report.light_on_device.expect("rays from hits");
            println!(
                "{n}, {count}: {differ} of {} differ, {beyond} beyond {MOST}, at most {most}; {share} of hits",
                differences.len()
            );
            assert!(beyond as f64 <= DECIDED * differences.len() as f64, "{n}, {count}: {beyond}");
            // The device drew it: sums in f32 differ from those in f64 somewhere, and nearly all hits are its own.
            assert!(differ > 100 && share > 0.9, "{n}, {count}: {differ}, {share}");
        }
    }
}

/// A device whose pictures are wrong leaves them to the host.
#[test]
fn a_device_that_fails_the_trial_draws_no_picture() {
    let Some(_) = adapter_or_skip() else { return };
    let mut renderer = Renderer::new(&settings(Backend::Gpu)).expect("an adapter; tests/run installs and pins one");
    let scene = cloud(12, true, 1);
    let picture = |renderer: &mut Renderer| {
        let frame = renderer.render(&scene, &settings(Backend::Gpu)).expect("a frame");
        (colors(&frame).to_vec(), renderer.device.gpu.as_ref().expect("a device").draws)
    };
    renderer.device.gpu.as_mut().expect("a device").draws = Some(false);
    let of_host = picture(&mut renderer);
    renderer.device.gpu.as_mut().expect("a device").draws = None;
    let drawn = picture(&mut renderer);
    assert!(drawn.1 == Some(true) && drawn.0 != of_host.0, "the device drew it");
    let gpu = renderer.device.gpu.as_mut().expect("a device");
    gpu.draws = None;
    gpu.spoil_pictures();
    assert!(picture(&mut renderer) == of_host, "a picture of the host");
}

/// Whatever call of a device fails while it draws, there is a picture, and a warning.
#[test]
fn a_device_that_fails_while_it_draws_leaves_a_picture() {
    let Some(found) = adapter_or_skip() else { return };
    let apart = calls_apart(&found.summary.name);
    let mut scene = cloud(12, true, 1);
    (scene.image.width, scene.image.height) = (67, 51);
    let mut host = Renderer::new(&settings(Backend::Cpu)).expect("the CPU path");
    let expected = host.render(&scene, &settings(Backend::Cpu)).expect("a frame");
    for (fault, word) in [(Fault::Lost, " was lost"), (Fault::OutOfMemory, " is out of memory")] {
        let mut calls = 0;
        loop {
            let mut renderer =
                Renderer::new(&settings(Backend::Gpu)).expect("an adapter; tests/run installs and pins one");
            renderer.verdict().expect("a self-test");
            let gpu = renderer.device.gpu.as_mut().expect("a device");
            (gpu.draws, gpu.fault) = (Some(true), Some((calls + 1, fault)));
            let frame = renderer.render(&scene, &settings(Backend::Auto)).expect("a frame");
            assert!(is_alike(colors(&frame), colors(&expected)), "{fault:?} at call {}", calls + 1);
            if renderer.device.gpu.as_ref().is_some_and(|gpu| gpu.fault.is_some()) {
                break;
            }
            let warnings = &frame.report.warnings;
            assert!(warnings.iter().any(|warning| warning.contains(word)), "{calls}: {warnings:?}");
            calls += apart;
        }
        // The spheres, the centres, their rays, the means, two of each sample, and the picture.
        println!("{fault:?}: {calls} calls");
        assert!(calls >= 13, "{calls}");
    }
}

/// Whatever a picture shows, it is the host's within roundings, and so are its buffers: also where the device leaves some of it to the
/// host, such as spheres that are seen through others.
#[test]
fn drawn_pictures_of_a_device_are_those_of_the_host() {
    let Some(_) = adapter_or_skip() else { return };
    let mut renderer = Renderer::new(&settings(Backend::Gpu)).expect("an adapter; tests/run installs and pins one");
    let mut host = Renderer::new(&settings(Backend::Cpu)).expect("the CPU path");
    renderer.device.gpu.as_mut().expect("a device").draws = Some(true);
    let mut rng = Rng(0x5eed_0104);
    let mut drawn = 0;
    for n in 0..24 {
        let mut is = |share: f64| rng.between(0.0, 1.0) < share;
        let mut scene = cloud(12, is(0.5), 7 + n);
        (scene.image.width, scene.image.height) = (67, 51);
        let ghosts = is(0.5);
        if ghosts {
            scene.spheres.opacities = Some((0..13).map(|k| if k % 2 == 0 { 0.5 } else { 1.0 }).collect());
        }
        scene.lighting.sky = Some(Sky { reach: if is(0.5) { 0.3 } else { f64::INFINITY }, ..Sky::AT_CENTERS });
        scene.lighting.shadows = is(0.3);
        let more = if is(0.3) { vec![Aov::Occlusion, Aov::Shadow] } else { Vec::new() };
        let settings = Settings {
            samples: if is(0.3) { 1 } else { 4 },
            layers: if is(0.5) { 3 } else { 0 },
            opacity_shadows: is(0.6),
            silhouette: is(0.5),
            depth_cue: is(0.3),
            aovs: [vec![Aov::Color, Aov::Alpha, Aov::Id], more].concat(),
            ..settings(Backend::Gpu)
        };
        let found = renderer.render(&scene, &settings).expect("a frame");
        let expected = host.render(&scene, &settings).expect("a frame");
        let values = colors(&found).iter().zip(colors(&expected));
        let beyond = values.clone().filter(|(a, b)| (*a - *b).abs() > MOST).count();
        assert!(beyond <= 3 && values.len() == 3 * 67 * 51, "{n}: {beyond} of {}: {settings:?}", values.len());
        drawn += usize::from(colors(&found) != colors(&expected));
        assert!(!ghosts || colors(&found) == colors(&expected), "{n}: the host draws what is seen through others");
        for (found, expected) in
            found.buffers.iter().zip(&expected.buffers).filter(|(found, _)| found.aov != Aov::Color)
        {
            assert_eq!(found, expected, "{n}: {settings:?}");
        }
    }
    assert!(drawn > 4, "the device drew {drawn}");
}
