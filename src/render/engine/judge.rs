//! The judge: exact arithmetic decides every pixel.

use super::{Engine, Found, ViewRays};
use crate::answers::raw::Raw;
use crate::answers::settle;
use crate::render::rendering::Rendering;
use halfline_ground::error::Result;
use halfline_ground::progress::Step;

/// All spheres, in exact arithmetic.
pub(in crate::render) struct Exact;

impl Engine for Exact {
    fn first_hits(&mut self, at: &mut Rendering<'_>, rays: ViewRays<'_>, raw: &mut Raw) -> Result<Found> {
        let ViewRays { scene, view, .. } = rays;
        let Rendering { renderer, log, .. } = at;
        let doing = renderer.watch.begin(Step::Settle, raw.id.len() as u64);
        let go_on = || doing.next(u64::from(view.record.columns));
        let settled = log.time("settle", || settle::exact(scene, view, &go_on));
        doing.end()?;
        settled.map(Found::Hits)
    }
}
