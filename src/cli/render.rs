//! `halfline render SCENE`.

use super::bar::Bar;
use super::scene_args::SceneArgs;
use super::{go_on, say};
use clap::Args;
use halfline::error::{Error, Result};
use halfline::frame::Frame;
use halfline::frame::file::Target;
use halfline::plan::{Accuracy, Backend};
use halfline::render::Renderer;
use halfline::scene::Scene;
use rayon::prelude::*;
use std::io::Write;
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
}

impl Render {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        let targets = self.targets()?;
        let mut settings = self.asked.settings(&targets);
        // A device takes its time to open, on another core than the one that reads.
        let (scene, renderer) = std::thread::scope(|scope| {
            let opening = scope.spawn(|| Renderer::new(&settings));
            (self.scene(&targets), opening.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
        });
        // What is wrong with the scene is told first, whatever adapters there are.
        let scene = scene?;
        settings.window = self.asked.window(&scene)?;
        let renderer = renderer?;
        let bar = Bar::new();
        let mut renderer = renderer.watched_by(bar.watch());
        if self.asked.backend == Backend::Auto && !renderer.is_gpu() {
            say(format_args!("no Vulkan, Metal or DX12 adapter was found: falling back to the CPU path"));
        }
        say(format_args!("rendering on {} ({})", renderer.adapter(), renderer.driver()));
        let mut frame = renderer.render(&scene, &settings)?;
        let mut times = frame.report.frame_ms.clone();
        let mut kernels = frame.report.kernel_ms.clone();
        for _ in 1..self.repeat.get() {
            renderer.recycle(frame);
            frame = renderer.render(&scene, &settings)?;
            times.extend(&frame.report.frame_ms);
            kernels.extend(&frame.report.kernel_ms);
        }
        drop(bar);
        (frame.report.frame_ms, frame.report.kernel_ms) = (times, kernels);
        if settings.tolerance.is_some() && settings.accuracy == Accuracy::Auto {
            say(format_args!("{}", frame.report.reason));
        }
        for warning in &frame.report.warnings {
            say(format_args!("warning: {warning}"));
        }
        write(&frame, &targets, &scene)?;
        if self.json {
            let text = serde_json::to_string(&frame.report).map_err(|e| Error::write("-", e.into()))?;
            writeln!(std::io::stdout(), "{text}").map_err(|e| Error::write("-", e))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// The scene, if it can be rendered and every file can be written.
    fn scene(&self, targets: &[Target]) -> Result<Scene> {
        let scene = self.asked.scene()?;
        targets.iter().try_for_each(Target::check)?;
        scene.check()?;
        Ok(scene)
    }

    /// Every file to be written; one place for what does not go together.
    fn targets(&self) -> Result<Vec<Target>> {
        let targets = self.asked.targets()?;
        if targets.is_empty() && !self.json {
            let problem = "nothing is asked for";
            return Err(Error::settings(problem, "name a picture with -o, a buffer with --aov, or --json"));
        }
        let standard = targets.iter().filter(|target| target.is_standard()).count();
        if standard + usize::from(self.json) > 1 {
            let problem = "standard output takes one thing, a picture, a buffer or the JSON";
            return Err(Error::settings(problem, "name files for the others"));
        }
        Ok(targets)
    }
}

fn write(frame: &Frame, targets: &[Target], scene: &Scene) -> Result<()> {
    if targets.is_empty() {
        return Ok(());
    }
    let report = &frame.report;
    let fact = |name: &str, text: &str| (name.to_owned(), text.to_owned());
    let provenance = [
        fact("Software", &format!("halfline {}", report.halfline)),
        fact("halfline:scene", &scene.fingerprint()),
        fact("halfline:adapter", &report.adapter),
        fact("halfline:driver", &report.driver),
        fact("halfline:method", report.method),
        fact("halfline:accuracy", report.accuracy),
    ];
    targets.par_iter().try_for_each(|target| match frame.get(target.aov()) {
        _ if !go_on() => Err(Error::Interrupted),
        Some(buffer) => target.write(buffer, &provenance),
        None => Ok(()),
    })
}
