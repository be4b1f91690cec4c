//! Tables and values of a TOML document, whose errors have the line, column and key.

use crate::read::style::color;
use halfline::error::{Error, Place, Result};
use halfline::scene::{check_color, check_opacity};
use halfline_particles::nearest::did_you_mean;
use std::fmt::Display;
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

/// The text of a document, and its file for errors.
pub(super) struct TomlText<'a> {
    pub(super) file: Place,
    pub(super) text: &'a str,
}

impl TomlText<'_> {
    /// The file, line and column of offset `byte` of the text, for errors.
    pub(super) fn place(&self, byte: usize) -> Place {
        self.file.clone().at_byte(self.text, byte)
    }
}

/// The name of a table in errors: `camera`, `sphere 3`, or nothing for the top level.
#[derive(Clone, Copy)]
pub(super) struct TomlName {
    part: &'static str,
    index: Option<usize>,
}

impl TomlName {
    const TOP: Self = Self::part("");

    pub(super) const fn part(part: &'static str) -> Self {
        Self { part, index: None }
    }

    fn field(self, key: &str) -> String {
        match self {
            Self { part: "", .. } => key.to_owned(),
            Self { part, index: Some(index) } => format!("{part} {index} {key}"),
            Self { part, index: None } => format!("{part}.{key}"),
        }
    }

    /// An example of a key of this table with its value, or of the table that a key names, for remedies in messages.
    fn example(self, key: &str) -> &'static str {
        match (self.part, key) {
            ("light", "sphere") => "sphere = 0",
            ("light", "color") => "color = [1.0, 1.0, 1.0]",
            ("light", "direction") => "direction = [-1.0, 2.0, 1.0]",
            ("light", "position") => "position = [-1.0, 2.0, 1.0]",
            (_, "camera") => "a [camera] table",
            (_, "image") => "an [image] table",
            (_, "sphere") => "[[sphere]] tables",
            (_, "spheres") => "[[spheres]] tables",
            (_, "eye") => "eye = [0.0, 0.0, 5.0]",
            (_, "at") => "at = [0.0, 0.0, 0.0]",
            (_, "view") => "view = [0.0, 0.0, -1.0]",
            (_, "up") => "up = [0.0, 1.0, 0.0]",
            (_, "vfov") => "vfov = 40.0",
            (_, "viewport") => "viewport = [1.0, 1.0]",
            (_, "distance") => "distance = 1.0",
            (_, "height") => "height = 12.0",
            (_, "lens") => "lens = \"fisheye\"",
            (_, "fx") => "fx = 525.0",
            (_, "fy") => "fy = 525.0",
            (_, "cx") => "cx = 320.0",
            (_, "cy") => "cy = 240.0",
            (_, "coefficients") => "coefficients = [-0.28, 0.07, 0.0, 0.0]",
            (_, "aperture") => "aperture = 0.1",
            (_, "focus") => "focus = 10.0",
            (_, "size") => "size = [512, 512]",
            (_, "center") => "center = [0.0, 0.0, 0.0]",
            (_, "radius") => "radius = 1.0",
            (_, "file") => "file = \"spheres.csv\"",
            (_, "select") => "select = \"chain A\"",
            (_, "background") => "background = [0.0, 0.0, 0.0]",
            (_, "light") => "[[light]] tables",
            (_, "cut") => "[[cut]] tables",
            (_, "normal") => "normal = [0.0, 0.0, 1.0]",
            (_, "occlusion") => "an [occlusion] table",
            (_, "sky") => "a [sky] table",
            (_, "zenith") => "zenith = [0.3, 0.5, 0.9]",
            (_, "horizon") => "horizon = [0.9, 0.95, 1.0]",
            (_, "samples") => "samples = 4",
            (_, "look") => "look = \"soft\"",
            (_, "intensity") => "intensity = 1.0",
            (_, "rays") => "rays = 16",
            (_, "reach") => "reach = 5.0",
            (_, "material") => "material = \"metal\"",
            (_, "diffuse") => "diffuse = 1.0",
            (_, "specular") => "specular = 0.5",
            (_, "gloss") => "gloss = 0.8",
            (_, "shine") => "shine = 30.0",
            (_, "transmission") => "transmission = 0.5",
            (_, "index") => "index = 1.5",
            (_, "fuzz") => "fuzz = 0.1",
            (_, "opacity") => "opacity = 0.3",
            _ => "color = [0.8, 0.8, 0.8]",
        }
    }
}

/// A table, and its position.
pub(super) struct TomlTable<'a> {
    doc: &'a TomlText<'a>,
    name: TomlName,
    keys: &'a DeTable<'a>,
    start: usize,
}

impl<'a> TomlTable<'a> {
    /// The top level of the document.
    pub(super) fn top(doc: &'a TomlText<'a>, keys: &'a DeTable<'a>) -> Self {
        Self { doc, name: TomlName::TOP, keys, start: 0 }
    }

    /// Returns an error at the first key that is not one of `known`.
    pub(super) fn allow(&self, known: &[&str]) -> Result<()> {
        let unknown = self.keys.keys().filter(|key| !known.contains(&key.get_ref().as_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else { return Ok(()) };
        let place = self.doc.place(key.span().start).named(self.name.field(key.get_ref()));
        let mend = format!("the keys of this table are {}", known.join(", "));
        Err(Error::scene(place, "unknown key", did_you_mean(key.get_ref(), known.iter().copied(), mend)))
    }

    pub(super) fn get(&self, key: &'static str) -> Option<TomlValue<'a>> {
        self.keys.get(key).map(|value| TomlValue { doc: self.doc, name: self.name, key, value })
    }

    pub(super) fn need(&self, key: &'static str) -> Result<TomlValue<'a>> {
        self.get(key).ok_or_else(|| self.missing(key, format!("add {}", self.name.example(key))))
    }

    /// The opacity of `owner`, which errors name; 1 without the key.
    pub(super) fn opacity(&self, owner: impl Display) -> Result<f32> {
        let Some(value) = self.get("opacity") else { return Ok(1.0) };
        let opacity = value.number()? as f32;
        check_opacity(opacity, || value.place().named(format!("{owner} opacity")))?;
        Ok(opacity)
    }

    /// The place of a key's value; without the key, the place of the key `other` or of the table.
    pub(super) fn place_of(&self, key: &str, other: &str) -> Place {
        let value = self.keys.get(key).or_else(|| self.keys.get(other));
        self.doc.place(value.map_or(self.start, |value| value.span().start))
    }

    fn missing(&self, key: &str, mend: String) -> Error {
        Error::scene(self.doc.place(self.start).named(self.name.field(key)), "missing", mend)
    }

    /// The only key of `keys` that is present; it is an error if there is none or more than one.
    pub(super) fn one_of<const N: usize>(&self, keys: [&'static str; N]) -> Result<&'static str> {
        let mut there: Vec<_> = keys.into_iter().filter_map(|key| self.get(key)).collect();
        there.sort_by_key(|value| value.value.span().start);
        match there[..] {
            [only] => Ok(only.key),
            [first, second, ..] => {
                let [a, b] = [first.key, second.key];
                Err(Error::scene(second.place(), format!("{a} and {b} exclude each other"), format!("use {a} or {b}")))
            }
            [] => Err(self.missing(keys[0], format!("add {}", keys.map(|key| self.name.example(key)).join(" or ")))),
        }
    }

    /// The tables of an array of tables; none if the key is missing.
    pub(super) fn tables(&self, key: &'static str) -> Result<impl Iterator<Item = Result<TomlTable<'a>>>> {
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
pub(super) struct TomlValue<'a> {
    doc: &'a TomlText<'a>,
    name: TomlName,
    key: &'static str,
    value: &'a Spanned<DeValue<'a>>,
}

impl<'a> TomlValue<'a> {
    pub(super) fn place(&self) -> Place {
        self.doc.place(self.value.span().start).named(self.name.field(self.key))
    }

    /// An error at this value, or at `part` of it.
    fn wrong(&self, part: &Spanned<DeValue<'_>>, problem: String) -> Error {
        let place = self.doc.place(part.span().start).named(self.name.field(self.key));
        Error::scene(place, problem, format!("write {}", self.name.example(self.key)))
    }

    fn mistyped(&self, part: &Spanned<DeValue<'_>>, expected: &str) -> Error {
        self.wrong(part, format!("expected {expected}, found a value of type {}", part.get_ref().type_str()))
    }

    pub(super) fn table(&self, name: TomlName) -> Result<TomlTable<'a>> {
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

    pub(super) fn string(&self) -> Result<&'a str> {
        self.value.get_ref().as_str().ok_or_else(|| self.mistyped(self.value, "a string"))
    }

    pub(super) fn number(&self) -> Result<f64> {
        self.finite(self.value)
    }

    pub(super) fn numbers<const N: usize>(&self) -> Result<[f64; N]> {
        self.items(Self::finite)
    }

    /// Finite numbers, of any count.
    pub(super) fn list(&self) -> Result<Vec<f64>> {
        self.array()?.iter().map(|item| self.finite(item)).collect()
    }

    pub(super) fn whole_numbers<const N: usize>(&self) -> Result<[i64; N]> {
        self.items(Self::whole)
    }

    /// A whole number; those beyond i64 are errors.
    pub(super) fn whole_number(&self) -> Result<i64> {
        self.whole(self.value)
    }

    fn whole(&self, part: &Spanned<DeValue<'_>>) -> Result<i64> {
        match part.get_ref() {
            DeValue::Integer(i) => {
                i64::from_str_radix(i.as_str(), i.radix()).map_err(|_| self.wrong(part, format!("{i} is out of range")))
            }
            _ => Err(self.mistyped(part, "a whole number")),
        }
    }

    /// Three numbers of linear RGB, or the text of a colour.
    pub(super) fn color(&self) -> Result<[f32; 3]> {
        if let Some(text) = self.value.get_ref().as_str() {
            return color(text).map_err(|error| match error {
                Error::Settings { problem, mend } => Error::scene(self.place(), problem, mend),
                other => other,
            });
        }
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

/// The nearest f64 of a decimal integer of any length, or of a hexadecimal, octal or binary one within i128.
fn integer(i: &DeInteger<'_>) -> Option<f64> {
    match i.radix() {
        10 => i.as_str().parse().ok(),
        radix => i128::from_str_radix(i.as_str(), radix).ok().map(|i| i as f64),
    }
}
