//! The source of a scene: a file or standard input, compressed or not, whose format is detected from its content.

use super::detect::recognise;
use super::format::Format;
use super::input::Input;
use crate::error::{Error, Place, Result};
use crate::progress::Watch;
use std::path::{Path, PathBuf};

/// An opened scene file.
pub(super) struct SceneSource {
    /// Its bytes.
    pub(super) reader: Input,
    /// The path as the user gave it; `-` is standard input.
    pub(super) path: PathBuf,
    /// Its format.
    pub(super) format: Format,
}

/// Bytes that are inspected to detect the format.
const LOOK: u64 = 1 << 16;

impl SceneSource {
    /// Opens `path`; the format is `format`, or detected from the content, or from the name.
    ///
    /// # Errors
    /// Those of [`Input::open`], and [`Error::Scene`] for a file whose format is not detected.
    pub(super) fn open(path: &Path, format: Option<Format>, watch: &Watch) -> Result<Self> {
        Self::of(Input::open(path, watch)?, path, format)
    }

    /// Opens bytes that errors refer to by `path`.
    ///
    /// # Errors
    /// As [`SceneSource::open`].
    pub(super) fn of(mut reader: Input, path: &Path, format: Option<Format>) -> Result<Self> {
        let mut name = path.to_path_buf();
        if reader.is_packed() {
            name.set_extension("");
        }
        let start = reader.look(LOOK).map_err(|e| Error::read(path, e))?;
        let format = match format {
            Some(format) => format,
            None => recognise(&start, &name)
                .map_err(|(problem, mend)| Error::scene(Place::file(path.display().to_string()), problem, mend))?,
        };
        Ok(Self { reader, path: path.to_path_buf(), format })
    }
}

#[cfg(test)]
impl SceneSource {
    /// A source from text, for the readers' tests; readers do not use `format`.
    pub(super) fn of_text(text: &str) -> Self {
        Self::of_bytes(text.as_bytes())
    }

    /// As [`SceneSource::of_text`].
    pub(super) fn of_bytes(bytes: &[u8]) -> Self {
        Self { reader: Input::of_bytes(bytes), path: "text".into(), format: Format::Native }
    }
}
