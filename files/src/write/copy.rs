//! TIFF, JPEG and WebP: copies of a picture for other programs, with its provenance and resolution, in Exif where the format
//! has no place of its own: <https://www.cipa.jp/std/documents/download_e.html?CIPA_DC-008-2024-E>.

use super::format::{Dpi, FileFormat};
use super::layer::{LayerFormat, SampleType};
use super::rows::{Head, Rows, Sink, invalid, pulled};
use halfline::frame::provenance::Provenance;
use image_webp::WebPEncoder;
use jpeg_encoder::{EncodingError, PixelDensity, SamplingFactor};
use std::io::{self, Cursor, Seek, Write};
use tiff::encoder::colortype::{ColorType, Gray8, Gray16, RGB8, RGB16, RGBA8, RGBA16};
use tiff::encoder::{Compression, DirectoryEncoder, Rational, TiffEncoder, TiffKind, TiffValue};
use tiff::tags::{ExtraSamples, Predictor, ResolutionUnit, Tag};
use tiff::{TiffError, TiffResult};

/// The quality of a JPEG, of 100: its losses are about a level, and edges of spheres keep their colours, since these have the
/// resolution of the brightness.
const QUALITY: u8 = 95;

/// The longest Exif block in a JPEG: a segment has 16 bits for its length, and begins with it and a name of 6 bytes.
const EXIF: usize = 65_535 - 2 - 6;

/// The format of a copy that begins with `start`.
pub(super) fn detect(start: &[u8]) -> Option<FileFormat> {
    match start {
        [b'I', b'I', b'*', 0, ..] | [b'M', b'M', 0, b'*', ..] => Some(FileFormat::Tiff),
        [0xff, 0xd8, 0xff, ..] => Some(FileFormat::Jpeg),
        _ if start.starts_with(b"RIFF") && start.get(8..12) == Some(b"WEBP") => Some(FileFormat::WebP),
        _ => None,
    }
}

/// The most bytes that encoding needs: the levels, the pixels that an encoder makes of them, and its file.
pub(super) fn memory(head: &Head) -> u64 {
    3 * head.bytes()
}

/// Writes a TIFF, LZW with differences of neighbours: every program reads it.
pub(super) fn write_tiff(head: &Head, rows: &mut dyn Rows, out: &mut dyn Sink) -> io::Result<()> {
    let layer = head.form()?;
    match (layer.channels, layer.kind) {
        (1, SampleType::U8) => strips::<Gray8>(head, rows, out, |samples| samples),
        (1, SampleType::U16) => strips::<Gray16>(head, rows, out, words),
        (3, SampleType::U8) => strips::<RGB8>(head, rows, out, |samples| samples),
        (3, SampleType::U16) => strips::<RGB16>(head, rows, out, words),
        (4, SampleType::U8) => strips::<RGBA8>(head, rows, out, |samples| samples),
        (4, SampleType::U16) => strips::<RGBA16>(head, rows, out, words),
        _ => Err(refused(FileFormat::Tiff, layer)),
    }
}

fn words(samples: Vec<u8>) -> Vec<u16> {
    samples.as_chunks().0.iter().map(|word| u16::from_le_bytes(*word)).collect()
}

/// Writes the strips of a TIFF; `numbers` gives the numbers of its samples.
fn strips<C: ColorType>(
    head: &Head,
    rows: &mut dyn Rows,
    out: &mut dyn Sink,
    numbers: fn(Vec<u8>) -> Vec<C::Inner>,
) -> io::Result<()>
where
    [C::Inner]: TiffValue,
{
    let write = || -> TiffResult<()> {
        let encoder = TiffEncoder::new(out)?;
        let mut encoder = encoder.with_compression(Compression::Lzw).with_predictor(Predictor::Horizontal);
        let [width, height] = [head.window.width(), head.window.height()];
        let mut picture = encoder.new_image::<C>(width, height)?;
        if C::BITS_PER_SAMPLE.len() == 4 {
            let straight = ExtraSamples::UnassociatedAlpha.to_u16();
            picture.encoder().write_tag(Tag::ExtraSamples, straight)?;
        }
        describe(picture.encoder(), &head.provenance)?;
        // All at once: single strips are not compressed (tiff 0.11.3).
        picture.write_data(&numbers(levels(head, rows)?))
    };
    write().map_err(|error| match error {
        TiffError::IoError(error) => error,
        error => invalid(error),
    })
}

/// Writes the provenance and the resolution as tags.
fn describe<W: Write + Seek, K: TiffKind>(
    tags: &mut DirectoryEncoder<'_, W, K>,
    provenance: &Provenance,
) -> TiffResult<()> {
    tags.write_tag(Tag::ImageDescription, &text(provenance)[..])?;
    if let Some(software) = provenance.get("Software") {
        tags.write_tag(Tag::Software, software)?;
    }
    if let Some(dpi) = Dpi::of(provenance) {
        for side in [Tag::XResolution, Tag::YResolution] {
            tags.write_tag(side, Rational { n: dpi.per_inch(), d: 1 })?;
        }
        tags.write_tag(Tag::ResolutionUnit, ResolutionUnit::Inch.to_u16())?;
    }
    Ok(())
}

/// The provenance, one keyword a line. Texts of TIFF and Exif are ASCII, so other characters are escaped, such as `\u{7403}`.
fn text(provenance: &Provenance) -> String {
    let text: String = provenance.words().iter().map(|(key, text)| format!("{key}: {text}\n")).collect();
    let escaped = |c: char| if c.is_ascii() && c != '\0' { String::from(c) } else { c.escape_unicode().to_string() };
    text.chars().map(escaped).collect()
}

/// An Exif block with the provenance: a TIFF without a picture.
fn exif(provenance: &Provenance) -> io::Result<Vec<u8>> {
    let write = || -> TiffResult<Vec<u8>> {
        let mut block = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut block)?;
        let mut tags = encoder.image_directory()?;
        describe(&mut tags, provenance)?;
        tags.finish()?;
        Ok(block.into_inner())
    };
    write().map_err(invalid)
}

/// Writes a JPEG.
pub(super) fn write_jpeg(head: &Head, rows: &mut dyn Rows, out: &mut dyn Sink) -> io::Result<()> {
    let layer = head.form()?;
    if (layer.channels, layer.kind) != (3, SampleType::U8) {
        return Err(refused(FileFormat::Jpeg, layer));
    }
    // The hash of the levels is not the hash of what is read again.
    let provenance = head.provenance.without_pixels();
    let short = || provenance.words().iter().filter(|(_, text)| text.len() < 1 << 12).cloned().collect();
    let mut block = exif(&provenance)?;
    if block.len() > EXIF {
        block = exif(&short())?;
    }
    let [width, height] = head.size().map(u16::try_from);
    let (Ok(width), Ok(height)) = (width, height) else { return Err(refused(FileFormat::Jpeg, layer)) };
    let mut encoder = jpeg_encoder::Encoder::new(&mut *out, QUALITY);
    encoder.set_sampling_factor(SamplingFactor::R_4_4_4);
    if let Some(dpi) = Dpi::of(&provenance).and_then(|dpi| u16::try_from(dpi.per_inch()).ok()) {
        encoder.set_density(PixelDensity::dpi(dpi));
    }
    let written = encoder
        .add_exif_metadata(&block)
        .and_then(|()| encoder.encode(&levels(head, rows)?, width, height, jpeg_encoder::ColorType::Rgb));
    written.map_err(|error| match error {
        EncodingError::IoError(error) => error,
        error => invalid(error),
    })
}

/// Writes a WebP without losses.
pub(super) fn write_webp(head: &Head, rows: &mut dyn Rows, out: &mut dyn Sink) -> io::Result<()> {
    let layer = head.form()?;
    let color = match (layer.channels, layer.kind) {
        (1, SampleType::U8) => image_webp::ColorType::L8,
        (3, SampleType::U8) => image_webp::ColorType::Rgb8,
        (4, SampleType::U8) => image_webp::ColorType::Rgba8,
        _ => return Err(refused(FileFormat::WebP, layer)),
    };
    let mut encoder = WebPEncoder::new(&mut *out);
    encoder.set_exif_metadata(exif(&head.provenance)?);
    let written = encoder.encode(&levels(head, rows)?, head.window.width(), head.window.height(), color);
    written.map_err(|error| match error {
        image_webp::EncodingError::IoError(error) => error,
        error => invalid(error),
    })
}

/// All levels of the picture.
fn levels(head: &Head, rows: &mut dyn Rows) -> io::Result<Vec<u8>> {
    let mut all = Vec::with_capacity(head.bytes() as usize);
    head.bands().try_for_each(|band| {
        all.extend_from_slice(&pulled(rows, 0, band)?);
        io::Result::Ok(())
    })?;
    Ok(all)
}

/// The error for a buffer that a copy cannot hold.
fn refused(format: FileFormat, layer: LayerFormat) -> io::Error {
    let LayerFormat { aov, kind, channels } = layer;
    invalid(format!("a {} cannot hold {channels} channels of {aov} of {kind:?}", format.name()))
}
