//! The report: a line of JSON for every step, and all lines as one JSON file.

use super::Result;
use serde_json::{Value, json};

/// A line about a step that has ended: what it printed, and the end of its messages.
pub(crate) fn line(step: &str, words: &str, code: i64, seconds: f64, files: [&str; 2]) -> Result {
    let [out, err] = files.map(|path| String::from_utf8_lossy(&std::fs::read(path).unwrap_or_default()).into_owned());
    let last = out.lines().last().unwrap_or_default();
    let result: Value = serde_json::from_str(&out).or_else(|_| serde_json::from_str(last)).unwrap_or_default();
    // Standard output is the result, or has messages like standard error.
    let messages = || out.lines().filter(|_| result.is_null()).chain(err.lines());
    let is_telling = |line: &&str| {
        let words = ["test result", "panicked", "FAILED", "rror"];
        words.iter().any(|word| line.contains(word)) && !line.ends_with(" ok")
    };
    let mut tail: Vec<&str> = messages().filter(is_telling).collect();
    if tail.is_empty() && result.is_null() {
        tail = messages().collect();
        tail.drain(..tail.len().saturating_sub(5));
    }
    let short = |line: &str| line.chars().take(400).collect::<String>();
    let tail: Vec<_> = tail.into_iter().take(40).map(short).collect();
    let result = if result["schema"] == "halfline-measure" { suite(&result) } else { result };
    let good = code == 0 && result["good"] != false;
    Ok(json!({
        "step": step, "words": words, "code": code, "seconds": seconds, "good": good, "tail": tail, "result": result,
    }))
}

/// The numbers of a suite's record that say whether certified answers are right.
fn suite(record: &Value) -> Value {
    let (mut runs, mut wrong, mut pixels) = (0u64, 0u64, 0u64);
    let (mut distance, mut normal) = (0.0f64, 0.0f64);
    for run in record["runs"].as_array().into_iter().flatten() {
        let errors = &run["errors"];
        let count = |name: &str| errors[name].as_u64().unwrap_or(0);
        runs += 1;
        wrong += ["false_hit", "false_miss", "wrong_sphere", "wrong_root"].map(count).iter().sum::<u64>();
        pixels += count("pixels");
        distance = distance.max(errors["relative"]["max"].as_f64().unwrap_or(0.0));
        normal = normal.max(errors["normal"]["max"].as_f64().unwrap_or(0.0));
    }
    let good = runs > 0 && wrong == 0 && distance <= 1e-5 && normal <= 1e-3f64.to_degrees();
    json!({ "runs": runs, "pixels": pixels, "wrong": wrong, "distance": distance, "normal_degrees": normal, "good": good })
}

/// Writes the report of all lines.
pub(crate) fn write(lines: &str, to: &str) -> Result<()> {
    let text = std::fs::read_to_string(lines)?;
    let all: Vec<Value> = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    std::fs::write(to, serde_json::to_string_pretty(&all)?)?;
    Ok(())
}
