//! The samples are written by tests/independent/laz.py with lazrs; `expected` has the formulas of that script.

use crate::formats::las;
use crate::particles::frame::Particles;
use crate::particles::request::Request;
use crate::source::Source;
use halfline_ground::error::Result;

const SAMPLES: [(u8, &[u8]); 7] = [
    (0, include_bytes!("samples/format-0.laz")),
    (1, include_bytes!("samples/format-1.laz")),
    (2, include_bytes!("samples/format-2.laz")),
    (3, include_bytes!("samples/format-3.laz")),
    (6, include_bytes!("samples/format-6.laz")),
    (7, include_bytes!("samples/format-7.laz")),
    (8, include_bytes!("samples/format-8.laz")),
];

const POINTS: usize = 40;

const NAMES: [&str; 9] = [
    "intensity",
    "return_number",
    "number_of_returns",
    "classification",
    "scan_angle",
    "user_data",
    "point_source",
    "gps_time",
    "nir",
];

fn read(bytes: &[u8]) -> Result<Particles> {
    las::read(Source::of_bytes(bytes), &Request::of(&NAMES)).map(Particles::linearized)
}

/// Position, columns and colour of point `n`.
fn expected(n: usize, format: u8) -> ([f64; 3], [f64; 9], [f64; 3]) {
    let k = n as i64;
    let whole = [k * k * k - 700, 900_000 - 37 * k, (k * 7919) % 1000 * (k % 3)].map(|x| x as f64);
    let position = [whole[0] * 0.5 + 100.0, whole[1] * 0.25, whole[2] * 0.125 - 1.0];
    let angle = if format > 5 { (k * 300 - 6000) as f64 * 0.006 } else { (k - 20) as f64 };
    let time = 1e8 + (k / 3) as f64 * 0.25 + if k % 8 == 7 { 5e5 } else { 0.0 };
    let time = time + if k > 30 { 1e-3 * (k * k) as f64 } else { 0.0 };
    let whole = [
        (k * 40503) % 65536 / (1 + k % 2 * 99),
        1 + k % (1 + k % 4),
        1 + k % 4,
        k / 5 % 20,
        0,
        k % 7 * 30,
        500 + k / 9 * 1000,
    ];
    let mut columns = [0.0; 9];
    columns.iter_mut().zip(whole).for_each(|(column, x)| *column = x as f64);
    (columns[4], columns[7], columns[8]) = (angle, time, (k / 3 * 999) as f64);
    let color = [k * 1000, k * 1000 + k / 4 * 300, 65535 - k * k].map(|x| {
        let x = x as f64 / 65535.0;
        // IEC 61966-2-1.
        if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    });
    (position, columns, color)
}

#[test]
fn the_points_of_several_chunks_are_those_that_were_written() {
    for (format, bytes) in SAMPLES {
        let found = read(bytes).unwrap_or_else(|e| panic!("format {format}: {e}"));
        assert_eq!(found.positions.len(), POINTS);
        for n in 0..POINTS {
            let (position, columns, color) = expected(n, format);
            assert_eq!(found.positions[n], position, "format {format}, point {n}");
            for column in &found.columns {
                let at = NAMES.iter().position(|name| *name == column.name).expect("a name");
                assert_eq!(column.values[n], columns[at], "format {format}, {} of point {n}", column.name);
            }
            if let Some(found) = found.colors.get(n) {
                // Rounded once to f32; the same formula in another order of roundings.
                let near = found.iter().zip(color).all(|(found, color)| (f64::from(*found) - color).abs() < 1e-7);
                assert!(near, "format {format}, point {n}: {found:?} {color:?}");
            }
        }
        let has = |name: &str| found.columns.iter().any(|column| column.name == name);
        assert_eq!((has("gps_time"), has("nir")), (![0, 2].contains(&format), format == 8), "format {format}");
        assert_eq!(!found.colors.is_empty(), [2, 3, 7, 8].contains(&format), "format {format}");
    }
}

#[test]
fn a_file_that_ends_within_its_points_is_refused() {
    for (format, bytes) in SAMPLES {
        // The table of chunks behind the points, 8 bytes and 4 of its own at least, is not read.
        for end in (0..bytes.len() - 12).rev().step_by(3) {
            if let Ok(found) = read(&bytes[..end]) {
                assert!(found.positions.len() == POINTS && end > bytes.len() - 64, "format {format} to byte {end}");
            }
        }
    }
}

#[test]
fn what_is_not_read_says_why() {
    let bytes = SAMPLES[3].1;
    let record = bytes.windows(14).position(|part| part == b"laszip encoded").expect("the record") - 2 + 54;
    for (at, value, message) in [
        (record, 7, "record of LASzip: compressor 7 in version 2 of this point format; decompress the file"),
        (record + 2, 1, "coder 1"),
        (record + 12, 0, "chunks of several sizes"),
        (record + 32, 9, "it has only"),
        (record + 34, 10, "the items do not match the point format"),
        (record + 38, 1, "compressor 2 in version 1"),
        (record + 44, 1, "items of several versions"),
        (record - 54 + 2, 0, "the record of LASzip is missing"),
        (record - 33, 9, "it does not end before the points"),
        (100, 0, "the record of LASzip is missing"),
    ] {
        let mut damaged = bytes.to_vec();
        damaged[at] = value;
        // Chunks of 16 points: the second byte stays 0.
        let error = read(&damaged).map(drop).expect_err(message).to_string();
        assert!(error.contains(message), "{message}: {error}");
    }
}
