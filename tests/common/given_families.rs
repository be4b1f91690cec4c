//! Families of given rays at the extremes: spheres, rays and limits.

use crate::rng::Rng;
use glam::DVec3;
use halfline::scene::Spheres;

/// Rays of one kind, and the spheres that they are aimed at.
pub(crate) struct Family {
    pub(crate) name: &'static str,
    pub(crate) spheres: Spheres,
    pub(crate) origins: Vec<[f64; 3]>,
    pub(crate) directions: Vec<[f64; 3]>,
    pub(crate) limits: Vec<f64>,
}

impl Family {
    fn new(name: &'static str, spheres: Spheres) -> Self {
        Self { name, spheres, origins: Vec::new(), directions: Vec::new(), limits: Vec::new() }
    }

    fn ray(&mut self, origin: DVec3, direction: DVec3) {
        let usable = |d: &DVec3| d.is_finite() && *d != DVec3::ZERO;
        self.origins.push(origin.to_array());
        self.directions.push(Some(direction).filter(usable).unwrap_or(DVec3::X).to_array());
        self.limits.push(f64::INFINITY);
    }
}

/// `count` spheres about `at` in a cube of half side `side`, radii `r` to 4 r.
fn cloud(random: &mut Rng, count: usize, at: [f64; 3], side: f64, r: f64) -> Spheres {
    let mut spheres = Spheres::default();
    for _ in 0..count {
        let c = random.cube();
        spheres.push(std::array::from_fn(|k| at[k] + side * c[k]), r * (1.0 + 3.0 * random.unit()), None);
    }
    spheres
}

fn center(spheres: &Spheres, k: usize) -> DVec3 {
    DVec3::from_array(spheres.centers[k])
}

/// A direction from `origin` past sphere `k` at `rim` radii from its centre, of any length.
fn past(random: &mut Rng, spheres: &Spheres, k: usize, origin: DVec3, rim: f64) -> DVec3 {
    let toward = center(spheres, k) - origin;
    let side = toward.cross(DVec3::from_array(random.cube())).normalize_or(DVec3::X);
    (toward + side * spheres.radii[k] * rim) * 10f64.powf(8.0 * random.unit() - 4.0)
}

/// Distances from the rim at which rays pass, in radii.
const RIMS: [f64; 8] = [0.0, 0.5, 0.999, 1.0, 1.0 - 1e-7, 1.0 + 1e-7, 1.0 - 1e-12, 1.3];

/// All families, `count` rays each.
pub(crate) fn families(seed: u64, count: usize) -> Vec<Family> {
    let random = &mut Rng::new(seed);
    let mut all = Vec::new();

    for (name, distance) in [("near", 3.0), ("1e5 away", 1e5), ("1e9 away", 1e9), ("1e13 away", 1e13)] {
        let mut family = Family::new(name, cloud(random, 300, [1.0, -2.0, 3.0], 1.0, 0.02));
        for n in 0..count {
            let origin = DVec3::from_array(random.cube()).normalize_or(DVec3::Z) * distance;
            let k = random.below(300);
            let direction = past(random, &family.spheres, k, origin, RIMS[n % 8]);
            family.ray(origin, direction);
        }
        all.push(family);
    }

    // Points that are on a sphere but for rounding, and rays that leave, enter and graze it.
    for (name, r, at) in
        [("on surfaces", 0.05, 1.0), ("on tiny surfaces", 1e-20, 1e-19), ("on large surfaces", 6.4e6, 1e7)]
    {
        let mut family = Family::new(name, cloud(random, 200, [at; 3], 20.0 * r, r));
        for n in 0..count {
            let k = random.below(200);
            let out = DVec3::from_array(random.cube()).normalize_or(DVec3::Y);
            let origin = center(&family.spheres, k) + out * family.spheres.radii[k];
            let perpendicular = out.cross(DVec3::from_array(random.cube())).normalize_or(DVec3::X);
            let direction = match n % 4 {
                0 => perpendicular + out * random.unit(),
                1 => perpendicular - out * random.unit(),
                2 => perpendicular + out * 1e-9 * (random.unit() - 0.5),
                _ => perpendicular,
            };
            family.ray(origin, direction * 10f64.powf(4.0 * random.unit() - 2.0));
        }
        all.push(family);
    }

    // Exactly on the surface, by Pythagorean triples; exactly tangent; and ends of the range.
    let mut family = Family::new("exact contact", Spheres::default());
    for (c, r) in [([0.0; 3], 5.0), ([10.0, 0.0, 0.0], 5.0), ([0.0, 20.0, 0.0], 13.0), ([0.0; 3], 5.0)] {
        family.spheres.push(c, r, None);
    }
    let whole = |random: &mut Rng| DVec3::from_array(random.cube().map(|x| (x * 9.0).round()));
    for n in 0..count {
        let origin = [[3.0, 4.0, 0.0], [5.0, 0.0, 0.0], [0.0, 3.0, -4.0], [15.0, 0.0, 0.0], [5.0, 12.0, 0.0]][n % 5];
        let (origin, direction) = match n % 3 {
            0 => (DVec3::from_array(origin), whole(random)),
            // Along a tangent plane of sphere 0.
            1 => (DVec3::new(-17.0, 5.0, random.cube()[2].round()), DVec3::new(1.0 + random.unit(), 0.0, 0.0)),
            _ => (DVec3::new(3.0, 4.0, 0.0) - 7.0 * DVec3::new(-4.0, 3.0, 0.0), DVec3::new(-4.0, 3.0, 0.0)),
        };
        family.ray(origin, direction);
    }
    all.push(family);

    // Many equal spheres, and pairs that are met at the same t.
    let mut family = Family::new("ties", cloud(random, 60, [0.0; 3], 1.0, 0.1));
    for k in 0..60 {
        let mirrored = (center(&family.spheres, k) * DVec3::new(1.0, 1.0, -1.0)).to_array();
        family.spheres.push(mirrored, family.spheres.radii[k], None);
        family.spheres.push(family.spheres.centers[k], family.spheres.radii[k], None);
    }
    for n in 0..count {
        let origin = DVec3::new(4.0 * random.cube()[0], 3.0, 0.0);
        let k = random.below(180);
        let direction = past(random, &family.spheres, k, origin, RIMS[n % 8]);
        family.ray(origin, if n % 2 == 0 { direction * DVec3::new(1.0, 1.0, 0.0) } else { direction });
    }
    all.push(family);

    // Nested shells about one centre, with origins between them.
    let mut family = Family::new("shells", Spheres::default());
    for k in 0..120 {
        family.spheres.push([1.0, 2.0, 3.0], 0.5 + 1e-3 * f64::from(k % 40), None);
    }
    for _ in 0..count {
        let out = DVec3::from_array(random.cube());
        family.ray(DVec3::new(1.0, 2.0, 3.0) + out * 0.6, DVec3::from_array(random.cube()));
    }
    all.push(family);

    // A planet with dust on it, seen along its surface.
    let mut family = Family::new("planet", Spheres::default());
    family.spheres.push([0.0, -6.4e6, 0.0], 6.4e6, None);
    for _ in 0..300 {
        let [x, _, z] = random.cube();
        let r = 10f64.powf(-2.0 + 3.0 * random.unit());
        family.spheres.push([1e3 * x, r, 1e3 * z], r, None);
    }
    for n in 0..count {
        let [x, y, z] = random.cube();
        let origin = DVec3::new(1e3 * x, 1.7 + 50.0 * y.abs(), 1e3 * z);
        let k = random.below(300);
        let direction = match n % 3 {
            0 => past(random, &family.spheres, k, origin, RIMS[n % 8]),
            1 => DVec3::new(x, -1e-3 * y, z),
            _ => past(random, &family.spheres, 0, origin, RIMS[n / 3 % 8]),
        };
        family.ray(origin, direction);
    }
    all.push(family);

    for (name, size) in [("subnormal", 1e-312), ("tiny", 1e-150), ("huge", 1e150), ("at the end", 1e307)] {
        let mut family = Family::new(name, cloud(random, 60, [2.0 * size, 0.0, -size], size, 0.1 * size));
        for n in 0..count {
            let origin = DVec3::from_array(random.cube()) * 3.0 * size;
            let k = random.below(60);
            let scale = 1.0 / size.clamp(1e-290, 1e290);
            let direction =
                (center(&family.spheres, k) - origin) * scale + DVec3::from_array(random.cube()) * [0.0, 0.1][n % 2];
            family.ray(origin, direction);
        }
        all.push(family);
    }

    // Spheres of every size, and coordinates that are zero or far apart.
    let mut family = Family::new("all sizes", Spheres::default());
    for _ in 0..300 {
        let r = 10f64.powf(-9.0 + 12.0 * random.unit());
        family.spheres.push(random.cube().map(|x| x * 1e3), r, None);
    }
    for n in 0..count {
        let origin = DVec3::from_array(random.cube()) * [1e3, 1.0, 1e6][n % 3];
        let k = random.below(300);
        let direction = past(random, &family.spheres, k, origin, RIMS[n % 8]);
        let axis = [DVec3::X, DVec3::NEG_Y, DVec3::Z][n % 3];
        family.ray(origin, if n % 7 == 0 { axis } else { direction });
    }
    all.push(family);
    all
}
