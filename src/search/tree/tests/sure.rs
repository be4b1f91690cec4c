//! Spheres that f32 takes for hit are hit, and the padding of that decision is needed.

use super::super::lanes::Portable;
use super::super::walk::may_pass;
use super::super::*;
use super::point;
use crate::double_double as dd;
use crate::testing::Rng;
use glam::DVec3;

/// Of `count` lines that pass a small sphere at this distance in radii, how many are taken for hits. `pad` changes the
/// padding of their rays.
fn taken(count: usize, distance: f64, pad: impl Fn(f32) -> f32) -> usize {
    let (random, radius) = (&mut Rng(9), 1e-4);
    let taken = |_: &usize| {
        let center = DVec3::from_array(point(random));
        // The other sphere is the other end of the scene.
        let far = -center.signum() * 1.5;
        let tree = Tree::new(&[center.to_array(), far.to_array()], &[radius; 2]).expect("a tree");
        let along = DVec3::from_array(point(random)).normalize();
        let perpendicular = along.cross(DVec3::from_array(point(random))).normalize();
        let origin = center + perpendicular * (radius * distance) - along * random.between(0.1, 3.0);
        let f = dd::exponent(along.abs().max_element());
        let along = along.to_array().map(|x| dd::ldexp(x, -f));
        let ray = BoxRay::new(tree.placement.point(origin.to_array()), along, 0.0).expect("a ray to the scene");
        let ray = BoxRay { pad: pad(ray.pad), ..ray };
        may_pass(Portable, &tree, 0, &ray, [f32::MAX; 2]).is_none()
    };
    (0..count).filter(taken).count()
}

#[test]
fn what_is_taken_for_hit_is_hit_and_padding_is_needed() {
    const COUNT: usize = 20_000;
    // Far more than the roundings of these rays in f64.
    let outside = 1.0 + 1e-9;
    assert_eq!(taken(COUNT, outside, |pad| pad), 0);
    let without = taken(COUNT, outside, |_| 0.0);
    println!("without padding {without} of {COUNT} rays take a sphere for hit that they miss");
    assert!(without > 0);
    assert_eq!(taken(COUNT, 0.5, |pad| pad), COUNT, "rays well within are all sure");
}
