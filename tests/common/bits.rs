//! Frames as bits.

use halfline::frame::{Aov, Data, Frame};
use halfline::window::Window;

/// The values of a frame's buffers as bits: NaN equals itself, and 0.0 differs from -0.0.
pub(crate) trait Bits {
    /// All values of one buffer, which the frame must have.
    fn bits(&self, aov: Aov) -> Vec<u64>;

    /// The values inside a window of a full frame.
    fn bits_in(&self, window: Window, aov: Aov) -> Vec<u64>;
}

impl Bits for Frame {
    fn bits(&self, aov: Aov) -> Vec<u64> {
        match &self.get(aov).expect("a requested buffer").data {
            Data::F32(v) => v.iter().map(|x| u64::from(x.to_bits())).collect(),
            Data::F64(v) => v.iter().map(|x| x.to_bits()).collect(),
            Data::I32(v) => v.iter().map(|x| *x as u64).collect(),
            Data::U8(v) => v.iter().map(|x| u64::from(*x)).collect(),
            _ => panic!("a new type of data"),
        }
    }

    fn bits_in(&self, window: Window, aov: Aov) -> Vec<u64> {
        let (width, channels) = (self.width as usize, self.get(aov).expect("a requested buffer").channels());
        let columns = channels * window.x0 as usize..channels * window.x1 as usize;
        let bits = self.bits(aov);
        let rows = bits.chunks_exact(channels * width).take(window.y1 as usize).skip(window.y0 as usize);
        rows.flat_map(|row| &row[columns.clone()]).copied().collect()
    }
}

/// The buffers in which two frames differ.
pub(crate) fn differing(a: &Frame, b: &Frame) -> Vec<Aov> {
    Aov::ALL.into_iter().filter(|aov| a.get(*aov).is_some() && a.bits(*aov) != b.bits(*aov)).collect()
}
