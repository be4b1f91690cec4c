//! Keywords of Python as options of the command, which alone understands them.

use crate::errors::OrRaise;
use crate::work::begin;
use halfline::Aov;
use halfline::error::Result;
use halfline::settings::Settings;
use halfline_command::choices::Choices;
use halfline_command::shown::{Call, Form, WrittenOption, keywords, of_keyword};
use halfline_files::read::cut::CutRules;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyBytes, PyDict, PyFloat, PyInt, PyMapping, PyString};
use std::ffi::OsString;
use std::sync::Arc;

/// Keywords of a rendering that are no options: arrays of the package.
const ARRAYS: [&str; 2] = ["aovs", "dtype"];

/// The keywords of a rendering.
pub(crate) struct Chosen {
    /// The options that they are, without options of arrays.
    pub(crate) written: Vec<WrittenOption>,
    pub(crate) choices: Arc<Choices>,
    pub(crate) aovs: Vec<Aov>,
    /// Whether lengths are float32.
    pub(crate) single: bool,
}

impl Chosen {
    /// The keywords of `Renderer.render`.
    pub(crate) fn of(options: &Bound<'_, PyDict>) -> PyResult<Self> {
        let written = written(options, Call::Render)?;
        let choices = Choices::of(&written).or_raise()?;
        let aovs = match options.get_item("aovs")? {
            Some(names) => texts("aovs", &names)?.iter().map(|name| name.parse()).collect::<Result<_>>().or_raise()?,
            None => vec![Aov::Color],
        };
        let single = options.get_item("dtype")?.map_or(Ok(false), |dtype| is_single(&dtype))?;
        Ok(Self { written, choices, aovs, single })
    }
}

/// The settings of keywords that do not depend on a scene, accuracy, method, tolerance, and the planes that cut spheres.
pub(crate) fn settings(options: &Bound<'_, PyDict>) -> PyResult<(Settings, CutRules)> {
    let choices = Choices::of(&written(options, Call::Render)?).or_raise()?;
    Ok((choices.settings(Vec::new()), choices.cuts()))
}

/// The keywords of a call as options, in the order in which they are given. `None` and `False` stand for no option.
///
/// # Errors
/// TypeError for an unknown keyword; ValueError for a value of another form, which names the keyword; errors of [`begin`].
pub(crate) fn written(given: &Bound<'_, PyDict>, call: Call) -> PyResult<Vec<WrittenOption>> {
    // A process that was forked may wait for ever for the parser, which another thread had.
    begin()?;
    let mut all = Vec::with_capacity(given.len());
    for (keyword, value) in given {
        let keyword = keyword.extract::<String>()?;
        let Some((id, form)) = of_keyword(call, &keyword) else {
            if call == Call::Render && ARRAYS.contains(&&keyword[..]) {
                continue;
            }
            let others = if call == Call::Render { &ARRAYS[..] } else { &[] };
            let names: Vec<&str> = keywords(call).map(|(name, _)| name).chain(others.iter().copied()).collect();
            let problem = format!("there is no option '{keyword}'; choose from {}", names.join(", "));
            return Err(PyTypeError::new_err(problem));
        };
        if !value.is_none() {
            add(&mut all, id, form, &keyword, &value)?;
        }
    }
    Ok(all)
}

/// Adds an option each time that a value gives it.
fn add(all: &mut Vec<WrittenOption>, id: &str, form: Form, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
    let mut push = |word: Option<OsString>| all.push((id.to_owned(), word));
    match form {
        Form::Flag => {
            if value.is_truthy()? {
                push(None);
            }
        }
        Form::NumberOrFlag | Form::TextOrFlag | Form::Legend if is_bool(value)? => {
            if value.is_truthy()? {
                push(None);
            }
        }
        Form::Legend => {
            // No corner has a dot, and every file name an extension.
            let word = text(name, value)?;
            let is_file = word.as_encoded_bytes().contains(&b'.');
            all.push((if is_file { "legend" } else { id }.to_owned(), Some(word)));
        }
        Form::Number | Form::NumberOrFlag => push(Some(number(name, value)?.into())),
        Form::Text | Form::TextOrFlag => push(Some(text(name, value)?)),
        Form::Name if value.is_instance_of::<PyInt>() => push(Some(number(name, value)?.into())),
        Form::Name => push(Some(text(name, value)?)),
        Form::Marks if value.cast::<PyMapping>().is_err() => {
            return Err(wrong(name, value, "{expression: text}"));
        }
        Form::Columns => match value.cast::<PyMapping>() {
            Ok(meanings) => {
                let pairs =
                    pairs(meanings)?.into_iter().map(|(meaning, column)| Ok(format!("{meaning}={}", column.str()?)));
                push(Some(pairs.collect::<PyResult<Vec<_>>>()?.join(",").into()));
            }
            Err(_) => push(Some(text(name, value)?)),
        },
        Form::Names => push(Some(texts(name, value)?.join(",").into())),
        Form::Size => {
            let side = |name: &str, side: &Bound<'_, PyAny>| {
                if side.is_none() { Ok("auto".to_owned()) } else { whole(name, side) }
            };
            let sides = parts(name, value, side)?;
            if sides.len() != 2 {
                return Err(wrong(name, value, "(width, height), or (width, None)"));
            }
            push(Some(sides.join("x").into()));
        }
        Form::Tuple => push(Some(parts(name, value, number_or_text)?.join(",").into())),
        Form::Color => push(Some(color(name, value)?)),
        Form::Texts => texts(name, value)?.into_iter().for_each(|word| push(Some(word.into()))),
        Form::Files => {
            let is_one = value.is_instance_of::<PyString>() || value.hasattr("__fspath__")?;
            let several = || value.try_iter().map_err(|_| wrong(name, value, "a file or several"));
            let files = if is_one { vec![value.clone()] } else { several()?.collect::<PyResult<Vec<_>>>()? };
            for (k, file) in files.iter().enumerate() {
                push(Some(text(&format!("{name}[{k}]"), file)?));
            }
        }
        Form::Tuples => {
            let rows: Vec<Bound<'_, PyAny>> = items(name, value)?;
            let is_single = rows.first().is_some_and(|first| number(name, first).is_ok());
            let rows = if is_single { vec![value.clone()] } else { rows };
            for (k, row) in rows.iter().enumerate() {
                push(Some(parts(&format!("{name}[{k}]"), row, number)?.join(",").into()));
            }
        }
        Form::Rules | Form::Marks => match value.cast::<PyMapping>() {
            Ok(rules) => {
                for (expression, value) in pairs(rules)? {
                    let word = color(&format!("{name}['{expression}']"), &value)?;
                    if word.as_encoded_bytes().contains(&b'=') {
                        return Err(wrong(&format!("{name}['{expression}']"), &value, "a text without ="));
                    }
                    let mut rule = OsString::from(expression + "=");
                    rule.push(word);
                    push(Some(rule));
                }
            }
            Err(_) => push(Some(color(name, value)?)),
        },
    }
    Ok(())
}

/// Whether a value is `True` or `False`, of Python or of NumPy.
fn is_bool(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    Ok(value.is_instance_of::<PyBool>() || value.get_type().name()?.to_str()?.starts_with("bool"))
}

/// A number in decimals that are read back as the same number.
fn number(name: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    if is_bool(value)? || value.is_instance_of::<PyString>() || value.is_instance_of::<PyBytes>() {
        return Err(wrong(name, value, "a number"));
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(value.str()?.to_string());
    }
    if value.is_instance_of::<PyFloat>() {
        return finite(value.extract()?).ok_or_else(|| wrong(name, value, "a finite number"));
    }
    // Numbers of other packages.
    if let Ok(whole) = value.call_method0("__index__") {
        return Ok(whole.str()?.to_string());
    }
    match value.extract::<f64>() {
        Ok(number) => finite(number).ok_or_else(|| wrong(name, value, "a finite number")),
        Err(_) => Err(wrong(name, value, "a number")),
    }
}

/// A whole number above 0.
fn whole(name: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    let word = number(name, value)?;
    match word.bytes().all(|c| c.is_ascii_digit()) && word != "0" {
        true => Ok(word),
        false => Err(wrong(name, value, "a positive whole number")),
    }
}

fn finite(number: f64) -> Option<String> {
    number.is_finite().then(|| format!("{number:?}"))
}

/// A number, or a text such as a percentage.
fn number_or_text(name: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    match value.extract::<String>() {
        Ok(text) => Ok(text),
        Err(_) => number(name, value),
    }
}

/// A text or the name of a file.
fn text(name: &str, value: &Bound<'_, PyAny>) -> PyResult<OsString> {
    if let Ok(text) = value.extract::<String>() {
        return Ok(text.into());
    }
    if value.hasattr("__fspath__")? {
        return value.extract::<OsString>().or_else(|_| value.call_method0("__fspath__")?.extract());
    }
    Err(wrong(name, value, "a text"))
}

/// A text or several.
pub(crate) fn texts(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    if let Ok(text) = value.extract::<String>() {
        return Ok(vec![text]);
    }
    let Ok(items) = value.try_iter() else { return Err(wrong(name, value, "a text or a list of texts")) };
    let mut all = Vec::new();
    for (k, item) in items.enumerate() {
        let item = item?;
        match item.extract::<String>() {
            Ok(text) => all.push(text),
            Err(_) => return Err(wrong(&format!("{name}[{k}]"), &item, "a text")),
        }
    }
    Ok(all)
}

/// A text, a number, or a colour of three numbers.
fn color(name: &str, value: &Bound<'_, PyAny>) -> PyResult<OsString> {
    match value.extract::<String>() {
        Ok(text) => Ok(text.into()),
        Err(_) => match value.try_iter() {
            Ok(_) => Ok(parts(name, value, number)?.join(",").into()),
            Err(_) => Ok(number(name, value)?.into()),
        },
    }
}

fn items<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Vec<Bound<'py, PyAny>>> {
    match value.try_iter() {
        Ok(items) if !value.is_instance_of::<PyString>() => items.collect(),
        _ => Err(wrong(name, value, "several numbers")),
    }
}

/// The words of several values.
fn parts(
    name: &str,
    value: &Bound<'_, PyAny>,
    part: fn(&str, &Bound<'_, PyAny>) -> PyResult<String>,
) -> PyResult<Vec<String>> {
    items(name, value)?.iter().enumerate().map(|(k, item)| part(&format!("{name}[{k}]"), item)).collect()
}

/// The pairs of a mapping, in its order.
fn pairs<'py>(mapping: &Bound<'py, PyMapping>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    mapping.items()?.iter().map(|pair| pair.extract()).collect()
}

/// The error for a value of another form, which is shown in at most 60 characters.
fn wrong(name: &str, value: &Bound<'_, PyAny>, what: &str) -> PyErr {
    let text = value.repr().map_or_else(|_| "a value".to_owned(), |text| text.to_string());
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let text = if text.chars().count() <= 60 { text } else { text.chars().take(57).chain("...".chars()).collect() };
    PyValueError::new_err(format!("{name} is {text}; give {what}"))
}

/// Whether a type of NumPy is float32.
fn is_single(dtype: &Bound<'_, PyAny>) -> PyResult<bool> {
    let name = || -> PyResult<String> {
        dtype.py().import("numpy")?.getattr("dtype")?.call1((dtype,))?.getattr("name")?.extract()
    };
    match name().as_deref() {
        Ok("float32") if !dtype.is_none() => Ok(true),
        Ok("float64") if !dtype.is_none() => Ok(false),
        _ => Err(wrong("dtype", dtype, "'float32' or 'float64'")),
    }
}
