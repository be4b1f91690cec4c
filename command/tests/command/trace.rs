//! The promise of `halfline trace`: rays in any of the forms give the same hits, in the order of the rays and independent
//! of blocks; invalid rows are named or counted; a file of hits is written completely or not at all.

use crate::numpy::{npy_of, python_or_skip};
use crate::test_dir::{Output, TestDir};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::process::{Command, Stdio};
#[cfg(target_os = "linux")]
use std::time::{Duration, Instant};

/// Two unit spheres behind each other on -z, one on the right, and a camera for patterns.
const SCENE: &str = "[camera]\neye = [0.0, 0.0, 0.0]\nview = [0.0, 0.0, -1.0]\nup = [0.0, 1.0, 0.0]\nvfov = 60.0\n
[[sphere]]\ncenter = [0.0, 0.0, -3.0]\nradius = 1.0\n
[[sphere]]\ncenter = [0.0, 0.0, -6.0]\nradius = 1.0\n
[[sphere]]\ncenter = [5.0, 0.0, 0.0]\nradius = 1.0\n";

/// Rays with limits, and the sphere and t that each hits.
const RAYS: [([f64; 7], i32, f64); 9] = [
    ([0.0, 0.0, 0.0, 0.0, 0.0, -1.0, f64::INFINITY], 0, 2.0),
    ([0.0, 0.0, 0.0, 0.0, 0.0, -4.0, f64::INFINITY], 0, 0.5),
    ([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, f64::INFINITY], -1, f64::INFINITY),
    ([0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 1.999], -1, f64::INFINITY),
    ([0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 2.001], 0, 2.0),
    ([0.0, 0.0, 0.0, 0.0, 0.0, -1.0, -3.0], -1, f64::INFINITY),
    ([0.0, 0.0, -9.0, 0.0, 0.0, 1.0, f64::INFINITY], 1, 2.0),
    ([5.0, 0.0, 0.0, 1.0, 0.0, 0.0, f64::INFINITY], 2, 1.0),
    ([0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.0], -1, f64::INFINITY),
];

fn npy(dtype: &str, width: usize, rows: &[[f64; 7]]) -> Vec<u8> {
    let numbers = rows.iter().flat_map(|row| &row[..width]);
    let data: Vec<u8> = match dtype {
        "<f4" => numbers.flat_map(|x| (*x as f32).to_le_bytes()).collect(),
        _ => numbers.flat_map(|x| x.to_le_bytes()).collect(),
    };
    npy_of(dtype, "False", &format!("({}, {width})", rows.len()), &data)
}

fn rows() -> Vec<[f64; 7]> {
    RAYS.iter().map(|(row, ..)| *row).collect()
}

fn csv(header: &str, delimiter: &str, rows: &[[f64; 7]]) -> String {
    let line = |row: &[f64; 7]| row.map(|x| x.to_string()).join(delimiter) + "\n";
    header.to_owned() + &rows.iter().map(line).collect::<String>()
}

fn dir() -> TestDir {
    let dir = TestDir::new(&[("s.toml", SCENE), ("rays.csv", &csv("", ",", &rows()))]);
    dir.put("rays.npy", npy("<f8", 7, &rows()));
    dir
}

/// Traces on the CPU path; the command must succeed.
fn trace(dir: &TestDir, words: &str) -> Output {
    dir.good(&on_cpu(words))
}

fn on_cpu(words: &str) -> String {
    format!("trace s.toml --backend cpu {words}")
}

/// The arrays of an archive and their shapes, by name.
fn npz(dir: &TestDir, name: &str) -> BTreeMap<String, (Vec<f64>, Vec<usize>)> {
    let file = std::fs::File::open(dir.path(name)).expect("an archive");
    let mut zip = zip::ZipArchive::new(file).expect("an archive");
    let (other, count) = (TestDir::new(&[]), zip.len());
    let array = |index| {
        let mut member = zip.by_index(index).expect("a member");
        let mut bytes = Vec::new();
        member.read_to_end(&mut bytes).expect("its bytes");
        other.put("a.npy", bytes);
        (member.name().expect("a name").trim_end_matches(".npy").to_owned(), other.array("a.npy"))
    };
    (0..count).map(array).collect()
}

/// The lines of CSV as numbers.
fn table(text: &str) -> Vec<Vec<f64>> {
    let number = |word: &str| word.parse().unwrap_or_else(|_| panic!("{word}"));
    text.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect()
}

#[test]
fn every_form_of_rays_gives_the_same_hits() {
    let dir = dir();
    let hits = trace(&dir, "--rays rays.npy -o -").text();
    assert_eq!(hits.lines().next(), Some("id,t,distance,nx,ny,nz,certainty"));
    for ((ray, id, t), row) in RAYS.iter().zip(table(&hits)) {
        let length = ray[3..6].iter().map(|x| x * x).sum::<f64>().sqrt();
        assert_eq!(row[0], f64::from(*id), "{ray:?}");
        let close = |found: f64, expected: f64| found == expected || (found / expected - 1.0).abs() < 1e-5;
        assert!(close(row[1], *t) && close(row[2], t * length), "{ray:?}: {row:?}");
        let normal: f64 = row[3..6].iter().map(|x| x * x).sum();
        assert!(if *id < 0 { normal == 0.0 } else { (normal - 1.0).abs() < 1e-5 }, "{row:?}");
        // Against the ray.
        let along: f64 = row[3..6].iter().zip(&ray[3..6]).map(|(n, d)| n * d).sum();
        assert!(*id < 0 || along < 0.0, "{row:?}");
    }

    dir.put("4.npy", npy("<f4", 7, &rows()));
    dir.put("named.csv", csv("ox,oy,oz,dx,dy,dz,tmax\n", ",", &rows()));
    let turned: Vec<_> = rows().iter().map(|[a, b, c, d, e, f, t]| [*t, *f, *e, *d, *c, *b, *a]).collect();
    dir.put("turned.csv", csv("# made by hand\n\nTMAX\tDZ\tDY\tDX\tOZ\tOY\tOX\n", "\t", &turned));
    dir.put("blanks.txt", csv("# ox oy oz dx dy dz tmax\n", "  ", &rows()));
    let mut gz = GzEncoder::new(Vec::new(), Compression::fast());
    gz.write_all(&dir.get("rays.npy")).expect("in memory");
    dir.put("rays.npy.gz", gz.finish().expect("in memory"));
    for name in ["rays.csv", "4.npy", "named.csv", "turned.csv", "blanks.txt", "rays.npy.gz"] {
        assert_eq!(trace(&dir, &format!("--rays {name} -o -")).text(), hits, "{name}");
    }
    for name in ["rays.npy", "rays.csv", "rays.npy.gz"] {
        let fed = dir.run_fed(&on_cpu("--rays - -o -"), &dir.get(name));
        assert_eq!((fed.code, fed.text()), (0, hits.clone()), "{name}: {}", fed.err);
    }

    // Without limits.
    dir.put("6.npy", npy("<f8", 6, &rows()));
    let ids: Vec<_> = table(&trace(&dir, "--rays 6.npy -o -").text()).iter().map(|row| row[0]).collect();
    assert_eq!(ids, [0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0]);

    let any = trace(&dir, "--rays rays.npy --any -o -").text();
    assert_eq!(any.lines().next(), Some("hit,certainty"));
    let hit: Vec<_> = table(&any).iter().map(|row| row[0]).collect();
    let expected: Vec<_> = RAYS.iter().map(|(_, id, _)| f64::from(u8::from(*id >= 0))).collect();
    assert_eq!(hit, expected);
}

#[test]
fn an_archive_has_the_columns_of_the_table() {
    let dir = dir();
    for (words, file) in [("", "hits.npz"), ("", "hits.csv"), ("--any", "any.npz"), ("--any", "any.csv")] {
        trace(&dir, &format!("--rays rays.npy {words} -o {file}"));
    }
    let table = table(&String::from_utf8(dir.get("hits.csv")).expect("text"));
    let column = |first: usize, count: usize| table.iter().flat_map(|row| row[first..first + count].to_vec()).collect();
    let arrays = npz(&dir, "hits.npz");
    assert_eq!(arrays.keys().collect::<Vec<_>>(), ["certainty", "distance", "id", "normal", "position", "t"]);
    for (name, first, count) in [("id", 0, 1), ("t", 1, 1), ("distance", 2, 1), ("normal", 3, 3), ("certainty", 6, 1)] {
        let (values, shape) = &arrays[name];
        // Text has the fewest digits that give an f32 again.
        let same =
            values.iter().zip::<Vec<f64>>(column(first, count)).all(|(a, b)| *a == b || *a == f64::from(b as f32));
        assert!(same, "{name}: {values:?}");
        assert_eq!(*shape, if count == 3 { vec![RAYS.len(), 3] } else { vec![RAYS.len()] }, "{name}");
    }
    let any = npz(&dir, "any.npz");
    assert_eq!(any.len(), 2);
    assert_eq!(any["hit"].0, arrays["id"].0.iter().map(|id| f64::from(u8::from(*id >= 0.0))).collect::<Vec<_>>());
    assert_eq!(any["certainty"].1, [RAYS.len()]);

    dir.put("none.npy", npy("<f8", 7, &[]));
    assert!(trace(&dir, "--rays none.npy -o none.npz").err.contains("warning: there are no rays"));
    assert_eq!(npz(&dir, "none.npz")["normal"].1, [0, 3]);
    let (positions, shape) = &arrays["position"];
    assert_eq!(*shape, [RAYS.len(), 3]);
    for (n, (ray, ..)) in RAYS.iter().enumerate() {
        for axis in 0..3 {
            let (found, t) = (positions[3 * n + axis], arrays["t"].0[n]);
            let expected = if t.is_finite() { ray[axis] + t * ray[3 + axis] } else { f64::NAN };
            assert!(found == expected || found.is_nan() && expected.is_nan(), "ray {n}: {found}, not {expected}");
        }
    }
}

/// NumPy reads the types of the contract.
#[test]
fn numpy_reads_the_archive() {
    let Some(python) = python_or_skip() else { return };
    let dir = dir();
    trace(&dir, "--rays rays.npy -o hits.npz");
    let script = "import numpy as n,sys; z=n.load(sys.argv[1]); \
        print([(k, str(z[k].dtype), z[k].shape) for k in z.files], z['id'].tolist())";
    let output = Command::new(&python).args(["-c", script]).arg(dir.path("hits.npz")).output().expect("python runs");
    let types = "[('id', 'int32', (9,)), ('t', 'float64', (9,)), ('distance', 'float64', (9,)), \
        ('normal', 'float32', (9, 3)), ('position', 'float64', (9, 3)), ('certainty', 'uint8', (9,))]";
    let ids: Vec<_> = RAYS.iter().map(|(_, id, _)| *id).collect();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(String::from_utf8_lossy(&output.stdout), format!("{types} {ids:?}\n"), "{stderr}");
}

/// More rays than a block has, and the same rays in two files.
#[test]
fn the_order_of_rays_is_kept_and_blocks_change_nothing() {
    let dir = dir();
    let beams = "--pattern lidar:rings=300,vfov=-20..20,step=0.02,azimuth=-20..20,range=5.5";
    let report = trace(&dir, &format!("{beams} --rays-out all.npy -o all.csv --json")).json();
    assert_eq!((&report["pattern"]["rings"], &report["pattern"]["azimuths"]), (&300.into(), &2001.into()));
    let (values, shape) = dir.array("all.npy");
    assert_eq!(shape, [600_300, 7]);
    assert!(report["trace_ms"].as_array().expect("a list").len() > 1, "several blocks: {report}");
    let rows: Vec<[f64; 7]> = values.as_chunks::<7>().0.to_vec();
    let all = String::from_utf8(dir.get("all.csv")).expect("text");
    assert_eq!(all.lines().count(), 600_301);

    let (first, second) = rows.split_at(123_456);
    let mut parts = String::new();
    for half in [first, second] {
        dir.put("half.npy", npy("<f8", 7, half));
        let text = trace(&dir, "--rays half.npy -o -").text();
        parts += if parts.is_empty() { &text } else { &text[1 + text.find('\n').expect("a header")..] };
    }
    assert!(parts == all, "two files together");
    trace(&dir, "--rays all.npy -o npy.npz");
    trace(&dir, &format!("{beams} -o pattern.npz"));
    // The same numbers, in the shape of the pattern.
    let (flat, shaped) = (npz(&dir, "npy.npz"), npz(&dir, "pattern.npz"));
    for (name, (values, shape)) in &flat {
        let equal = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        assert!(values.iter().zip(&shaped[name].0).all(equal), "{name}");
        assert_eq!(shaped[name].1, [&[300, 2001], &shape[1..]].concat(), "{name}");
    }
    // The other way round.
    let reversed: Vec<_> = rows.iter().rev().copied().collect();
    dir.put("reversed.npy", npy("<f8", 7, &reversed));
    let text = trace(&dir, "--rays reversed.npy -o -").text();
    assert!(text.lines().skip(1).eq(all.lines().skip(1).collect::<Vec<_>>().into_iter().rev()), "reversed");

    // The middle column of the middle rings looks at the first sphere.
    let arrays = npz(&dir, "npy.npz");
    let (ids, t) = (&arrays["id"].0, &arrays["t"].0);
    let middle = 150 * 2001 + 1000;
    assert!(ids[middle] == 0.0 && (t[middle] - 2.0).abs() < 1e-3, "{} {}", ids[middle], t[middle]);
    assert!(ids[0] < 0.0 && ids[600_299] < 0.0 && !ids.contains(&1.0), "the second sphere is hidden");
}

#[test]
fn the_beams_of_a_pattern_follow_the_pose() {
    let dir = dir();
    let ids = |words: &str| -> Vec<f64> {
        table(&trace(&dir, &format!("--pattern {words} -o -")).text()).iter().map(|row| row[0]).collect()
    };
    // Behind, left, ahead, right.
    assert_eq!(ids("lidar:rings=1,step=90"), [-1.0, -1.0, 0.0, 2.0]);
    assert_eq!(ids("lidar:rings=1,step=90,range=3"), [-1.0, -1.0, 0.0, -1.0]);
    assert_eq!(ids("lidar:rings=1,step=90 --view 1,0,0"), [-1.0, 0.0, 2.0, -1.0]);
    assert_eq!(ids("lidar:rings=1,step=90 --up 0,-1,0"), [-1.0, 2.0, 0.0, -1.0]);
    assert_eq!(ids("lidar:rings=1,step=90 --eye 0,0,-9"), [1.0, -1.0, -1.0, -1.0]);
    // The highest ring comes first; the view is down.
    assert_eq!(ids("lidar:rings=3,vfov=-60..60,step=360,azimuth=0 --eye 0,3,-3 --view 0,0,-1"), [-1.0, -1.0, -1.0]);
    assert_eq!(ids("lidar:rings=3,vfov=-90..90,step=360,azimuth=0 --eye 0,3,-3 --view 0,0,-1"), [-1.0, -1.0, 0.0]);

    // A particle file has no camera.
    dir.put("p.csv", "x,y,z,radius\n0,0,-3,1\n");
    let pattern = ["trace", "p.csv", "--backend", "cpu", "-o", "-", "--pattern", "lidar:rings=1,step=90"];
    dir.refused(2, &pattern, &["no camera", "--eye"]);
    let posed = [&pattern[..], &["--eye", "0,0,0"]].concat();
    assert_eq!(table(&dir.good(&posed).text())[2][0], 0.0);
}

#[test]
fn an_invalid_row_is_named_or_counted() {
    let dir = dir();
    let bad = |place: usize, x: f64| {
        let mut all = rows();
        all[3][place] = x;
        all
    };
    let mut zero = rows();
    zero[3][3..6].fill(0.0);
    for (rows, message) in [
        (bad(0, f64::NAN), "origin"),
        (bad(4, f64::INFINITY), "direction"),
        (zero, "the direction is zero"),
        (bad(6, f64::NAN), "NaN"),
    ] {
        dir.put("bad.npy", npy("<f8", 7, &rows));
        dir.put("bad.csv", csv("ox,oy,oz,dx,dy,dz,tmax\n", ",", &rows));
        for (name, place) in [("bad.npy", "bad.npy: row 3 (from 0) "), ("bad.csv", "bad.csv:5:1: ")] {
            for output in ["hits.npz", "hits.csv"] {
                let words = on_cpu(&format!("--rays {name} -o {output}"));
                dir.refused(3, &words, &[place, message, "--skip-invalid"]);
            }
            let report = trace(&dir, &format!("--rays {name} --skip-invalid -o hits.npz --json")).json();
            assert_eq!((&report["rays"], &report["invalid"], &report["hits"]), (&9.into(), &1.into(), &5.into()));
            let warning = report["warnings"][0].as_str().expect("a warning");
            assert!(
                warning.contains("1 of 9 rays") && warning.contains(place) && warning.contains(message),
                "{warning}"
            );
            let arrays = npz(&dir, "hits.npz");
            let expected: Vec<_> = RAYS.iter().map(|(_, id, _)| f64::from(*id)).collect();
            assert_eq!(arrays["id"].0, expected, "the invalid row is a miss, as it was");
            assert_eq!(arrays["certainty"].0[3], 255.0);
            assert_eq!((arrays["t"].0[3], &arrays["normal"].0[9..12]), (f64::INFINITY, &[0.0; 3][..]));
            dir.remove("hits.npz");
        }
    }
    let text = csv("", ",", &rows());
    let refused = |text: &str, message: &[&str]| {
        dir.put("bad.csv", text);
        dir.refused(3, &on_cpu("--rays bad.csv -o hits.csv"), message);
    };
    refused(&text.replacen(",-4,", ",", 1), &["bad.csv:2:", "expected 7 numbers, found 6"]);
    refused(&text.replacen(",-4,", ",-4,-4,", 1), &["bad.csv:2:", "more than the 7 numbers"]);
    refused(&text.replacen(",-4,", ",four,", 1), &["bad.csv:2:11: dz: `four` is not a number"]);
    refused("ox,oy,oz,dx,dy,dz,t\n", &["bad.csv:1:19: header: unknown column `t`", "tmax"]);
    refused("", &["bad.csv: the file has no rays"]);
    dir.put("bad.csv", text.replacen(",-4,", ",", 1) + "1,2,3,a,b,c,d\n");
    let any = trace(&dir, "--rays bad.csv --skip-invalid --any -o -").text();
    let expected = [[1, 0], [0, 255], [0, 0], [0, 0], [1, 0], [0, 0], [1, 0], [1, 0], [0, 0], [0, 255]];
    let found: Vec<_> = table(&any).iter().map(|row| [row[0], row[1]]).collect();
    assert_eq!(found.len(), 10);
    for (n, (found, [hit, certainty])) in found.iter().zip(expected).enumerate() {
        assert!(found[0] == f64::from(hit) && (certainty == 0 || found[1] == 255.0), "{n}: {found:?}");
    }

    dir.remove("bad.csv");
    // Rows of 56 bytes: a half of the fourth is there.
    let whole = dir.get("rays.npy");
    let cut = &whole[..whole.len() - 5 * 56 - 28];
    dir.put("bad.npy", cut);
    dir.refused(3, &on_cpu("--rays bad.npy -o hits.npz"), &["bad.npy: data: the file ends after 3 of 9 rows"]);
    dir.put("bad.npy", npy("<c8", 7, &rows()));
    dir.refused(3, &on_cpu("--rays bad.npy -o hits.npz"), &["dtype", "floats of at most 8 bytes"]);
    dir.refused(8, &on_cpu("--rays none.npy -o hits.npz"), &["cannot read none.npy"]);
    // A pipe is known to be too short only at its end.
    let fed = dir.run_fed(&on_cpu("--rays - -o hits.npz"), cut);
    assert!(
        fed.code == 3 && fed.err.contains("ends after 3 of 9 rows") && !dir.path("hits.npz").exists(),
        "{}",
        fed.err
    );
}

#[test]
fn invalid_arguments_are_exit_code_2() {
    let dir = dir();
    dir.put("two.xyz", "1\nH\nH 0 0 0\n".repeat(2));
    let refused = |words: &str, message: &[&str]| dir.refused(2, &format!("trace {words}"), message);
    refused("s.toml -o a.npz", &["--rays", "--pattern"]);
    refused("s.toml --rays rays.npy --pattern lidar:rings=1,step=1 -o a.npz", &["--rays", "--pattern"]);
    refused("s.toml --rays rays.npy", &["no output is requested", "--json"]);
    refused("s.toml --rays rays.npy -o a.npy", &["a.npy", ".npz or .csv", ".ply, .pcd or .las"]);
    refused("s.toml --rays rays.npy -o a.las --any", &["a.las is a point cloud", "remove --any"]);
    refused("s.toml --rays rays.npy -o a", &["a cannot hold hits"]);
    refused("s.toml --rays rays.npy -o a.npz --eye 0,0,0", &["--eye", "--pattern"]);
    refused("s.toml --rays rays.npy -o a.npz --rays-out b.npy", &["--rays-out", "--rays <FILE>"]);
    refused("s.toml --pattern lidar:rings=1,step=1 -o a.npz --skip-invalid", &["--skip-invalid"]);
    refused("s.toml --pattern lidar:rings=1,step=1 -o a.npz --rays-out b.csv", &["b.csv", ".npy"]);
    refused("s.toml --pattern lidar:rings=1,step=0 -o a.npz", &["step", "degrees"]);
    refused("s.toml --pattern radar -o a.npz", &["no pattern `radar`", "lidar:"]);
    refused("- --rays - -o a.npz", &["standard input"]);
    refused("two.xyz --rays rays.npy --frames 1-2 -o a.npz", &["one frame", "--frames"]);
    refused("s.toml --rays rays.npy -o a.npz --backend cpu --search tiles", &["tiles", "tree"]);
    refused("s.toml --rays rays.npy -o a.npz --backend cpu --accuracy exact --method unit", &["unit", "--method"]);
    for output in ["-", "/dev/stdout"].into_iter().take(if cfg!(unix) { 2 } else { 1 }) {
        refused(&format!("s.toml --rays rays.npy --json -o {output}"), &["standard output"]);
        refused(&format!("s.toml --rays rays.npy --progress openjd -o {output}"), &["standard output"]);
    }

    let read = "would be overwritten";
    dir.put("rays.npz", "");
    dir.put("s.csv", SCENE);
    refused("s.toml --rays rays.csv -o rays.csv", &["rays.csv is an input", read]);
    refused("s.toml --rays rays.csv -o ./rays.csv", &["is the input rays.csv", read]);
    refused("s.csv --format toml --rays rays.npy -o s.csv", &["s.csv is an input", read]);
    dir.put("list.csv", "x,y,z,radius\n0,0,-3,1\n");
    dir.put("named.toml", format!("{SCENE}\n[[spheres]]\nfile = \"list.csv\"\n"));
    refused("named.toml --rays rays.npy --backend cpu -o list.csv", &["list.csv is an input", read]);
    dir.put("n.npy", npy("<f8", 4, &rows()));
    refused("n.npy --pattern lidar:rings=1,step=1 --eye 0,0,0 -o a.npz --rays-out n.npy", &["n.npy is an input", read]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("rays.csv", dir.path("link.csv")).expect("linked");
        refused("s.toml --rays rays.csv -o link.csv", &["link.csv is the input rays.csv", read]);
        std::os::unix::fs::symlink("beams.npy", dir.path("beams.csv")).expect("linked");
        dir.put("beams.npy", "");
        refused("s.toml --pattern lidar:rings=1,step=1 -o beams.csv --rays-out beams.npy", &["twice"]);
    }
    dir.refused(8, &on_cpu("--rays rays.npy -o none/a.npz"), &["none", "does not exist"]);
}

#[test]
fn the_report_has_every_key() {
    let dir = dir();
    let report = trace(&dir, "--rays rays.npy --json").json();
    for key in ["schema", "halfline", "adapter", "driver", "backend", "method", "accuracy", "search"] {
        assert!(report[key].as_str().is_some_and(|text| !text.is_empty()), "{key}: {report}");
    }
    for (key, number) in [("version", 1), ("spheres", 3), ("skipped", 0), ("rays", 9), ("hits", 5), ("invalid", 0)] {
        assert_eq!(report[key], number, "{key}: {report}");
    }
    for key in ["build_ms", "elapsed_ms", "certified"] {
        assert!(report[key].as_f64().is_some_and(|x| x >= 0.0), "{key}: {report}");
    }
    assert_eq!((&report["backend"], &report["adapter"]), (&"cpu".into(), &"cpu".into()), "{report}");
    assert!(report["settled"].is_u64() && report["pattern"].is_null() && report["any"] == false, "{report}");
    let times = report["trace_ms"].as_array().expect("a list");
    assert!(times.len() == 1 && times[0].as_f64().is_some_and(|ms| ms > 0.0), "{report}");
    let rate = report["rays_per_second"].as_f64().expect("a number");
    assert!((rate * times[0].as_f64().expect("a number") / 9e3 - 1.0).abs() < 1e-6, "{report}");
    assert_eq!(report["warnings"].as_array().map(Vec::len), Some(0), "{report}");
    // Certainties are counted as they are written.
    for words in ["", "--any"] {
        let report = trace(&dir, &format!("--rays rays.npy {words} -o hits.npz --json")).json();
        let certainty = npz(&dir, "hits.npz").remove("certainty").expect("certainties").0;
        let with = |value: f64| certainty.iter().filter(|certainty| **certainty == value).count();
        assert_eq!(report["certified"].as_f64(), Some(with(0.0) as f64 / 9.0));
        assert_eq!(report["settled"], with(1.0));
    }
    dir.put("miss.csv", "0,0,0,0,1,0\n");
    let warned = trace(&dir, "--rays miss.csv --json --any").json();
    assert!(warned["warnings"][0].as_str().is_some_and(|text| text.contains("3 spheres")), "{warned}");
}

#[test]
fn progress_counts_rays() {
    let dir = dir();
    let lines = |words: &str| -> Vec<serde_json::Value> {
        let err = trace(&dir, words).err;
        err.lines().filter(|line| line.starts_with('{')).map(|line| serde_json::from_str(line).expect("JSON")).collect()
    };
    let beams = lines("--pattern lidar:rings=100,vfov=-1..1,step=0.05 -o a.npz --progress json");
    let done: Vec<_> = beams.iter().map(|line| line["done"].as_u64().expect("a number")).collect();
    assert!(done.is_sorted() && done.first() == Some(&0) && done.last() == Some(&720_000), "{beams:?}");
    assert!(beams.iter().all(|line| line["total"] == 720_000 && line["step"] == "trace" && line["frame"] == 1));
    let text = lines("--rays rays.csv -o a.npz --progress json");
    assert!(text[0]["total"].is_null(), "{text:?}");
    assert!(text.last().is_some_and(|line| line["done"] == 9 && line["total"] == 9), "{text:?}");
    let openjd = trace(&dir, "--rays rays.npy -o a.npz --progress openjd").text();
    assert!(
        openjd.contains("openjd_status: trace 9 of 9 rays") && openjd.ends_with("openjd_status: done\n"),
        "{openjd}"
    );
}

/// The signal ends the process in the middle of the work; neither the old file nor the folder is changed.
#[cfg(unix)]
#[test]
fn an_interrupt_leaves_nothing() {
    use std::io::{BufRead, BufReader};
    let dir = dir();
    dir.put("hits.npz", "an older file");
    dir.put("hits.csv", "an older file");
    dir.put("hits.las", "an older file");
    let before = dir.files();
    for output in ["hits.npz", "hits.csv", "hits.las"] {
        let words = on_cpu(&format!("--pattern lidar:rings=5000,vfov=-60..60,step=0.001 -o {output} --progress json"));
        let mut child = dir.command(&words).stderr(Stdio::piped()).spawn().expect("halfline runs");
        let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
        // Progress is reported at times, not for each block.
        let done = |line: String| serde_json::from_str::<serde_json::Value>(&line).ok()?["done"].as_u64();
        let started = lines.by_ref().map(|line| line.expect("text")).filter_map(done).any(|done| done > 0);
        assert!(started && child.try_wait().expect("its status").is_none(), "{output}");
        let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
        assert!(sent.expect("kill runs").success());
        assert_eq!(child.wait().expect("an end").code(), Some(130), "{output}");
        let rest: Vec<_> = lines.map(|line| line.expect("text")).filter(|line| !line.starts_with('{')).collect();
        assert_eq!(rest, ["halfline: interrupted"], "{output}");
        assert!(dir.files() == before, "{output}: {:?}", dir.files().keys());
    }
}

/// A full disk is reported although the rays come from a pipe that is silent but open.
#[cfg(target_os = "linux")]
#[test]
fn a_failure_does_not_wait_for_more_rays() {
    let dir = dir();
    let mut command = dir.command(&on_cpu("--rays - -o /dev/full"));
    let mut child = command.stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("halfline runs");
    let mut input = child.stdin.take().expect("a pipe");
    // A block and some more.
    let _ = input.write_all("0,0,0,0,0,-1\n".repeat(700_000).as_bytes());
    let start = Instant::now();
    while child.try_wait().expect("its status").is_none() && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(20));
    }
    let _ = child.kill();
    let output = Output::of(child.wait_with_output().expect("halfline ends"));
    assert!(output.code == 8 && output.err.contains("cannot write /dev/full"), "{} {}", output.code, output.err);
    drop(input);
}
