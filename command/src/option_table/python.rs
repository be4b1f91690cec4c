//! The keywords of the Python package, written from the table and from clap's help into `python/halfline/options.py`.

use super::{Call, Form, Python, of_call};
use crate::choices::in_keywords;
use crate::scene_args::SceneArgs;
use clap::{Args, Command};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// The file, with a place for the keywords of each call.
const TEMPLATE: &str = include_str!("options.py.in");

/// Columns of a line.
const WIDTH: usize = 98;

/// A text in lines of a docstring.
fn docstring(text: &str) -> String {
    let line = format!("    \"\"\"{text}\"\"\"\n");
    if line.len() <= WIDTH + 1 {
        return line;
    }
    let mut lines = vec!["    \"\"\"".to_owned()];
    for word in text.split_whitespace() {
        let last = lines.last_mut().expect("a line");
        let is_first = last.ends_with("\"\"\"");
        if last.len() + 1 + word.len() > WIDTH {
            lines.push(format!("    {word}"));
        } else {
            let _ = write!(last, "{}{word}", if is_first { "" } else { " " });
        }
    }
    lines.join("\n") + "\n    \"\"\"\n"
}

/// The help of the size: a frame has no paper.
const SIZE: &str = "Columns and rows of the image [default: the scene file's, else (512, 512)]; (columns, None) takes the rows that the \
                    framed spheres fill. With a vfov the width of the view follows; a viewport keeps its size.";

/// The keywords of a call, each with its type and the help of its option.
fn keywords(call: Call) -> String {
    let command = SceneArgs::augment_args(Command::new("render"));
    let of = |id: &str| command.get_arguments().find(|arg| arg.get_id() == id);
    let mut text = String::new();
    // The size of parts is an argument of its own.
    for row in of_call(call).filter(|row| call != Call::Sieve || row.id != "size") {
        let Python::Keyword(of_row, name, form, kind) = row.python else { continue };
        // A figure has the keywords of a rendering by inheritance.
        if call == Call::Vector && of_row == Call::Render {
            continue;
        }
        // An earlier name of an option has no help of its own.
        let id = if row.id == "outline" { "cell" } else { row.id };
        let arg = of(id).expect("an option");
        let mut help = in_keywords(&arg.get_help().map(ToString::to_string).unwrap_or_default());
        help = help.replace('`', "``") + ".";
        if let [default] = arg.get_default_values()
            && !matches!(form, Form::Flag | Form::TextOrFlag)
        {
            help.insert_str(help.len() - 1, &format!(" [default: {}]", default.to_string_lossy()));
        }
        if form == Form::Size {
            help = SIZE.to_owned();
        }
        if form == Form::Legend {
            help += " A file name (.svg, .png) writes it to a file of its own.";
        }
        text += &format!("    {name}: {kind}\n{}", docstring(&help));
    }
    text
}

#[test]
fn keywords_of_python_are_those_of_the_table() {
    let mut expected = TEMPLATE.to_owned();
    let calls = [
        ("read", Call::Read),
        ("render", Call::Render),
        ("sieve", Call::Sieve),
        ("save", Call::Save),
        ("vector", Call::Vector),
    ];
    for (place, call) in calls {
        expected = expected.replace(&format!("    # {place}\n"), &keywords(call));
    }
    assert!(!expected.contains("    # "), "a place without keywords");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../python/halfline/options.py");
    if std::env::var_os("HALFLINE_WRITE").is_some() {
        fs::write(&path, &expected).expect("the file of the package");
    }
    let found = fs::read_to_string(&path).expect("the file of the package");
    let mend = "HALFLINE_WRITE=1 cargo test -p halfline-command --lib keywords_of_python writes it";
    assert!(found == expected, "python/halfline/options.py does not match the options: {mend}");
}
