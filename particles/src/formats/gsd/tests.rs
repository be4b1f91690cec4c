//! Tests of GSD. The sample was written by the package gsd 5.0.1 of HOOMD-blue's authors from the numbers below.

use super::*;
use crate::particles::periodic::{self, Periodic};

/// Three frames of 4, 4 and 3 particles; only the first has types, diameters and velocities. Coordinate k of a frame is
/// k / 2 and the frame's number.
const FRAMES: &[u8] = include_bytes!("samples/frames.gsd");

fn gsd(bytes: &[u8], columns: &[&str]) -> Gsd {
    Gsd::new(Source::of_bytes(bytes), Request::of(columns))
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

/// A chunk: frame, name, kind, rows, columns, bytes.
type Written = (u64, &'static str, u8, u64, u32, Vec<u8>);

/// A file of version 2 with these chunks, by the description of the file layer.
fn written(chunks: &[Written]) -> Vec<u8> {
    let mut names: Vec<&str> = Vec::new();
    for (_, name, ..) in chunks.iter().filter(|chunk| chunk.4 > 0) {
        if !names.contains(name) {
            names.push(name);
        }
    }
    let list: Vec<u8> = names.iter().flat_map(|name| [name.as_bytes(), &[0]].concat()).collect();
    let slots = list.len().div_ceil(64) + 1;
    let (index, list_at) = (256, 256 + 32 * chunks.len());
    let mut place = list_at + 64 * slots;
    let mut bytes = [0x65df_65df_65df_65df_u64, index, chunks.len() as u64, list_at as u64, slots as u64, 2 << 48]
        .map(u64::to_le_bytes)
        .concat();
    bytes.resize(112, 0);
    bytes.extend(b"hoomd");
    bytes.resize(256, 0);
    for (frame, name, kind, rows, columns, data) in chunks {
        let number = names.iter().position(|known| known == name).expect("a name") as u64;
        let rest = u64::from(*columns) | number << 32 | u64::from(*kind) << 48;
        bytes.extend([*frame, *rows, place as u64, rest].map(u64::to_le_bytes).concat());
        place += data.len();
    }
    bytes.extend(&list);
    bytes.resize(list_at + 64 * slots, 0);
    chunks.iter().for_each(|chunk| bytes.extend(&chunk.5));
    bytes
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn whole(numbers: &[i32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// The kinds of chunks: u32, i32, f32 and i8 of the file layer.
const U32: u8 = 3;
const I8: u8 = 5;
const I32: u8 = 7;
const F32: u8 = 9;

/// Two frames of two particles in a box of 10.
fn two() -> Vec<Written> {
    let frame = |frame, x: f32| (frame, POSITION, F32, 2, 3, floats(&[x, 0.0, 0.0, -4.0, 0.0, 0.0]));
    vec![
        (0, COUNT, U32, 1, 1, whole(&[2])),
        (0, "configuration/box", F32, 6, 1, floats(&[10.0, 10.0, 10.0, 0.0, 0.0, 0.0])),
        frame(0, 4.0),
        frame(1, 3.0),
    ]
}

#[test]
fn images_unwrap_a_film() {
    let xs = |chunks: &[Written]| {
        let mut frames = read(&written(chunks), &["ix", "iy", "iz", "typeid"]).expect("frames");
        let mut of = |frame: &mut Particles| {
            periodic::apply(Periodic::Unwrap, frame).map(|()| frame.positions.iter().map(|p| p[0]).collect::<Vec<_>>())
        };
        (
            frames.iter().map(|frame| frame.has.len()).collect::<Vec<_>>(),
            frames.iter_mut().map(&mut of).collect::<Vec<_>>(),
        )
    };
    let image = |frame, numbers: [i32; 6]| (frame, IMAGE, I32, 2, 3, whole(&numbers));
    let mut chunks = two();
    let (has, none) = xs(&chunks);
    assert!(has == [8, 8] && none.iter().all(Result::is_err), "no images: {has:?}");
    chunks.push(image(1, [0, 0, 0, 1, -2, 0]));
    let (has, found) = xs(&chunks);
    assert_eq!(has, [11, 11]);
    assert_eq!(found.into_iter().map(|xs| xs.expect("images")).collect::<Vec<_>>(), [[4.0, -4.0], [3.0, 6.0]]);
    // The images of the first frame hold for a frame without them.
    let mut chunks = two();
    chunks.insert(3, image(0, [-1, 0, 0, 2, 0, 0]));
    let (_, found) = xs(&chunks);
    assert_eq!(found.into_iter().map(|xs| xs.expect("images")).collect::<Vec<_>>(), [[-6.0, 16.0], [-7.0, 16.0]]);
}

#[test]
fn shapes_of_types_give_radii() {
    let of = |shapes: &[&str], more: Option<Written>| {
        let width = shapes.iter().map(|shape| shape.len() + 1).max().unwrap_or(1);
        let row = |shape: &&str| [shape.as_bytes(), &vec![0; width - shape.len()]].concat();
        let rows: Vec<u8> = shapes.iter().flat_map(row).collect();
        let mut chunks = two();
        chunks.insert(2, (0, TYPE, U32, 2, 1, whole(&[0, 1])));
        chunks.insert(3, (0, SHAPES, I8, shapes.len() as u64, width as u32, rows));
        chunks.splice(4..4, more);
        read(&written(&chunks), &[])
    };
    let ball = r#"{"type": "Sphere", "diameter": 3.0}"#;
    let round = r#"{"type": "Ellipsoid", "a": 0.25, "b": 0.25, "c": 0.25}"#;
    for (shapes, radii, warning) in [
        (&[ball, round][..], [1.5, 0.25], None),
        (&[ball], [1.5, 0.5], None),
        (&["{}", ball], [0.5, 1.5], None),
        (&["", ball], [0.5, 1.5], None),
        (
            &[r#"{"type": "Ellipsoid", "a": 1, "b": 1, "c": 2}"#, ball],
            [0.5, 1.5],
            Some("1 particle is of a shape that is no sphere (1 Ellipsoid)"),
        ),
        (
            &[r#"{"type": "ConvexPolyhedron", "rounding_radius": 0, "vertices": [[1,1,1]]}"#, r#"{"type":"Mesh"}"#],
            [0.5, 0.5],
            Some("2 particles are of a shape that is no sphere (1 ConvexPolyhedron, 1 Mesh)"),
        ),
        (
            &[r#"{"type": "Polygon"}"#; 2],
            [0.5, 0.5],
            Some("no sphere (2 Polygon), and each is drawn as a sphere of the diameter 1"),
        ),
    ] {
        let frames = of(shapes, None).expect("frames");
        assert!(frames.iter().all(|frame| frame.radii == radii), "{shapes:?}: {:?}", frames[0].radii);
        let words = &frames[0].skipped.assumed;
        assert_eq!(words.len(), usize::from(warning.is_some()), "{words:?}");
        assert!(warning.is_none_or(|warning| words[0].contains(warning)), "{words:?}");
        assert!(frames[1].skipped.assumed.is_empty(), "once for all frames");
    }
    let diameters = Some((0, DIAMETER, F32, 2, 1, floats(&[2.0, 4.0])));
    assert_eq!(of(&[ball, ball], diameters).expect("frames")[1].radii, [1.0, 2.0], "of each particle");
    for (shape, problem) in [
        ("{", "type 0: `{` is not JSON"),
        (r#"{"type": 1}"#, "type 0: the type of the shape is not a text"),
        (r#"{"type": "Sphere"}"#, "`diameter` of the shape `Sphere` is not a positive number"),
        (r#"{"type": "Sphere", "diameter": -1}"#, "`diameter` of the shape `Sphere` is not a positive number"),
        (&"[".repeat(100_000), "is not JSON (recursion limit exceeded"),
    ] {
        let error = of(&[shape], None).map(drop).expect_err(shape).to_string();
        assert!(error.contains("frame 1: particles/type_shapes: ") && error.contains(problem), "{error}");
    }
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
