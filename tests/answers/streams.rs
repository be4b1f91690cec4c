//! The promise of streams: rays of one direction that go down the tree together have the answers of rays one by one.
//!
//! Gold standard: crops of so few pixels that their rays are traced one by one; what these answer is held against exact arithmetic by the tests
//! of light. Tolerance: none, in no buffer.

use crate::adapter::cpu;
use crate::bits::Bits;
use crate::cloud::cloud;
use crate::oblique::{self, vfov};
use crate::rng::Rng;
use halfline::camera::{Curve, Lens};
use halfline::frame::Aov;
use halfline::scene::{Light, LightSource, Lighting, Scene, Sky, SkyColors, Spheres};
use halfline::settings::Settings;
use halfline::window::Window;

/// So many pixels that streams are worth it, and a crop of too few.
const SIZE: [u32; 2] = [256, 160];
const CROP: u32 = 22;

fn crowd(eye: [f64; 3], lens: Lens) -> Scene {
    let mut spheres = cloud(5, 400, [0.0; 3], 1.2, 0.08);
    let mut random = Rng::new(2);
    for _ in 0..400 {
        let center = [0; 3].map(|_| 2.4 * random.unit() - 1.2);
        spheres.push(center, 10f64.powf(-6.0 * random.unit()) * 0.1, None);
    }
    for n in 0..40 {
        spheres.push(spheres.centers[n], spheres.radii[n], None);
    }
    Scene { lighting: lighting(), ..oblique::scene(SIZE, eye, [0.0; 3], lens, spheres) }
}

/// A sky with colours, whose rays leave the centres of pixels, and two suns with shadows.
fn lighting() -> Lighting {
    let sun = |direction: [f64; 3]| Light::white(LightSource::Direction(direction.into()));
    let colors = Some(SkyColors { zenith: [0.3, 0.5, 1.0], horizon: [1.0, 0.9, 0.8], is_shown: true });
    let sky = Some(Sky { colors, ..Sky::AT_CENTERS });
    Lighting {
        lights: vec![sun([1e-9, 2e-9, 0.5e-9]), sun([-3.0, 1.0, 2.0])],
        shadows: true,
        sky,
        ..Lighting::default()
    }
}

fn scenes() -> Vec<(&'static str, Scene)> {
    let [cx, cy] = SIZE.map(|side| f64::from(side) / 2.0);
    let fisheye = Lens::Curved { curve: Curve::Fisheye { k: [0.0; 4] }, fx: 60.0, fy: 60.0, cx, cy };
    let white = |scene: Scene| Scene { lighting: Lighting { sky: Some(Sky::AT_CENTERS), ..lighting() }, ..scene };
    let mut through = crowd([1.0, 2.0, 4.5], vfov(32.0));
    let opacity = |n: usize| if n.is_multiple_of(3) { 0.4 } else { 1.0 };
    through.spheres.opacities = Some((0..through.spheres.len()).map(opacity).collect());
    // Opaque spheres in translucent ones: what a picture shows behind these lies inside of them.
    let mut shells = crowd([1.0, 2.0, 4.5], vfov(32.0));
    for n in 0..400 {
        shells.spheres.push(shells.spheres.centers[n], 1.5 * shells.spheres.radii[n], None);
    }
    let opacity = |n: usize| if n + 400 < shells.spheres.len() { 1.0 } else { 0.4 };
    shells.spheres.opacities = Some((0..shells.spheres.len()).map(opacity).collect());
    let mut shell = crowd([0.1, 0.2, 0.3], vfov(80.0));
    shell.spheres.push([0.0; 3], 5.0, None);
    let mut two = Spheres::default();
    two.push([0.0, -1000.0, 0.0], 1000.0, None);
    two.push([0.0, 0.5, 0.0], 0.5, None);
    let ground =
        Scene { lighting: lighting(), ..oblique::scene(SIZE, [1.0, 0.7, 3.0], [0.0, 0.5, 0.0], vfov(40.0), two) };
    vec![
        ("perspective", white(crowd([1.0, 2.0, 4.5], vfov(32.0)))),
        ("parallel", crowd([1.0, 2.0, 4.5], Lens::Orthographic { height: 2.5 })),
        ("parallel, from among the spheres", crowd([0.1, 0.2, 0.3], Lens::Orthographic { height: 2.5 })),
        ("fisheye", crowd([0.1, 0.2, 0.3], fisheye)),
        ("far away", white(crowd([2e3, -1e3, 3e3], vfov(0.04)))),
        ("in a sphere", shell),
        ("a large ground", ground),
        ("through translucent spheres", through),
        ("translucent spheres that cast shadows", shells),
    ]
}

#[test]
fn streams_have_the_answers_of_rays_one_by_one() {
    let mut renderer = cpu();
    let aovs = vec![Aov::Color, Aov::Shadow, Aov::Certainty];
    for (name, scene) in scenes() {
        let opacity_shadows = name.contains("cast shadows");
        let settings = Settings { aovs: aovs.clone(), layers: 2, opacity_shadows, ..Settings::default() };
        let full = renderer.render(&scene, &settings).expect("a frame");
        let hits = full.report.hits;
        assert!(hits > 5000, "{name}: {hits} hits");
        for (x0, y0) in [(0, 0), (100, 60), (131, 83), (150, 99), (61, 77), (SIZE[0] - CROP, SIZE[1] - CROP)] {
            let window = Window { x0, y0, x1: x0 + CROP, y1: y0 + CROP };
            let crop = renderer.render(&scene, &Settings { window: Some(window), ..settings.clone() }).expect("a crop");
            for aov in &aovs {
                assert!(crop.bits(*aov) == full.bits_in(window, *aov), "{name}, {}, crop {window}", aov.name());
            }
        }
    }
}

/// Directions of turns at random, which many pixels share in a large image.
#[test]
fn streams_of_the_buffer_occlusion_have_the_answers_of_rays_one_by_one() {
    let (mut renderer, mut scene) = (cpu(), crowd([1.0, 2.0, 4.5], vfov(32.0)));
    [scene.image.width, scene.image.height] = [512, 272];
    scene.lighting = Lighting::default();
    let aovs = vec![Aov::Occlusion, Aov::Certainty];
    let settings = Settings { aovs: aovs.clone(), sky: Sky { rays: 64, ..Sky::default() }, ..Settings::default() };
    let full = renderer.render(&scene, &settings).expect("a frame");
    for (x0, y0) in [(200, 100), (271, 133), (150, 99)] {
        let window = Window { x0, y0, x1: x0 + CROP, y1: y0 + CROP };
        let crop = renderer.render(&scene, &Settings { window: Some(window), ..settings.clone() }).expect("a crop");
        for aov in &aovs {
            assert!(crop.bits(*aov) == full.bits_in(window, *aov), "{}, crop {window}", aov.name());
        }
    }
}
