//! The promise of `halfline sift` and `render --visible`: the files of parts have the bytes of the files of all spheres, and parts
//! that do not belong together are refused.

use crate::numpy::npy_of;
use crate::rng::Rng;
use crate::test_dir::TestDir;

const COUNT: usize = 60_000;

/// The first rows of the parts, and the end of the last one.
const CUTS: [usize; 5] = [0, 1_000, 33_333, 33_334, COUNT];

const CAMERA: &str = "--eye 3,2,4 --at 0,0,0 --vfov 40 --size 64x48";

/// Arrays of a cloud and of its parts, and a table with colours of it.
fn dir() -> TestDir {
    let mut rng = Rng::new(31);
    let rows: Vec<[f64; 4]> = (0..COUNT)
        .map(|_| {
            let [x, y, z] = rng.cube();
            [x, y, z, 0.01 * (1.0 + rng.unit())]
        })
        .collect();
    let dir = TestDir::new(&[]);
    let array = |rows: &[[f64; 4]]| {
        let data: Vec<u8> = rows.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
        npy_of("<f8", "False", &format!("({}, 4)", rows.len()), &data)
    };
    let table = |rows: &[[f64; 4]]| {
        let lines = rows.iter().map(|[x, y, z, r]| format!("{x},{y},{z},{r},{}\n", x + y));
        format!("x,y,z,radius,v\n{}", lines.collect::<String>()).into_bytes()
    };
    dir.put("all.npy", array(&rows));
    dir.put("all.csv", table(&rows));
    for (n, ends) in CUTS.windows(2).enumerate() {
        dir.put(&format!("{n}.npy"), array(&rows[ends[0]..ends[1]]));
        dir.put(&format!("{n}.csv"), table(&rows[ends[0]..ends[1]]));
    }
    dir
}

fn outputs(name: &str) -> String {
    let aovs = ["id", "distance", "normal", "certainty", "bound"].map(|aov| format!(" --aov {aov}={name}-{aov}.npy"));
    format!("-o {name}.png {}", aovs.concat())
}

#[test]
fn files_of_parts_have_the_bytes_of_those_of_all_spheres() {
    let dir = dir();
    for (ending, camera, drawn) in [
        ("npy", CAMERA.to_owned(), ""),
        ("npy", format!("{CAMERA} --samples 16 --seed 3"), ""),
        ("npy", format!("{CAMERA} --tolerance 1e-3"), ""),
        ("npy", CAMERA.replace("64x48", "200x150"), "--label {count}"),
        ("npy", format!("{CAMERA} --crop 9,9,40,30 --outline-width 4"), "--silhouette"),
        (
            "npy",
            "--eye 3,2,4 --at 0,0,0 --ortho 2 --size 64x48 --crop 10,5,50,33".to_owned(),
            "--background white --depth-cue",
        ),
        ("csv", format!("{CAMERA} --color-by v --range -1,1"), "--transparent --silhouette"),
        ("npy", format!("{CAMERA} --cut 0.2,0.1,1,0.3"), "--silhouette"),
        ("csv", format!("{CAMERA} --samples 4 --cut 1,0,0,0.4 --cut-slab 0,1,0.5,-0.5,0.25"), "--depth-cue"),
        ("csv", format!("{CAMERA} --tile 2/4 --samples 4 --radius-scale 0.5 --color teal"), "--exposure 1"),
    ] {
        for (n, first) in CUTS[..CUTS.len() - 1].iter().enumerate() {
            dir.good(&format!("sift {n}.{ending} --first-id {first} {camera} -o {n}.npz"));
        }
        dir.render(&format!("all.{ending} --look plain {camera} {drawn} {}", outputs("whole")));
        dir.render(&format!("--visible 2.npz 3.npz 0.npz 1.npz 3.npz {drawn} {}", outputs("parts")));
        let files = dir.files();
        for (name, bytes) in files.iter().filter(|(name, _)| name.starts_with("whole")) {
            let other = name.replacen("whole", "parts", 1);
            assert!(files[&other] == *bytes, "{camera} {drawn}: {other} differs from {name}");
        }
        assert_eq!(files.keys().filter(|name| name.starts_with("parts")).count(), 6);
    }
}

/// With few spheres and a tolerance, `auto` may choose an uncertified method.
#[test]
fn the_tolerance_is_that_of_the_parts() {
    let dir = dir();
    dir.put("few.csv", "x,y,z,radius\n0,0,0,0.5\n0.3,0,0,0.4\n-0.6,0.2,0.1,0.3\n");
    let outputs =
        |name: &str| ["bound", "certainty", "distance"].map(|aov| format!(" --aov {aov}={name}-{aov}.npy")).concat();
    for tolerance in ["", "--tolerance 1e-3", "--tolerance 3e-9"] {
        for file in ["few.csv", "1.npy"] {
            dir.good(&format!("sift {file} --first-id 0 {CAMERA} {tolerance} -o part.npz"));
            dir.render(&format!("{file} --look plain {CAMERA} {tolerance} {}", outputs("whole")));
            dir.render(&format!("--visible part.npz {}", outputs("parts")));
            for aov in ["bound", "certainty", "distance"] {
                let [whole, parts] = ["whole", "parts"].map(|name| dir.get(&format!("{name}-{aov}.npy")));
                assert!(whole == parts, "{file} {tolerance}: {aov}");
            }
        }
    }
}

/// The camera may come from a scene file, whose spheres are not read.
#[test]
fn the_camera_may_be_that_of_a_scene() {
    let dir = dir();
    let scene = "[camera]\neye = [3.0, 2.0, 4.0]\nat = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nvfov = 40.0\n[image]\nsize = [64, 48]\n";
    dir.put("camera.toml", format!("{scene}[[light]]\nsphere = 9\n[[spheres]]\nfile = \"none.npy\"\n"));
    for (n, first) in CUTS[..CUTS.len() - 1].iter().enumerate() {
        dir.good(&format!("sift {n}.npy --first-id {first} --camera-from camera.toml -o {n}.npz"));
    }
    dir.render(&format!("all.npy --look plain --camera-from camera.toml {}", outputs("whole")));
    dir.render(&format!("--visible 0.npz 1.npz 2.npz 3.npz {}", outputs("parts")));
    let files = dir.files();
    for (name, bytes) in files.iter().filter(|(name, _)| name.starts_with("whole")) {
        assert!(files[&name.replacen("whole", "parts", 1)] == *bytes, "{name}");
    }
}

#[test]
fn a_part_says_what_it_is_and_what_is_missing() {
    let dir = dir();
    for n in [0, 3] {
        let sifted = dir.good(&format!("sift {n}.npy --first-id {} {CAMERA} -o {n}.npz --json", CUTS[n]));
        let report = sifted.json();
        assert_eq!(report["ids"], serde_json::json!([[CUTS[n], CUTS[n + 1]]]));
        assert_eq!(report["spheres"], CUTS[n + 1] - CUTS[n]);
        assert!(report["kept"].as_u64().expect("a number") <= (CUTS[n + 1] - CUTS[n]) as u64);
    }
    let report = dir.render("--visible 3.npz 0.npz --json -o a.png").json();
    assert_eq!(report["warnings"], serde_json::json!(["no part has the 32334 spheres with ids 1000 to 33333"]));
    assert_eq!(report["spheres"], COUNT);
    let plan = dir.good("plan --visible 0.npz 3.npz --json").json();
    assert_eq!(plan["size"], serde_json::json!([64, 48]));
    let framed = dir.good("sift 0.npy --first-id 0 --size 64x48 -o f.npz").err;
    assert!(framed.contains("the camera frames the spheres of this part alone"), "{framed}");
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let dir = dir();
    let sift = |n: usize, options: &str, name: &str| {
        dir.good(&format!("sift {n}.npy --first-id {} {options} -o {name}.npz", CUTS[n]));
    };
    sift(0, CAMERA, "0");
    sift(1, CAMERA, "1");
    sift(1, &CAMERA.replace("40", "41"), "turned");
    sift(1, &CAMERA.replace("64x48", "64x49"), "larger");
    sift(1, &format!("{CAMERA} --samples 4"), "sampled");
    sift(1, &format!("{CAMERA} --cut 1,0,0,0.5"), "cut");
    dir.good(&format!("sift 3.npy --first-id 500 {CAMERA} -o same.npz"));
    let mut damaged = dir.files()["1.npz"].clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    dir.put("damaged.npz", damaged);
    for (code, command, words) in [
        (
            2,
            "render --visible 0.npz turned.npz -o x.png",
            "0.npz and turned.npz are parts of different frames: the camera",
        ),
        (2, "render --visible 0.npz larger.npz -o x.png", "the size is 64x48, and 64x49"),
        (2, "render --visible 0.npz sampled.npz -o x.png", "the number of samples is 1, and 4"),
        (2, "render --visible cut.npz 0.npz -o x.png", "the list of planes is 1,0,0,0.5, and empty"),
        (2, "render --visible cut.npz --cut 1,0,0,0.5 -o x.png", "--cut belongs to the parts"),
        (3, "render --visible 0.npz same.npz -o x.png", "0.npz and same.npz have different spheres"),
        (3, "render --visible 0.npz damaged.npz -o x.png", "damaged.npz"),
        (3, "render --visible 0.npz all.npy -o x.png", "all.npy"),
        (8, "render --visible 0.npz none.npz -o x.png", "none.npz"),
        (2, "render --visible 0.npz -o 0.npz", "0.npz is an input"),
        (2, "render --visible 0.npz --size 9x9 -o x.png", "the parts are of a frame of 64x48"),
        (2, "render --visible 0.npz --samples 4 -o x.png", "its number of samples is 1, and not 4"),
        (2, "render --visible 0.npz --outline-width 3 -o x.png", "its width of outlines is 1.3, and not 3"),
        (2, "render --visible 0.npz --eye 1,2,3 -o x.png", "--eye belongs to the parts"),
        (2, "render --visible 0.npz --crop 0,0,3,3 -o x.png", "--crop belongs to the parts"),
        (2, "render --visible 0.npz --select all -o x.png", "--select belongs to the parts"),
        (2, "render --visible 0.npz --copies 2,1,1 -o x.png", "made with their own options; remove it"),
        (2, "render --visible 0.npz --legend-in -o x.png", "parts have no legend"),
        (2, "render --visible 0.npz --stream -o x.png", "--stream"),
        (2, "render --visible 0.npz --occlusion -o x.png", "need all spheres in memory"),
        (2, "render 0.npy --visible 0.npz -o x.png", "cannot be used with"),
        (2, "sift 0.npy --first-id 0 --eye 1,2,3 -o x.png", "x.png cannot hold a part"),
        (2, "sift 0.npy --first-id 0 --eye 1,2,3 -o 0.npy", "0.npy cannot hold a part"),
        (2, "sift 0.npy --first-id 0 --eye 1,2,3 --copies 2,1,1 -o x.npz", "--copies is not an option of a part"),
        (2, "sift 0.npy --first-id 0 --eye 1,2,3 --cut-at all -o x.npz", "--cut-at is not an option of a part"),
        (2, "sift 0.npy --first-id 0 --eye 1,2,3 --backend cpu -o x.npz", "--backend is not an option of a part"),
        (
            2,
            "sift 0.npy --first-id 0 --eye 1,2,3 --outline-color red -o x.npz",
            "--outline-color is not an option of a part",
        ),
        (2, "sift 0.csv --first-id 0 --eye 1,2,3 --color-by v -o x.npz", "--range LOW,HIGH"),
        (2, "sift 0.csv --first-id 0 --eye 1,2,3 --select ligand -o x.npz", "`ligand` in the selection"),
        (2, "sift 0.csv --first-id 0 --eye 1,2,3 --at v>0 -o x.npz", "give --at a point"),
        (2, "sift 0.csv --first-id 0 --focus v>0 -o x.npz", "remove --focus"),
        (5, "sift 0.npy --first-id 36028797018963968 --eye 1,2,3 -o x.npz", "use ids below"),
        (2, "sift 0.npy --eye 1,2,3 -o x.npz", "--first-id"),
    ] {
        let found = dir.run(command);
        assert!(found.code == code && found.err.contains(words), "{command}: {} {}", found.code, found.err);
        assert!(!dir.files().contains_key("x.png") && !dir.files().contains_key("x.npz"), "{command} wrote a file");
    }
}
