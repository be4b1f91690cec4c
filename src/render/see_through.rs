//! Pictures that show something through translucent spheres: the picture of the opaque spheres alone, and over it the
//! translucent hits before them, layer by layer.

use super::light::LightSetup;
use super::opaque::Opaque;
use super::plan::Plan;
use super::plan::lights::bounces;
use super::renderer::Renderer;
use super::setup::FrameSetup;
use crate::answers::layers::Peeling;
use crate::answers::raw::Raw;
use crate::certify::binned::{BinnedScene, Binning};
use crate::error::Result;
use crate::frame::report::Timings;
use crate::memory::Pool;
use crate::parallel::{self, CHEAP, Rows};
use crate::scene::{Scene, Spheres};
use crate::settings::Settings;
use crate::view::raster::Raster;
use crate::view::ray::NONE;
use std::sync::Arc;

/// The frame of all spheres for the rays of a view, from which translucent hits are found.
pub(super) struct WholeFrame {
    pub(super) setup: FrameSetup,
    /// The spheres in lists from which none is left out, for more than one layer; `None` where every pixel is decided exactly.
    lists: Option<BinnedScene>,
}

impl WholeFrame {
    /// Returns its memory to the pool for the next frame.
    pub(super) fn put_back(self, pool: &Pool) {
        if let Some(lists) = self.lists {
            lists.put_back(pool);
        }
        self.setup.put_back(pool);
    }
}

impl Renderer {
    /// The opaque spheres of a scene whose picture shows something through others; `None` for any other picture.
    pub(super) fn opaque(&mut self, plan: &Plan, scene: &Scene) -> Result<Option<Arc<Opaque>>> {
        plan.see_through.then(|| self.opaque.of(&scene.spheres, self.frames)).transpose()
    }

    /// The light of a picture that shows something through translucent spheres.
    pub(super) fn light_through(
        &mut self,
        plan: &Plan,
        scene: &Scene,
        settings: &Settings,
        opaque: &Opaque,
    ) -> LightSetup {
        let blockers = if settings.opacity_shadows { None } else { Some(opaque.tree(scene)) };
        // Rays leave from the hits of the opaque spheres alone, and from those of each layer, where a device has those of one frame.
        let by_host =
            Some(if blockers.is_some() { "not all spheres block them" } else { "they leave from several layers" });
        match blockers {
            // Rays that go on from mirrors meet all spheres.
            Some(blockers) if bounces(scene) > 0 => {
                LightSetup { blockers, by_host, ..self.light_setup(scene, plan.accuracy) }
            }
            Some(blockers) => LightSetup { tree: blockers.clone(), blockers, accuracy: plan.accuracy, by_host },
            None => LightSetup { by_host, ..self.light_setup(scene, plan.accuracy) },
        }
    }

    /// Sets up the frame of all spheres for the rays of `raster`.
    pub(super) fn whole_frame(
        &mut self,
        plan: &Plan,
        scene: &Scene,
        settings: &Settings,
        raster: Raster,
        timings: &mut Timings,
    ) -> Result<WholeFrame> {
        let plan = Plan { kernel: plan.kernel.ids_only(), ..plan.clone() };
        let setup = self.setup(plan, scene, settings, raster, timings)?;
        let lists = if settings.layers > 1 {
            let tolerance = settings.promise().relative();
            let binning = Binning { culls: false, ..Binning::of(scene, &setup.view, tolerance, &self.pool) };
            timings.time("layers", || BinnedScene::new(&binning))?
        } else {
            None
        };
        Ok(WholeFrame { setup, lists })
    }

    /// The translucent spheres that the rays of a view hit before the opaque ones, which are given: of each pixel the nearest
    /// in the first layer, the next in the second; [`NONE`] where there is no more.
    pub(super) fn layers(
        &mut self,
        frame: &mut WholeFrame,
        scene: &Scene,
        settings: &Settings,
        opaque: &[u32],
        timings: &mut Timings,
    ) -> Result<Vec<Vec<u32>>> {
        let pool = Arc::clone(&self.pool);
        let WholeFrame { setup, lists } = frame;
        let mut raw = Raw::new(&setup.plan.kernel, opaque.len(), &pool)?;
        let settled = self.answer(setup, scene, settings, &mut raw, timings)?;
        raw.settle(&settled);
        let mut first = std::mem::take(&mut raw.id);
        raw.put_back(&pool);
        let spheres = &scene.spheres;
        parallel::each(&mut first, |_, id| {
            if *id != NONE && spheres.opacity(*id) == 1.0 {
                *id = NONE;
            }
        });
        let mut layers = vec![first];
        if settings.layers > 1 {
            let peeling = Peeling { scene, view: &setup.view, lists: lists.as_ref(), opaque };
            let more = timings.time("layers", || peeling.behind(&layers[0], settings.layers - 1, &self.watch))?;
            layers.extend(more);
        }
        Ok(layers)
    }
}

/// Lays a layer over the picture of what lies behind it: colours in linear light, by the opacity of each hit. `passing` is the share
/// of the light behind that reaches the eye.
pub(super) fn lay_over(spheres: &Spheres, layer: &[u32], over: &[f32], color: &mut [f32], passing: &mut [f32]) {
    let opacity = |id: u32| if id == NONE { 0.0 } else { spheres.opacity(id) };
    parallel::each(passing, |pixel, passing| *passing *= 1.0 - opacity(layer[pixel]));
    parallel::fill(Rows { values: color, each: 3 }, CHEAP, &|pixels, color| {
        let over = over[3 * pixels.start..].chunks_exact(3);
        for ((color, over), id) in color.values.chunks_exact_mut(3).zip(over).zip(&layer[pixels]) {
            let opacity = opacity(*id);
            color.iter_mut().zip(over).for_each(|(color, over)| *color += opacity * (*over - *color));
        }
    });
}
