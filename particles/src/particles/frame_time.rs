//! The time and the step of a frame.

/// The time and the step of a frame, as far as the file has them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FrameTime {
    /// The time: picoseconds for GRO, XTC, TRR and DCD, the unit of the file elsewhere; finite.
    pub time: Option<f64>,
    /// The number of the simulation's step, which is not a time.
    pub step: Option<i64>,
}

impl FrameTime {
    /// A time and a step; a time that is not finite is none.
    pub(crate) fn of(time: Option<f64>, step: Option<i64>) -> Self {
        Self { time: time.filter(|time| time.is_finite()), step }
    }
}
