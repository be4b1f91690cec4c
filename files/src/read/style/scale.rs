//! Scales of colours.

use halfline::frame::color_map::ColorMap;
use halfline::frame::legend::Legend;

/// The mapping of the numbers or names of a column to colours.
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

/// Linear RGB of each particle, and the legend.
pub(super) type Colored = (Vec<[f32; 3]>, Option<Legend>);
