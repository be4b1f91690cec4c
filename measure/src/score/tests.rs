use super::*;
use halfline::frame::{Buffer, Data};
use halfline::scene::camera::{Camera, Lens};
use halfline::scene::{ImagePlane, Spheres};
use halfline::settings::{Accuracy, Backend, Settings};

/// Seen from the origin along -z in 3 x 3 rays of slopes -1, 0, 1: one sphere ahead, a smaller one in front of it, and
/// one that only the middle ray of the right column hits.
fn scene() -> Scene {
    let mut spheres = Spheres::default();
    spheres.push([0.0, 0.0, -10.0], 2.0, None);
    spheres.push([0.0, 0.0, -5.0], 1.0, None);
    spheres.push([8.0, 0.0, -8.0], 4.0, None);
    let lens = Lens::Viewport { vw: 3.0, vh: 3.0, distance: 1.0 };
    let image = ImagePlane { width: 3, height: 3, background: [0.0; 3] };
    Scene { camera: Camera { lens, ..Camera::CANONICAL }, image, spheres, lighting: Default::default() }
}

/// The exact frame.
fn exact(scene: &Scene) -> Frame {
    let aovs = vec![Aov::Distance, Aov::Normal, Aov::Bound];
    let settings = Settings { backend: Backend::Cpu, accuracy: Accuracy::Exact, aovs, ..Settings::default() };
    halfline::render(scene, &settings).expect("an exact frame")
}

/// The middle pixel and the one to its right, which hit.
const MIDDLE: usize = 4;
const RIGHT: usize = 5;

fn ids(frame: &mut Frame) -> &mut [i32] {
    frame.buffers.iter_mut().find_map(|b| if let Data::I32(ids) = &mut b.data { Some(ids) } else { None }).expect("ids")
}

fn buffer(frame: &mut Frame, aov: Aov) -> &mut Buffer {
    frame.buffers.iter_mut().find(|b| b.aov == aov).expect("a requested buffer")
}

fn distances(frame: &mut Frame) -> &mut [f64] {
    if let Data::F64(values) = &mut buffer(frame, Aov::Distance).data { values } else { panic!("f64") }
}

fn normals(frame: &mut Frame) -> &mut [f32] {
    if let Data::F32(values) = &mut buffer(frame, Aov::Normal).data { values } else { panic!("f32") }
}

/// The errors after a change to the exact frame.
fn after(change: impl FnOnce(&mut Frame)) -> Errors {
    let scene = scene();
    let mut frame = exact(&scene);
    change(&mut frame);
    Truths::of(&scene).expect("truths").errors(&frame).expect("errors")
}

#[test]
fn the_exact_frame_has_no_errors() {
    let scene = scene();
    let truths = Truths::of(&scene).expect("truths");
    assert_eq!(truths.hits(), 2);
    let score = truths.score(&exact(&scene)).expect("a score");
    let errors = score.errors();
    assert_eq!((errors.pixels, errors.wrong(), errors.outline), (9, 0, Some(0.0)));
    assert_eq!((errors.relative.max, errors.ulp.max, errors.radii.max), (Some(0.0), Some(0.0), Some(0.0)));
    // The frame's normals are f32: 2^-24 per component is at most 6e-6 degrees.
    assert!(errors.normal.max.is_some_and(|x| x < 6e-6), "{errors:?}");
    assert_eq!(score.of_bound(), Some(0.0));
}

#[test]
fn planted_wrong_ids_are_classified_and_measured_in_radii() {
    // The corner's ray (1, 1, -1) passes sphere 0 at |(0,0,-10) x (1,1,-1)| / sqrt 3 = 10 sqrt(2/3).
    let errors = after(|frame| ids(frame)[2] = 0);
    assert_eq!((errors.false_hit, errors.wrong()), (1, 1));
    let grow = 10.0 * (2.0f64 / 3.0).sqrt() / 2.0 - 1.0;
    assert!(errors.outline.is_some_and(|x| (x - grow).abs() < 1e-14), "{errors:?}, not {grow}");
    // The middle ray passes through the centre: only a sphere of radius 0 is missed.
    let errors = after(|frame| ids(frame)[MIDDLE] = -1);
    assert_eq!((errors.false_miss, errors.wrong(), errors.outline), (1, 1, Some(1.0)));
    // Behind: the point of the half-line nearest to the centre is the eye, at a distance of 5.
    let mut behind = scene();
    behind.spheres.centers.to_mut()[1] = [0.0, 0.0, 5.0];
    let mut frame = exact(&behind);
    ids(&mut frame)[0] = 1;
    let errors = Truths::of(&behind).expect("truths").errors(&frame).expect("errors");
    assert_eq!((errors.false_hit, errors.outline), (1, Some(4.0)));
}

#[test]
fn a_wrong_sphere_is_a_wrong_outline_or_a_wrong_order() {
    // Sphere 0, which the ray also hits, instead of 1 at 4, more than twice as far: 1 was missed, which would need a
    // radius of 0.
    let errors = after(|frame| (ids(frame)[MIDDLE], distances(frame)[MIDDLE]) = (0, 8.1));
    assert_eq!((errors.wrong_sphere, errors.wrong(), errors.outline), (1, 1, Some(1.0)));
    assert_eq!(errors.relative.max, Some(0.0), "not counted as a distance");
    // At the same distance as 1: a wrong order.
    let errors = after(|frame| (ids(frame)[MIDDLE], distances(frame)[MIDDLE]) = (0, 4.5));
    assert_eq!((errors.wrong_sphere, errors.outline, errors.relative.max), (1, Some(0.0), Some(0.125)));
    let errors = after(|frame| (ids(frame)[MIDDLE], distances(frame)[MIDDLE]) = (0, 3.0));
    assert_eq!((errors.wrong_sphere, errors.outline, errors.relative.max), (1, Some(0.0), Some(0.25)));
    // Sphere 2 is at |(8,0,-8) x (0,0,-1)| = 8 from the middle ray, twice its radius.
    let errors = after(|frame| (ids(frame)[MIDDLE], distances(frame)[MIDDLE]) = (2, 3.0));
    assert_eq!((errors.wrong_sphere, errors.outline, errors.relative.max), (1, Some(1.0), Some(0.0)));
}

#[test]
fn a_planted_wrong_root_is_found() {
    // Sphere 1 is hit at 4 and at 6.
    let errors = after(|frame| distances(frame)[MIDDLE] = 6.0);
    assert_eq!((errors.wrong_root, errors.wrong(), errors.relative.max), (1, 1, Some(0.5)));
    assert_eq!(after(|frame| distances(frame)[MIDDLE] = 4.9).wrong_root, 0, "nearer to 4");
    assert_eq!(after(|frame| distances(frame)[MIDDLE] = 5.1).wrong_root, 1, "nearer to 6");
    for nothing in [f64::NAN, f64::INFINITY] {
        let errors = after(|frame| distances(frame)[MIDDLE] = nothing);
        assert_eq!((errors.wrong_root, errors.relative.max), (1, None));
    }
    // From inside, the far root is the hit, and the near one is behind.
    let mut inside = scene();
    inside.spheres.centers.to_mut()[1] = [0.0, 0.0, -0.5];
    let mut frame = exact(&inside);
    let truths = Truths::of(&inside).expect("truths");
    assert_eq!(frame.f64(Aov::Distance).expect("a requested buffer")[MIDDLE], 1.5);
    distances(&mut frame)[MIDDLE] = 0.4;
    assert_eq!(truths.errors(&frame).expect("errors").wrong_root, 1, "nearer to -0.5");
    distances(&mut frame)[MIDDLE] = 0.6;
    assert_eq!(truths.errors(&frame).expect("errors").wrong_root, 0, "nearer to 1.5");
}

#[test]
fn errors_of_distance_are_in_ulp_in_radii_and_relative() {
    // Three ulps of f32 at t* = 4, where one ulp is 2^-21; the radius is 1, the ray's direction of length 1.
    let errors = after(|frame| distances(frame)[MIDDLE] = 4.0 + 3.0 * 2f64.powi(-21));
    assert_eq!(errors.wrong(), 0);
    assert_eq!((errors.ulp.max, errors.radii.max), (Some(3.0), Some(3.0 * 2f64.powi(-21))));
    assert_eq!(errors.relative.max, Some(0.75 * 2f64.powi(-21)));
    // Half of the two hits have no larger error than the other one.
    assert_eq!((errors.ulp.median, errors.ulp.p99), (Some(0.0), Some(3.0)));
    // To the right the direction is sqrt 2 long, so t* = (8 sqrt 2 - 4)/sqrt 2 = 5.17 and the distance is 7.3; the
    // radius is 4.
    let errors = after(|frame| distances(frame)[RIGHT] += 2f64.sqrt() * 2f64.powi(-21));
    assert!(errors.ulp.max.is_some_and(|x| (x - 1.0).abs() < 1e-6), "{errors:?}");
    assert!(errors.radii.max.is_some_and(|x| (x * 4.0 / 2f64.sqrt() * 2f64.powi(21) - 1.0).abs() < 1e-6), "{errors:?}");
}

#[test]
fn a_planted_normal_shows_in_degrees() {
    let turn = |degrees: f32| {
        after(move |frame| {
            let n = &mut normals(frame)[3 * MIDDLE..3 * MIDDLE + 3];
            n.copy_from_slice(&[degrees.to_radians().sin(), 0.0, degrees.to_radians().cos()]);
        })
    };
    assert!(turn(30.0).normal.max.is_some_and(|x| (x - 30.0).abs() < 1e-5));
    assert!(turn(180.0).normal.max.is_some_and(|x| (x - 180.0).abs() < 1e-5), "the other way round");
    assert_eq!(after(|frame| normals(frame)[3 * MIDDLE..3 * MIDDLE + 3].fill(0.0)).normal.max, None, "no direction");
}

#[test]
fn a_bound_is_measured_against_the_true_error() {
    let scene = scene();
    let mut frame = exact(&scene);
    distances(&mut frame)[MIDDLE] = 4.25;
    if let Data::F64(bounds) = &mut buffer(&mut frame, Aov::Bound).data {
        bounds[MIDDLE] = 0.125;
    }
    let score = Truths::of(&scene).expect("truths").score(&frame).expect("a score");
    assert_eq!(score.of_bound(), Some(2.0), "a false bound shows");
}

#[test]
fn a_map_has_the_place_of_each_error() {
    let mut wide = scene();
    (wide.image.width, wide.image.height) = (321, 3);
    let mut frame = exact(&wide);
    ids(&mut frame)[2 * 321 + 320] = 0;
    let map = Truths::of(&wide).expect("truths").score(&frame).expect("a score").map();
    assert_eq!((map.cell, map.size), (3, [107, 1]), "321 columns make no more than 160 cells");
    assert_eq!((map.wrong.iter().sum::<u32>(), map.wrong[106]), (1, 1));
    let truths_size = Truths::of(&scene()).expect("truths").score(&frame).err().map(|e| e.to_string());
    assert!(truths_size.is_some_and(|e| e.contains("321 x 3")), "another scene's frame is refused");
}

/// A wrong kernel is reported as broken: here one whose radii are 1 % too large.
#[test]
fn a_broken_kernel_is_reported() {
    let mut scene = scene();
    (scene.image.width, scene.image.height) = (96, 96);
    let settings = Settings {
        backend: Backend::Cpu,
        method: Some(halfline::Method::Stable),
        aovs: vec![Aov::Distance, Aov::Normal],
        ..Settings::default()
    };
    let truths = Truths::of(&scene).expect("truths");
    let sound = truths.errors(&halfline::render(&scene, &settings).expect("a frame")).expect("errors");
    assert_eq!(sound.wrong(), 0, "{sound:?}");
    let mut broken = scene.clone();
    broken.spheres.radii.to_mut().iter_mut().for_each(|r| *r *= 1.01);
    let errors = truths.errors(&halfline::render(&broken, &settings).expect("a frame")).expect("errors");
    println!("sound {sound:?}\nbroken {errors:?}");
    assert!(errors.wrong() > 20 && errors.false_hit > 0 && errors.false_miss == 0, "{errors:?}");
    assert!(errors.outline.is_some_and(|x| (0.001..0.010_001).contains(&x)), "1 % of the radius: {errors:?}");
    assert!(errors.radii.median.is_some_and(|x| x > 0.009), "{errors:?}");
    assert!(errors.normal.max.is_some_and(|x| x > 0.1), "{errors:?}");
    assert!(errors.ulp.median > sound.ulp.max, "{errors:?}");
}

#[test]
fn a_crop_shows_the_shading_and_the_verdict() {
    let scene = scene();
    let mut frame = exact(&scene);
    ids(&mut frame)[2] = 0;
    let score = Truths::of(&scene).expect("truths").score(&frame).expect("a score");
    let crop = score.crop(&scene, &frame).expect("a crop");
    assert_eq!((crop.size, crop.verdict.as_str()), ([3, 3], "--h------"));
    // The corner with a false hit has no normal; the middle one faces the light.
    assert_eq!((&crop.shade[..5], &crop.shade[6..]), ("..0.f", "..."), "{}", crop.shade);
    assert!(crop.shade.as_bytes()[RIGHT].is_ascii_hexdigit());
}

#[test]
fn a_spread_has_the_quantiles_of_its_errors() {
    let mut errors: Vec<f64> = (1..=1000).map(f64::from).collect();
    errors.reverse();
    let Spread { median, p99, max } = Spread::of(errors);
    assert_eq!((median, p99, max), (Some(500.0), Some(990.0), Some(1000.0)));
    let Spread { median, p99, max } = Spread::of(vec![2.0]);
    assert_eq!((median, p99, max), (Some(2.0), Some(2.0), Some(2.0)));
}
