//! `halfline render SCENE`.

use super::bar::Bar;
use super::camera_list::WrittenCameras;
use super::clash::check_inputs;
use super::lines::ProgressOutput;
use super::messages::QuietArgs;
use super::preview::Preview;
use super::process::ExitCode;
use super::scene_args::SceneArgs;
use super::scene_frames::{Numbered, SceneFrames};
use super::{go_on, legend, note, print, say, threads};
use clap::Args;
use halfline::camera::CameraRecord;
use halfline::error::{Error, Result};
use halfline::frame::provenance::Origin;
use halfline::frame::{Aov, Frame};
use halfline::measure::plot::inset::Panels;
use halfline::progress::Cancel;
use halfline::render::{Renderer, origin};
use halfline::report::Report;
use halfline::scene::Scene;
use halfline::settings::{Accuracy, Backend, Settings};
use halfline::write::file::Target;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::fmt;
use std::num::NonZeroU32;
use std::path::Path;

/// Renders a picture of a scene or of particles, and the buffers behind it.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, next_line_help = true)]
pub(crate) struct Render {
    #[command(flatten)]
    args: SceneArgs,
    /// Skips files that exist, are complete and come from the same rendering.
    #[arg(long, help_heading = "Output")]
    resume: bool,
    /// Prints one JSON object about the rendering on standard output.
    #[arg(long, help_heading = REPORTING)]
    json: bool,
    /// Progress reporting: auto (a line on a terminal), none, json (lines on standard error), openjd (Open Job
    /// Description on standard output).
    #[arg(long, help_heading = REPORTING, value_name = "P", value_enum, hide_possible_values = true,
        default_value = "auto")]
    progress: ProgressOutput,
    /// Shows the picture in a terminal with 24-bit colours; =blocks shows it on any standard error.
    #[arg(long, help_heading = REPORTING, value_name = "blocks", num_args = 0..=1, require_equals = true,
        default_missing_value = "auto")]
    preview: Option<Preview>,
    /// Renders N times in one process, for time measurements.
    #[arg(long, help_heading = REPORTING, value_name = "N", default_value = "1")]
    repeat: NonZeroU32,
    #[command(flatten)]
    quiet: QuietArgs,
}

/// The most spheres of a scene beside which the next one is prepared: some 200 MB.
const AHEAD: usize = 1 << 22;

/// The heading of the options that report on the rendering.
const REPORTING: &str = "Reporting";

const EXAMPLES: &str = "\
Examples:
  halfline render molecule.pdb -o molecule.png
  halfline render molecule.pdb --color-by chain --background white -o chains.png
  halfline render run.dump --frames 1-100 --color-by vx,vy,vz --range 0,3 -o frame.%04d.png
  halfline render scenes/weekend.toml -o w.png --aov id=id.npy --aov depth=z.npy
  halfline render planet.toml -o p.png --eye 0,1.7,0 --view 0,0,-1 --vfov 60";

/// The message of `halfline render` without arguments.
pub(super) const START: &str = "\
error: halfline render needs a file

A molecule, with the radii and colours of its elements:
  halfline render molecule.pdb -o molecule.png
Particles, coloured by a column of their file:
  halfline render particles.csv --color-by speed --legend speed.svg -o particles.png
A scene file, with the depth of every pixel:
  halfline render scene.toml -o scene.png --aov depth=depth.npy

All options: halfline render --help
";

impl Render {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        self.quiet.apply();
        let targets = self.check()?;
        let mut settings = self.args.settings(&targets);
        if self.preview.is_some() && !settings.aovs.contains(&Aov::Color) {
            settings.aovs.push(Aov::Color);
        }
        // Opening a device takes time, so it runs beside the reading of the scene.
        let cancel = Cancel::default();
        let (opened, renderer) = threads::both(|| self.first(&cancel), || Renderer::new(&settings));
        // Errors of the scene are reported before those of the adapter.
        let ((mut scene_frames, mut picture), renderer) = (opened?, renderer?);
        let bar = Bar::with_output(self.progress, self.repeat.get().saturating_mul(self.args.expected()));
        let mut renderer = renderer.watched_by(bar.watch());
        if self.args.accuracy.compute.backend == Backend::Auto
            && !renderer.is_gpu()
            && renderer.passed_over().is_empty()
        {
            note(format_args!("no Vulkan, Metal or DX12 adapter was found: falling back to the CPU path"));
        }
        let (mut printed, mut cameras) = (BTreeSet::new(), WrittenCameras::default());
        // The next scene is prepared while one is rendered, unless two would need much memory.
        let is_large = picture.as_ref().is_some_and(|picture| picture.scene.spheres.len() > AHEAD);
        let mut next = || match picture.take() {
            Some(first) => Ok(Some(first)),
            None => self.ready(&mut scene_frames),
        };
        let mut each = |now: Numbered| {
            if !go_on() {
                return Err(Error::Interrupted);
            }
            self.picture(&now, &settings, &mut renderer, &bar, &mut printed)?;
            let image = now.scene.image;
            let files = self.args.files.targets(now.number)?;
            let camera = CameraRecord::new(&now.scene.camera, image.width, image.height)?;
            cameras.add(now.number, files.iter().map(Target::path), camera);
            Ok(())
        };
        if self.args.is_many() && !is_large {
            threads::ahead(next, &cancel, each)?;
        } else {
            while let Some(now) = next()? {
                each(now)?;
            }
        }
        bar.finish();
        if let Some(list) = self.args.camera_list()? {
            cameras.write(list.parent().unwrap_or(Path::new("")))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Renders one scene and writes its files, unless all exist. Messages in `printed` are not printed again.
    fn picture(
        &self,
        picture: &Numbered,
        settings: &Settings,
        renderer: &mut Renderer,
        bar: &Bar,
        printed: &mut BTreeSet<String>,
    ) -> Result<()> {
        let scene = &picture.scene;
        let mut targets = self.args.files.targets(picture.number)?;
        let panels = self.args.insets.panels(&self.args, picture)?;
        if let (Some(panels), Some(target)) = (&panels, targets.first_mut()) {
            target.set_drawn(panels.words());
        }
        let settings = &self.args.settings_for(picture, settings, &targets)?;
        if self.resume && !targets.is_empty() {
            let report = renderer.dry_run(scene, settings)?;
            let origin = origin(scene, settings, &report, settings.window_of(scene)?);
            targets.retain(|target| !target.is_there_while(&origin, &go_on));
            if targets.is_empty() {
                let which = if self.args.is_many() { format!("picture {}: ", picture.number) } else { String::new() };
                bar.aside(|| {
                    note(format_args!(
                        "{which}already there: every file is complete and comes from the same rendering"
                    ));
                });
                self.write_legend(picture)?;
                return self.print_report(&Report { resumed: true, number: picture.number, ..report });
            }
        }
        let mut once = |words: String, print: fn(fmt::Arguments<'_>)| {
            if !printed.contains(&words) {
                bar.aside(|| print(format_args!("{words}")));
                printed.insert(words);
            }
        };
        once(format!("rendering on {} ({})", renderer.adapter(), renderer.driver()), note);
        let mut frame = self.frames(renderer, scene, settings, &targets)?;
        frame.report.number = picture.number;
        frame.report.hold = self.args.read.hold();
        self.args.read.hold_words().into_iter().for_each(|words| once(words, note));
        picture.look.words().into_iter().for_each(|words| once(words, note));
        if settings.tolerance.is_some() && settings.accuracy == Accuracy::Auto {
            once(frame.report.reason.clone(), note);
        }
        frame.report.warnings.iter().for_each(|warning| once(format!("warning: {warning}"), say));
        if !targets.is_empty() {
            self.args.insets.words(scene).into_iter().for_each(|words| once(words, note));
            let (report, window) = (frame.report.clone(), frame.window);
            self.write(&mut frame, &targets, panels.as_ref(), &origin(scene, settings, &report, window))?;
        }
        self.write_legend(picture)?;
        if let Some(preview) = self.preview {
            preview.show(&frame);
        }
        self.print_report(&frame.report)?;
        renderer.recycle(frame);
        Ok(())
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

    fn write_legend(&self, picture: &Numbered) -> Result<()> {
        match (legend::file(&self.args, picture.number)?, &picture.legend) {
            (Some(path), Some(legend)) => legend::write(legend, &path),
            _ => Ok(()),
        }
    }

    /// Prints the report if --json is given.
    fn print_report(&self, report: &Report) -> Result<()> {
        if !self.json {
            return Ok(());
        }
        let text = serde_json::to_string(report).map_err(|e| Error::write("-", e.into()))?;
        print(&format!("{text}\n"))
    }

    /// The opened file and its first scene.
    fn first(&self, cancel: &Cancel) -> Result<(SceneFrames<'_>, Option<Numbered>)> {
        let mut scene_frames = SceneFrames::open(&self.args, cancel)?;
        let first = self.ready(&mut scene_frames)?;
        Ok((scene_frames, first))
    }

    /// The next scene, once its files are known to be writable.
    fn ready(&self, scene_frames: &mut SceneFrames<'_>) -> Result<Option<Numbered>> {
        let Some(picture) = scene_frames.next_frame()? else { return Ok(None) };
        let targets = self.args.files.targets(picture.number)?;
        let legend = legend::file(&self.args, picture.number)?;
        let list = self.args.camera_list()?;
        let written = targets.iter().map(Target::path).chain(legend.as_deref()).chain(list.as_deref());
        check_inputs(written, &scene_frames.inputs())?;
        targets.iter().try_for_each(Target::check)?;
        picture.scene.check()?;
        Ok(Some(picture))
    }

    /// The files of the first picture; checks combinations of options.
    fn check(&self) -> Result<Vec<Target>> {
        let targets = self.args.files.targets(1)?;
        if self.args.is_many() {
            self.args.files.check_many()?;
        }
        legend::check(&self.args)?;
        self.args.insets.check(&self.args)?;
        self.args.check_outputs()?;
        if targets.is_empty() && !self.json && self.preview.is_none() {
            let problem = "no output is requested";
            return Err(Error::settings(problem, "use -o for a picture, --aov for a buffer, or --json"));
        }
        let standard = targets.iter().filter(|target| target.is_standard()).count();
        if standard + usize::from(self.json) + usize::from(self.progress == ProgressOutput::Openjd) > 1 {
            let problem = "standard output can hold only one of: a picture, a buffer, the JSON, the lines of openjd";
            return Err(Error::settings(problem, "use files for the others"));
        }
        Ok(targets)
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
