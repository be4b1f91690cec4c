//! Spheres between points of surfaces and lights. A ray does not test the sphere that it leaves: the side of the
//! surface decides whether that one hides the light.

use super::given_certified::AnySearch;
use crate::certify::given::{AnyHit, CertifiedRay};
use crate::certify::surface::SurfacePoint;
use crate::scene::Ball;
use crate::search::tree::lanes::{Lanes, Portable, Work, dispatch};
use crate::search::tree::walk::{Test, walk};
use crate::search::tree::{BoxRay, Tree};

/// A ray from a point to a light.
#[derive(Clone, Copy)]
pub(crate) struct LightRay<'a> {
    pub(crate) tree: &'a Tree,
    pub(crate) point: &'a SurfacePoint,
    pub(crate) ray: &'a CertifiedRay,
    /// The light, if it is a sphere: it hides nothing of its own light, nor does a sphere equal to it.
    pub(crate) light: Option<Ball>,
}

impl LightRay<'_> {
    /// Whether the light is hidden, by the sphere of the point or by another.
    pub(crate) fn answer(&self) -> AnyHit {
        match self.point.own(self.ray) {
            AnyHit::Blocked => AnyHit::Blocked,
            AnyHit::Free => self.others(),
            AnyHit::Unsure => match self.others() {
                AnyHit::Free => AnyHit::Unsure,
                answer => answer,
            },
        }
    }

    /// Whether a sphere other than that of the point hides the light.
    pub(crate) fn others(&self) -> AnyHit {
        self.boxes().map_or(AnyHit::Free, |boxes| dispatch(Others { light_ray: self, boxes: &boxes }))
    }

    /// All spheres that may hide the light, beside that of the point.
    pub(crate) fn candidates(&self) -> Vec<Ball> {
        let Some(boxes) = self.boxes() else {
            return Vec::new();
        };
        let limit = boxes.limit(self.ray.limit[1]);
        let mut search = HidingSpheres { light_ray: self, limit, all: Vec::new() };
        walk::<false, _>(Portable, self.tree, &boxes, limit, &mut search);
        search.all
    }

    fn boxes(&self) -> Option<BoxRay> {
        BoxRay::new(self.ray.placed(), self.ray.direction, self.ray.doubt())
    }

    /// Whether the sphere at this place is another than that of the point and the light.
    #[inline(always)]
    fn counts(&self, place: usize) -> bool {
        let ball = self.tree.ball(place);
        ball != self.point.ball && Some(ball) != self.light
    }
}

/// The search of one ray among the other spheres. It is dispatched ray by ray, so that only the search itself is
/// compiled for every kind of vector.
struct Others<'a> {
    light_ray: &'a LightRay<'a>,
    boxes: &'a BoxRay,
}

impl Work for Others<'_> {
    type Output = AnyHit;

    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) -> AnyHit {
        let Self { light_ray, boxes } = self;
        let limit = boxes.limit(light_ray.ray.limit[1]);
        // A sphere that is the light hides nothing, and is never met for certain: the ray ends on its surface, and what is
        // certain in f32 lies before the end with all of the sphere and the padding.
        let limits = [boxes.limit_below(light_ray.ray.limit[0]), limit];
        let LightRay { tree, ray, .. } = *light_ray;
        let counts = |place| light_ray.counts(place);
        let mut search = AnySearch { lanes, tree, ray, boxes, counts, limits, found: AnyHit::Free };
        walk::<true, _>(lanes, tree, boxes, limit, &mut search);
        search.found
    }
}

struct HidingSpheres<'a> {
    light_ray: &'a LightRay<'a>,
    limit: f32,
    all: Vec<Ball>,
}

impl Test for HidingSpheres<'_> {
    fn test(&mut self, block: u32) -> f32 {
        let LightRay { tree, ray, .. } = *self.light_ray;
        for place in tree.places(block).filter(|place| self.light_ray.counts(*place)) {
            if AnyHit::of(ray, tree.ball(place)) != AnyHit::Free {
                self.all.push(tree.ball(place));
            }
        }
        self.limit
    }
}
