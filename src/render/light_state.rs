//! What a renderer keeps of lights within a frame: what a device did.

use crate::answers::lit::Traced;
use crate::view::ray::NONE;
use rayon::prelude::*;

/// Hits of which a device traced the rays, and those of them that it decided.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LightOnDevice {
    hits: usize,
    decided: usize,
}

impl LightOnDevice {
    /// `None` without hits.
    pub(super) fn share(self) -> Option<f64> {
        (self.hits > 0).then(|| self.decided as f64 / self.hits as f64)
    }

    pub(super) fn add(&mut self, ids: &[u32], traced: &Traced<'_>) {
        let hits = (0..ids.len() as u32).into_par_iter().filter(|pixel| ids[*pixel as usize] != NONE);
        self.hits += hits.clone().count();
        self.decided += hits.filter(|pixel| traced.of(*pixel).is_some()).count();
    }
}
