//! The rooms of src/ import only downwards: the table of ARCHITECTURE.md against every `crate::` path.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The rooms in the order of the table, and the floors' names with theirs.
fn floors(architecture: &str) -> Vec<(String, Vec<String>)> {
    let table = architecture.split("| floor | rooms |").nth(1).expect("the table of floors");
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    let row = |line: &str| {
        let cells: Vec<_> = line.split('|').collect();
        let rooms = cells[2].split('`').skip(1).step_by(2).map(str::to_owned).collect();
        (cells[1].trim().to_owned(), rooms)
    };
    rows.map(row).collect()
}

/// Every .rs file under a folder except those of tests.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut found = Vec::new();
    for path in entries {
        let is_tests = path.file_stem().is_some_and(|name| name == "tests");
        if path.is_dir() && !is_tests {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") && !is_tests {
            found.push(path);
        }
    }
    found
}

/// The code of a file without comments and without its module of tests.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).fold(String::new(), |all, line| all + line + "\n")
}

/// The first names behind `crate::`, also those of a group.
fn imports(code: &str) -> BTreeSet<String> {
    let name = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        match rest.strip_prefix('{') {
            None => _ = found.insert(name(rest)),
            Some(group) => {
                // Names that follow the brace or a comma outside of inner groups.
                let mut depth = 0;
                let mut begins = true;
                for (place, c) in group.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => begins = true,
                        c if begins && c.is_alphanumeric() => {
                            found.insert(name(&group[place..]));
                            begins = false;
                        }
                        _ => {}
                    }
                }
            }
        }
    }
    found
}

/// Names that the root of the library has from a room: `pub use room::...`.
fn exported(library: &str) -> BTreeMap<String, String> {
    let mut names = BTreeMap::new();
    for line in library.lines() {
        let Some((room, rest)) = line.strip_prefix("pub use ").and_then(|line| line.split_once("::")) else { continue };
        let words = rest.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty());
        names.extend(words.map(|word| (word.to_owned(), room.to_owned())));
    }
    names
}

/// The paths of `code` of a room that point upwards.
fn upward(room: &str, code: &str, order: &[String], exported: &BTreeMap<String, String>) -> Vec<String> {
    let place = |name: &str| order.iter().position(|known| known == name);
    let mut faults = Vec::new();
    for name in imports(code) {
        // Modules before names of the root: `trace` is both.
        let target = if place(&name).is_some() { &name } else { exported.get(&name).unwrap_or(&name) };
        match place(target) {
            None => faults.push(format!("{room} imports {name}, which is in no floor")),
            Some(_) if target == room => {}
            Some(at) if Some(at) < place(room) => {}
            Some(_) => faults.push(format!("{room} imports {target}, which is not below it")),
        }
    }
    faults
}

#[test]
fn rooms_import_only_downwards() {
    let floors = floors(&read("ARCHITECTURE.md"));
    let order: Vec<String> = floors.iter().flat_map(|(_, rooms)| rooms.clone()).collect();
    let library = read("src/lib.rs");
    let exported = exported(&library);
    let modules: BTreeSet<_> = library
        .replace("#[cfg(test)]\nmod testing;\n", "")
        .lines()
        .filter_map(|line| line.trim_start_matches("pub ").strip_prefix("mod ")?.strip_suffix(';'))
        .map(str::to_owned)
        .collect();
    assert_eq!(
        order.iter().cloned().collect::<BTreeSet<_>>(),
        modules,
        "the table has every room of lib.rs and no other"
    );
    assert_eq!(order.len(), modules.len(), "each room is on one floor");
    let (mut faults, mut count) = (Vec::new(), 0);
    let source = root().join("src");
    for path in files(&source) {
        let relative = path.strip_prefix(&source).expect("within src");
        let first = relative.components().next().expect("a name").as_os_str().to_string_lossy();
        let room = first.trim_end_matches(".rs");
        if ["lib", "main", "cli", "testing"].contains(&room) {
            continue;
        }
        count += 1;
        let found = upward(room, &code(&fs::read_to_string(&path).expect("a file")), &order, &exported);
        faults.extend(found.into_iter().map(|fault| format!("src/{}: {fault}", relative.display())));
    }
    for (floor, rooms) in &floors {
        println!("{floor}: {}", rooms.join(" "));
    }
    println!("{count} files of {} rooms", order.len());
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count > 100, "{count} files");
}

#[test]
fn an_import_that_points_upwards_is_found() {
    let order: Vec<String> = ["error", "view", "render"].map(str::to_owned).to_vec();
    let exported = exported("pub use render::{Renderer, render};\npub use view::View;\n");
    let count = |text: &str| upward("view", &code(text), &order, &exported).len();
    assert_eq!(count("use crate::error::Error;"), 0);
    assert_eq!(count("use crate::view::View;"), 0, "its own");
    assert_eq!(count("use crate::render::Renderer;"), 1);
    assert_eq!(count("fn f() { crate::render::render() }"), 1);
    assert_eq!(count("use crate::{error::{Error, Result}, render};"), 1);
    assert_eq!(count("use crate::Renderer;"), 1, "by the root's name");
    assert_eq!(count("use crate::nothing::X;"), 1);
    assert_eq!(count("// crate::render\n#[cfg(test)]\nmod tests {\n    use crate::render::render;\n}\n"), 0);
}
