//! Films: the pictures of a sequence, piped to the program ffmpeg as PNG, one after the other.

use super::camera_list::sizes_differ;
use super::messages::note;
use super::names::check_pattern;
use super::signals::go_on;
use halfline::error::{Error, Result};
use halfline_files::write::file::write_by_program;
use std::env;
use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};

/// Pictures per second where `--fps` does not say it. A GIF counts in hundredths of a second, so 25 is exact there.
pub(super) const FPS: f64 = 25.0;

/// The most pictures per second of a GIF. Browsers show a picture that is to stand for less than 0.02 s for 0.1 s.
const MOST_OF_GIF: f64 = 50.0;

/// The program that encodes.
const PROGRAM: &str = "ffmpeg";

/// A film that is to be written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Film<'a> {
    pub(super) path: &'a Path,
    kind: FilmKind,
    fps: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FilmKind {
    Mp4,
    Gif,
}

impl FilmKind {
    fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        [Self::Mp4, Self::Gif].into_iter().find(|kind| kind.name() == ending)
    }

    /// The extension, and the name of the format in ffmpeg.
    fn name(self) -> &'static str {
        match self {
            Self::Mp4 => "mp4",
            Self::Gif => "gif",
        }
    }

    /// The arguments of ffmpeg that choose the encoding. H.264 with colours at half the resolution plays everywhere,
    /// and needs even sides; its colours are BT.709, and the file says so. A GIF has a palette per picture,
    /// because one for all would keep every picture in memory until the last.
    fn encoding(self) -> Vec<&'static str> {
        match self {
            Self::Mp4 => vec![
                "-vf",
                "crop=trunc(iw/2)*2:trunc(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p",
                "-c:v",
                "libx264",
                "-crf",
                "18",
                "-colorspace",
                "bt709",
                "-color_primaries",
                "bt709",
                "-color_trc",
                "bt709",
                "-color_range",
                "tv",
                "-movflags",
                "+faststart",
            ],
            Self::Gif => {
                vec![
                    "-vf",
                    "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1:dither=bayer:bayer_scale=5",
                ]
            }
        }
    }
}

impl<'a> Film<'a> {
    /// The film at `path`, if it has the extension of a film.
    pub(super) fn of(path: &'a Path, fps: f64) -> Option<Self> {
        Some(Self { path, kind: FilmKind::of(path)?, fps })
    }

    /// Pictures per second of the file.
    fn rate(&self) -> f64 {
        if self.kind == FilmKind::Gif { self.fps.min(MOST_OF_GIF) } else { self.fps }
    }

    /// Returns an error for options that make no film, and where ffmpeg is missing.
    pub(super) fn check(&self, is_many: bool, is_transparent: bool, resume: bool) -> Result<()> {
        let name = self.path.display();
        let refuse = |problem: String, mend: &str| Err(Error::settings(problem, mend));
        if check_pattern(self.path).is_ok() {
            return refuse(format!("{name} is one film, not a file for each picture"), "use a name without %d");
        }
        if !is_many {
            let mend = "use .png for a picture, or --frames A-B, --spin N or --cameras FILE for a film";
            return refuse(format!("{name} is a film, but there is one picture"), mend);
        }
        if resume {
            let stem = self.path.with_extension("%04d.png");
            let mend = format!("remove --resume, or resume pictures, -o {}", stem.display());
            return refuse(format!("--resume: {name} is made in one run"), &mend);
        }
        if is_transparent {
            return refuse(
                format!("--transparent: {name} cannot be transparent"),
                "use --background, or .png for the pictures",
            );
        }
        if self.rate() < self.fps {
            note(format_args!(
                "{name} has {} pictures per second, the most of a GIF: players show a faster one at 10",
                self.rate()
            ));
        }
        let folders = env::var_os("PATH").unwrap_or_default();
        let program = format!("{PROGRAM}{}", env::consts::EXE_SUFFIX);
        if env::split_paths(&folders).any(|folder| folder.join(&program).is_file()) {
            return Ok(());
        }
        let mend = format!("install it, or {}", self.of_pictures());
        refuse(format!("{name} needs the program ffmpeg, and no folder of PATH has it"), &mend)
    }

    /// The mend of an error: the option that writes the pictures as files, and the line of ffmpeg that makes the film
    /// of them.
    pub(super) fn of_pictures(&self) -> String {
        let pictures = self.path.with_extension("%04d.png");
        format!("use -o {} and where ffmpeg is: {}", pictures.display(), self.line())
    }

    /// The command line of ffmpeg that makes the film of pictures in files.
    fn line(&self) -> String {
        let pictures = self.path.with_extension("*.png").display().to_string();
        let (fps, name) = (self.rate().to_string(), self.path.display().to_string());
        let input = [PROGRAM, "-framerate", &fps, "-pattern_type", "glob", "-i", &pictures];
        let words = input.into_iter().chain(self.kind.encoding()).chain([name.as_str()]);
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.:/=+%".contains(c);
        let quoted = |word: &str| if word.chars().all(is_plain) { word.to_owned() } else { format!("'{word}'") };
        words.map(quoted).collect::<Vec<_>>().join(" ")
    }

    /// Writes the film of the pictures that `fill` adds, completely or not at all.
    ///
    /// # Errors
    /// Errors of `fill`; [`Error::Io`] with the message of ffmpeg.
    pub(super) fn write(&self, fill: impl FnOnce(&mut FilmWriter) -> Result<()>) -> Result<()> {
        write_by_program(self.path, |name| {
            let mut writer = FilmWriter::start(self, name)?;
            match fill(&mut writer) {
                Ok(()) => writer.finish(),
                Err(error) => Err(io::Error::other(error)),
            }
        })
    }
}

/// A film that is being encoded. Without [`FilmWriter::finish`] the encoder is ended.
pub(super) struct FilmWriter {
    path: PathBuf,
    encoder: Child,
    /// Closed after the last picture.
    pictures: Option<ChildStdin>,
    /// The standard error of the encoder.
    messages: File,
    /// The number and the size of the first picture.
    first: Option<(u64, [u32; 2])>,
}

impl FilmWriter {
    fn start(film: &Film<'_>, name: &Path) -> io::Result<Self> {
        let messages = tempfile::tempfile()?;
        let mut command = Command::new(PROGRAM);
        command.args(["-hide_banner", "-loglevel", "error", "-nostats", "-f", "image2pipe", "-c:v", "png"]);
        command.args(["-framerate", &film.rate().to_string(), "-i", "pipe:0"]).args(film.kind.encoding());
        command.args(["-f", film.kind.name(), "-y"]).arg(name);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(messages.try_clone()?);
        let mut encoder = command.spawn()?;
        let pictures = encoder.stdin.take();
        Ok(Self { path: film.path.to_path_buf(), encoder, pictures, messages, first: None })
    }

    /// Adds a picture, the bytes of a PNG.
    ///
    /// # Errors
    /// [`Error::Settings`] for a picture of another size than the first; [`Error::Io`] with the message of ffmpeg.
    pub(super) fn add(&mut self, number: u64, png: &[u8]) -> Result<()> {
        // A PNG begins with a signature and the length and the name of its header, which begins with width and height.
        let side = |at: usize| png.get(at..at + 4).map_or(0, |side| side.iter().fold(0, |x, b| x << 8 | u32::from(*b)));
        let size = [side(16), side(20)];
        let first = *self.first.get_or_insert((number, size));
        if first.1 != size {
            return Err(sizes_differ(&self.path, [first, (number, size)]));
        }
        let Some(pictures) = &mut self.pictures else { return Ok(()) };
        let Err(error) = pictures.write_all(png) else { return Ok(()) };
        if !go_on() {
            return Err(Error::Interrupted);
        }
        // An encoder that has ended says why.
        self.pictures = None;
        let why = self.end().err().unwrap_or(error);
        Err(Error::write(&self.path, why))
    }

    /// Ends the input and waits for the file.
    fn finish(mut self) -> io::Result<()> {
        self.pictures = None;
        let ended = self.end();
        if go_on() { ended } else { Err(io::Error::other(Error::Interrupted)) }
    }

    /// Waits for the end of the encoder.
    fn end(&mut self) -> io::Result<()> {
        let status = self.encoder.wait()?;
        if status.success() {
            return Ok(());
        }
        let mut messages = Vec::new();
        self.messages.rewind()?;
        (&mut self.messages).take(1 << 12).read_to_end(&mut messages)?;
        let text = String::from_utf8_lossy(&messages);
        let first = text.lines().map(str::trim).find(|line| !line.is_empty());
        Err(io::Error::other(first.map_or(format!("ffmpeg: {status}"), |line| format!("ffmpeg: {line}"))))
    }
}

impl Drop for FilmWriter {
    fn drop(&mut self) {
        // Both fail where the encoder has ended.
        let _ = self.encoder.kill();
        let _ = self.encoder.wait();
    }
}
