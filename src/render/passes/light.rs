//! Lights and sky at hits: rays from there, on the device that still holds the hits or on the host, and what they bring.

use crate::answers::hits::FirstHits;
use crate::answers::light::{LightBuffers, Traced};
use crate::answers::open_sky::{OpenSky, SkySums};
use crate::cpu::hidden::HitCuts;
use crate::cpu::light::{LightOutputs, LightingContext};
use crate::exact::Judge;
use crate::gpu::Gpu;
use crate::gpu::resident::sky::{SkyRays, SkyRecord, SkyTraced};
use crate::render::plan::Plan;
use crate::render::plan::lights::{bounces, light_points};
use crate::render::rendering::{Pass, Rendering};
use crate::render::setup::FrameSetup;
use crate::scene::{Gradient, Light, LightSource, SPARED, Scene, Sky, SkyLight, Spheres};
use crate::search::tree::Tree;
use crate::search::tree::device_rays::DirectionRecord;
use crate::settings::{Accuracy, Settings};
use crate::view::backdrop::Backdrop;
use crate::view::directions::{DiscPoints, SkyDirections};
use crate::view::planes::EyePlanes;
use crate::view::{View, ViewRecord};
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::progress::Step;
use std::sync::Arc;

pub(in crate::render) const PASS: Pass = Pass {
    name: "light",
    output: "lights and sky at the hits of the pixels' centres: shadows, the open share, and colours without samples",
    runs: |plan, _, _| {
        let outputs = plan.light_outputs;
        outputs.shadow || outputs.occlusion || outputs.color && plan.sampled.is_none()
    },
};

/// The frame whose pixels are lit.
#[derive(Clone, Copy)]
pub(super) struct FrameContext<'a> {
    pub(super) scene: &'a Scene,
    pub(super) settings: &'a Settings,
    pub(super) view: &'a View,
}

/// The start of the message for rays that a device did not trace.
const LEFT: &str = "the host traced the rays to lights and sky of this frame";

/// The light that is requested of a frame.
pub(super) struct LightRequest<'a> {
    pub(super) outputs: LightOutputs,
    pub(super) sky: Option<Sky>,
    /// The sphere that each pixel shows; rays leave from its hits.
    pub(super) ids: &'a [u32],
    /// Whether neighbours complement each other, for rays that are put together afterwards; alone they would show the pattern in
    /// which they repeat.
    pub(super) interleaved: bool,
    /// The rays toward the sky, if they were traced before.
    pub(super) open_sky: Option<&'a OpenSky>,
}

impl<'a> LightRequest<'a> {
    /// A request for the light of all pixels, with rays toward the sky.
    pub(super) fn of(outputs: LightOutputs, sky: Option<Sky>, ids: &'a [u32]) -> Self {
        Self { outputs, sky, ids, interleaved: false, open_sky: None }
    }

    /// The sky toward which rays are traced; `None` where they were traced before.
    fn unknown_sky(&self) -> Option<Sky> {
        self.sky.filter(|_| self.open_sky.is_none())
    }

    /// The directions toward the sky. Rays leave from the hits, unless they were traced before, and from the points after a bounce.
    pub(super) fn directions(&self, FrameContext { scene, settings, view }: FrameContext<'_>) -> SkyDirections {
        let ViewRecord { strata, sample, .. } = view.record;
        let leaves = self.unknown_sky().is_some() || bounces(scene) > 0;
        let rays = self.sky.filter(|_| leaves).map_or(0, |sky| sky.rays);
        match self.interleaved {
            true => SkyDirections::interleaved(rays, strata, sample, settings.seed),
            false => SkyDirections::new(rays, strata, sample),
        }
    }
}

/// The rays from each hit of a frame.
pub(super) struct HitRays<'a> {
    /// Toward the sky.
    pub(super) directions: &'a SkyDirections,
    /// To lights, one each.
    pub(super) lights: &'a [DirectionRecord],
    /// The length of rays toward the sky, in the scene's unit.
    pub(super) reach: f64,
    pub(super) seed: u32,
}

impl HitRays<'_> {
    /// The rays as a device reads them.
    pub(super) fn records(&self, tree: &Tree) -> (Vec<DirectionRecord>, SkyRecord) {
        let turned = self.directions.turned().iter().map(DirectionRecord::of_unit);
        let records = turned.chain(self.lights.iter().copied()).collect();
        let [sure_limit, limit] = limits(tree, self.reach);
        let record = SkyRecord {
            rays: self.directions.len() as u32,
            lights: self.lights.len() as u32,
            seed: self.seed,
            interleaved: self.directions.is_interleaved().into(),
            sure_limit,
            limit,
            ..bytemuck::Zeroable::zeroed()
        };
        (records, record)
    }
}

/// The lights of a scene, for rays to them; empty where one has a size.
fn lights_of(tree: &Tree, scene: &Scene) -> Vec<DirectionRecord> {
    let without_size = |light: &Light| match light.source {
        LightSource::Direction(direction) => Some(DirectionRecord::new(direction.to_array())),
        LightSource::Point(place) => DirectionRecord::place(tree, place.to_array()),
        LightSource::Sphere(_) | LightSource::Ball { .. } => None,
    };
    scene.lighting.lights.iter().map(without_size).collect::<Option<_>>().unwrap_or_default()
}

/// Data for the lights of one scene, shared by the pixels' centres and all samples.
pub(in crate::render) struct LightSetup {
    /// The tree over the spheres that rays from mirrors and through glass meet; `None` without spheres.
    pub(super) tree: Option<Arc<Tree>>,
    /// The tree over the spheres that block rays to lights and sky, where they are not all.
    pub(super) blockers: Option<Arc<Tree>>,
    /// The tree over the blocking spheres that planes spare, which are then not in `blockers`.
    pub(super) spared: Option<Arc<Tree>>,
    pub(super) accuracy: Accuracy,
    /// Rays leave from what viewing rays hit first among all spheres that block them: so none begins inside of one, if the eye is outside.
    pub(super) from_first: bool,
    /// The reason why the host traces all rays: a device knows the hits of its last frame, and which spheres block their rays.
    pub(super) by_host: Option<&'static str>,
}

impl LightSetup {
    /// Does `work` in the context of a frame's light, whose rays toward the sky have these directions.
    ///
    /// # Errors
    /// Errors of the judge.
    pub(super) fn with_context<T>(
        &self,
        tree: &Tree,
        FrameContext { scene, settings, view }: FrameContext<'_>,
        request: &LightRequest<'_>,
        directions: &SkyDirections,
        work: impl FnOnce(LightingContext<'_>) -> T,
    ) -> Result<T> {
        let LightRequest { outputs, sky, open_sky, .. } = *request;
        let ViewRecord { strata, sample, .. } = view.record;
        let (bounces, samples) = (bounces(scene), strata * strata);
        let sized = scene.lighting.lights.iter().any(|light| light.source.has_size());
        let judge = self.judge(scene, view)?;
        Ok(work(LightingContext {
            scene,
            view,
            tree,
            blockers: self.blockers.as_deref().unwrap_or(tree),
            cuts: scene.spheres.cuts.as_ref().map(|cuts| HitCuts {
                cuts,
                planes: EyePlanes::new(cuts, view.basis.e),
                spared: self.spared.as_deref(),
            }),
            outputs,
            judge: judge.as_ref(),
            exact: self.accuracy == Accuracy::Exact,
            sky,
            colors: Gradient::of(scene).filter(|_| outputs.color || outputs.sky).map(SkyLight::new),
            backdrop: Backdrop::new(scene, view, true),
            directions,
            scattered: &if bounces > 0 { SkyDirections::one(strata, sample) } else { SkyDirections::none() },
            disc: &DiscPoints::new(if sized { light_points(samples) } else { 0 }, samples),
            seed: settings.seed,
            open: open_sky,
            from_first: self.from_first,
            traced: None,
            bounces,
        }))
    }

    /// The judge of rays that f64 leaves unsure; `None` where answers are not certified. It holds no spheres: each
    /// question brings its own.
    fn judge(&self, scene: &Scene, view: &View) -> Result<Option<Judge>> {
        let certified = matches!(self.accuracy, Accuracy::Certified | Accuracy::Exact);
        certified.then(|| view.judge(&scene.bare())).transpose()
    }
}

/// The limit of a ray toward the sky, in the tree's unit over the length of its direction: a lower bound and an upper
/// bound.
fn limits(tree: &Tree, reach: f64) -> [f32; 2] {
    let limit = tree.placement.radius(reach) / DirectionRecord::UNIT;
    match limit < f64::from(f32::MAX) {
        true => [(limit as f32).next_down(), (limit as f32).next_up()],
        false => [f32::MAX.next_down(), f32::MAX],
    }
}

/// The spheres that rays from hits meet; `None` where nothing asks for light.
pub(in crate::render) fn trees(at: &mut Rendering<'_>, plan: &Plan) -> Option<LightSetup> {
    plan.light_outputs.is_any().then(|| all_spheres(at, plan))
}

/// All spheres, which rays from hits meet.
pub(super) fn all_spheres(at: &mut Rendering<'_>, plan: &Plan) -> LightSetup {
    let Rendering { renderer, scene, log, .. } = at;
    let tree = log.time("tree", || renderer.order.tree(&scene.spheres, renderer.frames));
    // A device holds the hits of the viewing rays of a plane.
    let by_host = plan.given.as_ref().map(|_| "a curved lens gives its viewing rays");
    let (blockers, spared) = log.time("tree", || of_cuts(&scene.spheres, 0..scene.spheres.len() as u32)).unzip();
    LightSetup { tree, blockers, spared, accuracy: plan.accuracy, from_first: true, by_host }
}

/// Two trees over these spheres: over the ones that planes do not spare, and over the others; `None` where they spare none.
pub(super) fn of_cuts(spheres: &Spheres, ids: impl Iterator<Item = u32>) -> Option<(Arc<Tree>, Arc<Tree>)> {
    let cuts = spheres.cuts.as_ref().filter(|cuts| cuts.count(SPARED) > 0)?;
    let (spared, others): (Vec<u32>, Vec<u32>) = ids.partition(|id| cuts.is_spared(*id));
    let tree = |ids: &[u32]| Tree::of_some(&spheres.centers, &spheres.radii, ids).map(Arc::new);
    if spared.is_empty() { None } else { tree(&others).zip(tree(&spared)) }
}

/// The buffers of lights and sky, and the colours where there are no samples.
///
/// # Errors
/// As [`light`].
pub(in crate::render) fn run(
    at: &mut Rendering<'_>,
    setup: &FrameSetup,
    trees: Option<&LightSetup>,
    hits: &FirstHits,
) -> Result<LightBuffers> {
    let (asked, scene, settings) = (setup.plan.light_outputs, at.scene, at.settings);
    let outputs = LightOutputs { color: asked.color && at.rays.samples.is_none(), ..asked };
    let Some(trees) = trees.filter(|_| outputs.is_any()) else { return Ok(LightBuffers::default()) };
    let sky = if outputs.occlusion { Some(settings.buffer_sky(scene)) } else { scene.lighting.sky };
    let of = FrameContext { scene, settings, view: &setup.view };
    light(at, trees, of, &LightRequest::of(outputs, sky, &hits.raw.id))
}

/// Traces rays from the hits that are still on the device: toward the sky in these directions, and one to each
/// light, where lights cast shadows and none has a size. Returns the numbers of rays, and the words of all pixels;
/// `None` where the host has to trace.
fn trace_from_hits(
    at: &mut Rendering<'_>,
    tree: &Tree,
    frame: FrameContext<'_>,
    request: &LightRequest<'_>,
    directions: &SkyDirections,
) -> Result<Option<(Traced<'static>, Vec<u32>)>> {
    let (none, sky) = (SkyDirections::none(), request.unknown_sky());
    let directions = if sky.is_some() { directions } else { &none };
    let casts_shadows = request.outputs.casts_shadows(&frame.scene.lighting);
    let lights = if casts_shadows { lights_of(tree, frame.scene) } else { Vec::new() };
    let count = Traced { words: &[], rays: directions.len(), lights: lights.len() };
    if count.rays + count.lights == 0 {
        return Ok(None);
    }
    let reach = sky.map_or(f64::INFINITY, |sky| sky.reach);
    let (records, record) = HitRays { directions, lights: &lights, reach, seed: frame.settings.seed }.records(tree);
    let rays = SkyRays { tree, view: frame.view, directions: &records, record };
    let words = on_hits(at, &rays, Gpu::trace_sky)?;
    Ok(words.map(|words| (count, words)))
}

/// Has the device do `work` with rays from the hits that it still holds; `None` where the host has to.
pub(super) fn on_hits<T>(
    at: &mut Rendering<'_>,
    rays: &SkyRays<'_>,
    work: impl FnOnce(&mut Gpu, &SkyRays<'_>, &dyn Fn(u64) -> bool) -> Result<SkyTraced<T>>,
) -> Result<Option<T>> {
    let Some(gpu) = &mut at.renderer.device.gpu else { return Ok(None) };
    let doing = at.renderer.watch.begin(Step::Light, rays.view.record.pixels() as u64);
    match work(gpu, rays, &|done| doing.reached(done))? {
        SkyTraced::NoHits => Ok(None),
        SkyTraced::Traced(found) => {
            doing.end()?;
            Ok(Some(found))
        }
        SkyTraced::Refused(reason) => {
            at.log.leave_to_host(LEFT, &reason);
            Ok(None)
        }
    }
}

/// Light of the pixels of a view.
///
/// # Errors
/// [`crate::Error::Interrupted`], and [`crate::Error::Limits`] where memory is short.
pub(super) fn light(
    at: &mut Rendering<'_>,
    setup: &LightSetup,
    frame: FrameContext<'_>,
    request: &LightRequest<'_>,
) -> Result<LightBuffers> {
    at.time("light", |at| traced(at, setup, frame, request))
}

fn traced(
    at: &mut Rendering<'_>,
    setup: &LightSetup,
    frame: FrameContext<'_>,
    request: &LightRequest<'_>,
) -> Result<LightBuffers> {
    let LightRequest { outputs, ids, .. } = *request;
    let mut buffers = room(frame.scene, outputs, ids.len(), &at.pool)?;
    let directions = request.directions(frame);
    let Some(tree) = &setup.tree else {
        let backdrop = Backdrop::new(frame.scene, frame.view, true);
        return Ok(buffers.of_nothing(|pixel| backdrop.at(pixel)));
    };
    let found = match (setup.accuracy, setup.by_host) {
        (Accuracy::Certified, None) => trace_from_hits(at, tree, frame, request, &directions)?,
        (Accuracy::Certified, Some(reason)) if at.renderer.is_gpu() => {
            at.log.leave_to_host(LEFT, reason);
            None
        }
        _ => None,
    };
    let traced = found.as_ref().map(|(count, words)| Traced { words, ..*count });
    if let Some(traced) = &traced {
        at.log.add_traced(ids, traced);
    }
    let doing = at.renderer.watch.begin(Step::Light, ids.len() as u64);
    setup.with_context(tree, frame, request, &directions, |context| {
        let streamed = if traced.is_none() { context.stream(ids, &|| doing.next(0)) } else { None };
        let streamed = streamed.as_ref().map(|(count, words)| Traced { words, ..*count });
        let context = LightingContext { traced: traced.or(streamed), ..context };
        context.fill(ids, &mut buffers, &|pixels| doing.next(pixels));
    })?;
    doing.end()?;
    Ok(buffers)
}

/// Room for the light of so many pixels.
fn room(scene: &Scene, outputs: LightOutputs, pixels: usize, pool: &Pool) -> Result<LightBuffers> {
    let some = |is_requested: bool, each: usize| if is_requested { each * pixels } else { 0 };
    let sums = SkySums::count(Gradient::of(scene).is_some());
    Ok(LightBuffers {
        color: pool.values(some(outputs.color, 3))?,
        shadow: pool.values(some(outputs.shadow, scene.lighting.lights.len()))?,
        occlusion: pool.values(some(outputs.occlusion, 1))?,
        sky: [pool.values(some(outputs.sky, 3))?, pool.values(some(outputs.sky, sums))?],
        depth: pool.values(some(outputs.depth, 1))?,
        unsure: Vec::new(),
    })
}
