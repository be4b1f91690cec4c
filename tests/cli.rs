//! The promise of the command: its exit codes, what it writes and where, and that a failure leaves nothing behind.
//!
//! Code 6 (device lost) cannot be provoked from outside; 7 (accuracy not reached) belongs to the tests of accuracy.

#[expect(dead_code, reason = "the helpers of tests that render by themselves")]
mod common;

use common::gpu;
use halfline::frame::{Aov, npy, png};
use halfline::measure::{Array, Number};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A unit sphere before the eye; the corners of the picture see past it.
const SCENE: &str = "[camera]
eye = [0.0, 0.0, 0.0]
view = [0.0, 0.0, -1.0]
up = [0.0, 1.0, 0.0]
viewport = [1.5, 1.0]

[image]
size = [45, 31]
background = [0.25, 0.5, 1.0]

[[sphere]]
center = [0.0, 0.0, -3.0]
radius = 1.0
color = [0.9, 0.4, 0.2]
";

const NFF: &str = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 30\nhither 0.1\nresolution 32 24\nf 1 0.5 0 1 0 0 0 1
s 0 0 0 1\np 3\n0 0 0\n1 0 0\n0 1 0\n";

/// No adapter, whatever the machine has.
const NO_ADAPTER: [(&str, &str); 2] = [("VK_DRIVER_FILES", "no-such-driver.json"), ("WGPU_BACKEND", "vulkan")];

/// A folder to work in, with `scene.toml` in it.
struct Desk(tempfile::TempDir);

/// What a command left: exit code, standard output, standard error.
struct Said {
    code: i32,
    out: Vec<u8>,
    err: String,
}

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().expect("a temporary folder"));
        desk.put("scene.toml", SCENE);
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("a file in the temporary folder");
    }

    fn get(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Every file here and its content; folders are empty ones.
    fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let entries = fs::read_dir(self.0.path()).expect("the folder").map(|entry| entry.expect("an entry").path());
        entries.map(|path| (path.clone(), fs::read(path).unwrap_or_default())).collect()
    }

    fn command(&self, arguments: &[&str], environment: &[(&str, &str)]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halfline"));
        command.args(arguments).current_dir(self.0.path()).stdin(Stdio::null());
        // A layer of Mesa's talks on machines without a desktop.
        command.env("NODEVICE_SELECT", "1").env_remove("RUST_LOG");
        command.envs(environment.iter().copied());
        command
    }

    fn run_with(&self, arguments: &[&str], environment: &[(&str, &str)]) -> Said {
        said(self.command(arguments, environment).output().expect("halfline runs"))
    }

    fn run(&self, arguments: &[&str]) -> Said {
        self.run_with(arguments, &[])
    }

    /// Runs what must succeed.
    fn good(&self, arguments: &[&str]) -> Said {
        let said = self.run(arguments);
        assert_eq!(said.code, 0, "{arguments:?}: {}", said.err);
        assert!(!said.err.contains('\x1b'), "{arguments:?}: colours without a terminal: {}", said.err);
        said
    }

    /// Runs what must fail with `code`, say all of `words` in one line, and leave everything as it was.
    fn refused_with(&self, code: i32, arguments: &[&str], environment: &[(&str, &str)], words: &[&str]) {
        let before = self.files();
        let Said { code: found, out, err } = self.run_with(arguments, environment);
        assert_eq!(found, code, "{arguments:?}: {err}");
        assert!(out.is_empty(), "{arguments:?} printed {}", String::from_utf8_lossy(&out));
        assert!(!err.contains("panicked") && !err.contains('\x1b'), "{arguments:?}: {err}");
        let talk =
            |line: &&str| line.starts_with("halfline: rendering on ") || line.contains(": falling back to the CPU");
        let lines: Vec<_> = err.lines().filter(|line| !talk(line)).collect();
        // The parser of arguments adds how the command is used; a fault of ours is told in one line.
        let ours = lines.len() == 1 && lines[0].starts_with("halfline: ");
        assert!(ours || code == 2 && lines[0].starts_with("error: "), "{arguments:?}: {err}");
        for word in words {
            assert!(lines[0].contains(word), "{arguments:?}: no {word:?} in {err}");
        }
        assert_eq!(self.files(), before, "{arguments:?} left something behind");
    }

    fn refused(&self, code: i32, arguments: &[&str], words: &[&str]) {
        self.refused_with(code, arguments, &[], words);
    }
}

fn said(output: std::process::Output) -> Said {
    let err = String::from_utf8_lossy(&output.stderr).into_owned();
    Said { code: output.status.code().unwrap_or_else(|| panic!("{}: {err}", output.status)), out: output.stdout, err }
}

/// The backends to try: the CPU path, and the adapter where the tests have one.
fn backends() -> Vec<&'static str> {
    gpu().map(|_| "gpu").into_iter().chain(["cpu"]).collect()
}

fn json(said: &Said) -> Value {
    let text = String::from_utf8(said.out.clone()).expect("UTF-8");
    assert_eq!(text.lines().count(), 1, "one line: {text}");
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

fn contains(bytes: &[u8], word: &str) -> bool {
    String::from_utf8_lossy(bytes).contains(word)
}

/// A .npy file of f64, (rows, 4), with as many bytes of data as there are `values`.
fn npy_of(rows: usize, values: &[f64]) -> Vec<u8> {
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, 4), }}");
    header += &" ".repeat(128 - 11 - header.len());
    header.push('\n');
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend(u16::try_from(header.len()).expect("short").to_le_bytes());
    file.extend(header.as_bytes());
    file.extend(values.iter().flat_map(|x| x.to_le_bytes()));
    file
}

#[test]
fn usage_is_2() {
    let desk = Desk::new();
    desk.put("out.png", "an older picture");
    desk.refused(2, &["render", "scene.toml", "--bogus"], &["--bogus"]);
    desk.refused(2, &["paint", "scene.toml"], &["paint"]);
    desk.refused(2, &["render", "-o", "out.png"], &["required"]);
    let render = |options: &[&str], words: &[&str]| {
        desk.refused(2, &[&["render", "scene.toml"], options].concat(), words);
    };
    render(&[], &["nothing is asked for", "-o", "--aov", "--json"]);
    render(&["-o", "-", "--json"], &["standard output", "name files"]);
    render(&["-o", "-", "--aov", "id=-"], &["standard output", "name files"]);
    render(&["--aov", "mask=-", "--aov", "id=-"], &["standard output", "name files"]);
    render(&["-o", "out.npy", "--aov", "id=out.npy"], &["out.npy", "twice"]);
    render(&["-o", "out.npy", "--aov", "id=./out.npy"], &["out.npy", "twice"]);
    render(&["-o", "out.jpg"], &["out.jpg", ".png, .exr, .npy, .npz, .pfm or .raw"]);
    render(&["-o", "out"], &["out", ".png, .exr, .npy, .npz, .pfm or .raw"]);
    render(&["--aov", "id=out.png"], &["out.png", "id", ".npy"]);
    render(&["--aov", "id"], &["NAME=FILE", ".exr or .npz"]);
    render(&["-o", "out.png", "--aov", "id,depth"], &["id,depth", "names no file", ".exr or .npz"]);
    render(&["-o", "-", "--aov", "id,depth"], &["id,depth", "names no file", ".exr or .npz"]);
    render(&["--aov", "id,depth=out.npy"], &["out.npy", "id, depth", ".exr or .npz"]);
    render(&["-o", "out.png", "--raw"], &["--raw", "standard output"]);
    render(&["-o", "out.png", "--bits", "12"], &["12", "8 or 16"]);
    render(&["-o", "out.png", "--no-return", "none"], &["none", "inf, nan, zero"]);
    for unit in ["0", "-1", "inf", "nan", "mm"] {
        render(&["--aov", "depth=out.png", "--unit", unit], &[unit, "--unit", "positive"]);
    }
    render(&["--aov", "id="], &["file name"]);
    render(&["--aov", "colour=out.npy"], &["colour", "distance"]);
    for size in ["0x5", "5x0", "5", "axb", "-5x5", "1048577x1"] {
        render(&["-o", "out.png", &format!("--size={size}")], &[size, "--size"]);
    }
    for crop in ["1,2,3", "0,0,46,1", "5,5,5,6", "a,b,c,d", "-1,0,2,2"] {
        render(&["-o", "out.png", &format!("--crop={crop}")], &[crop]);
    }
    for tile in ["3", "0/4", "5/4", "1/0", "1/10000"] {
        render(&["-o", "out.png", "--tile", tile], &["tile"]);
    }
    render(&["-o", "out.png", "--tile", "1/4", "--crop", "0,0,1,1"], &["--tile", "--crop"]);
    render(&["-o", "out.png", "--samples", "0"], &["--samples"]);
    for angle in ["200", "0", "-20", "nan", "180"] {
        render(&["-o", "out.png", "--vfov", angle], &[angle, "--vfov", "between 0 and 180"]);
    }
    for vector in ["1,2", "1,2,3,4", "a,b,c", "1,2,inf", "nan,0,0"] {
        render(&["-o", "out.png", "--eye", vector], &[vector, "--eye", "three finite numbers"]);
    }
    render(&["-o", "out.png", "--at", "0,0,-1", "--view", "0,0,-1"], &["--at", "--view"]);
    render(&["-o", "out.png", "--adapter", "0", "--backend", "cpu"], &["--adapter", "--backend gpu"]);
    render(&["-o", "out.png", "--backend", "abacus"], &["abacus", "auto, gpu, cpu"]);
    render(&["-o", "out.png", "--method", "guess"], &["guess", "stable"]);
    render(&["-o", "out.png", "--shade", "plaid"], &["plaid", "headlight"]);
    render(&["-o", "out.png", "--accuracy", "wild"], &["wild", "certified"]);
    render(&["-o", "out.png", "--repeat", "0"], &["--repeat"]);
    for accuracy in ["certified", "exact"] {
        for backend in ["cpu", "auto", "gpu"] {
            let options = ["--accuracy", accuracy, "--method", "unit", "-o", "out.png", "--backend", backend];
            let arguments = [&["render", "scene.toml"][..], &options].concat();
            desk.refused_with(2, &arguments, &NO_ADAPTER, &["unit", accuracy, "--method"]);
        }
    }
}

#[test]
fn a_scene_that_cannot_be_is_3() {
    let desk = Desk::new();
    let change = |from: &str, to: &str| {
        assert!(SCENE.contains(from), "{from}");
        desk.put("bad.toml", SCENE.replace(from, to));
    };
    let bad = ["render", "bad.toml", "-o", "out.png", "--aov", "id=id.npy", "--json"];
    change("[0.0, 0.0, -3.0]", "[nan, 0.0, -3.0]");
    desk.refused(3, &bad, &["bad.toml:12", "sphere 0 center", "finite"]);
    change("radius = 1.0", "radius = -1.0");
    desk.refused(3, &bad, &["bad.toml:13", "sphere 0 radius", "positive"]);
    change("radius = 1.0", "radius = 0.0");
    desk.refused(3, &bad, &["bad.toml:13", "sphere 0 radius", "positive"]);
    change("radius", "radios");
    desk.refused(3, &bad, &["bad.toml:13", "radios", "radius"]);
    change("size = [45, 31]", "size = [45, 0]");
    desk.refused(3, &bad, &["bad.toml:8", "image.size", "1048576"]);
    change("up = [0.0, 1.0, 0.0]", "up = [0.0, 0.0, 2.0]");
    desk.refused(3, &bad, &["bad.toml:4", "camera.up", "parallel"]);
    change("[camera]", "[[camera");
    desk.refused(3, &bad, &["bad.toml:1", "mend"]);
    desk.put("bad.toml", b"\x00\xff\xfe\x80garbage");
    desk.refused(3, &bad, &["bad.toml:1"]);
    desk.put("bad.toml", "");
    desk.refused(3, &bad, &["bad.toml", "camera"]);
    desk.refused(
        3,
        &["render", "scene.toml", "-o", "out.png", "--up", "0,0,-5"],
        &["camera.up", "parallel", "elsewhere"],
    );
    desk.refused(3, &["render", "scene.toml", "-o", "out.png", "--at", "0,0,0"], &["camera"]);

    let balls = [[0.0, 0.0, -3.0, 1.0], [1.0, 0.0, -4.0, 1.0], [-1.0, 0.0, -4.0, 1.0]].concat();
    change("[[sphere]]", "[[spheres]]\nfile = \"balls.npy\"\n[[sphere]]");
    desk.put("balls.npy", npy_of(3, &balls));
    let whole = json(&desk.good(&["render", "bad.toml", "--json", "--backend", "cpu"]));
    assert_eq!(whole["spheres"], 4);
    desk.put("balls.npy", npy_of(3, &balls[..9]));
    desk.refused(3, &bad, &["balls.npy", "3 "]);
    fs::remove_file(desk.path("balls.npy")).expect("gone");
    desk.refused(8, &bad, &["cannot read balls.npy"]);
}

#[test]
fn no_adapter_is_4_where_one_is_demanded() {
    let desk = Desk::new();
    let base = ["render", "scene.toml", "-o", "out.png"];
    let with = |options: &[&'static str]| [&base[..], options].concat();
    desk.refused_with(
        4,
        &with(&["--backend", "gpu"]),
        &NO_ADAPTER,
        &["adapter", "mesa-vulkan-drivers", "--backend cpu"],
    );
    desk.refused_with(4, &with(&["--adapter", "nosuch"]), &NO_ADAPTER, &["nosuch", "none was found"]);
    desk.refused_with(4, &base, &[("WGPU_BACKEND", "nonsense")], &["WGPU_BACKEND=nonsense", "vulkan"]);
    // What was found is listed.
    let renderer = gpu();
    let found = renderer.as_ref().map_or("nosuch", |renderer| renderer.adapter());
    desk.refused(4, &with(&["--adapter", "nosuch"]), &["nosuch", found, "halfline adapters"]);
    desk.refused(4, &with(&["--adapter", "99"]), &["99", "halfline adapters"]);
    desk.refused_with(4, &base, &[("WGPU_ADAPTER_NAME", "nosuch")], &["nosuch", found]);
    if let Some(renderer) = &renderer {
        let named = with(&["--adapter", "0", "--json"]);
        assert_eq!(json(&desk.good(&named))["adapter"], renderer.adapter());
    }
}

#[test]
fn more_than_the_memory_is_5_and_at_once() {
    let desk = Desk::new();
    let start = Instant::now();
    for backend in ["auto", "cpu"] {
        let arguments = ["render", "scene.toml", "-o", "out.png", "--size", "1048576x1048576", "--backend", backend];
        desk.refused(5, &arguments, &["bytes", "--size"]);
    }
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
}

/// The file is as long as 2e8 spheres, though nobody ever wrote them.
#[test]
#[cfg(target_os = "linux")]
fn more_spheres_than_the_memory_are_5_and_the_number_that_would_fit() {
    let desk = Desk::new();
    desk.put("many.npy", npy_of(200_000_000, &[]));
    let file = fs::File::options().write(true).open(desk.path("many.npy")).expect("the file");
    file.set_len(128 + 32 * 200_000_000).expect("a sparse file");
    desk.put("many.toml", SCENE.replace("[[sphere]]", "[[spheres]]\nfile = \"many.npy\"\n[[sphere]]"));
    let start = Instant::now();
    for command in ["render", "plan"] {
        let mut shell = Command::new("sh");
        shell.args(["-c", "ulimit -v 4000000; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_halfline"), command]);
        shell.args(["many.toml", "-o", "out.png", "--backend", "cpu"]).current_dir(desk.0.path());
        let Said { code, err, .. } = said(shell.output().expect("sh runs"));
        assert_eq!(code, 5, "{err}");
        assert!(err.contains("200000001 spheres need 6400000032 bytes") && err.contains("give at most 1"), "{err}");
    }
    assert!(!desk.path("out.png").exists() && start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
}

#[test]
fn files_are_8() {
    let desk = Desk::new();
    fs::create_dir(desk.path("folder.png")).expect("a folder");
    desk.refused(8, &["render", "missing.toml", "-o", "out.png"], &["cannot read missing.toml"]);
    desk.refused(8, &["render", "folder.png", "-o", "out.png"], &["cannot read folder.png"]);
    for target in ["nowhere/out.png", "scene.toml/out.png", "folder.png"] {
        desk.refused(8, &["render", "scene.toml", "-o", target], &["cannot write", target]);
        // The first target is good and is not written either.
        let both = format!("color={target}");
        desk.refused(8, &["render", "scene.toml", "--aov", "id=id.npy", "--aov", &both], &["cannot write", target]);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_standard_output_is_8() {
    let desk = Desk::new();
    for options in [["-o", "-"], ["--aov", "id=-"], ["--json", "--strict"]] {
        let mut command = desk.command(&["render", "scene.toml", "--backend", "cpu"], &[]);
        let full = fs::File::options().write(true).open("/dev/full").expect("/dev/full");
        let said = said(command.args(options).stdout(full).output().expect("halfline runs"));
        assert_eq!(said.code, 8, "{options:?}: {}", said.err);
        assert!(said.err.contains("cannot write -: No space left"), "{}", said.err);
        assert!(!said.err.contains("panicked"), "{}", said.err);
    }
}

#[test]
fn a_difference_is_1() {
    let desk = Desk::new();
    desk.good(&["render", "scene.toml", "-o", "a.png", "--backend", "cpu"]);
    desk.good(&["render", "scene.toml", "-o", "b.png", "--backend", "cpu", "--eye", "0.01,0,0"]);
    assert_eq!(desk.run(&["compare", "a.png", "a.png"]).code, 0);
    assert_eq!(desk.run(&["compare", "a.png", "b.png"]).code, 1);
}

#[test]
fn the_json_has_every_key() {
    let desk = Desk::new();
    for backend in backends() {
        let said =
            desk.good(&["render", "scene.toml", "--json", "-o", "out.png", "--repeat", "3", "--backend", backend]);
        let report = json(&said);
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
        is("stages_ms", |value| {
            value.as_object().is_some_and(|all| !all.is_empty() && all.values().all(Value::is_f64))
        });
        is("warnings", |value| value.as_array().is_some_and(Vec::is_empty));
        assert_eq!(report["backend"], backend);
        assert_eq!([&report["spheres"], &report["skipped"], &report["rays"]], [1, 0, 45 * 31]);
        assert!((1..45 * 31).contains(&report["hits"].as_u64().expect("a count")), "{report}");
        let adapter = report["adapter"].as_str().expect("text");
        assert!(said.err.contains(&format!("rendering on {adapter}")), "{}", said.err);
    }
}

#[test]
fn standard_output_takes_one_thing_and_no_talk() {
    let desk = Desk::new();
    let cpu = ["--backend", "cpu"];
    let run = |options: &[&str]| desk.good(&[&["render", "scene.toml"], options, &cpu].concat());
    assert!(run(&["-o", "out.png"]).out.is_empty());
    assert!(run(&["--aov", "id=id.npy"]).out.is_empty());
    let picture = run(&["-o", "-"]).out;
    assert!(picture.starts_with(png::MAGIC));
    assert_eq!(picture, desk.get("out.png"));
    assert_eq!(png::read(&picture, "-").expect("a whole PNG").shape(), [31, 45, 3]);
    assert_eq!(run(&["--aov", "id=-"]).out, desk.get("id.npy"));
    // A name after = may be a pipe or a file; beside the JSON only files.
    json(&run(&["-o", "out.png", "--json"]));
}

#[test]
fn every_buffer_has_its_type_its_shape_and_its_miss() {
    let desk = Desk::new();
    for backend in backends() {
        let mut arguments: Vec<_> = ["render", "scene.toml", "--backend", backend].map(String::from).into();
        for aov in Aov::ALL {
            arguments.extend(["--aov".to_owned(), format!("{aov}={aov}.npy")]);
        }
        desk.good(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        for aov in Aov::ALL {
            let array = npy::read(&desk.get(&format!("{aov}.npy")), aov.name()).expect("a whole file");
            let pixel = |i: usize, j: usize| -> Vec<f64> {
                let first = (i * 45 + j) * aov.channels();
                let numbers = (first..first + aov.channels()).map(|k| array.values().get(k).expect("a value"));
                numbers.map(Number::to_f64).collect()
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
            };
            assert_eq!((array.shape(), array.values().dtype()), (shape, dtype), "{aov}");
            assert!(miss, "{aov} on {backend}: a miss is {corner:?}");
            assert!(hit, "{aov} on {backend}: a hit is {middle:?}");
        }
    }
}

#[test]
fn crops_are_parts_and_samples_are_told() {
    let desk = Desk::new();
    for backend in backends() {
        let run = |options: &[&str]| {
            let given = ["render", "scene.toml", "--json", "--samples", "5", "--seed", "3", "--backend", backend];
            json(&desk.good(&[&given[..], options].concat()))
        };
        let rows = |name: &str| {
            let array = Array::read(&desk.path(name)).expect("an array");
            let row = 3 * array.shape()[1];
            let values: Vec<_> =
                (0..array.values().len()).filter_map(|k| array.values().get(k)).map(Number::to_f64).collect();
            values.chunks_exact(row).map(<[f64]>::to_vec).collect::<Vec<_>>()
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
        let told = json(&desk.good(&[
            "plan",
            "scene.toml",
            "-o",
            "out.png",
            "--json",
            "--samples",
            "5",
            "--crop",
            "5,3,25,20",
            "--backend",
            backend,
        ]));
        assert_eq!([&told["samples"], &told["rays"]], [9, 20 * 17]);
        assert_eq!(told["window"], serde_json::json!([5, 3, 25, 20]));
    }
}

#[test]
fn options_replace_the_camera_and_may_be_negative() {
    let desk = Desk::new();
    let asked = ["--eye", "-1,2,3", "--view", "-0.1,-.5,-1", "--up", "-0.5,1,0", "--size", "20x10"];
    desk.good(&[&["render", "scene.toml", "-o", "a.npy", "--backend", "cpu"], &asked[..]].concat());
    let written = SCENE
        .replace("eye = [0.0, 0.0, 0.0]", "eye = [-1.0, 2.0, 3.0]")
        .replace("view = [0.0, 0.0, -1.0]", "view = [-0.1, -0.5, -1.0]")
        .replace("up = [0.0, 1.0, 0.0]", "up = [-0.5, 1.0, 0.0]")
        .replace("[45, 31]", "[20, 10]");
    desk.put("written.toml", written);
    desk.good(&["render", "written.toml", "-o", "b.npy", "--backend", "cpu"]);
    assert_eq!(desk.get("a.npy"), desk.get("b.npy"));
    assert_eq!(Array::read(&desk.path("a.npy")).expect("an array").shape(), [10, 20, 3]);
    desk.good(&["render", "scene.toml", "-o", "a.npy", "--backend", "cpu", "--at=-1,0,-3", "--vfov", "60"]);
}

#[test]
fn parallel_rays_by_file_and_by_option() {
    let desk = Desk::new();
    desk.good(&["render", "scene.toml", "-o", "a.npy", "--aov", "distance=d.npy", "--backend", "cpu", "--ortho", "3"]);
    desk.put("ortho.toml", SCENE.replace("viewport = [1.5, 1.0]", "height = 3"));
    desk.good(&["render", "ortho.toml", "-o", "b.npy", "--backend", "cpu"]);
    assert_eq!(desk.get("a.npy"), desk.get("b.npy"));
    // The middle column passes the unit sphere's centre, three ahead.
    let distance = Array::read(&desk.path("d.npy")).expect("an array");
    let middle = distance.values().get(15 * 45 + 22).expect("a pixel").to_f64();
    assert!((middle - 2.0).abs() <= 1e-5 * 2.0, "{middle}");
    // An angle makes it perspective again.
    desk.good(&["render", "ortho.toml", "-o", "a.npy", "--backend", "cpu", "--vfov", "60"]);
    desk.good(&["render", "scene.toml", "-o", "b.npy", "--backend", "cpu", "--vfov", "60"]);
    assert_eq!(desk.get("a.npy"), desk.get("b.npy"));
    for (arguments, code, word) in [
        (&["--ortho", "3", "--vfov", "60"][..], 2, "cannot be used with"),
        (&["--ortho", "-3"], 2, "a positive number"),
        (&["--ortho", "inf"], 2, "a positive number"),
        (&["--ortho", "3", "--method", "stable"], 2, "orthographic frames are certified"),
    ] {
        let said = desk.run(&[&["render", "scene.toml", "-o", "c.npy", "--backend", "cpu"], arguments].concat());
        assert!(said.code == code && said.err.contains(word), "{arguments:?}: {} {}", said.code, said.err);
        assert!(!desk.path("c.npy").exists());
    }
}

#[test]
fn without_an_adapter_the_cpu_path_renders_and_says_so() {
    let desk = Desk::new();
    for (backend, talk) in [("auto", "falling back to the CPU path"), ("cpu", "rendering on cpu")] {
        let arguments = ["render", "scene.toml", "-o", "out.png", "--json", "--backend", backend];
        let said = desk.run_with(&arguments, &NO_ADAPTER);
        assert_eq!(said.code, 0, "{}", said.err);
        assert!(said.err.contains(talk), "{}", said.err);
        let report = json(&said);
        assert_eq!([&report["backend"], &report["adapter"]], ["cpu", "cpu"]);
        assert!(desk.get("out.png").starts_with(png::MAGIC));
    }
    let none = desk.run_with(&["adapters"], &NO_ADAPTER);
    assert!(none.code == 0 && contains(&none.out, "mesa-vulkan-drivers"), "{}", none.err);
    assert_eq!(json(&desk.run_with(&["adapters", "--json"], &NO_ADAPTER))["adapters"], Value::Array(Vec::new()));
}

#[test]
fn adapters_lists_the_one_that_renders() {
    let Some(renderer) = gpu() else { return };
    let desk = Desk::new();
    assert!(contains(&desk.good(&["adapters"]).out, renderer.adapter()));
    let list = json(&desk.good(&["adapters", "--json"]));
    let list = list["adapters"].as_array().expect("a list");
    let found = list.iter().find(|adapter| adapter["name"] == renderer.adapter()).expect("its name");
    assert!(found["index"].is_u64() && found["driver"].is_string() && found["max_binding"].is_u64(), "{found}");
}

#[test]
fn a_scene_comes_from_standard_input() {
    let desk = Desk::new();
    for (scene, text) in [("scene.toml", SCENE), ("scene.nff", NFF)] {
        desk.put(scene, text);
        desk.good(&["render", scene, "-o", "file.png", "--backend", "cpu"]);
        let mut command = desk.command(&["render", "-", "-o", "piped.png", "--backend", "cpu"], &[]);
        let mut child = command.stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("halfline runs");
        child.stdin.take().expect("a pipe").write_all(text.as_bytes()).expect("taken");
        let said = said(child.wait_with_output().expect("it ends"));
        assert_eq!(said.code, 0, "{}", said.err);
        assert_eq!(desk.get("piped.png"), desk.get("file.png"), "{scene}");
    }
}

#[test]
fn what_is_no_sphere_is_skipped_aloud_or_refused() {
    let desk = Desk::new();
    desk.put("scene.nff", NFF);
    let said = desk.good(&["render", "scene.nff", "--json", "--backend", "cpu"]);
    assert!(said.err.contains("warning: 1 polygon skipped"), "{}", said.err);
    let report = json(&said);
    assert_eq!(report["skipped"], 1);
    assert_eq!(report["warnings"].as_array().map(Vec::len), Some(1));
    desk.refused(3, &["render", "scene.nff", "-o", "out.png", "--strict"], &["scene.nff:10", "polygon", "strict"]);
}

#[test]
fn scenes_that_nobody_here_wrote_render() {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data");
    let data = std::env::var_os("HALFLINE_DATA").map_or(beside.into(), PathBuf::from);
    if !data.is_dir() {
        println!("SKIPPED: no ../shared/data here and HALFLINE_DATA names no folder");
        return;
    }
    let desk = Desk::new();
    for (name, spheres, skipped) in [("balls_s2.nff", 91, "1 polygon skipped"), ("jacks.nff", 6, "cones skipped")] {
        let scene = data.join(name).display().to_string();
        let said = desk.good(&["render", &scene, "--size", "64x64", "-o", "out.png", "--json", "--backend", "cpu"]);
        assert!(said.err.contains(skipped), "{name}: {}", said.err);
        let report = json(&said);
        assert_eq!(report["spheres"], spheres, "{name}");
        assert!(report["hits"].as_u64() > Some(100), "{name}: {report}");
    }
}

#[test]
fn a_picture_of_nothing_is_a_warning_with_a_number() {
    let desk = Desk::new();
    let (camera, _) = SCENE.split_once("[[sphere]]").expect("a sphere");
    desk.put("empty.toml", camera);
    for (arguments, words) in [
        (&["render", "empty.toml"][..], &["warning: ", "0 spheres"][..]),
        (&["render", "scene.toml", "--view", "0,0,1"], &["warning: ", "the 1 sphere", "(0, 0, 0)", "(-1, -1, -4)"]),
    ] {
        for backend in backends() {
            let said = desk.good(&[arguments, &["-o", "out.npy", "--json", "--backend", backend]].concat());
            for word in words {
                assert!(said.err.contains(word), "no {word}: {}", said.err);
            }
            let report = json(&said);
            assert_eq!((&report["hits"], report["warnings"].as_array().map(Vec::len)), (&0.into(), Some(1)));
            let picture = Array::read(&desk.path("out.npy")).expect("an array");
            let background = (0..45 * 31 * 3).map(|k| picture.values().get(k).expect("a value").to_f64());
            assert!(background.eq([0.25, 0.5, 1.0].into_iter().cycle().take(45 * 31 * 3)), "background only");
        }
    }
}

#[test]
fn one_pixel_is_a_picture() {
    let desk = Desk::new();
    for backend in backends() {
        desk.good(&["render", "scene.toml", "-o", "out.png", "--size", "1x1", "--backend", backend]);
        assert_eq!(Array::read(&desk.path("out.png")).expect("a PNG").shape(), [1, 1, 3]);
    }
}

#[test]
fn the_same_command_writes_the_same_bytes() {
    let desk = Desk::new();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/inside.toml").display().to_string();
    for backend in backends() {
        for out in ["a.png", "b.png"] {
            desk.good(&["render", &scene, "-o", out, "--size", "160x120", "--backend", backend]);
        }
        assert_eq!(desk.get("a.png"), desk.get("b.png"), "{backend}");
    }
}

#[test]
#[cfg(unix)]
fn an_interrupt_is_130_and_writes_nothing() {
    use std::io::{BufRead, BufReader, Read};
    let desk = Desk::new();
    let before = desk.files();
    for (backend, signal) in backends().into_iter().flat_map(|backend| [(backend, "-INT"), (backend, "-TERM")]) {
        let options = ["-o", "out.png", "--json", "--repeat", "1000000", "--backend", backend];
        let mut command = desk.command(&[&["render", "scene.toml"], &options[..]].concat(), &[]);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("halfline runs");
        let mut talk = BufReader::new(child.stderr.take().expect("a pipe"));
        let mut line = String::new();
        talk.read_line(&mut line).expect("talk");
        assert!(line.contains("rendering on"), "{line}");
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill runs");
        assert!(sent.success());
        let start = Instant::now();
        let status = loop {
            match child.try_wait().expect("its status") {
                Some(status) => break status,
                None if start.elapsed() > Duration::from_secs(20) => {
                    child.kill().expect("ended");
                    panic!("{backend}: still at work 20 s after the interrupt");
                }
                None => std::thread::sleep(Duration::from_millis(10)),
            }
        };
        let (mut out, mut rest) = (String::new(), String::new());
        child.stdout.take().expect("a pipe").read_to_string(&mut out).expect("text");
        talk.read_to_string(&mut rest).expect("text");
        assert_eq!(
            (status.code(), out.as_str(), rest.as_str()),
            (Some(130), "", "halfline: interrupted\n"),
            "{backend}"
        );
        assert_eq!(desk.files(), before, "{backend}");
    }
}

#[test]
fn answers_are_certified_where_they_are_asked_for_and_equal_the_exact_ones() {
    let desk = Desk::new();
    let run = |options: &[&str]| {
        json(&desk.good(&[&["render", "scene.toml", "--json", "--backend", "cpu"], options].concat()))
    };
    assert_eq!(run(&["-o", "out.png"])["accuracy"], "fast", "a picture alone is a look");
    let certified = run(&["--aov", "id=a.npy", "--aov", "certainty=c.npy"]);
    assert_eq!([&certified["accuracy"], &certified["method"]], ["certified"; 2]);
    assert!(certified["certified"].as_f64().is_some_and(|share| share > 0.9), "{certified}");
    assert!(certified["bound"].as_f64().is_some_and(|bound| bound > 0.0 && bound <= 1e-5), "{certified}");
    let exact = run(&["--aov", "id=b.npy", "--accuracy", "exact"]);
    assert_eq!([&exact["accuracy"], &exact["settled"]], [&serde_json::json!("exact"), &exact["rays"]]);
    // The files also say how sure they are, which is not the same.
    let ids = |name: &str| npy::read(&desk.get(name), name).expect("a whole file").values().clone();
    assert_eq!(ids("a.npy"), ids("b.npy"));
    let settled = run(&["--aov", "id=d.npy", "--tolerance", "1e-14"]);
    assert!(settled["settled"].as_u64() >= settled["hits"].as_u64(), "f32 proves no 1e-14: {settled}");
    assert_eq!(ids("d.npy"), ids("b.npy"));
    assert_eq!(run(&["--aov", "id=e.npy", "--method", "unit"])["accuracy"], "fast", "a form runs alone");
    for bad in ["0", "-1", "1e-16", "nan", "much"] {
        desk.refused(2, &["render", "scene.toml", "-o", "no.png", "--tolerance", bad], &["tolerance"]);
    }
}
