//! The native scene file: TOML with `[camera]`, `[image]`, `[[sphere]]` and `[[spheres]]`. Every error has the line,
//! column and key.

mod room;

use super::format::ending;
use super::input::Input;
use super::lines::not_utf8;
use super::{csv, npy};
use crate::error::{Error, Place, Result, relocate};
use crate::memory::{check, reserve};
use crate::progress::Watch;
use crate::quote::quote;
use crate::scene::camera::{Camera, Lens, Look};
use crate::scene::{ImagePlane, Scene, Skipped, Spheres, check_color, check_size, check_sphere};
use glam::DVec3;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

/// The most bytes of a scene file; large numbers of spheres belong in a separate file.
const LONGEST: usize = 1 << 30;

/// Bytes that are parsed without checking for an interrupt, which may take a second; the parser reads 8 MB in that
/// time.
const QUICK: usize = 2 << 20;

/// Reads a scene from the stream, and the names of the files in `[[spheres]]`; `path` is for errors, and its folder
/// contains the files.
pub(super) fn read(reader: Input, path: &Path, watch: &Watch) -> Result<(Scene, Vec<PathBuf>)> {
    let file = Place::file(path.display().to_string());
    let text = String::from_utf8(bytes(reader, path)?).map_err(|e| not_utf8(file.clone(), 0, e))?;
    let length = text.len();
    check(room::most_held(&text), || format!("{file}: {length} bytes of TOML"))?;
    let (path, within) = (path.to_path_buf(), watch.clone());
    let parse = move || {
        // The byte order mark is not a character of the first line.
        let text = text.trim_start_matches('\u{feff}');
        let mut files = Vec::new();
        let scene = Document { file, text, path: &path, watch: &within }.scene(&mut files)?;
        Ok((scene, files))
    };
    if length <= QUICK { parse() } else { watch.wait_for(parse) }
}

/// All bytes of a scene file.
fn bytes(mut reader: Input, path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    loop {
        let block = reader.fill_buf().map_err(|e| Error::read(path, e))?;
        if block.is_empty() {
            return Ok(bytes);
        }
        if bytes.len() + block.len() > LONGEST {
            let problem = format!("{}: the scene file has more than {LONGEST} bytes", path.display());
            let mend = "put its spheres into a .csv or .npy file, and refer to it with [[spheres]]".into();
            return Err(Error::Limits { problem, mend });
        }
        reserve(&mut bytes, block.len())?;
        bytes.extend_from_slice(block);
        let read = block.len();
        reader.consume(read);
    }
}

struct Document<'a> {
    file: Place,
    text: &'a str,
    path: &'a Path,
    watch: &'a Watch,
}

impl Document<'_> {
    fn place(&self, byte: usize) -> Place {
        self.file.clone().at_byte(self.text, byte)
    }

    fn scene(&self, files: &mut Vec<PathBuf>) -> Result<Scene> {
        let root = DeTable::parse(self.text).map_err(|e| self.syntax(e))?;
        let root = TomlTable { doc: self, name: TomlName::TOP, keys: root.get_ref(), start: 0 };
        root.allow(&["camera", "image", "sphere", "spheres"])?;
        let image = match root.get("image") {
            Some(image) => self.image(&image.table(TomlName::part("image"))?)?,
            None => ImagePlane::default(),
        };
        let camera = self.camera(&root.need("camera")?.table(TomlName::part("camera"))?, &image)?;
        let mut spheres = Spheres::default();
        for table in root.tables("sphere")? {
            self.sphere(&table?, &mut spheres)?;
        }
        for table in root.tables("spheres")? {
            files.push(self.spheres(&table?, &mut spheres)?);
        }
        Ok(Scene { camera, image, spheres, lighting: Default::default(), skipped: Skipped::default() })
    }

    fn syntax(&self, error: toml::de::Error) -> Error {
        let span = error.span().unwrap_or_default();
        let mut place = self.place(span.start);
        let problem = error.message().lines().collect::<Vec<_>>().join(", ");
        // Only for this error does the parser's span cover a whole key.
        if problem == "duplicate key" {
            place.field = self.text.get(span).map(str::to_owned);
        }
        let mend = "correct the TOML there".into();
        Error::Scene { place: Box::new(place), problem, mend, source: Some(Box::new(error)) }
    }

    fn image(&self, table: &TomlTable<'_>) -> Result<ImagePlane> {
        table.allow(&["size", "background"])?;
        let mut image = ImagePlane::default();
        if let Some(size) = table.get("size") {
            (image.width, image.height) = check_size(size.whole_numbers()?, || size.place())?;
        }
        if let Some(background) = table.get("background") {
            image.background = background.color()?;
        }
        Ok(image)
    }

    fn camera(&self, table: &TomlTable<'_>, image: &ImagePlane) -> Result<Camera> {
        table.allow(&["eye", "at", "view", "up", "vfov", "viewport", "distance", "height"])?;
        let vector = |key| table.need(key)?.numbers().map(DVec3::from_array);
        let look = match table.one_of(["at", "view"])? {
            "at" => Look::At(vector("at")?),
            _ => Look::View(vector("view")?),
        };
        let distance = table.get("distance").map_or(Ok(1.0), |d| d.number())?;
        let lens = match table.one_of(["vfov", "viewport", "height"])? {
            "height" => {
                if let Some(distance) = table.get("distance") {
                    let problem = "an orthographic camera has no viewport distance";
                    return Err(Error::scene(distance.place(), problem, "remove it, or use vfov instead of height"));
                }
                Lens::Orthographic { height: table.need("height")?.number()? }
            }
            "vfov" => Lens::Vfov { degrees: table.need("vfov")?.number()?, distance },
            _ => {
                let [vw, vh] = table.need("viewport")?.numbers()?;
                Lens::Viewport { vw, vh, distance }
            }
        };
        let camera = Camera { eye: vector("eye")?, look, up: vector("up")?, lens };
        let locate = |error| {
            relocate(error, |field| {
                let key = field.trim_start_matches("camera.");
                // A viewport that overflows was computed from the angle.
                let value = table.keys.get(key).or_else(|| table.keys.get("vfov"));
                self.place(value.map_or(table.start, |value| value.span().start)).named(field)
            })
        };
        camera.basis().map_err(locate)?;
        camera.viewport(image.width, image.height).map_err(locate)?;
        Ok(camera)
    }

    fn sphere(&self, table: &TomlTable<'_>, spheres: &mut Spheres) -> Result<()> {
        table.allow(&["center", "radius", "color"])?;
        let center = table.need("center")?.numbers()?;
        let radius = table.need("radius")?;
        let length = radius.number()?;
        check_sphere(center, length, || radius.place().named(format!("sphere {}", spheres.len())))?;
        let color = table.get("color").map(|color| color.color()).transpose()?;
        spheres.add(center, length, color)
    }

    /// Reads the spheres of a file; returns its path.
    fn spheres(&self, table: &TomlTable<'_>, spheres: &mut Spheres) -> Result<PathBuf> {
        table.allow(&["file"])?;
        let file = table.need("file")?;
        let name = file.string()?;
        let path = self.path.parent().unwrap_or(Path::new("")).join(name);
        match ending(&path).as_str() {
            "csv" => csv::read(&path, spheres, self.watch),
            "npy" => npy::read(&path, spheres, self.watch),
            _ => {
                let problem = format!("{} is not a supported file of spheres", quote(name));
                Err(Error::scene(file.place(), problem, "use a .csv or a .npy file"))
            }
        }?;
        Ok(path)
    }
}

/// The name of a table in errors: `camera`, `sphere 3`, or nothing for the top level.
#[derive(Clone, Copy)]
struct TomlName {
    part: &'static str,
    index: Option<usize>,
}

impl TomlName {
    const TOP: Self = Self::part("");

    const fn part(part: &'static str) -> Self {
        Self { part, index: None }
    }

    fn field(self, key: &str) -> String {
        match self {
            Self { part: "", .. } => key.to_owned(),
            Self { part, index: Some(index) } => format!("{part} {index} {key}"),
            Self { part, index: None } => format!("{part}.{key}"),
        }
    }
}

/// A table, and its position.
struct TomlTable<'a> {
    doc: &'a Document<'a>,
    name: TomlName,
    keys: &'a DeTable<'a>,
    start: usize,
}

impl<'a> TomlTable<'a> {
    /// Returns an error at the first key that is not one of `known`.
    fn allow(&self, known: &[&str]) -> Result<()> {
        let unknown = self.keys.keys().filter(|key| !known.contains(&key.get_ref().as_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else { return Ok(()) };
        let place = self.doc.place(key.span().start).named(self.name.field(key.get_ref()));
        Err(Error::scene(place, "unknown key", format!("the keys of this table are {}", known.join(", "))))
    }

    fn get(&self, key: &'static str) -> Option<TomlValue<'a>> {
        self.keys.get(key).map(|value| TomlValue { doc: self.doc, name: self.name, key, value })
    }

    fn need(&self, key: &'static str) -> Result<TomlValue<'a>> {
        self.get(key).ok_or_else(|| self.missing(key, format!("add {}", example(key))))
    }

    fn missing(&self, key: &str, mend: String) -> Error {
        Error::scene(self.doc.place(self.start).named(self.name.field(key)), "missing", mend)
    }

    /// The only key of `keys` that is present; it is an error if there is none or more than one.
    fn one_of<const N: usize>(&self, keys: [&'static str; N]) -> Result<&'static str> {
        let mut there: Vec<_> = keys.into_iter().filter_map(|key| self.get(key)).collect();
        there.sort_by_key(|value| value.value.span().start);
        match there[..] {
            [only] => Ok(only.key),
            [first, second, ..] => {
                let [a, b] = [first.key, second.key];
                Err(Error::scene(second.place(), format!("{a} and {b} exclude each other"), format!("use {a} or {b}")))
            }
            [] => Err(self.missing(keys[0], format!("add {}", keys.map(example).join(" or ")))),
        }
    }

    /// The tables of an array of tables; none if the key is missing.
    fn tables(&self, key: &'static str) -> Result<impl Iterator<Item = Result<TomlTable<'a>>>> {
        let items: &'a [Spanned<DeValue<'a>>] = match self.get(key) {
            None => &[],
            Some(value) => value.array()?,
        };
        let (doc, name) = (self.doc, self.name);
        Ok(items.iter().enumerate().map(move |(index, value)| {
            let name = TomlValue { doc, name, key, value };
            name.table(TomlName { part: key, index: Some(index) })
        }))
    }
}

/// The value of a key, and its name.
#[derive(Clone, Copy)]
struct TomlValue<'a> {
    doc: &'a Document<'a>,
    name: TomlName,
    key: &'static str,
    value: &'a Spanned<DeValue<'a>>,
}

impl<'a> TomlValue<'a> {
    fn place(&self) -> Place {
        self.doc.place(self.value.span().start).named(self.name.field(self.key))
    }

    /// An error at this value, or at `part` of it.
    fn wrong(&self, part: &Spanned<DeValue<'_>>, problem: String) -> Error {
        let place = self.doc.place(part.span().start).named(self.name.field(self.key));
        Error::scene(place, problem, format!("write {}", example(self.key)))
    }

    fn mistyped(&self, part: &Spanned<DeValue<'_>>, wanted: &str) -> Error {
        self.wrong(part, format!("expected {wanted}, found a value of type {}", part.get_ref().type_str()))
    }

    fn table(&self, name: TomlName) -> Result<TomlTable<'a>> {
        match self.value.get_ref() {
            DeValue::Table(keys) => Ok(TomlTable { doc: self.doc, name, keys, start: self.value.span().start }),
            _ => Err(self.mistyped(self.value, "a table")),
        }
    }

    fn array(&self) -> Result<&'a [Spanned<DeValue<'a>>]> {
        match self.value.get_ref() {
            DeValue::Array(items) => Ok(items),
            _ => Err(self.mistyped(self.value, "an array")),
        }
    }

    fn string(&self) -> Result<&'a str> {
        self.value.get_ref().as_str().ok_or_else(|| self.mistyped(self.value, "a string"))
    }

    fn number(&self) -> Result<f64> {
        self.finite(self.value)
    }

    fn numbers<const N: usize>(&self) -> Result<[f64; N]> {
        self.items(Self::finite)
    }

    fn whole_numbers<const N: usize>(&self) -> Result<[i64; N]> {
        self.items(|this, part| match part.get_ref() {
            DeValue::Integer(i) => {
                i64::from_str_radix(i.as_str(), i.radix()).map_err(|_| this.wrong(part, format!("{i} is out of range")))
            }
            _ => Err(this.mistyped(part, "a whole number")),
        })
    }

    fn color(&self) -> Result<[f32; 3]> {
        let color = self.numbers()?.map(|c: f64| c as f32);
        check_color(color, || self.place())?;
        Ok(color)
    }

    /// An array of exactly N, each converted.
    fn items<T: Copy + Default, const N: usize>(
        &self,
        convert: impl Fn(&Self, &Spanned<DeValue<'_>>) -> Result<T>,
    ) -> Result<[T; N]> {
        let items = self.array()?;
        if items.len() != N {
            return Err(self.wrong(self.value, format!("expected {N} values, found {}", items.len())));
        }
        let mut out = [T::default(); N];
        for (out, item) in out.iter_mut().zip(items) {
            *out = convert(self, item)?;
        }
        Ok(out)
    }

    /// A finite number; TOML has keywords for the others.
    fn finite(&self, part: &Spanned<DeValue<'_>>) -> Result<f64> {
        let number = match part.get_ref() {
            DeValue::Float(x) => x.as_str().parse().ok(),
            DeValue::Integer(i) => integer(i),
            _ => return Err(self.mistyped(part, "a number")),
        };
        number.filter(|x: &f64| x.is_finite()).ok_or_else(|| self.wrong(part, "expected a finite number".into()))
    }
}

/// The nearest f64. Integers of any length are read like the float with the same digits.
fn integer(i: &DeInteger<'_>) -> Option<f64> {
    match i.radix() {
        10 => i.as_str().parse().ok(),
        radix => i128::from_str_radix(i.as_str(), radix).ok().map(|i| i as f64),
    }
}

/// How a key is written, for remedies in messages.
fn example(key: &str) -> &'static str {
    match key {
        "camera" => "a [camera] table",
        "image" => "an [image] table",
        "sphere" => "[[sphere]] tables",
        "spheres" => "[[spheres]] tables",
        "eye" => "eye = [0.0, 0.0, 5.0]",
        "at" => "at = [0.0, 0.0, 0.0]",
        "view" => "view = [0.0, 0.0, -1.0]",
        "up" => "up = [0.0, 1.0, 0.0]",
        "vfov" => "vfov = 40.0",
        "viewport" => "viewport = [1.0, 1.0]",
        "distance" => "distance = 1.0",
        "height" => "height = 12.0",
        "size" => "size = [512, 512]",
        "center" => "center = [0.0, 0.0, 0.0]",
        "radius" => "radius = 1.0",
        "file" => "file = \"spheres.csv\"",
        "background" => "background = [0.0, 0.0, 0.0]",
        _ => "color = [0.8, 0.8, 0.8]",
    }
}
