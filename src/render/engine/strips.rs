//! Strips of pixels over lists of tiles, on the CPU path.

use super::{Engine, Found, ViewRays, settle};
use crate::answers::layers::{Layers, Peeling};
use crate::answers::raw::Raw;
use crate::certify::binned::BinnedScene;
use crate::cpu;
use crate::kernel::Kernel;
use crate::render::rendering::Rendering;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::progress::Step;
use std::iter::once;

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
        let faces = scene.spheres.cuts.as_ref().and_then(|cuts| cuts.colors.as_deref());
        let colors = [scene.spheres.colors.as_deref(), faces];
        log.time("trace", || cpu::certified(kernel, view, &self.binned, colors, &[], raw, &row));
        doing.end()?;
        settle(at, rays, &self.binned, raw).map(Found::Hits)
    }

    /// Layer by layer, each among the spheres that the layers before leave; the pixels that a layer leaves undecided in the end.
    fn behind(&mut self, at: &mut Rendering<'_>, rays: ViewRays<'_>, layers: Layers<'_>) -> Result<Vec<Vec<u32>>> {
        let (ViewRays { scene, view, .. }, kernel) = (rays, Kernel::certified());
        let (pixels, watch) = (layers.first.len(), &at.renderer.watch);
        let doing = watch.begin(Step::Trace, pixels as u64 * u64::from(layers.more));
        let row = || doing.next(u64::from(view.record.columns));
        let (mut found, mut undecided): (Vec<Vec<u32>>, _) = (Vec::new(), Vec::new());
        for _ in 0..layers.more {
            let passed: Vec<&[u32]> = once(layers.first).chain(found.iter().map(Vec::as_slice)).collect();
            let mut next = Raw::new(&kernel, pixels, &at.pool)?;
            cpu::certified(&kernel, view, &self.binned, [None; 2], &passed, &mut next, &row);
            undecided.extend(layers.end(passed[passed.len() - 1], &mut next.id));
            found.push(next.id);
        }
        doing.end()?;
        let more = Peeling::new(scene, view, &self.binned, layers)?.behind(&undecided, watch)?;
        for (pixel, ids) in undecided.iter().zip(more.chunks(found.len())) {
            found.iter_mut().zip(ids).for_each(|(layer, id)| layer[*pixel as usize] = *id);
        }
        Ok(found)
    }

    fn binned(&self) -> Option<&BinnedScene> {
        Some(&self.binned)
    }

    fn put_back(self: Box<Self>, pool: &Pool) {
        self.binned.put_back(pool);
    }
}
