//! The controls of the page of `halfline view`: options that it sets give the picture of the command that it copies.

use crate::amount::amount;
use crate::data::real_or_skip;
use crate::page::{Page, moved};
use crate::rng::Rng;
use crate::test_dir::TestDir;
use serde_json::{Map, Value, json};

const TABLE: &str = "x,y,z,radius,kind,speed\n0,0,0,1,a,0.5\n2,0,0,0.7,b,1.5\n0,2,0,0.5,a,2.5\n1,1,1,0.6,c,-1\n";

/// Two frames of three atoms in a cell.
const FILM: &str = "3\nLattice=\"5 0 0 0 5 0 0 0 5\" Properties=species:S:1:pos:R:3:q:R:1\nC 0.5 0 0 1\nO 2 1 0 -0.25\nH 4 4 1 3\n\
                    3\nLattice=\"5 0 0 0 5 0 0 0 5\" Properties=species:S:1:pos:R:3:q:R:1\nC 1.5 0 0 2\nO 2 2 0 0.5\nH 4 3 1 7\n";

fn dir() -> TestDir {
    TestDir::new(&[("t.csv", TABLE), ("film.xyz", FILM), ("s.toml", crate::test_dir::SCENE)])
}

/// A value of a control, as the page sends it.
fn drawn(row: &Value, selection: Option<&str>, rng: &mut Rng) -> Vec<String> {
    let of = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name} of {row}"));
    if let Some(values) = row["values"].as_array() {
        let value = values[(rng.unit() * values.len() as f64) as usize].as_str().expect("a text");
        return (!value.is_empty()).then(|| value.to_owned()).into_iter().collect();
    }
    let number = match row["type"].as_str() {
        Some("color") => return vec![format!("#{:06x}", (rng.unit() * 16_777_216.0) as u32)],
        Some("number") => (1.0 + rng.unit() * 5.0).floor(),
        // Sliders keep most of the scene.
        Some("range") if row["id"] == "clip" => {
            let share = if row["plane"].to_string().contains('-') { 0.4 } else { 0.6 };
            of("min") + share * (of("max") - of("min"))
        }
        Some("range") => (of("min") + rng.unit() * (of("max") - of("min"))).max(0.05),
        kind => panic!("{kind:?} is no kind of control"),
    };
    let text = match (row["plane"].as_array(), selection) {
        (Some(plane), _) => {
            let plane: Vec<f64> = plane.iter().map(|x| x.as_f64().expect("a number")).collect();
            let distance = plane.iter().map(|x| x * number).sum::<f64>();
            format!("{},{},{},{distance}", plane[0], plane[1], plane[2])
        }
        (None, Some(selection)) if row["others"] == true => format!("not ({selection})={number}"),
        _ => number.to_string(),
    };
    vec![text]
}

/// Stills with drawn values of the controls: each has the bytes of the file that its command writes. Returns the options that were drawn.
fn check(dir: &TestDir, arguments: &str, selection: &str, cases: u32, seed: u64) -> Vec<String> {
    let page = page(dir, arguments);
    let scene = page.good("/scene", &json!({}));
    let rows = scene["controls"].as_array().expect("rows");
    let (mut rng, mut all) = (Rng::new(seed), Vec::new());
    for n in 0..cases {
        let select = (n % 3 == 1 && scene["selects"] == true).then_some(selection);
        let mut options = Map::new();
        // The sliders clip or cut.
        let planes = if rng.unit() < 0.5 { "clip" } else { "cut" };
        let is_drawn = |row: &&Value| row["renames"].is_null() && rng.unit() < 0.35;
        for row in rows.iter().filter(is_drawn).collect::<Vec<_>>() {
            let id = row["id"].as_str().map(|id| if id == "clip" { planes } else { id }).expect("an option");
            let more = drawn(row, select, &mut rng).into_iter().map(Value::from);
            options.entry(id).or_insert_with(|| json!([])).as_array_mut().expect("a list").extend(more);
            all.push(id.to_owned());
        }
        let camera = moved(&scene["camera"], 0.7 * f64::from(n), 1.0 - 0.02 * f64::from(n));
        let mut body = json!({ "camera": camera, "size": [191 + n, 160], "select": select, "options": options });
        if scene["frames"] != 1 {
            body["frame"] = json!(1 + n % 2);
        }
        let (still, words) = page.still(&body);
        dir.good(&words);
        let output = words.last().expect("a file");
        assert!(still == dir.get(output), "{arguments}: {body} {words:?}");
        dir.remove(output);
    }
    all
}

/// In the options `~` is a space within a word. Each picture has a legend whatever its colours are.
#[test]
fn drawn_controls_have_the_bytes_of_their_command() {
    let dir = dir();
    let mut all = Vec::new();
    for (seed, arguments, selection) in [
        (1, "t.csv --legend-in top-left --color kind~b=red", "kind a"),
        (2, "t.csv --legend-in --color-by speed --range 0,2 --map bwr --opacity kind~b=0.4 --clip 1,0,0,1.5", "x < 1"),
        (3, "t.csv --legend-in --color teal --color kind~b=red --transparent --samples 9 --layers 2", "speed > 0"),
        (4, "film.xyz --cell --copies 2,1,1 --frames 1 --legend-in", "element C"),
        (5, "film.xyz --look plain --color-by q --mark element~O=oxygen", "q > 0"),
        (6, "s.toml --look soft", "radius > 0"),
    ] {
        all.extend(check(&dir, arguments, selection, amount("stills with drawn controls", [6, 12, 12]), seed));
    }
    for id in ["color_by", "map", "opacity", "layers", "background", "look", "samples", "clip", "cut"] {
        assert!(all.iter().any(|drawn| drawn == id), "{id} was never drawn");
    }
}

#[test]
fn drawn_controls_of_real_files_have_the_bytes_of_their_command() {
    let dir = dir();
    for (name, path) in real_or_skip(&["1tii.pdb", "balls_s2.nff"]) {
        dir.put(name, std::fs::read(path).expect("a file"));
        check(&dir, name, "z > 0", amount("stills of a real file", [3, 9, 9]), 7);
    }
}

/// A control of the page with this option, and this word in its label.
fn row<'a>(scene: &'a Value, id: &str, word: &str) -> &'a Value {
    let is = |row: &&Value| row["id"] == id && row["label"].as_str().expect("a label").contains(word);
    scene["controls"].as_array().expect("rows").iter().find(is).unwrap_or_else(|| panic!("no {id} {word}"))
}

/// The controls begin with what the command line says, and offer what the file has.
#[test]
fn controls_begin_with_the_options_of_the_command_line() {
    let dir = dir();
    let words = "t.csv --color-by x,y --map own.csv --opacity 0.5 --opacity kind~b=0.2 --layers 3 --background #102030 --samples 25 --look plain";
    dir.put("own.csv", "#000000\n#ffffff\n");
    let scene = page(&dir, words).good("/scene", &json!({}));
    for (id, value) in [
        ("color_by", "x,y"),
        ("map", "own.csv"),
        ("opacity", "0.5"),
        ("layers", "3"),
        ("background", "#102030"),
        ("samples", "25"),
        ("look", "plain"),
    ] {
        let row = row(&scene, id, "");
        assert_eq!(row["value"], value, "{row}");
        assert!(row["help"].as_str().is_some_and(|help| help.len() > 20), "{row}");
        let offered = row["values"].as_array();
        assert!(offered.is_none_or(|values| values.contains(&row["value"])), "{row}");
    }
    let offered = row(&scene, "color_by", "")["values"].as_array().expect("columns");
    let columns = ["", "x,y", "kind", "speed", "x", "y", "z"].map(Value::from);
    assert!(columns.iter().all(|column| offered.contains(column)), "{offered:?}");
    let scene = page(&dir, "t.csv").good("/scene", &json!({}));
    assert_eq!(
        (&row(&scene, "color_by", "")["value"], &row(&scene, "opacity", "")["value"]),
        (&json!(""), &json!("1"))
    );
    // The sliders begin beyond all spheres, at whole steps.
    for (label, extent) in
        [("x from", -1.0), ("x to", 2.7), ("y from", -1.0), ("y to", 2.5), ("z from", -1.0), ("z to", 1.6)]
    {
        let row = row(&scene, "clip", label);
        let of = |name: &str| row[name].as_f64().expect("a number");
        let (value, step) = (of("value"), of("step"));
        let end = if label.ends_with("from") { of("min") } else { of("max") };
        assert!(value == end && (value - extent).abs() <= step && (of("max") - of("min")) / step >= 100.0, "{row}");
    }
}

fn page(dir: &TestDir, arguments: &str) -> Page {
    let words = format!("view {arguments} --port 0 --no-open --backend cpu");
    Page::of(dir.command(&words.split(' ').map(|word| word.replace('~', " ")).collect::<Vec<_>>()))
}

/// Every column and every map that the page offers is one that a picture takes.
#[test]
fn every_value_that_is_offered_is_taken() {
    let dir = dir();
    let mut files = vec!["t.csv".to_owned(), "film.xyz".into(), "s.toml".into()];
    for (name, path) in real_or_skip(&["1tii.pdb"]) {
        dir.put(name, std::fs::read(path).expect("a file"));
        files.push(name.into());
    }
    for file in files {
        let page = page(&dir, &file);
        let scene = page.good("/scene", &json!({}));
        if file == "s.toml" {
            assert!(!scene["controls"].to_string().contains("color_by"), "it has no columns");
            continue;
        }
        let values = |id: &str| row(&scene, id, "")["values"].as_array().expect("values").clone();
        let columns: Vec<Value> = values("color_by").into_iter().filter(|value| value != "").collect();
        for column in &columns {
            let body = json!({ "camera": scene["camera"], "size": [8, 6], "mode": "move", "options": { "color_by": [column] } });
            let reply = page.ask("/frame", &body);
            assert_eq!(reply.status, 200, "{file} {column}: {}", reply.json());
        }
        assert!(!columns.is_empty(), "{file}");
        for map in values("map").into_iter().filter(|map| map != "" && file == "t.csv") {
            let options = json!({ "color_by": ["speed"], "map": [map] });
            assert!(page.good("/select", &json!({ "options": options }))["legend"].is_string(), "{map}");
        }
    }
}

/// Picks and cameras that fit follow the picture without what is cut off.
#[test]
fn picks_and_fits_follow_the_clip_planes() {
    let dir = dir();
    let page = page(&dir, "t.csv --view 0,0,-1");
    let scene = page.good("/scene", &json!({}));
    let clip = json!({ "clip": ["-1,0,0,-0.5"] });
    let body = json!({ "camera": scene["camera"], "size": [40, 40], "options": clip });
    let found = (0..1600).map(|n| {
        let mut body = body.clone();
        (body["x"], body["y"]) = (json!(n % 40), json!(n / 40));
        page.good("/pick", &body)
    });
    let mut rows: Vec<(u64, u64)> = found
        .filter(|pick| !pick.is_null())
        .map(|pick| (pick["id"].as_u64().expect("an id"), pick["row"].as_u64().expect("a row")))
        .collect();
    rows.sort_unstable();
    rows.dedup();
    assert_eq!(rows, [(0, 1), (1, 3)], "the second and the fourth row of the file are left");
    let fitted = page.good("/fit", &body)["camera"].clone();
    let words = "plan t.csv --clip=-1,0,0,-0.5 --fit --view 0,0,-1 --up 0,1,0 --size 40x40 --json";
    let expected = dir.good(words).json()["camera"]["eye"].clone();
    let near = |k: usize| (fitted["eye"][k].as_f64().expect("x") - expected[k].as_f64().expect("x")).abs() < 1e-9;
    assert!((0..3).all(near), "{fitted} and {expected}");
}

/// The legend of other colours, and of all spheres.
#[test]
fn a_legend_follows_the_controls() {
    let dir = dir();
    let page = page(&dir, "t.csv");
    let ask = |expr: Value, options: Value| page.good("/select", &json!({ "expr": expr, "options": options }));
    let plain = ask(Value::Null, json!({}));
    assert_eq!((&plain["count"], &plain["of"], &plain["legend"]), (&json!(4), &json!(4), &Value::Null));
    let legend = |value: Value| value["legend"].as_str().expect("a legend").to_owned();
    let colored = legend(ask(Value::Null, json!({ "color_by": ["speed"] })));
    dir.good("render t.csv --color-by speed --legend l.svg -o a.png --size 20x20");
    assert_eq!(colored.as_bytes(), dir.get("l.svg"));
    let both = ask(json!("kind a"), json!({ "color_by": ["kind"], "opacity": ["not (kind a)=0.5"] }));
    assert_eq!(both["count"], 2);
    assert!(legend(both).contains("opacity 0.5"));
}

/// Options that are no controls are refused, above all those that name files; wrong values are answered with the reason.
#[test]
fn options_of_a_hostile_page_are_refused() {
    let dir = dir();
    dir.put("own.csv", "#000000\n#ffffff\n");
    let page = page(&dir, "t.csv --color-by speed --map own.csv");
    let scene = page.good("/scene", &json!({}));
    for (id, values, word) in [
        ("output", json!(["x.png"]), "output"),
        ("aov", json!(["id=x.npy"]), "aov"),
        ("topology", json!(["/etc/passwd"]), "topology"),
        ("legend", json!(["x.svg"]), "legend"),
        ("from", json!(["x.png"]), "from"),
        ("scene", json!(["/etc/passwd"]), "scene"),
        ("size", json!(["9x9"]), "size"),
        ("frames", json!(["1-"]), "frames"),
        ("", json!([]), "option"),
        ("look --output", json!(["x.png"]), "look --output"),
        ("map", json!(["/etc/passwd"]), "/etc/passwd"),
        ("map", json!(["./own.csv"]), "own.csv"),
        ("map", json!(["own.csv_r"]), "own.csv_r"),
        ("map", json!(["jet"]), "jet"),
        ("map", json!(["nonesuch"]), "nonesuch"),
        ("color_by", json!(["mass"]), "mass"),
        ("color_by", json!([""]), "column"),
        ("color_by", json!(["speed", "kind"]), "color"),
        ("clip", json!(["0,0,0,1"]), "direction"),
        ("clip", json!(["nan,0,0,1"]), "direction"),
        ("clip", json!(["1,0,0"]), "direction"),
        ("clip", json!([""]), "direction"),
        ("cut", json!(["0,0,0,1"]), "direction"),
        ("cut", json!(["cut"]), "direction"),
        ("opacity", json!(["0"]), "at most 1"),
        ("opacity", json!(["2"]), "at most 1"),
        ("opacity", json!(["not (mass)=0.5"]), "mass"),
        ("layers", json!(["65"]), "65"),
        ("layers", json!(["-1"]), "-1"),
        ("samples", json!(["9 --output x.png"]), "x.png"),
        ("background", json!(["url(http://x)"]), "url"),
        ("look", json!(["soft", "plain"]), "look"),
    ] {
        let options = json!({ id: values });
        for route in ["/frame", "/command", "/pick", "/fit"] {
            let body = json!({ "camera": scene["camera"], "size": [16, 12], "x": 1, "y": 1, "options": options });
            let reply = page.ask(route, &body);
            // The camera that fits a frame and the copied words do not read it again.
            let answers = [
                ("color_by", "/command"),
                ("opacity", "/command"),
                ("layers", "/fit"),
                ("cut", "/fit"),
                ("look", "/fit"),
                ("samples", "/fit"),
                ("background", "/fit"),
            ];
            if reply.status == 200 && answers.contains(&(id, route)) {
                continue;
            }
            let message = reply.json()["error"]["message"].as_str().unwrap_or_default().to_owned();
            assert!(reply.status == 400 && message.contains(word), "{route} {options}: {} {message}", reply.status);
        }
    }
    let names: Vec<String> = dir.files().into_keys().collect();
    assert!(!names.iter().any(|name| name.starts_with("x.")), "{names:?}");
    // The map that the command line names is one that the page may keep.
    let body =
        json!({ "camera": scene["camera"], "size": [16, 12], "options": { "color_by": ["x"], "map": ["own.csv"] } });
    assert_eq!(page.ask("/frame", &body).status, 200);
}
