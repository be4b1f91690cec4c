//! Perceptual colour maps from numbers between 0 and 1 to colours. The maps come from the crate colorous
//! (matplotlib's and ColorBrewer's by d3-scale-chromatic), from tables of others, and from the caller.

mod tables;

use halfline_ground::error::{Error, Result};
use halfline_ground::srgb::linear;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// A colour map.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ColorMap {
    /// Dark violet to yellow, with uniform lightness steps.
    #[default]
    Viridis,
    /// Black over violet and orange to pale yellow.
    Inferno,
    /// Black over violet to pale pink.
    Magma,
    /// Blue over violet to yellow.
    Plasma,
    /// Blue to yellow, for all kinds of colour vision.
    Cividis,
    /// Black over blue and green to white, with uniform lightness steps.
    Cubehelix,
    /// A rainbow with more uniform lightness than jet.
    Turbo,
    /// Red over pale yellow to blue, for values with a midpoint.
    RedYellowBlue,
    /// Blue over white to red, for values with a midpoint.
    BlueWhiteRed,
    /// Blue over light grey to red, for values with a midpoint: the map of ParaView and matplotlib.
    CoolWarm,
    /// Dark blue over green to pink, with uniform lightness steps, for all kinds of colour vision.
    Batlow,
    /// Brown over pale green to blue, for values with a midpoint.
    Roma,
    /// Blue over white to brown, for values with a midpoint.
    Vik,
    /// Dark blue, light blue, yellow and orange: the classes of confidence of the AlphaFold Protein Structure Database.
    Plddt,
    /// Black to white.
    Grays,
    /// Ten base colours, then ten darker and ten lighter ones, by the integer part of the number; for categories.
    Category,
    /// The caller's colours, or another map reversed.
    Own(OwnMap),
}

/// Colours at equal steps from 0 to 1, 8-bit sRGB, two at least.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct OwnMap {
    name: String,
    colors: Vec<[u8; 3]>,
}

/// The maps with a name.
const NAMED: [(&str, ColorMap); 16] = {
    use ColorMap::*;
    [
        ("viridis", Viridis),
        ("inferno", Inferno),
        ("magma", Magma),
        ("plasma", Plasma),
        ("cividis", Cividis),
        ("cubehelix", Cubehelix),
        ("turbo", Turbo),
        ("rdylbu", RedYellowBlue),
        ("bwr", BlueWhiteRed),
        ("coolwarm", CoolWarm),
        ("batlow", Batlow),
        ("roma", Roma),
        ("vik", Vik),
        ("plddt", Plddt),
        ("grays", Grays),
        ("category", Category),
    ]
};

/// The colour at `x` in [0, 1] of colours at equal steps, by linear interpolation in sRGB.
fn between(colors: &[[u8; 3]], x: f64) -> [u8; 3] {
    let last = colors.len().saturating_sub(1);
    let place = if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) * last as f64 };
    let (n, part) = ((place as usize).min(last), place.fract());
    let (from, to) = (colors[n], colors[(n + 1).min(last)]);
    [0, 1, 2].map(|k| (f64::from(from[k]) * (1.0 - part) + f64::from(to[k]) * part).round() as u8)
}

impl ColorMap {
    /// The number of different category colours.
    pub const CATEGORIES: u64 = 30;

    /// The names of all maps that have one.
    #[must_use]
    pub fn names() -> [&'static str; NAMED.len()] {
        NAMED.map(|(name, _)| name)
    }

    /// The name; of own colours the name given to [`ColorMap::of_colors`].
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Own(own) => &own.name,
            _ => NAMED.iter().find(|(_, map)| map == self).map_or("", |(name, _)| name),
        }
    }

    /// A map of these colours at equal steps from 0 to 1, 8-bit sRGB.
    ///
    /// # Errors
    /// [`Error::Settings`] for fewer than two colours.
    pub fn of_colors(name: &str, colors: Vec<[u8; 3]>) -> Result<Self> {
        if colors.len() < 2 {
            let problem =
                format!("the colour map {name} has {}", halfline_ground::quote::count(colors.len() as u64, "colour"));
            return Err(Error::settings(problem, "give two or more"));
        }
        Ok(Self::Own(OwnMap { name: name.to_owned(), colors }))
    }

    /// The map from its last colour to its first.
    ///
    /// # Errors
    /// [`Error::Settings`] for [`ColorMap::Category`] and [`ColorMap::Plddt`], which have no direction.
    pub fn reversed(&self) -> Result<Self> {
        /// Steps between which 8-bit colours of no map differ by more than rounding.
        const STEPS: u32 = 255;
        let colors = match self {
            Self::Category | Self::Plddt => {
                let problem = format!("the colour map {} has no direction to reverse", self.name());
                return Err(Error::settings(problem, "remove _r"));
            }
            Self::Own(own) => own.colors.iter().rev().copied().collect(),
            _ => (0..=STEPS).rev().map(|n| self.srgb(f64::from(n) / f64::from(STEPS))).collect(),
        };
        Self::of_colors(&format!("{}_r", self.name()), colors)
    }

    /// 8-bit sRGB of `x` in [0, 1]; of a category, by its integer part.
    #[must_use]
    pub fn srgb(&self, x: f64) -> [u8; 3] {
        use colorous::{
            CIVIDIS, CUBEHELIX, GREYS, INFERNO, MAGMA, PLASMA, RED_BLUE, RED_YELLOW_BLUE, TABLEAU10, TURBO, VIRIDIS,
        };
        let gradient = match self {
            Self::Viridis => VIRIDIS,
            Self::Inferno => INFERNO,
            Self::Magma => MAGMA,
            Self::Plasma => PLASMA,
            Self::Cividis => CIVIDIS,
            Self::Cubehelix => CUBEHELIX,
            Self::Turbo => TURBO,
            Self::RedYellowBlue => RED_YELLOW_BLUE,
            Self::BlueWhiteRed => RED_BLUE,
            Self::CoolWarm => return between(&tables::COOLWARM, x),
            Self::Batlow => return between(&tables::BATLOW, x),
            Self::Roma => return between(&tables::ROMA, x),
            Self::Vik => return between(&tables::VIK, x),
            Self::Plddt => return between(&tables::PLDDT, x),
            Self::Grays => GREYS,
            Self::Own(own) => return between(&own.colors, x),
            Self::Category => {
                let last = Self::CATEGORIES - 1;
                let place = (x.rem_euclid(Self::CATEGORIES as f64) as u64).min(last) as usize;
                let plain = TABLEAU10[place % TABLEAU10.len()].as_array();
                // Towards black, then towards white; half the way keeps each near its base colour and distinct from the
                // others.
                return match place / TABLEAU10.len() {
                    0 => plain,
                    1 => plain.map(|level| level / 2),
                    _ => plain.map(|level| level / 2 + 128),
                };
            }
        };
        // Some scales of d3 have the opposite direction.
        let x = if matches!(self, Self::Grays | Self::BlueWhiteRed) { 1.0 - x } else { x };
        gradient.eval_continuous(x.clamp(0.0, 1.0)).as_array()
    }

    /// The same in linear RGB.
    #[must_use]
    pub fn color(&self, x: f64) -> [f32; 3] {
        linear(self.srgb(x))
    }
}

/// Maps of other programs that go through all hues (D. Borland and R. M. Taylor, Rainbow Color Map (Still) Considered
/// Harmful, IEEE Computer Graphics and Applications 27(2), 2007).
const UNEVEN: [&str; 4] = ["jet", "rainbow", "hsv", "gist_rainbow"];

impl FromStr for ColorMap {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self> {
        if let Some(known) = UNEVEN.iter().find(|known| known.eq_ignore_ascii_case(name)) {
            let problem = format!(
                "{known} is not among the colour maps: its lightness goes up and down, which shows edges where the numbers have \
                 none, and not all people can tell its colours apart"
            );
            let mend = format!(
                "use turbo, which has the same colours with smoother lightness, or viridis, whose lightness is even; the maps are {}",
                Self::names().join(", ")
            );
            return Err(Error::settings(problem, mend));
        }
        let known = |name: &str| NAMED.iter().find(|(known, _)| *known == name).map(|(_, map)| map.clone());
        if let Some(reversed) = name.strip_suffix("_r").and_then(known) {
            return reversed.reversed();
        }
        known(name).ok_or_else(|| {
            let mend = format!("choose from {}, each also reversed, such as viridis_r", Self::names().join(", "));
            Error::settings(format!("there is no colour map '{name}'"), mend)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uneven_maps_are_refused_with_an_even_one() {
        for name in ["jet", "rainbow", "Jet"] {
            let error = name.parse::<ColorMap>().expect_err(name).to_string();
            let known = name.to_lowercase();
            for expected in [&known, "lightness", "edges", "turbo", "viridis"] {
                assert!(error.contains(expected), "{expected}: {error}");
            }
        }
    }

    #[test]
    fn tables_have_the_colours_of_their_authors() {
        // matplotlib 3.10 and cmcrameri 1.10, at 0, 1/4, 1/2, 3/4 and 1 of 255 steps.
        let expected: [(&str, [[u8; 3]; 3]); 3] = [
            ("coolwarm", [[59, 76, 192], [221, 220, 219], [180, 4, 38]]),
            ("batlow", [[1, 25, 89], [130, 130, 49], [250, 204, 250]]),
            ("vik", [[0, 18, 97], [236, 229, 224], [89, 0, 8]]),
        ];
        for (name, colors) in expected {
            let map: ColorMap = name.parse().expect(name);
            for (n, color) in [0.0, 128.0, 255.0].into_iter().zip(colors) {
                let found = map.srgb(n / 255.0);
                let differs = found.iter().zip(color).any(|(a, b)| a.abs_diff(b) > 1);
                assert!(!differs, "{name} at {n}: {found:?}, {color:?}");
            }
        }
    }

    #[test]
    fn every_map_can_be_reversed_but_categories() {
        for name in ColorMap::names().into_iter().filter(|name| !["category", "plddt"].contains(name)) {
            let (map, reversed) = (name.parse::<ColorMap>().expect(name), format!("{name}_r").parse::<ColorMap>());
            let reversed = reversed.expect(name);
            assert_eq!(reversed.name(), format!("{name}_r"));
            for n in 0..=1000 {
                let x = f64::from(n) / 1000.0;
                let (a, b) = (map.srgb(1.0 - x), reversed.srgb(x));
                // A table of 256 steps, interpolated.
                assert!(a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 2), "{name} at {x}: {a:?} {b:?}");
            }
        }
        for name in ["category_r", "plddt_r"] {
            let error = name.parse::<ColorMap>().expect_err("no direction").to_string();
            assert!(error.contains("has no direction"), "{error}");
        }
        let error = "viridi_r".parse::<ColorMap>().expect_err("no such map").to_string();
        assert!(error.contains("there is no colour map 'viridi_r'") && error.contains("viridis_r"), "{error}");
        ColorMap::of_colors("one", vec![[0; 3]]).expect_err("one colour");
        let two = ColorMap::of_colors("two", vec![[0, 0, 0], [255, 0, 100]]).expect("a map");
        assert_eq!([0.0, 0.5, 1.0, f64::NAN].map(|x| two.srgb(x)), [[0, 0, 0], [128, 0, 50], [255, 0, 100], [0, 0, 0]]);
    }

    #[test]
    fn maps_run_from_dark_to_bright() {
        let light =
            |map: &ColorMap, x: f64| map.color(x).iter().zip([0.2126, 0.7152, 0.0722]).map(|(c, w)| c * w).sum::<f32>();
        use ColorMap::{Batlow, Cividis, Cubehelix, Grays, Inferno, Magma, Plasma, Viridis};
        for map in [Viridis, Inferno, Magma, Plasma, Cividis, Cubehelix, Batlow, Grays] {
            let steps: Vec<f32> = (0..=16).map(|n| light(&map, f64::from(n) / 16.0)).collect();
            assert!(steps.is_sorted(), "{} {steps:?}", map.name());
        }
        assert_eq!(Viridis.srgb(0.0), [68, 1, 84], "matplotlib's first");
        let mut categories: Vec<[u8; 3]> = (0..30).map(|n| ColorMap::Category.srgb(f64::from(n))).collect();
        assert_eq!(ColorMap::Category.srgb(30.0), categories[0]);
        categories.sort_unstable();
        categories.dedup();
        assert_eq!(categories.len() as u64, ColorMap::CATEGORIES, "each is of its own colour");
        assert!(ColorMap::BlueWhiteRed.srgb(0.0)[2] > ColorMap::BlueWhiteRed.srgb(0.0)[0], "blue first");
        assert_eq!(Viridis.srgb(f64::NAN.clamp(0.0, 1.0)).len(), 3);
    }
}
