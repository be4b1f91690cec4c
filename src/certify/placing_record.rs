//! The uniform from which devices place spheres.

use bytemuck::{Pod, Zeroable};

/// A number of f64 as shaders/place/float64.wgsl takes it: significand (low and high word), exponent, sign.
pub(crate) type Words = [u32; 4];

pub(super) fn words(x: f64) -> Words {
    let bits = x.to_bits();
    let (exponent, significand) = ((bits >> 52) as i32 & 0x7ff, (bits << 11) | 1 << 63);
    match exponent {
        0 => [0, 0, -100_000i32 as u32, 0],
        _ => [significand as u32, (significand >> 32) as u32, (exponent - 1086) as u32, (bits >> 63) as u32],
    }
}

/// The uniform of the steps that place spheres, declared in shaders/place/placing.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct PlacingRecord {
    pub(crate) eye: [Words; 3],
    pub(crate) axes: [[Words; 3]; 3],
    pub(crate) per_slope: [Words; 2],
    pub(crate) middle: [Words; 2],
    pub(crate) reference: Words,
    pub(crate) low_blurred: [f32; 3],
    pub(crate) low_center: f32,
    pub(crate) low_offset: [f32; 3],
    pub(crate) low_coordinates: f32,
    pub(crate) low_total: [f32; 2],
    pub(crate) low_scale: [f32; 2],
    pub(crate) per_step: [f32; 2],
    pub(crate) slope: [f32; 2],
    pub(crate) edge: [f32; 2],
    pub(crate) reach: [f32; 2],
    pub(crate) per_slope_f32: [f32; 2],
    pub(crate) middle_f32: [f32; 2],
    pub(crate) corner: [f32; 2],
    pub(crate) end: [f32; 2],
    pub(crate) rotated: f32,
    pub(crate) wider: f32,
    pub(crate) farthest: f32,
    pub(crate) per_unit: i32,
    pub(crate) to_frame: i32,
    pub(crate) shift: u32,
    pub(crate) fine: u32,
    pub(crate) parallel: u32,
    pub(crate) columns: u32,
    pub(crate) rows: u32,
    pub(crate) narrow: u32,
    pub(crate) unused_a: u32,
}
