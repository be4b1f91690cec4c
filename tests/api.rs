//! The public names of halfline-particles are those of `particles/API.txt`, so that no change of them goes unseen.

#[path = "common/home.rs"]
mod home;

use home::home;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// The text of all files of the crate without their tests.
fn sources(folder: &Path, all: &mut Vec<String>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, all);
        } else if path.extension().is_some_and(|ending| ending == "rs") && !path.ends_with("tests.rs") {
            let text = fs::read_to_string(&path).expect("a file");
            all.push(text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default().to_owned());
        }
    }
}

/// The names that the crate exports, unless the line before hides them.
fn exported(root: &str) -> Vec<String> {
    let mut names = Vec::new();
    for (place, _) in root.match_indices("\npub use ") {
        if root[..place].ends_with("#[doc(hidden)]") {
            continue;
        }
        let tree = root[place + 9..].split(';').next().unwrap_or_default();
        let list = tree.rsplit("::").next().unwrap_or_default();
        names.extend(list.split(['{', '}', ',']).map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()));
    }
    names
}

/// The lines of the block that follows `head` in a source, up to the brace at its indentation.
fn block<'a>(source: &'a str, head: &str) -> Option<&'a str> {
    let begin = source.find(head)?;
    let text = &source[begin..];
    let end = text.find("\n}").unwrap_or(text.len());
    Some(&text[..end])
}

/// The public members of a block, each on a line: fields, variants, functions with their types, constants.
fn members(block: &str, is_enum: bool) -> Vec<String> {
    let (mut found, mut is_hidden) = (Vec::new(), false);
    let lines: Vec<&str> = block.lines().skip(1).collect();
    for (n, line) in lines.iter().enumerate() {
        let text = line.strip_prefix("    ").filter(|text| !text.starts_with(' ')).unwrap_or_default();
        let is_variant = is_enum && text.starts_with(|c: char| c.is_ascii_uppercase());
        if text.starts_with("pub ") || is_variant {
            // A function may have its types on several lines.
            let whole = lines[n..].iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
            let function = whole.split(" {").next().filter(|_| text.contains("fn "));
            let shown = function.unwrap_or(text);
            if !is_hidden {
                found.push(shown.trim_end_matches([',', ' ', ';']).replace("( ", "(").replace(", )", ")"));
            }
        }
        if !text.starts_with("///") {
            is_hidden = text.contains("doc(hidden)");
        }
    }
    found
}

/// The public interface, a line for each item.
fn interface() -> String {
    let folder = home().join("particles/src");
    let root = fs::read_to_string(folder.join("lib.rs")).expect("the root");
    let mut all = Vec::new();
    sources(&folder, &mut all);
    let mut lines = BTreeSet::new();
    for name in exported(&root) {
        lines.insert(name.clone());
        for source in &all {
            for (kind, is_enum) in [("struct", false), ("enum", true)] {
                for head in [format!("\npub {kind} {name} {{"), format!("\npub {kind} {name}<'a> {{")] {
                    let found = block(source, &head).map(|block| members(block.trim_start(), is_enum));
                    lines.extend(found.into_iter().flatten().map(|member| format!("{name}: {member}")));
                }
            }
            for head in [format!("\nimpl {name} {{"), format!("\nimpl<'a> {name}<'a> {{")] {
                let mut rest = source.as_str();
                while let Some(place) = rest.find(&head) {
                    let block = block(&rest[place..], &head).expect("a block");
                    lines.extend(
                        members(block.trim_start(), false).into_iter().map(|member| format!("{name}: {member}")),
                    );
                    rest = &rest[place + head.len()..];
                }
            }
        }
    }
    lines.into_iter().fold(String::new(), |all, line| all + &line + "\n")
}

#[test]
fn the_public_interface_of_the_particles_is_the_listed_one() {
    let path = home().join("particles/API.txt");
    let found = interface();
    if std::env::var_os("HALFLINE_WRITE").is_some() {
        fs::write(&path, &found).expect("the list");
    }
    let listed = fs::read_to_string(&path).expect("particles/API.txt");
    let mend = "HALFLINE_WRITE=1 cargo test -p halfline-tests --test api writes it";
    assert!(found == listed, "particles/API.txt is not the interface of the crate: {mend}");
    for item in ["Frames", "Keep: All", "Particles: pub positions: Vec<[f64; 3]>"] {
        assert!(found.lines().any(|line| line == item), "no {item}");
    }
    assert!(!found.contains("reading"), "what is hidden is not listed");
}
