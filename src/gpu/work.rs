//! The work of a frame on a device, as the functions that do it state it: `halfline plan` prints it.

use super::Gpu;
use super::compose::{Source, shaders};
use super::input::{Input, KernelRays};
use super::submission_budget::SubmissionBudget;
use super::transfers::{Band, Bands, few_generals, general_lists, most_spheres, uploads};
use crate::certify::ProjectionRecord;
use crate::certify::binned::BinnedScene;
use crate::certify::placing::PlacingRecord;
use crate::kernel::{Generals, Kernel, KernelOutput};
use crate::scene::Scene;
use crate::view::{View, ViewRecord};

/// The work of one pass of a frame.
pub(crate) struct Work {
    /// The shaders, in the order in which they run.
    pub(crate) shaders: Vec<Source>,
    /// The uploads of the first frame: binding name and bytes.
    pub(crate) uploaded: Vec<(&'static str, u64)>,
    /// The buffers that the kernel writes and the host reads, for all pixels: binding name and bytes.
    pub(crate) written: Vec<(&'static str, u64)>,
    pub(crate) dispatches: u64,
    /// The most spheres that the adapter can bind.
    pub(crate) spheres: u64,
}

impl Gpu {
    /// The work of `kernel` for a view of a scene; `binned` as the host would bin it, for a certified kernel.
    pub(crate) fn work(&self, kernel: &Kernel, view: &View, scene: &Scene, binned: Option<&BinnedScene>) -> Work {
        let input = Input { view, colors: scene.spheres.colors.as_deref(), rays: KernelRays::Viewing };
        let mut uploaded = vec![("view", size_of::<ViewRecord>() as u64)];
        if kernel.is_certified() {
            uploaded.push(("projection", size_of::<ProjectionRecord>() as u64));
            uploaded.push(("placing", size_of::<PlacingRecord>() as u64));
            uploaded.push(("resident", size_of::<[f64; 4]>() as u64 * scene.spheres.len() as u64));
            uploaded.extend(binned.into_iter().flat_map(|binned| generals(view, binned)));
        }
        uploaded.extend(uploads(kernel, &input).into_iter().map(|(name, bytes)| (name, bytes.len() as u64)));
        let pixels = view.record.pixels() as u64;
        let bands = || {
            let mut bands = Bands::new(kernel, &input, self.limits.clone());
            std::iter::from_fn(|| bands.next(&SubmissionBudget::default())).count() as u64
        };
        Work {
            shaders: shaders(kernel).into_iter().map(|(_, source)| source).collect(),
            uploaded,
            written: KernelOutput::of(kernel).map(|output| (output.name, pixels * output.bytes())).collect(),
            // The spheres are placed, go over the pixels and are certified in two submissions.
            dispatches: if kernel.is_certified() { 2 } else { bands() },
            spheres: most_spheres(&self.limits, kernel),
        }
    }
}

/// The uploads of general spheres: binding name and bytes.
fn generals(view: &View, binned: &BinnedScene) -> Vec<(&'static str, u64)> {
    match Generals::of(binned.generals.len()) {
        Generals::None => Vec::new(),
        Generals::Few => vec![("generals_uniform", size_of_val(&few_generals(binned)) as u64)],
        Generals::Lists => {
            let band = Band { first: view.record.first_row, count: view.record.rows };
            let (tiles, slots) = general_lists(binned, &band);
            let lists = size_of_val(&tiles[..]) + size_of_val(slots);
            vec![("generals_storage", (size_of_val(&binned.generals[..]) + lists) as u64)]
        }
    }
}
