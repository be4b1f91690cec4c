//! TIFF, JPEG and WebP in a build without the feature `formats`: refused by [`Target::new`](super::file::Target::new).

use super::format::FileFormat;
use super::rows::{Head, Rows, Sink};
use std::io;

pub(super) fn detect(_: &[u8]) -> Option<FileFormat> {
    None
}

pub(super) fn memory(_: &Head) -> u64 {
    0
}

pub(super) fn write_tiff(_: &Head, _: &mut dyn Rows, _: &mut dyn Sink) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

pub(super) use write_tiff as write_jpeg;
pub(super) use write_tiff as write_webp;
