//! The point formats of LAS, and numbers in their records.

/// The fields of a record: the byte of each that only some formats have.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointFormat {
    pub(super) size: usize,
    /// Whether it is one of the formats from 6 on, which have more bits for returns and classes.
    pub(super) long: bool,
    pub(super) gps_time: Option<usize>,
    pub(super) color: Option<usize>,
    pub(super) infrared: Option<usize>,
}

/// The formats 0 to 10; 4, 5, 9 and 10 end in 29 bytes of a wave packet.
pub(super) const FORMATS: [PointFormat; 11] = [
    PointFormat { size: 20, long: false, gps_time: None, color: None, infrared: None },
    PointFormat { size: 28, long: false, gps_time: Some(20), color: None, infrared: None },
    PointFormat { size: 26, long: false, gps_time: None, color: Some(20), infrared: None },
    PointFormat { size: 34, long: false, gps_time: Some(20), color: Some(28), infrared: None },
    PointFormat { size: 57, long: false, gps_time: Some(20), color: None, infrared: None },
    PointFormat { size: 63, long: false, gps_time: Some(20), color: Some(28), infrared: None },
    PointFormat { size: 30, long: true, gps_time: Some(22), color: None, infrared: None },
    PointFormat { size: 36, long: true, gps_time: Some(22), color: Some(30), infrared: None },
    PointFormat { size: 38, long: true, gps_time: Some(22), color: Some(30), infrared: Some(36) },
    PointFormat { size: 59, long: true, gps_time: Some(22), color: None, infrared: None },
    PointFormat { size: 67, long: true, gps_time: Some(22), color: Some(30), infrared: Some(36) },
];

pub(super) fn u16_at(bytes: &[u8], at: usize) -> u16 {
    bytes[at..].first_chunk().map_or(0, |bytes| u16::from_le_bytes(*bytes))
}

pub(super) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes[at..].first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes))
}
