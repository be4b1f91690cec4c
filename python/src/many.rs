//! Frames of many cameras: another thread renders the next one while Python handles the current one.

use crate::camera::Camera;
use crate::errors::{OrRaise, exception};
use crate::frame::Frame;
use crate::scene::Scene;
use crate::shared::Shared;
use crate::words::Chosen;
use crate::work::{Job, SLICE, begin, is_forked, no_thread};
use halfline::settings::Backend;
use halfline_command::choices::{ChosenPicture, Rendered};
use pyo3::prelude::*;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};

/// A rendered picture.
type Made = halfline::Result<Rendered>;

/// Picture `number` of a scene with this camera.
fn picture_of<'a>(
    scene: &'a Scene,
    camera: &Camera,
    chosen: &'a Chosen,
    number: u64,
    backend: Backend,
) -> halfline::Result<ChosenPicture<'a>> {
    chosen.choices.picture(scene.chosen(Some(camera), chosen.choices.size(), number)?, &chosen.aovs, backend)
}

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
        chosen: Chosen,
        backend: Backend,
    ) -> PyResult<Self> {
        begin()?;
        // The first one is checked at once, so that an error has the caller's line.
        if let Some(first) = cameras.first() {
            let first = || picture_of(scene.get(), first, &chosen, 1, backend).map(drop);
            py.detach(first).or_raise()?;
        }
        // A frame is handed over when the one before it is done, so there are at most two.
        let (sender, frames) = sync_channel(0);
        let (job, count, single) = (Job::default(), cameras.len(), chosen.single);
        let (own, shared) = (job.clone(), renderer.clone());
        let work = move || {
            for (number, camera) in (1..).zip(&cameras) {
                let render = || {
                    let picture = picture_of(scene.get(), camera, &chosen, number, backend)?;
                    let rendered = shared.with(&own, |renderer| picture.render(renderer))?;
                    // All frames have the same legend.
                    if number == 1 {
                        picture.write_legend()?
                    }
                    Ok(rendered)
                };
                let rendered = render();
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
                Some(Ok(Ok(rendered))) => {
                    return Ok(Some(Frame::new(rendered, self.single, self.renderer.clone())));
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
