//! The frame: the result of a rendering, as plain buffers with shapes, units and a value on a miss, and its report.
//! `write/` makes files of it.

mod aov;
pub mod array;
mod buffer;
pub mod color_map;
pub mod coverage;
pub mod legend;
pub mod outline;
pub mod provenance;
pub mod report;
pub use halfline_ground::srgb;
pub mod tone;
mod trim;

use crate::window::Window;
use coverage::Coverage;
use report::Report;
use tone::Toning;

pub use aov::{Aov, MOST_LIGHTS};
pub use buffer::{Buffer, Data};

/// A rendered frame: its buffers and its report.
///
/// ```
/// use halfline::{Accuracy, Aov, Settings};
/// # use halfline::{Camera, ImagePlane, Scene, Spheres};
/// # let image = ImagePlane { width: 32, height: 32, ..Default::default() };
/// # let spheres = Spheres { centers: vec![[0.0, 0.0, -3.0]].into(), radii: vec![1.0].into(), ..Spheres::default() };
/// # let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
///
/// let settings = Settings { accuracy: Accuracy::Certified, aovs: vec![Aov::Distance], ..Settings::default() };
/// let frame = halfline::render(&scene, &settings)?;
/// let distances = frame.f64(Aov::Distance).expect("they were requested");
/// for (id, distance) in frame.ids().iter().zip(distances) {
///     assert_eq!(*id < 0, distance.is_infinite(), "a miss is -1 and +inf");
/// }
/// assert!(frame.report.warnings.is_empty());
/// # Ok::<(), halfline::Error>(())
/// ```
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
    /// The spheres of the samples of each pixel, if they were requested.
    pub coverage: Option<Coverage>,
    /// The report: device, method, times, warnings.
    pub report: Report,
}

impl Frame {
    /// The buffer, if it was requested.
    #[must_use]
    pub fn get(&self, aov: Aov) -> Option<&Buffer> {
        self.buffers.iter().find(|buffer| buffer.aov == aov)
    }

    /// The values of an f32 buffer (colour, normal, alpha, shadow, occlusion), if it was requested.
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

    /// Index of the sphere that each pixel shows, -1 on a miss; H x W, always present, but where ids are 64-bit: then the
    /// buffer has [`Data::I64`], and this is empty.
    #[must_use]
    pub fn ids(&self) -> &[i32] {
        match self.get(Aov::Id).map(|buffer| &buffer.data) {
            Some(Data::I32(ids)) => ids,
            _ => &[],
        }
    }

    /// Exposure and curve of its pictures in 8 and 16 bits.
    #[must_use]
    pub fn toning(&self) -> Toning {
        self.report.toning()
    }

    /// Red, green and blue of the picture in 8-bit sRGB with its tone, H x W x 3, if colour was requested.
    #[must_use]
    pub fn levels(&self) -> Option<Vec<u8>> {
        Some(srgb::levels(&self.toning().all(self.f32(Aov::Color)?)))
    }

    /// The same picture with alpha 255; with the feature `image`, which is on by default.
    #[cfg(feature = "image")]
    #[must_use]
    pub fn image(&self) -> Option<image::RgbaImage> {
        let bytes = self.levels()?.chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect();
        image::RgbaImage::from_raw(self.width, self.height, bytes)
    }
}
