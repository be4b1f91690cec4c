//! Scenes one after the other: the frames of a trajectory, or the one scene of a file.

use super::fit::Framing;
use super::input::Input;
use super::particles::{self, Frames};
use super::source::{Format, Source};
use super::style::Legend;
use super::{Cell, ImagePlane, ReadOptions, Scene, native, nff};
use crate::camera::Camera;
use crate::error::{Error, Place, Result};
use crate::memory::check_spheres;
use std::io::Read;
use std::path::{Path, PathBuf};

/// An opened file of scenes.
pub struct Sequence {
    path: PathBuf,
    options: ReadOptions,
    state: State,
    /// Frames that are behind.
    passed: u64,
    /// The files that the scene file names.
    files: Vec<PathBuf>,
}

enum State {
    /// A format that holds a whole scene.
    One(Option<Box<Scene>>),
    Many(Box<dyn Frames>),
}

/// One scene of a sequence.
#[derive(Debug, Clone)]
pub struct Shot {
    /// The frame's number, from 1.
    pub number: u64,
    /// What it shows; where the file has no camera, from one that shows all of it.
    pub scene: Scene,
    /// Whether the file has a camera.
    pub has_camera: bool,
    /// What the colours stand for, where they come from a column.
    pub legend: Option<Legend>,
    /// The periodic cell, if the file has one.
    pub cell: Option<Cell>,
}

impl Shot {
    /// A copy.
    ///
    /// # Errors
    /// [`Error::Limits`] where the memory has no room for it.
    pub fn copy(&self) -> Result<Self> {
        check_spheres(self.scene.spheres.len() as u64, self.scene.spheres.colors.is_some())?;
        Ok(self.clone())
    }
}

impl Sequence {
    /// Opens `path`; `-` is standard input.
    ///
    /// # Errors
    /// Those of [`Scene::read`].
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self> {
        Self::begin(Source::open(path, options.format, &options.watch)?, path, options)
    }

    /// Opens what `reader` delivers, compressed or not; `path` names it in errors, its ending may tell the format, and its
    /// folder holds the files that a scene names.
    ///
    /// # Errors
    /// Those of [`Scene::read`].
    pub fn from_reader(reader: impl Read + Send + 'static, path: &Path, options: &ReadOptions) -> Result<Self> {
        let input = Input::of(Box::new(reader), &options.watch).map_err(|e| Error::read(path, e))?;
        Self::begin(Source::of(input, path, options.format)?, path, options)
    }

    fn begin(source: Source, path: &Path, options: &ReadOptions) -> Result<Self> {
        let mut files = Vec::new();
        let state = match particles::open(source, options)? {
            Ok(frames) => State::Many(frames),
            Err(source) => {
                let mut scene = match source.format {
                    Format::Nff => nff::read(source.reader, path, options)?,
                    _ => {
                        let (scene, named) = native::read(source.reader, path, &options.watch)?;
                        files = named;
                        scene
                    }
                };
                options.style.restyle(&mut scene.spheres)?;
                State::One(Some(Box::new(scene)))
            }
        };
        Ok(Self { path: path.to_path_buf(), options: options.clone(), state, passed: 0, files })
    }

    /// The files that the scene file names and that were read with it.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// The next frame that is asked for; `None` after the last.
    ///
    /// # Errors
    /// Those of [`Scene::read`].
    pub fn next_scene(&mut self) -> Result<Option<Shot>> {
        while self.passed < self.options.frames.last() {
            self.options.watch.check()?;
            let number = self.passed + 1;
            let wanted = self.options.frames.contains(number);
            let file = Place::file(self.path.display().to_string());
            self.passed = number;
            match &mut self.state {
                State::One(scene) => {
                    let Some(scene) = scene.take() else { return Ok(None) };
                    if wanted {
                        return Ok(Some(Shot { number, scene: *scene, has_camera: true, legend: None, cell: None }));
                    }
                }
                State::Many(frames) if wanted => {
                    let Some(particles) = frames.next()? else { return Ok(None) };
                    let cell = particles.cell;
                    self.options.watch.check()?;
                    let (spheres, skipped, legend) = self.options.style.dress(particles, &file)?;
                    self.options.watch.check()?;
                    let mut scene = Scene { camera: Camera::CANONICAL, image: ImagePlane::default(), spheres, skipped };
                    scene.frame_all(&Framing::default())?;
                    return Ok(Some(Shot { number, scene, has_camera: false, legend, cell }));
                }
                State::Many(frames) => {
                    if !frames.skip()? {
                        return Ok(None);
                    }
                }
            }
        }
        Ok(None)
    }

    /// The error for a sequence in which nothing was found.
    #[must_use]
    pub fn nothing(&self) -> Error {
        let place = Place::file(self.path.display().to_string());
        let problem = match self.passed {
            0 | 1 => "no frame was found".to_owned(),
            n => format!("no frame that was asked for is among the {} that the file has", n - 1),
        };
        Error::scene(place, problem, "ask for others with --frames, or for another --model")
    }
}
