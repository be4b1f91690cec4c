//! Haines' Neutral File Format, as written by the Standard Procedural Databases. Spheres with their materials and lights are
//! read; cones, polygons and polygonal patches are counted and skipped.
//!
//! A fill is the colour and the material of the spheres that follow: Kd, Ks, Shine, T and the index of refraction, or 1, 0,
//! 0, 0 and 1. The description of the format sets no limits ("Usually, 0 <= Kd <= 1 and 0 <= Ks <= 1"), and files had any
//! numbers before anything used them; here the nearest number in range is taken, with a warning.
//!
//! Lights are points that cast shadows. Of their brightness the description of the format (NFF.DOC) says: "Lights have a
//! non-zero intensity of no particular value, if not specified (i.e. the program can determine a useful intensity as
//! desired); the red/green/blue color of the light can optionally be specified." Here a light without a colour is white
//! with the intensity 1/sqrt(n), n being the number of lights in the file: where all of several lights meet, a surface is
//! brighter than under one, but a few lights do not drown it. A light with a colour has that colour and the intensity 1.
//!
//! Every statement begins on a new line; its numbers may continue on the following lines.

use glam::DVec3;
use halfline::error::{Error, Place, Result, relocate};
use halfline::quote::{count, quote};
use halfline::scene::camera::{Camera, Lens, Look};
use halfline::scene::{
    ImagePlane, Light, LightSource, Lighting, Material, Materials, Scene, Spheres, check_color, check_size,
    check_sphere,
};
use halfline_particles::Skipped;
use halfline_particles::formats::scenes::NFF_DIRECTIVES;
use halfline_particles::input::Input;
use halfline_particles::lines::{Lines, Spot, mend_number};
use std::fmt;
use std::path::Path;

/// The words that begin a line of the `v` block.
const VIEW: [&str; 6] = ["from", "at", "up", "angle", "hither", "resolution"];

/// Reads a scene from the stream; `path` is for errors.
pub(super) fn read(reader: Input, path: &Path, strict: bool) -> Result<(Scene, Skipped)> {
    let mut nff = Reader { lines: Lines::new(reader, path), next: 0 };
    let mut statements = Statements { strict, ..Statements::default() };
    while let Some(word) = nff.peek()? {
        let spot = nff.spot(word);
        let directive = nff.directive(word)?;
        nff.take(word);
        statements.add(&mut nff, directive, spot)?;
    }
    statements.scene(&nff)
}

/// The statements of a file so far.
#[derive(Default)]
struct Statements {
    strict: bool,
    view: Option<(Camera, ImagePlane)>,
    background: Option<[f32; 3]>,
    /// The colour and the material of the spheres that follow.
    fill: Option<([f32; 3], Material)>,
    spheres: Spheres,
    lights: Vec<(DVec3, Option<[f32; 3]>)>,
    /// The numbers of materials out of range, and of those with a Kd other than 1.
    limited: u64,
    dimmed: u64,
    skipped: Skipped,
}

impl Statements {
    /// Reads the numbers of a statement whose directive is at `spot`.
    fn add(&mut self, nff: &mut Reader, directive: &str, spot: Spot) -> Result<()> {
        let at = |name, id| Statement { spot, name, id };
        match directive {
            "v" if self.view.is_some() => return Err(nff.unknown(spot, "found a second view".into())),
            "v" => self.view = Some(nff.view(&at("camera", None))?),
            "b" if self.background.is_some() => return Err(nff.unknown(spot, "found a second background".into())),
            "b" => self.background = Some(nff.color(&at("background", None), 3)?),
            "f" => {
                let (color, material, in_range) = nff.fill(&at("fill", None))?;
                if !in_range && self.strict {
                    let mend = "use Kd, Ks and T from 0 to 1 and an index from 0.1 to 10, or read without strict";
                    let problem = "a part of the material is out of range";
                    return Err(Error::scene(nff.place(&at("fill", None)), problem, mend));
                }
                self.limited += u64::from(!in_range);
                self.dimmed += u64::from(matches!(material, Material::Phong { diffuse, .. } if diffuse != 1.0));
                self.fill = Some((color, material));
            }
            "l" => self.lights.push(nff.light(&at("light", None))?),
            "s" => {
                let (center, radius) = nff.sphere(&at("sphere", Some(self.spheres.len())))?;
                self.spheres.add(center, radius, self.fill.map(|(color, _)| color))?;
                if let Some((_, material)) = self.fill {
                    self.spheres.set_last_material(material);
                }
                nff.lines.found();
            }
            _ => {
                let kind = nff.other(directive, &at)?;
                self.skipped.skip(kind, self.strict, || nff.place(&at(kind, None)))?;
            }
        }
        Ok(())
    }

    /// The scene of the whole file, and the statements that were skipped or read in another way.
    fn scene(self, nff: &Reader) -> Result<(Scene, Skipped)> {
        let Self { view, background, spheres, lights, limited, dimmed, mut skipped, .. } = self;
        let Some((camera, mut image)) = view else {
            let mend = "add lines that begin with v, from, at, up, angle and resolution";
            return Err(Error::scene(nff.lines.file().named("camera"), "the v block is missing", mend));
        };
        image.background = background.unwrap_or(image.background);
        if limited > 0 {
            let what = "Kd, Ks and T are used from 0 to 1, Shine from 0, the index of refraction from 0.1 to 10";
            skipped.assumed.push(format!("{} out of range: {what}", count(limited, "material")));
        }
        let bounces = spheres.materials.as_ref().is_some_and(Materials::bounce);
        if dimmed > 0 && lights.is_empty() && !bounces {
            let what = "the file has no lights, and the light at the eye shows the whole colour";
            skipped.assumed.push(format!("Kd of {} is left out: {what}", count(dimmed, "material")));
        }
        Ok((Scene { camera, image, spheres, lighting: lighting(&lights) }, skipped))
    }
}

/// The lights at these points, with these colours where the file gives one.
fn lighting(lights: &[(DVec3, Option<[f32; 3]>)]) -> Lighting {
    let dimmed = (1.0 / (lights.len() as f64).sqrt()) as f32;
    let light = |&(position, color): &(DVec3, Option<[f32; 3]>)| match color {
        Some(color) => Light { color, ..Light::white(LightSource::Point(position)) },
        None => Light { intensity: dimmed, ..Light::white(LightSource::Point(position)) },
    };
    Lighting { lights: lights.iter().map(light).collect(), shadows: !lights.is_empty(), sky: None, bounces: None }
}

/// A range of the current line.
#[derive(Debug, Clone, Copy)]
struct WordRange {
    start: usize,
    end: usize,
}

/// The statement whose numbers are read, for errors.
struct Statement {
    spot: Spot,
    name: &'static str,
    id: Option<usize>,
}

impl fmt::Display for Statement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.id {
            Some(id) => write!(f, "{} {id}", self.name),
            None => f.write_str(self.name),
        }
    }
}

/// Up to eight numbers, the most that any statement has at once, and their places.
#[derive(Default)]
struct Numbers {
    values: [f64; 8],
    spots: [Spot; 8],
    count: usize,
}

struct Reader {
    lines: Lines<Input>,
    next: usize,
}

impl Reader {
    /// The next word, on any line, without consuming it.
    fn peek(&mut self) -> Result<Option<WordRange>> {
        loop {
            let rest = &self.lines.text()[self.next..];
            let word = rest.trim_start();
            if !word.is_empty() && !word.starts_with('#') {
                let start = self.next + rest.len() - word.len();
                let length = word.find(char::is_whitespace).unwrap_or(word.len());
                return Ok(Some(WordRange { start, end: start + length }));
            }
            self.next = 0;
            if !self.lines.advance()? {
                return Ok(None);
            }
            self.lines.check_utf8(self.lines.text().find('#').unwrap_or(usize::MAX))?;
        }
    }

    /// The directive of the statement that begins with a word.
    fn directive(&self, word: WordRange) -> Result<&'static str> {
        let text = self.text(word);
        let problem = match NFF_DIRECTIVES.into_iter().find(|directive| *directive == text) {
            Some(directive) if self.begins_line(word) => return Ok(directive),
            Some(_) => format!("expected the end of the line, found {}", quote(text)),
            None if VIEW.contains(&text) => format!("{} is outside of a v block", quote(text)),
            None if text.parse::<f64>().is_ok() => format!("{} is one number too many", quote(text)),
            None => format!("{} is not a statement", quote(text)),
        };
        Err(self.unknown(self.spot(word), problem))
    }

    /// The error where no statement can begin.
    fn unknown(&self, spot: Spot, problem: String) -> Error {
        Error::scene(
            spot.of(self.lines.file()),
            problem,
            format!("begin the line with one of {}", NFF_DIRECTIVES.join(" ")),
        )
    }

    fn take(&mut self, word: WordRange) {
        self.next = word.end;
    }

    fn text(&self, word: WordRange) -> &str {
        &self.lines.text()[word.start..word.end]
    }

    fn spot(&self, word: WordRange) -> Spot {
        self.lines.spot(word.start)
    }

    fn begins_line(&self, word: WordRange) -> bool {
        self.lines.text()[..word.start].trim_start().is_empty()
    }

    /// Reads at least `least` numbers and as many more as follow, up to `most`.
    fn numbers(&mut self, at: &Statement, least: usize, most: usize) -> Result<Numbers> {
        let mut numbers = Numbers::default();
        while numbers.count < most {
            let Some(word) = self.peek()? else {
                if numbers.count >= least {
                    break;
                }
                return Err(self.short(at, "the file ends", numbers.count, least));
            };
            let text = self.text(word);
            let Ok(value) = text.parse::<f64>() else {
                if numbers.count >= least {
                    break;
                }
                let known = NFF_DIRECTIVES.contains(&text) || VIEW.contains(&text);
                if known && self.begins_line(word) {
                    return Err(self.short(at, "the statement ends", numbers.count, least));
                }
                let place = self.spot(word).of(self.lines.file()).named(at.to_string());
                return Err(Error::scene(
                    place,
                    format!("{} is not a number", quote(text)),
                    mend_number(text, &number_mend(least)),
                ));
            };
            if !value.is_finite() {
                let place = self.spot(word).of(self.lines.file()).named(at.to_string());
                return Err(Error::scene(place, format!("{} is not finite", quote(text)), number_mend(least)));
            }
            numbers.spots[numbers.count] = self.spot(word);
            numbers.values[numbers.count] = value;
            numbers.count += 1;
            self.take(word);
        }
        Ok(numbers)
    }

    fn short(&self, at: &Statement, what: &str, found: usize, least: usize) -> Error {
        Error::scene(self.place(at), format!("{what} after {found} of {least} numbers"), number_mend(least))
    }

    fn place(&self, at: &Statement) -> Place {
        at.spot.of(self.lines.file()).named(at.to_string())
    }

    /// A whole number: a count of pixels or vertices.
    fn whole(&mut self, at: &Statement) -> Result<(u64, Spot)> {
        let numbers = self.numbers(at, 1, 1)?;
        let (value, spot) = (numbers.values[0], numbers.spots[0]);
        if value >= 0.0 && value.fract() == 0.0 {
            return Ok((value as u64, spot));
        }
        let place = spot.of(self.lines.file()).named(at.to_string());
        Err(Error::scene(place, format!("expected a whole number, found {value}"), "use a whole number"))
    }

    fn vector(&mut self, at: &Statement) -> Result<DVec3> {
        let numbers = self.numbers(at, 3, 3)?;
        Ok(DVec3::from_slice(&numbers.values[..3]))
    }

    /// r g b, and the statement's optional numbers after it.
    fn color(&mut self, at: &Statement, most: usize) -> Result<[f32; 3]> {
        let numbers = self.numbers(at, 3, most)?;
        self.check_color(at, &numbers, 0)
    }

    /// r g b [Kd Ks Shine T ior]: the colour, the material, and whether all its numbers are in range.
    fn fill(&mut self, at: &Statement) -> Result<([f32; 3], Material, bool)> {
        let numbers = self.numbers(at, 3, 8)?;
        let mut in_range = true;
        let mut part = |n: usize, default: f64, low: f64, high: f64| {
            let value = if numbers.count > n { numbers.values[n] } else { default };
            in_range &= (low..=high).contains(&value);
            value.clamp(low, high)
        };
        let [diffuse, specular] = [(3, 1.0), (4, 0.0)].map(|(n, default)| part(n, default, 0.0, 1.0) as f32);
        let shine = part(5, 0.0, 0.0, f64::from(f32::MAX)) as f32;
        let transmission = part(6, 0.0, 0.0, 1.0) as f32;
        // Files of opaque spheres have any number here, often 0.
        let index = if transmission > 0.0 { part(7, 1.0, 0.1, 10.0) } else { 1.0 };
        let material = Material::Phong { diffuse, specular, shine, transmission, index };
        Ok((self.check_color(at, &numbers, 0)?, material, in_range))
    }

    fn check_color(&self, at: &Statement, numbers: &Numbers, first: usize) -> Result<[f32; 3]> {
        let color = std::array::from_fn(|k| numbers.values[first + k] as f32);
        check_color(color, || numbers.spots[first].of(self.lines.file()).named(at.to_string()))?;
        Ok(color)
    }

    /// x y z [r g b]: a point, and its colour if it has one.
    fn light(&mut self, at: &Statement) -> Result<(DVec3, Option<[f32; 3]>)> {
        let numbers = self.numbers(at, 3, 6)?;
        let color = match numbers.count {
            3 => None,
            6 => Some(self.check_color(at, &numbers, 3)?),
            n => {
                let problem = format!("a light has {n} numbers");
                return Err(Error::scene(self.place(at), problem, "use x y z, or x y z r g b"));
            }
        };
        Ok((DVec3::from_slice(&numbers.values[..3]), color))
    }

    fn sphere(&mut self, at: &Statement) -> Result<([f64; 3], f64)> {
        let Numbers { values: [x, y, z, radius, ..], spots, .. } = self.numbers(at, 4, 4)?;
        check_sphere([x, y, z], radius, || Place::field(at.to_string())).map_err(|e| {
            let spot = |field: &str| if field.ends_with("radius") { spots[3] } else { spots[0] };
            relocate(e, |field| spot(field).of(self.lines.file()).named(field))
        })?;
        Ok(([x, y, z], radius))
    }

    /// Skips an object that is not a sphere and returns its kind.
    fn other(
        &mut self,
        directive: &str,
        at: &impl Fn(&'static str, Option<usize>) -> Statement,
    ) -> Result<&'static str> {
        let (kind, per_vertex) = match directive {
            "c" => {
                self.numbers(&at("cone", None), 8, 8)?;
                return Ok("cone");
            }
            "p" => ("polygon", 3),
            _ => ("polygonal patch", 6),
        };
        let at = at(kind, None);
        let (vertices, spot) = self.whole(&at)?;
        if vertices < 3 {
            let place = spot.of(self.lines.file()).named(kind);
            return Err(Error::scene(place, format!("a polygon has {vertices} vertices"), "use at least 3"));
        }
        for _ in 0..vertices {
            self.numbers(&at, per_vertex, per_vertex)?;
        }
        Ok(kind)
    }

    /// The lines of a v block, in any order; all but hither are required.
    fn view(&mut self, at: &Statement) -> Result<(Camera, ImagePlane)> {
        let (mut found, mut spots) = ([None; VIEW.len()], [at.spot; VIEW.len()]);
        while let Some(word) = self.peek()? {
            let key = VIEW.iter().position(|key| *key == self.text(word));
            let Some(key) = key.filter(|_| self.begins_line(word)) else { break };
            if found[key].is_some() {
                let place = self.spot(word).of(self.lines.file()).named(NAMES[key]);
                return Err(Error::scene(place, "occurs twice in one v block", "remove one of them"));
            }
            spots[key] = self.spot(word);
            self.take(word);
            let line = Statement { spot: spots[key], name: NAMES[key], id: None };
            found[key] = Some(match key {
                0..=2 => self.vector(&line)?,
                3 | 4 => DVec3::splat(self.numbers(&line, 1, 1)?.values[0]),
                _ => DVec3::new(self.whole(&line)?.0 as f64, self.whole(&line)?.0 as f64, 0.0),
            });
        }
        let need = |key: usize| {
            found[key].ok_or_else(|| {
                let place = at.spot.of(self.lines.file()).named(NAMES[key]);
                let mend = format!("add a line that begins with {}", VIEW[key]);
                Error::scene(place, "missing from the v block", mend)
            })
        };
        let (eye, look, up, degrees, size) = (need(0)?, Look::At(need(1)?), need(2)?, need(3)?.x, need(5)?);
        let place = |key: usize| spots[key].of(self.lines.file()).named(NAMES[key]);
        // The casts saturate.
        let (width, height) = check_size([size.x as i64, size.y as i64], || place(5))?;
        let camera = Camera { eye, look, up, lens: Lens::RowCentres { degrees } };
        let locate = |error| {
            relocate(error, |field| match field {
                "camera.eye" => place(0),
                "camera.at" => place(1),
                "camera.up" => place(2),
                _ => place(3),
            })
        };
        camera.basis().map_err(locate)?;
        camera.viewport(width, height).map_err(locate)?;
        Ok((camera, ImagePlane { width, height, ..ImagePlane::default() }))
    }
}

/// The names of [`VIEW`] in errors.
const NAMES: [&str; 6] =
    ["camera.from", "camera.at", "camera.up", "camera.angle", "camera.hither", "camera.resolution"];

fn number_mend(least: usize) -> String {
    match least {
        1 => "give a number".into(),
        n => format!("use {n} numbers"),
    }
}
