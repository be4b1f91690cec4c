//! The view of a notebook: its page, which the code of `halfline view` answers.

use crate::camera::Camera;
use crate::errors::{AccuracyError, AdapterError, OrRaise, exception};
use crate::renderer::Renderer;
use crate::scene::Scene;
use crate::words::{Chosen, written};
use crate::work::{Job, SLICE, begin, is_forked, no_thread};
use halfline::Aov;
use halfline_command::choices::in_keywords;
use halfline_command::shown::{self, Call, Content, MemoryScene, PageText};
use halfline_files::write::file::write_atomically;
use halfline_viewer::{FrameRequest, GoOn, Lens, Pixels, Pose, Refusal, Reply, Routes, SelectRequest, Stage};
use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// The module of the widget.
#[pyfunction]
pub(crate) fn widget_module() -> String {
    halfline_viewer::widget_module()
}

/// The style of the widget.
#[pyfunction]
pub(crate) fn widget_style() -> &'static str {
    halfline_viewer::style()
}

/// Source of the scene of a page: its file, and the keywords of `read` and of `Renderer`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Origin<'py> {
    file: Option<OsString>,
    reading: Bound<'py, PyDict>,
    renderer: Bound<'py, PyDict>,
}

/// A scene that a view shows, and the answers to its page.
#[pyclass(frozen)]
pub(crate) struct Desk {
    scene: Py<Scene>,
    /// The picture with which it begins.
    first: FrameRequest,
    stage: Arc<dyn Stage>,
    routes: Arc<Routes>,
}

/// A camera as the page has it, for an image of this size.
fn pose_of(scene: &Scene, camera: &Camera, size: (u32, u32)) -> halfline::Result<Pose> {
    let size = camera.size.is_none().then_some(size);
    shown::pose(&scene.sized(Some(camera), size)?, None)
}

/// A scene and the options of a page, as the package checked them.
#[derive(FromPyObject)]
pub(crate) struct PageScene<'py> {
    scene: Py<Scene>,
    renderer: PyRef<'py, Renderer>,
    native_camera: PyRef<'py, Camera>,
    size: (u32, u32),
    /// The keywords of the picture, and of its lens.
    options: Bound<'py, PyDict>,
    lens: Bound<'py, PyDict>,
    origin: Origin<'py>,
}

impl PageScene<'_> {
    /// The scene in memory, with the columns of `keep`, or all. Mistakes are named as keywords.
    fn memory(self, py: Python<'_>, keep: Option<&[String]>) -> PyResult<MemoryScene> {
        let Self { scene, renderer, native_camera, size, options, lens, origin } = self;
        let (shown, renderer, camera) = (scene.get(), &*renderer, &*native_camera);
        let Chosen { written: mut rendering, choices, .. } = Chosen::of(&options)?;
        rendering.extend(written(&lens, Call::Camera)?);
        // Edges that are drawn already are not drawn again.
        rendering.retain(|(id, _)| !(shown.outlined && id == "outline"));
        let mut copied = written(&origin.reading, Call::Read)?;
        copied.extend(rendering.iter().cloned().chain(written(&origin.renderer, Call::Renderer)?));
        let source = origin.file;
        Job::default().run(py, None, || {
            let first = shown.chosen(Some(camera), Some(size), shown.frame.number)?;
            choices.picture(first, &[Aov::Color], renderer.backend)?;
            let mut content = Content {
                frames: vec![shown.frame.clone()],
                edges: shown.edges(),
                name: shown.file.clone().unwrap_or_else(|| "scene".into()),
                source,
                rendering,
                copied,
                camera: pose_of(shown, camera, size)?,
                size: size.into(),
                is_sized: false,
                is_framed: false,
                text: PageText::default(),
            };
            keep.map_or(Ok(()), |names| content.keep(names))?;
            Ok(MemoryScene {
                content,
                renderer: renderer.shared.place(),
                backend: renderer.backend,
                words: in_keywords,
            })
        })
    }
}

/// The file of a page that shows a scene without a server, with these words around it, and the warnings of its picture. `columns` are
/// the names of those that it has.
#[pyfunction]
pub(crate) fn page(
    py: Python<'_>,
    page_scene: PageScene<'_>,
    columns: Vec<String>,
    title: Option<String>,
    caption: Option<String>,
) -> PyResult<(String, Vec<String>)> {
    let mut memory = page_scene.memory(py, Some(&columns))?;
    memory.content.text = PageText { title, caption };
    let made = Job::default().run(py, None, || shown::make_page(memory))?;
    Ok((made.html, made.warnings))
}

/// Writes the file of a page.
#[pyfunction]
pub(crate) fn save_page(py: Python<'_>, path: PathBuf, html: String) -> PyResult<()> {
    py.detach(|| write_atomically(&path, |out| out.write_all(html.as_bytes()))).or_raise()
}

#[pymethods]
impl Desk {
    #[new]
    fn new(py: Python<'_>, page_scene: PageScene<'_>) -> PyResult<Self> {
        let scene = page_scene.scene.clone_ref(py);
        let memory = page_scene.memory(py, None)?;
        let first = FrameRequest::still(memory.content.camera, memory.content.size);
        let stage = Job::default().run(py, None, || shown::stage(memory))?;
        let routes = Arc::new(Routes::new(Arc::clone(&stage)));
        Ok(Self { scene, first, stage, routes })
    }

    /// A camera as the page has it, as JSON.
    fn pose_of(&self, camera: &Camera) -> PyResult<String> {
        let [width, height] = self.first.size;
        pose_of(self.scene.get(), camera, (width, height)).map(|pose| json(&pose)).or_raise()
    }

    /// Takes a question of the page, which another thread answers.
    fn ask(&self, route: &str, body: &str) -> PyResult<Question> {
        begin()?;
        let answer = self.routes.take(route.trim_start_matches('/'), body.as_bytes());
        let (sender, receiver) = channel();
        let work = thread::Builder::new().name("halfline".into()).spawn(move || sender.send(answer()));
        work.map_err(|error| exception(no_thread(&error)))?;
        Ok(Question(Mutex::new(receiver)))
    }

    /// Checks the expression of a selection.
    fn select(&self, py: Python<'_>, expression: &str) -> PyResult<()> {
        begin()?;
        let request = SelectRequest { expr: Some(expression.to_owned()), ..SelectRequest::default() };
        py.detach(|| self.stage.select(&request)).map(drop).map_err(raised)
    }

    /// The PNG of the picture with which it begins.
    fn still<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let job = Job::default();
        let cancel = job.cancel.clone();
        let go_on: GoOn = Arc::new(move || !cancel.is_cancelled());
        let picture = job.run(py, None, || Ok(self.stage.frame(&self.first, &go_on)))?.map_err(raised)?;
        match picture.map(|picture| picture.pixels) {
            Some(Pixels::Png(bytes)) => Ok(PyBytes::new(py, &bytes)),
            _ => Err(exception(halfline::Error::Interrupted)),
        }
    }

    /// Gives up what is rendered and what waits.
    fn close(&self) {
        self.routes.close();
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        if is_forked() {
            // As for a renderer.
            std::mem::forget(Arc::clone(&self.stage));
        }
    }
}

/// A status, JSON, and a picture.
type PyAnswer<'py> = (u16, String, Option<Bound<'py, PyBytes>>);

/// A question of the page.
#[pyclass(frozen)]
pub(crate) struct Question(Mutex<Receiver<Reply>>);

#[pymethods]
impl Question {
    /// The answer: its status, its JSON, and its picture if it has one. `None` if there is none yet after a short while.
    fn wait<'py>(&self, py: Python<'py>) -> PyResult<Option<PyAnswer<'py>>> {
        let receiver = &self.0;
        let received = py.detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(SLICE));
        let Reply { status, halfline, body, .. } = match received {
            Ok(reply) => reply,
            Err(RecvTimeoutError::Timeout) => return Ok(None),
            Err(error) => return Err(PyValueError::new_err(error.to_string())),
        };
        Ok(Some(match halfline {
            Some(info) => (status, info, Some(PyBytes::new(py, &body))),
            None => (status, String::from_utf8_lossy(&body).into_owned(), None),
        }))
    }
}

/// The exception for a refusal.
fn raised(Refusal { kind, message, .. }: Refusal) -> PyErr {
    match kind {
        "accuracy" => AccuracyError::new_err(message),
        "adapter" | "device-lost" => AdapterError::new_err(message),
        "limits" => PyMemoryError::new_err(message),
        _ => PyValueError::new_err(message),
    }
}

/// A camera of the page, checked, as JSON.
#[pyfunction]
pub(crate) fn pose(camera: &str) -> PyResult<String> {
    let wrong = |error: serde_json::Error| PyValueError::new_err(error.to_string());
    let pose: Pose = serde_json::from_str(camera).map_err(wrong)?;
    let lens = match pose.lens {
        Lens::Vfov(degrees) => ("vfov".to_owned(), vec![degrees, 1.0]),
        Lens::Height(height) => ("height".to_owned(), vec![height]),
        // The options that it becomes are checked with each picture.
        Lens::Named(_) => ("vfov".to_owned(), vec![90.0, 1.0]),
    };
    Camera::new(pose.eye, Some(pose.at), None, pose.up, lens, None, None, None)?;
    Ok(json(&pose))
}

/// Finite numbers are always JSON.
fn json(pose: &Pose) -> String {
    serde_json::to_string(pose).unwrap_or_default()
}
