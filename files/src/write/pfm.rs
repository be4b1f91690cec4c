//! PFM, portable float map: three lines of text, then one or three channels of f32, bottom row first. FileFormat:
//! <https://www.pauldebevec.com/Research/HDR/PFM/>.

use super::format::FileFormat;
use super::layer::SampleType;
use super::plain::{self, Plain, reverse};
use super::rows::{Head, Rows, SeekRead, Sink, invalid, malformed, pulled};
use crate::error::Result;
use crate::frame::provenance::Provenance;
use std::io;

/// Writes the only buffer; a scale of -1 means little-endian. The provenance follows the last number.
pub(super) fn write(head: &Head, rows: &mut dyn Rows, out: &mut dyn Sink) -> io::Result<()> {
    out.write_all(header(head)?.as_bytes())?;
    for band in head.bands().rev() {
        let mut samples = pulled(rows, 0, band)?.into_owned();
        reverse(&mut samples, head.row(0));
        out.write_all(&samples)?;
    }
    out.write_all(head.provenance.trailer().as_bytes())
}

fn header(head: &Head) -> io::Result<String> {
    let form = head.form()?;
    let magic = match (form.kind, form.channels) {
        (SampleType::F32, 1) => "Pf",
        (SampleType::F32, 3) => "PF",
        _ => return Err(invalid(format!("a PFM cannot hold a {} buffer", form.aov))),
    };
    let [width, height] = head.size();
    Ok(format!("{magic}\n{width} {height}\n-1.0\n"))
}

/// Opens a file that [`write`] wrote; `None` where it has no provenance.
pub(super) fn open<'a>(mut input: Box<dyn SeekRead + 'a>, name: &str) -> Result<Option<(Head, Box<dyn Rows + 'a>)>> {
    let fail = |why: &str| malformed(name, "PFM", why);
    let (bytes, length) = plain::start(&mut *input, name)?;
    let mut lines = bytes.splitn(4, |byte| *byte == b'\n');
    let mut line = || lines.next().and_then(|line| str::from_utf8(line).ok());
    let (Some(magic), Some(size), Some("-1.0")) = (line(), line(), line()) else {
        return Err(fail("the header was not written by halfline"));
    };
    let channels: u64 = if magic == "PF" { 3 } else { 1 };
    let size = size.split_once(' ').and_then(|(w, h)| Some((w.parse::<u64>().ok()?, h.parse::<u64>().ok()?)));
    let size = size.and_then(|(w, h)| w.checked_mul(4 * channels)?.checked_mul(h)).filter(|size| *size > 0);
    let size = size.ok_or_else(|| fail("its size is not valid"))?;
    let first = (bytes.len() - lines.next().unwrap_or_default().len()) as u64;
    let Some(end) = first.checked_add(size).filter(|end| *end <= length) else {
        return Err(fail("it ends before its last number"));
    };
    let words = plain::tail(&mut *input, end, length, name)?.and_then(|tail| Provenance::from_trailer(&tail));
    let Some(head) = words.and_then(|words| Head::new(FileFormat::Pfm, words)) else { return Ok(None) };
    if !header(&head).is_ok_and(|header| bytes.starts_with(header.as_bytes())) {
        return Ok(None);
    }
    let (layers, bottom_up) = (vec![(first, head.row(0))], Some(head.size()[1]));
    let rows = Plain { input, name: name.into(), layers, bottom_up, samples: Vec::new() };
    Ok(Some((head, Box::new(rows))))
}
