//! Output files: the format is chosen by the file name extension; `-` is standard output.

pub use super::atomic::{
    check_writable, is_standard_output, refuse_standard_output, write_atomically, write_by_program,
};
pub use halfline_particles::input::{is_special, is_standard};

use super::atomic::write_anywhere;
use super::cryptomatte::MatteHead;
use super::digest::Digest;
use super::encode::{self, Encoder};
use super::format::{FileFormat, FormatOptions};
use super::image_file::{self, Opened};
use super::mattes::{self, MatteLayer};
use super::rows::{Head, Rows};
use crate::read::matte::MatteNames;
use halfline::error::{Error, Result};
use halfline::frame::provenance::{Origin, Provenance};
use halfline::frame::{Aov, Frame};
use halfline::memory::ids_fit;
use halfline::quote::setting::CRYPTOMATTE;
use halfline::window::Window;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// One file and the buffers that go into it.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    aovs: Vec<Aov>,
    format: FileFormat,
    style: FormatOptions,
    path: PathBuf,
    /// Words for what is drawn into the colour besides the scene, such as a legend; `None` for nothing.
    drawn: Option<String>,
    /// The names of the Cryptomatte layers, of an EXR file.
    mattes: Vec<MatteNames>,
}

impl Target {
    /// The buffers `aovs` at `path`, one or more. On standard output (`-`), and in pipes and devices without a known
    /// extension, colour is PNG and everything else .npy. With a transparent style, alpha is added to colour in every
    /// format that can hold it.
    ///
    /// # Errors
    /// [`Error::Settings`] naming the file, if its extension names no format that can hold these buffers.
    pub fn new(aovs: &[Aov], path: &Path, style: FormatOptions) -> Result<Self> {
        let fits =
            |format: FileFormat| aovs.iter().all(|aov| format.takes(*aov)) && (aovs.len() == 1 || format.holds_many());
        let customary = if aovs == [Aov::Color] { FileFormat::Png } else { FileFormat::Npy };
        let format = FileFormat::of(path).or((is_standard_output(path) || is_special(path)).then_some(customary));
        let Some(format) = format.filter(|format| fits(*format)) else {
            let names = aovs.iter().map(|aov| aov.name()).collect::<Vec<_>>().join(", ");
            let buffers = if aovs.len() == 1 { "buffer" } else { "buffers together" };
            let problem = format!("{} cannot hold the {names} {buffers}", path.display());
            return Err(Error::settings(problem, format!("use the file name extension {}", FileFormat::endings(fits))));
        };
        #[cfg(not(feature = "formats"))]
        if format == FileFormat::Exr || format.is_copy() {
            let problem = format!("{}: this build of halfline does not write {}", path.display(), format.name());
            return Err(Error::settings(problem, crate::WHOLE));
        }
        Ok(Self::with_format(aovs, path, format, style))
    }

    /// One buffer's numbers without a header at `path`, whatever its extension.
    pub fn raw(aov: Aov, path: &Path, style: FormatOptions) -> Self {
        Self::with_format(&[aov], path, FileFormat::Raw, style)
    }

    /// The colour of a picture of the film at `path`, as PNG; [`Target::encode`] gives its bytes.
    pub fn film(path: &Path, style: FormatOptions) -> Self {
        Self::with_format(&[Aov::Color], path, FileFormat::Png, style)
    }

    fn with_format(aovs: &[Aov], path: &Path, format: FileFormat, style: FormatOptions) -> Self {
        let mut aovs = aovs.to_vec();
        if style.transparent && aovs.contains(&Aov::Color) && format.takes_alpha() {
            aovs.push(Aov::Alpha);
        }
        aovs.sort_unstable();
        aovs.dedup();
        Self { aovs, format, style, path: path.to_path_buf(), drawn: None, mattes: Vec::new() }
    }

    /// The buffers, in the order of [`Aov::ALL`].
    pub fn aovs(&self) -> &[Aov] {
        &self.aovs
    }

    /// Notes what is drawn into the colour besides the scene, for provenance.
    pub fn set_drawn(&mut self, words: &str) {
        self.drawn = Some(words.to_owned());
    }

    /// Checks that the file can hold Cryptomatte layers.
    ///
    /// # Errors
    /// [`Error::Settings`] for a file that is no EXR.
    pub fn check_mattes(&self) -> Result<()> {
        if self.format == FileFormat::Exr {
            return Ok(());
        }
        let problem = format!("{} cannot hold the layers of {CRYPTOMATTE}", self.path.display());
        Err(Error::settings(problem, "use the file name extension .exr"))
    }

    /// Adds Cryptomatte layers with these names to the buffers of an EXR.
    pub fn set_mattes(&mut self, mattes: &[MatteNames]) {
        self.mattes = mattes.to_vec();
    }

    /// Whether anything is drawn into the colour besides the scene.
    pub fn is_drawn_on(&self) -> bool {
        self.drawn.is_some()
    }

    /// The file format.
    pub fn format(&self) -> FileFormat {
        self.format
    }

    /// The path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it is standard output.
    pub fn is_standard(&self) -> bool {
        is_standard_output(&self.path)
    }

    /// Checks that the file can be written, for use before the work begins.
    ///
    /// # Errors
    /// See [`check_writable`].
    pub fn check(&self) -> Result<()> {
        check_writable(&self.path)
    }

    /// Checks that the file can hold the ids of a scene with this many spheres, for use before the work begins. Ids of more
    /// spheres than 32 bits can number are int64.
    ///
    /// # Errors
    /// [`Error::Settings`] with the formats that can.
    pub fn check_ids(&self, spheres: u64) -> Result<()> {
        if ids_fit(spheres) || !self.aovs.contains(&Aov::Id) || self.format.takes_wide_ids() {
            return Ok(());
        }
        let problem = format!("{} cannot hold the ids of {spheres} spheres, which are int64", self.path.display());
        let mend = format!("write the ids to {}", FileFormat::endings(FileFormat::takes_wide_ids));
        Err(Error::settings(problem, mend))
    }

    /// The provenance of the file; .raw cannot hold it.
    pub fn provenance(&self, origin: &Origin<'_>) -> Provenance {
        let mut provenance = Provenance::new(origin, &self.aovs);
        let of_format = self.style.words(self.format, &self.aovs);
        of_format.into_iter().for_each(|(key, text)| provenance.set(key, text));
        if self.format.has_levels() && self.aovs.contains(&Aov::Color) {
            origin.report.toning().words().for_each(|(key, text)| provenance.set(key, text));
        }
        self.drawn.iter().for_each(|words| provenance.set("halfline:drawn", words));
        let layers = mattes::words(&self.mattes, origin.report.spheres);
        layers.into_iter().for_each(|(key, text)| provenance.set(key, text));
        provenance
    }

    /// Whether the file exists, has the same provenance as `origin`, and is byte for byte what encoding its own content
    /// again gives; false when `go_on` returns false before all of it is read.
    pub fn is_there(&self, origin: &Origin<'_>, go_on: &(dyn Fn() -> bool + Sync)) -> bool {
        !self.is_standard() && self.is_whole(origin, go_on).unwrap_or(false)
    }

    fn is_whole(&self, origin: &Origin<'_>, go_on: &(dyn Fn() -> bool + Sync)) -> Result<bool> {
        let name = self.path.display().to_string();
        let Opened { format, head, rows } = Opened::file(&self.path, &name)?;
        let words = head.provenance.without_pixels() == self.provenance(origin);
        if format != self.format || !words || head.provenance.pixels().is_none() {
            return Ok(false);
        }
        Digest::of(&head, &mut Interruptible { rows, go_on })?.check(&head.provenance, &name)?;
        let rows = Opened::file(&self.path, &name)?.rows;
        let mut comparison = Comparison::with(&self.path)?;
        let same = image_file::write(format, &head, &mut Interruptible { rows, go_on }, &mut comparison);
        Ok(same.is_ok() && comparison.is_complete())
    }

    /// Checks that the file can hold a picture of this width and height, for use before the work begins.
    ///
    /// # Errors
    /// [`Error::Settings`] with the longest side that it can hold.
    pub fn check_size(&self, size: [u32; 2]) -> Result<()> {
        let (most, name) = (self.format.longest_side(), self.format.name());
        if size.into_iter().all(|side| side <= most) {
            return Ok(());
        }
        let [width, height] = size;
        let problem = format!("{} cannot hold {width}x{height} pixels", self.path.display());
        Err(Error::settings(problem, format!("use at most {most} pixels a side for {name}, or .png or .tif")))
    }

    /// Bytes of memory that writing the file, or reading it again, needs besides the frame; `size` is the width and height of
    /// the rendered window, `lights` the number of the scene's lights.
    pub fn memory(&self, size: [u32; 2], lights: usize) -> u64 {
        let window = Window::full(size[0], size[1]);
        let forms = self.format.forms(&self.aovs, self.style.bits, lights, false).unwrap_or_default();
        let matte = |names: &MatteNames| MatteHead { layer: names.layer().to_owned(), manifest: BTreeMap::new() };
        let mattes = self.mattes.iter().map(matte).collect();
        Head { forms, mattes, provenance: Provenance::default(), window, full: size }.memory(self.format)
    }

    /// Warnings about what the format cannot hold of `frame`, in whole sentences.
    pub fn warnings(&self, frame: &Frame) -> Vec<String> {
        let buffers = self.aovs.iter().filter(|_| self.format == FileFormat::Png).filter_map(|aov| frame.get(*aov));
        let of_buffers = buffers.filter_map(|buffer| encode::warning(buffer, self.style.unit));
        of_buffers.chain(mattes::warnings(&self.mattes, frame)).collect()
    }

    /// Writes the buffers of `frame` and their provenance.
    ///
    /// # Errors
    /// [`Error::Settings`] for a frame that lacks a buffer or holds a malformed one, [`Error::Io`] from the system.
    pub fn write(&self, frame: &Frame, origin: &Origin<'_>) -> Result<()> {
        self.write_while(frame, origin, &|| true)
    }

    /// As [`Target::write`], but ended by [`Error::Interrupted`] when `go_on` returns false before all of it is
    /// written.
    ///
    /// # Errors
    /// As [`Target::write`].
    pub fn write_while(&self, frame: &Frame, origin: &Origin<'_>, go_on: &(dyn Fn() -> bool + Sync)) -> Result<()> {
        self.encoded(frame, origin, go_on, |head, rows| write_file(self.format, head, rows, &self.path))
    }

    /// The bytes that [`Target::write_while`] writes.
    ///
    /// # Errors
    /// As [`Target::write_while`].
    pub fn encode(&self, frame: &Frame, origin: &Origin<'_>, go_on: &(dyn Fn() -> bool + Sync)) -> Result<Vec<u8>> {
        let mut bytes = Cursor::new(Vec::new());
        self.encoded(frame, origin, go_on, |head, rows| {
            let written = image_file::write(self.format, head, rows, &mut bytes);
            written.map_err(|e| e.downcast::<Error>().unwrap_or_else(|error| Error::write(&self.path, error)))
        })?;
        Ok(bytes.into_inner())
    }

    /// The Cryptomatte layers of a frame.
    fn matte_layers(&self, frame: &Frame) -> Result<Vec<MatteLayer>> {
        let Some(coverage) = &frame.coverage else {
            let problem = "the frame does not have the spheres of its samples";
            let lacks = || Error::settings(problem, format!("render it with {CRYPTOMATTE}"));
            return if self.mattes.is_empty() { Ok(Vec::new()) } else { Err(lacks()) };
        };
        Ok(self.mattes.iter().map(|names| MatteLayer::new(names, coverage)).collect())
    }

    /// Calls `write` with the head and the rows of the file.
    fn encoded(
        &self,
        frame: &Frame,
        origin: &Origin<'_>,
        go_on: &(dyn Fn() -> bool + Sync),
        write: impl FnOnce(&Head, &mut dyn Rows) -> Result<()>,
    ) -> Result<()> {
        let refuse = |problem: String| Error::settings(problem, "render the frame with the buffers of its files");
        self.check_size([origin.window.width(), origin.window.height()])?;
        let [columns, lines] = [origin.window.width() as usize, origin.window.height() as usize];
        for aov in &self.aovs {
            let buffer = frame.get(*aov);
            let buffer = buffer.ok_or_else(|| {
                refuse(format!("{} needs the buffer {aov}, which the frame lacks", self.path.display()))
            })?;
            buffer.check()?;
            if self.format == FileFormat::Png {
                encode::check_ids(buffer)?;
            }
            if buffer.shape[..2] != [lines, columns] || frame.width as usize != columns {
                return Err(refuse(format!("the buffers do not have the size of the window {}", origin.window)));
            }
        }
        let encoder = Encoder::new(frame, &self.aovs, self.format, &self.style);
        let encoder = encoder.ok_or_else(|| refuse(format!("{} cannot hold the buffers", self.path.display())))?;
        let encoder = encoder.with_mattes(self.matte_layers(frame)?);
        let (forms, mattes, provenance) = (encoder.forms().to_vec(), encoder.mattes(), self.provenance(origin));
        let mut head = Head { forms, mattes, provenance, window: origin.window, full: origin.full };
        let mut rows = Interruptible { rows: Box::new(encoder), go_on };
        if self.format != FileFormat::Raw {
            let digest = Digest::of(&head, &mut rows)?;
            head.provenance = head.provenance.with_pixels(&digest.text());
        }
        write(&head, &mut rows)
    }
}

/// Writes a file sequentially, or with seeks where its format needs them.
///
/// # Errors
/// [`Error::Io`] naming `path`, and errors of `rows`.
pub(super) fn write_file(format: FileFormat, head: &Head, rows: &mut dyn Rows, path: &Path) -> Result<()> {
    match format {
        FileFormat::Exr | FileFormat::Tiff => write_anywhere(path, |out| image_file::write(format, head, rows, out)),
        _ => write_atomically(path, |out| image_file::write(format, head, rows, &mut Onward(out))),
    }
}

/// A writer without seeking.
struct Onward<'a>(&'a mut dyn Write);

impl Write for Onward<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl Seek for Onward<'_> {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

/// Rows that stop when a callback returns false.
pub(super) struct Interruptible<'a> {
    pub(super) rows: Box<dyn Rows + 'a>,
    pub(super) go_on: &'a (dyn Fn() -> bool + Sync),
}

impl Rows for Interruptible<'_> {
    fn rows(&mut self, layer: usize, rows: Range<usize>) -> Result<Cow<'_, [u8]>> {
        if (self.go_on)() { self.rows.rows(layer, rows) } else { Err(Error::Interrupted) }
    }
}

/// A writer that compares its input with an existing file.
struct Comparison {
    file: BufReader<File>,
    length: u64,
    /// The position of the next byte, and the end of the furthest write.
    place: u64,
    end: u64,
}

impl Comparison {
    fn with(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(|error| Error::read(path, error))?;
        let length = file.metadata().map_err(|error| Error::read(path, error))?.len();
        Ok(Self { file: BufReader::with_capacity(1 << 16, file), length, place: 0, end: 0 })
    }

    /// Whether the furthest write ended where the file does.
    fn is_complete(&self) -> bool {
        self.end == self.length
    }
}

impl Write for Comparison {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut there = [0; 1 << 12];
        let (some, there) = (&bytes[..bytes.len().min(there.len())], &mut there[..bytes.len().min(1 << 12)]);
        self.file.read_exact(there)?;
        if some != there {
            return Err(io::Error::other("the content differs"));
        }
        self.place += some.len() as u64;
        self.end = self.end.max(self.place);
        Ok(some.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Comparison {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.place = self.file.seek(to)?;
        Ok(self.place)
    }
}
