//! Progress for programs: lines of JSON on standard error, or lines of Open Job Description on standard output
//! (<https://github.com/OpenJobDescription/openjd-specifications/wiki/How-Jobs-Are-Run>).

use super::tally::Tally;
use halfline::progress::{Progress, Step};
use std::io::{self, Write};
use std::time::Duration;
use web_time::Instant;

/// The option `--progress`.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reporting")]
pub(super) struct ProgressArgs {
    /// Progress reporting: auto (a line on a terminal), none, json (lines on standard error), openjd (Open Job
    /// Description on standard output).
    #[arg(long, value_name = "P", value_enum, hide_possible_values = true, default_value = "auto")]
    pub(super) progress: ProgressOutput,
}

impl ProgressArgs {
    /// Whether standard output receives the lines.
    pub(super) fn is_openjd(&self) -> bool {
        self.progress == ProgressOutput::Openjd
    }
}

/// The form of progress reporting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum ProgressOutput {
    /// A line on a terminal.
    Auto,
    /// None.
    None,
    /// One JSON object per line on standard error: step, done, total, frame, sample, samples.
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
    /// The number of pictures.
    frames: u32,
    tally: Tally,
    printed_at: Instant,
}

impl ProgressLines {
    pub(super) fn new(output: ProgressOutput, frames: u32) -> Self {
        Self { output, frames, tally: Tally::default(), printed_at: Instant::now() }
    }

    /// Sets the samples per pixel of the pictures that follow, and whether they are lit; see [`Tally::expect`].
    pub(super) fn expect(&mut self, samples: u32, has_light: bool) {
        self.tally.expect(samples, has_light);
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
        let latest = self.tally.latest;
        self.tally.record(progress);
        if latest == Some(progress) {
            return false;
        }
        let due =
            latest.is_none_or(|latest| latest.step != step) || done == total || self.printed_at.elapsed() >= PAUSE;
        if due {
            self.printed_at = Instant::now();
        }
        due
    }

    fn lines(&self, progress: Progress) -> String {
        let Progress { step, done, .. } = progress;
        let (name, unit) = (step.name(), step.unit());
        let known = progress.known_total();
        if self.output == ProgressOutput::Json {
            let total = known.map_or("null".into(), |total| total.to_string());
            let Tally { frame, samples, .. } = self.tally;
            let of = match step {
                Step::Rays => String::new(),
                _ => format!(",\"sample\":{},\"samples\":{}", self.tally.sample(), samples.max(1)),
            };
            return format!("{{\"step\":\"{name}\",\"done\":{done},\"total\":{total},\"frame\":{frame}{of}}}\n");
        }
        let pictures = f64::from(self.tally.frame.saturating_sub(1)) + self.tally.share();
        let percent = 100.0 * pictures / f64::from(self.frames);
        let of = known.map_or(String::new(), |total| format!(" of {total}"));
        let sample = if self.tally.samples > 1 { format!("sample {}: ", self.tally.sample()) } else { String::new() };
        format!("openjd_progress: {:.1}\nopenjd_status: {sample}{name} {done}{of} {unit}\n", percent.min(100.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn printed(output: ProgressOutput, frames: u32) -> Vec<String> {
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
        let lines = printed(ProgressOutput::Json, 2);
        assert_eq!(lines.len(), 12, "a quarter of a step after so short a time is not reported: {lines:?}");
        assert_eq!(lines[0], "{\"step\":\"stage\",\"done\":0,\"total\":9,\"frame\":1,\"sample\":1,\"samples\":1}");
        assert_eq!(lines[11], "{\"step\":\"settle\",\"done\":2,\"total\":2,\"frame\":2,\"sample\":1,\"samples\":1}");
    }

    #[test]
    fn an_unknown_total_is_null() {
        let endless = Progress { step: Step::Rays, done: 7, total: 0 };
        let lines = |output| {
            let mut lines = ProgressLines::new(output, 1);
            lines.is_due(endless);
            lines.lines(endless)
        };
        assert_eq!(lines(ProgressOutput::Json), "{\"step\":\"trace\",\"done\":7,\"total\":null,\"frame\":1}\n");
        assert_eq!(lines(ProgressOutput::Openjd), "openjd_progress: 0.0\nopenjd_status: trace 7 rays\n");
    }

    #[test]
    fn percent_never_falls() {
        let lines = printed(ProgressOutput::Openjd, 3);
        let percents: Vec<f64> =
            lines.iter().filter_map(|line| line.strip_prefix("openjd_progress: ")?.parse().ok()).collect();
        assert!(percents.len() == 18 && percents.is_sorted() && percents[17] < 100.0, "{percents:?}");
        assert!(lines.contains(&"openjd_status: trace 40 of 40 pixels".to_owned()), "{lines:?}");
    }
}
