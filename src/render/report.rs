//! The report of a frame: what the plan decided, and what its passes logged.

use super::missed::missed;
use super::plan::Plan;
use super::rendering::Rendering;
use super::setup::FrameSetup;
use crate::cpu;
use crate::frame::coverage::Coverage;
use crate::frame::report::{Report, milliseconds};
use crate::frame::{Aov, Buffer, Data, Frame};
use crate::gpu::traffic::Traffic;
use crate::scene::camera::CameraRecord;
use crate::settings::{Accuracy, DEPTH_CUE};
use halfline_ground::error::Result;
use halfline_ground::parallel;

/// The report of a frame before it is computed: the decisions of the plan; counts and times are 0 or empty.
pub(super) fn known(at: &Rendering<'_>, plan: &Plan) -> Report {
    let Rendering { renderer, scene, settings, rays, log, .. } = at;
    let on_device = renderer.is_gpu() && log.refused.is_none();
    let idle = settings.idle_layers().filter(|_| !plan.see_through).chain(settings.idle_plastic(scene));
    Report {
        schema: "halfline-render",
        version: 1,
        halfline: env!("CARGO_PKG_VERSION"),
        spheres: scene.spheres.len() as u64,
        spheres_cut: Some(0),
        spheres_removed: Some(0),
        adapter: if on_device { renderer.adapter() } else { cpu::NAME }.to_owned(),
        driver: if on_device { renderer.driver() } else { cpu::driver() },
        backend: if on_device { "gpu" } else { "cpu" },
        backend_reason: renderer.backend_reason().to_owned(),
        method: plan.method,
        accuracy: plan.accuracy.name(),
        reason: plan.reason.clone(),
        shade: plan.shade_name(),
        search: plan.engine.name(),
        samples: rays.samples.map_or(1, |raster| raster.count()),
        camera: CameraRecord::new(&scene.camera, [scene.image.width, scene.image.height], settings.aperture).ok(),
        lights: scene.lighting.lights.len() as u64,
        occlusion: settings.sky(scene),
        silhouette: settings.silhouette,
        outline: settings.silhouette.then_some(settings.outline),
        depth_cue: settings.depth_cue,
        depth_cue_strength: settings.cue_strength().filter(|strength| *strength != DEPTH_CUE),
        layers: plan.see_through.then(|| settings.layers.max(1)),
        opacity_shadows: plan.see_through && settings.opacity_shadows,
        ghost_rim: plan.see_through && settings.ghost_rim,
        tone: settings.asks(&[Aov::Color]).then(|| settings.toning(scene).tone),
        exposure: settings.exposure,
        setup_ms: renderer.setup_ms,
        warnings: renderer.device.passed_over.iter().cloned().chain(idle).collect(),
        ..Report::default()
    }
}

/// The frame of these buffers, with its report. So many of its pixels were settled.
pub(super) fn complete(
    at: Rendering<'_>,
    setup: FrameSetup,
    settled: usize,
    buffers: Vec<Buffer>,
    coverage: Option<Coverage>,
) -> Result<Frame> {
    let (known, scene) = (known(&at, &setup.plan), at.scene);
    let Rendering { renderer, settings, rays, pool, mut log, start, .. } = at;
    let promised = setup.plan.accuracy != Accuracy::Fast;
    let predicted = if promised { None } else { log.time("predict", || setup.predicted(scene)) };
    let pixels = setup.view.record.pixels();
    let hits = buffers.iter().map(hits).sum();
    let proved = (pixels - settled) as f64 / pixels as f64;
    let missed = (hits == 0).then(|| missed(scene, settings.window)).flatten();
    let warnings =
        known.warnings.into_iter().chain(setup.warnings(scene, predicted)).chain(log.warnings()).chain(missed);
    let mut report = Report {
        rays: pixels as u64,
        hits,
        settled: settled as u64,
        certified: if setup.plan.proves() { proved } else { 0.0 },
        bound: promised.then(|| bound(&buffers, settings.promise().relative())),
        predicted,
        warnings: warnings.collect(),
        light_on_device: log.light_on_device(),
        ..known
    };
    report.stages_ms = log.timings.into_map();
    report.frame_ms = vec![milliseconds(start)];
    let Traffic { busy, kernel_ms, up, down } = renderer.traffic().unwrap_or_default();
    report.host_ms = report.frame_ms.iter().map(|whole| (whole - busy.as_secs_f64() * 1e3).max(0.0)).collect();
    (report.bytes_up, report.bytes_down) = (up, down);
    report.kernel_ms = kernel_ms.into_iter().collect();
    setup.put_back(&pool);
    let (window, full) = (rays.window, [scene.image.width, scene.image.height]);
    Ok(Frame { width: window.width(), height: window.height(), window, full, buffers, coverage, report })
}

/// The number of hits in the buffer of ids; 0 in any other.
fn hits(buffer: &Buffer) -> u64 {
    match &buffer.data {
        Data::I32(ids) => parallel::count(ids.len(), |n| ids[n] >= 0) as u64,
        Data::I64(ids) => parallel::count(ids.len(), |n| ids[n] >= 0) as u64,
        _ => 0,
    }
}

/// The largest proven relative error of the distance, where it is requested; else the promised tolerance.
fn bound(buffers: &[Buffer], promised: f64) -> f64 {
    let values = |aov: Aov| buffers.iter().find(|b| b.aov == aov).map(|b| &b.data);
    match (values(Aov::Bound), values(Aov::Distance)) {
        (Some(Data::F64(bounds)), Some(Data::F64(distances))) => {
            bounds.iter().zip(distances).map(|(b, d)| b / d).fold(0.0, f64::max)
        }
        _ => promised,
    }
}
