//! Pictures that show something through translucent spheres: the picture of the opaque spheres alone, and over it the
//! translucent hits before them, layer by layer.

use super::light::{LightSetup, all_spheres, of_cuts};
use super::sampling::Sampling;
use crate::answers::hits::FirstHits;
use crate::answers::layers::Layers;
use crate::render::engine::{Engine, ViewRays};
use crate::render::opaque::Opaque;
use crate::render::plan::Plan;
use crate::render::plan::lights::bounces;
use crate::render::rendering::{Pass, Rendering};
use crate::render::setup::{self, FrameSetup};
use crate::scene::{Scene, Spheres};
use crate::view::View;
use crate::view::picture_rays::PictureRays;
use crate::view::raster::Raster;
use crate::view::ray::NONE;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::parallel::{self, CHEAP, Rows};

pub(in crate::render) const PASS: Pass = Pass {
    name: "layers",
    output: "the translucent spheres before the opaque one of each sample, and their colours over its own",
    runs: |plan, _, _| plan.see_through,
};

/// The setups for the rays of a raster, of all passes of one eye.
pub(super) struct Setups {
    /// The frame of the opaque spheres, which may be all.
    pub(super) first: FrameSetup,
    /// The scene of the opaque spheres, where some are translucent.
    pub(super) alone: Option<Scene>,
    /// The frame of all spheres, where some are translucent.
    pub(super) shown: Option<Shown>,
}

/// The frame of all spheres for the rays of a view, from which translucent hits are found.
pub(super) struct Shown {
    setup: FrameSetup,
    /// The engine that finds the layers behind the first, where it is another.
    deep: Option<Box<dyn Engine>>,
}

impl Shown {
    pub(super) fn view(&self) -> &View {
        &self.setup.view
    }

    /// Returns the memory to the pool for the next frame.
    pub(super) fn put_back(self, pool: &Pool) {
        self.setup.put_back(pool);
        if let Some(deep) = self.deep {
            deep.put_back(pool);
        }
    }
}

/// The setups for the rays of a raster.
///
/// # Errors
/// Errors of the setups.
pub(super) fn setups(at: &mut Rendering<'_>, sampling: &Sampling<'_>, plan: Plan, raster: Raster) -> Result<Setups> {
    let scene = sampling.scene;
    let Some(opaque) = sampling.opaque else {
        let first = setup::make(at, plan, scene, raster)?;
        return Ok(Setups { first, alone: None, shown: None });
    };
    let alone = opaque.scene(scene);
    let of_ids = Plan { kernel: plan.kernel.ids_only(), is_deep: at.settings.layers > 1, ..plan.clone() };
    let all = setup::make(at, of_ids, scene, raster)?;
    let deep = all.deep(at, scene)?;
    let refused = at.log.refused.clone();
    let first = setup::make(at, plan, &alone, raster)?;
    if alone.spheres.is_empty() {
        // No sphere is opaque, and the device renders those that there are.
        at.log.refused = refused;
    }
    Ok(Setups { first, alone: Some(alone), shown: Some(Shown { setup: all, deep }) })
}

impl Setups {
    pub(super) fn set_sample(&mut self, sample: u32) {
        self.first.view.set_sample(sample);
        if let Some(shown) = &mut self.shown {
            shown.setup.view.set_sample(sample);
        }
    }

    /// Finds the first hits of the opaque spheres, which may be all. Settled pixels keep the ids of the scene alone.
    ///
    /// # Errors
    /// Errors of the engine.
    pub(super) fn find(&mut self, at: &mut Rendering<'_>, sampling: &Sampling<'_>, hits: &mut FirstHits) -> Result<()> {
        let of = self.alone.as_ref().unwrap_or(sampling.scene);
        self.first.find(at, of, hits)?;
        sampling.opaque.into_iter().for_each(|opaque| opaque.rename(&mut hits.raw.id));
        Ok(())
    }

    /// Returns the memory to the pool for the next frame.
    pub(super) fn put_back(self, pool: &Pool) {
        self.first.put_back(pool);
        if let Some(shown) = self.shown {
            shown.put_back(pool);
        }
    }
}

/// The light of a picture that shows something through translucent spheres.
pub(super) fn light_through(at: &mut Rendering<'_>, plan: &Plan, opaque: &Opaque) -> LightSetup {
    let scene = at.scene;
    let blockers = if at.settings.opacity_shadows { None } else { at.time("tree", |_| Some(opaque.tree(scene))) };
    // Rays leave from the hits of the opaque spheres alone, and from the hits of each layer; a device has the hits of one frame.
    let by_host =
        Some(if blockers.is_some() { "not all spheres block them" } else { "they leave from several layers" });
    let Some(tree) = blockers else {
        // Opaque spheres, and translucent ones behind the first, may lie inside of translucent ones.
        return LightSetup { from_first: false, by_host, ..all_spheres(at, plan) };
    };
    let (blockers, spared) = match at.time("tree", |_| of_cuts(&scene.spheres, opaque.ids().iter().copied())) {
        Some((others, spared)) => (Some(others), Some(spared)),
        None => (tree.clone(), None),
    };
    // Rays that go on from mirrors meet all spheres.
    if bounces(scene) > 0 {
        return LightSetup { blockers, spared, by_host, ..all_spheres(at, plan) };
    }
    LightSetup { tree, blockers, spared, accuracy: plan.accuracy, from_first: true, by_host }
}

/// The translucent spheres that the rays of a view hit before the opaque ones, which are given: of each pixel the nearest
/// in the first layer, the next in the second; [`NONE`] where there is no more.
///
/// # Errors
/// Errors of the engines.
pub(super) fn find(at: &mut Rendering<'_>, shown: &mut Shown, scene: &Scene, opaque: &[u32]) -> Result<Vec<Vec<u32>>> {
    let Shown { setup, deep } = shown;
    let mut hits = FirstHits::new(&setup.plan.kernel, opaque.len(), &at.pool)?;
    setup.find(at, scene, &mut hits)?;
    let mut first = hits.into_ids(&at.pool);
    let spheres = &scene.spheres;
    parallel::each(&mut first, |_, id| {
        if *id != NONE && spheres.opacity(*id) == 1.0 {
            *id = NONE;
        }
    });
    let mut layers = vec![first];
    if at.settings.layers > 1 {
        let rays = ViewRays { scene, view: &setup.view, kernel: &setup.plan.kernel };
        let behind = Layers { opaque, first: &layers[0], more: at.settings.layers - 1 };
        let engine = deep.as_mut().unwrap_or(&mut setup.engine);
        let more = at.time("layers", |at| engine.behind(at, rays, behind))?;
        layers.extend(more);
    }
    Ok(layers)
}

/// The opacity of each hit of a layer: its sphere's, or with the rays of a rim, one that grows to 1 where the ray grazes the sphere. It grows
/// as the share that glass reflects: C. Schlick, An Inexpensive BRDF Model for Physically-based Rendering, Computer Graphics Forum 13(3),
/// 1994.
pub(super) fn opacities(spheres: &Spheres, layer: &[u32], rim: Option<&PictureRays<'_>>) -> Vec<f32> {
    parallel::from_fn(layer.len(), |pixel| {
        let id = layer[pixel];
        if id == NONE {
            return 0.0;
        }
        let opacity = spheres.opacity(id);
        let hit = rim.map(|rays| rays.hit(pixel as u32, spheres.ball(id), spheres.is_cut(id)));
        hit.filter(|hit| hit.near).map_or(opacity, |hit| {
            let grazing = 1.0 - hit.normal.dot(-hit.along).clamp(0.0, 1.0);
            opacity + (1.0 - opacity) * (grazing * grazing * grazing) as f32
        })
    })
}

/// Lays a layer over the picture of what lies behind it: colours in linear light, by the opacity of each hit. `passing` is the share
/// of the light behind that reaches the eye.
pub(super) fn lay_over(opacities: &[f32], over: &[f32], color: &mut [f32], passing: &mut [f32]) {
    parallel::each(passing, |pixel, passing| *passing *= 1.0 - opacities[pixel]);
    parallel::fill(Rows { values: color, each: 3 }, CHEAP, &|pixels, color| {
        let over = over[3 * pixels.start..].chunks_exact(3);
        for ((color, over), opacity) in color.values.chunks_exact_mut(3).zip(over).zip(&opacities[pixels]) {
            color.iter_mut().zip(over).for_each(|(color, over)| *color += *opacity * (*over - *color));
        }
    });
}
