//! Promises of `halfline page`: mistakes are refused before a file is written, and the page has what was asked for and no more. What it
//! does in a browser is tested by page/tests/run.

use crate::skip::skip;
use crate::test_dir::TestDir;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::GzDecoder;
use std::io::Read;

const TABLE: &str = "x,y,z,radius,kind,speed\n0,0,0,1,secret,0.5\n2,0,0,0.7,b,1.5\n0,2,0,0.5,a,2.5\n1,1,1,0.6,c,-1\n";

fn dir() -> TestDir {
    let frame = |n: u32| format!("2\n\nC 0 0 {n}\nO 2 0 {n}\n");
    TestDir::new(&[("t.csv", TABLE), ("film.xyz", &(0..4).map(frame).collect::<String>())])
}

/// Whether the command was compiled with the program of pages.
fn has_program(dir: &TestDir) -> bool {
    let output = dir.run("page t.csv -o probe.html --backend cpu");
    if output.code == 0 {
        dir.remove("probe.html");
        return true;
    }
    assert!(output.err.contains("bash page/build") && output.code == 2, "{}", output.err);
    skip("the command was compiled without the program of pages (bash page/build)");
    false
}

#[test]
fn mistakes_are_refused() {
    let dir = dir();
    if !has_program(&dir) {
        return;
    }
    for (words, expected) in [
        ("page t.csv -o p.png", &["p.png", ".html"][..]),
        ("page t.csv", &["--output"]),
        ("page t.csv -o p.html --aov id=a.npy", &["--aov"]),
        ("page t.csv -o p.html --spin 5", &["--spin"]),
        ("page t.csv -o p.html --columns mass", &["mass", "kind", "speed"]),
        ("page t.csv -o p.html --columns mass=kind", &["mass"]),
        ("page film.xyz -o p.html --frames 1,3", &["frames 1 and 3", "5-20"]),
        ("page film.xyz -o p.html --frames 3-9", &["frame 5", "4 frames"]),
        ("page t.csv -o p.html --mark \"kind a={nothing}\"", &["nothing"]),
    ] {
        dir.refused(2, words, expected);
    }
    dir.put("t.html", TABLE);
    dir.refused(2, "page t.html --format csv -o t.html", &["t.html", "overwritten"]);
    assert_eq!(dir.get("t.html"), TABLE.as_bytes());
}

/// The content of a page, unpacked.
fn content(page: &[u8]) -> Vec<u8> {
    let text = std::str::from_utf8(page).expect("text");
    let (_, packed) = text.split_once("id=\"content\">").expect("a content");
    let (packed, _) = packed.split_once('<').expect("an end");
    let bytes = STANDARD.decode(packed).expect("base64");
    let mut content = Vec::new();
    GzDecoder::new(&bytes[..]).read_to_end(&mut content).expect("a whole content");
    content
}

#[test]
fn a_page_has_the_name_of_its_file_and_no_folder() {
    let dir = dir();
    if !has_program(&dir) {
        return;
    }
    let file = dir.path("t.csv");
    let file = file.to_str().expect("text");
    dir.good(&["page", file, "-o", "p.html", "--backend", "cpu"]);
    let (page, folder) = (dir.get("p.html"), file.strip_suffix("t.csv").expect("a folder"));
    let content = content(&page);
    let has = |bytes: &[u8], word: &str| bytes.windows(word.len()).any(|part| part == word.as_bytes());
    assert!(has(&content, "t.csv") && has(&page, "t.csv"));
    assert!(!has(&content, folder) && !has(&page, folder), "{folder}");
    assert!(!has(&content, "secret"), "a text of a column that was not asked for");
}

#[test]
fn a_page_says_what_is_in_it() {
    let dir = dir();
    if !has_program(&dir) {
        return;
    }
    let report = dir.good("page t.csv -o p.html --columns speed,radius=radius --backend cpu --json").json();
    assert_eq!((report["frames"].as_u64(), report["spheres"].as_u64()), (Some(1), Some(4)));
    assert_eq!(report["columns"], serde_json::json!(["speed", "index"]));
    let text = String::from_utf8(dir.get("p.html")).expect("text");
    assert_eq!(report["bytes"].as_u64(), Some(text.len() as u64));
    let again = dir.good("page t.csv -o - --columns speed,radius=radius --backend cpu");
    assert!(again.out == text.as_bytes(), "the same words make the same bytes");
    let report = dir.good("page film.xyz -o f.html --frames 2- --backend cpu --json").json();
    assert_eq!((report["frames"].as_u64(), report["spheres"].as_u64()), (Some(3), Some(6)));
}
