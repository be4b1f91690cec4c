//! Progress on a terminal: a line on standard error that appears after a second and is cleared at the end.

use super::lines::{ProgressLines, ProgressOutput};
use super::messages::is_quiet;
use super::signals::watch;
use halfline::progress::{Progress, Step, Watch};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A faster frame shows no line.
const LONG: Duration = Duration::from_secs(1);

/// The interval at which the line is drawn.
const TICK: Duration = Duration::from_millis(100);

/// The progress line. Working threads only store their progress; another thread draws it.
pub(super) struct Bar {
    /// Progress lines for programs, used instead of the bar.
    lines: Option<Arc<Mutex<ProgressLines>>>,
    notes: Arc<Mutex<Notes>>,
    line: ProgressBar,
    /// Dropping it ends the drawing; `None` where there is no terminal.
    drawing: Option<(Sender<()>, JoinHandle<()>)>,
}

/// The latest progress.
#[derive(Default)]
struct Notes {
    latest: Option<Progress>,
    /// When the frame and its step began.
    frame: Option<Instant>,
    step: Option<Instant>,
    /// When that progress was reported.
    reported: Option<Instant>,
}

impl Bar {
    /// The progress line, or the chosen output for programs, for `frames` frames.
    pub(super) fn with_output(output: ProgressOutput, frames: u32) -> Self {
        let notes = Arc::<Mutex<Notes>>::default();
        let line = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        let lines = output.is_lines().then(|| Arc::new(Mutex::new(ProgressLines::new(output, frames))));
        let drawing = if output == ProgressOutput::Auto && !is_quiet() && std::io::stderr().is_terminal() {
            let (stop, stopped) = mpsc::channel();
            let (notes, line) = (Arc::clone(&notes), line.clone());
            let draw = move || {
                let mut artist = Artist { line, step: None };
                while stopped.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                    artist.draw(&notes.lock().unwrap_or_else(PoisonError::into_inner));
                }
                artist.line.finish_and_clear();
            };
            // Where the system allows no more threads, no line is drawn.
            std::thread::Builder::new().spawn(draw).ok().map(|drawing| (stop, drawing))
        } else {
            None
        };
        Self { lines, notes, line, drawing }
    }

    /// Ends work on an interrupt, and stores progress for the line.
    pub(super) fn watch(&self) -> Watch {
        let watch = watch();
        if let Some(lines) = self.lines.clone() {
            return watch
                .on_progress(move |progress| lines.lock().unwrap_or_else(PoisonError::into_inner).record(progress));
        }
        if self.drawing.is_none() {
            return watch;
        }
        let notes = Arc::clone(&self.notes);
        watch.on_progress(move |progress| notes.lock().unwrap_or_else(PoisonError::into_inner).record(progress))
    }

    /// Reports progress that does not come from a renderer.
    pub(super) fn report(&self, progress: Progress) {
        if let Some(lines) = &self.lines {
            lines.lock().unwrap_or_else(PoisonError::into_inner).record(progress);
        } else if self.drawing.is_some() {
            self.notes.lock().unwrap_or_else(PoisonError::into_inner).record(progress);
        }
    }

    /// Ends the line when all is rendered and written.
    pub(super) fn finish(self) {
        if let Some(lines) = &self.lines {
            lines.lock().unwrap_or_else(PoisonError::into_inner).finish();
        }
    }

    /// Prints a message without drawing over it.
    pub(super) fn aside<T>(&self, say: impl FnOnce() -> T) -> T {
        self.line.suspend(say)
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some((stop, drawing)) = self.drawing.take() {
            drop(stop);
            // A line that cannot be drawn is not an error.
            let _ = drawing.join();
        }
    }
}

impl Notes {
    fn record(&mut self, progress: Progress) {
        let now = Instant::now();
        if self.latest.is_none_or(|latest| latest.step != progress.step || latest.done > progress.done) {
            self.step = Some(now);
            // A frame begins with staging; exact decisions in `measure` have no other step.
            if progress.step == Step::Stage || self.latest.is_none_or(|latest| latest.step >= progress.step) {
                self.frame = self.step;
            }
        }
        self.latest = Some(progress);
        self.reported = Some(now);
    }
}

/// The drawing thread's state.
struct Artist {
    line: ProgressBar,
    /// The step on the line and when it began; `None` while nothing is shown.
    step: Option<(Step, Instant)>,
}

impl Artist {
    fn draw(&mut self, notes: &Notes) {
        let Notes { latest: Some(progress), frame: Some(frame), step: Some(began), reported: Some(reported) } = *notes
        else {
            return;
        };
        let Progress { step, done, total } = progress;
        if frame.elapsed() < LONG {
            if self.step.take().is_some() {
                // Hiding alone would leave the line on the screen.
                self.line.finish_and_clear();
                self.line.set_draw_target(ProgressDrawTarget::hidden());
                self.line.reset();
            }
            return;
        }
        let shown = self.step.is_some();
        if self.step != Some((step, began)) {
            self.step = Some((step, began));
            self.line.set_style(style(progress));
            self.line.set_length(total);
        }
        self.line.set_message(words(progress, reported.duration_since(began), reported.elapsed()));
        self.line.set_position(done);
        if !shown {
            self.line.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.line.tick();
    }
}

/// Staging reports only its beginning and its end, so it has no bar, nor has a step without a known end.
fn style(progress: Progress) -> ProgressStyle {
    let template = if progress.step == Step::Stage || progress.known_total().is_none() {
        "{spinner} {msg}"
    } else {
        "{wide_bar} {percent:>3} %  {msg}"
    };
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// The step, its rate and the remaining time at that rate: `done` took `spent`, reported `since` ago.
fn words(progress: Progress, spent: Duration, since: Duration) -> String {
    let Progress { step, done, total } = progress;
    let (name, unit, since) = (step.name(), step.unit(), since.as_secs_f64());
    if step == Step::Stage || done == 0 {
        return format!("{name} {}{unit}, {}", quantity(total as f64), span(since));
    }
    let rate = done as f64 / spent.as_secs_f64().max(1e-9);
    if progress.known_total().is_none() {
        return format!("{name} {}{unit}/s, {}{unit}", quantity(rate), quantity(done as f64));
    }
    format!("{name} {}{unit}/s, {} left", quantity(rate), span((total - done) as f64 / rate - since))
}

/// A number with three digits and a suffix for thousands.
fn quantity(x: f64) -> String {
    let (unit, mark) = [(1e9, " G"), (1e6, " M"), (1e3, " k")].into_iter().find(|(u, _)| x >= *u).unwrap_or((1.0, " "));
    let x = x / unit;
    let digits = if x < 10.0 { 2 } else { usize::from(x < 100.0) };
    format!("{x:.digits$}{mark}")
}

/// A duration in readable units.
fn span(seconds: f64) -> String {
    let whole = seconds.ceil().clamp(0.0, 359_999.0) as u64;
    let [hours, minutes, seconds] = [whole / 3600, whole / 60 % 60, whole % 60];
    if hours > 0 { format!("{hours}:{minutes:02}:{seconds:02}") } else { format!("{minutes}:{seconds:02}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_has_a_rate_and_a_time() {
        let at = |step, done| Progress { step, done, total: 8_294_400 };
        let [none, two] = [0, 2].map(Duration::from_secs);
        assert_eq!(words(at(Step::Trace, 2_073_600), two, none), "trace 1.04 Mpixels/s, 0:06 left");
        assert_eq!(words(at(Step::Trace, 2_073_600), two, two), "trace 1.04 Mpixels/s, 0:04 left");
        assert_eq!(
            words(at(Step::Trace, 8_294_300), two, two),
            "trace 4.15 Mpixels/s, 0:00 left",
            "late, not negative"
        );
        assert_eq!(words(at(Step::Settle, 90), two, none), "settle 45.0 pixels/s, 51:11:58 left");
        assert_eq!(words(at(Step::Trace, 0), none, two), "trace 8.29 Mpixels, 0:02");
        assert_eq!(words(at(Step::Stage, 0), none, two), "stage 8.29 Mspheres, 0:02");
        let endless = Progress { step: Step::Rays, done: 3_000_000, total: 0 };
        assert_eq!(words(endless, two, none), "trace 1.50 Mrays/s, 3.00 Mrays");
    }

    #[test]
    fn progress_begins_with_the_first_step_of_a_frame() {
        let mut notes = Notes::default();
        let mut record = |step, done| {
            notes.record(Progress { step, done, total: 10 });
            (notes.frame, notes.step)
        };
        let stage = record(Step::Stage, 0);
        assert_eq!(stage.0, stage.1);
        record(Step::Stage, 10);
        let trace = record(Step::Trace, 0);
        assert!(trace.0 == stage.0 && trace.1 > stage.1, "another step of the same frame");
        assert_eq!(record(Step::Trace, 5), trace);
        let again = record(Step::Stage, 0);
        assert!(again.0 > trace.1, "another frame");
    }
}
