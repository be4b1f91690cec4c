//! The promise of the look of particles: with all other options the picture has one look; buffers do not depend on it.
//! A fully lit sphere has its own colour, which is the legend's, and beyond it pictures of levels keep the shape of spheres.

use crate::test_dir::{Output, TestDir};

/// Atoms of four elements that overlap, in two layers. None is as far from a pixel's ray as another, so that methods without a
/// certificate see the same ones.
fn dir() -> TestDir {
    let elements = ["C", "O", "N", "S"];
    let atom = |n: usize| {
        let shift = [7, 11, 13].map(|k| (n * k % 17) as f64 * 0.0213);
        let [x, y, z] =
            [(n % 4) as f64 * 2.1 + shift[0], (n / 4 % 4) as f64 * 2.3 + shift[1], (n / 16) as f64 * 2.5 + shift[2]];
        format!("{} {x} {y} {z}\n", elements[n * 7 % 5 % 4])
    };
    let atoms: String = (0..32).map(atom).collect();
    TestDir::new(&[("m.xyz", &format!("32\n\n{atoms}")), ("o.xyz", "1\n\nO 0 0 0\n"), ("c.toml", "samples = 4\n")])
}

/// The levels of a picture with these options.
fn picture(dir: &TestDir, options: &str) -> Vec<f64> {
    let size = if options.contains("--size") { "" } else { "--size 60x50" };
    dir.render(&format!("m.xyz {size} -o p.png {options}"));
    dir.array("p.png").0
}

/// The mean of each channel.
fn mean(levels: &[f64]) -> [f64; 3] {
    let sum = |k: usize| levels.iter().skip(k).step_by(3).sum::<f64>();
    [0, 1, 2].map(|k| sum(k) / (levels.len() / 3) as f64)
}

#[test]
fn what_is_requested_besides_leaves_the_look() {
    let dir = dir();
    let usual = picture(&dir, "");
    let bytes = dir.get("p.png");
    picture(&dir, "--look soft");
    assert!(dir.get("p.png") == bytes, "--look soft is the default, bit for bit");
    for options in [
        "--samples 4",
        "--aov depth=d.npy --aov id=i.npy --aov occlusion=o.npy",
        "--accuracy certified",
        "--accuracy exact",
        "--accuracy fast",
        "--method stable",
        "--seed 0 --bits 8 --json",
        "--samples 4 --look soft --accuracy certified --aov normal=n.npy",
    ] {
        assert!(picture(&dir, options) == usual, "{options}");
    }
    for variable in [("HALFLINE_SAMPLES", "4"), ("HALFLINE_ACCURACY", "certified"), ("HALFLINE_CONFIG", "c.toml")] {
        let Output { code, err, .. } = dir.run_with("render m.xyz --backend cpu --size 60x50 -o p.png", &[variable]);
        assert_eq!(code, 0, "{err}");
        assert!(dir.array("p.png").0 == usual, "{variable:?}");
    }
    // Smoother or coarser outlines move pixels by 1 to 4 levels in the mean, another light by 9 or more.
    let off = |other: &[f64]| usual.iter().zip(other).map(|(a, b)| (a - b).abs()).sum::<f64>() / usual.len() as f64;
    for (options, is_near) in [
        ("--samples 1", true),
        ("--samples 9", true),
        ("--samples 16", true),
        ("--look plain", false),
        ("--shade headlight", false),
        ("--shade flat", false),
        ("--look figure", false),
    ] {
        let off = off(&picture(&dir, options));
        assert!(if is_near { off < 5.0 } else { off > 8.0 }, "{options}: {off}");
    }
    let larger = mean(&picture(&dir, "--size 120x100"));
    // Lines are 1.3 pixels wide at each size: they darken the smaller picture by 2 levels more.
    assert!(mean(&usual).iter().zip(larger).all(|(a, b)| (a - b).abs() < 4.0), "{larger:?}");
    assert!(picture(&dir, "--shade headlight") == picture(&dir, "--look plain"), "a light at the eye");
    let json = dir.render("m.xyz --size 20x20 -o p.png --json").json();
    assert_eq!((&json["look"], &json["tone"], &json["samples"]), (&"soft".into(), &"soft".into(), &4.into()));
}

#[test]
fn buffers_do_not_depend_on_looks() {
    let dir = dir();
    let aovs = "--aov depth=d.npy --aov id=i.npy --aov normal=n.npy --aov occlusion=o.npy --aov certainty=c.npy";
    let buffers = |options: &str| {
        let report = dir.render(&format!("m.xyz --size 60x50 {aovs} --json {options}")).json();
        (["d", "i", "n", "o", "c"].map(|name| dir.array(&format!("{name}.npy"))), report)
    };
    let (alone, report) = buffers("");
    assert!(report["look"].is_null() && report["samples"] == 1, "nothing of a look is computed: {report}");
    assert!(report["stages_ms"]["samples"].is_null(), "{report}");
    for options in ["-o p.png", "-o p.png --look plain", "-o p.png --look figure", "--look soft"] {
        assert!(buffers(options).0 == alone, "{options}");
    }
    // The light of a look is none of the scene.
    dir.refused_render(2, "m.xyz -o p.png --aov shadow=s.npy", &["shadow needs a light"]);
    dir.render("m.xyz --size 20x20 -o p.png --aov shadow=s.npy --sun 1,2,3");
}

#[test]
fn a_stream_says_that_its_look_is_plain() {
    let dir = dir();
    let table: String = (0..9).map(|n| format!("{},{},0,0.6\n", n % 3, n / 3)).collect();
    dir.put("t.csv", format!("x,y,z,radius\n{table}"));
    let words = "look plain: a stream is lit from the eye";
    let warnings = |options: &str| dir.render(&format!("t.csv --size 30x30 {options}")).err.matches(words).count();
    assert_eq!(
        [warnings("-o a.png --stream"), warnings("-o b.png --look plain"), warnings("--aov id=i.npy --stream")],
        [1, 0, 0]
    );
    assert_eq!(warnings("-o c.png --stream --look plain"), 0, "as it was asked");
    assert!(dir.get("a.png") == dir.get("b.png") && dir.get("a.png") == dir.get("c.png"));
}

/// The swatch of an element has the colour of its atom where that faces the light under an open sky.
#[test]
fn a_sphere_in_full_light_has_the_colour_of_the_legend() {
    let dir = dir();
    dir.render("o.xyz --size 200x200 -o p.png --color-by element --legend l.svg --background white");
    let legend = String::from_utf8(dir.get("l.svg")).expect("UTF-8");
    let swatch = legend.split("<rect").find(|part| part.contains(">O<")).expect("a swatch");
    let hex = swatch.split('#').nth(1).expect("a colour");
    let own = [0, 2, 4].map(|k| f64::from(u8::from_str_radix(&hex[k..k + 2], 16).expect("two digits")));
    let (levels, _) = dir.array("p.png");
    let atom = || levels.chunks(3).filter(|rgb| rgb[1] < 200.0);
    // The nearest pixel is at most 1 from the brightest point and the radius is 80: the cosine is 1 within 1e-4, half a level.
    let brightest = atom().max_by(|a, b| a[0].total_cmp(&b[0])).expect("an atom");
    assert!(brightest.iter().zip(own).all(|(found, own)| (found - own).abs() <= 1.0), "{brightest:?}, not {own:?}");
    assert!(atom().filter(|rgb| rgb[0] == 255.0).count() * 20 < atom().count(), "only there");
    assert!(levels.chunks(3).filter(|rgb| rgb[1] > 254.0).all(|rgb| rgb == [255.0; 3]), "white stays white");
}

/// A ball of this colour before the eye, lit from there by as much.
fn ball_scene(color: &str, intensity: &str) -> String {
    format!(
        "[camera]\neye = [0, 0, 9]\nview = [0, 0, -1]\nup = [0, 1, 0]\nvfov = 20\n[image]\nsize = [60, 40]
background = [1, 0.5, 0.25]\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\ncolor = {color}
[[light]]\ndirection = [0, 0, 1]\nintensity = {intensity}\n"
    )
}

#[test]
fn what_exceeds_one_keeps_its_shape_in_pictures_of_levels() {
    let dir =
        TestDir::new(&[("red.toml", &ball_scene("[1, 0, 0]", "2")), ("dim.toml", &ball_scene("[1, 0.5, 0]", "1"))]);
    let levels = |options: &str| {
        dir.render(&format!("{options} -o p.png --samples 4"));
        dir.array("p.png").0
    };
    let colors = |levels: &[f64]| {
        let mut all: Vec<[u64; 3]> = levels.chunks(3).map(|rgb| [0, 1, 2].map(|k| rgb[k] as u64)).collect();
        all.sort_unstable();
        all.dedup();
        all.into_iter().filter(|rgb| rgb[0] == 255 && rgb[1] == rgb[2]).count()
    };
    let [soft, linear] = ["red.toml", "red.toml --tone linear"].map(levels);
    assert!(colors(&soft) > 60 && colors(&linear) == 1, "{} and {}", colors(&soft), colors(&linear));
    assert!(soft[..3] == linear[..3], "the background keeps its bytes");
    assert!(levels("dim.toml") == levels("dim.toml --tone linear"), "colours up to 1 too");
    assert_eq!(levels("red.toml --exposure -1"), levels("red.toml --exposure -1 --tone linear"), "up to 1 again");
    // 16 bits are finer levels of the same light.
    let fine = levels("red.toml --bits 16");
    assert!(fine.iter().zip(&soft).all(|(fine, coarse)| (fine / 257.0 - coarse).abs() <= 0.51));
    // Linear files know nothing of it.
    for file in ["p.npy", "p.exr", "p.pfm", "p.npz", "p.raw"] {
        let bytes = |options: &str| {
            dir.render(&format!("red.toml -o {file} {options}"));
            dir.get(file)
        };
        assert!(bytes("") == bytes("--tone linear --exposure 3"), "{file}");
    }
    // A background of the scene is not premultiplied, a transparent one is left out first.
    let clear = levels("red.toml --transparent");
    let edge = |levels: &[f64]| levels.chunks(4).filter(|rgba| rgba[3] > 0.0 && rgba[3] < 255.0).count();
    assert!(edge(&clear) > 20 && clear.chunks(4).filter(|rgba| rgba[3] == 255.0).any(|rgba| rgba[1] > 100.0));
    for bad in ["--exposure 33", "--exposure nan", "--tone warm"] {
        dir.refused_render(2, &format!("red.toml -o x.png {bad}"), &[bad.split(' ').next().expect("an option")]);
    }
    let (plan, err) =
        (dir.good("plan red.toml -o p.png --exposure 0.5"), "soft: colours beyond 1 become whiter, exposure 0.5 stops");
    assert!(plan.text().contains(err), "{}", plan.text());
    let variables = [("HALFLINE_TONE", "linear"), ("HALFLINE_EXPOSURE", "0")];
    assert_eq!(dir.run_with("render red.toml -o p.png --samples 4 --backend cpu", &variables).code, 0);
    assert!(dir.array("p.png").0 == linear);
}

#[test]
fn tiles_and_resumed_files_have_one_tone() {
    let dir = TestDir::new(&[("red.toml", &ball_scene("[1, 0, 0]", "2"))]);
    let render = |options: &str| dir.render(&format!("red.toml {options}"));
    render("-o whole.png --exposure 0.5");
    for tile in 1..=4 {
        render(&format!("--exposure 0.5 --tile {tile}/4 -o t{tile}.png"));
    }
    dir.good("merge t1.png t2.png t3.png t4.png -o merged.png");
    assert!(dir.get("merged.png") == dir.get("whole.png"));
    for other in ["", "--exposure 1", "--exposure 0.5 --tone linear"] {
        render(&format!("--tile 4/4 -o t5.png {other}"));
        dir.refused(3, "merge t1.png t2.png t3.png t5.png -o other.png", &["t5.png", "halfline:"]);
        assert!(!render(&format!("-o whole.png --resume {other}")).err.contains("already there"), "{other}");
        assert!(render(&format!("-o whole.png --resume {other}")).err.contains("already there"), "{other}");
    }
}

/// Nothing of tone is in a picture that is lit from the eye: neither in its pixels nor in its keywords.
#[test]
fn a_picture_with_light_at_the_eye_is_linear() {
    let dir = dir();
    let bytes = |options: &str| {
        dir.render(&format!("m.xyz --size 40x40 --look plain -o p.png {options}"));
        dir.get("p.png")
    };
    assert!(bytes("") == bytes("--tone linear --exposure 0"));
    assert!(!bytes("").windows(13).any(|part| part == b"halfline:tone") && bytes("") != bytes("--tone soft"));
}
