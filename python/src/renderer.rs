//! The renderer: a device, or the CPU path, kept for many frames.

use crate::camera::Camera;
use crate::errors::{OrRaise, keywords};
use crate::frame::Frame;
use crate::many::Frames;
use crate::options::{Accurate, Picture};
use crate::parts::Part;
use crate::scene::Scene;
use crate::shared::Shared;
use crate::work::Job;
use halfline::Renderer as CoreRenderer;
use halfline::render::stream::Visible;
use halfline::settings::{Backend, Settings};
use pyo3::prelude::*;

/// A renderer.
#[pyclass(frozen)]
pub(crate) struct Renderer {
    pub(crate) shared: Shared,
    pub(crate) backend: Backend,
    #[pyo3(get)]
    adapter: String,
    #[pyo3(get)]
    driver: String,
    #[pyo3(get)]
    is_gpu: bool,
    /// Why adapters that were found are not used.
    #[pyo3(get)]
    warnings: Vec<String>,
}

impl Renderer {
    /// The settings of a picture of a scene on this renderer.
    fn settings(
        &self,
        scene: &Scene,
        camera: Option<&Camera>,
        picture: &Picture,
        accurate: &Accurate,
    ) -> PyResult<Settings> {
        accurate.settings().and_then(|accurate| picture.settings(scene, camera, accurate, self.backend)).or_raise()
    }
}

#[pymethods]
impl Renderer {
    #[new]
    fn new(py: Python<'_>, backend: &str, adapter: Option<String>) -> PyResult<Self> {
        let backend = backend.parse::<Backend>().or_raise()?;
        let settings = Settings { backend, adapter, ..Settings::default() };
        let exact = Job::default().run(py, None, || CoreRenderer::new(&settings))?;
        Ok(Self {
            backend,
            adapter: exact.adapter().to_owned(),
            driver: exact.driver(),
            is_gpu: exact.is_gpu(),
            warnings: exact.passed_over().iter().map(|warning| keywords(warning)).collect(),
            shared: Shared::new(exact),
        })
    }

    fn render(
        &self,
        py: Python<'_>,
        scene: &Scene,
        camera: Option<&Camera>,
        picture: Picture,
        accurate: Accurate,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Frame> {
        let settings = self.settings(scene, camera, &picture, &accurate)?;
        let job = Job::default();
        let rendered = job.run(py, progress.as_ref(), || {
            let outlined = picture.begin(scene)?;
            let scene = outlined.as_ref().unwrap_or(scene);
            let rendered = picture.render(scene, camera, scene.frame.number, |exact| {
                self.shared.render(&job, exact, &settings, &scene.frame.skipped)
            })?;
            picture.insets.write(scene)?;
            Ok(rendered)
        })?;
        Ok(Frame::new(rendered, picture.single, settings, self.shared.clone()))
    }

    /// Renders the frame of a part.
    fn render_part(
        &self,
        py: Python<'_>,
        part: &Part,
        picture: Picture,
        accurate: Accurate,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Frame> {
        let scene = &part.scene();
        let settings = self.settings(scene, None, &picture, &accurate)?;
        let settings = part.settings(picture.size(), picture.outline_width(), settings).or_raise()?;
        let job = Job::default();
        let rendered = job.run(py, progress.as_ref(), || {
            picture.begin(scene)?;
            let mut shown = None;
            let mut rendered = picture.render(scene, None, scene.frame.number, |exact| {
                let Visible { scene: left, ids } = part.0.clone().visible(exact, &settings)?;
                let mut frame = self.shared.render(&job, &left, &settings, &scene.frame.skipped)?;
                ids.restore(&mut frame);
                frame.report.warnings.extend(part.0.gaps());
                shown = Some(left);
                Ok(frame)
            })?;
            // Provenance is that of all spheres.
            rendered.scene = shown.unwrap_or(rendered.scene);
            Ok(rendered)
        })?;
        Ok(Frame::new(rendered, picture.single, settings, self.shared.clone()))
    }

    /// Renders a picture for each camera, one ahead of the caller.
    fn render_many(
        &self,
        py: Python<'_>,
        scene: Py<Scene>,
        cameras: Vec<Camera>,
        picture: Picture,
        accurate: Accurate,
    ) -> PyResult<Frames> {
        // Mistakes are raised at once.
        self.settings(scene.get(), cameras.first(), &picture, &accurate)?;
        let accurate = accurate.settings().or_raise()?;
        Frames::start(py, self.shared.clone(), scene, cameras, picture, (accurate, self.backend))
    }

    /// The requirements of a picture of the scene, as JSON; no ray is traced.
    fn plan(
        &self,
        py: Python<'_>,
        scene: &Scene,
        camera: Option<&Camera>,
        picture: Picture,
        accurate: Accurate,
    ) -> PyResult<String> {
        let settings = self.settings(scene, camera, &picture, &accurate)?;
        let job = Job::default();
        let plan = job.run(py, None, || {
            let outlined = picture.begin(scene)?;
            let (exact, warnings) = picture.scene(outlined.as_ref().unwrap_or(scene), camera)?;
            self.shared.with(&job, |renderer| {
                let mut plan = renderer.explain(&exact, &settings)?;
                scene.frame.skipped.report(&mut plan.skipped, &mut plan.warnings, renderer.passed_over().len());
                plan.warnings.extend(warnings);
                Ok(plan)
            })
        })?;
        crate::reports::json(&plan)
    }
}
