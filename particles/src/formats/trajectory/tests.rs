//! Tests of the trajectories. The XTC frame was written by the xdrfile library of MDAnalysis 2.11 from the positions of
//! [`waters`]; TRR and DCD are put together here from the descriptions of the formats.

use super::*;
use crate::Format;
use crate::particles::frame_time::FrameTime;
use crate::particles::joined::{Joined, Topology};
use halfline_ground::Cell;
use halfline_ground::error::Place;
use halfline_ground::quote::setting::TOPOLOGY;

/// Four waters in the box 20 x 30 x 40, in two runs of small differences, compressed with a precision of 1000.
const XTC: &str = "000007cb0000000c00000000000000004000000000000000000000000000000040400000000000000000000000000000\
    408000000000000c447a0000ffffffe8fffffed4ffffe88e0000063c00000dd700000005000000150000003073a4092108443c8c294220f9\
    e080008ac1efa954e7d86b06480ac5401690199b0d60c90158f8472edbc361ac19202b10";

fn xtc() -> Vec<u8> {
    let digits = XTC.as_bytes().as_chunks::<2>().0;
    let byte = |pair: &[u8; 2]| u8::from_str_radix(std::str::from_utf8(pair).expect("ASCII"), 16).expect("digits");
    digits.iter().map(byte).collect()
}

/// The positions that the writer was given, in picometres.
fn waters() -> Vec<[f64; 3]> {
    let water = |w: i32| {
        let oxygen = [500 * w, 1250 * w - 300, -2000 * w + 1];
        [[0, 0, 0], [96, 12, -3], [-24, 93, 4]]
            .map(|offset: [i32; 3]| [0, 1, 2].map(|k| f64::from(oxygen[k] + offset[k])))
    };
    (0..4).flat_map(water).collect()
}

fn open(format: Format, bytes: &[u8], columns: &[&str]) -> Box<dyn ParticleFrames> {
    let opened = format.frames(Source::of_bytes(bytes), Request::of(columns), false).expect("a reader");
    opened.unwrap_or_else(|_| panic!("{format:?} has frames"))
}

fn frames(format: Format, bytes: &[u8], columns: &[&str]) -> Result<Vec<Particles>> {
    let mut trajectory = open(format, bytes, columns);
    std::iter::from_fn(|| trajectory.next().transpose()).collect()
}

#[test]
fn xtc_has_the_positions_that_another_program_wrote() {
    let found = frames(Format::XTC, &[xtc(), xtc()].concat(), &[]).expect("two frames");
    assert_eq!(found.len(), 2);
    for frame in &found {
        assert_eq!(frame.positions.len(), 12);
        for (position, expected) in frame.positions.iter().flatten().zip(waters().as_flattened()) {
            // Two roundings of numbers below 100.
            assert!((position - expected / 100.0).abs() < 3e-14, "{position} {expected}");
        }
        assert_eq!(frame.cell.expect("a box").edges, [[20.0, 0.0, 0.0], [0.0, 30.0, 0.0], [0.0, 0.0, 40.0]]);
    }
    assert_eq!((found[0].skipped.assumed.len(), found[1].skipped.assumed.len()), (1, 0), "told once");
    assert!(found[0].skipped.assumed[0].contains(TOPOLOGY), "{:?}", found[0].skipped);
    let mut passed = open(Format::XTC, &[xtc(), xtc()].concat(), &[]);
    assert!(passed.skip().expect("one"));
    assert_eq!(passed.next().expect("read").expect("the second").positions, found[0].positions);
    assert!(!passed.skip().expect("the end"));
}

#[test]
fn xtc_of_many_atoms_has_sizes_of_64_bits() {
    let mut bytes = xtc();
    bytes[2..4].copy_from_slice(&[0x07, 0xe7]);
    bytes.splice(88..88, [0; 4]);
    let frame = frames(Format::XTC, &bytes, &[]).expect("a frame").remove(0);
    assert_eq!(frame.positions, frames(Format::XTC, &xtc(), &[]).expect("a frame")[0].positions);
    assert!(open(Format::XTC, &bytes, &[]).skip().expect("skipped"));
    bytes[88] = 0x80;
    let error = frames(Format::XTC, &bytes, &[]).map(drop).expect_err("a negative size").to_string();
    assert!(error.contains("byte 88: compressed bytes: -9223372036854775760 bytes"), "{error}");
}

#[test]
fn xtc_frames_of_few_atoms_are_not_compressed() {
    let words = [1995i32, 2, 500];
    let mut bytes: Vec<u8> = words.iter().flat_map(|x| x.to_be_bytes()).collect();
    bytes.extend(2.5f32.to_be_bytes());
    bytes.extend([0; 36]);
    bytes.extend(2i32.to_be_bytes());
    bytes.extend([0.5f32, -1.0, 2.0, 3.0, 4.25, 0.0].iter().flat_map(|x| x.to_be_bytes()));
    let frame = frames(Format::XTC, &bytes, &[]).expect("a frame").remove(0);
    assert_eq!((&frame.positions[..], frame.cell), (&[[5.0, -10.0, 20.0], [30.0, 42.5, 0.0]][..], None));
    assert_eq!(frame.when, FrameTime { time: Some(2.5), step: Some(500) });
    assert!(open(Format::XTC, &bytes, &[]).skip().expect("skipped"));
}

/// A frame of TRR: `parts` are box, positions, velocities and forces.
fn trr(atoms: usize, double: bool, parts: [&[f64]; 4]) -> Vec<u8> {
    let [cell, x, v, f] = parts;
    let size = |part: &[f64]| (part.len() * if double { 8 } else { 4 }) as i32;
    let real = |x: &f64| if double { x.to_be_bytes().to_vec() } else { (*x as f32).to_be_bytes().to_vec() };
    let mut bytes: Vec<u8> = [1993, 13, 12].iter().flat_map(|x: &i32| x.to_be_bytes()).collect();
    bytes.extend(b"GMX_trn_file");
    let header = [0, 0, size(cell), 0, 0, 0, 0, size(x), size(v), size(f), atoms as i32, 7, 0];
    bytes.extend(header.iter().flat_map(|x| x.to_be_bytes()));
    bytes.extend([0.5, 0.0].iter().chain(cell).chain(x).chain(v).chain(f).flat_map(real));
    bytes
}

#[test]
fn trr_is_read_in_both_precisions_and_frames_without_positions_are_skipped() {
    let cell = [1.0, 0.0, 0.0, 0.25, 2.0, 0.0, 0.0, 0.0, 3.0];
    let [x, v] = [[1.0, 2.0, 3.0, -4.0, 0.5, 0.125], [0.5, 1.5, 2.5, 3.5, 4.5, 5.5]];
    for double in [false, true] {
        let bytes = [
            trr(2, double, [&cell, &x, &v, &[9.0; 6]]),
            trr(2, double, [&cell, &[], &v, &[]]),
            trr(2, double, [&[], &v, &[], &[]]),
        ]
        .concat();
        let found = frames(Format::TRR, &bytes, &["VZ", "vx"]).expect("two frames");
        assert_eq!(found.len(), 2);
        assert_eq!(found[0].positions, [[10.0, 20.0, 30.0], [-40.0, 5.0, 1.25]]);
        assert_eq!(found[0].cell.expect("a box").edges, [[10.0, 0.0, 0.0], [2.5, 20.0, 0.0], [0.0, 0.0, 30.0]]);
        let columns: Vec<_> = found[0].columns.iter().map(|c| (c.name.as_str(), &c.values[..])).collect();
        assert_eq!(columns, [("vx", &[0.5, 3.5][..]), ("vz", &[2.5, 5.5])]);
        assert_eq!((found[1].positions[1], found[1].cell), ([35.0, 45.0, 55.0], None));
        assert_eq!(found[0].when, FrameTime { time: Some(0.5), step: Some(7) });
        assert!(found[1].has.is_empty() && found[1].columns.is_empty());
        let mut passed = open(Format::TRR, &bytes, &[]);
        assert!(passed.skip().expect("one"));
        assert_eq!(passed.next().expect("read").expect("the last").positions[1][2], 55.0);
    }
}

/// The variant of DCD in which a file is written.
#[derive(Clone, Copy)]
struct How {
    big: bool,
    wide: bool,
    cell: Option<[f64; 6]>,
    fourth: bool,
    fixed: bool,
}

/// Two frames of three atoms; in the second, with fixed atoms, only the third moves.
fn dcd(how: How) -> Vec<u8> {
    let order = |mut little: Vec<u8>| {
        if how.big {
            little.reverse();
        }
        little
    };
    let int = |x: i32| order(x.to_le_bytes().to_vec());
    let marker =
        |x: usize| order(if how.wide { (x as u64).to_le_bytes().to_vec() } else { (x as u32).to_le_bytes().to_vec() });
    let record = |content: Vec<u8>| [marker(content.len()), content.clone(), marker(content.len())].concat();
    let reals = |numbers: &[f32]| record(numbers.iter().flat_map(|x| order(x.to_le_bytes().to_vec())).collect());
    let mut control = [0; 20];
    (control[0], control[8], control[19]) = (2, if how.fixed { 2 } else { 0 }, 24);
    (control[10], control[11]) = (i32::from(how.cell.is_some()), i32::from(how.fourth));
    // The first frame is of step 1000, others follow every 250, and a step takes 0.5 AKMA units.
    (control[1], control[2], control[9]) = (1000, 250, 0.5f32.to_bits() as i32);
    let first = [b"CORD".to_vec(), control.iter().flat_map(|x| int(*x)).collect()].concat();
    let mut bytes = [record(first), record([int(1), vec![b' '; 80]].concat()), record(int(3))].concat();
    if how.fixed {
        bytes.extend(record(int(3)));
    }
    for frame in 0..2 {
        if let Some(cell) = how.cell {
            bytes.extend(record(cell.iter().flat_map(|x| order(x.to_le_bytes().to_vec())).collect()));
        }
        for axis in 0..3 {
            let x: Vec<f32> = (0..3).map(|n| (100 * frame + 10 * n + axis) as f32 + 0.5).collect();
            bytes.extend(reals(if how.fixed && frame == 1 { &x[2..] } else { &x }));
        }
        if how.fourth {
            bytes.extend(reals(&[7.0; 3][..if how.fixed && frame == 1 { 1 } else { 3 }]));
        }
    }
    bytes
}

const PLAIN: How = How { big: false, wide: false, cell: None, fourth: false, fixed: false };

#[test]
fn dcd_is_read_in_all_its_variants() {
    for n in 0..16 {
        let [big, wide, fourth, fixed] = [n & 1 > 0, n & 2 > 0, n & 4 > 0, n & 8 > 0];
        let bytes = dcd(How { big, wide, cell: Some([20.0, 90.0, 30.0, 90.0, 90.0, 40.0]), fourth, fixed });
        let found = frames(Format::DCD, &bytes, &[]).expect("two frames");
        assert_eq!(found.len(), 2);
        assert_eq!(found[0].positions, [[0.5, 1.5, 2.5], [10.5, 11.5, 12.5], [20.5, 21.5, 22.5]]);
        let first = if fixed { [0.5, 1.5, 2.5] } else { [100.5, 101.5, 102.5] };
        assert_eq!((found[1].positions[0], found[1].positions[2]), (first, [120.5, 121.5, 122.5]));
        assert_eq!(found[0].cell.expect("a cell").edges, [[20.0, 0.0, 0.0], [0.0, 30.0, 0.0], [0.0, 0.0, 40.0]]);
        let mut passed = open(Format::DCD, &bytes, &[]);
        assert!(passed.skip().expect("one"));
        let second = passed.next().expect("read").expect("the second");
        assert_eq!((second.positions, second.when), (found[1].positions.clone(), found[1].when));
        assert!(!passed.skip().expect("the end"));
        for (frame, step) in found.iter().zip([1000, 1250]) {
            let time = frame.when.time.expect("a time");
            // 4.888821e-14 s are an AKMA unit; two roundings.
            assert!((time - step as f64 * 0.5 * 0.04888821).abs() < 1e-14 * time && frame.when.step == Some(step));
        }
    }
}

#[test]
fn steps_of_dcd_have_a_time_in_the_precision_of_the_program() {
    let mut bytes = dcd(PLAIN);
    // The control numbers follow the marker and the kind; X-PLOR has a double, and no version at the end.
    bytes[8 + 36..8 + 44].copy_from_slice(&0.1f64.to_le_bytes());
    bytes[8 + 76..8 + 80].fill(0);
    let when = |bytes: &[u8]| frames(Format::DCD, bytes, &[]).expect("two frames")[0].when;
    let time = when(&bytes).time.expect("a time");
    assert!((time - 4.888821).abs() < 1e-13, "{time}");
    let mut lammps = bytes.clone();
    // The titles follow the first record, their marker and their number.
    lammps[92 + 8..92 + 25].copy_from_slice(b"Written by LAMMPS");
    assert_eq!(when(&lammps), FrameTime { time: None, step: Some(1000) });
    bytes[8 + 36..8 + 44].fill(0);
    assert_eq!(when(&bytes), FrameTime { time: None, step: Some(1000) });
    bytes[8 + 8..8 + 12].fill(0);
    assert_eq!(when(&bytes), FrameTime::default());
}

#[test]
fn cells_of_dcd_have_cosines_degrees_or_a_matrix() {
    let edges = |cell| frames(Format::DCD, &dcd(How { cell: Some(cell), ..PLAIN }), &[]).map(|found| found[0].cell);
    // The angle between a and b is 60 degrees.
    for gamma in [0.5, 60.0] {
        let others = if gamma < 1.0 { 0.0 } else { 90.0 };
        let found = edges([2.0, gamma, 4.0, others, others, 5.0]).expect("a frame").expect("a cell").edges;
        let expected = [[2.0, 0.0, 0.0], [2.0, 12f64.sqrt(), 0.0], [0.0, 0.0, 5.0]];
        // Cosines and sines of numbers below 2, times 5.
        assert!(
            found.as_flattened().iter().zip(expected.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-14),
            "{found:?}"
        );
    }
    let matrix = edges([30.0, 1.5, 31.0, -2.0, 0.5, 32.0]).expect("a frame").expect("a cell").edges;
    assert_eq!(matrix, [[30.0, 1.5, -2.0], [1.5, 31.0, 0.5], [-2.0, 0.5, 32.0]]);
    assert_eq!(edges([0.0; 6]).expect("a frame"), None);
    edges([f64::NAN; 6]).expect_err("not a cell");
}

/// A topology of `names` atoms, which have these places among all `listed` ones of its file.
fn topology(names: usize, listed: usize, places: Vec<u32>) -> Topology {
    let column = |name: &str| Column { name: name.into(), values: (0..names).map(|n| n as f64).collect() };
    let atoms = Particles {
        positions: vec![[0.0; 3]; names],
        elements: vec![8; names],
        columns: vec![column("serial"), column("vx"), column("ix")],
        has: vec!["serial".into(), "vx".into(), "ix".into()],
        places,
        listed,
        ..Particles::default()
    };
    Topology { path: "atoms.gro".into(), atoms }
}

#[test]
fn a_topology_gives_elements_and_columns_and_the_trajectory_what_moves() {
    let bytes = trr(3, false, [&[], &[1.0; 9], &[0.25, 0.0, 0.0, 0.5, 0.0, 0.0, 0.75, 0.0, 0.0], &[]]);
    let read = |bytes: &[u8], topology: Topology| {
        let frames = open(Format::TRR, bytes, &["serial", "vx"]);
        Joined::new(frames, Place::file("text"), topology, None, true).next()
    };
    let of = |particles: &Particles| -> Vec<_> {
        let mut columns: Vec<_> =
            particles.columns.iter().map(|column| (column.name.clone(), column.values.clone())).collect();
        columns.sort_by(|a, b| a.0.cmp(&b.0));
        columns
    };
    let whole = read(&bytes, topology(3, 0, Vec::new())).expect("read").expect("a frame");
    assert_eq!((whole.positions[2], &whole.elements[..]), ([10.0; 3], &[8; 3][..]));
    assert_eq!(of(&whole), [("serial".into(), vec![0.0, 1.0, 2.0]), ("vx".into(), vec![0.25, 0.5, 0.75])]);
    // The second of three atoms is a virtual site.
    let two = read(&bytes, topology(2, 3, vec![0, 2])).expect("read").expect("a frame");
    assert_eq!((two.positions.len(), &of(&two)[1].1[..]), (2, &[0.25, 0.75][..]));
    let still = trr(3, false, [&[], &[1.0; 9], &[], &[]]);
    let still = read(&still, topology(3, 0, Vec::new())).expect("read").expect("a frame");
    assert_eq!(still.has, ["serial"], "velocities and image flags of another frame are left out");
    for (atoms, listed, places) in [(2, 0, vec![]), (4, 0, vec![]), (1, 2, vec![0]), (4, 5, vec![0, 1, 2, 4])] {
        let error = read(&bytes, topology(atoms, listed, places)).map(drop).expect_err("other atoms").to_string();
        let message = format!("the trajectory has 3 atoms, the topology atoms.gro has {atoms}");
        assert!(error.starts_with("text: number of atoms: ") && error.contains(&message), "{error}");
    }
}

/// The frames of a program that centres its box say its edges alone.
#[test]
fn a_cell_begins_where_that_of_the_topology_does() {
    let numbers: [f64; 9] = [2.0, 0.0, 0.0, 0.5, 4.0, 0.0, 0.0, 0.0, 8.0];
    let bytes = trr(1, false, [&numbers, &[0.1; 3], &[], &[]]);
    let edges = [[20.0, 0.0, 0.0], [5.0, 40.0, 0.0], [0.0, 0.0, 80.0]];
    for (of, origin, expected) in [
        (edges, [0.0; 3], [0.0; 3]),
        (edges, [-12.5, -20.0, 3.0], [-12.5, -20.0, 3.0]),
        // Half the cell, whose middle is at 0.
        (edges.map(|edge| edge.map(|x| x / 2.0)), [-6.25, -10.0, -20.0], [-12.5, -20.0, -40.0]),
        ([[0.0; 3]; 3], [1.0, 2.0, 3.0], [1.0, 2.0, 3.0]),
    ] {
        let mut topology = topology(1, 0, Vec::new());
        topology.atoms.cell = Some(Cell { origin, edges: of });
        let frames = open(Format::TRR, &bytes, &[]);
        let frame = Joined::new(frames, Place::file("text"), topology, None, true).next().expect("read");
        let cell = frame.expect("a frame").cell.expect("a cell");
        assert_eq!((cell.origin, cell.edges), (expected, edges));
    }
}

#[test]
fn errors_name_the_byte() {
    let with = |mut bytes: Vec<u8>, at: usize, word: i32| {
        bytes[at..at + 4].copy_from_slice(&word.to_be_bytes());
        bytes
    };
    let single = || trr(1, false, [&[], &[1.0; 3], &[], &[]]);
    let little = || dcd(PLAIN);
    let wide = |at: usize, byte: u8| {
        let mut bytes = little();
        bytes[at] = byte;
        bytes
    };
    let short = |bytes: Vec<u8>| bytes[..bytes.len() - 1].to_vec();
    for (format, bytes, message) in [
        (Format::XTC, vec![0, 0, 7], "byte 0: magic number: the file ends after 3 of 4 bytes"),
        (Format::XTC, with(xtc(), 0, 7), "byte 0: magic number: a frame begins with 7"),
        (Format::XTC, with(xtc(), 4, -1), "byte 4: number of atoms: -1 atoms"),
        (Format::XTC, with(xtc(), 52, 13), "byte 52: number of positions: 13 positions of 12 atoms"),
        (Format::XTC, with(xtc(), 16, 0x7fc0_0000), "byte 16: box"),
        (Format::XTC, with(xtc(), 56, 0), "byte 56: precision: the precision is 0"),
        (Format::XTC, with(xtc(), 60, 0x7fff_ffff), "positions: coordinates from 2147483647"),
        (Format::XTC, with(xtc(), 84, 8), "small differences of index 8"),
        (Format::XTC, with(xtc(), 84, i32::MIN), "small differences of index"),
        (Format::XTC, with(xtc(), 88, i32::MAX), "the file ends after 48 of 2147483647 bytes"),
        (Format::XTC, with(xtc(), 88, -4), "byte 88: compressed bytes: -4 bytes"),
        (Format::XTC, with(xtc(), 88, 8)[..100].to_vec(), "byte 92: positions: the compressed bytes end"),
        (Format::XTC, short(xtc()), "byte 92: positions: the file ends after 47 of 48 bytes"),
        (Format::TRR, with(single(), 0, 1), "byte 0: magic number"),
        (Format::TRR, with(single(), 52, -8), "byte 52: positions: the size is -8 bytes"),
        (Format::TRR, with(single(), 52, 13), "do not fit 1 atoms"),
        (Format::TRR, with(single(), 64, i32::MAX), "do not fit 2147483647 atoms"),
        (Format::TRR, short(single()), "positions: the file ends after 11 of 12 bytes"),
        (Format::DCD, wide(0, 80), "does not begin with a record of 84 bytes"),
        (Format::DCD, wide(4, b'X'), "does not begin with CORD"),
        (Format::DCD, [&84i32.to_le_bytes()[..], b"VELD"].concat(), "the file has velocities"),
        (Format::DCD, wide(88, 80), "byte 88: control numbers: expected a record of 84 bytes, found 80"),
        (Format::DCD, wide(187, 0xff), "atoms"),
        (Format::DCD, wide(196, 16), "x: expected a record of 12 bytes, found 16"),
        (Format::DCD, short(little()), "z: the file ends after 3 of 4 bytes"),
    ] {
        let error = frames(format, &bytes, &["vx"]).map(drop).expect_err(message).to_string();
        assert!(error.starts_with("text: ") && error.contains(message), "{message}: {error}");
    }
}

#[test]
fn the_number_of_titles_counts_where_their_marker_is_wrong() {
    let good = dcd(PLAIN);
    // The markers at 92 and 180 are for one title.
    let mut two = good.clone();
    two[96] = 2;
    two.splice(180..180, [b' '; 80]);
    let read = |bytes: &[u8]| frames(Format::DCD, bytes, &[]).map(|found| found[1].positions.clone());
    assert_eq!(read(&two).expect("frames"), read(&good).expect("frames"));
}

#[test]
fn a_file_that_ends_early_is_never_a_whole_one() {
    let cell = Some([20.0, 0.5, 30.0, 0.0, 0.0, 40.0]);
    let files = [
        (Format::XTC, xtc()),
        (Format::TRR, trr(2, true, [&[1.0; 9], &[1.0; 6], &[2.0; 6], &[3.0; 6]])),
        (Format::DCD, dcd(How { cell, fourth: true, fixed: true, ..PLAIN })),
    ];
    for (format, bytes) in files {
        let all = frames(format, &bytes, &["vx"]).expect("frames").len();
        for at in 0..bytes.len() {
            let cut = frames(format, &bytes[..at], &["vx"]);
            assert!(cut.is_err() || cut.is_ok_and(|found| found.len() < all), "{format:?} of {at} bytes");
        }
    }
}

#[test]
fn files_of_particles_take_a_topology() {
    use crate::Frames;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file");
        path
    };
    let atoms = path("atoms.xyz", format!("12\nwater\n{}", "O 0 0 0\nH 0 0 0\nH 0 0 0\n".repeat(4)).as_bytes());
    let moved = path("moved.xtc", &xtc());
    let scene = path("scene.nff", b"s 0 0 0 1\n");
    let open = |path: &std::path::Path, topology: &std::path::Path| {
        let options = crate::ParticleOptions { topology: Some(topology.to_path_buf()), ..Default::default() };
        Frames::open(path, &options).map_err(|error| error.to_string())
    };
    let frame = open(&moved, &atoms).expect("a trajectory").next().expect("a frame").expect("read");
    assert_eq!((&frame.elements[..3], frame.positions[1]), (&[8, 1, 1][..], [0.96, -2.88, -0.02]));
    for (path, topology, message) in [
        (&scene, &atoms, "nff files contain whole scenes and take no topology"),
        (&moved, &moved, "is a trajectory, which has positions only"),
        (&moved, &scene, "is a scene, not a particle file"),
    ] {
        let error = open(path, topology).map(drop).expect_err(message);
        assert!(error.contains(message), "{error}");
    }
}
