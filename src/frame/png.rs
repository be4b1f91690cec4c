//! PNG: colour as a picture in sRGB of 8 or 16 bits; alpha, mask and normals as levels; distance and depth in whole steps
//! of 16 bits. Where a picture came from is written inside, and where a crop lies.

use super::provenance::Provenance;
use super::sheet::{Kind, Layer, Sheet, invalid};
use super::srgb::levels;
use super::{Aov, Buffer, Data};
use crate::error::{Error, Place, Result};
use crate::measure::{Array, Values};
use png::{BitDepth, ColorType};
use std::borrow::Cow;
use std::io::{self, Cursor, Write};

/// The bytes every PNG file begins with.
pub const MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Keyword and text of each chunk that says where a picture came from; keywords are Latin-1, 1 to 79 characters.
type Words = [(String, String)];

/// Writes the colour buffer as 8-bit RGB, each component [levelled](super::srgb::level), marked sRGB, with `words` as iTXt
/// chunks. The same buffer and words give the same bytes: no date, no machine.
///
/// # Errors
/// `out`'s own, and `InvalidInput` for another buffer than colour, one that fails [`Buffer::check`], or a keyword
/// that PNG does not allow.
pub fn write(color: &Buffer, words: &Words, out: &mut dyn Write) -> io::Result<()> {
    color.check().map_err(invalid)?;
    let (Aov::Color, Data::F32(linear)) = (color.aov, &color.data) else {
        return Err(invalid(Error::settings(format!("a {} buffer is no picture", color.aov), "write it as .npy")));
    };
    write_levels([color.shape[1], color.shape[0]], &levels(linear), words, out)
}

/// Writes `[width, height]` pixels of three sRGB levels each.
pub(crate) fn write_levels(
    [width, height]: [usize; 2],
    levels: &[u8],
    words: &Words,
    out: &mut dyn Write,
) -> io::Result<()> {
    let side = |n: usize| u32::try_from(n).map_err(|_| io::Error::other(format!("{n} pixels are too many for PNG")));
    let form = Form { color: ColorType::Rgb, depth: BitDepth::Eight, srgb: true };
    form.write([side(width)?, side(height)?], levels, None, words, out)
}

/// Writes the only layer. Only colour is marked as sRGB; a part of a frame says where it lies.
pub(super) fn write_sheet(sheet: &Sheet<'_>, out: &mut dyn Write) -> io::Result<()> {
    let layer = sheet.layer()?;
    let color = match layer.channels {
        1 => ColorType::Grayscale,
        3 => ColorType::Rgb,
        4 => ColorType::Rgba,
        n => return Err(invalid(format!("{n} channels of {} are no picture", layer.aov))),
    };
    // PNG's numbers are big endian.
    let (depth, samples) = match layer.kind {
        Kind::U8 => (BitDepth::Eight, Cow::Borrowed(&layer.bytes[..])),
        Kind::U16 => (BitDepth::Sixteen, layer.samples(u16::from_le_bytes).flat_map(u16::to_be_bytes).collect()),
        _ => return Err(invalid(format!("these samples of {} are not those of a PNG", layer.aov))),
    };
    let (window, [width, height]) = (sheet.window, sheet.full);
    let crop = (window.width(), window.height()) != (width, height);
    let offset = crop.then_some([window.x0, window.y0]);
    let form = Form { color, depth, srgb: layer.aov == Aov::Color };
    form.write([window.width(), window.height()], &samples, offset, sheet.provenance.words(), out)
}

/// What the samples are.
struct Form {
    color: ColorType,
    depth: BitDepth,
    srgb: bool,
}

impl Form {
    fn write(
        self,
        [width, height]: [u32; 2],
        samples: &[u8],
        offset: Option<[u32; 2]>,
        words: &Words,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(self.color);
        encoder.set_depth(self.depth);
        if self.srgb {
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        }
        encoder.set_compression(png::Compression::Fast);
        // On shaded spheres smaller than the adaptive choice, and a third faster.
        encoder.set_filter(png::Filter::Paeth);
        for (keyword, text) in words {
            encoder.add_itxt_chunk(keyword.clone(), text.clone())?;
        }
        let mut writer = encoder.write_header()?;
        if let Some([x, y]) = offset {
            // In pixels, as the extensions to PNG say: <https://www.w3.org/TR/png-3/#11oFFs>.
            let chunk: Vec<u8> = [x.to_be_bytes(), y.to_be_bytes()].concat().into_iter().chain([0]).collect();
            writer.write_chunk(png::chunk::ChunkType(*b"oFFs"), &chunk)?;
        }
        writer.write_image_data(samples)?;
        writer.finish()?;
        Ok(())
    }
}

/// Reads what [`write_sheet`] wrote; `None` where it does not say where it comes from.
pub(super) fn read_sheet(bytes: &[u8], name: &str) -> Result<Option<Sheet<'static>>> {
    let picture = decode(bytes, false).map_err(|source| malformed(name, source))?;
    let Some(aov) = picture.words.buffers().and_then(|all| all.first().copied()) else { return Ok(None) };
    let (kind, samples) = match picture.depth {
        BitDepth::Sixteen => (Kind::U16, picture.samples.as_chunks().0.iter().flat_map(|[a, b]| [*b, *a]).collect()),
        BitDepth::Eight => (Kind::U8, picture.samples),
        _ => return Ok(None),
    };
    let layer = Layer { aov, kind, channels: picture.channels, bytes: Cow::Owned(samples) };
    let size = [picture.width, picture.height];
    Ok(Sheet::new(vec![layer], picture.words).filter(|sheet| sheet.size() == size))
}

/// Reads the picture in `bytes`, a whole PNG file, as levels of 0..255 or 0..65535; `name` is what errors call it.
/// Channels and alpha are the file's; palettes and transparent colours are resolved, and fewer than 8 bits are
/// stretched to 8.
///
/// # Errors
/// [`Error::Scene`] at the file, with the decoder's error, for anything malformed or truncated.
pub fn read(bytes: &[u8], name: &str) -> Result<Array> {
    let picture = decode(bytes, true).map_err(|source| malformed(name, source))?;
    let mut shape = vec![picture.height, picture.width];
    if picture.channels > 1 {
        shape.push(picture.channels);
    }
    let values = match picture.depth {
        BitDepth::Sixteen => {
            Values::U16(picture.samples.as_chunks().0.iter().map(|bytes| u16::from_be_bytes(*bytes)).collect())
        }
        _ => Values::U8(picture.samples),
    };
    Array::new(name, shape, values).map(Array::picture)
}

fn malformed(name: &str, source: png::DecodingError) -> Error {
    Error::Scene {
        place: Box::new(Place::file(name)),
        problem: format!("not a whole PNG: {source}"),
        mend: "give a PNG that other programs open".into(),
        source: Some(source.into()),
    }
}

/// A decoded file. Samples are big endian, as PNG has them.
struct Picture {
    width: usize,
    height: usize,
    channels: usize,
    depth: BitDepth,
    samples: Vec<u8>,
    words: Provenance,
}

/// The picture, if `expand` with its palette resolved and without words, else as it is stored and with them.
fn decode(bytes: &[u8], expand: bool) -> Result<Picture, png::DecodingError> {
    // Deflate expands by 1032 at most, so what claims to be larger is not believed and not allocated.
    let limit = bytes.len().saturating_mul(1032).saturating_add(1 << 16);
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: limit });
    decoder.set_transformations(if expand { png::Transformations::EXPAND } else { png::Transformations::IDENTITY });
    decoder.set_ignore_text_chunk(expand);
    let mut reader = decoder.read_info()?;
    let size = reader.output_buffer_size().filter(|size| *size <= limit).ok_or(png::DecodingError::LimitsExceeded)?;
    let mut samples = vec![0; size];
    let frame = reader.next_frame(&mut samples)?;
    reader.finish()?;
    let texts = reader.info().utf8_text.iter();
    let words =
        texts.map(|chunk| Ok((chunk.keyword.clone(), chunk.get_text()?))).collect::<Result<_, png::DecodingError>>()?;
    Ok(Picture {
        width: frame.width as usize,
        height: frame.height as usize,
        channels: frame.color_type.samples(),
        depth: frame.bit_depth,
        samples,
        words,
    })
}
