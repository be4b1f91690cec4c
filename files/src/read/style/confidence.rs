//! The classes of the confidence of a predicted structure, pLDDT from 0 to 100, as the AlphaFold Protein Structure Database
//! (alphafold.ebi.ac.uk) has them.

use halfline::parallel;
use halfline::quote::setting::RANGE;
use halfline_particles::Skipped;
use halfline_particles::particles::frame::Column;

/// The name of the quantity.
pub(super) const NAME: &str = "pLDDT";

/// The names of the classes, from the highest to the lowest.
const CLASSES: [&str; 4] = ["very high", "high", "low", "very low"];

/// The least percents of the classes but the last; a class begins above its limit.
const LIMITS: [f64; 3] = [90.0, 70.0, 50.0];

/// The class of each particle.
pub(super) struct Classes {
    /// Their numbers from 0; NaN for a particle without a confidence.
    pub(super) column: Column,
    /// Their names with their limits.
    pub(super) names: Vec<String>,
}

/// The classes of a column whose values go from `low` to `high`.
pub(super) fn classes(column: &Column, [low, high]: [f64; 2], skipped: &mut Skipped) -> Classes {
    // Limits between whole numbers are exact.
    let limits = LIMITS.map(|percent| (low * (100.0 - percent) + high * percent) / 100.0);
    let class = |x: &f64| match x.is_nan() {
        true => f64::NAN,
        false => limits.iter().position(|limit| x > limit).unwrap_or(limits.len()) as f64,
    };
    let most = column.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if high == 100.0 && most > 0.0 && most <= 1.0 {
        let note = format!(
            "no {} is above 1, and {NAME} goes to 100: {RANGE} 0,1 where the file has it from 0 to 1",
            column.name
        );
        skipped.assumed.push(note);
    }
    let [first, second, third] = limits.map(|limit| limit.to_string());
    let ranges = [
        format!("above {first}"),
        format!("{second} to {first}"),
        format!("{third} to {second}"),
        format!("{third} or less"),
    ];
    let names = CLASSES.iter().zip(ranges).map(|(class, range)| format!("{class}: {range}")).collect();
    Classes { column: Column { name: column.name.clone(), values: parallel::map(&column.values, class) }, names }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_have_the_limits_of_the_database() {
        let column = |values: &[f64]| Column { name: "bfactor".into(), values: values.to_vec() };
        let of = |values: &[f64], range| {
            let mut skipped = Skipped::default();
            let classes = classes(&column(values), range, &mut skipped);
            (classes.column.values, skipped.assumed.len())
        };
        let values = [100.0, 90.5, 90.0, 70.5, 70.0, 50.5, 50.0, 0.0, -1.0];
        let expected = [0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0];
        assert_eq!(of(&values, [0.0, 100.0]), (expected.to_vec(), 0));
        assert_eq!(of(&values.map(|x| x / 128.0), [0.0, 100.0 / 128.0]), (expected.to_vec(), 0));
        assert_eq!(of(&[0.95, 0.2], [0.0, 100.0]), (vec![3.0, 3.0], 1), "a note");
        assert_eq!(of(&[0.95, 0.2], [0.0, 1.0]), (vec![0.0, 3.0], 0));
        assert!(of(&[f64::NAN], [0.0, 100.0]).0[0].is_nan());
    }
}
