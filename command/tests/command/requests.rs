//! Outputs are written, or a message says why not. Spheres that are hidden do not change those that are shown.

use crate::amount::amount;
use crate::page::{Page, check_stills};
use crate::rng::Rng;
use crate::test_dir::TestDir;
use halfline_files::read::{ParticleOptions, ReadOptions, Sequence};
use serde_json::{Value, json};

/// Two frames of particles without radii and elements, the second with a column `q`; of the second frame half are as fast
/// as 3.
fn dump() -> String {
    let frame = |n: usize| {
        let q = if n == 2 { " q" } else { "" };
        let atom = |k: usize| {
            let (x, y, z) = (k % 3, k / 3 % 3, k / 9);
            let q = if n == 2 { format!(" {}", k % 5) } else { String::new() };
            format!("{} 1 {x} {y} {z} {} 0 0{q}\n", k + 1, 3 * (k % 2))
        };
        format!(
            "ITEM: TIMESTEP\n{n}\nITEM: NUMBER OF ATOMS\n27\nITEM: BOX BOUNDS pp pp pp\n0 4\n0 4\n0 4\n\
             ITEM: ATOMS id type x y z vx vy vz{q}\n{}",
            (0..27).map(atom).collect::<String>()
        )
    };
    frame(1) + &frame(2)
}

const TABLE: &str = "x,y,z,kind,q\n0,0,0,a,nan\n1,0,0,b,nan\n0,1,0,a,nan\n4,4,4,b,nan\n";

fn dir() -> TestDir {
    TestDir::new(&[
        ("run.dump", &dump()),
        ("t.csv", TABLE),
        ("cell.xyz", "2\nLattice=\"4 0 0 0 4 0 0 0 4\" Properties=species:S:1:pos:R:3\nC 1 1 1\nO 2 1 1\n"),
    ])
}

#[test]
fn planes_that_remove_all_say_so() {
    let dir = dir();
    let all = ["1,0,0,-9", "-1,0,0,-9", "0,0,1,-0.5"];
    for cell in ["", "--cell", "--cell=0.2", "--cell --copies 2,1,1", "--copies 2,1,1"] {
        for plane in all {
            let done = dir.render(&format!("cell.xyz --clip {plane} {cell} --size 16x12 -o a.png --json"));
            let warnings = done.json()["warnings"].to_string();
            assert!(
                warnings.contains("removes all 2 spheres") && done.err.contains("removes all"),
                "{plane} {cell}: {warnings}"
            );
        }
        let kept = dir.render(&format!("cell.xyz --clip 1,0,0,1.5 {cell} --size 16x12 -o a.png")).err;
        assert!(!kept.contains("removes all"), "{cell}: {kept}");
    }
    let camera = "--eye 0,0,9 --at 0,0,0 --size 16x12";
    let copied = dir.render(&format!("cell.xyz --stream --copies 2,1,1 {camera} --clip 1,0,0,-9 -o a.png")).err;
    assert!(copied.contains("removes all 2 spheres"), "{copied}");
    let streamed = dir.render(&format!("t.csv --radius 1 --stream {camera} --clip 1,0,0,-9 -o a.png")).err;
    let sifted = dir.good(&format!("sift t.csv --radius 1 --first-id 0 {camera} --clip 1,0,0,-9 -o a.npz")).err;
    assert!(
        streamed.contains("removes all 4 spheres") && sifted.contains("removes all 4 spheres"),
        "{streamed} {sifted}"
    );
}

#[test]
fn what_cannot_be_drawn_is_reported() {
    let dir = dir();
    for legend in ["--legend l.svg", "--legend l.png", "--legend-in"] {
        let option = legend.split(' ').next().expect("an option");
        let stderr = |options: &str| dir.render(&format!("t.csv {options} --size 300x200 {legend} -o a.png")).err;
        for (options, why) in [
            ("--color-by q", "no value of q is a number; --range LOW,HIGH"),
            ("--color-by q --log", "no value of q is a number; --range LOW,HIGH"),
            ("--color-by kind --select=x>9", "there are no spheres"),
        ] {
            let err = stderr(options);
            assert!(err.contains(&format!("warning: {option}: there is no legend, because {why}")), "{options}: {err}");
        }
        assert!(!stderr("--color-by q --range 0,1").contains("no legend"), "{legend}");
    }
    let frames =
        dir.render("run.dump --frames 2 --color-by q --log --range 1,9 --legend l%d.svg --size 16x12 -o a.png").err;
    assert!(!frames.contains("no legend") && !dir.get("l2.svg").is_empty(), "{frames}");
    for (output, is_lost) in [("a.npy", true), ("a.pfm", true), ("a.png", false), ("a.npz", false), ("a.exr", false)] {
        let err = dir.render(&format!("t.csv --transparent --size 16x12 -o {output}")).err;
        assert_eq!(err.contains("no file has the alpha"), is_lost, "{output}: {err}");
    }
    dir.refused_render(2, "t.csv --map plasma -o b.png", &["--map", "--color-by"]);
    dir.refused_render(2, "cell.xyz --color-by element --range 0,1 -o b.png", &["--range", "column"]);
}

#[test]
fn a_name_is_numbered_only_where_it_has_a_place() {
    let dir = dir();
    for name in ["50%dense.png", "100%.png", "%dark.png", "a%3dx.png", "n%.png"] {
        dir.render(&["t.csv", "--size", "16x12", "-o", name]);
        assert!(!dir.get(name).is_empty());
    }
    dir.refused_render(2, "run.dump --frames 1-2 -o 50%dense.png", &["50%dense.png", "50%dense.%04d.png"]);
    dir.render("run.dump --frames 1-2 --size 16x12 -o 50%dense.%02d.png --aov id=100%%.%d.npy");
    for name in ["50%dense.01.png", "50%dense.02.png", "100%.1.npy", "100%.2.npy"] {
        assert!(!dir.get(name).is_empty());
    }
}

/// Frame 1 has no column `q`.
#[test]
fn a_frame_needs_nothing_of_frames_that_are_not_requested() {
    let dir = dir();
    for options in [
        "--color-by q --range 0,9",
        "--color-by q",
        "--color-by q --hold all",
        "--color-by q --hold none",
        "--select=q>2",
        "--hide=q>2 --color-by q",
        "--radius=q>2=0.7",
        "--color=q>2=red",
    ] {
        let err = dir.render(&format!("run.dump --frames 2 {options} --size 16x12 -o a.png")).err;
        let is_first_read = !options.contains("--hold none");
        assert_eq!(err.contains("frame 1 is not what the others are held to"), is_first_read, "{options}: {err}");
        dir.refused_render(2, &format!("run.dump --frames 1 {options} -o b.png"), &["q"]);
        dir.refused_render(2, &format!("run.dump --frames 1-2 {options} -o b%d.png"), &["q"]);
    }
    // Nor need it be valid.
    dir.put("bad.dump", dump().replacen("1 1 0 0 0 0 0 0", "1 1 0 nan? 0 0 0 0", 1));
    dir.put("bad.xyz", "2\nbad\nC 0 0 zero\nC 1 0 0\n2\ngood\nC 0 0 0\nC 9 0 0\n");
    for file in ["bad.dump", "bad.xyz"] {
        let err = dir.render(&format!("{file} --frames 2 --size 16x12 -o a.png")).err;
        assert!(err.contains("frame 1 is not what the others are held to"), "{err}");
        dir.refused_render(3, &format!("{file} --frames 1 -o b.png"), &[&format!("{file}:")]);
        dir.refused_render(3, &format!("{file} --frames 1-2 -o b%d.png"), &[&format!("{file}:")]);
    }
    dir.put("hole.dump", dump() + &dump().replacen("1 1 0 0 0 0 0 0", "1 1 0 nan? 0 0 0 0", 1));
    for (file, options, frame) in [
        ("run.dump", "--color-by q", 2),
        ("bad.dump", "--color-by q", 2),
        ("bad.xyz", "", 2),
        ("hole.dump", "", 4),
        ("hole.dump", "--color-by q", 4),
    ] {
        let page = Page::open(&dir, &format!("{file} --frames 2 {options} --backend cpu"));
        let camera = page.good("/scene", &json!({}))["camera"].clone();
        for frame in [2, frame] {
            let body = json!({ "camera": camera, "size": [40, 30], "mode": "still", "frame": frame });
            let (still, words) = page.still(&body);
            dir.good(&words);
            assert!(still == dir.get(words.last().expect("a file")), "{file} {options} {frame}");
        }
    }
}

/// The radii of the frames that are read with these options.
fn radii(dir: &TestDir, file: &str, frames: &str, select: &[&str], hide: &[&str]) -> Vec<Vec<f64>> {
    let parsed = |all: &[&str]| all.iter().map(|text| text.parse().expect("an expression")).collect();
    let frames = frames.parse().expect("frames");
    let options = ReadOptions {
        particles: ParticleOptions { frames, select: parsed(select), hide: parsed(hide), ..Default::default() },
        ..ReadOptions::default()
    };
    let mut sequence = Sequence::open(&dir.path(file), &options).expect("a file");
    let next = || sequence.next_scene().expect("a scene").map(|frame| frame.scene.spheres.radii.to_vec());
    std::iter::from_fn(next).collect()
}

#[test]
fn the_radius_is_of_the_file_whatever_is_selected() {
    let dir = dir();
    let mut rng = Rng::new(5);
    let expected = radii(&dir, "run.dump", "1", &[], &[])[0][0];
    for _ in 0..40 {
        let mut pick = || {
            let [low, high] = [0, 1].map(|_| (rng.unit() * 27.0) as u32);
            let words = ["velocity > 2", "velocity < 2", "x > 1", "z = 2", "x < 0", "not y = 1"];
            let word = words[(rng.unit() * words.len() as f64) as usize].to_owned();
            if rng.unit() < 0.5 { format!("id {}:{}", low.min(high), low.max(high)) } else { word }
        };
        let [select, hide] = [pick(), pick()];
        for frames in ["1", "2", "1-2"] {
            let found = radii(&dir, "run.dump", frames, &[&select], &[&hide]);
            assert!(found.iter().flatten().all(|radius| *radius == expected), "{select}, {hide}, {frames}: {found:?}");
        }
    }
    // Atoms whose element is unknown have the radius of such atoms beside others whose element is known.
    dir.put("odd.xyz", "3\nodd\nC 0 0 0\nQq 9 0 0\nQq 18 0 0\n");
    assert_eq!(radii(&dir, "odd.xyz", "1", &[], &["element C"])[0][..], radii(&dir, "odd.xyz", "1", &[], &[])[0][1..]);
    // What the page shows and picks is the same.
    let words = ["view", "run.dump", "--select", "velocity > 2", "--backend", "cpu", "--port", "0", "--no-open"];
    let page = Page::of(dir.command(&words));
    let camera = page.good("/scene", &json!({}))["camera"].clone();
    let picks = (0..400).map(|n| json!({ "camera": camera, "size": [20, 20], "x": n % 20, "y": n / 20 }));
    let picked = picks.map(|pick| page.good("/pick", &pick)).find(|pick| !pick.is_null()).expect("a sphere");
    assert_eq!(picked["radius"], json!(expected));
}

#[test]
fn colours_are_of_the_file_whatever_is_selected() {
    let dir = dir();
    dir.put("c.csv", "x,y,z,radius,r,g,b\n0,0,0,1,255,128,0\n3,0,0,1,1,0,1\n");
    let colors = |select: &[&str]| {
        let select = select.iter().map(|text| text.parse().expect("an expression")).collect();
        let mut sequence = Sequence::open(
            &dir.path("c.csv"),
            &ReadOptions { particles: ParticleOptions { select, ..Default::default() }, ..ReadOptions::default() },
        )
        .expect("a file");
        let frame = sequence.next_scene().expect("a scene").expect("a frame");
        frame.scene.spheres.colors.expect("colours").to_vec()
    };
    assert_eq!(colors(&["x > 1"])[..], colors(&[])[1..]);
}

/// The length of a vector has its name in colours and selections, wherever columns are looked up.
#[test]
fn a_length_is_a_column_everywhere() {
    let dir = dir();
    dir.put("f.xyz", "2\nProperties=species:S:1:pos:R:3:forces:R:3\nC 0 0 0 3 4 0\nC 9 0 0 0 0 1\n");
    dir.put("f.csv", "x,y,z,radius,vel_x,vel_y,vel_z,m_x,m_y\n0,0,0,1,3,0,4,0,5\n9,0,0,1,0,1,0,1,0\n");
    for (file, name) in
        [("run.dump", "velocity"), ("f.xyz", "forces"), ("f.csv", "velocity"), ("f.csv", "m"), ("f.csv", "Vel")]
    {
        let select = format!("{name} > 2");
        let done = dir.render(&[
            file,
            "--select",
            &select,
            "--color-by",
            name,
            "--range",
            "0,3",
            "--size",
            "16x12",
            "-o",
            "a.png",
        ]);
        let words =
            ["view", file, "--color-by", name, "--range", "0,3", "--backend", "cpu", "--port", "0", "--no-open"];
        let page = Page::of(dir.command(&words));
        let scene = page.good("/scene", &json!({}));
        let selected = page.good("/select", &json!({ "expr": select }));
        let expected = if file == "run.dump" { 13 } else { 1 };
        assert_eq!(
            (&selected["count"], &selected["notes"]),
            (&json!(expected), &json!([])),
            "{file} {name}: {}",
            done.err
        );
        let (still, words) =
            page.still(&json!({ "camera": scene["camera"], "size": [40, 30], "mode": "still", "select": select }));
        dir.good(&words);
        assert!(still == dir.get(words.last().expect("a file")), "{file} {name}");
    }
    dir.refused_render(2, "f.csv --color-by n -o b.png", &["no column `n`"]);
}

/// Requests with numbers that nothing can have are answered, and the page is still there.
#[test]
fn a_page_bounds_every_number_of_a_request() {
    let dir = dir();
    let page = Page::open(&dir, "t.csv --backend cpu");
    let camera = page.good("/scene", &json!({}))["camera"].clone();
    let mut rng = Rng::new(9);
    let numbers: [Value; 14] = [
        json!(0),
        json!(1),
        json!(-1),
        json!(4_294_967_295_u64),
        json!(4_294_967_296_u64),
        json!(u64::MAX),
        json!(i64::MIN),
        json!(1e308),
        json!(-1e308),
        json!(5e-324),
        json!(65536),
        json!(1e15),
        json!(0.5),
        json!(2_147_483_648_u64),
    ];
    let fields = [
        "size", "samples", "frame", "x", "y", "from", "seq", "eye", "at", "up", "vfov", "height", "lens", "clip",
        "opacity", "layers",
    ];
    for n in 0..300 {
        let mut number = || numbers[(rng.unit() * numbers.len() as f64) as usize].clone();
        let mut body = json!({ "camera": camera, "size": [32, 24], "mode": if n % 2 == 0 { "still" } else { "move" }, "x": 3, "y": 4 });
        let values = [number(), number(), number()];
        let field = fields[n % fields.len()];
        match field {
            "size" => body["size"] = json!(values[..2]),
            "eye" | "at" | "up" => body["camera"][field] = json!(values),
            "vfov" => body["camera"]["vfov"] = values[0].clone(),
            "height" => {
                body["camera"].as_object_mut().expect("a camera").remove("vfov");
                body["camera"]["height"] = values[0].clone();
            }
            "lens" => {
                let camera = body["camera"].as_object_mut().expect("a camera");
                camera.remove("vfov");
                let name = ["fisheye", "equirectangular", "opencv"][n % 2 + usize::from(n % 5 == 0)];
                let [a, b, c] = &values;
                let pixels = json!([[a, b, c, 3], [32, 24]]);
                let lens = match n % 3 {
                    0 => json!({ "name": name, "half": a, "vfov": b }),
                    1 => json!({ "name": name, "half": 1, "intrinsics": pixels }),
                    _ => {
                        json!({ "name": name, "half": 1, "intrinsics": pixels, "coefficients": [a, b, 0, 0, c, 0, 0, 0] })
                    }
                };
                camera.insert("lens".into(), lens);
            }
            "samples" | "clip" | "opacity" | "layers" => {
                let texts = values.each_ref().map(Value::to_string);
                body["options"] = match field {
                    "clip" => json!({ field: [format!("{},2", texts.join(","))] }),
                    _ => json!({ field: texts[..1] }),
                };
            }
            _ => body[field] = values[0].clone(),
        }
        for route in ["/frame", "/pick", "/fit", "/command"] {
            // What render itself would take long for is not asked for.
            let is_long = field == "samples"
                && values[0].as_f64().is_some_and(|samples| samples > 1e3)
                && route == "/frame"
                && n % 2 == 0;
            let reply = page.ask(route, &body);
            assert!([200, 204, 400].contains(&reply.status), "{route} {body}: {} {}", reply.status, reply.json());
            assert!(!is_long || reply.status == 400, "{route} {body}");
        }
    }
    assert_eq!(page.good("/scene", &json!({}))["count"], 4);
}

/// Every option of a page against the bytes of the command that it copies.
#[test]
fn drawn_options_have_the_bytes_of_their_command() {
    let dir = dir();
    let options = [
        "--transparent",
        "--background teal",
        "--samples 9",
        "--seed 4 --samples 4",
        "--exposure -0.5",
        "--tone soft",
        "--shade normal",
        "--look plain",
        "--look figure",
        "--occlusion 8",
        "--occlusion --reach 3",
        "--sun 1,2,3",
        "--shadows",
        "--silhouette",
        "--outline-width 3",
        "--outline-color teal",
        "--depth-cue",
        "--radius 0.4",
        "--radius=x>0.5=0.7",
        "--radius-scale 1.5",
        "--color teal",
        "--color=x>0.5=red",
        "--color-by kind --legend-in",
        "--label {count}",
        "--scale-bar=nm",
        "--clip 0,0,1,2",
        "--hide=x>3",
        "--select=x<3",
        "--bits 16",
        "--dpi 90",
        "--zoom 2",
        "--accuracy exact",
        "--tolerance 1e-4",
        "--format csv",
    ];
    let mut rng = Rng::new(77);
    for _ in 0..amount("draws", [2, 4, 20]) {
        let mut drawn: Vec<&str> = Vec::new();
        for _ in 0..3 {
            let option = options[(rng.unit() * options.len() as f64) as usize];
            let name = |option: &str| option.split([' ', '=']).next().unwrap_or_default().to_owned();
            let clashes = [
                ["--transparent", "--background"],
                ["--method", "--accuracy"],
                ["--color", "--color-by"],
                ["--method", "--tolerance"],
            ];
            let clash = |known: &&str| {
                let pair = [name(known), name(option)];
                pair[0] == pair[1]
                    || clashes.iter().any(|two| two.iter().all(|one| pair.iter().any(|name| name == one)))
            };
            if !drawn.iter().any(clash) {
                drawn.push(option);
            }
        }
        let words = drawn.join(" ");
        println!("{words}");
        check_stills(&dir, &format!("t.csv --backend cpu {words}"), Some("kind a"));
    }
}

#[test]
fn short_help_fits_a_screen_and_long_help_has_all() {
    let dir = dir();
    for command in ["render", "plan", "view", "sift", "trace", "measure", "info"] {
        let [short, long] = ["-h", "--help"].map(|word| dir.good(&[command, word]).text());
        let lines = short.lines().count();
        assert!(
            lines <= 40 && short.lines().all(|line| line.chars().count() <= 100),
            "{command}: {lines} lines\n{short}"
        );
        assert!(long.lines().count() > lines || lines < 24, "{command}");
    }
    let short = dir.good("render -h").text();
    for option in ["--frames", "--color-by", "--size", "--output", "All options: halfline render --help"] {
        assert!(short.contains(option), "no {option} in {short}");
    }
}

#[test]
fn a_word_that_is_nearly_right_is_named() {
    let dir = dir();
    dir.put(
        "fov.toml",
        "[camera]\neye = [0, 0, 9]\nat = [0, 0, 0]\nfov = 20\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\n",
    );
    for (code, words, meant) in [
        (2, "t.csv --palette viridis", "'--map'"),
        (2, "t.csv --colormap viridis", "'--map'"),
        (2, "t.csv --spp 4", "'--samples'"),
        (2, "t.csv --fov 30", "'--vfov'"),
        (2, "t.csv --color-by knid", "did you mean `kind`?"),
        (2, "t.csv --select=knid>2", "did you mean `kind`?"),
        (3, "fov.toml", "did you mean `vfov`?"),
    ] {
        dir.refused_render(code, &format!("{words} -o a.png"), &[meant]);
    }
    assert!(!dir.run("render t.csv --palette viridis -o a.png").err.contains("silhouette"));
}

#[test]
fn the_list_of_cameras_has_a_folder_or_is_reported_to_have_none() {
    let dir = dir();
    dir.put("one.json", r#"[{"eye":[0,0,9],"at":[0,0,0],"up":[0,1,0],"vfov":40}]"#);
    let of = |output: &str| dir.render(&format!("t.csv --cameras one.json --size 16x12 -o {output}")).err;
    assert!(of("-").contains("cameras.json is not written") && !dir.path("cameras.json").exists());
    assert!(!of("a.png").contains("cameras.json") && dir.path("cameras.json").exists());
}

#[test]
fn frames_that_the_file_does_not_have_are_reported() {
    let dir = dir();
    for (frames, is_short) in
        [("1-2", false), ("1-3", true), ("2,7", true), ("1-", false), ("1-2,5-", false), ("2", false)]
    {
        let err = dir.render(&format!("run.dump --frames {frames} --size 16x12 -o a%d.png")).err;
        assert_eq!(
            err.contains("warning: the file has 2 frames, and --frames asks for others"),
            is_short,
            "{frames}: {err}"
        );
    }
}

#[test]
fn the_legend_of_selections_is_headed_by_what_it_has() {
    let dir = dir();
    let title = |options: &str| {
        dir.render(&format!("cell.xyz {options} --size 16x12 --legend l.svg -o a.png"));
        let svg = String::from_utf8(dir.get("l.svg")).expect("text");
        ["selection", "element"].into_iter().find(|title| svg.contains(&format!(">{title}<"))).map(str::to_owned)
    };
    assert_eq!(title("--color=x>0=red").as_deref(), Some("selection"), "all atoms");
    assert_eq!(title("--color=x>1.5=red").as_deref(), Some("element"));
    assert_eq!(title("").as_deref(), Some("element"));
}

/// Rules that give every particle its radius need no other; beads of a cell are no spheres of the scene.
#[test]
fn what_is_reported_about_spheres_is_true() {
    let dir = dir();
    for (rules, expected) in [("--radius=x>=0=0.4", None), ("--radius=x<1=0.4", Some(18)), ("", Some(27))] {
        let err = dir.render(&format!("run.dump {rules} --size 16x12 -o a.png")).err;
        let warning = expected.map(|count| format!("{count} particles have no radius"));
        assert_eq!(err.contains("no radius"), warning.is_some(), "{rules}: {err}");
        assert!(warning.is_none_or(|warning| err.contains(&warning)), "{rules}: {err}");
    }
    dir.render("run.dump --stream --radius=x>=0=0.4 --eye 0,0,9 --at 0,0,0 --size 16x12 -o a.png");
    dir.refused_render(2, "run.dump --stream --radius=x<1=0.4 --eye 0,0,9 --at 0,0,0 -o a.png", &["no radii"]);
    for cell in ["", "--cell", "--cell=0.1", "--copies 2,1,1 --cell"] {
        let page = Page::open(&dir, &format!("cell.xyz --backend cpu {cell}"));
        let expected = if cell.contains("copies") { 4 } else { 2 };
        assert_eq!(page.good("/scene", &json!({}))["count"], expected, "{cell}");
        let all = page.good("/select", &json!({ "expr": "all" }));
        assert_eq!((&all["count"], &all["of"]), (&json!(expected), &json!(expected)), "{cell}");
    }
    let words = |options: &str| dir.render(&format!("cell.xyz --size 16x12 {options} -o a.png")).err;
    assert!(words("").contains(
        "soft (the default for particles; see --look plain): --silhouette --samples 4, a sky with 3 rays from"
    ));
    assert!(words("--occlusion 8").contains(
        "--silhouette --samples 4, --occlusion at every sample, which takes much longer than a sky with 3 rays"
    ));
}

/// A name that is not UTF-8 arrives as it is, and is refused where a list in JSON would have to name it.
#[cfg(target_os = "linux")]
#[test]
fn names_that_are_not_text_are_never_other_names() {
    use std::os::unix::ffi::OsStrExt;
    let dir = dir();
    dir.put("one.json", r#"[{"eye":[0,0,9],"at":[0,0,0],"up":[0,1,0],"vfov":40}]"#);
    let name = |ending: &str| std::ffi::OsStr::from_bytes(&[b"b\xff", ending.as_bytes()].concat()).to_owned();
    std::fs::copy(dir.path("t.csv"), dir.path("").join(name(".csv"))).expect("a file");
    let run = |words: &str, output: &str| {
        let mut command = dir.command(words);
        let output = command.arg(name(".csv")).arg("-o").arg(name(output)).output().expect("halfline runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let camera = "--radius 1 --size 16x12";
    let picture = format!("render --backend cpu {camera}");
    assert_eq!(run(&picture, ".png").0, Some(0));
    assert!(dir.path("").join(name(".png")).exists());
    for (words, ending, expected) in [
        (format!("{picture} --cameras one.json"), ".png", "cameras.json cannot name it"),
        (format!("sift {camera} --first-id 0 --eye 0,0,9 --at 0,0,0 --json"), ".npz", "--json cannot name it"),
        (format!("{picture} --spin 2"), "%d.png", "not UTF-8"),
    ] {
        let (before, (code, err)) = (dir.files(), run(&words, ending));
        assert!(code == Some(2) && err.contains(expected), "{words}: {code:?} {err}");
        assert!(dir.files() == before, "{words} left something behind");
    }
    let mut view = dir.command("view --backend cpu --port 0 --no-open");
    view.arg(name(".csv"));
    let page = Page::of(view);
    let body = json!({ "camera": page.good("/scene", &json!({}))["camera"], "size": [40, 30], "mode": "still" });
    let still = page.ask("/frame", &body).body;
    let shell = page.good("/command", &body)["shell"].as_str().expect("a line").to_owned();
    let line = shell.replacen("halfline", env!("CARGO_BIN_EXE_halfline"), 1);
    let done = dir.program("sh").arg("-c").arg(&line).output().expect("a shell");
    assert!(done.status.success(), "{line}: {}", String::from_utf8_lossy(&done.stderr));
    assert!(std::fs::read(dir.path("").join(name("-view.png"))).expect("a picture") == still, "{line}");
}
