//! The frames of a file of particles, moved, completed and selected as the options ask for.

use super::format::Format;
use super::input::Input;
use super::open::open;
use super::opened::SceneSource;
use super::options::ParticleOptions;
use super::particles::frame::{ParticleFrames, Particles};
use super::select::{Selections, apply};
use halfline_ground::error::{Error, Place, Result};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The selected frames of a file, one after the other.
pub struct Frames {
    frames: Box<dyn ParticleFrames>,
    options: ParticleOptions,
    format: Format,
    path: PathBuf,
    passed: u64,
    has_ended: bool,
}

impl Frames {
    /// Opens `path`; `-` is standard input. Files may be compressed by gzip, bzip2, xz or Zstandard. The format is detected from the
    /// content, then from the name.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that cannot be read, [`Error::Scene`] for content that is not of particles, [`Error::Settings`] for
    /// options that do not apply to it.
    pub fn open(path: &Path, options: &ParticleOptions) -> Result<Self> {
        Self::of(SceneSource::open(path, options.known_format(), &options.watch)?, options)
    }

    /// The frames of a stream. Errors refer to it by `path`, whose extension may determine the format.
    ///
    /// # Errors
    /// As [`Frames::open`].
    pub fn from_reader(reader: impl Read + Send + 'static, path: &Path, options: &ParticleOptions) -> Result<Self> {
        let input = Input::of(Box::new(reader), &options.watch).map_err(|error| Error::read(path, error))?;
        Self::of(SceneSource::of(input, path, options.known_format())?, options)
    }

    fn of(source: SceneSource, options: &ParticleOptions) -> Result<Self> {
        let (format, path) = (source.format, source.path.clone());
        let Ok(frames) = open(source, options)? else {
            let problem = format!("this is a scene ({}), not a file of particles", format.name());
            let mend = "read it with the crate halfline-files";
            return Err(Error::scene(Place::file(path.display().to_string()), problem, mend));
        };
        Ok(Self { frames, options: options.clone(), format, path, passed: 0, has_ended: false })
    }

    /// The format of the file.
    #[must_use]
    pub fn format(&self) -> Format {
        self.format
    }

    /// The number of frames that were read or passed over, which is the number of the last frame.
    #[must_use]
    pub fn passed(&self) -> u64 {
        self.passed
    }

    fn next_frame(&mut self) -> Result<Option<Particles>> {
        while self.passed < self.options.frames.last() {
            self.options.watch.check()?;
            let number = self.passed + 1;
            let until = |error| self.options.frames.until(number, error);
            if self.options.frames.contains(number) {
                let Some(mut frame) = self.frames.next().map_err(until)? else { break };
                self.passed = number;
                self.options.prepare(&mut frame)?;
                let ParticleOptions { select, hide, .. } = &self.options;
                let selections = Selections { select, hide, marks: &[], rules: Default::default() };
                let notes = apply(&selections, &mut frame)?;
                frame.skipped.assumed.extend(notes.iter().map(ToString::to_string));
                return Ok(Some(frame));
            }
            if !self.frames.skip().map_err(until)? {
                break;
            }
            self.passed = number;
        }
        match self.passed {
            0 => {
                let place = Place::file(self.path.display().to_string());
                Err(Error::scene(place, "the file has no atoms or particles", "use a file with coordinates"))
            }
            _ => Ok(None),
        }
    }
}

impl Iterator for Frames {
    type Item = Result<Particles>;

    /// The next selected frame; nothing follows an error.
    fn next(&mut self) -> Option<Result<Particles>> {
        if self.has_ended {
            return None;
        }
        let next = self.next_frame().transpose();
        self.has_ended = !matches!(next, Some(Ok(_)));
        next
    }
}
