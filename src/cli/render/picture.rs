//! One picture of `halfline render`: rendered, written, and reported in its turn.

use super::Render;
use crate::cli::bar::Bar;
use crate::cli::scene_frames::Numbered;
use crate::cli::{go_on, legend, note, say};
use halfline::camera::CameraRecord;
use halfline::error::Result;
use halfline::frame::Frame;
use halfline::frame::provenance::Origin;
use halfline::measure::plot::inset::Panels;
use halfline::render::{Renderer, origin};
use halfline::report::Report;
use halfline::scene::Scene;
use halfline::settings::{Accuracy, Settings};
use halfline::write::file::Target;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::fmt;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Messages on standard error, each once for all pictures.
pub(super) struct Messages<'a> {
    bar: &'a Bar,
    printed: Mutex<BTreeSet<String>>,
}

impl<'a> Messages<'a> {
    pub(super) fn new(bar: &'a Bar) -> Self {
        Self { bar, printed: Mutex::default() }
    }

    fn note(&self, words: String) {
        self.once(words, note);
    }

    fn warn(&self, warning: &str) {
        self.once(format!("warning: {warning}"), say);
    }

    fn once(&self, words: String, print: fn(fmt::Arguments<'_>)) {
        let mut printed = self.printed.lock().unwrap_or_else(PoisonError::into_inner);
        if !printed.contains(&words) {
            self.bar.aside(|| print(format_args!("{words}")));
            printed.insert(words);
        }
    }
}

/// A picture that is written.
pub(super) struct Picture {
    pub(super) number: u64,
    /// The files that show it.
    pub(super) files: Vec<PathBuf>,
    pub(super) camera: CameraRecord,
    pub(super) report: Report,
}

impl Render {
    /// Renders one scene and writes its files, unless all exist.
    pub(super) fn picture(
        &self,
        numbered: &Numbered,
        settings: &Settings,
        renderer: &mut Renderer,
        messages: &Messages<'_>,
    ) -> Result<Picture> {
        let (scene, image) = (&numbered.scene, numbered.scene.image);
        let mut targets = self.args.files.targets(numbered.number)?;
        let files = targets.iter().map(|target| target.path().to_path_buf()).collect();
        let camera = CameraRecord::new(&scene.camera, image.width, image.height)?;
        let written = |report| Picture { number: numbered.number, files, camera, report };
        let panels = self.args.insets.panels(&self.args, numbered)?;
        if let (Some(panels), Some(target)) = (&panels, targets.first_mut()) {
            target.set_drawn(panels.words());
        }
        let settings = &self.args.settings_for(numbered, settings, &targets)?;
        if self.resume && !targets.is_empty() {
            let mut report = renderer.dry_run(scene, settings)?;
            report.spheres = numbered.ids.as_ref().map_or(report.spheres, |ids| ids.count);
            let origin = origin(scene, settings, &report, settings.window_of(scene)?);
            targets.retain(|target| !target.is_there_while(&origin, &go_on));
            if targets.is_empty() {
                let which = if self.args.is_many() { format!("picture {}: ", numbered.number) } else { String::new() };
                let there = "already there: every file is complete and comes from the same rendering";
                messages.note(format!("{which}{there}"));
                self.write_legend(numbered)?;
                return Ok(written(Report { resumed: true, number: numbered.number, ..report }));
            }
        }
        messages.note(format!("rendering on {} ({})", renderer.adapter(), renderer.driver()));
        let mut frame = self.frames(renderer, scene, settings, &targets)?;
        if let Some(ids) = &numbered.ids {
            ids.restore(&mut frame);
        }
        frame.report.number = numbered.number;
        frame.report.hold = self.args.read.hold();
        frame.report.warnings.extend(panels.as_ref().and_then(Panels::warning));
        let of_legend = legend::warning(&self.args, numbered.legend.as_ref());
        frame.report.warnings.extend(of_legend.filter(|words| !frame.report.warnings.contains(words)));
        self.args.read.hold_words().into_iter().chain(numbered.look.words()).for_each(|words| messages.note(words));
        if settings.tolerance.is_some() && settings.accuracy == Accuracy::Auto {
            messages.note(frame.report.reason.clone());
        }
        frame.report.warnings.iter().for_each(|warning| messages.warn(warning));
        if !targets.is_empty() {
            self.args.insets.words(numbered).for_each(|words| messages.note(words));
            let (report, window) = (frame.report.clone(), frame.window);
            self.write(&mut frame, &targets, panels.as_ref(), &origin(scene, settings, &report, window))?;
        }
        self.write_legend(numbered)?;
        if let Some(preview) = self.preview {
            preview.show(&frame);
        }
        let written = written(frame.report.clone());
        renderer.recycle(frame);
        Ok(written)
    }

    /// Renders the repeated frames; returns the last one with the times of all and the warnings of its files.
    fn frames(&self, renderer: &mut Renderer, scene: &Scene, settings: &Settings, targets: &[Target]) -> Result<Frame> {
        let mut frame = renderer.render(scene, settings)?;
        let mut times = frame.report.frame_ms.clone();
        let mut kernels = frame.report.kernel_ms.clone();
        for _ in 1..self.repeat.get() {
            renderer.recycle(frame);
            frame = renderer.render(scene, settings)?;
            times.extend(&frame.report.frame_ms);
            kernels.extend(&frame.report.kernel_ms);
        }
        (frame.report.frame_ms, frame.report.kernel_ms) = (times, kernels);
        let beyond: Vec<_> = targets.iter().flat_map(|target| target.warnings(&frame)).collect();
        frame.report.warnings.extend(beyond);
        Ok(frame)
    }

    fn write_legend(&self, numbered: &Numbered) -> Result<()> {
        match (legend::file(&self.args, numbered.number)?, &numbered.legend) {
            (Some(path), Some(legend)) => legend::write(legend, &path),
            _ => Ok(()),
        }
    }

    /// Writes the files; the panels are drawn into the picture, and into no other file.
    fn write(&self, frame: &mut Frame, targets: &[Target], panels: Option<&Panels>, origin: &Origin<'_>) -> Result<()> {
        let (pictures, others): (Vec<_>, Vec<_>) = targets.iter().partition(|target| target.is_drawn_on());
        let write = |frame: &Frame, targets: &[&Target]| {
            targets.par_iter().try_for_each(|target| target.write_while(frame, origin, &go_on))
        };
        if let Some(panels) = panels.filter(|_| !pictures.is_empty()) {
            let covered = panels.draw(frame, self.args.files.is_transparent());
            let written = write(frame, &pictures);
            covered.restore(frame);
            written?;
        }
        write(frame, &others)
    }
}
