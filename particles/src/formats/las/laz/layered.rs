//! Points of formats 6 to 10 in LAZ: every chunk has a coded sequence (layer) for each field, empty where the field is the
//! same in the whole chunk, and for each byte behind the fields of the format. Waveforms are skipped.

use super::arithmetic::{Decoder, Models, Symbols};
use super::color::{Colors, Infrared};
use super::integer::{Integers, Median, axis_context};
use super::layer::Layer;
use super::time::Times;
use crate::formats::las::format::PointFormat;
use halfline_ground::error::Result;

/// The layers of the first 30 bytes, in the order of the file.
pub(super) const LAYERS: usize = 9;

const SHAPE: usize = 0;
const Z: usize = 1;
const CLASS: usize = 2;
const FLAGS: usize = 3;
const INTENSITY: usize = 4;
const ANGLE: usize = 5;
const USER: usize = 6;
const SOURCE: usize = 7;
const TIME: usize = 8;

/// The decoder of a chunk's points behind the first.
pub(super) struct Layered {
    layers: Vec<Option<Decoder<Layer>>>,
    /// The state of each channel of the scanner; `None` before its first point.
    channels: [Option<Box<Channel>>; 4],
    current: usize,
    color: Option<Shared<Colors, 6>>,
    infrared: Option<Shared<Infrared, 2>>,
    /// The bytes behind the fields of the format: of each the last one and the models, by channel.
    extra: Vec<Shared<Bytes, 1>>,
    /// Whether channels share their last colours as in version 3 of the compression.
    mixes: bool,
    point: Vec<u8>,
}

/// The state of a channel.
struct Channel {
    last: [u8; 30],
    /// Whether the time of its last point differed from the time of the point before.
    timed: bool,
    intensities: [u16; 8],
    steps: [[Median; 2]; 12],
    heights: [i32; 8],
    changed: Models,
    channel: Symbols,
    returns: Models,
    number: Models,
    number_same_time: Symbols,
    class: Models,
    flags: Models,
    user: Models,
    x: Integers,
    y: Integers,
    z: Integers,
    intensity: Integers,
    angle: Integers,
    source: Integers,
    times: Times,
}

/// The models of a byte.
struct Bytes(Models);

impl Default for Bytes {
    fn default() -> Self {
        Self(Models::new(1, 256))
    }
}

/// A field whose last value and models belong to a channel.
struct Shared<M, const N: usize> {
    at: usize,
    models: [Option<Box<M>>; 4],
    last: [[u8; N]; 4],
    current: usize,
}

impl<M: Default, const N: usize> Shared<M, N> {
    fn new(at: usize, first: &[u8], channel: usize) -> Self {
        let mut last = [[0; N]; 4];
        last[channel] = first[at..].first_chunk().copied().unwrap_or([0; N]);
        let mut shared = Self { at, models: [const { None }; 4], last, current: channel };
        shared.models[channel] = Some(Box::default());
        shared
    }

    /// The models of a channel, and the last value. In version 3 a channel that was known before continues the value of
    /// the channel before, which is a mistake that files have.
    fn of(&mut self, channel: usize, mixes: bool) -> (&mut M, &mut [u8; N]) {
        let (before, is_known) = (self.current, self.models[channel].is_some());
        self.current = channel;
        if !is_known {
            self.last[channel] = self.last[before];
        }
        let last = if mixes && is_known { before } else { channel };
        (self.models[channel].get_or_insert_default(), &mut self.last[last])
    }
}

/// The kind of a return, by the number of returns and its own number: from the table of the specification.
const KINDS: [[u8; 16]; 16] = [
    [0, 1, 2, 3, 4, 5, 3, 4, 4, 5, 5, 5, 5, 5, 5, 5],
    [1, 0, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3],
    [2, 1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3],
    [3, 3, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [3, 3, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5],
];

impl Layered {
    /// The decoder behind the first point of a chunk, with its layers.
    pub(super) fn new(format: PointFormat, first: &[u8], layers: Vec<Option<Decoder<Layer>>>, mixes: bool) -> Self {
        let current = usize::from(first[15] >> 4 & 3);
        let mut channels = [const { None }; 4];
        channels[current] = first.first_chunk().map(|first| Box::new(Channel::new(*first)));
        let fields = LAYERS + usize::from(format.color.is_some()) + usize::from(format.infrared.is_some());
        let extra = (format.size..first.len()).take(layers.len() - fields).map(|at| Shared::new(at, first, current));
        Self {
            extra: extra.collect(),
            layers,
            channels,
            current,
            color: format.color.map(|at| Shared::new(at, first, current)),
            infrared: format.infrared.map(|at| Shared::new(at, first, current)),
            mixes,
            point: first.to_vec(),
        }
    }

    /// The next point.
    pub(super) fn next(&mut self) -> Result<&[u8]> {
        let Self { layers, channels, current, point, .. } = self;
        let changed = Channel::changed(channels[*current].as_deref_mut(), &mut layers[SHAPE])?;
        let switches = changed >> 6 & 1 == 1;
        if switches && let (Some(channel), Some(shape)) = (&mut channels[*current], &mut layers[SHAPE]) {
            let next = (*current + shape.symbol(&mut channel.channel)? as usize + 1) & 3;
            let last = channel.last;
            channels[next].get_or_insert_with(|| Box::new(Channel::new(last)));
            *current = next;
        }
        if let Some(channel) = &mut channels[*current] {
            channel.last[15] = channel.last[15] & !0x30 | (*current as u8) << 4;
            channel.next(layers, changed)?;
            point[..30].copy_from_slice(&channel.last);
        }
        let channel = if self.mixes && !switches { 0 } else { *current };
        if let Some(color) = &mut self.color {
            let at = color.at;
            let (models, last) = color.of(channel, self.mixes);
            if let Some(layer) = &mut layers[LAYERS] {
                *last = models.next(layer, *last)?;
            }
            point[at..at + 6].copy_from_slice(last);
        }
        if let Some(infrared) = &mut self.infrared {
            let at = infrared.at;
            let (models, last) = infrared.of(channel, self.mixes);
            if let Some(layer) = &mut layers[LAYERS + 1] {
                *last = models.next(layer, *last)?;
            }
            point[at..at + 2].copy_from_slice(last);
        }
        let fields = layers.len() - self.extra.len();
        for (byte, layer) in self.extra.iter_mut().zip(&mut layers[fields..]) {
            let at = byte.at;
            let (models, last) = byte.of(channel, self.mixes);
            if let Some(layer) = layer {
                *last = [last[0].wrapping_add(layer.symbol(models.0.at(0))? as u8)];
            }
            point[at] = last[0];
        }
        Ok(&self.point)
    }
}

impl Channel {
    fn new(last: [u8; 30]) -> Self {
        let height = last.first_chunk::<12>().map_or(0, |bytes| i32_at(bytes, 8));
        let time = last[22..].first_chunk().map_or(0, |bytes| i64::from_le_bytes(*bytes));
        Self {
            last,
            timed: false,
            intensities: [u16::from_le_bytes([last[12], last[13]]); 8],
            steps: Default::default(),
            heights: [height; 8],
            changed: Models::new(8, 128),
            channel: Symbols::new(3),
            returns: Models::new(16, 16),
            number: Models::new(16, 16),
            number_same_time: Symbols::new(13),
            class: Models::new(64, 256),
            flags: Models::new(64, 64),
            user: Models::new(64, 256),
            x: Integers::new(32, 2),
            y: Integers::new(32, 22),
            z: Integers::new(32, 20),
            intensity: Integers::new(16, 4),
            angle: Integers::new(16, 2),
            source: Integers::new(16, 1),
            times: Times::new(time, false),
        }
    }

    /// Reads the flags of the fields that differ from the last point; 0 without their layer, which every chunk of more
    /// than one point has.
    fn changed(channel: Option<&mut Self>, shape: &mut Option<Decoder<Layer>>) -> Result<u32> {
        let (Some(channel), Some(shape)) = (channel, shape) else { return Ok(0) };
        let (number, returns) = (channel.last[14] & 15, channel.last[14] >> 4);
        let context = usize::from(number == 1) + 2 * usize::from(number >= returns) + 4 * usize::from(channel.timed);
        shape.symbol(channel.changed.at(context))
    }

    fn next(&mut self, layers: &mut [Option<Decoder<Layer>>], changed: u32) -> Result<()> {
        let has = |bit: u32| changed >> bit & 1 == 1;
        let (timed, point) = (has(4), &mut self.last);
        let (mut number, mut returns) = (point[14] & 15, point[14] >> 4);
        let Some(shape) = &mut layers[SHAPE] else { return Ok(()) };
        if has(2) {
            returns = shape.symbol(self.returns.at(returns.into()))? as u8;
        }
        number = match changed & 3 {
            0 => number,
            1 => (number + 1) & 15,
            2 => (number + 15) & 15,
            _ if timed => shape.symbol(self.number.at(number.into()))? as u8,
            _ => (number + shape.symbol(&mut self.number_same_time)? as u8 + 2) & 15,
        };
        point[14] = returns << 4 | number;
        let kind = usize::from(KINDS[usize::from(returns)][usize::from(number)]);
        let [of_x, of_y] = &mut self.steps[2 * kind + usize::from(timed)];
        let single = returns == 1;
        let step = self.x.next(shape, of_x.get(), single.into())?;
        of_x.add(step);
        put(point, 0, i32_at(point, 0).wrapping_add(step));
        let step = self.y.next(shape, of_y.get(), axis_context(single, self.x.size(), 20))?;
        of_y.add(step);
        put(point, 4, i32_at(point, 4).wrapping_add(step));
        if let Some(layer) = &mut layers[Z] {
            let context = axis_context(single, u32::midpoint(self.x.size(), self.y.size()), 18);
            let height = &mut self.heights[usize::from(returns.abs_diff(number).min(7))];
            *height = self.z.next(layer, *height, context)?;
            put(point, 8, *height);
        }
        let (first, last) = (number == 1, number >= returns);
        if let Some(layer) = &mut layers[CLASS] {
            let context = usize::from(point[16] & 31) << 1 | usize::from(first && last);
            point[16] = layer.symbol(self.class.at(context))? as u8;
        }
        if let Some(layer) = &mut layers[FLAGS] {
            // In a code the bits of direction and edge follow the bits of the flags; in a point the channel is between them.
            let context = point[15] >> 2 & 0x30 | point[15] & 15;
            let flags = layer.symbol(self.flags.at(context.into()))? as u8;
            point[15] = (flags & 0x30) << 2 | point[15] & 0x30 | flags & 15;
        }
        let kind = 2 * usize::from(first) + usize::from(last);
        if let Some(layer) = &mut layers[INTENSITY] {
            let intensity = &mut self.intensities[2 * kind + usize::from(timed)];
            *intensity = self.intensity.next(layer, (*intensity).into(), kind)? as u16;
            point[12..14].copy_from_slice(&intensity.to_le_bytes());
        }
        if let Some(layer) = &mut layers[ANGLE]
            && has(3)
        {
            let angle = i16::from_le_bytes([point[18], point[19]]);
            let angle = self.angle.next(layer, angle.into(), timed.into())? as i16;
            point[18..20].copy_from_slice(&angle.to_le_bytes());
        }
        if let Some(layer) = &mut layers[USER] {
            point[17] = layer.symbol(self.user.at(usize::from(point[17] / 4)))? as u8;
        }
        if let Some(layer) = &mut layers[SOURCE]
            && has(5)
        {
            let source = u16::from_le_bytes([point[20], point[21]]);
            let source = self.source.next(layer, source.into(), 0)? as u16;
            point[20..22].copy_from_slice(&source.to_le_bytes());
        }
        self.timed = timed;
        if let Some(layer) = &mut layers[TIME]
            && timed
        {
            self.times.advance(layer)?;
            point[22..30].copy_from_slice(&self.times.time().to_le_bytes());
        }
        Ok(())
    }
}

fn i32_at(point: &[u8], at: usize) -> i32 {
    point[at..].first_chunk().map_or(0, |bytes| i32::from_le_bytes(*bytes))
}

fn put(point: &mut [u8; 30], at: usize, number: i32) {
    point[at..at + 4].copy_from_slice(&number.to_le_bytes());
}
