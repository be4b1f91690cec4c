//! Messages on standard error: errors and warnings, and notes, which `--quiet` leaves out.

use halfline::quote::{printable, reworded};
use std::fmt;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether notes are left out.
static QUIET: AtomicBool = AtomicBool::new(false);

/// The option `--quiet`.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reporting")]
pub(super) struct QuietArgs {
    /// Prints only errors and warnings on standard error; no notes and no line of progress.
    #[arg(long)]
    quiet: bool,
}

impl QuietArgs {
    /// Leaves out notes from now on if the option is given.
    pub(super) fn apply(&self) {
        QUIET.store(self.quiet, Ordering::Relaxed);
    }
}

/// Whether notes and lines of progress are left out.
pub(super) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// A message of the library with the options of the command in place of the names of settings.
pub fn flags(message: &str) -> String {
    reworded(message, |setting| format!("--{}", setting.replace('_', "-")))
}

/// A message of the library in a page, which has not all columns of its file.
pub fn in_page(message: &str) -> String {
    let message = flags(message);
    let lacking =
        message.split_once(": the file has no ").map(|(before, rest)| (before, rest.split(';').next().unwrap_or(rest)));
    match lacking.filter(|(_, word)| !word.contains(' ')) {
        Some((before, word)) => {
            format!(
                "{before}: this page carries no column {word}; make it with --columns {word}, where the file has that"
            )
        }
        None => message,
    }
}

/// Prints an error or a warning on standard error. A standard error that cannot be written is not a failure; `eprintln`
/// would panic.
pub(crate) fn say(message: fmt::Arguments<'_>) {
    // One write, so that lines of several processes do not mix.
    let _ = io::stderr().write_all(format!("halfline: {}\n", printable(&flags(&message.to_string()))).as_bytes());
}

/// Prints warnings on standard error.
pub(super) fn warn<T: fmt::Display>(warnings: impl IntoIterator<Item = T>) {
    warnings.into_iter().for_each(|warning| say(format_args!("warning: {warning}")));
}

/// Prints a message that is neither an error nor a warning, unless `--quiet` is given.
pub(super) fn note(message: fmt::Arguments<'_>) {
    if !is_quiet() {
        say(message);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_does_not_speak_of_its_file() {
        let lacking = "selection `chain A`: the file has no chain; the file has index, x, y, z";
        assert!(
            in_page(lacking)
                .starts_with("selection `chain A`: this page carries no column chain; make it with --columns chain")
        );
        let other = "the file has no elements to colour by; remove it";
        assert_eq!(in_page(other), other);
    }
}
