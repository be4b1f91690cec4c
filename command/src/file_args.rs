//! The output files of `render`: which buffers go where, and how they are stored.

use super::clash::{place, written_twice};
use super::film::{FPS, Film};
use super::messages::warn;
use super::names::{check_pattern, numbered};
use super::typed::Typed;
use super::values::{color, positive};
use clap::Args;
use clap::builder::ArgPredicate;
use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::scene::Scene;
use halfline_files::write::file::{Target, is_special, is_standard_output};
use halfline_files::write::format::{Bits, Dpi, FileFormat, FormatOptions, NoReturn};
use halfline_files::write::glb::is_glb;
use halfline_files::write::vector::VectorFormat;
use std::path::{Path, PathBuf};

/// Buffers and their file; `None` for the file of -o.
type AovArgument = (Vec<Aov>, Option<PathBuf>);

/// The output files and the options of their formats.
#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(super) struct FileArgs {
    #[command(flatten)]
    typed: Typed,
    /// The picture: .png, .exr, .npy (linear RGB), .npz, .pfm, .raw, or a copy for other programs, which halfline does not read
    /// again: .tif, .jpg (quality 95), .webp (lossless); - is a PNG on standard output. For several pictures
    /// %d or %04d is replaced by the number, and %% beside it by %, or .mp4 or .gif is a film of them, made by ffmpeg. .glb is
    /// no picture but the spheres themselves, as points with radii and colours for Blender and other programs. .svg and .pdf are
    /// figures without pixels: the visible part of each sphere as a path, sharp at any size.
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Pictures per second of a film [default: 25].
    #[arg(long, value_name = "N", value_parser = fps, allow_negative_numbers = true)]
    fps: Option<f64>,
    /// Buffers: color, distance, depth, normal, position, id, mask, certainty, bound, alpha, shadow (of each
    /// light), occlusion (open share of the sky). An .exr or .npz can hold
    /// several; without FILE they are stored in the file of -o. Examples: depth=d.pfm, depth,id=all.exr, depth,normal.
    #[arg(long, value_name = "NAME[,NAME..][=FILE]", value_parser = named)]
    aov: Vec<AovArgument>,
    /// Adds Cryptomatte layers to the .exr of -o, for masks in compositors: id (the number of each sphere), residue, or a column
    /// such as chain, element or type. Each layer has the six objects that cover most of a pixel, by its --samples. May be
    /// given several times.
    #[arg(long, value_name = "COLUMN")]
    pub(super) cryptomatte: Vec<String>,
    /// Bits per component in PNG and TIFF: 8, 16.
    #[arg(long, value_name = "N", default_value = "8")]
    bits: Bits,
    /// Pixels per inch, stored in .png, .tif, .jpg, .webp, .svg and .pdf for print; --size gives the number of pixels,
    /// or it follows from a size in millimetres.
    #[arg(long, value_name = "N")]
    pub(super) dpi: Option<Dpi>,
    /// Cuts the borders in which nothing is shown off the picture and all buffers; what remains has its place in the frame in its
    /// files, as a crop has.
    #[arg(long, help_heading = "Image", conflicts_with_all = ["crop", "tile"])]
    pub(super) trim: bool,
    /// Scene units per level of distance and depth in PNG, up to level 65535; 0 is a miss.
    #[arg(long, value_name = "X", default_value = "0.001", value_parser = positive("number, such as 0.001"),
        allow_negative_numbers = true)]
    unit: f64,
    /// Distance and depth of a miss: inf, nan (as in ROS), zero (as in OpenCV); in PNG always 0.
    #[arg(long, value_name = "V", default_value = "inf")]
    no_return: NoReturn,
    /// Writes little-endian numbers without a header to standard output, as in .raw files.
    #[arg(long)]
    pub(super) raw: bool,
    /// Background colour: a CSS name such as white, #rgb or #rrggbb in sRGB, or r,g,b in linear RGB.
    #[arg(long, help_heading = "Image", value_name = "C", value_parser = color, conflicts_with = "transparent")]
    background: Option<[f32; 3]>,
    /// Makes the background transparent; alpha is stored in .png, .exr, .npz, .tif and .webp.
    // --background on the command line overrides a configuration file that makes all backgrounds transparent.
    #[arg(long, help_heading = "Image", default_value_if("background", ArgPredicate::IsPresent, "false"))]
    pub(super) transparent: bool,
}

impl FileArgs {
    /// Applies the options that change the scene.
    pub(super) fn apply(&self, scene: &mut Scene) {
        let given = if self.transparent { Some([0.0; 3]) } else { self.background };
        if let Some(color) = given {
            scene.set_background(color);
        }
    }

    /// The files of picture `number`, each with its buffers, for print at `dpi`.
    pub(super) fn targets(&self, number: u64, dpi: Option<Dpi>) -> Result<Vec<Target>> {
        let mut files: Vec<(PathBuf, Vec<Aov>)> = Vec::new();
        for (aovs, path) in self.named()? {
            let path = numbered(path, number);
            // Pipes and devices can receive one file after another.
            let is_once =
                |other: &Path| !is_special(&path) && !is_standard_output(&path) && place(other) == place(&path);
            match files.iter_mut().find(|(other, _)| is_once(other)) {
                Some((_, together)) if FileFormat::of(&path).is_some_and(FileFormat::holds_many) => {
                    together.extend(aovs)
                }
                Some(_) => {
                    return written_twice(&path, "use a separate file for each buffer, or one .exr or .npz");
                }
                None => files.push((path, aovs)),
            }
        }
        if self.raw && !files.iter().any(|(path, _)| is_standard_output(path)) {
            return Err(Error::settings(
                "--raw applies to standard output only",
                "add NAME=-, or use the file name extension .raw",
            ));
        }
        let targets =
            files.into_iter().map(|(path, aovs)| self.target(&aovs, &path, dpi)).collect::<Result<Vec<_>>>()?;
        match targets.first().filter(|_| self.picture().is_some()) {
            _ if self.cryptomatte.is_empty() => {}
            Some(picture) => picture.check_mattes()?,
            None => return Err(Error::settings("--cryptomatte adds layers to a picture", "use -o FILE.exr")),
        }
        Ok(targets)
    }

    /// Returns an error for a --dpi of the command line that none of the files would hold, and for 16 bits in a file that has 8;
    /// a preference from elsewhere may apply to no file.
    pub(super) fn check_formats(&self, targets: &[Target]) -> Result<()> {
        let film = self.film().map(|film| film.path);
        let holds = |target: &Target| target.format().has_levels() && Some(target.path()) != film;
        if self.typed.has("dpi") && !targets.iter().any(holds) && self.figure().is_none() {
            let problem = "--dpi applies to .png, .tif, .jpg, .webp, .svg and .pdf files, and none is written";
            return Err(Error::settings(problem, "use the file name extension .png, or remove --dpi"));
        }
        let short = |target: &&Target| target.format().is_copy() && !target.format().takes_sixteen_bits();
        match targets.iter().find(short).filter(|_| self.typed.has("bits") && self.bits == Bits::Sixteen) {
            Some(target) => {
                let problem = format!("{} has 8 bits per component", target.path().display());
                Err(Error::settings(problem, "use .png or .tif with --bits 16"))
            }
            None => Ok(()),
        }
    }

    /// Returns an error for files that --resume could not find whole.
    ///
    /// # Errors
    /// [`Error::Settings`] with the file.
    pub(super) fn check_resume(&self, targets: &[Target]) -> Result<()> {
        if let Some((path, _)) = self.figure() {
            let problem = format!("--resume: {} is a figure, which is not read again", path.display());
            return Err(Error::settings(problem, "use .png, or remove --resume"));
        }
        match targets.iter().find(|target| target.format().is_copy()) {
            Some(target) => {
                let problem = format!("--resume: {} is a copy, which is not read again", target.path().display());
                Err(Error::settings(problem, "use .png, or remove --resume"))
            }
            None => Ok(()),
        }
    }

    /// Warns of a --transparent of the command line that none of the files shows.
    pub(super) fn check_transparent(&self, targets: &[Target]) {
        let shows = |target: &Target| target.aovs().contains(&Aov::Alpha);
        if self.figure().is_none() && self.typed.has("transparent") && !targets.is_empty() && !targets.iter().any(shows)
        {
            warn(["--transparent: no file has the alpha of the picture; .png, .exr, .npz, .tif and .webp store it"]);
        }
    }

    /// The film that -o names.
    pub(super) fn film(&self) -> Option<Film<'_>> {
        self.output.as_deref().and_then(|path| Film::of(path, self.fps.unwrap_or(FPS)))
    }

    /// Returns an error for options that make no film, and for --fps without one.
    pub(super) fn check_film(&self, is_many: bool, resume: bool) -> Result<()> {
        if self.trim && (resume || self.film().is_some()) {
            let why = if resume { "what --resume finds has a size" } else { "the pictures of a film have one size" };
            return Err(Error::settings(format!("--trim: {why} before it is rendered"), "remove one of them"));
        }
        if let Some(film) = self.film() {
            return film.check(is_many, self.transparent, resume);
        }
        if self.fps.is_none() {
            return Ok(());
        }
        let problem = "--fps is the rate of a film, and none is written";
        Err(Error::settings(problem, "use -o with the file name extension .mp4 or .gif, or remove --fps"))
    }

    /// The picture that -o names, neither a model nor a figure.
    fn picture(&self) -> Option<&Path> {
        self.output.as_deref().filter(|path| !is_glb(path) && VectorFormat::of(path).is_none())
    }

    /// The model of the spheres that -o names, with a place for the number.
    pub(super) fn model(&self) -> Option<&Path> {
        self.output.as_deref().filter(|path| is_glb(path))
    }

    /// The figure without pixels that -o names, with a place for the number, and its format.
    pub(super) fn figure(&self) -> Option<(&Path, VectorFormat)> {
        let path = self.output.as_deref()?;
        Some((path, VectorFormat::of(path)?))
    }

    /// Whether -o names neither a model nor a figure.
    pub(super) fn is_picture_only(&self) -> bool {
        self.model().is_none() && self.figure().is_none()
    }

    /// The buffers of --aov.
    pub(super) fn buffers(&self) -> Vec<Aov> {
        self.aov.iter().flat_map(|(aovs, _)| aovs).copied().collect()
    }

    /// The names of all files, with patterns for the number.
    pub(super) fn names(&self) -> Result<Vec<&Path>> {
        let figure = self.figure().map(|(path, _)| path);
        Ok(self.model().into_iter().chain(figure).chain(self.named()?.into_iter().map(|(_, path)| path)).collect())
    }

    /// Whether the name of the picture has a place for the number of a frame.
    pub(super) fn is_numbered(&self) -> bool {
        self.output.as_deref().is_some_and(|path| numbered(path, 1) != path)
    }

    /// Returns an error for names that several pictures would share.
    pub(super) fn check_many(&self) -> Result<()> {
        let film = self.film().map(|film| film.path);
        let names = self.names()?;
        names.into_iter().filter(|path| Some(*path) != film).try_for_each(check_pattern)
    }

    /// The options of the formats.
    pub(super) fn style(&self) -> FormatOptions {
        let Self { bits, unit, no_return, transparent, dpi, .. } = *self;
        FormatOptions { bits, unit, no_return, transparent, dpi }
    }

    fn target(&self, aovs: &[Aov], path: &Path, dpi: Option<Dpi>) -> Result<Target> {
        let style = FormatOptions { dpi, ..self.style() };
        match aovs {
            [aov] if self.raw && is_standard_output(path) => Ok(Target::raw(*aov, path, style)),
            [Aov::Color] if self.film().is_some_and(|film| film.path == path) => Ok(Target::film(path, style)),
            [Aov::Color] if self.picture().is_some() => {
                Target::new(aovs, path, style).map_err(|e| with_others(path, e))
            }
            _ => Target::new(aovs, path, style),
        }
    }

    /// The buffers and their files in the order of the command line, the picture first.
    fn named(&self) -> Result<Vec<(Vec<Aov>, &Path)>> {
        let output = self.picture();
        let mut named: Vec<_> = output.map(|path| (vec![Aov::Color], path)).into_iter().collect();
        for (aovs, path) in &self.aov {
            let together = output.filter(|path| FileFormat::of(path).is_some_and(FileFormat::holds_many));
            let path = path.as_deref().or(together).ok_or_else(|| {
                let names = aovs.iter().map(|aov| aov.name()).collect::<Vec<_>>().join(",");
                let mend = "use NAME=FILE, or an .exr or .npz file for -o, which can hold several buffers";
                Error::settings(format!("--aov {names} has no file"), mend)
            })?;
            named.push((aovs.clone(), path));
        }
        Ok(named)
    }
}

/// Endings of films and of models in other programs.
const FILMS: [&str; 12] = ["apng", "avi", "flv", "m4v", "mkv", "mov", "mpeg", "mpg", "ogv", "webm", "wmv", "y4m"];
const MODELS: [&str; 14] =
    ["3mf", "blend", "dae", "fbx", "gltf", "obj", "ply", "stl", "usd", "usda", "usdc", "usdz", "wrl", "x3d"];

/// The error for a picture's file name, with the endings of what is no picture; endings of its kind come first.
fn with_others(path: &Path, error: Error) -> Error {
    let Error::Settings { problem, mend } = error else { return error };
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
    let film = "a film of several pictures is .mp4 or .gif";
    let [model, figure] = ["a model of the spheres is .glb", "a figure without pixels is .svg or .pdf"];
    let mend = match &ending[..] {
        ending if FILMS.contains(&ending) => format!("{film}; else {mend}"),
        ending if MODELS.contains(&ending) => format!("{model}; else {mend}"),
        _ => format!("{mend}; {film}, {model}, {figure}"),
    };
    Error::Settings { problem, mend }
}

fn named(text: &str) -> Result<AovArgument, String> {
    let (names, file) = text.split_once('=').map_or((text, None), |(names, file)| (names, Some(file)));
    if file == Some("") {
        return Err("expected a file name after '='".into());
    }
    // A file's name may hold commas and equals signs, but not the name of a buffer between them.
    let begins = |part: &str| part.split_once('=').is_some_and(|(name, _)| name.parse::<Aov>().is_ok());
    if let Some((at, _)) = text.match_indices(',').find(|(at, _)| names.len() < *at && begins(&text[at + 1..])) {
        let [first, second] = [&text[..at], &text[at + 1..]];
        let mend = format!("use --aov once for each file, as in --aov {first} --aov {second}");
        return Err(format!("{second} is in the name of a file; {mend}"));
    }
    let aovs = names.split(',').map(|name| name.parse().map_err(|e: Error| e.to_string())).collect::<Result<_, _>>()?;
    Ok((aovs, file.map(PathBuf::from)))
}

fn fps(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && x <= 1000.0 => Ok(x),
        _ => Err("expected a number of pictures per second, such as 25".into()),
    }
}
