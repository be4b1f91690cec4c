//! The report of `halfline plan` for a curved lens, whose viewing rays are given rays.

use super::explanation::{Explanation, LeftOut, Room, ShaderFile};
use crate::error::{Error, Result};
use crate::gpu::compose::{Source, compose};
use crate::kernel::{Kernel, RaySource, Task};
use crate::memory;
use crate::quote::setting::ACCURACY;
use crate::render::curved::{BLOCK, CurvedPlan};
use crate::render::renderer::Renderer;
use crate::scene::Scene;
use crate::settings::Settings;

impl Renderer {
    /// [`Renderer::explain`] for a curved lens.
    pub(super) fn explain_curved(&mut self, scene: &Scene, settings: &Settings) -> Result<Explanation> {
        let plan = self.curved_plan(scene, settings)?;
        let (passes, is_gpu) = (plan.samples.map_or(1, |raster| 1 + raster.count()), plan.report.backend == "gpu");
        let source = source(&plan).filter(|_| is_gpu);
        let CurvedPlan { window, report, need, .. } = plan;
        let mut left_out = vec![LeftOut {
            what: "lights, sky and lines",
            why: "they need a perspective or orthographic camera; the light is at the eye".to_owned(),
        }];
        if !is_gpu {
            let why = if report.accuracy == "exact" {
                "exact answers are computed on the CPU"
            } else {
                "the CPU path traces the rays"
            };
            left_out.insert(0, LeftOut { what: "device", why: why.to_owned() });
        }
        let precision = match report.accuracy {
            "exact" => "double-double and exact integers on the CPU, every ray",
            "certified" if is_gpu => {
                "f32 with an error bound decides what is hit, f64 where; unsure rays are settled in exact arithmetic"
            }
            "certified" => "f32 and f64 with error bounds; unsure rays are settled in exact arithmetic",
            _ => "the method's own, without a bound",
        };
        let search_reason = match report.search {
            "tree" => "a tree of boxes finds the spheres that a ray may hit",
            _ => "every ray tests every sphere",
        };
        let free = memory::free(&self.pool);
        let of_report = Explanation::of_report(report, scene, settings, window)?;
        Ok(Explanation {
            precision: format!("{precision}; rays are those of the lens in f64, and exact from there on"),
            search_reason: search_reason.to_owned(),
            kernel: source.iter().flat_map(Source::files).map(|(file, lines)| ShaderFile { file, lines }).collect(),
            dispatches: source.map_or(0, |_| of_report.rays.div_ceil(BLOCK as u64) * u64::from(passes)),
            left_out,
            room: Room { needed: need, free, ..of_report.room },
            ..of_report
        })
    }

    /// [`Renderer::wgsl`] for a curved lens.
    pub(super) fn wgsl_of_rays(&mut self, scene: &Scene, settings: &Settings) -> Result<String> {
        let plan = self.curved_plan(scene, settings)?;
        let source = source(&plan).ok_or_else(|| {
            let problem = "exact answers are computed on the CPU without a kernel";
            Error::settings(problem, format!("use another {ACCURACY} or camera"))
        })?;
        Ok(format!("// given rays\n\n{}", source.with_banners()))
    }
}

/// The shader of the rays; `None` where no kernel runs.
fn source(plan: &CurvedPlan) -> Option<Source> {
    let task = match plan.kernel.task {
        Task::Method { method, .. } => Task::Method { method, rays: RaySource::SharedOrigin },
        task => task,
    };
    (plan.report.accuracy != "exact").then(|| compose(&Kernel { task, ..plan.kernel }))
}
