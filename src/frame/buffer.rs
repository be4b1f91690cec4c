//! One buffer of a frame.

use super::aov::Aov;
use crate::error::{Error, Result};

/// The values of one buffer, row by row from the top, components innermost.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Data {
    /// Color, normal, alpha.
    F32(Vec<f32>),
    /// Distance, depth, position, bound.
    F64(Vec<f64>),
    /// Id.
    I32(Vec<i32>),
    /// Mask, certainty.
    U8(Vec<u8>),
}

impl Data {
    /// The number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::F64(values) => values.len(),
            Self::I32(values) => values.len(),
            Self::U8(values) => values.len(),
        }
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The type of the values, as NumPy names it.
    pub fn dtype(&self) -> &'static str {
        match self {
            Self::F32(_) => "float32",
            Self::F64(_) => "float64",
            Self::I32(_) => "int32",
            Self::U8(_) => "uint8",
        }
    }
}

/// One buffer of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Buffer {
    /// The buffer's name.
    pub aov: Aov,
    /// `[H, W]` or `[H, W, 3]`.
    pub shape: Vec<usize>,
    /// The values, in C order.
    pub data: Data,
}

impl Buffer {
    /// A buffer of `width` columns and `height` rows.
    ///
    /// # Errors
    /// See [`Buffer::check`].
    pub fn new(aov: Aov, width: usize, height: usize, data: Data) -> Result<Self> {
        let mut shape = vec![height, width];
        if aov.channels() > 1 {
            shape.push(aov.channels());
        }
        let buffer = Self { aov, shape, data };
        buffer.check().map(|()| buffer)
    }

    /// Checks shape, type and number of values against the buffer's name; writers call it first.
    ///
    /// # Errors
    /// [`Error::Settings`] with the found and the expected layout.
    pub fn check(&self) -> Result<()> {
        let (aov, channels) = (self.aov, self.aov.channels());
        let tail: &[usize] = if channels > 1 { &[channels] } else { &[] };
        // A product that overflows is larger than any buffer in memory.
        let values = self.shape.iter().try_fold(1usize, |n, side| n.checked_mul(*side));
        let shaped = self.shape.len() >= 2
            && (aov == Aov::Shadow || &self.shape[2..] == tail)
            && values == Some(self.data.len());
        if shaped && self.data.dtype() == aov.dtype() {
            return Ok(());
        }
        let (dtype, len) = (self.data.dtype(), self.data.len());
        let problem = format!("found {len} values of {dtype} in the shape {:?} for the {aov} buffer", self.shape);
        let axes = if channels > 1 { "[H, W, 3]" } else { "[H, W]" };
        Err(Error::settings(problem, format!("use {axes} of {}", aov.dtype())))
    }
}
