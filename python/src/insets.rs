//! Insets in the pictures of a frame: legend, label, scale bar.

use crate::scene::Scene;
use halfline::error::{Error, Result};
use halfline::frame::legend::Legend;
use halfline::quote::setting::LEGEND;
use halfline::scene::ImagePlane;
use halfline_drawing::inset::{Corner, Insets as CoreInsets, Label, LabelValues, Panels, ScaleBar, Thing};
use halfline_files::read::mark::{self, MarkRule, Marked};
use halfline_files::write::figure;
use halfline_files::write::file::check_writable;
use pyo3::prelude::*;
use std::path::PathBuf;

/// The keywords of the insets.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Insets {
    /// The name of a corner.
    legend: Option<String>,
    /// The file of the legend.
    legend_file: Option<PathBuf>,
    label: Option<String>,
    /// The unit; empty for none.
    scale_bar: Option<String>,
    /// Expressions and their texts.
    mark: Vec<(String, String)>,
    mark_all: bool,
}

impl Insets {
    /// Whether anything is drawn into the picture.
    fn is_given(&self) -> bool {
        self.legend.is_some() || self.label.is_some() || self.scale_bar.is_some() || !self.mark.is_empty()
    }

    /// Whether things have marks.
    pub(crate) fn has_marks(&self) -> bool {
        !self.mark.is_empty()
    }

    /// The things of a scene that have marks, with their texts, and messages about the expressions.
    pub(crate) fn marked(&self, scene: &Scene) -> Result<(Vec<Marked>, Vec<String>)> {
        let rules = self.mark.iter().map(|(expression, text)| MarkRule::new(expression, text));
        scene.frame.marked(&rules.collect::<Result<Vec<_>>>()?)
    }

    /// Adds the marks of a frame to its panels: of what its ids show, also through translucent spheres, of which
    /// `render` renders a frame without them. Returns a warning about those that find no place.
    pub(crate) fn add_marks(
        &self,
        panels: &mut Panels,
        exact: &halfline::Scene,
        ids: &[i32],
        marked: &[Marked],
        render: impl FnOnce(&halfline::Scene) -> Result<halfline::Frame>,
    ) -> Result<Option<String>> {
        panels.also_drawn(&mark::words(marked, self.mark_all));
        let things: Vec<Thing> = marked.iter().map(|Marked { text, ids }| (text.clone(), ids.clone())).collect();
        panels.add_marks(exact, &things, ids, self.mark_all, render)
    }

    /// Checks what does not depend on a camera; `cropped` says whether a part of the picture is rendered, `colored` whether
    /// there is a picture.
    pub(crate) fn check(&self, scene: &Scene, cropped: bool, colored: bool) -> Result<()> {
        let what = if self.mark.is_empty() { "legend, label and scale_bar" } else { "texts of mark" };
        let refuse = |problem: &str, mend: &str| Err(Error::settings(format!("{what} are drawn into {problem}"), mend));
        self.label()?;
        if let Some(path) = &self.legend_file {
            figure::check(path)?;
            check_writable(path)?;
        }
        self.lacking(scene)?;
        match (self.is_given(), cropped, colored) {
            (true, true, _) => refuse("whole pictures, because parts would not merge", "remove crop"),
            (true, _, false) => refuse("the picture, and the frame has none", "add 'color' to aovs"),
            _ => Ok(()),
        }
    }

    fn label(&self) -> Result<Option<Label>> {
        self.label.as_deref().map(str::parse).transpose()
    }

    /// The label of picture `number` of this scene.
    pub(crate) fn text(&self, scene: &Scene, number: u64) -> Result<Option<String>> {
        let frame = &scene.frame;
        let values = LabelValues {
            frame: number,
            file: scene.file.clone(),
            count: frame.scene.spheres.len() - frame.beads,
            time: frame.when.time,
            step: frame.when.step,
        };
        self.label()?.map(|label| label.text(&values)).transpose()
    }

    /// A warning about a legend that has nothing to show.
    pub(crate) fn lacking(&self, scene: &Scene) -> Result<Option<String>> {
        let is_given = self.legend.is_some() || self.legend_file.is_some();
        let lacks = is_given && scene.frame.legend.is_none();
        let (column, is_empty) = (scene.colored_by.as_deref(), scene.spheres().is_empty());
        lacks.then(|| Legend::lacking(LEGEND, column, is_empty)).transpose()
    }

    /// Writes the file of the legend, if one is requested.
    pub(crate) fn write(&self, scene: &Scene) -> Result<()> {
        let (Some(path), Some(legend)) = (&self.legend_file, &scene.frame.legend) else { return Ok(()) };
        let drawing = halfline_drawing::legend::draw(legend)?;
        figure::write(path, &drawing.svg, drawing.size, &drawing.levels)
    }

    /// The shares of the width of this scene's picture that its legend takes at the left and the right.
    pub(crate) fn legend_shares(&self, scene: &Scene, image: ImagePlane) -> Result<[f64; 2]> {
        CoreInsets { legend: self.shown(scene)?, ..CoreInsets::default() }.legend_shares(image.width, image.height)
    }

    /// The legend in the picture and its corner.
    fn shown(&self, scene: &Scene) -> Result<Option<(Legend, Corner)>> {
        let corner = self.legend.as_deref().map(str::parse::<Corner>).transpose()?;
        Ok(scene.frame.legend.clone().zip(corner))
    }

    /// The panels to draw into picture `number` of this scene; `None` if no keyword asks for one.
    pub(crate) fn panels(&self, scene: &Scene, exact: &halfline::Scene, number: u64) -> Result<Option<Panels>> {
        if !self.is_given() {
            return Ok(None);
        }
        let insets = CoreInsets {
            legend: self.shown(scene)?,
            label: self.text(scene, number)?,
            scale_bar: self.scale_bar.as_deref().map(|unit| ScaleBar::of(exact, unit)).transpose()?,
        };
        insets.panels(exact.image.width, exact.image.height).map(Some)
    }

    /// Warnings about letters of the panels and of the legend's PNG file that the font lacks, in whole sentences.
    pub(crate) fn warnings(&self, scene: &Scene, panels: Option<&Panels>) -> Vec<String> {
        let of_file = self.legend_file.as_ref().filter(|path| figure::is_png(path)).and(scene.frame.legend.as_ref());
        let mut all: Vec<String> = panels.and_then(Panels::warning).into_iter().collect();
        all.extend(of_file.and_then(halfline_drawing::legend::warning).filter(|words| !all.contains(words)));
        all
    }
}
