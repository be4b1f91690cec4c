//! Spheres between points of surfaces and lights. A ray does not test the sphere that it leaves: the side of the
//! surface decides whether that one hides the light.

use super::given_certified::AnySearch;
use crate::certify::cut::{CutRay, PointPlanes};
use crate::certify::given::{AnyHit, CertifiedRay};
use crate::certify::surface::SurfacePoint;
use crate::scene::{Ball, Cuts, Solid};
use crate::search::tree::lanes::{Lanes, Portable, Work, dispatch};
use crate::search::tree::walk::{Test, walk};
use crate::search::tree::{BoxRay, Tree};
use crate::view::planes::EyePlanes;

/// The cuts of a scene, as rays from hits meet them.
pub(crate) struct HitCuts<'a> {
    pub(crate) cuts: &'a Cuts,
    pub(crate) planes: EyePlanes,
    /// The spheres that block rays and that planes spare; the others are in a tree of their own.
    pub(crate) spared: Option<&'a Tree>,
}

/// The part of a ray to a light in which spheres that planes do not spare may block it.
enum Part {
    /// A face looks into what its plane removes.
    Nothing,
    /// The ray leaves what planes keep at its limit.
    Until(CertifiedRay),
    Within(CutRay),
    /// f64 does not tell.
    Unknown,
}

/// A ray from a point to a light.
pub(crate) struct LightRay<'a> {
    point: &'a SurfacePoint,
    /// Among the spheres that planes do not spare.
    search: Search<'a>,
    cut: Option<(&'a HitCuts<'a>, Part)>,
}

impl<'a> LightRay<'a> {
    /// The ray among all spheres of a tree. `light` is a light that is a sphere.
    pub(crate) fn new(tree: &'a Tree, point: &'a SurfacePoint, ray: &'a CertifiedRay, light: Option<Ball>) -> Self {
        Self { search: Search { tree, ray, own: Some(point.ball), light }, point, cut: None }
    }

    /// The same ray among planes that cut the spheres, which are `at` these places from the point.
    pub(crate) fn cut_by(self, cuts: &'a HitCuts<'a>, at: &PointPlanes) -> Self {
        let (point, ray) = (self.point, self.search.ray);
        let part = if point.is_face {
            Part::Nothing
        } else if at.is_kept {
            Part::Until(at.clipped(ray))
        } else {
            CutRay::of_hit(at, *ray).map_or(Part::Unknown, Part::Within)
        };
        let own = (!cuts.cuts.is_spared(point.id)).then_some(point.ball);
        Self { search: Search { own, ..self.search }, cut: Some((cuts, part)), ..self }
    }

    /// Whether the light is hidden, by the sphere of the point or by another.
    pub(crate) fn answer(&self) -> AnyHit {
        let ray = match &self.cut {
            Some((_, Part::Until(ray))) if self.search.own.is_some() => ray,
            _ => self.search.ray,
        };
        or(self.point.own(ray), || self.others())
    }

    /// Whether a sphere other than the point's own hides the light.
    pub(crate) fn others(&self) -> AnyHit {
        let Some((cuts, part)) = &self.cut else { return self.search.answer() };
        let of_part = match part {
            Part::Nothing => AnyHit::Free,
            Part::Until(ray) => Search { ray, ..self.search }.answer(),
            Part::Within(ray) => self.search.possible().into_iter().fold(AnyHit::Free, |answer, place| {
                let Solid { ball, is_cut } = solid(self.search.tree, place, Some(cuts.cuts));
                or(answer, || ray.blocked_by(ball, is_cut))
            }),
            Part::Unknown if self.search.answer() == AnyHit::Free => AnyHit::Free,
            Part::Unknown => AnyHit::Unsure,
        };
        or(of_part, || self.spared().map_or(AnyHit::Free, |spared| spared.answer()))
    }

    /// The search among the spheres that planes spare.
    fn spared(&self) -> Option<Search<'a>> {
        let (cuts, _) = self.cut.as_ref()?;
        let own = self.search.own.is_none().then_some(self.point.ball);
        cuts.spared.map(|tree| Search { tree, own, ..self.search })
    }

    /// All spheres that may hide the light, beside the point's own.
    pub(crate) fn candidates(&self) -> Vec<Solid> {
        let Search { tree, .. } = self.search;
        let (cuts, places) = match &self.cut {
            None => (None, self.search.possible()),
            Some((_, Part::Nothing)) => (None, Vec::new()),
            Some((cuts, Part::Until(ray))) => (Some(cuts.cuts), Search { ray, ..self.search }.possible()),
            Some((cuts, Part::Within(_) | Part::Unknown)) => (Some(cuts.cuts), self.search.possible()),
        };
        let mut all: Vec<Solid> = places.into_iter().map(|place| solid(tree, place, cuts)).collect();
        if let Some(spared) = self.spared() {
            all.extend(spared.possible().into_iter().map(|place| solid(spared.tree, place, None)));
        }
        all
    }
}

/// All spheres but a light and those equal to it.
pub(crate) fn all_but(light: Option<Ball>, tree: &Tree, cuts: Option<&HitCuts<'_>>) -> Vec<Solid> {
    let solids = |tree: &Tree| -> Vec<Solid> {
        (0..tree.spheres.len()).map(|place| solid(tree, place, cuts.map(|cuts| cuts.cuts))).collect()
    };
    let spared = cuts.and_then(|cuts| cuts.spared).map(solids).unwrap_or_default();
    let mut all = [solids(tree), spared].concat();
    all.retain(|solid| Some(solid.ball) != light);
    all
}

/// The sphere at a place of a tree.
fn solid(tree: &Tree, place: usize, cuts: Option<&Cuts>) -> Solid {
    Solid { ball: tree.ball(place), is_cut: cuts.is_some_and(|cuts| cuts.is_cut(tree.ids[place])) }
}

/// The answer of two searches together.
fn or(first: AnyHit, second: impl FnOnce() -> AnyHit) -> AnyHit {
    match first {
        AnyHit::Blocked => AnyHit::Blocked,
        AnyHit::Free => second(),
        AnyHit::Unsure => match second() {
            AnyHit::Free => AnyHit::Unsure,
            answer => answer,
        },
    }
}

/// A ray and the spheres of a tree.
#[derive(Clone, Copy)]
struct Search<'a> {
    tree: &'a Tree,
    ray: &'a CertifiedRay,
    /// The sphere of the point that the ray leaves, where it is one of the tree.
    own: Option<Ball>,
    /// The light, if it is a sphere: it hides nothing of its own light, nor does a sphere equal to it.
    light: Option<Ball>,
}

impl Search<'_> {
    /// Whether a sphere hides the end of the ray.
    fn answer(&self) -> AnyHit {
        self.boxes().map_or(AnyHit::Free, |boxes| dispatch(Others { search: self, boxes: &boxes }))
    }

    /// The places of all spheres that may hide the end of the ray.
    fn possible(&self) -> Vec<usize> {
        let Some(boxes) = self.boxes() else {
            return Vec::new();
        };
        let limit = boxes.limit(self.ray.limit[1]);
        let mut search = HidingSpheres { search: self, limit, all: Vec::new() };
        walk::<false, _>(Portable, self.tree, &boxes, limit, &mut search);
        search.all
    }

    fn boxes(&self) -> Option<BoxRay> {
        BoxRay::new(self.ray.placed(), self.ray.direction, self.ray.doubt())
    }

    /// Whether the sphere at this place is neither the point's own nor the light.
    #[inline(always)]
    fn counts(&self, place: usize) -> bool {
        let ball = Some(self.tree.ball(place));
        ball != self.own && ball != self.light
    }
}

/// The search of one ray among the other spheres. It is dispatched ray by ray, so that only the search itself is
/// compiled for every kind of vector.
struct Others<'a> {
    search: &'a Search<'a>,
    boxes: &'a BoxRay,
}

impl Work for Others<'_> {
    type Output = AnyHit;

    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) -> AnyHit {
        let Self { search, boxes } = self;
        let Search { tree, ray, .. } = *search;
        let limit = boxes.limit(ray.limit[1]);
        // A sphere that is the light hides nothing, and is never met for certain: the ray ends on its surface, and what is
        // certain in f32 lies before the end with all of the sphere and the padding.
        let limits = [boxes.limit_below(ray.limit[0]), limit];
        let counts = |place| search.counts(place);
        let mut search = AnySearch { lanes, tree, ray, boxes, counts, limits, found: AnyHit::Free };
        walk::<true, _>(lanes, tree, boxes, limit, &mut search);
        search.found
    }
}

struct HidingSpheres<'a> {
    search: &'a Search<'a>,
    limit: f32,
    all: Vec<usize>,
}

impl Test for HidingSpheres<'_> {
    fn test(&mut self, block: u32) -> f32 {
        let Search { tree, ray, .. } = *self.search;
        for place in tree.places(block).filter(|place| self.search.counts(*place)) {
            if AnyHit::of(ray, tree.ball(place)) != AnyHit::Free {
                self.all.push(place);
            }
        }
        self.limit
    }
}
