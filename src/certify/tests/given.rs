//! The bounds of given rays in f64 hold against exact arithmetic where roundings are at their worst, and their terms
//! are needed.

use crate::certify::given::{CertifiedRay, GIVEN_TERMS, GivenTerms};
use crate::double_double as dd;
use crate::exact::{Root, judge_ray};
use crate::scene::{Ball, Spheres};
use crate::testing::Rng;
use crate::view::placement::Placement;
use glam::DVec3;

struct Case {
    center: [f64; 3],
    radius: f64,
    origin: [f64; 3],
    direction: [f64; 3],
}

fn vector(random: &mut Rng) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| random.between(-1.0, 1.0)))
}

/// One ray and one sphere of family `kind`: from afar and tangent but for roundings, or for `off` of the radius; from
/// points on the surface or just beside it; from near the middle; from anywhere.
fn case(random: &mut Rng, kind: usize, off: f64) -> Case {
    let center = vector(random) * 10.0;
    let radius = random.between(0.5, 2.0);
    let (out, other) = (vector(random).normalize(), vector(random).normalize());
    let perpendicular = out.cross(other).normalize();
    let (origin, direction) = match kind {
        0 => {
            let origin = center + out * 10f64.powf(random.between(0.5, 7.0));
            // The tangent of the sphere in the plane of `out` and `perpendicular`.
            let distance = (origin - center).length();
            let sine = radius / distance;
            let rim = perpendicular * (1.0 - sine * sine).sqrt() + out * sine;
            let touch = center + rim * radius * (1.0 + random.between(-4.0, 4.0) * (1e-16 * distance + off));
            (origin, touch - origin)
        }
        1 => {
            let height = [0.0, 1e-16, -1e-16, 1e-12, -1e-9, off, -off][random.bits() as usize % 7];
            (center + out * radius * (1.0 + height), perpendicular + out * random.between(-1e-3, 1e-3))
        }
        2 => (center + out * radius * 10f64.powf(random.between(-20.0, -1.0)), other),
        _ => (center + other * random.between(0.0, 30.0), vector(random)),
    };
    let scale = 10f64.powf(random.between(-3.0, 3.0));
    Case { center: center.to_array(), radius, origin: origin.to_array(), direction: (direction * scale).to_array() }
}

/// Errors of a ray: of its start, in the tree's unit, and of its direction, relative to its length.
type Off = [f64; 2];

/// Compares the bounds with these terms with exact arithmetic, for rays with errors of `blur` and `tilt`. Returns the
/// number of false claims among `count` cases of a family, and the largest error of a t over its bound.
fn false_claims(terms: &GivenTerms, kind: usize, count: usize, [blur, tilt]: Off) -> (usize, f64) {
    let random = &mut Rng(5 + kind as u64);
    let (mut wrong, mut worst) = (0, 0.0f64);
    for _ in 0..count {
        let Case { center, radius, origin, direction } = case(random, kind, 2.0 * blur + tilt);
        let mut spheres = Spheres::default();
        spheres.push(center, radius, None);
        let truth = judge_ray(origin, direction, &spheres);
        let placement = Placement::new(&spheres.centers, &spheres.radii);
        let length = DVec3::from_array(direction).length();
        let moved = DVec3::from_array(direction) + vector(random).normalize() * (0.99 * tilt * length);
        let moved = if tilt > 0.0 { moved.to_array() } else { direction };
        let offset = (vector(random).normalize() * (0.99 * blur)).to_array();
        let ray = CertifiedRay::new(&placement, origin, moved, f64::INFINITY);
        let ray = if blur + tilt > 0.0 { ray.offset_by(offset, blur, tilt) } else { ray };
        let claim = ray.intersect_by(terms, Ball { center, radius });
        let right = match (&truth, &claim) {
            (Some(_), None) => false,
            (None, Some(bounds)) => !bounds.sure,
            (None, None) => true,
            (Some(truth), Some(bounds)) => {
                let [low, high, t] = [bounds.low, bounds.high, bounds.t].map(|t| dd::ldexp(t, ray.shift));
                let root = if bounds.outside { Root::Near } else { Root::Far };
                let off = (t - truth.t).abs() - f64::EPSILON * truth.t;
                if bounds.sure && off > 0.0 {
                    worst = worst.max(off / (high - t).max(t - low));
                }
                // The judge rounds its t once.
                let holds = low <= truth.t.next_up() && high >= truth.t.next_down();
                holds && (!bounds.sure || root == truth.root)
            }
        };
        wrong += usize::from(!right);
    }
    (wrong, worst)
}

const COUNT: usize = 20_000;

/// Errors far larger than the few roundings of rays from surfaces, so that no other error counts.
const BLURRED: Off = [1e-9, 0.0];
const TILTED: Off = [0.0, 1e-9];

#[test]
fn bounds_hold_at_their_worst() {
    for kind in 0..4 {
        for off in [[0.0, 0.0], BLURRED, TILTED, [1e-9, 1e-9]] {
            let (wrong, worst) = false_claims(&GIVEN_TERMS, kind, COUNT, off);
            println!("family {kind}, off by {off:?}: {COUNT} rays, {wrong} wrong, worst error {worst:.3} of its bound");
            assert_eq!(wrong, 0, "family {kind}, off by {off:?}");
            assert!(worst <= 1.0, "family {kind}, off by {off:?}: {worst}");
        }
    }
}

#[test]
fn terms_of_the_bounds_are_needed() {
    // The others are derived only: wherever roundings reach `squares` or `quotient`, another term is larger, and no
    // power of points in f64 comes as near to zero as `power_dd`.
    let [blur, tilt] = [GIVEN_TERMS.blur, GIVEN_TERMS.tilt];
    let without = [
        ("cross", GivenTerms { cross: 0.0, ..GIVEN_TERMS }, [0.0, 0.0]),
        ("power", GivenTerms { power: 0.0, ..GIVEN_TERMS }, [0.0, 0.0]),
        ("blur of p x d", GivenTerms { blur: [0.0, blur[1]], ..GIVEN_TERMS }, BLURRED),
        ("blur of |p|^2", GivenTerms { blur: [blur[0], 0.0], ..GIVEN_TERMS }, BLURRED),
        ("tilt of p x d", GivenTerms { tilt: [0.0, tilt[1]], ..GIVEN_TERMS }, TILTED),
        ("tilt of |d|^2", GivenTerms { tilt: [tilt[0], 0.0], ..GIVEN_TERMS }, TILTED),
    ];
    for (name, terms, off) in without {
        let wrong: usize = (0..4).map(|kind| false_claims(&terms, kind, COUNT, off).0).sum();
        println!("without {name}: {wrong} wrong");
        assert!(wrong > 0, "without {name} no claim is false");
    }
}
