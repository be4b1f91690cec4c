//! Errors of the library as exceptions of Python, in the command's own words.

use halfline::Error;
use halfline_command::choices::in_keywords;
use pyo3::create_exception;
use pyo3::exceptions::{PyKeyboardInterrupt, PyMemoryError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::io::ErrorKind;

create_exception!(halfline, AccuracyError, PyValueError, "The promised accuracy cannot be reached here.");
create_exception!(
    halfline,
    AdapterError,
    PyRuntimeError,
    "No adapter (GPU or software Vulkan) fits the request, or the device was lost."
);

/// The exception for an error.
pub(crate) fn exception(error: Error) -> PyErr {
    let text = in_keywords(&error.to_string());
    match error {
        Error::Settings { .. } | Error::Scene { .. } => PyValueError::new_err(text),
        Error::Limits { .. } => PyMemoryError::new_err(text),
        Error::Accuracy { .. } => AccuracyError::new_err(text),
        Error::Adapter { .. } | Error::DeviceLost(_) => AdapterError::new_err(text),
        Error::Interrupted => PyKeyboardInterrupt::new_err(()),
        Error::Io { path, source, .. } => match source.raw_os_error().or(number_of(source.kind())) {
            // Python chooses the class by the number: FileNotFoundError, PermissionError.
            Some(number) => PyOSError::new_err((number, system_words(&source), path.into_os_string())),
            None => PyOSError::new_err(text),
        },
        _ => PyRuntimeError::new_err(text),
    }
}

/// The number of a failure that the library found before the system did.
fn number_of(kind: ErrorKind) -> Option<i32> {
    match kind {
        ErrorKind::NotFound => Some(2),
        ErrorKind::PermissionDenied => Some(13),
        ErrorKind::NotADirectory => Some(20),
        ErrorKind::IsADirectory => Some(21),
        _ => None,
    }
}

/// The system's message without the number, which `OSError` shows itself.
fn system_words(error: &std::io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error").next().unwrap_or_default().to_owned()
}

/// The library's result as a result of Python.
pub(crate) trait OrRaise<T> {
    /// The value, or the exception for the error.
    fn or_raise(self) -> PyResult<T>;
}

impl<T> OrRaise<T> for halfline::Result<T> {
    fn or_raise(self) -> PyResult<T> {
        self.map_err(exception)
    }
}
