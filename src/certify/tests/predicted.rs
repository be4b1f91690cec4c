//! Predictions with adversarial rounding: no rounding that WGSL allows makes a method worse than
//! src/intersect/predict.rs predicts.

use super::wild::{Mode, Wild, under};
use crate::double_double as dd;
use crate::exact::Judge;
use crate::intersect::predict::Prediction;
use crate::intersect::{Intersect, Method, Visit};
use crate::number::vector::Laned;
use crate::scene::camera::{Camera, Lens, Look};
use crate::scene::{ImagePlane, Scene, Spheres};
use crate::testing::Rng;
use crate::view::ray::viewing_ray;
use crate::view::{Sphere, View};
use glam::DVec3;

const SIDE: u32 = 24;

/// t of one sphere and one pixel under a mode, by a method; `None` for a miss.
struct Shot<'a> {
    view: &'a View,
    pixel: [u32; 2],
    mode: Mode,
    seed: u64,
}

impl Visit for Shot<'_> {
    type Output = Option<f64>;

    fn visit<V: Intersect, N: Laned>(self) -> Option<f64> {
        let record = &self.view.spheres[0];
        let [i, j] = self.pixel;
        let t = under(self.mode, self.seed, || {
            V::intersect(&viewing_ray::<Wild>(&self.view.record, i, j), &Sphere::<Wild>::from(record))
        });
        (t.0 < f32::MAX).then(|| dd::ldexp(f64::from(t.0) * f64::from(record.scale), self.view.unit))
    }
}

/// One sphere, seen from near its surface to far away, from outside and inside; a lens as wide as the sphere, aimed at
/// its limb.
fn world(rng: &mut Rng) -> Scene {
    let gap = rng.decade(-5.0, 4.0);
    let outside = gap > 0.9 || rng.sign() > 0.0;
    let k = if outside { 1.0 + gap } else { 1.0 - gap };
    let mut axis = || DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0)).normalize();
    let (away, across, up) = (axis(), axis(), axis());
    let radius = rng.decade(-3.0, 3.0);
    let eye = DVec3::new(rng.between(-1.0, 1.0), 2.0, 3.0) * radius;
    let center = eye + k * radius * away;
    let limb = center + radius * across.cross(away).normalize();
    let reach = if outside { 1.0 / k } else { 1.0 };
    let look = Look::View((limb - eye) + 0.3 * rng.unit() * across * radius);
    let half = reach * rng.decade(-2.0, 0.3);
    let camera = Camera { eye, look, up, lens: Lens::Viewport { vw: 2.0 * half, vh: 2.0 * half, distance: 1.0 } };
    let mut spheres = Spheres::default();
    spheres.push(center.to_array(), radius, None);
    let image = ImagePlane { width: SIDE, height: SIDE, background: [0.0; 3] };
    Scene { camera, image, spheres, lighting: Default::default() }
}

/// The sphere with a radius at which the pixel's ray grazes it, within the smallest predicted outline of all methods.
fn grazed(mut scene: Scene, [i, j]: [u32; 2], rng: &mut Rng) -> Scene {
    let view = View::new(&scene).expect("a good scene");
    let off = Prediction::of(&scene, Method::Stable).expect("a good scene").expect("a sphere").outline;
    let p = DVec3::from_array(scene.spheres.centers[0]) - scene.camera.eye;
    let d = view.to_world(view.direction(i, j)).normalize();
    if p.dot(d) > 0.0 {
        scene.spheres.radii.to_mut()[0] = p.cross(d).length() * (1.0 + rng.sign() * rng.unit() * off);
    }
    scene
}

/// The distance of a pixel's half-line from the limb, in radii, within 1e-11.
fn excess(view: &View, scene: &Scene, [i, j]: [u32; 2]) -> f64 {
    let p = DVec3::from_array(scene.spheres.centers[0]) - scene.camera.eye;
    let d = view.to_world(view.direction(i, j)).normalize();
    let l = if p.dot(d) > 0.0 { p.cross(d).length() } else { p.length() };
    (l / scene.spheres.radii[0] - 1.0).abs()
}

/// The largest shares of the predictions, by method of f32.
#[test]
fn no_legal_rounding_is_worse_than_predicted() {
    let mut rng = Rng(0x5eed_000b);
    let methods = || Method::ALL.iter().copied().filter(|method| !method.is_wide());
    let mut worst = vec![[0.0f64; 2]; methods().count()];
    for n in 0..4000 {
        let touching = [rng.below(SIDE), rng.below(SIDE)];
        let world = world(&mut rng);
        let scene = if n % 2 == 0 { world } else { grazed(world, touching, &mut rng) };
        let (view, judge) = (View::new(&scene).expect("a good scene"), Judge::new(&scene).expect("a good scene"));
        let predicted: Vec<_> = methods().map(|method| Prediction::of(&scene, method)).collect();
        for pixel in [touching, [rng.below(SIDE), rng.below(SIDE)], [rng.below(SIDE), rng.below(SIDE)]] {
            let truth = judge.pixel(pixel[0], pixel[1]);
            let [u, v, w] = view.direction(pixel[0], pixel[1]);
            let length = DVec3::new(u, v, w).length();
            for ((method, predicted), worst) in methods().zip(&predicted).zip(&mut worst) {
                let predicted = predicted.as_ref().expect("a good scene").expect("a sphere");
                for mode in Mode::BLIND.into_iter().chain([Mode::Random; 4]) {
                    let shown = method.dispatch(Shot { view: &view, pixel, mode, seed: rng.bits() });
                    let [outline, distance] = match (shown, truth) {
                        (None, None) => continue,
                        (Some(t), Some(truth)) => [0.0, (t * length / truth.distance - 1.0).abs()],
                        _ => [excess(&view, &scene, pixel), 0.0],
                    };
                    let fine = outline <= predicted.outline && distance <= predicted.distance;
                    assert!(fine, "{} {mode:?} {pixel:?}: {outline:e} {distance:e} of {predicted:?}", method.name());
                    worst[0] = worst[0].max(outline / predicted.outline);
                    worst[1] = worst[1].max(if predicted.distance < 1e9 { distance / predicted.distance } else { 0.0 });
                }
            }
        }
    }
    for (method, [outline, distance]) in methods().zip(&worst) {
        println!("{:10} outline {outline:.3}, distance {distance:.3} of what was predicted", method.name());
        assert!(*outline > 0.1 && *distance > 0.1, "the adversary finds large errors of {}", method.name());
    }
}
