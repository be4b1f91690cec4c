//! Frames of many cameras: other threads render the next ones while Python handles the current one.

use crate::camera::Camera;
use crate::errors::{OrRaise, exception};
use crate::frame::Frame;
use crate::scene::Scene;
use crate::shared::Shared;
use crate::words::Chosen;
use crate::work::{Job, SLICE, begin, is_forked, no_thread};
use halfline::Error;
use halfline::settings::Backend;
use halfline_command::choices::{ChosenPicture, Rendered};
use halfline_command::pipeline;
use pyo3::prelude::*;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};

/// A rendered picture, and the renderer that made it.
type Made = halfline::Result<(Rendered, Shared)>;

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

/// Renders the pictures that `next` makes, by their numbers from 1, with so many renderers on one device, and hands them to `done` in
/// order.
fn each_frame<'a>(
    renderer: &Shared,
    job: &Job,
    lanes: usize,
    next: impl Fn(u64) -> halfline::Result<Option<ChosenPicture<'a>>> + Sync,
    done: impl FnMut((Rendered, Shared)) -> halfline::Result<()>,
) -> halfline::Result<()> {
    let others =
        renderer.with(job, |renderer| Ok((1..lanes).map(|_| Shared::new(renderer.another())).collect::<Vec<_>>()))?;
    let mut number = 0;
    let numbered = || {
        number += 1;
        Ok(next(number)?.map(|picture| (number, picture)))
    };
    let each = |lane: &mut Shared, (number, picture): (u64, ChosenPicture<'a>)| {
        let rendered = lane.with(job, |renderer| picture.render(renderer))?;
        // All frames have the same legend.
        if number == 1 {
            picture.write_legend()?;
        }
        Ok((rendered, lane.clone()))
    };
    let lanes = std::iter::once(renderer.clone()).chain(others).collect();
    pipeline(numbered, lanes, &job.cancel, each, done)
}

/// The frames of many cameras, ahead of the caller.
#[pyclass(frozen)]
pub(crate) struct Frames {
    frames: Mutex<Option<Receiver<Made>>>,
    worker: Mutex<Option<JoinHandle<()>>>,
    job: Job,
    single: bool,
    #[pyo3(get)]
    count: usize,
}

impl Frames {
    pub(crate) fn start(
        py: Python<'_>,
        (renderer, backend, is_gpu): (Shared, Backend, bool),
        scene: Py<Scene>,
        cameras: Vec<Camera>,
        chosen: Chosen,
    ) -> PyResult<Self> {
        begin()?;
        // The first one is checked at once, so that an error has the caller's line.
        let lanes = cameras.first().map_or(Ok(1), |first| {
            let first = || Ok(picture_of(scene.get(), first, &chosen, 1, backend)?.together(is_gpu));
            py.detach(first).or_raise()
        })?;
        let lanes = lanes.min(cameras.len());
        // A frame is handed over when the one before it is done.
        let (sender, frames) = sync_channel::<Made>(0);
        let (job, count, single) = (Job::default(), cameras.len(), chosen.single);
        let own = job.clone();
        let work = move || {
            let made = each_frame(
                &renderer,
                &own,
                lanes,
                |number| {
                    let camera = cameras.get(number as usize - 1);
                    camera.map(|camera| picture_of(scene.get(), camera, &chosen, number, backend)).transpose()
                },
                |made| sender.send(Ok(made)).map_err(|_| Error::Interrupted),
            );
            if let Err(error) = made {
                // After a close there is no receiver.
                let _ = sender.send(Err(error));
            }
        };
        let worker = Builder::new().name("halfline".into()).spawn(work).map_err(|e| exception(no_thread(&e)))?;
        let (frames, worker) = (Mutex::new(Some(frames)), Mutex::new(Some(worker)));
        Ok(Self { frames, worker, job, single, count })
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
                Some(Ok(Ok((rendered, renderer)))) => {
                    return Ok(Some(Frame::new(rendered, self.single, renderer)));
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
