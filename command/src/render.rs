//! `halfline render SCENE`.

pub(super) mod picture;
pub(super) mod stream;

use super::adapters::note_fallback;
use super::bar::Bar;
use super::camera_list::WrittenCameras;
use super::clash::{check_one_standard, check_text};
use super::figure;
use super::film::FilmWriter;
use super::legend;
use super::lines::ProgressArgs;
use super::messages::{QuietArgs, note};
use super::picture_scene::PictureScene;
use super::preview::Preview;
use super::process::ExitCode;
use super::scene_args::SceneArgs;
use super::scene_frames::SceneFrames;
use super::signals::{go_on, watch};
use super::standard::print_json;
use super::threads;
use super::together::{SpheresOf, together};
use super::values::at_least_one;
use super::visible;
use clap::Args;
use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::progress::Cancel;
use halfline::render::Renderer;
use halfline::scene::Scene;
use halfline::settings::Settings;
use halfline_files::read::read_once;
use halfline_files::write::file::{Target, is_special};
use picture::{Messages, Picture, PictureWriter, writable_targets};
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

/// Renders a picture of a scene or of particles, and the buffers behind it.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, next_line_help = true)]
pub(crate) struct Render {
    #[command(flatten)]
    pub(super) args: SceneArgs,
    /// Skips files that exist, are complete and come from the same rendering.
    #[arg(long, help_heading = "Output")]
    resume: bool,
    /// Reads the scene in blocks and keeps only the spheres that some ray may hit, so that a file of rows (npy, csv, xyz,
    /// dump, ply, las) may be larger than memory. A file that does not fit is read this way without the option. For
    /// buffers of camera rays, whose bytes stay the same.
    #[arg(long)]
    stream: bool,
    /// Prints one JSON object about the rendering on standard output.
    #[arg(long, help_heading = REPORTING)]
    json: bool,
    #[command(flatten)]
    progress: ProgressArgs,
    /// Shows the picture in a terminal with 24-bit colours; =blocks shows it on any standard error.
    #[arg(long, help_heading = REPORTING, value_name = "blocks", num_args = 0..=1, require_equals = true,
        default_missing_value = "auto")]
    preview: Option<Preview>,
    /// Renders N times in one process, for time measurements.
    #[arg(long, help_heading = REPORTING, value_name = "N", default_value = "1", value_parser = at_least_one)]
    repeat: NonZeroU32,
    #[command(flatten)]
    quiet: QuietArgs,
}

/// The opened file, unless it was a stream, and its first scene.
type First<'a> = (Option<SceneFrames<'a>>, Option<PictureScene>);

/// The heading of the options that report on the rendering.
const REPORTING: &str = "Reporting";

const EXAMPLES: &str = "\
Examples:
  halfline render molecule.pdb -o molecule.png
  halfline render molecule.pdb --color-by chain --background white -o chains.png
  halfline render run.dump --frames 1-100 --color-by vx,vy,vz --range 0,3 -o frame.%04d.png
  halfline render molecule.pdb --spin 100 --background white -o molecule.mp4
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

/// The scenes that are in memory besides the picture that is rendered.
#[derive(Clone, Copy)]
enum Concurrency {
    /// Nothing.
    Alone,
    /// The next scene.
    Next,
    /// So many pictures that are rendered together.
    Pictures(usize),
}

impl Concurrency {
    fn lanes(self) -> usize {
        match self {
            Self::Alone | Self::Next => 1,
            Self::Pictures(lanes) => lanes,
        }
    }
}

/// All pictures of a command: their scenes, the renderers, and the files that are written.
struct Rendering<'a> {
    render: &'a Render,
    cancel: &'a Cancel,
    writer: PictureWriter<'a>,
    concurrency: Concurrency,
    renderers: Vec<Renderer>,
    /// The scenes behind the first.
    frames: Option<SceneFrames<'a>>,
    /// The first picture, until it is rendered.
    first: Option<PictureScene>,
    cameras: WrittenCameras,
}

impl Rendering<'_> {
    /// Renders and writes every picture, and adds it to a film.
    fn run(&mut self, mut film: Option<&mut FilmWriter>) -> Result<()> {
        let Self { render, cancel, writer, concurrency, renderers, frames, first, cameras } = self;
        let mut next = || match first.take() {
            Some(first) => Ok(Some(first)),
            None => frames.as_mut().map_or(Ok(None), |frames| render.ready(frames)),
        };
        let each = |renderer: &mut Renderer, numbered: PictureScene| {
            if !go_on() {
                return Err(Error::Interrupted);
            }
            writer.picture(&numbered, renderer)
        };
        let mut done = |picture: Picture| {
            cameras.add(picture.number, picture.files.iter().map(PathBuf::as_path), picture.report.camera);
            if let (Some(film), Some(still)) = (&mut film, &picture.still) {
                film.add(picture.number, still)?;
            }
            if render.json { print_json(&picture.report) } else { Ok(()) }
        };
        if !matches!(concurrency, Concurrency::Alone) {
            return threads::pipeline(next, std::mem::take(renderers), cancel, each, done);
        }
        while let Some(numbered) = next()? {
            let may_be_stream = render.may_be_stream(&numbered);
            let made = match each(&mut renderers[0], numbered) {
                Err(error) if may_be_stream => {
                    let picture = render.as_stream(error, writer.settings, cancel)?;
                    each(&mut renderers[0], picture)
                }
                made => made,
            };
            done(made?)?;
        }
        Ok(())
    }
}

impl Render {
    pub(crate) fn run(mut self) -> Result<ExitCode> {
        self.quiet.apply();
        self.take_all_frames()?;
        let targets = self.check()?;
        let mut settings = self.args.settings(&targets);
        if self.preview.is_some() && !settings.aovs.contains(&Aov::Color) {
            settings.aovs.push(Aov::Color);
        }
        // Opening a device takes time, so it runs beside the reading of the scene.
        let cancel = Cancel::default();
        let open = || self.first(&settings, &targets, &cancel);
        let (opened, renderer) = threads::both(open, || Renderer::new(&settings));
        // Errors of the scene are reported before errors of the adapter.
        let ((frames, first), renderer) = (opened?, renderer?);
        let bar = Bar::with_output(self.progress.progress, self.repeat.get().saturating_mul(self.args.expected()));
        note_fallback(&renderer);
        let concurrency =
            first.as_ref().map_or(Concurrency::Alone, |first| self.concurrency(first, &targets, renderer.is_gpu()));
        let mut renderers = vec![renderer.watched_by(bar.watch())];
        while renderers.len() < concurrency.lanes() {
            // Progress is shown for the first renderer.
            renderers.push(renderers[0].another().watched_by(watch()));
        }
        let messages = Messages::new(Some(&bar));
        let writer = PictureWriter {
            args: &self.args,
            settings: &settings,
            resume: self.resume,
            in_memory: false,
            repeat: self.repeat,
            preview: self.preview,
            messages: &messages,
        };
        let cameras = WrittenCameras::default();
        let (render, cancel) = (&self, &cancel);
        let mut all = Rendering { render, cancel, writer, concurrency, renderers, frames, first, cameras };
        match self.args.files.film() {
            Some(film) => film.write(|writer| all.run(Some(writer)))?,
            None => all.run(None)?,
        }
        let cameras = all.cameras;
        bar.finish();
        if let Some(list) = self.args.camera_list()? {
            cameras.write(list.parent().unwrap_or(Path::new("")))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Makes a film that no option gives its pictures one of all frames of the file, if it has several.
    ///
    /// # Errors
    /// Errors of `--frames`.
    fn take_all_frames(&mut self) -> Result<()> {
        if self.args.is_many() || self.args.read.frames.is_some() {
            return Ok(());
        }
        let Some(film) = self.args.files.film() else {
            if let (true, Some(frames @ 2..)) = (self.args.files.is_numbered(), self.args.frames_of_file()) {
                note(format_args!("the first of {frames} frames is rendered; --frames 1- renders all"));
            }
            return Ok(());
        };
        let all = match self.args.frames_of_file() {
            Some(0 | 1) => return Ok(()),
            Some(frames) => {
                let film = film.path.display();
                note(format_args!("{film} shows all {frames} frames of the file; --frames A-B takes some"));
                format!("1-{frames}")
            }
            // Of a stream, and of a file that cannot be read to its end, rendering says the rest.
            None => "1-".to_owned(),
        };
        self.args.read.frames = Some(all.parse()?);
        Ok(())
    }

    /// Limits of the pictures in memory besides the first, by its spheres and pixels. Pictures that are shown, piped or timed
    /// are rendered one after the other.
    fn concurrency(&self, first: &PictureScene, targets: &[Target], is_gpu: bool) -> Concurrency {
        let Scene { image, spheres, .. } = &first.scene;
        let pixels = image.width as usize * image.height as usize;
        let of = if self.args.read.frames.is_some() { SpheresOf::Each } else { SpheresOf::All };
        let is_piped = targets.iter().any(|target| target.is_standard() || is_special(target.path()));
        let in_turn = self.preview.is_some() || self.repeat.get() > 1 || self.progress.progress.is_lines() || is_piped;
        match together(is_gpu, pixels, spheres.len(), of) {
            _ if !self.args.is_many() => Concurrency::Alone,
            0 => Concurrency::Alone,
            1 => Concurrency::Next,
            _ if in_turn => Concurrency::Next,
            lanes => Concurrency::Pictures(lanes),
        }
    }

    /// The opened file and its first scene; a stream has no other.
    fn first(&self, settings: &Settings, targets: &[Target], cancel: &Cancel) -> Result<First<'_>> {
        if !self.args.visible.is_empty() {
            if self.stream {
                return Err(Error::settings(
                    "--stream reads a scene, and --visible has parts of one",
                    "remove --stream",
                ));
            }
            return Ok((None, Some(visible::picture(&self.args, settings, targets)?)));
        }
        if self.stream {
            let source = stream::Source::new(&self.args, cancel, None)?;
            return Ok((None, Some(source.visible(settings)?)));
        }
        let in_memory = || {
            let mut scene_frames = SceneFrames::open(&self.args, settings, cancel)?;
            let first = self.ready(&mut scene_frames)?;
            Ok((Some(scene_frames), first))
        };
        in_memory().or_else(|error| Ok((None, Some(self.as_stream(error, settings, cancel)?))))
    }

    /// The picture as a stream, where memory or its frame is too small for all spheres at once, as the error says.
    ///
    /// # Errors
    /// The same error if it has another reason, or the scene cannot be a stream.
    fn as_stream(&self, error: Error, settings: &Settings, cancel: &Cancel) -> Result<PictureScene> {
        let Error::Limits { problem, mend } = error else { return Err(error) };
        if read_once(self.args.path()).is_some() || !self.args.visible.is_empty() || self.stream {
            return Err(Error::Limits { problem, mend });
        }
        let why = format!("{problem}: the file is read as a stream (see --stream)");
        // A scene that cannot be a stream is one that does not fit.
        let source = stream::Source::new(&self.args, cancel, Some(why));
        source.and_then(|source| source.visible(settings)).map_err(|error| match error {
            Error::Settings { .. } => Error::Limits { problem, mend },
            Error::Limits { mend, .. } => Error::Limits { problem, mend },
            other => other,
        })
    }

    /// Whether a picture whose frame does not fit may be rendered as a stream. A stream keeps a few spheres a pixel, so it helps
    /// where there are more than that.
    fn may_be_stream(&self, picture: &PictureScene) -> bool {
        let image = picture.scene.image;
        let has_many = picture.scene.spheres.len() > image.width as usize * image.height as usize;
        picture.ids.is_none() && !self.args.is_many() && has_many
    }

    /// The next scene, once its files are known to be writable.
    fn ready(&self, scene_frames: &mut SceneFrames<'_>) -> Result<Option<PictureScene>> {
        let Some(mut picture) = scene_frames.next_frame()? else { return Ok(None) };
        writable_targets(&self.args, picture.number, &scene_frames.inputs())?;
        // Shared numbers are checked once, and not again for every repeated frame.
        picture.scene.spheres.share();
        picture.scene.check()?;
        Ok(Some(picture))
    }

    /// The files of the first picture; checks combinations of options.
    fn check(&self) -> Result<Vec<Target>> {
        if !self.args.visible.is_empty() {
            visible::check(&self.args)?;
        }
        self.args.files.check_film(self.args.is_many(), self.resume)?;
        let targets = self.args.targets(1)?;
        if let (Some(film), None, false) = (self.args.files.film(), self.args.size(), self.args.image.is_part()) {
            let frames = self.args.read.frames.as_ref();
            let is_used = |number| frames.is_none_or(|frames| frames.contains(number));
            self.args.camera.list.check_one_size(film.path, is_used)?;
        }
        if self.args.is_many() {
            self.args.files.check_many()?;
        }
        legend::check(&self.args)?;
        if let Some(warning) = legend::unused_title(&self.args) {
            note(format_args!("{warning}"));
        }
        self.args.insets.check(self.args.image.is_part(), &self.args.files)?;
        self.args.check_outputs()?;
        self.args.files.check_formats(&targets)?;
        figure::check(&self.args)?;
        if self.resume {
            self.args.files.check_resume(&targets)?;
        }
        self.args.files.check_transparent(&targets);
        match self.args.camera_list()? {
            Some(_) => check_text(targets.iter().map(Target::path), "cameras.json")?,
            None if self.args.camera.list.file.is_none() => {}
            None => note(format_args!(
                "cameras.json is not written, because no picture is a file whose folder it could be in"
            )),
        }
        if targets.is_empty() && !self.json && self.preview.is_none() && self.args.files.is_picture_only() {
            let problem = "no output is requested";
            return Err(Error::settings(problem, "use -o for a picture, --aov for a buffer, or --json"));
        }
        let standard = targets.iter().map(Target::is_standard).chain([self.json, self.progress.is_openjd()]);
        check_one_standard("a picture, a buffer", standard)?;
        Ok(targets)
    }
}
