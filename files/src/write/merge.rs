//! Merges parts of a frame into the frame. Samples are copied as stored, so the merged file equals byte for byte the
//! one that rendering the whole frame would have written.

use super::cryptomatte::MatteHead;
use super::digest::Digest;
use super::file::write_file;
use super::format::FileFormat;
use super::image_file::Opened;
use super::rows::{Head, Rows};
use halfline::error::{Error, Place, Result};
use halfline::memory::check;
use halfline::quote::setting::CROP;
use halfline::window::Window;
use halfline_particles::input::is_standard;
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// A part of a frame: the head of its file, and the location of its pixels.
#[derive(Debug)]
pub struct Tile {
    /// The file's name, for errors.
    name: String,
    format: FileFormat,
    head: Head,
    path: PathBuf,
    /// A copy of a pipe's content, which is read more than once.
    _copy: Option<TempPath>,
}

impl Tile {
    /// Reads the head of the file but none of its pixels.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that cannot be read, [`Error::Scene`] at one that is malformed or has no provenance.
    pub fn open(path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        let copy = copy_of_pipe(path).map_err(|error| Error::read(path, error))?;
        let path = copy.as_ref().map_or(path, |copy| copy).to_path_buf();
        let Opened { format, head, .. } = Opened::file(&path, &name)?;
        Ok(Self { name, format, head, path, _copy: copy })
    }
}

/// A copy of the content of a pipe or device; `None` for a file.
fn copy_of_pipe(path: &Path) -> std::io::Result<Option<TempPath>> {
    let mut input: Box<dyn Read> = match std::fs::metadata(path) {
        _ if is_standard(path) => Box::new(std::io::stdin()),
        Ok(found) if !found.is_file() && !found.is_dir() => Box::new(File::open(path)?),
        _ => return Ok(None),
    };
    let mut copy = tempfile::NamedTempFile::new()?;
    std::io::copy(&mut input, &mut copy)?;
    Ok(Some(copy.into_temp_path()))
}

/// Tiles that cover every pixel of the full frame exactly once.
#[derive(Debug)]
pub struct Mosaic {
    tiles: Vec<Tile>,
    format: FileFormat,
    head: Head,
}

impl Mosaic {
    /// Determines how `tiles` cover the frame.
    ///
    /// # Errors
    /// [`Error::Scene`] at the tile that differs from most of the others (another scene, size, setting, adapter, driver
    /// or program) or overlaps another, and with the rectangles that no tile covers. [`Error::Settings`] where there is
    /// no tile.
    pub fn new(tiles: Vec<Tile>) -> Result<Self> {
        let Some(common) = most_common(&tiles) else {
            return Err(Error::settings("no tiles to merge", "name the files with the parts of a frame"));
        };
        tiles.iter().try_for_each(|tile| belongs(tile, common))?;
        overlap(&tiles)?;
        let [width, height] = common.head.full;
        let full = Window::full(width, height);
        let missing = missing(full, tiles.iter().map(|tile| tile.head.window));
        if !missing.is_empty() {
            let pixels: u64 = missing.iter().map(area).sum();
            let mut named: Vec<_> = missing.iter().take(MOST).map(ToString::to_string).collect();
            if missing.len() > MOST {
                named.push(format!("{} more", missing.len() - MOST));
            }
            let problem =
                format!("no tile covers {} of {width} x {height} pixels ({pixels} pixels)", named.join(" and "));
            let mend = format!("render each missing part with {CROP} x0,y0,x1,y1 and add it to the list");
            return Err(Error::scene(Place::file(format!("{} tiles", tiles.len())), problem, mend));
        }
        let provenance = common.head.provenance.without_pixels().of_window(full);
        let (format, forms) = (common.format, common.head.forms.clone());
        let mattes = MatteHead::joined(tiles.iter().map(|tile| &tile.head.mattes[..]));
        let head = Head { forms, mattes, provenance, window: full, full: common.head.full };
        Ok(Self { tiles, format, head })
    }

    /// The format of the tiles.
    pub fn format(&self) -> FileFormat {
        self.format
    }

    /// W and H of the full frame.
    pub fn size(&self) -> [u32; 2] {
        self.head.full
    }

    /// The number of tiles.
    pub fn len(&self) -> usize {
        self.tiles.len()
    }

    /// Whether there are no tiles; always false.
    pub fn is_empty(&self) -> bool {
        self.tiles.is_empty()
    }

    /// Warnings, in whole sentences.
    pub fn warnings(&self) -> Vec<String> {
        let unproven = self.tiles.iter().filter(|tile| tile.head.provenance.pixels().is_none()).count();
        let says = match unproven {
            0 => return Vec::new(),
            1 => "1 tile was written by an earlier version of halfline and has no hash of its".to_owned(),
            n => format!("{n} tiles were written by an earlier version of halfline and have no hash of their"),
        };
        vec![format!("{says} pixels, so changes to them cannot be detected")]
    }

    /// Reads every pixel of every tile and checks it; then reads them again and writes the full frame in bands of rows,
    /// so that neither tiles nor frame are in memory as a whole.
    ///
    /// # Errors
    /// [`Error::Limits`] where not even a band fits into memory, [`Error::Scene`] at a tile that is malformed or whose
    /// pixels were changed, [`Error::Io`], and [`Error::Interrupted`] when `go_on` returns false.
    pub fn write(&self, path: &Path, go_on: &(dyn Fn() -> bool + Sync)) -> Result<()> {
        // The band of the frame, and the parts of it in the tiles.
        check(2 * self.head.memory(self.format), || "a band of the frame's rows".into())?;
        let mut rows = Tiles { mosaic: self, open: HashMap::new(), checks: Some(HashMap::new()), go_on };
        let digest = Digest::of(&self.head, &mut rows)?;
        rows.check()?;
        let head = Head { provenance: self.head.provenance.clone().with_pixels(&digest.text()), ..self.head.clone() };
        let mut rows = Tiles { mosaic: self, open: HashMap::new(), checks: None, go_on };
        write_file(self.format, &head, &mut rows, path)
    }
}

/// The rows of all tiles as rows of the frame.
struct Tiles<'a> {
    mosaic: &'a Mosaic,
    /// The open tiles of the last rows, by index.
    open: HashMap<usize, Box<dyn Rows>>,
    /// The hashes of the tiles, where they are checked.
    checks: Option<HashMap<usize, Digest>>,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

impl Tiles<'_> {
    /// Returns an error for tiles whose pixels do not match their hash.
    fn check(&self) -> Result<()> {
        let mut known = self.checks.iter().flatten();
        known.try_for_each(|(n, digest)| {
            let tile = &self.mosaic.tiles[*n];
            digest.check(&tile.head.provenance, &tile.name)
        })
    }
}

impl Rows for Tiles<'_> {
    fn rows(&mut self, layer: usize, rows: Range<usize>) -> Result<Cow<'_, [u8]>> {
        if !(self.go_on)() {
            return Err(Error::Interrupted);
        }
        let Mosaic { tiles, head, .. } = self.mosaic;
        let (row, pixel) = (head.row(layer), head.pixel(layer));
        let mut samples = vec![0; rows.len() * row];
        let mut met = HashSet::new();
        for (n, tile) in tiles.iter().enumerate() {
            let window = tile.head.window;
            let [top, bottom] = [window.y0, window.y1].map(|y| (y as usize).clamp(rows.start, rows.end));
            if top == bottom {
                continue;
            }
            met.insert(n);
            let source = match self.open.entry(n) {
                std::collections::hash_map::Entry::Occupied(open) => open.into_mut(),
                std::collections::hash_map::Entry::Vacant(place) => {
                    let opened = Opened::file(&tile.path, &tile.name)?;
                    if opened.head != tile.head {
                        return Err(Error::scene(
                            Place::file(&tile.name),
                            "the file was changed while it was read",
                            "merge again",
                        ));
                    }
                    place.insert(opened.rows)
                }
            };
            let own = top - window.y0 as usize..bottom - window.y0 as usize;
            let part = source.rows(layer, own)?;
            if let Some(checks) = &mut self.checks {
                checks.entry(n).or_insert_with(|| Digest::new(&tile.head)).update(layer, &part);
            }
            for (y, line) in (top..).zip(part.chunks_exact(window.width() as usize * pixel)) {
                samples[(y - rows.start) * row + window.x0 as usize * pixel..][..line.len()].copy_from_slice(line);
            }
        }
        // Closes tiles that the current rows do not need.
        self.open.retain(|n, _| met.contains(n));
        Ok(samples.into())
    }
}

/// At most this many rectangles are named; the others are counted.
const MOST: usize = 8;

/// The first tile of the rendering that most tiles belong to; of two equally common renderings, the first.
fn most_common(tiles: &[Tile]) -> Option<&Tile> {
    let mut counts: HashMap<_, usize> = HashMap::new();
    let renderings: Vec<_> = tiles.iter().map(|tile| (tile.format, tile.head.provenance.rendering())).collect();
    renderings.iter().for_each(|rendering| *counts.entry(rendering).or_default() += 1);
    // `max_by_key` takes the last of equal elements, so the order is reversed.
    tiles.iter().zip(&renderings).rev().max_by_key(|(_, rendering)| counts[rendering]).map(|(tile, _)| tile)
}

fn belongs(tile: &Tile, common: &Tile) -> Result<()> {
    let other = &common.name;
    let foreign = |what: String| Err(Error::scene(Place::file(&tile.name), what, "merge tiles of one rendering only"));
    if tile.format != common.format {
        let [this, that] = [tile.format, common.format].map(FileFormat::ending);
        return foreign(format!("a tile in {this} among tiles in {that}"));
    }
    match tile.head.provenance.foreign(&common.head.provenance) {
        Some([key, this, that]) => {
            foreign(format!("the tile belongs to another rendering: {key} is {this:?}, but {that:?} in {other}"))
        }
        None => Ok(()),
    }
}

fn overlap(tiles: &[Tile]) -> Result<()> {
    for (n, tile) in tiles.iter().enumerate() {
        let this = tile.head.window;
        for other in &tiles[..n] {
            if let Some(both) = common(this, other.head.window) {
                let problem = format!("the tile covers {both}, which {} covers already", other.name);
                return Err(Error::scene(Place::file(&tile.name), problem, "remove one of the two"));
            }
        }
    }
    Ok(())
}

/// The pixels in both.
fn common(a: Window, b: Window) -> Option<Window> {
    let [x0, y0, x1, y1] = [a.x0.max(b.x0), a.y0.max(b.y0), a.x1.min(b.x1), a.y1.min(b.y1)];
    (x0 < x1 && y0 < y1).then_some(Window { x0, y0, x1, y1 })
}

fn area(window: &Window) -> u64 {
    u64::from(window.width()) * u64::from(window.height())
}

/// The pixels of `full` that none of `windows` covers, as few rectangles.
fn missing(full: Window, windows: impl Iterator<Item = Window>) -> Vec<Window> {
    let mut rest = vec![full];
    for window in windows {
        rest = rest.into_iter().flat_map(|part| without(part, window)).collect();
    }
    loop {
        let before = rest.len();
        // Those beside each other, then those above each other.
        for _ in 0..2 {
            rest.sort_by_key(|part| (part.y0, part.y1, part.x0));
            rest.dedup_by(|next, part| {
                let is_adjacent = part.x1 == next.x0 && (part.y0, part.y1) == (next.y0, next.y1);
                part.x1 = if is_adjacent { next.x1 } else { part.x1 };
                is_adjacent
            });
            for part in &mut rest {
                *part = Window { x0: part.y0, y0: part.x0, x1: part.y1, y1: part.x1 };
            }
        }
        if rest.len() == before {
            break;
        }
    }
    rest.sort_by_key(|part| (part.y0, part.x0));
    rest
}

/// The rest of `part`: above, below, left and right.
fn without(part: Window, window: Window) -> Vec<Window> {
    let Some(hole) = common(part, window) else { return vec![part] };
    let around = [
        Window { y1: hole.y0, ..part },
        Window { y0: hole.y1, ..part },
        Window { x1: hole.x0, y0: hole.y0, y1: hole.y1, ..part },
        Window { x0: hole.x1, y0: hole.y0, y1: hole.y1, ..part },
    ];
    around.into_iter().filter(|left| left.x0 < left.x1 && left.y0 < left.y1).collect()
}
