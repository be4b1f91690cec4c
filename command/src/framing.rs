//! Framing: the points and selections that the camera looks at, and the spheres that it brings into view.

use super::camera_args::{CameraArgs, CameraTarget, Direction, PoseArgs, upright};
use glam::DVec3;
use halfline::camera::{Camera, Lens, Look};
use halfline::error::{Error, Result};
use halfline::parallel::{self, CHEAP};
use halfline::quote::quote;
use halfline::quote::setting::{CUT, FOCUS};
use halfline::scene::{
    Facing, Framing, ImagePlane, MAX_SIDE, NamedView, Outlook, SphereSource, Spheres, Spread, Surroundings, middle,
};
use halfline_files::read::{Focus, SceneFrame};

/// The source of a camera's direction.
pub(super) enum DirectionSource {
    /// From the options or from the file.
    Given(Look, DVec3),
    /// From a given eye toward the middle of the spheres.
    Middle(DVec3),
    /// Along the principal axes of the spheres.
    Axes,
}

/// The most heights of a picture in its width, where the spheres give its height.
const TALLEST: u32 = 16;

/// The margin around what `--focus` frames, as a share of the image: its surroundings are seen.
const FOCUS_MARGIN: f64 = 0.25;

impl CameraArgs {
    /// The point to look at.
    fn at(&self, frame: &SceneFrame) -> Result<Option<DVec3>> {
        match &self.pose.at {
            None => Ok(None),
            Some(CameraTarget::Point(at)) => Ok(Some(*at)),
            Some(CameraTarget::Selected(_)) => {
                chosen("--at", frame.marks.first(), frame)?.map_or(Ok(None), SphereSource::mean)
            }
        }
    }

    /// The spheres to frame; `None` for all.
    pub(super) fn focused<'a>(&self, frame: &'a SceneFrame) -> Result<Option<&'a Spheres>> {
        if self.focus.is_none() { Ok(None) } else { chosen("--focus", frame.marks.last(), frame) }
    }

    /// The spheres that a camera without a focus shows; `None` for all.
    pub(super) fn central(&self, spheres: &Spheres) -> Option<Spheres> {
        self.frame_share.map(|share| spheres.central(share))
    }

    /// The point that the camera turns about in place of the middle of all spheres.
    pub(super) fn pivot(&self, frame: &SceneFrame) -> Result<Option<DVec3>> {
        let focus = self.focused(frame)?.map(Spheres::middle);
        let central = || self.central(&frame.scene.spheres).map(|spheres| spheres.middle());
        Ok(self.at(frame)?.or(focus).or_else(central))
    }

    /// The framing of the scene. `None` if the eye is given, or if the file has a camera and no option asks for
    /// framing.
    ///
    /// # Errors
    /// [`Error::Settings`] for parallel rays without a height from a given eye.
    pub(super) fn framing(
        &self,
        has_camera: bool,
        at: Option<DVec3>,
        legend_shares: [f64; 2],
    ) -> Result<Option<Framing>> {
        let keep_height = !matches!(self.ortho, None | Some(None));
        if self.pose.eye.is_some() {
            return match self.ortho {
                Some(None) => Err(Error::settings("--ortho needs a height when --eye is given", "use --ortho HEIGHT")),
                _ => Ok(None),
            };
        }
        let PoseArgs { at: looks_at, view, .. } = &self.pose;
        let is_placed = looks_at.is_some() && view.is_some() || matches!(view, Some(Direction::Named(_)));
        let is_framed = self.fit
            || self.ortho == Some(None)
            || !has_camera
            || self.focus.is_some()
            || self.frame_share.is_some()
            || is_placed;
        let margin = if self.focus.is_some() { FOCUS_MARGIN } else { Framing::default().margin };
        Ok(is_framed.then(|| Framing { margin, ball: self.spin.is_some(), keep_height, legend_shares, aim: at }))
    }

    /// The direction of a camera.
    pub(super) fn direction_source(
        &self,
        camera: &Camera,
        has_camera: bool,
        is_molecule: bool,
        at: Option<DVec3>,
    ) -> DirectionSource {
        let own = if has_camera { camera.up } else { Facing::FRONT.up };
        let given = |look: Look, up: Option<DVec3>| {
            let up = self.pose.up.or(up).unwrap_or_else(|| upright(look, own, has_camera));
            DirectionSource::Given(look, up)
        };
        let named = |view: NamedView| {
            view.facing().map_or(DirectionSource::Axes, |facing| given(Look::View(facing.view), Some(facing.up)))
        };
        match (self.pose.view, at) {
            (Some(Direction::Vector(view)), _) => given(Look::View(view), None),
            (Some(Direction::Named(view)), _) => named(view),
            // The eye of a panorama is among the spheres and not where they frame the point.
            (None, Some(at)) if has_camera || self.pose.eye.is_some() || camera.lens.is_panorama() => {
                given(Look::At(at), None)
            }
            (None, None) if has_camera => given(camera.look, None),
            (None, None) if self.pose.eye.is_some() => DirectionSource::Middle(self.pose.up.unwrap_or(own)),
            // A lone point is looked at in the default direction.
            (None, _) => named(if is_molecule { NamedView::Auto } else { NamedView::Front }),
        }
    }
}

/// The spheres of a focus that are drawn; `None` without a focus or in a scene without spheres.
///
/// # Errors
/// [`Error::Settings`] for a focus that selects none of the spheres.
fn chosen<'a>(option: &str, focus: Option<&'a Focus>, frame: &SceneFrame) -> Result<Option<&'a Spheres>> {
    let Some(focus) = focus.filter(|_| !frame.scene.spheres.is_empty()) else { return Ok(None) };
    if !focus.spheres.is_empty() {
        return Ok(Some(&focus.spheres));
    }
    Err(none_selected(option, &focus.text, &focus.notes, frame.scene.spheres.len() as u64))
}

/// The error for an expression that selects none of so many spheres.
pub(super) fn none_selected(option: &str, text: &str, notes: &[String], count: u64) -> Error {
    let problem =
        format!("{option} {}: the expression selects none of the {count} spheres that are drawn", quote(text));
    let mend = match notes {
        [] => "use another expression; halfline info lists the columns of the file".to_owned(),
        notes => notes.join("; "),
    };
    Error::settings(problem, mend)
}

/// Applies the options of the camera to a frame, and frames the spheres where they do not give its place. `legend_shares`
/// are what a legend takes of the width at the left and at the right. Returns how the scene is framed, if it is.
///
/// # Errors
/// [`Error::Settings`] for a selection without spheres, and errors of [`Camera::fit`].
pub(super) fn point(options: &CameraArgs, frame: &mut SceneFrame, legend_shares: [f64; 2]) -> Result<Option<Framing>> {
    options.apply_lens(&mut frame.scene.camera, frame.scene.image)?;
    let at = options.at(frame)?;
    let framing = options.framing(frame.has_camera, at, legend_shares)?;
    let (image, spheres) = (frame.scene.image, &frame.scene.spheres);
    let (mut warning, mut hidden) = (None, None);
    let camera = match (framing, options.focused(frame)?) {
        (Some(framing), Some(focus)) => {
            let camera = &frame.scene.camera;
            let source = options.direction_source(camera, frame.has_camera, frame.is_molecule, at);
            let found = look_at_focus(&source, options, camera, image, [focus, spheres], &framing)?;
            hidden = found.warning(matches!(source, DirectionSource::Axes | DirectionSource::Middle(_)));
            found.camera
        }
        (framing, _) => {
            let central = options.central(spheres);
            aimed(options, frame, at, framing.as_ref(), central.as_ref().unwrap_or(spheres))?
        }
    };
    if framing.is_some() && camera.lens.is_panorama() && is_inside(camera.eye, spheres) {
        let text =
            "the eye of the panorama, the middle of the spheres, is inside of one of them; --eye gives another place";
        warning = Some(text.to_owned());
    }
    frame.scene.camera = camera;
    let notes = frame.marks.iter().flat_map(|focus| focus.notes.iter().cloned());
    frame.skipped.assumed.extend(notes.chain(warning));
    frame.hidden = hidden;
    Ok(framing)
}

/// The warning about a focus that is hidden where planes cut the spheres.
///
/// # Errors
/// [`Error::Settings`] for a selection without spheres.
pub(super) fn hidden_when_cut(options: &CameraArgs, frame: &SceneFrame) -> Result<Option<String>> {
    let Some(focus) = options.focused(frame)? else { return Ok(None) };
    let SceneFrame { scene, has_camera, is_molecule, .. } = frame;
    let at = options.at(frame)?;
    let Some(framing) = options.framing(*has_camera, at, [0.0; 2])? else { return Ok(None) };
    let around = Surroundings::new(scene.image, focus, &scene.spheres, &framing);
    if around.is_removed() {
        return Ok(Some(format!("{CUT} removes all of {FOCUS}")));
    }
    let source = options.direction_source(&scene.camera, *has_camera, *is_molecule, at);
    let is_best = matches!(source, DirectionSource::Axes | DirectionSource::Middle(_));
    Ok(around.from(scene.camera)?.warning(is_best))
}

/// The rows of a picture of `width` columns that the framed spheres fill; a camera that is not framed keeps the shape of its file.
///
/// # Errors
/// Errors of [`point`] and of `legend_shares`.
pub(super) fn filled_height(
    options: &CameraArgs,
    frame: &mut SceneFrame,
    width: u32,
    legend_shares: &dyn Fn(&SceneFrame) -> Result<[f64; 2]>,
) -> Result<u32> {
    let mut trial = frame.copy();
    trial.scene.resize([width, width]);
    let shares = legend_shares(&trial)?;
    let framing = point(options, &mut trial, shares)?;
    if framing.is_none() {
        let words = "the camera is given, so an open height follows from the file's image; --trim cuts empty borders";
        frame.skipped.assumed.push(words.to_owned());
    }
    let shape = match (framing, trial.scene.camera.lens) {
        (_, lens) if lens.is_panorama() => 0.5,
        (_, Lens::Viewport { vw, vh, .. }) => vh / vw,
        (None, _) => f64::from(frame.scene.image.height) / f64::from(frame.scene.image.width),
        (Some(framing), _) => {
            let central = options.central(&trial.scene.spheres);
            let all = central.as_ref().unwrap_or(&trial.scene.spheres);
            let spheres = options.focused(&trial)?.unwrap_or(all).clone();
            return filled(trial, &spheres, framing, legend_shares);
        }
    };
    Ok((f64::from(width) * shape).round().clamp(1.0, MAX_SIDE as f64) as u32)
}

/// The largest height of a frame's image at which the height, and not the width, decides how near the camera is.
fn filled(
    mut trial: SceneFrame,
    spheres: &Spheres,
    framing: Framing,
    legend_shares: &dyn Fn(&SceneFrame) -> Result<[f64; 2]>,
) -> Result<u32> {
    let width = trial.scene.image.width;
    let (mut low, mut high) = (1, width.saturating_mul(TALLEST).min(MAX_SIDE as u32));
    while low < high {
        let height = low + (high - low).div_ceil(2);
        trial.scene.resize([width, height]);
        // A picture that is too small for its legend is not tall enough.
        let Ok(legend_shares) = legend_shares(&trial) else {
            low = height;
            continue;
        };
        let framing = Framing { legend_shares, ..framing };
        match trial.scene.camera.is_bound_by_height(trial.scene.image, spheres, &framing)? {
            true => low = height,
            false => high = height - 1,
        }
    }
    Ok(low)
}

/// Whether a point is inside of a sphere.
fn is_inside(eye: DVec3, spheres: &Spheres) -> bool {
    let holds = |id: usize| (DVec3::from_array(spheres.centers[id]) - eye).length() <= spheres.radii[id];
    parallel::any(spheres.len(), CHEAP, &|mut ids| ids.any(holds))
}

/// The camera of a frame, whose lens is final, in the direction of the options; with a framing, it shows all spheres.
///
/// # Errors
/// Errors of [`Camera::fit`] and of the source.
pub(super) fn aimed(
    options: &CameraArgs,
    frame: &SceneFrame,
    at: Option<DVec3>,
    framing: Option<&Framing>,
    spheres: &dyn SphereSource,
) -> Result<Camera> {
    let (mut camera, image) = (frame.scene.camera, frame.scene.image);
    match options.direction_source(&camera, frame.has_camera, frame.is_molecule, at) {
        DirectionSource::Given(look, up) => (camera.look, camera.up) = (look, up),
        DirectionSource::Middle(up) => (camera.look, camera.up) = (Look::At(middle(spheres.ends()?)), up),
        DirectionSource::Axes => {
            Spread::of(spheres)?.facing(image.height > image.width).turn(&mut camera);
            camera.up = options.pose.up.unwrap_or(camera.up);
        }
    }
    framing.map_or(Ok(()), |framing| camera.fit(image, spheres, framing))?;
    Ok(camera)
}

/// The camera that shows the focus.
fn look_at_focus(
    source: &DirectionSource,
    options: &CameraArgs,
    camera: &Camera,
    image: ImagePlane,
    [focus, all]: [&Spheres; 2],
    framing: &Framing,
) -> Result<Outlook> {
    let around = Surroundings::new(image, focus, all, framing);
    let facing = match source {
        DirectionSource::Given(Look::View(view), up) => Facing { view: *view, up: *up },
        DirectionSource::Given(Look::At(at), up) => Facing { view: *at - camera.eye, up: *up },
        DirectionSource::Middle(_) | DirectionSource::Axes => {
            let found = around.least_hidden(camera)?;
            let (Some(up), Look::View(view)) = (options.pose.up, found.camera.look) else { return Ok(found) };
            Facing { view, up }
        }
    };
    around.look(facing, camera)
}

/// Words for the framing, for `halfline plan`: the spheres, the direction, the place of the legend. `None` without a
/// framing.
pub(super) fn words(options: &CameraArgs, frame: &SceneFrame, framing: Option<&Framing>) -> Option<String> {
    let framing = framing?;
    if frame.scene.camera.lens.is_panorama() {
        return Some("all around, from the middle of the spheres".to_owned());
    }
    let what = match (&options.focus, frame.marks.last()) {
        (Some(_), Some(focus)) => format!("{} ({} of the spheres)", quote(&focus.text), focus.spheres.len()),
        _ => match options.frame_share {
            Some(share) => format!("{} % of the spheres", 100.0 * share),
            None => "all spheres".to_owned(),
        },
    };
    let source = match options.direction_source(&frame.scene.camera, frame.has_camera, frame.is_molecule, framing.aim) {
        DirectionSource::Axes if options.focus.is_some() => ", from where least of it is hidden (--view auto)",
        DirectionSource::Axes => ", along its principal axes (--view auto)",
        DirectionSource::Given(..) | DirectionSource::Middle(_) => "",
    };
    let aim = if framing.aim.is_some() { ", with --at in the middle" } else { "" };
    let legend = if framing.legend_shares == [0.0; 2] { "" } else { ", beside the legend" };
    Some(format!("{what}{source}{aim}{legend}"))
}
