//! The inputs of the samples of a frame.

use super::light::LightSetup;
use crate::answers::finish::Finish;
use crate::frame::Aov;
use crate::kernel::Kernel;
use crate::render::opaque::Opaque;
use crate::render::plan::Plan;
use crate::scene::Scene;
use crate::settings::Settings;

/// The inputs that all samples of a frame share.
#[derive(Clone, Copy)]
pub(super) struct Sampling<'a> {
    pub(super) plan: &'a Plan,
    /// Writes ids and colours.
    pub(super) kernel: Kernel,
    /// As the eye of a pass sees it.
    pub(super) scene: &'a Scene,
    pub(super) settings: &'a Settings,
    /// The spheres that rays from hits meet; `None` where the kernel shades.
    pub(super) trees: Option<&'a LightSetup>,
    /// The opaque spheres, where some are translucent. The samples then show the opaque ones, with layers over them.
    pub(super) opaque: Option<&'a Opaque>,
}

impl<'a> Sampling<'a> {
    /// The effects that are drawn over the colours; `None` where colour is not requested.
    pub(super) fn finish(&self) -> Option<Finish> {
        self.plan.finish.filter(|_| self.settings.asks(&[Aov::Color]))
    }
}
