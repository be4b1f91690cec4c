//! NumPy's .npz: a .npy for each buffer, NAME.npy, and provenance.json, stored in one ZIP without compression and with
//! ZIP's own first date, so that the same buffers give the same bytes.

use super::npy;
use super::provenance::Provenance;
use super::sheet::{Layer, Sheet, malformed};
use crate::error::Result;
use std::io::{self, Cursor, Read, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipArchive, ZipWriter};

/// The bytes every ZIP of files begins with.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";

const PROVENANCE: &str = "provenance.json";

/// Writes every layer and the provenance.
pub(super) fn write(sheet: &Sheet<'_>, out: &mut dyn Write) -> io::Result<()> {
    let mut zip = ZipWriter::new_stream(out);
    let options = |bytes: usize| {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        // ZIP counts to 2^32, ZIP64 further; the header of an array is short.
        options
            .last_modified_time(DateTime::DEFAULT)
            .system(System::Unix)
            .unix_permissions(0o644)
            .large_file(bytes >= (1 << 32) - 4096)
    };
    for layer in &sheet.layers {
        zip.start_file(format!("{}.npy", layer.aov), options(layer.bytes.len()))?;
        npy::write_layer(layer, sheet.size(), &mut zip)?;
    }
    let json = sheet.provenance.to_json();
    zip.start_file(PROVENANCE, options(json.len()))?;
    zip.write_all(json.as_bytes())?;
    zip.finish()?;
    Ok(())
}

/// Reads what [`write`] wrote; `None` where it does not say where it comes from.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<Option<Sheet<'static>>> {
    let fail = |why: &dyn std::fmt::Display| malformed(name, "NPZ", why);
    let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(|error| fail(&error))?;
    let member = |zip: &mut ZipArchive<_>, member: &str| -> Result<Option<Vec<u8>>> {
        let Ok(file) = zip.by_name(member) else { return Ok(None) };
        let mut content = Vec::new();
        // Nothing is compressed, so nothing is longer than the file; its sum is checked at its end.
        file.take(bytes.len() as u64 + 1).read_to_end(&mut content).map_err(|error| fail(&error))?;
        Ok(Some(content))
    };
    let provenance = member(&mut zip, PROVENANCE)?.and_then(|json| Provenance::from_json(&json));
    let Some((provenance, buffers)) = provenance.and_then(|words| words.buffers().map(|all| (words, all))) else {
        return Ok(None);
    };
    if zip.len() != buffers.len() + 1 {
        return Err(fail(&"it holds other members than its provenance says"));
    }
    let mut layers: Vec<Layer<'static>> = Vec::new();
    for aov in buffers {
        let content = member(&mut zip, &format!("{aov}.npy"))?.ok_or_else(|| fail(&format!("it has no {aov}")))?;
        let (layer, rest) = npy::read_layer(&content, name, aov)?;
        if !rest.is_empty() {
            return Err(fail(&format!("bytes follow the last value of {aov}")));
        }
        layers.push(layer);
    }
    Ok(Sheet::new(layers, provenance))
}
