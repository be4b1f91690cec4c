//! A ray as the judge decides it.

use super::cut::{ExactPlane, Interval};
use super::decide::{ExactFrame, ExactLens, ExactRay, Line};
use super::filter::FilterRay;
use crate::dyadic::{self, Dyadic};
use std::cell::OnceCell;

/// One ray in both arithmetics; the exact one is computed when it is first needed.
pub(super) struct RayForms<'a> {
    pub(super) quick: FilterRay,
    course: Course<'a>,
    exact: OnceCell<Box<ExactRay>>,
    /// The part that planes keep, if any.
    interval: OnceCell<Option<Box<Interval>>>,
}

/// The source of the exact ray: a pixel of a lens, or a given direction.
enum Course<'a> {
    /// Row and column.
    Pixel(&'a ExactLens, [u32; 2]),
    Given([f64; 3]),
}

impl<'a> RayForms<'a> {
    /// The ray through the centre of this row and column.
    #[inline(always)]
    pub(super) fn through(lens: &'a ExactLens, at: [u32; 2], quick: FilterRay) -> Self {
        Self { quick, course: Course::Pixel(lens, at), exact: OnceCell::new(), interval: OnceCell::new() }
    }

    /// A ray with a given direction; finite and not zero.
    pub(super) fn along(direction: [f64; 3]) -> Self {
        Self {
            quick: FilterRay::along(direction),
            course: Course::Given(direction),
            exact: OnceCell::new(),
            interval: OnceCell::new(),
        }
    }

    /// Whether the third component is a depth.
    pub(super) fn planar(&self) -> bool {
        matches!(self.course, Course::Pixel(..))
    }

    /// The factor from the real direction to the exact one.
    pub(super) fn stretch(&self) -> &Dyadic {
        static ONE: Dyadic = Dyadic::ONE;
        match self.course {
            Course::Pixel(lens, _) => &lens.stretch,
            Course::Given(_) => &ONE,
        }
    }

    /// The part that planes, which are the same for all calls, keep of it.
    pub(super) fn interval(&self, frame: &ExactFrame, planes: &[ExactPlane]) -> Option<&Interval> {
        self.interval.get_or_init(|| frame.interval(self.exact(frame), planes).map(Box::new)).as_deref()
    }

    pub(super) fn exact(&self, frame: &ExactFrame) -> &ExactRay {
        self.exact.get_or_init(|| {
            Box::new(frame.ray(match self.course {
                Course::Pixel(lens, [i, j]) => lens.line(i, j),
                Course::Given(direction) => Line { dir: dyadic::vector(direction), from: None },
            }))
        })
    }
}
