//! Parallel rays against answers known by construction and against given rays.

use super::*;
use crate::scene::camera::Lens;

/// Looks along (3, 4, 0) with z up, so that alpha = beta = 5, and right is (4, -3, 0)/5. Nine pixels with a pitch of 1.
fn slanted(eye: [f64; 3], balls: &[Sphere]) -> Judge {
    let look = Look::View([3.0, 4.0, 0.0].into());
    let lens = Lens::Orthographic { height: 3.0 };
    judge(Camera { eye: eye.into(), look, up: [0.0, 0.0, 1.0].into(), lens }, [3, 3], balls)
}

/// The eye of [`slanted`], m times the view, right times 5 s and up z from it.
fn from_eye(m: f64, s: f64, z: f64) -> [f64; 3] {
    [5.0 + 3.0 * m + 4.0 * s, -7.0 + 4.0 * m - 3.0 * s, 11.0 + z]
}

const EYE: [f64; 3] = [5.0, -7.0, 11.0];

#[test]
fn a_parallel_ray_agrees_with_a_given_ray() {
    let mut rng = Rng(11);
    let mut hits = 0;
    for height in [0.5, 8.0, 1024.0, 2.0, 4.0, 8.0] {
        let mut scene = random_scene(&mut rng, 1.0);
        let lens = Lens::Orthographic { height };
        scene.camera = Camera { eye: [0.25, -0.5, 2.0].into(), lens, ..Camera::CANONICAL };
        scene.image = ImagePlane { width: 8, height: 8, ..ImagePlane::default() };
        let judge = Judge::new(&scene).expect("a scene");
        for (i, j) in pixels(&scene) {
            let [u, v] = [f64::from(j) + 0.5 - 4.0, 4.0 - 0.5 - f64::from(i)].map(|n| n * height / 8.0);
            let ray = judge_ray([0.25 + u, v - 0.5, 2.0], [0.0, 0.0, -1.0], &scene.spheres);
            assert_eq!(ray.map(|truth| Truth { depth: truth.t, ..truth }), judge.pixel(i, j), "row {i}, column {j}");
            hits += usize::from(ray.is_some());
        }
    }
    assert!(hits > 30, "{hits} hits");
}

#[test]
fn tangency_and_what_is_an_ulp_off_it() {
    // The ray of row 0, column 2 starts at right + up: 5 s - 1 = 4 and z - 1 = 3 have the norm 5.
    for m in [3.0, 1000.0, 2f64.powi(40)] {
        let center = from_eye(m, 1.0, 4.0);
        let touch = slanted(EYE, &[(center, 5.0)]).pixel(0, 2).expect("the touch");
        assert!(
            touch.tangent && touch.t == 5.0 * m && touch.depth == touch.t && touch.distance == touch.t,
            "{touch:?}"
        );
        // Both are rounded: of the normal (-4 U - 3 V)/5 with U = (4, -3, 0)/5.
        for (got, known) in touch.normal.into_iter().zip([-16.0 / 25.0, 12.0 / 25.0, -3.0 / 5.0]) {
            assert!((got - known).abs() <= f64::EPSILON, "{touch:?}");
        }
        assert_eq!(slanted(EYE, &[(center, 5f64.next_down())]).pixel(0, 2), None, "{m}");
        assert!(!slanted(EYE, &[(center, 5f64.next_up())]).pixel(0, 2).expect("a cut").tangent, "{m}");
    }
    // Shifts that double-doubles lose beside a discriminant of 25.
    for k in 40..130 {
        let shift = 2f64.powi(-k);
        let see = |eye: [f64; 3]| {
            let truth = slanted(eye, &[([12.0 + 4.0, 16.0 - 3.0, 4.0], 5.0)]).pixel(0, 2);
            truth.map(|truth| truth.tangent)
        };
        assert_eq!(see([0.0; 3]), Some(true));
        assert_eq!(see([0.0, 0.0, shift]), Some(false), "nearer the middle: 2^-{k}");
        assert_eq!(see([0.0, 0.0, -shift]), None, "past the edge: 2^-{k}");
        assert_eq!(see([3.0 * shift, 4.0 * shift, 0.0]), Some(true), "along the ray: 2^-{k}");
    }
}

#[test]
fn ties_go_to_the_lower_index() {
    // The ray of row 0, column 2 starts at right + up. All spheres pass through the point 4 views from there: as a
    // touch, from the front (3 aside, 4 of depth), and from inside (4 aside, 3 of depth).
    let balls =
        [(from_eye(4.0, 1.0, 4.0), 5.0), (from_eye(4.8, 1.0, -2.0), 41f64.sqrt()), (from_eye(4.8, 0.8, 1.0), 5.0)];
    assert_eq!(slanted(EYE, &balls[..1]).pixel(0, 2).expect("the touch").t, 20.0);
    // 4.8, 0.8 and the root are rounded, so these two are not ties, and the order of the list has no effect.
    for n in [1, 2] {
        let [ahead, back] = [[0, n], [n, 0]].map(|order| {
            let id = slanted(EYE, &order.map(|k: usize| balls[k])).pixel(0, 2).expect("a hit").id;
            order[id as usize]
        });
        assert_eq!(ahead, back, "{n}");
    }
    // The rays of the middle column start at up: exact ties from the front, by a touch, and, nearer, at 2 views.
    let along = [(from_eye(5.0, 0.0, 1.0), 5.0), (from_eye(4.0, 1.0, 1.0), 5.0), (from_eye(3.0, 0.0, 1.0), 5.0)];
    for first in 0..3 {
        for second in (0..3).filter(|second| *second != first) {
            let truth = slanted(EYE, &[along[first], along[second]]).pixel(0, 1).expect("a hit");
            let nearer = first == 2 || second == 2;
            assert_eq!(truth.t, if nearer { 10.0 } else { 20.0 });
            assert_eq!(truth.id, u32::from(second == 2), "{first} {second}: {truth:?}");
        }
    }
}

#[test]
fn the_plane_of_the_eye_is_where_rays_begin() {
    // A sphere around the eye: from inside, its far side; from its surface, only points ahead.
    let see = |center: [f64; 3], r: f64| slanted(EYE, &[(center, r)]).pixel(1, 1);
    let inside = see(EYE, 2.0).expect("inside");
    assert_eq!((inside.root, inside.t), (Root::Far, 2.0));
    assert_eq!(see(from_eye(-1.0, 0.0, 0.0), 5.0), None, "t = 0 is not a hit");
    let far = see(from_eye(1.0, 0.0, 0.0), 5.0).expect("looking in");
    assert_eq!((far.root, far.t), (Root::Far, 10.0));
    assert_eq!(see(from_eye(-1.0, 0.0, 0.0), 5f64.next_up()).map(|truth| truth.root), Some(Root::Far));
    // The eye itself is inside, but the ray a unit to the right of it starts outside, and hits the sphere ahead.
    let ball = (from_eye(0.125, 0.0, 0.0), 0.75);
    assert_eq!(slanted(EYE, &[ball]).pixel(1, 1).map(|truth| truth.root), Some(Root::Far));
    assert_eq!(slanted(EYE, &[ball]).pixel(1, 2), None);
    let wide = (from_eye(1.0, 0.0, 0.0), 5.05);
    assert_eq!(slanted(EYE, &[wide]).pixel(1, 1).map(|truth| truth.root), Some(Root::Far), "the eye is inside");
    assert_eq!(slanted(EYE, &[wide]).pixel(1, 2).map(|truth| truth.root), Some(Root::Near), "this origin is not");
}
