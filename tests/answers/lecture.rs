//! The lecture on one page, shaders/lecture.wgsl, finds the spheres that the textbook kernel finds.
//!
//! In the canonical camera, whose numbers the kernel has too, both do the same operations: every id is equal. From an eye elsewhere
//! the page subtracts centres from it in f32, and the kernel in f64. Ids differ
//! there only where a bound of these rounding errors leaves open which sphere is hit: at outlines, and where spheres touch.

use crate::adapter::{cpu, gpu_or_skip, is_strict};
use crate::home::home;
use glam::DVec3;
use halfline::camera::{Basis, Viewport};
use halfline::intersect::Method;
use halfline::render::Renderer;
use halfline::scene::Scene;
use halfline::settings::{Accuracy, Settings};
use halfline::{Aov, Camera, Lens, Look, Spheres, wgpu};
use halfline_files::read::{self, ReadOptions};
use page::MAX_SPHERES;

#[path = "../../examples/lecture.rs"]
#[expect(dead_code, reason = "the example has a main function of its own")]
mod page;

const SCENES: [&str; 2] = ["inside.toml", "weekend.toml"];

fn scene(name: &str) -> Scene {
    read::scene(&home().join("scenes").join(name), &ReadOptions::default()).expect("a scene").scene
}

/// The scene moved into the canonical camera: the same pixels, of spheres whose centres are rounded to f64 once more.
fn canonical(scene: &Scene) -> Scene {
    let Basis { e, u, v, w } = scene.camera.basis().expect("a basis");
    let Viewport { vw, vh, d } = viewport(scene);
    let mut spheres = Spheres::default();
    for (center, radius) in scene.spheres.centers.iter().zip(scene.spheres.radii.iter()) {
        let p = DVec3::from_array(*center) - e;
        spheres.push([p.dot(u), p.dot(v), p.dot(w)], *radius, None);
    }
    let lens = Lens::Viewport { vw, vh, distance: d };
    let camera = Camera { eye: DVec3::ZERO, look: Look::View(DVec3::NEG_Z), up: DVec3::Y, lens };
    Scene { camera, spheres, image: scene.image, lighting: Default::default() }
}

fn viewport(scene: &Scene) -> Viewport {
    scene.camera.viewport(scene.image.width, scene.image.height).expect("a viewport")
}

/// The ids of a frame by this method, or of this accuracy.
fn ids(renderer: &mut Renderer, scene: &Scene, method: Option<Method>, accuracy: Accuracy) -> Vec<i32> {
    let settings = Settings { accuracy, method, aovs: vec![Aov::Id], ..Settings::default() };
    let scene = Scene { lighting: Default::default(), ..scene.clone() };
    renderer.render(&scene, &settings).expect("a frame").ids().to_vec()
}

/// The ids of the textbook kernel.
fn textbook(renderer: &mut Renderer, scene: &Scene) -> Vec<i32> {
    ids(renderer, scene, Some(Method::Textbook), Accuracy::Fast)
}

/// The ids of the page.
fn ids_of_page(adapter: &wgpu::Adapter, scene: &Scene) -> Vec<i32> {
    page::render(scene, adapter).expect("a picture").iter().map(|pixel| pixel[3] as i32).collect()
}

/// The pixels whose ids differ; the bound must leave each of them open.
fn differing(scene: &Scene, a: &[i32], b: &[i32]) -> usize {
    assert_eq!(a.len(), b.len());
    let differ: Vec<_> = (0..a.len()).filter(|n| a[*n] != b[*n]).collect();
    let decided = |n: &usize| decides(scene, n / scene.image.width as usize, n % scene.image.width as usize);
    let wrong: Vec<_> = differ.iter().filter(|n| decided(n)).map(|n| (n, a[*n], b[*n])).collect();
    assert!(
        wrong.is_empty(),
        "{} of {} ids that differ are decided, such as {:?}",
        wrong.len(),
        differ.len(),
        wrong[0]
    );
    differ.len()
}

/// Whether the discriminants and the roots of a pixel's ray, in f64, say which sphere it hits in spite of all roundings of f32: of
/// eye and centre, which leave 2 u (|e| + |c|) of p, and of each operation.
fn decides(scene: &Scene, i: usize, j: usize) -> bool {
    const U: f64 = f32::EPSILON as f64 / 2.0;
    let (Basis { e, u, v, w }, Viewport { vw, vh, d }) = (scene.camera.basis().expect("a basis"), viewport(scene));
    let part = |n: usize, count: u32| (n as f64 + 0.5) / f64::from(count) - 0.5;
    let d = part(j, scene.image.width) * vw * u - part(i, scene.image.height) * vh * v - d * w;
    // The nearest t that a sphere may have, whether it has one for certain, and then the farthest.
    let mut ranges = Vec::new();
    for (c, r) in scene.spheres.centers.iter().zip(scene.spheres.radii.iter()) {
        let c = DVec3::from_array(*c);
        let (p, size) = (e - c, e.length() + c.length() + r);
        let (dd, dp) = (d.dot(d), d.dot(p));
        let discriminant = dp * dp - dd * (p.dot(p) - r * r);
        let error = 64.0 * U * dd * size * size;
        if discriminant < -error {
            continue;
        }
        let root = discriminant.max(0.0).sqrt();
        let root_error = if discriminant > error { error / root } else { (2.0 * error).sqrt() };
        for t in [(-dp - root) / dd, (-dp + root) / dd] {
            let error_of_t = (16.0 * U * dd.sqrt() * size + root_error) / dd + 8.0 * U * t.abs();
            if t >= -error_of_t {
                ranges.push((t - error_of_t, discriminant > error && t > error_of_t, t + error_of_t));
                break;
            }
        }
    }
    let farthest =
        ranges.iter().filter(|(_, is_hit, _)| *is_hit).map(|(_, _, most)| *most).fold(f64::INFINITY, f64::min);
    ranges.retain(|(least, ..)| *least <= farthest);
    ranges.iter().all(|(_, is_hit, _)| *is_hit) && ranges.len() <= 1
}

#[test]
fn in_the_canonical_camera_it_finds_the_spheres_of_the_textbook_kernel() {
    let Some(mut gpu) = gpu_or_skip() else { return };
    let adapter = page::adapter(gpu.adapter()).expect("the adapter of the tests");
    for name in SCENES {
        let scene = canonical(&scene(name));
        let page = ids_of_page(&adapter, &scene);
        let kernel_and_twin =
            [&mut gpu, &mut cpu()].map(|renderer| differing(&scene, &page, &textbook(renderer, &scene)));
        println!("{name}: {kernel_and_twin:?} of {} pixels differ from the kernel and its twin", page.len());
        assert!(kernel_and_twin == [0, 0] || !is_strict(&gpu), "{name}");
    }
}

#[test]
fn from_an_eye_elsewhere_it_finds_them_but_for_rounding_errors() {
    let Some(mut gpu) = gpu_or_skip() else { return };
    let adapter = page::adapter(gpu.adapter()).expect("the adapter of the tests");
    for name in SCENES {
        let scene = scene(name);
        let page = ids_of_page(&adapter, &scene);
        let from_kernel = differing(&scene, &page, &textbook(&mut gpu, &scene));
        let wrong = differing(&scene, &page, &ids(&mut cpu(), &scene, None, Accuracy::Exact));
        println!("{name}: {from_kernel} of {} pixels differ from the kernel, {wrong} are wrong", page.len());
    }
}

/// The sphere that is hit comes last; llvmpipe would end the loop before one more.
#[test]
fn as_many_spheres_as_it_takes_are_tested() {
    let Some(gpu) = gpu_or_skip() else { return };
    let adapter = page::adapter(gpu.adapter()).expect("the adapter of the tests");
    let mut scene = canonical(&scene("inside.toml"));
    (scene.image.width, scene.image.height) = (16, 16);
    scene.spheres = Spheres::default();
    (1..MAX_SPHERES).for_each(|_| scene.spheres.push([0.0, 0.0, 9.0], 1.0, None));
    scene.spheres.push([0.0; 3], 1.0, None);
    assert!(ids_of_page(&adapter, &scene).iter().all(|id| *id == MAX_SPHERES as i32 - 1));
    scene.spheres.push([0.0; 3], 1.0, None);
    let words = page::render(&scene, &adapter).expect_err("too many spheres").to_string();
    assert!(words.contains("65536") && words.contains("65535"), "{words}");
}
