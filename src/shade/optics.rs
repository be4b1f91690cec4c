//! Mirrors and glass: directions and shares of light.

use glam::DVec3;

/// The direction of length 1 in which a mirror with this normal reflects a ray of length 1.
pub(crate) fn reflected(along: DVec3, normal: DVec3) -> DVec3 {
    along - 2.0 * along.dot(normal) * normal
}

/// The direction of length 1 in which a ray of length 1 is refracted by Snell's law, for `eta`, the ratio of the index on its side
/// to that on the other; the normal is against the ray. `None` where all light is reflected.
pub(crate) fn refracted(along: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let cosine = -along.dot(normal);
    let k = 1.0 - eta * eta * (1.0 - cosine * cosine);
    (k >= 0.0).then(|| (eta * along + (eta * cosine - k.sqrt()) * normal).normalize())
}

/// The share of light that glass reflects: Schlick, *An inexpensive BRDF model for physically-based rendering*, 1994. All of it
/// where nothing is refracted.
pub(crate) fn schlick(cosine: f64, eta: f64) -> f64 {
    if eta * eta * (1.0 - cosine * cosine) > 1.0 {
        return 1.0;
    }
    let straight = ((1.0 - eta) / (1.0 + eta)).powi(2);
    straight + (1.0 - straight) * (1.0 - cosine.min(1.0)).powi(5)
}
