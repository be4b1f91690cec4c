//! The promise of provenance: everything that changes a byte of a file is in it. Pairs of options are drawn; what the first ones wrote is
//! kept by `--resume` with the second ones, or merged with their tiles, only where their own files have the same bytes.

use crate::amount::amount;
use crate::rng::Rng;
use crate::test_dir::TestDir;

/// Values of options of a scene file and of particles; "" is the option alone.
const OF_SCENES: &[(&str, &[&str])] = &[
    ("--eye", &["0.3,0.2,4", "0,0,3"]),
    ("--at", &["0.1,0,0", "0,0.2,0"]),
    ("--view", &["0,0,-1", "left"]),
    ("--up", &["0,1,0.2"]),
    ("--fit", &[""]),
    ("--vfov", &["30", "50"]),
    ("--ortho", &["2", "3"]),
    ("--zoom", &["1.5"]),
    ("--lens", &["fisheye", "equirectangular"]),
    ("--lens-coefficients", &["0.1,0.01,0,0"]),
    ("--aperture", &["0.3", "0.6"]),
    ("--focus-distance", &["2", "3"]),
    ("--intrinsics", &["20,21,12,9"]),
    ("--size", &["24x18", "18x24"]),
    ("--samples", &["1", "4", "9"]),
    ("--seed", &["0", "1", "7"]),
    ("--least-size", &["4", "7"]),
    ("--exposure", &["1", "-1"]),
    ("--tone", &["linear", "soft"]),
    ("--label", &["a", "{count}"]),
    ("--scale-bar", &["", "=nm"]),
    ("--background", &["white", "0.1,0.2,0.3"]),
    ("--transparent", &[""]),
    ("--look", &["plain", "soft", "figure"]),
    ("--occlusion", &["3", "8"]),
    ("--reach", &["0.5", "2"]),
    ("--sun", &["1,2,3", "-1,1,1"]),
    ("--shadows", &[""]),
    ("--bounces", &["0", "2"]),
    ("--silhouette", &[""]),
    ("--outline-width", &["0.5", "3"]),
    ("--outline-color", &["teal", "1,0.5,0.2"]),
    ("--depth-cue", &[""]),
    ("--depth-cue-strength", &["0.3", "1"]),
    ("--opacity", &["0.4", "0.9"]),
    ("--layers", &["1", "2"]),
    ("--opacity-shadows", &[""]),
    ("--ghost-rim", &[""]),
    ("--shade", &["flat", "headlight", "normal", "lights"]),
    ("--accuracy", &["fast", "certified", "exact"]),
    ("--method", &["textbook", "stable", "double-float"]),
    ("--tolerance", &["1e-4", "1e-3"]),
    ("--bits", &["8", "16"]),
    ("--dpi", &["72", "300"]),
    ("--no-return", &["-1"]),
];
const OF_PARTICLES: [(&str, &[&str]); 32] = [
    ("--select", &["x > 0", "element O"]),
    ("--hide", &["element H"]),
    ("--radii", &["vdw", "covalent"]),
    ("--radius", &["0.4", "element O=0.9"]),
    ("--radius-scale", &["0.5"]),
    ("--move", &["element O=0.5,0,-1", "x > 0=1,2,3"]),
    ("--wrap", &[""]),
    ("--copies", &["2,1,1"]),
    ("--clip", &["1,0,0,0.5"]),
    ("--cell", &["", "=0.05"]),
    ("--cut", &["1,0,0,0.1", "0,1,1,0.3"]),
    ("--cut-slab", &["1,0,0,-0.3,0.4"]),
    ("--cut-at", &["element O", "all:0,1,0"]),
    ("--cut-only", &["element O"]),
    ("--cut-color", &["red", "element O=teal"]),
    ("--color", &["red", "element O=blue"]),
    ("--color-by", &["vx", "element", "x"]),
    ("--opacity", &["0.4", "element O=0.5"]),
    ("--material", &["plastic", "element O=plastic", "metal"]),
    ("--shine", &["5"]),
    ("--mark", &["element O={element}", "all=x"]),
    ("--mark-one", &["element O=o", "all=x"]),
    ("--mark-all", &[""]),
    ("--map", &["magma", "grays"]),
    ("--nan-color", &["red", "#102030"]),
    ("--range", &["0,1", "0,3"]),
    ("--log", &[""]),
    ("--legend-in", &["", "=left"]),
    ("--legend-title", &["a", "b"]),
    ("--focus", &["element O"]),
    ("--frame-share", &["0.5"]),
    ("--unit", &["0.5"]),
];
/// Options that this test does not draw, by the reason.
const OTHERS: [(&str, &[&str]); 5] = [
    (
        "name or read other inputs",
        &[
            "--visible",
            "--format",
            "--columns",
            "--atom-style",
            "--topology",
            "--add",
            "--identity",
            "--model",
            "--altloc",
            "--assembly",
            "--as-listed",
            "--strict",
            "--skip-invalid",
            "--unwrap",
            "--camera-from",
            "--cameras",
        ],
    ),
    ("make several pictures", &["--frames", "--hold", "--spin", "--fps"]),
    (
        "name the outputs, or a part of the frame",
        &[
            "--output",
            "--aov",
            "--cryptomatte",
            "--group",
            "--detail",
            "--legend",
            "--raw",
            "--crop",
            "--tile",
            "--trim",
        ],
    ),
    ("name the machine, which the provenance has as adapter and driver", &["--backend", "--adapter"]),
    ("change no byte", &["--resume", "--stream", "--json", "--progress", "--preview", "--repeat", "--quiet", "--help"]),
];

const SCENE: &str =
    "[camera]\neye = [0, 0, 4]\nview = [0, 0, -1]\nup = [0, 1, 0]\nvfov = 40\n[image]\nsize = [24, 18]\n
[[light]]\nposition = [4, 3, 1]\nradius = 1.5\n[[light]]\ndirection = [-1, 2, 1]\n
[[sphere]]\ncenter = [0, 0, 0]\nradius = 0.8\nmaterial = 'metal'\nfuzz = 0.4\n
[[sphere]]\ncenter = [1.1, 0.4, 0.3]\nradius = 0.5\nmaterial = 'glass'\n
[[sphere]]\ncenter = [-1, -0.3, 0.6]\nradius = 0.6\ncolor = [0.9, 0.4, 0.2]\n";
const PARTICLES: &str =
    "5\nLattice=\"3 0 0 0 3 0 0 0 3\" Properties=species:S:1:pos:R:3:vx:R:1\nO 0 0 0 1.5\nH 0.9 0.3 0 0.2
H -0.4 0.8 0.2 2.5\nC 2.5 3.5 1 0.7\nO 1.5 1 2 3\n";

/// Some options with their values.
type Words = Vec<String>;

/// An option of a table, with one of its values.
fn draw(rng: &mut Rng, table: &[(&str, &[&str])]) -> [String; 2] {
    let (name, values) = table[rng.below(table.len())];
    [name.into(), rng.pick(values).into()]
}

/// Their words on the command line.
fn words(options: &[[String; 2]]) -> Words {
    let one = |[name, value]: &[String; 2]| match value.as_str() {
        "" => vec![name.clone()],
        value if value.starts_with('=') => vec![format!("{name}{value}")],
        value => vec![name.clone(), value.to_owned()],
    };
    options.iter().flat_map(one).collect()
}

/// Two lists of options; one has one option more, or another value of one.
fn pair(rng: &mut Rng, table: &[(&str, &[&str])]) -> [Words; 2] {
    let mut first: Vec<[String; 2]> = Vec::new();
    for _ in 0..rng.below(4) {
        let option = draw(rng, table);
        if first.iter().all(|known| known[0] != option[0]) {
            first.push(option);
        }
    }
    let mut second = first.clone();
    let option = draw(rng, table);
    second.retain(|known| known[0] != option[0]);
    second.push(option);
    let pair = [words(&first), words(&second)];
    if rng.below(2) == 0 { pair } else { [pair[1].clone(), pair[0].clone()] }
}

/// Runs a command with more words; whether it was taken.
fn runs(dir: &TestDir, command: &str, options: &Words) -> bool {
    let words: Words = command.split_whitespace().map(String::from).chain(options.iter().cloned()).collect();
    // Particles have no size of their own.
    let output = dir.run_with(&words, &[("HALFLINE_SIZE", "24x18")]);
    // Some pairs contradict each other, and others leave a scene incomplete.
    assert!([0, 2, 3].contains(&output.code), "{words:?}: {}", output.err);
    output.code == 0
}

/// The bytes of a picture and of buffers that these options write; `None` where they are refused.
fn written(dir: &TestDir, input: &str, options: &Words, more: &str) -> Option<[Vec<u8>; 3]> {
    // The particles have no light of their own.
    let light = if input == "s.toml" { "shadow,occlusion" } else { "occlusion" };
    let command =
        format!("render {input} --backend cpu -o a.png --aov id,depth,color=b.npz --aov {light}=c.npz {more}");
    runs(dir, &command, options).then(|| ["a.png", "b.npz", "c.npz"].map(|name| dir.get(name)))
}

/// Renders with the first options, and again with the second ones; whether both are taken.
fn check(dir: &TestDir, input: &str, [first, second]: &[Words; 2]) -> bool {
    let Some(expected) = written(dir, input, second, "") else { return false };
    if written(dir, input, first, "").is_none() {
        return false;
    }
    let found = written(dir, input, second, "--resume").expect("as before");
    assert!(found == expected, "{input}: {second:?} kept a file of {first:?}");
    let tile = |options, tile: u32| {
        runs(dir, &format!("render {input} --backend cpu --aov color,depth=t{tile}.npz --tile {tile}/2"), options)
    };
    if tile(first, 1) && tile(second, 2) && dir.run("merge t1.npz t2.npz -o m.npz").code == 0 {
        let whole = |options| {
            runs(dir, &format!("render {input} --backend cpu --aov color,depth=w.npz"), options);
            dir.get("w.npz")
        };
        let merged = dir.get("m.npz");
        assert!(
            whole(first) == merged && whole(second) == merged,
            "{input}: tiles of {first:?} and {second:?} were merged"
        );
    }
    true
}

#[test]
fn a_file_of_other_options_is_neither_kept_nor_merged() {
    let dir = TestDir::new(&[("s.toml", SCENE), ("p.xyz", PARTICLES)]);
    let particles = [OF_SCENES, &OF_PARTICLES[..]].concat();
    let mut rng = Rng::new(0xb17e);
    let (pairs, mut compared) = (amount("pairs of options", [20, 60, 1500]), 0);
    for n in 0..pairs {
        let (input, table) = if n % 2 == 0 { ("s.toml", OF_SCENES) } else { ("p.xyz", &particles[..]) };
        compared += usize::from(check(&dir, input, &pair(&mut rng, table)));
    }
    println!("{compared} of {pairs} pairs compared; the others are refused");
    assert!(3 * compared > pairs, "{compared} of {pairs}");
}

/// An option that is added to the command is added to a table above.
#[test]
fn every_option_is_drawn_or_has_a_reason() {
    let help = TestDir::new(&[]).good("render --help").text();
    let known = OF_SCENES.iter().chain(&OF_PARTICLES).map(|(name, _)| *name);
    let known: Vec<&str> = known.chain(OTHERS.iter().flat_map(|(_, names)| names.iter().copied())).collect();
    let option = |line: &str| {
        let line = line.trim_start();
        let line = line.strip_prefix("-o, ").or(line.strip_prefix("-h, ")).unwrap_or(line);
        let end = line.find([' ', '[', '=']).unwrap_or(line.len());
        line.starts_with("--").then(|| line[..end].to_owned())
    };
    // Options stand at the beginning of a line, six columns in at most.
    let lines = help.lines().filter(|line| line.len() - line.trim_start().len() <= 6);
    let found: Vec<String> = lines.filter_map(option).collect();
    assert!(found.len() > 80, "{found:?}");
    for name in &found {
        assert!(known.contains(&name.as_str()), "{name} is in no table");
    }
    for name in known {
        assert!(found.iter().any(|found| found == name), "{name} is no option");
    }
}
