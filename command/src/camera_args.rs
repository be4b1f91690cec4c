//! Options of the camera: its position, direction and lens.

use super::camera_list::CameraListArgs;
use super::lens_args::LensArgs;
use super::values::{at_least_one, numbers, positive, share, vector};
use clap::Args;
use glam::DVec3;
use halfline::camera::{Camera, Intrinsics, Lens, Look};
use halfline::error::{Error, Result};
use halfline::quote::list;
use halfline::scene::{ImagePlane, NamedView, Scene};
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
        conflicts_with_all = ["eye", "at", "view", "up", "focus", "frame_share", "fit", "vfov", "ortho", "lens"])]
    pub(super) from: Option<PathBuf>,
    /// Vertical field of view, degrees; makes the camera a perspective one, unless --lens is fisheye [default of a fisheye: 180].
    #[arg(long, value_name = "DEG", value_parser = angle, allow_hyphen_values = true)]
    vfov: Option<f64>,
    /// Orthographic camera with a view of this height in scene units; without HEIGHT it shows all spheres. Answers are
    /// always certified or exact.
    #[arg(long, value_name = "HEIGHT", value_parser = positive("number, in the scene's unit"), num_args = 0..=1,
        allow_negative_numbers = true, conflicts_with = "vfov")]
    pub(super) ortho: Option<Option<f64>>,
    /// Magnifies the picture X times about its middle, or about the principal point; below 1 it shows more. It makes the viewport
    /// narrower by that factor, or the focal lengths of a lens longer, after the scene is framed, and does not move the eye.
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
    /// Checks the combination of the eye, the point and the direction, and the numbers of the lens.
    ///
    /// # Errors
    /// [`Error::Settings`] for all three, and as [`Self::apply_lens`].
    pub(super) fn check(&self) -> Result<()> {
        let PoseArgs { eye, at, view, .. } = &self.pose;
        if eye.is_some() && at.is_some() && view.is_some() {
            let problem = "--eye and --at give the direction, and --view another one";
            return Err(Error::settings(problem, "remove one of the three"));
        }
        if self.lens.intrinsics.is_some() && !self.lens.is_named() && self.list.file.is_none() {
            let problem = "--intrinsics belongs to a lens in pixels or to a list of cameras";
            return Err(Error::settings(
                problem,
                "add --lens opencv, --lens fisheye or --cameras, or remove --intrinsics",
            ));
        }
        if let Some(degrees) = self.vfov.filter(|degrees| *degrees >= 180.0 && !self.lens.is_named()) {
            let mend = "use an angle between 0 and 180 degrees, ends excluded, or add --lens fisheye";
            return Err(Error::settings(format!("--vfov is {degrees}"), mend));
        }
        // Before a file is read; sizes matter to no check.
        let ImagePlane { width, height, .. } = ImagePlane::default();
        match self.lens.named(self.vfov, (width, height))? {
            Some(lens) => self.check_panorama(lens),
            None => Ok(()),
        }
    }

    /// Checks that no option moves the sides of a picture that shows the whole sphere.
    fn check_panorama(&self, lens: Lens) -> Result<()> {
        let given = [
            ("--zoom", self.zoom.is_some()),
            ("--fit", self.fit),
            ("--focus", self.focus.is_some()),
            ("--frame-share", self.frame_share.is_some()),
        ];
        match given.iter().find(|(_, is_given)| *is_given && lens.is_panorama()) {
            Some((option, _)) => {
                let problem =
                    format!("{option}: an equirectangular picture shows the whole sphere, whatever it frames");
                Err(Error::settings(problem, format!("remove {option}, or use --lens fisheye")))
            }
            None => Ok(()),
        }
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

    /// The lens for cameras of a list without one: `--intrinsics`, or `--vfov`.
    pub(super) fn lens_of_list(&self) -> (Option<Intrinsics>, Option<Lens>) {
        (self.lens.intrinsics, self.vfov.map(|degrees| Lens::Vfov { degrees, distance: 1.0 }))
    }

    /// Whether the camera of a file without one shows all spheres by no other option than a direction and a lens.
    pub(super) fn frames_all(&self) -> bool {
        let PoseArgs { eye, at, .. } = &self.pose;
        let is_given = eye.is_some() || at.is_some() || self.from.is_some() || self.list.file.is_some();
        let is_part = self.focus.is_some() || self.frame_share.is_some() || self.zoom.is_some();
        !(is_given || is_part || self.spin.is_some() || self.lens.is_named() || matches!(self.ortho, Some(Some(_))))
    }

    /// Narrows the viewport of the scene's final camera and image by --zoom.
    pub(super) fn zoom(&self, scene: &mut Scene) -> Result<()> {
        let (width, height) = (scene.image.width, scene.image.height);
        self.zoom.map_or(Ok(()), |factor| scene.camera.zoom(factor, width, height))
    }

    /// Replaces the eye and the lens that the options give, for this image.
    ///
    /// # Errors
    /// [`Error::Settings`] for numbers that a lens does not have, or lacks.
    pub(super) fn apply_lens(&self, camera: &mut Camera, image: ImagePlane) -> Result<()> {
        camera.eye = self.pose.eye.unwrap_or(camera.eye);
        if let Some(lens) = self.lens.named(self.vfov, (image.width, image.height))? {
            camera.lens = lens;
        } else if let Some(degrees) = self.vfov {
            let distance = match camera.lens {
                Lens::Viewport { distance, .. } | Lens::Vfov { distance, .. } => distance,
                _ => 1.0,
            };
            camera.lens = Lens::Vfov { degrees, distance };
        }
        if let Some(height) = self.ortho {
            camera.lens = Lens::Orthographic { height: height.unwrap_or(1.0) };
        }
        self.check_panorama(camera.lens)
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
        Ok(x) if x > 0.0 && x <= 360.0 => Ok(x),
        _ => Err("expected an angle between 0 and 180 degrees, ends excluded; of a fisheye at most 360".into()),
    }
}
