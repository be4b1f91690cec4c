//! Promises of `halfline view`: a still has the bytes of the copied command, a pick is the buffer `id` of it with the row
//! and the columns of the file, and the command ends as it should.

use crate::data::real_or_skip;
use crate::page::{Page, check_stills, moved};
use crate::rng::Rng;
use crate::test_dir::TestDir;
use serde_json::{Value, json};

const TABLE: &str = "x,y,z,radius,kind,speed\n0,0,0,1,a,0.5\n2,0,0,0.7,b,1.5\n0,2,0,0.5,a,2.5\n1,1,1,0.6,c,-1\n";

/// Three frames of two atoms in a cell; the second atom crosses its border.
fn film() -> String {
    let frame = |n: u32| {
        format!(
            "2\nLattice=\"10 0 0 0 10 0 0 0 10\" Properties=species:S:1:pos:R:3:q:R:1\nC 0.5 0 0 {n}\nO {}.5 1 0 0.25\n",
            7 + n
        )
    };
    (0..3).map(frame).collect()
}

fn dir() -> TestDir {
    TestDir::new(&[("t.csv", TABLE), ("film.xyz", &film()), ("it's a $file.csv", TABLE)])
}

#[test]
fn a_still_has_the_bytes_of_its_command() {
    let dir = dir();
    check_stills(&dir, "t.csv --backend cpu --color-by speed --legend-in top-left --size 240x180", Some("kind a"));
    check_stills(&dir, "film.xyz --backend cpu --cell --frames 2", Some("element C"));
    check_stills(&dir, "film.xyz --backend cpu --look figure --clip 1,0,0,8.6 --hold all --color-by q", None);
    dir.put("s.toml", crate::test_dir::SCENE);
    check_stills(&dir, "s.toml --backend cpu --exposure 0.5 --transparent", None);
}

#[test]
fn a_still_of_real_files_has_the_bytes_of_its_command() {
    let dir = dir();
    for (name, path) in real_or_skip(&["1tii.pdb", "balls_s2.nff"]) {
        dir.put(name, std::fs::read(path).expect("a file"));
        let selection = name.ends_with("pdb").then_some("chain A and not name CA");
        check_stills(&dir, &format!("{name} --backend cpu --shadows"), selection);
    }
}

/// The name of the file has what a shell takes apart.
#[test]
fn the_command_is_for_a_shell() {
    let dir = dir();
    dir.put("plain.csv", TABLE);
    let mut words = vec!["view", "it's a $file.csv", "--backend", "cpu", "--port", "0", "--no-open", "--select"];
    words.push("kind a b and not (speed > 2 or kind \"q'\")");
    let page = Page::of(dir.command(&words));
    let scene = page.good("/scene", &json!({}));
    assert_eq!((scene["count"].as_u64(), scene["file"].as_str()), (Some(2), Some("it's a $file.csv")));
    let body = json!({ "camera": scene["camera"], "size": [40, 30], "mode": "still" });
    let (still, words) = page.still(&body);
    dir.good(&words);
    assert!(still == dir.get("it's a $file-view.png"));
}

/// Picks at random pixels of random cameras, against the buffers of the command.
fn check_picks(dir: &TestDir, arguments: &str, count: u32, seed: u64) {
    let page = Page::open(dir, arguments);
    let scene = page.good("/scene", &json!({}));
    let mut rng = Rng::new(seed);
    let mut below = |n: u32| (rng.unit() * f64::from(n)) as u32;
    let (views, mut hits) = (4, 0);
    for view in 0..views {
        let camera = moved(&scene["camera"], 1.3 * f64::from(view), 0.4 + 0.15 * f64::from(view));
        let body = json!({ "camera": camera, "size": [97, 71], "mode": "still", "options": { "look": ["plain"] } });
        let (_, mut words) = page.still(&body);
        words.extend(["--aov", "id=id.npy", "--aov", "position=p.npy", "--aov", "distance=d.npy"].map(String::from));
        dir.good(&words);
        let [id, position, distance] = ["id.npy", "p.npy", "d.npy"].map(|name| dir.array(name).0);
        for _ in 0..count / views {
            let (x, y) = (below(97), below(71));
            let at = (y * 97 + x) as usize;
            let pick = page.good("/pick", &json!({ "camera": camera, "size": [97, 71], "x": x, "y": y }));
            if id[at] < 0.0 {
                assert_eq!(pick, Value::Null, "{arguments} {x} {y}");
                continue;
            }
            hits += 1;
            assert_eq!(pick["id"].as_f64(), Some(id[at]), "{arguments} {x} {y}");
            // Both are within 1e-5 of the exact distance.
            let close = |found: &Value, expected: f64| {
                (found.as_f64().expect("a number") - expected).abs() <= 2.1e-5 * distance[at]
            };
            assert!(close(&pick["distance"], distance[at]), "{pick}");
            (0..3).for_each(|k| assert!(close(&pick["position"][k], position[3 * at + k]), "{pick}"));
        }
    }
    println!("{arguments}: {count} picks, {hits} of them hits");
    assert!(hits > count / 20, "{arguments}: {hits} hits");
}

#[test]
fn a_pick_is_the_buffer_of_ids() {
    let dir = dir();
    dir.put("s.toml", crate::test_dir::SCENE);
    check_picks(&dir, "s.toml --backend cpu", 200, 1);
    check_picks(&dir, "t.csv --backend cpu", 200, 2);
    check_picks(&dir, "film.xyz --backend cpu --cell --copies 2,2,1", 200, 3);
    for (name, path) in real_or_skip(&["1tii.pdb", "balls_s4.nff"]) {
        dir.put(name, std::fs::read(path).expect("a file"));
        check_picks(&dir, &format!("{name} --backend cpu"), 200, 4);
    }
}

/// The page is framed for its window as a picture of that size is, and `f` frames what is selected in the same direction.
#[test]
fn a_page_is_framed_for_its_window_and_its_selection() {
    let dir = dir();
    let page = Page::open(&dir, "t.csv --backend cpu");
    let scene = page.good("/scene", &json!({ "size": [300, 120] }));
    let expected = dir.render("t.csv --size 300x120 -o a.png --json").json()["camera"].clone();
    assert_eq!((&scene["size"], &scene["camera"]["eye"]), (&json!([300, 120]), &expected["eye"]));
    assert_eq!((&scene["format"], &scene["sized"]), (&json!("csv"), &json!(false)));
    let mut body = json!({ "camera": moved(&scene["camera"], 0.5, 2.0), "size": [300, 120] });
    for select in [Value::Null, json!("kind b or kind c")] {
        body["select"] = select.clone();
        let fitted = page.good("/fit", &body)["camera"].clone();
        let part =
            |camera: &Value, k: usize| camera["at"][k].as_f64().expect("x") - camera["eye"][k].as_f64().expect("x");
        let view = |camera: &Value| glam::DVec3::from_array([0, 1, 2].map(|k| part(camera, k)));
        let turned = view(&body["camera"]).normalize().cross(view(&fitted).normalize()).length();
        assert!(turned < 1e-12, "{select}: the direction stays");
        body["camera"] = fitted.clone();
        let distance = view(&fitted).length();
        let options = if select.is_null() { "--fit".to_owned() } else { "--focus=kind b or kind c".to_owned() };
        let [eye, at, up] = ["eye", "at", "up"].map(|name| [0, 1, 2].map(|k| fitted[name][k].as_f64().expect("x")));
        let vector = |v: [f64; 3]| v.map(|x| x.to_string()).join(",");
        let direction = vector([0, 1, 2].map(|k| at[k] - eye[k]));
        let words =
            ["plan", "t.csv", &options, "--view", &direction, "--up", &vector(up), "--size", "300x120", "--json"];
        let again = dir.good(&words).json()["camera"]["eye"].clone();
        let near = |k: usize| (again[k].as_f64().expect("x") - eye[k]).abs() < 1e-9 * distance;
        assert!((0..3).all(near), "{select}: {again} and {fitted}");
    }
    let sized = Page::open(&dir, "t.csv --backend cpu --size 90x60").good("/scene", &json!({ "size": [300, 120] }));
    assert_eq!((&sized["size"], &sized["sized"]), (&json!([90, 60]), &json!(true)));
}

/// A pixel that shows this sphere.
fn pick(page: &Page, frame: u32, id: u64, from: Option<u64>) -> Value {
    let camera = page.good("/scene", &json!({}))["camera"].clone();
    let of = |x: u32, y: u32| {
        let body = json!({ "camera": camera, "size": [40, 40], "x": x, "y": y, "frame": frame, "from": from });
        page.good("/pick", &body)
    };
    let all = (0..1600).map(|n| of(n % 40, n / 40));
    all.into_iter().find(|pick| pick["id"] == id).unwrap_or_else(|| panic!("sphere {id} is not seen"))
}

#[test]
fn a_pick_has_the_row_and_the_columns_of_the_file() {
    let dir = dir();
    let words =
        ["view", "t.csv", "--backend", "cpu", "--hide", "kind b", "--view", "0,0,-1", "--port", "0", "--no-open"];
    let page = Page::of(dir.command(&words));
    let found = pick(&page, 1, 1, None);
    assert_eq!((&found["row"], &found["columns"]), (&json!(2), &json!({ "kind": "a", "speed": 2.5 })));
    assert_eq!((&found["center"], &found["radius"]), (&json!([0.0, 2.0, 0.0]), &json!(0.5)));
}

/// The atoms of the second frame are 8 apart along x and 1 along y, and in the cell 2 along x.
#[test]
fn the_distance_of_two_picks_is_also_that_of_the_nearest_image() {
    let dir = dir();
    let page = Page::open(&dir, "film.xyz --backend cpu --view 0,0,-1");
    let from = &pick(&page, 2, 1, Some(0))["from"];
    let close = |found: &Value, expected: f64| (found.as_f64().expect("a number") - expected).abs() < 1e-12;
    assert!(close(&from["distance"], 65_f64.sqrt()) && close(&from["minimum_image"], 5_f64.sqrt()), "{from}");
    assert_eq!(from["id"], 0);
}

#[test]
fn the_frames_of_a_film_are_shown_and_counted() {
    let dir = dir();
    let page = Page::open(&dir, "film.xyz --backend cpu --color-by q");
    let scene = page.good("/scene", &json!({}));
    let count = (0..200).find_map(|_| {
        std::thread::sleep(std::time::Duration::from_millis(20));
        page.good("/scene", &json!({}))["frames"].as_u64()
    });
    assert_eq!(count, Some(3), "{scene}");
    let still = |frame: u32| {
        let body = json!({ "camera": scene["camera"], "size": [40, 30], "mode": "still", "frame": frame });
        page.ask("/frame", &body)
    };
    let pictures: Vec<_> = [3, 1, 2, 3].map(|frame| still(frame).body).into();
    assert!(pictures[0] == pictures[3] && pictures[0] != pictures[1] && pictures[1] != pictures[2]);
    let beyond = still(4);
    assert_eq!(beyond.status, 400);
    assert!(beyond.json()["error"]["message"].as_str().expect("words").contains("3 frames"), "{}", beyond.json());
}

#[test]
fn a_move_is_a_jpeg_and_says_what_is_true() {
    let dir = dir();
    let page = Page::open(&dir, "t.csv --backend cpu");
    let scene = page.good("/scene", &json!({}));
    let body = json!({ "seq": 7, "camera": scene["camera"], "size": [64, 48], "mode": "move" });
    let reply = page.ask("/frame", &body);
    assert!(reply.body.starts_with(&[0xff, 0xd8, 0xff]) && reply.body.ends_with(&[0xff, 0xd9]));
    assert_eq!((&reply.info["seq"], &reply.info["accuracy"]), (&json!(7), &json!("fast")), "four spheres");
    let unit = reply.info["unit"].as_f64().expect("a length");
    let camera = &scene["camera"];
    let part = |k: usize| camera["eye"][k].as_f64().expect("x") - camera["at"][k].as_f64().expect("x");
    let distance = (0..3).map(|k| part(k) * part(k)).sum::<f64>().sqrt();
    let expected = 2.0 * (camera["vfov"].as_f64().expect("an angle").to_radians() / 2.0).tan() * distance / 48.0;
    assert!((unit / expected - 1.0).abs() < 1e-12, "{unit}, not {expected}");
}

#[test]
fn what_is_wrong_is_answered() {
    let dir = dir();
    let page = Page::open(&dir, "t.csv --backend cpu");
    let camera = page.good("/scene", &json!({}))["camera"].clone();
    let with = |name: &str, value: Value| {
        let mut body = json!({ "camera": camera, "size": [64, 48] });
        body[name] = value;
        body
    };
    let part =
        |window: [u32; 4]| json!({ "camera": camera, "size": [64, 48], "mode": "part", "window": window, "seq": 1 });
    let reply = page.ask("/frame", &part([0, 0, 3, 2]));
    assert!(reply.status == 200 && reply.body.starts_with(b"\xff\xd8\xff"), "a part is a JPEG: {}", reply.status);
    assert_eq!((&reply.info["warnings"], &reply.info["look"]), (&json!([]), &json!("soft")));
    let mut down = camera.clone();
    down["up"] = json!([0.0, 0.0, 0.0]);
    for (route, body, word) in [
        ("/frame", with("size", json!([0, 48])), "size"),
        ("/frame", with("size", json!([1_000_000, 1_000_000])), "size"),
        ("/frame", with("options", json!({ "look": ["pretty"] })), "pretty"),
        ("/frame", with("options", json!({ "look": ["plain --output=x.png"] })), "plain"),
        ("/frame", with("camera", down), "up"),
        ("/frame", with("camera", json!({ "eye": [0, 0, 1], "at": [0, 0, 0], "up": [0, 1, 0], "vfov": 200 })), "200"),
        ("/frame", with("select", json!("kind")), "kind"),
        ("/frame", with("options", json!({ "samples": ["0"] })), "samples"),
        ("/frame", with("frame", json!(2)), "frame 2"),
        ("/frame", part([0, 0, 65, 48]), "64"),
        ("/frame", part([9, 9, 9, 9]), "9"),
        ("/frame", part([40, 0, 20, 48]), "40"),
        ("/select", json!({ "expr": "knd a" }), "knd"),
        ("/select", json!({ "expr": "" }), ""),
        ("/pick", json!({ "camera": camera, "size": [64, 48], "x": 64, "y": 0 }), "64"),
    ] {
        let reply = page.ask(route, &body);
        let message = reply.json()["error"]["message"].as_str().unwrap_or_default().to_owned();
        assert!(reply.status == 400 && message.contains(word), "{route} {body}: {} {message}", reply.status);
    }
    assert_eq!(page.good("/select", &json!({ "expr": "kind a and speed < 1" }))["count"], 1, "it is still there");
}

#[test]
fn the_camera_of_a_picture_is_taken_both_ways() {
    let dir = dir();
    let page = Page::open(&dir, "t.csv --backend cpu --look plain");
    let scene = page.good("/scene", &json!({}));
    let body = json!({ "camera": moved(&scene["camera"], 0.4, 0.7), "size": [50, 40], "mode": "still" });
    dir.put("saved.png", page.still(&body).0);
    dir.render("t.csv --look plain --camera-from saved.png -o again.png");
    // The files differ in the fingerprint of the scene: a picture has its camera as a viewport.
    assert!(dir.array("again.png") == dir.array("saved.png"));
    let again = Page::open(&dir, "t.csv --camera-from saved.png").good("/scene", &json!({}));
    assert_eq!(again["size"], body["size"]);
    ["eye", "at", "up"].iter().for_each(|part| assert_eq!(again["camera"][part], body["camera"][part], "{part}"));
    let [found, given] = [&again, &body].map(|of| of["camera"]["vfov"].as_f64().expect("an angle"));
    assert!((found / given - 1.0).abs() < 1e-14, "a tangent and its inverse: {found}, not {given}");
}

/// The page begins with the picture of the same options.
#[test]
fn the_first_camera_is_that_of_the_picture() {
    let dir = dir();
    dir.render("t.csv --eye 3,4,5 --at 0,0,0 --vfov 20 -o from.png");
    for options in [
        "t.csv",
        "t.csv --size 90x60 --view iso --zoom 2",
        "t.csv --ortho --view top",
        "t.csv --focus kind=a",
        "t.csv --at kind=c --vfov 50",
        "t.csv --camera-from from.png --zoom 3",
        "film.xyz --hold all --frames 2",
        "film.xyz --frames 2 --clip 1,0,0,8.6",
        "t.csv --color-by speed --legend-in --size 300x200",
    ] {
        let words: Vec<String> = options.split(' ').map(|word| word.replace("kind=", "kind ")).collect();
        let with = |before: &[&str], after: &[&str]| {
            let own = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
            [own(before), words.clone(), own(after)].concat()
        };
        let first =
            dir.good(&with(&["render"], &["--json", "--backend", "cpu", "-o", "%d.png"])).json_lines().remove(0);
        let page = Page::of(dir.command(&with(&["view"], &["--port", "0", "--no-open", "--backend", "cpu"])));
        let (scene, expected) = (page.good("/scene", &json!({})), &first["camera"]);
        let camera = &scene["camera"];
        ["eye", "up"].iter().for_each(|part| assert_eq!(camera[part], expected[part], "{options}: {part}"));
        assert_eq!(scene["size"], expected["size"], "{options}");
        let number = |value: &Value| value.as_f64().expect("a number");
        let along = |k: usize| number(&camera["at"][k]) - number(&camera["eye"][k]);
        let view = |k: usize| number(&expected["view"][k]);
        let length = |of: &dyn Fn(usize) -> f64| (0..3).map(|k| of(k) * of(k)).sum::<f64>().sqrt();
        let cosine = (0..3).map(|k| along(k) * view(k)).sum::<f64>() / length(&along) / length(&view);
        assert!((cosine - 1.0).abs() < 1e-14, "{options}: {camera}");
        let height = match camera["height"].as_f64() {
            Some(height) => height,
            None => 2.0 * (number(&camera["vfov"]).to_radians() / 2.0).tan() * number(&expected["distance"]),
        };
        assert!((height / number(&expected["viewport"][1]) - 1.0).abs() < 1e-14, "{options}: {camera}");
    }
}

#[test]
fn what_a_page_does_not_have_is_refused() {
    let dir = dir();
    dir.put("bad.csv", "x,y,z\n1,2\n");
    for (code, words, expected) in [
        (8, "view missing.csv --no-open", "missing.csv"),
        (2, "view - --no-open", "standard input"),
        (2, "view t.csv -o x.png", "--output"),
        (2, "view t.csv --aov id=x.npy", "--aov"),
        (2, "view t.csv --spin 3", "--spin"),
        (2, "view t.csv --cameras c.json", "--cameras"),
        (2, "view t.csv --tile 1/4", "--tile"),
        (2, "view film.xyz --frames 1-2 --no-open --port 0", "one number"),
        (2, "view t.csv --idle soon", "--idle"),
        (2, "view t.csv --port 70000", "--port"),
    ] {
        dir.refused(code, words, &[expected]);
    }
    // The page is there before the file is read.
    let output = dir.run("view bad.csv --no-open --port 0");
    assert!(output.code == 3 && output.err.contains("bad.csv:2"), "{}", output.err);
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("an address").port();
    dir.refused(2, &format!("view t.csv --no-open --port {port}"), &[&port.to_string()]);
}

#[test]
fn it_ends_when_it_is_idle_or_interrupted() {
    let dir = dir();
    let output = dir.run("view t.csv --no-open --port 0 --idle 0.3s --quiet");
    assert_eq!((output.code, output.text().lines().count()), (0, 1), "{}", output.err);
    #[cfg(unix)]
    {
        let mut page = Page::open(&dir, "t.csv --backend cpu");
        page.good("/scene", &json!({}));
        let id = page.process().id().to_string();
        assert!(std::process::Command::new("kill").args(["-INT", &id]).status().expect("kill").success());
        assert_eq!(page.process().wait().expect("an end").code(), Some(130));
        assert!(std::net::TcpStream::connect(("127.0.0.1", page.port())).is_err(), "the port is closed");
    }
}
