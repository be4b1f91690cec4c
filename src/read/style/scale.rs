//! Scales of colours, and their legends.

use super::colormap::ColorMap;

/// How numbers become colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// The column; with several, the length of the vector.
    pub columns: Vec<String>,
    /// The colour map. `None` takes [`ColorMap::Category`] for names (chain, asym, entity) and for numbers that
    /// identify (type, molecule, model, copy), else [`ColorMap::Viridis`].
    pub map: Option<ColorMap>,
    /// The values at the map's ends; `None` takes the minimum and the maximum.
    pub range: Option<[f64; 2]>,
    /// Whether the scale is logarithmic.
    pub log: bool,
}

/// The legend of a scale.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    /// The coloured quantity: `speed`, or `|vx, vy, vz|`.
    pub name: String,
    /// The colour map.
    pub map: ColorMap,
    /// The values at the map's ends; for categories the minimum and the maximum.
    pub range: [f64; 2],
    /// Whether the scale is logarithmic.
    pub log: bool,
    /// The categories that occur; empty for numbers.
    pub categories: Vec<Category>,
}

/// A category of particles.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Category {
    /// Its name or number, as in the file.
    pub label: String,
    /// Its colour, 8-bit sRGB.
    pub color: [u8; 3],
    /// The number of its particles.
    pub count: u64,
}

/// Linear RGB of each particle, and the legend.
pub(super) type Colored = (Vec<[f32; 3]>, Option<Legend>);
