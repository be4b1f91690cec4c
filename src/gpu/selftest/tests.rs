use super::*;
use crate::gpu::device;
use crate::gpu::validate::validate;
use crate::testing::adapter_or_skip;

/// The pinned adapter, opened.
fn gpu() -> Option<Gpu> {
    let found = adapter_or_skip()?;
    Some(Gpu::new(device::open(&found).expect("a device"), found.summary))
}

/// The known verdicts of the two software adapters; any other adapter must only have a verdict.
#[test]
fn known_adapters_have_their_known_verdicts() {
    let Some(mut gpu) = gpu() else { return };
    let verdict = gpu.measure().expect("a verdict");
    println!("{} ms", verdict.milliseconds);
    for check in &verdict.checks {
        println!("{} {} {:?}", if check.passed { "ok  " } else { "FAIL" }, check.name, check.detail);
    }
    let passed = |name: &str| verdict.checks.iter().find(|c| c.name == name).expect("it was tried").passed;
    let llvmpipe = gpu.summary.name.contains("llvmpipe");
    if !llvmpipe && !gpu.summary.name.contains("SwiftShader") {
        return;
    }
    assert!(verdict.f32 && verdict.strict_twin, "{verdict:?}");
    assert_eq!(verdict.rounding, Rounding::NearestEven);
    assert!(verdict.div_ulp <= 0.5 && verdict.sqrt_ulp <= 0.5, "{verdict:?}");
    assert_eq!(verdict.double_float.reason, None, "barrier and split hold");
    assert!(!passed("TwoProd by fma, plain") && !passed("TwoProd by fma, barrier"), "fma is not fused");
    for name in ["TwoSum, plain", "FastTwoSum, plain", "TwoDiff, plain", "no reassociation"] {
        assert_eq!(passed(name), !llvmpipe, "{name}: Mesa folds (a + b) - a, SwiftShader does not");
    }
    assert_eq!(verdict.flushes_subnormals, !llvmpipe);
    assert_eq!(verdict.f64.reason.is_none(), gpu.summary.f64, "{:?}", verdict.f64);
}

/// Negative control: with one bit of one answer changed, a check that passed fails.
#[test]
fn a_planted_wrong_answer_is_caught() {
    let Some(mut gpu) = gpu() else { return };
    for trial in trials(gpu.has_f64()) {
        let answers = gpu.answer(&trial).expect("answers");
        let before = (trial.judge)(&trial.cases, &answers);
        // 8 ulps of one operation; 2^-11 of a low word; the sign of a discriminant's high word.
        let (words, bit) = match trial.name {
            "double_float" => (trial.words[1], 12),
            "solve" => (1, 31),
            _ => (trial.words[1], 3),
        };
        for word in 0..words {
            let mut planted = answers.clone();
            planted[5 * trial.words[1] + word] ^= 1 << bit;
            let after = (trial.judge)(&trial.cases, &planted);
            let numbers = |checks: &[Check]| checks.iter().map(|c| c.detail.clone()).collect::<Vec<_>>();
            let fell = before.iter().zip(&after).any(|(a, b)| a.passed && !b.passed);
            // This adapter fails the check anyway.
            let of = if word < 24 { word / 2 } else { word - 12 };
            let lost = trial.name == "transforms" && !before[of].passed;
            assert!(fell || lost, "{} word {word}: {:?}", trial.name, numbers(&after));
        }
    }
}

/// Answers of NaN, of all ones, and missing answers.
#[test]
fn nonsense_fails_and_does_not_panic() {
    for trial in trials(true) {
        let count = trial.cases.len() / trial.words[0] * trial.words[1];
        for word in [0, u32::MAX, 0x7f80_0000, 1] {
            let checks = (trial.judge)(&trial.cases, &vec![word; count]);
            assert!(checks.iter().any(|check| !check.passed), "{} all {word:x}", trial.name);
            serde_json::to_string(&checks).expect("JSON");
        }
        (trial.judge)(&trial.cases, &[]);
    }
    let nothing = conclude(Vec::new(), true);
    assert!(!nothing.f32 && !nothing.strict_twin && nothing.f64.by.is_none() && nothing.double_float.by.is_none());
}

/// Checks of the shaders that need no adapter: capabilities, words per case and answer, workgroups.
#[test]
fn shaders_validate_and_declare_their_words() {
    for trial in trials(true) {
        let source = Source::new(trial.parts.clone());
        let (module, _) = validate(&source, trial.capabilities).expect(trial.name);
        let constant = |name: &str| {
            let found = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name)).expect(name).1.init;
            match module.global_expressions[found] {
                naga::Expression::Literal(naga::Literal::U32(x)) => x as usize,
                ref other => panic!("{name} is {other:?}"),
            }
        };
        let size = if trial.name == "f64" { 2 } else { 1 };
        assert_eq!([constant("WORDS_IN"), constant("WORDS_OUT")].map(|n| n * size), trial.words, "{}", trial.name);
        assert_eq!(module.entry_points[0].workgroup_size, [super::super::input::GROUP, 1, 1]);
    }
}

/// A verdict is read back from the cache; broken files, other keys and unwritable folders count as no cache.
#[test]
fn the_cache_is_used_only_for_the_same_adapter_and_version() {
    let adapter = device::AdapterSummary {
        index: 0,
        name: "unknown adapter".into(),
        kind: "other",
        backend: "vulkan".into(),
        driver: "1".into(),
        subgroup: None,
        f64: false,
        max_binding: 0,
        max_buffer: 0,
    };
    let verdict = conclude(Vec::new(), false);
    let folder = tempfile::tempdir().expect("a folder");
    let at = || Some(folder.path().join("deeper"));
    let read = |key: &str| cache::read(at(), &adapter, key);
    assert_eq!(read("key"), None);
    cache::write(at(), &adapter, "key", &verdict);
    assert_eq!(read("key"), Some(verdict.clone()));
    assert_eq!(read("another driver"), None);
    cache::write(at(), &adapter, "another driver", &verdict);
    assert_eq!(read("key"), None, "one file per adapter");
    let file = std::fs::read_dir(folder.path().join("deeper")).expect("it was made").next().expect("one").expect("one");
    std::fs::write(file.path(), "{\"key\": \"another driver\", \"verdict\": ").expect("broken on purpose");
    assert_eq!(read("another driver"), None);
    cache::write(None, &adapter, "key", &verdict);
    cache::write(Some(file.path()), &adapter, "key", &verdict);
}
