//! OpenEXR: every buffer as channels of one part, f32 or u32. The display window is the full frame, the data window the
//! rendered part. Losslessly compressed by ZIP, sixteen rows at a time; the bytes do not depend on the number of
//! threads. Channels are named as in the technical introduction to OpenEXR: R, G, B, A, Z, and `layer.channel` for
//! others, with the number of the light in `shadow`. File layout: <https://openexr.com/en/latest/OpenEXRFileLayout.html>.
//! The block writer of exr (1.74) writes its table twice, so that a file could not be compared while it is written again.

mod any;

use super::cryptomatte::{CHANNELS, MatteHead};
use super::format::FileFormat;
use super::layer::LayerFormat;
use super::rows::{EXR_ROWS, Found, Head, Rows, SeekRead, Sink, invalid, malformed, pulled};
use exr::meta::attribute::{ChannelDescription, IntegerBounds, SampleType};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::meta::{BlockDescription, MetaData, magic_number};
use exr::prelude::{AttributeValue, Compression, LineOrder, Text, Vec2};
use halfline::error::Result;
use halfline::frame::Aov;
use halfline::frame::provenance::Provenance;
use halfline::parallel;
use std::borrow::Cow;
use std::collections::VecDeque;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;

pub(super) use any::read;

/// The signature of OpenEXR files.
pub(super) const MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

/// The attribute that holds the provenance as JSON. The writer does not keep the order of custom attributes, so there
/// is only one.
const ATTRIBUTE: &str = "halfline";

/// Bytes per sample.
const SAMPLE: usize = 4;

/// The channels of a buffer, as in [`FileFormat::forms`]; channels of `shadow` have the lights' numbers.
fn names(form: &LayerFormat) -> Vec<Cow<'static, str>> {
    let fixed: &[&'static str] = match form.aov {
        Aov::Shadow => return (0..form.channels).map(|light| format!("shadow.{light}").into()).collect(),
        Aov::Color => &["R", "G", "B"],
        Aov::Alpha => &["A"],
        Aov::Depth => &["Z"],
        Aov::Distance => &["distance"],
        Aov::Normal => &["normal.X", "normal.Y", "normal.Z"],
        Aov::Position => &["position.X", "position.Y", "position.Z"],
        Aov::Id => &["id"],
        Aov::Mask => &["mask"],
        Aov::Certainty => &["certainty"],
        Aov::Bound => &["bound"],
        Aov::Occlusion => &["occlusion"],
    };
    fixed.iter().map(|name| Cow::Borrowed(*name)).collect()
}

/// The layout of the samples in the file.
struct ExrLayout {
    header: Header,
    /// The bytes before the offset table.
    start: Vec<u8>,
    /// For each channel in the file's order, its buffer and its index in that buffer.
    channels: Vec<[usize; 2]>,
    /// Samples per pixel of each buffer.
    each: Vec<usize>,
    width: usize,
    height: usize,
}

impl ExrLayout {
    fn of(head: &Head) -> io::Result<Self> {
        let text = |text: &str| Text::new_or_none(text).ok_or_else(|| invalid("the text cannot be stored in EXR"));
        let mut channels = Vec::new();
        for (layer, form) in head.forms.iter().enumerate() {
            let kind = if form.kind == super::layer::SampleType::U32 { SampleType::U32 } else { SampleType::F32 };
            for (place, name) in names(form).iter().enumerate() {
                channels.push((ChannelDescription::named(&**name, kind), [layer, place]));
            }
        }
        for (layer, matte) in (head.forms.len()..).zip(&head.mattes) {
            for (place, name) in matte.channels().enumerate() {
                channels.push((ChannelDescription::named(&*name, SampleType::F32), [layer, place]));
            }
        }
        channels.sort_by(|(a, _), (b, _)| a.name.cmp(&b.name));
        let [width, height] = head.size();
        let (list, channels): (Vec<_>, _) = channels.into_iter().unzip();
        let mut attributes = LayerAttributes {
            layer_position: Vec2(head.window.x0 as i32, head.window.y0 as i32),
            software_name: Some(text(head.provenance.get("Software").unwrap_or("halfline"))?),
            ..LayerAttributes::default()
        };
        attributes.other.insert(text(ATTRIBUTE)?, AttributeValue::Text(text(&head.provenance.to_json())?));
        let full = IntegerBounds::new((0, 0), (head.full[0] as usize, head.full[1] as usize));
        let header = Header::new(text("")?, (width, height), list.into())
            .with_encoding(Compression::ZIP16, BlockDescription::ScanLines, LineOrder::Increasing)
            .with_shared_attributes(ImageAttributes::new(full))
            .with_attributes(attributes);
        let mut start = Vec::new();
        let requirements = MetaData::validate(std::slice::from_ref(&header), true).map_err(io::Error::other)?;
        magic_number::write(&mut start)
            .and_then(|()| requirements.write(&mut start))
            .and_then(|()| header.write(&mut start))
            .map_err(io::Error::other)?;
        // Before the byte that ends the header.
        let end = start.len() - 1;
        let attributes = head.mattes.iter().flat_map(MatteHead::attributes).map(|(name, text)| attribute(&name, &text));
        start.splice(end..end, attributes.collect::<io::Result<Vec<_>>>()?.concat());
        let each = head.forms.iter().map(|form| form.channels).chain(head.mattes.iter().map(|_| CHANNELS)).collect();
        Ok(Self { header, start, channels, each, width, height })
    }

    fn blocks(&self) -> usize {
        self.height.div_ceil(EXR_ROWS)
    }

    /// The rows of a block, from 0 in this file.
    fn rows(&self, block: usize) -> Range<usize> {
        block * EXR_ROWS..(block * EXR_ROWS + EXR_ROWS).min(self.height)
    }

    /// The bounds of a block, for the compressor.
    fn bounds(&self, block: usize) -> IntegerBounds {
        let rows = self.rows(block);
        IntegerBounds::new((0, rows.start as i32), (self.width, rows.len()))
    }

    /// The y coordinate that identifies a block in the file.
    fn y(&self, block: usize) -> i32 {
        self.header.own_attributes.layer_position.1 + (block * EXR_ROWS) as i32
    }

    /// Bytes per row of one channel.
    fn line(&self) -> usize {
        self.width * SAMPLE
    }

    /// Bytes of `rows` rows of all channels.
    fn size(&self, rows: usize) -> usize {
        rows * self.channels.len() * self.line()
    }

    /// The samples of a block in this machine's byte order, as the compressor expects them: row by row, channel by
    /// channel.
    fn gather(&self, rows: &mut dyn Rows, block: usize) -> io::Result<Vec<u8>> {
        let range = self.rows(block);
        let mut bytes = vec![0; self.size(range.len())];
        for (layer, channels) in self.each.iter().enumerate() {
            let samples = pulled(rows, layer, range.clone())?;
            self.lines(layer).for_each(|(line, place)| {
                for row in 0..range.len() {
                    let out = bytes[self.size(row) + line * self.line()..][..self.line()].as_chunks_mut::<SAMPLE>().0;
                    let from = &samples[row * self.line() * channels..][..self.line() * channels];
                    for (out, pixel) in out.iter_mut().zip(from.as_chunks::<SAMPLE>().0.chunks_exact(*channels)) {
                        *out = u32::from_le_bytes(pixel[place]).to_ne_bytes();
                    }
                }
            });
        }
        Ok(bytes)
    }

    /// The inverse: rows of one buffer, counted from the block's first.
    fn scatter(&self, block: &[u8], layer: usize, rows: Range<usize>, out: &mut [u8]) {
        let channels = self.each[layer];
        self.lines(layer).for_each(|(line, place)| {
            for (row, out) in rows.clone().zip(out.chunks_exact_mut(self.line() * channels)) {
                let from = block[self.size(row) + line * self.line()..][..self.line()].as_chunks::<SAMPLE>().0;
                for (pixel, from) in out.as_chunks_mut::<SAMPLE>().0.chunks_exact_mut(channels).zip(from) {
                    pixel[place] = u32::from_ne_bytes(*from).to_le_bytes();
                }
            }
        });
    }

    /// For each channel of a buffer, its index among all channels and within the buffer.
    fn lines(&self, layer: usize) -> impl Iterator<Item = (usize, usize)> {
        let all = self.channels.iter().enumerate();
        all.filter(move |(_, [of, _])| *of == layer).map(|(line, [_, place])| (line, *place))
    }
}

/// The bytes of an attribute of text. The text is UTF-8, which the type of exr does not hold, and the order follows the calls.
fn attribute(name: &str, text: &str) -> io::Result<Vec<u8>> {
    let size = i32::try_from(text.len()).map_err(|_| invalid("the text is too long for EXR"))?;
    Ok([name.as_bytes(), b"\0string\0", &size.to_le_bytes(), text.as_bytes()].concat())
}

/// Writes every buffer and the provenance.
pub(super) fn write(head: &Head, rows: &mut dyn Rows, out: &mut dyn Sink) -> io::Result<()> {
    let layout = ExrLayout::of(head)?;
    let (table, blocks) = (layout.start.len() as u64, layout.blocks());
    out.write_all(&layout.start)?;
    // The offset table comes first in the file and is complete last.
    let mut place = table + 8 * blocks as u64;
    out.seek(SeekFrom::Start(place))?;
    let mut offsets = Vec::with_capacity(blocks);
    let compress = |block: usize, bytes: Vec<u8>| {
        layout.header.compression.compress_image_section_to_le(&layout.header, bytes, layout.bounds(block))
    };
    let together = blocks_together(layout.size(EXR_ROWS));
    for first in (0..blocks).step_by(together) {
        let some = first..(first + together).min(blocks);
        let mut raw = some.clone().map(|block| layout.gather(rows, block)).collect::<io::Result<Vec<_>>>()?;
        let packed =
            parallel::blocks(&mut raw[..], 1, &|n, raw| compress(first + n.start, std::mem::take(&mut raw[0])));
        for (block, packed) in some.zip(packed) {
            let packed = packed.map_err(io::Error::other)?;
            let size = i32::try_from(packed.len()).map_err(io::Error::other)?;
            offsets.push(place);
            out.write_all(&layout.y(block).to_le_bytes())?;
            out.write_all(&size.to_le_bytes())?;
            out.write_all(&packed)?;
            place += 8 + packed.len() as u64;
        }
    }
    out.seek(SeekFrom::Start(table))?;
    let offsets: Vec<u8> = offsets.into_iter().flat_map(u64::to_le_bytes).collect();
    out.write_all(&offsets)?;
    out.seek(SeekFrom::Start(place)).map(drop)
}

/// The number of blocks of `bytes` bytes compressed at once: two per thread, within a memory limit.
fn blocks_together(bytes: usize) -> usize {
    const MEMORY: usize = 64 << 20;
    (MEMORY / (3 * bytes).max(1)).clamp(1, 2 * parallel::threads())
}

/// The most bytes needed for blocks of rows of `row` bytes.
pub(super) fn memory(row: u64) -> u64 {
    let block = EXR_ROWS as u64 * row;
    3 * block * blocks_together(usize::try_from(block).unwrap_or(usize::MAX / 3)) as u64
}

/// Opens a file that [`write`] wrote; `None` where it has no provenance.
pub(super) fn open<'a>(mut input: Box<dyn SeekRead + 'a>, name: &str) -> Result<Found<'a>> {
    let fail = |why: &dyn std::fmt::Display| malformed(name, "EXR", why);
    let meta = MetaData::read_from_buffered(&mut input, true).map_err(|error| fail(&error))?;
    let [found] = &meta.headers[..] else { return Ok(None) };
    let Some(AttributeValue::Text(json)) = found.own_attributes.other.get(&Text::from(ATTRIBUTE)) else {
        return Ok(None);
    };
    let words = Provenance::from_json(json.to_string().as_bytes());
    let Some(mut head) = words.and_then(|words| Head::new(FileFormat::Exr, words)) else { return Ok(None) };
    let manifest = |name: &str| match found.own_attributes.other.get(&Text::from(name)) {
        Some(AttributeValue::Text(text)) => String::from_utf8(text.as_slice().to_vec()).ok(),
        _ => None,
    };
    head.mattes =
        MatteHead::all(&head.provenance, manifest).ok_or_else(|| fail(&"it lacks a manifest of Cryptomatte"))?;
    // The provenance defines the content; the rest of the header must agree with it.
    let layout = ExrLayout::of(&head).map_err(|error| fail(&error))?;
    let mut start = vec![0; layout.start.len()];
    let mut table = vec![0; 8 * layout.blocks()];
    let read = input.rewind().and_then(|()| input.read_exact(&mut start)).and_then(|()| input.read_exact(&mut table));
    read.map_err(|error| fail(&error))?;
    if start != layout.start {
        return Err(fail(&"its header differs from its provenance"));
    }
    let offsets = table.as_chunks().0.iter().map(|bytes| u64::from_le_bytes(*bytes)).collect();
    // A band of rows of the merged frame overlaps at most one more block of a tile than its own number of blocks.
    let kept = head.band_rows() / EXR_ROWS + 1;
    let recent = VecDeque::new();
    let rows = Blocks { input, name: name.into(), layout, offsets, recent, kept, samples: Vec::new() };
    Ok(Some((head, Box::new(rows))))
}

/// The rows of a file, block by block.
struct Blocks<'a> {
    input: Box<dyn SeekRead + 'a>,
    name: String,
    layout: ExrLayout,
    offsets: Vec<u64>,
    /// The last blocks that were read: all buffers of some rows are requested, then all of the next rows.
    recent: VecDeque<(usize, Vec<u8>)>,
    /// The most of them.
    kept: usize,
    samples: Vec<u8>,
}

impl Blocks<'_> {
    /// Reads a block, unless it is cached.
    fn load(&mut self, block: usize) -> Result<()> {
        if self.recent.iter().any(|(known, _)| *known == block) {
            return Ok(());
        }
        let fail = |why: &dyn std::fmt::Display| malformed(&self.name, "EXR", why);
        let mut start = [[0; 4]; 2];
        let read = self.input.seek(SeekFrom::Start(self.offsets[block]));
        let read = read.and_then(|_| self.input.read_exact(start.as_flattened_mut()));
        read.map_err(|error| fail(&error))?;
        let [y, size] = start.map(i32::from_le_bytes);
        let most = self.layout.size(self.layout.rows(block).len());
        let size = usize::try_from(size).ok().filter(|size| *size <= most && y == self.layout.y(block));
        let size = size.ok_or_else(|| fail(&format!("block {block} is not at its offset")))?;
        let mut packed = vec![0; size];
        self.input.read_exact(&mut packed).map_err(|error| fail(&error))?;
        let (header, bounds) = (&self.layout.header, self.layout.bounds(block));
        let bytes = header.compression.decompress_image_section_from_le(header, packed, bounds, true);
        let bytes = bytes.map_err(|error| fail(&error))?;
        if bytes.len() != most {
            return Err(fail(&format!("block {block} has {} bytes instead of {most}", bytes.len())));
        }
        self.recent.truncate(self.kept - 1);
        self.recent.push_front((block, bytes));
        Ok(())
    }
}

impl Rows for Blocks<'_> {
    fn rows(&mut self, layer: usize, rows: Range<usize>) -> Result<Cow<'_, [u8]>> {
        let row = self.layout.line() * self.layout.each[layer];
        let mut samples = std::mem::take(&mut self.samples);
        samples.resize(rows.len() * row, 0);
        for block in rows.start / EXR_ROWS..rows.end.div_ceil(EXR_ROWS) {
            self.load(block)?;
            let all = self.layout.rows(block);
            let part = all.start.max(rows.start)..all.end.min(rows.end);
            let out = &mut samples[(part.start - rows.start) * row..(part.end - rows.start) * row];
            let own = part.start - all.start..part.end - all.start;
            if let Some((_, bytes)) = self.recent.iter().find(|(known, _)| *known == block) {
                self.layout.scatter(bytes, layer, own, out);
            }
        }
        self.samples = samples;
        Ok(Cow::Borrowed(&self.samples))
    }
}
