//! The promise of `--lens` and of `[camera] lens`: rays follow the models that docs/light.md names, whoever gives the lens.

use crate::page::{Page, moved};
use crate::test_dir::TestDir;
use serde_json::json;
use std::f64::consts::PI;

/// Balls in front, at the sides and behind an eye at the origin that looks along -z.
const ROWS: &str = "x,y,z,radius\n0,0,-40,12\n30,5,-45,9\n-25,-20,-50,11\n-30,30,-60,14\n20,-28,-44,8\n50,0,3,9\n0,45,-9,8\n-6,-48,10,7\n9,4,60,10\n";

const POSE: &str = "--eye 0,0,0 --view 0,0,-1 --up 0,1,0 --look plain";

/// The place of a direction (right, down, ahead) in the image by the formulas of docs.opencv.org (calib3d, fisheye), in focal lengths.
fn distorted([k1, k2, p1, p2, k3, k4, k5, k6]: [f64; 8], [x, y, z]: [f64; 3]) -> [f64; 2] {
    let (x, y) = (x / z, y / z);
    let r2 = x * x + y * y;
    let radial =
        (1.0 + k1 * r2 + k2 * r2.powi(2) + k3 * r2.powi(3)) / (1.0 + k4 * r2 + k5 * r2.powi(2) + k6 * r2.powi(3));
    [x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y]
}

fn fisheye([k1, k2, k3, k4]: [f64; 4], [x, y, z]: [f64; 3]) -> [f64; 2] {
    let r = x.hypot(y);
    let theta = r.atan2(z);
    let bent = theta + k1 * theta.powi(3) + k2 * theta.powi(5) + k3 * theta.powi(7) + k4 * theta.powi(9);
    [bent * x / r, bent * y / r]
}

/// Renders an image of `size` and checks that the hit of each pixel is where `place` shows it: at the pixel's centre.
fn check(dir: &TestDir, words: &str, size: [usize; 2], least: usize, place: &dyn Fn([f64; 3]) -> [f64; 2]) {
    dir.render(&format!("{words} --aov position=p.npy --aov id=i.npy"));
    let [positions, ids] = ["p.npy", "i.npy"].map(|name| dir.array(name).0);
    assert_eq!(ids.len(), size[0] * size[1], "{words}");
    let hits: Vec<usize> = (0..ids.len()).filter(|pixel| ids[*pixel] >= 0.0).collect();
    for pixel in &hits {
        // Right, down and ahead of an eye at the origin.
        let found = place([positions[3 * pixel], -positions[3 * pixel + 1], -positions[3 * pixel + 2]]);
        let expected = [(pixel % size[0]) as f64 + 0.5, (pixel / size[0]) as f64 + 0.5];
        // Rounding: an error of the distance moves the hit along its ray.
        let apart = (found[0] - expected[0]).hypot(found[1] - expected[1]);
        assert!(apart < 1e-8, "{words}, pixel {pixel}: {found:?} for {expected:?}");
    }
    assert!(hits.len() >= least, "{words}: {} hits", hits.len());
}

#[test]
fn lenses_have_the_rays_of_their_models() {
    let dir = TestDir::new(&[("a.csv", ROWS)]);
    let rational = [-0.2, 0.04, 0.003, -0.002, 0.001, 0.02, -0.003, 0.0004];
    for count in [4, 5, 8] {
        let mut k = rational;
        k[count..].fill(0.0);
        let list = rational[..count].iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        let words =
            format!("a.csv {POSE} --size 40x30 --lens opencv --intrinsics 30,31,21,14.5 --lens-coefficients {list}");
        // A zoom is about the principal point, with the same coefficients.
        for zoom in [1.0, 1.5] {
            check(&dir, &format!("{words} --zoom {zoom}"), [40, 30], 300, &|d| {
                let [x, y] = distorted(k, d);
                [30.0 * zoom * x + 21.0, 31.0 * zoom * y + 14.5]
            });
        }
    }
    let pinhole = "--size 40x30 --lens opencv --intrinsics 30,31,21,14.5";
    check(&dir, &format!("a.csv {POSE} {pinhole}"), [40, 30], 300, &|[x, y, z]| {
        [30.0 * x / z + 21.0, 31.0 * y / z + 14.5]
    });
    let k = [0.05, -0.01, 0.002, 0.001];
    let given = "--lens fisheye --intrinsics 15,16,21,14.5 --lens-coefficients 0.05,-0.01,0.002,0.001";
    check(&dir, &format!("a.csv {POSE} --size 40x30 {given}"), [40, 30], 150, &|d| {
        let [x, y] = fisheye(k, d);
        [15.0 * x + 21.0, 16.0 * y + 14.5]
    });
    for (more, degrees) in [("", 180.0_f64), ("--vfov 40", 40.0), ("--vfov 250", 250.0), ("--vfov 360", 360.0)] {
        // The full height is the angle: equidistant.
        let focal = 30.0 / degrees.to_radians();
        for zoom in [1.0, 2.0] {
            let words = format!("a.csv {POSE} --size 40x30 --lens fisheye {more} --zoom {zoom}");
            check(&dir, &words, [40, 30], 60, &|d| {
                let [x, y] = fisheye([0.0; 4], d);
                [zoom * focal * x + 20.0, zoom * focal * y + 15.0]
            });
        }
    }
    check(&dir, &format!("a.csv {POSE} --size 60x30 --lens equirectangular"), [60, 30], 100, &|[x, y, z]| {
        let (longitude, latitude) = (x.atan2(z), (-y).atan2(x.hypot(z)));
        [60.0 * (longitude / (2.0 * PI) + 0.5), 30.0 * (0.5 - latitude / PI)]
    });
}

/// The contract of --vfov: a fisheye of 180 degrees shows what is at 90 degrees at the edge of its image.
#[test]
fn a_fisheye_of_180_degrees_has_90_degrees_at_its_edge() {
    let dir = TestDir::new(&[("a.csv", "x,y,z,radius\n50,0,0,2\n0,50,0,2\n0,0,-50,2\n0,0,50,2\n")]);
    dir.render(&format!("a.csv {POSE} --size 201x201 --lens fisheye --vfov 180 --aov id=i.npy"));
    let ids = dir.array("i.npy").0;
    let places = |id: f64| (0..201 * 201).filter(|n| ids[*n] == id).map(|n| [n % 201, n / 201]).collect::<Vec<_>>();
    let (right, top, ahead, behind) = (places(0.0), places(1.0), places(2.0), places(3.0));
    // A radius of 2.3 degrees is 2.6 pixels.
    assert!(right.contains(&[200, 100]) && right.iter().all(|[x, y]| *x >= 198 && y.abs_diff(100) <= 3), "{right:?}");
    assert!(top.contains(&[100, 0]) && top.iter().all(|[x, y]| *y <= 2 && x.abs_diff(100) <= 3), "{top:?}");
    assert!(ahead.contains(&[100, 100]) && ahead.len() < 40 && behind.is_empty(), "{ahead:?} {behind:?}");
}

/// A scene file, `--camera-from` and the options give one lens: the same numbers.
#[test]
fn scene_files_and_options_give_the_same_lens() {
    let lenses = [
        ("lens = \"fisheye\"\nvfov = 200.0\n", "--lens fisheye --vfov 200", [20.0, 15.0]),
        ("lens = \"fisheye\"\n", "--lens fisheye", [20.0, 15.0]),
        ("lens = \"equirectangular\"\n", "--lens equirectangular", [20.0, 15.0]),
        (
            "lens = \"opencv\"\nfx = 30\nfy = 31\ncx = 21\ncy = 14.5\ncoefficients = [-0.2, 0.04, 0.003, -0.002]\n",
            "--lens opencv --intrinsics 30,31,21,14.5 --lens-coefficients -0.2,0.04,0.003,-0.002",
            [21.0, 14.5],
        ),
        (
            "lens = \"opencv\"\nfx = 30\nfy = 31\ncx = 21\ncy = 14.5\n",
            "--lens opencv --intrinsics 30,31,21,14.5",
            [21.0, 14.5],
        ),
        (
            "lens = \"fisheye\"\nfx = 15\nfy = 15\ncx = 20\ncy = 15\ncoefficients = [0.05, 0, 0, 0]\n",
            "--lens fisheye --intrinsics 15,15,20,15 --lens-coefficients 0.05,0,0,0",
            [20.0, 15.0],
        ),
    ];
    for (keys, options, center) in lenses {
        let scene = |lens: &str| {
            format!(
                "[camera]\neye = [0, 0, 0]\nview = [0, 0, -1]\nup = [0, 1, 0]\n{lens}[image]\nsize = [40, 30]\n\
                 [[spheres]]\nfile = \"a.csv\"\n"
            )
        };
        let flat = scene("vfov = 50\n");
        let dir = TestDir::new(&[("a.csv", ROWS), ("own.toml", &scene(keys)), ("flat.toml", &flat)]);
        let report = dir.render("own.toml --aov distance=own.npy -o own.png --json").json();
        dir.render(&format!("flat.toml {options} --aov distance=given.npy"));
        dir.render("flat.toml --camera-from own.toml --aov distance=from.npy");
        dir.render("flat.toml --camera-from own.png --aov distance=picture.npy");
        let own = dir.array("own.npy").0;
        assert!(own.iter().any(|distance| distance.is_finite()), "{keys}");
        for other in ["given.npy", "from.npy", "picture.npy"] {
            assert!(dir.array(other).0 == own, "{keys}: {other}");
        }
        let found = ["cx", "cy"].map(|key| report["camera"]["intrinsics"][key].as_f64().expect("a number"));
        assert_eq!(found, center, "{keys}");
        // Twice as many rows and columns: the same directions, and pixels of half the width.
        let large = dir.render("own.toml --size 80x60 --aov id=large.npy --json").json();
        let small = &report["camera"]["intrinsics"];
        for key in ["fx", "fy", "cx", "cy"] {
            let [one, two] = [small, &large["camera"]["intrinsics"]].map(|of| of[key].as_f64().expect("a number"));
            assert!((two - 2.0 * one).abs() < 1e-12 * two, "{keys} {key}: {one} {two}");
        }
        dir.render("flat.toml --camera-from own.png --size 80x60 --aov id=again.npy");
        assert!(dir.array("large.npy").0 == dir.array("again.npy").0, "{keys}");
        // An option for the angle makes it a perspective one.
        dir.render("own.toml --vfov 50 --aov distance=flat.npy");
        dir.render("flat.toml --aov distance=known.npy");
        assert!(dir.array("flat.npy").0 == dir.array("known.npy").0, "{keys}");
    }
}

/// Particles without a camera: all balls are in the picture, and none is cut.
#[test]
fn particles_are_framed_through_a_lens() {
    let mut rows = "x,y,z,radius\n".to_owned();
    for n in 0..27 {
        let [x, y, z] = [n % 3, n / 3 % 3, n / 9].map(|k| f64::from(k) * 10.0 - 10.0);
        rows += &format!("{},{},{z},2\n", x + 1.3 * z / 10.0 + 0.7 * y / 10.0, y + 1.7 * z / 10.0 - 0.9 * x / 10.0);
    }
    let dir = TestDir::new(&[("a.csv", &rows)]);
    for lens in [
        "--lens fisheye",
        "--lens fisheye --vfov 40",
        "--lens fisheye --vfov 300",
        "--lens opencv --intrinsics 100,100,60,45 --lens-coefficients -0.2,0.04,0.003,-0.002",
        "--lens opencv --intrinsics 100,100,60,45 --lens-coefficients 0.3,0.1,0,0,0.1",
        "--lens opencv --intrinsics 150,140,30,60",
        "--lens fisheye --vfov 100 --view left",
        "--lens fisheye --vfov 100 --view iso --fit",
    ] {
        dir.render(&format!("a.csv --look plain --size 120x90 {lens} --aov id=i.npy"));
        let ids = dir.array("i.npy").0;
        let border = (0..120 * 90).filter(|n| [0, 119].contains(&(n % 120)) || [0, 89].contains(&(n / 120)));
        assert!(border.clone().all(|n| ids[n] < 0.0), "{lens}: a ball is cut");
        let shown = (0..27).filter(|id| ids.contains(&f64::from(*id))).count();
        // Some hide others.
        assert!(shown >= 12, "{lens}: {shown} of the 27 balls");
    }
    let focus = ["--lens", "fisheye", "--focus", "index 13", "--aov", "id=i.npy"];
    dir.render(&[&["a.csv", "--look", "plain", "--size", "120x90"][..], &focus].concat());
    assert!(dir.array("i.npy").0.contains(&13.0));
}

/// The eye of a panorama without a camera is the middle of the balls, and a warning says where that is inside of one.
#[test]
fn the_eye_of_a_panorama_is_the_middle() {
    let around = "x,y,z,radius\n7,2,3,1\n-3,2,3,1\n2,7,3,1\n2,-3,3,1\n2,2,8,1\n2,2,-2,1\n";
    let dir = TestDir::new(&[("a.csv", around), ("b.csv", &format!("{around}2,2,3,1\n"))]);
    let output = dir.render("a.csv --look plain --size 80x40 --lens equirectangular --aov id=i.npy --json");
    assert_eq!(output.json()["camera"]["eye"], json!([2.0, 2.0, 3.0]));
    assert!(!output.err.contains("inside"), "{}", output.err);
    let ids = dir.array("i.npy").0;
    let at = |longitude: f64, latitude: f64| {
        let [x, y] = [80.0 * (longitude / 360.0 + 0.5), 40.0 * (0.5 - latitude / 180.0)];
        ids[80 * (y as usize).min(39) + (x as usize).min(79)]
    };
    // Front looks along -z.
    assert_eq!([at(0.0, 0.0), at(90.0, 0.0), at(-90.0, 0.0), at(180.0, 0.0)], [5.0, 0.0, 1.0, 4.0]);
    assert_eq!([at(0.0, 89.9), at(0.0, -89.9)], [2.0, 3.0]);
    let output = dir.render("a.csv --look plain --size 80x40 --lens equirectangular --at 9,2,3 --aov id=i.npy --json");
    assert_eq!(output.json()["camera"]["eye"], json!([2.0, 2.0, 3.0]));
    assert_eq!(dir.array("i.npy").0[80 * 20 + 40], 0.0, "what is looked at is in the middle");
    let inside = dir.render("b.csv --look plain --size 80x40 --lens equirectangular --aov id=i.npy");
    assert!(inside.err.contains("is inside of one of them; --eye gives another place"), "{}", inside.err);
}

#[test]
fn what_a_lens_cannot_do_is_refused_by_name() {
    let camera = "[camera]\neye = [0, 0, 0]\nview = [0, 0, -1]\nup = [0, 1, 0]\n";
    let rest = "[image]\nsize = [40, 30]\n[[spheres]]\nfile = \"a.csv\"\n";
    let dir = TestDir::new(&[("a.csv", ROWS)]);
    let panorama = "--lens equirectangular";
    let opencv = "--lens opencv --intrinsics 30,31,21,14.5";
    for (options, words) in [
        (format!("{panorama} --vfov 90"), &["--vfov", "whole sphere", "remove --vfov"][..]),
        (format!("{panorama} --zoom 2"), &["--zoom", "whole sphere", "remove --zoom"]),
        (format!("{panorama} --fit"), &["--fit", "whole sphere", "remove --fit"]),
        (format!("{panorama} --frame-share 90%"), &["--frame-share", "remove --frame-share"]),
        (format!("{panorama} --intrinsics 30,31,21,14.5"), &["--intrinsics", "remove --intrinsics"]),
        (format!("{panorama} --lens-coefficients 0,0,0,0"), &["--lens-coefficients", "remove --lens-coefficients"]),
        (format!("{panorama} --ortho 5"), &["--lens", "--ortho"]),
        (format!("{panorama} --aperture 1"), &["--lens", "--aperture"]),
        ("--lens fisheye --ortho".into(), &["--lens", "--ortho"]),
        ("--lens fisheye --aperture 1 --focus-distance 9".into(), &["--lens", "--aperture"]),
        ("--lens fisheye --vfov 361".into(), &["--vfov", "at most 360"]),
        ("--lens fisheye --vfov 90 --intrinsics 30,31,21,14.5".into(), &["--intrinsics", "--vfov"]),
        ("--lens fisheye --lens-coefficients 0.1,0.1".into(), &["--lens-coefficients", "k1,k2,k3,k4"]),
        ("--lens opencv".into(), &["--lens opencv", "add --intrinsics"]),
        ("--lens opencv --vfov 60".into(), &["--vfov", "remove --vfov"]),
        ("--lens opencv --intrinsics 0,31,21,14.5".into(), &["not positive", "525"]),
        (format!("{opencv} --lens-coefficients 0.1,0.1,0.1"), &["--lens-coefficients", "3 numbers", "k1,k2,p1,p2"]),
        (format!("{opencv} --lens-coefficients 0.1,x"), &["0.1,x", "--lens-coefficients", "finite numbers"]),
        (format!("{opencv} --aperture 1"), &["--lens", "--aperture"]),
        ("--lens-coefficients 0.1,0.1,0,0".into(), &["--lens"]),
        ("--intrinsics 30,31,21,14.5".into(), &["--intrinsics", "--lens opencv", "--cameras"]),
        ("--lens wide".into(), &["wide", "fisheye, equirectangular, opencv"]),
        ("--vfov 200".into(), &["--vfov is 200", "--lens fisheye"]),
        ("--lens fisheye --cameras list.json".into(), &["--lens", "--cameras"]),
        ("--lens fisheye --camera-from x.png".into(), &["--lens", "--camera-from"]),
        ("--lens fisheye --stream".into(), &["--stream", "a curved lens"]),
    ] {
        dir.refused_render(2, &format!("a.csv --look plain -o a.png {options}"), words);
    }
    dir.refused_render(
        3,
        "a.csv --look plain -o a.png --lens fisheye --scale-bar",
        &["--scale-bar", "remove --scale-bar"],
    );
    for (keys, words) in [
        ("lens = \"wide\"\n", &["camera.lens", "there is no lens 'wide'"][..]),
        ("lens = \"fisheye\"\nvfov = 400\n", &[":6:", "camera.vfov", "at most 360"]),
        ("lens = \"equirectangular\"\nvfov = 90\n", &["camera.vfov", "remove vfov"]),
        ("lens = \"fisheye\"\nheight = 4\n", &["camera.height", "remove lens"]),
        ("lens = \"opencv\"\n", &["camera.fx", "add fx, fy, cx, cy"]),
        ("lens = \"opencv\"\nfx = 3\n", &["camera.fy", "missing"]),
        ("lens = \"opencv\"\nfx = 3\nfy = -3\ncx = 1\ncy = 1\n", &["camera.fx", "not positive"]),
        (
            "lens = \"opencv\"\nfx = 3\nfy = 3\ncx = 1\ncy = 1\ncoefficients = [1]\n",
            &["camera.coefficients", "k1,k2,p1,p2"],
        ),
        ("vfov = 40\nfx = 3\n", &["camera.fx", "lens = \"opencv\""]),
        ("lens = \"fisheye\"\naperture = 0.5\nfocus = 3\n", &["camera.aperture", "remove the aperture"]),
    ] {
        dir.put("a.toml", format!("{camera}{keys}{rest}"));
        dir.refused_render(3, "a.toml -o a.png", words);
    }
    dir.put("p.toml", format!("{camera}lens = \"equirectangular\"\n{rest}"));
    for option in ["--zoom 2", "--fit"] {
        dir.refused_render(
            2,
            &format!("p.toml -o a.png {option}"),
            &[option.split(' ').next().expect("a name"), "whole sphere"],
        );
    }
}

/// The page begins with the picture of the command, keeps the lens when the camera moves and the window has another size, and its command
/// renders what it shows.
#[test]
fn the_page_keeps_the_lens() {
    let dir = TestDir::new(&[("a.csv", ROWS)]);
    for lens in [
        "--lens fisheye --vfov 200",
        "--lens fisheye --zoom 2",
        "--lens equirectangular",
        "--lens opencv --intrinsics 30,31,21,14.5 --lens-coefficients -0.2,0.04,0.003,-0.002",
        "--lens opencv --intrinsics 30,31,21,14.5",
        "--lens fisheye --intrinsics 15,16,21,14.5 --lens-coefficients 0.05,0,0,0",
    ] {
        let options = format!("a.csv --look plain --size 40x30 --eye 0,0,0 --at 0,0,-40 {lens}");
        let page = Page::open(&dir, &format!("{options} --backend cpu"));
        let camera = page.good("/scene", &json!({}))["camera"].clone();
        let body = json!({ "camera": camera, "size": [40, 30], "mode": "still" });
        dir.render(&format!("{options} -o own.png --aov id=i.npy --aov distance=d.npy"));
        let (ids, distances) = (dir.array("i.npy").0, dir.array("d.npy").0);
        for mut body in [body.clone(), json!({ "camera": moved(&camera, 0.4, 0.9), "size": [80, 60], "mode": "still" })]
        {
            let (still, words) = page.still(&body);
            assert!(words.iter().any(|word| word.starts_with("--lens=")), "{lens}: {words:?}");
            let output = dir.run(&[&words[..], &["--aov=distance=s.npy".into()]].concat());
            assert!(output.code == 0 && dir.get("a-view.png") == still, "{lens}: {words:?}: {}", output.err);
            body["mode"] = json!("move");
            assert_eq!(page.ask("/frame", &body).status, 200, "{lens}");
            if body["size"] == json!([40, 30]) {
                assert!(dir.array("s.npy").0 == distances, "{lens}: {words:?}");
            }
        }
        for pixel in [0, 620, 633, 655, 1199] {
            let mut body = body.clone();
            (body["x"], body["y"]) = (json!(pixel % 40), json!(pixel / 40));
            let picked = page.good("/pick", &body)["id"].as_f64().unwrap_or(-1.0);
            assert_eq!(picked, ids[pixel], "{lens} {pixel}");
        }
        let fitted = page.ask("/fit", &body);
        assert_eq!(fitted.status, 200, "{lens}: {}", String::from_utf8_lossy(&fitted.body));
    }
}
