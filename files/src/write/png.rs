//! PNG: colour as an sRGB picture of 8 or 16 bits; alpha, occlusion, mask and normals as levels; distance and depth as 16-bit
//! multiples of a unit. Text chunks hold the provenance, and a crop has its offset.

mod joined;
mod strips;

use super::format::{Dpi, FileFormat};
use super::layer::SampleType;
use super::rows::{Found, Head, Rows, SeekRead, Sink, invalid, pulled};
use halfline::error::{Error, Place, Result};
use halfline::frame::array::{Array, Values};
use halfline::frame::srgb::levels;
use halfline::frame::{Aov, Buffer, Data};
use halfline::memory::check;
use png::{BitDepth, ColorType, PixelDimensions, Unit};
use std::borrow::Cow;
use std::io::{self, Cursor, Write};
use std::ops::Range;
use strips::Strips;

/// The signature of PNG files.
pub const MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Keyword and text of each provenance chunk; keywords are Latin-1, 1 to 79 characters.
type TextChunks = [(String, String)];

/// Writes the colour buffer as 8-bit RGB, each component [encoded](halfline::frame::srgb::level) and marked as sRGB, with `words`
/// as iTXt chunks. Equal buffers and words give equal bytes: no date and no machine name is written.
///
/// # Errors
/// The errors of `out`, and `InvalidInput` for a buffer other than colour, one that fails [`Buffer::check`], or a
/// keyword that PNG does not allow.
pub fn write(color: &Buffer, words: &TextChunks, out: &mut dyn Write) -> io::Result<()> {
    color.check().map_err(invalid)?;
    let (Aov::Color, Data::F32(linear)) = (color.aov, &color.data) else {
        return Err(invalid(Error::settings(
            format!("expected a color buffer, found a {} buffer", color.aov),
            "write it as .npy",
        )));
    };
    write_levels([color.shape[1], color.shape[0]], words, out, |out| out.write_all(&levels(linear)))
}

/// Writes `[width, height]` pixels of three sRGB levels each; `fill` writes the levels row by row.
pub fn write_levels(
    [width, height]: [usize; 2],
    words: &TextChunks,
    out: &mut dyn Write,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let side =
        |n: usize| u32::try_from(n).map_err(|_| io::Error::other(format!("a side of {n} pixels is too long for PNG")));
    let form = SampleFormat { color: ColorType::Rgb, depth: BitDepth::Eight, srgb: true, dpi: None };
    form.write([side(width)?, side(height)?], None, words, out, fill)
}

/// The file of a drawing: `[width, height]` pixels of three sRGB levels each, row by row.
///
/// # Errors
/// Errors of the encoder.
pub fn of_levels(size: [usize; 2], levels: &[u8]) -> io::Result<Vec<u8>> {
    let software = [("Software".to_owned(), concat!("halfline ", env!("CARGO_PKG_VERSION")).to_owned())];
    let mut file = Vec::new();
    write_levels(size, &software, &mut file, |out| out.write_all(levels))?;
    Ok(file)
}

/// Writes the only buffer. Only colour is marked as sRGB; a part of a frame gets its offset.
pub(super) fn write_sheet(head: &Head, rows: &mut dyn Rows, out: &mut dyn Sink) -> io::Result<()> {
    let layer = head.form()?;
    let color = match layer.channels {
        1 => ColorType::Grayscale,
        3 => ColorType::Rgb,
        4 => ColorType::Rgba,
        n => return Err(invalid(format!("a PNG cannot hold {n} channels of {}", layer.aov))),
    };
    let depth = match layer.kind {
        SampleType::U8 => BitDepth::Eight,
        SampleType::U16 => BitDepth::Sixteen,
        _ => return Err(invalid(format!("a PNG cannot hold samples of {} of this type", layer.aov))),
    };
    let (window, [width, height]) = (head.window, head.full);
    let crop = (window.width(), window.height()) != (width, height);
    let offset = crop.then_some([window.x0, window.y0]);
    let form = SampleFormat { color, depth, srgb: layer.aov == Aov::Color, dpi: Dpi::of(&head.provenance) };
    form.write([window.width(), window.height()], offset, head.provenance.words(), out, |out| {
        head.bands().try_for_each(|band| {
            let samples = pulled(rows, 0, band)?;
            if depth == BitDepth::Sixteen { out.write_all(&swapped(&samples)) } else { out.write_all(&samples) }
        })
    })
}

/// The most bytes needed for strips of rows of `row` bytes.
pub(super) fn memory(row: u64) -> u64 {
    strips::memory(row)
}

/// Swaps the bytes of two-byte samples: PNG is big-endian.
fn swapped(samples: &[u8]) -> Vec<u8> {
    samples.as_chunks().0.iter().flat_map(|[a, b]| [*b, *a]).collect()
}

/// The format of the samples.
struct SampleFormat {
    color: ColorType,
    depth: BitDepth,
    srgb: bool,
    /// The resolution, in a pHYs chunk.
    dpi: Option<Dpi>,
}

impl SampleFormat {
    /// Writes the file; `fill` writes the samples row by row.
    fn write(
        self,
        [width, height]: [u32; 2],
        offset: Option<[u32; 2]>,
        words: &TextChunks,
        out: &mut dyn Write,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(self.color);
        encoder.set_depth(self.depth);
        if self.srgb {
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        }
        encoder.set_pixel_dims(self.dpi.map(Dpi::per_metre).map(|per_metre| PixelDimensions {
            xppu: per_metre,
            yppu: per_metre,
            unit: Unit::Meter,
        }));
        for (keyword, text) in words {
            encoder.add_itxt_chunk(keyword.clone(), text.clone())?;
        }
        let mut writer = encoder.write_header()?;
        if let Some([x, y]) = offset {
            // In pixels, as in the extensions to PNG: <https://www.w3.org/TR/png-3/#11oFFs>.
            let chunk: Vec<u8> = [x.to_be_bytes(), y.to_be_bytes()].concat().into_iter().chain([0]).collect();
            writer.write_chunk(png::chunk::ChunkType(*b"oFFs"), &chunk)?;
        }
        let pixel = self.color.samples() * if self.depth == BitDepth::Sixteen { 2 } else { 1 };
        let pass = |part: &[u8]| writer.write_chunk(png::chunk::IDAT, part).map_err(io::Error::from);
        let mut strips = Strips::new(width as usize * pixel, pixel, pass);
        fill(&mut strips)?;
        strips.finish(height.into())?;
        writer.finish()?;
        Ok(())
    }
}

/// Opens a file that [`write_sheet`] wrote; `None` where it has no provenance.
pub(super) fn open<'a>(input: Box<dyn SeekRead + 'a>, name: &str) -> Result<Found<'a>> {
    let mut options = png::DecodeOptions::default();
    // A failed checksum is an error in text chunks too.
    options.set_skip_ancillary_crc_failures(false);
    options.set_ignore_adler32(false);
    let mut decoder = png::Decoder::new_with_options(input, options);
    decoder.set_limits(png::Limits { bytes: ROWS_AND_WORDS });
    decoder.set_transformations(png::Transformations::IDENTITY);
    let reader = decoder.read_info().map_err(|source| malformed(name, source))?;
    let info = reader.info();
    let texts = info.utf8_text.iter();
    let words = texts.map(|chunk| Ok((chunk.keyword.clone(), chunk.get_text()?)));
    let words = words.collect::<Result<_, png::DecodingError>>().map_err(|source| malformed(name, source))?;
    let Some(head) = Head::new(FileFormat::Png, words) else { return Ok(None) };
    let form = head.form().map_err(|source| malformed(name, png::DecodingError::IoError(source)))?;
    let depth = if form.kind == SampleType::U16 { BitDepth::Sixteen } else { BitDepth::Eight };
    let size = [info.width as usize, info.height as usize];
    let is_ours = size == head.size() && info.bit_depth == depth && !info.interlaced && info.palette.is_none();
    if !is_ours || info.color_type.samples() != form.channels {
        return Ok(None);
    }
    let (row, height) = (head.row(0), size[1]);
    let lines = PngRows { reader, name: name.into(), next: 0, height, row, depth, samples: Vec::new() };
    Ok(Some((head, Box::new(lines))))
}

/// Bytes that the decoder may allocate for text and for rows, which have at most [`halfline::scene::MAX_SIDE`] pixels;
/// larger claims of a damaged file are rejected.
const ROWS_AND_WORDS: usize = 64 << 20;

/// The rows of a file, in order.
struct PngRows<'a> {
    reader: png::Reader<Box<dyn SeekRead + 'a>>,
    name: String,
    /// The next row.
    next: usize,
    height: usize,
    /// Bytes of a row.
    row: usize,
    depth: BitDepth,
    samples: Vec<u8>,
}

impl Rows for PngRows<'_> {
    fn rows(&mut self, _: usize, rows: Range<usize>) -> Result<Cow<'_, [u8]>> {
        if rows.start != self.next {
            let problem = format!("rows {rows:?} of {} were requested after row {}", self.name, self.next);
            return Err(Error::settings(problem, "read the rows of a PNG in order"));
        }
        self.samples.resize(rows.len() * self.row, 0);
        for row in self.samples.chunks_exact_mut(self.row) {
            self.reader.read_row(row).map_err(|source| malformed(&self.name, source))?;
        }
        self.next = rows.end;
        if self.next == self.height {
            self.reader.finish().map_err(|source| malformed(&self.name, source))?;
        }
        Ok(match self.depth {
            BitDepth::Sixteen => Cow::Owned(swapped(&self.samples)),
            _ => Cow::Borrowed(&self.samples),
        })
    }
}

/// Reads the picture in `bytes`, a complete PNG file, as levels of 0..255 or 0..65535; errors refer to it by `name`.
/// Channels and alpha are the file's; palettes and transparent colours are resolved, and fewer than 8 bits are
/// scaled to 8.
///
/// # Errors
/// [`Error::Scene`] at the file, with the decoder's error, for anything malformed or truncated.
pub fn read(bytes: &[u8], name: &str) -> Result<Array> {
    // Deflate expands by a factor of 1032 at most, so a larger claim is rejected and not allocated.
    let limit = bytes.len().saturating_mul(1032).saturating_add(1 << 16);
    let fail = |source: png::DecodingError| malformed(name, source);
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: limit });
    decoder.set_transformations(png::Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    let mut reader = decoder.read_info().map_err(fail)?;
    let size = reader.output_buffer_size().filter(|size| *size <= limit);
    let size = size.ok_or_else(|| fail(png::DecodingError::LimitsExceeded))?;
    // The samples, and a copy if they have two bytes.
    check(2 * size as u64, || format!("the samples of {name}"))?;
    let mut samples = vec![0; size];
    let frame = reader.next_frame(&mut samples).map_err(fail)?;
    reader.finish().map_err(fail)?;
    let mut shape = vec![frame.height as usize, frame.width as usize];
    shape.extend(Some(frame.color_type.samples()).filter(|channels| *channels > 1));
    let values = match frame.bit_depth {
        BitDepth::Sixteen => {
            Values::U16(samples.as_chunks().0.iter().map(|bytes| u16::from_be_bytes(*bytes)).collect())
        }
        _ => Values::U8(samples),
    };
    Array::new(name, shape, values).map(Array::picture)
}

fn malformed(name: &str, source: png::DecodingError) -> Error {
    Error::Scene {
        place: Box::new(Place::file(name)),
        problem: format!("the PNG file is damaged or incomplete: {source}"),
        mend: "use a PNG that other programs can open".into(),
        source: Some(source.into()),
    }
}
