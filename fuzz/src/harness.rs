//! The fuzz targets and their invariants for any input: no panic, bounded memory and time, errors that a terminal can
//! show, and scenes that can be rendered. `tests/corpus.rs` runs the stored inputs through the same code.

#[path = "pictures.rs"]
mod pictures;
#[path = "rays.rs"]
mod rays;
#[path = "select.rs"]
mod select;

use halfline::error::Error;
use halfline_files::read::style::{Coloring, Scale, Style};
use halfline_files::read::{Format, ReadOptions, SceneFrame, Sequence};
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

/// A fuzz target.
pub(crate) struct Target {
    name: &'static str,
    kind: Kind,
}

/// Runs an input, and panics where an invariant fails.
type Run = fn(&[u8]) -> Allowed;

/// The kind of input.
enum Kind {
    /// A scene in this format, or in one detected from its content, compressed or not. The first byte selects the
    /// options.
    Scene(Option<Format>),
    /// Files that halfline wrote, or rays.
    File(Run),
    #[cfg(fuzzing)]
    Config,
}

/// The limits of a run.
pub(crate) struct Allowed {
    /// Peak memory in bytes.
    pub(crate) bytes: usize,
    /// Seconds of one processor; not checked in the test suite.
    #[cfg_attr(not(fuzzing), expect(dead_code, reason = "only the fuzzer looks at it"))]
    pub(crate) seconds: f64,
}

/// Bytes that a reader may use for any file: its buffers, blocks of lines, a decompressor, names of columns.
const FREE: usize = 24 << 20;

/// Bytes per byte of a file, decompressed. A byte of TOML can be a table (`src/read/native/room.rs`), a byte of an
/// array a number that exists in several forms.
const PER_BYTE: usize = 256;
const PER_BYTE_OF_TOML: usize = 1500;

/// Seconds per file, and per byte of it: a million times those of a plain reader, on a machine with other load.
const SECONDS: f64 = 1.0;
const PER_BYTE_SECONDS: f64 = 1e-4;

/// The most decompressed bytes that are run.
const UNPACKED: u64 = 8 << 20;

/// The most points in a byte of LAZ, and the memory and time of each.
const POINTS_OF_LAZ: usize = 1100;
const PER_POINT: usize = 256;
const PER_POINT_SECONDS: f64 = 1e-6;

/// The most characters of an error or a warning: a place, a few quoted words, a list of names.
const LONGEST: usize = 2000;

impl Target {
    /// All of them.
    pub(crate) fn all() -> Vec<Self> {
        let scene = |format: &Format| Self { name: format.name(), kind: Kind::Scene(Some(*format)) };
        let mut all: Vec<Self> = Format::ALL.iter().map(scene).collect();
        all.push(Self { name: "any", kind: Kind::Scene(None) });
        let files: [(_, Run); 6] = [
            ("compare", pictures::compare),
            ("merge", pictures::merge),
            ("resume", pictures::resume),
            ("rays", rays::read),
            ("select", select::select),
            ("cameras", select::cameras),
        ];
        all.extend(files.map(|(name, run)| Self { name, kind: Kind::File(run) }));
        #[cfg(fuzzing)]
        all.push(Self { name: "config", kind: Kind::Config });
        all
    }

    /// The target with this name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::all().into_iter().find(|target| target.name == name)
    }

    /// The names, which are those of the folders of inputs.
    pub(crate) fn names() -> Vec<&'static str> {
        Self::all().iter().map(|target| target.name).collect()
    }

    /// Runs the input, and panics where an invariant fails; returns the limits of the run.
    pub(crate) fn run(&self, data: &[u8]) -> Allowed {
        match self.kind {
            Kind::Scene(format) => scene(format, data),
            Kind::File(run) => run(data),
            #[cfg(fuzzing)]
            Kind::Config => {
                if let Err(error) = crate::config::run(data) {
                    check_error(&error);
                }
                allowed(data.len(), PER_BYTE_OF_TOML)
            }
        }
    }
}

/// The folder for files that readers open by name, in memory where the system has such a folder.
pub(crate) fn desk() -> PathBuf {
    let memory = PathBuf::from("/dev/shm");
    let folder = if memory.is_dir() { memory } else { std::env::temp_dir() };
    folder.join(format!("halfline-fuzz-{}", std::process::id()))
}

fn allowed(bytes: usize, per_byte: usize) -> Allowed {
    Allowed { bytes: FREE + per_byte * bytes, seconds: SECONDS + PER_BYTE_SECONDS * bytes as f64 }
}

/// The limits of a file of so many bytes that may be LAZ.
fn allowed_points(bytes: usize) -> Allowed {
    let points = POINTS_OF_LAZ * bytes;
    Allowed {
        bytes: FREE + PER_BYTE_OF_TOML * bytes + PER_POINT * points,
        seconds: SECONDS + PER_BYTE_SECONDS * bytes as f64 + PER_POINT_SECONDS * points as f64,
    }
}

/// Reads all frames of a scene.
fn scene(format: Option<Format>, data: &[u8]) -> Allowed {
    let Some((choice, content)) = data.split_first() else { return allowed(0, 0) };
    let Some(Unpacked { length, whole }) = unpacked(content) else { return allowed(0, 0) };
    let options = options(format, *choice);
    let at_once = read(Cursor::new(content.to_vec()), &options, length);
    // The same bytes in pieces must give the same scene. For a damaged stream, a decompressor delivers more or fewer
    // bytes before its error, depending on the pieces.
    if choice & 0x80 != 0 {
        let in_pieces = read(Pieces { content: content.to_vec(), at: 0 }, &options, length);
        assert!(at_once == in_pieces || !whole, "at once {at_once:?}, in pieces {in_pieces:?}");
    }
    match format {
        Some(Format::Native | Format::Pcd) => allowed(length, PER_BYTE_OF_TOML),
        Some(Format::Las) | None => allowed_points(length),
        _ => allowed(length, PER_BYTE),
    }
}

/// The input as a reader receives it.
struct Unpacked {
    length: usize,
    /// Whether it decompresses without error.
    whole: bool,
}

/// The decompressed bytes; `None` if there are too many.
fn unpacked(content: &[u8]) -> Option<Unpacked> {
    let (mut count, mut whole) = (0, true);
    let mut pass = |reader: &mut dyn Read| {
        let mut block = vec![0; 1 << 14];
        while count as u64 <= UNPACKED {
            match reader.read(&mut block) {
                Ok(0) => break,
                Ok(read) => count += read,
                Err(_) => {
                    whole = false;
                    break;
                }
            }
        }
    };
    match content {
        [0x1f, 0x8b, ..] => pass(&mut flate2::bufread::MultiGzDecoder::new(content)),
        [b'B', b'Z', b'h', ..] => pass(&mut bzip2::bufread::MultiBzDecoder::new(content)),
        // Arrays of an archive are deflated separately, with a factor of at most 1032.
        [b'P', b'K', ..] => count = content.len().saturating_mul(1032),
        _ => {}
    }
    (count as u64 <= UNPACKED).then_some(Unpacked { length: count.max(content.len()), whole })
}

/// Options that select other paths of the readers, by the bits of a byte.
fn options(format: Option<Format>, choice: u8) -> ReadOptions {
    let columns: &[&str] = match choice & 3 {
        0 => &[],
        1 => &["x"],
        2 => &["vx", "vy"],
        _ => &["chain"],
    };
    let mut options = ReadOptions { format, frames: "1-".parse().expect("frames"), ..ReadOptions::default() };
    if !columns.is_empty() {
        let columns = columns.iter().map(|name| (*name).to_owned()).collect();
        let scale = Scale { log: choice & 0x40 != 0 && choice & 3 == 1, ..Scale::of(columns) };
        options.style = Style { coloring: Coloring::Column(scale), ..Style::default() };
    }
    if matches!(format, Some(Format::Pdb | Format::Mmcif)) {
        match choice >> 2 & 7 {
            1 => options.assembly = Some("1".into()),
            2 => options.altloc = "highest".parse().expect("an alternate location"),
            3 => options.altloc = "A".parse().expect("an alternate location"),
            4 => options.model = Some(2),
            5 => {
                options.assembly = Some("1".into());
                options.frames = "1".parse().expect("frames");
            }
            _ => {}
        }
    } else if choice & 4 != 0 {
        options.frames = "2-3".parse().expect("frames");
    } else if choice & 8 != 0 {
        options.frames = "1".parse().expect("frames");
    }
    options.strict = choice & 0x20 != 0;
    options
}

/// The result of reading: a line for every frame, and one for the error that ended them.
fn read(reader: impl Read + Send + 'static, options: &ReadOptions, length: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut sequence = match Sequence::from_reader(reader, Path::new("fuzzed"), options) {
        Ok(sequence) => sequence,
        Err(error) => return vec![check_error(&error)],
    };
    loop {
        match sequence.next_scene() {
            Ok(None) => return lines,
            Ok(Some(shot)) => lines.push(check_shot(&shot, options, length)),
            Err(error) => {
                lines.push(check_error(&error));
                return lines;
            }
        }
    }
}

/// Checks that a scene can be rendered; returns its description in a line.
fn check_shot(shot: &SceneFrame, options: &ReadOptions, length: usize) -> String {
    let (scene, spheres) = (&shot.scene, &shot.scene.spheres);
    scene.check().expect("a scene that was read can be rendered");
    assert!(spheres.radii.iter().all(|radius| *radius > 0.0 && radius.is_finite()));
    assert!(spheres.centers.iter().flatten().all(|x| x.is_finite()));
    if let Some(colors) = &spheres.colors {
        assert_eq!(colors.len(), spheres.len());
        assert!(colors.iter().flatten().all(|c| *c >= 0.0 && c.is_finite()), "colours are light");
    }
    // A sphere has three coordinates of at least one byte each; an assembly repeats spheres. In compressed formats it has
    // at least two bits (XTC), and three bytes decompress to at most 264 (PCD), in which a point has at least three. A
    // point like the one before takes 0.0075 bits of LAZ.
    let most = match options.format {
        Some(Format::Xtc) => 4 * length,
        Some(Format::Pcd) => 30 * length,
        Some(Format::Las) | None => POINTS_OF_LAZ * length,
        _ => length / 3,
    };
    assert!(options.assembly.is_some() || spheres.len() <= most, "{} spheres of {length} bytes", spheres.len());
    if let Some(cell) = &shot.cell {
        assert!(cell.origin.iter().chain(cell.edges.iter().flatten()).all(|x| x.is_finite()), "{cell:?}");
    }
    if let Some(legend) = &shot.legend {
        assert!(
            legend.categories.is_empty()
                || legend.categories.iter().map(|c| c.count).sum::<u64>() <= spheres.len() as u64
        );
        assert!(legend.range[0] <= legend.range[1], "{:?}", legend.range);
    }
    let warnings = scene.skipped.warnings();
    warnings.iter().for_each(|warning| check_words(warning));
    format!("{} {} {} {warnings:?}", shot.number, scene.fingerprint(), spheres.len())
}

/// Checks that an error is short and has no control characters.
fn check_error(error: &Error) -> String {
    let text = error.to_string();
    check_words(&text);
    text
}

fn check_words(text: &str) {
    let length = text.chars().count();
    assert!((1..=LONGEST).contains(&length), "{length} characters: {text:?}");
    assert!(!text.chars().any(|c| c.is_control() && c != '\n'), "{text:?}");
}

/// Bytes in pieces of irregular lengths.
struct Pieces {
    content: Vec<u8>,
    at: usize,
}

impl Read for Pieces {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        let rest = &self.content[self.at..];
        let count = (1 + self.at % 7).min(rest.len()).min(bytes.len());
        bytes[..count].copy_from_slice(&rest[..count]);
        self.at += count;
        Ok(count)
    }
}
