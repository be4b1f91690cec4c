//! Classifies one sphere: in front of the eye plane (project.rs), general, or out of sight.

use super::project::Landed;
use super::{FARTHEST, ProjectionBounds, SMALLEST, UNKNOWN, not_below};
use crate::certify::general::GeneralRecord;
use crate::view::FromEye;
use bytemuck::Zeroable;
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
            // Possibly a hit, at any depth from 0, for every ray.
            Err(()) if self.parallel => Staged::General(GeneralRecord {
                center_radius: [0.0, 0.0, 0.0, 1.0],
                scale: 1.0,
                form: 1,
                id,
                blur: UNKNOWN,
                ..GeneralRecord::zeroed()
            }),
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
        // p.d at a pixel is start + by[0] columns + by[1] rows, counted from the pixel nearest to its zero.
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
            pixel: pixel.map(|pixel| pixel as i32),
            by: by.map(|by| by as f32),
            start: start as f32,
            // 2^-48 of p in every component, and the rounding of start.
            blur: if unknown { UNKNOWN } else { not_below(2f64.powi(-46) * (1.0 + slopes[0] + slopes[1])) },
            ..GeneralRecord::zeroed()
        }
    }
}
