//! The claims of devices about rays from the hits of a frame (shaders/main/start.wgsl, sky.wgsl) hold in exact
//! arithmetic, for every rounding that WGSL allows, and the terms of the start's error are needed. The twins are only
//! here: the CPU path has f64.

use super::claims::{Case, Checks, check};
use super::given_device::{self, Pair, bounds, weigh};
use super::wild::{Mode, Value, Wild, under};
use crate::certify::TERMS;
use crate::certify::answer::{Answer, Slopes};
use crate::certify::constants::given::GIVEN_STEP;
use crate::certify::constants::{INFLATE, SURFACE, UNIT, WAY};
use crate::cpu::light::tests::families::FAMILIES;
use crate::double_double as dd;
use crate::exact::{Judge, LightQuestion, Toward, Truth};
use crate::number::Number;
use crate::scene::Solid;
use crate::search::tree::Tree;
use crate::search::tree::device::OnGrid;
use crate::search::tree::device_rays::DirectionRecord;
use crate::testing::Rng;
use crate::view::ViewRecord;
use crate::view::ray::dot3;
use glam::DVec3;
use rayon::prelude::*;

/// The constants of a start; a test removes each in turn.
#[derive(Debug, Clone, Copy)]
struct Terms {
    surface: f32,
    way: f32,
    /// Error of the product of normal and direction, in multiples of UNIT.
    cosine: f32,
    /// Factor of the bound of the normal's error.
    turn: f32,
    /// Factor of the bound of the error of the way from the eye.
    doubt: f32,
    /// Error of the way to a light, in multiples of UNIT and of the lengths that it is made of.
    aim: f32,
    given: given_device::Terms,
}

const STARTS: Terms =
    Terms { surface: SURFACE, way: WAY, cosine: 8.0, turn: 1.0, doubt: 1.0, aim: 4.0, given: given_device::TERMS };

/// Least bound of a start's error, relative to the radius.
const BLURRED: f32 = 1.0 / (1u64 << 45) as f32;

/// The error of two places on the grid.
const PLACES: f32 = 1.0 / (1u64 << 47) as f32;

fn to_world<R: Number>(view: &ViewRecord, a: [R; 3]) -> [R; 3] {
    let c = R::from_f32;
    std::array::from_fn(|n| a[0] * c(view.right[n]) + a[1] * c(view.up[n]) + a[2] * c(view.back[n]))
}

/// The start of a pixel's rays.
struct Start<R> {
    normal: [R; 3],
    turn: R,
    steps: [i32; 3],
    offset: [R; 3],
    blur: R,
}

impl<R: Value> Start<R> {
    /// The twin of `keep_start` and `start_of`, for an answer with [`Answer::turn`] above 0.
    fn new(
        terms: &Terms,
        (staged, view): (&Staged<'_>, &ViewRecord),
        depth: f32,
        s: &Slopes<R>,
        a: &Answer<R>,
    ) -> Self {
        let c = R::from_f32;
        let normal = to_world(view, a.normal);
        let less = c((SURFACE - terms.surface) * UNIT);
        let turn = (a.turn - less) * c(terms.turn);
        let depth = c(depth) + c(0.5) * (a.low + a.high);
        let doubt = c(0.5) * a.depth_interval + c(UNIT * terms.way) * depth;
        let along = to_world(view, [s.x, s.y, -R::ONE]);
        let way = along.map(|x| depth * x);
        let spread = s.a.sqrt() * doubt * c(INFLATE) * c(terms.doubt);
        let sphere = &staged.spheres[staged.place];
        let radius = c(sphere.radius);
        let mut start = Self {
            normal,
            turn,
            steps: sphere.steps,
            offset: std::array::from_fn(|n| c(sphere.rest[n]) + radius * normal[n]),
            blur: radius * turn,
        };
        if let Some((unit, (steps, rest))) = staged.eye
            && spread * c(unit) < start.blur
        {
            (start.steps, start.blur) = (steps, spread * c(unit));
            start.offset = std::array::from_fn(|n| c(rest[n]) + c(unit) * way[n]);
        }
        let least = c(BLURRED) * radius;
        let blur = if start.blur < least { least } else { start.blur };
        start.blur = (blur + c(PLACES)) * c(INFLATE);
        start
    }
}

impl<R: Value> Start<R> {
    /// The twin of `next_ray`: a direction, the bound of its relative error, and t of the light that ends the ray, if
    /// one does; `None` where the error is too large.
    fn toward(&self, terms: &Terms, record: &DirectionRecord) -> Option<([R; 3], R, Option<f32>)> {
        let c = R::from_f32;
        let three = |of: [u32; 4]| [0, 1, 2].map(|n| f32::from_bits(of[n]));
        if record.first[3] == 0 {
            return Some((three(record.first).map(c), R::ZERO, None));
        }
        let place = three(record.second).map(c);
        let rest: [R; 3] = std::array::from_fn(|n| place[n] - self.offset[n]);
        let steps = |n: usize| R::from_i32(record.first[n] as i32 - self.steps[n]);
        let way: [R; 3] = std::array::from_fn(|n| steps(n) * c(GIVEN_STEP) + rest[n]);
        let size = |x: [R; 3]| dot3(x, x).sqrt();
        let doubt = c(terms.aim * UNIT) * (size(way) + size(rest) + size(place)) + self.blur;
        let tilt = doubt / size(way) * c(INFLATE);
        let largest = way.iter().fold(0.0f64, |most, x| x.value().abs().max(most));
        let e = dd::exponent(largest);
        let known = doubt < c(1.0 / 4096.0) * size(way);
        let scale = dd::ldexp(1.0, -e) as f32;
        known.then(|| (way.map(|x| x * c(scale)), tilt, Some(1.0 / scale)))
    }
}

/// The spheres of a case as devices have them, and the place of one hit.
struct Staged<'a> {
    spheres: &'a [crate::search::tree::device::PlacedSphereRecord],
    place: usize,
    eye: Option<(f32, OnGrid)>,
}

/// A ray from a hit, with the exact answers about it.
struct Shot {
    record: DirectionRecord,
    /// The other sphere's place.
    other: usize,
    /// Whether the ray goes behind the surface of the hit.
    behind: bool,
    /// Whether the other sphere hides the ray's target, with the ray turned to the side of the normal.
    hidden: bool,
}

/// A ray that passes another sphere near its rim, by about so much of its radius, or anywhere.
fn aim(random: &mut Rng, hit: DVec3, center: DVec3, radius: f64) -> DVec3 {
    let random_vector = |random: &mut Rng| DVec3::from_array(std::array::from_fn(|_| random.between(-1.0, 1.0)));
    let toward = center - hit;
    let distance = toward.length();
    let perpendicular = toward.cross(random_vector(random)).normalize_or_zero();
    if distance <= radius || perpendicular == DVec3::ZERO || random.below(8) == 0 {
        return random_vector(random).normalize();
    }
    let (sine, off) = (radius / distance, random.decade(-7.5, -4.0) * random.sign());
    // The tangent, moved by `off` of the radius across the rim.
    let rim = perpendicular * (1.0 - sine * sine).sqrt() - toward / distance * sine;
    (toward + rim * radius * (1.0 + off)).normalize()
}

/// The number of false claims about some rays of a pixel, and the number of all claims, in the number type R.
fn claims<R: Value>(case: &Case, terms: &Terms, at: [u32; 2], staged: &Staged<'_>, shots: &[Shot]) -> [u32; 2] {
    case.with::<R, _>(&case.binned, &TERMS, |twin| {
        let s = twin.slopes(at[0], at[1]);
        let kept = twin.nearest_two(&s);
        let answer = twin.certify_winner(&s, &kept);
        if !twin.certain(&answer, [kept.low, kept.second]) || answer.turn.value() <= 0.0 {
            return [0; 2];
        }
        let start = Start::new(terms, (staged, &case.view.record), twin.projection.depth, &s, &answer);
        let (mut wrong, mut made) = (0, 0);
        let mut claim = |is_false: bool| (wrong, made) = (wrong + u32::from(is_false), made + 1);
        for shot in shots {
            let Some((mut d, tilt, limit)) = start.toward(terms, &shot.record) else { continue };
            let cosine = dot3(start.normal, d);
            let off = start.turn + tilt + R::from_f32(terms.cosine * UNIT);
            let unsure = off * dot3(d, d).sqrt() * R::from_f32(INFLATE);
            let behind = cosine < R::ZERO;
            if cosine.abs() <= unsure {
                continue;
            }
            claim(behind != shot.behind);
            match (behind, limit) {
                // The sphere of the hit hides a light that is behind it.
                (true, Some(_)) => continue,
                (true, None) => d = d.map(|x| -x),
                (false, _) => {}
            }
            let sphere = &staged.spheres[shot.other];
            let pair = Pair {
                steps: std::array::from_fn(|n| R::from_i32(sphere.steps[n] - start.steps[n])),
                rests: [sphere.rest.map(R::from_f32), start.offset],
                d,
                blur: start.blur,
                tilt,
                radius: R::from_f32(sphere.radius),
            };
            let limit = R::from_f32(limit.unwrap_or(f32::MAX));
            match bounds(&weigh(&pair, &terms.given), &terms.given) {
                None => claim(shot.hidden),
                Some(bounds) if bounds.low >= limit => claim(shot.hidden),
                Some(bounds) if bounds.sure && bounds.high < limit => claim(!shot.hidden),
                Some(_) => {}
            }
        }
        [wrong, made]
    })
}

/// The number of false claims and of all claims, over scenes of a family.
fn false_claims(terms: &Terms, family: usize, scenes: u64) -> [u32; 2] {
    let random = &mut Rng(0x57a2 + family as u64);
    let mut count = [0, 0];
    for n in 0..scenes {
        let (scene, _) = (FAMILIES[family].make)(random);
        let size = [scene.image.height, scene.image.width];
        let pixels: Vec<_> = (0..PIXELS).map(|_| size.map(|n| random.below(n))).collect();
        let Some(case) = Case::new(scene, 1e-5, &pixels, &TERMS) else { continue };
        let spheres = &case.scene.spheres;
        let Some(tree) = Tree::new(&spheres.centers, &spheres.radii) else { continue };
        let judge = Judge::new(&case.scene).expect("a judge");
        let placed = tree.device_spheres();
        let place = |id: u32| tree.ids.iter().position(|own| *own == id).expect("every sphere has a place");
        for judged in &case.judged {
            // What the kernel certifies, whichever way it rounds.
            let certain = case.with::<f32, _>(&case.binned, &TERMS, |twin| check(&case, twin, judged, Checks::ALL));
            let [i, j] = judged.at;
            let Some(hit) = judge.pixel(i, j).filter(|_| certain == Ok(true)) else { continue };
            let staged = Staged { spheres: &placed, place: place(hit.id), eye: tree.eye(&case.view, case.view.unit) };
            let shots = shots(random, &case, (&judge, &tree), judged.at, &hit, &place);
            for mode in Mode::BLIND {
                let of = under(mode, n, || claims::<Wild>(&case, terms, judged.at, &staged, &shots));
                count = [count[0] + of[0], count[1] + of[1]];
            }
        }
    }
    count
}

/// Rays from a hit past the spheres of the scene, with exact answers.
fn shots(
    random: &mut Rng,
    case: &Case,
    (judge, tree): (&Judge, &Tree),
    [i, j]: [u32; 2],
    hit: &Truth,
    place: &dyn Fn(u32) -> usize,
) -> Vec<Shot> {
    let spheres = &case.scene.spheres;
    let own = spheres.ball(hit.id);
    let whole = |ball| Solid { ball, is_cut: false };
    let mut shots = Vec::new();
    for id in (0..spheres.len() as u32).filter(|id| spheres.ball(*id) != own).take(6) {
        let ball = spheres.ball(id);
        let relative = |to: [f64; 3]| DVec3::from_array(to) - DVec3::from_array(own.center);
        let at = DVec3::from_array(hit.normal) * own.radius;
        let direction = aim(random, at, relative(ball.center), ball.radius);
        if !(0.99..1.01).contains(&direction.length()) {
            continue;
        }
        // A light beside the rim, or somewhere along the ray.
        let distance = relative(ball.center).distance(at) * [1.0, random.decade(-2.0, 2.0)][random.below(2) as usize];
        let light = DVec3::from_array(own.center) + at + direction * distance;
        if let Some(record) = DirectionRecord::place(tree, light.to_array()) {
            let toward = Toward::Point(light.to_array());
            let ask = |among| judge.ask(i, j, whole(own), &[LightQuestion::Hidden { toward, turned: false, among }]);
            let (behind, hidden) = (ask(Vec::new()).expect("a hit")[0], ask(vec![whole(ball)]).expect("a hit")[0]);
            shots.push(Shot { record, other: place(id), behind, hidden });
        }
        let exact = direction.as_vec3().to_array();
        let toward = |sign: f64| Toward::Direction(exact.map(|x| sign * f64::from(x)));
        let question = |toward, among: Vec<_>| LightQuestion::Hidden { toward, turned: false, among };
        let behind = judge.ask(i, j, whole(own), &[question(toward(1.0), Vec::new())]).expect("a hit")[0];
        let outward = toward(if behind { -1.0 } else { 1.0 });
        let hidden = judge.ask(i, j, whole(own), &[question(outward, vec![whole(ball)])]).expect("a hit")[0];
        shots.push(Shot { record: DirectionRecord::of_unit(&exact), other: place(id), behind, hidden });
    }
    shots
}

/// Scenes of each family, and pixels of each.
const SCENES: u64 = 40;
const PIXELS: u32 = 12;

fn of_all_families(terms: &Terms) -> Vec<[u32; 2]> {
    (0..FAMILIES.len()).into_par_iter().map(|family| false_claims(terms, family, SCENES)).collect()
}

#[test]
fn no_claim_of_a_ray_from_a_hit_is_false() {
    let all = of_all_families(&STARTS);
    for ([wrong, made], family) in all.iter().zip(FAMILIES) {
        println!("{:24} {made:6} claims, {wrong} wrong", family.name);
        assert_eq!(*wrong, 0, "{}", family.name);
    }
    assert!(all.iter().map(|[_, made]| made).sum::<u32>() > 20_000, "{all:?}");
}

#[test]
fn terms_of_a_start_are_needed() {
    // The tilt of lights is derived only: what it changes at spheres before the light, the blur changes more.
    let each: [(&str, Terms); 3] = [
        ("turn", Terms { turn: 0.0, ..STARTS }),
        ("doubt", Terms { doubt: 0.0, ..STARTS }),
        ("blur", Terms { given: given_device::TERMS.sharp(), ..STARTS }),
    ];
    for (name, terms) in each {
        let wrong = |family: &usize| false_claims(&terms, *family, SCENES)[0] > 0;
        let family = (0..FAMILIES.len()).into_par_iter().find_any(wrong).map(|family| FAMILIES[family].name);
        println!("without {name}: a false claim in {family:?}");
        assert!(family.is_some(), "without {name} no claim is false");
    }
}
