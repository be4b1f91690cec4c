//! The time of one small frame on a software adapter and on the CPU path, which decides between them. It is measured once
//! per adapter, driver, processor and version, and remembered like the verdict of the self-test.

use super::cache;
use super::twin::cloud;
use crate::answers::raw::Raw;
use crate::certify::binned::{BinnedScene, Binning};
use crate::cpu;
use crate::error::{Error, Result};
use crate::frame::report::{Timings, milliseconds};
use crate::gpu::Gpu;
use crate::gpu::device::{self, AdapterSummary, FoundAdapter};
use crate::gpu::input::{Input, KernelRays, Output};
use crate::intersect::Method;
use crate::kernel::Kernel;
use crate::memory::Pool;
use crate::quote::setting::BACKEND;
use crate::search::tile_candidates::CandidateList;
use crate::settings::Tolerance;
use crate::shade::Shade;
use crate::view::View;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Times of one small certified frame, from candidate lists to its buffers in the host's memory: the least of several, in
/// milliseconds, because other work on the machine only adds to them; medians chose wrongly on a busy one. What comes
/// before and after is the same for both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pace {
    /// By the adapter's kernel.
    pub(crate) adapter_ms: f64,
    /// By the CPU path.
    pub(crate) cpu_ms: f64,
}

/// An adapter is preferred where it takes less than this share of the CPU path's time: noise must not decide otherwise
/// from one machine to the next of the same kind.
const CLEAR: f64 = 0.8;

/// Frames that are timed.
const FRAMES: usize = 15;

/// Spheres of the frame, and pixels along a side.
const SPHERES: u32 = 2000;
const SIDE: u32 = 256;

impl Pace {
    /// The pace of an adapter: known to this process, read from the user's cache, or measured now.
    ///
    /// # Errors
    /// Those of opening and using the device.
    pub(crate) fn of(found: &FoundAdapter) -> Result<Self> {
        // The cache folder may not be writable.
        static KNOWN: Mutex<BTreeMap<String, Pace>> = Mutex::new(BTreeMap::new());
        let key = key(&found.summary);
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pace) = known.get(&key) {
            return Ok(*pace);
        }
        let pace = match cache::read(cache::folder(), cache::PACE, &found.summary, &key) {
            Some(pace) => pace,
            None => Self::measured(&mut Gpu::new(device::open(found)?, found.summary.clone()))?,
        };
        known.insert(key, pace);
        Ok(pace)
    }

    /// The pace of an adapter, measured now and stored in the user's cache.
    ///
    /// # Errors
    /// Those of the device.
    pub(super) fn measured(gpu: &mut Gpu) -> Result<Self> {
        let pace = gpu.guarded(Gpu::pace)?;
        cache::write(cache::folder(), cache::PACE, &gpu.summary, &key(&gpu.summary), &pace);
        Ok(pace)
    }

    /// Whether the adapter is clearly faster than the CPU path.
    pub(crate) fn prefers_adapter(&self) -> bool {
        self.adapter_ms < CLEAR * self.cpu_ms
    }
}

/// Everything that the times depend on.
fn key(adapter: &AdapterSummary) -> String {
    let AdapterSummary { name, backend, driver, .. } = adapter;
    let (processor, threads) = (processor(), rayon::current_num_threads());
    // Without optimisation the CPU path is several times slower, and the adapter is not.
    let build = if cfg!(debug_assertions) { "debug" } else { "release" };
    let version = env!("CARGO_PKG_VERSION");
    format!("{name}, {backend}, {driver}, {processor}, {threads} threads, halfline {version}, {build}")
}

/// The processor's name where the system tells it, else its architecture.
fn processor() -> String {
    let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let model = model.or_else(|| std::env::var("PROCESSOR_IDENTIFIER").ok());
    model.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

impl Gpu {
    /// Measures both. The first frame, which compiles the kernel, is left out.
    fn pace(&mut self) -> Result<Pace> {
        let scene = cloud(SPHERES, SIDE);
        let pool = Pool::default();
        let view = View::new(&scene)?;
        let binned = BinnedScene::new(&Binning::of(&scene, &view, Tolerance::default().relative(), &pool))?;
        let binned = binned.ok_or_else(|| Error::Adapter {
            problem: "the scene of the measurement has no candidate lists".into(),
            mend: format!("use {BACKEND} cpu, and report this as a bug"),
        })?;
        let kernel = Kernel {
            shade: Some(Shade::default()),
            t: true,
            normal: true,
            certify: true,
            depth_interval: true,
            ..Kernel::bare(Method::Stable)
        };
        let on_adapter = self.summary.adapted(kernel, binned.generals.len());
        let mut raw = Raw::new(&kernel, (SIDE * SIDE) as usize, &pool)?;
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..=FRAMES {
            let candidates = Some(CandidateList::Certified(&binned));
            let input = Input { view: &view, colors: None, rays: KernelRays::Viewing, candidates };
            let start = Instant::now();
            let mut output = Output { raw: &mut raw, timings: &mut Timings::default() };
            self.find_winners(&on_adapter, &kernel, &input, &mut output, &pool, &|_| true)?;
            times[0].push(milliseconds(start));
            let start = Instant::now();
            cpu::certified(&kernel, &view, &binned, None, &mut raw, &|| true);
            times[1].push(milliseconds(start));
        }
        let [adapter_ms, cpu_ms] = times.map(|times| least(&times[1..]));
        Ok(Pace { adapter_ms, cpu_ms })
    }
}

/// The least time; infinite for none.
fn least(times: &[f64]) -> f64 {
    times.iter().copied().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_clearly_faster_adapter_is_preferred() {
        for (adapter_ms, cpu_ms, preferred) in [(1.0, 2.0, true), (1.9, 2.0, false), (2.0, 1.0, false)] {
            assert_eq!(Pace { adapter_ms, cpu_ms }.prefers_adapter(), preferred, "{adapter_ms} {cpu_ms}");
        }
        assert!(!Pace { adapter_ms: f64::INFINITY, cpu_ms: f64::INFINITY }.prefers_adapter());
        assert_eq!((least(&[5.0, 1.0, 9.0]), least(&[])), (1.0, f64::INFINITY));
    }

    #[test]
    fn times_depend_on_the_processor_and_the_driver() {
        let adapter = AdapterSummary {
            index: 0,
            name: "an adapter".into(),
            kind: "software",
            backend: "vulkan".into(),
            driver: "driver 1".into(),
            subgroup: None,
            f64: false,
            max_binding: 0,
            max_buffer: 0,
        };
        let text = key(&adapter);
        assert!(text.contains("an adapter") && text.contains("driver 1") && text.contains(&processor()), "{text}");
        assert_ne!(text, key(&AdapterSummary { driver: "driver 2".into(), ..adapter }));
    }

    #[test]
    fn a_frame_of_both_is_timed() {
        let Some(found) = device::find().expect("a known backend").pop() else { return };
        let pace = Gpu::new(device::open(&found).expect("a device"), found.summary).pace().expect("times");
        assert!(pace.adapter_ms > 0.0 && pace.cpu_ms > 0.0, "{pace:?}");
    }
}
