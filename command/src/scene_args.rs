//! The options that `render` and `plan` share: the scene, the camera, the image and its buffers, and the accuracy.

use super::camera_args::CameraArgs;
use super::camera_list::list_in;
use super::clash::{check_inputs, check_numbered, place};
use super::cut_args::CutArgs;
use super::figure_args::FigureArgs;
use super::file_args::FileArgs;
use super::inset_args::InsetArgs;
use super::light_args::{LightArgs, LookRequest};
use super::names::number_in;
use super::picture_scene::PictureScene;
use super::picture_size::PictureSize;
use super::read_args::{ColorArgs, ReadArgs};
use super::typed::Typed;
use super::values::{at_least_one, positive, wholes};
use clap::Args;
use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::frame::tone::{Tone, Toning};
use halfline::intersect::Method;
use halfline::quote::setting::{CUT, LEAST_SIZE, SIZE};
use halfline::render::stream::PartView;
use halfline::scene::{MAX_SIDE, Scene};
use halfline::settings::{Accuracy, Backend, FileLook, Outline, Settings, Tolerance};
use halfline::shade::Shade;
use halfline::window::Window;
use halfline_files::parts;
use halfline_files::read::{Hold, Sequence, read_once};
use halfline_files::write::file::{Target, is_standard_output};
use halfline_files::write::format::Dpi;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The options of `render` and `plan`, in the groups of their help.
#[derive(Debug, Args)]
pub(super) struct SceneArgs {
    /// All options that are given.
    #[command(flatten)]
    pub(super) typed: Typed,
    /// The scene or particle file, in one of the formats of --format, also compressed (.gz, .bz2, .xz or .zst); - for standard
    /// input.
    #[arg(required_unless_present = "visible")]
    scene: Option<PathBuf>,
    /// In place of a scene: files of halfline sift, the parts of one scene in any order. The result is the picture of
    /// all spheres of all parts, bit for bit; the parts give camera, size, window and samples.
    #[arg(long, value_name = "PART", num_args = 1.., conflicts_with = "scene", help_heading = "Input")]
    pub(super) visible: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) read: ReadArgs,
    /// Leaves out rows of tables, PTS, XYZ, LAMMPS dump, PLY, PCD, LAS, NPY and NPZ whose coordinates are not finite numbers or
    /// whose radius is not positive, and counts them; otherwise the first one is an error.
    #[arg(long, help_heading = "Input")]
    pub(super) skip_invalid: bool,
    #[command(flatten)]
    pub(super) color: ColorArgs,
    #[command(flatten)]
    pub(super) cut: CutArgs,
    #[command(flatten)]
    pub(super) camera: CameraArgs,
    #[command(flatten)]
    pub(super) image: ImageArgs,
    #[command(flatten)]
    pub(super) insets: InsetArgs,
    #[command(flatten)]
    pub(super) light: LightArgs,
    #[command(flatten)]
    pub(super) accuracy: AccuracyArgs,
    #[command(flatten)]
    pub(super) files: FileArgs,
    #[command(flatten)]
    pub(super) figure: FigureArgs,
}

/// The image options.
#[derive(Debug, Args)]
#[command(next_help_heading = "Image")]
pub(super) struct ImageArgs {
    /// Image size in pixels [default: the scene file's, else 512x512], or on paper, such as 85x60mm at --dpi (300 if not given).
    /// Wxauto, or 85mm alone, takes the height that the framed spheres fill. With a vfov the width of the view follows; a
    /// viewport keeps its size.
    #[arg(long, value_name = "WxH", value_parser = PictureSize::from_str)]
    size: Option<PictureSize>,
    /// Samples per pixel for anti-aliasing of colour and alpha, rounded up to a square number. Other buffers use the
    /// pixel's centre [default: the scene file's, else 1, and 4 in the look soft].
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    samples: Option<NonZeroU32>,
    /// Seed of the sample positions.
    #[arg(long, value_name = "S", default_value = "0")]
    seed: u32,
    /// Multiplies the light of pictures in 8 and 16 bits by 2 to this power. Linear files (.exr, .npy, .npz, .pfm, .raw) keep
    /// the light as it is.
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = stops, allow_negative_numbers = true)]
    exposure: f64,
    /// Light beyond 1 in pictures in 8 and 16 bits: linear (cut off), soft (the colour becomes whiter, so that shapes stay
    /// visible) [default: soft where lights or a sky light the picture, else linear].
    #[arg(long, value_name = "T")]
    tone: Option<Tone>,
    /// Enlarges spheres that would be less than so many pixels wide, in pictures and all buffers.
    #[arg(long, value_name = "PIXELS", value_parser = pixels, allow_negative_numbers = true)]
    pub(super) least_size: Option<f64>,
    /// Renders only columns X0 to X1 and rows Y0 to Y1, counted from 0 at the top left, ends excluded.
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = crop)]
    crop: Option<Window>,
    /// Renders only tile I of N equal ones, counted from 1 row by row; see halfline merge.
    #[arg(long, value_name = "I/N", value_parser = tile, conflicts_with = "crop")]
    tile: Option<(u32, u32)>,
    /// Shading: flat (the sphere's colour), normal (as a colour), headlight (lights, or a light at the eye in a scene
    /// without any). A picture of particles then has the look plain [default: headlight; see --look].
    // After the lights, to which it belongs.
    #[arg(long, help_heading = "Light", display_order = 1000, value_name = "S")]
    shade: Option<Shade>,
}

/// The options for accuracy and speed.
#[derive(Debug, Args)]
#[command(next_help_heading = "Accuracy and speed")]
pub(super) struct AccuracyArgs {
    #[command(flatten)]
    pub(super) compute: ComputeArgs,
    /// Allowed error of distances (relative) and outlines (in radii), at least 2^-50. Certified answers stay within it
    /// (1e-5 if not given); with accuracy auto, the cheapest method that does is used.
    #[arg(long, value_name = "X", value_parser = tolerance, allow_negative_numbers = true)]
    tolerance: Option<Tolerance>,
}

/// The options for the method and the device that compute answers.
#[derive(Debug, Args)]
#[command(next_help_heading = "Accuracy and speed")]
pub(super) struct ComputeArgs {
    /// Accuracy of the answers: auto, fast, certified, exact [default: auto].
    #[arg(long, value_name = "A")]
    accuracy: Option<Accuracy>,
    /// Uses one intersection method, uncertified: textbook, unit, geometric, stable, f64, double-float.
    #[arg(long, value_name = "M")]
    method: Option<Method>,
    /// Backend to compute on: auto, gpu, cpu.
    #[arg(long, value_name = "B", default_value = "auto")]
    pub(super) backend: Backend,
    /// Adapter, by index or part of its name (see halfline adapters).
    #[arg(long, value_name = "NAME|INDEX")]
    adapter: Option<String>,
}

impl ComputeArgs {
    /// The settings of these options.
    pub(super) fn settings(&self) -> Settings {
        Settings {
            backend: self.backend,
            adapter: self.adapter.clone(),
            method: self.method,
            accuracy: self.accuracy.unwrap_or_default(),
            ..Settings::default()
        }
    }
}

impl SceneArgs {
    /// The name of the scene file, without its folder.
    pub(super) fn file_name(&self) -> String {
        let path = self.path();
        path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
    }

    /// The scene file, or the first of the parts in its place.
    pub(super) fn path(&self) -> &Path {
        self.scene.as_ref().or(self.visible.first()).map_or(Path::new("-"), PathBuf::as_path)
    }

    /// The inputs that choose the look of a picture: `file`, `--samples` and `--shade`. `has_picture` says whether its
    /// colour is computed.
    pub(super) fn look_request(&self, file: FileLook, has_picture: bool) -> LookRequest {
        let Self { image, .. } = self;
        LookRequest { file, has_picture, is_figure: self.is_figure(), samples: image.samples(), shade: image.shade }
    }

    /// Whether the picture is a figure without pixels.
    pub(super) fn is_figure(&self) -> bool {
        self.files.figure().is_some()
    }

    /// Whether several pictures are rendered.
    pub(super) fn is_many(&self) -> bool {
        self.expected() > 1
    }

    /// The number of frames of the file; `None` where they cannot be counted.
    pub(super) fn frames_of_file(&self) -> Option<u64> {
        let path = self.scene.as_deref().filter(|path| read_once(path).is_none())?;
        let mut sequence = Sequence::open(path, &self.read.quiet_options()).ok()?;
        while sequence.pass().ok()? {}
        Some(sequence.passed())
    }

    /// The number of pictures by the arguments alone: the selected frames, the turns, or one. The file may have fewer frames.
    pub(super) fn expected(&self) -> u32 {
        match (&self.read.frames, self.camera.turns()) {
            (Some(frames), _) => frames.count().try_into().unwrap_or(u32::MAX),
            (None, turns) => turns.unwrap_or(1),
        }
    }

    /// The file `cameras.json` that --cameras writes: in the folder of the first file.
    pub(super) fn camera_list(&self) -> Result<Option<PathBuf>> {
        let names = self.files.names()?;
        let first = names.iter().find(|name| !is_standard_output(name)).filter(|_| self.camera.list.file.is_some());
        Ok(first.map(|name| list_in(name.parent().unwrap_or(Path::new("")))))
    }

    /// The numbers that go into names, by the arguments alone; only the first of very many.
    fn numbers(&self) -> Vec<u64> {
        const MANY: usize = 1 << 16;
        match (&self.read.frames, self.camera.turns()) {
            (Some(frames), _) => frames.numbers().take(MANY).collect(),
            (None, turns) => (1..=u64::from(turns.unwrap_or(1))).take(MANY).collect(),
        }
    }

    /// Returns an error for outputs that are one file, or the scene file or its topology. `SceneFrames::inputs` gives the other files that
    /// are read.
    pub(super) fn check_outputs(&self) -> Result<()> {
        let mut names = self.files.names()?;
        names.extend(self.color.legend.as_deref());
        names.retain(|name| !is_standard_output(name));
        let numbers = self.numbers();
        check_numbered(&names, numbers.iter().copied())?;
        let inputs: Vec<PathBuf> = self
            .scene
            .iter()
            .chain(&self.visible)
            .chain(&self.read.topology)
            .chain(&self.read.add)
            .cloned()
            .chain(self.color.map_file())
            .collect();
        for input in &inputs {
            let file = place(input);
            // By a later frame of a numbered pattern.
            let over = |name: &&Path| number_in(&place(name), &file).is_some_and(|number| numbers.contains(&number));
            if names.iter().any(over) {
                check_inputs([input.as_path()], std::slice::from_ref(input))?;
            }
        }
        check_inputs(names, &inputs)
    }

    /// Columns and rows, where both are given.
    pub(super) fn size(&self) -> Option<(u32, u32)> {
        let (width, height) = self.pixels()?;
        Some((width, height?))
    }

    /// The columns of a picture whose rows are those that the framed spheres fill.
    pub(super) fn open_width(&self) -> Option<u32> {
        self.pixels().filter(|(_, height)| height.is_none()).map(|(width, _)| width)
    }

    /// Whether the columns are given.
    pub(super) fn is_sized(&self) -> bool {
        self.image.size.is_some()
    }

    fn pixels(&self) -> Option<(u32, Option<u32>)> {
        Some(self.image.size?.pixels(self.dpi().unwrap_or(Dpi::OF_PRINT)))
    }

    /// The resolution of pictures; for a size on paper it has a default.
    pub(super) fn dpi(&self) -> Option<Dpi> {
        self.files.dpi.or(self.image.size.filter(|size| size.is_printed()).map(|_| Dpi::OF_PRINT))
    }

    /// The files of picture `number`, each with its buffers.
    pub(super) fn targets(&self, number: u64) -> Result<Vec<Target>> {
        self.files.targets(number, self.dpi())
    }

    /// Returns an error for paper of too many pixels, and for an open height where the options do not frame the spheres that give it.
    ///
    /// # Errors
    /// [`Error::Settings`] with the pixels, or with the option that gives the camera.
    pub(super) fn check_picture_size(&self) -> Result<()> {
        let Some((width, height)) = self.pixels() else { return Ok(()) };
        let longest = width.max(height.unwrap_or(1));
        if i64::from(longest) > MAX_SIDE {
            let problem = format!("{SIZE}: a side of {longest} pixels is longer than {MAX_SIDE}");
            return Err(Error::settings(problem, "use a smaller size, or a lower --dpi"));
        }
        if height.is_some() {
            return Ok(());
        }
        let given = [
            (self.camera.from.is_some(), "--camera-from"),
            (self.camera.list.file.is_some(), "--cameras"),
            (!self.visible.is_empty(), "--visible"),
            (self.read.hold == Hold::All, "--hold all"),
        ];
        match given.into_iter().find(|(is_given, _)| *is_given) {
            Some((_, by)) => {
                let problem = format!("{SIZE}: with {by} the camera is known before the height that its spheres fill");
                Err(Error::settings(problem, "give a height too, such as 1200x800"))
            }
            None => Ok(()),
        }
    }

    /// The selected window of the scene's image.
    pub(super) fn window(&self, scene: &Scene) -> Result<Option<Window>> {
        let image = &scene.image;
        let tile = self.image.tile.map(|(number, count)| Window::tile(number, count, image.width, image.height));
        Ok(tile.transpose()?.or(self.image.crop))
    }

    /// Checks that a size is the size of the parts, unless it is a preference, and that their spheres keep theirs.
    ///
    /// # Errors
    /// [`Error::Settings`] with both sizes, and for a least size.
    pub(super) fn check_size(&self, view: &PartView) -> Result<()> {
        if self.image.least_size.is_some() {
            let problem = format!("{LEAST_SIZE}: in parts, spheres hide others at their own size");
            return Err(Error::settings(problem, "remove it"));
        }
        if self.cut.is_given() {
            let problem = format!("{CUT}: the parts give the planes");
            return Err(Error::settings(problem, format!("give every part the same planes, and remove {CUT} here")));
        }
        let [w, h] = view.size;
        match self.size().filter(|_| self.typed.has("size")) {
            Some((width, height)) if [width, height] != view.size => {
                let problem = format!("--size {width}x{height}: the parts are of a frame of {w}x{h}");
                Err(Error::settings(problem, "remove --size, or sift again"))
            }
            _ => Ok(()),
        }
    }

    /// The settings for one picture, whose frame is written to these files.
    pub(super) fn settings_for(
        &self,
        picture: &PictureScene,
        settings: &Settings,
        targets: &[Target],
    ) -> Result<Settings> {
        let scene = &picture.scene;
        let window = self.window(scene)?;
        let size = window.map_or([scene.image.width, scene.image.height], |window| {
            [window.x1.saturating_sub(window.x0), window.y1.saturating_sub(window.y0)]
        });
        targets.iter().try_for_each(|target| target.check_size(size))?;
        let reserve =
            targets.iter().map(|target| target.memory(size, scene.lighting.lights.len())).fold(0, u64::saturating_add);
        let own = Settings { window, reserve, ..picture.look.settings(settings) };
        let Some(view) = &picture.part_view else { return Ok(own) };
        let width = self.light.width_or(view.outline);
        Ok(Settings {
            window: Some(view.window),
            seed: if self.typed.has("seed") { own.seed } else { view.seed },
            tolerance: if self.typed.has("tolerance") { own.tolerance } else { parts::tolerance(view)? },
            outline: Outline { width, ..own.outline },
            ..own
        })
    }

    /// The settings for these files, without those that depend on the scene.
    pub(super) fn settings(&self, targets: &[Target]) -> Settings {
        self.settings_of(targets.iter().flat_map(Target::aovs).copied().collect())
    }

    /// The settings for these buffers, without those that depend on the scene.
    pub(super) fn settings_of(&self, aovs: Vec<Aov>) -> Settings {
        self.light.drawn(Settings {
            tolerance: self.accuracy.tolerance,
            aovs,
            seed: self.image.seed,
            coverage: !self.files.cryptomatte.is_empty(),
            tone: self.image.tone,
            exposure: self.image.exposure,
            ..self.accuracy.compute.settings()
        })
    }
}

impl ImageArgs {
    /// The samples per pixel, if they are given.
    pub(super) fn samples(&self) -> Option<u32> {
        self.samples.map(NonZeroU32::get)
    }

    /// Whether only a part of the picture is rendered.
    pub(super) fn is_part(&self) -> bool {
        self.crop.is_some() || self.tile.is_some()
    }
}

fn crop(text: &str) -> Result<Window, String> {
    let [x0, y0, x1, y1] = wholes(text).ok_or("expected four whole numbers X0,Y0,X1,Y1, such as 0,0,640,360")?;
    Ok(Window { x0, y0, x1, y1 })
}

fn tile(text: &str) -> Result<(u32, u32), String> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    numbers.ok_or_else(|| "expected I/N, such as 3/16".into())
}

/// The most pixels of a least size.
const MOST_PIXELS: f64 = 10_000.0;

fn pixels(text: &str) -> Result<f64, String> {
    let pixels = positive("number")(text)?;
    if pixels <= MOST_PIXELS { Ok(pixels) } else { Err(format!("expected at most {MOST_PIXELS} pixels")) }
}

fn stops(text: &str) -> Result<f64, String> {
    let stops = text.parse().ok().and_then(|stops| Toning::check_stops(stops).ok());
    stops.ok_or_else(|| format!("expected a number of stops from -{0} to {0}, such as 0.5", Toning::MOST_STOPS))
}

pub(super) fn tolerance(text: &str) -> Result<Tolerance, String> {
    let number = text.parse().map_err(|_| "expected a number".to_owned())?;
    Tolerance::new(number).map_err(|e| e.to_string())
}
