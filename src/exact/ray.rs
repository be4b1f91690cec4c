//! A ray as the judge decides it.

use super::decide::{ExactFrame, ExactRay, Line};
use super::filter::FilterRay;
use crate::dyadic::{self, Dyadic};
use std::cell::OnceCell;

/// One ray in both arithmetics; the exact one is computed when it is first needed.
pub(super) struct RayForms {
    pub(super) quick: FilterRay,
    pub(super) line: Line,
    /// The factor from the real direction to the exact one.
    pub(super) stretch: Dyadic,
    /// Whether the third component is a depth.
    pub(super) planar: bool,
    pub(super) exact: OnceCell<ExactRay>,
}

impl RayForms {
    /// A ray with a given direction; finite and not zero.
    pub(super) fn along(direction: [f64; 3]) -> Self {
        Self {
            quick: FilterRay::along(direction),
            line: Line { dir: dyadic::vector(direction), from: None },
            stretch: Dyadic::from(1),
            planar: false,
            exact: OnceCell::new(),
        }
    }

    pub(super) fn exact(&self, frame: &ExactFrame) -> &ExactRay {
        self.exact.get_or_init(|| frame.ray(self.line.clone()))
    }
}
