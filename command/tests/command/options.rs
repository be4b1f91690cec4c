//! The promise of the options of `render`: each replaces a value of the scene file, and standard input and output are
//! files.

use crate::nff;
use crate::test_dir::{SCENE, SPHERE, TestDir};
use halfline_files::write::{npy, png};
use serde_json::Value;

const NFF: &str = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 30\nhither 0.1\nresolution 32 24\nf 1 0.5 0 1 0 0 0 1
s 0 0 0 1\np 3\n0 0 0\n1 0 0\n0 1 0\n";

fn dir() -> TestDir {
    TestDir::new(&[("scene.toml", SCENE)])
}

#[test]
fn standard_output_is_one_result_without_messages() {
    let dir = dir();
    let run = |options: &[&str]| dir.render(&[&["scene.toml"], options].concat());
    assert!(run(&["-o", "out.png"]).out.is_empty());
    assert!(run(&["--aov", "id=id.npy"]).out.is_empty());
    let picture = run(&["-o", "-"]).out;
    assert!(picture.starts_with(png::MAGIC));
    assert_eq!(picture, dir.get("out.png"));
    assert_eq!(png::read(&picture, "-").expect("a whole PNG").shape(), [31, 45, 3]);
    assert_eq!(run(&["--aov", "id=-"]).out, dir.get("id.npy"));
    run(&["-o", "out.png", "--json"]).json();
}

#[test]
fn options_replace_the_camera() {
    let dir = dir();
    let options = ["--eye", "-1,2,3", "--view", "-0.1,-.5,-1", "--up", "-0.5,1,0", "--size", "20x10"];
    dir.good(&[&["render", "scene.toml", "-o", "a.npy", "--backend", "cpu"], &options[..]].concat());
    let written = SCENE
        .replace("eye = [0.0, 0.0, 0.0]", "eye = [-1.0, 2.0, 3.0]")
        .replace("view = [0.0, 0.0, -1.0]", "view = [-0.1, -0.5, -1.0]")
        .replace("up = [0.0, 1.0, 0.0]", "up = [-0.5, 1.0, 0.0]")
        .replace("[45, 31]", "[20, 10]");
    dir.put("written.toml", written);
    dir.good(&["render", "written.toml", "-o", "b.npy", "--backend", "cpu"]);
    assert_eq!(dir.get("a.npy"), dir.get("b.npy"));
    assert_eq!(dir.array("a.npy").1, [10, 20, 3]);
    dir.good(&["render", "scene.toml", "-o", "a.npy", "--backend", "cpu", "--at=-1,0,-3", "--vfov", "60"]);
}

#[test]
fn an_orthographic_camera_by_file_and_by_option() {
    let dir = dir();
    dir.good(&["render", "scene.toml", "-o", "a.npy", "--aov", "distance=d.npy", "--backend", "cpu", "--ortho", "3"]);
    dir.put("ortho.toml", SCENE.replace("viewport = [1.5, 1.0]", "height = 3"));
    dir.good(&["render", "ortho.toml", "-o", "b.npy", "--backend", "cpu"]);
    assert_eq!(dir.get("a.npy"), dir.get("b.npy"));
    // The ray of the middle pixel goes through the sphere's centre, at a distance of 3.
    let middle = dir.array("d.npy").0[15 * 45 + 22];
    assert!((middle - 2.0).abs() <= 1e-5 * 2.0, "{middle}");
    // --vfov makes the camera a perspective one.
    dir.good(&["render", "ortho.toml", "-o", "a.npy", "--backend", "cpu", "--vfov", "60"]);
    dir.good(&["render", "scene.toml", "-o", "b.npy", "--backend", "cpu", "--vfov", "60"]);
    assert_eq!(dir.get("a.npy"), dir.get("b.npy"));
    for (arguments, code, word) in [
        (&["--ortho", "3", "--vfov", "60"][..], 2, "cannot be used with"),
        (&["--ortho", "-3"], 2, "a positive number"),
        (&["--ortho", "inf"], 2, "a positive number"),
        (&["--ortho", "3", "--method", "stable"], 2, "does not support orthographic cameras"),
    ] {
        dir.refused_render(code, &[&["scene.toml", "-o", "c.npy"], arguments].concat(), &[word]);
    }
}

#[test]
fn a_scene_is_read_from_standard_input() {
    let dir = dir();
    for (scene, text) in [("scene.toml", SCENE), ("scene.nff", NFF)] {
        dir.put(scene, text);
        dir.render(&[scene, "-o", "file.png"]);
        let piped = dir.run_fed("render - -o piped.png --backend cpu", text.as_bytes());
        assert_eq!(piped.code, 0, "{}", piped.err);
        assert_eq!(dir.get("piped.png"), dir.get("file.png"), "{scene}");
    }
}

#[test]
fn other_shapes_are_skipped_with_a_warning_or_refused() {
    let dir = dir();
    dir.put("scene.nff", NFF);
    let rendered = dir.render("scene.nff --json");
    assert!(rendered.err.contains("warning: 1 polygon skipped"), "{}", rendered.err);
    let report = rendered.json();
    assert_eq!(report["skipped"], 1);
    assert_eq!(report["warnings"].as_array().map(Vec::len), Some(1));
    dir.refused(3, &["render", "scene.nff", "-o", "out.png", "--strict"], &["scene.nff:10", "polygon", "strict"]);
}

#[test]
fn buffers_of_answers_are_certified_and_equal_the_exact_ones() {
    let dir = dir();
    let run = |options: &[&str]| dir.render(&[&["scene.toml", "--json"], options].concat()).json();
    assert_eq!(run(&["-o", "out.png"])["accuracy"], "fast", "a picture without buffers");
    let certified = run(&["--aov", "id=a.npy", "--aov", "certainty=c.npy"]);
    assert_eq!([&certified["accuracy"], &certified["method"]], ["certified"; 2]);
    assert!(certified["certified"].as_f64().is_some_and(|share| share > 0.9), "{certified}");
    assert!(certified["bound"].as_f64().is_some_and(|bound| bound > 0.0 && bound <= 1e-5), "{certified}");
    let exact = run(&["--aov", "id=b.npy", "--accuracy", "exact"]);
    assert_eq!([&exact["accuracy"], &exact["settled"]], [&serde_json::json!("exact"), &exact["rays"]]);
    // The files have their accuracy in their provenance, which differs.
    let ids = |name: &str| npy::read(&dir.get(name), name).expect("a whole file").values().clone();
    assert_eq!(ids("a.npy"), ids("b.npy"));
    let settled = run(&["--aov", "id=d.npy", "--tolerance", "1e-14"]);
    assert!(settled["settled"].as_u64() >= settled["hits"].as_u64(), "f32 cannot certify 1e-14: {settled}");
    assert_eq!(ids("d.npy"), ids("b.npy"));
    assert_eq!(run(&["--aov", "id=e.npy", "--method", "unit"])["accuracy"], "fast", "a method without a certificate");
    for bad in ["0", "-1", "1e-16", "nan", "much"] {
        dir.refused(2, &["render", "scene.toml", "-o", "no.png", "--tolerance", bad], &["tolerance"]);
    }
}

/// Scenes of the Standard Procedural Databases.
#[test]
fn scenes_of_another_program_are_rendered() {
    let dir = dir();
    for (name, text) in nff::all() {
        let (spheres, skipped) = match name {
            "balls_s2.nff" => (91, "1 polygon skipped"),
            "jacks.nff" => (6, "3 cones skipped"),
            _ => continue,
        };
        dir.put(name, text);
        let rendered = dir.render(&format!("{name} --size 64x64 -o out.png --json"));
        assert!(rendered.err.contains(skipped), "{name}: {}", rendered.err);
        let report = rendered.json();
        assert_eq!(report["spheres"], spheres, "{name}");
        assert!(report["hits"].as_u64() > Some(100), "{name}: {report}");
    }
}

/// The signature of PNG, and pHYs as the specification gives it (<https://www.w3.org/TR/png-3/#11pHYs>).
/// One --aov has one file; a second name in it would be part of the file's.
#[test]
fn an_aov_has_one_file() {
    let dir = TestDir::new(&[("s.toml", SPHERE)]);
    for (given, mend) in [
        ("id=a.npy,depth=b.npy", "--aov id=a.npy --aov depth=b.npy"),
        ("id=a.npy,depth=a.npy", "--aov id=a.npy --aov depth=a.npy"),
        ("id,depth=a.npz,mask=b.npz", "--aov mask=b.npz"),
    ] {
        dir.refused_render(2, &format!("s.toml --aov {given}"), &["in the name of a file", mend]);
    }
    // Other commas and equals signs belong to the name.
    dir.render("s.toml --aov id=a,b=c.npy");
    assert_eq!(dir.array("a,b=c.npy").1, [30, 40]);
}

#[test]
fn a_png_has_the_resolution_of_its_option() {
    let dir = TestDir::new(&[("s.toml", SPHERE)]);
    let resolution = |name: &str| {
        let file = dir.get(name);
        let info = ::png::Decoder::new(std::io::Cursor::new(file)).read_info().expect("a PNG");
        info.info().pixel_dims.map(|dims| (dims.xppu, dims.yppu, dims.unit == ::png::Unit::Meter))
    };
    dir.render("s.toml -o a.png");
    assert_eq!(resolution("a.png"), None);
    // 300 / 0.0254 = 11811.02, 72 / 0.0254 = 2834.65, 1 / 0.0254 = 39.37.
    for (dpi, per_metre) in [("300", 11811), ("72", 2835), ("1", 39), ("1000000", 39_370_079)] {
        dir.render(&format!("s.toml -o b.png --aov id=b.npy --aov depth=d.png --dpi {dpi}"));
        for name in ["b.png", "d.png"] {
            assert_eq!(resolution(name), Some((per_metre, per_metre, true)), "{name} {dpi}");
        }
    }
    assert_eq!(dir.array("a.png"), dir.array("b.png"), "the pixels stay");
    assert!(dir.good("compare a.png b.png").text().starts_with("equal"));
    // Another resolution is another file; tiles have theirs.
    dir.render("s.toml -o b.png --dpi 72");
    assert!(dir.render("s.toml -o b.png --dpi 72 --resume").err.contains("already there"));
    assert!(!dir.render("s.toml -o b.png --dpi 300 --resume").err.contains("already there"));
    for (tile, name) in [("1/2", "1.png"), ("2/2", "2.png")] {
        dir.render(&format!("s.toml -o {name} --tile {tile} --dpi 300"));
    }
    dir.good("merge 1.png 2.png -o m.png");
    assert!(dir.get("m.png") == dir.get("b.png"));
    for bad in ["0", "-1", "1.5", "1000001", "x"] {
        dir.refused_render(2, &format!("s.toml -o c.png --dpi={bad}"), &["--dpi", bad, "such as 300"]);
    }
    for files in ["-o c.npy", "-o c.exr --aov id=d.npy", "--aov depth=d.pfm", "-o - --raw", "--json"] {
        dir.refused_render(2, &format!("s.toml {files} --dpi 300"), &["--dpi applies to .png", ".png"]);
    }
    dir.render("s.toml -o c.tif --bits 16 --dpi 300");
    dir.refused_render(2, "s.toml -o c.jpg --bits 16", &["c.jpg has 8 bits", ".tif"]);
    dir.refused_render(2, "s.toml -o c.webp --resume", &["c.webp is a copy", ".png"]);
    dir.refused_render(2, "s.toml --size 70000x1 -o c.jpg", &["70000x1", "65535 pixels a side"]);
    dir.refused(2, "plan s.toml -o c.npy --dpi 300", &["--dpi applies to .png"]);
    dir.good("plan s.toml --backend cpu --dpi 300");
    dir.render("s.toml -o - --dpi 300");
    // Preferences may apply to other pictures.
    dir.put("config.toml", "dpi = 300\n");
    for variable in [("HALFLINE_CONFIG", "config.toml"), ("HALFLINE_DPI", "300")] {
        let run = dir.run_with("render s.toml -o e.npy --backend cpu", &[variable]);
        assert_eq!(run.code, 0, "{variable:?}: {}", run.err);
    }
}

/// Zooming by X shows the pixels of the middle: a zoom by 3 of a picture with an odd number of pixels has every third ray
/// of the other one.
#[test]
fn zoom_narrows_the_viewport_and_keeps_the_eye() {
    let atoms = "3\nProperties=species:S:1:pos:R:3\nC 0 0 0\nO 2 0 1\nN 0 1.5 3\n";
    let dir = TestDir::new(&[("s.toml", SPHERE), ("m.xyz", atoms)]);
    let ids = |options: &str| {
        let ((ids, shape), (positions, _)) = {
            dir.render(&format!("{options} --aov id=i.npy --aov position=p.npy"));
            (dir.array("i.npy"), dir.array("p.npy"))
        };
        (ids, positions, shape)
    };
    for (file, height) in [("s.toml", 33), ("m.xyz", 33), ("m.xyz --ortho", 33), ("m.xyz --eye 1,0,9 --ortho 5", 33)] {
        let (whole, at, _) = ids(&format!("{file} --size 45x{height}"));
        let (zoomed, at_zoomed, shape) = ids(&format!("{file} --size 45x{height} --zoom 3"));
        assert_eq!(shape, [33, 45]);
        // Pixel 22 + 3 k of the zoomed picture sees along the ray of pixel 22 + k; so do rows, about 16.
        let mut hits = 0;
        for (row, column) in (-5..=5i32).flat_map(|row| (-7..=7i32).map(move |column| (row, column))) {
            let index = |row: i32, column: i32| ((16 + row) * 45 + 22 + column) as usize;
            let (near, far) = (index(row, column), index(3 * row, 3 * column));
            assert_eq!(whole[near], zoomed[far], "{file} at {row}, {column}");
            for k in 0..3 {
                let (a, b) = (at[3 * near + k], at_zoomed[3 * far + k]);
                // The two rays differ by a rounding of the viewport, certified distances by 1e-5 of some 10 units.
                assert!(a.is_nan() == b.is_nan() && (a.is_nan() || (a - b).abs() <= 2e-4), "{file}: {a} and {b}");
            }
            hits += usize::from(whole[near] >= 0.0);
        }
        assert!(hits > 20, "{file}: {hits} hits");
    }
    // 1 changes nothing, and a zoom is part of the scene.
    dir.render("s.toml -o a.png --zoom 2");
    assert!(!dir.render("s.toml -o a.png --zoom 3 --resume").err.contains("already there"));
    for bad in ["0", "-2", "inf", "nan", "x"] {
        dir.refused_render(2, &format!("s.toml -o c.png --zoom={bad}"), &["--zoom", bad, "positive"]);
    }
    dir.refused_render(3, "s.toml -o c.png --zoom 1e-320", &["camera.viewport", "positive finite"]);
}

#[test]
fn a_plan_without_an_output_is_that_of_a_picture() {
    let dir = TestDir::new(&[("s.toml", SCENE)]);
    let plan = |options: &str| dir.good(&format!("plan s.toml --backend cpu --json {options}")).json();
    let left_out = |plan: &Value| plan["left_out"].to_string().contains("no picture is requested");
    let keys = |plan: &Value| ["frame", "left_out", "rays_per_pixel", "samples"].map(|key| plan[key].clone());
    assert_eq!(keys(&plan("")), keys(&plan("-o a.png")));
    assert!(!left_out(&plan("")) && !left_out(&plan("--samples 4")) && !left_out(&plan("--dpi 300")));
    assert!(left_out(&plan("--aov depth=z.npy")), "what is requested is all");
    assert!(dir.files().len() == 1, "nothing is written");
}
