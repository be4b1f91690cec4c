//! The text of a label, in which names in braces stand for what is known of a picture.

use super::MOST_LETTERS;
use halfline::error::{Error, Result};
use halfline::quote::number;
use halfline::quote::setting::LABEL;
use std::str::FromStr;

/// The text of a label, in parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label(Vec<LabelPart>);

#[derive(Debug, Clone, PartialEq, Eq)]
enum LabelPart {
    Text(String),
    Frame,
    File,
    Count,
    Time,
    Step,
}

/// The values of the names in braces for one picture.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LabelValues {
    /// `{frame}`: the number of the frame or of the picture.
    pub frame: u64,
    /// `{file}`: the name of the scene's file, if it has one.
    pub file: Option<String>,
    /// `{count}`: the number of spheres.
    pub count: usize,
    /// `{time}`, if the file has it.
    pub time: Option<f64>,
    /// `{step}`, if the file has it.
    pub step: Option<i64>,
}

impl Label {
    /// The text for one picture.
    ///
    /// # Errors
    /// [`Error::Settings`] for a name that the picture has nothing for.
    pub fn text(&self, values: &LabelValues) -> Result<String> {
        let LabelValues { time, step, .. } = *values;
        let part = |part: &LabelPart| {
            Ok(match part {
                LabelPart::Text(text) => text.clone(),
                LabelPart::Frame => values.frame.to_string(),
                LabelPart::File => values.file.clone().ok_or_else(|| lacking("{file}", "scene", "file", None))?,
                LabelPart::Count => values.count.to_string(),
                LabelPart::Time => {
                    let found = time.map(brief);
                    found.ok_or_else(|| lacking("{time}", "frame", "time", step.map(|_| "{step}")))?
                }
                LabelPart::Step => {
                    let found = step.map(|step| step.to_string());
                    found.ok_or_else(|| lacking("{step}", "frame", "step", time.map(|_| "{time}")))?
                }
            })
        };
        self.0.iter().map(part).collect()
    }
}

impl FromStr for Label {
    type Err = Error;

    /// Parses a text of at most [`MOST_LETTERS`] letters; the names in braces are `frame`, `file`, `count`, `time`, `step`.
    ///
    /// # Errors
    /// [`Error::Settings`] for a blank or too long text, and for another name in braces.
    fn from_str(text: &str) -> Result<Self> {
        if text.trim().is_empty() || text.chars().count() > MOST_LETTERS {
            let problem = if text.trim().is_empty() { "the label is empty" } else { "the label is too long" };
            return Err(Error::settings(problem, format!("use a text of 1 to {MOST_LETTERS} letters")));
        }
        let wrong = || {
            let problem = "braces in a label hold another name";
            Error::settings(problem, "use {frame}, {file}, {count}, {time} or {step} in braces")
        };
        let (mut parts, mut rest) = (Vec::new(), text);
        while let Some(start) = rest.find(['{', '}']) {
            let (before, from) = rest.split_at(start);
            let (name, after) = from.strip_prefix('{').and_then(|from| from.split_once('}')).ok_or_else(wrong)?;
            parts.push(LabelPart::Text(before.to_owned()));
            parts.push(match name {
                "frame" => LabelPart::Frame,
                "file" => LabelPart::File,
                "count" => LabelPart::Count,
                "time" => LabelPart::Time,
                "step" => LabelPart::Step,
                _ => return Err(wrong()),
            });
            rest = after;
        }
        parts.push(LabelPart::Text(rest.to_owned()));
        Ok(Self(parts))
    }
}

/// A time with seven significant digits, which a number of 32 bits has, and without zeros at its end.
fn brief(time: f64) -> String {
    let text = number(time, 7);
    if text.contains('e') || !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The error for a name in braces that the picture has nothing for; `other` is one that it has.
fn lacking(name: &str, of: &str, what: &str, other: Option<&str>) -> Error {
    let other = other.map_or(String::new(), |other| format!(", or use {other}"));
    Error::settings(format!("{LABEL} has {name}, but the {of} has no {what}"), format!("remove {name}{other}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_text_with_names_in_braces() {
        let text = |text: &str| LabelPart::Text(text.into());
        let label = |text: &str| text.parse::<Label>();
        assert_eq!(label("t").expect("a label"), Label(vec![text("t")]));
        let parts = vec![text("a "), LabelPart::Frame, text("/"), LabelPart::Count, text("")];
        assert_eq!(label("a {frame}/{count}").expect("a label"), Label(parts));
        let times = [0.0, 100.00000762939453, 2.5, 0.1f32.into(), -3.0, 1e9].map(brief);
        assert_eq!(times, ["0", "100", "2.5", "0.1", "-3", "1.000000e9"]);
        for bad in ["", " ", "{", "}", "{x}", "{frame", "a}b", "{{frame}", "{}", &"x".repeat(1001)] {
            label(bad).expect_err(bad);
        }
    }

    #[test]
    fn a_name_without_a_value_is_an_error_with_another() {
        let label: Label = "{file} {time}".parse().expect("a label");
        let values = LabelValues { frame: 3, file: Some("a.dump".into()), count: 2, time: None, step: Some(7) };
        let fault = label.text(&values).expect_err("no time").to_string();
        assert!(fault.contains("{time}") && fault.contains("or use {step}"), "{fault}");
        let timed = LabelValues { time: Some(2.5), step: None, ..values };
        assert_eq!(label.text(&timed).expect("a text"), "a.dump 2.5");
        let fault = label.text(&LabelValues { file: None, ..timed }).expect_err("no file").to_string();
        assert!(fault.contains("the scene has no file"), "{fault}");
    }
}
