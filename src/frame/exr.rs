//! OpenEXR: every buffer as channels of one part, f32 or u32, the display window being the full frame and the data window
//! the part that was rendered. Compressed by ZIP without loss, in one thread's order, so that bytes are always the same.
//! Names of channels follow the technical introduction to OpenEXR: R, G, B, A, Z, and `layer.channel` beyond.

use super::Aov;
use super::provenance::Provenance;
use super::sheet::{Kind, Layer, Sheet, invalid, malformed};
use crate::error::Result;
use exr::prelude::*;
use std::io::{self, Cursor, Write};

/// The bytes every OpenEXR file begins with.
pub(super) const MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

/// The attribute that holds the provenance, as JSON: the writer keeps attributes of our own in no order, so there is one.
const ATTRIBUTE: &str = "halfline";

/// The channels of a buffer and the type of their samples. A miss of id is 4294967295.
fn channels(aov: Aov) -> (Kind, &'static [&'static str]) {
    match aov {
        Aov::Color => (Kind::F32, &["R", "G", "B"]),
        Aov::Alpha => (Kind::F32, &["A"]),
        Aov::Depth => (Kind::F32, &["Z"]),
        Aov::Distance => (Kind::F32, &["distance"]),
        Aov::Normal => (Kind::F32, &["normal.X", "normal.Y", "normal.Z"]),
        Aov::Position => (Kind::F32, &["position.X", "position.Y", "position.Z"]),
        Aov::Id => (Kind::U32, &["id"]),
        Aov::Mask => (Kind::F32, &["mask"]),
        Aov::Certainty => (Kind::U32, &["certainty"]),
        Aov::Bound => (Kind::F32, &["bound"]),
    }
}

/// Writes every layer and the provenance.
pub(super) fn write(sheet: &Sheet<'_>, out: &mut dyn Write) -> io::Result<()> {
    let mut all = SmallVec::new();
    for layer in &sheet.layers {
        let (kind, names) = channels(layer.aov);
        if (layer.kind, layer.channels) != (kind, names.len()) {
            return Err(invalid(format!("these samples of {} are not those of an EXR", layer.aov)));
        }
        for (channel, name) in names.iter().enumerate() {
            let samples = match kind {
                Kind::U32 => {
                    FlatSamples::U32(layer.samples(u32::from_le_bytes).skip(channel).step_by(names.len()).collect())
                }
                _ => FlatSamples::F32(layer.samples(f32::from_le_bytes).skip(channel).step_by(names.len()).collect()),
            };
            all.push(AnyChannel::new(*name, samples));
        }
    }
    let text = |text: &str| Text::new_or_none(text).ok_or_else(|| invalid("EXR takes no such text"));
    let [width, height] = sheet.size();
    let mut attributes = LayerAttributes {
        layer_position: Vec2(sheet.window.x0 as i32, sheet.window.y0 as i32),
        software_name: Some(text(sheet.provenance.get("Software").unwrap_or("halfline"))?),
        ..LayerAttributes::default()
    };
    attributes.other.insert(text(ATTRIBUTE)?, AttributeValue::Text(text(&sheet.provenance.to_json())?));
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let layer = exr::image::Layer::new((width, height), attributes, encoding, AnyChannels::sort(all));
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new((0, 0), (sheet.full[0] as usize, sheet.full[1] as usize));
    // The table of offsets is written last and stands first.
    let mut bytes = Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut bytes).map_err(io::Error::other)?;
    out.write_all(bytes.get_ref())
}

/// Reads what [`write`] wrote; `None` where it does not say where it comes from.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<Option<Sheet<'static>>> {
    let fail = |why: &dyn std::fmt::Display| malformed(name, "EXR", why);
    let image = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let image = image
        .all_attributes()
        .non_parallel()
        .pedantic()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| fail(&error))?;
    let found = image.layer_data;
    let Some(AttributeValue::Text(json)) = found.attributes.other.get(&Text::from(ATTRIBUTE)) else { return Ok(None) };
    let provenance = Provenance::from_json(json.to_string().as_bytes());
    let Some((provenance, buffers)) = provenance.and_then(|words| words.buffers().map(|all| (words, all))) else {
        return Ok(None);
    };
    let names: usize = buffers.iter().map(|aov| channels(*aov).1.len()).sum();
    if names != found.channel_data.list.len() {
        return Err(fail(&"it holds other channels than its provenance says"));
    }
    let pixels = found.size.area();
    let mut layers = Vec::new();
    for aov in buffers {
        let (kind, names) = channels(aov);
        let mut bytes = vec![0; 4 * names.len() * pixels];
        for (n, name) in names.iter().enumerate() {
            let channel = found.channel_data.list.iter().find(|channel| channel.name == **name);
            let places = bytes.as_chunks_mut::<4>().0.iter_mut().skip(n).step_by(names.len());
            match (kind, channel.map(|channel| &channel.sample_data)) {
                (Kind::U32, Some(FlatSamples::U32(samples))) => {
                    places.zip(samples).for_each(|(place, sample)| *place = sample.to_le_bytes());
                }
                (Kind::F32, Some(FlatSamples::F32(samples))) => {
                    places.zip(samples).for_each(|(place, sample)| *place = sample.to_le_bytes());
                }
                _ => return Err(fail(&format!("it has no channel {name} of the promised type"))),
            }
        }
        layers.push(Layer { aov, kind, channels: names.len(), bytes: bytes.into() });
    }
    Ok(Sheet::new(layers, provenance))
}
