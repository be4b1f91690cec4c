//! The reference that the depths of a frame are relative to.

/// The reference depth, from the least and the largest depth of the projected spheres. If all spheres are distant and close
/// together, depths relative to it keep their order in f32.
pub(super) fn reference(range: Option<[f64; 2]>, has_generals: bool) -> f32 {
    // Devices know depths in f32.
    match range.map(|range| range.map(|depth| f64::from(depth as f32))) {
        // The nearest surface is at least a quarter of the nearest centre's depth away.
        Some([least, most]) if !has_generals && least > 4.0 * (most - least) => least as f32,
        _ => 0.0,
    }
}

/// Least and largest depth of two sets of spheres.
pub(super) fn joined([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a.min(c), b.max(d)]
}
