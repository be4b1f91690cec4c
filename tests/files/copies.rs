//! The promise of copies: other programs find the levels of the PNG in them, and halfline does not read them.

use crate::formats::{same, samples, styles, written};
use crate::random_frames::{frame, origin};
use halfline::frame::Aov;
use halfline::settings::Settings;
use halfline_files::write::file::Target;
use halfline_files::write::format::{Bits, FormatOptions};
use halfline_files::write::image_file::ImageFile;
use image_webp::WebPDecoder;
use std::io::Cursor;
use std::path::Path;
use tiff::decoder::ifd::Value;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;

/// The levels of a TIFF, its description, and its pixels per inch.
fn tiff(bytes: &[u8]) -> (Vec<f64>, String, Option<u32>) {
    let mut decoder = Decoder::new(Cursor::new(bytes)).expect("a TIFF");
    let description = decoder.get_tag_ascii_string(Tag::ImageDescription).expect("a description");
    let in_inches = decoder.get_tag_u32(Tag::ResolutionUnit).expect("a unit") == 2;
    let dpi = match decoder.get_tag(Tag::XResolution).expect("a resolution") {
        Value::Rational(n, 1) if in_inches => Some(n),
        _ => None,
    };
    let levels = match decoder.read_image().expect("levels") {
        DecodingResult::U8(levels) => levels.into_iter().map(f64::from).collect(),
        DecodingResult::U16(levels) => levels.into_iter().map(f64::from).collect(),
        _ => panic!("other levels"),
    };
    (levels, description, dpi)
}

#[test]
fn copies_have_the_levels_of_the_png() {
    let folder = tempfile::tempdir().expect("a folder");
    for (n, full) in [[1, 1], [40, 30], [301, 70]].into_iter().enumerate() {
        let whole = frame(n as u64, full);
        for style in styles() {
            let at = |name: &str| Target::new(&[Aov::Color], &folder.path().join(name), style).expect("a target");
            let png = samples(&written(&whole, &at("a.png")).1, 0);
            let settings = Settings::default();
            let file = |name: &str| {
                at(name).write(&whole, &origin(&whole, &settings, "scene")).expect("written");
                let error = ImageFile::read(&folder.path().join(name)).expect_err("a copy").to_string();
                assert!(error.contains("is a copy of a picture and is not read back"), "{error}");
                std::fs::read(folder.path().join(name)).expect("there")
            };
            let (levels, description, dpi) = tiff(&file("a.tif"));
            assert!(same(&levels, &png), "{full:?}, {style:?}: TIFF");
            assert!(description.contains("halfline:scene: scene\n"), "{description}");
            assert_eq!(dpi, style.dpi.map(|_| 600));
            let bytes = file("a.webp");
            let mut decoder = WebPDecoder::new(Cursor::new(&bytes[..])).expect("a WebP");
            let mut found = vec![0; decoder.output_buffer_size().expect("a size")];
            decoder.read_image(&mut found).expect("levels");
            let exif = decoder.exif_metadata().expect("Exif").expect("there");
            assert!(exif.windows(22).any(|some| some == b"halfline:scene: scene\n"), "{full:?}");
            if style.bits == Bits::Eight {
                assert_eq!(found.into_iter().map(f64::from).collect::<Vec<_>>(), png, "{full:?}, {style:?}: WebP");
            }
            let bytes = file("a.jpg");
            assert!(bytes.starts_with(b"\xff\xd8\xff") && bytes.windows(4).any(|some| some == b"Exif"));
        }
    }
}

#[test]
fn copies_refuse_sides_that_their_headers_cannot_hold() {
    for (name, longest) in [("a.jpg", 65_535), ("a.webp", 16_384)] {
        let target = Target::new(&[Aov::Color], Path::new(name), FormatOptions::default()).expect("a target");
        target.check_size([longest, 1]).expect("fits");
        let error = target.check_size([1, longest + 1]).expect_err("too long").to_string();
        assert!(error.contains(&longest.to_string()) && error.contains(name), "{error}");
    }
}
