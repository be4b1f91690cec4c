//! What `render` and `plan` share: the scene, the camera, the buffers and how sure they must be.

use clap::Args;
use glam::DVec3;
use halfline::camera::{Lens, Look};
use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::frame::file::Target;
use halfline::intersect::Method;
use halfline::plan::{Accuracy, Backend, Search, Settings, Tolerance};
use halfline::scene::{ReadOptions, Scene};
use halfline::shade::Shade;
use std::path::{Path, PathBuf};

/// A scene and what is asked of it.
#[derive(Debug, Args)]
pub(super) struct SceneArgs {
    /// The scene: .toml, .nff, or - for standard input.
    scene: PathBuf,
    /// The picture: .png, .npy for linear RGB, or - for a PNG on standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// A buffer beside the picture: color, distance, depth, normal, position, id, mask, certainty, bound,
    /// alpha.
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
    /// The error that is allowed, at least 2^-50: of the distance, relative to it, and of outlines, in radii. Certified
    /// answers promise it (1e-5 if it is left out); with accuracy auto and no method, the cheapest method is taken whose
    /// predicted errors it allows.
    #[arg(long, value_name = "X", value_parser = tolerance, allow_negative_numbers = true)]
    tolerance: Option<Tolerance>,
    /// How candidates are found: auto, all, tiles (tree is for given rays, which only the library
    /// takes).
    #[arg(long, value_name = "S", default_value = "auto")]
    search: Search,
    /// How a hit becomes a colour: flat, normal, headlight.
    #[arg(long, value_name = "S", default_value = "headlight")]
    shade: Shade,
    /// Where to compute: auto, gpu, cpu.
    #[arg(long, value_name = "B", default_value = "auto")]
    pub(super) backend: Backend,
    /// Which adapter, by index or part of its name (halfline adapters lists them).
    #[arg(long, value_name = "NAME|INDEX")]
    adapter: Option<String>,
    #[command(flatten)]
    camera: CameraArgs,
    /// Refuses a scene with anything but spheres in it.
    #[arg(long)]
    strict: bool,
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
    /// Full height of the view, degrees; makes an orthographic camera a perspective one.
    #[arg(long, value_name = "DEG", value_parser = angle, allow_hyphen_values = true)]
    vfov: Option<f64>,
    /// Parallel rays: full height of the view in the scene's unit. Its answers are always certified or exact.
    #[arg(long, value_name = "HEIGHT", value_parser = height, allow_hyphen_values = true, conflicts_with = "vfov")]
    ortho: Option<f64>,
}

impl SceneArgs {
    /// The scene as the options change it.
    pub(super) fn scene(&self) -> Result<Scene> {
        let mut scene = Scene::read(&self.scene, &ReadOptions { strict: self.strict })?;
        self.camera.apply(&mut scene);
        if let Some((width, height)) = self.size {
            (scene.image.width, scene.image.height) = (width, height);
        }
        Ok(scene)
    }

    /// The options besides the scene, for these buffers.
    pub(super) fn settings(&self, targets: &[Target]) -> Settings {
        Settings {
            backend: self.backend,
            adapter: self.adapter.clone(),
            method: self.method,
            accuracy: self.accuracy,
            search: self.search,
            shade: self.shade,
            tolerance: self.tolerance,
            aovs: targets.iter().map(Target::aov).collect(),
        }
    }

    /// Every file that is named, each for one buffer.
    pub(super) fn targets(&self) -> Result<Vec<Target>> {
        let picture = self.output.iter().map(|path| (Aov::Color, path));
        let beside = self.aov.iter().map(|(aov, path)| (*aov, path));
        let targets: Vec<_> = picture.chain(beside).map(|(aov, path)| Target::new(aov, path)).collect::<Result<_>>()?;
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
                Lens::RowCentres { .. } | Lens::Orthographic { .. } => 1.0,
            };
            camera.lens = Lens::Vfov { degrees, distance };
        }
        if let Some(height) = self.ortho {
            camera.lens = Lens::Orthographic { height };
        }
    }
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

fn height(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && f64::is_finite(x) => Ok(x),
        _ => Err("a height is a positive number, in the scene's unit".into()),
    }
}
