//! The bounds of given rays in f32, which devices use, hold for every rounding and every order of evaluation that WGSL
//! allows, and their terms are needed. The twin of certify/given.wgsl is only here: the CPU path has f64.

use super::first_order::WHOLE;
use super::tape::{Given, Program, Traced, rewind};
use super::wild::{Mode, Value, Wild, under};
use crate::certify::constants::given::{
    GIVEN_AR2, GIVEN_BLURS, GIVEN_CROSS, GIVEN_GG, GIVEN_POWER, GIVEN_QUOTIENT, GIVEN_STEP, GIVEN_TILTS,
};
use crate::certify::constants::{INFLATE, UNIT, VANISH};
use crate::certify::given::CertifiedRay;
use crate::double_double as dd;
use crate::exact::judge_ray;
use crate::number::{Arithmetic, Number};
use crate::scene::Spheres;
use crate::search::tree::device::{OnGrid, PlacedSphereRecord, on_grid};
use crate::search::tree::{BoxRay, Tree};
use crate::testing::Rng;
use crate::view::placement::PLACED;
use crate::view::ray::{cross3, dot3, positive};
use glam::DVec3;
use rayon::prelude::*;

/// The constants of the bounds; a test removes each in turn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Terms {
    cross: f32,
    blurs: f32,
    ar2: f32,
    gg: f32,
    power: f32,
    quotient: f32,
    tilts: f32,
}

pub(super) const TERMS: Terms = Terms {
    cross: GIVEN_CROSS,
    blurs: GIVEN_BLURS,
    ar2: GIVEN_AR2,
    gg: GIVEN_GG,
    power: GIVEN_POWER,
    quotient: GIVEN_QUOTIENT,
    tilts: GIVEN_TILTS,
};

impl Terms {
    /// The terms without the term of the blur.
    pub(super) fn sharp(self) -> Self {
        Self { blurs: 0.0, ..self }
    }
}

/// Members of [`Terms`] by name.
type Term = (&'static str, fn(&mut Terms) -> &mut f32);
const EACH: [Term; 6] = [
    ("cross", |t| &mut t.cross),
    ("blurs", |t| &mut t.blurs),
    ("ar2", |t| &mut t.ar2),
    ("gg", |t| &mut t.gg),
    ("power", |t| &mut t.power),
    ("quotient", |t| &mut t.quotient),
];

/// A ray as a device certifies it, in the tree's unit; certify/given.wgsl declares it. A ray from a hit has its start there.
struct DeviceRay {
    steps: [i32; 3],
    rest: [f32; 3],
    direction: [f32; 3],
    blur: f32,
}

/// Bound of the error of a difference of two places in each component, beside three roundings of the difference:
/// docs/certificate.md, section 9.
const PLACE: f64 = 8.0 * PLACED;

impl DeviceRay {
    /// The ray from `origin` (in the tree's coordinates) along `direction`. `None` if its boxes leave nothing out, since then f32
    /// decides nothing either.
    fn new(origin: [f64; 3], direction: [f64; 3], boxes: &BoxRay) -> Option<Self> {
        if *boxes == BoxRay::EVERYTHING {
            return None;
        }
        let (steps, rest): OnGrid = on_grid(std::array::from_fn(|n| origin[n] + boxes.start * direction[n]));
        let blur = ((BoxRay::lost(origin) + PLACE) as f32).next_up();
        Some(Self { steps, rest, direction: direction.map(|x| x as f32), blur })
    }
}

/// A ray and a sphere in the numbers of a twin.
pub(super) struct Pair<R> {
    pub(super) steps: [R; 3],
    pub(super) rests: [[R; 3]; 2],
    pub(super) d: [R; 3],
    pub(super) blur: R,
    pub(super) tilt: R,
    pub(super) radius: R,
}

impl<R: Number> Pair<R> {
    fn new(ray: &DeviceRay, s: &PlacedSphereRecord, number: impl Fn(f32) -> R) -> Self {
        Self {
            steps: std::array::from_fn(|n| R::from_i32(s.steps[n] - ray.steps[n])),
            rests: [s.rest, ray.rest].map(|rest| rest.map(R::from_f32)),
            d: ray.direction.map(&number),
            blur: R::from_f32(ray.blur),
            tilt: R::ZERO,
            radius: number(s.radius),
        }
    }
}

/// The numbers by which `intersect` of certify/given.wgsl decides, with bounds of their errors.
pub(super) struct Weighed<R> {
    a: R,
    b: R,
    /// Bound of the error of b and of p x d.
    e: R,
    g: [R; 3],
    disc: R,
    error: R,
    power: R,
    power_error: R,
    /// Relative error of |d|^2 in a quotient, by the direction's tilt.
    tilted: R,
}

pub(super) fn weigh<R: Number>(w: &Pair<R>, terms: &Terms) -> Weighed<R> {
    let c = R::from_f32;
    let d = w.d;
    let p: [R; 3] = std::array::from_fn(|n| w.steps[n] * c(GIVEN_STEP) + (w.rests[0][n] - w.rests[1][n]));
    let (a, b, g, p2) = (dot3(d, d), dot3(p, d), cross3(p, d), dot3(p, p));
    let (g2, r2) = (dot3(g, g), w.radius * w.radius);
    let ar2 = a * r2;
    let far = p2.sqrt();
    let e = ((c(terms.cross * UNIT) + w.tilt) * far + c(terms.blurs) * w.blur) * a.sqrt() * c(INFLATE);
    let disc = ar2 - g2;
    let tilted = c(terms.tilts) * w.tilt;
    let rounded = c(UNIT) * (c(terms.ar2) * ar2 + c(terms.gg) * g2) + tilted * (ar2 + g2);
    let error = ((c(2.0) * g2.sqrt() + e) * e + rounded) * c(INFLATE) + a * c(VANISH);
    let power = p2 - r2;
    let power_error = (c(terms.power * UNIT) * (p2 + r2) + c(2.0 * terms.blurs) * w.blur * (far + w.blur)) * c(INFLATE);
    Weighed { a, b, e, g, disc, error, power, power_error, tilted }
}

/// Bounds of t; `None` for a certain miss.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds<R> {
    pub(super) low: R,
    pub(super) high: R,
    pub(super) sure: bool,
    outside: bool,
}

pub(super) fn bounds<R: Number>(w: &Weighed<R>, terms: &Terms) -> Option<Bounds<R>> {
    let (zero, one) = (R::ZERO, R::ONE);
    let (outside, inside) = (w.power > w.power_error, w.power < -w.power_error);
    if !outside && !inside {
        return Some(Bounds { low: zero, high: R::MISS, sure: false, outside });
    }
    if outside && (w.b < -w.e || w.disc < -w.error) {
        return None;
    }
    let least = positive(w.disc - w.error).sqrt();
    let most = positive(w.disc + w.error).sqrt();
    let quotient = R::from_f32(terms.quotient * UNIT) + w.tilted;
    let (less, more) = (one - quotient, one + quotient);
    if inside && w.b >= zero {
        let low = positive(w.b - w.e + least) / w.a * less;
        return Some(Bounds { low, high: (w.b + w.e + most) / w.a * more, sure: true, outside });
    }
    let (along, size) = if outside { (w.b, w.power) } else { (-w.b, -w.power) };
    let (q, q_most) = (along - w.e + least, along + w.e + most);
    let low = if q_most > zero { (size - w.power_error) / q_most * less } else { zero };
    let high = if q > zero { (size + w.power_error) / q * more } else { R::MISS };
    let sure = q > zero && (inside || (w.disc > w.error && w.b > w.e));
    Some(Bounds { low, high, sure, outside })
}

/// One ray and one sphere, and other spheres that only make the tree's unit larger.
struct Case {
    spheres: Spheres,
    origin: [f64; 3],
    direction: [f64; 3],
}

fn vector(random: &mut Rng) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| random.between(-1.0, 1.0)))
}

const KINDS: usize = 8;

/// A case of family `kind`: tangent but for roundings, from near and far; from points near the surface; from inside; from
/// inside and nearly square to the centre; a small sphere of a large scene; a tiny one from beside it; from very far; from
/// anywhere.
fn case(random: &mut Rng, kind: usize) -> Case {
    let center = vector(random);
    let (out, other) = (vector(random).normalize(), vector(random).normalize());
    let perpendicular = out.cross(other).normalize();
    let small = [1.0, 1e-2, 1e-4][random.bits() as usize % 3];
    let size = [small, small, small, small, 1e-6, 10f64.powf(random.between(-12.0, -8.0)), 1.0, small][kind];
    let radius = random.between(0.1, 0.5) * size;
    let farthest = [0.5, 4.0][random.bits() as usize % 2];
    let away = match kind {
        5 => radius * random.between(0.1, 10.0),
        6 => 10f64.powf(random.between(6.0, 11.0)),
        _ => 10f64.powf(random.between(-2.0, farthest)),
    };
    let (origin, direction) = match kind {
        0 | 4..=6 => {
            let origin = center + out * (radius + away);
            let distance = (origin - center).length();
            let sine = radius / distance;
            let rim = perpendicular * (1.0 - sine * sine).sqrt() + out * sine;
            let off = random.between(-12.0, 12.0) * (1.2e-7 * (distance.min(2.0) + radius) + distance * 2e-15 + 1e-15);
            (origin, center + rim * (radius + off) - origin)
        }
        1 => {
            let height = random.between(-1.0, 1.0) * [1e-7, 1e-6, 1e-5, 1e-3][random.bits() as usize % 4];
            (center + out * radius * (1.0 + height), perpendicular + out * random.between(-1e-3, 1e-3))
        }
        2 => (center + out * radius * 10f64.powf(random.between(-8.0, 0.0)) * 0.999, other),
        3 => (center + out * radius * random.between(0.0, 0.999), perpendicular + out * random.between(-1e-6, 1e-6)),
        _ => (center + other * random.between(0.0, 9.0), vector(random)),
    };
    let mut spheres = Spheres::default();
    spheres.push(center.to_array(), radius, None);
    spheres.push([-1.0; 3], 0.1, None);
    spheres.push([1.0; 3], 0.1, None);
    let scale = 10f64.powf(random.between(-3.0, 3.0));
    Case { spheres, origin: origin.to_array(), direction: (direction * scale).to_array() }
}

/// The records of a case; `None` if its boxes leave nothing to decide.
struct Staged {
    case: Case,
    exact: CertifiedRay,
    ray: DeviceRay,
    start: f64,
    sphere: PlacedSphereRecord,
}

fn staged(random: &mut Rng, kind: usize) -> Option<Staged> {
    let case = case(random, kind);
    let tree = Tree::new(&case.spheres.centers, &case.spheres.radii)?;
    let exact = CertifiedRay::new(&tree.placement, case.origin, case.direction, f64::INFINITY);
    let boxes = BoxRay::new(exact.placed(), exact.direction, 0.0)?;
    let ray = DeviceRay::new(exact.placed(), exact.direction, &boxes)?;
    let place = tree.ids.iter().position(|id| *id == 0)?;
    let sphere = tree.device_spheres()[place];
    Some(Staged { case, exact, ray, start: boxes.start, sphere })
}

/// Compares the bounds with these terms with exact arithmetic: whether a claim is false, and, for a sure hit, the
/// distance of the exact t from the middle of its interval, over half the interval.
fn claim<R: Value>(staged: &Staged, terms: &Terms) -> (bool, f64) {
    let Staged { case, exact, ray, start, sphere } = staged;
    let mut one = Spheres::default();
    one.push(case.spheres.centers[0], case.spheres.radii[0], None);
    let truth = judge_ray(case.origin, case.direction, &one);
    let claim = bounds(&weigh(&Pair::<R>::new(ray, sphere, R::from_f32), terms), terms);
    match (truth, claim) {
        (Some(_), None) => (true, 0.0),
        (None, Some(bounds)) => (bounds.sure, 0.0),
        (None, None) => (false, 0.0),
        (Some(truth), Some(bounds)) => {
            let whole = dd::ldexp(truth.t, -exact.shift);
            // The judge rounds its t, from which the start is taken.
            let (t, rounded) = (whole - start, whole * f64::EPSILON);
            let (low, high) = (bounds.low.value(), bounds.high.value());
            let share = if bounds.sure { (2.0 * t - low - high).abs() / (high - low) } else { 0.0 };
            (low > t + rounded || high < t - rounded, share)
        }
    }
}

const COUNT: usize = 4000;

/// False claims in a family, by roundings to nearest and by the adversary's roundings, and the largest share.
fn false_claims(terms: &Terms, kind: usize, count: usize) -> (usize, f64) {
    let random = &mut Rng(0x91e5 + kind as u64);
    let (mut wrong, mut worst) = (0, 0.0f64);
    for n in 0..count {
        let Some(staged) = staged(random, kind) else { continue };
        let claims = Mode::BLIND.map(|mode| under(mode, n as u64, || claim::<Wild>(&staged, terms)));
        for (is_wrong, share) in claims.into_iter().chain([claim::<f32>(&staged, terms)]) {
            wrong += usize::from(is_wrong);
            worst = worst.max(share);
        }
    }
    (wrong, worst)
}

#[test]
fn no_claim_of_a_device_is_false() {
    let found: Vec<_> = (0..KINDS).into_par_iter().map(|kind| false_claims(&TERMS, kind, COUNT)).collect();
    for (kind, (wrong, worst)) in found.into_iter().enumerate() {
        println!("family {kind}: {COUNT} rays, 6 ways to round, {wrong} wrong, worst error {worst:.3} of its bound");
        assert_eq!(wrong, 0, "family {kind}");
    }
}

/// A bound that is compared with the sum of all roundings.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Check {
    Along,
    Cross,
    DiscMost,
    DiscLeast,
    PowerMost,
    PowerLeast,
    Low,
    High,
}

const CHECKS: [Check; 8] = [
    Check::Along,
    Check::Cross,
    Check::DiscMost,
    Check::DiscLeast,
    Check::PowerMost,
    Check::PowerLeast,
    Check::Low,
    Check::High,
];

/// The relative error of evaluating a bound, which INFLATE covers.
const OWN: f64 = 1.0 / (1u64 << 16) as f64;

/// The part of the blur that is for roundings in the kernel, in multiples of [`PLACED`]: docs/certificate.md, section
/// 9.
const ROUNDED_PLACES: f64 = 5.25;

/// The largest error of a combination of numbers by all roundings, in some order of its sums.
fn worst(given: &Given, order: Option<u64>, number: Traced) -> f64 {
    let mut program = Program::new(given, order.map(Rng));
    let step = program.compute(number);
    f64::from(UNIT) * program.worst([&[(step, 1.0)]])
}

/// The share of a bound that all roundings together use in some order of its sums; NaN if the check does not apply.
fn share(staged: &Staged, terms: &Terms, check: Check, order: Option<u64>) -> f64 {
    rewind();
    let mut pair = Pair::<Traced>::new(&staged.ray, &staged.sphere, Traced::input);
    // The other parts of the blur are no roundings.
    pair.blur = Traced::from_f32((ROUNDED_PLACES * PLACED) as f32);
    let mut given = Given::default();
    pair.d.into_iter().chain([pair.radius]).for_each(|number| given.set(number, 0.5));
    let w = weigh(&pair, terms);
    // The bounds hold whether they are made of the true numbers or of rounded ones.
    given.fix(&[w.e, w.error, w.power_error], &[]);
    // The last sum is counted by the root or the quotient that follows.
    let without_last = |sum: Traced| worst(&given, order, sum) - f64::from(UNIT) * sum.real().abs();
    let room = |error: Traced| error.real() / f64::from(INFLATE) + OWN * error.real();
    let (most, least) = (w.disc + w.error, w.disc - w.error);
    match check {
        Check::Along => worst(&given, order, w.b) / room(w.e),
        Check::Cross => {
            let [x, y, z] = w.g.map(|g| worst(&given, order, g));
            x.hypot(y).hypot(z) / room(w.e)
        }
        Check::DiscMost => without_last(most) / room(w.error),
        Check::DiscLeast => without_last(least) / room(w.error),
        Check::PowerMost => without_last(w.power + w.power_error) / room(w.power_error),
        Check::PowerLeast => without_last(w.power - w.power_error) / room(w.power_error),
        Check::Low | Check::High => {
            // D and the power may lie anywhere within their errors.
            let size = if w.power > Traced::ZERO { w.power } else { -w.power };
            let powers = [size + w.power_error, size - w.power_error];
            given.fix(&[w.disc, w.error, w.e, w.power, w.power_error], &[most, least, powers[0], powers[1]]);
            let taken_apart = quotient(&given, &w, terms, check, order, 0.0);
            given.fix(&[w.b], &[]);
            taken_apart.max(quotient(&given, &w, terms, check, order, w.e.real()))
        }
    }
}

/// The share of the quotient's own bound. p.d lies anywhere within `e`.
fn quotient(given: &Given, w: &Weighed<Traced>, terms: &Terms, check: Check, order: Option<u64>, e: f64) -> f64 {
    let Some(bounds) = bounds(w, terms).filter(|bounds| bounds.sure) else {
        return f64::NAN;
    };
    let (a, b, power, error) = (w.a.real(), w.b.real(), w.power.real(), w.power_error.real());
    let root = |sign: f64| (w.disc.real() + sign * w.error.real()).max(0.0).sqrt();
    let low = check == Check::Low;
    let out = if low { bounds.low } else { bounds.high };
    let sign = if low { 1.0 } else { -1.0 };
    let bound = match bounds.outside || b < 0.0 {
        true => (power.abs() - sign * error) / (b.abs() + sign * e + root(sign)),
        false => (b - sign * e + root(-sign)) / a,
    };
    worst(given, order, out) / (sign * (bound - out.real()))
}

/// The largest share over cases of all families and orders.
fn largest(terms: &Terms, check: Check, kind: usize, count: u32) -> f64 {
    let random = &mut Rng(0x0dde + kind as u64 * 64 + check as u64);
    let mut worst = f64::NAN;
    for _ in 0..count {
        let Some(staged) = staged(random, kind) else { continue };
        let orders = [None; 1].into_iter().chain((0..6).map(|_| Some(random.bits())));
        worst = orders.map(|order| share(&staged, terms, check, order)).fold(worst, f64::max);
    }
    worst
}

/// The largest shares of each check, in each family.
fn largest_of_all(terms: &Terms, count: u32) -> Vec<f64> {
    let pairs = CHECKS.iter().flat_map(|check| (0..KINDS).map(move |kind| (*check, kind)));
    let pairs: Vec<_> = pairs.collect();
    pairs.par_iter().map(|(check, kind)| largest(terms, *check, *kind, count)).collect()
}

#[test]
fn no_roundings_together_leave_a_bound_of_a_device() {
    let shares = largest_of_all(&TERMS, 100);
    for (row, check) in shares.chunks(KINDS).zip(CHECKS) {
        println!("{:10} {row:.3?}", format!("{check:?}"));
        assert!(row.iter().any(|share| share.is_finite()), "{check:?} never applied");
        assert!(row.iter().all(|share| share.is_nan() || *share <= WHOLE), "{check:?}: {row:?}");
    }
}

/// Without a term, or with half of it, a claim is false or all roundings together leave a bound. g.g is left out: wherever
/// its roundings matter, the roundings of g are larger.
#[test]
fn terms_of_a_device_are_needed() {
    for (name, of) in EACH.into_iter().filter(|(name, _)| *name != "gg") {
        // Half of the blur's term is derived only: the parts of a blur do not add up in one case.
        let parts: &[f32] = if name == "blurs" { &[0.0] } else { &[0.0, 0.5] };
        for &part in parts {
            let mut terms = TERMS;
            *of(&mut terms) *= part;
            let wrong: usize = (0..KINDS).into_par_iter().map(|kind| false_claims(&terms, kind, COUNT / 2).0).sum();
            let share = largest_of_all(&terms, 30).into_iter().fold(0.0, f64::max);
            println!("{part} of {name}: {wrong} wrong claims, share {share:.3}");
            assert!(wrong > 0 || share > WHOLE, "{part} of {name} is enough");
        }
    }
}
