//! The times of frames, and the memory that they take.

use super::Result;
use super::scenes::{Times, looked, report_json};
use glam::{DMat3, DVec3};
use halfline::{Backend, Look, Renderer, Scene, Settings};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Instant;

/// The first frame, the second, frames from one camera, and frames whose camera goes round the cloud.
pub(crate) fn frames(count: usize, look: &str, side: u32, many: usize, backend: Backend, seconds: f64) -> Result {
    let (scene, settings) = looked(count, look, side, backend)?;
    let mut renderer = Renderer::new(&settings)?;
    let mut one = || -> Result {
        let frame = renderer.render(&scene, &settings)?;
        let mut report = report_json(&frame);
        (report["frame_ms"], report["setup_ms"]) = (json!(frame.report.frame_ms[0]), json!(frame.report.setup_ms));
        renderer.recycle(frame);
        Ok(report)
    };
    let (first, second) = (one()?, one()?);
    let (steady, last) = series(&mut renderer, &settings, many, seconds / 2.0, |_| scene.clone())?;
    let (moving, _) = series(&mut renderer, &settings, many, seconds / 2.0, |n| turned(&scene, n))?;
    Ok(json!({
        "spheres": count, "look": look, "side": side, "backend": backend.name(),
        "shader_cache": std::env::var_os("MESA_SHADER_CACHE_DISABLE").is_none(), "first": first,
        "second_ms": second["frame_ms"], "steady": steady, "moving": moving, "last": last, "host_mib": peak_memory(),
        "device_mib": device_memory(),
    }))
}

/// View `n` from a camera that goes round the cloud.
fn turned(scene: &Scene, n: usize) -> Scene {
    let mut turned = scene.clone();
    let (middle, angle) = (DVec3::splat(0.5), 0.02 * (n + 1) as f64);
    turned.camera.eye = middle + DMat3::from_rotation_y(angle) * (scene.camera.eye - middle);
    turned
}

/// A film round the cloud: one frame after the other, and two in flight.
pub(crate) fn films(count: usize, look: &str, side: u32, many: usize) -> Result {
    let (scene, settings) = looked(count, look, side, Backend::Gpu)?;
    let renderer = Renderer::new(&settings)?;
    let mut two = [renderer.another(), renderer];
    // First frames compile.
    film_by(&mut two, &scene, &settings, 4)?;
    let in_turn = film_by(&mut two[..1], &scene, &settings, many)?;
    let in_flight = film_by(&mut two, &scene, &settings, many)?;
    let (host_mib, device_mib) = (peak_memory(), device_memory());
    Ok(json!({
        "spheres": count, "look": look, "side": side, "frames": many, "in_turn": in_turn, "in_flight": in_flight,
        "host_mib": host_mib, "device_mib": device_mib,
    }))
}

/// The time of a frame of a film that these renderers make together, and the mean share of it in which the device has work.
fn film_by(renderers: &mut [Renderer], scene: &Scene, settings: &Settings, many: usize) -> Result<Value> {
    let (next, started) = (AtomicUsize::new(0), Instant::now());
    let work = |renderer: &mut Renderer| -> halfline::Result<Times> {
        let mut times = Times::default();
        loop {
            let n = next.fetch_add(1, Ordering::Relaxed);
            if n >= many {
                return Ok(times);
            }
            let frame = renderer.render(&turned(scene, n), settings)?;
            times.add(&frame);
            renderer.recycle(frame);
        }
    };
    let parts: Vec<_> = thread::scope(|scope| {
        let threads: Vec<_> = renderers.iter_mut().map(|renderer| scope.spawn(|| work(renderer))).collect();
        threads.into_iter().map(|thread| thread.join().map_err(|_| "a renderer panicked")).collect()
    });
    let frame_ms = started.elapsed().as_secs_f64() * 1e3 / many as f64;
    let mut all = Times::default();
    for part in parts {
        all.join(part??);
    }
    Ok(json!({ "frame_ms": frame_ms, "busy": all.busy() }))
}

/// The medians of up to `many` frames in some seconds, and what the last one reports.
fn series(
    renderer: &mut Renderer,
    settings: &Settings,
    many: usize,
    seconds: f64,
    mut scene: impl FnMut(usize) -> Scene,
) -> Result<(Value, Value)> {
    let (mut times, mut last, started) = (Times::default(), Value::Null, Instant::now());
    for n in 0..many {
        let frame = renderer.render(&scene(n), settings)?;
        times.add(&frame);
        last = report_json(&frame);
        renderer.recycle(frame);
        if started.elapsed().as_secs_f64() > seconds {
            break;
        }
    }
    Ok((times.medians(), last))
}

/// The eye in the middle of a cloud.
pub(crate) fn inside(count: usize) -> Result {
    let (mut scene, settings) = looked(count, "plain", 1024, Backend::Gpu)?;
    scene.camera.look = Look::At(DVec3::ZERO);
    let mut renderer = Renderer::new(&settings)?;
    let mut eye = DVec3::splat(0.5);
    let mut at = |step: f64| {
        eye += step * DVec3::new(0.003, 0.001, 0.0);
        scene.camera.eye = eye;
        scene.clone()
    };
    series(&mut renderer, &settings, 1, f64::INFINITY, |_| at(0.0))?;
    let (times, last) = series(&mut renderer, &settings, 5, f64::INFINITY, |n| at(n as f64))?;
    Ok(json!({ "spheres": count, "times": times, "last": last }))
}

/// Spheres that move: the device takes all of them for every frame.
pub(crate) fn film(count: usize, many: usize) -> Result {
    let (mut scene, settings) = looked(count, "plain", 1024, Backend::Gpu)?;
    let mut renderer = Renderer::new(&settings)?;
    let mut moved = |n: usize| {
        let mut centers = scene.spheres.centers.clone().into_vec();
        centers.iter_mut().for_each(|center| center[n % 3] += 1e-4);
        scene.spheres.centers = centers.into();
        scene.spheres.share();
        scene.clone()
    };
    series(&mut renderer, &settings, 1, f64::INFINITY, &mut moved)?;
    let (times, last) = series(&mut renderer, &settings, many, f64::INFINITY, &mut moved)?;
    Ok(json!({ "spheres": count, "times": times, "last": last }))
}

/// The most memory that this process had, MiB.
fn peak_memory() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().trim_end_matches(" kB").trim().parse::<f64>().ok()? / 1024.0)
}

/// Memory in use on the device, MiB: of all processes as nvidia-smi reports it, else of this one as the kernel does.
fn device_memory() -> Option<f64> {
    let query = ["--query-gpu=memory.used", "--format=csv,noheader,nounits", "--id=0"];
    if let Ok(output) = Command::new("nvidia-smi").args(query).output()
        && output.status.success()
    {
        return String::from_utf8_lossy(&output.stdout).trim().parse().ok();
    }
    // A device is opened more than once: its regions are counted once each.
    let mut regions = BTreeMap::<String, f64>::new();
    for entry in std::fs::read_dir("/proc/self/fdinfo").ok()?.flatten() {
        for line in std::fs::read_to_string(entry.path()).unwrap_or_default().lines() {
            if let Some((name, kib)) = line.split_once(':').filter(|(name, _)| name.starts_with("drm-total")) {
                let kib: f64 = kib.trim().trim_end_matches(" KiB").trim().parse().unwrap_or(0.0);
                let most = regions.entry(name.to_owned()).or_default();
                *most = most.max(kib / 1024.0);
            }
        }
    }
    (!regions.is_empty()).then(|| regions.values().sum())
}
