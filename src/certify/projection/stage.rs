//! Classifies one sphere: in front of the eye plane (project.rs), general, or out of sight.

use super::project::Landed;
use super::{FARTHEST, ProjectionBounds, SMALLEST, UNKNOWN, not_below};
use crate::certify::general::GeneralRecord;
use crate::view::FromEye;
use glam::DVec3;

/// A sphere after binning.
pub(in crate::certify) enum Staged {
    /// Behind the eye plane, entirely outside the image, or between its pixels: no viewing ray hits it.
    Unseen,
    Projected(Landed),
    General(GeneralRecord),
}

impl ProjectionBounds {
    /// Classifies a sphere for the viewing rays, with depths relative to `reference`.
    pub(in crate::certify) fn stage(&self, id: u32, center: [f64; 3], radius: f64, reference: f64) -> Staged {
        match self.project(center, radius, reference) {
            Ok(None) => Staged::Unseen,
            Ok(Some(mut landed)) => {
                landed.placed.detail.id = id;
                Staged::Projected(landed)
            }
            Err(()) if self.parallel => Staged::General(GeneralRecord { id, ..UNKNOWN_SPHERE }),
            Err(()) => Staged::General(self.general(id, center, radius)),
        }
    }

    pub(in crate::certify) fn general(&self, id: u32, center: [f64; 3], radius: f64) -> GeneralRecord {
        let FromEye { k, offset, radius: r, power } = FromEye::new(self.basis.e, center, radius);
        let power = power.value();
        // Too small for products in f32, yet not zero: the record means "possibly a hit, at any depth from 0".
        let unknown = power != 0.0 && power.abs() < SMALLEST;
        let power = if unknown { 0.0 } else { power };
        let away = DVec3::from_array(offset.map(|x| x.hi));
        // The camera looks along -z.
        let p = [self.basis.u, self.basis.v, self.basis.w].map(|axis| away.dot(axis));
        // p.d at a pixel is start + by_column columns + by_row rows, counted from the pixel nearest to its zero.
        let by = [2.0 * self.slope[0] * p[0], -2.0 * self.slope[1] * p[1]];
        let middle = self.size.map(|n| (n - 1.0) / 2.0);
        let back = p[2] / (by[0] * by[0] + by[1] * by[1]).max(f64::MIN_POSITIVE);
        let pixel = [0, 1].map(|k| (middle[k] + by[k] * back).clamp(-FARTHEST, FARTHEST).round());
        let along = [0, 1].map(|k| (pixel[k] - middle[k]) * by[k]);
        let start = along[0] + along[1] - p[2];
        let slopes = [0, 1].map(|k| (2.0 * self.slope[k] * (pixel[k] - middle[k])).abs());
        GeneralRecord {
            center_radius: [p[0] as f32, p[1] as f32, p[2] as f32, r as f32],
            power: power as f32,
            scale: f32::from_bits(((k - self.frame + 127) as u32) << 23),
            form: u32::from(power.abs() <= r * r),
            id,
            column: pixel[0] as i32,
            row: pixel[1] as i32,
            start: start as f32,
            by_column: by[0] as f32,
            by_row: by[1] as f32,
            // 2^-48 of p in every component, and the rounding of start.
            blur: if unknown { UNKNOWN } else { not_below(2f64.powi(-46) * (1.0 + slopes[0] + slopes[1])) },
            unused: [0.0; 2],
        }
    }
}

/// A record that means "possibly a hit, at any depth from 0" for every ray.
const UNKNOWN_SPHERE: GeneralRecord = GeneralRecord {
    center_radius: [0.0, 0.0, 0.0, 1.0],
    power: 0.0,
    scale: 1.0,
    form: 1,
    id: 0,
    column: 0,
    row: 0,
    start: 0.0,
    by_column: 0.0,
    by_row: 0.0,
    blur: UNKNOWN,
    unused: [0.0; 2],
};
