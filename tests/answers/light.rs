//! The promises of lights, of the sky, of mirrors and glass: hand-computed values; certified answers that are the exact ones;
//! the same bits in every crop, tile and number of threads.
//!
//! Gold standards: numbers derived in the comments, exact arithmetic, a sky of 65,536 rays. All of it on the CPU path, which
//! computes lights on every backend.

use crate::adapter::cpu;
use crate::bits::Bits;
use crate::cloud::cloud;
use glam::DVec3;
use halfline::camera::{Camera, Lens, Look};
use halfline::explain::explain;
use halfline::frame::{Aov, Frame};
use halfline::scene::{ImagePlane, Light, LightSource, Lighting, Material, Scene, Sky, Spheres};
use halfline::settings::{Accuracy, Backend, Settings};
use halfline::window::Window;

/// Colour of every ray that hits nothing.
const BACKGROUND: [f32; 3] = [0.125, 0.25, 0.5];

const MIRROR: Material = phong(0.25, 0.5, 0.0);
const CLEAR: Material = phong(0.0, 0.0, 1.0);

/// An index of refraction of 1 and no highlights.
const fn phong(diffuse: f32, specular: f32, transmission: f32) -> Material {
    Material::Phong { diffuse, specular, shine: 0.0, transmission, index: 1.0 }
}

/// One pixel of no size that looks along -z.
const STRAIGHT: Camera = Camera::CANONICAL;

fn scene(camera: Camera, [width, height]: [u32; 2], spheres: Spheres) -> Scene {
    let image = ImagePlane { width, height, background: BACKGROUND };
    Scene { camera, image, spheres, lighting: Lighting::default() }
}

fn looking(eye: [f64; 3], at: [f64; 3], degrees: f64) -> Camera {
    let lens = Lens::Vfov { degrees, distance: 1.0 };
    Camera { eye: eye.into(), look: Look::At(at.into()), up: DVec3::new(0.1, 1.0, 0.2), lens }
}

fn spheres(list: &[([f64; 3], f64, [f32; 3], Material)]) -> Spheres {
    let mut spheres = Spheres::default();
    for (center, radius, color, material) in list {
        spheres.push(*center, *radius, Some(*color));
        spheres.set_last_material(*material);
    }
    spheres
}

fn frame(scene: &Scene, aovs: &[Aov], change: impl FnOnce(&mut Settings)) -> Frame {
    let mut settings = Settings { accuracy: Accuracy::Certified, aovs: aovs.to_vec(), ..Settings::default() };
    change(&mut settings);
    cpu().render(scene, &settings).expect("a frame")
}

fn color(scene: &Scene) -> Vec<f32> {
    frame(scene, &[Aov::Color], |_| {}).f32(Aov::Color).expect("a requested buffer").to_vec()
}

fn certainty(scene: &Scene) -> Vec<u64> {
    frame(scene, &[Aov::Color, Aov::Certainty], |_| {}).bits(Aov::Certainty)
}

/// Whether colours are equal but for the rounding of the result to f32, 2^-24 of at most 1, and of less than a thousand
/// operations in f64.
fn close(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-6)
}

/// The viewing ray meets a sphere of `material` at (0, 0, -4) with the normal (1, 0, 1)/sqrt 2, so that a mirror reflects it
/// along x. There it meets a red sphere where the normal is (-0.6, -0.8, 0).
fn corner(material: Material) -> Scene {
    let list = [
        ([-1.0, 0.0, -5.0], 2f64.sqrt(), [1.0, 0.5, 0.25], material),
        ([4.0, 0.8, -4.0], 1.0, [1.0, 0.0, 0.0], Material::default()),
    ];
    scene(STRAIGHT, [1, 1], spheres(&list))
}

#[test]
fn a_mirror_shows_what_is_before_it() {
    // The light at the eye: the mirror's own colour, its diffuse share, and the cosine of 45 degrees. The mirror image: the
    // share of 0.5, and the cosine 0.6 at the red sphere.
    let own = 0.25 * 0.5f32.sqrt();
    let found = color(&corner(MIRROR));
    assert!(close(&found, &[own + 0.5 * 0.6, 0.5 * own, 0.25 * own]), "{found:?}");
    // Without the red sphere the mirror shows the background.
    let mut alone = corner(MIRROR);
    alone.spheres.centers.to_mut()[1] = [4.0, 10.0, -4.0];
    let found = color(&alone);
    let expected = [own + 0.5 * BACKGROUND[0], 0.5 * own + 0.5 * BACKGROUND[1], 0.25 * own + 0.5 * BACKGROUND[2]];
    assert!(close(&found, &expected), "{found:?}");
}

/// As viewing rays do, and as certainly.
#[test]
fn of_equal_spheres_a_mirror_shows_the_one_with_the_lower_index() {
    let (expected, mut twins) = (color(&corner(MIRROR)), corner(MIRROR));
    let (center, radius) = (twins.spheres.centers[1], twins.spheres.radii[1]);
    twins.spheres.push(center, radius, Some([0.0, 1.0, 0.0]));
    assert_eq!(color(&twins), expected);
    assert!(certainty(&twins)[0] <= 1);
}

#[test]
fn a_metal_tints_what_it_shows() {
    let mut metal = corner(Material::Metal { fuzz: 0.0 });
    metal.spheres.colors.as_mut().expect("colours").to_mut()[1] = [1.0, 1.0, 1.0];
    let found = color(&metal);
    assert!(close(&found, &[0.6, 0.5 * 0.6, 0.25 * 0.6]), "{found:?}");
    // A fuzzy one scatters it, and cannot reflect more than it gets.
    let fuzzy = color(&corner(Material::Metal { fuzz: 0.5 }));
    assert!(fuzzy[0] <= 1.0 && fuzzy[1] <= 0.5 * BACKGROUND[1] && !close(&fuzzy, &found), "{fuzzy:?}");
}

/// A mirror image over two mirrors takes two bounces: where only one is allowed, what the second mirror shows is missing.
#[test]
fn the_number_of_bounces_is_a_limit() {
    let mut scene = corner(phong(0.0, 0.5, 0.0));
    scene.spheres.set_last_material(phong(0.5, 0.5, 0.0));
    let bounces = |n: u32| {
        let lighting = Lighting { bounces: Some(n), ..Lighting::default() };
        color(&Scene { lighting, ..scene.clone() })
    };
    // The ray (1, 0, 0) is reflected at (-0.6, -0.8, 0) to (0.28, -0.96, 0), into the background.
    let once = 0.5 * 0.5 * 0.6;
    assert!(close(&bounces(1), &[once, 0.0, 0.0]), "{:?}", bounces(1));
    let twice = BACKGROUND.map(|x| 0.25 * x);
    assert!(close(&bounces(2), &[once + twice[0], twice[1], twice[2]]), "{:?}", bounces(2));
    assert_eq!(bounces(2), bounces(64));
}

/// Without bounces mirrors and glass reflect like any other sphere, also under a light.
#[test]
fn without_bounces_every_material_is_shaded() {
    for material in [Material::Metal { fuzz: 0.0 }, Material::Glass { index: 1.5 }, Material::default()] {
        let mut scene = scene(STRAIGHT, [1, 1], spheres(&[([0.0, 0.0, -3.0], 1.0, [1.0; 3], material)]));
        let lights = vec![Light::white(LightSource::Direction(DVec3::Z))];
        scene.lighting = Lighting { lights, shadows: true, bounces: Some(0), ..Lighting::default() };
        assert!(close(&color(&scene), &[1.0; 3]), "{material:?}");
    }
}

/// A light behind a surface has no highlight on it, whether or not it casts shadows.
#[test]
fn a_light_behind_a_surface_has_no_highlight() {
    let shiny = Material::Phong { diffuse: 0.0, specular: 1.0, shine: 4.0, transmission: 0.0, index: 1.0 };
    let list = [([0.0, 0.0, -3.0], 1.0, [0.0; 3], shiny)];
    let mut scene = scene(looking([0.0; 3], [0.0, 0.0, -1.0], 45.0), [21, 21], spheres(&list));
    scene.image.background = [0.0; 3];
    for (toward, faces_light) in [(DVec3::NEG_Z, false), (DVec3::Z, true)] {
        let lights = vec![Light::white(LightSource::Direction(toward))];
        scene.lighting = Lighting { lights, bounces: Some(0), ..Lighting::default() };
        assert_eq!(color(&scene).iter().any(|x| *x > 0.0), faces_light, "{toward}");
    }
}

#[test]
fn clear_spheres_of_index_1_change_nothing() {
    let mut covered =
        scene(looking([0.0; 3], [0.0, 0.0, -1.0], 40.0), [31, 21], cloud(3, 60, [0.0, 0.0, -6.0], 1.5, 0.2));
    covered.spheres.push([0.1, 0.2, -3.0], 0.8, Some([0.3, 0.3, 0.3]));
    covered.spheres.set_last_material(CLEAR);
    // Behind the eye, so that the same arithmetic shades the rest.
    let mut bare = covered.clone();
    bare.spheres.centers.to_mut()[60] = [0.1, 0.2, 3.0];
    let expected = color(&bare);
    let found = color(&covered);
    // The direction is computed again twice, and points on the outline of a sphere behind may fall on its other side: with
    // directions within 1e-15, no pixel of this picture.
    assert!(close(&found, &expected));
    let visible = frame(&covered, &[Aov::Id], |_| {});
    assert!(visible.ids().iter().filter(|id| **id == 60).count() > 50, "the sphere is in the picture");
    // Glass reflects nothing of a ray through its centre.
    let list = [
        ([0.0, 0.0, -3.0], 1.0, [0.3; 3], Material::Glass { index: 1.0 }),
        ([0.0, 0.6, -6.0], 1.0, [1.0, 0.5, 0.25], Material::default()),
    ];
    let found = color(&scene(STRAIGHT, [1, 1], spheres(&list)));
    assert!(close(&found, &[0.8, 0.4, 0.2]), "{found:?}");
}

/// Straight on, glass of index n reflects ((n - 1)/(n + 1))^2, here 0.04, at each side.
#[test]
fn glass_divides_light_by_fresnels_equations() {
    let list = [([0.0, 0.0, -3.0], 1.0, [0.3; 3], Material::Glass { index: 1.5 })];
    let glass = scene(STRAIGHT, [1, 1], spheres(&list));
    // All rays end in the same background, so the shares add up to 1 but for what is left inside: after 6 bounces
    // 0.04^5, and before that the rays of a weight below 1/512, which are not followed: 0.04^2 0.96 = 0.0015.
    let found = color(&glass);
    assert!(found.iter().zip(BACKGROUND).all(|(x, all)| *x <= all && *x >= 0.998 * all), "{found:?}");
    let lighting = Lighting { bounces: Some(1), ..Lighting::default() };
    let found = color(&Scene { lighting, ..glass });
    assert!(close(&found, &BACKGROUND.map(|x| 0.04 * x)), "only the mirror image is left: {found:?}");
}

#[test]
fn without_bounces_mirrors_and_glass_are_as_without_materials() {
    for material in [MIRROR, Material::Metal { fuzz: 0.25 }, Material::Glass { index: 1.5 }] {
        let mut with = corner(material);
        [with.image.width, with.image.height] = [19, 13];
        with.lighting.bounces = Some(0);
        let mut without = with.clone();
        without.spheres.materials = None;
        assert_eq!(color(&with), color(&without), "{material:?}");
        with.lighting.bounces = None;
        assert_ne!(color(&with), color(&without), "{material:?}");
    }
}

#[test]
fn the_certainty_of_a_picture_is_that_of_its_rays() {
    assert!(certainty(&corner(MIRROR))[0] <= 1, "the first reflection is proved");
    for material in [Material::Metal { fuzz: 0.5 }, Material::Glass { index: 1.5 }] {
        assert_eq!(certainty(&corner(material)), [255], "{material:?}");
    }
}

/// Random spheres with a light of each kind and a sky.
fn cloud_with_lights() -> Scene {
    let mut scene = scene(looking([3.0, 2.0, 4.0], [0.0; 3], 32.0), [37, 29], cloud(4, 150, [0.0; 3], 1.0, 0.05));
    scene.spheres.push([1.8, 0.3, 0.4], 0.3, None);
    let lights = [
        LightSource::Direction(DVec3::new(1.0, 2.0, 0.5)),
        LightSource::Point(DVec3::new(0.2, 1.8, -0.3)),
        LightSource::Ball { center: DVec3::new(-2.0, 1.0, 2.0), radius: 0.5 },
        LightSource::Sphere(150),
    ];
    let lights = lights.map(|source| Light { intensity: 0.25, ..Light::white(source) }).to_vec();
    scene.lighting =
        Lighting { lights, shadows: true, sky: Some(Sky { rays: 8, reach: 1.5, ..Sky::default() }), bounces: None };
    scene
}

#[test]
fn certified_shadows_and_skies_are_the_exact_ones() {
    let [certified, exact] = [Accuracy::Certified, Accuracy::Exact].map(|accuracy| {
        frame(&cloud_with_lights(), &[Aov::Shadow, Aov::Occlusion], |settings| settings.accuracy = accuracy)
    });
    assert_eq!((certified.report.accuracy, exact.report.accuracy), ("certified", "exact"));
    for aov in [Aov::Shadow, Aov::Occlusion] {
        assert!(certified.bits(aov) == exact.bits(aov), "{aov}");
    }
    let (ids, shares) = (exact.ids(), exact.f32(Aov::Shadow).expect("a requested buffer"));
    let between = |x: &f32| *x > 0.0 && *x < 1.0;
    for (light, soft) in [(0, false), (1, false), (2, true), (3, true)] {
        let of_light = || shares.iter().skip(light).step_by(4);
        assert_eq!(of_light().any(between), soft, "light {light}");
        let [open, hidden] = [0.0, 1.0].map(|x| of_light().zip(ids).filter(|(s, id)| **id >= 0 && **s == x).count());
        assert!(open > 20 && hidden > 20, "light {light}: {open} lit, {hidden} hidden");
    }
}

/// Equal spheres count as one: a sphere that is equal to the light's hides nothing of it, whether the light is a sphere of the scene
/// or stands by itself, and shines as the light's does.
#[test]
fn a_sphere_equal_to_the_light_is_the_light() {
    let sun = ([0.0, 4.0, -3.0], 1.0, [1.0; 3], Material::default());
    let ground = ([0.0, -100.0, -5.0], 99.0, [1.0; 3], Material::default());
    let camera = looking([0.0, 1.0, 6.0], [0.0, 1.0, -4.0], 50.0);
    let sight = |list: &[_], source: LightSource| {
        let mut scene = scene(camera, [40, 40], spheres(list));
        scene.lighting = Lighting { lights: vec![Light::white(source)], shadows: true, ..Lighting::default() };
        let frame = frame(&scene, &[Aov::Color, Aov::Shadow, Aov::Certainty], |_| {});
        let certain = frame.bits(Aov::Certainty).iter().all(|x| *x <= 1);
        assert!(certain, "{source:?}");
        [Aov::Color, Aov::Shadow].map(|aov| frame.f32(aov).expect("a requested buffer").to_vec())
    };
    let alone = sight(&[ground, sun], LightSource::Sphere(1));
    assert!(
        alone[1].iter().all(|share| *share == 0.0 || *share == 1.0),
        "one sphere has the shadows of its own back alone"
    );
    // The sphere that is hit has the lower index, the light's is the other.
    assert!(sight(&[ground, sun, sun], LightSource::Sphere(2)) == alone, "a twin hides the light");
    assert!(sight(&[ground, sun, sun], LightSource::Sphere(1)) == alone, "a twin hides the light");
    let ball = LightSource::Ball { center: sun.0.into(), radius: sun.1 };
    assert!(sight(&[ground, sun], ball)[1] == alone[1], "the sphere in the place of a ball hides it");
}

/// With mirrors, glass and a fuzzy metal, which scatters at random.
#[test]
fn parts_and_threads_give_the_bits_of_the_frame() {
    let mut scene = cloud_with_lights();
    for (center, material) in [
        ([1.5, 0.0, 1.0], MIRROR),
        ([0.0, 1.2, 1.0], Material::Glass { index: 1.5 }),
        ([0.3, -0.6, 1.3], Material::Metal { fuzz: 0.3 }),
    ] {
        scene.spheres.push(center, 0.4, Some([0.9, 0.8, 0.7]));
        scene.spheres.set_last_material(material);
    }
    let aovs = [Aov::Color, Aov::Shadow, Aov::Occlusion];
    let [width, height] = [scene.image.width, scene.image.height];
    let tile = |number| Window::tile(number, 6, width, height).expect("a tile");
    let windows: Vec<_> = [Window { x0: 5, y0: 3, x1: 6, y1: 4 }, Window { x0: 9, y0: 8, x1: 30, y1: 17 }]
        .into_iter()
        .chain((1..=6).map(tile))
        .collect();
    for samples in [1, 4] {
        let whole = frame(&scene, &aovs, |settings| settings.samples = samples);
        let same = |part: &Frame, window: Window, what: &str| {
            for aov in aovs {
                assert!(part.bits(aov) == whole.bits_in(window, aov), "{aov}, {samples} samples, {what}");
            }
        };
        for window in &windows {
            let part = frame(&scene, &aovs, |settings| {
                (settings.samples, settings.window) = (samples, Some(*window));
            });
            same(&part, *window, &format!("crop {window}"));
        }
        for threads in [1, 2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let again = pool.install(|| frame(&scene, &aovs, |settings| settings.samples = samples));
            same(&again, Window::full(width, height), &format!("{threads} threads"));
        }
    }
}

/// A furnace: where all light comes from a white sky, a lone white sphere reflects as much from every direction, and cannot be
/// seen before a white background. Exactly so: none of its rays is hidden, and the quotient of equal sums is 1.
#[test]
fn a_lone_white_sphere_under_a_white_sky_is_white() {
    for samples in [1, 4] {
        let list = [([0.0, 0.0, -3.0], 1.0, [1.0; 3], Material::default())];
        let mut furnace = scene(looking([0.0; 3], [0.0, 0.0, -1.0], 45.0), [23, 23], spheres(&list));
        furnace.image.background = [1.0; 3];
        furnace.lighting.sky = Some(Sky::default());
        let found = frame(&furnace, &[Aov::Color, Aov::Occlusion], |settings| settings.samples = samples);
        assert!(found.report.hits > 200);
        for aov in [Aov::Color, Aov::Occlusion] {
            assert!(found.f32(aov).expect("a requested buffer").iter().all(|x| *x == 1.0), "{aov}, {samples} samples");
        }
    }
}

/// The root mean square of the difference to 65,536 rays, whose own error is at most 0.55 65536^-3/4 = 0.00013, is below the
/// standard error that src/view/directions.rs states for 16 rays: 0.55 16^-3/4 = 0.069, the largest of the caps, as each
/// sphere that touches another hides a cap of the sky.
#[test]
fn sixteen_rays_to_the_sky_have_the_stated_error() {
    let touching =
        [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 3f64.sqrt(), 0.0], [1.0, 1.0 / 3f64.sqrt(), (8f64 / 3.0).sqrt()]];
    let list = touching.map(|center| (center, 1.0, [1.0; 3], Material::default()));
    let camera = looking([4.0, 5.0, 9.0], [1.0, 0.6, 0.5], 20.0);
    let sky = |rays: u32, seed: u32| {
        let mut scene = scene(camera, [11, 9], spheres(&list));
        scene.lighting.sky = Some(Sky { rays, ..Sky::default() });
        let found = frame(&scene, &[Aov::Occlusion], |settings| settings.seed = seed);
        let shares = found.f32(Aov::Occlusion).expect("a requested buffer").to_vec();
        shares.into_iter().zip(found.ids().to_vec()).filter(|(_, id)| *id >= 0).map(|(x, _)| f64::from(x)).collect()
    };
    let reference: Vec<f64> = sky(65536, 0);
    assert!(reference.len() > 40 && reference.iter().filter(|x| **x < 0.9).count() > 12, "spheres hide the sky");
    let seeds = 8;
    let (mut squares, mut sum) = (0.0, 0.0);
    for seed in 0..seeds {
        let found: Vec<f64> = sky(16, seed);
        let differences = || found.iter().zip(&reference).map(|(a, b)| a - b);
        squares += differences().map(|x| x * x).sum::<f64>();
        sum += differences().sum::<f64>();
    }
    let count = f64::from(seeds) * reference.len() as f64;
    let (error, bias) = ((squares / count).sqrt(), sum / count);
    println!("standard error {error:.4}, mean {bias:.5}, {count} points");
    assert!(error < 0.069, "{error}");
    // The stated bias, 0.003, and three standard errors of this mean.
    assert!(bias.abs() < 0.003 + 3.0 * error / count.sqrt(), "{bias}");
}

/// A sphere whose top is at the origin, seen from the right, under a ball light straight above it. A large sphere on the left
/// reaches up to x = `edge` at half the height of the light.
fn under_a_light(edge: f64) -> Scene {
    let list = [
        ([0.0, -1.0, 0.0], 1.0, [1.0; 3], Material::default()),
        ([edge - 1000.0, 5.0, 0.0], 1000.0, [1.0; 3], Material::default()),
    ];
    let camera = looking([3.0, 1.0, 0.0], [0.0; 3], 1e-3);
    let mut scene = scene(camera, [1, 1], spheres(&list));
    let source = LightSource::Ball { center: DVec3::new(0.0, 10.0, 0.0), radius: 0.5 };
    scene.lighting = Lighting { lights: vec![Light::white(source)], shadows: true, ..Lighting::default() };
    scene
}

fn shadow(scene: &Scene, seed: u32) -> f64 {
    let found = frame(scene, &[Aov::Shadow, Aov::Color], |settings| settings.seed = seed);
    assert_eq!(found.ids(), [0], "the sphere below is seen");
    let (share, color) = (found.f32(Aov::Shadow).expect("requested")[0], found.f32(Aov::Color).expect("requested")[0]);
    // What is not hidden is reflected, with cosines between 1 and the cosine of the light's angular radius of 0.05.
    assert!(color <= 1.0 - share + 1e-6 && color >= (1.0 - share) * (1.0 - 0.00126), "{color} of {}", 1.0 - share);
    f64::from(share)
}

/// The line from the origin to the light's centre touches the large sphere, whose edge is straight there but for the ratio of
/// the radii: it hides half of the light. The share of 64 points on one side of a chord has a standard error of at most
/// 0.5 64^-3/4 = 0.022.
#[test]
fn half_of_a_light_is_hidden() {
    let error = 0.5 * 64f64.powf(-0.75);
    let half = under_a_light(0.0);
    let shares: Vec<f64> = (0..32).map(|seed| shadow(&half, seed)).collect();
    assert!(shares.iter().all(|share| (share - 0.5).abs() < 3.0 * error), "{shares:?}");
    let settings = Settings { backend: Backend::Cpu, aovs: vec![Aov::Color, Aov::Shadow], ..Settings::default() };
    let planned = explain(&half, &settings).expect("a plan").rays_per_pixel;
    assert_eq!((planned.lights, planned.onward), (80, 0), "64 points, and 16 on the rim");
    assert!(shares.iter().all(|share| (64.0 * share).fract() == 0.0), "shares of 64 points");
    let mean = shares.iter().sum::<f64>() / 32.0;
    assert!((mean - 0.5).abs() < 3.0 * error / 32f64.sqrt(), "{mean}");
}

/// The lines from the origin to the light reach 0.5 to both sides at its height, and 0.25 at half of it.
#[test]
fn a_light_is_hidden_as_a_whole_or_not_at_all() {
    for seed in 0..8 {
        assert_eq!(shadow(&under_a_light(-0.6), seed), 0.0);
    }
    // The umbra cannot come from the large sphere, which would hide the origin from the eye.
    let mut umbra = under_a_light(-0.6);
    umbra.spheres.push([0.0, 5.0, 0.0], 0.3, Some([1.0; 3]));
    for seed in 0..8 {
        assert_eq!(shadow(&umbra, seed), 1.0);
    }
}
