//! The source of a scene: a file or standard input, compressed or not, whose format is detected from its content.

use super::detect::recognise;
use super::format::Format;
use super::input::Input;
use super::options::ReadOptions;
use crate::error::{Error, Place, Result};
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
    /// Opens `path`; the format is that of the options, or detected from the content, or from the name. A file whose
    /// columns are named is a table if nothing else is detected.
    ///
    /// # Errors
    /// Those of [`Input::open`], and [`Error::Scene`] for an empty file and for one whose format is not detected.
    pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Self> {
        Self::of(Input::open(path, &options.watch)?, path, options)
    }

    /// Opens bytes that errors refer to by `path`.
    ///
    /// # Errors
    /// As [`SceneSource::open`].
    pub(super) fn of(mut reader: Input, path: &Path, options: &ReadOptions) -> Result<Self> {
        let mut name = path.to_path_buf();
        if reader.is_packed() {
            name.set_extension("");
        }
        let start = reader.look(LOOK).map_err(|e| Error::read(path, e))?;
        let format = match (options.format, recognise(&start, &name)) {
            (Some(format), _) | (None, Ok(format)) => format,
            (None, Err(_)) if !options.columns_named.is_empty() => Format::Csv,
            (None, Err((problem, mend))) => {
                return Err(Error::scene(Place::file(path.display().to_string()), problem, mend));
            }
        };
        // The reader of scenes says more: what a scene needs.
        if start.is_empty() && !matches!(format, Format::Native | Format::Nff) {
            let place = Place::file(path.display().to_string());
            return Err(Error::scene(place, "the file is empty", "use a file with particles"));
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_file_is_called_empty() {
        let open = |format| {
            let options = ReadOptions { format, ..ReadOptions::default() };
            SceneSource::of(Input::of_bytes(b""), Path::new("a.xyz"), &options)
        };
        for format in [None, Some(Format::Pdb)] {
            let error = open(format).map(drop).expect_err("nothing").to_string();
            assert!(error.starts_with("a.xyz: the file is empty"), "{error}");
        }
    }
}
