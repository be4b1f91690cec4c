//! Work on another thread, while the calling one waits without the interpreter's lock, handles signals and reports
//! progress. It belongs to one process: after a fork neither the threads nor the device are in the child.

use crate::errors::OrRaise;
use halfline::{Cancel, Error, Progress, Watch};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;
use std::time::Duration;

/// The time between two looks at signals and progress.
pub(crate) const SLICE: Duration = Duration::from_millis(50);

/// The process that started the threads, 0 before.
static PROCESS: AtomicU32 = AtomicU32::new(0);

/// Whether the threads were started in a process that this one was forked from; there is nothing to wait for here.
pub(crate) fn is_forked() -> bool {
    ![0, std::process::id()].contains(&PROCESS.load(Ordering::Relaxed))
}

/// Says that threads are started in this process, unless they were in one that it was forked from.
///
/// # Errors
/// RuntimeError with the mend, instead of waiting for ever.
pub(crate) fn begin() -> PyResult<()> {
    let here = std::process::id();
    match PROCESS.compare_exchange(0, here, Ordering::Relaxed, Ordering::Relaxed) {
        Err(first) if first != here => Err(PyRuntimeError::new_err(format!(
            "halfline was used in process {first}, and process {here} was forked from it: neither its threads nor its \
             device are here; start processes with multiprocessing.get_context(\"spawn\"), or use halfline in the \
             forked processes only"
        ))),
        _ => Ok(()),
    }
}

/// Work that can be cancelled and watched.
#[derive(Clone, Default)]
pub(crate) struct Job {
    pub(crate) cancel: Cancel,
    latest: Arc<Mutex<Option<Progress>>>,
}

impl Job {
    /// A watch that ends the work after a cancellation, and keeps its latest progress.
    pub(crate) fn watch(&self) -> Watch {
        let latest = Arc::clone(&self.latest);
        Watch::default()
            .cancelled_by(&self.cancel)
            .on_progress(move |progress| *latest.lock().unwrap_or_else(PoisonError::into_inner) = Some(progress))
    }

    /// Sets the progress, for work that counts itself.
    pub(crate) fn reached(&self, progress: Progress) {
        *self.latest.lock().unwrap_or_else(PoisonError::into_inner) = Some(progress);
    }

    /// Handles signals, and calls `callback(step, done, total, unit)` if there is progress.
    pub(crate) fn look(&self, py: Python<'_>, callback: Option<&Py<PyAny>>) -> PyResult<()> {
        py.check_signals()?;
        let Some(callback) = callback else { return Ok(()) };
        let latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(Progress { step, done, total }) = latest {
            callback.call1(py, (step.name(), done, total, step.unit()))?;
        }
        Ok(())
    }

    /// Runs `work` on another thread. An exception of a signal handler (ctrl-C) or of the callback cancels it.
    pub(crate) fn run<T: Send>(
        &self,
        py: Python<'_>,
        callback: Option<&Py<PyAny>>,
        work: impl FnOnce() -> halfline::Result<T> + Send,
    ) -> PyResult<T> {
        begin()?;
        let (result, stop) = py.detach(|| {
            thread::scope(|scope| {
                let (done, wait) = channel::<()>();
                let worker = thread::Builder::new().name("halfline".into()).spawn_scoped(scope, move || {
                    // Dropped at the end, also of a panic.
                    let _done = done;
                    work()
                });
                let worker = match worker {
                    Ok(worker) => worker,
                    Err(error) => return (Err(no_thread(&error)), None),
                };
                let mut stop = None;
                while wait.recv_timeout(SLICE) == Err(RecvTimeoutError::Timeout) {
                    if stop.is_none()
                        && let Err(exception) = Python::attach(|py| self.look(py, callback))
                    {
                        self.cancel.cancel();
                        stop = Some(exception);
                    }
                }
                (worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), stop)
            })
        });
        match stop {
            Some(exception) => Err(exception),
            None => {
                let value = result.or_raise()?;
                self.look(py, callback)?;
                Ok(value)
            }
        }
    }

    /// Waits for a lock, unless the work is cancelled.
    pub(crate) fn lock<'a, T>(&self, mutex: &'a Mutex<T>) -> halfline::Result<MutexGuard<'a, T>> {
        loop {
            match mutex.try_lock() {
                Ok(guard) => return Ok(guard),
                Err(TryLockError::Poisoned(poisoned)) => return Ok(poisoned.into_inner()),
                Err(TryLockError::WouldBlock) if self.cancel.is_cancelled() => return Err(Error::Interrupted),
                Err(TryLockError::WouldBlock) => thread::sleep(Duration::from_millis(1)),
            }
        }
    }
}

/// The error of a system that starts no thread.
pub(crate) fn no_thread(error: &std::io::Error) -> Error {
    Error::Limits {
        problem: format!("no thread could be started: {error}"),
        mend: "allow the process more threads".into(),
    }
}
