//! Progress through the pictures of a command. A picture is traced once for the centres of its pixels and, with several
//! samples, once for each sample.

use halfline::progress::{Progress, Step};
use halfline::view::strata_of;

/// The picture and the sample that the latest progress is of.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tally {
    pub(super) latest: Option<Progress>,
    /// The number of the picture, and of the pass over its pixels, from 1.
    pub(super) frame: u32,
    pass: u32,
    /// The samples of a picture, and whether rays go on from its hits.
    pub(super) samples: u32,
    has_light: bool,
    /// Whether the picture began with staging, as all do but exact ones of `measure` and given rays.
    is_staged: bool,
}

impl Tally {
    /// Sets the samples per pixel of the pictures that follow, rounded up to a square number. `has_light` says whether
    /// rays go on from the hits, which takes most of the time.
    pub(super) fn expect(&mut self, samples: u32, has_light: bool) {
        self.has_light = has_light;
        self.samples = strata_of(samples).saturating_pow(2);
    }

    /// Takes progress; whether a picture begins with it.
    pub(super) fn record(&mut self, progress: Progress) -> bool {
        // A pass begins with an earlier step than the last one ended with, or with less of the same.
        let begins = self.latest.is_none_or(|latest| (progress.step, progress.done) < (latest.step, latest.done));
        self.latest = Some(progress);
        if !begins {
            return false;
        }
        let is_first = progress.step == Step::Stage || !self.is_staged || self.pass >= self.passes();
        if is_first {
            (self.frame, self.pass, self.is_staged) = (self.frame + 1, 1, progress.step == Step::Stage);
        } else {
            self.pass += 1;
        }
        is_first
    }

    fn passes(&self) -> u32 {
        if self.samples > 1 { self.samples + 1 } else { 1 }
    }

    /// The sample that is traced, from 1; 0 for the centres of pixels that have several samples.
    pub(super) fn sample(&self) -> u32 {
        if self.samples > 1 { self.pass.saturating_sub(1) } else { 1 }
    }

    /// The share of the picture that is done, by estimated shares of the steps; it never falls.
    pub(super) fn share(&self) -> f64 {
        let Some(progress) = self.latest else { return 0.0 };
        let (begin, end) = match (progress.step, self.has_light) {
            (Step::Rays, _) => (0.0, 0.95),
            (Step::Stage, _) => (0.0, 0.05),
            (Step::Trace, false) => (0.05, 0.75),
            (Step::Settle, false) => (0.75, 0.85),
            (_, false) => (0.85, 0.95),
            (Step::Trace, true) => (0.05, 0.2),
            (Step::Settle, true) => (0.2, 0.25),
            (_, true) => (0.25, 0.95),
        };
        let part = progress.known_total().map_or(0.0, |total| progress.done as f64 / (total as f64).max(1.0));
        (f64::from(self.pass.saturating_sub(1)) + begin + (end - begin) * part) / f64::from(self.passes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The progress of pictures as renderers report it: staged, then a pass for the centres and one for each sample.
    fn picture(passes: u32, has_light: bool) -> Vec<Progress> {
        let of =
            |step, done: &[u64]| done.iter().map(|done| Progress { step, done: *done, total: 40 }).collect::<Vec<_>>();
        let pass = || {
            let light = of(Step::Light, if has_light { &[0, 20, 40] } else { &[] });
            [of(Step::Trace, &[0, 10, 40]), of(Step::Settle, &[0, 40]), light].concat()
        };
        [of(Step::Stage, &[0, 40])].into_iter().chain((0..passes).map(|_| pass())).flatten().collect()
    }

    #[test]
    fn a_picture_is_one_frame_whatever_its_samples() {
        for (samples, passes, has_light) in [(1, 1, false), (1, 1, true), (4, 5, true), (16, 17, false), (10, 17, true)]
        {
            let mut tally = Tally::default();
            tally.expect(samples, has_light);
            let (mut last, mut begun) = (0.0, 0);
            for frame in 1..=3 {
                for progress in picture(passes, has_light) {
                    begun += u32::from(tally.record(progress));
                    assert_eq!((tally.frame, begun), (frame, frame), "{samples} samples");
                    let share = f64::from(frame - 1) + tally.share();
                    // Sums of shares are rounded.
                    assert!(share >= last - 1e-12 && tally.share() < 1.0, "{share} after {last}");
                    last = share;
                }
                assert_eq!(tally.sample(), tally.samples, "{samples} samples");
            }
        }
    }

    #[test]
    fn frames_that_are_not_staged_are_counted_too() {
        let mut tally = Tally::default();
        let settle = |done| Progress { step: Step::Settle, done, total: 2 };
        let begun = [0, 2, 0, 1, 2, 0].map(|done| tally.record(settle(done)));
        assert_eq!((begun, tally.frame), ([true, false, true, false, false, true], 3));
    }
}
