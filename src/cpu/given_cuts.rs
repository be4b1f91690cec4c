//! Given rays among spheres that planes cut: the part of each ray that the planes keep, and the hits there.

use crate::certify::cut::{CutRay, FirstHit};
use crate::certify::given::{AnyHit, CertifiedRay, HitNumbers};
use crate::scene::{Cuts, NumberedBall};
use crate::search::tree::lanes::Lanes;
use crate::search::tree::walk::{Test, may_intersect, pass_all, walk};
use crate::search::tree::{BoxRay, Tree};
use crate::view::planes::EyePlanes;
use glam::DVec3;

/// The planes of a scene, as given rays meet them.
pub(crate) struct GivenCuts<'a> {
    cuts: &'a Cuts,
    planes: EyePlanes,
}

impl<'a> GivenCuts<'a> {
    pub(crate) fn new(cuts: &'a Cuts) -> Self {
        // Each ray has its own origin.
        Self { cuts, planes: EyePlanes::new(cuts, DVec3::ZERO) }
    }

    /// Whether planes cut or remove a sphere: then its hit as a whole bounds nothing.
    #[inline(always)]
    pub(crate) fn changes(&self, id: u32) -> bool {
        self.cuts.is_cut(id) || self.cuts.is_removed(id)
    }

    /// The nearest hit of a ray among the spheres whose places count, with its sphere's id: `None` where f64 does not decide it, `Some(None)`
    /// for a certain miss. With `all` every sphere is tested, without the boxes.
    pub(super) fn nearest<L: Lanes>(
        &self,
        (tree, all): (&Tree, bool),
        lanes: L,
        (ray, boxes): (&CertifiedRay, &BoxRay),
        counts: impl Fn(usize) -> bool,
    ) -> Option<Option<(u32, HitNumbers)>> {
        let kept = CutRay::of_given(&self.planes, &tree.placement, *ray)?;
        let (limit, first) = (boxes.limit(ray.limit[1]), FirstHit::default());
        let mut search = FirstOfCut { lanes, tree, cuts: self.cuts, kept: &kept, boxes, counts, limit, first };
        if all {
            pass_all(tree, &mut search);
        } else {
            walk::<false, _>(lanes, tree, boxes, limit, &mut search);
        }
        match search.first.found()? {
            None => Some(None),
            Some(hit) => kept.numbers(&self.planes, hit).map(|numbers| Some((hit.0.id, numbers))),
        }
    }

    /// Whether a ray hits anything before its limit.
    pub(super) fn any<L: Lanes>(
        &self,
        (tree, all): (&Tree, bool),
        lanes: L,
        (ray, boxes): (&CertifiedRay, &BoxRay),
    ) -> AnyHit {
        let Some(kept) = CutRay::of_given(&self.planes, &tree.placement, *ray) else {
            return AnyHit::Unsure;
        };
        let (limit, found) = (boxes.limit(ray.limit[1]), AnyHit::Free);
        let mut search = AnyOfCut { lanes, tree, cuts: self.cuts, kept: &kept, boxes, limit, found };
        if all {
            pass_all(tree, &mut search);
        } else {
            walk::<false, _>(lanes, tree, boxes, limit, &mut search);
        }
        search.found
    }
}

/// The search for the first hit, among the spheres whose places count.
pub(super) struct FirstOfCut<'a, L, F> {
    pub(super) lanes: L,
    pub(super) tree: &'a Tree,
    pub(super) cuts: &'a Cuts,
    pub(super) kept: &'a CutRay,
    pub(super) boxes: &'a BoxRay,
    pub(super) counts: F,
    pub(super) limit: f32,
    pub(super) first: FirstHit,
}

impl<L: Lanes, F: Fn(usize) -> bool> Test for FirstOfCut<'_, L, F> {
    #[inline(always)]
    fn test(&mut self, block: u32) -> f32 {
        for place in may_intersect(self.lanes, self.tree, block, self.boxes, self.limit) {
            let id = self.tree.ids[place];
            if (self.counts)(place) && !self.cuts.is_removed(id) {
                let ball = NumberedBall { id, ball: self.tree.ball(place) };
                self.first.keep(self.kept, ball, self.cuts.is_cut(id));
            }
        }
        self.limit = self.limit.min(self.boxes.limit(self.first.high()));
        self.limit
    }
}

/// The search for any hit before the limit.
struct AnyOfCut<'a, L> {
    lanes: L,
    tree: &'a Tree,
    cuts: &'a Cuts,
    kept: &'a CutRay,
    boxes: &'a BoxRay,
    limit: f32,
    found: AnyHit,
}

impl<L: Lanes> Test for AnyOfCut<'_, L> {
    #[inline(always)]
    fn test(&mut self, block: u32) -> f32 {
        for place in may_intersect(self.lanes, self.tree, block, self.boxes, self.limit) {
            let id = self.tree.ids[place];
            if self.cuts.is_removed(id) {
                continue;
            }
            match self.kept.blocked_by(self.tree.ball(place), self.cuts.is_cut(id)) {
                AnyHit::Free => {}
                AnyHit::Unsure => self.found = AnyHit::Unsure,
                AnyHit::Blocked => {
                    self.found = AnyHit::Blocked;
                    return -1.0;
                }
            }
        }
        self.limit
    }
}
