//! What the page shows about the scene and about a picture.

use super::moving::Moved;
use crate::picture_scene::PictureScene;
use halfline::error::Result;
use halfline::frame::legend::Legend;
use halfline::frame::report::Report;
use halfline::frame::srgb;
use halfline::settings::{Look, Settings};
use halfline_files::read::{ColumnValues, SceneFrame};
use halfline_viewer::Pose;
use serde_json::{Map, Value, json};
use std::ffi::OsStr;
use std::path::Path;

/// The most texts of a column that are listed.
const MOST_TEXTS: usize = 32;

/// The scene of a frame, with the camera of this picture.
///
/// # Errors
/// Those of the camera.
pub(super) fn of(file: &OsStr, frame: &SceneFrame, picture: &PictureScene, pose: &Pose) -> Result<Value> {
    let SceneFrame { number, scene, skipped, columns, cell, legend: colors, .. } = frame;
    let [low, high] = scene.spheres.bounds();
    let image = picture.scene.image;
    let names = columns.names().filter(|name| *name != "index");
    let all: Map<String, Value> =
        names.filter_map(|name| Some((name.to_owned(), column(columns.get(name).ok()?.1)))).collect();
    let mut warnings = Vec::new();
    skipped.report(&mut 0, &mut warnings, 0);
    Ok(json!({
        "schema": 1,
        "version": env!("CARGO_PKG_VERSION"),
        "file": Path::new(file).file_name().unwrap_or(file).to_string_lossy(),
        "count": scene.spheres.len(),
        "frame": number,
        "cell": cell.as_ref().map(|cell| cell.edges),
        "extent": [low.to_array(), high.to_array()],
        "center": ((low + high) / 2.0).to_array(),
        "radius": (high - low).length() / 2.0,
        "columns": all,
        "camera": pose,
        "look": picture.look.name(),
        "looks": Look::ALL.iter().map(|look| look.name()).collect::<Vec<_>>(),
        "samples": picture.look.settings(&Settings::default()).samples,
        "size": [image.width, image.height],
        "background": hex(image.background),
        "selects": !columns.is_empty(),
        "legend": legend(colors.as_ref())?,
        "warnings": warnings,
    }))
}

/// What is true of a still picture.
pub(super) fn of_still(report: &Report) -> Value {
    json!({
        "accuracy": report.accuracy,
        "certified": report.proved(),
        "settled": report.settled,
        "adapter": report.adapter,
        "look": report.look,
        "samples": report.samples,
        "warnings": report.warnings,
    })
}

/// What is true of a picture while the camera moves.
pub(super) fn of_moved(moved: &Moved) -> Value {
    json!({
        "accuracy": moved.accuracy,
        "certified": moved.proved,
        "settled": moved.settled,
        "adapter": moved.adapter,
        "look": "plain",
        "samples": 1,
        "warnings": [],
    })
}

/// The legend of the colours as SVG.
///
/// # Errors
/// Those of drawing.
pub fn legend(legend: Option<&Legend>) -> Result<Option<String>> {
    legend.map(|legend| halfline_drawing::legend::draw(legend).map(|drawing| drawing.svg)).transpose()
}

/// The type of a column, and its range or its texts.
pub fn column(values: &ColumnValues) -> Value {
    let range = |numbers: &mut dyn Iterator<Item = f64>| {
        let finite = numbers.filter(|x| x.is_finite());
        let ends = finite
            .fold(None, |ends: Option<[f64; 2]>, x| Some(ends.map_or([x, x], |[low, high]| [low.min(x), high.max(x)])));
        json!({ "type": "number", "min": ends.map(|[low, _]| low), "max": ends.map(|[_, high]| high) })
    };
    match values {
        ColumnValues::Numbers(numbers) => range(&mut numbers.iter().copied()),
        ColumnValues::Whole(numbers) => range(&mut numbers.iter().map(|x| f64::from(*x))),
        ColumnValues::Order(count) => json!({ "type": "number", "min": 0, "max": count.saturating_sub(1) }),
        ColumnValues::Texts(..) => {
            let used = values.texts();
            json!({ "type": "text", "count": used.len(), "values": used.iter().take(MOST_TEXTS).collect::<Vec<_>>() })
        }
    }
}

/// A linear colour as `#rrggbb`.
pub fn hex(linear: [f32; 3]) -> String {
    let [r, g, b] = linear.map(srgb::level);
    format!("#{r:02x}{g:02x}{b:02x}")
}
