//! The arguments of the command and its exit code. The process has other arguments and another exit code where another
//! program calls the command.

use std::ffi::OsString;
use std::sync::OnceLock;

static ARGUMENTS: OnceLock<Vec<OsString>> = OnceLock::new();

/// Sets the arguments, beginning with the command's name. Only the first call has an effect.
pub(super) fn start(arguments: impl Iterator<Item = OsString>) {
    ARGUMENTS.get_or_init(|| arguments.collect());
}

/// All arguments, beginning with the command's name.
pub(super) fn all_arguments() -> &'static [OsString] {
    ARGUMENTS.get().map_or(&[], Vec::as_slice)
}

/// The arguments behind the command's name.
pub(super) fn arguments() -> impl Iterator<Item = &'static OsString> {
    all_arguments().iter().skip(1)
}

/// An exit code. The type of the standard library does not show its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ExitCode(pub(super) u8);

impl ExitCode {
    /// No failure.
    pub(super) const SUCCESS: Self = Self(0);
}
