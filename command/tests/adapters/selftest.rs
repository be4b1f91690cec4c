//! The promise: a method whose arithmetic fails the self-test of an adapter is refused there, and `halfline adapters` says
//! which checks failed.

use crate::adapter::{admitted, gpu_or_skip};
use crate::data::in_checkout;
use crate::test_dir::{Output, TestDir};
use halfline::intersect::Method;

#[test]
fn a_method_that_fails_the_self_test_is_refused_with_code_7() {
    let Some(mut gpu) = gpu_or_skip() else { return };
    let methods = admitted(&mut gpu);
    let scene = &*in_checkout("scenes/canonical.toml").display().to_string();
    let dir = TestDir::new(&[]);
    for &method in Method::ALL {
        let render = |backend: &str| {
            dir.run(&["render", scene, "--size", "16x16", "--backend", backend, "--json", "--method", method.name()])
        };
        let Output { code, out, err } = render("gpu");
        if methods.contains(&method) {
            assert_eq!(code, 0, "{}: {err}", method.name());
        } else {
            assert_eq!(code, 7, "{}: {err}", method.name());
            assert!(err.contains("cannot run on"), "{err}");
            // With --json a failure is one object on standard output.
            let object: serde_json::Value = serde_json::from_slice(&out).expect("an object");
            let message = object["error"]["message"].as_str();
            assert!(message.is_some_and(|message| message.contains("cannot run on")), "{object}");
        }
        assert_eq!(render("cpu").code, 0, "{} runs on the CPU", method.name());
    }
    let cache = dir.path("cache").display().to_string();
    for arguments in ["adapters --json", "adapters --json", "adapters --json --retest"] {
        let object = dir.run_with(arguments, &[("XDG_CACHE_HOME", &cache), ("LOCALAPPDATA", &cache)]).json();
        let verdict = &object["adapters"][0]["verdict"];
        assert_eq!(verdict["f64"]["reason"].is_null(), methods.contains(&Method::Native64), "{object}");
        assert_eq!(verdict["double_float"]["reason"].is_null(), methods.contains(&Method::DoubleFloat), "{object}");
        assert!(verdict["checks"].as_array().is_some_and(|checks| checks.len() > 20), "{object}");
    }
    assert!(std::fs::read_dir(dir.path("cache/halfline")).expect("a cache").count() > 0);
}
