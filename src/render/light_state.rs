//! What a renderer keeps of lights: the tree from frame to frame, and what a device did within one.

use crate::answers::lit::Traced;
use crate::scene::Spheres;
use crate::scene::same::SameSpheres;
use crate::search::tree::Tree;
use crate::view::ray::NONE;
use rayon::prelude::*;
use std::sync::Arc;

/// The tree of the spheres that a renderer saw last.
#[derive(Default)]
pub(super) struct LastTree(Option<(SameSpheres, Arc<Tree>)>);

impl LastTree {
    /// The tree of these spheres, which is built unless it is known.
    pub(super) fn of(&mut self, spheres: &Spheres, frame: u64) -> Option<Arc<Tree>> {
        if self.0.as_ref().is_none_or(|(same, _)| !same.is_of(spheres, frame)) {
            self.0 = None;
            let tree = Tree::new(&spheres.centers, &spheres.radii)?;
            self.0 = Some((SameSpheres::of(spheres, frame), Arc::new(tree)));
        }
        self.0.as_ref().map(|(_, tree)| Arc::clone(tree))
    }
}

/// Hits of which a device traced the rays, and those of them that it decided.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LightOnDevice {
    hits: usize,
    decided: usize,
}

impl LightOnDevice {
    /// Ends the count of a frame.
    pub(super) fn take(&mut self) -> Self {
        std::mem::take(self)
    }

    /// `None` without hits.
    pub(super) fn share(self) -> Option<f64> {
        (self.hits > 0).then(|| self.decided as f64 / self.hits as f64)
    }

    pub(super) fn add(&mut self, ids: &[u32], traced: &Traced<'_>) {
        let hits = (0..ids.len() as u32).into_par_iter().filter(|pixel| ids[*pixel as usize] != NONE);
        self.hits += hits.clone().count();
        self.decided += hits.filter(|pixel| traced.of(*pixel).is_some()).count();
    }
}
