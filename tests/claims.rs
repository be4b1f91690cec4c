//! docs/claims.md names code and tests that exist; docs/certificate.md names the constants of the proof.

mod constants;
#[path = "common/home.rs"]
mod home;

use home::home;

/// `file#name` and files of theorems, in backquotes.
fn named(cell: &str) -> impl Iterator<Item = (&str, Option<&str>)> {
    let quoted = cell.split('`').skip(1).step_by(2).filter(|word| word.contains('/') && !word.contains('*'));
    quoted.map(|word| word.split_once('#').map_or((word, None), |(file, name)| (file, Some(name))))
}

fn text(file: &str) -> Option<String> {
    std::fs::read_to_string(home().join(file)).ok()
}

fn is_declared(text: &str, name: &str) -> bool {
    let follows = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    let declared = |word: &str| text.split(&format!("{word} {name}")).skip(1).any(follows);
    ["fn", "const", "struct", "let"].into_iter().any(declared)
}

fn is_test(text: &str, name: &str) -> bool {
    let Some((before, _)) = text.split_once(&format!("fn {name}()")) else { return false };
    before.trim_end().ends_with("#[test]")
}

/// The errors in the rows of the tables, and the number of rows.
fn faults(claims: &str) -> (Vec<String>, usize) {
    let mut faults = Vec::new();
    let mut rows = 0;
    // Other tables follow.
    let claims = claims.split("## Test coverage").next().unwrap_or_default();
    for line in claims.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| section")) {
        rows += 1;
        let cells: Vec<_> = line.replace("\\|", "/").split('|').map(str::to_owned).collect();
        let [_, _, claim, code, tests, _] = &cells[..] else {
            faults.push(format!("not four cells: {line}"));
            continue;
        };
        for (file, name) in named(code) {
            let found = name.is_some_and(|name| text(file).is_some_and(|text| is_declared(&text, name)));
            faults.extend((!found).then(|| format!("{claim}: no {file}#{}", name.unwrap_or_default())));
        }
        for (file, name) in named(tests) {
            let found = text(file).is_some_and(|text| name.is_none_or(|name| is_test(&text, name)));
            faults.extend((!found).then(|| format!("{claim}: no test {file}#{}", name.unwrap_or_default())));
        }
        for (cell, what) in [(code, "code"), (tests, "test")] {
            faults.extend(named(cell).next().is_none().then(|| format!("{claim}: no {what}")));
        }
    }
    (faults, rows)
}

#[test]
fn every_claim_names_code_and_a_test_that_exist() {
    let claims = text("docs/claims.md").expect("docs/claims.md");
    let (faults, rows) = faults(&claims);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(rows > 40, "{rows} rows");
    // Every theorem is named in a row.
    let folder = home().join("tests/gappa");
    let theorems = std::fs::read_dir(folder).expect("tests/gappa").map(|entry| entry.expect("a file").path());
    for theorem in theorems.filter(|path| path.extension().is_some_and(|ending| ending == "g")) {
        let name = format!("tests/gappa/{}", theorem.file_name().expect("a name").to_string_lossy());
        assert!(claims.contains(&name), "no row names {name}");
    }
}

#[test]
fn a_row_without_code_or_test_is_found() {
    let row = |code: &str, test: &str| faults(&format!("| 1 | a claim | `{code}` | `{test}` |\n")).0.len();
    let test = "tests/claims.rs#a_row_without_code_or_test_is_found";
    assert_eq!(row("src/scene/camera.rs#axes", test), 0);
    assert_eq!(row("src/scene/camera.rs#axe", test), 1);
    assert_eq!(row("src/cameras.rs#axes", test), 1);
    assert_eq!(row("src/scene/camera.rs#axes", "tests/claims.rs#row"), 1);
    assert_eq!(row("src/scene/camera.rs#axes", "tests/gappa/nothing.g"), 1);
    assert_eq!(row("nothing", test), 1);
}
