//! The closing line of `tests/run`: a test that prints that it was skipped counts as skipped, not as passed.

#![cfg(unix)]

use std::io::Write;
use std::process::{Command, Stdio};

/// What `tests/count` prints of a log.
fn count(log: &str) -> String {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/count");
    let mut awk = Command::new("awk");
    awk.args(["-f", script]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = awk.spawn().expect("awk runs");
    child.stdin.take().expect("a pipe").write_all(log.as_bytes()).expect("written");
    String::from_utf8(child.wait_with_output().expect("awk ends").stdout).expect("UTF-8")
}

/// Two binaries as libtest prints them: four tests pass, of which one prints SKIPPED twice; one test fails, which prints
/// SKIPPED too; one is ignored.
const LOG: &str = "
running 4 tests
test readers::a ... ok
test readers::b ... ok
test readers::c ... ok
test readers::d ... FAILED

successes:

---- readers::a stdout ----
reads /somewhere/a.pdb
not SKIPPED: this line does not begin with it

---- readers::b stdout ----
SKIPPED: no file
SKIPPED: no other file


successes:
    readers::a
    readers::b
    readers::c

failures:

---- readers::d stdout ----
SKIPPED: no file
thread 'readers::d' panicked at tests/files/readers.rs:1:1:
it fails

failures:
    readers::d

test result: FAILED. 3 passed; 1 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s

running 2 tests
test e ... ok
test f ... ignored

successes:

successes:
    e

test result: ok. 1 passed; 0 failed; 1 ignored; 0 measured; 2 filtered out; finished in 0.00s
";

#[test]
fn a_skipped_test_is_counted_as_skipped() {
    assert_eq!(count(LOG), "3 passed, 1 failed, 2 skipped\n");
}

#[test]
fn a_test_that_checks_something_is_counted_as_passed() {
    assert_eq!(count(&LOG.replace("SKIPPED: no", "without a")), "4 passed, 1 failed, 1 skipped\n");
    assert_eq!(count(""), "0 passed, 0 failed, 0 skipped\n");
}

/// Compares the lines above with those of libtest: this binary runs itself for one test.
#[test]
fn the_log_of_libtest_is_understood() {
    const INNER: &str = "HALFLINE_TEST_COUNT";
    if std::env::var_os(INNER).is_some() {
        println!("SKIPPED: planted");
        return;
    }
    let mut tests = Command::new(std::env::current_exe().expect("this test"));
    tests.args([
        "--exact",
        "--show-output",
        "the_log_of_libtest_is_understood",
        "a_skipped_test_is_counted_as_skipped",
    ]);
    let output = tests.env(INNER, "1").output().expect("the tests run");
    assert!(output.status.success());
    assert_eq!(count(&String::from_utf8_lossy(&output.stdout)), "1 passed, 0 failed, 1 skipped\n");
}
