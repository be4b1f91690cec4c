//! Frames as bits.

use halfline::frame::{Aov, Data, Frame};

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
