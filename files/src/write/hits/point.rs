//! A point of a cloud.

use halfline::frame::srgb;
use halfline::render::trace::echoes::Echo;

/// A hit or an echo, as it is kept until the cloud is written.
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Point {
    /// Origin + t direction, in f64.
    pub(super) position: [f64; 3],
    /// From the origin of the ray.
    pub(super) distance: f64,
    /// The index of the sphere.
    pub(super) id: i32,
    /// The ring and the column of the ray, or of rays that are not a scan their number from 0 and 0. The number of the
    /// return and the count of returns.
    pub(super) numbers: [u32; 4],
    /// The intensity of an echo, 0 to 1; 0 for hits.
    pub(super) intensity: f32,
}

/// The fields that a point has beside its position, distance, sphere and colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fields {
    /// The number of the ray.
    Ray,
    /// The ring and the column of the ray in its scan.
    Scan,
    /// The ring and the column of the beam, and the numbers and the intensity of the echo.
    Echo,
}

impl Point {
    /// A hit, the one return of its ray.
    pub(super) fn new(position: [f64; 3], distance: f64, id: i32, [ring, column]: [u32; 2]) -> Self {
        Self { position, distance, id, numbers: [ring, column, 1, 1], intensity: 0.0 }
    }

    /// The numbers of [`Fields::names`].
    pub(super) fn numbers(&self, fields: Fields) -> &[u32] {
        &self.numbers[..fields.names().len()]
    }

    /// The numbers of [`Fields::intensities`].
    pub(super) fn intensities(&self, fields: Fields) -> &[f32] {
        &std::slice::from_ref(&self.intensity)[..fields.intensities().len()]
    }
}

impl From<&Echo> for Point {
    fn from(echo: &Echo) -> Self {
        let numbers = [echo.ring, echo.column, echo.return_number.into(), echo.number_of_returns.into()];
        Self { position: echo.position, distance: echo.distance, id: echo.id, numbers, intensity: echo.intensity }
    }
}

impl Fields {
    /// The names of the whole numbers.
    pub(super) fn names(self) -> &'static [&'static str] {
        match self {
            Self::Ray => &["ray"],
            Self::Scan => &["ring", "column"],
            Self::Echo => &["ring", "column", "return_number", "number_of_returns"],
        }
    }

    /// The name of the intensity, if there is one.
    pub(super) fn intensities(self) -> &'static [&'static str] {
        if self == Self::Echo { &["intensity"] } else { &[] }
    }
}

/// 8-bit sRGB of linear RGB.
pub(super) fn levels(color: [f32; 3]) -> [u8; 3] {
    color.map(srgb::level)
}
