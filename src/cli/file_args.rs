//! The files that `render` writes: which buffers go where, and how their numbers are stored.

use super::clash::place;
use super::read_args::color;
use super::shots::{check_pattern, numbered};
use clap::Args;
use clap::builder::ArgPredicate;
use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::frame::file::{Target, is_special, is_standard_output};
use halfline::frame::format::{Bits, Format, NoReturn, Style};
use halfline::scene::Scene;
use std::path::{Path, PathBuf};

/// Buffers, and the file they go to; `None` for that of -o.
type Named = (Vec<Aov>, Option<PathBuf>);

/// Files and what their formats leave to choose.
#[derive(Debug, Args)]
pub(super) struct FileArgs {
    /// The picture; of several, with %d or %04d where its number goes: .png, .exr, .npy for linear RGB, .npz, .pfm, .raw, or - for a PNG on standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Buffers beside the picture: color, distance, depth, normal, position, id, mask, certainty, bound, alpha. An .exr or
    /// .npz takes several, and names without a file go to that of -o: depth=d.pfm, depth,id=all.exr, depth,normal.
    #[arg(long, value_name = "NAME[,NAME..][=FILE]", value_parser = named)]
    aov: Vec<Named>,
    /// Bits of colour, alpha and normals in PNG: 8, 16.
    #[arg(long, value_name = "N", default_value = "8")]
    bits: Bits,
    /// Scene units per step of distance and depth in PNG, which has 65535 steps; 0 is no return.
    #[arg(long, value_name = "X", default_value = "0.001", value_parser = unit, allow_negative_numbers = true)]
    unit: f64,
    /// Distance and depth where nothing is hit: inf, nan (as ROS wants it), zero (as OpenCV does). In PNG it is 0.
    #[arg(long, value_name = "V", default_value = "inf")]
    no_return: NoReturn,
    /// Makes the background transparent: colour is black there, and alpha is stored beside it in .png, .exr and .npz.
    // A background on the command line beats a file that always wants none.
    #[arg(long, default_value_if("background", ArgPredicate::IsPresent, "false"))]
    transparent: bool,
    /// The colour of a ray that hits nothing: #rrggbb in sRGB, or r,g,b in linear RGB.
    #[arg(long, value_name = "C", value_parser = color, conflicts_with = "transparent")]
    background: Option<[f32; 3]>,
    /// Writes bare little-endian numbers to standard output, as every .raw file holds them, instead of a PNG or .npy.
    #[arg(long)]
    raw: bool,
}

impl FileArgs {
    /// What the files ask of the scene.
    pub(super) fn apply(&self, scene: &mut Scene) {
        let given = if self.transparent { Some([0.0; 3]) } else { self.background };
        scene.image.background = given.unwrap_or(scene.image.background);
    }

    /// Every file that is named, with all that goes into it, for the picture of this number.
    pub(super) fn targets(&self, number: u64) -> Result<Vec<Target>> {
        let mut files: Vec<(PathBuf, Vec<Aov>)> = Vec::new();
        for (aovs, path) in self.named()? {
            let path = numbered(path, number);
            // Pipes and devices take one file after the other.
            let is_once =
                |other: &Path| !is_special(&path) && !is_standard_output(&path) && place(other) == place(&path);
            match files.iter_mut().find(|(other, _)| is_once(other)) {
                Some((_, together)) if Format::of(&path).is_some_and(Format::holds_many) => together.extend(aovs),
                Some(_) => {
                    let problem = format!("{} would be written twice", path.display());
                    return Err(Error::settings(problem, "name a file of its own for each buffer, or an .exr or .npz"));
                }
                None => files.push((path, aovs)),
            }
        }
        if self.raw && !files.iter().any(|(path, _)| is_standard_output(path)) {
            return Err(Error::settings(
                "--raw is for standard output",
                "write NAME=- too, or end a file's name in .raw",
            ));
        }
        files.into_iter().map(|(path, aovs)| self.target(&aovs, &path)).collect()
    }

    /// The names of all files, before numbers go into them.
    pub(super) fn names(&self) -> Result<Vec<&Path>> {
        Ok(self.named()?.into_iter().map(|(_, path)| path).collect())
    }

    /// Refuses names that several pictures would bear.
    pub(super) fn check_many(&self) -> Result<()> {
        self.named()?.iter().try_for_each(|(_, path)| check_pattern(path))
    }

    fn target(&self, aovs: &[Aov], path: &Path) -> Result<Target> {
        let Self { bits, unit, no_return, transparent, .. } = *self;
        let style = Style { bits, unit, no_return, transparent };
        match aovs {
            [aov] if self.raw && is_standard_output(path) => Ok(Target::raw(*aov, path, style)),
            _ => Target::new(aovs, path, style),
        }
    }

    /// The buffers and their files, in the order of the command line, the picture first.
    fn named(&self) -> Result<Vec<(Vec<Aov>, &Path)>> {
        let output = self.output.as_deref();
        let mut named: Vec<_> = output.map(|path| (vec![Aov::Color], path)).into_iter().collect();
        for (aovs, path) in &self.aov {
            let together = output.filter(|path| Format::of(path).is_some_and(Format::holds_many));
            let path = path.as_deref().or(together).ok_or_else(|| {
                let names = aovs.iter().map(|aov| aov.name()).collect::<Vec<_>>().join(",");
                let mend =
                    format!("write --aov {names}=FILE as NAME=FILE, or give -o an .exr or .npz, which takes them all");
                Error::settings(format!("--aov {names} names no file"), mend)
            })?;
            named.push((aovs.clone(), path));
        }
        Ok(named)
    }
}

fn named(text: &str) -> Result<Named, String> {
    let (names, file) = text.split_once('=').map_or((text, None), |(names, file)| (names, Some(file)));
    if file == Some("") {
        return Err("a file name is missing after '='".into());
    }
    let aovs = names.split(',').map(|name| name.parse().map_err(|e: Error| e.to_string())).collect::<Result<_, _>>()?;
    Ok((aovs, file.map(PathBuf::from)))
}

fn unit(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && f64::is_finite(x) => Ok(x),
        _ => Err("a unit is a positive number of scene units, such as 0.001".into()),
    }
}
