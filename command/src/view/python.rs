//! The lines of Python that render a picture of the page.

use super::given::GivenOption;
use super::lens;
use crate::option_table::{Call, Form, OptionRow, Python, options as all_options};
use halfline_viewer::{FrameRequest, Lens};
use std::ffi::OsStr;
use std::str::Utf8Chunk;

/// The lines for these options of the command. An option that Python does not have is named in a comment. A scene without a
/// file is a variable, whose spheres get the colours of a selection.
pub(super) fn lines(file: Option<&OsStr>, output: &OsStr, options: &[GivenOption], request: &FrameRequest) -> String {
    let keywords = |call: Call| {
        let keyword = |row: &OptionRow| match row.python {
            Python::Keyword(of, name, form, _) if of == call && row.is_copied() => {
                Some(format!(", {name}={}", value(form, &values(options, row.id)?)))
            }
            _ => None,
        };
        all_options().filter_map(keyword).collect::<String>()
    };
    let lacks_keyword =
        |option: &&GivenOption| all_options().any(|row| row.id == option.id && matches!(row.python, Python::Missing));
    let missing = options.iter().filter(lacks_keyword);
    let notes: String = missing.map(|option| format!("# {} has no keyword in Python\n", option.flag())).collect();
    let camera = &request.camera;
    let [eye, at, up] = [camera.eye, camera.at, camera.up].map(|vector| format!("{vector:?}").replace(['[', ']'], ""));
    let lens = match camera.lens {
        Lens::Height(height) => format!("height={height:?}"),
        lens => {
            let keyword = |(id, value): (&str, Option<String>)| {
                let value = value.unwrap_or_default();
                format!("{id}={}", if id == "lens" { text(&value) } else { literal(&value) })
            };
            lens::options(&lens, request.size, false).into_iter().map(keyword).collect::<Vec<_>>().join(", ")
        }
    };
    let [width, height] = request.size;
    let scene = match (file, values(options, "color")) {
        (Some(file), _) => format!("scene = hl.read({}{})", path(file), keywords(Call::Read)),
        (None, None) => "# scene is the scene of the view".to_owned(),
        (None, Some(rules)) => {
            format!("# scene is the scene of the view\nscene = scene.with_colors({})", value(Form::Rules, &rules))
        }
    };
    let output = path(output);
    let renderer = keywords(Call::Renderer);
    let render = match renderer.strip_prefix(", ") {
        Some(renderer) => format!("hl.Renderer({renderer}).render"),
        None => "hl.render".to_owned(),
    };
    format!(
        "import halfline as hl\n\n{notes}{scene}\ncamera = hl.Camera(({eye}), at=({at}), up=({up}), {lens}{})\n\
         frame = {render}(scene, camera, size=({width}, {height}){})\nframe.save({output}{})\n",
        keywords(Call::Camera),
        keywords(Call::Render),
        keywords(Call::Save),
    )
}

/// The values of an option each time that it is given; `None` if it is not. A flag has an empty one.
fn values(options: &[GivenOption], id: &str) -> Option<Vec<String>> {
    let given = options.iter().filter(|option| option.id == id);
    let values: Vec<String> = given.map(GivenOption::text).collect();
    Some(values).filter(|values| !values.is_empty())
}

/// A value in Python; a flag of environment or configuration may be a word.
fn value(form: Form, values: &[String]) -> String {
    let last = values.last().map_or("", String::as_str);
    let several =
        |one: fn(&str) -> String| format!("[{}]", values.iter().map(|v| one(v)).collect::<Vec<_>>().join(", "));
    match form {
        Form::Flag if ["0", "n", "no", "f", "false", "off"].contains(&last.to_ascii_lowercase().as_str()) => {
            "False".into()
        }
        Form::Flag => "True".into(),
        Form::NumberOrFlag | Form::TextOrFlag | Form::Legend if last.is_empty() => "True".into(),
        Form::Number | Form::NumberOrFlag => last.to_owned(),
        Form::Text | Form::Name | Form::Columns | Form::Names | Form::TextOrFlag | Form::Legend => text(last),
        Form::Tuple | Form::Size => tuple(last),
        Form::Tuples => several(tuple),
        Form::Texts | Form::Files => several(text),
        Form::Color => literal(last),
        Form::Rules | Form::Marks => match values {
            [one] if !one.contains('=') => literal(one),
            rules => {
                let rule = |rule: &String| {
                    let (selection, value) = rule.rsplit_once('=').unwrap_or(("all", rule));
                    format!("{}: {}", text(selection), literal(value.trim()))
                };
                // Values for all spheres come first: values of selections are painted over them.
                let (all, some): (Vec<&String>, _) = rules.iter().partition(|rule| !rule.contains('='));
                let last = all.last().copied().into_iter();
                format!("{{{}}}", last.chain(some).map(rule).collect::<Vec<_>>().join(", "))
            }
        },
    }
}

/// A number, several of them, or a text.
fn literal(value: &str) -> String {
    let is_number = |part: &str| part.trim().parse::<f64>().is_ok_and(f64::is_finite);
    match value.contains(',') {
        true if value.split(',').all(is_number) => tuple(value),
        false if is_number(value) => value.to_owned(),
        _ => text(value),
    }
}

fn tuple(value: &str) -> String {
    format!("({})", value.split(',').map(str::trim).collect::<Vec<_>>().join(", "))
}

/// The name of a file as a literal of Python, where bytes that are not UTF-8 are lone surrogates.
fn path(name: &OsStr) -> String {
    let of = |chunk: Utf8Chunk<'_>| {
        let escaped: String = chunk.invalid().iter().map(|byte| format!("\\udc{byte:02x}")).collect();
        escape(chunk.valid()) + &escaped
    };
    format!("\"{}\"", name.as_encoded_bytes().utf8_chunks().map(of).collect::<String>())
}

/// A text as a string literal of Python: backslashes, double quotes and control characters are escaped.
fn text(value: &str) -> String {
    format!("\"{}\"", escape(value))
}

fn escape(value: &str) -> String {
    value
        .chars()
        .map(|c| match c {
            '\\' => "\\\\".into(),
            '"' => "\\\"".into(),
            c if c.is_control() => format!("\\U{:08x}", u32::from(c)),
            c => c.to_string(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline_viewer::Pose;

    #[test]
    fn bytes_of_names_are_surrogates() {
        #[cfg(unix)]
        {
            use std::os::unix::ffi::OsStrExt;
            assert_eq!(path(OsStr::from_bytes(b"a\"\xff\xc3\xa9\xc3.csv")), r#""a\"\udcffé\udcc3.csv""#);
        }
    }

    #[test]
    fn options_are_keywords() {
        let option = |id: &str, value: Option<&str>| GivenOption::new(id, value.map(Into::into));
        let options = [
            option("color", Some("not (chain A)=silver")),
            option("color", Some("(chain A)=1,0.5,0")),
            option("clip", Some("0,0,1,2.5")),
            option("cell", None),
            option("bits", Some("16")),
            option("dpi", Some("300")),
            option("backend", Some("cpu")),
            option("label", Some("a \"b\"\n")),
        ];
        let camera = Pose { eye: [0.0, 0.1, 1e-7], at: [0.0; 3], up: [0.0, 1.0, 0.0], lens: Lens::Height(2.0) };
        let request = FrameRequest::still(camera, [4, 3]);
        let lines = lines(Some("a.pdb".as_ref()), "a-view.png".as_ref(), &options, &request);
        let expected = r#"import halfline as hl

scene = hl.read("a.pdb", clip=[(0, 0, 1, 2.5)], cell=True, color={"not (chain A)": "silver", "(chain A)": (1, 0.5, 0)})
camera = hl.Camera((0.0, 0.1, 1e-7), at=(0.0, 0.0, 0.0), up=(0.0, 1.0, 0.0), height=2.0)
frame = hl.Renderer(backend="cpu").render(scene, camera, size=(4, 3), label="a \"b\"\U0000000a")
frame.save("a-view.png", bits=16, dpi=300)
"#;
        assert_eq!(lines, expected);
    }
}
