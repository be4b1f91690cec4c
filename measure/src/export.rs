//! Exports a record: JSON for programs, CSV for spreadsheets.

use super::record::{Record, Run, Spread};
use halfline::error::{Error, Result};
use halfline_files::write::file::write_atomically;
use std::borrow::Cow;
use std::path::Path;

/// The record as one JSON object, one line per field.
///
/// # Errors
/// None are known: every number of a record can be written as JSON.
pub fn json(record: &Record) -> Result<String> {
    serde_json::to_string(record).map(|text| text + "\n").map_err(|e| Error::write("-", e.into()))
}

/// Writes `records.json` and `records.csv` atomically into the folder `dir`.
///
/// # Errors
/// [`Error::Io`] naming the file.
pub fn write(record: &Record, dir: &Path) -> Result<()> {
    let files = [("records.json", json(record)?), ("records.csv", csv(record))];
    files.iter().try_for_each(|(name, text)| write_atomically(&dir.join(name), |out| out.write_all(text.as_bytes())))
}

/// A row per run; column names contain the units, raw samples are joined by semicolons.
fn csv(record: &Record) -> String {
    let rows: Vec<_> = record.runs.iter().map(|run| row(record, run)).collect();
    let line = |fields: Vec<&String>| fields.into_iter().map(|text| field(text)).collect::<Vec<_>>().join(",") + "\n";
    let header = rows.first().map(|row| line(row.iter().map(|(name, _)| name).collect()));
    header.into_iter().chain(rows.iter().map(|row| line(row.iter().map(|(_, value)| value).collect()))).collect()
}

/// A field of CSV: in quotes where it has a comma, a quote or a line break (RFC 4180).
fn field(text: &str) -> Cow<'_, str> {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")).into(),
        false => text.into(),
    }
}

/// Names and values of the columns of a run. Infinite and missing values are empty, as in the JSON.
fn row(record: &Record, run: &Run) -> Vec<(String, String)> {
    let mut row = Vec::new();
    let mut add = |name: &str, value: String| row.push((name.to_owned(), value));
    let number = |x: Option<f64>| x.map(|x| x.to_string()).unwrap_or_default();
    let samples = |list: &[f64]| list.iter().map(f64::to_string).collect::<Vec<_>>().join(";");
    let scene = record.scenes.get(run.scene).cloned().unwrap_or_default();
    let place = record.places.get(run.place).cloned().unwrap_or_default();
    add("subject", record.subject.clone());
    add("scene", scene.name);
    add("fingerprint", scene.fingerprint);
    add("pictures", scene.pictures.to_string());
    add("spheres", scene.spheres.to_string());
    add("width_pixels", scene.size[0].to_string());
    add("height_pixels", scene.size[1].to_string());
    add("farthest_radii", number(scene.farthest));
    add("hits_pixels", scene.hits.to_string());
    add("halfline", record.halfline.clone());
    add("backend", place.backend);
    add("adapter", place.adapter);
    add("driver", place.driver);
    add("self_test", place.self_test.join("; "));
    add("tolerance_relative", record.tolerance.to_string());
    add("method", run.method.clone());
    add("refused", run.refused.clone().unwrap_or_default());
    add("first_ms", number(run.first_ms));
    add("steady_ms", samples(&run.steady_ms));
    add("kernel_ms", samples(&run.kernel_ms));
    let errors = &run.errors;
    add("judged_pixels", errors.pixels.to_string());
    add("false_hit_pixels", errors.false_hit.to_string());
    add("false_miss_pixels", errors.false_miss.to_string());
    add("wrong_sphere_pixels", errors.wrong_sphere.to_string());
    add("wrong_root_pixels", errors.wrong_root.to_string());
    add("outline_radii", number(errors.outline));
    for (name, unit, Spread { median, p99, max }) in [
        ("distance", "relative", errors.relative),
        ("t", "ulp", errors.ulp),
        ("distance", "radii", errors.radii),
        ("normal", "degrees", errors.normal),
    ] {
        add(&format!("{name}_median_{unit}"), number(median));
        add(&format!("{name}_p99_{unit}"), number(p99));
        add(&format!("{name}_max_{unit}"), number(max));
    }
    add("certified_share", number(run.certified));
    add("settled_pixels", run.settled.map(|n| n.to_string()).unwrap_or_default());
    add("error_share_of_bound", number(run.of_bound));
    add("predicted_outline_radii", number(run.predicted.outline));
    add("predicted_distance_relative", number(run.predicted.distance));
    row
}
