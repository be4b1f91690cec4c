//! The promise of lists of cameras: each camera of a list gives the picture that the same camera gives alone, whatever
//! form the list has, and `cameras.json` describes the pictures.

use crate::test_dir::{Output, TestDir};
use serde_json::{Value, json};

const ATOMS: &str = "4\n\nC 0 0 0\nO 2 0 0\nN 0 2 0\nH 0 0 2\n";

fn dir() -> TestDir {
    TestDir::new(&[("a.xyz", ATOMS)])
}

fn views(dir: &TestDir, options: &str) -> Output {
    dir.render(&format!("a.xyz --size 40x30 {options}"))
}

/// The distances and ids of a picture of one camera, by its options.
fn alone(dir: &TestDir, camera: &str) -> [Vec<f64>; 2] {
    views(dir, &format!("{camera} --aov distance=t.npy --aov id=i.npy"));
    ["t.npy", "i.npy"].map(|name| dir.array(name).0)
}

/// Right, up and view, perpendicular and as long as the view.
fn axes(view: [f64; 3], up: [f64; 3]) -> [[f64; 3]; 3] {
    let cross =
        |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
    let length = |a: [f64; 3]| a.iter().map(|x| x * x).sum::<f64>().sqrt();
    let scaled = |a: [f64; 3]| a.map(|x| x / length(a) * length(view));
    let right = scaled(cross(view, up));
    [right, scaled(cross(right, view)), view]
}

#[test]
fn every_form_of_a_list_gives_the_pictures_of_its_cameras() {
    let dir = dir();
    let options = ["--eye 9,1,2 --view -9,-1,-2 --up 0,1,0", "--eye 1,9,1 --view -1,-9,-0.5 --up 0,0,1"];
    // 40 / 50 at distance 1 is 0.8: the tangent of half the vertical angle is 0.3.
    let lens = "--vfov 33.398488467987";
    let pictures = options.map(|camera| alone(&dir, &format!("{camera} {lens}")));
    let list = |views: [Value; 2]| Value::from(views.to_vec());
    dir.put(
        "own.json",
        list([
            json!({"eye": [9, 1, 2], "view": [-9, -1, -2], "up": [0, 1, 0]}),
            json!({"eye": [1, 9, 1], "at": [0, 0, 0.5], "up": [0, 0, 1]}),
        ])
        .to_string(),
    );
    dir.put(
        "table.csv",
        "eye_x,eye_y,eye_z,view_x,view_y,view_z,up_x,up_y,up_z,fx,fy,cx,cy\n\
        9,1,2,-9,-1,-2,0,1,0,50,50,20,15\n# a comment\n1,9,1,-1,-9,-0.5,0,0,1,50,50,20,15\n",
    );
    // Columns right, up, back, eye; the common length of the axes does not matter.
    let nerf = |view: [f64; 3], up: [f64; 3], eye: [f64; 3]| {
        let [right, up, view] = axes(view, up);
        let row = |k: usize| json!([right[k], up[k], -view[k], eye[k]]);
        json!({"file_path": "x.png", "transform_matrix": [row(0), row(1), row(2), [0, 0, 0, 1]]})
    };
    let frames = [
        nerf([-9.0, -1.0, -2.0], [0.0, 1.0, 0.0], [9.0, 1.0, 2.0]),
        nerf([-1.0, -9.0, -0.5], [0.0, 0.0, 1.0], [1.0, 9.0, 1.0]),
    ];
    dir.put(
        "transforms.json",
        json!({"fl_x": 50, "fl_y": 50, "cx": 20, "cy": 15, "w": 40, "h": 30, "frames": frames}).to_string(),
    );
    let angle = 2.0 * (0.4_f64).atan();
    dir.put("angle.json", json!({"camera_angle_x": angle, "w": 40, "h": 30, "frames": frames}).to_string());
    // Columns right, down, forward, eye.
    let pose = |view: [f64; 3], up: [f64; 3], eye: [f64; 3]| {
        let [right, up, view] = axes(view, up);
        let row = |k: usize| json!([right[k], -up[k], view[k], eye[k]]);
        json!({"pose": [row(0), row(1), row(2), [0, 0, 0, 1]], "K": [[50, 0, 20], [0, 50, 15], [0, 0, 1]]})
    };
    dir.put(
        "poses.json",
        json!({"poses": [pose([-9.0, -1.0, -2.0], [0.0, 1.0, 0.0], [9.0, 1.0, 2.0]),
        pose([-1.0, -9.0, -0.5], [0.0, 0.0, 1.0], [1.0, 9.0, 1.0])]})
        .to_string(),
    );
    for (file, more) in [
        ("own.json", "--intrinsics 50,50,20,15"),
        ("own.json", lens),
        ("table.csv", ""),
        ("transforms.json", ""),
        ("angle.json", ""),
        ("poses.json", ""),
    ] {
        views(&dir, &format!("--cameras {file} {more} --aov distance=t%d.npy --aov id=i%d.npy"));
        for (n, [distances, ids]) in pictures.iter().enumerate() {
            let found = ["t", "i"].map(|name| dir.array(&format!("{name}{}.npy", n + 1)).0);
            assert_eq!(&found[1], ids, "{file} {more}: ids of camera {n}");
            // The angle of the single pictures has 14 digits, so rays differ by some 1e-13.
            let close = |(a, b): (&f64, &f64)| a == b || (a - b).abs() < 1e-9;
            assert!(found[0].iter().zip(distances).all(close), "{file} {more}: distances of camera {n}");
        }
    }
}

#[test]
fn the_cameras_are_written_next_to_the_pictures_and_can_be_read_again() {
    let dir = dir();
    std::fs::create_dir(dir.path("out")).expect("a folder");
    let cameras: Vec<Value> = (0..5).map(|n| json!({"eye": [9, n, 2], "at": [0, 0, 0], "up": [0, 1, 0]})).collect();
    dir.put("list.json", Value::from(cameras).to_string());
    let reports =
        views(&dir, "--cameras list.json --vfov 30 -o out/c%03d.png --aov depth=out/d%03d.npy --json").json_lines();
    let written: Value = serde_json::from_slice(&dir.get("out/cameras.json")).expect("JSON");
    assert_eq!(reports.len(), 5);
    for (n, (report, camera)) in reports.iter().zip(written["cameras"].as_array().expect("a list")).enumerate() {
        assert_eq!(camera["number"], n as u64 + 1);
        assert_eq!(camera["files"], json!([format!("c{:03}.png", n + 1), format!("d{:03}.npy", n + 1)]));
        for key in ["eye", "view", "up", "viewport", "distance", "intrinsics", "size"] {
            assert_eq!(camera[key], report["camera"][key], "{key} of camera {n}");
        }
    }
    views(&dir, "--cameras out/cameras.json --aov depth=again%03d.npy");
    for n in 1..=5 {
        let bits = |name: String| dir.array(&name).0.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        assert!(bits(format!("again{n:03}.npy")) == bits(format!("out/d{n:03}.npy")), "camera {n}");
    }
}

/// An image of 40 x 30 with the principal point (35, 9.5) shows the last 30 rows and the first 40 columns of one
/// of 70 x 41 with the same focal lengths.
#[test]
fn principal_points_may_lie_off_the_middle() {
    let dir = dir();
    let pose = json!([[1, 0, 0, 0.5], [0, -1, 0, 0.2], [0, 0, -1, 9], [0, 0, 0, 1]]);
    let k = |cx: f64, cy: f64| json!([[50, 0, cx], [0, 50, cy], [0, 0, 1]]);
    dir.put("off.json", json!({"poses": [{"pose": pose, "K": k(35.0, 9.5)}]}).to_string());
    dir.put("bare.json", json!({"poses": [{"pose": pose}]}).to_string());
    dir.put("whole.json", json!({"poses": [{"pose": pose, "K": k(35.0, 20.5)}]}).to_string());
    let arrays = |names: [&str; 2]| names.map(|name| dir.array(name).0);
    views(&dir, "--cameras off.json --aov distance=t%d.npy --aov id=i%d.npy -o p%d.png");
    let whole = "a.xyz --size 70x41 --crop 0,11,40,41 --cameras whole.json --aov distance=wt%d.npy --aov id=wi%d.npy";
    dir.render(whole);
    let found = arrays(["t1.npy", "i1.npy"]);
    let expected = arrays(["wt1.npy", "wi1.npy"]);
    assert!(found[1] == expected[1], "other ids");
    // The viewport of the larger image has rounded numbers: 70/50 and 41/50.
    let close = |(a, b): (&f64, &f64)| a == b || (a - b).abs() < 1e-12;
    assert!(found[0].iter().zip(&expected[0]).all(close), "other distances");
    assert!(found[1].iter().filter(|id| **id >= 0.0).count() > 100, "the atoms are in view");
    views(&dir, "--cameras bare.json --intrinsics 50,50,35,9.5 --aov distance=bt%d.npy --aov id=bi%d.npy");
    assert!(found == arrays(["bt1.npy", "bi1.npy"]));
    // The list beside the picture, and the picture itself, give the camera back.
    let written: Value = serde_json::from_slice(&dir.get("cameras.json")).expect("JSON");
    let intrinsics = json!({"fx": 50.0, "fy": 50.0, "cx": 35.0, "cy": 9.5});
    assert_eq!(written["cameras"][0]["intrinsics"], intrinsics);
    dir.put("again.json", dir.get("cameras.json"));
    dir.render("a.xyz --cameras again.json --aov distance=at%d.npy --aov id=ai%d.npy");
    assert!(found == arrays(["at1.npy", "ai1.npy"]));
    dir.render("a.xyz --camera-from p1.png --aov distance=ct.npy --aov id=ci.npy");
    assert!(found == arrays(["ct.npy", "ci.npy"]));
    // Tiles are parts of the image.
    views(&dir, "--cameras off.json --tile 2/4 --aov distance=q%d.npy");
    let (part, shape) = dir.array("q1.npy");
    let expected: Vec<f64> = (0..15).flat_map(|i| found[0][40 * i + 20..40 * i + 40].to_vec()).collect();
    assert!(shape == [15, 20] && part == expected);
    // A calibrated point is rounded to less than 1/512 of a pixel, which is told.
    let report =
        &views(&dir, "--cameras bare.json --intrinsics 50,49,18.3717,16.2229 -o c%d.png --json").json_lines()[0];
    let point = ["cx", "cy"].map(|key| report["camera"]["intrinsics"][key].as_f64().expect("a number"));
    assert!((point[0] - 18.3717).abs() <= 1.0 / 512.0 && (point[1] - 16.2229).abs() <= 1.0 / 512.0, "{point:?}");
}

/// docs/film.md: the picture gives what a list does not say of the image, and a picture of another size has its view.
#[test]
fn lenses_belong_to_the_image_of_the_list_or_to_the_picture() {
    let dir = dir();
    let matrix = json!([[1, 0, 0, 0.5], [0, 1, 0, 0.2], [0, 0, 1, 9], [0, 0, 0, 1]]);
    let angle = |side: f64| 2.0 * (side / 2.0 / 50.0).atan();
    let ids = |name: &str, list: Value, size: &str| {
        let Value::Object(mut list) = list else { panic!("an object") };
        list.insert("frames".into(), json!([{"transform_matrix": matrix}]));
        dir.put("list.json", Value::Object(list).to_string());
        dir.render(&format!("a.xyz --size {size} --cameras list.json --aov id={name}%d.npy"));
        dir.array(&format!("{name}1.npy")).0
    };
    let expected = ids("i", json!({"fl_x": 50, "fl_y": 50, "cx": 20, "cy": 15, "w": 40, "h": 30}), "40x30");
    assert!(expected.iter().filter(|id| **id >= 0.0).count() > 100, "the atoms are in view");
    let off = ids("o", json!({"fl_x": 50, "cx": 24, "cy": 12}), "40x30");
    assert!(off != expected);
    for (list, picture) in [
        (json!({"camera_angle_x": angle(40.0)}), &expected),
        (json!({"camera_angle_y": angle(30.0)}), &expected),
        (json!({"camera_angle_x": angle(40.0), "camera_angle_y": angle(30.0)}), &expected),
        (json!({"fl_x": 50}), &expected),
        (json!({"fy": 50}), &expected),
        (json!({"fl_x": 50, "k1": 0, "p1": 0.0, "camera_model": "OPENCV", "distortion_params": [0, 0]}), &expected),
        (json!({"camera_angle_x": angle(40.0), "w": 400, "h": 300}), &expected),
        (json!({"fl_x": 500, "width": 400, "height": 300}), &expected),
        (json!({"fl_x": 500, "cx": 240, "cy": 120, "w": 400, "h": 300}), &off),
        (json!({"K": [[25, 0, 12], [0, 25, 6], [0, 0, 1]], "w": 20, "h": 15}), &off),
        (json!({"intrinsics": {"fx": 50, "cx": 24, "cy": 12}}), &off),
    ] {
        let text = list.to_string();
        assert!(&ids("f", list, "40x30") == picture, "{text}");
    }
    // The list that is written has the size of the pictures.
    dir.put("own.json", json!([{"eye": [9, 1, 2], "at": [0, 0, 0], "up": [0, 1, 0]}]).to_string());
    let angle = |size: &str, name: &str| {
        dir.render(&format!("a.xyz --size {size} --cameras own.json --vfov 30 --aov id={name}%d.npy"));
    };
    angle("400x300", "s");
    dir.put("written.json", dir.get("cameras.json"));
    for size in ["40x30", "30x30", "60x30"] {
        angle(size, "v");
        dir.render(&format!("a.xyz --size {size} --cameras written.json --aov id=w%d.npy"));
        assert!(dir.array("w1.npy") == dir.array("v1.npy"), "{size}");
    }
    for (key, value, words) in [
        ("k1", json!("x"), "k1: expected a finite number"),
        ("k4", json!(-1e-9), "FULL_OPENCV"),
        ("distortion_params", json!([0, 0, 0, 0.5]), "r^8"),
        ("dist", json!([0, 0, 0, 0, 0, 0, 0, 0, 0.5]), "more than 8"),
        ("camera_model", json!("FOV"), "the lens has the model"),
        ("cx", json!(20), "cy: missing beside cx"),
        ("h", json!(20), "w: missing beside h"),
    ] {
        for inside in [false, true] {
            let mut list = json!({"fl_x": 50, "frames": [{"transform_matrix": matrix}]});
            let target = if inside { &mut list["frames"][0] } else { &mut list };
            target[key] = value.clone();
            if inside {
                target["fl_x"] = json!(50);
            }
            dir.put("list.json", list.to_string());
            dir.refused_render(3, "a.xyz --size 40x30 --cameras list.json -o a%d.png", &["list.json", words]);
        }
    }
}

/// The place of a point in the image of a lens at the origin of OpenCV's axes, by the formulas of its documentation; coefficients k1, k2,
/// p1, p2, k3.
fn projected(k: [f64; 5], is_fisheye: bool, point: [f64; 3]) -> [f64; 2] {
    let (x, y) = (point[0] / point[2], point[1] / point[2]);
    let r2 = x * x + y * y;
    let [x, y] = if is_fisheye {
        let theta = r2.sqrt().atan();
        let scale = (theta + k[0] * theta.powi(3) + k[1] * theta.powi(5)) / r2.sqrt();
        [x * scale, y * scale]
    } else {
        let radial = 1.0 + k[0] * r2 + k[1] * r2 * r2 + k[4] * r2.powi(3);
        [
            x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x),
            y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y,
        ]
    };
    [30.0 * x + 21.0, 31.0 * y + 14.5]
}

/// docs/film.md: the hit of each pixel is projected to the pixel's centre by the model of the lens.
#[test]
fn curved_lenses_have_the_rays_of_their_models() {
    let dir =
        TestDir::new(&[("a.csv", "x,y,z,radius\n0,0,40,12\n30,5,45,9\n-25,-20,50,11\n-30,30,60,14\n20,-28,44,8\n")]);
    // A camera at the origin that looks along z, with OpenCV's axes.
    let pose = json!([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]);
    let camera = |lens: Value| {
        let mut camera = json!({"pose": pose, "fx": 30, "fy": 31, "cx": 21, "cy": 14.5});
        lens.as_object().expect("an object").iter().for_each(|(key, value)| camera[key] = value.clone());
        dir.put("list.json", json!([camera]).to_string());
    };
    let buffers = "--aov position=p%d.npy --aov id=i%d.npy --aov depth=z%d.npy --aov distance=d%d.npy";
    for (lens, k, is_fisheye) in [
        (
            json!({"k1": -0.2, "k2": 0.04, "p1": 0.003, "p2": -0.002, "k3": 0.001}),
            [-0.2, 0.04, 0.003, -0.002, 0.001],
            false,
        ),
        (json!({"dist": [-0.2, 0.04, 0.003, -0.002, 0.001]}), [-0.2, 0.04, 0.003, -0.002, 0.001], false),
        (
            json!({"distortion_params": [-0.2, 0.04, 0.001, 0, 0.003, -0.002]}),
            [-0.2, 0.04, 0.003, -0.002, 0.001],
            false,
        ),
        (json!({"camera_model": "OPENCV_FISHEYE", "k1": 0.05, "k2": -0.01}), [0.05, -0.01, 0.0, 0.0, 0.0], true),
        (json!({"is_fisheye": true, "D": [0.05, -0.01, 0, 0]}), [0.05, -0.01, 0.0, 0.0, 0.0], true),
    ] {
        camera(lens.clone());
        dir.render(&format!("a.csv --size 40x30 --look plain --cameras list.json {buffers} -o c%d.png"));
        let [positions, ids, depths, distances] =
            ["p1.npy", "i1.npy", "z1.npy", "d1.npy"].map(|name| dir.array(name).0);
        let mut hits = 0;
        for pixel in (0..1200).filter(|pixel| ids[*pixel] >= 0.0) {
            let point = [0, 1, 2].map(|axis| positions[3 * pixel + axis]);
            let expected = [(pixel % 40) as f64 + 0.5, (pixel / 40) as f64 + 0.5];
            let found = projected(k, is_fisheye, point);
            // The distance is within 1e-5 of itself along the ray, which does not move the place; the rest is rounding.
            let apart = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(apart < 1e-9, "{lens} pixel {pixel}: {found:?} for {expected:?}");
            assert!((depths[pixel] - point[2]).abs() < 1e-9 && distances[pixel] > depths[pixel] * (1.0 - 1e-15));
            hits += 1;
        }
        assert!(hits > 300, "{lens}: {hits} hits");
        // The picture has the camera, for another render and for the list that is written.
        dir.put("again.json", dir.get("cameras.json"));
        dir.render("a.csv --cameras again.json --aov distance=e%d.npy");
        dir.render("a.csv --camera-from c1.png --aov distance=f.npy");
        dir.render("a.csv --cameras again.json --crop 10,5,30,25 --aov distance=g%d.npy");
        assert!(dir.array("e1.npy").0 == distances && dir.array("f.npy").0 == distances, "{lens}");
        let part: Vec<f64> = (5..25).flat_map(|row| distances[40 * row + 10..40 * row + 30].to_vec()).collect();
        assert!(dir.array("g1.npy").0 == part, "{lens}");
    }
    let output = dir.render("a.csv --size 40x30 --cameras list.json -o a%d.glb");
    assert!(output.err.contains("a1.glb has no camera"), "{}", output.err);
    let mend = "a.csv --size 40x30 --cameras list.json -o a%d.png";
    for (code, options, words) in [
        (2, "--aperture 0.1 --focus-distance 9 --samples 4", &["lens with a size", "remove --aperture"]),
        (3, "--scale-bar", &["--scale-bar needs the viewport", "remove --scale-bar"]),
    ] {
        dir.refused_render(code, &format!("{mend} {options}"), words);
    }
    let pixels = |options: &str| {
        dir.render(&format!("a.csv --size 40x30 --cameras list.json --aov color=k%d.npy {options}"));
        dir.array("k1.npy").0
    };
    let plain = pixels("--look plain");
    for options in [
        "--look soft",
        "--look figure",
        "--look plain --silhouette",
        "--look plain --depth-cue",
        "--look plain --opacity 0.5",
        "--look plain --shadows",
        "--look plain --sun 1,2,3",
        "--look plain --occlusion",
        "--look plain --material metal",
        "--look plain --material glass",
    ] {
        assert!(pixels(options) != plain, "{options} has an effect");
    }
    dir.render(
        "a.csv --size 40x30 --cameras list.json --aov occlusion=o%d.npy --aov bound=b%d.npy --aov distance=q%d.npy",
    );
    let [bounds, distances] = ["b1.npy", "q1.npy"].map(|name| dir.array(name).0);
    let pairs = || bounds.iter().zip(&distances).filter(|(_, distance)| distance.is_finite());
    assert!(pairs().count() > 300 && pairs().all(|(bound, distance)| *bound > 0.0 && *bound <= 1.01e-5 * distance));
    // Metal whose rays do not go on is matte for every camera, and buffers have no materials.
    dir.render(&format!("{mend} --look plain --material metal --bounces 0"));
    dir.render("a.csv --size 40x30 --cameras list.json --aov id=m%d.npy --material metal --opacity 0.5");
    assert!(dir.array("m1.npy").0 == dir.array("i1.npy").0);
    dir.put("from.png", dir.get("c1.png"));
    let stream = "render a.csv --backend cpu --camera-from from.png --stream --aov id=s.npy";
    let refused = dir.run(stream);
    assert!(refused.code == 2 && refused.err.contains("or remove --stream"), "{}", refused.err);
    let page = dir.run("view a.csv --backend cpu --camera-from from.png --no-open --idle 1 --port 0");
    assert!(page.code == 0 || page.err.contains("--camera-from"), "{} {}", page.code, page.err);
}

/// A panorama has all directions: what is ahead in the middle, what is right in the right half, what is behind at the sides.
#[test]
fn a_panorama_sees_all_around() {
    let rows = "x,y,z,radius\n0,0,9,1\n9,0,0,1\n0,0,-9,1\n-9,0,0,1\n0,-9,0,1\n";
    let dir = TestDir::new(&[("a.csv", rows)]);
    let pose = json!([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]);
    dir.put("list.json", json!([{"pose": pose, "camera_model": "EQUIRECTANGULAR"}]).to_string());
    dir.render("a.csv --size 72x36 --look plain --cameras list.json --aov id=i%d.npy --aov alpha=a%d.npy --samples 4 -o c%d.png");
    let ids = dir.array("i1.npy").0;
    let at = |column: usize, row: usize| ids[72 * row + column];
    // Ahead, right, behind at either side, left; OpenCV's y is down, so -9 is above.
    assert_eq!([at(36, 18), at(54, 18), at(0, 18), at(71, 18), at(18, 18), at(5, 0)], [0.0, 1.0, 2.0, 2.0, 3.0, 4.0]);
    let alpha: f64 = dir.array("a1.npy").0.iter().sum();
    // Pixels of 5 degrees: a cap around the pole, and four circles at the equator, where pixels are as wide as high to cos 6.4 degrees.
    let radius = (1.0_f64 / 9.0).asin().to_degrees() / 5.0;
    let expected = 72.0 * radius + 4.0 * std::f64::consts::PI * radius * radius;
    assert!(
        (alpha - expected).abs() < 0.03 * expected,
        "{alpha} for {expected}: four samples a pixel see outlines to a quarter"
    );
}

#[test]
fn a_list_moves_through_the_frames_of_a_film() {
    let dir = dir();
    dir.put("two.xyz", format!("{ATOMS}{}", ATOMS.replace("H 0 0 2", "H 0 0 3")));
    let camera = |x: f64| json!({"eye": [x, 0, 20], "view": [0, 0, -1], "up": [0, 1, 0], "vfov": 30});
    dir.put("list.json", Value::from(vec![camera(0.0), camera(3.0)]).to_string());
    let reports = dir.render("two.xyz --size 40x30 --cameras list.json --frames 1-2 -o f%d.png --json").json_lines();
    assert_eq!([&reports[0]["camera"]["eye"][0], &reports[1]["camera"]["eye"][0]], [&json!(0.0), &json!(3.0)]);
    dir.put("one.json", Value::from(vec![camera(0.0)]).to_string());
    let more = dir.run("render two.xyz --backend cpu --size 40x30 --cameras one.json --frames 1-2 -o g%d.png");
    assert!(more.code == 2 && more.err.contains("frame 2 has no camera: the list has 1"), "{}", more.err);
}

#[test]
fn invalid_lists_are_refused_with_the_camera_and_the_field() {
    let dir = dir();
    for (text, words) in [
        ("[]", &["list.json", "no cameras"][..]),
        ("{}", &["no list of cameras"]),
        ("[{\"eye\": [1, 2]}]", &["camera 0 eye: expected finite numbers"]),
        ("[{\"eye\": [1, 2, 3], \"view\": [0, 0, 1]}]", &["camera 0 up: missing"]),
        ("[{\"transform_matrix\": [[1, 0, 0, 0]]}]", &["camera 0 transform_matrix", "4 x 4"]),
        ("[{\"eye\": [1, 2, 3],", &["list.json:1:"]),
        ("eye_x,eye_y\n1,2\n", &["camera 0 eye_z", "missing"]),
        ("eye_x,nose\n1,2\n", &["list.json:1:7: header", "unknown column `nose`"]),
        ("eye_x,EYE_X\n1,2\n", &["list.json:1:7: header", "`EYE_X` occurs twice"]),
        ("eye_x,eye_y\n1\n", &["list.json:2:2: eye_y", "expected 2 numbers, found 1"]),
        ("eye_x,eye_y\n1,2,3\n", &["list.json:2:5: row", "more than the 2 numbers"]),
        ("eye_x,view_x,at_y\n1,2,3\n", &["list.json:1:1: header", "`view_x` and `at_y` exclude each other"]),
        ("vfov,cx\n1,2\n", &["list.json:1:1: header", "`vfov` and `cx` exclude each other"]),
        (
            "eye_x,eye_y,eye_z,view_x,view_y,view_z,up_x,up_y,up_z,cx,cy\n0,0,9,0,0,-1,0,1,0,20,15\n",
            &["camera 0 fx", "missing"],
        ),
        ("eye_x,eye_y,eye_z\n1,a,3\n", &["list.json:2:3: eye_y"]),
    ] {
        dir.put("list.json", text);
        dir.refused_render(3, "a.xyz --cameras list.json -o a%d.png", words);
    }
    dir.put("list.json", "[{\"eye\": [9, 0, 0], \"view\": [-1, 0, 0], \"up\": [0, 1, 0]}, {\"eye\": [9, 1, 0], \"view\": [-1, 0, 0], \"up\": [0, 1, 0]}]");
    for (options, words) in [
        ("--cameras list.json -o a%d.png", &["camera 0 has no lens", "--intrinsics"][..]),
        ("--cameras list.json -o a.png --vfov 30", &["a.%04d.png"]),
        ("--cameras list.json -o a%d.png --size 40x30 --intrinsics 50,50,1e7,15", &["principal point is 10000000"]),
        ("--cameras list.json -o a%d.png --intrinsics 0,50,256,256", &["not positive"]),
        ("--cameras list.json -o a%d.png --intrinsics 1e-320,50,256,256", &["1e-320, 50.0", "525"]),
        ("--cameras list.json -o a%d.png --intrinsics 50,1e-320,256,200", &["fy is 1e-320", "525"]),
        ("--cameras list.json -o a%d.png --intrinsics 1e-320,1e10,256,200", &["fx is 1e-320", "525"]),
        ("--cameras list.json -o a%d.png --intrinsics 50", &["four finite numbers"]),
        ("-o a.png --intrinsics 50,50,20,15", &["--cameras"]),
        ("--cameras list.json -o a%d.png --eye 0,0,9", &["--eye"]),
    ] {
        dir.refused_render(2, &format!("a.xyz {options}"), words);
    }
    dir.refused_render(8, "a.xyz --cameras none.json -o a%d.png", &["none.json"]);
    dir.put("cameras.json", dir.get("list.json"));
    dir.refused_render(2, "a.xyz --cameras cameras.json -o a%d.png --vfov 30", &["cameras.json"]);
}

#[test]
fn matrices_that_are_no_rotations_are_refused() {
    let dir = dir();
    let good = json!([[1, 0, 0, 0.5], [0, -1, 0, 0.2], [0, 0, -1, 9], [0, 0, 0, 1]]);
    for (key, row, words) in [
        ("pose", json!([-1, 0, 0, 0.5]), "mirrored"),
        ("transform_matrix", json!([2, 0, 0, 0.5]), "lengths 2, 1, 1"),
        ("camera_to_world", json!([1, 0.01, 0, 0.5]), "columns 0 and 1"),
    ] {
        let mut bad = good.clone();
        bad[0] = row;
        dir.put("bad.json", json!({"poses": [{"pose": good}, {key: bad}]}).to_string());
        let words = ["bad.json", &format!("camera 1 {key}"), words];
        dir.refused_render(3, "a.xyz --size 40x30 --vfov 30 --cameras bad.json -o b%d.png", &words);
    }
}
