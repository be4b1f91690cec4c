//! Options of the camera: its position, direction and lens.

use super::camera_list::CameraListArgs;
use super::lens_args::LensArgs;
use super::values::{at_least_one, numbers, positive, vector};
use clap::Args;
use glam::DVec3;
use halfline::camera::{Camera, Lens, Look};
use halfline::error::{Error, Result};
use halfline::quote::list;
use halfline::scene::{NamedView, Scene};
use halfline_files::read::Selection;
use std::num::NonZeroU32;
use std::path::PathBuf;

/// The camera options, which replace parts of the scene's camera.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(super) struct CameraArgs {
    #[command(flatten)]
    pub(super) pose: PoseArgs,
    /// Frames the spheres that an expression selects, with a margin, within the whole scene; --view auto, the default of
    /// molecules, looks from where least of them is hidden. Where the eye would be inside of a sphere it steps back, and the
    /// viewport narrows.
    #[arg(long, value_name = "EXPR", conflicts_with_all = ["eye", "fit"])]
    pub(super) focus: Option<Selection>,
    /// Moves the eye so that all spheres are in view; the default for files without a camera.
    #[arg(long, conflicts_with = "eye")]
    pub(super) fit: bool,
    /// Frames this share of the spheres, such as 99%, and leaves out those farthest from the median of their centres; all are rendered.
    #[arg(long, value_name = "P", value_parser = share, conflicts_with_all = ["eye", "focus"])]
    pub(super) frame_share: Option<f64>,
    /// Takes the camera and the size of a picture or buffer that halfline wrote, of a report of --json, or of a scene (.toml).
    #[arg(long = "camera-from", value_name = "FILE",
        conflicts_with_all = ["eye", "at", "view", "up", "focus", "frame_share", "fit", "vfov", "ortho"])]
    pub(super) from: Option<PathBuf>,
    /// Vertical field of view, degrees; makes the camera a perspective one.
    #[arg(long, value_name = "DEG", value_parser = angle, allow_hyphen_values = true)]
    vfov: Option<f64>,
    /// Orthographic camera with a view of this height in scene units; without HEIGHT it shows all spheres. Answers are
    /// always certified or exact.
    #[arg(long, value_name = "HEIGHT", value_parser = positive("number, in the scene's unit"), num_args = 0..=1,
        allow_negative_numbers = true, conflicts_with = "vfov")]
    pub(super) ortho: Option<Option<f64>>,
    /// Magnifies the picture X times about its middle; below 1 it shows more. It makes the viewport
    /// narrower by that factor, after the scene is framed, and does not move the eye.
    #[arg(long, value_name = "X", value_parser = positive("number, such as 2"), allow_negative_numbers = true)]
    zoom: Option<f64>,
    #[command(flatten)]
    pub(super) lens: LensArgs,
    #[command(flatten)]
    pub(super) list: CameraListArgs,
    /// Renders N pictures in a full turn about the up axis; with --frames, the frame's number gives the angle.
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pub(super) spin: Option<NonZeroU32>,
}

/// A share above 0 and at most 1, or in percent.
fn share(text: &str) -> Result<f64, String> {
    let number = match text.strip_suffix('%') {
        Some(percent) => percent.trim().parse().map(|percent: f64| percent / 100.0),
        None => text.parse(),
    };
    let expected = "expected a share above 0 and at most 1, or a percentage, such as 99%";
    number.ok().filter(|share| *share > 0.0 && *share <= 1.0).ok_or_else(|| expected.into())
}

/// The pose of a camera or of a scanner.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(super) struct PoseArgs {
    /// Position of the eye.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(super) eye: Option<DVec3>,
    /// Point to look at, or an expression such as "resname HEM" for the centre of what it selects. Without --eye, the eye
    /// is placed so that the point is in the middle and all spheres are in view.
    #[arg(long, value_name = "X,Y,Z|EXPR", value_parser = target, allow_hyphen_values = true)]
    pub(super) at: Option<CameraTarget>,
    /// Direction to look in: X,Y,Z, or front (along -z, y up), back, left, right, top, bottom, iso, which frame all; auto
    /// turns the largest face to the eye and the longest axis across, the default for molecules.
    #[arg(long, value_name = "X,Y,Z|WORD", value_parser = direction, allow_hyphen_values = true)]
    pub(super) view: Option<Direction>,
    /// Up direction of the scene.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(super) up: Option<DVec3>,
}

/// The target of `--at`: a point in scene units, or selected spheres.
#[derive(Debug, Clone)]
pub(super) enum CameraTarget {
    Point(DVec3),
    /// The centre of the selected spheres.
    Selected(Selection),
}

/// The direction of `--view`.
#[derive(Debug, Clone, Copy)]
pub(super) enum Direction {
    Vector(DVec3),
    Named(NamedView),
}

impl CameraArgs {
    /// Checks the combination of the eye, the point and the direction.
    ///
    /// # Errors
    /// [`Error::Settings`] for all three.
    pub(super) fn check(&self) -> Result<()> {
        let PoseArgs { eye, at, view, .. } = &self.pose;
        if eye.is_some() && at.is_some() && view.is_some() {
            let problem = "--eye and --at give the direction, and --view another one";
            return Err(Error::settings(problem, "remove one of the three"));
        }
        Ok(())
    }

    /// The selections that are looked at, in the order of a frame's marks.
    pub(super) fn marks(&self) -> Vec<Selection> {
        let at = match &self.pose.at {
            Some(CameraTarget::Selected(selection)) => Some(selection),
            _ => None,
        };
        at.into_iter().chain(&self.focus).cloned().collect()
    }

    /// The number of pictures of one scene: the turns, or the cameras of a list; `None` without either. A list that
    /// cannot be read counts as several, and is reported when it is opened.
    pub(super) fn turns(&self) -> Option<u32> {
        let listed = || match self.list.listed() {
            Ok(listed) => listed.map(|listed| u32::try_from(listed.len()).unwrap_or(u32::MAX)),
            Err(_) => Some(2),
        };
        self.spin.map(NonZeroU32::get).or_else(listed)
    }

    /// The lens of `--vfov`.
    pub(super) fn vfov(&self) -> Option<Lens> {
        self.vfov.map(|degrees| Lens::Vfov { degrees, distance: 1.0 })
    }

    /// Narrows the viewport of the scene's final camera and image by --zoom.
    pub(super) fn zoom(&self, scene: &mut Scene) -> Result<()> {
        let (width, height) = (scene.image.width, scene.image.height);
        self.zoom.map_or(Ok(()), |factor| scene.camera.zoom(factor, width, height))
    }

    /// Replaces the eye and the lens that the options give.
    pub(super) fn apply_lens(&self, camera: &mut Camera) {
        camera.eye = self.pose.eye.unwrap_or(camera.eye);
        if let Some(degrees) = self.vfov {
            let distance = match camera.lens {
                Lens::Viewport { distance, .. } | Lens::Vfov { distance, .. } => distance,
                _ => 1.0,
            };
            camera.lens = Lens::Vfov { degrees, distance };
        }
        if let Some(height) = self.ortho {
            camera.lens = Lens::Orthographic { height: height.unwrap_or(1.0) };
        }
    }
}

impl PoseArgs {
    /// The direction and the up vector of these options alone, for a camera or a scanner with an eye: `at` takes precedence.
    ///
    /// # Errors
    /// [`Error::Settings`] for a direction that depends on the spheres, which a scanner does not have.
    pub(super) fn turn(&self, camera: &mut Camera, has_camera: bool) -> Result<()> {
        let problem =
            |what: &str| Err(Error::settings(format!("{what} depends on the spheres of a picture"), "use X,Y,Z"));
        camera.eye = self.eye.unwrap_or(camera.eye);
        if self.at.is_some() && self.view.is_some() {
            return Err(Error::settings("--at and --view give two directions", "remove one of them"));
        }
        let up = match (&self.at, self.view) {
            (Some(CameraTarget::Selected(_)), _) => return problem("--at EXPR"),
            (Some(CameraTarget::Point(at)), _) => {
                camera.look = Look::At(*at);
                None
            }
            (None, Some(Direction::Vector(view))) => {
                camera.look = Look::View(view);
                None
            }
            (None, Some(Direction::Named(view))) => {
                let Some(facing) = view.facing() else { return problem("--view auto") };
                camera.look = Look::View(facing.view);
                Some(facing.up)
            }
            (None, None) => None,
        };
        camera.up = self.up.or(up).unwrap_or_else(|| upright(camera.look, camera.up, has_camera));
        Ok(())
    }

    /// Whether an option is given.
    pub(super) fn is_given(&self) -> bool {
        self.eye.is_some() || self.up.is_some() || self.at.is_some() || self.view.is_some()
    }
}

/// The up vector of a camera whose options give none: its own, or z where it is not a file's and looks along its own.
pub(super) fn upright(look: Look, up: DVec3, has_camera: bool) -> DVec3 {
    match look {
        Look::View(view) if !has_camera && view.cross(up).length() <= 1e-6 * view.length() => DVec3::Z,
        _ => up,
    }
}

fn target(text: &str) -> Result<CameraTarget, String> {
    if let Some(point) = numbers(text) {
        return Ok(CameraTarget::Point(DVec3::from_array(point)));
    }
    // No expression has a comma between numbers.
    if text.split(',').all(|part| part.trim().parse::<f64>().is_ok()) {
        return Err("expected three finite numbers, such as 1,-2,3.5, or an expression such as `resname HEM`".into());
    }
    text.parse().map(CameraTarget::Selected).map_err(|e: Error| e.to_string())
}

fn direction(text: &str) -> Result<Direction, String> {
    if let Some(vector) = numbers(text) {
        return Ok(Direction::Vector(DVec3::from_array(vector)));
    }
    let names = list(NamedView::ALL.iter().map(|view| view.name()));
    text.trim()
        .parse()
        .map(Direction::Named)
        .map_err(|_| format!("expected three finite numbers, such as 0,0,-1, or {names}"))
}

fn angle(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && x < 180.0 => Ok(x),
        _ => Err("expected an angle between 0 and 180 degrees, ends excluded".into()),
    }
}
