//! Frames of many cameras: another thread renders the next one while Python handles the current one.

use crate::camera::Camera;
use crate::errors::{OrRaise, exception};
use crate::frame::Frame;
use crate::options::{Picture, Rendered};
use crate::scene::Scene;
use crate::shared::Shared;
use crate::work::{Job, SLICE, begin, is_forked, no_thread};
use halfline::settings::{Backend, Settings};
use pyo3::prelude::*;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};

/// A rendered picture and its settings.
type Made = halfline::Result<(Rendered, Settings)>;

/// The frames of many cameras, one ahead of the caller.
#[pyclass(frozen)]
pub(crate) struct Frames {
    frames: Mutex<Option<Receiver<Made>>>,
    worker: Mutex<Option<JoinHandle<()>>>,
    job: Job,
    single: bool,
    renderer: Shared,
    #[pyo3(get)]
    count: usize,
}

impl Frames {
    pub(crate) fn start(
        py: Python<'_>,
        renderer: Shared,
        scene: Py<Scene>,
        cameras: Vec<Camera>,
        picture: Picture,
        (accurate, backend): (Settings, Backend),
    ) -> PyResult<Self> {
        begin()?;
        let outlined = py.detach(|| picture.begin(scene.get())).or_raise()?;
        let scene = outlined.map_or(Ok(scene), |outlined| Py::new(py, outlined))?;
        // The first one is checked at once, so that an error has the caller's line.
        if let Some(first) = cameras.first() {
            picture.scene(scene.get(), Some(first)).and_then(|(scene, _)| py.detach(|| scene.check())).or_raise()?;
        }
        // A frame is handed over when the one before it is done, so there are at most two.
        let (sender, frames) = sync_channel(0);
        let (job, count, single) = (Job::default(), cameras.len(), picture.single);
        let (own, shared) = (job.clone(), renderer.clone());
        let work = move || {
            for (number, camera) in (1..).zip(&cameras) {
                let scene = scene.get();
                let settings = picture.settings(scene, Some(camera), accurate.clone(), backend);
                let mut rendered = settings.and_then(|settings| {
                    let render = |exact: &_| shared.render(&own, exact, &settings, &scene.frame.skipped);
                    Ok((picture.render(scene, Some(camera), number, render)?, settings))
                });
                // All frames have the same legend.
                if number == 1 {
                    rendered = rendered.and_then(|rendered| picture.insets.write(scene).map(|()| rendered));
                }
                let is_last = rendered.is_err();
                if sender.send(rendered).is_err() || is_last {
                    return;
                }
            }
        };
        let worker = Builder::new().name("halfline".into()).spawn(work).map_err(|e| exception(no_thread(&e)))?;
        let (frames, worker) = (Mutex::new(Some(frames)), Mutex::new(Some(worker)));
        Ok(Self { frames, worker, job, single, renderer, count })
    }

    /// Cancels the work and waits for its end; a panic of the work goes on here.
    fn stop(&self, py: Python<'_>) {
        if is_forked() {
            return;
        }
        self.job.cancel.cancel();
        py.detach(|| {
            drop(self.frames.lock().unwrap_or_else(PoisonError::into_inner).take());
            let worker = self.worker.lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(Err(panic)) = worker.map(JoinHandle::join) {
                std::panic::resume_unwind(panic);
            }
        });
    }
}

#[pymethods]
impl Frames {
    fn __iter__(this: Bound<'_, Self>) -> Bound<'_, Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Frame>> {
        begin()?;
        loop {
            let next = py.detach(|| {
                let frames = self.frames.lock().unwrap_or_else(PoisonError::into_inner);
                frames.as_ref().map(|frames| frames.recv_timeout(SLICE))
            });
            match next {
                Some(Ok(Ok((rendered, settings)))) => {
                    return Ok(Some(Frame::new(rendered, self.single, settings, self.renderer.clone())));
                }
                Some(Ok(Err(error))) => {
                    self.stop(py);
                    return Err(exception(error));
                }
                Some(Err(RecvTimeoutError::Timeout)) => {
                    if let Err(exception) = self.job.look(py, None) {
                        self.stop(py);
                        return Err(exception);
                    }
                }
                Some(Err(RecvTimeoutError::Disconnected)) | None => {
                    self.stop(py);
                    return Ok(None);
                }
            }
        }
    }

    /// Ends the work.
    fn close(&self, py: Python<'_>) {
        self.stop(py);
    }
}

impl Drop for Frames {
    fn drop(&mut self) {
        if is_forked() {
            // Neither end of the channel nor the thread can be waited for.
            std::mem::forget(self.frames.get_mut().map(|frames| frames.take()).ok());
            std::mem::forget(self.worker.get_mut().map(|worker| worker.take()).ok());
            return;
        }
        // Without an interpreter there is nobody to wait for it.
        let _ = Python::try_attach(|py| self.stop(py));
    }
}
