//! File formats, the buffers that each can hold, and the options of the formats.

use super::layer::{LayerFormat, SampleType};
use halfline::error::{Error, Result, named};
use halfline::frame::Aov;
use halfline::frame::provenance::Provenance;
use halfline::quote::quote;
use std::path::Path;
use std::str::FromStr;

/// The formats of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FileFormat {
    /// A picture: colour in sRGB, alpha, normals or occlusion as levels, lengths in whole units, or ids from 1.
    Png,
    /// All buffers as layers of one file, 32 bits per sample.
    Exr,
    /// One buffer, unchanged.
    Npy,
    /// All buffers in one file, unchanged.
    Npz,
    /// One buffer in f32, bottom row first.
    Pfm,
    /// One buffer's little-endian numbers without a header.
    Raw,
    /// A picture for print: colour in sRGB, with alpha; not read back.
    Tiff,
    /// A picture of 8 bits per component with small losses; not read back.
    Jpeg,
    /// A picture of 8 bits per component for web pages, without losses, with alpha; not read back.
    WebP,
}

impl FileFormat {
    /// Every format.
    pub const ALL: [Self; 9] =
        [Self::Png, Self::Exr, Self::Npy, Self::Npz, Self::Pfm, Self::Raw, Self::Tiff, Self::Jpeg, Self::WebP];

    /// The file name extension of the format.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Png => ".png",
            Self::Exr => ".exr",
            Self::Npy => ".npy",
            Self::Npz => ".npz",
            Self::Pfm => ".pfm",
            Self::Raw => ".raw",
            Self::Tiff => ".tif",
            Self::Jpeg => ".jpg",
            Self::WebP => ".webp",
        }
    }

    /// The name, for messages.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Exr => "OpenEXR",
            Self::Npy => "NPY",
            Self::Npz => "NPZ",
            Self::Pfm => "PFM",
            Self::Raw => "raw",
            Self::Tiff => "TIFF",
            Self::Jpeg => "JPEG",
            Self::WebP => "WebP",
        }
    }

    /// Whether colour is stored as levels of sRGB, as it is seen, with the resolution for print.
    pub fn has_levels(self) -> bool {
        self == Self::Png || self.is_copy()
    }

    /// Whether the file is a copy of a picture for other programs: it is not compared, merged or resumed.
    pub fn is_copy(self) -> bool {
        matches!(self, Self::Tiff | Self::Jpeg | Self::WebP)
    }

    /// Whether halfline reads files of it again.
    pub fn is_read(self) -> bool {
        self != Self::Raw && !self.is_copy()
    }

    /// Whether legends, labels and marks are drawn into its colour.
    pub fn is_picture(self) -> bool {
        self == Self::Exr || self.has_levels()
    }

    /// Whether its levels may have 16 bits.
    pub fn takes_sixteen_bits(self) -> bool {
        matches!(self, Self::Png | Self::Tiff)
    }

    /// The greatest width and height, from the fields of its header.
    pub fn longest_side(self) -> u32 {
        match self {
            Self::Jpeg => u16::MAX.into(),
            // 14 bits, counted from 1.
            Self::WebP => 1 << 14,
            _ => u32::MAX,
        }
    }

    /// Whether it can hold a buffer.
    pub fn takes(self, aov: Aov) -> bool {
        match self {
            Self::Png => !matches!(aov, Aov::Position | Aov::Certainty | Aov::Bound | Aov::Shadow),
            Self::Pfm => {
                matches!(aov, Aov::Color | Aov::Distance | Aov::Depth | Aov::Normal | Aov::Position | Aov::Occlusion)
            }
            Self::Exr | Self::Npy | Self::Npz | Self::Raw => true,
            Self::Tiff | Self::WebP => matches!(aov, Aov::Color | Aov::Alpha),
            Self::Jpeg => aov == Aov::Color,
        }
    }

    /// Whether it can hold ids that are 64-bit integers, and says so.
    pub fn takes_wide_ids(self) -> bool {
        matches!(self, Self::Npy | Self::Npz)
    }

    /// The sample formats of these buffers, in the order of [`Aov::ALL`]; `None` where it cannot hold them. `bits` is
    /// for PNG, `lights` is the number of lights of a `shadow` buffer, `wide_ids` says that ids are 64-bit integers.
    pub fn forms(self, aovs: &[Aov], bits: Bits, lights: usize, wide_ids: bool) -> Option<Vec<LayerFormat>> {
        let mut forms = Vec::new();
        for aov in aovs.iter().copied() {
            match forms.last_mut() {
                // Alpha is the fourth channel of colour.
                Some(LayerFormat { aov: Aov::Color, channels, .. }) if self.has_levels() && aov == Aov::Alpha => {
                    *channels = 4
                }
                _ if wide_ids && aov == Aov::Id => {
                    let kind = Some(SampleType::I64).filter(|_| self.takes_wide_ids())?;
                    forms.push(LayerFormat { aov, kind, channels: 1 });
                }
                _ => forms.push(LayerFormat { aov, kind: self.kind(aov, bits), channels: aov.channels(lights) }),
            }
        }
        let ordered = aovs.is_sorted_by(|a, b| a < b) && aovs.iter().all(|aov| self.takes(*aov));
        let filled = forms.iter().all(|form| form.channels > 0);
        (ordered && filled && (forms.len() == 1 || self.holds_many() && !forms.is_empty())).then_some(forms)
    }

    /// The type of the samples of a buffer.
    fn kind(self, aov: Aov, bits: Bits) -> SampleType {
        match (self, aov.dtype(), aov) {
            (Self::Png, _, Aov::Mask) => SampleType::U8,
            (Self::Png, "float64", _) | (Self::Png, _, Aov::Id) => SampleType::U16,
            (Self::Png | Self::Tiff, ..) if bits == Bits::Sixteen => SampleType::U16,
            (Self::Png | Self::Tiff | Self::Jpeg | Self::WebP, ..) => SampleType::U8,
            (Self::Exr, _, Aov::Id | Aov::Certainty) => SampleType::U32,
            (Self::Exr | Self::Pfm, ..) | (_, "float32", _) => SampleType::F32,
            (_, "float64", _) => SampleType::F64,
            (_, "int32", _) => SampleType::I32,
            _ => SampleType::U8,
        }
    }

    /// Whether one file holds any number of buffers.
    pub fn holds_many(self) -> bool {
        matches!(self, Self::Exr | Self::Npz)
    }

    /// Whether alpha can be added to colour in the same file.
    pub fn takes_alpha(self) -> bool {
        self.takes(Aov::Alpha) && (self.has_levels() || self.holds_many())
    }

    /// The format of `path`'s extension, in upper or lower case.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        match &ending[..] {
            "tiff" => Some(Self::Tiff),
            "jpeg" => Some(Self::Jpeg),
            _ => Self::ALL.into_iter().find(|format| format.ending()[1..] == ending),
        }
    }

    /// The extensions of the formats that fit, for messages.
    pub(super) fn endings(fits: impl Fn(Self) -> bool) -> String {
        let all: Vec<_> = Self::ALL.into_iter().filter(|format| fits(*format)).map(Self::ending).collect();
        match &all[..] {
            [others @ .., last] if !others.is_empty() => format!("{} or {last}", others.join(", ")),
            _ => all.concat(),
        }
    }
}

/// The keyword of the bits per component in a PNG or TIFF.
const BITS: &str = "halfline:bits";

/// Bits per component in a PNG or TIFF.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bits {
    /// 0 to 255.
    #[default]
    Eight,
    /// 0 to 65535.
    Sixteen,
}

impl Bits {
    /// The bits per component in a PNG with this provenance.
    pub(super) fn of(provenance: &Provenance) -> Self {
        if provenance.get(BITS) == Some("16") { Self::Sixteen } else { Self::Eight }
    }
}

impl FromStr for Bits {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text {
            "8" => Ok(Self::Eight),
            "16" => Ok(Self::Sixteen),
            _ => Err(Error::settings(format!("a PNG cannot have {text} bits per component"), "use 8 or 16")),
        }
    }
}

/// The value of distance and depth on a miss; in PNG it is always 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NoReturn {
    /// +inf.
    #[default]
    Inf,
    /// NaN, as ROS expects.
    Nan,
    /// 0, as OpenCV expects.
    Zero,
}

named! { NoReturn, "value of a miss", Inf "inf" Nan "nan" Zero "zero" }

impl NoReturn {
    /// The number.
    pub(super) fn value(self) -> f64 {
        match self {
            Self::Inf => f64::INFINITY,
            Self::Nan => f64::NAN,
            Self::Zero => 0.0,
        }
    }
}

/// The keyword of the resolution of a picture.
const DPI: &str = "halfline:dpi";

/// The resolution of a picture for print: pixels per inch, between 1 and [`Dpi::MOST`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dpi(u32);

impl Dpi {
    /// The highest resolution; its pixels per metre are within the 31 bits of PNG.
    pub const MOST: u32 = 1_000_000;

    /// The resolution of a picture with this provenance.
    pub(super) fn of(provenance: &Provenance) -> Option<Self> {
        provenance.get(DPI)?.parse().ok()
    }

    /// The resolution of a size that is given in millimetres, without another: that which journals ask for.
    pub const OF_PRINT: Self = Self(300);

    /// Pixels per inch.
    pub fn per_inch(self) -> u32 {
        self.0
    }

    /// Pixels per metre, the nearest whole number: an inch is 0.0254 m.
    pub(super) fn per_metre(self) -> u32 {
        (f64::from(self.0) / 0.0254).round() as u32
    }
}

impl FromStr for Dpi {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let dpi = text.parse().ok().filter(|dpi| (1..=Self::MOST).contains(dpi));
        dpi.map(Self).ok_or_else(|| {
            let problem = format!("{} is not a resolution in pixels per inch", quote(text));
            Error::settings(problem, format!("use a whole number between 1 and {}, such as 300", Self::MOST))
        })
    }
}

/// The options of the formats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormatOptions {
    /// Bits of colour, alpha and normals in PNG, of colour and alpha in TIFF.
    pub bits: Bits,
    /// Scene units per level of distance and depth in PNG; positive and finite.
    pub unit: f64,
    /// The value of distance and depth on a miss.
    pub no_return: NoReturn,
    /// Whether colour was rendered on black and has alpha.
    pub transparent: bool,
    /// The resolution of a picture; without it the file has none.
    pub dpi: Option<Dpi>,
}

impl Default for FormatOptions {
    /// 8 bits, a unit of 0.001 (millimetres if the scene is in metres), +inf on a miss, opaque.
    fn default() -> Self {
        Self { bits: Bits::Eight, unit: 0.001, no_return: NoReturn::Inf, transparent: false, dpi: None }
    }
}

impl FormatOptions {
    /// The options that a file with these buffers depends on.
    pub(super) fn words(&self, format: FileFormat, aovs: &[Aov]) -> Vec<(&'static str, String)> {
        let any = |some: &[Aov]| some.iter().any(|aov| aovs.contains(aov));
        let (levels, lengths) =
            (any(&[Aov::Color, Aov::Alpha, Aov::Normal, Aov::Occlusion]), any(&[Aov::Distance, Aov::Depth]));
        let mut words = Vec::new();
        if format.takes_sixteen_bits() && levels {
            words.push((BITS, if self.bits == Bits::Eight { "8" } else { "16" }.to_owned()));
        }
        if lengths {
            words.push(match format {
                FileFormat::Png => ("halfline:unit", format!("{:?}", self.unit)),
                _ => ("halfline:no-return", self.no_return.name().to_owned()),
            });
        }
        if self.transparent && any(&[Aov::Color]) {
            words.push(("halfline:transparent", "true".to_owned()));
        }
        if let Some(Dpi(dpi)) = self.dpi.filter(|_| format.has_levels()) {
            words.push((DPI, dpi.to_string()));
        }
        words
    }
}
