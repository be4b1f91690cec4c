//! The scene: spheres, their colours, the camera, the image. Everything geometric is f64 and taken as exact;
//! the readers below make scenes, nothing else does.

pub mod arrange;
mod csv;
mod fit;
mod foreign;
mod input;
mod lines;
mod native;
mod nff;
mod npy;
mod particles;
mod sequence;
mod source;
pub mod style;

use crate::camera::Camera;
use crate::error::{Error, Place, Result};
use crate::memory::{entries, extend_to};
use crate::progress::Watch;
use glam::DVec3;
use std::path::Path;

pub use fit::Framing;
pub use particles::{Altloc, Cell, FrameRange};
pub use sequence::{Sequence, Shot};
pub use source::Format;
pub use style::Style;

/// Linear RGB of a sphere that names no colour.
pub const DEFAULT_COLOR: [f32; 3] = [0.8, 0.8, 0.8];

/// What is to be rendered. World coordinates, in whatever length unit the user likes.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Where the picture is taken from.
    pub camera: Camera,
    /// What the picture is taken on.
    pub image: ImagePlane,
    /// What the picture is taken of.
    pub spheres: Spheres,
    /// What the reader met and left out.
    pub skipped: Skipped,
}

/// Size of the image in pixels and the colour of a ray that hits nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImagePlane {
    /// Columns, W.
    pub width: u32,
    /// Rows, H.
    pub height: u32,
    /// Linear RGB; black unless the scene says otherwise.
    pub background: [f32; 3],
}

impl Default for ImagePlane {
    /// 512 x 512 pixels on black.
    fn default() -> Self {
        Self { width: 512, height: 512, background: [0.0; 3] }
    }
}

/// The spheres in the scene's order: a sphere's id is its index here.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Spheres {
    /// World centres.
    pub centers: Vec<[f64; 3]>,
    /// Radii, positive and finite.
    pub radii: Vec<f64>,
    /// Linear RGB per sphere; `None` when no sphere of the scene names a colour, so that none is uploaded.
    pub colors: Option<Vec<[f32; 3]>>,
}

impl Spheres {
    /// How many.
    pub fn len(&self) -> usize {
        self.radii.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.radii.is_empty()
    }

    /// The corners of the box around all spheres; not finite where there is none.
    #[must_use]
    pub fn bounds(&self) -> [DVec3; 2] {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (center, radius) in self.centers.iter().zip(&self.radii) {
            let center = DVec3::from_array(*center);
            (low, high) = (low.min(center - *radius), high.max(center + *radius));
        }
        [low, high]
    }

    /// Where the spheres are, in words.
    pub fn extent(&self) -> String {
        let [low, high] = self.bounds();
        format!("the spheres lie between {} and {}", point(low), point(high))
    }

    /// Makes room for so many more, with or without colours of their own.
    ///
    /// # Errors
    /// [`Error::Limits`] where the memory has none.
    pub(crate) fn grow(&mut self, more: usize, colored: bool) -> Result<()> {
        let n = self.len();
        let room = |capacity: usize| capacity - n >= more;
        let colored = colored || self.colors.is_some();
        let colors = self.colors.as_ref().map_or(0, Vec::capacity);
        if room(self.centers.capacity()) && room(self.radii.capacity()) && (!colored || colors >= n + more) {
            return Ok(());
        }
        let each = size_of::<[f64; 3]>() + size_of::<f64>() + if colored { size_of::<[f32; 3]>() } else { 0 };
        let entries = entries(n, more, each, "spheres")?;
        extend_to(&mut self.centers, entries)?;
        extend_to(&mut self.radii, entries)?;
        // Where the first sphere names a colour, adding it makes the list.
        if self.colors.is_some() || colored && n > 0 {
            let colors = self.colors.get_or_insert_default();
            extend_to(colors, entries)?;
            colors.resize(n, DEFAULT_COLOR);
        }
        Ok(())
    }

    /// As [`Spheres::push`], where the memory has room for it.
    ///
    /// # Errors
    /// [`Error::Limits`].
    pub(crate) fn add(&mut self, center: [f64; 3], radius: f64, color: Option<[f32; 3]>) -> Result<()> {
        self.grow(1, color.is_some())?;
        self.push(center, radius, color);
        Ok(())
    }

    /// Adds one sphere. The first colour given makes a colour list; spheres without one get [`DEFAULT_COLOR`] in it.
    pub fn push(&mut self, center: [f64; 3], radius: f64, color: Option<[f32; 3]>) {
        match (&mut self.colors, color) {
            (Some(colors), color) => colors.push(color.unwrap_or(DEFAULT_COLOR)),
            (None, Some(color)) => {
                let mut colors = vec![DEFAULT_COLOR; self.len()];
                colors.push(color);
                self.colors = Some(colors);
            }
            (None, None) => {}
        }
        self.centers.push(center);
        self.radii.push(radius);
    }
}

/// A point in words.
pub(crate) fn point(p: DVec3) -> String {
    // Written out, a number of the solar system's scale fits a line and one near the ends of f64 does not.
    let number = |x: f64| match x.abs() {
        size if size == 0.0 || (1e-9..1e16).contains(&size) => x.to_string(),
        _ => format!("{x:e}"),
    };
    format!("({}, {}, {})", number(p.x), number(p.y), number(p.z))
}

/// What a reader met that is no sphere, counted by kind, in the file's order of first meeting; and what it assumed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Skipped {
    /// Kind in the singular (`polygon`) and how many.
    pub kinds: Vec<(&'static str, u64)>,
    /// What the file does not say and was assumed, or was chosen among what it says: whole sentences, with the numbers.
    pub assumed: Vec<String>,
}

impl Skipped {
    /// Counts one more of `kind`.
    pub fn add(&mut self, kind: &'static str) {
        match self.kinds.iter_mut().find(|(k, _)| *k == kind) {
            Some((_, n)) => *n += 1,
            None => self.kinds.push((kind, 1)),
        }
    }

    /// A warning for each kind, for people.
    pub fn warnings(&self) -> Vec<String> {
        let plural = |n: u64| if n == 1 { "" } else { "s" };
        self.kinds
            .iter()
            .map(|(kind, n)| format!("{n} {kind}{} skipped: only spheres are rendered", plural(*n)))
            .chain(self.assumed.iter().cloned())
            .collect()
    }

    /// Counts one more of `kind`, or refuses it where the caller is strict.
    fn meet(&mut self, kind: &'static str, options: &ReadOptions, place: impl FnOnce() -> Place) -> Result<()> {
        if options.strict {
            let mend = "take it out, or read without strict to leave it out";
            return Err(Error::scene(place(), format!("a {kind} is no sphere"), mend));
        }
        self.add(kind);
        Ok(())
    }

    /// All kinds together.
    pub fn total(&self) -> u64 {
        self.kinds.iter().map(|(_, n)| n).sum()
    }
}

/// How a scene is read.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// Whether an item that is no sphere is an error; otherwise it is counted in [`Skipped`].
    pub strict: bool,
    /// The file's format; `None` has its content, then its name, tell.
    pub format: Option<Format>,
    /// Which frames of a sequence.
    pub frames: FrameRange,
    /// The MODEL of a PDB or mmCIF file by its number; `None` takes the first as the first frame.
    pub model: Option<i64>,
    /// Which alternate locations of atoms.
    pub altloc: Altloc,
    /// The biological assembly to be built by the file's operators; `None` takes the atoms as they stand.
    pub assembly: Option<String>,
    /// Whether the atoms of small-molecule CIF are taken as the file lists them; otherwise its symmetry fills the cell.
    pub as_listed: bool,
    /// How particles look.
    pub style: Style,
    /// Who may end the reading.
    pub watch: Watch,
}

impl Scene {
    /// Reads a scene file, or standard input when `path` is `-`, compressed by gzip or bzip2 or not. The content tells the
    /// format, and then the name. Of a sequence, the first frame that is asked for.
    ///
    /// Spheres are named by their id, counted from 0 in the file's order, also in errors. A file without a camera gets one
    /// that shows all of it.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that cannot be read, [`Error::Scene`] for content that makes no scene,
    /// [`Error::Settings`] for options that do not go with it.
    pub fn read(path: &Path, options: &ReadOptions) -> Result<Self> {
        let mut sequence = Sequence::open(path, options)?;
        let first = sequence.next_scene()?;
        first.map(|frame| frame.scene).ok_or_else(|| sequence.nothing())
    }

    /// Checks what a reader checks, for a scene made in memory: sizes, radii, finite numbers, the camera.
    ///
    /// # Errors
    /// [`Error::Scene`] naming the first field that cannot be rendered.
    pub fn check(&self) -> Result<()> {
        let s = &self.spheres;
        if s.centers.len() != s.radii.len() || s.colors.as_ref().is_some_and(|c| c.len() != s.radii.len()) {
            let problem = format!(
                "{} centres, {} radii and {} colours do not make spheres",
                s.centers.len(),
                s.radii.len(),
                s.colors.as_ref().map_or(0, Vec::len)
            );
            return Err(Error::scene("spheres", problem, "give as many of each"));
        }
        for (index, (center, radius)) in s.centers.iter().zip(&s.radii).enumerate() {
            check_sphere(*center, *radius, || Place::field(format!("sphere {index}")))?;
        }
        self.image.check()?;
        self.camera.basis().map(drop)?;
        self.camera.viewport(self.image.width, self.image.height).map(drop)
    }
}

impl Scene {
    /// A fingerprint of everything that decides the picture: the same for the same numbers, wherever they came from.
    /// 32 hexadecimal digits of BLAKE3.
    pub fn fingerprint(&self) -> String {
        let mut hash = blake3::Hasher::new();
        hash.update(format!("{:?} {:?}", self.camera, self.image).as_bytes());
        hash.update_rayon(bytemuck::cast_slice(&self.spheres.centers));
        hash.update_rayon(bytemuck::cast_slice(&self.spheres.radii));
        if let Some(colors) = &self.spheres.colors {
            hash.update(b"colors");
            hash.update_rayon(bytemuck::cast_slice(colors));
        }
        hash.finalize().to_hex()[..32].to_owned()
    }
}

impl ImagePlane {
    fn check(&self) -> Result<()> {
        check_size([i64::from(self.width), i64::from(self.height)], || Place::field("image.size")).map(drop)?;
        check_color(self.background, || Place::field("image.background"))
    }
}

/// Largest number of columns or rows: 2j + 1 - W stays exact in f32 far beyond it, and id buffers stay addressable.
pub const MAX_SIDE: i64 = 1 << 20;

/// A size in pixels that is positive and not absurd, as (W, H). One place for every reader and the command line.
///
/// # Errors
/// [`Error::Scene`] at `place`.
pub fn check_size([width, height]: [i64; 2], place: impl FnOnce() -> Place) -> Result<(u32, u32)> {
    if [width, height].iter().all(|side| (1..=MAX_SIDE).contains(side)) {
        return Ok((width as u32, height as u32));
    }
    let problem = format!("an image of {width} x {height} pixels cannot be made");
    Err(Error::scene(place(), problem, format!("give two whole numbers between 1 and {MAX_SIDE}")))
}

/// A sphere that can be rendered: finite centre, positive finite radius. One place for every reader.
///
/// # Errors
/// [`Error::Scene`] at `place`, with the field appended.
pub fn check_sphere(center: [f64; 3], radius: f64, place: impl Fn() -> Place) -> Result<()> {
    let inside = |field: &str| {
        let place = place();
        let name = place.field.as_ref().map_or_else(|| field.to_owned(), |outer| format!("{outer} {field}"));
        place.named(name)
    };
    if let Some(bad) = center.iter().find(|x| !x.is_finite()) {
        return Err(Error::scene(inside("center"), format!("{bad} is not a place"), "give three finite numbers"));
    }
    if !(radius > 0.0 && radius.is_finite()) {
        let problem = format!("a radius of {radius} makes no sphere");
        return Err(Error::scene(inside("radius"), problem, "give a positive finite number"));
    }
    Ok(())
}

/// A colour that can be shown: three finite numbers, none negative. One place for every reader.
///
/// # Errors
/// [`Error::Scene`] at `place`.
pub fn check_color(color: [f32; 3], place: impl FnOnce() -> Place) -> Result<()> {
    match color.iter().find(|c| !(c.is_finite() && **c >= 0.0)) {
        None => Ok(()),
        Some(bad) => Err(Error::scene(place(), format!("{bad} is no colour component"), "give linear RGB, 0 or more")),
    }
}

/// The same fault, found by a check that knows only the field, at the place of that field in the file.
fn relocate(error: Error, place: impl FnOnce(&str) -> Place) -> Error {
    match error {
        Error::Scene { place: old, problem, mend, source } => {
            let place = Box::new(place(old.field.as_deref().unwrap_or_default()));
            Error::Scene { place, problem, mend, source }
        }
        other => other,
    }
}

/// The ending in lower case, empty if there is none.
fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}
