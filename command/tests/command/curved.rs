//! The promise of curved lenses: plans and reports say what is rendered, and what is drawn over a picture is where the lens shows it.

use crate::test_dir::TestDir;
use serde_json::json;

/// docs/film.md: `plan` says how a curved lens is rendered, and `--resume` keeps the files of the same rendering alone.
#[test]
fn curved_lenses_are_planned_and_resumed() {
    let rows = "x,y,z,radius\n0,0,40,12\n30,5,45,9\n-25,-20,50,11\n";
    let pose = json!([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]);
    for lens in [
        json!({"k1": -0.2, "fx": 30, "cx": 21, "cy": 14.5}),
        json!({"camera_model": "OPENCV_FISHEYE", "fx": 20}),
        json!({"camera_model": "EQUIRECTANGULAR"}),
    ] {
        let dir = TestDir::new(&[("a.csv", rows)]);
        let mut camera = json!({"pose": pose, "w": 40, "h": 30});
        lens.as_object().expect("an object").iter().for_each(|(key, value)| camera[key] = value.clone());
        dir.put("list.json", json!([camera]).to_string());
        let options = "a.csv --cameras list.json --look plain";
        let plan = dir.run(&format!("plan {options} --backend cpu --json"));
        assert_eq!(plan.code, 0, "{}", plan.err);
        let plan = plan.json();
        let report = &dir.render(&format!("{options} -o r%d.png --json")).json_lines()[0];
        for key in
            ["backend", "adapter", "method", "accuracy", "search", "reason", "camera", "spheres", "rays", "samples"]
        {
            assert_eq!(plan[key], report[key], "{key}");
        }
        assert_eq!((&plan["method"], &plan["search"]), (&json!("certified"), &json!("tree")));
        let text = dir.run(&format!("plan {options} --backend cpu")).text();
        assert!(text.contains("given rays") && text.contains("a tree certifies"), "{text}");
        assert_eq!(dir.run(&format!("plan {options} --wgsl")).code, 2, "the host traces given rays");
        assert!(dir.run(&format!("plan {options} --method stable --wgsl")).text().contains("fn main"));
        let resumed = |more: &str| {
            let lines = dir.render(&format!("{options} -o r%d.png --json --resume {more}")).json_lines();
            lines[0]["resumed"].as_bool().expect("a truth")
        };
        assert!(resumed(""), "{lens}: its own file is known");
        assert!(!resumed("--method stable"), "{lens}: a file of another method is not");
        assert!(resumed("--method stable"), "{lens}");
        assert!(!resumed(""), "{lens}: an uncertified file is not kept");
        assert!(!resumed("--accuracy exact") && resumed("--accuracy exact"), "{lens}");
        assert!(!resumed("--samples 4") && resumed("--samples 4"), "{lens}");
    }
}

/// docs/film.md: a mark stands where the lens shows what it names.
#[test]
fn marks_are_where_curved_lenses_show_their_things() {
    let rows = "x,y,z,radius,name\n-2.6,1.5,0.5,0.6,A\n2.5,0.8,0.2,0.6,B\n0,-1,0,0.6,C\n";
    let dir = TestDir::new(&[("a.csv", rows)]);
    let matrix = json!([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 3], [0, 0, 0, 1]]);
    for lens in [
        json!({"camera_model": "OPENCV_FISHEYE", "fl_x": 110, "k1": 0.02}),
        json!({"fl_x": 110, "k1": -0.12, "p1": 0.01}),
        json!({"camera_model": "EQUIRECTANGULAR"}),
        json!({"fl_x": 110, "cx": 130}),
    ] {
        let mut camera = json!({"transform_matrix": matrix, "w": 300, "h": 300});
        lens.as_object().expect("an object").iter().for_each(|(key, value)| camera[key] = value.clone());
        if lens.get("cx").is_some() {
            camera["cy"] = json!(150);
        }
        dir.put("list.json", json!([camera]).to_string());
        dir.render("a.csv --cameras list.json --look plain -o plain%d.png --aov id=i%d.npy");
        let pixels = |name: &str| image::open(dir.path(name)).expect("a picture").to_rgb8().into_raw();
        let (ids, plain) = (dir.array("i1.npy").0, pixels("plain1.png"));
        for (id, name) in ["A", "B", "C"].iter().enumerate() {
            let mark = format!("name {name}=o");
            let options = ["a.csv", "--cameras", "list.json", "--look", "plain", "-o", "m%d.png", "--mark", &mark];
            dir.render(&options);
            let marked = pixels("m1.png");
            let middle = |is_of: &dyn Fn(usize) -> bool| {
                let of: Vec<usize> = (0..300 * 300).filter(|n| is_of(*n)).collect();
                assert!(!of.is_empty(), "{lens} {name}");
                let mean =
                    |side: &dyn Fn(usize) -> usize| of.iter().map(|n| side(*n) as f64).sum::<f64>() / of.len() as f64;
                [mean(&|n| n % 300), mean(&|n| n / 300)]
            };
            let text = middle(&|n| marked[3 * n..3 * n + 3] != plain[3 * n..3 * n + 3]);
            let thing = middle(&|n| ids[n] == id as f64);
            let apart = (text[0] - thing[0]).hypot(text[1] - thing[1]);
            // The text is on its thing; the middle of a disc's picture is beside the picture of its centre by a few pixels.
            assert!(apart < 6.0, "{lens} {name}: {text:?} for {thing:?}");
        }
    }
}
