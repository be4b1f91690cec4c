//! The native scene file: TOML with `[camera]`, `[image]`, `[[sphere]]`, `[[spheres]]`, `[[light]]`, `[sky]` and
//! `[occlusion]`.
//! Every error has the line, column and key.

mod image;
mod lens;
mod light;
mod material;
mod room;
mod spheres;
mod table;

use glam::DVec3;
use halfline::error::{Error, Place, Result, relocate};
use halfline::memory::{check, reserve};
use halfline::progress::Watch;
use halfline::scene::camera::{Aperture, Camera, Lens, Look};
use halfline::scene::{CutPlane, ImagePlane, Scene, Spheres, check_sphere};
use halfline::settings::FileLook;
use halfline_particles::Skipped;
use halfline_particles::input::Input;
use halfline_particles::lines::{check_idle, not_utf8};
pub(super) use spheres::{NamedSpheres, rows_of};
use std::io::BufRead;
use std::path::{Path, PathBuf};
use table::{TomlName, TomlTable, TomlText};
use toml::de::DeTable;

/// The most bytes of a scene file; large numbers of spheres belong in a separate file.
const LONGEST: usize = 1 << 30;

/// Bytes that are parsed without checking for an interrupt, which may take a second; the parser reads 8 MB in that
/// time.
const QUICK: usize = 2 << 20;

/// The content of a native scene file, or of another file with a whole scene.
pub(super) struct Read {
    pub(super) scene: Scene,
    pub(super) skipped: Skipped,
    pub(super) look: FileLook,
    /// The size of the camera's lens.
    pub(super) aperture: Option<Aperture>,
    pub(super) cuts: Vec<CutPlane>,
    /// The files in `[[spheres]]`.
    pub(super) files: Vec<PathBuf>,
}

impl Read {
    /// A scene with nothing else known about it.
    pub(super) fn of((scene, skipped): (Scene, Skipped)) -> Self {
        Self { scene, skipped, look: FileLook::default(), aperture: None, cuts: Vec::new(), files: Vec::new() }
    }
}

/// Reads a scene from the stream; `path` is for errors, and its folder contains the files of `[[spheres]]`.
pub(super) fn read(reader: Input, path: &Path, watch: &Watch) -> Result<Read> {
    document(reader, path, watch, true).map(|(read, _)| read)
}

/// The same without the spheres of `[[spheres]]`, whose tables are returned. Lights may be any of the spheres.
pub(super) fn without_files(reader: Input, path: &Path, watch: &Watch) -> Result<(Read, Vec<NamedSpheres>)> {
    document(reader, path, watch, false)
}

fn document(reader: Input, path: &Path, watch: &Watch, is_whole: bool) -> Result<(Read, Vec<NamedSpheres>)> {
    let file = Place::file(path.display().to_string());
    // Comments may have any bytes; elsewhere the first that is not UTF-8 is the error.
    let (text, invalid) = match String::from_utf8(bytes(reader, path)?) {
        Ok(text) => (text, None),
        Err(e) => (String::from_utf8_lossy(e.as_bytes()).into_owned(), Some(not_utf8(file.clone(), 0, e))),
    };
    check_idle(&text, &file)?;
    let has_invalid =
        |line: &str| line.split('#').next().is_some_and(|code| code.contains(char::REPLACEMENT_CHARACTER));
    let is_used = invalid.is_some() && text.lines().any(has_invalid);
    let length = text.len();
    check(room::most_bytes(&text), || format!("{file}: {length} bytes of TOML"))?;
    let (path, within) = (path.to_path_buf(), watch.clone());
    let parse = move || {
        // The byte order mark is not a character of the first line.
        let text = text.trim_start_matches('\u{feff}');
        let text = TomlText { file, text };
        Document { text: &text, path: &path, watch: &within }.read(is_whole)
    };
    let read = if length <= QUICK { parse() } else { watch.wait_for(parse) };
    match invalid {
        Some(invalid) if is_used || matches!(read, Err(Error::Scene { .. } | Error::Io { .. })) => Err(invalid),
        _ => read,
    }
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

/// The keys of a `[[sphere]]`; those after the opacity are its material.
const SPHERE: [&str; 12] = [
    "center",
    "radius",
    "color",
    "opacity",
    "material",
    "diffuse",
    "specular",
    "gloss",
    "shine",
    "transmission",
    "index",
    "fuzz",
];

struct Document<'a> {
    text: &'a TomlText<'a>,
    path: &'a Path,
    watch: &'a Watch,
}

impl Document<'_> {
    /// `is_whole` reads the files of `[[spheres]]` too.
    fn read(&self, is_whole: bool) -> Result<(Read, Vec<NamedSpheres>)> {
        let root = DeTable::parse(self.text.text).map_err(|e| self.syntax(e))?;
        let root = TomlTable::top(self.text, root.get_ref());
        root.allow(&["camera", "image", "sphere", "spheres", "light", "sky", "occlusion", "cut"])?;
        let image::Read { image, background, look } = match root.get("image") {
            Some(table) => image::read(&table.table(TomlName::part("image"))?)?,
            None => image::Read::default(),
        };
        let table = root.need("camera")?.table(TomlName::part("camera"))?;
        let camera = self.camera(&table, &image)?;
        let aperture = lens::read(&table, &camera)?;
        let (mut spheres, mut skipped, mut named) = (Spheres::default(), Skipped::default(), Vec::new());
        for table in root.tables("sphere")? {
            self.sphere(&table?, &mut spheres)?;
        }
        for table in root.tables("spheres")? {
            let more = NamedSpheres::of(&table?, self.path)?;
            if is_whole {
                skipped.assumed.extend(more.read(&mut spheres, self.watch)?);
            }
            named.push(more);
        }
        let cuts = root.tables("cut")?.map(|table| cut(&table?)).collect::<Result<_>>()?;
        let lighting = light::read(&root, if is_whole { spheres.len() } else { usize::MAX })?;
        let mut scene = Scene { camera, image, spheres, lighting };
        // Where the sky's colours are not to be seen, what stands for it is the colour of its horizon.
        if let Some(colors) = scene.lighting.sky.and_then(|sky| sky.colors) {
            scene.image.background = colors.horizon;
        }
        if let Some(color) = background {
            scene.set_background(color);
        }
        let files = named.iter().map(|more| more.path.clone()).collect();
        Ok((Read { scene, skipped, look, aperture, cuts, files }, named))
    }

    fn syntax(&self, error: toml::de::Error) -> Error {
        let span = error.span().unwrap_or_default();
        let mut place = self.text.place(span.start);
        let problem = error.message().lines().collect::<Vec<_>>().join(", ");
        // Only for this error does the parser's span cover a whole key.
        if problem == "duplicate key" {
            place.field = self.text.text.get(span).map(str::to_owned);
        }
        let mend = "correct the TOML there".into();
        Error::Scene { place: Box::new(place), problem, mend, source: Some(Box::new(error)) }
    }

    fn camera(&self, table: &TomlTable<'_>, image: &ImagePlane) -> Result<Camera> {
        table.allow(&[
            "eye",
            "at",
            "view",
            "up",
            "lens",
            "vfov",
            "viewport",
            "distance",
            "height",
            "fx",
            "fy",
            "cx",
            "cy",
            "coefficients",
            "aperture",
            "focus",
        ])?;
        let vector = |key| table.need(key)?.numbers().map(DVec3::from_array);
        let look = match table.one_of(["at", "view"])? {
            "at" => Look::At(vector("at")?),
            _ => Look::View(vector("view")?),
        };
        let lens = match lens::named(table, image)? {
            Some(lens) => lens,
            None => Self::flat_lens(table)?,
        };
        let camera = Camera { eye: vector("eye")?, look, up: vector("up")?, lens };
        let locate = |error| {
            relocate(error, |field| {
                let key = field.trim_start_matches("camera.");
                // A viewport that overflows was computed from the angle.
                table.place_of(key, "vfov").named(field)
            })
        };
        camera.basis().map_err(locate)?;
        camera.check(image.width, image.height).map_err(locate)?;
        Ok(camera)
    }

    /// The lens of a camera without `lens`.
    fn flat_lens(table: &TomlTable<'_>) -> Result<Lens> {
        let distance = table.get("distance").map_or(Ok(1.0), |d| d.number())?;
        Ok(match table.one_of(["vfov", "viewport", "height"])? {
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
        })
    }

    fn sphere(&self, table: &TomlTable<'_>, spheres: &mut Spheres) -> Result<()> {
        table.allow(&SPHERE)?;
        let center = table.need("center")?.numbers()?;
        let radius = table.need("radius")?;
        let length = radius.number()?;
        check_sphere(center, length, || radius.place().named(format!("sphere {}", spheres.len())))?;
        let color = table.get("color").map(|color| color.color()).transpose()?;
        let material = material::read(table, spheres.len())?;
        let opacity = table.opacity(format_args!("sphere {}", spheres.len()))?;
        spheres.add(center, length, color)?;
        spheres.set_last_material(material);
        spheres.set_opacity_from(spheres.len() - 1, opacity);
        Ok(())
    }
}

/// A plane of `[[cut]]`.
fn cut(table: &TomlTable<'_>) -> Result<CutPlane> {
    table.allow(&["normal", "distance"])?;
    let (normal, distance) = (table.need("normal")?, table.need("distance")?);
    let plane = CutPlane { normal: normal.numbers()?, distance: distance.number()? };
    plane.check(|| normal.place())?;
    Ok(plane)
}
