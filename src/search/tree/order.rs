//! Sorts rays so that neighbours visit the same boxes: they find them in the processor's caches, and on a device run side
//! by side. The answers do not depend on the order.

use super::BoxRay;
use halfline_ground::parallel;
use std::ops::Range;

/// Fewer rays than this are not sorted.
const SORTING_MIN_RAYS: usize = 1 << 10;

/// The numbers of some rays along the Morton curve through their starts, then through their directions. `ray` is a ray by
/// its number; `None` if it certainly meets nothing.
pub(crate) fn order(numbers: Range<usize>, ray: impl Fn(usize) -> Option<BoxRay> + Sync) -> Vec<u32> {
    if numbers.len() < SORTING_MIN_RAYS {
        return numbers.map(|n| n as u32).collect();
    }
    let key = |n: usize| u64::from(ray(n).map_or(0, |ray| key(&ray))) << 32 | n as u64;
    let mut keys = parallel::from_fn(numbers.len(), |n| key(numbers.start + n));
    parallel::sort(&mut keys, u64::cmp);
    parallel::map(&keys, |key| *key as u32)
}

fn key(ray: &BoxRay) -> u32 {
    let step = |x: f32, bits: u32| ((x * 0.5 + 0.5).clamp(0.0, 1.0) * ((1u32 << bits) - 1) as f32) as u32;
    // The directions unfold onto a square by an octahedron (Meyer et al. 2010).
    let [x, y, z] = ray.direction;
    let sum = x.abs() + y.abs() + z.abs();
    let (u, v) = (x / sum, y / sum);
    let folded = if z < 0.0 { [(1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v)] } else { [u, v] };
    interleave(ray.origin.map(|x| step(x, 7)), 7) << 10 | interleave(folded.map(|x| step(x, 5)), 5)
}

/// The bits of some numbers in turn, the highest first.
fn interleave<const N: usize>(numbers: [u32; N], bits: u32) -> u32 {
    (0..bits).rev().fold(0, |key, bit| numbers.iter().fold(key, |key, number| key << 1 | number >> bit & 1))
}
