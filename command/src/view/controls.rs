//! The controls of the page: options of the picture that it sets in place of options of the command line.

use super::given::{Given, GivenOption};
use crate::option_table::{Call, call};
use halfline::error::{Error, Result};
use halfline::frame::color_map::ColorMap;
use halfline::settings::Look;
use halfline_viewer::Options;
use serde_json::{Value, json};

/// The options that the page sets, and the labels of their rows. Clip planes have six rows of their own, which planes that cut spheres
/// share.
const CONTROLS: [(&str, &str); 9] = [
    ("color_by", "Colour by"),
    ("map", "Colour map"),
    ("opacity", "Opacity"),
    ("layers", "Layers seen through"),
    ("background", "Background"),
    ("look", "Look"),
    ("samples", "Samples"),
    ("cut", "Planes"),
    ("clip", ""),
];

/// The numbers of samples that are offered, squares.
const SAMPLES: [u32; 5] = [1, 4, 9, 16, 64];

/// Steps of a slider along an edge of the box around the spheres, at least.
const STEPS: f64 = 100.0;

/// The identifiers of the controls of a page that reads its file again for every change.
pub(super) fn of_file() -> Vec<&'static str> {
    CONTROLS.iter().map(|(id, _)| *id).collect()
}

/// The identifiers of the controls of scenes in memory, whose lines are copied with these options. Colours by a column need the file, as do
/// opacities over others; what only a reader takes is left out where the lines read no file.
pub(super) fn in_memory(copied: &Given) -> Vec<&'static str> {
    let has_file = !copied.scene.is_empty();
    let fades = copied.options().iter().any(|option| option.id == "opacity");
    let is_shown = |id: &str| match id {
        "color_by" | "map" => false,
        "opacity" => has_file && !fades,
        "cut" | "clip" => has_file,
        _ => true,
    };
    of_file().into_iter().filter(|id| is_shown(id)).collect()
}

/// Refuses options that are no controls of the page, and colour maps of files, which only the command line names.
///
/// # Errors
/// [`Error::Settings`].
pub(super) fn check(shown: &[&str], options: &Options, given: &Given) -> Result<()> {
    // A legend is in pictures that are saved.
    if let Some(id) = options.keys().find(|id| !shown.contains(&id.as_str()) && *id != "legend_in") {
        let problem = format!("the page does not set the option {id:?}");
        return Err(Error::settings(problem, format!("use one of {}", shown.join(", "))));
    }
    let is_typed = |name: &str| given.options().iter().any(|option| option.id == "map" && option.text() == name);
    let maps = options.get("map").into_iter().flatten();
    maps.filter(|name| !is_typed(name)).try_for_each(|name| name.parse::<ColorMap>().map(drop))
}

/// The options that a reader takes, without clip planes, which frames get after they were read.
pub(super) fn of_reader(options: &Options) -> Options {
    let is_read = |id: &str| id != "clip" && call(id) == Some(Call::Read);
    options.iter().filter(|(id, _)| is_read(id)).map(|(id, values)| (id.clone(), values.clone())).collect()
}

/// The rows of the page's panel: for each its option, its label, its help, the value with which it begins, and the kind of input with its
/// bounds, or the values that it offers. An empty value takes the option away. A row with a `plane` sets the distance along it; one with
/// `others` sets it for all spheres but those that are selected; one with `renames` chooses the option that the rows of that one set.
pub(super) fn rows(shown: &[&str], given: &Given, summary: &Value, help: impl Fn(&str) -> String) -> Vec<Value> {
    let all = |id: &'static str| given.options().iter().filter(move |option| option.id == id).map(GivenOption::text);
    let typed = |id: &'static str| all(id).next_back();
    let mut rows = Vec::new();
    let has_columns = !columns(summary).is_empty();
    let is_shown = |id: &str| shown.contains(&id) && (has_columns || !["color_by", "map"].contains(&id));
    for (id, label) in CONTROLS.iter().filter(|(id, _)| is_shown(id)) {
        let own = match *id {
            "color_by" => choice(typed(id), columns(summary)),
            "map" => choice(typed(id), maps()),
            "look" => json!({ "value": summary["look"], "values": Look::ALL.map(|look| look.name()) }),
            "samples" => choice(typed(id), SAMPLES.iter().map(u32::to_string).collect()),
            "background" => json!({ "type": "color", "value": summary["background"] }),
            "cut" => json!({ "value": "clip", "values": ["clip", "cut"], "renames": "clip" }),
            "layers" => json!({ "type": "number", "value": typed(id).unwrap_or("1".into()), "min": 1, "max": 64 }),
            "opacity" => {
                let value = all(id).rfind(|rule| !rule.contains('=')).unwrap_or("1".into());
                json!({ "type": "range", "value": value, "min": 0.05, "max": 1, "step": 0.05, "others": true })
            }
            _ => {
                rows.extend((0..6).map(|n| slider(&summary["extent"], n / 2, n % 2 == 0, &help(id))));
                continue;
            }
        };
        let mut row = json!({ "id": id, "label": label, "help": help(id) });
        row.as_object_mut().into_iter().for_each(|row| row.extend(own.as_object().cloned().unwrap_or_default()));
        rows.push(row);
    }
    rows
}

/// A choice of these values, none of them, or another one that is typed.
fn choice(typed: Option<String>, mut values: Vec<String>) -> Value {
    let value = typed.unwrap_or_default();
    if !values.contains(&value) {
        values.insert(0, value.clone());
    }
    if !values.iter().any(String::is_empty) {
        values.insert(0, String::new());
    }
    json!({ "value": value, "values": values })
}

/// The columns that may give colours; a scene without columns has none.
fn columns(summary: &Value) -> Vec<String> {
    let Some(all) = summary["columns"].as_object().filter(|all| !all.is_empty()) else { return Vec::new() };
    let axes = ["x", "y", "z"].into_iter().filter(|axis| !all.contains_key(*axis));
    all.keys().cloned().chain(axes.map(String::from)).collect()
}

/// The colour maps, and each reversed that can be.
fn maps() -> Vec<String> {
    let both = |name: &str| [name.to_owned(), format!("{name}_r")];
    ColorMap::names().into_iter().flat_map(both).filter(|name| name.parse::<ColorMap>().is_ok()).collect()
}

/// A slider that cuts along an axis, from its lower or its upper end. It begins where it removes nothing.
fn slider(extent: &Value, axis: usize, is_lower: bool, help: &str) -> Value {
    let [low, high] = [0, 1].map(|end| extent[end][axis].as_f64().unwrap_or_default());
    // The step is the greatest power of ten that gives the edge enough steps.
    let power = ((high - low) / STEPS).log10().floor();
    let exponent = if power.is_finite() { power as i32 } else { 0 };
    // Decimal numbers, so that the page has them in few digits.
    let steps = |count: f64| format!("{count}e{exponent}").parse::<f64>().unwrap_or(count);
    let step = steps(1.0);
    let ends = [steps((low / step).floor()), steps((high / step).ceil())];
    let (name, direction, end) = if is_lower { ("from", -1, ends[0]) } else { ("to", 1, ends[1]) };
    let mut plane = [0; 3];
    plane[axis] = direction;
    json!({
        "id": "clip", "label": format!("{} {name}", ["x", "y", "z"][axis]), "help": help, "type": "range", "min": ends[0], "max": ends[1],
        "step": step, "value": end, "plane": plane,
    })
}

#[cfg(test)]
mod tests {
    use super::super::handler::ViewHandler;
    use super::super::{MemoryScene, WrittenOption, gather};
    use super::*;
    use halfline::render::Renderer;
    use halfline::settings::{Backend, Settings};
    use halfline_viewer::{FrameRequest, Picture, Pixels, Pose, SceneRequest, Stage};
    use std::ffi::OsString;
    use std::sync::{Arc, Mutex};

    const FILM: &str = "3\nLattice=\"5 0 0 0 5 0 0 0 5\" Properties=species:S:1:pos:R:3:q:R:1\nC 0.5 0 0 1\nO 2 1 0 -0.25\nH 4 4 1 3\n";

    /// The answers of a page with the file, and of the same page in memory.
    fn both(folder: &tempfile::TempDir, options: &[(&str, &str)]) -> [ViewHandler; 2] {
        let file = folder.path().join("film.xyz");
        std::fs::write(&file, FILM).expect("a file");
        let mut options: Vec<(String, Option<OsString>)> =
            options.iter().map(|(id, value)| ((*id).to_owned(), Some((*value).into()))).collect();
        options.push(("backend".into(), Some("cpu".into())));
        let given = Given::of_options(file.into_os_string(), &options);
        let content = gather::content(&given, None, &["q".to_owned(), "element".to_owned()]).expect("a content");
        let settings = Settings { backend: Backend::Cpu, ..Settings::default() };
        let renderer = Arc::new(Mutex::new(Some(Renderer::new(&settings).expect("a renderer"))));
        let words = crate::messages::flags;
        let memory = MemoryScene { content, renderer, backend: Backend::Cpu, words };
        let reading = ViewHandler::new(given).expect("a handler");
        reading.load().expect("the file");
        [reading, ViewHandler::in_memory(memory).expect("a scene")]
    }

    fn of(options: &[(&str, &[&str])]) -> Options {
        let values = |values: &[&str]| values.iter().map(|value| (*value).to_owned()).collect();
        options.iter().map(|(id, all)| ((*id).to_owned(), values(all))).collect()
    }

    fn png(handler: &ViewHandler, request: &FrameRequest) -> Vec<u8> {
        let picture = handler.frame(request, &(Arc::new(|| true) as _)).expect("a picture").expect("not given up");
        let Picture { pixels: Pixels::Png(bytes), .. } = picture else { panic!("a still is a PNG") };
        bytes
    }

    /// Controls of a scene in memory give the pictures of the file that is read again, byte for byte, with the legend and the beads of
    /// the cell.
    #[test]
    fn controls_in_memory_give_the_pictures_of_the_file() {
        let folder = tempfile::tempdir().expect("a folder");
        for given in
            [&[("legend_in", "top-left"), ("cell", "0.1")][..], &[("legend_in", "top-left"), ("color_by", "q")]]
        {
            let [reading, memory] = both(&folder, given);
            let camera = reading.scene(&SceneRequest { size: None }).expect("a scene")["camera"].clone();
            let camera: Pose = serde_json::from_value(camera).expect("a camera");
            let mut pictures = Vec::new();
            for (select, options) in [
                (None, of(&[])),
                (None, of(&[("clip", &["-1,0,0,-1"])])),
                (None, of(&[("clip", &["1,0,0,3", "0,-1,0,-0.5"]), ("background", &["#204060"]), ("samples", &["4"])])),
                (None, of(&[("cut", &["1,0,0,3", "0,-1,0,-0.5"])])),
                (None, of(&[("opacity", &["0.4"]), ("layers", &["3"])])),
                (Some("element C"), of(&[("opacity", &["not (element C)=0.3"]), ("look", &["plain"])])),
                (Some("q > 0"), of(&[("opacity", &["0.5", "q > 2=0.2"]), ("clip", &["0,0,1,0.5"])])),
            ] {
                let select = select.map(str::to_owned);
                let request = FrameRequest { select, options, ..FrameRequest::still(camera, [240, 180]) };
                let [expected, found] = [&reading, &memory].map(|handler| png(handler, &request));
                assert!(expected == found, "{given:?} {:?} {:?}", request.select, request.options);
                pictures.push(found);
            }
            assert!((1..pictures.len()).all(|n| pictures[n] != pictures[n - 1]), "each changes the picture");
        }
    }

    #[test]
    fn scenes_in_memory_have_the_controls_that_their_lines_can_say() {
        let copied = |file: &str, options: &[WrittenOption]| Given::of_options(file.into(), options);
        let fades = [("opacity".to_owned(), Some("0.5".into()))];
        assert_eq!(in_memory(&copied("", &[])), ["layers", "background", "look", "samples"]);
        assert_eq!(
            in_memory(&copied("a.xyz", &[])),
            ["opacity", "layers", "background", "look", "samples", "cut", "clip"]
        );
        assert_eq!(in_memory(&copied("a.xyz", &fades)), ["layers", "background", "look", "samples", "cut", "clip"]);
        let refused = check(&in_memory(&copied("a.xyz", &[])), &of(&[("color_by", &["q"])]), &copied("a.xyz", &[]));
        assert!(refused.expect_err("a column").to_string().contains("color_by"));
    }

    /// Sliders have whole steps at every scale, and begin beyond the box.
    #[test]
    fn sliders_hold_the_box_at_every_scale() {
        for scale in [1e-300, 1e-9, 0.07, 1.0, 33.0, 1e6, 1e200] {
            let extent = json!([[-0.37 * scale, 0, 0], [1.21 * scale, 0, 0]]);
            for is_lower in [true, false] {
                let row = slider(&extent, 0, is_lower, "");
                let of = |name: &str| row[name].as_f64().expect("a number");
                let [low, high, step, value] = ["min", "max", "step", "value"].map(of);
                assert!(low <= -0.37 * scale && high >= 1.21 * scale, "{row}");
                assert!((high - low) / step >= STEPS && (high - low) / step <= 10.0 * STEPS + 12.0, "{row}");
                assert_eq!(value, if is_lower { low } else { high });
            }
        }
        let row = slider(&json!([[0, 0, 0], [0, 0, 0]]), 1, true, "");
        assert_eq!((&row["min"], &row["max"], &row["plane"]), (&json!(0.0), &json!(0.0), &json!([0, -1, 0])));
    }
}
