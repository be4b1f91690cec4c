//! Points of formats 0 to 3 in LAZ: one coded sequence per chunk, a point after the other.

use super::arithmetic::{Decoder, Models, Source, Symbols};
use super::color::Colors;
use super::integer::{Integers, Median, axis_context};
use super::time::Times;
use crate::formats::las::format::PointFormat;
use halfline_ground::error::Result;

/// The decoder of a chunk's points behind the first.
pub(super) struct Sequential {
    last: Vec<u8>,
    base: Base,
    time: Option<(usize, Times)>,
    color: Option<(usize, Colors)>,
    /// The models of the bytes behind the fields of the format.
    extra: Models,
    fields: usize,
}

/// The first 20 bytes.
struct Base {
    changed: Symbols,
    x: Integers,
    y: Integers,
    z: Integers,
    intensity: Integers,
    source: Integers,
    /// By the last byte, and the angle by the direction.
    bits: Models,
    class: Models,
    angle: Models,
    user: Models,
    /// By the kind of return.
    intensities: [u16; 16],
    steps: [[Median; 2]; 16],
    /// By the number of returns between it and the last one.
    heights: [i32; 8],
}

/// The kind of a return, by the number of returns and its own number: from the table of the specification, which has the
/// combinations that are no returns too.
const KINDS: [[u8; 8]; 8] = [
    [15, 14, 13, 12, 11, 10, 9, 8],
    [14, 0, 1, 3, 6, 10, 10, 9],
    [13, 1, 2, 4, 7, 11, 11, 10],
    [12, 3, 4, 5, 8, 12, 12, 11],
    [11, 6, 7, 8, 9, 13, 13, 12],
    [10, 10, 11, 12, 13, 14, 14, 13],
    [9, 10, 11, 12, 13, 14, 15, 14],
    [8, 9, 10, 11, 12, 13, 14, 15],
];

impl Sequential {
    /// The decoder behind the first point of a chunk.
    pub(super) fn new(format: PointFormat, first: &[u8]) -> Self {
        let bytes = |at: usize| first[at..].first_chunk().map_or(0, |bytes| i64::from_le_bytes(*bytes));
        let mut last = first.to_vec();
        // The first intensity is not what the next is expected to be.
        last[12..14].fill(0);
        Self {
            last,
            base: Base::new(),
            time: format.gps_time.map(|at| (at, Times::new(bytes(at), true))),
            color: format.color.map(|at| (at, Colors::default())),
            extra: Models::new(first.len() - format.size, 256),
            fields: format.size,
        }
    }

    /// The next point.
    pub(super) fn next<S: Source>(&mut self, from: &mut Decoder<S>) -> Result<&[u8]> {
        if let Some(base) = self.last.first_chunk_mut() {
            self.base.next(from, base)?;
        }
        if let Some((at, times)) = &mut self.time {
            times.advance(from)?;
            self.last[*at..*at + 8].copy_from_slice(&times.time().to_le_bytes());
        }
        if let Some((at, colors)) = &mut self.color
            && let Some(last) = self.last[*at..].first_chunk_mut::<6>()
        {
            *last = colors.next(from, *last)?;
        }
        for (index, byte) in self.last[self.fields..].iter_mut().enumerate() {
            *byte = byte.wrapping_add(from.symbol(self.extra.at(index))? as u8);
        }
        Ok(&self.last)
    }
}

impl Base {
    fn new() -> Self {
        Self {
            changed: Symbols::new(64),
            x: Integers::new(32, 2),
            y: Integers::new(32, 22),
            z: Integers::new(32, 20),
            intensity: Integers::new(16, 4),
            source: Integers::new(16, 1),
            bits: Models::new(256, 256),
            class: Models::new(256, 256),
            angle: Models::new(2, 256),
            user: Models::new(256, 256),
            intensities: [0; 16],
            steps: Default::default(),
            heights: [0; 8],
        }
    }

    fn next<S: Source>(&mut self, from: &mut Decoder<S>, point: &mut [u8; 20]) -> Result<()> {
        let changed = from.symbol(&mut self.changed)?;
        let has = |bit: u32| changed >> bit & 1 == 1;
        if has(5) {
            point[14] = from.symbol(self.bits.at(point[14].into()))? as u8;
        }
        let (number, returns) = (point[14] & 7, point[14] >> 3 & 7);
        let kind = usize::from(KINDS[usize::from(returns)][usize::from(number)]);
        if changed != 0 {
            if has(4) {
                let intensity = self.intensity.next(from, self.intensities[kind].into(), kind.min(3))? as u16;
                self.intensities[kind] = intensity;
            }
            point[12..14].copy_from_slice(&self.intensities[kind].to_le_bytes());
        }
        if has(3) {
            point[15] = from.symbol(self.class.at(point[15].into()))? as u8;
        }
        if has(2) {
            let direction = usize::from(point[14] >> 6 & 1);
            point[16] = point[16].wrapping_add(from.symbol(self.angle.at(direction))? as u8);
        }
        if has(1) {
            point[17] = from.symbol(self.user.at(point[17].into()))? as u8;
        }
        if has(0) {
            let last = u16::from_le_bytes([point[18], point[19]]);
            let source = self.source.next(from, last.into(), 0)? as u16;
            point[18..20].copy_from_slice(&source.to_le_bytes());
        }
        let single = returns == 1;
        let [of_x, of_y] = &mut self.steps[kind];
        let step = self.x.next(from, of_x.get(), single.into())?;
        of_x.add(step);
        add(point, 0, step);
        let step = self.y.next(from, of_y.get(), axis_context(single, self.x.size(), 20))?;
        of_y.add(step);
        add(point, 4, step);
        let context = axis_context(single, u32::midpoint(self.x.size(), self.y.size()), 18);
        let height = &mut self.heights[usize::from(returns.abs_diff(number))];
        *height = self.z.next(from, *height, context)?;
        point[8..12].copy_from_slice(&height.to_le_bytes());
        Ok(())
    }
}

/// Adds to a coordinate.
fn add(point: &mut [u8; 20], at: usize, step: i32) {
    let last = point[at..].first_chunk().map_or(0, |bytes| i32::from_le_bytes(*bytes));
    point[at..at + 4].copy_from_slice(&last.wrapping_add(step).to_le_bytes());
}
