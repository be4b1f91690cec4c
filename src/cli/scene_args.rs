//! What `render` and `plan` share: the scene, the camera, the buffers and how sure they must be.

use super::clash::{check_inputs, check_numbered, place};
use super::file_args::FileArgs;
use super::read_args::{ReadArgs, numbers};
use super::shots::{Shots, number_in};
use clap::Args;
use glam::DVec3;
use halfline::camera::{Lens, Look};
use halfline::error::{Error, Result};
use halfline::frame::file::{Target, is_standard_output};
use halfline::intersect::Method;
use halfline::scene::{Framing, Scene};
use halfline::settings::{Accuracy, Backend, Search, Settings, Tolerance};
use halfline::shade::Shade;
use halfline::window::Window;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

/// A scene and what is asked of it.
#[derive(Debug, Args)]
pub(super) struct SceneArgs {
    /// The scene or the particles: toml, nff, xyz, pdb, cif, gro, LAMMPS dump or data, ply, csv, npy, npz, each also
    /// compressed (gz, bz2); - for standard input.
    pub(super) scene: PathBuf,
    #[command(flatten)]
    pub(super) files: FileArgs,
    /// Image size in pixels; a given viewport keeps its shape, a vfov its height.
    #[arg(long, value_name = "WxH", value_parser = scene_size)]
    pub(super) size: Option<(u32, u32)>,
    /// Anti-aliasing: colour and alpha are the means of so many samples of each pixel, rounded up to the next square;
    /// everything else stays the answer of the pixel's centre.
    #[arg(long, value_name = "N", default_value = "1")]
    samples: NonZeroU32,
    /// Chooses where in their pixels samples lie.
    #[arg(long, value_name = "S", default_value = "0")]
    seed: u32,
    /// Renders only columns x0 to x1 and rows y0 to y1 of the image, the ends excluded, bit for bit as the whole has
    /// them.
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = crop)]
    crop: Option<Window>,
    /// Renders only tile I, from 1, of N equal ones: bands of rows cut into columns, row by row.
    #[arg(long, value_name = "I/N", value_parser = tile, conflicts_with = "crop")]
    tile: Option<(u32, u32)>,
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
    pub(super) camera: CameraArgs,
    #[command(flatten)]
    pub(super) read: ReadArgs,
}

/// What replaces parts of the scene's camera.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(super) struct CameraArgs {
    /// The eye.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(super) eye: Option<DVec3>,
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
    /// Parallel rays: full height of the view in the scene's unit, or as high as all spheres need. Its answers are always
    /// certified or exact.
    #[arg(long, value_name = "HEIGHT", value_parser = height, num_args = 0..=1, allow_negative_numbers = true,
        conflicts_with = "vfov")]
    ortho: Option<Option<f64>>,
    /// Moves the eye so that all spheres are seen whole, as near as that allows; a file without a camera is framed so anyway.
    #[arg(long, conflicts_with = "eye")]
    pub(super) fit: bool,
    /// N pictures from all sides, around up: the first from where the camera stands. Of the frames of a sequence, each is
    /// turned by its number.
    #[arg(long, value_name = "N")]
    pub(super) spin: Option<NonZeroU32>,
}

impl SceneArgs {
    /// The scene as the options change it; of several, the first.
    pub(super) fn scene(&self) -> Result<Scene> {
        let first = Shots::open(self)?.next_shot()?;
        first.map(|shot| shot.scene).ok_or_else(|| Error::settings("there is no scene", "ask for other --frames"))
    }

    /// Whether several pictures are asked for.
    pub(super) fn is_many(&self) -> bool {
        self.expected() > 1
    }

    /// How many pictures are asked for, as far as is known before the file is read.
    pub(super) fn expected(&self) -> u32 {
        match (self.read.frames(), self.camera.spin) {
            (Some(frames), _) => frames.count().try_into().unwrap_or(u32::MAX),
            (None, turns) => turns.map_or(1, NonZeroU32::get),
        }
    }

    /// The numbers that go into names, as far as is known before the file is read; the first of very many.
    fn numbers(&self) -> Vec<u64> {
        const MANY: usize = 1 << 16;
        match (self.read.frames(), self.camera.spin) {
            (Some(frames), _) => frames.numbers().take(MANY).collect(),
            (None, turns) => (1..=turns.map_or(1, |turns| u64::from(turns.get()))).take(MANY).collect(),
        }
    }

    /// Refuses outputs that are one file, or the scene file. `Shots::inputs` knows the other files that are read.
    pub(super) fn check_outputs(&self) -> Result<()> {
        let mut names = self.files.names()?;
        names.extend(self.read.legend.as_deref());
        names.retain(|name| !is_standard_output(name));
        let numbers = self.numbers();
        check_numbered(&names, numbers.iter().copied())?;
        let scene = place(&self.scene);
        let over = |name: &&&Path| number_in(&place(name), &scene).is_some_and(|number| numbers.contains(&number));
        match names.iter().find(over) {
            Some(_) => check_inputs([self.scene.as_path()], std::slice::from_ref(&self.scene)),
            None => check_inputs(names, std::slice::from_ref(&self.scene)),
        }
    }

    /// Which part of the scene's image is asked for.
    pub(super) fn window(&self, scene: &Scene) -> Result<Option<Window>> {
        let image = &scene.image;
        let tile = self.tile.map(|(number, count)| Window::tile(number, count, image.width, image.height));
        Ok(tile.transpose()?.or(self.crop))
    }

    /// The same settings for one scene, whose frame goes into these files.
    pub(super) fn settings_for(&self, scene: &Scene, settings: &Settings, targets: &[Target]) -> Result<Settings> {
        let window = self.window(scene)?;
        let columns = window.map_or(scene.image.width, |window| window.x1.saturating_sub(window.x0));
        let reserve = targets.iter().map(|target| target.memory(columns)).fold(0, u64::saturating_add);
        Ok(Settings { window, reserve, ..settings.clone() })
    }

    /// The options besides the scene and what is asked of its image, for these buffers.
    pub(super) fn settings(&self, targets: &[Target]) -> Settings {
        Settings {
            backend: self.backend,
            adapter: self.adapter.clone(),
            method: self.method,
            accuracy: self.accuracy,
            search: self.search,
            shade: self.shade,
            tolerance: self.tolerance,
            aovs: targets.iter().flat_map(Target::aovs).copied().collect(),
            samples: self.samples.get(),
            seed: self.seed,
            window: None,
            reserve: 0,
        }
    }
}

impl CameraArgs {
    /// How the scene is framed, if it is; a file without a camera always is, unless the eye is given.
    pub(super) fn framing(&self, has_camera: bool) -> Result<Option<Framing>> {
        let keep_height = !matches!(self.ortho, None | Some(None));
        if self.eye.is_some() {
            return match self.ortho {
                Some(None) => {
                    Err(Error::settings("an eye is given, and no height of the view", "give --ortho a height"))
                }
                _ => Ok(None),
            };
        }
        let framed = self.fit || self.ortho == Some(None) || !has_camera;
        Ok(framed.then(|| Framing { ball: self.spin.is_some(), keep_height, ..Framing::default() }))
    }

    /// Whether an up is given.
    pub(super) fn has_up(&self) -> bool {
        self.up.is_some()
    }

    /// Whether a direction is given.
    pub(super) fn looks(&self) -> bool {
        self.at.is_some() || self.view.is_some()
    }

    pub(super) fn apply(&self, scene: &mut Scene) {
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
            camera.lens = Lens::Orthographic { height: height.unwrap_or(1.0) };
        }
    }
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

fn crop(text: &str) -> Result<Window, String> {
    let sides: Option<Vec<u32>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    match sides.as_deref() {
        Some(&[x0, y0, x1, y1]) => Ok(Window { x0, y0, x1, y1 }),
        _ => Err("write X0,Y0,X1,Y1, four whole numbers such as 0,0,640,360".into()),
    }
}

fn tile(text: &str) -> Result<(u32, u32), String> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    numbers.ok_or_else(|| "write I/N, such as 3/16".into())
}

fn vector(text: &str) -> Result<DVec3, String> {
    numbers(text).map(DVec3::from_array).ok_or_else(|| "write three finite numbers, such as 1,-2,3.5".into())
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
