//! The judge: exact arithmetic decides every pixel.

use super::{Engine, Found, ViewRays};
use crate::answers::raw::Raw;
use crate::answers::settle;
use crate::error::Result;
use crate::progress::Step;
use crate::render::log::FrameLog;
use crate::render::renderer::Renderer;

/// All spheres, in exact arithmetic.
pub(in crate::render) struct Exact;

impl Engine for Exact {
    fn first_hits(
        &mut self,
        renderer: &mut Renderer,
        ViewRays { scene, view, .. }: ViewRays<'_>,
        raw: &mut Raw,
        log: &mut FrameLog,
    ) -> Result<Found> {
        let doing = renderer.watch.begin(Step::Settle, raw.id.len() as u64);
        let go_on = || doing.next(u64::from(view.record.columns));
        let settled = log.time("settle", || settle::exact(scene, view, &go_on));
        doing.end()?;
        settled.map(Found::Hits)
    }

    fn proves(&self) -> bool {
        false
    }
}
