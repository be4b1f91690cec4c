//! Point clouds of the Point Cloud Library, version 0.7, binary. The points of that library have f32 coordinates, and it
//! does not take others for them, so coordinates are rounded to f32. It packs 8-bit colours into the bits of an f32.

use super::point::{Fields, Point, levels};

/// The header.
pub(super) fn header(count: u64, fields: Fields) -> Vec<u8> {
    let own = [fields.names(), fields.intensities()].concat();
    let each = |word: &str| format!(" {word}").repeat(own.len());
    let (names, four, one) = (own.join(" "), each("4"), each("1"));
    let types = " U".repeat(fields.names().len()) + &" F".repeat(fields.intensities().len());
    format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z distance id {names} rgb\n\
        SIZE 4 4 4 4 4{four} 4\nTYPE F F F F I{types} F\nCOUNT 1 1 1 1 1{one} 1\nWIDTH {count}\nHEIGHT 1\n\
        VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA binary\n"
    )
    .into_bytes()
}

/// Adds a row; returns the coordinates that it has.
pub(super) fn point(point: &Point, color: [f32; 3], fields: Fields, out: &mut Vec<u8>) -> [f64; 3] {
    let position = point.position.map(|x| x as f32);
    position.iter().chain([&(point.distance as f32)]).for_each(|x| out.extend(x.to_le_bytes()));
    out.extend(point.id.to_le_bytes());
    point.numbers(fields).iter().for_each(|n| out.extend(n.to_le_bytes()));
    point.intensities(fields).iter().for_each(|x| out.extend(x.to_le_bytes()));
    let [red, green, blue] = levels(color);
    out.extend([blue, green, red, 0]);
    position.map(f64::from)
}
