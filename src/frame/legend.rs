//! The legend of a picture: quantity, colour map, range and categories.

use super::color_map::ColorMap;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::{COLOR, COLOR_BY, RANGE};
use serde::{Deserialize, Serialize};

/// The meaning of a picture's colours: the coloured quantity with its map and range, or categories.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Legend {
    /// The coloured quantity: `speed`, or `|vx, vy, vz|`.
    pub name: String,
    /// The words in place of the name, in the legend of a reader.
    #[serde(default)]
    pub title: Option<String>,
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
    /// The colours of selected particles, labelled by their expressions. The categories belong to the other particles.
    pub overrides: Vec<Category>,
}

impl Legend {
    /// The most marks of a bar.
    pub const MAX_TICKS: usize = 5;

    /// The legend of colours of selections only.
    #[must_use]
    pub fn of_selections(overrides: Vec<Category>) -> Self {
        let (map, range) = (ColorMap::Category, [0.0; 2]);
        let name = "selection".into();
        Self { name, title: None, map, range, log: false, categories: Vec::new(), names: Vec::new(), overrides }
    }

    /// A warning that the legend that an option asks for has nothing to show, in a scene without spheres, or one that is coloured by
    /// a column without numbers.
    ///
    /// # Errors
    /// [`Error::Settings`] for spheres whose colours have no meaning.
    pub fn lacking(option: &str, column: Option<&str>, is_empty: bool) -> Result<String> {
        let why = match column {
            _ if is_empty => "there are no spheres".to_owned(),
            Some(column) => {
                format!("no value of {column} is a number; {RANGE} LOW,HIGH gives a legend its ends")
            }
            None => {
                let problem =
                    format!("{option}: the spheres have neither elements nor a column that gives them their colours");
                let mend = format!("add {COLOR_BY} COLUMN, or {COLOR} 'EXPR=COLOR' for a row, or remove it");
                return Err(Error::settings(problem, mend));
            }
        };
        Ok(format!("{option}: there is no legend, because {why}"))
    }

    /// The words above it: the title, or the name of the quantity and whether its scale is logarithmic.
    #[must_use]
    pub fn heading(&self) -> String {
        let log = if self.log { " (logarithmic)" } else { "" };
        self.title.clone().unwrap_or_else(|| format!("{}{log}", self.name))
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

    /// The marks of the bar from its lower end on, two to five of them: multiples of 1, 2, 2.5 or 5 times a power of ten; on a
    /// logarithmic scale powers of ten, or 1, 2 and 5 times these where the range has few powers. One mark in the middle
    /// where all numbers are equal, and the ends of a range whose numbers differ too little.
    #[must_use]
    pub fn ticks(&self) -> Vec<Tick> {
        let [low, high] = self.range;
        if low == high {
            return vec![Tick { place: 0.5, label: short(low) }];
        }
        let scale = |x: f64| if self.log { x.ln() } else { x };
        let tick = |(value, label): (f64, String)| {
            let place = (scale(value) - scale(low)) / (scale(high) - scale(low));
            Tick { place: place.clamp(0.0, 1.0), label }
        };
        let powers = if self.log { powers(self.range) } else { Vec::new() };
        let marks = if powers.len() > 1 { powers } else { multiples(self.range, if self.log { 0.0 } else { SLACK }) };
        let ends = || self.range.map(|end| (end, short(end))).to_vec();
        (if marks.len() > 1 { marks } else { ends() }).into_iter().map(tick).collect()
    }

    /// Whether it is a scale of numbers that are all equal.
    #[must_use]
    pub fn is_flat(&self) -> bool {
        self.names.is_empty() && self.is_scale() && self.range[0] == self.range[1]
    }
}

/// A category of particles.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Category {
    /// Its name or number, as in the file.
    pub label: String,
    /// Its colour, 8-bit sRGB.
    pub color: [u8; 3],
    /// The number of its particles.
    pub count: u64,
}

/// A mark of a bar of colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// The place on the bar, from 0 at its lower end to 1.
    pub place: f64,
    /// The number there.
    pub label: String,
}

/// The share of a bar by which a number may lie beyond its end and have its mark there: less than a pixel.
const SLACK: f64 = 0.002;

/// The multiples of a round number in a range, with their texts: at most [`Legend::MAX_TICKS`], and three or more unless the range
/// is too narrow for f64.
fn multiples([low, high]: [f64; 2], slack: f64) -> Vec<(f64, String)> {
    let most = Legend::MAX_TICKS as f64;
    let from = (high / most - low / most).log10().floor() as i32;
    // A step of 2.5 has one digit more.
    let steps = (from..from + 3).flat_map(|power| [(1, power), (2, power), (25, power - 1), (5, power)]);
    let inside = |(digits, power): (i64, i32)| {
        let step = digits as f64 * 10f64.powi(power);
        let [low, high] = [low / step, high / step];
        let slack = slack * (high - low);
        let [first, last] = [(low - slack).ceil(), (high + slack).floor()];
        let is_exact = first.abs().max(last.abs()) * (digits as f64) < 2f64.powi(50);
        is_exact.then(|| (first as i64..=last as i64).map(|n| decimal(n * digits, power)).collect::<Vec<_>>())
    };
    let count = |marks: &Vec<_>| marks.len() <= Legend::MAX_TICKS;
    steps.filter_map(inside).find(count).unwrap_or_default()
}

/// The powers of ten in a range, or 1, 2 and 5 times these where that is no more than [`Legend::MAX_TICKS`] numbers.
fn powers(range: [f64; 2]) -> Vec<(f64, String)> {
    let slack = 10f64.powf(SLACK * (range[1].log10() - range[0].log10()));
    let range = [range[0] / slack, (range[1] * slack).min(f64::MAX)];
    let [low, high] = range.map(|end| end.log10().floor().max(-324.0) as i32);
    let inside = |digits: &'static [i64], every: usize| {
        let all = (low..=high).filter(move |power| power.rem_euclid(every as i32) == 0);
        let all = all.flat_map(move |power| digits.iter().map(move |digit| decimal(*digit, power)));
        all.filter(|(value, _)| (range[0]..=range[1]).contains(value)).collect::<Vec<_>>()
    };
    let tries = [inside(&[1, 2, 5], 1)].into_iter().chain((1..).map(|every| inside(&[1], every)));
    tries.into_iter().find(|marks| marks.len() <= Legend::MAX_TICKS).unwrap_or_default()
}

/// The number `digits` times ten to `power`, and its text: with as many decimals as it needs, or with an exponent where the
/// power is beyond 4, or below -4 and the number below 0.001.
fn decimal(digits: i64, power: i32) -> (f64, String) {
    let exponent = format!("{digits}e{power}");
    let value = exponent.parse::<f64>().unwrap_or(f64::NAN);
    let text = match power {
        _ if digits == 0 => "0".to_owned(),
        -4..=4 => format!("{value:.*}", -power.min(0) as usize),
        ..-4 if value.abs() >= 1e-3 => format!("{value:.*}", -power as usize),
        _ => format!("{value:e}"),
    };
    (value, without_zeros(text))
}

/// A number to four digits.
fn short(value: f64) -> String {
    let decade = value.abs().log10().floor();
    if value == 0.0 || !(-3.0..5.0).contains(&decade) {
        return if value == 0.0 { "0".into() } else { format!("{value:.3e}") };
    }
    let text = format!("{value:.*}", (3.0 - decade).max(0.0) as usize);
    without_zeros(text)
}

/// A number without zeros at the end of its decimals.
fn without_zeros(text: String) -> String {
    match text.contains('.') && !text.contains('e') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn legend(range: [f64; 2], log: bool) -> Legend {
        let map = ColorMap::Viridis;
        Legend {
            name: "x".into(),
            title: None,
            map,
            range,
            log,
            categories: Vec::new(),
            names: Vec::new(),
            overrides: Vec::new(),
        }
    }

    #[test]
    fn numbers_have_four_digits() {
        assert_eq!([0.0, 123.456, -0.5, 6.02e23, 99999.0].map(short), ["0", "123.5", "-0.5", "6.020e23", "99999"]);
    }

    #[test]
    fn marks_are_round_numbers() {
        for (range, log, labels) in [
            ([0.0, 1.0], false, &["0", "0.25", "0.5", "0.75", "1"][..]),
            ([0.0, 3.0], false, &["0", "1", "2", "3"]),
            ([-0.013, 0.021], false, &["-0.01", "0", "0.01", "0.02"]),
            ([5.96e-6, 2.975], false, &["0", "1", "2"]),
            ([5.3, 97.1], false, &["20", "40", "60", "80"]),
            ([0.1, 0.7], false, &["0.2", "0.4", "0.6"]),
            ([1e6, 1.000_004e6], false, &["1000000", "1000001", "1000002", "1000003", "1000004"]),
            ([0.0, 8e9], false, &["0", "2e9", "4e9", "6e9", "8e9"]),
            ([-3e-12, 1e-12], false, &["-3e-12", "-2e-12", "-1e-12", "0", "1e-12"]),
            ([7.0, 7.0], false, &["7"]),
            ([1.0, f64::from_bits(1f64.to_bits() + 1)], false, &["1", "1"]),
            ([1.0, 100.0], true, &["1", "10", "100"]),
            ([3.0, 40.0], true, &["5", "10", "20"]),
            ([0.002, 70.0], true, &["0.01", "0.1", "1", "10"]),
            ([1e-9, 1e12], true, &["1e-5", "1", "1e5", "1e10"]),
            ([5e-324, f64::MAX], true, &["1e-218", "1e-109", "1", "1e109", "1e218"]),
            ([-f64::MAX, f64::MAX], false, &["-1e308", "0", "1e308"]),
            ([2.1, 4.4], true, &["2.5", "3", "3.5", "4"]),
        ] {
            let ticks = legend(range, log).ticks();
            assert_eq!(ticks.iter().map(|tick| &tick.label[..]).collect::<Vec<_>>(), labels, "{range:?}");
        }
    }

    #[test]
    fn marks_stand_where_their_numbers_are() {
        let mut bits = 0x9e37_79b9_7f4a_7c15_u64;
        let mut next = || {
            bits = bits.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (bits >> 11) as f64 / (1u64 << 53) as f64
        };
        for case in 0..4000 {
            let log = case % 2 == 1;
            let size = 10f64.powf(40.0 * next() - 20.0);
            let low = if log { size } else { size * (next() - 0.5) * 20.0 };
            let high = if log { low * 10f64.powf(0.01 + 12.0 * next()) } else { low + size * (0.1 + next()) };
            let ticks = legend([low, high], log).ticks();
            assert!((2..=Legend::MAX_TICKS).contains(&ticks.len()), "{low} {high} {log}: {ticks:?}");
            assert!(ticks.is_sorted_by(|a, b| a.place < b.place), "{ticks:?}");
            for Tick { place, label } in ticks {
                let value: f64 = label.parse().expect("a number");
                let part = if log { (value / low).ln() / (high / low).ln() } else { (value - low) / (high - low) };
                assert!((part - place).abs() < 1.01 * SLACK, "{label} at {place} of {low} to {high}");
            }
        }
    }
}
