//! The promise of `--opacity`: pictures alone change, with the same bytes from files, streams and parts, and what cannot be meant is
//! refused.

use crate::rng::Rng;
use crate::test_dir::{SCENE, TestDir};
use serde_json::json;

/// A cloud of carbon and oxygen, and a table of it with radii.
fn dir() -> TestDir {
    let mut rng = Rng::new(6);
    let dir = TestDir::new(&[("scene.toml", SCENE)]);
    let (mut atoms, mut table) = (String::from("400\ncloud\n"), String::from("x,y,z,radius,kind\n"));
    for n in 0..400 {
        let [x, y, z] = rng.cube().map(|x| 6.0 * x);
        atoms.push_str(&format!("{} {x} {y} {z}\n", if n % 2 == 0 { "C" } else { "O" }));
        table.push_str(&format!("{x},{y},{z},1.5,{}\n", n % 2));
    }
    dir.put("cloud.xyz", atoms);
    dir.put("cloud.csv", table);
    dir
}

#[test]
fn opacities_change_pictures_alone() {
    let dir = dir();
    let aovs = " --aov id=NAME-id.npy --aov depth=NAME-depth.npy --aov occlusion=NAME-occlusion.npy";
    let render = |name: &str, options: &str| {
        let aovs = aovs.replace("NAME", name);
        let words = format!("render cloud.xyz --size 60x45 --backend cpu -o {name}.png{aovs} --json {options}");
        let words: Vec<String> = words.split_whitespace().map(|word| word.replace('~', " ")).collect();
        let ran = dir.run(&words);
        assert_eq!(ran.code, 0, "{}", ran.err);
        ran.json()
    };
    assert_eq!(render("plain", "")["layers"], json!(null));
    let report = render("ghost", "--opacity element~C=0.3");
    assert_eq!((&report["layers"], &report["opacity_shadows"]), (&json!(1), &json!(false)));
    for buffer in ["id", "depth", "occlusion"] {
        // The files name the scene, whose fingerprint has the opacities.
        let [plain, ghost] = ["plain", "ghost"].map(|name| dir.array(&format!("{name}-{buffer}.npy")));
        assert!(plain == ghost, "{buffer}");
    }
    assert!(dir.get("plain.png") != dir.get("ghost.png"));
    // The later rule wins, and an opaque sphere is one without an opacity.
    render("won", "--opacity 0.5 --opacity all=0.2 --opacity element~O=1 --opacity element~C=0.3");
    assert!(dir.get("won.png") == dir.get("ghost.png"));
    assert_eq!(render("three", "--opacity element~C=0.3 --layers 3 --opacity-shadows")["layers"], json!(3));
    assert!(dir.get("three.png") != dir.get("ghost.png"));
    let warnings = |report: serde_json::Value| report["warnings"].clone();
    let idle = |option: &str| format!("--{option} changes nothing: no sphere of the picture has an --opacity below 1");
    let given = warnings(render("idle", "--layers 2 --opacity-shadows --ghost-rim --opacity 1"));
    assert_eq!(given, json!([idle("layers"), idle("opacity-shadows"), idle("ghost-rim")]));
}

#[test]
fn streams_and_parts_have_the_bytes_of_all_spheres() {
    let dir = dir().in_parts(64);
    let view = "--size 60x45 --eye 9,7,20 --at 0,0,0 --vfov 40";
    for opacity in ["kind=1=0.4", "0.25"] {
        let words = |rest: &str| format!("cloud.csv {view} --opacity {opacity} {rest}");
        let pictures = |name: &str| format!("-o {name}.png --aov id={name}-id.npy --silhouette");
        dir.render(&words(&format!("--look plain {}", pictures("whole"))));
        dir.render(&words(&format!("--stream {}", pictures("stream"))));
        let table = String::from_utf8(dir.get("cloud.csv")).expect("a table");
        let lines: Vec<&str> = table.lines().collect();
        for (name, rows) in [("0", &lines[1..151]), ("150", &lines[151..])] {
            dir.put("part.csv", format!("{}\n{}\n", lines[0], rows.join("\n")));
            dir.good(&format!("sift part.csv --first-id {name} {view} --opacity {opacity} -o {name}.npz"));
        }
        dir.render(&format!("--visible 150.npz 0.npz {}", pictures("parts")));
        for other in ["stream", "parts"] {
            for file in [".png", "-id.npy"] {
                assert!(
                    dir.get(&format!("whole{file}")) == dir.get(&format!("{other}{file}")),
                    "{opacity}: {other}{file}"
                );
            }
        }
        dir.refused_render(2, &words("--stream --layers 2 -o a.png"), &["layer", "--layers", "--stream"]);
    }
    dir.good(&format!("sift part.csv --first-id 150 {view} -o plain.npz"));
    dir.refused_render(2, "--visible 0.npz plain.npz -o a.png", &["opacities"]);
}

#[test]
fn scene_files_give_spheres_opacities() {
    let dir = dir();
    let ball =
        |opacity: &str| format!("{SCENE}[[sphere]]\ncenter = [0.3, 0.1, -1.5]\nradius = 0.3\nopacity = {opacity}\n");
    for (name, opacity) in [("ghost.toml", "0.5"), ("full.toml", "1")] {
        dir.put(name, ball(opacity));
        dir.render(&format!("{name} -o {name}.npy"));
    }
    assert_ne!(dir.array("ghost.toml.npy"), dir.array("full.toml.npy"));
    dir.render("full.toml --opacity 0.5 -o both.npy");
    assert_ne!(dir.array("full.toml.npy"), dir.array("both.npy"), "the option is of all spheres");
    // A file of spheres has one opacity, and its absence means the same as for a sphere.
    dir.put("ball.csv", "x,y,z,radius\n0.3,0.1,-1.5,0.3\n");
    let file = |opacity: &str| format!("{SCENE}[[spheres]]\nfile = \"ball.csv\"\nopacity = {opacity}\n");
    for (name, opacity) in [("ghost", "0.5"), ("full", "1")] {
        dir.put("file.toml", file(opacity));
        dir.render("file.toml -o file.npy");
        assert!(dir.get("file.npy") == dir.get(&format!("{name}.toml.npy")), "{name}");
    }
    dir.put("file.toml", file("0.5"));
    dir.refused_render(2, "file.toml --stream -o a.png", &["--stream", "opacities"]);
    for (opacity, words) in [("0", "above 0"), ("1.5", "at most 1"), ("-0.5", "above 0"), ("\"red\"", "a number")] {
        for (wrong, line) in [(ball(opacity), 18), (file(opacity), 17)] {
            dir.put("wrong.toml", wrong);
            dir.refused_render(3, "wrong.toml -o a.png", &[&format!("wrong.toml:{line}:11"), "opacity", words]);
        }
    }
    dir.refused_render(2, "ghost.toml --stream -o a.png", &["opacities", "--stream"]);
    let plan = dir.good("plan ghost.toml --layers 2 --backend cpu").text();
    assert!(plan.contains("layers     the 2 nearest of the translucent spheres"), "{plan}");
}

#[test]
fn invalid_opacities_are_refused() {
    let dir = dir();
    for (options, words) in [
        ("--opacity 0", &["--opacity", "above 0", "--hide"][..]),
        ("--opacity -1", &["--opacity", "above 0"]),
        ("--opacity 1.01", &["--opacity", "at most 1"]),
        ("--opacity nan", &["--opacity"]),
        ("--opacity kind=2=x", &["--opacity"]),
        ("--opacity bogus=1=0.5", &["bogus"]),
        ("--opacity 0.5 --layers 0", &["--layers", "between 1 and 64"]),
        ("--opacity 0.5 --layers 65", &["--layers", "between 1 and 64"]),
    ] {
        dir.refused_render(2, &format!("cloud.csv {options} -o a.png"), words);
    }
}

/// The legend has a row for every rule that applies.
#[test]
fn legends_name_opacities() {
    let dir = dir();
    let words = "render cloud.xyz --size 60x45 --backend cpu -o a.png --legend legend.svg";
    let rules = ["--opacity", "element C=0.3", "--opacity", "element N=0.5"];
    let ran = dir.run(&words.split(' ').chain(rules).collect::<Vec<_>>());
    assert_eq!(ran.code, 0, "{}", ran.err);
    let svg = String::from_utf8(dir.get("legend.svg")).expect("SVG");
    assert!(svg.contains("element C: opacity 0.3") && !svg.contains("element N"), "{svg}");
}
