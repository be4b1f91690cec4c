//! A renderer: a device or the CPU path, with its caches between frames.

use super::opaque::LastOpaque;
use super::order::LastOrder;
use super::place::ChosenDevice;
use super::plan::Plan;
use super::remaining::LastRemaining;
use crate::cpu;
use crate::frame::report::milliseconds;
use crate::frame::{Data, Frame};
use crate::gpu::Gpu;
use crate::gpu::device::{AdapterSummary, Open};
use crate::gpu::selftest::Verdict;
use crate::gpu::traffic::Traffic;
use crate::intersect::Method;
use crate::scene::Spheres;
use crate::settings::Settings;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::progress::Watch;
use std::sync::Arc;
use web_time::Instant;

/// The reason for the CPU path where there is nothing that a device could hold.
pub(super) const NOTHING: &str = "it has no spheres";

/// A device with its pipelines and buffers, or the CPU reference path, kept for many frames.
///
/// ```
/// use halfline::{Renderer, Settings};
/// # use halfline::{Camera, ImagePlane, Scene, Spheres};
/// # let image = ImagePlane { width: 32, height: 32, ..Default::default() };
/// # let spheres = Spheres { centers: vec![[0.0, 0.0, -3.0]].into(), radii: vec![1.0].into(), ..Spheres::default() };
/// # let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
/// # let mut scene = scene;
///
/// let settings = Settings::default();
/// let mut renderer = Renderer::new(&settings)?;
/// for step in 0..3 {
///     scene.camera.eye.x = 0.1 * f64::from(step);
///     let frame = renderer.render(&scene, &settings)?;
///     assert!(frame.report.hits > 0);
///     renderer.recycle(frame); // its memory serves the next frame
/// }
/// # Ok::<(), halfline::Error>(())
/// ```
pub struct Renderer {
    pub(super) device: ChosenDevice,
    pub(super) setup_ms: f64,
    pub(super) watch: Watch,
    pub(super) pool: Arc<Pool>,
    /// The number of frames so far. Within one frame spheres do not change.
    pub(super) frames: u64,
    /// The spheres in tree order, cached between frames, for rays from hits and for groups of hidden spheres.
    pub(super) order: LastOrder,
    /// The opaque spheres, cached between frames, of a picture that shows something through others.
    pub(super) opaque: LastOpaque,
    pub(super) remaining: LastRemaining,
}

impl Renderer {
    /// Opens the backend and the adapter that `settings` select. `WGPU_ADAPTER_NAME` and `WGPU_BACKEND` apply where the
    /// settings leave a choice. [`Backend::Auto`](crate::settings::Backend::Auto) takes the first hardware adapter that
    /// opens; instead of a software adapter the CPU path, which is faster.
    ///
    /// # Errors
    /// [`Error::Adapter`](crate::Error::Adapter) when no adapter fits, [`Error::Settings`](crate::Error::Settings) for a contradiction, such as an adapter with the
    /// CPU path, [`Error::Accuracy`](crate::Error::Accuracy) for an accuracy that cannot be reached.
    pub fn new(settings: &Settings) -> Result<Self> {
        let start = Instant::now();
        // Errors that do not depend on a device are found before one is opened.
        Plan::for_method(settings)?;
        let device = ChosenDevice::of(settings)?;
        Ok(Self::on(device, milliseconds(start)))
    }

    /// Renders on the caller's own device.
    #[must_use]
    pub fn with_device(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let summary = AdapterSummary::of_device(&device);
        let gpu = Gpu::new(Open::new(device, queue), summary);
        Self::on(ChosenDevice::adapter(gpu, "the caller opened the device"), 0.0)
    }

    /// Another renderer on the same device, or on the CPU path, for frames of another thread: while one thread waits for the device,
    /// the other keeps it busy. Both have the device's copy of equal spheres, its programs, and the host's trees over equal
    /// spheres together, where no one can change these ([`Spheres::share`]). It takes each other buffer once more. A lost device is
    /// lost for both. Not watched.
    #[must_use]
    pub fn another(&self) -> Self {
        let (order, opaque, remaining) = (self.order.another(), self.opaque.another(), self.remaining.another());
        Self { order, opaque, remaining, ..Self::on(self.device.another(), self.setup_ms) }
    }

    /// A renderer on this device, before its first frame.
    fn on(device: ChosenDevice, setup_ms: f64) -> Self {
        Self {
            device,
            setup_ms,
            watch: Watch::default(),
            pool: Arc::default(),
            frames: 0,
            order: LastOrder::default(),
            opaque: LastOpaque::default(),
            remaining: LastRemaining::default(),
        }
    }

    /// The reasons why adapters that were found are not used although the settings allow them; they are warnings of
    /// every report.
    #[must_use]
    pub fn passed_over(&self) -> &[String] {
        &self.device.passed_over
    }

    /// The reason for the place of rendering, in words: requested, found or measured.
    #[must_use]
    pub fn backend_reason(&self) -> &str {
        &self.device.reason
    }

    /// Whether the settings left the choice, and there was no adapter.
    #[must_use]
    pub fn has_no_adapter(&self) -> bool {
        self.device.has_no_adapter
    }

    /// Reports every frame to `watch`, which can end it with [`Error::Interrupted`](crate::Error::Interrupted); the renderer stays usable.
    ///
    /// ```
    /// use halfline::{Cancel, Error, Renderer, Settings, Watch};
    /// # use halfline::{Camera, ImagePlane, Scene, Spheres};
    /// # let image = ImagePlane { width: 8, height: 8, background: [0.0; 3] };
    /// # let spheres = Spheres { centers: vec![[0.0, 0.0, -3.0]].into(), radii: vec![1.0].into(), ..Spheres::default() };
    /// # let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
    /// let (cancel, settings) = (Cancel::default(), Settings::default());
    /// let watch = Watch::default()
    ///     .cancelled_by(&cancel)
    ///     .on_progress(|p| println!("{}: {} of {} {}", p.step.name(), p.done, p.total, p.step.unit()));
    /// let mut renderer = Renderer::new(&settings)?.watched_by(watch);
    /// cancel.cancel(); // from any thread, at any time
    /// assert!(matches!(renderer.render(&scene, &settings), Err(Error::Interrupted)));
    /// cancel.reset();
    /// assert!(renderer.render(&scene, &settings).is_ok());
    /// # Ok::<(), Error>(())
    /// ```
    #[must_use]
    pub fn watched_by(mut self, watch: Watch) -> Self {
        self.watch = watch;
        self
    }

    /// Whether an adapter computes the frames; otherwise the CPU reference path does.
    #[must_use]
    pub fn is_gpu(&self) -> bool {
        self.device.gpu.is_some()
    }

    /// The adapter's name, `cpu` for the reference path.
    #[must_use]
    pub fn adapter(&self) -> &str {
        self.device.gpu.as_ref().map_or(cpu::NAME, |gpu| &gpu.summary.name)
    }

    /// Driver and its version, threads for the reference path.
    #[must_use]
    pub fn driver(&self) -> String {
        self.device.gpu.as_ref().map_or_else(cpu::driver, |gpu| gpu.summary.driver.clone())
    }

    /// Checks that `method` can run here. On the CPU path every method can.
    ///
    /// # Errors
    /// [`Error::Accuracy`](crate::Error::Accuracy) with the reason why the adapter's arithmetic does not allow it, and the errors of the
    /// self-test.
    pub fn check_method(&mut self, method: Method) -> Result<()> {
        self.device.gpu.as_mut().map_or(Ok(()), |gpu| gpu.check_method(method))
    }

    /// The measured properties of the adapter's arithmetic; `None` for the reference path, which defines them.
    ///
    /// # Errors
    /// The errors of the self-test.
    pub fn verdict(&mut self) -> Result<Option<&Verdict>> {
        self.device.gpu.as_mut().map(|gpu| gpu.verdict()).transpose()
    }

    /// Whether the device's own clock times the kernels.
    #[must_use]
    pub fn has_clock(&self) -> bool {
        self.device.gpu.as_ref().is_some_and(|gpu| gpu.has_clock())
    }

    /// The order of these spheres, which may be the opaque ones alone.
    pub(super) fn order_of(&mut self, spheres: &Spheres) -> &mut LastOrder {
        if self.opaque.is_of(spheres) { &mut self.opaque.order } else { &mut self.order }
    }

    /// Takes the device's times and bytes since the last call; `None` for the reference path.
    pub(super) fn traffic(&mut self) -> Option<Traffic> {
        self.device.gpu.as_mut().map(|gpu| gpu.traffic())
    }

    /// Returns the memory of a frame that is no longer needed to the pool of later frames.
    pub fn recycle(&mut self, frame: Frame) {
        for buffer in frame.buffers {
            match buffer.data {
                // The kernels' ids have the same bits.
                Data::I32(v) => self.pool.put_back(bytemuck::allocation::cast_vec::<i32, u32>(v)),
                Data::F32(v) => self.pool.put_back(v),
                Data::F64(v) => self.pool.put_back(v),
                Data::I64(_) | Data::U8(_) => {}
            }
        }
    }
}
