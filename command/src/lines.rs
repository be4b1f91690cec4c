//! Progress for programs: lines of JSON on standard error, or those of Open Job Description on standard output
//! (<https://github.com/OpenJobDescription/openjd-specifications/wiki/How-Jobs-Are-Run>).

use halfline::progress::{Progress, Step};
use std::io::{self, Write};
use std::time::{Duration, Instant};

/// The form of progress reporting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum ProgressOutput {
    /// A line on a terminal.
    Auto,
    /// None.
    None,
    /// One JSON object per line on standard error: step, done, total, frame.
    Json,
    /// openjd_progress and openjd_status on standard output.
    Openjd,
}

impl ProgressOutput {
    /// Whether programs read lines, which count the pictures one after the other.
    pub(super) fn is_lines(self) -> bool {
        matches!(self, Self::Json | Self::Openjd)
    }
}

/// The minimum interval between lines of one step.
const PAUSE: Duration = Duration::from_millis(100);

/// Prints the lines.
pub(super) struct ProgressLines {
    output: ProgressOutput,
    /// The number of frames, and the index of the current one, from 1.
    frames: u32,
    frame: u32,
    latest: Option<Progress>,
    told: Instant,
}

impl ProgressLines {
    pub(super) fn new(output: ProgressOutput, frames: u32) -> Self {
        Self { output, frames, frame: 0, latest: None, told: Instant::now() }
    }

    /// Prints a line unless one was printed just before. A closed output is not an error.
    pub(super) fn record(&mut self, progress: Progress) {
        if self.is_due(progress) {
            let lines = self.lines(progress);
            let _ = if self.output == ProgressOutput::Json {
                io::stderr().write_all(lines.as_bytes())
            } else {
                io::stdout().write_all(lines.as_bytes())
            };
        }
    }

    /// Prints that the files are written.
    pub(super) fn finish(&self) {
        if self.output == ProgressOutput::Openjd {
            let _ = io::stdout().write_all(b"openjd_progress: 100.0\nopenjd_status: done\n");
        }
    }

    fn is_due(&mut self, progress: Progress) -> bool {
        let Progress { step, done, total } = progress;
        let latest = self.latest.replace(progress);
        // A new frame begins with an earlier step than the last one ended with, or with less of the same.
        if latest.is_none_or(|latest| (step, done) < (latest.step, latest.done)) {
            self.frame += 1;
        }
        if latest == Some(progress) {
            return false;
        }
        let due = latest.is_none_or(|latest| latest.step != step) || done == total || self.told.elapsed() >= PAUSE;
        if due {
            self.told = Instant::now();
        }
        due
    }

    fn lines(&self, progress: Progress) -> String {
        let Progress { step, done, .. } = progress;
        let (name, unit) = (step.name(), step.unit());
        let known = progress.known_total();
        if self.output == ProgressOutput::Json {
            let total = known.map_or("null".into(), |total| total.to_string());
            return format!("{{\"step\":\"{name}\",\"done\":{done},\"total\":{total},\"frame\":{}}}\n", self.frame);
        }
        // The share of a frame at which a step begins and ends is an estimate.
        let (begin, end) = match step {
            Step::Stage => (0.0, 0.05),
            Step::Trace => (0.05, 0.75),
            Step::Rays => (0.0, 0.95),
            _ => (0.75, 0.95),
        };
        let part = known.map_or(0.0, |total| done as f64 / (total as f64).max(1.0));
        let share = begin + (end - begin) * part;
        let percent = 100.0 * (f64::from(self.frame.saturating_sub(1)) + share) / f64::from(self.frames);
        let of = known.map_or(String::new(), |total| format!(" of {total}"));
        format!("openjd_progress: {:.1}\nopenjd_status: {name} {done}{of} {unit}\n", percent.min(100.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(output: ProgressOutput, frames: u32) -> Vec<String> {
        let mut lines = ProgressLines::new(output, frames);
        let mut all = Vec::new();
        for _ in 0..frames {
            for (step, done, total) in [
                (Step::Stage, 0, 9),
                (Step::Stage, 9, 9),
                (Step::Trace, 0, 40),
                (Step::Trace, 10, 40),
                (Step::Trace, 40, 40),
                (Step::Settle, 0, 2),
                (Step::Settle, 2, 2),
            ] {
                let progress = Progress { step, done, total };
                if lines.is_due(progress) {
                    all.extend(lines.lines(progress).lines().map(str::to_owned));
                }
            }
        }
        all
    }

    #[test]
    fn frames_are_counted_and_pauses_kept() {
        let lines = told(ProgressOutput::Json, 2);
        assert_eq!(lines.len(), 12, "a quarter of a step after so short a time is not reported: {lines:?}");
        assert_eq!(lines[0], "{\"step\":\"stage\",\"done\":0,\"total\":9,\"frame\":1}");
        assert_eq!(lines[11], "{\"step\":\"settle\",\"done\":2,\"total\":2,\"frame\":2}");
    }

    #[test]
    fn an_unknown_total_is_null() {
        let endless = Progress { step: Step::Rays, done: 7, total: 0 };
        let lines = |output| ProgressLines { frame: 1, ..ProgressLines::new(output, 1) }.lines(endless);
        assert_eq!(lines(ProgressOutput::Json), "{\"step\":\"trace\",\"done\":7,\"total\":null,\"frame\":1}\n");
        assert_eq!(lines(ProgressOutput::Openjd), "openjd_progress: 0.0\nopenjd_status: trace 7 rays\n");
    }

    #[test]
    fn percent_never_falls() {
        let lines = told(ProgressOutput::Openjd, 3);
        let percents: Vec<f64> =
            lines.iter().filter_map(|line| line.strip_prefix("openjd_progress: ")?.parse().ok()).collect();
        assert!(percents.len() == 18 && percents.is_sorted() && percents[17] < 100.0, "{percents:?}");
        assert!(lines.contains(&"openjd_status: trace 40 of 40 pixels".to_owned()), "{lines:?}");
    }
}
