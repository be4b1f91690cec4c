//! The nearest of the hits of a ray that are known within bounds.

use crate::certify::given::{Bounds, CertifiedRay};
use crate::search::tree::Tree;

/// The nearest certain hit so far, and a lower bound of t of all others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Foremost {
    /// The place of the sphere in the tree, and its hit.
    pub(super) best: Option<(usize, Bounds)>,
    /// The least t at which any other sphere may be hit.
    pub(super) rival: f64,
}

impl Foremost {
    /// The state before the search, with a hit that is known already or with none.
    pub(super) fn of(best: Option<(usize, Bounds)>) -> Self {
        Self { best, rival: f64::INFINITY }
    }

    /// Adds a possible hit of the sphere at `place`. Returns whether it is now the nearest certain hit.
    #[inline(always)]
    pub(super) fn keep(&mut self, tree: &Tree, ray: &CertifiedRay, place: usize, bounds: Bounds) -> bool {
        if bounds.low >= ray.limit[1] {
            return false;
        }
        if !bounds.sure || bounds.high >= ray.limit[0] {
            self.rival = self.rival.min(bounds.low);
            return false;
        }
        if let Some((other, nearest)) = self.best {
            // Of equal spheres the lower index is hit. A place beyond the tree is the place of no other sphere.
            let equal = || tree.spheres.get(other).is_some_and(|sphere| *sphere == tree.spheres[place]);
            if bounds.low <= nearest.high && nearest.low <= bounds.high && equal() {
                let first = if tree.ids[place] < tree.ids[other] { place } else { other };
                self.best = Some((first, nearest));
                return false;
            }
            if bounds.high >= nearest.high {
                self.rival = self.rival.min(bounds.low);
                return false;
            }
            self.rival = self.rival.min(nearest.low);
        }
        self.best = Some((place, bounds));
        true
    }
}
