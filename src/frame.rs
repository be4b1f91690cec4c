//! The frame: the result of a rendering, as plain buffers with shapes, units and a value on a miss. The modules below
//! write them to files.

pub mod array;
mod atomic;
mod digest;
mod encode;
mod exr;
pub mod file;
pub mod format;
pub mod image_file;
pub mod merge;
pub mod npy;
mod npz;
mod pfm;
mod plain;
pub mod png;
pub mod provenance;
pub mod srgb;

use crate::error::{Error, Result};
use crate::window::Window;
use std::fmt;
use std::str::FromStr;

/// The buffers a frame can hold (arbitrary output variables), by the names of the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Aov {
    /// Shaded colour, H,W,3 f32, linear RGB; the background on a miss.
    Color,
    /// Euclidean length from the ray's origin to the hit, H,W f64, scene units; +inf on a miss.
    Distance,
    /// Distance along the view axis (planar z), H,W f64, scene units; +inf on a miss.
    Depth,
    /// Unit normal in world space, against the ray, H,W,3 f32; 0,0,0 on a miss.
    Normal,
    /// Hit point in world space, H,W,3 f64, scene units; NaN on a miss.
    Position,
    /// Index of the sphere in the scene's order, H,W i32; -1 on a miss.
    Id,
    /// 1 hit, 0 miss, H,W u8.
    Mask,
    /// 0 certified in f32, 1 settled, 255 not certified, H,W u8; a miss has a certainty like a hit.
    Certainty,
    /// Proven bound of the distance's error, H,W f64, scene units; 0 on a miss, +inf where nothing is proven.
    Bound,
    /// Coverage of the pixel: the share of its samples that hit, H,W f32; 0 on a miss.
    Alpha,
}

impl Aov {
    /// Every buffer, in the order of the documentation.
    pub const ALL: [Self; 10] = [
        Self::Color,
        Self::Distance,
        Self::Depth,
        Self::Normal,
        Self::Position,
        Self::Id,
        Self::Mask,
        Self::Certainty,
        Self::Bound,
        Self::Alpha,
    ];

    /// The name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Color => "color",
            Self::Distance => "distance",
            Self::Depth => "depth",
            Self::Normal => "normal",
            Self::Position => "position",
            Self::Id => "id",
            Self::Mask => "mask",
            Self::Certainty => "certainty",
            Self::Bound => "bound",
            Self::Alpha => "alpha",
        }
    }

    /// Components per pixel.
    pub fn channels(self) -> usize {
        match self {
            Self::Color | Self::Normal | Self::Position => 3,
            _ => 1,
        }
    }

    /// The type of its values, as NumPy names it: `float32`, `float64`, `int32` or `uint8`.
    pub fn dtype(self) -> &'static str {
        match self {
            Self::Color | Self::Normal | Self::Alpha => "float32",
            Self::Distance | Self::Depth | Self::Position | Self::Bound => "float64",
            Self::Id => "int32",
            Self::Mask | Self::Certainty => "uint8",
        }
    }
}

impl fmt::Display for Aov {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Aov {
    type Err = Error;

    /// The buffer with this name; [`Error::Settings`] lists the names.
    fn from_str(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|aov| aov.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            Error::settings(format!("there is no buffer named {name:?}"), format!("choose from {names}"))
        })
    }
}

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

/// A rendered frame: its buffers and its report.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Columns of the window.
    pub width: u32,
    /// Rows of the window.
    pub height: u32,
    /// The window of the full frame that the buffers hold.
    pub window: Window,
    /// W and H of the full frame, pixels.
    pub full: [u32; 2],
    /// The requested buffers and the ids, in the order of [`Aov::ALL`].
    pub buffers: Vec<Buffer>,
    /// The report: device, method, times, warnings.
    pub report: crate::report::Report,
}

impl Frame {
    /// The buffer, if it was requested.
    #[must_use]
    pub fn get(&self, aov: Aov) -> Option<&Buffer> {
        self.buffers.iter().find(|buffer| buffer.aov == aov)
    }

    /// The values of an f32 buffer (colour, normal, alpha), if it was requested.
    #[must_use]
    pub fn f32(&self, aov: Aov) -> Option<&[f32]> {
        match &self.get(aov)?.data {
            Data::F32(values) => Some(values),
            _ => None,
        }
    }

    /// The values of an f64 buffer (distance, depth, position, bound), if it was requested.
    #[must_use]
    pub fn f64(&self, aov: Aov) -> Option<&[f64]> {
        match &self.get(aov)?.data {
            Data::F64(values) => Some(values),
            _ => None,
        }
    }

    /// Index of the sphere that each pixel shows, -1 on a miss; H x W, always present.
    #[must_use]
    pub fn ids(&self) -> &[i32] {
        match self.get(Aov::Id).map(|buffer| &buffer.data) {
            Some(Data::I32(ids)) => ids,
            _ => &[],
        }
    }

    /// The picture in 8-bit sRGB, alpha 255, if colour was requested.
    #[must_use]
    pub fn image(&self) -> Option<image::RgbaImage> {
        let bytes: Vec<u8> = self
            .f32(Aov::Color)?
            .chunks_exact(3)
            .flat_map(|c| [srgb::level(c[0]), srgb::level(c[1]), srgb::level(c[2]), 255])
            .collect();
        image::RgbaImage::from_raw(self.width, self.height, bytes)
    }
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
        let shaped = self.shape.len() >= 2 && &self.shape[2..] == tail && values == Some(self.data.len());
        if shaped && self.data.dtype() == aov.dtype() {
            return Ok(());
        }
        let (dtype, len) = (self.data.dtype(), self.data.len());
        let problem = format!("found {len} values of {dtype} in the shape {:?} for the {aov} buffer", self.shape);
        let axes = if channels > 1 { "[H, W, 3]" } else { "[H, W]" };
        Err(Error::settings(problem, format!("use {axes} of {}", aov.dtype())))
    }
}
