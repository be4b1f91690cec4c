//! Strips of pixels over lists of tiles, on the CPU path.

use super::{Engine, Found, ViewRays, settle};
use crate::answers::raw::Raw;
use crate::certify::binned::BinnedScene;
use crate::cpu;
use crate::error::Result;
use crate::memory::Pool;
use crate::progress::Step;
use crate::render::rendering::Rendering;

/// The spheres, binned into tiles by the host.
pub(in crate::render) struct Strips {
    pub(in crate::render) binned: BinnedScene,
}

impl Engine for Strips {
    fn first_hits(&mut self, at: &mut Rendering<'_>, rays: ViewRays<'_>, raw: &mut Raw) -> Result<Found> {
        let ViewRays { scene, view, kernel } = rays;
        let Rendering { renderer, log, .. } = &mut *at;
        let doing = renderer.watch.begin(Step::Trace, raw.id.len() as u64);
        let row = || doing.next(u64::from(view.record.columns));
        let colors = scene.spheres.colors.as_deref();
        log.time("trace", || cpu::certified(kernel, view, &self.binned, colors, raw, &row));
        doing.end()?;
        settle(at, rays, &self.binned, raw).map(Found::Hits)
    }

    fn binned(&self) -> Option<&BinnedScene> {
        Some(&self.binned)
    }

    fn put_back(self: Box<Self>, pool: &Pool) {
        self.binned.put_back(pool);
    }
}
