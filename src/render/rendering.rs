//! A frame in progress, as its passes share it.

use super::log::FrameLog;
use super::plan::Plan;
use super::renderer::Renderer;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::view::raster::Raster;
use crate::window::Window;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use std::sync::Arc;
use web_time::Instant;

/// A pass, for the report of `halfline plan`.
pub(super) struct Pass {
    pub(super) name: &'static str,
    /// Its output, in words.
    pub(super) output: &'static str,
    /// Whether a frame has it.
    pub(super) runs: fn(&Plan, &Scene, &Settings) -> bool,
}

/// The rays of a frame.
#[derive(Clone, Copy)]
pub(super) struct FrameRays {
    pub(super) window: Window,
    /// The samples, where pictures have passes of their own.
    pub(super) samples: Option<Raster>,
}

/// A frame in progress: the renderer, the inputs of all passes, and their log.
pub(super) struct Rendering<'a> {
    pub(super) renderer: &'a mut Renderer,
    pub(super) scene: &'a Scene,
    pub(super) settings: &'a Settings,
    pub(super) rays: FrameRays,
    pub(super) pool: Arc<Pool>,
    pub(super) log: FrameLog,
    pub(super) start: Instant,
}

impl<'a> Rendering<'a> {
    /// A frame of a renderer before its first pass.
    pub(super) fn new(renderer: &'a mut Renderer, scene: &'a Scene, settings: &'a Settings, rays: FrameRays) -> Self {
        let (start, pool) = (Instant::now(), Arc::clone(&renderer.pool));
        Self { renderer, scene, settings, rays, pool, log: FrameLog::default(), start }
    }

    /// Begins the renderer's next frame.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`].
    pub(super) fn begin(&mut self) -> Result<()> {
        self.pool.next_frame();
        self.renderer.watch.check()?;
        // Discards what was done before, for example by a self-test.
        self.renderer.traffic();
        self.renderer.frames += 1;
        Ok(())
    }

    /// Does `work` as a part of a step.
    pub(super) fn time<T>(&mut self, step: &'static str, work: impl FnOnce(&mut Self) -> T) -> T {
        let start = Instant::now();
        let done = work(self);
        self.log.timings.add(step, start);
        done
    }
}
