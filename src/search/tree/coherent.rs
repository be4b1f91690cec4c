//! Sorts rays so that neighbours are similar: rays that run side by side on a device then visit the same boxes. The
//! answers do not depend on the order.

use crate::view::ray::RayRecord;
use rayon::prelude::*;

/// The indices of `rays` in such an order: along the Morton (Lebesgue) curve through origins and directions, 10 bits
/// per coordinate.
pub(crate) fn coherent(rays: &[RayRecord], farthest: f64) -> Vec<u32> {
    let mut keyed: Vec<(u64, u32)> =
        rays.par_iter().zip(0..rays.len() as u32).map(|(r, n)| (key(r, farthest), n)).collect();
    keyed.par_sort_unstable();
    keyed.into_iter().map(|(_, n)| n).collect()
}

/// Interleaves the bits of the six coordinates, the highest bits first.
fn key(ray: &RayRecord, farthest: f64) -> u64 {
    let [x, y, z, _] = ray.direction.map(f64::from);
    let length = (x * x + y * y + z * z).sqrt();
    // 0 if all rays start at the eye.
    let within = if farthest > 0.0 { 1.0 / farthest } else { 0.0 };
    let [a, b, c, _] = ray.origin.map(|o| f64::from(o) * within);
    [a, b, c, x / length, y / length, z / length].iter().enumerate().fold(0, |key, (k, number)| {
        let step = ((number * 0.5 + 0.5) * 1023.0) as u64;
        (0..10).fold(key, |key, bit| key | (step >> bit & 1) << (6 * bit + k))
    })
}
