//! Frames as bits, and windows of them.

use halfline::frame::{Aov, Data, Frame};
use halfline::window::Window;

/// The values of a frame's buffers as bits: NaN is equal to itself, and zeros tell their signs.
pub(crate) trait Bits {
    /// Of one buffer that was asked for.
    fn bits(&self, aov: Aov) -> Vec<u64>;
}

impl Bits for Frame {
    fn bits(&self, aov: Aov) -> Vec<u64> {
        match &self.get(aov).expect("asked for").data {
            Data::F32(v) => v.iter().map(|x| u64::from(x.to_bits())).collect(),
            Data::F64(v) => v.iter().map(|x| x.to_bits()).collect(),
            Data::I32(v) => v.iter().map(|x| *x as u64).collect(),
            Data::U8(v) => v.iter().map(|x| u64::from(*x)).collect(),
            _ => panic!("a new type of data"),
        }
    }
}

/// The bits of a window of one buffer of a full frame.
pub(crate) fn cut(full: &Frame, aov: Aov, window: Window) -> Vec<u64> {
    let (width, channels) = (full.width as usize, aov.channels());
    let columns = channels * window.x0 as usize..channels * window.x1 as usize;
    let bits = full.bits(aov);
    let rows = bits.chunks_exact(channels * width).take(window.y1 as usize).skip(window.y0 as usize);
    rows.flat_map(|row| &row[columns.clone()]).copied().collect()
}
