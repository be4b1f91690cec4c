//! The promise of the camera: what is framed is in view beside the legend, directions and selections have the meaning that
//! the help gives them, and a legend shows what the colours mean. Cameras are checked against positions that are computed here.

use crate::data::real;
use crate::skip::skip;
use crate::test_dir::TestDir;
use serde_json::Value;

/// Atoms in a flat box of 30 x 8 x 16, its largest face towards y, in an order without a pattern.
fn flat() -> (String, Vec<[f64; 3]>) {
    let mut text = "120\nProperties=species:S:1:pos:R:3:velo:R:3\n".to_owned();
    let mut state = 7_u32;
    let mut next = |side: f64| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24) * side
    };
    let mut places = Vec::new();
    for n in 0..120 {
        let [x, y, z] = [next(30.0), next(8.0), next(16.0)];
        let velocity = n as f64 / 40.0 + 5.96e-6;
        text += &format!("{} {x} {y} {z} 0 {velocity} 0\n", ["C", "N", "O"][n % 3]);
        places.push([x, y, z]);
    }
    (text, places)
}

fn dir() -> (TestDir, Vec<[f64; 3]>) {
    let (text, places) = flat();
    (TestDir::new(&[("flat.xyz", &text)]), places)
}

fn numbers(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|k| value[k].as_f64().expect("a number"))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross([a, b, c]: [f64; 3], [d, e, f]: [f64; 3]) -> [f64; 3] {
    [b * f - c * e, c * d - a * f, a * e - b * d]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

/// The standard deviation of coordinates along a vector of unit length.
fn deviation(places: &[[f64; 3]], axis: [f64; 3]) -> f64 {
    let along: Vec<f64> = places.iter().map(|place| dot(*place, axis)).collect();
    let mean = along.iter().sum::<f64>() / along.len() as f64;
    (along.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / along.len() as f64).sqrt()
}

/// Eye, view and up of the camera of a report; view and up of unit length and perpendicular to each other.
fn camera(report: &Value) -> [[f64; 3]; 3] {
    let [eye, view, up] = ["eye", "view", "up"].map(|key| numbers(&report["camera"][key]));
    let unit = |a: [f64; 3]| a.map(|x| x / dot(a, a).sqrt());
    let view = unit(view);
    [eye, view, unit([0, 1, 2].map(|k| up[k] - dot(up, view) * view[k]))]
}

fn json(dir: &TestDir, words: &str) -> Value {
    dir.render(&format!("{words} --size 90x60 --json")).json()
}

/// The pixels that a legend covers are those in which a picture with it and one without differ, from the same camera.
#[test]
fn no_sphere_is_behind_the_legend_and_the_rest_is_filled() {
    let (dir, _) = dir();
    for size in ["300x200", "200x300"] {
        for (corner, options) in [
            ("right", "--color-by velo"),
            ("top-left", "--color-by velo"),
            ("top-right", ""),
            ("bottom-left", "--view right"),
            ("bottom-right", "--ortho --color-by x"),
            ("right", "--focus all --color 'index 0=red'"),
            ("top-left", "--at 'index 3'"),
        ] {
            let words: Vec<String> = options
                .split('\'')
                .enumerate()
                .flat_map(|(n, part)| {
                    if n % 2 == 1 {
                        vec![part.to_owned()]
                    } else {
                        part.split_whitespace().map(str::to_owned).collect()
                    }
                })
                .collect();
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            let plain = ["--look", "plain", "--background", "white", "--size", size];
            let legend = format!("--legend-in={corner}");
            dir.render(
                &[&["flat.xyz", &legend, "-o", "with.png", "--aov", "id=id.npy"][..], &plain[..], &words[..]].concat(),
            );
            let colors =
                words.iter().position(|word| word.starts_with("--color")).map_or(&[][..], |at| &words[at..at + 2]);
            let same = ["flat.xyz", "--camera-from", "with.png", "-o", "without.png"];
            dir.render(&[&same[..], &plain[..4], colors].concat());
            let ((with, shape), (without, _), (ids, _)) =
                (dir.array("with.png"), dir.array("without.png"), dir.array("id.npy"));
            let covered = |n: usize| with[3 * n..3 * n + 3] != without[3 * n..3 * n + 3];
            let behind = (0..ids.len()).filter(|n| covered(*n) && ids[*n] >= 0.0).count();
            assert!((0..ids.len()).filter(|n| covered(*n)).count() > 300, "{corner} {options}: there is a legend");
            assert_eq!(behind, 0, "{corner} {options} {size}: hits behind the legend");
            // All atoms are hit or hidden by others, and none is cut by the edge of the picture.
            let is_edge = |n: usize| {
                n.is_multiple_of(shape[1])
                    || (n + 1).is_multiple_of(shape[1])
                    || n < shape[1]
                    || n >= ids.len() - shape[1]
            };
            assert!((0..ids.len()).all(|n| !is_edge(n) || ids[n] < 0.0), "{corner} {options} {size}: cut");
            let columns: Vec<usize> = (0..ids.len()).filter(|n| ids[*n] >= 0.0).map(|n| n % shape[1]).collect();
            let free = shape[1] - (0..shape[1]).filter(|x| (0..shape[0]).any(|y| covered(y * shape[1] + x))).count();
            let wide = columns.iter().max().expect("hits") - columns.iter().min().expect("hits");
            let rows: Vec<usize> = (0..ids.len()).filter(|n| ids[*n] >= 0.0).map(|n| n / shape[1]).collect();
            let high = rows.iter().max().expect("hits") - rows.iter().min().expect("hits");
            // A perspective makes what is near larger; a focus has a margin of a quarter; a point need not be in the middle.
            let least = if options.contains("--at") { 0.4 } else { 0.65 };
            let filled = (wide as f64 / free as f64).max(high as f64 / shape[0] as f64);
            assert!(filled > least, "{corner} {options} {size}: {wide} of {free} x {high}");
        }
    }
}

#[test]
fn directions_in_words_are_those_of_the_help() {
    let (dir, places) = dir();
    let iso = 1.0 / 3.0_f64.sqrt();
    for (word, view, right) in [
        ("front", [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]),
        ("back", [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]),
        ("left", [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ("right", [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
        ("top", [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]),
        ("bottom", [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]),
        ("iso", [-iso; 3], [0.5_f64.sqrt(), 0.0, -(0.5_f64.sqrt())]),
    ] {
        let [eye, found, up] = camera(&json(&dir, &format!("flat.xyz --view {word}")));
        let across = cross(found, up);
        let close = |a: [f64; 3], b: [f64; 3]| dot(minus(a, b), minus(a, b)) < 1e-24;
        assert!(close(found, view) && close(across, right), "{word}: {found:?} {across:?}");
        // The eye is before all atoms; the largest atom has a radius of 1.7.
        assert!(places.iter().all(|place| dot(minus(*place, eye), found) > 1.7), "{word}");
    }
    // The largest face of the box is that towards y; its longest side is across the wider side of the image.
    for (size, tall) in [("90x60", false), ("60x90", true)] {
        for options in ["", "--view auto"] {
            let report = dir.render(&format!("flat.xyz {options} --size {size} --json")).json();
            let [_, view, up] = camera(&report);
            let across = cross(view, up);
            let [depth, down, wide] = [view, up, across].map(|axis| deviation(&places, axis));
            let [long, short] = if tall { [down, wide] } else { [wide, down] };
            assert!(depth < short && short < long && view[1] < -0.9, "{options} {size}: {depth} {down} {wide}");
        }
    }
    // A box of particles is seen as before.
    dir.put("a.csv", "x,y,z,radius\n0,0,0,1\n1,9,3,1\n4,5,9,1\n-3,5,2,1\n");
    let [_, view, up] = camera(&json(&dir, "a.csv"));
    assert_eq!([view, up], [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]);
    // A file's camera stays, but for a direction in words.
    dir.put(
        "s.toml",
        "[camera]\neye=[0,0,9]\nview=[0,0,-1]\nup=[0,1,0]\nvfov=40\n[[sphere]]\ncenter=[0,0,0]\nradius=1\n",
    );
    assert_eq!(camera(&json(&dir, "s.toml --view 1,0,-1"))[0], [0.0, 0.0, 9.0]);
    let [eye, view, _] = camera(&json(&dir, "s.toml --view right"));
    assert!(eye[0] > 2.0 && eye[2].abs() < 1e-9 && view[0] == -1.0, "{eye:?}");
    assert!(dir.render("flat.xyz --view auto --size 9x9 --json").json()["hits"].as_u64() > Some(0));
    let plan = dir.good("plan flat.xyz -o a.png --backend cpu --view auto --legend-in").text();
    assert!(plan.contains("frames all spheres, along its principal axes (--view auto), beside the legend"), "{plan}");
}

/// The point in the middle of a picture is the point of `--at`: the id of the atom there, or the way from the eye.
#[test]
fn what_is_looked_at_is_in_the_middle() {
    let (dir, places) = dir();
    let toward = |report: &Value, at: [f64; 3]| {
        let [eye, view, _] = camera(report);
        let way = minus(at, eye);
        dot(way, view) / dot(way, way).sqrt()
    };
    let [x, y, z] = places[17];
    let exact = |report: &Value, at: [f64; 3]| assert!(toward(report, at) > 1.0 - 1e-12, "{report}");
    let default = camera(&json(&dir, "flat.xyz"));
    let lone = json(&dir, &format!("flat.xyz --at {x},{y},{z}"));
    exact(&lone, places[17]);
    // The default direction; and from so far that all is seen.
    assert!(dot(camera(&lone)[1], default[1]) > 1.0 - 1e-12);
    let words = ["flat.xyz", "--at", "index 17", "--size", "90x60", "--json"];
    assert_eq!(dir.render(&words).json()["camera"], lone["camera"]);
    let both = dir.render(&[&words[..], &["--view", "0,-1,-1"]].concat()).json();
    exact(&both, places[17]);
    assert!(dot(camera(&both)[1], [0.0, -(0.5_f64.sqrt()), -(0.5_f64.sqrt())]) > 1.0 - 1e-12);
    let words = ["flat.xyz", "--at", "element O", "--view", "left", "--size", "90x60", "--json"];
    let oxygens: Vec<[f64; 3]> = places.iter().skip(2).step_by(3).copied().collect();
    let mean = [0, 1, 2].map(|k| oxygens.iter().map(|place| place[k]).sum::<f64>() / oxygens.len() as f64);
    exact(&dir.render(&words).json(), mean);
    for words in
        [vec!["--at", "index 17"], vec!["--at", "index 17", "--view", "1,2,3"], vec!["--at", "index 0", "--ortho"]]
    {
        dir.render(&[&["flat.xyz", "--size", "90x60", "--aov", "id=i.npy"][..], &words[..]].concat());
        let (ids, _) = dir.array("i.npy");
        let is_edge = |n: usize| n.is_multiple_of(90) || n % 90 == 89 || !(90..ids.len() - 90).contains(&n);
        assert!((0..ids.len()).all(|n| !is_edge(n) || ids[n] < 0.0), "{words:?}: cut");
    }
    // From an eye, the selection is the point to look at.
    exact(&dir.render(&["flat.xyz", "--at", "index 17", "--eye", "50,60,70", "--json"]).json(), places[17]);
}

/// A target in the middle of a shell of spheres with one hole: it is seen from there only.
#[test]
fn a_focus_is_framed_from_where_it_is_visible() {
    let (mut text, mut count) = (String::new(), 1);
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    // A direction that is none of the candidates.
    let hole = [0.36, -0.48, 0.8];
    for n in 0..400 {
        let z = 1.0 - (2.0 * f64::from(n) + 1.0) / 400.0;
        let [x, y] = [(golden * f64::from(n)).cos(), (golden * f64::from(n)).sin()].map(|k| k * (1.0 - z * z).sqrt());
        if dot([x, y, z], hole) < 0.5 {
            text += &format!("C {} {} {}\n", 4.0 * x, 4.0 * y, 4.0 * z);
            count += 1;
        }
    }
    let dir = TestDir::new(&[("shell.xyz", &format!("{count}\n\nH 0 0 0\n{text}"))]);
    let target = ["shell.xyz", "--focus", "element H", "--size", "90x60", "--json", "--aov", "id=i.npy"];
    let report = dir.render(&target).json();
    let [_, view, _] = camera(&report);
    assert!(dot(view, hole) < -0.85, "{view:?}");
    let (ids, _) = dir.array("i.npy");
    let visible = ids.iter().filter(|id| **id == 0.0).count();
    // Its disc, 3/4 of the height of 60 pixels across, has 1590 pixels.
    assert!((1400..1700).contains(&visible), "{visible}");
    assert!(report["warnings"].as_array().is_some_and(Vec::is_empty), "{report}");
    // From elsewhere it is hidden, which is words; the eye is not inside of an atom. Carbon has a radius of 1.7.
    for view in ["1,0,0", "front", "0,-1,0.2", "0.36,-0.48,0.8"] {
        let report = dir.render(&[&target[..], &["--view", view]].concat()).json();
        let [eye, ..] = camera(&report);
        let inside = text.lines().any(|line| {
            let place: Vec<f64> = line.split(' ').skip(1).map(|x| x.parse().expect("a number")).collect();
            let away = minus([place[0], place[1], place[2]], eye);
            dot(away, away) <= 1.7 * 1.7
        });
        assert!(!inside, "{view}: {eye:?}");
        let warning = report["warnings"].to_string();
        assert!(view == "front" || warning.contains("0 % of --focus is seen"), "{view}: {warning}");
    }
    // A plane opens the shell, one behind the focus does not, and one removes the focus.
    for (cut, words) in
        [("0,0,-1,1.5", ""), ("0,0,1,2.5", "0 % of --focus is seen"), ("0,0,-1,-2", "--cut removes all of --focus")]
    {
        let options = ["--view", "0,0,1", "--cut", cut];
        let report = dir.render(&[&target[..], &options].concat()).json();
        let warnings = report["warnings"].to_string();
        assert!(warnings.contains(words) && (warnings == "[]") == words.is_empty(), "{cut}: {warnings}");
        let visible = dir.array("i.npy").0.iter().filter(|id| **id == 0.0).count();
        assert_eq!(visible > 1000, words.is_empty(), "{cut}: {visible}");
    }
    dir.refused_render(2, &["shell.xyz", "--focus", "element U", "-o", "a.png"], &["--focus", "none of the", "H, C"]);
    dir.refused_render(2, &["shell.xyz", "--at", "element U", "-o", "a.png"], &["--at", "none of the", "H, C"]);
    // What is hidden is not looked at.
    let hidden = ["shell.xyz", "--focus", "element H", "--hide", "element H", "-o", "a.png"];
    dir.refused_render(2, &hidden, &["--focus", "none of the"]);
    let refused = ["shell.xyz", "--stream", "--focus", "element O", "-o", "a.npy"];
    dir.refused_render(2, &refused, &["--stream", "--focus"]);
    // A film keeps the camera of its first frame, also where a later one has nothing of the focus.
    dir.put("film.xyz", "2\n\nO 0 0 0\nC 5 0 0\n2\n\nC 0 0 0\nC 5 0 0\n");
    for hold in ["first", "all"] {
        let words = ["film.xyz", "--frames", "1-2", "--hold", hold, "--focus", "element O", "--json", "--size", "9x9"];
        let film = dir.render(&words).text();
        let cameras: Vec<Value> =
            film.lines().map(|line| serde_json::from_str::<Value>(line).expect("JSON")["camera"].clone()).collect();
        assert!(cameras.len() == 2 && cameras[0] == cameras[1], "{hold}: {cameras:?}");
    }
}

/// A stream reads the file once more for the axes, and has the camera and the legend of the scene in memory.
#[test]
fn a_stream_has_the_camera_and_the_legend_of_memory() {
    let (dir, places) = dir();
    // More than a block, 2^18 spheres, so that sums go on from one to the next; the second has another element.
    let count = (1 << 18) + 500;
    let mut large = format!("{count}\n\n");
    for n in 0..count {
        let [x, y, z] = places[n % places.len()];
        let shift = (n / places.len()) as f64;
        large += &format!("{} {} {} {}\n", if n < (1 << 18) { "C" } else { "B" }, x + 0.1 * shift, y, z + 0.01 * shift);
    }
    dir.put("large.xyz", &large);
    dir.put("none.csv", "x,y,z,radius\n");
    for (file, options) in [
        ("flat.xyz", ""),
        ("flat.xyz", "--legend-in=top-left"),
        ("flat.xyz", "--color-by velocity --range 0,3 --legend-in --at 1,2,3"),
        ("flat.xyz", "--view right"),
        ("flat.xyz", "--view auto --up 0,0,1"),
        ("large.xyz", "--legend-in"),
        // The ball around all spheres, not those around the spheres of a block.
        ("large.xyz", "--spin 1"),
        ("none.csv", ""),
    ] {
        let words = format!("{file} --look plain --samples 1 --size 200x120 {options} --aov id,depth=d.npz -o");
        let picture = |name: &str, stream: &str| {
            dir.render(&format!("{words} {name} {stream}"));
            [dir.get(name), dir.get("d.npz")]
        };
        assert!(picture("a.png", "") == picture("b.png", "--stream"), "{file} {options}");
    }
}

/// The rows of a legend in the picture are in its provenance.
#[test]
fn a_legend_shows_elements_and_the_colours_of_selections() {
    let (dir, _) = dir();
    let drawn = |words: &[&str]| {
        dir.render(&[&["flat.xyz", "--size", "300x200", "-o", "a.png"][..], words].concat());
        String::from_utf8_lossy(&dir.get("a.png")).into_owned()
    };
    let elements = drawn(&["--legend-in"]);
    assert!(elements.contains("legend right: element, C, N, O"), "no --color-by");
    let drawn_with = drawn(&["--legend-in", "--color", "element O=#ff00ff", "--color", "index 0=blue"]);
    // Every oxygen has another colour now, so none has the colour of its element.
    assert!(drawn_with.contains("legend right: element, C, N, element O, index 0 ["), "rows of selections");
    assert!(drawn_with.contains("[255, 0, 255] [0, 0, 255]"), "their colours");
    let bar = drawn(&["--legend-in", "--color-by", "velo", "--color", "index 0=blue", "--color", "index 0=red"]);
    assert!(bar.contains("|velocity|, 2, 1, 0, index 0, Viridis"), "one row: the later rule wins");
    let only = drawn(&["--legend-in", "--color", "gray", "--color", "index 0=blue"]);
    assert!(only.contains("legend right: selection, index 0 [0, 0, 255]"), "without other colours");
    dir.render(&[
        "flat.xyz",
        "-o",
        "a.png",
        "--legend",
        "l.svg",
        "--color",
        "velocity < 1=red",
        "--color-by",
        "velocity",
    ]);
    let svg = String::from_utf8(dir.get("l.svg")).expect("UTF-8");
    assert!(
        [">|velocity|<", ">0<", ">1<", ">2<", ">velocity &lt; 1<", "#ff0000"].iter().all(|part| svg.contains(part)),
        "{svg}"
    );
    let bare = ["flat.xyz", "--color", "red", "--legend-in", "-o", "a.png"];
    dir.refused_render(2, &bare, &["--legend-in", "neither elements", "--color-by"]);
}

#[test]
fn the_velocity_has_one_name_in_all_formats() {
    let dir = TestDir::new(&[
        ("a.xyz", "2\nProperties=species:S:1:pos:R:3:velo:R:3\nC 0 0 0 2 3 6\nC 5 0 0 0 0 0\n"),
        ("b.xyz", "2\nProperties=species:S:1:pos:R:3:velocity:R:3\nC 0 0 0 2 3 6\nC 5 0 0 0 0 0\n"),
        ("c.csv", "x,y,z,radius,vx,vy,vz\n0,0,0,1,2,3,6\n5,0,0,1,0,0,0\n"),
        (
            "d.dump",
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 9\n0 9\n0 9\n\
             ITEM: ATOMS id x y z radius vx vy vz\n1 0 0 0 1 2 3 6\n2 5 0 0 1 0 0 0\n",
        ),
    ]);
    for (file, other) in [("a.xyz", "velo"), ("b.xyz", "velocity"), ("c.csv", "vx,vy,vz"), ("d.dump", "vz,vy,vx")] {
        let picture = |column: &str| {
            dir.render(&format!("{file} --size 40x20 --color-by {column} -o a.png --legend l.svg"));
            (dir.array("a.png"), String::from_utf8(dir.get("l.svg")).expect("UTF-8"))
        };
        let (found, legend) = picture("velocity");
        assert_eq!(picture(other), (found, legend.clone()), "{file}");
        assert!(
            [">|velocity|<", ">0<", ">2<", ">4<", ">6<"].iter().all(|part| legend.contains(part)),
            "{file}: {legend}"
        );
        let info = dir.good(&["info", file, "--json"]).json();
        let column = &info["columns"]["velocity"];
        assert_eq!((column["min"].as_f64(), column["max"].as_f64()), (Some(0.0), Some(7.0)), "{file}: {info}");
        dir.render(&[file, "--select", "velocity > 5", "--json", "--size", "9x9"]);
        let report = dir.render(&[file, "--select", "velocity > 5", "--json", "--size", "9x9"]).json();
        assert_eq!(report["spheres"], 1, "{file}");
    }
}

/// In 3SN6 the ligand is the one residue of HETATM records; in 1tii these are waters.
#[test]
fn ligands_and_metals_of_real_files_are_those_of_their_text() {
    let (Some(cif), Some(pdb)) = (real("3SN6.cif"), real("1tii.pdb")) else {
        skip("3SN6.cif or 1tii.pdb is not there".to_owned());
        return;
    };
    let dir = TestDir::new(&[]);
    let spheres = |file: &str, expression: &str| {
        dir.render(&[file, "--select", expression, "--json", "--size", "9x9"]).json()["spheres"]
            .as_u64()
            .expect("a count")
    };
    let text = std::fs::read_to_string(&cif).expect("a file");
    let of_text = text.lines().filter(|line| line.starts_with("HETATM")).count() as u64;
    let cif = cif.to_str().expect("UTF-8");
    assert_eq!((spheres(cif, "ligand"), spheres(cif, "metal")), (of_text, 0));
    assert!(of_text > 20);
    let pdb = pdb.to_str().expect("UTF-8");
    assert_eq!((spheres(pdb, "ligand"), spheres(pdb, "metal")), (0, 0));
    // The pocket at the first try: a good part of the picture shows the ligand.
    dir.render(&[cif, "--focus", "ligand", "--size", "120x90", "--aov", "id=i.npy"]);
    let ligand = |ids: &[f64]| {
        let first = text.lines().filter(|line| line.starts_with("ATOM") || line.starts_with("HETATM"));
        let kinds: Vec<bool> = first.map(|line| line.starts_with("HETATM")).collect();
        ids.iter().filter(|id| **id >= 0.0 && kinds[**id as usize]).count()
    };
    let (ids, _) = dir.array("i.npy");
    let visible = ligand(&ids);
    assert!(visible > ids.len() / 20, "{visible} of {} pixels", ids.len());
}

/// With the farthest spheres left out of the file, the camera is the same, in films of one camera for all frames too.
#[test]
fn a_share_of_the_spheres_is_framed() {
    let cloud = |frame: u32| {
        let points = (0..38).map(|n| f64::from(n * 7919 % 101) / 25.0 + f64::from(frame));
        let rows = points
            .zip(0..)
            .map(|(x, n)| format!("Ar {x} {} {}\n", f64::from(n * 31 % 17) / 4.0, f64::from(n * 13 % 7)));
        format!("40\n\nAr 9000 {frame} 0\n{}Ar 0 -7000 3\n", rows.collect::<String>())
    };
    let dir = TestDir::new(&[("a.xyz", &format!("{}{}", cloud(1), cloud(2)))]);
    let camera = |options: &str| json(&dir, &format!("a.xyz --radius 1 {options}"))["camera"].clone();
    for lens in ["--view 1,2,3", "--ortho --view front"] {
        let near = camera(&format!("{lens} --hide x>1000 --hide y<-1000"));
        assert_eq!(camera(&format!("{lens} --frame-share 95%")), near, "{lens}");
        assert_ne!(camera(lens), near, "{lens}");
    }
    let film = |options: &str| {
        let text = dir.render(&format!("a.xyz --radius 1 --frames 1-2 --hold all --size 90x60 --json {options}"));
        text.json_lines().iter().map(|report| report["camera"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(film("--frame-share 0.95"), film("--hide x>1000 --hide y<-1000"));
    for (options, words) in [
        ("--frame-share 0 -o a.png", "at most 1"),
        ("--frame-share 101% -o a.png", "99%"),
        ("--frame-share 0.5 --eye 0,0,9 -o a.png", "--eye"),
        ("--frame-share 0.5 --focus all -o a.png", "--focus"),
        ("--frame-share 0.5 --stream -o a.png", "--frame-share"),
    ] {
        dir.refused_render(2, &format!("a.xyz --radius 1 {options}"), &[words]);
    }
}
