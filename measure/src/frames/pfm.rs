//! Portable float maps of any program: `PF` or `Pf`, width, height, and a scale whose sign gives the byte order,
//! separated by white space; then rows of f32 from the bottom (pauldebevec.com/Research/HDR/PFM). The absolute value of
//! the scale is a unit and is ignored.

use super::super::{Array, Values};
use halfline::error::{Error, Place, Result};
use halfline::frame::provenance::Provenance;
use halfline::memory::check;

pub(super) fn read(bytes: &[u8], name: &str) -> Result<Array> {
    let fail = |why: &str| {
        Error::scene(Place::file(name), format!("the PFM file is damaged or incomplete: {why}"), "render it again")
    };
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
        return Err(fail("the header has no size and scale"));
    };
    // A single white space ends the header.
    let data = bytes.get(at + 1..).unwrap_or_default();
    let row = width.checked_mul(4 * channels).filter(|row| *row > 0 && height > 0);
    let size = row.and_then(|row| row.checked_mul(height)).ok_or_else(|| fail("its size is not valid"))?;
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
