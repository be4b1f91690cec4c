//! The opaque spheres of a scene, kept from frame to frame: a picture shows them through translucent ones.

use super::order::LastOrder;
use crate::scene::list::List;
use crate::scene::same::SameSpheres;
use crate::scene::{Cuts, Lighting, Scene, Spheres};
use crate::search::tree::Tree;
use crate::view::ray::NONE;
use halfline_ground::Shared;
use halfline_ground::error::Result;
use halfline_ground::memory::check;
use halfline_ground::parallel;
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
        let mut own = Spheres {
            centers: List::sound(parallel::map(&ids, |id| spheres.centers[*id as usize])),
            radii: List::sound(parallel::map(&ids, |id| spheres.radii[*id as usize])),
            colors: spheres.colors.as_ref().map(|colors| parallel::map(&ids, |id| colors[*id as usize]).into()),
            materials: None,
            opacities: None,
            cuts: spheres.cuts.as_ref().map(|cuts| cuts.chosen(&ids)),
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
        parallel::each(ids, |_, id| *id = if *id == NONE { NONE } else { self.ids[*id as usize] });
    }

    /// Their ids in the whole scene.
    pub(super) fn ids(&self) -> &[u32] {
        &self.ids
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
    known: Option<Arc<Known>>,
    shared: Shared<Known>,
    pub(super) order: LastOrder,
}

struct Known {
    same: SameSpheres,
    /// The opacities and the colours where no one can change them; otherwise they belong to one frame.
    opacities: Option<List<f32>>,
    colors: Option<List<[f32; 3]>>,
    cuts: Option<Cuts>,
    frame: u64,
    opaque: Arc<Opaque>,
}

impl Known {
    fn of(spheres: &Spheres, frame: u64) -> Result<Self> {
        Ok(Self {
            same: SameSpheres::of(spheres, frame),
            opacities: spheres.opacities.as_ref().and_then(List::kept),
            colors: spheres.colors.as_ref().and_then(List::kept),
            cuts: spheres.cuts.clone(),
            frame,
            opaque: Arc::new(Opaque::of(spheres)?),
        })
    }

    fn is_of(&self, spheres: &Spheres, frame: u64) -> bool {
        fn same<T>(known: Option<&List<T>>, own: Option<&List<T>>, is_same_frame: bool) -> bool {
            match (known, own) {
                (Some(known), Some(own)) => known.is_same(own),
                (None, None) => true,
                (None, Some(_)) => is_same_frame,
                (Some(_), None) => false,
            }
        }
        let is_same_frame = self.frame == frame;
        same(self.opacities.as_ref(), spheres.opacities.as_ref(), is_same_frame)
            && same(self.colors.as_ref(), spheres.colors.as_ref(), is_same_frame)
            && self.cuts == spheres.cuts
            && self.same.is_of(spheres, frame)
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
                self.order.forget();
                // No frame has the number 0: lists that can be changed are not shared.
                let serves = |known: &Known| known.same.is_kept() && known.is_of(spheres, 0);
                self.shared.or_make(serves, || Known::of(spheres, frame))?
            }
        };
        Ok(Arc::clone(&self.known.insert(known).opaque))
    }

    /// The same for another renderer.
    pub(super) fn another(&self) -> Self {
        Self { known: None, shared: self.shared.clone(), order: self.order.another() }
    }

    /// Whether a scene is one of [`Opaque::scene`].
    pub(super) fn is_of(&self, spheres: &Spheres) -> bool {
        self.known.as_ref().is_some_and(|known| known.opaque.spheres.centers.is_same(&spheres.centers))
    }
}
