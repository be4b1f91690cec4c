//! The log of a frame: times, what was left to the host, what a device did. Its report is made of it.

use crate::answers::light::Traced;
use crate::frame::report::Timings;
use crate::view::ray::NONE;
use halfline_ground::parallel;

/// The notes of one frame.
#[derive(Default)]
pub(super) struct FrameLog {
    /// Times of its steps.
    pub(super) timings: Timings,
    /// The reason why the CPU path renders the frame in place of the device.
    pub(super) refused: Option<String>,
    /// The reason why the host traces rays from its hits, or draws its samples, in place of the device.
    left_to_host: Option<String>,
    light: LightOnDevice,
}

/// The number of hits whose rays a device traced, and of those hits that it decided.
#[derive(Debug, Clone, Copy, Default)]
struct LightOnDevice {
    hits: usize,
    decided: usize,
}

impl FrameLog {
    /// Does `work` as a part of the step `name`.
    pub(super) fn time<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        self.timings.time(name, work)
    }

    /// Notes why the device left the frame to the CPU path; the first reason counts.
    pub(super) fn refuse(&mut self, reason: &str) {
        self.refused.get_or_insert_with(|| format!("the CPU path rendered this frame: {reason}"));
    }

    /// Notes `what` the host did in place of the device, and why; the first reason counts.
    pub(super) fn leave_to_host(&mut self, what: &str, reason: &str) {
        self.left_to_host.get_or_insert_with(|| format!("{what}: {reason}"));
    }

    /// Notes hits; the device left so many of them to the host.
    pub(super) fn add_light(&mut self, ids: &[u32], left: usize) {
        let hits = parallel::count(ids.len(), |pixel| ids[pixel] != NONE);
        self.light.hits += hits;
        self.light.decided += hits.saturating_sub(left);
    }

    /// Notes the hits whose rays the device traced.
    pub(super) fn add_traced(&mut self, ids: &[u32], traced: &Traced<'_>) {
        let is_left = |pixel: usize| ids[pixel] != NONE && traced.of(pixel as u32).is_none();
        self.add_light(ids, parallel::count(ids.len(), is_left));
    }

    /// The share of hits whose rays the device decided; `None` where it traced none.
    pub(super) fn light_on_device(&self) -> Option<f64> {
        let LightOnDevice { hits, decided } = self.light;
        (hits > 0).then(|| decided as f64 / hits as f64)
    }

    /// The warnings, in the order of the report.
    pub(super) fn warnings(&self) -> impl Iterator<Item = String> {
        [&self.refused, &self.left_to_host].into_iter().flatten().cloned()
    }
}
