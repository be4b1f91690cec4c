//! The words of the code: doc comments begin with the thing that they describe, and names are the field's.

#[path = "common/home.rs"]
mod home;

use home::home;
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

/// The folders of all Rust code and of the shaders.
const FOLDERS: [&str; 16] = [
    "ground",
    "particles",
    "src",
    "shaders",
    "files",
    "drawing",
    "measure",
    "viewer",
    "command",
    "python/src",
    "farm",
    "fuzz",
    "examples",
    "benches",
    "tests/answers",
    "tests/files",
];

/// Words that begin a sentence about something without a name.
const BEGINNINGS: [&str; 4] = ["What", "Those", "Where", "How"];

/// Parts of names that are English, but no words of the field.
const BANNED: [&str; 10] = ["told", "said", "held", "meet", "wanted", "asked", "lit", "seen", "beside", "aside"];

/// Names with such a part, and their reason.
const EXCEPTIONS: [(&str, &str); 2] = [("lit_by", "a key of a plan's JSON"), ("asked", "a key of a plan's JSON")];

/// The text of every file with one of the extensions, by its path.
fn texts(folders: &[&str], extensions: &[&str]) -> Vec<(String, String)> {
    let root = home();
    let mut found = Vec::new();
    let mut folders: Vec<PathBuf> =
        folders.iter().map(|folder| root.join(folder)).filter(|path| path.is_dir()).collect();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let is_text = path.extension().is_some_and(|extension| extensions.iter().any(|one| extension == *one));
            if path.is_dir() && !path.ends_with("target") {
                folders.push(path);
            } else if is_text {
                let name = path.strip_prefix(&root).expect("inside").display().to_string();
                found.push((name, fs::read_to_string(&path).expect("text")));
            }
        }
    }
    found
}

/// The text of all Rust code and of the shaders.
fn sources() -> Vec<(String, String)> {
    let found = texts(&FOLDERS, &["rs", "wgsl"]);
    assert!(found.len() > 400, "{} files", found.len());
    found
}

/// The text of all Python code. A template and the command's help, which counts as Rust code, make `options.py`.
fn python() -> Vec<(String, String)> {
    let folders = ["benches", "command/src", "docs", "farm", "python", "tests", "viewer"];
    let mut found = texts(&folders, &["py", "pyi", "in"]);
    found.retain(|(name, _)| !name.ends_with("options.py"));
    assert!(found.len() > 60, "{} files of Python", found.len());
    found
}

/// The comment of a line that documents what follows, or a file: in WGSL any comment of its own line.
fn comment<'a>(name: &str, line: &'a str) -> Option<&'a str> {
    let line = line.trim_start();
    let mark = if name.ends_with(".wgsl") { &["//"][..] } else { &["///", "//!"] };
    mark.iter().find_map(|mark| line.strip_prefix(mark)).map(str::trim_start)
}

#[test]
fn doc_comments_begin_with_the_thing_that_they_describe() {
    let mut count = 0;
    for (name, text) in sources() {
        let mut begins = true;
        for (n, line) in text.lines().enumerate() {
            let Some(comment) = comment(&name, line) else {
                begins = true;
                continue;
            };
            // A line may begin with such a word in the middle of a sentence.
            if begins {
                let word = comment.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
                assert!(!BEGINNINGS.contains(&word), "{name}:{}: begin with the noun or the verb: {comment}", n + 1);
                count += 1;
            }
            begins = comment.is_empty();
        }
    }
    assert!(count > 5_000, "{count} comments");
}

/// Code without comments and without the text of literals, which may have several lines.
fn code(text: &str) -> String {
    let mut code = String::new();
    let mut is_quoted = false;
    for line in text.lines() {
        let mut rest = line;
        while let Some(c) = rest.chars().next() {
            let is_quote = c == '"' && !code.ends_with('\'');
            if is_quote {
                is_quoted = !is_quoted;
            }
            match (is_quoted, c) {
                (true, '\\') => rest = rest.get(1..).unwrap_or_default(),
                (false, '/') if rest.starts_with("//") => break,
                (false, _) => code.push(c),
                _ => {}
            }
            rest = rest.get(rest.chars().next().map_or(0, char::len_utf8)..).unwrap_or_default();
        }
        code.push('\n');
    }
    code
}

/// The parts of a name: `HeldTree` and `held_tree` have the same.
fn parts(name: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut last = '_';
    for c in name.chars() {
        let begins = c == '_' || c.is_uppercase() && !last.is_uppercase();
        if begins && parts.last().is_some_and(|part| !part.is_empty()) {
            parts.push(String::new());
        }
        if c != '_'
            && let Some(part) = parts.last_mut()
        {
            part.extend(c.to_lowercase());
        }
        last = c;
    }
    parts
}

#[test]
fn names_are_the_fields_own() {
    assert_eq!(parts("HeldTree_x"), ["held", "tree", "x"]);
    let mut found: BTreeMap<String, String> = BTreeMap::new();
    for (file, text) in sources() {
        for name in code(&text).split(|c: char| !c.is_alphanumeric() && c != '_') {
            let is_banned = BANNED.iter().any(|word| parts(name).iter().any(|part| part == word));
            if is_banned && !EXCEPTIONS.iter().any(|(exception, _)| *exception == name) {
                found.entry(name.to_owned()).or_insert_with(|| file.clone());
            }
        }
    }
    assert!(EXCEPTIONS.len() <= 10 && EXCEPTIONS.iter().all(|(_, reason)| !reason.is_empty()));
    assert!(found.is_empty(), "{} names say nothing of the field: {found:?}", found.len());
}

/// Phrases that hide the noun that they stand for. No code, text of a program or page has one.
const VAGUE: [&str; 3] = ["those of", "that of", "of which"];

/// The most words in a sentence of a page.
const LONGEST: usize = 35;

/// The pages of the project, without its log of changes and texts of others.
fn pages() -> Vec<(String, String)> {
    let root = home();
    let folders = ["", "docs", "benches/peers", "fuzz", "packaging", ".github", ".github/ISSUE_TEMPLATE"];
    let crates = FOLDERS.iter().map(|folder| folder.trim_end_matches("/src"));
    let mut found = BTreeMap::new();
    for folder in folders.into_iter().chain(crates) {
        for entry in fs::read_dir(root.join(folder)).into_iter().flatten() {
            let path = entry.expect("an entry").path();
            let name = path.strip_prefix(&root).expect("inside").display().to_string();
            let is_other = ["CHANGELOG", "CODE_OF_CONDUCT", "SECURITY"].iter().any(|other| name.starts_with(other));
            if path.extension().is_some_and(|extension| extension == "md") && !is_other {
                found.insert(name, fs::read_to_string(&path).expect("text"));
            }
        }
    }
    assert!(found.len() > 30, "{} pages", found.len());
    found.into_iter().collect()
}

/// The paragraphs and points of a page, without code, tables and headings.
fn paragraphs(page: &str) -> Vec<String> {
    let mut found = vec![String::new()];
    let mut is_code = false;
    for line in page.lines() {
        let text = line.trim_start();
        let is_fence = text.starts_with("```");
        is_code ^= is_fence;
        let is_point = text.starts_with("- ") || text.split_once(". ").is_some_and(|(n, _)| n.parse::<u32>().is_ok());
        let is_block = is_code || is_fence || line.starts_with("    ") && !is_point;
        let is_prose = !is_block && !text.starts_with(['|', '#']) && !text.is_empty();
        if is_point || !is_prose {
            found.push(String::new());
        }
        if is_prose && let Some(last) = found.last_mut() {
            *last += text;
            last.push(' ');
        }
    }
    found
}

/// The numbers of words of the sentences of a paragraph.
fn sentences(paragraph: &str) -> Vec<usize> {
    let (mut counts, mut count) = (Vec::new(), 0);
    // A code span is a word.
    let plain: String = paragraph.split('`').enumerate().map(|(n, part)| if n % 2 == 1 { "x" } else { part }).collect();
    for word in plain.split_whitespace() {
        count += 1;
        if word.trim_end_matches([')', '*', '"']).ends_with(['.', '!', '?', ':']) {
            counts.push(std::mem::take(&mut count));
        }
    }
    counts.push(count);
    counts
}

/// Whether a text has a vague phrase.
fn is_vague(text: &str) -> bool {
    let words: Vec<String> = text
        .split(|c: char| !c.is_alphanumeric() && !"'`_-".contains(c))
        .filter(|word| !word.is_empty())
        .map(str::to_lowercase)
        .collect();
    let is_one = |pair: &[String]| VAGUE.iter().any(|phrase| phrase.split(' ').eq(pair.iter().map(String::as_str)));
    words.windows(2).any(is_one)
}

#[test]
fn sentences_are_short_and_name_their_nouns() {
    assert_eq!(sentences("One two. `a b c` is `d`: (five six.) Seven"), [2, 3, 2, 1]);
    assert!(is_vague("Those of a list") && is_vague("a list\nof which") && !is_vague("of a list"));
    let (code, python, pages) = (sources(), python(), pages());
    let hidden: Vec<&String> =
        code.iter().chain(&python).chain(&pages).filter(|(_, text)| is_vague(text)).map(|(name, _)| name).collect();
    assert!(hidden.is_empty(), "files with {VAGUE:?}: name the noun in {hidden:?}");
    let long = |text: &str| paragraphs(text).iter().flat_map(|p| sentences(p)).filter(|n| *n > LONGEST).count();
    let long: Vec<&String> = pages.iter().filter(|(_, text)| long(text) > 0).map(|(name, _)| name).collect();
    assert!(long.is_empty(), "pages with sentences of more than {LONGEST} words: {long:?}");
}
