//! The promises of planes that cut spheres, as options and in scene files: what is removed, cut and kept whole, ids that stay, and words for
//! what cannot be.

use crate::test_dir::TestDir;

/// A big sphere, a small one inside of it, one beyond, one before.
const NESTED: &str = "x,y,z,radius,kind\n0,0,0,4,shell\n0,0,0,2,core\n0,0,9,1,far\n7,0,-3,1,near\n";
const CAMERA: &str = "--eye 0,0,40 --at 0,0,0 --ortho 20 --size 100x100 --look plain --aov id=i.npy --aov depth=d.npy";

/// Words, in which ~ stands for a blank.
fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(|word| word.replace('~', " ")).collect()
}

fn with(text: &str) -> TestDir {
    TestDir::new(&[("n.csv", text)])
}

#[test]
fn a_cut_shows_the_inside_and_ids_stay() {
    let dir = with(NESTED);
    let ran = dir.render(&format!("n.csv {CAMERA} --cut 0,0,2,2 --json"));
    let report: serde_json::Value = serde_json::from_slice(&ran.out).expect("a report");
    assert_eq!(
        report["cuts"][0]["normal"].to_string() + &report["cuts"][0]["distance"].to_string(),
        "[0.0,0.0,2.0]2.0"
    );
    assert_eq!(
        [&report["spheres"], &report["spheres_cut"], &report["spheres_removed"]].map(|n| n.as_u64()),
        [4, 2, 1].map(Some)
    );
    let [ids, depths] = ["i.npy", "d.npy"].map(|file| dir.array(file).0);
    let at = |x: usize, y: usize| (ids[100 * y + x], depths[100 * y + x]);
    // Five pixels for 1; the plane is at z = 1, so the eye is 39 away. The smaller sphere shows its face, in the larger one.
    assert_eq!([at(50, 50), at(64, 50), at(85, 50)].map(|(id, _)| id), [1.0, 0.0, 3.0]);
    assert!([at(50, 50).1, at(64, 50).1].iter().all(|depth| (depth - 39.0).abs() < 1e-4));
    // sqrt(4 - 1) of the core, sqrt(16 - 1) of the shell.
    let area = |id: f64| ids.iter().filter(|found| **found == id).count() as f64 / 25.0;
    let discs = [std::f64::consts::PI * 3.0, std::f64::consts::PI * (16.0 - 3.0)];
    assert!([1.0, 0.0].into_iter().zip(discs).all(|(id, disc)| (area(id) / disc - 1.0).abs() < 0.03));
    assert!(!ids.contains(&2.0), "the one beyond is removed");
}

#[test]
fn slabs_selections_and_scene_files_say_the_same() {
    let toml = "[camera]\neye = [0, 0, 40]\nview = [0, 0, -1]\nup = [0, 1, 0]\nheight = 20\n[image]\nsize = [100, 100]\n
[[sphere]]\ncenter = [0, 0, 0]\nradius = 4\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 2\n
[[sphere]]\ncenter = [0, 0, 9]\nradius = 1\n[[sphere]]\ncenter = [7, 0, -3]\nradius = 1\n[[cut]]\nnormal = [0, 0, 1]\ndistance = 1\n[[cut]]\nnormal = [0.0, 0.0, -1.0]\ndistance = 2\n";
    let dir = TestDir::new(&[("n.csv", NESTED), ("s.toml", toml)]);
    let picture = |line: &str| {
        dir.render(&words(line));
        (dir.array("i.npy").0, dir.array("d.npy").0)
    };
    let two = picture(&format!("n.csv {CAMERA} --cut 0,0,1,1 --cut 0,0,-1,2"));
    assert_eq!(two, picture(&format!("n.csv {CAMERA} --cut-slab 0,0,1,-2,1")));
    assert_eq!(two, picture("s.toml --look plain --aov id=i.npy --aov depth=d.npy"));
    // The plane through the core's centre, toward the eye.
    let through = picture(&format!("n.csv {CAMERA} --cut 0,0,1,0"));
    assert_eq!(through, picture(&format!("n.csv {CAMERA} --cut-at kind~core")));
    assert_eq!(through, picture(&format!("n.csv {CAMERA} --cut-at kind~core:0,0,3")));
    // The core stays whole.
    let spared = picture(&format!("n.csv {CAMERA} --cut-at kind~core --cut-only not~(kind~core)"));
    let at = |(ids, depths): &(Vec<f64>, Vec<f64>), n: usize| (ids[n], depths[n].round());
    assert_eq!((at(&spared, 5050), at(&spared, 5065)), ((1.0, 38.0), (0.0, 40.0)));
}

#[test]
fn faces_have_colours_of_their_own() {
    let dir = with(NESTED);
    let colors = |words: &str| {
        let camera = CAMERA.replace("--look plain", "");
        let line = format!("n.csv {camera} --color white --cut 0,0,1,1 {words} --aov color=c.npy");
        dir.render(&self::words(&line));
        let (colors, _) = dir.array("c.npy");
        [5050, 5065, 5085].map(|pixel: usize| [0, 1, 2].map(|k| (100.0 * colors[3 * pixel + k]).round()))
    };
    let white = [100.0; 3];
    for (look, words) in [
        ("flat", "--look plain --shade flat"),
        ("soft", "--look soft"),
        ("through", "--look plain --shade flat --opacity kind~near=0.5"),
    ] {
        let plain = colors(words);
        let all = colors(&format!("{words} --cut-color 0,1,0"));
        let core = colors(&format!("{words} --cut-color 0,1,0 --cut-color kind~core=1,0,0"));
        let hue = |color: [f64; 3]| color.map(|x| if x > 1.0 { 1 } else { 0 });
        assert_eq!([hue(all[0]), hue(all[1])], [[0, 1, 0]; 2], "{look}: {all:?}");
        assert_eq!([hue(core[0]), hue(core[1])], [[1, 0, 0], [0, 1, 0]], "{look}: {core:?}");
        assert!(
            all[2] == plain[2] && plain[0] == plain[1] && plain[2][0] == plain[2][1],
            "{look}: the whole sphere keeps its own"
        );
        assert!(look != "flat" || plain == [white; 3], "{plain:?}");
    }
}

/// A thing in a translucent shell, behind a wall that a plane removes, has its name.
#[test]
fn marks_see_through_what_is_removed() {
    let text = "x,y,z,radius,kind\n0,0,0,4,shell\n0,0,0,2,core\n0,0,12,5,wall\n";
    let dir = with(text);
    let err = |cut: &str| {
        let line = format!("n.csv {CAMERA} --opacity kind~shell=0.4 --mark kind~core=C {cut} -o a.png");
        dir.render(&words(&line)).err
    };
    let hidden = "what no pixel shows";
    assert!(err("").contains(hidden) && !err("--cut 0,0,1,6").contains(hidden), "{}", err("--cut 0,0,1,6"));
}

/// Given rays meet faces, in every format of planes; whether anything is hit counts them.
#[test]
fn given_rays_hit_faces() {
    let toml = "[camera]\neye = [0, 0, 40]\nview = [0, 0, -1]\nup = [0, 1, 0]\nheight = 20\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 4\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 2\n
[[sphere]]\ncenter = [0, 0, 9]\nradius = 1\n[[sphere]]\ncenter = [7, 0, -3]\nradius = 1\n[[cut]]\nnormal = [0, 0, 1]\ndistance = 1\n";
    let rays = "0,0,40,0,0,-1,inf\n3,0,40,0,0,-2,inf\n0,0,40,0,0,-1,39\n0,0,40,0,0,-1,40\n";
    let dir = TestDir::new(&[("n.csv", NESTED), ("s.toml", toml), ("r.csv", rays)]);
    let traced = |line: &str| dir.good(&words(&format!("trace {line} --rays r.csv -o -"))).text();
    // The face of the core in the face of the shell, at z = 1; a limit at the face excludes it.
    let hits = "id,t,distance,nx,ny,nz,certainty\n1,39.0,39.0,0.0,0.0,1.0,0\n0,19.5,39.0,0.0,0.0,1.0,0\n-1,inf,inf,0.0,0.0,0.0,";
    let plain = traced("n.csv --cut 0,0,1,1");
    assert!(plain.starts_with(hits) && plain.contains("\n1,39.0,39.0,0.0,0.0,1.0,0\n"), "{plain}");
    for line in ["s.toml", "n.csv --cut-slab 0,0,2,-99,2"] {
        assert_eq!(traced(line), plain, "{line}");
    }
    // Through the centre of the core, which is 1 before the plane.
    assert!(traced("n.csv --cut-at kind~core:0,0,3").contains("\n1,40.0,40.0,0.0,0.0,1.0,0\n"));
    assert_eq!(traced("n.csv --cut 0,0,1,1 --any").lines().map(|line| &line[..1]).collect::<String>(), "h1101");
    // The others stay whole: the one beyond, and the shell at z = sqrt 7.
    let spared = traced("n.csv --cut 0,0,1,1 --cut-only kind~core");
    assert!(spared.contains("\n2,30.0,30.0,") && spared.contains("\n0,18.677"), "{spared}");
    let report = dir.good("trace n.csv --cut 0,0,1,1 --rays r.csv --json").json();
    assert_eq!([&report["spheres_cut"], &report["spheres_removed"]].map(|n| n.as_u64()), [2, 1].map(Some));
    let refused = |code: i32, line: &str, parts: &[&str]| {
        dir.refused(code, &words(&format!("trace {line} --rays r.csv -o a.csv")), parts);
    };
    refused(2, "n.csv --cut-at kind~core", &["--cut-at", "no view", "EXPR:X,Y,Z"]);
    refused(2, "n.csv --cut 0,0,1,1 --accuracy fast", &["planes cut some spheres", "--accuracy"]);
    assert!(dir.good("trace n.csv --cut 0,0,1,-50 --rays r.csv --json").err.contains("--cut removes all 4 spheres"));
}

#[test]
fn what_cannot_be_cut_has_words() {
    let bad = "[camera]\neye = [0, 0, 40]\nview = [0, 0, -1]\nup = [0, 1, 0]\nheight = 20\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\n
[[cut]]\nnormal = [0, 0, 0]\ndistance = 1\n";
    let good = bad.replace("[0, 0, 0]\ndistance", "[0, 0, 1]\ndistance");
    let dir = TestDir::new(&[("n.csv", NESTED), ("bad.toml", bad), ("good.toml", &good)]);
    let refused = |code: i32, line: &str, parts: &[&str]| {
        dir.refused_render(code, &words(&format!("{line} -o a.png")), parts);
    };
    refused(2, "n.csv --cut 0,0,0,1", &["--cut", "expected a direction"]);
    refused(2, "n.csv --cut 0,0,1", &["--cut"]);
    refused(2, "n.csv --cut-slab 0,0,1,2,2", &["--cut-slab", "nothing lies from 2 to 2"]);
    refused(2, "n.csv --cut-at kind~core:0,0,0", &["--cut-at", "direction behind the colon"]);
    refused(2, "n.csv --cut-only kind~core", &["--cut-only", "none cuts", "--cut-at"]);
    refused(2, "n.csv --cut-color red", &["--cut-color", "none cuts"]);
    refused(2, "n.csv --cut 0,0,1,1 --cut-color blak", &["--cut-color", "blak"]);
    refused(3, "n.csv --cut-at kind~nothing", &["--cut-at", "kind nothing", "none of 4 spheres"]);
    refused(2, "n.csv --cut-at kind~core --stream", &["--stream", "--cut-slab"]);
    refused(2, "n.csv --cut 0,0,1,1 --cut-color red --stream", &["--cut-color", "all spheres in memory"]);
    dir.refused(
        2,
        &words("sift n.csv --cut-only x>0 --first-id 0 -o p.npz"),
        &["--cut-only is not an option of a part"],
    );
    refused(2, "n.csv --cut 0,0,1,1 --method stable", &["planes cut some spheres", "--method"]);
    refused(3, "bad.toml", &["bad.toml:11:10", "cut 0 normal", "any length but zero"]);
    // A stream and a part count as a scene in memory does.
    let counts = |options: &str| {
        let ran = dir.render(&words(&format!("{options} --json"))).json();
        ["spheres", "spheres_cut", "spheres_removed", "cuts"].map(|key| ran[key].to_string())
    };
    let rays = "n.csv --eye 0,0,40 --at 0,0,0 --ortho 20 --size 100x100 --cut 0,0,1,1";
    dir.good(&format!("sift {rays} --first-id 0 -o p.npz"));
    let whole = format!("{rays} --look plain -o a.png");
    assert_eq!(counts(&format!("{whole} --stream")), counts(&whole));
    assert_eq!(counts("--visible p.npz -o a.png"), counts(&whole));
    let ran = dir.render(&format!("n.csv {CAMERA} --cut 0,0,1,-50 --stream"));
    assert!(ran.err.contains("--cut removes all 4 spheres"), "{}", ran.err);
    let ran = dir.render(&format!("n.csv {CAMERA} --cut 0,0,1,-50"));
    assert!(ran.err.contains("--cut removes all 4 spheres"), "{}", ran.err);
    // The beads of a cell are not cut.
    let cell = "3\nLattice=\"6 0 0 0 6 0 0 0 6\" Properties=species:S:1:pos:R:3\nC 1 1 1\nC 3 3 3\nC 5 5 5\n";
    let dir = TestDir::new(&[("n.xyz", cell)]);
    let count = |words: &str| {
        dir.render(&format!(
            "n.xyz --eye 3,3,30 --at 3,3,3 --size 60x60 --look plain --cell=0.2 {words} --aov id=i.npy"
        ));
        dir.array("i.npy").0.iter().filter(|id| **id >= 3.0).count()
    };
    assert!(count("--cut 0,0,1,0.5") >= count(""), "nothing hides beads that was not there before");
}
