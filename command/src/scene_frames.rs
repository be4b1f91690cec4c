//! The scenes of one command: a single one, the frames of a sequence, or the turns of `--spin`, each with the options
//! applied.

use super::camera_file;
use super::framing;
use super::legend;
use super::messages::warn;
use super::picture_scene::PictureScene;
use super::read_args::ReadArgs;
use super::scene_args::SceneArgs;
use super::signals::watch;
use glam::{DQuat, DVec3};
use halfline::camera::{Aperture, Camera, CameraRecord, Look};
use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::progress::Cancel;
use halfline::quote;
use halfline::scene::arrange::Arrangement;
use halfline::scene::{Framing, Reach, Scene};
use halfline::settings::Settings;
use halfline_files::read::style::{Coloring, GatheredValues, RangeEnd, Scale};
use halfline_files::read::{
    FixedCamera, FrameRange, Hold, Keep, ParticleOptions, ReadOptions, SceneFrame, Sequence, read_once,
};
use std::collections::HashSet;
use std::path::PathBuf;

/// Iterates over the scenes.
pub(super) struct SceneFrames<'a> {
    args: &'a SceneArgs,
    sequence: Sequence,
    /// The number of scenes so far.
    count: u32,
    /// The scene that `--spin` shows from all sides.
    standing: Option<SceneFrame>,
    /// The camera that all frames have, and the point that it turns about.
    common: FixedCamera,
    /// Whether the colour of pictures is computed.
    has_picture: bool,
    /// The camera and the size of the picture that they are taken from.
    taken: Option<CameraRecord>,
    /// Words for the spheres that the last framed camera shows, for `halfline plan`; `None` for a camera that is given.
    framed: Option<String>,
    /// The columns, and the rows that the spheres of the last framed camera fill.
    open: Option<(u32, u32)>,
}

/// The options for reading.
///
/// # Errors
/// [`Error::Settings`] for options of the camera or of the colours that exclude each other.
pub(super) fn options(args: &SceneArgs, cancel: &Cancel) -> Result<ReadOptions> {
    args.camera.check()?;
    args.check_picture_size()?;
    let mut options = args.color.of(args.read.options())?;
    options.marks = args.camera.marks();
    options.particles.watch = options.particles.watch.cancelled_by(cancel);
    options.particles.skip_invalid = args.skip_invalid;
    Ok(options)
}

impl<'a> SceneFrames<'a> {
    /// Opens the scene file for frames with these settings; `cancel` ends the reading of frames.
    pub(super) fn open(args: &'a SceneArgs, settings: &Settings, cancel: &Cancel) -> Result<Self> {
        args.camera.list.listed()?;
        let taken = args.camera.from.as_deref().map(camera_file::read).transpose()?;
        let mut common = FixedCamera::new(args.read.frames.is_some() && args.read.hold != Hold::None);
        let (sequence, fixed) = sequence(args, Keep::Nothing, None, cancel)?;
        (common.camera, common.middle) = fixed.unzip();
        if let Some(record) = &taken {
            common.camera = Some(camera_file::resized(record, args.size()));
        }
        let has_picture = settings.aovs.contains(&Aov::Color) || args.is_figure();
        Ok(Self { args, sequence, count: 0, standing: None, common, has_picture, taken, framed: None, open: None })
    }

    /// Every file that is read.
    pub(super) fn inputs(&self) -> Vec<PathBuf> {
        let scene = [self.args.path().to_path_buf()].into_iter();
        scene
            .chain(self.sequence.files().iter().cloned())
            .chain(self.args.camera.from.clone())
            .chain(self.args.camera.list.file.clone())
            .collect()
    }

    /// The next scene; `None` after the last.
    pub(super) fn next_frame(&mut self) -> Result<Option<PictureScene>> {
        let (camera, count) = (&self.args.camera, self.count);
        self.count += 1;
        let turns = camera.turns().filter(|_| self.args.read.frames.is_none());
        let frame = match turns {
            Some(turns) if count >= turns => return Ok(None),
            Some(_) => {
                if self.standing.is_none() {
                    self.standing = self.sequence.next_scene()?;
                }
                let standing = self.standing.as_mut().map(SceneFrame::copy);
                standing.map(|frame| SceneFrame { number: u64::from(count) + 1, ..frame })
            }
            None => {
                if let Some(mut first) = self.sequence.unselected_first()? {
                    self.prepare(&mut first)?;
                }
                self.sequence.next_scene()?
            }
        };
        let Some(mut frame) = frame else {
            let last = self.args.read.frames.as_ref().map_or(0, FrameRange::last);
            if let Some(total) = self.sequence.total().filter(|total| (1..last).contains(total) && last < u64::MAX) {
                warn([format!(
                    "the file has {}, and --frames asks for others behind them",
                    quote::count(total, "frame")
                )]);
            }
            return if count == 0 { Err(self.sequence.nothing()) } else { Ok(None) };
        };
        self.prepare(&mut frame)?;
        let listed = camera.list.aperture(frame.number)?;
        let taken = self.taken.and_then(|record| record.lens_size()).or(listed);
        let turn = |frame: &mut SceneFrame| {
            let Some(turns) = camera.spin else { return };
            let scene = &mut frame.scene;
            // The angle depends on the number only, so a frame rendered alone equals the same frame of the sequence.
            let middle = self.common.middle.unwrap_or_else(|| scene.spheres.middle());
            spin(scene, middle, (frame.number - 1) as f64 / f64::from(turns.get()));
        };
        let picture = light(self.args, frame, self.has_picture, taken, turn)?;
        Ok(Some(PictureScene { framed: self.framed.clone(), ..picture }))
    }

    /// Applies the options to the scene of a frame. The first frame sets the camera of the others.
    fn prepare(&mut self, frame: &mut SceneFrame) -> Result<()> {
        let (args, image) = (self.args, self.args.size().or(self.taken.map(|record| record.size.into())));
        let is_listed = args.camera.list.file.is_some();
        size(image, args, frame);
        if !is_listed {
            let open = &mut self.open;
            let see = |whole: &mut SceneFrame| {
                point(args, whole)?;
                *open = args.open_width().map(|width| (width, whole.scene.image.height));
                Ok(())
            };
            self.common.see(frame, &args.read.arrangement(), &watch(), see)?;
        }
        // All frames that share a camera have the height of the first.
        if let Some((width, height)) = self.open.filter(|_| self.common.camera.is_some()) {
            frame.scene.resize([width, height]);
        }
        arrange(&args.read, frame)?;
        if is_listed {
            args.camera.list.apply(frame.number, args.size(), args.camera.lens_of_list(), &mut frame.scene)?;
        } else {
            // A later frame of a film may have nothing of what the first one is turned about.
            if self.common.middle.is_none() {
                self.common.middle = args.camera.pivot(frame)?;
            }
            let (framed, open) = (&mut self.framed, &mut self.open);
            self.common.apply(frame, |frame| {
                let framing = point(args, frame)?;
                *open = args.open_width().map(|width| (width, frame.scene.image.height));
                *framed = framing::words(&args.camera, frame, framing.as_ref());
                Ok(())
            })?;
        }
        args.camera.zoom(&mut frame.scene)
    }
}

/// Opens the scene file with the options for reading, for its frames from `from` on, or else for the frames of `--frames`.
/// Returns also the camera and the middle of the spheres that all frames share under `--hold all`.
///
/// # Errors
/// Errors of [`options`], of opening the file and, under `--hold all`, of reading its frames.
pub(super) fn sequence(
    args: &SceneArgs,
    keep: Keep,
    from: Option<u64>,
    cancel: &Cancel,
) -> Result<(Sequence, Option<(Camera, DVec3)>)> {
    let needs_columns =
        args.insets.has_marks() || args.cut.selects() || !args.files.cryptomatte.is_empty() || args.is_figure();
    let keep = match keep {
        Keep::Nothing if needs_columns => Keep::All,
        keep => keep,
    };
    let mut options = options(args, cancel)?;
    options.particles.keep = keep;
    if let Some(from) = from {
        options.particles.frames = format!("{from}-").parse()?;
    }
    let holds_all = options.hold == Hold::All && args.read.frames.is_some();
    let fixed = if holds_all { hold_all(args, &mut options)? } else { None };
    Ok((Sequence::open(args.path(), &options)?, fixed))
}

/// The picture of a frame that was arranged, with its size and a camera: the camera of `record`, or `fixed` of all frames, or by the
/// options.
///
/// # Errors
/// Errors of the camera, of the lens, of the light and of the legend.
pub(super) fn framed(
    args: &SceneArgs,
    mut frame: SceneFrame,
    record: Option<&CameraRecord>,
    fixed: Option<Camera>,
) -> Result<PictureScene> {
    size(args.size().or(record.map(|record| record.size.into())), args, &mut frame);
    match record.map(|record| camera_file::resized(record, args.size())).or(fixed) {
        Some(camera) => frame.scene.camera = camera,
        None => drop(point(args, &mut frame)?),
    }
    args.camera.zoom(&mut frame.scene)?;
    light(args, frame, true, record.and_then(CameraRecord::lens_size), |_| ())
}

/// The picture of a frame that was arranged, with the size and the eye that the options give.
///
/// # Errors
/// Errors of the camera, of the lens, of the light and of the legend.
pub(super) fn posed(args: &SceneArgs, mut frame: SceneFrame, taken: Option<Aperture>) -> Result<PictureScene> {
    size(args.size(), args, &mut frame);
    framing::point(&args.camera, &mut frame, [0.0; 2])?;
    light(args, frame, true, taken, |_| ())
}

/// The picture of a frame whose camera is final but for a turn: with its lens and its light, and with the buffers of the options.
fn light(
    args: &SceneArgs,
    frame: SceneFrame,
    has_picture: bool,
    taken: Option<Aperture>,
    turn: impl FnOnce(&mut SceneFrame),
) -> Result<PictureScene> {
    let mut picture = with_light(args, frame, (has_picture, &args.files.buffers()), taken, turn)?;
    legend::check_content(args, args.color.color_by.as_deref(), &mut picture)?;
    Ok(picture)
}

/// The picture of a frame whose camera is final but for a turn: with its lens and its light. It says whether its colour is computed, and
/// which buffers are.
pub(super) fn with_light(
    args: &SceneArgs,
    mut frame: SceneFrame,
    (has_picture, aovs): (bool, &[Aov]),
    taken: Option<Aperture>,
    turn: impl FnOnce(&mut SceneFrame),
) -> Result<PictureScene> {
    let request = args.look_request(frame.look, has_picture);
    let has_samples = request.samples.or(request.file.samples).is_some();
    let lens = args.camera.lens.lens(&frame, taken, has_samples)?;
    turn(&mut frame);
    if let Some(pixels) = args.image.least_size {
        let enlarged = frame.scene.enlarge_to(pixels)?;
        let all = frame.scene.spheres.len();
        let warning = || format!("{enlarged} of {all} spheres are enlarged to {pixels} pixels, in every buffer");
        frame.skipped.assumed.extend((enlarged > 0).then(warning));
    }
    frame.cut(&args.cut.rules())?;
    let hidden = match frame.scene.spheres.cuts {
        Some(_) => framing::hidden_when_cut(&args.camera, &frame)?,
        None => frame.hidden.take(),
    };
    frame.skipped.assumed.extend(hidden);
    // The light from above left belongs to the final camera.
    let look = args.light.apply(&mut frame, aovs, request, lens)?;
    let (marked, notes) = frame.marked(&args.insets.marks())?;
    frame.skipped.assumed.extend(notes);
    let mattes = frame.matte_names(&args.files.cryptomatte)?;
    let path_names = if args.is_figure() { frame.path_names(args.figure.groups())? } else { Vec::new() };
    let SceneFrame { number, scene, skipped, legend, when, beads, .. } = frame;
    Ok(PictureScene {
        number,
        beads,
        skipped,
        legend,
        when,
        marked,
        mattes,
        path_names,
        ..PictureScene::bare(scene, look)
    })
}

/// The camera that shows all frames of the file, and the middle of the first; their default radius and range of colours
/// are set in `options`.
fn hold_all(args: &SceneArgs, options: &mut ReadOptions) -> Result<Option<(Camera, DVec3)>> {
    if let Some(once) = read_once(args.path()) {
        let problem = format!("--hold all reads the file twice, and {once} can be read once");
        return Err(Error::settings(problem, format!("use --hold first, or a file instead of {once}")));
    }
    if let Coloring::Column(scale) = &mut options.style.coloring {
        scale.gathered = scale.has_percentile().then(GatheredValues::default);
    }
    let mut all = AllFrames::read(args, options, [0.0; 2])?;
    if let Coloring::Column(scale) = &mut options.style.coloring {
        scale.settle_range();
        scale.range = scale.range.or(all.range.map(|ends| ends.map(RangeEnd::Value)));
        scale.names = std::mem::take(&mut all.names);
    }
    if all.legend_shares != [0.0; 2] {
        // The legend of all frames is known only now, and the spheres are framed beside it.
        let legend_shares = all.legend_shares;
        all = AllFrames::read(args, options, legend_shares)?;
    }
    let Some((mut first, framing)) = all.first else { return Ok(None) };
    if let (Some(framing), Some(reach)) = (framing, all.reach) {
        first.scene.camera.fit_to(first.scene.image, &framing, &reach)?;
    }
    let pivot = args.camera.pivot(&first)?;
    Ok(Some((first.scene.camera, pivot.unwrap_or_else(|| first.scene.spheres.middle()))))
}

/// The results of a pass over all frames of a file, for `--hold all`: framing, range and names of the colours, legend.
#[derive(Default)]
struct AllFrames {
    /// The first frame with spheres, whose camera has the direction and the lens of all, and how it is framed.
    first: Option<(SceneFrame, Option<Framing>)>,
    reach: Option<Reach>,
    range: Option<[f64; 2]>,
    names: Vec<String>,
    /// The shares of the image's width that the widest legend takes at the left and at the right.
    legend_shares: [f64; 2],
}

impl AllFrames {
    /// Reads all frames, to be framed with this part of the width free.
    fn read(args: &SceneArgs, options: &ReadOptions, legend_shares: [f64; 2]) -> Result<Self> {
        let each = ReadOptions {
            particles: ParticleOptions { frames: "1-".parse()?, ..options.particles.clone() },
            ..options.clone()
        };
        let mut sequence = Sequence::open(args.path(), &each)?;
        let (mut all, mut known) = (Self::default(), HashSet::new());
        loop {
            let mut frame = match sequence.next_scene() {
                Ok(Some(frame)) => frame,
                Ok(None) => break,
                // A frame that is not shown may lack the columns of those that are.
                Err(Error::Settings { .. }) if !options.particles.frames.contains(sequence.passed()) => continue,
                Err(error) => return Err(error),
            };
            if frame.scene.spheres.is_empty() {
                continue;
            }
            if let Coloring::Column(Scale { gathered: Some(gathered), .. }) = &options.style.coloring {
                gathered.check()?;
            }
            size(args.size(), args, &mut frame);
            if let Some(legend) = &mut frame.legend {
                all.names.extend(legend.names.iter().filter(|name| known.insert((*name).clone())).cloned());
                if legend.is_scale() {
                    let [low, high] = all.range.unwrap_or(legend.range);
                    legend.range = [low.min(legend.range[0]), high.max(legend.range[1])];
                    all.range = Some(legend.range);
                }
            }
            let shares = args.insets.legend_shares(&frame)?;
            all.legend_shares.iter_mut().zip(shares).for_each(|(widest, share)| *widest = widest.max(share));
            arrange(&args.read, &mut frame)?;
            if !frame.scene.spheres.is_empty() {
                all.add(args, frame, legend_shares)?;
            }
        }
        Ok(all)
    }

    fn add(&mut self, args: &SceneArgs, mut frame: SceneFrame, legend_shares: [f64; 2]) -> Result<()> {
        let framing = match &self.first {
            Some((first, framing)) => {
                frame.scene.camera = first.scene.camera;
                *framing
            }
            None => framing::point(&args.camera, &mut frame, legend_shares)?,
        };
        let (image, mut camera) = (frame.scene.image, frame.scene.camera);
        if let Some(framing) = &framing {
            // A later frame may have nothing of a focus.
            let focus = frame.marks.last().filter(|_| args.camera.focus.is_some());
            let central = args.camera.central(&frame.scene.spheres);
            let all = central.as_ref().unwrap_or(&frame.scene.spheres);
            let spheres = focus.map_or(all, |focus| &focus.spheres);
            if let Some(reach) = camera.reach(image, spheres, framing, self.reach.as_ref())? {
                self.reach = Some(self.reach.map_or(reach, |all| all.with(&reach)));
            }
        }
        self.first.get_or_insert((frame, framing));
        Ok(())
    }
}

/// Gives a frame the camera of the options, beside the legend, and an open height. Returns how it is framed, if it is.
fn point(args: &SceneArgs, frame: &mut SceneFrame) -> Result<Option<Framing>> {
    if let Some(width) = args.open_width() {
        let height = framing::filled_height(&args.camera, frame, width, &|frame| args.insets.legend_shares(frame))?;
        frame.scene.resize([width, height]);
    }
    let legend_shares = args.insets.legend_shares(frame)?;
    framing::point(&args.camera, frame, legend_shares)
}

/// Applies the size of the image, for which the file's lens is made again, and its background.
pub(super) fn size(size: Option<(u32, u32)>, args: &SceneArgs, frame: &mut SceneFrame) {
    if let Some((width, height)) = size {
        frame.scene.resize([width, height]);
    }
    args.files.apply(&mut frame.scene);
}

/// Applies copies, clip planes and outline.
pub(super) fn arrange(read: &ReadArgs, frame: &mut SceneFrame) -> Result<()> {
    let arrangement = read.arrangement();
    frame.arrange(&arrangement, &watch())?;
    // The spheres that are looked at are in the file itself, as far as it is drawn, not in its copies.
    let clip = Arrangement { clip: arrangement.clip, ..Arrangement::default() };
    frame.marks.iter_mut().try_for_each(|mark| clip.apply(&mut mark.spheres, None, &watch()))
}

/// Rotates the camera about the up axis through a point, by a share of a full turn.
fn spin(scene: &mut Scene, middle: DVec3, share: f64) {
    let camera = &mut scene.camera;
    let Some(axis) = camera.up.try_normalize() else { return };
    if share == 0.0 {
        return;
    }
    let turn = DQuat::from_axis_angle(axis, std::f64::consts::TAU * share);
    let look = match camera.look {
        Look::At(at) => at - camera.eye,
        Look::View(view) => view,
    };
    camera.look = Look::View(turn * look);
    camera.eye = middle + turn * (camera.eye - middle);
}
