//! The promise of frames on disk: files hold the rendered values, other programs read them, and they are written completely or
//! not at all.

use crate::numpy::{npy as foreign, python_or_skip};
use halfline::error::Error;
use halfline::frame::provenance::Origin;
use halfline::frame::{Aov, Buffer, Data, Frame};
use halfline::report::Report;
use halfline::settings::Settings;
use halfline::window::Window;
use halfline_files::write::buffers::FrameFile;
use halfline_files::write::file::{Target, check_writable, write_atomically};
use halfline_files::write::format::FormatOptions;
use halfline_files::write::{npy, png as picture};
use halfline_measure::Values;
use std::fs;
use std::io::{self, Cursor, Write};
use std::path::Path;

const SIZE: [usize; 2] = [5, 3];

/// One buffer of every kind, with special values.
fn buffers() -> Vec<Buffer> {
    let awkward = [0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MIN_POSITIVE, 5e-324, 1e300, 0.1, -1.5];
    Aov::ALL
        .into_iter()
        .map(|aov| {
            let n = SIZE[0] * SIZE[1] * aov.channels(2);
            let float = |i: usize| awkward[i % awkward.len()];
            let data = match aov.dtype() {
                "float32" => Data::F32((0..n).map(|i| float(i) as f32).collect()),
                "float64" => Data::F64((0..n).map(float).collect()),
                "int32" => Data::I32((0..n as i32).map(|i| if i == 3 { i32::MIN } else { i - 1 }).collect()),
                _ => Data::U8((0..n).map(|i| (i * 37) as u8).collect()),
            };
            Buffer::new(aov, SIZE[0], SIZE[1], data).expect("a whole buffer")
        })
        .collect()
}

/// A frame of that one buffer.
fn frame(buffer: &Buffer) -> Frame {
    let [width, height] = [buffer.shape[1] as u32, buffer.shape[0] as u32];
    let window = Window::full(width, height);
    Frame {
        width,
        height,
        window,
        full: [width, height],
        buffers: vec![buffer.clone()],
        coverage: None,
        report: Report::default(),
    }
}

/// Writes it as a rendering of the scene "s".
fn write_to(target: &Target, frame: &Frame) -> halfline::Result<()> {
    let (report, fingerprint) = (&frame.report, "s".to_owned());
    let (tolerance, seed) = (Settings::default().promise().relative(), 0);
    target.write(frame, &Origin { fingerprint, tolerance, seed, report, window: frame.window, full: frame.full })
}

fn npy_of(buffer: &Buffer) -> Vec<u8> {
    let mut bytes = Vec::new();
    npy::write(buffer, &mut bytes).expect("written to memory");
    bytes
}

/// A picture with every level in each component.
fn ramp() -> Buffer {
    let linear = |level: usize| {
        let encoded = level as f64 / 255.0;
        let x = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
        x as f32
    };
    let data = (0..256).flat_map(|level| [linear(level), linear(255 - level), linear(level * 7 % 256)]).collect();
    Buffer::new(Aov::Color, 32, 8, Data::F32(data)).expect("a whole picture")
}

fn words() -> Vec<(String, String)> {
    [("Software", "halfline"), ("Scene", "Kugeln für Ωμέγα 球.toml"), ("Comment", "")]
        .map(|(keyword, text)| (keyword.into(), text.into()))
        .to_vec()
}

fn png_of(buffer: &Buffer) -> Vec<u8> {
    let mut bytes = Vec::new();
    picture::write(buffer, &words(), &mut bytes).expect("written to memory");
    bytes
}

/// A .npy file of little-endian bytes, put together from the format's own description (numpy.lib.format, version 1.0).
fn npy_file(descr: &str, shape: &[usize], data: Vec<u8>) -> Vec<u8> {
    let sides: String = shape.iter().map(|side| format!("{side}, ")).collect();
    let mut text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({sides}), }}");
    while (10 + text.len() + 1) % 64 != 0 {
        text.push(' ');
    }
    text.push('\n');
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend([text.len() as u8, (text.len() >> 8) as u8]);
    file.extend(text.bytes());
    file.extend(data);
    file
}

#[test]
fn npy_has_version_1_the_documented_types_and_every_bit() {
    let types = ["<f4", "<f8", "<f8", "<f4", "<f8", "<i4", "|u1", "|u1", "<f8"];
    for (buffer, dtype) in buffers().iter().zip(types) {
        let bytes = npy_of(buffer);
        let data: Vec<u8> = match &buffer.data {
            Data::F32(values) => values.iter().flat_map(|x| x.to_bits().to_le_bytes()).collect(),
            Data::F64(values) => values.iter().flat_map(|x| x.to_bits().to_le_bytes()).collect(),
            Data::I32(values) => values.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Data::U8(values) => values.clone(),
            other => panic!("{} has {} values", buffer.aov, other.dtype()),
        };
        assert!(bytes == npy_file(dtype, &buffer.shape, data), "{}", buffer.aov);
        let array = FrameFile::from_bytes(&bytes, "memory").expect("halfline reads it").buffers.remove(0).array;
        assert_eq!(array.shape(), buffer.shape);
        match (&buffer.data, array.values()) {
            (Data::F32(written), Values::F32(read)) => {
                assert!(written.iter().zip(read).all(|(a, b)| a.to_bits() == b.to_bits()), "{}", buffer.aov);
            }
            (Data::F64(written), Values::F64(read)) => {
                assert!(written.iter().zip(read).all(|(a, b)| a.to_bits() == b.to_bits()), "{}", buffer.aov);
            }
            (Data::I32(written), Values::I32(read)) => assert_eq!(written, read),
            (Data::U8(written), Values::U8(read)) => assert_eq!(written, read),
            (written, read) => panic!("{} was read as {}", written.dtype(), read.dtype()),
        }
    }
}

#[test]
fn numpy_reads_npy() {
    let Some(python) = python_or_skip() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    for buffer in buffers() {
        let path = folder.path().join("buffer.npy");
        fs::write(&path, npy_of(&buffer)).expect("written");
        let script = "import numpy,sys; a=numpy.load(sys.argv[1]); print(a.dtype, list(a.shape), a.tobytes().hex())";
        let output = std::process::Command::new(&python).args(["-c", script]).arg(&path).output().expect("python runs");
        let bytes = match &buffer.data {
            Data::F32(values) => bytemuck::cast_slice(values),
            Data::F64(values) => bytemuck::cast_slice(values),
            Data::I32(values) => bytemuck::cast_slice(values),
            Data::U8(values) => &values[..],
            _ => panic!("a new kind of data"),
        };
        let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        let expected = format!("{} {:?} {hex}\n", buffer.data.dtype(), buffer.shape);
        assert_eq!(String::from_utf8_lossy(&output.stdout), expected, "{}", buffer.aov);
    }
}

#[test]
fn npy_of_other_programs_is_read() {
    let read = |header: &str, data: &[u8]| {
        let array = FrameFile::from_bytes(&foreign(header, data), "foreign").expect("readable").buffers.remove(0).array;
        (array.shape().to_vec(), array.values().clone())
    };
    let columns = "{'descr': '>i2', 'fortran_order': True, 'shape': (2, 3), }\n";
    let expected = Values::I32(vec![0, 2, 4, 1, 3, -1]);
    assert_eq!(read(columns, &[0, 0, 0, 1, 0, 2, 0, 3, 0, 4, 255, 255]), (vec![2, 3], expected));
    let spaced = "{ \"shape\" : (3,), \"fortran_order\":False, \"descr\":\"|b1\" }";
    assert_eq!(read(spaced, &[0, 1, 7]), (vec![3], Values::U8(vec![0, 1, 1])));
    let scalar = "{'descr': '>f8', 'fortran_order': False, 'shape': ()}";
    assert_eq!(read(scalar, &1.5f64.to_be_bytes()), (vec![], Values::F64(vec![1.5])));
    let wide = "{'descr': '<u4', 'fortran_order': False, 'shape': (1,)}";
    assert_eq!(read(wide, &[255; 4]), (vec![1], Values::I64(vec![u32::MAX.into()])));
    let cube = "{'descr': '|u1', 'fortran_order': True, 'shape': (2, 2, 2)}";
    assert_eq!(read(cube, &[0, 1, 2, 3, 4, 5, 6, 7]), (vec![2, 2, 2], Values::U8(vec![0, 4, 2, 6, 1, 5, 3, 7])));
}

#[test]
fn a_malformed_file_is_refused_by_name() {
    let plain = |shape: &str| format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}");
    let whole = npy_of(&buffers()[1]);
    let picture = png_of(&ramp());
    let mut crooked = picture.clone();
    let inside = crooked.len() - 100;
    crooked[inside] ^= 1;
    let mut cases = vec![
        b"".to_vec(),
        b"P6 1 1 255".to_vec(),
        b"\x93NUMPY\x09\x00\x01\x00{".to_vec(),
        foreign("nothing", &[]),
        foreign(&plain("(2,)"), &[0; 15]),
        foreign(&plain("(4294967296, 4294967296)"), &[0; 16]),
        foreign(&plain("(4294967296, 0, 4294967296, 4294967296)"), &[]),
        foreign(&plain("(-1,)"), &[0; 8]),
        foreign(&plain("(1"), &[0; 8]),
        foreign("{'descr': '|O', 'fortran_order': False, 'shape': (1,)}", &[0; 8]),
        foreign("{'descr': '<c8', 'fortran_order': False, 'shape': (1,)}", &[0; 8]),
        foreign("{'descr': '<é8', 'fortran_order': False, 'shape': (1,)}", &[0; 8]),
        foreign("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (1,)}", &[0; 8]),
        foreign(&"(".repeat(60_000), &[]),
        crooked,
    ];
    cases.extend((0..whole.len()).step_by(7).map(|n| whole[..n].to_vec()));
    cases.extend((0..picture.len()).step_by(7).map(|n| picture[..n].to_vec()));
    for bytes in cases {
        let error = FrameFile::from_bytes(&bytes, "bad.file").expect_err("must not be read");
        assert!(matches!(error, Error::Scene { .. }), "{error}");
        assert!(error.to_string().starts_with("bad.file: "), "{error}");
    }
}

#[test]
fn png_keeps_every_level() {
    let levels: Vec<u8> =
        (0..256usize).flat_map(|level| [level, 255 - level, level * 7 % 256].map(|level| level as u8)).collect();
    let array = FrameFile::from_bytes(&png_of(&ramp()), "ramp.png").expect("readable").buffers.remove(0).array;
    assert!(array.is_picture());
    assert_eq!(array.shape(), [8, 32, 3]);
    assert_eq!(*array.values(), Values::U8(levels.clone()));
    let others = image::load_from_memory(&png_of(&ramp())).expect("the image crate reads it");
    assert_eq!(others.as_rgb8().map(|rgb| rgb.as_raw()), Some(&levels));
}

#[test]
fn png_has_its_provenance_and_is_srgb() {
    let bytes = png_of(&ramp());
    let reader = png::Decoder::new(Cursor::new(&bytes)).read_info().expect("readable");
    let info = reader.info();
    assert_eq!(info.srgb, Some(png::SrgbRenderingIntent::Perceptual));
    let found: Vec<_> = info.utf8_text.iter().map(|c| (c.keyword.clone(), c.get_text().expect("text"))).collect();
    assert_eq!(found, words());
    assert!(!bytes.windows(4).any(|name| name == b"tIME"), "no date");
}

#[test]
fn the_same_frame_gives_the_same_bytes() {
    assert_eq!(png_of(&ramp()), png_of(&ramp()));
    for buffer in buffers() {
        assert_eq!(npy_of(&buffer), npy_of(&buffer));
    }
}

/// Every colour type and depth PNG has, through the reader.
#[test]
fn png_of_any_colour_type_is_read() {
    use png::{BitDepth, ColorType};
    type Case<'a> = (ColorType, BitDepth, &'a [u8], &'a [usize], Values);
    let cases: [Case; 7] = [
        (ColorType::Grayscale, BitDepth::One, &[0b0100_0000], &[1, 2], Values::U8(vec![0, 255])),
        (ColorType::Grayscale, BitDepth::Eight, &[3, 4], &[1, 2], Values::U8(vec![3, 4])),
        (ColorType::Grayscale, BitDepth::Sixteen, &[1, 2, 3, 4], &[1, 2], Values::U16(vec![258, 772])),
        (ColorType::GrayscaleAlpha, BitDepth::Eight, &[1, 2, 3, 4], &[1, 2, 2], Values::U8(vec![1, 2, 3, 4])),
        (ColorType::Indexed, BitDepth::Eight, &[1, 0], &[1, 2, 3], Values::U8(vec![4, 5, 6, 1, 2, 3])),
        (ColorType::Rgba, BitDepth::Eight, &[9; 8], &[1, 2, 4], Values::U8(vec![9; 8])),
        (ColorType::Rgb, BitDepth::Sixteen, &[1; 12], &[1, 2, 3], Values::U16(vec![257; 6])),
    ];
    for (color, depth, samples, shape, values) in cases {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if color == ColorType::Indexed {
            encoder.set_palette(&[1, 2, 3, 4, 5, 6][..]);
        }
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(samples).expect("samples");
        writer.finish().expect("an end");
        let array = FrameFile::from_bytes(&bytes, "any.png").expect("readable").buffers.remove(0).array;
        assert_eq!((array.shape(), array.values()), (shape, &values), "{color:?} {depth:?}");
    }
}

fn names(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).expect("a folder");
    names.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
}

#[test]
fn a_failing_writer_leaves_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("half.npy");
    let half = |out: &mut dyn Write| {
        out.write_all(&[1; 1 << 17])?;
        Err(io::Error::other("a failing writer"))
    };
    let error = write_atomically(&path, half).expect_err("must fail");
    assert!(matches!(&error, Error::Io { action: "write", .. }), "{error}");
    assert!(error.to_string().contains("half.npy") && error.to_string().contains("a failing writer"), "{error}");
    assert_eq!(names(folder.path()), [""; 0]);

    fs::write(&path, "before").expect("written");
    write_atomically(&path, half).expect_err("must fail");
    assert_eq!(fs::read(&path).expect("still there"), b"before");
    write_atomically(&path, |out| out.write_all(b"after")).expect("written");
    assert_eq!(fs::read(&path).expect("there"), b"after");
    assert_eq!(names(folder.path()), ["half.npy"]);
}

#[test]
fn a_target_writes_what_readers_read() {
    let folder = tempfile::tempdir().expect("a folder");
    for buffer in buffers() {
        let path = folder.path().join(format!("{}.npy", buffer.aov));
        let target = Target::new(&[buffer.aov], &path, FormatOptions::default()).expect("any buffer can be .npy");
        target.check().expect("writable");
        assert_eq!(names(folder.path()), [""; 0], "checking leaves no file");
        write_to(&target, &frame(&buffer)).expect("written");
        let bytes = fs::read(&path).expect("there");
        let (array, alone) = (npy_of(&buffer).len(), npy_of(&buffer));
        assert_eq!(bytes[..array], alone);
        assert!(bytes[array..].starts_with(b"\nhalfline {\"Software\":"), "and the provenance");
        fs::remove_file(&path).expect("removed");
    }
    let path = folder.path().join("ramp.PNG");
    let target = Target::new(&[Aov::Color], &path, FormatOptions::default()).expect("a target");
    write_to(&target, &frame(&ramp())).expect("written");
    let levels =
        |bytes: &[u8]| FrameFile::from_bytes(bytes, "ramp").expect("readable").buffers[0].array.values().clone();
    assert_eq!(levels(&fs::read(&path).expect("there")), levels(&png_of(&ramp())));
}

#[test]
fn a_target_refuses_buffers_that_it_cannot_hold() {
    for (aovs, name, offer) in [
        (&[Aov::Certainty][..], "c.png", "use the file name extension .exr, .npy, .npz or .raw"),
        (
            &[Aov::Color],
            "picture.bmp",
            "use the file name extension .png, .exr, .npy, .npz, .pfm, .raw, .tif, .jpg or .webp",
        ),
        (&[Aov::Mask], "mask.pfm", "use the file name extension .png, .exr, .npy, .npz or .raw"),
        (&[Aov::Color], ".png", "use the file name extension .png, .exr, .npy, .npz, .pfm, .raw, .tif, .jpg or .webp"),
        (&[Aov::Depth, Aov::Id], "both.npy", "use the file name extension .exr or .npz"),
        (&[Aov::Depth, Aov::Id], "-", "use the file name extension .exr or .npz"),
    ] {
        let error = Target::new(aovs, Path::new(name), FormatOptions::default()).expect_err("must be refused");
        assert!(matches!(error, Error::Settings { .. }), "{error}");
        assert!(error.to_string().starts_with(name) && error.to_string().ends_with(offer), "{error}");
    }
    let standard = Target::new(&[Aov::Depth], Path::new("-"), FormatOptions::default()).expect("standard output");
    assert!(standard.is_standard());
    let folder = tempfile::tempdir().expect("a folder");
    let target =
        Target::new(&[Aov::Depth], &folder.path().join("depth.npy"), FormatOptions::default()).expect("a target");
    let mut short = buffers().swap_remove(2);
    short.shape[0] += 1;
    for wrong in [&buffers()[1], &short] {
        let error = write_to(&target, &frame(wrong)).expect_err("must be refused");
        assert!(matches!(error, Error::Settings { .. }), "{error}");
    }
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn a_missing_folder_is_found_before_any_work() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    fs::write(&file, "").expect("written");
    for bad in [folder.path().join("none/out.npy"), file.join("out.npy"), folder.path().to_path_buf()] {
        let error = check_writable(&bad).expect_err("must be refused");
        assert!(matches!(&error, Error::Io { action: "write", path, .. } if *path == bad), "{error}");
        let written = write_atomically(&bad, |out| out.write_all(b"x"));
        assert!(matches!(written, Err(Error::Io { .. })), "{}", bad.display());
    }
    check_writable(&folder.path().join("out.npy")).expect("writable");
    check_writable(Path::new("out.npy")).expect("the working folder is writable");
    assert_eq!(names(folder.path()), ["file"]);
}

#[cfg(unix)]
#[test]
fn files_have_the_mode_of_ordinary_files() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let mode = |name: &str| fs::metadata(folder.path().join(name)).expect("there").permissions().mode() & 0o777;
    let write = |name: &str| write_atomically(&folder.path().join(name), |out| out.write_all(b"x")).expect("written");
    fs::write(folder.path().join("plain"), "").expect("written");
    write("ours");
    assert_eq!(mode("ours"), mode("plain"), "a new file follows the umask");

    fs::set_permissions(folder.path().join("plain"), fs::Permissions::from_mode(0o640)).expect("set");
    std::os::unix::fs::symlink("plain", folder.path().join("link")).expect("linked");
    write("link");
    assert!(fs::symlink_metadata(folder.path().join("link")).expect("there").is_symlink(), "a link stays one");
    assert_eq!((fs::read(folder.path().join("plain")).expect("there"), mode("plain")), (b"x".to_vec(), 0o640));

    write_atomically(Path::new("/dev/null"), |out| out.write_all(b"x")).expect("written");
    assert!(!fs::metadata("/dev/null").expect("there").is_file(), "a device stays one");
}

#[test]
fn the_names_of_buffers_are_parsed() {
    for aov in Aov::ALL {
        assert_eq!(aov.name().parse::<Aov>().expect("its own name"), aov);
    }
    let error = "colour".parse::<Aov>().expect_err("no such buffer");
    assert!(matches!(error, Error::Settings { .. }));
    assert!(Aov::ALL.iter().all(|aov| error.to_string().contains(aov.name())), "{error}");
}
