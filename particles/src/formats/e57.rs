//! Scans of E57 (ASTM E2807), by the crate e57: points, colours, intensities and other fields, each scan at its pose.

use crate::format::{FormatRow, Has, Open, Sign};

#[cfg(feature = "formats")]
mod scans;

pub(crate) const E57: FormatRow = FormatRow {
    name: "e57",
    about: "scans of E57",
    // The major version.
    signs: &[Sign::Bytes(|bytes| bytes.starts_with(b"ASTM-E57\x01\0\0\0"))],
    has: &[Has::AnyColumns],
    open: OPEN,
    ..FormatRow::PLAIN
};

#[cfg(feature = "formats")]
const OPEN: Open = Open::Frame(scans::read);
#[cfg(not(feature = "formats"))]
const OPEN: Open = Open::Lacking;
