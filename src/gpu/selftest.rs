//! Measures the arithmetic of an adapter. WGSL guarantees little: rounding direction is unspecified, reassociation and
//! fusion are allowed, subnormals may be flushed, and drivers make use of this. A method that needs more than the
//! guarantee runs only after this test has passed for the same adapter, driver and shader text.

mod cache;
mod cases;
mod judge;
#[cfg(test)]
mod tests;
mod twin;
pub(super) mod verdict;

pub use verdict::{Check, Rounding, Usable, Verdict};

use crate::frame::report::milliseconds;
use crate::gpu::Gpu;
use crate::gpu::compose::{Part, Source, Step, binding_numbers, compose, compose_step, files};
use crate::intersect::Method;
use crate::view::ViewRecord;
use bytemuck::Zeroable;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::{BACKEND, METHOD};
use naga::valid::Capabilities;
use web_time::Instant;

/// Evaluates the cases and answers of a trial.
type Evaluate = fn(&[u32], &[u32]) -> Vec<Check>;

/// One shader of the test, its cases and the function that evaluates its answers.
pub(super) struct Trial {
    pub(super) name: &'static str,
    pub(super) parts: Vec<Part>,
    capabilities: Capabilities,
    /// 32-bit words per case and per answer; the shader declares them in its own number type.
    words: [usize; 2],
    cases: Vec<u32>,
    judge: Evaluate,
}

/// The trials for an adapter with or without f64.
pub(super) fn trials(f64: bool) -> Vec<Trial> {
    let trial = |name, own: Vec<Part>, words, cases, judge| Trial {
        name,
        parts: [binding_numbers()].into_iter().chain(files(["view.wgsl", "selftest/main.wgsl"])).chain(own).collect(),
        capabilities: Capabilities::empty(),
        words,
        cases,
        judge,
    };
    let with = |own| files(["number/double_float.wgsl", own]).collect();
    let operations = files(["selftest/operations.wgsl"]).collect();
    let solve = ["number/double_float.wgsl", "math.wgsl", "ray.wgsl", "form/perpendicular.wgsl", "selftest/solve.wgsl"];
    let mut trials = vec![
        trial("transforms", with("selftest/transforms.wgsl"), [6, 27], cases::transforms(), judge::transforms),
        trial("operations", operations, [2, 11], cases::operations(), judge::operations),
        trial("double_float", with("selftest/double_float.wgsl"), [6, 8], cases::pairs(), judge::pairs),
        trial("solve", files(solve).collect(), [9, 2], cases::solve(), judge::solve),
    ];
    if f64 {
        let wide = trial("f64", files(["selftest/f64.wgsl"]).collect(), [4, 10], cases::wide(), judge::wide);
        trials.push(Trial { capabilities: Capabilities::FLOAT64, ..wide });
    }
    trials
}

impl Gpu {
    /// The verdict on this adapter's arithmetic: measured now, earlier in this process, or read from the user's cache.
    ///
    /// # Errors
    /// Errors of the device. A failed check is not an error but part of the verdict.
    pub(crate) fn verdict(&mut self) -> Result<&Verdict> {
        match self.verdict.take().or_else(|| cache::read(cache::folder(), &self.summary, &self.key())) {
            Some(verdict) => Ok(self.verdict.insert(verdict)),
            None => self.retest(),
        }
    }

    /// Checks that `method` can be used here. A method that needs more than WGSL guarantees requires a passed
    /// self-test.
    ///
    /// # Errors
    /// [`Error::Accuracy`] with the reason if it cannot, and the errors of the self-test.
    pub(crate) fn check_method(&mut self, method: Method) -> Result<()> {
        let reason = match method {
            Method::Native64 if !self.has_f64() => no_f64().reason,
            Method::Native64 => self.verdict()?.f64.reason.clone(),
            Method::DoubleFloat => self.verdict()?.double_float.reason.clone(),
            _ => None,
        };
        match reason {
            None => Ok(()),
            Some(reason) => Err(Error::Accuracy {
                problem: format!("method {} cannot run on {}: {reason}", method.name(), self.summary.name),
                mend: format!("leave out {METHOD}, or use {BACKEND} cpu"),
            }),
        }
    }

    /// Measures again, ignoring the cache, and stores the verdict.
    pub(crate) fn retest(&mut self) -> Result<&Verdict> {
        let verdict = self.measure()?;
        cache::write(cache::folder(), &self.summary, &self.key(), &verdict);
        Ok(self.verdict.insert(verdict))
    }

    /// Makes the verdict say that the f32 self-test failed.
    #[cfg(test)]
    pub(crate) fn distrust(&mut self) {
        if let Some(verdict) = &mut self.verdict {
            verdict.f32 = false;
        }
    }

    fn measure(&mut self) -> Result<Verdict> {
        let start = Instant::now();
        let mut checks = Vec::new();
        for trial in trials(self.has_f64()) {
            let answers = self.guarded(|gpu| gpu.answer(&trial))?;
            checks.extend((trial.judge)(&trial.cases, &answers));
        }
        for name in ["cases", "answers"] {
            self.buffers.remove(name);
            self.staging.remove(name);
        }
        checks.push(self.compare_places()?);
        checks.push(self.compare_twins()?);
        Ok(Verdict { milliseconds: milliseconds(start), ..conclude(checks, self.has_f64()) })
    }

    fn has_f64(&self) -> bool {
        self.open.device.features().contains(wgpu::Features::SHADER_F64)
    }

    /// Everything that the verdict depends on.
    fn key(&self) -> String {
        let mut text = blake3::Hasher::new();
        let trials = trials(true).into_iter().map(|trial| Source::new(trial.parts));
        let kernels = self.twin_kernels().into_iter().map(|kernel| compose(&kernel));
        let [samples, planes] = [false; 2];
        let steps = [Step::Place, Step::Small { samples, planes }, Step::Large { samples, planes }].map(compose_step);
        for source in trials.chain(kernels).chain(steps) {
            text.update(source.text.as_bytes());
        }
        let (adapter, text) = (&self.summary, text.finalize().to_hex());
        format!(
            "{}, {}, {}, f64 {}, subgroup {:?}, halfline {}, shaders {text}",
            adapter.name,
            adapter.backend,
            adapter.driver,
            self.has_f64(),
            adapter.subgroup,
            env!("CARGO_PKG_VERSION"),
        )
    }

    /// Runs a trial's shader on its cases.
    fn answer(&mut self, trial: &Trial) -> Result<Vec<u32>> {
        let source = Source::new(trial.parts.clone());
        let program = self.built(&source, trial.capabilities, trial.name)?;
        let count = trial.cases.len() / trial.words[0];
        let size = (count * trial.words[1] * size_of::<u32>()) as u64;
        let record = ViewRecord { spheres: count as u32, ..ViewRecord::zeroed() };
        self.fill("view", bytemuck::bytes_of(&record))?;
        self.fill("cases", bytemuck::cast_slice(&trial.cases))?;
        self.reserve("answers", size, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
        let mut encoder = self.encoder();
        let groups = (count as u32).div_ceil(super::input::GROUP);
        self.dispatch(&mut self.pass(&mut encoder), &program, |name| self.bound(name, None), (groups, 1));
        self.fetch(encoder, true, "answers", size)
    }
}

fn no_f64() -> Usable {
    Usable { by: None, reason: Some("its shaders have no f64".into()), worst: 0.0 }
}

/// The verdict from all checks.
fn conclude(checks: Vec<Check>, has_f64: bool) -> Verdict {
    let find = |name: &str| checks.iter().find(|check| check.name == name);
    let passed = |name: &str| find(name).is_some_and(|check| check.passed);
    // A number that was not measured counts as the worst value.
    let number = |name: &str, of: &str| find(name).and_then(|c| c.detail.get(of)).copied().unwrap_or(f64::MAX);
    let (div_ulp, sqrt_ulp) = (number("f32 division", "ulp"), number("f32 sqrt", "ulp"));
    let failed = |names: &[&str]| {
        let failed: Vec<_> = names.iter().copied().filter(|name| !passed(name)).collect();
        (!failed.is_empty()).then(|| format!("the self-test failed: {}", failed.join(", ")))
    };
    let usable =
        |by: &str, reason: Option<String>, worst| Usable { by: reason.is_none().then(|| by.to_owned()), reason, worst };
    let f32_checks = ["f32 sum", "f32 difference", "f32 product", "f32 division", "f32 sqrt", "no distribution"];
    let rounding = match number("f32 rounding", "mode") {
        0.0 => Rounding::NearestEven,
        1.0 => Rounding::TowardZero,
        _ => Rounding::Other,
    };
    let double_float = usable("bits XOR 0, Dekker's split", failed(&judge::DOUBLE_FLOAT), judge::worst(&checks, "u2"));
    let f64 = match has_f64 {
        true => usable("native", failed(&judge::F64), judge::worst(&checks, "f64 ulp")),
        false => no_f64(),
    };
    Verdict {
        f32: f32_checks.iter().all(|name| passed(name)),
        places: passed(twin::PLACES),
        strict_twin: passed(twin::NAME),
        rounding,
        div_ulp,
        sqrt_ulp,
        inverse_sqrt_ulp: number("f32 inverseSqrt", "ulp"),
        flushes_subnormals: !passed("subnormals"),
        double_float,
        f64,
        checks,
        milliseconds: 0.0,
    }
}

/// Measures every adapter, or reads the verdict from the user's cache unless `again`, in the order of
/// [`adapters`](crate::adapters). An adapter that cannot be opened, or loses the device, has an error of its own.
///
/// # Errors
/// [`Error::Adapter`] if WGPU_BACKEND names an unknown backend.
pub fn verdicts(again: bool) -> Result<Vec<Result<Verdict>>> {
    use crate::gpu::device;
    let measure = |found: device::FoundAdapter| {
        let mut gpu = Gpu::new(device::open(&found)?, found.summary);
        if !again {
            return gpu.verdict().cloned();
        }
        gpu.retest().cloned()
    };
    Ok(device::find()?.into_iter().map(measure).collect())
}
