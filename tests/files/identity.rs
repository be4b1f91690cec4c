//! The order of particles in the frames of a film, by the column that identifies them.

use halfline_files::read::{ColumnValue, Hold, Identity, Keep, ParticleOptions, ReadOptions, SceneFrame, Sequence};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Numbers that look random, by a linear congruential generator (Knuth).
struct Draw(u64);

impl Draw {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) % n as u64) as usize
    }

    /// A permutation (Fisher and Yates).
    fn shuffled(&mut self, mut list: Vec<u32>) -> Vec<u32> {
        for k in (1..list.len()).rev() {
            list.swap(k, self.below(k + 1));
        }
        list
    }
}

/// A dump of these ids, frame by frame; particle i is at (i, frame, 0), and has the type i % 3 + 1.
fn dump(frames: &[Vec<u32>]) -> String {
    let mut text = String::new();
    for (number, ids) in frames.iter().enumerate() {
        write!(text, "ITEM: TIMESTEP\n{number}\nITEM: NUMBER OF ATOMS\n{}\n", ids.len()).expect("a string");
        text.push_str("ITEM: BOX BOUNDS pp pp pp\n0 100\n0 100\n0 100\nITEM: ATOMS id type x y z\n");
        for id in ids {
            writeln!(text, "{id} {} {id} {number} 0", id % 3 + 1).expect("a string");
        }
    }
    text
}

/// The same as extended XYZ.
fn xyz(frames: &[Vec<u32>]) -> String {
    let mut text = String::new();
    for (number, ids) in frames.iter().enumerate() {
        writeln!(text, "{}\nProperties=species:S:1:pos:R:3:id:I:1", ids.len()).expect("a string");
        for id in ids {
            writeln!(text, "C {id} {number} 0 {id}").expect("a string");
        }
    }
    text
}

fn file(folder: &tempfile::TempDir, name: &str, text: &str) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("a file");
    path
}

fn options(frames: &str) -> ParticleOptions {
    let keep = Keep::Named(vec!["index".into()]);
    ParticleOptions { frames: frames.parse().expect("frames"), keep, ..ParticleOptions::default() }
}

fn read(path: &Path, particles: &ParticleOptions) -> Result<Vec<SceneFrame>, String> {
    frames_of(path, particles, Hold::default())
}

fn frames_of(path: &Path, particles: &ParticleOptions, hold: Hold) -> Result<Vec<SceneFrame>, String> {
    let options = ReadOptions { particles: particles.clone(), hold, ..ReadOptions::default() };
    let mut sequence = Sequence::open(path, &options).map_err(|error| error.to_string())?;
    std::iter::from_fn(|| sequence.next_scene().transpose())
        .collect::<Result<_, _>>()
        .map_err(|error| error.to_string())
}

/// The particle that each sphere is.
fn ids(frame: &SceneFrame) -> Vec<u32> {
    frame.scene.spheres.centers.iter().map(|center| center[0] as u32).collect()
}

fn warnings(frame: &SceneFrame) -> String {
    frame.skipped.assumed.join("; ")
}

#[test]
fn frames_have_the_order_of_the_first_whatever_their_rows() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut draw = Draw(1);
    for case in 0..40 {
        let count = 1 + draw.below(30);
        let first = draw.shuffled((0..count as u32).map(|n| 7 * n + 3).collect());
        let frames: Vec<Vec<u32>> =
            (0..4).map(|k| if k == 0 { first.clone() } else { draw.shuffled(first.clone()) }).collect();
        let (name, text) = [("a.dump", dump(&frames)), ("a.xyz", xyz(&frames))].into_iter().nth(case % 2).expect("one");
        let path = file(&folder, name, &text);
        let all = read(&path, &options("1-4")).expect("four frames");
        for (number, frame) in all.iter().enumerate() {
            assert_eq!(ids(frame), first, "case {case}, frame {}", number + 1);
            assert_eq!(warnings(frame).find("first frame"), None, "{}", warnings(frame));
            // Columns follow, and `index` is the row of the file.
            let (_, rows) = frame.columns.get("index").expect("kept");
            let row = |n: usize| match rows.value(n) {
                ColumnValue::Number(row) => row as usize,
                ColumnValue::Text(text) => panic!("a row is a number: {text}"),
            };
            let of_rows: Vec<u32> = (0..count).map(|n| frames[number][row(n)]).collect();
            assert_eq!(of_rows, first, "case {case}: the rows in the file");
        }
        // Alone as in the film, whatever holds its colours, and by columns with other names.
        for hold in [Hold::First, Hold::None] {
            let alone = frames_of(&path, &options("3"), hold).expect("a frame");
            assert_eq!((alone.len(), ids(&alone[0])), (1, first.clone()));
        }
        let named = ParticleOptions { identity: "ID".into(), ..options("2-") };
        assert_eq!(ids(&read(&path, &named).expect("frames")[1]), first);
        let by_row = ParticleOptions { identity: Identity::Row, ..options("1-4") };
        let by_row = read(&path, &by_row).expect("frames");
        assert!(by_row.iter().zip(&frames).all(|(frame, rows)| ids(frame) == *rows), "case {case}: rows as they are");
    }
}

#[test]
fn particles_that_come_and_go_are_named_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = file(&folder, "a.dump", &dump(&[vec![5, 1, 9], vec![20, 9, 5, 11], vec![9, 1, 5], vec![]]));
    let frames = read(&path, &options("1-")).expect("frames");
    let found: Vec<_> = frames.iter().map(ids).collect();
    assert_eq!(found, [vec![5, 1, 9], vec![5, 9, 11, 20], vec![5, 1, 9], vec![]]);
    let message = "1 of 3 particles of the first frame is missing: the ids of later particles hold in this frame alone";
    assert!(warnings(&frames[1]).contains(message), "{}", warnings(&frames[1]));
    assert_eq!(warnings(&frames[2]).find("missing"), None);
    let less = file(&folder, "less.dump", &dump(&[vec![5, 1, 9], vec![1, 5], vec![1, 9]]));
    let frames = read(&less, &options("1-")).expect("frames");
    assert_eq!(frames.iter().map(ids).collect::<Vec<_>>(), [vec![5, 1, 9], vec![5, 1], vec![1, 9]]);
    assert_eq!(warnings(&frames[1]).find("missing"), None, "no other particle moves up");
    assert!(
        warnings(&frames[2]).contains("1 of 3 particles of the first frame is missing"),
        "{}",
        warnings(&frames[2])
    );
    let twice = file(&folder, "twice.dump", &dump(&[vec![1, 2, 3], vec![2, 2, 1]]));
    let frames = read(&twice, &options("1-")).expect("frames");
    assert_eq!(ids(&frames[1]), [2, 2, 1]);
    assert!(warnings(&frames[1]).contains("two particles have the same id"), "{}", warnings(&frames[1]));
}

#[test]
fn a_column_that_is_named_must_be_there() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = file(&folder, "a.dump", &dump(&[vec![1, 2], vec![2, 1]]));
    let named = ParticleOptions { identity: "tag".into(), ..options("1-") };
    let error = read(&path, &named).expect_err("no column");
    assert!(error.contains("there is no column tag of numbers; the file has id, type"), "{error}");
}

#[test]
fn a_topology_gives_what_frames_lack_by_id() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let atom = |serial: u32, element: &str, chain: &str| {
        format!(
            "ATOM  {serial:>5}  {element:<3} ALA {chain}{serial:>4}    {:>8.3}{:>8.3}{:>8.3}  1.00  0.00          {element:>2}\n",
            0.0, 0.0, 0.0
        )
    };
    let atoms = [atom(3, "C", "A"), atom(1, "O", "B"), atom(2, "N", "C")].concat();
    let topology = file(&folder, "atoms.pdb", &atoms);
    let path = file(&folder, "a.dump", &dump(&[vec![1, 2, 3], vec![3, 1, 2]]));
    let keep = Keep::Named(vec!["chain".into()]);
    let with = ParticleOptions { topology: Some(topology.clone()), keep, ..options("1-") };
    let chains = |frame: &SceneFrame| -> Vec<String> {
        let chain = frame.columns.get("chain").expect("kept").1;
        let text = |n: usize| match chain.value(n) {
            ColumnValue::Text(text) => text.to_owned(),
            ColumnValue::Number(number) => number.to_string(),
        };
        (0..frame.scene.spheres.len()).map(text).collect()
    };
    for identity in [Identity::Id, Identity::Row] {
        for (number, frame) in
            read(&path, &ParticleOptions { identity: identity.clone(), ..with.clone() }).expect("ok").iter().enumerate()
        {
            // Oxygen has the serial 1, nitrogen 2, carbon 3; by rows they keep the file's order.
            let expected: &[(&str, f64)] = match identity {
                Identity::Row => &[("A", 1.7), ("B", 1.52), ("C", 1.55)],
                _ => &[("B", 1.52), ("C", 1.55), ("A", 1.7)],
            };
            let found: Vec<_> = chains(frame).into_iter().zip(frame.scene.spheres.radii.iter().copied()).collect();
            let expected: Vec<_> = expected.iter().map(|(chain, radius)| ((*chain).to_owned(), *radius)).collect();
            assert_eq!(found, expected, "{identity}, frame {}", number + 1);
        }
    }
    let error = read(&file(&folder, "b.dump", &dump(&[vec![1, 2, 7]])), &with).expect_err("no such atom");
    assert!(
        error.contains("id: there is a particle with the id 7, and the topology") && error.contains("has none"),
        "{error}"
    );
    let by_row = ParticleOptions { identity: Identity::Row, ..with };
    let error = read(&file(&folder, "c.dump", &dump(&[vec![1, 2]])), &by_row).expect_err("other atoms");
    assert!(error.contains("the trajectory has 2 atoms, the topology"), "{error}");
}
