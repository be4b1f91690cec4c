//! NumPy's .npz: a .npy per buffer, NAME.npy, and provenance.json, in a ZIP file without compression. The date is
//! always ZIP's first one, so that equal buffers give equal bytes.

use super::format::FileFormat;
use super::layer::LayerFormat;
use super::npy;
use super::plain::Plain;
use super::rows::{Found, Head, Rows, SeekRead, Sink, malformed};
use flate2::CrcReader;
use flate2::read::DeflateDecoder;
use halfline::error::Result;
use halfline::frame::array::Array;
use halfline::frame::provenance::Provenance;
use halfline::memory::check;
use std::cell::Cell;
use std::io::{self, Cursor, Read, Write};
use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, DateTime, System, ZipArchive, ZipWriter};

/// The signature of ZIP archives with files.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";

const PROVENANCE: &str = "provenance.json";

/// Writes every buffer and the provenance.
pub(super) fn write(head: &Head, rows: &mut dyn Rows, out: &mut dyn Sink) -> io::Result<()> {
    write_archive(out, |archive| {
        for (layer, form) in head.forms.iter().enumerate() {
            let bytes = head.row(layer) as u64 * head.size()[1] as u64;
            npy::write_layer(head, layer, rows, archive.member(&member(form), bytes)?)?;
        }
        let json = head.provenance.to_json();
        archive.member(PROVENANCE, json.len() as u64)?.write_all(json.as_bytes())
    })
}

/// Writes an archive to `out` whose members `fill` adds.
pub(crate) fn write_archive(
    out: &mut dyn Write,
    fill: impl FnOnce(&mut Archive<'_>) -> io::Result<()>,
) -> io::Result<()> {
    let failed = Cell::new(false);
    let mut archive = Archive(ZipWriter::new_stream(UntilFailure { out, failed: &failed }));
    // Dropping an unfinished writer would write the end of an incomplete archive; this discards it.
    fill(&mut archive).inspect_err(|_| failed.set(true))?;
    archive.0.finish()?;
    Ok(())
}

/// An archive that is being written.
pub(crate) struct Archive<'a>(ZipWriter<StreamWriter<UntilFailure<'a>>>);

impl Archive<'_> {
    /// Begins a member whose data has this number of bytes; what is written to the result is its content.
    pub(crate) fn member(&mut self, name: &str, bytes: u64) -> io::Result<&mut dyn Write> {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        // ZIP is limited to 2^32 bytes, ZIP64 is not; an array's header is short.
        let options = options
            .last_modified_time(DateTime::DEFAULT)
            .system(System::Unix)
            .unix_permissions(0o644)
            .large_file(bytes >= (1 << 32) - 4096);
        self.0.start_file(name, options)?;
        Ok(&mut self.0)
    }
}

/// Writes to `out` until a write fails, and discards the rest. A [`ZipWriter`] that could not finish tries again when
/// it is dropped, and prints a second failure to standard error.
struct UntilFailure<'a> {
    out: &'a mut dyn Write,
    failed: &'a Cell<bool>,
}

impl Write for UntilFailure<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.failed.get() {
            return Ok(bytes.len());
        }
        self.out.write(bytes).inspect_err(|error| self.failed.set(error.kind() != io::ErrorKind::Interrupted))
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.failed.get() {
            return Ok(());
        }
        self.out.flush().inspect_err(|_| self.failed.set(true))
    }
}

fn member(form: &LayerFormat) -> String {
    format!("{}.npy", form.aov)
}

/// Opens a file that [`write`] wrote; `None` where it has no provenance.
pub(super) fn open<'a>(input: Box<dyn SeekRead + 'a>, name: &str) -> Result<Found<'a>> {
    let fail = |why: &dyn std::fmt::Display| malformed(name, "NPZ", why);
    let mut zip = ZipArchive::new(input).map_err(|error| fail(&error))?;
    let json = match zip.by_name(PROVENANCE) {
        Ok(file) => {
            let mut json = Vec::new();
            file.take(LONGEST).read_to_end(&mut json).map_err(|error| fail(&error))?;
            json
        }
        Err(_) => return Ok(None),
    };
    let Some(head) = Provenance::from_json(&json).and_then(|words| Head::new(FileFormat::Npz, words)) else {
        return Ok(None);
    };
    if zip.len() != head.forms.len() + 1 {
        return Err(fail(&"its members differ from those in its provenance"));
    }
    let mut layers = Vec::new();
    for (layer, form) in head.forms.iter().enumerate() {
        let header = npy::header(*form, head.size()).map_err(|error| fail(&error))?;
        let mut file = zip.by_name(&member(form)).map_err(|_| fail(&format!("it has no {}", form.aov)))?;
        let size = header.len() as u64 + head.row(layer) as u64 * head.size()[1] as u64;
        let stored = file.compression() == CompressionMethod::Stored && !file.encrypted();
        let (Some(start), true) = (file.data_start(), stored && file.size() == size) else {
            return Err(fail(&format!("its {} differs from its provenance", form.aov)));
        };
        let mut found = vec![0; header.len()];
        file.read_exact(&mut found).map_err(|error| fail(&error))?;
        if found != header {
            return Err(fail(&format!("its {} differs from its provenance", form.aov)));
        }
        if head.provenance.pixels().is_none() {
            // Without a hash, the checksum of the ZIP is checked at the end.
            io::copy(&mut file, &mut io::sink()).map_err(|error| fail(&error))?;
        }
        layers.push((start + header.len() as u64, head.row(layer)));
    }
    let input = zip.into_inner();
    let rows = Plain { input, name: name.into(), layers, bottom_up: None, samples: Vec::new() };
    Ok(Some((head, Box::new(rows))))
}

/// Reads the arrays of any program, stored or deflated. Members that are not arrays are skipped.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<Vec<(Option<String>, Array)>> {
    let fail = |why: &dyn std::fmt::Display| malformed(name, "NPZ", why);
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| fail(&error))?;
    let mut buffers = Vec::new();
    for n in 0..archive.len() {
        let file = archive.by_index_raw(n).map_err(|error| fail(&error))?;
        let path = file.name().map_err(|error| fail(&error))?.into_owned();
        let (size, sum) = (file.size(), file.crc32());
        let Some(buffer) = path.strip_suffix(".npy") else { continue };
        // Deflate expands by a factor of 1032 at most.
        if size > 1032 * (file.compressed_size() + 1) {
            return Err(fail(&format!("{path} claims to have {size} bytes")));
        }
        check(2 * size, || format!("{path} of {name}"))?;
        let reader: Box<dyn Read> = match file.compression() {
            CompressionMethod::Stored => Box::new(file),
            CompressionMethod::DEFLATE => Box::new(DeflateDecoder::new(file)),
            other => return Err(fail(&format!("{path} is compressed with {other:?}, which is not supported"))),
        };
        let mut content = Vec::new();
        let mut reader = CrcReader::new(reader.take(size + 1));
        reader.read_to_end(&mut content).map_err(|error| fail(&format!("{path}: {error}")))?;
        if content.len() as u64 != size || reader.crc().sum() != sum {
            return Err(fail(&format!("{path} does not match its checksum")));
        }
        let array = npy::read(&content, &format!("{name}:{path}"))?;
        buffers.push((Some(buffer.to_owned()), array));
    }
    if buffers.is_empty() {
        return Err(fail(&"it holds no arrays"));
    }
    Ok(buffers)
}

/// The longest provenance.
const LONGEST: u64 = 1 << 17;
