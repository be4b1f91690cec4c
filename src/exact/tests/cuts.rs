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
    /// The balls that no plane may cut.
    spared: Vec<bool>,
    planes: Vec<(Whole, i128)>,
    origin: Whole,
    direction: Whole,
}

/// The part of a ray that planes keep.
#[derive(Debug, Clone, Copy)]
struct Interval {
    entry: Option<Fraction>,
    exit: Option<Fraction>,
    is_empty: bool,
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
        let spared = balls.iter().map(|_| rng.below(5) == 0).collect();
        Self { balls, spared, planes, origin, direction }
    }

    /// Whether each ball is removed, and whether it is cut.
    fn sides(&self) -> Vec<(bool, bool)> {
        let side = |((c, r), is_spared): (&(Whole, i128), &bool)| {
            let each = self.planes.iter().map(|(n, d)| {
                let (beyond, reach2) = (dot(*n, *c) - d, r * r * dot(*n, *n));
                (beyond >= 0 && beyond * beyond >= reach2, !(beyond <= 0 && beyond * beyond >= reach2))
            });
            let all = each.fold((false, false), |(removed, cut), (r, c)| (removed || r, cut || c));
            if *is_spared { (false, false) } else { all }
        };
        self.balls.iter().zip(&self.spared).map(side).collect()
    }

    /// The part of the ray that planes keep.
    fn interval(&self) -> Interval {
        let Self { planes, origin, direction, .. } = self;
        let zero = Fraction(0, 1);
        let mut kept = Interval { entry: None, exit: None, is_empty: false };
        for (n, d) in planes {
            let (k, m) = (d - dot(*n, *origin), dot(*n, *direction));
            if m == 0 {
                kept.is_empty |= k < 0;
                continue;
            }
            let t = Fraction::of(k, m);
            let is_ahead = t.order(zero) == Ordering::Greater;
            if m < 0 && is_ahead && kept.entry.is_none_or(|e| t.order(e) == Ordering::Greater) {
                kept.entry = Some(t);
            }
            if m > 0 && kept.exit.is_none_or(|e| t.order(e) == Ordering::Less) {
                kept.exit = Some(t);
            }
        }
        let start = kept.entry.unwrap_or(zero);
        kept.is_empty |= kept.exit.is_some_and(|exit| start.order(exit) != Ordering::Less);
        kept
    }

    fn quadratic(&self, id: usize) -> Quadratic {
        let (c, r) = self.balls[id];
        let p = [0, 1, 2].map(|n| c[n] - self.origin[n]);
        Quadratic { a: dot(self.direction, self.direction), b: dot(p, self.direction), c: dot(p, p) - r * r }
    }

    /// The place at which the ray hits a ball, which planes cut or not.
    fn root(&self, id: usize, is_cut: bool, Interval { entry, exit, is_empty }: Interval) -> Option<Root> {
        let (q, zero) = (self.quadratic(id), Fraction(0, 1));
        if !q.has_roots() {
            return None;
        }
        let before_exit = |is_far| exit.is_none_or(|exit| q.order(exit, is_far) == Ordering::Greater);
        let behind = |t: Fraction, is_far| q.order(t, is_far) == Ordering::Less;
        let start = entry.unwrap_or(zero);
        match (is_cut, entry) {
            (false, _) if behind(zero, false) => Some(Root::Near),
            (false, _) => behind(zero, true).then_some(Root::Far),
            _ if is_empty => None,
            (true, _) if behind(start, false) => before_exit(false).then_some(Root::Near),
            (true, Some(_)) => behind(start, true).then_some(Root::Face),
            (true, None) => (behind(zero, true) && before_exit(true)).then_some(Root::Far),
        }
    }

    /// The first hit, by the rule of docs; `None` for none, `Err` where two roots are too near to each other to tell.
    fn first(&self) -> Result<Option<Found>, ()> {
        let Self { balls, .. } = self;
        let kept = self.interval();
        let start = kept.entry.unwrap_or(Fraction(0, 1));
        let mut all: Vec<(Found, i128)> = Vec::new();
        let quadratics: Vec<Quadratic> = (0..balls.len()).map(|id| self.quadratic(id)).collect();
        for (id, ((_, r), (removed, cut))) in balls.iter().zip(self.sides()).enumerate() {
            if removed {
                continue;
            }
            if let Some(root) = self.root(id, cut, kept) {
                let far = quadratics[id].root(root == Root::Far);
                let t = if root == Root::Face { start.0 as f64 / start.1 as f64 } else { far };
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

    fn spheres(&self) -> Spheres {
        let mut spheres = Spheres::default();
        for (c, r) in &self.balls {
            spheres.push(c.map(|x| x as f64), *r as f64, None);
        }
        let plane = |(n, d): &(Whole, i128)| CutPlane { normal: n.map(|x| x as f64), distance: *d as f64 };
        let planes: Vec<CutPlane> = self.planes.iter().map(plane).collect();
        let may: Vec<bool> = self.spared.iter().map(|spared| !spared).collect();
        spheres.cut(&planes, Some(&may)).expect("planes");
        spheres
    }
}

#[test]
fn first_hits_of_cut_balls_are_those_of_whole_numbers() {
    let mut rng = Rng(0xc07);
    let (mut roots, mut misses, mut unsure) = ([0; 3], 0, 0);
    for n in 0..60_000 {
        let scene = WholeScene::random(&mut rng);
        let (spheres, sides) = (scene.spheres(), scene.sides());
        for (id, (removed, cut)) in (0..).zip(sides) {
            let is_removed = spheres.cuts.as_ref().is_some_and(|cuts| cuts.is_removed(id));
            assert_eq!((is_removed, spheres.is_cut(id)), (removed, cut && !removed), "{scene:?}, sphere {id}");
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
                assert_eq!((truth.id as usize, truth.root), (expected.id, expected.root), "{n}: {scene:?}");
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
                // Normals are rounded: of a tangent ray the product is 0.
                assert!(along <= 4.0 * f64::EPSILON * length, "{n}: the normal is against the ray: {scene:?}");
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
        let spheres = scene.spheres();
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

/// The root of a whole number, if that is one.
fn whole_root(x: i128) -> Option<i128> {
    let root = (x as f64).sqrt().round() as i128;
    (root * root == x).then_some(root)
}

impl WholeScene {
    /// The scene m times as large, seen from its hit m (origin + k/m direction) along a direction.
    fn at_hit(&self, Fraction(k, m): Fraction, toward: impl FnOnce(Whole) -> Whole) -> Self {
        let origin = [0, 1, 2].map(|n| m * self.origin[n] + k * self.direction[n]);
        Self {
            balls: self.balls.iter().map(|(c, r)| (c.map(|x| m * x), m * r)).collect(),
            planes: self.planes.iter().map(|(n, d)| (*n, m * d)).collect(),
            origin,
            direction: toward(origin),
            spared: self.spared.clone(),
        }
    }

    /// Whether a light is hidden from a hit of sphere `own`, where the ray begins: before its end at t = 1 or without one.
    fn is_hidden(&self, own: Found, plane: Option<Whole>, sides: &[(bool, bool)], is_endless: bool) -> bool {
        let (kept, one) = (self.interval(), Fraction(1, 1));
        if self.direction == [0; 3] {
            return false;
        }
        let of_surface = |is_cut: bool| {
            let q = self.quadratic(own.id);
            match own.root {
                Root::Near => q.b >= 0,
                Root::Face => dot(plane.expect("a face"), self.direction) <= 0,
                // The hit is on the wall, which a ray outward passes at once, and one inward at 2 b/a.
                Root::Far => {
                    let wall = Fraction((2 * q.b).max(0), q.a);
                    let ends = |end: Fraction| wall.order(end) == Ordering::Less;
                    (is_endless || ends(one)) && (!is_cut || kept.exit.is_none_or(ends))
                }
            }
        };
        let hides = |id: usize| {
            let (removed, cut) = sides[id];
            if removed {
                return false;
            }
            if self.balls[id] == self.balls[own.id] && (own.root != Root::Face || cut) {
                return of_surface(cut);
            }
            let q = self.quadratic(id);
            self.root(id, cut, kept).is_some_and(|root| {
                let place = |end: Fraction| match root {
                    Root::Face => kept.entry.expect("a face").order(end).reverse(),
                    root => q.order(end, root == Root::Far),
                };
                is_endless || place(one) == Ordering::Greater
            })
        };
        of_surface(sides[own.id].1) || (0..self.balls.len()).filter(|id| *id != own.id).any(hides)
    }
}

/// Lights from hits whose places are fractions, on faces and on spheres, spared ones beyond planes among them.
#[test]
fn lights_from_hits_among_cut_balls_are_those_of_whole_numbers() {
    let mut rng = Rng(0xc27);
    let (mut counts, mut beyond) = ([[0; 2]; 3], 0);
    for n in 0..60_000 {
        let scene = WholeScene::random(&mut rng);
        let (spheres, sides) = (scene.spheres(), scene.sides());
        let Ok(Some(found)) = scene.first() else { continue };
        let (q, kept) = (scene.quadratic(found.id), scene.interval());
        let at = match (found.root, whole_root(q.b * q.b - q.a * q.c)) {
            (Root::Face, _) => kept.entry.expect("a face"),
            (Root::Near, Some(root)) => Fraction(q.b - root, q.a),
            (Root::Far, Some(root)) => Fraction(q.b + root, q.a),
            _ => continue,
        };
        let mut small = |most: i128| i128::from(rng.below(2 * most as u32 + 1)) - most;
        let lights: Vec<Whole> = (0..6).map(|n| [0; 3].map(|_| small(if n < 3 { 2 } else { 7 }))).collect();
        let plane = scene.planes.iter().map(|(n, _)| *n).zip(&scene.planes).find(|(normal, (_, d))| {
            let (k, m) = (d - dot(*normal, scene.origin), dot(*normal, scene.direction));
            found.root == Root::Face && m < 0 && Fraction::of(k, m).order(at) == Ordering::Equal
        });
        let plane = plane.map(|(normal, _)| normal);
        let toward: Vec<Toward> = (0..)
            .zip(&lights)
            .filter(|(_, light)| **light != [0; 3])
            .map(|(n, light)| match light.map(|x| x as f64) {
                light if n < 3 => Toward::Direction(light),
                light => Toward::Point(light),
            })
            .collect();
        let expected: Vec<bool> = (0..)
            .zip(&lights)
            .filter(|(_, light)| **light != [0; 3])
            .map(|(n, light)| {
                let Fraction(_, m) = at;
                let to = |origin: Whole| [0, 1, 2].map(|k| if n < 3 { light[k] } else { m * light[k] - origin[k] });
                scene.at_hit(at, to).is_hidden(found, plane, &sides, n < 3)
            })
            .collect();
        let [origin, direction] = [scene.origin, scene.direction].map(|x| x.map(|x| x as f64));
        let bench = Bench::new(ExactFrame::world(origin), origin, &spheres);
        let rays = RayForms::along(direction);
        let nearest = bench.nearest(&rays, 0..spheres.len() as u32, f64::INFINITY);
        assert_eq!(nearest.expect("a hit").id as usize, found.id);
        assert_eq!(
            bench.hidden(&rays, &toward).expect("a hit"),
            expected,
            "{n}: {found:?} at {at:?} of {scene:?}, {toward:?}"
        );
        for hidden in expected {
            counts[found.root as usize][usize::from(hidden)] += 1;
        }
        let removes = |(normal, d): &(Whole, i128)| {
            let Fraction(k, m) = at;
            (0..3).map(|n| normal[n] * (m * scene.origin[n] + k * scene.direction[n])).sum::<i128>() > m * d
        };
        beyond += u32::from(scene.planes.iter().any(removes));
    }
    println!("near, far, face: open and hidden: {counts:?}; hits beyond planes: {beyond}");
    assert!(counts.iter().flatten().all(|count| *count > 300) && beyond > 300, "{counts:?} {beyond}");
}
