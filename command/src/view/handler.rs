//! Handles the page's requests: the open file and its cached frames, or a scene in memory; two renderers.

use super::content::Content;
use super::controls;
use super::frames::{Count, Frames};
use super::given::{Given, GivenOption, line};
use super::memory::MemoryScene;
use super::moving;
use super::parse::Parser;
use super::pick::{apart, describe, pick};
use super::{lens, python, summary};
use crate::adapters::note_fallback;
use crate::camera_file;
use crate::failure::class;
use crate::messages::flags;
use crate::picture_scene::PictureScene;
use crate::read_args::plane;
use crate::render::picture::{Messages, PictureWriter};
use crate::scene_args::SceneArgs;
use crate::scene_frames::{self, framed, posed};
use crate::signals::watch;
use crate::threads::both;
use halfline::camera::{Camera, CameraRecord};
use halfline::error::{Error, Result};
use halfline::frame::report::Report;
use halfline::progress::Cancel;
use halfline::render::Renderer;
use halfline::scene::Cell;
use halfline::settings::{Backend, Settings};
use halfline::window::Window;
use halfline_files::read::{Focus, Format, SceneFrame, Selection};
use halfline_files::write::file::Target;
use halfline_viewer::{
    Answer, Commands, FrameRequest, GoOn, Mode, Options, PickRequest, Picture, Pixels, Pose, Refusal, SceneRequest,
    SelectRequest, Stage,
};
use serde_json::{Value, json};
use std::num::NonZeroU32;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use web_time::Instant;

/// The scene that a page shows, its cached frames, and the renderers of pictures and of picks.
pub(super) struct ViewHandler {
    given: Given,
    /// `None` until the first frame was read.
    session: Mutex<Option<Session>>,
    read: Condvar,
    renderer: Arc<Mutex<Option<Renderer>>>,
    /// A renderer for picks alone, so that they do not wait for a picture.
    picker: Mutex<Renderer>,
    messages: Messages<'static>,
    /// The names of settings in errors and warnings.
    words: fn(&str) -> String,
    /// The identifiers of the options that the page sets.
    controls: Vec<&'static str>,
    notebook: Option<Notebook>,
}

/// Parts that only a scene in memory has.
struct Notebook {
    /// The options of the lines that are copied, with the options of reading.
    copied: Given,
    /// The cell whose edges a picture may draw.
    edges: Option<Cell>,
    /// The backend of the renderer, which the options of a picture do not name.
    backend: Backend,
}

/// The file after its first frame was read: the parser of options, cached frames, and the summary of the scene.
struct Session {
    parser: Parser,
    /// The frames with the colours of the command line, and those with other ones.
    plain: Frames,
    styled: Option<Frames>,
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
            renderer: Arc::default(),
            picker: Mutex::new(Renderer::new(&own)?),
            messages: Messages::new(None),
            words: flags,
            controls: controls::of_file(),
            notebook: None,
        })
    }

    /// The handler of a scene in memory, which answers at once and prints nothing.
    ///
    /// # Errors
    /// Errors of the options and of the camera with which it begins.
    pub(super) fn in_memory(memory: MemoryScene) -> Result<Self> {
        let MemoryScene { content, renderer, backend, words } = memory;
        let Content { mut frames, edges, name, source, rendering, copied, camera, size, is_sized, is_framed, text } =
            content;
        let given = Given::of_options(name.into(), &rendering);
        let first = frames.first().map_or(1, |frame| frame.number);
        let is_numbered = frames.len() > 1 || source.is_some() && first != 1;
        let copied = Given::of_options(source.unwrap_or_default(), &copied);
        let controls = controls::in_memory(&copied);
        let notebook = Some(Notebook { copied, edges, backend });
        let handler = Self { renderer, messages: Messages::silent(), words, controls, notebook, ..Self::new(given)? };
        // Pictures take nothing from the camera of the file.
        for frame in &mut frames {
            (frame.scene.camera, frame.aperture) = (Camera::CANONICAL, None);
        }
        let plain = Frames::in_memory(Vec::new(), frames);
        let (parser, summary) = (Parser::without_preferences(), Value::Null);
        let mut session = Session { parser, plain, styled: None, summary, record: None, first, is_numbered };
        let RenderJob { args, picture, .. } = handler.render_job(&mut session, &FrameRequest::still(camera, size))?;
        session.summary = summary::of(&args, session.plain.get(first)?, &picture, &camera)?;
        session.summary["framed"] = json!(is_framed);
        (session.summary["title"], session.summary["caption"]) = (json!(text.title), json!(text.caption));
        if is_sized {
            session.summary["sized"] = json!(true);
        }
        if session.is_numbered && session.plain.total > Some(1) {
            session.summary["first"] = json!(first);
        }
        // Expressions of coordinates need no columns.
        session.summary["selects"] = json!(true);
        session.summary["controls"] = handler.rows(&session.parser, &session.summary);
        *lock(&handler.session) = Some(session);
        Ok(handler)
    }

    /// Opens the device, and reads the frame with which the page begins; its camera is the camera of its picture by
    /// `halfline render`. Then requests are answered, and the frames of the file are counted.
    ///
    /// # Errors
    /// Errors of the options, of reading the file and of opening the device.
    pub(super) fn load(&self) -> Result<()> {
        let mut parser = Parser::new()?;
        let words = self.given.words(&self.given.initial());
        let args = parser.args(&words)?;
        let settings = args.settings(&[]);
        let first = self.given.frame.unwrap_or(1);
        let read = || read_first(Frames::new(words.clone(), parser.args(&words)?), &args, first);
        let (read, renderer) = both(read, || Renderer::new(&settings));
        // Errors of the scene are reported before errors of the adapter.
        let (mut plain, mut summary, record) = read?;
        summary["controls"] = self.rows(&parser, &summary);
        let renderer = renderer?;
        note_fallback(&renderer);
        *lock(&self.renderer) = Some(renderer);
        let rest = plain.count();
        let is_numbered = self.given.frame.is_some() || plain.total != Some(1);
        *lock(&self.session) = Some(Session { parser, plain, styled: None, summary, record, first, is_numbered });
        self.read.notify_all();
        if let Some(total) = rest.and_then(Count::end)
            && let Some(session) = lock(&self.session).as_mut()
        {
            session.plain.total = Some(total);
        }
        Ok(())
    }

    /// The camera of the first picture in another size, which is the page's.
    fn resized(&self, session: &mut Session, [width, height]: [u32; 2]) -> Result<Pose> {
        let mut options = self.given.initial();
        options.push(GivenOption::new("size", Some(format!("{width}x{height}").into())));
        let args = session.parser.args(&self.given.words(&options))?;
        let fixed = session.plain.fixed_camera(session.first)?;
        let frame = session.plain.framed(session.first)?.copy();
        first_picture(&args, frame, session.record.as_ref(), fixed).map(|(_, pose)| pose)
    }

    /// Waits until the first frame was read, then runs `work` on the file.
    fn with<T>(&self, work: impl FnOnce(&mut Session) -> Result<T>) -> Answer<T> {
        let mut session = lock(&self.session);
        loop {
            if let Some(session) = session.as_mut() {
                return work(session).map_err(|error| self.refusal(&error));
            }
            session = self.read.wait(session).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// The rows of the panel of controls.
    fn rows(&self, parser: &Parser, summary: &Value) -> Value {
        controls::rows(&self.controls, &self.given, summary, |id| parser.help(id)).into()
    }

    /// A request whose options are controls of the page, and whose frame is named where pictures name it.
    ///
    /// # Errors
    /// As [`controls::check`].
    fn checked(&self, session: &Session, request: &FrameRequest) -> Result<FrameRequest> {
        controls::check(&self.controls, &request.options, &self.given)?;
        let frame = request.frame.filter(|frame| session.is_numbered || *frame != 1);
        Ok(FrameRequest { frame: frame.or(session.is_numbered.then_some(session.first)), ..request.clone() })
    }

    /// The picture of a request.
    fn render_job(&self, session: &mut Session, request: &FrameRequest) -> Result<RenderJob> {
        let request = self.checked(session, request)?;
        let args = session.parser.args(&self.given.words_of(&request))?;
        let mut frame = self.shown(session, &request)?;
        if let (Some(notebook), Some(bead)) = (&self.notebook, args.read.arrangement().outline) {
            frame.outline(notebook.edges.as_ref(), bead)?;
        }
        let picture = posed(&args, frame, session.record.as_ref().and_then(CameraRecord::lens_size))?;
        let targets = args.targets(picture.number)?;
        let settings = args.settings(&targets);
        let backend = self.notebook.as_ref().map_or(settings.backend, |notebook| notebook.backend);
        let settings = Settings { backend, ..settings };
        Ok(RenderJob { args, picture, settings, targets })
    }

    /// The frame of a request that was checked, as its picture shows it: with its colours, without what its planes cut off.
    fn shown(&self, session: &mut Session, request: &FrameRequest) -> Result<SceneFrame> {
        let mut frame = self.frame_of(session, request.select.as_deref(), &request.options, request.frame)?.copy();
        let planes = request.options.get("clip").into_iter().flatten();
        let planes =
            planes.map(|text| plane(text).map_err(|expected| Error::settings(format!("clip is {text:?}"), expected)));
        frame.clip(planes.collect::<Result<_>>()?, &watch())?;
        Ok(frame)
    }

    /// A frame, with the colours of a selection and of the options.
    fn frame_of<'a>(
        &self,
        session: &'a mut Session,
        select: Option<&str>,
        options: &Options,
        number: Option<u64>,
    ) -> Result<&'a mut SceneFrame> {
        let number = number.unwrap_or(session.first);
        let options = controls::of_reader(options);
        if select.is_none() && options.is_empty() {
            return session.plain.get(number);
        }
        let words = self.given.words(&self.given.reading(select, &options));
        let styled = match session.styled.take().filter(|styled| styled.are_of(&words)) {
            // In memory the colours of one frame are kept.
            Some(styled) if self.notebook.is_none() || styled.has(number) => styled,
            _ if self.notebook.is_some() => {
                let style = scene_frames::options(&session.parser.args(&words)?, &Cancel::default())?.style;
                Frames::in_memory(words, vec![session.plain.get(number)?.styled(&style)?])
            }
            _ => Frames::new(words.clone(), session.parser.args(&words)?),
        };
        session.styled.insert(styled).get(number)
    }

    fn refusal(&self, error: &Error) -> Refusal {
        let (kind, exit) = class(error);
        Refusal { kind, message: (self.words)(&error.to_string()), exit }
    }

    /// A summary whose warnings have the words of this front end.
    fn in_words(&self, mut summary: Value) -> Value {
        for warning in summary["warnings"].as_array_mut().into_iter().flatten() {
            *warning = (self.words)(warning.as_str().unwrap_or_default()).into();
        }
        summary
    }

    /// The pixels of a picture and its report, by a renderer that ends its work when `go_on` says so.
    fn render(&self, job: &RenderJob, request: &FrameRequest, go_on: &GoOn) -> Result<(Pixels, Report)> {
        let mut place = lock(&self.renderer);
        let idle = match place.take() {
            Some(idle) => idle,
            None if self.notebook.is_none() => Renderer::new(&job.settings)?,
            None => return Err(Error::settings("the renderer failed before", "start again")),
        };
        let go_on = GoOn::clone(go_on);
        let renderer = place.insert(idle.watched_by(watch().while_true(move || go_on())));
        let rendered = self.rendered(job, request, renderer);
        if matches!(rendered, Err(Error::DeviceLost(_))) && self.notebook.is_none() {
            // The next picture opens the device again.
            *place = None;
        }
        rendered
    }

    /// The pixels of a picture by this renderer, and its report.
    fn rendered(&self, job: &RenderJob, request: &FrameRequest, renderer: &mut Renderer) -> Result<(Pixels, Report)> {
        let RenderJob { args, picture, settings, targets } = job;
        match request.mode {
            Mode::Move => {
                let settings = args.settings_for(picture, settings, targets)?;
                moving::render(renderer, &picture.scene, &settings)
            }
            Mode::Part => {
                let window = request.window.map(|[x0, y0, x1, y1]| Window { x0, y0, x1, y1 });
                let settings = Settings { window, ..args.settings_for(picture, settings, targets)? };
                let (pixels, mut report) = moving::part(renderer, &picture.scene, &settings)?;
                report.look = picture.look.name();
                // What is said of a part is not true of the picture.
                if window.is_some() {
                    report.warnings.clear();
                }
                Ok((pixels, report))
            }
            Mode::Still | Mode::Svg | Mode::Pdf => {
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
                let pixels = match request.mode {
                    Mode::Svg => Pixels::Svg(still),
                    Mode::Pdf => Pixels::Pdf(still),
                    _ => Pixels::Png(still),
                };
                Ok((pixels, written.report))
            }
        }
    }
}

impl Stage for ViewHandler {
    fn scene(&self, request: &SceneRequest) -> Answer<Value> {
        self.with(|session| {
            let mut summary = self.in_words(session.summary.clone());
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
            let request = self.checked(session, request)?;
            let frame = self.shown(session, &request)?;
            let marks = match &args.camera.focus {
                Some(selection) => {
                    let (mask, notes) = frame.selected(selection)?;
                    vec![Focus { text: selection.to_string(), spheres: frame.scene.spheres.part(&mask), notes }]
                }
                None => Vec::new(),
            };
            let frame = SceneFrame { marks, ..frame };
            first_picture(&args, frame, None, None).map(|(_, pose)| json!({ "camera": pose }))
        })
    }

    fn frame(&self, request: &FrameRequest, go_on: &GoOn) -> Answer<Option<Picture>> {
        let start = Instant::now();
        let (job, frames) = self.with(|session| {
            let total = session.plain.total.filter(|_| session.is_numbered);
            self.render_job(session, request).map(|job| (job, total))
        })?;
        let (pixels, report) = match self.render(&job, request, go_on) {
            Err(Error::Interrupted) => return Ok(None),
            done => done.map_err(|error| self.refusal(&error))?,
        };
        let unit = lens::unit(&job.picture.scene.camera, request.size).map_err(|error| self.refusal(&error))?;
        let mut info = self.in_words(summary::of_picture(&report));
        let ms = (start.elapsed().as_secs_f64() * 1e5).round() / 100.0;
        let own = json!({ "seq": request.seq, "unit": unit, "ms": ms, "frames": frames });
        info.as_object_mut().into_iter().for_each(|info| info.extend(own.as_object().cloned().unwrap_or_default()));
        Ok(Some(Picture { pixels, info }))
    }

    fn pick(&self, request: &PickRequest) -> Answer<Value> {
        let PickRequest { camera, size, frame, ref select, ref options, x, y, from } = *request;
        let (select, options) = (select.clone(), options.clone());
        let of = FrameRequest { frame, select, options, ..FrameRequest::still(camera, size) };
        let RenderJob { picture, settings, .. } = self.with(|session| self.render_job(session, &of))?;
        let mut picker = lock(&self.picker);
        let found = pick(&mut picker, &picture.scene, &settings, [x, y]).map_err(|error| self.refusal(&error))?;
        drop(picker);
        let Some((id, mut picked)) = found else { return Ok(Value::Null) };
        self.with(|session| {
            let frame = self.shown(session, &self.checked(session, &of)?)?;
            if id >= frame.scene.spheres.len() {
                // A bead that only the picture has.
                return Ok(Value::Null);
            }
            describe(&mut picked, &frame.columns, id);
            let to_other = |from: u64| {
                let other = usize::try_from(from).ok()?;
                let (distance, image) = apart(&frame.scene.spheres, frame.cell.as_ref(), [other, id])?;
                Some(json!({ "id": from, "distance": distance, "minimum_image": image }))
            };
            picked["from"] = from.and_then(to_other).into();
            Ok(picked)
        })
    }

    fn select(&self, SelectRequest { expr, options, frame }: &SelectRequest) -> Answer<Value> {
        self.with(|session| {
            controls::check(&self.controls, options, &self.given)?;
            let selection: Option<Selection> = expr.as_deref().map(str::parse).transpose()?;
            let shown = session.plain.get(frame.unwrap_or(session.first))?;
            let of = shown.scene.spheres.len() - shown.beads;
            let (count, notes) = match selection {
                Some(selection) => {
                    let (mask, notes) = shown.selected(&selection)?;
                    (mask[..of].iter().filter(|is| **is).count(), notes)
                }
                None => (of, Vec::new()),
            };
            let legend = self.frame_of(session, expr.as_deref(), options, *frame)?.legend.clone();
            let notes: Vec<String> = notes.iter().map(|note| (self.words)(note)).collect();
            Ok(json!({ "count": count, "of": of, "legend": summary::legend(legend.as_ref())?, "notes": notes }))
        })
    }

    fn command(&self, request: &FrameRequest) -> Answer<Commands> {
        self.with(|session| {
            let request = self.checked(session, request)?;
            // What the command would refuse is an error here.
            session.parser.args(&self.given.words_of(&request))?;
            let given = self.notebook.as_ref().map_or(&self.given, |notebook| &notebook.copied);
            let options = given.with_preferences(given.options_of(&request));
            // There is no command for a scene without a file.
            let file = Some(given.scene.as_os_str()).filter(|file| !file.is_empty());
            let shell = file.map(|_| line(&given.words_of(&request))).transpose()?;
            Ok(Commands { shell, python: python::lines(file, &given.output(), &options, &request) })
        })
    }

    fn progress(&self, wait: Duration) -> Answer<Value> {
        let mut session = lock(&self.session);
        // A page in a browser has no clock for waits, and nothing to wait for.
        if session.is_none() {
            let waited = self.read.wait_timeout_while(session, wait, |session| session.is_none());
            session = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        let (state, text) = match *session {
            Some(_) => ("ready", String::new()),
            None => ("loading", format!("reading {}", self.given.scene.to_string_lossy())),
        };
        Ok(json!({ "state": state, "text": text }))
    }
}

/// Reads the first frame of the file, whose camera all frames have, and the frame with which the page begins. Returns them with the summary of
/// the scene and the record of `--camera-from`.
///
/// # Errors
/// Errors of the options and of reading the file.
pub(super) fn read_first(
    mut frames: Frames,
    args: &SceneArgs,
    first: u64,
) -> Result<(Frames, Value, Option<CameraRecord>)> {
    let record = args.camera.from.as_deref().map(camera_file::read).transpose()?;
    let fixed = frames.fixed_camera(first)?;
    let (picture, pose) = first_picture(args, frames.framed(first)?.copy(), record.as_ref(), fixed)?;
    let mut summary = summary::of(args, frames.get(first)?, &picture, &pose)?;
    summary["format"] = json!(frames.format.map(Format::name));
    summary["sized"] = json!(args.is_sized() || record.is_some());
    Ok((frames, summary, record))
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

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
