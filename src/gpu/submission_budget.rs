//! The budget of a submission: its duration is bounded, because operating systems reset a device that does not respond.

/// Upper bound of a submission's duration in seconds. Windows resets a device after 2 s without a response (TDR), Linux
/// drivers after some 2 to 10 s, and the display is not updated meanwhile. A band may cost a few times its estimate.
const BOUND: f64 = 0.5;

/// Target duration of a band, if more than one is needed, in seconds.
const AIM: f64 = BOUND / 2.0;

/// Ray-sphere tests, at the cost of `stable`, in the first submission, when the kernel's speed is still unknown. They
/// take half a second in software on two cores, and milliseconds on hardware.
const FIRST: f64 = (1u64 << 29) as f64;

/// Upper bound of a band's cost relative to one that completed in time.
const GROWTH: f64 = 16.0;

/// The cost of a pixel besides its ray-sphere tests, in tests: its ray, outputs and colour. On lavapipe a certified
/// frame of 1024 x 1024 with eight spheres per tile takes 60 ms.
pub(super) const PIXEL: f64 = 64.0;

/// The measured speed of a kernel on this device. It limits the size of submissions and does not affect the answers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SubmissionBudget {
    /// The speed of the last band.
    seconds_per_test: Option<f64>,
    /// The cost that may be submitted at any speed.
    trusted: f64,
    /// [`BOUND`]; tests use others.
    bound: f64,
}

impl Default for SubmissionBudget {
    fn default() -> Self {
        Self { seconds_per_test: None, trusted: FIRST, bound: BOUND }
    }
}

impl SubmissionBudget {
    /// A budget that admits only the smallest band.
    #[cfg(test)]
    pub(crate) fn minimal() -> Self {
        Self { seconds_per_test: Some(1.0), trusted: 0.0, bound: 0.0 }
    }

    /// A budget whose first band costs at most so much.
    #[cfg(test)]
    pub(crate) fn starting(trusted: f64) -> Self {
        Self { trusted, ..Self::default() }
    }

    /// The tests that the next band may cost, out of `left`.
    pub(super) fn next(&self, left: f64) -> f64 {
        let Some(seconds) = self.seconds_per_test else { return self.trusted };
        let aim = if left * seconds <= self.bound { left } else { AIM.min(self.bound) / seconds };
        aim.min(self.trusted)
    }

    /// Records that a band of `tests` took `seconds`, by the device's clock if there is one, else by the host's.
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

    /// Submits `tests` to a device that performs `speed` of them per second; the durations of the submissions.
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
        let mut budget = SubmissionBudget::default();
        submit(&mut budget, 1e11, 1e12);
        assert_eq!(submit(&mut budget, 4e11, 1e12).len(), 1, "0.4 s at the speed that was seen");
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
