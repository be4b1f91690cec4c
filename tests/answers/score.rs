//! The errors of a frame against the exact frame.

use halfline::frame::{Aov, Frame};

/// The errors of one frame, or of several together.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Score {
    pub(crate) pixels: usize,
    /// False hits, false misses and wrong spheres.
    pub(crate) wrong: usize,
    /// Largest relative error of the distance where the right sphere is hit; infinite where one is NaN.
    pub(crate) error: f64,
    /// Pixels certified in f32, and the largest ratio of error to bound among them.
    pub(crate) certified: usize,
    pub(crate) ratio: f64,
}

impl Score {
    /// Compares ids and distances, and bounds where the frame has them.
    pub(crate) fn of(frame: &Frame, exact: &Frame) -> Self {
        let values = |frame: &Frame| frame.f64(Aov::Distance).expect("a requested buffer").to_vec();
        let (distances, truths) = (values(frame), values(exact));
        let bounds = frame.f64(Aov::Bound);
        let settled = settled(frame);
        let mut score = Self { pixels: truths.len(), ..Self::default() };
        for (k, truth) in truths.iter().enumerate() {
            score.certified += usize::from(settled.is_some_and(|settled| settled[k] == 0));
            if frame.ids()[k] != exact.ids()[k] {
                score.wrong += 1;
            } else if truth.is_finite() {
                let off = (distances[k] - truth).abs();
                score.error = worse(score.error, off / truth);
                if let (Some(bounds), true) = (bounds, settled.is_some_and(|settled| settled[k] == 0)) {
                    score.ratio = worse(score.ratio, off / bounds[k]);
                }
            }
        }
        score
    }

    /// The errors of both together.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            wrong: self.wrong + other.wrong,
            error: worse(self.error, other.error),
            certified: self.certified + other.certified,
            ratio: worse(self.ratio, other.ratio),
        }
    }
}

/// The larger; NaN counts as infinite.
fn worse(a: f64, b: f64) -> f64 {
    if b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// 0 for a pixel certified in f32, 1 for a settled one.
pub(crate) fn settled(frame: &Frame) -> Option<&[u8]> {
    match &frame.get(Aov::Certainty)?.data {
        halfline::frame::Data::U8(values) => Some(values),
        _ => None,
    }
}
