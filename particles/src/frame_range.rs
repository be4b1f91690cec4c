//! Which frames of a sequence are read.

use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::FRAMES;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Frames of a sequence, counted from 1: `2`, `1-10`, `1-3,5,7-20:2`, `5-` to the last.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameRange(Vec<(RangeInclusive<u64>, u64)>);

impl FrameRange {
    /// The first frame only.
    #[must_use]
    pub fn first() -> Self {
        Self(vec![(1..=1, 1)])
    }

    /// Whether frame `number` is selected.
    #[must_use]
    pub fn contains(&self, number: u64) -> bool {
        self.0.iter().any(|(range, step)| range.contains(&number) && (number - range.start()).is_multiple_of(*step))
    }

    /// The most frames that can be selected; frames in several ranges count for each.
    #[must_use]
    pub fn count(&self) -> u64 {
        let each = |(range, step): &(RangeInclusive<u64>, u64)| (range.end() - range.start()) / step + 1;
        self.0.iter().map(each).fold(0, u64::saturating_add)
    }

    /// The frame numbers, range by range.
    pub fn numbers(&self) -> impl Iterator<Item = u64> + Clone + '_ {
        // `step_by` takes a usize; a longer step than that ends any range.
        let step = |step: u64| usize::try_from(step).unwrap_or(usize::MAX);
        self.0.iter().flat_map(move |(range, by)| range.clone().step_by(step(*by)))
    }

    /// The number of the last frame, [`u64::MAX`] for an open end.
    #[must_use]
    pub fn last(&self) -> u64 {
        self.0.iter().map(|(range, _)| *range.end()).max().unwrap_or(1)
    }

    /// The error of frame `number`, whose remedy also names the frames before it, which were read: a simulation that runs, or was stopped,
    /// has written a part of the last.
    #[doc(hidden)]
    pub fn until(&self, number: u64, error: Error) -> Error {
        let last = number.saturating_sub(1);
        let first = self.numbers().next().filter(|first| *first <= last).unwrap_or(1);
        match error {
            Error::Scene { place, problem, mend, source } if last > 0 => {
                let range = if first == last { last.to_string() } else { format!("{first}-{last}") };
                let mend = format!("{mend}; or use {FRAMES} {range}, since the frames before frame {number} are whole");
                Error::Scene { place, problem, mend, source }
            }
            other => other,
        }
    }
}

impl Default for FrameRange {
    fn default() -> Self {
        Self::first()
    }
}

impl FromStr for FrameRange {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let part = |part: &str| {
            let (range, step) = part.split_once(':').unwrap_or((part, "1"));
            let (first, last) = match range.split_once('-') {
                Some((first, "")) => (first.parse().ok()?, u64::MAX),
                Some((first, last)) => (first.parse().ok()?, last.parse().ok()?),
                None => (range.parse().ok()?, range.parse().ok()?),
            };
            let step: u64 = step.parse().ok()?;
            (first >= 1 && first <= last && step >= 1).then_some((first..=last, step))
        };
        text.split(',').map(|text| part(text.trim())).collect::<Option<_>>().map(Self).ok_or_else(|| {
            let problem = format!("`{text}` is not a selection of frames");
            Error::settings(problem, "use numbers from 1: 2, 1-10, 1-3,5,7-20:2, or 5- to the last")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_named_by_ranges() {
        let frames = |text: &str| -> Vec<u64> {
            let range: FrameRange = text.parse().expect("frames");
            (1..=12).filter(|n| range.contains(*n)).collect()
        };
        assert_eq!(frames("2"), [2]);
        assert_eq!(frames("1-3,5,7-12:2"), [1, 2, 3, 5, 7, 9, 11]);
        assert_eq!(frames("10-"), [10, 11, 12]);
        assert_eq!("3-4,2".parse::<FrameRange>().expect("frames").last(), 4);
        for bad in ["", "0", "0-3", "3-2", "1:0", "a", "1-2-3", "1,,2"] {
            bad.parse::<FrameRange>().expect_err(bad);
        }
    }
}
