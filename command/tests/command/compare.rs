//! The promise of `halfline compare`: it finds each difference and its position, and the exit code is 1 if there is
//! any.

use crate::test_dir::{TestDir, failure};
use halfline::frame::{Aov, Buffer, Data};
use halfline_files::write::buffers::FrameFile;
use halfline_files::write::{npy, png};
use serde_json::Value;

const WIDTH: usize = 7;
const HEIGHT: usize = 4;

/// A folder with frames in it.
struct Frames(TestDir);

impl Frames {
    fn new() -> Self {
        Self(TestDir::new(&[]))
    }

    fn put(&self, name: &str, aov: Aov, width: usize, height: usize, data: Data) {
        let buffer = Buffer::new(aov, width, height, data).expect("a whole buffer");
        let mut bytes = Vec::new();
        match name.ends_with(".png") {
            true => png::write(&buffer, &[], &mut bytes),
            false => npy::write(&buffer, &mut bytes),
        }
        .expect("written to memory");
        self.0.put(name, bytes);
    }

    fn depth(&self, name: &str, values: Vec<f64>) {
        self.put(name, Aov::Depth, WIDTH, HEIGHT, Data::F64(values));
    }

    fn color(&self, name: &str, values: Vec<f32>) {
        self.put(name, Aov::Color, WIDTH, HEIGHT, Data::F32(values));
    }

    /// Exit code, standard output, standard error.
    fn compare(&self, arguments: &[&str]) -> (i32, String, String) {
        let output = self.0.run(&[&["compare"], arguments].concat());
        (output.code, output.text(), output.err)
    }

    fn json(&self, arguments: &[&str]) -> (i32, Value) {
        let output = self.0.run(&[&["compare", "--json"], arguments].concat());
        (output.code, output.json())
    }
}

fn depths() -> Vec<f64> {
    (0..WIDTH * HEIGHT).map(|i| if i % 5 == 0 { f64::INFINITY } else { 1.0 + i as f64 / 8.0 }).collect()
}

fn colors() -> Vec<f32> {
    (0..WIDTH * HEIGHT * 3).map(|i| i as f32 / 100.0).collect()
}

#[test]
fn equal_frames_are_equal() {
    let frames = Frames::new();
    frames.depth("a.npy", depths());
    frames.depth("b.npy", depths());
    let (code, out, err) = frames.compare(&["a.npy", "b.npy"]);
    assert_eq!((code, out.as_str(), err.as_str()), (0, "equal: 4 x 7 of float64, every value is the same\n", ""));
    let (code, report) = frames.json(&["a.npy", "b.npy"]);
    assert_eq!(code, 0);
    assert_eq!(report["schema"], "halfline-compare");
    assert_eq!(report["version"], 1);
    assert_eq!(report["equal"], true);
    assert_eq!(report["shape"], serde_json::json!([4, 7]));
    assert_eq!((report["pixels"].as_u64(), report["differing"].as_u64()), (Some(28), Some(0)));
    assert_eq!((report["max"].as_f64(), report["mean"].as_f64()), (Some(0.0), Some(0.0)));
    assert!(report["at"].is_null());
}

#[test]
fn one_changed_pixel_is_found_at_its_place() {
    let frames = Frames::new();
    frames.depth("a.npy", depths());
    frames.color("a.png", colors());
    for (row, column) in [(0, 1), (0, WIDTH - 1), (2, 3), (HEIGHT - 1, 0), (HEIGHT - 1, WIDTH - 1)] {
        let index = row * WIDTH + column;
        let mut changed = depths();
        assert!(changed[index].is_finite());
        changed[index] += 0.25;
        frames.depth("b.npy", changed.clone());
        let (code, report) = frames.json(&["a.npy", "b.npy"]);
        assert_eq!((code, &report["equal"]), (1, &false.into()));
        assert_eq!((report["differing"].as_u64(), report["beyond"].as_u64()), (Some(1), Some(1)));
        assert_eq!((report["max"].as_f64(), report["mean"].as_f64()), (Some(0.25), Some(0.25 / 28.0)));
        let at = &report["at"];
        let place = [&at["row"], &at["column"], &at["channel"]].map(|x| x.as_u64().expect("a place") as usize);
        assert_eq!(place, [row, column, 0]);
        assert_eq!((at["a"].as_f64(), at["b"].as_f64()), (Some(depths()[index]), Some(changed[index])));

        let mut changed = colors();
        changed[index * 3 + 2] = if changed[index * 3 + 2] > 0.5 { 0.0 } else { 1.0 };
        frames.color("b.png", changed);
        let (code, out, _) = frames.compare(&["a.png", "b.png"]);
        assert_eq!(code, 1);
        assert!(out.starts_with("different: 1 of 28 pixels differ beyond 0.0 (4 x 7 x 3 of uint8)\n"), "{out}");
        assert!(out.contains(&format!(" at row {row}, column {column}, channel 2: ")), "{out}");
    }
}

#[test]
fn a_difference_of_the_tolerance_is_equal() {
    let frames = Frames::new();
    frames.depth("a.npy", vec![1.0; WIDTH * HEIGHT]);
    let mut values = vec![1.0; WIDTH * HEIGHT];
    (values[3], values[9]) = (1.5, 1.125);
    frames.depth("b.npy", values);
    for (tolerance, code, beyond) in [("0.5", 0, 0), ("0.4999999999999999", 1, 1), ("0.125", 1, 1), ("0.1", 1, 2)] {
        let (found, report) = frames.json(&["a.npy", "b.npy", "--tolerance", tolerance]);
        assert_eq!((found, report["beyond"].as_u64()), (code, Some(beyond)), "{tolerance}");
        assert_eq!((report["differing"].as_u64(), &report["equal"]), (Some(2), &(code == 0).into()));
    }
    // Two of 28 pixels are 7.1 percent.
    for (share, code) in [("7.2%", 0), ("0.072", 0), ("7.1%", 1), ("1e-9", 1)] {
        let (found, report) = frames.json(&["a.npy", "b.npy", "--share", share]);
        assert_eq!(
            (found, report["beyond"].as_u64(), &report["equal"]),
            (code, Some(2), &(code == 0).into()),
            "{share}"
        );
    }
    let (_, out, _) = frames.compare(&["a.npy", "b.npy", "--share", "10%"]);
    assert!(out.starts_with("within the share: 2 of 28 pixels differ beyond 0.0, and 10 % may "), "{out}");
    for wrong in ["0", "1", "1.0"] {
        assert_eq!(frames.compare(&["a.npy", "b.npy", "--share", wrong]).0, 2, "{wrong}");
    }
    let (code, out, _) = frames.compare(&["a.npy", "b.npy", "--tolerance", "0.5"]);
    assert_eq!(code, 0);
    assert!(out.starts_with("equal: 2 of 28 pixels differ, none beyond 0.5 "), "{out}");
}

#[test]
fn nan_and_infinity_equal_only_themselves() {
    let frames = Frames::new();
    let special = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0];
    let single = |name: &str, x: f64| frames.put(name, Aov::Depth, 1, 1, Data::F64(vec![x]));
    for a in special {
        for b in special {
            single("a.npy", a);
            single("b.npy", if b.is_nan() { -b } else { b });
            let equal = a == b || a.is_nan() && b.is_nan();
            let (code, report) = frames.json(&["a.npy", "b.npy", "--tolerance", "inf", "-o", "diff.png"]);
            assert_eq!(code, i32::from(!equal), "{a} against {b}");
            assert_eq!(report["max"], if equal { 0.0.into() } else { Value::from("inf") }, "{a} against {b}");
        }
    }
    single("a.npy", f64::NEG_INFINITY);
    single("b.npy", f64::NAN);
    let (_, report) = frames.json(&["a.npy", "b.npy"]);
    assert_eq!(
        (&report["at"]["a"], &report["at"]["b"], &report["mean"]),
        (&"-inf".into(), &"nan".into(), &"inf".into())
    );
}

#[test]
fn zeros_of_both_signs_are_equal_and_the_smallest_subnormal_differs() {
    let frames = Frames::new();
    frames.depth("a.npy", vec![0.0; WIDTH * HEIGHT]);
    frames.depth("b.npy", vec![-0.0; WIDTH * HEIGHT]);
    assert_eq!(frames.compare(&["a.npy", "b.npy"]).0, 0);
    frames.depth("b.npy", [vec![0.0; WIDTH * HEIGHT - 1], vec![5e-324]].concat());
    let (code, report) = frames.json(&["a.npy", "b.npy"]);
    assert_eq!((code, report["max"].as_f64()), (1, Some(5e-324)));
}

#[test]
fn values_of_different_types_are_compared_as_numbers() {
    let frames = Frames::new();
    let ids: Vec<i32> = (0..(WIDTH * HEIGHT) as i32).collect();
    frames.put("ids.npy", Aov::Id, WIDTH, HEIGHT, Data::I32(ids.clone()));
    frames.depth("floats.npy", ids.iter().map(|id| f64::from(*id)).collect());
    assert_eq!(frames.compare(&["ids.npy", "floats.npy"]).0, 0);
    frames.put("far.npy", Aov::Id, 1, 1, Data::I32(vec![i32::MIN]));
    frames.put("near.npy", Aov::Id, 1, 1, Data::I32(vec![i32::MAX]));
    let (code, report) = frames.json(&["far.npy", "near.npy"]);
    assert_eq!((code, report["max"].as_f64(), report["at"]["a"].as_i64()), (1, Some(4294967295.0), Some(-2147483648)));
}

#[test]
fn different_shapes_are_a_difference() {
    let frames = Frames::new();
    frames.depth("a.npy", depths());
    frames.put("b.npy", Aov::Depth, HEIGHT, WIDTH, Data::F64(depths()));
    let (code, out, err) = frames.compare(&["a.npy", "b.npy", "-o", "diff.png"]);
    assert_eq!((code, out.as_str()), (1, "different: the shapes are 4 x 7 and 7 x 4\n"));
    assert!(err.contains("diff.png is not written"), "{err}");
    assert!(!frames.0.path("diff.png").exists());
    let (code, report) = frames.json(&["a.npy", "b.npy"]);
    assert_eq!(
        (code, &report["equal"], &report["shape"], &report["max"]),
        (1, &false.into(), &Value::Null, &Value::Null)
    );
    assert_eq!(report["shapes"], serde_json::json!([[4, 7], [7, 4]]));

    // The same picture in 8 and in 16 bits is not compared level by level.
    image::save_buffer(frames.0.path("8.png"), &[255; 4], 2, 2, image::ColorType::L8).expect("written");
    image::save_buffer(frames.0.path("16.png"), &[255; 8], 2, 2, image::ColorType::L16).expect("written");
    let (code, out, _) = frames.compare(&["8.png", "16.png"]);
    assert_eq!((code, out.as_str()), (1, "different: the pictures have levels of uint8 and of uint16\n"));
}

#[test]
fn invalid_files_and_arguments_have_their_exit_codes() {
    let frames = Frames::new();
    frames.depth("a.npy", depths());
    frames.color("a.png", colors());
    let cut = |from: &str, to: &str| {
        let bytes = frames.0.get(from);
        frames.0.put(to, &bytes[..bytes.len() / 2]);
    };
    cut("a.npy", "cut.npy");
    cut("a.png", "cut.png");
    frames.0.put("words.npy", "not a frame");
    for (arguments, code, word) in [
        (&["a.npy", "cut.npy"][..], 3, "cut.npy: "),
        (&["cut.png", "a.png"], 3, "cut.png: "),
        (&["words.npy", "a.npy"], 3, "words.npy: not a PNG, EXR, PFM, .npy or .npz file"),
        (&["a.npy", "none.npy"], 8, "cannot read none.npy"),
        (&["a.npy", "."], 8, "cannot read ."),
        (&["a.npy", "a.npy", "-o", "none/diff.png"], 8, "cannot write none/diff.png"),
        (&["a.npy", "a.npy", "-o", "diff.jpg"], 2, "diff.jpg"),
        (&["a.npy", "a.npy", "-o", "-", "--json"], 2, "standard output"),
        (&["-", "-"], 2, "standard input"),
        (&["a.npy", "a.npy", "--tolerance", "-1"], 2, "0 or more"),
        (&["a.npy", "a.npy", "--tolerance=-0.5"], 2, "0 or more"),
        (&["a.npy", "a.npy", "--tolerance", "nan"], 2, "0 or more"),
        (&["a.npy"], 2, "<B>"),
    ] {
        let (found, out, err) = frames.compare(arguments);
        assert_eq!(found, code, "{arguments:?}: {err}");
        assert!(out.is_empty() || arguments.contains(&"--json") && !failure(&out, code).is_empty(), "{out}");
        assert!(err.contains(word), "{arguments:?}: {err}");
    }
}

/// Width, height and the levels of a picture of three panels.
fn panels(bytes: &[u8]) -> (usize, usize, Vec<u8>) {
    let array = FrameFile::from_bytes(bytes, "diff.png").expect("a picture").buffers.remove(0).array;
    let levels = image::load_from_memory(bytes).expect("a picture").into_rgb8().into_raw();
    (array.shape()[1], array.shape()[0], levels)
}

#[test]
fn the_picture_shows_both_frames_and_their_difference() {
    let frames = Frames::new();
    frames.color("a.png", colors());
    let mut changed = colors();
    let (row, column) = (2, 5);
    changed[(row * WIDTH + column) * 3 + 1] = 0.0;
    frames.color("b.png", changed);
    assert_eq!(frames.compare(&["a.png", "b.png", "-o", "diff.png"]).0, 1);
    let (width, height, levels) = panels(&frames.0.get("diff.png"));
    assert_eq!((width, height), (3 * WIDTH, HEIGHT));
    let pixel = |panel: usize, row: usize, column: usize| {
        let at = (row * width + panel * WIDTH + column) * 3;
        [levels[at], levels[at + 1], levels[at + 2]]
    };
    for (panel, name) in [(0, "a.png"), (2, "b.png")] {
        let original = image::open(frames.0.path(name)).expect("a picture").into_rgb8();
        for (x, y, expected) in original.enumerate_pixels() {
            assert_eq!(pixel(panel, y as usize, x as usize), expected.0, "{name} at {x}, {y}");
        }
    }
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            let expected = if (y, x) == (row, column) { [255, 255, 0] } else { [0; 3] };
            assert_eq!(pixel(1, y, x), expected, "row {y}, column {x}");
        }
    }
    let within = frames.compare(&["a.png", "b.png", "-o", "diff.png", "--tolerance", "255"]);
    let (_, _, levels) = panels(&frames.0.get("diff.png"));
    let at = (row * width + WIDTH + column) * 3;
    assert_eq!((within.0, &levels[at..at + 3]), (0, &[255; 3][..]), "grey within the tolerance");
}

#[test]
fn the_picture_is_written_for_equal_frames_of_every_type() {
    let frames = Frames::new();
    frames.depth("depth.npy", depths());
    frames.put("id.npy", Aov::Id, WIDTH, HEIGHT, Data::I32(vec![-1; WIDTH * HEIGHT]));
    frames.put("position.npy", Aov::Position, WIDTH, HEIGHT, Data::F64(vec![f64::MAX; WIDTH * HEIGHT * 3]));
    for name in ["depth.npy", "id.npy", "position.npy"] {
        let (code, _, err) = frames.compare(&[name, name, "-o", "diff.png"]);
        assert_eq!(code, 0, "{err}");
        let (width, height, _) = panels(&frames.0.get("diff.png"));
        assert_eq!((width, height), (3 * WIDTH, HEIGHT), "{name}");
        frames.0.remove("diff.png");
    }
}

#[test]
fn a_frame_is_read_from_standard_input_and_a_picture_written_to_standard_output() {
    let frames = Frames::new();
    frames.depth("a.npy", depths());
    let output = frames.0.run("compare a.npy a.npy -o -");
    assert_eq!(panels(&output.out).0, 3 * WIDTH);
    assert!(output.err.starts_with("equal: "), "the summary goes to standard error");
    assert_eq!(frames.0.run_fed("compare - a.npy", &frames.0.get("a.npy")).code, 0);
}

/// Renders a sphere on the CPU path into the files that are named.
fn render(frames: &Frames, options: &str) {
    frames.0.put(
        "scene.toml",
        "[camera]\neye = [0, 0, 5]\nview = [0, 0, -1]\nup = [0, 1, 0]\nvfov = 40\n[image]\nsize = [12, 9]\n\
        [[sphere]]\ncenter = [0.1, 0.2, 0.3]\nradius = 1\ncolor = [0.9, 0.5, 0.1]\n",
    );
    frames.0.render(&format!("scene.toml {options}"));
}

const ALL: &str = "color,distance,depth,normal,position,id,mask,certainty,bound,alpha";

#[test]
fn every_format_is_compared() {
    let frames = Frames::new();
    render(
        &frames,
        &format!("-o a.exr --aov {ALL} --aov {ALL}=a.npz --aov depth=a.npy --aov depth=a.pfm --aov normal=n.pfm"),
    );
    // Misses are NaN in position, infinite in depth and -1 in id; all of these compare equal.
    for name in ["a.exr", "a.npz"] {
        let (code, out, _) = frames.compare(&[name, name]);
        assert_eq!((code, out.lines().next()), (0, Some("equal: 10 buffers")), "{out}");
        assert!(
            out.contains("\nposition: equal: 9 x 12 x 3 of ") && out.contains("\nid: equal: 9 x 12 of int32"),
            "{out}"
        );
    }
    // EXR rounds f64 to f32, whose half unit is 2^-24 of the number; all numbers here are below 8. All else is the same.
    let half = (8.0 * f64::powi(2.0, -24)).to_string();
    for (a, b) in [("a.exr", "a.npz"), ("a.npz", "a.exr")] {
        let (code, report) = frames.json(&[a, b, "--tolerance", &half]);
        let buffers = report["buffers"].as_array().expect("buffers");
        assert_eq!((code, buffers.len(), report["missing"].as_array().map(Vec::len)), (0, 10, Some(0)), "{report}");
        for buffer in buffers {
            let exact =
                ["color", "normal", "id", "mask", "certainty", "alpha"].iter().any(|name| buffer["name"] == *name);
            assert!(!exact || buffer["differing"] == 0, "{buffer}");
            assert!(buffer["name"] != "depth" || buffer["differing"].as_u64() > Some(0), "rounding shows: {buffer}");
        }
    }
    // A file of one buffer and one of many: --aov chooses.
    for (a, b) in [("a.pfm", "a.exr"), ("a.npy", "a.npz"), ("a.exr", "a.pfm")] {
        let (code, out, _) = frames.compare(&[a, b, "--aov", "depth"]);
        assert_eq!((code, &out[..6]), (0, "equal:"), "{a} {b}: {out}");
    }
    assert_eq!(frames.compare(&["a.npy", "a.pfm", "--tolerance", &half]).0, 0);
    assert_eq!(frames.compare(&["n.pfm", "a.exr", "--aov", "normal"]).0, 0);
    let (code, out, _) = frames.compare(&["a.pfm", "n.pfm"]);
    assert!(code == 1 && out.contains("the shapes are 9 x 12 and 9 x 12 x 3"), "{out}");
}

#[test]
fn a_buffer_that_one_file_lacks_is_named() {
    let frames = Frames::new();
    render(&frames, "-o a.exr --aov depth,id --aov depth,bound=b.npz --aov depth=d.npy");
    let (code, out, _) = frames.compare(&["a.exr", "b.npz", "--tolerance", "1e-6"]);
    assert_eq!(code, 1);
    let verdict =
        "different: only a.exr has color; only a.exr has id; only b.npz has bound; 0 of 1 common buffers differ\n";
    assert!(out.starts_with(verdict), "{out}");
    let (_, report) = frames.json(&["a.exr", "b.npz", "--tolerance", "1e-6"]);
    assert_eq!(report["missing"][2], serde_json::json!({ "buffer": "bound", "only_in": "b.npz" }));
    assert_eq!((&report["equal"], &report["buffers"][0]["equal"]), (&false.into(), &true.into()));
    assert_eq!(frames.compare(&["a.exr", "b.npz", "--tolerance", "1e-6", "--aov", "depth"]).0, 0);
    assert_eq!(frames.compare(&["d.npy", "b.npz"]).0, 1, "one file has buffers that the other lacks");
    for (arguments, word) in [
        (&["a.exr", "b.npz", "--aov", "bound"][..], "a.exr has no buffer `bound`; the file has color, depth, id"),
        (&["a.exr", "a.exr", "-o", "diff.png"], "choose one with --aov: color, depth, id"),
    ] {
        let (code, _, err) = frames.compare(arguments);
        assert!(code == 2 && err.contains(word), "{arguments:?}: {err}");
    }
    assert!(!frames.0.path("diff.png").exists());
    assert_eq!(frames.compare(&["a.exr", "a.exr", "-o", "diff.png", "--aov", "depth"]).0, 0);
    assert!(frames.0.path("diff.png").exists());
}

#[test]
fn differing_misses_are_found_in_every_format() {
    let frames = Frames::new();
    // On a miss depth is infinite or 0: nothing else differs.
    for ending in ["npz", "exr", "pfm"] {
        render(&frames, &format!("--aov depth=inf.{ending}"));
        render(&frames, &format!("--aov depth=zero.{ending} --no-return zero"));
        let (code, report) = frames.json(&[&format!("inf.{ending}"), &format!("zero.{ending}"), "--tolerance", "inf"]);
        assert_eq!((code, &report["max"], &report["at"]["a"]), (1, &"inf".into(), &"inf".into()), "{ending}");
        let count = report["beyond"].as_u64().expect("a count");
        assert!((10..108).contains(&count), "{ending}: {count} misses");
    }
    render(&frames, "-o left.exr --crop 0,0,6,9");
    render(&frames, "-o right.exr --crop 6,0,12,9");
    let (code, out, _) = frames.compare(&["left.exr", "right.exr"]);
    assert!(code == 1 && out.contains("the data windows begin at 0,0 and at 6,0"), "{out}");
}
