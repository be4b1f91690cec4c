//! The judge: decides in exact arithmetic which sphere a ray hits.
//!
//! The numbers of a scene are exact, and so is the question which sphere the ray through a pixel centre hits first.
//! Sums and products of f64 are binary numbers, which big integers represent exactly (`dyadic.rs`). The basis of an
//! oblique camera adds two square roots, over which signs are still decided by squaring (`exact/field.rs`,
//! `exact/decide.rs`). Double-doubles with proven bounds decide the easy cases first (`exact/filter.rs`), and results
//! are rounded from more bits than they have (`exact/answer.rs`).
//!
//! A tangent ray hits. t counts from just above 0: an eye on a surface does not hit it there, but may hit its far side.
//! From inside the far root is the hit. Equal t goes to the lower index.

mod answer;
mod cut;
mod decide;
mod field;
mod filter;
mod ray;
mod secondary;
#[cfg(test)]
mod tests;

use crate::double_double::{self as dd, Dd};
use crate::dyadic::{self, Dyadic};
use crate::number::vector::{LANES, Vector};
use crate::scene::camera::{CentredFrame, CurvedFrame, ExactViewport};
use crate::scene::{Ball, Scene, Solid, Spheres, check_sphere};
pub use answer::Truth;
use answer::{DecidedHit, Path, Place as HitPlace, Quick};
use cut::{Crossing, ExactCuts};
pub use decide::Root;
use decide::{ExactFrame, ExactLens, Meeting, odds};
use filter::{AxesDd, Body, ExactCamera, FilterHit, FilterRay, FilterResult, Screen};
use halfline_ground::error::{Place, Result};
use halfline_ground::parallel;
use ray::RayForms;
pub(crate) use secondary::LightQuestion;
pub use secondary::Toward;
use secondary::{HitOf, HitPoint};
use std::cell::OnceCell;
use std::cmp::Ordering;

/// Bytes per sphere in [`Judge`], without the digits of long numbers.
pub(crate) const BYTES_PER_SPHERE: u64 = (size_of::<Body>() + size_of::<Screen>()) as u64;

/// A scene set up for exact decisions, pixel by pixel, from any number of threads.
///
/// ```
/// use halfline::exact::Judge;
/// # use halfline::{Camera, ImagePlane, Scene, Spheres};
/// # let image = ImagePlane { width: 32, height: 32, ..Default::default() };
/// # let spheres = Spheres { centers: vec![[0.0, 0.0, -3.0]].into(), radii: vec![1.0].into(), ..Spheres::default() };
/// # let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
///
/// let judge = Judge::new(&scene)?;
/// let truth = judge.pixel(16, 16).expect("the middle of the picture shows the sphere");
/// assert_eq!(truth.id, 0);
/// assert!(judge.pixel(0, 0).is_none());
/// # Ok::<(), halfline::Error>(())
/// ```
pub struct Judge {
    bench: Bench,
    lens: JudgedLens,
}

/// The rays of an image.
enum JudgedLens {
    Plane(Box<ExactLens>, CentredFrame),
    Curved(Box<CurvedFrame>),
}

impl Judge {
    /// Sets up camera and spheres: about a microsecond per sphere.
    ///
    /// # Errors
    /// Errors of [`Scene::check`]; [`Error::Limits`](crate::Error::Limits) for an off-centre lens whose frame has more
    /// than 2^20 columns or rows; [`Error::Settings`](crate::Error::Settings) for numbers of a curved lens that give no rays.
    pub fn new(scene: &Scene) -> Result<Self> {
        scene.check()?;
        let size = [scene.image.width, scene.image.height];
        if let Some(curved) = CurvedFrame::new(&scene.camera, size, 1)? {
            let eye = scene.camera.eye.to_array();
            let bench = Bench::new(ExactFrame::world(eye), eye, &scene.spheres);
            return Ok(Self { bench, lens: JudgedLens::Curved(Box::new(curved)) });
        }
        let frame = scene.camera.centred(size, 1, 1)?;
        let viewport = frame.viewport;
        let lens = JudgedLens::Plane(Box::new(ExactLens::of(viewport, frame.size)), frame);
        let mut bench = Bench::new(ExactFrame::of(&scene.camera), scene.camera.eye.to_array(), &scene.spheres);
        if viewport.is_parallel() {
            let k = filter::exponent(&viewport);
            parallel::each(&mut bench.screens, |id, screen| screen.rescale(&bench.bodies[id], k));
        }
        Ok(Self { bench, lens })
    }

    /// The judge of the same spheres for the pixels of a frame with this viewport and size. Rows and columns then refer
    /// to this frame.
    pub(crate) fn in_frame(self, viewport: ExactViewport, size: [u32; 2]) -> Self {
        let frame = CentredFrame { viewport, size, step: 1, shift: [0; 2] };
        Self { lens: JudgedLens::Plane(Box::new(ExactLens::of(viewport, size)), frame), ..self }
    }

    /// The judge of the same spheres for the places of a frame of a curved lens. Rows and columns then refer to this frame.
    pub(crate) fn in_curved_frame(self, frame: CurvedFrame) -> Self {
        Self { lens: JudgedLens::Curved(Box::new(frame)), ..self }
    }

    /// The nearest hit of the ray through the centre of row `i`, column `j`, over all spheres.
    pub fn pixel(&self, i: u32, j: u32) -> Option<Truth> {
        let ids = 0..self.bench.bodies.len() as u32;
        self.with_depth([i, j], self.bench.nearest(&self.ray(i, j)?, ids, f64::INFINITY)?)
    }

    /// [`Self::pixel`] among the spheres with these indices. Indices beyond the scene's are ignored.
    #[inline(always)]
    pub fn among(&self, i: u32, j: u32, candidates: &[u32]) -> Option<Truth> {
        self.with_depth([i, j], self.bench.nearest(&self.ray(i, j)?, candidates.iter().copied(), f64::INFINITY)?)
    }

    /// Whether each of `lights` is hidden from the nearest hit of the ray through the centre of row `i`, column `j`. The
    /// sphere of the hit or another one between hides it; only the parts that planes keep count. `None` where the ray hits nothing. All
    /// numbers are exact, so a ray that grazes its own or another surface is hidden, and no epsilon moves it off its surface.
    pub fn hidden(&self, i: u32, j: u32, lights: &[Toward]) -> Option<Vec<bool>> {
        self.bench.hidden(&self.ray(i, j)?, lights)
    }

    /// t of either root of sphere `id`, ahead or behind, as the unevaluated sum of two f64 (about 106 bits); `None`
    /// when the ray's line misses the sphere or there is no such sphere.
    pub fn t(&self, i: u32, j: u32, id: u32, root: Root) -> Option<[f64; 2]> {
        let t = self.bench.t(&self.ray(i, j)?, id, root)?.to_dd();
        Some([t.hi, t.lo])
    }

    /// (t - t*)/t* where t* is the exact t of that root of sphere `id`: the relative error of an f64 result.
    ///
    /// NaN when the line misses the sphere or `t` is NaN, infinite for an infinite `t`; where t* is 0, 0 for a `t` of
    /// 0 and infinite for any other.
    pub fn relative_error_of_t(&self, i: u32, j: u32, id: u32, root: Root, t: f64) -> f64 {
        let Some(real) = self.ray(i, j).and_then(|ray| self.bench.t(&ray, id, root)) else {
            return f64::NAN;
        };
        if !t.is_finite() {
            return t.abs();
        }
        let error = &Dyadic::of(t) - &real;
        match (error.is_zero(), real.is_zero()) {
            (true, _) => 0.0,
            (_, true) => f64::INFINITY,
            _ => error.over(&real, 64).to_f64(),
        }
    }

    /// l/r - 1 of a sphere, where l is the distance of its centre from the half-line of a perspective camera: negative for a
    /// hit, with an error of about 2^-94 of the centre's distance in radii. Infinity for a sphere that the scene does not have.
    pub fn excess(&self, i: u32, j: u32, id: u32) -> f64 {
        let (Some(body), Some(ray)) = (self.bench.bodies.get(id as usize), self.ray(i, j)) else {
            return f64::INFINITY;
        };
        let FilterRay { dir, a, .. } = ray.quick;
        let (p, r) = (body.p, Dd::from(body.r));
        let l = if dd::dot(dir, p).hi > 0.0 {
            let moment = dd::cross(dir, p);
            dd::dot(moment, moment).sqrt() / a.sqrt()
        } else {
            dd::dot(p, p).sqrt()
        };
        ((l - r) / r).value()
    }

    /// The hit of one sphere by the ray of row `i`, column `j`, as if it were the only one.
    pub(crate) fn hit_of(&self, i: u32, j: u32, Solid { ball, is_cut }: Solid) -> Option<Truth> {
        let (rays, body) = (self.ray(i, j)?, self.bench.body(ball));
        self.with_depth([i, j], self.bench.truth(&rays, &self.bench.hit_body(&rays, (0, is_cut), &body)?)?)
    }

    /// Whether the ray of row `i` and column `j` lies along a plane that cuts spheres, in it or beside it.
    pub(crate) fn is_along(&self, [i, j]: [u32; 2], plane: usize) -> bool {
        self.ray(i, j).is_some_and(|ray| self.bench.is_along(&ray, plane))
    }

    /// The answers to questions about the hit of one sphere by the ray of row `i`, column `j`; `None` where the ray misses
    /// that sphere.
    pub(crate) fn ask(&self, i: u32, j: u32, solid: Solid, questions: &[LightQuestion]) -> Option<Vec<bool>> {
        let (rays, body) = (self.ray(i, j)?, self.bench.body(solid.ball));
        let best = self.bench.hit_body(&rays, (0, solid.is_cut), &body)?;
        let hit = self.bench.hit_point(&rays, &best, solid.is_cut);
        Some(questions.iter().map(|question| question.answer(&hit)).collect())
    }

    /// The ray of row `i` and column `j`; `None` where a curved lens has none.
    #[inline(always)]
    fn ray(&self, i: u32, j: u32) -> Option<RayForms<'_>> {
        let (lens, CentredFrame { viewport, size, step, shift: [left, top] }) = match &self.lens {
            JudgedLens::Plane(lens, frame) => (lens, frame),
            JudgedLens::Curved(frame) => {
                let direction = frame.in_world([i, j]).to_array();
                return (direction != [0.0; 3]).then(|| RayForms::along(direction));
            }
        };
        let (i, j) = (i * step + top, j * step + left);
        let odds = odds(size.map(i64::from), i, j).map(|n| n as f64);
        Some(RayForms::through(lens, [i, j], FilterRay::through(viewport, *size, odds)))
    }

    /// The hit of a ray of row `i` and column `j`, with the depth along the axis of a curved lens.
    #[inline(always)]
    fn with_depth(&self, place: [u32; 2], truth: Truth) -> Option<Truth> {
        Some(match &self.lens {
            JudgedLens::Plane(..) => truth,
            JudgedLens::Curved(frame) => Truth { depth: -frame.direction(place)[2] * truth.t, ..truth },
        })
    }

    /// The hits of one sphere by the rays through these rows and columns, as if it were the only one, where double-double decides all
    /// about them; `None` where it does not, and for rays that are parallel or of a curved lens.
    #[inline(always)]
    pub(crate) fn surely_hit(&self, at: &[[u32; 2]; LANES], id: u32) -> [Option<Truth>; LANES] {
        let body = &self.bench.bodies[id as usize];
        let mut truths = [None; LANES];
        if self.bench.is_cut(id) {
            return truths;
        }
        let JudgedLens::Plane(_, CentredFrame { viewport, size, step, shift: [left, top] }) = &self.lens else {
            return truths;
        };
        if viewport.is_parallel() {
            return truths;
        }
        let mut apart = [Vector([0.0; LANES]); 2];
        for (l, [i, j]) in at.iter().enumerate() {
            let [columns, rows] = odds(size.map(i64::from), i * step + top, j * step + left);
            (apart[0].0[l], apart[1].0[l]) = (columns as f64, rows as f64);
        }
        let ray = FilterRay::through(viewport, *size, apart);
        let (sure, hit) = ray.hit(body);
        let root = decide::root(body.side);
        let quick = Quick::new(root, &self.bench.camera, &ray, true, body, &hit);
        for (l, truth) in truths.iter_mut().enumerate().filter(|(l, _)| sure.0[*l] != 0) {
            *truth = quick.lane(l).truth(DecidedHit { id, root, tangent: false });
        }
        truths
    }
}

/// The nearest hit of any ray: `origin` + t `direction`, both exact, the direction of any length but zero.
///
/// A ray that is not finite or has no direction hits nothing, and an invalid sphere (see [`Scene::check`]) is not hit.
pub fn judge_ray(origin: [f64; 3], direction: [f64; 3], spheres: &Spheres) -> Option<Truth> {
    judge_ray_among(origin, direction, f64::INFINITY, spheres, 0..spheres.len() as u32)
}

/// [`judge_ray`] among the spheres with these indices, in ascending order. `None` unless the exact t is below `limit`.
pub(crate) fn judge_ray_among(
    origin: [f64; 3],
    direction: [f64; 3],
    limit: f64,
    spheres: &Spheres,
    ids: impl Iterator<Item = u32>,
) -> Option<Truth> {
    let finite = origin.iter().chain(&direction).all(|x| x.is_finite());
    if !finite || direction == [0.0; 3] || limit.is_nan() || limit <= 0.0 {
        return None;
    }
    let rays = RayForms::along(direction);
    let near = |id: &u32| {
        let Ball { center, radius } = spheres.ball(*id);
        !rays.quick.misses(&Screen::from(origin, center, radius))
    };
    let ids: Vec<u32> = ids.filter(near).collect();
    let mut few = Spheres::default();
    for Ball { center, radius } in ids.iter().map(|id| spheres.ball(*id)) {
        few.push(center, radius, None);
    }
    few.cuts = spheres.cuts.as_ref().map(|cuts| cuts.chosen(&ids));
    let bench = Bench::new(ExactFrame::world(origin), origin, &few);
    let truth = bench.nearest(&rays, 0..ids.len() as u32, limit)?;
    Some(Truth { id: ids[truth.id as usize], ..truth })
}

/// The power |c - e|^2 - r^2 of the eye with respect to a sphere, times 2^2k, rounded from its exact value. It is zero
/// only where the eye is exactly on the surface; a value that underflows f64 is the smallest normal number with its
/// sign.
pub(crate) fn power(center: [f64; 3], eye: [f64; 3], radius: f64, k: i32) -> Dd {
    let p = dyadic::minus(&dyadic::vector(center), &dyadic::vector(eye));
    let power = decide::power(&p, radius).ldexp(2 * i64::from(k));
    let near = power.to_dd();
    match power.sign() {
        Ordering::Less if near.hi > -f64::MIN_POSITIVE => Dd::from(-f64::MIN_POSITIVE),
        Ordering::Greater if near.hi < f64::MIN_POSITIVE => Dd::from(f64::MIN_POSITIVE),
        _ => near,
    }
}

/// A frame and the spheres in it.
struct Bench {
    frame: ExactFrame,
    camera: ExactCamera,
    bodies: Vec<Body>,
    screens: Vec<Screen>,
    /// The planes that cut some of the spheres.
    cuts: Option<ExactCuts>,
}

/// The nearest hit so far.
struct Best<'a> {
    decided: DecidedHit,
    body: &'a Body,
    hit: FilterHit,
    meeting: OnceCell<Box<Meeting>>,
}

/// The order of hits at the same t: faces come first, of these the smaller sphere, so that nested layers show; then the lower index counts.
fn rank(next: &Best, best: &Best) -> Ordering {
    let key = |best: &Best| if best.decided.root == Root::Face { best.body.ball.radius } else { f64::INFINITY };
    key(next).total_cmp(&key(best)).then(next.decided.id.cmp(&best.decided.id))
}

impl Bench {
    fn new(frame: ExactFrame, eye: [f64; 3], spheres: &Spheres) -> Self {
        let camera = ExactCamera { eye, basis: AxesDd::of(&frame) };
        let make = |id: usize| {
            let ball = Ball { center: spheres.centers[id], radius: spheres.radii[id] };
            let is_removed = spheres.cuts.as_ref().is_some_and(|cuts| cuts.is_removed(id as u32));
            if is_removed || check_sphere(ball.center, ball.radius, Place::default).is_err() {
                return (Body::new(&frame, &camera, Ball { center: eye, radius: 1.0 }), Screen::NEVER);
            }
            let body = Body::new(&frame, &camera, ball);
            let screen = body.screen();
            (body, screen)
        };
        // A sphere takes about a microsecond.
        let all = parallel::blocks(0..spheres.len(), 1 << 6, &|ids, _| ids.map(make).unzip::<_, _, Vec<_>, Vec<_>>());
        let (mut bodies, mut screens) = (Vec::with_capacity(spheres.len()), Vec::with_capacity(spheres.len()));
        all.into_iter().for_each(|(some, their)| {
            bodies.extend(some);
            screens.extend(their);
        });
        Self { frame, camera, bodies, screens, cuts: spheres.cuts.as_ref().map(ExactCuts::of) }
    }

    /// The nearest hit, if its t is below `limit`.
    #[inline(always)]
    fn nearest(&self, rays: &RayForms<'_>, ids: impl Iterator<Item = u32>, limit: f64) -> Option<Truth> {
        let best = self.foremost(rays, ids)?;
        let before = || {
            let (field, ray, limit) = (&self.frame.field, rays.exact(&self.frame), Dyadic::of(limit));
            match self.entry(rays, &best) {
                Some(entry) => entry.is_before(field, &limit),
                None => decide::before(field, ray, self.meeting(rays, &best), best.decided.root, &limit),
            }
        };
        if limit < f64::INFINITY && !before() {
            return None;
        }
        self.truth(rays, &best)
    }

    #[inline(always)]
    fn foremost(&self, rays: &RayForms<'_>, ids: impl Iterator<Item = u32>) -> Option<Best<'_>> {
        let mut best: Option<Best> = None;
        for id in ids {
            if self.screens.get(id as usize).is_none_or(|screen| rays.quick.misses(screen)) {
                continue;
            }
            if let Some(next) = self.hit_body(rays, (id, self.is_cut(id)), &self.bodies[id as usize])
                && best.as_ref().is_none_or(|best| self.beats(rays, &next, best))
            {
                best = Some(next);
            }
        }
        best
    }

    fn body(&self, ball: Ball) -> Body {
        Body::new(&self.frame, &self.camera, ball)
    }

    /// Whether the ray lies along a plane, in it or beside it.
    fn is_along(&self, rays: &RayForms<'_>, plane: usize) -> bool {
        let plane = self.cuts.as_ref().map(|cuts| &cuts.planes[plane]);
        plane.is_some_and(|plane| self.frame.is_along(rays.exact(&self.frame), plane))
    }

    /// The candidate hit of the sphere, which planes may cut, if the ray hits it.
    #[inline(always)]
    fn hit_body<'b>(&self, rays: &RayForms<'_>, (id, is_cut): (u32, bool), body: &'b Body) -> Option<Best<'b>> {
        let best =
            |hit, root| Best { decided: DecidedHit { id, root, tangent: false }, body, hit, meeting: OnceCell::new() };
        match rays.quick.intersect(body) {
            FilterResult::Miss => None,
            // What the filter knows of a whole sphere bounds nothing of a cut one.
            FilterResult::FilterHit(hit, _) | FilterResult::Unsure(hit) if is_cut => {
                let best = best(hit.unknown(), Root::Near);
                let (cuts, meeting) = (self.cuts.as_ref()?, self.meeting(rays, &best));
                let kept = rays.interval(&self.frame, &cuts.planes)?;
                let (root, tangent) = kept.hit(&self.frame.field, rays.exact(&self.frame), meeting)?;
                Some(Best { decided: DecidedHit { id, root, tangent }, ..best })
            }
            FilterResult::FilterHit(hit, root) => Some(best(hit, root)),
            FilterResult::Unsure(hit) => {
                let best = best(hit, Root::Near);
                let (field, meeting) = (&self.frame.field, self.meeting(rays, &best));
                let tangent = meeting.hit(field)?;
                let root = decide::root(meeting.side(field));
                Some(Best { decided: DecidedHit { id, root, tangent }, ..best })
            }
        }
    }

    /// Whether `next` is nearer, or at the same t with a lower index.
    #[inline(always)]
    fn beats(&self, rays: &RayForms<'_>, next: &Best, best: &Best) -> bool {
        let same = next.body.ball == best.body.ball && next.decided.root == best.decided.root;
        let order = if same { Some(Ordering::Equal) } else { next.hit.order(&best.hit) };
        let exact = || self.exact_order(rays, next, best);
        order.unwrap_or_else(exact).then_with(|| rank(next, best)) == Ordering::Less
    }

    /// The exact order of t.
    fn exact_order(&self, rays: &RayForms<'_>, next: &Best, best: &Best) -> Ordering {
        let (field, ray) = (&self.frame.field, || rays.exact(&self.frame));
        match (self.entry(rays, next), self.entry(rays, best)) {
            (Some(_), Some(_)) => Ordering::Equal,
            (Some(entry), None) => entry.order_root(field, ray(), self.meeting(rays, best), best.decided.root),
            (None, Some(entry)) => {
                entry.order_root(field, ray(), self.meeting(rays, next), next.decided.root).reverse()
            }
            (None, None) => {
                let root = |best: &Best| best.decided.root;
                decide::order(field, (self.meeting(rays, next), root(next)), (self.meeting(rays, best), root(best)))
            }
        }
    }

    fn is_cut(&self, id: u32) -> bool {
        self.cuts.as_ref().is_some_and(|cuts| cuts.is_cut(id))
    }

    /// The plane of a hit that is on a face.
    fn entry<'b>(&self, rays: &'b RayForms<'_>, best: &Best) -> Option<&'b Crossing> {
        let cuts = self.cuts.as_ref().filter(|_| best.decided.root == Root::Face)?;
        rays.interval(&self.frame, &cuts.planes)?.entry.as_ref()
    }

    fn hidden(&self, rays: &RayForms<'_>, lights: &[Toward]) -> Option<Vec<bool>> {
        let best = self.foremost(rays, 0..self.bodies.len() as u32)?;
        let hit = self.hit_point(rays, &best, self.is_cut(best.decided.id));
        let is_hidden = |light: &Toward| {
            let light = hit.toward(*light, false);
            let solids = (0..).zip(&self.bodies).zip(&self.screens).filter(|(_, screen)| !screen.is_never());
            let mut solids = solids.map(|((id, body), _)| Solid { ball: body.ball, is_cut: self.is_cut(id) });
            hit.hides_itself(&light) || solids.any(|solid| hit.is_hidden_by(&light, solid))
        };
        Some(lights.iter().map(is_hidden).collect())
    }

    fn hit_point<'b>(&'b self, rays: &'b RayForms<'b>, best: &'b Best, is_cut: bool) -> HitPoint<'b> {
        let (ray, planes) = (rays.exact(&self.frame), self.cuts.as_ref().map_or(&[][..], |cuts| &cuts.planes));
        let own = Solid { ball: best.body.ball, is_cut };
        let (root, meeting) = (best.decided.root, self.meeting(rays, best));
        let hit = HitOf { own, root, meeting, entry: self.entry(rays, best) };
        HitPoint::new(&self.frame, ray, rays.stretch(), planes, hit)
    }

    fn meeting<'b>(&self, rays: &RayForms<'_>, best: &'b Best) -> &'b Meeting {
        best.meeting.get_or_init(|| Box::new(self.intersect(rays, best.body)))
    }

    fn intersect(&self, rays: &RayForms<'_>, body: &Body) -> Meeting {
        self.frame.intersect(rays.exact(&self.frame), body.ball)
    }

    #[inline(always)]
    fn truth(&self, rays: &RayForms<'_>, best: &Best) -> Option<Truth> {
        let Best { decided, body, .. } = *best;
        Quick::new(decided.root, &self.camera, &rays.quick, rays.planar(), body, &best.hit).truth(decided).or_else(
            || {
                let normal = |entry: &Crossing| self.cuts.as_ref().map_or([0.0; 3], |cuts| cuts.normal(entry.plane));
                let place = match self.entry(rays, best) {
                    Some(entry) => HitPlace::Face(entry, normal(entry)),
                    None => HitPlace::Root(self.meeting(rays, best)),
                };
                answer::slow(decided, &self.frame, rays, &place, body.ball.radius)
            },
        )
    }

    /// 128 bits of t: more than a double-double holds.
    fn t(&self, rays: &RayForms<'_>, id: u32, root: Root) -> Option<Dyadic> {
        let meeting = self.intersect(rays, self.bodies.get(id as usize)?);
        Some(Path::new(&self.frame, rays, &meeting, root, 128)?.t())
    }
}
