//! A file or standard input, compressed or not, whose format is detected from its content.

use super::detect::{is_foreign, recognise};
use super::format::Format;
use super::input::Input;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::progress::Watch;
use std::path::{Path, PathBuf};

/// An opened scene file.
pub struct SceneSource {
    /// Its bytes.
    pub reader: Input,
    /// The path as the user gave it; `-` is standard input.
    pub path: PathBuf,
    /// Its format.
    pub format: Format,
    /// The warning where name and content say different formats.
    pub warning: Option<String>,
}

/// The caller's knowledge of a file's format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KnownFormat {
    /// Nothing: it is detected from the content, then from the name.
    Nothing,
    /// It has this format.
    Given(Format),
    /// It has this format if no other is detected.
    IfNone(Format),
}

/// Bytes that are inspected to detect the format.
const LOOK: u64 = 1 << 16;

impl SceneSource {
    /// Opens `path`; `-` is standard input.
    ///
    /// # Errors
    /// As [`Input::open`], and [`Error::Scene`] for an empty file and for one whose format is not detected.
    pub fn open(path: &Path, known: KnownFormat, watch: &Watch) -> Result<Self> {
        Self::of(Input::open(path, watch)?, path, known)
    }

    /// Opens bytes that errors refer to by `path`.
    ///
    /// # Errors
    /// As [`SceneSource::open`].
    pub fn of(reader: Input, path: &Path, known: KnownFormat) -> Result<Self> {
        let mut reader = reader.without_utf16(path)?;
        let mut name = path.to_path_buf();
        if reader.is_packed() {
            name.set_extension("");
        }
        let start = reader.look(LOOK).map_err(|e| Error::read(path, e))?;
        let (format, warning) = match (known, recognise(&start, &name)) {
            (KnownFormat::Given(format), _) => (format, None),
            (_, Ok(recognised)) => recognised,
            (KnownFormat::IfNone(format), Err(_)) if !is_foreign(&start) => (format, None),
            (_, Err((problem, mend))) => {
                return Err(Error::scene(Place::file(path.display().to_string()), problem, mend));
            }
        };
        let is_empty = (start.len() as u64) < LOOK && start.iter().all(u8::is_ascii_whitespace);
        // A scene lacks its camera first of all.
        let is_scene = format.is_of_scenes();
        if is_empty && (is_scene || start.is_empty()) {
            let place = Place::file(path.display().to_string());
            let place = if format == Format::NATIVE { place.at(1, 1) } else { place };
            let place = if is_scene { place.named("camera") } else { place };
            return Err(Error::scene(place, "the file is empty", "use a file with particles or a scene"));
        }
        Ok(Self { reader, path: path.to_path_buf(), format, warning })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_file_is_called_empty() {
        for known in [KnownFormat::Nothing, KnownFormat::Given(Format::PDB)] {
            let open = SceneSource::of(Input::of_bytes(b""), Path::new("a.xyz"), known);
            let error = open.map(drop).expect_err("nothing").to_string();
            assert!(error.starts_with("a.xyz: the file is empty"), "{error}");
        }
    }
}
