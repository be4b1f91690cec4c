//! Hits of viewing rays on spheres, in f64 without bounds: accurate enough for the colours and lines of a picture.

use super::planes::{EyePlane, EyePlanes};
use super::ray::NONE;
use super::records::ViewRecord;
use super::{RayKind, View};
use crate::double_double as dd;
use crate::number::vector::{LANES, vectorized};
use crate::scene::{Ball, Cuts, Spheres};
use glam::DVec3;

/// The distance, in radii, beyond which f64 does not give a sphere's normals to seven digits.
const FARTHEST: f64 = (1u64 << 30) as f64;

/// A normal is off by at most 2^-29 where the discriminant is at least this part of |d|^2 |p|^2: docs/certificate.md,
/// section 10.
const SHARP: f64 = 1.0 / (1u64 << 35) as f64;

/// The part of numbers that may be left of them by rounding where they cancel.
const NOISE: f64 = 1.0 / (1u64 << 40) as f64;

/// The viewing rays of a view.
pub(crate) struct PictureRays<'a> {
    view: &'a View,
    /// The factor from the scene's unit to the frame's, in which squares neither overflow nor vanish.
    scale: f64,
    /// The planes that cut spheres.
    planes: Option<EyePlanes>,
}

/// The hit of a viewing ray on a sphere.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PictureHit {
    /// The direction of the ray, of length 1.
    pub(crate) along: DVec3,
    /// Normal of length 1, against the ray; of no use unless `near`.
    pub(crate) normal: DVec3,
    /// Whether the ray comes from outside of the sphere.
    pub(crate) outside: bool,
    /// Whether the sphere is near enough for its normal to be known.
    pub(crate) near: bool,
    /// Whether the normal is off by at most 2^-29.
    pub(crate) sharp: bool,
    /// Whether the hit is on a plane that cuts the sphere.
    pub(crate) face: bool,
    /// The depth along the view axis, for a curved lens along the ray, in the frame's unit.
    depth: f64,
}

/// The spheres that some pixels show, one array per component. A lane without one has a place of the window, and a sphere of no size.
#[derive(Clone, Copy)]
pub(crate) struct ShownBalls {
    position: [[u32; LANES]; 2],
    ball: [[f64; LANES]; 4],
    /// Whether planes cut them.
    is_cut: [bool; LANES],
}

impl ShownBalls {
    /// The spheres of the pixels from `first` on, at most [`LANES`] of these.
    #[inline(always)]
    pub(crate) fn of_run(record: &ViewRecord, first: u32, ids: &[u32], spheres: &Spheres) -> Self {
        let mut shown = Self { position: record.positions(first), ball: [[0.0; LANES]; 4], is_cut: [false; LANES] };
        for (l, id) in ids.iter().take(LANES).enumerate().filter(|(_, id)| **id != NONE) {
            shown.show(l, spheres, *id);
        }
        shown
    }

    /// The spheres of some pixels of the window, whose `ids` are of all its pixels: at least one of them, at most [`LANES`].
    #[inline(always)]
    pub(crate) fn of_some(record: &ViewRecord, pixels: &[u32], ids: &[u32], spheres: &Spheres) -> Self {
        let mut shown = Self { position: [[0; LANES]; 2], ball: [[0.0; LANES]; 4], is_cut: [false; LANES] };
        for l in 0..LANES {
            // Lanes beyond the last pixel repeat it.
            let pixel = pixels[l.min(pixels.len() - 1)];
            [shown.position[0][l], shown.position[1][l]] = record.position(pixel);
            shown.show(l, spheres, ids[pixel as usize]);
        }
        shown
    }

    #[inline(always)]
    fn show(&mut self, l: usize, spheres: &Spheres, id: u32) {
        let [x, y, z] = spheres.centers[id as usize];
        [self.ball[0][l], self.ball[1][l], self.ball[2][l], self.ball[3][l]] = [x, y, z, spheres.radii[id as usize]];
        self.is_cut[l] = spheres.is_cut(id);
    }

    #[inline(always)]
    fn position(&self, l: usize) -> [u32; 2] {
        [self.position[0][l], self.position[1][l]]
    }

    /// The centre of the sphere of a lane.
    #[inline(always)]
    pub(crate) fn center(&self, l: usize) -> [f64; 3] {
        [self.ball[0][l], self.ball[1][l], self.ball[2][l]]
    }

    /// The radius of the sphere of a lane.
    #[inline(always)]
    pub(crate) fn radius(&self, l: usize) -> f64 {
        self.ball[3][l]
    }
}

/// [`PictureHit`] of some pixels, one array per component; truth values as 1 and 0.
pub(crate) struct PictureHits {
    pub(crate) normal: [[f64; LANES]; 3],
    /// The cosine between the normal and the way back along the ray.
    pub(crate) facing: [f64; LANES],
    pub(crate) outside: [u64; LANES],
    pub(crate) near: [u64; LANES],
    pub(crate) sharp: [u64; LANES],
    pub(crate) face: [bool; LANES],
    depth: [f64; LANES],
}

impl PictureHits {
    #[inline(always)]
    fn set(&mut self, l: usize, hit: PictureHit) {
        (self.normal[0][l], self.normal[1][l], self.normal[2][l]) = (hit.normal.x, hit.normal.y, hit.normal.z);
        self.facing[l] = -hit.along.dot(hit.normal);
        self.depth[l] = hit.depth;
        (self.outside[l], self.near[l], self.sharp[l]) = (hit.outside.into(), hit.near.into(), hit.sharp.into());
        self.face[l] = hit.face;
    }
}

impl<'a> PictureRays<'a> {
    /// The rays of a view to spheres that planes may cut.
    pub(crate) fn new(view: &'a View, cuts: Option<&Cuts>) -> Self {
        Self::among(view, cuts.map(|cuts| EyePlanes::new(cuts, view.basis.e)))
    }

    /// The same with these planes, as its eye sees them.
    pub(crate) fn among(view: &'a View, planes: Option<EyePlanes>) -> Self {
        Self { view, scale: dd::ldexp(1.0, -view.unit), planes }
    }

    /// The hit of this pixel's viewing ray on a sphere. Where the ray passes beside the sphere in f64, the point of the
    /// sphere that is nearest to the ray is the hit.
    #[inline(always)]
    pub(crate) fn hit(&self, pixel: u32, Ball { center, radius }: Ball, is_cut: bool) -> PictureHit {
        let (kind, position) = (self.view.kind(), self.view.record.position(pixel));
        let hit = self.hit_at(kind, position, center, radius);
        if is_cut { self.on_face(kind, position, center, hit) } else { hit }
    }

    /// The hit of a cut sphere, whose hit as a whole one is `hit`: on the plane through which the ray enters what is kept, unless the
    /// sphere comes after that.
    fn on_face(&self, kind: RayKind, position: [u32; 2], center: [f64; 3], hit: PictureHit) -> PictureHit {
        let Some(planes) = &self.planes else { return hit };
        let Meeting { forward, d, from, .. } = self.meeting(kind, position, center, 0.0);
        let mut entry: Option<(f64, usize)> = None;
        for (n, EyePlane { normal, gap, length, .. }) in planes.iter().enumerate() {
            let normal = DVec3::from_array(*normal);
            let (along, away, origin) = (normal.dot(d), gap * self.scale, normal.dot(from));
            // What is left of numbers that cancel is noise.
            let is_known = -along > NOISE * length * d.length() && origin - away > NOISE * (away.abs() + origin.abs());
            let t = (away - origin) / along;
            if is_known && entry.is_none_or(|(last, _)| t > last) {
                entry = Some((t, n));
            }
        }
        match entry {
            Some((t, plane)) if !hit.outside || hit.depth < forward * t => PictureHit {
                normal: DVec3::from_array(planes.normal(plane)),
                outside: true,
                near: true,
                sharp: true,
                face: true,
                depth: forward * t,
                ..hit
            },
            _ => hit,
        }
    }

    /// The hit for a row and a column of the view's frame. It has no branches where `kind`, the kind of the view, is a constant, so that
    /// compilers make vectors of loops over it.
    #[inline(always)]
    pub(crate) fn hit_at(&self, kind: RayKind, position: [u32; 2], center: [f64; 3], radius: f64) -> PictureHit {
        let Meeting { forward, d, p, r, a, p2, disc, far2, outside, t, .. } =
            self.meeting(kind, position, center, radius);
        let outward = (d * t - p).normalize_or(-d);
        PictureHit {
            along: d / a.sqrt(),
            normal: if outside { outward } else { -outward },
            outside,
            near: p2 <= FARTHEST * FARTHEST * r * r,
            sharp: disc >= SHARP * a * far2,
            face: false,
            depth: forward * t,
        }
    }

    /// The hits of pixels on the spheres that they show, in one vector where the view is a perspective one.
    #[inline(always)]
    pub(crate) fn hits(&self, shown: &ShownBalls) -> PictureHits {
        match self.view.kind() {
            RayKind::Perspective => self.hits_by(RayKind::Perspective, shown),
            kind => self.hits_by(kind, shown),
        }
    }

    #[inline(always)]
    fn hits_by(&self, kind: RayKind, shown: &ShownBalls) -> PictureHits {
        let none = [0; LANES];
        let (normal, facing, depth) = ([[0.0; LANES]; 3], [0.0; LANES], [0.0; LANES]);
        let mut hits =
            PictureHits { normal, facing, outside: none, near: none, sharp: none, face: [false; LANES], depth };
        for l in 0..LANES {
            hits.set(l, self.hit_at(kind, shown.position(l), shown.center(l), shown.radius(l)));
        }
        for l in (0..LANES).filter(|l| shown.is_cut[*l]) {
            let hit = self.hit_at(kind, shown.position(l), shown.center(l), shown.radius(l));
            hits.set(l, self.on_face(kind, shown.position(l), shown.center(l), hit));
        }
        hits
    }

    /// Writes the depth of each hit along the view axis, for a curved lens along the ray, in the scene's unit; +inf on a miss. The hits
    /// are in the pixels from `first` on, which show the spheres `ids`.
    pub(crate) fn depths(&self, first: u32, ids: &[u32], spheres: &Spheres, depths: &mut [f64]) {
        match self.view.kind() {
            RayKind::Parallel => vectorized!(self.depths_of(RayKind::Parallel, first, ids, spheres, depths)),
            RayKind::Perspective => vectorized!(self.depths_of(RayKind::Perspective, first, ids, spheres, depths)),
            RayKind::Curved => self.depths_of(RayKind::Curved, first, ids, spheres, depths),
        }
    }

    /// [`PictureRays::depths`], eight pixels at once where `kind` is a constant.
    #[inline(always)]
    fn depths_of(&self, kind: RayKind, first: u32, ids: &[u32], spheres: &Spheres, depths: &mut [f64]) {
        let record = &self.view.record;
        for (n, (ids, depths)) in ids.chunks(LANES).zip(depths.chunks_mut(LANES)).enumerate() {
            let shown = ShownBalls::of_run(record, first + (n * LANES) as u32, ids, spheres);
            self.write_depths(&self.hits_by(kind, &shown), ids, depths);
        }
    }

    /// Writes the depths of hits of pixels that show these spheres as [`PictureRays::depths`] does.
    #[inline(always)]
    pub(crate) fn write_depths(&self, hits: &PictureHits, ids: &[u32], depths: &mut [f64]) {
        let (mut found, unit) = (hits.depth, self.view.unit);
        if let -1022..=1023 = unit {
            // One product; compilers make a vector of it.
            let factor = dd::ldexp(1.0, unit);
            found.iter_mut().for_each(|found| *found *= factor);
        } else {
            found.iter_mut().for_each(|found| *found = dd::ldexp(*found, unit));
        }
        for ((depth, found), id) in depths.iter_mut().zip(found).zip(ids) {
            *depth = if *id == NONE { f64::INFINITY } else { found };
        }
    }

    #[inline(always)]
    fn meeting(&self, kind: RayKind, [i, j]: [u32; 2], center: [f64; 3], radius: f64) -> Meeting {
        let view = self.view;
        let direction = match kind {
            RayKind::Parallel => [0.0, 0.0, -1.0],
            RayKind::Perspective => view.slope_direction(i, j),
            RayKind::Curved => view.direction(i, j),
        };
        let d = view.to_world(direction);
        let mut p = (DVec3::from_array(center) - view.basis.e) * self.scale;
        let (mut lengths2, mut from) = (0.0, DVec3::ZERO);
        if kind == RayKind::Parallel {
            from = view.to_world(view.origin(i, j)) * self.scale;
            (p, lengths2) = (p - from, p.length_squared() + from.length_squared());
        }
        let r = radius * self.scale;
        let (a, b, p2) = (d.length_squared(), p.dot(d), p.length_squared());
        let disc = a * r * r - p.cross(d).length_squared();
        let root = disc.max(0.0).sqrt();
        let outside = p2 > r * r;
        let t = if outside { b - root } else { b + root } / a;
        let forward = if kind == RayKind::Curved { a.sqrt() } else { -direction[2] };
        Meeting { forward, d, from, p, r, a, p2, disc, far2: p2 + r * r + 4.0 * lengths2, outside, t }
    }
}

/// A ray and a sphere in the frame's unit.
struct Meeting {
    /// The direction along the view axis, of a curved lens its length, and in world space.
    forward: f64,
    d: DVec3,
    /// The origin of a parallel ray from the eye.
    from: DVec3,
    /// The centre from the origin, and the radius.
    p: DVec3,
    r: f64,
    /// |d|^2 and |p|^2.
    a: f64,
    p2: f64,
    /// a r^2 - |p x d|^2
    disc: f64,
    /// At least the squares of all lengths that are rounded.
    far2: f64,
    outside: bool,
    t: f64,
}
