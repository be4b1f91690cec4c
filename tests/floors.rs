//! The rooms of src/ import only downwards, by the table of ARCHITECTURE.md, and no files import each other in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The path of a module: the names behind `crate::`.
type Module = Vec<String>;

/// The files of the library without comments and tests, by their modules. The root is lib.rs.
type Files = BTreeMap<Module, String>;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The floors in the order of the table: their names and their rooms.
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

/// The code of a file without comments and without its module of tests.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).fold(String::new(), |all, line| all + line + "\n")
}

/// Adds the files of the library under `folder`, whose module is `outer`.
fn collect(folder: &Path, outer: &[String], files: &mut Files) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let is_apart = outer.is_empty() && name == "testing";
        if name == "tests" || is_apart {
            continue;
        }
        let mut module = outer.to_vec();
        if !outer.is_empty() || name != "lib" {
            module.push(name);
        }
        if path.is_dir() {
            collect(&path, &module, files);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            files.insert(module, code(&fs::read_to_string(&path).expect("a file")));
        }
    }
}

/// A path in the code, and the name that it gets there.
type Named = (Vec<String>, String);

/// The paths of a `use` tree such as `crate::a::{b, c::{self, d as e}}`.
fn paths(tree: &str) -> Vec<Named> {
    let tree = tree.trim();
    let names = |path: &str| -> Vec<String> {
        path.split("::").map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).collect()
    };
    let Some((prefix, group)) = tree.split_once('{') else {
        let (path, alias) = tree.split_once(" as ").unwrap_or((tree, tree));
        return vec![(names(path), names(alias).pop().unwrap_or_default())];
    };
    let (mut parts, mut depth) = (vec![String::new()], 0);
    for c in group.chars() {
        match c {
            '}' if depth == 0 => break,
            ',' if depth == 0 => parts.push(String::new()),
            _ => {
                depth += i32::from(c == '{') - i32::from(c == '}');
                parts.last_mut().expect("a part").push(c);
            }
        }
    }
    let prefixed = |(path, name): Named| {
        let is_self = path == ["self"];
        let path: Vec<_> = names(prefix).into_iter().chain(path.into_iter().filter(|_| !is_self)).collect();
        let name = if name == "self" { path.last().cloned().unwrap_or_default() } else { name };
        (path, name)
    };
    parts.iter().filter(|part| !part.trim().is_empty()).flat_map(|part| paths(part)).map(prefixed).collect()
}

/// The re-exports of a file, its other imports, and its code without both.
fn uses(code: &str) -> (Vec<Named>, Vec<Named>, String) {
    let (mut exports, mut imports, mut rest) = (Vec::new(), Vec::new(), String::new());
    let mut lines = code.lines();
    while let Some(line) = lines.next() {
        let text = line.trim_start();
        let exported = text.strip_prefix("pub").and_then(|text| text.split_once("use ")).map(|(_, tree)| tree);
        let exported = exported.filter(|_| text.starts_with("pub use ") || text.starts_with("pub("));
        let Some(tree) = text.strip_prefix("use ").or(exported) else {
            rest += line;
            rest.push('\n');
            continue;
        };
        let mut tree = tree.to_owned();
        while !tree.contains(';') {
            let Some(next) = lines.next() else { break };
            tree += next;
        }
        let found = paths(tree.split(';').next().unwrap_or_default());
        if exported.is_some() { exports.extend(found) } else { imports.extend(found) }
    }
    (exports, imports, rest)
}

/// The paths in code that begin with one of these names.
fn inline(code: &str, names: &[String]) -> Vec<Vec<String>> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut found = Vec::new();
    for name in names {
        for (place, _) in code.match_indices(&format!("{name}::")) {
            let before = &code[..place];
            // `pub(in crate::room)` is not an import.
            if !before.ends_with(|c: char| is_name(c) || c == ':' || c == '$') && !before.ends_with("pub(in ") {
                let path = code[place..].split(|c: char| !is_name(c) && c != ':').next().unwrap_or_default();
                found.push(path.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect());
            }
        }
    }
    found
}

/// The names behind `crate::` of a path in `module`; `None` for paths of other crates.
fn absolute(module: &Module, path: &[String], files: &Files) -> Option<Module> {
    let first = path.first()?;
    let mut child = module.clone();
    child.push(first.clone());
    match &**first {
        "crate" => Some(path[1..].to_vec()),
        "self" | "super" => {
            let ups = path.iter().filter(|name| *name == "super").count();
            let outer = &module[..module.len().checked_sub(ups)?];
            let rest = path.iter().filter(|name| !["self", "super"].contains(&name.as_str()));
            Some(outer.iter().chain(rest).cloned().collect())
        }
        _ => files.contains_key(&child).then(|| module.iter().chain(path).cloned().collect()),
    }
}

/// The file that each file imports from, with re-exports followed to the file that declares the name.
fn imports(files: &Files) -> BTreeMap<Module, BTreeSet<Module>> {
    let mut exports: BTreeMap<(Module, String), Module> = BTreeMap::new();
    let mut wanted: BTreeMap<Module, Vec<Module>> = BTreeMap::new();
    for (module, code) in files {
        let (exported, imported, rest) = uses(code);
        for (path, name) in exported {
            exports.extend(absolute(module, &path, files).map(|target| ((module.clone(), name), target)));
        }
        let is_child = |other: &&Module| other.len() == module.len() + 1 && other.starts_with(module);
        let children = files.keys().filter(is_child).filter_map(|child| child.last().cloned());
        let heads: Vec<_> = ["crate", "super", "self"].map(str::to_owned).into_iter().chain(children).collect();
        let paths = imported.into_iter().map(|(path, _)| path).chain(inline(&rest, &heads));
        wanted.insert(module.clone(), paths.filter_map(|path| absolute(module, &path, files)).collect());
    }
    let declares = |path: &Module| {
        let (mut path, mut at, mut hops) = (path.clone(), 0, 0);
        while at < path.len() {
            let key = (path[..at].to_vec(), path[at].clone());
            if files.contains_key(&path[..=at]) {
                at += 1;
            } else if let Some(target) = exports.get(&key).filter(|_| hops < 8) {
                (path, at, hops) = (target.iter().chain(&path[at + 1..]).cloned().collect(), 0, hops + 1);
            } else {
                break;
            }
        }
        path.truncate(at);
        path
    };
    let targets = |(module, paths): (Module, Vec<Module>)| {
        let found = paths.iter().map(declares).filter(|target| *target != module).collect();
        (module, found)
    };
    wanted.into_iter().map(targets).collect()
}

/// The imports that point to a room that is not below, in the order of the rooms.
fn upward(imports: &BTreeMap<Module, BTreeSet<Module>>, order: &[String]) -> Vec<String> {
    let place = |module: &Module| order.iter().position(|room| Some(room) == module.first());
    let mut faults = Vec::new();
    for (module, targets) in imports.iter().filter(|(module, _)| !module.is_empty()) {
        for target in targets.iter().filter(|target| target.first() != module.first()) {
            let (from, to) = (module.join("::"), target.join("::"));
            match place(target) {
                None => faults.push(format!("{from} imports from `crate::{to}`, which is in no room")),
                Some(at) if Some(at) < place(module) => {}
                Some(_) => faults.push(format!("{from} imports {to}, which is not below it")),
            }
        }
    }
    faults
}

/// The files that lie on circles or between two of them, with their imports among these.
fn circles(imports: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<String> {
    let mut left: BTreeSet<&Module> = imports.keys().filter(|module| !module.is_empty()).collect();
    loop {
        let known = left.clone();
        left.retain(|module| {
            let imports_some = imports[*module].iter().any(|target| known.contains(target));
            imports_some && known.iter().any(|other| imports[*other].contains(*module))
        });
        if left.len() == known.len() {
            break;
        }
    }
    let line = |module: &&Module| {
        let targets = imports[*module].iter().filter(|target| left.contains(target)).map(|target| target.join("::"));
        format!("{} -> {}", module.join("::"), targets.collect::<Vec<_>>().join(" "))
    };
    left.iter().map(line).collect()
}

#[test]
fn rooms_import_only_downwards_and_files_in_no_circle() {
    let floors = floors(&read("ARCHITECTURE.md"));
    let order: Vec<String> = floors.iter().flat_map(|(_, rooms)| rooms.clone()).collect();
    let mut files = Files::new();
    collect(&root().join("src"), &[], &mut files);
    let rooms: BTreeSet<_> = files.keys().filter_map(|module| module.first().cloned()).collect();
    assert_eq!(order.iter().cloned().collect::<BTreeSet<_>>(), rooms, "the table has every room of src/ and no other");
    assert_eq!(order.len(), rooms.len(), "each room is on one floor");
    let imports = imports(&files);
    for (floor, rooms) in &floors {
        println!("{floor}: {}", rooms.join(" "));
    }
    let count: usize = imports.values().map(BTreeSet::len).sum();
    println!("{} files of {} rooms, {count} imports among them", files.len(), rooms.len());
    let faults = upward(&imports, &order);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    let circles = circles(&imports);
    assert!(circles.is_empty(), "files import each other in a circle:\n{}", circles.join("\n"));
    assert!(files.len() > 150 && count > 600, "{} files, {count} imports", files.len());
}

/// Files by their modules, as `a::b`.
fn tree(files: &[(&str, &str)]) -> Files {
    let module = |name: &str| name.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect();
    files.iter().map(|(name, text)| (module(name), code(text))).collect()
}

#[test]
fn an_import_that_points_upwards_is_found() {
    let order = ["error", "view", "render"].map(str::to_owned);
    let root = "pub mod view;\npub use render::{Renderer, render};\npub use view::View;\n";
    let count = |text: &str| {
        let render = ("render", "mod frame;\npub use frame::Renderer;\npub fn render() {}\n");
        let files = [("", root), ("error", ""), ("view", text), ("view::ray", ""), render, ("render::frame", "")];
        upward(&imports(&tree(&files)), &order).len()
    };
    assert_eq!(count("use crate::error::Error;"), 0);
    assert_eq!(count("use crate::view::View;"), 0, "its own");
    assert_eq!(count("use crate::render::Renderer;"), 1);
    assert_eq!(count("fn f() { crate::render::render() }"), 1);
    assert_eq!(count("use crate::{\n    error::{Error, Result},\n    render,\n};"), 1);
    assert_eq!(count("use super::render;"), 1);
    assert_eq!(count("use crate::Renderer;"), 1, "by the root's name");
    assert_eq!(count("pub(in crate::render) struct X;"), 0, "a visibility");
    assert_eq!(count("use crate::nothing::X;"), 1, "in no room");
    assert_eq!(count("// crate::render\n#[cfg(test)]\nmod tests {\n    use crate::render::render;\n}\n"), 0);
}

#[test]
fn a_circle_of_files_is_found() {
    let count = |a: &str, b: &str| {
        let files = [("", ""), ("room", "mod a;\nmod b;\npub use a::A;\npub use b::{B, C as D};\n"), ("room::a", a)];
        circles(&imports(&tree(&[&files[..], &[("room::b", b)]].concat()))).len()
    };
    assert_eq!(count("use super::b::B;", "use std::io;"), 0);
    assert_eq!(count("use super::b::B;", "use super::a::A;"), 2);
    assert_eq!(count("use super::D;", "use super::{self as room, A};"), 2, "by the names of the room");
    assert_eq!(count("fn f() { super::b::b() }", "fn b() { crate::room::a::f() }"), 2);
    assert_eq!(count("use super::b::B;", "use super::E;"), 0, "a name of the room's own file");
    assert_eq!(count("struct A;", "pub use super::a::A;"), 0, "a re-export is not a circle by itself");
}
