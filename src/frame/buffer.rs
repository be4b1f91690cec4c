//! One buffer of a frame.

use super::aov::{Aov, MOST_LIGHTS};
use halfline_ground::error::{Error, Result};

/// The values of one buffer, row by row from the top, components innermost.
#[derive(Debug, Clone, PartialEq)]
pub enum Data {
    /// Color, normal, alpha, shadow, occlusion.
    F32(Vec<f32>),
    /// Distance, depth, position, bound.
    F64(Vec<f64>),
    /// Id.
    I32(Vec<i32>),
    /// Id where there are more spheres than 32 bits can number.
    I64(Vec<i64>),
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
            Self::I64(values) => values.len(),
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
            Self::I64(_) => "int64",
            Self::U8(_) => "uint8",
        }
    }
}

/// One buffer of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Buffer {
    /// The buffer's name.
    pub aov: Aov,
    /// `[H, W]`, `[H, W, 3]`, or `[H, W, L]` for the shadows of L lights.
    pub shape: Vec<usize>,
    /// The values, in C order.
    pub data: Data,
}

impl Buffer {
    /// A buffer of `width` columns and `height` rows. The number of values gives the number of lights of a `shadow` buffer.
    ///
    /// # Errors
    /// See [`Buffer::check`].
    pub fn new(aov: Aov, width: usize, height: usize, data: Data) -> Result<Self> {
        let mut shape = vec![height, width];
        if aov.is_vector() {
            let pixels = width.saturating_mul(height).max(1);
            shape.push(aov.channels(data.len() / pixels));
        }
        let buffer = Self { aov, shape, data };
        buffer.check().map(|()| buffer)
    }

    /// Components per pixel.
    pub fn channels(&self) -> usize {
        self.shape.get(2).copied().unwrap_or(1)
    }

    /// Whether its values are 64-bit integers.
    pub fn is_wide(&self) -> bool {
        matches!(self.data, Data::I64(_))
    }

    /// Checks shape, type and number of values against the buffer's name; writers call it first.
    ///
    /// # Errors
    /// [`Error::Settings`] with the found and the expected layout.
    pub fn check(&self) -> Result<()> {
        let aov = self.aov;
        let channels = aov.channels(self.channels());
        let tail: &[usize] = if aov.is_vector() { &[channels] } else { &[] };
        // A product that overflows is larger than any buffer in memory.
        let values = self.shape.iter().try_fold(1usize, |n, side| n.checked_mul(*side));
        let counted = (1..=MOST_LIGHTS).contains(&channels) && values == Some(self.data.len());
        let shaped = counted && self.shape.get(2..) == Some(tail);
        if shaped && (aov == Aov::Id && self.is_wide() || self.data.dtype() == aov.dtype()) {
            return Ok(());
        }
        let (dtype, len) = (self.data.dtype(), self.data.len());
        let problem = format!("found {len} values of {dtype} in the shape {:?} for the {aov} buffer", self.shape);
        let axes = match aov {
            Aov::Shadow => "[H, W, L], with L lights,",
            _ if aov.is_vector() => "[H, W, 3]",
            _ => "[H, W]",
        };
        Err(Error::settings(problem, format!("use {axes} of {}", aov.dtype())))
    }
}
