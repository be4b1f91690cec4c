//! The conclusions from a record: broken runs, the recommended method, and the distances at which methods fail.

use super::record::{PlaceRecord, Record, Run};
use super::total::{Total, main_place, methods, totals};

/// Methods that promise correct answers in every pixel.
const PROVED: [&str; 2] = ["certified", "exact"];

/// Share of wrong pixels at which a method counts as failed: one in a hundred is clearly visible.
const LEFT: f64 = 0.01;

/// The reasons why a run is broken; empty for a sound one. This is the definition: a method that promises every pixel
/// has a wrong one, an error exceeds its stated bound, or an error exceeds its prediction.
#[must_use]
pub fn broken(run: &Run) -> Vec<String> {
    let mut reasons = Vec::new();
    if run.refused.is_some() {
        return reasons;
    }
    if PROVED.contains(&run.method.as_str()) && run.errors.wrong() > 0 {
        reasons.push(format!("{} wrong pixels, although the method promises none", run.errors.wrong()));
    }
    if let Some(share) = run.of_bound.filter(|share| *share > 1.0) {
        reasons.push(format!("an error {share:.3} times its stated bound"));
    }
    let mut exceeds = |what: &str, unit: &str, measured: Option<f64>, predicted: Option<f64>| {
        // An unbounded prediction promises nothing; an unbounded error exceeds every finite promise.
        if let Some(predicted) = predicted.filter(|predicted| measured.is_none_or(|measured| measured > *predicted)) {
            let measured = measured.map_or("without bound".into(), |measured| format!("{measured:.1e}{unit}"));
            reasons.push(format!("{what} off {measured}, {predicted:.1e}{unit} predicted"));
        }
    };
    exceeds("outlines", " radii", run.errors.outline, run.predicted.outline);
    exceeds("distances", " of themselves", run.errors.relative.max, run.predicted.distance);
    reasons
}

/// A summary of the record in a few sentences.
#[must_use]
pub fn summary(record: &Record) -> Vec<String> {
    let totals = totals(record);
    let mut sentences: Vec<String> = (0..record.places.len())
        .filter_map(|place| {
            let here: Vec<&Total<'_>> = totals.iter().filter(|t| t.place == place && t.is_whole()).collect();
            fastest(&name(&record.places[place]), &here)
        })
        .collect();
    sentences.extend(ladder(record));
    let broken = record.runs.iter().filter(|run| !broken(run).is_empty()).count();
    sentences.push(match broken {
        0 => "No run broke a promise: no proved pixel was wrong, and no error exceeded its bound or its prediction."
            .into(),
        1 => "1 run broke a promise; it is marked BROKEN below.".into(),
        n => format!("{n} runs broke a promise; they are marked BROKEN below."),
    });
    sentences
}

/// The name of a place within a sentence.
fn name(place: &PlaceRecord) -> String {
    if place.backend == "cpu" { format!("the CPU ({})", place.driver) } else { place.adapter.clone() }
}

/// The fastest correct method of a place, and the time that the fastest incorrect one would save.
fn fastest(place: &str, totals: &[&Total<'_>]) -> Option<String> {
    let timed = |right: bool| {
        let these = totals.iter().filter(move |t| (t.wrong == 0) == right);
        these.filter_map(|t| Some((*t, t.ns?[1]))).min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let wrong = timed(false);
    let Some((right, ns)) = timed(true) else {
        let (wrong, ns) = wrong?;
        return Some(format!(
            "On {place} every method that was timed shows wrong pixels; the fastest is {} at {ns:.2} ns per ray.",
            wrong.method
        ));
    };
    let mut sentence =
        format!("On {place} the fastest method without a wrong pixel is {} at {ns:.2} ns per ray", right.method);
    if let Some((wrong, less)) = wrong.filter(|(_, less)| *less < ns) {
        sentence += &format!(
            "; {} takes {:.0} % of that time and shows {} of its pixels wrong",
            wrong.method,
            100.0 * less / ns,
            percent(wrong.wrong_share())
        );
    }
    Some(sentence + ".")
}

/// The distance at which each method failed along a ladder; methods with equal distances share a sentence.
fn ladder(record: &Record) -> Vec<String> {
    let Some(place) = main_place(record).filter(|_| is_ladder(record)) else { return Vec::new() };
    let runs = || record.runs.iter().filter(|run| run.place == place && run.refused.is_none());
    let mut fates: Vec<([Option<f64>; 2], Vec<&str>)> = Vec::new();
    for method in methods(runs()) {
        let beyond = |share: f64| {
            let of_method = runs().filter(|run| run.method == method && run.errors.wrong_share() > share);
            of_method.filter_map(|run| record.scenes.get(run.scene)?.farthest).min_by(f64::total_cmp)
        };
        let fate = [0.0, LEFT].map(beyond);
        match fates.iter_mut().find(|(other, _)| *other == fate) {
            Some((_, methods)) => methods.push(method),
            None => fates.push((fate, vec![method])),
        }
    }
    let sentence = |([first, left], methods): ([Option<f64>; 2], Vec<&str>)| {
        let names = methods.join(", ");
        match (first, left) {
            (None, _) => format!("Right in every pixel at every distance: {names}."),
            (Some(first), None) => {
                format!("First wrong pixel at {first:.0e} radii, never more than 1 % wrong: {names}.")
            }
            (Some(first), Some(left)) => {
                format!(
                    "First wrong pixel at {first:.0e} radii, off the chart (more than 1 % wrong) at {left:.0e}: {names}."
                )
            }
        }
    };
    fates.into_iter().map(sentence).collect()
}

/// Whether the scenes form a ladder: two or more, each farther than the one before.
#[must_use]
pub fn is_ladder(record: &Record) -> bool {
    let farther = |pair: &[super::record::SceneRecord]| matches!((pair[0].farthest, pair[1].farthest), (Some(a), Some(b)) if a < b);
    record.scenes.len() > 1 && record.scenes.windows(2).all(farther)
}

/// A share in per cent, with enough digits to differ from zero.
#[must_use]
pub fn percent(share: f64) -> String {
    match share {
        0.0 => "0 %".into(),
        share if share < 1e-6 => format!("{:.0e} %", 100.0 * share),
        share if share < 1e-4 => format!("{:.4} %", 100.0 * share),
        share if share < 1e-2 => format!("{:.2} %", 100.0 * share),
        share => format!("{:.1} %", 100.0 * share),
    }
}
