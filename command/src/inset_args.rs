//! Legend, label and scale bar inside the picture, as options.

use super::file_args::FileArgs;
use super::picture_scene::PictureScene;
use clap::{ArgGroup, Args};
use halfline::error::{Error, Result};
use halfline::frame::legend::Legend;
use halfline::frame::{Aov, Frame};
use halfline::quote::list;
use halfline::render::Renderer;
use halfline::settings::Settings;
use halfline_drawing::inset::{Corner, Insets, Label, LabelValues, Panels, ScaleBar, Thing};
use halfline_files::read::SceneFrame;
use halfline_files::read::mark::{self, MarkRule, Marked};
use halfline_files::write::file::is_standard_output;
use halfline_files::write::format::FileFormat;
use std::ffi::OsString;
use std::path::Path;

/// The options for what is drawn inside the picture.
#[derive(Debug, Args)]
#[command(next_help_heading = "Image", group = ArgGroup::new("marks").args(["mark", "mark_one"]).multiple(true))]
pub(super) struct InsetArgs {
    /// Draws the legend of the colours, of --color-by or else of the elements, inside the picture: right (the default),
    /// top-left, top-right, bottom-left, bottom-right. Spheres that are framed lie beside it. CORNER may follow = or a space.
    #[arg(long, value_name = "CORNER", num_args = 0..=1, require_equals = true, default_missing_value = "right")]
    pub(super) legend_in: Option<Corner>,
    /// Draws text at the top left; {frame}, {file} and {count} are replaced by the frame's number, the file's name and the
    /// number of spheres, {time} and {step} by the frame's time and step if its file has them.
    #[arg(long, value_name = "TEXT")]
    label: Option<Label>,
    /// Draws a bar of a round length in scene units at the bottom left, with this unit in its label. With a perspective
    /// camera the length is that at the distance of the scene's middle.
    #[arg(long, value_name = "UNIT", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    pub(super) scale_bar: Option<String>,
    /// Writes a text at what an expression selects: at each residue, or at each particle of files without residues. {COLUMN} in the
    /// text is replaced by the value of a column. A text has no equals sign; the option may be repeated.
    #[arg(long, value_name = "EXPR=TEXT")]
    mark: Vec<MarkRule>,
    /// Writes a text once, at what an expression selects as a whole, such as 'chain A=receptor'. Otherwise as --mark.
    #[arg(long, value_name = "EXPR=TEXT")]
    mark_one: Vec<MarkRule>,
    /// Writes the texts of --mark and --mark-one also at what is hidden.
    #[arg(long, requires = "marks")]
    mark_all: bool,
}

const LEGEND_IN: &str = "--legend-in";

impl InsetArgs {
    /// Whether something is drawn into the picture.
    pub(super) fn is_given(&self) -> bool {
        self.legend_in.is_some() || self.label.is_some() || self.scale_bar.is_some() || self.has_marks()
    }

    /// Whether texts are written at things.
    pub(super) fn has_marks(&self) -> bool {
        !(self.mark.is_empty() && self.mark_one.is_empty())
    }

    /// The rules of the texts at things.
    pub(super) fn marks(&self) -> Vec<MarkRule> {
        self.mark.iter().cloned().chain(self.mark_one.iter().cloned().map(MarkRule::once)).collect()
    }

    /// Checks the combination with other options before any work; `is_part` says whether a part of the picture is rendered.
    ///
    /// # Errors
    /// [`Error::Settings`] for a part of a picture, and for a picture of arrays, such as .npy.
    pub(super) fn check(&self, is_part: bool, files: &FileArgs) -> Result<()> {
        let is_picture =
            |path: &Path| is_standard_output(path) || FileFormat::of(path).is_some_and(FileFormat::is_picture);
        let is_drawn = files.output.as_deref().is_some_and(|path| is_picture(path) || files.film().is_some());
        let is_drawn = is_drawn || files.figure().is_some();
        let mend = "use -o with the file name extension .png, .exr, .tif, .jpg, .webp, .svg, .pdf, .mp4 or .gif";
        self.check_place(is_part, is_drawn && !files.raw, "pictures and films", mend)
    }

    /// Checks that there is a whole picture to draw into: `places` are the pictures that have one.
    ///
    /// # Errors
    /// [`Error::Settings`] for a part of a picture, and with the mend where none is drawn.
    pub(super) fn check_place(&self, is_part: bool, is_drawn: bool, places: &str, mend: &str) -> Result<()> {
        if !self.is_given() {
            return Ok(());
        }
        let what = match self.has_marks() {
            true => "texts of --mark",
            false => "--legend-in, --label and --scale-bar",
        };
        let problem = |problem: &str| format!("{what} are drawn into {problem}");
        match (is_part, is_drawn) {
            (true, _) => {
                let whole = problem("whole pictures, because parts would not merge");
                Err(Error::settings(whole, "remove --crop or --tile"))
            }
            (false, false) => Err(Error::settings(problem(places), mend)),
            (false, true) => Ok(()),
        }
    }

    /// The shares of the width of a picture that its legend takes at the left and the right.
    ///
    /// # Errors
    /// [`Error::Settings`] for a picture that is too small for its legend.
    pub(super) fn legend_shares(&self, frame: &SceneFrame) -> Result<[f64; 2]> {
        let (Some(corner), Some(legend)) = (self.legend_in, &frame.legend) else { return Ok([0.0; 2]) };
        let insets = Insets { legend: Some((legend.clone(), corner)), ..Insets::default() };
        insets.legend_shares(frame.scene.image.width, frame.scene.image.height)
    }

    /// The panels to draw into one picture of the scene, whose file has this name: legend, label, scale bar. `None` if no option asks for
    /// one.
    ///
    /// # Errors
    /// [`Error::Settings`] for a picture that is too small for it, a time that the frame does not have, and a scale bar of
    /// a scene that is not in front of the camera.
    pub(super) fn panels(&self, file: Option<String>, picture: &PictureScene) -> Result<Option<Panels>> {
        if !self.is_given() {
            return Ok(None);
        }
        let scene = &picture.scene;
        let legend = |legend: &Legend| self.legend_in.map(|corner| (legend.clone(), corner));
        let insets = Insets {
            legend: picture.legend.as_ref().and_then(legend),
            label: self.label.as_ref().map(|label| label.text(&values(file.clone(), picture))).transpose()?,
            scale_bar: self.scale_bar.as_ref().map(|unit| ScaleBar::of(scene, unit)).transpose()?,
        };
        let mut panels = insets.panels(scene.image.width, scene.image.height)?;
        if self.has_marks() {
            panels.also_drawn(&mark::words(&picture.marked, self.mark_all));
        }
        Ok(Some(panels))
    }

    /// Adds the marks of a frame to its panels: of what its ids show, also through translucent spheres. Returns a warning about those
    /// that find no place.
    ///
    /// # Errors
    /// Errors of the camera, and of the renderer.
    pub(super) fn add_marks(
        &self,
        panels: &mut Panels,
        picture: &PictureScene,
        frame: &Frame,
        (renderer, settings): (&mut Renderer, &Settings),
    ) -> Result<Vec<String>> {
        let things: Vec<Thing> =
            picture.marked.iter().map(|Marked { text, ids }| (text.clone(), ids.clone())).collect();
        let settings = Settings { aovs: vec![Aov::Id], ..settings.clone() };
        panels.add_marks(&picture.scene, &things, frame.ids(), self.mark_all, |scene| renderer.render(scene, &settings))
    }

    /// A sentence on a scale bar that holds at one distance only.
    pub(super) fn words(&self, picture: &PictureScene) -> Option<&'static str> {
        let is_vague = self.scale_bar.is_some() && !picture.scene.camera.lens.is_orthographic();
        is_vague.then_some("the scale bar holds at the distance of the scene's middle; with --ortho everywhere")
    }

    /// A warning about spheres of a whole frame that panels cover.
    pub(super) fn covering(&self, panels: &Panels, frame: &Frame) -> Option<String> {
        let given = [
            (self.legend_in.is_some(), "--legend-in"),
            (self.label.is_some(), "--label"),
            (self.scale_bar.is_some(), "--scale-bar"),
        ];
        let names = list(given.into_iter().filter(|(is_given, _)| *is_given).map(|(_, name)| name));
        panels.cover_spheres(frame.ids(), frame.width).then(|| {
            let corner = if self.legend_in.is_some() { ", or another corner of --legend-in," } else { "" };
            format!("spheres lie under the panels of {names}; a smaller --zoom{corner} leaves them free")
        })
    }
}

/// The values of the names in braces of a label.
fn values(file: Option<String>, picture: &PictureScene) -> LabelValues {
    LabelValues {
        frame: picture.number,
        file,
        count: picture.ids.as_ref().map_or(picture.scene.spheres.len() - picture.beads, |ids| ids.count as usize),
        time: picture.when.time,
        step: picture.when.step,
    }
}

/// The words of a command line in which the name of a corner behind `--legend-in` and a blank is joined to it by `=`, up
/// to `--`. For an option with an optional value clap would take any next word, also the name of the scene file.
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
}
