//! The buffers that a frame can hold, by name.

use halfline_ground::error::named;
use std::fmt;

/// The most lights of a `shadow` buffer.
pub const MOST_LIGHTS: usize = 1 << 12;

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
    /// Index of the sphere in the scene's order, H,W i32, or i64 for more spheres than 32 bits can number; -1 on a miss.
    Id,
    /// 1 hit, 0 miss, H,W u8.
    Mask,
    /// 0 certified in f32, 1 settled, 255 not certified, H,W u8; a miss has a certainty like a hit.
    Certainty,
    /// Proven bound of the distance's error, H,W f64, scene units; 0 on a miss, +inf where nothing is proven.
    Bound,
    /// Coverage of the pixel: the share of its samples that hit, H,W f32; 0 on a miss.
    Alpha,
    /// Share of each light that is hidden at the hit, H,W,L f32 with L lights in their order: 0 lit, 1 in full shadow, for
    /// points and directions nothing between; 0 on a miss.
    Shadow,
    /// Share of the sky that is open at the hit, weighted by the cosine to the normal, H,W f32; 1 on a miss.
    Occlusion,
}

named! {
    Aov, "buffer",
    Color "color" Distance "distance" Depth "depth" Normal "normal" Position "position" Id "id" Mask "mask"
    Certainty "certainty" Bound "bound" Alpha "alpha" Shadow "shadow" Occlusion "occlusion"
}

impl Aov {
    /// Components per pixel in the frame of a scene with that many lights; only `shadow` depends on them.
    pub fn channels(self, lights: usize) -> usize {
        match self {
            Self::Color | Self::Normal | Self::Position => 3,
            Self::Shadow => lights,
            _ => 1,
        }
    }

    /// Whether its arrays have an axis of components, also where there is only one.
    pub fn is_vector(self) -> bool {
        matches!(self, Self::Color | Self::Normal | Self::Position | Self::Shadow)
    }

    /// The type of its values, as NumPy names it: `float32`, `float64`, `int32` or `uint8`.
    pub fn dtype(self) -> &'static str {
        match self {
            Self::Color | Self::Normal | Self::Alpha | Self::Shadow | Self::Occlusion => "float32",
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
