//! What a buffer can be written as, and what the formats leave to choose.

use super::Aov;
use super::sheet::{Form, Kind};
use crate::error::{Error, Result};
use std::path::Path;
use std::str::FromStr;

/// The formats of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// A picture: colour in sRGB, matte or normals, or whole steps of depth.
    Png,
    /// All buffers as layers of one file, 32 bits a sample.
    Exr,
    /// One buffer, as it is.
    Npy,
    /// All buffers in one file, as they are.
    Npz,
    /// One buffer in f32, bottom row first.
    Pfm,
    /// One buffer's little-endian numbers and nothing else.
    Raw,
}

impl Format {
    /// Every format.
    pub const ALL: [Self; 6] = [Self::Png, Self::Exr, Self::Npy, Self::Npz, Self::Pfm, Self::Raw];

    /// The ending that chooses it.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Png => ".png",
            Self::Exr => ".exr",
            Self::Npy => ".npy",
            Self::Npz => ".npz",
            Self::Pfm => ".pfm",
            Self::Raw => ".raw",
        }
    }

    /// Whether a buffer can be written in it.
    pub fn takes(self, aov: Aov) -> bool {
        match self {
            Self::Png => {
                matches!(aov, Aov::Color | Aov::Distance | Aov::Depth | Aov::Normal | Aov::Mask | Aov::Alpha)
            }
            Self::Pfm => matches!(aov, Aov::Color | Aov::Distance | Aov::Depth | Aov::Normal | Aov::Position),
            Self::Exr | Self::Npy | Self::Npz | Self::Raw => true,
        }
    }

    /// How it stores these buffers, in the order of [`Aov::ALL`]; `None` where it does not. `bits` are those of PNG.
    pub fn forms(self, aovs: &[Aov], bits: Bits) -> Option<Vec<Form>> {
        let mut forms = Vec::new();
        for aov in aovs.iter().copied() {
            match forms.last_mut() {
                // Alpha goes into the pixels of colour.
                Some(Form { aov: Aov::Color, channels, .. }) if self == Self::Png && aov == Aov::Alpha => *channels = 4,
                _ => forms.push(Form { aov, kind: self.kind(aov, bits), channels: aov.channels() }),
            }
        }
        let ordered = aovs.is_sorted_by(|a, b| a < b) && aovs.iter().all(|aov| self.takes(*aov));
        (ordered && (forms.len() == 1 || self.holds_many() && !forms.is_empty())).then_some(forms)
    }

    /// The type of the samples of a buffer.
    fn kind(self, aov: Aov, bits: Bits) -> Kind {
        match (self, aov.dtype(), aov) {
            (Self::Png, _, Aov::Mask) => Kind::U8,
            (Self::Png, "float64", _) => Kind::U16,
            (Self::Png, ..) if bits == Bits::Sixteen => Kind::U16,
            (Self::Png, ..) => Kind::U8,
            (Self::Exr, _, Aov::Id | Aov::Certainty) => Kind::U32,
            (Self::Exr | Self::Pfm, ..) | (_, "float32", _) => Kind::F32,
            (_, "float64", _) => Kind::F64,
            (_, "int32", _) => Kind::I32,
            _ => Kind::U8,
        }
    }

    /// Whether one file holds any number of buffers.
    pub fn holds_many(self) -> bool {
        matches!(self, Self::Exr | Self::Npz)
    }

    /// Whether alpha goes beside colour into the same file.
    pub fn takes_alpha(self) -> bool {
        self == Self::Png || self.holds_many()
    }

    /// The format that `path` ends in, in capitals or not.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?;
        Self::ALL.into_iter().find(|format| format.ending()[1..].eq_ignore_ascii_case(ending))
    }

    /// The endings of the formats that fit, for people.
    pub(super) fn endings(fits: impl Fn(Self) -> bool) -> String {
        let all: Vec<_> = Self::ALL.into_iter().filter(|format| fits(*format)).map(Self::ending).collect();
        match &all[..] {
            [others @ .., last] if !others.is_empty() => format!("{} or {last}", others.join(", ")),
            _ => all.concat(),
        }
    }
}

/// The keyword of the bits of a component in a PNG.
pub(super) const BITS: &str = "halfline:bits";

/// Bits of a component in a PNG.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bits {
    /// 0 to 255.
    #[default]
    Eight,
    /// 0 to 65535.
    Sixteen,
}

impl FromStr for Bits {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text {
            "8" => Ok(Self::Eight),
            "16" => Ok(Self::Sixteen),
            _ => Err(Error::settings(format!("a PNG of {text} bits is not written"), "choose 8 or 16")),
        }
    }
}

/// What distance and depth are on a miss, outside of PNG, where it is 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NoReturn {
    /// +inf.
    #[default]
    Inf,
    /// NaN, which ROS takes.
    Nan,
    /// 0, which OpenCV takes.
    Zero,
}

impl NoReturn {
    const ALL: [Self; 3] = [Self::Inf, Self::Nan, Self::Zero];

    /// The name on the command line and in provenance.
    pub fn name(self) -> &'static str {
        match self {
            Self::Inf => "inf",
            Self::Nan => "nan",
            Self::Zero => "zero",
        }
    }

    /// The number.
    pub(super) fn value(self) -> f64 {
        match self {
            Self::Inf => f64::INFINITY,
            Self::Nan => f64::NAN,
            Self::Zero => 0.0,
        }
    }
}

impl FromStr for NoReturn {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        crate::error::by_name("value of a miss", name, &Self::ALL, Self::name)
    }
}

/// What the formats leave to choose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    /// Of colour, alpha and normals in PNG.
    pub bits: Bits,
    /// Scene units per step of distance and depth in PNG; positive and finite.
    pub unit: f64,
    /// Of distance and depth.
    pub no_return: NoReturn,
    /// Colour was rendered before black and comes with alpha.
    pub transparent: bool,
}

impl Default for Style {
    /// 8 bits, millimetres of metres, +inf on a miss, opaque.
    fn default() -> Self {
        Self { bits: Bits::Eight, unit: 0.001, no_return: NoReturn::Inf, transparent: false }
    }
}

impl Style {
    /// What of it a file with these buffers depends on.
    pub(super) fn words(&self, format: Format, aovs: &[Aov]) -> Vec<(&'static str, String)> {
        let any = |some: &[Aov]| some.iter().any(|aov| aovs.contains(aov));
        let (levels, lengths) = (any(&[Aov::Color, Aov::Alpha, Aov::Normal]), any(&[Aov::Distance, Aov::Depth]));
        let mut words = Vec::new();
        if format == Format::Png && levels {
            words.push((BITS, if self.bits == Bits::Eight { "8" } else { "16" }.to_owned()));
        }
        if lengths {
            words.push(match format {
                Format::Png => ("halfline:unit", format!("{:?}", self.unit)),
                _ => ("halfline:no-return", self.no_return.name().to_owned()),
            });
        }
        if self.transparent && any(&[Aov::Color]) {
            words.push(("halfline:transparent", "true".to_owned()));
        }
        words
    }
}
