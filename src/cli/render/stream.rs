//! `--stream`: a scene of more spheres than fit in memory, read in blocks.

use crate::cli::camera_file;
use crate::cli::clash::check_inputs;
use crate::cli::note;
use crate::cli::scene_args::SceneArgs;
use crate::cli::scene_frames::{Numbered, aim, options, size};
use glam::DVec3;
use halfline::camera::{Camera, CameraRecord, Look};
use halfline::error::{Error, Result};
use halfline::progress::Cancel;
use halfline::quote::count;
use halfline::read::{FrameTime, ReadOptions, SceneFrame, SphereBlocks};
use halfline::render::stream::{Stream, Visible};
use halfline::scene::arrange::Arrangement;
use halfline::scene::{Framing, ImagePlane, Lighting, Reach, Scene, Skipped, Spheres, middle};
use halfline::settings::Settings;
use halfline::write::file::Target;
use std::path::{Path, PathBuf};

/// Where the scene is read.
pub(super) struct Source<'a> {
    args: &'a SceneArgs,
    options: ReadOptions,
    taken: Option<CameraRecord>,
}

impl<'a> Source<'a> {
    /// Checks the options.
    ///
    /// # Errors
    /// [`Error::Settings`] for those that need the scene in memory.
    pub(super) fn new(args: &'a SceneArgs, cancel: &Cancel) -> Result<Self> {
        let options = options(args, cancel)?;
        let refuse = |problem: &str, mend: &str| Err(Error::settings(format!("--stream: {problem}"), mend));
        if args.is_many() {
            return refuse(
                "a stream is one picture",
                "render the frames, turns or cameras one by one, or without --stream",
            );
        }
        if args.read.arrangement() != Arrangement::default() {
            return refuse(
                "copies, clip planes and the edges of a cell need the scene in memory",
                "remove --copies, --clip and --cell",
            );
        }
        let taken = args.camera.from.as_deref().map(camera_file::read).transpose()?;
        Ok(Self { args, options, taken })
    }

    /// Reads the scene: the spheres that some ray may hit, and what else belongs to the picture.
    ///
    /// # Errors
    /// Those of reading and of [`Stream`].
    pub(super) fn visible(&self, settings: &Settings, targets: &[Target]) -> Result<Numbered> {
        let inputs: Vec<PathBuf> =
            [Some(&self.args.scene), self.args.camera.from.as_ref()].into_iter().flatten().cloned().collect();
        check_inputs(targets.iter().map(Target::path), &inputs)?;
        targets.iter().try_for_each(Target::check)?;
        let mut frame = self.bare()?;
        // What a stream cannot do is found before the file is read.
        self.begin(frame.scene.clone(), settings, targets)?;
        if self.taken.is_none() {
            self.aim(&mut frame)?;
        }
        self.args.camera.zoom(&mut frame.scene)?;
        let (mut picture, mut stream) = self.begin(frame.scene, settings, targets)?;
        let mut blocks = SphereBlocks::open(&self.args.scene, &self.options)?;
        while let Some(block) = blocks.next_block()? {
            stream.add(&block)?;
        }
        let Visible { mut scene, ids } = stream.finish()?;
        let kept = count(ids.ids.len() as u64, "sphere");
        note(format_args!("{kept} of {} may be hit first and are in memory", ids.count));
        scene.skipped = blocks.skipped().clone();
        (picture.scene, picture.legend, picture.ids) = (scene, blocks.legend().cloned(), Some(ids));
        Ok(picture)
    }

    /// The picture of a scene whose spheres are still to come.
    fn begin(&self, mut scene: Scene, settings: &Settings, targets: &[Target]) -> Result<(Numbered, Stream)> {
        // The look is plain unless another is requested, which the stream refuses.
        let look = self.args.light.apply(&mut scene, &self.args.files.buffers(), self.args.look_request(false))?;
        let picture = Numbered { number: 1, scene, legend: None, look, when: FrameTime::default(), ids: None };
        let settings = self.args.settings_for(&picture, settings, targets)?;
        let stream = Stream::new(&picture.scene, &settings)?;
        Ok((picture, stream))
    }

    /// The image, and the camera as far as it does not depend on the spheres.
    fn bare(&self) -> Result<SceneFrame> {
        let (image, spheres, lighting) = (ImagePlane::default(), Spheres::default(), Lighting::default());
        let mut scene = Scene { camera: Camera::CANONICAL, image, spheres, skipped: Skipped::default(), lighting };
        scene.frame_all(&Framing::default())?;
        let mut frame =
            SceneFrame { number: 1, scene, has_camera: false, legend: None, cell: None, when: FrameTime::default() };
        size(self.args.image.size.or(self.taken.map(|record| record.size.into())), self.args, &mut frame);
        match &self.taken {
            Some(record) => frame.scene.camera = camera_file::resized(record, self.args.image.size),
            None => aim(self.args, &mut frame),
        }
        Ok(frame)
    }

    /// Frames all spheres where the options do not give the camera's place, for which the file is read twice more.
    fn aim(&self, frame: &mut SceneFrame) -> Result<()> {
        let camera = &self.args.camera;
        let framing = camera.framing(frame.has_camera)?;
        let at_middle = camera.pose.eye.is_some() && !camera.pose.looks();
        if framing.is_none() && !at_middle {
            return Ok(());
        }
        if self.args.scene == Path::new("-") {
            let problem = "--stream: the camera depends on all spheres, and standard input can be read once";
            return Err(Error::settings(problem, "give --eye and --at, or --view"));
        }
        note(format_args!(
            "the camera depends on all spheres, so the file is read first for them (see --eye and --at)"
        ));
        let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        self.each(|block| {
            let [low, high] = block.bounds();
            if bounds[0].x > bounds[1].x {
                note(format_args!(
                    "the camera depends on all spheres, so the file is read for it first (see --eye and --at)"
                ));
            }
            bounds = [bounds[0].min(low), bounds[1].max(high)];
            Ok(())
        })?;
        let middle = middle(bounds);
        if at_middle {
            frame.scene.camera.look = Look::At(middle);
        }
        let Some(framing) = framing else { return Ok(()) };
        let mut reach = Reach::about(middle);
        self.each(|block| {
            let mut part = Scene { spheres: block, ..frame.scene.clone() };
            if let Some(more) = part.reach(&framing, Some(&reach))? {
                reach = reach.with(&more);
            }
            // A point to look at has become a direction.
            frame.scene.camera = part.camera;
            Ok(())
        })?;
        frame.scene.fit_to(&framing, &reach)
    }

    fn each(&self, mut each: impl FnMut(Spheres) -> Result<()>) -> Result<()> {
        let mut blocks = SphereBlocks::open(&self.args.scene, &self.options)?;
        while let Some(block) = blocks.next_block()? {
            each(block)?;
        }
        Ok(())
    }
}
