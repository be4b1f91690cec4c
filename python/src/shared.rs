//! A renderer that a Python renderer shares with its frames.

use crate::work::{Job, is_forked};
use halfline::{Error, Frame, Renderer, Result};
use std::sync::{Arc, Mutex};

/// The renderer, which one thread uses at a time; the others wait.
#[derive(Clone)]
pub(crate) struct Shared(Arc<Mutex<Option<Renderer>>>);

impl Shared {
    pub(crate) fn new(renderer: Renderer) -> Self {
        Self(Arc::new(Mutex::new(Some(renderer))))
    }

    /// The place of the renderer, which one user at a time locks.
    pub(crate) fn place(&self) -> Arc<Mutex<Option<Renderer>>> {
        Arc::clone(&self.0)
    }

    /// Runs `work` with the renderer, which reports to the job.
    pub(crate) fn with<T>(&self, job: &Job, work: impl FnOnce(&mut Renderer) -> Result<T>) -> Result<T> {
        let mut place = job.lock(&self.0)?;
        let renderer = place.take().ok_or_else(|| Error::Adapter {
            problem: "an earlier failure of the program ended this renderer".into(),
            mend: "make another one".into(),
        })?;
        let mut renderer = renderer.watched_by(job.watch());
        let result = work(&mut renderer);
        *place = Some(renderer);
        result
    }

    /// Gives the memory of a frame back, unless the renderer is at work, which does not wait for memory.
    pub(crate) fn recycle(&self, frame: Frame) {
        if let Ok(mut place) = self.0.try_lock()
            && let Some(renderer) = place.as_mut()
        {
            renderer.recycle(frame);
        }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        if is_forked() {
            // The device of the process that this one was forked from would wait for threads that are not here.
            std::mem::forget(Arc::clone(&self.0));
        }
    }
}
