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
    /// Names of categories whose colours are fixed, in the order of their colours: a film keeps those of its first frame.
    /// Others follow in the file's order.
    pub names: Vec<String>,
}

impl Scale {
    /// The colours of these columns, with everything else as it is by default.
    #[must_use]
    pub fn of(columns: Vec<String>) -> Self {
        Self { columns, map: None, range: None, log: false, names: Vec::new() }
    }
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
    /// The names of the file in the order of their colours, whether they occur or not; empty for numbers.
    pub names: Vec<String>,
    /// The colours of selected particles ([`Style::paints`](super::Style::paints)), labelled by their expressions. The
    /// categories are those of the other particles.
    pub overrides: Vec<Category>,
}

impl Legend {
    /// The legend of colours of selections only.
    pub(super) fn of_selections(overrides: Vec<Category>) -> Self {
        let (map, range) = (ColorMap::Category, [0.0; 2]);
        Self { name: "selection".into(), map, range, log: false, categories: Vec::new(), names: Vec::new(), overrides }
    }

    /// Whether it shows numbers through a colour map; otherwise it shows categories only.
    #[must_use]
    pub fn is_scale(&self) -> bool {
        self.categories.is_empty() && self.map != ColorMap::Category
    }

    /// The swatches: the categories, then the colours of selections.
    pub fn swatches(&self) -> impl Iterator<Item = &Category> + Clone {
        self.categories.iter().chain(&self.overrides)
    }

    /// Whether it is a scale of numbers that are all equal.
    pub(in crate::read) fn is_flat(&self) -> bool {
        self.names.is_empty() && self.is_scale() && self.range[0] == self.range[1]
    }
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
