//! Decisions whose answers are known by construction, and a comparison of the filter with the exact signs.

mod cuts;
mod parallel;
mod secondary;

use super::*;
use crate::scene::ImagePlane;
use crate::scene::camera::{Camera, Look};
use crate::testing::Rng;
use rayon::prelude::*;

type Sphere = ([f64; 3], f64);

fn scene(camera: Camera, [width, height]: [u32; 2], balls: &[Sphere]) -> Scene {
    let mut spheres = Spheres::default();
    for (center, radius) in balls {
        spheres.push(*center, *radius, None);
    }
    let image = ImagePlane { width, height, ..ImagePlane::default() };
    Scene { camera, image, spheres, lighting: Default::default() }
}

fn judge(camera: Camera, size: [u32; 2], balls: &[Sphere]) -> Judge {
    Judge::new(&scene(camera, size, balls)).expect("a scene")
}

/// The hit straight ahead of the canonical camera: the ray (0, 0, -1).
fn ahead(balls: &[Sphere]) -> Option<Truth> {
    judge(Camera::CANONICAL, [1, 1], balls).pixel(0, 0)
}

/// View (1, 1, 0) and up z make alpha = beta = sqrt(2). The right pixel of three looks along A3 + 2 view = (3, 1, 0)
/// in whole numbers, but its discriminants have a part with alpha beta, whose sign needs a squaring.
fn oblique(balls: &[Sphere]) -> Option<Truth> {
    slanted([5.0, -7.0, 11.0], balls).pixel(0, 2)
}

/// The same camera at another eye.
fn slanted(eye: [f64; 3], balls: &[Sphere]) -> Judge {
    let camera = Camera {
        eye: eye.into(),
        look: Look::View([1.0, 1.0, 0.0].into()),
        up: [0.0, 0.0, 1.0].into(),
        lens: crate::scene::camera::Lens::Viewport { vw: 3.0, vh: 1.0, distance: 2.0 },
    };
    judge(camera, [3, 1], balls)
}

/// The eye of [`oblique`] plus m (3, 1, 0) plus `q`.
fn from_eye(m: f64, q: [f64; 3]) -> [f64; 3] {
    [5.0 + 3.0 * m + q[0], -7.0 + m + q[1], 11.0 + q[2]]
}

/// The nearest hit by exact signs alone.
fn exactly(bench: &Bench, rays: &RayForms) -> Option<Truth> {
    let field = &bench.frame.field;
    let mut best: Option<(u32, Meeting, bool)> = None;
    for (id, body) in bench.bodies.iter().enumerate() {
        let meeting = bench.intersect(rays, body);
        let Some(tangent) = meeting.hit(field) else { continue };
        let rooted = |meeting: &Meeting| decide::root(meeting.side(field));
        let nearer = |other: &Meeting| decide::order(field, (&meeting, rooted(&meeting)), (other, rooted(other)));
        if best.as_ref().is_none_or(|(_, other, _)| nearer(other) == Ordering::Less) {
            best = Some((id as u32, meeting, tangent));
        }
    }
    let (id, meeting, tangent) = best?;
    let body = &bench.bodies[id as usize];
    let name = DecidedHit { id, root: decide::root(meeting.side(field)), tangent };
    answer::slow(name, &bench.frame, rays, &HitPlace::Root(&meeting), body.ball.radius)
}

/// In [-1, 1).
fn signed(rng: &mut Rng) -> f64 {
    2.0 * rng.unit() - 1.0
}

fn vector(rng: &mut Rng, scale: f64) -> [f64; 3] {
    std::array::from_fn(|_| signed(rng) * scale)
}

/// An oblique camera at `scale` and spheres of all kinds: near, far, around the eye, shells, coincident ones.
fn random_scene(rng: &mut Rng, scale: f64) -> Scene {
    let eye = vector(rng, 3.0 * scale);
    let camera = Camera {
        eye: eye.into(),
        look: Look::At(vector(rng, scale).into()),
        up: vector(rng, 1.0).into(),
        lens: crate::scene::camera::Lens::Vfov { degrees: 20.0 + 60.0 * signed(rng).abs(), distance: 1.5 },
    };
    let mut balls = Vec::new();
    for _ in 0..12 {
        let far = 10f64.powf(4.0 + 4.0 * signed(rng));
        balls.push((vector(rng, scale), 0.3 * scale * signed(rng).abs() + 1e-3 * scale));
        balls.push((vector(rng, far * scale), 0.3 * far * scale * signed(rng).abs() + 1e-3 * scale));
    }
    balls.push((eye, 2.0 * scale));
    balls.push(([eye[0] + scale, eye[1], eye[2]], scale));
    let (center, radius) = balls[0];
    balls.push((center, radius * (1.0 - 1e-15)));
    balls.push((center, radius));
    balls.push((center, radius));
    scene(camera, [7, 5], &balls)
}

fn pixels(scene: &Scene) -> impl Iterator<Item = (u32, u32)> + use<> {
    let ImagePlane { width, height, .. } = scene.image;
    (0..height).flat_map(move |i| (0..width).map(move |j| (i, j)))
}

#[test]
fn a_tangent_ray_hits_and_one_ulp_less_of_radius_is_missed() {
    for (center, r) in [([0.75, 0.0, -5.0], 0.75f64), ([3.0, 4.0, -7.0], 5.0), ([-5.0, 12.0, -1e9], 13.0)] {
        let touch = ahead(&[(center, r)]).expect("the touch");
        assert!(touch.tangent && touch.root == Root::Near && touch.t == -center[2], "{touch:?}");
        assert_eq!(ahead(&[(center, r.next_down())]), None, "{center:?}");
        assert!(!ahead(&[(center, r.next_up())]).expect("a cut").tangent, "{center:?}");
    }
}

#[test]
fn tangency_is_decided_through_the_roots_of_an_oblique_basis() {
    // (-2, 6, 3) is orthogonal to (3, 1, 0) and has length 7.
    for (m, scale) in [(3.0, 1.0), (1000.0, 0.25), (2f64.powi(40), 1.0)] {
        let (center, r) = (from_eye(m, [-2.0 * scale, 6.0 * scale, 3.0 * scale]), 7.0 * scale);
        let touch = oblique(&[(center, r)]).expect("the touch");
        // The direction is (3, 1, 0)/sqrt(2).
        assert!(touch.tangent && touch.t == (2.0 * m * m).sqrt(), "{touch:?}");
        assert_eq!(touch.position, from_eye(m, [0.0; 3]));
        assert_eq!(touch.normal, [2.0 / 7.0, -6.0 / 7.0, -3.0 / 7.0]);
        assert_eq!(oblique(&[(center, r.next_down())]), None);
        assert!(!oblique(&[(center, r.next_up())]).expect("a cut").tangent);
    }
}

#[test]
fn equal_t_goes_to_the_lower_index() {
    // All pass through (0, 0, -4): two from the front, one around the eye, with different b and D.
    let balls = [([0.0, 0.0, -5.0], 1.0), ([3.0, 0.0, -8.0], 5.0), ([0.0, 0.0, 0.0], 4.0), ([0.0, 4.0, -1.0], 5.0)];
    // All pass through 6 (3, 1, 0) from the eye of the oblique camera; the last one is tangent there.
    let through = [([2.0, 3.0, 6.0], 7.0), ([6.0, -2.0, 3.0], 7.0), ([1.0, 2.0, 2.0], 3.0), ([-2.0, 6.0, 3.0], 7.0)];
    let through = through.map(|(q, r): Sphere| (from_eye(6.0, q), r));
    for first in 0..4 {
        for second in (0..4).filter(|second| *second != first) {
            let truth = ahead(&[balls[first], balls[second]]).expect("a hit");
            assert_eq!((truth.id, truth.t), (0, 4.0), "{first} {second}");
            let truth = oblique(&[through[first], through[second]]).expect("a hit");
            assert_eq!((truth.id, truth.tangent), (0, first == 3), "{first} {second}");
            assert_eq!(truth.t, 72f64.sqrt());
        }
        let nearer = |(center, r): Sphere| (center, r.next_up());
        let (last, tie) = (nearer(through[first]), through[(first + 1) % 4]);
        // A tangent sphere that grows is hit earlier on its front.
        assert_eq!(oblique(&[tie, last]).expect("a hit").id, 1, "an ulp decides: {first}");
    }
}

#[test]
fn an_eye_on_the_surface_sees_the_far_side_only() {
    let far = ahead(&[([0.0, 0.0, -2.0], 2.0)]).expect("looking in");
    assert_eq!((far.root, far.t, far.normal), (Root::Far, 4.0, [0.0, 0.0, 1.0]));
    assert_eq!(ahead(&[([0.0, 0.0, 2.0], 2.0)]), None, "looking out");
    assert_eq!(ahead(&[([2.0, 0.0, 0.0], 2.0)]), None, "looking along");
    // The eye of the oblique camera, 7 from the centre.
    assert_eq!(oblique(&[(from_eye(0.0, [-2.0, 6.0, 3.0]), 7.0)]), None, "looking along");
    assert_eq!(oblique(&[(from_eye(0.0, [-3.0, 6.0, 2.0]), 7.0)]), None, "looking out");
    let far = oblique(&[(from_eye(0.0, [6.0, -3.0, 2.0]), 7.0)]).expect("looking in");
    // 2 p.x/|x| for x = (3, 1, 0): 30/sqrt(10), and |dir| = sqrt(5).
    assert_eq!((far.root, far.t), (Root::Far, 18f64.sqrt()));
}

#[test]
fn from_inside_the_far_root_is_the_hit() {
    let inside = ahead(&[([0.0, 0.0, 1.0], 5.0)]).expect("inside");
    assert_eq!((inside.root, inside.t, inside.normal), (Root::Far, 4.0, [0.0, 0.0, 1.0]));
    assert_eq!(inside.position, [0.0, 0.0, -4.0]);
    assert_eq!(ahead(&[([0.0, 0.0, 1.0], 1.0 - f64::EPSILON)]), None, "behind");
}

#[test]
fn the_filter_says_what_exact_signs_say() {
    let mut rng = Rng(1);
    for scale in [1.0, 1e-30, 1e30, 1e-140, 1e150] {
        for n in 0..8 {
            let mut scene = random_scene(&mut rng, scale);
            if n % 2 == 1 {
                let height = scale * 10f64.powf(3.0 * signed(&mut rng));
                scene.camera.lens = crate::scene::camera::Lens::Orthographic { height };
            }
            let judge = Judge::new(&scene).expect("a scene");
            for (i, j) in pixels(&scene) {
                let (quick, slow) = (judge.pixel(i, j), exactly(&judge.bench, &judge.ray(i, j).expect("a plane")));
                let (Some(quick), Some(slow)) = (quick, slow) else {
                    assert_eq!(quick, slow);
                    continue;
                };
                assert_eq!((quick.id, quick.root, quick.tangent), (slow.id, slow.root, slow.tangent));
                // Both round numbers whose relative difference is 2^-60; for vectors it is relative to their scale.
                let near =
                    |a: f64, b: f64, size: f64| (a - b).abs() <= 2f64.powi(-52) * b.abs() + 2f64.powi(-60) * size;
                assert!(near(quick.t, slow.t, 0.0) && near(quick.distance, slow.distance, 0.0), "{quick:?} {slow:?}");
                assert!(near(quick.depth, slow.depth, 0.0), "{quick:?} {slow:?}");
                for k in 0..3 {
                    assert!(near(quick.normal[k], slow.normal[k], 1.0), "{quick:?} {slow:?}");
                    assert!(near(quick.position[k], slow.position[k], slow.distance), "{quick:?} {slow:?}");
                }
            }
        }
    }
}

#[test]
fn eight_rays_at_once_have_the_answers_of_each() {
    let (mut rng, mut hits, mut decided) = (Rng(8), 0, 0);
    for scale in [1.0, 1e-30, 1e30, 1e-140, 1e150] {
        for _ in 0..8 {
            let scene = random_scene(&mut rng, scale);
            let judge = Judge::new(&scene).expect("a scene");
            let places: Vec<[u32; 2]> = pixels(&scene).map(|(i, j)| [i, j]).collect();
            for id in 0..scene.spheres.len() as u32 {
                let ball = scene.spheres.ball(id);
                for eight in places.as_chunks().0 {
                    for ([i, j], truth) in eight.iter().zip(judge.surely_hit(eight, id)) {
                        let alone =
                            judge.hit_of(*i, *j, Solid { ball, is_cut: false }).map(|alone| Truth { id, ..alone });
                        (hits, decided) = (hits + u32::from(alone.is_some()), decided + u32::from(truth.is_some()));
                        assert!(truth.is_none() || truth == alone, "{truth:?} {alone:?}");
                    }
                }
            }
        }
    }
    assert!(hits > 1000 && decided > hits / 10 * 9, "{decided} of {hits}");
    // A close call is left to exact signs.
    for k in 110..130 {
        let judge = slanted([0.0, 0.0, 2f64.powi(-k)], &[([7.0, 9.0, 3.0], 7.0)]);
        assert!(judge.pixel(0, 2).is_some() && judge.surely_hit(&[[0, 2]; LANES], 0) == [None; LANES], "2^-{k}");
    }
}

#[test]
fn the_filter_leaves_close_calls_to_exact_signs() {
    // Double-doubles represent a shift of 2^-k beside a 3, but not its effect on a discriminant.
    for k in 40..130 {
        let shift = 2f64.powi(-k);
        for m in [3.0, 1000.0, 2f64.powi(30) + 1.0] {
            let touch = ([3.0 * m - 2.0, m + 6.0, 3.0], 7.0);
            let see = |eye: [f64; 3]| slanted(eye, &[touch]).pixel(0, 2).map(|truth| truth.tangent);
            assert_eq!(see([0.0, 0.0, shift]), Some(false), "nearer the middle: 2^-{k}, {m}");
            assert_eq!(see([0.0, 0.0, -shift]), None, "past the edge: 2^-{k}, {m}");
            assert_eq!(see([3.0 * shift, shift, 0.0]), Some(true), "along the ray: 2^-{k}, {m}");
            let [near, far] = [([3.0 * m + 1.0, m + 2.0, 2.0], 3.0), ([3.0 * m + 2.0, m + 3.0, 6.0], 7.0)];
            for eye in [[0.0, 0.0, shift], [0.0, 0.0, -shift], [-shift, 3.0 * shift, 0.0]] {
                let judge = slanted(eye, &[near, far]);
                let truth = exactly(&judge.bench, &judge.ray(0, 2).expect("a plane")).map(|truth| truth.id);
                assert_eq!(judge.pixel(0, 2).map(|truth| truth.id), truth, "{eye:?}, {m}");
                let back = slanted(eye, &[far, near]).pixel(0, 2).map(|truth| 1 - truth.id);
                assert_eq!(back, truth, "no tie: {eye:?}, {m}");
            }
        }
    }
}

#[test]
fn an_eye_just_off_the_surface_is_on_its_side() {
    // |p|^2 - r^2 is the square of the shift, which a double-double loses beside 1.
    for k in [-30, -60, -500] {
        let spheres = Spheres {
            centers: vec![[1.0, 2f64.powi(k), 0.0]].into(),
            radii: vec![1.0].into(),
            colors: None,
            materials: None,
            opacities: None,
            cuts: None,
        };
        let outside = judge_ray([0.0; 3], [1.0, 0.0, 0.0], &spheres).expect("looking in");
        // t = c/(b + sqrt(D)) for c = 2^2k, b = 1 and D = 1 - 2^2k.
        assert_eq!((outside.root, outside.t), (Root::Near, 2f64.powi(2 * k - 1)), "2^{k}");
        assert_eq!(judge_ray([0.0; 3], [-1.0, 0.0, 0.0], &spheres), None, "looking out");
    }
    // p = (3 + 4 x, 4 - 3 x, 0) and r = 5: c = 25 x^2, which is lost in a product of double-doubles.
    for k in 30..60 {
        let x = 2f64.powi(-k);
        let spheres = Spheres {
            centers: vec![[3.0, 4.0, 0.0]].into(),
            radii: vec![5.0].into(),
            colors: None,
            materials: None,
            opacities: None,
            cuts: None,
        };
        let outside = judge_ray([-4.0 * x, 3.0 * x, 0.0], [3.0, 4.0, 0.0], &spheres).expect("looking in");
        assert_eq!((outside.root, outside.t), (Root::Near, x * x / 2.0), "2^-{k}");
    }
    let inside = Spheres {
        centers: vec![[1.0 - 2f64.powi(-53), 2f64.powi(-60), 0.0]].into(),
        radii: vec![1.0].into(),
        colors: None,
        materials: None,
        opacities: None,
        cuts: None,
    };
    let truth = judge_ray([0.0; 3], [-1.0, 0.0, 0.0], &inside).expect("inside");
    assert_eq!((truth.root, truth.distance), (Root::Far, 2f64.powi(-53)));
}

#[test]
fn underflow_leaves_the_decision_to_exact_arithmetic() {
    // The squares of the central ray, (0, 0, -2^-520), are subnormal beside a viewport of 1.
    let lens = crate::scene::camera::Lens::Viewport { vw: 1.0, vh: 1.0, distance: 2f64.powi(-520) };
    let mut rng = Rng(6);
    for n in 0..200 {
        let [x, y, _] = vector(&mut rng, 1.0);
        let radius = x.hypot(y) * (1.0 + f64::from(n % 2 * 2 - 1) * 2f64.powi(-40));
        let truth = judge(Camera { lens, ..Camera::CANONICAL }, [1, 1], &[([x, y, -5.0], radius)]).pixel(0, 0);
        assert_eq!(truth.is_some(), n % 2 == 1, "{x:e} {y:e}");
    }
}

#[test]
fn powers_of_two_scale_the_answer_exactly() {
    let mut rng = Rng(2);
    let scene = random_scene(&mut rng, 1.0);
    scaled_by_powers_of_two(&scene);
    let lens = crate::scene::camera::Lens::Orthographic { height: 1.7 };
    scaled_by_powers_of_two(&Scene { camera: Camera { lens, ..scene.camera }, ..scene });
}

fn scaled_by_powers_of_two(scene: &Scene) {
    let whole = Judge::new(scene).expect("a scene");
    for k in [-300, -33, 7, 400] {
        let factor = 2f64.powi(k);
        let mut scaled = scene.clone();
        if let crate::scene::camera::Lens::Orthographic { height } = &mut scaled.camera.lens {
            *height *= factor;
        }
        scaled.camera.eye *= factor;
        if let Look::At(at) = &mut scaled.camera.look {
            *at *= factor;
        }
        for (center, radius) in scaled.spheres.centers.to_mut().iter_mut().zip(scaled.spheres.radii.to_mut()) {
            (*center, *radius) = (center.map(|x| x * factor), *radius * factor);
        }
        let scaled = Judge::new(&scaled).expect("a scaled scene");
        for (i, j) in pixels(scene) {
            let expected = whole.pixel(i, j).map(|truth| Truth {
                t: truth.t * factor,
                distance: truth.distance * factor,
                depth: truth.depth * factor,
                position: truth.position.map(|x| x * factor),
                ..truth
            });
            assert_eq!(scaled.pixel(i, j), expected, "2^{k}");
        }
    }
}

#[test]
fn the_order_of_the_spheres_matters_only_to_ties() {
    let mut rng = Rng(3);
    let scene = random_scene(&mut rng, 1.0);
    let judge = Judge::new(&scene).expect("a scene");
    let count = scene.spheres.len() as u32;
    let mut shuffled: Vec<u32> = (0..count).collect();
    for (i, j) in pixels(&scene) {
        for n in (1..shuffled.len()).rev() {
            shuffled.swap(n, rng.bits() as usize % (n + 1));
        }
        assert_eq!(judge.among(i, j, &shuffled), judge.pixel(i, j));
        assert_eq!(judge.among(i, j, &[count, u32::MAX]), None, "no such spheres");
    }
}

#[test]
fn a_given_ray_agrees_with_the_pixel_that_it_passes() {
    let mut rng = Rng(4);
    let mut scene = random_scene(&mut rng, 1.0);
    scene.camera = Camera { eye: scene.camera.eye, ..Camera::CANONICAL };
    scene.image = ImagePlane { width: 8, height: 8, ..ImagePlane::default() };
    let judge = Judge::new(&scene).expect("a scene");
    for (i, j) in pixels(&scene) {
        let direction = [(f64::from(j) + 0.5) / 8.0 - 0.5, -(f64::from(i) + 0.5) / 8.0 + 0.5, -1.0];
        let ray = judge_ray(scene.camera.eye.to_array(), direction, &scene.spheres);
        assert_eq!(ray.map(|truth| Truth { depth: truth.t, ..truth }), judge.pixel(i, j));
    }
    assert_eq!(judge_ray([0.0; 3], [0.0; 3], &scene.spheres), None);
    assert_eq!(judge_ray([f64::NAN; 3], [1.0; 3], &scene.spheres), None);
    let bad = Spheres {
        centers: vec![[0.0, 0.0, 3.0]; 3].into(),
        radii: vec![f64::NAN, -1.0, 1.0].into(),
        colors: None,
        materials: None,
        opacities: None,
        cuts: None,
    };
    assert_eq!(judge_ray([0.0; 3], [0.0, 0.0, 1.0], &bad).map(|truth| (truth.id, truth.t)), Some((2, 2.0)));
}

#[test]
fn rows_may_be_judged_in_parallel() {
    let scene = random_scene(&mut Rng(7), 1.0);
    let judge = Judge::new(&scene).expect("a scene");
    let row = |i: u32| -> Vec<_> { (0..scene.image.width).map(|j| judge.pixel(i, j)).collect() };
    let together: Vec<_> = (0..scene.image.height).into_par_iter().map(row).collect();
    assert_eq!(together, (0..scene.image.height).map(row).collect::<Vec<_>>());
}

#[test]
fn the_error_of_a_t_is_exact() {
    let balls = [([0.0, 0.0, -5.0], 1.0), ([0.0, 2.0, -5.0], 1.0), ([0.0, 0.0, -1.0], 1.0)];
    let judge = judge(Camera::CANONICAL, [1, 1], &balls);
    let error = |id, root, t| judge.relative_error_of_t(0, 0, id, root, t);
    assert_eq!((error(0, Root::Near, 4.0), error(0, Root::Far, 6.0)), (0.0, 0.0));
    assert_eq!(error(0, Root::Near, 4.0 + 4.0 * f64::EPSILON), f64::EPSILON);
    assert_eq!(error(0, Root::Far, 3.0), -0.5);
    assert!(error(0, Root::Near, f64::NEG_INFINITY) == f64::INFINITY && error(0, Root::Near, f64::NAN).is_nan());
    assert!(error(1, Root::Near, 4.0).is_nan() && judge.t(0, 0, 1, Root::Near).is_none(), "a miss");
    assert_eq!((error(2, Root::Near, 0.0), error(2, Root::Near, 1e-300)), (0.0, f64::INFINITY));
    assert_eq!(judge.t(0, 0, 0, Root::Far), Some([6.0, 0.0]));
    assert_eq!(judge.t(0, 0, 7, Root::Far), None);
}

#[test]
fn the_ends_of_the_range_are_judged_too() {
    let far = |x: f64| {
        judge_ray(
            [-x, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            &Spheres {
                centers: vec![[x, 0.0, 0.0]].into(),
                radii: vec![x / 2.0].into(),
                colors: None,
                materials: None,
                opacities: None,
                cuts: None,
            },
        )
    };
    for x in [1e-300, 1e300, 1.7e308, 4e-320] {
        let truth = far(x).expect("a hit");
        assert_eq!(truth.position, [x / 2.0, 0.0, 0.0], "{x:e}");
        assert_eq!(truth.normal, [-1.0, 0.0, 0.0]);
    }
    // A radius of 1e-300 grazed at 1e-316 beside a centre 1e300 away: thousands of bits.
    for (r, hit) in [(1e-300, true), (1e-300f64.next_down(), false)] {
        let spheres = Spheres {
            centers: vec![[1e300, 1e-300, 0.0]].into(),
            radii: vec![r].into(),
            colors: None,
            materials: None,
            opacities: None,
            cuts: None,
        };
        let truth = judge_ray([0.0; 3], [1e-300, 0.0, 0.0], &spheres);
        assert_eq!(truth.map(|truth| truth.tangent), hit.then_some(true));
    }
}
