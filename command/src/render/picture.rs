//! One picture of `halfline render`: rendered, written, and reported in its turn.

use crate::bar::Bar;
use crate::clash::check_inputs;
use crate::legend;
use crate::messages::{note, say};
use crate::names::numbered as numbered_name;
use crate::picture_scene::PictureScene;
use crate::preview::Preview;
use crate::scene_args::SceneArgs;
use crate::signals::go_on;
use halfline::error::Result;
use halfline::frame::legend::Legend;
use halfline::frame::provenance::Origin;
use halfline::frame::{Aov, Frame};
use halfline::parallel;
use halfline::render::{Renderer, origin};
use halfline::report::{FigureCounts, Report};
use halfline::scene::Scene;
use halfline::settings::{Accuracy, Settings};
use halfline::window::Window;
use halfline_drawing::figure::Figure;
use halfline_drawing::inset::Panels;
use halfline_files::read::style::RangeEnd;
use halfline_files::write::figure;
use halfline_files::write::file::{Target, check_writable, write_atomically};
use halfline_files::write::glb;
use halfline_files::write::vector::VectorFormat;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Messages on standard error, each once for all pictures. A warning that differs from a warning of an earlier picture in its
/// numbers only is not printed again.
pub(crate) struct Messages<'a> {
    bar: Option<&'a Bar>,
    /// For each kind of message the first picture that has it, and what was printed for that, by their hashes.
    printed: Mutex<BTreeMap<u64, (u64, BTreeSet<u64>)>>,
    is_silent: bool,
}

/// The most kinds of messages that are known: a page can ask for pictures without end. Beyond, they are said again.
const KINDS: usize = 1 << 10;

impl<'a> Messages<'a> {
    pub(crate) fn new(bar: Option<&'a Bar>) -> Self {
        Self { bar, printed: Mutex::default(), is_silent: false }
    }

    /// Messages that are not printed.
    pub(crate) fn silent() -> Self {
        Self { is_silent: true, ..Self::new(None) }
    }

    fn note(&self, number: u64, words: String) {
        self.once(number, words.clone(), words, note);
    }

    fn warn(&self, number: u64, warning: &str) {
        let kind = warning.chars().filter(|c| !c.is_ascii_digit()).collect();
        self.once(number, kind, format!("warning: {warning}"), say);
    }

    fn once(&self, number: u64, kind: String, words: String, print: fn(fmt::Arguments<'_>)) {
        if self.is_silent {
            return;
        }
        let hash = |text: &str| BuildHasherDefault::<DefaultHasher>::default().hash_one(text);
        let mut printed = self.printed.lock().unwrap_or_else(PoisonError::into_inner);
        if printed.len() == KINDS && !printed.contains_key(&hash(&kind)) {
            printed.clear();
        }
        let (first, all) = printed.entry(hash(&kind)).or_insert_with(|| (number, BTreeSet::new()));
        if *first == number && all.len() < KINDS && all.insert(hash(&words)) {
            let print = || print(format_args!("{words}"));
            self.bar.map_or_else(print, |bar| bar.suspended(print));
        }
    }
}

/// A picture that is written.
pub(crate) struct Picture {
    pub(crate) number: u64,
    /// The files that show it.
    pub(crate) files: Vec<PathBuf>,
    pub(crate) report: Report,
    /// Its bytes in PNG, of a film or in memory.
    pub(crate) still: Option<Vec<u8>>,
}

/// Renders and writes pictures.
pub(crate) struct PictureWriter<'a> {
    pub(crate) args: &'a SceneArgs,
    /// The settings that all pictures share.
    pub(crate) settings: &'a Settings,
    pub(crate) resume: bool,
    /// The bytes of the picture are returned, and no file is written.
    pub(crate) in_memory: bool,
    pub(crate) repeat: NonZeroU32,
    pub(crate) preview: Option<Preview>,
    pub(crate) messages: &'a Messages<'a>,
}

impl PictureWriter<'_> {
    /// Renders one scene and writes its files, unless all exist.
    pub(crate) fn picture(&self, numbered: &PictureScene, renderer: &mut Renderer) -> Result<Picture> {
        let (scene, number) = (&numbered.scene, numbered.number);
        let mut targets = self.args.targets(numbered.number)?;
        let figure = self.args.files.figure().map(|(path, format)| (numbered_name(path, number), format));
        let files = figure.iter().map(|(path, _)| path.as_path()).chain(targets.iter().map(Target::path));
        let files: Vec<_> = files.map(Path::to_path_buf).collect();
        let written = |files, report, still| Picture { number, files, report, still };
        let mut panels = self.args.insets.panels(Some(self.args.file_name()), numbered)?;
        if let (Some(panels), Some(target)) = (&panels, targets.first_mut()) {
            target.set_drawn(panels.words());
        }
        if let Some(picture) = targets.first_mut() {
            picture.set_mattes(&numbered.mattes);
        }
        let settings = &self.args.settings_for(numbered, self.settings, &targets)?;
        if let Some(model) = self.args.files.model() {
            let report = self.write_model(model, numbered, renderer, settings)?;
            if targets.is_empty() && self.preview.is_none() {
                write_legend(self.args, numbered)?;
                return Ok(written(files, report, None));
            }
        }
        if self.resume && !targets.is_empty() {
            let mut report = renderer.dry_run(scene, settings)?;
            report.skipped = numbered.skipped.total();
            report.look = numbered.look.name();
            report.spheres = numbered.ids.as_ref().map_or(report.spheres, |ids| ids.count);
            let origin = origin(scene, settings, &report, settings.window_of(scene)?);
            targets.retain(|target| !target.is_there(&origin, &go_on));
            if targets.is_empty() {
                self.messages.note(number, already_there(&files));
                write_legend(self.args, numbered)?;
                return Ok(written(files, Report { resumed: true, number, ..report }, None));
            }
        }
        let drawn = figure.as_ref().map(|_| crate::figure::of(self.args, numbered, settings)).transpose()?;
        self.messages.note(number, format!("rendering on {} ({})", renderer.adapter(), renderer.driver()));
        let mut frame = self.frames(renderer, scene, settings, &targets)?;
        complete(self.args, numbered, &mut frame, panels.as_mut(), (renderer, settings))?;
        self.args
            .read
            .hold_words()
            .into_iter()
            .chain(numbered.look.words())
            .for_each(|words| self.messages.note(number, words));
        let is_percentile = self.args.color.range.is_some_and(RangeEnd::have_percentile);
        if let Some(Legend { range: [low, high], .. }) = numbered.legend.as_ref().filter(|_| is_percentile) {
            let [low, high] = [low, high].map(|end| halfline::quote::number(*end, 6));
            self.messages.note(number, format!("the colours go from {low} to {high}, the percentiles of --range"));
        }
        if settings.tolerance.is_some() && settings.accuracy == Accuracy::Auto {
            self.messages.note(number, frame.report.reason.clone());
        }
        let made = drawn.as_ref().zip(figure.as_ref());
        let made = made.map(|(drawn, of)| self.write_figure(drawn, (&of.0, of.1), panels.as_ref())).transpose()?;
        let (of_figure, figure_bytes) = made.unzip();
        if let Some((counts, (path, _))) = of_figure.zip(figure.as_ref()) {
            self.messages.note(number, crate::figure::words(path, counts));
            frame.report.figure = Some(counts);
            frame.report.warnings.extend(crate::figure::warning(counts));
        }
        frame.report.warnings.iter().for_each(|warning| self.messages.warn(number, warning));
        let mut still = None;
        if !targets.is_empty() {
            if let Some(words) = self.args.insets.words(numbered) {
                self.messages.note(number, words.to_owned());
            }
            let (report, window) = (frame.report.clone(), frame.window);
            let origin = &origin(scene, settings, &report, window);
            still = self.write(&mut frame, &targets, panels.as_ref(), (origin, scene.image.background))?;
            if self.args.files.film().is_some() && (window.width() % 2 == 1 || window.height() % 2 == 1) {
                self.messages
                    .note(number, "a film has even sides, so the last column or row of pixels is left out".into());
            }
        }
        still = still.or(figure_bytes.filter(|_| self.in_memory));
        write_legend(self.args, numbered)?;
        if let Some(preview) = self.preview {
            preview.show(&frame);
        }
        let written = written(files, frame.report.clone(), still);
        renderer.recycle(frame);
        Ok(written)
    }

    /// Renders the repeated frames; returns the last one with the times of all and the warnings of its files.
    fn frames(&self, renderer: &mut Renderer, scene: &Scene, settings: &Settings, targets: &[Target]) -> Result<Frame> {
        if let Some(bar) = self.messages.bar {
            let is_sampled = settings.aovs.iter().any(|aov| matches!(aov, Aov::Color | Aov::Alpha));
            let light = &scene.lighting;
            let has_light = light.sky.is_some() || light.shadows && !light.lights.is_empty();
            bar.expect(if is_sampled { settings.samples } else { 1 }, has_light);
        }
        let mut frame = renderer.render(scene, settings)?;
        let mut times = frame.report.frame_ms.clone();
        let (mut kernels, mut host) = (frame.report.kernel_ms.clone(), frame.report.host_ms.clone());
        for _ in 1..self.repeat.get() {
            renderer.recycle(frame);
            frame = renderer.render(scene, settings)?;
            times.extend(&frame.report.frame_ms);
            kernels.extend(&frame.report.kernel_ms);
            host.extend(&frame.report.host_ms);
        }
        let report = &mut frame.report;
        (report.frame_ms, report.kernel_ms, report.host_ms) = (times, kernels, host);
        let beyond: Vec<_> = targets.iter().flat_map(|target| target.warnings(&frame)).collect();
        frame.report.warnings.extend(beyond);
        Ok(frame)
    }

    /// Writes a figure with panels over it. Returns its counts and its bytes.
    fn write_figure(
        &self,
        figure: &Figure,
        (path, format): (&Path, VectorFormat),
        panels: Option<&Panels>,
    ) -> Result<(FigureCounts, Vec<u8>)> {
        let bytes = crate::figure::bytes(figure, format, panels);
        if !self.in_memory {
            write_atomically(path, |out| out.write_all(&bytes))?;
        }
        Ok((FigureCounts { bytes: bytes.len() as u64, ..figure.counts() }, bytes))
    }

    /// Writes the spheres as a model. Returns a report without a frame.
    fn write_model(
        &self,
        path: &Path,
        numbered: &PictureScene,
        renderer: &mut Renderer,
        settings: &Settings,
    ) -> Result<Report> {
        let (number, scene) = (numbered.number, &numbered.scene);
        let mut report = Report { number, look: numbered.look.name(), ..renderer.dry_run(scene, settings)? };
        numbered.skipped.report(&mut report.skipped, &mut report.warnings, renderer.passed_over().len());
        report.warnings.extend(glb::write(&numbered_name(path, number), scene)?);
        report.warnings.iter().for_each(|warning| self.messages.warn(number, warning));
        Ok(report)
    }

    /// Writes the files, and returns the bytes of the picture of a film; the panels are drawn into the picture, and into no
    /// other file.
    fn write(
        &self,
        frame: &mut Frame,
        targets: &[Target],
        panels: Option<&Panels>,
        (origin, background): (&Origin<'_>, [f32; 3]),
    ) -> Result<Option<Vec<u8>>> {
        let (pictures, others): (Vec<_>, Vec<_>) = targets.iter().partition(|target| target.is_drawn_on());
        let (film, still) = (self.args.files.film(), OnceLock::new());
        let trim = self.args.files.trim;
        let put = |frame: &Frame, target: &Target, origin: &Origin<'_>| match film {
            film if self.in_memory || film.is_some_and(|film| film.path == target.path()) => {
                target.encode(frame, origin, &go_on).map(|bytes| _ = still.set(bytes))
            }
            _ => target.write_while(frame, origin, &go_on),
        };
        let write = |frame: &Frame, targets: &[&Target], window: Option<Window>| {
            let part = window.map(|window| (frame.cut(window), Origin { window, ..origin.clone() }));
            let (frame, origin) = part.as_ref().map_or((frame, origin), |(frame, origin)| (frame, origin));
            parallel::try_collect(targets.len(), 1, &|n| {
                put(frame, targets[n.start], origin).map(|()| Vec::<()>::new())
            })
        };
        let mut content = None;
        let mut trimmed = |frame: &Frame| {
            content = content.or_else(|| trim.then(|| frame.content(background)).flatten());
            content
        };
        if let Some(panels) = panels.filter(|_| !pictures.is_empty()) {
            let covered = panels.draw(frame, self.args.files.transparent);
            let written = write(frame, &pictures, trimmed(frame));
            covered.restore(frame);
            written?;
        }
        write(frame, &others, trimmed(frame))?;
        if let Some(Window { x0, y0, x1, y1 }) = content {
            let [width, height] = origin.full;
            let part = format!("--trim keeps {}x{} of {width}x{height} pixels", x1 - x0, y1 - y0);
            self.messages.note(frame.report.number, part);
        } else if trim {
            self.messages.note(frame.report.number, "--trim keeps all, because nothing is shown".into());
        }
        Ok(still.into_inner())
    }
}

/// Completes a frame: the ids and the report of its scene, the marks of its panels, warnings about what is drawn.
///
/// # Errors
/// Errors of the camera, and of the renderer.
pub(crate) fn complete(
    args: &SceneArgs,
    numbered: &PictureScene,
    frame: &mut Frame,
    panels: Option<&mut Panels>,
    (renderer, settings): (&mut Renderer, &Settings),
) -> Result<()> {
    if let Some(ids) = &numbered.ids {
        ids.restore(frame);
    }
    let report = &mut frame.report;
    numbered.skipped.report(&mut report.skipped, &mut report.warnings, renderer.passed_over().len());
    (report.number, report.hold, report.look) = (numbered.number, args.read.hold(), numbered.look.name());
    if let Some(panels) = panels {
        frame.report.warnings.extend(args.insets.covering(panels, frame));
        frame.report.warnings.extend(args.insets.add_marks(panels, numbered, frame, (renderer, settings))?);
        frame.report.warnings.extend(panels.warning());
    }
    let of_legend = legend::warning(args, numbered.legend.as_ref());
    frame.report.warnings.extend(legend::hidden(args, numbered, frame.ids()));
    frame.report.warnings.extend(of_legend.filter(|words| !frame.report.warnings.contains(words)));
    Ok(())
}

/// Writes the file of the legend, if one is requested and the colours have one.
///
/// # Errors
/// Errors of writing.
pub(crate) fn write_legend(args: &SceneArgs, numbered: &PictureScene) -> Result<()> {
    let (Some(path), Some(legend)) = (legend::file(args, numbered.number)?, &numbered.legend) else { return Ok(()) };
    let drawing = halfline_drawing::legend::draw(legend)?;
    figure::write(&path, &drawing.svg, drawing.size, &drawing.levels)
}

/// The files of picture `number`, once they are known to be writable, and neither they nor what is written beside them is one of
/// `inputs`.
///
/// # Errors
/// Errors of [`check_inputs`] and of files that cannot be written.
pub(crate) fn writable_targets(args: &SceneArgs, number: u64, inputs: &[PathBuf]) -> Result<Vec<Target>> {
    let targets = args.targets(number)?;
    let model = args.files.model().map(|path| numbered_name(path, number));
    let figure = args.files.figure().map(|(path, _)| numbered_name(path, number));
    let (legend, list) = (legend::file(args, number)?, args.camera_list()?);
    let others = legend.iter().chain(&list).chain(&model).chain(&figure).map(PathBuf::as_path);
    check_inputs(targets.iter().map(Target::path).chain(others), inputs)?;
    model.iter().chain(&figure).try_for_each(|path| check_writable(path))?;
    targets.iter().try_for_each(Target::check)?;
    Ok(targets)
}

/// That the files of a picture need no rendering.
fn already_there(files: &[PathBuf]) -> String {
    let names: Vec<_> = files.iter().map(|file| file.display().to_string()).collect();
    match &names[..] {
        [name] => format!("{name} is already there: it is complete and comes from the same rendering"),
        names => {
            let names = names.join(", ");
            format!("{names} are already there: they are complete and come from the same rendering")
        }
    }
}
