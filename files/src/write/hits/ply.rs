//! Polygon files of points: a header of text, and rows of little-endian numbers without loss.

use super::point::{Fields, Point, levels};

/// The header.
pub(super) fn header(count: u64, fields: Fields) -> Vec<u8> {
    let numbers: String = fields.names().iter().map(|name| format!("property uint {name}\n")).collect();
    let intensity: String = fields.intensities().iter().map(|name| format!("property float {name}\n")).collect();
    format!(
        "ply\nformat binary_little_endian 1.0\ncomment halfline: the hits of rays, without the rays that miss\n\
        element vertex {count}\nproperty double x\nproperty double y\nproperty double z\nproperty double distance\n\
        property int id\n{numbers}{intensity}property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
    )
    .into_bytes()
}

/// Adds a row; returns the coordinates that it has.
pub(super) fn point(point: &Point, color: [f32; 3], fields: Fields, out: &mut Vec<u8>) -> [f64; 3] {
    point.position.iter().chain([&point.distance]).for_each(|x| out.extend(x.to_le_bytes()));
    out.extend(point.id.to_le_bytes());
    point.numbers(fields).iter().for_each(|n| out.extend(n.to_le_bytes()));
    point.intensities(fields).iter().for_each(|x| out.extend(x.to_le_bytes()));
    out.extend(levels(color));
    point.position
}
