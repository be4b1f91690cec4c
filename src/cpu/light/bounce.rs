//! Rays that go on from mirrors and through glass.

use super::super::foremost::Foremost;
use super::super::given_certified::NearestSearch;
use super::super::given_cuts::FirstOfCut;
use super::super::hidden::HitCuts;
use super::lighting::LightingContext;
use super::point::PointLight;
use super::surface::Surface;
use crate::answers::open_sky::SkySums;
use crate::certify::cut::{CutRay, FirstHit, Leaving, PointPlanes};
use crate::certify::given::CertifiedRay;
use crate::certify::surface::SurfacePoint;
use crate::scene::{Cuts, Material, NumberedBall};
use crate::search::tree::lanes::{Lanes, Work, dispatch};
use crate::search::tree::walk::walk;
use crate::search::tree::{BoxRay, Tree};
use crate::shade::optics::{reflected, refracted, schlick};
use crate::view::directions::PixelSample;
use glam::DVec3;

/// A ray with less weight than this is not followed: it changes a picture of 8 bits by less than half a level.
const NEGLIGIBLE: f64 = 1.0 / 512.0;

/// A ray that goes on from a mirror or through glass, or the viewing ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Onward {
    from: SurfacePoint,
    /// The direction, of length 1, with an error of up to `tilt`.
    along: DVec3,
    tilt: f64,
    /// It goes through the sphere that it starts from.
    within: bool,
    /// The part of its light that reaches the eye.
    weight: DVec3,
    /// Number of rays before it on the path: 0 for the viewing ray.
    depth: u32,
    proved: bool,
}

/// The light that `point` reflects or lets through, back along a viewing ray in the unit direction `along`, and whether
/// every ray that brings it is proved. `waiting` holds the rays that are still to be followed; it is empty before and
/// after.
pub(super) fn follow(
    waiting: &mut Vec<Onward>,
    at_point: &mut PointLight<'_>,
    point: SurfacePoint,
    along: DVec3,
    at: PixelSample,
) -> (DVec3, bool) {
    let lighting = at_point.lighting;
    let (mut sum, mut proved) = (DVec3::ZERO, true);
    let first = Onward {
        from: point,
        along,
        tilt: SurfacePoint::VIEWING_TILT,
        within: false,
        weight: DVec3::ONE,
        depth: 0,
        proved: true,
    };
    push(waiting, lighting, &first, &point, at);
    while let Some(ray) = waiting.pop() {
        let (hit, sure) = ray.nearest(lighting);
        let known = ray.proved && sure;
        proved &= known;
        let Some(hit) = hit else {
            sum += ray.weight * lighting.backdrop.toward(ray.along);
            continue;
        };
        let (hit, sharp) = match lighting.judge {
            Some(_) if hit.is_sharp(&lighting.tree.placement) => (hit, true),
            _ => (hit.trusted(&lighting.tree.placement), false),
        };
        proved &= sharp || lighting.judge.is_none();
        if hit.outside || !lighting.material(hit.id).is_clear() {
            let surface = Surface::from(&hit);
            at_point.begin(&surface, ray.along, SkySums::default());
            at_point.trace_lights(&hit, at);
            at_point.trace_sky(&hit, &surface, at);
            proved &= !at_point.assume_blocked();
            sum += ray.weight * at_point.color(&surface, ray.along);
        }
        if ray.depth < lighting.bounces {
            push(waiting, lighting, &Onward { proved: known && sharp, ..ray }, &hit, at);
        }
    }
    (sum, proved)
}

/// Adds the rays that go on where `ray` meets a point.
fn push(
    waiting: &mut Vec<Onward>,
    lighting: &LightingContext<'_>,
    ray: &Onward,
    point: &SurfacePoint,
    at: PixelSample,
) {
    let (normal, along) = (DVec3::from_array(point.normal), ray.along);
    let depth = ray.depth + 1;
    let mirror = |weight: DVec3| Onward {
        from: *point,
        along: reflected(along, normal),
        tilt: point.mirrored_tilt(&lighting.tree.placement, ray.tilt),
        within: !point.outside,
        weight: ray.weight * weight,
        depth,
        ..*ray
    };
    let through = |weight: DVec3, index: f64| {
        let eta = if point.outside { 1.0 / index } else { index };
        match refracted(along, normal, eta) {
            // What is refracted is not proved.
            Some(along) => {
                let within = point.outside;
                Onward { along, tilt: 0.0, within, proved: false, ..mirror(weight) }
            }
            None => mirror(weight),
        }
    };
    let mut add = |ray: Option<Onward>| waiting.extend(ray.filter(|ray| ray.weight.max_element() >= NEGLIGIBLE));
    match lighting.material(point.id) {
        Material::Phong { specular, transmission, index, .. } => {
            add((specular > 0.0 && point.outside).then(|| mirror(DVec3::splat(specular.into()))));
            add((transmission > 0.0).then(|| through(DVec3::splat(transmission.into()), index)));
        }
        Material::Plastic { .. } | Material::Ink => {}
        Material::Metal { fuzz } => {
            let mut ray = mirror(lighting.own_color(point.id, point.is_face).as_dvec3());
            if fuzz > 0.0 {
                let scattered = lighting.scattered.of(at, depth)[0].map(f64::from);
                let scatter = DVec3::from_array(scattered) * f64::from(fuzz);
                let along = ray.along + scatter;
                ray = Onward { along: along.normalize(), proved: false, ..ray };
            }
            // What is scattered into the metal is lost.
            add((ray.along.dot(normal) > 0.0).then_some(ray));
        }
        Material::Glass { index } => {
            let share = schlick(-along.dot(normal), if point.outside { 1.0 / index } else { index });
            add(Some(mirror(DVec3::splat(share))));
            add(Some(through(DVec3::splat(1.0 - share), index)));
        }
    }
}

impl Onward {
    /// The point that it meets first, and whether that is certain.
    fn nearest(&self, lighting: &LightingContext<'_>) -> (Option<SurfacePoint>, bool) {
        let tree = lighting.tree;
        let ray = self.from.onward(&tree.placement, self.along.to_array(), self.tilt);
        let Some(boxes) = BoxRay::new(ray.placed(), ray.direction, ray.doubt()) else {
            return (None, true);
        };
        match &lighting.cuts {
            None => self.nearest_whole(tree, (ray, boxes)),
            Some(cuts) => self.nearest_cut(tree, cuts, (ray, boxes)),
        }
    }

    /// The same among spheres that planes cut.
    fn nearest_cut(
        &self,
        tree: &Tree,
        cuts: &HitCuts<'_>,
        (ray, boxes): (CertifiedRay, BoxRay),
    ) -> (Option<SurfacePoint>, bool) {
        let from = &self.from;
        // What leaves a face leaves what planes keep.
        let kept = match from.is_face && !self.within {
            true => Some(CutRay::beyond(ray)),
            false => {
                let mut planes = PointPlanes::default();
                planes.begin(&cuts.planes, &tree.placement, from, !cuts.cuts.is_spared(from.id));
                CutRay::of_hit(&planes, ray)
            }
        };
        let is_known = kept.is_some();
        let kept = kept.unwrap_or_else(|| CutRay::whole(ray));
        let own = self.within.then(|| kept.leaving(&cuts.planes, from, cuts.cuts.is_cut(from.id)));
        let limit = boxes.limit(own.as_ref().map_or(f64::INFINITY, |own| own.t[1]));
        let first = dispatch(FirstOf { tree, cuts: cuts.cuts, kept: &kept, boxes: &boxes, from, limit });
        let is_first = |high: f64, own: &Leaving| high < own.t[0];
        match (first.best(), own) {
            (Some((ball, hit, [_, high])), own) if own.as_ref().is_none_or(|own| high <= own.t[1]) => {
                let sure = first.found().is_some() && own.is_none_or(|own| is_first(high, &own));
                (Some(kept.point(&cuts.planes, ball, hit)), is_known && sure)
            }
            (_, Some(own)) => (Some(own.point), is_known && own.sure && own.t[1] < first.low()),
            _ => (None, is_known && first.low() == f64::INFINITY),
        }
    }

    /// The same among whole spheres.
    fn nearest_whole(&self, tree: &Tree, (ray, boxes): (CertifiedRay, BoxRay)) -> (Option<SurfacePoint>, bool) {
        let own = self.within.then(|| (OWN, self.from.chord(&ray)));
        let limit = boxes.limit(own.map_or(f64::INFINITY, |(_, bounds)| bounds.high));
        let found =
            dispatch(NearestOf { tree, ray: &ray, boxes: &boxes, from: &self.from, limit, own: Foremost::of(own) });
        let Foremost { best: Some((place, bounds)), rival } = found else {
            return (None, found.rival == f64::INFINITY);
        };
        let sphere = match place {
            OWN => NumberedBall { id: self.from.id, ball: self.from.ball },
            place => NumberedBall { id: tree.ids[place], ball: tree.ball(place) },
        };
        (Some(SurfacePoint::met(&ray, &bounds, sphere)), rival > bounds.high)
    }
}

/// The search for the first hit of one ray among spheres that planes cut, without the one that it starts from.
struct FirstOf<'a> {
    tree: &'a Tree,
    cuts: &'a Cuts,
    kept: &'a CutRay,
    boxes: &'a BoxRay,
    from: &'a SurfacePoint,
    limit: f32,
}

impl Work for FirstOf<'_> {
    type Output = FirstHit;

    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) -> FirstHit {
        let Self { tree, cuts, kept, boxes, from, limit } = self;
        let counts = |place: usize| tree.ball(place) != from.ball;
        let mut search = FirstOfCut { lanes, tree, cuts, kept, boxes, counts, limit, first: FirstHit::default() };
        walk::<false, _>(lanes, tree, boxes, limit, &mut search);
        search.first
    }
}

/// Stands for the place of the sphere that the ray starts from.
const OWN: usize = usize::MAX;

/// The search for the first hit of one ray.
struct NearestOf<'a> {
    tree: &'a Tree,
    ray: &'a CertifiedRay,
    boxes: &'a BoxRay,
    from: &'a SurfacePoint,
    limit: f32,
    /// The hit of the sphere that the ray starts from, if the ray goes through it.
    own: Foremost,
}

impl Work for NearestOf<'_> {
    type Output = Foremost;

    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) -> Foremost {
        let Self { tree, ray, boxes, from, limit, own } = self;
        let counts = |place: usize| tree.ball(place) != from.ball;
        let mut search = NearestSearch { lanes, tree, ray, boxes, counts, limit, foremost: own };
        walk::<false, _>(lanes, tree, boxes, limit, &mut search);
        search.foremost
    }
}
