//! Values of options.

use glam::DVec3;
use halfline_files::read::style;
use std::num::NonZeroU32;
use std::ops::RangeInclusive;

/// Finite numbers separated by commas, exactly `N` of them.
pub(super) fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    list(text)?.try_into().ok()
}

/// Finite numbers separated by commas.
pub(super) fn list(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect()
}

/// Whole numbers separated by commas, exactly `N` of them.
pub(super) fn wholes<const N: usize>(text: &str) -> Option<[u32; N]> {
    let numbers: Vec<u32> = text.split(',').map(|n| n.trim().parse().ok()).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

pub(super) fn vector(text: &str) -> Result<DVec3, String> {
    numbers(text).map(DVec3::from_array).ok_or_else(|| "expected three finite numbers, such as 1,-2,3.5".into())
}

/// A finite number above 0, which the message calls `what`.
pub(super) fn positive(what: &'static str) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite());
        number.ok_or_else(|| format!("expected a positive {what}"))
    }
}

/// A finite length above 0.
pub(super) fn length(text: &str) -> Result<f64, String> {
    positive("length, in the scene's unit")(text)
}

/// A number of samples, pictures or repetitions.
pub(super) fn at_least_one(text: &str) -> Result<NonZeroU32, String> {
    text.parse().map_err(|_| format!("expected a whole number between 1 and {}", u32::MAX))
}

/// A whole number in a range.
pub(super) fn whole(range: RangeInclusive<u32>) -> impl Fn(&str) -> Result<u32, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("expected a whole number between {} and {}", range.start(), range.end()))
    }
}

pub(super) fn color(text: &str) -> Result<[f32; 3], String> {
    style::color(text).map_err(|e| e.to_string())
}

/// A share above 0 and at most 1, or in percent.
pub(super) fn share(text: &str) -> Result<f64, String> {
    let number = match text.strip_suffix('%') {
        Some(percent) => percent.trim().parse().map(|percent: f64| percent / 100.0),
        None => text.parse(),
    };
    let expected = "expected a share above 0 and at most 1, or a percentage, such as 99%";
    number.ok().filter(|share| *share > 0.0 && *share <= 1.0).ok_or_else(|| expected.into())
}
