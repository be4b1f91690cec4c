//! Progress on a terminal: a line on standard error that appears after a second and is cleared at the end.

use super::lines::{ProgressLines, ProgressOutput};
use super::messages::is_quiet;
use super::signals::watch;
use super::tally::Tally;
use halfline::progress::{Progress, Step, Watch};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use web_time::Instant;

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
    tally: Tally,
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
                let mut artist = Artist { line, shown: None };
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

    /// The following pictures have so many samples per pixel, and rays that go on from the hits; see [`Tally::expect`].
    pub(super) fn expect(&self, samples: u32, has_light: bool) {
        match &self.lines {
            Some(lines) => lines.lock().unwrap_or_else(PoisonError::into_inner).expect(samples, has_light),
            None => self.notes.lock().unwrap_or_else(PoisonError::into_inner).tally.expect(samples, has_light),
        }
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
    pub(super) fn suspended<T>(&self, say: impl FnOnce() -> T) -> T {
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
        if self.tally.latest.is_none_or(|latest| latest.step != progress.step || latest.done > progress.done) {
            self.step = Some(now);
        }
        if self.tally.record(progress) {
            self.frame = self.step;
        }
        self.reported = Some(now);
    }
}

/// The drawing thread's state.
struct Artist {
    line: ProgressBar,
    /// The picture on the line by its beginning, and whether it has a bar; `None` while nothing is shown.
    shown: Option<(Instant, bool)>,
}

/// The length of the bar of a picture.
const LENGTH: u64 = 1000;

impl Artist {
    fn draw(&mut self, notes: &Notes) {
        let Notes { tally, frame: Some(frame), step: Some(began), reported: Some(reported) } = *notes else { return };
        let Some(progress) = tally.latest else { return };
        if frame.elapsed() < LONG {
            if self.shown.take().is_some() {
                // Hiding alone would leave the line on the screen.
                self.line.finish_and_clear();
                self.line.set_draw_target(ProgressDrawTarget::hidden());
                self.line.reset();
            }
            return;
        }
        let shown = self.shown.is_some();
        let has_bar = tally.share() > 0.0;
        if self.shown != Some((frame, has_bar)) {
            self.shown = Some((frame, has_bar));
            self.line.set_style(style(has_bar));
            self.line.set_length(LENGTH);
        }
        let (share, spent) = (tally.share(), reported.duration_since(frame).as_secs_f64());
        let left = has_bar.then(|| spent * (1.0 - share) / share - reported.elapsed().as_secs_f64());
        self.line.set_message(words(&tally, progress, reported.duration_since(began), (reported.elapsed(), left)));
        self.line.set_position((share * LENGTH as f64) as u64);
        if !shown {
            self.line.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.line.tick();
    }
}

/// Staging reports only its beginning and its end, so until then there is no bar, nor is one for a step without a known end.
fn style(has_bar: bool) -> ProgressStyle {
    let template = if has_bar { "{wide_bar} {percent:>3} %  {msg}" } else { "{spinner} {msg}" };
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// The sample, the step, its rate, and the seconds that are left of the picture: `done` took `spent`, reported `since` ago.
fn words(tally: &Tally, progress: Progress, spent: Duration, (since, left): (Duration, Option<f64>)) -> String {
    let Progress { step, done, total } = progress;
    let (name, unit, since) = (step.name(), step.unit(), since.as_secs_f64());
    let name = match (tally.samples, tally.sample()) {
        (0 | 1, _) => name.to_owned(),
        (_, 0) => format!("centres, {name}"),
        (samples, sample) => format!("sample {sample} of {samples}, {name}"),
    };
    if step == Step::Stage || done == 0 {
        return format!("{name} {}{unit}, {}", quantity(total as f64), span(since));
    }
    let rate = done as f64 / spent.as_secs_f64().max(1e-9);
    if progress.known_total().is_none() {
        return format!("{name} {}{unit}/s, {}{unit}", quantity(rate), quantity(done as f64));
    }
    let left = left.map_or(String::new(), |left| format!(", {} left", span(left)));
    format!("{name} {}{unit}/s{left}", quantity(rate))
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
        let words = |progress, spent, since, left| super::words(&Tally::default(), progress, spent, (since, left));
        assert_eq!(words(at(Step::Trace, 2_073_600), two, none, Some(5.2)), "trace 1.04 Mpixels/s, 0:06 left");
        assert_eq!(words(at(Step::Trace, 8_294_300), two, two, Some(-1.0)), "trace 4.15 Mpixels/s, 0:00 left", "late");
        assert_eq!(words(at(Step::Settle, 90), two, none, Some(184_318.0)), "settle 45.0 pixels/s, 51:11:58 left");
        assert_eq!(words(at(Step::Trace, 0), none, two, Some(1.0)), "trace 8.29 Mpixels, 0:02");
        assert_eq!(words(at(Step::Stage, 0), none, two, None), "stage 8.29 Mspheres, 0:02");
        let endless = Progress { step: Step::Rays, done: 3_000_000, total: 0 };
        assert_eq!(words(endless, two, none, None), "trace 1.50 Mrays/s, 3.00 Mrays");
        let mut tally = Tally::default();
        tally.expect(16, false);
        [Step::Stage, Step::Trace, Step::Settle, Step::Trace]
            .into_iter()
            .for_each(|step| _ = tally.record(at(step, 9)));
        let of_sample = super::words(&tally, at(Step::Trace, 2_073_600), two, (none, Some(60.0)));
        assert_eq!(of_sample, "sample 1 of 16, trace 1.04 Mpixels/s, 1:00 left");
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
