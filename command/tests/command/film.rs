//! The promise of films: camera, default radii and the range of colours are the same in all frames, a frame rendered
//! alone is the same file as in the film, and pictures and reports give their camera back.

use crate::films::has_ffmpeg;
use crate::test_dir::TestDir;
use serde_json::Value;
use std::fmt::Write as _;
use std::io::Write as _;
use std::process::Stdio;

/// Frames of a gas that expands: its box, and the values of its column, grow from frame to frame.
fn gas(frames: u32) -> String {
    let (mut text, mut state) = (String::new(), 1_u64);
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for frame in 1..=frames {
        let side = 8.0 + 0.2 * f64::from(frame);
        writeln!(text, "ITEM: TIMESTEP\n{frame}\nITEM: NUMBER OF ATOMS\n60\nITEM: BOX BOUNDS pp pp pp").expect("text");
        writeln!(text, "0 {side}\n0 {side}\n0 {side}\nITEM: ATOMS id type x y z c_ke").expect("text");
        for id in 1..=60 {
            let [x, y, z] = [random(), random(), random()].map(|x| x * side);
            writeln!(text, "{id} 1 {x:.6} {y:.6} {z:.6} {:.6}", random() * f64::from(frame)).expect("text");
        }
    }
    text
}

fn reports(dir: &TestDir, options: &str) -> Vec<Value> {
    dir.render(&format!("gas.dump --size 64x48 --json {options}")).json_lines()
}

#[test]
fn a_film_of_a_hundred_frames_has_one_camera_one_radius_and_one_range() {
    let dir = TestDir::new(&[("gas.dump", &gas(100))]);
    let film = reports(&dir, "--frames 1-100 --color-by c_ke -o f%03d.png --aov distance=d%03d.npy --legend l.svg");
    assert_eq!(film.len(), 100);
    for (n, report) in film.iter().enumerate() {
        assert_eq!(
            (&report["camera"], &report["hold"]),
            (&film[0]["camera"], &Value::from("first")),
            "frame {}",
            n + 1
        );
        assert_eq!(report["number"], n as u64 + 1);
    }
    // On a farm each frame is rendered alone.
    let files = dir.files();
    for n in [1, 2, 57, 100] {
        let alone = reports(&dir, &format!("--frames {n} --color-by c_ke -o alone.png --aov distance=alone.npy"));
        assert_eq!(alone[0]["camera"], film[0]["camera"], "frame {n}");
        assert!(dir.get("alone.png") == files[&format!("f{n:03}.png")], "frame {n} is another picture");
        assert!(dir.get("alone.npy") == files[&format!("d{n:03}.npy")], "frame {n} has other distances");
    }
    // Every frame by itself has another camera, and another radius: the gas expands.
    let each = reports(&dir, "--frames 1-3 --color-by c_ke --hold none");
    assert_eq!(each[0]["camera"], film[0]["camera"]);
    assert!(each[1]["camera"] != each[0]["camera"] && each[2]["camera"] != each[1]["camera"]);
    let stderr = |options: &str| dir.render(&format!("gas.dump --size 64x48 --json --frames 50 {options}")).err;
    assert!(stderr("").contains("come from the first frame of the file (see --hold)"));
    let first = film[0]["warnings"][0].as_str().expect("a warning");
    assert!(first.contains("half the mean spacing") && stderr("").contains(first), "{first}: {}", stderr(""));
    assert!(!stderr("--hold none").contains("held"));
}

/// A warning that every picture has is printed once for a film, although its numbers differ; each report has its own.
#[test]
fn a_film_says_a_warning_once() {
    let mut frames = gas(1);
    for frame in 2..=5 {
        // Each frame has one particle less than the one before.
        let one = gas(1).replace("\n60\n", &format!("\n{}\n", 61 - frame));
        let lines = one.lines().count() - frame as usize + 1;
        frames += &(one.lines().take(lines).collect::<Vec<_>>().join("\n") + "\n");
    }
    let dir = TestDir::new(&[("gas.dump", &frames)]);
    for hold in ["first", "none"] {
        let film = dir.render(&format!("gas.dump --size 8x8 --json --frames 1-5 --hold {hold}"));
        assert_eq!(film.err.matches("no radius").count(), 1, "{hold}: {}", film.err);
        for (n, report) in film.json_lines().iter().enumerate() {
            let warning = report["warnings"][0].as_str().expect("a warning");
            assert!(warning.starts_with(&format!("{} particles have no radius", 60 - n)), "{hold}: {warning}");
        }
    }
    // Two warnings of one picture that differ in their numbers are two.
    let two = dir.render(&["gas.dump", "--size", "8x8", "--json", "--hide", "id 77", "--hide", "id 88"]);
    assert_eq!(two.err.matches("no particle has it").count(), 2, "{}", two.err);
}

/// An extended XYZ file with these particles in each frame: kind, position on the x axis, and a value.
fn named(frames: &[&[(&str, f64, f64)]]) -> String {
    let mut text = String::new();
    for frame in frames {
        writeln!(text, "{}\nProperties=species:S:1:pos:R:3:kind:S:1:v:R:1", frame.len()).expect("text");
        frame.iter().for_each(|(kind, x, v)| writeln!(text, "C {x} 0 0 {kind} {v}").expect("text"));
    }
    text
}

#[test]
fn a_film_is_fixed_to_the_first_frame_that_shows_something() {
    let frames: [&[(&str, f64, f64)]; 4] = [
        &[],
        &[("other", 5.0, 3.0)],
        &[("b", 4.0, 0.0), ("a", 0.0, 0.0)],
        // The same spheres in another order, and one of a new name behind the first.
        &[("c", 0.0, 7.0), ("a", 0.0, 2.0), ("b", 4.0, 1.0)],
    ];
    let dir = TestDir::new(&[("kinds.xyz", &named(&frames))]);
    let selected = |options: &str| {
        let options: Vec<&str> = options.split_whitespace().collect();
        dir.render(&[&["kinds.xyz", "--select", "kind a b"][..], &options].concat())
    };
    for hold in ["first", "all"] {
        let run = |options: &str| {
            let fixed = "--color-by kind --radius 0.5 --shade flat --size 40x30 --json";
            selected(&format!("{fixed} --hold {hold} {options}"))
        };
        let film = run("--frames 1-4 -o f%d.png").json_lines();
        assert_eq!((film[0]["spheres"].as_u64(), film[3]["spheres"].as_u64()), (Some(0), Some(2)));
        assert_eq!(film[2]["camera"], film[3]["camera"], "{hold}");
        let pixels = |name: &str| image::open(dir.path(name)).expect(name).to_rgb8().into_raw();
        assert!(pixels("f3.png") == pixels("f4.png"), "{hold}: other colours for the same names");
        let mut colors: Vec<[u8; 3]> = pixels("f3.png").as_chunks().0.to_vec();
        colors.sort_unstable();
        colors.dedup();
        assert!(colors.len() > 2, "two colours on the background");
        let alone = run("--frames 4 -o alone.png").json_lines();
        assert_eq!(alone[0]["camera"], film[2]["camera"], "{hold}");
        assert!(dir.get("alone.png") == dir.get("f4.png"), "{hold}: alone");
    }
    // All values of the first frame with spheres are equal: a range without a width, which is said.
    for (options, is_reported) in
        [("3-4", true), ("4", true), ("3-4 --hold all", false), ("3-4 --range 0,2", false), ("3", false)]
    {
        let err = selected(&format!("--color-by v --size 40x30 --json --frames {options}")).err;
        assert_eq!(err.contains("all values of v in frame 3 are 0"), is_reported, "{options}: {err}");
    }
}

/// Frames whose two spheres come nearer from frame to frame, on the x axis at 16 and 20, 12 and 16, and so on.
#[test]
fn a_film_whose_first_frames_are_clipped_away_has_the_camera_of_the_first() {
    let frames: Vec<_> =
        (0..5).map(|n| [("a", 16.0 - 4.0 * f64::from(n), 0.0), ("b", 20.0 - 4.0 * f64::from(n), 1.0)]).collect();
    let frames: Vec<&[(&str, f64, f64)]> = frames.iter().map(|frame| &frame[..]).collect();
    let dir = TestDir::new(&[("near.xyz", &named(&frames))]);
    let run = |options: &str| dir.render(&format!("near.xyz --radius 1 --size 40x30 --json {options}")).json_lines();
    let unclipped = run("--frames 1");
    // Spheres are left from the third frame on, at 8.
    for (hold, expected) in [("first", Some(&unclipped[0]["camera"])), ("all", None)] {
        let clip = format!("--clip 1,0,0,9 --hold {hold}");
        let film = run(&format!("{clip} --frames 1-5 -o f%d.png"));
        let counts: Vec<_> = film.iter().map(|report| report["spheres"].as_u64().expect("a count")).collect();
        assert_eq!(counts, [0, 0, 1, 2, 2]);
        let camera = expected.unwrap_or(&film[0]["camera"]);
        film.iter().for_each(|report| assert_eq!(report["camera"], *camera, "{hold}, {}", report["number"]));
        for n in [2, 3, 5] {
            let alone = run(&format!("{clip} --frames {n} -o alone.png"));
            assert_eq!(alone[0]["camera"], *camera, "{hold}, {n} alone");
            assert!(dir.get("alone.png") == dir.get(&format!("f{n}.png")), "{hold}, {n} alone");
        }
    }
    let each = run("--clip 1,0,0,9 --hold none --frames 4-5");
    assert_ne!(each[0]["camera"], each[1]["camera"]);
}

#[test]
fn a_frame_alone_says_what_the_film_says() {
    let atom = |x: u32| format!("{:5}{:<5}{:>5}{:5}{:8.3}{:8.3}{:8.3}\n", 1, "MOL", "Q9", 1, x, 0.0, 0.0);
    let frame = |x: u32| format!("title\n    1\n{}   9.0   9.0   9.0\n", atom(x));
    let dir = TestDir::new(&[("two.gro", &(frame(1) + &frame(2)))]);
    let stderr = |options: &str| dir.render(&format!("two.gro --size 8x8 --json --frames {options}")).err;
    let film = stderr("1-2");
    let line = film.lines().find(|line| line.contains("element")).unwrap_or_else(|| panic!("{film}"));
    assert!(stderr("2").contains(line), "{}", stderr("2"));
}

/// With --hold all the percentiles are over the values of all frames, as in NumPy.
#[test]
fn percentiles_of_a_film_are_those_of_all_frames() {
    let frame = |first: usize| {
        let rows = (0..10).map(|n| format!("C {n} 0 0 {}\n", first + n));
        format!("10\nProperties=species:S:1:pos:R:3:q:R:1\n{}", rows.collect::<String>())
    };
    let dir = TestDir::new(&[("film.xyz", &[0, 10].map(frame).concat())]);
    let film = "film.xyz --frames 1-2 --size 60x20 --color-by q --hold all";
    dir.render(&format!("{film} --range 10%,90% -o a%d.png"));
    // Of 0 to 19.
    dir.render(&format!("{film} --range 1.9,17.1 -o b%d.png"));
    dir.render(&format!("{film} --range 10%,17.1 -o c%d.png"));
    for k in 1..=2 {
        let pixels = |name: char| dir.get(&format!("{name}{k}.png"));
        assert!(pixels('a') == pixels('b') && pixels('c') == pixels('b'), "picture {k}");
    }
    dir.render("film.xyz --frames 1-2 --size 60x20 --color-by q --range 10%,90% -o d%d.png");
    assert!(dir.get("d1.png") != dir.get("b1.png"), "percentiles of the first frame");
}

#[test]
fn hold_all_shows_every_frame_completely() {
    let dir = TestDir::new(&[("gas.dump", &gas(20))]);
    let all = reports(&dir, "--frames 1-20 --color-by c_ke --hold all -o f%d.png --aov id=i%d.npy --samples 1");
    assert!(all.iter().all(|report| report["camera"] == all[0]["camera"] && report["hold"] == "all"));
    // The last frame is the largest; no sphere touches the border of any picture.
    for n in 1..=20 {
        let (ids, shape) = dir.array(&format!("i{n}.npy"));
        let [rows, columns] = shape[..] else { panic!("{shape:?}") };
        let border = |at: usize| {
            let (row, column) = (at / columns, at % columns);
            row == 0 || column == 0 || row + 1 == rows || column + 1 == columns
        };
        assert!(ids.iter().enumerate().all(|(at, id)| *id < 0.0 || !border(at)), "frame {n} is cut");
    }
    let alone = reports(&dir, "--frames 7 --color-by c_ke --hold all -o alone.png --samples 1");
    assert_eq!(alone[0]["camera"], all[0]["camera"]);
    assert!(dir.get("alone.png") == dir.get("f7.png"));
    let mut fed = vec!["render", "-", "--format", "dump", "--frames", "1-2", "--hold", "all", "--json"];
    fed.extend(["--backend", "cpu"]);
    let output = dir.run_fed(&fed, gas(2).as_bytes());
    assert!(output.code == 2 && output.err.contains("standard input can be read once"), "{}", output.err);
}

#[test]
fn pictures_and_reports_give_their_camera_back() {
    let dir = TestDir::new(&[("gas.dump", &gas(3)), ("other.xyz", "2\n\nC 0 0 0\nO 9 9 9\n")]);
    let first = reports(&dir, "--frames 2 --view 1,2,-3 --vfov 12.5 -o a.png --aov depth=d.npy --aov depth,id=a.exr");
    dir.put("report.json", first[0].to_string());
    let pictures = ["a.png", "d.npy", "a.exr", "report.json"];
    for file in pictures {
        let again = reports(&dir, &format!("--frames 2 --camera-from {file} --aov depth=again.npy"));
        let bits = |name: &str| dir.array(name).0.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        assert!(bits("again.npy") == bits("d.npy"), "{file}: other depths");
        let (mut old, mut new) = (first[0]["camera"].clone(), again[0]["camera"].clone());
        // `at` is not kept where a view was given; both have the same numbers otherwise.
        for camera in [&mut old, &mut new] {
            camera.as_object_mut().expect("an object").remove("at");
        }
        assert_eq!(old, new, "{file}");
    }
    let size = dir.render("other.xyz --json --camera-from a.png").json();
    assert_eq!(size["camera"], first[0]["camera"], "the picture gives the size");
    let wide = dir.render("other.xyz --json --camera-from a.png --size 128x48").json();
    let side = |report: &Value, k: usize| report["camera"]["viewport"][k].as_f64().expect("a number");
    assert_eq!(side(&wide, 1), side(&size, 1));
    // One rounding for the product and one for the quotient.
    assert!((side(&wide, 0) / side(&size, 0) - 2.0).abs() <= 4.0 * f64::EPSILON);
    let plan = dir.good("plan other.xyz --backend cpu --json --camera-from a.png").json();
    assert_eq!(plan["camera"], size["camera"]);
    dir.put("no.json", "{\"spheres\": 3}\n");
    dir.put("empty.json", "");
    dir.refused_render(3, "other.xyz --json --camera-from no.json", &["no.json: camera: the file has no camera"]);
    dir.refused_render(8, "other.xyz --json --camera-from none.png", &["none.png"]);
    dir.refused_render(3, "other.xyz --json --camera-from empty.json", &["empty.json"]);
    dir.refused_render(2, "other.xyz --json --camera-from a.png --eye 0,0,9", &["--camera-from", "--eye"]);
    dir.refused_render(2, "other.xyz -o a.png --camera-from a.png", &["a.png"]);
}

#[test]
fn frames_on_standard_output_are_a_film_for_ffmpeg() {
    if !has_ffmpeg() {
        return;
    }
    let dir = TestDir::new(&[("gas.dump", &gas(7))]);
    let film = dir.render("gas.dump --size 64x48 --frames 1-7 --color-by c_ke -o -").out;
    let mut command = dir.program("ffmpeg");
    command.args("-v error -f image2pipe -c:v png -i - -f rawvideo -pix_fmt rgb24 -".split(' '));
    let mut ffmpeg = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("ffmpeg runs");
    let mut pipe = ffmpeg.stdin.take().expect("a pipe");
    let fed = std::thread::spawn(move || pipe.write_all(&film));
    let frames = ffmpeg.wait_with_output().expect("ffmpeg ends").stdout;
    fed.join().expect("a thread").expect("ffmpeg takes all frames");
    assert_eq!(frames.len(), 7 * 64 * 48 * 3, "seven frames of three bytes per pixel");
    let pictures: Vec<&[u8]> = frames.chunks(64 * 48 * 3).collect();
    assert!(pictures.windows(2).all(|two| two[0] != two[1]), "the particles move");
}
