//! The promise of `[sky]` in a scene file: a gradient behind all spheres, by the formula of docs/light.md, that also lights
//! them; the same in parts of a frame.

use crate::test_dir::TestDir;

const HORIZON: [f64; 3] = [0.75, 0.5, 0.25];
const ZENITH: [f64; 3] = [0.0, 0.25, 1.0];

/// A level camera that sees from 45 degrees below the horizon to 45 degrees above it, and a white ball.
fn scene(more: &str) -> String {
    format!(
        "[camera]\neye = [0, 0, 0]\nview = [0, 0, -1]\nup = [0, 3, 0]\nvfov = 90\n[image]\nsize = [40, 40]\n{more}
[[sphere]]\ncenter = [0, 0, -5]\nradius = 1\ncolor = [1, 1, 1]\n[sky]\nzenith = [0, 0.25, 1]\nhorizon = [0.75, 0.5, 0.25]\n"
    )
}

fn dir() -> TestDir {
    TestDir::new(&[("s.toml", &scene("")), ("b.toml", &scene("background = 'white'"))])
}

/// The linear colours of a picture, pixel by pixel, and its width.
fn colors(dir: &TestDir, options: &str) -> Vec<[f64; 3]> {
    dir.render(&format!("{options} -o c.npy"));
    dir.array("c.npy").0.chunks(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect()
}

/// The sky at the sine of an elevation.
fn sky(sine: f64) -> [f64; 3] {
    let zenith = 1.0 - (1.0 - sine.max(0.0)).powi(8);
    [0, 1, 2].map(|k| HORIZON[k] + (ZENITH[k] - HORIZON[k]) * zenith)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn the_background_is_the_documented_gradient() {
    let dir = dir();
    let found = colors(&dir, "s.toml");
    for (row, column) in (0..40).flat_map(|row| [0, 7, 39].map(|column| (row, column))) {
        // The ray through the pixel's centre, on a view of 2 x 2 at distance 1.
        let [x, y] = [(2 * column + 1) as f64 / 40.0 - 1.0, 1.0 - (2 * row + 1) as f64 / 40.0];
        let expected = sky(y / (x * x + y * y + 1.0).sqrt());
        // Stored as f32.
        assert!(distance(found[40 * row + column], expected) < 1e-6, "{row}, {column}");
    }
    // A pixel has the mean of its samples, which differ from the centre by less than half a row: 0.18 of zenith's share.
    let many = colors(&dir, "s.toml --samples 16");
    assert!(distance(many[0], found[0]) < 0.05 && many[0] != found[0]);
    // With parallel rays all of them have one elevation.
    let parallel = colors(&dir, "s.toml --ortho 8 --view 0,0.6,-0.8 --eye 0,-9,12");
    assert!(distance(parallel[0], sky(0.6)) < 1e-6 && parallel[0] == parallel[39]);
    // Up is the camera's: upside down, the picture has the same sky.
    let turned = colors(&dir, "s.toml --up 0,-1,0");
    assert!(distance(turned[0], found[0]) < 1e-6, "{:?}", turned[0]);
}

#[test]
fn an_open_sky_lights_a_sphere_with_its_mean() {
    let dir = dir();
    let found = colors(&dir, "s.toml --aov occlusion=o.npy");
    assert!(dir.array("o.npy").0.iter().all(|open| *open == 1.0), "nothing hides it from a single sphere");
    // The normal at the middle is horizontal: half of what it sees is below the horizon. The mean of the zenith's share, weighted
    // by the cosine, is 2/pi times the integral of (1 - (1 - s)^8) sqrt(1 - s^2) for s from 0 to 1.
    let of_rows = |colors: &[[f64; 3]]| [0, 1, 2].map(|k| (colors[40 * 19 + 20][k] + colors[40 * 20 + 20][k]) / 2.0);
    let middle = of_rows(&found);
    let steps = 100_000;
    let share = |k: usize| {
        let s = (k as f64 + 0.5) / steps as f64;
        (1.0 - (1.0 - s).powi(8)) * (1.0 - s * s).sqrt()
    };
    let zenith = (0..steps).map(share).sum::<f64>() / steps as f64 * 2.0 / std::f64::consts::PI;
    let expected = [0, 1, 2].map(|k| HORIZON[k] + (ZENITH[k] - HORIZON[k]) * zenith);
    // The normals of these two pixels are 0.1 above and below the horizon, where the mean's curve is nearly straight: seen 0.002.
    assert!(distance(middle, expected) < 0.01, "{middle:?}, not {expected:?}");
    // No noise: neighbours differ by their normals alone.
    let column: Vec<f64> = (18..22).map(|row| found[40 * row + 20][2]).collect();
    assert!(column.windows(2).all(|pair| pair[0] > pair[1] && pair[0] - pair[1] < 0.1), "{column:?}");
    // A light that does not reach these pixels takes nothing from it, be it the file's or added.
    dir.put("l.toml", scene("") + "[[light]]\ndirection = [0, 0, -1]\n");
    for options in ["l.toml", "s.toml --sun=0,0,-1"] {
        let outer = of_rows(&colors(&dir, options));
        assert!(distance(outer, middle) < 1e-6, "{options}: {outer:?}");
    }
    // What hides it has no colour: a ground takes the lower half away, which gives 0.88 of the red and 0.22 of the blue.
    dir.put("g.toml", scene("") + "[[sphere]]\ncenter = [0, -1001, -5]\nradius = 1000\ncolor = [0, 0, 0]\n");
    // 1024 rays for each pixel, since few are open in the red; these two pixels are then within 0.003 of 4096 rays each.
    let ground = of_rows(&colors(&dir, "g.toml --samples 16 --occlusion 64"));
    assert!(
        ground[0] < 0.3 * middle[0] && ground[2] > 0.65 * middle[2] && ground[2] < 0.9 * middle[2],
        "{ground:?} beside {middle:?}"
    );
}

#[test]
fn a_background_is_shown_in_place_of_the_sky_and_the_sky_still_lights() {
    let dir = dir();
    let [shown, hidden, given] = ["s.toml", "b.toml", "s.toml --background white"].map(|options| colors(&dir, options));
    assert!(hidden == given && given[0] == [1.0; 3] && shown[0] != given[0]);
    assert!(shown[40 * 20 + 20] == given[40 * 20 + 20], "the same light");
    dir.render("s.toml --transparent -o t.png");
    let (pixels, _) = dir.array("t.png");
    assert!(pixels[..4] == [0.0; 4], "{:?}", &pixels[..4]);
    // Shading without light has one background.
    let flat = colors(&dir, "s.toml --shade flat");
    assert!(distance(flat[0], HORIZON) < 1e-6 && flat[0] == flat[1599]);
    let cue = colors(&dir, "s.toml --depth-cue");
    assert!(cue[0] == shown[0] && cue[40 * 20 + 20] != shown[40 * 20 + 20]);
}

#[test]
fn parts_of_a_frame_have_the_bytes_of_the_frame() {
    let dir = dir();
    dir.put("m.toml", scene("samples = 4\nlook = 'soft'"));
    dir.render("m.toml -o whole.png");
    for tile in 1..=6 {
        dir.render(&format!("m.toml --tile {tile}/6 -o t{tile}.png"));
    }
    dir.good("merge t1.png t2.png t3.png t4.png t5.png t6.png -o merged.png");
    assert!(dir.get("merged.png") == dir.get("whole.png"));
    // The keys of the file are defaults of the options.
    let plan = |options: &str| {
        let plan = dir.good(&format!("plan m.toml -o p.png --backend cpu --json {options}")).json();
        (
            plan["samples"].as_u64(),
            plan["silhouette"].as_bool(),
            plan["occlusion"]["rays"].as_u64(),
            plan["lights"].as_u64(),
        )
    };
    assert_eq!(plan(""), (Some(4), Some(true), Some(3), Some(1)));
    assert_eq!(plan("--look plain --samples 9"), (Some(9), Some(false), Some(3), Some(0)));
    let text = dir.good("plan m.toml -o p.png --backend cpu").text();
    assert!(text.contains("zenith 0, 0.25, 1, horizon 0.75, 0.5, 0.25"), "{text}");
}
