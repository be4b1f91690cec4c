//! A scene that is read in blocks: for `--stream` because it does not fit in memory, for `halfline sift` because it is a part.

mod refused;

use crate::camera_args::CameraTarget;
use crate::camera_file;
use crate::framing::{DirectionSource, aimed, none_selected};
use crate::legend;
use crate::lens_args::PictureLens;
use crate::messages::note;
use crate::picture_scene::PictureScene;
use crate::read_args::ReadArgs;
use crate::render::picture::writable_targets;
use crate::scene_args::SceneArgs;
use crate::scene_frames::{options, size};
use glam::DVec3;
use halfline::camera::CameraRecord;
use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::frame::legend::Legend;
use halfline::progress::Cancel;
use halfline::quote::count;
use halfline::render::stream::{Part, Stream, Visible};
use halfline::scene::arrange::Arrangement;
use halfline::scene::instances::{CopiedSpheres, Instances};
use halfline::scene::{SphereSource, Spheres};
use halfline::settings::{FileLook, Settings};
use halfline_files::read::style::{Coloring, RangeEnd};
use halfline_files::read::{
    Focus, FrameTime, Hold, ParticleOptions, ReadOptions, SceneFrame, Sequence, Skipped, SphereBlocks, all_clipped,
    read_once,
};
use halfline_files::write::file::Target;
use std::cell::{Cell, RefCell};
use std::path::{Path, PathBuf};

/// The mend for a camera that depends on the spheres of other frames.
const CAMERA: &str = "give --eye and --at with numbers, or --eye and --view";

/// A scene that is read as a stream: its file, and the options of every pass through it.
pub(crate) struct Source<'a> {
    args: &'a SceneArgs,
    /// The number of its frame, from 1.
    number: u64,
    options: ReadOptions,
    taken: Option<CameraRecord>,
    arrangement: Arrangement,
    /// The scene of a scene file without spheres, and the files that it refers to.
    scene: Option<(SceneFrame, Vec<PathBuf>)>,
    /// The reason for a stream that was not requested, and whether it was printed.
    why: Option<String>,
    is_explained: Cell<bool>,
    /// Notes on the selection of `--at`, which become warnings of the picture.
    notes: Vec<String>,
}

/// A scene that is copies of spheres in memory.
struct InstancedScene {
    instances: Instances,
    /// The number of spheres of the file.
    whole: u64,
    facts: SceneFacts,
    /// The spheres of the file, not their copies, that are looked at.
    marks: Vec<Focus>,
}

/// All spheres of a file.
struct FileSpheres<'a> {
    source: &'a Source<'a>,
    /// The corners of the box around them.
    ends: [DVec3; 2],
}

impl SphereSource for FileSpheres<'_> {
    fn each(&self, visit: &mut dyn FnMut(&Spheres) -> Result<()>) -> Result<()> {
        self.source.each(|block| visit(&block)).map(drop)
    }

    fn ends(&self) -> Result<[DVec3; 2]> {
        Ok(self.ends)
    }
}

/// The spheres of a file that `--at` selects.
struct MarkedSpheres<'a> {
    source: &'a Source<'a>,
    /// The number of all spheres of the file, and the notes on the selection, once they were visited.
    drawn: Cell<u64>,
    notes: RefCell<Vec<String>>,
}

impl SphereSource for MarkedSpheres<'_> {
    fn each(&self, visit: &mut dyn FnMut(&Spheres) -> Result<()>) -> Result<()> {
        let (mut drawn, mut selected) = (0, 0);
        let blocks = self.source.read(self.source.blocks_of_places()?, |block, marks| {
            drawn += block.len() as u64;
            selected += marks.iter().map(Spheres::len).sum::<usize>();
            marks.iter().try_for_each(&mut *visit)
        })?;
        if self.drawn.replace(drawn) == 0 && selected > 0 {
            note(format_args!("the camera depends on the spheres that --at selects, so the file is read for it twice"));
        }
        self.notes.replace(blocks.mark_notes().concat());
        Ok(())
    }
}

/// Facts about a scene that are known after its last sphere was read.
struct SceneFacts {
    skipped: Skipped,
    legend: Option<Legend>,
    when: FrameTime,
    is_molecule: bool,
}

impl SceneFacts {
    /// The facts from blocks that were read to the end.
    fn of(blocks: &SphereBlocks) -> Self {
        let (skipped, legend) = (blocks.skipped().clone(), blocks.legend());
        Self { skipped, legend, when: blocks.when(), is_molecule: blocks.is_molecule() }
    }
}

impl<'a> Source<'a> {
    /// Checks the options. `why` is said when the first block was read.
    ///
    /// # Errors
    /// [`Error::Settings`] for those that need the scene in memory.
    pub(crate) fn new(args: &'a SceneArgs, cancel: &Cancel, why: Option<String>) -> Result<Self> {
        let options = options(args, cancel)?;
        args.camera.list.listed()?;
        let number = args.read.frames.as_ref().and_then(|frames| frames.numbers().next()).unwrap_or(1);
        let taken = args.camera.from.as_deref().map(camera_file::read).transpose()?;
        let arrangement = args.read.arrangement();
        refused::check(args, number, taken.as_ref())?;
        let scene = SphereBlocks::scene(args.path(), &options)?;
        let is_explained = Cell::new(false);
        Ok(Self { args, number, options, taken, arrangement, scene, why, is_explained, notes: Vec::new() })
    }

    /// Every file that is read.
    pub(crate) fn inputs(&self) -> Vec<PathBuf> {
        let named = self.scene.iter().flat_map(|(_, files)| files.iter().map(PathBuf::as_path));
        let camera = &self.args.camera;
        let cameras = [camera.from.as_deref(), camera.list.file.as_deref()];
        let all = [Some(self.args.path())].into_iter().chain(cameras).flatten().chain(named);
        all.map(Path::to_path_buf).collect()
    }

    /// Reads the scene: the spheres that some ray may hit, and what else belongs to the picture.
    ///
    /// # Errors
    /// Errors of the output files, of reading and of [`Stream`].
    pub(super) fn visible(mut self, settings: &Settings) -> Result<PictureScene> {
        let targets = &writable_targets(self.args, self.number, &self.inputs())?;
        let mut frame = self.bare()?;
        // What a stream cannot do is found before the file is read.
        let (bare, own) = self.begin(frame.clone(), settings, targets)?;
        Stream::new(&bare.scene, &own)?;
        let request = self.args.look_request(FileLook::PARTICLES, settings.aovs.contains(&Aov::Color));
        let is_soft = self.scene.is_none() && self.args.light.would_be_soft(request);
        if is_soft && self.why.is_some() {
            if !self.is_copied() {
                self.blocks_of_places()?;
            }
            let problem = "the light of the look soft needs all spheres in memory".to_owned();
            return Err(Error::Limits { problem, mend: "add --look plain: the file is then read as a stream".into() });
        }
        let copied = self.copied()?;
        let framed = self.aim(&mut frame, copied.as_ref())?;
        if copied.is_none() && self.lacks_range() {
            self.check_own("the range of colours", "add --range LOW,HIGH")?;
            self.check_repeatable("the range of colours depends on all particles", "add --range LOW,HIGH")?;
            self.survey(
                "the range of colours depends on all particles, so the file is read for it first (see --range)",
            )?;
        }
        let (mut picture, own) = self.begin(frame, settings, targets)?;
        let mut stream = Stream::new(&picture.scene, &own)?;
        let (visible, mut facts) = match copied {
            Some(InstancedScene { instances, whole, mut facts, .. }) => {
                if self.arrangement.clip.is_empty() {
                    targets.iter().try_for_each(|target| target.check_ids(instances.total()))?;
                }
                let visible = Stream::of_instances(&picture.scene, &own, &instances, &self.options.particles.watch)?;
                if visible.ids.count == 0 && whole > 0 {
                    facts.skipped.assumed.push(all_clipped(whole));
                }
                (visible, facts)
            }
            None => {
                let facts = self.each(|block| stream.add(&block))?;
                (stream.finish()?, facts)
            }
        };
        let Visible { scene, ids } = visible;
        targets.iter().try_for_each(|target| target.check_ids(ids.count))?;
        let kept = count(ids.ids.len() as u64, "sphere");
        note(format_args!("{kept} of {} may be hit first and are in memory", ids.count));
        if ids.are_wide() && targets.iter().any(|target| target.aovs().contains(&Aov::Id)) {
            note(format_args!("ids are int64: {} spheres are more than 32 bits can number", ids.count));
        }
        if is_soft {
            note(format_args!(
                "look plain: a stream is lit from the eye, because lights and a sky need all spheres in memory"
            ));
        }
        facts.skipped.assumed.append(&mut picture.skipped.assumed);
        facts.skipped.assumed.append(&mut self.notes);
        (picture.legend, picture.when) = (facts.legend, facts.when);
        let framed = framed.then(|| "all spheres".to_owned());
        let mut picture = PictureScene { scene, skipped: facts.skipped, framed, ids: Some(ids), ..picture };
        legend::check_content(self.args, self.args.color.color_by.as_deref(), &mut picture)?;
        Ok(picture)
    }

    /// Reads a part of a scene, whose spheres have the ids from `first_id` on. Returns what a frame needs of it, what is to be said
    /// about its spheres, and whether the camera frames them alone.
    ///
    /// # Errors
    /// Errors of reading and of [`Stream`]; [`Error::Settings`] for options that depend on the spheres of other parts.
    pub(crate) fn part(mut self, settings: &Settings, first_id: u64) -> Result<(Part, Vec<String>, bool)> {
        let refused = [
            (self.is_copied(), "the ids of copies depend on all spheres", "remove --copies and --assembly"),
            (self.lacks_range(), "--color-by: the range of colours depends on all parts", "add --range LOW,HIGH"),
            (!self.options.marks.is_empty(), "what --at selects depends on all parts", "give --at a point"),
        ];
        if let Some((_, problem, mend)) = refused.into_iter().find(|(is_given, ..)| *is_given) {
            return Err(Error::settings(problem, mend));
        }
        let mut frame = self.bare()?;
        let framed = self.aim(&mut frame, None)?;
        let (picture, settings) = self.begin(frame, settings, &[])?;
        let mut stream = Stream::of_part(&picture.scene, &settings, first_id)?;
        let facts = self.each(|block| stream.add(&block))?;
        Ok((stream.part()?, facts.skipped.warnings(), framed))
    }

    /// The picture of a scene whose spheres are still to come, and the settings of its frame.
    fn begin(
        &self,
        mut frame: SceneFrame,
        settings: &Settings,
        targets: &[Target],
    ) -> Result<(PictureScene, Settings)> {
        // The look of particles is plain unless another is requested, which the stream refuses.
        let file = if frame.has_camera { frame.look } else { FileLook::default() };
        let request = self.args.look_request(file, settings.aovs.contains(&Aov::Color));
        // What the file leaves out is counted while its spheres are read.
        frame.skipped = Skipped::default();
        let look = self.args.light.apply(&mut frame, &self.args.files.buffers(), request, PictureLens::default())?;
        frame.cut_later(&self.args.cut.rules())?;
        let (number, skipped) = (self.number, frame.skipped);
        let picture = PictureScene { number, skipped, ..PictureScene::bare(frame.scene, look) };
        let settings = self.args.settings_for(&picture, settings, targets)?;
        Ok((picture, settings))
    }

    /// The image, and the camera as far as it does not depend on the spheres.
    fn bare(&self) -> Result<SceneFrame> {
        let mut frame = match &self.scene {
            Some((frame, _)) => frame.clone(),
            None => SceneFrame::of_particles(1, Spheres::default(), false)?,
        };
        size(self.args.size().or(self.taken.map(|record| record.size.into())), self.args, &mut frame);
        let camera = &self.args.camera;
        match &self.taken {
            Some(record) => frame.scene.camera = camera_file::resized(record, self.args.size()),
            None if camera.list.file.is_some() => {
                camera.list.apply(self.number, self.args.size(), camera.lens_of_list(), &mut frame.scene)?;
            }
            None => camera.apply_lens(&mut frame.scene.camera, frame.scene.image)?,
        }
        refused::check_frame(&frame, camera.lens.is_named())?;
        Ok(frame)
    }

    /// Directs the camera, unless it was taken or is one of a list, and frames all spheres where the options do not give its place, for which the
    /// file is read twice more, and once more for its principal axes. Returns whether they are framed.
    fn aim(&mut self, frame: &mut SceneFrame, copied: Option<&InstancedScene>) -> Result<bool> {
        let camera = &self.args.camera;
        if self.taken.is_some() || camera.list.file.is_some() {
            return camera.zoom(&mut frame.scene).map(|()| false);
        }
        let at = self.looked_at(copied)?;
        // The passes that follow need not look for them.
        self.options.marks.clear();
        let mut framing = camera.framing(frame.has_camera, at, [0.0; 2])?;
        let source = camera.direction_source(&frame.scene.camera, frame.has_camera, frame.is_molecule, at);
        let is_given = framing.is_none() && matches!(source, DirectionSource::Given(..));
        if !is_given {
            self.check_own("the camera", CAMERA)?;
        }
        let spheres: Box<dyn SphereSource + '_> = match copied {
            Some(InstancedScene { instances, facts, .. }) => {
                (frame.is_molecule, frame.legend) = (facts.is_molecule, facts.legend.clone());
                Box::new(CopiedSpheres { instances, watch: &self.options.particles.watch })
            }
            None if is_given => Box::new(Spheres::default()),
            None => {
                self.check_repeatable("the camera depends on all spheres", "give --eye and --at, or --view")?;
                let why = "the camera depends on all spheres, so the file is read for it first (see --eye and --at)";
                let (ends, facts) = self.survey(why)?;
                (frame.is_molecule, frame.legend) = (facts.is_molecule, facts.legend);
                Box::new(FileSpheres { source: self, ends })
            }
        };
        if let Some(framing) = &mut framing {
            framing.legend_shares = self.args.insets.legend_shares(frame)?;
        }
        frame.scene.camera = aimed(camera, frame, at, framing.as_ref(), &*spheres)?;
        camera.zoom(&mut frame.scene).map(|()| framing.is_some())
    }

    /// The point to look at: the point of `--at`, or the mean of the centres of the spheres that it selects, for which the file is read
    /// twice.
    fn looked_at(&mut self, copied: Option<&InstancedScene>) -> Result<Option<DVec3>> {
        let text = match &self.args.camera.pose.at {
            None => return Ok(None),
            Some(CameraTarget::Point(at)) => return Ok(Some(*at)),
            Some(CameraTarget::Selected(selection)) => selection.to_string(),
        };
        self.check_own("the camera", CAMERA)?;
        let (at, drawn) = match copied {
            Some(InstancedScene { marks, instances, .. }) => {
                self.notes = marks.iter().flat_map(|mark| mark.notes.clone()).collect();
                (marks.first().map_or(Ok(None), |mark| mark.spheres.mean())?, instances.total())
            }
            None => {
                self.check_repeatable("the camera depends on the spheres that --at selects", "give --at a point")?;
                let marked = MarkedSpheres { source: self, drawn: Cell::default(), notes: RefCell::default() };
                let (at, drawn) = (marked.mean()?, marked.drawn.get());
                self.notes = marked.notes.take();
                (at, drawn)
            }
        };
        // An empty scene has nothing to look at.
        match at {
            None if drawn > 0 => Err(none_selected("--at", &text, &self.notes, drawn)),
            at => Ok(at),
        }
    }

    /// The blocks of the file for their places, without colours.
    fn blocks_of_places(&self) -> Result<SphereBlocks> {
        SphereBlocks::survey(self.args.path(), &self.options)
    }

    /// Returns an error where other frames than the one that is read give the film `what`.
    fn check_own(&self, what: &str, mend: &str) -> Result<()> {
        let ReadArgs { frames, hold, .. } = &self.args.read;
        let of = match hold {
            _ if frames.is_none() => return Ok(()),
            Hold::First if self.number > 1 => "the first frame",
            Hold::All => "all frames",
            Hold::First | Hold::None => return Ok(()),
        };
        let problem = format!("--stream: {what} depends on {of} of the file (see --hold), and one frame is read");
        Err(Error::settings(problem, format!("{mend}, or use --hold none")))
    }

    /// Returns an error for an input that can be read once.
    fn check_repeatable(&self, why: &str, mend: &str) -> Result<()> {
        let Some(once) = read_once(self.args.path()) else { return Ok(()) };
        Err(Error::settings(format!("--stream: {why}, and {once} can be read once"), mend))
    }

    /// The box around all spheres of the file, and what else is known of them. The same pass finds the range of the colours,
    /// where it is not given. `why` is said when the first block was read.
    fn survey(&mut self, why: &str) -> Result<([DVec3; 2], SceneFacts)> {
        let (mut bounds, mut why) = ([DVec3::INFINITY, DVec3::NEG_INFINITY], Some(why));
        let blocks = self.read(self.blocks_of_places()?, |block, _| {
            if let Some(why) = why.take() {
                note(format_args!("{why}"));
            }
            let [low, high] = block.bounds();
            bounds = [bounds[0].min(low), bounds[1].max(high)];
            Ok(())
        })?;
        if let Coloring::Column(scale) = &mut self.options.style.coloring {
            // Where no value is a number, any range gives the same colours.
            let range = scale.known_range().or(blocks.range()).unwrap_or([0.0, 1.0]);
            scale.range = Some(range.map(RangeEnd::Value));
        }
        Ok((bounds, SceneFacts::of(&blocks)))
    }

    /// Whether the range of the colours is over all particles and not known yet.
    fn lacks_range(&self) -> bool {
        matches!(&self.options.style.coloring, Coloring::Column(scale) if scale.known_range().is_none())
    }

    fn is_assembly(&self) -> bool {
        self.options.particles.assembly.is_some() && self.options.particles.topology.is_none()
    }

    fn is_copied(&self) -> bool {
        self.arrangement.copies != [1; 3] || self.is_assembly()
    }

    /// Reads into memory the spheres that `--copies` or the operators of an assembly repeat, but not their copies;
    /// `None` without either option.
    fn copied(&self) -> Result<Option<InstancedScene>> {
        if !self.is_copied() {
            return Ok(None);
        }
        let options = ReadOptions {
            particles: ParticleOptions { as_operators: self.is_assembly(), ..self.options.particles.clone() },
            ..self.options.clone()
        };
        let mut sequence = Sequence::open(self.args.path(), &options)?;
        let SceneFrame {
            mut scene, skipped, has_camera, legend, cell, instances, when, is_molecule, mut marks, ..
        } = sequence.next_scene()?.ok_or_else(|| sequence.nothing())?;
        if has_camera {
            let mend = "remove --stream, or use a file of particles";
            return Err(Error::settings("--stream: a scene with a camera of its own is in memory", mend));
        }
        scene.spheres.share();
        let whole = instances.as_ref().map_or(scene.spheres.len() as u64, Instances::total);
        let instances = match instances.filter(|_| self.arrangement.copies == [1; 3]) {
            Some(instances) => instances.clipped(&self.arrangement.clip),
            None => self.arrangement.copies(&scene.spheres, cell.as_ref())?,
        };
        // A stream that was not requested keeps 32-bit ids, and ends in a reasonable time.
        if self.why.is_some() && instances.are_wide() {
            let problem = format!("{} spheres are more than 32-bit ids can number", instances.total());
            return Err(Error::Limits { problem, mend: "add --stream; ids are then int64".into() });
        }
        self.say_why();
        marks.iter_mut().try_for_each(|mark| self.clip(&mut mark.spheres))?;
        Ok(Some(InstancedScene { instances, whole, facts: SceneFacts { skipped, legend, when, is_molecule }, marks }))
    }

    /// Says once why the scene is a stream.
    fn say_why(&self) {
        if let Some(why) = self.why.as_ref().filter(|_| !self.is_explained.replace(true)) {
            note(format_args!("{why}"));
        }
    }

    /// Every block of the file.
    fn each(&self, mut each: impl FnMut(Spheres) -> Result<()>) -> Result<SceneFacts> {
        let mut left = 0;
        let blocks = self.read(SphereBlocks::open(self.args.path(), &self.options)?, |block, _| {
            left += block.len();
            each(block)
        })?;
        let mut facts = SceneFacts::of(&blocks);
        if left == 0 && blocks.spheres() > 0 && !self.arrangement.clip.is_empty() {
            facts.skipped.assumed.push(all_clipped(blocks.spheres()));
        }
        Ok(facts)
    }

    /// All blocks, as they are arranged, with their spheres that are looked at.
    fn read(
        &self,
        mut blocks: SphereBlocks,
        mut each: impl FnMut(Spheres, Vec<Spheres>) -> Result<()>,
    ) -> Result<SphereBlocks> {
        while let Some(mut block) = blocks.next_block()? {
            let mut marks = blocks.marked();
            self.arrangement.apply(&mut block, None, &self.options.particles.watch)?;
            marks.iter_mut().try_for_each(|spheres| self.clip(spheres))?;
            self.say_why();
            each(block, marks)?;
        }
        Ok(blocks)
    }

    /// Leaves out what clip planes cut off.
    fn clip(&self, spheres: &mut Spheres) -> Result<()> {
        let clip = Arrangement { clip: self.arrangement.clip.clone(), ..Arrangement::default() };
        clip.apply(spheres, None, &self.options.particles.watch)
    }
}
