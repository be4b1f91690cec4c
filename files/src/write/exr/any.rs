//! OpenEXR files of any program: channels become buffers by the names in the technical introduction to OpenEXR. R, G, B
//! are `color`, A is `alpha`, Z is `depth`, and `layer.X`, `layer.Y`, `layer.Z` are the components of `layer`, as are
//! `layer.0`, `layer.1` and so on. In files with several parts the name of a buffer includes its part's name.

use crate::write::rows::{NamedArrays, malformed};
use exr::prelude::*;
use halfline::error::Result;
use halfline::frame::array::{Array, Values};
use halfline::memory::check;
use std::collections::BTreeMap;
use std::io::Cursor;

pub(in crate::write) fn read(bytes: &[u8], name: &str) -> Result<(NamedArrays, Option<[i32; 2]>)> {
    let fail = |why: &dyn std::fmt::Display| malformed(name, "EXR", why);
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), true).map_err(|error| fail(&error))?;
    // A size beyond any compression ratio is rejected and not allocated.
    let most = 1032 * bytes.len() as u64;
    let mut size = 0_u64;
    for header in &meta.headers {
        let channels = header.channels.list.len() as u64;
        let samples = (header.layer_size.area() as u64).saturating_mul(channels);
        size = size.saturating_add(samples.saturating_mul(4));
    }
    if size > most {
        return Err(fail(&format!("{size} bytes of samples cannot be stored in {} bytes", bytes.len())));
    }
    check(3 * size, || format!("the samples of {name}"))?;
    let image = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().all_layers();
    let image = image.all_attributes().non_parallel().pedantic().from_buffered(Cursor::new(bytes));
    let parts = image.map_err(|error| fail(&error))?.layer_data;
    let several = parts.len() > 1;
    let (mut buffers, mut origin) = (Vec::new(), None);
    for (n, part) in parts.iter().enumerate() {
        let [width, height] = [part.size.0, part.size.1];
        let position = part.attributes.layer_position;
        if n == 0 {
            origin = Some([position.0, position.1]);
        }
        let prefix = match &part.attributes.layer_name {
            Some(text) if several => format!("{text}."),
            _ if several => format!("{n}."),
            _ => String::new(),
        };
        // For each buffer, its channels with their index.
        let mut groups: BTreeMap<String, Vec<(usize, &FlatSamples)>> = BTreeMap::new();
        for channel in &part.channel_data.list {
            let (buffer, place) = component(&channel.name.to_string());
            groups.entry(buffer).or_default().push((place, &channel.sample_data));
        }
        for (buffer, mut channels) in groups {
            channels.sort_by_key(|(place, _)| *place);
            let samples: Vec<&FlatSamples> = channels.iter().map(|(_, samples)| *samples).collect();
            if samples.iter().any(|samples| samples.len() != width * height) {
                return Err(fail(&format!("channels of {buffer} have fewer samples than pixels")));
            }
            let is_vector = samples.len() > 1 || buffer == "shadow";
            let shape = if is_vector { vec![height, width, samples.len()] } else { vec![height, width] };
            let array = Array::new(name, shape, values(&buffer, &samples))?;
            buffers.push((Some(format!("{prefix}{buffer}")), array));
        }
    }
    if buffers.is_empty() {
        return Err(fail(&"it has no channels"));
    }
    Ok((buffers, origin))
}

/// The buffer of a channel, and the channel's index in it.
fn component(channel: &str) -> (String, usize) {
    let letter = |last: &str| ["X", "Y", "Z"].iter().chain(&["R", "G", "B", "A"]).position(|known| *known == last);
    let place = |last: &str| letter(last).or_else(|| last.parse().ok());
    match channel {
        "R" => ("color".into(), 0),
        "G" => ("color".into(), 1),
        "B" => ("color".into(), 2),
        "A" => ("alpha".into(), 0),
        "Z" => ("depth".into(), 0),
        _ => match channel.rsplit_once('.').and_then(|(layer, last)| Some((layer, place(last)?))) {
            Some((layer, place)) => (layer.to_owned(), place),
            None => (channel.to_owned(), 0),
        },
    }
}

/// The samples pixel by pixel. Ids become signed: 4294967295, the id of a miss, is -1 in other formats.
fn values(buffer: &str, channels: &[&FlatSamples]) -> Values {
    let pixels = channels.first().map_or(0, |samples| samples.len());
    let whole: Option<Vec<&[u32]>> = channels
        .iter()
        .map(|samples| if let FlatSamples::U32(samples) = samples { Some(&samples[..]) } else { None })
        .collect();
    if let Some(whole) = whole {
        let all = (0..pixels).flat_map(|n| whole.iter().map(move |samples| samples[n]));
        return match buffer {
            "id" => Values::I32(all.map(|x| x as i32).collect()),
            _ => Values::I64(all.map(i64::from).collect()),
        };
    }
    let number = |samples: &FlatSamples, n: usize| match samples {
        FlatSamples::F16(samples) => samples[n].to_f32(),
        FlatSamples::F32(samples) => samples[n],
        FlatSamples::U32(samples) => samples[n] as f32,
    };
    Values::F32((0..pixels).flat_map(|n| channels.iter().map(move |samples| number(samples, n))).collect())
}
