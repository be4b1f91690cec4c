//! Promises of docs/film.md for the keys of lenses: each is the camera's, else the list's; what is not known is refused by name.

use super::{ListedCamera, of_bytes};
use halfline::scene::camera::{Curve, Lens};
use serde_json::{Map, Value, json};

/// Numbers that look random, by a linear congruential generator (Knuth).
struct Draw(u64);

impl Draw {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) % n as u64) as usize
    }

    fn coin(&mut self) -> bool {
        self.below(2) == 0
    }

    fn unit(&mut self) -> f64 {
        self.below(1 << 20) as f64 / f64::from(1 << 20)
    }
}

type Keys = Map<String, Value>;

/// The camera of a list with these keys for all, and one camera with those.
fn read(list: &Keys, camera: &Keys) -> Result<ListedCamera, String> {
    let mut one = json!({"transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5], [0, 0, 0, 1]]});
    one.as_object_mut().expect("an object").extend(camera.clone());
    let mut all = list.clone();
    all.insert("frames".into(), json!([one]));
    let text = Value::Object(all).to_string();
    of_bytes(text.as_bytes(), "list.json").map(|cameras| cameras[0]).map_err(|error| error.to_string())
}

fn keys(value: Value) -> Keys {
    let Value::Object(keys) = value else { panic!("an object") };
    keys
}

/// Keys of a lens that agree, under names of several programs.
fn drawn(draw: &mut Draw) -> Keys {
    let mut keys = Keys::new();
    let mut put = |key: &str, value: Value| drop(keys.insert(key.to_owned(), value));
    // Without a size the pixels are the picture's.
    let has_size = draw.coin();
    let (w, h) = if has_size { (32 + 2 * draw.below(40) as u32, 24 + 2 * draw.below(40) as u32) } else { (64, 48) };
    let focal = [40.0 + 30.0 * draw.unit(), 40.0 + 30.0 * draw.unit()];
    let centered = draw.below(3) == 0;
    let center = if centered { [w / 2, h / 2].map(f64::from) } else { [30.5 * draw.unit(), 20.0 * draw.unit()] };
    let [fx, fy, cx, cy] = [focal[0], focal[1], center[0], center[1]];
    if has_size {
        put(["w", "width", "image_width"][draw.below(3)], json!(w));
        put(["h", "height"][draw.below(2)], json!(h));
    }
    if has_size && draw.below(3) == 0 {
        put("size", json!([w, h]));
    }
    let mut is_given = false;
    if draw.coin() {
        put(["fl_x", "fx"][draw.below(2)], json!(fx));
        put(["fl_y", "fy"][draw.below(2)], json!(fy));
        is_given = true;
    }
    if draw.below(3) == 0 {
        put("camera_angle_x", json!(2.0 * (f64::from(w) / 2.0 / fx).atan()));
        is_given = true;
    }
    if !is_given || draw.below(3) == 0 {
        put("K", json!([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]));
    }
    if draw.coin() {
        put("cx", json!(cx));
        put("cy", json!(cy));
    }
    if draw.below(5) == 0 {
        put("intrinsics", json!({"fx": fx, "fy": fy, "cx": cx, "cy": cy}));
    }
    let is_fisheye = draw.below(3) == 0;
    if is_fisheye {
        put(["camera_model", "model", "distortion_model"][draw.below(3)], json!("OPENCV_FISHEYE"));
    } else if draw.coin() {
        put("camera_model", json!("OPENCV"));
    }
    if draw.below(4) == 0 {
        put("is_fisheye", [json!(is_fisheye), json!(is_fisheye.to_string())][draw.below(2)].clone());
    }
    let k = [0, 1, 2].map(|_| if draw.coin() { 0.1 * draw.unit() } else { 0.0 });
    for (n, k) in k.iter().enumerate() {
        if draw.coin() {
            put(&format!("k{}", n + 1), json!(k));
        }
    }
    match (draw.below(4), is_fisheye) {
        (0, true) => put("D", json!([k[0], k[1], k[2], 0])),
        (0, false) => put("dist_coeffs", json!([k[0], k[1], 0, 0, k[2]])),
        (1, _) => put("distortion_params", json!([k[0], k[1], k[2], 0, 0, 0])),
        _ => {}
    }
    keys
}

#[test]
fn keys_may_stand_with_the_camera_or_with_its_list() {
    let draw = &mut Draw(7);
    let (mut curved, mut off) = (0, 0);
    for n in 0..4000 {
        let all = drawn(draw);
        let expected = read(&Keys::new(), &all).unwrap_or_else(|error| panic!("{all:?}: {error}"));
        let Some(lens) = expected.lens(None, None) else { panic!("{all:?}") };
        let made = lens.for_image(0, 64, 48).unwrap_or_else(|error| panic!("{all:?}: {error}"));
        curved += u32::from(made.is_curved());
        off += u32::from(matches!(made, Lens::Intrinsics { .. }));
        let (mut list, mut camera) = (Keys::new(), Keys::new());
        for (key, value) in &all {
            if draw.coin() {
                camera.insert(key.clone(), value.clone());
                // What the camera has itself is not taken from the list.
                if draw.below(3) == 0 {
                    list.insert(key.clone(), [json!(3), json!("x"), Value::Null][draw.below(3)].clone());
                }
            } else {
                list.insert(key.clone(), value.clone());
                // Nothing is no value.
                if draw.below(4) == 0 {
                    camera.insert(key.clone(), Value::Null);
                }
            }
        }
        let found = read(&list, &camera).unwrap_or_else(|error| panic!("{n}: {list:?} {camera:?}: {error}"));
        // A number that several keys give is taken from the first of them in the order of the file.
        let found = found.lens(None, None).expect("a lens").for_image(0, 64, 48).expect("a lens");
        assert!(near(found, made), "{n}: {list:?} {camera:?}: {found:?} for {made:?}");
        assert_eq!(read(&all, &Keys::new()), Ok(expected), "{all:?}");
    }
    assert!(curved > 1000 && off > 300, "{curved} {off}");
}

/// Whether two lenses are one, but for roundings of angles.
fn near(a: Lens, b: Lens) -> bool {
    let numbers = |lens: Lens| match lens {
        Lens::Curved { fx, fy, cx, cy, .. } | Lens::Intrinsics { fx, fy, cx, cy } => [fx, fy, cx, cy],
        Lens::Viewport { vw, vh, distance } => [vw, vh, distance, 1.0],
        other => panic!("{other:?}"),
    };
    let curve = |lens| if let Lens::Curved { curve, .. } = lens { Some(curve) } else { None };
    let is_same = |(x, y): (f64, f64)| (x - y).abs() <= 1e-9 * x.abs().max(1.0);
    curve(a) == curve(b) && numbers(a).into_iter().zip(numbers(b)).all(is_same)
}

#[test]
fn what_is_not_modelled_is_refused_by_name() {
    let base = keys(json!({"fl_x": 60, "fl_y": 60, "cx": 20, "cy": 10, "w": 64, "h": 48}));
    let bent = {
        let mut bent = base.clone();
        bent.insert("k1".into(), json!(0.05));
        bent
    };
    let wrong = [
        ("s1", json!(0.05)),
        ("s4", json!(-1e-9)),
        ("tauX", json!(0.1)),
        ("tau_y", json!(0.1)),
        ("k7", json!(0.1)),
        ("xi", json!(1.2)),
        ("alpha", json!(0.5)),
        ("omega", json!(0.9)),
        ("skew", json!(2)),
        ("ppx", json!(21)),
        ("lens", json!({"s1": 0.1})),
        ("camera", json!("double_sphere")),
        ("radial_distortion", json!([0.1, 0.2])),
        ("c_x", json!(0.01)),
        ("b1", json!("0.1")),
        ("ftheta_p1", json!(0.001)),
        ("latlong", json!(true)),
        ("orthographic", json!(true)),
        ("fisheye_crop_radius", json!(700.0)),
        ("rolling_shutter", json!([0, 0, 1])),
        ("roi", json!({"x_offset": 3, "width": 0})),
        ("R", json!([[0, -1, 0], [1, 0, 0], [0, 0, 1]])),
        ("projection", json!("stereographic")),
        ("projection_type", json!("dual")),
        ("camera_model", json!("THIN_PRISM_FISHEYE")),
        ("camera_model", json!(3)),
        ("model", json!("FOV")),
        ("model", json!("rad_tan_thin_prism_fisheye")),
        ("camera_type", json!("omnidirectional")),
        ("distortion_model", json!("mei")),
        ("distortion", json!("0.1 0.2")),
        ("distortion", json!(0.2)),
        ("distortion", json!([0.3])),
        ("distortion", json!({"k1": 0.3})),
        ("distortion", json!({"s1": 0.3})),
        ("D", json!([0, 0, 0, 0, 0, 0, 0, 0, 0.1])),
        ("dist", json!([0.05, 0, 0, 0, 0.01, 0.02])),
        ("distortion_params", json!([0.05, 0, 0, 0.5])),
        ("is_fisheye", json!("perhaps")),
        ("params", json!([60, 60, 20, 10])),
        ("fx", json!(50)),
        ("camera_angle_x", json!(0.3)),
        ("K", json!([[60, 0, 21], [0, 60, 10], [0, 0, 1]])),
        ("K", json!([[60, 1, 20], [0, 60, 10], [0, 0, 1]])),
        ("P", json!([70, 0, 20, 0, 0, 60, 10, 0, 0, 0, 1, 0])),
        ("width", json!(65)),
        ("size", json!([64, 40])),
        ("vfov", json!(10)),
        ("viewport", json!([1.0, 1.0])),
        ("k4", json!(0.1)),
    ];
    for (key, value) in wrong {
        let of_k1 = matches!(value, Value::Array(_) | Value::Object(_)) && key.starts_with("dist");
        for (keys, has_k1) in [(&base, false), (&bent, true)] {
            for in_list in [false, true] {
                // A list of coefficients contradicts a coefficient.
                if of_k1
                    && !has_k1
                    && !value.to_string().contains("s1")
                    && !["dist", "D", "distortion_params"].contains(&key)
                {
                    continue;
                }
                let mut one = keys.clone();
                one.insert(key.to_owned(), value.clone());
                let found = if in_list {
                    let mut list = one.clone();
                    let camera: Keys = [("cx".to_owned(), json!(20))].into_iter().collect();
                    list.remove("cx");
                    read(&list, &camera)
                } else {
                    read(&Keys::new(), &one)
                };
                let error = found.expect_err(key);
                let is_named =
                    error.contains(key) || value.as_object().is_some_and(|o| o.keys().any(|k| error.contains(k)));
                assert!(is_named && error.contains("list.json"), "{key} {value}: {error}");
                assert!(error.contains(';'), "{key}: a mend: {error}");
            }
        }
    }
    // What leaves a part out is no part, and what is no key of a lens has nothing to do with the picture.
    let plain = read(&Keys::new(), &bent).expect("a lens");
    for (key, value) in [
        ("s1", json!(0)),
        ("s2", Value::Null),
        ("xi", json!(0.0)),
        ("latlong", json!(false)),
        ("rolling_shutter", json!([0, 0, 0, 0])),
        ("binning_x", json!(1)),
        ("roi", json!({"x_offset": 0, "do_rectify": false})),
        ("rectification_matrix", json!({"rows": 3, "cols": 3, "data": [1, 0, 0, 0, 1, 0, 0, 0, 1]})),
        ("distortion", json!([0.05, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0])),
        ("distortion_coefficients", json!({"rows": 1, "cols": 5, "data": [0.05, 0, 0, 0, 0]})),
        ("distortion", json!({"k1": 0.05, "k2": 0})),
        ("distortion_model", json!("plumb_bob")),
        ("camera_model", json!("SIMPLE_RADIAL")),
        ("camera_model", json!("opencv")),
        ("model", json!("Canon EOS 5D")),
        ("camera", json!("FC6310")),
        ("lens", json!({"k2": 0, "fl_x": 60})),
        ("coeffs", json!([0, 0, 0, 0, 0])),
        ("is_fisheye", json!("False")),
        ("is_fisheye", json!(0)),
        ("camera_matrix", json!({"rows": 3, "cols": 3, "data": [60, 0, 20, 0, 60, 10, 0, 0, 1]})),
        ("k", json!([60, 0, 20, 0, 60, 10, 0, 0, 1])),
        ("intrinsics", json!([60, 60, 20, 10])),
        ("projection_matrix", json!([[60, 0, 20, 0], [0, 60, 10, 0], [0, 0, 1, 0]])),
        ("resolution", json!([64, 48])),
        ("applied_transform", json!([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]])),
        ("ply_file_path", json!("sparse.ply")),
        ("file_path", json!("a.png")),
        ("colmap_im_id", json!(3)),
        ("aabb_scale", json!(16)),
        ("focal_length", json!(35)),
        ("fov", json!(90)),
    ] {
        let mut one = bent.clone();
        one.insert(key.to_owned(), value.clone());
        assert_eq!(read(&Keys::new(), &one), Ok(plain), "{key} {value}");
        assert_eq!(read(&one, &Keys::new()), Ok(plain), "{key} {value}");
    }
}

/// Models of other names, and contradictions between two of them and their coefficients.
#[test]
fn models_have_their_coefficients() {
    let with = |more: Value| {
        let mut all = keys(json!({"fl_x": 60, "fl_y": 61, "cx": 20, "cy": 10, "w": 64, "h": 48}));
        all.extend(keys(more));
        read(&Keys::new(), &all)
    };
    let curve = |more: Value| match with(more.clone())
        .map(|found| found.lens(None, None).expect("a lens").for_image(0, 64, 48))
    {
        Ok(Ok(Lens::Curved { curve, .. })) => Some(curve),
        Ok(Ok(_)) => None,
        other => panic!("{more}: {other:?}"),
    };
    let fisheye = Some(Curve::Fisheye { k: [0.05, 0.01, 0.0, 0.0] });
    let distorted = Some(Curve::Distorted { k: [0.05, 0.01, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] });
    for (more, expected) in [
        (
            json!({"camera_model": "pinhole", "distortion_model": "equidistant", "distortion_coeffs": [0.05, 0.01, 0, 0]}),
            fisheye,
        ),
        (json!({"distortion_model": "radtan", "D": [0.05, 0.01, 0, 0]}), distorted),
        (json!({"camera_model": "RADIAL", "params": [60.0, 20, 10, 0.05, 0.01], "fl_y": 60}), distorted),
        (json!({"model": "RADIAL_FISHEYE", "params": [60.0, 20, 10, 0.05, 0.01], "fl_y": 60}), fisheye),
        (json!({"is_fisheye": "true", "k1": 0.05, "k2": 0.01}), fisheye),
        (json!({"camera_model": "OPENCV", "params": [60, 61, 20, 10, 0.05, 0.01, 0, 0]}), distorted),
        (json!({"camera_model": "PINHOLE", "k1": 0, "distortion": [0, 0, 0, 0, 0]}), None),
    ] {
        assert_eq!(curve(more.clone()), expected, "{more}");
    }
    for more in [
        json!({"camera_model": "PINHOLE", "k1": 0.05}),
        json!({"camera_model": "SIMPLE_RADIAL", "k2": 0.05}),
        json!({"camera_model": "OPENCV_FISHEYE", "p1": 0.05}),
        json!({"camera_model": "OPENCV_FISHEYE", "k5": 0.05}),
        json!({"camera_model": "OPENCV_FISHEYE", "is_fisheye": false}),
        json!({"camera_model": "OPENCV", "is_fisheye": true}),
        json!({"camera_model": "OPENCV", "distortion_model": "equidistant"}),
        json!({"camera_model": "EQUIRECTANGULAR", "k1": 0.1}),
        json!({"camera_model": "EQUIRECTANGULAR", "is_fisheye": 1}),
        json!({"curve": "panorama", "k1": 0.1}),
        json!({"curve": "panorama", "camera_model": "OPENCV"}),
        json!({"k1": 0.1, "D": [0.2]}),
    ] {
        let error = with(more.clone()).expect_err(&more.to_string());
        assert!(more.as_object().is_some_and(|keys| keys.keys().any(|key| error.contains(key))), "{more}: {error}");
    }
    // A panorama has no focal lengths, and its middle is the view.
    let panorama = with(json!({"camera_model": "EQUIRECTANGULAR"})).expect("a lens").lens(None, None).expect("a lens");
    assert!(panorama.for_image(0, 64, 48).expect_err("off centre").to_string().contains("camera 0: cx and cy"));
}

/// A height as an angle is a focal length where the principal point is beside the middle; sizes and angles of the list belong to
/// its cameras.
#[test]
fn angles_complete_what_the_camera_says() {
    let list = keys(json!({"vfov": 40, "w": 64, "h": 48}));
    let camera = keys(json!({"cx": 20, "cy": 10}));
    let found = read(&list, &camera).expect("a lens").lens(None, None).expect("a lens").for_image(0, 64, 48);
    let Ok(Lens::Intrinsics { fx, fy, cx, cy }) = found else { panic!("{found:?}") };
    let focal = 24.0 / 20.0_f64.to_radians().tan();
    assert!((fx - focal).abs() < 1e-12 * focal && fx == fy && [cx, cy] == [20.0, 10.0]);
    let viewport = read(&keys(json!({"viewport": [0.4, 0.3]})), &keys(json!({"distance": 2}))).expect("a lens");
    assert_eq!(viewport.camera.lens, Lens::Viewport { vw: 0.4, vh: 0.3, distance: 2.0 });
    let parallel = read(&keys(json!({"viewport": [4, 3], "distance": null})), &Keys::new()).expect("a lens");
    assert_eq!(parallel.camera.lens, Lens::Orthographic { height: 3.0 });
    let lacks = read(&list, &keys(json!({"cx": 20}))).expect_err("half a point");
    assert!(lacks.contains("camera 0 cy: missing beside cx"), "{lacks}");
    let alone = read(&Keys::new(), &keys(json!({"cx": 20, "cy": 10}))).expect_err("no focal length");
    assert!(alone.contains("camera 0 fl_x: missing beside `cx` of the camera"), "{alone}");
    // Without a size an angle and a focal length are compared with the picture's.
    let lens =
        read(&keys(json!({"camera_angle_x": 1.0})), &keys(json!({"fl_x": 60}))).expect("a lens").lens(None, None);
    let lens = lens.expect("a lens");
    let focal = 2.0 * 60.0 * 0.5_f64.tan();
    lens.for_image(0, focal.round() as u32, 48).expect("they agree");
    let error = lens.for_image(0, 40, 48).expect_err("they differ").to_string();
    assert!(error.contains("camera 0: the focal length and the angle of its width"), "{error}");
}

#[test]
fn an_empty_list_says_what_it_should_have() {
    for text in ["", " \n\t", "\u{feff}"] {
        let error = of_bytes(text.as_bytes(), "none.json").expect_err("nothing").to_string();
        assert!(error.starts_with("none.json: the file is empty") && error.contains("frames"), "{error}");
    }
    let list = "\u{feff}[{\"eye\": [0, 0, 9], \"at\": [0, 0, 0], \"up\": [0, 1, 0], \"vfov\": 30}]";
    assert_eq!(of_bytes(list.as_bytes(), "bom.json").expect("a list").len(), 1);
}

/// Any values of any keys give a camera, or an error with the file and a mend; what is read makes a lens or is refused.
#[test]
fn any_values_are_read_or_refused() {
    let draw = &mut Draw(11);
    let names: Vec<&str> = super::keys::KEYS.iter().map(|(key, _)| *key).chain(["k", "eye", "data"]).collect();
    let numbers = [0.0, 1.0, -1.0, 0.5, 3.0, 4.0, 1e-320, 1e308, -2.5e8, 64.0, 4294967296.0, 0.1];
    let words = ["", "true", "OPENCV", "opencv_fisheye", "FOV", "pinhole", "panorama", "equidistant", "\u{e9}"];
    let mut read_of = [0, 0];
    for _ in 0..6_000 {
        let value = |draw: &mut Draw| -> Value {
            let number = |draw: &mut Draw| json!(numbers[draw.below(numbers.len())]);
            let list = |draw: &mut Draw| {
                (0..[0, 1, 2, 3, 4, 5, 6, 8, 9, 12, 14, 16][draw.below(12)]).map(|_| number(draw)).collect()
            };
            match draw.below(9) {
                0 => Value::Null,
                1 => json!(draw.coin()),
                2 => json!(words[draw.below(words.len())]),
                3 => Value::Array(list(draw)),
                4 => json!({"data": Value::Array(list(draw)), "k1": number(draw)}),
                5 => json!({names[draw.below(names.len())]: number(draw), names[draw.below(names.len())]: list(draw)}),
                _ => number(draw),
            }
        };
        let some = |draw: &mut Draw| -> Keys {
            (0..draw.below(5)).map(|_| (names[draw.below(names.len())].to_owned(), value(draw))).collect()
        };
        let (list, mut camera) = (some(draw), some(draw));
        if draw.coin() {
            camera.insert("fl_x".into(), json!(60));
        }
        match read(&list, &camera) {
            Ok(found) => {
                read_of[0] += 1;
                if let Some(lens) = found.lens(None, None) {
                    drop(lens.for_image(0, 64, 48));
                }
            }
            Err(error) => {
                read_of[1] += 1;
                assert!(error.contains("list.json") && error.contains(';'), "{list:?} {camera:?}: {error}");
            }
        }
    }
    assert!(read_of[0] > 300 && read_of[1] > 300, "{read_of:?}");
}
