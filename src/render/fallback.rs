//! The CPU path in place of an adapter that may not answer, or that fails meanwhile.

use super::budget::{self, Need};
use super::lens;
use super::place::INSTEAD;
use super::plan::Plan;
use super::renderer::Renderer;
use super::rendering::FrameRays;
use crate::scene::Scene;
use crate::settings::{Accuracy, Backend, Settings};
use crate::view::raster::Raster;
use halfline_ground::error::{Error, Result};
use halfline_ground::memory;
use halfline_ground::quote::setting::{ACCURACY, BACKEND};

impl Renderer {
    /// Runs `work` with the plan: on the CPU path with a warning if the adapter may not certify, and once more there where it fails.
    pub(super) fn planned<T>(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        work: impl Fn(&mut Self, Plan, FrameRays) -> Result<T>,
    ) -> Result<(T, Option<String>)> {
        match self.planned_once(scene, settings, &work) {
            Err(error) => {
                let warning = self.device.leave(error, settings.backend)?;
                let (done, _) = self.on_host(|this| this.planned_once(scene, settings, &work))?;
                // A loss is a warning of every report from now on.
                Ok((done, Some(warning).filter(|_| self.is_gpu())))
            }
            done => done,
        }
    }

    /// Runs `work` with the plan, on the CPU path with a warning if the adapter may not certify or was out of memory for as much.
    fn planned_once<T>(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        work: impl Fn(&mut Self, Plan, FrameRays) -> Result<T>,
    ) -> Result<(T, Option<String>)> {
        let by_host = Plan::new(scene, settings, &mut |method| self.check_method(method).is_ok())?;
        let plan = if self.is_gpu() { by_host.clone().on_device() } else { by_host.clone() };
        let window = settings.window_of(scene)?;
        settings.check_lighting(scene)?;
        let samples = Raster::samples(window, settings.samples, settings.seed, &scene.image)?;
        let samples = lens::raster(samples, scene, settings)?;
        let samples = plan.sampled.map(|_| samples.unwrap_or(Raster::centres(window)));
        let rays = FrameRays { window, samples };
        let adapter = self.device.gpu.as_ref().map(|gpu| &gpu.summary);
        Need::of(&plan, settings, scene, window, adapter).check(memory::free(&self.pool))?;
        let of_given = plan.given.as_ref().and_then(|given| given.kernel.method().filter(|_| !given.certifies()));
        if let Some(method) = plan.kernel.method().or(of_given) {
            self.check_method(method)?;
        }
        let pixels = u64::from(window.width()) * u64::from(window.height());
        let load = budget::on_device(scene.spheres.len(), &plan.kernel, pixels);
        match self.blocker(load, plan.accuracy, settings.backend)? {
            None => work(self, plan, rays).map(|done| (done, None)),
            blocker => self.on_host(|this| work(this, by_host, rays)).map(|done| (done, blocker)),
        }
    }

    /// Runs `work` on the CPU path.
    pub(super) fn on_host<T>(&mut self, work: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        let gpu = self.device.gpu.take();
        let done = work(self);
        self.device.gpu = gpu;
        done
    }

    /// The warning that the CPU path takes over, where an adapter was out of memory for no more than `load` bytes, or may not certify.
    ///
    /// # Errors
    /// As [`Renderer::certification_blocker`].
    pub(super) fn blocker(&mut self, load: u64, accuracy: Accuracy, backend: Backend) -> Result<Option<String>> {
        match self.device.memory_blocker(load, backend) {
            None => self.certification_blocker(accuracy, backend),
            blocker => Ok(blocker),
        }
    }

    /// The warning that the CPU path takes over, where an adapter may not certify.
    ///
    /// # Errors
    /// [`Error::Accuracy`] where a device was asked for, and the errors of the self-test.
    fn certification_blocker(&mut self, accuracy: Accuracy, backend: Backend) -> Result<Option<String>> {
        let certified = accuracy == Accuracy::Certified;
        let Some(gpu) = self.device.gpu.as_mut().filter(|_| certified) else { return Ok(None) };
        if gpu.verdict()?.f32 {
            return Ok(None);
        }
        let name = &gpu.summary.name;
        let problem =
            format!("{name} failed the self-test of its f32 arithmetic (see halfline adapters) and cannot certify");
        match backend {
            Backend::Gpu => {
                let mend = format!("use {BACKEND} auto or cpu, or {ACCURACY} fast");
                Err(Error::Accuracy { problem, mend })
            }
            _ => Ok(Some(format!("{problem}: {INSTEAD}"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Aov, Camera, ImagePlane, Spheres};

    /// An adapter that failed the self-test does not certify: the CPU path is used with a warning, or it is an error.
    #[test]
    fn an_adapter_that_failed_the_self_test_does_not_certify() {
        let Some(_) = crate::testing::adapter_or_skip() else { return };
        let mut spheres = Spheres::default();
        spheres.push([0.0, 0.0, -3.0], 1.0, None);
        let image = ImagePlane { width: 16, height: 16, background: [0.0; 3] };
        let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
        let gpu = Settings { backend: Backend::Gpu, aovs: vec![Aov::Id], ..Settings::default() };
        let mut renderer = Renderer::new(&gpu).expect("an adapter; tests/run installs and pins one");
        assert_eq!(renderer.render(&scene, &gpu).expect("a frame").report.backend, "gpu");
        let Some(adapter) = &mut renderer.device.gpu else { panic!("a GPU was requested") };
        adapter.distrust();
        let error = renderer.render(&scene, &gpu).expect_err("the CPU path is not allowed");
        assert!(matches!(error, Error::Accuracy { .. }), "{error}");
        let auto = Settings { backend: Backend::Auto, ..gpu.clone() };
        let report = renderer.render(&scene, &auto).expect("a frame").report;
        assert_eq!((report.backend, report.accuracy), ("cpu", "certified"));
        assert!(report.warnings.iter().any(|w| w.contains("self-test")), "{:?}", report.warnings);
        let plan = renderer.explain(&scene, &auto).expect("a plan");
        assert_eq!((plan.backend, plan.accuracy, &plan.warnings), ("cpu", "certified", &report.warnings));
        assert!(matches!(renderer.explain(&scene, &gpu), Err(Error::Accuracy { .. })), "as rendering does");
        let fast = Settings { accuracy: Accuracy::Fast, ..gpu };
        assert_eq!(renderer.render(&scene, &fast).expect("a frame").report.backend, "gpu", "fast promises nothing");
    }
}
