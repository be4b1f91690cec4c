//! One frame the whole way: its passes in order.

use super::passes::{buffers, hits, light, samples, shade};
use super::plan::Plan;
use super::renderer::Renderer;
use super::rendering::{FrameRays, Rendering};
use super::{report, setup};
use crate::frame::report::Report;
use crate::frame::{Aov, Frame};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::view::raster::Raster;
use halfline_ground::error::Result;

impl Renderer {
    /// Renders `scene`. The backend and adapter of `settings` take effect in [`Renderer::new`] only.
    ///
    /// # Errors
    /// [`Error::Scene`](crate::Error::Scene), [`Error::Settings`](crate::Error::Settings), [`Error::Limits`](crate::Error::Limits),
    /// [`Error::DeviceLost`](crate::Error::DeviceLost), [`Error::Accuracy`](crate::Error::Accuracy),
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn render(&mut self, scene: &Scene, settings: &Settings) -> Result<Frame> {
        if scene.lighting.sky.is_some_and(|sky| settings.sky_at_centers(sky)) && settings.asks(&[Aov::Color]) {
            self.try_drawing();
        }
        let mut frame = self.frame_of_remaining(scene, |this, scene| {
            let work = |this: &mut Self, plan: Plan, rays: FrameRays| this.frame(plan, rays, scene, settings);
            let (mut frame, blocker) = this.planned(scene, settings, work)?;
            frame.report.warnings.extend(blocker);
            Ok(frame)
        })?;
        frame.report.add_cuts(&scene.spheres);
        Ok(frame)
    }

    /// The report of a frame before it is rendered: the plan, the device and the settings. No ray is traced.
    ///
    /// # Errors
    /// Errors of [`Renderer::render`] that do not depend on rays.
    pub fn dry_run(&mut self, scene: &Scene, settings: &Settings) -> Result<Report> {
        let mut report = self.with_remaining(scene, |this, scene| {
            let known = |this: &mut Self, plan: Plan, rays: FrameRays| {
                let mut at = Rendering::new(this, scene, settings, rays);
                let plan = setup::decided(&mut at, plan, Raster::centres(rays.window))?;
                let mut report = report::known(&at, &plan);
                report.warnings.extend(at.log.warnings());
                Ok(report)
            };
            this.planned(scene, settings, known).map(|(report, _)| report)
        })?;
        report.add_cuts(&scene.spheres);
        Ok(report)
    }

    /// Does `work` with the spheres of a scene that its planes leave.
    ///
    /// # Errors
    /// Errors of `work`; [`crate::Error::Limits`] where memory is short.
    pub(super) fn with_remaining<T>(
        &mut self,
        scene: &Scene,
        work: impl FnOnce(&mut Self, &Scene) -> Result<T>,
    ) -> Result<T> {
        match self.remaining.of(&scene.spheres)? {
            Some(remaining) => work(self, &remaining.scene(scene)),
            None => work(self, scene),
        }
    }

    /// The frame that `work` makes of the spheres that planes leave, with the ids that they have in the whole scene.
    fn frame_of_remaining(
        &mut self,
        scene: &Scene,
        work: impl FnOnce(&mut Self, &Scene) -> Result<Frame>,
    ) -> Result<Frame> {
        let Some(remaining) = self.remaining.of(&scene.spheres)? else { return work(self, scene) };
        let mut frame = work(self, &remaining.scene(scene))?;
        remaining.rename(&mut frame);
        Ok(frame)
    }

    /// Renders the window of a frame: the passes of [`PASSES`](super::passes::PASSES), each with the outputs of those before it.
    fn frame(&mut self, plan: Plan, rays: FrameRays, scene: &Scene, settings: &Settings) -> Result<Frame> {
        let mut at = Rendering::new(self, scene, settings, rays);
        at.begin()?;
        let (setup, mut hits) = hits::run(&mut at, plan)?;
        let trees = light::trees(&mut at, &setup.plan);
        let light = light::run(&mut at, &setup, trees.as_ref(), &hits)?;
        let (means, coverage) = samples::run(&mut at, &setup, trees.as_ref(), &hits)?;
        shade::run(&mut at, &setup, &mut hits);
        let settled = hits.settled.len();
        let buffers = buffers::run(&mut at, &setup, hits, means, light)?;
        report::complete(at, setup, settled, buffers, coverage)
    }
}
