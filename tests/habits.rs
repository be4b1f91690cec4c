//! The promise of habits: a flag beats the environment beats the file, shells and manuals know every command, and help shows
//! how each is used.

#[path = "common/desk.rs"]
mod desk;

use desk::Desk;

const COMMANDS: [&str; 8] = ["render", "adapters", "compare", "merge", "measure", "plan", "completions", "man"];

fn desk() -> Desk {
    Desk::new(&[("one.xyz", "1\none\nC 0 0 0\n")])
}

/// The size of the picture that is rendered, and of each of its pixels' channels.
fn shape(desk: &Desk, options: &str, environment: &[(&str, &str)]) -> Vec<usize> {
    let said = desk.run_with(&format!("render --backend cpu one.xyz -o a.png{options}"), environment, b"");
    assert_eq!(said.code, 0, "{options} {environment:?}: {}", said.err);
    desk.array("a.png").1
}

#[test]
fn a_flag_beats_the_environment_beats_the_file() {
    let desk = desk();
    desk.put("c.toml", "size = \"20x10\"\ntransparent = true\n");
    let file = ("HALFLINE_CONFIG", "c.toml");
    let variable = ("HALFLINE_SIZE", "22x11");
    assert_eq!(shape(&desk, "", &[]), [512, 512, 3]);
    assert_eq!(shape(&desk, "", &[file]), [10, 20, 4]);
    assert_eq!(shape(&desk, "", &[variable]), [11, 22, 3]);
    assert_eq!(shape(&desk, "", &[variable, file]), [11, 22, 4]);
    assert_eq!(shape(&desk, " --size 24x12", &[variable, file]), [12, 24, 4]);
    assert_eq!(shape(&desk, " --size 24x12 --background 1,1,1", &[file]), [12, 24, 3], "a background beats the file");
    for truth in ["1", "true", "yes"] {
        assert_eq!(shape(&desk, " --size 9x9", &[("HALFLINE_TRANSPARENT", truth)]), [9, 9, 4]);
    }
    assert_eq!(shape(&desk, " --size 9x9", &[("HALFLINE_TRANSPARENT", "0")]), [9, 9, 3]);
    // The usual place, without a variable.
    std::fs::create_dir(desk.path("halfline")).expect("a folder");
    desk.put("halfline/config.toml", "size = \"7x5\"\n");
    assert_eq!(shape(&desk, "", &[]), [5, 7, 3]);
    assert_eq!(shape(&desk, "", &[file]), [10, 20, 4], "a file that is named");
}

#[test]
fn what_a_file_or_a_variable_cannot_mean_is_refused_where_it_stands() {
    let desk = desk();
    let bad = |text: &str, told: &[&str]| {
        desk.put("c.toml", text);
        desk.refused_with(2, "one.xyz -o a.png", &[("HALFLINE_CONFIG", "c.toml")], told);
    };
    bad("shade = \"flat\"\nsamples = 0\n", &["c.toml:2:11: `0` is no value of samples", "--samples"]);
    bad("no_return = \"x\"\n", &["c.toml:1:13: ", "inf, nan, zero"]);
    bad("unit = -1\n", &["c.toml:1:8: ", "positive"]);
    bad("transparent = \"perhaps\"\n", &["c.toml:1:15: "]);
    bad("\neye = [0, 0, 1]\n", &["c.toml:2:1: `eye`", "samples"]);
    bad("size = [1, 2]\n", &["c.toml:1:8: "]);
    bad("size = \n", &["c.toml:1:"]);
    let missing = [("HALFLINE_CONFIG", "missing.toml")];
    desk.refused_with(8, "one.xyz -o a.png", &missing, &["missing.toml"]);
    desk.refused_with(2, "one.xyz -o a.png", &[("HALFLINE_SAMPLES", "0")], &["--samples", "0"]);
    desk.refused(2, "one.xyz -o a.png --samples 0", &["--samples", "0"]);
}

/// A preference for how renderings are computed does not soften what two files are judged by.
#[test]
fn compare_tolerates_what_its_own_flag_says() {
    let desk = desk();
    desk.put("c.toml", "tolerance = 1e3\n");
    for (name, color) in [("a.npy", "0,0,0"), ("b.npy", "1,1,1")] {
        desk.render(&format!("one.xyz --size 4x4 -o {name} --background {color}"));
    }
    let environment = [("HALFLINE_CONFIG", "c.toml"), ("HALFLINE_TOLERANCE", "1e3")];
    assert_eq!(desk.run_with("compare a.npy b.npy", &environment, b"").code, 1);
    assert_eq!(desk.run_with("compare a.npy b.npy --tolerance 1e3", &environment, b"").code, 0);
}

#[test]
fn every_name_of_the_file_is_an_option_of_render() {
    let desk = desk();
    // The message of a name that is none tells all names.
    desk.put("c.toml", "bogus = 1\n");
    let said = desk.run_with("render one.xyz -o a.png", &[("HALFLINE_CONFIG", "c.toml")], b"");
    let names = said.err.trim_end().split_once("the options are ").expect("a list").1.to_owned();
    let names: Vec<_> = names.split(", ").collect();
    assert!(names.len() >= 20, "{names:?}");
    let help = String::from_utf8(desk.run("render --help").out).expect("UTF-8");
    for name in names {
        assert!(
            help.contains(&format!("--{name} "))
                || help.contains(&format!("--{name}\n"))
                || help.contains(&format!("--{name}[")),
            "{name}"
        );
        let variable = format!("[env: HALFLINE_{}]", name.to_uppercase().replace('-', "_"));
        assert!(help.contains(&variable), "{variable}");
    }
}

#[test]
fn every_command_is_completed_described_and_shown() {
    let desk = desk();
    for shell in ["bash", "zsh", "fish"] {
        let said = desk.run(&format!("completions {shell}"));
        let script = String::from_utf8(said.out).expect("UTF-8");
        assert_eq!(said.code, 0, "{}", said.err);
        let named = COMMANDS.iter().chain(&["radius-scale", "color-by"]).all(|name| script.contains(name));
        assert!(named, "{shell}: {script}");
    }
    assert_eq!(desk.run("completions abacus").code, 2);
    let manual = String::from_utf8(desk.run("man").out).expect("UTF-8");
    assert!(manual.contains(".TH halfline 1"), "{manual}");
    std::fs::create_dir(desk.path("man1")).expect("a folder");
    assert_eq!(desk.run("man --out man1").code, 0);
    assert_eq!(desk.run("man --out missing").code, 8);
    for name in COMMANDS {
        assert!(manual.contains(&format!("halfline\\-{name}(1)")), "{name} in {manual}");
        let page = String::from_utf8(desk.get(&format!("man1/halfline-{name}.1"))).expect("UTF-8");
        assert!(page.contains("SYNOPSIS") && page.contains("Examples:"), "{name}: {page}");
        let help = String::from_utf8(desk.run(&format!("{name} --help")).out).expect("UTF-8");
        assert!(help.contains("Examples:\n") && help.contains(&format!("  halfline {name}")), "{name}: {help}");
    }
}
