//! The tree holds every sphere, is the same for any number of threads, and its padding is needed.

mod device;
mod streams;
mod sure;

use super::lanes::{LANE, Lanes, NEVER, Portable};
use super::walk::{Test, may_intersect, walk};
use super::*;
use crate::double_double as dd;
use crate::exact::judge_ray;
use crate::scene::Spheres;
use crate::testing::Rng;
use glam::DVec3;

fn point(random: &mut Rng) -> [f64; 3] {
    std::array::from_fn(|_| random.between(-1.0, 1.0))
}

/// Scenes of every kind, by name.
fn scenes() -> Vec<(String, Spheres)> {
    let random = &mut Rng(3);
    let mut all = Vec::new();
    for count in [1, 7, 8, 9, 63, 64, 65, 511, 512, 513, 5000] {
        let mut spheres = Spheres::default();
        for _ in 0..count {
            spheres.push(point(random), 0.05 * random.unit() + 1e-6, None);
        }
        all.push((format!("{count} spheres"), spheres));
    }
    let mut add = |name: &str, sphere: &mut dyn FnMut(usize) -> ([f64; 3], f64)| {
        let mut spheres = Spheres::default();
        for (center, radius) in (0..3000).map(sphere) {
            spheres.push(center, radius, None);
        }
        all.push((name.to_string(), spheres));
    };
    add("equal", &mut |_| ([1.0, 2.0, 3.0], 0.5));
    add("shells", &mut |n| ([1.0, 2.0, 3.0], 0.1 + n as f64));
    add("a line", &mut |n| ([n as f64, 0.0, 0.0], 0.4));
    add("two clusters", &mut |n| (point(random).map(|x| x * 1e-9 + (n % 2) as f64 * 1e9), 1e-10));
    add("subnormal", &mut |_| (point(random).map(|x| x * 1e-310), 1e-312));
    add("at the end", &mut |_| (point(random).map(|x| x * 1.7e308), 1e306));
    add("every size", &mut |_| (point(random), 10f64.powf(random.between(-300.0, 2.0))));
    all
}

#[test]
fn every_sphere_is_in_all_boxes_above_it() {
    for (name, spheres) in scenes() {
        let tree = Tree::new(&spheres.centers, &spheres.radii).expect("a tree");
        let mut ids = tree.ids.clone();
        ids.sort_unstable();
        assert!(ids.iter().zip(0..).all(|(id, n)| *id == n), "{name}: every sphere once");
        assert!(tree.levels() <= LEVELS && tree.firsts[1] == 1, "{name}");
        for (place, [x, y, z, radius]) in tree.spheres.iter().enumerate() {
            let (center, radius) = (tree.placement.point([*x, *y, *z]), tree.placement.radius(*radius));
            assert!(center.iter().all(|x| x.abs() + radius <= 1.0), "{name}: {center:?} {radius}");
            let mut child = place / WIDE;
            for level in (0..tree.levels()).rev() {
                let node = &tree.nodes[tree.firsts[level] as usize + child / WIDE];
                for (n, x) in center.iter().enumerate() {
                    let (low, high) = (node.planes[n][child % WIDE], node.planes[n + 3][child % WIDE]);
                    let inside = f64::from(low) <= x - radius && x + radius <= f64::from(high);
                    assert!(inside, "{name}: sphere {place} in {low}..{high}");
                }
                child /= WIDE;
            }
        }
    }
}

#[test]
fn the_tree_is_the_same_for_any_number_of_threads() {
    let random = &mut Rng(4);
    let mut spheres = Spheres::default();
    for n in 0..40_000 {
        // Coordinates with ties.
        spheres.push(point(random).map(|x| (x * 30.0).round()), 0.1 * f64::from(n % 3 + 1), None);
    }
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| Tree::new(&spheres.centers, &spheres.radii)).expect("a tree")
    };
    let one = build(1);
    for threads in [2, 3, 8] {
        let other = build(threads);
        assert!(one.ids == other.ids && one.nodes == other.nodes && one.blocks == other.blocks, "{threads} threads");
    }
}

/// Counts the spheres that a traversal would test.
struct Found<'a> {
    tree: &'a Tree,
    ray: BoxRay,
    limit: f32,
    ids: Vec<u32>,
}

impl Test for Found<'_> {
    fn test(&mut self, block: u32) -> f32 {
        let places = may_intersect(Portable, self.tree, block, &self.ray, self.limit);
        self.ids.extend(places.map(|place| self.tree.ids[place]));
        self.limit
    }
}

/// Whether a search finds the sphere of this index by this limit.
type Finds<'a> = &'a mut dyn FnMut(&Tree, &BoxRay, f64, u32) -> bool;

/// The number of rays of `count` that pass one sphere of many at its rim, hit it, and do not find it. `extra` is the
/// padding of a ray from that far.
fn lost(count: usize, extra: impl Fn(f64) -> f64, finds: Finds<'_>) -> usize {
    let random = &mut Rng(6);
    let mut spheres = Spheres::default();
    for _ in 0..600 {
        spheres.push(point(random).map(|x| x * 8.0), 1.0, None);
    }
    let tree = Tree::new(&spheres.centers, &spheres.radii).expect("a tree");
    let mut lost = 0;
    for n in 0..count {
        let k = n % 600;
        // In a plane that touches the sphere and its box, but for roundings.
        let (axis, sign) = (n % 3, if n % 2 == 0 { 1.0 } else { -1.0 });
        let center = DVec3::from_array(spheres.centers[k]);
        let mut touch = center;
        touch[axis] += sign * (1.0 - 1e-14);
        let mut direction = DVec3::from_array(point(random));
        direction[axis] = [0.0, 1e-12, 1e-5][n / 6 % 3] * random.unit();
        let distance = [3.0, 30.0, 1e6][n / 18 % 3];
        let origin = touch - direction * distance;
        let (origin, direction) = (origin.to_array(), direction.to_array());
        let mut alone = Spheres::default();
        alone.push(spheres.centers[k], 1.0, None);
        let Some(truth) = judge_ray(origin, direction, &alone) else { continue };
        let f = dd::exponent(direction.iter().fold(0.0f64, |m, x| m.max(x.abs())));
        let scaled = direction.map(|x| dd::ldexp(x, -f));
        let placed = tree.placement.point(origin);
        let t = dd::ldexp(truth.t, f - tree.placement.k);
        let found = |ray| finds(&tree, &ray, t, k as u32);
        lost += usize::from(!BoxRay::new(placed, scaled, extra(DVec3::from_array(placed).length())).is_some_and(found));
    }
    lost
}

#[test]
fn padding_loses_no_hit_and_is_needed() {
    let mut finds = |tree: &Tree, ray: &BoxRay, t: f64, k: u32| {
        let limit = ray.limit(t);
        let mut found = Found { tree, ray: *ray, limit, ids: Vec::new() };
        walk::<false, _>(Portable, tree, ray, limit, &mut found);
        found.ids.contains(&k)
    };
    assert_eq!(lost(20_000, |_| 0.0, &mut finds), 0);
    // 8 u (1 + |o|) is 2^-19 or more: without it rays in the planes of the boxes miss them.
    let without = lost(20_000, |_| -1.9e-6, &mut finds);
    println!("without padding {without} of 20000 rays lose their sphere");
    assert!(without > 0);
}

/// Vectors of the processor and arrays give the same masks and orders.
fn compare_lanes<L: Lanes>(lanes: L) {
    let random = &mut Rng(8);
    for _ in 0..10_000 {
        let numbers: [f32; WIDE] = std::array::from_fn(|_| match random.bits() % 5 {
            0 => 0.0,
            1 => f32::MAX,
            2 => 1.0,
            _ => (random.unit() * 1e3) as f32,
        });
        let others: [f32; WIDE] = std::array::from_fn(|lane| numbers[(lane + 3) % WIDE]);
        let (a, b) = (lanes.load(&numbers), lanes.load(&others));
        let mask = lanes.at_most(a, b);
        assert_eq!(mask, Portable.at_most(numbers, others));
        let (mut keys, mut plain) = (lanes.keys(a, b), Portable.keys(numbers, others));
        let taken: Vec<u32> = (0..=WIDE).map(|_| lanes.take_least(&mut keys)).collect();
        assert_eq!(taken, (0..=WIDE).map(|_| Portable.take_least(&mut plain)).collect::<Vec<_>>());
        let count = mask.count_ones() as usize;
        assert!(taken.is_sorted() && taken[count..].iter().all(|key| *key == NEVER));
        assert!(taken[..count].iter().all(|key| mask >> (key & LANE) & 1 == 1));
    }
}

#[test]
fn lanes_agree() {
    compare_lanes(Portable);
    #[cfg(target_arch = "x86_64")]
    if let Some(v3) = pulp::x86::V3::try_new() {
        compare_lanes(v3);
    }
}
