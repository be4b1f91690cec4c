//! `halfline compare`: what differs is found where it is, what is equal is called equal, and the exit code says which.

use halfline::frame::{Aov, Buffer, Data, npy, png};
use halfline::measure::Array;
use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

const WIDTH: usize = 7;
const HEIGHT: usize = 4;

/// A folder with frames in it, gone after the test.
struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, aov: Aov, width: usize, height: usize, data: Data) {
        let buffer = Buffer::new(aov, width, height, data).expect("a whole buffer");
        let mut bytes = Vec::new();
        match name.ends_with(".png") {
            true => png::write(&buffer, &[], &mut bytes),
            false => npy::write(&buffer, &mut bytes),
        }
        .expect("memory takes everything");
        fs::write(self.path(name), bytes).expect("written");
    }

    fn depth(&self, name: &str, values: Vec<f64>) {
        self.put(name, Aov::Depth, WIDTH, HEIGHT, Data::F64(values));
    }

    fn color(&self, name: &str, values: Vec<f32>) {
        self.put(name, Aov::Color, WIDTH, HEIGHT, Data::F32(values));
    }

    fn compare(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halfline"));
        command.arg("compare").args(arguments).current_dir(self.0.path()).stdin(Stdio::null());
        command.output().expect("halfline runs")
    }

    /// Exit code, standard output, standard error.
    fn said(&self, arguments: &[&str]) -> (i32, String, String) {
        let output = self.compare(arguments);
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code().expect("an exit code"), text(&output.stdout), text(&output.stderr))
    }

    fn json(&self, arguments: &[&str]) -> (i32, Value) {
        let (code, out, err) = self.said(&[arguments, &["--json"]].concat());
        (code, serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error} in {out:?}; {err}")))
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
    let desk = Desk::new();
    desk.depth("a.npy", depths());
    desk.depth("b.npy", depths());
    let (code, out, err) = desk.said(&["a.npy", "b.npy"]);
    assert_eq!((code, out.as_str(), err.as_str()), (0, "equal: 4 x 7 of float64, every value the same\n", ""));
    let (code, report) = desk.json(&["a.npy", "b.npy"]);
    assert_eq!(code, 0);
    assert_eq!(report["schema"], "halfline-compare");
    assert_eq!(report["version"], 1);
    assert_eq!(report["equal"], true);
    assert_eq!(report["shape"], serde_json::json!([4, 7]));
    assert_eq!((report["pixels"].as_u64(), report["differing"].as_u64()), (Some(28), Some(0)));
    assert_eq!((report["max"].as_f64(), report["mean"].as_f64()), (Some(0.0), Some(0.0)));
    assert!(report["at"].is_null());
}

/// The negative control: a differ that cannot find this finds nothing.
#[test]
fn one_changed_pixel_is_found_wherever_it_is() {
    let desk = Desk::new();
    desk.depth("a.npy", depths());
    desk.color("a.png", colors());
    for (row, column) in [(0, 1), (0, WIDTH - 1), (2, 3), (HEIGHT - 1, 0), (HEIGHT - 1, WIDTH - 1)] {
        let index = row * WIDTH + column;
        let mut changed = depths();
        assert!(changed[index].is_finite());
        changed[index] += 0.25;
        desk.depth("b.npy", changed.clone());
        let (code, report) = desk.json(&["a.npy", "b.npy"]);
        assert_eq!((code, &report["equal"]), (1, &false.into()));
        assert_eq!((report["differing"].as_u64(), report["beyond"].as_u64()), (Some(1), Some(1)));
        assert_eq!((report["max"].as_f64(), report["mean"].as_f64()), (Some(0.25), Some(0.25 / 28.0)));
        let at = &report["at"];
        let place = [&at["row"], &at["column"], &at["channel"]].map(|x| x.as_u64().expect("a place") as usize);
        assert_eq!(place, [row, column, 0]);
        assert_eq!((at["a"].as_f64(), at["b"].as_f64()), (Some(depths()[index]), Some(changed[index])));

        let mut changed = colors();
        changed[index * 3 + 2] = if changed[index * 3 + 2] > 0.5 { 0.0 } else { 1.0 };
        desk.color("b.png", changed);
        let (code, out, _) = desk.said(&["a.png", "b.png"]);
        assert_eq!(code, 1);
        assert!(out.starts_with("different: 1 of 28 pixels differ beyond 0.0 (4 x 7 x 3 of uint8)\n"), "{out}");
        assert!(out.contains(&format!(" at row {row}, column {column}, channel 2: ")), "{out}");
    }
}

#[test]
fn the_tolerance_belongs_to_the_equal() {
    let desk = Desk::new();
    desk.depth("a.npy", vec![1.0; WIDTH * HEIGHT]);
    let mut values = vec![1.0; WIDTH * HEIGHT];
    (values[3], values[9]) = (1.5, 1.125);
    desk.depth("b.npy", values);
    for (tolerance, code, beyond) in [("0.5", 0, 0), ("0.4999999999999999", 1, 1), ("0.125", 1, 1), ("0.1", 1, 2)] {
        let (found, report) = desk.json(&["a.npy", "b.npy", "--tolerance", tolerance]);
        assert_eq!((found, report["beyond"].as_u64()), (code, Some(beyond)), "{tolerance}");
        assert_eq!((report["differing"].as_u64(), &report["equal"]), (Some(2), &(code == 0).into()));
    }
    let (code, out, _) = desk.said(&["a.npy", "b.npy", "--tolerance", "0.5"]);
    assert_eq!(code, 0);
    assert!(out.starts_with("equal: 2 of 28 pixels differ, none beyond 0.5 "), "{out}");
}

#[test]
fn nan_and_infinity_equal_themselves_and_nothing_else() {
    let desk = Desk::new();
    let special = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0];
    let single = |name: &str, x: f64| desk.put(name, Aov::Depth, 1, 1, Data::F64(vec![x]));
    for a in special {
        for b in special {
            single("a.npy", a);
            single("b.npy", if b.is_nan() { -b } else { b });
            let equal = a == b || a.is_nan() && b.is_nan();
            let (code, report) = desk.json(&["a.npy", "b.npy", "--tolerance", "inf", "-o", "diff.png"]);
            assert_eq!(code, i32::from(!equal), "{a} against {b}");
            assert_eq!(report["max"], if equal { 0.0.into() } else { Value::from("inf") }, "{a} against {b}");
        }
    }
    single("a.npy", f64::NEG_INFINITY);
    single("b.npy", f64::NAN);
    let (_, report) = desk.json(&["a.npy", "b.npy"]);
    assert_eq!(
        (&report["at"]["a"], &report["at"]["b"], &report["mean"]),
        (&"-inf".into(), &"nan".into(), &"inf".into())
    );
}

#[test]
fn zeros_of_both_signs_are_equal_and_the_smallest_step_is_not() {
    let desk = Desk::new();
    desk.depth("a.npy", vec![0.0; WIDTH * HEIGHT]);
    desk.depth("b.npy", vec![-0.0; WIDTH * HEIGHT]);
    assert_eq!(desk.said(&["a.npy", "b.npy"]).0, 0);
    desk.depth("b.npy", [vec![0.0; WIDTH * HEIGHT - 1], vec![5e-324]].concat());
    let (code, report) = desk.json(&["a.npy", "b.npy"]);
    assert_eq!((code, report["max"].as_f64()), (1, Some(5e-324)));
}

#[test]
fn types_of_one_shape_are_compared_as_numbers() {
    let desk = Desk::new();
    let ids: Vec<i32> = (0..(WIDTH * HEIGHT) as i32).collect();
    desk.put("ids.npy", Aov::Id, WIDTH, HEIGHT, Data::I32(ids.clone()));
    desk.depth("floats.npy", ids.iter().map(|id| f64::from(*id)).collect());
    assert_eq!(desk.said(&["ids.npy", "floats.npy"]).0, 0);
    desk.put("far.npy", Aov::Id, 1, 1, Data::I32(vec![i32::MIN]));
    desk.put("near.npy", Aov::Id, 1, 1, Data::I32(vec![i32::MAX]));
    let (code, report) = desk.json(&["far.npy", "near.npy"]);
    assert_eq!((code, report["max"].as_f64(), report["at"]["a"].as_i64()), (1, Some(4294967295.0), Some(-2147483648)));
}

#[test]
fn shapes_that_differ_are_a_difference() {
    let desk = Desk::new();
    desk.depth("a.npy", depths());
    desk.put("b.npy", Aov::Depth, HEIGHT, WIDTH, Data::F64(depths()));
    let (code, out, err) = desk.said(&["a.npy", "b.npy", "-o", "diff.png"]);
    assert_eq!((code, out.as_str()), (1, "different: the shapes are 4 x 7 and 7 x 4\n"));
    assert!(err.contains("diff.png is not written"), "{err}");
    assert!(!desk.path("diff.png").exists());
    let (code, report) = desk.json(&["a.npy", "b.npy"]);
    assert_eq!(
        (code, &report["equal"], &report["shape"], &report["max"]),
        (1, &false.into(), &Value::Null, &Value::Null)
    );
    assert_eq!(report["shapes"], serde_json::json!([[4, 7], [7, 4]]));

    // The same picture in 8 and in 16 bits is not compared level by level.
    image::save_buffer(desk.path("8.png"), &[255; 4], 2, 2, image::ColorType::L8).expect("written");
    image::save_buffer(desk.path("16.png"), &[255; 8], 2, 2, image::ColorType::L16).expect("written");
    let (code, out, _) = desk.said(&["8.png", "16.png"]);
    assert_eq!((code, out.as_str()), (1, "different: the pictures hold levels of uint8 and of uint16\n"));
}

#[test]
fn bad_files_and_bad_requests_have_their_own_codes() {
    let desk = Desk::new();
    desk.depth("a.npy", depths());
    desk.color("a.png", colors());
    let cut = |from: &str, to: &str| {
        let bytes = fs::read(desk.path(from)).expect("there");
        fs::write(desk.path(to), &bytes[..bytes.len() / 2]).expect("written");
    };
    cut("a.npy", "cut.npy");
    cut("a.png", "cut.png");
    fs::write(desk.path("words.npy"), "not a frame").expect("written");
    for (arguments, code, word) in [
        (&["a.npy", "cut.npy"][..], 3, "cut.npy: "),
        (&["cut.png", "a.png"], 3, "cut.png: "),
        (&["words.npy", "a.npy"], 3, "words.npy: neither PNG, EXR, PFM, .npy nor .npz"),
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
        let (found, out, err) = desk.said(arguments);
        assert_eq!((found, out.as_str()), (code, ""), "{arguments:?}: {err}");
        assert!(err.contains(word), "{arguments:?}: {err}");
    }
}

/// Width, height and the levels of a picture of three panels.
fn panels(bytes: &[u8]) -> (usize, usize, Vec<u8>) {
    let array = Array::from_bytes(bytes, "diff.png").expect("a picture");
    let levels = image::load_from_memory(bytes).expect("a picture").into_rgb8().into_raw();
    (array.shape()[1], array.shape()[0], levels)
}

#[test]
fn the_picture_shows_expected_difference_actual() {
    let desk = Desk::new();
    desk.color("a.png", colors());
    let mut changed = colors();
    let (row, column) = (2, 5);
    changed[(row * WIDTH + column) * 3 + 1] = 0.0;
    desk.color("b.png", changed);
    assert_eq!(desk.said(&["a.png", "b.png", "-o", "diff.png"]).0, 1);
    let (width, height, levels) = panels(&fs::read(desk.path("diff.png")).expect("written"));
    assert_eq!((width, height), (3 * WIDTH, HEIGHT));
    let pixel = |panel: usize, row: usize, column: usize| {
        let at = (row * width + panel * WIDTH + column) * 3;
        [levels[at], levels[at + 1], levels[at + 2]]
    };
    for (panel, name) in [(0, "a.png"), (2, "b.png")] {
        let original = image::open(desk.path(name)).expect("a picture").into_rgb8();
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
    let within = desk.said(&["a.png", "b.png", "-o", "diff.png", "--tolerance", "255"]);
    let (_, _, levels) = panels(&fs::read(desk.path("diff.png")).expect("written"));
    let at = (row * width + WIDTH + column) * 3;
    assert_eq!((within.0, &levels[at..at + 3]), (0, &[255; 3][..]), "grey within the tolerance");
}

#[test]
fn the_picture_is_written_for_equal_frames_of_any_kind() {
    let desk = Desk::new();
    desk.depth("depth.npy", depths());
    desk.put("id.npy", Aov::Id, WIDTH, HEIGHT, Data::I32(vec![-1; WIDTH * HEIGHT]));
    desk.put("position.npy", Aov::Position, WIDTH, HEIGHT, Data::F64(vec![f64::MAX; WIDTH * HEIGHT * 3]));
    for name in ["depth.npy", "id.npy", "position.npy"] {
        let (code, _, err) = desk.said(&[name, name, "-o", "diff.png"]);
        assert_eq!(code, 0, "{err}");
        let (width, height, _) = panels(&fs::read(desk.path("diff.png")).expect("written"));
        assert_eq!((width, height), (3 * WIDTH, HEIGHT), "{name}");
        fs::remove_file(desk.path("diff.png")).expect("removed");
    }
}

#[test]
fn standard_input_and_output_are_files_too() {
    let desk = Desk::new();
    desk.depth("a.npy", depths());
    let output = desk.compare(&["a.npy", "a.npy", "-o", "-"]);
    assert_eq!(panels(&output.stdout).0, 3 * WIDTH);
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("equal: "), "the summary gives way");

    let mut child = Command::new(env!("CARGO_BIN_EXE_halfline"))
        .args(["compare", "-", "a.npy"])
        .current_dir(desk.0.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("halfline runs");
    let bytes = fs::read(desk.path("a.npy")).expect("there");
    child.stdin.take().expect("a pipe").write_all(&bytes).expect("taken");
    assert!(child.wait().expect("it ends").success());
}

/// Renders a sphere on the CPU into the files that are named.
fn render(desk: &Desk, options: &str) {
    let scene = "[camera]\neye = [0, 0, 5]\nview = [0, 0, -1]\nup = [0, 1, 0]\nvfov = 40\n[image]\nsize = [12, 9]\n\
        [[sphere]]\ncenter = [0.1, 0.2, 0.3]\nradius = 1\ncolor = [0.9, 0.5, 0.1]\n";
    fs::write(desk.path("scene.toml"), scene).expect("written");
    let words = ["render", "scene.toml", "--backend", "cpu"].into_iter().chain(options.split(' '));
    let mut command = Command::new(env!("CARGO_BIN_EXE_halfline"));
    let output = command.args(words).current_dir(desk.0.path()).stdin(Stdio::null()).output().expect("halfline runs");
    assert!(output.status.success(), "{options}: {}", String::from_utf8_lossy(&output.stderr));
}

const ALL: &str = "color,distance,depth,normal,position,id,mask,certainty,bound,alpha";

#[test]
fn every_format_that_is_written_is_compared() {
    let desk = Desk::new();
    render(
        &desk,
        &format!("-o a.exr --aov {ALL} --aov {ALL}=a.npz --aov depth=a.npy --aov depth=a.pfm --aov normal=n.pfm"),
    );
    // Misses are NaN in position, infinite in depth, -1 in id, and equal themselves.
    for name in ["a.exr", "a.npz"] {
        let (code, out, _) = desk.said(&[name, name]);
        assert_eq!((code, out.lines().next()), (0, Some("equal: 10 buffers")), "{out}");
        assert!(
            out.contains("\nposition: equal: 9 x 12 x 3 of ") && out.contains("\nid: equal: 9 x 12 of int32"),
            "{out}"
        );
    }
    // EXR rounds f64 to f32, whose half unit is 2^-24 of the number; all numbers here are below 8. All else is the same.
    let half = (8.0 * f64::powi(2.0, -24)).to_string();
    for (a, b) in [("a.exr", "a.npz"), ("a.npz", "a.exr")] {
        let (code, report) = desk.json(&[a, b, "--tolerance", &half]);
        let buffers = report["buffers"].as_array().expect("buffers");
        assert_eq!((code, buffers.len(), report["missing"].as_array().map(Vec::len)), (0, 10, Some(0)), "{report}");
        for buffer in buffers {
            let exact =
                ["color", "normal", "id", "mask", "certainty", "alpha"].iter().any(|name| buffer["name"] == *name);
            assert!(!exact || buffer["differing"] == 0, "{buffer}");
            assert!(buffer["name"] != "depth" || buffer["differing"].as_u64() > Some(0), "rounding is seen: {buffer}");
        }
    }
    // One buffer against many is that buffer.
    for (a, b) in [("a.pfm", "a.exr"), ("a.npy", "a.npz"), ("a.exr", "a.pfm")] {
        let (code, out, _) = desk.said(&[a, b, "--aov", "depth"]);
        assert_eq!((code, &out[..6]), (0, "equal:"), "{a} {b}: {out}");
    }
    assert_eq!(desk.said(&["a.npy", "a.pfm", "--tolerance", &half]).0, 0);
    assert_eq!(desk.said(&["n.pfm", "a.exr", "--aov", "normal"]).0, 0);
    let (code, out, _) = desk.said(&["a.pfm", "n.pfm"]);
    assert!(code == 1 && out.contains("the shapes are 9 x 12 and 9 x 12 x 3"), "{out}");
}

#[test]
fn buffers_that_one_file_lacks_are_a_difference_with_a_name() {
    let desk = Desk::new();
    render(&desk, "-o a.exr --aov depth,id --aov depth,bound=b.npz --aov depth=d.npy");
    let (code, out, _) = desk.said(&["a.exr", "b.npz", "--tolerance", "1e-6"]);
    assert_eq!(code, 1);
    let verdict =
        "different: only a.exr has color; only a.exr has id; only b.npz has bound; 0 of 1 common buffers differ\n";
    assert!(out.starts_with(verdict), "{out}");
    let (_, report) = desk.json(&["a.exr", "b.npz", "--tolerance", "1e-6"]);
    assert_eq!(report["missing"][2], serde_json::json!({ "buffer": "bound", "only_in": "b.npz" }));
    assert_eq!((&report["equal"], &report["buffers"][0]["equal"]), (&false.into(), &true.into()));
    assert_eq!(desk.said(&["a.exr", "b.npz", "--tolerance", "1e-6", "--aov", "depth"]).0, 0);
    assert_eq!(desk.said(&["d.npy", "b.npz"]).0, 1, "the file with more has what the other lacks");
    for (arguments, word) in [
        (&["a.exr", "b.npz", "--aov", "bound"][..], "a.exr has no buffer `bound`; it has color, depth, id"),
        (&["a.exr", "a.exr", "-o", "diff.png"], "choose one with --aov: color, depth, id"),
    ] {
        let (code, _, err) = desk.said(arguments);
        assert!(code == 2 && err.contains(word), "{arguments:?}: {err}");
    }
    assert!(!desk.path("diff.png").exists());
    assert_eq!(desk.said(&["a.exr", "a.exr", "-o", "diff.png", "--aov", "depth"]).0, 0);
    assert!(desk.path("diff.png").exists());
}

#[test]
fn one_pixel_that_differs_is_found_in_every_format() {
    let desk = Desk::new();
    // On a miss depth is infinite or 0: nothing else differs.
    for ending in ["npz", "exr", "pfm"] {
        render(&desk, &format!("--aov depth=inf.{ending}"));
        render(&desk, &format!("--aov depth=zero.{ending} --no-return zero"));
        let (code, report) = desk.json(&[&format!("inf.{ending}"), &format!("zero.{ending}"), "--tolerance", "inf"]);
        assert_eq!((code, &report["max"], &report["at"]["a"]), (1, &"inf".into(), &"inf".into()), "{ending}");
        let count = report["beyond"].as_u64().expect("a count");
        assert!((10..108).contains(&count), "{ending}: {count} misses");
    }
    render(&desk, "-o left.exr --crop 0,0,6,9");
    render(&desk, "-o right.exr --crop 6,0,12,9");
    let (code, out, _) = desk.said(&["left.exr", "right.exr"]);
    assert!(code == 1 && out.contains("the data windows begin at 0,0 and at 6,0"), "{out}");
}
