//! The promise of messages: the library names settings, and the command writes them as its options.

use crate::test_dir::TestDir;
use halfline::quote::setting::ALL;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the whole program.
fn root() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().find(|folder| folder.join("ARCHITECTURE.md").exists()).expect("the root")
}

/// The files of the library.
fn files(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
        match path.is_dir() {
            true if !["cli", "tests"].contains(&name) => files(&path, all),
            false if name.ends_with(".rs") && !["main.rs", "testing.rs", "tests.rs"].contains(&name) => all.push(path),
            _ => {}
        }
    }
}

/// The code of a file without comments and without its tests.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a file");
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).fold(String::new(), |all, line| all + line + "\n")
}

/// The words of the command in a text, without their dashes.
fn flags(text: &str) -> impl Iterator<Item = &str> {
    let is_part = |c: char| c.is_ascii_lowercase() || c == '-';
    text.match_indices("--").filter_map(move |(at, _)| {
        let begins = !text[..at].ends_with(|c: char| c == '-' || c.is_alphanumeric());
        let word = text[at + 2..].split(|c: char| !is_part(c)).next().unwrap_or_default();
        (begins && word.starts_with(|c: char| c.is_ascii_lowercase())).then_some(word)
    })
}

#[test]
fn the_library_names_settings_and_each_has_an_option() {
    let mut all = Vec::new();
    ["ground/src", "src", "particles/src", "files/src", "drawing/src", "measure/src"]
        .iter()
        .map(|folder| root().join(folder))
        .filter(|folder| folder.is_dir())
        .for_each(|folder| files(&folder, &mut all));
    let (mut found, mut used) = (Vec::new(), BTreeSet::<&str>::new());
    // The synthetic record of plots has a command line.
    for path in all.iter().filter(|path| !path.ends_with("plot/sample.rs")) {
        let code = code(path);
        // A mend has a line for cargo.
        let own = flags(&code).filter(|flag| *flag != "path");
        found.extend(own.map(|flag| format!("{}: --{flag}", path.display())));
        let is_used = |name: &&&str| !path.ends_with("quote/setting.rs") && code.contains(&name.to_uppercase());
        used.extend(ALL.iter().filter(is_used));
    }
    // The messages of the front ends name some that no other does.
    let mut front = Vec::new();
    ["command/src", "python/src"].iter().for_each(|folder| files(&root().join(folder), &mut front));
    let front: String = front.iter().map(|path| code(path)).collect();
    used.extend(ALL.iter().filter(|name| front.contains(&name.to_uppercase())));
    assert!(all.len() > 200, "{} files", all.len());
    assert!(found.is_empty(), "name the setting instead, by quote::setting:\n{}", found.join("\n"));
    let dir = TestDir::new(&[]);
    let commands = ["render", "plan", "sift", "info", "trace", "measure", "compare", "merge"];
    let help = commands.map(|command| dir.good(&[command, "--help"]).text()).join("\n");
    let options: BTreeSet<_> = flags(&help).collect();
    for name in ALL {
        assert!(used.contains(name), "no message names {name}");
        assert!(options.contains(&*name.replace('_', "-")), "{name} is not an option");
    }
}

#[test]
fn flags_are_found_in_texts() {
    let of = |text: &str| flags(text).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(of("use --accuracy certified, or --depth-cue."), ["accuracy", "depth-cue"]);
    assert!(of("a--b --- --1 x -- y").is_empty());
}
