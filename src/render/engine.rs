//! The engines: each finds what the viewing rays of a view hit first. What follows does not ask which one it was.

mod given;
mod judge;
mod method;
mod resident;
mod strips;

use super::rendering::Rendering;
use crate::answers::layers::Layers;
use crate::answers::raw::Raw;
use crate::answers::settle::{self, Settled};
use crate::certify::binned::BinnedScene;
use crate::certify::cut::SHARP;
use crate::certify::placing::Placer;
use crate::frame::Aov;
use crate::kernel::Kernel;
use crate::scene::Scene;
use crate::view::View;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::progress::Step;

pub(super) use given::{BLOCK, GivenRays};
pub(super) use judge::Exact;
pub(super) use method::EverySphere;
pub(super) use resident::Resident;
pub(super) use strips::Strips;

/// The viewing rays of one sample of each pixel of a view, and what a kernel computes of their hits.
#[derive(Clone, Copy)]
pub(super) struct ViewRays<'a> {
    pub(super) scene: &'a Scene,
    pub(super) view: &'a View,
    pub(super) kernel: &'a Kernel,
}

/// The answer of an engine.
pub(super) enum Found {
    /// The hits are written; the hits of these pixels were decided in exact arithmetic, and their answers come from here.
    Hits(Vec<Settled>),
    /// The device leaves the frame to the host, for this reason.
    Left(String),
}

/// A way to find first hits, with its data for one view.
pub(super) trait Engine {
    /// Writes the first hits of the rays to `raw`, with the outputs of their kernel.
    ///
    /// # Errors
    /// Errors of a device and of the judge; [`crate::Error::Interrupted`].
    fn first_hits(&mut self, at: &mut Rendering<'_>, rays: ViewRays<'_>, raw: &mut Raw) -> Result<Found>;

    /// The translucent hits behind the first ones, up to the opaque ones: layer by layer, of each pixel the sphere, [`NONE`](crate::view::ray::NONE) where there
    /// is none.
    ///
    /// # Errors
    /// Errors of the judge; [`crate::Error::Interrupted`].
    fn behind(&mut self, at: &mut Rendering<'_>, rays: ViewRays<'_>, layers: Layers<'_>) -> Result<Vec<Vec<u32>>> {
        layers.judged(rays.scene, rays.view, &at.renderer.watch)
    }

    /// The spheres as the host binned them, if it did.
    fn binned(&self) -> Option<&BinnedScene> {
        None
    }

    /// The host's part in placing the spheres that a device holds, if one does.
    fn placer(&self) -> Option<&Placer> {
        None
    }

    /// Returns its memory to the pool for the next frame.
    fn put_back(self: Box<Self>, _: &Pool) {}
}

/// Decides the unsure pixels among spheres that are binned.
fn settle(
    Rendering { renderer, settings, log, .. }: &mut Rendering<'_>,
    ViewRays { scene, view, kernel }: ViewRays<'_>,
    binned: &BinnedScene,
    raw: &Raw,
) -> Result<Vec<Settled>> {
    let unsure = log.time("settle", || settle::unsure(&raw.id));
    if unsure.is_empty() {
        return Ok(Vec::new());
    }
    let doing = renderer.watch.begin(Step::Settle, unsure.len() as u64);
    let sharp = match kernel {
        // The bound of a settled distance is the bound of the judge's distance.
        _ if settings.asks(&[Aov::Bound]) => 0.0,
        _ if !(kernel.t || kernel.normal || kernel.shade.is_some()) => f64::INFINITY,
        _ => SHARP.min(0.25 * settings.promise().relative()),
    };
    let settled = log.time("settle", || settle::settle(scene, view, binned, (&unsure, sharp), &|| doing.next(1)));
    doing.end()?;
    settled
}
