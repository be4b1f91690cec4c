//! The promise of settings and help: a flag overrides the environment, which overrides the configuration file; completions,
//! manual pages and examples exist for every command.

use crate::test_dir::{Output, SPHERE, TestDir, failure};
use halfline::frame::color_map::ColorMap;

const COMMANDS: [&str; 10] =
    ["render", "view", "adapters", "compare", "merge", "measure", "plan", "trace", "completions", "man"];

const RENDER: &str = "render --backend cpu one.xyz -o a.png";

fn dir() -> TestDir {
    TestDir::new(&[("one.xyz", "1\none\nC 0 0 0\n")])
}

/// The shape of the rendered picture: height, width and channels.
fn shape(dir: &TestDir, options: &str, environment: &[(&str, &str)]) -> Vec<usize> {
    let Output { code, err, .. } =
        dir.run_with(&format!("render --backend cpu one.xyz -o a.png{options}"), environment);
    assert_eq!(code, 0, "{options} {environment:?}: {err}");
    dir.array("a.png").1
}

#[test]
fn a_flag_overrides_the_environment_which_overrides_the_file() {
    let dir = dir();
    dir.put("c.toml", "size = \"20x10\"\ntransparent = true\n");
    let file = ("HALFLINE_CONFIG", "c.toml");
    let variable = ("HALFLINE_SIZE", "22x11");
    assert_eq!(shape(&dir, "", &[]), [512, 512, 3]);
    assert_eq!(shape(&dir, "", &[file]), [10, 20, 4]);
    assert_eq!(shape(&dir, "", &[variable]), [11, 22, 3]);
    assert_eq!(shape(&dir, "", &[variable, file]), [11, 22, 4]);
    assert_eq!(shape(&dir, " --size 24x12", &[variable, file]), [12, 24, 4]);
    assert_eq!(
        shape(&dir, " --size 24x12 --background 1,1,1", &[file]),
        [12, 24, 3],
        "a background on the command line overrides transparency in the file"
    );
    for truth in ["1", "true", "yes"] {
        assert_eq!(shape(&dir, " --size 9x9", &[("HALFLINE_TRANSPARENT", truth)]), [9, 9, 4]);
    }
    assert_eq!(shape(&dir, " --size 9x9", &[("HALFLINE_TRANSPARENT", "0")]), [9, 9, 3]);
    // The default path, without a variable.
    std::fs::create_dir(dir.path("halfline")).expect("a folder");
    dir.put("halfline/config.toml", "size = \"7x5\"\n");
    assert_eq!(shape(&dir, "", &[]), [5, 7, 3]);
    assert_eq!(shape(&dir, "", &[file]), [10, 20, 4], "a file named by the variable");
}

#[test]
fn an_invalid_setting_is_refused_at_its_place() {
    let dir = dir();
    let bad = |text: &str, expected: &[&str]| {
        dir.put("c.toml", text);
        dir.refused_with(2, RENDER, &[("HALFLINE_CONFIG", "c.toml")], expected);
    };
    bad("shade = \"flat\"\nsamples = 0\n", &["c.toml:2:11: `0` is not a valid value of samples", "--samples"]);
    bad("no_return = \"x\"\n", &["c.toml:1:13: ", "inf, nan, zero"]);
    bad("unit = -1\n", &["c.toml:1:8: ", "positive"]);
    bad("transparent = \"perhaps\"\n", &["c.toml:1:15: "]);
    bad("\neye = [0, 0, 1]\n", &["c.toml:2:1: `eye`", "samples"]);
    bad("size = [1, 2]\n", &["c.toml:1:8: "]);
    bad("size = \n", &["c.toml:1:"]);
    let missing = [("HALFLINE_CONFIG", "missing.toml")];
    dir.refused_with(8, RENDER, &missing, &["missing.toml"]);
    dir.refused_with(2, RENDER, &[("HALFLINE_SAMPLES", "0")], &["--samples", "0"]);
    dir.refused_render(2, "one.xyz -o a.png --samples 0", &["--samples", "0"]);
}

/// A tolerance of rendering in the environment or the file does not apply to the comparison of files.
#[test]
fn compare_takes_its_tolerance_from_its_own_flag_alone() {
    let dir = dir();
    dir.put("c.toml", "tolerance = 1e3\n");
    for (name, color) in [("a.npy", "0,0,0"), ("b.npy", "1,1,1")] {
        dir.render(&format!("one.xyz --size 4x4 -o {name} --background {color}"));
    }
    let environment = [("HALFLINE_CONFIG", "c.toml"), ("HALFLINE_TOLERANCE", "1e3")];
    assert_eq!(dir.run_with("compare a.npy b.npy", &environment).code, 1);
    assert_eq!(dir.run_with("compare a.npy b.npy --tolerance 1e3", &environment).code, 0);
}

#[test]
fn every_name_of_the_file_is_an_option_of_render() {
    let dir = dir();
    // The error of an unknown name lists all names.
    dir.put("c.toml", "bogus = 1\n");
    let refused = dir.run_with("render one.xyz -o a.png", &[("HALFLINE_CONFIG", "c.toml")]);
    let names = refused.err.trim_end().split_once("the options are ").expect("a list").1.to_owned();
    let names: Vec<_> = names.split(", ").collect();
    assert!(names.len() >= 20, "{names:?}");
    let help = dir.good("render --help").text().split_whitespace().collect::<Vec<_>>().join(" ");
    for name in names {
        assert!(help.contains(&format!("--{name} ")) || help.contains(&format!("--{name}[")), "{name}");
        let variable = format!("[env: HALFLINE_{}]", name.to_uppercase().replace('-', "_"));
        assert!(help.contains(&variable), "{variable}");
    }
}

#[test]
fn every_command_has_completions_a_manual_page_and_examples() {
    let dir = dir();
    for shell in ["bash", "zsh", "fish"] {
        let script = dir.good(&format!("completions {shell}")).text();
        let named = COMMANDS.iter().chain(&["radius-scale", "color-by"]).all(|name| script.contains(name));
        assert!(named, "{shell}: {script}");
    }
    assert_eq!(dir.run("completions abacus").code, 2);
    let manual = dir.good("man").text();
    assert!(manual.contains(".TH halfline 1"), "{manual}");
    std::fs::create_dir(dir.path("man1")).expect("a folder");
    assert_eq!(dir.run("man --out man1").code, 0);
    assert_eq!(dir.run("man --out missing").code, 8);
    for name in COMMANDS {
        assert!(manual.contains(&format!("halfline\\-{name}(1)")), "{name} in {manual}");
        let page = String::from_utf8(dir.get(&format!("man1/halfline-{name}.1"))).expect("UTF-8");
        assert!(page.contains("SYNOPSIS") && page.contains("Examples:"), "{name}: {page}");
        let help = dir.good(&format!("{name} --help")).text();
        assert!(help.contains("Examples:\n") && help.contains(&format!("  halfline {name}")), "{name}: {help}");
    }
}

/// The commands that are printed work, once their files are there.
#[test]
fn render_without_arguments_prints_three_commands_that_work() {
    let dir = dir();
    dir.refused(2, "render", &["error: halfline render needs a file", "halfline render --help"]);
    assert_eq!(
        failure(&dir.run("render --json").text(), 2),
        "the following required arguments were not provided: <SCENE>"
    );
    let err = dir.run("render").err;
    let commands: Vec<_> = err.lines().filter_map(|line| line.strip_prefix("  halfline ")).collect();
    assert_eq!(commands.len(), 3, "{err}");
    dir.put("molecule.pdb", "ATOM      1  CA  ALA A   1       0.000   0.000   0.000  1.00  0.00           C\n");
    dir.put("particles.csv", "x,y,z,radius,speed\n0,0,0,1,3\n3,0,0,1,4\n");
    dir.put("scene.toml", SPHERE);
    for command in commands {
        dir.good(&format!("{command} --backend cpu --size 20x20"));
        for file in command.split_whitespace().filter(|word| word.contains(".png") || word.contains(".svg")) {
            assert!(!dir.get(file).is_empty(), "{command}");
        }
    }
    assert_eq!(dir.array("depth.npy").1, [20, 20]);
}

#[test]
fn the_help_of_map_lists_all_maps() {
    let help = TestDir::new(&[]).good("render --help").text().split_whitespace().collect::<Vec<_>>().join(" ");
    let maps = ColorMap::names().join(", ");
    assert!(help.contains(&format!("Colour map: {maps} [default")), "{maps}");
}

#[test]
fn help_is_in_groups_by_task() {
    let help = dir().good("render --help").text();
    let headings: Vec<_> = help.lines().filter(|line| !line.starts_with(' ') && line.ends_with(':')).collect();
    let expected =
        ["Input", "Spheres and colours", "Camera", "Image", "Light", "Accuracy and speed", "Output", "Reporting"];
    let found: Vec<_> = headings.iter().map(|line| line.trim_end_matches(':')).collect();
    let places: Vec<_> = expected.iter().map(|name| found.iter().position(|heading| heading == name)).collect();
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{found:?}");
    // Every option has a place in a group; Options has --help alone.
    let options = help.split_once("Options:\n").and_then(|(_, rest)| rest.split_once("\n\n")).expect("Options").0;
    assert_eq!(options.matches("--").count(), 1, "{options}");
}
