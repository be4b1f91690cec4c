//! The promise of clouds of hits: a point for each hit in the order of the rays, at the position that .npz has, with its
//! sphere, ray and colour; the readers of halfline find the same points. `tests/independent/clouds.py` reads them by other
//! programs.

use crate::test_dir::TestDir;
use halfline::Scene;
use halfline_files::read::ReadOptions;
use serde_json::Value;
use std::io::Read;

/// Two spheres of two colours, the second without one, far from the origin by whole numbers.
fn scene(x: f64) -> String {
    format!(
        "[camera]\neye = [{x}, 0.0, 0.0]\nview = [0.0, 0.0, -1.0]\nup = [0.0, 1.0, 0.0]\nvfov = 60.0\n\n\
        [[sphere]]\ncenter = [{x}, 0.0, -3.0]\nradius = 1.0\ncolor = [0.9, 0.4, 0.2]\n\n\
        [[sphere]]\ncenter = [{}, 0.0, 0.0]\nradius = 1.25\n",
        x + 5.0
    )
}

const PATTERN: &str = "--pattern lidar:rings=5,vfov=-20..20,step=3";

/// The rings and the columns of the pattern.
const SHAPE: [usize; 2] = [5, 120];

/// The numbers of an array of the archive.
fn array(dir: &TestDir, name: &str, shape: &[usize]) -> Vec<f64> {
    let file = std::fs::File::open(dir.path("hits.npz")).expect("an archive");
    let mut zip = zip::ZipArchive::new(file).expect("an archive");
    let mut bytes = Vec::new();
    zip.by_name(&format!("{name}.npy")).expect(name).read_to_end(&mut bytes).expect("its bytes");
    dir.put("member.npy", bytes);
    let (values, found) = dir.array("member.npy");
    assert_eq!(found, shape, "{name}");
    values
}

/// A hit as the archive has it.
struct Hit {
    position: [f64; 3],
    distance: f64,
    id: f64,
    row: usize,
}

fn hits(dir: &TestDir) -> Vec<Hit> {
    let [position, distance, id] = ["position", "distance", "id"].map(|name| {
        let shape = if name == "position" { &[SHAPE[0], SHAPE[1], 3][..] } else { &SHAPE };
        array(dir, name, shape)
    });
    let hit = |row: usize| Hit {
        position: [0, 1, 2].map(|axis| position[3 * row + axis]),
        distance: distance[row],
        id: id[row],
        row,
    };
    let (found, missed): (Vec<_>, Vec<_>) = (0..id.len()).partition(|row| id[*row] >= 0.0);
    assert!(missed.iter().all(|row| position[3 * row..3 * row + 3].iter().all(|x| x.is_nan())), "misses have no place");
    found.into_iter().map(hit).collect()
}

/// Traces the pattern into every format; the reports of the clouds.
fn traced(x: f64) -> (TestDir, [Value; 3]) {
    let dir = TestDir::new(&[("s.toml", &scene(x))]);
    let run = |output: &str| dir.good(&format!("trace s.toml --backend cpu {PATTERN} -o {output} --json")).json();
    assert!(run("hits.npz")["cloud"].is_null());
    let reports = ["hits.ply", "hits.pcd", "hits.las"].map(run);
    (dir, reports)
}

fn read(dir: &TestDir, name: &str) -> Scene {
    halfline_files::read::scene(&dir.path(name), &ReadOptions::default()).expect(name).scene
}

/// The most that a coordinate may differ: nothing in PLY, half the last bit of f32, half a step of the finest grid, which
/// has 2^30 to 2^31 steps along the side.
#[test]
fn the_readers_find_the_points_of_the_archive() {
    let (dir, reports) = traced(0.0);
    let expected = hits(&dir);
    assert!(
        expected.len() > 50 && expected.iter().any(|hit| hit.id == 0.0) && expected.iter().any(|hit| hit.id == 1.0)
    );
    let side = |axis: usize| {
        let all = expected.iter().map(|hit| hit.position[axis]);
        all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
    };
    for (name, report) in ["hits.ply", "hits.pcd", "hits.las"].into_iter().zip(&reports) {
        let scene = read(&dir, name);
        let found = &scene.spheres;
        assert_eq!(found.len(), expected.len(), "{name}");
        let cloud = &report["cloud"];
        assert_eq!(cloud["points"], expected.len(), "{name}");
        assert_eq!(cloud["left_out"], SHAPE[0] * SHAPE[1] - expected.len(), "{name}");
        let rounding = cloud["rounding"].as_f64().expect("a number");
        let mut worst = 0.0f64;
        for (n, hit) in expected.iter().enumerate() {
            for axis in 0..3 {
                let (x, error) = (hit.position[axis], (found.centers[n][axis] - hit.position[axis]).abs());
                let most = match name {
                    "hits.ply" => 0.0,
                    "hits.pcd" => x.abs() * 2f64.powi(-24),
                    _ => side(axis) * 2f64.powi(-31),
                };
                assert!(error <= most, "{name}: point {n} is off by {error}, not {most}");
                worst = worst.max(error);
            }
            let colors = found.colors.as_ref().expect("colours");
            // The default colour is a grey of 0.8.
            let color: [f32; 3] = if hit.id == 0.0 { [0.9, 0.4, 0.2] } else { [0.8; 3] };
            for (found, given) in colors[n].iter().zip(color) {
                // A level of 8-bit sRGB is at most 2.4 / 255 wide in linear light.
                assert!((found - given).abs() < 0.5 * 2.4 / 255.0, "{name}: {found} for {given}");
            }
        }
        assert_eq!(worst, rounding, "{name}: the report says how far coordinates were moved");
        assert_eq!(report["warnings"].as_array().map(Vec::len), Some(0), "{report}");
    }
    assert!(
        reports[1]["cloud"]["rounding"].as_f64() > Some(0.0) && reports[2]["cloud"]["rounding"].as_f64() > Some(0.0)
    );
}

/// The fields that halfline's readers do not keep are found by the layout that each header states.
#[test]
fn every_field_has_the_number_of_the_archive() {
    let (dir, _) = traced(0.0);
    let expected = hits(&dir);
    let ply = dir.get("hits.ply");
    let end = b"end_header\n";
    let start = ply.windows(end.len()).position(|bytes| bytes == end).expect("an end") + end.len();
    let head = String::from_utf8(ply[..start].to_vec()).expect("text");
    let properties: Vec<&str> = head.lines().filter_map(|line| line.strip_prefix("property ")).collect();
    assert_eq!(
        properties,
        [
            "double x",
            "double y",
            "double z",
            "double distance",
            "int id",
            "uint ring",
            "uint column",
            "uchar red",
            "uchar green",
            "uchar blue"
        ]
    );
    let pcd = dir.get("hits.pcd");
    let end = b"DATA binary\n";
    let pcd_start = pcd.windows(end.len()).position(|bytes| bytes == end).expect("an end") + end.len();
    let head = String::from_utf8(pcd[..pcd_start].to_vec()).expect("text");
    assert!(head.contains("FIELDS x y z distance id ring column rgb\nSIZE 4 4 4 4 4 4 4 4\nTYPE F F F F I U U F\n"));
    let las = dir.get("hits.las");
    let las_start = u32::from_le_bytes(las[96..100].try_into().expect("four bytes")) as usize;
    let name = |n: usize| {
        let at = 375 + 54 + 192 * n + 4;
        String::from_utf8(las[at..at + 32].iter().copied().take_while(|byte| *byte != 0).collect()).expect("a name")
    };
    assert_eq!([0, 1, 2, 3].map(name), ["distance", "id", "ring", "column"]);
    let integers = |bytes: &[u8]| [0, 4, 8].map(|at| i32::from_le_bytes(bytes[at..at + 4].try_into().expect("four")));
    for (n, hit) in expected.iter().enumerate() {
        let places = [hit.id as i32, (hit.row / SHAPE[1]) as i32, (hit.row % SHAPE[1]) as i32];
        let row = &ply[start + 47 * n..][..47];
        assert_eq!(
            (f64::from_le_bytes(row[24..32].try_into().expect("eight")), integers(&row[32..])),
            (hit.distance, places)
        );
        let row = &pcd[pcd_start + 32 * n..][..32];
        let distance = f32::from_le_bytes(row[12..16].try_into().expect("four"));
        assert_eq!((distance, integers(&row[16..])), (hit.distance as f32, places));
        let row = &las[las_start + 56 * n..][..56];
        assert_eq!(
            (f64::from_le_bytes(row[36..44].try_into().expect("eight")), integers(&row[44..])),
            (hit.distance, places)
        );
    }
    assert_eq!(ply.len(), start + 47 * expected.len());
    assert_eq!(pcd.len(), pcd_start + 32 * expected.len());
    assert_eq!(las.len(), las_start + 56 * expected.len());
}

#[test]
fn rays_of_a_file_are_numbered_and_misses_are_reported() {
    let dir =
        TestDir::new(&[("s.toml", &scene(0.0)), ("rays.csv", "0,0,0,0,0,1\n0,0,0,0,0,-2\n0,0,0,0,0,0\n0,0,0,4,0,0\n")]);
    let run = |output: &str| {
        dir.good(&format!("trace s.toml --backend cpu --rays rays.csv --skip-invalid -o {output} --json"))
    };
    for name in ["a.ply", "a.pcd", "a.las"] {
        let done = run(name);
        assert!(done.err.contains(&format!("{name} has 2 points; 2 rays without a hit left out")), "{}", done.err);
        assert_eq!((&done.json()["cloud"]["points"], &done.json()["cloud"]["left_out"]), (&2.into(), &2.into()));
        let first = dir.get(name);
        run(name);
        assert!(dir.get(name) == first, "{name}: other bytes");
        let info = dir.good(&format!("info {name} --json")).json();
        assert_eq!(info["spheres"], 2, "{name}: {info}");
        if name != "a.las" {
            let column = |name: &str| [&info["columns"][name]["min"], &info["columns"][name]["max"]];
            assert_eq!(column("ray").map(Value::as_f64), [Some(1.0), Some(3.0)], "{info}");
            assert_eq!(column("id").map(Value::as_f64), [Some(0.0), Some(1.0)], "{info}");
        }
    }
    // Nothing is hit: a cloud without points.
    dir.put("rays.csv", "0,0,0,0,0,1\n");
    for name in ["a.ply", "a.pcd", "a.las"] {
        assert_eq!(run(name).json()["cloud"]["points"], 0);
        assert_eq!(dir.good(&format!("info {name} --json")).json()["spheres"], 0, "{name}");
    }
}

#[test]
fn coordinates_that_a_format_cannot_hold_are_reported() {
    // Ten thousand kilometres from the origin f32 has steps of a metre.
    let (dir, [ply, pcd, las]) = traced(1e7);
    let warnings = |report: &Value| {
        report["warnings"].as_array().expect("a list").iter().map(Value::to_string).collect::<String>()
    };
    assert!(
        warnings(&pcd).contains("hits.pcd are rounded by up to 0.4") && warnings(&pcd).contains("use .ply"),
        "{pcd}"
    );
    assert_eq!((warnings(&ply), warnings(&las)), (String::new(), String::new()));
    assert!(las["cloud"]["rounding"].as_f64().is_some_and(|x| x < 1e-8), "{las}");
    // Beyond f32, and farther apart than f64 can number.
    dir.put("far.toml", scene(0.0).replace("[5, 0.0, 0.0]\nradius = 1.25", "[1e39, 0.0, 0.0]\nradius = 1e38"));
    let trace = |words: &str| format!("trace far.toml --backend cpu {PATTERN} {words}");
    let refused = dir.run(&trace("-o a.pcd"));
    assert!(
        refused.code == 2
            && refused.err.contains("a.pcd cannot hold the hits: ")
            && refused.err.contains("e38 is beyond"),
        "{}",
        refused.err
    );
    assert!(refused.err.contains("use .ply"), "{}", refused.err);
    dir.good(&trace("-o a.las"));
    assert!(!dir.path("a.pcd").exists());
}
