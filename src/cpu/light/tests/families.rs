//! Scenes whose rays to lights are hard: tangent, touching, nested, far, small, large.

use crate::exact::{Toward, Truth};
use crate::scene::camera::{Camera, Lens, Look};
use crate::scene::{ImagePlane, Scene, Spheres};
use crate::testing::Rng;
use glam::DVec3;

/// A kind of scenes.
#[derive(Clone, Copy)]
pub(crate) struct Family {
    pub(crate) name: &'static str,
    pub(crate) seed: u64,
    /// The most rays from a point.
    pub(crate) most: usize,
    pub(crate) make: fn(&mut Rng) -> (Scene, Vec<Aim>),
}

/// The target of a ray from a hit.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Aim {
    Fixed(Toward),
    /// Any direction, in units of any length.
    Anywhere,
    /// The same up to a reach of about this length.
    Within(f64),
    /// Along the surface but for a few roundings.
    Grazing,
    /// A point near the hit, at about this distance.
    Near(f64),
}

impl Aim {
    pub(crate) fn at(&self, random: &mut Rng, hit: &Truth) -> Toward {
        let (normal, position) = (DVec3::from_array(hit.normal), DVec3::from_array(hit.position));
        match *self {
            Self::Fixed(toward) => toward,
            Self::Anywhere => Toward::Direction((direction(random) * random.decade(-3.0, 3.0)).to_array()),
            Self::Within(reach) => {
                let length = random.decade(-3.0, 3.0);
                let direction = (direction(random) * length).to_array();
                Toward::Within { direction, reach: reach / length * random.decade(-1.0, 1.0) }
            }
            Self::Grazing => {
                let along = normal.cross(direction(random)).normalize();
                Toward::Direction((along + normal * random.between(-3e-16, 3e-16)).to_array())
            }
            Self::Near(distance) => {
                Toward::Point((position + direction(random) * distance * random.decade(-3.0, 1.0)).to_array())
            }
        }
    }
}

fn direction(random: &mut Rng) -> DVec3 {
    loop {
        let v = DVec3::from_array(std::array::from_fn(|_| random.between(-1.0, 1.0)));
        if v.length_squared() > 1e-3 && v.length_squared() <= 1.0 {
            return v.normalize();
        }
    }
}

/// A camera at `eye` toward `at` that sees this many degrees.
fn camera(eye: DVec3, at: DVec3, degrees: f64) -> Camera {
    Camera {
        eye,
        look: Look::View(at - eye),
        up: DVec3::new(0.1, 1.0, 0.2),
        lens: Lens::Vfov { degrees, distance: 1.0 },
    }
}

fn scene(camera: Camera, balls: &[(DVec3, f64)]) -> Scene {
    let mut spheres = Spheres::default();
    for (center, radius) in balls {
        spheres.push(center.to_array(), *radius, None);
    }
    let image = ImagePlane { width: 8, height: 8, background: [0.0; 3] };
    Scene { camera, image, spheres, lighting: Default::default() }
}

fn cloud(random: &mut Rng, at: DVec3, unit: f64) -> Vec<(DVec3, f64)> {
    (0..12)
        .map(|_| (at + direction(random) * unit * random.between(0.0, 4.0), unit * random.between(0.2, 1.5)))
        .collect()
}

/// Spheres of radius `unit` that touch their neighbours, exactly where `unit` is a power of two.
fn lattice(at: DVec3, unit: f64) -> Vec<(DVec3, f64)> {
    let place = |n: i32| DVec3::new(f64::from(n % 3 - 1), f64::from(n / 3 % 3 - 1), f64::from(n / 9 - 1));
    (0..27).map(|n| (at + place(n) * 2.0 * unit, unit)).collect()
}

/// Random directions, points, and rays along the surface, in a scene of this size.
fn aims(size: f64) -> Vec<Aim> {
    vec![Aim::Anywhere, Aim::Within(size), Aim::Grazing, Aim::Near(size)]
}

fn clouds(random: &mut Rng) -> (Scene, Vec<Aim>) {
    let unit = random.decade(-20.0, 20.0);
    let balls = cloud(random, DVec3::ZERO, unit);
    (scene(camera(direction(random) * 12.0 * unit, DVec3::ZERO, 40.0), &balls), aims(unit))
}

fn far_from_the_origin(random: &mut Rng) -> (Scene, Vec<Aim>) {
    let at = direction(random) * 1e9;
    let balls = cloud(random, at, 1.0);
    (scene(camera(at + direction(random) * 12.0, at, 40.0), &balls), aims(1.0))
}

/// Lights along the axes graze whole rows of spheres; points lie where spheres touch, in their middles and on surfaces.
fn touching(random: &mut Rng) -> (Scene, Vec<Aim>) {
    let unit = 2f64.powi(random.below(120) as i32 - 60);
    let eye = DVec3::new(random.between(-9.0, 9.0), random.between(-9.0, 9.0), random.sign() * 12.0) * unit;
    let mut all = aims(unit);
    all.extend([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, 1.0, 0.0]].map(|d| Aim::Fixed(Toward::Direction(d))));
    let points = [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [5.0, 1.0, 0.0]];
    all.extend(points.map(|p| Aim::Fixed(Toward::Point(p.map(|x| x * unit)))));
    (scene(camera(eye, DVec3::ZERO, 40.0), &lattice(DVec3::ZERO, unit)), all)
}

/// Hits with coordinates that are exact, whose rays to the lights are tangent to neighbours or pass where they touch: a parallel
/// camera over touching spheres.
fn tangent(random: &mut Rng) -> (Scene, Vec<Aim>) {
    let unit = 2f64.powi(random.below(60) as i32 - 30);
    let look = Look::View(DVec3::new(0.0, 0.0, -1.0));
    let lens = Lens::Orthographic { height: 8.0 * unit };
    let camera = Camera { eye: DVec3::new(0.5, 0.5, 16.0) * unit, look, up: DVec3::Y, lens };
    let directions = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [-1.0, 1.0, 0.0], [3.0, 0.0, 4.0]];
    let mut all: Vec<Aim> = directions.map(|d| Aim::Fixed(Toward::Direction(d))).to_vec();
    all.extend([Aim::Fixed(Toward::Point([4.0 * unit, 0.0, 3.0 * unit])), Aim::Grazing]);
    (scene(camera, &lattice(DVec3::ZERO, unit)), all)
}

/// Shells around each other, some apart by a rounding, seen from outside, from between, and from within.
fn nested(random: &mut Rng) -> (Scene, Vec<Aim>) {
    let unit = random.decade(-10.0, 10.0);
    let mut balls: Vec<(DVec3, f64)> =
        [0.5, 1.0, 1.0 + 1e-15, 1.0 + 1e-9, 2.0, 2.0, 4.0].map(|r| (DVec3::ZERO, r * unit)).to_vec();
    balls.truncate(2 + random.below(6) as usize);
    // Shells that touch from within.
    balls.push((DVec3::new(0.0, 0.0, unit), unit));
    balls.push((DVec3::new(0.25 * unit, 0.0, 0.0), 0.125 * unit));
    let eye = direction(random) * unit * [0.1, 0.75, 1.5, 3.0, 6.0][random.below(5) as usize];
    let mut all = aims(unit);
    all.extend([2.0, 1.0, 0.5, 4.0].map(|x| Aim::Fixed(Toward::Point([x * unit, 0.0, 0.0]))));
    (scene(camera(eye, DVec3::ZERO, 100.0), &balls), all)
}

/// From inside a large sphere with small ones in it.
fn inside(random: &mut Rng) -> (Scene, Vec<Aim>) {
    let mut balls = cloud(random, DVec3::ZERO, 1.0);
    balls.push((DVec3::ZERO, 8.0));
    (scene(camera(direction(random) * 6.0, DVec3::ZERO, 90.0), &balls), aims(8.0))
}

/// The ground of a planet beside small things on it, with lights at the horizon.
fn planet(random: &mut Rng) -> (Scene, Vec<Aim>) {
    let radius = 6.4e6;
    let mut balls = vec![(DVec3::new(0.0, -radius, 0.0), radius)];
    balls.extend((0..8).map(|_| {
        let r = random.decade(-2.0, 1.0);
        (DVec3::new(random.between(-30.0, 30.0), r * random.between(0.5, 1.0), random.between(-60.0, -5.0)), r)
    }));
    let mut all = vec![Aim::Anywhere, Aim::Grazing];
    all.extend([[1.0, 0.0, -0.5], [1.0, 1e-9, 0.0]].map(|d| Aim::Fixed(Toward::Direction(d))));
    all.push(Aim::Fixed(Toward::Point([1e8, 1.0, -1e9])));
    (scene(camera(DVec3::new(0.0, 1.7, 0.0), DVec3::new(0.0, 0.5, -20.0), 50.0), &balls), all)
}

/// Through a long lens, from a hundred million radii away.
fn long_lens(random: &mut Rng) -> (Scene, Vec<Aim>) {
    let balls = cloud(random, DVec3::ZERO, 1.0);
    (scene(camera(direction(random) * random.decade(6.0, 9.0), DVec3::ZERO, 1e-6), &balls), aims(1.0))
}

/// Sizes from 1e-20 to 1e20 in one scene, each beside the next, and equal spheres.
fn sizes(random: &mut Rng) -> (Scene, Vec<Aim>) {
    let mut balls = Vec::new();
    let mut at = DVec3::ZERO;
    let (mut size, first) = (1e-20, direction(random));
    while size < 1e20 {
        balls.push((at, size));
        let next = size * random.decade(0.5, 3.0);
        at += (first + 0.3 * direction(random)).normalize() * (size + next);
        size = next;
    }
    let chosen = balls[random.below(balls.len() as u32) as usize];
    balls.push(chosen);
    let eye = chosen.0 + direction(random) * chosen.1 * 3.0;
    (scene(camera(eye, chosen.0, 60.0), &balls), aims(chosen.1))
}

/// All of them.
pub(crate) const FAMILIES: &[Family] = &[
    Family { name: "clouds of 1e-20 to 1e20", seed: 1, most: usize::MAX, make: clouds },
    Family { name: "1e9 from the origin", seed: 2, most: usize::MAX, make: far_from_the_origin },
    Family { name: "touching neighbours", seed: 3, most: usize::MAX, make: touching },
    Family { name: "tangent rays", seed: 4, most: usize::MAX, make: tangent },
    Family { name: "nested shells", seed: 5, most: usize::MAX, make: nested },
    Family { name: "eye inside", seed: 6, most: usize::MAX, make: inside },
    Family { name: "ground of a planet", seed: 7, most: usize::MAX, make: planet },
    Family { name: "long lens", seed: 8, most: usize::MAX, make: long_lens },
    Family { name: "all sizes in one scene", seed: 9, most: usize::MAX, make: sizes },
];
