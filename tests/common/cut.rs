//! Windows of frames, as bits.

use super::bits::Bits;
use halfline::frame::{Aov, Frame};
use halfline::window::Window;

/// The bits of a window of one buffer of a full frame.
pub(crate) fn cut(full: &Frame, aov: Aov, window: Window) -> Vec<u64> {
    let (width, channels) = (full.width as usize, aov.channels());
    let columns = channels * window.x0 as usize..channels * window.x1 as usize;
    let bits = full.bits(aov);
    let rows = bits.chunks_exact(channels * width).take(window.y1 as usize).skip(window.y0 as usize);
    rows.flat_map(|row| &row[columns.clone()]).copied().collect()
}
