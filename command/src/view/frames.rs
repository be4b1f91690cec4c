//! The frames of the file, as one set of options reads them, or a frame in memory. The last ones are kept.

use super::reading::{Reading, open};
use crate::scene_args::SceneArgs;
use crate::scene_frames::arrange;
use halfline::camera::Camera;
use halfline::error::{Error, Result};
use halfline::quote::count;
use halfline_files::read::{Format, SceneFrame};
use std::collections::VecDeque;
use std::ffi::OsString;

/// The most spheres of the frames that are kept besides the last one.
const KEPT: usize = 1 << 22;

/// The frames of a file for one set of options.
pub(super) struct Frames {
    words: Vec<OsString>,
    /// The options of reading; `None` for a frame in memory.
    args: Option<SceneArgs>,
    /// The reading, which goes on behind the last frame that was read.
    reading: Option<Reading>,
    /// The number of frames that it has read.
    passed: u64,
    /// Frames with their clip planes, copies and outline.
    kept: VecDeque<SceneFrame>,
    /// The number of frames, once the end was reached.
    pub(super) total: Option<u64>,
    /// The camera of all frames, with `--hold all`.
    fixed: Option<Camera>,
    /// The file's format, once it was opened.
    pub(super) format: Option<Format>,
}

/// A file whose frames are counted.
pub(super) struct Count {
    reading: Reading,
    count: u64,
}

impl Count {
    /// The number of frames of the file; `None` where one cannot be read.
    pub(super) fn end(mut self) -> Option<u64> {
        while self.reading.pass().ok()? {
            self.count += 1;
        }
        Some(self.count)
    }
}

impl Frames {
    /// The frames that `args`, which are of these words, read.
    pub(super) fn new(words: Vec<OsString>, args: SceneArgs) -> Self {
        Self {
            words,
            args: Some(args),
            reading: None,
            passed: 0,
            kept: VecDeque::new(),
            total: None,
            fixed: None,
            format: None,
        }
    }

    /// Frames in memory, with the colours that these words say.
    pub(super) fn in_memory(words: Vec<OsString>, frames: Vec<SceneFrame>) -> Self {
        let (total, kept) = (Some(frames.len() as u64), VecDeque::from(frames));
        Self { words, args: None, reading: None, passed: 0, kept, total, fixed: None, format: None }
    }

    /// Whether frame `number` is there without reading.
    pub(super) fn has(&self, number: u64) -> bool {
        self.kept.iter().any(|kept| kept.number == number)
    }

    /// Whether they are read with these words.
    pub(super) fn are_of(&self, words: &[OsString]) -> bool {
        self.words == words
    }

    /// The camera that all frames share under `--hold all`, else `None`; see [`Self::framed`] for `first`.
    ///
    /// # Errors
    /// Errors of reading the file.
    pub(super) fn fixed_camera(&mut self, first: u64) -> Result<Option<Camera>> {
        if self.passed == 0 {
            self.framed(first)?;
        }
        Ok(self.fixed)
    }

    /// The frame whose camera all have: the first one of the file, unless it is invalid or lacks a column. Then it is frame `first`,
    /// with which the page begins.
    ///
    /// # Errors
    /// Errors of reading the file.
    pub(super) fn framed(&mut self, first: u64) -> Result<&mut SceneFrame> {
        let number = match self.get(1) {
            Err(Error::Settings { .. } | Error::Scene { .. }) => first,
            frame => frame.map(|_| 1)?,
        };
        self.get(number)
    }

    /// Frame `number` of the file, from 1.
    ///
    /// # Errors
    /// Errors of reading the file and of arranging the frame; [`Error::Settings`] for a number beyond the last frame.
    pub(super) fn get(&mut self, number: u64) -> Result<&mut SceneFrame> {
        let at = self.kept.iter().position(|kept| kept.number == number);
        let at = at.map_or_else(|| self.read(number), Ok)?;
        Ok(&mut self.kept[at])
    }

    /// Counts the frames behind the last one that was read, if there are any. They are read again when they are shown.
    pub(super) fn count(&mut self) -> Option<Count> {
        let mut reading = self.reading.take()?;
        match reading.pass() {
            Ok(false) => self.total = Some(self.passed),
            Ok(true) => return Some(Count { reading, count: self.passed + 1 }),
            // It is an error when it is shown.
            Err(_) => {}
        }
        None
    }

    /// Reads frame `number`; its place among those that are kept.
    fn read(&mut self, number: u64) -> Result<usize> {
        if self.args.is_none() || self.total.is_some_and(|total| number > total) {
            return Err(self.beyond(number));
        }
        let going_on = self.reading.take().filter(|_| self.passed < number);
        let mut is_new = going_on.is_none();
        let mut reading = going_on.map_or_else(|| self.open(number), Ok)?;
        loop {
            let next = match reading.next_scene() {
                // An invalid frame before the wanted one: the file is opened again, and reading begins at the wanted one.
                Err(Error::Settings { .. } | Error::Scene { .. }) if !is_new && reading.passed() < number => {
                    (reading, is_new) = (self.open(number)?, true);
                    continue;
                }
                next => next?,
            };
            let Some(mut frame) = next else {
                let Some(total) = reading.total().filter(|total| *total > 0) else { return Err(reading.nothing()) };
                self.total = Some(total);
                return Err(self.beyond(number));
            };
            self.passed = frame.number;
            if frame.number == number {
                if let Some(args) = &self.args {
                    arrange(&args.read, &mut frame)?;
                }
                frame.scene.spheres.share();
                frame.scene.check()?;
                self.keep(frame);
                self.reading = Some(reading);
                return Ok(self.kept.len() - 1);
            }
        }
    }

    /// Opens the file for its frames from this one on.
    fn open(&mut self, number: u64) -> Result<Reading> {
        self.passed = 0;
        let Some(args) = &self.args else { return Err(self.beyond(number)) };
        let (reading, fixed) = open(args, number)?;
        self.fixed = fixed.map(|(camera, _)| camera);
        self.format = Some(reading.format());
        Ok(reading)
    }

    fn keep(&mut self, frame: SceneFrame) {
        self.kept.push_back(frame);
        let size = |kept: &SceneFrame| kept.scene.spheres.len().max(1);
        let mut all: usize = self.kept.iter().map(size).sum();
        while self.kept.len() > 1 && all > KEPT {
            all -= self.kept.pop_front().as_ref().map_or(0, size);
        }
    }

    fn beyond(&self, number: u64) -> Error {
        let total = self.total.unwrap_or(self.passed);
        Error::settings(
            format!("there is no frame {number}: the file has {}", count(total, "frame")),
            "use another frame",
        )
    }
}
