//! The rays of `halfline trace`: rays of a file, or beams of a pattern.

use crate::camera_args::PoseArgs;
use crate::signals::go_on;
use clap::Args;
use halfline::camera::{Basis, Camera};
use halfline::error::{Error, Result};
use halfline::progress::Watch;
use halfline::quote::setting::ANY;
use halfline::scene::lidar::Lidar;
use halfline_files::read::SceneFrame;
use halfline_files::read::rays::{RayBlock, RayOptions, RayReader};
use halfline_files::write::hits::Query;
use halfline_files::write::rays;
use std::path::PathBuf;

/// The rays that are traced together, while others are read and written. Their answers do not depend on it.
const BLOCK: usize = 1 << 18;

/// Rays of a block.
pub(super) fn rays_of_a_block() -> usize {
    halfline_files::blocks::at_most(BLOCK)
}

/// The source of the rays: a file, or the pattern of a scanner.
#[derive(Debug, Args)]
#[command(next_help_heading = "Rays")]
pub(super) struct SourceArgs {
    #[command(flatten)]
    which: Which,
    /// Writes the beams of the pattern as rays in .npy.
    #[arg(long, value_name = "FILE", conflicts_with = "rays")]
    rays_out: Option<PathBuf>,
    /// Counts invalid rows (NaN, a zero direction, missing columns) as misses of certainty 255; otherwise the first one is
    /// an error.
    #[arg(long, conflicts_with = "pattern")]
    skip_invalid: bool,
}

/// A file or a pattern.
#[derive(Debug, Args)]
#[command(next_help_heading = "Rays")]
#[group(required = true, multiple = false)]
struct Which {
    /// The rays: .npy, float64 of shape (n, 6) or (n, 7), or a table of text, which may have a header; - for standard
    /// input. Also .gz, .bz2, .xz or .zst.
    #[arg(long, value_name = "FILE")]
    rays: Option<PathBuf>,
    /// The beams of a spinning scanner at --eye, in degrees: lidar:rings=N,vfov=LOW..HIGH,step=DEG and optionally
    /// ,azimuth=FROM..TO and ,range=LENGTH. Azimuths are clockwise from --view; the highest ring comes first. Echoes with
    /// intensities in place of exact hits: ,divergence=DEG[,returns=N] for beams that are cones of 19 rays,
    /// ,noise=SIGMA[,seed=N] for normal noise of the range.
    #[arg(long, value_name = "PATTERN")]
    pattern: Option<Lidar>,
}

/// An opened source of rays.
pub(super) enum RaySource {
    File(RayReader),
    Pattern {
        lidar: Lidar,
        basis: Basis,
        /// The beams so far.
        done: u64,
    },
}

impl SourceArgs {
    /// The file of the rays.
    pub(super) fn rays(&self) -> Option<&PathBuf> {
        self.which.rays.as_ref()
    }

    /// The file for the beams.
    pub(super) fn beams(&self) -> Option<&PathBuf> {
        self.rays_out.as_ref()
    }

    /// The query of the rays; with `any`, whether each hits anything.
    pub(super) fn query(&self, any: bool) -> Result<Query> {
        let has_echoes = self.which.pattern.is_some_and(|lidar| lidar.echoes().is_some());
        match (any, has_echoes) {
            (true, true) => {
                let problem =
                    format!("{ANY} finds no echoes, and divergence and noise of the pattern belong to echoes");
                Err(Error::settings(problem, format!("remove {ANY}, or these keys")))
            }
            (true, false) => Ok(Query::Any),
            (false, true) => Ok(Query::Echoes),
            (false, false) => Ok(Query::Nearest),
        }
    }

    /// Checks combinations of options.
    pub(super) fn check(&self, pose: &PoseArgs) -> Result<()> {
        if self.which.pattern.is_none() && pose.is_given() {
            let problem = "--eye, --at, --view and --up are the pose of a pattern, and --rays has origins of its own";
            return Err(Error::settings(problem, "remove them, or use --pattern"));
        }
        match &self.rays_out {
            Some(path) if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("npy")) => {
                let problem = format!("{} cannot hold rays", path.display());
                Err(Error::settings(problem, "use the file name extension .npy"))
            }
            _ => Ok(()),
        }
    }

    /// Opens the source; a pattern has the pose of the scene's camera with the options applied.
    pub(super) fn open(&self, pose: &PoseArgs, frame: &SceneFrame, watch: Watch) -> Result<RaySource> {
        let lidar = match (&self.which.rays, self.which.pattern) {
            (_, Some(lidar)) => lidar,
            (Some(path), None) => {
                let options = RayOptions { skip_invalid: self.skip_invalid, watch };
                return RayReader::open(path, &options).map(RaySource::File);
            }
            (None, None) => return Err(Error::settings("there are no rays", "use --rays or --pattern")),
        };
        if !frame.has_camera && pose.eye.is_none() {
            let problem = "the scene has no camera, so the scanner has no position";
            return Err(Error::settings(problem, "use --eye X,Y,Z, and --view and --up for its direction"));
        }
        let mut camera = if frame.has_camera { frame.scene.camera } else { Camera::CANONICAL };
        pose.turn(&mut camera, frame.has_camera)?;
        Ok(RaySource::Pattern { lidar, basis: camera.basis()?, done: 0 })
    }

    /// Writes the beams of the source, if their file is requested.
    pub(super) fn write_beams(&self, source: &RaySource) -> Result<()> {
        let (Some(path), RaySource::Pattern { lidar, basis, .. }) = (&self.rays_out, source) else { return Ok(()) };
        // The rays themselves are still to be traced.
        let mut source = RaySource::Pattern { lidar: *lidar, basis: *basis, done: 0 };
        rays::write(path, lidar.rays(), lidar.range().is_finite(), |add| {
            while let Some(block) = source.next_block(rays_of_a_block())? {
                add(&block.rays())?;
            }
            Ok(())
        })
    }
}

impl RaySource {
    /// The number of rays, if it is known.
    pub(super) fn count(&self) -> Option<u64> {
        match self {
            Self::File(reader) => reader.count(),
            Self::Pattern { lidar, .. } => Some(lidar.rays()),
        }
    }

    /// The scanner, if the rays are its beams.
    pub(super) fn lidar(&self) -> Option<&Lidar> {
        match self {
            Self::File(_) => None,
            Self::Pattern { lidar, .. } => Some(lidar),
        }
    }

    /// The next rays, about `most`, for a pattern in whole beams; `None` after the last.
    pub(super) fn next_block(&mut self, most: usize) -> Result<Option<RayBlock>> {
        let (lidar, basis, done) = match self {
            Self::File(reader) => return reader.next_block(most),
            Self::Pattern { lidar, basis, done } => (lidar, basis, done),
        };
        if !go_on() {
            return Err(Error::Interrupted);
        }
        let most = (most as u64 / u64::from(lidar.rays_per_beam())).max(1);
        let beams = *done..lidar.beams().min(*done + most);
        if beams.is_empty() {
            return Ok(None);
        }
        *done = beams.end;
        let directions = lidar.directions(beams, basis);
        let limits = if lidar.range().is_finite() { vec![lidar.range(); directions.len()] } else { Vec::new() };
        Ok(Some(RayBlock { origins: vec![basis.e.to_array()], directions, limits, ..RayBlock::default() }))
    }
}
