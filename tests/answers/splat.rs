//! Frames whose spheres an adapter holds (`search splat`) have the bits of the CPU path, which the other files compare with
//! exact arithmetic: every buffer, in every family of scenes, for windows, samples, parallel rays and off-centre lenses.
//! Tolerance: none on adapters known to be strict; on others ids and masks.

use super::{crop, extremes, off_center, ortho};
use crate::adapter::{cpu, gpu_or_skip, is_strict};
use crate::bits::differing;
use crate::cloud::cloud;
use crate::weekend::weekend;
use halfline::frame::{Aov, Frame};
use halfline::render::Renderer;
use halfline::scene::Scene;
use halfline::settings::{Accuracy, Search, Settings};
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
        let settings = Settings { search: Search::Splat, ..settings };
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
        println!("{} frames compared, of which {} were left to the host", self.compared, self.left);
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
    // Colours that change while the positions cannot, and a frame by lists of another scene between two of this one.
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
        let by_method = Settings { search: Search::Tiles, accuracy: Accuracy::Fast, aovs, ..Settings::default() };
        both.gpu.render(&other, &by_method).expect("a frame by lists");
        both.compare("after lists of another scene", &shared, &all());
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
