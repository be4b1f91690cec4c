//! The promise of exit codes: each failure has its code and one line of message, and leaves every file as it was.
//!
//! Code 4 (no adapter) is tested in tests/answers/command.rs, 6 (device lost) in src/gpu/tests.rs and 7 (accuracy not reached)
//! in tests/answers/selftest.rs.

use crate::numpy::{little, npy_of};
use crate::test_dir::{NO_ADAPTER, Output, SCENE, TestDir};
use std::fs;
use std::io::Write;
use std::time::{Duration, Instant};

fn dir() -> TestDir {
    TestDir::new(&[("scene.toml", SCENE)])
}

#[test]
fn invalid_arguments_are_exit_code_2() {
    let dir = dir();
    dir.put("out.png", "an older picture");
    dir.refused(2, &["render", "scene.toml", "--bogus"], &["--bogus"]);
    dir.refused(2, &["paint", "scene.toml"], &["paint"]);
    dir.refused(2, &["render", "-o", "out.png"], &["required"]);
    let render = |options: &[&str], words: &[&str]| {
        dir.refused(2, &[&["render", "scene.toml"], options].concat(), words);
    };
    render(&[], &["no output is requested", "-o", "--aov", "--json"]);
    render(&["-o", "-", "--json"], &["standard output", "use files"]);
    render(&["-o", "-", "--aov", "id=-"], &["standard output", "use files"]);
    render(&["--aov", "mask=-", "--aov", "id=-"], &["standard output", "use files"]);
    render(&["-o", "out.npy", "--aov", "id=out.npy"], &["out.npy", "twice"]);
    render(&["-o", "out.npy", "--aov", "id=./out.npy"], &["out.npy", "twice"]);
    render(&["-o", "out.bmp"], &["out.bmp", ".png, .exr, .npy, .npz, .pfm, .raw, .tif, .jpg or .webp"]);
    render(&["-o", "out"], &["out", ".png, .exr, .npy, .npz, .pfm, .raw, .tif, .jpg or .webp"]);
    render(&["--aov", "certainty=out.png"], &["out.png", "certainty", ".npy"]);
    render(&["--aov", "id"], &["NAME=FILE", ".exr or .npz"]);
    render(&["-o", "out.png", "--aov", "id,depth"], &["id,depth", "has no file", ".exr or .npz"]);
    render(&["-o", "-", "--aov", "id,depth"], &["id,depth", "has no file", ".exr or .npz"]);
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
    let all = ["-o", "out.png", "--eye", "0,0,9", "--at", "0,0,-1", "--view", "0,0,-1"];
    render(&all, &["--eye", "--at", "--view", "remove one of the three"]);
    render(&["-o", "out.png", "--eye", "0,0,9", "--focus", "index 0"], &["--eye", "--focus"]);
    render(&["-o", "out.png", "--view", "above"], &["above", "front, back, left, right, top, bottom, iso, auto"]);
    render(&["-o", "out.png", "--at", "1,2"], &["1,2", "--at", "three finite numbers"]);
    render(&["-o", "out.png", "--focus", "resname"], &["resname", "--focus", "column"]);
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
            dir.refused_with(2, &arguments, &NO_ADAPTER, &["unit", accuracy, "--method"]);
        }
    }
}

#[test]
fn an_invalid_scene_is_exit_code_3() {
    let dir = dir();
    let change = |from: &str, to: &str| {
        assert!(SCENE.contains(from), "{from}");
        dir.put("bad.toml", SCENE.replace(from, to));
    };
    let bad = ["render", "bad.toml", "-o", "out.png", "--aov", "id=id.npy", "--json"];
    change("[0.0, 0.0, -3.0]", "[nan, 0.0, -3.0]");
    dir.refused(3, &bad, &["bad.toml:12", "sphere 0 center", "finite"]);
    change("radius = 1.0", "radius = -1.0");
    dir.refused(3, &bad, &["bad.toml:13", "sphere 0 radius", "positive"]);
    change("radius = 1.0", "radius = 0.0");
    dir.refused(3, &bad, &["bad.toml:13", "sphere 0 radius", "positive"]);
    change("radius", "radios");
    dir.refused(3, &bad, &["bad.toml:13", "radios", "radius"]);
    change("size = [45, 31]", "size = [45, 0]");
    dir.refused(3, &bad, &["bad.toml:8", "image.size", "1048576"]);
    change("up = [0.0, 1.0, 0.0]", "up = [0.0, 0.0, 2.0]");
    dir.refused(3, &bad, &["bad.toml:4", "camera.up", "parallel"]);
    change("[camera]", "[[camera");
    dir.refused(3, &bad, &["bad.toml:1", "correct"]);
    dir.put("bad.toml", b"\x00\xff\xfe\x80garbage");
    dir.refused(3, &bad, &["bad.toml:1"]);
    dir.put("bad.toml", "");
    dir.refused(3, &bad, &["bad.toml", "camera"]);
    dir.refused(
        3,
        &["render", "scene.toml", "-o", "out.png", "--up", "0,0,-5"],
        &["camera.up", "parallel", "another direction"],
    );
    dir.refused(3, &["render", "scene.toml", "-o", "out.png", "--at", "0,0,0"], &["camera"]);

    let balls = [[0.0, 0.0, -3.0, 1.0], [1.0, 0.0, -4.0, 1.0], [-1.0, 0.0, -4.0, 1.0]].concat();
    change("[[sphere]]", "[[spheres]]\nfile = \"balls.npy\"\n[[sphere]]");
    dir.put("balls.npy", npy_of("<f8", "False", "(3, 4)", &little(&balls)));
    let whole = dir.good("render bad.toml --json --backend cpu").json();
    assert_eq!(whole["spheres"], 4);
    dir.put("balls.npy", npy_of("<f8", "False", "(3, 4)", &little(&balls[..9])));
    dir.refused(3, &bad, &["balls.npy", "3 "]);
    dir.remove("balls.npy");
    dir.refused(8, &bad, &["cannot read balls.npy"]);
}

#[test]
fn a_frame_beyond_memory_is_exit_code_5_at_once() {
    let dir = dir();
    let start = Instant::now();
    for backend in ["auto", "cpu"] {
        let arguments = ["render", "scene.toml", "-o", "out.png", "--size", "1048576x1048576", "--backend", backend];
        dir.refused(5, &arguments, &["bytes", "--size"]);
    }
    // Light keeps directions for every sample of a pixel.
    for samples in [1_100_000, 2_000_000_000, u32::MAX] {
        let words = format!("render scene.toml --backend cpu --size 2x2 --samples {samples} -o a.png");
        dir.refused(5, &words, &["samples per pixel are too many", "use at most 1048576"]);
    }
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
}

/// A sparse file of 2e8 spheres.
#[test]
#[cfg(target_os = "linux")]
fn spheres_beyond_memory_are_exit_code_5_with_the_number_that_fits() {
    let dir = dir();
    let header = npy_of("<f8", "False", "(200000000, 4)", &[]);
    dir.put("many.npy", &header);
    let file = fs::File::options().write(true).open(dir.path("many.npy")).expect("the file");
    file.set_len(header.len() as u64 + 32 * 200_000_000).expect("a sparse file");
    dir.put("many.toml", SCENE.replace("[[sphere]]", "[[spheres]]\nfile = \"many.npy\"\n[[sphere]]"));
    let start = Instant::now();
    for command in ["render", "plan"] {
        let mut shell = dir.program("sh");
        shell.args(["-c", "ulimit -v 4000000; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_halfline"), command]);
        // A sky needs all spheres in memory; otherwise the file would be read as a stream.
        shell.args(["many.toml", "-o", "out.png", "--backend", "cpu", "--occlusion"]);
        let Output { code, err, .. } = Output::of(shell.output().expect("sh runs"));
        assert_eq!(code, 5, "{err}");
        assert!(err.contains("200000001 spheres need 6400000032 bytes") && err.contains("read at most 1"), "{err}");
    }
    assert!(!dir.path("out.png").exists() && start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
}

#[test]
fn an_unreadable_or_unwritable_file_is_exit_code_8() {
    let dir = dir();
    fs::create_dir(dir.path("folder.png")).expect("a folder");
    dir.refused(8, &["render", "missing.toml", "-o", "out.png"], &["cannot read missing.toml"]);
    dir.refused(8, &["render", "folder.png", "-o", "out.png"], &["cannot read folder.png"]);
    for target in ["nowhere/out.png", "scene.toml/out.png", "folder.png"] {
        dir.refused(8, &["render", "scene.toml", "-o", target], &["cannot write", target]);
        // The first target is valid, and is not written either.
        let both = format!("color={target}");
        dir.refused(8, &["render", "scene.toml", "--aov", "id=id.npy", "--aov", &both], &["cannot write", target]);
    }
}

/// A retry may help with exit code 8, and no retry repairs a file.
#[test]
fn compressed_files_that_are_cut_or_damaged_are_exit_code_3() {
    let rows: String = (0..3000).map(|k| format!("C {k} {} 0.25\n", k * k % 977)).collect();
    let text = format!("3000\n\n{rows}");
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    gz.write_all(text.as_bytes()).expect("gzip");
    let mut bz2 = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::default());
    bz2.write_all(text.as_bytes()).expect("bzip2");
    for (name, data) in [("a.xyz.gz", gz.finish().expect("gzip")), ("a.xyz.bz2", bz2.finish().expect("bzip2"))] {
        let mut damaged = data.clone();
        damaged[data.len() / 2] ^= 0x10;
        for broken in [&data[..data.len() / 2], &damaged] {
            let dir = dir();
            dir.put(name, broken);
            dir.refused(3, &["render", name, "-o", "out.png"], &[name]);
        }
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_standard_output_is_exit_code_8() {
    let dir = dir();
    for options in [["-o", "-"], ["--aov", "id=-"], ["--json", "--strict"]] {
        let mut command = dir.command("render scene.toml --backend cpu");
        let full = fs::File::options().write(true).open("/dev/full").expect("/dev/full");
        let Output { code, err, .. } = Output::of(command.args(options).stdout(full).output().expect("halfline runs"));
        assert_eq!(code, 8, "{options:?}: {err}");
        assert!(err.contains("cannot write -: No space left") && !err.contains("panicked"), "{err}");
    }
}

#[test]
fn a_difference_is_exit_code_1() {
    let dir = dir();
    dir.render("scene.toml -o a.png");
    dir.render("scene.toml -o b.png --eye 0.01,0,0");
    assert_eq!(dir.run("compare a.png a.png").code, 0);
    assert_eq!(dir.run("compare a.png b.png").code, 1);
}
