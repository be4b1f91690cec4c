//! The promise of translucent spheres: a picture shows the layers of each ray over the picture of the opaque spheres, in exact
//! order and with the same bits everywhere, and no other buffer depends on opacities.
//!
//! Gold standard of the order: fractions (`python3 tests/truth/layers.py`), whose program shares nothing with this one. Tolerance
//! of colours: 2^-20, far above the roundings of a few products in f32, and far below what any other order would change.

use crate::adapter::{cpu, gpu, is_strict, renderers};
use crate::amount::amount;
use crate::bits::{Bits, differing};
use crate::cloud::cloud;
use crate::oblique::{self, vfov};
use crate::rng::Rng;
use crate::stream::{blocks, settings as stream_settings};
use crate::truth::Digits;
use glam::DVec3;
use halfline::camera::{Aperture, Camera, Lens, Look as Toward};
use halfline::frame::{Aov, Frame};
use halfline::render::Renderer;
use halfline::render::stream::Stream;
use halfline::scene::{ImagePlane, Light, LightSource, Lighting, Material, Scene, Sky, Spheres};
use halfline::settings::{Accuracy, AddedLight, Backend, Look, Settings};
use halfline::shade::Shade;
use halfline::window::Window;
use serde::Deserialize;

const SIZE: [u32; 2] = [73, 51];

#[derive(Deserialize)]
struct Case {
    eye: [Digits; 3],
    viewport: [Digits; 2],
    parallel: bool,
    spheres: Vec<[Digits; 4]>,
    opaque: Vec<bool>,
    /// Of each pixel the spheres in order, one letter each, up to the first opaque one; `.` for none.
    rows: Vec<Vec<String>>,
}

impl Case {
    fn scene(&self, rng: &mut Rng) -> Scene {
        let mut spheres = Spheres::default();
        for (sphere, opaque) in self.spheres.iter().zip(&self.opaque) {
            let [x, y, z, radius] = sphere.each_ref().map(Digits::number);
            spheres.push([x, y, z], radius, Some(rng.cube().map(|c| 0.5 + 0.5 * c as f32)));
            spheres.set_opacity_from(spheres.len() - 1, if *opaque { 1.0 } else { 0.1 + 0.8 * rng.unit() as f32 });
        }
        let [vw, vh] = self.viewport.each_ref().map(Digits::number);
        let lens =
            if self.parallel { Lens::Orthographic { height: vh } } else { Lens::Viewport { vw, vh, distance: 1.0 } };
        let look = Toward::View(-DVec3::Z);
        let camera = Camera { eye: self.eye.each_ref().map(Digits::number).into(), look, up: DVec3::Y, lens };
        let image = ImagePlane { width: 9, height: 7, background: [0.25, 0.5, 0.125] };
        Scene { camera, image, spheres, lighting: Default::default() }
    }
}

/// Colour and coverage of a pixel whose ray meets these spheres, composed back to front in f64.
fn composed(scene: &Scene, hits: &str, layers: usize) -> ([f64; 3], f64) {
    let spheres = &scene.spheres;
    let color = |n: usize| spheres.colors.as_ref().expect("colours")[n].map(f64::from);
    let ids: Vec<usize> = hits.bytes().take_while(|c| *c != b'.').map(|c| usize::from(c - b'a')).collect();
    let is_opaque = |n: &usize| spheres.opacity(*n as u32) == 1.0;
    let last = ids.last().copied().filter(is_opaque);
    let mut mixed = last.map_or(scene.image.background.map(f64::from), color);
    let mut passing = if last.is_some() { 0.0 } else { 1.0 };
    let shown: Vec<usize> = ids.into_iter().filter(|n| !is_opaque(n)).take(layers).collect();
    for n in shown.into_iter().rev() {
        let opacity = f64::from(spheres.opacity(n as u32));
        passing *= 1.0 - opacity;
        mixed = std::array::from_fn(|k| mixed[k] + opacity * (color(n)[k] - mixed[k]));
    }
    (mixed, 1.0 - passing)
}

#[test]
fn layers_are_those_of_exact_fractions() {
    let cases: Vec<Case> = serde_json::from_str(include_str!("../truth/layers.json")).expect("the fixture");
    assert_eq!(cases.len(), 200);
    let mut rng = Rng::new(50);
    let scenes: Vec<Scene> = cases.iter().map(|case| case.scene(&mut rng)).collect();
    let (mut renderers, mut wrong, mut deep) = (renderers(), Vec::new(), 0);
    // Each scene with some numbers of layers on the CPU path, and with one on an adapter, which decides the opaque spheres alone.
    let counts = amount("numbers of layers of a scene", [1, 4, 4]);
    let on_device = amount("numbers of layers of a scene on an adapter", [1, 1, 4]);
    for (n, (case, scene)) in cases.iter().zip(&scenes).enumerate() {
        for (k, layers) in [8, 0, 1, 2].into_iter().cycle().skip(n % 4).take(counts).enumerate() {
            let truth: Vec<_> = case.rows.iter().flatten().map(|hits| composed(scene, hits, layers.max(1))).collect();
            deep += case.rows.iter().flatten().filter(|hits| hits.len() > 2 && layers == 8).count();
            for (backend, renderer) in renderers.iter_mut().filter(|(of, _)| *of == Backend::Cpu || k < on_device) {
                for accuracy in [Accuracy::Certified, Accuracy::Exact] {
                    let (aovs, layers) = (vec![Aov::Color, Aov::Alpha], layers as u32);
                    let settings = Settings { accuracy, shade: Shade::Flat, aovs, layers, ..Settings::default() };
                    let frame = renderer.render(scene, &settings).expect("a frame");
                    let color = frame.f32(Aov::Color).expect("colours");
                    let alpha = frame.f32(Aov::Alpha).expect("coverage");
                    let near = |a: f32, b: f64| (f64::from(a) - b).abs() < 2f64.powi(-20);
                    let is_right = |n: usize| {
                        let (mixed, cover) = &truth[n];
                        near(alpha[n], *cover) && (0..3).all(|k| near(color[3 * n + k], mixed[k]))
                    };
                    let off = (0..truth.len()).filter(|n| !is_right(*n)).count();
                    if off > 0 {
                        wrong.push(format!(
                            "scene {n}, {layers} layers, {}, {}: {off}",
                            backend.name(),
                            accuracy.name()
                        ));
                    }
                }
            }
        }
    }
    assert!(deep > 250 * counts, "{deep} pixels with several hits");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A crowd whose first third is translucent, before and behind the others.
fn crowd() -> Scene {
    let mut spheres = cloud(4, 240, [0.0; 3], 1.2, 0.09);
    let mut rng = Rng::new(9);
    let opacities = (0..spheres.len()).map(|n| if n % 3 == 0 { 0.2 + 0.5 * rng.unit() as f32 } else { 1.0 });
    spheres.opacities = Some(opacities.collect());
    let scene = oblique::scene(SIZE, [1.0, 2.0, 4.5], [0.0; 3], vfov(32.0), spheres);
    Scene { image: ImagePlane { background: [0.3, 0.1, 0.6], ..scene.image }, ..scene }
}

/// The scene and the settings of pictures of every kind, with their names.
fn kinds() -> Vec<(&'static str, Scene, Settings)> {
    let base = || Settings {
        accuracy: Accuracy::Certified,
        aovs: vec![Aov::Color, Aov::Alpha, Aov::Id, Aov::Distance, Aov::Normal, Aov::Certainty],
        ..Settings::default()
    };
    let plain = crowd();
    let with = |light: AddedLight| {
        let mut scene = crowd();
        light.apply(&mut scene, &[]).expect("light");
        scene
    };
    let soft = with(AddedLight { look: Look::Soft, ..AddedLight::default() });
    let sun = vec![DVec3::new(1.0, 2.0, 1.0)];
    let shadows = with(AddedLight { suns: sun.clone(), shadows: true, ..AddedLight::default() });
    let sky = with(AddedLight { occlusion: Some(Some(8)), suns: sun, ..AddedLight::default() });
    let drawn = Settings { silhouette: true, samples: 4, ..base() };
    vec![
        ("plain", plain.clone(), base()),
        ("flat, 9 samples, 3 layers", plain.clone(), Settings { shade: Shade::Flat, samples: 9, layers: 3, ..base() }),
        ("normals, 2 layers", plain.clone(), Settings { shade: Shade::Normal, layers: 2, ..base() }),
        ("lines and cue", plain.clone(), Settings { depth_cue: true, ..drawn.clone() }),
        ("soft", soft.clone(), drawn.clone()),
        ("soft, 2 layers", soft, Settings { layers: 2, ..drawn.clone() }),
        ("shadows", shadows.clone(), Settings { samples: 4, ..base() }),
        ("shadows of all", shadows, Settings { opacity_shadows: true, ..base() }),
        ("a sky for each sample", sky, drawn),
        (
            "a lens",
            plain.clone(),
            Settings {
                samples: 4,
                layers: 2,
                aperture: Some(Aperture { diameter: 0.3, focus: Some(4.0) }),
                shade: Shade::Flat,
                ..base()
            },
        ),
        ("exact", plain, Settings { accuracy: Accuracy::Exact, layers: 2, ..base() }),
    ]
}

fn render(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Frame {
    renderer.render(scene, settings).expect("a frame")
}

#[test]
fn pictures_have_the_same_bits_on_devices_in_crops_and_in_any_order_of_spheres() {
    let (mut cpu, mut gpu) = (cpu(), gpu());
    for (what, scene, settings) in kinds() {
        let whole = render(&mut cpu, &scene, &settings);
        let plain = render(&mut cpu, &Scene { spheres: opaque(&scene.spheres), ..scene.clone() }, &settings);
        let changed = differing(&whole, &plain);
        assert_eq!(changed, [Aov::Color, Aov::Alpha], "{what}: pictures alone");
        if let Some(gpu) = gpu.as_mut().filter(|gpu| is_strict(gpu)) {
            let other = render(gpu, &scene, &settings);
            assert_eq!((differing(&whole, &other), other.report.backend), (vec![], "gpu"), "{what}");
        }
        let alone = render(&mut cpu, &scene, &Settings { aovs: vec![Aov::Alpha], ..settings.clone() });
        assert!(alone.bits(Aov::Alpha) == whole.bits(Aov::Alpha), "{what}: coverage alone");
        for window in [[3, 5, 40, 31], [0, 0, 8, 8], [50, 20, 73, 51]] {
            let [x0, y0, x1, y1] = window;
            let window = Window { x0, y0, x1, y1 };
            let crop = render(&mut cpu, &scene, &Settings { window: Some(window), ..settings.clone() });
            for aov in [Aov::Color, Aov::Alpha] {
                assert!(crop.bits(aov) == whole.bits_in(window, aov), "{what}: {} of {window}", aov.name());
            }
        }
        let turned = render(&mut cpu, &Scene { spheres: reversed(&scene.spheres), ..scene.clone() }, &settings);
        assert!([Aov::Color, Aov::Alpha].iter().all(|aov| turned.bits(*aov) == whole.bits(*aov)), "{what}: reversed");
    }
}

fn opaque(spheres: &Spheres) -> Spheres {
    Spheres { opacities: None, ..spheres.clone() }
}

/// The same spheres, the last one first.
fn reversed(spheres: &Spheres) -> Spheres {
    let mut turned = Spheres::default();
    for n in (0..spheres.len()).rev() {
        turned.push(spheres.centers[n], spheres.radii[n], spheres.colors.as_ref().map(|colors| colors[n]));
        turned.set_opacity_from(turned.len() - 1, spheres.opacity(n as u32));
    }
    turned
}

/// The spheres that are opaque, or those that are not.
fn only(spheres: &Spheres, is_opaque: bool) -> Spheres {
    let mut some = Spheres::default();
    for n in (0..spheres.len()).filter(|n| (spheres.opacity(*n as u32) == 1.0) == is_opaque) {
        some.push(spheres.centers[n], spheres.radii[n], spheres.colors.as_ref().map(|colors| colors[n]));
    }
    some
}

/// A picture in which a ray meets no translucent sphere is there the picture without them, bit for bit: only they are laid over it.
#[test]
fn a_picture_without_a_translucent_hit_is_that_of_the_opaque_spheres() {
    let mut cpu = cpu();
    for (what, scene, settings) in kinds() {
        // The cue goes from the nearest sphere to the farthest of all, and opaque spheres shade all others alike.
        if settings.depth_cue || settings.opacity_shadows {
            continue;
        }
        let shown = render(&mut cpu, &scene, &settings);
        let alone = render(&mut cpu, &Scene { spheres: only(&scene.spheres, true), ..scene.clone() }, &settings);
        // A ray of the pixel or of one around it that meets a translucent sphere anywhere.
        let veiled = {
            let spheres = only(&scene.spheres, false);
            let settings = Settings { aovs: vec![Aov::Alpha], samples: 64, ..settings.clone() };
            render(&mut cpu, &Scene { spheres, ..scene.clone() }, &settings)
        };
        let veil = veiled.f32(Aov::Alpha).expect("coverage");
        let [width, height] = SIZE.map(|n| n as usize);
        let clear = |pixel: usize| {
            let (y, x) = (pixel / width, pixel % width);
            let near = |n: usize, most: usize| n.saturating_sub(1)..(n + 2).min(most);
            near(y, height).all(|y| near(x, width).all(|x| veil[y * width + x] == 0.0))
        };
        let (a, b) = (shown.bits(Aov::Color), alone.bits(Aov::Color));
        let pixels: Vec<usize> = (0..width * height).filter(|pixel| clear(*pixel)).collect();
        let differ = pixels.iter().filter(|pixel| a[3 * **pixel..][..3] != b[3 * **pixel..][..3]).count();
        let hits = pixels.iter().filter(|pixel| shown.ids()[**pixel] >= 0).count();
        assert!(hits > 100, "{what}: {hits} clear hits");
        assert_eq!(differ, 0, "{what}: of {} pixels", pixels.len());
    }
}

/// Opacities that are all 1 change nothing.
#[test]
fn opaque_opacities_are_none() {
    let mut cpu = cpu();
    for (what, scene, settings) in kinds() {
        let mut full = scene.clone();
        full.spheres.opacities = Some(vec![1.0; scene.spheres.len()].into());
        let none = Scene { spheres: opaque(&scene.spheres), ..scene };
        let [a, b] = [&full, &none].map(|scene| render(&mut cpu, scene, &settings));
        assert_eq!(differing(&a, &b), [], "{what}");
        assert_eq!((a.report.layers, b.report.layers), (None, None));
        assert_ne!(full.fingerprint(), none.fingerprint());
    }
}

/// A plate of spheres under a translucent ball, lit from above.
#[test]
fn translucent_spheres_cast_shadows_with_opacity_shadows_alone() {
    let mut spheres = Spheres::default();
    spheres.push([0.0, -1000.0, 0.0], 1000.0, Some([0.8; 3]));
    spheres.push([0.0, 2.0, 0.0], 1.0, Some([0.9, 0.2, 0.1]));
    spheres.set_opacity_from(spheres.len() - 1, 0.4);
    let scene = oblique::scene(SIZE, [0.0, 5.0, 12.0], [0.0, 1.0, 0.0], vfov(30.0), spheres);
    let lights = vec![Light::white(LightSource::Direction(DVec3::Y))];
    let sky = Some(Sky { rays: 16, ..Sky::default() });
    let scene = Scene { lighting: Lighting { lights, shadows: true, sky, ..Lighting::default() }, ..scene };
    let settings = Settings { aovs: vec![Aov::Color, Aov::Shadow, Aov::Occlusion, Aov::Id], ..Settings::default() };
    let mut cpu = cpu();
    let clear = render(&mut cpu, &scene, &settings);
    let dark = render(&mut cpu, &scene, &Settings { opacity_shadows: true, ..settings.clone() });
    assert_eq!(differing(&clear, &dark), [Aov::Color], "buffers do not depend on it");
    let ground: Vec<usize> = (0..clear.ids().len()).filter(|n| clear.ids()[*n] == 0).collect();
    let shadow = clear.f32(Aov::Shadow).expect("shadows");
    let brightness = |frame: &Frame, n: usize| frame.f32(Aov::Color).expect("colours")[3 * n];
    let shaded: Vec<usize> = ground.iter().copied().filter(|n| shadow[*n] == 1.0).collect();
    assert!(shaded.len() > 50, "{} pixels of the ball's shadow", shaded.len());
    let alone = Scene { spheres: only(&scene.spheres, true), ..scene.clone() };
    let alone = render(&mut cpu, &alone, &settings);
    for n in shaded {
        assert_eq!(brightness(&clear, n), brightness(&alone, n), "no shadow, and no part of the sky hidden");
        assert!(brightness(&dark, n) < 0.7 * brightness(&clear, n));
    }
}

/// With a rim a sphere is as opaque as the documentation says: a + (1 - a) (1 - cos)^3 of the angle between the ray and the normal.
#[test]
fn rims_grow_opaque_with_the_angle() {
    let (radius, opacity) = (3.0, 0.3_f64);
    let mut spheres = Spheres::default();
    spheres.push([1.0, -0.5, -7.0], radius, Some([0.8, 0.3, 0.1]));
    spheres.set_opacity_from(spheres.len() - 1, opacity as f32);
    let lens = Lens::Orthographic { height: 8.0 };
    let camera = Camera { eye: DVec3::ZERO, look: Toward::View(-DVec3::Z), up: DVec3::Y, lens };
    let image = ImagePlane { width: 80, height: 60, ..ImagePlane::default() };
    let scene = Scene { camera, image, spheres, lighting: Lighting::default() };
    let settings = Settings { aovs: vec![Aov::Alpha], ghost_rim: true, ..Settings::default() };
    let mut cpu = cpu();
    let frame = render(&mut cpu, &scene, &settings);
    let alpha = frame.f32(Aov::Alpha).expect("coverage");
    let (mut hits, mut least, mut most) = (0, 1.0_f64, 0.0_f64);
    for (pixel, found) in alpha.iter().enumerate() {
        let (row, column) = (pixel / 80, pixel % 80);
        let [x, y] = [(column as f64 + 0.5 - 40.0) * 8.0 / 60.0 - 1.0, (29.5 - row as f64) * 8.0 / 60.0 + 0.5];
        let away = x.hypot(y) / radius;
        if away >= 1.0 {
            assert_eq!(*found, 0.0, "pixel {pixel}");
            continue;
        }
        let expected = opacity + (1.0 - opacity) * (1.0 - (1.0 - away * away).sqrt()).powi(3);
        // Rounding to f32, of the opacity and of the share.
        assert!((f64::from(*found) - expected).abs() < 3e-7, "pixel {pixel}: {found}, not {expected}");
        (hits, least, most) = (hits + 1, least.min(expected), most.max(expected));
    }
    assert!(hits > 1000 && least < 0.301 && most > 0.8, "{hits} hits from {least} to {most}");
    assert!(frame.report.ghost_rim && frame.report.layers == Some(1));
    let plain = render(&mut cpu, &scene, &Settings { ghost_rim: false, ..settings.clone() });
    assert_eq!(plain.ids(), frame.ids());
    assert!(plain.f32(Aov::Alpha).expect("coverage").iter().all(|x| *x == 0.0 || *x == 0.3));
}

/// A mirror shows a translucent sphere as an opaque one.
#[test]
fn mirrors_show_translucent_spheres_as_opaque() {
    let mut spheres = Spheres::default();
    spheres.push([0.0, 0.0, -10.0], 4.0, Some([1.0; 3]));
    spheres.set_last_material(Material::Metal { fuzz: 0.0 });
    spheres.push([0.0, 3.0, 6.0], 2.0, Some([0.9, 0.1, 0.1]));
    let colors_with = |opacity: f32, cpu: &mut Renderer| {
        let mut spheres = spheres.clone();
        spheres.set_opacity_from(spheres.len() - 1, opacity);
        let scene = oblique::scene(SIZE, [0.0, 0.0, 0.0], [0.0, 0.0, -1.0], vfov(60.0), spheres);
        let settings = Settings { aovs: vec![Aov::Color, Aov::Id], ..Settings::default() };
        let frame = render(cpu, &scene, &settings);
        assert!(frame.ids().iter().all(|id| *id != 1), "the sphere is behind the eye");
        frame.bits(Aov::Color)
    };
    let mut cpu = cpu();
    assert!(colors_with(0.25, &mut cpu) == colors_with(1.0, &mut cpu));
}

/// The frame of what a stream or parts keep equals the frame of all spheres.
#[test]
fn streams_and_parts_keep_the_spheres_behind_translucent_ones() {
    let mut spheres = cloud(6, 9000, [0.0; 3], 1.0, 0.02);
    // Half of the space is behind a translucent shell of many, and the opaque ones are within.
    let opacities: Vec<f32> =
        spheres.centers.iter().map(|c| if DVec3::from_array(*c).length() > 0.7 { 0.3 } else { 1.0 }).collect();
    spheres.opacities = Some(opacities.into());
    let scene = crate::stream::scene([1.0, 2.0, 4.0], vfov(40.0), spheres);
    for settings in [stream_settings(), Settings { samples: 4, silhouette: true, ..stream_settings() }] {
        for (backend, renderer) in &mut renderers() {
            let whole = render(renderer, &scene, &settings);
            let mut stream = Stream::new(&scene, &settings).expect("a stream");
            blocks(&scene.spheres, 700).for_each(|block| stream.add(&block).expect("a block"));
            let visible = stream.finish().expect("what is visible");
            let kept = visible.scene.spheres.len();
            let mut frame = render(renderer, &visible.scene, &settings);
            visible.ids.restore(&mut frame);
            assert_eq!(differing(&whole, &frame), [], "{}: a stream", backend.name());
            assert!(kept < 6000, "{kept} of 9000 are kept");
            assert_eq!(visible.scene.fingerprint(), scene.fingerprint());
            let part = |range: std::ops::Range<usize>| {
                let mut stream = Stream::of_part(&scene, &settings, range.start as u64).expect("a part");
                let all = blocks(&scene.spheres, 500).skip(range.start / 500).take(range.len() / 500);
                all.for_each(|block| stream.add(&block).expect("a block"));
                stream.part().expect("a part")
            };
            let parts = [6000..9000, 0..3000, 2000..6500].map(part);
            let [first, others @ ..] = parts;
            let all = first.combine_all(others.into_iter().map(Ok)).expect("parts of one frame");
            let visible = all.visible(&scene, &settings).expect("the same frame");
            let mut frame = render(renderer, &visible.scene, &settings);
            visible.ids.restore(&mut frame);
            assert_eq!(differing(&whole, &frame), [], "{}: parts", backend.name());
            assert_eq!(visible.scene.fingerprint(), scene.fingerprint());
        }
    }
    let refused = Stream::new(&scene, &Settings { layers: 2, ..stream_settings() }).map(drop);
    assert!(refused.expect_err("all spheres are needed").to_string().contains("layer"));
}

/// A sphere that is nearly opaque, and blocks light as opaque ones do, looks like an opaque one: its layer has its own light and sky.
/// Tolerance: what passes, 2^-20 of colours up to 1, and a few roundings.
#[test]
fn nearly_opaque_spheres_look_opaque() {
    let mut cpu = cpu();
    for (what, scene, settings) in kinds() {
        // Lines of an opaque sphere are those before what is opaque behind it.
        let settings = Settings { opacity_shadows: true, layers: 1, silhouette: false, ..settings };
        let nearly = 1.0 - 2f32.powi(-20);
        let mut ghosts = scene.clone();
        let of = |n: usize| if scene.spheres.opacity(n as u32) < 1.0 { nearly } else { 1.0 };
        ghosts.spheres.opacities = Some((0..scene.spheres.len()).map(of).collect());
        let whole = Scene { spheres: opaque(&scene.spheres), ..scene };
        let [a, b] = [&ghosts, &whole].map(|scene| render(&mut cpu, scene, &settings));
        let [a, b] = [&a, &b].map(|frame| frame.f32(Aov::Color).expect("colours"));
        let off: Vec<f64> = a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs())).collect();
        let most = off.iter().copied().fold(0.0, f64::max);
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        // Samples under a sky take the rays of pixels around them, and a layer has other rays. Found: 0.0022 in the mean of all pixels here,
        // and 0.013 with the rays of another layer.
        let is_near = if settings.sky(&ghosts).is_some() { mean < 0.005 } else { most < 2f64.powi(-18) };
        assert!(is_near, "{what}: {most}, mean {mean}");
    }
}
