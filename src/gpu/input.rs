//! Inputs and results of a dispatch.

use crate::answers::raw::Raw;
use crate::frame::report::Timings;
use crate::view::View;
use crate::view::ray::RayRecord;

/// Invocations per workgroup, rays per group: a test checks that they are equal.
pub(crate) const GROUP: u32 = 64;

/// The inputs of kernels besides the view, by binding name.
pub(crate) struct Input<'a> {
    pub(crate) view: &'a View,
    /// Linear RGB per sphere.
    pub(crate) colors: Option<&'a [[f32; 3]]>,
    pub(crate) rays: KernelRays<'a>,
}

/// The rays of a dispatch.
#[derive(Debug, Clone, Copy)]
pub(crate) enum KernelRays<'a> {
    /// The viewing rays of the view; they need no buffer.
    Viewing,
    /// Given rays for a method.
    Given(&'a [RayRecord]),
}

impl KernelRays<'_> {
    /// The number of given rays.
    pub(super) fn given(&self) -> usize {
        match self {
            Self::Viewing => 0,
            Self::Given(rays) => rays.len(),
        }
    }
}

/// The results of a run.
pub(crate) struct Output<'a> {
    pub(crate) raw: &'a mut Raw,
    pub(crate) timings: &'a mut Timings,
}
