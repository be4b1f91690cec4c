//! The format of a buffer's samples in a file.

use halfline::frame::Aov;

/// The type of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SampleType {
    /// A level of 0 to 255, or a byte.
    U8,
    /// A level of 0 to 65535.
    U16,
    /// A 32-bit unsigned integer.
    U32,
    /// A 32-bit integer.
    I32,
    /// A 64-bit integer.
    I64,
    /// A 32-bit float.
    F32,
    /// A 64-bit float.
    F64,
}

impl SampleType {
    /// Bytes per sample.
    pub fn size(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::I64 | Self::F64 => 8,
        }
    }
}

/// The format of a buffer in a file: the type of its samples, and their number per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LayerFormat {
    /// The buffer. Colour with four channels has alpha as the last.
    pub aov: Aov,
    /// The type of its samples.
    pub kind: SampleType,
    /// Samples per pixel.
    pub channels: usize,
}

impl LayerFormat {
    /// Whether the last of its channels is alpha. Other buffers have as many channels as there are lights.
    pub(super) fn has_alpha(&self) -> bool {
        self.aov == Aov::Color && self.channels == 4
    }

    /// Bytes per pixel.
    pub fn pixel(&self) -> usize {
        self.kind.size() * self.channels
    }
}
