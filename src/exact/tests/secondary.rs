//! Lights from hits: cases known by construction, and random ones where f64 is certain.

use super::{Sphere, judge, slanted};
use crate::exact::{Toward, judge_ray};
use crate::scene::Spheres;
use crate::scene::camera::{Camera, Lens, Look};
use crate::testing::Rng;
use glam::DVec3;

/// Whether lights are hidden at the hit of the ray (0, 0, -1): the first ball stands at (0, 0, -5) with radius 1, so the hit is
/// (0, 0, -4) and its normal (0, 0, 1).
fn hidden(others: &[Sphere], lights: &[Toward]) -> Vec<bool> {
    let balls: Vec<Sphere> = [([0.0, 0.0, -5.0], 1.0)].iter().chain(others).copied().collect();
    judge(Camera::CANONICAL, [1, 1], &balls).hidden(0, 0, lights).expect("a hit")
}

/// hit + by
fn at(by: [f64; 3]) -> [f64; 3] {
    [by[0], by[1], by[2] - 4.0]
}

fn toward(direction: [f64; 3]) -> Toward {
    Toward::Direction(direction)
}

#[test]
fn a_surface_hides_what_is_behind_it_and_what_grazes_it() {
    let lights = [[0.0, 0.0, 1.0], [1.0, 0.0, f64::MIN_POSITIVE], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]].map(toward);
    assert_eq!(hidden(&[], &lights), [false, false, true, true]);
    // Points: in front, on the tangent plane, inside the sphere, behind it, and the hit itself.
    let points = [[0.0, 0.0, 1e-300], [1.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, -9.0], [0.0; 3]];
    assert_eq!(hidden(&[], &points.map(|p| Toward::Point(at(p)))), [false, true, true, true, false]);
}

#[test]
fn a_tangent_blocker_hides_and_one_a_step_smaller_does_not() {
    let blocker = at([3.0, 1.0, 3.0]);
    let along = [1.0, 0.0, 1.0];
    assert_eq!(hidden(&[(blocker, 1.0)], &[toward(along)]), [true]);
    assert_eq!(hidden(&[(blocker, 1f64.next_down())], &[toward(along)]), [false]);
    // The light before, at and behind the point of contact.
    let points = [2.0, 3.0, 3.0000000000000004, 4.0].map(|s| Toward::Point(at([s, 0.0, s])));
    assert_eq!(hidden(&[(blocker, 1.0)], &points), [false, false, true, true]);
    let within = [3.0, 3f64.next_up()].map(|reach| Toward::Within { direction: along, reach });
    assert_eq!(hidden(&[(blocker, 1.0)], &within), [false, true]);
}

#[test]
fn blockers_count_between_hit_and_light() {
    // Behind the hit, around the hit, around the light, around both, and pierced before the light.
    let light = [Toward::Point(at([0.0, 0.0, 8.0])), toward([0.0, 0.0, 1.0])];
    let around = |z: f64, r: f64| hidden(&[(at([0.0, 0.0, z]), r)], &light);
    assert_eq!(around(-20.0, 5.0), [false, false]);
    assert_eq!(around(3.0, 2.0), [true, true]);
    assert_eq!(around(8.0, 1.0), [true, true], "the light is inside");
    assert_eq!(around(9.0, 1.0), [false, true], "the light is on the near side");
    assert_eq!(around(7.0, 1.0), [true, true], "the light is on the far side");
    assert_eq!(around(20.0, 1.0), [false, true]);
}

/// The hit is also on another sphere: outside it, inside it, and beside it.
#[test]
fn spheres_that_touch_the_hit_hide_what_they_cover() {
    let up = [toward([0.0, 0.0, 1.0]), toward([1.0, 0.0, 1e-9])];
    assert_eq!(hidden(&[(at([0.0, 0.0, 2.0]), 2.0)], &up), [true, true]);
    let points = [1.0, 4.0, 5.0].map(|z| Toward::Point(at([0.0, 0.0, z])));
    assert_eq!(hidden(&[(at([0.0, 0.0, 2.0]), 2.0)], &points), [false, false, true]);
    // It touches from inside the hit sphere: never in the way.
    assert_eq!(hidden(&[(at([0.0, 0.0, -0.5]), 0.5)], &up), [false, false]);
    // Its surface passes through the hit at right angles.
    let adjacent = (at([3.0, 0.0, 0.0]), 3.0);
    let lights = [[1.0, 0.0, 1.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 1.0]].map(toward);
    assert_eq!(hidden(&[adjacent], &lights), [true, false, false]);
}

/// From inside, the sphere itself hides the sky and everything outside it.
#[test]
fn a_hit_from_inside_sees_what_is_inside() {
    let judge = judge(Camera::CANONICAL, [1, 1], &[([0.0, 0.0, 0.0], 4.0), ([0.0, 0.0, -2.0], 0.5)]);
    // The inner ball is hit first; without it the far side of the outer one.
    let outer = super::judge(Camera::CANONICAL, [1, 1], &[([0.0, 0.0, 0.0], 4.0)]);
    let points = [[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [0.0, 0.0, 4.1], [3.0, 0.0, 0.0], [0.0, 0.0, -4.0]];
    let lights = points.map(Toward::Point);
    assert_eq!(outer.hidden(0, 0, &lights), Some(vec![false, false, true, false, false]));
    assert_eq!(outer.hidden(0, 0, &[toward([0.0, 0.0, 1.0])]), Some(vec![true]), "the sky is closed");
    let near = Toward::Within { direction: [0.0, 0.0, 1.0], reach: 8.0 };
    let far = Toward::Within { direction: [0.0, 0.0, 1.0], reach: 8f64.next_up() };
    assert_eq!(outer.hidden(0, 0, &[near, far]), Some(vec![false, true]));
    assert_eq!(judge.hidden(0, 0, &lights), Some(vec![false, false, true, false, true]));
}

/// A camera with irrational axes: a light is hidden where the judge's own ray from beside the hit says so, unless that is
/// too near to tell.
#[test]
fn irrational_hits_agree_with_rays_from_nearby_points() {
    let mut random = Rng(15);
    let (mut decided, mut blocked) = (0, 0);
    for _ in 0..30 {
        let mut number = |size: f64| random.between(-size, size);
        let balls: Vec<Sphere> =
            (0..12).map(|_| ([number(4.0), number(4.0), number(4.0)], 1.0 + number(0.4))).collect();
        let camera = Camera {
            eye: DVec3::new(9.0, number(1.0), number(1.0)),
            look: Look::View(DVec3::new(-1.0, number(0.2), number(0.2))),
            up: DVec3::new(number(0.1), number(0.1), 1.0),
            lens: Lens::Viewport { vw: 1.0, vh: 1.0, distance: 1.3 },
        };
        let lights: Vec<DVec3> = (0..4).map(|_| DVec3::new(number(6.0), number(6.0), number(6.0))).collect();
        let judge = judge(camera, [5, 5], &balls);
        let mut spheres = Spheres::default();
        balls.iter().for_each(|(center, radius)| spheres.push(*center, *radius, None));
        for (i, j) in (0..5).flat_map(|i| (0..5).map(move |j| (i, j))) {
            let Some(truth) = judge.pixel(i, j) else { continue };
            let points: Vec<Toward> = lights.iter().map(|p| Toward::Point(p.to_array())).collect();
            let exact = judge.hidden(i, j, &points).expect("a hit");
            for (light, exact) in lights.iter().zip(exact) {
                // Two starts beside the surface, and two ends: where all agree, so does the exact answer.
                let (hit, normal) = (DVec3::from_array(truth.position), DVec3::from_array(truth.normal));
                let answers = [1e-9, 1e-7].map(|off| {
                    let from = hit + normal * off;
                    let to = *light - from;
                    normal.dot(to) <= 0.0
                        || judge_ray(from.to_array(), to.to_array(), &spheres).is_some_and(|hit| hit.t < 1.0)
                });
                if answers[0] == answers[1] && normal.dot(*light - hit).abs() > 1e-6 {
                    assert_eq!(exact, answers[0], "{camera:?} {i} {j} {light}");
                    decided += 1;
                    blocked += usize::from(exact);
                }
            }
        }
    }
    println!("{decided} lights, {blocked} hidden");
    assert!(decided > 500 && blocked > 100 && decided - blocked > 100, "{decided} {blocked}");
}

/// An oblique camera and touching spheres: the hit is where they touch, and its coordinates are irrational.
#[test]
fn irrational_contact_is_exact() {
    // The ray of `slanted` runs along (3, 1, 0); at its 2nd multiple two spheres touch.
    let contact = super::from_eye(2.0, [0.0; 3]);
    let ball = |sign: f64, r: f64| ([contact[0] + sign * 3.0 * r, contact[1] + sign * r, contact[2]], r * 10f64.sqrt());
    // The radius is rounded, so the contact is missed by less than an ulp either way; what is beside is not hidden either way.
    let judge = slanted([5.0, -7.0, 11.0], &[ball(1.0, 1.0)]);
    let lights = [toward([-1.0, 0.0, 0.0]), toward([3.0, 1.0, 0.0]), toward([-3.0, -1.0, 0.0])];
    assert_eq!(judge.hidden(0, 2, &lights), Some(vec![false, true, false]));
}
