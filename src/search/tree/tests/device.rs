//! Boxes on a grid hold the spheres, however the device rounds.

use super::*;
use crate::search::tree::device::{NodeRecord, first};

/// A box as its grid states it, exactly; `None` for a child that is missing.
fn decoded(record: &NodeRecord, lane: usize) -> Option<[[f64; 3]; 2]> {
    let plane = |n: usize| {
        let steps = record.planes[n][lane / 4] >> (lane % 4 * 8) & 255;
        let exponent = (record.grid >> (n % 3 * 8) & 255) as i32 - 127;
        f64::from(record.origin[n % 3]) + dd::ldexp(f64::from(steps), exponent)
    };
    (record.grid >> (24 + lane) & 1 == 1).then(|| [0, 3].map(|n| [plane(n), plane(n + 1), plane(n + 2)]))
}

#[test]
fn every_sphere_is_in_all_boxes_of_the_device_above_it() {
    for (name, spheres) in scenes() {
        let tree = Tree::new(&spheres.centers, &spheres.radii).expect("a tree");
        let nodes = tree.device_nodes();
        for (place, [x, y, z, radius]) in tree.spheres.iter().enumerate() {
            let (center, radius) = (tree.placement.point([*x, *y, *z]), tree.placement.radius(*radius));
            let mut child = place;
            for level in (0..=tree.levels()).rev() {
                let [low, high] = decoded(&nodes[first(level) + child / WIDE], child % WIDE).expect("a child");
                for (n, x) in center.iter().enumerate() {
                    let inside = low[n] <= x - radius && x + radius <= high[n];
                    assert!(inside, "{name}: sphere {place} in {low:?}..{high:?}");
                    // A grid of 255 steps is at most twice as wide as the node, and the finest 2^-30.
                    let tight = low[n] >= -1.1 && high[n] <= 1.1;
                    assert!(tight, "{name}: {low:?}..{high:?}");
                }
                child /= WIDE;
            }
        }
        let children: u32 = nodes.iter().map(|node| (node.grid >> 24).count_ones()).sum();
        let below = tree.firsts[tree.levels()] as usize - 1 + tree.blocks.len() + tree.ids.len();
        assert_eq!(children as usize, below, "{name}: children that exist");
    }
}

/// f32 of an exact number, rounded up or down at random as WGSL may.
fn rounded(random: &mut Rng, x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) == x {
        return near;
    }
    let (low, high) = if f64::from(near) < x { (near, near.next_up()) } else { (near.next_down(), near) };
    if random.bits().is_multiple_of(2) { low } else { high }
}

/// Whether a device enters the box of this child before `limit`: the operations of `descend`.
fn enters(random: &mut Rng, node: &NodeRecord, lane: usize, ray: &BoxRay, limit: f32) -> bool {
    let (mut near, mut far) = (0f32, limit);
    for n in 0..3 {
        let step = f32::from_bits((node.grid >> (8 * n) & 255) << 23) * ray.inverse[n];
        let mut t = |plane: usize, from: f32| {
            let steps = node.planes[plane][lane / 4] >> (lane % 4 * 8) & 255;
            let difference = rounded(random, f64::from(node.origin[n]) - f64::from(from));
            let first = rounded(random, f64::from(difference) * f64::from(ray.inverse[n]));
            let way = rounded(random, f64::from(steps) * f64::from(step));
            rounded(random, f64::from(way) + f64::from(first))
        };
        let (low, high) = if ray.inverse[n] < 0.0 { (n + 3, n) } else { (n, n + 3) };
        near = near.max(t(low, ray.enter[n]));
        far = far.min(t(high, ray.leave[n]));
    }
    near <= far && node.grid >> (24 + lane) & 1 == 1
}

/// As [`lost`], for a device.
fn lost_by_device(extra: impl Fn(f64) -> f64) -> usize {
    let random = &mut Rng(9);
    let mut nodes = Vec::new();
    lost(20_000, extra, &mut |tree, ray, t, k| {
        if nodes.is_empty() {
            nodes = tree.device_nodes();
        }
        let limit = ray.limit(t);
        let place = tree.ids.iter().position(|id| *id == k).expect("a sphere");
        (0..=tree.levels()).all(|level| {
            let child = place >> (3 * (tree.levels() - level));
            enters(random, &nodes[first(level) + child / WIDE], child % WIDE, ray, limit)
        })
    })
}

#[test]
fn padding_loses_no_hit_on_devices_and_is_needed() {
    const U: f64 = 1.0 / (1u64 << 23) as f64;
    assert_eq!(lost_by_device(|_| 0.0), 0);
    let without = lost_by_device(|far| -8.0 * U * (1.0 + far));
    println!("without padding {without} of 20000 rays lose their sphere");
    assert!(without > 0);
}

/// Rays from hits, whose starts and reciprocals devices compute in f32: shaders/main/sky.wgsl, docs/certificate.md, section 13.
fn lost_from_hits(pad: f64) -> (usize, usize) {
    const U: f64 = 1.0 / (1u64 << 23) as f64;
    let random = &mut Rng(10);
    let (mut nodes, mut count) = (Vec::new(), 0);
    let lost = lost(20_000, |_| 0.0, &mut |tree, ray, t, k| {
        if ray.start > 0.0 || ray.origin.iter().any(|x| x.abs() > 1.0) {
            return true;
        }
        count += 1;
        if nodes.is_empty() {
            nodes = tree.device_nodes();
        }
        let origin = ray.origin.map(|x| (f64::from(x) + random.between(-11.0, 11.0) * U) as f32);
        let inverse = ray.inverse.map(|x| (f64::from(x) * (1.0 + random.between(-2.5, 2.5) * U)) as f32);
        let mut moved = |back: f64| -> [f32; 3] {
            std::array::from_fn(|n| rounded(random, f64::from(origin[n]) + back * pad.copysign(inverse[n].into())))
        };
        let ray = BoxRay { enter: moved(1.0), leave: moved(-1.0), inverse, ..*ray };
        let limit = ray.limit(t);
        let place = tree.ids.iter().position(|id| *id == k).expect("a sphere");
        (0..=tree.levels()).all(|level| {
            let child = place >> (3 * (tree.levels() - level));
            enters(random, &nodes[first(level) + child / WIDE], child % WIDE, &ray, limit)
        })
    });
    (lost, count)
}

#[test]
fn padding_of_rays_from_hits_loses_no_hit_and_is_needed() {
    const U: f64 = 1.0 / (1u64 << 23) as f64;
    let ((with, count), (half, _), (without, _)) =
        (lost_from_hits(40.0 * U), lost_from_hits(10.0 * U), lost_from_hits(0.0));
    println!(
        "of {count} rays from hits {with} lose their sphere, {half} with a quarter of the padding, {without} without"
    );
    assert!(with == 0 && without > 0 && count > 3000, "{with} {without} {count}");
}
