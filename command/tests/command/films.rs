//! The promise of `-o film.mp4` and `-o film.gif`: ffmpeg gets the pictures that files would have, in their order; the film is
//! written completely or not at all; where ffmpeg is missing, the error has the line to type.

use crate::skip::skip;
use crate::test_dir::{SPHERE, TestDir};
use std::ffi::OsString;
use std::process::{Command, Stdio};

/// A scene whose sides differ, so that turns do.
fn dir() -> TestDir {
    let more = "\n[[sphere]]\ncenter = [1.5, 0.5, -3.0]\nradius = 0.5\ncolor = [0.9, 0.1, 0.2]\n";
    TestDir::new(&[("s.toml", &format!("{SPHERE}{more}"))])
}

/// Whether ffmpeg is here; otherwise the test is skipped.
pub(crate) fn has_ffmpeg() -> bool {
    let found = ["ffmpeg", "ffprobe"].iter().all(|program| {
        Command::new(program).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
    });
    if !found {
        skip("ffmpeg is not here (Debian: apt-get install ffmpeg)");
    }
    found
}

/// The report of ffprobe on the film's pictures: codec, width, height, pixel format, rate, count.
fn probe(dir: &TestDir, film: &str) -> String {
    let entries = "stream=codec_name,width,height,pix_fmt,r_frame_rate,nb_read_frames";
    let mut command = dir.program("ffprobe");
    command.args(["-v", "error", "-count_frames", "-show_entries", entries, "-of", "csv=p=0", film]);
    String::from_utf8(command.output().expect("ffprobe runs").stdout).expect("text").trim().to_owned()
}

/// The bytes of the pictures as RGB.
fn decoded(dir: &TestDir, film: &str) -> Vec<u8> {
    let mut command = dir.program("ffmpeg");
    command.args(["-v", "error", "-i", film, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]);
    command.output().expect("ffmpeg runs").stdout
}

#[test]
fn films_show_the_pictures() {
    if !has_ffmpeg() {
        return;
    }
    let dir = dir();
    dir.render("s.toml --spin 6 --size 64x48 -o f.%d.png");
    let pixels = |n: usize| image::open(dir.path(&format!("f.{n}.png"))).expect("a picture").to_rgb8().into_raw();
    let pictures: Vec<u8> = (1..=6).flat_map(pixels).collect();
    for (film, rate, expected) in [
        ("film.mp4", "", "h264,64,48,yuv420p,25/1,6"),
        ("Film.GIF", "", "gif,64,48,bgra,25/1,6"),
        ("slow.mp4", "--fps 12.5", "h264,64,48,yuv420p,25/2,6"),
        ("fast.gif", "--fps 90", "gif,64,48,bgra,50/1,6"),
    ] {
        let done = dir.render(&format!("s.toml --spin 6 --size 64x48 {rate} -o {film} --json"));
        assert_eq!(done.json_lines().len(), 6, "{film}: a report for each picture");
        assert_eq!(done.err.contains("50 pictures per second"), film == "fast.gif", "{}", done.err);
        assert_eq!(probe(&dir, film), expected, "{film}");
        let found = decoded(&dir, film);
        assert_eq!(found.len(), pictures.len(), "{film}");
        let apart: u64 = found.iter().zip(&pictures).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
        // Colours at half the resolution, or 256 of them: a few levels at edges. Another picture is off by 20.
        let mean = apart as f64 / pictures.len() as f64;
        assert!(mean < 4.0, "{film}: {mean} levels on average");
    }
    // Even sides, and buffers beside the film.
    let done = dir.render("s.toml --spin 2 --size 33x25 -o odd.mp4 --aov id=id.%d.npy");
    assert!(done.err.contains("even sides"), "{}", done.err);
    assert_eq!(probe(&dir, "odd.mp4"), "h264,32,24,yuv420p,25/1,2");
    assert_eq!(dir.array("id.2.npy").1, [25, 33]);
}

/// A program that stands for ffmpeg, in a folder of its own; the PATH with it.
#[cfg(unix)]
fn stand_in(dir: &TestDir, script: &str) -> OsString {
    use std::os::unix::fs::PermissionsExt;
    let folder = dir.path("bin");
    std::fs::create_dir_all(&folder).expect("a folder");
    let program = folder.join("ffmpeg");
    std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).expect("a script");
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).expect("permissions");
    let others = std::env::var_os("PATH").unwrap_or_default();
    std::env::join_paths([folder].into_iter().chain(std::env::split_paths(&others))).expect("a path")
}

/// The stand-in writes its input to its last argument.
#[cfg(unix)]
#[test]
fn ffmpeg_gets_the_bytes_of_the_pictures_in_order() {
    let dir = dir();
    let path = stand_in(&dir, "for last; do :; done\nexec cat > \"$last\"");
    // What is drawn into pictures is drawn into pictures of a film.
    let drawn = "--size 160x120 --label {frame} --scale-bar";
    for options in ["--size 32x24", "--size 32x24 --repeat 2", "--size 32x24 --progress json", drawn] {
        dir.render(&format!("s.toml --spin 9 -o f.%d.png {options}"));
        let pictures: Vec<u8> = (1..=9).flat_map(|n| dir.get(&format!("f.{n}.png"))).collect();
        let words = format!("render s.toml --backend cpu --spin 9 -o film.mp4 {options}");
        let done = dir.run_with(&words, &[("PATH", path.to_str().expect("text"))]);
        assert_eq!(done.code, 0, "{}", done.err);
        assert!(dir.get("film.mp4") == pictures, "{options}: other pictures");
    }
}

/// The old film stays where the new one fails.
#[cfg(unix)]
#[test]
fn a_failure_leaves_the_old_film() {
    let dir = dir();
    dir.put("film.mp4", "an older film");
    let run = |script: &str, spin: u32| {
        let path = stand_in(&dir, script);
        let before = dir.files();
        let words = format!("render s.toml --backend cpu --spin {spin} --size 64x48 -o film.mp4");
        let done = dir.run_with(&words, &[("PATH", path.to_str().expect("text"))]);
        assert!(dir.files() == before, "{script}: {:?}", dir.files().keys());
        done
    };
    for (script, message) in [
        ("cat > /dev/null; echo 'Unknown encoder libx264' >&2; exit 1", "ffmpeg: Unknown encoder libx264"),
        ("echo 'No space left on device' >&2; exit 1", "ffmpeg: No space left on device"),
        ("exit 3", "ffmpeg: exit status: 3"),
    ] {
        // More bytes than a pipe holds, so that a write fails where the program has ended.
        let done = run(script, 60);
        assert_eq!(done.code, 8, "{script}: {}", done.err);
        assert!(done.err.contains("cannot write film.mp4") && done.err.contains(message), "{script}: {}", done.err);
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_the_old_film() {
    use std::io::{BufRead, BufReader};
    if !has_ffmpeg() {
        return;
    }
    let dir = dir();
    dir.put("film.mp4", "an older film");
    let before = dir.files();
    let words = "render s.toml --backend cpu --spin 100000 --size 64x48 -o film.mp4 --progress json";
    let mut child = dir.command(words).stderr(Stdio::piped()).spawn().expect("halfline runs");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    let started = lines.by_ref().map(|line| line.expect("text")).any(|line| line.contains("\"frame\":9"));
    assert!(started && child.try_wait().expect("its status").is_none());
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.expect("kill runs").success());
    drop(lines);
    assert_eq!(child.wait().expect("an end").code(), Some(130));
    assert!(dir.files() == before, "{:?}", dir.files().keys());
}

#[test]
fn without_ffmpeg_the_error_has_the_line_to_type() {
    let dir = dir();
    let nowhere = dir.path("").display().to_string();
    let run = |film: &str| {
        let words = format!("render s.toml --backend cpu --spin 4 --size 64x48 --fps 10 -o {film}");
        let done = dir.run_with(&words, &[("PATH", &nowhere)]);
        assert_eq!(done.code, 2, "{}", done.err);
        assert!(done.err.contains("film.%04d.png") && done.err.contains("needs the program ffmpeg"), "{}", done.err);
        done.err
    };
    for film in ["film.mp4", "film.gif"] {
        let output = run(film);
        let (_, line) = output.trim().split_once("where ffmpeg is: ").expect("a line to type");
        assert!(line.starts_with("ffmpeg -framerate 10 ") && line.ends_with(film), "{line}");
        if cfg!(unix) && has_ffmpeg() {
            dir.render("s.toml --spin 4 --size 64x48 -o film.%04d.png");
            let typed = dir.program("sh").args(["-c", line]).output().expect("a shell");
            assert!(typed.status.success(), "{line}: {}", String::from_utf8_lossy(&typed.stderr));
            assert!(probe(&dir, film).ends_with(",10/1,4"), "{}", probe(&dir, film));
        }
    }
}

#[test]
fn what_is_no_film_is_refused_with_its_mend() {
    let dir = dir();
    for (options, message) in [
        ("-o a.mp4", &["there is one picture", ".png", "--spin"][..]),
        ("-o a.gif --frames 3", &["there is one picture", "--frames A-B"]),
        ("-o a.%d.mp4 --spin 4", &["one film", "%d"]),
        ("-o a.mp4 --spin 4 --resume", &["--resume", "a.%04d.png"]),
        ("-o a.mp4 --spin 4 --transparent", &["transparent", "--background"]),
        ("-o a.%d.png --spin 4 --fps 10", &["--fps", ".mp4 or .gif"]),
        ("-o a.mp4 --spin 4 --fps 0", &["--fps", "pictures per second"]),
        ("-o a.png --aov depth=a.mp4", &["a.mp4 cannot hold the depth buffer"]),
    ] {
        dir.refused_render(2, &format!("s.toml {options}"), message);
    }
    assert!(!dir.files().keys().any(|name| name.starts_with("a.")), "no file is written");
}

/// A film of a file of several frames needs no option for them.
#[test]
fn a_film_shows_all_frames_of_its_file() {
    if !has_ffmpeg() {
        return;
    }
    let dir = dir();
    dir.put("three.xyz", "1\na\nC 0 0 0\n1\nb\nC 1 0 0\n1\nc\nC 2 0 0\n");
    let all = dir.render("three.xyz --size 32x20 -o all.mp4");
    assert!(all.err.contains("all.mp4 shows all 3 frames of the file"), "{}", all.err);
    dir.render("three.xyz --size 32x20 --frames 1-3 -o named.mp4");
    assert_eq!(dir.get("all.mp4"), dir.get("named.mp4"));
    // What cannot be read is said, and not that there is one picture.
    dir.refused_render(8, "missing.xyz -o all.gif", &["missing.xyz"]);
    dir.put("cut.xyz", "1\na\nC 0 0 0\n1\nb\nC 1 0\n");
    let cut = dir.run("render --backend cpu cut.xyz --size 32x20 -o all.gif");
    assert!(cut.code == 3 && cut.err.contains("cut.xyz:6:"), "{}", cut.err);
}

/// docs/film.md: the pictures of a film have one size, which is known before any is rendered where the list says it.
#[test]
fn films_have_pictures_of_one_size() {
    if !has_ffmpeg() {
        return;
    }
    let dir = dir();
    let camera = |size: &str| format!("{{\"eye\":[0,0,3],\"view\":[0,0,-1],\"up\":[0,1,0],\"vfov\":30{size}}}");
    let list = |sizes: &[&str]| format!("[{}]", sizes.iter().map(|size| camera(size)).collect::<Vec<_>>().join(","));
    let (small, large) = (",\"size\":[32,20]", ",\"w\":64,\"h\":48");
    for film in ["o.mp4", "o.gif"] {
        for (sizes, words) in [
            (&[large, small][..], "picture 1 has 64 x 48 pixels, and picture 2 has 32 x 20 pixels"),
            (&[small, small, small, large], "picture 4 has 64 x 48 pixels"),
            // The size of a scene file is known when it is read.
            (&["", small], "picture 2 has 32 x 20 pixels"),
        ] {
            dir.put("list.json", list(sizes));
            let refused = dir.run(&format!("render s.toml --backend cpu --cameras list.json -o {film}"));
            assert!(refused.code == 2 && refused.err.contains(words), "{}", refused.err);
            assert!(refused.err.contains("--size"), "{}", refused.err);
            assert_eq!(sizes[0].is_empty(), refused.err.contains("rendering on"), "{}", refused.err);
            let left: Vec<String> = dir.files().into_keys().filter(|name| !name.starts_with(['s', 'l'])).collect();
            assert!(left.is_empty(), "{left:?}");
            dir.render(&format!("s.toml --cameras list.json --size 40x30 -o {film}"));
            dir.render(&format!("s.toml --cameras list.json --crop 2,3,20,15 -o {film}"));
            dir.remove(film);
            dir.remove("cameras.json");
        }
        // Cameras that no picture has do not count.
        dir.put("list.json", list(&[small, small, large]));
        dir.put("run.xyz", "1\n\nC 0 0 0\n".repeat(3));
        dir.render(&format!("run.xyz --frames 1-2 --cameras list.json -o {film}"));
        dir.remove(film);
        dir.remove("cameras.json");
        dir.remove("run.xyz");
    }
}
