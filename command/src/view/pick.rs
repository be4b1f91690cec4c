//! What a pixel shows, decided exactly.

use halfline::error::Result;
use halfline::frame::{Aov, Data};
use halfline::render::Renderer;
use halfline::scene::{Cell, Scene};
use halfline::settings::{Accuracy, Settings};
use halfline::window::Window;
use halfline_files::read::{ColumnValue, Columns, SceneFrame};
use serde_json::{Map, Value, json};

/// The sphere that pixel `x`, `y` of a scene shows: its id is that of the buffer `id`; null on a miss.
///
/// # Errors
/// Those of a frame; [`halfline::Error::Settings`] for a pixel that is not in the image.
pub(super) fn pick(renderer: &mut Renderer, scene: &Scene, settings: &Settings, [x, y]: [u32; 2]) -> Result<Value> {
    let window = Window { x0: x, y0: y, x1: x.saturating_add(1), y1: y.saturating_add(1) };
    let settings = Settings {
        accuracy: Accuracy::Certified,
        aovs: vec![Aov::Id, Aov::Distance, Aov::Position, Aov::Certainty],
        tolerance: settings.tolerance,
        window: Some(window),
        ..Settings::default()
    };
    let frame = renderer.render(scene, &settings)?;
    let (Some(id @ 0..), Some([x, y, z])) = (frame.ids().first().copied(), frame.f64(Aov::Position)) else {
        return Ok(Value::Null);
    };
    let is_settled = frame.get(Aov::Certainty).is_some_and(|buffer| buffer.data == Data::U8(vec![1]));
    let (center, radius) = (scene.spheres.centers[id as usize], scene.spheres.radii[id as usize]);
    Ok(json!({
        "id": id,
        "center": center,
        "radius": radius,
        "position": [x, y, z],
        "distance": frame.f64(Aov::Distance).and_then(|distances| distances.first()),
        "certainty": if is_settled { "settled" } else { "certified" },
    }))
}

/// What the file says about a sphere: `row`, its number in the file from 0, and `columns`.
pub fn describe(picked: &mut Map<String, Value>, columns: &Columns, id: usize) {
    let value = |name: &str| {
        let (_, values) = columns.get(name).ok()?;
        Some(match values.value(id) {
            ColumnValue::Number(x) if x.trunc() == x && x.abs() < 1e15 => json!(x as i64),
            ColumnValue::Number(x) => json!(x),
            ColumnValue::Text(text) => json!(text),
        })
    };
    picked.insert("row".into(), value("index").unwrap_or(json!(id)));
    let all = columns.names().filter(|name| *name != "index");
    picked.insert("columns".into(), all.filter_map(|name| Some((name.to_owned(), value(name)?))).collect());
}

/// The distance of the centres of two spheres of a frame: as they lie, and in a periodic cell that of their nearest images.
pub(super) fn distance(frame: &SceneFrame, id: usize, from: u64) -> Option<Value> {
    let centers = &frame.scene.spheres.centers;
    let (a, b) = (centers.get(usize::try_from(from).ok()?)?, centers.get(id)?);
    let apart = glam::DVec3::from_array(*b) - glam::DVec3::from_array(*a);
    let image = frame.cell.as_ref().map(|cell: &Cell| cell.nearest_image(apart).length());
    Some(json!({ "id": from, "distance": apart.length(), "minimum_image": image }))
}
