//! The promise of the buffers of light: shadows have a component for each light in every format that holds them, and
//! provenance names what they depend on.

use crate::formats::{samples, written};
use crate::random_frames::frame;
use halfline::frame::{Aov, Buffer, Data, Frame};
use halfline_files::write::buffers::FrameFile;
use halfline_files::write::file::Target;
use halfline_files::write::format::FormatOptions;
use halfline_files::write::image_file::ImageFile;
use halfline_measure::Values;

#[test]
fn shadows_have_a_component_for_each_light() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let write = |frame: &Frame, name: &str| {
        let target = Target::new(&[Aov::Shadow], &path(name), FormatOptions::default()).expect("a target");
        written(frame, &target)
    };
    for lights in [1_usize, 2, 11] {
        let mut frame = frame(12, [4, 3]);
        let shares: Vec<f32> = (0..12 * lights).map(|n| n as f32 / 128.0).collect();
        frame.buffers = vec![Buffer::new(Aov::Shadow, 4, 3, Data::F32(shares.clone())).expect("a buffer")];
        frame.report.lights = lights as u64;
        assert_eq!(frame.buffers[0].shape, [3, 4, lights]);
        for name in ["s.npy", "s.npz", "s.exr"] {
            let (_, image_file) = write(&frame, name);
            assert_eq!(image_file.head.provenance.lights(), lights, "{name}");
            assert_eq!(samples(&image_file, 0), shares.iter().map(|x| f64::from(*x)).collect::<Vec<_>>());
            let file = FrameFile::read(&path(name)).expect("readable");
            let array = &file.buffers[0].array;
            assert_eq!((array.shape(), array.values()), (&[3, 4, lights][..], &Values::F32(shares.clone())), "{name}");
        }
        let exr = exr::meta::MetaData::read_from_file(path("s.exr"), true).expect("readable");
        let mut names: Vec<_> = exr.headers[0].channels.list.iter().map(|channel| channel.name.to_string()).collect();
        names.sort_by_key(|name| name["shadow.".len()..].parse::<usize>().expect("the number of a light"));
        assert_eq!(names, (0..lights).map(|light| format!("shadow.{light}")).collect::<Vec<_>>());
    }
    // The buffer says how many lights there are, so that an empty one, or one without the axis, is no buffer.
    Buffer::new(Aov::Shadow, 4, 3, Data::F32(Vec::new())).expect_err("no light");
    let flat = Buffer { aov: Aov::Shadow, shape: vec![3, 4], data: Data::F32(vec![0.0; 12]) };
    assert!(flat.check().expect_err("two axes").to_string().contains("[H, W, L]"));
    let error = Target::new(&[Aov::Shadow], &path("s.png"), FormatOptions::default()).expect_err("no picture");
    assert!(error.to_string().contains("cannot hold the shadow buffer"), "{error}");
}

#[test]
fn a_number_of_lights_that_is_not_the_files_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["s.npy", "s.npz", "s.exr"] {
        let target =
            Target::new(&[Aov::Shadow], &folder.path().join(name), FormatOptions::default()).expect("a target");
        let (bytes, _) = written(&frame(13, [4, 3]), &target);
        let key = b"halfline:lights\":\"3";
        let at = bytes.windows(key.len()).position(|part| part == key).expect("the keyword") + key.len() - 1;
        for digit in *b"0129" {
            let mut changed = bytes.clone();
            changed[at] = digit;
            ImageFile::from_bytes(&changed, name).expect_err("another number");
        }
    }
}

#[test]
fn provenance_names_lights_sky_and_lines_where_bytes_depend_on_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut whole = frame(1, [8, 6]);
    (whole.report.silhouette, whole.report.depth_cue) = (true, true);
    let keys = ["halfline:lights", "halfline:occlusion", "halfline:silhouette", "halfline:depth-cue"];
    for (aov, expected) in [
        (Aov::Color, [None, None, Some("true"), Some("true")]),
        (Aov::Shadow, [Some("3"), None, None, None]),
        (Aov::Occlusion, [None, Some("64 rays, reach 2.5"), None, None]),
        (Aov::Depth, [None; 4]),
    ] {
        let target = Target::new(&[aov], &folder.path().join("a.npy"), FormatOptions::default()).expect("a target");
        let words = written(&whole, &target).1.head.provenance;
        assert_eq!(keys.map(|key| words.get(key)), expected, "{aov}");
    }
}
