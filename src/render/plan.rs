//! Decides what a scene requires: accuracy, method, search, kernel and buffers.

pub(super) mod choose;
pub(crate) mod kind;
pub(super) mod lights;

use crate::answers::finish::Finish;
use crate::answers::silhouette::Line;
use crate::cpu::light::LightOutputs;
use crate::frame::Aov;
use crate::intersect::Method;
use crate::intersect::predict::Prediction;
use crate::kernel::{Certificate, Kernel, Task, Unproved};
use crate::scene::Scene;
use crate::scene::camera::{CURVED, Lens};
use crate::settings::{Accuracy, Search, Settings};
use crate::shade::Shade;
use choose::Choice;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::{ACCURACY, APERTURE, METHOD};
use kind::EngineKind;

/// The decisions for one scene and its settings, with their reasons.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The intersection method; `certified` and `exact` choose their own.
    pub method: &'static str,
    /// The accuracy of the answers: fast, certified or exact.
    pub accuracy: Accuracy,
    /// The reason for this accuracy and this method.
    pub reason: String,
    /// The predicted worst-case rounding error, where it was computed for the choice.
    pub predicted: Option<Prediction>,
    /// The engine that finds the first hits.
    pub engine: EngineKind,
    /// The decisions for the rays of a curved lens, which are given rays.
    pub(crate) given: Option<GivenPlan>,
    /// The outputs of lights and sky that are computed.
    pub(crate) light_outputs: LightOutputs,
    /// The picture shows something through translucent spheres.
    pub(crate) see_through: bool,
    /// The lists of spheres serve the hits behind the first too, and keep what translucent spheres hide.
    pub(crate) is_deep: bool,
    /// The effects that are drawn over the colours; `None` without any.
    pub(crate) finish: Option<Finish>,
    pub(crate) kernel: Kernel,
    /// The kernel of the samples, with several samples per pixel or where something is drawn over the colours; `kernel` then
    /// computes no colour.
    pub(crate) sampled: Option<Kernel>,
}

impl Plan {
    /// The shading, if colour is requested.
    pub(crate) fn shade(&self) -> Option<Shade> {
        self.sampled.unwrap_or(self.kernel).shade
    }

    /// The name of the shading: `lights` where the scene's lights or its sky light the picture.
    pub(crate) fn shade_name(&self) -> Option<&'static str> {
        if self.light_outputs.color { Some("lights") } else { self.shade().map(Shade::name) }
    }

    /// Decides what `scene` requires for the requested buffers, among the methods that `admits` accepts.
    ///
    /// # Errors
    /// [`Error::Settings`] for a method together with a certificate or parallel rays, and for a curved lens with a size; [`Error::Scene`]
    /// for spheres that exceed the range of one frame.
    pub fn new(scene: &Scene, settings: &Settings, admits: &mut dyn FnMut(Method) -> bool) -> Result<Self> {
        let mut plan = match scene.camera.lens.is_curved() {
            true => Self::of_given_rays(scene, settings)?,
            false => Self::of_view(scene, settings, admits)?,
        };
        let (silhouette, depth_cue) = (settings.silhouette, settings.cue_strength());
        // Touching spheres of flat colours would run into each other.
        let between = settings.shade == Shade::Flat;
        let line = silhouette.then(|| Line::new(settings.outline));
        plan.finish = (silhouette || depth_cue.is_some()).then_some(Finish { line, between, depth_cue });
        plan.light_outputs = lights::outputs(scene, settings);
        plan.see_through = settings.asks(&[Aov::Color, Aov::Alpha]) && scene.spheres.is_translucent();
        let shade = Some(settings.shade).filter(|_| settings.asks(&[Aov::Color]) && !plan.light_outputs.color);
        plan.kernel.shade = shade;
        let has_colors = shade.is_some_and(Shade::needs_colors);
        plan.kernel.face_colors = has_colors && scene.spheres.cuts.as_ref().is_some_and(|cuts| cuts.colors.is_some());
        plan.kernel.colors = has_colors && scene.spheres.colors.is_some() || plan.kernel.face_colors;
        plan.kernel.t = settings.asks(&[Aov::Distance, Aov::Depth, Aov::Position]);
        plan.kernel.t |= plan.given.is_some() && settings.asks(&[Aov::Bound]);
        plan.kernel.normal = settings.asks(&[Aov::Normal]);
        // Its pixels belong to a finer or larger frame.
        plan.kernel.samples = matches!(scene.camera.lens, Lens::Intrinsics { .. });
        plan.sampled = plan.kernel_of_samples(scene, settings);
        if plan.sampled.is_some() {
            plan.kernel = Kernel { shade: None, colors: false, face_colors: false, ..plan.kernel };
        }
        // A method takes spheres for whole.
        if scene.spheres.cuts.is_some() && plan.accuracy == Accuracy::Fast {
            return Err(choose::cut_by_method());
        }
        Ok(plan)
    }

    /// The plan for viewing rays through a plane, as far as hits go.
    fn of_view(scene: &Scene, settings: &Settings, admits: &mut dyn FnMut(Method) -> bool) -> Result<Self> {
        let plan = Self::for_method(settings)?;
        let Choice { accuracy, method, reason, predicted } = choose::choose(scene, settings, admits)?;
        let (engine, name, task) = match method {
            Some(method) => {
                kind::check_method(scene.spheres.len())?;
                (EngineKind::Method, method.name(), Kernel::of_method(method).task)
            }
            None => {
                let promised = accuracy != Accuracy::Fast;
                let certificate = Certificate {
                    unproved: if promised { Unproved::Unsure } else { Unproved::Nearest },
                    depth_interval: promised && settings.asks(&[Aov::Bound]),
                    starts: promised && lights::leave_hits(lights::outputs(scene, settings), scene),
                    planes: scene.spheres.cuts.is_some(),
                    ..Certificate::PLAIN
                };
                let engine = if accuracy == Accuracy::Exact { EngineKind::Judge } else { EngineKind::Strips };
                (engine, accuracy.name(), Task::Certified(certificate))
            }
        };
        let kernel = Kernel { task, ..plan.kernel };
        Ok(Self { accuracy, reason, predicted, engine, method: name, kernel, ..plan })
    }

    /// The plan for the viewing rays of a curved lens, as far as hits go.
    fn of_given_rays(scene: &Scene, settings: &Settings) -> Result<Self> {
        if settings.aperture.is_some() {
            let problem =
                format!("a lens with a size has the rays of a perspective camera, and this lens has {CURVED}");
            return Err(Error::settings(problem, format!("remove {APERTURE}, or the aperture of the file")));
        }
        let given = GivenPlan::new(settings, scene.spheres.len())?;
        let reason = match given.accuracy {
            Accuracy::Exact => "every ray of a curved lens is decided in exact arithmetic",
            Accuracy::Fast => "the rays of a curved lens are given rays, which a method does not prove",
            _ => "the rays of a curved lens are given rays, which a tree certifies",
        };
        let tree = given.search == Search::Tree;
        let base = Self::for_method(settings)?;
        Ok(Self {
            method: given.method,
            accuracy: given.accuracy,
            reason: reason.to_owned(),
            engine: EngineKind::Given { tree },
            kernel: Kernel { task: Task::Given, ..base.kernel },
            given: Some(given),
            ..base
        })
    }

    /// The kernel of the samples, where the colours need passes of their own: several samples, effects over the colours, the sky, whose
    /// open share is known before them, and translucent spheres.
    fn kernel_of_samples(&self, scene: &Scene, settings: &Settings) -> Option<Kernel> {
        let finished = self.finish.is_some() && settings.asks(&[Aov::Color]);
        let sky = scene.lighting.sky.filter(|_| self.light_outputs.color);
        let counted = settings.asks(&[Aov::Color, Aov::Alpha]) || settings.coverage;
        let several = settings.samples > 1 && counted;
        if !(finished || sky.is_some() || several || self.see_through) {
            return None;
        }
        let at_centers = sky.is_some_and(|sky| settings.sky_at_centers(sky));
        // Through translucent spheres the host traces the rays from hits.
        let alone = at_centers && !scene.lighting.shadows || self.see_through;
        let kernel = Kernel { samples: true, t: false, normal: false, ..self.kernel };
        let of_sample = |of: Certificate| Certificate { depth_interval: false, starts: of.starts && !alone, ..of };
        Some(kernel.certified_by(of_sample))
    }

    /// The plan that follows from the settings alone: their method, or `stable`, with a kernel that writes only ids.
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
        Ok(Self {
            method: method.name(),
            accuracy: Accuracy::Fast,
            reason: String::new(),
            predicted: None,
            engine: EngineKind::Method,
            given: None,
            light_outputs: LightOutputs::default(),
            see_through: false,
            is_deep: false,
            finish: None,
            kernel: Kernel::of_method(method),
            sampled: None,
        })
    }

    /// Whether its rays are given ones, which the host certifies.
    pub(crate) fn certifies_given(&self) -> bool {
        self.given.as_ref().is_some_and(GivenPlan::certifies)
    }

    /// Whether the judge decides only the pixels that the engine does not prove.
    pub(crate) fn proves(&self) -> bool {
        self.accuracy == Accuracy::Certified && self.engine != EngineKind::Judge
    }

    /// The same plan on a device, which has its own engine for certified kernels.
    pub(crate) fn on_device(self) -> Self {
        let engine = if self.engine == EngineKind::Strips { EngineKind::Resident } else { self.engine };
        Self { engine, ..self }
    }
}

/// The decisions for given rays.
#[derive(Debug, Clone)]
pub(crate) struct GivenPlan {
    pub(crate) accuracy: Accuracy,
    pub(crate) method: &'static str,
    /// Tree or all.
    pub(crate) search: Search,
    /// The kernel of a method. Its flag of normals also applies to certified answers.
    pub(crate) kernel: Kernel,
}

impl GivenPlan {
    /// The plan for given rays. Without a method answers are certified unless the accuracy is fast, since the hits of
    /// given rays are data, not a picture.
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
        let search = kind::for_given_rays(settings.search, accuracy == Accuracy::Fast, spheres)?;
        Ok(Self { accuracy, method, search, kernel })
    }

    /// Whether the answers are proved.
    pub(crate) fn certifies(&self) -> bool {
        matches!(self.accuracy, Accuracy::Certified | Accuracy::Exact)
    }
}
