//! Scales of colours.

use halfline::error::{Error, Result};
use halfline::frame::color_map::ColorMap;
use halfline::frame::legend::{Category, Legend};
use halfline::frame::srgb::{level, linear};
use halfline::memory::check;
use halfline::parallel;
use halfline::quote::quote;
use halfline::quote::setting::{NAN_COLOR, RANGE};
use std::str::FromStr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The mapping of the numbers or names of a column to colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// The column; with several, the length of the vector.
    pub columns: Vec<String>,
    /// The colour map. `None` takes [`ColorMap::Category`] for names (chain, asym, entity) and for numbers that
    /// identify (type, molecule, model, copy), else [`ColorMap::Viridis`].
    pub map: Option<ColorMap>,
    /// The map's ends; `None` takes the minimum and the maximum.
    pub range: Option<[RangeEnd; 2]>,
    /// Whether the scale is logarithmic.
    pub log: bool,
    /// Linear RGB of particles without a number; `None` takes a grey.
    pub nan_color: Option<[f32; 3]>,
    /// Names of categories whose colours are fixed, in the order of their colours: a film keeps the names of its first frame.
    /// Others follow in the file's order.
    pub names: Vec<String>,
    /// The place for the values of all frames, where their percentiles are to be found.
    pub gathered: Option<GatheredValues>,
}

/// Values of a column, of every frame that was read with a scale that has this place. All are equal as options.
#[derive(Debug, Clone, Default)]
pub struct GatheredValues(Arc<Mutex<Vec<f64>>>);

impl GatheredValues {
    fn lock(&self) -> MutexGuard<'_, Vec<f64>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns an error where the values need more memory than there is.
    ///
    /// # Errors
    /// [`Error::Limits`].
    pub fn check(&self) -> Result<()> {
        let more = self.lock().len() as u64;
        // Twice: they grow, and are sorted.
        check(2 * 8 * more, || format!("the {more} values of all frames, for the percentiles of {RANGE}"))
    }
}

impl PartialEq for GatheredValues {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Scale {
    /// The values at the map's ends, as far as they are known without the particles: the given values, or the map's.
    #[must_use]
    pub fn known_range(&self) -> Option<[f64; 2]> {
        match self.range {
            Some([RangeEnd::Value(low), RangeEnd::Value(high)]) => Some([low, high]),
            Some(_) => None,
            None => (self.map == Some(ColorMap::Plddt)).then_some(PLDDT),
        }
    }

    /// Whether an end of the range is a percentile.
    #[must_use]
    pub fn has_percentile(&self) -> bool {
        self.range.is_some_and(RangeEnd::have_percentile)
    }

    /// The values at the map's ends for the finite values of all particles: those that are known, the percentiles, or the least and the
    /// greatest. Without values an end is an infinity.
    pub(super) fn ends(&self, values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
        if let Some(range) = self.known_range() {
            return range;
        }
        if let Some(gathered) = &self.gathered {
            gathered.lock().extend(values.clone());
        }
        let Some(ends) = self.range else {
            return values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
        };
        let mut sorted: Vec<f64> = values.collect();
        parallel::sort(&mut sorted, f64::total_cmp);
        let value = |end: RangeEnd, without: f64| match end {
            RangeEnd::Value(value) => value,
            RangeEnd::Percentile(percent) => percentile(&sorted, percent).unwrap_or(without),
        };
        [value(ends[0], f64::INFINITY), value(ends[1], f64::NEG_INFINITY)]
    }

    /// Gives the scale the range of all values that were gathered, if they were.
    pub fn settle_range(&mut self) {
        if let Some(gathered) = self.gathered.take() {
            let values = std::mem::take(&mut *gathered.lock());
            self.range = Some(self.ends(values.iter().copied()).map(RangeEnd::Value));
        }
    }

    /// Linear RGB of particles without a number.
    pub(super) fn missing(&self) -> [f32; 3] {
        self.nan_color.unwrap_or_else(|| linear(MISSING))
    }

    /// The colour of particles without a number, in words.
    pub(super) fn missing_words(&self) -> String {
        self.nan_color.map_or("are grey".into(), |_| format!("have the colour of {NAN_COLOR}"))
    }

    /// The row of a legend for so many particles without a number.
    pub(super) fn missing_row(&self, label: &str, count: u64) -> Option<Category> {
        (count > 0).then(|| Category { label: label.into(), color: self.missing().map(level), count })
    }

    /// The colours of these columns, with everything else as it is by default.
    #[must_use]
    pub fn of(columns: Vec<String>) -> Self {
        Self { columns, map: None, range: None, log: false, nan_color: None, names: Vec::new(), gathered: None }
    }
}

/// The colour of particles without a number.
const MISSING: [u8; 3] = [0x80; 3];

/// An end of a range of colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RangeEnd {
    /// A finite number.
    Value(f64),
    /// The percentile of the values of all particles of the frame, from 0 to 100.
    Percentile(f64),
}

impl RangeEnd {
    /// Whether one of two ends is a percentile.
    #[must_use]
    pub fn have_percentile(ends: [Self; 2]) -> bool {
        ends.iter().any(|end| matches!(end, Self::Percentile(_)))
    }
}

impl FromStr for RangeEnd {
    type Err = Error;
    /// A number, or one from 0 to 100 with a percent sign.
    fn from_str(text: &str) -> Result<Self> {
        let (digits, is_percentile) = text.trim().strip_suffix('%').map_or((text, false), |digits| (digits, true));
        let number = digits.trim().parse().ok().filter(|x: &f64| x.is_finite());
        match number {
            Some(number) if !is_percentile => Ok(Self::Value(number)),
            Some(percent) if (0.0..=100.0).contains(&percent) => Ok(Self::Percentile(percent)),
            _ => {
                let problem = format!("{} is no end of a range", quote(text));
                Err(Error::settings(problem, "give a number such as 1.5, or a percentile such as 99%"))
            }
        }
    }
}

/// The percentile of sorted values: the value of that rank, and between two ranks the number between their values, as in NumPy's
/// `percentile` by default (definition 7 of R. J. Hyndman and Y. Fan, Sample Quantiles in Statistical Packages, The American
/// Statistician 50(4), 1996). `None` without values.
fn percentile(sorted: &[f64], percent: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = last as f64 * percent / 100.0;
    let (below, part) = (place.floor() as usize, place.fract());
    let (low, high) = (sorted[below], sorted[(below + 1).min(last)]);
    Some(low * (1.0 - part) + high * part)
}

/// The least and the greatest pLDDT.
const PLDDT: [f64; 2] = [0.0, 100.0];

/// Linear RGB of each particle, and the legend.
pub(super) type Colored = (Vec<[f32; 3]>, Option<Legend>);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_numpy() {
        // numpy.percentile of NumPy 2.3.
        let values = [9.0, -3.0, 4.5, 0.25, 7.0];
        let of = |ends: [&str; 2]| {
            let range = Some(ends.map(|end| end.parse().expect(end)));
            Scale { range, ..Scale::of(Vec::new()) }.ends(values.into_iter())
        };
        for (ends, expected) in [
            (["0%", "100%"], [-3.0, 9.0]),
            (["25%", "75 %"], [0.25, 7.0]),
            (["10%", "90%"], [-1.7, 8.2]),
            (["-1", "50%"], [-1.0, 4.5]),
        ] {
            // Between two ranks a rounding of each product and of the sum.
            assert!(of(ends).iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{ends:?}: {:?}", of(ends));
        }
        assert_eq!(Scale { range: Some([RangeEnd::Percentile(1.0); 2]), ..Scale::of(Vec::new()) }.known_range(), None);
        for bad in ["101%", "-1%", "%", "x", "nan", "inf%", ""] {
            bad.parse::<RangeEnd>().expect_err(bad);
        }
    }
}
