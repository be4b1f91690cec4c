//! Perceptual colour maps from numbers between 0 and 1 to colours. The maps are those of the crate colorous
//! (matplotlib's and ColorBrewer's by d3-scale-chromatic).

use super::srgb::linear;
use crate::error::{Error, Result, named};
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// A colour map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
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
    /// Black to white.
    Grays,
    /// Ten base colours, then ten darker and ten lighter ones, by the integer part of the number; for categories.
    Category,
}

named! {
    ColorMap,
    Viridis "viridis" Inferno "inferno" Magma "magma" Plasma "plasma" Cividis "cividis" Cubehelix "cubehelix"
    Turbo "turbo" RedYellowBlue "rdylbu" BlueWhiteRed "bwr" Grays "grays" Category "category"
}

impl ColorMap {
    /// The number of different category colours.
    pub const CATEGORIES: u64 = 30;

    /// 8-bit sRGB of `x` in [0, 1]; of a category, by its integer part.
    #[must_use]
    pub fn srgb(self, x: f64) -> [u8; 3] {
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
            Self::Grays => GREYS,
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
    pub fn color(self, x: f64) -> [f32; 3] {
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
                Self::ALL.map(Self::name).join(", ")
            );
            return Err(Error::settings(problem, mend));
        }
        crate::error::by_name("colour map", name, &Self::ALL, Self::name)
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
    fn maps_run_from_dark_to_bright() {
        let light =
            |map: ColorMap, x: f64| map.color(x).iter().zip([0.2126, 0.7152, 0.0722]).map(|(c, w)| c * w).sum::<f32>();
        use ColorMap::{Cividis, Cubehelix, Grays, Inferno, Magma, Plasma, Viridis};
        for map in [Viridis, Inferno, Magma, Plasma, Cividis, Cubehelix, Grays] {
            let steps: Vec<f32> = (0..=16).map(|n| light(map, f64::from(n) / 16.0)).collect();
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
