//! A point of a cloud.

use halfline::frame::srgb;

/// A hit, as it is kept until the cloud is written.
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Point {
    /// Origin + t direction, in f64.
    pub(super) position: [f64; 3],
    /// From the origin of the ray.
    pub(super) distance: f64,
    /// The index of the sphere.
    pub(super) id: i32,
    /// The ring and the column of the ray; of rays that are not a scan, their number from 0, and 0.
    pub(super) place: [u32; 2],
    unused: u32,
}

impl Point {
    pub(super) fn new(position: [f64; 3], distance: f64, id: i32, place: [u32; 2]) -> Self {
        Self { position, distance, id, place, unused: 0 }
    }

    /// The numbers of [`names`].
    pub(super) fn places(&self, is_scan: bool) -> &[u32] {
        &self.place[..names(is_scan).len()]
    }
}

/// The fields that say which ray it is.
pub(super) fn names(is_scan: bool) -> &'static [&'static str] {
    if is_scan { &["ring", "column"] } else { &["ray"] }
}

/// 8-bit sRGB of linear RGB.
pub(super) fn levels(color: [f32; 3]) -> [u8; 3] {
    color.map(srgb::level)
}
