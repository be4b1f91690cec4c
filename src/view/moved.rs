//! One sphere moved into the canonical camera.

use super::records::{SphereRecord, SphereResiduals};
use crate::double_double::{self as dd, Dd, Dd3};
use crate::exact;
use crate::scene::camera::Basis;
use glam::DVec3;

/// A sphere relative to the eye, times the power of two 2^-k that brings the largest of |c - e|'s components and r into
/// [1, 2).
pub(crate) struct FromEye {
    /// The exponent k.
    pub(crate) k: i32,
    /// c - e along the world axes, exact.
    pub(crate) offset: Dd3,
    pub(crate) radius: f64,
    /// The power of the eye |c - e|^2 - r^2: relative error within 2^-50, exact sign.
    pub(crate) power: Dd,
}

impl FromEye {
    /// Below this power double-double is not exact enough: its error is within 2^-92 for sums below 16.
    /// Section 3 of docs/certificate.md.
    const FAINT: f64 = 1.0 / (1u64 << 42) as f64;

    pub(crate) fn new(eye: DVec3, center: [f64; 3], radius: f64) -> Self {
        let away: Dd3 = std::array::from_fn(|n| Dd::diff(center[n], eye[n]));
        let k = dd::exponent(away.iter().fold(radius, |most, x| most.max(x.hi.abs())));
        // Scaling comes before any product, because products of subnormal numbers underflow.
        let offset = away.map(|x| x.ldexp(-k));
        let radius_scaled = dd::ldexp(radius, -k);
        let mut power = dd::dot(offset, offset) - Dd::product(radius_scaled, radius_scaled);
        if power.hi.abs() < Self::FAINT {
            power = exact::power(center, eye.to_array(), radius, -k);
        }
        Self { k, offset, radius: radius_scaled, power }
    }
}

/// One sphere in the canonical camera: p = (u.(c-e), v.(c-e), w.(c-e)) and r in f64, and the power of the eye.
pub(super) struct Moved {
    /// The exponent k.
    k: i32,
    center_radius: [f64; 4],
    power: Dd,
}

impl Moved {
    pub(super) fn new(basis: &Basis, center: [f64; 3], radius: f64) -> Self {
        let FromEye { k, offset, radius, power } = FromEye::new(basis.e, center, radius);
        let p = DVec3::from_array(offset.map(|x| x.hi));
        Self { k, center_radius: [p.dot(basis.u), p.dot(basis.v), p.dot(basis.w), radius], power }
    }

    pub(super) fn record(&self, unit: i32) -> SphereRecord {
        SphereRecord {
            center_radius: self.center_radius.map(|x| x as f32),
            power: nonzero_f32(self.power.value()),
            scale: f32::from_bits(((self.k - unit + 127) as u32) << 23),
            unused: [0; 2],
        }
    }

    /// Rounding errors of `s`, this sphere's record.
    pub(super) fn residuals(&self, s: &SphereRecord) -> SphereResiduals {
        SphereResiduals {
            center_radius: std::array::from_fn(|n| (self.center_radius[n] - f64::from(s.center_radius[n])) as f32),
            power: (self.power - Dd::from(f64::from(s.power))).value() as f32,
            unused: [0.0; 3],
        }
    }
}

/// x as f32, never rounded to zero: the sign of the power says whether the eye is inside.
fn nonzero_f32(x: f64) -> f32 {
    let rounded = x as f32;
    if rounded == 0.0 && x != 0.0 { f32::MIN_POSITIVE.copysign(x as f32) } else { rounded }
}
