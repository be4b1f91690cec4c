//! `halfline render SCENE`.

use super::bar::Bar;
use super::clash::check_inputs;
use super::lines::Talk;
use super::preview::Preview;
use super::scene_args::SceneArgs;
use super::shots::{Numbered, Shots};
use super::{go_on, legend, print, say, threads};
use clap::Args;
use halfline::error::{Error, Result};
use halfline::frame::file::Target;
use halfline::frame::provenance::Origin;
use halfline::frame::{Aov, Frame};
use halfline::render::{Renderer, origin};
use halfline::report::Report;
use halfline::scene::Scene;
use halfline::settings::{Accuracy, Backend, Settings};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::num::NonZeroU32;
use std::process::ExitCode;

/// Renders a scene: a picture, and the buffers beside it that are asked for.
///
/// Examples:
///   halfline render scenes/weekend.toml -o weekend.png
///   halfline render balls.nff -o balls.png --aov id=id.npy --aov distance=t.npy --json
///   halfline render planet.toml -o planet.png --eye 0,1.7,0 --view 0,0,-1 --vfov 60 --size 1920x1080
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Render {
    #[command(flatten)]
    asked: SceneArgs,
    /// Renders N times in one process, for measuring.
    #[arg(long, value_name = "N", default_value = "1")]
    repeat: NonZeroU32,
    /// Prints one JSON object about the rendering on standard output.
    #[arg(long)]
    json: bool,
    /// Leaves alone every file that is whole and says word for word that it comes from this very rendering; renders nothing
    /// if all do.
    #[arg(long)]
    resume: bool,
    /// Progress reporting: a line on a terminal, none, lines of JSON on standard error, or the lines of Open Job
    /// Description on standard output.
    #[arg(long, value_name = "P", value_enum, default_value = "auto")]
    progress: Talk,
    /// Shows the picture in the terminal, in half blocks of 24-bit colours; =blocks insists where there is no terminal.
    #[arg(long, value_name = "blocks", num_args = 0..=1, require_equals = true, default_missing_value = "auto")]
    preview: Option<Preview>,
}

impl Render {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        let targets = self.check()?;
        let mut settings = self.asked.settings(&targets);
        if self.preview.is_some() && !settings.aovs.contains(&Aov::Color) {
            settings.aovs.push(Aov::Color);
        }
        // A device takes its time to open, on another core than the one that reads.
        let (opened, renderer) = std::thread::scope(|scope| {
            let open = || Renderer::new(&settings);
            let other = (!threads::is_alone()).then(|| std::thread::Builder::new().spawn_scoped(scope, open));
            let first = self.first();
            match other {
                Some(Ok(opening)) => (first, opening.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))),
                // The system allows no more threads.
                _ => (first, open()),
            }
        });
        // What is wrong with the scene is told first, whatever adapters there are.
        let ((mut shots, mut shot), renderer) = (opened?, renderer?);
        let bar = Bar::talking(self.progress, self.repeat.get().saturating_mul(self.asked.expected()));
        let mut renderer = renderer.watched_by(bar.watch());
        if self.asked.backend == Backend::Auto && !renderer.is_gpu() && renderer.passed_over().is_empty() {
            say(format_args!("no Vulkan, Metal or DX12 adapter was found: falling back to the CPU path"));
        }
        let mut told = BTreeSet::new();
        while let Some(now) = shot {
            if !go_on() {
                return Err(Error::Interrupted);
            }
            self.picture(&now, &settings, &mut renderer, &bar, &mut told)?;
            shot = self.ready(&mut shots)?;
        }
        bar.finish();
        Ok(ExitCode::SUCCESS)
    }

    /// Renders one scene and writes its files, if anything is left to render. What was `told` is not told again.
    fn picture(
        &self,
        shot: &Numbered,
        settings: &Settings,
        renderer: &mut Renderer,
        bar: &Bar,
        told: &mut BTreeSet<String>,
    ) -> Result<()> {
        let scene = &shot.scene;
        let mut targets = self.asked.files.targets(shot.number)?;
        let settings = &self.asked.settings_for(scene, settings, &targets)?;
        if self.resume && !targets.is_empty() {
            let report = renderer.dry_run(scene, settings)?;
            let origin = origin(scene, settings, &report, settings.window_of(scene)?);
            targets.retain(|target| !target.is_there_while(&origin, &go_on));
            if targets.is_empty() {
                let which = if self.asked.is_many() { format!("picture {}: ", shot.number) } else { String::new() };
                bar.aside(|| {
                    say(format_args!("{which}already there: every file is whole and from this very rendering"));
                });
                self.write_legend(shot)?;
                return self.tell(&Report { resumed: true, number: shot.number, ..report });
            }
        }
        let mut once = |words: String| {
            if !told.contains(&words) {
                bar.aside(|| say(format_args!("{words}")));
                told.insert(words);
            }
        };
        once(format!("rendering on {} ({})", renderer.adapter(), renderer.driver()));
        let mut frame = self.frames(renderer, scene, settings, &targets)?;
        frame.report.number = shot.number;
        if settings.tolerance.is_some() && settings.accuracy == Accuracy::Auto {
            once(frame.report.reason.clone());
        }
        frame.report.warnings.iter().for_each(|warning| once(format!("warning: {warning}")));
        if !targets.is_empty() {
            write(&frame, &targets, &origin(scene, settings, &frame.report, frame.window))?;
        }
        self.write_legend(shot)?;
        if let Some(preview) = self.preview {
            preview.show(&frame);
        }
        self.tell(&frame.report)?;
        renderer.recycle(frame);
        Ok(())
    }

    /// The last of the frames, its report telling the times of all, and what its files cannot hold.
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

    fn write_legend(&self, shot: &Numbered) -> Result<()> {
        match (legend::file(&self.asked, shot.number)?, &shot.legend) {
            (Some(path), Some(legend)) => legend::write(legend, &path),
            _ => Ok(()),
        }
    }

    /// Prints the report, if it is asked for.
    fn tell(&self, report: &Report) -> Result<()> {
        if !self.json {
            return Ok(());
        }
        let text = serde_json::to_string(report).map_err(|e| Error::write("-", e.into()))?;
        print(&format!("{text}\n"))
    }

    /// The opened file and its first scene.
    fn first(&self) -> Result<(Shots<'_>, Option<Numbered>)> {
        let mut shots = Shots::open(&self.asked)?;
        let first = self.ready(&mut shots)?;
        Ok((shots, first))
    }

    /// The next scene, if it can be rendered and every file of it can be written.
    fn ready(&self, shots: &mut Shots<'_>) -> Result<Option<Numbered>> {
        let Some(shot) = shots.next_shot()? else { return Ok(None) };
        let targets = self.asked.files.targets(shot.number)?;
        let legend = legend::file(&self.asked, shot.number)?;
        check_inputs(targets.iter().map(Target::path).chain(legend.as_deref()), &shots.inputs())?;
        targets.iter().try_for_each(Target::check)?;
        shot.scene.check()?;
        Ok(Some(shot))
    }

    /// What goes into the files of the first picture; one place for what does not go together.
    fn check(&self) -> Result<Vec<Target>> {
        let targets = self.asked.files.targets(1)?;
        if self.asked.is_many() {
            self.asked.files.check_many()?;
        }
        legend::check(&self.asked)?;
        self.asked.check_outputs()?;
        if targets.is_empty() && !self.json && self.preview.is_none() {
            let problem = "nothing is asked for";
            return Err(Error::settings(problem, "name a picture with -o, a buffer with --aov, or --json"));
        }
        let standard = targets.iter().filter(|target| target.is_standard()).count();
        if standard + usize::from(self.json) + usize::from(self.progress == Talk::Openjd) > 1 {
            let problem = "standard output takes one thing, a picture, a buffer, the JSON or the lines of openjd";
            return Err(Error::settings(problem, "name files for the others"));
        }
        Ok(targets)
    }
}

fn write(frame: &Frame, targets: &[Target], origin: &Origin<'_>) -> Result<()> {
    targets.par_iter().try_for_each(|target| target.write_while(frame, origin, &go_on))
}
