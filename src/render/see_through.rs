//! Pictures that show something through translucent spheres: the picture of the opaque spheres alone, and over it the
//! translucent hits before them, layer by layer.

use super::light::LightSetup;
use super::order::LastOrder;
use super::plan::Plan;
use super::plan::lights::bounces;
use super::renderer::Renderer;
use super::sample::Sampling;
use super::setup::FrameSetup;
use crate::answers::layers::Peeling;
use crate::answers::raw::Raw;
use crate::certify::binned::{BinnedScene, Binning};
use crate::error::Result;
use crate::frame::report::Timings;
use crate::memory::{Pool, check};
use crate::scene::list::List;
use crate::scene::same::SameSpheres;
use crate::scene::{Lighting, Scene, Spheres};
use crate::search::tree::Tree;
use crate::settings::Settings;
use crate::view::View;
use crate::view::raster::Raster;
use crate::view::ray::NONE;
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};

/// The opaque spheres of a scene.
pub(super) struct Opaque {
    spheres: Spheres,
    /// Their ids in the scene.
    ids: Vec<u32>,
    /// The tree over them, in the placement of all spheres.
    tree: OnceLock<Option<Arc<Tree>>>,
}

impl Opaque {
    fn of(spheres: &Spheres) -> Result<Self> {
        let count = spheres.len() as u64;
        check(48 * count, || format!("the opaque ones of {count} spheres"))?;
        let ids: Vec<u32> = (0..spheres.len() as u32).filter(|id| spheres.opacity(*id) == 1.0).collect();
        let all = || ids.par_iter().map(|id| *id as usize);
        let mut own = Spheres {
            centers: List::sound(all().map(|n| spheres.centers[n]).collect()),
            radii: List::sound(all().map(|n| spheres.radii[n]).collect()),
            colors: spheres.colors.as_ref().map(|colors| all().map(|n| colors[n]).collect::<Vec<_>>().into()),
            materials: None,
            opacities: None,
        };
        own.share();
        Ok(Self { spheres: own, ids, tree: OnceLock::new() })
    }

    /// A scene of these spheres alone, as the camera of another sees them.
    pub(super) fn scene(&self, of: &Scene) -> Scene {
        let lighting = Lighting::default();
        Scene { camera: of.camera, image: of.image, spheres: self.spheres.clone(), lighting }
    }

    /// Gives spheres of [`Opaque::scene`] the ids that they have in the whole scene.
    pub(super) fn rename(&self, ids: &mut [u32]) {
        ids.par_iter_mut().filter(|id| **id != NONE).for_each(|id| *id = self.ids[*id as usize]);
    }

    /// The tree over them, for rays that only opaque spheres block; `None` where the scene has no spheres.
    pub(super) fn tree(&self, scene: &Scene) -> Option<Arc<Tree>> {
        let build = || Tree::of_some(&scene.spheres.centers, &scene.spheres.radii, &self.ids).map(Arc::new);
        self.tree.get_or_init(build).clone()
    }
}

/// The opaque spheres of the scene that a renderer saw last, and their order.
#[derive(Default)]
pub(super) struct LastOpaque {
    known: Option<Known>,
    pub(super) order: LastOrder,
}

struct Known {
    same: SameSpheres,
    /// The opacities and the colours where no one can change them; otherwise the frame in which they were read.
    lists: Option<(List<f32>, Option<List<[f32; 3]>>)>,
    frame: u64,
    opaque: Arc<Opaque>,
}

impl Known {
    fn is_of(&self, spheres: &Spheres, frame: u64) -> bool {
        let unchanged = match (&self.lists, &spheres.opacities) {
            (Some((opacities, colors)), Some(own)) => {
                let same_colors = match (colors, &spheres.colors) {
                    (Some(colors), Some(own)) => colors.is_same(own),
                    (colors, own) => colors.is_none() && own.is_none(),
                };
                opacities.is_same(own) && same_colors
            }
            _ => self.frame == frame,
        };
        unchanged && self.same.is_of(spheres, frame)
    }
}

impl LastOpaque {
    /// The opaque ones of these spheres.
    ///
    /// # Errors
    /// [`crate::Error::Limits`] where memory is short.
    pub(super) fn of(&mut self, spheres: &Spheres, frame: u64) -> Result<Arc<Opaque>> {
        let known = match self.known.take().filter(|known| known.is_of(spheres, frame)) {
            Some(known) => known,
            None => {
                self.order = LastOrder::default();
                let colors = spheres.colors.as_ref().map(List::kept);
                let lists = spheres.opacities.as_ref().and_then(List::kept).and_then(|opacities| match colors {
                    Some(None) => None,
                    colors => Some((opacities, colors.flatten())),
                });
                let (same, opaque) = (SameSpheres::of(spheres, frame), Arc::new(Opaque::of(spheres)?));
                Known { same, lists, frame, opaque }
            }
        };
        Ok(Arc::clone(&self.known.insert(known).opaque))
    }

    /// Whether a scene is one of [`Opaque::scene`].
    pub(super) fn is_of(&self, spheres: &Spheres) -> bool {
        self.known.as_ref().is_some_and(|known| known.opaque.spheres.centers.is_same(&spheres.centers))
    }
}

/// The frame of all spheres for the rays of a view, from which translucent hits are found.
pub(super) struct WholeFrame {
    pub(super) setup: FrameSetup,
    /// The spheres in lists from which none is left out, for more than one layer; `None` where every pixel is decided exactly.
    lists: Option<BinnedScene>,
}

impl WholeFrame {
    /// Returns its memory to the pool for the next frame.
    pub(super) fn put_back(self, pool: &Pool) -> View {
        if let Some(lists) = self.lists {
            lists.put_back(pool);
        }
        self.setup.put_back(pool)
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
        match blockers {
            // Rays that go on from mirrors meet all spheres.
            Some(blockers) if bounces(scene) > 0 => LightSetup { blockers, ..self.light_setup(scene, plan.accuracy) },
            Some(blockers) => LightSetup { tree: blockers.clone(), blockers, accuracy: plan.accuracy },
            None => self.light_setup(scene, plan.accuracy),
        }
    }

    /// Sets up the frame of all spheres for the rays of `raster`.
    pub(super) fn whole_frame(
        &mut self,
        sampling: &Sampling<'_>,
        raster: Raster,
        timings: &mut Timings,
    ) -> Result<WholeFrame> {
        let Sampling { plan, scene, settings, .. } = *sampling;
        let plan = Plan { kernel: sampling.kernel.ids_only(), ..plan.clone() };
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
        sampling: &Sampling<'_>,
        frame: &mut WholeFrame,
        opaque: &[u32],
        timings: &mut Timings,
    ) -> Result<Vec<Vec<u32>>> {
        let Sampling { scene, settings, .. } = *sampling;
        let pool = Arc::clone(&self.pool);
        let WholeFrame { setup, lists } = frame;
        let mut raw = Raw::new(&setup.plan.kernel, opaque.len(), &pool)?;
        let settled = self.answer(setup, scene, settings, &mut raw, timings)?;
        raw.settle(&settled);
        let mut first = std::mem::take(&mut raw.id);
        raw.put_back(&pool);
        let spheres = &scene.spheres;
        first.par_iter_mut().filter(|id| **id != NONE && spheres.opacity(**id) == 1.0).for_each(|id| *id = NONE);
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
    let mix = |((id, passing), (over, color)): ((&u32, &mut f32), (&[f32], &mut [f32]))| {
        if *id != NONE {
            let opacity = spheres.opacity(*id);
            *passing *= 1.0 - opacity;
            color.iter_mut().zip(over).for_each(|(color, over)| *color += opacity * (*over - *color));
        }
    };
    let colors = over.par_chunks_exact(3).zip(color.par_chunks_exact_mut(3));
    layer.par_iter().zip(passing).zip(colors).for_each(mix);
}
