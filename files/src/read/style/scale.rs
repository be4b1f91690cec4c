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
    /// The values at the map's ends, as far as they are known without the particles: those given, or those of the map.
    #[must_use]
    pub fn known_range(&self) -> Option<[f64; 2]> {
        self.range.or_else(|| (self.map == Some(ColorMap::Plddt)).then_some(PLDDT))
    }

    /// The colours of these columns, with everything else as it is by default.
    #[must_use]
    pub fn of(columns: Vec<String>) -> Self {
        Self { columns, map: None, range: None, log: false, names: Vec::new() }
    }
}

/// The least and the greatest pLDDT.
const PLDDT: [f64; 2] = [0.0, 100.0];

/// Linear RGB of each particle, and the legend.
pub(super) type Colored = (Vec<[f32; 3]>, Option<Legend>);
