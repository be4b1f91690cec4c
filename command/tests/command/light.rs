//! The promise of the options for light: they add lights, a sky and lines to the scene, looks stand for several of them, and
//! what cannot be meant is refused before anything is written. `plan` says what `render` would do.

use crate::test_dir::{SCENE, TestDir};
use serde_json::{Value, json};

const LIGHT: &str = "[[light]]\nposition = [4, 3, 2]\nintensity = 2\n";

fn dir() -> TestDir {
    let with_light = format!("{SCENE}{LIGHT}[occlusion]\nrays = 32\nreach = 7\n");
    TestDir::new(&[("scene.toml", SCENE), ("lit.toml", &with_light), ("one.xyz", "1\none\nC 0 0 0\n")])
}

/// The plan of rendering with these options, and what is said about it.
fn plan(dir: &TestDir, options: &str) -> (Value, String) {
    let planned = dir.good(&format!("plan {options} --backend cpu --json"));
    (planned.json(), planned.err)
}

/// Lights, rays of the sky, samples, silhouette, depth cue.
fn parts(plan: &Value) -> Value {
    json!([plan["lights"], plan["occlusion"]["rays"], plan["samples"], plan["silhouette"], plan["depth_cue"]])
}

#[test]
fn invalid_options_are_refused() {
    let dir = dir();
    for (options, words) in [
        ("-o a.png --sun 0,0,0", &["--sun", "not all 0"][..]),
        ("-o a.png --sun=-0,0,0", &["--sun"]),
        ("-o a.png --sun nan,0,1", &["--sun"]),
        ("-o a.png --sun inf,0,1", &["--sun"]),
        ("-o a.png --sun 1,2", &["--sun", "toward the light"]),
        ("-o a.png --occlusion 0", &["--occlusion", "between 1 and"]),
        ("-o a.png --occlusion 1.5", &["--occlusion"]),
        ("-o a.png --occlusion --reach 0", &["--reach", "positive"]),
        ("-o a.png --occlusion --reach -1", &["--reach", "positive"]),
        ("-o a.png --occlusion --reach inf", &["--reach", "positive"]),
        ("-o a.png --reach 2", &["--reach", "--occlusion"]),
        ("--aov depth=d.npy --reach 2", &["--reach", "--aov occlusion"]),
        ("-o a.png --bounces 65", &["--bounces", "between 0 and 64"]),
        ("-o a.png --bounces=-1", &["--bounces", "whole number"]),
        ("-o a.png --silhouette --outline-width 0.05", &["--outline-width", "from 0.1 to 40"]),
        ("-o a.png --silhouette --outline-width -1", &["--outline-width", "from 0.1 to 40"]),
        ("-o a.png --silhouette --outline-width nan", &["--outline-width", "from 0.1 to 40"]),
        ("-o a.png --silhouette --outline-color blak", &["--outline-color", "black"]),
        ("-o a.png --look pretty", &["--look", "pretty"]),
        ("--aov shadow=s.npy", &["shadow needs a light", "--sun", "[[light]]"]),
        ("-o a.exr --aov shadow --occlusion", &["light"]),
        ("--aov shadow=s.png --sun 0,0,1", &["s.png cannot hold the shadow buffer", ".exr, .npy"]),
        ("--aov shadow=s.pfm --sun 0,0,1", &["cannot hold"]),
    ] {
        dir.refused_render(2, &format!("scene.toml {options}"), words);
    }
    dir.refused(2, "plan scene.toml --aov shadow=s.npy --backend cpu", &["light"]);
    dir.put("rays.csv", "0,0,0,0,0,-1\n");
    for option in ["--sun 0,0,1", "--shadows", "--occlusion", "--silhouette", "--depth-cue", "--look soft", "--reach 1"]
    {
        dir.refused(2, &format!("trace scene.toml --rays rays.csv -o hits.csv {option}"), &["unexpected argument"]);
    }
    dir.put("broken.toml", format!("{SCENE}[[light]]\nsphere = 1\n"));
    dir.refused_render(3, "broken.toml -o a.png", &["broken.toml:16:10: light 0 sphere", "there is no sphere 1"]);
}

#[test]
fn options_add_lights_and_a_sky() {
    let dir = dir();
    let point = "a point at 4, 3, 2, intensity 2";
    let sun = "infinitely far in the direction -1, 2, 0.5";
    for (options, lights, shadows, sky) in [
        ("scene.toml", &[][..], false, Value::Null),
        ("scene.toml --sun -1,2,.5", &[sun], false, Value::Null),
        ("scene.toml --sun -1,2,.5 --shadows", &[sun], true, Value::Null),
        ("lit.toml --sun -1,2,.5", &[point, sun], true, json!({"rays": 32, "reach": 7.0})),
        ("lit.toml --occlusion", &[point], true, json!({"rays": 32, "reach": 7.0})),
        ("lit.toml --occlusion 9 --reach 2", &[point], true, json!({"rays": 9, "reach": 2.0})),
        ("lit.toml --reach 2", &[point], true, json!({"rays": 32, "reach": 2.0})),
        ("scene.toml --occlusion", &[], false, json!({"rays": 16, "reach": null})),
        ("scene.toml --occlusion 64 --reach 3", &[], false, json!({"rays": 64, "reach": 3.0})),
        ("scene.toml --aov occlusion=o.npy", &[], false, json!({"rays": 16, "reach": null})),
        ("scene.toml --aov occlusion=o.npy --reach 3", &[], false, json!({"rays": 16, "reach": 3.0})),
        ("scene.toml --aov shadow=s.npy --sun -1,2,.5", &[sun], true, Value::Null),
        ("lit.toml --shade flat", &[point], false, json!({"rays": 32, "reach": 7.0})),
    ] {
        let (plan, _) = plan(&dir, &format!("{options} -o a.png"));
        assert_eq!(plan["lit_by"], json!(lights), "{options}");
        assert_eq!(plan["lights"], lights.len(), "{options}");
        assert_eq!((&plan["shadows"], &plan["occlusion"]), (&json!(shadows), &sky), "{options}");
    }
    let (plan, _) = plan(&dir, "scene.toml -o a.exr --aov shadow,occlusion --sun 0,0,1 --sun 0,1,0");
    let frame = plan["frame"].as_array().expect("buffers");
    let shape = |name: &str| frame.iter().find(|shown| shown["name"] == name).map(|shown| shown["shape"].clone());
    assert_eq!((shape("shadow"), shape("occlusion")), (Some(json!([31, 45, 2])), Some(json!([31, 45]))));
}

#[test]
fn a_light_from_above_left_belongs_to_the_camera() {
    let dir = dir();
    let lights = |options: &str| plan(&dir, options).0["lit_by"].clone();
    let [first, turned] = ["", " --view 1,0,0"].map(|view| lights(&format!("scene.toml -o a.png --shadows{view}")));
    let [first, turned] = [first, turned].map(|lights| {
        let text = lights[0].as_str().expect("one light").rsplit("direction ").next().expect("numbers").to_owned();
        text.split(", ").map(|x| x.parse().expect("a number")).collect::<Vec<f64>>()
    });
    assert!(first[0] < 0.0 && first[1] > 0.0 && first[2] > 0.0, "{first:?}");
    // Looking along x, left is -z and the viewer's side is -x.
    assert!(turned[0] < 0.0 && turned[1] > 0.0 && turned[2] < 0.0, "{turned:?}");
    assert_eq!(lights("lit.toml -o a.png --shadows"), json!(["a point at 4, 3, 2, intensity 2"]), "it has a light");
}

#[test]
fn looks_stand_for_options() {
    let dir = dir();
    for (options, expected) in [
        ("scene.toml --look plain", json!([0, null, 1, false, false])),
        ("scene.toml --look soft", json!([1, 3, 4, true, false])),
        ("scene.toml --look soft --samples 1", json!([1, 3, 1, true, false])),
        ("scene.toml --look soft --samples 16", json!([1, 3, 16, true, false])),
        ("scene.toml --look soft --occlusion 64 --depth-cue", json!([1, 64, 4, true, true])),
        ("scene.toml --look soft --sun 0,0,1 --sun 0,1,0", json!([2, 3, 4, true, false])),
        ("lit.toml --look soft", json!([1, 32, 4, true, false])),
        ("scene.toml --look figure", json!([0, 3, 16, true, false])),
        ("scene.toml --look figure --samples 4 --depth-cue", json!([0, 3, 4, true, true])),
        ("scene.toml --silhouette", json!([0, null, 1, true, false])),
        ("scene.toml --depth-cue", json!([0, null, 1, false, true])),
    ] {
        let (plan, err) = plan(&dir, &format!("{options} -o a.png"));
        assert_eq!(parts(&plan), expected, "{options}");
        let look = ["soft", "figure"].into_iter().find(|look| options.contains(look));
        let lines: Vec<_> = err.lines().filter(|line| line.contains("look ")).collect();
        assert_eq!(lines.len(), usize::from(look.is_some()), "{options}: {err}");
        assert!(look.is_none_or(|look| lines[0].contains(&format!("look {look}: --"))), "{options}: {err}");
    }
    let left_out = |options: &str| {
        let (plan, _) = plan(&dir, &format!("scene.toml {options}"));
        let all = plan["left_out"].as_array().expect("a list").clone();
        all.into_iter().map(|left| left["what"].as_str().expect("a name").to_owned()).collect::<Vec<_>>()
    };
    for what in ["shadows", "occlusion", "silhouette", "depth cue"] {
        assert!(left_out("-o a.png").iter().any(|left| left == what), "{what}");
        assert!(!left_out("-o a.png --look soft --shadows --depth-cue").iter().any(|left| left == what), "{what}");
    }
    assert!(left_out("--aov id=i.npy --silhouette").contains(&"silhouette".to_owned()), "no picture");
}

#[test]
fn pictures_of_particles_are_soft_unless_an_option_asks_for_another_light() {
    let dir = dir();
    let soft = json!([1, 3, 4, true, false]);
    let plain = json!([0, null, 1, false, false]);
    for (options, samples) in [
        ("-o a.png", 4),
        ("-o a.png --size 20x20", 4),
        ("-o a.png --color #ff0000", 4),
        ("-o a.png --aov id=i.npy", 4),
        ("-o a.png --accuracy fast", 4),
        ("-o a.png --accuracy certified", 4),
        ("-o a.png --method stable", 4),
        ("-o a.png --samples 1", 1),
        ("-o a.png --samples 9", 9),
        ("--aov color=c.npy", 4),
    ] {
        let planned = dir.good(&format!("plan one.xyz --backend cpu --json {options}"));
        let mut expected = soft.clone();
        expected[2] = json!(samples);
        assert_eq!(parts(&planned.json()), expected, "{options}");
        let stands_for = "look soft (the default for particles; see --look plain): --silhouette --samples";
        let rays = if samples == 9 { 4 } else { 3 };
        let words = format!("{stands_for} {samples}, a sky with {rays} rays");
        assert!(planned.err.contains(&words), "{options}: {}", planned.err);
    }
    for (options, samples) in [
        ("-o a.png --look plain", 1),
        ("-o a.png --shade flat", 1),
        ("-o a.png --shade headlight --samples 4", 4),
        ("--aov depth=d.npy", 1),
    ] {
        let (plan, err) = plan(&dir, &format!("one.xyz {options}"));
        let mut expected = plain.clone();
        expected[2] = json!(samples);
        assert_eq!(parts(&plan), expected, "{options}");
        assert!(!err.contains("look"), "{options}: {err}");
    }
    assert_eq!(parts(&plan(&dir, "scene.toml -o a.png").0), plain, "a scene file");
    let added = plan(&dir, "one.xyz -o a.png --sun 0,0,1 --sun 0,1,0 --shadows --occlusion 8").0;
    assert_eq!((parts(&added), &added["shadows"]), (json!([2, 8, 4, true, false]), &json!(true)), "parts are added");
    let of = |name: &str, value: &str| {
        let planned = dir.run_with("plan one.xyz -o a.png --backend cpu --json", &[(name, value)]);
        assert_eq!(planned.code, 0, "{}", planned.err);
        parts(&planned.json())
    };
    assert_eq!(of("HALFLINE_LOOK", "plain"), plain);
    assert_eq!(of("HALFLINE_ACCURACY", "auto"), soft);
    assert_eq!(of("HALFLINE_SAMPLES", "9"), json!([1, 3, 9, true, false]));
    assert_eq!(of("HALFLINE_SHADE", "normal"), plain);
    assert_eq!(of("HALFLINE_DEPTH_CUE", "1"), json!([1, 3, 4, true, true]));
    dir.put("c.toml", "occlusion = 8\nsilhouette = true\nlook = \"plain\"\nshadows = true\n");
    assert_eq!(of("HALFLINE_CONFIG", "c.toml"), json!([1, 8, 1, true, false]));
}

#[test]
fn bounces_are_those_that_materials_ask_for() {
    let dir = dir();
    let ball = |lines: &str| format!("[[sphere]]\ncenter = [3.0, 0.0, -9.0]\nradius = 0.5\n{lines}\n");
    dir.put("metal.toml", format!("{SCENE}{}", ball("material = 'metal'")));
    dir.put("glass.toml", format!("{SCENE}{}{}", ball("material = 'glass'"), ball("specular = 0.5")));
    let left_out = |plan: &Value| {
        let left_out =
            plan["left_out"].as_array().expect("a list").iter().find(|left| left["what"] == "mirrors and glass");
        left_out.map(|left| left["why"].as_str().expect("words").to_owned())
    };
    // Options; mirrors, metals, clear spheres; bounces; rays; why they are left out.
    for (options, materials, bounces, rays, why) in [
        ("scene.toml -o a.png", [0, 0, 0], 0, [1, 0, 0, 0], Some("no sphere asks for them")),
        ("lit.toml -o a.png", [0, 0, 0], 0, [1, 1, 32, 0], Some("no sphere asks for them")),
        ("lit.toml -o a.png --samples 4", [0, 0, 0], 0, [4, 4, 128, 0], Some("no sphere asks for them")),
        ("metal.toml -o a.png", [0, 1, 0], 6, [1, 0, 0, 6], None),
        ("metal.toml -o a.png --bounces 2 --samples 9", [0, 1, 0], 2, [9, 0, 0, 18], None),
        ("metal.toml -o a.png --bounces 0", [0, 1, 0], 0, [1, 0, 0, 0], Some("--bounces 0 switches them off")),
        ("metal.toml -o a.png --shade flat", [0, 1, 0], 0, [1, 0, 0, 0], Some("this shading shows none")),
        ("metal.toml --aov depth=d.npy", [0, 1, 0], 0, [1, 0, 0, 0], Some("no picture is requested")),
        ("glass.toml -o a.png --bounces 3 --occlusion 5", [1, 0, 1], 3, [1, 0, 5, 14], None),
    ] {
        let (plan, err) = plan(&dir, options);
        let [mirrors, metals, clear] = materials;
        assert_eq!(plan["materials"], json!({"mirrors": mirrors, "metals": metals, "clear": clear}), "{options}");
        let [viewing, lights, sky, onward] = rays;
        let rays = json!({"viewing": viewing, "lights": lights, "sky": sky, "onward": onward});
        assert_eq!((&plan["bounces"], &plan["rays_per_pixel"]), (&json!(bounces), &rays), "{options}");
        assert_eq!(left_out(&plan).as_deref(), why, "{options}");
        assert!(!err.contains("--bounces"), "{err}");
    }
    let text = dir.good("plan glass.toml -o a.png --backend cpu --bounces 2").out;
    let text = String::from_utf8(text).expect("text");
    assert!(text.contains("materials  spheres: 1 with a mirror image, 0 of metal, 1 of glass or clear\n"), "{text}");
    assert!(text.contains("bounces    up to 2\nrays       per pixel 1 to the scene"), "{text}");
    // Where no sphere asks for them, the option changes nothing and says so.
    let report = dir.render("scene.toml -o b.png --json --bounces 3").json();
    assert!(report["warnings"][0].as_str().expect("a warning").contains("light"), "{report}");
    dir.render("scene.toml -o c.png");
    assert!(dir.get("b.png") == dir.get("c.png"), "pixels and provenance");
    dir.render("metal.toml -o m.npy --bounces 0");
    dir.put("plain.toml", format!("{SCENE}{}", ball("")));
    dir.render("plain.toml -o p.npy");
    assert_eq!(dir.array("m.npy"), dir.array("p.npy"));
}

#[test]
fn outlines_have_a_width_and_a_colour() {
    let dir = dir();
    let picture = |options: &str| {
        dir.render(&format!("scene.toml --size 450x310 {options} -o o.npy"));
        dir.array("o.npy").0
    };
    let [plain, thin] = ["", "--silhouette"].map(picture);
    let wide = picture("--silhouette --outline-width 10 --outline-color 0,0,1");
    let changed = |other: &[f64]| plain.chunks(3).zip(other.chunks(3)).filter(|(own, other)| own != other).count();
    assert!(changed(&thin) > 0 && changed(&wide) > 4 * changed(&thin), "{} {}", changed(&thin), changed(&wide));
    let is_blue = |rgb: &[f64]| rgb[0] < 0.1 && rgb[2] > 0.9;
    assert!(wide.chunks(3).any(is_blue) && !plain.chunks(3).chain(thin.chunks(3)).any(is_blue));
    assert!(picture("--silhouette --outline-width 1.3 --outline-color black") == thin, "the defaults");
    dir.refused_render(
        2,
        "scene.toml --silhouette --outline-width 41 -o a.png",
        &["--outline-width", "from 0.1 to 40"],
    );
    // Without lines they change nothing and say so, but for a preference.
    dir.render("scene.toml -o a.png");
    for options in ["--outline-width 3", "--outline-color red", "--outline-width 3 --stream"] {
        let report = dir.render(&format!("scene.toml {options} -o b.png --json")).json();
        let option = options.split(' ').next().expect("an option");
        let words = format!("{option} changes nothing: the picture has no --silhouette");
        assert_eq!(report["warnings"], json!([words]), "{options}");
        assert!(dir.get("a.png") == dir.get("b.png"), "{options}: pixels and provenance");
    }
    let preferred = dir.run_with("render scene.toml --backend cpu -o b.png --json", &[("HALFLINE_OUTLINE_WIDTH", "3")]);
    assert_eq!(preferred.json()["warnings"], json!([]));
    let soft = dir.render("scene.toml --look soft --outline-width 3 -o b.png --json").json();
    assert_eq!((&soft["warnings"], &soft["outline"]["width"]), (&json!([]), &json!(3.0)));
}

/// Kd changes a picture only where something beside the light at the eye lights it.
#[test]
fn an_nff_file_without_lights_and_mirrors_shows_its_colours() {
    let dir = dir();
    let file = |name: &str, fill: &str| {
        let view = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 40\nresolution 31 21\n";
        dir.put(name, format!("{view}f 1 0.5 0.25{fill}\ns 0 0 0 1\n"));
    };
    file("bare.nff", "");
    file("dim.nff", " 0.5 0 30 0 1");
    file("mirror.nff", " 0.5 0.25 0 0 1");
    let picture = |options: &str| {
        let report = dir.render(&format!("{options} -o c.npy --json")).json();
        (dir.array("c.npy").0, report["warnings"].as_array().map_or(0, Vec::len))
    };
    let bare = picture("bare.nff");
    assert_eq!((picture("dim.nff").0, bare.1, picture("dim.nff").1), (bare.0.clone(), 0, 1));
    let sunny = picture("bare.nff --sun 1,2,3").0;
    let dim = picture("dim.nff --sun 1,2,3").0;
    // Half of what is rounded to f32 once is exact.
    assert!(sunny.iter().zip(&dim).all(|(all, half)| 0.5 * all == *half) && sunny.iter().any(|x| *x > 0.1));
    assert_ne!(picture("mirror.nff").0, bare.0);
}

#[test]
fn a_light_follows_its_sphere() {
    let dir = dir();
    let sphere = |x: u32| format!("[[sphere]]\ncenter = [{x}.0, 0.0, -9.0]\nradius = 0.5\n");
    // Spheres 2 and 3 are equal.
    let spheres = [1, 2, 2, 3].map(sphere).concat();
    dir.put("s.toml", format!("{SCENE}{spheres}[[light]]\nsphere = 3\n"));
    for (clip, expected) in [
        ("", "sphere 3"),
        (" --clip=-1,0,0,-1", "sphere 2"),
        (" --clip=-1,0,0,-1.5", "sphere 1"),
        (" --clip=1,0,0,1.5", "a ball at 2, 0, -9 of radius 0.5"),
    ] {
        assert_eq!(plan(&dir, &format!("s.toml -o a.png{clip}")).0["lit_by"], json!([expected]), "{clip}");
    }
}

#[test]
fn the_plan_says_what_lights_the_scene() {
    let dir = dir();
    let text = |options: &str| dir.good(&format!("plan {options} -o a.png --backend cpu")).out;
    let of = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    assert!(of(text("scene.toml")).contains("light      at the eye\n"));
    let words = of(text("lit.toml --silhouette --depth-cue"));
    assert!(
        words.contains("light      1 light, with shadows\n           a point at 4, 3, 2, intensity 2\n"),
        "{words}"
    );
    assert!(words.contains("sky        32 rays for each point, that end after 7\n"), "{words}");
    assert!(words.contains("drawn      silhouette, depth cue\n"), "{words}");
}

#[test]
fn rendering_reports_its_lights_and_writes_their_shadows() {
    let dir = dir();
    let report = dir.render("lit.toml -o a.png --json --sun 0,0,1").json();
    assert_eq!((&report["lights"], &report["occlusion"]["rays"]), (&json!(2), &json!(32)));
    assert_eq!(dir.render("scene.toml -o a.png --json").json()["lights"], 0);
    dir.render("scene.toml --sun 0,0,1 --sun 0,0,-1 --aov shadow=s.npy --aov occlusion=o.png");
    let (shares, shape) = dir.array("s.npy");
    assert_eq!(shape, [31, 45, 2]);
    let middle = 2 * (15 * 45 + 22);
    assert_eq!(shares[middle..middle + 2], [0.0, 1.0], "the light before the sphere, and the one behind it");
    assert_eq!(shares[..2], [0.0; 2], "a miss has no shadow");
    let (open, shape) = dir.array("o.png");
    assert_eq!((shape, open[0], open[15 * 45 + 22]), (vec![31, 45], 255.0, 255.0), "nothing hides the sky");
}

/// A buffer of four lights has as many channels as colour with alpha, and is no colour.
#[test]
fn shadows_of_any_number_of_lights_are_written_with_alpha() {
    let dir = dir();
    let mut words = "scene.toml -o a.png --transparent".to_owned();
    for lights in 1..=5 {
        words += &format!(" --sun {},{},1", lights % 3, lights / 3);
        let [first, second, third] = ["s.npy", "s.npz", "s.exr"].map(|name| {
            dir.render(&format!("{words} --aov shadow={name}"));
            dir.array(name)
        });
        assert_eq!(first.1, [31, 45, lights]);
        assert!(first == second && first == third, "{lights} lights");
    }
}

/// Another seed changes the picture, and `--resume` does not keep a picture of another seed.
#[test]
fn another_seed_is_another_rendering() {
    let dir = dir();
    let ball = "[[light]]\nposition = [4, 3, -1]\nradius = 2\n[[sphere]]\ncenter = [0.9, 0.6, -2]\nradius = 0.2\n";
    dir.put("ball.toml", format!("{SCENE}{ball}"));
    for (words, file) in [
        ("ball.toml --aov occlusion=o.npy --occlusion 8", "o.npy"),
        ("ball.toml --aov shadow=s.npy", "s.npy"),
        ("ball.toml -o a.png --occlusion 8", "a.png"),
    ] {
        let render = |seed: u32, more: &str| {
            dir.render(&format!("{words} --seed {seed} {more}"));
            dir.array(file)
        };
        let second = render(2, "");
        assert!(render(1, "") != second, "{words}: seeds change nothing");
        assert!(render(2, "--resume") == second, "{words}: an old file was kept");
    }
}
