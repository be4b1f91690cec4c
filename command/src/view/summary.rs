//! Summaries of the scene and of a picture for the page, as JSON.

use crate::picture_scene::PictureScene;
use crate::scene_args::SceneArgs;
use glam::DVec3;
use halfline::error::Result;
use halfline::frame::legend::Legend;
use halfline::frame::report::Report;
use halfline::frame::srgb;
use halfline::settings::Settings;
use halfline_files::read::{ColumnValues, SceneFrame};
use halfline_viewer::Pose;
use serde_json::{Map, Value, json};

/// The most texts of a column that are listed.
const MOST_TEXTS: usize = 32;

/// Summarises the scene of a frame and the picture with which a page begins. Beads along the edges of a cell are not counted;
/// without spheres the box is the origin.
///
/// # Errors
/// Errors of [`legend`].
pub(super) fn of(args: &SceneArgs, frame: &SceneFrame, picture: &PictureScene, pose: &Pose) -> Result<Value> {
    let (spheres, columns, image) = (&frame.scene.spheres, &frame.columns, picture.scene.image);
    let [low, high] = if spheres.is_empty() { [DVec3::ZERO; 2] } else { spheres.bounds() };
    let names = columns.names().filter(|name| *name != "index");
    let all: Map<String, Value> =
        names.filter_map(|name| Some((name.to_owned(), column(columns.get(name).ok()?.1)))).collect();
    let [r, g, b] = image.background.map(srgb::level);
    let file = args.path().file_name().unwrap_or(args.path().as_os_str());
    let mut warnings = Vec::new();
    frame.skipped.report(&mut 0, &mut warnings, 0);
    Ok(json!({
        "schema": 1,
        "version": env!("CARGO_PKG_VERSION"),
        "file": file.to_string_lossy(),
        "frame": frame.number,
        "first": frame.number.min(1),
        "count": spheres.len() - frame.beads,
        "cell": frame.cell.as_ref().map(|cell| cell.edges),
        "extent": [low.to_array(), high.to_array()],
        "center": ((low + high) / 2.0).to_array(),
        "radius": (high - low).length() / 2.0,
        "columns": all,
        "selects": !columns.is_empty(),
        "look": picture.look.name(),
        "samples": picture.look.settings(&Settings::default()).samples,
        "unit": frame.is_molecule.then_some("\u{c5}"),
        "background": format!("#{r:02x}{g:02x}{b:02x}"),
        "legend": legend(frame.legend.as_ref())?,
        "draws": { "legend": args.insets.legend_in.is_some(), "scale_bar": args.insets.scale_bar.is_some() },
        "parts": !args.insets.is_given() && !args.files.transparent,
        "camera": pose,
        "size": [image.width, image.height],
        "warnings": warnings,
    }))
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
pub(super) fn legend(legend: Option<&Legend>) -> Result<Option<String>> {
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
