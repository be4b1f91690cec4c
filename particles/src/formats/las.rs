//! LAS: points of laser scans in records of ten formats (ASPRS, LAS Specification 1.4 R15), also compressed (LAZ).
//! Coordinates are whole numbers times a scale plus an offset, in f64.

mod extra;
mod format;
mod laz;

use crate::format::{FormatRow, Has, Open, Sign};
use crate::particles::bytes::{BinaryFile, DAMAGED};
use crate::particles::colors::ColorType;
use crate::particles::frame::Particles;
use crate::particles::layout::{EVERY, Layout, is_requested};
use crate::particles::request::Request;
use crate::particles::role::Role;
use crate::source::Source;
use extra::ExtraField;
use format::{FORMATS, PointFormat, u16_at, u32_at};
use halfline_ground::error::{Result, relocate};
use halfline_ground::memory::check_ids;
use laz::{Laz, LazScheme};

pub(crate) const LAS: FormatRow = FormatRow {
    name: "las",
    about: "points of laser scans",
    endings: &["laz"],
    // The major version.
    signs: &[Sign::Bytes(|bytes| bytes.starts_with(b"LASF") && bytes.get(24).is_none_or(|version| *version == 1))],
    has: &[Has::Blocks, Has::AnyColumns],
    open: Open::Frame(read).optional(),
    ..FormatRow::PLAIN
};

/// The header, as far as points need it.
struct LasHeader {
    format: PointFormat,
    /// Bytes of a record.
    record: usize,
    points: u64,
    scale: [f64; 3],
    offset: [f64; 3],
    /// The compression of the points; `None` for plain points and for a file without any.
    scheme: Option<LazScheme>,
    /// The fields behind the fields of the format.
    extra: Vec<ExtraField>,
}

/// Columns of all formats, after the coordinates.
const COMMON: [&str; 7] =
    ["intensity", "return_number", "number_of_returns", "classification", "scan_angle", "user_data", "point_source"];

/// Bytes of the header of versions before 1.3, and of 1.4.
const HEADER: u64 = 227;
const HEADER_14: u64 = 375;

/// Bytes of the head of a record behind the header.
const RECORD_HEAD: u64 = 54;

/// Points per block.
const BLOCK: u64 = 4096;

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    bytes[at..].first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes))
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_bits(u64_at(bytes, at))
}

/// Reads the points.
///
/// # Errors
/// [`Error::Scene`] with the place in the file, [`Error::Io`], [`Error::Limits`].
pub(crate) fn read(source: Source, request: &Request) -> Result<Particles> {
    let mut file = BinaryFile::new(source);
    let mut header = LasHeader::read(&mut file)?;
    // Every field costs time for every point. A field of the format comes before one of its name.
    let is_every = request.columns.iter().any(|name| name == EVERY);
    let own = header.format.columns();
    let is_own = |name: &str| own.iter().any(|(own, _)| own.eq_ignore_ascii_case(name));
    let (requested, others): (Vec<_>, Vec<_>) = header
        .extra
        .drain(..)
        .partition(|field| is_requested(&request.columns, &field.name) && (is_every || !is_own(&field.name)));
    header.extra = requested;
    let layout = columns(&header, &file, request)?;
    let mut particles = layout.begin();
    particles.has.extend(others.iter().map(|field| field.name.to_lowercase()));
    let (mut block, mut numbers, mut read) = (Vec::new(), Vec::new(), 0);
    let place = file.file();
    let placed = |point: u64, error| relocate(error, |field| place.clone().named(format!("point {point} {field}")));
    if let Some(scheme) = header.scheme.take() {
        let mut laz = Laz::new(file, scheme, header.format, header.record, !header.extra.is_empty())?;
        for point in 0..header.points {
            numbers.clear();
            header.numbers(laz.next()?, &mut numbers);
            layout.checked_numbers(&numbers, &mut particles, |e| placed(point, e))?;
            if point % BLOCK == 0 {
                laz.found();
            }
        }
        return Ok(header.finish(particles));
    }
    while read < header.points {
        let count = BLOCK.min(header.points - read);
        file.block(count * header.record as u64, &mut block, "points")?;
        for (point, record) in (read..).zip(block.chunks_exact(header.record)) {
            numbers.clear();
            header.numbers(record, &mut numbers);
            layout.checked_numbers(&numbers, &mut particles, |e| placed(point, e))?;
        }
        read += count;
        file.found();
    }
    Ok(header.finish(particles))
}

/// The columns, in the order of [`LasHeader::numbers`].
fn columns(header: &LasHeader, file: &BinaryFile, request: &Request) -> Result<Layout> {
    let mut layout = Layout::new(request);
    layout.note(ColorType::Whole, Vec::new());
    let mut add = |name: &str, role| {
        let wrong = |problem: String| file.fail(104, "point format", problem, DAMAGED);
        layout.add(name, role).map_err(wrong)
    };
    for (name, role) in header.format.columns() {
        add(name, role)?;
    }
    for field in &header.extra {
        add(&field.name, Role::Other)?;
    }
    Ok(layout)
}

impl PointFormat {
    /// The columns of its points, in the order of [`LasHeader::numbers`].
    fn columns(self) -> Vec<(&'static str, Role)> {
        let mut columns: Vec<_> = (0..3).map(|axis| (["x", "y", "z"][axis], Role::Position(axis))).collect();
        columns.extend(COMMON.map(|name| (name, Role::Other)));
        columns.extend(self.gps_time.map(|_| ("gps_time", Role::Other)));
        if self.color.is_some() {
            columns.extend((0..3).map(|channel| (["red", "green", "blue"][channel], Role::Color(channel))));
        }
        columns.extend(self.infrared.map(|_| ("nir", Role::Other)));
        columns
    }
}

/// The variable length records that describe points.
#[derive(Default)]
struct PointRecords {
    extra: Vec<ExtraField>,
    laszip: Option<LazScheme>,
}

impl PointRecords {
    /// Reads `count` records, as far as they end before the points, which begin at byte `start`.
    fn read(
        file: &mut BinaryFile,
        count: u32,
        start: u64,
        format: PointFormat,
        record: usize,
        is_compressed: bool,
    ) -> Result<Self> {
        let mut records = Self::default();
        let mut content = Vec::new();
        for _ in 0..count {
            let head_at = file.at();
            if head_at + RECORD_HEAD > start {
                break;
            }
            let head = file.bytes::<{ RECORD_HEAD as usize }>("variable length record")?;
            let (at, length) = (file.at(), u64::from(u16_at(&head, 20)));
            if at + length > start {
                // Without compression nothing depends on the records.
                if !is_compressed {
                    break;
                }
                return Err(file.fail(head_at, "variable length record", "it does not end before the points", DAMAGED));
            }
            content.clear();
            match (&head[2..18], u16_at(&head, 18)) {
                (user, extra::RECORD) if user.starts_with(extra::USER) => {
                    file.block(length, &mut content, "extra bytes")?;
                    records.extra = extra::fields(&content, format.size, record);
                }
                (user, laz::RECORD) if is_compressed && user.starts_with(laz::USER) => {
                    file.block(length, &mut content, "record of LASzip")?;
                    let scheme = LazScheme::of(&content, format, record);
                    let wrong = |(byte, problem, mend)| file.fail(at + byte, "record of LASzip", problem, mend);
                    records.laszip = Some(scheme.map_err(wrong)?);
                }
                _ => file.pass(length, "variable length record")?,
            }
        }
        Ok(records)
    }
}

impl LasHeader {
    /// Reads up to the first point.
    fn read(file: &mut BinaryFile) -> Result<Self> {
        let mut bytes = Vec::new();
        file.block(HEADER, &mut bytes, "header")?;
        if !bytes.starts_with(b"LASF") {
            return Err(file.fail(0, "signature", "the file does not begin with LASF", DAMAGED));
        }
        let (version, size) = ([bytes[24], bytes[25]], u64::from(u16_at(&bytes, 94)));
        if version[0] != 1 || version[1] > 4 {
            let problem = format!("version {}.{}", version[0], version[1]);
            return Err(file.fail(24, "version", problem, "versions 1.0 to 1.4 are read"));
        }
        let (start, record) = (u64::from(u32_at(&bytes, 96)), usize::from(u16_at(&bytes, 105)));
        let mut points = u64::from(u32_at(&bytes, 107));
        if version[1] == 4 {
            let mut rest = Vec::new();
            file.block(HEADER_14 - HEADER, &mut rest, "header")?;
            points = u64_at(&rest, 247 - HEADER as usize);
        }
        // LAZ sets the highest bit.
        let (is_compressed, number) = (bytes[104] >= 128, bytes[104] & 127);
        let format = FORMATS.get(usize::from(number)).copied();
        let wrong = || file.fail(104, "point format", format!("point format {number}"), "formats 0 to 10 are read");
        let format = format.ok_or_else(wrong)?;
        if record < format.size {
            let problem = format!("{record} bytes, but format {number} has {}", format.size);
            return Err(file.fail(105, "point record length", problem, DAMAGED));
        }
        check_ids(points)?;
        let three = |at: usize| [0, 8, 16].map(|k| f64_at(&bytes, at + k));
        let (scale, offset) = (three(131), three(155));
        if !scale.iter().chain(&offset).all(|x| x.is_finite()) {
            return Err(file.fail(131, "scale and offset", "a number is not finite", DAMAGED));
        }
        let here = file.at();
        if size < HEADER.min(here) || start < here.max(size) {
            let problem = format!("the points begin at byte {start}, the header has {size} bytes");
            return Err(file.fail(96, "offset to point data", problem, DAMAGED));
        }
        file.pass(size.saturating_sub(here), "header")?;
        let count = u32_at(&bytes, 100);
        let PointRecords { extra, laszip } = PointRecords::read(file, count, start, format, record, is_compressed)?;
        if is_compressed && points > 0 && laszip.is_none() {
            let problem = "the points are compressed, but the record of LASzip is missing";
            return Err(file.fail(104, "point format", problem, DAMAGED));
        }
        let scheme = laszip.filter(|_| points > 0);
        file.pass(start.saturating_sub(file.at()), "variable length records")?;
        Ok(Self { format, record, points, scale, offset, scheme, extra })
    }

    /// The particles, with what is to be said of all points.
    fn finish(&self, mut particles: Particles) -> Particles {
        particles.tell_left_out();
        particles.skipped.assumed.extend(self.extra.iter().filter_map(ExtraField::warning));
        particles
    }

    /// The numbers of a record; colours are as in the file.
    fn numbers(&self, record: &[u8], numbers: &mut Vec<f64>) {
        for axis in 0..3 {
            let whole = f64::from(u32_at(record, 4 * axis) as i32);
            numbers.push(whole * self.scale[axis] + self.offset[axis]);
        }
        let returns = record[14];
        let common = if self.format.long {
            // In units of 0.006 degrees.
            let angle = f64::from(u16_at(record, 18) as i16) * 0.006;
            [returns & 15, returns >> 4, record[16]].map(f64::from).into_iter().chain([angle, record[17].into()])
        } else {
            let angle = f64::from(record[16] as i8);
            [returns & 7, returns >> 3 & 7, record[15] & 31]
                .map(f64::from)
                .into_iter()
                .chain([angle, record[17].into()])
        };
        numbers.push(u16_at(record, 12).into());
        numbers.extend(common);
        numbers.push(u16_at(record, if self.format.long { 20 } else { 18 }).into());
        numbers.extend(self.format.gps_time.map(|at| f64_at(record, at)));
        if let Some(at) = self.format.color {
            numbers.extend([0, 2, 4].map(|channel| f64::from(u16_at(record, at + channel))));
        }
        numbers.extend(self.format.infrared.map(|at| f64::from(u16_at(record, at))));
        numbers.extend(self.extra.iter().map(|field| field.number(record)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of two points in a format, with a record of 10 bytes between header and points, and 3 extra bytes.
    fn las(format: u8, minor: u8) -> Vec<u8> {
        let size = if minor == 4 { HEADER_14 } else { HEADER } as usize;
        let mut bytes = vec![0; size + 10];
        let mut put = |at: usize, new: &[u8]| bytes[at..at + new.len()].copy_from_slice(new);
        put(0, b"LASF");
        put(24, &[1, minor]);
        put(94, &(size as u16).to_le_bytes());
        put(96, &(size as u32 + 10).to_le_bytes());
        let record = FORMATS[usize::from(format)].size + 3;
        put(104, &[format]);
        put(105, &(record as u16).to_le_bytes());
        if minor == 4 {
            put(247, &2u64.to_le_bytes())
        } else {
            put(107, &2u32.to_le_bytes())
        }
        for (k, x) in [0.01, 0.5, -2.0, 1000.0, 0.0, 0.25].into_iter().enumerate() {
            put(131 + 8 * k, &f64::to_le_bytes(x));
        }
        for n in 0..2u8 {
            let mut point: Vec<u8> = [150 + i32::from(n), -3, 7].iter().flat_map(|x| x.to_le_bytes()).collect();
            point.extend((513 + u16::from(n)).to_le_bytes());
            // Return 2 of 3, class 5, the angle -12 or -2000 x 0.006 degrees, user data 9, source 77.
            if format < 6 {
                point.extend([2 | 3 << 3, 5 | 1 << 5, -12i8 as u8, 9]);
            } else {
                point.extend([2 | 3 << 4, 0, 5, 9]);
                point.extend((-2000i16).to_le_bytes());
            }
            point.extend(77u16.to_le_bytes());
            if FORMATS[usize::from(format)].gps_time.is_some() {
                point.extend((1e9f64 + 0.125).to_le_bytes());
            }
            if FORMATS[usize::from(format)].color.is_some() {
                point.extend([65535u16, 0, 32896].iter().flat_map(|c| c.to_le_bytes()));
            }
            if FORMATS[usize::from(format)].infrared.is_some() {
                point.extend(4242u16.to_le_bytes());
            }
            point.resize(record, 0xee);
            bytes.extend(point);
        }
        bytes
    }

    fn read(bytes: &[u8], columns: &[&str]) -> Result<Particles> {
        super::read(Source::of_bytes(bytes), &Request::of(columns)).map(Particles::linearized)
    }

    #[test]
    fn points_of_every_format_are_read() {
        for format in 0..11 {
            for minor in if format < 6 { 0..5 } else { 4..5 } {
                let found = read(&las(format, minor), &[&COMMON[..], &["gps_time", "nir"]].concat()).expect("points");
                assert_eq!(
                    found.positions,
                    [[150.0 * 0.01 + 1000.0, -1.5, -13.75], [151.0 * 0.01 + 1000.0, -1.5, -13.75]]
                );
                let of =
                    |name: &str| found.columns.iter().find(|column| column.name == name).map(|column| column.values[1]);
                let common = [514.0, 2.0, 3.0, 5.0, -12.0, 9.0, 77.0];
                assert_eq!(COMMON.map(|name| of(name).expect(name)), common, "format {format}");
                let has = FORMATS[usize::from(format)];
                assert_eq!(of("gps_time"), has.gps_time.map(|_| 1e9 + 0.125));
                assert_eq!(of("nir"), has.infrared.map(|_| 4242.0));
                match has.color {
                    // 32896 of 65535 is 128 of 255: IEC 61966-2-1.
                    Some(_) => {
                        assert!(found.colors[1][..2] == [1.0, 0.0] && (found.colors[1][2] - 0.2158605).abs() < 1e-6)
                    }
                    None => assert!(found.colors.is_empty()),
                }
            }
        }
    }

    #[test]
    fn colours_of_8_bits_are_recognised() {
        let mut bytes = las(2, 2);
        let start = HEADER as usize + 10;
        for point in 0..2 {
            let at = start + 29 * point + 20;
            bytes[at..at + 6].copy_from_slice(&[255, 0, 128, 0, 0, 0]);
        }
        let found = read(&bytes, &[]).expect("points");
        assert!(found.colors[0][0] == 1.0 && (found.colors[0][1] - 0.2158605).abs() < 1e-6, "{:?}", found.colors);
        assert!(found.skipped.assumed[0].contains("8-bit"), "{:?}", found.skipped);
    }

    #[test]
    fn errors_name_the_byte() {
        let with = |at: usize, byte: u8| {
            let mut bytes = las(3, 4);
            bytes[at] = byte;
            bytes
        };
        for (bytes, message) in [
            (with(0, 0), "byte 0: signature"),
            (with(25, 5), "byte 24: version: version 1.5"),
            (with(104, 131), "byte 104: point format: the points are compressed, but the record of LASzip is missing"),
            (with(104, 11), "byte 104: point format: point format 11"),
            (with(105, 33), "byte 105: point record length: 33 bytes, but format 3 has 34"),
            (with(96, 0), "byte 96: offset to point data"),
            (with(138, 0x7f), "byte 131: scale and offset"),
            (with(247, 3), "byte 385: points: the file ends after 74 of 111 bytes"),
            (with(251, 1), "32-bit ids"),
            (las(3, 4)[..300].to_vec(), "byte 227: header: the file ends after 73 of 148 bytes"),
            (las(3, 4)[..380].to_vec(), "variable length records: the file ends after 5 of 10 bytes"),
        ] {
            let mut bytes = bytes;
            if message.contains("scale") {
                bytes[137] = 0xf0;
            }
            let error = read(&bytes, &[]).map(drop).expect_err(message).to_string();
            assert!(error.contains(message), "{message}: {error}");
        }
    }
}
