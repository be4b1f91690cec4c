//! The promise of every format: it stores the rendered values by its documented arithmetic, with their provenance; a truncated
//! file is not read; the same frame gives the same bytes.

use crate::numpy::python_or_skip;
use crate::random_frames::{cut, frame, origin};
use crate::rng::Rng;
use halfline::frame::{Aov, Data, Frame};
use halfline::quote::setting::UNIT;
use halfline::settings::Settings;
use halfline::window::Window;
use halfline_files::write::buffers::FrameFile;
use halfline_files::write::file::Target;
use halfline_files::write::format::{Bits, FileFormat, FormatOptions, NoReturn};
use halfline_files::write::image_file::{ImageFile, SampleType};
use std::path::Path;
use std::process::Command;

/// A random part of a frame.
fn random_window(rng: &mut Rng, [width, height]: [u32; 2]) -> Window {
    let (x0, y0) = (rng.within(0, width), rng.within(0, height));
    Window { x0, y0, x1: rng.within(x0, width) + 1, y1: rng.within(y0, height) + 1 }
}

/// Writes the file of `frame` and reads it back.
pub(crate) fn written(frame: &Frame, target: &Target) -> (Vec<u8>, ImageFile) {
    let settings = Settings::default();
    target.write(frame, &origin(frame, &settings, "scene")).expect("written");
    let bytes = std::fs::read(target.path()).expect("there");
    let image_file = read(target.path());
    assert_eq!(image_file.format, target.format());
    (bytes, image_file)
}

/// The file's content.
fn read(path: &Path) -> ImageFile {
    ImageFile::read(path).unwrap_or_else(|error| panic!("{error}"))
}

/// Every value of a buffer, in f64.
fn values(frame: &Frame, aov: Aov) -> Vec<f64> {
    match &frame.get(aov).expect("every buffer is there").data {
        Data::F32(values) => values.iter().map(|x| f64::from(*x)).collect(),
        Data::F64(values) => values.clone(),
        Data::I32(values) => values.iter().map(|x| f64::from(*x)).collect(),
        Data::U8(values) => values.iter().map(|x| f64::from(*x)).collect(),
        _ => panic!("a new kind of data"),
    }
}

/// Every sample of a buffer, in f64.
pub(crate) fn samples(file: &ImageFile, layer: usize) -> Vec<f64> {
    let kind = file.head.forms[layer].kind;
    let number = |bytes: &[u8]| match kind {
        SampleType::U8 => f64::from(bytes[0]),
        SampleType::U16 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        SampleType::U32 => f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        SampleType::I32 => f64::from(i32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        SampleType::F32 => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        SampleType::F64 => f64::from_le_bytes(bytes.try_into().expect("eight")),
        _ => panic!("a new kind of sample"),
    };
    file.samples[layer].chunks_exact(kind.size()).map(number).collect()
}

/// The transfer function of IEC 61966-2-1 in this number of levels.
fn srgb(linear: f64, levels: f64) -> f64 {
    let x = linear.clamp(0.0, 1.0);
    (levels * if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }).round()
}

/// The values that a format stores of a buffer, by its documentation.
fn expected(frame: &Frame, aov: Aov, format: FileFormat, style: &FormatOptions) -> Vec<f64> {
    let levels = if style.bits == Bits::Sixteen { 65535.0 } else { 255.0 };
    let single = |x: f64| if matches!(format, FileFormat::Exr | FileFormat::Pfm) { f64::from(x as f32) } else { x };
    let length = |x: f64| match style.no_return {
        _ if x.is_finite() => single(x),
        NoReturn::Inf => f64::INFINITY,
        NoReturn::Nan => f64::NAN,
        NoReturn::Zero => 0.0,
    };
    let found = values(frame, aov);
    let map = |store: &dyn Fn(f64) -> f64| found.iter().map(|x| store(*x)).collect();
    match (format, aov) {
        (FileFormat::Png, Aov::Color) if style.transparent => {
            let alpha = values(frame, Aov::Alpha);
            let straight = |(rgb, a): (&[f64], &f64)| {
                let level = |x: &f64| srgb(if *a > 0.0 { f64::from(*x as f32 / *a as f32) } else { 0.0 }, levels);
                [level(&rgb[0]), level(&rgb[1]), level(&rgb[2]), (levels * a).round()]
            };
            found.chunks(3).zip(&alpha).flat_map(straight).collect()
        }
        (FileFormat::Png, Aov::Color) => map(&|x| srgb(x, levels)),
        (FileFormat::Png, Aov::Alpha | Aov::Occlusion) => map(&|x| (levels * x).round()),
        (FileFormat::Png, Aov::Normal) => map(&|x| (levels * (x + 1.0) / 2.0).round()),
        (FileFormat::Png, Aov::Mask) => map(&|x| 255.0 * x),
        (FileFormat::Png, Aov::Id) => map(&|x| x + 1.0),
        (FileFormat::Png, _) => {
            map(&|x| if x.is_finite() { (x / style.unit).round().clamp(1.0, 65535.0) } else { 0.0 })
        }
        (_, Aov::Distance | Aov::Depth) => map(&length),
        (FileFormat::Exr, Aov::Id) => map(&|x| if x < 0.0 { 4_294_967_295.0 } else { x }),
        _ => map(&single),
    }
}

pub(crate) fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a == b || a.is_nan() && b.is_nan())
}

/// Three styles that differ in every field.
pub(crate) fn styles() -> [FormatOptions; 3] {
    let plain = FormatOptions::default();
    [
        plain,
        FormatOptions {
            bits: Bits::Sixteen,
            unit: 0.01,
            no_return: NoReturn::Nan,
            transparent: true,
            dpi: "600".parse().ok(),
        },
        FormatOptions { unit: 0.25, no_return: NoReturn::Zero, transparent: true, ..plain },
    ]
}

#[test]
fn random_parts_of_random_frames_are_read_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut rng = Rng::new(7);
    for n in 0..12 {
        let full = [rng.within(1, 40), rng.within(1, 30)];
        let window = random_window(&mut rng, full);
        let whole = cut(&frame(n, full), window);
        let few = with_small_ids(&whole);
        for format in FileFormat::ALL.into_iter().filter(|format| format.is_read()) {
            for style in styles() {
                for aov in Aov::ALL.into_iter().filter(|aov| format.takes(*aov)) {
                    let path = folder.path().join(format!("one{}", format.ending()));
                    let part = if (format, aov) == (FileFormat::Png, Aov::Id) { &few } else { &whole };
                    let target = Target::new(&[aov], &path, style).expect("a target");
                    let (bytes, image_file) = written(part, &target);
                    assert_eq!((image_file.head.window, image_file.head.full), (window, full));
                    let found = samples(&image_file, 0);
                    let what = format!("{aov} as {format:?} of {window} in {full:?} with {style:?}");
                    let reference = expected(part, aov, format, &style);
                    // A level of the normal may fall between two: n + 1 is rounded once, in f32.
                    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1.0;
                    let whole = if (format, aov) == (FileFormat::Png, Aov::Normal) {
                        found.len() == reference.len() && found.iter().zip(&reference).all(near)
                    } else {
                        same(&found, &reference)
                    };
                    assert!(whole, "{what}");
                    assert_eq!(written(part, &target).0, bytes, "{what}: the same bytes");
                }
            }
        }
    }
}

/// The same frame with ids up to 65534, the largest in a PNG.
fn with_small_ids(frame: &Frame) -> Frame {
    let mut few = frame.clone();
    for buffer in &mut few.buffers {
        if let Data::I32(ids) = &mut buffer.data {
            ids.iter_mut().filter(|id| **id >= 0).for_each(|id| *id %= 65535);
            ids[0] = 65534;
        }
    }
    few
}

#[test]
fn ids_that_a_png_cannot_hold_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ids.png");
    let mut frame = with_small_ids(&frame(1, [9, 5]));
    let target = Target::new(&[Aov::Id], &path, FormatOptions::default()).expect("a target");
    for buffer in &mut frame.buffers {
        if let Data::I32(ids) = &mut buffer.data {
            ids[3] = 65535;
        }
    }
    let origin = origin(&frame, &Settings::default(), "scene");
    let error = target.write(&frame, &origin).expect_err("65536 is no 16-bit number").to_string();
    assert!(error.contains("the id 65535") && error.contains(".npy or .exr"), "{error}");
    assert!(!path.exists(), "no file is left");
}

#[test]
fn one_file_holds_all_buffers() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = frame(3, [17, 9]);
    let part = cut(&whole, random_window(&mut Rng::new(4), [17, 9]));
    for (frame, format) in
        [(&whole, FileFormat::Exr), (&part, FileFormat::Exr), (&whole, FileFormat::Npz), (&part, FileFormat::Npz)]
    {
        let path = folder.path().join(format!("all{}", format.ending()));
        let target = Target::new(&Aov::ALL, &path, FormatOptions::default()).expect("a target");
        let (bytes, image_file) = written(frame, &target);
        assert_eq!(image_file.head.forms.iter().map(|form| form.aov).collect::<Vec<_>>(), Aov::ALL);
        for (layer, aov) in Aov::ALL.into_iter().enumerate() {
            let reference = expected(frame, aov, format, &FormatOptions::default());
            assert!(same(&samples(&image_file, layer), &reference), "{aov} as {format:?}");
        }
        assert_eq!(written(frame, &target).0, bytes, "the same bytes");
    }
}

#[test]
fn provenance_names_all_that_the_bytes_depend_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let part = cut(&frame(1, [8, 6]), halfline::Window { x0: 1, y0: 2, x1: 8, y1: 5 });
    let style = styles()[1];
    let says = |aov: Aov, name: &str| {
        let target = Target::new(&[aov], &folder.path().join(name), style).expect("a target");
        written(&part, &target).1.head.provenance
    };
    let color = says(Aov::Color, "a.png");
    let words: Vec<_> = color.words().iter().map(|(key, text)| [key.as_str(), text.as_str()]).collect();
    let known = [
        ["Software", "halfline 0.0.0"],
        ["halfline:scene", "scene"],
        ["halfline:adapter", "a test's"],
        ["halfline:driver", "Ω \"5\""],
        ["halfline:method", "stable"],
        ["halfline:accuracy", "certified"],
        ["halfline:tolerance", "1e-5"],
        ["halfline:shade", "headlight"],
        ["halfline:frame", "8x6"],
        ["halfline:window", "1,2,8,5"],
        ["halfline:buffers", "color,alpha"],
        ["halfline:bits", "16"],
        ["halfline:transparent", "true"],
        ["halfline:dpi", "600"],
    ];
    let (hash, others) = words.split_last().expect("words");
    assert_eq!(others, known);
    assert!(hash[0] == "halfline:pixels" && hash[1].len() == 32, "{hash:?}");
    assert_eq!(says(Aov::Depth, "a.png").get("halfline:unit"), Some("0.01"));
    for ending in ["exr", "npy", "npz", "pfm"] {
        let depth = says(Aov::Depth, &format!("a.{ending}"));
        assert_eq!((depth.get("halfline:no-return"), depth.get("halfline:unit")), (Some("nan"), None), "{ending}");
        assert_eq!((depth.get("halfline:shade"), depth.get("halfline:dpi")), (None, None), "{ending}");
    }
}

#[test]
fn a_truncated_file_is_not_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let part = cut(&frame(2, [20, 12]), halfline::Window { x0: 3, y0: 1, x1: 19, y1: 12 });
    for format in FileFormat::ALL.into_iter().filter(|format| format.is_read()) {
        let path = folder.path().join(format!("cut{}", format.ending()));
        let target = Target::new(&[Aov::Color], &path, FormatOptions::default()).expect("a target");
        let (bytes, _) = written(&part, &target);
        let (settings, step) = (Settings::default(), bytes.len() / 60 + 1);
        assert!(target.is_there(&origin(&part, &settings, "scene"), &|| true), "{format:?}");
        for n in (0..bytes.len()).step_by(step).chain([bytes.len() - 1]) {
            std::fs::write(&path, &bytes[..n]).expect("written");
            let error = ImageFile::read(&path).expect_err("must not be read");
            assert!(matches!(error, halfline::Error::Scene { .. }), "{format:?} after {n}: {error}");
            assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
            assert!(!target.is_there(&origin(&part, &settings, "scene"), &|| true), "{format:?} after {n}");
        }
    }
}

#[test]
fn a_damaged_byte_is_found_where_the_format_has_a_checksum() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["a.png", "a.npz"] {
        let target = Target::new(&[Aov::Color], &folder.path().join(name), FormatOptions::default()).expect("a target");
        let (bytes, _) = written(&frame(4, [20, 12]), &target);
        // The middle of the file is samples.
        let mut damaged = bytes.clone();
        damaged[bytes.len() / 2] ^= 4;
        let error = ImageFile::from_bytes(&damaged, name).expect_err("damaged").to_string();
        assert!(error.starts_with(&format!("{name}: the ")) && error.contains("damaged"), "{error}");
    }
}

#[test]
fn bytes_behind_the_provenance_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = frame(5, [6, 4]);
    for name in ["depth.npy", "depth.pfm"] {
        let target = Target::new(&[Aov::Depth], &folder.path().join(name), FormatOptions::default()).expect("a target");
        let (mut bytes, _) = written(&whole, &target);
        if name.ends_with("npy") {
            assert_eq!(FrameFile::from_bytes(&bytes, name).expect("readable").buffers[0].array.shape(), [4, 6]);
        }
        bytes.push(b'\n');
        ImageFile::from_bytes(&bytes, name).expect_err("more than we wrote");
        if name.ends_with("npy") {
            FrameFile::from_bytes(&bytes, name).expect_err("more than we wrote");
        }
    }
}

#[test]
fn raw_is_the_numbers_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = frame(6, [5, 3]);
    let target =
        Target::new(&[Aov::Depth], &folder.path().join("depth.raw"), FormatOptions::default()).expect("a target");
    let settings = Settings::default();
    target.write(&whole, &origin(&whole, &settings, "scene")).expect("written");
    let bytes = std::fs::read(target.path()).expect("there");
    let numbers: Vec<u8> = values(&whole, Aov::Depth).iter().flat_map(|x| x.to_le_bytes()).collect();
    assert_eq!(bytes, numbers);
    assert!(!target.is_there(&origin(&whole, &settings, "scene"), &|| true), "it has no provenance");
}

#[test]
fn depth_beyond_the_range_of_png_has_a_warning_with_a_unit_that_fits() {
    let whole = frame(8, [30, 20]);
    let beyond = values(&whole, Aov::Depth).iter().filter(|x| x.is_finite() && **x > 65.5355).count();
    assert!(beyond > 3, "the frame is far enough");
    let warnings = |aov: Aov, name: &str, unit: f64| {
        let style = FormatOptions { unit, ..FormatOptions::default() };
        Target::new(&[aov], Path::new(name), style).expect("a target").warnings(&whole)
    };
    let warning = warnings(Aov::Depth, "d.png", 0.001).concat();
    assert!(
        warning.starts_with(&format!("{beyond} values of depth")) && warning.contains(&format!("{UNIT} 0.00122")),
        "{warning}"
    );
    assert_eq!(warnings(Aov::Depth, "d.png", 0.01), [""; 0]);
    assert_eq!(warnings(Aov::Depth, "d.npy", 0.001), [""; 0]);
    assert_eq!(warnings(Aov::Color, "c.png", 0.001), [""; 0]);
}

#[test]
fn a_crop_stores_its_offset() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = frame(9, [300, 8]);
    let path = folder.path().join("a.png");
    let target = Target::new(&[Aov::Color], &path, FormatOptions::default()).expect("a target");
    let chunk = |frame: &Frame| {
        let bytes = written(frame, &target).0;
        let at = bytes.windows(4).position(|name| name == b"oFFs");
        at.map(|at| bytes[at - 4..at + 13].to_vec())
    };
    assert_eq!(chunk(&whole), None);
    let part = cut(&whole, halfline::Window { x0: 258, y0: 3, x1: 300, y1: 8 });
    assert_eq!(chunk(&part), Some([&[0, 0, 0, 9][..], b"oFFs", &[0, 0, 1, 2, 0, 0, 0, 3, 0]].concat()));
    image::open(&path).expect("another decoder reads it");
    let path = folder.path().join("a.exr");
    written(&part, &Target::new(&[Aov::Color], &path, FormatOptions::default()).expect("a target"));
    let exr = exr::meta::MetaData::read_from_file(&path, true).expect("readable");
    let header = &exr.headers[0];
    assert_eq!((header.own_attributes.layer_position.0, header.own_attributes.layer_position.1), (258, 3));
    assert_eq!((header.layer_size.0, header.layer_size.1), (42, 5));
    assert_eq!(header.shared_attributes.display_window.size, exr::math::Vec2(300, 8));
}

/// NumPy reads the arrays, mapped into memory or not, despite the provenance after or beside them.
#[test]
fn numpy_reads_npy_and_npz_with_their_provenance() {
    let Some(python) = python_or_skip() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let whole = frame(11, [7, 5]);
    let [npy, npz] = ["depth.npy", "depth.npz"].map(|name| folder.path().join(name));
    for path in [&npy, &npz] {
        written(&whole, &Target::new(&[Aov::Depth], path, FormatOptions::default()).expect("a target"));
    }
    let script = "import numpy as n,json,sys; a=n.load(sys.argv[1]); m=n.load(sys.argv[1],mmap_mode='r'); \
        z=n.load(sys.argv[2]); print(z.files, json.loads(z['provenance.json'])['halfline:buffers']); \
        [print(x.dtype, x.shape, x.tobytes().hex()) for x in (a, m, z['depth'])]";
    let output = Command::new(&python).args(["-c", script]).args([&npy, &npz]).output().expect("python runs");
    let hex: String =
        values(&whole, Aov::Depth).iter().flat_map(|x| x.to_le_bytes()).map(|b| format!("{b:02x}")).collect();
    let array = format!("float64 (5, 7) {hex}\n");
    let expected = format!("['depth', 'provenance.json'] depth\n{array}{array}{array}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), expected, "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_file_of_another_program_has_no_provenance() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("other.png");
    image::RgbImage::new(4, 4).save(&path).expect("written");
    for (path, words) in [(path, "no provenance"), (folder.path().join("text"), "not a .png, .exr, .npy, .npz or .pfm")]
    {
        if !path.exists() {
            std::fs::write(&path, "P6 1 1 255").expect("written");
        }
        let error = ImageFile::read(&path).expect_err("not ours").to_string();
        assert!(error.contains(words) && error.starts_with(&path.display().to_string()), "{error}");
    }
    let ours = folder.path().join("ours.png");
    written(&frame(1, [2, 2]), &Target::new(&[Aov::Color], &ours, FormatOptions::default()).expect("a target"));
    assert_eq!(read(&ours).format, FileFormat::Png);
}

/// With any one bit changed, the file does not count as rendered, and reading it gives the old content or an error.
#[test]
fn a_changed_bit_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let (part, mut rng, mut flips) =
        (cut(&frame(9, [9, 7]), halfline::Window { x0: 1, y0: 2, x1: 9, y1: 7 }), Rng::new(9), 0);
    let settings = Settings::default();
    let buffers =
        |format: FileFormat| if format.holds_many() { vec![Aov::Color, Aov::Depth, Aov::Id] } else { vec![Aov::Color] };
    for format in FileFormat::ALL.into_iter().filter(|format| format.is_read()) {
        let path = folder.path().join(format!("a{}", format.ending()));
        let target = Target::new(&buffers(format), &path, FormatOptions::default()).expect("a target");
        let (bytes, image_file) = written(&part, &target);
        // All bits of the first 1200 and the last 400 bytes; of the samples between them one bit of each byte.
        let all = |n: usize| n < 1200 || n + 400 > bytes.len();
        let bits = (0..bytes.len()).flat_map(|n| {
            let one = rng.within(0, 8);
            (0..8).filter(move |bit| all(n) || *bit == one).map(move |bit| (n, bit))
        });
        for (n, bit) in bits.collect::<Vec<_>>() {
            let mut changed = bytes.clone();
            changed[n] ^= 1 << bit;
            match ImageFile::from_bytes(&changed, "changed") {
                Ok(read) => assert!(
                    read.head.forms == image_file.head.forms && read.samples == image_file.samples,
                    "{format:?}, bit {bit} of byte {n}"
                ),
                Err(error) => assert!(matches!(error, halfline::Error::Scene { .. }), "{format:?}: {error}"),
            }
            // Only some are written to a file, which takes a hundred times as long.
            if bit as usize == n % 8 {
                std::fs::write(&path, &changed).expect("written");
                assert!(
                    !target.is_there(&origin(&part, &settings, "scene"), &|| true),
                    "{format:?}, bit {bit} of byte {n}"
                );
            }
            flips += 1;
        }
        for more in [&b"\0"[..], b"\n", b"more", &bytes] {
            std::fs::write(&path, [&bytes[..], more].concat()).expect("written");
            assert!(
                !target.is_there(&origin(&part, &settings, "scene"), &|| true),
                "{format:?} and {} bytes more",
                more.len()
            );
        }
        std::fs::write(&path, &bytes).expect("written");
        assert!(target.is_there(&origin(&part, &settings, "scene"), &|| true), "{format:?}");
    }
    println!("{flips} flipped bits");
}
