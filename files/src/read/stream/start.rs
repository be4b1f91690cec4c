//! Starts of the reading of a file in parts, and readings before it of what depends on all rows.

use crate::read::native::{self, NamedSpheres, rows_of};
use crate::read::options::ReadOptions;
use crate::read::style::{Style, no_selections};
use halfline::error::{Error, Result};
use halfline::progress::Watch;
use halfline::quote::setting::STREAM;
use halfline_particles::Format;
use halfline_particles::blocks;
use halfline_particles::input::read_once;
use halfline_particles::open::{listed, open as open_particles};
use halfline_particles::opened::SceneSource;
use halfline_particles::particles::colors::ColorSurvey;
use halfline_particles::particles::frame::{ParticleFrames, Particles};
use halfline_particles::particles::request::Request;
use halfline_particles::particles::survey::{Part, Survey};
use halfline_particles::spheres::SphereRows;
use std::path::Path;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::{self, JoinHandle};

/// Spheres of a block.
const BLOCK: usize = 1 << 18;

/// Blocks that are read ahead.
const AHEAD: usize = 2;

/// The spheres of a scene file: its own, and the spheres of the files that it refers to.
struct InBlocks {
    own: SphereRows,
    files: Vec<NamedSpheres>,
    is_colored: bool,
    watch: Watch,
}

impl InBlocks {
    fn open(source: SceneSource, options: &ReadOptions) -> Result<Self> {
        if let Some(once) = read_once(&source.path) {
            let problem = format!("{STREAM}: a scene is read for its camera first, and {once} can be read once");
            return Err(Error::settings(problem, "use a file"));
        }
        let watch = options.particles.watch.clone();
        let (read, files) = native::without_files(source.reader, &source.path, &watch)?;
        let own = read.scene.spheres;
        if own.materials.is_some() {
            let problem = format!("{STREAM}: mirrors and glass need all spheres in memory");
            return Err(Error::settings(problem, "remove the materials of the scene"));
        }
        if own.opacities.is_some() || files.iter().any(|file| file.opacity < 1.0) {
            let problem = format!("{STREAM}: the opacities of a scene file need all its spheres in memory");
            return Err(Error::settings(problem, format!("remove the opacities of the scene, or {STREAM}")));
        }
        let colored = files.iter().map(|file| file.is_colored(&watch));
        let is_colored = own.colors.is_some() || colored.collect::<Result<Vec<_>>>()?.contains(&true);
        Ok(Self { own: rows_of(own), files, is_colored, watch })
    }

    /// Passes all spheres on; what remains are messages.
    fn pass(mut self, survey: &Survey) -> Result<Option<Particles>> {
        survey.take_spheres(&mut self.own, true)?;
        let mut rest = Particles::default();
        for file in &self.files {
            rest.skipped.assumed.extend(file.pass(survey, &self.watch)?);
        }
        Ok(Some(rest))
    }
}

/// The parts of a file while they are read, and the thread that reads them; whether the spheres of a scene have colours.
pub(super) type Started = (Option<bool>, Receiver<Part>, JoinHandle<Result<Option<Particles>>>);

/// Starts to read a file in parts, where these columns are known to have texts.
pub(super) fn start(source: SceneSource, options: &ReadOptions, texts: Vec<String>) -> Result<Started> {
    let (sender, parts) = sync_channel(AHEAD);
    let survey = Survey::passing(sender, blocks::at_most(BLOCK)).with_texts(texts);
    let (scene, read): (_, Box<dyn FnOnce() -> Result<Option<Particles>> + Send>) = if source.format == Format::NATIVE {
        if !(options.particles.select.is_empty() && options.particles.hide.is_empty()) {
            return Err(no_selections());
        }
        let scene = InBlocks::open(source, options)?;
        (Some(scene.is_colored), Box::new(move || scene.pass(&survey)))
    } else {
        let passing = halfline_particles::ParticleOptions { survey: Some(survey), ..options.reading() };
        let Ok(frames) = open_particles(source, &passing)? else {
            return Err(Error::settings("scenes are not read as a stream", format!("remove {STREAM}")));
        };
        let number = options.particles.frames.numbers().next().unwrap_or(1);
        // The thread must hold the only sender, so that the receiver sees the end.
        (None, Box::new(move || frame(frames, number)))
    };
    let reader = thread::Builder::new().name("halfline blocks".into()).spawn(read);
    let reader = reader.map_err(|e| Error::Limits {
        problem: format!("no thread could be started to read the file: {e}"),
        mend: format!("allow the process more threads, or remove {STREAM}"),
    })?;
    Ok((scene, parts, reader))
}

/// Reads one frame, whose parts are passed on; returns the rest of it.
fn frame(mut frames: Box<dyn ParticleFrames>, number: u64) -> Result<Option<Particles>> {
    for _ in 1..number {
        if !frames.skip()? {
            return Ok(None);
        }
    }
    let rest = frames.next()?;
    // The rest must not hold the sender: the receiver waits for the end of all parts before it takes it.
    Ok(rest.map(|rest| Particles { reading: Default::default(), ..rest }))
}

/// Surveys the colours of a file, reading until their scale is certain; `None` where a part has no colours. Errors of
/// rows are reported when their block is used, not here.
pub(super) fn colors_of(path: &Path, options: &ReadOptions) -> Result<Option<ColorSurvey>> {
    let source = SceneSource::open(path, options.particles.known_format(), &options.particles.watch)?;
    let (_, parts, reader) = start(source, &ReadOptions { style: Style::default(), ..options.clone() }, Vec::new())?;
    let mut colors = ColorSurvey::default();
    for part in &parts {
        options.particles.watch.check()?;
        colors.see(part.color_type, &part.colors);
        if part.colors.is_empty() || colors.is_decided() {
            return Ok((!part.colors.is_empty()).then_some(colors));
        }
    }
    if let Ok(Ok(Some(rest))) = reader.join() {
        colors.see(rest.color_type, &rest.colors);
    }
    Ok(Some(colors))
}

/// The columns among these in which some row of the frame has a text. None where the file cannot be read to its end, so that the
/// error is reported at its row.
pub(super) fn texts_of(path: &Path, options: &ReadOptions, columns: &[String]) -> Result<Vec<String>> {
    let source = SceneSource::open(path, options.particles.known_format(), &options.particles.watch)?;
    let survey = Survey::default();
    let reading = options.reading();
    let request = Request { columns: columns.to_vec(), survey: Some(survey.clone()), ..reading.request(source.format) };
    let Ok(frames) = listed(source, request, &reading)? else { return Ok(Vec::new()) };
    let Ok(Some(rest)) = frame(frames, options.particles.frames.numbers().next().unwrap_or(1)) else {
        return Ok(Vec::new());
    };
    let counts = rest.counted(&survey);
    Ok(counts.columns.into_iter().filter(|(_, column)| column.is_text()).map(|(name, _)| name).collect())
}
