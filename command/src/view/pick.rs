//! The sphere that a pixel shows, decided with certified accuracy, and the data that the file has of it.

use glam::DVec3;
use halfline::error::Result;
use halfline::frame::{Aov, Data};
use halfline::parallel::{self, CHEAP};
use halfline::render::Renderer;
use halfline::scene::{Cell, Lighting, Scene, Spheres};
use halfline::settings::{Accuracy, Settings};
use halfline::window::Window;
use halfline_files::read::{ColumnValue, Columns};
use serde_json::{Value, json};

/// The sphere that pixel `x`, `y` of a scene shows: its id as in the buffer `id`, and as JSON with centre, radius, position and
/// distance of the hit, certainty. `None` on a miss.
///
/// # Errors
/// Errors of the camera and of [`Renderer::render`]; [`halfline::Error::Settings`] for a pixel outside the image.
pub(super) fn pick(
    renderer: &mut Renderer,
    scene: &Scene,
    settings: &Settings,
    [x, y]: [u32; 2],
) -> Result<Option<(usize, Value)>> {
    // The frame has only the spheres that the ray comes close to.
    let projector = scene.camera.projector([scene.image.width, scene.image.height])?;
    let Some(ray) = projector.ray([x, y].map(|place| f64::from(place) + 0.5)) else { return Ok(None) };
    let near = near_ray(&scene.spheres, ray);
    let of = |values: &[[f64; 3]]| near.iter().map(|id| values[*id]).collect::<Vec<_>>().into();
    let radii = near.iter().map(|id| scene.spheres.radii[*id]).collect::<Vec<_>>().into();
    let spheres = Spheres { centers: of(&scene.spheres.centers), radii, ..Spheres::default() };
    let alone = Scene { spheres, lighting: Lighting::default(), ..*scene };
    let window = Window { x0: x, y0: y, x1: x.saturating_add(1), y1: y.saturating_add(1) };
    let settings = Settings {
        accuracy: Accuracy::Certified,
        aovs: vec![Aov::Id, Aov::Distance, Aov::Position, Aov::Certainty],
        tolerance: settings.tolerance,
        window: Some(window),
        ..Settings::default()
    };
    let frame = renderer.render(&alone, &settings)?;
    let found = frame.ids().first().and_then(|id| near.get(usize::try_from(*id).ok()?));
    let (Some(id), Some([x, y, z])) = (found, frame.f64(Aov::Position)) else {
        return Ok(None);
    };
    let is_settled = frame.get(Aov::Certainty).is_some_and(|buffer| buffer.data == Data::U8(vec![1]));
    let (center, radius) = (scene.spheres.centers[*id], scene.spheres.radii[*id]);
    let picked = json!({
        "id": id,
        "center": center,
        "radius": radius,
        "position": [x, y, z],
        "distance": frame.f64(Aov::Distance).and_then(|distances| distances.first()),
        "certainty": if is_settled { "settled" } else { "certified" },
    });
    Ok(Some((*id, picked)))
}

/// The ids of the spheres that the line of a ray hits, or passes within 1e-9 of their radius plus 1e-9 of the distance from the
/// origin to their centre.
fn near_ray(spheres: &Spheres, [origin, direction]: [DVec3; 2]) -> Vec<usize> {
    const SLACK: f64 = 1e-9;
    let along = direction.normalize();
    let is_near = |id: &usize| {
        let (center, radius) = (spheres.centers[*id], spheres.radii[*id]);
        let toward = DVec3::from_array(center) - origin;
        let distance = (toward - along * toward.dot(along)).length();
        let reach = radius * (1.0 + SLACK) + SLACK * toward.length();
        // Numbers too large for f64 are no reason to leave a sphere out.
        distance <= reach || distance.is_nan() || reach.is_nan()
    };
    parallel::collect(spheres.len(), CHEAP, &|ids, out| out.extend(ids.filter(is_near)))
}

/// Adds to `picked` the data that the file has of sphere `id`: `row`, its number in the file from 0, and `columns`, its
/// value in each column.
pub(super) fn describe(picked: &mut Value, columns: &Columns, id: usize) {
    let value = |name: &str| {
        let (_, values) = columns.get(name).ok()?;
        Some(match values.value(id) {
            ColumnValue::Number(x) if x.trunc() == x && x.abs() < 1e15 => json!(x as i64),
            ColumnValue::Number(x) => json!(x),
            ColumnValue::Text(text) => json!(text),
        })
    };
    picked["row"] = value("index").unwrap_or(json!(id));
    let all = columns.names().filter(|name| *name != "index");
    picked["columns"] = all.filter_map(|name| Some((name.to_owned(), value(name)?))).collect();
}

/// The distance of the centres of two spheres: as they lie, and in a periodic cell between their nearest images; `None` if there
/// are no such spheres.
pub(super) fn apart(spheres: &Spheres, cell: Option<&Cell>, [from, to]: [usize; 2]) -> Option<(f64, Option<f64>)> {
    let [from, to] = [*spheres.centers.get(from)?, *spheres.centers.get(to)?].map(DVec3::from_array);
    let apart = to - from;
    Some((apart.length(), cell.map(|cell| cell.nearest_image(apart).length())))
}
