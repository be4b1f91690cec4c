//! PNG: the colour buffer as a picture, 8 bits of sRGB per component, with where it came from written inside.

use super::{Aov, Buffer, Data};
use crate::error::{Error, Place, Result};
use crate::measure::{Array, Values};
use rayon::prelude::*;
use std::io::{self, Cursor, Write};
use std::sync::LazyLock;

/// The bytes every PNG file begins with.
pub const MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Keyword and text of each chunk that says where a picture came from; keywords are Latin-1, 1 to 79 characters.
pub type Provenance = [(String, String)];

/// Writes the colour buffer as 8-bit RGB, each component [`level`]led, marked sRGB, with `provenance` as iTXt chunks.
/// The same buffer and provenance give the same bytes: no date, no machine.
///
/// # Errors
/// `out`'s own, and `InvalidInput` for another buffer than colour, one that fails [`Buffer::check`], or a keyword
/// that PNG does not allow.
pub fn write(color: &Buffer, provenance: &Provenance, out: &mut dyn Write) -> io::Result<()> {
    let invalid = |error: Error| io::Error::new(io::ErrorKind::InvalidInput, error);
    color.check().map_err(invalid)?;
    let (Aov::Color, Data::F32(linear)) = (color.aov, &color.data) else {
        return Err(invalid(Error::settings(format!("a {} buffer is no picture", color.aov), "write it as .npy")));
    };
    let mut levels = vec![0; linear.len()];
    let table = &*TABLE;
    levels.par_chunks_mut(1 << 14).zip(linear.par_chunks(1 << 14)).for_each(|(levels, linear)| {
        for (level, linear) in levels.iter_mut().zip(linear) {
            *level = table.level(*linear);
        }
    });
    write_levels([color.shape[1], color.shape[0]], &levels, provenance, out)
}

/// Writes `[width, height]` pixels of three sRGB levels each.
pub(crate) fn write_levels(
    [width, height]: [usize; 2],
    levels: &[u8],
    provenance: &Provenance,
    out: &mut dyn Write,
) -> io::Result<()> {
    let side = |n: usize| u32::try_from(n).map_err(|_| io::Error::other(format!("{n} pixels are too many for PNG")));
    let mut encoder = png::Encoder::new(out, side(width)?, side(height)?);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::Fast);
    // On shaded spheres smaller than the adaptive choice, and a third faster.
    encoder.set_filter(png::Filter::Paeth);
    for (keyword, text) in provenance {
        encoder.add_itxt_chunk(keyword.clone(), text.clone())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(levels)?;
    writer.finish()?;
    Ok(())
}

/// The 8-bit sRGB level of a linear component: clamped to [0, 1], through the transfer function of IEC 61966-2-1,
/// times 255, rounded to the nearest whole number. NaN is 0. Equal to the formula in f64 for every f32.
pub fn level(linear: f32) -> u8 {
    TABLE.level(linear)
}

/// The formula itself, for x in [0, 1].
fn level_by_formula(x: f32) -> u8 {
    let x = f64::from(x);
    let encoded = if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}

/// Cells per unit of linear light. Levels are at least 1 / (12.92 * 255) > 1 / 4096 apart, the slope being greatest
/// at black, so a cell holds at most one step; a power of two, so finding the cell is exact.
const CELLS: usize = 4096;

static TABLE: LazyLock<Table> = LazyLock::new(Table::new);

struct Table {
    /// The least f32 of each level; NaN after the last, which nothing reaches.
    least: [f32; 257],
    /// The level at the beginning of each cell; the last cell begins at 1.
    begin: [u8; CELLS + 1],
}

impl Table {
    fn new() -> Self {
        let mut least = [f32::NAN; 257];
        for (level, least) in least[..256].iter_mut().enumerate() {
            // Positive floats are ordered like their bits.
            let (mut low, mut high) = (0, 1f32.to_bits());
            while low < high {
                let middle = low.midpoint(high);
                if usize::from(level_by_formula(f32::from_bits(middle))) < level {
                    low = middle + 1;
                } else {
                    high = middle;
                }
            }
            *least = f32::from_bits(low);
        }
        Self { least, begin: std::array::from_fn(|cell| level_by_formula(cell as f32 / CELLS as f32)) }
    }

    fn level(&self, linear: f32) -> u8 {
        // The cast saturates: below 0 and NaN fall into the first cell, above 1 into the last.
        let cell = ((linear * CELLS as f32) as usize).min(CELLS);
        let level = self.begin[cell];
        level + u8::from(linear >= self.least[usize::from(level) + 1])
    }
}

/// Reads the picture in `bytes`, a whole PNG file, as levels of 0..255 or 0..65535; `name` is what errors call it.
/// Channels and alpha are the file's; palettes and transparent colours are resolved, and fewer than 8 bits are
/// stretched to 8.
///
/// # Errors
/// [`Error::Scene`] at the file, with the decoder's error, for anything malformed or truncated.
pub fn read(bytes: &[u8], name: &str) -> Result<Array> {
    let (shape, values) = decode(bytes).map_err(|source| Error::Scene {
        place: Box::new(Place::file(name)),
        problem: format!("not a whole PNG: {source}"),
        mend: "give a PNG that other programs open".into(),
        source: Some(source.into()),
    })?;
    Array::new(name, shape, values).map(Array::picture)
}

fn decode(bytes: &[u8]) -> Result<(Vec<usize>, Values), png::DecodingError> {
    // Deflate expands by 1032 at most, so what claims to be larger is not believed and not allocated.
    let limit = bytes.len().saturating_mul(1032).saturating_add(1 << 16);
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: limit });
    decoder.set_transformations(png::Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    let mut reader = decoder.read_info()?;
    let size = reader.output_buffer_size().filter(|size| *size <= limit).ok_or(png::DecodingError::LimitsExceeded)?;
    let mut samples = vec![0; size];
    let frame = reader.next_frame(&mut samples)?;
    reader.finish()?;
    let mut shape = vec![frame.height as usize, frame.width as usize];
    if frame.color_type.samples() > 1 {
        shape.push(frame.color_type.samples());
    }
    let values = match frame.bit_depth {
        png::BitDepth::Sixteen => {
            Values::U16(samples.as_chunks().0.iter().map(|bytes| u16::from_be_bytes(*bytes)).collect())
        }
        _ => Values::U8(samples),
    };
    Ok((shape, values))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn level_equals_the_formula_on_a_dense_sweep() {
        let one = 1f32.to_bits();
        let near = |x: &f32| (x.to_bits().saturating_sub(100)..=(x.to_bits() + 100).min(one)).collect::<Vec<_>>();
        let bits = (0..=one).step_by(997).chain(TABLE.least[..256].iter().flat_map(near));
        for x in bits.map(f32::from_bits) {
            assert_eq!(level(x), level_by_formula(x), "{x:e} = {:#010x}", x.to_bits());
        }
    }

    #[test]
    #[ignore = "every f32 in [0, 1]: a thousand million"]
    fn level_equals_the_formula_everywhere() {
        (0..=1f32.to_bits()).into_par_iter().map(f32::from_bits).for_each(|x| {
            assert_eq!(level(x), level_by_formula(x), "{x:e}");
        });
    }

    #[test]
    fn level_clamps() {
        for (x, expected) in [
            (-0.0, 0),
            (-1.0, 0),
            (f32::NEG_INFINITY, 0),
            (f32::NAN, 0),
            (1.0, 255),
            (1.5, 255),
            (f32::MAX, 255),
            (f32::INFINITY, 255),
        ] {
            assert_eq!(level(x), expected, "{x}");
        }
    }

    #[test]
    fn a_cell_holds_one_step() {
        let cell = |x: f32| (x * CELLS as f32) as usize;
        assert!(TABLE.least[1..256].windows(2).all(|pair| cell(pair[0]) < cell(pair[1])));
    }
}
