//! OpenEXR in a build without the feature `formats`: refused.

use super::rows::{Found, Head, NamedArrays, Rows, SeekRead, Sink};
use halfline::error::{Error, Place, Result};
use std::io;

/// The first bytes of a file.
pub(super) const MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

fn refused(name: &str) -> Error {
    Error::scene(Place::file(name), "this build of halfline does not read OpenEXR", crate::WHOLE)
}

pub(super) fn read(_: &[u8], name: &str) -> Result<(NamedArrays, Option<[i32; 2]>)> {
    Err(refused(name))
}

pub(super) fn open<'a>(_: Box<dyn SeekRead + 'a>, name: &str) -> Result<Found<'a>> {
    Err(refused(name))
}

pub(super) fn write(_: &Head, _: &mut dyn Rows, _: &mut dyn Sink) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

pub(super) fn memory(_: u64) -> u64 {
    0
}
