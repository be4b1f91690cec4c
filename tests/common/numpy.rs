//! NumPy and its files.

use crate::skip::skip;
use std::process::Command;

/// An NPY file of version 1 with this text of a header, from NumPy's description of the format.
pub(crate) fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    let length = (header.len() as u16 + 1).to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), b"\n", data].concat()
}

/// An NPY file of values of this type in this shape.
pub(crate) fn npy_of(descr: &str, fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    npy(&format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}"), data)
}

pub(crate) fn little(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// The Python that has NumPy, python3 or HALFLINE_PYTHON. Without NumPy, the test is skipped.
pub(crate) fn python_or_skip() -> Option<String> {
    let python = std::env::var("HALFLINE_PYTHON").unwrap_or_else(|_| "python3".into());
    let has_numpy = Command::new(&python).args(["-c", "import numpy"]).output();
    if has_numpy.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    skip(format!("{python} has no numpy (Debian: apt-get install python3-numpy)"));
    None
}
