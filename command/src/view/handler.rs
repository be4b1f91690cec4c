//! Handles the page's requests: the open file, its cached frames, two renderers.

use super::frames::{Count, Frames};
use super::given::{Given, GivenOption, line};
use super::moving;
use super::parse::Parser;
use super::pick::{apart, describe, pick};
use super::{lens, python, summary};
use crate::adapters::note_fallback;
use crate::camera_file;
use crate::failure::object;
use crate::picture_scene::PictureScene;
use crate::render::picture::{Messages, PictureWriter};
use crate::scene_args::SceneArgs;
use crate::scene_frames::{framed, posed};
use crate::signals::watch;
use crate::threads::both;
use halfline::camera::{Camera, CameraRecord};
use halfline::error::{Error, Result};
use halfline::frame::report::Report;
use halfline::render::Renderer;
use halfline::settings::{Backend, Settings};
use halfline_files::read::{Focus, Format, SceneFrame, Selection};
use halfline_files::write::file::Target;
use halfline_viewer::{
    Answer, Commands, FrameRequest, GoOn, Mode, PickRequest, Picture, Pixels, Pose, Refusal, SceneRequest, Stage,
};
use serde_json::{Value, json};
use std::num::NonZeroU32;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The file that a page shows, its cached frames, and the renderers of pictures and of picks.
pub(super) struct ViewHandler {
    given: Given,
    /// `None` until the first frame was read.
    session: Mutex<Option<Session>>,
    read: Condvar,
    renderer: Mutex<Option<Renderer>>,
    /// A renderer for picks alone, so that they do not wait for a picture.
    picker: Mutex<Renderer>,
    messages: Messages<'static>,
}

/// The file after its first frame was read: the parser of options, cached frames, and the summary of the scene.
struct Session {
    parser: Parser,
    /// The frames with the colours of the command line, and those with a selection.
    plain: Frames,
    selected: Option<Frames>,
    /// The answer to `/scene`, without the number of frames and the camera for another size.
    summary: Value,
    /// The camera of `--camera-from`.
    record: Option<CameraRecord>,
    /// The number of the frame that the page begins with.
    first: u64,
    /// Whether pictures name their frame: the file has several, or the command line names one.
    is_numbered: bool,
}

/// A picture that is ready to render.
struct RenderJob {
    args: SceneArgs,
    picture: PictureScene,
    settings: Settings,
    targets: Vec<Target>,
}

impl ViewHandler {
    /// # Errors
    /// Errors of [`Renderer::new`] on the CPU path.
    pub(super) fn new(given: Given) -> Result<Self> {
        let own = Settings { backend: Backend::Cpu, ..Settings::default() };
        Ok(Self {
            given,
            session: Mutex::default(),
            read: Condvar::new(),
            renderer: Mutex::default(),
            picker: Mutex::new(Renderer::new(&own)?),
            messages: Messages::new(None),
        })
    }

    /// Opens the device, and reads the frame with which the page begins; its camera is that of its picture by
    /// `halfline render`. Then requests are answered, and the frames of the file are counted.
    ///
    /// # Errors
    /// Errors of the options, of reading the file and of opening the device.
    pub(super) fn load(&self) -> Result<()> {
        let mut parser = Parser::new()?;
        let words = self.given.words(&self.given.initial());
        let args = parser.args(&words)?;
        let settings = args.settings(&[]);
        let read = || self.read_first(Frames::new(words.clone(), parser.args(&words)?), &args);
        let (read, renderer) = both(read, || Renderer::new(&settings));
        // Errors of the scene are reported before those of the adapter.
        let (mut plain, summary, record, first) = read?;
        let renderer = renderer?;
        note_fallback(&renderer);
        *lock(&self.renderer) = Some(renderer);
        let rest = plain.count();
        let is_numbered = self.given.frame.is_some() || plain.total != Some(1);
        *lock(&self.session) = Some(Session { parser, plain, selected: None, summary, record, first, is_numbered });
        self.read.notify_all();
        if let Some(total) = rest.and_then(Count::end)
            && let Some(session) = lock(&self.session).as_mut()
        {
            session.plain.total = Some(total);
        }
        Ok(())
    }

    /// Reads the first frame of the file, whose camera is that of all, and the one with which the page begins.
    fn read_first(&self, mut frames: Frames, args: &SceneArgs) -> Result<(Frames, Value, Option<CameraRecord>, u64)> {
        let record = args.camera.from.as_deref().map(camera_file::read).transpose()?;
        let first = self.given.frame.unwrap_or(1);
        let fixed = frames.fixed_camera(first)?;
        let (picture, pose) = first_picture(args, without_columns(frames.framed(first)?), record.as_ref(), fixed)?;
        let mut summary = summary::of(&self.given.scene, frames.get(first)?, &picture, &pose)?;
        summary["format"] = json!(frames.format.map(Format::name));
        summary["sized"] = json!(args.image.size.is_some() || record.is_some());
        summary["draws"] = json!({
            "legend": args.insets.legend_in.is_some(),
            "scale_bar": args.insets.scale_bar.is_some(),
        });
        Ok((frames, summary, record, first))
    }

    /// The camera of the first picture in another size, which is the page's.
    fn resized(&self, session: &mut Session, [width, height]: [u32; 2]) -> Result<Pose> {
        let mut options = self.given.initial();
        options.push(GivenOption::new("size", Some(format!("{width}x{height}").into())));
        let args = session.parser.args(&self.given.words(&options))?;
        let fixed = session.plain.fixed_camera(session.first)?;
        let frame = without_columns(session.plain.framed(session.first)?);
        first_picture(&args, frame, session.record.as_ref(), fixed).map(|(_, pose)| pose)
    }

    /// Waits until the first frame was read, then runs `work` on the file.
    fn with<T>(&self, work: impl FnOnce(&mut Session) -> Result<T>) -> Answer<T> {
        let mut session = lock(&self.session);
        loop {
            if let Some(session) = session.as_mut() {
                return work(session).map_err(|error| refusal(&error));
            }
            session = self.read.wait(session).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// A request whose frame is named where pictures name it.
    fn numbered(session: &Session, request: &FrameRequest) -> FrameRequest {
        let frame = request.frame.filter(|frame| session.is_numbered || *frame != 1);
        FrameRequest { frame: frame.or(session.is_numbered.then_some(session.first)), ..request.clone() }
    }

    /// The picture of a request.
    fn render_job(&self, session: &mut Session, request: &FrameRequest) -> Result<RenderJob> {
        let request = Self::numbered(session, request);
        let args = session.parser.args(&self.given.words_of(&request))?;
        let frame = self.frame_of(session, request.select.as_deref(), request.frame)?;
        let frame = without_columns(frame);
        let picture = posed(&args, frame, session.record.as_ref().and_then(CameraRecord::lens_size))?;
        let targets = args.files.targets(picture.number)?;
        let settings = args.settings(&targets);
        Ok(RenderJob { args, picture, settings, targets })
    }

    /// A frame that was read, with the colours of a selection.
    fn frame_of<'a>(
        &self,
        session: &'a mut Session,
        select: Option<&str>,
        number: Option<u64>,
    ) -> Result<&'a mut SceneFrame> {
        let number = number.unwrap_or(session.first);
        let Some(selection) = select else { return session.plain.get(number) };
        let words = self.given.words(&self.given.selected(selection));
        let selected = match session.selected.take().filter(|selected| selected.are_of(&words)) {
            Some(selected) => selected,
            None => Frames::new(words.clone(), session.parser.args(&words)?),
        };
        session.selected.insert(selected).get(number)
    }

    /// The pixels of a picture and its report, by a renderer that ends its work when `go_on` says so.
    fn render(&self, job: &RenderJob, request: &FrameRequest, go_on: &GoOn) -> Result<(Pixels, Report)> {
        let mut renderer = lock(&self.renderer);
        let Some(idle) = renderer.take() else {
            return Err(Error::settings("the renderer failed before", "start the command again"));
        };
        let go_on = GoOn::clone(go_on);
        let renderer = renderer.insert(idle.watched_by(watch().while_true(move || go_on())));
        let RenderJob { args, picture, settings, targets } = job;
        match request.mode {
            Mode::Move => {
                let settings = args.settings_for(picture, settings, targets)?;
                moving::render(renderer, &picture.scene, &settings)
            }
            Mode::Still => {
                let writer = PictureWriter {
                    args,
                    settings,
                    resume: false,
                    in_memory: true,
                    repeat: NonZeroU32::MIN,
                    preview: None,
                    messages: &self.messages,
                };
                let written = writer.picture(picture, renderer)?;
                let still = written.still.ok_or_else(|| Error::settings("no picture is requested", "remove --aov"))?;
                Ok((Pixels::Png(still), written.report))
            }
        }
    }
}

impl Stage for ViewHandler {
    fn scene(&self, request: &SceneRequest) -> Answer<Value> {
        self.with(|session| {
            let mut summary = session.summary.clone();
            summary["frames"] = if session.is_numbered { json!(session.plain.total) } else { json!(1) };
            if let Some(size) = request.size.filter(|_| summary["sized"] == false) {
                summary["camera"] = json!(self.resized(session, size)?);
                summary["size"] = json!(size);
            }
            Ok(summary)
        })
    }

    fn fit(&self, request: &FrameRequest) -> Answer<Value> {
        self.with(|session| {
            let args = session.parser.args(&self.given.words(&self.given.fitted(request)))?;
            let number = Self::numbered(session, request).frame;
            let frame = self.frame_of(session, request.select.as_deref(), number)?;
            let marks = match &args.camera.focus {
                Some(selection) => {
                    let (mask, notes) = frame.columns.select(selection, &frame.scene.spheres)?;
                    vec![Focus { text: selection.to_string(), spheres: frame.scene.spheres.part(&mask), notes }]
                }
                None => Vec::new(),
            };
            let frame = SceneFrame { marks, ..without_columns(frame) };
            first_picture(&args, frame, None, None).map(|(_, pose)| json!({ "camera": pose }))
        })
    }

    fn frame(&self, request: &FrameRequest, go_on: &GoOn) -> Answer<Option<Picture>> {
        let start = Instant::now();
        let job = self.with(|session| self.render_job(session, request))?;
        let (pixels, report) = match self.render(&job, request, go_on) {
            Err(Error::Interrupted) => return Ok(None),
            done => done.map_err(|error| refusal(&error))?,
        };
        let unit = lens::unit(&job.picture.scene.camera, request.size).map_err(|error| refusal(&error))?;
        let mut info = summary::of_picture(&report);
        let ms = (start.elapsed().as_secs_f64() * 1e5).round() / 100.0;
        for (name, value) in [("seq", json!(request.seq)), ("unit", json!(unit)), ("ms", json!(ms))] {
            info[name] = value;
        }
        Ok(Some(Picture { pixels, info }))
    }

    fn pick(&self, request: &PickRequest) -> Answer<Value> {
        let PickRequest { camera, size, frame, ref select, x, y, from } = *request;
        let of = FrameRequest {
            seq: 0,
            camera,
            size,
            frame,
            select: select.clone(),
            look: Some("plain".into()),
            samples: Some(1),
            mode: Mode::Still,
        };
        let RenderJob { picture, settings, .. } = self.with(|session| self.render_job(session, &of))?;
        let mut picker = lock(&self.picker);
        let mut found = pick(&mut picker, &picture.scene, &settings, [x, y]).map_err(|error| refusal(&error))?;
        drop(picker);
        if let Some(picked) = found.as_object_mut()
            && let Some(id) = picked.get("id").and_then(Value::as_u64).and_then(|id| usize::try_from(id).ok())
        {
            self.with(|session| {
                let number = Self::numbered(session, &of).frame;
                let frame = self.frame_of(session, select.as_deref(), number)?;
                describe(picked, &frame.columns, id);
                let to_other = |from: u64| {
                    let other = usize::try_from(from).ok()?;
                    let (distance, image) = apart(&frame.scene.spheres, frame.cell.as_ref(), [other, id])?;
                    Some(json!({ "id": from, "distance": distance, "minimum_image": image }))
                };
                picked.insert("from".into(), from.and_then(to_other).into());
                Ok(())
            })?;
        }
        Ok(found)
    }

    fn select(&self, expr: &str, frame: Option<u64>) -> Answer<Value> {
        self.with(|session| {
            let selection: Selection = expr.parse()?;
            let shown = session.plain.get(frame.unwrap_or(session.first))?;
            let (mask, notes) = shown.columns.select(&selection, &shown.scene.spheres)?;
            let mask = &mask[..mask.len() - shown.beads];
            let (count, of) = (mask.iter().filter(|is| **is).count(), mask.len());
            let legend = self.frame_of(session, Some(expr), frame)?.legend.clone();
            Ok(json!({ "count": count, "of": of, "legend": summary::legend(legend.as_ref())?, "notes": notes }))
        })
    }

    fn command(&self, request: &FrameRequest) -> Answer<Commands> {
        self.with(|session| {
            let request = Self::numbered(session, request);
            let words = self.given.words_of(&request);
            // What the command would refuse is an error here.
            session.parser.args(&words)?;
            let options = self.given.with_preferences(self.given.options_of(&request));
            let python = python::lines(Some(&self.given.scene), &self.given.output(), &options, &request);
            Ok(Commands { shell: Some(line(&words)?), python })
        })
    }

    fn progress(&self, wait: Duration) -> Answer<Value> {
        let session = lock(&self.session);
        let (session, _) = self
            .read
            .wait_timeout_while(session, wait, |session| session.is_none())
            .unwrap_or_else(PoisonError::into_inner);
        let (state, text) = match *session {
            Some(_) => ("ready", String::new()),
            None => ("loading", format!("reading {}", self.given.scene.to_string_lossy())),
        };
        Ok(json!({ "state": state, "text": text }))
    }
}

/// The picture of a frame that the options frame, and its camera, whose pivot is what they look at.
fn first_picture(
    args: &SceneArgs,
    frame: SceneFrame,
    record: Option<&CameraRecord>,
    fixed: Option<Camera>,
) -> Result<(PictureScene, Pose)> {
    let pivot = args.camera.pivot(&frame)?;
    let picture = framed(args, frame, record, fixed)?;
    let pose = lens::pose(&picture.scene, pivot)?;
    Ok((picture, pose))
}

/// A copy that shares the spheres and has no columns, which are large and no part of a picture.
fn without_columns(frame: &mut SceneFrame) -> SceneFrame {
    let columns = std::mem::take(&mut frame.columns);
    let copy = frame.copy();
    frame.columns = columns;
    copy
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn refusal(error: &Error) -> Refusal {
    let (kind, exit, message) = object(error);
    Refusal { kind, message, exit }
}
