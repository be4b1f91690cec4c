//! Frames whose spheres an adapter holds (`search splat`) have the bits of the CPU path, which the other files compare with
//! exact arithmetic: every buffer, in every family of scenes, for windows, samples, parallel rays and off-centre lenses.
//! Tolerance: none on adapters known to be strict; on others ids and masks.

use super::{crop, extremes, off_center, ortho};
use crate::adapter::{cpu, gpu_or_skip, is_strict};
use crate::amount::amount;
use crate::bits::differing;
use crate::cloud::cloud;
use crate::rng::Rng;
use crate::weekend::weekend;
use glam::DVec3;
use halfline::Sky;
use halfline::camera::{Camera, Lens, Look};
use halfline::frame::{Aov, Frame};
use halfline::intersect::Method;
use halfline::render::Renderer;
use halfline::scene::{CutPlane, ImagePlane, Scene, Spheres};
use halfline::settings::{Accuracy, Settings};
use halfline::window::Window;
use halfline_measure::suite::extremes::FAMILIES;

/// The CPU path and the adapter, and how many frames the adapter has searched itself.
pub(super) struct Both {
    cpu: Renderer,
    gpu: Renderer,
    pub(super) compared: u32,
    left: u32,
}

impl Both {
    pub(super) fn new() -> Option<Self> {
        Some(Self { gpu: gpu_or_skip()?, cpu: cpu(), compared: 0, left: 0 })
    }

    /// Renders a scene on both; the adapter's frame.
    pub(super) fn compare(&mut self, what: &str, scene: &Scene, settings: &Settings) -> Frame {
        let settings = Settings { accuracy: Accuracy::Certified, ..settings.clone() };
        let host = self.cpu.render(scene, &settings).expect(what);
        let device = self.gpu.render(scene, &settings).expect(what);
        let differ: Vec<Aov> = match is_strict(&self.gpu) {
            true => differing(&device, &host),
            false => differing(&device, &host).into_iter().filter(|aov| [Aov::Id, Aov::Mask].contains(aov)).collect(),
        };
        assert!(differ.is_empty(), "{what}: {differ:?} differ");
        self.compared += 1;
        self.left += u32::from(device.report.search != "splat" || device.report.stages_ms.contains_key("stage"));
        device
    }

    /// Tells how many frames were compared; at most a share of them was left to the host.
    pub(super) fn done(self, most_left: u32) {
        println!("{} frames compared, {} of them left to the host", self.compared, self.left);
        assert!(self.compared > 0 && self.left <= most_left, "{} of {}", self.left, self.compared);
    }
}

fn all() -> Settings {
    let aovs = [Aov::Color, Aov::Distance, Aov::Depth, Aov::Normal, Aov::Position, Aov::Mask, Aov::Certainty];
    Settings { aovs: aovs.to_vec(), ..Settings::default() }
}

#[test]
fn every_family_has_the_bits_of_the_cpu_path() {
    let Some(mut both) = Both::new() else { return };
    for family in FAMILIES {
        for &seed in extremes::seeds(&[0x5eed_0003, 0x5eed_0005]) {
            for (n, scene) in extremes::scenes(family, seed).iter().enumerate() {
                let mut settings = all();
                settings.aovs.push(Aov::Bound);
                both.compare(&format!("{} {seed:x} {n}", family.name), scene, &settings);
            }
        }
    }
    let most = both.compared / 2;
    both.done(most);
}

/// Planes through the middle of a sphere and tangent to one, toward the eye, along the view and in any direction.
#[test]
fn every_family_of_cut_spheres_has_the_bits_of_the_cpu_path() {
    let Some(mut both) = Both::new() else { return };
    let (mut rng, mut cut) = (Rng::new(0xc07), 0);
    for family in FAMILIES {
        for &seed in extremes::seeds(&[0x5eed_0003]) {
            for (n, mut scene) in extremes::scenes(family, seed).into_iter().enumerate() {
                let Some(basis) = scene.camera.basis().ok().filter(|_| !scene.spheres.is_empty()) else { continue };
                let mut planes: Vec<CutPlane> = Vec::new();
                for axis in [basis.w, basis.u, DVec3::from_array(rng.cube())].into_iter().take(1 + n % 3) {
                    let ball = rng.below(scene.spheres.len());
                    let inset = [0.0, 0.5, 1.0][rng.below(3)] * scene.spheres.radii[ball];
                    let through = DVec3::from_array(scene.spheres.centers[ball]) + inset * axis;
                    planes.push(CutPlane { normal: axis.to_array(), distance: axis.dot(through) });
                }
                if scene.spheres.cut(&planes, None).is_err() || scene.spheres.cuts.is_none() {
                    continue;
                }
                cut += 1;
                both.compare(&format!("{} {seed:x} {n} {planes:?}", family.name), &scene, &all());
            }
        }
    }
    println!("{cut} scenes have cut spheres");
    assert!(cut > 20, "{cut}");
    let most = both.compared / 2;
    both.done(most);
}

#[test]
fn windows_samples_and_lenses_have_the_bits_of_the_cpu_path() {
    let Some(mut both) = Both::new() else { return };
    for (what, scene) in crop::scenes() {
        for window in crop::windows() {
            both.compare(&format!("{what}, {window:?}"), &scene, &Settings { window: Some(window), ..all() });
        }
        for samples in [4, 9] {
            both.compare(&format!("{what}, {samples} samples"), &scene, &Settings { samples, seed: 3, ..all() });
        }
        both.compare(&format!("{what}, lines"), &scene, &Settings { silhouette: true, ..all() });
    }
    for (what, scene) in ortho::scenes() {
        both.compare(what, &scene, &all());
    }
    for point in off_center::POINTS {
        let scene = off_center::scene(off_center::intrinsics(point), off_center::SIZE);
        both.compare(&format!("principal point {point:?}"), &scene, &all());
    }
    both.done(20);
}

/// A camera that moves around spheres which it holds, spheres that change between frames, and a look without changes.
#[test]
fn what_the_adapter_holds_is_what_is_rendered() {
    let Some(mut both) = Both::new() else { return };
    let mut scene = weekend();
    (scene.image.width, scene.image.height) = (150, 100);
    let mut shared = scene.clone();
    shared.spheres.share();
    for turn in 0..4 {
        let angle = f64::from(turn) * 0.3;
        for scene in [&mut scene, &mut shared] {
            let eye = scene.camera.eye;
            scene.camera.eye.x = eye.x * angle.cos() - eye.z * angle.sin();
            scene.camera.eye.z = eye.x * angle.sin() + eye.z * angle.cos();
            let frame = both.compare("turned", scene, &all());
            let again = both.compare("again", scene, &all());
            assert!(differing(&frame, &again).is_empty());
        }
        // The caller's own list in the same memory.
        scene.spheres.centers.to_mut()[3][1] += 0.25;
        both.compare("moved", &scene, &all());
    }
    // Colours that change while the positions cannot, and a frame of another scene by a method between two of this one.
    // Without lights, so that the kernels shade.
    shared.lighting = Default::default();
    let mut painted = shared.clone();
    let mut other = Scene { lighting: Default::default(), ..weekend() };
    let half = |color: &mut [f32; 3]| color.iter_mut().for_each(|channel| *channel *= 0.5);
    other.spheres.colors.iter_mut().flat_map(|colors| colors.to_mut().iter_mut()).for_each(half);
    for turn in 0..3 {
        painted.spheres.colors.as_mut().expect("colours").to_mut()[turn] = [0.1, 0.9, 0.4];
        both.compare("painted", &painted, &all());
        both.compare("shared", &shared, &all());
        let aovs = vec![Aov::Color];
        let by_method = Settings { method: Some(Method::Stable), aovs, ..Settings::default() };
        both.gpu.render(&other, &by_method).expect("a frame by a method");
        both.compare("after another scene", &shared, &all());
    }
    // Nothing but the camera is sent for spheres that no one can change.
    let mut shared = crop::scenes().remove(2).1;
    shared.spheres.share();
    both.compare("first", &shared, &all());
    shared.camera.eye.x += 1.0;
    let moved = both.compare("held", &shared, &all()).report.bytes_up;
    let again = both.compare("again", &shared, &all()).report.bytes_up;
    println!("{moved} bytes for a camera that moves, {again} for one that does not");
    assert!(moved < 5000 && again < moved);
    both.done(0);
}

/// Clouds of many sizes: thousands of spheres of less than a pixel, and spheres that fill the image.
#[test]
fn spheres_of_every_size_have_the_bits_of_the_cpu_path() {
    let Some(mut both) = Both::new() else { return };
    for (seed, count, radius) in [(1, 20_000, 0.002), (2, 5000, 0.03), (3, 300, 0.4), (4, 40, 0.9), (5, 1, 1.0)] {
        let scene = Scene { spheres: cloud(seed, count, [0.0; 3], 1.0, radius), ..crop::scenes().remove(1).1 };
        for size in [[64, 40], [333, 211]] {
            let image = halfline::scene::ImagePlane { width: size[0], height: size[1], background: [0.2; 3] };
            for eye in [[0.3, 0.2, 4.0], [0.2, 0.1, 0.4], [30.0, -20.0, 900.0]] {
                let look = halfline::camera::Look::At(glam::DVec3::ZERO);
                let camera = halfline::camera::Camera { eye: eye.into(), look, ..scene.camera };
                let scene = Scene { camera, image, ..scene.clone() };
                both.compare(&format!("{count} of {radius}, {size:?} from {eye:?}"), &scene, &all());
            }
        }
    }
    both.done(0);
}

/// Crops of frames of up to 2^40 pixels, of spheres from some pixels to all: counters, numbers of tiles and rectangles at their ends.
#[test]
fn crops_of_huge_frames_have_the_bits_of_the_cpu_path() {
    let Some(mut both) = Both::new() else { return };
    let mut random = Rng::new(0xb16);
    let mut hits = 0;
    for case in 0..amount("crops of huge frames", [30, 60, 600]) {
        let sides = [0, 1].map(|_| 2f64.powf(12.0 + 8.0 * random.unit()) as u32);
        let count = 1 + (8.0 * random.unit()) as usize;
        let mut spheres = Spheres::default();
        for _ in 0..count {
            let [x, y, z] = random.cube();
            spheres.push([x, y, z - 4.0], 10f64.powf(-3.0 * random.unit()), None);
        }
        let image = ImagePlane { width: sides[0], height: sides[1], background: [0.0; 3] };
        let lens = Lens::Viewport { vw: 2.0, vh: 2.0 * f64::from(sides[1]) / f64::from(sides[0]), distance: 2.0 };
        let scene =
            Scene { camera: Camera { lens, ..Camera::CANONICAL }, image, spheres, lighting: Default::default() };
        // A window at an edge of a sphere as it is projected, or anywhere.
        let [x, y, z] = scene.spheres.centers[0];
        let radius = scene.spheres.radii[0];
        let corner_share =
            if case % 3 == 0 { [random.unit(), random.unit()] } else { [0.5 + (x + radius) / -z, 0.5 - y / -z] };
        let corner = [0, 1].map(|k| (corner_share[k].clamp(0.0, 1.0) * f64::from(sides[k] - 40)) as u32);
        let size = [8 + (30.0 * random.unit()) as u32, 8 + (30.0 * random.unit()) as u32];
        let window = Window { x0: corner[0], y0: corner[1], x1: corner[0] + size[0], y1: corner[1] + size[1] };
        let settings = Settings { window: Some(window), ..all() };
        hits += both.compare(&format!("{case}: {sides:?}, {window:?}"), &scene, &settings).report.hits;
    }
    assert!(hits > 1000, "{hits}");
    let most = both.compared / 2;
    both.done(most);
    // One sphere of more pieces than the loops of llvmpipe count, and several of more than 2^32 together.
    let Some(mut both) = Both::new() else { return };
    for (sides, count, most) in [([8224, 8224], 1, 0), ([1 << 20, 599_200], 7, 1)] {
        let mut spheres = Spheres::default();
        (0..count).for_each(|n| spheres.push([0.0, 0.0, -40.0 - f64::from(n)], 30.0, None));
        let image = ImagePlane { width: sides[0], height: sides[1], background: [0.0; 3] };
        let lens = Lens::Viewport { vw: 1.0, vh: 1.0, distance: 1.0 };
        let scene =
            Scene { camera: Camera { lens, ..Camera::CANONICAL }, image, spheres, lighting: Default::default() };
        let left = both.left;
        for [x0, y0] in [[0, 0], [sides[0] / 2, sides[1] / 2], [sides[0] - 24, sides[1] - 24]] {
            let settings = Settings { window: Some(Window { x0, y0, x1: x0 + 24, y1: y0 + 24 }), ..all() };
            let frame = both.compare(&format!("{count} that fill {sides:?}"), &scene, &settings);
            assert_eq!(frame.report.hits, 576);
        }
        assert!(both.left - left <= 3 * most);
    }
}

/// The camera's numbers in f64 are the same, those in double-double are not.
#[test]
fn cameras_one_ulp_apart_are_two_cameras() {
    let Some(mut both) = Both::new() else { return };
    // A pixel is 2^-58 of the distance. An ulp of the direction's x turns it by four pixels, and is half an ulp of the unit vector's, so
    // some of the cameras have the same axes in f64.
    let size = 64.0 * 2f64.powi(-58);
    let image = ImagePlane { width: 64, height: 64, background: [0.0; 3] };
    let lens = Lens::Viewport { vw: size, vh: size, distance: 1.0 };
    let mut direction = glam::DVec3::new(0.2495, 1.2, -1.565);
    let mut spheres = Spheres::default();
    spheres.push(direction.normalize().to_array(), 100.0 * 2f64.powi(-58), None);
    // No one can change them, so what is placed stays for the same camera.
    spheres.share();
    let mut hits = 0;
    for _ in 0..40 {
        let camera = Camera { look: Look::View(direction), lens, ..Camera::CANONICAL };
        let scene = Scene { camera, image, spheres: spheres.clone(), lighting: Default::default() };
        hits += both.compare(&format!("{direction:?}"), &scene, &all()).report.hits;
        direction.x = direction.x.next_up();
    }
    assert!(hits > 100, "the sphere is in sight: {hits}");
}

/// More rays of a pixel than one dispatch traces.
#[test]
fn many_rays_of_a_pixel_have_the_bits_of_the_cpu_path() {
    let Some(mut both) = Both::new() else { return };
    let mut scene = Scene { spheres: cloud(6, 3000, [0.0; 3], 1.0, 0.04), ..crop::scenes().remove(1).1 };
    (scene.image.width, scene.image.height) = (24, 20);
    for rays in [31, 33, 700, 2048] {
        scene.lighting.sky = Some(Sky { rays, ..Sky::default() });
        both.compare(&format!("{rays} rays"), &scene, &Settings { aovs: vec![Aov::Occlusion], ..Settings::default() });
    }
}

/// More spheres near a pixel than a shader's loop has iterations, and as many for a method as it tests.
#[test]
fn longer_lists_than_loops_have_the_bits_of_the_cpu_path() {
    let Some(mut both) = Both::new() else { return };
    for (method, count) in [(None, 530_000), (Some(Method::Stable), 99_999)] {
        compare_many(&mut both, method, count);
    }
}

fn compare_many(both: &mut Both, method: Option<Method>, count: i32) {
    let mut spheres = Spheres::default();
    // All in one tile, beside its rays, before what the rays hit.
    (0..count).for_each(|n| spheres.push([0.013, 0.017, -2.0 - 1e-6 * f64::from(n)], 1e-7, None));
    spheres.push([0.0, 0.0, -10.0], 5.0, None);
    let image = ImagePlane { width: 9, height: 9, background: [0.0; 3] };
    let scene = Scene { image, spheres, camera: Camera::CANONICAL, lighting: Default::default() };
    let settings = Settings { method, aovs: vec![Aov::Distance, Aov::Id], ..Settings::default() };
    let device = both.gpu.render(&scene, &settings).expect("a frame");
    let host = both.cpu.render(&scene, &settings).expect("a frame");
    assert_eq!(device.ids(), host.ids(), "{method:?}");
    assert!(host.ids().contains(&count));
}
