//! The rooms of src/ import only downwards, by the table of ARCHITECTURE.md, and no files of a crate or of the Python package
//! import each other in a circle.

#[path = "common/home.rs"]
mod home;

use home::home;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The path of a module: the names behind `crate::`.
type Module = Vec<String>;

/// The files of a crate without comments and tests, by their modules. The root is lib.rs.
type Files = BTreeMap<Module, String>;

/// The files that each file imports from.
type Imports = BTreeMap<Module, BTreeSet<Module>>;

fn read(path: impl AsRef<Path>) -> String {
    let path = home().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The rows of the table that begins with these cells: the first cell, and the words in backquotes of the second.
fn table(architecture: &str, begin: &str) -> Vec<(String, Vec<String>)> {
    let table = architecture.split(begin).nth(1).expect("the table");
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    let row = |line: &str| {
        let cells: Vec<_> = line.split('|').collect();
        let words = cells[2].split('`').skip(1).step_by(2).map(str::to_owned).collect();
        (cells[1].trim().to_owned(), words)
    };
    rows.map(row).collect()
}

/// The crates of the workspace that the crate in `folder` depends on.
fn depends_on(folder: &str) -> Vec<String> {
    let manifest = read(Path::new(folder).join("Cargo.toml"));
    let dependencies = manifest.split("\n[dependencies]\n").nth(1).expect("dependencies");
    let lines = dependencies.lines().take_while(|line| !line.starts_with('['));
    let name = |line: &str| line.split(['.', ' ', '=']).next().unwrap_or_default().to_owned();
    lines.map(name).filter(|name| name.starts_with("halfline")).collect()
}

#[test]
fn crates_import_only_crates_above() {
    let crates = table(&read("ARCHITECTURE.md"), "| crate | folder |");
    let names: Vec<_> = crates.iter().map(|(name, _)| name.trim_matches('`').to_owned()).collect();
    let mut found = 0;
    for (n, (_, folders)) in crates.iter().enumerate() {
        let folder = if folders[0] == "src/" { "." } else { &folders[0] };
        for other in depends_on(folder) {
            assert!(names[..n].contains(&other), "{} imports {other}, which is not above it", names[n]);
            found += 1;
        }
    }
    assert!(found >= 10 && names.len() >= 6, "{found} imports of {names:?}");
}

/// The code of a file without comments and without its module of tests.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).fold(String::new(), |all, line| all + line + "\n")
}

/// The folders of the crates that exist.
fn crates() -> impl Iterator<Item = &'static str> {
    let all = [
        "ground/src",
        "particles/src",
        "src",
        "command/src",
        "drawing/src",
        "files/src",
        "measure/src",
        "viewer/src",
        "python/src",
    ];
    all.into_iter().filter(|folder| home().join(folder).is_dir())
}

/// The files of the crate in `folder`.
fn files(folder: &str) -> Files {
    let mut files = Files::new();
    collect(&home().join(folder), &[], &mut files);
    files
}

/// Adds the files of a crate under `folder`, whose module is `outer`.
fn collect(folder: &Path, outer: &[String], files: &mut Files) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let is_apart = outer.is_empty() && ["main", "testing"].contains(&&*name);
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

/// The files that each file imports from: those that declare the names, and those whose re-exports lead there.
fn imports(files: &Files) -> Imports {
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
    let leads_to = |path: &Module| {
        let (mut path, mut at, mut passed) = (path.clone(), 0, Vec::new());
        while at < path.len() {
            let key = (path[..at].to_vec(), path[at].clone());
            if files.contains_key(&path[..=at]) {
                at += 1;
            } else if let Some(target) = exports.get(&key).filter(|_| passed.len() < 8) {
                (path, at) = (target.iter().chain(&path[at + 1..]).cloned().collect(), 0);
                passed.push(key.0);
            } else {
                break;
            }
        }
        path.truncate(at);
        passed.push(path);
        passed
    };
    let targets = |(module, paths): (Module, Vec<Module>)| {
        let found = paths.iter().flat_map(leads_to).filter(|target| *target != module).collect();
        (module, found)
    };
    wanted.into_iter().map(targets).collect()
}

/// The same for the modules of a Python package, also of imports inside of functions and for type checkers.
fn python_imports(folder: &Path) -> Imports {
    let name = |path: &Path| path.file_stem().expect("a name").to_string_lossy().into_owned();
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let files: BTreeMap<String, String> = entries
        .filter(|path| path.extension().is_some_and(|ending| ending == "py" || ending == "pyi"))
        .map(|path| (name(&path), fs::read_to_string(&path).expect("a file")))
        .collect();
    let targets = |text: &str| -> BTreeSet<Module> {
        let mut found = BTreeSet::new();
        let statements = text.lines().map(str::trim_start).filter_map(|line| line.strip_prefix("from ."));
        for (module, names) in statements.filter_map(|line| line.split_once(" import ")) {
            let names = names.split(',').map(|name| name.split(" as ").next().unwrap_or_default().trim());
            match module {
                "" => found.extend(names.map(|name| if files.contains_key(name) { name } else { "__init__" })),
                module => _ = found.insert(module),
            }
        }
        found.into_iter().map(|name| vec![name.to_owned()]).collect()
    };
    files.iter().map(|(name, text)| (vec![name.clone()], targets(text))).collect()
}

/// The imports that point to a room that is not below, in the order of the rooms.
fn upward(imports: &Imports, order: &[String]) -> Vec<String> {
    let place = |module: &Module| order.iter().position(|room| Some(room) == module.first());
    let mut faults = Vec::new();
    for (module, targets) in imports.iter().filter(|(module, _)| !module.is_empty()) {
        let rooms: BTreeMap<_, _> = targets.iter().map(|target| (target.first(), target)).collect();
        for target in rooms.into_values().filter(|target| target.first() != module.first()) {
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

/// The files on circles, with their imports on the same circle.
fn circles(imports: &Imports) -> Vec<String> {
    let reached = |from: &Module| {
        let (mut found, mut left) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(module) = left.pop() {
            left.extend(imports[&module].iter().filter(|target| found.insert((*target).clone())).cloned());
        }
        found
    };
    let all: BTreeMap<&Module, BTreeSet<Module>> = imports.keys().map(|module| (module, reached(module))).collect();
    let name = |module: &Module| if module.is_empty() { "the root".to_owned() } else { module.join("::") };
    let line = |module: &Module| {
        let targets = imports[module].iter().filter(|target| all[*target].contains(module)).map(name);
        format!("{} -> {}", name(module), targets.collect::<Vec<_>>().join(" "))
    };
    all.iter().filter(|(module, found)| found.contains(**module)).map(|(module, _)| line(module)).collect()
}

#[test]
fn rooms_import_only_downwards() {
    let floors = table(&read("ARCHITECTURE.md"), "| floor | rooms |");
    let order: Vec<String> = floors.iter().flat_map(|(_, rooms)| rooms.clone()).collect();
    let files = files("src");
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
    assert!(files.len() > 150 && count > 600, "{} files, {count} imports", files.len());
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let found = crates().map(|folder| (folder, imports(&files(folder))));
    let package = ("python/halfline", python_imports(&home().join("python/halfline")));
    let mut faults = Vec::new();
    for (folder, imports) in found.chain([package]) {
        let count: usize = imports.values().map(BTreeSet::len).sum();
        println!("{folder}: {} files, {count} imports among them", imports.len());
        assert!(2 * count > imports.len(), "{folder}: {} files, {count} imports", imports.len());
        let circles = circles(&imports);
        if !circles.is_empty() {
            faults.push(format!("{folder}: files import each other in a circle:\n{}", circles.join("\n")));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
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
    assert_eq!(count("use crate::Renderer;"), 2, "from the root, which is in no room, and by its name");
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

#[test]
fn a_circle_through_the_file_of_a_room_is_found() {
    let count = |room: &str, a: &str| {
        let room = format!("mod a;\nmod b;\npub use b::B;\n{room}");
        circles(&imports(&tree(&[("", ""), ("room", &room), ("room::a", a), ("room::b", "")]))).len()
    };
    assert_eq!(count("", "use super::B;"), 0);
    assert_eq!(count("use a::A;", "use super::b::B;"), 0);
    assert_eq!(count("use a::A;", "use super::B;"), 2, "by a name that the room re-exports");
    assert_eq!(count("fn f() { a::f() }", "use super::B;"), 2);
    assert_eq!(count("use a::A;", "use super::E;"), 2, "by a name of the room's own file");
}

#[test]
fn a_circle_of_python_modules_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let count = |a: &str, b: &str| {
        for (name, text) in [("__init__.py", "from .a import A\n"), ("a.py", a), ("b.py", b), ("_native.pyi", "")] {
            fs::write(folder.path().join(name), text).expect("written");
        }
        circles(&python_imports(folder.path())).len()
    };
    assert_eq!(count("from .b import B\n", "from . import _native\n"), 0);
    assert_eq!(count("from .b import B\n", "def f():\n    from .a import A\n"), 2);
    assert_eq!(count("from . import b as c, _native\n", "if TYPE_CHECKING:\n    from .a import A\n"), 2);
    assert_eq!(count("from . import A\n", ""), 2, "by a name of the package");
}
