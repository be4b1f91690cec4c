//! The part of a device in the light of a frame.

use crate::answers::light::Traced;
use crate::parallel;
use crate::view::ray::NONE;

/// The number of hits of which a device traced the rays, and of those hits that it decided.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LightOnDevice {
    hits: usize,
    decided: usize,
}

impl LightOnDevice {
    /// The share of these hits that the device decided; `None` without hits.
    pub(super) fn share(self) -> Option<f64> {
        (self.hits > 0).then(|| self.decided as f64 / self.hits as f64)
    }

    /// Adds the hits of a frame of which the device left so many to the host.
    pub(super) fn add_left(&mut self, ids: &[u32], left: usize) {
        let hits = parallel::count(ids.len(), |pixel| ids[pixel] != NONE);
        self.hits += hits;
        self.decided += hits.saturating_sub(left);
    }

    pub(super) fn add(&mut self, ids: &[u32], traced: &Traced<'_>) {
        let is_left = |pixel: usize| ids[pixel] != NONE && traced.of(pixel as u32).is_none();
        self.add_left(ids, parallel::count(ids.len(), is_left));
    }
}
