//! Scenes in sequence: the frames of a trajectory, or the single scene of a file.

use super::options::{Hold, ReadOptions};
use super::sphere_lights::SphereLights;
use super::style::no_selections;
use super::{native, nff};
use halfline::error::{Error, Place, Result};
use halfline::frame::legend::Legend;
use halfline::progress::Watch;
use halfline::quote::count;
use halfline::quote::setting::{FRAMES, HOLD, MODEL, RANGE, UNWRAP, WRAP};
use halfline::scene::arrange::{Arrangement, Bead};
use halfline::scene::camera::{Aperture, Camera};
use halfline::scene::instances::Instances;
use halfline::scene::{Cell, CutPlane, Framing, ImagePlane, Lighting, Scene, Spheres};
use halfline::settings::FileLook;
use halfline_particles::input::Input;
use halfline_particles::open::open;
use halfline_particles::opened::SceneSource;
use halfline_particles::particles::frame::{ParticleFrames, Particles};
use halfline_particles::particles::periodic::no_cell;
use halfline_particles::select::{self, Note};
use halfline_particles::{Columns, Format, FrameTime, Keep, ParticleOptions, Periodic, Selection, Skipped};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An opened file of scenes.
pub struct Sequence {
    path: PathBuf,
    options: ReadOptions,
    /// The options for the readers, which keep the columns of the style and of all selections.
    reading: ParticleOptions,
    format: Format,
    state: SequenceState,
    /// The number of frames read so far.
    passed: u64,
    /// The files that the scene file refers to, and the topology.
    files: Vec<PathBuf>,
    /// Whether a frame that was read has set the default radius of the following ones, and their colours.
    holds_radius: bool,
    holds: bool,
    /// Warnings about frames that were read but are not selected. The next selected frame reports them.
    warnings: Vec<String>,
    /// The number of frames, once the end was reached.
    total: Option<u64>,
    /// Whether the path can be opened again.
    is_file: bool,
}

enum SequenceState {
    /// A format that contains a whole scene.
    One(Option<Box<SceneFrame>>),
    Many(Box<dyn ParticleFrames>),
}

/// One scene of a sequence.
#[derive(Debug, Clone)]
pub struct SceneFrame {
    /// The frame's number, from 1.
    pub number: u64,
    /// The scene; where the file has no camera, with one that shows all of it.
    pub scene: Scene,
    /// The items that the reader left out, and its assumptions.
    pub skipped: Skipped,
    /// Whether the file has a camera.
    pub has_camera: bool,
    /// Whether the file holds particles, and the look and the samples per pixel that it asks for.
    pub look: FileLook,
    /// The size of its camera's lens; `None` for a pinhole.
    pub aperture: Option<Aperture>,
    /// The planes of its file that cut spheres.
    pub cuts: Vec<CutPlane>,
    /// A warning about spheres that hide what the camera looks at, unless planes cut them.
    pub hidden: Option<String>,
    /// The legend of the colours, where they come from a column.
    pub legend: Option<Legend>,
    /// The columns of the particles that [`ParticleOptions::keep`](super::ParticleOptions::keep) keeps, in the order of the spheres.
    pub columns: Arc<Columns>,
    /// The periodic cell, if the file has one.
    pub cell: Option<Cell>,
    /// The spheres, where an assembly is kept as operators ([`ParticleOptions::as_operators`](super::ParticleOptions::as_operators)). The scene then has none.
    pub instances: Option<Instances>,
    /// Its time and step, as far as the file has them.
    pub when: FrameTime,
    /// Whether it is of atoms without a box around them, whose default camera follows their principal axes. True for a format
    /// of molecules ([`Format::is_of_molecules`]), with an element; for XYZ only without a cell.
    pub is_molecule: bool,
    /// The number of the last spheres of the scene that are beads along the edges of a cell.
    pub beads: usize,
    /// The spheres of each of [`ReadOptions::marks`].
    pub marks: Vec<Focus>,
}

/// The spheres of a frame that a selection selects.
#[derive(Debug, Clone, Default)]
pub struct Focus {
    /// The expression.
    pub text: String,
    /// The selected spheres that [`ParticleOptions::select`](super::ParticleOptions::select) and [`ParticleOptions::hide`](super::ParticleOptions::hide) leave in the frame.
    pub spheres: Spheres,
    /// Messages about the expression, such as the values that the file has instead of one that no particle has.
    pub notes: Vec<String>,
}

/// The warning about a frame that is not selected and cannot set radii and colours because of this error.
fn unusable_frame(number: u64, error: &Error) -> String {
    let problem = match error {
        Error::Settings { problem, .. } => problem.clone(),
        other => other.to_string(),
    };
    format!("frame {number} is not what the others are held to: {problem}")
}

/// The words for clip planes that leave none of so many spheres.
#[must_use]
pub fn all_clipped(spheres: u64) -> String {
    // Marked as the names of `quote::setting` are.
    format!("`\u{2060}clip` removes all {} of the file", count(spheres, "sphere"))
}

/// The marks of spheres by their masks.
fn marks(options: &ReadOptions, masks: Vec<(Vec<bool>, Vec<Note>)>, spheres: &Spheres) -> Vec<Focus> {
    let focus = |(selection, (mask, notes)): (&Selection, (Vec<bool>, Vec<Note>))| Focus {
        text: selection.to_string(),
        spheres: spheres.part(&mask),
        notes: notes.iter().map(Note::to_string).collect(),
    };
    options.marks.iter().zip(masks).map(focus).collect()
}

impl SceneFrame {
    /// The scene of these spheres of particles, with the default camera.
    ///
    /// # Errors
    /// As [`Camera::fit`].
    pub fn of_particles(number: u64, spheres: Spheres, is_molecule: bool) -> Result<Self> {
        let (camera, image, lighting) = (Camera::CANONICAL, ImagePlane::default(), Lighting::default());
        let mut scene = Scene { camera, image, spheres, lighting };
        scene.frame_by_default(is_molecule, &Framing::default())?;
        Ok(Self { is_molecule, ..Self::new(number, scene) })
    }

    /// The scene of particles with nothing else known about them.
    #[must_use]
    pub fn new(number: u64, scene: Scene) -> Self {
        Self {
            number,
            scene,
            skipped: Skipped::default(),
            has_camera: false,
            aperture: None,
            cuts: Vec::new(),
            hidden: None,
            look: FileLook::PARTICLES,
            legend: None,
            columns: Arc::default(),
            cell: None,
            instances: None,
            when: FrameTime::default(),
            is_molecule: false,
            beads: 0,
            marks: Vec::new(),
        }
    }

    /// The spheres that a selection selects, as flags, and the messages about it; as [`Columns::select`].
    ///
    /// # Errors
    /// As [`Columns::select`].
    pub fn selected(&self, selection: &Selection) -> Result<(Vec<bool>, Vec<String>)> {
        self.columns.select(selection, &self.scene.spheres.centers, &self.scene.spheres.radii)
    }

    /// Arranges the spheres, and with them their columns and the lights that are spheres. Says so where clip planes remove all.
    ///
    /// # Errors
    /// As [`Arrangement::apply`].
    pub fn arrange(&mut self, arrangement: &Arrangement, watch: &Watch) -> Result<()> {
        if *arrangement == Arrangement::default() {
            return Ok(());
        }
        let lights = SphereLights::of(&self.scene);
        let (spheres, cell) = (&mut self.scene.spheres, self.cell.as_ref());
        // The beads of an outline are no spheres of the file.
        let alone = Arrangement { outline: None, ..arrangement.clone() };
        if alone.leaves_nothing(spheres, cell, watch)? {
            self.skipped.assumed.push(all_clipped(spheres.len() as u64));
        }
        let needs_rows = !self.columns.is_empty() || arrangement.outline.is_some();
        let rows = needs_rows.then(|| arrangement.rows(spheres, cell, watch)).transpose()?;
        arrangement.apply(spheres, cell, watch)?;
        lights.follow(&mut self.scene);
        let spheres = &self.scene.spheres;
        if let Some(rows) = rows {
            self.beads = spheres.len().saturating_sub(rows.len());
            self.columns = self.columns.rearranged(&rows, self.beads)?.into();
        }
        Ok(())
    }

    /// Draws the edges of this cell as beads after all other spheres. The columns still describe only the spheres before the beads.
    ///
    /// # Errors
    /// As [`Arrangement::apply`].
    pub fn outline(&mut self, cell: Option<&Cell>, bead: Bead) -> Result<()> {
        let spheres = &mut self.scene.spheres;
        let before = spheres.len();
        let arrangement = Arrangement { outline: Some(bead), ..Arrangement::default() };
        arrangement.apply(spheres, cell, &Watch::default())?;
        spheres.share();
        self.beads += spheres.len() - before;
        Ok(())
    }

    /// A copy that shares its spheres and its columns with this one.
    pub fn copy(&mut self) -> Self {
        self.scene.spheres.share();
        self.clone()
    }
}

impl Sequence {
    /// Opens `path`; `-` is standard input.
    ///
    /// # Errors
    /// As [`scene`](super::scene).
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self> {
        let sequence = Self::of_source(
            SceneSource::open(path, options.particles.known_format(), &options.particles.watch)?,
            path,
            options,
        )?;
        Ok(Self { is_file: path.is_file(), ..sequence })
    }

    /// Opens the stream `reader`, compressed or not. Errors refer to it by `path`, whose extension may determine the
    /// format, and whose folder contains the files that a scene refers to.
    ///
    /// # Errors
    /// As [`scene`](super::scene).
    pub fn from_reader(reader: impl Read + Send + 'static, path: &Path, options: &ReadOptions) -> Result<Self> {
        let input = Input::of(Box::new(reader), &options.particles.watch).map_err(|e| Error::read(path, e))?;
        Self::of_source(SceneSource::of(input, path, options.particles.known_format())?, path, options)
    }

    /// The scenes of an opened source.
    pub(super) fn of_source(source: SceneSource, path: &Path, options: &ReadOptions) -> Result<Self> {
        let mut files: Vec<PathBuf> =
            options.particles.topology.iter().chain(&options.particles.added).cloned().collect();
        let format = source.format;
        let reading = options.reading();
        let state = match open(source, &reading)? {
            Ok(frames) => SequenceState::Many(frames),
            Err(source) => {
                let warning = source.warning.clone();
                let native::Read { mut scene, mut skipped, look, aperture, cuts, files: named } =
                    match source.format.name() {
                        "nff" => native::Read::of(nff::read(source.reader, path, options.particles.strict)?),
                        _ => native::read(source.reader, path, &options.particles.watch)?,
                    };
                files.extend(named);
                skipped.assumed.extend(warning);
                if !(options.particles.select.is_empty() && options.particles.hide.is_empty()) {
                    return Err(no_selections());
                }
                match options.particles.periodic {
                    Periodic::AsListed => {}
                    Periodic::Wrap => return Err(no_cell(WRAP)),
                    Periodic::Unwrap => return Err(no_cell(UNWRAP)),
                }
                options.style.restyle(&mut scene.spheres)?;
                let frame = SceneFrame { skipped, has_camera: true, look, aperture, cuts, ..SceneFrame::new(1, scene) };
                SequenceState::One(Some(Box::new(frame)))
            }
        };
        let (path, options) = (path.to_path_buf(), options.clone());
        Ok(Self {
            path,
            options,
            reading,
            format,
            state,
            passed: 0,
            files,
            holds_radius: false,
            holds: false,
            warnings: Vec::new(),
            total: None,
            is_file: false,
        })
    }

    /// The number of frames that were read or passed over.
    #[must_use]
    pub fn passed(&self) -> u64 {
        self.passed
    }

    /// The number of frames of the file, once its end was reached.
    #[must_use]
    pub fn total(&self) -> Option<u64> {
        self.total
    }

    /// Its format.
    #[must_use]
    pub fn format(&self) -> Format {
        self.format
    }

    /// The files that the scene file refers to, and the topology of a trajectory, which were read with it.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// The first frame of the file that has spheres, where the following ones are held to it but it is not selected. It
    /// must be called before every [`Sequence::next_scene`], which does the same and drops the frame.
    ///
    /// # Errors
    /// As [`scene`](super::scene).
    pub fn unselected_first(&mut self) -> Result<Option<SceneFrame>> {
        let ReadOptions { hold, particles, .. } = &self.options;
        let (hold, selected, model, watch) =
            (*hold, particles.frames.clone(), particles.model, particles.watch.clone());
        if self.holds || hold == Hold::None || model.is_some() {
            return Ok(None);
        }
        let last = selected.last();
        while self.passed < last && !selected.contains(self.passed + 1) {
            watch.check()?;
            let SequenceState::Many(frames) = &mut self.state else { break };
            let particles = match frames.next() {
                Err(error @ Error::Scene { .. }) => {
                    self.pass_invalid(error)?;
                    continue;
                }
                next => next?,
            };
            let Some(particles) = particles else {
                self.total = Some(self.passed);
                return Ok(None);
            };
            self.passed += 1;
            if particles.positions.is_empty() {
                continue;
            }
            let number = self.passed;
            let mut messages = particles.skipped.assumed.clone();
            let frame = match self.styled_frame(particles, number) {
                // The frames that are selected need not lack what this one does.
                Err(error @ (Error::Settings { .. } | Error::Scene { .. })) => {
                    messages.push(unusable_frame(number, &error));
                    self.warnings.extend(messages);
                    continue;
                }
                styled => styled?,
            };
            if !frame.scene.spheres.is_empty() {
                self.warnings.extend(messages);
                return Ok(Some(frame));
            }
        }
        Ok(None)
    }

    /// Passes over the next frame, which has this error and is not selected, as if it had not been read: the file is opened again.
    ///
    /// # Errors
    /// The same where the frame cannot be passed over, or the file is a stream.
    fn pass_invalid(&mut self, error: Error) -> Result<()> {
        let again = || -> Result<Option<Box<dyn ParticleFrames>>> {
            let source =
                SceneSource::open(&self.path, self.options.particles.known_format(), &self.options.particles.watch)?;
            let Ok(mut frames) = open(source, &self.reading)? else { return Ok(None) };
            for _ in 0..=self.passed {
                if !frames.skip()? {
                    return Ok(None);
                }
            }
            Ok(Some(frames))
        };
        let again = if self.is_file { again().ok().flatten() } else { None };
        let Some(frames) = again else { return Err(error) };
        self.state = SequenceState::Many(frames);
        self.passed += 1;
        self.warnings.push(unusable_frame(self.passed, &error));
        Ok(())
    }

    /// The scene of a frame's particles; the first with spheres sets what the following ones are held to.
    fn styled_frame(&mut self, mut particles: Particles, number: u64) -> Result<SceneFrame> {
        let file = Place::file(self.path.display().to_string());
        let (cell, when, is_molecule) = (particles.cell, particles.when, {
            let has_elements = particles.elements.iter().any(|number| *number != 0);
            self.format.is_molecule(has_elements, particles.cell.is_some())
        });
        self.options.particles.watch.check()?;
        self.reading.prepare(&mut particles)?;
        self.options.style.settle(&mut particles);
        let spaced = self.options.style.spaced(&particles);
        let hold = self.options.hold;
        if hold != Hold::None && !self.holds_radius && !particles.positions.is_empty() {
            self.holds_radius = true;
            self.options.style.default_radius = spaced;
        }
        let notes = select::apply(&self.options.selections(), &mut particles)?;
        particles.skipped.assumed.extend(notes.iter().map(ToString::to_string));
        if !particles.placed.is_empty() {
            // Copies are one frame, which nothing is held to.
            let (instances, skipped, legend) = self.options.style.to_instances(particles, spaced, &file)?;
            let frame = SceneFrame::of_particles(number, Spheres::default(), is_molecule)?;
            return Ok(SceneFrame { skipped, legend, instances: Some(instances), when, ..frame });
        }
        let columns = self.columns(&mut particles)?.into();
        let masks = std::mem::take(&mut particles.marks);
        let (spheres, mut skipped, legend) = self.options.style.to_spheres(particles, spaced, &file)?;
        if hold != Hold::None && !self.holds && !spheres.is_empty() {
            self.holds = true;
            let (frames, flat) = (&self.options.particles.frames, legend.as_ref().filter(|legend| legend.is_flat()));
            if let Some(Legend { name, range: [value, _], .. }) = flat.filter(|_| hold == Hold::First)
                && (frames.count() > 1 || !frames.contains(number))
            {
                let warning = format!(
                    "all values of {name} in frame {number} are {value}, and the colours of the other frames are held to this \
                     range; use {RANGE} LOW,HIGH or {HOLD} all"
                );
                let film_warnings = if frames.contains(number) { &mut skipped.assumed } else { &mut self.warnings };
                film_warnings.push(warning);
            }
            self.options.style.hold(legend.as_ref(), hold == Hold::First);
        }
        self.options.particles.watch.check()?;
        let marks = marks(&self.options, masks, &spheres);
        let frame = SceneFrame::of_particles(number, spheres, is_molecule)?;
        Ok(SceneFrame { skipped, legend, columns, cell, when, marks, ..frame })
    }

    /// The columns that the scene of these particles keeps.
    fn columns(&self, particles: &mut Particles) -> Result<Columns> {
        if self.options.particles.keep == Keep::Nothing {
            return Ok(Columns::default());
        }
        let columns = Columns::of(particles)?;
        // A frame without particles may have no columns either.
        if let (Keep::Named(words), false) = (&self.options.particles.keep, particles.positions.is_empty()) {
            words.iter().try_for_each(|word| columns.get(word).map(drop))?;
        }
        Ok(columns)
    }

    /// The next selected frame; `None` after the last.
    ///
    /// # Errors
    /// As [`scene`](super::scene).
    pub fn next_scene(&mut self) -> Result<Option<SceneFrame>> {
        self.unselected_first()?;
        while self.passed < self.options.particles.frames.last() {
            self.options.particles.watch.check()?;
            let number = self.passed + 1;
            let is_requested = self.options.particles.frames.contains(number);
            self.passed = number;
            let is_there = match &mut self.state {
                SequenceState::One(frame) => match frame.take() {
                    Some(frame) if is_requested => {
                        let masks = {
                            let spheres = &frame.scene.spheres;
                            select::marks_of(&self.options.marks, 0, &spheres.centers, &spheres.radii)?
                        };
                        let marks = marks(&self.options, masks, &frame.scene.spheres);
                        return Ok(Some(SceneFrame { number, marks, ..*frame }));
                    }
                    frame => frame.is_some(),
                },
                SequenceState::Many(frames) if is_requested => {
                    match frames.next().map_err(|e| self.options.particles.frames.until(number, e))? {
                        Some(mut particles) => {
                            // A reader says what concerns the whole file in its first frame.
                            for warning in std::mem::take(&mut self.warnings) {
                                if !particles.skipped.assumed.contains(&warning) {
                                    particles.skipped.assumed.push(warning);
                                }
                            }
                            return self.styled_frame(particles, number).map(Some);
                        }
                        None => false,
                    }
                }
                SequenceState::Many(frames) => {
                    frames.skip().map_err(|e| self.options.particles.frames.until(number, e))?
                }
            };
            if !is_there {
                self.total = Some(number - 1);
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// Passes over the next frame, whether it is selected or not; `false` behind the last one.
    ///
    /// # Errors
    /// [`Error::Interrupted`], and errors of reading.
    pub fn pass(&mut self) -> Result<bool> {
        self.options.particles.watch.check()?;
        let passed = match &mut self.state {
            SequenceState::One(frame) => frame.take().is_some(),
            SequenceState::Many(frames) => frames.skip()?,
        };
        self.passed += u64::from(passed);
        Ok(passed)
    }

    /// The error for a sequence without a selected frame.
    #[must_use]
    pub fn nothing(&self) -> Error {
        let place = Place::file(self.path.display().to_string());
        match self.passed {
            0 | 1 => Error::scene(place, "the file has no atoms or particles", "use a file with coordinates"),
            n => {
                let problem = format!("the file has {}, none of them selected", count(n - 1, "frame"));
                Error::scene(place, problem, format!("use other {FRAMES}, or another {MODEL}"))
            }
        }
    }
}
