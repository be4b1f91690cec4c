//! `halfline render SCENE`.

use super::{go_on, say};
use clap::Args;
use glam::DVec3;
use halfline::camera::{Lens, Look};
use halfline::error::{Error, Result};
use halfline::frame::file::Target;
use halfline::frame::{Aov, Frame};
use halfline::intersect::Method;
use halfline::plan::{Accuracy, Backend, Settings, Tolerance};
use halfline::render::Renderer;
use halfline::scene::{ReadOptions, Scene};
use halfline::shade::Shade;
use std::io::Write;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
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
    /// The scene: .toml, .nff, or - for standard input.
    scene: PathBuf,
    /// The picture: .png, .npy for linear RGB, or - for a PNG on standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// A buffer beside the picture: color, distance, depth, normal, position, id, mask, certainty, bound.
    #[arg(long, value_name = "NAME=FILE", value_parser = aov)]
    aov: Vec<(Aov, PathBuf)>,
    /// Image size in pixels; a given viewport keeps its shape, a vfov its height.
    #[arg(long, value_name = "WxH", value_parser = scene_size)]
    size: Option<(u32, u32)>,
    /// One form of the quadratic and nothing else, uncertified: textbook, unit, geometric, stable, f64,
    /// double-float.
    #[arg(long, value_name = "M")]
    method: Option<Method>,
    /// How sure the answers must be: auto, fast, certified, exact.
    #[arg(long, value_name = "A", default_value = "auto")]
    accuracy: Accuracy,
    /// Promised relative error of the distance where answers are certified; at least 2^-50.
    #[arg(long, value_name = "X", default_value = "1e-5", value_parser = tolerance, allow_negative_numbers = true)]
    tolerance: Tolerance,
    /// How a hit becomes a colour: flat, normal, headlight.
    #[arg(long, value_name = "S", default_value = "headlight")]
    shade: Shade,
    /// Where to compute: auto, gpu, cpu.
    #[arg(long, value_name = "B", default_value = "auto")]
    backend: Backend,
    /// Which adapter, by index or part of its name (halfline adapters lists them).
    #[arg(long, value_name = "NAME|INDEX")]
    adapter: Option<String>,
    #[command(flatten)]
    camera: CameraArgs,
    /// Refuses a scene with anything but spheres in it.
    #[arg(long)]
    strict: bool,
    /// Renders N times in one process, for measuring.
    #[arg(long, value_name = "N", default_value = "1")]
    repeat: NonZeroU32,
    /// Prints one JSON object about the rendering on standard output.
    #[arg(long)]
    json: bool,
}

/// What replaces parts of the scene's camera.
#[derive(Debug, Args)]
struct CameraArgs {
    /// The eye.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    eye: Option<DVec3>,
    /// The point it looks at.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, conflicts_with = "view")]
    at: Option<DVec3>,
    /// The direction it looks in.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    view: Option<DVec3>,
    /// Up in the scene.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    up: Option<DVec3>,
    /// Full height of the view, degrees.
    #[arg(long, value_name = "DEG", value_parser = angle, allow_hyphen_values = true)]
    vfov: Option<f64>,
}

impl Render {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        let targets = self.targets()?;
        let mut scene = Scene::read(&self.scene, &ReadOptions { strict: self.strict })?;
        self.camera.apply(&mut scene);
        if let Some((width, height)) = self.size {
            (scene.image.width, scene.image.height) = (width, height);
        }
        for target in &targets {
            target.check()?;
        }
        let settings = Settings {
            backend: self.backend,
            adapter: self.adapter.clone(),
            method: self.method,
            accuracy: self.accuracy,
            shade: self.shade,
            tolerance: self.tolerance,
            aovs: targets.iter().map(Target::aov).collect(),
        };
        // A camera that cannot see is the scene's fault, whatever adapters there are.
        scene.check()?;
        let mut renderer = Renderer::new(&settings)?.cancelled_by(go_on);
        if self.backend == Backend::Auto && !renderer.is_gpu() {
            say(format_args!("no Vulkan, Metal or DX12 adapter was found: falling back to the CPU path"));
        }
        say(format_args!("rendering on {} ({})", renderer.adapter(), renderer.driver()));
        let mut frame = renderer.render(&scene, &settings)?;
        let mut times = frame.report.frame_ms.clone();
        let mut kernels = frame.report.kernel_ms.clone();
        for _ in 1..self.repeat.get() {
            drop(std::mem::take(&mut frame.buffers));
            frame = renderer.render(&scene, &settings)?;
            times.extend(&frame.report.frame_ms);
            kernels.extend(&frame.report.kernel_ms);
        }
        (frame.report.frame_ms, frame.report.kernel_ms) = (times, kernels);
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

    /// Every file to be written; one place for what does not go together.
    fn targets(&self) -> Result<Vec<Target>> {
        let picture = self.output.iter().map(|path| (Aov::Color, path));
        let beside = self.aov.iter().map(|(aov, path)| (*aov, path));
        let targets: Vec<_> = picture.chain(beside).map(|(aov, path)| Target::new(aov, path)).collect::<Result<_>>()?;
        if targets.is_empty() && !self.json {
            let problem = "nothing is asked for";
            return Err(Error::settings(problem, "name a picture with -o, a buffer with --aov, or --json"));
        }
        let standard = targets.iter().filter(|target| target.is_standard()).count();
        if standard + usize::from(self.json) > 1 {
            let problem = "standard output takes one thing, a picture, a buffer or the JSON";
            return Err(Error::settings(problem, "name files for the others"));
        }
        for (n, target) in targets.iter().enumerate() {
            if !target.is_standard() && targets[..n].iter().any(|other| place(other.path()) == place(target.path())) {
                let problem = format!("{} would be written twice", target.path().display());
                return Err(Error::settings(problem, "name a file of its own for each buffer"));
            }
        }
        Ok(targets)
    }
}

impl CameraArgs {
    fn apply(&self, scene: &mut Scene) {
        let camera = &mut scene.camera;
        camera.eye = self.eye.unwrap_or(camera.eye);
        camera.up = self.up.unwrap_or(camera.up);
        camera.look = self.at.map(Look::At).or(self.view.map(Look::View)).unwrap_or(camera.look);
        if let Some(degrees) = self.vfov {
            let distance = match camera.lens {
                Lens::Viewport { distance, .. } | Lens::Vfov { distance, .. } => distance,
                Lens::RowCentres { .. } => 1.0,
            };
            camera.lens = Lens::Vfov { degrees, distance };
        }
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
    for target in targets {
        if !go_on() {
            return Err(Error::Interrupted);
        }
        if let Some(buffer) = frame.get(target.aov()) {
            target.write(buffer, &provenance)?;
        }
    }
    Ok(())
}

/// Where a file lies or will lie, the same however its name is written.
fn place(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let new = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
    path.canonicalize().ok().or_else(new).unwrap_or_else(|| path.to_path_buf())
}

fn aov(text: &str) -> Result<(Aov, PathBuf), String> {
    let (name, file) = text.split_once('=').ok_or("write NAME=FILE, such as id=id.npy")?;
    if file.is_empty() {
        return Err("a file name is missing after '='".into());
    }
    Ok((name.parse().map_err(|e: Error| e.to_string())?, Path::new(file).to_path_buf()))
}

pub(super) fn scene_size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let sides = sides.ok_or("write WxH, such as 1920x1080")?;
    halfline::scene::check_size(sides, || "--size".into()).map_err(|e| match e {
        // The option is named already.
        Error::Scene { problem, mend, .. } => format!("{problem}; {mend}"),
        other => other.to_string(),
    })
}

fn vector(text: &str) -> Result<DVec3, String> {
    let numbers: Vec<f64> = text.split(',').map(|x| x.trim().parse().ok()).collect::<Option<_>>().unwrap_or_default();
    match <[f64; 3]>::try_from(numbers) {
        Ok(v) if v.iter().all(|x| x.is_finite()) => Ok(v.into()),
        _ => Err("write three finite numbers, such as 1,-2,3.5".into()),
    }
}

pub(super) fn tolerance(text: &str) -> Result<Tolerance, String> {
    let number = text.parse().map_err(|_| "a tolerance is a number".to_owned())?;
    Tolerance::new(number).map_err(|e| e.to_string())
}

fn angle(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && x < 180.0 => Ok(x),
        _ => Err("an angle lies between 0 and 180 degrees".into()),
    }
}
