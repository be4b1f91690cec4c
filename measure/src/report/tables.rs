//! The tables of a report.

use super::html::{BADGE, escaped};
use crate::record::{Record, Run, SceneRecord, Spread};
use crate::total::{self, ns_per_ray, spread};
use crate::verdict::{broken, percent};

/// A table in a box that scrolls sideways on a narrow screen; cells are HTML.
pub(super) fn table(heads: &[&str], rows: Vec<Vec<String>>) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let heads: String = heads.iter().map(|head| format!("<th scope=\"col\">{head}</th>")).collect();
    let row = |cells: Vec<String>| {
        let cells: String = cells.iter().map(|cell| format!("<td>{cell}</td>")).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let rows: String = rows.into_iter().map(row).collect();
    format!("<div class=\"scroll\"><table>\n<thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n")
}

/// Sums over the scenes; empty for a single scene, whose own table has the same numbers.
pub(super) fn totals(record: &Record) -> String {
    if record.scenes.len() < 2 {
        return String::new();
    }
    let rows = total::totals(record).into_iter().map(|total| {
        let place = record.places.get(total.place).map_or("", |place| &place.backend);
        let is_broken = |run: &Run| run.place == total.place && run.method == total.method && !broken(run).is_empty();
        let broken = record.runs.iter().filter(|run| is_broken(run)).count();
        let badge = if broken > 0 { format!(" {BADGE} in {broken} scenes") } else { String::new() };
        vec![
            format!("{}{badge}", escaped(total.method)),
            escaped(place),
            format!("{} of {}", total.scenes, total.of_scenes),
            total
                .ns
                .map_or("\u{2013}".into(), |[least, median, most]| format!("{median:.3} ({least:.3} to {most:.3})")),
            total.pixels.to_string(),
            format!("{} ({})", total.wrong, percent(total.wrong_share())),
            bounded(total.relative),
        ]
    });
    let heads = [
        "method",
        "place",
        "scenes",
        "ns per ray (least to greatest)",
        "pixels",
        "wrong pixels",
        "largest relative error",
    ];
    table(&heads, rows.collect())
}

/// Each scene with its runs.
pub(super) fn results(record: &Record) -> String {
    let scene = |(index, scene): (usize, &SceneRecord)| {
        let runs: Vec<&Run> = record.runs.iter().filter(|run| run.scene == index).collect();
        let reasons: String = runs.iter().map(|run| shout(record, run)).collect();
        let badge = if reasons.is_empty() { "" } else { BADGE };
        let far = scene.farthest.map_or(String::new(), |far| format!(", the farthest {far:.1e} radii away"));
        // The details of a single scene, or of a broken one, are open.
        let open = if record.scenes.len() == 1 || !reasons.is_empty() { " open" } else { "" };
        let size = match (scene.size, scene.pictures) {
            ([0, _] | [_, 0], pictures) => format!("{pictures} pictures"),
            ([columns, rows], 0 | 1) => format!("{columns} \u{d7} {rows} pixels"),
            ([columns, rows], pictures) => format!("{pictures} pictures of {columns} \u{d7} {rows} pixels"),
        };
        format!(
            "<details{open}>\n<summary>{} {badge}</summary>\n<p>{}{far}; {size}, {} rays hit \
             something. Content <code>{}</code></p>\n{reasons}{}</details>\n",
            escaped(&scene.name),
            if scene.spheres == 1 { "1 sphere".into() } else { format!("{} spheres", scene.spheres) },
            scene.hits,
            escaped(scene.fingerprint.get(..16).unwrap_or(&scene.fingerprint)),
            table(&HEADS, runs.iter().map(|run| row(record, run)).collect()),
        )
    };
    record.scenes.iter().enumerate().map(scene).collect()
}

/// Why a run is broken, highlighted.
fn shout(record: &Record, run: &Run) -> String {
    let place = record.places.get(run.place).map_or("", |place| &place.adapter);
    let line = |reason: String| {
        format!("<p class=\"shout\">{BADGE} {} on {}: {}</p>\n", escaped(&run.method), escaped(place), escaped(&reason))
    };
    broken(run).into_iter().map(line).collect()
}

const HEADS: [&str; 22] = [
    "method",
    "place",
    "wrong pixels",
    "ns per ray",
    "steady frame, ms (least to greatest)",
    "first frame, ms",
    "kernels, ms",
    "false hits",
    "false misses",
    "wrong sphere",
    "wrong root",
    "outline off, radii",
    "predicted",
    "relative error: largest",
    "predicted",
    "p99",
    "median",
    "ulp of f32, largest",
    "normal off, degrees, largest",
    "proved in f32",
    "settled",
    "error / bound",
];

fn row(record: &Record, run: &Run) -> Vec<String> {
    let badge = if broken(run).is_empty() { String::new() } else { format!(" {BADGE}") };
    let place = record.places.get(run.place).map_or("", |place| &place.backend);
    let mut cells = vec![format!("{}{badge}", escaped(&run.method)), escaped(place)];
    if let Some(why) = &run.refused {
        cells.push(format!("<em>refused: {}</em>", escaped(why)));
        cells.resize(HEADS.len(), String::new());
        return cells;
    }
    let none = || "\u{2013}".to_owned();
    let errors = &run.errors;
    let Spread { median, p99, max } = errors.relative;
    let unit = |share: Option<f64>| share.map_or_else(none, percent);
    // A record stores no prediction and an unbounded one alike.
    let predicted = |bound: Option<f64>| bound.map_or("no bound".into(), |bound| format!("{bound:.1e}"));
    cells.extend([
        format!("{} ({})", errors.wrong(), percent(errors.wrong_share())),
        ns_per_ray(&[run]).map_or_else(none, |[_, median, _]| format!("{median:.3}")),
        spread(&run.steady_ms)
            .map_or_else(none, |[least, median, most]| format!("{median:.3} ({least:.3} to {most:.3})")),
        run.first_ms.map_or_else(none, |ms| format!("{ms:.2}")),
        spread(&run.kernel_ms).map_or_else(none, |[_, median, _]| format!("{median:.3}")),
        errors.false_hit.to_string(),
        errors.false_miss.to_string(),
        errors.wrong_sphere.to_string(),
        errors.wrong_root.to_string(),
        bounded(errors.outline),
        predicted(run.predicted.outline),
        bounded(max),
        predicted(run.predicted.distance),
        bounded(p99),
        bounded(median),
        bounded(errors.ulp.max),
        bounded(errors.normal.max),
        unit(run.certified),
        run.settled.map_or_else(none, |settled| settled.to_string()),
        run.of_bound.map_or_else(none, |share| format!("{share:.3}")),
    ]);
    cells
}

/// A number that may be unbounded.
fn bounded(value: Option<f64>) -> String {
    match value {
        None => "unbounded".into(),
        Some(0.0) => "0".into(),
        Some(value) => format!("{value:.1e}"),
    }
}
