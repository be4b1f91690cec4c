//! The bounds of mirrored directions and of weights in docs/certificate.md, section 10, against exact numbers.

use crate::certify::given::EPS;
use crate::certify::surface::SurfacePoint;
use crate::dyadic::{self, Dyadic, Dyadic3};
use crate::exact::Toward;
use crate::scene::{Ball, NumberedBall};
use crate::shade::optics::reflected;
use crate::testing::Rng;
use crate::view::placement::Placement;
use crate::view::ray::dot3;
use glam::DVec3;

/// A point that is off by up to `blur` of its radius (in the tree's unit), and the exact one.
struct BlurredPoint {
    placement: Placement,
    point: SurfacePoint,
    exact: Dyadic3,
}

fn unit(random: &mut Rng) -> DVec3 {
    loop {
        let v = DVec3::from_array(std::array::from_fn(|_| random.between(-1.0, 1.0)));
        if v.length() > 0.1 && v.length() <= 1.0 {
            return v.normalize();
        }
    }
}

/// The exact sum of `from` and a vector of a length just below `by`, which is across `from` or has any direction.
fn moved(random: &mut Rng, from: DVec3, by: f64) -> Dyadic3 {
    let direction = if random.bits().is_multiple_of(2) { unit(random).cross(from).normalize() } else { unit(random) };
    let [from, step] = [from, direction * (by * 0.999)].map(|v| dyadic::vector(v.to_array()));
    std::array::from_fn(|n| &from[n] + &step[n])
}

fn blurred_point(random: &mut Rng, blur: f64) -> BlurredPoint {
    let placement = Placement::new(&[[0.0; 3]], &[1.0]);
    let size = placement.radius(1.0);
    let offset = unit(random) * size;
    let exact = moved(random, offset, blur * size);
    let point = SurfacePoint::new(
        NumberedBall { id: 0, ball: Ball { center: [0.0; 3], radius: 1.0 } },
        offset.to_array(),
        blur * size,
        true,
    );
    BlurredPoint { placement, point, exact }
}

/// |a - b| of exact vectors.
fn apart(a: &Dyadic3, b: &Dyadic3) -> f64 {
    let gap = dyadic::minus(a, b);
    dyadic::dot(&gap, &gap).sqrt(64).to_f64()
}

#[test]
fn a_reflected_ray_is_within_its_tilt() {
    let random = &mut Rng(19);
    let mut worst = [0.0f64; 3];
    for n in 0..30_000 {
        let (kind, [blur, tilt]) = (n % 3, [[0.0, 0.0], [1e-10, 1e-15], [1e-13, 1e-10]][n % 3]);
        let BlurredPoint { placement, point, exact: q } = blurred_point(random, blur);
        let along = unit(random);
        let d = moved(random, along, tilt);
        // The direction has the length 1 but for roundings, which count as its tilt.
        let tilt = tilt + 4.0 * EPS;
        let found = reflected(along, DVec3::from_array(point.normal));
        let bound = point.mirrored_tilt(&placement, tilt);
        // d - 2 (d.q) q / |q|^2
        let q2 = dyadic::dot(&q, &q);
        let dq = dyadic::dot(&d, &q).ldexp(1);
        let expected: Dyadic3 = std::array::from_fn(|k| &d[k] - &(&dq * &q[k]).over(&q2, 128));
        let error = apart(&dyadic::vector(found.to_array()), &expected);
        worst[kind] = worst[kind].max(error / bound);
    }
    println!("reflected directions are off by {worst:.2?} of their tilt at most");
    // A normal that turns by x turns the ray by 2 x, of the 4 x that are derived; and what the direction is off by remains.
    assert!(worst.iter().all(|x| *x <= 1.0) && worst[1] > 0.4 && worst[2] > 0.8, "{worst:?}");
}

#[test]
fn a_cosine_is_within_its_bound() {
    let random = &mut Rng(20);
    let mut worst = [0.0f64; 2];
    for n in 0..20_000 {
        let blur = [0.0, 1e-10][n % 2];
        let BlurredPoint { placement, point, exact: q } = blurred_point(random, blur);
        let toward = unit(random) * 10f64.powf(random.between(-3.0, 3.0));
        let light = [Toward::Direction(toward.to_array()), Toward::Point((toward * 4.0).to_array())][n / 2 % 2];
        let Some(ray) = point.ray(&placement, &light) else { continue };
        // The light in the tree's unit, in which q is.
        let l = match light {
            Toward::Point(place) => {
                let place = place.map(|x| &Dyadic::of(x) * &Dyadic::of(placement.radius(1.0)));
                dyadic::minus(&place, &q)
            }
            _ => dyadic::vector(toward.to_array()),
        };
        let lengths = (&dyadic::dot(&q, &q) * &dyadic::dot(&l, &l)).sqrt(128);
        let expected = dyadic::dot(&q, &l).over(&lengths, 128);
        let error = (&Dyadic::of(point.cosine(&ray).0) - &expected).abs().to_f64();
        let bound = ray.tilt + ray.blur / dot3(point.offset, point.offset).sqrt() + 12.0 * EPS;
        worst[n % 2] = worst[n % 2].max(error / bound);
    }
    println!("cosines are off by {worst:.2?} of their bound at most");
    assert!(worst.iter().all(|x| *x <= 1.0) && worst[1] > 0.3, "{worst:?}");
}
