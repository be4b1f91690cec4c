//! How far long work is, for people at a terminal: a line on stderr that comes after a second and goes with the work.

use super::go_on;
use super::lines::{Lines, Talk};
use halfline::progress::{Progress, Step, Watch};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A frame that is done sooner shows nothing.
const LONG: Duration = Duration::from_secs(1);

/// How often the line is drawn.
const TICK: Duration = Duration::from_millis(100);

/// The line. The threads that work only leave a note; another draws it.
pub(super) struct Bar {
    /// What programs hear instead.
    lines: Option<Arc<Mutex<Lines>>>,
    notes: Arc<Mutex<Notes>>,
    line: ProgressBar,
    /// Dropped to end the drawing; `None` where nobody looks.
    drawing: Option<(Sender<()>, JoinHandle<()>)>,
}

/// What was heard last.
#[derive(Default)]
struct Notes {
    latest: Option<Progress>,
    /// When the frame and its step began.
    frame: Option<Instant>,
    step: Option<Instant>,
    /// When that much was done.
    heard: Option<Instant>,
}

impl Bar {
    pub(super) fn new() -> Self {
        Self::talking(Talk::Auto, 1)
    }

    /// The line, or what else shall be told of so many frames.
    pub(super) fn talking(talk: Talk, frames: u32) -> Self {
        let notes = Arc::<Mutex<Notes>>::default();
        let line = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        let lines = matches!(talk, Talk::Json | Talk::Openjd).then(|| Arc::new(Mutex::new(Lines::new(talk, frames))));
        let drawing = if talk == Talk::Auto && std::io::stderr().is_terminal() {
            let (stop, stopped) = mpsc::channel();
            let (notes, line) = (Arc::clone(&notes), line.clone());
            let draw = move || {
                let mut artist = Artist { line, step: None };
                while stopped.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                    artist.draw(&notes.lock().unwrap_or_else(PoisonError::into_inner));
                }
                artist.line.finish_and_clear();
            };
            // Where the system allows no more threads there is no line.
            std::thread::Builder::new().spawn(draw).ok().map(|drawing| (stop, drawing))
        } else {
            None
        };
        Self { lines, notes, line, drawing }
    }

    /// Ends work on an interrupt, and tells the line about it.
    pub(super) fn watch(&self) -> Watch {
        let watch = Watch::default().while_true(go_on);
        if let Some(lines) = self.lines.clone() {
            return watch.telling(move |progress| lines.lock().unwrap_or_else(PoisonError::into_inner).hear(progress));
        }
        if self.drawing.is_none() {
            return watch;
        }
        let notes = Arc::clone(&self.notes);
        watch.telling(move |progress| notes.lock().unwrap_or_else(PoisonError::into_inner).hear(progress))
    }

    /// All is done and written.
    pub(super) fn finish(self) {
        if let Some(lines) = &self.lines {
            lines.lock().unwrap_or_else(PoisonError::into_inner).finish();
        }
    }

    /// Says something without drawing over it.
    pub(super) fn aside<T>(&self, say: impl FnOnce() -> T) -> T {
        self.line.suspend(say)
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some((stop, drawing)) = self.drawing.take() {
            drop(stop);
            // A line that cannot be drawn is no reason to fail.
            let _ = drawing.join();
        }
    }
}

impl Notes {
    fn hear(&mut self, progress: Progress) {
        let now = Instant::now();
        if self.latest.is_none_or(|latest| latest.step != progress.step || latest.done > progress.done) {
            self.step = Some(now);
            // A frame begins with staging; the judge of a measurement has no other step.
            if progress.step == Step::Stage || self.latest.is_none_or(|latest| latest.step >= progress.step) {
                self.frame = self.step;
            }
        }
        self.latest = Some(progress);
        self.heard = Some(now);
    }
}

/// Who draws.
struct Artist {
    line: ProgressBar,
    /// The step on the line and its beginning; `None` while nothing is shown.
    step: Option<(Step, Instant)>,
}

impl Artist {
    fn draw(&mut self, notes: &Notes) {
        let Notes { latest: Some(progress), frame: Some(frame), step: Some(began), heard: Some(heard) } = *notes else {
            return;
        };
        let Progress { step, done, total } = progress;
        if frame.elapsed() < LONG {
            if self.step.take().is_some() {
                // Hiding alone would leave the line where it is.
                self.line.finish_and_clear();
                self.line.set_draw_target(ProgressDrawTarget::hidden());
                self.line.reset();
            }
            return;
        }
        let shown = self.step.is_some();
        if self.step != Some((step, began)) {
            self.step = Some((step, began));
            self.line.set_style(style(step));
            self.line.set_length(total);
        }
        self.line.set_message(words(progress, heard.duration_since(began), heard.elapsed()));
        self.line.set_position(done);
        if !shown {
            self.line.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.line.tick();
    }
}

/// Staging tells nothing between its ends, so it has no bar.
fn style(step: Step) -> ProgressStyle {
    let template = if step == Step::Stage { "{spinner} {msg}" } else { "{wide_bar} {percent:>3} %  {msg}" };
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// What is being done, how fast, and how long it will take at that rate: `done` took `spent`, `since` ago.
fn words(Progress { step, done, total }: Progress, spent: Duration, since: Duration) -> String {
    let (name, unit, since) = (step.name(), step.unit(), since.as_secs_f64());
    if step == Step::Stage || done == 0 {
        return format!("{name} {}{unit}, {}", quantity(total as f64), span(since));
    }
    let rate = done as f64 / spent.as_secs_f64().max(1e-9);
    format!("{name} {}{unit}/s, {} left", quantity(rate), span((total - done) as f64 / rate - since))
}

/// A number of three digits and its thousands.
fn quantity(x: f64) -> String {
    let (unit, mark) = [(1e9, " G"), (1e6, " M"), (1e3, " k")].into_iter().find(|(u, _)| x >= *u).unwrap_or((1.0, " "));
    let x = x / unit;
    let digits = if x < 10.0 { 2 } else { usize::from(x < 100.0) };
    format!("{x:.digits$}{mark}")
}

/// A time for people.
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
    }

    #[test]
    fn progress_begins_with_the_first_step_of_a_frame() {
        let mut notes = Notes::default();
        let mut hear = |step, done| {
            notes.hear(Progress { step, done, total: 10 });
            (notes.frame, notes.step)
        };
        let stage = hear(Step::Stage, 0);
        assert_eq!(stage.0, stage.1);
        hear(Step::Stage, 10);
        let trace = hear(Step::Trace, 0);
        assert!(trace.0 == stage.0 && trace.1 > stage.1, "another step of the same frame");
        assert_eq!(hear(Step::Trace, 5), trace);
        let again = hear(Step::Stage, 0);
        assert!(again.0 > trace.1, "another frame");
    }
}
