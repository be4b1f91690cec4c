//! A record as text: one table for a scene, one per device for a suite.

use halfline::quote::count;
use halfline_measure::record::{Errors, PlaceRecord, Record, Run, SceneRecord};
use halfline_measure::total::spread;
use std::fmt::Write as _;

/// The record as text.
pub(super) fn of(record: &Record) -> String {
    match &record.scenes[..] {
        [scene] => one(record, scene),
        _ => suite(record),
    }
}

/// One scene: a row for each method on each device.
fn one(record: &Record, scene: &SceneRecord) -> String {
    let [width, height] = scene.size;
    let mut rows = vec![
        [
            "method",
            "place",
            "first ms",
            "steady ms",
            "ns/ray",
            "wrong",
            "share",
            "max relative",
            "normal deg",
            "in f32",
        ]
        .map(String::from),
    ];
    for run in &record.runs {
        let place = record.places.get(run.place).map_or("", |place| &place.backend).to_owned();
        let ms = |x: Option<f64>| x.map_or("-".into(), |x| format!("{x:.1}"));
        let steady = spread(&run.steady_ms).map(|[_, median, _]| median);
        let rays = run.errors.pixels.max(1) as f64;
        rows.push(match &run.refused {
            Some(_) => [run.method.as_str(), &place, "refused", "-", "-", "-", "-", "-", "-", "-"].map(String::from),
            None => [
                run.method.clone(),
                place,
                ms(run.first_ms),
                ms(steady),
                ms(steady.map(|ms| ms * 1e6 / rays)),
                run.errors.wrong().to_string(),
                format!("{:.2} %", 100.0 * run.errors.wrong_share()),
                error(run.errors.relative.max),
                error(run.errors.normal.max),
                run.certified.map_or("-".into(), |share| format!("{:.2} %", 100.0 * share)),
            ],
        });
    }
    let mut text = format!("{}: {}, {width} x {height} pixels\n", scene.name, count(scene.spheres, "sphere"));
    for place in &record.places {
        let _ = writeln!(text, "{}", heading(place));
    }
    text.push('\n');
    text += &aligned(&rows);
    text + &refusals(record, None)
}

/// Many scenes: a row for each, a column for each method; Markdown, as in docs/accuracy.md.
fn suite(record: &Record) -> String {
    let mut text = String::new();
    for (n, place) in record.places.iter().enumerate() {
        let runs: Vec<&Run> = record.runs.iter().filter(|run| run.place == n).collect();
        let mut methods: Vec<&str> = Vec::new();
        for run in &runs {
            if !methods.contains(&run.method.as_str()) {
                methods.push(&run.method);
            }
        }
        let proof = if methods.contains(&"certified") { [" in f32 |", " error / bound |"] } else { [""; 2] };
        let _ = writeln!(text, "{}{}\n", if n > 0 { "\n" } else { "" }, heading(place));
        let _ = writeln!(text, "| scenes | pixels | {} |{}", methods.join(" | "), proof.concat());
        let _ = writeln!(
            text,
            "|---|---{}|{}",
            "|---".repeat(methods.len()),
            "---|".repeat(proof.concat().matches('|').count())
        );
        for (k, scene) in record.scenes.iter().enumerate() {
            let own: Vec<&Run> = runs.iter().copied().filter(|run| run.scene == k).collect();
            row(&mut text, &scene.name, &methods, &own);
        }
        if record.scenes.len() > 1 {
            row(&mut text, "**all**", &methods, &runs);
        }
        text += &refusals(record, Some(n));
    }
    text
}

/// One row: the runs of all methods on a scene.
fn row<'a>(text: &mut String, name: &str, methods: &[&'a str], runs: &[&'a Run]) {
    let of = |method: &'a str| runs.iter().copied().filter(move |run| run.method == method);
    let pixels = methods.iter().map(|m| of(m).map(|run| run.errors.pixels).sum::<u64>()).max().unwrap_or(0);
    let cell = |&method: &&'a str| match of(method).any(|run| run.refused.is_some()) {
        true => "refused".into(),
        false => {
            let wrong: u64 = of(method).map(|run| run.errors.wrong()).sum();
            format!("{wrong}, {}", error(worst(of(method).map(|run| run.errors.relative.max))))
        }
    };
    let cells: Vec<String> = methods.iter().map(cell).collect();
    let _ = write!(text, "| {name} | {pixels} | {} |", cells.join(" | "));
    if methods.contains(&"certified") {
        let proved: f64 = of("certified").map(proved).sum();
        let share = of("certified").filter_map(|run| run.of_bound).fold(0.0, f64::max);
        let _ = write!(text, " {:.1} % | {share:.2} |", 100.0 * proved / pixels.max(1) as f64);
    }
    text.push('\n');
}

/// The number of pixels that f32 proved.
fn proved(run: &Run) -> f64 {
    let Errors { pixels, .. } = run.errors;
    run.certified.unwrap_or(0.0) * pixels as f64
}

/// The largest; `None` is infinite and larger than all others.
fn worst(mut errors: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    errors.try_fold(0.0, |a: f64, b| Some(a.max(b?)))
}

fn error(x: Option<f64>) -> String {
    match x {
        None => "inf".into(),
        Some(0.0) => "0".into(),
        Some(x) => format!("{x:.0e}"),
    }
}

fn heading(place: &PlaceRecord) -> String {
    let PlaceRecord { backend, adapter, driver, .. } = place;
    if backend == "cpu" { format!("cpu: {driver}") } else { format!("{backend}: {adapter} ({driver})") }
}

/// Why methods did not run, each reason once.
fn refusals(record: &Record, place: Option<usize>) -> String {
    let mut lines: Vec<String> = Vec::new();
    for run in record.runs.iter().filter(|run| place.is_none_or(|place| place == run.place)) {
        if let Some(reason) = &run.refused {
            let line = format!("{} is refused: {reason}", run.method);
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
    }
    if lines.is_empty() { String::new() } else { format!("\n{}\n", lines.join("\n")) }
}

/// Columns as wide as their widest cell, text aligned to the left and numbers to the right.
fn aligned<const N: usize>(rows: &[[String; N]]) -> String {
    let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    let line = |row: &[String; N]| {
        let cell = |(k, cell): (usize, &String)| match k {
            0 | 1 => format!("{cell:<0$}", widths[k]),
            _ => format!("{cell:>0$}", widths[k]),
        };
        row.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}
