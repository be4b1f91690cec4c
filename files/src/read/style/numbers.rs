//! Colours from columns of numbers.

use super::categories::{self, is_painted};
use super::scale::{Colored, Scale};
use halfline::error::{Error, Result};
use halfline::frame::legend::Legend;
use halfline::parallel;
use halfline::quote::setting::{COLOR_BY, HOLD, LOG, MAP, RANGE};
use halfline::quote::{list, number, quote};
use halfline_particles::Skipped;
use halfline_particles::nearest::did_you_mean;
use halfline_particles::particles::frame::{Column, Particles, RuleTarget};
use halfline_particles::particles::vectors;
use std::borrow::Cow;

/// Values beyond the ends of the colours are reported where they are more than this part of all.
const MANY: usize = 4;

/// The share of a colour map at one of its ends, and the number n: reported if all values but one in n lie there.
const CROWDED: f64 = 0.05;
const REST: usize = 20;

impl Scale {
    /// The colours, and the legend unless there are no values and no range.
    ///
    /// # Errors
    /// [`Error::Settings`] for missing columns or columns that the scale does not fit.
    pub(super) fn apply(&self, particles: &Particles, skipped: &mut Skipped) -> Result<Colored> {
        if let Some([a, b]) = self.known_range().filter(|ends| self.log && ends.iter().any(|end| *end <= 0.0)) {
            let problem = format!("the range {a},{b} is not positive, so it has no logarithm");
            return Err(Error::settings(problem, format!("use two positive numbers, or remove {LOG}")));
        }
        let column = |name: &String| {
            let known = particles.columns.iter().find(|column| column.name.eq_ignore_ascii_case(name));
            known.map(Cow::Borrowed).or_else(|| own(particles, name).map(Cow::Owned)).ok_or_else(|| {
                let all = particles.has.iter().map(String::as_str);
                let axes = ["x", "y", "z"].into_iter().filter(|axis| !particles.has.iter().any(|name| name == axis));
                let all: Vec<&str> = all.chain(axes).collect();
                let mend = match name.to_ascii_lowercase().as_str() {
                    "plddt" => format!("predicted structures have it as the B factor: {COLOR_BY} bfactor {MAP} plddt"),
                    _ => format!("the file has {}", list(&all)),
                };
                Error::settings(
                    format!("the file has no column {} to colour by", quote(name)),
                    did_you_mean(name, all, mend),
                )
            })
        };
        let columns: Vec<Cow<'_, Column>> = self.columns.iter().map(column).collect::<Result<_>>()?;
        let columns: Vec<&Column> = columns.iter().map(|column| &**column).collect();
        if let Some(found) = categories::apply(self, &columns, particles, skipped)? {
            return Ok(found);
        }
        let map = self.map.clone().unwrap_or_default();
        let n = particles.positions.len();
        let values = match columns[..] {
            [one] => Cow::Borrowed(&one.values),
            _ => Cow::Owned(vectors::length(&columns.iter().map(|column| &column.values[..]).collect::<Vec<_>>())),
        };
        let shown = |x: &f64| x.is_finite() && (!self.log || *x > 0.0);
        let [low, high] = self.ends(values.iter().copied().filter(shown));
        let scaled = |x: f64| if self.log { x.ln() } else { x };
        let (from, width) = (scaled(low), scaled(high) - scaled(low));
        let missing = self.missing();
        let color = |x: &f64| {
            let part = (scaled(*x) - from) / width;
            match x.is_nan() {
                true => missing,
                // If all values are equal or not positive on a logarithmic scale: the map's first colour.
                false => map.color(if part.is_nan() { 0.0 } else { part }),
            }
        };
        let name = vectors::title(&self.columns, &particles.has);
        let without = parallel::count(values.len(), |n| values[n].is_nan());
        let below = if self.log { parallel::count(values.len(), |n| values[n] <= 0.0) } else { 0 };
        let lost = without + below;
        if lost > 0 {
            let (why, grey) =
                (if self.log { "are not positive numbers" } else { "are not numbers" }, self.missing_words());
            let color = match (self.log, without) {
                (false, _) => grey,
                (true, 0) => "have the first colour of the map".to_owned(),
                (true, _) => format!("have the first colour of the map, or {grey} where the value is NaN"),
            };
            skipped.assumed.push(format!("{lost} of {n} values of {name} {why}, so these particles {color}"));
        }
        if let Some([low, high]) = self.known_range() {
            let [low, high] = [low.min(high), low.max(high)];
            let beyond = parallel::count(values.len(), |n| values[n] < low || values[n] > high);
            if beyond > n / MANY {
                let percent = 100 * beyond / n;
                skipped.assumed.push(format!(
                    "{percent} % of the values of {name} lie beyond {} to {}, the ends of the colours; {RANGE} LOW,HIGH sets \
                     others, and {HOLD} all takes the ends of all frames",
                    number(low, 4),
                    number(high, 4),
                ));
            }
        }
        let ends = |end: fn(f64) -> bool| parallel::count(n, |k| end((scaled(values[k]) - from) / width));
        let (lowest, highest) = (ends(|part| part < CROWDED), ends(|part| part > 1.0 - CROWDED));
        if self.range.is_none() && width > 0.0 && lowest.max(highest) > n - n / REST {
            let (which, percent) = (if lowest > highest { "lowest" } else { "highest" }, 100 * lowest.max(highest) / n);
            let log = if self.log { String::new() } else { format!(", or {LOG},") };
            skipped.assumed.push(format!(
                "{percent} % of the values of {name} have the {which} 5 % of the colours; {RANGE} 1%,99%{log} spreads them"
            ));
        }
        let paint = particles.rule_numbers(RuleTarget::Color);
        let shown = values.iter().enumerate().filter(|(n, x)| x.is_nan() && !is_painted(paint, *n));
        let shown = if without > 0 { shown.count() } else { 0 };
        let legend = Legend {
            name,
            title: None,
            map: map.clone(),
            range: [low, high],
            log: self.log,
            categories: Vec::new(),
            names: Vec::new(),
            overrides: self.missing_row("no number", shown as u64).into_iter().collect(),
        };
        Ok((parallel::map(&values, color), (low <= high || self.known_range().is_some()).then_some(legend)))
    }
}

/// Coordinates and radii, which every file or some files have besides their columns.
fn own(particles: &Particles, name: &str) -> Option<Column> {
    let values: Vec<f64> = match name.to_ascii_lowercase().as_str() {
        "x" => particles.positions.iter().map(|position| position[0]).collect(),
        "y" => particles.positions.iter().map(|position| position[1]).collect(),
        "z" => particles.positions.iter().map(|position| position[2]).collect(),
        "radius" if !particles.radii.is_empty() => particles.radii.clone(),
        _ => return None,
    };
    Some(Column { name: name.to_owned(), values })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::style::scale::RangeEnd;
    use halfline::frame::color_map::ColorMap;

    fn particles(n: usize) -> Particles {
        Particles { positions: (0..n).map(|k| [k as f64, 0.0, 0.0]).collect(), ..Particles::default() }
    }

    #[test]
    fn columns_are_coloured_between_the_ends_of_their_range() {
        let mut p = particles(3);
        p.columns = vec![Column { name: "v".into(), values: vec![1.0, 10.0, 100.0] }];
        let scale = |range: Option<[f64; 2]>, log| Scale {
            map: Some(ColorMap::Viridis),
            range: range.map(|ends| ends.map(RangeEnd::Value)),
            log,
            ..Scale::of(vec!["V".into()])
        };
        let middle = ColorMap::Viridis.color(0.5);
        let apply = |scale: Scale, p: &Particles| {
            let mut skipped = Skipped::default();
            let (colors, legend) = scale.apply(p, &mut skipped)?;
            Ok::<_, Error>((colors, legend, skipped.assumed))
        };
        let (colors, legend, _) = apply(scale(None, true), &p).expect("colours");
        let legend = legend.expect("a legend");
        assert_eq!(
            (legend.range, colors[0], colors[2]),
            ([1.0, 100.0], ColorMap::Viridis.color(0.0), ColorMap::Viridis.color(1.0))
        );
        assert!(colors[1].iter().zip(middle).all(|(a, b)| (a - b).abs() < 0.02), "the logarithm's middle");
        assert_eq!(apply(scale(Some([0.0, 20.0]), false), &p).expect("colours").0[1], middle);
        let beyond = |range| apply(scale(Some(range), false), &p).expect("colours").2.concat();
        assert!(
            beyond([0.0, 1.5]).starts_with("66 % of the values of V lie beyond 0 to 1.5"),
            "{}",
            beyond([0.0, 1.5])
        );
        assert_eq!([beyond([0.0, 100.0]), beyond([100.0, 0.0])], ["", ""]);
        // Coordinates need no column.
        p.positions[2] = [7.0, 0.0, 5.0];
        let height = Scale { columns: vec!["z".into()], ..scale(None, false) };
        let (colors, legend, _) = apply(height, &p).expect("colours");
        assert_eq!((legend.expect("a legend").range, colors[2]), ([0.0, 5.0], ColorMap::Viridis.color(1.0)));
        let missing = Scale { columns: vec!["w".into()], ..scale(None, false) };
        assert!(apply(missing, &p).expect_err("no such column").to_string().contains("`w`"));
        apply(scale(Some([0.0, 20.0]), true), &p).expect_err("0 has no logarithm");
        p.columns[0].values = vec![f64::NAN, -1.0, 5.0];
        let (colors, legend, warnings) = apply(scale(None, true), &p).expect("colours");
        assert_eq!((legend.map(|legend| legend.range), colors[1]), (Some([5.0, 5.0]), ColorMap::Viridis.color(0.0)));
        assert!(colors[0][0] == colors[0][1] && colors[0][1] == colors[0][2], "NaN is grey: {:?}", colors[0]);
        assert!(warnings[0].starts_with("2 of 3 values of V "), "{warnings:?}");
        p.columns[0].values = vec![f64::NAN; 3];
        assert_eq!(apply(scale(None, false), &p).expect("colours").1, None, "no legend without values");
    }
}
