//! Planes that cut spheres, against a decision in whole numbers that shares nothing with the judge: a plane is passed at a fraction, whose
//! place among the roots of a quadratic follows from the quadratic's sign there.

use super::*;
use crate::scene::CutPlane;
use crate::scene::camera::Lens;

type Whole = [i128; 3];

fn dot(a: Whole, b: Whole) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A fraction k/m with m > 0.
#[derive(Debug, Clone, Copy)]
struct Fraction(i128, i128);

impl Fraction {
    fn of(k: i128, m: i128) -> Self {
        if m < 0 { Self(-k, -m) } else { Self(k, m) }
    }

    fn order(self, other: Self) -> Ordering {
        (self.0 * other.1).cmp(&(other.0 * self.1))
    }
}

/// a t^2 - 2 b t + c of a ray and a ball, which is below 0 inside of it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Quadratic {
    a: i128,
    b: i128,
    c: i128,
}

impl Quadratic {
    fn has_roots(self) -> bool {
        self.b * self.b >= self.a * self.c
    }

    /// The order of a fraction and the smaller or the larger root.
    fn order(self, Fraction(k, m): Fraction, is_far: bool) -> Ordering {
        let sign = (self.a * k * k - 2 * self.b * k * m + self.c * m * m).cmp(&0);
        let side = (k * self.a).cmp(&(self.b * m));
        match (sign, is_far) {
            (Ordering::Less, false) => Ordering::Greater,
            (Ordering::Less, true) => Ordering::Less,
            // A double root is its middle.
            (Ordering::Equal, _) if side == Ordering::Equal => Ordering::Equal,
            (Ordering::Equal, false) => {
                if side == Ordering::Less {
                    Ordering::Equal
                } else {
                    Ordering::Greater
                }
            }
            (Ordering::Equal, true) => {
                if side == Ordering::Greater {
                    Ordering::Equal
                } else {
                    Ordering::Less
                }
            }
            (Ordering::Greater, _) => side,
        }
    }

    fn root(self, is_far: bool) -> f64 {
        let half = ((self.b * self.b - self.a * self.c) as f64).sqrt();
        (self.b as f64 + if is_far { half } else { -half }) / self.a as f64
    }
}

/// A scene in whole numbers.
#[derive(Debug, Clone)]
struct WholeScene {
    balls: Vec<(Whole, i128)>,
    planes: Vec<(Whole, i128)>,
    origin: Whole,
    direction: Whole,
}

/// A hit: the sphere, the root, and the place where that is a fraction.
#[derive(Debug, Clone, Copy)]
struct Found {
    id: usize,
    root: Root,
    t: f64,
}

impl WholeScene {
    fn random(rng: &mut Rng) -> Self {
        let mut small = |most: i128| i128::from(rng.below(2 * most as u32 + 1)) - most;
        let mut vector = |most: i128| [small(most), small(most), small(most)];
        let balls: Vec<Whole> = (0..12).map(|_| vector(5)).collect();
        let normals: Vec<Whole> = (0..3).map(|_| vector(2)).collect();
        let (origin, direction) = (vector(6), vector(3));
        let mut distance = || small(8) + 2;
        let planes = normals.into_iter().filter(|n| *n != [0; 3]).map(|n| (n, distance())).collect();
        let direction = if direction == [0; 3] { [0, 0, 1] } else { direction };
        let mut balls: Vec<(Whole, i128)> = balls.into_iter().map(|c| (c, i128::from(rng.below(6)) + 1)).collect();
        // Equal ones, and concentric ones.
        balls.push(balls[0]);
        balls.push((balls[1].0, balls[1].1 + 1));
        Self { balls, planes, origin, direction }
    }

    /// Whether each ball is removed, and whether it is cut.
    fn sides(&self) -> Vec<(bool, bool)> {
        let side = |(c, r): &(Whole, i128)| {
            let each = self.planes.iter().map(|(n, d)| {
                let (beyond, reach2) = (dot(*n, *c) - d, r * r * dot(*n, *n));
                (beyond >= 0 && beyond * beyond >= reach2, !(beyond <= 0 && beyond * beyond >= reach2))
            });
            each.fold((false, false), |(removed, cut), (r, c)| (removed || r, cut || c))
        };
        self.balls.iter().map(side).collect()
    }

    /// The first hit, by the rule of docs; `None` for none, `Err` where two roots are too near to each other to tell.
    fn first(&self) -> Result<Option<Found>, ()> {
        let Self { balls, planes, origin, direction } = self;
        let zero = Fraction(0, 1);
        let (mut entry, mut exit, mut is_empty): (Option<Fraction>, Option<Fraction>, bool) = (None, None, false);
        for (n, d) in planes {
            let (k, m) = (d - dot(*n, *origin), dot(*n, *direction));
            if m == 0 {
                is_empty |= k < 0;
                continue;
            }
            let t = Fraction::of(k, m);
            if m < 0 && t.order(zero) == Ordering::Greater && entry.is_none_or(|e| t.order(e) == Ordering::Greater) {
                entry = Some(t);
            }
            if m > 0 && exit.is_none_or(|e| t.order(e) == Ordering::Less) {
                exit = Some(t);
            }
        }
        let start = entry.unwrap_or(zero);
        is_empty |= exit.is_some_and(|exit| start.order(exit) != Ordering::Less);
        let mut all: Vec<(Found, i128)> = Vec::new();
        let quadratic = |(c, r): &(Whole, i128)| {
            let p = [0, 1, 2].map(|n| c[n] - origin[n]);
            Quadratic { a: dot(*direction, *direction), b: dot(p, *direction), c: dot(p, p) - r * r }
        };
        let quadratics: Vec<Quadratic> = balls.iter().map(quadratic).collect();
        for (id, ((_, r), (removed, cut))) in balls.iter().zip(self.sides()).enumerate() {
            let q = quadratics[id];
            if removed || !q.has_roots() {
                continue;
            }
            let before_exit = |is_far| exit.is_none_or(|exit| q.order(exit, is_far) == Ordering::Greater);
            let behind = |t: Fraction, is_far| q.order(t, is_far) == Ordering::Less;
            let root = match (cut, entry) {
                (false, _) if behind(zero, false) => Some(Root::Near),
                (false, _) => behind(zero, true).then_some(Root::Far),
                _ if is_empty => None,
                (true, _) if behind(start, false) => before_exit(false).then_some(Root::Near),
                (true, Some(_)) => behind(start, true).then_some(Root::Face),
                (true, None) => (behind(zero, true) && before_exit(true)).then_some(Root::Far),
            };
            if let Some(root) = root {
                let t = if root == Root::Face { start.0 as f64 / start.1 as f64 } else { q.root(root == Root::Far) };
                all.push((Found { id, root, t }, *r));
            }
        }
        let mut best: Option<(Found, i128)> = None;
        for (next, r) in all {
            let Some((old, radius)) = best else {
                best = Some((next, r));
                continue;
            };
            let same =
                balls[next.id] == balls[old.id] && next.root == old.root || [next.root, old.root] == [Root::Face; 2];
            // The place of a face among the roots of the other sphere is exact.
            let of_face = |root: &Found| quadratics[root.id].order(start, root.root == Root::Far);
            let order = match (next.t - old.t).abs() < 1e-9 * next.t {
                _ if next.root == Root::Face && old.root != Root::Face => of_face(&old).then(Ordering::Less),
                _ if next.root != Root::Face && old.root == Root::Face => {
                    of_face(&next).reverse().then(Ordering::Greater)
                }
                true if same => Ordering::Equal,
                true => return Err(()),
                false => next.t.total_cmp(&old.t),
            };
            let smaller =
                if next.root == Root::Face && old.root == Root::Face { r.cmp(&radius) } else { Ordering::Equal };
            // Ids rise.
            if order.then(smaller) == Ordering::Less {
                best = Some((next, r));
            }
        }
        Ok(best.map(|(found, _)| found))
    }

    fn spheres(&self) -> (Spheres, Vec<bool>) {
        let mut spheres = Spheres::default();
        for (c, r) in &self.balls {
            spheres.push(c.map(|x| x as f64), *r as f64, None);
        }
        let plane = |(n, d): &(Whole, i128)| CutPlane { normal: n.map(|x| x as f64), distance: *d as f64 };
        let planes: Vec<CutPlane> = self.planes.iter().map(plane).collect();
        let stays = spheres.cut(&planes, None).expect("planes");
        (spheres, stays)
    }

    /// The index of each sphere that stays.
    fn places(stays: &[bool]) -> Vec<usize> {
        stays.iter().enumerate().filter(|(_, stays)| **stays).map(|(n, _)| n).collect()
    }
}

#[test]
fn first_hits_of_cut_balls_are_those_of_whole_numbers() {
    let mut rng = Rng(0xc07);
    let (mut roots, mut misses, mut unsure) = ([0; 3], 0, 0);
    for n in 0..60_000 {
        let scene = WholeScene::random(&mut rng);
        let (spheres, stays) = scene.spheres();
        let sides = scene.sides();
        for (id, (removed, _)) in sides.iter().enumerate() {
            assert_eq!(stays[id], !removed, "{scene:?}, sphere {id}");
        }
        let places = WholeScene::places(&stays);
        for (id, place) in (0..).zip(&places) {
            assert_eq!(spheres.is_cut(id), sides[*place].1, "{scene:?}, sphere {place}");
        }
        let Ok(expected) = scene.first() else {
            unsure += 1;
            continue;
        };
        let [origin, direction] = [scene.origin, scene.direction].map(|x| x.map(|x| x as f64));
        let found = judge_ray(origin, direction, &spheres);
        match (expected, found) {
            (None, None) => misses += 1,
            (Some(expected), Some(truth)) => {
                let id = places[truth.id as usize];
                assert_eq!((id, truth.root), (expected.id, expected.root), "{n}: {scene:?}");
                assert!((truth.t - expected.t).abs() <= 1e-14 * expected.t, "{n}: {scene:?}");
                roots[match truth.root {
                    Root::Near => 0,
                    Root::Far => 1,
                    Root::Face => 2,
                }] += 1;
                let length = (dot(scene.direction, scene.direction) as f64).sqrt();
                assert!((truth.distance - truth.t * length).abs() <= 1e-14 * truth.distance);
                let place: [f64; 3] = std::array::from_fn(|k| origin[k] + truth.t * direction[k]);
                assert!((0..3).all(|k| (place[k] - truth.position[k]).abs() < 1e-12), "{n}: {scene:?}");
                let along: f64 = (0..3).map(|k| truth.normal[k] * direction[k]).sum();
                assert!(along <= 0.0, "{n}: the normal is against the ray: {scene:?}");
                if truth.root == Root::Face {
                    let on = |(normal, d): &(Whole, i128)| {
                        let length = (dot(*normal, *normal) as f64).sqrt();
                        (0..3).all(|k| (truth.normal[k] * length - normal[k] as f64).abs() < 1e-14 * length)
                            && (0..3).map(|k| normal[k] as f64 * place[k]).sum::<f64>() - *d as f64 <= 1e-9
                    };
                    assert!(scene.planes.iter().any(on), "{n}: {scene:?}");
                }
            }
            (expected, found) => panic!("{n}: {expected:?} is not {found:?}: {scene:?}"),
        }
        // A limit just behind and before the hit.
        if let Some(truth) = found {
            let all = || 0..spheres.len() as u32;
            let within = |limit: f64| judge_ray_among(origin, direction, limit, &spheres, all()).is_some();
            assert!(within(truth.t * (1.0 + 1e-12)) && !within(truth.t * (1.0 - 1e-12)), "{n}: {scene:?}");
        }
    }
    println!("near, far, face: {roots:?}; misses: {misses}; not decided by f64: {unsure}");
    assert!(roots.iter().all(|count| *count > 300) && misses > 300 && unsure < 1000, "{roots:?} {misses} {unsure}");
}

/// Oblique and parallel cameras whose rays are whole numbers agree with given rays.
#[test]
fn pixels_of_cut_balls_are_those_of_given_rays() {
    let mut rng = Rng(0xc17);
    let mut counts = [0; 2];
    for n in 0..300 {
        let scene = WholeScene::random(&mut rng);
        let (spheres, _) = scene.spheres();
        let eye = scene.origin.map(|x| x as f64);
        // Right is (4, -3, 0)/5 and up z, so that alpha and beta are 5.
        let look = Look::View([3.0, 4.0, 0.0].into());
        for lens in [Lens::Orthographic { height: 15.0 }, Lens::Viewport { vw: 3.0, vh: 3.0, distance: 5.0 }] {
            let camera = Camera { eye: eye.into(), look, up: [0.0, 0.0, 1.0].into(), lens };
            let image = ImagePlane { width: 3, height: 3, ..ImagePlane::default() };
            let judge = Judge::new(&Scene { camera, image, spheres: spheres.clone(), lighting: Default::default() });
            let judge = judge.expect("a scene");
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let (u, v) = (f64::from(j) - 1.0, 1.0 - f64::from(i));
                let [right, up] = [[0.8, -0.6, 0.0], [0.0, 0.0, 1.0]];
                let (origin, direction) = match lens {
                    // Five units between pixels: whole numbers.
                    Lens::Orthographic { .. } => {
                        ([eye[0] + 4.0 * u, eye[1] - 3.0 * u, eye[2] + 5.0 * v], [3.0, 4.0, 0.0])
                    }
                    // Times 5.
                    _ => (
                        eye,
                        std::array::from_fn(|k| {
                            let ahead = [15.0, 20.0, 0.0][k];
                            (5.0 * (u * right[k] + v * up[k])).round() + ahead
                        }),
                    ),
                };
                let [own, given] = [judge.pixel(i, j), judge_ray(origin, direction, &spheres)];
                let brief = |truth: &Truth| (truth.id, truth.root, truth.tangent);
                assert_eq!(own.as_ref().map(brief), given.as_ref().map(brief), "{n}: {scene:?}, {lens:?} {i} {j}");
                if let (Some(own), Some(given)) = (own, given) {
                    assert!((own.distance - given.distance).abs() <= 1e-14 * given.distance, "{n}: {scene:?}");
                    assert!((0..3).all(|k| (own.normal[k] - given.normal[k]).abs() < 1e-14));
                    counts[usize::from(own.root == Root::Face)] += 1;
                }
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 100), "{counts:?}");
}
