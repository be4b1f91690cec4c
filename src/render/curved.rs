//! Frames of curved lenses: their viewing rays are given rays, whose hits the tree certifies.

use super::plan::Plan;
use super::plan::lights::bounces;
use super::renderer::Renderer;
use super::trace::{GivenPlace, Hits, Rays, Tracer};
use crate::cpu;
use crate::error::{Error, Result};
use crate::frame::coverage::Coverage;
use crate::frame::report::{Report, milliseconds};
use crate::frame::{Aov, Buffer, Data, Frame};
use crate::kernel::{Kernel, Task};
use crate::memory::check;
use crate::parallel::{self, CHEAP, Rows};
use crate::progress::Step;
use crate::quote::setting::{AOV, APERTURE, BOUNCES, DEPTH_CUE, LOOK, MATERIAL, OCCLUSION, OPACITY, SILHOUETTE, SUN};
use crate::scene::Scene;
use crate::scene::camera::{Basis, CURVED, CurvedRays, Lens};
use crate::settings::{Accuracy, Search, Settings};
use crate::shade::{Shade, color_of};
use crate::view::ViewRecord;
use crate::view::raster::Raster;
use crate::window::Window;
use glam::DVec3;
use web_time::Instant;

/// Rays that are traced at once.
pub(super) const BLOCK: usize = 1 << 18;

/// Bytes of a pixel's buffers and rays at once, rounded up.
const PIXEL: u64 = 160;

/// Pixels without a ray, in the words of a warning.
fn without_ray(count: usize) -> Option<String> {
    let words = format!(
        "{count} pixels have no viewing ray, because the lens's model gives their places no direction; they are misses"
    );
    (count > 0).then_some(words)
}

/// The rays of a frame.
struct FrameRays {
    rays: CurvedRays,
    basis: Basis,
    /// The positions of rays within pixels.
    record: ViewRecord,
}

impl FrameRays {
    /// The direction of the ray of a pixel of the window in the world; `None` without one.
    fn direction(&self, pixel: usize) -> Option<DVec3> {
        let [row, column] =
            self.record.position(pixel as u32).map(|at| (f64::from(at) + 0.5) / f64::from(self.record.fine()));
        let local = self.rays.direction([column, row])?;
        let Basis { u, v, w, .. } = self.basis;
        Some(local.x * u - local.y * v - local.z * w)
    }
}

/// The hits of the rays of a window, as many as pixels.
struct WindowHits {
    directions: Vec<Option<DVec3>>,
    hits: Hits,
}

impl WindowHits {
    /// Adds the spheres of the pixels to their coverage. A miss, -1, and [`NONE`](crate::view::ray::NONE) are the same bits.
    fn count(&self, coverage: Option<&mut Coverage>, window: Window) {
        if let Some(coverage) = coverage {
            coverage.add(bytemuck::cast_slice(&self.hits.id), window.inside(window), window.width());
        }
    }
}

impl Renderer {
    /// Renders a scene whose lens is curved.
    ///
    /// # Errors
    /// [`Error::Settings`] for what only frames of a plane have: lights, a sky, lines, a lens with a size, translucent spheres, mirrors and
    /// glass; those of [`Renderer::tracer`].
    pub(super) fn render_curved(&mut self, scene: &Scene, settings: &Settings) -> Result<Frame> {
        let start = Instant::now();
        let CurvedPlan { window, samples, given, mut report, .. } = self.curved_plan(scene, settings)?;
        let watch = self.watch.clone();
        watch.check()?;
        let [width, height] = [window.width(), window.height()];
        let pixels = width as usize * height as usize;
        let mut of_ray = frame_rays(scene, Raster::centres(window))?;
        let colors = settings.asks(&[Aov::Color]);
        let mut tracer = self.tracer(&scene.spheres, &given)?;
        let passes = samples.map_or(0, |raster| raster.count());
        let mut coverage = settings.coverage.then(|| Coverage::new(window));
        let doing = watch.begin(Step::Trace, u64::from(passes + 1) * pixels as u64);
        let mut step = |of: &FrameRays| of.trace(&mut tracer, pixels, &|rays| doing.next(rays));
        let centers = step(&of_ray)?;
        let mut picture = Picture { color: vec![0.0; if colors { 3 * pixels } else { 0 }], alpha: vec![0.0; pixels] };
        match samples {
            Some(raster) => {
                of_ray.record = record(raster);
                for sample in 0..passes {
                    of_ray.record.sample = sample;
                    let found = step(&of_ray)?;
                    picture.add(&found, scene, settings.shade);
                    found.count(coverage.as_mut(), window);
                }
                picture.divide(f64::from(passes));
            }
            None => {
                picture.add(&centers, scene, settings.shade);
                centers.count(coverage.as_mut(), window);
            }
        }
        doing.end()?;
        if report.backend == "gpu" && !tracer.is_gpu() {
            // The adapter failed meanwhile.
            (report.adapter, report.driver, report.backend) = (cpu::NAME.to_owned(), cpu::driver(), "cpu");
            report.warnings.extend(tracer.warning().map(str::to_owned));
        }
        report.warnings.extend(without_ray(centers.directions.iter().filter(|ray| ray.is_none()).count()));
        report.rays = pixels as u64;
        report.hits = centers.hits.id.iter().filter(|id| **id >= 0).count() as u64;
        report.settled = centers.hits.certainty.iter().filter(|certainty| **certainty == 1).count() as u64;
        let promised = tracer.accuracy() != Accuracy::Fast;
        report.certified = if promised { 1.0 - report.settled as f64 / pixels as f64 } else { 0.0 };
        report.bound = promised.then(|| settings.promise().relative());
        let buffers = buffers(&centers, &picture, &of_ray.basis, settings, [width, height].map(|side| side as usize))?;
        report.frame_ms = vec![milliseconds(start)];
        let full = [scene.image.width, scene.image.height];
        Ok(Frame { width, height, window, full, buffers, coverage, report })
    }

    /// The plan of a frame of a curved lens. Its report has all entries that need no traced ray.
    ///
    /// # Errors
    /// As [`Self::render_curved`], as far as no ray is traced.
    pub(super) fn curved_plan(&mut self, scene: &Scene, settings: &Settings) -> Result<CurvedPlan> {
        check_settings(scene, settings)?;
        settings.check_lighting(scene)?;
        scene.check()?;
        let window = settings.window_of(scene)?;
        let colors = settings.asks(&[Aov::Color]);
        let counted = settings.asks(&[Aov::Color, Aov::Alpha]) || settings.coverage;
        let samples = Raster::samples(window, settings.samples, settings.seed, &scene.image)?.filter(|_| counted);
        let pixels = u64::from(window.width()) * u64::from(window.height());
        let need = PIXEL * pixels + settings.reserve;
        check(need, || format!("a frame of {} x {} pixels", window.width(), window.height()))?;
        let normals =
            settings.aovs.iter().copied().chain((colors && settings.shade != Shade::Flat).then_some(Aov::Normal));
        let given = Settings { aovs: normals.collect(), ..settings.clone() };
        let GivenPlace { plan: of_rays, on_device, warning } = self.given_place(&scene.spheres, &given)?;
        if let (Some(method), true) = (of_rays.kernel.method(), on_device && !of_rays.certifies()) {
            self.check_method(method)?;
        }
        let mut plan = Plan::for_method(settings)?;
        (plan.method, plan.accuracy) = (of_rays.method, of_rays.accuracy);
        plan.reason = match of_rays.accuracy {
            Accuracy::Exact => "every ray of a curved lens is decided in exact arithmetic",
            Accuracy::Fast => "the rays of a curved lens are given rays, which a method does not prove",
            _ => "the rays of a curved lens are given rays, which a tree certifies",
        }
        .to_owned();
        plan.kernel.shade = Some(settings.shade).filter(|_| colors);
        let report = Report {
            adapter: if on_device { self.adapter() } else { cpu::NAME }.to_owned(),
            driver: if on_device { self.driver() } else { cpu::driver() },
            backend: if on_device { "gpu" } else { "cpu" },
            search: of_rays.search.name(),
            ..self.report(&plan, scene, settings, samples)
        };
        let mut found = CurvedPlan { window, samples, given, kernel: of_rays.kernel, report, need };
        found.report.warnings.extend(warning);
        if of_rays.certifies() {
            found.kernel = Kernel::bare(Task::Given { any: false, tree: of_rays.search == Search::Tree });
        }
        Ok(found)
    }
}

/// The decisions for a frame of a curved lens.
pub(super) struct CurvedPlan {
    pub(super) window: Window,
    /// The samples, where there are several per pixel.
    pub(super) samples: Option<Raster>,
    /// The settings of the rays.
    given: Settings,
    /// The kernel of the rays, where a device traces them.
    pub(super) kernel: Kernel,
    pub(super) report: Report,
    /// Estimate of the memory that the frame needs besides the scene, bytes.
    pub(super) need: u64,
}

/// Returns an error for what frames of given rays do not have.
fn check_settings(scene: &Scene, settings: &Settings) -> Result<()> {
    let asks = |aov| settings.asks(&[aov]);
    let has_light = !scene.lighting.lights.is_empty() || scene.lighting.sky.is_some();
    let (what, mend) = if asks(Aov::Shadow) || asks(Aov::Occlusion) || asks(Aov::Bound) {
        ("the buffers shadow, occlusion and bound", format!("remove them from {AOV}"))
    } else if asks(Aov::Color) && has_light {
        ("lights and a sky", format!("use {LOOK} plain without {SUN} and {OCCLUSION}, and a scene without lights"))
    } else if settings.silhouette {
        ("the lines of silhouettes", format!("remove {SILHOUETTE}"))
    } else if settings.depth_cue {
        ("a depth cue", format!("remove {DEPTH_CUE}"))
    } else if settings.aperture.is_some() {
        ("a lens with a size", format!("remove {APERTURE}, or the aperture of the file"))
    } else if settings.asks(&[Aov::Color, Aov::Alpha]) && scene.spheres.is_translucent() {
        ("translucent spheres", format!("remove {OPACITY}"))
    } else if asks(Aov::Color) && settings.shade == Shade::Headlight && bounces(scene) > 0 {
        ("metal, glass and mirror images", format!("remove {MATERIAL}, or use {BOUNCES} 0, which draws them matte"))
    } else {
        return Ok(());
    };
    let problem = format!("only a perspective or orthographic camera has {what}, and this lens has {CURVED}");
    Err(Error::settings(problem, mend))
}

/// The rays of a raster.
fn frame_rays(scene: &Scene, raster: Raster) -> Result<FrameRays> {
    let Lens::Curved { curve, fx, fy, cx, cy } = scene.camera.lens else {
        return Err(Error::settings("the lens is not curved", "render the scene as any other"));
    };
    let rays = CurvedRays::new(curve, [fx, fy, cx, cy], [scene.image.width, scene.image.height])?;
    Ok(FrameRays { rays, basis: scene.camera.basis()?, record: record(raster) })
}

/// The positions of the rays of a raster within pixels.
fn record(raster: Raster) -> ViewRecord {
    let Window { x0, y0, .. } = raster.window;
    ViewRecord {
        first_row: y0,
        first_column: x0,
        columns: raster.window.width(),
        rows: raster.window.height(),
        strata: raster.strata,
        jitter: raster.jitter,
        step: 1,
        seed: raster.seed,
        ..bytemuck::Zeroable::zeroed()
    }
}

impl FrameRays {
    /// The hits of all pixels; a pixel without a ray is a miss.
    fn trace(&self, tracer: &mut Tracer<'_>, pixels: usize, go_on: &dyn Fn(u64) -> bool) -> Result<WindowHits> {
        let directions = parallel::values(pixels, CHEAP, |pixel| self.direction(pixel));
        let origins = [self.basis.e.to_array()];
        let mut all = tracer.misses(pixels);
        for first in (0..pixels).step_by(BLOCK) {
            let block = first..pixels.min(first + BLOCK);
            let rays: Vec<usize> = block.clone().filter(|pixel| directions[*pixel].is_some()).collect();
            let given: Vec<[f64; 3]> =
                rays.iter().filter_map(|pixel| directions[*pixel]).map(|d| d.to_array()).collect();
            if !given.is_empty() {
                all.put(&rays, tracer.hits(&Rays { origins: &origins, directions: &given, limits: &[] })?);
            }
            if !go_on(block.len() as u64) {
                return Err(Error::Interrupted);
            }
        }
        Ok(WindowHits { directions, hits: all })
    }
}

/// Sums of colour and coverage.
struct Picture {
    color: Vec<f64>,
    alpha: Vec<f64>,
}

impl Picture {
    fn add(&mut self, found: &WindowHits, scene: &Scene, shade: Shade) {
        let WindowHits { directions, hits } = found;
        self.alpha.iter_mut().zip(&hits.id).for_each(|(alpha, id)| *alpha += f64::from(u8::from(*id >= 0)));
        let color_at = |pixel: usize| {
            let id = hits.id[pixel];
            let Some(direction) = directions[pixel].filter(|_| id >= 0) else { return scene.image.background };
            let normal = hits.normal.as_ref().map_or([0.0; 3], |normals| normals[pixel]);
            let own = color_of(scene.spheres.colors.as_deref(), id as u32);
            shade.in_world(direction, DVec3::from(normal.map(f64::from)), own)
        };
        parallel::fill(Rows { values: &mut self.color[..], each: 3 }, CHEAP, &|pixels, sums| {
            let colors = pixels.flat_map(color_at);
            sums.values.iter_mut().zip(colors).for_each(|(sum, x)| *sum += f64::from(x));
        });
    }

    fn divide(&mut self, count: f64) {
        self.color.iter_mut().chain(&mut self.alpha).for_each(|sum| *sum /= count);
    }
}

/// The requested buffers and the ids.
fn buffers(
    found: &WindowHits,
    picture: &Picture,
    basis: &Basis,
    settings: &Settings,
    [width, height]: [usize; 2],
) -> Result<Vec<Buffer>> {
    let WindowHits { directions, hits } = found;
    let forward = -basis.w;
    let each = |missed: f64, of: &(dyn Fn(usize, DVec3) -> f64 + Sync)| -> Vec<f64> {
        let value = |pixel: usize| directions[pixel].filter(|_| hits.id[pixel] >= 0).map_or(missed, |d| of(pixel, d));
        parallel::from_fn(hits.id.len(), value)
    };
    let single = |values: &[f64]| Data::F32(values.iter().map(|x| *x as f32).collect());
    let data = |aov: Aov| match aov {
        Aov::Id => Some(Data::I32(hits.id.clone())),
        Aov::Mask => Some(Data::U8(hits.id.iter().map(|id| u8::from(*id >= 0)).collect())),
        Aov::Certainty => Some(Data::U8(hits.certainty.clone())),
        Aov::Distance => Some(Data::F64(hits.distance.clone())),
        Aov::Depth => Some(Data::F64(each(f64::INFINITY, &|n, d| hits.t[n] * d.dot(forward)))),
        Aov::Position => {
            let axis = |k: usize| each(f64::NAN, &|n, d| basis.e[k] + hits.t[n] * d[k]);
            let axes = [axis(0), axis(1), axis(2)];
            Some(Data::F64((0..hits.id.len()).flat_map(|n| axes.each_ref().map(|axis| axis[n])).collect()))
        }
        Aov::Normal => hits.normal.as_ref().map(|normals| Data::F32(normals.iter().flatten().copied().collect())),
        Aov::Color => Some(single(&picture.color)),
        Aov::Alpha => Some(single(&picture.alpha)),
        Aov::Bound | Aov::Shadow | Aov::Occlusion => None,
    };
    let requested = Aov::ALL.into_iter().filter(|aov| *aov == Aov::Id || settings.asks(&[*aov]));
    requested
        .filter_map(|aov| Some((aov, data(aov)?)))
        .map(|(aov, data)| Buffer::new(aov, width, height, data))
        .collect()
}
