//! The promise of `-o FILE.glb`: a binary glTF 2.0 that has each sphere as it is styled, near the middle of the scene, and the camera of
//! the picture.

use crate::test_dir::TestDir;
use serde_json::{Value, json};

/// Rows of x, y, z, radius and a colour in sRGB, far from the origin; coordinates in eighths are exact.
const ROWS: &str = "x,y,z,radius,red,green,blue\n\
    1000000.125,2000000.5,-3000000.25,0.5,255,0,0\n\
    1000003.375,2000001.25,-3000001.5,0.1,0,255,0\n\
    999999.5,1999997.0,-2999998.75,2,0,0,255\n\
    1000000.0,2000000.0,-3000000.0,1,255,255,255\n";

/// The JSON of a file and the float32 numbers of its accessors, by the specification.
fn parsed(bytes: &[u8]) -> (Value, Vec<Vec<f32>>) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let json = word(12);
    assert_eq!((&bytes[16..20], json % 4), (&b"JSON"[..], 0));
    let document: Value = serde_json::from_slice(&bytes[20..20 + json]).expect("JSON");
    let start = 28 + json;
    if start > bytes.len() {
        assert_eq!(20 + json, bytes.len(), "no other chunk");
        return (document, Vec::new());
    }
    assert_eq!((word(20 + json), &bytes[24 + json..start]), (bytes.len() - start, &b"BIN\0"[..]));
    assert_eq!(document["buffers"], json!([{"byteLength": bytes.len() - start}]));
    let number = |value: &Value| value.as_u64().expect("a whole number") as usize;
    let numbers = |accessor: &Value| {
        let view = &document["bufferViews"][number(&accessor["bufferView"])];
        let (from, size) = (number(&view["byteOffset"]), number(&view["byteLength"]));
        let each =
            ["SCALAR", "", "VEC3", "VEC4"].iter().position(|kind| accessor["type"] == *kind).expect("a type") + 1;
        assert_eq!((&accessor["componentType"], size), (&json!(5126), 4 * each * number(&accessor["count"])));
        let words = bytes[start + from..start + from + size].as_chunks::<4>().0.iter();
        words.map(|word| f32::from_le_bytes(*word)).collect()
    };
    let all = document["accessors"].as_array().expect("a list").iter().map(numbers).collect();
    (document, all)
}

fn model(dir: &TestDir, words: &str) -> (Value, Vec<Vec<f32>>) {
    dir.render(&format!("{words} -o a.glb"));
    parsed(&dir.get("a.glb"))
}

/// The node of this name.
fn node<'a>(document: &'a Value, name: &str) -> Option<&'a Value> {
    document["nodes"].as_array().expect("a list").iter().find(|node| node["name"] == name)
}

#[test]
fn every_sphere_is_a_point_with_its_radius_and_its_colour() {
    let dir = TestDir::new(&[("p.csv", ROWS)]);
    let (document, numbers) = model(&dir, "p.csv");
    let primitive = json!({"mode": 0, "attributes": {"POSITION": 0, "_RADIUS": 1, "COLOR_0": 2}, "material": 0});
    assert_eq!(document["meshes"][0]["primitives"], json!([primitive]));
    assert_eq!((&document["asset"]["version"], &document["scenes"][0]["nodes"]), (&json!("2.0"), &json!([0, 1])));
    let [positions, radii, colors] = &numbers[..] else { panic!("three accessors") };
    let middle = node(&document, "spheres").expect("a node")["translation"].as_array().expect("a vector").clone();
    let rows: Vec<Vec<f64>> =
        ROWS.lines().skip(1).map(|row| row.split(',').map(|x| x.parse().expect("a number")).collect()).collect();
    for (n, row) in rows.iter().enumerate() {
        for k in 0..3 {
            // Differences of eighths below 2^24 / 8 are exact in float32.
            assert_eq!(middle[k].as_f64().expect("a number") + f64::from(positions[3 * n + k]), row[k], "row {n}");
            // 0 and 255 are 0 and 1 in linear light too.
            assert_eq!(f64::from(colors[3 * n + k]), row[4 + k] / 255.0, "row {n}");
        }
        assert_eq!(radii[n], row[3] as f32, "row {n}");
    }
    for (field, pick) in [("min", f32::min as fn(f32, f32) -> f32), ("max", f32::max)] {
        let ends =
            [0, 1, 2].map(|k| f64::from(positions.iter().skip(k).step_by(3).copied().reduce(pick).expect("some")));
        assert_eq!(document["accessors"][0][field], json!(ends), "{field}");
    }
    // What is not drawn is not there, and what is translucent has an alpha.
    let (document, numbers) = model(&dir, "p.csv --hide radius>1 --opacity radius<0.2=0.25 --radius-scale 2");
    assert_eq!((numbers[1].clone(), &document["materials"][0]["alphaMode"]), (vec![1.0, 0.2, 2.0], &json!("BLEND")));
    assert_eq!(numbers[2].iter().skip(3).step_by(4).collect::<Vec<_>>(), [&1.0, &0.25, &1.0]);
}

#[test]
fn the_camera_is_that_of_the_picture() {
    let dir = TestDir::new(&[("p.csv", ROWS)]);
    let about = "p.csv --size 30x20 --eye 1000000,2000000,-2999990 --view 0,-0.6,-0.8 --up 0,1,0";
    let (document, _) = model(&dir, &format!("{about} --vfov 90"));
    let matrix = node(&document, "camera").expect("a camera")["matrix"].as_array().expect("numbers").clone();
    // Right, up and back of the view, and the eye; 0.6, 0.8 and 1 are sides of a triangle, so a few ulps at most.
    let expected = [1.0, 0.0, 0.0, 0.0, 0.0, 0.8, -0.6, 0.0, 0.0, 0.6, 0.8, 0.0, 1e6, 2e6, -2_999_990.0, 1.0];
    for (found, expected) in matrix.iter().zip(expected) {
        assert!((found.as_f64().expect("a number") - expected).abs() < 1e-15, "{matrix:?}");
    }
    let lens = &document["cameras"][0];
    let angle = lens["perspective"]["yfov"].as_f64().expect("an angle");
    // The tangent of half the angle is rounded once.
    assert!(lens["type"] == "perspective" && (angle - std::f64::consts::FRAC_PI_2).abs() < 1e-15, "{lens}");
    assert_eq!(lens["perspective"]["aspectRatio"], json!(1.5));
    let [near, far] = ["znear", "zfar"].map(|plane| lens["perspective"][plane].as_f64().expect("a length"));
    // The nearest sphere begins at 6.8, and the farthest ends at 10.8.
    assert!(0.0 < near && near < 6.8 && far > 10.8, "{near} to {far}");
    let (document, _) = model(&dir, &format!("{about} --ortho 8"));
    let lens = &document["cameras"][0]["orthographic"];
    assert_eq!((&lens["xmag"], &lens["ymag"], &lens["znear"]), (&json!(6.0), &json!(4.0), &json!(0.0)));
    // A principal point beside the middle.
    let pose = json!([[1, 0, 0, 1e6], [0, 1, 0, 2e6], [0, 0, 1, -2_999_990], [0, 0, 0, 1]]);
    dir.put("list.json", json!({"poses": [{"pose": pose}]}).to_string());
    let output = dir.render("p.csv --cameras list.json --intrinsics 20,20,7,10 --size 30x20 -o b%d.glb");
    assert!(output.err.contains("b1.glb has no camera"), "{}", output.err);
    assert!(node(&parsed(&dir.get("b1.glb")).0, "camera").is_none());
}

#[test]
fn each_frame_of_a_sequence_has_a_model() {
    let dir = TestDir::new(&[("p.csv", ROWS), ("t.xyz", "1\n\nC 0 0 0\n1\n\nO 1 2 3\n")]);
    let output = dir.render("p.csv -o a.glb --json");
    assert!(!output.err.contains("rendering on"), "nothing is rendered: {}", output.err);
    assert_eq!(output.json()["spheres"], json!(4));
    dir.render("p.csv -o b.glb --size 8x4 --aov id=id.npy");
    assert!(dir.get("a.glb") != dir.get("b.glb"), "another aspect");
    assert_eq!(dir.array("id.npy").1, [4, 8]);
    dir.render("t.xyz --frames 1-2 -o f%d.glb");
    let at = |name: &str| node(&parsed(&dir.get(name)).0, "spheres").expect("a node")["translation"].clone();
    assert_eq!((at("f1.glb"), at("f2.glb")), (json!([0.0, 0.0, 0.0]), json!([1.0, 2.0, 3.0])));
    // Clip planes may leave nothing.
    let (document, numbers) = model(&dir, "p.csv --clip 1,0,0,5 --size 4x4 --eye 0,0,9 --at 0,0,0");
    assert!(numbers.is_empty() && document.get("meshes").is_none() && node(&document, "camera").is_some());
}

#[test]
fn what_a_model_cannot_hold_is_refused() {
    let dir = TestDir::new(&[
        ("p.csv", ROWS),
        ("far.csv", "x,y,z,radius\n0,0,0,1\n1e60,0,0,1\n"),
        ("t.xyz", "1\n\nC 0 0 0\n1\n\nO 1 2 3\n"),
    ]);
    for (code, words, mend) in [
        (2, "p.csv -o a.glb --stream", "a model has all spheres"),
        (2, "p.csv -o a.glb --aov depth", "has no file"),
        (2, "p.csv -o a.glb --cryptomatte id", "-o FILE.exr"),
        (2, "p.csv -o a.glb --label text", "-o with the file name extension .png"),
        (2, "t.xyz --frames 1-2 -o a.glb", "a.%04d.glb"),
        (3, "far.csv -o a.glb --eye 0,0,9 --at 0,0,0", "sphere 0 is beyond the range of float32"),
        (8, "p.csv -o none/a.glb", "none"),
        (2, "--visible part.npz -o a.glb", "a model has"),
    ] {
        dir.refused_render(code, words, &[mend]);
    }
    dir.put("same.glb", ROWS);
    dir.refused_render(2, "same.glb --format csv -o same.glb", &["is an input"]);
}
