//! Strips of pixels over lists of tiles, on the CPU path.

use super::{Engine, Found, ViewRays, settle};
use crate::answers::raw::Raw;
use crate::certify::binned::BinnedScene;
use crate::cpu;
use crate::error::Result;
use crate::memory::Pool;
use crate::progress::Step;
use crate::render::log::FrameLog;
use crate::render::renderer::Renderer;

/// The spheres, binned into tiles by the host.
pub(in crate::render) struct Strips {
    pub(in crate::render) binned: BinnedScene,
    /// Whether pixels without a proof are decided by the judge.
    pub(in crate::render) proves: bool,
}

impl Engine for Strips {
    fn first_hits(
        &mut self,
        renderer: &mut Renderer,
        rays: ViewRays<'_>,
        raw: &mut Raw,
        log: &mut FrameLog,
    ) -> Result<Found> {
        let (ViewRays { scene, view, kernel }, watch) = (rays, &renderer.watch);
        let doing = watch.begin(Step::Trace, raw.id.len() as u64);
        let row = || doing.next(u64::from(view.record.columns));
        let colors = scene.spheres.colors.as_deref();
        log.time("trace", || cpu::certified(kernel, view, &self.binned, colors, raw, &row));
        doing.end()?;
        settle(rays, &self.binned, raw, watch, log).map(Found::Hits)
    }

    fn binned(&self) -> Option<&BinnedScene> {
        Some(&self.binned)
    }

    fn proves(&self) -> bool {
        self.proves
    }

    fn put_back(self: Box<Self>, pool: &Pool) {
        self.binned.put_back(pool);
    }
}
