//! LAS 1.4 in point format 7, which has 16-bit colours (ASPRS, LAS Specification 1.4 R15). A coordinate is a whole number of
//! 32 bits times a scale plus an offset. What else a hit has is in extra bytes, which a record of the header names.

use super::point::{Fields, Point};
use halfline::frame::srgb::level16;

/// The scale, the offset and the bounds of the coordinates.
pub(super) struct LasGrid {
    scale: [f64; 3],
    offset: [f64; 3],
    bounds: [[f64; 3]; 2],
}

/// Bytes of the header, of the head of a record behind it, and of the description of an extra field.
const HEADER: usize = 375;
const RECORD: usize = 54;
const EXTRA: usize = 192;

/// Bytes of a point of format 7 without extra ones.
const POINT: usize = 36;

/// The most returns of a ray.
pub(super) const RETURNS: usize = 15;

/// The numbers of a point that are extra fields: the others, of returns, are in the format.
const PLACES: usize = 2;

/// The types of extra fields: 32 bits without and with a sign, f64.
const U32: u8 = 5;
const I32: u8 = 6;
const F64: u8 = 10;

impl LasGrid {
    /// The finest grid for coordinates between these bounds: per axis at most 2^31 steps of a power of two, which is at
    /// least the last bit of the largest coordinate. So whole number times scale plus offset is exact in f64, and the error
    /// of a coordinate is at most half a step, 2^-31 of the longest side. `None` where a side or a grid point is beyond f64.
    pub(super) fn of([low, high]: [[f64; 3]; 2]) -> Option<Self> {
        let mut grid = Self { scale: [1.0; 3], offset: [0.0; 3], bounds: [[0.0; 3]; 2] };
        for (axis, (low, high)) in low.into_iter().zip(high).enumerate() {
            if low > high {
                // There are no points.
                continue;
            }
            let (side, largest) = (high - low, low.abs().max(high.abs()));
            if !side.is_finite() {
                return None;
            }
            if largest > 0.0 {
                grid.scale[axis] = power(exponent(side) - 30).max(power(exponent(largest) - 52));
            }
            grid.offset[axis] = ((low / 2.0 + high / 2.0) / grid.scale[axis]).round() * grid.scale[axis];
            let [least, most] = [low, high].map(|x| grid.place(axis, grid.number(axis, x)));
            (grid.bounds[0][axis], grid.bounds[1][axis]) = (least, most);
        }
        // At the end of f64 a grid point may be beyond it.
        grid.bounds.iter().flatten().all(|x| x.is_finite()).then_some(grid)
    }

    /// The whole number of a coordinate; the cast saturates, but the grid has room.
    fn number(&self, axis: usize, x: f64) -> i32 {
        ((x - self.offset[axis]) / self.scale[axis]).round() as i32
    }

    /// The coordinate of a whole number.
    fn place(&self, axis: usize, number: i32) -> f64 {
        f64::from(number) * self.scale[axis] + self.offset[axis]
    }

    /// The header and the description of the extra bytes. Equal points give equal bytes, so there is no date.
    pub(super) fn header(&self, returns: &[u64; RETURNS], fields: Fields) -> Vec<u8> {
        let extra = extra(fields);
        let start = HEADER + RECORD + EXTRA * extra.len();
        let size = POINT + extra.iter().map(|(_, kind, _)| if *kind == F64 { 8 } else { 4 }).sum::<usize>();
        let mut out = vec![0; start];
        let mut put = |at: usize, bytes: &[u8]| out[at..at + bytes.len()].copy_from_slice(bytes);
        put(0, b"LASF");
        // A coordinate system would be described as in WKT, as formats from 6 on require.
        put(6, &16u16.to_le_bytes());
        put(24, &[1, 4]);
        put(26, b"halfline trace");
        put(58, concat!("halfline ", env!("CARGO_PKG_VERSION")).as_bytes());
        put(94, &(HEADER as u16).to_le_bytes());
        put(96, &(start as u32).to_le_bytes());
        put(100, &1u32.to_le_bytes());
        put(104, &[7]);
        put(105, &(size as u16).to_le_bytes());
        for axis in 0..3 {
            put(131 + 8 * axis, &self.scale[axis].to_le_bytes());
            put(155 + 8 * axis, &self.offset[axis].to_le_bytes());
            put(179 + 16 * axis, &self.bounds[1][axis].to_le_bytes());
            put(187 + 16 * axis, &self.bounds[0][axis].to_le_bytes());
        }
        put(247, &returns.iter().sum::<u64>().to_le_bytes());
        for (n, count) in returns.iter().enumerate() {
            put(255 + 8 * n, &count.to_le_bytes());
        }
        put(HEADER + 2, b"LASF_Spec");
        put(HEADER + 18, &4u16.to_le_bytes());
        put(HEADER + 20, &((EXTRA * extra.len()) as u16).to_le_bytes());
        for (n, (name, kind, about)) in extra.into_iter().enumerate() {
            let at = HEADER + RECORD + EXTRA * n;
            put(at + 2, &[kind]);
            put(at + 4, name.as_bytes());
            put(at + 160, about.as_bytes());
        }
        out
    }

    /// Adds a point; returns the coordinates that it has.
    pub(super) fn point(&self, point: &Point, color: [f32; 3], fields: Fields, out: &mut Vec<u8>) -> [f64; 3] {
        let numbers = [0, 1, 2].map(|axis| self.number(axis, point.position[axis]));
        numbers.iter().for_each(|number| out.extend(number.to_le_bytes()));
        out.extend(((f64::from(point.intensity) * f64::from(u16::MAX)).round() as u16).to_le_bytes());
        let [.., number, count] = point.numbers;
        // No class, angle, source and time.
        out.extend([(number | count << 4) as u8, 0, 0, 0, 0, 0, 0, 0]);
        out.extend([0; 8]);
        color.iter().for_each(|component| out.extend(level16(*component).to_le_bytes()));
        out.extend(point.distance.to_le_bytes());
        out.extend(point.id.to_le_bytes());
        point.numbers(fields).iter().take(PLACES).for_each(|n| out.extend(n.to_le_bytes()));
        [0, 1, 2].map(|axis| self.place(axis, numbers[axis]))
    }
}

/// The extra fields of a point: name, type and description.
fn extra(fields: Fields) -> Vec<(&'static str, u8, &'static str)> {
    let hit = [("distance", F64, "from the origin of the ray"), ("id", I32, "index of the sphere")];
    let places = fields.names().iter().take(PLACES).map(|name| (*name, U32, "of the ray, from 0"));
    hit.into_iter().chain(places).collect()
}

/// The exponent of a finite number: 2^exponent is at most its absolute value, and more than half of it. Below the normal
/// numbers it is the exponent of the least normal one.
fn exponent(x: f64) -> i32 {
    ((x.to_bits() >> 52 & 0x7ff) as i32 - 1023).max(-1022)
}

/// 2^n, or the least normal power of two.
fn power(n: i32) -> f64 {
    f64::from_bits(((n.max(-1022) + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The finest grid is exact in f64, and moves a coordinate by at most half a step.
    #[test]
    fn a_grid_has_room_and_its_error_is_half_a_step() {
        let cases = [
            [0.0, 0.0],
            [12.3, 12.3],
            [-3.7, 1e3],
            [1e9, 1e9 + 1e-3],
            [-1e300, 1e300],
            [-1e-310, 3e-310],
            [-1.0, 1.0],
            [4_194_304.0, 4_194_304.5],
            [0.0, 1e308],
        ];
        for [low, high] in cases {
            let grid = LasGrid::of([[low; 3], [high; 3]]).expect("finite sides");
            let (scale, side) = (grid.scale[0], high - low);
            let largest = low.abs().max(high.abs());
            let last_bit = 2.0 * (largest - largest.next_down());
            let finest = (side * 2f64.powi(-30)).max(last_bit).max(f64::MIN_POSITIVE);
            assert!(scale <= finest || largest == 0.0, "{low} {high}: {scale}");
            for k in 0..=1000 {
                let x = low + side * (f64::from(k) / 1000.0);
                let number = grid.number(0, x);
                assert!(number.unsigned_abs() <= 1 << 30, "{low} {high}: {number}");
                let written = grid.place(0, number);
                // x - offset is rounded by 2^-53 of itself, which is at most 2^30 steps: 2^-23 of a step.
                assert!((written - x).abs() <= scale * 0.500001, "{x} becomes {written}, scale {scale}");
            }
        }
        assert!(LasGrid::of([[f64::MIN; 3], [f64::MAX; 3]]).is_none());
        assert!(LasGrid::of([[0.0; 3], [f64::MAX; 3]]).is_none());
        assert!(LasGrid::of([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]).is_some(), "no points");
    }
}
