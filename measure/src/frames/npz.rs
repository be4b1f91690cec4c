//! Archives of arrays, as written by halfline and numpy.savez, stored or deflated. Members that are not arrays are
//! skipped.

use super::file::{FrameFile, NamedBuffer};
use flate2::CrcReader;
use flate2::read::DeflateDecoder;
use halfline::error::{Error, Place, Result};
use halfline::memory::check;
use halfline_files::write::npy;
use std::io::{Cursor, Read};
use zip::{CompressionMethod, ZipArchive};

pub(super) fn read(bytes: &[u8], name: &str) -> Result<FrameFile> {
    let fail = |why: String| {
        Error::scene(Place::file(name), format!("the NPZ file is damaged or incomplete: {why}"), "render it again")
    };
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| fail(error.to_string()))?;
    let mut buffers = Vec::new();
    for n in 0..archive.len() {
        let file = archive.by_index_raw(n).map_err(|error| fail(error.to_string()))?;
        let path = file.name().map_err(|error| fail(error.to_string()))?.into_owned();
        let (size, sum) = (file.size(), file.crc32());
        let Some(buffer) = path.strip_suffix(".npy") else { continue };
        // Deflate expands by a factor of 1032 at most.
        if size > 1032 * (file.compressed_size() + 1) {
            return Err(fail(format!("{path} claims to have {size} bytes")));
        }
        check(2 * size, || format!("{path} of {name}"))?;
        let reader: Box<dyn Read> = match file.compression() {
            CompressionMethod::STORE => Box::new(file),
            CompressionMethod::DEFLATE => Box::new(DeflateDecoder::new(file)),
            other => return Err(fail(format!("{path} is compressed with {other:?}, which is not supported"))),
        };
        let mut content = Vec::new();
        let mut reader = CrcReader::new(reader.take(size + 1));
        reader.read_to_end(&mut content).map_err(|error| fail(format!("{path}: {error}")))?;
        if content.len() as u64 != size || reader.crc().sum() != sum {
            return Err(fail(format!("{path} does not match its checksum")));
        }
        let array = npy::read(&content, &format!("{name}:{path}"))?;
        buffers.push(NamedBuffer { name: Some(buffer.to_owned()), array });
    }
    if buffers.is_empty() {
        return Err(fail("it holds no arrays".into()));
    }
    Ok(FrameFile { name: name.to_owned(), buffers, origin: None })
}
