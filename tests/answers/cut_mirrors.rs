//! The promise of mirrors and glass among planes that cut spheres: they show and bend what the planes leave, and a ray inside of cut glass
//! leaves by its face.
//!
//! Gold standard: a ray tracer of this file, which tests every sphere by the rule in f64, without trees and without bounds. First hits come
//! from the judge.

use crate::adapter::renderers;
use crate::cloud::cloud;
use crate::oblique::{self, vfov};
use crate::rng::Rng;
use glam::DVec3;
use halfline::exact::{Judge, Root};
use halfline::frame::Aov;
use halfline::scene::{CUT, CutPlane, Material, Materials, REMOVED, SPARED, Scene, Spheres};
use halfline::settings::Settings;

const SIZE: [u32; 2] = [49, 35];
const EYE: [f64; 3] = [1.0, 2.0, 9.0];

/// The index of the glass.
const INDEX: f64 = 1.5;

/// A colour of a path may lack rays of less weight than 1/512 each, and is rounded to f32.
const CLOSE: f64 = 0.01;

/// A point on a sphere from which rays go on.
#[derive(Debug, Clone, Copy)]
struct Point {
    id: usize,
    place: DVec3,
    /// Against the ray.
    normal: DVec3,
    face: bool,
    /// The ray comes from outside.
    outside: bool,
}

struct World<'a> {
    spheres: &'a Spheres,
    background: DVec3,
    bounces: u32,
    faces: std::cell::Cell<u64>,
}

impl World<'_> {
    fn planes(&self) -> &[CutPlane] {
        self.spheres.cuts.as_ref().map_or(&[], |cuts| &cuts.planes)
    }

    fn flag(&self, id: usize) -> u8 {
        self.spheres.cuts.as_ref().map_or(0, |cuts| cuts.of[id])
    }

    /// The last plane that a ray enters through ahead and the first that it leaves through; `None` where it keeps nothing. A plane `on`
    /// which the ray starts is passed at 0.
    fn part(&self, from: DVec3, along: DVec3, on: Option<usize>) -> Option<[(f64, Option<usize>); 2]> {
        let (mut entry, mut exit) = ((0.0, None), (f64::INFINITY, None));
        for (n, plane) in self.planes().iter().enumerate() {
            let normal = DVec3::from_array(plane.normal);
            let gap = if on == Some(n) { 0.0 } else { plane.distance - normal.dot(from) };
            let across = normal.dot(along);
            match (gap / across, across > 0.0) {
                (t, true) if t < exit.0 => exit = (t, Some(n)),
                (t, false) if t > entry.0 => entry = (t, Some(n)),
                _ => {}
            }
        }
        (entry.0 < exit.0).then_some([entry, exit])
    }

    /// Both roots of a sphere.
    fn roots(&self, id: usize, from: DVec3, along: DVec3) -> Option<[f64; 2]> {
        let away = DVec3::from_array(self.spheres.centers[id]) - from;
        let (b, r) = (away.dot(along), self.spheres.radii[id]);
        let disc = r * r - (away - b * along).length_squared();
        (disc > 0.0).then(|| [b - disc.sqrt(), b + disc.sqrt()])
    }

    fn point(&self, id: usize, place: DVec3, along: DVec3, plane: Option<usize>) -> Point {
        let normal = match plane {
            Some(plane) => DVec3::from_array(self.planes()[plane].normal).normalize(),
            None => (place - DVec3::from_array(self.spheres.centers[id])).normalize(),
        };
        let outside = normal.dot(along) < 0.0;
        Point { id, place, normal: if outside { normal } else { -normal }, face: plane.is_some(), outside }
    }

    /// The first hit of a ray that starts at a point of a sphere, `within` that or not.
    fn next(&self, from: &Point, along: DVec3, within: bool) -> Option<Point> {
        let on = from.face.then(|| {
            let gap = |plane: &CutPlane| {
                let normal = DVec3::from_array(plane.normal);
                (plane.distance - normal.dot(from.place)).abs() / normal.length()
            };
            let gaps = self.planes().iter().map(gap);
            gaps.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(n, _)| n)
        });
        let part = self.part(from.place, along, on);
        let mut best: Option<(f64, f64, usize, Option<usize>)> = None;
        let stays = |id: &usize| self.flag(*id) != REMOVED && (*id != from.id || within);
        for id in (0..self.spheres.len()).filter(stays) {
            let Some([near, far]) = self.roots(id, from.place, along) else { continue };
            let is_cut = self.flag(id) == CUT;
            let hit = match part {
                // From within the sphere itself: by its surface, or by the plane where it ends.
                _ if id == from.id => match part.filter(|_| is_cut) {
                    Some([_, (exit, plane)]) if exit < far => Some((exit, plane)),
                    _ => Some((far, None)),
                },
                _ if !is_cut => (near > 1e-12).then_some((near, None)).or((far > 1e-12).then_some((far, None))),
                Some([(entry, plane), (exit, _)]) => {
                    if entry < near && near < exit && near > 1e-12 {
                        Some((near, None))
                    } else if plane.is_some() && near <= entry && entry < far {
                        Some((entry, plane))
                    } else if plane.is_none() && near <= 1e-12 && far > 1e-12 && far < exit {
                        Some((far, None))
                    } else {
                        None
                    }
                }
                None => None,
            };
            let Some((t, plane)) = hit else { continue };
            // At a face the smaller sphere shows.
            let key = (t, if plane.is_some() { self.spheres.radii[id] } else { f64::INFINITY });
            if best.is_none_or(|best| key.0 < best.0 - 1e-12 || key.0 < best.0 + 1e-12 && key.1 < best.1) {
                best = Some((key.0, key.1, id, plane));
            }
        }
        best.map(|(t, _, id, plane)| self.point(id, from.place + t * along, along, plane))
    }

    /// The light that a point sends back along a ray.
    fn light(&self, point: &Point, along: DVec3, depth: u32, weight: f64) -> DVec3 {
        let own = DVec3::from_array(self.spheres.colors.as_ref().expect("colours")[point.id].map(f64::from));
        let material = self.spheres.materials.as_ref().expect("materials").of(point.id as u32);
        self.faces.set(self.faces.get() + u64::from(point.face && depth > 0));
        let more = |weight: f64| depth < self.bounces && weight >= 1.0 / 512.0;
        let go = |direction: DVec3, within: bool, share: f64| {
            let weight = weight * share;
            if !more(weight) {
                return DVec3::ZERO;
            }
            let next = self.next(point, direction, within);
            share * next.map_or(self.background, |next| self.light(&next, direction, depth + 1, weight))
        };
        let cosine = -along.dot(point.normal);
        let mirrored = along + 2.0 * cosine * point.normal;
        match material {
            Material::Ink => own,
            Material::Metal { .. } => own * go(mirrored, !point.outside, 1.0),
            Material::Glass { index } => {
                let eta = if point.outside { 1.0 / index } else { index };
                let square = 1.0 - eta * eta * (1.0 - cosine * cosine);
                if square < 0.0 {
                    return go(mirrored, !point.outside, 1.0);
                }
                let thin = if eta > 1.0 { square.sqrt() } else { cosine };
                let straight = ((1.0 - eta) / (1.0 + eta)).powi(2);
                let share = straight + (1.0 - straight) * (1.0 - thin).powi(5);
                let bent = (eta * along + (eta * cosine - square.sqrt()) * point.normal).normalize();
                go(mirrored, !point.outside, share) + go(bent, point.outside, 1.0 - share)
            }
            other => panic!("{other:?}"),
        }
    }
}

/// A cloud of ink, mirrors and glass.
fn spheres() -> Spheres {
    let mut all = cloud(0xc17, 60, [0.0; 3], 4.0, 0.9);
    let kinds = vec![Material::Ink, Material::Metal { fuzz: 0.0 }, Material::Glass { index: INDEX }];
    let of: Vec<u32> = (0..all.len() as u32).map(|id| id % 3).collect();
    all.materials = Some(Materials { kinds, of: of.into() });
    all
}

fn through(normal: [f64; 3], point: [f64; 3]) -> CutPlane {
    CutPlane { normal, distance: (0..3).map(|k| normal[k] * point[k]).sum() }
}

/// Without cuts, by planes toward the eye, along the view, in a slab, and drawn, with and without spared spheres.
fn scenes() -> Vec<(&'static str, Scene)> {
    let (mut rng, whole) = (Rng::new(0xc18), spheres());
    let mut all = vec![("whole", vec![])];
    all.push(("toward the eye", vec![through(EYE, [0.0; 3])]));
    all.push(("along the view", vec![through([2.0, -1.0, 0.0], [0.1, 0.0, 0.0])]));
    all.push(("a slab", vec![through(EYE, [0.3, 0.6, 1.2]), through(EYE.map(|x| -x), [0.0; 3])]));
    for _ in 0..3 {
        all.push(("drawn", (0..2).map(|_| through(rng.cube(), rng.cube())).collect()));
    }
    let each = all.into_iter().flat_map(|(name, planes)| [false, true].map(|spares| (name, planes.clone(), spares)));
    let scene = |(name, planes, spares): (&'static str, Vec<CutPlane>, bool)| {
        let mut cut = whole.clone();
        let may: Vec<bool> = (0..cut.len()).map(|n| n % 5 > 1).collect();
        cut.cut(&planes, spares.then_some(&may[..])).expect("planes");
        let mut scene = oblique::scene(SIZE, EYE, [0.0; 3], vfov(38.0), cut);
        scene.lighting.bounces = Some(5);
        (name, scene)
    };
    each.map(scene).collect()
}

#[test]
fn mirrors_and_glass_show_what_planes_leave() {
    let settings = Settings { aovs: vec![Aov::Color], ..Settings::default() };
    let (mut faces, mut cut, mut spared) = (0, 0, 0);
    for (name, scene) in scenes() {
        let judge = Judge::new(&scene).expect("a scene");
        let (bounces, background) = (scene.lighting.bounces.expect("bounces"), scene.image.background);
        let background = DVec3::from_array(background.map(f64::from));
        let world = World { spheres: &scene.spheres, background, bounces, faces: Default::default() };
        let count = |flag: u8| scene.spheres.cuts.as_ref().map_or(0, |cuts| cuts.count(flag));
        (cut, spared) = (cut + count(CUT), spared + count(SPARED));
        for (backend, mut renderer) in renderers() {
            let frame = renderer.render(&scene, &settings).expect("a picture");
            let color = frame.f32(Aov::Color).expect("colours");
            let mut wrong = Vec::new();
            for pixel in 0..frame.ids().len() {
                let Some(truth) = judge.pixel(pixel as u32 / SIZE[0], pixel as u32 % SIZE[0]) else { continue };
                let place = DVec3::from_array(truth.position);
                let along = (place - scene.camera.eye).normalize();
                let (normal, face) = (DVec3::from_array(truth.normal), truth.root == Root::Face);
                let point = Point { id: truth.id as usize, place, normal, face, outside: truth.root != Root::Far };
                let expected = world.light(&point, along, 0, 1.0);
                let found = DVec3::from_array([0, 1, 2].map(|k| f64::from(color[3 * pixel + k])));
                if (found - expected).abs().max_element() > CLOSE {
                    wrong.push(format!("{pixel}: {found} is not {expected} at {point:?}"));
                }
            }
            // Where a ray grazes an edge, f64 without bounds may go the other way.
            assert!(wrong.len() <= 2, "{name} {backend:?}: {} wrong, {:#?}", wrong.len(), &wrong[..wrong.len().min(4)]);
        }
        faces += world.faces.get();
    }
    println!("{faces} faces beyond first hits, {cut} spheres cut and {spared} spared");
    assert!(faces > 2000 && cut > 50 && spared > 50, "{faces} {cut} {spared}");
}
