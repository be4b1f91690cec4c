//! Summaries of the scene and of a picture for the page, as JSON.

use crate::picture_scene::PictureScene;
use glam::DVec3;
use halfline::error::Result;
use halfline::frame::legend::Legend;
use halfline::frame::report::Report;
use halfline::frame::srgb;
use halfline::scene::Spheres;
use halfline::settings::{Look, Settings};
use halfline_files::read::{ColumnValues, Columns, SceneFrame};
use halfline_viewer::Pose;
use serde_json::{Map, Value, json};
use std::ffi::OsStr;
use std::path::Path;

/// The most texts of a column that are listed.
const MOST_TEXTS: usize = 32;

/// Summarises spheres as JSON: count, box, cell, columns, looks, background. The last `beads` spheres are beads along
/// the edges of a cell and are not counted. `look` and `samples` are those of the pictures. Without spheres the box is
/// the origin.
pub fn scene(
    (spheres, beads): (&Spheres, usize),
    columns: &Columns,
    edges: Option<[[f64; 3]; 3]>,
    background: [f32; 3],
    (look, samples): (Option<&str>, u32),
) -> Value {
    let [low, high] = if spheres.is_empty() { [DVec3::ZERO; 2] } else { spheres.bounds() };
    let names = columns.names().filter(|name| *name != "index");
    let all: Map<String, Value> =
        names.filter_map(|name| Some((name.to_owned(), column(columns.get(name).ok()?.1)))).collect();
    let [r, g, b] = background.map(srgb::level);
    json!({
        "count": spheres.len() - beads,
        "cell": edges,
        "extent": [low.to_array(), high.to_array()],
        "center": ((low + high) / 2.0).to_array(),
        "radius": (high - low).length() / 2.0,
        "columns": all,
        "look": look,
        "looks": Look::ALL.iter().map(|look| look.name()).collect::<Vec<_>>(),
        "samples": samples,
        "background": format!("#{r:02x}{g:02x}{b:02x}"),
    })
}

/// Summarises the scene of a frame: the values of [`scene`], the file, the camera and the size of this picture, the
/// legend and the warnings of the reader.
///
/// # Errors
/// Errors of [`legend`].
pub(super) fn of(file: &OsStr, frame: &SceneFrame, picture: &PictureScene, pose: &Pose) -> Result<Value> {
    let image = picture.scene.image;
    let look = (picture.look.name(), picture.look.settings(&Settings::default()).samples);
    let edges = frame.cell.as_ref().map(|cell| cell.edges);
    let mut summary = scene((&frame.scene.spheres, frame.beads), &frame.columns, edges, image.background, look);
    let mut warnings = Vec::new();
    frame.skipped.report(&mut 0, &mut warnings, 0);
    for (name, value) in [
        ("schema", json!(1)),
        ("version", json!(env!("CARGO_PKG_VERSION"))),
        ("file", json!(Path::new(file).file_name().unwrap_or(file).to_string_lossy())),
        ("frame", json!(frame.number)),
        ("camera", json!(pose)),
        ("size", json!([image.width, image.height])),
        ("selects", json!(!frame.columns.is_empty())),
        ("legend", json!(legend(frame.legend.as_ref())?)),
        ("warnings", json!(warnings)),
    ] {
        summary[name] = value;
    }
    Ok(summary)
}

/// Summarises the report of a picture: accuracy, certified share, adapter, look, samples, warnings.
pub(super) fn of_picture(report: &Report) -> Value {
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

/// The legend of the colours as SVG; `None` without a legend.
///
/// # Errors
/// Errors of [`halfline_drawing::legend::draw`].
pub fn legend(legend: Option<&Legend>) -> Result<Option<String>> {
    legend.map(|legend| halfline_drawing::legend::draw(legend).map(|drawing| drawing.svg)).transpose()
}

/// The type of a column, and its range or its texts.
fn column(values: &ColumnValues) -> Value {
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
