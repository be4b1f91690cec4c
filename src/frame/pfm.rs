//! PFM, portable float map: one or three channels of f32 behind three lines of text, bottom row first.
//! The format: <https://www.pauldebevec.com/Research/HDR/PFM/>.

use super::provenance::Provenance;
use super::sheet::{Kind, Layer, Sheet, invalid, malformed};
use crate::error::Result;
use std::io::{self, Write};

/// Writes the only layer; a scale of -1 says little endian. Provenance follows the last number.
pub(super) fn write(sheet: &Sheet<'_>, out: &mut dyn Write) -> io::Result<()> {
    let layer = sheet.layer()?;
    let magic = match (layer.kind, layer.channels) {
        (Kind::F32, 1) => "Pf",
        (Kind::F32, 3) => "PF",
        _ => return Err(invalid(format!("a {} buffer is no PFM", layer.aov))),
    };
    let [width, height] = sheet.size();
    write!(out, "{magic}\n{width} {height}\n-1.0\n")?;
    layer.bytes.chunks_exact(width * layer.pixel()).rev().try_for_each(|row| out.write_all(row))?;
    out.write_all(sheet.provenance.trailer().as_bytes())
}

/// Reads what [`write`] wrote; `None` where it does not say where it comes from.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<Option<Sheet<'static>>> {
    let fail = |why: &str| malformed(name, "PFM", why);
    let mut lines = bytes.splitn(4, |byte| *byte == b'\n');
    let mut line = || lines.next().and_then(|line| str::from_utf8(line).ok());
    let (Some(magic), Some(size), Some("-1.0")) = (line(), line(), line()) else {
        return Err(fail("the header is not halfline's"));
    };
    let channels = if magic == "PF" { 3 } else { 1 };
    let row = size.split_once(' ').and_then(|(w, h)| Some((w.parse::<usize>().ok()?, h.parse::<usize>().ok()?)));
    let row = row.and_then(|(w, h)| Some((w.checked_mul(4 * channels)?, h))).filter(|(row, _)| *row > 0);
    let (row, rows) = row.ok_or_else(|| fail("its size is none"))?;
    let data = lines.next().unwrap_or_default();
    let Some((data, rest)) = row.checked_mul(rows).and_then(|n| data.split_at_checked(n)) else {
        return Err(fail("it ends before its last number"));
    };
    let Some(provenance) = Provenance::from_trailer(rest) else { return Ok(None) };
    let Some([aov]) = provenance.buffers().and_then(|all| <[_; 1]>::try_from(all).ok()) else { return Ok(None) };
    let bytes: Vec<u8> = data.chunks_exact(row).rev().flatten().copied().collect();
    Ok(Sheet::new(vec![Layer { aov, kind: Kind::F32, channels, bytes: bytes.into() }], provenance))
}
