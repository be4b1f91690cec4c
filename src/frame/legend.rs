//! The legend of a picture: quantity, colour map, range and categories.

use super::color_map::ColorMap;

/// The meaning of a picture's colours: the coloured quantity with its map and range, or categories.
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
    /// The colours of selected particles, labelled by their expressions. The categories are those of the other particles.
    pub overrides: Vec<Category>,
}

impl Legend {
    /// The number of ticks that [`Legend::ticks`] gives.
    pub const TICKS: i32 = 5;

    /// The legend of colours of selections only.
    #[must_use]
    pub fn of_selections(overrides: Vec<Category>) -> Self {
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

    /// The number at a fraction of the bar.
    fn at(&self, part: f64) -> f64 {
        let [low, high] = self.range;
        if self.log { (low.ln() + part * (high.ln() - low.ln())).exp() } else { low + part * (high - low) }
    }

    /// The numbers of the bar from its lower end to the upper one, to four digits. On a linear scale a number that is less
    /// than half of the fourth digit of the end that is farther from 0 is written as 0.
    #[must_use]
    pub fn ticks(&self) -> Vec<String> {
        let digits = |x: f64| if x == 0.0 || !x.is_finite() { 0 } else { x.abs().log10().floor() as i32 };
        let largest = self.range.iter().fold(0.0, |largest: f64, end| largest.max(end.abs()));
        let tick = |tick: i32| {
            let value = self.at(f64::from(tick) / f64::from(Self::TICKS - 1));
            let is_nothing = !self.log && value.abs() < 0.5 * 10f64.powi(digits(largest) - 3);
            short(if is_nothing { 0.0 } else { value })
        };
        (0..Self::TICKS).map(tick).collect()
    }

    /// Whether it is a scale of numbers that are all equal.
    #[must_use]
    pub fn is_flat(&self) -> bool {
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

/// A number to four digits.
fn short(value: f64) -> String {
    let decade = value.abs().log10().floor();
    if value == 0.0 || !(-3.0..5.0).contains(&decade) {
        return if value == 0.0 { "0".into() } else { format!("{value:.3e}") };
    }
    let text = format!("{value:.*}", (3.0 - decade).max(0.0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_have_four_digits() {
        assert_eq!([0.0, 123.456, -0.5, 6.02e23, 99999.0].map(short), ["0", "123.5", "-0.5", "6.020e23", "99999"]);
    }
}
