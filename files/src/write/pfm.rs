//! PFM, portable float map: `PF` or `Pf`, width, height, and a scale whose sign gives the byte order, separated by white
//! space; then one or three channels of f32, bottom row first: <https://www.pauldebevec.com/Research/HDR/PFM/>. The
//! absolute value of the scale is a unit and is ignored. Written are three lines, with a scale of -1.

use super::format::FileFormat;
use super::layer::SampleType;
use super::plain::{self, reverse};
use super::rows::{Found, Head, Rows, SeekRead, Sink, invalid, malformed, pulled};
use halfline::error::Result;
use halfline::frame::array::{Array, Values};
use halfline::frame::provenance::Provenance;
use halfline::memory::check;
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

/// The values of a header, and the place of the numbers behind it.
struct PfmHeader {
    channels: usize,
    width: usize,
    height: usize,
    scale: f64,
    /// The position of the first number, and the bytes of all numbers.
    start: usize,
    size: usize,
}

impl PfmHeader {
    /// The layout of the file that begins with `bytes`, or why it has none.
    fn of(bytes: &[u8]) -> Result<Self, &'static str> {
        let mut at = 0;
        let mut word = || {
            let start = at + bytes[at..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
            let length = bytes[start..].iter().take(32).take_while(|byte| !byte.is_ascii_whitespace()).count();
            at = start + length;
            std::str::from_utf8(&bytes[start..at]).unwrap_or_default()
        };
        let channels = if word() == "PF" { 3 } else { 1 };
        let sides: [Option<usize>; 2] = [word().parse().ok(), word().parse().ok()];
        let scale = word().parse::<f64>().ok().filter(|scale| *scale != 0.0 && scale.is_finite());
        let ([Some(width), Some(height)], Some(scale)) = (sides, scale) else {
            return Err("the header has no size and scale");
        };
        let row = width.checked_mul(4 * channels).filter(|row| *row > 0 && height > 0);
        let size = row.and_then(|row| row.checked_mul(height)).ok_or("its size is not valid")?;
        // A single white space ends the header.
        Ok(Self { channels, width, height, scale, start: at + 1, size })
    }
}

/// Opens a file that [`write`] wrote; `None` where it has no provenance.
pub(super) fn open<'a>(input: Box<dyn SeekRead + 'a>, name: &str) -> Result<Found<'a>> {
    let layout = |bytes: &[u8], length: u64| {
        let fail = |why: &str| malformed(name, "PFM", why);
        if bytes.split(|byte| *byte == b'\n').nth(2) != Some(&b"-1.0"[..]) {
            return Err(fail("the header was not written by halfline"));
        }
        let PfmHeader { start, size, .. } = PfmHeader::of(bytes).map_err(fail)?;
        let end = (start as u64).checked_add(size as u64).filter(|end| *end <= length);
        end.map(|end| [start as u64, end]).ok_or_else(|| fail("it ends before its last number"))
    };
    plain::open(input, name, FileFormat::Pfm, layout, |head| header(head).map(String::into_bytes))
}

/// Reads the numbers in `bytes`, a complete file of any program.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<Array> {
    let fail = |why: &str| malformed(name, "PFM", why);
    let PfmHeader { channels, width, height, scale, start, size } = PfmHeader::of(bytes).map_err(fail)?;
    let data = bytes.get(start..).unwrap_or_default();
    let (data, rest) = data.split_at_checked(size).ok_or_else(|| fail("it ends before its last number"))?;
    if !rest.is_empty() && Provenance::from_trailer(rest).is_none() {
        return Err(fail("bytes follow its last number"));
    }
    check(size as u64, || format!("the numbers of {name}"))?;
    let number = |bytes: &[u8; 4]| if scale < 0.0 { f32::from_le_bytes(*bytes) } else { f32::from_be_bytes(*bytes) };
    let rows = data.chunks_exact(size / height).rev();
    let values = rows.flat_map(|row| row.as_chunks::<4>().0).map(number).collect();
    let shape = if channels == 3 { vec![height, width, 3] } else { vec![height, width] };
    Array::new(name, shape, Values::F32(values))
}
