//! The promise of `halfline render` and `halfline plan` on every backend: their reports, buffers and files.

use crate::adapter::{gpu, gpu_or_skip};
use crate::data::in_checkout;
use crate::skip::skip;
use crate::test_dir::{NO_ADAPTER, SCENE, TestDir, failure};
use halfline::frame::Aov;
use halfline_files::write::{npy, png};
use halfline_measure::ArrayValue;
use serde_json::Value;

fn dir() -> TestDir {
    TestDir::new(&[("scene.toml", SCENE)])
}

/// The CPU path, and the adapter where the tests have one.
fn backends() -> Vec<&'static str> {
    gpu().map(|_| "gpu").into_iter().chain(["cpu"]).collect()
}

#[test]
fn a_required_adapter_that_is_missing_is_exit_code_4() {
    let dir = dir();
    let base = ["render", "scene.toml", "-o", "out.png"];
    let with = |options: &[&'static str]| [&base[..], options].concat();
    dir.refused_with(
        4,
        &with(&["--backend", "gpu"]),
        &NO_ADAPTER,
        &["adapter", "mesa-vulkan-drivers", "--backend cpu"],
    );
    dir.refused_with(4, &with(&["--adapter", "nosuch"]), &NO_ADAPTER, &["nosuch", "none was found"]);
    dir.refused_with(4, &base, &[("WGPU_BACKEND", "nonsense")], &["WGPU_BACKEND=nonsense", "vulkan"]);
    // The message lists the adapters that were found.
    let renderer = gpu();
    let found = renderer.as_ref().map_or("nosuch", |renderer| renderer.adapter());
    dir.refused(4, &with(&["--adapter", "nosuch"]), &["nosuch", found, "halfline adapters"]);
    dir.refused(4, &with(&["--adapter", "99"]), &["99", "halfline adapters"]);
    dir.refused_with(4, &base, &[("WGPU_ADAPTER_NAME", "nosuch")], &["nosuch", found]);
    if let Some(renderer) = &renderer {
        let named = with(&["--adapter", "0", "--json"]);
        assert_eq!(dir.good(&named).json()["adapter"], renderer.adapter());
    }
}

#[test]
fn the_json_has_every_key() {
    let dir = dir();
    for backend in backends() {
        let rendered = dir.good(&format!("render scene.toml --json -o out.png --repeat 3 --backend {backend}"));
        assert_eq!(rendered.text().lines().count(), 1, "one line for each frame");
        let report = rendered.json();
        let is = |key: &str, kind: fn(&Value) -> bool| {
            let value = report.get(key).unwrap_or_else(|| panic!("no {key}: {report}"));
            assert!(kind(value), "{key}: {value}");
        };
        for key in ["schema", "halfline", "adapter", "driver", "backend", "method", "accuracy", "search"] {
            is(key, |value| value.as_str().is_some_and(|text| !text.is_empty()));
        }
        for key in ["version", "spheres", "skipped", "rays", "hits", "settled"] {
            is(key, Value::is_u64);
        }
        is("certified", |value| value.as_f64().is_some_and(|share| (0.0..=1.0).contains(&share)));
        is("bound", |value| value.is_null() || value.is_f64());
        is("frame_ms", |value| value.as_array().is_some_and(|all| all.len() == 3 && all.iter().all(Value::is_f64)));
        let times = |key: &str| -> Vec<f64> {
            report[key].as_array().expect(key).iter().map(|ms| ms.as_f64().expect("a time")).collect()
        };
        let (frames, host) = (times("frame_ms"), times("host_ms"));
        let bytes = [&report["bytes_up"], &report["bytes_down"]].map(|bytes| bytes.as_u64().expect("bytes"));
        if backend == "cpu" {
            assert!(host == frames && bytes == [0; 2], "all is the host's: {report}");
        } else {
            let is_part = |(host, frame): (&f64, &f64)| *host > 0.0 && host < frame;
            assert!(host.len() == 3 && host.iter().zip(&frames).all(is_part), "{report}");
            // At least the view goes up; colour and id come back, 16 bytes a pixel.
            assert!(bytes[0] > 100 && bytes[1] >= 16 * 45 * 31, "{report}");
        }
        is("stages_ms", |value| {
            value.as_object().is_some_and(|all| !all.is_empty() && all.values().all(Value::is_f64))
        });
        is("warnings", |value| value.as_array().is_some_and(Vec::is_empty));
        assert_eq!(report["backend"], backend);
        assert_eq!([&report["spheres"], &report["skipped"], &report["rays"]], [1, 0, 45 * 31]);
        assert!((1..45 * 31).contains(&report["hits"].as_u64().expect("a count")), "{report}");
        let adapter = report["adapter"].as_str().expect("text");
        let err = rendered.err;
        assert!(err.contains(&format!("rendering on {adapter}")), "{err}");
        assert!(!err.contains('\x1b'), "colours without a terminal: {err}");
    }
}

#[test]
fn every_buffer_has_its_type_shape_and_value_on_a_miss() {
    let dir = dir();
    for backend in backends() {
        let mut arguments: Vec<_> = ["render", "scene.toml", "--backend", backend].map(String::from).into();
        // Shadows need a light; this one is behind the eye.
        arguments.extend(["--sun", "0,0,1"].map(String::from));
        for aov in Aov::ALL {
            arguments.extend(["--aov".to_owned(), format!("{aov}={aov}.npy")]);
        }
        dir.good(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        for aov in Aov::ALL {
            let array = npy::read(&dir.get(&format!("{aov}.npy")), aov.name()).expect("a whole file");
            let pixel = |i: usize, j: usize| -> Vec<f64> {
                let channels = array.shape().get(2).copied().unwrap_or(1);
                let numbers = ((i * 45 + j) * channels..(i * 45 + j + 1) * channels)
                    .map(|k| array.values().get(k).expect("a value"));
                numbers.map(ArrayValue::to_f64).collect()
            };
            let (middle, corner) = (pixel(15, 22), pixel(0, 44));
            let near = |expected: &[f64]| middle.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-3);
            let (shape, dtype, miss, hit): (&[usize], _, _, _) = match aov {
                Aov::Color => (&[31, 45, 3], "float32", corner == [0.25, 0.5, 1.0], near(&[0.9, 0.4, 0.2])),
                Aov::Distance => (&[31, 45], "float64", corner == [f64::INFINITY], near(&[2.0])),
                Aov::Depth => (&[31, 45], "float64", corner == [f64::INFINITY], near(&[2.0])),
                Aov::Normal => (&[31, 45, 3], "float32", corner == [0.0; 3], near(&[0.0, 0.0, 1.0])),
                Aov::Position => (&[31, 45, 3], "float64", corner.iter().all(|x| x.is_nan()), near(&[0.0, 0.0, -2.0])),
                Aov::Id => (&[31, 45], "int32", corner == [-1.0], middle == [0.0]),
                Aov::Mask => (&[31, 45], "uint8", corner == [0.0], middle == [1.0]),
                Aov::Certainty => {
                    let known = |pixel: &[f64]| [0.0, 1.0, 255.0].contains(&pixel[0]);
                    (&[31, 45], "uint8", known(&corner), known(&middle))
                }
                Aov::Bound => (&[31, 45], "float64", corner == [0.0], middle[0] >= 0.0),
                Aov::Alpha => (&[31, 45], "float32", corner == [0.0], middle == [1.0]),
                Aov::Shadow => (&[31, 45, 1], "float32", corner == [0.0], middle == [0.0]),
                Aov::Occlusion => (&[31, 45], "float32", corner == [1.0], middle == [1.0]),
            };
            assert_eq!((array.shape(), array.values().dtype()), (shape, dtype), "{aov}");
            assert!(miss, "{aov} on {backend}: a miss is {corner:?}");
            assert!(hit, "{aov} on {backend}: a hit is {middle:?}");
        }
    }
}

#[test]
fn crops_are_parts_of_the_frame_and_samples_are_reported() {
    let dir = dir();
    for backend in backends() {
        let run = |options: &[&str]| {
            let given = ["render", "scene.toml", "--json", "--samples", "5", "--seed", "3", "--backend", backend];
            dir.good(&[&given[..], options].concat()).json()
        };
        let rows = |name: &str| {
            let (values, shape) = dir.array(name);
            values.chunks_exact(3 * shape[1]).map(<[f64]>::to_vec).collect::<Vec<_>>()
        };
        let report = run(&["-o", "full.npy"]);
        assert_eq!([&report["samples"], &report["rays"]], [9, 45 * 31], "the next square");
        let report = run(&["-o", "crop.npy", "--crop", "5,3,25,20"]);
        assert_eq!([&report["samples"], &report["rays"]], [9, 20 * 17]);
        run(&["-o", "tile.npy", "--tile", "4/4"]);
        let (full, crop, tile) = (rows("full.npy"), rows("crop.npy"), rows("tile.npy"));
        let part = |columns: std::ops::Range<usize>, rows: std::ops::Range<usize>| {
            full[rows].iter().map(|row| row[3 * columns.start..3 * columns.end].to_vec()).collect::<Vec<_>>()
        };
        assert!(crop == part(5..25, 3..20) && tile == part(22..45, 15..31));
        let plan = format!("plan scene.toml -o out.png --json --samples 5 --crop 5,3,25,20 --backend {backend}");
        let plan = dir.good(&plan).json();
        assert_eq!([&plan["samples"], &plan["rays"]], [9, 20 * 17]);
        assert_eq!(plan["window"], serde_json::json!([5, 3, 25, 20]));
    }
}

#[test]
fn without_an_adapter_the_cpu_path_renders_with_a_message() {
    let dir = dir();
    for (backend, message) in [("auto", "falling back to the CPU path"), ("cpu", "rendering on cpu")] {
        let arguments = ["render", "scene.toml", "-o", "out.png", "--json", "--backend", backend];
        let rendered = dir.run_with(&arguments, &NO_ADAPTER);
        assert!(rendered.code == 0 && rendered.err.contains(message), "{} {}", rendered.code, rendered.err);
        let report = rendered.json();
        assert_eq!([&report["backend"], &report["adapter"]], ["cpu", "cpu"]);
        assert!(dir.get("out.png").starts_with(png::MAGIC));
    }
    let none = dir.run_with("adapters", &NO_ADAPTER);
    assert!(none.code == 0 && none.text().contains("mesa-vulkan-drivers"), "{}", none.err);
    assert_eq!(dir.run_with("adapters --json", &NO_ADAPTER).json()["adapters"], Value::Array(Vec::new()));
}

#[test]
fn adapters_lists_the_adapter_that_renders() {
    let Some(renderer) = gpu_or_skip() else { return };
    let dir = dir();
    assert!(dir.good("adapters").text().contains(renderer.adapter()));
    let list = dir.good("adapters --json").json();
    let list = list["adapters"].as_array().expect("a list");
    let found = list.iter().find(|adapter| adapter["name"] == renderer.adapter()).expect("its name");
    assert!(found["index"].is_u64() && found["driver"].is_string() && found["max_binding"].is_u64(), "{found}");
}

#[test]
fn auto_takes_the_cpu_path_in_place_of_software_and_says_why() {
    let Some(renderer) = gpu_or_skip() else { return };
    let dir = dir();
    let list = dir.good("adapters --json").json();
    if list["adapters"][0]["kind"] != "software" {
        return skip("the first adapter is hardware, which auto takes");
    }
    for part in ["", "--crop 0,0,9,9", "--tile 2/4"] {
        let report = dir.good(&format!("render scene.toml --backend auto --json --aov id=id.npy {part}")).json();
        let reason = report["backend_reason"].as_str().expect("a reason");
        assert!(report["backend"] == "cpu" && reason.contains(renderer.adapter()), "{part}: {reason}");
    }
}

#[test]
fn a_frame_without_hits_has_a_warning() {
    let dir = dir();
    let (camera, _) = SCENE.split_once("[[sphere]]").expect("a sphere");
    dir.put("empty.toml", camera);
    for (arguments, words) in [
        (&["render", "empty.toml"][..], &["warning: ", "0 spheres"][..]),
        (&["render", "scene.toml", "--view", "0,0,1"], &["warning: ", "the 1 sphere", "(0, 0, 0)", "(-1, -1, -4)"]),
    ] {
        for backend in backends() {
            let rendered = dir.good(&[arguments, &["-o", "out.npy", "--json", "--backend", backend]].concat());
            words.iter().for_each(|word| assert!(rendered.err.contains(word), "no {word}: {}", rendered.err));
            let report = rendered.json();
            assert_eq!((&report["hits"], report["warnings"].as_array().map(Vec::len)), (&0.into(), Some(1)));
            let (picture, _) = dir.array("out.npy");
            assert_eq!(picture, [0.25, 0.5, 1.0].repeat(45 * 31), "background only");
        }
    }
}

#[test]
fn a_frame_may_be_one_pixel() {
    let dir = dir();
    for backend in backends() {
        dir.good(&["render", "scene.toml", "-o", "out.png", "--size", "1x1", "--backend", backend]);
        assert_eq!(dir.array("out.png").1, [1, 1, 3]);
    }
}

#[test]
fn the_same_command_writes_the_same_bytes() {
    let dir = dir();
    let scene = scene("inside.toml");
    for backend in backends() {
        for out in ["a.png", "b.png"] {
            dir.good(&["render", &scene, "-o", out, "--size", "160x120", "--backend", backend]);
        }
        assert_eq!(dir.get("a.png"), dir.get("b.png"), "{backend}");
    }
}

#[test]
#[cfg(unix)]
fn an_interrupt_is_exit_code_130_and_writes_nothing() {
    use std::io::{BufRead, BufReader, Read};
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};
    let dir = dir();
    let before = dir.files();
    for (backend, signal) in backends().into_iter().flat_map(|backend| [(backend, "-INT"), (backend, "-TERM")]) {
        let options = ["-o", "out.png", "--json", "--repeat", "1000000", "--backend", backend];
        let mut command = dir.command(&[&["render", "scene.toml"], &options[..]].concat());
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("halfline runs");
        let mut messages = BufReader::new(child.stderr.take().expect("a pipe"));
        let mut line = String::new();
        messages.read_line(&mut line).expect("a line");
        assert!(line.contains("rendering on"), "{line}");
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill runs");
        assert!(sent.success());
        let start = Instant::now();
        let status = loop {
            match child.try_wait().expect("its status") {
                Some(status) => break status,
                None if start.elapsed() > Duration::from_secs(20) => {
                    child.kill().expect("ended");
                    panic!("{backend}: still running 20 s after the interrupt");
                }
                None => std::thread::sleep(Duration::from_millis(10)),
            }
        };
        let (mut out, mut rest) = (String::new(), String::new());
        child.stdout.take().expect("a pipe").read_to_string(&mut out).expect("text");
        messages.read_to_string(&mut rest).expect("text");
        assert_eq!((status.code(), rest.as_str()), (Some(130), "halfline: interrupted\n"), "{backend}");
        assert_eq!(failure(&out, 130), "interrupted", "{backend}");
        assert_eq!(dir.files(), before, "{backend}");
    }
}

/// A scene of the project.
fn scene(name: &str) -> String {
    in_checkout("scenes").join(name).display().to_string()
}

#[test]
fn a_plan_is_printed_as_text_and_as_json() {
    let (dir, weekend) = (dir(), scene("weekend.toml"));
    let outputs = "-o x.png --aov distance=t.npy --aov bound=b.npy --size 64x48".split(' ');
    let plan = [&["plan", &weekend][..], &outputs.collect::<Vec<_>>()].concat();
    for backend in backends() {
        let plan = [&plan[..], &["--backend", backend]].concat();
        let text = dir.good(&plan).text();
        for word in ["color", "distance", "bound", "id", "certified", "f32", "room ", "48 x 64 x 3 of float32"] {
            assert!(text.contains(word), "no {word:?} in {text}");
        }
        assert!(backend == "cpu" || text.contains("left out"), "{text}");
        let json = dir.good(&[&plan[..], &["--json"]].concat()).json();
        assert_eq!((&json["schema"], &json["version"]), (&"halfline-plan".into(), &1.into()));
        let frame: Vec<_> = json["frame"].as_array().expect("buffers").iter().map(|b| b["name"].clone()).collect();
        assert_eq!(frame, ["color", "distance", "id", "bound"]);
    }
    assert!(!dir.path("x.png").exists(), "nothing is rendered");
    // Without any adapter the CPU path is planned.
    let json = dir.run_with(&[&plan[..], &["--json"]].concat(), &NO_ADAPTER).json();
    assert_eq!((&json["backend"], &json["dispatches"]), (&"cpu".into(), &0.into()));
}

#[test]
fn a_plan_is_refused_with_the_exit_codes_of_rendering() {
    let dir = dir();
    for (code, arguments, environment) in [
        (2, "plan scene.toml --method unit --accuracy certified", &[][..]),
        (2, "plan scene.toml -o a.png --aov color=a.png", &[]),
        (3, "plan scene.toml --up 0,0,0", &[]),
        (8, "plan no-such-scene.toml", &[]),
        (4, "plan scene.toml --backend gpu", &NO_ADAPTER),
    ] {
        dir.refused_with(code, arguments, environment, &[]);
    }
}

#[test]
fn a_choice_by_tolerance_is_reported_in_one_line() {
    let (dir, canonical) = (dir(), scene("canonical.toml"));
    for backend in backends() {
        let arguments = ["render", &canonical, "-o", "x.png", "--tolerance", "1e-2", "--json", "--backend", backend];
        let rendered = dir.good(&arguments);
        let json = rendered.json();
        let lines: Vec<_> = rendered.err.lines().filter(|line| line.contains("tolerance")).collect();
        assert_eq!(lines, [format!("halfline: {}", json["reason"].as_str().expect("text"))]);
        let predicted = &json["predicted"];
        let within = |name: &str| predicted[name].as_f64().is_some_and(|x| x <= 1e-2);
        assert!(within("outline") && within("distance"), "{json}");
        assert!(predicted["sphere"] == 0 && predicted["radii"].as_f64() == Some(3.0), "{json}");
        assert_eq!(json["accuracy"], "fast");
    }
}
