//! Tests of files that are put together from the description of the format; `tests/independent/netcdf.py` compares those that
//! other programs write.

use crate::Format;
use crate::particles::frame::Particles;
use crate::particles::frame_time::FrameTime;
use crate::particles::request::Request;
use crate::source::Source;
use halfline_ground::error::Result;

/// A header in this version of the format.
struct Writer {
    version: u8,
    bytes: Vec<u8>,
}

impl Writer {
    fn count(&mut self, count: u64) {
        match self.version {
            5 => self.bytes.extend(count.to_be_bytes()),
            _ => self.bytes.extend((count as u32).to_be_bytes()),
        }
    }

    fn list(&mut self, tag: u32, count: u64) {
        self.bytes.extend(if count == 0 { 0 } else { tag }.to_be_bytes());
        self.count(count);
    }

    fn name(&mut self, name: &str) {
        self.count(name.len() as u64);
        self.bytes.extend(name.as_bytes());
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }
}

/// The variables: name, dimensions, type, bytes of a record and whether they have one for each frame.
type Row = (&'static str, &'static [u64], u32, u64);

/// Dimensions: frame, spatial, atom (two), and three letters.
const ROWS: [Row; 7] = [
    ("spatial", &[1], 2, 4),
    ("time", &[0], 5, 4),
    ("note", &[0], 3, 4),
    ("coordinates", &[0, 2, 1], 5, 24),
    ("cell_lengths", &[0, 1], 6, 24),
    ("cell_angles", &[0, 1], 6, 24),
    ("velocities", &[0, 2, 1], 5, 24),
];

/// The number of a coordinate, of a frame from 0.
fn place(frame: u64, k: u64) -> f32 {
    frame as f32 * 100.0 + k as f32 + 0.25
}

/// A film of frames of two atoms, or a restart file of one, whose variables have no records.
fn file(version: u8, records: u64, frames: u64, is_restart: bool) -> Vec<u8> {
    let header = |begins: &[u64]| {
        let mut to = Writer { version, bytes: vec![b'C', b'D', b'F', version] };
        to.count(records);
        to.list(10, 3);
        for (name, length) in [("frame", 0), ("spatial", 3), ("atom", 2)] {
            to.name(name);
            to.count(length);
        }
        to.list(12, 1);
        to.name("Conventions");
        to.bytes.extend(2u32.to_be_bytes());
        to.name("AMBER");
        to.list(11, ROWS.len() as u64);
        for ((name, sides, kind, bytes), begin) in ROWS.iter().zip(begins) {
            let sides: Vec<u64> = sides.iter().copied().filter(|side| !(is_restart && *side == 0)).collect();
            to.name(name);
            to.count(sides.len() as u64);
            sides.into_iter().for_each(|side| to.count(side));
            to.list(12, u64::from(*name == "velocities"));
            if *name == "velocities" {
                to.name("scale_factor");
                to.bytes.extend(5u32.to_be_bytes());
                to.count(1);
                to.bytes.extend(20.5f32.to_be_bytes());
            }
            to.bytes.extend(kind.to_be_bytes());
            to.count(*bytes);
            match version {
                1 => to.bytes.extend((*begin as u32).to_be_bytes()),
                _ => to.bytes.extend(begin.to_be_bytes()),
            }
        }
        to.bytes
    };
    let start = header(&[0; 7]).len() as u64;
    let before = |n: usize| ROWS[..n].iter().map(|(.., bytes)| bytes).sum::<u64>();
    let begins: Vec<u64> = (0..ROWS.len()).map(|n| start + before(n)).collect();
    let mut bytes = header(&begins);
    bytes.extend(b"xyz\0");
    for frame in 0..frames {
        bytes.extend((frame as f32 * 0.5).to_be_bytes());
        bytes.extend([0, 7, 0, 0]);
        (0..6).for_each(|k| bytes.extend(place(frame, k).to_be_bytes()));
        [10.0, 20.0, 30.0 + frame as f64, 90.0, 90.0, 90.0].iter().for_each(|x: &f64| bytes.extend(x.to_be_bytes()));
        (0..6).for_each(|k| bytes.extend((2.0 * place(frame, k)).to_be_bytes()));
    }
    bytes
}

fn read(bytes: &[u8], columns: &[&str]) -> Result<Vec<Particles>> {
    let frames = Format::NC.frames(Source::of_bytes(bytes), Request::of(columns), false)?;
    let Ok(mut frames) = frames else { panic!("a trajectory") };
    std::iter::from_fn(|| frames.next().transpose()).collect()
}

#[test]
fn films_of_all_versions_have_their_frames() {
    for (version, records) in
        [(1, 3), (2, 3), (5, 3), (1, u64::from(u32::MAX)), (2, u64::from(u32::MAX)), (5, u64::MAX)]
    {
        let bytes = file(version, records, 3, false);
        for columns in [&["vy"][..], &[]] {
            let found = read(&bytes, columns).expect("three frames");
            assert_eq!(found.len(), 3, "{version}");
            for (n, frame) in (0..).zip(&found) {
                let number = |k| f64::from(place(n, k));
                assert_eq!(frame.positions, [[0, 1, 2], [3, 4, 5]].map(|three| three.map(number)), "{version}");
                assert_eq!(frame.when, FrameTime::of(Some(n as f64 * 0.5), None));
                let edges = frame.cell.expect("a cell").edges;
                assert!((edges[2][2] - 30.0 - n as f64).abs() < 1e-12 && edges[0] == [10.0, 0.0, 0.0], "{edges:?}");
                assert_eq!(frame.has, ["vx", "vy", "vz"]);
                let velocities: Vec<f64> = frame.columns.iter().flat_map(|column| column.values.clone()).collect();
                let expected = [1, 4].map(|k| f64::from(2.0 * place(n, k)) * 20.5);
                assert_eq!(velocities, if columns.is_empty() { vec![] } else { expected.to_vec() }, "{version}");
            }
        }
        let Ok(mut frames) = Format::NC.frames(Source::of_bytes(&bytes), Request::of(&[]), false).expect("a reader")
        else {
            panic!("a trajectory")
        };
        assert!(frames.skip().expect("one") && frames.skip().expect("two"));
        assert_eq!(frames.next().expect("read").expect("the third").positions[0][0], f64::from(place(2, 0)));
        assert!(!frames.skip().expect("the end"));
    }
}

#[test]
fn a_restart_file_is_one_frame() {
    for version in [1, 2, 5] {
        let found = read(&file(version, 0, 1, true), &["vx"]).expect("a frame");
        assert_eq!((found.len(), found[0].positions[1][2], found[0].columns[0].values[1]), (1, 5.25, 6.5 * 20.5));
    }
}

#[test]
fn damaged_files_are_refused() {
    let good = file(2, 3, 3, false);
    let replaced = |from: &str, to: &str| {
        let at = good.windows(from.len()).position(|text| text == from.as_bytes()).expect(from);
        [&good[..at], to.as_bytes(), &good[at + from.len()..]].concat()
    };
    let mut many = good.clone();
    many[8..12].copy_from_slice(&[0, 0, 0, 11]);
    let mut sides = good.clone();
    sides[12..16].copy_from_slice(&[0, 0xff, 0, 0]);
    let mut empty = good.clone();
    let atom = good.windows(4).position(|text| text == b"atom").expect("a dimension");
    empty[atom + 4..atom + 8].copy_from_slice(&[0; 4]);
    let mut version = good.clone();
    version[3] = 3;
    for (bytes, message) in [
        (empty, "a frame has no atoms"),
        (version, "does not begin with CDF and 1, 2 or 5"),
        (good[..good.len() - 1].to_vec(), "velocities: the file ends after 23 of 24 bytes"),
        (good[..30].to_vec(), "dimensions: the file ends"),
        (replaced("coordinates", "coordinated"), "no variable coordinates among spatial, time, note"),
        (many, "a list begins with 11, not with 10"),
        (sides, "is more than 4096"),
    ] {
        let error = read(&bytes, &["vx"]).map(drop).expect_err(message).to_string();
        assert!(error.starts_with("text: byte ") && error.contains(message), "{message}: {error}");
    }
    for at in 0..good.len() {
        let cut = read(&good[..at], &["vx"]);
        assert!(cut.is_err(), "{at} bytes");
    }
}
