//! Progress reporting and cancellation.

use crate::error::{Error, Result};
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// A step of the work on a frame that may take long; the variants are in the order of the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Step {
    /// Spheres are transformed into camera space and binned into candidate lists. Reported at its beginning and its end.
    Stage,
    /// Rays are traced.
    Trace,
    /// Pixels are decided in exact arithmetic: those that a certified kernel could not prove, or all of them with
    /// accuracy `exact`.
    Settle,
    /// Rays from the hits to lights and to the sky are traced.
    Light,
    /// Given rays are traced. Where their number is not known beforehand, the total is 0.
    Rays,
}

impl Step {
    /// The name, one word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Stage => "stage",
            Self::Trace | Self::Rays => "trace",
            Self::Settle => "settle",
            Self::Light => "light",
        }
    }

    /// The plural noun of the step's count: `spheres`, `pixels` or `rays`.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Stage => "spheres",
            Self::Trace | Self::Settle | Self::Light => "pixels",
            Self::Rays => "rays",
        }
    }
}

/// Progress of one step. `done` never decreases within a step: it starts at 0 and ends at `total` unless the frame
/// fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// The current step.
    pub step: Step,
    /// The number of spheres, pixels or rays that are done; rows that threads are working on count as done.
    pub done: u64,
    /// The total number of spheres, pixels or rays, as [`Step::unit`] says.
    pub total: u64,
}

impl Progress {
    /// The total, where it is known.
    #[must_use]
    pub fn known_total(&self) -> Option<u64> {
        (self.step != Step::Rays || self.total > 0).then_some(self.total)
    }
}

/// A token that cancels work, from another thread or from the progress callback. Clones are the same token.
#[derive(Debug, Clone, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Cancels the work that watches this token. It ends soon with [`Error::Interrupted`]: after a band of rows on an
    /// adapter, after a few rows on the CPU path.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Clears the token, so that new work can begin.
    pub fn reset(&self) {
        self.0.store(false, Ordering::Relaxed);
    }

    /// Whether it was cancelled.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The interval at which a thread that waits for another one checks for cancellation.
const PATIENCE: Duration = Duration::from_millis(20);

type GoOn = dyn Fn() -> bool + Send + Sync;
type Callback = dyn FnMut(Progress) + Send;

/// Watches long work: callbacks that report progress and that may cancel it. The default does neither.
#[derive(Clone)]
pub struct Watch {
    go_on: Arc<GoOn>,
    callback: Option<Arc<Mutex<Callback>>>,
}

impl Default for Watch {
    fn default() -> Self {
        Self { go_on: Arc::new(|| true), callback: None }
    }
}

impl fmt::Debug for Watch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Watch").field("callback", &self.callback.is_some()).finish_non_exhaustive()
    }
}

impl Watch {
    /// Calls `go_on` before every band of rows on an adapter, before every row on the CPU path, and between the steps. When
    /// it returns false, the work ends with [`Error::Interrupted`]. Several callbacks are combined: each may end the work.
    #[must_use]
    pub fn while_true(mut self, go_on: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        let others = self.go_on;
        self.go_on = Arc::new(move || others() && go_on());
        self
    }

    /// Ends the work when the token is cancelled.
    #[must_use]
    pub fn cancelled_by(self, cancel: &Cancel) -> Self {
        let cancel = cancel.clone();
        self.while_true(move || !cancel.is_cancelled())
    }

    /// Reports progress to `callback` from the working threads, often but one call at a time, so `callback` should be quick. A
    /// later callback replaces an earlier one.
    #[must_use]
    pub fn on_progress(mut self, callback: impl FnMut(Progress) + Send + 'static) -> Self {
        self.callback = Some(Arc::new(Mutex::new(callback)));
        self
    }

    /// Whether the work may go on.
    pub fn goes_on(&self) -> bool {
        (self.go_on)()
    }

    /// Checks for cancellation.
    ///
    /// # Errors
    /// [`Error::Interrupted`] if the work was cancelled.
    pub fn check(&self) -> Result<()> {
        if self.goes_on() { Ok(()) } else { Err(Error::Interrupted) }
    }

    /// Runs uninterruptible work on a separate thread and waits until it is done or cancelled. After a cancellation the
    /// thread runs on until its work or the process ends.
    ///
    /// # Errors
    /// Errors of `work`, [`Error::Interrupted`], and [`Error::Limits`] where no thread can be started.
    pub fn wait_for<T: Send + 'static>(&self, work: impl FnOnce() -> Result<T> + Send + 'static) -> Result<T> {
        let worker = thread::Builder::new().name("halfline work".into()).spawn(work).map_err(|e| Error::Limits {
            problem: format!("no thread could be started: {e}"),
            mend: "allow the process more threads".into(),
        })?;
        while !worker.is_finished() {
            self.check()?;
            thread::park_timeout(PATIENCE);
        }
        worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }

    /// Begins a step of `total` spheres or pixels.
    pub fn begin(&self, step: Step, total: u64) -> Doing<'_> {
        let doing = Doing { watch: self, step, total, done: AtomicU64::new(0) };
        doing.report();
        doing
    }
}

/// A running step.
pub struct Doing<'a> {
    watch: &'a Watch,
    step: Step,
    total: u64,
    done: AtomicU64,
}

impl Doing<'_> {
    /// Reports that `more` are about to be done; returns whether to do them.
    pub fn next(&self, more: u64) -> bool {
        let on = self.watch.goes_on();
        if on {
            self.done.fetch_add(more, Ordering::Relaxed);
            self.report();
        }
        on
    }

    /// Reports that `done` are done in all, no fewer than before; returns whether to go on.
    pub fn reached(&self, done: u64) -> bool {
        self.done.fetch_max(done, Ordering::Relaxed);
        self.report();
        self.watch.goes_on()
    }

    /// Ends the step.
    ///
    /// # Errors
    /// [`Error::Interrupted`] if the work was cancelled, even if it is complete.
    pub fn end(self) -> Result<()> {
        self.watch.check()?;
        self.done.store(self.total, Ordering::Relaxed);
        // The last report must not be dropped, so this waits for the lock.
        if let Some(callback) = &self.watch.callback {
            self.report_to(&mut *callback.lock().unwrap_or_else(PoisonError::into_inner));
        }
        Ok(())
    }

    /// Reporting never blocks a worker: if another thread is reporting, its next report includes this one.
    fn report(&self) {
        if let Some(Ok(mut callback)) = self.watch.callback.as_ref().map(|callback| callback.try_lock()) {
            self.report_to(&mut *callback);
        }
    }

    /// Reads the count under the lock, so that reports never decrease.
    fn report_to(&self, callback: &mut Callback) {
        let done = self.done.load(Ordering::Relaxed).min(self.total);
        callback(Progress { step: self.step, done, total: self.total });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    /// Watches everything.
    fn listener() -> (Watch, Arc<Mutex<Vec<Progress>>>) {
        let reported = Arc::new(Mutex::new(Vec::new()));
        let ear = Arc::clone(&reported);
        (Watch::default().on_progress(move |p| ear.lock().expect("an ear").push(p)), reported)
    }

    #[test]
    fn progress_of_many_threads_is_reported_in_order_and_completely() {
        let (watch, reported) = listener();
        let doing = watch.begin(Step::Trace, 7000);
        (0..1000).into_par_iter().for_each(|_| assert!(doing.next(7)));
        doing.end().expect("not cancelled");
        let reported = reported.lock().expect("an ear");
        assert_eq!((reported[0].done, reported[reported.len() - 1].done), (0, 7000));
        assert!(reported.is_sorted_by_key(|p| p.done) && reported.iter().all(|p| p.total == 7000), "{reported:?}");
    }

    #[test]
    fn a_step_is_reported_at_both_ends() {
        let (watch, reported) = listener();
        watch.begin(Step::Stage, 3).end().expect("no condition cancels it");
        let of = |done| Progress { step: Step::Stage, done, total: 3 };
        assert_eq!(*reported.lock().expect("an ear"), [of(0), of(3)]);
    }

    #[test]
    fn any_clone_cancels_and_a_token_can_be_reset() {
        let cancel = Cancel::default();
        let watch = Watch::default().while_true(|| true).cancelled_by(&cancel);
        assert!(watch.begin(Step::Settle, 1).next(1));
        cancel.clone().cancel();
        assert!(cancel.is_cancelled() && matches!(watch.check(), Err(Error::Interrupted)));
        let doing = watch.begin(Step::Settle, 1);
        assert!(!doing.next(1) && matches!(doing.end(), Err(Error::Interrupted)));
        cancel.reset();
        assert!(watch.check().is_ok());
        assert!(watch.while_true(|| false).check().is_err(), "a further condition also cancels");
    }
}
