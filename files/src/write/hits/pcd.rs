//! Point clouds of the Point Cloud Library, version 0.7, binary. The points of that library have f32 coordinates, and it
//! does not take others for them, so coordinates are rounded to f32. It packs 8-bit colours into the bits of an f32.

use super::point::{Point, levels, names};

/// The header.
pub(super) fn header(count: u64, is_scan: bool) -> Vec<u8> {
    let places = names(is_scan);
    let each = |word: &str| format!(" {word}").repeat(places.len());
    let (fields, four, unsigned, one) = (places.join(" "), each("4"), each("U"), each("1"));
    format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z distance id {fields} rgb\n\
        SIZE 4 4 4 4 4{four} 4\nTYPE F F F F I{unsigned} F\nCOUNT 1 1 1 1 1{one} 1\nWIDTH {count}\nHEIGHT 1\n\
        VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA binary\n"
    )
    .into_bytes()
}

/// Adds a row; returns the coordinates that it has.
pub(super) fn point(point: &Point, color: [f32; 3], is_scan: bool, out: &mut Vec<u8>) -> [f64; 3] {
    let position = point.position.map(|x| x as f32);
    position.iter().chain([&(point.distance as f32)]).for_each(|x| out.extend(x.to_le_bytes()));
    out.extend(point.id.to_le_bytes());
    point.places(is_scan).iter().for_each(|n| out.extend(n.to_le_bytes()));
    let [red, green, blue] = levels(color);
    out.extend([blue, green, red, 0]);
    position.map(f64::from)
}
