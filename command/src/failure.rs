//! Failures: the exit codes, the message on standard error, and with `--json` an object on standard output.

use super::messages::{flags, say};
use super::process::{ExitCode, arguments};
use halfline::error::Error;
use serde_json::json;
use std::ffi::OsStr;
use std::io::{self, Write};
use std::sync::{Mutex, PoisonError};

/// Whether the object is printed: the thread that ends a process after a signal may be as fast as the work.
static PRINTED: Mutex<bool> = Mutex::new(false);

/// Kind and exit code of a failure, which scripts may rely on. 0 is success, 1 a difference found by `compare`; 2 is also
/// clap's.
pub(super) fn class(error: &Error) -> (&'static str, u8) {
    match error {
        Error::Settings { .. } => SETTINGS,
        Error::Scene { .. } => ("scene", 3),
        Error::Adapter { .. } => ("adapter", 4),
        Error::Limits { .. } => ("limits", 5),
        Error::DeviceLost(_) => ("device-lost", 6),
        Error::Accuracy { .. } => ("accuracy", 7),
        Error::Io { .. } => ("io", 8),
        Error::Interrupted => ("interrupted", 130),
        _ => ("internal", 101),
    }
}

const SETTINGS: (&str, u8) = ("settings", 2);

/// Reports a failure; the exit code of the process.
pub(super) fn fail(error: &Error) -> ExitCode {
    let (kind, exit) = class(error);
    say(format_args!("{error}"));
    print_object((kind, exit), &flags(&error.to_string()));
    ExitCode(exit)
}

/// Prints the object of an error of clap, which prints its own message; help and version are no errors.
pub(super) fn print_usage(error: &clap::Error) {
    if error.use_stderr() {
        let rendered = error.render().to_string();
        let lines = rendered
            .lines()
            .map(str::trim)
            .take_while(|line| !["Usage:", "For more"].iter().any(|end| line.starts_with(end)));
        let words: Vec<_> = lines.filter(|line| !line.is_empty()).collect();
        let message = words.join(" ");
        print_object(SETTINGS, message.strip_prefix("error: ").unwrap_or(&message));
    }
}

/// Prints `{"error": {..}}` on a line of standard output if `--json` is among the arguments. The arguments may be invalid
/// otherwise, so they are not parsed. A standard output that cannot be written changes nothing.
fn print_object((kind, exit): (&str, u8), message: &str) {
    let is_json = arguments().take_while(|text| *text != "--").any(|text| text == OsStr::new("--json"));
    let mut printed = PRINTED.lock().unwrap_or_else(PoisonError::into_inner);
    if is_json && !std::mem::replace(&mut printed, true) {
        let object = json!({ "error": { "kind": kind, "message": message, "exit": exit } });
        let mut out = io::stdout().lock();
        let _ = out.write_all(format!("{object}\n").as_bytes()).and_then(|()| out.flush());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The failures that no test of the command can make at will.
    #[test]
    fn every_failure_has_its_kind_and_code() {
        let of = |error: &Error| class(error);
        assert_eq!(of(&Error::DeviceLost("gone".into())), ("device-lost", 6));
        let accuracy = Error::Accuracy { problem: "too coarse".into(), mend: "use another".into() };
        assert_eq!(of(&accuracy), ("accuracy", 7));
        assert_eq!(of(&Error::Interrupted), ("interrupted", 130));
    }
}
