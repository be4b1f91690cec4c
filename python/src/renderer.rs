//! The renderer: a device, or the CPU path, kept for many frames.

use crate::camera::Camera;
use crate::errors::OrRaise;
use crate::frame::Frame;
use crate::many::Frames;
use crate::parts::Part;
use crate::scene::Scene;
use crate::shared::Shared;
use crate::words::Chosen;
use crate::work::Job;
use halfline::Renderer as CoreRenderer;
use halfline::settings::{Backend, Settings};
use halfline_command::choices::{ChosenScene, in_keywords};
use pyo3::prelude::*;
use pyo3::types::PyDict;

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
            warnings: exact.passed_over().iter().map(|warning| in_keywords(warning)).collect(),
            shared: Shared::new(exact),
        })
    }

    fn render(
        &self,
        py: Python<'_>,
        scene: &Scene,
        camera: Option<&Camera>,
        options: &Bound<'_, PyDict>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Frame> {
        let chosen = Chosen::of(options)?;
        self.rendered(py, progress.as_ref(), &chosen, || {
            scene.chosen(camera, chosen.choices.size(), scene.frame.number)
        })
    }

    /// Renders the frame of a part.
    fn render_part(
        &self,
        py: Python<'_>,
        part: &Part,
        options: &Bound<'_, PyDict>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Frame> {
        let (chosen, scene) = (Chosen::of(options)?, part.scene());
        let of_part = || Ok(ChosenScene { part: Some(&part.0), ..scene.chosen(None, None, 1)? });
        self.rendered(py, progress.as_ref(), &chosen, of_part)
    }

    /// Renders a picture for each camera, ahead of the caller.
    fn render_many(
        &self,
        py: Python<'_>,
        scene: Py<Scene>,
        cameras: Vec<Camera>,
        options: &Bound<'_, PyDict>,
    ) -> PyResult<Frames> {
        let place = (self.shared.clone(), self.backend, self.is_gpu);
        Frames::start(py, place, scene, cameras, Chosen::of(options)?)
    }

    /// The requirements of a picture of the scene, as JSON; no ray is traced.
    fn plan(
        &self,
        py: Python<'_>,
        scene: &Scene,
        camera: Option<&Camera>,
        options: &Bound<'_, PyDict>,
    ) -> PyResult<String> {
        let Chosen { choices, aovs, .. } = Chosen::of(options)?;
        let job = Job::default();
        let plan = job.run(py, None, || {
            let of = scene.chosen(camera, choices.size(), scene.frame.number)?;
            let picture = choices.picture(of, &aovs, self.backend)?;
            self.shared.with(&job, |renderer| picture.explain(renderer))
        })?;
        crate::reports::json(&plan)
    }
}

impl Renderer {
    /// Renders the picture of a scene, and writes the file of its legend.
    fn rendered<'a>(
        &self,
        py: Python<'_>,
        progress: Option<&Py<PyAny>>,
        chosen: &Chosen,
        scene: impl FnOnce() -> halfline::Result<ChosenScene<'a>> + Send,
    ) -> PyResult<Frame> {
        let job = Job::default();
        let rendered = job.run(py, progress, || {
            let picture = chosen.choices.picture(scene()?, &chosen.aovs, self.backend)?;
            let rendered = self.shared.with(&job, |renderer| picture.render(renderer))?;
            picture.write_legend()?;
            Ok(rendered)
        })?;
        Ok(Frame::new(rendered, chosen.single, self.shared.clone()))
    }
}
