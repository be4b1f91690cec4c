//! How much the device is given at once: a submission is bounded in time, because systems end what takes long.

/// No submission shall take longer than this, seconds. Windows resets a device that does not answer for 2 s (TDR), Linux
/// drivers for some 2 to 10 s, and until then nothing else is drawn; a band may be a few times as heavy as the one before.
const BOUND: f64 = 0.5;

/// What a band is cut for where more than one is needed, seconds.
const AIM: f64 = BOUND / 2.0;

/// Ray-sphere tests, at the price of `stable`, that a kernel is given before its speed is known: half a second of software
/// on two cores, and milliseconds of hardware.
const FIRST: f64 = (1u64 << 29) as f64;

/// A band is at most so many times as heavy as one that was seen to end in time.
const GROWTH: f64 = 16.0;

/// What a pixel costs besides the spheres it asks, in tests: its ray, its answers, its colour. On lavapipe a certified
/// frame of 1024 x 1024 whose tiles list eight spheres takes 60 ms.
pub(super) const PIXEL: f64 = 64.0;

/// How fast a kernel is on this device, as far as it has been seen. It bounds how much is submitted, and nothing else: the
/// answers do not depend on it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SubmissionBudget {
    /// Of the last band.
    seconds_per_test: Option<f64>,
    /// What may be submitted whatever the speed.
    trusted: f64,
    /// [`BOUND`], but for tests.
    bound: f64,
}

impl Default for SubmissionBudget {
    fn default() -> Self {
        Self { seconds_per_test: None, trusted: FIRST, bound: BOUND }
    }
}

impl SubmissionBudget {
    /// A budget at which only the smallest band is submitted at once.
    #[cfg(test)]
    pub(crate) fn minimal() -> Self {
        Self { seconds_per_test: Some(1.0), trusted: 0.0, bound: 0.0 }
    }

    /// Tests that the next band may have, of `left`.
    pub(super) fn next(&self, left: f64) -> f64 {
        let Some(seconds) = self.seconds_per_test else { return self.trusted };
        let aim = if left * seconds <= self.bound { left } else { AIM.min(self.bound) / seconds };
        aim.min(self.trusted)
    }

    /// A band of so many tests took so long: by the device's clock, or by the host's where there is none.
    pub(super) fn took(&mut self, tests: f64, seconds: f64) {
        self.seconds_per_test = Some(seconds / tests.max(1.0));
        if seconds <= self.bound {
            self.trusted = self.trusted.max(GROWTH * tests);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Submits `tests` to a device that does `speed` of them a second; how long each submission took.
    fn submit(budget: &mut SubmissionBudget, tests: f64, speed: f64) -> Vec<f64> {
        let mut times = Vec::new();
        let mut left = tests;
        while left > 0.0 {
            let next = budget.next(left).min(left);
            times.push(next / speed);
            budget.took(next, next / speed);
            left -= next;
        }
        times
    }

    #[test]
    fn light_frames_are_one_submission() {
        for speed in [1e8, 1e12] {
            assert_eq!(submit(&mut SubmissionBudget::default(), FIRST, speed).len(), 1);
        }
        let mut seen = SubmissionBudget::default();
        submit(&mut seen, 1e11, 1e12);
        assert_eq!(submit(&mut seen, 4e11, 1e12).len(), 1, "0.4 s at the speed that was seen");
    }

    #[test]
    fn heavy_frames_are_split_into_short_submissions() {
        for speed in [1.2e9, 1e10, 1e12] {
            let times = submit(&mut SubmissionBudget::default(), 20.0 * speed, speed);
            assert!(times.iter().all(|t| *t <= BOUND), "{speed}: {times:?}");
            assert!((40..120).contains(&times.len()), "{speed}: {} submissions", times.len());
        }
    }

    #[test]
    fn a_device_that_slows_down_is_given_less() {
        let mut budget = SubmissionBudget::default();
        submit(&mut budget, 1e12, 1e12);
        let times = submit(&mut budget, 1e12, 1e10);
        assert!(times[1..].iter().all(|t| *t <= BOUND), "{times:?}");
    }
}
