//! Legend, label and scale bar inside the picture, as options.

use super::scene_args::SceneArgs;
use super::scene_frames::Numbered;
use clap::Args;
use halfline::camera::Viewport;
use halfline::error::{Error, Result};
use halfline::measure::plot::inset::{Corner, Insets, MOST_LETTERS, Panels, ScaleBar};
use halfline::quote::number;
use halfline::read::SceneFrame;
use halfline::read::style::Legend;
use halfline::scene::Scene;
use halfline::write::file::is_standard_output;
use std::ffi::OsString;

/// The options for what is drawn inside the picture.
#[derive(Debug, Args)]
#[command(next_help_heading = "Image")]
pub(super) struct InsetArgs {
    /// Draws the legend of the colours, of --color-by or else of the elements, inside the picture: right (the default),
    /// top-left, top-right, bottom-left, bottom-right. What is framed lies beside it. The corner may also follow a blank.
    #[arg(long, value_name = "CORNER", num_args = 0..=1, require_equals = true, default_missing_value = "right")]
    legend_in: Option<Corner>,
    /// Draws text at the top left; {frame}, {file} and {count} are replaced by the frame's number, the file's name and the
    /// number of spheres, {time} and {step} by the frame's time and step if its file has them.
    #[arg(long, value_name = "TEXT", value_parser = label)]
    label: Option<Label>,
    /// Draws a bar of a round length in scene units at the bottom left, with this unit in its label. With a perspective
    /// camera the length is that at the distance of the scene's middle.
    #[arg(long, value_name = "UNIT", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    scale_bar: Option<String>,
}

const LEGEND_IN: &str = "--legend-in";

/// The text of a label, in parts.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Label(Vec<LabelPart>);

#[derive(Debug, Clone, PartialEq, Eq)]
enum LabelPart {
    Text(String),
    Frame,
    File,
    Count,
    Time,
    Step,
}

impl InsetArgs {
    fn is_given(&self) -> bool {
        self.legend_in.is_some() || self.label.is_some() || self.scale_bar.is_some()
    }

    /// Checks the combination with other options before any work.
    ///
    /// # Errors
    /// [`Error::Settings`] for a part of a picture, and for a picture that is neither PNG nor EXR.
    pub(super) fn check(&self, args: &SceneArgs) -> Result<()> {
        if !self.is_given() {
            return Ok(());
        }
        let refuse = |problem: &str, mend: &str| {
            let what = "--legend-in, --label and --scale-bar";
            Err(Error::settings(format!("{what} {problem}"), mend))
        };
        if args.image.is_part() {
            return refuse("are drawn into whole pictures, because parts would not merge", "remove --crop or --tile");
        }
        let is_picture = |path: &std::path::Path| {
            let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
            is_standard_output(path) || ending.is_some_and(|ending| ending == "png" || ending == "exr")
        };
        match args.files.picture() {
            Some(path) if is_picture(path) && !args.files.is_raw() => Ok(()),
            _ => refuse("are drawn into a PNG or EXR picture", "use -o with the file name extension .png or .exr"),
        }
    }

    /// Whether a legend is drawn.
    pub(super) fn has_legend(&self) -> bool {
        self.legend_in.is_some()
    }

    /// The shares of the width of a picture that its legend takes at the left and the right.
    ///
    /// # Errors
    /// [`Error::Settings`] for a picture that is too small for its legend.
    pub(super) fn aside(&self, frame: &SceneFrame) -> Result<[f64; 2]> {
        let (Some(corner), Some(legend)) = (self.legend_in, &frame.legend) else { return Ok([0.0; 2]) };
        let insets = Insets { legend: Some((legend.clone(), corner)), ..Insets::default() };
        insets.aside(frame.scene.image.width, frame.scene.image.height)
    }

    /// What is drawn into one picture; `None` for nothing.
    ///
    /// # Errors
    /// [`Error::Settings`] for a picture that is too small for it, a time that the frame does not have, and a scale bar of
    /// a scene that is not in front of the camera.
    pub(super) fn panels(&self, args: &SceneArgs, picture: &Numbered) -> Result<Option<Panels>> {
        if !self.is_given() {
            return Ok(None);
        }
        let scene = &picture.scene;
        let legend = |legend: &Legend| self.legend_in.map(|corner| (legend.clone(), corner));
        let scale_bar = self.scale_bar.as_ref().map(|unit| {
            let unit = unit.clone();
            per_pixel(scene).map(|per_pixel| ScaleBar { per_pixel, unit })
        });
        let insets = Insets {
            legend: picture.legend.as_ref().and_then(legend),
            label: self.label.as_ref().map(|label| label.text(args, picture)).transpose()?,
            scale_bar: scale_bar.transpose()?,
        };
        insets.panels(scene.image.width, scene.image.height).map(Some)
    }

    /// What the panels of a picture do not show everywhere or leave free, in sentences.
    pub(super) fn words(&self, picture: &Numbered) -> impl Iterator<Item = String> {
        let is_vague = self.scale_bar.is_some() && !picture.scene.camera.lens.is_orthographic();
        let vague = "the scale bar holds at the distance of the scene's middle; with --ortho everywhere";
        let covers = self.legend_in.is_some() && picture.legend.is_some() && picture.framed.is_none();
        let covering = "the camera is given, so the legend may cover spheres";
        [(is_vague, vague), (covers, covering)].into_iter().filter(|(is, _)| *is).map(|(_, words)| words.to_owned())
    }
}

/// Scene units in a pixel: everywhere with an orthographic camera, else at the distance of the middle of all spheres.
fn per_pixel(scene: &Scene) -> Result<f64> {
    let Viewport { vw, d, .. } = scene.camera.viewport(scene.image.width, scene.image.height)?;
    let pixel = vw / f64::from(scene.image.width);
    if scene.camera.lens.is_orthographic() {
        return Ok(pixel);
    }
    let basis = scene.camera.basis()?;
    let depth = (basis.e - scene.spheres.middle()).dot(basis.w);
    if depth > 0.0 {
        return Ok(pixel * depth / d);
    }
    let problem = "--scale-bar needs the middle of all spheres in front of the camera";
    Err(Error::settings(problem, "use --ortho or another camera, or remove --scale-bar"))
}

impl Label {
    fn text(&self, args: &SceneArgs, picture: &Numbered) -> Result<String> {
        let part = |part: &LabelPart| {
            Ok(match part {
                LabelPart::Text(text) => text.clone(),
                LabelPart::Frame => picture.number.to_string(),
                LabelPart::File => {
                    let name = args.scene.file_name().unwrap_or(args.scene.as_os_str());
                    name.to_string_lossy().into_owned()
                }
                LabelPart::Count => picture.scene.spheres.len().to_string(),
                LabelPart::Time => {
                    let found = picture.when.time.map(brief);
                    found.ok_or_else(|| lacking("{time}", "time", picture.when.step.map(|_| "{step}")))?
                }
                LabelPart::Step => {
                    let found = picture.when.step.map(|step| step.to_string());
                    found.ok_or_else(|| lacking("{step}", "step", picture.when.time.map(|_| "{time}")))?
                }
            })
        };
        self.0.iter().map(part).collect()
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

/// The error for a name in braces that the frame has no number for; `other` is one that it has.
fn lacking(name: &str, what: &str, other: Option<&str>) -> Error {
    let other = other.map_or(String::new(), |other| format!(", or use {other}"));
    Error::settings(format!("--label has {name}, but the frame has no {what}"), format!("remove {name}{other}"))
}

/// The words of a command line in which the name of a corner behind `--legend-in` and a blank is joined to it by `=`, up
/// to `--`. For an option with an optional value clap would take any next word, also that of the scene file.
pub(super) fn joined(words: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let (mut all, mut ended): (Vec<OsString>, bool) = (Vec::new(), false);
    for word in words {
        ended |= word == "--";
        let corner = word.to_str().filter(|word| !ended && Corner::ALL.iter().any(|corner| corner.name() == *word));
        match (corner, all.last_mut()) {
            (Some(corner), Some(option)) if option == LEGEND_IN => option.push(format!("={corner}")),
            _ => all.push(word),
        }
    }
    all
}

fn label(text: &str) -> Result<Label, String> {
    if text.trim().is_empty() || text.chars().count() > MOST_LETTERS {
        return Err(format!("expected a text of 1 to {MOST_LETTERS} letters"));
    }
    let wrong = || "expected {frame}, {file}, {count}, {time} or {step} in braces".to_owned();
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
    Ok(Label(parts))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_corner_is_joined_to_its_option() {
        for (typed, words) in [
            ("render a.pdb --legend-in top-right -o b", "render a.pdb --legend-in=top-right -o b"),
            ("render --legend-in right", "render --legend-in=right"),
            ("render --legend-in a.pdb", "render --legend-in a.pdb"),
            ("render --legend-in ./right", "render --legend-in ./right"),
            ("render --legend-in=right right", "render --legend-in=right right"),
            ("render right -- --legend-in right", "render right -- --legend-in right"),
        ] {
            let typed = joined(typed.split(' ').map(OsString::from));
            assert_eq!(typed.join(" ".as_ref()), words);
        }
    }

    #[test]
    fn labels_are_text_with_names_in_braces() {
        let text = |text: &str| LabelPart::Text(text.into());
        assert_eq!(label("t"), Ok(Label(vec![text("t")])));
        let parts = vec![text("a "), LabelPart::Frame, text("/"), LabelPart::Count, text("")];
        assert_eq!(label("a {frame}/{count}"), Ok(Label(parts)));
        let times = [0.0, 100.00000762939453, 2.5, 0.1f32.into(), -3.0, 1e9].map(brief);
        assert_eq!(times, ["0", "100", "2.5", "0.1", "-3", "1.000000e9"]);
        for bad in ["", " ", "{", "}", "{x}", "{frame", "a}b", "{{frame}", "{}", &"x".repeat(1001)] {
            label(bad).expect_err(bad);
        }
    }
}
