//! Decides what a scene requires: accuracy, method, search, kernel and buffers.

pub(super) mod choose;
pub(super) mod lights;
pub(crate) mod search;

use crate::answers::finish::Finish;
use crate::cpu::light::LightOutputs;
use crate::error::{Error, Result};
use crate::frame::Aov;
use crate::intersect::Method;
use crate::intersect::predict::Prediction;
use crate::kernel::Kernel;
use crate::quote::setting::{ACCURACY, METHOD};
use crate::scene::Scene;
use crate::scene::camera::Lens;
use crate::settings::{Accuracy, Search, Settings};
use crate::shade::Shade;
use search::Device;
use serde::Serialize;

/// The decisions for one scene and its settings, with their reasons.
#[derive(Debug, Clone, Serialize)]
pub struct Plan {
    /// The intersection method; `certified` and `exact` choose their own.
    pub method: &'static str,
    /// The accuracy of the answers: fast, certified or exact.
    pub accuracy: Accuracy,
    /// Why this accuracy and this method.
    pub reason: String,
    /// The predicted worst-case rounding error, where it was computed for the choice.
    pub predicted: Option<Prediction>,
    /// How candidates are found; never `auto`.
    #[serde(serialize_with = "by_name")]
    pub search: Search,
    /// Why this search.
    pub search_reason: &'static str,
    /// What is computed of lights and sky.
    #[serde(skip)]
    pub(crate) wanted: LightOutputs,
    /// What is drawn over the colours.
    #[serde(skip)]
    pub(crate) finish: Option<Finish>,
    #[serde(skip)]
    pub(crate) kernel: Kernel,
    /// The kernel of the samples, with several samples per pixel or where something is drawn over the colours; `kernel` then
    /// computes no colour.
    #[serde(skip)]
    pub(crate) sampled: Option<Kernel>,
}

fn by_name<S: serde::Serializer>(search: &Search, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(search.name())
}

impl Plan {
    /// The shading, if colour is requested.
    pub(crate) fn shade(&self) -> Option<Shade> {
        self.sampled.unwrap_or(self.kernel).shade
    }

    /// Its name: `lights` where the scene's lights or its sky light the picture.
    pub(crate) fn shade_name(&self) -> Option<&'static str> {
        if self.wanted.color { Some("lights") } else { self.shade().map(Shade::name) }
    }

    /// Decides what `scene` requires for the requested buffers, among the methods that `admits` accepts.
    ///
    /// # Errors
    /// [`Error::Settings`] for a method together with a certificate or parallel rays, [`Error::Scene`] for spheres that
    /// exceed the range of one frame.
    pub fn new(scene: &Scene, settings: &Settings, admits: &mut dyn FnMut(Method) -> bool) -> Result<Self> {
        if settings.search == Search::Tree {
            return Err(search::only_given_rays());
        }
        let mut plan = Self::for_method(settings)?;
        let (silhouette, depth_cue) = (settings.silhouette, settings.depth_cue);
        // Touching spheres of flat colours would run into each other.
        let between = settings.shade == Shade::Flat;
        plan.finish = (silhouette || depth_cue).then_some(Finish { silhouette, between, depth_cue });
        plan.wanted = lights::wanted(scene, settings);
        let shade = Some(settings.shade).filter(|_| settings.asks(&[Aov::Color]) && !plan.wanted.color);
        plan.kernel.shade = shade;
        plan.kernel.colors = scene.spheres.colors.is_some() && shade.is_some_and(Shade::needs_colors);
        plan.kernel.t = settings.asks(&[Aov::Distance, Aov::Depth, Aov::Position]);
        plan.kernel.normal = settings.asks(&[Aov::Normal]);
        let choice = choose::choose(scene, settings, admits)?;
        plan.kernel.method = choice.method;
        (plan.accuracy, plan.method) = (choice.accuracy, choice.method.name());
        (plan.reason, plan.predicted) = (choice.reason, choice.predicted);
        if matches!(plan.accuracy, Accuracy::Certified | Accuracy::Exact) {
            plan.method = plan.accuracy.name();
            plan.kernel.certify = true;
            plan.kernel.depth_interval = settings.asks(&[Aov::Bound]);
            plan.kernel.starts = lights::leave_hits(plan.wanted, scene);
        }
        (plan.search, plan.search_reason) =
            search::for_viewing_rays(settings.search, plan.kernel.certify, scene.spheres.len());
        // Its pixels are those of a finer or larger frame.
        plan.kernel.samples = matches!(scene.camera.lens, Lens::Intrinsics { .. });
        plan.kernel.tiles = !plan.kernel.certify && plan.search == Search::Tiles;
        let finished = plan.finish.is_some() && settings.asks(&[Aov::Color]);
        // A sky at the centres of pixels is known before the colours.
        let shared = plan.wanted.color && scene.lighting.sky.is_some_and(|sky| sky.at_centers);
        if finished || shared || settings.samples > 1 && settings.asks(&[Aov::Color, Aov::Alpha]) {
            let alone = shared && settings.aperture.is_none() && !scene.lighting.shadows;
            plan.sampled = Some(Kernel {
                samples: true,
                t: false,
                normal: false,
                depth_interval: false,
                starts: plan.kernel.starts && !alone,
                ..plan.kernel
            });
            (plan.kernel.shade, plan.kernel.colors) = (None, false);
        }
        Ok(plan)
    }

    /// What the settings alone decide: a kernel that writes only ids.
    pub(crate) fn for_method(settings: &Settings) -> Result<Self> {
        let promised = matches!(settings.accuracy, Accuracy::Certified | Accuracy::Exact);
        if let (Some(method), true) = (settings.method, promised) {
            let problem = format!(
                "method {} is uncertified, so the accuracy cannot be {}",
                method.name(),
                settings.accuracy.name()
            );
            return Err(Error::settings(problem, format!("remove {METHOD} or {ACCURACY}")));
        }
        let method = settings.method.unwrap_or(Method::Stable);
        let kernel = Kernel::bare(method);
        let (method, accuracy, search) = (method.name(), Accuracy::Fast, Search::All);
        let (reason, search_reason) = (String::new(), "");
        Ok(Self {
            method,
            accuracy,
            reason,
            predicted: None,
            search,
            search_reason,
            wanted: LightOutputs::default(),
            finish: None,
            kernel,
            sampled: None,
        })
    }

    /// The plan on a device.
    ///
    /// # Errors
    /// [`Error::Settings`] where it cannot search as requested.
    pub(crate) fn on(self, device: Device, settings: &Settings) -> Result<Self> {
        let planned = (self.search, self.search_reason);
        let (search, search_reason) = search::on_device(settings.search, self.kernel.certify, device, planned)?;
        Ok(Self { search, search_reason, ..self })
    }

    /// The same plan by tiles, where a device leaves the search to lists.
    pub(crate) fn by_tiles(self, reason: &'static str) -> Self {
        Self { search: Search::Tiles, search_reason: reason, ..self }
    }

    /// The same plan without tiles, where the spheres cannot be binned into them.
    pub(crate) fn without_tiles(self) -> Self {
        let without = |kernel: Kernel| Kernel { tiles: false, ..kernel };
        let (kernel, sampled) = (without(self.kernel), self.sampled.map(without));
        Self { search: Search::All, search_reason: search::NO_LENS, kernel, sampled, ..self }
    }
}

/// The decisions for given rays.
#[derive(Debug, Clone)]
pub(crate) struct GivenPlan {
    pub(crate) accuracy: Accuracy,
    pub(crate) method: &'static str,
    /// Tree or all.
    pub(crate) search: Search,
    /// What a method computes; normals are requested of certified answers too.
    pub(crate) kernel: Kernel,
}

impl GivenPlan {
    /// Without a method answers are certified unless the accuracy is fast: what rays hit is data, not a picture.
    ///
    /// # Errors
    /// [`Error::Settings`] for a method together with a certificate, and for a search that does not apply;
    /// [`Error::Limits`] for too many spheres.
    pub(crate) fn new(settings: &Settings, spheres: usize) -> Result<Self> {
        let base = Plan::for_method(settings)?;
        let kernel = Kernel { t: true, normal: settings.aovs.contains(&Aov::Normal), ..base.kernel };
        let accuracy = match settings.accuracy {
            Accuracy::Auto if settings.method.is_none() => Accuracy::Certified,
            Accuracy::Auto => Accuracy::Fast,
            requested => requested,
        };
        let method = if accuracy == Accuracy::Fast { base.method } else { accuracy.name() };
        let search = search::for_given_rays(settings.search, accuracy == Accuracy::Fast, spheres)?;
        Ok(Self { accuracy, method, search, kernel })
    }

    /// Whether the answers are proved.
    pub(crate) fn certifies(&self) -> bool {
        matches!(self.accuracy, Accuracy::Certified | Accuracy::Exact)
    }
}
