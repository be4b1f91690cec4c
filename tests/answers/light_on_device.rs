//! Rays that leave from hits on an adapter, toward the sky and toward lights without a size, give the bits of the CPU path, whose rays
//! src/cpu/light/tests.rs compares with exact arithmetic: shadows, occlusion and pictures, in every family of scenes, for
//! windows, samples, reaches, skies with colours, and parallel rays. Tolerance: none on adapters known to be strict.

use super::splat::Both;
use super::{crop, extremes, off_center, ortho};
use crate::amount::{amount, everything};
use crate::rng::Rng;
use crate::weekend::weekend;
use halfline::frame::Aov;
use halfline::scene::camera::{Aperture, Camera, Lens, Look};
use halfline::scene::{ImagePlane, Light, LightSource, Lighting, Material, Scene, Sky, SkyColors, Spheres};
use halfline::settings::Settings;
use halfline::window::Window;
use halfline_measure::suite::extremes::FAMILIES;

fn settings() -> Settings {
    let aovs = [Aov::Color, Aov::Shadow, Aov::Occlusion, Aov::Certainty];
    Settings { aovs: aovs.to_vec(), ..Settings::default() }
}

/// Far lights from above and along an axis, and a sky of so many rays.
fn with_lights(scene: &Scene, rays: u32) -> Scene {
    let mut scene = scene.clone();
    let toward = [[0.3, 1.0, 0.2], [1.0, 0.0, 0.0]].map(|d| LightSource::Direction(d.into()));
    // A light above the eye, too.
    let near_eye = LightSource::Point(
        scene.camera.eye + glam::DVec3::new(0.2, 0.5, 0.1) * scene.spheres.radii.first().copied().unwrap_or(1.0),
    );
    scene.lighting.lights = toward.into_iter().chain([near_eye]).map(Light::white).collect();
    scene.lighting.shadows = true;
    scene.lighting.sky = Some(Sky { rays, ..Sky::default() });
    scene
}

/// The frames that were compared, and the shares of their hits that the adapter decided.
struct Shares {
    both: Both,
    frames: u32,
    sum: f64,
    least: f64,
}

impl Shares {
    fn new() -> Option<Self> {
        Some(Self { both: Both::new()?, frames: 0, sum: 0.0, least: 1.0 })
    }

    fn compare(&mut self, what: &str, scene: &Scene, settings: &Settings) {
        let report = self.both.compare(what, scene, settings).report;
        if let Some(share) = report.light_on_device {
            (self.frames, self.sum, self.least) = (self.frames + 1, self.sum + share, self.least.min(share));
        }
    }

    /// The mean share of hits in those frames whose rays the adapter traced, and the number of frames whose rays it did not trace.
    fn done(self, most_left: u32) -> (f64, u32) {
        let (mean, others) = (self.sum / f64::from(self.frames), self.both.compared - self.frames);
        println!(
            "{} frames: the adapter decided {mean:.4} of the hits, at least {:.4}; {others} others",
            self.frames, self.least
        );
        self.both.done(most_left);
        (mean, others)
    }
}

#[test]
fn every_family_has_the_light_of_the_cpu_path() {
    let Some(mut shares) = Shares::new() else { return };
    for family in FAMILIES {
        for (n, scene) in extremes::scenes(family, 0x5eed_0007).iter_mut().enumerate() {
            // Most rays of some families need hundreds of digits.
            if !everything() {
                extremes::halve(scene);
            }
            shares.compare(&format!("{} {n}", family.name), &with_lights(scene, 5), &settings());
        }
    }
    let most = shares.both.compared / 2;
    let (mean, others) = shares.done(most);
    assert!(mean > 0.5 && others <= most, "{mean} {others}");
}

#[test]
fn windows_samples_and_lenses_have_the_light_of_the_cpu_path() {
    let Some(mut shares) = Shares::new() else { return };
    for (what, scene) in crop::scenes() {
        let scene = with_lights(&scene, 40);
        for window in crop::windows() {
            shares.compare(&format!("{what}, {window:?}"), &scene, &Settings { window: Some(window), ..settings() });
        }
        for sky in [Sky { rays: 7, ..Sky::default() }, Sky::AT_CENTERS] {
            let mut scene = scene.clone();
            scene.lighting.sky = Some(sky);
            shares.compare(&format!("{what}, {sky:?}"), &scene, &Settings { samples: 4, seed: 3, ..settings() });
        }
    }
    for (what, scene) in ortho::scenes() {
        shares.compare(what, &with_lights(&scene, 16), &settings());
    }
    for point in off_center::POINTS {
        let scene = off_center::scene(off_center::intrinsics(point), off_center::SIZE);
        shares.compare(&format!("principal point {point:?}"), &with_lights(&scene, 16), &settings());
    }
    let (mean, others) = shares.done(20);
    assert!(mean > 0.5 && others <= 20, "{mean} {others}");
}

#[test]
fn ground_reaches_colours_and_other_lights_are_those_of_the_cpu_path() {
    let Some(mut shares) = Shares::new() else { return };
    let mut scene = weekend();
    (scene.image.width, scene.image.height) = (150, 100);
    let scene = with_lights(&scene, 16);
    shares.compare("weekend", &scene, &settings());
    for reach in [1e-3, 0.7, 1e9] {
        let mut scene = scene.clone();
        scene.lighting.sky = Some(Sky { rays: 31, reach, ..Sky::default() });
        shares.compare(&format!("reach {reach}"), &scene, &settings());
    }
    let colors = SkyColors { zenith: [0.2, 0.4, 0.9], horizon: [0.9, 0.8, 0.6], is_shown: true };
    let mut colored = scene.clone();
    colored.lighting.sky = Some(Sky { colors: Some(colors), ..Sky::default() });
    shares.compare("a sky with colours", &colored, &settings());
    let mut near = scene.clone();
    for place in [[0.0, 3.0, 1.0], [4.0, 1e-3, 0.5], [-1e7, 2e7, 3e6], [0.0, 1.5, 0.0]] {
        near.lighting.lights.push(Light::white(LightSource::Point(place.into())));
        shares.compare(&format!("a light at {place:?} too"), &near, &settings());
        near.lighting.shadows = !near.lighting.shadows;
    }
    // The host traces the rays to lights where one has a size, and the adapter those to the sky.
    let ball = LightSource::Ball { center: [0.0, 3.0, 1.0].into(), radius: 0.5 };
    near.lighting.lights.push(Light::white(ball));
    shares.compare("a ball too", &near, &settings());
    let mut apart = scene.clone();
    apart.lighting.shadows = false;
    apart.lighting.sky = None;
    shares.compare("only the buffers of light", &apart, &settings());
    // The sky of the picture belongs to another view of the same pixels, whose unit is another here.
    let mut close = scene.clone();
    close.camera.eye = glam::DVec3::new(0.0, 0.5, 3.0);
    close.lighting.sky = Some(Sky::AT_CENTERS);
    shares.compare("weekend from close by", &close, &Settings { samples: 4, ..settings() });
    // A planet, whose hits leave by the way from the eye.
    let mut planet = scene.clone();
    // Another light grazes its ground.
    planet.lighting.lights.truncate(1);
    let radius = 6.4e6;
    planet.spheres = Spheres::default();
    planet.spheres.push([0.0, -radius, 0.0], radius, None);
    for n in 0..40 {
        let [x, z] = [f64::from(n % 8) - 3.5, f64::from(n / 8) - 2.0].map(|x| 3.0 * x);
        planet.spheres.push([x, 0.4, z], 0.3 + 0.01 * f64::from(n), None);
    }
    planet.camera.eye = glam::DVec3::new(0.5, 1.7, 14.0);
    planet.camera.look = Look::At(glam::DVec3::new(0.0, 0.5, 0.0));
    for sky in [Sky::default(), Sky::AT_CENTERS] {
        planet.lighting.sky = Some(sky);
        shares.compare(&format!("a planet, {sky:?}"), &planet, &Settings { samples: 4, ..settings() });
    }
    // No kernel runs for so wide a lens, and the hits before are not its own.
    let mut wide = planet.clone();
    wide.camera.lens = Lens::Vfov { degrees: 179.999_9, distance: 1.0 };
    shares.compare("before a wide lens", &planet, &settings());
    let host = shares.frames;
    shares.compare("a wide lens", &wide, &settings());
    assert_eq!(shares.frames, host, "the host traced the rays of a wide lens");
    for turn in 0..2 {
        shares.compare("the same again", &scene, &Settings { seed: turn, ..settings() });
    }
    let (mean, others) = shares.done(1);
    assert!(mean > 0.9 && others == 1, "{mean} {others}");
}

/// A few spheres before the eye, and others around that it does not see: some translucent, some mirrors, glass or plastic, under drawn
/// lights and a drawn sky.
fn drawn_scene(rng: &mut Rng) -> Scene {
    let mut spheres = Spheres::default();
    let count = 2 + rng.below(24);
    let (ghosts, kinds) = (rng.unit() < 0.75, rng.unit() < 0.3);
    for n in 0..count {
        let [x, y, z] = rng.cube();
        let is_hidden = n % 3 == 2;
        let place = if is_hidden { [4.0 * x, 3.0 + y, 2.0 * z] } else { [x, y, z] };
        spheres.push(place, 0.15 + 0.5 * rng.unit(), Some(rng.cube().map(|c| 0.5 + 0.4 * c as f32)));
        if ghosts {
            let opacity = if rng.unit() < 0.5 { 1.0 } else { 0.1 + 0.8 * rng.unit() as f32 };
            spheres.set_opacity_from(n, opacity);
        }
        if kinds {
            let clear = Material::Glass { index: 1.5 };
            let plastic = Material::Plastic { gloss: 0.8, shine: 9.0 };
            spheres
                .set_last_material([Material::default(), Material::Metal { fuzz: 0.1 }, clear, plastic][rng.below(4)]);
        }
    }
    let lens = match rng.below(3) {
        0 => Lens::Orthographic { height: 2.6 },
        _ => Lens::Vfov { degrees: 40.0, distance: 1.0 },
    };
    let camera =
        Camera { eye: glam::DVec3::new(0.6, 0.9, 4.0), look: Look::At(glam::DVec3::ZERO), up: glam::DVec3::Y, lens };
    let image = ImagePlane { width: 16 + rng.below(9) as u32, height: 12, background: [0.3, 0.5, 0.7] };
    let mut lights = Vec::new();
    for _ in 0..rng.below(4) {
        let place = glam::DVec3::from(rng.cube()) + glam::DVec3::new(0.0, 2.0, 1.0);
        lights.push(Light::white(match rng.below(5) {
            0 | 1 => LightSource::Direction(place),
            2 => LightSource::Point(place),
            3 => LightSource::Ball { center: place, radius: 0.3 },
            _ => LightSource::Sphere(rng.below(count) as u32),
        }));
    }
    let colors = SkyColors { zenith: [0.2, 0.4, 0.9], horizon: [0.9, 0.8, 0.6], is_shown: rng.below(2) == 0 };
    let sky = Sky {
        rays: 1 + rng.below(9) as u32,
        reach: [f64::INFINITY, 0.4][rng.below(2)],
        at_centers: rng.below(3) > 0,
        colors: (rng.below(3) == 0).then_some(colors),
        share: [1.0, Sky::SHARE_WITH_LIGHTS][rng.below(2)],
    };
    let lighting = Lighting {
        lights,
        sky: (rng.below(4) > 0).then_some(sky),
        shadows: rng.below(2) == 0,
        bounces: (rng.below(3) == 0).then(|| rng.below(4) as u32),
    };
    Scene { camera, image, spheres, lighting }
}

/// Drawn settings of a picture and its buffers.
fn drawn_settings(rng: &mut Rng, scene: &Scene) -> Settings {
    let mut aovs = vec![Aov::Color, Aov::Alpha, Aov::Id, Aov::Certainty];
    aovs.extend((!scene.lighting.lights.is_empty() && rng.below(3) == 0).then_some(Aov::Shadow));
    aovs.extend((rng.below(3) == 0).then_some(Aov::Occlusion));
    let is_parallel = scene.camera.lens.is_orthographic();
    let has_size = !is_parallel && rng.below(5) == 0;
    Settings {
        aovs,
        samples: if has_size { 4 } else { [1, 4, 9][rng.below(3)] },
        seed: rng.below(3) as u32,
        layers: rng.below(4) as u32,
        opacity_shadows: rng.below(3) > 0,
        silhouette: rng.below(2) == 0,
        depth_cue: rng.below(3) == 0,
        aperture: has_size.then_some(Aperture { diameter: 0.2, focus: Some(4.0) }),
        window: (rng.below(4) == 0).then_some(Window { x0: 3, y0: 2, x1: 15, y1: 11 }),
        ..Settings::default()
    }
}

/// An adapter answers for the hits that are shaded, whatever the options of light are: also where a picture has hits of opaque spheres
/// and of several layers before them.
#[test]
fn drawn_options_of_light_are_those_of_the_cpu_path() {
    let Some(mut shares) = Shares::new() else { return };
    let mut rng = Rng::new(0x5eed_0103);
    for n in 0..amount("scenes with drawn options of light", [20, 40, 600]) {
        let scene = drawn_scene(&mut rng);
        let settings = drawn_settings(&mut rng, &scene);
        shares.compare(&format!("scene {n}: {settings:?}, {:?}", scene.lighting), &scene, &settings);
    }
    let most = shares.both.compared;
    let (_, others) = shares.done(most);
    assert!(others < most / 2, "{others}");
}
