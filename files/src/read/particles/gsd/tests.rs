//! Tests of GSD. The sample was written by the package gsd 5.0.1 of HOOMD-blue's authors from the numbers below.

use super::*;

/// Three frames of 4, 4 and 3 particles; only the first has types, diameters and velocities. Coordinate k of a frame is
/// k / 2 and the frame's number.
const FRAMES: &[u8] = include_bytes!("samples/frames.gsd");

fn gsd(bytes: &[u8], columns: &[&str]) -> Gsd {
    Gsd::new(SceneSource::of_bytes(bytes), Request::of(columns))
}

fn read(bytes: &[u8], columns: &[&str]) -> Result<Vec<Particles>> {
    let mut gsd = gsd(bytes, columns);
    std::iter::from_fn(|| gsd.next().transpose()).collect()
}

#[test]
fn frames_have_what_they_lack_from_the_first_or_from_the_schema() {
    let frames = read(FRAMES, &["type", "vy", "mass"]).expect("frames");
    assert_eq!(frames.iter().map(|frame| frame.positions.len()).collect::<Vec<_>>(), [4, 4, 3]);
    for (n, frame) in frames.iter().enumerate() {
        let expected = |k: usize| [0, 1, 2].map(|axis| (3 * k + axis) as f64 / 2.0 + n as f64);
        assert!(frame.positions.iter().enumerate().all(|(k, position)| *position == expected(k)), "{n}");
        let names: Vec<&str> = frame.columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["type", "mass", "vy"]);
        assert_eq!(frame.columns[1].values, vec![1.0; frame.positions.len()], "of the schema");
    }
    assert_eq!(frames[0].radii, [0.5, 0.75, 1.0, 1.25]);
    assert_eq!(frames[1].radii, frames[0].radii, "of the first frame");
    assert_eq!(frames[2].radii, [0.5; 3], "another number of particles");
    assert_eq!(
        (&frames[1].columns[0].values[..], &frames[1].labels["type"][..2]),
        (&[0.0, 1.0, 0.0, 1.0][..], &["A".into(), "long".into()][..])
    );
    assert_eq!(frames[2].columns[0].values, [0.0; 3]);
    // Velocities of the first frame are zero, so they are not written.
    assert_eq!(frames[0].columns[2].values, [0.0; 4]);
    let cell = frames[0].cell.expect("a box");
    // The tilts 0.1, 0.2 and 0.3 are float32.
    let tilt = |x: f32, length: f64| f64::from(x) * length;
    let edges = [[20.0, 0.0, 0.0], [tilt(0.1, 30.0), 30.0, 0.0], [tilt(0.2, 40.0), tilt(0.3, 40.0), 40.0]];
    assert_eq!((cell.edges, cell.origin[2]), (edges, -20.0));
    let mut passed = gsd(FRAMES, &[]);
    assert!(passed.skip().expect("one") && passed.skip().expect("two"));
    assert_eq!(passed.next().expect("read").expect("the third").positions.len(), 3);
    assert!(!passed.skip().expect("the end"));
}

#[test]
fn types_have_numbers_and_names() {
    let frame = read(FRAMES, &["typeid", "type"]).expect("frames").remove(0);
    assert_eq!((&frame.columns[0].name[..], &frame.columns[0].values[..]), ("typeid", &[0.0, 1.0, 0.0, 1.0][..]));
    assert!(frame.labels.contains_key("type") && !frame.labels.contains_key("typeid"));
}

#[test]
fn errors_are_reported() {
    let with = |at: usize, byte: u8| {
        let mut bytes = FRAMES.to_vec();
        bytes[at] = byte;
        bytes
    };
    for (bytes, message) in [
        (with(0, 0), "byte 0: header: the file does not begin"),
        (with(112, b'X'), "byte 112: schema: the schema is `Xoomd`"),
        (with(15, 1), "byte 8: index: "),
        (with(23, 1), "byte 8: index: "),
        (with(31, 1), "byte 24: names: "),
        (FRAMES[..299].to_vec(), "are not in the file of 299 bytes"),
        (FRAMES[..199].to_vec(), "byte 0: header"),
    ] {
        let error = read(&bytes, &[]).map(drop).expect_err(message).to_string();
        assert!(error.contains(message), "{message}: {error}");
    }
}
